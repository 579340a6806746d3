//! Steady sliding of a cell in space.
//!
//! The equations of [`super::interface`] are linear except for the friction t = mu f(p) max(N, 0), which is only weakly
//! nonlinear. They are solved by the chord method: with the derivative of friction at the nominal pressure the
//! linearized equations are the same for all iterations and loads, and the search directions serve all of them
//! ([`super::directions`]). Where chords do not contract (lands that tilt, steep area laws), tangents replace chords.

mod contacts;

use std::borrow::Cow;

use crate::material::AreaLaw;

use super::directions::{Direction, Directions, norm};
use super::interface::{Face, Interface, Response};
use super::lattice::SpaceLattice;
use crate::springblock::outcome::peak_over_whole_blocks;
use crate::springblock::{InterfacePoint, Load, Monitor, Scene, Status, SurfaceOutcome, Unwatched};

/// Default tolerance: a solve has converged if the sum of the magnitudes of the unbalanced forces, divided by the load,
/// is no larger.
pub(crate) const TOLERANCE: f64 = 1e-10;
/// A chord step ends, and friction is evaluated again, when the residual of the linearized equations falls to this
/// fraction of the residual at the start of the step. A chord step reduces the nonlinear residual by about as much.
const LINEAR_TOLERANCE: f64 = 0.03;
/// Tangents replace chords if the ratio of a residual to the previous residual exceeds this value.
const CONTRACTION: f64 = 0.5;
/// Maximum number of search directions for one load.
pub(crate) const MAX_DIRECTIONS: usize = 600;
/// Maximum number of evaluations of friction for one load.
const MAX_EVALUATIONS: usize = 100;
/// Maximum number of stored search directions: more directions take memory and time, fewer directions lose information.
pub(crate) const MAX_STORED_DIRECTIONS: usize = 160;
/// Step of the finite difference for the derivative of friction by normal force, relative to the nominal normal force.
const SLOPE_STEP: f64 = 1e-6;
/// Maximum number of rounds of lifting and landing blocks in unilateral contact.
const MAX_CONTACT_ROUNDS: usize = 60;

/// A load, friction coefficients and an area law, for which a [`SpaceSteadyModel`] is solved.
#[derive(Clone, Copy, Debug)]
pub struct SpaceLoad<'a> {
    /// Nominal pressure, in pascals.
    pub pressure_pa: f64,
    /// Local dynamic friction coefficient.
    pub dynamic_mu: f64,
    /// Friction coefficient of each contact divided by `dynamic_mu`, in the order of the contacts; `None` means 1 for
    /// all.
    pub relative_mu: Option<&'a [f64]>,
    /// Area law; `None` for Amontons-Coulomb friction, proportional to the normal force.
    pub area_law: Option<&'a AreaLaw>,
    /// Unit vector of the sliding direction, which friction opposes.
    pub direction: [f64; 2],
}

impl<'a> SpaceLoad<'a> {
    /// Converts `load` to a load whose friction coefficient is the mean dynamic coefficient of `load`, sliding along
    /// the unit vector `direction`.
    pub(crate) fn with_mean_friction(load: &Load, area_law: Option<&'a AreaLaw>, direction: [f64; 2]) -> Self {
        let dynamic_mu = load.friction.dynamic_mean();
        Self { pressure_pa: load.pressure_pa, dynamic_mu, relative_mu: None, area_law, direction }
    }
}

/// Model of steady sliding of a cell, for any load.
#[derive(Clone, Debug)]
pub struct SpaceSteadyModel {
    lattice: SpaceLattice,
    block_m: f64,
    youngs_modulus_pa: f64,
    liftoff: bool,
    yield_pressure_pa: Option<f64>,
    tolerance: f64,
    interface: Interface,
}

/// Unknowns of the cell, and quantities that depend linearly on the unknowns. Forces are in units of P l^2,
/// displacements in units of P l^2 / k, with the nominal pressure P, lattice spacing l and spring stiffness k.
#[derive(Clone, Debug)]
struct State {
    unknowns: Vec<f64>,
    /// Residual of the elastic equations.
    elastic: Vec<f64>,
    /// Normal forces by contact.
    normal: Vec<f64>,
}

/// Solver for a sequence of loads on one cell.
struct Solver<'a> {
    model: &'a SpaceSteadyModel,
    monitor: &'a dyn Monitor,
    interface: Cow<'a, Interface>,
    response: Response,
    directions: Directions,
    state: State,
    /// Derivative of friction by normal force in the linearized equations, by contact.
    slope: Vec<f64>,
    /// Unit vector along which friction acts, opposite to the sliding direction.
    along: [f64; 2],
    /// Scale of the face heights, and yield force, for the current load; zero for a flat face.
    face: Face,
    /// An iteration ends when the sum of the magnitudes of the unbalanced forces, divided by the load, is no larger.
    tolerance: f64,
    /// Whether `slope` was taken at the current normal forces (tangents), not at the nominal pressure (chords).
    tangent: bool,
}

