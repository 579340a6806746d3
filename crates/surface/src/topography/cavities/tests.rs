use slipgrid_base::monitor::Unwatched;

use super::cut::tests::GROOVES;
use super::*;
use crate::topography::{Crop, SelfAffine};

/// A rough map of 5 um pixels, 2.56 mm wide, like the measured flat surface.
fn rough() -> HeightMap {
    SelfAffine { side_m: 2.56e-3, ..SelfAffine::STAND_IN }.map().unwrap()
}

/// The published cavities: 130 +- 8 um wide, 370 +- 13 um apart, 5.2 +- 1.3 um deep.
pub(super) const PUBLISHED: CutPattern = CutPattern {
    shape: CutShape::Groove,
    width_m: 130e-6,
    spacing_m: 370e-6,
    depth_m: 5.2e-6,
    wall_m: 10e-6,
    width_std_m: 8e-6,
    pitch_std_m: 13e-6,
    depth_std_m: 1.3e-6,
    rim: None,
    seed: 7,
};

/// Tilted by 20 um along x and -12 um along y.
fn tilted(map: &HeightMap) -> HeightMap {
    let (rows, cols) = (map.rows() as f64, map.cols());
    map.changed(|n, height| height + 20e-6 * (n / cols) as f64 / rows - 12e-6 * (n % cols) as f64 / cols as f64)
}

/// Removes every `every`-th point, and most points of the steep walls.
fn holed(map: &HeightMap, every: usize) -> HeightMap {
    let cols = map.cols();
    map.changed(|n, height| {
        let steep = n >= cols && (map.heights_m()[n - cols] - height).abs() > 0.5e-6;
        let lost = |of: usize| (n * 7919 + n / cols * 104_729).is_multiple_of(of);
        if lost(every) || steep && !lost(3) { f64::NAN } else { height }
    })
}

fn expected(values: impl Iterator<Item = f64> + Clone) -> Spread {
    Spread::of(values).unwrap()
}

fn close(found: Option<Spread>, expected: Spread, mean_m: f64, std_m: f64) {
    let found = found.unwrap();
    assert!(
        (found.mean_m - expected.mean_m).abs() < mean_m && (found.std_m - expected.std_m).abs() < std_m,
        "{found:?} and {expected:?}"
    );
    assert_eq!(found.count, expected.count);
}

#[test]
fn a_smooth_pattern_is_measured_exactly() {
    let mut map = HeightMap::new(500, 200, 1e-6, 2e-6, vec![0.0; 100_000]).unwrap();
    map.cut_cavities(&CutPattern { wall_m: 6e-6, ..GROOVES }).unwrap();
    let found = map.measure_cavities(Form::Plane, &Unwatched).unwrap();
    assert_eq!(found.cavities.len(), 5);
    close(found.width[0], Spread { mean_m: 30e-6, std_m: 0.0, count: 5 }, 1e-9, 1e-9);
    close(found.spacing[0], Spread { mean_m: 70e-6, std_m: 0.0, count: 4 }, 1e-9, 1e-9);
    close(found.depth, Spread { mean_m: 5e-6, std_m: 0.0, count: 5 }, 1e-12, 1e-12);
    assert_eq!((found.width[1], found.spacing[1]), (None, None));
    assert!((found.area_fraction - 0.3).abs() < 1e-12 && found.land_sq_m < 1e-12);
    assert!((found.cavities[1].center_m[0] - 150e-6).abs() < 1e-9);
}

#[test]
fn rough_grooves_with_scatter_tilt_and_holes() {
    let mut map = rough();
    let cut = map.cut_cavities(&PUBLISHED).unwrap();
    // The sixth groove begins at 2.685 mm, outside the map.
    let cut = &cut[..5];
    assert!(cut[4].center_m[0] + cut[4].width_m < 2.56e-3);
    let width = expected(cut.iter().map(|cavity| cavity.width_m));
    let depth = expected(cut.iter().map(|cavity| cavity.depth_m));
    let spacing = expected(
        cut.windows(2)
            .map(|pair| pair[1].center_m[0] - pair[0].center_m[0] - 0.5 * (pair[0].width_m + pair[1].width_m)),
    );
    for map in [map.clone(), tilted(&map), holed(&map, 20), holed(&tilted(&map), 20)] {
        let found = map.measure_cavities(Form::Plane, &Unwatched).unwrap();
        // A tenth of a pixel, even if two of three points on the walls are missing.
        close(found.width[0], width, 0.5e-6, 0.5e-6);
        close(found.spacing[0], spacing, 0.5e-6, 0.5e-6);
        // The roughness of 0.2 um, in waves up to 0.64 mm long, has at least four independent parts along each of five
        // floors: the mean has an error of 0.2/sqrt 20 um, of which twice is allowed.
        close(found.depth, depth, 0.09e-6, 0.1e-6);
        assert!((found.land_sq_m - 0.2e-6).abs() < 0.03e-6, "{}", found.land_sq_m);
        assert_eq!((found.cavities.len(), found.width[1]), (5, None));
    }
}

