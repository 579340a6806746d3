//! Record of a comparison.

use std::f64::consts::SQRT_2;

use serde::Serialize;
use slipgrid_model::springblock::Scene;

use super::difference::{Difference, Mean, Quantity, SIGNIFICANT, difference, mean};
use super::front::{Point, better, front};
use super::measure::{Run, runs_of};
use super::plan::{Family, Role, Row};
use slipgrid_base::units::{STEP_NS, tidy};
use slipgrid_design::results::{SCHEMA, VERSION};

/// Record that `accuracy --json` prints.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AccuracyReport {
    /// Program name: `slipgrid`.
    pub program: &'static str,
    /// Program version.
    pub version: &'static str,
    /// Schema version of the record.
    pub schema: u32,
    /// `quick` or `full`.
    pub size: &'static str,
    /// Description of the scene and of the comparison.
    pub model: Vec<String>,
    /// Reference that judges the methods.
    pub reference: RowReport,
    /// Other methods for an identical problem, with errors relative to the reference.
    pub methods: Vec<RowReport>,
    /// Steady cells of coarser blocks, compared with the finest ones.
    pub discretization: Vec<RowReport>,
    /// Dynamic run with which choices are compared.
    pub base: RowReport,
    /// Other physical scenes, with changes relative to the base.
    pub choices: Vec<RowReport>,
    /// Base with many draws.
    pub scatter: RowReport,
    /// Pareto fronts of time and error, one per quantity.
    pub fronts: Vec<FrontReport>,
    /// Machine of the runs.
    pub machine: Machine,
    /// Total wall time in seconds.
    pub wall_s: f64,
    /// Number of threads.
    pub threads: usize,
}

/// Row of the page.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RowReport {
    /// Full description of the change.
    pub name: String,
    /// Short label of the change.
    pub label: String,
    /// Family of the row.
    pub family: &'static str,
    /// Commands for which this method is the program's default.
    pub default_of: Option<&'static str>,
    /// Status of the runs: that of the first run that did not end as planned.
    pub status: String,
    /// Number of draws of the local coefficients.
    pub seeds: usize,
    /// Time step.
    pub step_ns: Option<f64>,
    /// Blocks times force evaluations of the timed run, both surfaces; null for steady runs.
    pub site_updates: Option<u64>,
    /// Dynamic friction coefficient.
    pub mu_dynamic: Option<ValueReport>,
    /// Static friction coefficient.
    pub mu_static: Option<ValueReport>,
    /// Ratio of dynamic friction, patterned over flat.
    pub ratio: Option<ValueReport>,
    /// Wall time of the timed run on one thread, in seconds.
    pub wall_s: f64,
    /// Site updates per second of integration.
    pub site_updates_per_s: Option<f64>,
}

/// Mean over seeds and its difference from the compared row.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ValueReport {
    /// The mean.
    pub value: f64,
    /// Standard deviation between draws.
    pub std: Option<f64>,
    /// Standard error from the batch means within the runs.
    pub stderr: Option<f64>,
    /// Difference, in per cent.
    pub difference_pct: Option<f64>,
    /// Standard error of the difference, in per cent.
    pub difference_stderr_pct: Option<f64>,
    /// The difference exceeds two standard errors.
    pub significant: Option<bool>,
    /// Upper bound of the difference: the difference or two standard errors, whichever is larger.
    pub difference_at_most_pct: Option<f64>,
}

/// Pareto front in one quantity.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FrontReport {
    /// Quantity of the error.
    pub quantity: &'static str,
    /// Smallest distinguishable error: two standard errors of the difference of two references,
    /// with a margin of a quarter.
    pub resolution_pct: f64,
    /// Methods without a faster method that is at least as accurate, fastest first.
    pub methods: Vec<String>,
    /// Defaults of the program.
    pub defaults: Vec<DefaultReport>,
}

/// Position of a default relative to the front.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DefaultReport {
    /// Name of the method.
    pub name: String,
    /// Commands for which it is the default.
    pub default_of: &'static str,
    /// The default is on the front.
    pub on_front: bool,
    /// Method of the front that is faster and no less accurate; null if the default is on the front.
    pub better: Option<String>,
    /// Position among methods that give static friction; null unless the default gives it and `better` does not.
    pub among_static: Option<AmongStatic>,
}

/// Position of a default among the methods that give static friction.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AmongStatic {
    /// The default is on the front of these methods.
    pub on_front: bool,
    /// Method that is faster and no less accurate; null if the default is on the front.
    pub better: Option<String>,
}

/// Machine on which a page was made.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Machine {
    /// Architecture of the processor.
    pub architecture: &'static str,
    /// Operating system.
    pub system: &'static str,
    /// Number of hardware threads.
    pub processors: Option<usize>,
    /// Date, if requested.
    pub date: Option<String>,
}

