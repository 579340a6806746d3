//! Effect of smaller blocks on cells in space, estimated from smaller cells and from grooves.
//!
//! Cells in space are too expensive in blocks of a fraction of a shallow cavity's depth; grooves in the vertical plane
//! are not. The edges of a groove across the sliding direction with the width, the depth and the area fraction of the
//! cavities carry load like the edges of the cavities, so that both friction reductions 1 - r in blocks of size l have
//! the same relative error:
//!
//! ```text
//! 1 - r(0) = (1 - r(l)) (1 - r_groove(0)) / (1 - r_groove(l))
//! ```
//!
//! A groove that is not across the sliding direction is compared with a transversal groove of equal width and spacing;
//! at edges along the sliding direction friction does not tilt the pressure, which changes the effect of blocks by a
//! tenth. For crossing grooves the error of the formula may exceed the correction; its standard error covers this and
//! decreases with the correction. The formula therefore starts from the smallest blocks, a half or a quarter of the
//! layer's blocks, in which a cell in space takes at most a second. Rims and measured reliefs are not refined, because
//! the blocks that touch depend on their heights.

use crate::pattern::{Pattern, Planform};

use super::blocks::{BlockRefinement, CANCELLED, Finest, MAX_PRODUCTS, refine_in_plane, with_block_factor};
use super::space::MAX_ESTIMATED_BYTES;
use crate::springblock::{Dimension, Monitor, Scene, SteadyCell};

/// Standard error of ratios from the formula of this module, as a fraction of the largest change by smaller blocks at
/// any load (`grooves_tell_what_smaller_blocks_change_of_cavities_in_space`); rarely exceeded.
const RELATIVE_ERROR: f64 = 0.5;
/// Number of multiplications in the plane that take as long as one column of a cell in space.
const COLUMN_PRODUCTS: f64 = 2e6;
/// Block sizes of smaller cells in space relative to the layer's blocks, smallest first.
const SIZES: [f64; 2] = [0.25, 0.5];
/// Minimum friction reduction of a groove, relative to the flat surface, for use of the formula.
const MIN_LOWERING: f64 = 1e-5;

/// Whether the face of `pattern` is flat, without rims and measured relief.
pub fn has_flat_face(scene: &Scene, pattern: &Pattern) -> bool {
    pattern.texture().rim().is_none() && scene.relief.is_none()
}

/// Returns the groove across the sliding direction with the width, depth and area fraction of cavities of `pattern`;
/// `None` if it would have no land.
fn similar_groove(pattern: &Pattern) -> Option<Pattern> {
    let width_m = pattern.width_m();
    let spacing_m = match pattern.planform() {
        Planform::Groove => pattern.spacing_m(),
        // w / (w + s) = area fraction of cavities
        _ => width_m / pattern.areal_density() - width_m,
    };
    Pattern::new(Planform::Groove, width_m, spacing_m, pattern.depth_m()).ok()
}

/// Effect of smaller blocks on the ratios `own` of cells of `scene` with `pattern` in space, or the reason why there is
/// no result. Cells in smaller blocks are solved in space if one takes no longer than `most` multiplications in the
/// plane; the effect of still smaller blocks is taken from grooves.
pub fn refined_by_grooves(
    scene: &Scene,
    pattern: &Pattern,
    own: &[Option<f64>],
    most: f64,
    monitor: &dyn Monitor,
) -> Result<BlockRefinement, String> {
    let alike = Some(pattern).filter(|pattern| has_flat_face(scene, pattern)).and_then(similar_groove);
    let groove = alike.ok_or("cells in space with rims or measured heights are like no grooves in the plane")?;
    for size in SIZES {
        let Some(finer) = with_block_factor(scene, size).filter(|finer| is_cheap(finer, pattern, most)) else {
            continue;
        };
        // The groove is solved first, because the cell in space is more expensive and useless without it.
        let Ok(of_groove) = refine_groove(&finer, &groove, most.min(MAX_PRODUCTS), monitor) else { continue };
        let Some(nearer) = refine_by_cells(scene, &finer, pattern, own, monitor) else { continue };
        monitor.heed().map_err(|_| CANCELLED)?;
        let added =
            nearer.iter().zip(own).map(|(nearer, own)| nearer.zip(*own).map_or(0.0, |(nearer, own)| nearer - own));
        let found = scale_refinement(of_groove, &nearer);
        let shifts = found.shifts.iter().zip(added).map(|(shift, added)| shift + added).collect();
        return Ok(BlockRefinement { factor: size * found.factor, shifts, ..found });
    }
    Ok(scale_refinement(refine_groove(scene, &groove, most, monitor)?, own))
}

/// Whether a cell in space of `scene` with `pattern` takes no longer than `most` multiplications in the plane, and less
/// memory than [`MAX_ESTIMATED_BYTES`].
fn is_cheap(scene: &Scene, pattern: &Pattern, most: f64) -> bool {
    let cell = SteadyCell::with_dimension(scene, Dimension::Space);
    let [nx, ny] = cell.columns(pattern);
    nx * ny * COLUMN_PRODUCTS < most && cell.bytes(pattern) < MAX_ESTIMATED_BYTES
}

/// Returns the ratios `own` plus the change from the steady cells of `scene` to those of `finer`; `None` if a cell has
/// no ratio at a load.
fn refine_by_cells(
    scene: &Scene,
    finer: &Scene,
    pattern: &Pattern,
    own: &[Option<f64>],
    monitor: &dyn Monitor,
) -> Option<Vec<Option<f64>>> {
    let ratios = |scene: &Scene| SteadyCell::with_dimension(scene, Dimension::Space).ratios_heeding(pattern, monitor);
    let (finer, coarse) = rayon::join(|| ratios(finer), || ratios(scene));
    let moved = |(own, (finer, coarse)): (&Option<f64>, (Option<f64>, Option<f64>))| match own {
        Some(own) => Some(Some(own + finer? - coarse?)),
        None => Some(None),
    };
    own.iter().zip(finer.into_iter().zip(coarse)).map(moved).collect()
}

