//! Results of a simulation: one record per load, with observables and recorded history.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::material::AreaLaw;

/// State in which a run ended, from the least to the most severe.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Status {
    /// Steady: the residual is below the tolerance. Dynamic: sliding was reached and averaged.
    Converged,
    /// The area law leaves no friction on any contact block: mu is 0, and a ratio to it is undefined.
    NoFriction,
    /// No contact block carries load, so that mu is undefined.
    NoLoad,
    /// The requested standard error was not reached within the maximum travel.
    StderrNotReached,
    /// Sliding is unstable to waves: blocks that stick while others slide reduce friction by more than
    /// [`crate::springblock::WAVE_DEFICIT`], by an amount that depends on ends, damping and block size.
    SlidingWaves,
    /// Dynamic mu was not yet stationary when the run ended, or was averaged over too few periods of the layer's first
    /// shear mode.
    ShortWindow,
    /// A dynamic run ended before every contact block had slipped.
    NoOnset,
    /// The nonlinear solve reached its iteration limit; the best state is reported.
    #[default]
    NotConverged,
    /// A dynamic run was refused, because it needs more steps than [`crate::springblock::MAX_STEPS`].
    TooManySteps,
    /// The monitor cancelled the run.
    Cancelled,
    /// The state is no longer finite.
    Diverged,
}

slipgrid_base::names!(Status {
    Converged = "converged",
    NotConverged = "not_converged",
    NoOnset = "no_onset",
    NoLoad = "no_load",
    NoFriction = "no_friction",
    TooManySteps = "too_many_steps",
    ShortWindow = "short_window",
    SlidingWaves = "sliding_waves",
    StderrNotReached = "stderr_not_reached",
    Diverged = "diverged",
    Cancelled = "cancelled",
});

impl Status {
    /// Whether a dynamic run reached its end, so that another would end in the same way.
    pub(crate) const fn is_final(self) -> bool {
        use Status::{Converged, NoFriction, NoOnset, ShortWindow, SlidingWaves, StderrNotReached};
        matches!(self, Converged | NoOnset | NoFriction | ShortWindow | SlidingWaves | StderrNotReached)
    }
}

/// State of one contact block on the interface.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct InterfacePoint {
    /// Position along the sliding direction from the left side, in metres; in space along the pattern's x axis from the
    /// corner of the cell.
    pub x_m: f64,
    /// Position along the pattern's y axis from the corner of the cell, in metres; 0 in the vertical plane.
    pub y_m: f64,
    /// Normal pressure, positive in compression, in pascals. For dynamic runs it is the mean from three fifths of the
    /// planned travel on or, if the run was extended, from the last check at which mu was not yet stationary.
    pub pressure_pa: f64,
    /// Friction traction, positive against sliding, in pascals. For dynamic runs it is a mean over the same time as the
    /// pressure.
    pub friction_pa: f64,
}

/// Friction coefficient over one recording interval of a dynamic run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TracePoint {
    /// Time since the drive started, in seconds.
    pub time_s: f64,
    /// Sum of friction over sum of normal force, averaged over the interval that ends at `time_s`.
    pub mu: f64,
}

/// Cost of a dynamic run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DynamicCost {
    /// Number of time steps.
    pub steps: u64,
    /// Time step, in seconds.
    pub dt_s: f64,
    /// Number of blocks times number of force evaluations.
    pub site_updates: u64,
    /// Elapsed time of the monitor's clock, in seconds.
    pub wall_s: f64,
}

/// Result of one surface, flat or patterned, under one load.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SurfaceOutcome {
    /// How the run ended.
    pub status: Status,
    /// Dynamic friction coefficient; `None` if there is none, for the reason that the status gives.
    pub mu_dynamic: Option<f64>,
    /// Standard error of `mu_dynamic` due to averaging over time and the loss to waves; `None` for steady runs.
    pub mu_dynamic_stderr: Option<f64>,
    /// Mean friction over the friction of the same normal forces with every block sliding, minus one; dynamic runs
    /// only. The excess is positive if sticking blocks hold more than sliding friction, and negative if waves reduce
    /// friction ([`Status::SlidingWaves`]).
    pub stick_slip_excess: Option<f64>,
    /// Mean friction force perpendicular to the sliding direction over the normal force; `None` except for dynamic runs
    /// in space.
    pub mu_across: Option<f64>,
    /// Time since the start of the drive from which `mu_dynamic` was averaged, up to the end of the run, in seconds;
    /// `None` for steady runs and without a mean.
    pub averaged_from_s: Option<f64>,
    /// Peak of mu(t) at the onset of sliding; dynamic runs only.
    pub mu_static: Option<f64>,
    /// Largest pressure on a contact block, in pascals. The pressure of a block that touches in part is averaged with
    /// that of its neighbour over a whole block. The value increases as blocks become smaller.
    pub peak_pressure_pa: f64,
    /// Number of contact blocks under tension; for dynamic runs at the end.
    pub tension_blocks: usize,
    /// Whether the ceiling of a cavity touches the counterface.
    pub cavity_closed: bool,
    /// Minimum height of a cavity's ceiling above the counterface under load, in metres, negative if the ceiling passes
    /// through the counterface; steady runs of patterns only.
    pub clearance_m: Option<f64>,
    /// Whether a contact pressure exceeds the last pressure of the area law.
    pub area_law_extrapolated: bool,
    /// Steady runs: sum of the magnitudes of the unbalanced forces over the load, at the end of the solve.
    pub residual: Option<f64>,
    /// Steady runs: number of iterations of the nonlinear solve.
    pub iterations: usize,
    /// Dynamic runs: cost of the run.
    pub cost: Option<DynamicCost>,
    /// Contact blocks of the interface, left to right.
    pub interface: Vec<InterfacePoint>,
    /// mu as a function of time; empty for steady runs.
    pub trace: Vec<TracePoint>,
}