#[test]
fn every_groove_has_its_own_depth_wherever_its_walls_fall_on_the_pixels() {
    for seed in 1..=4 {
        let mut map = rough();
        let cut = map.cut_cavities(&CutPattern { seed, ..PUBLISHED }).unwrap();
        let found = map.measure_cavities(Form::Plane, &Unwatched).unwrap().cavities;
        // Cavities shallower than half the depth of the others are not detected.
        let whole = |cut: &&CutCavity| cut.center_m[0] + cut.width_m < 2.56e-3 && cut.depth_m > 3.2e-6;
        for cut in cut.iter().filter(whole) {
            let near = |found: &&Cavity| (cut.center_m[0] - found.center_m[0]).abs() < 10e-6;
            let found = found.iter().find(near).unwrap_or_else(|| panic!("seed {seed}: {cut:?} in {found:?}"));
            // Roughness of 0.2 um changes the levels of a floor and its land by a fraction of itself.
            let error = found.depth_m.unwrap() - cut.depth_m;
            assert!(error.abs() < 0.15e-6, "seed {seed}, depth {}: off by {error}", cut.depth_m);
        }
    }
}

#[test]
fn rough_squares_along_both_axes() {
    let mut map = rough();
    let pattern = CutPattern { shape: CutShape::Square, depth_std_m: 0.5e-6, ..PUBLISHED };
    let cut = map.cut_cavities(&pattern).unwrap();
    let whole: Vec<_> =
        cut.iter().filter(|cavity| cavity.center_m.iter().all(|c| c + cavity.width_m < 2.56e-3)).collect();
    assert_eq!(whole.len(), 25);
    let width = expected(whole.iter().map(|cavity| cavity.width_m));
    let depth = expected(whole.iter().map(|cavity| cavity.depth_m));
    let found = holed(&tilted(&map), 20).measure_cavities(Form::Plane, &Unwatched).unwrap();
    close(found.width[0], width, 1e-6, 1e-6);
    close(found.width[1], width, 1e-6, 1e-6);
    // The mean of 25 floors has an error of 0.2/sqrt 25 um; scatter of 0.4 um and of 0.2 um add as squares.
    close(found.depth, depth, 0.08e-6, 0.08e-6);
    let [x, y] = found.spacing.map(Option::unwrap);
    assert_eq!((x.count, y.count), (20, 20));
    assert!((x.mean_m - 370e-6).abs() < 5e-6 && (y.mean_m - 370e-6).abs() < 5e-6, "{x:?} {y:?}");
    // 6.8 % of the surface, like the published squares.
    assert!((found.area_fraction - 25.0 * 0.0169 / 6.5536).abs() < 2e-3, "{}", found.area_fraction);
}

#[test]
fn walls_of_three_quarters_of_the_width_hide_no_cavity_and_no_depth() {
    for (shape, count) in [(CutShape::Groove, 5), (CutShape::Square, 25), (CutShape::Disc, 25)] {
        for wall_m in [0.0, 40e-6, 60e-6] {
            let mut map = SelfAffine { side_m: 1.024e-3, sa_m: 0.05e-6, ..SelfAffine::STAND_IN }.map().unwrap();
            let pattern = CutPattern { shape, width_m: 80e-6, spacing_m: 120e-6, depth_m: 8e-6, wall_m, ..GROOVES };
            map.cut_cavities(&pattern).unwrap();
            let found = holed(&map, 20).measure_cavities(Form::Plane, &Unwatched).unwrap();
            let width = found.width[0].unwrap();
            assert_eq!((found.cavities.len(), width.count), (count, count), "{shape:?} {wall_m}");
            // The wall falls by 8 um in 60, so that roughness of 0.06 um moves an edge by 0.5 um.
            assert!((width.mean_m - 80e-6).abs() < 0.4e-6, "{shape:?} {wall_m}: {width:?}");
            // The floor of a disc, 20 um wide, is not the middle tenth of every chord.
            let allowed_m = if shape == CutShape::Disc && wall_m > 50e-6 { 0.2e-6 } else { 0.05e-6 };
            let depth = found.depth.unwrap();
            assert!((depth.mean_m - 8e-6).abs() < allowed_m, "{shape:?} {wall_m}: {depth:?}");
        }
    }
}

