//! Formulae compared with single pulses.

use super::*;
use crate::export::layout::every_kind;
use crate::export::{Outline, ProcessInput, ProcessSheet, process};
use slipgrid_model::pattern::{Pattern, Planform, Texture};

/// Removes 35.343 um in two passes over an infinite hatch: (pi/4) 30^2 / (4 8) x 0.8 um each.
fn narrow() -> Laser {
    laser(30.0, 8.0, 200.0, 0.8)
}

fn laser(spot_um: f64, hatch_um: f64, speed_mm_s: f64, burst_um: f64) -> Laser {
    Laser {
        spot_um: Some(spot_um),
        depth_per_burst_um: Some(burst_um),
        repetition_hz: Some(50e3),
        speed_mm_s: Some(speed_mm_s),
        hatch_um: Some(hatch_um),
        ..Laser::default()
    }
}

fn laid(texture: impl Into<Texture>, [width_um, spacing_um, depth_um]: [f64; 3]) -> Layout {
    let pattern = Pattern::new(texture, width_um * 1e-6, spacing_um * 1e-6, depth_um * 1e-6).unwrap();
    Layout::new(pattern, Outline::Rectangle { length_m: 1.2e-3, width_m: 1e-3 }).unwrap()
}

/// Positions of the pulses in one pass over `lines`, at a constant distance along the path, which continues from line
/// to line.
fn pulses(lines: &[Line], pulse_m: f64) -> Vec<[f64; 2]> {
    let (mut next_m, mut places) = (0.5 * pulse_m, Vec::new());
    for line in lines {
        let length = length_m(line);
        while next_m < length {
            places.push([0, 1].map(|axis| line[0][axis] + next_m / length * (line[1][axis] - line[0][axis])));
            next_m += pulse_m;
        }
        next_m -= length;
    }
    places
}

#[test]
fn depths_are_what_pulses_remove_one_by_one() {
    for (texture, lengths_um, laser) in [
        (Texture::new(Planform::Groove), [30.0, 60.0, 35.343], narrow()),
        (Texture::new(Planform::Groove), [69.9, 80.1, 35.343], laser(40.0, 8.0, 200.0, 0.45)),
        (Texture::new(Planform::Groove), [200.0, 100.0, 20.0], laser(20.0, 10.0, 100.0, 0.2)),
        (Texture::new(Planform::Square), [130.0, 170.0, 12.0], laser(23.0, 11.5, 4.6 * 50.0, 0.2)),
        (Texture::new(Planform::Disc), [130.0, 170.0, 12.0], laser(23.0, 11.5, 4.6 * 50.0, 0.2)),
    ] {
        let layout = laid(texture, lengths_um);
        let removal = Removal::new(&layout, &laser).unwrap();
        let marking = Marking::new(&laser).unwrap();
        let hatch = marking.on(&layout);
        let (pulse_m, spot_m) = (laser.pulse_distance_um().unwrap() * 1e-6, laser.spot_um.unwrap() * 1e-6);
        // One volume per pulse, divided by the area of the cavities.
        let all: Vec<Line> = layout.iter().flat_map(|cavity| hatch.lines(&cavity)).collect();
        let pulse_m3 = std::f64::consts::FRAC_PI_4 * spot_m * spot_m * laser.depth_per_burst_um.unwrap() * 1e-6;
        let volume_m3 = f64::from(removal.passes) * pulse_m3 * pulses(&all, pulse_m).len() as f64;
        let mean_um = volume_m3 / layout.cavity_area_m2() * 1e6;
        assert!((removal.mean_depth_um / mean_um - 1.0).abs() < 2e-3, "{texture:?}: {removal:?}, {mean_um}");
        // Pulses that reach points in the middle third of a cavity's width, close to the middle of its length, for 200
        // passes with random starts.
        let cavity = layout.iter().next().unwrap();
        let [dx, dy] = marking.direction(&cavity);
        let width_m = cavity.width_m.min(cavity.length_m);
        let centre_m = [cavity.centre_x_m, cavity.centre_y_m];
        let mut places = pulses(&hatch.lines(&cavity), pulse_m / 200.0);
        places.retain(|[x_m, y_m]| ((x_m - centre_m[0]) * dx + (y_m - centre_m[1]) * dy).abs() <= spot_m / 2.0);
        let mut reached = 0;
        for k in 0..200 {
            let across_m = width_m / 3.0 * ((f64::from(k) + 0.5) / 200.0 - 0.5);
            let at = [centre_m[0] - across_m * dy, centre_m[1] + across_m * dx];
            let are_pulses_close = |place: &&[f64; 2]| (place[0] - at[0]).hypot(place[1] - at[1]) <= spot_m / 2.0;
            reached += places.iter().filter(are_pulses_close).count();
        }
        let per_pass_um = reached as f64 / 200.0 / 200.0 * laser.depth_per_burst_um.unwrap();
        assert!(
            (removal.depth_per_pass_um / per_pass_um - 1.0).abs() < 5e-3,
            "{texture:?}: {removal:?}, {per_pass_um}"
        );
        // The nearest integer number of passes.
        assert!((removal.depth_um - lengths_um[2]).abs() <= 0.5 * removal.depth_per_pass_um + 1e-3, "{removal:?}");
    }
}

