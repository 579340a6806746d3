//! Measured flat friction as the law of local pressure.

use slipgrid_model::material::{AreaLaw, Extrapolation, MaterialError};

use crate::calibrate::Measurement;

/// Builds the law of local pressure from measurements on `flat` samples of `specimen_area_m2`: friction relative to
/// that at the lowest pressure, averaged over conditions. `None` if no condition was measured at the lowest pressure
/// and another one.
///
/// # Errors
/// [`MaterialError`] if the means are not a valid law.
pub fn flat_friction_law(
    flat: &[Measurement],
    specimen_area_m2: f64,
    extrapolation: Extrapolation,
) -> Result<Option<AreaLaw>, MaterialError> {
    let same = |a: f64, b: f64| (a - b).abs() <= 1e-6 * a.abs().max(b.abs());
    let alike = |a: &Measurement, b: &Measurement| same(a.speed_m_s, b.speed_m_s) && same(a.humidity, b.humidity);
    let mut forces: Vec<f64> = flat.iter().map(|row| row.force_n).collect();
    forces.sort_by(f64::total_cmp);
    forces.dedup_by(|a, b| same(*a, *b));
    let friction_at = |row: &Measurement, force_n: f64| {
        let own = flat.iter().find(|other| alike(other, row) && same(other.force_n, force_n));
        own.map(|other| other.mu_dynamic)
    };
    let Some(&lightest) = forces.first() else { return Ok(None) };
    // Conditions measured at the lowest load and another one.
    let conditions: Vec<(&Measurement, f64)> = flat
        .iter()
        .filter(|row| same(row.force_n, lightest) && flat.iter().filter(|other| alike(other, row)).count() > 1)
        .map(|row| (row, row.mu_dynamic))
        .collect();
    let mean = |force_n: f64| {
        let all: Vec<f64> =
            conditions.iter().filter_map(|(row, first)| Some(friction_at(row, force_n)? / first)).collect();
        (!all.is_empty()).then(|| [force_n / specimen_area_m2, all.iter().sum::<f64>() / all.len() as f64])
    };
    let (pressures_pa, shape): (Vec<f64>, Vec<f64>) =
        forces.iter().filter_map(|f| mean(*f)).map(|[p, f]| (p, f)).unzip();
    if pressures_pa.len() < 2 {
        return Ok(None);
    }
    AreaLaw::from_flat_friction(&pressures_pa, &shape, extrapolation).map(Some)
}
