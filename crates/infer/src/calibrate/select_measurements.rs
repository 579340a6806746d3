//! Selection of the measurements that a design needs, because each measurement on a flat sample requires a dynamic run.

use slipgrid_base::units::{HUMIDITY_PCT, SAME, SPEED_MM_S};
use slipgrid_model::material::{Condition, ConditionFriction, Friction, LocalFriction, MaterialError, between};

use crate::calibrate::{CalibrationTask, Coefficients, Measurement, Selection};

impl Selection {
    /// Selects the measurements of `task` on flat samples. If coefficients depend on the condition, these are the
    /// measurements at the selected conditions or next to them, and next to each pressure; otherwise all.
    pub fn flat(&self, task: &CalibrationTask) -> Vec<Measurement> {
        if task.coefficients != Coefficients::PerCondition || self.conditions.is_empty() {
            return task.flat.clone();
        }
        let measured: Vec<Condition> = task.flat.iter().map(Measurement::condition).collect();
        let about: Vec<_> =
            self.conditions.iter().filter_map(|condition| between(&measured, condition)).flatten().collect();
        let is_about = |condition: &Condition| about.iter().any(|(own, _)| own.matches(condition));
        let is_needed = |row: &&Measurement| {
            let condition = row.condition();
            let own: Vec<f64> = task
                .flat
                .iter()
                .filter(|other| other.condition().matches(&condition))
                .map(|other| task.pressure_pa(other))
                .collect();
            is_about(&condition)
                && self.pressures_pa.iter().any(|wanted| is_beside(&own, task.pressure_pa(row), *wanted))
        };
        task.flat.iter().filter(is_needed).copied().collect()
    }
}

/// Groups `rows` by speed and humidity: groups in the order of their first rows, rows of a group in their order.
pub(crate) fn by_condition<T>(rows: impl Iterator<Item = (Condition, T)>) -> Vec<(Condition, Vec<T>)> {
    let mut groups: Vec<(Condition, Vec<T>)> = Vec::new();
    for (condition, row) in rows {
        match groups.iter_mut().find(|(other, _)| other.matches(&condition)) {
            Some((_, rows)) => rows.push(row),
            None => groups.push((condition, vec![row])),
        }
    }
    groups
}

/// Speed and humidity as they are read back from a file.
pub(crate) fn as_written(condition: &Condition) -> Condition {
    Condition {
        speed_m_s: SPEED_MM_S.as_written(condition.speed_m_s),
        humidity: HUMIDITY_PCT.as_written(condition.humidity),
    }
}

/// Measured flat friction in place of fitted coefficients, at nominal pressures: force over `specimen_area_m2`. It is
/// used to find out whether pressures and conditions are within the measured range.
///
/// # Errors
/// [`MaterialError`] if a measured number is not a valid coefficient.
pub fn measured_friction(
    flat: &[Measurement],
    specimen_area_m2: f64,
    coefficients: Coefficients,
    relative_std: f64,
) -> Result<Friction, MaterialError> {
    let row = |measured: &Measurement| {
        Ok(ConditionFriction {
            // P = F / A
            pressure_pa: measured.force_n / specimen_area_m2,
            condition: (coefficients == Coefficients::PerCondition).then_some(measured.condition()),
            friction: LocalFriction::new(measured.mu_dynamic, measured.mu_dynamic, relative_std)?,
        })
    };
    Ok(Friction::PerCondition(flat.iter().map(row).collect::<Result<_, MaterialError>>()?))
}

/// Whether the pressure `one` of the `measured` pressures equals `wanted` or, if none does, is the next one below or
/// above `wanted`; all in pascals.
fn is_beside(measured: &[f64], one: f64, wanted: f64) -> bool {
    let slack = SAME * wanted;
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
