use super::*;
use crate::pattern::{Arrangement, Pattern, Planform, Texture};

/// An L with arms 4 and 3 wide, 10 by 12.
const L: [[f64; 2]; 6] = [[0.0, 0.0], [10.0, 0.0], [10.0, 3.0], [4.0, 3.0], [4.0, 12.0], [0.0, 12.0]];

/// Corners of a regular polygon, the first at the angle `start_deg`.
pub fn regular(corners: u32, start_deg: f64) -> Vec<[f64; 2]> {
    let angle = |k: u32| (start_deg + 360.0 * f64::from(k) / f64::from(corners)).to_radians();
    (0..corners).map(|k| [libm::cos(angle(k)), libm::sin(angle(k))]).collect()
}

fn pattern(outline: &[[f64; 2]], arrangement: Arrangement, width_um: f64, spacing_um: f64) -> Pattern {
    let texture = Texture::new(Planform::Polygon).with_outline(Polygon::new(outline).unwrap()).unwrap();
    Pattern::new(texture.with_arrangement(arrangement).unwrap(), width_um * 1e-6, spacing_um * 1e-6, 5e-6).unwrap()
}

#[test]
fn an_outline_is_the_same_at_any_scale_place_and_sense() {
    let outline = Polygon::new(&L).unwrap();
    assert!((outline.length() - 1.2).abs() < 2_f64.powi(-42));
    assert_eq!(outline.vertices()[0], [-0.5, -outline.length() / 2.0]);
    assert!((outline.area() - (40.0 + 8.0 + 18.0) / 100.0).abs() < 1e-13, "{}", outline.area());
    for (scale, [x0, y0]) in [(13.37, [0.3, 400.0]), (1e-6 / 3.0, [0.0, -1e-5]), (7.7e4, [1.0, 2.0])] {
        let moved = L.map(|[x, y]| [x0 + scale * x, y0 + scale * y]);
        assert_eq!(Polygon::new(&moved).unwrap(), outline);
    }
    let scaled: Vec<[f64; 2]> = outline.vertices().iter().map(|at| at.map(|c| c * 131.07)).collect();
    assert!(std::ptr::eq(Polygon::new(&scaled).unwrap().0, outline.0));
    let mut reversed = L;
    reversed.reverse();
    let reversed = Polygon::new(&reversed).unwrap();
    assert!((reversed.area() - outline.area()).abs() < 1e-15);
    // The last corner may repeat the first.
    let closed = [L.as_slice(), &[L[0]]].concat();
    assert_eq!(Polygon::new(&closed).unwrap().vertices().len(), 6);
}

#[test]
fn what_is_no_outline_is_refused_with_the_corner() {
    let refused = |vertices: &[[f64; 2]]| Polygon::new(vertices).unwrap_err().to_string();
    assert_eq!(refused(&[]), "an outline of 0 corners encloses nothing: expected at least 3");
    assert_eq!(refused(&[[0.0; 2], [1.0, 0.0]]), "an outline of 2 corners encloses nothing: expected at least 3");
    assert_eq!(
        refused(&[[0.0; 2], [1.0, 1.0], [1.0, 1.0], [0.0; 2]]),
        "an outline of 2 corners encloses nothing: expected at least 3"
    );
    assert!(refused(&[[0.0; 2], [1.0, 0.0], [3.0, 0.0]]).contains("encloses no area"));
    assert!(refused(&[[0.0; 2], [1.0, 1.0], [3.0, 3.0], [2.0, 2.0]]).contains("encloses no area"));
    assert!(refused(&[[0.0; 2], [1.0, f64::NAN], [3.0, 1.0]]).starts_with("corner 2 of the outline is (1, NaN)"));
    let bow = refused(&[[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 1.0]]);
    assert!(bow.contains("from corner 1 (0, 0) and from corner 3 (2, 0) meet"), "{bow}");
    // Touching counts as meeting: a corner on another edge, and an edge back along the previous one.
    let touching = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 0.0], [0.0, 4.0]];
    assert!(refused(&touching).contains("meet: expected a closed outline"));
    let back = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [4.0, 2.0], [0.0, 4.0]];
    assert!(refused(&back).contains("meet: expected a closed outline"));
    let many = regular(2001, 0.0);
    assert_eq!(refused(&many), "an outline of 2001 corners: expected at most 2000");
}

