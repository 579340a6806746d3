//! What trials say of the design that was found: whether to cut it as a series or as a trial.

use serde::{Deserialize, Serialize};
use slipgrid_calibrate::uncertainty::MaterialUncertainty;
use slipgrid_monitor::{Monitor, Part};
use slipgrid_optimize::{ModelFailure, Status};

use super::candidate_search::{Scope, Search, is_same};
use super::interpolation::{Interpolation, Modelled, Models};
use super::{Asked, BeyondCells, Design, Judged, PredictedRatio, SERIES, TrialCandidateReport, asked};
use crate::DesignError;
use crate::chance::{About, Chances, Expansion};
use crate::chance_report::{numerical, percent};
use crate::multi_fidelity::MultiFidelityLoop;
use crate::task::DesignTask;
use slipgrid_results::{ErrorsReport, Table};
use slipgrid_units::tidy;

/// By how much the chance of another texture must be greater to be worth a word.
pub(super) const CLEARLY: f64 = 0.005;
/// Samples that are likelier on target, as many as are listed.
const RATHER: usize = 4;

/// The chance of the design that was found, with what trials say that the model lacks; before any trial with what is believed of
/// that.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AdviceReport {
    /// "series" if a cut sample is more likely on target than not, otherwise "trial".
    pub advice: String,
    /// The chance of this design.
    pub chance: f64,
    /// Trials that it rests on.
    pub trials: usize,
    /// In one line.
    pub words: String,
    /// What is predicted of a cut sample.
    pub predicted: Vec<PredictedRatio>,
    /// Other samples that are clearly likelier to be on target than this one, the most likely first; empty where the advice is a series.
    /// Their ratios have ends, tilt and time of their own. Before any trial only samples
    /// whose median is near the target are listed. In space the list is empty, and `slipgrid next` looks for such samples.
    #[serde(default)]
    pub rather: Vec<TrialCandidateReport>,
}

impl AdviceReport {
    /// In words, with the samples that are likelier on target.
    #[must_use]
    pub fn text(&self) -> String {
        let table = if self.rather.is_empty() { String::new() } else { format!("\n{}", self.table()) };
        format!("  {}\n{table}", self.words)
    }

    /// What its chance counts beside the model, in words.
    #[must_use]
    pub fn known_of(&self) -> String {
        match self.trials {
            0 => "how far the model may be off, as it is believed before any trial".to_owned(),
            1 => "what one trial says that the model lacks".to_owned(),
            trials => format!("what {trials} trials say that the model lacks"),
        }
    }

    fn table(&self) -> Table {
        let mut table = Table::new(TrialCandidateReport::COLUMNS);
        self.rather.iter().enumerate().for_each(|(place, of)| {
            table.row(of.row(if place == 0 { "next" } else { "also" }));
        });
        table
    }
}

