//! The model's error on patterned samples, from a calibration's patterned measurements.

use slipgrid_calibrate::{
    Discrepancy, DiscrepancyForm as Form, RatioInterval, RatioPoint, Trial, estimate, leave_one_out, uncorrected,
};
use slipgrid_contact::AreaPoint;
use slipgrid_material::{AreaLaw, LocalFriction};
use slipgrid_pattern::Pattern;
use slipgrid_springblock::{Layer, Load, RunOptions, Scene, Status, Unwatched, simulate};
use toml::Spanned;

use super::CalibrationInput;
use crate::CliError;
use crate::commands::area_curve::area_law;
use slipgrid_formats::calibration::{Calibration, DiscrepancyForm};
use slipgrid_formats::discrepancy::{DiscrepancyFile, EstimateFile, HumidityFile, TrialFile};
use slipgrid_formats::measurements::Measurement;
use slipgrid_formats::values::number;
use slipgrid_results::Table;
use slipgrid_results::fixed;
use slipgrid_units::{HUMIDITY_PCT, LENGTH_UM, SPEED_MM_S, tidy};

/// Step of ln E behind the sensitivity: small against the modulus's own error, large against rounding.
const LOG_MODULUS_STEP: f64 = 0.02;
/// Ratios at one humidity from which it has an estimate of its own.
const FEWEST_AT_HUMIDITY: usize = 3;

/// `calibration` with the patterned measurements that estimates for `humidities` rest on: those at them, or all where
/// those at one of them are too few.
#[must_use]
pub fn narrowed(calibration: &Calibration, humidities: &[f64]) -> Calibration {
    let mut narrowed = calibration.clone();
    let at = |humidity: f64| calibration.patterned.iter().filter(|measured| measured.humidity == humidity).count();
    if !humidities.is_empty() && humidities.iter().all(|humidity| at(*humidity) >= FEWEST_AT_HUMIDITY) {
        narrowed.patterned.retain(|measured| humidities.contains(&measured.humidity));
    }
    narrowed
}

/// One condition measured on both kinds of sample.
#[derive(Clone, Copy, Debug)]
struct Row {
    flat: Measurement,
    point: RatioPoint,
}

/// Discrepancy with what each condition says without itself.
pub struct Report {
    rows: Vec<Row>,
    pattern: Pattern,
    modulus_relative_std: f64,
    /// Over all conditions.
    pub all: Discrepancy,
    by_humidity: Vec<(f64, Discrepancy)>,
    left_out: Vec<Option<RatioInterval>>,
    left_out_by_humidity: Vec<Option<RatioInterval>>,
}

/// Estimates the discrepancy; `None` without patterned samples, their pattern, or where it is not wanted.
pub fn discrepancy(
    calibration: &Calibration,
    input: &CalibrationInput,
    curve: &[AreaPoint],
) -> Result<Option<Report>, CliError> {
    let form = match calibration.discrepancy {
        DiscrepancyForm::Constant => Form::Constant,
        DiscrepancyForm::Linear => Form::Linear,
        DiscrepancyForm::None => return Ok(None),
    };
    let Some(pattern) = calibration.pattern else { return Ok(None) };
    let rows = rows(calibration, input, curve, pattern)?;
    if rows.is_empty() {
        return Ok(None);
    }
    let modulus_relative_std = calibration.modulus_relative_std().unwrap_or(0.0);
    let points: Vec<RatioPoint> = rows.iter().map(|row| row.point).collect();
    let failed = |error: slipgrid_calibrate::CalibrationError| CliError::Other(format!("discrepancy: {error}"));
    let all = estimate(&points, form, modulus_relative_std).map_err(failed)?;
    let left_out = leave_one_out(&points, form, modulus_relative_std);
    let mut by_humidity = Vec::new();
    let mut left_out_by_humidity = vec![None; rows.len()];
    for row in &rows {
        let humidity = row.flat.humidity;
        if by_humidity.iter().any(|(known, _)| *known == humidity) {
            continue;
        }
        let members: Vec<usize> = (0..rows.len()).filter(|&i| rows[i].flat.humidity == humidity).collect();
        let own: Vec<RatioPoint> = members.iter().map(|&i| points[i]).collect();
        if own.len() >= FEWEST_AT_HUMIDITY {
            by_humidity.push((humidity, estimate(&own, form, modulus_relative_std).map_err(failed)?));
            for (&i, found) in members.iter().zip(leave_one_out(&own, form, modulus_relative_std)) {
                left_out_by_humidity[i] = found;
            }
        }
    }
    Ok(Some(Report { rows, pattern, modulus_relative_std, all, by_humidity, left_out, left_out_by_humidity }))
}

