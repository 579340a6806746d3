//! Material tables: inline in a scene or design, or in a separate file, with the same keys.

use crate::formats::spanned::Spanned;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use slipgrid_infer::calibrate::area_law::table_warnings;
use slipgrid_model::material::{
    AreaLaw, Condition, ConditionFriction, Elastic, Friction, LocalFriction, Material, MaterialError, Provenance,
};

use super::document::Document;
use super::file_kind::FileKind;
use super::learned::LearnedFile;
use super::made_from::MadeFrom;
use super::values::{Number, NumberList, Numbers, for_each, increasing, list};
use crate::formats::diagnostic::Diagnostic;
use crate::formats::source::Entry;
use slipgrid_base::units::{
    DENSITY_G_CM3, EXCESS, FACTOR, FACTOR_STD, FRACTION, FRICTION, FRICTION_STD, HUMIDITY_PCT, LENGTH_UM, MODULUS_GPA,
    MODULUS_STD_GPA, POISSON, PRESSURE_MPA, RELATIVE_STD, SLOPE, SPEED_MM_S, significant_to, tidy,
};

/// Default scatter of the local coefficients: 5 %, as in the paper.
pub const DEFAULT_RELATIVE_STD: f64 = 0.05;
/// Default ratio mu_s / mu_d if no static friction was measured: 0.30 / 0.27, as in the paper.
pub const DEFAULT_STATIC_OVER_DYNAMIC: f64 = 0.30 / 0.27;

/// A material in the form of its file.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MaterialFile {
    /// The material's name.
    pub name: Option<String>,
    /// Publication or laboratory.
    pub source: Option<String>,
    /// Schema of the file; 1 when absent.
    pub schema: Option<Spanned<u32>>,
    /// Version of the program that wrote the file.
    pub slipgrid_version: Option<String>,
    /// The surface behind the area law is synthetic, not measured; false when absent.
    pub synthetic_surface: Option<bool>,
    /// Provenance of the values.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// Warnings of doubtful results that depend on the material; each begins with its name.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
    /// Young's modulus.
    pub youngs_modulus_gpa: Number,
    /// Standard deviation of Young's modulus.
    pub youngs_modulus_std_gpa: Option<Number>,
    /// Density.
    pub density_g_cm3: Number,
    /// Contact pressure at which rims flatten permanently; absent where they are elastic.
    pub yield_pressure_mpa: Option<Number>,
    /// Local friction coefficients.
    pub friction: Spanned<FrictionFile>,
    /// Area law; absent for Amontons-Coulomb.
    pub area_law: Option<Spanned<AreaLawFile>>,
    /// Dynamic friction of flat samples as measured, per condition. If it contradicts the area law, there is no
    /// evidence whether friction follows the local or the nominal pressure.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub flat_friction: Vec<Spanned<FlatFrictionTable>>,
    /// One factor for every texture, written by earlier versions; it is ignored.
    #[serde(default, skip_serializing)]
    #[schemars(with = "Option<serde_json::Map<String, serde_json::Value>>")]
    pub discrepancy: Option<toml::Table>,
    /// Discrepancy learned from trials, for any texture.
    pub learned: Option<Spanned<LearnedFile>>,
    /// The calibration from which the file was made.
    pub made_from: Option<MadeFrom>,
}

