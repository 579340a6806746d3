//! Difference between two rows, and its statistical significance.

use super::measure::Run;
use slipgrid_base::statistics::{Confidence, mean_and_std};

/// A difference below this number of standard errors is not significant.
pub const SIGNIFICANT: f64 = 2.0;

/// Significance threshold if the standard error is estimated from `count` values only.
fn significant_of(count: usize) -> f64 {
    Confidence::TWO_SIGMA.student_t(count.saturating_sub(1))
}

/// Observable of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Dynamic friction coefficient.
    MuDynamic,
    /// Static friction coefficient.
    MuStatic,
    /// Ratio of dynamic friction, patterned over flat.
    Ratio,
}

impl Quantity {
    /// Name on the page.
    pub const fn name(self) -> &'static str {
        match self {
            Self::MuDynamic => "dynamic mu",
            Self::MuStatic => "static mu",
            Self::Ratio => "ratio",
        }
    }

    /// Value of one run and its standard error, if the run provides one.
    pub fn of(self, run: &Run) -> Option<(f64, Option<f64>)> {
        match self {
            Self::MuDynamic => Some((run.mu_dynamic?, run.mu_dynamic_stderr)),
            Self::MuStatic => Some((run.mu_static?, None)),
            Self::Ratio => Some((run.ratio?, run.ratio_stderr)),
        }
    }
}

/// Mean over seeds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mean {
    /// The mean.
    pub value: f64,
    /// Standard deviation between seeds; `None` for a single seed.
    pub std: Option<f64>,
    /// Standard error of the mean from the batch means within the runs: scatter in time, not between draws.
    pub stderr: Option<f64>,
}

/// Mean of `quantity` over the `runs` that provide it.
pub fn mean(quantity: Quantity, runs: &[Run]) -> Option<Mean> {
    let found: Vec<(f64, Option<f64>)> = runs.iter().filter_map(|run| quantity.of(run)).collect();
    let values: Vec<f64> = found.iter().map(|(value, _)| *value).collect();
    let (value, std) = mean_and_std(values.iter().copied())?;
    // Standard error of a mean of n independent means: sqrt(sum s_i^2) / n
    let squares: Option<f64> = found.iter().map(|(_, stderr)| stderr.map(|stderr| stderr * stderr)).sum();
    Some(Mean { value, std, stderr: squares.map(|squares| squares.sqrt() / found.len() as f64) })
}

/// Difference between two rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// Mean over the seeds, in per cent of the other row's value.
    pub percent: f64,
    /// Standard error of `percent`; `None` if unknown.
    pub stderr: Option<f64>,
    /// Maximum difference that chance may cause, in per cent.
    pub chance: Option<f64>,
}

impl Difference {
    /// Whether the difference is significant; `None` if unknown.
    pub fn is_significant(&self) -> Option<bool> {
        Some(self.percent.abs() > self.chance?)
    }

    /// Upper bound of the error: the difference itself if significant, otherwise the maximum difference that chance
    /// may cause.
    pub fn bound(&self) -> f64 {
        self.percent.abs().max(self.chance.unwrap_or(0.0))
    }
}

