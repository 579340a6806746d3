//! What a simulation found: recorded history and observables, one record per load.

mod bytes;

use slipgrid_material::AreaLaw;

use crate::simulate::TILT_STD;

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Status {
    /// Steady: the residual is below the tolerance. Dynamic: sliding was reached and averaged.
    Converged,
    /// The nonlinear solve stopped at its iteration limit: the best state is reported.
    NotConverged,
    /// A dynamic run ended before every contact block had slipped.
    NoOnset,
    /// No contact block carries load, so that mu is 0/0.
    NoLoad,
    /// The area law leaves no friction on any contact block: mu is 0, a ratio to it 0/0.
    NoFriction,
    /// A dynamic run was not begun: it would take more steps than [`crate::MAX_STEPS`].
    TooManySteps,
    /// Dynamic mu had not become stationary when the run ended, or was averaged over too few periods of the layer's first
    /// shear mode to be a mean.
    ShortWindow,
    /// Sliding is unstable to waves: blocks that stick while others slide take more than
    /// [`crate::WAVE_DEFICIT`] of sliding friction away, by an amount that depends on ends, damping and blocks.
    SlidingWaves,
    /// The wanted standard error was not reached within the run's cap on travel.
    StderrNotReached,
    /// The state stopped being finite.
    Diverged,
    /// The monitor asked to stop.
    Cancelled,
}

impl Status {
    /// The name used in files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Converged => "converged",
            Self::NotConverged => "not_converged",
            Self::NoOnset => "no_onset",
            Self::NoLoad => "no_load",
            Self::NoFriction => "no_friction",
            Self::TooManySteps => "too_many_steps",
            Self::ShortWindow => "short_window",
            Self::SlidingWaves => "sliding_waves",
            Self::StderrNotReached => "stderr_not_reached",
            Self::Diverged => "diverged",
            Self::Cancelled => "cancelled",
        }
    }
}

/// One contact block on the interface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InterfacePoint {
    /// Position along the sliding direction, from the left side, in metres; in space along the
    /// pattern's own x axis, from the cell's corner.
    pub x_m: f64,
    /// Position along the pattern's y axis, from the cell's corner, in metres; 0 in the vertical plane.
    pub y_m: f64,
    /// Normal pressure, positive in compression, in pascals. Dynamic runs: mean from three fifths of the planned travel on, or
    /// from where a run that was not stationary then was looked at last.
    pub pressure_pa: f64,
    /// Friction traction, positive against sliding, in pascals. Dynamic runs: mean likewise.
    pub friction_pa: f64,
}

/// One sample of the friction coefficient in time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TracePoint {
    /// Time since the drive started, in seconds.
    pub time_s: f64,
    /// Sum of friction over sum of normal force, mean over the interval that ends here.
    pub mu: f64,
}

/// What a dynamic run cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DynamicCost {
    /// Time steps.
    pub steps: u64,
    /// Time step, in seconds.
    pub dt_s: f64,
    /// Blocks times force evaluations.
    pub site_updates: u64,
    /// Seconds by the monitor's clock.
    pub wall_s: f64,
}

/// What one surface, flat or patterned, did under one load.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceOutcome {
    /// How the run ended.
    pub status: Status,
    /// Dynamic friction coefficient; absent where the status says why.
    pub mu_dynamic: Option<f64>,
    /// Its standard error: of the time average, and of what waves take away; absent for steady runs, which have none.
    pub mu_dynamic_stderr: Option<f64>,
    /// Friction over that of the same normal forces with every block sliding, less one, in the mean of the interface: above 0
    /// where blocks that stick hold more than sliding friction, below 0 where waves keep blocks from sliding
    /// ([`Status::SlidingWaves`]); dynamic runs only.
    pub stick_slip_excess: Option<f64>,
    /// Mean friction across the sliding direction over the normal force; dynamic runs in space only.
    pub mu_across: Option<f64>,
    /// Time since the drive started from which mu_dynamic was averaged, up to the end of the run, in
    /// seconds; absent for steady runs and where there is no mean.
    pub averaged_from_s: Option<f64>,
    /// Peak of mu(t) at the onset of sliding; dynamic runs only.
    pub mu_static: Option<f64>,
    /// Largest pressure on a contact block, in pascals: where one touches in part, the mean over a whole block at the same edge. It grows
    /// as blocks shrink.
    pub peak_pressure_pa: f64,
    /// Contact blocks under tension (steady: in the solution; dynamic: at the run's end).
    pub tension_blocks: usize,
    /// The ceiling of a cavity sags to the counterface.
    pub cavity_closed: bool,
    /// Least height of a cavity's ceiling above the counterface under load, in metres, negative beyond it; steady runs of
    /// patterns alone.
    pub clearance_m: Option<f64>,
    /// A contact pressure lies past the last pressure of the area law.
    pub area_law_extrapolated: bool,
    /// Steady: largest change of mu in the last iteration, the bound on its convergence error.
    pub residual: Option<f64>,
    /// Steady: iterations of the nonlinear solve.
    pub iterations: usize,
    /// Dynamic runs: what they cost.
    pub cost: Option<DynamicCost>,
    /// The interface, left to right.
    pub interface: Vec<InterfacePoint>,
    /// mu against time; empty for steady runs.
    pub trace: Vec<TracePoint>,
}

