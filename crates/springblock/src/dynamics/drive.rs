//! Drives an integrator through the protocol: steps, records, decides when to stop.

use super::contact::ContactForce;
use super::engine::Engine;
use super::protocol::{RAMP_S, REST_S};
use super::recorder::{Recorder, WindowMean};
use super::scales::Scales;
use crate::Monitor;
use crate::dimension::Dimension;
use crate::outcome::{DynamicCost, InterfacePoint, Status, SurfaceOutcome};
use crate::scene::{Layer, Load, RunOptions, Scene};
use slipgrid_material::{AreaLaw, Elastic};

/// Intervals in which the planned run is recorded.
const BINS: u64 = 2000;
/// Steps between two looks at the monitor.
const STEPS_PER_LOOK: u64 = 64;
/// Share of the planned travel after which the interface is sampled.
const INTERFACE_FROM: f64 = 0.6;
/// A run whose mu is not stationary goes on, up to so many times the planned travel.
const MAX_EXTENSION: u64 = 4;
/// The same of a run that goes on until its standard error is small enough.
pub const MAX_EXTENSION_FOR_STDERR: u64 = 20;
/// Share of sliding friction beyond which what waves take away is no error any more, but makes a run
/// [`Status::SlidingWaves`].
pub const WAVE_DEFICIT: f64 = 0.01;
/// Time after the rest that a run without motion is watched, in seconds.
const WATCH_AT_REST_S: f64 = 20e-6;
/// Most time steps of one run: a whole sample of 20,000 blocks takes about an hour for them, the paper's
/// run a quarter of a million. What would take more is not begun and says so.
pub const MAX_STEPS: u64 = 100_000_000;
/// Periods of the layer's first shear mode that an average must hold: one mode alone swings mu by a
/// tenth, and its mean over n periods departs by up to 1/(pi n) of that.
const MIN_PERIODS: f64 = 10.0;

/// Periods of the layer's first shear mode, and slips of a block, that a warm run is planned for at least: with the usual
/// layer the mean is then known to 0.1 %, and the ratio of two surfaces with the same coefficients off by 0.03 %
/// (`the_confirming_run_is_as_long_as_its_error_asks_for`).
const WARM_PERIODS: f64 = 25.0;
const WARM_SLIPS: f64 = 25.0;

/// Shear modulus of the plane's blocks, in pascals: G = 3 E / 8.
#[must_use]
pub fn shear_modulus_pa(elastic: &Elastic) -> f64 {
    0.375 * elastic.youngs_modulus_pa()
}

/// Period of the first shear mode of a layer `height_m` high whose upper side is held, in seconds: T = 4 h / c_s,
/// c_s = sqrt(G / rho).
#[must_use]
pub fn shear_period_s(elastic: &Elastic, height_m: f64) -> f64 {
    4.0 * height_m / (shear_modulus_pa(elastic) / elastic.density_kg_m3()).sqrt()
}

/// Of P / sqrt(E rho): how fast a layer slides evenly.
const EVEN_SLIDING: f64 = 0.01;
/// How many times faster than that a speed may be that a run at that speed still stands for.
const MAX_SLOWED: f64 = 10.0;

/// Speed of a run in time that stands for sliding at `speed_m_s` under the pressure `pressure_pa`, in m/s: that speed, or the fastest at
/// which the layer slides evenly,
///
/// ```text
/// v = 0.01 P / sqrt(E rho)
/// ```
///
/// where it is up to ten times as fast. Beyond that nothing slower stands for it.
///
/// Faster, waves run along its contact. How large they grow hangs on the damping, and they take from friction what a patterned surface, whose
/// lands are shorter, keeps: of PEEK under 1 MPa the flat sample loses 0.5, 1.5 and 2.0 % at 1, 2 and 2.7 times this speed against a sixth of
/// it, and the ratio of a groove rises by 0.003, 0.012 and 0.017. From three times this speed on waves rule ([`Status::SlidingWaves`]).
#[must_use]
pub fn run_speed_m_s(elastic: &Elastic, pressure_pa: f64, speed_m_s: f64) -> f64 {
    if is_too_fast(elastic, pressure_pa, speed_m_s) {
        speed_m_s
    } else {
        speed_m_s.min(even_speed_m_s(elastic, pressure_pa))
    }
}