impl AccuracyReport {
    /// Makes the record of `runs`, one list per row.
    pub fn new(
        size: &'static str,
        model: Vec<String>,
        rows: &[Row],
        runs: &[Vec<Run>],
        machine: Machine,
        wall_s: f64,
        threads: usize,
    ) -> Self {
        let (judge, base) = (runs_of(rows, runs, Role::Judge), runs_of(rows, runs, Role::Base));
        let of_role = |role: Role, other: &[Run]| -> Vec<RowReport> {
            let own = rows.iter().zip(runs).filter(|(row, _)| row.role == role);
            own.map(|(row, runs)| RowReport::new(row, runs, other)).collect()
        };
        let one = |role: Role| of_role(role, &[]).into_iter().next().unwrap_or_default();
        let reference = one(Role::Judge);
        let methods = of_role(Role::Method, judge);
        let fronts = [Quantity::MuDynamic, Quantity::Ratio]
            .into_iter()
            .filter_map(|quantity| FrontReport::new(quantity, &methods, &reference))
            .collect();
        Self {
            program: "slipgrid",
            version: VERSION,
            schema: SCHEMA,
            size,
            model,
            methods,
            reference,
            discretization: discretization(rows, runs),
            base: one(Role::Base),
            choices: of_role(Role::Choice, base),
            scatter: one(Role::Seeds),
            fronts,
            machine,
            wall_s,
            threads,
        }
    }
}

/// Steady cells compared with the finest blocks, coarsest first.
fn discretization(rows: &[Row], runs: &[Vec<Run>]) -> Vec<RowReport> {
    let mut cells: Vec<(f64, &Row, &Vec<Run>)> =
        rows.iter().zip(runs).filter_map(|(row, runs)| Some((row.steady_cell_blocks()?, row, runs))).collect();
    cells.sort_by(|a, b| b.0.total_cmp(&a.0));
    let finest = cells.last().map_or(&[][..], |(_, _, runs)| runs.as_slice());
    cells.iter().map(|(_, row, runs)| RowReport::new(row, runs, finest)).collect()
}

impl Default for RowReport {
    fn default() -> Self {
        Self {
            name: String::new(),
            label: String::new(),
            family: Family::Steady.name(),
            default_of: None,
            status: "missing".to_owned(),
            seeds: 0,
            step_ns: None,
            site_updates: None,
            mu_dynamic: None,
            mu_static: None,
            ratio: None,
            wall_s: 0.0,
            site_updates_per_s: None,
        }
    }
}

impl RowReport {
    /// Makes the row of `runs`, compared with `other`.
    pub fn new(row: &Row, runs: &[Run], other: &[Run]) -> Self {
        let value = |quantity| {
            let mean = mean(quantity, runs)?;
            Some(ValueReport::new(mean, difference(quantity, runs, other)))
        };
        let timed = runs.first();
        let ended = runs.iter().find(|run| !run.converged).or(timed);
        Self {
            name: row.name.clone(),
            label: row.label.clone(),
            family: row.family.name(),
            default_of: row.default_of,
            status: ended.map_or_else(|| "missing".to_owned(), |run| run.status.clone()),
            seeds: runs.len(),
            step_ns: timed.and_then(|run| run.dt_s).map(|dt_s| STEP_NS.from_si(dt_s)).map(tidy),
            site_updates: timed.map(|run| run.site_updates).filter(|updates| *updates > 0),
            mu_dynamic: value(Quantity::MuDynamic),
            mu_static: value(Quantity::MuStatic),
            ratio: value(Quantity::Ratio),
            wall_s: timed.map_or(0.0, |run| run.wall_s),
            site_updates_per_s: timed.and_then(|run| run.site_updates_per_s),
        }
    }

    /// Value of `quantity`.
    pub const fn value(&self, quantity: Quantity) -> Option<ValueReport> {
        match quantity {
            Quantity::MuDynamic => self.mu_dynamic,
            Quantity::MuStatic => self.mu_static,
            Quantity::Ratio => self.ratio,
        }
    }

    /// Point on the diagram of `quantity`; `None` if the row has no error or took no time.
    pub fn point(&self, quantity: Quantity) -> Option<Point> {
        let error = self.value(quantity)?.difference_at_most_pct?;
        (self.wall_s > 0.0 && error.is_finite()).then_some(Point { cost: self.wall_s, error })
    }
}

impl ValueReport {
    fn new(mean: Mean, difference: Option<Difference>) -> Self {
        Self {
            value: mean.value,
            std: mean.std,
            stderr: mean.stderr,
            difference_pct: difference.map(|difference| difference.percent),
            difference_stderr_pct: difference.and_then(|difference| difference.stderr),
            significant: difference.and_then(|difference| difference.is_significant()),
            difference_at_most_pct: difference.map(|difference| difference.bound()),
        }
    }
}

/// Factor on standard errors: estimated from a few tens of batches, they are themselves uncertain by a fifth, so closer
/// bounds are not ranked.
const STDERR_UNCERTAINTY: f64 = 1.25;

