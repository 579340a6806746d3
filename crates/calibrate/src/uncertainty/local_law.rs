//! Friction of the local pressure, where flat friction contradicts the area law.
//!
//! Flat friction is mu(P) = c(P) f(P): f from the contact area, and a local coefficient c that changes with the nominal load P wherever
//! measured friction does not go as f. Nothing says whether c follows the load on the sample or the pressure on each spot. The first is how a
//! textured sample is modelled; by the second its local friction is
//!
//! ```text
//! f_c(p) = f(p) c(p) / c(P_1)
//! ```
//!
//! with P_1 the lightest measured load: between measured loads measured friction itself, beyond them f with the nearest coefficient.

use slipgrid_material::{AreaLaw, Condition, MaterialError};
use slipgrid_pattern::Pattern;
use slipgrid_springblock::{Scene, SteadyCell};
use slipgrid_units::{FRICTION, HUMIDITY_PCT, PRESSURE_MPA, SPEED_MM_S};

use super::CoefficientEstimate;
use super::first_order_propagation::{steady_cell, with_law};
use super::material_uncertainty::{mean, shares};
use crate::{CalibrationTask, Coefficients, Measurement};

/// Straight parts of f_c from one measured load to the next: c and f are straight there, and their product bends a little.
const PARTS: usize = 8;
/// Coefficients that differ by no more than this share are one.
const SAME_COEFFICIENT: f64 = 1e-6;

/// Friction of the flat samples of `task` as measured, condition by condition, pressures increasing, to the digits that a material file holds; none
/// where one pair of coefficients holds at all loads, or no condition has two.
pub(crate) fn flat_friction(task: &CalibrationTask) -> Vec<CoefficientEstimate> {
    let mut conditions: Vec<(Condition, Vec<CoefficientEstimate>)> = Vec::new();
    let measured: &[Measurement] = if task.coefficients == Coefficients::PerCondition { &task.flat } else { &[] };
    for flat in measured {
        let condition = Condition {
            speed_m_s: SPEED_MM_S.as_written(flat.speed_m_s),
            humidity: HUMIDITY_PCT.as_written(flat.humidity),
        };
        let own = CoefficientEstimate {
            pressure_pa: Some(PRESSURE_MPA.as_written(task.pressure_pa(flat))),
            condition: Some(condition),
            value: FRICTION.as_written(flat.mu_dynamic),
            std_error: 0.0,
        };
        match conditions.iter_mut().find(|(other, _)| other.matches(&condition)) {
            Some((_, all)) => all.push(own),
            None => conditions.push((condition, vec![own])),
        }
    }
    if conditions.iter().all(|(_, all)| all.len() < 2) {
        return Vec::new();
    }
    let sorted = |(_, mut all): (Condition, Vec<CoefficientEstimate>)| {
        all.sort_by(|a, b| a.pressure_pa.partial_cmp(&b.pressure_pa).unwrap_or(std::cmp::Ordering::Equal));
        all
    };
    conditions.into_iter().flat_map(sorted).collect()
}

/// f_c of the `area_law` and of `flat` friction as measured under `condition`; `None` where c is one at all loads, as where one was measured.
#[must_use]
pub fn local_law(area_law: &AreaLaw, flat: &[CoefficientEstimate], condition: Option<&Condition>) -> Option<AreaLaw> {
    let coefficient = |known: &CoefficientEstimate| {
        let factor = known.pressure_pa.map_or(1.0, |pressure_pa| area_law.factor(pressure_pa));
        CoefficientEstimate { value: known.value / factor, ..*known }
    };
    let known: Vec<CoefficientEstimate> = flat.iter().map(coefficient).collect();
    let sorted = |mut pressures_pa: Vec<f64>| {
        pressures_pa.sort_by(f64::total_cmp);
        pressures_pa.dedup();
        pressures_pa
    };
    let measured_pa = sorted(known.iter().filter_map(|known| known.pressure_pa).collect());
    let between = |ends: &[f64]| -> Vec<f64> {
        (1..PARTS).map(|part| ends[0] + (ends[1] - ends[0]) * part as f64 / PARTS as f64).collect()
    };
    let mut pressures_pa: Vec<f64> = measured_pa.windows(2).flat_map(between).collect();
    pressures_pa.extend(measured_pa.iter().chain(area_law.pressures_pa()));
    let pressures_pa = sorted(pressures_pa);
    let rows = shares(&known, &pressures_pa, condition)?;
    let coefficients: Vec<f64> = rows.iter().map(|row| mean(row, &known)).collect();
    let [least, most] = [f64::min, f64::max].map(|end| coefficients.iter().copied().fold(coefficients[0], end));
    if !(least > 0.0 && most > least * (1.0 + SAME_COEFFICIENT)) {
        return None;
    }
    let times = |(pressure_pa, own): (&f64, &f64)| area_law.factor(*pressure_pa) * own / coefficients[0];
    let factors = pressures_pa.iter().zip(&coefficients).map(times).collect();
    AreaLaw::new(pressures_pa, factors).ok()
}

/// `scene` with friction that follows the local pressure by `law`, flat friction as it is.
///
/// # Errors
/// [`MaterialError`] where that leaves no coefficients.
pub fn with_local_law(scene: &Scene, law: &AreaLaw) -> Result<Scene, MaterialError> {
    with_law(scene.clone(), Some(law.clone()), &vec![0.0; scene.loads.len()])
}

/// Change of the logarithm of the steady ratio of `pattern` in `scene` at each load where friction follows the local pressure by `law`; 0 where a
/// ratio cannot be computed.
#[must_use]
pub fn local_law_changes(scene: &Scene, pattern: &Pattern, law: &AreaLaw) -> Vec<f64> {
    let cell = steady_cell(scene, pattern);
    let by_law = with_local_law(&cell, law).map(|cell| SteadyCell::new(&cell).ratios(pattern)).unwrap_or_default();
    let own = SteadyCell::new(&cell).ratios(pattern);
    let change = |load: usize| Some((by_law.get(load).copied()?? / own[load]?).ln());
    (0..scene.loads.len()).map(|load| change(load).unwrap_or(0.0)).collect()
}
