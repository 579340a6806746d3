//! One dynamic run: builds the integrator, drives it through the protocol, records, reports.

use slipgrid_material::AreaLaw;

use super::contact::{ContactRow, LocalLaw};
use super::engine::{Engine, Setup};
use super::leapfrog::BondLeapfrog;
use super::protocol::{Protocol, RAMP_S, REST_S};
use super::recorder::{Recorder, WINDOW_START, WindowMean};
use super::runge_kutta::RungeKutta;
use super::scales::Scales;
use super::stability::largest_frequency;
use super::strip_leapfrog::StripLeapfrog;
use crate::SceneError;
use crate::draws;
use crate::lattice::Lattice;
use crate::monitor::Monitor;
use crate::outcome::{DynamicCost, InterfacePoint, Status, SurfaceOutcome};
use crate::scene::{Fidelity, Load, Scene, Springs};
use crate::steady::{SteadyLoad, SteadyModel};

/// Default step of the leapfrog over sqrt(m/k): 4 ns for the published polymer at l = 10 um, a third
/// of the stability limit; 0.04 % below the limit of short steps in dynamic mu, 0.2 % at twice the step.
///
/// Up to there the error is of second order. A block that starts is seen half a step late on average and has
/// then moved by a dt^2 / 8 already; without that its slip is too long by the share (omega dt)^2 / 8. Moving
/// it there at once turns the error's sign (+0.03 % and +0.09 %), interpolating the start in time doubles it:
/// neither is worth an account of work that no longer closes. The slip of a lone contact block lasts
/// pi/sqrt(5) of these units, three steps of 8.3 ns: with longer steps mu drops by 0.5 % at once.
const LEAPFROG_STEP: f64 = 0.2251;
/// Step of the reference integration, in seconds (paper).
const REFERENCE_STEP_S: f64 = 1e-9;
/// Stability limit of the leapfrog times the largest eigenfrequency.
const LEAPFROG_LIMIT: f64 = 2.0;
/// Stability limit of the classical Runge-Kutta method on the imaginary axis.
const RUNGE_KUTTA_LIMIT: f64 = 2.828;
/// Intervals in which the planned run is recorded.
const BINS: u64 = 2000;
/// Steps between two looks at the monitor.
const STEPS_PER_LOOK: u64 = 256;
/// A run that is extended until its standard error is small enough gives up after this many times the
/// planned travel.
const MOST_EXTENSION: u64 = 20;
/// Time after the rest that a run without motion is watched, in seconds.
const WATCH_AT_REST_S: f64 = 20e-6;
/// Most time steps of one run: a whole sample of 20,000 blocks takes about an hour for them, the paper's
/// run a quarter of a million. What would take more is not begun and says so.
pub const MOST_STEPS: u64 = 100_000_000;
/// Periods of the layer's first shear mode that an average must hold: one mode alone swings mu by a
/// tenth, and its mean over n periods departs by up to 1/(pi n) of that.
const LEAST_PERIODS: f64 = 10.0;

/// Steps that a run is planned to take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Steps of the ramp and the rest before the bulk moves.
    pub preparation: u64,
    /// Steps of the travel asked for.
    pub travel: u64,
}

impl Plan {
    /// The steps of `scene` at `step_s` seconds each.
    #[must_use]
    pub fn new(scene: &Scene, step_s: f64) -> Self {
        // The cast saturates: a number of steps beyond 2^64 stays beyond every limit.
        let steps_in = |time_s: f64| (time_s / step_s).ceil() as u64;
        let travel_s = if scene.speed_m_s > 0.0 { scene.run.sliding_m / scene.speed_m_s } else { WATCH_AT_REST_S };
        let preparation_s = if scene.run.warm_start { 0.0 } else { RAMP_S + REST_S };
        Self { preparation: steps_in(preparation_s), travel: steps_in(travel_s).max(1) }
    }

