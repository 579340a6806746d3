//! What trials say of the design that was found: whether to cut it as a series or as a trial.

use serde::{Deserialize, Serialize};
use slipgrid_calibrate::uncertainty::MaterialUncertainty;
use slipgrid_optimize::ModelFailure;

use super::interpolation::{Modelled, Models};
use super::{Design, PredictedRatio, SERIES, asked};
use crate::DesignError;
use crate::chance_report::percent;
use crate::multi_fidelity::MultiFidelityLoop;
use crate::task::DesignTask;
use slipgrid_units::tidy;

/// The chance of the design that was found, with what trials say that the model lacks; before any trial with what is believed of
/// that.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AdviceReport {
    /// "series" where a cut sample is on target more likely than not, "trial" otherwise.
    pub advice: String,
    /// That chance.
    pub chance: f64,
    /// Trials that it rests on.
    pub trials: usize,
    /// In one line.
    pub words: String,
    /// What is predicted of a cut sample.
    pub predicted: Vec<PredictedRatio>,
}

impl MultiFidelityLoop<'_> {
    /// The advice for the design that was found; `None` where nothing is demanded, or where it cannot be computed.
    ///
    /// # Errors
    /// [`DesignError`] for trials that mean nothing, and where the monitor cancels.
    pub(crate) fn advice(
        &self,
        task: &DesignTask,
        material: &MaterialUncertainty,
    ) -> Result<Option<AdviceReport>, DesignError> {
        let (Some(best), Some(confirmed), Some(chances)) = (&self.best, &self.confirmed, &self.chances) else {
            return Ok(None);
        };
        if !task.target.has_demands() {
            return Ok(None);
        }
        let asked = asked(task, material, &self.further, &self.model)?;
        let found = Models::new(&self.model, material)?.at(&best.design).and_then(|modelled| {
            let ratio: Vec<f64> = modelled.log_ratio.iter().map(|log| log.exp()).collect();
            Ok((modelled, chances.covariance_of_made(&best.design, &ratio)?))
        });
        let (modelled, covariance) = match found {
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
        let design = Design::new(best.design, Modelled { log_ratio, ..modelled }, covariance);
        let judged = design.judged(&asked.learned.at(&asked.loads), &asked.wanted);
        let chance = judged.score.chance;
        let (advice, trials) = (if chance > SERIES { "series" } else { "trial" }, asked.learned.trials().len());
        let known_of = match trials {
            0 => "before any trial, by what is believed that the model lacks".to_owned(),
            1 => "with what one trial says that the model lacks".to_owned(),
            trials => format!("with what {trials} trials say that the model lacks"),
        };
        let words = format!("cut it as a {advice}: chance {}, {known_of}", percent(chance));
        let predicted = PredictedRatio::of(&asked, &judged);
        Ok(Some(AdviceReport { advice: advice.to_owned(), chance: tidy(chance), trials, words, predicted }))
    }
}
