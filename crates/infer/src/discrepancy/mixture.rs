//! Posterior mixture of all forms given the trials.

use crate::discrepancy::rows::Basis;
use crate::discrepancy::{
    Conditions, DimensionShift, DiscrepancyError, Features, Form, Hyperparameters, Load, Measured, Predictor, Trial,
};
use slipgrid_base::statistics::cholesky::{cholesky, dot, is_regular, log_determinant, solve_lower, solve_upper};
use slipgrid_base::units;

/// Number of regressions after the first. Each updates the discrepancy at the trials, which multiplies the effect of
/// errors of their dimensions: for errors of 10 % of the form and a discrepancy of 0.3, the change left after three
/// regressions is 1e-4.
const ROUNDS: usize = 3;

/// Posterior of the discrepancy, ln(measured / modelled ratio), given the trials, or the prior without trials.
#[derive(Clone, Debug)]
pub struct Discrepancy {
    trials: Vec<Trial>,
    basis: Basis,
    members: Vec<Member>,
}

impl PartialEq for Discrepancy {
    /// Compares trials and prior, which determine the posterior.
    fn eq(&self, other: &Self) -> bool {
        self.conditions() == other.conditions()
            && self.trials == other.trials
            && self.hyperparameters() == other.hyperparameters()
            && self.modulus_relative_std() == other.modulus_relative_std()
    }
}

/// Member of the mixture: regression of one form with one scale, residual and scatter. Coefficients are in units of
/// their prior standard deviations.
#[derive(Clone, Debug)]
pub(crate) struct Member {
    pub form: Form,
    /// Factor on the standard deviations of the form's coefficients.
    pub scale: f64,
    /// Standard deviation of the residual over that of the amplitude, alpha.
    pub residual: f64,
    /// Standard deviation of ln(ratio) between samples of one texture, for trials that state none.
    pub scatter: f64,
    pub prior: f64,
    pub weight: f64,
    /// Value of the form at the reference texture; 1 without an effect.
    pub at_reference: f64,
    pub mean: Vec<f64>,
    /// L^-1, with the posterior precision L L^T of the coefficients: a lower triangle, row by row.
    pub inverse: Vec<f64>,
    /// Posterior mean of the discrepancy at each measurement, without the terms of the flat sample, of Young's modulus
    /// and of the local law; needed for errors of a trial's dimensions.
    pub at_trials: Vec<f64>,
}

impl Member {
    /// Value of the form, 1 at the reference texture, times the scale.
    pub fn value(&self, of: &Features) -> f64 {
        self.scale * self.form.on_face(of) / self.at_reference
    }
}

/// Form with its prior and posterior weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FormWeight {
    /// Form of the discrepancy.
    pub form: Form,
    /// Prior weight.
    pub prior: f64,
    /// Posterior weight.
    pub weight: f64,
}

impl Discrepancy {
    /// Learns the discrepancy from `trials`. `modulus_relative_std` is the relative standard deviation of Young's
    /// modulus, 0 if exact.
    ///
    /// # Errors
    /// [`DiscrepancyError`] for an invalid number, or if the covariance of the measurements has no inverse.
    pub fn new(
        hyper: Hyperparameters,
        conditions: Conditions,
        modulus_relative_std: f64,
        trials: Vec<Trial>,
    ) -> Result<Self, DiscrepancyError> {
        hyper.check()?;
        trials.iter().try_for_each(Trial::check)?;
        if !(0.0..=10.0).contains(&modulus_relative_std) {
            let (name, expected) = ("error of Young's modulus over itself", "from 0 to 10");
            return Err(DiscrepancyError::Hyperparameter { name, value: modulus_relative_std, expected });
        }
        let basis = Basis::new(&hyper, conditions, modulus_relative_std, &trials);
        let mut found = Self { trials, basis, members: Vec::new() };
        let mut fitted: Vec<(Member, f64)> = Vec::new();
        for (scatter, weight) in found.scatters() {
            let noise = found.noise(scatter, &|_, _| 0.0);
            let whitened = found.whitened(&noise).ok_or(DiscrepancyError::Singular)?;
            // Sequential, because files are read by callers without a thread pool.
            let at_scatter = members(&hyper, (scatter, weight))
                .into_iter()
                .map(|member| found.fit_as_made(member, &whitened))
                .collect::<Option<Vec<_>>>();
            fitted.extend(at_scatter.ok_or(DiscrepancyError::Singular)?);
        }
        let most = fitted.iter().map(|(_, evidence)| *evidence).fold(f64::NEG_INFINITY, f64::max);
        let sum: f64 = fitted.iter().map(|(member, evidence)| member.prior * libm::exp(evidence - most)).sum();
        found.members = fitted
            .into_iter()
            .map(|(member, evidence)| Member { weight: member.prior * libm::exp(evidence - most) / sum, ..member })
            .collect();
        Ok(found)
    }

