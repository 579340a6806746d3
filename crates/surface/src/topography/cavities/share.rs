//! Fraction of the edges along which there is a rim.

use slipgrid_base::monitor::{Cancelled, Monitor};

use super::found::Mean;
use super::scene::Scene;
use super::{Estimate, RimProfile};

/// A position belongs to the core of a rim if the height there is at least this fraction of the maximum.
const CORE: f64 = 0.5;
/// Minimum length of a piece of edge, in bins.
const MIN_PIECE: f64 = 8.0;
/// Maximum standard error of a reported fraction.
const MAX_ERROR: f64 = 0.25;
/// Number of trial fractions.
const STEPS: u32 = 200;

/// Fraction of pieces of edge whose relief, the height of the core minus that of the land beyond, exceeds half of the
/// relief of a rim. The same bands moved outward onto the land give the rate of false decisions by roughness. `None` if
/// there is no land for the moved bands, or if the error of the fraction exceeds [`MAX_ERROR`].
pub(super) fn share_of_edge(
    scene: &Scene<'_>,
    profile: RimProfile,
    width_m: f64,
    monitor: &dyn Monitor,
) -> Result<Option<Estimate>, Cancelled> {
    let Some((bands_m, mean)) = bands_m(scene, profile, width_m) else { return Ok(None) };
    let mut sums = vec![[Mean::default(); 4]; scene.edges.points.len()];
    scene.for_land(monitor, |number, distance_m, height_m| {
        for (band, [from_m, to_m]) in sums[number].iter_mut().zip(bands_m) {
            if (from_m..to_m).contains(&distance_m) {
                band.add(height_m);
            }
        }
    })?;
    Ok(share_of(scene, &sums, mean, width_m))
}

/// Bands of distances from the edge, in metres: core of the rim, land beyond it, and both moved outward onto the land.
/// Also returns the mean over the core of a rim of height 1. `None` if there is no land for the moved bands.
fn bands_m(scene: &Scene<'_>, profile: RimProfile, width_m: f64) -> Option<([[f64; 2]; 4], f64)> {
    let bin_m = scene.bin_m;
    // Core of the profile in steps of a hundredth.
    let core: Vec<f64> = (0..=100).map(|n| f64::from(n) / 100.0).filter(|&s| profile.height(s) >= CORE).collect();
    let core_m = [
        (core.first()? * width_m).max(bin_m) + scene.start_m,
        (core.last()? * width_m).max(2.0 * bin_m) + scene.start_m,
    ];
    let first_m = scene.start_m + width_m + 0.5 * bin_m;
    let base_m = [first_m, first_m + (core_m[1] - core_m[0]).max(2.0 * bin_m)];
    let moved_m = (base_m[1] - core_m[0]).min(scene.reach_m() - base_m[1]);
    if moved_m < first_m - core_m[0] {
        return None;
    }
    // If the mean height of the core is k h, the rim's relief is that of the bands over k.
    let mean = profile.mean(width_m, core_m[0] - scene.start_m, core_m[1] - scene.start_m);
    Some(([core_m, base_m, core_m.map(|m| m + moved_m), base_m.map(|m| m + moved_m)], mean))
}

/// Fraction of the edges with a rim, from the sums of heights in each band at every edge point; `mean` is the mean over
/// the core of a rim of height 1.
fn share_of(scene: &Scene<'_>, sums: &[[Mean; 4]], mean: f64, width_m: f64) -> Option<Estimate> {
    // Pieces of edge are as long as the rim is wide.
    let piece_m = width_m.max(MIN_PIECE * scene.bin_m);
    let mut pieces: Vec<(f64, f64)> = Vec::new();
    let mut land: Vec<f64> = Vec::new();
    let key = |number: usize| {
        let edge = &scene.edges.points[number];
        let block = (edge.line as f64 * scene.pixel_m[1 - edge.axis] / piece_m) as usize;
        (edge.region, edge.axis, edge.behind, block)
    };
    let numbers: Vec<usize> = (0..sums.len()).collect();
    for piece in numbers.chunk_by(|&one, &other| key(one) == key(other)) {
        let mut total = [Mean::default(); 4];
        for &number in piece {
            for (total, &band) in total.iter_mut().zip(&sums[number]) {
                total.join(band);
            }
        }
        let length_m: f64 = piece.iter().map(|&number| scene.edges.points[number].length_m).sum();
        // Ends of sides, shorter than half a piece, are rougher than the rest.
        if length_m < 0.5 * piece_m {
            continue;
        }
        let [core_m, base_m, moved_core_m, moved_base_m] = total.map(Mean::value);
        pieces.extend(core_m.zip(base_m).map(|(core_m, base_m)| (length_m, (core_m - base_m) / mean)));
        land.extend(moved_core_m.zip(moved_base_m).map(|(core_m, base_m)| (core_m - base_m) / mean));
    }
    if pieces.len() < 2 || land.len() < 2 {
        return None;
    }
    let all_m: f64 = pieces.iter().map(|piece| piece.0).sum();
    let mean_m = pieces.iter().map(|piece| piece.0 * piece.1).sum::<f64>() / all_m;
    let center_m = land.iter().sum::<f64>() / land.len() as f64;
    let of_land = |decides: &dyn Fn(f64) -> bool| {
        land.iter().filter(|relief_m| decides(**relief_m - center_m)).count() as f64 / land.len() as f64
    };
    // With rims along the fraction p, each of the height mean/p, the fraction of pieces above half of that is
    //     p (1 - missed) + (1 - p) false,
    // where the rates of missed and false rims are those due to roughness on land farther out.
    let balance = |p: f64| {
        let half_m = 0.5 * mean_m / p;
        let found = pieces.iter().filter(|piece| piece.1 > half_m).map(|piece| piece.0).sum::<f64>() / all_m;
        let (missed, false_rims) = (of_land(&|relief_m| relief_m < -half_m), of_land(&|relief_m| relief_m > half_m));
        (found - p * (1.0 - missed) - (1.0 - p) * false_rims, found, 1.0 - missed - false_rims)
    };
    let shares = || (1..=STEPS).rev().map(|step| f64::from(step) / f64::from(STEPS));
    let value = shares().find(|&p| balance(p).0 >= 0.0)?;
    // Pieces count half, because roughness and gaps are longer than pieces.
    let binomial = |share: f64, count: usize| {
        let count = 0.5 * count as f64;
        (share * (1.0 - share)).max(1.0 / count) / count
    };
    let (_, found, right) = balance(value);
    let stray = (binomial(found, pieces.len()) + binomial(0.5 * (1.0 - right), land.len())).sqrt();
    // Fractions that are balanced within a standard error.
    let low = shares().find(|&p| balance(p).0 > stray).unwrap_or(0.0);
    let high = shares().find(|&p| balance(p).0 >= -stray).unwrap_or(1.0);
    let error = (value - low).max(high - value);
    (error <= MAX_ERROR).then_some(Estimate { value, error: Some(error) })
}