    /// All steps.
    #[must_use]
    pub const fn total(&self) -> u64 {
        self.preparation.saturating_add(self.travel)
    }
}

/// The integration scheme of a scene and its step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scheme {
    /// Spring law.
    pub springs: Springs,
    /// Runge-Kutta of order 4 instead of the leapfrog.
    pub runge_kutta: bool,
    /// Time step, in seconds.
    pub step_s: f64,
    /// Largest stable time step, in seconds.
    pub limit_s: f64,
}

impl Scheme {
    /// The scheme that `scene` asks for on `lattice`.
    ///
    /// # Errors
    /// [`SceneError::UnstableStep`] if the step is beyond the stability limit.
    pub fn choose(scene: &Scene, lattice: &Lattice) -> Result<Self, SceneError> {
        let scales = Scales::new(&scene.elastic, scene.layer.block_m);
        let runge_kutta = scene.run.fidelity == Fidelity::Reference;
        let (default_law, default_step_s, limit, name) = if runge_kutta {
            (Springs::Exact, REFERENCE_STEP_S, RUNGE_KUTTA_LIMIT, "Runge-Kutta method")
        } else {
            (Springs::Linear, LEAPFROG_STEP * scales.time_s, LEAPFROG_LIMIT, "leapfrog")
        };
        let limit_s = limit / largest_frequency(lattice, scene.run.liftoff) * scales.time_s;
        let step_s = scene.run.step_s.unwrap_or(default_step_s);
        if step_s > limit_s {
            return Err(SceneError::UnstableStep { step_s, limit_s, scheme: name });
        }
        Ok(Self { springs: scene.run.springs.unwrap_or(default_law), runge_kutta, step_s, limit_s })
    }
}

/// A surface under one load, ready to run.
pub struct DynamicRun<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The load.
    pub load: &'a Load,
    /// A plain lattice.
    pub lattice: &'a Lattice,
    /// How to integrate.
    pub scheme: Scheme,
    /// Threads that may work on it; what it finds does not depend on them.
    pub threads: usize,
    /// Share of all work that this run is, for the progress report.
    pub share: f64,
}

