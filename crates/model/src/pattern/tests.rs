//! Patterns compared with closed forms and with brute force.

use super::*;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use std::f64::consts::PI;

/// All kinds of patterns with these dimensions, in micrometres.
fn kinds(width: f64, spacing: f64, length: f64, spacing_across: f64) -> Vec<Pattern> {
    let pattern = |texture: Texture| Pattern::new(texture, width * 1e-6, spacing * 1e-6, 20e-6).unwrap();
    let mut patterns = vec![pattern(Planform::Groove.into())];
    for planform in [Planform::Square, Planform::Rectangle, Planform::Disc] {
        for arrangement in Arrangement::ALL {
            let texture = Texture::new(planform).with_arrangement(arrangement).unwrap();
            if arrangement == Arrangement::Hexagonal {
                // Hexagonal rows determine their distance; there is no pattern if squares would overlap.
                patterns.extend(Pattern::new(texture, width * 1e-6, spacing * 1e-6, 20e-6));
                continue;
            }
            let texture = texture.with_spacing_across_m(spacing_across * 1e-6).unwrap();
            patterns.push(pattern(texture));
            if planform == Planform::Rectangle {
                patterns.push(pattern(texture.with_length_m(length * 1e-6).unwrap()));
            }
        }
    }
    patterns
}

/// An L, concave and without symmetry, 100 by 70.
const L: [[f64; 2]; 6] = [[0.0, 0.0], [100.0, 10.0], [90.0, 40.0], [45.0, 35.0], [40.0, 70.0], [5.0, 65.0]];

/// Patterns of polygons and of crossing grooves.
fn further_kinds(width: f64, spacing: f64, spacing_across: f64) -> Vec<Pattern> {
    let pattern = |texture: Texture| Pattern::new(texture, width * 1e-6, spacing * 1e-6, 20e-6).unwrap();
    let bent = Texture::new(Planform::Polygon).with_outline(Polygon::new(&L).unwrap()).unwrap();
    let bent = bent.with_spacing_across_m(spacing_across * 1e-6).unwrap();
    let crossed = Texture::new(Planform::Crosshatch);
    let textures = [
        Texture::new(Planform::Polygon),
        bent,
        bent.with_arrangement(Arrangement::Staggered).unwrap(),
        crossed.with_groove_angle_deg(20.0).unwrap(),
        crossed.with_crossing_angle_deg(55.0).unwrap(),
        crossed.with_crossing_angle_deg(20.0).unwrap(),
    ];
    textures.map(pattern).to_vec()
}

/// All patterns of [`kinds`] and [`further_kinds`].
fn all_kinds(width: f64, spacing: f64, length: f64, spacing_across: f64) -> Vec<Pattern> {
    [kinds(width, spacing, length, spacing_across), further_kinds(width, spacing, spacing_across)].concat()
}

/// Whether a point lies in a cavity, by testing all cavities near it.
fn contains(pattern: &Pattern, point_m: [f64; 2]) -> bool {
    if pattern.planform() == Planform::Crosshatch {
        // Inside one of the families, whose width directions are at angles to the specimen's X.
        return pattern.texture().families_deg().any(|angle_deg| {
            let turned = (angle_deg - pattern.texture().orientation_deg()).to_radians();
            let away = (point_m[0] * turned.cos() + point_m[1] * turned.sin()) / pattern.pitch_m();
            (away - away.round()).abs() * pattern.pitch_m() < pattern.width_m() / 2.0
        });
    }
    let cell_m = pattern.cell_m();
    let (half_x_m, half_y_m) = (pattern.width_m() / 2.0, pattern.length_m().map_or(f64::INFINITY, |l| l / 2.0));
    pattern.centres_m().any(|centre_m| {
        let [x_m, y_m] = [0, 1].map(|axis| {
            let away = (point_m[axis] - centre_m[axis]) / cell_m[axis];
            (away - away.round()) * cell_m[axis]
        });
        match (pattern.planform(), pattern.texture().outline()) {
            (Planform::Disc, _) => x_m.hypot(y_m) < half_x_m,
            (_, Some(outline)) => outline.contains([x_m, y_m].map(|at_m| at_m / pattern.width_m())),
            _ => x_m.abs() < half_x_m && y_m.abs() < half_y_m,
        }
    })
}

