//! The material from a fit, with its numbers rounded as in a material file, so that results from a file and from memory
//! are equal.

use slipgrid_base::units::{
    DENSITY_G_CM3, EXCESS, FACTOR, FACTOR_STD, FRICTION, FRICTION_STD, MODULUS_GPA, MODULUS_STD_GPA, PRESSURE_MPA,
    Quantity, tidy,
};
use slipgrid_model::material::{
    AreaLaw, Condition, ConditionFriction, Elastic, Friction, LocalFriction, Material, Provenance,
};

use crate::calibrate::area_law::table_warnings;
use crate::calibrate::calibration_task::{CalibrationError, CalibrationTask};
use crate::calibrate::contradicting_samples::contradicting_samples;
use crate::calibrate::load_dependence::load_dependence_warning;
use crate::calibrate::select_measurements::{as_written, by_condition};
use crate::calibrate::surface_area_law_source::{AreaLawOrigin, SurfaceFindings};
use crate::calibrate::trial_discrepancy::{Learned, note};
use crate::calibrate::uncertainty::{CoefficientEstimate, MaterialUncertainty, flat_friction};
use crate::calibrate::{Coefficients, Fit, FittedPair, FittedRow, Measurement, ModelledRow, split_parameter_name};

/// Result of a calibration.
#[derive(Clone, Debug, PartialEq)]
pub struct CalibrationOutcome {
    /// The material, with its numbers rounded as in a material file.
    pub material: Material,
    /// Uncertainty of the material's numbers.
    pub uncertainty: MaterialUncertainty,
    /// Measurements on flat samples that were selected for the fit.
    pub measurements: Vec<Measurement>,
    /// The fit to these measurements.
    pub fit: Fit,
    /// Fitted rows by speed and humidity: groups in the order of the measurements, rows of a group by increasing
    /// pressure; empty if one pair of coefficients is fitted to all measurements.
    pub by_condition: Vec<(Condition, Vec<FittedRow>)>,
    /// The surface, its contact area and its area law.
    pub surface: SurfaceFindings,
}

/// Rounds a number in SI units as in a material file. Error: [`CalibrationError::OutOfRange`] if the file does not
/// accept it.
fn rounded(field: &'static str, quantity: Quantity, si: f64) -> Result<f64, CalibrationError> {
    let value = quantity.from_si(si);
    if quantity.accepts(value) {
        return Ok(quantity.to_si(value));
    }
    Err(CalibrationError::OutOfRange { field, value, expected: quantity.to_string() })
}

fn all_rounded(field: &'static str, quantity: Quantity, si: &[f64]) -> Result<Vec<f64>, CalibrationError> {
    si.iter().map(|&si| rounded(field, quantity, si)).collect()
}

/// Assembles the outcome of `task` from the fit to `measurements`, the surface and the trials.
pub(crate) fn outcome(
    task: &CalibrationTask,
    measurements: Vec<Measurement>,
    fit: Fit,
    surface: SurfaceFindings,
    Learned { discrepancy: learned, warnings: trial_warnings, lands, .. }: Learned,
) -> Result<CalibrationOutcome, CalibrationError> {
    let (rows, (friction, mut uncertainty)) = match task.coefficients {
        Coefficients::Single => (Vec::new(), single_pair(task, &fit)?),
        Coefficients::PerCondition => {
            let rows = fitted_rows(task, &measurements, &fit);
            let pairs = pairs_by_condition(task, &rows)?;
            (rows, pairs)
        }
    };
    let elastic = Elastic::new(
        MODULUS_GPA.as_written(task.elastic.youngs_modulus_pa()),
        DENSITY_G_CM3.as_written(task.elastic.density_kg_m3()),
    )?
    .with_yield_pressure_pa(task.elastic.yield_pressure_pa().map(|pa| PRESSURE_MPA.as_written(pa)))?;
    let modulus_std_pa = task.youngs_modulus_std_pa.map(|std_pa| MODULUS_STD_GPA.as_written(std_pa));
    uncertainty.modulus_relative_std = modulus_std_pa.map(|std_pa| std_pa / elastic.youngs_modulus_pa());
    let has_origin = |origin| surface.law.is_some() && surface.origin == Some(origin);
    uncertainty.law_is_fitted = has_origin(AreaLawOrigin::Fit);
    uncertainty.law_is_measured = has_origin(AreaLawOrigin::Measured);
    let area_law = surface.law.as_ref().map(law).transpose()?;
    if surface.law.is_some() && surface.depends_on_modulus() {
        uncertainty.flat_friction = flat_friction(task);
    }
    let mut notes = fit.notes.clone();
    notes.extend(surface.notes.iter().chain(&task.notes).cloned());
    notes.extend(note(&learned));
    notes.extend(lands.into_iter().map(|land| land.words));
    let contradicting = contradicting_samples(&learned);
    uncertainty.learned = Some(learned);
    if surface.synthetic {
        notes.push("the area law rests on a synthetic surface, not on a measured one".to_owned());
    }
    let fit_warnings = fit.warnings.iter().map(|warning| with_condition(warning, &measurements)).collect();
    let provenance = Provenance {
        name: task.name.clone(),
        source: task.source.clone(),
        synthetic_surface: surface.synthetic,
        notes,
        warnings: [warnings(task, &surface, area_law.as_ref(), &rows, fit_warnings), contradicting, trial_warnings]
            .concat(),
    };
    let material = Material { elastic, friction, area_law, provenance };
    Ok(CalibrationOutcome { material, uncertainty, measurements, fit, by_condition: rows, surface })
}

