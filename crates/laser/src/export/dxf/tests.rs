//! A reader of R12 written from the description of the format, and drawings read with it.

use super::*;
use crate::export::layout::every_kind;
use slipgrid_model::pattern::{Pattern, Planform, Texture};

/// Content of a drawing.
#[derive(Default)]
struct Drawing {
    variables: Vec<(String, Vec<String>)>,
    layers: Vec<String>,
    entities: Vec<Entity>,
}

/// An entity: kind, layer, groups, and the vertices of a polyline.
struct Entity {
    kind: String,
    layer: String,
    groups: Vec<(u16, String)>,
    vertices_mm: Vec<[f64; 2]>,
    ended: bool,
}

impl Entity {
    fn real(&self, code: u16) -> f64 {
        self.groups.iter().find(|(group, _)| *group == code).unwrap().1.parse().unwrap()
    }
}

fn read(text: &str) -> Drawing {
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len() % 2, 0, "codes and values come in pairs");
    let pairs: Vec<(u16, &str)> = lines
        .chunks(2)
        .map(|pair| (pair[0].trim().parse().unwrap(), pair[1]))
        .filter(|(code, _)| *code != 999)
        .collect();
    assert_eq!(pairs.last(), Some(&(0, "EOF")));

    let mut drawing = Drawing::default();
    let mut section = "";
    let mut record = "";
    for window in pairs.windows(2) {
        let ((code, value), next) = (window[0], window[1]);
        if code == 0 {
            record = value;
            match value {
                "SECTION" => {
                    assert!(section.is_empty(), "sections do not nest");
                    section = next.1;
                }
                "ENDSEC" => section = "",
                "VERTEX" => drawing.entities.last_mut().unwrap().vertices_mm.push([f64::NAN; 2]),
                "SEQEND" => drawing.entities.last_mut().unwrap().ended = true,
                _ if section == "ENTITIES" => drawing.entities.push(Entity {
                    kind: value.to_owned(),
                    layer: String::new(),
                    groups: Vec::new(),
                    vertices_mm: Vec::new(),
                    ended: false,
                }),
                _ => {}
            }
            continue;
        }
        match (section, record) {
            ("HEADER", _) if code == 9 => drawing.variables.push((value.to_owned(), Vec::new())),
            ("HEADER", _) if code != 2 => drawing.variables.last_mut().unwrap().1.push(value.to_owned()),
            ("TABLES", "LAYER") if code == 2 => drawing.layers.push(value.to_owned()),
            ("ENTITIES", "VERTEX") => {
                let vertex = drawing.entities.last_mut().unwrap().vertices_mm.last_mut().unwrap();
                match code {
                    10 => vertex[0] = value.parse().unwrap(),
                    20 => vertex[1] = value.parse().unwrap(),
                    30 => assert_eq!(value, "0.0"),
                    8 => {}
                    _ => panic!("group {code} in a vertex"),
                }
            }
            ("ENTITIES", "SECTION" | "SEQEND") => {}
            ("ENTITIES", _) => {
                let entity = drawing.entities.last_mut().unwrap();
                if code == 8 {
                    entity.layer = value.to_owned();
                } else {
                    entity.groups.push((code, value.to_owned()));
                }
            }
            _ => {}
        }
    }
    drawing
}

const HEADING: Heading = Heading { name: "test", version: "0.0.0", notes: &[] };

fn drawn(layout: &Layout, heading: &Heading) -> String {
    crate::export::stream::text(|to| dxf(layout, heading, to))
}

fn layout(texture: impl Into<Texture>, outline: Outline) -> Layout {
    Layout::new(Pattern::new(texture, 131.2347e-6, 369.9999e-6, 5.2e-6).unwrap(), outline).unwrap()
}

