//! The job, from a task to a design: search, confirm, explain.

use slipgrid_export::{Removal, burst_warnings};
use slipgrid_monitor::{Monitor, Remembering};
use slipgrid_optimize::{Candidate, ModelFailure, Status, TradeOffs};
use slipgrid_pattern::Pattern;
use slipgrid_results::{MaterialReport, PatternReport, SCHEMA, VERSION, load_reports, measured_range, model_notes};
use slipgrid_springblock::{Load, Scene, Simulation, Statements};
use slipgrid_units::tidy;

use crate::assessment::Assessment;
use crate::best_round::BestDesign;
use crate::chance::Chances;
use crate::design_report::{DesignReport, MisfitReport, patterns};
use crate::discrepancy_correction::DiscrepancyReport;
use crate::evaluation_cache::EvaluationCache;
use crate::explorer::Explorer;
use crate::learned_discrepancy::LearnedDiscrepancy;
use crate::multi_fidelity::{MultiFidelityLoop, time_statement};
use crate::prepared_task::PreparedTask;
use crate::target_report::GoalReport;
use crate::task::{DesignTask, KnownMaterial, TradeOffsWanted};
use crate::time_budget::TimeBudget;
use crate::timings::Timings;
use crate::{DesignError, flat_is_best, selection, trade_offs};

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
    let prepared = PreparedTask::new(task)?;
    let design = &prepared.task;

    let mut found = search_and_confirm(&prepared, cache, budget, monitor, &mut timings)?;
    let explanation = found.explain(design, &mut timings)?;
    let (table, lattice) = if design.table { found.compare(design, &mut timings)? } else { None }.unzip();
    let best = found.round.best_design()?;
    let mut cut_short = found.cut_short.clone();

    let probing = budget.stage("slopes and tolerances");
    let assessed = Assessment::new(&prepared, &found, best, &probing)?;
    cut_short.extend(probing.is_out_of_time().then_some("slopes and tolerances"));
    timings.uncertainty = probing.finish();
    monitor.heed()?;

    let comparing = budget.stage("trade-offs");
    let selection = found.round.selection.as_ref();
    let traded = trade_offs::report(design, &found.model, (&best.pattern(), best.value()), selection, &comparing)?;
    cut_short.extend(
        (design.trade_offs.is_some() && comparing.is_out_of_time() && traded.is_none()).then_some("trade-offs"),
    );
    timings.trade_offs = comparing.finish();
    monitor.heed()?;
    let (trade_offs, compared) = traded.unzip();

    let exploring = budget.stage("explorer");
    let (explorer, unexplored) = assessed.explore(design, &found, best, &exploring);
    cut_short.extend((exploring.is_out_of_time() && explorer.is_none()).then_some("explorer"));
    timings.explorer = exploring.finish();
    monitor.heed()?;

    let scene = assessed.confirming.clone();
    let measured_mpa = prepared.task.measured_mpa(&prepared.material, &prepared.outside);
    let said = statements(&prepared, &found, best, measured_mpa, (&cut_short, unexplored));
    let report = DesignReport {
        trade_offs,
        explanation,
        table,
        model: said.model,
        method: said.method,
        measured_mpa,
        cut_short: cut_short.into_iter().map(Into::into).collect(),
        timings_s: timings,
        wall_s: monitor.seconds() - started_s,
        threads: rayon::current_num_threads(),
        ..report_of(&prepared, &found, best, assessed)?
    };
    let (status, pattern, confirmed) = (found.status, best.pattern(), best.confirmed.clone());
    let PreparedTask { task, material, uncertainty, loads, .. } = prepared.clone();
    let material = KnownMaterial { material, uncertainty };
    Ok(DesignOutcome { report, status, pattern, loads, scene, confirmed, lattice, compared, explorer, material, task })
}

