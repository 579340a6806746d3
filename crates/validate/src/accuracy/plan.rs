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
    /// Layer height relative to the scene's. A higher layer needs more travel until it slides.
    LayerTimes(f64),
    /// Damping frequency relative to sqrt(k/m).
    Damping(f64),
    /// Speed relative to the scene's speed.
    SpeedTimes(f64),
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
            Self::LayerTimes(factor) => {
                scene.layer.height_m *= factor;
                scene.run.sliding_m *= factor.max(1.0);
            }
            Self::Damping(damping) => scene.run.damping = damping,
            Self::SpeedTimes(factor) => scene.speed_m_s *= factor,
        }
    }
}

/// Group of rows on the page.
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
    /// Damping frequency.
    Damping,
    /// Sliding speed.
    Speed,
    /// Height of the elastic layer.
    LayerHeight,
}

impl Family {
    /// Families of methods, in the order of the page.
    pub const METHODS: [Self; 5] = [Self::Steady, Self::RungeKutta, Self::Leapfrog, Self::BlockSize, Self::Shortcut];

    /// Name on the page.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Steady => "steady",
            Self::RungeKutta => "Runge-Kutta",
            Self::Leapfrog => "leapfrog",
            Self::BlockSize => "block size",
            Self::Shortcut => "extent and shortcuts",
            Self::Damping => "damping",
            Self::Speed => "speed",
            Self::LayerHeight => "layer height",
        }
    }
}

/// Role of a row in the comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Reference that judges the methods.
    Judge,
    /// Another method for an identical problem: its difference from the judge is an error.
    Method,
    /// Dynamic run with which choices are compared.
    Base,
    /// Another physical scene: its difference from the base is a change of the answer.
    Choice,
    /// Base with many draws of the local coefficients.
    Seeds,
}

/// Row of the page.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Full description of the change.
    pub name: String,
    /// Short label of the change, for the diagram.
    pub label: String,
    /// Family of the row.
    pub family: Family,
    /// Role of the row.
    pub role: Role,
    /// Changes to the base scene, in order.
    pub changes: Vec<Change>,
    /// Number of draws of the local coefficients, from the scene's seed on.
    pub seeds: u64,
    /// Commands for which this method is the program's default.
    pub default_of: Option<&'static str>,
}

impl Row {
    /// Relative block size of a steady cell; `None` for every other row. A steady cell is deterministic:
    /// its discretization error is exact to the last digit.
    pub fn steady_cell_blocks(&self) -> Option<f64> {
        match self.changes[..] {
            [STEADY, CELL] => Some(1.0),
            [STEADY, CELL, Change::BlockTimes(times)] => Some(times),
            _ => None,
        }
    }
}

/// Size of the comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Size {
    /// Takes a minute.
    Quick,
    /// Takes hours.
    Full,
}

/// Number of draws for the scatter between draws.
pub const SCATTER_SEEDS: u64 = 10;
/// Step near the stability limit, relative to the limit.
const NEAR_LIMIT: f64 = 0.97;
/// Relative standard error of mu at which shortened runs stop, as for the confirming runs of `optimize`.
const STOP_STDERR: f64 = 0.001;
/// Share of the travel from which shortened runs may stop.
const STOP_TRAVEL_SHARE: f64 = 0.2;

/// All rows, judge first; `scene` is the base scene.
pub fn rows(size: Size, scene: &Scene, seeds: u64) -> Vec<Row> {
    let mut rows = vec![row("reference", "reference", Family::RungeKutta, Role::Judge, vec![])];
    rows.extend(steady());
    rows.extend(runge_kutta(size));
    rows.extend(leapfrog());
    rows.extend(block_sizes(size, scene.layer.block_m * 1e6));
    rows.extend(shortcuts());
    rows.extend(choices(scene));
    for row in &mut rows {
        row.seeds = if row.role == Role::Seeds { SCATTER_SEEDS.max(seeds) } else { seeds };
    }
    rows
}

fn row(name: impl Into<String>, label: impl Into<String>, family: Family, role: Role, changes: Vec<Change>) -> Row {
    Row { name: name.into(), label: label.into(), family, role, changes, seeds: 1, default_of: None }
}

fn method(name: impl Into<String>, label: impl Into<String>, family: Family, changes: Vec<Change>) -> Row {
    row(name, label, family, Role::Method, changes)
}

