//! A drawing of the textured specimen at scale.

use std::fmt::Write as _;

use slipgrid_pattern::Planform;

use crate::number::{COORDINATE_DECIMALS, MICROMETRE_DECIMALS, decimal, push_decimal};
use crate::{Heading, Layout, Outline};

/// Blue of the cavities, dark grey of lines and text, light grey of the specimen: told apart in
/// any colour vision and in print.
const CAVITY_COLOUR: &str = "#0072b2";
const INK_COLOUR: &str = "#333333";
const FACE_COLOUR: &str = "#f4f4f2";

/// Page measures in hundredths of the specimen's larger extent, so that every specimen reads alike.
const MARGIN: f64 = 4.0;
const CONTENT: f64 = 100.0;
const TITLE_SIZE: f64 = 3.2;
const TEXT_SIZE: f64 = 2.3;
const LINE_HEIGHT: f64 = 3.4;
const DETAIL_SIDE: f64 = 34.0;
const TEXT_LEFT: f64 = 42.0;
const VALUE_LEFT: f64 = 20.0;
/// Characters that fit a line of the title and of the caption.
const TITLE_CHARACTERS: usize = 58;
const CAPTION_CHARACTERS: usize = 48;

/// The layout as an SVG picture at scale 1:1: `width` and `height` in millimetres, one unit of the
/// view box a millimetre, coordinates rounded to one nanometre. The outline, the cavities (one
/// path) and the sliding direction are groups of their own in a frame whose origin is the
/// specimen's centre; as everywhere in SVG, y points down.
#[must_use]
pub fn svg(layout: &Layout, heading: &Heading) -> String {
    let [extent_x_m, extent_y_m] = layout.outline().extents_m();
    let (extent_x_mm, extent_y_mm) = (extent_x_m * 1e3, extent_y_m * 1e3);
    let unit_mm = extent_x_mm.max(extent_y_mm) / CONTENT;

    let title = wrap(heading.name, TITLE_CHARACTERS);
    let (dimensions, remarks) = (dimensions(layout), remarks(heading));
    let caption_lines = (1 + dimensions.len() + remarks.len()) as f64;
    let title_height = title.len() as f64 * 1.4 * TITLE_SIZE + 2.0;
    let specimen_top = MARGIN + title_height;
    let bar_top = specimen_top + extent_y_mm / unit_mm + 3.0;
    let footer_top = bar_top + 9.0;
    let footer_height = (DETAIL_SIDE + 13.0).max(caption_lines * LINE_HEIGHT);

    let mut page = Page { out: String::with_capacity(64 * layout.cavities() + 8192), unit_mm };
    page.open(2.0 * MARGIN + CONTENT, footer_top + footer_height + MARGIN);
    for (line, text) in title.iter().enumerate() {
        let y = MARGIN + (1.0 + 1.4 * line as f64) * TITLE_SIZE;
        page.text([MARGIN, y], "start", TITLE_SIZE, " font-weight=\"bold\"", text);
    }

    let centre = [MARGIN + CONTENT / 2.0, specimen_top + extent_y_mm / unit_mm / 2.0];
    page.specimen(layout, centre);
    page.sliding_direction([MARGIN, bar_top + 3.0]);
    page.scale_bar([MARGIN + CONTENT, bar_top + 3.0]);
    page.detail(layout, [MARGIN, footer_top]);
    let text_left = MARGIN + TEXT_LEFT;
    let mut baseline = footer_top + TEXT_SIZE;
    let arrangement = match layout.pattern().planform() {
        Planform::Groove => "Grooves across the sliding direction",
        Planform::Square => "Square cavities on a square lattice",
    };
    page.text([text_left, baseline], "start", TEXT_SIZE, " font-weight=\"bold\"", arrangement);
    for (name, value) in &dimensions {
        baseline += LINE_HEIGHT;
        page.text([text_left, baseline], "start", TEXT_SIZE, "", name);
        page.text([text_left + VALUE_LEFT, baseline], "start", TEXT_SIZE, "", value);
    }
    for text in &remarks {
        baseline += LINE_HEIGHT;
        page.text([text_left, baseline], "start", TEXT_SIZE, "", text);
    }
    page.out.push_str("</svg>\n");
    page.out
}

