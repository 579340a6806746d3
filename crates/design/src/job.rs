//! Job of `optimize`, from a task to a design: the texture with the maximum chance of a sample on target, confirmed by
//! a dynamic run.

use crate::results::{MadeBy, load_reports, measured_range, section_note};
use slipgrid_base::monitor::{CachingMonitor, Monitor};
use slipgrid_base::units::tidy;
use slipgrid_laser::export::{Removal, burst_warnings};
use slipgrid_model::pattern::Pattern;
use slipgrid_model::springblock::{Load, Scene, Simulation};

use crate::DesignError;
use crate::advice::Advice;
use crate::blocked::{blocked_by, bounds_reached};
use crate::confirmation::confirm;
use crate::design_report::{DesignReport, GoalReport, SCHEMA};
use crate::evaluation_cache::EvaluationCache;
use crate::explorer::Explorer;
use crate::lattice_table::Lattice;
use crate::operating_conditions::statements;
use crate::prepared_task::PreparedTask;
use crate::search::{Found, Search};
use crate::sensitivities::local_law_note;
use crate::session::with_table;
use crate::slopes::slopes;
use crate::task::{DesignTask, KnownMaterial};
use crate::time_budget::{SEARCH_SHARE, TimeBudget};
use crate::timings::Timings;
use crate::trade_offs::{self, Compared};

/// Maximum number of alternative textures in the report.
const OTHERS: usize = 3;

/// Result of a design job.
#[derive(Clone, Debug)]
pub struct DesignOutcome {
    /// Report as written to result.json.
    pub report: DesignReport,
    /// Recommended action.
    pub advice: Advice,
    /// Pattern of the design.
    pub pattern: Pattern,
    /// Task with resolved conditions.
    pub task: DesignTask,
    /// Material with its uncertainty.
    pub material: KnownMaterial,
    /// Loads at the condition of the design.
    pub loads: Vec<Load>,
    /// Scene of the dynamic run that confirms the design, at the design condition.
    pub scene: Scene,
    /// Result of the dynamic run that confirms the design.
    pub confirmed: Simulation,
    /// Predictions for all designs in whole blocks and bursts; `None` unless the task requests them.
    pub lattice: Option<Lattice>,
    /// Designs compared by the goals of the trade-offs; `None` if the task names none.
    pub compared: Option<Compared>,
    /// Predictions for all designs within the bounds; `None` unless the task requests them.
    pub explorer: Option<Explorer>,
}

/// Finds the texture with the maximum chance for `task`, confirms it by a dynamic run, and reports the inputs that
/// limit the chance and alternative textures. `cache` stores results of the model for later jobs; `monitor` receives
/// every stage and can cancel. Equal tasks with equal seeds give equal outcomes, except for times.
///
/// # Errors
/// [`DesignError`] for a task that is refused, that the monitor cancels, or whose time limit ends before a design is
/// found, and if no design can be computed.
pub fn run(
    task: &DesignTask,
    cache: &mut dyn EvaluationCache,
    monitor: &dyn Monitor,
) -> Result<DesignOutcome, DesignError> {
    // Confirming runs share flat samples even if the caller caches nothing.
    let monitor = &CachingMonitor::new(monitor);
    // A cancelled solve is not a failure of the step that requested it.
    every_step(task, cache, monitor).map_err(|error| match error {
        DesignError::Failed(_) if monitor.cancelled() => DesignError::Cancelled,
        other => other,
    })
}

/// Performs the steps of [`run`] in order.
fn every_step(
    task: &DesignTask,
    cache: &mut dyn EvaluationCache,
    monitor: &dyn Monitor,
) -> Result<DesignOutcome, DesignError> {
    let started_s = monitor.seconds();
    let budget = TimeBudget::new(monitor, task.search.max_seconds, SEARCH_SHARE);
    let prepared = &PreparedTask::new(task)?;
    let mut timings = Timings::default();
    let mut outcome = with_table(prepared, None, Some(cache), budget, &mut timings, |search, timings| {
        let searching_s = monitor.seconds();
        let found = search.best(&|_| true, 1);
        timings.search += monitor.seconds() - searching_s;
        monitor.heed()?;
        reported(search, &found, budget, timings)
    })?;
    outcome.report.wall_s = monitor.seconds() - started_s;
    timings.count_rest(outcome.report.wall_s);
    outcome.report.timings_s = timings;
    outcome.report.threads = rayon::current_num_threads();
    Ok(outcome)
}

