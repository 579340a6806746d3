use std::f64::consts::PI;

use slipgrid_model::pattern::Texture;

use super::*;
use crate::export::layout::every_kind;
use crate::export::stream::text;
use crate::export::{Heading, Laser, dxf, dxf_of_sectors, svg_of_sectors};

const DISC: Outline = Outline::Disc { diameter_m: 10e-3 };
const RING: Outline = Outline::Ring { outer_diameter_m: 15e-3, inner_diameter_m: 5e-3 };
const PLATE: Outline = Outline::Rectangle { length_m: 14e-3, width_m: 10e-3 };

fn division(outline: Outline, count: usize) -> Division {
    Division::new(Specimen { outline, is_clipped: true }, count).unwrap()
}

fn pattern(texture: impl Into<Texture>, width_um: f64, spacing_um: f64) -> Pattern {
    Pattern::new(texture, width_um * 1e-6, spacing_um * 1e-6, 10e-6).unwrap()
}

fn grooves(count: usize) -> Vec<Pattern> {
    (1..=count).map(|n| pattern(Planform::Groove, 20.0 * n as f64, 150.0)).collect()
}

/// The polygon turned by an angle in degrees.
fn turned(polygon: &[[f64; 2]], deg: f64) -> Vec<[f64; 2]> {
    let (sine, cosine) = deg.to_radians().sin_cos();
    polygon.iter().map(|[x, y]| [x * cosine - y * sine, x * sine + y * cosine]).collect()
}

#[test]
fn sectors_and_lands_make_up_the_face() {
    for (outline, count) in [(DISC, 2), (DISC, 3), (DISC, 7), (RING, 4), (PLATE, 2), (PLATE, 4), (PLATE, 5)] {
        let of = division(outline, count);
        let areas: Vec<f64> = (1..=count).map(|number| of.area_m2(number)).collect();
        let sum: f64 = areas.iter().sum();
        // The lands are strips from the centre to the border, which overlap at the centre by less than the square of
        // their width each; on a ring they lie between hole and border.
        let [x, y] = outline.extents_m();
        let half = |deg: f64| {
            let (sine, cosine) = deg.to_radians().sin_cos();
            if let Outline::Rectangle { .. } = outline {
                (x / 2.0 / cosine.abs()).min(y / 2.0 / sine.abs())
            } else {
                x / 2.0 - outline.hole_m() / 2.0
            }
        };
        let long: f64 = (1..=count).map(|number| half(of.middle_deg(number) + of.angle_deg() / 2.0)).sum();
        let lands = outline.area_m2() - sum;
        let slack = 2.0 * of.land_m() * of.land_m() * count as f64;
        assert!((lands - long * of.land_m()).abs() < slack, "{outline:?} {count}: {lands} {long}");
        if !matches!(outline, Outline::Rectangle { .. }) {
            assert!(areas.iter().all(|area| (area / areas[0] - 1.0).abs() < 1e-7), "{areas:?}");
        }
    }
    // Half a disc beside a land of width b: R^2 acos(b / 2R) - b / 2 sqrt(R^2 - b^2 / 4).
    let (of, radius) = (division(DISC, 2), 5e-3_f64);
    let half = of.land_m() / 2.0;
    let expected = radius * radius * (half / radius).acos() - half * (radius * radius - half * half).sqrt();
    // Chords of the border reduce the area by less than 4e-6.
    assert!((of.area_m2(1) / expected - 1.0).abs() < 4e-6);
}

#[test]
fn the_largest_circle_touches_both_lands_and_the_rim() {
    for count in [2, 3, 6, 12] {
        let of = division(DISC, count);
        // r sin(pi / K) - b / 2 = R - r
        let (half, radius) = ((PI / count as f64).sin(), 5e-3);
        let r = (radius + of.land_m() / 2.0) / (1.0 + half);
        assert!((of.circle_m(1) - 2.0 * (radius - r)).abs() < 1e-12, "{count}");
        assert!((of.circle_m(count) - of.circle_m(1)).abs() < 1e-12);
    }
    // Between the hole and the border of a ring.
    assert!((division(RING, 2).circle_m(1) - 5e-3).abs() < 1e-12);
}

#[test]
fn every_cavity_lies_on_its_own_sector_and_none_on_a_land() {
    for outline in [DISC, RING, PLATE] {
        for is_clipped in [false, true] {
            let of = Division::new(Specimen { outline, is_clipped }, 3).unwrap();
            for texture in every_kind() {
                let patterns = [50.0, 70.0, 90.0].map(|width_um| pattern(texture, width_um, 300.0));
                let sectors = of.lay(&patterns).unwrap();
                for sector in &sectors {
                    let turn_deg = of.turn_deg(sector.number());
                    let mut area = 0.0;
                    for boundary in sector.boundaries() {
                        let corners = boundary.polygon_m();
                        area += area_m2(&corners);
                        for [x, y] in corners {
                            assert!(outline.contains([x * (1.0 - 1e-9), y * (1.0 - 1e-9)]) || outline.hole_m() > 0.0);
                            // In axes with the sector's middle line upwards: both lands are cleared.
                            let own = turned(&[[x, y]], 90.0 - of.middle_deg(sector.number()))[0];
                            let (sine, cosine) = (60.0_f64).to_radians().sin_cos();
                            let away = own[1] * sine - own[0].abs() * cosine;
                            assert!(away >= of.land_m() / 2.0 - 1e-12, "{texture:?} {turn_deg} {away}");
                        }
                    }
                    // Chords of a circle of 25 um reduce its area by 5e-4.
                    assert!((area / sector.cavity_area_m2() - 1.0).abs() < 1e-3 && sector.cavities() > 0);
                    assert!(sector.areal_density() < 1.05 * sector.pattern().areal_density(), "{texture:?}");
                }
            }
        }
    }
}

