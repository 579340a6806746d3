//! Drives an integrator through the protocol: steps, records, and decides when to stop.

use super::contact::ContactForce;
use super::engine::Engine;
use super::protocol::{RAMP_S, REST_S};
use super::recorder::{Recorder, WindowMean};
use super::scales::Scales;
use crate::material::{AreaLaw, Elastic};
use crate::springblock::{
    Dimension, DynamicCost, InterfacePoint, Layer, Load, Monitor, RunOptions, Scene, Status, SurfaceOutcome,
};

/// Number of recording intervals in the planned travel.
const BINS: u64 = 2000;
/// Number of steps between two checks of the monitor.
const STEPS_PER_MONITOR_CHECK: u64 = 64;
/// Fraction of the planned travel from which on the contact forces are averaged for the interface.
const INTERFACE_FROM: f64 = 0.6;
/// Maximum travel of a run as a multiple of the planned travel, for runs that continue until the friction coefficient
/// is stationary.
const MAX_EXTENSION: u64 = 4;
/// Maximum travel of a run as a multiple of the planned travel, for runs that continue until a requested standard error
/// of the friction coefficient is reached.
pub const MAX_EXTENSION_FOR_STDERR: u64 = 20;
/// Maximum loss of friction to sliding waves that counts as an error of the mean, relative to friction with every block
/// sliding. A run with a greater loss has the status [`Status::SlidingWaves`].
pub const WAVE_DEFICIT: f64 = 0.01;
/// Duration of the observation after the rest under load if the bulk has zero speed, in seconds.
const REST_OBSERVATION_S: f64 = 20e-6;
/// Maximum number of time steps of one run; longer runs are refused. This number takes about an hour for a whole sample
/// of 20,000 blocks; the paper's run has a quarter of a million steps.
pub const MAX_STEPS: u64 = 100_000_000;
/// Minimum averaging time in periods of the layer's first shear mode. That mode alone makes the friction coefficient
/// oscillate by a tenth, and a mean over n periods deviates by up to 1/(pi n) of the amplitude.
const MIN_PERIODS: f64 = 10.0;

/// Minimum duration of the planned travel of a warm run, which starts from the sheared layer, in periods of the layer's
/// first shear mode.
///
/// With the usual layer the mean is then known to 0.1 %, and the ratio of two surfaces with the same coefficients is
/// off by 0.03 % (`the_confirming_run_is_as_long_as_its_error_asks_for`).
const WARM_PERIODS: f64 = 12.5;
/// Minimum planned travel of a warm run, as a multiple of the slip length of a block; accuracy as at `WARM_PERIODS`.
const WARM_SLIPS: f64 = 12.5;

/// Shear modulus of the plane lattice, G = 3 E / 8, in pascals.
pub fn shear_modulus_pa(elastic: &Elastic) -> f64 {
    0.375 * elastic.youngs_modulus_pa()
}

/// Period of the first shear mode of a layer `height_m` high with its upper side held, in seconds: T = 4 h / c_s, c_s =
/// sqrt(G / rho).
pub fn shear_period_s(elastic: &Elastic, height_m: f64) -> f64 {
    4.0 * height_m / (shear_modulus_pa(elastic) / elastic.density_kg_m3()).sqrt()
}

/// Maximum speed of sliding without waves along the contact, in units of P / sqrt(E rho), with the pressure P, Young's
/// modulus E and the density rho; found as described at [`run_speed_m_s`].
const EVEN_SLIDING_SPEED: f64 = 0.01;
/// Maximum ratio of a sliding speed to the lower speed of the dynamic run that represents it.
const MAX_SPEED_RATIO: f64 = 10.0;

