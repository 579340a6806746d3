//! Lines of friction force against normal force: slope dF/dN, and normal force at which friction vanishes.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use slipgrid_base::units::{HUMIDITY_PCT, SPEED_MM_S, tidy};
use slipgrid_design::results::{Table, fixed};
use slipgrid_infer::calibrate::{CutSample, Measurement};

/// Minimum number of measurements on a line, so that the errors of the line can be computed.
const MIN_FORCES: usize = 3;

/// Line F = s (N - N0) of friction force against normal force at one speed and humidity, by least squares.
///
/// N0 < 0 indicates adhesion; N0 > 0 indicates a film that bears load without friction, which does not affect s.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LoadLine {
    /// `flat`, or the name of the trial.
    pub sample: String,
    /// Sliding speed.
    pub speed_mm_s: f64,
    /// Relative humidity.
    pub humidity_pct: f64,
    /// Number of measurements on the line.
    pub forces: usize,
    /// Slope s = dF/dN.
    pub slope: f64,
    /// Standard error of the slope, from the scatter about the line.
    pub slope_std: f64,
    /// Normal force N0 on one specimen at which the friction of the line is zero.
    pub zero_n: f64,
    /// Standard error of N0.
    pub zero_n_std: f64,
}

/// Fits lines for the `flat` samples and for each of `samples`, at every speed and humidity with at least three
/// measurements, different forces and friction that grows with force.
pub(super) fn load_lines(flat: &[Measurement], samples: &[CutSample]) -> Vec<LoadLine> {
    let trials = samples.iter().map(|cut| (cut.name.as_str(), cut.measured.as_slice()));
    let mut found = Vec::new();
    for (name, rows) in std::iter::once(("flat", flat)).chain(trials) {
        for (place, first) in rows.iter().enumerate() {
            let is_alike = |row: &&Measurement| row.speed_m_s == first.speed_m_s && row.humidity == first.humidity;
            if !rows[..place].iter().any(|row| is_alike(&row)) {
                let own: Vec<&Measurement> = rows.iter().filter(is_alike).collect();
                found.extend(line(name, &own));
            }
        }
    }
    found
}

fn line(sample: &str, rows: &[&Measurement]) -> Option<LoadLine> {
    let n = rows.len() as f64;
    let mean = |of: fn(&Measurement) -> f64| rows.iter().map(|row| of(row)).sum::<f64>() / n;
    let friction_n = |row: &Measurement| row.mu_dynamic * row.force_n;
    let (force_n, friction) = (mean(|row| row.force_n), mean(friction_n));
    let sum = |of: &dyn Fn(&Measurement) -> f64| rows.iter().map(|row| of(row)).sum::<f64>();
    let spread = sum(&|row| (row.force_n - force_n).powi(2));
    if rows.len() < MIN_FORCES || spread <= 0.0 {
        return None;
    }
    let slope = sum(&|row| (row.force_n - force_n) * (friction_n(row) - friction)) / spread;
    let rest = sum(&|row| (friction_n(row) - friction - slope * (row.force_n - force_n)).powi(2)) / (n - 2.0);
    let zero_n = force_n - friction / slope;
    // N0 = N - F / s: var = [var F + (F / s)^2 var s] / s^2
    let slope_variance = rest / spread;
    let zero_variance = (rest / n + (friction / slope).powi(2) * slope_variance) / (slope * slope);
    let first = rows.first().filter(|_| slope > 0.0)?;
    Some(LoadLine {
        sample: sample.to_owned(),
        speed_mm_s: tidy(SPEED_MM_S.from_si(first.speed_m_s)),
        humidity_pct: tidy(HUMIDITY_PCT.from_si(first.humidity)),
        forces: rows.len(),
        slope: tidy(slope),
        slope_std: tidy(slope_variance.sqrt()),
        zero_n: tidy(zero_n),
        zero_n_std: tidy(zero_variance.sqrt()),
    })
}

/// Table of the fitted lines.
pub(super) fn table(lines: &[LoadLine]) -> Table {
    let mut table = Table::of(lines);
    table.column("sample", |of| of.sample.clone());
    table.column("v mm/s", |of| of.speed_mm_s.to_string());
    table.column("RH %", |of| of.humidity_pct.to_string());
    table.column("dF/dN", |of| fixed(Some(of.slope), 3));
    table.column("+-", |of| fixed(Some(of.slope_std), 3));
    table.column("N0 N", |of| fixed(Some(of.zero_n), 1));
    table.column("+-", |of| fixed(Some(of.zero_n_std), 1));
    table.table()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_force_borne_without_friction_is_the_zero_of_the_line() {
        let row = |force_n: f64, humidity: f64, off: f64| Measurement {
            force_n,
            speed_m_s: 2e-3,
            humidity,
            // F = 0.3 (N - 10)
            mu_dynamic: 0.3 * (force_n - 10.0) / force_n + off / force_n,
            mu_dynamic_std: 0.002,
            static_peak: None,
        };
        let flat = [row(50.0, 0.8, 0.0), row(100.0, 0.8, 0.0), row(50.0, 0.4, 0.0), row(200.0, 0.8, 0.0)];
        let found = load_lines(&flat, &[]);
        assert_eq!(found.len(), 1, "two forces make no line: {found:?}");
        let of = &found[0];
        assert_eq!((of.sample.as_str(), of.forces, of.humidity_pct), ("flat", 3, 80.0));
        assert!((of.slope - 0.3).abs() < 1e-9 && (of.zero_n - 10.0).abs() < 1e-6 && of.zero_n_std < 1e-6, "{of:?}");
        // Residuals -1, 2, -1 over equal distances: the slope is unchanged.
        let scattered = [row(50.0, 0.4, -1.0), row(100.0, 0.4, 2.0), row(150.0, 0.4, -1.0)];
        let of = &load_lines(&scattered, &[])[0];
        assert!((of.slope - 0.3).abs() < 1e-9 && (of.slope_std - (6.0_f64 / 5000.0).sqrt()).abs() < 1e-9, "{of:?}");
        assert!(table(&[]).body().is_empty() && table(&found).to_string().contains("0.300"));
    }
}
