//! Errors of methods against the reference, and the Pareto front of wall time and error.

use serde::Serialize;
use slipgrid_base::statistics::{Confidence, mean_and_std};
use slipgrid_base::units::{STEP_NS, tidy};

use super::measure::Run;
use super::plan::{Family, Method};

/// Names of the compared observables, in the order of [`Run::values`].
pub const OBSERVABLES: [&str; 3] = ["dynamic mu", "static mu", "ratio"];

/// Minimum significant difference, in standard errors.
const SIGNIFICANT: f64 = 2.0;
/// Factor on the smallest distinguishable error, because standard errors from a few tens of batches are uncertain by a
/// fifth: smaller errors count as equal in the ranking.
const STDERR_UNCERTAINTY: f64 = 1.25;
/// Wall times count as equal if the ratio of the shorter to the longer exceeds this value: runs of one method differ by
/// as much.
const SAME_COST: f64 = 0.9;

/// Method with its wall time and its errors against the reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Compared {
    /// The method.
    #[serde(flatten)]
    pub method: Method,
    /// Status of the first run that did not end as planned, or of all runs if all ended as planned.
    pub status: String,
    /// Time step; null for steady runs.
    pub step_ns: Option<f64>,
    /// Blocks times force evaluations of the timed run, both surfaces; null for steady runs.
    pub site_updates: Option<u64>,
    /// Wall time of the timed run on one thread.
    pub wall_s: f64,
    /// Site updates per second of integration; null for steady runs.
    pub site_updates_per_s: Option<f64>,
    /// Values of dynamic mu, static mu and the ratio patterned over flat; null where a method gives none.
    pub values: [Option<Value>; 3],
}

/// Mean of an observable over the random draws of the local coefficients, and difference from the reference.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Value {
    /// The mean.
    pub mean: f64,
    /// Standard deviation between draws; null for a single draw.
    pub std: Option<f64>,
    /// Standard error of the mean from batch means within the runs: scatter in time, not between draws.
    pub stderr: Option<f64>,
    /// Difference from the reference, in per cent; null for the reference, or if the reference lacks the observable.
    pub difference_pct: Option<f64>,
    /// Standard error of the difference, in per cent; null if unknown.
    pub difference_stderr_pct: Option<f64>,
    /// Maximum difference that chance may cause, in per cent; null without a standard error.
    pub chance_pct: Option<f64>,
    /// Whether the method is on the Pareto front: no method that gives as many observables is both faster and at least
    /// as accurate.
    pub is_on_front: bool,
    /// Method that is faster and no less accurate; null if the method is on the front, or takes no part in it.
    pub better: Option<String>,
}

impl Value {
    /// Whether the difference exceeds the difference that chance may cause; `None` if either is unknown.
    pub fn is_significant(&self) -> Option<bool> {
        Some(self.difference_pct?.abs() > self.chance_pct?)
    }

    /// Upper bound of the error in per cent: the larger of the difference and the difference that chance may cause;
    /// `None` without a difference.
    pub fn error_pct(&self) -> Option<f64> {
        self.difference_pct.map(|percent| percent.abs().max(self.chance_pct.unwrap_or(0.0)))
    }
}

/// Compares `methods`, the reference first, by `runs`, one list per method. Returns the smallest distinguishable error
/// of each observable, in per cent (`None` if the reference gives no standard error of the observable), and the
/// compared methods.
pub fn compare(methods: Vec<Method>, runs: &[Vec<Run>]) -> ([Option<f64>; 3], Vec<Compared>) {
    let reference = runs.first().map_or(&[][..], Vec::as_slice);
    let mut compared: Vec<Compared> =
        methods.into_iter().zip(runs).map(|(method, runs)| Compared::new(method, runs, reference)).collect();
    let resolution_pct = std::array::from_fn(|observable| {
        let value = compared.first()?.values[observable].as_ref()?;
        // The difference of two independent means has sqrt 2 times the standard error of one.
        let std = std::f64::consts::SQRT_2 * 100.0 * value.stderr? / value.mean.abs();
        Some(STDERR_UNCERTAINTY * SIGNIFICANT * std)
    });
    for (observable, floor_pct) in resolution_pct.iter().enumerate() {
        rank(&mut compared, observable, floor_pct.unwrap_or(0.0));
    }
    (resolution_pct, compared)
}

