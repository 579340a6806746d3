//! G-code for controllers with a laser mode: G1 marks, G0 jumps with the laser off.
//!
//! Words follow NIST RS274/NGC version 3; `M4 S` is power that follows speed, as in the laser mode of Grbl 1.1.
//! Coordinates are absolute, in millimetres from the specimen's centre.

use std::io::{self, Write};

use crate::export::number::COORDINATE_DECIMALS;
use crate::export::{
    ExportError, Heading, Laser, Layout, Marking, ascii, decimal, flush_full, flush_rest, push_decimal,
    sliding_direction,
};

/// Value of `S` for full power in Grbl's default configuration.
const FULL_POWER: u32 = 1000;

/// Settings of a G-code program: lines, speed and number of passes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GcodePlan {
    marking: Marking,
    speed_mm_s: f64,
    passes: u32,
}

impl GcodePlan {
    /// Creates the settings for `laser`: all lines of a cavity are marked `passes` times before the next cavity.
    ///
    /// # Errors
    /// [`ExportError::Refused`] without a speed; errors of [`Marking::of_lines`].
    pub fn new(laser: &Laser, passes: u32) -> Result<Self, ExportError> {
        let marking = Marking::of_lines(laser, "G-code")?;
        let missing = || ExportError::Refused("G-code needs laser.speed_mm_s".to_owned());
        Ok(Self { marking, speed_mm_s: laser.speed_mm_s.ok_or_else(missing)?, passes: passes.max(1) })
    }
}

/// Writes the G-code program that marks the cavities of `layout`.
///
/// # Errors
/// Errors of the writer `to`.
pub fn gcode(layout: &Layout, plan: &GcodePlan, heading: &Heading, to: &mut dyn Write) -> io::Result<()> {
    let mut out = String::new();
    comment(&mut out, &format!("slipgrid {}: {}", heading.version, heading.name));
    comment(&mut out, "Millimetres, origin at the centre of the specimen; G0 jumps with the laser off, G1 marks");
    let sliding = sliding_direction(layout.pattern().texture());
    comment(&mut out, &format!("Sliding direction: {sliding}. Passes: {}. S{FULL_POWER} is full power", plan.passes));
    for note in heading.notes {
        comment(&mut out, note);
    }
    // F in mm/min
    let feed = decimal(plan.speed_mm_s * 60.0, 3);
    out.push_str(&format!("G21\nG90\nG17\nM5\nM4 S{FULL_POWER}\nG1 F{feed}\n"));
    let hatch = plan.marking.on(layout);
    for cavity in layout.iter() {
        let lines = hatch.lines(&cavity);
        for _ in 0..plan.passes {
            let mut at = None;
            for &[from, end] in &lines {
                if at != Some(from) {
                    word(&mut out, "G0", from);
                }
                word(&mut out, "G1", end);
                at = Some(end);
            }
            flush_full(&mut out, to)?;
        }
    }
    out.push_str("M5\nG0 X0 Y0\nM2\n");
    flush_rest(&mut out, to)
}

/// Appends a comment in parentheses, in printable ASCII; inner parentheses become brackets.
fn comment(out: &mut String, text: &str) {
    out.push_str(&format!("({})\n", ascii(text).replace('(', "[").replace(')', "]")));
}

fn word(out: &mut String, command: &str, [x_m, y_m]: [f64; 2]) {
    out.push_str(command);
    for (axis, at_m) in [(" X", x_m), (" Y", y_m)] {
        out.push_str(axis);
        push_decimal(out, at_m * 1e3, COORDINATE_DECIMALS);
    }
    out.push('\n');
}

/// Reads the marked lines of a program, with their passes, for tests.
#[cfg(test)]
pub(crate) fn read(text: &str) -> Vec<crate::export::Line> {
    let mut at = [f64::NAN; 2];
    let mut lines = Vec::new();
    for words in text.lines().filter(|line| line.contains('X')) {
        let mut parts = words.split(' ');
        let command = parts.next().unwrap();
        let to = [parts.next().unwrap(), parts.next().unwrap()].map(|word| word[1..].parse::<f64>().unwrap() * 1e-3);
        if command == "G1" {
            lines.push([at, to]);
        }
        at = to;
    }
    lines
}
