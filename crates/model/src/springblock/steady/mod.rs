//! Equilibrium with every contact block sliding.
//!
//! Linear elasticity makes the normal forces N an affine function of the friction forces T on the contact blocks,
//! positive against sliding. The bulk's height balances the load. With the area factor f, steady sliding is the fixed
//! point of
//!
//! ```text
//! T = mu_d f(p(N(T))) max(N(T), 0)
//! ```
//!
//! The stiffness matrix, its factorization and the response to the bulk depend on the geometry only: one
//! [`SteadyModel`] serves every pressure and every set of coefficients. Lengths are in lattice spacings l, stiffnesses
//! in the spring stiffness k, pressures in the nominal pressure. Only f needs pascals, so that pressures do not depend
//! on Young's modulus.
//!
//! The fixed point is computed by Anderson-accelerated iteration ([`anderson`]). The plain iteration reduces the error
//! by the friction coefficient times a coupling of order 0.3, so that 6 to 12 iterations reach rounding for
//! coefficients below 1. If lands tilt or the law falls steeply the iteration may not converge; then Newton's method
//! ([`newton`]) continues from the best state. If that fails too, the best state is returned as not converged.
//!
//! N(T) is computed by a band factorization of all blocks ([`system`]) or, for cells of equal columns, from the
//! closed-form response of the flat layer and the few forces around the cavity ([`condensed`]), which gives the same
//! result to rounding in a twentieth of the time. A face with height variations is in partial contact: [`raised`].

mod anderson;
mod band;
mod condensed;
pub(super) mod dense;
mod flat_layer;
mod newton;
mod raised;
mod system;
mod thick;

use crate::material::AreaLaw;

use crate::springblock::outcome::peak_over_whole_blocks;
use crate::springblock::rims::PLANE_STRAIN;
use crate::springblock::{InterfacePoint, Lattice, Scene, Status, SurfaceOutcome};
use anderson::Anderson;
pub use band::{BATCH, BandFactor, BandMatrix};
pub use condensed::{CondensedModel, condensing_cost};
pub use raised::{FaceHistory, RaisedModel};
use system::{Contact, Raised, System};
pub use system::{band_products, factor_bytes};
pub use thick::ThickModel;

/// A solve has converged if the friction forces change by no more than this in one evaluation of the fixed-point map:
/// sum of the magnitudes of the changes, over the load. The error of the friction coefficient is about as large; 1e-8
/// is required.
const TOLERANCE: f64 = 1e-11;
/// Maximum number of evaluations of the fixed-point map.
const MAX_ITERATIONS: usize = 300;
/// Maximum number of rounds of lifting and landing blocks in unilateral contact.
const MAX_CONTACT_ROUNDS: usize = 60;

/// A load, friction coefficients and an area law, for which a [`SteadyModel`] is solved.
#[derive(Clone, Copy, Debug)]
pub struct SteadyLoad<'a> {
    /// Nominal pressure, in pascals.
    pub pressure_pa: f64,
    /// Local dynamic friction coefficient of every column, cavity or not.
    pub dynamic_mu: &'a [f64],
    /// Area law; `None` for Amontons-Coulomb friction, proportional to the normal force.
    pub area_law: Option<&'a AreaLaw>,
}

/// Model of steady sliding of a lattice, for any load.
#[derive(Clone, Debug)]
pub struct SteadyModel {
    lattice: Lattice,
    block_m: f64,
    youngs_modulus_pa: f64,
    liftoff: bool,
    system: System,
}

/// Response of an elastic lattice under the nominal load to friction on the contact blocks.
trait LinearResponse {
    /// Contact blocks, left to right.
    fn contacts(&self) -> &[Contact];
    /// Load on the bulk in units of P l^2 (nominal pressure P, lattice spacing l), which equals the length of the
    /// lattice in lattice spacings.
    fn load(&self) -> f64;
    /// Number of displacements that [`Self::respond`] computes.
    fn order(&self) -> usize;
    /// Computes displacements and normal forces (positive in compression) under the nominal load and the friction
    /// forces `friction` (positive against sliding) on the contacts, with the bulk at x = 0. Displacements are in units
    /// of P l^2 / k, forces in units of P l^2, with the nominal pressure P, lattice spacing l and spring stiffness k.
    fn respond(&self, friction: &[f64], displacement: &mut [f64], normal: &mut [f64]);
    /// Like [`Self::respond`] for several loads, possibly faster than one after the other; results are identical.
    fn respond_each(&self, each: &mut [Response<'_>]) {
        for Response { friction, displacement, normal } in each {
            self.respond(friction, displacement, normal);
        }
    }
}

/// Arguments of [`LinearResponse::respond`].
struct Response<'a> {
    friction: &'a [f64],
    displacement: &'a mut [f64],
    normal: &'a mut [f64],
}