/// Two lines fill a groove as wide as the spot: an infinite hatch removes less in its middle, and more on average.
#[test]
fn a_groove_as_wide_as_the_spot_gets_the_passes_that_its_lines_need_and_warnings() {
    let layout = laid(Planform::Groove, [30.0, 60.0, 35.343]);
    let removal = Removal::new(&layout, &laser(30.0, 30.0, 200.0, 0.8)).unwrap();
    // Lines a = 7.125 um beside the middle: 0.8 um / 4 um times the mean of both chords over |y| < 5 um of a spot of 30 um,
    // (F(5 + a) - F(a - 5)) / 5, F = y sqrt(225 - y^2) + 225 asin(y/15): 51.066 um, twice the chord at 15 - a.
    assert!((removal.depth_per_pass_um - 0.2 * 51.066).abs() < 2e-3, "{removal:?}");
    assert_eq!((removal.passes, removal.width_um), (3, 30.0));
    // 3 x 0.2 x (pi/4) 30^2 x 2 lines / 30 um, minus the half spots at the ends of a groove.
    assert!((removal.mean_depth_um - 1.2 * std::f64::consts::FRAC_PI_4 * 30.0 * 0.97).abs() < 1e-3, "{removal:?}");
    // At the edges of the middle third the chord of the nearer line, 2 sqrt(15^2 - 2.125^2), and that of the other, 2
    // sqrt(15^2 - 12.125^2), add up to the least; in the middle, two of 2 sqrt(15^2 - 7.125^2) to the greatest.
    let reach_um =
        |offs_um: [f64; 2]| offs_um.iter().map(|off_um: &f64| 2.0 * (225.0 - off_um * off_um).sqrt()).sum::<f64>();
    let expected = [[2.125, 12.125], [7.125; 2]].map(|offs_um| 0.6 * reach_um(offs_um));
    assert!(removal.floor_um.iter().zip(expected).all(|(a, b)| (a - b).abs() < 3e-3), "{removal:?} {expected:?}");
    let [said] = &removal.warnings[..] else { panic!("{removal:?}") };
    assert!(
        said.starts_with("3 passes make 30.6 um in the middle of a cavity, -13 % of the design's 35.3 um"),
        "{said}"
    );
}