/// Result of the iteration for one load.
struct End {
    status: Status,
    residual: f64,
    directions: usize,
}

impl SpaceSteadyModel {
    /// Condenses `lattice`, whose blocks are `block_m` metres apart.
    ///
    /// With `liftoff` contact is unilateral and blocks under tension leave the counterface; this is always so on a face
    /// with height variations.
    pub fn new(lattice: SpaceLattice, block_m: f64, youngs_modulus_pa: f64, liftoff: bool) -> Self {
        let interface = Interface::new(&lattice);
        // A face with height variations does not touch the counterface everywhere.
        let liftoff = liftoff || lattice.is_raised();
        Self { lattice, block_m, youngs_modulus_pa, liftoff, yield_pressure_pa: None, tolerance: TOLERANCE, interface }
    }

    /// Creates the model with the blocks and the material of `scene`.
    pub(crate) fn for_scene(scene: &Scene, lattice: SpaceLattice) -> Self {
        Self::new(lattice, scene.layer.block_m, scene.elastic.youngs_modulus_pa(), scene.run.liftoff)
    }

    /// Sets the pressure in pascals at which the heights of the face yield; with `None` the heights stay elastic.
    /// Yielded contacts remain flattened for the following loads.
    #[must_use]
    pub fn yielding_at(self, yield_pressure_pa: Option<f64>) -> Self {
        Self { yield_pressure_pa, ..self }
    }

    /// Sets the tolerance: a solve ends if the sum of the magnitudes of the unbalanced forces, divided by the load, is
    /// no larger.
    #[must_use]
    pub fn balanced_to(self, tolerance: f64) -> Self {
        Self { tolerance, ..self }
    }

    /// Lattice of the model.
    pub const fn lattice(&self) -> &SpaceLattice {
        &self.lattice
    }

    /// Distance between neighbouring rows, in metres.
    pub const fn block_m(&self) -> f64 {
        self.block_m
    }

    /// Solves steady sliding under `load`.
    pub fn solve(&self, load: &SpaceLoad) -> SurfaceOutcome {
        Solver::new(self).outcome(load)
    }

    /// Solves steady sliding under each of `loads` until `monitor` cancels; each solution is the start for the next
    /// load.
    pub fn solve_all(&self, loads: &[SpaceLoad], monitor: &dyn Monitor) -> Vec<SurfaceOutcome> {
        let mut solver = Solver { monitor, ..Solver::new(self) };
        loads.iter().map(|load| solver.outcome(load)).collect()
    }

    /// Displacements x, y and z, in lattice spacings, in steady sliding under `load`; index (k ny + j) nx + i for the
    /// block in column i along x and j along y of row k. The bulk is the last row, at x = y = 0. Values of removed
    /// blocks are meaningless.
    pub fn displacements(&self, load: &SpaceLoad) -> Vec<[f64; 3]> {
        let [nx, ny] = self.lattice.columns();
        let plane = nx * ny;
        if load.pressure_pa == 0.0 || self.interface.contacts() == 0 {
            return vec![[0.0; 3]; plane * (self.lattice.rows() + 1)];
        }
        let mut solver = Solver::new(self);
        let (_, lifted) = solver.equilibrate(load);
        let solver = lifted.as_ref().unwrap_or(&solver);
        let mut whole = Interface::uncondensed(&self.lattice).with_contacts(&solver.lifted(), &solver.yielding());
        whole.copy_heights(&solver.interface);
        let mut moved = whole.response();
        whole.respond_loaded(&solver.state.unknowns, solver.along, solver.face, &mut moved);
        let unit = self.displacement_unit(load.pressure_pa);
        (0..plane * (self.lattice.rows() + 1))
            .map(|number| {
                let place = 3 * plane * (number / plane) + number % plane;
                [0, 1, 2].map(|c| moved.fields[place + c * plane] * unit)
            })
            .collect()
    }

    /// Unit of displacement P l^2 / k of a steady solution, in lattice spacings l: P / (2/5 E), with the nominal
    /// pressure P and Young's modulus E.
    fn displacement_unit(&self, pressure_pa: f64) -> f64 {
        pressure_pa / (0.4 * self.youngs_modulus_pa)
    }

