//! Detection of round cavities, and their diameters.
//!
//! A chord of an ellipse at the fraction u of its half extent has sqrt(1 - u^2) of its extent. The median chord, at u =
//! 1/2, is 0.866 and the 90 % quantile, at u = 1/10, 0.995 of it, a ratio of 0.870. A square or a rectangle along the
//! axes has chords of one length, a ratio of 1. Those of a diamond are 0.5 and 0.9 of its extent; those of a regular
//! hexagon are 0.75 and 0.95 along one axis and equal for half of the other. A cavity is round if both axes have the
//! ratio of an ellipse.

use slipgrid_base::statistics::median;

use super::Spread;
use super::found::Found;

/// Median chord of an ellipse over the 90 % quantile of its chords: sqrt(1 - 1/4) over sqrt(1 - 1/100).
const ROUND_RATIO: f64 = 0.870_388;
/// Maximum deviation from [`ROUND_RATIO`]: half of the difference to a square.
const MAX_DEPARTURE: f64 = 0.06;
/// Quantile of the chords that represents the extent.
const QUANTILE: f64 = 0.9;
/// Minimum number of chords along an axis for the detection of a shape.
const MIN_CHORDS: usize = 8;

/// Diameters of a region along both axes, in metres, if it is round: those of the ellipse with the region's area and
/// ratio of median chords. `None` if it is not round.
fn diameters_m(found: &Found, region: usize) -> Option<[f64; 2]> {
    let mut medians_m = [0.0; 2];
    let mut area_m2 = 0.0;
    for axis in [0, 1] {
        if !found.counts(axis, region) {
            return None;
        }
        let mut lengths = found.along[axis][region].lengths.clone();
        if lengths.len() < MIN_CHORDS {
            return None;
        }
        lengths.sort_by(f64::total_cmp);
        // The sum of chords times the pixel is the area, including parts of pixels at edges.
        area_m2 += 0.5 * lengths.iter().sum::<f64>() * found.pixel_m[0] * found.pixel_m[1];
        // Below the number of chords: the cast is exact.
        let long = lengths[(QUANTILE * lengths.len() as f64) as usize];
        let middle = median(&mut lengths)?;
        if (middle / long - ROUND_RATIO).abs() > MAX_DEPARTURE {
            return None;
        }
        medians_m[axis] = middle * found.pixel_m[axis];
    }
    let mean_m = (4.0 * area_m2 / std::f64::consts::PI).sqrt();
    let aspect = (medians_m[0] / medians_m[1]).sqrt();
    Some([mean_m * aspect, mean_m / aspect])
}

/// Diameters of every region by label, along both axes in metres, if most whole regions are round; otherwise `None`. An
/// entry is `None` if the region is not round.
pub(super) fn diameters(found: &Found) -> Option<Vec<Option<[f64; 2]>>> {
    let regions = 1..=found.regions.count();
    let whole = regions.clone().filter(|&region| found.is_whole(region)).count();
    let of_regions = regions.map(|region| diameters_m(found, region));
    let diameters: Vec<Option<[f64; 2]>> = std::iter::once(None).chain(of_regions).collect();
    (2 * diameters.iter().flatten().count() > whole).then_some(diameters)
}

/// Width of the land between neighbours along `axis`, in metres: the distance of their centres minus their mean
/// diameter. Cavities cut by the map's sides have no diameter and are left out. `None` without neighbours.
pub(super) fn spacing(found: &Found, axis: usize, diameters_m: &[Option<[f64; 2]>]) -> Option<Spread> {
    let centers_m = found.centers_m(axis);
    let gap_m = |(pair, _): &([u32; 2], f64)| {
        let [one, other] = pair.map(|region| region as usize);
        let mean_m = 0.5 * (diameters_m[one]?[axis] + diameters_m[other]?[axis]);
        Some((centers_m[other] - centers_m[one]).abs() - mean_m)
    };
    Spread::of(found.neighbours(axis).iter().filter_map(gap_m))
}

#[cfg(test)]
mod tests {
    use slipgrid_base::monitor::Unwatched;

