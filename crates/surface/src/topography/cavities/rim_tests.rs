use slipgrid_base::monitor::Unwatched;

use super::cut::tests::GROOVES;
use super::tests::PUBLISHED;
use super::*;
use crate::topography::form::Form;
use crate::topography::{HeightMap, SelfAffine};
use slipgrid_base::statistics::splitmix64;

/// Cavities 60 um wide, 5.2 um deep and 140 um apart, for maps of 2 um pixels, 1.024 mm wide.
const PATTERN: CutPattern = CutPattern {
    width_m: 60e-6,
    spacing_m: 140e-6,
    width_std_m: 1e-6,
    pitch_std_m: 3e-6,
    depth_std_m: 0.2e-6,
    seed: 3,
    ..PUBLISHED
};

fn rim(height_um: f64, width_um: f64, profile: RimProfile, height_std_um: f64) -> Option<CutRim> {
    Some(CutRim { height_m: height_um * 1e-6, width_m: width_um * 1e-6, profile, height_std_m: height_std_um * 1e-6 })
}

/// A tilted map of roughness Sa 0.158 um with `pattern`, white noise of 20 nm, and 5 % of its points missing, half of
/// these on walls.
fn measured(pattern: &CutPattern, seed: u32) -> (HeightMap, Vec<CutCavity>) {
    let mut map = SelfAffine { side_m: 1.024e-3, seed, ..SelfAffine::STAND_IN }.map().unwrap();
    let cut = map.cut_cavities(pattern).unwrap();
    let (rows, cols) = (map.rows(), map.cols());
    let uniform = |n: usize, of: u64| {
        (splitmix64(splitmix64(u64::from(seed) << 40 | of << 32 | n as u64)) >> 11) as f64 / (1_u64 << 53) as f64
    };
    let noisy = |n: usize, height: f64| {
        let (x, y) = ((n / cols) as f64 / rows as f64, (n % cols) as f64 / cols as f64);
        // The sum of twelve uniform deviates has variance 1.
        let noise = (1..=12).map(|of| uniform(n, of)).sum::<f64>() - 6.0;
        height + 15e-6 * x - 8e-6 * y + 20e-9 * noise
    };
    let steep = |n: usize| {
        let at = |other: usize| (map.heights_m()[other.min(rows * cols - 1)] - map.heights_m()[n]).abs();
        at(n + cols).max(at(n.saturating_sub(cols))).max(at(n + 1)).max(at(n.saturating_sub(1))) > 0.5e-6
    };
    let walls = (0..rows * cols).filter(|&n| steep(n)).count();
    let lost_walls = (0.025 * (rows * cols) as f64 / walls as f64).min(0.5);
    let is_lost = |n: usize| steep(n) && uniform(n, 13) < lost_walls || uniform(n, 14) < 0.025;
    (map.changed(|n, height| if is_lost(n) { f64::NAN } else { noisy(n, height) }), cut)
}

/// Asserts that `found` is within a tenth of `truth`, or within twice its stated error.
fn agrees(found: Option<Estimate>, truth: f64, what: &str) {
    let found = found.unwrap_or_else(|| panic!("{what}: nothing was measured"));
    let allowed = (0.1 * truth).max(2.0 * found.error.unwrap());
    assert!((found.value - truth).abs() <= allowed, "{what}: {found:?}, not {truth}");
}

/// Cavities that the map's sides do not cut.
fn whole(cut: &[CutCavity], shape: CutShape) -> Vec<&CutCavity> {
    let within = |cavity: &CutCavity, axis: usize| cavity.center_m[axis] + 0.5 * cavity.width_m < 1.024e-3;
    cut.iter().filter(|cavity| within(cavity, 0) && (shape == CutShape::Groove || within(cavity, 1))).collect()
}

