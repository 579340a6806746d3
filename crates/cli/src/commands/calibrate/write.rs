//! The material file that a calibration writes.

use slipgrid_material::Condition;
use toml::Spanned;

use super::discrepancy::Report;
use super::{CalibrationInput, Fit, FittedPair, SurfaceFacts};
use crate::CliError;
use slipgrid_formats::calibration::{Calibration, Coefficients};
use slipgrid_formats::material::{AreaLawFile, ConditionTable, FrictionFile, MaterialFile};
use slipgrid_formats::values::{Numbers, number, number_list};
use slipgrid_results::VERSION;
use slipgrid_units::{DENSITY_G_CM3, HUMIDITY_PCT, LENGTH_UM, MODULUS_GPA, PRESSURE_MPA, SPEED_MM_S, tidy};

/// The material as TOML.
///
/// # Errors
/// [`CliError::Other`] if the fit has not one pair, or one pair per measurement.
pub fn material_toml(
    calibration: &Calibration,
    input: &CalibrationInput,
    facts: &SurfaceFacts,
    fit: &Fit,
    discrepancy: Option<&Report>,
) -> Result<String, CliError> {
    let mut notes = fit.notes.clone();
    notes.extend(facts.notes.iter().cloned());
    notes.extend(calibration.told.iter().cloned());
    notes.extend(slipgrid_formats::traces::notes(&calibration.traces));
    notes.extend(discrepancy.map(Report::note));
    if facts.synthetic {
        notes.push("the area law rests on a synthetic surface, not on a measured one".to_owned());
    }
    let file = MaterialFile {
        name: Some(calibration.name.clone()),
        source: Some(calibration.source.clone()),
        slipgrid_version: Some(VERSION.to_owned()),
        synthetic_surface: Some(facts.synthetic),
        notes,
        warnings: facts.warnings.clone(),
        youngs_modulus_gpa: number(MODULUS_GPA.from_si(calibration.elastic.youngs_modulus_pa())),
        youngs_modulus_std_gpa: calibration.youngs_modulus_std_pa.map(|std_pa| number(MODULUS_GPA.from_si(std_pa))),
        density_g_cm3: number(DENSITY_G_CM3.from_si(calibration.elastic.density_kg_m3())),
        friction: unplaced(friction(calibration, fit)?),
        area_law: input.area_law.as_ref().map(|law| {
            let area = |&pressure_pa: &f64| {
                let listed = facts.curve.iter().find(|point| point.pressure_pa == pressure_pa);
                listed.map(|point| tidy(point.area_fraction_corrected))
            };
            let areas: Option<Vec<f64>> = law.pressures_pa().iter().map(area).collect();
            unplaced(AreaLawFile {
                origin: facts.origin.map(str::to_owned),
                rms_slope: facts.rms_slope.map(|slope| number(tidy(slope))),
                sa_um: facts.sa_m.map(|sa_m| number(LENGTH_UM.from_si(sa_m))),
                pixel_um: facts.pixel_m.map(|pixel_m| number(LENGTH_UM.from_si(pixel_m))),
                poisson_ratio: Some(number(tidy(calibration.poisson_ratio))),
                pressure_mpa: number_list(law.pressures_pa().iter().map(|&p| PRESSURE_MPA.from_si(p))),
                factor: number_list(law.factors().iter().map(|&factor| tidy(factor))),
                factor_std: law.factor_std().map(|std| number_list(std.iter().map(|&std| tidy(std)))),
                area_fraction: areas.map(number_list),
            })
        }),
        discrepancy: discrepancy.map(Report::file),
    };
    let body =
        toml::to_string(&file).map_err(|error| CliError::Other(format!("the material has no TOML form: {error}")))?;
    Ok(format!(
        "# Material, by slipgrid calibrate {VERSION}. Scenes and designs name this file: material = \"...\".\n\
         # residual: model minus measured dynamic friction of the flat sample.\n{body}"
    ))
}

/// A residual without what is rounding of the fit.
fn rounded(residual: f64) -> f64 {
    (residual * 1e9).round() / 1e9 + 0.0
}