/// Warnings about the surface, the fit, the measurements and the table of the law.
fn warnings(
    task: &CalibrationTask,
    surface: &SurfaceFindings,
    law: Option<&AreaLaw>,
    by_condition: &[(Condition, Vec<FittedRow>)],
    fit_warnings: Vec<String>,
) -> Vec<String> {
    // Warnings about the input come before warnings about the results.
    let mut warnings = task.doubts.clone();
    warnings.extend(surface.warnings.iter().map(ToString::to_string));
    warnings.extend(fit_warnings);
    warnings.extend(law.and_then(|_| load_dependence_warning(surface, task.elastic.youngs_modulus_pa(), by_condition)));
    // A measured law may rise, because it is not computed from contact area.
    let of_area = law.filter(|_| surface.origin != Some(AreaLawOrigin::Measured));
    let name = |warning: &str| warning.split(':').next().map(str::to_owned);
    let known: Vec<Option<String>> = warnings.iter().map(|warning| name(warning)).collect();
    let beside = of_area.into_iter().flat_map(table_warnings);
    warnings.extend(beside.filter(|warning| !known.contains(&name(warning))));
    warnings
}

/// Replaces the index in `static_mean 2: ...` by the condition of the measurement.
fn with_condition(warning: &str, measurements: &[Measurement]) -> String {
    let placed =
        warning.split_once(':').and_then(|(name, rest)| Some((split_parameter_name(name, measurements)?, rest)));
    placed.map_or_else(
        || warning.to_owned(),
        |((what, at), rest)| format!("{what} at {}:{rest}", at.condition_in_words()),
    )
}

fn law(found: &AreaLaw) -> Result<AreaLaw, CalibrationError> {
    let pressures_pa = all_rounded("area_law.pressure_mpa", PRESSURE_MPA, found.pressures_pa())?;
    let law = AreaLaw::new(pressures_pa, all_rounded("area_law.factor", FACTOR, found.factors())?)?;
    match found.factor_std() {
        Some(std) => Ok(law.with_factor_std(all_rounded("area_law.factor_std", FACTOR_STD, std)?)?),
        None => Ok(law),
    }
}

fn pair(found: &FittedPair, relative_std: f64) -> Result<LocalFriction, CalibrationError> {
    let static_mean = rounded("friction.static_mean", FRICTION, found.static_mean)?;
    let dynamic_mean = rounded("friction.dynamic_mean", FRICTION, found.dynamic_mean)?;
    Ok(LocalFriction::new(static_mean, dynamic_mean, relative_std)?)
}

/// Estimates of the coefficients at one condition with rounded standard errors; empty if any coefficient has no
/// standard error.
fn standard_errors(
    field: &'static str,
    estimates: impl Iterator<Item = (CoefficientEstimate, Option<f64>)>,
) -> Result<Vec<CoefficientEstimate>, CalibrationError> {
    let known: Option<Vec<(CoefficientEstimate, f64)>> = estimates.map(|(at, error)| Some((at, error?))).collect();
    let each = known.unwrap_or_default().into_iter();
    each.map(|(at, error)| Ok(CoefficientEstimate { std_error: rounded(field, FRICTION_STD, error)?, ..at })).collect()
}

/// Adds the uncertainties of `rows`, which hold for one condition, or for all. A row has the pressure in pascals
/// (`None` for all pressures), the fitted pair, the rounded coefficients, and dynamic over steady friction.
fn row_uncertainty(
    rows: &[(Option<f64>, FittedPair, LocalFriction, Option<f64>)],
    condition: Option<Condition>,
    into: &mut MaterialUncertainty,
) -> Result<(), CalibrationError> {
    let at =
        |pressure_pa: Option<f64>, value: f64| CoefficientEstimate { pressure_pa, condition, value, std_error: 0.0 };
    let estimates = |mean: fn(&LocalFriction) -> f64, error: fn(&FittedPair) -> Option<f64>| {
        rows.iter().map(move |(pressure_pa, pair, friction, _)| (at(*pressure_pa, mean(friction)), error(pair)))
    };
    let static_errors = estimates(LocalFriction::static_mean, |pair| pair.static_std_error);
    into.static_friction.extend(standard_errors("friction.static_std_error", static_errors)?);
    let in_all = standard_errors(
        "friction.dynamic_std_error",
        estimates(LocalFriction::dynamic_mean, |pair| pair.dynamic_std_error),
    )?;
    let given_law = standard_errors(
        "friction.dynamic_std_error_given_law",
        estimates(LocalFriction::dynamic_mean, |pair| pair.dynamic_std_error_given_law),
    )?;
    into.has_marginal_errors |= !given_law.is_empty();
    into.friction.extend(if given_law.is_empty() { in_all } else { given_law });
    for (pressure_pa, _, _, excess) in rows {
        let excess = excess.map(|excess| rounded("friction.dynamic_over_steady", EXCESS, excess)).transpose()?;
        into.dynamic_over_steady.extend(excess.map(|excess| at(*pressure_pa, excess)));
    }
    Ok(())
}