/// Speed of a dynamic run that represents sliding at `speed_m_s` under the pressure `pressure_pa`, in m/s.
///
/// This is `speed_m_s`, but at most the maximum speed of even sliding, without waves along the contact,
///
/// ```text
/// v = 0.01 P / sqrt(E rho)
/// ```
///
/// with the pressure P, Young's modulus E and the density rho. Sliding at more than ten times v is run at its own
/// speed.
///
/// Above v, waves run along the contact. Their amplitude depends on the damping, and they reduce the friction of a flat
/// surface more than that of a patterned surface, whose lands are shorter. For PEEK under 1 MPa the flat sample loses
/// 0.5, 1.5 and 2.0 % at 1, 2 and 2.7 times v compared with v/6, and the ratio of a groove rises by 0.003, 0.012 and
/// 0.017. From 3 v on, waves dominate ([`Status::SlidingWaves`]).
pub fn run_speed_m_s(elastic: &Elastic, pressure_pa: f64, speed_m_s: f64) -> f64 {
    if is_too_fast(elastic, pressure_pa, speed_m_s) {
        speed_m_s
    } else {
        speed_m_s.min(even_speed_m_s(elastic, pressure_pa))
    }
}

/// Whether sliding at `speed_m_s` under `pressure_pa` is too fast for a dynamic run: more than ten times as fast as
/// even sliding, so that waves dominate.
pub fn is_too_fast(elastic: &Elastic, pressure_pa: f64, speed_m_s: f64) -> bool {
    speed_m_s > max_run_speed_m_s(elastic, pressure_pa)
}

/// Maximum sliding speed that a dynamic run under `pressure_pa` represents, in m/s: ten times that of
/// [`even_speed_m_s`].
pub fn max_run_speed_m_s(elastic: &Elastic, pressure_pa: f64) -> f64 {
    MAX_SPEED_RATIO * even_speed_m_s(elastic, pressure_pa)
}

/// Maximum speed of even sliding, without waves along the contact, under the pressure P = `pressure_pa`: v = 0.01 P /
/// sqrt(E rho), in m/s.
pub fn even_speed_m_s(elastic: &Elastic, pressure_pa: f64) -> f64 {
    EVEN_SLIDING_SPEED * pressure_pa / (elastic.youngs_modulus_pa() * elastic.density_kg_m3()).sqrt()
}

/// Travel of the bulk that a run from the sheared layer needs for its mean, in metres, rounded up to nanometres:
///
/// ```text
/// u = max(12.5 T v, 12.5 d),     d = 2 (mu_s - mu_d) f(P) P l / E
/// ```
///
/// T is the period of the layer's first shear mode ([`shear_period_s`]), v the sliding speed, and d the maximum over
/// `loads` of the slip of a block of size l. mu_s and mu_d are the static and the dynamic friction coefficient, f is
/// the area factor at the pressure P, and E is Young's modulus.
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

/// Planned numbers of time steps of a dynamic run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Number of steps of the pressure ramp and the rest before the bulk moves.
    pub preparation: u64,
    /// Number of steps of the requested travel of the bulk.
    pub travel: u64,
}

impl Plan {
    /// Plans the steps of `scene` for a step of `step_s` seconds.
    pub fn new(scene: &Scene, step_s: f64) -> Self {
        // The cast saturates: a number beyond 2^64 exceeds every limit.
        let steps_in = |time_s: f64| (time_s / step_s).ceil() as u64;
        let travel_s = if scene.speed_m_s > 0.0 { scene.run.sliding_m / scene.speed_m_s } else { REST_OBSERVATION_S };
        let preparation_s = if scene.run.warm_start { 0.0 } else { RAMP_S + REST_S };
        Self { preparation: steps_in(preparation_s), travel: steps_in(travel_s).max(1) }
    }

    /// Number of steps between two checks for convergence of a run that is longer than planned: a tenth of the planned
    /// travel.
    fn tenth(&self) -> u64 {
        (self.travel / 10).max(1)
    }