impl SurfaceOutcome {
    /// What is said of a surface that was not solved: nothing but why, with the interface unloaded at
    /// the contact blocks' positions `x_m`.
    pub(crate) fn unsolved(status: Status, x_m: impl Iterator<Item = f64>) -> Self {
        Self {
            status,
            mu_dynamic: None,
            mu_dynamic_stderr: None,
            stick_slip_excess: None,
            mu_across: None,
            averaged_from_s: None,
            mu_static: None,
            peak_pressure_pa: 0.0,
            tension_blocks: 0,
            cavity_closed: false,
            clearance_m: None,
            area_law_extrapolated: false,
            residual: None,
            iterations: 0,
            cost: None,
            interface: x_m.map(|x_m| InterfacePoint { x_m, y_m: 0.0, pressure_pa: 0.0, friction_pa: 0.0 }).collect(),
            trace: Vec::new(),
        }
    }
}

impl SurfaceOutcome {
    /// Steady sliding: the forces `normal` and `friction` on the contact blocks, in any unit, in a solve that ended with
    /// `status`, the pressures of `interface`, the largest of them over a whole block, and the least height of a ceiling, in metres.
    pub(crate) fn sliding(
        status: Status,
        [normal, friction]: [&[f64]; 2],
        (interface, peak_pressure_pa): (Vec<InterfacePoint>, f64),
        clearance_m: Option<f64>,
        area_law: Option<&AreaLaw>,
    ) -> Self {
        let compressive: f64 = normal.iter().filter(|normal| **normal > 0.0).sum();
        let total: f64 = friction.iter().sum();
        let mu = (compressive > 0.0 && total.is_finite()).then(|| total / compressive);
        let status = match mu {
            Some(0.0) if status == Status::Converged => Status::NoFriction,
            Some(_) => status,
            None => Status::NoLoad,
        };
        let extrapolated = |law: &AreaLaw| interface.iter().any(|point| law.is_extrapolated(point.pressure_pa));
        Self {
            // What is no equilibrium has no friction, and no ratio.
            mu_dynamic: mu.filter(|_| status != Status::NotConverged),
            peak_pressure_pa,
            tension_blocks: normal.iter().filter(|normal| **normal < 0.0).count(),
            cavity_closed: clearance_m.is_some_and(|clearance_m| clearance_m <= 0.0),
            clearance_m,
            area_law_extrapolated: area_law.is_some_and(extrapolated),
            interface,
            ..Self::unsolved(status, std::iter::empty())
        }
    }
}

/// The largest of the pressures of contact blocks that touch on `share` of a block each, over a whole block: at an edge pressure grows
/// without bound, so that a narrow part of a block bears more than a whole one would, however little of it there is. `beside` are the
/// contact blocks next to one.
pub(crate) fn peak_over_whole_blocks<I: IntoIterator<Item = usize>>(
    interface: &[InterfacePoint],
    share: &[f64],
    beside: impl Fn(usize) -> I,
) -> f64 {
    let over_a_block = |number: usize| {
        let (own_pa, own) = (interface[number].pressure_pa, share[number]);
        if own >= WHOLE {
            return own_pa;
        }
        let Some(next) = beside(number).into_iter().max_by(|&a, &b| share[a].total_cmp(&share[b])) else {
            return own_pa;
        };
        // The rest of a block, as far as there is land.
        let rest = (1.0 - own).min(share[next]);
        (own * own_pa + rest * interface[next].pressure_pa) / (own + rest)
    };
    (0..interface.len()).map(over_a_block).fold(0.0, f64::max)
}

