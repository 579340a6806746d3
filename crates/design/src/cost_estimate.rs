//! Cost estimate of a design job, reported before it starts.

use slipgrid_base::monitor::Monitor;
use slipgrid_base::units::counted;
use slipgrid_infer::calibrate::uncertainty::{MaterialUncertainty, Slopes};
use slipgrid_model::material::Condition;
use slipgrid_model::pattern::Pattern;
use slipgrid_model::springblock::{
    Expense, Fidelity, Scene, SceneError, Unwatched, bounded, cell_expense, expense, simulate,
};

use crate::confirmation::confirming_scene;
use crate::prepared_task::PreparedTask;
use crate::steady_model::SteadyModel;
use crate::table::nodes;
use crate::{DesignError, Refusal};

/// Duration up to which no estimate is reported, in seconds.
const SHORT_S: f64 = 30.0;
/// Memory up to which no estimate is reported, in bytes.
const SMALL_BYTES: f64 = (1_u64 << 30) as f64;

/// Cost of a cell in the plane, whose equations are condensed, as a fraction of the cost of solving all equations.
const CONDENSED_SHARE: f64 = 0.03;
/// Cost of a cell in space at the looser force balance of tables, as a fraction of the cost at the force balance of
/// runs.
const LOOSE_SHARE: f64 = 0.3;
/// Cost of the cells solved after the table over the cost of the table, in the plane: for derivatives, neighbours, and
/// smaller blocks.
const AFTER_TABLE: f64 = 1.0;
/// Cost of the cells solved after the table over the cost of the table, in space. For about 100 cells of the table in
/// the requested blocks, 150 are solved for derivatives by Young's modulus, 108 in blocks of half the size at eight
/// times the cost, and up to 200 for trade-offs and the explorer.
const AFTER_TABLE_IN_SPACE: f64 = 12.0;
/// Typical ratio of the length of a confirming run, which continues until the standard error is small enough, to the
/// minimum length.
const CONFIRMED_TIMES: f64 = 1.5;

/// Reports to `monitor` the estimated cost of the table, of the search and, if `is_confirmed`, of the confirming run,
/// if this cost is large. The estimate lies between the costs of designs in the middle of the bounds and of the largest
/// cells.
///
/// # Errors
/// [`DesignError`] if the confirming run exceeds the limits on memory or time.
pub fn announce(
    prepared: &PreparedTask,
    model: &SteadyModel<'_>,
    is_confirmed: bool,
    monitor: &dyn Monitor,
) -> Result<(), DesignError> {
    let space = &prepared.task.space;
    let Ok(pattern) = space.middle() else { return Ok(()) };
    let cell = model.cell(&pattern, false);
    let confirmed = confirming_scene(prepared, model, &pattern, prepared.task.search.from_rest);
    // An invalid design in the middle of the bounds does not make other designs invalid.
    if cell.validate().is_err() || confirmed.validate().is_err() {
        return Ok(());
    }
    if is_confirmed {
        bounded(&confirmed).map_err(|error| Refusal::of_cost("confirming runs", &error))?;
    }
    // The nodes cover the whole space, and the largest cells cost most.
    let widest = space.pattern([space.width_m()[1], space.spacing_m()[1], pattern.depth_m()]).ok();
    let largest =
        |scene: &dyn Fn(&Pattern) -> Scene| widest.as_ref().map(scene).filter(|scene| scene.validate().is_ok());
    let spread_s = |coarse: bool| {
        let own_s = cell_expense(&model.cell(&pattern, coarse)).core_s;
        let largest = largest(&|widest| model.cell(widest, coarse));
        f64::midpoint(own_s, largest.map_or(own_s, |scene| cell_expense(&scene).core_s))
    };
    let [nodes, lifting] = nodes(&prepared.task, model);
    let (share, after) =
        if model.is_cheap_per_design() { (CONDENSED_SHARE, AFTER_TABLE) } else { (LOOSE_SHARE, AFTER_TABLE_IN_SPACE) };
    let asked = if lifting > 0.0 { lifting } else { nodes };
    let of_guide = if lifting > 0.0 { nodes * spread_s(true) } else { 0.0 };
    let search_s = share * (of_guide + asked * (1.0 + after) * spread_s(false));
    let threads = rayon::current_num_threads() as f64;
    let bytes = cell_expense(&largest(&|widest| model.cell(widest, false)).unwrap_or(cell)).bytes * threads;
    let run = expense(&confirmed);
    // Cost of a cell grows with the square of the pitch; the texture found is equally likely on either side of the
    // geometric mean.
    let longest = largest(&|widest| confirming_scene(prepared, model, widest, prepared.task.search.from_rest));
    let run = longest.map_or(run, |longest| geometric_mean(run, expense(&longest)));
    let (of_run, bytes) = if is_confirmed { (CONFIRMED_TIMES, run.bytes.max(bytes)) } else { (0.0, bytes) };
    let all =
        Expense { core_s: search_s + of_run * run.core_s, wall_s: search_s / threads + of_run * run.wall_s, bytes };
    let what = if is_confirmed { "a search with one confirming run" } else { "a search" };
    if let Some(line) = cost_line(what, all, false, rayon::current_num_threads()) {
        monitor.note(&line);
    }
    Ok(())
}