impl DynamicRun<'_> {
    /// Runs to the end.
    #[must_use]
    pub fn run(&self, monitor: &dyn Monitor) -> SurfaceOutcome {
        let scene = self.scene;
        if self.load.pressure_pa == 0.0 {
            return self.not_run(Status::NoLoad, monitor);
        }
        if Plan::new(scene, self.scheme.step_s).total() > MOST_STEPS {
            return self.not_run(Status::TooManySteps, monitor);
        }
        let scales = Scales::new(&scene.elastic, scene.layer.block_m);
        let coefficients = draws::draw(&self.load.friction, scene.run.seed, self.lattice.nx());
        let law = LocalLaw::new(scene.area_law.as_ref(), scales.pressure_pa);
        let setup = Setup {
            contact: ContactRow::new(self.lattice.contacts(), &coefficients, law),
            protocol: self.protocol(&scales),
            time_step: self.scheme.step_s / scales.time_s,
            damping: scene.run.damping,
            liftoff: scene.run.liftoff,
        };
        if self.scheme.runge_kutta {
            self.drive(RungeKutta::new(self.lattice, self.scheme.springs, setup), &scales, monitor)
        } else if self.scheme.springs == Springs::Exact {
            self.drive(BondLeapfrog::new(self.lattice, Springs::Exact, setup), &scales, monitor)
        } else {
            // One thread is the scope's own: without others nothing is spawned.
            std::thread::scope(|scope| {
                let engine = StripLeapfrog::new(self.lattice, setup).with_threads(scope, self.threads);
                self.drive(engine, &scales, monitor)
            })
        }
    }

    /// What is said of a run that was not begun, because nothing could come of it.
    fn not_run(&self, status: Status, monitor: &dyn Monitor) -> SurfaceOutcome {
        monitor.advance(self.share);
        let block_m = self.scene.layer.block_m;
        let cost = DynamicCost { steps: 0, dt_s: self.scheme.step_s, site_updates: 0, wall_s: 0.0 };
        let unsolved = SurfaceOutcome::unsolved(status, self.lattice.contacts().map(|i| (i as f64 + 0.5) * block_m));
        SurfaceOutcome { cost: Some(cost), ..unsolved }
    }

    fn protocol(&self, scales: &Scales) -> Protocol {
        let (ramp, start) = if self.scene.run.warm_start {
            (0.0, 0.0)
        } else {
            (RAMP_S / scales.time_s, (RAMP_S + REST_S) / scales.time_s)
        };
        Protocol {
            ramp,
            start,
            // load over k l = P L l / (k l), L in lattice spacings
            load: self.load.pressure_pa / scales.pressure_pa * self.lattice.length(),
            speed: self.scene.speed_m_s * scales.time_s / scales.length_m,
        }
    }

    /// Displacements of steady sliding over l, by row and column.
    fn steady_displacements(&self) -> Vec<[f64; 2]> {
        let run = &self.scene.run;
        let model = SteadyModel::new(
            self.lattice.clone(),
            self.scene.layer.block_m,
            self.scene.elastic.youngs_modulus_pa(),
            run.liftoff,
        );
        let dynamic_mu: Vec<f64> = draws::draw(&self.load.friction, run.seed, self.lattice.nx())
            .iter()
            .map(|drawn| drawn.dynamic_mu)
            .collect();
        model.displacements(&SteadyLoad {
            pressure_pa: self.load.pressure_pa,
            dynamic_mu: &dynamic_mu,
            area_law: self.scene.area_law.as_ref(),
        })
    }

    fn drive(&self, mut engine: impl Engine, scales: &Scales, monitor: &dyn Monitor) -> SurfaceOutcome {
        let run = &self.scene.run;
        let started_s = monitor.seconds();
        if run.warm_start {
            let displacements = self.steady_displacements();
            let nx = self.lattice.nx();
            engine.start_sheared(&|i, j| displacements[j * nx + i]);
        }
        let Plan { preparation, travel: planned } = Plan::new(self.scene, self.scheme.step_s);
        let steps_per_bin = planned.div_ceil(BINS).max(1);
        let window_bin = (WINDOW_START * planned as f64 / steps_per_bin as f64).ceil() as usize;
        let mut recorder = Recorder::new(self.lattice.contacts().count(), steps_per_bin, engine.time_step());
        let most =
            if run.mu_stderr.is_some() { planned.saturating_mul(MOST_EXTENSION).min(MOST_STEPS) } else { planned };

        let mut status = Status::Converged;
        let mut steps: u64 = 0;
        let share_per_step = self.share / (preparation + planned) as f64;
        loop {
            if steps.is_multiple_of(STEPS_PER_LOOK) {
                if steps > 0 && steps <= preparation + planned {
                    monitor.advance(share_per_step * STEPS_PER_LOOK as f64);
                }
                if monitor.cancelled() {
                    status = Status::Cancelled;
                    break;
                }
            }
            if steps >= preparation + planned {
                let driven = steps - preparation;
                let precise = match (run.mu_stderr, recorder.window_mean(window_bin)) {
                    (Some(wanted), Some(mean)) => mean.stderr <= wanted * mean.mu.abs(),
                    (Some(_), None) => false,
                    (None, _) => true,
                };
                // A longer run is judged anew after every tenth of the planned travel.
                if (precise && driven.is_multiple_of((planned / 10).max(1))) || run.mu_stderr.is_none() {
                    break;
                }
                if driven >= most {
                    status = Status::StderrNotReached;
                    break;
                }
            }
            if steps == preparation && !run.warm_start {
                engine.begin_drive();
            }
            let sums = engine.step();
            steps += 1;
            if !(sums.friction.is_finite() && sums.normal.is_finite()) {
                status = Status::Diverged;
                break;
            }
            if steps > preparation {
                recorder.record(sums, &mut engine, window_bin);
            }
        }
        let cost = DynamicCost {
            steps,
            dt_s: self.scheme.step_s,
            site_updates: steps * engine.evaluations_per_step() * (self.lattice.nx() * self.lattice.ny()) as u64,
            wall_s: monitor.seconds() - started_s,
        };
        let mean = recorder.window_mean(window_bin);
        if status == Status::Converged {
            let window = |mean: &WindowMean| (steps - preparation) as f64 * engine.time_step() - mean.from;
            status = match &mean {
                None => Status::NoOnset,
                Some(mean) if window(mean) < LEAST_PERIODS * shear_period(self.lattice) => Status::ShortWindow,
                // Sums of nothing but zeros.
                Some(mean) if mean.mu == 0.0 && mean.stderr == 0.0 => Status::NoFriction,
                Some(_) => Status::Converged,
            };
        }
        self.observe(engine, &recorder, status, mean, cost, scales)
    }

    fn observe(
        &self,
        mut engine: impl Engine,
        recorder: &Recorder,
        status: Status,
        mean: Option<WindowMean>,
        cost: DynamicCost,
        scales: &Scales,
    ) -> SurfaceOutcome {
        let last = engine.contact_forces();
        engine.finish();
        let mut interface: Vec<InterfacePoint> = self
            .lattice
            .contacts()
            .zip(recorder.interface(&last))
            .map(|(column, mean)| InterfacePoint {
                x_m: (column as f64 + 0.5) * scales.length_m,
                y_m: 0.0,
                pressure_pa: mean.normal * scales.pressure_pa,
                friction_pa: mean.friction * scales.pressure_pa,
            })
            .collect();
        if status == Status::Diverged {
            // Forces of a state that is no longer finite mean nothing.
            for point in &mut interface {
                (point.pressure_pa, point.friction_pa) = (0.0, 0.0);
            }
        }
        let reached = mean.filter(|_| status != Status::Diverged && status != Status::Cancelled);
        let law: Option<&AreaLaw> = self.scene.area_law.as_ref();
        let peak_pressure_pa = interface.iter().map(|point| point.pressure_pa).fold(0.0, f64::max);
        SurfaceOutcome {
            status,
            mu_dynamic: reached.map(|mean| mean.mu),
            mu_dynamic_stderr: reached.map(|mean| mean.stderr),
            averaged_from_s: reached.map(|mean| mean.from * scales.time_s),
            mu_static: if self.scene.run.warm_start { None } else { recorder.peak_mu() },
            peak_pressure_pa,
            tension_blocks: last.iter().filter(|force| force.normal < 0.0).count(),
            cavity_closed: self.is_closed(&engine),
            area_law_extrapolated: law.is_some_and(|law| law.is_extrapolated(peak_pressure_pa)),
            residual: None,
            iterations: 0,
            cost: Some(cost),
            interface,
            trace: recorder.trace(scales.time_s),
        }
    }

    /// Whether a ceiling lies on or below the counterface at the end of the run.
    fn is_closed(&self, engine: &impl Engine) -> bool {
        self.lattice
            .columns()
            .iter()
            .enumerate()
            // A layer of one row may be cut through: nothing is left that could sag.
            .filter(|(i, column)| !column.is_land() && self.lattice.lowest_row(*i) < self.lattice.ny())
            .any(|(i, column)| column.cavity_rows + engine.rise(i, self.lattice.lowest_row(i)) <= 0.0)
    }
}

/// Period of the layer's first shear mode over sqrt(m/k): 4 h / c_s, c_s = sqrt(C66/rho) = sqrt(1/2) l sqrt(k/m).
fn shear_period(lattice: &Lattice) -> f64 {
    4.0 * lattice.ny() as f64 * std::f64::consts::SQRT_2
}
