//! Headers of maps in text formats.

use super::super::{GIVEN, plainly};
use super::*;
use crate::topography::{MapFormat, ReadOptions, read_map};

fn header(lines: &[&str]) -> Result<Header, ReadError> {
    let mut header = Header::default();
    for (n, text) in lines.iter().enumerate() {
        assert!(header.take(text, n + 1)?, "{text} is a header line");
    }
    Ok(header)
}

#[test]
fn column_titles_carry_units() {
    for titles in [
        &["x_um,y_um,z_nm"][..],
        &["X [um]\tY [um]\tZ [nm]"],
        &["x (\u{b5}m); y (\u{b5}m); z (nm)"],
        &["X(um)\tY(um)\tZ(nm)"],
        &["\"X (um)\",\"Y (um)\",\"Height (nm)\""],
        &["X,Y,Z", "um,um,nm"],
        &["x y z", "[um] [um] [nm]"],
    ] {
        let read = header(titles).unwrap();
        assert_eq!(read.lateral, Some(LengthUnit::Micrometre.into()), "{titles:?}");
        assert_eq!(read.value(), Some(LengthUnit::Nanometre.into()), "{titles:?}");
    }
    let read = header(&["x y z"]).unwrap();
    assert_eq!((read.lateral, read.value()), (None, None));
    assert!(!Header::default().take("1 2 3", 1).unwrap());
    assert!(!Header::default().take("xerox yes zero", 1).unwrap());
    // A line of units counts only below titles.
    assert!(!Header::default().take("um,um,nm", 1).unwrap());
}

#[test]
fn header_entries_that_mean_nothing_are_refused_with_line_and_value() {
    for (text, needle) in [
        ("# Width: wide", "wide"),
        ("# Width: -1 mm", "-1 mm"),
        ("# Height: 3", "\"3\""),
        ("# Value units: counts", "one of m"),
        ("x_um,y_mm,z_um", "um and mm"),
        ("# x-pixels = -4", "\"-4\""),
        ("# y-length = 0", "above 0"),
        ("# voidpixels = 12", "NaN"),
    ] {
        let message = header(&["# File Format = ASCII", text]).unwrap_err().to_string();
        assert!(message.starts_with("line 2: ") && message.contains(needle), "{message}");
    }
}

#[test]
fn a_word_that_two_lines_state_with_other_values_is_refused_with_both_lines() {
    let read = |lines: &str| read_map(format!("{lines}\n1 2\n3 4\n").as_bytes(), &ReadOptions::default());
    let sides = "# Width: 2 um\n# Height: 2 um";
    for (text, needle) in [
        (format!("{sides}\n# Value units: um\n# Width: 4 um"), "line 4: Width is \"4 um\", and was \"2 um\" on line 1"),
        (
            format!("# Value units: um\n{sides}\n# value units: nm"),
            "line 4: value units is \"nm\", and was \"um\" on line 1",
        ),
        (format!("{sides}\n# Height [nm]: 2"), "line 3: Height is \"2 nm\", and was \"2 um\" on line 2"),
    ] {
        let said = read(&text).unwrap_err().to_string();
        assert!(said.starts_with(needle) && said.ends_with("expected one value"), "{said}");
    }
    assert!(read(&format!("{sides}\n# Value units: um\n# Width: 2 um")).is_ok());
    // What was not understood states nothing.
    assert!(read("Width: 640\n# Width: 2 um\n# Height: 2 um\n# Value units: um").is_ok());
    let counted = "# Rows: each a scan\n# Rows: 2\n# Width: 2 um\n# Height: 2 um\n# Value units: um";
    assert!(read(counted).is_ok());
    // Comments without a meaning may be repeated.
    assert!(read(&format!("{sides}\n# Value units: um\n# Comment: a\n# Comment: b")).is_ok());
}

#[test]
fn titles_in_another_order_than_x_y_z_are_refused_with_the_order() {
    for titles in ["Z [nm],X [um],Y [um]", "y x z", "x,height,y"] {
        let said = plainly::refused(format!("{titles}\n1,2,3\n"));
        assert_eq!(
            said,
            format!("line 1: order of the columns is \"{titles}\": expected x, y and z from left to right")
        );
    }
}

#[test]
fn what_an_instrument_writes_above_the_titles_is_passed_over_and_nothing_else_is() {
    let refused = |text: &str| read_map(text.as_bytes(), &GIVEN).unwrap_err().to_string();
    let points = "0,0,1\n1,0,2\n0,1,3\n1,1,4\n";
    let text = format!("Measurement 17\nOperator,Anna\n\nX,Y,Z\num,um,nm\n{points}");
    let read = plainly::read(text);
    assert_eq!((read.format, read.map.dx_m()), (MapFormat::Xyz, 1e-6));
    assert_eq!(read.map.heights_m(), [1e-9, 3e-9, 2e-9, 4e-9]);
    // Lines that name a value are read like comments.
    let named = "Instrument: Profiler 9\nOperator: AN\nWidth: 2 um\nHeight: 2 um\nValue units: nm\n1;2\n3;4\n";
    let named = plainly::read(named);
    assert_eq!((named.map.dx_m(), named.map.heights_m()), (1e-6, &[1e-9, 3e-9, 2e-9, 4e-9][..]));
    assert_eq!(named.comments[0], "Instrument: Profiler 9");
    // Sizes of the instrument itself neither refuse the points below titles nor turn them into a matrix.
    for words in ["Height: 480\nWidth: 640", "Width: 10 mm\nHeight: 10 mm", "Value units: counts"] {
        let read = plainly::read(format!("{words}\nX [um],Y [um],Z [nm]\n{points}"));
        assert_eq!((read.format, read.map.heights_m()), (MapFormat::Xyz, &[1e-9, 3e-9, 2e-9, 4e-9][..]), "{words}");
        assert_eq!(read.comments[0], words.lines().next().unwrap());
    }
    assert!(refused(&format!("Measurement,17\n{points}")).contains("lines above the data begin with #"));
    for text in [format!("Measurement,17\n{points}"), format!("a,b,c\n{points}"), "friction\n".to_owned()] {
        assert!(refused(&text).starts_with("line 1, column "), "{text}: {}", refused(&text));
    }
    assert!(refused(&format!("X,Y,Z\nabout,these,points\n{points}")).starts_with("line 2"));
}
