//! Scenarios: truths drawn from the mixture, in which several samples are evaluated jointly.

use slipgrid_base::statistics::Normals;
use slipgrid_base::statistics::cholesky::covariance_factor;

use crate::discrepancy::mixture::Member;
use crate::discrepancy::residual::{KernelBasis, Place};
use crate::discrepancy::rows::Basis;
use crate::discrepancy::{Candidate, Discrepancy, Load, Sensitivity, Wanted};
use slipgrid_base::statistics::cholesky::dot;

/// Equally weighted random draws (truths) from the posterior of the model discrepancy; each fixes the discrepancy of
/// every texture.
#[derive(Clone, Debug)]
pub struct Scenarios {
    basis: Basis,
    members: Vec<Member>,
    /// Shares of the flat sample's errors at each load; empty for ratios.
    flat_shares: Vec<Vec<f64>>,
    draws: Vec<Truth>,
    /// Deviation of the log ratio by the scatter of the one disc that all samples share, one per truth; empty if each
    /// sample has a separate disc.
    of_disc: Vec<f64>,
    seed: u64,
}

/// One truth: a random draw from the mixture.
#[derive(Clone, Debug)]
struct Truth {
    /// Index of the mixture's member.
    member: usize,
    coefficients: Vec<f64>,
    residual: ResidualDraw,
}

/// Draw of the rest of the residual, which the trials do not explain: a draw of the prior minus its regression on its
/// values at the trials (Matheron's rule). The prior is a sum of waves of random frequencies (Rahimi and Recht 2007),
/// drawn anew for every truth.
#[derive(Clone, Debug)]
struct ResidualDraw {
    /// Frequency along each coordinate of a place, and phase in radians, of each wave.
    waves: Vec<([f64; 4], f64)>,
    /// L^-1 times the prior draw at the places of the basis, with the factor L of their correlation.
    whitened: Vec<f64>,
}

/// Number of waves per draw of the residual: their sum is nearly normal, and the covariance over all draws is exact.
const WAVES: usize = 16;
/// Offset of the seed for errors that all samples share.
const OF_ALL: u64 = 1 << 32;
/// Offset of the seed for errors of one sample, to which its number is added.
const OF_SAMPLES: u64 = 2 << 32;
/// Offset of the seed for residuals.
const OF_RESIDUALS: u64 = 3 << 32;
/// Offset of the seed for the local law.
const OF_LOCAL_LAW: u64 = 4 << 32;
/// Offset of the seed for the flat sample's errors.
const OF_FLAT: u64 = 5 << 32;

impl ResidualDraw {
    fn new(basis: &KernelBasis, normals: &mut Normals) -> Self {
        let wave = |_| {
            let frequency = std::array::from_fn(|_| normals.draw());
            // Uniform phase, from the argument of two normal deviates.
            (frequency, libm::atan2(normals.draw(), normals.draw()))
        };
        let mut found = Self { waves: (0..WAVES).map(wave).collect(), whitened: Vec::new() };
        let mut whitened: Vec<f64> = basis.places.iter().map(|place| found.prior(place)).collect();
        basis.whiten(&mut whitened);
        found.whitened = whitened;
        found
    }

    /// Value of the prior draw at the place x: sqrt(2 / J) sum_j cos(omega_j x + phi_j) over J waves.
    fn prior(&self, place: &Place) -> f64 {
        let wave = |(omega, phase): &([f64; 4], f64)| libm::cos(dot(omega, &place.0) + phase);
        (2.0 / WAVES as f64).sqrt() * self.waves.iter().map(wave).sum::<f64>()
    }
}

impl Scenarios {
    /// Draws `count` truths with a seed; members of the mixture occur in proportion to their weights.
    pub fn new(discrepancy: &Discrepancy, count: usize, seed: u64) -> Self {
        let (basis, members) = (discrepancy.basis().clone(), discrepancy.members().to_vec());
        let p = basis.count();
        let mut normals = Normals::new(seed);
        let [mut of_residual, mut of_law, mut of_flat] =
            [OF_RESIDUALS, OF_LOCAL_LAW, OF_FLAT].map(|beyond| Normals::new(seed.wrapping_add(beyond)));
        let ([_, law], flat) = (basis.globals(), basis.flat.len());
        let mut draws = Vec::with_capacity(count);
        let (mut place, mut reached) = (0, members.first().map_or(1.0, |member| member.weight));
        for draw in 0..count {
            // Systematic sampling: places (k + 1/2) / n of the cumulated weights.
            while reached < (draw as f64 + 0.5) / count as f64 && place + 1 < members.len() {
                place += 1;
                reached += members[place].weight;
            }
            let member = &members[place];
            let deviate = |c: usize| match c {
                c if c < flat => of_flat.draw(),
                c if c == law => of_law.draw(),
                _ => normals.draw(),
            };
            let z: Vec<f64> = (0..p).map(deviate).collect();
            // theta = mean + L^-T z
            let coefficient =
                |c: usize| member.mean[c] + (c..p).map(|row| member.inverse[row * p + c] * z[row]).sum::<f64>();
            draws.push(Truth {
                member: place,
                coefficients: (0..p).map(coefficient).collect(),
                residual: ResidualDraw::new(&basis.residual_basis, &mut of_residual),
            });
        }
        Self { basis, members, flat_shares: Vec::new(), draws, of_disc: Vec::new(), seed }
    }

