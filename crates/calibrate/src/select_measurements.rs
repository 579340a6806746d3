//! Which measurements a design needs: each on a flat sample takes a run of that sample in time.

use slipgrid_material::{Condition, ConditionFriction, Friction, LocalFriction, MaterialError, between};

use crate::{CalibrationTask, Coefficients, Measurement};

/// A force within a part in a million of another is the same.
const SAME_PRESSURE: f64 = 1e-6;

/// The conditions and pressures at which friction is wanted.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Selection {
    /// Speeds and humidities; where there are none, all measurements are taken.
    pub conditions: Vec<Condition>,
    /// Nominal pressures, in pascals; where there are conditions, only measurements at or about these pressures are taken.
    pub pressures_pa: Vec<f64>,
}

impl Selection {
    /// The measurements of `task` on flat samples that the coefficients are made of: where they depend on the condition those
    /// at the selected conditions, or about them, and of these the ones about each of the pressures; all where one pair of
    /// coefficients holds for all.
    #[must_use]
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

/// Friction as measured at nominal pressures on specimens of an area, before anything is fitted: enough to find out whether
/// pressures and conditions are among those measured.
///
/// # Errors
/// [`MaterialError`] if a measured number is no coefficient.
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
