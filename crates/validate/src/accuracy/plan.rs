//! Plan of a comparison: a list of named changes to one scene.

use serde::Serialize;
use slipgrid_base::units::tidy;
use slipgrid_model::springblock::{Extent, Fidelity, Scene, Springs};

/// Change to the base scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    /// Fidelity of the solution.
    Fidelity(Fidelity),
    /// Modelled extent of the specimen.
    Extent(Extent),
    /// Spring law.
    Springs(Springs),
    /// Time step, in nanoseconds.
    StepNs(f64),
    /// Time step relative to the stability limit.
    StepOverLimit(f64),
    /// Block size relative to the scene's block size.
    BlockTimes(f64),
    /// Start from the sheared steady equilibrium.
    WarmStart,
    /// Stop at the relative standard error `mu_stderr` of dynamic mu, after at least the share `travel_share` of the
    /// travel.
    StopAt { mu_stderr: f64, travel_share: f64 },
}

impl Change {
    /// Applies the change to `scene`; `limit_s` returns the maximum stable time step of a scene, in seconds.
    pub fn apply(self, scene: &mut Scene, limit_s: impl Fn(&Scene) -> Option<f64>) {
        match self {
            Self::Fidelity(fidelity) => scene.run.fidelity = fidelity,
            Self::Extent(extent) => scene.run.extent = extent,
            Self::Springs(springs) => scene.run.springs = Some(springs),
            Self::StepNs(step_ns) => scene.run.step_s = Some(step_ns / 1e9),
            Self::StepOverLimit(share) => scene.run.step_s = limit_s(scene).map(|limit_s| share * limit_s),
            Self::BlockTimes(factor) => scene.layer.block_m *= factor,
            Self::WarmStart => scene.run.warm_start = true,
            Self::StopAt { mu_stderr, travel_share } => {
                scene.run.mu_stderr = Some(mu_stderr);
                scene.run.sliding_m *= travel_share;
            }
        }
    }
}

/// Family of related methods.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// Methods that solve for the steady equilibrium.
    Steady,
    /// Runge-Kutta integrator of the reference, with other steps and springs.
    RungeKutta,
    /// Leapfrog integrator, with various steps and springs.
    Leapfrog,
    /// Methods with other sizes of the blocks.
    BlockSize,
    /// Reduced extent and other ways to simulate less.
    Shortcut,
}

impl Family {
    /// Names of the families, in the order of the variants.
    pub const NAMES: [&str; 5] = ["steady", "Runge-Kutta", "leapfrog", "block size", "extent and shortcuts"];
}

/// Method of the comparison.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Method {
    /// Full description of the changes to the scene.
    pub name: String,
    /// Short label of the changes, for the picture.
    pub label: String,
    /// Family of the method.
    #[serde(skip)]
    pub family: Family,
    /// Changes to the base scene, in order; none for the reference.
    #[serde(skip)]
    pub changes: Vec<Change>,
    /// Commands that use this method by default; `None` if no command does.
    pub default_of: Option<&'static str>,
}

impl Method {
    fn default_of(self, commands: &'static str) -> Self {
        Self { default_of: Some(commands), ..self }
    }
}

/// Size of the comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Size {
    /// Comparison that takes a minute, on a reduced scene.
    Quick,
    /// Comparison that takes hours, on the whole scene.
    Full,
}

slipgrid_base::names!(Size { Quick = "quick", Full = "full" });

/// Time step near the stability limit, relative to the limit.
const NEAR_LIMIT: f64 = 0.97;
/// Relative standard error of mu at which shortened runs stop, as in the runs by which `optimize` confirms designs.
const STOP_STDERR: f64 = 0.001;
/// Minimum share of the travel after which shortened runs stop.
const STOP_TRAVEL_SHARE: f64 = 0.2;

const STEADY: Change = Change::Fidelity(Fidelity::Steady);
const DYNAMIC: Change = Change::Fidelity(Fidelity::Dynamic);
const CELL: Change = Change::Extent(Extent::Cell);
const WARM: Change = Change::WarmStart;
const STOP: Change = Change::StopAt { mu_stderr: STOP_STDERR, travel_share: STOP_TRAVEL_SHARE };