/// Local friction coefficients in the form of a file: one pair, one pair per pressure, or tables per condition.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FrictionFile {
    /// Nominal pressures of the coefficients; absent for one pair.
    pub pressure_mpa: Option<NumberList>,
    /// Mean local static coefficient.
    pub static_mean: Option<Spanned<Numbers>>,
    /// Mean local dynamic coefficient.
    pub dynamic_mean: Option<Spanned<Numbers>>,
    /// Relative scatter of both coefficients; 0.05 when absent.
    pub relative_std: Option<Number>,
    /// Standard errors of `static_mean`.
    pub static_std_error: Option<Spanned<Numbers>>,
    /// Standard errors of `dynamic_mean`, including those of Young's modulus and the area law. Without
    /// `dynamic_std_error_given_law` they hold at the given law.
    pub dynamic_std_error: Option<Spanned<Numbers>>,
    /// Standard errors of `dynamic_mean` at the given area law: those of flat friction.
    pub dynamic_std_error_given_law: Option<Spanned<Numbers>>,
    /// Dynamic friction of the flat sample over mu_d f(P), the friction of an endless flat sample in steady sliding.
    pub dynamic_over_steady: Option<Spanned<Numbers>>,
    /// Model minus measurement of the flat sample, one per measurement.
    pub residual: Option<Vec<f64>>,
    /// Covariance of `dynamic_mean` and of the logarithm of the area law's pressure scale, if the scale was fitted.
    pub scale_covariance: Option<Spanned<Vec<Vec<f64>>>>,
    /// Coefficients per condition.
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
    /// Mean local static coefficients.
    pub static_mean: Spanned<Numbers>,
    /// Mean local dynamic coefficients.
    pub dynamic_mean: Spanned<Numbers>,
    /// Standard errors of `static_mean`.
    pub static_std_error: Option<Spanned<Numbers>>,
    /// Standard errors of `dynamic_mean`, including those of Young's modulus and the area law. Without
    /// `dynamic_std_error_given_law` they hold at the given law.
    pub dynamic_std_error: Option<Spanned<Numbers>>,
    /// Standard errors of `dynamic_mean` at the given area law: those of flat friction.
    pub dynamic_std_error_given_law: Option<Spanned<Numbers>>,
    /// Dynamic friction of the flat sample over mu_d f(P), the friction of an endless flat sample in steady sliding.
    pub dynamic_over_steady: Option<Spanned<Numbers>>,
    /// Model minus measurement of the flat sample, one per pressure.
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

/// An area law in the form of a file.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AreaLawFile {
    /// Source of the law: `map`, `persson`, `fit`, or `measured` for flat friction itself.
    pub origin: Option<String>,
    /// Rms slope of the map from which the law was computed.
    pub rms_slope: Option<Number>,
    /// Arithmetic mean height of the map.
    pub sa_um: Option<Number>,
    /// Pixel size of the map along the sliding direction.
    pub pixel_um: Option<Number>,
    /// Pixel size of the map across the sliding direction; as along it when absent.
    pub pixel_y_um: Option<Number>,
    /// Poisson's ratio of the contact computation.
    pub poisson_ratio: Option<Number>,
    /// Tabulated pressures.
    pub pressure_mpa: NumberList,
    /// Factors f.
    pub factor: NumberList,
    /// Standard errors of the factors, from windows of the map.
    pub factor_std: Option<NumberList>,
    /// Real contact area fractions behind the factors.
    pub area_fraction: Option<NumberList>,
}

/// Speed and humidity that select coefficients.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConditionFile {
    /// Sliding speed.
    pub speed_mm_s: Number,
    /// Relative humidity.
    pub humidity_pct: Number,
}

/// Reads a condition.
///
/// # Errors
/// [`Diagnostic`] for numbers out of range.
pub fn read_condition(document: &Document, condition: &ConditionFile) -> Result<Condition, Diagnostic> {
    Ok(Condition {
        speed_m_s: document.number(&condition.speed_mm_s, SPEED_MM_S)?,
        humidity: document.number(&condition.humidity_pct, HUMIDITY_PCT)?,
    })
}

/// Path of a file that a key names, relative to its document.
///
/// # Errors
/// [`Diagnostic`] at the key if the file does not exist.
pub fn existing<T>(document: &Document, key: &Spanned<T>, path: &str) -> Result<std::path::PathBuf, Diagnostic> {
    let path = document.resolve(path);
    match document.source().entry(&path) {
        Ok(Entry::File) => Ok(path),
        Ok(_) => Err(document
            .refuse(key.span(), format!("({}) is not a file", path.display()))
            .expected("the path of a file, relative to this one")),
        Err(error) => Err(document
            .refuse(key.span(), format!("({}) cannot be read: {error}", path.display()))
            .expected("the path of a file, relative to this one")),
    }
}