/// Result of a solve: forces on the contact blocks in units of P l^2, and displacements in units of P l^2 / k, with the
/// nominal pressure P, lattice spacing l and spring stiffness k.
struct Equilibrium {
    status: Status,
    iterations: usize,
    residual: f64,
    /// Friction force, positive against sliding, by contact.
    friction: Vec<f64>,
    /// Normal force, positive in compression, by contact.
    normal: Vec<f64>,
    displacement: Vec<f64>,
}

impl SteadyModel {
    /// Assembles and factors the elastic equations of `lattice`, whose blocks are `block_m` metres apart.
    ///
    /// With `liftoff` contact is unilateral and blocks under tension leave the counterface.
    pub fn new(lattice: Lattice, block_m: f64, youngs_modulus_pa: f64, liftoff: bool) -> Self {
        let system = System::new(&lattice, &[]);
        Self { lattice, block_m, youngs_modulus_pa, liftoff, system }
    }

    /// Creates the model with the blocks and the material of `scene`.
    pub fn for_scene(scene: &Scene, lattice: Lattice) -> Self {
        Self::new(lattice, scene.layer.block_m, scene.elastic.youngs_modulus_pa(), scene.run.liftoff)
    }

    pub const fn lattice(&self) -> &Lattice {
        &self.lattice
    }

    /// Vertical stiffness of the layer without friction, in units of the spring stiffness k, divided by the length of
    /// the lattice in lattice spacings.
    pub fn stiffness_per_length(&self) -> f64 {
        self.system.bulk_stiffness() / self.system.load()
    }

    /// Solves steady sliding under `load`.
    pub fn solve(&self, load: &SteadyLoad) -> SurfaceOutcome {
        if load.pressure_pa == 0.0 || self.system.contacts().is_empty() {
            return unloaded(self.system.contacts(), self.block_m);
        }
        self.observe(load, &self.equilibrium(load))
    }

    /// Solves steady sliding under each of `loads`, with results identical to [`Self::solve`].
    pub fn solve_all(&self, loads: &[SteadyLoad]) -> Vec<SurfaceOutcome> {
        let is_plain = !self.liftoff && !self.lattice.is_raised() && !self.system.contacts().is_empty();
        if !is_plain || loads.iter().any(|load| load.pressure_pa == 0.0) {
            return loads.iter().map(|load| self.solve(load)).collect();
        }
        let states = iterate_all(&self.system, loads);
        loads.iter().zip(&states).map(|(load, state)| self.observe(load, state)).collect()
    }

    /// Solves steady sliding in unilateral contact: lifts blocks under tension and lands lifted blocks that are below
    /// the height of their face, until no block changes.
    fn solve_unilateral(&self, load: &SteadyLoad) -> Equilibrium {
        // r in units of P l^2 / k
        let scale = 1.0 / displacement_unit(load.pressure_pa, self.youngs_modulus_pa);
        let mut lifted: Vec<usize> = Vec::new();
        let mut iterations = 0;
        let mut rounds = 0;
        loop {
            let own;
            let system = if lifted.is_empty() {
                &self.system
            } else {
                own = System::new(&self.lattice, &lifted);
                &own
            };
            let mut state = iterate(&Raised { system, scale }, load);
            iterations += state.iterations;
            state.iterations = iterations;
            let mut next: Vec<usize> = Vec::new();
            for (contact, &normal) in system.contacts().iter().zip(&state.normal) {
                let is_lifted = lifted.contains(&contact.column);
                let height = state.displacement[contact.dof + 1];
                let face = scale * self.lattice.columns()[contact.column].relief;
                if (is_lifted && height >= face) || (!is_lifted && normal < 0.0) {
                    next.push(contact.column);
                }
            }
            rounds += 1;
            if next == lifted {
                return state;
            }
            if rounds == MAX_CONTACT_ROUNDS || next.len() == system.contacts().len() {
                state.status = Status::NotConverged;
                return state;
            }
            lifted = next;
        }
    }