    /// Returns the trials.
    pub fn trials(&self) -> &[Trial] {
        &self.trials
    }

    /// Returns the reference pressures and speed.
    pub const fn conditions(&self) -> Conditions {
        self.basis.conditions
    }

    /// Returns the prior.
    pub const fn hyperparameters(&self) -> &Hyperparameters {
        &self.basis.hyper
    }

    /// Returns the prior relative standard deviation of Young's modulus.
    pub const fn modulus_relative_std(&self) -> f64 {
        self.basis.modulus_std
    }

    /// Returns posterior mean and standard deviation of the share lambda of the local law: 0 if local friction follows
    /// the nominal pressure, 1 if it follows the local pressure.
    pub fn local_law(&self) -> (f64, f64) {
        let [_, place] = self.basis.globals();
        let [_, prior_std] = self.basis.global_stds();
        let p = self.basis.count();
        let of = |member: &Member| {
            let [_, mean] = self.basis.global_means(&member.mean);
            let square: f64 = (place..p).map(|row| member.inverse[row * p + place].powi(2)).sum();
            [member.weight, mean, prior_std * prior_std * square]
        };
        let all: Vec<[f64; 3]> = self.members.iter().map(of).collect();
        let mean: f64 = all.iter().map(|[weight, mean, _]| weight * mean).sum();
        let variance: f64 = all.iter().map(|[weight, own, var]| weight * (var + (own - mean).powi(2))).sum();
        (mean, variance.sqrt())
    }

    /// Returns the forms with their weights.
    pub fn forms(&self) -> Vec<FormWeight> {
        let weight = |form: Form, of: fn(&Member) -> f64| -> f64 {
            self.members.iter().filter(|member| member.form == form).map(of).sum()
        };
        let own = |form: Form| FormWeight {
            form,
            prior: weight(form, |member| member.prior),
            weight: weight(form, |member| member.weight),
        };
        self.hyperparameters().forms.iter().map(|(form, _)| own(*form)).collect()
    }

    /// Prepares predictions of ratios at `loads`.
    pub fn at(&self, loads: &[Load]) -> Predictor {
        self.of_friction_at(loads, &[])
    }

    /// Prepares predictions at `loads` of friction, relative to the modelled ratio times the flat friction as known:
    /// the trials that informed about the flat sample's errors share these with the prediction. `shares` are those of
    /// [`Self::flat_shares`]; without shares ratios are predicted.
    pub fn of_friction_at(&self, loads: &[Load], shares: &[Vec<f64>]) -> Predictor {
        Predictor::new(&self.basis, &self.members, loads, shares)
    }

    /// Learns from other trials with an unchanged prior.
    ///
    /// # Errors
    /// [`DiscrepancyError`] as for [`Discrepancy::new`].
    pub fn with_trials(&self, trials: Vec<Trial>) -> Result<Self, DiscrepancyError> {
        Self::new(self.hyperparameters().clone(), self.conditions(), self.modulus_relative_std(), trials)
    }

    pub(crate) const fn basis(&self) -> &Basis {
        &self.basis
    }

    pub(crate) fn members(&self) -> &[Member] {
        &self.members
    }

    /// Measurements with the index of their trial.
    pub(crate) fn rows(&self) -> impl Iterator<Item = (usize, &Measured)> {
        self.trials.iter().enumerate().flat_map(|(place, trial)| trial.measured.iter().map(move |at| (place, at)))
    }

    /// Basis functions of all coefficients at each measurement, for one member of the mixture.
    pub(crate) fn basis_rows(&self, member: &Member) -> Vec<Vec<f64>> {
        let row = |(trial, at): (usize, &Measured)| {
            let features = &self.trials[trial].features;
            let flat = self.basis.flat_row(&at.load, at.flat_std);
            self.basis.row(flat, [member.value(features), member.residual], features, &at.load, at.sensitivity)
        };
        self.rows().map(row).collect()
    }

