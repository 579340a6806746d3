//! Layouts compared with brute force.

use super::*;
use crate::export::Boundary;
use slipgrid_model::pattern::Texture;

fn squares(width_um: f64, spacing_um: f64) -> Pattern {
    Pattern::new(Planform::Square, width_um * 1e-6, spacing_um * 1e-6, 5.2e-6).unwrap()
}

const DISC: Outline = Outline::Disc { diameter_m: 10e-3 };

#[test]
fn a_rectangle_takes_cavities_that_touch_its_edge() {
    // 2 (0.9) + 0.1 = 1.9 mm: the outermost cavities end on the outline.
    let outline = Outline::Rectangle { length_m: 1.9e-3, width_m: 0.7e-3 };
    let layout = Layout::new(squares(100.0, 200.0), outline).unwrap();
    assert_eq!(layout.cavities(), 7 * 3);
    let grooves = Layout::new(squares(100.0, 200.0).as_groove(), outline).unwrap();
    assert_eq!(grooves.cavities(), 7);
    assert!(grooves.iter().all(|groove| (groove.length_m - 0.7e-3).abs() < 1e-15));
    assert!((grooves.areal_density() - 7.0 * 0.1 / 1.9).abs() < 1e-12);
}

#[test]
fn specimens_that_hold_no_cavity_or_too_many_are_refused() {
    let pattern = squares(130.0, 370.0);
    for outline in [
        Outline::Disc { diameter_m: 0.18e-3 },
        Outline::Rectangle { length_m: 1e-3, width_m: 0.12e-3 },
        Outline::Rectangle { length_m: 0.12e-3, width_m: 1e-3 },
    ] {
        for pattern in [pattern, pattern.as_groove()] {
            let refused = Layout::new(pattern, outline);
            assert!(matches!(refused, Err(ExportError::NoCavityFits { .. })), "{outline:?}: {refused:?}");
        }
    }
    let one = Layout::new(pattern, Outline::Disc { diameter_m: 0.184e-3 }).unwrap();
    assert_eq!(one.cavities(), 1);
    let refused = Layout::new(pattern, Outline::Disc { diameter_m: 10.0 }).unwrap_err();
    assert!(matches!(refused, ExportError::TooManyCavities { .. }));
    let refused = Layout::new(pattern, Outline::Disc { diameter_m: f64::NAN }).unwrap_err();
    assert!(refused.to_string().contains("diameter_m"));
}

/// Textures of every kind with their dimensions, in micrometres.
fn patterns(width_um: f64, spacing_um: f64) -> Vec<Pattern> {
    let pattern = |texture| Pattern::new(texture, width_um * 1e-6, spacing_um * 1e-6, 5.2e-6).unwrap();
    every_kind().into_iter().map(pattern).collect()
}

const OUTLINES: [Outline; 2] = [DISC, Outline::Rectangle { length_m: 6e-3, width_m: 3.1e-3 }];

/// Distance by which a cavity crosses the outline, in metres; negative inside.
fn excess_m(cavity: &Cavity, outline: &Outline) -> f64 {
    let reach_m = |boundary: Boundary| match boundary {
        Boundary::Circle { centre_m: [x, y], radius_m } => vec![[x, y, radius_m]],
        Boundary::Polygon { corners_m } => corners_m.iter().map(|[x, y]| [*x, *y, 0.0]).collect(),
    };
    let excess = |[x, y, radius_m]: [f64; 3]| match *outline {
        Outline::Disc { diameter_m } => x.hypot(y) + radius_m - diameter_m / 2.0,
        Outline::Ring { .. } => f64::NAN,
        Outline::Rectangle { length_m, width_m } => (x.abs() - length_m / 2.0).max(y.abs() - width_m / 2.0) + radius_m,
    };
    cavity.boundaries().into_iter().flat_map(reach_m).map(excess).fold(f64::NEG_INFINITY, f64::max)
}

#[test]
fn every_cavity_that_fits_whole_is_laid_and_no_other() {
    for (pattern, outline) in patterns(131.2, 97.0).into_iter().flat_map(|p| OUTLINES.map(|o| (p, o))) {
        let layout = Layout::new(pattern, outline).unwrap();
        assert_eq!(layout.iter().count(), layout.cavities());
        assert!(layout.iter().all(|cavity| excess_m(&cavity, &outline) < 1e-12), "{pattern:?}");
        let area_m2: f64 = layout.iter().map(|cavity| cavity.area_m2()).sum();
        assert!((layout.cavity_area_m2() / area_m2 - 1.0).abs() < 1e-12);
        let Some(length_m) = pattern.length_m() else { continue };
        // Brute force: all cavities of all cells around the specimen.
        let [cell_x_m, cell_y_m] = pattern.cell_m();
        let mut fitting = 0;
        for (i, j) in (-60..=60).flat_map(|i| (-60..=60).map(move |j| (f64::from(i), f64::from(j)))) {
            for [x_m, y_m] in pattern.centres_m() {
                let cavity = Cavity::new(&pattern, [x_m + i * cell_x_m, y_m + j * cell_y_m], length_m);
                fitting += usize::from(excess_m(&cavity, &outline) < 1e-12);
            }
        }
        assert_eq!(layout.cavities(), fitting, "{pattern:?} on {outline:?}");
    }
}