/// The areal density on a sector approaches that of the pattern for finer patterns.
#[test]
fn the_areal_density_as_cut_is_near_the_pattern_s() {
    for (texture, near) in [
        (Texture::new(Planform::Groove), 0.01),
        (Texture::new(Planform::Crosshatch), 0.01),
        (Texture::new(Planform::Square), 0.12),
    ] {
        for sector in division(DISC, 3).lay(&[pattern(texture, 40.0, 60.0); 3]).unwrap() {
            let share = sector.areal_density() / sector.pattern().areal_density();
            assert!((share - 1.0).abs() < near, "{texture:?}: {share}");
        }
    }
}

#[test]
fn sectors_of_a_disc_are_turned_copies_and_those_of_a_plate_are_not() {
    let same = [pattern(Planform::Groove, 60.0, 150.0); 3];
    let sectors = division(DISC, 3).lay(&same).unwrap();
    let first: Vec<Vec<[f64; 2]>> = sectors[0].boundaries().map(|of| of.polygon_m()).collect();
    for (place, sector) in sectors.iter().enumerate() {
        for (own, of) in sector.boundaries().zip(&first) {
            let expected = turned(of, 120.0 * place as f64);
            for ([x, y], [x1, y1]) in own.polygon_m().iter().zip(&expected) {
                assert!((x - x1).hypot(y - y1) < 1e-12);
            }
        }
    }
    // Grooves of the second sector of a plate still lie across x.
    let plate = division(PLATE, 3).lay(&same).unwrap();
    for boundary in plate[1].boundaries() {
        let corners = boundary.polygon_m();
        let (low, high) = corners.iter().fold((1.0_f64, -1.0_f64), |(low, high), [x, _]| (low.min(*x), high.max(*x)));
        assert!(high - low < 60.1e-6);
    }
}

#[test]
fn what_cannot_be_divided_is_refused() {
    let specimen = Specimen { outline: DISC, is_clipped: true };
    for count in [0, 1, 13] {
        let refused = Division::new(specimen, count).unwrap_err().to_string();
        assert!(refused.contains("expected 2 to 12"), "{refused}");
    }
    let of = division(DISC, 3);
    let coarse = [pattern(Planform::Groove, 100.0, 1000.0); 3];
    assert!(!of.holds(&coarse[0]) && of.holds(&grooves(1)[0]));
    let refused = of.lay(&coarse).unwrap_err().to_string();
    assert!(refused.contains("fewer than 4 periods of 1100 um"), "{refused}");
    assert!(of.lay(&grooves(2)).is_err());
}

#[test]
fn drawings_have_a_layer_for_every_sector_and_a_mark() {
    let sectors = division(DISC, 3).lay(&grooves(3)).unwrap();
    let heading = Heading { name: "three", version: "0", notes: &["a note"] };
    let laser = Laser { spot_um: Some(25.0), depth_per_burst_um: Some(2.5), ..Laser::default() };
    let drawn = text(|to| dxf_of_sectors(&sectors, &laser, &heading, to));
    for sector in &sectors {
        let own = format!("  8\nCAVITIES_{}\n 66", sector.number());
        assert_eq!(drawn.matches(&own).count(), sector.cavities());
        assert!(drawn.contains(&format!(
            "CAVITIES_{}: groove, width {:.3} um",
            sector.number(),
            20.0 * sector.number() as f64
        )));
    }
    assert_eq!(drawn.matches("  8\nMARK\n 66").count(), 1);
    assert!(drawn.contains(", 4 bursts") && drawn.ends_with("  0\nEOF\n") && drawn.contains("a note"));
    let picture = text(|to| svg_of_sectors(&sectors, &laser, &heading, to));
    for number in 1..=3 {
        let path =
            picture.split(&format!("id=\"sector-{number}\"")).nth(1).unwrap().split("/>").next().unwrap().to_owned();
        assert_eq!(path.matches('z').count(), sectors[number - 1].cavities());
    }
    assert!(picture.contains("the arrow is the sliding direction on sector 1"));
    assert!(picture.contains("id=\"mark\"") && picture.contains("a mean of all sectors"));
    assert!(picture.contains("1: grooves 20 µm wide, spacing 150 µm, 10 µm deep, 4 bursts"));
    // The mark lies on a land.
    let of = sectors[0].division();
    for [x, y] in of.mark_m() {
        let away = turned(&[[x, y]], -(of.middle_deg(1) - 60.0))[0];
        assert!(away[1].abs() < of.land_m() / 2.0 && away[0] > 0.0 && away[0] < 5e-3);
    }
    // The drawing of a single pattern has equal axes.
    let layout = sectors[0].whole();
    assert!(text(|to| dxf(layout, &heading, to)).contains("$EXTMIN"));
}