#[test]
fn a_turned_groove_has_its_width_and_depth() {
    // Grooves 80 um wide, 120 um apart, turned by up to 5 deg, on 512 x 512 pixels of 2 um: no line runs from side to side.
    for angle_deg in [0.5_f64, 2.0, 5.0] {
        let (sin, cos) = angle_deg.to_radians().sin_cos();
        let height = |n: usize| {
            let along_um = 2.0 * (cos * (n / 512) as f64 - sin * (n % 512) as f64);
            let inside_um = 40.0 - (along_um.rem_euclid(200.0) - 100.0).abs();
            -8e-6 * (inside_um / 10.0 + 0.5).clamp(0.0, 1.0)
        };
        let map = HeightMap::new(512, 512, 2e-6, 2e-6, (0..512 * 512).map(height).collect()).unwrap();
        let found = map.measure_cavities(Form::Plane, &Unwatched).unwrap();
        let whole = if angle_deg > 4.0 { 4 } else { 5 };
        close(found.width[0], Spread { mean_m: 80e-6 / cos, std_m: 0.0, count: whole }, 0.01e-6, 0.01e-6);
        close(found.depth, Spread { mean_m: 8e-6, std_m: 0.0, count: whole }, 1e-9, 1e-9);
        // To a twentieth of a pixel: the gaps of a turned groove scatter with the places where lines cross it.
        assert!((found.spacing[0].unwrap().mean_m - 120e-6 / cos).abs() < 0.1e-6, "{:?}", found.spacing);
    }
}

/// The median of chords is a whole number of pixels, up to half a pixel off.
#[test]
fn a_turned_groove_with_vertical_walls_has_its_width() {
    for width_um in [80.4_f64, 81.0, 81.6] {
        let (sin, cos) = 3.0_f64.to_radians().sin_cos();
        let height = |n: usize| {
            let along_um = 2.0 * (cos * (n / 512) as f64 - sin * (n % 512) as f64);
            if (along_um.rem_euclid(200.0) - 100.0).abs() < 0.5 * width_um { -8e-6 } else { 0.0 }
        };
        let map = HeightMap::new(512, 512, 2e-6, 2e-6, (0..512 * 512).map(height).collect()).unwrap();
        let found = map.measure_cavities(Form::Plane, &Unwatched).unwrap();
        let [width_m, spacing_m] = [found.width[0], found.spacing[0]].map(|of| of.unwrap().mean_m);
        // A tenth of a pixel of 2 um.
        assert!((width_m * 1e6 - width_um / cos).abs() < 0.2, "{width_um}: {width_m}");
        assert!((spacing_m * 1e6 - (200.0 - width_um) / cos).abs() < 0.2, "{width_um}: {spacing_m}");
    }
}

#[test]
fn a_curved_specimen_needs_the_second_order() {
    let mut map = rough();
    map.cut_cavities(&PUBLISHED).unwrap();
    let cols = map.cols();
    let bowed = map.changed(|n, height| height - 60e-6 * ((n / cols) as f64 / 512.0 - 0.4).powi(2));
    let straight = map.measure_cavities(Form::Plane, &Unwatched).unwrap();
    let found = bowed.measure_cavities(Form::SecondOrder, &Unwatched).unwrap();
    close(found.depth, straight.depth.unwrap(), 0.05e-6, 0.05e-6);
    close(found.width[0], straight.width[0].unwrap(), 0.5e-6, 0.5e-6);
}

#[test]
fn noise_of_single_pixels_and_specks_do_no_harm() {
    let mut map = rough();
    let cut = map.cut_cavities(&PUBLISHED).unwrap();
    let noisy = map.changed(|n, height| {
        let noise = ((n * 2_654_435_761) >> 7) % 2001;
        let spike = if n % 9973 == 0 { 30e-6 } else { 0.0 };
        let pit = if n % 7001 == 0 { -12e-6 } else { 0.0 };
        height + (noise as f64 - 1000.0) * 0.8e-9 + spike + pit
    });
    let found = noisy.measure_cavities(Form::Plane, &Unwatched).unwrap();
    assert_eq!(found.cavities.len(), 5);
    close(found.width[0], expected(cut[..5].iter().map(|cavity| cavity.width_m)), 1.5e-6, 1.5e-6);
    close(found.depth, expected(cut[..5].iter().map(|cavity| cavity.depth_m)), 0.1e-6, 0.1e-6);
}

