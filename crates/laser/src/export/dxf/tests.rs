//! A reader of R12 written from the description of the format, and drawings read with it.

use super::*;
use crate::export::layout::every_kind;
use slipgrid_model::pattern::{Pattern, Planform, Texture};

/// Content of a drawing: values of the header's variables, names of layers, and entities.
struct Drawing {
    variables: Vec<(String, Vec<String>)>,
    layers: Vec<String>,
    entities: Vec<Entity>,
}

/// An entity: kind, groups, and the vertices of a polyline.
struct Entity {
    kind: String,
    groups: Vec<(u16, String)>,
    vertices_mm: Vec<[f64; 2]>,
    ended: bool,
}

impl Entity {
    fn text(&self, code: u16) -> &str {
        &self.groups.iter().find(|(group, _)| *group == code).unwrap().1
    }

    fn real(&self, code: u16) -> f64 {
        self.text(code).parse().unwrap()
    }
}

fn read(text: &str) -> Drawing {
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len() % 2, 0, "codes and values come in pairs");
    let pairs = lines.chunks(2).map(|pair| (pair[0].trim().parse().unwrap(), pair[1].to_owned()));
    // Records: a group 0 with their kind, and the groups that follow it.
    let mut records: Vec<Entity> = Vec::new();
    for (code, value) in pairs.filter(|(code, _)| *code != 999) {
        match code {
            0 => records.push(Entity { kind: value, groups: Vec::new(), vertices_mm: Vec::new(), ended: false }),
            _ => records.last_mut().unwrap().groups.push((code, value)),
        }
    }
    assert_eq!(records.pop().unwrap().kind, "EOF");
    let mut drawing = Drawing { variables: Vec::new(), layers: Vec::new(), entities: Vec::new() };
    for section in records.split(|record| record.kind == "ENDSEC").filter(|section| !section.is_empty()) {
        let (first, rest) = section.split_first().unwrap();
        assert!(first.kind == "SECTION" && rest.iter().all(|record| record.kind != "SECTION"), "sections do not nest");
        for (code, value) in &first.groups[1..] {
            match code {
                9 => drawing.variables.push((value.clone(), Vec::new())),
                _ => drawing.variables.last_mut().unwrap().1.push(value.clone()),
            }
        }
        drawing.layers.extend(rest.iter().filter(|of| of.kind == "LAYER").map(|layer| layer.text(2).to_owned()));
        for record in rest.iter().filter(|_| first.text(2) == "ENTITIES") {
            match (record.kind.as_str(), drawing.entities.last_mut()) {
                ("VERTEX", Some(polyline)) => {
                    let codes: Vec<u16> = record.groups.iter().map(|(code, _)| *code).collect();
                    assert_eq!((&codes[..], record.text(30)), (&[8, 10, 20, 30][..], "0.0"));
                    polyline.vertices_mm.push([record.real(10), record.real(20)]);
                }
                ("SEQEND", Some(polyline)) => polyline.ended = true,
                (kind, _) => drawing.entities.push(Entity {
                    kind: kind.to_owned(),
                    groups: record.groups.clone(),
                    vertices_mm: Vec::new(),
                    ended: false,
                }),
            }
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
            let cavities: Vec<&Entity> = drawing.entities.iter().filter(|e| e.text(8) == LAYER_CAVITIES).collect();
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
    let circle = disc.entities.iter().find(|e| e.text(8) == LAYER_OUTLINE).unwrap();
    assert_eq!((circle.kind.as_str(), circle.real(10), circle.real(20), circle.real(40)), ("CIRCLE", 0.0, 0.0, 5.0));

    let outline = Outline::Rectangle { length_m: 6e-3, width_m: 3e-3 };
    let rectangle = read(&drawn(&layout(Planform::Square, outline), &HEADING));
    let polygon = rectangle.entities.iter().find(|e| e.text(8) == LAYER_OUTLINE).unwrap();
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
    assert!(drawing.entities.iter().all(|entity| drawing.layers.iter().any(|layer| layer == entity.text(8))));
}

#[test]
fn the_arrow_turns_with_the_sliding_direction_off_the_specimen_and_within_the_extents() {
    for angle_deg in [-180.0, -120.0, -45.0, 0.0, 30.0, 90.0] {
        let texture = Texture::new(Planform::Disc).with_sliding_angle_deg(angle_deg).unwrap();
        let text = drawn(&layout(texture, Outline::Disc { diameter_m: 10e-3 }), &HEADING);
        let turned = format!("Sliding direction: {angle_deg} degrees from x, anticlockwise.");
        assert_eq!(text.contains(&turned), angle_deg != 0.0);
        let drawing = read(&text);
        let lowest_mm: f64 =
            drawing.variables.iter().find(|(name, _)| name == "$EXTMIN").unwrap().1[1].parse().unwrap();
        let lines: Vec<&Entity> = drawing.entities.iter().filter(|e| e.text(8) == LAYER_SLIDING_DIRECTION).collect();
        assert_eq!(lines.len(), 3);
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
    assert_eq!(read(&text).entities.iter().filter(|e| e.text(8) == LAYER_CAVITIES).count(), 19);
    let heading = Heading { name: "Größe 20 µm", ..heading };
    let text = drawn(&layout(Planform::Groove, Outline::Disc { diameter_m: 10e-3 }), &heading);
    assert!(text.starts_with("999\nslipgrid 0.0.0: Groesse 20 um\n"), "{}", &text[..60]);
}