#[test]
fn rims_of_a_tenth_to_three_micrometres_are_measured_on_rough_tilted_noisy_maps_with_holes() {
    let mut seed = 0;
    for shape in [CutShape::Groove, CutShape::Square, CutShape::Disc] {
        for (height_um, width_um, profile, std_um) in [
            (0.1, 16.0, RimProfile::Round, 0.0),
            (0.1, 15.0, RimProfile::Flat, 0.02),
            (0.3, 12.0, RimProfile::Ramp, 0.06),
            (0.3, 20.0, RimProfile::HalfSine, 0.0),
            (1.0, 10.0, RimProfile::Round, 0.2),
            (1.0, 30.0, RimProfile::Ramp, 0.1),
            (3.0, 20.0, RimProfile::Flat, 0.6),
            (3.0, 25.0, RimProfile::Round, 0.0),
        ] {
            seed += 1;
            let rim = rim(height_um, width_um, profile, std_um);
            let (map, cut) = measured(&CutPattern { shape, rim, seed: seed.into(), ..PATTERN }, seed);
            let cut = whole(&cut, shape);
            let mean =
                |value: &dyn Fn(&CutCavity) -> f64| cut.iter().map(|cut| value(cut)).sum::<f64>() / cut.len() as f64;
            let found = map.measure_cavities(Form::Plane, &Unwatched).unwrap();
            let what = format!("{shape:?}, {profile} rim of {height_um} um, {width_um} um wide");
            assert_eq!(found.cavities.iter().filter(|cavity| cavity.depth_m.is_some()).count(), cut.len(), "{what}");

            let truth_m = mean(&|cut| cut.rim_height_m);
            agrees(found.rim.height_m, truth_m, &what);
            let std_m =
                (mean(&|cut| (cut.rim_height_m - truth_m).powi(2)) * cut.len() as f64 / (cut.len() - 1) as f64).sqrt();
            let found_std = found.rim.height_std_m.unwrap();
            // Among two dozen patterns, one is expected to deviate by more than two errors.
            let allowed_m = 3.0 * found_std.error.unwrap();
            assert!((found_std.value - std_m).abs() < allowed_m, "{what}: {found_std:?}, not {std_m}");
            let width = found.rim.width_m.unwrap();
            assert!((width.value - width_um * 1e-6).abs() <= 3.0 * width.error.unwrap(), "{what}: {width:?}");
            if height_um >= 0.3 {
                assert_eq!(found.rim.profile, Some(profile), "{what}");
            }
            if let Some(share) = found.rim.share_of_edge {
                assert!(share.value > 1.0 - 3.0 * share.error.unwrap().max(0.01), "{what}: {share:?}");
            }
            // Walls of 10 um, with any rim; no rim changes the depth.
            let angle = found.wall_angle_deg.unwrap();
            let truth = (mean(&|cut| cut.depth_m) / 10e-6).atan().to_degrees();
            assert!((angle.value - truth).abs() < 1.0 + 2.0 * angle.error.unwrap(), "{what}: {angle:?}, not {truth}");
            // A roughness of 0.2 um causes an error of itself over the root of the number of cavities.
            let depth = found.depth.unwrap();
            assert!(
                (depth.mean_m - mean(&|cut| cut.depth_m)).abs() < 0.2e-6 / (cut.len() as f64).sqrt() + 0.05e-6,
                "{what}: {depth:?}"
            );
            for (cut, found) in cut.iter().filter_map(|cut| {
                let near =
                    |found: &&Cavity| (0..2).all(|axis| (found.center_m[axis] - cut.center_m[axis]).abs() < 20e-6);
                found.cavities.iter().find(near).map(|found| (cut, found))
            }) {
                let rim = found.rim_height_m.unwrap();
                let off_m = (rim.value - cut.rim_height_m).abs();
                assert!(off_m < 4.0 * rim.error.unwrap() + 0.1 * truth_m, "{what}: {rim:?} of {cut:?}");
            }
        }
    }
}

#[test]
fn surfaces_without_rims_have_none() {
    for (seed, shape) in
        (40..).zip([CutShape::Groove, CutShape::Square, CutShape::Disc, CutShape::Groove, CutShape::Square])
    {
        let (map, _) = measured(&CutPattern { shape, seed: seed.into(), ..PATTERN }, seed);
        let rim = map.measure_cavities(Form::Plane, &Unwatched).unwrap().rim;
        let height = rim.height_m.unwrap();
        assert!(
            height.value.abs() < 2.5 * height.error.unwrap() && height.value.abs() < 0.02e-6,
            "{shape:?}: {height:?}"
        );
        assert_eq!((rim.width_m, rim.profile, rim.height_std_m), (None, None, None), "{shape:?}");
        assert_eq!(rim.share_of_edge, Some(Estimate { value: 0.0, error: None }));
        assert!(rim.fitted_m(rim.start_m + 1e-6) == 0.0);
    }
}