    /// Displacements x and y, in lattice spacings, in steady sliding under `load` with the bulk at x = 0; index j * nx
    /// + i for column i of row j.
    pub fn displacements(&self, load: &SteadyLoad) -> Vec<[f64; 2]> {
        let (nx, ny) = (self.lattice.nx(), self.lattice.ny());
        if load.pressure_pa == 0.0 || self.system.contacts().is_empty() {
            return vec![[0.0; 2]; nx * ny];
        }
        let state = self.equilibrium(load);
        let unit = displacement_unit(load.pressure_pa, self.youngs_modulus_pa);
        (0..nx * ny)
            .map(|number| {
                let dof = self.system.dof(number % nx, number / nx);
                [state.displacement[dof] * unit, state.displacement[dof + 1] * unit]
            })
            .collect()
    }

    fn equilibrium(&self, load: &SteadyLoad) -> Equilibrium {
        if self.liftoff || self.lattice.is_raised() { self.solve_unilateral(load) } else { iterate(&self.system, load) }
    }

    fn observe(&self, load: &SteadyLoad, state: &Equilibrium) -> SurfaceOutcome {
        let clearance = self.clearance(load.pressure_pa, &state.displacement);
        observe(self.system.contacts(), self.block_m, load, state, clearance)
    }

    /// Minimum height of a cavity's ceiling above the counterface at the displacements `displacement`, in lattice
    /// spacings; `None` if there is no ceiling.
    fn clearance(&self, pressure_pa: f64, displacement: &[f64]) -> Option<f64> {
        let unit = displacement_unit(pressure_pa, PLANE_STRAIN * self.youngs_modulus_pa);
        let (columns, rows) = (self.lattice.columns(), self.lattice.ny());
        // In a column that is cavity in all rows there is no ceiling.
        let ceilings = columns.iter().enumerate().filter(|(i, c)| !c.is_land() && self.lattice.lowest_row(*i) < rows);
        let heights = ceilings.into_iter().map(|(i, column)| {
            let ceiling = self.system.dof(i, self.lattice.lowest_row(i));
            column.cavity_rows + displacement[ceiling + 1] * unit
        });
        heights.reduce(f64::min)
    }
}

/// Unit of displacement P l^2 / k of a steady solution, in lattice spacings l: P / (3/4 E), with the nominal pressure P
/// and Young's modulus E.
fn displacement_unit(pressure_pa: f64, youngs_modulus_pa: f64) -> f64 {
    pressure_pa / (0.75 * youngs_modulus_pa)
}

/// Outcome of a lattice without load.
fn unloaded(contacts: &[Contact], block_m: f64) -> SurfaceOutcome {
    SurfaceOutcome::unsolved(Status::NoLoad, contacts.iter().map(|contact| contact.centre * block_m))
}

/// Converts the forces of `state` on `contacts` to an outcome of the model; `clearance` is the minimum height of a
/// cavity's ceiling, in lattice spacings, or `None` without a ceiling.
fn observe(
    contacts: &[Contact],
    block_m: f64,
    load: &SteadyLoad,
    state: &Equilibrium,
    clearance: Option<f64>,
) -> SurfaceOutcome {
    if !state.normal.iter().chain(&state.friction).all(|force| force.is_finite()) {
        // Nothing resists the friction, as in a single free column: there is no equilibrium.
        return SurfaceOutcome { status: Status::NotConverged, ..unloaded(contacts, block_m) };
    }
    let interface: Vec<InterfacePoint> = contacts
        .iter()
        .zip(state.normal.iter().zip(&state.friction))
        .map(|(contact, (normal, friction))| {
            // p = F_n / (w l), forces in units of P l^2
            let [pressure_pa, friction_pa] = [normal, friction].map(|force| force / contact.width * load.pressure_pa);
            InterfacePoint { x_m: contact.centre * block_m, y_m: 0.0, pressure_pa, friction_pa }
        })
        .collect();
    let share: Vec<f64> = contacts.iter().map(|contact| contact.width).collect();
    let neighbours = |number: usize| {
        let is_neighbour = move |other: &usize| {
            contacts.get(*other).is_some_and(|other| other.column.abs_diff(contacts[number].column) == 1)
        };
        [number.wrapping_sub(1), number + 1].into_iter().filter(is_neighbour)
    };
    let peak_pressure_pa = peak_over_whole_blocks(&interface, &share, neighbours);
    let clearance_m = clearance.map(|clearance| clearance * block_m);
    let forces = [&state.normal[..], &state.friction];
    SurfaceOutcome {
        residual: Some(state.residual),
        iterations: state.iterations,
        ..SurfaceOutcome::from_steady_forces(
            state.status,
            forces,
            (interface, peak_pressure_pa),
            clearance_m,
            load.area_law,
        )
    }
}

