//! Published ratios of textured over flat friction, beside a user's trials.

use crate::charts::{self, ChartError};
use crate::trials::TrialsReport;
use slipgrid_traces::cells::{cut, unquoted};

/// Published friction of textured and flat surfaces with references, as CSV.
const TABLE: &str = include_str!("../data/dry_textured_friction.csv");
/// Kind of a comparison of textured with flat dry polymer or rubber.
const DRY_POLYMER: &str = "measured";

/// Source, reference, kind of the comparison and ratio of textured over flat friction of each row of `TABLE`; ratios
/// that are no numbers are not known.
fn published() -> impl Iterator<Item = ([String; 3], Option<f64>)> {
    let mut lines = TABLE.lines().filter(|line| !line.starts_with('#')).map(|line| cut(line, ','));
    let header = lines.next().unwrap_or_default();
    lines.map(move |cells| {
        let place = |name: &str| header.iter().position(|own| *own == name);
        let cell = |name: &str| place(name).and_then(|place| cells.get(place)).map_or("", |cell| unquoted(cell));
        (["source", "reference", "kind"].map(|name| cell(name).to_owned()), cell("ratio").parse().ok())
    })
}

/// Sources with ratios of dry polymers, in the order of the table: name, reference, and ratios of textured over flat
/// friction. Lubricated and metal surfaces, and other comparisons, are left out.
pub fn sources() -> Vec<(String, String, Vec<f64>)> {
    let mut found: Vec<(String, String, Vec<f64>)> = Vec::new();
    for ([source, reference, kind], ratio) in published() {
        let Some(ratio) = ratio.filter(|_| kind == DRY_POLYMER) else { continue };
        match found.iter_mut().find(|(known, ..)| *known == source) {
            Some((.., ratios)) => ratios.push(ratio),
            None => found.push((source, reference, vec![ratio])),
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
        let all: Vec<_> = published().collect();
        assert!(all.len() >= 40 && all.iter().flat_map(|(words, _)| words).all(|words| !words.is_empty()));
        let contrasts = all.iter().filter(|([.., kind], _)| kind != DRY_POLYMER).count();
        assert!((3..10).contains(&contrasts), "{contrasts}");
        assert_eq!(all.iter().filter(|([source, ..], _)| source == "Balestra 2022").count(), 18);
        assert!(all.iter().filter_map(|(_, ratio)| *ratio).all(|ratio| (0.1..3.0).contains(&ratio)));
        assert!(all.iter().any(|([_, reference, _], _)| reference == "J. Tribol. 144(3) 031704; arXiv 2110.11838"));
        // Quoted cells hold commas.
        assert!(TABLE.lines().any(|line| cut(line, ',').len() < line.split(',').count()));
    }
}