/// Converts a material from its file form to the validated one.
///
/// # Errors
/// [`Diagnostic`] for any refused input.
pub fn read_material(
    document: &Document,
    file: &MaterialFile,
    place: &std::ops::Range<usize>,
) -> Result<Material, Diagnostic> {
    let youngs_modulus_pa = document.number(&file.youngs_modulus_gpa, MODULUS_GPA)?;
    document.optional(file.youngs_modulus_std_gpa.as_ref(), MODULUS_STD_GPA)?;
    check_modulus_std(document, *file.youngs_modulus_gpa.get_ref(), file.youngs_modulus_std_gpa.as_ref())?;
    let density_kg_m3 = document.number(&file.density_g_cm3, DENSITY_G_CM3)?;
    let yield_pressure_pa = document.optional(file.yield_pressure_mpa.as_ref(), PRESSURE_MPA)?;
    let elastic = Elastic::new(youngs_modulus_pa, density_kg_m3)
        .and_then(|elastic| elastic.with_yield_pressure_pa(yield_pressure_pa))
        .map_err(|error| at(document, place, &error))?;
    let friction = read_friction(document, &file.friction)?;
    let area_law = file.area_law.as_ref().map(|law| read_area_law(document, law)).transpose()?;
    let mut warnings = file.warnings.clone();
    // Warnings that the file states about its law are not repeated.
    let named = |warning: &str| warning.split(':').next().map(str::to_owned);
    let told = |warning: &String| file.warnings.iter().any(|known| named(known) == named(warning));
    // A measured law may rise with pressure, because it is not one of contact area.
    let is_measured = file.area_law.as_ref().is_some_and(|law| law.get_ref().origin.as_deref() == Some("measured"));
    warnings.extend(area_law.iter().filter(|_| !is_measured).flat_map(table_warnings).filter(|warning| !told(warning)));
    let mut notes = file.notes.clone();
    if file.discrepancy.is_some() {
        notes.push(OUTDATED_DISCREPANCY.to_owned());
    }
    Ok(Material {
        elastic,
        friction,
        area_law,
        provenance: Provenance {
            name: file.name.clone().unwrap_or_default(),
            source: file.source.clone().unwrap_or_default(),
            synthetic_surface: file.synthetic_surface.unwrap_or(false),
            notes,
            warnings,
        },
    })
}

/// Refuses a standard deviation of Young's modulus that is not below the modulus, because such a modulus determines
/// nothing.
pub(crate) fn check_modulus_std(document: &Document, modulus_gpa: f64, std: Option<&Number>) -> Result<(), Diagnostic> {
    let Some(std) = std.filter(|std| *std.get_ref() >= modulus_gpa) else { return Ok(()) };
    let reason = format!("leaves Young's modulus of {modulus_gpa} GPa open altogether");
    Err(document.refuse(std.span(), reason).expected("a standard deviation below the modulus, in GPa"))
}

/// Warning about a table of earlier versions.
const OUTDATED_DISCREPANCY: &str = "[discrepancy] of the material file is not used: it is one factor whatever the texture, as earlier \
                                    versions wrote it; `slipgrid calibrate` writes [learned], what trials say of every texture";

fn at(document: &Document, place: &std::ops::Range<usize>, error: &MaterialError) -> Diagnostic {
    document.refuse(place.clone(), error.to_string())
}

fn read_friction(document: &Document, file: &Spanned<FrictionFile>) -> Result<Friction, Diagnostic> {
    let (place, friction) = (file.span(), file.get_ref());
    let relative_std = friction
        .relative_std
        .as_ref()
        .map_or(Ok(DEFAULT_RELATIVE_STD), |relative_std| document.number(relative_std, RELATIVE_STD))?;
    let local = |static_mean: f64, dynamic_mean: f64| {
        LocalFriction::new(static_mean, dynamic_mean, relative_std).map_err(|error| at(document, &place, &error))
    };
    let errors = [&friction.static_std_error, &friction.dynamic_std_error, &friction.dynamic_std_error_given_law];
    for errors in errors.into_iter().flatten() {
        list(document, errors, FRICTION_STD)?;
    }
    if let Some(excess) = &friction.dynamic_over_steady {
        list(document, excess, EXCESS)?;
    }
    if !friction.conditions.is_empty() {
        refuse_beside_conditions(document, friction)?;
        return read_conditions(document, &friction.conditions, local);
    }
    let static_mean = friction.static_mean.as_ref().ok_or_else(|| document.missing(file.span(), "static_mean"))?;
    let dynamic_mean = friction.dynamic_mean.as_ref().ok_or_else(|| document.missing(file.span(), "dynamic_mean"))?;
    let Some(pressures) = &friction.pressure_mpa else {
        for mean in [static_mean, dynamic_mean] {
            if matches!(mean.get_ref(), Numbers::Each(_)) {
                return Err(document
                    .refuse(mean.span(), "is a list without pressures")
                    .expected("one number, or `pressure_mpa` beside it, one for each coefficient"));
            }
        }
        let (static_mean, dynamic_mean) =
            (list(document, static_mean, FRICTION)?[0], list(document, dynamic_mean, FRICTION)?[0]);
        return Ok(Friction::Single(local(static_mean, dynamic_mean)?));
    };
    let pressure_pa = increasing(document, pressures, PRESSURE_MPA)?;
    let static_mean = for_each(document, static_mean, FRICTION, pressure_pa.len(), "pressure")?;
    let dynamic_mean = for_each(document, dynamic_mean, FRICTION, pressure_pa.len(), "pressure")?;
    let mut rows = Vec::new();
    for ((&pressure_pa, &static_mean), &dynamic_mean) in pressure_pa.iter().zip(&static_mean).zip(&dynamic_mean) {
        rows.push(ConditionFriction { pressure_pa, condition: None, friction: local(static_mean, dynamic_mean)? });
    }
    Ok(Friction::PerCondition(rows))
}

