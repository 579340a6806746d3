//! Measured and modelled static friction.

use schemars::JsonSchema;
use serde::Serialize;
use slipgrid_base::units::{HUMIDITY_PCT, SPEED_MM_S, tidy};
use slipgrid_design::results::{Table, fixed};
use slipgrid_infer::calibrate::{Measurement, ModelledRow};

use super::Fitted;

/// Measured static peak with its modelled value.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct StaticPeakFit {
    /// Normal force on one specimen.
    pub force_n: f64,
    /// Nominal pressure.
    pub pressure_mpa: f64,
    /// Sliding speed.
    pub speed_mm_s: f64,
    /// Relative humidity.
    pub humidity_pct: f64,
    /// Measured static friction.
    pub measured: f64,
    /// Standard deviation of the measured static friction, including the error of the sampling interval.
    pub measured_std: f64,
    /// Static friction of the flat sample in the last transient run of the fit; null if the peak is not fitted.
    pub modelled: Option<f64>,
    /// Modelled minus measured static friction; null if the peak is not fitted.
    pub residual: Option<f64>,
}

impl Fitted {
    /// One row per measured static peak.
    pub(crate) fn static_rows(&self) -> Vec<StaticPeakFit> {
        let row = |(measured, predicted): (&Measurement, &ModelledRow)| {
            let peak = measured.static_peak?;
            Some(StaticPeakFit {
                force_n: measured.force_n,
                pressure_mpa: self.pressure_mpa(measured),
                speed_mm_s: SPEED_MM_S.from_si(measured.speed_m_s),
                humidity_pct: HUMIDITY_PCT.from_si(measured.humidity),
                measured: tidy(peak.mu),
                measured_std: tidy(peak.std),
                modelled: predicted.mu_static.map(tidy),
                residual: predicted.mu_static.map(|modelled| tidy(modelled - peak.mu)),
            })
        };
        self.measured().filter_map(row).collect()
    }
}

/// Describes the mean and the largest difference between modelled and measured static friction; `None` without a
/// measured peak.
pub fn words(rows: &[StaticPeakFit]) -> Option<String> {
    let fitted: Vec<(&StaticPeakFit, f64)> = rows.iter().filter_map(|row| Some((row, row.residual?))).collect();
    let left = match rows.len() - fitted.len() {
        0 => String::new(),
        1 => "; 1 measured peak is not fitted".to_owned(),
        left => format!("; {left} measured peaks are not fitted"),
    };
    let Some((row, largest)) = fitted.iter().copied().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())) else {
        return (!rows.is_empty()).then(|| format!("static friction: none of {} measured peaks is fitted", rows.len()));
    };
    let mean = fitted.iter().map(|(_, residual)| residual).sum::<f64>() / fitted.len() as f64;
    Some(format!(
        "static friction of the model in time minus the measured: {mean:+.4} in the mean of {}, {largest:+.4} ({:+.1} %) where the difference \
         is largest, at {} N, {} mm/s, {} %{left}",
        fitted.len(),
        100.0 * largest / row.measured,
        row.force_n,
        row.speed_mm_s,
        row.humidity_pct,
    ))
}

/// Table of the measured and modelled static peaks.
pub fn table(rows: &[StaticPeakFit]) -> Table {
    let mut table = Table::of(rows);
    table.column("F N", |row| row.force_n.to_string());
    table.column("v mm/s", |row| row.speed_mm_s.to_string());
    table.column("RH %", |row| row.humidity_pct.to_string());
    table.column("static measured", |row| fixed(Some(row.measured), 4));
    table.column("+-", |row| fixed(Some(row.measured_std), 4));
    table.column("static modelled", |row| fixed(row.modelled, 4));
    table.column("model - measured", |row| fixed(row.residual, 4));
    table.table()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_difference_is_named_with_its_sign_and_place() {
        let row = |force_n: f64, modelled: Option<f64>| StaticPeakFit {
            force_n,
            pressure_mpa: 1.0,
            speed_mm_s: 5.0,
            humidity_pct: 50.0,
            measured: 0.4,
            measured_std: 0.01,
            modelled,
            residual: modelled.map(|modelled| modelled - 0.4),
        };
        let said = words(&[row(40.0, Some(0.41)), row(80.0, Some(0.38)), row(160.0, None)]).unwrap();
        assert!(said.contains("-0.0050 in the mean of 2, -0.0200 (-5.0 %)"), "{said}");
        assert!(said.contains("at 80 N, 5 mm/s, 50 %; 1 measured peak is not fitted"), "{said}");
        assert_eq!(words(&[row(40.0, None)]).unwrap(), "static friction: none of 1 measured peaks is fitted");
        assert_eq!(words(&[]), None);
    }
}
