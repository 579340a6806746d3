//! Ledger of a calibration's trials: predictions before the measurements, measurements, and predictions for the next
//! samples.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use slipgrid_base::monitor::{Cancelled, Monitor};
use slipgrid_base::units::{HUMIDITY_PCT, LENGTH_UM, PRESSURE_MPA, SPEED_MM_S, tidy};
use slipgrid_design::results::{MadeBy, SCHEMA};
use slipgrid_infer::calibrate::{CutSample, LandEffect, Measurement, contradicting_samples};
use slipgrid_infer::discrepancy::{Discrepancy, LeftOut, Surprise, leave_out};

use crate::friction_sheet::{self, FrictionSheet};
use crate::{Failure, Outputs, charts, html, linked_data};
use effects::effects;
use load_lines::load_lines;

mod effects;
mod load_lines;
mod parts;
mod text;

pub use effects::DiscrepancyEffect;
pub use load_lines::LoadLine;
pub use parts::{PendingTrial, SampleScatter};

/// Metres per millimetre: converts an edge length per area from 1/m to 1/mm.
const PER_MM: f64 = 1e-3;

/// Ledger of a calibration's trials: measured ratios with their predictions, as `slipgrid trials` reports them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TrialsReport {
    /// Program that made the record.
    #[serde(flatten)]
    pub made_by: MadeBy,
    /// Name of the calibration.
    pub name: String,
    /// Warnings about implausible measurements, and about contradictory samples of one texture.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
    /// Trials, the earliest first.
    pub trials: Vec<TrialReport>,
    /// Names of trials that were cut and not yet measured.
    pub pending: Vec<String>,
    /// Predictions for the pending trials.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub predicted: Vec<PendingTrial>,
    /// Prior and posterior weights of the candidate forms of the discrepancy.
    pub forms: Vec<WeightedForm>,
    /// Family of forms that the trials identify; null while the textures of the trials do not discriminate between forms.
    pub identified: Option<String>,
    /// All trials have one texture, which cannot discriminate between forms.
    #[serde(default)]
    pub one_texture: bool,
    /// Scatter of samples of one texture; null if the trials carry no information about it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scatter: Option<SampleScatter>,
    /// Discrepancy at the texture measured last, and dependence of the discrepancy on pressure, speed and humidity.
    pub effects: Vec<DiscrepancyEffect>,
    /// Slope of the land between cavities, and its effect on the modelled ratios, for trials that name a map of the cut
    /// sample.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lands: Vec<LandEffect>,
    /// Fitted lines of friction force against normal force.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub load_lines: Vec<LoadLine>,
    /// Coverage of the predictions: measured ratios within their intervals.
    pub coverage: Vec<Coverage>,
}

/// Trial with its measurements.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TrialReport {
    /// Name of the trial.
    pub name: String,
    /// Date of the measurement, from the calibration.
    pub date: String,
    /// Other notes in the calibration.
    pub notes: String,
    /// Disc that the trial shares with other trials; null if it has a specimen to itself.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub disc: Option<String>,
    /// Areal density: share of a period of the infinite pattern that is cavity.
    pub areal_density: f64,
    /// Edge length per area, in 1/mm.
    pub edge_per_mm: f64,
    /// Width of the cavities.
    pub width_um: f64,
    /// Gap between cavities along a row.
    pub spacing_um: f64,
    /// Depth of the cavities.
    pub depth_um: f64,
    /// Measured ratios.
    pub measured: Vec<MeasuredReport>,
}

/// Measured ratio of patterned to flat friction, with predictions.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MeasuredReport {
    /// Nominal pressure.
    pub pressure_mpa: f64,
    /// Sliding speed.
    pub speed_mm_s: f64,
    /// Relative humidity.
    pub humidity_pct: f64,
    /// Measured ratio.
    pub measured: f64,
    /// Modelled ratio.
    pub modelled: f64,
    /// Prediction from all earlier trials.
    pub before: PredictedReport,
    /// Prediction from all trials except this one.
    pub without_trial: PredictedReport,
    /// Prediction from the measurements at all other conditions (pressure, speed and humidity), including those of this
    /// trial.
    pub without_condition: PredictedReport,
}

/// Prediction of a measured ratio, including measurement errors.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PredictedReport {
    /// Median of the predicted ratio.
    pub ratio: f64,
    /// Ends of the 68 % interval.
    pub interval_68: [f64; 2],
    /// Ends of the 95 % interval.
    pub interval_95: [f64; 2],
    /// Number of standard deviations by which a normal value as improbable as the measured ratio lies off its prediction.
    pub surprise: f64,
    /// Number of measured ratios from which the prediction is made; if 0, the prediction is the prior.
    #[serde(default)]
    pub known: usize,
}

/// Prior and posterior weight of one candidate form of the discrepancy, the model's error as a function of the texture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct WeightedForm {
    /// Name of the form.
    pub form: String,
    /// Prior weight.
    pub prior: f64,
    /// Posterior weight.
    pub weight: f64,
}

/// Number of measured ratios within their predicted intervals.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Coverage {
    /// Data that the predictions are based on.
    pub by: String,
    /// Number of ratios whose prediction is based on at least one measured ratio.
    pub ratios: usize,
    /// Number of ratios predicted by the prior alone; not counted, because the prior's interval contains almost any value.
    #[serde(default)]
    pub without_any: usize,
    /// Number of `ratios` within the 68 % interval.
    pub within_68: usize,
    /// Number of `ratios` within the 95 % interval.
    pub within_95: usize,
}

