//! Designs within the bounds, with width and spacing in whole blocks and depth in whole bursts or passes.

use slipgrid_base::units::LENGTH_UM;
use slipgrid_model::pattern::Pattern;
use slipgrid_model::springblock::Dimension;

use crate::DesignError;
use crate::steps::Steps;
use crate::task::DesignTask;

/// Step of the depth if the depth per burst is unknown, in metres.
const DEPTH_STEP_M: f64 = 2e-6;
/// Maximum number of designs in a table.
const MAX_NODES: usize = 1_000_000;
/// Maximum number of intervals between depths in whole passes.
const MAX_DEPTHS: f64 = 1000.0;
/// Tolerance for rounding at bounds that are whole steps, as a fraction of a step.
const WHOLE: f64 = 1e-6;

/// Returns the widths and spacings in whole blocks within the bounds of `design`, and for each width the depths in whole
/// bursts, or in whole passes over the lines in this width, in metres. A fixed depth is kept: the speed of the laser
/// makes it.
pub fn axes(design: &DesignTask) -> ([Vec<f64>; 2], Vec<Vec<f64>>) {
    let (space, block_m) = (&design.space, design.layer.block_m);
    let burst_m = design.constraints.limits.depth_per_burst_m.unwrap_or(DEPTH_STEP_M);
    let whole = |[lower_m, upper_m]: [f64; 2], step_m: f64| -> Vec<f64> {
        // Bounds are at most a metre, so the casts are exact.
        let (first, last) = ((lower_m / step_m - WHOLE).ceil().max(1.0), (upper_m / step_m + WHOLE).floor());
        (first as u64..=last as u64).map(|step| (step as f64 * step_m).clamp(lower_m, upper_m)).collect()
    };
    let axis = |bounds_m: [f64; 2], step_m: f64| -> Vec<f64> {
        let [lower_m, upper_m] = bounds_m;
        if lower_m == upper_m {
            return vec![lower_m];
        }
        let whole = whole(bounds_m, step_m);
        // If the bounds lie between two steps, the bounds and their middle are used.
        if whole.is_empty() { vec![lower_m, f64::midpoint(lower_m, upper_m), upper_m] } else { whole }
    };
    let [widths_m, spacings_m] = [space.width_m(), space.spacing_m()].map(|bounds_m| axis(bounds_m, block_m));
    let depth_m = space.depth_m();
    let in_passes = |width_m: &f64| -> Option<Vec<f64>> {
        let pattern = space.pattern([*width_m, space.spacing_m()[1], depth_m[0]]).ok()?;
        let pass_m = LENGTH_UM.to_si(design.laser.depth_step_um(&pattern)?);
        // Many passes are taken several at a time.
        let several = ((depth_m[1] - depth_m[0]) / (pass_m * MAX_DEPTHS)).ceil().max(1.0);
        Some(whole(depth_m, several * pass_m))
    };
    if design.laser.has_passes() && depth_m[0] < depth_m[1] {
        let depths_m: Vec<Vec<f64>> = widths_m.iter().map(|width_m| in_passes(width_m).unwrap_or_default()).collect();
        if depths_m.iter().any(|depths_m| !depths_m.is_empty()) {
            return ([widths_m, spacings_m], depths_m);
        }
    }
    let depths_m = vec![axis(depth_m, burst_m); widths_m.len()];
    ([widths_m, spacings_m], depths_m)
}

/// All designs in whole blocks and bursts within bounds and limits of the laser, width varying slowest. Stops after a
/// million and one designs, which shows that there are too many.
pub fn lattice(design: &DesignTask) -> Vec<Pattern> {
    Steps::new(design).every(1).take(MAX_NODES + 1).collect()
}

/// Checks that the table of all designs can be made, before anything is computed.
///
/// # Errors
/// [`DesignError`] for models in space, and tables of too many designs or none.
pub fn check(design: &DesignTask) -> Result<(), DesignError> {
    if !Dimension::of(design.search.dimensions, design.space.texture()).is_cheap_per_design() {
        return Err(DesignError::refused(
            "a table takes the vertical plane: in space it would take hours, which a campaign with work = \"table\" spreads over machines",
        ));
    }
    match lattice(design).len() {
        0 => Err(DesignError::refused("no whole blocks and bursts lie within bounds and limits: the table is empty")),
        nodes if nodes > MAX_NODES => {
            Err(DesignError::refused(format!("the table has more than {MAX_NODES} designs: narrow the bounds")))
        }
        _ => Ok(()),
    }
}