fn friction(calibration: &Calibration, fit: &Fit) -> Result<FrictionFile, CliError> {
    let relative_std = Some(number(calibration.relative_std));
    match (calibration.coefficients, &fit.pairs[..]) {
        (Coefficients::Single, [pair]) => Ok(FrictionFile {
            static_mean: Some(unplaced(Numbers::One(tidy(pair.static_mean)))),
            dynamic_mean: Some(unplaced(Numbers::One(tidy(pair.dynamic_mean)))),
            static_std_error: pair.static_std_error.map(|error| unplaced(Numbers::One(tidy(error)))),
            dynamic_std_error: pair.dynamic_std_error.map(|error| unplaced(Numbers::One(tidy(error)))),
            dynamic_std_error_given_law: pair
                .dynamic_std_error_given_law
                .map(|error| unplaced(Numbers::One(tidy(error)))),
            dynamic_over_steady: mean(&fit.dynamic_over_steady).map(|excess| unplaced(Numbers::One(excess))),
            relative_std,
            residual: Some(fit.residuals.iter().copied().map(rounded).collect()),
            scale_covariance: fit.details.scale_covariance(pair.dynamic_std_error).map(unplaced),
            ..FrictionFile::default()
        }),
        (Coefficients::PerCondition, pairs)
            if pairs.len() == calibration.flat.len()
                && fit.residuals.len() == pairs.len()
                && fit.dynamic_over_steady.len() == pairs.len() =>
        {
            let conditions = conditions(calibration, fit)
                .into_iter()
                .map(|(condition, rows)| unplaced(condition_table(condition, &rows)))
                .collect();
            Ok(FrictionFile { relative_std, conditions, ..FrictionFile::default() })
        }
        (_, pairs) => Err(CliError::Other(format!("the fit returned {} pairs of coefficients", pairs.len()))),
    }
}

/// A measurement's pressure with what was fitted to it.
#[derive(Clone, Copy)]
struct Row {
    pressure_pa: f64,
    pair: FittedPair,
    residual: f64,
    dynamic_over_steady: f64,
}

/// The mean to five digits: runs are known to a thousandth. `None` of nothing.
fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| digits(values.iter().sum::<f64>() / values.len() as f64))
}

fn digits(excess: f64) -> f64 {
    (excess * 1e5).round() / 1e5
}

/// Rows by speed and humidity in the order of the measurements, each by pressure.
fn conditions(calibration: &Calibration, fit: &Fit) -> Vec<(Condition, Vec<Row>)> {
    let mut conditions: Vec<(Condition, Vec<Row>)> = Vec::new();
    let found = fit.pairs.iter().zip(&fit.residuals).zip(&fit.dynamic_over_steady);
    for (measured, ((&pair, &residual), &excess)) in calibration.flat.iter().zip(found) {
        let condition = Condition { speed_m_s: measured.speed_m_s, humidity: measured.humidity };
        let pressure_pa = calibration.pressure_pa(measured.force_n);
        let row = Row { pressure_pa, pair, residual, dynamic_over_steady: digits(excess) };
        match conditions.iter_mut().find(|(other, _)| other.matches(&condition)) {
            Some((_, rows)) => rows.push(row),
            None => conditions.push((condition, vec![row])),
        }
    }
    for (_, rows) in &mut conditions {
        rows.sort_by(|a, b| a.pressure_pa.total_cmp(&b.pressure_pa));
    }
    conditions
}

fn condition_table(condition: Condition, rows: &[Row]) -> ConditionTable {
    let column =
        |value: fn(&Row) -> f64| unplaced(Numbers::Each(rows.iter().map(|row| number(tidy(value(row)))).collect()));
    let errors = |value: fn(&FittedPair) -> Option<f64>| {
        let errors: Option<Vec<f64>> = rows.iter().map(|row| value(&row.pair).map(tidy)).collect();
        errors.map(|errors| unplaced(Numbers::Each(errors.into_iter().map(number).collect())))
    };
    ConditionTable {
        speed_mm_s: number(SPEED_MM_S.from_si(condition.speed_m_s)),
        humidity_pct: number(HUMIDITY_PCT.from_si(condition.humidity)),
        pressure_mpa: number_list(rows.iter().map(|row| PRESSURE_MPA.from_si(row.pressure_pa))),
        static_mean: column(|row| row.pair.static_mean),
        dynamic_mean: column(|row| row.pair.dynamic_mean),
        static_std_error: errors(|pair| pair.static_std_error),
        dynamic_std_error: errors(|pair| pair.dynamic_std_error),
        dynamic_std_error_given_law: errors(|pair| pair.dynamic_std_error_given_law),
        dynamic_over_steady: Some(column(|row| row.dynamic_over_steady)),
        residual: Some(rows.iter().map(|row| rounded(row.residual)).collect()),
    }
}