    /// Evaluates samples for friction in place of ratios, with `flat_shares` of [`Discrepancy::flat_shares`], one list per
    /// load; without shares for ratios.
    #[must_use]
    pub fn of_friction(self, flat_shares: &[Vec<f64>]) -> Self {
        Self { flat_shares: flat_shares.to_vec(), ..self }
    }

    /// Puts all samples on one disc: they share one deviation due to scatter, drawn with `seed`.
    #[must_use]
    pub fn on_one_disc(mut self, seed: u64) -> Self {
        let mut normals = Normals::new(seed);
        let disc = |truth: &Truth| self.members[truth.member].scatter * normals.draw();
        self.of_disc = self.draws.iter().map(disc).collect();
        self
    }

    /// Returns for each truth whether a sample of `candidate` is on target `wanted` at `loads`. Samples with different
    /// `number` are independent in dimensions and scatter, and share all other unknowns.
    pub fn on_target(&self, candidate: &Candidate<'_>, loads: &[Load], wanted: &Wanted, number: usize) -> Vec<bool> {
        let [lower, upper] = wanted.over(candidate.modelled);
        let is_on = |value: &Vec<f64>| (0..loads.len()).all(|load| (lower[load]..=upper[load]).contains(&value[load]));
        self.log_excesses(candidate, loads, number).iter().map(is_on).collect()
    }

    /// Logarithm of the true over the modelled ratio of a sample of `candidate`: one list per truth, with one value per
    /// load. `number` distinguishes samples as in [`Scenarios::on_target`].
    pub fn log_excesses(&self, candidate: &Candidate<'_>, loads: &[Load], number: usize) -> Vec<Vec<f64>> {
        let n = loads.len();
        let places: Vec<Place> = loads.iter().map(|load| self.basis.place(&candidate.features, load)).collect();
        let explained: Vec<Vec<f64>> = places.iter().map(|place| self.basis.residual(place)).collect();
        let amplitude = self.basis.hyper.amplitude_std;
        // c beyond the trials: f(x) - w(x)^T L^-1 f(trials)
        let residual_left = |draw: &ResidualDraw, load: usize| {
            amplitude * draw.prior(&places[load]) - dot(&explained[load], &draw.whitened)
        };
        let first = self.basis.flat.len();
        let of = |member: &Member| {
            let form = member.value(&candidate.features);
            let at = loads.iter().zip(candidate.sensitivity).enumerate();
            let row = |(place, (load, own)): (usize, (&Load, &Sensitivity))| {
                let flat = self.flat_shares.get(place).cloned().unwrap_or_else(|| vec![0.0; first]);
                self.basis.row(flat, [form, member.residual], &candidate.features, load, *own)
            };
            let shifts = candidate.dimension_shifts.iter();
            let log_forms: Vec<f64> = shifts.map(|shift| shift.log_form(&member.form, &candidate.features)).collect();
            (form, at.map(row).collect::<Vec<_>>(), log_forms)
        };
        let members: Vec<(f64, Vec<Vec<f64>>, Vec<f64>)> = self.members.iter().map(of).collect();
        let left: Vec<f64> = loads.iter().flat_map(|a| loads.iter().map(|b| self.basis.humidity_left(a, b))).collect();
        let common = candidate.covariance;
        let common = if common.is_empty() { vec![0.0; n * n] } else { common.to_vec() };
        let [left, common] = [left, common].map(|covariance| covariance_factor(&covariance, n));
        let [mut of_all, mut of_own] =
            [OF_ALL, OF_SAMPLES + number as u64].map(|beyond| Normals::new(self.seed.wrapping_add(beyond)));
        let drawn = |factor: &[f64], normals: &mut Normals| -> Vec<f64> {
            let z: Vec<f64> = (0..n).map(|_| normals.draw()).collect();
            (0..n).map(|load| dot(&factor[load * n..][..=load], &z)).collect()
        };
        let globals = self.basis.globals();
        let prior_mean: Vec<f64> = candidate.sensitivity.iter().map(Sensitivity::prior_mean).collect();
        let mut log_excess = |(draw, truth): (usize, &Truth)| {
            let (form, rows, log_forms) = &members[truth.member];
            let member = &self.members[truth.member];
            let [left, common] = [&left, &common].map(|factor| drawn(factor, &mut of_all));
            let deviates: Vec<f64> = candidate.dimension_shifts.iter().map(|_| of_own.draw()).collect();
            // ln h as made - ln h as designed
            let log_form = dot(log_forms, &deviates);
            let own_t = member.scatter * of_own.draw();
            let t = self.of_disc.get(draw).copied().unwrap_or(own_t);
            let at = |load: usize| {
                let of_globals: f64 = globals.map(|place| rows[load][place] * truth.coefficients[place]).iter().sum();
                let rest = form * (left[load] + member.residual * residual_left(&truth.residual, load));
                let of_flat = dot(&rows[load][..first], &truth.coefficients[..first]);
                let of_form = dot(&rows[load][first..], &truth.coefficients[first..]) - of_globals + rest;
                let shifts = candidate.dimension_shifts.iter().zip(&deviates);
                let of_dimensions: f64 = shifts.map(|(shift, z)| shift.log_ratio[load] * z).sum();
                // y = D h' / h + eps g + lambda d + flat friction + shared errors + d ln R + t
                let of_globals = of_globals + prior_mean[load];
                of_form * (1.0 + log_form) + of_globals + of_flat + common[load] + of_dimensions + t
            };
            (0..n).map(at).collect()
        };
        self.draws.iter().enumerate().map(&mut log_excess).collect()
    }
}