/// Builds the report of `found` with its confirming run.
fn reported(
    search: &Search<'_>,
    found: &Found,
    budget: TimeBudget<'_>,
    timings: &mut Timings,
) -> Result<DesignOutcome, DesignError> {
    let Search { prepared, task, asked, .. } = *search;
    let monitor = budget.monitor;
    let mut cut_short: Vec<&'static str> = Vec::new();
    if search.stage.cancelled() {
        cut_short.push("search");
    }
    let Some(best) = found.solved.first() else { return Err(search.nothing_found()) };
    let pattern = best.texture.pattern;
    let stage = budget.stage("confirmation");
    let (scene, confirmed) = confirm(prepared, search.models.own, (&pattern, best.texture.run.as_deref()), &stage)?;
    cut_short.extend(stage.is_out_of_time().then_some("confirmation"));
    timings.confirm = stage.finish();
    monitor.heed()?;

    let advice = Advice::of(search, best, found.is_within_reach);
    let beside_s = monitor.seconds();
    let is_missed = !matches!(advice, Advice::DoNotTexture | Advice::MeasureAgain { .. });
    let is_out_of_reach = asked.has_demands() && !found.is_within_reach && is_missed;
    let breaks_limits = asked.has_demands() && advice == Advice::CannotBeMet { keeps_limits: false };
    let blocked =
        if is_out_of_reach || breaks_limits { blocked_by(search, best, found.is_within_reach) } else { Vec::new() };
    let can_gain = asked.has_demands() && !is_out_of_reach && matches!(advice, Advice::Trial | Advice::Series);
    let reached = if can_gain { bounds_reached(task, &pattern) } else { Vec::new() };
    let slopes = slopes(search, best);
    let (trade_offs, compared) = trade_offs::of(search, (best, Some(&confirmed)), &found.solved).unzip();
    let own = best.full_report(search);
    let worth_cutting =
        if matches!(advice, Advice::CannotBeMet { .. } | Advice::MeasureAgain { .. }) { 1 } else { 1 + OTHERS };
    let others = search.unlike(&found.solved, 1, worth_cutting);
    let others = others.iter().skip(1).map(|of| of.report(search).beside(&own)).collect();
    timings.trade_offs = monitor.seconds() - beside_s;
    monitor.heed()?;
    let lattice = task.search.table.then(|| Lattice::new(search));
    monitor.heed()?;
    let exploring_s = monitor.seconds();
    let explorer = task.explorer.then(|| Explorer::new(search, best, Some(&confirmed))).flatten();
    timings.explorer = monitor.seconds() - exploring_s;
    monitor.heed()?;
    if search.stage.cancelled() && !cut_short.contains(&"search") {
        cut_short.push("trade-offs and explorer");
    }

    let laid = task.specimen.layout(pattern).map_err(|error| DesignError::refused(error.to_string()))?;
    let depth_std_um = task.assumed_tolerances().and_then(|of| of.depth_um);
    let removal = Removal::new(&laid, &task.laser).map(|removal| removal.with_depth_tolerance(depth_std_um));
    let section = search.models.own.dimension().section_of(&pattern);
    let measured_mpa = task.measured_mpa(&prepared.material, &prepared.outside);
    let mut said = confirmed.statements.clone();
    said.model.extend(statements(prepared));
    search.models.own.describe(&mut said);
    let (local_law, _) = asked.learned.local_law();
    if let Some(note) = local_law_note(&best.texture.sensitivity, &asked.loads, local_law) {
        said.model(note);
    }
    if !cut_short.is_empty() {
        said.model(format!("cut short by max_seconds: {}", cut_short.join(", ")));
    }
    if let Some(range) = measured_mpa {
        said.model(format!("{}; beyond that the nearest measurement's coefficients were taken", measured_range(range)));
    }
    said.model.extend(section.map(section_note));
    let report = DesignReport {
        made_by: MadeBy::slipgrid(SCHEMA),
        name: task.name.clone(),
        date: task.date.clone(),
        advice: advice.name().into(),
        words: advice.words(best.chance(), asked.has_demands(), found.is_within_reach),
        trials: asked.learned.trials().len(),
        sample: own,
        goal: GoalReport::of(search, best),
        others,
        blocked_by: blocked,
        at_bounds: reached.iter().map(ToString::to_string).collect(),
        slopes,
        trade_offs,
        compared: found.compared,
        table: search.table.report.clone(),
        specimen_areal_density: tidy(laid.areal_density()),
        bursts: task.laser.bursts(pattern.depth_m()),
        passes: removal.as_ref().map(|removal| removal.passes),
        laser_warnings: burst_warnings(&laid, &task.laser),
        removal,
        block_um: tidy(task.block_um()),
        dimensions: search.models.own.dimension().number(),
        section_model: section.is_some(),
        fidelity: scene.run.fidelity.name().into(),
        extent: scene.run.extent.name().into(),
        target: (&task.target).into(),
        confirmed: load_reports(&confirmed, section, &prepared.outside),
        cut_short: cut_short.into_iter().map(Into::into).collect(),
        model: said.model,
        method: said.method,
        measured_mpa,
        material: prepared.material.provenance.clone(),
        specimen: (&task.specimen).into(),
        laser: task.laser,
        tolerances: task.assumed_tolerances(),
        seed: task.search.seed,
        ..DesignReport::default()
    };
    let loads = prepared.loads().to_vec();
    let PreparedTask { task, material, uncertainty, .. } = prepared.clone();
    let material = KnownMaterial { material, uncertainty };
    Ok(DesignOutcome { report, advice, pattern, task, material, loads, scene, confirmed, lattice, compared, explorer })
}