impl MultiFidelityLoop<'_> {
    /// The advice for the design that was found, whose chance is `aimed` where it counts what the model lacks already, with its expansion
    /// where that is known; `None` where nothing is demanded, or where it cannot be computed.
    ///
    /// # Errors
    /// [`DesignError`] for trials that mean nothing, and where the monitor cancels.
    pub(crate) fn advice(
        &self,
        task: &DesignTask,
        material: &MaterialUncertainty,
        (errors, expansion): (&ErrorsReport, Option<&Expansion>),
        aimed: Option<f64>,
    ) -> Result<Option<AdviceReport>, DesignError> {
        let (Some(best), Some(confirmed), Some(chances)) = (&self.round.best, &self.round.confirmed, &self.chances)
        else {
            return Ok(None);
        };
        // Where no pattern is needed or none helps, none is to be cut; and what does not slide evenly is no sample to measure.
        let is_meant = task.target.has_demands() && self.confirmed_values().is_some();
        if !is_meant || self.flat_is_best(task).is_some() {
            return Ok(None);
        }
        let asked = asked(task, material, &self.further, &self.model)?;
        let models = Models::new(&self.model, material)?;
        let found = models.at(&best.design).and_then(|modelled| {
            if let Some(expansion) = expansion {
                return Ok((modelled, (chances.log_covariance(expansion), chances.dimension_shifts(expansion))));
            }
            let still = chances.still(&best.design)?;
            let (scales, values) = (self.model.scales(&best.design), self.confirmed_values());
            let (numerical, _) = numerical(task, &scales, confirmed, errors);
            let values =
                values.unwrap_or_else(|| still.ratio.iter().zip(&scales).map(|(ratio, scale)| ratio * scale).collect());
            let about = About { design: &best.design, still: &still, values: &values, numerical: &numerical };
            let expansion = chances.expand(&about)?;
            Ok((modelled, (chances.log_covariance(&expansion), chances.dimension_shifts(&expansion))))
        });
        let (modelled, (covariance, shifts)) = match found {
            Ok(found) => found,
            Err(ModelFailure::Cancelled) => return Err(DesignError::Cancelled),
            Err(_) => return Ok(None),
        };
        // ln R of the run in time where there is one; elsewhere the steady one, off by as much as there.
        let count = task.target.points().len();
        let off = |load: usize| {
            let ratio = confirmed.loads.get(load).and_then(|at| at.ratio)?;
            Some(ratio.ln() - modelled.log_ratio[load])
        };
        let log_ratio = modelled.log_ratio.iter().enumerate();
        let log_ratio = log_ratio.map(|(load, log)| log + off(load % count).unwrap_or(0.0)).collect();
        let design = Design::new(best.design, Modelled { log_ratio, ..modelled }, covariance, shifts);
        let judged = design.judged(&asked.learned.at(&asked.loads), &asked.wanted);
        // A design that aims with the discrepancy has it in its chance.
        let chance = aimed.unwrap_or(judged.score.chance);
        let (advice, trials) = (if chance > SERIES { "series" } else { "trial" }, asked.learned.trials().len());
        let side = if chance > SERIES { "above" } else { "below" };
        // Out of reach by the model, a sample says how far that is off.
        let is_out = self.status == Status::Unreachable && chance <= SERIES;
        let words = if is_out {
            format!(
                "not worth a series: its chance is {}; as a trial it would say how far the model is off",
                percent(chance)
            )
        } else {
            format!("cut it as a {advice}: its chance, {}, is {side} one half", percent(chance))
        };
        let predicted = PredictedRatio::of(&asked, &judged);
        let rather = if chance > SERIES {
            None
        } else {
            self.rather(task, &asked, (&models, chances), (&judged.design, chance))
        };
        let words = match &rather {
            Some(rather) if !rather.is_empty() && trials == 0 => {
                format!("{words}; others may be likelier, by what is believed before any trial")
            }
            Some(rather) if !rather.is_empty() => format!("{words}; others are likelier on target"),
            Some(_) if trials > 0 => format!("{words}; no other texture found within the bounds is clearly likelier"),
            _ => words,
        };
        let rather = rather.unwrap_or_default();
        let advice = advice.to_owned();
        Ok(Some(AdviceReport { advice, chance: tidy(chance), trials, words, predicted, rather }))
    }

    /// Samples that are clearly likelier on target than `found` with its `chance`, the likeliest first; `None` in space, and where time is
    /// spent.
    fn rather(
        &self,
        task: &DesignTask,
        asked: &Asked,
        (models, chances): (&Models<'_>, &Chances<'_>),
        (found, chance): (&Design, f64),
    ) -> Option<Vec<TrialCandidateReport>> {
        if !self.model.is_cheap_per_design() {
            return None;
        }
        let stage = self.stage("samples likelier on target");
        let scope = Scope::BESIDE;
        let half = Part::new(&stage, 0.5);
        let beyond = BeyondCells {
            model: &self.model,
            face: Some(task.specimen),
            count: task.target.points().len(),
            seed: task.seed,
        };
        let interpolation = Interpolation::new(task, models, &beyond, &scope, &half);
        let best = interpolation.and_then(|nodes| {
            let search = Search::new(task, asked, (models, &beyond), chances, (&nodes, &scope), &half);
            let is_other = |_: &_, of: &_| !is_same(of, &found.features);
            let (best, _) = search.best(&is_other, chance + CLEARLY, RATHER);
            let mut best = search.all_as_cut(best, 2 * RATHER);
            if stage.cancelled() {
                return None;
            }
            best.retain(|of| of.score.chance > chance + CLEARLY);
            // Before any trial little is known of any texture: one whose own median misses by far is no better guess.
            let is_guess = |of: &Judged| {
                let predicted = PredictedRatio::of(asked, of);
                predicted.iter().zip(&asked.tolerances).all(|(of, tolerance)| of.is_near(*tolerance))
            };
            best.retain(|of| !asked.learned.trials().is_empty() || is_guess(of));
            Some(best)
        });
        stage.finish();
        let mut best = best?;
        best.truncate(RATHER);
        Some(best.iter().map(|of| TrialCandidateReport::new(task, asked, of)).collect())
    }
}