    /// Number of steps from step `steps` until the monitor is checked, the bulk begins to move, or the run is checked
    /// for convergence.
    fn steps_to_next_event(&self, steps: u64) -> u64 {
        let to_turn = match steps.checked_sub(self.preparation) {
            None => self.preparation - steps,
            Some(driven) if driven < self.travel => self.travel - driven,
            Some(driven) => self.tenth() - driven % self.tenth(),
        };
        to_turn.min(STEPS_PER_MONITOR_CHECK - steps % STEPS_PER_MONITOR_CHECK)
    }

    pub const fn total(&self) -> u64 {
        self.preparation.saturating_add(self.travel)
    }
}

/// One run of an integrator.
#[derive(Clone, Copy, Debug)]
pub struct Drive<'a> {
    pub scene: &'a Scene,
    /// Nominal pressure, in pascals.
    pub pressure_pa: f64,
    /// Time step, in seconds.
    pub step_s: f64,
    /// Time step in units of sqrt(m/k), with block mass m and spring stiffness k.
    pub time_step: f64,
    /// Force evaluations per step.
    pub evaluations_per_step: u64,
    /// Fraction of the whole job's work that this run takes, for the progress report.
    pub share: f64,
    /// Standard error of the mean dynamic friction coefficient, relative to this mean, at which the run may end after
    /// the planned travel; `None` if no standard error is requested.
    pub stderr_share: Option<f64>,
    /// Number of blocks in the lattice.
    pub blocks: u64,
    /// Period of the layer's first shear mode, in the units of `time_step`.
    pub shear_period: f64,
    /// Time of the monitor's clock when the run was set up, in seconds.
    pub started_s: f64,
}

/// Result of a run.
#[derive(Clone, Debug)]
pub struct RunResult {
    pub status: Status,
    pub recorder: Recorder,
    /// Mean friction coefficient over the averaging window; `None` if the record is too short.
    pub mean: Option<WindowMean>,
    pub cost: DynamicCost,
    /// Forces on the contact blocks at the end of the run, in units of k l (spring stiffness times lattice spacing).
    pub last: Vec<ContactForce>,
}

/// Status with which a dynamic run of `scene` under `load` in steps of `step_s` seconds is refused; `None` if the run
/// is possible.
pub fn refusal(scene: &Scene, load: &Load, step_s: f64) -> Option<Status> {
    let is_too_long = Plan::new(scene, step_s).total() > MAX_STEPS;
    let no_load = (load.pressure_pa == 0.0).then_some(Status::NoLoad);
    no_load.or(is_too_long.then_some(Status::TooManySteps))
}

/// Outcome of a run that was refused with `status` before its first step; `centres_m` are the positions of the contact
/// blocks along x and y, in metres.
pub fn refused_outcome(status: Status, step_s: f64, centres_m: impl Iterator<Item = [f64; 2]>) -> SurfaceOutcome {
    let cost = DynamicCost { steps: 0, dt_s: step_s, site_updates: 0, wall_s: 0.0 };
    let at = |[x_m, y_m]: [f64; 2]| InterfacePoint { x_m, y_m, pressure_pa: 0.0, friction_pa: 0.0 };
    let interface = centres_m.map(at).collect();
    SurfaceOutcome { cost: Some(cost), interface, ..SurfaceOutcome::unsolved(status, std::iter::empty()) }
}