    /// Friction force on contact `number`, of which the fraction `share` touches, at the normal force `normal`; both
    /// forces are in units of P l^2 (nominal pressure P, lattice spacing l). In unilateral contact, blocks under
    /// tension are lifted in a later round; until then friction is continued smoothly to negative values.
    fn friction(&self, load: &SpaceLoad, number: usize, share: f64, normal: f64) -> f64 {
        let normal = if self.liftoff { normal } else { normal.max(0.0) };
        // p = F_n / (a l^2), forces in units of P l^2
        let pressure_pa = normal / (share * self.interface.column_area()) * load.pressure_pa;
        let factor = load.area_law.map_or(1.0, |law| law.factor(pressure_pa));
        let relative_mu = load.relative_mu.map_or(1.0, |each| each[number]);
        load.dynamic_mu * relative_mu * factor * normal
    }

    /// Fraction of the area of the column that touches, for each contact.
    fn shares(&self) -> impl Iterator<Item = f64> + '_ {
        self.interface.surface().iter().filter(|s| s.contact.is_some()).map(|s| s.contact_share)
    }

    /// Minimum height of a cavity's ceiling above the counterface at the displacements `displacement`, in lattice
    /// spacings; `None` if there is no cavity.
    fn clearance(&self, pressure_pa: f64, displacement: &[f64]) -> Option<f64> {
        let unit = self.displacement_unit(pressure_pa);
        let [nx, ny] = self.lattice.columns();
        let row = self.lattice.ceiling_row();
        let ceiling = &displacement[(3 * row + 2) * nx * ny..][..nx * ny];
        let is_cavity = |column: &usize| self.lattice.is_cavity(column % nx, column / nx);
        (0..nx * ny).filter(is_cavity).map(|column| self.lattice.depth() + ceiling[column] * unit).reduce(f64::min)
    }
}

impl<'a> Solver<'a> {
    fn new(model: &'a SpaceSteadyModel) -> Self {
        Self::with_interface(model, Cow::Borrowed(&model.interface))
    }

    fn with_interface(model: &'a SpaceSteadyModel, interface: Cow<'a, Interface>) -> Self {
        let elastic = interface.elastic_unknowns();
        let mut solver = Self {
            model,
            monitor: &Unwatched,
            response: interface.response(),
            directions: Directions::default(),
            state: State {
                unknowns: vec![0.0; elastic + interface.contacts()],
                elastic: vec![0.0; elastic],
                normal: vec![0.0; interface.contacts()],
            },
            interface,
            slope: Vec::new(),
            along: [0.0; 2],
            face: Face::default(),
            tolerance: model.tolerance,
            tangent: false,
        };
        solver.observe();
        solver
    }

    /// Recomputes the residual, the normal forces and the needed displacements from the unknowns.
    fn observe(&mut self) {
        let interface = &self.interface;
        let heights = interface.elastic_unknowns() - interface.free();
        interface.respond_loaded(&self.state.unknowns, self.along, self.face, &mut self.response);
        for (number, residual) in self.state.elastic.iter_mut().enumerate() {
            let image = self.response.linear[number];
            // g - R u, and the unbalanced vertical force
            *residual = if number < heights { self.state.unknowns[number] - image } else { image };
        }
        self.state.normal.copy_from_slice(&self.response.normal);
    }

    /// Negative residuals of all equations under `load`, and the sum of the magnitudes of the residuals divided by the
    /// load.
    fn residual(&self, load: &SpaceLoad) -> (Vec<f64>, f64) {
        let elastic = self.state.elastic.len();
        let mut residual: Vec<f64> = self.state.elastic.iter().map(|value| -value).collect();
        let friction = &self.state.unknowns[elastic..];
        for (number, ((share, normal), friction)) in
            self.model.shares().zip(&self.state.normal).zip(friction).enumerate()
        {
            residual.push(self.model.friction(load, number, share, *normal) - friction);
        }
        let sum: f64 = residual.iter().map(|value| value.abs()).sum();
        let size = sum / self.interface.load();
        (residual, size)
    }

    /// Applies the linearized equations to `step`, a change of the unknowns; returns `step`, the image, and the normal
    /// forces that the step adds.
    fn apply(&mut self, step: Vec<f64>) -> Direction {
        let interface = &self.interface;
        let elastic = interface.elastic_unknowns();
        let heights = elastic - interface.free();
        interface.respond(&step, self.along, &mut self.response);
        let mut image = step.clone();
        for (number, image) in image[..elastic].iter_mut().enumerate() {
            let linear = self.response.linear[number];
            *image = if number < heights { *image - linear } else { linear };
        }
        for (image, (slope, normal)) in image[elastic..].iter_mut().zip(self.slope.iter().zip(&self.response.normal)) {
            *image -= slope * normal;
        }
        Direction { step, image, normal: self.response.normal.clone() }
    }