    use super::super::cut::tests::GROOVES;
    use crate::topography::form::Form;
    use crate::topography::{CutPattern, CutRim, CutShape, HeightMap, RimProfile, SelfAffine};

    /// A rough, tilted map of 2 um pixels with cavities 80 um wide and 120 um apart, with walls and rims.
    fn cut(shape: CutShape, wall_m: f64, rim_height_m: Option<f64>) -> HeightMap {
        let mut map = SelfAffine { side_m: 1.024e-3, ..SelfAffine::STAND_IN }.map().unwrap();
        let rim = |height_m| CutRim { height_m, width_m: 16e-6, profile: RimProfile::Round, height_std_m: 0.0 };
        let pattern = CutPattern {
            shape,
            width_m: 80e-6,
            spacing_m: 120e-6,
            depth_m: 10e-6,
            wall_m,
            rim: rim_height_m.map(rim),
            seed: 3,
            ..GROOVES
        };
        map.cut_cavities(&pattern).unwrap();
        let (rows, cols) = (map.rows(), map.cols());
        let noise = |n: usize| ((n * 2_654_435_761) >> 7) % 2001;
        map.changed(|n, height_m| {
            height_m + 4e-6 * (n / cols) as f64 / rows as f64 + (noise(n) as f64 - 1000.0) * 5e-11
        })
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

    /// Discs of 60 um at positions in micrometres, on 300 x 400 pixels of 2 um, with walls 4 um wide.
    fn discs(places_um: impl Iterator<Item = [f64; 2]> + Clone) -> HeightMap {
        let height = |n: usize| {
            let (x, y) = (2.0 * (n / 400) as f64 + 1.0, 2.0 * (n % 400) as f64 + 1.0);
            let near = places_um.clone().map(|[px, py]| (x - px).hypot(y - py)).fold(f64::INFINITY, f64::min);
            -5e-6 * (0.5 + (30.0 - near) / 4.0).clamp(0.0, 1.0)
        };
        HeightMap::new(300, 400, 2e-6, 2e-6, (0..120_000).map(height).collect()).unwrap()
    }

    #[test]
    fn discs_that_the_map_cuts_off_do_not_change_the_spacing() {
        // Pitches of 100 by 110 um; the map's sides leave slivers, halves and nearly whole discs.
        for offset_um in [0.0, 17.0, 33.0, 48.0] {
            let places = (0..64).map(|n| [100.0 * f64::from(n / 8) - offset_um, 110.0 * f64::from(n % 8) - offset_um]);
            let found = discs(places).measure_cavities(Form::Plane, &slipgrid_base::monitor::Unwatched).unwrap();
            assert!(found.round);
            for (spacing, expected_m) in found.spacing.into_iter().zip([40e-6, 50e-6]) {
                let spacing = spacing.unwrap();
                assert!(spacing.count >= 20, "{offset_um}: {spacing:?}");
                // A quarter of a pixel, the accuracy of the diameter of a disc of 30 pixels.
                assert!(
                    (spacing.mean_m - expected_m).abs() < 0.5e-6 && spacing.std_m < 0.2e-6,
                    "{offset_um}: {spacing:?}"
                );
            }
        }
    }

    #[test]
    fn discs_that_face_each_other_on_a_part_of_their_lines_have_the_spacing_of_their_diameters() {
        // Rows 60 um apart, every second one shifted by half of 86 um: the lines along x at the sides of a disc, 60 um
        // wide, meet a disc of the next row.
        let places = (0..60)
            .map(|n| [45.0 + 60.0 * f64::from(n / 6), 40.0 + 86.0 * f64::from(n % 6) + f64::from(n / 6 % 2) * 43.0]);
        let found = discs(places);
        let found = super::Found::find(&found, Form::Plane, &slipgrid_base::monitor::Unwatched).unwrap();
        let diameters_m = super::diameters(&found).unwrap();
        let spacing = super::spacing(&found, 0, &diameters_m).unwrap();
        assert!((spacing.mean_m - 60e-6).abs() < 0.6e-6 && spacing.std_m < 0.5e-6, "{spacing:?}");
    }
}