impl Drive<'_> {
    /// Runs `engine` through loading, rest and travel, until the mean friction coefficient has converged, a limit is
    /// reached, or `monitor` cancels.
    pub fn run(&self, engine: &mut impl Engine, monitor: &dyn Monitor) -> RunResult {
        let plan = Plan::new(self.scene, self.step_s);
        let Plan { preparation, travel: planned } = plan;
        let steps_per_bin = planned.div_ceil(BINS).max(1);
        let interface_from = (INTERFACE_FROM * planned as f64 / steps_per_bin as f64).ceil() as usize;
        let min_time = MIN_PERIODS * self.shear_period;
        let mut recorder = Recorder::new(steps_per_bin, self.time_step, min_time, interface_from);
        let extension = if self.stderr_share.is_some() { MAX_EXTENSION_FOR_STDERR } else { MAX_EXTENSION };
        let max_steps = planned.saturating_mul(extension).min(MAX_STEPS.max(planned));

        let mut status;
        let mut steps: u64 = 0;
        let share_per_step = self.share / (preparation + planned) as f64;
        'run: loop {
            if steps.is_multiple_of(STEPS_PER_MONITOR_CHECK) {
                if steps > 0 && steps <= preparation + planned {
                    monitor.advance(share_per_step * STEPS_PER_MONITOR_CHECK as f64);
                }
                if monitor.cancelled() {
                    status = Status::Cancelled;
                    break;
                }
            }
            if steps >= preparation + planned {
                let driven = steps - preparation;
                if driven == planned || driven.is_multiple_of(plan.tenth()) {
                    // If the bulk never moves, a longer run changes nothing.
                    let verdict = self.judge(recorder.window_mean().as_ref());
                    if verdict == Status::Converged || driven >= max_steps || self.scene.speed_m_s == 0.0 {
                        status = verdict;
                        break;
                    }
                    if verdict != Status::StderrNotReached {
                        recorder.restart_interface();
                    }
                }
            }
            if steps == preparation && !self.scene.run.warm_start {
                engine.begin_drive();
            }
            let free_steps = plan.steps_to_next_event(steps);
            let free_steps =
                if steps < preparation { free_steps } else { free_steps.min(recorder.steps_to_next_query()) };
            let (first, second) = if free_steps > 1 { engine.one_or_two_steps() } else { (engine.step(), None) };
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
            site_updates: steps * self.evaluations_per_step * self.blocks,
            wall_s: monitor.seconds() - self.started_s,
        };
        let mean = recorder.window_mean();
        if let (Status::Converged | Status::StderrNotReached, Some(mean)) = (status, &mean) {
            // If the standard error was not reached, the loss to waves must exceed twice the error.
            let unknown = if status == Status::Converged { 0.0 } else { 2.0 * mean.stderr / mean.mu.abs() };
            if mean.mu == 0.0 && mean.stderr == 0.0 {
                // Every sum is exactly zero.
                status = Status::NoFriction;
            } else if mean.excess.is_some_and(|excess| excess < -(WAVE_DEFICIT + unknown)) || self.is_too_fast() {
                status = Status::SlidingWaves;
            }
        }
        let last = engine.contact_forces();
        RunResult { status, recorder, mean, cost, last }
    }

    /// Whether the speed is too high for a dynamic run at this pressure. Damping above the default may suppress waves,
    /// so that no speed is too high then.
    fn is_too_fast(&self) -> bool {
        let run = &self.scene.run;
        run.damping <= RunOptions::default().damping
            && is_too_fast(&self.scene.elastic, self.pressure_pa, self.scene.speed_m_s)
    }

    /// Returns the status of a run with the mean `mean`: converged, or the reason to continue.
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
}

impl RunResult {
    /// Converts the result to an outcome of the model; `centres_m` are the positions of the contact blocks along x and
    /// y, in metres.
    pub fn outcome(
        &self,
        scene: &Scene,
        scales: &Scales,
        centres_m: impl Iterator<Item = [f64; 2]>,
        cavity_closed: bool,
    ) -> SurfaceOutcome {
        let Self { status, recorder, mean, cost, last } = self;
        // Forces are meaningless once the state is not finite.
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
        // The loss to waves depends on quantities that the scene does not give, so all of it counts as an error.
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
            area_law_extrapolated: scene.area_law.as_ref().is_some_and(|law| law.is_extrapolated(peak_pressure_pa)),
            cost: Some(*cost),
            interface,
            trace: recorder.trace(scales.time_s),
            ..SurfaceOutcome::default()
        }
    }
}

#[cfg(test)]
mod tests;
