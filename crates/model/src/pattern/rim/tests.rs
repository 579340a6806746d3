use super::*;
use crate::pattern::{Arrangement, Pattern, Planform, Polygon, Texture, regular};

fn rimmed(texture: impl Into<Texture>, profile: RimProfile) -> Pattern {
    let rim = Rim::new(0.5e-6, 20e-6, profile).unwrap();
    Pattern::new(texture.into().with_rim(rim), 130e-6, 70e-6, 20e-6).unwrap()
}

#[test]
fn integrals_are_those_of_heights() {
    for profile in RimProfile::ALL {
        for s in [0.2, 0.5, 1.0, 1.7] {
            let parts = 20_000;
            let sum: f64 = (0..parts).map(|n| profile.height(s * (f64::from(n) + 0.5) / f64::from(parts))).sum();
            assert!((sum * s / f64::from(parts) - profile.integral(s)).abs() < 1e-4, "{profile} {s}");
        }
        let crest = (0..=1000).map(|n| profile.height(f64::from(n) / 1000.0)).fold(0.0, f64::max);
        assert!((crest - 1.0).abs() < 1e-12 && profile.height(1.001) == 0.0 && profile.height(-0.001) == 0.0);
    }
    // A flat rim of 4 um covers half of the pixel from 3 to 5 um, and a quarter of the one from -1.5 to 0.5 um.
    assert!((RimProfile::Flat.mean(4e-6, 3e-6, 5e-6) - 0.5).abs() < 1e-12);
    assert!((RimProfile::Flat.mean(4e-6, -1.5e-6, 0.5e-6) - 0.25).abs() < 1e-12);
}

#[test]
fn heights_follow_the_depth_between_what_was_measured_and_stay_beyond() {
    let rim = Rim::following_depth(&[[5e-6, 0.1e-6], [15e-6, 0.5e-6]], 1e-5, RimProfile::Flat).unwrap();
    for (depth_m, height_m) in [(1e-6, 0.1e-6), (5e-6, 0.1e-6), (10e-6, 0.3e-6), (15e-6, 0.5e-6), (1e-3, 0.5e-6)] {
        assert!((rim.height_m(depth_m) - height_m).abs() < 1e-18, "{depth_m}");
    }
    assert!((rim.raised(-0.2e-6).height_m(20e-6) - 0.3e-6).abs() < 1e-18);
    assert_eq!(rim.raised(-0.2e-6).height_m(0.0), 0.0);
    for bad in [&[][..], &[[5e-6, 0.0], [5e-6, 1e-7]], &[[-1e-6, 1e-7]], &[[f64::NAN, 1e-7]], &[[0.0, 0.0]; 9]] {
        assert!(matches!(Rim::following_depth(bad, 1e-5, RimProfile::Flat), Err(PatternError::Refused(_))));
    }
    for bad in [-1e-7, f64::NAN, 2e-3] {
        assert!(matches!(Rim::new(bad, 1e-5, RimProfile::Round), Err(PatternError::Refused(_))));
    }
}

#[test]
fn blocks_are_at_most_half_a_rim_and_a_whole_number_of_times_smaller() {
    for (rim_um, block_um) in [(10.0, 5.0), (20.0, 10.0), (50.0, 10.0), (12.0, 5.0), (6.0, 2.5), (3.0, 10.0 / 7.0)] {
        let found_m = Rim::new(1e-7, rim_um * 1e-6, RimProfile::Round).unwrap().block_m(10e-6);
        assert!((found_m * 1e6 - block_um).abs() < 1e-9, "{rim_um}: {found_m}");
    }
}

