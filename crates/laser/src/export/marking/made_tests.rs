//! The surface that the lines of `hatch.csv` make, measured as `slipgrid surface --cavities` does: width at half depth,
//! depth in the middle third of it. Depth is counted from single points of the lines.

use crate::export::stream::text;
use crate::export::{Laser, Layout, Marking, Outline, Removal, hatch_csv};
use slipgrid_base::statistics::extremes;
use slipgrid_model::pattern::{Pattern, Planform, Texture};

/// Distance between the points of a line, in um.
const STEP_UM: f64 = 0.25;

fn laser(spot_um: f64, hatch_um: f64) -> Laser {
    Laser {
        spot_um: Some(spot_um),
        hatch_um: Some(hatch_um),
        depth_per_burst_um: Some(0.2),
        repetition_hz: Some(20e3),
        speed_mm_s: Some(60.0),
        ..Laser::default()
    }
}

/// Points of all lines within `reach_um` of `about_um`, in um, read from the exported table.
fn points(layout: &Layout, laser: &Laser, about_um: [f64; 2], reach_um: f64) -> Vec<[f64; 2]> {
    let table = text(|to| hatch_csv(layout, &Marking::new(laser).unwrap(), to));
    let rows = table
        .lines()
        .skip(1)
        .map(|row| -> Vec<f64> { row.split(',').skip(2).map(|field| field.parse::<f64>().unwrap() * 1e3).collect() });
    let of_line = |row: Vec<f64>| {
        let count = ((row[2] - row[0]).hypot(row[3] - row[1]) / STEP_UM).round().max(1.0);
        (0..count as u32).map(move |k| {
            let share = (f64::from(k) + 0.5) / count;
            [row[0] + share * (row[2] - row[0]), row[1] + share * (row[3] - row[1])]
        })
    };
    let is_near = |[x, y]: &[f64; 2]| (x - about_um[0]).abs().max((y - about_um[1]).abs()) < reach_um;
    rows.flat_map(of_line).filter(is_near).collect()
}

/// Depth at a point as the length of lines within half a spot, in um.
fn reach_um(points: &[[f64; 2]], [x, y]: [f64; 2], spot_um: f64) -> f64 {
    points.iter().filter(|[u, v]| (u - x).powi(2) + (v - y).powi(2) < 0.25 * spot_um * spot_um).count() as f64 * STEP_UM
}

/// Width at half depth of a profile about its middle, and the mean depth in the middle third of this width.
fn half_depth(profile: impl Fn(f64) -> f64, design_um: f64) -> [f64; 2] {
    let steps = 1200;
    let at = |k: i32| (f64::from(k) / f64::from(steps) - 0.5) * 2.0 * design_um;
    let depths: Vec<[f64; 2]> = (0..=steps).map(|k| [at(k), profile(at(k))]).collect();
    let mut width_um = design_um;
    let mut middle_um = 0.0;
    for _ in 0..8 {
        let middle: Vec<f64> = depths.iter().filter(|[x, _]| x.abs() < width_um / 6.0).map(|[_, z]| *z).collect();
        middle_um = middle.iter().sum::<f64>() / middle.len() as f64;
        let [from, to] = extremes(depths.iter().filter(|[_, z]| *z > 0.5 * middle_um).map(|[x, _]| *x));
        width_um = to - from;
    }
    [width_um, middle_um]
}

fn laid(texture: impl Into<Texture>, width_um: f64, depth_um: f64) -> Layout {
    let pattern = Pattern::new(texture, width_um * 1e-6, 90e-6, depth_um * 1e-6).unwrap();
    Layout::new(pattern, Outline::Rectangle { length_m: 0.7e-3, width_m: 0.7e-3 }).unwrap()
}

fn centre_um(layout: &Layout) -> [f64; 2] {
    let near = |a: &[f64; 2]| a[0].hypot(a[1]);
    let centres = layout.iter().map(|cavity| [cavity.centre_x_m * 1e6, cavity.centre_y_m * 1e6]);
    centres.min_by(|a, b| near(a).total_cmp(&near(b))).unwrap()
}

const SPOTS: [[f64; 2]; 4] = [[10.0, 2.5], [10.0, 5.0], [23.0, 5.75], [23.0, 11.5]];

#[test]
fn grooves_are_as_wide_and_deep_at_half_depth_as_designed() {
    for [spot_um, hatch_um] in SPOTS {
        for width_um in [23.0, 40.0, 80.0, 130.0] {
            let (laser, layout) = (laser(spot_um, hatch_um), laid(Planform::Groove, width_um, 12.0));
            let centre = centre_um(&layout);
            let points = points(&layout, &laser, centre, width_um + spot_um);
            let profile = |x: f64| reach_um(&points, [centre[0] + x, centre[1]], spot_um);
            let [made_um, middle_um] = half_depth(profile, width_um);
            let removal = Removal::new(&layout, &laser).unwrap();
            let pulse_um = laser.pulse_distance_um().unwrap();
            let depth_um = f64::from(removal.passes) * 0.2 / pulse_um * middle_um;
            assert!((made_um / width_um - 1.0).abs() < 0.02, "{width_um} {spot_um} {hatch_um}: {made_um}");
            assert!((depth_um / removal.depth_um - 1.0).abs() < 0.01, "{depth_um} {removal:?}");
        }
    }
}

