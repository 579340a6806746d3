//! Local friction that depends on the local pressure, for materials whose flat friction contradicts the area law.
//!
//! Flat friction is mu(P) = c(P) f(P). The factor f follows from the contact area; the local coefficient c depends on
//! the nominal load P if measured friction is not proportional to f. Measurements do not show whether c depends on the
//! load on the sample or on the pressure on each spot. Textured samples are modelled with the former; with the latter
//! their local friction is
//!
//! ```text
//! f_c(p) = f(p) c(p) / c(P_1)
//! ```
//!
//! where P_1 is the lightest measured load: between measured loads this is measured friction itself. Below them c is
//! that of P_1. Above the heaviest load P_n, friction decreases by the same fraction of the decrease of f as between
//! P_1 and P_n, limited to the range from none to all of it:
//!
//! ```text
//! f_c(p) = f_c(P_n) [f(p) / f(P_n)]^s,     s = 1 - ln[c(P_n) / c(P_1)] / ln[f(P_1) / f(P_n)],     0 <= s <= 1
//! ```

use slipgrid_base::statistics::extremes;
use slipgrid_base::units::{FRICTION, PRESSURE_MPA, SAME, is_same};
use slipgrid_model::material::{AreaLaw, Condition, MaterialError};
use slipgrid_model::pattern::Pattern;
use slipgrid_model::springblock::{Scene, SteadyCell};

use super::CoefficientEstimate;
use super::first_order_propagation::{steady_cell, with_law};
use super::material_uncertainty::{mean, shares};
use crate::calibrate::select_measurements::{as_written, by_condition};
use crate::calibrate::{CalibrationTask, Coefficients, Measurement};

/// Number of linear parts of the local law f_c between two measured loads, and above the heaviest load. Between loads
/// the coefficient c and the area factor f are linear, and their product is slightly curved.
const PARTS: usize = 8;
/// Lower limit for the decrease of ln f (area factor f) over the measured loads in the exponent s of the extrapolation;
/// with a smaller decrease, errors of measured friction would determine s.
const MIN_FALL: f64 = 0.05;
/// Minimum range of the table of the local law f_c, as a multiple of the heaviest measured load: edges of cavities
/// carry ten times the nominal pressure.
const REACH: f64 = 20.0;

/// Measured friction of the flat samples of `task`, by condition and increasing pressure, rounded as in a material
/// file. Empty if one pair of coefficients holds at all loads, or if no condition has two measurements.
pub(crate) fn flat_friction(task: &CalibrationTask) -> Vec<CoefficientEstimate> {
    let measured: &[Measurement] = if task.coefficients == Coefficients::PerCondition { &task.flat } else { &[] };
    let estimate = |flat: &Measurement| {
        let condition = as_written(&flat.condition());
        let own = CoefficientEstimate {
            pressure_pa: Some(PRESSURE_MPA.as_written(task.pressure_pa(flat))),
            condition: Some(condition),
            value: FRICTION.as_written(flat.mu_dynamic),
            std_error: 0.0,
        };
        (condition, own)
    };
    let mut conditions = by_condition(measured.iter().map(estimate));
    if conditions.iter().all(|(_, all)| all.len() < 2) {
        return Vec::new();
    }
    let pressure_pa = |own: &CoefficientEstimate| own.pressure_pa.unwrap_or(0.0);
    conditions.iter_mut().for_each(|(_, all)| all.sort_by(|a, b| pressure_pa(a).total_cmp(&pressure_pa(b))));
    conditions.into_iter().flat_map(|(_, all)| all).collect()
}