    /// Standard deviation of the scatter of the sample with index `trial`; `scatter` if the trial states none.
    pub(crate) fn own_std(&self, trial: usize, scatter: f64) -> f64 {
        self.trials[trial].sample_std.unwrap_or(scatter)
    }

    /// Whether two trials were cut on one disc and therefore share one deviation due to scatter.
    pub(crate) fn is_one_disc(&self, left: usize, right: usize) -> bool {
        left == right
            || self.trials[left].disc.as_ref().is_some_and(|disc| self.trials[right].disc.as_ref() == Some(disc))
    }

    /// Covariance of all measurements for known coefficients: scatter between discs, shared by trials of one disc; errors
    /// of a sample's dimensions; and measurement errors. Samples without a stated scatter have `scatter`.
    /// `discrepancy_by` is the change of the discrepancy at a row by a shift of its trial's dimensions.
    pub(crate) fn noise(&self, scatter: f64, discrepancy_by: &dyn Fn(usize, &DimensionShift) -> f64) -> Vec<f64> {
        let rows: Vec<(usize, &Measured)> = self.rows().collect();
        let n = rows.len();
        // Index of each row within its trial.
        let own: Vec<usize> = self.trials.iter().flat_map(|trial| 0..trial.measured.len()).collect();
        let mut noise = vec![0.0; n * n];
        for (i, (left, a)) in rows.iter().enumerate() {
            for (j, (right, _)) in rows.iter().enumerate() {
                let mut shared = 0.0;
                if self.is_one_disc(*left, *right) {
                    // cov(t_a, t_b) = s_a s_b
                    shared += self.own_std(*left, scatter) * self.own_std(*right, scatter);
                }
                if left == right {
                    let by =
                        |row: usize, shift: &DimensionShift| shift.log_ratio[own[row]] + discrepancy_by(row, shift);
                    let shifts = self.trials[*left].dimension_shifts.iter();
                    shared += shifts.map(|shift| by(i, shift) * by(j, shift)).sum::<f64>();
                }
                if i == j {
                    shared += a.patterned_std.max(self.hyperparameters().least_measured_std).powi(2);
                }
                noise[i * n + j] = shared;
            }
        }
        noise
    }

    /// Covariance of all measurements for known coefficients of `member`, including the effect of errors of the trials'
    /// dimensions on the discrepancy.
    pub(crate) fn noise_of(&self, member: &Member) -> Vec<f64> {
        let rows: Vec<&Features> = self.rows().map(|(trial, _)| &self.trials[trial].features).collect();
        let by = |row: usize, shift: &DimensionShift| {
            member.at_trials.get(row).map_or(0.0, |own| own * shift.log_form(&member.form, rows[row]))
        };
        self.noise(member.scatter, &by)
    }

    /// Whitens the measurements by the covariance `noise`; `None` if the covariance has no inverse.
    fn whitened(&self, noise: &[f64]) -> Option<Whitened> {
        let mut excess: Vec<f64> = self.rows().map(|(_, at)| at.log_excess() - at.sensitivity.prior_mean()).collect();
        let n = excess.len();
        let factor = cholesky(noise, n).filter(|factor| is_regular(factor, n))?;
        solve_lower(&factor, n, &mut excess);
        // ln N(y; 0, noise), up to a constant
        let log_density = -0.5 * (dot(&excess, &excess) + log_determinant(&factor, n));
        Some(Whitened { factor, excess, log_density })
    }

    /// Fits the form of `member`, including the effect of errors of the trials' dimensions on the discrepancy, to first
    /// order about the discrepancy at each trial, which [`ROUNDS`] regressions find (effective variance method, Orear,
    /// Am. J. Phys. 50, 912, 1982). Also returns the log evidence. `None` if a covariance has no inverse.
    fn fit_as_made(&self, member: Member, as_designed: &Whitened) -> Option<(Member, f64)> {
        let (mut found, mut evidence) = self.fit(member, as_designed)?;
        let is_exact = self.trials.iter().all(|trial| trial.dimension_shifts.is_empty());
        for _ in 0..if is_exact { 0 } else { ROUNDS } {
            let whitened = self.whitened(&self.noise_of(&found))?;
            (found, evidence) = self.fit(found, &whitened)?;
        }
        Some((found, evidence))
    }

