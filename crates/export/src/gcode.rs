//! G-code for controllers with a laser mode: G1 marks, G0 jumps with the laser off.
//!
//! NIST RS274/NGC version 3 words; `M4 S` is the power that follows speed, as Grbl 1.1's laser mode has it.
//! Millimetres, absolute, origin at the specimen's centre.

use std::io::{self, Write};

use crate::ascii::ascii;
use crate::number::{COORDINATE_DECIMALS, decimal, push_decimal};
use crate::stream::{finish, hand_on};
use crate::words::sliding_direction;
use crate::{ExportError, Heading, Laser, Layout, Marking};

/// Full power, by Grbl's default.
const FULL_POWER: u32 = 1000;

/// What a program is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GcodePlan {
    marking: Marking,
    speed_mm_s: f64,
    passes: u32,
}

impl GcodePlan {
    /// A program for `laser`: every line of a cavity `passes` times before the next cavity.
    ///
    /// # Errors
    /// [`ExportError::Needs`] without a speed; as [`Marking::of_lines`].
    pub fn new(laser: &Laser, passes: u32) -> Result<Self, ExportError> {
        let marking = Marking::of_lines(laser, "G-code")?;
        let needs = ExportError::Needs { what: "G-code", key: "laser.speed_mm_s" };
        Ok(Self { marking, speed_mm_s: laser.speed_mm_s.ok_or(needs)?, passes: passes.max(1) })
    }
}

/// Writes the program of `layout`.
///
/// # Errors
/// Those of `to`.
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
    for cavity in layout.iter() {
        let lines = plan.marking.lines(&cavity);
        for _ in 0..plan.passes {
            let mut at = None;
            for &[from, end] in &lines {
                if at != Some(from) {
                    word(&mut out, "G0", from);
                }
                word(&mut out, "G1", end);
                at = Some(end);
            }
            hand_on(&mut out, to)?;
        }
    }
    out.push_str("M5\nG0 X0 Y0\nM2\n");
    finish(&mut out, to)
}

/// Comments stand in parentheses, of printable ASCII; those within become brackets.
fn comment(out: &mut String, text: &str) {
    out.push('(');
    out.push_str(&ascii(text).replace('(', "[").replace(')', "]"));
    out.push_str(")\n");
}

fn word(out: &mut String, command: &str, [x_m, y_m]: [f64; 2]) {
    out.push_str(command);
    for (axis, at_m) in [(" X", x_m), (" Y", y_m)] {
        out.push_str(axis);
        push_decimal(out, at_m * 1e3, COORDINATE_DECIMALS);
    }
    out.push('\n');
}

/// The marked lines of a program with their passes, read back: for tests.
#[cfg(test)]
pub(crate) fn read(text: &str) -> Vec<crate::Line> {
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
