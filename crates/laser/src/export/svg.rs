//! Drawing of the textured specimen to scale.

mod detail;
mod of_sectors;

pub use of_sectors::svg_of_sectors;

use std::fmt::Write as _;
use std::io;

use slipgrid_model::pattern::{Contour, Pattern, Planform, Texture};

use crate::export::number::COORDINATE_DECIMALS;
use crate::export::{
    Boundary, Cavity, Heading, Layout, MICROMETRE_DECIMALS, Outline, cavities, decimal, degrees, flush_full,
    flush_rest, groove_direction, lattice, push_decimal,
};

/// Fill of cavities, blue: the three colours are distinguishable with any colour vision and in print.
const CAVITY_COLOUR: &str = "#0072b2";
/// Colour of lines and text, dark grey.
const INK_COLOUR: &str = "#333333";
/// Fill of the specimen, light grey.
const FACE_COLOUR: &str = "#f4f4f2";

/// Margin around the page, in page units: hundredths of the specimen's larger extent, so that the page does not depend
/// on the size of the specimen.
const MARGIN: f64 = 4.0;
/// Width of the content between the margins, in page units: the specimen's larger extent.
const CONTENT: f64 = 100.0;
/// Font size of the title, in page units.
const TITLE_SIZE: f64 = 3.2;
/// Font size of other text, in page units.
const TEXT_SIZE: f64 = 2.3;
/// Distance between lines of text, in page units.
const LINE_HEIGHT: f64 = 3.4;
/// Side of the enlarged detail, a square, in page units.
const DETAIL_SIDE: f64 = 34.0;
/// Distance of the caption from the left margin, in page units.
const TEXT_LEFT: f64 = 42.0;
/// Distance of the values in the caption from the beginning of their names, in page units.
const VALUE_LEFT: f64 = 20.0;
/// Maximum number of characters per line of the title.
const TITLE_CHARACTERS: usize = 58;
/// Maximum number of characters per line of the caption.
const CAPTION_CHARACTERS: usize = 48;
/// Maximum number of characters per line of the bold head of the caption.
const BOLD_CHARACTERS: usize = 40;

/// Writes the layout as an SVG picture at true size. One unit of the view box is a millimetre; coordinates are rounded
/// to one nanometre. For a laser, use the DXF, which states its unit. The outline, the cavities (one path) and the
/// sliding direction are separate groups; outline and cavities are in a frame whose origin is the specimen's centre. As
/// usual in SVG, y points down.
///
/// # Errors
/// Errors of the writer `to`.
pub fn svg(layout: &Layout, heading: &Heading, to: &mut dyn io::Write) -> io::Result<()> {
    let [extent_x_m, extent_y_m] = layout.outline().extents_m();
    let (extent_x_mm, extent_y_mm) = (extent_x_m * 1e3, extent_y_m * 1e3);
    let unit_mm = extent_x_mm.max(extent_y_mm) / CONTENT;

    let title = title(heading);
    let dimensions = dimensions(layout);
    let mut remarks: Vec<String> = heading.notes.iter().flat_map(|note| wrap(note, CAPTION_CHARACTERS)).collect();
    remarks.push(format!("slipgrid {}", heading.version));
    let arrangement = wrap(&arrangement(layout.pattern()), BOLD_CHARACTERS);
    let caption_lines = (arrangement.len() + dimensions.len() + remarks.len()) as f64;
    let title_height = title.len() as f64 * 1.4 * TITLE_SIZE + 2.0;
    let specimen_top = MARGIN + title_height;
    let bar_top = specimen_top + extent_y_mm / unit_mm + 3.0;
    let footer_top = bar_top + 9.0;
    let footer_height = (DETAIL_SIDE + 13.0).max(caption_lines * LINE_HEIGHT);

    let mut page = Page { out: String::new(), unit_mm };
    page.open(2.0 * MARGIN + CONTENT, footer_top + footer_height + MARGIN);
    page.title(&title);

    let centre = [MARGIN + CONTENT / 2.0, specimen_top + extent_y_mm / unit_mm / 2.0];
    page.specimen(layout, centre, to)?;
    page.sliding_direction(layout.pattern().texture(), [MARGIN, bar_top + 3.0]);
    page.scale_bar([MARGIN + CONTENT, bar_top + 3.0]);
    page.detail(layout, [MARGIN, footer_top]);
    let text_left = MARGIN + TEXT_LEFT;
    let mut baseline = footer_top + TEXT_SIZE - LINE_HEIGHT;
    for text in &arrangement {
        baseline += LINE_HEIGHT;
        page.text([text_left, baseline], "start", TEXT_SIZE, " font-weight=\"bold\"", text);
    }
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
    flush_rest(&mut page.out, to)
}