#[test]
fn densities_of_the_published_pattern() {
    let pattern = |planform| Pattern::new(planform, 130e-6, 370e-6, 20e-6).unwrap();
    assert!((pattern(Planform::Groove).areal_density() - 0.26).abs() < 1e-12);
    assert!((pattern(Planform::Square).areal_density() - 0.0676).abs() < 1e-12);
    assert_eq!(pattern(Planform::Rectangle).areal_density(), pattern(Planform::Square).areal_density());
    assert!((pattern(Planform::Disc).areal_density() - 0.0676 * PI / 4.0).abs() < 1e-12);
    assert!((pattern(Planform::Square).strip_estimate(0.827) - 0.95502).abs() < 1e-9);
    assert!((pattern(Planform::Groove).strip_estimate(0.827) - 0.827).abs() < 1e-15);
    let long = Texture::new(Planform::Rectangle).with_length_m(390e-6).unwrap().with_spacing_across_m(10e-6).unwrap();
    let long = Pattern::new(long, 130e-6, 370e-6, 20e-6).unwrap();
    assert!((long.areal_density() - 0.26 * 0.975).abs() < 1e-12);
    assert!((long.strip_estimate(0.827) - (1.0 - 0.975 * 0.173)).abs() < 1e-12);
}

#[test]
fn plain_planforms_given_as_polygons_have_the_same_coverage() {
    let box_of = |length: f64| vec![[0.0, 0.0], [3.0, 0.0], [3.0, 3.0 * length], [0.0, 3.0 * length]];
    let rectangle = Texture::new(Planform::Rectangle).with_length_m(77.7e-6).unwrap();
    for (plain, outline, tolerance) in [
        (Texture::new(Planform::Square), box_of(1.0), 1e-12),
        (rectangle, box_of(77.7 / 130.0), 1e-12),
        // Segments between chords and arcs: (2 pi/n)^2/6 of the area, all of it near the edge.
        (Texture::new(Planform::Disc), regular(720, 0.0), 4e-4),
    ] {
        let polygon = Texture::new(Planform::Polygon).with_outline(Polygon::new(&outline).unwrap()).unwrap();
        for arrangement in [Arrangement::Square, Arrangement::Staggered] {
            let [plain, polygon] = [plain, polygon]
                .map(|texture| texture.with_arrangement(arrangement).unwrap().with_spacing_across_m(41.1e-6).unwrap())
                .map(|texture| Pattern::new(texture, 130e-6, 60e-6, 5e-6).unwrap());
            assert!((plain.areal_density() - polygon.areal_density()).abs() < tolerance);
            assert!((plain.strip_estimate(0.8) - polygon.strip_estimate(0.8)).abs() < tolerance);
            for (i, j) in (-20..20).flat_map(|i| (-20..20).map(move |j| (f64::from(i), f64::from(j)))) {
                let (x_m, y_m) = (i * 9.7e-6, j * 11.3e-6);
                let shares = [plain, polygon].map(|p| p.coverage(x_m, x_m + 9.7e-6, y_m, y_m + 11.3e-6));
                assert!((shares[0] - shares[1]).abs() < tolerance, "{plain:?} {i} {j}: {shares:?}");
            }
        }
    }
}