const STEADY: Change = Change::Fidelity(Fidelity::Steady);
const DYNAMIC: Change = Change::Fidelity(Fidelity::Dynamic);
const CELL: Change = Change::Extent(Extent::Cell);
const LINEAR: Change = Change::Springs(Springs::Linear);
const EXACT: Change = Change::Springs(Springs::Exact);

fn steady() -> Vec<Row> {
    vec![
        Row {
            default_of: Some("simulate, and the search of optimize"),
            ..method("steady, cell", "steady cell", Family::Steady, vec![STEADY, CELL])
        },
        method("steady, sample", "steady sample", Family::Steady, vec![STEADY]),
    ]
}

fn runge_kutta(size: Size) -> Vec<Row> {
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

fn leapfrog() -> Vec<Row> {
    let step = |name: &str, law: &str, changes: &[Change]| {
        let changes = [DYNAMIC].into_iter().chain(changes.iter().copied()).collect();
        method(format!("leapfrog, {law} springs, {name}"), format!("LF {law} {name}"), Family::Leapfrog, changes)
    };
    vec![
        step("1 ns", "linear", &[Change::StepNs(1.0)]),
        step("2 ns", "linear", &[Change::StepNs(2.0)]),
        Row {
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

fn block_sizes(size: Size, block_um: f64) -> Vec<Row> {
    let named = |what: &str, short: &str, times: f64, changes: &[Change]| {
        let um = slipgrid_base::units::tidy(block_um * times);
        let changes = changes.iter().copied().chain([Change::BlockTimes(times)]).collect();
        method(format!("{what}, blocks of {um} um"), format!("{short} {um} um"), Family::BlockSize, changes)
    };
    let mut rows: Vec<Row> =
        [2.0, 0.5, 0.25].map(|times| named("steady, cell", "steady", times, &[STEADY, CELL])).into();
    let dynamic: &[f64] = if size == Size::Full { &[2.0, 0.5, 0.25] } else { &[2.0, 0.5] };
    rows.extend(dynamic.iter().map(|&times| named("dynamic, sample", "dynamic", times, &[DYNAMIC])));
    rows
}

fn shortcuts() -> Vec<Row> {
    let stop = Change::StopAt { mu_stderr: STOP_STDERR, travel_share: STOP_TRAVEL_SHARE };
    let percent = slipgrid_base::units::tidy(100.0 * STOP_STDERR);
    let shortcut = |name: String, label: &str, changes: &[Change]| {
        let changes = [DYNAMIC].into_iter().chain(changes.iter().copied()).collect();
        method(name, label, Family::Shortcut, changes)
    };
    vec![
        Row {
            default_of: Some("simulate --fidelity dynamic with extent = cell"),
            ..shortcut("dynamic, cell".to_owned(), "dynamic cell", &[CELL])
        },
        shortcut("dynamic, sample, warm start".to_owned(), "warm", &[Change::WarmStart]),
        Row {
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

fn choices(scene: &Scene) -> Vec<Row> {
    let dynamic = |name: String, family, role, change: Option<Change>| {
        row(name.clone(), name, family, role, [DYNAMIC].into_iter().chain(change).collect())
    };
    let choice = |name, family, change| dynamic(name, family, Role::Choice, Some(change));
    let um = |times: f64| slipgrid_base::units::tidy(scene.layer.height_m * 1e6 * times);
    let mm_s = |times: f64| slipgrid_base::units::tidy(scene.speed_m_s * 1e3 * times);
    let mut rows = vec![dynamic("as in the scene".to_owned(), Family::Damping, Role::Base, None)];
    let damping = [0.003, 0.01, 0.03, 0.1].into_iter().filter(|damping| *damping != scene.run.damping);
    rows.extend(
        damping.map(|damping| {
            choice(format!("damping of {damping} sqrt(k/m)"), Family::Damping, Change::Damping(damping))
        }),
    );
    rows.extend(
        [0.2, 2.0].map(|times| choice(format!("{} mm/s", mm_s(times)), Family::Speed, Change::SpeedTimes(times))),
    );
    rows.extend(
        [0.5, 2.0]
            .map(|times| choice(format!("layer of {} um", um(times)), Family::LayerHeight, Change::LayerTimes(times))),
    );
    rows.push(dynamic("draws of the local coefficients".to_owned(), Family::Damping, Role::Seeds, None));
    rows
}
