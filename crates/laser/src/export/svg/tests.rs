//! Pictures read back.

use super::*;
use crate::export::layout::every_kind;
use slipgrid_model::pattern::{Pattern, Texture};

const HEADING: Heading = Heading { name: "a < b & c", version: "0.0.0", notes: &["synthetic surface"] };

fn layout(texture: impl Into<Texture>, outline: Outline) -> Layout {
    Layout::new(Pattern::new(texture, 131.2347e-6, 369.9999e-6, 5.2e-6).unwrap(), outline).unwrap()
}

fn drawn(layout: &Layout, heading: &Heading) -> String {
    crate::export::stream::text(|to| svg(layout, heading, to))
}

/// Value of the attribute `name` in the element that contains `marker`.
fn attribute<'a>(svg: &'a str, marker: &str, name: &str) -> &'a str {
    let at = svg.find(marker).unwrap();
    let start = svg[..=at].rfind('<').unwrap();
    let element = &svg[start..at + svg[at..].find('>').unwrap()];
    let from = element.find(&format!(" {name}=\"")).unwrap() + name.len() + 3;
    &element[from..from + element[from..].find('"').unwrap()]
}

/// Content of a path of cavities: corners, or leftmost point and radius, with y pointing up.
enum Read {
    Corners(Vec<[f64; 2]>),
    Circle([f64; 3]),
}

fn read(path: &str) -> Read {
    let numbers = |text: &str| -> Vec<f64> {
        text.split(['M', 'L', ' ', 'h', 'v', 'a']).filter_map(|value| value.parse().ok()).collect()
    };
    let values = numbers(path);
    match (path.contains('a'), path.contains('L'), &values[..]) {
        // Two arcs of radius r, a diameter forth and back.
        (true, false, &[x, y, r, r1, 0.0, 0.0, 0.0, over, 0.0, r2, r3, 0.0, 0.0, 0.0, back, 0.0]) => {
            assert!(r1 == r && r2 == r && r3 == r && back == -over && (over - 2.0 * r).abs() < 1.1e-6, "{path}");
            Read::Circle([x, -y, r])
        }
        (false, true, values) => Read::Corners(values.chunks_exact(2).map(|corner| [corner[0], -corner[1]]).collect()),
        (false, false, &[x, y, width, length, back]) => {
            assert_eq!(width, -back);
            Read::Corners(vec![[x, -y - length], [x + width, -y - length], [x + width, -y], [x, -y]])
        }
        _ => panic!("{path}"),
    }
}

#[test]
fn cavities_read_back_to_the_same_shapes_within_two_nanometres() {
    for texture in every_kind() {
        for outline in [Outline::Disc { diameter_m: 10e-3 }, Outline::Rectangle { length_m: 6e-3, width_m: 3e-3 }] {
            let layout = layout(texture, outline);
            let picture = drawn(&layout, &HEADING);
            let path = attribute(&picture, "id=\"cavities\"", "d");
            let paths: Vec<&str> = path.split_terminator('z').collect();
            let laid: Vec<Boundary> = layout.iter().flat_map(|cavity| cavity.boundaries()).collect();
            assert_eq!(paths.len(), laid.len());
            for (text, boundary) in paths.iter().zip(laid) {
                let (read_mm, laid_m): (Vec<f64>, Vec<f64>) = match (read(text), &boundary) {
                    (Read::Corners(corners), Boundary::Polygon { .. }) => {
                        assert_eq!(corners.len(), boundary.polygon_m().len());
                        (corners.concat(), boundary.polygon_m().concat())
                    }
                    (Read::Circle(circle), Boundary::Circle { centre_m: [x, y], radius_m }) => {
                        (circle.to_vec(), vec![x - radius_m, *y, *radius_m])
                    }
                    _ => panic!("{text}"),
                };
                for (read_mm, laid_m) in read_mm.iter().zip(laid_m) {
                    assert!((read_mm - laid_m * 1e3).abs() < 2e-6, "{text}");
                }
            }
        }
    }
}

#[test]
fn the_caption_says_what_lies_where() {
    let outline = Outline::Disc { diameter_m: 10e-3 };
    let groove = Texture::new(Planform::Groove);
    let staggered =
        |planform| Texture::new(planform).with_arrangement(slipgrid_model::pattern::Arrangement::Staggered).unwrap();
    for (texture, texts) in [
        (groove, vec!["Grooves across the sliding direction", "sliding direction x", "w  width"]),
        (groove.with_groove_angle_deg(30.0).unwrap(), vec!["Grooves turned by 30 degrees from lying<", ">across x<"]),
        (Planform::Square.into(), vec!["Square cavities on a square lattice", "sliding direction x<"]),
        (
            staggered(Planform::Disc).with_sliding_angle_deg(-90.0).unwrap(),
            vec!["Round cavities on a staggered lattice,", "w  diameter", "sliding direction, -90° from x"],
        ),
        (
            Texture::new(Planform::Rectangle).with_length_m(1e-4).unwrap(),
            vec!["Rectangular cavities on a rectangular<", ">length<", ">pitch across<", ">470 µm<"],
        ),
    ] {
        let picture = drawn(&layout(texture, outline), &HEADING);
        for text in texts {
            assert!(picture.contains(text), "{text}");
        }
    }
}

#[test]
fn the_picture_is_at_scale() {
    let picture = drawn(&layout(Planform::Square, Outline::Disc { diameter_m: 10e-3 }), &HEADING);
    // One unit is a millimetre, and the picture is printed at true size.
    let number = |text: &str| text.parse::<f64>().unwrap();
    let shown =
        ["width", "height"].map(|side| number(attribute(&picture, "viewBox", side).strip_suffix("mm").unwrap()));
    let view_box: Vec<f64> = attribute(&picture, "viewBox", "viewBox").split(' ').map(number).collect();
    assert_eq!((view_box[2], &view_box[2..]), (10.8, &shown[..]));
    assert_eq!(attribute(&picture, "id=\"outline\"", "r"), "5");
    let bar = &picture[picture.find("id=\"scale-bar\"").unwrap()..];
    assert_eq!(attribute(bar, "<rect", "width"), "2");
    assert!(bar.contains(">2 mm</text>"));
}

#[test]
fn names_are_escaped_and_notes_appear() {
    let picture = drawn(&layout(Planform::Groove, Outline::Disc { diameter_m: 10e-3 }), &HEADING);
    assert!(picture.contains(">a &lt; b &amp; c: textured specimen from above</text>"));
    assert!(picture.contains(">synthetic surface</text>"));
    assert_eq!(escape("a\u{fffe}\u{ffff}\u{0}\u{1b}\nb\u{1fffe}é"), "ab\u{1fffe}é");
}

#[test]
fn round_lengths_are_one_two_or_five() {
    for (limit, expected) in [(2.0, 2.0), (1.99, 1.0), (0.07, 0.05), (10.0, 10.0), (99.0, 50.0)] {
        assert!((round_length(limit) - expected).abs() < 1e-12 * expected);
    }
}

#[test]
fn lines_break_between_words() {
    assert_eq!(wrap("one two  three", 7), ["one two", "three"]);
    assert_eq!(wrap("unbreakable", 3), ["unbreakable"]);
}
