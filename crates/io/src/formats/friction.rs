//! Local friction coefficients of a material with their errors, and friction of flat samples: `[friction]` and
//! `[[flat_friction]]` of a material file.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use slipgrid_infer::calibrate::uncertainty::{CoefficientEstimate, MaterialUncertainty};
use slipgrid_model::material::{Condition, ConditionFriction, Friction, LocalFriction};

use super::values::{Number, NumberList, Numbers, for_each, increasing};
use crate::formats::{Diagnostic, Document, Spanned};
use slipgrid_base::key_error::KeyError;
use slipgrid_base::units::{EXCESS, FRICTION, FRICTION_STD, HUMIDITY_PCT, PRESSURE_MPA, RELATIVE_STD, SPEED_MM_S};

/// Default standard deviation of the friction coefficients between contact blocks, relative to the mean, as in Balestra
/// et al., J. Tribol. 144, 031704.
pub const DEFAULT_RELATIVE_STD: f64 = 0.05;
/// Default ratio of static to dynamic coefficient if no static friction was measured: 0.30 / 0.27, as in Balestra et
/// al.
pub const DEFAULT_STATIC_OVER_DYNAMIC: f64 = 0.30 / 0.27;

/// Local friction coefficients in the form of a file: one pair, one pair per pressure, or tables per condition.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FrictionFile {
    /// Nominal pressures, one per coefficient; without the key, one pair of coefficients holds at every pressure.
    pub pressure_mpa: Option<NumberList>,
    /// Mean static friction coefficient of the contact blocks: one, or one per pressure.
    pub static_mean: Option<Spanned<Numbers>>,
    /// Mean dynamic friction coefficient of the contact blocks: one, or one per pressure.
    pub dynamic_mean: Option<Spanned<Numbers>>,
    /// Standard deviation of both coefficients between contact blocks, relative to the mean; 0.05 when absent.
    pub relative_std: Option<Number>,
    /// Standard errors of `static_mean`.
    pub static_std_error: Option<Spanned<Numbers>>,
    /// Standard errors of `dynamic_mean`, including those of Young's modulus and the area law; without
    /// `dynamic_std_error_given_law`, only those of flat friction.
    pub dynamic_std_error: Option<Spanned<Numbers>>,
    /// Standard errors of `dynamic_mean` at the given area law: those of flat friction.
    pub dynamic_std_error_given_law: Option<Spanned<Numbers>>,
    /// Dynamic friction of the flat sample over that of an endless flat sample in steady sliding, `dynamic_mean` times
    /// the area factor.
    pub dynamic_over_steady: Option<Spanned<Numbers>>,
    /// Modelled minus measured friction of the flat sample, one per measurement.
    pub residual: Option<Vec<f64>>,
    /// 2 x 2 covariance of `dynamic_mean` and the logarithm of the area law's pressure scale, if the scale was fitted.
    pub scale_covariance: Option<Spanned<Vec<Vec<f64>>>>,
    /// Coefficients per condition, in place of the coefficients above.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub conditions: Vec<Spanned<ConditionTable>>,
}

/// Coefficients at one speed and humidity.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConditionTable {
    /// Sliding speed.
    pub speed_mm_s: Number,
    /// Relative humidity.
    pub humidity_pct: Number,
    /// Nominal pressures.
    pub pressure_mpa: NumberList,
    /// Mean static friction coefficients of the contact blocks: one for all pressures, or one per pressure.
    pub static_mean: Spanned<Numbers>,
    /// Mean dynamic friction coefficients of the contact blocks: one for all pressures, or one per pressure.
    pub dynamic_mean: Spanned<Numbers>,
    /// Standard errors of `static_mean`.
    pub static_std_error: Option<Spanned<Numbers>>,
    /// Standard errors of `dynamic_mean`, including those of Young's modulus and the area law; without
    /// `dynamic_std_error_given_law`, only those of flat friction.
    pub dynamic_std_error: Option<Spanned<Numbers>>,
    /// Standard errors of `dynamic_mean` at the given area law: those of flat friction.
    pub dynamic_std_error_given_law: Option<Spanned<Numbers>>,
    /// Dynamic friction of the flat sample over that of an endless flat sample in steady sliding, `dynamic_mean` times
    /// the area factor.
    pub dynamic_over_steady: Option<Spanned<Numbers>>,
    /// Modelled minus measured friction of the flat sample, one per pressure.
    pub residual: Option<Vec<f64>>,
}