#[test]
fn crossing_grooves_cover_what_either_family_covers() {
    for (crossing_deg, sides) in [(90.0, [1.0, 1.0]), (60.0, [2.0 / 3_f64.sqrt(), 2.0])] {
        let texture = Texture::new(Planform::Crosshatch).with_crossing_angle_deg(crossing_deg).unwrap();
        let texture = texture.with_groove_angle_deg(-30.0).unwrap().with_sliding_angle_deg(10.0).unwrap();
        let pattern = Pattern::new(texture, 100e-6, 150e-6, 5e-6).unwrap();
        // 1 - (1 - 0.4)^2
        assert!((pattern.areal_density() - 0.64).abs() < 1e-15);
        assert_eq!(
            (pattern.least_land_m(), pattern.least_extent_m(), pattern.texture().is_one_section()),
            (150e-6, 100e-6, false)
        );
        let cell_m = pattern.cell_m();
        assert!((0..2).all(|axis| (cell_m[axis] / 250e-6 - sides[axis]).abs() < 1e-12), "{cell_m:?}");
        assert_eq!(pattern.centres_m().count(), if crossing_deg == 90.0 { 1 } else { 2 });
        // The pattern's axes: halfway between the families, or along them for a right angle.
        assert_eq!(texture.orientation_deg(), if crossing_deg == 90.0 { -30.0 } else { 0.0 });
        assert_eq!(texture.families_deg().collect::<Vec<_>>(), [-30.0, crossing_deg - 30.0]);
        // Far inside a groove of one family, along it.
        assert_eq!(pattern.coverage(-1e-6, 1e-6, -1e-6, 1e-6), 1.0);
    }
    // Between crossings, families are independent: a small square on the middle of a groove of the first.
    let texture = Texture::new(Planform::Crosshatch);
    let pattern = Pattern::new(texture, 100e-6, 150e-6, 5e-6).unwrap();
    let groove = Pattern::new(Planform::Groove, 100e-6, 150e-6, 5e-6).unwrap();
    for x_m in [-60e-6, -20e-6, 45e-6, 70e-6] {
        let share = pattern.coverage(x_m, x_m + 30e-6, 0.0, 250e-6);
        // A + B - A B over a period across.
        let alone = groove.coverage(x_m, x_m + 30e-6, 0.0, 250e-6);
        assert!((share - (alone + 0.4 - 0.4 * alone)).abs() < 1e-12, "{share} {alone}");
    }
    let alike = |texture: Texture, angle_deg: f64| texture.slides_alike(angle_deg);
    let square = Texture::new(Planform::Crosshatch).with_sliding_angle_deg(20.0).unwrap();
    assert!(alike(square, 70.0) && alike(square, -20.0) && alike(square, -160.0) && !alike(square, 45.0));
    let rhombic = square.with_crossing_angle_deg(60.0).unwrap();
    // Reflected at the axis halfway between the families, at 30 degrees.
    assert!(alike(rhombic, 40.0) && alike(rhombic, -160.0) && !alike(rhombic, -20.0) && !alike(rhombic, 70.0));
    for bad in [0.0, 9.9, 90.1, f64::NAN] {
        let refused = Texture::new(Planform::Crosshatch).with_crossing_angle_deg(bad).unwrap_err().to_string();
        assert!(refused.contains("expected 10 to 90"), "{refused}");
    }
    assert!(Texture::new(Planform::Groove).with_crossing_angle_deg(60.0).is_err());
    assert!(texture.with_spacing_across_m(1e-5).is_err() && texture.with_length_m(1e-5).is_err());
    assert!(texture.with_arrangement(Arrangement::Staggered).is_err());
}

#[test]
fn whole_blocks_are_covered_wholly_or_not_at_all() {
    // Cells of 50 columns of 10 um with a cavity of 13, and odd numbers of both; positioned as in the two-dimensional
    // model, floor((m - c) / 2) columns before the cavity.
    for (columns, cavity) in [(50_u32, 13_u32), (51, 13), (50, 12), (7, 3), (200, 199)] {
        let side_m = 10e-6;
        let [width_m, spacing_m] = [cavity, columns - cavity].map(|blocks| f64::from(blocks) * side_m);
        let before = (columns - cavity) / 2;
        let centre_m = (f64::from(before) + f64::from(cavity) / 2.0) * side_m;
        for planform in [Planform::Groove, Planform::Square] {
            let pattern = Pattern::new(planform, width_m, spacing_m, 20e-6).unwrap();
            for (i, j) in (0..columns).flat_map(|i| (0..columns).map(move |j| (i, j))) {
                let edge_m = |block: u32| f64::from(block) * side_m - centre_m;
                let share = pattern.coverage(edge_m(i), edge_m(i + 1), edge_m(j), edge_m(j + 1));
                let inside = |block: u32| (before..before + cavity).contains(&block);
                let expected = inside(i) && (planform == Planform::Groove || inside(j));
                assert_eq!(share, f64::from(u8::from(expected)), "{planform} {columns} {cavity}: {i} {j}");
            }
        }
    }
}

#[test]
fn a_staggered_row_is_the_first_half_a_pitch_aside() {
    for planform in [Planform::Square, Planform::Rectangle, Planform::Disc] {
        let texture = Texture::new(planform).with_arrangement(Arrangement::Staggered).unwrap();
        let pattern = Pattern::new(texture.with_spacing_across_m(50e-6).unwrap(), 130e-6, 370e-6, 20e-6).unwrap();
        assert_eq!(pattern.centres_m().count(), 2);
        let [cell_x_m, cell_y_m] = pattern.cell_m();
        assert!((cell_x_m - 500e-6).abs() < 1e-18 && (cell_y_m - 360e-6).abs() < 1e-18);
        for (x_m, y_m) in [(0.0, 0.0), (40e-6, 52e-6), (60e-6, 10e-6), (-70e-6, -60e-6)] {
            let at = |x_m: f64, y_m: f64| pattern.coverage(x_m, x_m + 17e-6, y_m, y_m + 9e-6);
            let aside = at(x_m + 250e-6, y_m + 180e-6);
            assert!((at(x_m, y_m) - aside).abs() < 1e-12, "{planform} {x_m} {y_m}");
            assert!((at(x_m, y_m) - at(x_m - 250e-6, y_m + 180e-6)).abs() < 1e-12);
        }
    }
}

