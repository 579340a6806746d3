//! Polygons and crossing grooves compared with basic planforms, and their symmetries.

use crate::pattern::{Arrangement, Pattern, Planform, Polygon, Texture, regular};

use super::tests::{largest_imbalance, load, ratio_of_layer};
use super::*;
use crate::springblock::tests::samples::{self, E_PA, pattern, persson_law, says, scene};
use crate::springblock::{RunOptions, Scene, SteadyCell, Unwatched, simulate};

fn polygon(vertices: &[[f64; 2]]) -> Texture {
    Texture::new(Planform::Polygon).with_outline(Polygon::new(vertices).unwrap()).unwrap()
}

/// An arrow along x, which no symmetry maps onto itself.
const ARROW: [[f64; 2]; 4] = [[0.0, 0.0], [10.0, 4.0], [0.0, 8.0], [3.0, 4.0]];

fn mirrored(vertices: &[[f64; 2]]) -> Vec<[f64; 2]> {
    vertices.iter().map(|[x, y]| [-x, *y]).collect()
}

fn ratio(pattern: &Pattern) -> f64 {
    ratio_of_layer(pattern, 10.0, 100.0)
}

/// The peak over whole blocks depends on the width, but not on the positions of the blocks at edges and corners.
#[test]
fn the_peak_over_a_whole_block_does_not_depend_on_how_blocks_lie_on_edges() {
    let peak = |width_um: f64| {
        let pattern = pattern(Planform::Square, width_um, 250.0 - width_um, 20.0);
        let model = SpaceSteadyModel::new(SpaceLattice::cell(&pattern, 10e-6, 10), 10e-6, E_PA, false);
        let load = SpaceLoad { direction: pattern.sliding_direction(), ..load(2.6, None) };
        model.solve(&load).peak_pressure_pa / 1e6
    };
    let (narrow, wide) = (peak(130.0), peak(150.0));
    for step in 1..10 {
        let width_um = 130.0 + 2.0 * f64::from(step);
        let between = narrow + (wide - narrow) * f64::from(step) / 10.0;
        assert!((peak(width_um) / between - 1.0).abs() < 0.03, "{width_um}: {} {between}", peak(width_um));
    }
}

#[test]
fn polygons_of_many_corners_tend_to_the_disc() {
    let disc = ratio(&pattern(Planform::Disc, 130.0, 70.0, 20.0));
    let distances =
        [12, 36, 360].map(|corners| (ratio(&pattern(polygon(&regular(corners, 0.0)), 130.0, 70.0, 20.0)) - disc).abs());
    // The error of the area, (2 pi/n)^2/6, decreases by factors of 9 and 100.
    assert!(distances[1] < distances[0] / 5.0 && distances[2] < distances[1] / 20.0, "{distances:?}");
    let area = (2.0 * std::f64::consts::PI / 360.0).powi(2) / 6.0;
    assert!(distances[2] < 2.0 * area * (1.0 - disc) && 1.0 - disc > 0.05, "{distances:?} {disc}");
}

#[test]
fn a_mirrored_outline_slides_as_the_other_way() {
    // Whole blocks, so that the mirrored pattern has the mirrored mesh.
    let slid = |vertices: &[[f64; 2]], angle_deg: f64| {
        let texture = polygon(vertices).with_sliding_angle_deg(angle_deg).unwrap();
        ratio(&pattern(texture, 100.0, 60.0, 20.0))
    };
    let there = slid(&ARROW, 0.0);
    assert!((there - slid(&mirrored(&ARROW), 180.0)).abs() < 1e-12);
    let back = slid(&ARROW, 180.0);
    assert!((there - back).abs() > 1e-6, "an arrow feels which way it slides: {there} {back}");
    // By symmetry 30 and -30 degrees are equivalent.
    assert!((slid(&ARROW, 30.0) - slid(&ARROW, -30.0)).abs() < 1e-12);
}

