//! Compares outputs of the program with the kept ones in `kept/`: scenes, designs, calibrations, maps, traces and
//! refusals.
//!
//! `cargo test --release -p slipgrid-tests --test golden` compares a part of them in seconds; `-- --include-ignored`
//! compares all. With `SLIPGRID_UPDATE_GOLDEN=1` the files are rewritten instead, and git shows the changes.

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

/// Computation whose outputs are kept as `name`.
pub struct Case {
    name: String,
    /// Whether the case is compared in every run of the tests.
    quick: bool,
    compute: Box<dyn Fn() -> Record + Send + Sync>,
}

impl Case {
    fn new(name: impl Into<String>, quick: bool, compute: impl Fn() -> Record + Send + Sync + 'static) -> Self {
        Self { name: name.into(), quick, compute: Box::new(compute) }
    }
}

/// Computes the outputs of the cases by name, on as many threads as there are cores. These are plain threads, because
/// each case has a thread pool of its own, and a pool thread that waits for it would begin another case.
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

/// Defines a test of the quick cases and an ignored test of all cases, for each group.
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
