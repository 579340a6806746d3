//! What trials say of the design that was found: whether to cut it as a series or as a trial.

use serde::{Deserialize, Serialize};
use slipgrid_optimize::ModelFailure;
use slipgrid_pattern::Pattern;
use slipgrid_springblock::{Scene, Simulation};

use super::interpolation::{Modelled, Models};
use super::{Design, PredictedRatio, SERIES, asked};
use crate::chance_report::percent;
use crate::operating_conditions::Further;
use crate::steady_model::SteadyModel;
use crate::task::DesignTask;
use crate::{DesignError, KnownMaterial};
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

/// What is found in the end.
pub struct Found<'a> {
    /// The scene of the condition designed for.
    pub scene: &'a Scene,
    /// Where the target must hold beside it.
    pub further: &'a [Further],
    /// The search's model.
    pub model: &'a SteadyModel<'a>,
    /// The design.
    pub pattern: &'a Pattern,
    /// Its confirming run at the condition designed for.
    pub confirmed: &'a Simulation,
}

/// The advice for the design `found` of `task`; `None` where nothing is demanded, or where it cannot be computed.
///
/// # Errors
/// [`DesignError`] for trials that mean nothing, and where the monitor cancels.
pub fn of_design(
    task: &DesignTask,
    known: &KnownMaterial,
    found: &Found<'_>,
) -> Result<Option<AdviceReport>, DesignError> {
    if !task.target.has_demands() {
        return Ok(None);
    }
    let asked = asked(task, known, found.scene, found.further, found.model)?;
    let models = Models::new(found.model)?;
    let modelled = match models.at(found.pattern) {
        Ok(modelled) => modelled,
        Err(ModelFailure::Cancelled) => return Err(DesignError::Cancelled),
        Err(_) => return Ok(None),
    };
    let Some(covariance) = covariance(task, found, &modelled) else { return Ok(None) };
    // ln R of the run in time where there is one; elsewhere the steady one, off by as much as there.
    let count = task.target.points().len();
    let off = |load: usize| {
        let ratio = found.confirmed.loads.get(load).and_then(|at| at.ratio)?;
        Some(ratio.ln() - modelled.log_ratio[load])
    };
    let log_ratio = modelled.log_ratio.iter().enumerate();
    let log_ratio = log_ratio.map(|(load, log)| log + off(load % count).unwrap_or(0.0)).collect();
    let design = Design::new(*found.pattern, Modelled { log_ratio, ..modelled }, covariance);
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

/// Covariance of ln R of samples by their dimensions: differences of the steady model over a standard deviation each way.
fn covariance(task: &DesignTask, found: &Found<'_>, modelled: &Modelled) -> Option<Vec<f64>> {
    let count = modelled.log_ratio.len();
    let std_m = task.tolerances.map_or([0.0; 3], |scatter| scatter.tolerances.std_m);
    let own = found.pattern;
    let mut covariance = vec![0.0; count * count];
    for axis in (0..3).filter(|axis| std_m[*axis] > 0.0) {
        let at = |side: f64| {
            let mut lengths_m = [own.width_m(), own.spacing_m(), own.depth_m()];
            lengths_m[axis] = (lengths_m[axis] + side * std_m[axis]).max(0.1 * lengths_m[axis]);
            let made = Pattern::new(*own.texture(), lengths_m[0], lengths_m[1], lengths_m[2]).ok()?;
            found.model.ratios_made(&made, own).ok()
        };
        let slope: Vec<f64> = match (at(1.0), at(-1.0)) {
            (Some(above), Some(below)) => above.iter().zip(&below).map(|(a, b)| 0.5 * (a / b).ln()).collect(),
            // Samples to one side cannot be computed: the other one and the design.
            (Some(one), None) | (None, Some(one)) => {
                one.iter().zip(&modelled.log_ratio).map(|(one, own)| one.ln() - own).collect()
            }
            (None, None) => return None,
        };
        for l in 0..count {
            for m in 0..count {
                covariance[l * count + m] += slope[l] * slope[m];
            }
        }
    }
    Some(covariance)
}