/// Dynamic friction of flat samples at one speed and humidity.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FlatFrictionTable {
    /// Sliding speed.
    pub speed_mm_s: Number,
    /// Relative humidity.
    pub humidity_pct: Number,
    /// Nominal pressures.
    pub pressure_mpa: NumberList,
    /// Dynamic friction at each pressure.
    pub mu_dynamic: Spanned<Numbers>,
}

/// Checks that speed and humidity of a condition are in range, and returns the condition.
///
/// # Errors
/// [`Diagnostic`] for numbers out of range.
pub fn check_condition(document: &Document, table: &Spanned<Condition>) -> Result<Condition, Diagnostic> {
    let condition = *table.get_ref();
    KeyError::number("speed_mm_s", SPEED_MM_S.from_si(condition.speed_m_s), SPEED_MM_S)
        .and(KeyError::number("humidity_pct", HUMIDITY_PCT.from_si(condition.humidity), HUMIDITY_PCT))
        .map_err(|error| document.refuse_key(&table.span(), &error))?;
    Ok(condition)
}

/// Reads a condition, converted to m/s and a humidity of 0 to 1.
///
/// # Errors
/// [`Diagnostic`] for numbers out of range.
pub fn read_condition(
    document: &Document,
    speed_mm_s: &Number,
    humidity_pct: &Number,
) -> Result<Condition, Diagnostic> {
    Ok(Condition {
        speed_m_s: document.number(speed_mm_s, SPEED_MM_S)?,
        humidity: document.number(humidity_pct, HUMIDITY_PCT)?,
    })
}

