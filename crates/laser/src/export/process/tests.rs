//! Process sheets of the published pattern, and of every other kind.

use super::*;
use crate::export::Outline;
use crate::export::work::spots_along;
use slipgrid_model::pattern::{Arrangement, Polygon, Rim, RimProfile, Texture};

/// Laser and pattern of Balestra et al., J. Tribol. 144, 031704, Sec. "Laser patterning"; the repetition rate is an
/// assumption.
pub(crate) fn input(repetition_hz: Option<f64>) -> ProcessInput {
    ProcessInput {
        name: "LDPE, lower friction".to_owned(),
        made_by: MadeBy::slipgrid(1),
        seed: 1,
        laser: Laser {
            wavelength_nm: Some(1064.0),
            spot_um: Some(23.0),
            pulse_ns: Some(4.0),
            power_density_gw_cm2: Some(3.65),
            depth_per_burst_um: Some(2.6),
            repetition_hz,
            ..Laser::default()
        },
        tolerances: Some(Tolerances {
            width_um: Some(8.0),
            spacing_um: Some(13.0),
            depth_um: Some(1.3),
            basis: "scatter of the published pattern".to_owned(),
        }),
        material: Provenance {
            name: "LDPE on grey cast iron".to_owned(),
            source: "Balestra et al., J. Tribol. 144, 031704".to_owned(),
            synthetic_surface: true,
            ..Provenance::default()
        },
    }
}

fn layout(planform: Planform, outline: Outline) -> Layout {
    Layout::new(Pattern::new(planform, 130e-6, 370e-6, 5.2e-6).unwrap(), outline).unwrap()
}

const DISC: Outline = Outline::Disc { diameter_m: 10e-3 };

#[test]
fn the_published_pattern_takes_two_bursts_on_36_spots_a_cavity() {
    let layout = layout(Planform::Square, DISC);
    let sheet = ProcessSheet::new(&layout, input(Some(50.0))).unwrap();
    assert_eq!(sheet.work.bursts_per_cavity, Some(2));
    assert_eq!(sheet.work.depth_of_bursts_um, Some(5.2));
    // 130 / 23 = 5.65: six spots along each side.
    assert_eq!(sheet.work.spots_per_cavity, Some(36));
    let spots = 36 * layout.cavities() as u64;
    assert_eq!(sheet.work.spots_on_specimen, Some(spots));
    assert_eq!(sheet.work.estimated_time_s, Some(spots as f64 * 2.0 / 50.0));
    assert_eq!(sheet.work.no_estimate_because, None);
    assert_eq!(sheet.pattern.pitch_um, 500.0);
    assert_eq!(sheet.pattern.areal_density, 0.0676);
    assert_eq!(sheet.specimen.face.diameter_mm, Some(10.0));
}

#[test]
fn grooves_count_the_spots_of_each_length() {
    let outline = Outline::Rectangle { length_m: 1.2e-3, width_m: 2e-3 };
    let sheet = ProcessSheet::new(&layout(Planform::Groove, outline), input(None)).unwrap();
    // 2000 / 23 = 86.96.
    assert_eq!(sheet.work.spots_per_cavity, Some(6 * 87));
    assert_eq!(sheet.work.spots_on_specimen, Some(3 * 6 * 87));
    assert_eq!(spots_along(46e-6, 23.0), 2);
    assert_eq!(spots_along(10e-6, 23.0), 1);
}

#[test]
fn a_missing_number_is_the_reason_for_no_estimate() {
    let mut input = input(None);
    input.laser.spot_um = None;
    let sheet = ProcessSheet::new(&layout(Planform::Square, DISC), input).unwrap();
    assert_eq!(sheet.work.estimated_time_s, None);
    assert_eq!(sheet.work.no_estimate_because.as_deref(), Some("not given: spot_um, repetition_hz"));
}