/// Computes the law f_c of local pressure from the `area_law` and the measured `flat` friction under `condition`;
/// `None` if the local coefficient c is the same at all loads, for example with one measurement.
pub fn local_law(area_law: &AreaLaw, flat: &[CoefficientEstimate], condition: Option<&Condition>) -> Option<AreaLaw> {
    let coefficient = |known: &CoefficientEstimate| {
        let factor = known.pressure_pa.map_or(1.0, |pressure_pa| area_law.factor(pressure_pa));
        CoefficientEstimate { value: known.value / factor, ..*known }
    };
    let known: Vec<CoefficientEstimate> = flat.iter().map(coefficient).collect();
    let sorted = |mut pressures_pa: Vec<f64>| {
        pressures_pa.sort_by(f64::total_cmp);
        pressures_pa.dedup_by(|a, b| is_same(*a, *b));
        pressures_pa
    };
    // Loads that count under this condition: another condition may have been measured over a wider range.
    let all_pa: Vec<f64> = known.iter().filter_map(|known| known.pressure_pa).collect();
    let rows = shares(&known, &all_pa, condition)?;
    let counts = |place: usize| rows.iter().any(|row| row[place] != 0.0);
    let own = known.iter().enumerate().filter(|(place, _)| counts(*place));
    let measured_pa = sorted(own.filter_map(|(_, known)| known.pressure_pa).collect());
    let (first_pa, last_pa) = (*measured_pa.first()?, *measured_pa.last()?);
    let measured = |pressures_pa: &[f64]| -> Option<Vec<f64>> {
        Some(shares(&known, pressures_pa, condition)?.iter().map(|row| mean(row, &known)).collect())
    };
    let at_measured = measured(&measured_pa)?;
    let [least, most] = extremes(at_measured.iter().copied());
    if !(least > 0.0 && most > least * (1.0 + SAME)) {
        return None;
    }
    let tabulated_pa = area_law.pressures_pa();
    let reach_pa = tabulated_pa.iter().copied().fold(REACH * last_pa, f64::max);
    let parts = (1..=PARTS).map(|part| part as f64 / PARTS as f64);
    let mut pressures_pa = [tabulated_pa, &measured_pa].concat();
    pressures_pa
        .extend(measured_pa.windows(2).flat_map(|ends| parts.clone().map(move |t| ends[0] + t * (ends[1] - ends[0]))));
    pressures_pa.extend(parts.clone().map(|t| last_pa * (reach_pa / last_pa).powf(t)));
    let pressures_pa = sorted(pressures_pa);
    let (first, last) = (at_measured[0], at_measured[at_measured.len() - 1]);
    let fall = |to_pa: f64, from_pa: f64| (area_law.factor(from_pa) / area_law.factor(to_pa)).ln();
    let missing = ((last / first).ln() / fall(last_pa, first_pa).max(MIN_FALL)).clamp(0.0, 1.0);
    let factor = |(pressure_pa, own): (&f64, &f64)| {
        // f_c / f goes on as f^(s - 1), 1 - s the part of the fall that is missing.
        let beyond = if *pressure_pa > last_pa { missing * fall(*pressure_pa, last_pa) } else { 0.0 };
        area_law.factor(*pressure_pa) * own / first * beyond.exp()
    };
    let factors = pressures_pa.iter().zip(&measured(&pressures_pa)?).map(factor).collect();
    AreaLaw::new(pressures_pa, factors).ok()
}

/// Replaces the area law of `scene` by `law`, so that local friction depends on the local pressure; flat friction is
/// unchanged.
///
/// # Errors
/// [`MaterialError`] if no valid coefficients result.
pub fn with_local_law(scene: &Scene, law: &AreaLaw) -> Result<Scene, MaterialError> {
    with_law(scene.clone(), Some(law.clone()), &vec![0.0; scene.loads.len()])
}