/// Refuses coefficients, and keys that belong to them, in addition to coefficients per condition, because they would be
/// ignored.
fn refuse_beside_conditions(document: &Document, friction: &FrictionFile) -> Result<(), Diagnostic> {
    let numbers = [
        ("static_mean", &friction.static_mean),
        ("dynamic_mean", &friction.dynamic_mean),
        ("static_std_error", &friction.static_std_error),
        ("dynamic_std_error", &friction.dynamic_std_error),
        ("dynamic_std_error_given_law", &friction.dynamic_std_error_given_law),
        ("dynamic_over_steady", &friction.dynamic_over_steady),
    ];
    let mut stray = numbers.map(|(key, numbers)| (key, numbers.as_ref().map(Spanned::span))).to_vec();
    stray.push(("pressure_mpa", friction.pressure_mpa.as_ref().map(Spanned::span)));
    stray.push(("scale_covariance", friction.scale_covariance.as_ref().map(Spanned::span)));
    let found = stray.into_iter().find_map(|(key, place)| Some((key, place?)));
    let Some((key, place)) = found else { return Ok(()) };
    let expected = match key {
        "static_mean" | "dynamic_mean" => "either static_mean and dynamic_mean, or [[friction.conditions]]".to_owned(),
        "scale_covariance" => {
            "scale_covariance beside one dynamic_mean, or [[friction.conditions]] without it".to_owned()
        }
        _ => format!("{key} in each of the tables [[friction.conditions]], or no such table"),
    };
    Err(document.refuse(place, "stands beside coefficients per condition").expected(expected))
}

fn read_conditions(
    document: &Document,
    tables: &[Spanned<ConditionTable>],
    local: impl Fn(f64, f64) -> Result<LocalFriction, Diagnostic>,
) -> Result<Friction, Diagnostic> {
    let mut rows: Vec<ConditionFriction> = Vec::new();
    for spanned in tables {
        let table = spanned.get_ref();
        let condition = Condition {
            speed_m_s: document.number(&table.speed_mm_s, SPEED_MM_S)?,
            humidity: document.number(&table.humidity_pct, HUMIDITY_PCT)?,
        };
        if rows.iter().any(|row| row.condition.is_some_and(|other| other.matches(&condition))) {
            return Err(document
                .refuse(table.speed_mm_s.span(), "and this humidity occur a second time")
                .expected("one table per condition"));
        }
        let pressure_pa = increasing(document, &table.pressure_mpa, PRESSURE_MPA)?;
        let count = pressure_pa.len();
        let static_mean = for_each(document, &table.static_mean, FRICTION, count, "pressure")?;
        let dynamic_mean = for_each(document, &table.dynamic_mean, FRICTION, count, "pressure")?;
        let errors = [&table.static_std_error, &table.dynamic_std_error, &table.dynamic_std_error_given_law];
        for errors in errors.into_iter().flatten() {
            for_each(document, errors, FRICTION_STD, count, "pressure")?;
        }
        if let Some(excess) = &table.dynamic_over_steady {
            for_each(document, excess, EXCESS, count, "pressure")?;
        }
        for row in 0..count {
            rows.push(ConditionFriction {
                pressure_pa: pressure_pa[row],
                condition: Some(condition),
                friction: local(static_mean[row], dynamic_mean[row])?,
            });
        }
    }
    Ok(Friction::PerCondition(rows))
}

/// Relative decrease that is allowed in tabulated contact area: tables are written with three digits or more.
const AREA_TOLERANCE: f64 = 5e-3;