/// Reads the friction coefficients and their errors; fields of the returned uncertainty that `[friction]` does not
/// state keep their defaults.
///
/// # Errors
/// [`Diagnostic`] for any refused input.
pub(super) fn read_friction(
    document: &Document,
    file: &Spanned<FrictionFile>,
) -> Result<(Friction, MaterialUncertainty), Diagnostic> {
    let relative_std =
        document.optional(file.get_ref().relative_std.as_ref(), RELATIVE_STD)?.unwrap_or(DEFAULT_RELATIVE_STD);
    let tables = coefficients(document, file)?;
    let (mut rows, mut known) = (Vec::new(), MaterialUncertainty::default());
    for (condition, table) in &tables {
        let static_mean = table.static_mean.as_ref().ok_or_else(|| document.missing(file.span(), "static_mean"))?;
        let dynamic_mean = table.dynamic_mean.as_ref().ok_or_else(|| document.missing(file.span(), "dynamic_mean"))?;
        let is_list = |mean: &&&Spanned<Numbers>| matches!(mean.get_ref(), Numbers::Each(_));
        if let (None, Some(list)) = (&table.pressure_mpa, [static_mean, dynamic_mean].iter().find(is_list)) {
            return Err(document
                .refuse(list.span(), "is a list without pressures")
                .expected("one number, or `pressure_mpa` beside it, one for each coefficient"));
        }
        let pressures_pa = table.pressure_mpa.as_ref().map(|list| increasing(document, list, PRESSURE_MPA));
        let pressures_pa = pressures_pa.transpose()?;
        let count = pressures_pa.as_ref().map_or(1, Vec::len);
        let each = |numbers, quantity| for_each(document, numbers, quantity, count, "pressure");
        let optional = |own: Option<_>, quantity| own.map(|own| each(own, quantity)).transpose();
        let (static_mean, dynamic_mean) = (each(static_mean, FRICTION)?, each(dynamic_mean, FRICTION)?);
        let static_std = optional(table.static_std_error.as_ref(), FRICTION_STD)?;
        let with_law = optional(table.dynamic_std_error.as_ref(), FRICTION_STD)?;
        let given_law = optional(table.dynamic_std_error_given_law.as_ref(), FRICTION_STD)?;
        let excess = optional(table.dynamic_over_steady.as_ref(), EXCESS)?;
        known.has_marginal_errors |= given_law.is_some();
        // Errors at the given area law are those of flat friction.
        let dynamic_std = given_law.or(with_law);
        for row in 0..count {
            let pressure_pa = pressures_pa.as_ref().map(|list| list[row]);
            let estimate =
                |value, std_error| CoefficientEstimate { pressure_pa, condition: *condition, value, std_error };
            known.friction.extend(dynamic_std.as_ref().map(|std| estimate(dynamic_mean[row], std[row])));
            known.static_friction.extend(static_std.as_ref().map(|std| estimate(static_mean[row], std[row])));
            known.dynamic_over_steady.extend(excess.as_ref().map(|excess| estimate(excess[row], 0.0)));
            let friction = LocalFriction::new(static_mean[row], dynamic_mean[row], relative_std)
                .map_err(|error| document.refuse(file.span(), error.to_string()))?;
            let pressure_pa = pressure_pa.unwrap_or_default();
            rows.push(ConditionFriction { pressure_pa, condition: *condition, friction });
        }
    }
    known.scale_covariance = scale_covariance(document, file.get_ref())?;
    let friction = match (&tables[..], &rows[..]) {
        ([(_, FrictionFile { pressure_mpa: None, .. })], [only]) => Friction::Single(only.friction),
        _ => Friction::PerCondition(rows),
    };
    Ok((friction, known))
}

/// Coefficients of `file`: one entry per condition, or a single entry for any condition, `None`.
fn coefficients(
    document: &Document,
    file: &Spanned<FrictionFile>,
) -> Result<Vec<(Option<Condition>, FrictionFile)>, Diagnostic> {
    let mut tables: Vec<(Option<Condition>, FrictionFile)> = Vec::new();
    for table in file.get_ref().conditions.iter().map(Spanned::get_ref).cloned() {
        let condition = read_condition(document, &table.speed_mm_s, &table.humidity_pct)?;
        if tables.iter().any(|(other, _)| other.is_some_and(|other| other.matches(&condition))) {
            return Err(document
                .refuse(table.speed_mm_s.span(), "and this humidity occur a second time")
                .expected("one table per condition"));
        }
        let of_condition = FrictionFile {
            pressure_mpa: Some(table.pressure_mpa),
            static_mean: Some(table.static_mean),
            dynamic_mean: Some(table.dynamic_mean),
            static_std_error: table.static_std_error,
            dynamic_std_error: table.dynamic_std_error,
            dynamic_std_error_given_law: table.dynamic_std_error_given_law,
            dynamic_over_steady: table.dynamic_over_steady,
            ..FrictionFile::default()
        };
        tables.push((Some(condition), of_condition));
    }
    if tables.is_empty() {
        return Ok(vec![(None, file.get_ref().clone())]);
    }
    refuse_beside_conditions(document, file)?;
    Ok(tables)
}

/// Keys of `[friction]` for coefficients that hold at any condition.
const OF_ANY_CONDITION: [&str; 8] = [
    "static_mean",
    "dynamic_mean",
    "static_std_error",
    "dynamic_std_error",
    "dynamic_std_error_given_law",
    "dynamic_over_steady",
    "pressure_mpa",
    "scale_covariance",
];

