//! What smaller blocks change of cavities in space, as grooves tell it.
//!
//! Cells in space are too dear in blocks of a fraction of a shallow cavity's depth. Grooves in the vertical plane are not. A groove
//! across the sliding direction as wide and as deep as a cavity, with as large a share of the face, has edges that bear alike, and what
//! blocks of the size l take off friction at them is off by the same share:
//!
//! ```text
//! 1 - r(0) = (1 - r(l)) (1 - r_groove(0)) / (1 - r_groove(l))
//! ```
//!
//! Crossing and turned grooves have no such likeness (at 12 um of depth the formula is off by more than it corrects), and rims and
//! measured reliefs meet the counterface in their own way.

use slipgrid_pattern::{Pattern, Planform};

use super::blocks::{BlockRefinement, Unrefined, refined};
use crate::Monitor;
use crate::scene::Scene;

/// What the likeness leaves open, as a share of what smaller blocks change
/// (`grooves_tell_what_smaller_blocks_change_of_cavities_in_space`): hardly exceeded.
const OPEN_SHARE: f64 = 0.5;
/// Friction that a groove takes off, over the flat surface's, below which nothing is told by it.
const LEAST_LOWERING: f64 = 1e-5;

/// Whether `pattern` is one of cavities, each with land all around and without rims, under which nothing is measured.
pub fn are_like_grooves(scene: &Scene, pattern: &Pattern) -> bool {
    let is_cavity = !matches!(pattern.texture().planform(), Planform::Groove | Planform::Crosshatch);
    is_cavity && pattern.texture().rim().is_none() && scene.relief.is_none()
}

/// What smaller blocks change of ratios `own` of cells of `scene` over `pattern` in space, by steady cells of grooves of at most `most`
/// multiplications.
pub fn refined_by_grooves(
    scene: &Scene,
    pattern: &Pattern,
    own: &[Option<f64>],
    most: f64,
    monitor: &dyn Monitor,
) -> Result<BlockRefinement, Unrefined> {
    let width_m = pattern.width_m();
    let alike = Some(pattern).filter(|pattern| are_like_grooves(scene, pattern)).and_then(|pattern| {
        // w / (w + s) = share of the face
        let spacing_m = width_m / pattern.areal_density() - width_m;
        Pattern::new(Planform::Groove, width_m, spacing_m, pattern.depth_m()).ok()
    });
    let groove = alike.ok_or(Unrefined::Space)?;
    let mut plane = Scene { pattern: Some(groove), ..scene.clone() };
    plane.run.dimensions = Some(2);
    let (found, of_groove) = refined(&plane, &groove, most, monitor)?;
    // (1 - r) / (1 - r_groove), in blocks of this size
    let scale: Vec<f64> = own
        .iter()
        .zip(&of_groove)
        .map(|(own, groove)| {
            let lowering = 1.0 - groove;
            own.filter(|_| lowering > LEAST_LOWERING).map_or(0.0, |own| (1.0 - own) / lowering)
        })
        .collect();
    let shifts: Vec<f64> = found.shifts.iter().zip(&scale).map(|(shift, scale)| shift * scale).collect();
    let widest = shifts.iter().fold(0.0, |widest: f64, shift| widest.max(shift.abs()));
    let errors = found.errors.iter().zip(&scale);
    let errors = errors.map(|(error, scale)| (error * scale.abs()).hypot(OPEN_SHARE * widest)).collect();
    Ok(BlockRefinement { shifts, errors, ..found })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cell::SteadyCell;
    use crate::scene::RunOptions;
    use crate::simulate::block_refinement;
    use crate::{Layer, samples};

    /// Cells in blocks of 10 and of 5 um, refined by grooves to an eighth of that, against the same in blocks of 2.5 and of 1.25 um, refined
    /// to as small ones.
    #[test]
    fn grooves_tell_what_smaller_blocks_change_of_cavities_in_space() {
        let (mut plain, mut left, mut most, mut worst, mut beyond) = (0.0_f64, 0.0_f64, 0.0_f64, 0.0_f64, 0);
        for (planform, width_um, spacing_um, fine_um) in [
            (Planform::Square, 80.0, 80.0, 2.5),
            (Planform::Disc, 80.0, 60.0, 2.5),
            (Planform::Square, 60.0, 100.0, 2.5),
            (Planform::Square, 40.0, 40.0, 1.25),
        ] {
            for depth_um in [3.0, 5.2, 10.0] {
                let pattern = samples::pattern(planform, width_um, spacing_um, depth_um);
                let scene = |block_um: f64| {
                    let base = samples::scene(pattern, &[0.65, 1.3, 2.6], RunOptions::default());
                    let layer = Layer { height_m: 80e-6, block_m: block_um * 1e-6, ..base.layer };
                    Scene { layer, ..base }
                };
                let solved = |block_um: f64| {
                    let scene = scene(block_um);
                    let own = SteadyCell::new(&scene).ratios(&pattern);
                    let found = block_refinement(&scene, &own, 2e9).unwrap();
                    (own, found)
                };
                let (fine, after) = solved(fine_um);
                for block_um in [10.0, 5.0] {
                    let (own, found) = solved(block_um);
                    for load in 0..3 {
                        let (own, fine) = (own[load].unwrap(), fine[load].unwrap());
                        let before = own - fine - after.shifts[load];
                        let corrected = before + found.shifts[load];
                        plain += before.powi(2);
                        left += corrected.powi(2);
                        most = most.max(before.abs());
                        worst = worst.max(corrected.abs());
                        let stated = found.errors[load].hypot(after.errors[load]);
                        beyond += usize::from(corrected.abs() > stated);
                    }
                }
            }
        }
        assert!(left.sqrt() < 0.4 * plain.sqrt() && worst < 0.4 * most, "{left} {plain} {worst} {most}");
        // Of 72.
        assert!(beyond <= 2, "{beyond}");
    }
}