#[test]
fn turned_grooves_are_as_long_as_the_outline_lets_them() {
    let groove = Texture::new(Planform::Groove);
    for angle_deg in [-90.0, -33.3, 0.0, 10.0, 45.0, 90.0] {
        let turned = groove.with_groove_angle_deg(angle_deg).unwrap();
        let pattern = Pattern::new(turned, 130e-6, 370e-6, 5.2e-6).unwrap();
        // A disc holds equal grooves at any angle.
        let layout = Layout::new(pattern, DISC).unwrap();
        let across = Layout::new(pattern.as_groove(), DISC).unwrap();
        assert_eq!((layout.cavities(), layout.iter().count(), across.cavities()), (19, 19, 19));
        assert!((layout.cavity_area_m2() / across.cavity_area_m2() - 1.0).abs() < 1e-12);
        for outline in OUTLINES {
            let layout = Layout::new(pattern, outline).unwrap();
            assert!(layout.cavities() >= 5);
            for groove in layout.iter() {
                assert!(excess_m(&groove, &outline).abs() < 1e-12, "{angle_deg}: {groove:?}");
                assert!(groove.length_m >= groove.width_m);
                // Both ends lie on the outline: a groove extended at one end crosses it.
                for end in [-1.0, 1.0] {
                    let [cosine, sine] = groove.orientation;
                    let longer = Cavity {
                        length_m: groove.length_m + 1e-9,
                        centre_x_m: groove.centre_x_m - end * 0.5e-9 * sine,
                        centre_y_m: groove.centre_y_m + end * 0.5e-9 * cosine,
                        ..groove
                    };
                    assert!(excess_m(&longer, &outline) > 1e-11, "{angle_deg}: {groove:?}");
                }
            }
        }
    }
    // Longitudinal grooves on a rectangle run along its length.
    let along = groove.with_groove_angle_deg(90.0).unwrap();
    let along = Pattern::new(along, 100e-6, 200e-6, 5.2e-6).unwrap();
    let layout = Layout::new(along, Outline::Rectangle { length_m: 5e-3, width_m: 0.7e-3 }).unwrap();
    assert_eq!(layout.cavities(), 3);
    assert!(layout.iter().all(|groove| (groove.length_m - 5e-3).abs() < 1e-15));
}

#[test]
fn one_disc_fits_on_a_disc_of_its_size_and_none_on_a_smaller_one() {
    let pattern = Pattern::new(Planform::Disc, 130e-6, 370e-6, 5.2e-6).unwrap();
    assert_eq!(Layout::new(pattern, Outline::Disc { diameter_m: 130e-6 }).unwrap().cavities(), 1);
    let refused = Layout::new(pattern, Outline::Disc { diameter_m: 129e-6 });
    assert!(matches!(refused, Err(ExportError::NoCavityFits { needed_m: 130e-6, .. })), "{refused:?}");
    let long = Texture::new(Planform::Rectangle).with_length_m(400e-6).unwrap();
    let long = Pattern::new(long, 130e-6, 370e-6, 5.2e-6).unwrap();
    let refused = Layout::new(long, Outline::Rectangle { length_m: 0.3e-3, width_m: 0.39e-3 });
    assert!(matches!(refused, Err(ExportError::NoCavityFits { needed_m: 400e-6, extent_m: 0.39e-3, .. })));
}

/// Smallest and largest distance of a cavity's points from the specimen's centre, in metres.
fn span_m(cavity: &Cavity) -> [f64; 2] {
    let [cosine, sine] = cavity.orientation;
    let (x_m, y_m) = (cavity.centre_x_m, cavity.centre_y_m);
    if let Some(reach_m) = cavity.polygon_reach_m() {
        return reach_m;
    }
    if cavity.planform == Planform::Disc {
        let (distance_m, radius_m) = (x_m.hypot(y_m), cavity.width_m / 2.0);
        return [(distance_m - radius_m).max(0.0), distance_m + radius_m];
    }
    // In the cavity's axes: the point of the rectangle closest to the centre, and the farthest corner.
    let own = [(x_m * cosine + y_m * sine, cavity.width_m), (y_m * cosine - x_m * sine, cavity.length_m)];
    let [near, far] = [-1.0, 1.0].map(|side| own.map(|(at_m, extent_m)| (at_m.abs() + side * extent_m / 2.0).max(0.0)));
    [near[0].hypot(near[1]), far[0].hypot(far[1])]
}