/// Whether sliding at `speed_m_s` under `pressure_pa` is so fast that no run stands for it: waves rule, whatever a run's mean says.
#[must_use]
pub fn is_too_fast(elastic: &Elastic, pressure_pa: f64, speed_m_s: f64) -> bool {
    speed_m_s > max_run_speed_m_s(elastic, pressure_pa)
}

/// The fastest speed that a run in time under `pressure_pa` stands for, in m/s: ten times that of even sliding.
#[must_use]
pub fn max_run_speed_m_s(elastic: &Elastic, pressure_pa: f64) -> f64 {
    MAX_SLOWED * even_speed_m_s(elastic, pressure_pa)
}

/// The fastest speed at which the layer slides evenly under `pressure_pa`: v = 0.01 P / sqrt(E rho), in m/s.
#[must_use]
pub fn even_speed_m_s(elastic: &Elastic, pressure_pa: f64) -> f64 {
    EVEN_SLIDING * pressure_pa / (elastic.youngs_modulus_pa() * elastic.density_kg_m3()).sqrt()
}

/// Travel of the bulk that a run from the sheared layer needs for a mean, in metres, rounded up to nanometres:
///
/// ```text
/// u = max(25 T v, 25 d),     d = 2 (mu_s - mu_d) f(P) P l / E
/// ```
///
/// with the period T of the layer's first shear mode ([`shear_period_s`]) and the slip d of a block of size l, the largest over
/// `loads`.
#[must_use]
pub fn warm_travel_m(
    (elastic, area_law): (&Elastic, Option<&AreaLaw>),
    layer: &Layer,
    loads: &[Load],
    speed_m_s: f64,
) -> f64 {
    let stiffness_pa = elastic.youngs_modulus_pa();
    let period_s = shear_period_s(elastic, layer.height_m);
    let slip_m = |load: &Load| {
        let drop = (load.friction.static_mean() - load.friction.dynamic_mean()).max(0.0);
        let factor = area_law.map_or(1.0, |law| law.factor(load.pressure_pa));
        2.0 * drop * factor * load.pressure_pa / stiffness_pa * layer.block_m
    };
    let slips_m = WARM_SLIPS * loads.iter().map(slip_m).fold(0.0, f64::max);
    ((WARM_PERIODS * period_s * speed_m_s).max(slips_m) * 1e9).ceil().max(1.0) * 1e-9
}

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

    /// Steps after which a run longer than planned is judged anew: a tenth of the planned travel.
    fn tenth(&self) -> u64 {
        (self.travel / 10).max(1)
    }

    /// Steps from step `steps` on up to where the monitor is looked at, the bulk begins to move, or the run is judged.
    fn steps_to_next_turn(&self, steps: u64) -> u64 {
        let to_turn = match steps.checked_sub(self.preparation) {
            None => self.preparation - steps,
            Some(driven) if driven < self.travel => self.travel - driven,
            Some(driven) => self.tenth() - driven % self.tenth(),
        };
        to_turn.min(STEPS_PER_LOOK - steps % STEPS_PER_LOOK)
    }

    /// All steps.
    #[must_use]
    pub const fn total(&self) -> u64 {
        self.preparation.saturating_add(self.travel)
    }
}