    /// Fits the form of `member` to the whitened data. Also returns the log evidence. `None` if the posterior precision
    /// matrix is singular.
    fn fit(&self, member: Member, whitened: &Whitened) -> Option<(Member, f64)> {
        let Whitened { factor, excess, log_density } = whitened;
        let (p, n) = (self.basis.count(), excess.len());
        // Columns of the whitened rows: S^-1 Phi, noise = S S^T
        let rows = self.basis_rows(&member);
        let columns: Vec<Vec<f64>> = (0..p)
            .map(|c| {
                let mut column: Vec<f64> = rows.iter().map(|row| row[c]).collect();
                solve_lower(factor, n, &mut column);
                column
            })
            .collect();
        // I + Phi^T noise^-1 Phi
        let mut precision = vec![0.0; p * p];
        for i in 0..p {
            for j in 0..=i {
                let entry = dot(&columns[i], &columns[j]) + if i == j { 1.0 } else { 0.0 };
                precision[i * p + j] = entry;
                precision[j * p + i] = entry;
            }
        }
        let lower = cholesky(&precision, p).filter(|lower| is_regular(lower, p))?;
        // mean = precision^-1 Phi^T noise^-1 y
        let mut mean: Vec<f64> = columns.iter().map(|column| dot(column, excess)).collect();
        solve_lower(&lower, p, &mut mean);
        // ln N(y; 0, noise + Phi Phi^T), up to a constant
        let evidence = 0.5 * (dot(&mean, &mean) - log_determinant(&lower, p)) + log_density;
        solve_upper(&lower, p, &mut mean);
        let mut inverse = vec![0.0; p * p];
        for c in 0..p {
            let mut column = vec![0.0; p];
            column[c] = 1.0;
            solve_lower(&lower, p, &mut column);
            (c..p).for_each(|row| inverse[row * p + c] = column[row]);
        }
        let of_globals = |row: &[f64]| self.basis.globals().map(|place| row[place] * mean[place]).iter().sum::<f64>();
        let first = self.basis.flat.len();
        let at_trials = rows.iter().map(|row| dot(&row[first..], &mean[first..]) - of_globals(row)).collect();
        Some((Member { mean, inverse, at_trials, ..member }, evidence))
    }
}

/// Measured discrepancies y, less their prior means, whitened by their noise S S^T.
struct Whitened {
    /// Lower factor S of the noise, row by row.
    factor: Vec<f64>,
    /// Whitened discrepancies S^-1 y.
    excess: Vec<f64>,
    /// Logarithm of the normal density N(y; 0, noise), up to a constant.
    log_density: f64,
}

/// Members of the mixture to be fitted: every form at every scale with every residual, for samples with the scatter
/// `scatter` of prior weight `of_scatter`. [`Form::None`] has one member for all scales and residuals.
fn members(hyper: &Hyperparameters, (scatter, of_scatter): (f64, f64)) -> Vec<Member> {
    let mut all = Vec::new();
    let once = vec![(1.0, 1.0)];
    for (form, of_form) in &hyper.forms {
        let (scales, residuals, at_reference) = match form {
            Form::None => (&once, &once, 1.0),
            _ => (&hyper.scales, &hyper.residuals, form.value(&hyper.reference)),
        };
        for (scale, of_scale) in scales {
            for (residual, of_residual) in residuals {
                let prior = of_form * of_scale * of_residual * of_scatter;
                all.push(Member {
                    form: *form,
                    scale: *scale,
                    residual: *residual,
                    scatter,
                    prior,
                    weight: prior,
                    at_reference,
                    mean: Vec::new(),
                    inverse: Vec::new(),
                    at_trials: Vec::new(),
                });
            }
        }
    }
    all.retain(|member| member.prior > 0.0);
    all
}

/// Whether two loads have equal pressure, speed and humidity.
pub(crate) fn is_same(a: &Load, b: &Load) -> bool {
    [(a.pressure_pa, b.pressure_pa), (a.speed_m_s, b.speed_m_s), (a.humidity, b.humidity)]
        .iter()
        .all(|(a, b)| units::is_same(*a, *b))
}
