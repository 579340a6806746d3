//! HP-GL/2 plots (PLT), which marking software imports.
//!
//! Hewlett-Packard, "HP-GL/2 and HP RTL Reference Guide": a plotter unit is 0.025 mm, and coordinates may have
//! decimals. They do here: a reader that keeps whole plotter units alone moves edges by up to 12.5 um. Pen 1
//! draws the specimen, pen 2 the contours of the cavities, pen 3 the lines that fill them.

use std::io::{self, Write};

use crate::ascii::ascii;
use crate::number::push_decimal;
use crate::outline::rims;
use crate::stream::{finish, hand_on};
use crate::{Heading, Layout, Marking};

/// Plotter units in a metre.
const UNITS_PER_M: f64 = 40_000.0;
/// A quarter of a nanometre.
const DECIMALS: usize = 5;

/// Writes the layout as a plot whose origin is the specimen's centre, with the lines of `marking` where it is
/// given.
///
/// # Errors
/// Those of `to`.
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
        hand_on(&mut out, to)?;
    }
    if let Some(marking) = marking {
        out.push_str("SP3;\n");
        for cavity in layout.iter() {
            for line in marking.lines(&cavity) {
                path(&mut out, &line, false);
            }
            hand_on(&mut out, to)?;
        }
    }
    out.push_str("PU;SP0;\n");
    finish(&mut out, to)
}

/// A comment: printable ASCII without its own delimiter.
fn comment(out: &mut String, text: &str) {
    out.push_str("CO \"");
    out.push_str(&ascii(text).replace('"', "'"));
    out.push_str("\";\n");
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