#[test]
fn squares_are_as_long_and_wide_at_half_depth_as_designed() {
    for [spot_um, hatch_um] in SPOTS {
        let (laser, layout) = (laser(spot_um, hatch_um), laid(Planform::Square, 120.0, 12.0));
        let centre = centre_um(&layout);
        let points = points(&layout, &laser, centre, 150.0);
        for along in [0, 1] {
            // The mean over chords through the middle half.
            let profile = |x: f64| {
                let at = |k: i32| {
                    let mut at = centre;
                    at[along] += x;
                    at[1 - along] += 60.0 * (f64::from(k) / 15.0 - 0.5);
                    reach_um(&points, at, spot_um)
                };
                (0..16).map(at).sum::<f64>() / 16.0
            };
            let [made_um, _] = half_depth(profile, 120.0);
            assert!((made_um / 120.0 - 1.0).abs() < 0.02, "{along} {spot_um} {hatch_um}: {made_um}");
        }
    }
}

#[test]
fn discs_have_the_designed_area_at_half_depth() {
    for [spot_um, hatch_um] in SPOTS {
        for width_um in [40.0, 120.0] {
            let (laser, layout) = (laser(spot_um, hatch_um), laid(Planform::Disc, width_um, 12.0));
            let centre = centre_um(&layout);
            let points = points(&layout, &laser, centre, width_um);
            let cells = 90;
            let at = |k: i32| (f64::from(k) + 0.5) / f64::from(cells) * 1.2 * width_um - 0.6 * width_um;
            let map: Vec<[f64; 3]> = (0..cells * cells)
                .map(|k| [at(k % cells), at(k / cells)])
                .map(|[x, y]| [x, y, reach_um(&points, [centre[0] + x, centre[1] + y], spot_um)])
                .collect();
            let middle: Vec<f64> =
                map.iter().filter(|[x, y, _]| x.hypot(*y) < width_um / 6.0).map(|[_, _, z]| *z).collect();
            let level_um = 0.5 * middle.iter().sum::<f64>() / middle.len() as f64;
            let cell_um2 = (1.2 * width_um / f64::from(cells)).powi(2);
            let area_um2 = map.iter().filter(|[_, _, z]| *z > level_um).count() as f64 * cell_um2;
            let made_um = (4.0 * area_um2 / std::f64::consts::PI).sqrt();
            assert!((made_um / width_um - 1.0).abs() < 0.02, "{width_um} {spot_um} {hatch_um}: {made_um}");
        }
    }
}

/// Along the middle of a groove of the second family, depth at the walls of the first is that of the rest.
#[test]
fn grooves_that_cross_keep_no_ridge_between_them() {
    for (crossing_deg, [spot_um, hatch_um]) in
        [(60.0, [25.0, 12.5]), (90.0, [25.0, 12.5]), (90.0, [25.0, 6.25]), (40.0, [23.0, 5.75])]
    {
        let texture = Texture::new(Planform::Crosshatch).with_crossing_angle_deg(crossing_deg).unwrap();
        let pattern = Pattern::new(texture.with_groove_angle_deg(-30.0).unwrap(), 60e-6, 240e-6, 6e-6).unwrap();
        let layout = Layout::new(pattern, Outline::Disc { diameter_m: 3e-3 }).unwrap();
        let laser = laser(spot_um, hatch_um);
        let points = points(&layout, &laser, [0.0; 2], 260.0);
        let along_deg: f64 = 60.0 + crossing_deg;
        let [dy, dx] = [along_deg.to_radians().sin(), along_deg.to_radians().cos()];
        let second = layout.iter().filter(|cavity| cavity.crossed_by.is_some());
        let offset = |x_um: f64, y_um: f64| y_um * dx - x_um * dy;
        let off_um = second
            .map(|cavity| offset(cavity.centre_x_m * 1e6, cavity.centre_y_m * 1e6))
            .min_by(|a, b| a.abs().total_cmp(&b.abs()))
            .unwrap();
        // Means over the middle third of the width.
        let depth = |along_um: f64| {
            let at = |k: i32| {
                let off_um = off_um + 20.0 * (f64::from(k) / 8.0 - 0.5);
                reach_um(&points, [along_um * dx - off_um * dy, along_um * dy + off_um * dx], spot_um)
            };
            (0..=8).map(at).sum::<f64>() / 9.0
        };
        let depths: Vec<f64> = (-200..=200).map(|along_um| depth(f64::from(along_um))).collect();
        let mean_um = depths.iter().sum::<f64>() / depths.len() as f64;
        let [least_um, most_um] = extremes(depths);
        assert!(least_um > 0.8 * mean_um && most_um < 1.2 * mean_um, "{crossing_deg}: {least_um} {most_um} {mean_um}");
    }
}
