//! Share of the edges along which there is a rim.

use super::rims::Scene;
use super::{Estimate, RimProfile};

/// Height over the greatest above which a place belongs to the core of a rim.
const CORE: f64 = 0.5;
/// Least length of a piece of edge, in bins.
const LEAST_PIECE: f64 = 8.0;
/// Most wrong decisions, of pieces with a rim and of those without together, from which a share can be told.
const MOST_WRONG: f64 = 0.6;
/// Rounds in which the height of pieces with a rim is found.
const ROUNDS: usize = 20;

/// Sums of heights in a band of distances before an edge.
#[derive(Clone, Copy, Default)]
struct Band {
    sum_m: f64,
    count: f64,
}

impl Band {
    fn add(&mut self, other: Self) {
        self.sum_m += other.sum_m;
        self.count += other.count;
    }

    fn less(self, base: Self) -> Option<f64> {
        (self.count > 0.0 && base.count > 0.0).then(|| self.sum_m / self.count - base.sum_m / base.count)
    }
}

/// The share of pieces of edge whose relief, core less the land beyond, exceeds half of a rim's; the same bands moved
/// outward onto the land say how often roughness decides wrongly. `None` where there is no land for them, or it decides
/// too often.
pub(super) fn share_of_edge(scene: &Scene<'_>, profile: RimProfile, width_m: f64, height_m: f64) -> Option<Estimate> {
    let bin_m = scene.bin_m();
    // The core of the profile in steps of a hundredth.
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
    // A core of mean height k h: the rim's relief is that of the bands over k.
    let mean = profile.mean(width_m, core_m[0] - scene.start_m, core_m[1] - scene.start_m);
    let bands_m = [core_m, base_m, core_m.map(|m| m + moved_m), base_m.map(|m| m + moved_m)];
    let mut sums = vec![[Band::default(); 4]; scene.edges.points.len()];
    scene.for_land(|number, distance_m, height_m| {
        for (band, [from_m, to_m]) in sums[number].iter_mut().zip(bands_m) {
            if (from_m..to_m).contains(&distance_m) {
                band.add(Band { sum_m: height_m, count: 1.0 });
            }
        }
    });
    // Pieces of edge as long as the rim is wide.
    let piece_m = width_m.max(LEAST_PIECE * bin_m);
    let mut pieces: Vec<(f64, f64)> = Vec::new();
    let mut land: Vec<f64> = Vec::new();
    let key = |number: usize| {
        let edge = &scene.edges.points[number];
        let block = (edge.line as f64 * scene.pixel_m[1 - edge.axis] / piece_m) as usize;
        (edge.region, edge.axis, edge.behind, block)
    };
    let numbers: Vec<usize> = (0..sums.len()).collect();
    for piece in numbers.chunk_by(|&one, &other| key(one) == key(other)) {
        let mut total = [Band::default(); 4];
        for &number in piece {
            for (total, &band) in total.iter_mut().zip(&sums[number]) {
                total.add(band);
            }
        }
        let length_m: f64 = piece.iter().map(|&number| scene.edges.points[number].length_m).sum();
        // Ends of sides, shorter than half a piece, are rougher than the rest.
        if length_m < 0.5 * piece_m {
            continue;
        }
        pieces.extend(total[0].less(total[1]).map(|relief_m| (length_m, relief_m / mean)));
        land.extend(total[2].less(total[3]).map(|relief_m| relief_m / mean));
    }
    if pieces.len() < 2 || land.len() < 2 {
        return None;
    }
    let all_m: f64 = pieces.iter().map(|piece| piece.0).sum();
    // Height of the pieces that have a rim, which is more than the mean where some have none.
    let mut rim_m = height_m;
    for _ in 0..ROUNDS {
        let high = || pieces.iter().filter(|piece| piece.1 > 0.5 * rim_m);
        let length_m: f64 = high().map(|piece| piece.0).sum();
        if length_m == 0.0 {
            break;
        }
        rim_m = high().map(|piece| piece.0 * piece.1).sum::<f64>() / length_m;
    }
    let found = pieces.iter().filter(|piece| piece.1 > 0.5 * rim_m).map(|piece| piece.0).sum::<f64>() / all_m;
    // Roughness lifts a piece of land above half a rim's height, or lowers a rim below it, as often as land farther out.
    let center_m = land.iter().sum::<f64>() / land.len() as f64;
    let share = |wrong: &dyn Fn(f64) -> bool| {
        land.iter().filter(|relief_m| wrong(**relief_m - center_m)).count() as f64 / land.len() as f64
    };
    let wrong = [share(&|relief_m| relief_m > 0.5 * rim_m), share(&|relief_m| relief_m < -0.5 * rim_m)];
    let right = 1.0 - wrong[0] - wrong[1];
    if right < 1.0 - MOST_WRONG {
        return None;
    }
    // found = p (1 - missed) + (1 - p) false
    let value = ((found - wrong[0]) / right).clamp(0.0, 1.0);
    // Pieces count singly; roughness and rims are longer than they are, by about two.
    let independent = 0.5 * pieces.len() as f64;
    let error = (found * (1.0 - found)).max(1.0 / independent / independent) / independent;
    Some(Estimate { value, error: Some(error.sqrt() / right) })
}