#[test]
fn rings_take_what_is_clear_of_hole_and_rim() {
    let outline = Outline::Ring { outer_diameter_m: 6e-3, inner_diameter_m: 2.1e-3 };
    let clear = |cavity: &Cavity| {
        let [interval_near_m, far_m] = span_m(cavity);
        interval_near_m > 1.05e-3 - 1e-12 && far_m < 3e-3 + 1e-12
    };
    for pattern in patterns(131.2, 97.0) {
        let (layout, disc) = (Layout::new(pattern, outline).unwrap(), Layout::new(pattern, DISC).unwrap());
        assert!(layout.iter().all(|cavity| clear(&cavity)), "{pattern:?}");
        if pattern.length_m().is_some() {
            // The clear cases among the cavities on a larger disc, which are compared with brute force.
            assert_eq!(layout.cavities(), disc.iter().filter(clear).count(), "{pattern:?}");
            let touching = |cavity: &Cavity| span_m(cavity)[0] < 3e-3 && span_m(cavity)[1] > 1.05e-3;
            let clipped = Layout::clipped(pattern, outline).unwrap();
            assert_eq!(clipped.cavities(), disc.iter().filter(touching).count(), "{pattern:?}");
            continue;
        }
        // Two on each strip that meets the hole, each of maximum length.
        assert!(layout.cavities() > Layout::new(pattern, Outline::Disc { diameter_m: 6e-3 }).unwrap().cavities());
        for groove in layout.iter() {
            let longer = Cavity { length_m: groove.length_m + 1e-9, ..groove };
            assert!(!clear(&longer), "{groove:?}");
        }
    }
}

#[test]
fn area_outline_chords_and_walls_of_every_cavity_agree() {
    const LINES: u32 = 200;
    let plate = Outline::Rectangle { length_m: 0.8e-3, width_m: 0.8e-3 };
    for pattern in patterns(131.2, 97.0) {
        let cavity = Layout::new(pattern, plate).unwrap().iter().next().unwrap();
        let along @ [cosine, sine] = cavity.orientation;
        let expected_m2: f64 = cavity.boundaries().iter().map(Boundary::area_m2).sum();
        assert!((cavity.area_m2() / expected_m2 - 1.0).abs() < 1e-3, "{cavity:?}");
        // Lines along the width and points on each, in equal steps over the rectangle around the cavity.
        let step = |k: u32, extent_m: f64| ((f64::from(k) + 0.5) / f64::from(LINES) - 0.5) * extent_m;
        let (mut chords_m2, mut inside) = (0.0, 0);
        for k in 0..LINES {
            let across_m = step(k, cavity.length_m);
            let at_m = cavity.centre_y_m * cosine - cavity.centre_x_m * sine + across_m;
            let chord_m = cavity.spans_m(along, at_m).iter().map(|[from_m, to_m]| to_m - from_m).sum::<f64>();
            chords_m2 += chord_m * cavity.length_m / f64::from(LINES);
            inside += (0..LINES)
                .map(|k| step(k, cavity.width_m))
                .map(|along_m| [along_m * cosine - across_m * sine, along_m * sine + across_m * cosine])
                .filter(|[x_m, y_m]| cavity.wall_distance_m([cavity.centre_x_m + x_m, cavity.centre_y_m + y_m]) > 0.0)
                .count();
        }
        let points_m2 = inside as f64 / f64::from(LINES * LINES) * cavity.width_m * cavity.length_m;
        assert!((points_m2 / expected_m2 - 1.0).abs() < 5e-3, "{points_m2} for {expected_m2}: {cavity:?}");
        // A concave corner divides a chord.
        let is_convex = cavity.face.is_none();
        assert!(
            !is_convex || (chords_m2 / expected_m2 - 1.0).abs() < 1e-3,
            "{chords_m2} for {expected_m2}: {cavity:?}"
        );
    }
}

/// A groove whose corners lie on the border is cut neither to the whole border nor to nothing.
#[test]
fn clipped_grooves_have_the_area_of_the_slices_they_are() {
    for (width_um, spacing_um) in [(400.0, 824.5), (130.0, 370.0), (40.0, 92.4), (250.0, 250.0), (400.0, 600.0)] {
        let pattern = Pattern::new(Planform::Groove, width_um * 1e-6, spacing_um * 1e-6, 5e-6).unwrap();
        for diameter_m in [10e-3, 6e-3, 2e-3, 9.7e-3] {
            let layout = Layout::clipped(pattern, Outline::Disc { diameter_m }).unwrap();
            let radius_m = diameter_m / 2.0;
            // Area of the disc up to x: x sqrt(R^2 - x^2) + R^2 asin(x / R).
            let up_to = |x_m: f64| {
                let x_m = x_m.clamp(-radius_m, radius_m);
                x_m * (radius_m * radius_m - x_m * x_m).max(0.0).sqrt() + radius_m * radius_m * (x_m / radius_m).asin()
            };
            for cavity in layout.iter() {
                let half_m = cavity.width_m / 2.0;
                let slice_m2 = up_to(cavity.centre_x_m + half_m) - up_to(cavity.centre_x_m - half_m);
                let error = (cavity.area_m2() - slice_m2).abs();
                // Chords deviate from arcs by at most 10 nm.
                assert!(error < 1e-8 * 2.0 * diameter_m, "{width_um} {diameter_m} {} {slice_m2}", cavity.area_m2());
            }
        }
    }
}