/// Difference of `runs` from `judge`, seed by seed.
///
/// Runs of one seed have equal local coefficients. The standard error is the larger of two estimates: the scatter
/// of the differences between seeds, which includes the scatter between draws, and the combined batch means of both
/// rows, which does not require many seeds. Without batch means, a small number of seeds increases the bound
/// of chance.
pub fn difference(quantity: Quantity, runs: &[Run], judge: &[Run]) -> Option<Difference> {
    let pairs: Vec<_> = runs
        .iter()
        .filter_map(|run| {
            let same = judge.iter().find(|other| other.seed == run.seed)?;
            Some((quantity.of(run)?, quantity.of(same)?))
        })
        .collect();
    let count = pairs.len() as f64;
    let scale = pairs.iter().map(|(_, (judge, _))| judge).sum::<f64>() / count;
    if scale == 0.0 {
        return None;
    }
    let differences: Vec<f64> = pairs.iter().map(|((own, _), (judge, _))| 100.0 * (own - judge) / scale).collect();
    let (percent, std) = mean_and_std(differences.iter().copied())?;
    let scatter = std.map(|std| std / count.sqrt());
    let squares: Option<f64> =
        pairs.iter().map(|((_, own), (_, judge))| Some(own.as_ref()?.powi(2) + judge.as_ref()?.powi(2))).sum();
    let batches = squares.map(|squares| 100.0 * squares.sqrt() / (count * scale.abs()));
    let stderr = [scatter, batches].into_iter().flatten().reduce(f64::max);
    let standard_errors = if batches.is_some() { SIGNIFICANT } else { significant_of(pairs.len()) };
    Some(Difference { percent, stderr, chance: stderr.map(|stderr| standard_errors * stderr) })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(seed: u64, mu: f64, stderr: Option<f64>) -> Run {
        Run { seed, mu_dynamic: Some(mu), mu_dynamic_stderr: stderr, ..Run::default() }
    }

    const MU: Quantity = Quantity::MuDynamic;

    #[test]
    fn a_constant_shift_is_judged_by_the_batch_means() {
        let judge = [run(1, 0.25, Some(0.003)), run(2, 0.75, Some(0.004))];
        let runs = [run(2, 0.76, Some(0.0)), run(1, 0.26, Some(0.0))];
        let found = difference(MU, &runs, &judge).unwrap();
        assert!((found.percent - 2.0).abs() < 1e-12);
        // sqrt(0.003^2 + 0.004^2) / 2 over 0.5
        assert!((found.stderr.unwrap() - 0.5).abs() < 1e-12);
        assert_eq!((found.is_significant(), found.bound()), (Some(true), found.percent));
    }

    #[test]
    fn scatter_from_seed_to_seed_counts_where_it_is_larger() {
        let judge = [run(1, 0.5, Some(1e-6)), run(2, 0.5, Some(1e-6))];
        let runs = [run(1, 0.5, Some(1e-6)), run(2, 0.51, Some(1e-6))];
        let found = difference(MU, &runs, &judge).unwrap();
        // 0 and 2 per cent: mean 1, standard deviation sqrt 2, standard error 1
        assert!((found.percent - 1.0).abs() < 1e-12 && (found.stderr.unwrap() - 1.0).abs() < 1e-12);
        assert_eq!(found.is_significant(), Some(false));
        assert!((found.bound() - 2.0).abs() < 1e-12);
    }

    #[test]
    fn one_run_without_a_standard_error_tells_no_significance() {
        let found = difference(MU, &[run(1, 0.3, None)], &[run(1, 0.25, None)]).unwrap();
        assert!((found.percent - 20.0).abs() < 1e-12);
        assert_eq!((found.stderr, found.is_significant()), (None, None));
        assert!(difference(MU, &[run(2, 0.3, None)], &[run(1, 0.25, None)]).is_none());
        assert!(difference(Quantity::Ratio, &[run(1, 0.3, None)], &[run(1, 0.25, None)]).is_none());
    }

    #[test]
    fn few_seeds_alone_tell_little() {
        // Quantiles of Student's t that leave 4.55 % on both sides.
        for (count, quantile) in [(2, 13.968), (3, 4.527), (6, 2.649), (10, 2.320), (31, 2.087), (1_000_001, 2.0)] {
            assert!((significant_of(count) / quantile - 1.0).abs() < 2e-3, "{count} {}", significant_of(count));
        }
        let runs = [1.0, 1.1, 1.2].map(|mu| run((10.0 * mu) as u64, mu, None));
        let judge = [1.0, 1.1, 1.2].map(|mu| run((10.0 * mu) as u64, 1.0, None));
        // 0, 10 and 20 per cent: 10 +- 5.8 is not significant for three values.
        let found = difference(MU, &runs, &judge).unwrap();
        assert!((found.percent - 10.0).abs() < 1e-9 && (found.stderr.unwrap() - 10.0 / 3.0_f64.sqrt()).abs() < 1e-9);
        assert!((found.chance.unwrap() / found.stderr.unwrap() - 4.527).abs() < 1e-9);
        assert_eq!(found.is_significant(), Some(false));
    }

    #[test]
    fn a_mean_over_seeds() {
        let found = mean(MU, &[run(1, 0.25, Some(0.03)), run(2, 0.5, Some(0.04)), run(3, 0.75, Some(0.0))]).unwrap();
        assert!((found.value - 0.5).abs() < 1e-15 && (found.std.unwrap() - 0.25).abs() < 1e-15);
        assert!((found.stderr.unwrap() - 0.05 / 3.0).abs() < 1e-15);
        assert!(mean(MU, &[]).is_none());
    }
}