#[test]
fn blocks_that_fill_a_cell_hold_the_volume_of_the_rims() {
    // Areas within d of the cavity: 2 d per length, a square ring with round corners, an annulus.
    let ring = |d: f64| 4.0 * d * 130e-6 + std::f64::consts::PI * d * d;
    let annulus = |d: f64| std::f64::consts::PI * d * (130e-6 + d);
    let w = 20e-6;
    for profile in RimProfile::IN_FILES {
        // Integral of phi dA over many thin rings.
        let volume = |area: &dyn Fn(f64) -> f64| -> f64 {
            let thin = |n: i32| (f64::from(n) / 20_000.0, (f64::from(n) + 0.5) / 20_000.0, f64::from(n + 1) / 20_000.0);
            (0..20_000).map(thin).map(|(a, m, b)| profile.height(m) * (area(b * w) - area(a * w))).sum()
        };
        let groove = |d: f64| 2.0 * d * 200e-6;
        for (planform, expected) in
            [(Planform::Groove, volume(&groove)), (Planform::Square, volume(&ring)), (Planform::Disc, volume(&annulus))]
        {
            let pattern = rimmed(planform, profile);
            for blocks in [20, 27] {
                let side = 200e-6 / f64::from(blocks);
                let edges = |n: i32| (f64::from(n) * side - 31e-6, f64::from(n + 1) * side - 31e-6);
                let cells = (0..blocks * blocks).map(|n| (edges(n % blocks), edges(n / blocks)));
                let found: f64 = cells
                    .map(|((x0, x1), (y0, y1))| {
                        let land = 1.0 - pattern.coverage(x0, x1, y0, y1);
                        pattern.rim_share(x0, x1, y0, y1) * land * side * side
                    })
                    .sum();
                assert!((found / expected - 1.0).abs() < 1e-5, "{planform} {profile} {blocks}: {found} {expected}");
            }
        }
    }
}

/// Fraction by counting points: a rim extends by its width from the nearest point of a cavity of any shape.
#[test]
fn rims_are_as_wide_around_corners_as_along_edges() {
    let square = Polygon::new(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]).unwrap();
    let outlined = |outline| Texture::new(Planform::Polygon).with_outline(outline).unwrap();
    let staggered = |texture: Texture| texture.with_arrangement(Arrangement::Staggered).unwrap();
    let textures = [
        (Texture::new(Planform::Square), 130.0),
        (staggered(Texture::new(Planform::Square)), 130.0),
        (Texture::new(Planform::Rectangle).with_length_m(70e-6).unwrap(), 70.0),
        (outlined(square), 130.0),
        (staggered(outlined(square)), 130.0),
    ];
    for (texture, length_um) in textures {
        for profile in RimProfile::IN_FILES {
            let rim = Rim::new(0.5e-6, 20e-6, profile).unwrap();
            let pattern = Pattern::new(texture.with_rim(rim), 130e-6, 70e-6, 20e-6).unwrap();
            let cell_um = pattern.cell_m().map(|m| m * 1e6);
            // Distance to the nearest rectangle, folded to the period.
            let height = |x: f64, y: f64| {
                let away = |[cx, cy]: [f64; 2]| {
                    let from = |at: f64, centre_m: f64, axis: usize, half: f64| {
                        let at = (at - centre_m * 1e6).rem_euclid(cell_um[axis]);
                        (at.min(cell_um[axis] - at) - half).max(0.0)
                    };
                    from(x, cx, 0, 65.0).hypot(from(y, cy, 1, 0.5 * length_um))
                };
                let nearest_um = pattern.centres_m().map(away).fold(f64::INFINITY, f64::min);
                (nearest_um > 0.0).then(|| profile.height(nearest_um / 20.0))
            };
            for (x, y) in [(64.0, 62.0), (71.0, 34.0), (60.0, 33.0), (78.0, 78.0), (66.0, 3.0), (-85.0, 47.0)] {
                let point = |n: i32| (f64::from(n) + 0.5) / 200.0 * 11.0;
                let (mut sum, mut land) = (0.0, 0.0);
                for height in (0..40_000).filter_map(|n| height(x + point(n % 200), y + point(n / 200))) {
                    sum += height;
                    land += 1.0;
                }
                let counted = if land > 0.0 { sum / land } else { 0.0 };
                let [x_m, y_m] = [x, y].map(|from: f64| [from * 1e-6, (from + 11.0) * 1e-6]);
                let share = pattern.rim_share(x_m[0], x_m[1], y_m[0], y_m[1]);
                assert!((share - counted).abs() < 4e-3, "{texture:?} {profile} {x} {y}: {share} {counted}");
            }
        }
    }
}

