//! Check whether local coefficients depend on load; with a correct law of contact area they are constant.

use slipgrid_base::units::{HUMIDITY_PCT, MODULUS_GPA, PRESSURE_MPA, SPEED_MM_S, in_digits, significant, tidy};
use slipgrid_model::material::Condition;
use slipgrid_surface::contact::AreaPoint;

use crate::calibrate::FittedRow;
use crate::calibrate::surface_area_law_source::{AreaLawOrigin, SurfaceFindings};

/// A change of a coefficient is significant above this number of standard errors.
const MIN_SIGNIFICANCE: f64 = 3.0;
/// A warning is given only if a coefficient changes by more than this fraction.
const MIN_CHANGE: f64 = 0.05;

/// Warning if the local coefficient of a condition (speed and humidity) changes from the lowest to the highest load by
/// more than 5 % and by more than three standard errors. Names the condition with the most significant change.
///
/// Flat friction is mu_d f(P), local coefficient times area factor, so that mu_d is constant if f reproduces the
/// measured dependence on load. Errors of f at different loads are correlated; treating them as independent
/// underestimates the significance.
pub(crate) fn load_dependence_warning(
    surface: &SurfaceFindings,
    modulus_pa: f64,
    by_condition: &[(Condition, Vec<FittedRow>)],
) -> Option<String> {
    // A measured law is flat friction itself, and a fitted law has a single coefficient.
    if !matches!(surface.origin, Some(AreaLawOrigin::Map | AreaLawOrigin::Persson)) {
        return None;
    }
    let changes = by_condition.iter().filter_map(|(condition, rows)| Some((condition, Change::from_rows(rows)?)));
    let changes =
        changes.filter(|(_, change)| change.part.abs() > MIN_CHANGE && change.errors.abs() > MIN_SIGNIFICANCE);
    let (condition, change) = changes.max_by(|(_, a), (_, b)| a.errors.abs().total_cmp(&b.errors.abs()))?;
    let is_of_map = surface.origin == Some(AreaLawOrigin::Map);
    let (source, check) = if is_of_map { ("altitude map", "map") } else { ("rms slope", "slope") };
    let moves = if change.part > 0.0 { "rises" } else { "falls" };
    let [from, to] = change.pressures_pa.map(|pressure_pa| PRESSURE_MPA.from_si(pressure_pa));
    let fitting = fitting_modulus(surface, by_condition).map_or_else(String::new, |factor| {
        let modulus_gpa = MODULUS_GPA.from_si(modulus_pa);
        let fitting_gpa = in_digits(significant(factor * modulus_gpa, 2));
        format!("; Young's modulus of about {fitting_gpa} GPa in place of {} GPa would fit", tidy(modulus_gpa))
    });
    Some(format!(
        "flat friction does not follow the {source} ({:.1} sigma): check {check}, threshold_mpa and modulus; the local coefficient mu_d, which should be constant, {moves} by {:.0} % from {from:.3} to \
         {to:.3} MPa at {} mm/s and {} %{fitting}; local_law = \"measured\" in [surface] takes flat friction as measured",
        change.errors.abs(),
        100.0 * change.part.abs(),
        tidy(SPEED_MM_S.from_si(condition.speed_m_s)),
        tidy(HUMIDITY_PCT.from_si(condition.humidity)),
    ))
}

/// Range of tested factors on Young's modulus: covers pascals given as gigapascals, and the reverse for megapascals.
const MODULUS_FACTORS: [f64; 2] = [1e-9, 1e4];
/// Number of tested factors; neighbours differ by 6 %.
const FACTOR_COUNT: usize = 501;
/// A modulus fits if at most this fraction of chi-square at the given modulus remains.
const MAX_REMAINING_CHI_SQUARE: f64 = 0.1;