#[test]
fn the_share_of_an_edge_with_a_rim_is_found_and_the_height_is_its_mean() {
    for (seed, height_um) in [(60, 0.3), (61, 1.0), (62, 3.0)] {
        let pattern = CutPattern { seed: seed.into(), ..PATTERN };
        let (bare, _) = measured(&pattern, seed);
        let (rimmed, _) = measured(&CutPattern { rim: rim(height_um, 14.0, RimProfile::Round, 0.0), ..pattern }, seed);
        // Rims along 60 % of the grooves, in two pieces.
        let has_rim = |j: usize| (100..300).contains(&j) || (400..507).contains(&j);
        let map = bare.changed(|n, height| if has_rim(n % 512) { rimmed.heights_m()[n] } else { height });
        let found = map.measure_cavities(Form::Plane, &Unwatched).unwrap().rim;
        let share = found.share_of_edge.unwrap();
        assert!(
            (share.value - 0.6).abs() < 0.05 + 2.0 * share.error.unwrap() && share.error.unwrap() < 0.12,
            "{share:?}"
        );
        agrees(found.height_m, 0.6e-6 * height_um, "rims in pieces");
    }
}

#[test]
fn a_rim_that_the_pixels_do_not_resolve_has_no_height() {
    let (map, _) = measured(&CutPattern { rim: rim(1.0, 4.0, RimProfile::Round, 0.0), ..PATTERN }, 70);
    let rim = map.measure_cavities(Form::Plane, &Unwatched).unwrap().rim;
    assert_eq!((rim.height_m, rim.width_m, rim.share_of_edge), (None, None, None));
    assert_eq!(rim.unknown, Some(RimUnknown::TooSmall));
    assert!(rim.edge_profile.len() > 20 && rim.edge_profile[0].height_m > 0.05e-6);
}

#[test]
fn walls_steeper_than_pixels_resolve_say_so_and_floors_have_their_roughness() {
    let (map, _) = measured(&CutPattern { wall_m: 0.0, ..PATTERN }, 80);
    let found = map.measure_cavities(Form::Plane, &Unwatched).unwrap();
    // Pixels of 2 um: walls three pixels wide have the slope atan(5.2/6), and these are steeper.
    let resolved = found.wall_resolved_deg.unwrap();
    assert!((resolved - (5.2_f64 / 6.0).atan().to_degrees()).abs() < 1.0, "{resolved}");
    assert!(found.wall_angle_deg.unwrap().value > resolved);
    // The middle thirds extend over the whole map: their roughness is that of the land without the longest waves
    // across.
    let floor = found.floor_sq_m.unwrap();
    assert!((floor.value / found.land_sq_m - 1.0).abs() < 0.2, "{floor:?} {}", found.land_sq_m);

    let mut smooth = HeightMap::new(200, 200, 1e-6, 1e-6, vec![0.0; 40_000]).unwrap();
    let rim = rim(0.5, 8.0, RimProfile::Flat, 0.0);
    smooth
        .cut_cavities(&CutPattern { width_m: 20e-6, spacing_m: 50e-6, depth_m: 5.2e-6, wall_m: 4e-6, rim, ..GROOVES })
        .unwrap();
    let found = smooth.measure_cavities(Form::Plane, &Unwatched).unwrap();
    let rim = found.rim.height_m.unwrap();
    assert!((rim.value - 0.5e-6).abs() < 5e-9 && (found.rim.width_m.unwrap().value - 8e-6).abs() < 0.2e-6, "{rim:?}");
    // The adjacent land is that without the rim, to a hundredth of its height.
    assert!((found.depth.unwrap().mean_m - 5.2e-6).abs() < 5e-9, "{:?}", found.depth);
    assert!(found.floor_sq_m.unwrap().value < 1e-12);
    let angle_deg = found.wall_angle_deg.unwrap().value;
    assert!((angle_deg - (5.2_f64 / 4.0).atan().to_degrees()).abs() < 0.02, "{angle_deg}");
}

/// Grooves of 100 um, 150 um apart and 8 um deep, on a map of roughness Sa 0.158 um with pixels of `pixel_um`, with
/// straight walls `wall_um` wide that rise to the top of the rim, which declines outward as a ramp over 20 um.
fn walls_up_to_rims(pixel_um: f64, wall_um: f64, rim_um: f64) -> HeightMap {
    let pixels = (1024.0 / pixel_um) as usize;
    let map = SelfAffine { side_m: 1.024e-3, pixels, max_wave: 100, ..SelfAffine::STAND_IN }.map().unwrap();
    map.changed(|n, height_m| {
        let x_um = ((n / pixels) as f64 + 0.5) * pixel_um;
        let beyond_um = 50.0 - (x_um.rem_euclid(250.0) - 125.0).abs();
        let out_um = -beyond_um - 0.5 * wall_um;
        let profile_um = if out_um > 0.0 {
            rim_um * (1.0 - out_um / 20.0).max(0.0)
        } else {
            (rim_um + (8.0 + rim_um) / wall_um * out_um).max(-8.0)
        };
        height_m + 1e-6 * profile_um
    })
}