fn unplaced<T>(value: T) -> Spanned<T> {
    Spanned::new(0..0, value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::commands::calibrate::details::FitDetails;
    use slipgrid_formats::Document;
    use slipgrid_formats::material::read_material;
    use slipgrid_formats::measurements::Measurement;
    use slipgrid_formats::surface::Surface;
    use slipgrid_material::{AreaLaw, Elastic, Friction};

    fn measurement(force_n: f64, humidity: f64) -> Measurement {
        Measurement {
            force_n,
            speed_m_s: 2e-3,
            humidity,
            mu_dynamic: 0.25,
            mu_dynamic_std: 0.002,
            mu_static: None,
            mu_static_std: None,
        }
    }

    fn calibration(coefficients: Coefficients) -> Calibration {
        Calibration {
            inputs: Vec::new(),
            name: "test".into(),
            source: "nowhere".into(),
            elastic: Elastic::new(0.38e9, 900.0).unwrap(),
            youngs_modulus_std_pa: Some(0.08e9),
            poisson_ratio: 1.0 / 3.0,
            surface: Surface::None,
            threshold_pa: slipgrid_material::THRESHOLD_PRESSURE_PA,
            specimen_area_m2: std::f64::consts::PI * 25e-6,
            flat: vec![measurement(200.0, 0.15), measurement(50.0, 0.8), measurement(50.0, 0.15)],
            patterned: Vec::new(),
            traces: Vec::new(),
            pattern: None,
            area_law_scale_pa: None,
            measured_law: None,
            discrepancy: slipgrid_formats::calibration::DiscrepancyForm::Constant,
            coefficients,
            relative_std: 0.05,
            placed: Vec::new(),
            told: Vec::new(),
        }
    }

    fn pair(dynamic_mean: f64) -> FittedPair {
        FittedPair {
            static_mean: 0.3,
            static_std_error: None,
            dynamic_mean,
            dynamic_std_error: Some(0.002),
            dynamic_std_error_given_law: None,
        }
    }

    fn written(coefficients: Coefficients, pairs: Vec<FittedPair>) -> slipgrid_material::Material {
        let calibration = calibration(coefficients);
        let law = AreaLaw::new(vec![0.7e6, 2.6e6], vec![1.0, 0.9]);
        let input = CalibrationInput {
            elastic: calibration.elastic,
            area_law: Some(law.and_then(|law| law.with_factor_std(vec![0.0, 0.02])).unwrap()),
            specimen_area_m2: calibration.specimen_area_m2,
            measurements: calibration.flat.clone(),
            coefficients,
            relative_std: calibration.relative_std,
            layer: slipgrid_formats::scene::DEFAULT_LAYER,
            seed: 1,
            area_law_scale_pa: None,
        };
        let warnings = vec!["spikes: 2 points".to_owned()];
        let facts = SurfaceFacts { origin: Some("map"), synthetic: true, warnings, ..SurfaceFacts::default() };
        let fit = Fit {
            pairs,
            residuals: vec![0.001, -0.002, 0.0],
            dynamic_over_steady: vec![1.014, 1.018, 1.016],
            notes: vec!["a \"note\"".into()],
            details: FitDetails::default(),
        };
        let document = Document::new("m.toml", material_toml(&calibration, &input, &facts, &fit, None).unwrap());
        let material = read_material(&document, &document.parse().unwrap(), &(0..0)).unwrap();
        assert_eq!(material.elastic, input.elastic);
        assert_eq!(material.area_law, input.area_law);
        assert!(material.provenance.synthetic_surface);
        assert_eq!(material.provenance.notes[0], "a \"note\"");
        assert_eq!(material.provenance.warnings, ["spikes: 2 points"]);
        material
    }

    #[test]
    fn a_written_material_reads_back() {
        let single = written(Coefficients::Single, vec![pair(0.27)]);
        assert!(matches!(single.friction, Friction::Single(friction) if friction.dynamic_mean() == 0.27));

        let each = written(Coefficients::PerCondition, vec![pair(0.28), pair(0.22), pair(0.25)]);
        let at = |force_n: f64, humidity| {
            let pressure_pa = calibration(Coefficients::Single).pressure_pa(force_n);
            let condition = Condition { speed_m_s: 2e-3, humidity };
            each.friction.at(pressure_pa, Some(&condition)).unwrap()
        };
        assert_eq!(at(200.0, 0.15).friction.dynamic_mean(), 0.28);
        assert_eq!(at(50.0, 0.15).friction.dynamic_mean(), 0.25);
        assert_eq!(at(50.0, 0.8).friction.dynamic_mean(), 0.22);
        assert!(!at(50.0, 0.15).outside_measured_range && at(40.0, 0.15).outside_measured_range);
    }
}