/// Factor on Young's modulus for which the contact area A explains the dependence of flat friction on load. For the
/// factor c the area is A(P; c E) = A(P / c; E), and friction is a_k A(P / c) / P with one coefficient a_k per
/// condition. `None` if no modulus explains most of the dependence.
fn fitting_modulus(surface: &SurfaceFindings, by_condition: &[(Condition, Vec<FittedRow>)]) -> Option<f64> {
    let (curve, law) = (&surface.curve, surface.law.as_ref()?);
    let (first, last) = (curve.first()?, curve.last()?);
    let log_share = |point: &AreaPoint| (point.area_fraction_corrected / point.pressure_pa).ln();
    // ln (A / P), extrapolated by its limits beyond the ends of the curve.
    let at = |pressure_pa: f64| {
        if pressure_pa <= first.pressure_pa {
            return log_share(first);
        }
        let above = curve.partition_point(|point| point.pressure_pa < pressure_pa);
        let Some(upper) = curve.get(above) else { return (last.area_fraction_corrected / pressure_pa).ln() };
        let lower = &curve[above - 1];
        let share = (pressure_pa / lower.pressure_pa).ln() / (upper.pressure_pa / lower.pressure_pa).ln();
        (1.0 - share) * log_share(lower) + share * log_share(upper)
    };
    // ln friction with its standard error: flat friction is mu_d f(P).
    let log_friction = |row: &FittedRow| {
        let std_error = row.pair.dynamic_std_error_given_law.or(row.pair.dynamic_std_error)?;
        let friction = row.pair.dynamic_mean * law.factor(row.pressure_pa);
        (friction > 0.0 && std_error > 0.0).then(|| (row.pressure_pa, friction.ln(), std_error / row.pair.dynamic_mean))
    };
    let conditions: Vec<Vec<(f64, f64, f64)>> =
        by_condition.iter().map(|(_, rows)| rows.iter().filter_map(log_friction).collect()).collect();
    let chi_square = |factor: f64| -> f64 {
        let condition_chi_square = |rows: &Vec<(f64, f64, f64)>| -> f64 {
            let off = || rows.iter().map(|&(pressure_pa, log, std)| (log - at(pressure_pa / factor), std.powi(-2)));
            let mean =
                off().map(|(off, weight)| off * weight).sum::<f64>() / off().map(|(_, weight)| weight).sum::<f64>();
            off().map(|(off, weight)| weight * (off - mean).powi(2)).sum()
        };
        conditions.iter().filter(|rows| rows.len() > 1).map(condition_chi_square).sum()
    };
    let [from, to] = MODULUS_FACTORS;
    let tried = (0..FACTOR_COUNT).map(|i| from * (to / from).powf(i as f64 / (FACTOR_COUNT - 1) as f64));
    let best = tried.min_by(|a, b| chi_square(*a).total_cmp(&chi_square(*b)))?;
    // Far harder solids all have the law f = 1, and far softer ones share another; a minimum there determines no
    // modulus.
    let is_found = best > from && [0.5, 2.0].iter().any(|by| chi_square(best * by) > chi_square(best) + 1.0);
    (is_found && chi_square(best) < MAX_REMAINING_CHI_SQUARE * chi_square(1.0)).then_some(best)
}

/// Change of a local coefficient from the lowest to the highest load.
struct Change {
    pressures_pa: [f64; 2],
    /// Change relative to the coefficient at the lowest load.
    part: f64,
    /// Change relative to its standard error.
    errors: f64,
}