/// Finds the front of wall time and error in the observable with the index `observable`; errors below `floor_pct` per
/// cent count as equal.
fn rank(methods: &mut [Compared], observable: usize, floor_pct: f64) {
    let places: Vec<(usize, f64, f64)> = (1..methods.len())
        .filter_map(|place| {
            let method = &methods[place];
            // The reference has an error due to its block size, so that a difference with other blocks is not an error.
            let error_pct = method.values[observable].as_ref()?.error_pct().filter(|_| method.is_of_its_blocks())?;
            (method.wall_s > 0.0).then_some((place, method.wall_s, error_pct.max(floor_pct)))
        })
        .collect();
    let dominates = |(a, cost_a, error_a): &(usize, f64, f64), (b, cost_b, error_b): &(usize, f64, f64)| {
        let gives = |of: usize| methods[of].values.each_ref().map(Option::is_some);
        let answers_as_much = gives(*a).into_iter().zip(gives(*b)).all(|(a, b)| a || !b);
        let is_better =
            cost_a < &(SAME_COST * cost_b) && error_a <= error_b || SAME_COST * cost_a <= *cost_b && error_a < error_b;
        answers_as_much && is_better
    };
    let better_than = |one| places.iter().filter(move |other| dominates(other, one));
    let is_on_front = |one| better_than(one).next().is_none();
    let found: Vec<(usize, Option<String>)> = places
        .iter()
        .map(|one| {
            let better = better_than(one).find(|other| is_on_front(other)).or_else(|| better_than(one).next());
            (one.0, better.map(|(place, ..)| methods[*place].method.name.clone()))
        })
        .collect();
    for (place, better) in found {
        if let Some(value) = &mut methods[place].values[observable] {
            value.is_on_front = better.is_none();
            value.better = better;
        }
    }
}

impl Compared {
    fn new(method: Method, runs: &[Run], reference: &[Run]) -> Self {
        let timed = runs.first();
        let ended = runs.iter().find(|run| !run.has_converged()).or(timed);
        Self {
            status: ended.map_or_else(|| "missing".to_owned(), |run| run.status.clone()),
            step_ns: timed.and_then(|run| run.dt_s).map(|dt_s| tidy(STEP_NS.from_si(dt_s))),
            site_updates: timed.map(|run| run.site_updates).filter(|updates| *updates > 0),
            wall_s: timed.map_or(0.0, |run| run.wall_s),
            site_updates_per_s: timed.and_then(|run| run.site_updates_per_s),
            values: std::array::from_fn(|observable| {
                // The reference is not compared with itself.
                let other = if method.changes.is_empty() { &[] } else { reference };
                value(observable, runs, other)
            }),
            method,
        }
    }

    /// Whether the method has the block size of the reference.
    fn is_of_its_blocks(&self) -> bool {
        self.method.family != Family::BlockSize
    }
}

