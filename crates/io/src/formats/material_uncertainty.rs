//! Uncertainty of a material, as its file states it.

use crate::formats::spanned::Spanned;
use slipgrid_infer::calibrate::uncertainty::{CoefficientEstimate, MaterialUncertainty};
use slipgrid_infer::calibrate::{contradicting_samples, is_of_contradicting_samples};
use slipgrid_model::material::{Condition, Material};

use super::document::Document;
use super::file_kind::FileKind;
use super::learned::LearnedFile;
use super::material::{ConditionTable, FlatFrictionTable, FrictionFile, MaterialFile, existing, read_material};
use super::values::{NumberList, Numbers, PathOr, for_each, increasing};
use crate::formats::diagnostic::Diagnostic;
use slipgrid_base::units::{
    EXCESS, FRICTION, FRICTION_STD, HUMIDITY_PCT, MODULUS_GPA, MODULUS_STD_GPA, PRESSURE_MPA, SPEED_MM_S,
};

/// Reads the material and its uncertainty from `file` in `document`; `place` is the span of the whole table.
///
/// # Errors
/// [`Diagnostic`] for any refused input.
pub fn read_known(
    document: &Document,
    file: &MaterialFile,
    place: &std::ops::Range<usize>,
) -> Result<(Material, MaterialUncertainty), Diagnostic> {
    document.check_schema(file.schema.as_ref())?;
    let (mut material, uncertainty) = (read_material(document, file, place)?, read_uncertainty(document, file)?);
    let warnings = &mut material.provenance.warnings;
    // Files of earlier versions do not state this warning themselves.
    if !warnings.iter().any(|warning| is_of_contradicting_samples(warning)) {
        warnings.extend(uncertainty.learned.iter().flat_map(contradicting_samples));
    }
    Ok((material, uncertainty))
}

/// Reads the material and its uncertainty from the table or file that a key of `document` gives.
///
/// # Errors
/// [`Diagnostic`] if a file cannot be read, or for any refused input.
pub fn read_referenced(
    document: &Document,
    material: &Spanned<PathOr<MaterialFile>>,
) -> Result<(Material, MaterialUncertainty), Diagnostic> {
    match material.get_ref() {
        PathOr::Table(table) => read_known(document, table, &material.span()),
        PathOr::Path(path) => {
            let named = Document::read(document.source(), &existing(document, material, path)?, FileKind::Material)?;
            read_known(&named, &named.parse()?, &(0..0))
        }
    }
}

fn read_uncertainty(document: &Document, file: &MaterialFile) -> Result<MaterialUncertainty, Diagnostic> {
    let modulus_pa = document.number(&file.youngs_modulus_gpa, MODULUS_GPA)?;
    let modulus_std_pa = document.optional(file.youngs_modulus_std_gpa.as_ref(), MODULUS_STD_GPA)?;
    let origin = file.area_law.as_ref().and_then(|law| law.get_ref().origin.as_deref());
    Ok(MaterialUncertainty {
        friction: friction_errors(document, file.friction.get_ref(), Column::Dynamic)?,
        static_friction: friction_errors(document, file.friction.get_ref(), Column::Static)?,
        dynamic_over_steady: friction_errors(document, file.friction.get_ref(), Column::Excess)?,
        has_marginal_errors: {
            let friction = file.friction.get_ref();
            let tables = friction.conditions.iter().map(|table| &table.get_ref().dynamic_std_error_given_law);
            tables.chain([&friction.dynamic_std_error_given_law]).any(Option::is_some)
        },
        modulus_relative_std: modulus_std_pa.map(|std_pa| std_pa / modulus_pa),
        law_is_fitted: origin == Some("fit"),
        law_is_measured: origin == Some("measured"),
        scale_covariance: scale_covariance(document, file.friction.get_ref())?,
        flat_friction: flat_friction(document, &file.flat_friction)?,
        learned: file.learned.as_ref().map(|table| LearnedFile::read(document, table)).transpose()?,
    })
}