#[test]
fn hexagonal_cavities_have_six_neighbours_at_one_pitch() {
    let hexagonal = |planform| Texture::new(planform).with_arrangement(Arrangement::Hexagonal).unwrap();
    for (planform, width_um, spacing_um) in
        [(Planform::Disc, 100.0, 40.0), (Planform::Disc, 100.0, 3.0), (Planform::Square, 60.0, 90.0)]
    {
        let pattern = Pattern::new(hexagonal(planform), width_um * 1e-6, spacing_um * 1e-6, 20e-6).unwrap();
        let (pitch_m, cell_m) = (pattern.pitch_m(), pattern.cell_m());
        let mut near = 0;
        for (i, j, [x_m, y_m]) in (-2..=2)
            .flat_map(|i| (-2..=2).map(move |j| (i, j)))
            .flat_map(|(i, j)| pattern.centres_m().map(move |centre_m| (i, j, centre_m)))
        {
            let away_m = (x_m + f64::from(i) * cell_m[0]).hypot(y_m + f64::from(j) * cell_m[1]);
            assert!(away_m < 1e-12 || away_m > pitch_m * (1.0 - 1e-12), "{planform} {away_m}");
            near += usize::from((away_m / pitch_m - 1.0).abs() < 1e-9);
        }
        assert_eq!(near, 6, "{planform}");
    }
    // The land of a disc equals its spacing bit by bit, so that a limit of this length is satisfied.
    let disc = Pattern::new(hexagonal(Planform::Disc), 100e-6, 40e-6, 20e-6).unwrap();
    assert_eq!(disc.least_land_m(), 40e-6);
    assert!((disc.areal_density() - PI * 1e4 / (2.0 * 3.0_f64.sqrt() * 140.0 * 140.0)).abs() < 1e-12);
    // Squares this close would overlap with the next row.
    let refused = Pattern::new(hexagonal(Planform::Square), 100e-6, 10e-6, 20e-6).unwrap_err().to_string();
    assert!(refused.contains("95.26") && refused.contains("cavities 100 um long"), "{refused}");
    for refused in [
        hexagonal(Planform::Disc).with_spacing_across_m(1e-5),
        Texture::new(Planform::Disc).with_spacing_across_m(1e-5).unwrap().with_arrangement(Arrangement::Hexagonal),
    ] {
        assert!(refused.unwrap_err().to_string().contains("expected no spacing across"));
    }
    assert!(Texture::new(Planform::Groove).with_arrangement(Arrangement::Hexagonal).is_err());
}

#[test]
fn coverage_of_long_and_of_empty_rectangles() {
    for pattern in all_kinds(130.0, 370.0, 90.0, 60.0) {
        // A square metre takes no longer than a block, and approaches the areal density.
        let share = pattern.coverage(-0.3, 0.7, -0.4, 0.6);
        assert!((share / pattern.areal_density() - 1.0).abs() < 2e-3, "{pattern:?}: {share}");
        for empty in [[0.0, 0.0, 0.0, 1e-5], [1e-5, 0.0, 0.0, 1e-5], [0.0, f64::NAN, 0.0, 1.0]] {
            assert_eq!(pattern.coverage(empty[0], empty[1], empty[2], empty[3]), 0.0);
        }
        assert_eq!(pattern.coverage(f64::NEG_INFINITY, f64::INFINITY, 0.0, 1.0), 0.0);
    }
}

#[test]
fn staggered_lands_by_hand() {
    let staggered = |planform, width_um: f64, spacing_um: f64, spacing_across_um: f64| {
        let texture = Texture::new(planform).with_arrangement(Arrangement::Staggered).unwrap();
        let texture = texture.with_spacing_across_m(spacing_across_um * 1e-6).unwrap();
        Pattern::new(texture, width_um * 1e-6, spacing_um * 1e-6, 20e-6).unwrap().least_land_m() * 1e6
    };
    // Corner to corner: gaps of (20 + 80)/2 - 20 = 30 along and 40 across.
    assert!((staggered(Planform::Square, 20.0, 80.0, 40.0) - 50.0).abs() < 1e-9);
    // Wider than half a pitch: side to side.
    assert!((staggered(Planform::Square, 60.0, 40.0, 25.0) - 25.0).abs() < 1e-9);
    // Rows so close that the second next one is nearest: 20 + 2 x 1.
    assert!((staggered(Planform::Square, 20.0, 200.0, 1.0) - 22.0).abs() < 1e-9);
    // Centres 30 along and 40 across, diameter 20.
    assert!((staggered(Planform::Disc, 20.0, 40.0, 20.0) - 30.0).abs() < 1e-9);
}

