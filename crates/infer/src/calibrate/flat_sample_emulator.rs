//! Emulator of steady friction of the flat sample for any coefficient and scale of the area law, from a few solves.

use slipgrid_model::material::{AreaLaw, LocalFriction};

use crate::calibrate::{FitError, Problem, flat_sample};

/// Nodes of the emulator: coefficients relative to the current ones.
const NODES: [f64; 3] = [0.8, 1.0, 1.25];
/// Number of nodes along the scale, on which the end effect depends slowly.
const SCALES: usize = 13;

/// Interpolates the end effect c in mu_i = mu_d f(P_i) c_i. c differs from 1 by some thousandths; it is interpolated
/// quadratically in mu_d and linearly in the logarithm of the scale. The other factors are exact.
pub struct Emulator<'a> {
    problem: &'a Problem,
    dynamic_means: Vec<f64>,
    /// Logarithms of the scales; a single dummy value if the law is given.
    log_scales: Vec<f64>,
    /// c by scale, measurement and node.
    ends: Vec<Vec<[f64; 3]>>,
}

impl<'a> Emulator<'a> {
    /// Solves the sample around the coefficients `dynamic_means`, one per measurement.
    pub fn new(problem: &'a Problem, dynamic_means: &[f64]) -> Result<Self, FitError> {
        let log_scales: Vec<f64> = problem.area_law_scale.as_ref().map_or(vec![0.0], |unknown| {
            let [from, to] = unknown.bounds_pa.map(f64::ln);
            (0..SCALES).map(|i| from + (to - from) * i as f64 / (SCALES - 1) as f64).collect()
        });
        let mut ends = Vec::new();
        for log_scale in &log_scales {
            let law = problem.law_at(log_scale.exp())?;
            let mut rows = vec![[0.0; 3]; dynamic_means.len()];
            for (node, factor) in NODES.into_iter().enumerate() {
                let pairs = dynamic_means
                    .iter()
                    .map(|mean| LocalFriction::new(mean * factor, mean * factor, problem.relative_std))
                    .collect::<Result<_, _>>()?;
                let solved = flat_sample::steady(&Problem { area_law: law.clone(), ..problem.clone() }, &pairs)?;
                for (i, mu) in solved.iter().enumerate() {
                    rows[i][node] = mu / (dynamic_means[i] * factor * factor_at(law.as_ref(), problem, i));
                }
            }
            ends.push(rows);
        }
        Ok(Self { problem, dynamic_means: dynamic_means.to_vec(), log_scales, ends })
    }

    /// Steady friction of measurement `i`.
    pub fn steady(&self, i: usize, dynamic_mean: f64, law: Option<&AreaLaw>, log_scale: f64) -> f64 {
        let end = |scale: usize| {
            let x = (dynamic_mean / self.dynamic_means[i]).clamp(NODES[0], NODES[2]);
            let c = &self.ends[scale][i];
            // Lagrange polynomial through the nodes
            (0..3)
                .map(|j| {
                    let others = (0..3).filter(|&k| k != j);
                    c[j] * others.map(|k| (x - NODES[k]) / (NODES[j] - NODES[k])).product::<f64>()
                })
                .sum::<f64>()
        };
        let last = self.log_scales.len() - 1;
        let ends = if last == 0 {
            end(0)
        } else {
            let place = (log_scale - self.log_scales[0]) / (self.log_scales[last] - self.log_scales[0]) * last as f64;
            let below = (place.max(0.0) as usize).min(last - 1);
            let share = (place - below as f64).clamp(0.0, 1.0);
            (1.0 - share) * end(below) + share * end(below + 1)
        };
        dynamic_mean * factor_at(law, self.problem, i) * ends
    }
}

fn factor_at(law: Option<&AreaLaw>, problem: &Problem, i: usize) -> f64 {
    law.map_or(1.0, |law| law.factor(problem.pressure_pa(&problem.measurements[i])))
}
