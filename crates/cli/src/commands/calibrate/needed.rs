//! Which measurements a design needs: each takes a run of the flat sample in time.

use slipgrid_material::{Condition, between};

use super::Purpose;
use slipgrid_formats::calibration::{Calibration, Coefficients};
use slipgrid_formats::measurements::Measurement;

/// A force within a part in a million of another is the same.
const SAME_PRESSURE: f64 = 1e-6;

/// The measurements on flat samples that coefficients for `purpose` are made of: where they depend on the condition those at
/// its conditions, or about them, and of these the ones about each of its pressures; all where one pair holds for all.
pub fn needed(calibration: &Calibration, purpose: &Purpose<'_>) -> Vec<Measurement> {
    let (Coefficients::PerCondition, Some(condition)) = (calibration.coefficients, &purpose.condition) else {
        return calibration.flat.clone();
    };
    let of = |measured: &Measurement| Condition { speed_m_s: measured.speed_m_s, humidity: measured.humidity };
    let measured: Vec<Condition> = calibration.flat.iter().map(of).collect();
    let wanted = purpose.also_at.iter().chain([condition]);
    let about: Vec<_> = wanted.filter_map(|condition| between(&measured, condition)).flatten().collect();
    let is_about = |condition: &Condition| about.iter().any(|(own, _)| own.matches(condition));
    let pressure_pa = |measured: &Measurement| calibration.pressure_pa(measured.force_n);
    let is_needed = |row: &&Measurement| {
        let condition = of(row);
        let own: Vec<f64> =
            calibration.flat.iter().filter(|other| of(other).matches(&condition)).map(pressure_pa).collect();
        is_about(&condition) && purpose.pressures_pa.iter().any(|wanted| is_beside(&own, pressure_pa(row), *wanted))
    };
    calibration.flat.iter().filter(is_needed).copied().collect()
}

/// Whether `one` of the measured pressures is `wanted`, or the nearest of them on either side.
fn is_beside(measured: &[f64], one: f64, wanted: f64) -> bool {
    let slack = SAME_PRESSURE * wanted;
    let below = measured.iter().copied().filter(|own| *own <= wanted + slack).reduce(f64::max);
    let above = measured.iter().copied().filter(|own| *own >= wanted - slack).reduce(f64::min);
    below.is_some_and(|below| one >= below - slack) && above.is_none_or(|above| one <= above + slack)
        || below.is_none() && above.is_some_and(|above| one <= above + slack)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pressures_beside_the_wanted_one_are_needed() {
        let measured = [2.0, 0.5, 1.0, 1.5];
        let beside = |wanted: f64| -> Vec<f64> {
            measured.iter().copied().filter(|one| is_beside(&measured, *one, wanted)).collect()
        };
        assert_eq!(beside(1.2), [1.0, 1.5]);
        assert_eq!(beside(1.0), [1.0]);
        assert_eq!(beside(1.0 + 1e-8), [1.0]);
        assert_eq!(beside(0.4), [0.5]);
        assert_eq!(beside(2.2), [2.0]);
    }
}