fn read_area_law(document: &Document, file: &Spanned<AreaLawFile>) -> Result<AreaLaw, Diagnostic> {
    let law = file.get_ref();
    let pressure_pa = increasing(document, &law.pressure_mpa, PRESSURE_MPA)?;
    let factor = document.numbers(&law.factor, FACTOR)?;
    // A scene would end with the status `no_friction`, and a design would have nothing to search.
    let nil = law.factor.get_ref().iter().find(|factor| *factor.get_ref() <= 0.0);
    if let Some(nil) = nil.filter(|_| document.is_meant_as(FileKind::Design)) {
        return Err(document
            .refuse(nil.span(), "leaves no contact and no friction, and nothing to compare a pattern with")
            .expected("a positive factor at every pressure"));
    }
    let same_length = |list: &NumberList| {
        if list.get_ref().len() == pressure_pa.len() {
            return Ok(());
        }
        Err(document
            .refuse(list.span(), format!("has {} values", list.get_ref().len()))
            .expected(format!("{}, one for each pressure", pressure_pa.len())))
    };
    same_length(&law.factor)?;
    if law.origin.as_deref() != Some("measured") {
        refuse_falling_area(document, &law.factor, &pressure_pa, &factor)?;
    }
    for (about, quantity) in [
        (&law.rms_slope, SLOPE),
        (&law.sa_um, LENGTH_UM),
        (&law.pixel_um, LENGTH_UM),
        (&law.pixel_y_um, LENGTH_UM),
        (&law.poisson_ratio, POISSON),
    ] {
        document.optional(about.as_ref(), quantity)?;
    }
    if let Some(area_fraction) = &law.area_fraction {
        document.numbers(area_fraction, FRACTION)?;
        same_length(area_fraction)?;
    }
    let law_of = |error: MaterialError| at(document, &file.span(), &error);
    let Some(factor_std) = &law.factor_std else {
        return AreaLaw::new(pressure_pa, factor).map_err(law_of);
    };
    same_length(factor_std)?;
    let factor_std = document.numbers(factor_std, FACTOR_STD)?;
    AreaLaw::new(pressure_pa, factor).and_then(|law| law.with_factor_std(factor_std)).map_err(law_of)
}

/// Refuses factors by which contact area decreases from one pressure to the next: area is proportional to P f(P).
fn refuse_falling_area(
    document: &Document,
    file: &NumberList,
    pressure_pa: &[f64],
    factor: &[f64],
) -> Result<(), Diagnostic> {
    let area: Vec<f64> = pressure_pa.iter().zip(factor).map(|(pressure_pa, factor)| pressure_pa * factor).collect();
    let falls = |pair: &[f64]| pair[1] < (1.0 - AREA_TOLERANCE) * pair[0];
    let Some(place) = area.windows(2).position(falls) else { return Ok(()) };
    let [from_mpa, to_mpa] = [place, place + 1].map(|place| tidy(PRESSURE_MPA.from_si(pressure_pa[place])));
    let least = significant_to(factor[place] * pressure_pa[place] / pressure_pa[place + 1], 3, f64::ceil);
    let reason = format!(
        "makes contact area fall to {:.2} times from {from_mpa} to {to_mpa} MPa; real contact area never falls with pressure",
        area[place + 1] / area[place]
    );
    let span = file.get_ref().get(place + 1).map_or(file.span(), Spanned::span);
    Err(document.refuse(span, reason).expected(format!("a factor of at least {least} at {to_mpa} MPa")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_belongs_to_one_pair_of_coefficients_is_refused_beside_coefficients_per_condition() {
        let table = "[[friction.conditions]]\nspeed_mm_s = 2.0\nhumidity_pct = 15.0\npressure_mpa = [0.7]\nstatic_mean = 0.3\n\
                     dynamic_mean = 0.25\n";
        let read = |line: &str| {
            let text = format!(
                "youngs_modulus_gpa = 0.4\ndensity_g_cm3 = 0.9\n[friction]\nrelative_std = 0.05\n{line}\n{table}"
            );
            let document = Document::new("m.toml", text);
            read_material(&document, &document.parse().unwrap(), &(0..0)).map_err(|refused| refused.to_string())
        };
        assert!(read("").is_ok());
        for (line, key) in [
            ("static_mean = 0.3", "static_mean"),
            ("pressure_mpa = [0.7, 2.6]", "pressure_mpa"),
            ("static_std_error = 0.01", "static_std_error"),
            ("dynamic_std_error = 0.01", "dynamic_std_error"),
            ("dynamic_std_error_given_law = 0.01", "dynamic_std_error_given_law"),
            ("dynamic_over_steady = 1.0", "dynamic_over_steady"),
            ("scale_covariance = [[1e-4, 0.0], [0.0, 1e-4]]", "scale_covariance"),
        ] {
            let refused = read(line).unwrap_err();
            assert!(refused.starts_with(&format!("m.toml:5: friction.{key}: ")), "{refused}");
            assert!(refused.contains("stands beside coefficients per condition; expected"), "{refused}");
        }
    }
}
