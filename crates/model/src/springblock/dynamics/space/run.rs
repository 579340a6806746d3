//! One dynamic run of one cell or strip in space.

use super::super::contact::{ContactRow, LocalLaw};
use super::super::drive::{Drive, refusal, refused_outcome};
use super::super::engine::Setup;
use super::super::protocol::Protocol;
use super::super::real::Real;
use super::super::scales::Scales;
use super::super::stability::largest_eigenfrequency;
use super::bonds::SpaceBonds;
use super::leapfrog::SpaceLeapfrog;
use crate::springblock::{
    Load, Monitor, Scene, SceneError, SpaceLattice, SpaceLoad, SpaceSteadyModel, Status, SurfaceOutcome, draws,
};

/// Default time step in units of sqrt(m/k), with block mass m and spring stiffness k = 2/5 E l: 4 ns for the published
/// polymer at a lattice spacing l of 10 um, two fifths of the stability limit.
pub const SPACE_STEP: f64 = 0.1644;
/// Largest eigenfrequency times the step at the stability limit of the leapfrog.
const LEAPFROG_LIMIT: f64 = 2.0;

/// Time step of the leapfrog on a cell, and its stability limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpaceScheme {
    /// Time step, in seconds.
    pub step_s: f64,
    /// Largest stable time step, in seconds.
    pub limit_s: f64,
}

impl SpaceScheme {
    /// Returns the time step that `scene` requests, and the stability limit on `lattice`.
    ///
    /// # Errors
    /// [`SceneError::UnstableStep`] if the step exceeds the stability limit.
    pub fn choose(scene: &Scene, lattice: &SpaceLattice) -> Result<Self, SceneError> {
        let scales = Scales::space(&scene.elastic, scene.layer.block_m);
        let liftoff = scene.run.liftoff || lattice.is_raised();
        let limit_s = LEAPFROG_LIMIT / largest_frequency(lattice, liftoff) * scales.time_s;
        let step_s = scene.run.step_s.unwrap_or(SPACE_STEP * scales.time_s);
        if step_s > limit_s {
            return Err(SceneError::UnstableStep { step_s, limit_s, scheme: "leapfrog in three dimensions" });
        }
        Ok(Self { step_s, limit_s })
    }
}

/// Largest angular eigenfrequency of `lattice` in units of sqrt(k/m), with spring stiffness k and block mass m. Blocks
/// on the counterface move vertically only if `liftoff`.
pub fn largest_frequency(lattice: &SpaceLattice, liftoff: bool) -> f64 {
    let bonds = SpaceBonds::new(lattice);
    let [nx, ny] = lattice.columns();
    let blocks = bonds.mass().len();
    let mut weight = vec![0.0; 3 * blocks];
    for (number, mass) in bonds.mass().iter().enumerate() {
        let is_held = number < nx * ny && lattice.contact_share(number % nx, number / nx) > 0.0 && !liftoff;
        if *mass > 0.0 {
            weight[3 * number..][..3].fill(1.0 / mass.sqrt());
            if is_held {
                weight[3 * number + 2] = 0.0;
            }
        }
    }
    let (mut u, mut f) = (vec![[0.0; 3]; blocks + 1], vec![[0.0; 3]; blocks + 1]);
    largest_eigenfrequency(&weight, |displacement, force| {
        for (u, displacement) in u.iter_mut().zip(displacement.chunks_exact(3)) {
            u.copy_from_slice(displacement);
        }
        bonds.balance(&mut u, 0.0);
        bonds.forces(&u, &mut f);
        for (force, f) in force.chunks_exact_mut(3).zip(&f) {
            force.copy_from_slice(f);
        }
    })
}

/// A dynamic run of one cell or strip in space under one load.
#[derive(Clone, Copy)]
pub struct SpaceRun<'a> {
    pub scene: &'a Scene,
    pub load: &'a Load,
    /// Lattice of whole cubes.
    pub lattice: &'a SpaceLattice,
    /// Unit vector of the sliding direction.
    pub direction: [f64; 2],
    /// Time step and its stability limit.
    pub scheme: SpaceScheme,
    /// Fraction of the whole job's work that this run takes, for the progress report.
    pub share: f64,
    /// Random seed of the local friction coefficients.
    pub seed: u64,
    /// Standard error of the mean dynamic friction coefficient, relative to this mean, at which the run may end; `None`
    /// if no standard error is requested.
    pub stderr_share: Option<f64>,
}