/// Springs and time steps of the Runge-Kutta methods, and whether the quick comparison includes the method.
const RUNGE_KUTTA: [(Springs, Change, bool); 6] = [
    (Springs::Exact, Change::StepNs(2.0), false),
    (Springs::Exact, Change::StepNs(4.0), false),
    (Springs::Exact, Change::StepNs(8.0), true),
    (Springs::Exact, Change::StepOverLimit(NEAR_LIMIT), true),
    (Springs::Linear, Change::StepNs(4.0), false),
    (Springs::Linear, Change::StepNs(8.0), true),
];
/// Springs and time steps of the leapfrog methods; `None` for the step that the program chooses.
const LEAPFROG: [(Springs, Option<Change>); 8] = [
    (Springs::Linear, Some(Change::StepNs(1.0))),
    (Springs::Linear, Some(Change::StepNs(2.0))),
    (Springs::Linear, None),
    (Springs::Linear, Some(Change::StepNs(4.0))),
    (Springs::Linear, Some(Change::StepNs(8.0))),
    (Springs::Linear, Some(Change::StepOverLimit(NEAR_LIMIT))),
    (Springs::Exact, Some(Change::StepNs(4.0))),
    (Springs::Exact, Some(Change::StepNs(8.0))),
];
/// Block sizes relative to the block size of the scene; only the full comparison solves whole samples with the last
/// size.
const BLOCKS: [f64; 3] = [2.0, 0.5, 0.25];

/// Methods of a comparison of the given `size`, the reference first; `scene` is the base scene.
pub fn methods(size: Size, scene: &Scene) -> Vec<Method> {
    let is_full = size == Size::Full;
    let mut methods = vec![
        method(Family::RungeKutta, "reference", "reference", &[]),
        method(Family::Steady, "steady, cell", "steady cell", &[STEADY, CELL])
            .default_of("simulate, and the search of optimize"),
        method(Family::Steady, "steady, sample", "steady sample", &[STEADY]),
    ];
    let runge_kutta = RUNGE_KUTTA.into_iter().filter(|(.., is_quick)| is_full || *is_quick);
    methods.extend(runge_kutta.map(|(springs, step, _)| {
        let words = step_words(springs, step);
        let changes = [Change::Springs(springs), step];
        method(Family::RungeKutta, format!("Runge-Kutta, {}", words[0]), format!("RK4 {}", words[1]), &changes)
    }));
    methods.extend(LEAPFROG.into_iter().map(|(springs, step)| {
        let Some(step) = step else {
            return method(Family::Leapfrog, "dynamic as it comes, sample", "dynamic sample", &[DYNAMIC])
                .default_of("simulate --fidelity dynamic, and optimize with from_rest = true");
        };
        let words = step_words(springs, step);
        let changes = [DYNAMIC, Change::Springs(springs), step];
        method(Family::Leapfrog, format!("leapfrog, {}", words[0]), format!("LF {}", words[1]), &changes)
    }));
    let blocks = |name: &str, label: &str, changes: &[Change], times: f64| {
        let um = tidy(scene.layer.block_m * 1e6 * times);
        let changes = [changes, &[Change::BlockTimes(times)]].concat();
        method(Family::BlockSize, format!("{name}, blocks of {um} um"), format!("{label} {um} um"), &changes)
    };
    methods.extend(BLOCKS.map(|times| blocks("steady, cell", "steady", &[STEADY, CELL], times)));
    let of_samples = &BLOCKS[..if is_full { 3 } else { 2 }];
    methods.extend(of_samples.iter().map(|&times| blocks("dynamic, sample", "dynamic", &[DYNAMIC], times)));
    let stop = format!("warm start, stop at a standard error of {} %", tidy(100.0 * STOP_STDERR));
    let shortcut = |name: String, label, changes: &[Change]| method(Family::Shortcut, name, label, changes);
    methods.extend([
        shortcut("dynamic, cell".to_owned(), "dynamic cell", &[DYNAMIC, CELL])
            .default_of("simulate --fidelity dynamic with extent = cell"),
        shortcut("dynamic, sample, warm start".to_owned(), "warm", &[DYNAMIC, WARM]),
        shortcut(format!("dynamic, sample, {stop}"), "warm stop", &[DYNAMIC, WARM, STOP])
            .default_of("the confirming runs of optimize"),
        shortcut(format!("dynamic, cell, {stop}"), "cell warm stop", &[DYNAMIC, CELL, WARM, STOP]),
    ]);
    methods
}

fn method(family: Family, name: impl Into<String>, label: impl Into<String>, changes: &[Change]) -> Method {
    Method { name: name.into(), label: label.into(), family, changes: changes.to_vec(), default_of: None }
}

/// Describes springs and time step, first in words and then in brief.
fn step_words(springs: Springs, step: Change) -> [String; 2] {
    let step = match step {
        Change::StepNs(step_ns) => format!("{step_ns} ns"),
        _ => "near limit".to_owned(),
    };
    let law = springs.name();
    [format!("{law} springs, {step}"), format!("{law} {step}")]
}
