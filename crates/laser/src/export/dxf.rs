//! AutoCAD R12 (AC1009) drawings in ASCII, the dialect that all laser controllers read.
//!
//! Format: Autodesk, "Drawing Interchange and File Formats", Release 12. A group code in a field of three characters
//! and a value stand on alternate lines; sections are HEADER, TABLES, BLOCKS and ENTITIES. R12 has no variable for
//! units, which are therefore stated in comments (group 999).

mod of_sectors;

use std::fmt::Write as _;
use std::io::{self, Write};

use slipgrid_model::pattern::{Arrangement, Pattern};

use crate::export::number::COORDINATE_DECIMALS;
use crate::export::{
    Boundary, Heading, Layout, Outline, ascii, flush_full, flush_rest, groove_direction, push_decimal,
    sliding_direction,
};

pub use of_sectors::{LAYER_MARK, dxf_of_sectors, sector_layer};

/// Layer of the specimen's outline.
pub const LAYER_OUTLINE: &str = "OUTLINE";
/// Layer of the cavities, the only layer that the laser marks.
pub const LAYER_CAVITIES: &str = "CAVITIES";
/// Layer of the arrow that shows the sliding direction, outside the specimen.
pub const LAYER_SLIDING_DIRECTION: &str = "SLIDING_DIRECTION";

/// Layer of a small cross at the origin, the specimen's centre.
pub const LAYER_ORIGIN: &str = "ORIGIN";

/// Layers with their AutoCAD colour numbers.
const LAYERS: [(&str, &str); 4] =
    [(LAYER_OUTLINE, "7"), (LAYER_CAVITIES, "1"), (LAYER_SLIDING_DIRECTION, "5"), (LAYER_ORIGIN, "3")];

/// Maximum length of a comment, in characters: R12 lines hold 255, and some readers fewer.
const MAX_COMMENT_LENGTH: usize = 200;

/// Writes the layout as an R12 drawing in millimetres, rounded to one nanometre. The origin is the specimen's centre,
/// and x the sliding direction unless the texture has a sliding angle. Cavities are circles or closed polylines.
///
/// # Errors
/// Errors of the writer `to`.
pub fn dxf(layout: &Layout, heading: &Heading, to: &mut dyn Write) -> io::Result<()> {
    let mut file = Writer { out: String::new() };
    let pattern = layout.pattern();
    let (half_x_mm, half_y_mm) = half_extents_mm(layout.outline());
    let arrow = Arrow::below(half_x_mm, half_y_mm, pattern.texture().sliding_direction_on_specimen());

    file.comment(&format!("slipgrid {}: {}", heading.version, heading.name));
    file.comment(&match pattern.texture().sliding_angle_deg() {
        0.0 => "Units: millimetres. Origin: centre of the specimen. x: sliding direction.".to_owned(),
        _ => format!(
            "Units: millimetres. Origin: centre of the specimen. Sliding direction: {}.",
            sliding_direction(pattern.texture())
        ),
    });
    file.comment(&format!("Pattern: {}, {} cavities", pattern_words(pattern), layout.cavities()));
    if let Some(outline) = pattern.texture().outline() {
        file.comment(&format!("Outline of a cavity: polygon of {} corners", outline.vertices().len()));
    }
    if pattern.texture().crossing_angle_deg().is_some() {
        file.comment("Grooves of the second family end at the walls of the first: nothing is marked twice.");
    }
    if layout.specimen().is_clipped {
        file.comment("Cavities that pass the rim are cut there.");
    }
    for note in heading.notes {
        file.comment(note);
    }

    file.head([half_x_mm, half_y_mm], &arrow, &LAYERS);
    file.face(layout.outline());
    for boundary in layout.iter().flat_map(|cavity| cavity.boundaries()) {
        file.boundary(LAYER_CAVITIES, boundary);
        flush_full(&mut file.out, to)?;
    }
    file.end(&arrow);
    flush_rest(&mut file.out, to)
}

fn half_extents_mm(outline: &Outline) -> (f64, f64) {
    let [extent_x_m, extent_y_m] = outline.extents_m();
    (extent_x_m * 500.0, extent_y_m * 500.0)
}