/// A flat floor, and edges on which half of its depth falls: both depths are those of the design.
#[test]
fn wide_cavities_are_as_deep_as_an_endless_hatch_says() {
    let laser = laser(10.0, 5.0, 100.0, 0.1);
    let step_um = laser.infinite_pass_um().unwrap();
    let layout = laid(Planform::Groove, [510.0, 90.0, 4.0 * step_um]);
    let removal = Removal::new(&layout, &laser).unwrap();
    assert_eq!((removal.passes, &removal.warnings[..]), (4, &[][..]));
    assert!((removal.depth_per_pass_um / step_um - 1.0).abs() < 0.01, "{removal:?}");
    // Volumes of pulses and of cavities agree up to the fraction of the ends, s / 1 mm.
    let input = ProcessInput { laser, tolerances: None, ..process::tests::input(None) };
    let sheet = ProcessSheet::new(&layout, input).unwrap();
    let share = sheet.work.removed_volume_mm3.unwrap() / sheet.specimen.cavity_volume_mm3;
    assert!((share - (1.0 - 10.0 / 1000.0)).abs() < 1e-3, "{share}");
    let across = sheet.work.depths_across_um.unwrap();
    assert!(across.len() == 8 && across[0][1] < across[1][1]);
    // Bins of an eighth of half the width: a flat floor in all but the first, which holds the edge.
    let ends: Vec<f64> = across.iter().map(|[end_um, _]| *end_um).collect();
    assert!(ends.iter().zip(1..).all(|(end_um, bin)| (end_um - 31.875 * f64::from(bin)).abs() < 1e-9), "{ends:?}");
    assert!(sheet.work.depths_across_formula.unwrap().contains("the bin that ends at the distance x"));
    assert_eq!(sheet.work.depth_step_um, Some(removal.depth_per_pass_um));
    assert!(across[7][0] == 255.0 && (across[7][1] / removal.depth_um - 1.0).abs() < 0.01, "{across:?}");
    assert_eq!(toml::from_str::<Removal>(&toml::to_string(&removal).unwrap()).unwrap(), removal);
}

/// The advised speed makes the depth of a design at once: in the next design, a pass is what its lines remove.
#[test]
fn the_advised_speed_makes_the_depth_of_the_design() {
    // Lines of 20 um lie 11 um apart in a width of 42 um, so that a pass removes more than in an infinite hatch.
    for (planform, width_um, laser) in [
        (Planform::Groove, 42.0, laser(20.0, 20.0, 200.0, 0.5)),
        (Planform::Groove, 100.0, laser(25.0, 25.0, 200.0, 1.0)),
        (Planform::Groove, 40.0, laser(23.0, 11.5, 200.0, 1.0)),
        (Planform::Disc, 40.0, laser(23.0, 11.5, 200.0, 1.0)),
        (Planform::Disc, 60.0, laser(25.0, 6.0, 200.0, 1.0)),
        (Planform::Square, 100.0, laser(25.0, 25.0, 200.0, 1.0)),
    ] {
        let depth_um = 1.4 * laser.infinite_pass_um().unwrap();
        let layout = laid(planform, [width_um, 60.0, depth_um]);
        let removal = Removal::new(&layout, &laser).unwrap();
        let speed_mm_s = removal.speed_for_depth_mm_s.unwrap();
        let is_said = removal.warnings.iter().any(|said| {
            said.contains(" um in the middle ")
                && said.contains(&format!("{} mm/s instead of 200", decimal(speed_mm_s, 1)))
        });
        assert!(is_said, "{removal:?}");
        let mended = Laser { speed_mm_s: Some(speed_mm_s), ..laser };
        let removal = Removal::new(&layout, &mended).unwrap();
        assert!((removal.depth_um / depth_um - 1.0).abs() < 1e-3, "{removal:?}");
        assert!((removal.speed_for_depth_mm_s.unwrap() / speed_mm_s - 1.0).abs() < 1e-3, "{removal:?}");
        // The search takes that depth for whole passes, which it did not before.
        assert!(laser.check_depth(layout.pattern()).is_err());
        assert_eq!(mended.check_depth(layout.pattern()), Ok(()));
        let step_um = mended.depth_step_um(layout.pattern()).unwrap();
        assert!((removal.depth_per_pass_um / step_um - 1.0).abs() < 1e-3, "{removal:?}, {step_um}");
    }
}

/// Depths of designs are whole steps, so that passes make them in any cavity.
#[test]
fn whole_depth_steps_are_whole_passes_in_every_kind_of_cavity() {
    let laser = laser(23.0, 15.0, 200.0, 0.2);
    for texture in every_kind() {
        let pattern = |depth_um: f64| *laid(texture, [131.2, 170.0, depth_um]).pattern();
        let step_um = laser.depth_step_um(&pattern(10.0)).unwrap();
        let removal = Removal::new(&laid(texture, [131.2, 170.0, 2.0 * step_um]), &laser).unwrap();
        assert_eq!(removal.passes, 2);
        assert!((removal.depth_um / (2.0 * step_um) - 1.0).abs() < 1e-3, "{texture:?}: {removal:?}, {step_um}");
        assert_eq!(laser.check_depth(&pattern(2.0 * step_um)), Ok(()));
    }
}