/// Share from which a block is a whole one, but for rounding.
const WHOLE: f64 = 1.0 - 1e-9;

/// What the scene did under one load.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadOutcome {
    /// Nominal pressure, in pascals.
    pub pressure_pa: f64,
    /// The scene's own surface.
    pub surface: SurfaceOutcome,
    /// The flat surface at the same settings; `None` for a flat scene.
    pub flat: Option<SurfaceOutcome>,
    /// mu_dynamic, patterned over flat; `None` for a flat scene or where one of the two is absent.
    pub ratio: Option<f64>,
    /// Standard error of the ratio; `None` for steady runs.
    pub ratio_stderr: Option<f64>,
    /// Estimated distance of the ratio from that of vanishing blocks, which it hardly exceeds: the largest over all loads;
    /// `None` for a flat scene, and where no other size of blocks can be had.
    pub ratio_discretization_error: Option<f64>,
    /// Standard error of the ratio from what stands for the specimen's layout: strips that sample its face, one strip for
    /// all in time, a cell for its middle; `None` where nothing does.
    pub ratio_layout_error: Option<f64>,
    /// Ratio of the steady cell over the specimen's thickness less that of the layer alone. It is in `ratio` where the scene
    /// says how thick the specimen is; otherwise it is what a thick one would add. `None` for a flat scene, and where a cell
    /// has no ratio.
    pub ratio_layer_difference: Option<f64>,
    /// Standard error of the ratio where that difference was added to a strip or to a run in time; `None` where it was not.
    pub ratio_layer_error: Option<f64>,
    /// What friction changes of the ratio by tilting the pressure of a specimen that its holder keeps from turning. [`TILT_MEAN`](crate::TILT_MEAN) of it is
    /// in `ratio`, which has an error of [`TILT_STD`](crate::TILT_STD) of it; `None` where the scene does not say how thick a specimen with ends is.
    pub ratio_tilt_change: Option<f64>,
    /// What sliding in time adds to the ratio of steady sliding, which is in `ratio`; `None` where it is not known: only strips of a
    /// specimen have both.
    pub ratio_time_change: Option<f64>,
}

impl LoadOutcome {
    /// Whether both surfaces slid to a mean that means something.
    #[must_use]
    pub fn is_trusted(&self) -> bool {
        let means = [Status::Converged, Status::NoFriction, Status::StderrNotReached];
        std::iter::once(&self.surface).chain(&self.flat).all(|surface| means.contains(&surface.status))
    }

    /// Error of the ratio by the tilt of the pressure, one standard deviation, with the sign that it has at this load where the tilt
    /// is larger than its mean: all loads of a specimen have it in common.
    #[must_use]
    pub fn tilt_error(&self) -> Option<f64> {
        self.ratio_tilt_change.map(|change| TILT_STD * change)
    }

    /// Sets the ratio, and the patterned surface's dynamic friction to that of the flat one times it.
    pub fn set_ratio(&mut self, ratio: Option<f64>) {
        let flat_mu = self.flat.as_ref().and_then(|flat| flat.mu_dynamic);
        self.ratio = ratio;
        self.surface.mu_dynamic = ratio.zip(flat_mu).map(|(ratio, mu)| ratio * mu);
    }

    /// Adds `by` to the ratio, where there is one, and to friction in proportion.
    pub(crate) fn shift_ratio(&mut self, by: f64) {
        if let Some(ratio) = self.ratio {
            self.set_ratio(Some(ratio + by));
        }
    }
}

/// What a simulation says of itself, one statement each.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Statements {
    /// What was modelled and why: what bears on a decision.
    pub model: Vec<String>,
    /// How it was computed.
    pub method: Vec<String>,
}

impl Statements {
    /// That something was modelled so, or not at all.
    pub fn model(&mut self, said: impl Into<String>) {
        self.model.push(said.into());
    }

    /// That something was computed so.
    pub fn method(&mut self, said: impl Into<String>) {
        self.method.push(said.into());
    }
}

/// Results of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Simulation {
    /// What was modelled, and how it was computed.
    pub statements: Statements,
    /// One record per load, in the scene's order.
    pub loads: Vec<LoadOutcome>,
}
