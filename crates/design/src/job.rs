//! The job, from a task to a design: search, confirm, explain.

use slipgrid_export::Removal;
use slipgrid_material::Material;
use slipgrid_monitor::{Monitor, Remembering};
use slipgrid_optimize::{Candidate, ForwardModel, ModelFailure, Status, TradeOffs};
use slipgrid_pattern::Pattern;
use slipgrid_results::{MaterialReport, PatternReport, SCHEMA, VERSION, load_reports, model_notes};
use slipgrid_springblock::{Load, Scene, Simulation};
use slipgrid_units::{PRESSURE_MPA, tidy};

use crate::chance::Chances;
use crate::discrepancy_correction::DiscrepancyReport;
use crate::evaluation_cache::EvaluationCache;
use crate::explorer::Explorer;
use crate::learned::LearnedDiscrepancy;
use crate::multi_fidelity::{MultiFidelityLoop, time_statement};
use crate::outcome::{DesignReport, MisfitReport, patterns};
use crate::target_report::{GoalReport, TargetReport};
use crate::task::{DesignTask, KnownMaterial, TradeOffsWanted};
use crate::time_budget::TimeBudget;
use crate::timings::Timings;
use crate::{
    DesignError, chance_report, explorer, flat_is_best, lattice_table, operating_conditions, pattern_effect,
    reachable_range, rim_sensitivity, robustness, selection, sensitivity, trade_offs, uncertainty_budget,
};

/// What a job found.
#[derive(Clone, Debug)]
pub struct DesignOutcome {
    /// Everything that is reported, as result.json holds it.
    pub report: DesignReport,
    /// How the search ended.
    pub status: Status,
    /// The design.
    pub pattern: Pattern,
    /// The task with its conditions known.
    pub task: DesignTask,
    /// The material as it was used.
    pub material: KnownMaterial,
    /// The loads at the condition designed for.
    pub loads: Vec<Load>,
    /// The scene of the confirming run at that condition.
    pub scene: Scene,
    /// What came of it.
    pub confirmed: Simulation,
    /// Every design of a lattice, where the task asks for them.
    pub lattice: Option<Lattice>,
    /// Designs compared by goals, where the task asks for that.
    pub compared: Option<Compared>,
    /// What any design within the bounds does, where the task asks for it and it could be computed in time.
    pub explorer: Option<Explorer>,
}

/// Every design of a lattice with what the model says of it.
#[derive(Clone, Debug)]
pub struct Lattice {
    /// The designs.
    pub patterns: Vec<Pattern>,
    /// What the model says of each.
    pub answers: Vec<Result<Candidate, ModelFailure>>,
}

/// Designs compared by goals.
#[derive(Clone, Debug)]
pub struct Compared {
    /// The goals.
    pub wanted: TradeOffsWanted,
    /// Those that no other beats in every goal, and the others; none where no design can be compared.
    pub found: TradeOffs,
}

/// The pattern that does what `task` asks for, confirmed in time, with the chance that a cut sample is on target, what
/// limits it, and what else could be had. `cache` keeps the answers of the search's model beyond this run; `monitor` is told
/// of every stage, and ends any of them. Same task and seed give the same outcome but for times.
///
/// # Errors
/// [`DesignError`] for a task that is refused, that the monitor cancels, or whose time is spent before there is a design.
pub fn run(
    task: &DesignTask,
    cache: &mut dyn EvaluationCache,
    monitor: &dyn Monitor,
) -> Result<DesignOutcome, DesignError> {
    // Confirming runs share flat samples, also where the caller remembers nothing.
    let monitor = &Remembering::new(monitor);
    // A solve that was given up is no failure of the step that asked for it.
    every_step(task, cache, monitor).map_err(|error| match error {
        DesignError::Failed(_) if monitor.cancelled() => DesignError::Cancelled,
        other => other,
    })
}

