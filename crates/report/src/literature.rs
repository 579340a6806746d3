//! Published ratios of textured over flat friction, beside a user's trials.

use crate::charts::{self, ChartError};
use crate::trials::TrialsReport;

/// Published friction of textured and flat surfaces with references, as CSV.
const TABLE: &str = include_str!("../data/dry_textured_friction.csv");

/// Published comparison of a textured with a flat surface.
#[derive(Clone, Debug, PartialEq)]
struct Published {
    source: String,
    reference: String,
    /// Ratio of friction, textured over flat, if it is a number.
    ratio: Option<f64>,
    /// Compares textured with flat dry polymer or rubber; false for lubricated or metal surfaces and for other
    /// comparisons.
    is_dry_polymer: bool,
}

/// Parses all rows of `TABLE`.
fn published() -> Vec<Published> {
    let mut lines = TABLE.lines().filter(|line| !line.starts_with('#'));
    let header = cells(lines.next().unwrap_or_default());
    let row = |line: &str| {
        let cells = cells(line);
        let cell = |name: &str| {
            let place = header.iter().position(|own| own == name);
            place.and_then(|place| cells.get(place)).cloned().unwrap_or_default()
        };
        Published {
            source: cell("source"),
            reference: cell("reference"),
            ratio: cell("ratio").parse().ok(),
            is_dry_polymer: cell("kind") == "measured",
        }
    };
    lines.map(row).collect()
}

/// Cells of a line of comma-separated values; commas within quotes do not separate.
fn cells(line: &str) -> Vec<String> {
    let mut cells = vec![String::new()];
    let mut is_quoted = false;
    for letter in line.chars() {
        match letter {
            '"' => is_quoted = !is_quoted,
            ',' if !is_quoted => cells.push(String::new()),
            _ => {
                if let Some(cell) = cells.last_mut() {
                    cell.push(letter);
                }
            }
        }
    }
    cells
}

/// Sources with ratios of dry polymers, in the order of the table: name, reference, and ratios of textured over flat
/// friction.
pub fn sources() -> Vec<(String, String, Vec<f64>)> {
    let mut found: Vec<(String, String, Vec<f64>)> = Vec::new();
    for of in published().into_iter().filter(|of| of.is_dry_polymer) {
        let Some(ratio) = of.ratio else { continue };
        match found.iter_mut().find(|(source, ..)| *source == of.source) {
            Some((.., ratios)) => ratios.push(ratio),
            None => found.push((of.source, of.reference, vec![ratio])),
        }
    }
    found
}

/// Draws the measured ratios of `report` beside published ones.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw or a value is not finite.
pub fn picture(report: &TrialsReport) -> Result<String, ChartError> {
    let sources = sources();
    let published: Vec<&[f64]> = sources.iter().map(|(.., ratios)| &ratios[..]).collect();
    let own = report.trials.iter().flat_map(|trial| &trial.measured).map(|at| at.measured);
    let title = "Dry polymers and rubbers: friction of textured over flat";
    charts::literature(title, &own.collect::<Vec<f64>>(), &published)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_has_a_source_a_reference_and_a_kind_and_numbers_are_those_of_coefficients() {
        let all = published();
        assert!(all.len() >= 40 && all.iter().all(|of| !of.source.is_empty() && !of.reference.is_empty()));
        let contrasts = all.iter().filter(|of| !of.is_dry_polymer).count();
        assert!((3..10).contains(&contrasts), "{contrasts}");
        assert_eq!(all.iter().filter(|of| of.source == "Balestra 2022").count(), 18);
        assert!(all.iter().filter_map(|of| of.ratio).all(|ratio| (0.1..3.0).contains(&ratio)));
        assert_eq!(cells("a,\"b, c\",,d"), ["a", "b, c", "", "d"]);
    }
}
