//! Emulator of steady friction of the flat sample for any local coefficient and scale of the area law, from a few
//! solves.

use slipgrid_base::monitor::{Monitor, cached};
use slipgrid_base::statistics::extremes;
use slipgrid_model::material::{AreaLaw, LocalFriction};

use crate::calibrate::{FitError, Problem, flat_sample};

/// Lowest node along mu_d over the lowest coefficient at the load, and highest node over the highest coefficient.
const BEYOND: [f64; 2] = [0.8, 1.25];
/// Number of nodes along the logarithm of the area law's scale, with which the end effect changes slowly.
const SCALES: usize = 13;

/// Measurements at one load, which share the solutions at three nodes.
struct AtLoad {
    /// Index of the first measurement at this load.
    first: usize,
    /// Local dynamic coefficients mu_d at the nodes, increasing.
    nodes: [f64; 3],
}

/// Interpolates the end effect c in the steady friction mu_i = mu_d f(P_i) c_i of the flat sample, with the local
/// coefficient mu_d and the area factor f. c depends on the load and on mu_d, and differs from 1 by some thousandths;
/// it is interpolated quadratically in mu_d and linearly in the logarithm of the area law's scale. mu_d and f are
/// exact.
pub struct Emulator<'a> {
    problem: &'a Problem,
    loads: Vec<AtLoad>,
    /// Index in `loads` of the load of each measurement.
    load_of: Vec<usize>,
    /// Logarithms of the area law's scales in pascals at the nodes; a single dummy value if the law is given.
    log_scales: Vec<f64>,
    /// End effect c at the three nodes along mu_d; index `[scale][load][node]`.
    ends: Vec<Vec<[f64; 3]>>,
}

impl<'a> Emulator<'a> {
    /// Solves the flat sample at nodes around the coefficients `dynamic_means`, one per measurement, unless the
    /// monitor's cache has the solutions.
    pub fn new(problem: &'a Problem, dynamic_means: &[f64], monitor: &dyn Monitor) -> Result<Self, FitError> {
        let log_scales: Vec<f64> = problem.area_law_scale.as_ref().map_or(vec![0.0], |unknown| {
            let [from, to] = unknown.bounds_pa.map(f64::ln);
            (0..SCALES).map(|i| from + (to - from) * i as f64 / (SCALES - 1) as f64).collect()
        });
        let (loads, load_of) = loads(problem, dynamic_means);
        let measurements = loads.iter().map(|load| problem.measurements[load.first]).collect();
        let alone = Problem { measurements, ..problem.clone() };
        let nodes: Vec<[f64; 3]> = loads.iter().map(|load| load.nodes).collect();
        let content = (&alone, &nodes, &log_scales);
        let solve = || log_scales.iter().map(|log_scale| solve_ends(&alone, &loads, *log_scale)).collect();
        let ends = cached(monitor, ("ends", &content), 0.0, solve)?;
        Ok(Self { problem, loads, load_of, log_scales, ends })
    }

    /// Steady friction of the flat sample at measurement `i` for the local coefficient `dynamic_mean` and the area
    /// `law`; `log_scale` is the logarithm of its scale in pascals.
    pub fn steady(&self, i: usize, dynamic_mean: f64, law: Option<&AreaLaw>, log_scale: f64) -> f64 {
        let load = self.load_of[i];
        let nodes = &self.loads[load].nodes;
        let x = dynamic_mean.clamp(nodes[0], nodes[2]);
        let end = |scale: usize| {
            let c = &self.ends[scale][load];
            // Lagrange polynomial through the nodes
            (0..3)
                .map(|j| {
                    let others = (0..3).filter(|&k| k != j);
                    c[j] * others.map(|k| (x - nodes[k]) / (nodes[j] - nodes[k])).product::<f64>()
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

/// End effect c (steady friction over mu_d f) at the three nodes of every load; `problem` has one measurement for each
/// of `loads`, and `log_scale` is the logarithm of the area law's scale.
fn solve_ends(problem: &Problem, loads: &[AtLoad], log_scale: f64) -> Result<Vec<[f64; 3]>, FitError> {
    let solved = Problem { area_law: problem.law_at(log_scale.exp())?, ..problem.clone() };
    let law = solved.area_law.as_ref();
    // All nodes of all loads at once: their equations are the same.
    let nodes: Vec<(&AtLoad, f64)> = loads.iter().flat_map(|load| load.nodes.map(|node| (load, node))).collect();
    let pair = |(_, node): &(&AtLoad, f64)| LocalFriction::new(*node, *node, problem.relative_std);
    let pairs = nodes.iter().map(pair).collect::<Result<_, _>>()?;
    let measurements = solved.measurements.iter().flat_map(|measured| [*measured; 3]).collect();
    let solved = Problem { measurements, ..solved.clone() };
    let all: Vec<usize> = (0..nodes.len()).collect();
    // An error names the first measurement at the load.
    let found = flat_sample::steady(&solved, &pairs, &all).map_err(|error| match error {
        FitError::NoSliding { number, pressure_pa, status } => {
            FitError::NoSliding { number: nodes[number - 1].0.first + 1, pressure_pa, status }
        }
        error => error,
    })?;
    let end = |(place, (mu, (_, node))): (usize, (&f64, &(&AtLoad, f64)))| mu / (node * factor_at(law, &solved, place));
    let ends: Vec<f64> = found.iter().zip(&nodes).enumerate().map(end).collect();
    Ok(ends.as_chunks().0.to_vec())
}

/// Loads of `problem`, each with nodes around its `dynamic_means`, and the index of the load of each measurement.
fn loads(problem: &Problem, dynamic_means: &[f64]) -> (Vec<AtLoad>, Vec<usize>) {
    let pressure = |i: usize| problem.pressure_pa(&problem.measurements[i]);
    let mut loads: Vec<AtLoad> = Vec::new();
    let mut load_of = Vec::new();
    for i in 0..dynamic_means.len() {
        let known = loads.iter().position(|load| pressure(load.first) == pressure(i));
        load_of.push(known.unwrap_or_else(|| {
            let alike = (0..dynamic_means.len()).filter(|j| pressure(*j) == pressure(i)).map(|j| dynamic_means[j]);
            let [least, most] = extremes(alike);
            let nodes = [BEYOND[0] * least, (least * most).sqrt(), BEYOND[1] * most];
            loads.push(AtLoad { first: i, nodes });
            loads.len() - 1
        }));
    }
    (loads, load_of)
}

fn factor_at(law: Option<&AreaLaw>, problem: &Problem, i: usize) -> f64 {
    law.map_or(1.0, |law| law.factor(problem.pressure_pa(&problem.measurements[i])))
}