/// Mean of the observable with the index `observable` over `runs`, and mean difference from `reference` between runs of
/// equal seed; `None` if no run gives the observable.
///
/// Runs of one seed have equal local coefficients. The standard error of the difference is the larger of two estimates:
/// the scatter of the differences between seeds, which includes the scatter between draws, and the combined batch
/// means, which do not require many seeds. Without batch means, Student's t for the number of seeds widens the
/// difference that chance may cause.
fn value(observable: usize, runs: &[Run], reference: &[Run]) -> Option<Value> {
    let found: Vec<(f64, Option<f64>)> = runs.iter().filter_map(|run| run.values[observable]).collect();
    let (mean, std) = mean_and_std(found.iter().map(|(value, _)| *value))?;
    // Standard error of a mean of n independent means: sqrt(sum s_i^2) / n
    let stderr: Option<f64> = found.iter().map(|(_, stderr)| stderr.map(|stderr| stderr * stderr)).sum();
    let stderr = stderr.map(|squares| squares.sqrt() / found.len() as f64);
    let alone = Value { mean, std, stderr, ..Value::default() };
    let pairs: Vec<_> = runs
        .iter()
        .filter_map(|run| {
            let same = reference.iter().find(|other| other.seed == run.seed)?;
            Some((run.values[observable]?, same.values[observable]?))
        })
        .collect();
    let count = pairs.len() as f64;
    let scale = pairs.iter().map(|(_, (reference, _))| reference).sum::<f64>() / count;
    let percents = pairs.iter().map(|((own, _), (reference, _))| 100.0 * (own - reference) / scale);
    let Some((percent, std)) = mean_and_std(percents).filter(|_| scale != 0.0) else { return Some(alone) };
    let scatter = std.map(|std| std / count.sqrt());
    let squares: Option<f64> =
        pairs.iter().map(|((_, own), (_, reference))| Some(own.as_ref()?.powi(2) + reference.as_ref()?.powi(2))).sum();
    let batches = squares.map(|squares| 100.0 * squares.sqrt() / (count * scale.abs()));
    let stderr_pct = [scatter, batches].into_iter().flatten().reduce(f64::max);
    let limit =
        if batches.is_some() { SIGNIFICANT } else { Confidence::TWO_SIGMA.student_t(pairs.len().saturating_sub(1)) };
    Some(Value {
        difference_pct: Some(percent),
        difference_stderr_pct: stderr_pct,
        chance_pct: stderr_pct.map(|stderr| limit * stderr),
        ..alone
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(seed: u64, mu: f64, stderr: Option<f64>) -> Run {
        Run { seed, values: [Some((mu, stderr)), None, None], ..Run::default() }
    }

    #[test]
    fn a_constant_shift_is_judged_by_the_batch_means() {
        let reference = [run(1, 0.25, Some(0.003)), run(2, 0.75, Some(0.004))];
        let runs = [run(2, 0.76, Some(0.0)), run(1, 0.26, Some(0.0))];
        let found = value(0, &runs, &reference).unwrap();
        assert!((found.difference_pct.unwrap() - 2.0).abs() < 1e-12 && (found.mean - 0.51).abs() < 1e-12);
        // sqrt(0.003^2 + 0.004^2) / 2 over 0.5
        assert!((found.difference_stderr_pct.unwrap() - 0.5).abs() < 1e-12);
        assert_eq!((found.is_significant(), found.error_pct()), (Some(true), found.difference_pct));
    }

    #[test]
    fn scatter_between_seeds_counts_where_it_is_larger() {
        let reference = [run(1, 0.5, Some(1e-6)), run(2, 0.5, Some(1e-6))];
        let found = value(0, &[run(1, 0.5, Some(1e-6)), run(2, 0.51, Some(1e-6))], &reference).unwrap();
        // 0 and 2 per cent: mean 1, standard deviation sqrt 2, standard error 1
        assert!((found.difference_pct.unwrap() - 1.0).abs() < 1e-12);
        assert_eq!(found.is_significant(), Some(false));
        assert!((found.error_pct().unwrap() - 2.0).abs() < 1e-12);
    }

    #[test]
    fn one_run_without_a_standard_error_tells_no_significance() {
        let found = value(0, &[run(1, 0.3, None)], &[run(1, 0.25, None)]).unwrap();
        assert!((found.difference_pct.unwrap() - 20.0).abs() < 1e-12);
        assert_eq!((found.difference_stderr_pct, found.is_significant()), (None, None));
        assert_eq!(value(0, &[run(2, 0.3, None)], &[run(1, 0.25, None)]).unwrap().difference_pct, None);
        assert!(value(2, &[run(1, 0.3, None)], &[run(1, 0.25, None)]).is_none());
    }

    #[test]
    fn few_seeds_alone_tell_little() {
        let runs = [1.0, 1.1, 1.2].map(|mu| run((10.0 * mu) as u64, mu, None));
        let reference = [1.0, 1.1, 1.2].map(|mu| run((10.0 * mu) as u64, 1.0, None));
        // 0, 10 and 20 per cent: 10 +- 5.8 is not significant for three values, whose t is 4.527.
        let found = value(0, &runs, &reference).unwrap();
        assert!((found.difference_stderr_pct.unwrap() - 10.0 / 3.0_f64.sqrt()).abs() < 1e-9);
        assert!((found.chance_pct.unwrap() / found.difference_stderr_pct.unwrap() - 4.527).abs() < 2e-3);
        assert_eq!(found.is_significant(), Some(false));
    }

    /// Names of the methods on the front, given by cost, error and whether they give static friction.
    fn front(methods: &[(f64, f64, bool)], floor_pct: f64) -> Vec<usize> {
        let one = |(wall_s, error, gives_static): (f64, f64, bool)| Compared {
            method: Method {
                name: String::new(),
                label: String::new(),
                family: Family::Steady,
                changes: Vec::new(),
                default_of: None,
            },
            status: String::new(),
            step_ns: None,
            site_updates: None,
            wall_s,
            site_updates_per_s: None,
            values: [
                Some(Value { difference_pct: Some(error), ..Value::default() }),
                gives_static.then(Value::default),
                None,
            ],
        };
        let mut all: Vec<Compared> =
            std::iter::once((1.0, 0.0, true)).chain(methods.iter().copied()).map(one).collect();
        rank(&mut all, 0, floor_pct);
        (1..all.len())
            .filter(|place| all[*place].values[0].as_ref().unwrap().is_on_front)
            .map(|place| place - 1)
            .collect()
    }

    #[test]
    fn the_front_has_the_methods_that_none_beats_in_time_and_error() {
        let alike = |all: &[[f64; 2]]| all.iter().map(|[cost, error]| (*cost, *error, false)).collect::<Vec<_>>();
        let five = alike(&[[1.0, 3.0], [2.0, 1.0], [3.0, 2.0], [4.0, 0.5], [1.0, 4.0]]);
        assert_eq!(front(&five, 0.0), [0, 1, 3]);
        // Below the smallest distinguishable error only the fastest counts.
        let close = alike(&[[1.0, 3.0], [2.0, 0.4], [3.0, 0.2], [4.0, 0.0]]);
        assert_eq!((front(&close, 0.5), front(&close, 0.0)), (vec![0, 1], vec![0, 1, 2, 3]));
        // Times within a tenth are equal.
        assert_eq!(front(&alike(&[[1.0, 1.0], [1.05, 1.0]]), 0.0), [0, 1]);
        assert_eq!(front(&alike(&[[1.0, 1.0], [1.05, 0.5], [1.2, 0.5]]), 0.0), [1]);
        // A method without static friction does not beat one that gives it.
        assert_eq!(front(&[(1.0, 0.5, false), (2.0, 1.0, true), (3.0, 1.0, true)], 0.0), [0, 1]);
    }
}
