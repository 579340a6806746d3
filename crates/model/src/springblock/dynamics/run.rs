//! One dynamic run in the plane: creates the integrator, drives it through the protocol, and returns the outcome.

use std::sync::OnceLock;

use super::contact::{ContactRow, LocalLaw};
use super::drive::{Drive, refusal, refused_outcome};
use super::engine::{PlaneEngine, Setup};
use super::leapfrog::BondLeapfrog;
use super::protocol::Protocol;
use super::runge_kutta::RungeKutta;
use super::scales::Scales;
use super::space::SPACE_STEP;
use super::stability::largest_frequency;
use super::strip_leapfrog::StripLeapfrog;
use crate::springblock::rims::PLANE_STRAIN;
use crate::springblock::{
    Fidelity, Lattice, Load, Monitor, Scene, SceneError, Springs, SteadyLoad, SteadyModel, SurfaceOutcome, draws,
};

/// Default time step of the leapfrog in units of sqrt(m/k), with block mass m and spring stiffness k: 6 ns for the
/// published polymer at a lattice spacing of 10 um, half of the stability limit. The dynamic friction coefficient is
/// then 0.03 % below the limit of short steps, and the ratio of the patterned to the flat surface has reached its limit
/// (`tests/validation/excess.rs`).
///
/// Up to this step the length of slips is accurate ([`super::contact`]): the slip of a single contact block lasts
/// pi/sqrt(5) of these units, four steps. At 8 ns the dynamic friction coefficient is 0.08 % too low; at 10 ns, with
/// five steps for two slips, it is 0.1 % too high.
const LEAPFROG_STEP: f64 = 0.3376;
/// Time step of the reference integration, in seconds, as in the paper.
const REFERENCE_STEP_S: f64 = 1e-9;
/// Largest eigenfrequency times the step at the stability limit of the leapfrog.
const LEAPFROG_LIMIT: f64 = 2.0;
/// Largest eigenfrequency times the step at the stability limit of the classical Runge-Kutta method.
const RUNGE_KUTTA_LIMIT: f64 = 2.828;
/// Integration scheme of a scene, and its time step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scheme {
    /// Force law of the springs.
    pub springs: Springs,
    /// Whether the Runge-Kutta method of order 4 replaces the leapfrog.
    pub runge_kutta: bool,
    /// Time step, in seconds.
    pub step_s: f64,
    /// Largest stable time step, in seconds.
    pub limit_s: f64,
}

impl Scheme {
    /// Default time step of `scene`, in seconds.
    pub fn default_step_s(scene: &Scene) -> f64 {
        match scene.run.fidelity {
            Fidelity::Reference => REFERENCE_STEP_S,
            _ => LEAPFROG_STEP * Scales::new(&scene.elastic, scene.layer.block_m).time_s,
        }
    }

    /// Chooses the scheme that `scene` requests on `lattice`.
    ///
    /// # Errors
    /// [`SceneError::UnstableStep`] if the step exceeds the stability limit.
    pub fn choose(scene: &Scene, lattice: &Lattice) -> Result<Self, SceneError> {
        let scales = Scales::new(&scene.elastic, scene.layer.block_m);
        let runge_kutta = scene.run.fidelity == Fidelity::Reference;
        let (default_law, limit, name) = if runge_kutta {
            (Springs::Exact, RUNGE_KUTTA_LIMIT, "Runge-Kutta method")
        } else {
            (Springs::Linear, LEAPFROG_LIMIT, "leapfrog")
        };
        let liftoff = scene.run.liftoff || lattice.is_raised();
        let limit_s = limit / largest_frequency(lattice, liftoff) * scales.time_s;
        let step_s = scene.run.step_s.unwrap_or_else(|| Self::default_step_s(scene));
        if step_s > limit_s {
            return Err(SceneError::UnstableStep { step_s, limit_s, scheme: name });
        }
        Ok(Self { springs: scene.run.springs.unwrap_or(default_law), runge_kutta, step_s, limit_s })
    }
}

/// Default time step of a dynamic run of `scene`, in seconds: in space if `is_spatial`, otherwise in the plane.
pub fn default_step_s(scene: &Scene, is_spatial: bool) -> f64 {
    if is_spatial {
        SPACE_STEP * Scales::space(&scene.elastic, scene.layer.block_m).time_s
    } else {
        Scheme::default_step_s(scene)
    }
}

/// A dynamic run of one surface under one load.
pub struct DynamicRun<'a> {
    pub scene: &'a Scene,
    pub load: &'a Load,
    /// Regular lattice of whole blocks.
    pub lattice: &'a Lattice,
    /// Equations of steady sliding on the lattice, created by the first run that starts from steady sliding.
    pub steady: &'a OnceLock<SteadyModel>,
    /// Integration scheme.
    pub scheme: Scheme,
    /// Number of threads; the result does not depend on it.
    pub threads: usize,
    /// Fraction of the whole job's work that this run takes, for the progress report.
    pub share: f64,
    /// Random seed of the local friction coefficients.
    pub seed: u64,
    /// Standard error of the mean dynamic friction coefficient, relative to this mean, at which the run may end; `None`
    /// if no standard error is requested.
    pub stderr_share: Option<f64>,
}

