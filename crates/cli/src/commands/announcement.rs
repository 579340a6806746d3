//! One line on stderr before a run of more than half a minute, or of more than a gigabyte.

use slipgrid_design::cost_line;
use slipgrid_springblock::{Expense, Fidelity, Scene, SceneError, Unwatched, bounded, expense, simulate};

use crate::Console;

/// Step of the reference integration where a scene names none, in seconds; that of dynamic runs is always stable.
const REFERENCE_STEP_S: f64 = 1e-9;

/// Says what solving `scene` takes, where that is much and it is not refused.
pub fn announce(scene: &Scene, console: &mut Console<'_>) {
    let expense = expense(scene);
    let is_much = cost_line("", expense, false, console.threads).is_some();
    if is_much && bounded(scene).is_ok() && is_stable(scene) {
        say("this run", expense, scene.run.mu_stderr.is_some(), console);
    }
}

/// Whether a run in time takes the step of `scene`.
fn is_stable(scene: &Scene) -> bool {
    let is_reference = scene.run.fidelity == Fidelity::Reference;
    let asked = scene.run.step_s.filter(|_| scene.run.fidelity != Fidelity::Steady);
    let Some(step_s) = asked.or(is_reference.then_some(REFERENCE_STEP_S)) else { return true };
    // The largest step is refused with the limit named, before anything is run.
    let mut probe = scene.clone();
    probe.run.step_s = Some(f64::MAX);
    match simulate(&probe, &Unwatched) {
        Err(SceneError::UnstableStep { limit_s, .. }) => step_s <= limit_s,
        Err(_) => false,
        Ok(_) => true,
    }
}

/// Says that `what` takes `expense`, where that is much; `may_go_on`: until a standard error is small enough.
pub fn say(what: &str, expense: Expense, may_go_on: bool, console: &mut Console<'_>) {
    if let Some(line) = cost_line(what, expense, may_go_on, console.threads) {
        console.note(&line);
    }
}