#[test]
fn the_top_of_a_wall_is_found_however_many_pixels_the_wall_spans() {
    for (pixel_um, wall_um) in [(1.0, 8.0), (1.0, 12.0), (1.0, 30.0), (2.0, 12.0), (2.0, 30.0)] {
        for rim_um in [0.0, 0.5, 2.0] {
            let found = walls_up_to_rims(pixel_um, wall_um, rim_um).measure_cavities(Form::Plane, &Unwatched).unwrap();
            let what =
                format!("pixels of {pixel_um} um, wall of {wall_um} um, rim of {rim_um} um: {:?}", found.rim.height_m);
            let angle_deg = ((8.0 + rim_um) / wall_um).atan().to_degrees();
            assert!(
                (found.wall_angle_deg.unwrap().value - angle_deg).abs() < 2.0,
                "{what}: {:?}",
                found.wall_angle_deg
            );
            if rim_um == 0.0 {
                assert!(found.rim.width_m.is_none() && found.rim.height_m.unwrap().value.abs() < 0.02e-6, "{what}");
            } else {
                agrees(found.rim.height_m, 1e-6 * rim_um, &what);
                assert_eq!(found.rim.profile, Some(RimProfile::Ramp), "{what}");
            }
            // The floors' roughness of 0.2 um gives all maps the same depth.
            assert!((found.depth.unwrap().mean_m - 7.92e-6).abs() < 0.01e-6, "{what}: {:?}", found.depth);
        }
    }
}

#[test]
fn rims_that_leave_no_land_have_no_height() {
    for (seed, width_um) in (90..).zip([60.0, 65.0, 70.0]) {
        for profile in RimProfile::ALL {
            let mut map = SelfAffine { side_m: 1.024e-3, seed, ..SelfAffine::STAND_IN }.map().unwrap();
            // Rims 70 um wide meet, as walls are 10 um wide; flat ones are then land.
            let most_um = if profile == RimProfile::Flat { 66.0 } else { 70.0 };
            let rim = rim(1.5, f64::min(width_um, most_um), profile, 0.0);
            let pattern =
                CutPattern { width_m: 100e-6, spacing_m: 150e-6, depth_m: 8e-6, wall_m: 10e-6, rim, ..GROOVES };
            map.cut_cavities(&pattern).unwrap();
            let rim = map.measure_cavities(Form::Plane, &Unwatched).unwrap().rim;
            assert_eq!((rim.height_m, rim.width_m, rim.unknown), (None, None, Some(RimUnknown::NoLand)), "{width_um}");
        }
    }
}

#[test]
fn a_relief_that_is_no_rim_has_no_height_of_one() {
    let mut map = SelfAffine { side_m: 1.024e-3, ..SelfAffine::STAND_IN }.map().unwrap();
    map.cut_cavities(&CutPattern { width_m: 60e-6, spacing_m: 140e-6, ..GROOVES }).unwrap();
    // A step up of 1 um next to the cavity, and a trough of 1 um behind.
    let map = map.changed(|n, height_m| {
        let beyond_um = (2.0 * (n / 512) as f64 + 1.0).rem_euclid(200.0);
        match (beyond_um - 100.0).abs() - 30.0 {
            0.0..15.0 => height_m + 1e-6,
            15.0..30.0 => height_m - 1e-6,
            _ => height_m,
        }
    });
    let rim = map.measure_cavities(Form::Plane, &Unwatched).unwrap().rim;
    assert_eq!((rim.height_m, rim.unknown), (None, Some(RimUnknown::Misfit)), "{:?}", rim.width_m);
    assert!(!rim.edge_profile.is_empty());
}

#[test]
fn rims_of_grooves_across_the_fine_side_of_oblong_pixels_are_measured() {
    // A rim of 10 fine pixels, and of 3.3 coarse ones.
    let noise = |n: usize| (splitmix64(n as u64) >> 11) as f64 / (1_u64 << 53) as f64 - 0.5;
    let mut map = HeightMap::new(800, 150, 2e-6, 6e-6, (0..120_000).map(|n| 0.2e-6 * noise(n)).collect()).unwrap();
    let rim = rim(0.4, 20.0, RimProfile::Round, 0.0);
    map.cut_cavities(&CutPattern { shape: CutShape::Groove, wall_m: 12e-6, rim, ..PATTERN }).unwrap();
    for map in [map.transposed(), map] {
        let found = map.measure_cavities(Form::Plane, &Unwatched).unwrap().rim;
        agrees(found.height_m, 0.4e-6, "height");
        agrees(found.width_m, 20e-6, "width");
    }
}