impl DynamicRun<'_> {
    pub fn run(&self, monitor: &dyn Monitor) -> SurfaceOutcome {
        let scene = self.scene;
        if let Some(status) = refusal(scene, self.load, self.scheme.step_s) {
            monitor.advance(self.share);
            return refused_outcome(status, self.scheme.step_s, self.centres_m());
        }
        let scales = Scales::new(&scene.elastic, scene.layer.block_m);
        let coefficients = draws::draw(&self.load.friction, self.seed, self.lattice.nx());
        let law = LocalLaw::new(scene.area_law.as_ref(), scales.pressure_pa);
        let started_s = monitor.seconds();
        let start = self.start();
        let mut contact = ContactRow::new(self.lattice.contacts(), &coefficients, law);
        if let Some(start) = start.as_ref().filter(|_| self.lattice.is_raised()) {
            contact.place(|i| [self.lattice.columns()[i].relief, start[i][1]]);
        }
        let setup = Setup {
            contact,
            direction: [1.0],
            // load over k l = P L l / (k l), L in lattice spacings
            protocol: Protocol::new(scene, &scales, self.load.pressure_pa / scales.pressure_pa * self.lattice.length()),
            time_step: self.scheme.step_s / scales.time_s,
            damping: scene.run.damping,
            liftoff: scene.run.liftoff || self.lattice.is_raised(),
        };
        let start = start.as_deref();
        if self.scheme.runge_kutta {
            self.drive(RungeKutta::new(self.lattice, self.scheme.springs, setup), start, started_s, monitor)
        } else if self.scheme.springs == Springs::Exact {
            self.drive(BondLeapfrog::new(self.lattice, Springs::Exact, setup), start, started_s, monitor)
        } else {
            // The drive itself uses one thread; with one thread no other is spawned.
            std::thread::scope(|scope| {
                let sliding = start.filter(|_| scene.run.warm_start);
                match sliding.and_then(|base| StripLeapfrog::from_sliding(self.lattice, setup.clone(), base)) {
                    Some(engine) => self.drive(engine.with_threads(scope, self.threads), None, started_s, monitor),
                    None => {
                        let engine = StripLeapfrog::new(self.lattice, setup);
                        self.drive(engine.with_threads(scope, self.threads), start, started_s, monitor)
                    }
                }
            })
        }
    }

    fn centres_m(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        self.lattice.contacts().map(|column| [(column as f64 + 0.5) * self.scene.layer.block_m, 0.0])
    }

    /// Displacements x and y, in lattice spacings, of the layer in equilibrium with sliding friction, every block at a
    /// random phase of its stick-slip cycle; index j * nx + i for column i of row j.
    fn sheared_displacements(&self) -> Vec<[f64; 2]> {
        let model = self.steady.get_or_init(|| SteadyModel::for_scene(self.scene, self.lattice.clone()));
        let drawn = draws::draw(&self.load.friction, self.seed, self.lattice.nx());
        model.displacements(&SteadyLoad {
            pressure_pa: self.load.pressure_pa,
            dynamic_mu: &draws::random_phase_friction(&drawn, self.seed),
            area_law: self.scene.area_law.as_ref(),
        })
    }

    /// Initial displacements x and y, in lattice spacings, with index j * nx + i for column i of row j. A warm start
    /// has the displacements of sliding; an unloaded layer with face heights touches with its highest point; `None` for
    /// an unloaded flat layer.
    fn start(&self) -> Option<Vec<[f64; 2]>> {
        if self.scene.run.warm_start {
            return Some(self.sheared_displacements());
        }
        let contacts = || self.lattice.contacts().map(|i| self.lattice.columns()[i].relief);
        let highest = contacts().fold(f64::NEG_INFINITY, f64::max);
        self.lattice.is_raised().then(|| vec![[0.0, highest]; self.lattice.nx() * self.lattice.ny()])
    }

    /// Drives `engine`, which begins at the displacements `start`, or at its present state if `start` is `None`.
    /// `started_s` is the time of the monitor's clock, in seconds, at which the run was set up.
    fn drive(
        &self,
        mut engine: impl PlaneEngine,
        start: Option<&[[f64; 2]]>,
        started_s: f64,
        monitor: &dyn Monitor,
    ) -> SurfaceOutcome {
        let scales = Scales::new(&self.scene.elastic, self.scene.layer.block_m);
        if let Some(start) = start {
            let nx = self.lattice.nx();
            engine.start_sheared(&|i, j| start[j * nx + i]);
        }
        let drive = Drive {
            scene: self.scene,
            pressure_pa: self.load.pressure_pa,
            step_s: self.scheme.step_s,
            time_step: self.scheme.step_s / scales.time_s,
            evaluations_per_step: if self.scheme.runge_kutta { 4 } else { 1 },
            share: self.share,
            stderr_share: self.stderr_share,
            blocks: (self.lattice.nx() * self.lattice.ny()) as u64,
            shear_period: shear_period(self.lattice),
            started_s,
        };
        let driven = drive.run(&mut engine, monitor);
        engine.finish();
        driven.outcome(self.scene, &scales, self.centres_m(), self.is_closed(&engine))
    }

    /// Whether the ceiling of a cavity touches the counterface at the end of the run.
    fn is_closed(&self, engine: &impl PlaneEngine) -> bool {
        self.lattice
            .columns()
            .iter()
            .enumerate()
            // In a column that is cavity in all rows there is no ceiling.
            .filter(|(i, column)| !column.is_land() && self.lattice.lowest_row(*i) < self.lattice.ny())
            .any(|(i, column)| column.cavity_rows + engine.rise(i, self.lattice.lowest_row(i)) / PLANE_STRAIN <= 0.0)
    }
}

/// Period of the layer's first shear mode in units of sqrt(m/k): 4 h / c_s with the layer height h and the speed of
/// shear waves c_s = sqrt(C66/rho) = sqrt(1/2) l sqrt(k/m), where m is the block mass, k the spring stiffness and l the
/// lattice spacing.
fn shear_period(lattice: &Lattice) -> f64 {
    4.0 * lattice.ny() as f64 * std::f64::consts::SQRT_2
}