/// One run of an integrator.
#[derive(Clone, Copy, Debug)]
pub struct Drive<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The nominal pressure of the run, in pascals.
    pub pressure_pa: f64,
    /// Time step, in seconds.
    pub step_s: f64,
    /// Share of all work that this run is, for the progress report.
    pub share: f64,
    /// Standard error over dynamic mu at which the run may end, after the planned travel.
    pub stderr_share: Option<f64>,
    /// Blocks of the lattice.
    pub blocks: u64,
    /// Period of the layer's first shear mode over sqrt(m/k).
    pub shear_period: f64,
    /// The monitor's clock when the run was set up.
    pub started_s: f64,
}

/// A run that has ended.
#[derive(Clone, Debug)]
pub struct Driven {
    /// How it ended.
    pub status: Status,
    /// What was recorded.
    pub recorder: Recorder,
    /// Mean of mu over the window, if there is one.
    pub mean: Option<WindowMean>,
    /// What it cost.
    pub cost: DynamicCost,
    /// Forces on the contact blocks at the last instant.
    pub last: Vec<ContactForce>,
}

/// The outcome of a run on contact blocks at `centres_m` that was refused with `status` before its first step.
pub fn not_begun(status: Status, step_s: f64, centres_m: impl Iterator<Item = [f64; 2]>) -> SurfaceOutcome {
    let cost = DynamicCost { steps: 0, dt_s: step_s, site_updates: 0, wall_s: 0.0 };
    let at = |[x_m, y_m]: [f64; 2]| InterfacePoint { x_m, y_m, pressure_pa: 0.0, friction_pa: 0.0 };
    let interface = centres_m.map(at).collect();
    SurfaceOutcome { cost: Some(cost), interface, ..SurfaceOutcome::unsolved(status, std::iter::empty()) }
}

impl Drive<'_> {
    /// Runs `engine` from its start to the end.
    pub fn run(&self, engine: &mut impl Engine, monitor: &dyn Monitor) -> Driven {
        let plan = Plan::new(self.scene, self.step_s);
        let Plan { preparation, travel: planned } = plan;
        let steps_per_bin = planned.div_ceil(BINS).max(1);
        let interface_from = (INTERFACE_FROM * planned as f64 / steps_per_bin as f64).ceil() as usize;
        let least_time = MIN_PERIODS * self.shear_period;
        let mut recorder =
            Recorder::new(engine.contacts(), steps_per_bin, engine.time_step(), least_time, interface_from);
        let extension = if self.stderr_share.is_some() { MAX_EXTENSION_FOR_STDERR } else { MAX_EXTENSION };
        let most = planned.saturating_mul(extension).min(MAX_STEPS.max(planned));

        let mut status;
        let mut steps: u64 = 0;
        let share_per_step = self.share / (preparation + planned) as f64;
        'run: loop {
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
                if driven == planned || driven.is_multiple_of(plan.tenth()) {
                    let said = self.judge(recorder.window_mean().as_ref());
                    if said == Status::Converged || driven >= most || self.is_at_rest() {
                        status = said;
                        break;
                    }
                    if said != Status::StderrNotReached {
                        recorder.forget_interface();
                    }
                }
            }
            if steps == preparation && !self.scene.run.warm_start {
                engine.begin_drive();
            }
            let alone = plan.steps_to_next_turn(steps);
            let alone = if steps < preparation { alone } else { alone.min(recorder.steps_to_next_question()) };
            let (first, second) = if alone > 1 { engine.one_or_two_steps() } else { (engine.step(), None) };
            for sums in std::iter::once(first).chain(second) {
                steps += 1;
                if !sums.is_finite() {
                    status = Status::Diverged;
                    break 'run;
                }
                if steps > preparation {
                    recorder.record(sums, engine);
                }
            }
        }
        let cost = DynamicCost {
            steps,
            dt_s: self.step_s,
            site_updates: steps * engine.evaluations_per_step() * self.blocks,
            wall_s: monitor.seconds() - self.started_s,
        };
        let mean = recorder.window_mean();
        if let (Status::Converged | Status::StderrNotReached, Some(mean)) = (status, &mean) {
            // What is not known well enough must be missing by more than its error.
            let unknown = if status == Status::Converged { 0.0 } else { 2.0 * mean.stderr / mean.mu.abs() };
            if mean.mu == 0.0 && mean.stderr == 0.0 {
                // Sums of nothing but zeros.
                status = Status::NoFriction;
            } else if mean.excess.is_some_and(|excess| excess < -(WAVE_DEFICIT + unknown)) || self.is_too_fast() {
                status = Status::SlidingWaves;
            }
        }
        let last = engine.contact_forces();
        Driven { status, recorder, mean, cost, last }
    }

    /// Whether waves rule, whatever the mean says: stronger damping than the usual one may hold them down.
    fn is_too_fast(&self) -> bool {
        let run = &self.scene.run;
        run.damping <= RunOptions::default().damping
            && is_too_fast(&self.scene.elastic, self.pressure_pa, self.scene.speed_m_s)
    }

    /// What a run with `mean` is: converged, or why it goes on.
    fn judge(&self, mean: Option<&WindowMean>) -> Status {
        match mean {
            None => Status::NoOnset,
            Some(mean) if !mean.is_stationary => Status::ShortWindow,
            Some(mean) if self.stderr_share.is_some_and(|wanted| mean.stderr > wanted * mean.mu.abs()) => {
                Status::StderrNotReached
            }
            Some(_) => Status::Converged,
        }
    }

    /// Whether the bulk never moves: watching it longer changes nothing.
    fn is_at_rest(&self) -> bool {
        self.scene.speed_m_s == 0.0
    }
}

