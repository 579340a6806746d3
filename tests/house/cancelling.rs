//! Checks that one monitor reaches every stage of the job.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use slipgrid_base::monitor::Monitor;
use slipgrid_design::{DesignError, DesignTask, NoCache, run};
use slipgrid_io::formats::Document;
use slipgrid_io::formats::design::Design;

/// Monitor that cancels a given time after the stage `stage` has begun.
struct Button {
    stage: String,
    after: Duration,
    begun: Mutex<Option<Instant>>,
    pressed: AtomicBool,
    seen: Mutex<Vec<String>>,
    clock: Instant,
}

impl Button {
    fn new(stage: &str, after: Duration) -> Self {
        Self {
            stage: stage.to_owned(),
            after,
            begun: Mutex::new(None),
            pressed: AtomicBool::new(false),
            seen: Mutex::default(),
            clock: Instant::now(),
        }
    }
}

impl Monitor for Button {
    fn stage(&self, name: &str) {
        self.seen.lock().unwrap().push(name.to_owned());
        if name == self.stage {
            self.begun.lock().unwrap().get_or_insert_with(Instant::now);
        }
    }

    fn cancelled(&self) -> bool {
        if !self.pressed.load(Ordering::Relaxed) {
            let is_due = self.begun.lock().unwrap().is_some_and(|begun| begun.elapsed() >= self.after);
            self.pressed.fetch_or(is_due, Ordering::Relaxed);
        }
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
    let whole = Button::new("", Duration::ZERO);
    run(&task, &mut NoCache, &whole).unwrap();
    let mut stages = whole.seen.into_inner().unwrap();
    stages.sort();
    stages.dedup();
    for needed in ["table", "search", "confirmation"] {
        assert!(stages.iter().any(|stage| stage == needed), "{needed}: {stages:?}");
    }
    for stage in &stages {
        let found = run(&task, &mut NoCache, &Button::new(stage, Duration::ZERO));
        assert_eq!(found.err(), Some(DesignError::Cancelled), "{stage}");
    }
}

/// Prints the time between cancelling and the end of a job, for every stage of two jobs.
#[test]
#[ignore = "measures times: prints a table"]
fn seconds_from_cancelling_to_the_end() {
    for (name, more) in [("plane", ""), ("space", "[pattern]\nplanform = \"square\"\n")] {
        let task = task(more);
        let whole = Button::new("", Duration::ZERO);
        let started = Instant::now();
        run(&task, &mut NoCache, &whole).unwrap();
        println!("{name}: {:.1} s in all", started.elapsed().as_secs_f64());
        let mut stages = whole.seen.into_inner().unwrap();
        stages.sort();
        stages.dedup();
        for stage in stages {
            let worst = [10, 50, 150, 400].map(|after_ms| {
                let button = Button::new(&stage, Duration::from_millis(after_ms));
                let found = run(&task, &mut NoCache, &button);
                let ended = button.begun.lock().unwrap().map(|begun| begun.elapsed().saturating_sub(button.after));
                (found.err() == Some(DesignError::Cancelled)).then(|| ended.unwrap_or_default().as_secs_f64())
            });
            let worst = worst.into_iter().flatten().fold(0.0, f64::max);
            println!("  {stage}: {worst:.3} s");
        }
    }
}