/// Solves for the fixed point of the friction forces under `load`.
fn iterate(system: &impl LinearResponse, load: &SteadyLoad) -> Equilibrium {
    let mut iteration = Iteration::new(system, load);
    while iteration.is_open() {
        let Response { friction, displacement, normal } = iteration.response();
        system.respond(friction, displacement, normal);
        iteration.advance(system);
    }
    iteration.end(system)
}

/// Like [`iterate`] for several loads at the same time.
fn iterate_all(system: &impl LinearResponse, loads: &[SteadyLoad]) -> Vec<Equilibrium> {
    let mut all: Vec<Iteration> = loads.iter().map(|load| Iteration::new(system, load)).collect();
    loop {
        let mut open: Vec<&mut Iteration> = all.iter_mut().filter(|iteration| iteration.is_open()).collect();
        if open.is_empty() {
            break;
        }
        let mut each: Vec<Response> = open.iter_mut().map(|iteration| iteration.response()).collect();
        system.respond_each(&mut each);
        open.into_iter().for_each(|iteration| iteration.advance(system));
    }
    all.into_iter().map(|iteration| iteration.end(system)).collect()
}

/// The iteration for one load: alternates between [`LinearResponse::respond`] and [`Self::advance`].
struct Iteration<'a> {
    load: &'a SteadyLoad<'a>,
    friction: Vec<f64>,
    mixer: Anderson,
    displacement: Vec<f64>,
    normal: Vec<f64>,
    /// Friction forces computed from the current normal forces.
    image: Vec<f64>,
    residual: f64,
    count: usize,
    best: Option<(f64, Vec<f64>)>,
    has_ended: bool,
}

impl<'a> Iteration<'a> {
    /// Starts from the friction forces at the nominal pressure without an area law.
    fn new(system: &impl LinearResponse, load: &'a SteadyLoad<'a>) -> Self {
        let contacts = system.contacts();
        let share = |contact: &Contact| {
            if contact.lifted { 0.0 } else { load.dynamic_mu[contact.column] * contact.width }
        };
        Self {
            load,
            friction: contacts.iter().map(share).collect(),
            mixer: Anderson::new(),
            displacement: vec![0.0; system.order()],
            normal: vec![0.0; contacts.len()],
            image: vec![0.0; contacts.len()],
            residual: f64::INFINITY,
            count: 0,
            best: None,
            has_ended: false,
        }
    }

    fn is_open(&self) -> bool {
        !self.has_ended && self.count < MAX_ITERATIONS
    }

    fn response(&mut self) -> Response<'_> {
        Response { friction: &self.friction, displacement: &mut self.displacement, normal: &mut self.normal }
    }

    /// Computes `image` from the normal forces, and `residual`: the sum of the magnitudes of `image` - `friction`,
    /// divided by the load.
    fn evaluate(&mut self, system: &impl LinearResponse) {
        for (number, (image, &normal)) in self.image.iter_mut().zip(&self.normal).enumerate() {
            *image = newton::friction_at(system, self.load, number, normal);
        }
        let distance: f64 = self.image.iter().zip(&self.friction).map(|(g, x)| (g - x).abs()).sum();
        self.residual = distance / system.load();
    }

    /// Computes the next friction forces, unless the current ones are the fixed point.
    fn advance(&mut self, system: &impl LinearResponse) {
        self.count += 1;
        self.evaluate(system);
        if self.residual <= TOLERANCE || !self.residual.is_finite() {
            self.has_ended = true;
            return;
        }
        if self.best.as_ref().is_none_or(|(least, _)| self.residual < *least) {
            self.best = Some((self.residual, self.friction.clone()));
        }
        self.mixer.step(&mut self.friction, &self.image);
    }

    /// Returns the equilibrium; continues with Newton's method from the best state if the iteration has not converged.
    fn end(mut self, system: &impl LinearResponse) -> Equilibrium {
        let mut iterations = self.count;
        if !(self.has_ended && self.residual <= TOLERANCE) {
            iterations = MAX_ITERATIONS;
            if let Some((_, state)) = self.best.take() {
                self.friction = state;
                iterations += newton::improve(system, self.load, &mut self.friction, 0.5 * TOLERANCE);
            }
            let Response { friction, displacement, normal } = self.response();
            system.respond(friction, displacement, normal);
            self.evaluate(system);
        }
        Equilibrium {
            status: if self.residual <= TOLERANCE { Status::Converged } else { Status::NotConverged },
            iterations,
            residual: self.residual,
            friction: self.image,
            normal: self.normal,
            displacement: self.displacement,
        }
    }
}

#[cfg(test)]
mod tests;
