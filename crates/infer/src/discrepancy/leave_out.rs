//! Cross-validation: predicts measurements from the remaining ones.

use slipgrid_base::monitor::{Cancelled, Monitor};
use slipgrid_base::statistics::normal_quantile;

use crate::discrepancy::mixture::{Member, is_same};
use crate::discrepancy::{Component, Discrepancy, Distribution};
use slipgrid_base::statistics::cholesky::{cholesky, dot, is_regular, log_determinant, solve_lower};

/// Measurements to leave out at a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LeftOut {
    /// One trial, predicted from all others.
    Trial,
    /// One condition (pressure, speed and humidity) in all trials, predicted from all others.
    Condition,
    /// One trial, predicted from the earlier trials only: the knowledge when the sample was cut.
    TrialAndLater,
}

/// Measurement together with its prediction from other measurements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surprise {
    /// Index of the trial, from 0.
    pub trial: usize,
    /// Index of the measurement in the trial, from 0.
    pub row: usize,
    /// Number of measurements used in the prediction; with 0, the prior is used.
    pub known: usize,
    /// Logarithm of the measured over the modelled ratio.
    pub measured: f64,
    /// Median predicted for `measured`, including the errors of the measurement.
    pub median: f64,
    /// Lower and upper end of the 68 % interval predicted for `measured`.
    pub interval_68: [f64; 2],
    /// Lower and upper end of the 95 % interval predicted for `measured`.
    pub interval_95: [f64; 2],
    /// Deviation of the measurement from its prediction: the standard normal deviate with the probability that was
    /// predicted for values below `measured`.
    pub surprise: f64,
}

/// Predicts every measurement of `discrepancy` without the measurements that `by` leaves out together with it.
///
/// # Errors
/// [`Cancelled`] once `monitor` has cancelled.
pub fn leave_out(discrepancy: &Discrepancy, by: LeftOut, monitor: &dyn Monitor) -> Result<Vec<Surprise>, Cancelled> {
    let rows: Vec<_> = discrepancy.rows().collect();
    let n = rows.len();
    let excess: Vec<f64> = rows.iter().map(|(_, at)| at.log_excess()).collect();
    let prior_mean: Vec<f64> = rows.iter().map(|(_, at)| at.sensitivity.prior_mean()).collect();
    let covariances: Vec<Vec<f64>> = discrepancy
        .members()
        .iter()
        .map(|member| covariance(discrepancy, member, &discrepancy.noise_of(member)))
        .collect();
    let mut found = Vec::new();
    let mut done = vec![false; n];
    for first in 0..n {
        if done[first] {
            continue;
        }
        monitor.heed()?;
        let (trial, at) = rows[first];
        let is_wanted = |row: &usize| match by {
            LeftOut::Trial | LeftOut::TrialAndLater => rows[*row].0 == trial,
            LeftOut::Condition => is_same(&rows[*row].1.load, &at.load),
        };
        let is_known = |row: &usize| match by {
            LeftOut::TrialAndLater => rows[*row].0 < trial,
            _ => !is_wanted(row),
        };
        let wanted: Vec<usize> = (0..n).filter(is_wanted).collect();
        let known: Vec<usize> = (0..n).filter(is_known).collect();
        let prediction = conditional(discrepancy, &covariances, (&excess, &prior_mean), [&known, &wanted]);
        for (load, &row) in wanted.iter().enumerate() {
            done[row] = true;
            let (trial, own) = (rows[row].0, row - rows.iter().position(|(of, _)| *of == rows[row].0).unwrap_or(0));
            let quantile = |p: f64| prediction.quantile(load, p);
            // Probabilities of exactly 0 or 1 are clamped to keep the quantile finite.
            let below = prediction.probability_below(load, excess[row]).clamp(1e-300, 1.0 - 1e-16);
            found.push(Surprise {
                trial,
                row: own,
                known: known.len(),
                measured: excess[row],
                median: quantile(0.5),
                interval_68: [quantile(0.16), quantile(0.84)],
                interval_95: [quantile(0.025), quantile(0.975)],
                surprise: normal_quantile(below),
            });
        }
    }
    found.sort_by_key(|surprise| (surprise.trial, surprise.row));
    Ok(found)
}

/// Covariance of all measurements for one member of the mixture, row by row: noise + Phi Phi^T, with the basis
/// functions Phi at the measurements. Measurements lie at places of the residual's basis, so the basis is exact.
fn covariance(discrepancy: &Discrepancy, member: &Member, noise: &[f64]) -> Vec<f64> {
    let rows = discrepancy.basis_rows(member);
    let n = rows.len();
    (0..n * n).map(|entry| noise[entry] + dot(&rows[entry / n], &rows[entry % n])).collect()
}

/// Distribution of the measurements `wanted` given the measurements `known`, including errors. With the prior means m,
/// the covariance K and the measured y, the mean is m_w + K_wk K_kk^-1 (y - m_k), and the covariance K_ww - K_wk
/// K_kk^-1 K_kw.
fn conditional(
    discrepancy: &Discrepancy,
    covariances: &[Vec<f64>],
    (excess, prior_mean): (&[f64], &[f64]),
    [known, wanted]: [&[usize]; 2],
) -> Distribution {
    let (n, k, m) = (excess.len(), known.len(), wanted.len());
    let mut evidences = Vec::new();
    let mut components = Vec::new();
    for (member, all) in discrepancy.members().iter().zip(covariances) {
        let inner: Vec<f64> = known.iter().flat_map(|i| known.iter().map(move |j| all[i * n + j])).collect();
        // The noise is regular, so every submatrix is regular.
        let Some(factor) = cholesky(&inner, k).filter(|factor| is_regular(factor, k)) else { continue };
        let mut y: Vec<f64> = known.iter().map(|i| excess[*i] - prior_mean[*i]).collect();
        solve_lower(&factor, k, &mut y);
        let columns: Vec<Vec<f64>> = wanted
            .iter()
            .map(|j| {
                let mut column: Vec<f64> = known.iter().map(|i| all[i * n + j]).collect();
                solve_lower(&factor, k, &mut column);
                column
            })
            .collect();
        evidences.push(-0.5 * (dot(&y, &y) + log_determinant(&factor, k)));
        let entry = |e: usize| all[wanted[e / m] * n + wanted[e % m]] - dot(&columns[e / m], &columns[e % m]);
        components.push(Component {
            form: member.form,
            weight: member.prior,
            mean: columns.iter().zip(wanted).map(|(column, j)| prior_mean[*j] + dot(column, &y)).collect(),
            covariance: (0..m * m).map(entry).collect(),
        });
    }
    let most = evidences.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    for (component, evidence) in components.iter_mut().zip(&evidences) {
        component.weight *= libm::exp(evidence - most);
    }
    let sum: f64 = components.iter().map(|component| component.weight).sum();
    components.iter_mut().for_each(|component| component.weight /= sum);
    Distribution { components }
}