/// The steps of [`run`], in their order.
fn every_step(
    task: &DesignTask,
    cache: &mut dyn EvaluationCache,
    monitor: &dyn Monitor,
) -> Result<DesignOutcome, DesignError> {
    let started_s = monitor.seconds();
    let budget = TimeBudget::new(monitor, task.max_seconds);
    let mut timings = Timings::default();
    let mut task = task.clone();
    let known = task.material.clone().ok_or_else(|| DesignError::refused("has no material"))?;
    task.check(&known)?;
    let KnownMaterial { mut material, uncertainty } = known;
    let conditions = task.condition.iter().chain(&task.also_at);
    let interpolated = conditions.filter_map(|condition| material.friction.interpolation(Some(condition)));
    material.provenance.notes.extend(interpolated);
    let (loads, outside) = task.loads(&material)?;
    let further = operating_conditions::further(&task, &material)?;
    task.target = task.target.at_conditions(1 + further.len());
    pattern_effect::demand_effect(&mut task);
    if task.table {
        lattice_table::check(&task)?;
    }
    let (design, uncertainty) = (&task, &uncertainty);

    let mut found = MultiFidelityLoop::new(design, &material, loads.clone(), further, budget, monitor, &mut timings)?;
    if design.discrepancy {
        let learned = LearnedDiscrepancy::new(design, uncertainty, &found.further, &found.model)?;
        found.model.aim_with(learned);
    }
    found.chances = Some(Chances::new(design, uncertainty, &found.model, &found.further)?);
    let conditions = std::iter::once(design.condition).chain(found.further.iter().map(|further| further.at.condition));
    let excess = conditions.map(|condition| uncertainty.excess(&design.pressures_pa(), condition.as_ref()));
    found.excess = excess.collect();
    found.keep_answers(design, cache)?;
    found.announce(design)?;
    found.run(design, &mut timings)?;
    let explanation = found.explain(design, &mut timings)?;
    let lattice = if design.table { found.compare(design, &mut timings)? } else { None };
    let (table, lattice) = lattice.unzip();
    let (Some(best), Some(predicted), Some(confirmed)) =
        (&found.round.best, &found.round.predicted, &found.round.confirmed)
    else {
        return Err(DesignError::Failed("the search ended without a design".to_owned()));
    };

    let pattern = best.design;
    let probing = budget.stage("slopes and tolerances");
    let target: TargetReport = (&design.target).into();
    let watched =
        |at: &Pattern| if probing.cancelled() { Err(ModelFailure::Cancelled) } else { found.model.respond(at) };
    let mut slopes = sensitivity::report(
        &watched,
        &pattern,
        design.layer.block_m,
        design.target.quantity().name(),
        &target.pressure_mpa,
    )?;
    if let Some(slopes) = &mut slopes {
        let asked = rim_sensitivity::Asked {
            model: &found.model,
            design: &pattern,
            pressures: target.pressure_mpa.len(),
            layer: &design.layer,
            tolerances: design.tolerances.as_ref().map(|scatter| &scatter.tolerances),
        };
        slopes.rim = rim_sensitivity::report(&asked, slopes, &|| probing.cancelled())?;
    }
    let (model, choice) = (&found.model, found.round.choice.as_ref());
    let about = robustness::About { model, pattern: &pattern, confirmed, choice, bar: &probing };
    let spread = robustness::of_design(design, uncertainty, &about)?;
    let value = &best.response.value;
    let confirming = found.confirming_scene(&pattern);
    let rim_std = found.chances.as_ref().and_then(|chances| chances.rim_std(&pattern));
    let failed = |failure: ModelFailure| DesignError::Failed(format!("discrepancy: {failure}"));
    let learned = found.model.learned();
    let lacking = learned.map(|learned| learned.each(&pattern)).transpose().map_err(failed)?;
    let errors = uncertainty_budget::of_design(
        design,
        uncertainty,
        (&confirming, confirmed),
        value,
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
    let conditions = found.conditions_report(design, uncertainty, lacking.as_deref(), &errors.report, &outside)?;
    let reachable = reachable_range::of_search(design, uncertainty, &found, &probing)?;
    let mut cut_short = found.cut_short.clone();
    cut_short.extend(probing.is_out_of_time().then_some("slopes and tolerances"));
    timings.uncertainty = probing.finish();
    monitor.heed()?;

    let comparing = budget.stage("trade-offs");
    let selection = found.round.selection.as_ref();
    let traded = trade_offs::report(design, &found.model, (&pattern, value), selection, &comparing)?;
    cut_short.extend(
        (design.trade_offs.is_some() && comparing.is_out_of_time() && traded.is_none()).then_some("trade-offs"),
    );
    timings.trade_offs = comparing.finish();
    monitor.heed()?;
    let (traded, compared) = traded.unzip();

    let exploring = budget.stage("explorer");
    let (numerical, _) = chance_report::numerical(design, &model.scales(&pattern), confirmed, &errors.report);
    let chances = found.chances.as_ref();
    let anchor = explorer::Anchor { design: &pattern, values: value, chances, numerical: &numerical };
    let (explorer, unexplored) = explorer::explore_beside(design, model, &anchor, &exploring);
    cut_short.extend((exploring.is_out_of_time() && explorer.is_none()).then_some("explorer"));
    timings.explorer = exploring.finish();
    monitor.heed()?;

    let flat = found.flat_is_best(design);
    let suffices = flat.as_ref().is_some_and(|flat| flat.suffices);
    let laid = design.specimen.layout(pattern).map_err(|error| DesignError::refused(error.to_string()))?;
    let removal = Removal::new(&laid, &design.laser);
    // What the vertical plane leaves out needs saying, and only of patterns that have it.
    let is_spatial = found.model.is_spatial();
    let sectioned = Some(&pattern).filter(|_| !is_spatial);
    let mut model = confirmed.model.clone();
    model.extend(found.condition_statements(design));
    model.extend(found.statements());
    model.extend(time_statement(&cut_short));
    model.extend(unexplored.map(Into::into));
    model.extend(measured_range(&material, &outside));
    model.extend(model_notes(sectioned, &material.provenance));
    let report = DesignReport {
        program: "slipgrid".into(),
        version: VERSION.into(),
        schema: SCHEMA,
        name: design.name.clone(),
        date: design.date.clone(),
        status: if suffices { flat_is_best::FLAT_IS_BEST } else { found.status.name() }.into(),
        flat,
        chance,
        advice,
        selection: found.round.selection.as_ref().and_then(selection::Chosen::report),
        design: PatternReport::from(&pattern),
        specimen_areal_density: tidy(laid.areal_density()),
        bursts: design.laser.bursts(pattern.depth_m()),
        passes: removal.as_ref().map(|removal| removal.passes),
        removal,
        dimensions: if is_spatial { 3 } else { 2 },
        section_model: sectioned.is_some_and(|pattern| pattern.dimensions() > 2),
        fidelity: found.round.confirming.fidelity.name().into(),
        extent: found.round.confirming.extent.name().into(),
        target,
        predicted: load_reports(predicted, sectioned, &outside),
        predicted_value: value[..loads.len()].to_vec(),
        confirmed: load_reports(confirmed, sectioned, &outside),
        discrepancy: learned
            .zip(lacking.as_ref())
            .zip(errors.physics.as_ref())
            .map(|((learned, lacking), physics)| DiscrepancyReport::new(design, learned.trials(), lacking, physics)),
        goal: GoalReport::new(&design.target, value, found.confirmed_values().as_deref(), &errors.report),
        errors: errors.report,
        conditions,
        misfit: MisfitReport { predicted: best.misfit.max, confirmed: found.confirmed_misfit(design) },
        violations: best.violations.iter().map(ToString::to_string).collect(),
        sensitivities: slopes,
        robustness: spread,
        trade_offs: traded,
        reachable,
        explanation,
        table,
        alternatives: patterns(&found.round.alternatives),
        evaluations: found.evaluations,
        solid_evaluations: found.solid_evaluations,
        out_of_time: found.out_of_time,
        cut_short: cut_short.into_iter().map(Into::into).collect(),
        failed_trials: found.failed_trials,
        rounds: found.rounds,
        history: found.history.clone(),
        model,
        material: MaterialReport::from(&material.provenance),
        specimen: (&design.specimen).into(),
        laser: design.laser,
        timings_s: timings,
        wall_s: monitor.seconds() - started_s,
        threads: rayon::current_num_threads(),
        seed: design.seed,
    };
    Ok(DesignOutcome {
        report,
        status: found.status,
        pattern,
        loads,
        scene: confirming,
        confirmed: confirmed.clone(),
        lattice,
        compared,
        explorer,
        material: KnownMaterial { material, uncertainty: uncertainty.clone() },
        task: task.clone(),
    })
}

/// From where to where friction was measured, where one of the pressures is `outside`.
fn measured_range(material: &Material, outside: &[bool]) -> Option<String> {
    let [low, high] = material.friction.measured_pressures_pa().filter(|_| outside.contains(&true))?;
    let [low, high] = [low, high].map(|pressure_pa| tidy(PRESSURE_MPA.from_si(pressure_pa)));
    Some(format!(
        "friction was measured from {low} to {high} MPa; beyond that the nearest measurement's coefficients were taken"
    ))
}