#[test]
fn surfaces_without_cavities_are_refused() {
    let refused = |map: &HeightMap| map.measure_cavities(Form::Plane, &Unwatched).unwrap_err().to_string();
    assert!(refused(&rough()).contains("do not part"));
    assert!(refused(&HeightMap::new(4, 4, 1e-6, 1e-6, vec![1e-6; 16]).unwrap()).contains("equal"));
    let ramp = HeightMap::new(50, 50, 1e-6, 1e-6, (0..2500).map(|n| f64::from(n / 50) * 1e-7).collect()).unwrap();
    assert!(ramp.measure_cavities(Form::Mean, &Unwatched).is_err());
}

#[test]
fn grooves_that_cross_are_named_and_a_strip_between_two_shows_one_family() {
    // Grooves of 10 of 50 pixels along both axes; the map's sides cut none.
    let map = rough();
    let in_groove = |k: usize| (20..30).contains(&(k % 50));
    let cols = map.cols();
    let crossed = map.changed(|n, height| height - if in_groove(n / cols) || in_groove(n % cols) { 8e-6 } else { 0.0 });
    let found = crossed.measure_cavities(Form::Plane, &Unwatched).unwrap();
    let crossing = found.crossing.unwrap();
    let [Some([first, last]), Some(columns)] = crossing.strips else { panic!("{crossing}") };
    assert!(first >= 30 && last - first > 20 && columns == [first, last], "{crossing}");
    let refused = crossed.mean_cavity_period(Form::Plane, &Unwatched).unwrap_err().to_string();
    assert!(
        refused.contains("grooves that cross") && refused.contains(&format!("columns {first} to {last}")),
        "{refused}"
    );
    let strip = Crop { first_row: first, first_col: 0, rows: last + 1 - first, cols };
    let strip = crossed.windowed(Some(strip), None).unwrap();
    let found = strip.measure_cavities(Form::Plane, &Unwatched).unwrap();
    let width = found.width[1].unwrap();
    assert!((width.mean_m - 10.0 * map.dy_m()).abs() < 0.5 * map.dy_m() && found.crossing.is_none(), "{width:?}");
    assert!(strip.mean_cavity_period(Form::Plane, &Unwatched).is_ok());
    // Grooves of one family, and squares, do not cross.
    for shape in [CutShape::Groove, CutShape::Square] {
        let mut map = rough();
        map.cut_cavities(&CutPattern { shape, ..PUBLISHED }).unwrap();
        assert_eq!(map.measure_cavities(Form::Plane, &Unwatched).unwrap().crossing, None);
    }
}

#[test]
fn slivers_of_a_turned_grid_are_no_neighbours_of_what_lies_far_behind() {
    // Squares of 90 um, 200 um apart, rotated by 12 deg, on 600 x 700 pixels of 2 um.
    let (sin, cos) = 12_f64.to_radians().sin_cos();
    let off = |along_um: f64| 45.0 - (along_um.rem_euclid(200.0) - 100.0).abs();
    let height = |n: usize| {
        let (x, y) = (2.0 * (n / 700) as f64, 2.0 * (n % 700) as f64);
        let inside_um = off(cos * x - sin * y + 23.0).min(off(sin * x + cos * y + 37.0));
        -6e-6 * (inside_um / 8.0 + 0.5).clamp(0.0, 1.0)
    };
    let map = HeightMap::new(600, 700, 2e-6, 2e-6, (0..420_000).map(height).collect()).unwrap();
    let found = map.measure_cavities(Form::Plane, &Unwatched).unwrap();
    for spacing in found.spacing.map(Option::unwrap) {
        // 110 um, seen at 12 deg.
        assert!((spacing.mean_m - 110e-6 / cos).abs() < 1e-6 && spacing.std_m < 1e-6, "{spacing:?}");
        assert!(spacing.count >= 15);
    }
}

#[test]
fn a_sliver_of_a_cavity_at_the_map_s_side_is_no_land_of_its_neighbour() {
    for shape in [CutShape::Square, CutShape::Disc] {
        let mut whole = HeightMap::new(360, 360, 1e-6, 1e-6, vec![0.0; 360 * 360]).unwrap();
        // The fifth cavities begin at 290 um.
        whole.cut_cavities(&CutPattern { shape, width_m: 50e-6, spacing_m: 20e-6, ..GROOVES }).unwrap();
        for cols in 288..300 {
            let crop = Crop { first_row: 0, first_col: 0, rows: 288, cols };
            let found = whole.windowed(Some(crop), None).unwrap().measure_cavities(Form::Plane, &Unwatched).unwrap();
            // To a thousandth: the smallest slivers of discs leave points of their walls.
            close(found.depth, Spread { mean_m: 5e-6, std_m: 0.0, count: 16 }, 5e-9, 5e-9);
            close(found.spacing[1], Spread { mean_m: 20e-6, std_m: 0.0, count: 12 }, 0.2e-6, 1e-9);
        }
    }
}