/// Changes of the logarithm of the `ratios` of `pattern` in `scene`, one per load, if local friction follows the local
/// pressure by `law`; 0 if a ratio cannot be computed. Cells are solved in the blocks of the scene: were trials solved in
/// smaller blocks than designs, their difference would count as discrepancy. The share of the face that is cavity is
/// `face_share` times that of a period.
pub fn local_law_changes(
    scene: &Scene,
    pattern: &Pattern,
    law: &AreaLaw,
    (ratios, face_share): (&[f64], f64),
) -> Vec<f64> {
    let cell = steady_cell(scene, pattern);
    let by_law = with_local_law(&cell, law).map(|cell| SteadyCell::new(&cell).ratios(pattern)).unwrap_or_default();
    let own = SteadyCell::new(&cell).ratios(pattern);
    // d ln r = (r - 1 + D) / r d ln r_cell of the ratio r = 1 - D (1 - r_cell) with the share D of the face
    let change = |(load, ratio): (usize, &f64)| {
        let of_cell = by_law.get(load).copied()?? / own[load]? - 1.0;
        Some(((ratio - 1.0 + face_share) / ratio * of_cell).ln_1p())
    };
    ratios.iter().enumerate().map(|at| change(at).unwrap_or(0.0)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const DRY: Condition = Condition { speed_m_s: 2e-3, humidity: 0.15 };

    fn flat(rows: &[(Condition, f64, f64)]) -> Vec<CoefficientEstimate> {
        let one = |(condition, mpa, value): &(Condition, f64, f64)| CoefficientEstimate {
            pressure_pa: Some(mpa * 1e6),
            condition: Some(*condition),
            value: *value,
            std_error: 0.0,
        };
        rows.iter().map(one).collect()
    }

    fn area_law() -> AreaLaw {
        AreaLaw::new(vec![0.7e6, 1.4e6, 3e6, 10e6], vec![1.0, 0.95, 0.8, 0.4]).unwrap()
    }

    #[test]
    fn between_measured_loads_the_local_law_is_flat_friction() {
        let measured = flat(&[(DRY, 0.6, 0.25), (DRY, 1.3, 0.26), (DRY, 2.6, 0.28)]);
        let f = area_law();
        let law = local_law(&f, &measured, Some(&DRY)).unwrap();
        for (mpa, mu) in [(0.6, 0.25), (1.3, 0.26), (2.6, 0.28)] {
            assert!((0.25 * law.factor(mpa * 1e6) - mu).abs() < 1e-12, "{mpa}");
        }
        // Between them c is linear; the law is straight in an eighth of each interval.
        let c = |mpa: f64, mu: f64| mu / f.factor(mpa * 1e6);
        let between = f64::midpoint(c(1.3, 0.26), c(2.6, 0.28)) * f.factor(1.95e6);
        assert!((0.25 * law.factor(1.95e6) - between).abs() < 1e-12);
        let off = 0.25 * law.factor(2.1e6) - f.factor(2.1e6) * (c(1.3, 0.26) * 5.0 + c(2.6, 0.28) * 8.0) / 13.0;
        assert!(off.abs() < 1e-4, "{off}");
        // Below them f goes on with the nearest coefficient. Above them friction that did not fall stays as it is.
        assert_eq!(law.factor(0.3e6), 1.0);
        for mpa in [3.0, 10.0, 40.0] {
            assert!((0.25 * law.factor(mpa * 1e6) - 0.28).abs() < 1e-9, "{mpa}");
        }
        // Of half of the fall of f, the root of it; of more than all of it, all of it.
        for (share, kept) in [(0.5, 0.5), (1.5, 1.0)] {
            let mu = 0.25 * f.factor(2.6e6).powf(share);
            let law = local_law(&f, &flat(&[(DRY, 0.6, 0.25), (DRY, 2.6, mu)]), Some(&DRY)).unwrap();
            let fall = (f.factor(10e6) / f.factor(2.6e6)).powf(kept);
            assert!((law.factor(10e6) / law.factor(2.6e6) - fall).abs() < 1e-9, "{share}");
        }
    }

    #[test]
    fn a_condition_measured_over_a_wider_range_does_not_count() {
        let own = [(DRY, 0.6, 0.25), (DRY, 1.3, 0.28)];
        let humid = Condition { humidity: 0.8, ..DRY };
        let both = [own[0], own[1], (humid, 0.6, 0.25), (humid, 2.6, 0.27)];
        let laws = [flat(&own), flat(&both)].map(|known| local_law(&area_law(), &known, Some(&DRY)).unwrap());
        for mpa in [0.9, 1.3, 2.6, 10.0] {
            let [alone, beside] = laws.each_ref().map(|law| law.factor(mpa * 1e6));
            assert!((alone / beside - 1.0).abs() < 1e-3, "{mpa}: {alone} {beside}");
        }
    }

    #[test]
    fn flat_friction_that_follows_the_area_law_is_no_other_law() {
        let f = area_law();
        let along = [0.6, 1.3, 2.6].map(|mpa| (DRY, mpa, 0.25 * f.factor(mpa * 1e6)));
        assert_eq!(local_law(&f, &flat(&along), Some(&DRY)), None);
        assert_eq!(local_law(&f, &flat(&[(DRY, 1.3, 0.26)]), Some(&DRY)), None);
        assert_eq!(local_law(&f, &[], Some(&DRY)), None);
        // Of a condition beside those measured nothing is known.
        let rising = flat(&[(DRY, 0.6, 0.25), (DRY, 2.6, 0.28)]);
        let humid = Condition { humidity: 0.8, ..DRY };
        assert_eq!((local_law(&f, &rising, Some(&humid)), local_law(&f, &rising, None)), (None, None));
        // Halfway to a condition with one load c rises by half as much.
        let both = [rising, flat(&[(humid, 1.3, 0.25 * f.factor(1.3e6))])].concat();
        let halfway = Condition { humidity: 0.475, ..DRY };
        let law = local_law(&f, &both, Some(&halfway)).unwrap();
        let rise = |law: &AreaLaw| law.factor(2.6e6) / f.factor(2.6e6) - 1.0;
        let whole = rise(&local_law(&f, &both, Some(&DRY)).unwrap());
        assert!((rise(&law) - 0.5 * whole).abs() < 1e-9, "{} {whole}", rise(&law));
    }
}
