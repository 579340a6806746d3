//! Measured flat friction as the law of local pressure.

use slipgrid_base::units::is_same;
use slipgrid_model::material::{AreaLaw, Extrapolation, MaterialError};

use crate::calibrate::Measurement;

/// Builds the law of local pressure from measurements on `flat` samples of `specimen_area_m2`: friction relative to
/// that at the lowest pressure, averaged over conditions. `None` if no condition was measured both at the lowest and at
/// another pressure.
///
/// # Errors
/// [`MaterialError`] if the means are not a valid law.
pub fn flat_friction_law(
    flat: &[Measurement],
    specimen_area_m2: f64,
    extrapolation: Extrapolation,
) -> Result<Option<AreaLaw>, MaterialError> {
    let mut forces: Vec<f64> = flat.iter().map(|row| row.force_n).collect();
    forces.sort_by(f64::total_cmp);
    forces.dedup_by(|a, b| is_same(*a, *b));
    let Some(&lightest) = forces.first() else { return Ok(None) };
    // Conditions measured at the lowest load and another one.
    let is_repeated = |row: &&Measurement| flat.iter().filter(|other| other.has_condition_of(row)).count() > 1;
    let conditions: Vec<&Measurement> =
        flat.iter().filter(|row| is_same(row.force_n, lightest)).filter(is_repeated).collect();
    let mean = |force_n: f64| {
        let over_first = |row: &&Measurement| {
            let own = flat.iter().find(|other| other.is_at(&Measurement { force_n, ..**row }))?;
            Some(own.mu_dynamic / row.mu_dynamic)
        };
        let all: Vec<f64> = conditions.iter().filter_map(over_first).collect();
        (!all.is_empty()).then(|| [force_n / specimen_area_m2, all.iter().sum::<f64>() / all.len() as f64])
    };
    let (pressures_pa, shape): (Vec<f64>, Vec<f64>) =
        forces.iter().filter_map(|f| mean(*f)).map(|[p, f]| (p, f)).unzip();
    if pressures_pa.len() < 2 {
        return Ok(None);
    }
    AreaLaw::from_flat_friction(&pressures_pa, &shape, extrapolation).map(Some)
}
