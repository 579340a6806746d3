//! Friction target of a design, `[target]`, and the speeds and humidities at which it must hold, each a number or a range.

use schemars::JsonSchema;
use serde::Deserialize;
use slipgrid_design::optimize::{Demand, Goal, Quantity, Target, Wanted};
use slipgrid_model::material::ConditionRange;

use super::values::{MAX_TARGET_PRESSURES, Numbers, distinct_pressures, for_each, range};
use crate::formats::{Diagnostic, Document, Spanned};
use slipgrid_base::units::{FRICTION, HUMIDITY_PCT, PRESSURE_MPA, RATIO, SPEED_MM_S, TOLERANCE, WEIGHT};

/// The table `[target]` of a design file.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TargetFile {
    /// Target quantity: `ratio`, friction of the patterned over the flat surface, or `mu_dynamic`, dynamic friction.
    quantity: Spanned<String>,
    /// Nominal pressures.
    pub pressure_mpa: Spanned<Numbers>,
    /// Target value: one number, or one per pressure.
    value: Option<Spanned<Numbers>>,
    /// Half-width about `value` within which the target is met; with only `lowest` or `highest`, distance beyond this
    /// limit at which the search aims (without the key 0.01 of the limit). One number, or one per pressure.
    tolerance: Option<Spanned<Numbers>>,
    /// Lower end of a band, in place of `value`: one number, or one per pressure.
    lowest: Option<Spanned<Numbers>>,
    /// Upper end of a band, in place of `value`: one number, or one per pressure.
    highest: Option<Spanned<Numbers>>,
    /// Goal of the search: `lowest` or `highest` mean of the quantity over the pressures, or `even`, the smallest
    /// standard deviation over the pressures relative to the mean.
    goal: Option<Spanned<String>>,
    /// Weight of each pressure in means over the pressures; all alike when absent.
    weights: Option<Spanned<Numbers>>,
}

/// Default distance beyond a one-sided limit at which the search aims, relative to the limit.
const MARGIN: f64 = 0.01;

/// Reads the target of a design.
///
/// # Errors
/// [`Diagnostic`] if numbers are out of range, lists differ in length, or keys contradict each other.
pub fn read_target(document: &Document, file: &Spanned<TargetFile>) -> Result<Target, Diagnostic> {
    let target = file.get_ref();
    let quantity = document.choice(&target.quantity, &Quantity::ALL, Quantity::name)?;
    let pressures_pa = distinct_pressures(document, &target.pressure_mpa, PRESSURE_MPA, MAX_TARGET_PRESSURES)?;
    let range = match quantity {
        Quantity::Ratio => RATIO,
        Quantity::DynamicFriction => FRICTION,
    };
    let each = |numbers: &Option<Spanned<Numbers>>, range: slipgrid_base::units::Quantity| {
        numbers.as_ref().map(|numbers| for_each(document, numbers, range, pressures_pa.len(), "pressure")).transpose()
    };
    let goal = target.goal.as_ref().map(|goal| document.choice(goal, &Goal::ALL, Goal::name)).transpose()?;
    let (value, tolerance) = (each(&target.value, range)?, each(&target.tolerance, TOLERANCE)?);
    let (lowest, highest) = (each(&target.lowest, range)?, each(&target.highest, range)?);
    let weights = each(&target.weights, WEIGHT)?;
    combined(document, file, goal)?;
    let wanted = |place: usize| {
        let at = |numbers: &Option<Vec<f64>>| numbers.as_ref().map(|numbers| numbers[place]);
        match (at(&value), at(&lowest), at(&highest)) {
            (Some(value), ..) => Wanted::Near { value, tolerance: at(&tolerance).unwrap_or_default() },
            (None, Some(lowest), Some(highest)) => Wanted::Between { lowest, highest },
            (None, Some(lowest), None) => Wanted::AtLeast { lowest, margin: at(&tolerance).unwrap_or(MARGIN * lowest) },
            (None, None, Some(highest)) => {
                Wanted::AtMost { highest, margin: at(&tolerance).unwrap_or(MARGIN * highest) }
            }
            (None, None, None) => Wanted::Anything,
        }
    };
    if let (Some(lowest), Some(highest), Some(place)) = (&lowest, &highest, &target.highest)
        && let Some(reversed) = lowest.iter().zip(highest).position(|(lowest, highest)| lowest >= highest)
    {
        let reason = format!("does not lie above lowest at {} MPa", PRESSURE_MPA.from_si(pressures_pa[reversed]));
        return Err(document.refuse(place.span(), reason).expected("a band: lowest below highest"));
    }
    let demand = |(place, &pressure_pa): (usize, &f64)| Demand {
        pressure_pa,
        wanted: wanted(place),
        weight: weights.as_ref().map_or(1.0, |weights| weights[place]),
    };
    let mut demands: Vec<Demand> = pressures_pa.iter().enumerate().map(demand).collect();
    demands.sort_by(|a, b| a.pressure_pa.total_cmp(&b.pressure_pa));
    Target::of(quantity, demands, goal).map_err(|error| document.refuse(file.span(), error.to_string()))
}