impl SurfaceOutcome {
    /// Outcome of a surface that was not solved, for the reason `status`, with unloaded contact blocks at the positions
    /// `x_m`.
    pub(crate) fn unsolved(status: Status, x_m: impl Iterator<Item = f64>) -> Self {
        let at = |x_m| InterfacePoint { x_m, y_m: 0.0, pressure_pa: 0.0, friction_pa: 0.0 };
        Self { status, interface: x_m.map(at).collect(), ..Self::default() }
    }

    /// Outcome of steady sliding, from the solved forces.
    ///
    /// `normal` and `friction` are forces on the contact blocks in any common unit; `status` is the status of the
    /// solve; `interface` has the pressures; `peak_pressure_pa` is their maximum, averaged over a whole block;
    /// `clearance_m` is the minimum height of a ceiling above the counterface.
    pub(crate) fn from_steady_forces(
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
            // A state out of equilibrium has no friction coefficient.
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

/// Maximum pressure, in pascals, averaged over a whole block, on an `interface` whose contact blocks each touch on the
/// fraction `share` of a block.
///
/// At an edge the pressure is singular, so that a narrow part of a block has a higher pressure than a whole block,
/// however narrow it is. `neighbours` returns the indices of the contact blocks next to a given one.
pub(crate) fn peak_over_whole_blocks<I: IntoIterator<Item = usize>>(
    interface: &[InterfacePoint],
    share: &[f64],
    neighbours: impl Fn(usize) -> I,
) -> f64 {
    let pressure_over_block = |number: usize| {
        let (own_pa, own) = (interface[number].pressure_pa, share[number]);
        if own >= WHOLE_SHARE {
            return own_pa;
        }
        let Some(next) = neighbours(number).into_iter().max_by(|&a, &b| share[a].total_cmp(&share[b])) else {
            return own_pa;
        };
        // The rest of a block, as far as the neighbour is land.
        let rest = (1.0 - own).min(share[next]);
        (own * own_pa + rest * interface[next].pressure_pa) / (own + rest)
    };
    (0..interface.len()).map(pressure_over_block).fold(0.0, f64::max)
}

/// A block whose touching fraction is at least this value counts as whole: 1 less rounding.
const WHOLE_SHARE: f64 = 1.0 - 1e-9;

/// Effect that the solved blocks leave out, and that a [`Correction`] adds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Effect {
    /// Dimensions that are not whole numbers of blocks, in a dynamic run: the difference between the steady cells with
    /// exact and with rounded dimensions.
    #[serde(rename = "whole blocks")]
    WholeBlocks,
    /// Rims of a strip, or yielding of rims: the difference between the steady cells with and without this effect.
    #[serde(rename = "rims")]
    Rims,
    /// Layout of cavities on the specimen, which the solved strips or the solved cell represent only approximately.
    #[serde(rename = "layout on the specimen")]
    Layout,
    /// Sliding in time instead of steady sliding.
    #[serde(rename = "sliding in time")]
    Time,
    /// Specimen behind the layer that was solved: the difference between the steady cells of the whole thickness and of
    /// the layer.
    #[serde(rename = "specimen behind the layer")]
    Behind,
    /// Tilt of the pressure by friction, on a specimen whose holder prevents rotation. All of the effect is included
    /// with a rigid holder, half of it with an unknown holder. Its error is fully correlated between the loads of a
    /// specimen: if the tilt exceeds its mean, all ratios change in the direction of the correction.
    #[serde(rename = "tilt of the pressure")]
    Tilt,
    /// Size of the blocks. The change is the step to smaller blocks, 0 without refinement; the error is half of the
    /// largest estimated difference from vanishing blocks at this and nearby loads, which the true difference hardly
    /// exceeds.
    #[serde(rename = "size of blocks")]
    Blocks,
}

slipgrid_base::names!(Effect {
    WholeBlocks = "whole blocks",
    Rims = "rims",
    Layout = "layout on the specimen",
    Time = "sliding in time",
    Behind = "specimen behind the layer",
    Tilt = "tilt of the pressure",
    Blocks = "size of blocks",
});

/// Change of a ratio by an effect that the solved blocks leave out, included in the ratio.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Correction {
    /// The effect.
    pub effect: Effect,
    /// Change of the ratio; 0 where only the error is known.
    pub change: f64,
    /// Standard error of the change; null if it is not known.
    pub std: Option<f64>,
}