/// Rounds of searches and confirming runs, ended, and what the chance of designs rests on.
fn search_and_confirm<'a>(
    prepared: &'a PreparedTask,
    cache: &'a mut dyn EvaluationCache,
    budget: TimeBudget<'a>,
    monitor: &'a dyn Monitor,
    timings: &mut Timings,
) -> Result<MultiFidelityLoop<'a>, DesignError> {
    let PreparedTask { task: design, material, uncertainty, loads, further, .. } = prepared;
    let mut found = MultiFidelityLoop::new(design, material, loads.clone(), further.clone(), budget, monitor, timings)?;
    if design.discrepancy {
        let learned = LearnedDiscrepancy::new(design, uncertainty, &found.further, &found.model)?;
        found.model.aim_with(learned);
    }
    found.chances = Some(Chances::new(design, uncertainty, &found.model, &found.further)?);
    let conditions = std::iter::once(design.condition).chain(further.iter().map(|further| further.at.condition));
    let excess = conditions.map(|condition| uncertainty.excess(&design.pressures_pa(), condition.as_ref()));
    found.excess = excess.collect();
    found.keep_answers(design, cache)?;
    found.announce(design)?;
    found.run(design, timings)?;
    Ok(found)
}

/// What was modelled of the design that was found, what was not, and how it was computed.
fn statements(
    prepared: &PreparedTask,
    found: &MultiFidelityLoop<'_>,
    best: BestDesign<'_>,
    measured_mpa: Option<[f64; 2]>,
    (cut_short, unexplored): (&[&str], Option<&'static str>),
) -> Statements {
    let mut said = best.confirmed.statements.clone();
    said.model.extend(found.condition_statements(&prepared.task));
    found.describe(&mut said);
    said.model.extend(time_statement(cut_short));
    said.model.extend(unexplored.map(Into::into));
    if let Some(range) = measured_mpa {
        said.model(format!("{}; beyond that the nearest measurement's coefficients were taken", measured_range(range)));
    }
    said.model.extend(model_notes(found.model.dimension().section_of(&best.pattern()), &prepared.material.provenance));
    said
}

/// The record of the design itself, without what was found beside it and without times.
fn report_of(
    prepared: &PreparedTask,
    found: &MultiFidelityLoop<'_>,
    best: BestDesign<'_>,
    assessed: Assessment,
) -> Result<DesignReport, DesignError> {
    let (design, pattern, value) = (&prepared.task, best.pattern(), best.value());
    let flat = found.flat_is_best(design);
    let suffices = flat.as_ref().is_some_and(|flat| flat.suffices);
    let laid = design.specimen.layout(pattern).map_err(|error| DesignError::refused(error.to_string()))?;
    let removal = Removal::new(&laid, &design.laser);
    let section = found.model.dimension().section_of(&pattern);
    let Assessment { slopes, spread, errors, lacking, chance, advice, conditions, reachable, .. } = assessed;
    let learned = found.model.learned().zip(lacking.as_ref()).zip(errors.physics.as_ref());
    Ok(DesignReport {
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
        laser_warnings: burst_warnings(&laid, &design.laser),
        removal,
        block_um: tidy(design.block_um()),
        dimensions: found.model.dimension().number(),
        section_model: section.is_some(),
        fidelity: found.round.confirming.fidelity.name().into(),
        extent: found.round.confirming.extent.name().into(),
        target: (&design.target).into(),
        predicted: load_reports(best.predicted, section, &prepared.outside),
        predicted_value: value[..prepared.loads.len()].to_vec(),
        confirmed: load_reports(best.confirmed, section, &prepared.outside),
        discrepancy: learned
            .map(|((learned, lacking), physics)| DiscrepancyReport::new(design, learned.trials(), lacking, physics)),
        goal: GoalReport::new(&design.target, value, found.confirmed_values().as_deref(), &errors.report),
        errors: errors.report,
        conditions,
        misfit: MisfitReport { predicted: best.found.misfit.max, confirmed: found.confirmed_misfit(design) },
        violations: found.broken(design).iter().map(ToString::to_string).collect(),
        sensitivities: slopes,
        robustness: spread,
        reachable_among: Some(found.round.searched)
            .filter(|_| !found.model.is_cheap_per_design() && !reachable.is_empty()),
        reachable,
        alternatives: patterns(&found.round.alternatives),
        evaluations: found.evaluations,
        solid_evaluations: found.solid_evaluations,
        out_of_time: found.out_of_time,
        failed_trials: found.failed_trials,
        rounds: found.rounds,
        runs: found.runs,
        history: found.history.clone(),
        material: MaterialReport::from(&prepared.material.provenance),
        specimen: (&design.specimen).into(),
        laser: design.laser,
        tolerances: design.assumed_tolerances(),
        seed: design.seed,
        ..DesignReport::default()
    })
}
