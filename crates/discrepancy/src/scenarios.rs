//! Truths drawn from the mixture: what several samples would do in one and the same of them.

use slipgrid_statistics::Normals;

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
    /// t of the one disc on which all samples are cut; none where each has its own, which is left out.
    of_disc: Vec<f64>,
}

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
        Self { basis, members, draws, of_disc: Vec::new() }
    }

    /// The same truths with one disc on which all samples are cut: they share its t, drawn by `seed`.
    #[must_use]
    pub fn on_one_disc(mut self, seed: u64) -> Self {
        let mut normals = Normals::new(seed);
        self.of_disc = self.draws.iter().map(|(member, _)| self.members[*member].scatter * normals.draw()).collect();
        self
    }

    /// In which of them a sample of `candidate` is on target: `wanted` at `loads`.
    #[must_use]
    pub fn on_target(&self, candidate: &Candidate<'_>, loads: &[Load], wanted: &Wanted) -> Vec<bool> {
        let [lower, upper] = wanted.over(candidate.modelled);
        let of = |member: &Member| -> Vec<Vec<f64>> {
            let form = member.value(&candidate.features);
            let at = loads.iter().zip(candidate.modulus_sensitivity);
            at.map(|(load, g)| self.basis.row(form, member.residual, &candidate.features, load, *g)).collect()
        };
        let rows: Vec<Vec<Vec<f64>>> = self.members.iter().map(of).collect();
        let is_on = |(draw, (member, theta)): (usize, &(usize, Vec<f64>))| {
            let own = self.of_disc.get(draw).copied().unwrap_or(0.0);
            let values = rows[*member].iter().map(|row| dot(row, theta) + own);
            values.zip(lower.iter().zip(&upper)).all(|(value, (lower, upper))| (*lower..=*upper).contains(&value))
        };
        self.draws.iter().enumerate().map(is_on).collect()
    }
}
