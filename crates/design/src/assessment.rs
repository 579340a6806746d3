//! How far the design that was found can be trusted, and what moves it: slopes, tolerances, errors, the chance that a cut sample is on
//! target, what trials advise, other conditions, and what other designs reach.

use slipgrid_calibrate::uncertainty::DiscrepancyAt;
use slipgrid_monitor::{Monitor, Stage};
use slipgrid_optimize::{ModelFailure, Response};
use slipgrid_pattern::Pattern;
use slipgrid_springblock::Scene;

use crate::best_round::BestDesign;
use crate::chance::Chances;
use crate::chance_report::ChanceReport;
use crate::conditions_report::ConditionsReport;
use crate::explorer::{self, Explorer};
use crate::multi_fidelity::MultiFidelityLoop;
use crate::next_trial::AdviceReport;
use crate::prepared_task::PreparedTask;
use crate::reachable_range::ReachableReport;
use crate::robustness_report::RobustnessReport;
use crate::sensitivity::SensitivityReport;
use crate::target_report::TargetReport;
use crate::task::DesignTask;
use crate::uncertainty_budget::DesignErrors;
use crate::{
    DesignError, chance_report, reachable_range, rim_sensitivity, robustness, sensitivity, uncertainty_budget,
};

/// What is known of a design beside its friction.
pub struct Assessment {
    /// The scene of its confirming run.
    pub confirming: Scene,
    /// How the target's quantity moves with its dimensions.
    pub slopes: Option<SensitivityReport>,
    /// What tolerances make of it.
    pub spread: Option<RobustnessReport>,
    /// The error beside every number.
    pub errors: DesignErrors,
    /// What trials say that the model lacks of it, at each load.
    pub lacking: Option<Vec<DiscrepancyAt>>,
    /// The chance that a cut sample is on target.
    pub chance: Option<ChanceReport>,
    /// Whether to cut it as a series or as a trial.
    pub advice: Option<AdviceReport>,
    /// What it does at every condition.
    pub conditions: Option<ConditionsReport>,
    /// What designs within bounds and limits reach.
    pub reachable: Vec<ReachableReport>,
}

impl Assessment {
    /// Of the design `best` of all that was `found`; what costs time ends with `probing`.
    ///
    /// # Errors
    /// [`DesignError`] where the model fails at the design, and for an area law that cannot be moved.
    pub(crate) fn new(
        prepared: &PreparedTask,
        found: &MultiFidelityLoop<'_>,
        best: BestDesign<'_>,
        probing: &Stage<'_>,
    ) -> Result<Self, DesignError> {
        let PreparedTask { task: design, uncertainty, .. } = prepared;
        let pattern = best.pattern();
        let slopes = slopes(design, found, &pattern, probing)?;
        let (model, choice) = (&found.model, found.round.choice.as_ref());
        let (confirmed, further) = (best.confirmed, &found.further[..]);
        let about = robustness::About { model, pattern: &pattern, confirmed, further, choice, bar: probing };
        let spread = robustness::of_design(design, uncertainty, &about)?;
        let confirming = found.confirming_scene(&pattern);
        let rim_std = found.chances.as_ref().and_then(|chances| chances.rim_std(&pattern));
        let failed = |failure: ModelFailure| DesignError::Failed(format!("discrepancy: {failure}"));
        let lacking = model.learned().map(|learned| learned.each(&pattern)).transpose().map_err(failed)?;
        let errors = uncertainty_budget::of_design(
            design,
            uncertainty,
            (&confirming, best.confirmed),
            best.value(),
            rim_std.as_deref(),
            lacking.as_deref(),
        )?;
        let chance = match found.chances.as_ref() {
            Some(chances) => found.chance(design, uncertainty, chances, &errors.report)?,
            None => None,
        };
        let (chance, expansion) = chance.unzip();
        let aimed = chance.as_ref().and_then(|chance| chance.value).filter(|_| design.discrepancy);
        let advice = found.advice(design, uncertainty, (&errors.report, expansion.flatten().as_ref()), aimed)?;
        let conditions =
            found.conditions_report(design, uncertainty, lacking.as_deref(), &errors.report, &prepared.outside)?;
        let reachable = reachable_range::of_search(design, uncertainty, found, probing)?;
        Ok(Self { confirming, slopes, spread, errors, lacking, chance, advice, conditions, reachable })
    }

    /// What any design within the bounds does, anchored at the one found; otherwise why not, where something is to be said.
    pub(crate) fn explore(
        &self,
        design: &DesignTask,
        found: &MultiFidelityLoop<'_>,
        best: BestDesign<'_>,
        exploring: &Stage<'_>,
    ) -> (Option<Explorer>, Option<&'static str>) {
        let pattern = best.pattern();
        let scales = found.model.scales(&pattern);
        let (numerical, _) = chance_report::numerical(design, &scales, best.confirmed, &self.errors.report);
        let chances = found.chances.as_ref();
        let anchor = explorer::Anchor { design: &pattern, values: best.value(), chances, numerical: &numerical };
        explorer::explore_beside(design, &found.model, &anchor, exploring)
    }
}

/// How the target's quantity moves with the dimensions of the design `pattern` and with the height of its rims.
fn slopes(
    design: &DesignTask,
    found: &MultiFidelityLoop<'_>,
    pattern: &Pattern,
    probing: &Stage<'_>,
) -> Result<Option<SensitivityReport>, DesignError> {
    let target: TargetReport = (&design.target).into();
    let watched = |at: &Pattern| {
        if probing.cancelled() { Err(ModelFailure::Cancelled) } else { found.model.respond_made(at, pattern) }
    };
    let (block_m, quantity) = (design.layer.block_m, design.target.quantity().name());
    let mut slopes = sensitivity::report(&watched, pattern, block_m, quantity, &target.pressure_mpa)?;
    if let Some(slopes) = &mut slopes {
        if let Some(fine) = found.chances.as_ref().and_then(Chances::fine) {
            let heeded = |answer: &dyn Fn() -> Result<Vec<f64>, ModelFailure>| {
                if probing.cancelled() {
                    return Err(ModelFailure::Cancelled);
                }
                Ok(Response { value: answer()?, limited: Vec::new() })
            };
            // The slopes have asked for these cells before.
            let own = |at: &Pattern| heeded(&|| found.model.ratios_kept(at, &found.model.lay(pattern)?));
            let half = |at: &Pattern| heeded(&|| fine.ratios_made(at, &fine.lay(pattern)?));
            // Where smaller blocks have no answer, nothing more is known of the errors.
            match slopes.add_blocks([&own, &half], pattern, block_m, &found.model.scales(pattern)) {
                Ok(()) | Err(ModelFailure::Trial { .. } | ModelFailure::Cancelled) => {}
                Err(failure) => return Err(DesignError::Failed(format!("slopes: {failure}"))),
            }
        }
        let asked = rim_sensitivity::Asked {
            model: &found.model,
            design: pattern,
            pressures: target.pressure_mpa.len(),
            layer: &design.layer,
            tolerances: design.tolerances.as_ref().map(|scatter| &scatter.tolerances),
        };
        slopes.rim = rim_sensitivity::report(&asked, slopes, &|| probing.cancelled())?;
    }
    Ok(slopes)
}