/// Refuses coefficients, and keys that belong to them, in addition to coefficients per condition, because they would be
/// ignored.
fn refuse_beside_conditions(document: &Document, file: &Spanned<FrictionFile>) -> Result<(), Diagnostic> {
    let table = file.span();
    let places = OF_ANY_CONDITION.map(|key| (key, document.value_span(&table, key)));
    let Some((key, place)) = places.into_iter().find(|(_, place)| *place != table) else { return Ok(()) };
    let expected = match key {
        "static_mean" | "dynamic_mean" => "either static_mean and dynamic_mean, or [[friction.conditions]]".to_owned(),
        "scale_covariance" => {
            "scale_covariance beside one dynamic_mean, or [[friction.conditions]] without it".to_owned()
        }
        _ => format!("{key} in each of the tables [[friction.conditions]], or no such table"),
    };
    Err(document.refuse(place, "stands beside coefficients per condition").expected(expected))
}

/// Reads the measured friction of flat samples. The returned standard errors are 0, because the file states errors only
/// with the coefficients.
pub(super) fn read_flat_friction(
    document: &Document,
    tables: &[Spanned<FlatFrictionTable>],
) -> Result<Vec<CoefficientEstimate>, Diagnostic> {
    let mut all = Vec::new();
    for table in tables {
        let table = table.get_ref();
        let condition = read_condition(document, &table.speed_mm_s, &table.humidity_pct)?;
        let pressures_pa = increasing(document, &table.pressure_mpa, PRESSURE_MPA)?;
        let values = for_each(document, &table.mu_dynamic, FRICTION, pressures_pa.len(), "pressure")?;
        all.extend(pressures_pa.into_iter().zip(values).map(|(pressure_pa, value)| CoefficientEstimate {
            pressure_pa: Some(pressure_pa),
            condition: Some(condition),
            value,
            std_error: 0.0,
        }));
    }
    Ok(all)
}

