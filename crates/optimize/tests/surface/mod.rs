//! A closed-form surface, where what can be reached and where it is are known.
//!
//! ratio(P) = 1 - s g c(P),  s = width / pitch,  g = 1 - exp(-depth / 8 um),
//! c(P) = P / (P + 1 MPa width / 100 um),  peak pressure = 2.5 MPa (1 + 2 s) (1 + depth / 40 um).
//!
//! Width enters c, so that targets at several pressures determine the width and s g, but of spacing
//! and depth only s g: the designs that meet a target are a curve.

#![allow(dead_code, reason = "each test crate uses its own part")]

use slipgrid_monitor::{Monitor, Unwatched};
use slipgrid_optimize::{
    Bound, Constraints, DesignSpace, Limit, ModelFailure, Quantity, Response, SearchOptions, SearchOutcome, Target,
    TargetPoint, search,
};
use slipgrid_pattern::{ManufacturingLimits, Pattern, Planform};
use std::sync::atomic::{AtomicUsize, Ordering};

pub const PRESSURES_PA: [f64; 4] = [0.65e6, 1.3e6, 1.95e6, 2.6e6];
pub const TOLERANCE: f64 = 0.01;

/// g of the surface.
pub fn depth_share(depth_um: f64) -> f64 {
    1.0 - (-depth_um / 8.0).exp()
}

pub fn ratio(design: &Pattern, pressure_pa: f64) -> f64 {
    let load_share = pressure_pa / (pressure_pa + 1e6 * design.width_m() / 100e-6);
    1.0 - design.section_density() * depth_share(design.depth_m() * 1e6) * load_share
}

pub fn respond(design: &Pattern) -> Result<Response, ModelFailure> {
    let value = PRESSURES_PA.iter().map(|&pressure_pa| ratio(design, pressure_pa)).collect();
    let peak_pressure_pa = 2.5e6 * (1.0 + 2.0 * design.section_density()) * (1.0 + design.depth_m() / 40e-6);
    Ok(Response { value, limited: vec![peak_pressure_pa] })
}

pub fn target(values: [f64; 4]) -> Target {
    let point = |(&pressure_pa, value)| TargetPoint { pressure_pa, value };
    Target::new(Quantity::Ratio, PRESSURES_PA.iter().zip(values).map(point).collect(), TOLERANCE).unwrap()
}

pub fn design(width_um: f64, spacing_um: f64, depth_um: f64) -> Pattern {
    Pattern::new(Planform::Groove, width_um * 1e-6, spacing_um * 1e-6, depth_um * 1e-6).unwrap()
}

/// The target that a design reaches.
pub fn target_of(design: &Pattern) -> Target {
    target(PRESSURES_PA.map(|pressure_pa| ratio(design, pressure_pa)))
}

pub fn space() -> DesignSpace {
    DesignSpace::new(Planform::Groove, [40e-6, 400e-6], [40e-6, 1000e-6], [2e-6, 50e-6]).unwrap()
}

pub fn bursts(depth_per_burst_um: f64) -> Constraints {
    let limits = ManufacturingLimits { depth_per_burst_m: Some(depth_per_burst_um * 1e-6), ..Default::default() };
    Constraints { limits, ..unlimited() }
}

pub fn peak(max_peak_pressure_mpa: f64) -> Constraints {
    let limit_pa = max_peak_pressure_mpa * 1e6;
    let bound = Bound::AtMost(limit_pa);
    let limit =
        Limit { name: "peak pressure", unit: "MPa", unit_si: 1e6, bound, scale: limit_pa, loosest: f64::INFINITY };
    Constraints { quantities: vec![limit], ..Constraints::default() }
}

/// The peak pressure without a limit.
pub fn unlimited() -> Constraints {
    let mut constraints = peak(1.0);
    constraints.quantities[0] = constraints.quantities[0].relaxed();
    constraints
}

pub fn seeded(seed: u64) -> SearchOptions {
    SearchOptions { seed, ..Default::default() }
}

/// Cancels a search after so many evaluations.
pub struct StopAfter {
    pub most: usize,
    /// Share that an evaluation is to be of the search's work.
    pub share: f64,
    pub evaluations: AtomicUsize,
}

impl StopAfter {
    pub const fn new(most: usize, share: f64) -> Self {
        Self { most, share, evaluations: AtomicUsize::new(0) }
    }
}

impl Monitor for StopAfter {
    fn advance(&self, share: f64) {
        assert!((share / self.share - 1.0).abs() < 1e-9, "{share}");
        self.evaluations.fetch_add(1, Ordering::Relaxed);
    }

    fn cancelled(&self) -> bool {
        self.evaluations.load(Ordering::Relaxed) >= self.most
    }
}

pub fn run(target: &Target, constraints: &Constraints, options: &SearchOptions) -> SearchOutcome {
    search(target, &space(), constraints, options, &respond, &Unwatched).unwrap()
}
