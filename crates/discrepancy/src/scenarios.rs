//! Truths drawn from the mixture: what several samples would do in one and the same of them.

use slipgrid_statistics::Normals;
use slipgrid_statistics::cholesky::covariance_factor;

use crate::mixture::Member;
use crate::rows::Basis;
use crate::{Candidate, Discrepancy, Load, Wanted};
use slipgrid_statistics::cholesky::dot;

/// Truths drawn from the mixture, all alike likely.
#[derive(Clone, Debug)]
pub struct Scenarios {
    basis: Basis,
    members: Vec<Member>,
    /// Number of the member and its coefficients.
    draws: Vec<(usize, Vec<f64>)>,
    /// t of the one disc on which all samples are cut; none where each has its own.
    of_disc: Vec<f64>,
    seed: u64,
}

/// Seeds beyond that of the truths: of what all samples share, and of each sample beyond its number.
const OF_ALL: u64 = 1 << 32;
const OF_SAMPLES: u64 = 2 << 32;

impl Scenarios {
    /// `count` truths, seeded: of every form as many as its weight says.
    #[must_use]
    pub fn new(discrepancy: &Discrepancy, count: usize, seed: u64) -> Self {
        let (basis, members) = (discrepancy.basis().clone(), discrepancy.members().to_vec());
        let p = basis.count();
        let mut normals = Normals::new(seed);
        let mut draws = Vec::with_capacity(count);
        let (mut place, mut reached) = (0, members.first().map_or(1.0, |member| member.weight));
        for draw in 0..count {
            // Systematic sampling: places (k + 1/2) / n of the cumulated weights.
            while reached < (draw as f64 + 0.5) / count as f64 && place + 1 < members.len() {
                place += 1;
                reached += members[place].weight;
            }
            let member = &members[place];
            let z: Vec<f64> = (0..p).map(|_| normals.draw()).collect();
            // theta = mean + L^-T z
            let coefficient =
                |c: usize| member.mean[c] + (c..p).map(|row| member.inverse[row * p + c] * z[row]).sum::<f64>();
            draws.push((place, (0..p).map(coefficient).collect()));
        }
        Self { basis, members, draws, of_disc: Vec::new(), seed }
    }

    /// The same truths with one disc on which all samples are cut: they share its t, drawn by `seed`.
    #[must_use]
    pub fn on_one_disc(mut self, seed: u64) -> Self {
        let mut normals = Normals::new(seed);
        self.of_disc = self.draws.iter().map(|(member, _)| self.members[*member].scatter * normals.draw()).collect();
        self
    }

    /// In which of them a sample of `candidate` is on target: `wanted` at `loads`. Samples of another `number` are other samples: each has
    /// dimensions and a t of its own, and all have in common what else is not known exactly.
    #[must_use]
    pub fn on_target(&self, candidate: &Candidate<'_>, loads: &[Load], wanted: &Wanted, number: usize) -> Vec<bool> {
        let n = loads.len();
        let [lower, upper] = wanted.over(candidate.modelled);
        let of = |member: &Member| -> (f64, Vec<Vec<f64>>) {
            let form = member.value(&candidate.features);
            let at = loads.iter().zip(candidate.modulus_sensitivity);
            let row = |(load, g)| self.basis.row(form, member.residual, &candidate.features, load, g);
            (form, at.map(|(load, g)| row((load, *g))).collect())
        };
        let members: Vec<(f64, Vec<Vec<f64>>)> = self.members.iter().map(of).collect();
        let left: Vec<f64> = loads.iter().flat_map(|a| loads.iter().map(|b| self.basis.humidity_left(a, b))).collect();
        let or_none = |covariance: &[f64]| if covariance.is_empty() { vec![0.0; n * n] } else { covariance.to_vec() };
        let (all, own) = (or_none(candidate.covariance), or_none(candidate.of_dimensions));
        let common: Vec<f64> = all.iter().zip(&own).map(|(all, own)| all - own).collect();
        let [left, common, own] = [left, common, own].map(|covariance| covariance_factor(&covariance, n));
        let [mut of_all, mut of_own] =
            [OF_ALL, OF_SAMPLES + number as u64].map(|beyond| Normals::new(self.seed.wrapping_add(beyond)));
        let drawn = |factor: &[f64], normals: &mut Normals| -> Vec<f64> {
            let z: Vec<f64> = (0..n).map(|_| normals.draw()).collect();
            (0..n).map(|load| dot(&factor[load * n..][..=load], &z)).collect()
        };
        let mut is_on = |(draw, (member, theta)): (usize, &(usize, Vec<f64>))| {
            let (form, rows) = &members[*member];
            let [left, common, own] =
                [drawn(&left, &mut of_all), drawn(&common, &mut of_all), drawn(&own, &mut of_own)];
            let own_t = self.members[*member].scatter * of_own.draw();
            let t = self.of_disc.get(draw).copied().unwrap_or(own_t);
            // y = b theta + h eta + what all samples share + what this one has of its own + t
            (0..n).all(|load| {
                let value = dot(&rows[load], theta) + form * left[load] + common[load] + own[load] + t;
                (lower[load]..=upper[load]).contains(&value)
            })
        };
        self.draws.iter().enumerate().map(&mut is_on).collect()
    }
}