impl SpaceRun<'_> {
    pub fn run(&self, monitor: &dyn Monitor) -> SurfaceOutcome {
        let Self { scene, lattice, .. } = self;
        let untouched = self.centres_m().next().is_none().then_some(Status::NoLoad);
        if let Some(status) = untouched.or_else(|| refusal(scene, self.load, self.scheme.step_s)) {
            monitor.advance(self.share);
            return refused_outcome(status, self.scheme.step_s, self.centres_m());
        }
        let started_s = monitor.seconds();
        let scales = Scales::space(&scene.elastic, scene.layer.block_m);
        let plane = Scales::new(&scene.elastic, scene.layer.block_m);
        let [nx, ny] = lattice.columns();
        let coefficients = draws::draw(&self.load.friction, self.seed, nx * ny);
        let start = self.start();
        let law = LocalLaw::new(scene.area_law.as_ref(), scales.pressure_pa);
        let mut contact = ContactRow::new(lattice.contacts(), &coefficients, law);
        if let Some(start) = start.as_ref().filter(|_| lattice.is_raised()) {
            contact.place(|column| [lattice.relief(column % nx, column / nx), start[column][2]]);
        }
        let setup = Setup {
            contact,
            // The load is P l^2 per column of the face.
            protocol: Protocol::new(
                scene,
                &scales,
                self.load.pressure_pa / scales.pressure_pa * lattice.face_columns() as f64,
            ),
            direction: self.direction,
            time_step: self.scheme.step_s / scales.time_s,
            // The damping rate in 1/s is the same as in the plane, where k differs.
            damping: scene.run.damping * scales.time_s / plane.time_s,
            liftoff: scene.run.liftoff || lattice.is_raised(),
        };
        let sliding = start.as_ref().filter(|_| scene.run.warm_start);
        let sliding = sliding.and_then(|base| SpaceLeapfrog::from_sliding(lattice, setup.clone(), base));
        if let Some(engine) = sliding {
            return self.drive(engine, started_s, monitor);
        }
        let mut engine = SpaceLeapfrog::new(lattice, setup);
        if let Some(start) = start {
            engine.start_sheared(&|[i, j, k]| start[(k * ny + j) * nx + i]);
        }
        self.drive(engine, started_s, monitor)
    }

    fn drive<R: Real>(&self, mut engine: SpaceLeapfrog<R>, started_s: f64, monitor: &dyn Monitor) -> SurfaceOutcome {
        let Self { scene, lattice, .. } = self;
        let scales = Scales::space(&scene.elastic, scene.layer.block_m);
        let drive = Drive {
            scene,
            pressure_pa: self.load.pressure_pa,
            step_s: self.scheme.step_s,
            time_step: self.scheme.step_s / scales.time_s,
            evaluations_per_step: 1,
            share: self.share,
            stderr_share: self.stderr_share,
            blocks: (lattice.face_columns() * lattice.rows()) as u64,
            // 4 h / c_s, c_s = sqrt(C44/rho) = l sqrt(k/m)
            shear_period: 4.0 * lattice.rows() as f64,
            started_s,
        };
        let driven = drive.run(&mut engine, monitor);
        driven.outcome(scene, &scales, self.centres_m(), self.is_closed(&engine))
    }

    /// Initial displacements x, y and z, in lattice spacings, with index (k ny + j) nx + i for block (i, j, k). A warm
    /// start has the displacements in equilibrium with sliding friction, every block at a random phase of its stick-slip
    /// cycle; an unloaded layer with face heights touches with its highest point; `None` for an unloaded flat layer.
    fn start(&self) -> Option<Vec<[f64; 3]>> {
        let Self { scene, load, lattice, .. } = *self;
        let [nx, ny] = lattice.columns();
        if !scene.run.warm_start {
            return lattice.is_raised().then(|| vec![[0.0, 0.0, lattice.highest()]; nx * ny * lattice.rows()]);
        }
        let mean = SpaceLoad::with_mean_friction(load, scene.area_law.as_ref(), self.direction);
        let phases = draws::random_phase_mean_friction(&load.friction, self.seed, nx * ny);
        let model = SpaceSteadyModel::for_scene(scene, lattice.clone());
        Some(model.displacements(&SpaceLoad { relative_mu: Some(&phases), ..mean }))
    }

    /// Centres of the contact blocks, x and y in metres, row by row along x.
    fn centres_m(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        let nx = self.lattice.columns()[0];
        let centre_m = |number: usize| (number as f64 + 0.5) * self.scene.layer.block_m;
        self.lattice.contacts().map(move |column| [column % nx, column / nx].map(centre_m))
    }

    /// Whether the ceiling of a cavity touches the counterface at the end of the run.
    fn is_closed<R: Real>(&self, engine: &SpaceLeapfrog<R>) -> bool {
        let ([nx, ny], ceiling) = (self.lattice.columns(), self.lattice.cavity_rows());
        ceiling < self.lattice.rows()
            && (0..nx * ny).map(|column| [column % nx, column / nx]).any(|[i, j]| {
                self.lattice.is_cavity(i, j) && ceiling as f64 + engine.displacement([i, j, ceiling])[2] <= 0.0
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pattern::Planform;
    use crate::springblock::tests::samples::pattern;

    #[test]
    fn the_largest_frequency_is_that_of_the_dense_matrix() {
        let pattern = pattern(Planform::Square, 20.0, 30.0, 10.0);
        for lattice in [SpaceLattice::cell(&pattern, 10e-6, 3), SpaceLattice::flat([4, 4], 3)] {
            let bonds = SpaceBonds::new(&lattice);
            let blocks = bonds.mass().len();
            let unknowns: Vec<(usize, usize)> = (0..3 * blocks)
                .map(|n| (n / 3, n % 3))
                .filter(|(n, c)| {
                    bonds.mass()[*n] > 0.0 && (*c < 2 || *n >= lattice.columns()[0] * lattice.columns()[1])
                })
                .collect();
            let mut matrix = nalgebra::DMatrix::<f64>::zeros(unknowns.len(), unknowns.len());
            let mut force = vec![[0.0; 3]; blocks + 1];
            for (column, (n, c)) in unknowns.iter().enumerate() {
                let mut u = vec![[0.0; 3]; blocks + 1];
                u[*n][*c] = 1.0;
                bonds.balance(&mut u, 0.0);
                bonds.forces(&u, &mut force);
                for (row, (m, d)) in unknowns.iter().enumerate() {
                    matrix[(row, column)] = -force[*m][*d] / (bonds.mass()[*n] * bonds.mass()[*m]).sqrt();
                }
            }
            assert!((&matrix - matrix.transpose()).abs().max() < 1e-12);
            let expected = matrix.symmetric_eigenvalues().max().sqrt();
            let found = largest_frequency(&lattice, false);
            assert!((found / expected - 1.0).abs() < 1e-3, "{found} {expected}");
        }
    }

    #[test]
    fn the_stability_limit_leaves_the_default_step_room() {
        // Inside the lattice, [100] waves of the shortest length have m w^2 = 12 k.
        let flat = largest_frequency(&SpaceLattice::flat([8, 8], 20), false);
        assert!(flat > 12.0_f64.sqrt() && flat < 4.5, "{flat}");
        let pattern = pattern(Planform::Square, 40.0, 80.0, 20.0);
        let patterned = largest_frequency(&SpaceLattice::cell(&pattern, 10e-6, 10), false);
        // Blocks at the edges of lands have a quarter of the mass and most of their springs.
        assert!(patterned > flat && patterned < 5.2, "{patterned}");
        assert!(SPACE_STEP < 0.45 * LEAPFROG_LIMIT / patterned);
    }
}