impl Change {
    /// Change over `rows`, sorted by pressure; `None` for a single load, or if a standard error is unknown.
    fn from_rows(rows: &[FittedRow]) -> Option<Self> {
        let (first, last) = (rows.first()?, rows.last().filter(|_| rows.len() > 1)?);
        let [from, to] = [first, last].map(|row| row.pair.dynamic_mean);
        // s^2 = s_1^2 + s_2^2
        let std_error = first.pair.dynamic_std_error?.hypot(last.pair.dynamic_std_error?);
        let change = to - from;
        (from > 0.0 && std_error > 0.0).then(|| Self {
            pressures_pa: [first.pressure_pa, last.pressure_pa],
            part: change / from,
            errors: change / std_error,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::area_law::{area_law, persson_curve};
    use crate::calibrate::{FittedPair, LawPressures};

    fn row(pressure_pa: f64, dynamic_mean: f64, std_error: f64) -> FittedRow {
        let pair = FittedPair {
            static_mean: 1.1 * dynamic_mean,
            dynamic_mean,
            static_std_error: None,
            dynamic_std_error: Some(std_error),
            dynamic_std_error_given_law: None,
        };
        FittedRow { pressure_pa, pair, residual: 0.0, dynamic_over_steady: 1.01 }
    }

    #[test]
    fn a_coefficient_that_follows_load_is_told_with_its_size() {
        let map = AreaLawOrigin::Map;
        let at = |speed_m_s| Condition { speed_m_s, humidity: 0.5 };
        let of = |origin: AreaLawOrigin, last: f64, std_error: f64| {
            let rows = |last: f64| vec![row(0.4e6, 0.28, 0.001), row(1e6, 0.29, 0.004), row(4e6, last, std_error)];
            let surface = SurfaceFindings { origin: Some(origin), ..SurfaceFindings::default() };
            load_dependence_warning(&surface, 0.38e9, &[(at(2e-3), rows(0.281)), (at(1e-2), rows(last))])
        };
        let said = of(map, 0.336, 0.018).unwrap();
        let first =
            "flat friction does not follow the altitude map (3.1 sigma): check map, threshold_mpa and modulus; ";
        assert!(said.starts_with(first), "{said}");
        assert!(
            said.contains("which should be constant, rises by 20 % from 0.400 to 4.000 MPa at 10 mm/s and 50 %;"),
            "{said}"
        );
        assert!(of(map, 0.23, 0.01).unwrap().contains("falls by 18 %"));
        // A change within its error, one too small to matter, and a measured law.
        assert_eq!(of(map, 0.336, 0.02), None);
        assert_eq!(of(map, 0.29, 0.001), None);
        assert_eq!(of(AreaLawOrigin::Measured, 0.336, 0.001), None);
    }

    #[test]
    fn the_modulus_that_fits_is_named() {
        // Friction of a solid of 0.048 GPa, calibrated with wrong moduli: by a factor of 1000 (MPa given as GPa), and
        // by less.
        let rms_slope = 0.0358;
        let law_at = |modulus_pa: f64| {
            let of = LawPressures::new(None, 1.125 * modulus_pa, rms_slope, None);
            let curve = persson_curve(rms_slope, 1.125 * modulus_pa, &of.pressures_pa).unwrap();
            (area_law(&curve, of.threshold_pa).unwrap(), curve)
        };
        let condition = Condition { speed_m_s: 1e-2, humidity: 0.4 };
        let told = |true_pa: f64, taken_pa: f64, exponent: f64| {
            let ((truth, _), (law, curve)) = (law_at(true_pa), law_at(taken_pa));
            let rows = [0.15e6, 0.3e6, 0.6e6, 1e6].map(|pressure_pa| {
                let friction = 0.65 * truth.factor(pressure_pa) * (pressure_pa / 1e6_f64).powf(exponent);
                let mean = friction / law.factor(pressure_pa);
                row(pressure_pa, mean, 0.01 * mean)
            });
            let surface = SurfaceFindings {
                origin: Some(AreaLawOrigin::Persson),
                law: Some(law),
                curve,
                ..SurfaceFindings::default()
            };
            load_dependence_warning(&surface, taken_pa, &[(condition, rows.to_vec())])
        };
        for (taken_pa, taken) in [(48e9, "48"), (0.48e9, "0.48"), (0.012e9, "0.012")] {
            let said = told(0.048e9, taken_pa, 0.0).unwrap();
            let words = said.split("of about ").nth(1).unwrap();
            let fitting_gpa: f64 = words.split(' ').next().unwrap().parse().unwrap();
            assert!((0.044..0.053).contains(&fitting_gpa), "{said}");
            assert!(said.contains(&format!("GPa in place of {taken} GPa would fit; local_law")), "{said}");
        }
        assert_eq!(told(0.048e9, 0.048e9, 0.0), None);
        // No modulus explains friction that rises with load.
        let said = told(0.048e9, 48e9, 0.6).unwrap();
        assert!(said.contains("and modulus; the local coefficient") && !said.contains("would fit"), "{said}");
    }
}