fn single_pair(task: &CalibrationTask, fit: &Fit) -> Result<(Friction, MaterialUncertainty), CalibrationError> {
    let found = &fit.pairs[0];
    let friction = pair(found, task.relative_std)?;
    let mut uncertainty = MaterialUncertainty::default();
    row_uncertainty(&[(None, *found, friction, fit.mean_over_local_law())], None, &mut uncertainty)?;
    if let Some(known) = fit.scale_covariance() {
        let ([[a, b], [c, d]], mean) = (known, friction.dynamic_mean());
        if !(a >= 0.0 && d >= 0.0 && b * b <= a * d * (1.0 + 1e-9)) {
            let (field, expected) = ("friction.scale_covariance", "a covariance of two numbers".to_owned());
            return Err(CalibrationError::OutOfRange { field, value: b, expected });
        }
        uncertainty.scale_covariance = Some([[a / (mean * mean), b / mean], [c / mean, d]]);
    }
    Ok((Friction::Single(friction), uncertainty))
}

fn pairs_by_condition(
    task: &CalibrationTask,
    conditions: &[(Condition, Vec<FittedRow>)],
) -> Result<(Friction, MaterialUncertainty), CalibrationError> {
    let (mut table, mut uncertainty) = (Vec::new(), MaterialUncertainty::default());
    for (condition, rows) in conditions {
        let condition = as_written(condition);
        let mut known = Vec::new();
        for row in rows {
            let pressure_pa = rounded("friction.pressure_mpa", PRESSURE_MPA, row.pressure_pa)?;
            let friction = pair(&row.pair, task.relative_std)?;
            table.push(ConditionFriction { pressure_pa, condition: Some(condition), friction });
            known.push((Some(pressure_pa), row.pair, friction, Some(row.dynamic_over_steady)));
        }
        row_uncertainty(&known, Some(condition), &mut uncertainty)?;
    }
    Ok((Friction::PerCondition(table), uncertainty))
}

/// Groups the fitted rows by speed and humidity: groups in the order of the measurements, rows of a group by increasing
/// pressure.
fn fitted_rows(task: &CalibrationTask, measurements: &[Measurement], fit: &Fit) -> Vec<(Condition, Vec<FittedRow>)> {
    let row = |(measured, (&pair, predicted)): (&Measurement, (&FittedPair, &ModelledRow))| {
        let row = FittedRow {
            pressure_pa: task.pressure_pa(measured),
            pair,
            residual: predicted.residual,
            dynamic_over_steady: five_digits(predicted.over_local_law),
        };
        (measured.condition(), row)
    };
    let mut conditions = by_condition(measurements.iter().zip(fit.pairs.iter().zip(&fit.predictions)).map(row));
    for (_, rows) in &mut conditions {
        rows.sort_by(|a, b| a.pressure_pa.total_cmp(&b.pressure_pa));
    }
    conditions
}

/// Rounds to five decimals; runs are accurate to a thousandth.
fn five_digits(excess: f64) -> f64 {
    (excess * 1e5).round() / 1e5
}

impl Fit {
    /// Mean over all measurements of dynamic friction over mu_d f(P), the local dynamic coefficient times the area
    /// factor, to five decimals; `None` without measurements.
    pub fn mean_over_local_law(&self) -> Option<f64> {
        let sum: f64 = self.predictions.iter().map(|predicted| predicted.over_local_law).sum();
        (!self.predictions.is_empty()).then(|| five_digits(sum / self.predictions.len() as f64))
    }

    /// Covariance matrix of the single fitted `dynamic_mean` and the logarithm of the area law's scale; `None` if the
    /// scale was not fitted or is undetermined.
    pub fn scale_covariance(&self) -> Option<[[f64; 2]; 2]> {
        let place = |name: &str| self.parameters.iter().position(|parameter| parameter.name == name);
        let (mean, scale) = (place("dynamic_mean")?, place("area_law_scale_pa")?);
        let entry = |i: usize, j: usize| {
            self.covariance.get(i)?.get(j).map(|&entry| tidy(entry)).filter(|entry| entry.is_finite())
        };
        let std_error = self.pairs.first()?.dynamic_std_error;
        let variance = std_error.map_or(entry(mean, mean)?, |std_error| std_error * std_error);
        // In a poor fit, measurements scatter more than their standard deviations say (Birge, Phys. Rev. 40, 207,
        // 1932).
        let excess = (self.chi_square / self.degrees_of_freedom.max(1) as f64).max(1.0);
        let [shared, of_scale] = [entry(mean, scale)?, entry(scale, scale)?].map(|entry| tidy(excess * entry));
        Some([[tidy(variance).max(tidy(excess * entry(mean, mean)?)), shared], [shared, of_scale]])
    }
}