#[test]
fn the_rims_of_outlines_and_of_crossing_grooves_are_those_of_the_plain_shapes() {
    let outlined = |corners: &[[f64; 2]], profile| {
        let texture = Texture::new(Planform::Polygon).with_outline(Polygon::new(corners).unwrap()).unwrap();
        rimmed(texture, profile)
    };
    let square = [[0.0, 0.0], [40.0, 0.0], [40.0, 40.0], [0.0, 40.0]];
    for profile in RimProfile::IN_FILES {
        // Chords of the outline's arcs deviate by 1e-4 of the width. A disc is compared with 360 corners.
        for (plain, polygon, tolerance) in [
            (rimmed(Planform::Square, profile), outlined(&square, profile), 4e-4),
            (rimmed(Planform::Disc, profile), outlined(&regular(360, 0.0), profile), 2e-3),
        ] {
            for (x, y) in [(63.0, 3.0), (71.5, -12.0), (48.0, 48.0), (10.0, 72.0), (63.0, 63.0)] {
                let [x, y] = [x, y].map(|from: f64| [from * 1e-6, (from + 8.0) * 1e-6]);
                let [one, other] = [plain, polygon].map(|pattern| pattern.rim_share(x[0], x[1], y[0], y[1]));
                assert!((one - other).abs() < tolerance, "{plain:?} {x:?}: {one} {other}");
            }
        }
    }
    let [crossing, groove] = [Planform::Crosshatch, Planform::Groove].map(|of| rimmed(of, RimProfile::Ramp));
    // Far from the other family, the land next to a groove equals that of parallel grooves: its middle is half a pitch
    // away.
    let share = |pattern: &Pattern| pattern.rim_share(66e-6, 73e-6, 97e-6, 103e-6);
    assert!((share(&crossing) - share(&groove)).abs() < 1e-12);
}

#[test]
fn rims_that_meet_end_half_way() {
    let rim = Rim::new(0.5e-6, 20e-6, RimProfile::Ramp).unwrap();
    let pattern = Pattern::new(Texture::new(Planform::Groove).with_rim(rim), 100e-6, 20e-6, 20e-6).unwrap();
    // The mean of 1 - s from the edge to half a width is 3/4.
    assert!((pattern.rim_share(50e-6, 70e-6, 0.0, 1e-6) - 0.75).abs() < 1e-12);
    assert_eq!(pattern.rim_share(-10e-6, 10e-6, 0.0, 1e-6), 0.0);
}

#[test]
fn shares_are_continuous_in_the_rim_and_in_the_cavity() {
    for (planform, profile) in [(Planform::Groove, RimProfile::Flat), (Planform::Square, RimProfile::Round)] {
        let share = |width_um: f64, rim_um: f64| {
            let rim = Rim::new(1e-6, rim_um * 1e-6, profile).unwrap();
            let texture = Texture::new(planform).with_rim(rim);
            let pattern = Pattern::new(texture, width_um * 1e-6, 1e-4, 2e-5).unwrap();
            pattern.rim_share(60e-6, 70e-6, 0.0, 10e-6)
        };
        let steps = |values: Vec<f64>| values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
        let along_rim = steps((1..400).map(|n| share(110.0, 0.1 * f64::from(n))).collect());
        let along_width = steps((0..380).map(|n| share(100.0 + 0.1 * f64::from(n), 12.0)).collect());
        assert!(along_rim < 0.02 && along_width < 0.03, "{planform}: {along_rim} {along_width}");
    }
}