#[test]
fn sheets_of_every_kind_read_back_and_name_what_is_not_plain() {
    for texture in crate::export::layout::every_kind() {
        let pattern = Pattern::new(texture, 130e-6, 370e-6, 5.2e-6).unwrap();
        let input = ProcessInput { seed: u64::MAX, ..input(Some(50.0)) };
        let sheet = ProcessSheet::new(&Layout::new(pattern, DISC).unwrap(), input).unwrap();
        let text = sheet.to_toml().unwrap();
        assert_eq!(toml::from_str::<ProcessSheet>(&text).unwrap(), sheet);
        assert_eq!(sheet.seed, u64::MAX);
        assert!(!text.contains("99999") && !text.contains("00000"), "{text}");
        let named = |key: &str| text.lines().any(|line| line.starts_with(&format!("{key} = ")));
        assert_eq!(named("angle_deg"), texture.orientation_deg() != 0.0);
        assert_eq!(named("sliding_angle_deg"), texture.sliding_angle_deg() != 0.0);
        assert_eq!(text.contains("x is the sliding direction"), texture.sliding_angle_deg() == 0.0);
        assert_eq!(text.contains("arrangement = \"staggered\""), texture.arrangement() == Arrangement::Staggered);
        assert_eq!(named("length_um"), texture.planform() == Planform::Rectangle);
        assert_eq!(sheet.pattern.areal_density, six_digits(pattern.areal_density()));
    }
    let turned = Texture::new(Planform::Groove).with_groove_angle_deg(33.3).unwrap();
    let pattern = Pattern::new(turned, 130e-6, 370e-6, 5.2e-6).unwrap();
    let sheet = ProcessSheet::new(&Layout::new(pattern, DISC).unwrap(), input(None)).unwrap();
    assert_eq!(sheet.pattern.texture.angle_deg, Some(33.3));
    assert!(sheet.specimen.arrangement.starts_with("grooves turned by 33.3 degrees from lying across x, one"));
}

#[test]
fn dimensions_are_rounded_to_a_nanometre_and_rows_state_their_gap() {
    let corners: Vec<[f64; 2]> =
        (0..6).map(|k| (f64::from(k) * std::f64::consts::FRAC_PI_3).sin_cos().into()).collect();
    let hexagon = Texture::new(Planform::Polygon).with_outline(Polygon::new(&corners).unwrap()).unwrap();
    let hexagon = hexagon.with_arrangement(Arrangement::Hexagonal).unwrap();
    let rim = Rim::new(1e-6 / 3.0, 1e-5 / 3.0, RimProfile::Flat).unwrap();
    let pattern = Pattern::new(hexagon.with_rim(rim), 1e-4 / 3.0, 2e-4 / 3.0, 5.2e-6).unwrap();
    let sheet = ProcessSheet::new(&Layout::clipped(pattern, DISC).unwrap(), input(None)).unwrap();
    let text = sheet.to_toml().unwrap();
    let digits = |number: &str| number.trim_start_matches(['0', '.']).chars().filter(char::is_ascii_digit).count();
    let numbers = text.split(|letter: char| !(letter.is_ascii_digit() || ".e-".contains(letter)));
    let long: Vec<&str> = numbers.filter(|number| number.parse::<f64>().is_ok() && digits(number) > 8).collect();
    assert!(long.is_empty(), "{long:?}");
    let own = (sheet.pattern.texture.spacing_across_um, sheet.pattern.pitch_across_um);
    assert_eq!(own, (pattern.spacing_across_m().map(micrometres), pattern.pitch_across_m().map(micrometres)));
    assert_eq!(sheet.specimen.at_the_rim, "cavities are cut");
    assert!(text.contains(&format!("cavities = {}", sheet.specimen.cavities)) && !text.contains("clipped"), "{text}");
}

#[test]
fn numbers_that_mean_nothing_are_refused() {
    let layout = layout(Planform::Square, DISC);
    let mut bad = input(None);
    bad.laser.spot_um = Some(0.0);
    assert!(ProcessSheet::new(&layout, bad).unwrap_err().to_string().contains("spot_um"));
    let mut bad = input(None);
    bad.tolerances = Some(Tolerances { depth_um: Some(f64::NAN), ..Default::default() });
    assert!(ProcessSheet::new(&layout, bad).unwrap_err().to_string().contains("depth_um"));
}

#[test]
fn a_moving_spot_counts_lines_overlaps_and_passes() {
    let layout = layout(Planform::Square, DISC);
    let mut input = input(Some(1000.0));
    input.laser = Laser { speed_mm_s: Some(4.6), hatch_um: Some(11.5), ..input.laser };
    let work = ProcessSheet::new(&layout, input).unwrap().work;
    // 4.6 mm/s at 1 kHz: a burst every 4.6 um, a fifth of the spot.
    assert_eq!((work.pulse_distance_um, work.pulse_overlap), (Some(4.6), Some(0.8)));
    // 130 - 2 6.1552 um in eleven gaps are 10.699 um each, which overlap by 1 - 10.699/23.
    assert_eq!((work.greatest_line_distance_um, work.line_overlap), (Some(10.699), Some(0.534826)));
    // (pi/4) 23^2 / (4.6 11.5) = 2.5 pi; two bursts make 5.2 um, and one pass over lines 10.7 um apart makes more.
    let removal = work.removal.unwrap();
    assert_eq!((work.bursts_per_pass, removal.passes), (Some(7.85398), 1));
    assert!((removal.depth_um / (20.42 * 11.5 / 10.7) - 1.0).abs() < 0.02, "{}", removal.depth_um);
    // Twelve lines from edge to edge.
    let cavities = layout.cavities() as f64;
    assert_eq!(work.lines_on_specimen, Some(12 * layout.cavities() as u64));
    assert!((work.marked_length_mm.unwrap() / (cavities * 12.0 * 0.13) - 1.0).abs() < 1e-5);
    assert!((work.estimated_time_s.unwrap() / (cavities * 12.0 * 0.13 / 4.6) - 1.0).abs() < 1e-5);
    assert_eq!(work.spot_compensation_um, Some(6.155));
}