#[test]
fn cavities_read_back_to_the_same_shapes_within_half_a_nanometre() {
    for texture in every_kind() {
        for outline in [Outline::Disc { diameter_m: 10e-3 }, Outline::Rectangle { length_m: 6e-3, width_m: 3e-3 }] {
            let layout = layout(texture, outline);
            let drawing = read(&drawn(&layout, &HEADING));
            let cavities: Vec<&Entity> = drawing.entities.iter().filter(|e| e.layer == LAYER_CAVITIES).collect();
            let laid: Vec<Boundary> = layout.iter().flat_map(|cavity| cavity.boundaries()).collect();
            assert!(cavities.len() == laid.len() && laid.len() >= layout.cavities());
            let close = |read_mm: f64, laid_m: f64| assert!((read_mm - laid_m * 1e3).abs() <= 0.5001e-6);
            for (entity, boundary) in cavities.iter().zip(laid) {
                match boundary {
                    Boundary::Circle { centre_m, radius_m } => {
                        assert_eq!((entity.kind.as_str(), texture.planform()), ("CIRCLE", Planform::Disc));
                        close(entity.real(10), centre_m[0]);
                        close(entity.real(20), centre_m[1]);
                        close(entity.real(40), radius_m);
                    }
                    Boundary::Polygon { .. } => {
                        let corners_m = boundary.polygon_m();
                        assert_eq!(entity.kind, "POLYLINE");
                        assert_eq!(entity.real(66), 1.0);
                        assert_eq!(entity.real(70), 1.0, "closed");
                        assert!(entity.ended);
                        assert_eq!(entity.vertices_mm.len(), corners_m.len());
                        for (vertex_mm, corner_m) in entity.vertices_mm.iter().zip(corners_m) {
                            close(vertex_mm[0], corner_m[0]);
                            close(vertex_mm[1], corner_m[1]);
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn the_outline_is_the_specimens() {
    let disc = read(&drawn(&layout(Planform::Square, Outline::Disc { diameter_m: 10e-3 }), &HEADING));
    let circle = disc.entities.iter().find(|e| e.layer == LAYER_OUTLINE).unwrap();
    assert_eq!((circle.kind.as_str(), circle.real(10), circle.real(20), circle.real(40)), ("CIRCLE", 0.0, 0.0, 5.0));

    let outline = Outline::Rectangle { length_m: 6e-3, width_m: 3e-3 };
    let rectangle = read(&drawn(&layout(Planform::Square, outline), &HEADING));
    let polygon = rectangle.entities.iter().find(|e| e.layer == LAYER_OUTLINE).unwrap();
    assert_eq!(polygon.vertices_mm, [[-3.0, -1.5], [3.0, -1.5], [3.0, 1.5], [-3.0, 1.5]]);
}

#[test]
fn header_and_layers_are_those_of_release_12() {
    let drawing = read(&drawn(&layout(Planform::Square, Outline::Disc { diameter_m: 10e-3 }), &HEADING));
    let variable = |name: &str| drawing.variables.iter().find(|(n, _)| n == name).map(|(_, values)| values.clone());
    assert_eq!(variable("$ACADVER").unwrap(), ["AC1009"]);
    assert_eq!(variable("$EXTMAX").unwrap(), ["5.0", "5.0", "0.0"]);
    assert!(variable("$INSUNITS").is_none(), "not a variable of R12");
    assert_eq!(drawing.layers, ["0", LAYER_OUTLINE, LAYER_CAVITIES, LAYER_SLIDING_DIRECTION, LAYER_ORIGIN]);
    assert!(drawing.entities.iter().all(|entity| drawing.layers.contains(&entity.layer)));
}

#[test]
fn the_arrow_points_along_x_and_stays_off_the_specimen() {
    let drawing = read(&drawn(&layout(Planform::Groove, Outline::Disc { diameter_m: 10e-3 }), &HEADING));
    let lines: Vec<&Entity> = drawing.entities.iter().filter(|e| e.layer == LAYER_SLIDING_DIRECTION).collect();
    assert_eq!(lines.len(), 3);
    assert!(lines[0].real(11) > lines[0].real(10) && lines[0].real(21) == lines[0].real(20));
    assert!(lines.iter().all(|line| line.real(20) < -5.0 && line.real(21) < -5.0));
}

#[test]
fn the_arrow_turns_with_the_sliding_direction_off_the_specimen_and_within_the_extents() {
    for angle_deg in [-180.0, -120.0, -45.0, 30.0, 90.0] {
        let texture = Texture::new(Planform::Disc).with_sliding_angle_deg(angle_deg).unwrap();
        let text = drawn(&layout(texture, Outline::Disc { diameter_m: 10e-3 }), &HEADING);
        assert!(text.contains(&format!("Sliding direction: {angle_deg} degrees from x, anticlockwise.")));
        let drawing = read(&text);
        let lowest_mm: f64 =
            drawing.variables.iter().find(|(name, _)| name == "$EXTMIN").unwrap().1[1].parse().unwrap();
        let lines: Vec<&Entity> = drawing.entities.iter().filter(|e| e.layer == LAYER_SLIDING_DIRECTION).collect();
        let (across, along) = (lines[0].real(21) - lines[0].real(20), lines[0].real(11) - lines[0].real(10));
        assert!((across.atan2(along).to_degrees().abs() - angle_deg.abs()).abs() < 1e-4);
        assert!(across.hypot(along) > 2.4 && (across - 2.5 * angle_deg.to_radians().sin()).abs() < 1e-5);
        for height_mm in lines.iter().flat_map(|line| [line.real(20), line.real(21)]) {
            assert!(height_mm < -5.0 && height_mm >= lowest_mm, "{angle_deg}: {height_mm}");
        }
    }
}

#[test]
fn comments_say_what_the_planform_leaves_open() {
    let comment = |texture: Texture| {
        let text = drawn(&layout(texture, Outline::Disc { diameter_m: 10e-3 }), &HEADING);
        text.lines().find(|line| line.starts_with("Pattern: ")).unwrap().to_owned()
    };
    assert!(comment(Planform::Square.into()).starts_with("Pattern: square, width 131.235 um, spacing 370.000 um"));
    let long = Texture::new(Planform::Rectangle).with_length_m(288.8e-6).unwrap();
    let staggered = long.with_arrangement(slipgrid_model::pattern::Arrangement::Staggered).unwrap();
    assert!(comment(staggered).starts_with("Pattern: rectangle, staggered, length 288.800 um, width"));
    let turned = Texture::new(Planform::Groove).with_groove_angle_deg(30.0).unwrap();
    assert!(comment(turned).starts_with("Pattern: groove, turned by 30 degrees from lying across x, width"));
}

#[test]
fn comments_stay_one_line_of_ascii() {
    let heading = Heading { name: "µ\n  0\nEOF", version: "0.0.0", notes: &["synthetic surface"] };
    let text = drawn(&layout(Planform::Groove, Outline::Disc { diameter_m: 10e-3 }), &heading);
    assert!(text.is_ascii());
    assert!(text.starts_with("999\nslipgrid 0.0.0: u?  0?EOF\n999\nUnits: millimetres"));
    assert!(text.contains("999\nsynthetic surface\n"));
    assert_eq!(read(&text).entities.iter().filter(|e| e.layer == LAYER_CAVITIES).count(), 19);
    let heading = Heading { name: "Größe 20 µm", ..heading };
    let text = drawn(&layout(Planform::Groove, Outline::Disc { diameter_m: 10e-3 }), &heading);
    assert!(text.starts_with("999\nslipgrid 0.0.0: Groesse 20 um\n"), "{}", &text[..60]);
}