#[test]
fn the_narrowest_width_is_that_of_the_hull_or_of_a_neck() {
    let least = |vertices: &[[f64; 2]]| {
        let [left, right] = extremes(vertices.iter().map(|at| at[0]));
        Polygon::new(vertices).unwrap().least_extent() * (right - left)
    };
    let close = |value: f64, expected: f64| assert!((value - expected).abs() < 1e-11, "{value} for {expected}");
    close(least(&[[0.0, 0.0], [7.0, 0.0], [7.0, 3.0], [0.0, 3.0]]), 3.0);
    close(least(&L), 3.0);
    // An equilateral triangle: its height.
    close(least(&regular(3, 20.0)), 1.5);
    close(least(&regular(6, 0.0)), 3_f64.sqrt());
    // An inclined dumbbell of two squares and a bar 0.5 wide.
    let turn = |[x, y]: [f64; 2]| [0.8 * x - 0.6 * y, 0.6 * x + 0.8 * y];
    let dumbbell = [
        [0.0, 0.0],
        [3.0, 0.0],
        [3.0, 1.0],
        [6.0, 1.0],
        [6.0, 0.0],
        [9.0, 0.0],
        [9.0, 3.0],
        [6.0, 3.0],
        [6.0, 1.5],
        [3.0, 1.5],
        [3.0, 3.0],
        [0.0, 3.0],
    ];
    close(least(&dumbbell.map(turn)), 0.5);
    // A smooth waist: circles of radius 1 cut into a plate at x = 0 from y = 1.25 and -1.25 leave 0.5; chords leave a
    // little more.
    let arc = |centre: f64, from: f64| {
        (0..=40).map(move |k| {
            let angle = from - std::f64::consts::PI * f64::from(k) / 40.0;
            [libm::cos(angle), centre + libm::sin(angle)]
        })
    };
    let lower: Vec<[f64; 2]> = arc(-1.25, std::f64::consts::PI).collect();
    let upper: Vec<[f64; 2]> = arc(1.25, 0.0).collect();
    let outline = [&[[-3.0, -1.25]], &lower[..], &[[3.0, -1.25], [3.0, 1.25]], &upper[..], &[[-3.0, 1.25]]].concat();
    close(least(&outline), 0.5);
}

#[test]
fn only_what_symmetry_gives_slides_alike() {
    let at = |outline: &[[f64; 2]], angle_deg: f64| {
        let texture = Texture::new(Planform::Polygon).with_outline(Polygon::new(outline).unwrap()).unwrap();
        texture.with_sliding_angle_deg(angle_deg).unwrap()
    };
    let alike =
        |texture: Texture, others: &[f64]| others.iter().map(|deg| texture.slides_alike(*deg)).collect::<Vec<_>>();
    // An L has no symmetry, so that both directions differ.
    assert_eq!(alike(at(&L, 30.0), &[30.0, -150.0, -30.0, 150.0, 60.0]), [true, false, false, false, false]);
    // A triangle that points along x is symmetric across the x axis.
    assert_eq!(alike(at(&regular(3, 0.0), 30.0), &[-30.0, -150.0, 150.0]), [true, false, false]);
    assert_eq!(alike(at(&regular(3, 0.0), 0.0), &[180.0, -180.0, 90.0]), [false, false, false]);
    // A hexagon is symmetric under rotation by 180 degrees and reflection across both axes, but not across the
    // diagonal.
    assert_eq!(alike(at(&regular(6, 0.0), 30.0), &[-30.0, -150.0, 150.0, 60.0]), [true, true, true, false]);
    // An octagon is symmetric across the diagonals on a square lattice only.
    let octagon = at(&regular(8, 22.5), 30.0);
    assert_eq!(alike(octagon, &[60.0, 120.0, -60.0, 45.0]), [true, true, true, false]);
    let staggered = octagon.with_arrangement(Arrangement::Staggered).unwrap();
    assert_eq!(alike(staggered, &[60.0, 120.0, -60.0, 150.0]), [false, false, false, true]);
    // A parallelogram is symmetric under rotation by 180 degrees only.
    let leaning = [[0.0, 0.0], [4.0, 0.0], [5.0, 3.0], [1.0, 3.0]];
    assert_eq!(alike(at(&leaning, 30.0), &[-150.0, -30.0, 150.0]), [true, false, false]);
    assert!((0..360).all(|deg| at(&L, 0.0).slides_alike(f64::from(deg) - 180.0) == (deg == 180)));
}

#[test]
fn the_narrowest_land_is_exact() {
    let close =
        |land_m: f64, expected_um: f64| assert!((land_m * 1e6 - expected_um).abs() < 1e-9, "{land_m} {expected_um}");
    let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    for arrangement in Arrangement::ALL {
        let plain = Texture::new(Planform::Square).with_arrangement(arrangement).unwrap();
        let plain = Pattern::new(plain, 100e-6, 60e-6, 5e-6).unwrap();
        close(pattern(&square, arrangement, 100.0, 60.0).least_land_m(), plain.least_land_m() * 1e6);
    }
    // Diamonds 100 um wide at a pitch of 120: distance between facing sides of diagonal neighbours, the lines x + y =
    // 50 and x + y = 240 - 50.
    let diamond = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]];
    close(pattern(&diamond, Arrangement::Square, 100.0, 20.0).least_land_m(), 20.0);
    // Staggered at pitches of 120 by 120: x + y = 50 and x + y = 180 - 50.
    close(pattern(&diamond, Arrangement::Staggered, 100.0, 60.0).least_land_m(), 60.0_f64.min(140.0 / 2_f64.sqrt()));
    // Hexagons with a corner at the top, 100 across flats, nested in hexagonal rows: 20 um of land on all sides.
    let hexagons = pattern(&regular(6, 30.0), Arrangement::Hexagonal, 100.0, 20.0);
    close(hexagons.least_land_m(), 20.0);
    assert!((hexagons.areal_density() - (100.0_f64 / 120.0).powi(2)).abs() < 1e-12);
    assert!(hexagons.spacing_across_m().unwrap() < 0.0);
    // Rows may interlock, and overlap if they do not fit.
    let texture = *pattern(&square, Arrangement::Hexagonal, 100.0, 60.0).texture();
    let refused = Pattern::new(texture, 100e-6, 5e-6, 5e-6).unwrap_err().to_string();
    assert!(refused.contains("they run into each other"), "{refused}");
}