#[test]
fn crossing_grooves_have_the_symmetry_of_their_axes() {
    let law = persson_law();
    let crossed = |crossing_deg: f64, groove_deg: f64, sliding_deg: f64| {
        let texture = Texture::new(Planform::Crosshatch).with_crossing_angle_deg(crossing_deg).unwrap();
        let texture = texture.with_groove_angle_deg(groove_deg).unwrap().with_sliding_angle_deg(sliding_deg).unwrap();
        pattern(texture, 60.0, 100.0, 20.0)
    };
    // Right angles: the two families, the two bisectors, and common rotations are equivalent.
    let along = ratio(&crossed(90.0, 0.0, 0.0));
    assert!((along - ratio(&crossed(90.0, 0.0, 90.0))).abs() < 1e-12);
    assert!((along - ratio(&crossed(90.0, 25.0, 25.0))).abs() < 1e-12);
    let aslant = ratio(&crossed(90.0, 0.0, 45.0));
    assert!((aslant - ratio(&crossed(90.0, 0.0, -45.0))).abs() < 1e-12);
    // The reduction is greater than that of either family.
    let groove = ratio(&pattern(Planform::Groove, 60.0, 100.0, 20.0));
    assert!(along < groove - 0.02 && aslant < groove, "{along} {aslant} {groove}");
    // The cell half-way between the families at 89.9 degrees gives the result of the cell along the families at 90.
    let lattice = |crossing_deg: f64| SpaceLattice::cell(&crossed(crossing_deg, 0.0, 0.0), 10e-6, 10).columns();
    assert_eq!((lattice(90.0), lattice(89.9)), ([16, 16], [23, 23]));
    let near = ratio(&crossed(89.9, 0.0, 0.0));
    assert!((near - along).abs() < 0.01 * (1.0 - along), "{near} {along}");
    // 60 degrees: mirror symmetry at the axes between the families.
    let one = crossed(60.0, -30.0, 20.0);
    assert!((ratio(&one) - ratio(&crossed(60.0, -30.0, -20.0))).abs() < 1e-12);
    let model = SpaceSteadyModel::new(SpaceLattice::cell(&one, 10e-6, 10), 10e-6, E_PA, false);
    let load = SpaceLoad { direction: one.sliding_direction(), ..load(2.6, Some(&law)) };
    assert!(largest_imbalance(&model, &load) < 1e-8);
}

#[test]
fn columns_of_a_cell_add_up_to_the_areal_density() {
    let crossed = Texture::new(Planform::Crosshatch).with_crossing_angle_deg(50.0).unwrap();
    let staggered = polygon(&ARROW).with_arrangement(Arrangement::Staggered).unwrap();
    let nested = polygon(&regular(6, 30.0)).with_arrangement(Arrangement::Hexagonal).unwrap();
    for (texture, width_um, spacing_um) in [(crossed, 60.0, 100.0), (staggered, 100.0, 47.0), (nested, 100.0, 20.0)] {
        let pattern = pattern(texture, width_um, spacing_um, 12.0);
        let lattice = SpaceLattice::cell(&pattern, 10e-6, 10);
        let [nx, ny] = lattice.columns();
        let covered: f64 =
            (0..nx * ny).map(|n| 1.0 - lattice.contact_share(n % nx, n / nx)).sum::<f64>() / (nx * ny) as f64;
        assert!((covered - pattern.areal_density()).abs() < 1e-5, "{pattern:?} {covered}");
        assert_eq!(SpaceLattice::columns_of(&pattern, 10e-6), [nx as f64, ny as f64]);
    }
}

#[test]
fn both_are_solved_in_space_steady_and_in_time() {
    let crossed = Texture::new(Planform::Crosshatch).with_crossing_angle_deg(70.0).unwrap();
    for texture in [polygon(&ARROW), crossed] {
        let pattern = pattern(texture, 80.0, 80.0, 20.0);
        let mut asked = scene(pattern, &[2.6], RunOptions::default());
        (asked.layer.block_m, asked.layer.height_m) = (20e-6, 100e-6);
        let steady = simulate(&asked, &Unwatched).unwrap();
        let ratio = steady.loads[0].ratio().unwrap();
        assert!(ratio < 0.99 && says(&steady, "three dimensions"), "{ratio}");
        assert!((SteadyCell::new(&asked).ratios(&pattern)[0].unwrap() - ratio).abs() < 1e-9);
        let in_time = simulate(&Scene { run: samples::in_time(2e-6), ..asked }, &Unwatched).unwrap();
        assert!(in_time.loads[0].ratio().is_some(), "{:?}", in_time.loads[0]);
    }
}