/// Describes the planform, properties of the texture that are not the default, and the lengths of the pattern.
fn pattern_words(pattern: &Pattern) -> String {
    let texture = pattern.texture();
    let mut words = pattern.planform().to_string();
    if texture.groove_angle_deg() != 0.0 || texture.crossing_angle_deg().is_some() {
        words += &format!(", {}", groove_direction(texture));
    }
    if texture.arrangement() != Arrangement::Square {
        words += &format!(", {}", texture.arrangement().name());
    }
    for (name, length_m) in [
        ("length", texture.length_m().and(pattern.length_m())),
        ("spacing across", texture.spacing_across_m().and(pattern.spacing_across_m())),
    ] {
        if let Some(length_m) = length_m {
            words += &format!(", {name} {:.3} um", length_m * 1e6);
        }
    }
    let [width_um, spacing_um, depth_um] =
        [pattern.width_m(), pattern.spacing_m(), pattern.depth_m()].map(|length_m| length_m * 1e6);
    format!("{words}, width {width_um:.3} um, spacing {spacing_um:.3} um, depth {depth_um:.3} um")
}

/// Arrow along the sliding direction below the specimen, in millimetres.
struct Arrow {
    half_length_mm: f64,
    height_mm: f64,
    direction: [f64; 2],
}

impl Arrow {
    fn below(half_x_mm: f64, half_y_mm: f64, direction: [f64; 2]) -> Self {
        let half_length_mm = half_x_mm / 4.0;
        // A turned arrow reaches up, so that it is placed lower by this amount.
        let up_mm = half_length_mm * direction[1].abs();
        Self { half_length_mm, height_mm: -half_y_mm - half_length_mm / 2.0 - up_mm, direction }
    }

    /// Half the width of the arrow head, in millimetres.
    fn barb_mm(&self) -> f64 {
        self.half_length_mm / 5.0
    }

    fn lowest_mm(&self) -> f64 {
        self.height_mm - self.half_length_mm * self.direction[1].abs() - self.barb_mm()
    }

    /// Shaft and the two lines of the arrow head, each as start and end `[x, y]`, in millimetres.
    fn lines_mm(&self) -> [[[f64; 2]; 2]; 3] {
        let [cosine, sine] = self.direction;
        let at = |along: f64, across: f64| {
            [along * cosine - across * sine, self.height_mm + (along * sine + across * cosine)]
        };
        let (half, barb) = (self.half_length_mm, self.barb_mm());
        let tip = at(half, 0.0);
        [[at(-half, 0.0), tip], [at(half - 2.0 * barb, barb), tip], [at(half - 2.0 * barb, -barb), tip]]
    }
}

/// Collects the group codes and values of a drawing.
struct Writer {
    out: String,
}

impl Writer {
    /// Writes header, tables and blocks of a drawing with an arrow, and begins its entities.
    fn head(&mut self, [half_x_mm, half_y_mm]: [f64; 2], arrow: &Arrow, layers: &[(&str, &str)]) {
        self.section("HEADER");
        self.variable("$ACADVER", 1, "AC1009");
        self.variable_point("$INSBASE", &[0.0, 0.0, 0.0]);
        self.variable_point("$EXTMIN", &[-half_x_mm, arrow.lowest_mm(), 0.0]);
        self.variable_point("$EXTMAX", &[half_x_mm, half_y_mm, 0.0]);
        self.variable_point("$LIMMIN", &[-half_x_mm, arrow.lowest_mm()]);
        self.variable_point("$LIMMAX", &[half_x_mm, half_y_mm]);
        // Decimal numbers with six decimals.
        self.variable("$LUNITS", 70, "2");
        self.variable("$LUPREC", 70, "6");
        self.pair(0, "ENDSEC");

        self.section("TABLES");
        self.table("LTYPE", 1);
        for (code, value) in [(0, "LTYPE"), (2, "CONTINUOUS"), (70, "0"), (3, "Solid line"), (72, "65"), (73, "0")] {
            self.pair(code, value);
        }
        self.real(40, 0.0);
        self.pair(0, "ENDTAB");
        self.table("LAYER", layers.len() + 1);
        for (name, colour) in std::iter::once(&("0", "7")).chain(layers) {
            for (code, value) in [(0, "LAYER"), (2, *name), (70, "0"), (62, *colour), (6, "CONTINUOUS")] {
                self.pair(code, value);
            }
        }
        self.pair(0, "ENDTAB");
        self.pair(0, "ENDSEC");

        self.section("BLOCKS");
        self.pair(0, "ENDSEC");

        self.section("ENTITIES");
    }