/// Methods that solve the lattice of the reference. With other blocks, the difference from the reference is not
/// the error, because the blocks of the reference cause an error themselves.
fn contestants(methods: &[RowReport]) -> impl Iterator<Item = &RowReport> {
    methods.iter().filter(|method| method.family != Family::BlockSize.name())
}

impl FrontReport {
    /// Front of `methods` in `quantity`; `None` if no method has an error in it.
    pub fn new(quantity: Quantity, methods: &[RowReport], reference: &RowReport) -> Option<Self> {
        let judge = reference.value(quantity)?;
        // The difference of two independent means has sqrt 2 times the standard error of one.
        let resolution_pct = STDERR_UNCERTAINTY * SIGNIFICANT * SQRT_2 * 100.0 * judge.stderr? / judge.value.abs();
        let all: Vec<(&RowReport, Point)> =
            contestants(methods).filter_map(|method| Some((method, method.point(quantity)?))).collect();
        if all.is_empty() {
            return None;
        }
        let with_static: Vec<(&RowReport, Point)> =
            all.iter().filter(|(method, _)| method.mu_static.is_some()).copied().collect();
        let on_front = front(&points(&all), resolution_pct);
        let mut best: Vec<&(&RowReport, Point)> =
            all.iter().zip(&on_front).filter(|(_, on_front)| **on_front).map(|(placed, _)| placed).collect();
        best.sort_by(|a, b| a.1.cost.total_cmp(&b.1.cost));
        let defaults = all
            .iter()
            .filter_map(|(method, _)| {
                let better = better_than(method, &all, resolution_pct);
                let among_static = better.filter(|better| better.mu_static.is_none() && method.mu_static.is_some());
                Some(DefaultReport {
                    name: method.name.clone(),
                    default_of: method.default_of?,
                    on_front: better.is_none(),
                    better: better.map(|better| better.name.clone()),
                    among_static: among_static.map(|_| {
                        let better = better_than(method, &with_static, resolution_pct);
                        AmongStatic { on_front: better.is_none(), better: better.map(|better| better.name.clone()) }
                    }),
                })
            })
            .collect();
        Some(Self {
            quantity: quantity.name(),
            resolution_pct,
            methods: best.into_iter().map(|(method, _)| method.name.clone()).collect(),
            defaults,
        })
    }
}

fn points(placed: &[(&RowReport, Point)]) -> Vec<Point> {
    placed.iter().map(|(_, point)| *point).collect()
}

/// Method of `placed` that dominates `method`.
fn better_than<'a>(method: &RowReport, placed: &[(&'a RowReport, Point)], floor: f64) -> Option<&'a RowReport> {
    let index = placed.iter().position(|(other, _)| other.name == method.name)?;
    better(&points(placed), index, floor).map(|other| placed[other].0)
}

/// Describes the comparison and its methods.
pub fn model_notes(scene: &Scene, source: &str, size: &str, seeds: u64) -> Vec<String> {
    use slipgrid_base::units::{LENGTH_UM, PRESSURE_MPA, SPEED_MM_S};
    let um = |length_m: f64| LENGTH_UM.from_si(length_m);
    let rounded_um = |length_m: f64| (um(length_m) * 1e3).round() / 1e3;
    let mut notes = vec![source.to_owned()];
    if size == "quick" {
        notes.push(
            "quick: a shorter specimen, a thinner layer and less travel than the scene's, so that the reference takes \
             seconds; its numbers hold for this specimen, and --full takes the scene as it is"
                .to_owned(),
        );
    }
    if let Some(load) = scene.loads.first() {
        notes.push(format!(
            "{} x {} blocks of {} um, {} MPa, {} mm/s, {} um of travel, damping {} sqrt(k/m)",
            scene.layer.columns(),
            scene.layer.rows(),
            um(scene.layer.block_m),
            PRESSURE_MPA.from_si(load.pressure_pa),
            SPEED_MM_S.from_si(scene.speed_m_s),
            rounded_um(scene.run.sliding_m),
            scene.run.damping,
        ));
    }
    notes.push(match &scene.pattern {
        Some(pattern) => format!(
            "{} {} um wide, {} um apart, {} um deep; the ratio is to the flat surface by the same method",
            pattern.planform().name(),
            um(pattern.width_m()),
            um(pattern.spacing_m()),
            um(pattern.depth_m()),
        ),
        None => "a flat surface: there is no ratio".to_owned(),
    });
    notes.push(
        "reference: the whole sample by the published scheme (Runge-Kutta of order 4, 1 ns, exact springs), from rest"
            .to_owned(),
    );
    notes.push(format!(
        "{seeds} draws of the local coefficients a row; errors are means over them, run by run with the same draw"
    ));
    notes.push(
        "+-: standard error of a difference, the larger of the scatter from draw to draw and both rows' batch means; \
         n.s.: not significant, below 2 standard errors (more by Student's t where only the draws tell, as for static mu)"
            .to_owned(),
    );
    notes.push(
        "block sizes: the reference's own blocks have an error too, so that finer ones depart from it and take no part in \
         the front; their own error stands apart"
            .to_owned(),
    );
    notes
}