/// Smallest distance between two cavities, with their outlines sampled at `steps` points.
fn sampled_land_m(pattern: &Pattern, steps: u32) -> f64 {
    let half_m = [pattern.width_m() / 2.0, pattern.length_m().unwrap() / 2.0];
    let outline: Vec<[f64; 2]> = (0..steps)
        .map(|step| {
            let angle = 2.0 * PI * f64::from(step) / f64::from(steps);
            let [cosine, sine] = [angle.cos(), angle.sin()];
            let scale = match pattern.planform() {
                Planform::Disc => 1.0,
                _ => 1.0 / cosine.abs().max(sine.abs()),
            };
            [half_m[0] * cosine * scale, half_m[1] * sine * scale]
        })
        .collect();
    let cell_m = pattern.cell_m();
    let mut least_m = f64::INFINITY;
    for (i, j, centre_m) in (-1..=1)
        .flat_map(|i| (-1..=1).map(move |j| (i, j)))
        .flat_map(|(i, j)| pattern.centres_m().map(move |centre_m| (f64::from(i), f64::from(j), centre_m)))
    {
        let shift_m = [centre_m[0] + i * cell_m[0], centre_m[1] + j * cell_m[1]];
        if shift_m == [0.0, 0.0] {
            continue;
        }
        for from_m in &outline {
            for to_m in &outline {
                least_m = least_m.min((to_m[0] + shift_m[0] - from_m[0]).hypot(to_m[1] + shift_m[1] - from_m[1]));
            }
        }
    }
    least_m
}

#[test]
fn the_narrowest_land_is_the_least_distance_of_outlines() {
    for (width, spacing, length, spacing_across) in
        [(20.0, 80.0, 30.0, 40.0), (60.0, 40.0, 10.0, 25.0), (20.0, 200.0, 20.0, 3.0), (40.0, 11.0, 70.0, 90.0)]
    {
        for pattern in kinds(width, spacing, length, spacing_across).into_iter().skip(1) {
            let sampled_m = sampled_land_m(&pattern, 256);
            let least_m = pattern.least_land_m();
            // Corners are sampled and opposite sides face each other in a sample; discs lose less than R (pi/256)^2.
            let extent_m = pattern.width_m().max(pattern.length_m().unwrap());
            assert!((-1e-12..2e-4 * extent_m).contains(&(sampled_m - least_m)), "{pattern:?}: {sampled_m} {least_m}");
        }
    }
}

/// A runner with the same cases on every run.
fn runner() -> TestRunner {
    let config = Config { cases: 64, failure_persistence: None, ..Config::default() };
    TestRunner::new_with_rng(config, TestRng::from_seed(RngAlgorithm::ChaCha, &[7; 32]))
}

#[test]
fn coverage_adds_up_to_the_areal_density_over_any_tiling() {
    let dimensions = (5.0..300.0, 1.0..300.0, 5.0..300.0, 1.0..300.0);
    let tiling = (-2.0..2.0, -2.0..2.0, 1_u32..40, 1_u32..40);
    runner()
        .run(&(dimensions, tiling), |((width, spacing, length, across), (offset_x, offset_y, columns, rows))| {
            for pattern in all_kinds(width, spacing, length, across) {
                let [cell_x_m, cell_y_m] = pattern.cell_m();
                let x_m = |i: u32| (offset_x + f64::from(i) / f64::from(columns)) * cell_x_m;
                let y_m = |j: u32| (offset_y + f64::from(j) / f64::from(rows)) * cell_y_m;
                let mut sum = 0.0;
                for (i, j) in (0..columns).flat_map(|i| (0..rows).map(move |j| (i, j))) {
                    let share = pattern.coverage(x_m(i), x_m(i + 1), y_m(j), y_m(j + 1));
                    prop_assert!((0.0..=1.0).contains(&share));
                    sum += share;
                }
                let mean = sum / f64::from(columns * rows);
                prop_assert!((mean - pattern.areal_density()).abs() < 1e-12, "{:?}: {}", pattern, mean);
            }
            Ok(())
        })
        .unwrap();
}