impl Driven {
    /// What is reported of the run; `centres_m`: where the contact blocks are, along x and y.
    #[must_use]
    pub fn outcome(
        &self,
        scene: &Scene,
        scales: &Scales,
        centres_m: impl Iterator<Item = [f64; 2]>,
        cavity_closed: bool,
    ) -> SurfaceOutcome {
        let Self { status, recorder, mean, cost, last } = self;
        // Forces of a state that is no longer finite mean nothing.
        let unit_pa = if *status == Status::Diverged { 0.0 } else { scales.pressure_pa };
        let in_pa = |force: f64| if unit_pa == 0.0 { 0.0 } else { force * unit_pa };
        let interface: Vec<InterfacePoint> = centres_m
            .zip(recorder.interface(last))
            .map(|([x_m, y_m], mean)| InterfacePoint {
                x_m,
                y_m,
                pressure_pa: in_pa(mean.normal),
                friction_pa: in_pa(mean.friction),
            })
            .collect();
        let reached = mean.filter(|_| *status != Status::Diverged && *status != Status::Cancelled);
        // What waves take away depends on more than a scene says: all of it is an error.
        let waves = |mean: WindowMean| mean.mu * mean.excess.map_or(0.0, |excess| (-excess).max(0.0));
        let peak_pressure_pa = interface.iter().map(|point| point.pressure_pa).fold(0.0, f64::max);
        SurfaceOutcome {
            status: *status,
            mu_dynamic: reached.map(|mean| mean.mu),
            mu_dynamic_stderr: reached.map(|mean| mean.stderr.hypot(waves(mean))),
            stick_slip_excess: reached.and_then(|mean| mean.excess),
            mu_across: reached.map(|mean| mean.mu_across).filter(|_| scene.dimension() == Dimension::Space),
            averaged_from_s: reached.map(|mean| mean.from * scales.time_s),
            mu_static: if scene.run.warm_start { None } else { recorder.peak_mu() },
            peak_pressure_pa,
            tension_blocks: last.iter().filter(|force| force.normal < 0.0).count(),
            cavity_closed,
            clearance_m: None,
            area_law_extrapolated: scene.area_law.as_ref().is_some_and(|law| law.is_extrapolated(peak_pressure_pa)),
            residual: None,
            iterations: 0,
            cost: Some(*cost),
            interface,
            trace: recorder.trace(scales.time_s),
        }
    }
}

#[cfg(test)]
mod tests;