    /// Moves the state by the step whose image, the sum of `shares[n]` times stored image n, was subtracted from the
    /// negative residual; `residual` is the rest.
    fn advance(&mut self, shares: &[f64], residual: &[f64]) {
        let State { unknowns, elastic, normal } = &mut self.state;
        self.directions.advance(shares, unknowns, normal);
        elastic.iter_mut().zip(residual).for_each(|(elastic, left)| *elastic = -left);
    }

    /// Sets the derivatives of friction by normal force: at the current normal forces if `tangent`, otherwise at the
    /// nominal pressure.
    fn set_slopes(&mut self, load: &SpaceLoad, tangent: bool) {
        let (model, area) = (self.model, self.model.interface.column_area());
        let slope_at = |number: usize, share: f64, normal: f64| {
            let step = SLOPE_STEP * (share * area);
            let [ahead, behind] = [normal + step, normal - step].map(|n| model.friction(load, number, share, n));
            (ahead - behind) / (2.0 * step)
        };
        let contacts = self.state.normal.len();
        self.slope = if tangent {
            let each = model.shares().zip(&self.state.normal).enumerate();
            each.map(|(number, (share, normal))| slope_at(number, share, *normal)).collect()
        } else if load.relative_mu.is_some() {
            (0..contacts).map(|number| slope_at(number, 1.0, area)).collect()
        } else {
            vec![slope_at(0, 1.0, area); contacts]
        };
        self.tangent = tangent;
        self.directions.clear();
    }

    /// Solves for equilibrium under `load`. In unilateral contact lifts blocks under tension and lands lifted blocks
    /// below the counterface until no block changes; if blocks have lifted, also returns the solver with the lifted
    /// contacts.
    fn equilibrate(&mut self, load: &SpaceLoad) -> (End, Option<Self>) {
        if self.model.lattice.is_raised() {
            return (self.equilibrate_raised(load), None);
        }
        let mut end = self.iterate(load);
        if !self.model.liftoff {
            return (end, None);
        }
        let mut lifted = vec![false; self.interface.contacts()];
        let mut latest: Option<Self> = None;
        for _ in 0..MAX_CONTACT_ROUNDS {
            let solver = latest.as_ref().unwrap_or(self);
            let heights = solver.interface.lifted(&solver.state.unknowns);
            let next: Vec<bool> = heights
                .zip(&solver.state.normal)
                .map(|(height, normal)| height.map_or(*normal < 0.0, |height| height >= 0.0))
                .collect();
            if next == lifted || end.status == Status::Cancelled {
                return (end, latest);
            }
            if next.iter().all(|lifted| *lifted) {
                break;
            }
            lifted = next;
            let interface = Cow::Owned(self.model.interface.with_contacts(&lifted, &vec![false; lifted.len()]));
            let mut solver = Self { monitor: self.monitor, ..Self::with_interface(self.model, interface) };
            let latest_end = solver.iterate(load);
            end = End { directions: end.directions + latest_end.directions, ..latest_end };
            latest = Some(solver);
        }
        end.status = Status::NotConverged;
        (end, latest)
    }

    /// Iterates to equilibrium under `load`, starting from the current state.
    fn iterate(&mut self, load: &SpaceLoad) -> End {
        if self.along != load.direction.map(|component| -component) {
            self.along = load.direction.map(|component| -component);
            self.observe();
            self.slope.clear();
        }
        if self.slope.is_empty() || self.tangent {
            self.set_slopes(load, false);
        }
        let mut applied = 0;
        let mut last = f64::INFINITY;
        let mut best: Option<(f64, State)> = None;
        let mut verified = false;
        for _ in 0..MAX_EVALUATIONS {
            let (mut residual, size) = self.residual(load);
            if size <= self.tolerance {
                if verified {
                    return End { status: Status::Converged, residual: size, directions: applied };
                }
                // Sums of many directions accumulate rounding errors, so the residual must be recomputed from the
                // unknowns.
                self.observe();
                verified = true;
                continue;
            }
            verified = false;
            if !size.is_finite() || applied >= MAX_DIRECTIONS {
                break;
            }
            if best.as_ref().is_none_or(|(least, _)| size < *least) {
                best = Some((size, self.state.clone()));
            }
            if size > CONTRACTION * last {
                self.set_slopes(load, true);
            }
            last = size;
            let target = LINEAR_TOLERANCE * norm(&residual);
            let mut shares = self.directions.project_out(&mut residual);
            while norm(&residual) > target && applied < MAX_DIRECTIONS {
                if self.monitor.cancelled() {
                    self.advance(&shares, &residual);
                    return End { status: Status::Cancelled, residual: size, directions: applied };
                }
                if self.directions.count() >= MAX_STORED_DIRECTIONS {
                    self.advance(&shares, &residual);
                    shares.clear();
                    self.directions.clear();
                }
                let mut step = residual.clone();
                self.interface.precondition(&mut step);
                let direction = self.apply(step);
                applied += 1;
                if !self.directions.add(direction) {
                    break;
                }
                shares.extend(self.directions.project_out_last(&mut residual));
            }
            self.advance(&shares, &residual);
        }
        if let Some((_, state)) = best {
            self.state = state;
        }
        self.observe();
        let (_, residual) = self.residual(load);
        let status = if residual <= self.tolerance { Status::Converged } else { Status::NotConverged };
        End { status, residual, directions: applied }
    }