/// Refuses keys of `[target]` that contradict each other or are missing.
fn combined(document: &Document, file: &Spanned<TargetFile>, goal: Option<Goal>) -> Result<(), Diagnostic> {
    let target = file.get_ref();
    let band = target.lowest.as_ref().or(target.highest.as_ref());
    if let (Some(_), Some(band)) = (&target.value, band) {
        return Err(document
            .refuse(band.span(), "stands beside value")
            .expected("value with tolerance, or lowest and highest"));
    }
    if target.value.is_some() && target.tolerance.is_none() {
        return Err(document.missing(file.span(), "tolerance").expected(TOLERANCE.to_string()));
    }
    if target.value.is_none() && band.is_none() && goal.is_none() {
        return Err(document
            .missing(file.span(), "value")
            .expected("value with tolerance, lowest, highest, or goal = \"lowest\", \"highest\" or \"even\""));
    }
    let takes_none =
        target.value.is_none() && (band.is_none() || (target.lowest.is_some() && target.highest.is_some()));
    match &target.tolerance {
        Some(tolerance) if takes_none => Err(document
            .refuse(tolerance.span(), "has nothing that it belongs to")
            .expected("a tolerance beside value, or beside one of lowest and highest")),
        _ => Ok(()),
    }
}

/// A condition or a range of conditions in the form of a design file.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConditionRangeFile {
    /// Sliding speed: one number, or minimum and maximum.
    speed_mm_s: Spanned<Numbers>,
    /// Relative humidity: one number, or minimum and maximum.
    pub(crate) humidity_pct: Spanned<Numbers>,
}

/// Reads a condition or a range of conditions.
///
/// # Errors
/// [`Diagnostic`] if numbers are out of range, a list does not have two entries, or the ends are in the wrong order.
pub fn read_conditions(document: &Document, file: &ConditionRangeFile) -> Result<ConditionRange, Diagnostic> {
    const EXPECTED: &str = "one number, or [lowest, highest]";
    let speed_m_s = range(document, &file.speed_mm_s, SPEED_MM_S, EXPECTED)?;
    let humidity = range(document, &file.humidity_pct, HUMIDITY_PCT, EXPECTED)?;
    ConditionRange::new(speed_m_s, humidity).map_err(|error| document.refuse(file.speed_mm_s.span(), error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(keys: &str) -> Result<Target, String> {
        let text = format!("quantity = \"ratio\"\npressure_mpa = 1.0\n{keys}");
        let document = Document::new("design.toml", &text);
        read_target(&document, &document.parse().unwrap()).map_err(|refused| refused.to_string())
    }

    #[test]
    fn a_tolerance_beside_one_limit_says_how_far_beyond_it_is_aimed() {
        for (keys, wanted) in [
            ("highest = 0.9\ntolerance = 0.02", Wanted::AtMost { highest: 0.9, margin: 0.02 }),
            ("highest = 0.9", Wanted::AtMost { highest: 0.9, margin: MARGIN * 0.9 }),
            ("lowest = 0.9\ntolerance = 0.02", Wanted::AtLeast { lowest: 0.9, margin: 0.02 }),
        ] {
            let demand = Demand { pressure_pa: 1e6, wanted, weight: 1.0 };
            assert_eq!(read(keys), Ok(Target::of(Quantity::Ratio, vec![demand], None).unwrap()), "{keys}");
        }
        let said = read("lowest = 0.8\nhighest = 0.9\ntolerance = 0.02").unwrap_err();
        assert!(said.contains("tolerance: 0.02 has nothing that it belongs to"), "{said}");
        assert!(read("value = 0.85\nhighest = 0.9\ntolerance = 0.02").unwrap_err().contains("stands beside value"));
    }
}
