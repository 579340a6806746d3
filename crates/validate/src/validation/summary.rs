//! Averages of a validation over its conditions.

use serde::Serialize;
use slipgrid_base::statistics::mean_and_std;

use super::ratios::{ModelledRatio, RatioReport};

/// Averages over all compared conditions.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Number of conditions.
    pub conditions: usize,
    /// Mean measured reduction, 1 - ratio.
    pub reduction_measured: f64,
    /// Standard deviation of `reduction_measured` between conditions; null for a single condition.
    pub reduction_measured_std: Option<f64>,
    /// Mean modelled reductions, 1 - ratio, for each slope factor.
    pub modelled: Vec<ModelledReduction>,
    /// Modelled over measured mean reduction, as grooves and for the surface as given; null if the pattern did not
    /// reduce friction or a solution did not converge.
    pub explained_by_grooves: Option<f64>,
    /// Modelled over measured mean reduction, as square cavities in three dimensions; null for the reasons that hold
    /// for `explained_by_grooves`.
    pub explained_by_squares: Option<f64>,
    /// Modelled over measured mean reduction, as squares by the strip estimate; null for the reasons that hold for
    /// `explained_by_grooves`.
    pub explained_by_strip_estimate: Option<f64>,
    /// Mean change of the ratio with grooves from the modelled to the measured depth; null if both depths are equal or
    /// a solution did not converge.
    pub ratio_change_at_measured_depth: Option<f64>,
    /// Mean change of the ratio with squares from the modelled to the measured depth; null if both depths are equal or
    /// a solution did not converge.
    pub square_ratio_change_at_measured_depth: Option<f64>,
    /// Change of the ratio with grooves, from the modelled to the measured depth, that has the largest magnitude over
    /// all conditions; null if the mean change is null.
    pub largest_ratio_change_at_measured_depth: Option<f64>,
}

/// Mean modelled reductions; null where a solution did not converge.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ModelledReduction {
    /// Factor on the slopes of the surface.
    pub slope_factor: f64,
    /// Mean of 1 - ratio, as grooves.
    pub groove: Option<f64>,
    /// Standard deviation of `groove`: mean of the standard deviations of the ratios, whose errors are fully
    /// correlated.
    pub groove_std: Option<f64>,
    /// Mean of 1 - ratio, as square cavities in three dimensions.
    pub square: Option<f64>,
    /// Standard deviation of `square`.
    pub square_std: Option<f64>,
    /// Mean of 1 - ratio, as squares by the strip estimate.
    pub square_estimate: Option<f64>,
}

impl Summary {
    /// Averages over `rows`, which must not be empty, for each of `slope_factors`.
    pub fn new(rows: &[RatioReport], slope_factors: &[f64]) -> Self {
        let measured = rows.iter().map(|row| 1.0 - row.measured.ratio);
        let (reduction_measured, reduction_measured_std) = mean_and_std(measured).unwrap_or((f64::NAN, None));
        let mean = |all: Vec<f64>| all.iter().sum::<f64>() / all.len() as f64;
        let modelled: Vec<ModelledReduction> = slope_factors
            .iter()
            .map(|&slope_factor| {
                let average = |value: fn(&ModelledRatio) -> Option<f64>| {
                    let all: Option<Vec<f64>> = rows.iter().map(|row| value(row.at_slope(slope_factor)?)).collect();
                    all.map(mean)
                };
                ModelledReduction {
                    slope_factor,
                    groove: average(|modelled| Some(1.0 - modelled.ratio_groove?)),
                    groove_std: average(|modelled| modelled.ratio_groove_std),
                    square: average(|modelled| Some(1.0 - modelled.ratio_square?)),
                    square_std: average(|modelled| modelled.ratio_square_std),
                    square_estimate: average(|modelled| Some(1.0 - modelled.ratio_square_estimate?)),
                }
            })
            .collect();
        let given = modelled.iter().find(|modelled| modelled.slope_factor == 1.0);
        let explained =
            |reduction: Option<f64>| Some(reduction? / reduction_measured).filter(|_| reduction_measured > 0.0);
        let changes_of = |ratio: fn(&ModelledRatio) -> Option<f64>| -> Option<Vec<f64>> {
            let change =
                |row: &RatioReport| Some(ratio(row.modelled_at_measured_depth.as_ref()?)? - ratio(row.at_slope(1.0)?)?);
            rows.iter().map(change).collect()
        };
        let changes = changes_of(|modelled| modelled.ratio_groove);
        Self {
            conditions: rows.len(),
            reduction_measured,
            reduction_measured_std,
            explained_by_grooves: given.and_then(|given| explained(given.groove)),
            explained_by_squares: given.and_then(|given| explained(given.square)),
            explained_by_strip_estimate: given.and_then(|given| explained(given.square_estimate)),
            square_ratio_change_at_measured_depth: changes_of(|modelled| modelled.ratio_square).map(mean),
            ratio_change_at_measured_depth: changes.clone().map(mean),
            largest_ratio_change_at_measured_depth: changes
                .and_then(|changes| changes.into_iter().max_by(|a, b| a.abs().total_cmp(&b.abs()))),
            modelled,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::report_for_tests::row;
    use super::*;

    #[test]
    fn averages_known_exactly() {
        let rows = [row(0.75, Some(1.0), 0.9375), row(0.875, Some(0.75), 0.875)];
        let summary = Summary::new(&rows, &[0.5, 1.0]);
        assert_eq!(summary.reduction_measured, 0.1875);
        assert!((summary.reduction_measured_std.unwrap() - 0.125 / 2.0_f64.sqrt()).abs() < 1e-15);
        assert_eq!((summary.modelled[0].groove, summary.modelled[1].groove), (None, Some(0.125)));
        assert_eq!(summary.explained_by_grooves, Some(0.125 / 0.1875));
        assert_eq!(summary.explained_by_squares, Some(0.125 * 0.125 / 0.1875));
        assert_eq!(summary.explained_by_strip_estimate, Some(0.25 * 0.125 / 0.1875));
        assert_eq!(summary.square_ratio_change_at_measured_depth, Some(0.125 * 0.03125));
        assert_eq!(summary.ratio_change_at_measured_depth, Some(0.03125));
        assert_eq!(summary.largest_ratio_change_at_measured_depth, Some(0.125));
    }

    #[test]
    fn nothing_is_explained_where_nothing_was_reduced_or_solved() {
        let summary = Summary::new(&[row(1.0, Some(0.9), 0.9)], &[1.0]);
        assert_eq!((summary.explained_by_grooves, summary.reduction_measured_std), (None, None));
        let summary = Summary::new(&[row(0.8, Some(0.9), 0.9), row(0.8, None, 0.9)], &[1.0]);
        assert_eq!((summary.explained_by_grooves, summary.ratio_change_at_measured_depth), (None, None));
    }
}
