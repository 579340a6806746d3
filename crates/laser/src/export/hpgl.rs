//! HP-GL/2 plots (PLT), which marking software imports.
//!
//! Format: Hewlett-Packard, "HP-GL/2 and HP RTL Reference Guide". A plotter unit is 0.025 mm, and coordinates may have
//! decimals. This writer uses decimals; a reader that keeps only integers moves edges by up to 12.5 um. Pen 1 draws the
//! specimen, pen 2 the contours of the cavities, pen 3 the lines that fill them.

use std::io::{self, Write};

use crate::export::clip::rims;
use crate::export::{Heading, Layout, Marking, ascii, flush_full, flush_rest, push_decimal};

/// Plotter units per metre.
const UNITS_PER_M: f64 = 40_000.0;
/// Decimals of a plotter unit: a quarter of a nanometre.
const DECIMALS: usize = 5;

/// Writes the layout as a plot whose origin is the specimen's centre, with the lines of `marking` if given.
///
/// # Errors
/// Errors of the writer `to`.
pub fn hpgl(layout: &Layout, marking: Option<&Marking>, heading: &Heading, to: &mut dyn Write) -> io::Result<()> {
    let mut out = String::new();
    comment(&mut out, &format!("slipgrid {}: {}", heading.version, heading.name));
    comment(&mut out, "Plotter units of 0.025 mm with decimals. Origin: centre of the specimen.");
    comment(&mut out, "Pen 1: specimen, not to be marked. Pen 2: cavities. Pen 3: lines of the spot's centre.");
    for note in heading.notes {
        comment(&mut out, note);
    }
    out.push_str("IN;PA;SP1;\n");
    for rim in rims(layout.outline()) {
        path(&mut out, &rim, true);
    }
    out.push_str("SP2;\n");
    for cavity in layout.iter() {
        for boundary in cavity.boundaries() {
            path(&mut out, &boundary.polygon_m(), true);
        }
        flush_full(&mut out, to)?;
    }
    if let Some(hatch) = marking.map(|marking| marking.on(layout)) {
        out.push_str("SP3;\n");
        for cavity in layout.iter() {
            for line in hatch.lines(&cavity) {
                path(&mut out, &line, false);
            }
            flush_full(&mut out, to)?;
        }
    }
    out.push_str("PU;SP0;\n");
    flush_rest(&mut out, to)
}

/// Writes a comment: printable ASCII without quotation marks.
fn comment(out: &mut String, text: &str) {
    out.push_str(&format!("CO \"{}\";\n", ascii(text).replace('"', "'")));
}

fn path(out: &mut String, points_m: &[[f64; 2]], closed: bool) {
    for (place, [x_m, y_m]) in points_m.iter().chain(points_m.first().filter(|_| closed)).enumerate() {
        out.push_str(match place {
            0 => "PU",
            1 => ";PD",
            _ => ",",
        });
        push_decimal(out, x_m * UNITS_PER_M, DECIMALS);
        out.push(',');
        push_decimal(out, y_m * UNITS_PER_M, DECIMALS);
    }
    out.push_str(";\n");
}