/// Lines of the title.
fn title(heading: &Heading) -> Vec<String> {
    wrap(&format!("{}: textured specimen from above", heading.name), TITLE_CHARACTERS)
}

/// Describes the arrangement of cavities, without a full stop.
fn arrangement(pattern: &Pattern) -> String {
    let what = cavities(pattern.planform());
    let words = match pattern.planform() {
        Planform::Groove => format!("{what} {}", groove_direction(pattern.texture())),
        Planform::Crosshatch => groove_direction(pattern.texture()),
        _ => format!("{what} on a {}", lattice(pattern)),
    };
    let mut letters = words.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// Dimensions for the caption, as pairs of name and value with unit.
fn dimensions(layout: &Layout) -> Vec<(&'static str, String)> {
    let pattern = layout.pattern();
    let um = |length_m: f64| format!("{} µm", decimal(length_m * 1e6, MICROMETRE_DECIMALS));
    let mm = |length_m: f64| decimal(length_m * 1e3, COORDINATE_DECIMALS);
    let texture = pattern.texture();
    let width = match texture.planform().contour() {
        Contour::Circle => "w  diameter",
        Contour::Rectangle => "w  width",
    };
    let mut lines = vec![
        (width, um(pattern.width_m())),
        ("s  spacing", um(pattern.spacing_m())),
        ("p  pitch", um(pattern.pitch_m())),
    ];
    if let Some(length_m) = texture.length_m() {
        lines.push(("length", um(length_m)));
    }
    if let Some(outline) = texture.outline() {
        lines.push(("corners", outline.vertices().len().to_string()));
        lines.extend(pattern.length_m().map(|length_m| ("extent across", um(length_m))));
    }
    if let Some(pitch_m) = pattern.pitch_across_m().filter(|&pitch_m| pitch_m != pattern.pitch_m()) {
        lines.push(("spacing across", um(pattern.spacing_across_m().unwrap_or(0.0))));
        lines.push(("pitch across", um(pitch_m)));
    }
    lines.extend([
        ("depth", um(pattern.depth_m())),
        ("areal density", format!("{:.2} % of the pattern", 100.0 * pattern.areal_density())),
        ("", format!("{:.2} % of the specimen", 100.0 * layout.areal_density())),
        (if pattern.planform().is_grooves() { "grooves" } else { "cavities" }, layout.cavities().to_string()),
        (
            layout.outline().name(),
            match *layout.outline() {
                Outline::Disc { diameter_m } => format!("diameter {} mm", mm(diameter_m)),
                Outline::Rectangle { length_m, width_m } => format!("{} mm × {} mm", mm(length_m), mm(width_m)),
                Outline::Ring { outer_diameter_m, inner_diameter_m } => {
                    format!("diameters {} and {} mm", mm(outer_diameter_m), mm(inner_diameter_m))
                }
            },
        ),
    ]);
    lines
}

/// Breaks `text` between words into lines of at most `characters`; longer words are not broken.
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

/// Whether XML allows `letter` in a line of text: XML 1.0 forbids control characters and U+FFFE and U+FFFF ("Char").
pub fn is_xml_letter(letter: char) -> bool {
    !letter.is_control() && !matches!(letter, '\u{fffe}' | '\u{ffff}')
}

/// Escapes `text` as XML character data, without forbidden characters.
fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars().filter(|c| is_xml_letter(*c)) {
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

/// Returns the largest of 1, 2 or 5 times a power of ten that is at most `limit`.
fn round_length(limit: f64) -> f64 {
    let power = 10_f64.powf(limit.log10().floor());
    [5.0, 2.0].into_iter().map(|step| step * power).find(|&length| length <= limit).unwrap_or(power)
}

/// A picture under construction. Positions are in page units of `unit_mm` millimetres, and are written in millimetres.
struct Page {
    out: String,
    unit_mm: f64,
}

impl Page {
    /// Formats a page length in millimetres; decoration does not need nanometres.
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

    fn title(&mut self, lines: &[String]) {
        for (line, text) in lines.iter().enumerate() {
            let y = MARGIN + (1.0 + 1.4 * line as f64) * TITLE_SIZE;
            self.text([MARGIN, y], "start", TITLE_SIZE, " font-weight=\"bold\"", text);
        }
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

    /// Draws a filled triangle with its tip at `tip`, pointing along the unit vector `[along_x, along_y]` of the page.
    fn arrowhead(&mut self, tip: [f64; 2], [along_x, along_y]: [f64; 2], length: f64) {
        let back = [tip[0] - along_x * length, tip[1] - along_y * length];
        // At right angles, towards larger y.
        let aside = 0.35 * length * along_x.signum();
        let (aside_x, aside_y) = (-along_y * aside, along_x * aside);
        let points = [tip, [back[0] - aside_x, back[1] - aside_y], [back[0] + aside_x, back[1] + aside_y]]
            .map(|[x, y]| format!("{} {}", self.mm(x), self.mm(y)));
        let _ = writeln!(self.out, "<path d=\"M{}L{}L{}z\"/>", points[0], points[1], points[2]);
    }

    /// Opens the frame at the specimen's centre and draws the outline; returns the stroke width in millimetres, as
    /// text.
    fn begin_specimen(&mut self, outline: &Outline, centre: [f64; 2]) -> String {
        let (x, y, stroke) = (self.mm(centre[0]), self.mm(centre[1]), self.mm(0.25));
        let _ = writeln!(self.out, "<g id=\"specimen\" transform=\"translate({x} {y})\">");
        let face = format!("id=\"outline\" fill=\"{FACE_COLOUR}\" stroke=\"{INK_COLOUR}\" stroke-width=\"{stroke}\"");
        let mm = |length_m: f64| decimal(length_m * 1e3, COORDINATE_DECIMALS);
        let _ = match *outline {
            Outline::Disc { diameter_m } => writeln!(self.out, "<circle {face} r=\"{}\"/>", mm(diameter_m / 2.0)),
            Outline::Ring { outer_diameter_m, inner_diameter_m } => {
                // The hole has the opposite orientation, so that it stays open.
                let circle = |diameter_m: f64, sweep: u8| {
                    let (radius, diameter) = (mm(diameter_m / 2.0), mm(diameter_m));
                    let half = |way: &str| format!("a{radius} {radius} 0 0 {sweep} {way}{diameter} 0");
                    format!("M-{radius} 0{}{}z", half(""), half("-"))
                };
                let (rim, hole) = (circle(outer_diameter_m, 0), circle(inner_diameter_m, 1));
                writeln!(self.out, "<path {face} d=\"{rim}{hole}\"/>")
            }
            Outline::Rectangle { length_m, width_m } => writeln!(
                self.out,
                "<rect {face} x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/>",
                mm(-length_m / 2.0),
                mm(-width_m / 2.0),
                mm(length_m),
                mm(width_m)
            ),
        };
        stroke
    }

    /// Draws outline and cavities in a frame at the specimen's centre.
    fn specimen(&mut self, layout: &Layout, centre: [f64; 2], to: &mut dyn io::Write) -> io::Result<()> {
        let stroke = self.begin_specimen(layout.outline(), centre);
        let _ = write!(self.out, "<path id=\"cavities\" fill=\"{CAVITY_COLOUR}\" d=\"");
        for cavity in layout.iter() {
            for boundary in cavity.boundaries() {
                self.outline_of(Some(&cavity), &boundary);
                self.out.push('z');
            }
            flush_full(&mut self.out, to)?;
        }
        self.out.push_str("\"/>\n");
        self.end_specimen(&stroke);
        Ok(())
    }

    /// Draws the origin and closes the specimen's frame.
    fn end_specimen(&mut self, stroke: &str) {
        let arm = self.mm(1.0);
        let _ = writeln!(
            self.out,
            "<path id=\"origin\" fill=\"none\" stroke=\"{INK_COLOUR}\" stroke-width=\"{stroke}\" \
             d=\"M-{arm} 0L{arm} 0M0 -{arm}L0 {arm}\"/>\n</g>"
        );
    }

    /// Appends the path commands for the outline of a cavity without the closing `z`; y points down.
    fn outline_of(&mut self, cavity: Option<&Cavity>, boundary: &Boundary) {
        let mut commands = |steps: &[(&str, f64)]| {
            for &(command, length_m) in steps {
                self.out.push_str(command);
                push_decimal(&mut self.out, length_m * 1e3, COORDINATE_DECIMALS);
            }
        };
        match (boundary, cavity.filter(|cavity| cavity.is_rectangle() && cavity.is_aligned())) {
            (Boundary::Polygon { .. }, Some(cavity)) => commands(&[
                // From the upper left corner.
                ("M", cavity.centre_x_m - cavity.width_m / 2.0),
                (" ", -cavity.centre_y_m - cavity.length_m / 2.0),
                ("h", cavity.width_m),
                ("v", cavity.length_m),
                ("h", -cavity.width_m),
            ]),
            (Boundary::Polygon { corners_m }, None) => {
                for (corner, [x_m, y_m]) in corners_m.iter().enumerate() {
                    commands(&[(if corner == 0 { "M" } else { "L" }, *x_m), (" ", -y_m)]);
                }
            }
            // Two half circles, from the leftmost point and back.
            (&Boundary::Circle { centre_m: [x_m, y_m], radius_m }, _) => {
                commands(&[("M", x_m - radius_m), (" ", -y_m)]);
                for across_m in [2.0 * radius_m, -2.0 * radius_m] {
                    commands(&[("a", radius_m), (" ", radius_m), (" 0 0 0 ", across_m), (" ", 0.0)]);
                }
            }
        }
    }

    fn sliding_direction(&mut self, texture: &Texture, [left, y]: [f64; 2]) {
        self.out.push_str("<g id=\"sliding-direction\">\n");
        let label_left = if texture.sliding_angle_deg() == 0.0 {
            self.line([left, y], [left + 12.0, y]);
            self.arrowhead([left + 13.0, y], [1.0, 0.0], 2.4);
            left + 15.0
        } else {
            // Turned about its middle, short enough to stay clear of the content above and below.
            let [cosine, sine] = texture.sliding_direction_on_specimen();
            let at = |along: f64| [left + 5.0 + along * cosine, y - along * sine];
            self.line(at(-5.0), at(4.0));
            self.arrowhead(at(5.0), [cosine, -sine], 2.4);
            left + 12.0
        };
        // The arrow shows the orientation of the angle.
        let label = match texture.sliding_angle_deg() {
            0.0 => "sliding direction x".to_owned(),
            angle_deg => format!("sliding direction, {}° from x", degrees(angle_deg)),
        };
        self.text([label_left, y + 0.35 * TEXT_SIZE], "start", TEXT_SIZE, "", &label);
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

    fn rectangle(&mut self, [x, y]: [f64; 2], [width, height]: [f64; 2], style: &str) {
        let (x, y, width, height) = (self.mm(x), self.mm(y), self.mm(width), self.mm(height));
        let _ = writeln!(self.out, "<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" {style}/>");
    }
}

#[cfg(test)]
mod tests;