    /// Writes the outline of the specimen and a cross at the origin, so that a moved drawing can be moved back.
    fn face(&mut self, outline: &Outline) {
        let (half_x_mm, half_y_mm) = half_extents_mm(outline);
        match *outline {
            Outline::Disc { diameter_m } => self.circle(LAYER_OUTLINE, [0.0, 0.0], diameter_m * 500.0),
            Outline::Ring { outer_diameter_m, inner_diameter_m } => {
                self.circle(LAYER_OUTLINE, [0.0, 0.0], outer_diameter_m * 500.0);
                self.circle(LAYER_OUTLINE, [0.0, 0.0], inner_diameter_m * 500.0);
            }
            Outline::Rectangle { .. } => self.polygon(
                LAYER_OUTLINE,
                &[[-half_x_mm, -half_y_mm], [half_x_mm, -half_y_mm], [half_x_mm, half_y_mm], [-half_x_mm, half_y_mm]],
            ),
        }
        let cross_mm = half_x_mm.min(half_y_mm) / 100.0;
        self.line(LAYER_ORIGIN, [-cross_mm, 0.0], [cross_mm, 0.0]);
        self.line(LAYER_ORIGIN, [0.0, -cross_mm], [0.0, cross_mm]);
    }

    /// Writes the outline of a cavity, or of a part of it.
    fn boundary(&mut self, layer: &str, boundary: Boundary) {
        let millimetres = |[x_m, y_m]: [f64; 2]| [x_m * 1e3, y_m * 1e3];
        match boundary {
            Boundary::Polygon { corners_m } => {
                self.polygon(layer, &corners_m.into_iter().map(millimetres).collect::<Vec<_>>());
            }
            Boundary::Circle { centre_m, radius_m } => self.circle(layer, millimetres(centre_m), radius_m * 1e3),
        }
    }

    /// Writes the arrow and the end of the drawing.
    fn end(&mut self, arrow: &Arrow) {
        for [from_mm, to_mm] in arrow.lines_mm() {
            self.line(LAYER_SLIDING_DIRECTION, from_mm, to_mm);
        }
        self.pair(0, "ENDSEC");
        self.pair(0, "EOF");
    }

    fn pair(&mut self, code: u16, value: &str) {
        let _ = writeln!(self.out, "{code:>3}\n{value}");
    }

    /// Writes a real number, always with a decimal point.
    fn real(&mut self, code: u16, value: f64) {
        let _ = writeln!(self.out, "{code:>3}");
        let start = self.out.len();
        push_decimal(&mut self.out, value, COORDINATE_DECIMALS);
        if !self.out[start..].contains('.') {
            self.out.push_str(".0");
        }
        self.out.push('\n');
    }

    /// Writes x, y and z, as far as given, with the group codes `code`, `code` + 10 and `code` + 20.
    fn point(&mut self, code: u16, coordinates: &[f64]) {
        for (group, &value) in (code..).step_by(10).zip(coordinates) {
            self.real(group, value);
        }
    }

    /// Writes `text` as a comment, transliterated to printable ASCII and truncated to [`MAX_COMMENT_LENGTH`].
    fn comment(&mut self, text: &str) {
        let ascii: String = ascii(text).chars().take(MAX_COMMENT_LENGTH).collect();
        self.pair(999, &ascii);
    }

    fn section(&mut self, name: &str) {
        self.pair(0, "SECTION");
        self.pair(2, name);
    }

    fn table(&mut self, name: &str, entries: usize) {
        self.pair(0, "TABLE");
        self.pair(2, name);
        self.pair(70, &entries.to_string());
    }

    fn variable(&mut self, name: &str, code: u16, value: &str) {
        self.pair(9, name);
        self.pair(code, value);
    }

    fn variable_point(&mut self, name: &str, coordinates: &[f64]) {
        self.pair(9, name);
        self.point(10, coordinates);
    }

    fn entity(&mut self, kind: &str, layer: &str) {
        self.pair(0, kind);
        self.pair(8, layer);
    }

    fn line(&mut self, layer: &str, from_mm: [f64; 2], to_mm: [f64; 2]) {
        self.entity("LINE", layer);
        self.point(10, &[from_mm[0], from_mm[1], 0.0]);
        self.point(11, &[to_mm[0], to_mm[1], 0.0]);
    }

    fn circle(&mut self, layer: &str, centre_mm: [f64; 2], radius_mm: f64) {
        self.entity("CIRCLE", layer);
        self.point(10, &[centre_mm[0], centre_mm[1], 0.0]);
        self.real(40, radius_mm);
    }

    /// Writes a closed polyline.
    fn polygon(&mut self, layer: &str, corners_mm: &[[f64; 2]]) {
        self.entity("POLYLINE", layer);
        // Vertices follow; elevation; closed.
        self.pair(66, "1");
        self.point(10, &[0.0, 0.0, 0.0]);
        self.pair(70, "1");
        for corner_mm in corners_mm {
            self.entity("VERTEX", layer);
            self.point(10, &[corner_mm[0], corner_mm[1], 0.0]);
        }
        self.entity("SEQEND", layer);
    }
}

#[cfg(test)]
mod tests;
