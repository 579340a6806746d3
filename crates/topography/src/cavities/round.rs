//! Which cavities are round, and the diameter of those.
//!
//! The chords of an ellipse that lie at the share u of its half extent are sqrt(1 - u^2) of its extent: their median, at
//! u = 1/2, is 0.866 and their 90 % quantile, at u = 1/10, 0.995 of it, a ratio of 0.870. A square or a rectangle along the
//! axes has chords of one length, a ratio of 1; a diamond's are 0.5 and 0.9 of its extent, a regular hexagon's 0.75 and
//! 0.95 along one axis and all the same for half of the other. A cavity is round where both axes have the ratio of an ellipse.

use slipgrid_statistics::median;

use super::Spread;
use super::found::Found;

/// sqrt(1 - 1/4) over sqrt(1 - 1/100).
const ROUND_RATIO: f64 = 0.870_388;
/// Largest departure from it: half the way to a square.
const MOST_DEPARTURE: f64 = 0.06;
/// Share of chords that are shorter than the one that stands for the extent.
const QUANTILE: f64 = 0.9;
/// Least chords along an axis that show a shape.
const LEAST_CHORDS: usize = 8;

/// The diameters of a region along both axes if it is round, in metres: those of the ellipse with its area and with its
/// ratio of median chords.
fn diameters_m(found: &Found, region: usize) -> Option<[f64; 2]> {
    let mut medians_m = [0.0; 2];
    let mut area_m2 = 0.0;
    for axis in [0, 1] {
        if !found.counts(axis, region) {
            return None;
        }
        let mut lengths = found.along[axis][region].lengths.clone();
        if lengths.len() < LEAST_CHORDS {
            return None;
        }
        lengths.sort_by(f64::total_cmp);
        // The sum of chords, a pixel apart each, is the area with the parts of pixels that edges cross.
        area_m2 += 0.5 * lengths.iter().sum::<f64>() * found.pixel_m[0] * found.pixel_m[1];
        // Below their number: the cast is exact.
        let long = lengths[(QUANTILE * lengths.len() as f64) as usize];
        let middle = median(&mut lengths)?;
        if (middle / long - ROUND_RATIO).abs() > MOST_DEPARTURE {
            return None;
        }
        medians_m[axis] = middle * found.pixel_m[axis];
    }
    let mean_m = (4.0 * area_m2 / std::f64::consts::PI).sqrt();
    let aspect = (medians_m[0] / medians_m[1]).sqrt();
    Some([mean_m * aspect, mean_m / aspect])
}

/// The diameters of every region, from 1 on, if most of those that end within the map along both axes are round; `None`
/// where they are not.
pub(super) fn diameters(found: &Found) -> Option<Vec<Option<[f64; 2]>>> {
    let regions = 0..=found.regions.count();
    let whole = regions.clone().filter(|&region| region > 0 && [0, 1].iter().all(|&axis| found.counts(axis, region)));
    let diameters: Vec<Option<[f64; 2]>> =
        regions.map(|region| if region > 0 { diameters_m(found, region) } else { None }).collect();
    let round = diameters.iter().flatten().count();
    (2 * round > whole.count()).then_some(diameters)
}

/// Land between neighbours along `axis`: their distance on most lines, less what their diameters have more than their widths
/// on those.
pub(super) fn spacing(
    found: &Found,
    axis: usize,
    width_m: &[[Option<f64>; 2]],
    diameters_m: &[Option<[f64; 2]>],
) -> Option<Spread> {
    let beyond_m = |region: u32| {
        let region = region as usize;
        let chord_m = width_m[region][axis];
        diameters_m[region].zip(chord_m).map_or(0.0, |(diameter_m, chord_m)| 0.5 * (diameter_m[axis] - chord_m))
    };
    let gaps = found.neighbours(axis).into_iter();
    let gaps: Vec<f64> = gaps.map(|([one, other], gap_m)| gap_m - beyond_m(one) - beyond_m(other)).collect();
    Spread::of(&gaps)
}

#[cfg(test)]
mod tests {
    use slipgrid_monitor::Unwatched;

    use crate::form::Form;
    use crate::{CutPattern, CutRim, CutShape, HeightMap, RimProfile, SelfAffine};

    /// A rough map of 2 um pixels with cavities 80 um wide and 120 um apart, with walls and rims, tilted.
    fn cut(shape: CutShape, wall_m: f64, rim_height_m: Option<f64>) -> HeightMap {
        let mut map = SelfAffine { side_m: 1.024e-3, ..SelfAffine::STAND_IN }.map().unwrap();
        let rim = |height_m| CutRim { height_m, width_m: 16e-6, profile: RimProfile::Round, height_std_m: 0.0 };
        let pattern = CutPattern {
            shape,
            width_m: 80e-6,
            spacing_m: 120e-6,
            depth_m: 10e-6,
            wall_m,
            width_std_m: 0.0,
            pitch_std_m: 0.0,
            depth_std_m: 0.0,
            rim: rim_height_m.map(rim),
            seed: 3,
        };
        map.cut_cavities(&pattern).unwrap();
        let (rows, cols) = (map.rows(), map.cols());
        let noise = |n: usize| ((n * 2_654_435_761) >> 7) % 2001;
        let tilted = map.heights_m().iter().enumerate().map(|(n, height_m)| {
            height_m + 4e-6 * (n / cols) as f64 / rows as f64 + (noise(n) as f64 - 1000.0) * 5e-11
        });
        HeightMap::new(rows, cols, map.dx_m(), map.dy_m(), tilted.collect()).unwrap()
    }

    #[test]
    fn discs_have_their_diameter_and_squares_their_side() {
        for (shape, round) in [(CutShape::Disc, true), (CutShape::Square, false)] {
            for (wall_m, rim_m) in [(0.0, None), (10e-6, None), (10e-6, Some(0.5e-6))] {
                let found = cut(shape, wall_m, rim_m).measure_cavities(Form::Plane, &Unwatched).unwrap();
                assert_eq!((found.round, found.cavities.len() >= 25), (round, true), "{shape:?} {wall_m} {rim_m:?}");
                for axis in [0, 1] {
                    let [width, spacing] = [found.width[axis].unwrap(), found.spacing[axis].unwrap()];
                    assert!((width.mean_m - 80e-6).abs() < 0.8e-6, "{shape:?} {wall_m} {rim_m:?}: {width:?}");
                    assert!((spacing.mean_m - 120e-6).abs() < 0.8e-6, "{shape:?} {wall_m} {rim_m:?}: {spacing:?}");
                }
            }
        }
    }
}