#[test]
fn coverage_is_continuous_in_every_dimension() {
    const SIDE: f64 = 10.0;
    const STEP: f64 = 1e-6;
    let dimensions = [20.0..100.0, 5.0..100.0, 20.0..100.0, 5.0..100.0, -300.0..300.0, -300.0..300.0];
    runner()
        .run(&(dimensions, 0_usize..6), |(numbers, axis)| {
            let shares = |numbers: [f64; 6]| -> Vec<f64> {
                let [width, spacing, length, across, x, y] = numbers;
                let [x0_m, x1_m, y0_m, y1_m] = [x, x + SIDE, y, y + SIDE].map(|um| um * 1e-6);
                let patterns = all_kinds(width, spacing, length, across);
                patterns.iter().map(|p| p.coverage(x0_m, x1_m, y0_m, y1_m)).collect()
            };
            let mut moved = numbers;
            moved[axis] += STEP;
            // 300 um are at most 12 periods of 25: edges move by at most 13 steps, two of them over a block.
            for (before, after) in shares(numbers).into_iter().zip(shares(moved)) {
                prop_assert!((before - after).abs() <= 26.0 * STEP / SIDE, "{} {}", before, after);
            }
            Ok(())
        })
        .unwrap();
}

#[test]
fn coverage_is_the_share_of_points_inside() {
    const POINTS: u32 = 60;
    let dimensions = (20.0..100.0, 5.0..100.0, 20.0..100.0, 5.0..100.0);
    let rectangle = ([-200.0..200.0, -200.0..200.0], [5.0..150.0, 5.0..150.0]);
    runner()
        .run(&(dimensions, rectangle), |((width, spacing, length, across), (corner, side))| {
            let at_m = |axis: usize, points: f64| (corner[axis] + side[axis] * points / f64::from(POINTS)) * 1e-6;
            for pattern in all_kinds(width, spacing, length, across) {
                let inside = (0..POINTS)
                    .flat_map(|i| (0..POINTS).map(move |j| [i, j].map(|k| f64::from(k) + 0.5)))
                    .filter(|point| contains(&pattern, [at_m(0, point[0]), at_m(1, point[1])]))
                    .count();
                let counted = inside as f64 / f64::from(POINTS * POINTS);
                let whole = f64::from(POINTS);
                let share = pattern.coverage(at_m(0, 0.0), at_m(0, whole), at_m(1, 0.0), at_m(1, whole));
                // Each edge that crosses the rectangle misses at most half a line of points.
                let [cell_x_m, cell_y_m] = pattern.cell_m();
                let cavities = pattern.centres_m().count() as f64;
                let edges = 2.0 * cavities * (side[0] * 1e-6 / cell_x_m + side[1] * 1e-6 / cell_y_m + 2.0);
                prop_assert!((counted - share).abs() < 0.5 * edges / whole, "{:?}: {} {}", pattern, counted, share);
            }
            Ok(())
        })
        .unwrap();
}

#[test]
fn edges_are_what_a_grown_cavity_gains() {
    let um = 1e-6;
    let hexagon = Polygon::new(&regular(6, 0.0)).unwrap();
    let polygon = Texture::new(Planform::Polygon).with_outline(hexagon).unwrap();
    let of = |texture: Texture, by: f64| Pattern::new(texture, 130.0 * um + by, 370.0 * um - by, 20.0 * um).unwrap();
    for planform in [Planform::Groove, Planform::Square, Planform::Disc, Planform::Crosshatch] {
        // d(areal density) / dw at constant pitches, where each edge moves by dw / 2.
        let texture = Texture::new(planform);
        let step = 1e-3 * um;
        let gained = (of(texture, step).areal_density() - of(texture, -step).areal_density()) / step;
        let edges = of(texture, 0.0).edge_per_area_1_m();
        assert!((gained / edges - 1.0).abs() < 1e-6, "{planform:?}: {gained} {edges}");
    }
    let rectangle = Texture::new(Planform::Rectangle).with_length_m(250.0 * um).unwrap();
    for (texture, perimeter_um) in [(rectangle, 760.0), (polygon, 390.0)] {
        let pattern = of(texture, 0.0);
        let cell_m2 = pattern.pitch_m() * pattern.pitch_across_m().unwrap();
        let edges = pattern.edge_per_area_1_m();
        assert!((edges * cell_m2 / (perimeter_um * um) - 1.0).abs() < 1e-9, "{:?}", texture.planform());
    }
}