#[test]
fn leaning_walls_leave_less_volume() {
    let outline = Outline::Rectangle { length_m: 0.2e-3, width_m: 0.2e-3 };
    for (planform, expected_mm3) in [
        // Frustum of a pyramid, d/3 (A + sqrt(A B) + B), d = 5.2 um, sides 130 and 119.6 um; likewise for a cone.
        (Planform::Square, 5.2e-3 / 3.0 * (0.0169 + 0.13 * 0.1196 + 0.1196 * 0.1196)),
        (Planform::Disc, 5.2e-3 / 3.0 * (0.0169 + 0.13 * 0.1196 + 0.1196 * 0.1196) * std::f64::consts::FRAC_PI_4),
    ] {
        let mut input = input(None);
        input.laser.wall_taper_deg = Some(45.0);
        let sheet = ProcessSheet::new(&layout(planform, outline), input).unwrap();
        assert!((sheet.specimen.cavity_volume_mm3 / expected_mm3 - 1.0).abs() < 1e-5, "{planform}");
        assert_eq!(sheet.work.floor_width_um, Some(119.6));
    }
}

#[test]
fn rims_stand_on_the_sheet_as_what_the_design_assumes_and_no_longer_among_what_is_not_modelled() {
    let plain = ProcessSheet::new(&layout(Planform::Groove, DISC), input(None)).unwrap();
    assert!(plain.not_modelled[0].starts_with("recast rims") && !plain.to_toml().unwrap().contains("rim_"));
    let rim = Rim::following_depth(&[[0.0, 0.0], [10.4e-6, 0.2e-6]], 12e-6, RimProfile::Ramp).unwrap();
    let texture = Texture::new(Planform::Groove).with_rim(rim.with_height_std_m(2e-8).unwrap());
    let layout = Layout::new(Pattern::new(texture, 130e-6, 370e-6, 5.2e-6).unwrap(), DISC).unwrap();
    let sheet = ProcessSheet::new(&layout, input(None)).unwrap();
    assert!(!sheet.not_modelled.iter().any(|what| what.contains("rim")) && sheet.not_modelled.len() == 5);
    let text = sheet.to_toml().unwrap();
    for said in ["rim_height_um = 0.1\n", "rim_height_std_um = 0.02", "rim_width_um = 12.0", "rim_profile = \"ramp\""] {
        assert!(text.contains(said), "{said}: {text}");
    }
    assert!(text.contains("have to be measured"));
    assert_eq!(toml::from_str::<ProcessSheet>(&text).unwrap(), sheet);
}

#[test]
fn a_mask_takes_one_burst_of_a_whole_cavity_at_a_time() {
    let outline = Outline::Disc { diameter_m: 2e-3 };
    let layout = Layout::new(Pattern::new(Planform::Square, 120e-6, 100e-6, 2e-6).unwrap(), outline).unwrap();
    let mut input = input(Some(20e3));
    input.laser = Laser {
        depth_per_burst_um: Some(0.5),
        exposure: Some(crate::export::Exposure::Mask),
        spot_um: None,
        ..input.laser
    };
    let work = ProcessSheet::new(&layout, input).unwrap().work;
    assert_eq!((layout.cavities(), work.bursts_per_cavity), (57, Some(4)));
    assert_eq!((work.spots_per_cavity, work.spots_on_specimen, &work.no_estimate_because), (None, None, &None));
    assert_eq!(work.estimated_time_s, Some(57.0 * 4.0 / 20e3));
    assert_eq!(work.estimated_time_formula, "cavities * bursts_per_cavity / repetition_hz");
    // No line follows a contour: the sheet states neither the edges nor their length.
    assert_eq!((work.lines_on_specimen, work.marked_length_mm), (None, None));
    assert_eq!((work.marking_direction, work.spot_compensation_um), (None, None));
    assert!(work.spots_formula.starts_with("none are counted: a mask exposes each cavity as a whole"));
}
