//! Outputs of the program against those that are kept in `kept/`: scenes, designs, calibrations, maps, traces and refusals.
//!
//! `cargo test --release -p slipgrid-tests --test golden` compares a part of them in seconds; `-- --include-ignored` compares all.
//! With `SLIPGRID_UPDATE_GOLDEN=1` the files are written anew instead, and their difference in git is what changed.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "a test that cannot go on fails, and tells what it measured"
)]

mod calibrations;
mod designs;
mod maps;
mod place;
mod random;
mod record;
mod refusals;
mod scenes;
mod store;
mod traces;

use std::sync::Mutex;
use std::time::Instant;

use record::Record;
use store::Store;

/// A computation whose outputs are kept under `name`.
pub struct Case {
    name: String,
    /// Compared on every run of the tests, not only where all are.
    quick: bool,
    compute: Box<dyn Fn() -> Record + Send + Sync>,
}

impl Case {
    fn new(name: impl Into<String>, quick: bool, compute: impl Fn() -> Record + Send + Sync + 'static) -> Self {
        Self { name: name.into(), quick, compute: Box::new(compute) }
    }
}

/// Outputs of the cases by their names, on as many threads as there are cores. They are plain threads: a case has a pool of its own, and
/// one that waits for it would begin another case meanwhile.
fn compute(cases: &[&Case]) -> Vec<(String, Record)> {
    let (waiting, found) = (Mutex::new(cases.iter()), Mutex::new(Vec::new()));
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                loop {
                    let Some(case) = waiting.lock().unwrap().next() else { break };
                    let started = Instant::now();
                    let record = (case.compute)();
                    println!("{:7.2} s  {}", started.elapsed().as_secs_f64(), case.name);
                    found.lock().unwrap().push((case.name.clone(), record));
                }
            });
        }
    });
    found.into_inner().unwrap()
}

/// Computes the cases of the file `kept/<name>.txt` and compares them with it; fails with the differences.
fn compare(name: &str, cases: Vec<Case>, all: bool) {
    let chosen: Vec<&Case> = cases.iter().filter(|case| all || case.quick).collect();
    let found = compute(&chosen);
    let store = Store::read(name);
    if std::env::var_os(store::UPDATE).is_some() {
        store.update(found, all);
        return;
    }
    let differences = store.differences(&found, all);
    let shown: Vec<&str> = differences.iter().take(60).map(String::as_str).collect();
    assert!(
        differences.is_empty(),
        "{} differences from kept/{name}.txt; where they are meant, set {}=1 and run again:\n{}",
        differences.len(),
        store::UPDATE,
        shown.join("\n")
    );
}

/// A test of the quick cases of a group, and an ignored one of all of them.
macro_rules! group {
    ($($module:ident),*) => {$(
        mod $module {
            #[test]
            fn quick() {
                super::super::compare(stringify!($module), crate::$module::cases(), false);
            }

            #[test]
            #[ignore = "minutes; run before and after a change of what is computed"]
            fn all() {
                super::super::compare(stringify!($module), crate::$module::cases(), true);
            }
        }
    )*};
}

mod against_kept {
    group!(calibrations, designs, maps, refusals, scenes, traces);
}