/// The dimensions, a name and a value a line.
fn dimensions(layout: &Layout) -> Vec<(&'static str, String)> {
    let pattern = layout.pattern();
    let um = |length_m: f64| format!("{} µm", decimal(length_m * 1e6, MICROMETRE_DECIMALS));
    let mm = |length_m: f64| decimal(length_m * 1e3, COORDINATE_DECIMALS);
    let cavities = match pattern.planform() {
        Planform::Groove => "grooves",
        Planform::Square => "cavities",
    };
    vec![
        ("w  width", um(pattern.width_m())),
        ("s  spacing", um(pattern.spacing_m())),
        ("p  pitch", um(pattern.pitch_m())),
        ("depth", um(pattern.depth_m())),
        ("areal density", format!("{:.2} % of the pattern", 100.0 * pattern.areal_density())),
        ("", format!("{:.2} % of the specimen", 100.0 * layout.areal_density())),
        (cavities, layout.cavities().to_string()),
        (
            layout.outline().name(),
            match *layout.outline() {
                Outline::Disc { diameter_m } => format!("diameter {} mm", mm(diameter_m)),
                Outline::Rectangle { length_m, width_m } => format!("{} mm × {} mm", mm(length_m), mm(width_m)),
            },
        ),
    ]
}

/// Notes and version, one string a line.
fn remarks(heading: &Heading) -> Vec<String> {
    let mut lines: Vec<String> = heading.notes.iter().flat_map(|note| wrap(note, CAPTION_CHARACTERS)).collect();
    lines.push(format!("slipgrid {}", heading.version));
    lines
}

/// `text` broken between words into lines of at most `characters`; a longer word stays whole.
fn wrap(text: &str, characters: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= characters => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// `text` as XML character data; control characters, which XML forbids, are left out.
fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars().filter(|c| !c.is_control()) {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            c => out.push(c),
        }
    }
    out
}

/// The largest of 1, 2, 5 times a power of ten that is at most `limit`.
fn round_length(limit: f64) -> f64 {
    let power = 10_f64.powf(limit.log10().floor());
    [5.0, 2.0].into_iter().map(|step| step * power).find(|&length| length <= limit).unwrap_or(power)
}

/// A picture under construction. Positions are in page units, written in millimetres.
struct Page {
    out: String,
    unit_mm: f64,
}

impl Page {
    /// A page length in millimetres. Decoration needs no nanometres.
    fn mm(&self, length: f64) -> String {
        decimal(length * self.unit_mm, 4)
    }