fn rows(
    calibration: &Calibration,
    input: &CalibrationInput,
    curve: &[AreaPoint],
    pattern: Pattern,
) -> Result<Vec<Row>, CliError> {
    let same = |a: f64, b: f64| (a - b).abs() <= 1e-6 * a.abs().max(b.abs());
    let pairs: Vec<(Measurement, Measurement)> = calibration
        .patterned
        .iter()
        .filter_map(|patterned| {
            let alike = |flat: &&Measurement| {
                same(flat.force_n, patterned.force_n)
                    && same(flat.speed_m_s, patterned.speed_m_s)
                    && same(flat.humidity, patterned.humidity)
            };
            Some((*calibration.flat.iter().find(alike)?, *patterned))
        })
        .collect();
    let modelled = |log_modulus: f64| -> Result<Vec<Option<f64>>, CliError> {
        let law = match input.area_law {
            None => None,
            // A measured law is moved by no modulus.
            Some(ref law) if curve.is_empty() => Some(law.clone()),
            Some(_) => Some(stiffer(curve, log_modulus, calibration.threshold_pa)?),
        };
        ratios(calibration, law, input.layer, pattern, &pairs)
    };
    let [less, here, more] = [modelled(-LOG_MODULUS_STEP)?, modelled(0.0)?, modelled(LOG_MODULUS_STEP)?];
    Ok(pairs
        .iter()
        .enumerate()
        .filter_map(|(i, (flat, patterned))| {
            let measured = patterned.mu_dynamic / flat.mu_dynamic;
            let relative =
                (patterned.mu_dynamic_std / patterned.mu_dynamic).hypot(flat.mu_dynamic_std / flat.mu_dynamic);
            let point = RatioPoint {
                pressure_pa: calibration.pressure_pa(flat.force_n),
                measured,
                measured_std: measured * relative,
                modelled: here[i]?,
                modulus_sensitivity: (more[i]?.ln() - less[i]?.ln()) / (2.0 * LOG_MODULUS_STEP),
            };
            Some(Row { flat: *flat, point })
        })
        .collect())
}

/// The law of a surface whose modulus is larger by the factor exp(log_modulus): A(P; c E) = A(P / c; E).
fn stiffer(curve: &[AreaPoint], log_modulus: f64, threshold_pa: f64) -> Result<AreaLaw, CliError> {
    let factor = log_modulus.exp();
    let moved: Vec<AreaPoint> =
        curve.iter().map(|point| AreaPoint { pressure_pa: point.pressure_pa * factor, ..*point }).collect();
    area_law(&moved, threshold_pa).map_err(|error| CliError::Other(error.to_string()))
}

/// Modelled ratios of the patterned samples: steady cells, the flat surface at its measured friction.
fn ratios(
    calibration: &Calibration,
    area_law: Option<AreaLaw>,
    layer: Layer,
    pattern: Pattern,
    pairs: &[(Measurement, Measurement)],
) -> Result<Vec<Option<f64>>, CliError> {
    let loads = pairs
        .iter()
        .map(|(flat, _)| {
            let pressure_pa = calibration.pressure_pa(flat.force_n);
            // A flat cell slides at mu_flat = mu_d f(P).
            let mean = flat.mu_dynamic / area_law.as_ref().map_or(1.0, |law| law.factor(pressure_pa));
            Ok(Load { pressure_pa, friction: LocalFriction::new(mean, mean, 0.0)? })
        })
        .collect::<Result<Vec<Load>, slipgrid_material::MaterialError>>()
        .map_err(|error| CliError::Other(error.to_string()))?;
    let Some(speed_m_s) = pairs.first().map(|(flat, _)| flat.speed_m_s) else { return Ok(Vec::new()) };
    let scene = Scene {
        elastic: calibration.elastic,
        area_law,
        pattern: Some(pattern),
        layer,
        loads,
        // Steady sliding does not depend on it.
        speed_m_s,
        run: RunOptions::default(),
    };
    let simulation = simulate(&scene, &Unwatched).map_err(|error| CliError::Other(error.to_string()))?;
    let converged = simulation.loads.iter().map(|load| load.ratio.filter(|_| load.surface.status == Status::Converged));
    Ok(converged.collect())
}

impl Report {
    /// As a table of the material file.
    pub fn file(&self) -> Spanned<DiscrepancyFile> {
        let um = |length_m: f64| LENGTH_UM.from_si(length_m);
        let pattern = &self.pattern;
        let file = DiscrepancyFile {
            pattern: format!(
                "{} {} um wide, {} um apart, {} um deep",
                pattern.planform(),
                um(pattern.width_m()),
                um(pattern.spacing_m()),
                um(pattern.depth_m())
            ),
            all: EstimateFile::new(&self.all),
            humidity: self
                .by_humidity
                .iter()
                .map(|(humidity, found)| HumidityFile {
                    humidity_pct: number(HUMIDITY_PCT.from_si(*humidity)),
                    estimate: EstimateFile::new(found),
                })
                .collect(),
            trials: vec![TrialFile::from(&Trial::from(pattern))],
        };
        Spanned::new(0..0, file)
    }

