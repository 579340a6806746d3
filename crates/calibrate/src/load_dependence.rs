//! Whether local coefficients follow load, which a law of contact area that fits would leave constant.

use slipgrid_material::Condition;
use slipgrid_units::{HUMIDITY_PCT, PRESSURE_MPA, SPEED_MM_S, tidy};

use crate::FittedRow;
use crate::surface_area_law_source::AreaLawOrigin;

/// Standard errors from which on a change is no scatter.
const SURE: f64 = 3.0;
/// Part of a coefficient by which it must change to matter.
const LEAST: f64 = 0.05;

/// What contradicts the law: the local coefficient of a speed and humidity changes from the lowest to the highest load by more than 5 %, and
/// by more than three times the standard error of that change. The condition where it does so by most standard errors is named.
///
/// Flat friction is mu_d f(P), so that mu_d is constant where f is the measured fall of friction. Errors of f are those of a larger load
/// alone, or shared: taken as independent, they make the change less sure than it is.
pub(crate) fn follows_load(
    origin: Option<AreaLawOrigin>,
    by_condition: &[(Condition, Vec<FittedRow>)],
) -> Option<String> {
    // A measured law is flat friction itself, and a fitted one has one coefficient.
    if !matches!(origin, Some(AreaLawOrigin::Map | AreaLawOrigin::Persson)) {
        return None;
    }
    let changes = by_condition.iter().filter_map(|(condition, rows)| Some((condition, Change::of(rows)?)));
    let changes = changes.filter(|(_, change)| change.part.abs() > LEAST && change.errors.abs() > SURE);
    let (condition, change) = changes.max_by(|(_, a), (_, b)| a.errors.abs().total_cmp(&b.errors.abs()))?;
    let (moves, falls) =
        if change.part > 0.0 { ("rises", "rises with load or falls less") } else { ("falls", "falls more with load") };
    let [from, to] = change.pressures_pa.map(|pressure_pa| PRESSURE_MPA.from_si(pressure_pa));
    Some(format!(
        "local coefficient: mu_d {moves} by {:.0} % from {from:.3} to {to:.3} MPa at {} mm/s and {} %, {:.1} standard errors with those of \
         the law: measured flat friction {falls} than this area law says. The law, the map or the modulus does not fit; \
         local_law = \"measured\" in [surface] takes flat friction as measured",
        100.0 * change.part.abs(),
        tidy(SPEED_MM_S.from_si(condition.speed_m_s)),
        tidy(HUMIDITY_PCT.from_si(condition.humidity)),
        change.errors.abs()
    ))
}

/// How a coefficient changes from the lowest to the highest load.
struct Change {
    pressures_pa: [f64; 2],
    /// Over the coefficient at the lowest load, and over its standard error.
    part: f64,
    errors: f64,
}

impl Change {
    /// Nothing at one load, or where an error is not known.
    fn of(rows: &[FittedRow]) -> Option<Self> {
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
    use crate::FittedPair;

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
            follows_load(Some(origin), &[(at(2e-3), rows(0.281)), (at(1e-2), rows(last))])
        };
        let said = of(map, 0.336, 0.018).unwrap();
        assert!(
            said.starts_with("local coefficient: mu_d rises by 20 % from 0.400 to 4.000 MPa at 10 mm/s and 50 %, 3.1"),
            "{said}"
        );
        assert!(said.contains("rises with load or falls less than this area law says"), "{said}");
        assert!(of(map, 0.23, 0.01).unwrap().contains("mu_d falls by 18 %"));
        // Within its error, too small to matter, or the law that was measured.
        assert_eq!(of(map, 0.336, 0.02), None);
        assert_eq!(of(map, 0.29, 0.001), None);
        assert_eq!(of(AreaLawOrigin::Measured, 0.336, 0.001), None);
    }
}