/// Ridges between coarse lines are an uneven floor, and not corners that the spot does not reach.
#[test]
fn a_floor_is_stated_and_warned_of_beyond_the_tolerance() {
    let removal = |width_um: f64, hatch_um: f64| {
        let laser = laser(25.0, hatch_um, 200.0, 1.0);
        let step_um = laser.depth_step_um(laid(Planform::Groove, [width_um, 60.0, 5.0]).pattern()).unwrap();
        Removal::new(&laid(Planform::Groove, [width_um, 60.0, 2.0 * step_um]), &laser).unwrap()
    };
    // A spot on a line removes 25 um / 4 um x 1 um a pass; where it leaves that line, its chord on the next, 22.5 um apart,
    // is 2 sqrt(12.5^2 - 10^2) = 15 um.
    let coarse = removal(225.0, 25.0);
    assert!((coarse.floor_um[0] - 7.5).abs() < 0.02 && (coarse.floor_um[1] - 12.5).abs() < 0.01, "{coarse:?}");
    assert_eq!(coarse.warnings, Vec::<String>::new());
    assert_eq!(coarse.clone().with_depth_tolerance(Some(3.6)).warnings.len(), 0);
    let [said] = &coarse.clone().with_depth_tolerance(Some(0.5)).warnings[..] else { panic!("{coarse:?}") };
    assert!(said.starts_with("the floor between lines and on them is ") && said.contains("0.5 um: "), "{said}");
    let fine = removal(225.0, 2.5);
    assert!(fine.floor_um[0] > 0.9 * fine.depth_um && fine.floor_um[1] < 1.1 * fine.depth_um, "{fine:?}");
    // Ridges between lines almost as far apart as the spot is wide.
    let ridges = removal(900.0, 25.0);
    assert!(ridges.floor_um[0] < 0.5 * ridges.depth_um && ridges.warnings.is_empty(), "{ridges:?}");
}

/// Between a design and its lines a disc of 60 um is 60.7 um wide by area, as a surface is measured, and 64 um by the
/// chord through its middle.
#[test]
fn the_width_of_a_disc_is_that_of_its_area() {
    for (width_um, spot_um, hatch_um) in
        [(60.0, 25.0, 12.5), (40.0, 23.0, 11.5), (60.0, 25.0, 6.0), (130.0, 23.0, 11.5)]
    {
        let removal =
            Removal::new(&laid(Planform::Disc, [width_um, 60.0, 8.0]), &laser(spot_um, hatch_um, 200.0, 1.0)).unwrap();
        assert!((removal.width_um / width_um - 1.0).abs() < 0.02, "{removal:?}");
        assert!(removal.warnings.iter().all(|said| !said.starts_with("across the lines")), "{removal:?}");
    }
}

#[test]
fn every_kind_of_cavity_has_its_passes() {
    let laser = laser(23.0, 15.0, 200.0, 0.2);
    for texture in every_kind() {
        let removal = Removal::new(&laid(texture, [131.2, 170.0, 12.0]), &laser).unwrap();
        assert!(removal.passes > 0 && (removal.depth_um / 12.0 - 1.0).abs() < 0.3, "{texture:?}: {removal:?}");
        assert!(removal.mean_depth_um < 1.05 * removal.depth_um, "{texture:?}: {removal:?}");
    }
    let still = Laser { speed_mm_s: None, ..laser };
    assert_eq!(Removal::new(&laid(Planform::Square, [131.2, 170.0, 12.0]), &still), None);
    let removal = Removal::new(&laid(Planform::Square, [22.9, 170.0, 12.0]), &laser).unwrap();
    assert_eq!(removal.mean_depth_um, 0.0);
    assert!(removal.warnings[0].contains("no line is left"));
}
