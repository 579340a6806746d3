//! Plan of a comparison: a list of named changes to one scene.

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
    /// Stop at this relative standard error of dynamic mu, checked from this share of the travel on.
    StopAt { mu_stderr: f64, travel_share: f64 },
}

impl Change {
    /// Applies the change to `scene`; `limit_s` gives a scene's maximum stable step.
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

/// Group of methods.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// Steady equilibrium.
    Steady,
    /// Integrator of the reference with other steps and springs.
    RungeKutta,
    /// Fast integrator with various steps and springs.
    Leapfrog,
    /// Size of the blocks.
    BlockSize,
    /// Reduced extent and other ways to simulate less.
    Shortcut,
}

impl Family {
    /// Names by family, in their order.
    pub const NAMES: [&str; 5] = ["steady", "Runge-Kutta", "leapfrog", "block size", "extent and shortcuts"];
}

/// Method of the comparison.
#[derive(Clone, Debug, PartialEq)]
pub struct Method {
    /// Full description of the change.
    pub name: String,
    /// Short label of the change, for the picture.
    pub label: String,
    /// Family of the method.
    pub family: Family,
    /// Changes to the base scene, in order; none for the reference.
    pub changes: Vec<Change>,
    /// Commands for which this method is the program's default.
    pub default_of: Option<&'static str>,
}

/// Size of the comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Size {
    /// Takes a minute.
    Quick,
    /// Takes hours.
    Full,
}

impl Size {
    /// Name in results.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Quick => "quick",
            Self::Full => "full",
        }
    }
}

/// Step near the stability limit, relative to the limit.
const NEAR_LIMIT: f64 = 0.97;
/// Relative standard error of mu at which shortened runs stop, as for the confirming runs of `optimize`.
const STOP_STDERR: f64 = 0.001;
/// Share of the travel from which shortened runs may stop.
const STOP_TRAVEL_SHARE: f64 = 0.2;

/// All methods, the reference first; `scene` is the base scene.
pub fn methods(size: Size, scene: &Scene) -> Vec<Method> {
    let mut methods = vec![method("reference", "reference", Family::RungeKutta, vec![])];
    methods.extend(steady());
    methods.extend(runge_kutta(size));
    methods.extend(leapfrog());
    methods.extend(block_sizes(size, scene.layer.block_m * 1e6));
    methods.extend(shortcuts());
    methods
}

fn method(name: impl Into<String>, label: impl Into<String>, family: Family, changes: Vec<Change>) -> Method {
    Method { name: name.into(), label: label.into(), family, changes, default_of: None }
}

const STEADY: Change = Change::Fidelity(Fidelity::Steady);
const DYNAMIC: Change = Change::Fidelity(Fidelity::Dynamic);
const CELL: Change = Change::Extent(Extent::Cell);
const LINEAR: Change = Change::Springs(Springs::Linear);
const EXACT: Change = Change::Springs(Springs::Exact);

fn steady() -> Vec<Method> {
    vec![
        Method {
            default_of: Some("simulate, and the search of optimize"),
            ..method("steady, cell", "steady cell", Family::Steady, vec![STEADY, CELL])
        },
        method("steady, sample", "steady sample", Family::Steady, vec![STEADY]),
    ]
}

fn runge_kutta(size: Size) -> Vec<Method> {
    let step = |name: &str, springs: Change, step: Change| {
        let law = if springs == EXACT { "exact" } else { "linear" };
        method(
            format!("Runge-Kutta, {law} springs, {name}"),
            format!("RK4 {law} {name}"),
            Family::RungeKutta,
            vec![springs, step],
        )
    };
    let mut rows = Vec::new();
    if size == Size::Full {
        rows.push(step("2 ns", EXACT, Change::StepNs(2.0)));
        rows.push(step("4 ns", EXACT, Change::StepNs(4.0)));
    }
    rows.push(step("8 ns", EXACT, Change::StepNs(8.0)));
    rows.push(step("near limit", EXACT, Change::StepOverLimit(NEAR_LIMIT)));
    if size == Size::Full {
        rows.push(step("4 ns", LINEAR, Change::StepNs(4.0)));
    }
    rows.push(step("8 ns", LINEAR, Change::StepNs(8.0)));
    rows
}

fn leapfrog() -> Vec<Method> {
    let step = |name: &str, law: &str, changes: &[Change]| {
        let changes = [DYNAMIC].into_iter().chain(changes.iter().copied()).collect();
        method(format!("leapfrog, {law} springs, {name}"), format!("LF {law} {name}"), Family::Leapfrog, changes)
    };
    vec![
        step("1 ns", "linear", &[Change::StepNs(1.0)]),
        step("2 ns", "linear", &[Change::StepNs(2.0)]),
        Method {
            name: "dynamic as it comes, sample".to_owned(),
            label: "dynamic sample".to_owned(),
            default_of: Some("simulate --fidelity dynamic, and optimize with from_rest = true"),
            ..step("", "linear", &[])
        },
        step("4 ns", "linear", &[Change::StepNs(4.0)]),
        step("8 ns", "linear", &[Change::StepNs(8.0)]),
        step("near limit", "linear", &[Change::StepOverLimit(NEAR_LIMIT)]),
        step("4 ns", "exact", &[EXACT, Change::StepNs(4.0)]),
        step("8 ns", "exact", &[EXACT, Change::StepNs(8.0)]),
    ]
}

fn block_sizes(size: Size, block_um: f64) -> Vec<Method> {
    let named = |what: &str, short: &str, times: f64, changes: &[Change]| {
        let um = slipgrid_base::units::tidy(block_um * times);
        let changes = changes.iter().copied().chain([Change::BlockTimes(times)]).collect();
        method(format!("{what}, blocks of {um} um"), format!("{short} {um} um"), Family::BlockSize, changes)
    };
    let mut rows: Vec<Method> =
        [2.0, 0.5, 0.25].map(|times| named("steady, cell", "steady", times, &[STEADY, CELL])).into();
    let dynamic: &[f64] = if size == Size::Full { &[2.0, 0.5, 0.25] } else { &[2.0, 0.5] };
    rows.extend(dynamic.iter().map(|&times| named("dynamic, sample", "dynamic", times, &[DYNAMIC])));
    rows
}

fn shortcuts() -> Vec<Method> {
    let stop = Change::StopAt { mu_stderr: STOP_STDERR, travel_share: STOP_TRAVEL_SHARE };
    let percent = slipgrid_base::units::tidy(100.0 * STOP_STDERR);
    let shortcut = |name: String, label: &str, changes: &[Change]| {
        let changes = [DYNAMIC].into_iter().chain(changes.iter().copied()).collect();
        method(name, label, Family::Shortcut, changes)
    };
    vec![
        Method {
            default_of: Some("simulate --fidelity dynamic with extent = cell"),
            ..shortcut("dynamic, cell".to_owned(), "dynamic cell", &[CELL])
        },
        shortcut("dynamic, sample, warm start".to_owned(), "warm", &[Change::WarmStart]),
        Method {
            default_of: Some("the confirming runs of optimize"),
            ..shortcut(
                format!("dynamic, sample, warm start, stop at a standard error of {percent} %"),
                "warm stop",
                &[Change::WarmStart, stop],
            )
        },
        shortcut(
            format!("dynamic, cell, warm start, stop at a standard error of {percent} %"),
            "cell warm stop",
            &[CELL, Change::WarmStart, stop],
        ),
    ]
}
