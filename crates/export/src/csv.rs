//! CSV of the cavities.

use std::fmt::Write as _;

use crate::Layout;
use crate::number::{COORDINATE_DECIMALS, MICROMETRE_DECIMALS, decimal, push_decimal};

/// The first line of the file.
pub const CSV_HEADER: &str = "index,centre_x_mm,centre_y_mm,width_mm,length_mm,depth_um,bursts";

/// One line per cavity in the layout's order, counted from 1: width along the sliding direction x,
/// length across it, millimetres from the specimen's centre rounded to one nanometre. `bursts` per
/// cavity; the field is empty where it is unknown.
#[must_use]
pub fn csv(layout: &Layout, bursts: Option<u32>) -> String {
    let depth_and_bursts = format!(
        ",{},{}\n",
        decimal(layout.pattern().depth_m() * 1e6, MICROMETRE_DECIMALS),
        bursts.map_or_else(String::new, |bursts| bursts.to_string())
    );
    let mut out = String::with_capacity(64 * (layout.cavities() + 1));
    out.push_str(CSV_HEADER);
    out.push('\n');
    for (index, cavity) in layout.iter().enumerate() {
        let _ = write!(out, "{}", index + 1);
        for length_m in [cavity.centre_x_m, cavity.centre_y_m, cavity.width_m, cavity.length_m] {
            out.push(',');
            push_decimal(&mut out, length_m * 1e3, COORDINATE_DECIMALS);
        }
        out.push_str(&depth_and_bursts);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Outline;
    use slipgrid_pattern::{Pattern, Planform};

    #[test]
    fn reads_back_to_the_same_cavities_within_a_nanometre() {
        for planform in Planform::ALL {
            let pattern = Pattern::new(planform, 131.2347e-6, 369.9999e-6, 5.2e-6).unwrap();
            let layout = Layout::new(pattern, Outline::Disc { diameter_m: 10e-3 }).unwrap();
            let text = csv(&layout, Some(2));
            let mut lines = text.lines();
            assert_eq!(lines.next(), Some(CSV_HEADER));
            let mut read = 0;
            for (index, (line, cavity)) in lines.by_ref().zip(layout.iter()).enumerate() {
                let values: Vec<f64> = line.split(',').map(|field| field.parse().unwrap()).collect();
                let expected = [
                    (index + 1) as f64,
                    cavity.centre_x_m * 1e3,
                    cavity.centre_y_m * 1e3,
                    cavity.width_m * 1e3,
                    cavity.length_m * 1e3,
                    5.2,
                    2.0,
                ];
                assert_eq!(values.len(), expected.len());
                for (value, expected) in values.iter().zip(expected) {
                    assert!((value - expected).abs() <= 0.5001e-6, "{line}");
                }
                read += 1;
            }
            assert_eq!(read, layout.cavities());
            assert_eq!(lines.next(), None);
        }
    }

    #[test]
    fn unknown_bursts_are_an_empty_field() {
        let pattern = Pattern::new(Planform::Square, 130e-6, 370e-6, 20e-6).unwrap();
        let layout = Layout::new(pattern, Outline::Rectangle { length_m: 0.2e-3, width_m: 0.2e-3 }).unwrap();
        assert_eq!(csv(&layout, None), format!("{CSV_HEADER}\n1,0,0,0.13,0.13,20,\n"));
    }
}