/// Effect of smaller blocks on `groove`, from steady plane cells that each take at most `most` multiplications, and the
/// ratios of the groove in the blocks of `scene`; or the reason why there is no result.
fn refine_groove(
    scene: &Scene,
    groove: &Pattern,
    most: f64,
    monitor: &dyn Monitor,
) -> Result<(BlockRefinement, Vec<f64>), String> {
    let mut plane = Scene { pattern: Some(*groove), ..scene.clone() };
    plane.run.dimensions = Some(Dimension::Plane.number());
    // Edges along the sliding direction converge in another way: nothing is extrapolated.
    refine_in_plane(&plane, groove, (most, Finest::AS_SOLVED), monitor)
}

/// Scales the refinement `found` of a groove with the ratios `of_groove` to cells with the ratios `own`, in proportion
/// to the friction reductions.
fn scale_refinement((found, of_groove): (BlockRefinement, Vec<f64>), own: &[Option<f64>]) -> BlockRefinement {
    // (1 - r) / (1 - r_groove) in blocks of this size
    let scale: Vec<f64> = own
        .iter()
        .zip(&of_groove)
        .map(|(own, groove)| {
            let lowering = 1.0 - groove;
            own.filter(|_| lowering > MIN_LOWERING).map_or(0.0, |own| (1.0 - own) / lowering)
        })
        .collect();
    let shifts: Vec<f64> = found.shifts.iter().zip(&scale).map(|(shift, scale)| shift * scale).collect();
    let widest = shifts.iter().fold(0.0, |widest: f64, shift| widest.max(shift.abs()));
    let errors = found.errors.iter().zip(&scale);
    let errors = errors.map(|(error, scale)| (error * scale.abs()).hypot(RELATIVE_ERROR * widest)).collect();
    BlockRefinement { shifts, errors, ..found }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pattern::Texture;
    use crate::springblock::RunOptions;
    use crate::springblock::cell::SteadyCell;
    use crate::springblock::simulate::block_refinement;
    use crate::springblock::{Layer, tests::samples};

    /// Crossing and turned grooves in blocks of 20 um, refined by cells in blocks of 5 um and by grooves, compared with
    /// refinement from blocks of 2.5 um.
    #[test]
    fn smaller_cells_and_grooves_tell_what_smaller_blocks_change_of_crossing_and_turned_grooves() {
        let crossing = |angle_deg: f64| {
            let texture = Texture::from(Planform::Crosshatch).with_groove_angle_deg(-0.5 * angle_deg).unwrap();
            texture.with_crossing_angle_deg(angle_deg).unwrap()
        };
        let turned = |angle_deg: f64| Texture::from(Planform::Groove).with_groove_angle_deg(angle_deg).unwrap();
        let (mut plain, mut left, mut by_grooves_alone) = (0.0_f64, 0.0_f64, 0);
        for (texture, width_um, spacing_um) in [
            (crossing(60.0), 40.0, 100.0),
            (crossing(90.0), 40.0, 100.0),
            (turned(30.0), 60.0, 60.0),
            (turned(90.0), 60.0, 60.0),
        ] {
            for depth_um in [2.6, 5.2, 12.0] {
                let pattern = Pattern::new(texture, width_um * 1e-6, spacing_um * 1e-6, depth_um * 1e-6).unwrap();
                let solved = |block_um: f64| {
                    let base = samples::scene(pattern, &[0.65, 1.3, 2.6], RunOptions::default());
                    let scene =
                        Scene { layer: Layer { height_m: 80e-6, block_m: block_um * 1e-6, ..base.layer }, ..base };
                    let own = SteadyCell::new(&scene).ratios(&pattern);
                    let found = block_refinement(&scene, &own, 2e10, false).unwrap();
                    let alone = block_refinement(&scene, &own, 2e8, false);
                    (own, found, alone)
                };
                let ((own, found, alone), (fine, after, _)) = (solved(20.0), solved(2.5));
                assert!(found.factor <= 0.0625, "{}", found.factor);
                for load in 0..3 {
                    let before = own[load].unwrap() - fine[load].unwrap() - after.shifts[load];
                    let corrected = before + found.shifts[load];
                    plain += before.powi(2);
                    left += corrected.powi(2);
                    let stated = found.errors[load].hypot(after.errors[load]);
                    assert!(corrected.abs() < stated && stated < 0.014, "{pattern:?} {load}: {corrected} {stated}");
                    // Grooves only, as if no smaller cell were cheap.
                    if let Some(alone) = &alone {
                        let corrected = (before + alone.shifts[load]).abs();
                        let stated = alone.errors[load].hypot(after.errors[load]);
                        assert!(corrected < stated, "{pattern:?} {load}: {corrected} {stated}");
                        by_grooves_alone += 1;
                    }
                }
            }
        }
        // 36 cases.
        let [before, after] = [plain, left].map(|sum| (sum / 36.0).sqrt());
        assert!(before > 0.02 && after < 0.003, "{before} {after}");
        assert!(by_grooves_alone >= 12, "{by_grooves_alone}");
    }

    /// Cells in blocks of 10 and 5 um, refined by grooves to an eighth of these sizes, compared with cells in blocks of
    /// 2.5 and 1.25 um refined to equally small ones.
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
                    let found = block_refinement(&scene, &own, 2e9, false).unwrap();
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
        // 72 cases.
        assert!(beyond <= 2, "{beyond}");
    }
}