/// Geometric mean of the costs of two runs.
fn geometric_mean(one: Expense, other: Expense) -> Expense {
    let mean = |a: f64, b: f64| (a * b).sqrt();
    Expense {
        core_s: mean(one.core_s, other.core_s),
        wall_s: mean(one.wall_s, other.wall_s),
        bytes: mean(one.bytes, other.bytes),
    }
}

/// Time step of the reference integration if a scene names none, in seconds; the default step of dynamic runs is
/// stable.
const REFERENCE_STEP_S: f64 = 1e-9;

/// Cost of solving `scene` under `condition` with the errors of its material, as a line from [`cost_line`]; `None` if
/// the cost is small, or if the scene or its time step is refused.
pub fn run_line(scene: &Scene, uncertainty: &MaterialUncertainty, condition: Option<&Condition>) -> Option<String> {
    let may_go_on = scene.run.mu_stderr.is_some();
    let knowledge = uncertainty.at_loads(scene.area_law.as_ref(), &scene.loads, condition).unwrap_or_default();
    let all = expense(scene).then(Slopes::expense(scene, &knowledge));
    let line = cost_line("this run", all, may_go_on, rayon::current_num_threads())?;
    (bounded(scene).is_ok() && is_stable(scene)).then_some(line)
}

/// Whether the time step of `scene` is stable; true for steady scenes and for dynamic runs with the default step.
fn is_stable(scene: &Scene) -> bool {
    let is_reference = scene.run.fidelity == Fidelity::Reference;
    let asked = scene.run.step_s.filter(|_| scene.run.fidelity != Fidelity::Steady);
    let Some(step_s) = asked.or(is_reference.then_some(REFERENCE_STEP_S)) else { return true };
    // A run with the largest possible step is refused at once, by an error that gives the stability limit.
    let mut probe = scene.clone();
    probe.run.step_s = Some(f64::MAX);
    match simulate(&probe, &Unwatched) {
        Err(SceneError::UnstableStep { limit_s, .. }) => step_s <= limit_s,
        Err(_) => false,
        Ok(_) => true,
    }
}

/// Formats the line that `what` takes `expense` on `threads` threads; `None` up to 30 s and 1 GiB. If `may_go_on`, the
/// run continues until a standard error is small enough.
pub fn cost_line(what: &str, expense: Expense, may_go_on: bool, threads: usize) -> Option<String> {
    if expense.wall_s <= SHORT_S && expense.bytes <= SMALL_BYTES {
        return None;
    }
    let time = duration(expense.wall_s);
    let longer = if may_go_on { " or, until the standard error is small enough, longer" } else { "" };
    let memory = if expense.bytes > SMALL_BYTES {
        format!(" and {:.1} GiB of memory", expense.bytes / SMALL_BYTES)
    } else {
        String::new()
    };
    let threads = counted(threads, "thread");
    Some(format!("{what} takes about {time}{longer}{memory}, estimated for {threads} with cores of their own"))
}

/// Formats seconds in a suitable unit.
fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 100.0 => format!("{:.0} s", s.ceil()),
        s if s < 5400.0 => format!("{:.0} min", s / 60.0),
        s if s < 172_800.0 => format!("{:.0} h", s / 3600.0),
        s => format!("{:.0} days", s / 86_400.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_long_or_large_is_said() {
        let expense = |wall_s: f64, gib: f64| Expense { core_s: wall_s, wall_s, bytes: gib * SMALL_BYTES };
        assert_eq!(cost_line("this run", expense(29.0, 0.9), true, 2), None);
        let told = cost_line("this run", expense(31.0, 0.1), false, 2).unwrap();
        assert_eq!(told, "this run takes about 31 s, estimated for 2 threads with cores of their own");
        let told = cost_line("this run", expense(7300.0, 2.0), true, 2).unwrap();
        assert!(told.contains("2 h or, until") && told.contains("2.0 GiB of memory"), "{told}");
        assert!(cost_line("a", expense(1.0, 1.5), false, 1).unwrap().contains("about 1 s and 1.5 GiB"));
        assert_eq!((duration(600.0), duration(1e6)), ("10 min".to_owned(), "12 days".to_owned()));
    }
}