impl TrialsReport {
    /// Makes the ledger of the calibration `name`: `learned` is the discrepancy learned from the textured `samples`;
    /// `flat` are the measurements on flat samples.
    ///
    /// # Errors
    /// [`Cancelled`] once `monitor` has cancelled.
    pub fn new(
        name: &str,
        flat: &[Measurement],
        samples: &[CutSample],
        learned: &Discrepancy,
        monitor: &dyn Monitor,
    ) -> Result<Self, Cancelled> {
        let without = |by| leave_out(learned, by, monitor);
        let by = [without(LeftOut::TrialAndLater)?, without(LeftOut::Trial)?, without(LeftOut::Condition)?];
        let trial = |(place, of): (usize, &slipgrid_infer::discrepancy::Trial)| {
            let cut = samples.iter().find(|cut| cut.name == of.name);
            let row = |(row, at): (usize, &slipgrid_infer::discrepancy::Measured)| {
                let predicted = |all: &[Surprise]| {
                    all.iter()
                        .find(|of| (of.trial, of.row) == (place, row))
                        .map_or_else(PredictedReport::default, |of| PredictedReport::new(of, at.modelled))
                };
                MeasuredReport {
                    pressure_mpa: tidy(PRESSURE_MPA.from_si(at.load.pressure_pa)),
                    speed_mm_s: tidy(SPEED_MM_S.from_si(at.load.speed_m_s)),
                    humidity_pct: tidy(HUMIDITY_PCT.from_si(at.load.humidity)),
                    measured: tidy(at.measured),
                    modelled: tidy(at.modelled),
                    before: predicted(&by[0]),
                    without_trial: predicted(&by[1]),
                    without_condition: predicted(&by[2]),
                }
            };
            TrialReport {
                name: of.name.clone(),
                date: cut.map(|cut| cut.date.clone()).unwrap_or_default(),
                notes: cut.map(|cut| cut.notes.clone()).unwrap_or_default(),
                disc: of.disc.clone(),
                areal_density: tidy(of.features.areal_density),
                edge_per_mm: tidy(of.features.edge_1_m * PER_MM),
                width_um: tidy(LENGTH_UM.from_si(of.features.width_m)),
                spacing_um: tidy(LENGTH_UM.from_si(of.features.pitch_m - of.features.width_m)),
                depth_um: tidy(LENGTH_UM.from_si(of.features.depth_m)),
                measured: of.measured.iter().enumerate().map(row).collect(),
            }
        };
        let mut forms: Vec<WeightedForm> = learned
            .forms()
            .iter()
            .map(|of| WeightedForm { form: of.form.name(), prior: tidy(of.prior), weight: tidy(of.weight) })
            .collect();
        // Stable sort: forms of equal weight keep their order.
        forms.sort_by(|a, b| b.weight.total_cmp(&a.weight));
        let names = ["the trials before it", "all other trials", "all other conditions"];
        let coverage = names.iter().zip(&by).map(|(by, all)| {
            let predicted = || all.iter().filter(|of| of.known > 0);
            let inside = |interval: fn(&Surprise) -> [f64; 2]| {
                let is_within = |of: &&Surprise| (interval(of)[0]..=interval(of)[1]).contains(&of.measured);
                predicted().filter(is_within).count()
            };
            Coverage {
                by: (*by).to_owned(),
                ratios: predicted().count(),
                without_any: all.len() - predicted().count(),
                within_68: inside(|of| of.interval_68),
                within_95: inside(|of| of.interval_95),
            }
        });
        Ok(Self {
            made_by: MadeBy::slipgrid(SCHEMA),
            name: name.to_owned(),
            warnings: contradicting_samples(learned),
            trials: learned.trials().iter().enumerate().map(trial).collect(),
            pending: samples.iter().filter(|cut| cut.measured.is_empty()).map(|cut| cut.name.clone()).collect(),
            predicted: Vec::new(),
            identified: learned.identified().map(str::to_owned),
            one_texture: learned.has_one_texture(),
            forms,
            scatter: SampleScatter::of(learned),
            effects: effects(learned),
            lands: Vec::new(),
            load_lines: load_lines(flat, samples),
            coverage: coverage.collect(),
        })
    }

    /// Inserts `warnings` about measurements before the warnings about contradictory samples.
    #[must_use]
    pub fn with_warnings(self, mut warnings: Vec<String>) -> Self {
        warnings.extend(self.warnings);
        Self { warnings, ..self }
    }

    /// Draws measured ratios beside their predictions, and against areal density, edge length and pressure, as SVG.
    ///
    /// # Errors
    /// [`Failure`] if the picture cannot be drawn.
    pub fn picture(&self) -> Result<String, Failure> {
        Ok(charts::trials(&format!("{}: measured and predicted ratios", self.name), &self.trials)?)
    }

    /// Makes the files of the ledger; `sheet` is the sheet of the friction measurements.
    ///
    /// # Errors
    /// [`Failure`] if the picture cannot be drawn or the record has no JSON form.
    pub fn files(&self, sheet: &FrictionSheet) -> Result<Outputs, Failure> {
        let mut outputs = Outputs::default();
        outputs.add("trials.csv", self.csv());
        if !self.trials.is_empty() {
            outputs.add("trials.svg", self.picture()?);
        }
        outputs.add_record(self)?;
        outputs.add(friction_sheet::FILE, sheet.markdown());
        outputs.add(linked_data::FILE, linked_data::of_trials(self, &outputs)?);
        let page = html::trials(self, sheet, &outputs);
        outputs.add("report.html", page);
        Ok(outputs)
    }
}

impl PredictedReport {
    fn new(of: &Surprise, modelled: f64) -> Self {
        let ratio = |log: f64| tidy(modelled * log.exp());
        Self {
            ratio: ratio(of.median),
            interval_68: of.interval_68.map(ratio),
            interval_95: of.interval_95.map(ratio),
            surprise: tidy(of.surprise),
            known: of.known,
        }
    }
}

#[cfg(test)]
mod tests;