    fn outcome(&mut self, load: &SpaceLoad) -> SurfaceOutcome {
        if load.pressure_pa == 0.0 || self.interface.contacts() == 0 {
            let interface = self.points(load, |_| (0.0, 0.0));
            return SurfaceOutcome { interface, ..SurfaceOutcome::unsolved(Status::NoLoad, std::iter::empty()) };
        }
        let (end, lifted) = self.equilibrate(load);
        lifted.as_ref().unwrap_or(self).outcome_of(load, &end)
    }

    /// Pressure and friction of every contact block, from the normal and the friction force that `forces` returns for
    /// the index of the contact, in units of P l^2 (nominal pressure P, lattice spacing l).
    fn points(&self, load: &SpaceLoad, forces: impl Fn(usize) -> (f64, f64)) -> Vec<InterfacePoint> {
        let (spacing, block_m, area) = (self.model.lattice.spacing(), self.model.block_m, self.interface.column_area());
        let contacts = self.interface.surface().iter().filter(|surface| surface.contact.is_some());
        contacts
            .enumerate()
            .map(|(number, surface)| {
                // p = F_n / (a l^2), forces in units of P l^2
                let scale = load.pressure_pa / (surface.contact_share * area);
                let centre = |axis: usize| (surface.column[axis] as f64 + 0.5) * spacing[axis] * block_m;
                let (normal, friction) = forces(number);
                InterfacePoint {
                    x_m: centre(0),
                    y_m: centre(1),
                    pressure_pa: normal * scale,
                    friction_pa: friction * scale,
                }
            })
            .collect()
    }

    /// Largest pressure at the contacts `interface`, in pascals, with pressures averaged over whole blocks.
    fn peak_pressure_pa(&self, interface: &[InterfacePoint]) -> f64 {
        let [nx, ny] = self.model.lattice.columns();
        let touching: Vec<_> = self.interface.surface().iter().filter(|surface| surface.contact.is_some()).collect();
        let share: Vec<f64> = touching.iter().map(|surface| surface.contact_share).collect();
        let mut numbers = vec![None; nx * ny];
        for (number, surface) in touching.iter().enumerate() {
            numbers[surface.column[1] * nx + surface.column[0]] = Some(number);
        }
        peak_over_whole_blocks(interface, &share, |number| {
            let [i, j] = touching[number].column;
            let around = [[(i + 1) % nx, j], [(i + nx - 1) % nx, j], [i, (j + 1) % ny], [i, (j + ny - 1) % ny]];
            around.into_iter().filter_map(|[i, j]| numbers[j * nx + i]).collect::<Vec<usize>>()
        })
    }

    /// Converts the current state to an outcome for `load`.
    fn outcome_of(&self, load: &SpaceLoad, end: &End) -> SurfaceOutcome {
        let friction = &self.state.unknowns[self.state.elastic.len()..];
        let interface = self.points(load, |number| (self.state.normal[number], friction[number]));
        let peak_pressure_pa = self.peak_pressure_pa(&interface);
        let clearance = self.model.clearance(load.pressure_pa, &self.response.fields);
        let clearance_m = clearance.map(|clearance| clearance * self.model.block_m);
        let forces = [&self.state.normal[..], friction];
        let interface = (interface, peak_pressure_pa);
        let found = SurfaceOutcome::from_steady_forces(end.status, forces, interface, clearance_m, load.area_law);
        let residual = Some(end.residual).filter(|_| found.status != Status::NoLoad);
        SurfaceOutcome { residual, iterations: end.directions, ..found }
    }
}