/// Friction of flat samples as measured. Its standard errors are stored with the coefficients.
fn flat_friction(
    document: &Document,
    tables: &[Spanned<FlatFrictionTable>],
) -> Result<Vec<CoefficientEstimate>, Diagnostic> {
    let mut all = Vec::new();
    for table in tables {
        let table = table.get_ref();
        let condition = Condition {
            speed_m_s: document.number(&table.speed_mm_s, SPEED_MM_S)?,
            humidity: document.number(&table.humidity_pct, HUMIDITY_PCT)?,
        };
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

/// Column that is read together with a mean coefficient.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Column {
    /// Standard errors of the static coefficients.
    Static,
    /// Standard errors of the dynamic coefficients at the given area law, equal to those of flat friction.
    Dynamic,
    /// Dynamic over steady friction.
    Excess,
}

/// Mean static or dynamic coefficients, together with one further column.
fn friction_errors(
    document: &Document,
    file: &FrictionFile,
    column: Column,
) -> Result<Vec<CoefficientEstimate>, Diagnostic> {
    let mut errors = Vec::new();
    for table in &file.conditions {
        let table: &ConditionTable = table.get_ref();
        let condition = Condition {
            speed_m_s: document.number(&table.speed_mm_s, SPEED_MM_S)?,
            humidity: document.number(&table.humidity_pct, HUMIDITY_PCT)?,
        };
        let (mean, beside) = match column {
            Column::Static => (&table.static_mean, &table.static_std_error),
            Column::Dynamic if table.dynamic_std_error_given_law.is_some() => {
                (&table.dynamic_mean, &table.dynamic_std_error_given_law)
            }
            Column::Dynamic => (&table.dynamic_mean, &table.dynamic_std_error),
            Column::Excess => (&table.dynamic_mean, &table.dynamic_over_steady),
        };
        let Some(beside) = beside else { continue };
        errors.extend(rows(document, Some(&table.pressure_mpa), mean, (beside, column), Some(condition))?);
    }
    let (mean, beside) = match column {
        Column::Static => (&file.static_mean, &file.static_std_error),
        Column::Dynamic if file.dynamic_std_error_given_law.is_some() => {
            (&file.dynamic_mean, &file.dynamic_std_error_given_law)
        }
        Column::Dynamic => (&file.dynamic_mean, &file.dynamic_std_error),
        Column::Excess => (&file.dynamic_mean, &file.dynamic_over_steady),
    };
    if let (Some(mean), Some(beside)) = (mean, beside) {
        errors.extend(rows(document, file.pressure_mpa.as_ref(), mean, (beside, column), None)?);
    }
    Ok(errors)
}

fn rows(
    document: &Document,
    pressures: Option<&NumberList>,
    mean: &Spanned<Numbers>,
    (beside, column): (&Spanned<Numbers>, Column),
    condition: Option<Condition>,
) -> Result<Vec<CoefficientEstimate>, Diagnostic> {
    let pressures_pa = pressures.map(|list| increasing(document, list, PRESSURE_MPA)).transpose()?;
    let count = pressures_pa.as_ref().map_or(1, Vec::len);
    let means = for_each(document, mean, FRICTION, count, "pressure")?;
    let range = if column == Column::Excess { EXCESS } else { FRICTION_STD };
    let errors = for_each(document, beside, range, count, "pressure")?;
    let row = |place: usize| {
        let (value, std_error) =
            if column == Column::Excess { (errors[place], 0.0) } else { (means[place], errors[place]) };
        let pressure_pa = pressures_pa.as_ref().map(|list| list[place]);
        CoefficientEstimate { pressure_pa, condition, value, std_error }
    };
    Ok((0..count).map(row).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(friction: &str, more: &str) -> MaterialUncertainty {
        let text = format!(
            "youngs_modulus_gpa = 0.4\nyoungs_modulus_std_gpa = 0.1\ndensity_g_cm3 = 0.9\n[friction]\n{friction}\n{more}"
        );
        let document = Document::new("m.toml", text);
        read_uncertainty(&document, &document.parse().unwrap()).unwrap()
    }

    #[test]
    fn one_pair_is_off_alike_at_every_load() {
        let known = read("static_mean = 0.3\ndynamic_mean = 0.25\ndynamic_std_error = 0.005", "");
        let covariance = known.friction_covariance(&[1e6, 2e6], &[None]).unwrap();
        assert!(covariance.iter().flatten().all(|entry| (entry - 4e-4).abs() < 1e-15), "{covariance:?}");
        assert_eq!((known.modulus_relative_std, known.law_is_fitted), (Some(0.25), false));
        assert_eq!(known.discrepancy().unwrap().trials(), []);
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
        for wrong in ["[[1.0]]", "[[1e-4, 1.0], [1.0, 1e-4]]", "[[1e-4, 0.0], [1e-5, 1e-4]]"] {
            let text = format!(
                "youngs_modulus_gpa = 0.4\ndensity_g_cm3 = 0.9\n[friction]\n{single}scale_covariance = {wrong}\n"
            );
            let document = Document::new("m.toml", text);
            let refused = read_uncertainty(&document, &document.parse().unwrap()).unwrap_err().to_string();
            assert!(refused.contains("scale_covariance"), "{refused}");
        }
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