fn scale_covariance(document: &Document, file: &FrictionFile) -> Result<Option<[[f64; 2]; 2]>, Diagnostic> {
    let (Some(given), Some(mean)) = (&file.scale_covariance, &file.dynamic_mean) else { return Ok(None) };
    let refuse = || {
        document
            .refuse(given.span(), "is no covariance of two numbers")
            .expected("[[a, b], [b, c]] with a and c positive and b^2 at most a c, beside one dynamic_mean")
    };
    let (Numbers::One(mean), [first, second]) = (mean.get_ref(), &given.get_ref()[..]) else { return Err(refuse()) };
    let ([a, b], [c, d]) = (&first[..], &second[..]) else { return Err(refuse()) };
    let is_covariance = *a >= 0.0 && *d >= 0.0 && b == c && b * b <= a * d * (1.0 + 1e-9);
    if !(is_covariance && *mean > 0.0) {
        return Err(refuse());
    }
    Ok(Some([[a / (mean * mean), b / mean], [c / mean, *d]]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::material::read_known;

    fn read(friction: &str, more: &str) -> MaterialUncertainty {
        let text = format!(
            "youngs_modulus_gpa = 0.4\nyoungs_modulus_std_gpa = 0.1\ndensity_g_cm3 = 0.9\n[friction]\n{friction}\n{more}"
        );
        let document = Document::new("m.toml", text);
        read_known(&document, &document.parse().unwrap(), &(0..0)).unwrap().1
    }

    #[test]
    fn one_pair_is_off_alike_at_every_load() {
        let known = read("static_mean = 0.3\ndynamic_mean = 0.25\ndynamic_std_error = 0.005", "");
        let covariance = known.friction_covariance(&[1e6, 2e6], &[None]).unwrap();
        assert!(covariance.iter().flatten().all(|entry| (entry - 4e-4).abs() < 1e-15), "{covariance:?}");
        assert_eq!((known.modulus_relative_std, known.law_is_fitted), (Some(0.25), false));
        assert_eq!(known.learned, None);
        let silent = read("static_mean = 0.3\ndynamic_mean = 0.25", "");
        assert_eq!(silent.friction_covariance(&[1e6], &[None]), None);
    }

    #[test]
    fn a_fitted_scale_comes_with_its_covariance() {
        let single = "static_mean = 0.3\ndynamic_mean = 0.25\ndynamic_std_error = 0.005\n";
        let known = read(&format!("{single}scale_covariance = [[2.5e-5, -1e-3], [-1e-3, 0.09]]"), "");
        let covariance = known.scale_covariance.unwrap();
        let expected = [[4e-4, -4e-3], [-4e-3, 0.09]];
        assert!(covariance.iter().flatten().zip(expected.iter().flatten()).all(|(a, b)| (a - b).abs() < 1e-12));
    }

    #[test]
    fn between_measurements_errors_are_shared() {
        let known = read(
            "relative_std = 0.05\n[[friction.conditions]]\nspeed_mm_s = 2.0\nhumidity_pct = 15.0\npressure_mpa = [1.0, 2.0]\n\
             static_mean = 0.3\ndynamic_mean = [0.2, 0.3]\ndynamic_std_error = [0.004, 0.003]",
            "[area_law]\norigin = \"fit\"\npressure_mpa = [0.7, 2.6]\nfactor = [1.0, 0.9]",
        );
        assert!(known.law_is_fitted);
        let condition = Condition { speed_m_s: 2e-3, humidity: 0.15 };
        // mu(1.5) = 0.25 has the mean of both errors. mu(0.5) and mu(3) have the values at the ends; one of them has
        // four fifths of the shared error.
        let covariance = known.friction_covariance(&[0.5e6, 1.5e6, 3e6], &[Some(condition)]).unwrap();
        let (own, rho) = (0.0035 / 0.25, [0.004, 0.003].map(|error| error / 0.005));
        let expected = [
            [4e-4, 0.02 * rho[0] * own, 0.0],
            [0.02 * rho[0] * own, own * own, 0.01 * rho[1] * own],
            [0.0, 0.01 * rho[1] * own, 1e-4],
        ];
        for (row, expected) in covariance.iter().zip(expected) {
            for (entry, expected) in row.iter().zip(expected) {
                assert!((entry - expected).abs() < 1e-12, "{covariance:?}");
            }
        }
        assert_eq!(known.friction_covariance(&[1e6], &[Some(Condition { humidity: 0.8, ..condition })]), None);
    }

    #[test]
    fn between_conditions_errors_are_shared_too() {
        let condition = |speed: f64, mean: f64, error: f64| {
            format!(
                "[[friction.conditions]]\nspeed_mm_s = {speed}\nhumidity_pct = 15.0\npressure_mpa = [1.0]\n\
                 static_mean = 0.3\ndynamic_mean = {mean}\ndynamic_std_error = {error}\n"
            )
        };
        let known = read(&format!("{}{}", condition(1.0, 0.2, 0.004), condition(4.0, 0.3, 0.003)), "");
        let at = |speed_m_s: f64| Some(Condition { speed_m_s, humidity: 0.15 });
        let covariance = known.friction_covariance(&[1e6], &[at(2e-3), at(1e-3)]).unwrap();
        // Half of each: mean 0.25 with the mean of both errors, and a correlation of 0.8 to the first.
        let own = 0.0035 / 0.25;
        assert!((covariance[0][0] - own * own).abs() < 1e-12, "{covariance:?}");
        assert!((covariance[0][1] - 0.8 * own * 0.02).abs() < 1e-12, "{covariance:?}");
        // A single pair has the same error in all conditions.
        let single = read("static_mean = 0.3\ndynamic_mean = 0.25\ndynamic_std_error = 0.005", "");
        let covariance = single.friction_covariance(&[1e6, 2e6], &[at(2e-3), at(1e-3)]).unwrap();
        assert!(covariance.len() == 4 && covariance.iter().flatten().all(|entry| (entry - 4e-4).abs() < 1e-15));
    }
}
