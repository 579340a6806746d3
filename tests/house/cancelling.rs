//! Checks that one monitor reaches every stage of the job.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use slipgrid_base::monitor::Monitor;
use slipgrid_design::{DesignError, DesignTask, NoCache, run};
use slipgrid_io::formats::Document;
use slipgrid_io::formats::design::Design;

/// Monitor that cancels once the stage `stage` has begun.
struct Button {
    stage: String,
    pressed: AtomicBool,
    seen: Mutex<Vec<String>>,
    clock: Instant,
}

impl Button {
    fn new(stage: &str) -> Self {
        Self { stage: stage.to_owned(), pressed: AtomicBool::new(false), seen: Mutex::default(), clock: Instant::now() }
    }
}

impl Monitor for Button {
    fn stage(&self, name: &str) {
        self.seen.lock().unwrap().push(name.to_owned());
        self.pressed.fetch_or(name == self.stage, Ordering::Relaxed);
    }

    fn cancelled(&self) -> bool {
        self.pressed.load(Ordering::Relaxed)
    }

    fn seconds(&self) -> f64 {
        self.clock.elapsed().as_secs_f64()
    }
}

fn task(more: &str) -> DesignTask {
    let text = format!(
        "[material]\nyoungs_modulus_gpa = 0.38\nyoungs_modulus_std_gpa = 0.07\ndensity_g_cm3 = 0.9\n\
         friction = {{ static_mean = 0.30, dynamic_mean = 0.27, relative_std = 0.05 }}\n\
         area_law = {{ pressure_mpa = [0.7, 2.6, 26.0], factor = [1.0, 0.8, 0.3] }}\n\
         [target]\nquantity = \"mu_dynamic\"\npressure_mpa = 2.6\nvalue = 0.20\ntolerance = 0.01\n\
         [bounds]\nwidth_um = [100, 300]\nspacing_um = [200, 600]\ndepth_um = [5, 30]\n\
         [specimen]\nshape = \"disc\"\ndiameter_mm = 4\n[sample]\nlayer_um = 100\nblock_um = 10\n\
         [tolerances]\nwidth_std_um = 5\n{more}"
    );
    Design::from_document(Document::new("design.toml", text)).unwrap().task
}

#[test]
fn every_stage_ends_when_the_monitor_cancels() {
    let task = task("[trade_offs]\ngoals = [\"misfit\", \"volume\"]\ndesigns = 100\n[search]\ntable = true\n");
    let whole = Button::new("");
    run(&task, &mut NoCache, &whole).unwrap();
    let mut stages = whole.seen.into_inner().unwrap();
    stages.sort();
    stages.dedup();
    for needed in ["table", "search", "confirmation"] {
        assert!(stages.iter().any(|stage| stage == needed), "{needed}: {stages:?}");
    }
    for stage in &stages {
        let found = run(&task, &mut NoCache, &Button::new(stage));
        assert_eq!(found.err(), Some(DesignError::Cancelled), "{stage}");
    }
}
