//! Flat friction in predictions of friction: its errors, as far as trials share and inform about them.

use crate::discrepancy::mixture::{Member, is_same};
use crate::discrepancy::rows::GLOBALS;
use crate::discrepancy::{Discrepancy, Load};
use slipgrid_base::statistics::cholesky::{covariance_factor, dot};

impl Discrepancy {
    /// Loads at which the trials share an error of the flat sample.
    pub fn flat_loads(&self) -> &[Load] {
        &self.basis().flat
    }

    /// Relative standard error of the flat sample at each of [`Self::flat_loads`], as the first trial states it.
    fn flat_stds(&self) -> Vec<f64> {
        let of = |load: &Load| self.rows().find(|(_, at)| is_same(&at.load, load) && at.flat_std > 0.0);
        self.basis().flat.iter().map(|load| of(load).map_or(1.0, |(_, at)| at.flat_std)).collect()
    }

    /// Shares of the flat sample's errors at the loads of trials in the errors of flat friction at other loads, and the
    /// covariance of the rest of these. `covariance` is that of the relative errors of flat friction x, first at the
    /// other loads, `count` in number, and then at [`Self::flat_loads`].
    ///
    /// ```text
    /// x_l = sum_k w_lk s_k + rest_l,     w_lk = cov(x_l, x_k) / max(var(s_k), var(x_k))
    /// ```
    ///
    /// with the independent errors `s_k` of the flat sample's friction at the loads of trials, from which flat friction
    /// was fitted. A fit that averages errors has cov(x_k, s_k) = var(x_k); one with further errors of its own has
    /// var(s_k). Shares that would exceed the variance of `x_l` are scaled down to it.
    pub fn flat_shares(&self, covariance: &[Vec<f64>], count: usize) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
        let stds = self.flat_stds();
        let share = |own: &Vec<f64>, variance: f64| {
            // In units of one standard deviation of each error.
            let in_stds =
                |(k, (own, std)): (usize, (&f64, &f64))| own * std / (std * std).max(covariance[count + k][count + k]);
            let all: Vec<f64> = own[count..].iter().zip(&stds).enumerate().map(in_stds).collect();
            let square = dot(&all, &all);
            let most = if square > variance { (variance / square).sqrt() } else { 1.0 };
            all.into_iter().map(|own| most * own).collect::<Vec<f64>>()
        };
        let shares: Vec<Vec<f64>> =
            covariance[..count].iter().enumerate().map(|(load, own)| share(own, own[load])).collect();
        let rest = |l: usize| (0..count).map(|m| covariance[l][m] - dot(&shares[l], &shares[m])).collect();
        let rest = (0..count).map(rest).collect();
        (shares, rest)
    }
}

/// Error of flat friction as known from the trials, of a member prepared for the loads: F_l = L^-1 w_l, with the shares
/// `w_l` of the flat sample's errors at load l.
#[derive(Clone, Debug)]
pub struct PreparedFlat {
    /// Posterior mean, one per load.
    pub mean: Vec<f64>,
    /// F_l, the entries of the residual's coefficients alone.
    pub residual: Vec<Vec<f64>>,
    /// Products B_l F_m of the form's coefficients, loads x loads.
    pub bf: Vec<f64>,
    /// Products E_k F_m of modulus and local law, one entry per load.
    pub ef: Vec<[f64; GLOBALS]>,
    /// Products F_l F_m, loads x loads.
    pub ff: Vec<f64>,
}

impl PreparedFlat {
    /// Prepares a member of `p` coefficients, the first `flat` of which are the flat sample's errors and those from
    /// `of_residual` on the residual's, for loads with the `shares` in these errors. `b` and `e` are B_l and E_k without
    /// the entries of the flat sample.
    pub fn new(
        member: &Member,
        [p, flat, of_residual]: [usize; 3],
        shares: &[Vec<f64>],
        (b, e): (&[Vec<f64>], &[Vec<f64>; GLOBALS]),
    ) -> Self {
        let row = |row: usize| -> Vec<f64> {
            let own = &member.inverse[row * p..][..=row.min(flat - 1)];
            shares.iter().map(|share| dot(own, share)).collect()
        };
        // All entries, row by row: those of the flat sample's own errors first.
        let all: Vec<Vec<f64>> = (0..p).map(row).collect();
        let n = shares.len();
        let f = |load: usize, from: usize| -> Vec<f64> { all[from..].iter().map(|row| row[load]).collect() };
        let beyond_flat: Vec<Vec<f64>> = (0..n).map(|load| f(load, flat)).collect();
        Self {
            mean: shares.iter().map(|share| dot(share, &member.mean)).collect(),
            residual: (0..n).map(|load| f(load, of_residual)).collect(),
            bf: b.iter().flat_map(|b| beyond_flat.iter().map(move |f| dot(b, f))).collect(),
            ef: beyond_flat.iter().map(|f| e.each_ref().map(|e| dot(e, f))).collect(),
            ff: (0..n * n).map(|e| all.iter().map(|row| row[e / n] * row[e % n]).sum()).collect(),
        }
    }
}

/// Covariance of values v given other values z, from the covariances `own` of v, `with` of v with z, and `given` of z,
/// which may be singular: the trailing block L L^T of the factor of all, z first.
pub fn conditional(own: &[f64], with: &[f64], given: &[f64]) -> Vec<f64> {
    let (all, n) = (own.len().isqrt(), given.len().isqrt());
    let joint = |row: usize, column: usize| match (row.checked_sub(n), column.checked_sub(n)) {
        (None, None) => given[row * n + column],
        (Some(a), None) => with[a * n + column],
        (None, Some(b)) => with[b * n + row],
        (Some(a), Some(b)) => own[a * all + b],
    };
    let size = n + all;
    let factor = covariance_factor(&(0..size * size).map(|e| joint(e / size, e % size)).collect::<Vec<_>>(), size);
    let row = |a: usize| &factor[(n + a) * size..][n..size];
    (0..all * all).map(|e| dot(row(e / all), row(e % all))).collect()
}