/// Result of a scene under one load.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LoadOutcome {
    /// Nominal pressure, in pascals.
    pub pressure_pa: f64,
    /// Surface with the scene's pattern. Its dynamic friction is the ratio times the dynamic friction of the flat
    /// surface.
    pub surface: SurfaceOutcome,
    /// Flat surface with the same settings; `None` for a flat scene.
    pub flat: Option<SurfaceOutcome>,
    /// Standard error of the ratio before corrections; `None` for steady runs.
    pub ratio_stderr: Option<f64>,
    /// Friction of the patterned over that of the flat surface for the solved blocks, before corrections; `None` if it
    /// is undefined.
    pub(crate) solved: Option<f64>,
    /// Corrections, at most one for each effect, in the order in which they were added.
    pub(crate) corrections: Vec<Correction>,
}

impl LoadOutcome {
    /// Dynamic friction coefficient of the patterned over that of the flat surface: the ratio of the solved blocks plus
    /// all corrections. `None` for a flat scene, or if one of the two coefficients is absent.
    pub fn ratio(&self) -> Option<f64> {
        Some(self.solved? + self.corrections.iter().map(|correction| correction.change).sum::<f64>())
    }

    /// Changes of the ratio by the effects that the solved blocks leave out.
    pub fn corrections(&self) -> &[Correction] {
        &self.corrections
    }

    /// Change of the ratio by `effect`; `None` if it was not added.
    pub fn correction(&self, effect: Effect) -> Option<&Correction> {
        self.corrections.iter().find(|correction| correction.effect == effect)
    }

    /// Whether both surfaces have a meaningful mean friction.
    pub fn is_trusted(&self) -> bool {
        let means = [Status::Converged, Status::NoFriction, Status::StderrNotReached];
        std::iter::once(&self.surface).chain(&self.flat).all(|surface| means.contains(&surface.status))
    }

    /// Adds the `change` of the ratio by `effect` with the standard error `std`, if known; an earlier change by this
    /// effect is replaced. Does nothing without a ratio.
    pub(crate) fn correct(&mut self, effect: Effect, change: f64, std: impl Into<Option<f64>>) {
        if self.solved.is_some() {
            self.corrections.retain(|correction| correction.effect != effect);
            self.corrections.push(Correction { effect, change, std: std.into() });
            self.follow_ratio();
        }
    }

    /// Scales the friction reduction 1 - r, with the ratio r, all changes and errors to a face whose cavity fraction is
    /// `share` times that of the solved blocks. `std` is the standard error of the scaling, if known.
    ///
    /// ```text
    /// 1 - r = share (1 - r_solved),     r - r_solved = (share - 1) (r_solved - 1)
    /// ```
    pub fn scale_to_layout(&mut self, share: f64, std: Option<f64>) {
        for correction in &mut self.corrections {
            correction.change *= share;
            correction.std = correction.std.map(|std| std * share);
        }
        self.ratio_stderr = self.ratio_stderr.map(|stderr| stderr * share);
        if let Some(solved) = self.solved {
            self.correct(Effect::Layout, (share - 1.0) * (solved - 1.0), std);
        }
    }

    /// Removes the ratio and its corrections, because without a missing correction the ratio would be misleading.
    pub(crate) fn remove_ratio(&mut self) {
        self.solved = None;
        self.corrections.clear();
        self.follow_ratio();
    }

    fn follow_ratio(&mut self) {
        let flat_mu = self.flat.as_ref().and_then(|flat| flat.mu_dynamic);
        self.surface.mu_dynamic = self.ratio().zip(flat_mu).map(|(ratio, mu)| ratio * mu);
    }
}

/// Statements about a simulation, one sentence each.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Statements {
    /// Statements on what was modelled and why, relevant to decisions.
    pub model: Vec<String>,
    /// Statements on how the results were computed.
    pub method: Vec<String>,
}

impl Statements {
    /// Adds a statement on what was modelled or neglected.
    pub fn model(&mut self, said: impl Into<String>) {
        self.model.push(said.into());
    }

    /// Adds a statement on how something was computed.
    pub fn method(&mut self, said: impl Into<String>) {
        self.method.push(said.into());
    }
}

/// Results of a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Simulation {
    /// Statements on what was modelled and how the results were computed.
    pub statements: Statements,
    /// One record per load, in the scene's order.
    pub loads: Vec<LoadOutcome>,
}

impl Simulation {
    /// Maximum local pressure on the patterned surface (or the flat surface of a flat scene) over all loads, in
    /// pascals.
    pub fn peak_pressure_pa(&self) -> f64 {
        self.loads.iter().map(|load| load.surface.peak_pressure_pa).fold(0.0, f64::max)
    }
}