    /// What the discrepancy says, for the material's notes.
    pub fn note(&self) -> String {
        let factor = self.all.factor(self.all.reference_pressure_pa);
        let found = self.all.correct(self.all.reference_pressure_pa, factor, 0.0);
        format!(
            "discrepancy: on the patterned samples measured ratios are {factor:.3} times the modelled ones (95 % of conditions within {:.3} to {:.3}); it is kept apart from the physics, in [discrepancy], and holds for patterns like theirs alone",
            found.interval[0] / factor,
            found.interval[1] / factor
        )
    }

    /// Measured ratios beside predicted ones.
    pub fn table(&self) -> String {
        let mut table = Table::new([
            "F N",
            "v mm/s",
            "RH %",
            "ratio",
            "+-",
            "model",
            "95 % by modulus",
            "without this one",
            "95 %",
            "its humidity alone",
            "95 %",
        ]);
        for (i, row) in self.rows.iter().enumerate() {
            let point = &row.point;
            let bare = uncorrected(point.modelled, point.modulus_sensitivity, self.modulus_relative_std);
            table.row([
                row.flat.force_n.to_string(),
                SPEED_MM_S.from_si(row.flat.speed_m_s).to_string(),
                HUMIDITY_PCT.from_si(row.flat.humidity).to_string(),
                fixed(Some(point.measured), 3),
                fixed(Some(point.measured_std), 3),
                fixed(Some(point.modelled), 3),
                ends(Some(bare)),
                fixed(self.left_out[i].map(|found| found.ratio), 3),
                marked(self.left_out[i], point.measured),
                fixed(self.left_out_by_humidity[i].map(|found| found.ratio), 3),
                marked(self.left_out_by_humidity[i], point.measured),
            ]);
        }
        format!("{table}{}\n", self.coverage())
    }

    fn coverage(&self) -> String {
        let count = |left_out: &[Option<RatioInterval>]| {
            let told: Vec<bool> = left_out
                .iter()
                .zip(&self.rows)
                .filter_map(|(found, row)| found.map(|found| within(&found, row.point.measured)))
                .collect();
            format!("{} of {}", told.iter().filter(|inside| **inside).count(), told.len())
        };
        format!(
            "measured ratios within the interval predicted without them: {} by all conditions, {} by their humidity's; ! marks those outside. Scatter between conditions {:.3}",
            count(&self.left_out),
            count(&self.left_out_by_humidity),
            self.all.scatter
        )
    }

    /// The same as CSV.
    pub fn csv(&self) -> String {
        let mut text = String::from(
            "force_n,speed_mm_s,humidity_pct,ratio,ratio_std,modelled,modulus_sensitivity,left_out,left_out_low,left_out_high,\
             left_out_humidity,left_out_humidity_low,left_out_humidity_high\n",
        );
        let three = |found: Option<RatioInterval>| {
            let numbers = found.map(|found| [found.ratio, found.interval[0], found.interval[1]]);
            let cells = numbers.map_or([const { String::new() }; 3], |all| all.map(|value| tidy(value).to_string()));
            cells.join(",")
        };
        for (i, row) in self.rows.iter().enumerate() {
            let point = &row.point;
            text += &format!(
                "{},{},{},{},{},{},{},{},{}\n",
                row.flat.force_n,
                SPEED_MM_S.from_si(row.flat.speed_m_s),
                HUMIDITY_PCT.from_si(row.flat.humidity),
                tidy(point.measured),
                tidy(point.measured_std),
                tidy(point.modelled),
                tidy(point.modulus_sensitivity),
                three(self.left_out[i]),
                three(self.left_out_by_humidity[i]),
            );
        }
        text
    }
}

fn within(found: &RatioInterval, measured: f64) -> bool {
    (found.interval[0]..=found.interval[1]).contains(&measured)
}

fn ends(found: Option<RatioInterval>) -> String {
    found.map_or_else(|| "-".to_owned(), |found| format!("{:.3}-{:.3}", found.interval[0], found.interval[1]))
}

/// The interval, with a mark where the measured ratio lies outside.
fn marked(found: Option<RatioInterval>, measured: f64) -> String {
    let outside = found.is_some_and(|found| !within(&found, measured));
    format!("{}{}", if outside { "! " } else { "" }, ends(found))
}
