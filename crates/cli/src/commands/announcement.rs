//! One line on stderr before a run of more than a minute, or of more than a gigabyte.

use slipgrid_springblock::{Expense, Fidelity, Scene, SceneError, Unwatched, bounded, expense, simulate};

use crate::Console;

/// Seconds, and bytes, up to which nothing is said.
const SHORT_S: f64 = 60.0;
const SMALL_BYTES: f64 = (1_u64 << 30) as f64;

/// Step of the reference integration where a scene names none, in seconds; that of dynamic runs is always stable.
const REFERENCE_STEP_S: f64 = 1e-9;

/// Says what solving `scene` takes, where that is much and it is not refused.
pub fn announce(scene: &Scene, console: &mut Console<'_>) {
    let expense = expense(scene);
    let is_much = line("", expense, false, console.threads).is_some();
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
    if let Some(line) = line(what, expense, may_go_on, console.threads) {
        console.note(&line);
    }
}

fn line(what: &str, expense: Expense, may_go_on: bool, threads: usize) -> Option<String> {
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
    Some(format!("{what} takes about {time}{longer}{memory}, estimated for {threads} threads with cores of their own"))
}

/// Seconds in the unit that fits them.
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
        assert_eq!(line("this run", expense(59.0, 0.9), true, 2), None);
        let told = line("this run", expense(61.0, 0.1), false, 2).unwrap();
        assert_eq!(told, "this run takes about 61 s, estimated for 2 threads with cores of their own");
        let told = line("this run", expense(7300.0, 2.0), true, 2).unwrap();
        assert!(told.contains("2 h or, until") && told.contains("2.0 GiB of memory"), "{told}");
        assert!(line("a", expense(1.0, 1.5), false, 1).unwrap().contains("about 1 s and 1.5 GiB"));
        assert_eq!((duration(600.0), duration(1e6)), ("10 min".to_owned(), "12 days".to_owned()));
    }
}