    fn open(&mut self, width: f64, height: f64) {
        let (width_mm, height_mm) = (self.mm(width), self.mm(height));
        let _ = writeln!(
            self.out,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width_mm}mm\" height=\"{height_mm}mm\" \
             viewBox=\"0 0 {width_mm} {height_mm}\" font-family=\"sans-serif\" fill=\"{INK_COLOUR}\">\n\
             <rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>"
        );
    }

    fn text(&mut self, [x, y]: [f64; 2], anchor: &str, size: f64, style: &str, text: &str) {
        let (x, y, size, text) = (self.mm(x), self.mm(y), self.mm(size), escape(text));
        let _ = writeln!(
            self.out,
            "<text x=\"{x}\" y=\"{y}\" text-anchor=\"{anchor}\" font-size=\"{size}\"{style}>{text}</text>"
        );
    }

    fn line(&mut self, from: [f64; 2], to: [f64; 2]) {
        let (from_x, from_y, to_x, to_y) = (self.mm(from[0]), self.mm(from[1]), self.mm(to[0]), self.mm(to[1]));
        let width = self.mm(0.22);
        let _ = writeln!(
            self.out,
            "<path d=\"M{from_x} {from_y}L{to_x} {to_y}\" stroke=\"{INK_COLOUR}\" stroke-width=\"{width}\"/>"
        );
    }

    /// A filled triangle with its tip at `tip`, pointing along `direction` (1 or -1) in x.
    fn arrowhead(&mut self, tip: [f64; 2], direction: f64, length: f64) {
        let back = tip[0] - direction * length;
        let points = [tip, [back, tip[1] - 0.35 * length], [back, tip[1] + 0.35 * length]]
            .map(|[x, y]| format!("{} {}", self.mm(x), self.mm(y)));
        let _ = writeln!(self.out, "<path d=\"M{}L{}L{}z\"/>", points[0], points[1], points[2]);
    }

    /// Outline and cavities, in a frame that starts at the specimen's centre.
    fn specimen(&mut self, layout: &Layout, centre: [f64; 2]) {
        let (x, y, stroke) = (self.mm(centre[0]), self.mm(centre[1]), self.mm(0.25));
        let _ = writeln!(self.out, "<g id=\"specimen\" transform=\"translate({x} {y})\">");
        let face = format!("id=\"outline\" fill=\"{FACE_COLOUR}\" stroke=\"{INK_COLOUR}\" stroke-width=\"{stroke}\"");
        let mm = |length_m: f64| decimal(length_m * 1e3, COORDINATE_DECIMALS);
        let _ = match *layout.outline() {
            Outline::Disc { diameter_m } => writeln!(self.out, "<circle {face} r=\"{}\"/>", mm(diameter_m / 2.0)),
            Outline::Rectangle { length_m, width_m } => writeln!(
                self.out,
                "<rect {face} x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/>",
                mm(-length_m / 2.0),
                mm(-width_m / 2.0),
                mm(length_m),
                mm(width_m)
            ),
        };
        let _ = write!(self.out, "<path id=\"cavities\" fill=\"{CAVITY_COLOUR}\" d=\"");
        for cavity in layout.iter() {
            // Upper left corner; y points down.
            let corner_x_m = cavity.centre_x_m - cavity.width_m / 2.0;
            let corner_y_m = -cavity.centre_y_m - cavity.length_m / 2.0;
            let steps = [(" ", corner_y_m), ("h", cavity.width_m), ("v", cavity.length_m), ("h", -cavity.width_m)];
            for (command, length_m) in std::iter::once(("M", corner_x_m)).chain(steps) {
                self.out.push_str(command);
                push_decimal(&mut self.out, length_m * 1e3, COORDINATE_DECIMALS);
            }
            self.out.push('z');
        }
        self.out.push_str("\"/>\n</g>\n");
    }

    fn sliding_direction(&mut self, [left, y]: [f64; 2]) {
        self.out.push_str("<g id=\"sliding-direction\">\n");
        self.line([left, y], [left + 12.0, y]);
        self.arrowhead([left + 13.0, y], 1.0, 2.4);
        self.text([left + 15.0, y + 0.35 * TEXT_SIZE], "start", TEXT_SIZE, "", "sliding direction x");
        self.out.push_str("</g>\n");
    }

    fn scale_bar(&mut self, [right, y]: [f64; 2]) {
        let length_mm = round_length(20.0 * self.unit_mm);
        let left = right - length_mm / self.unit_mm;
        self.out.push_str("<g id=\"scale-bar\">\n");
        let (x, top, width, height) = (self.mm(left), self.mm(y - 0.4), self.mm(right - left), self.mm(0.8));
        let _ = writeln!(self.out, "<rect x=\"{x}\" y=\"{top}\" width=\"{width}\" height=\"{height}\"/>");
        let label = if length_mm >= 1.0 {
            format!("{} mm", decimal(length_mm, 3))
        } else {
            format!("{} µm", decimal(length_mm * 1e3, 3))
        };
        self.text([left - 1.5, y + 0.35 * TEXT_SIZE], "end", TEXT_SIZE, "", &label);
        self.out.push_str("</g>\n");
    }

    /// Two by two periods, enlarged, with dimension lines.
    fn detail(&mut self, layout: &Layout, [left, top]: [f64; 2]) {
        let pattern = layout.pattern();
        let pitch = DETAIL_SIDE / 2.0;
        let width = pitch * pattern.section_density();
        self.out.push_str("<g id=\"detail\">\n");
        let stroke = self.mm(0.2);
        let frame = format!("fill=\"{FACE_COLOUR}\" stroke=\"{INK_COLOUR}\" stroke-width=\"{stroke}\"");
        self.rectangle([left, top], [DETAIL_SIDE; 2], &frame);
        let cavity = format!("fill=\"{CAVITY_COLOUR}\"");
        let starts = [(pitch - width) / 2.0, (pitch - width) / 2.0 + pitch];
        for x in starts {
            match pattern.planform() {
                Planform::Groove => self.rectangle([left + x, top], [width, DETAIL_SIDE], &cavity),
                Planform::Square => {
                    for y in starts {
                        self.rectangle([left + x, top + y], [width; 2], &cavity);
                    }
                }
            }
        }
        // Width and spacing on one line, the pitch below it.
        let [first, second] = starts.map(|start| left + start);
        let y = top + DETAIL_SIDE + 3.0;
        for x in [first, first + width, second] {
            self.line([x, top + DETAIL_SIDE + 0.8], [x, y + 0.8]);
        }
        self.dimension([first, first + width], y, "w");
        self.dimension([first + width, second], y, "s");
        for x in [first, second] {
            self.line([x, y + 0.8], [x, y + 5.8]);
        }
        self.dimension([first, second], y + 5.0, "p");
        let enlargement = DETAIL_SIDE * self.unit_mm / (2.0 * pattern.pitch_m() * 1e3);
        let decimals = if enlargement < 9.95 { 1 } else { 0 };
        let label = format!("detail, {} : 1", decimal(enlargement, decimals));
        self.text([left + DETAIL_SIDE, y + 9.0], "end", TEXT_SIZE, "", &label);
        self.out.push_str("</g>\n");
    }

    fn rectangle(&mut self, [x, y]: [f64; 2], [width, height]: [f64; 2], style: &str) {
        let (x, y, width, height) = (self.mm(x), self.mm(y), self.mm(width), self.mm(height));
        let _ = writeln!(self.out, "<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" {style}/>");
    }

    fn dimension(&mut self, [from, to]: [f64; 2], y: f64, label: &str) {
        self.line([from, y], [to, y]);
        let head = (0.4 * (to - from)).min(1.2);
        self.arrowhead([from, y], -1.0, head);
        self.arrowhead([to, y], 1.0, head);
        self.text([(from + to) / 2.0, y + 2.4], "middle", TEXT_SIZE, " font-style=\"italic\"", label);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_pattern::Pattern;

    const HEADING: Heading = Heading { name: "a < b & c", version: "0.0.0", notes: &["synthetic surface"] };

    fn layout(planform: Planform, outline: Outline) -> Layout {
        Layout::new(Pattern::new(planform, 131.2347e-6, 369.9999e-6, 5.2e-6).unwrap(), outline).unwrap()
    }

    /// The value of attribute `name` in the element that contains `marker`.
    fn attribute<'a>(svg: &'a str, marker: &str, name: &str) -> &'a str {
        let at = svg.find(marker).unwrap();
        let start = svg[..=at].rfind('<').unwrap();
        let element = &svg[start..at + svg[at..].find('>').unwrap()];
        let from = element.find(&format!(" {name}=\"")).unwrap() + name.len() + 3;
        &element[from..from + element[from..].find('"').unwrap()]
    }

    #[test]
    fn cavities_read_back_to_the_same_polygons_within_two_nanometres() {
        for planform in Planform::ALL {
            for outline in [Outline::Disc { diameter_m: 10e-3 }, Outline::Rectangle { length_m: 6e-3, width_m: 3e-3 }] {
                let layout = layout(planform, outline);
                let picture = svg(&layout, &HEADING);
                let path = attribute(&picture, "id=\"cavities\"", "d");
                let boxes: Vec<&str> = path.split_terminator('z').collect();
                assert_eq!(boxes.len(), layout.cavities());
                for (text, cavity) in boxes.iter().zip(layout.iter()) {
                    let values: Vec<f64> = text
                        .split(['M', ' ', 'h', 'v'])
                        .filter(|value| !value.is_empty())
                        .map(|value| value.parse().unwrap())
                        .collect();
                    let [x, y, width, length, back] = values[..] else { panic!("{text}") };
                    assert_eq!(width, -back);
                    // The path's corners, y turned up again, from the least x and y.
                    let read = [[x, -y - length], [x + width, -y - length], [x + width, -y], [x, -y]];
                    for (corner_mm, corner_m) in read.iter().zip(cavity.corners_m()) {
                        for axis in 0..2 {
                            assert!((corner_mm[axis] - corner_m[axis] * 1e3).abs() < 2e-6);
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn the_picture_is_at_scale() {
        let picture = svg(&layout(Planform::Square, Outline::Disc { diameter_m: 10e-3 }), &HEADING);
        let (width, height) = (attribute(&picture, "viewBox", "width"), attribute(&picture, "viewBox", "height"));
        let view_box = format!("0 0 {} {}", width.strip_suffix("mm").unwrap(), height.strip_suffix("mm").unwrap());
        assert_eq!(attribute(&picture, "viewBox", "viewBox"), view_box);
        assert_eq!(attribute(&picture, "id=\"outline\"", "r"), "5");
        let bar = &picture[picture.find("id=\"scale-bar\"").unwrap()..];
        assert_eq!(attribute(bar, "<rect", "width"), "2");
        assert!(bar.contains(">2 mm</text>"));
    }

    #[test]
    fn names_are_escaped_and_notes_appear() {
        let picture = svg(&layout(Planform::Groove, Outline::Disc { diameter_m: 10e-3 }), &HEADING);
        assert!(picture.contains(">a &lt; b &amp; c</text>"));
        assert!(picture.contains(">synthetic surface</text>"));
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
}
