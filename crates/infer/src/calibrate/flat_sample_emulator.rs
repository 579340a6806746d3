//! Emulator of steady friction of the flat sample for any coefficient and scale of the area law, from a few solves.

use slipgrid_base::monitor::Monitor;
use slipgrid_base::monitor::cached;
use slipgrid_model::material::{AreaLaw, LocalFriction};

use crate::calibrate::{FitError, Problem, flat_sample};

/// Least and greatest node of a load, relative to the least and greatest coefficient at that load.
const BEYOND: [f64; 2] = [0.8, 1.25];
/// Number of nodes along the scale, on which the end effect depends slowly.
const SCALES: usize = 13;

/// Measurements at one load, which share three solves.
struct AtLoad {
    /// One of the measurements.
    first: usize,
    /// Coefficients at the nodes.
    nodes: [f64; 3],
}

/// Interpolates the end effect c in mu_i = mu_d f(P_i) c_i. c depends on the load and on mu_d, and differs from 1 by some
/// thousandths; it is interpolated quadratically in mu_d and linearly in the logarithm of the scale. The other factors
/// are exact.
pub struct Emulator<'a> {
    problem: &'a Problem,
    loads: Vec<AtLoad>,
    /// Load of each measurement.
    load_of: Vec<usize>,
    /// Logarithms of the scales; a single dummy value if the law is given.
    log_scales: Vec<f64>,
    /// c at the nodes, by scale and load.
    ends: Vec<Vec<[f64; 3]>>,
}

impl<'a> Emulator<'a> {
    /// Solves the sample around the coefficients `dynamic_means`, one per measurement, unless the monitor's cache knows it.
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

    /// Steady friction of measurement `i`.
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

/// c at every load of `problem`, which has one measurement for each of `loads`, with this scale of the law.
fn solve_ends(problem: &Problem, loads: &[AtLoad], log_scale: f64) -> Result<Vec<[f64; 3]>, FitError> {
    let solved = Problem { area_law: problem.law_at(log_scale.exp())?, ..problem.clone() };
    let law = solved.area_law.as_ref();
    let at_node = |node: usize| -> Result<Vec<f64>, FitError> {
        let pair = |load: &AtLoad| LocalFriction::new(load.nodes[node], load.nodes[node], problem.relative_std);
        let pairs = loads.iter().map(pair).collect::<Result<_, _>>()?;
        // A load is refused as the first measurement at it.
        let found = flat_sample::steady(&solved, &pairs).map_err(|error| {
            let load = error.measurement().and_then(|number| loads.get(number - 1));
            load.map_or(error.clone(), |load| error.with_place(load.first))
        })?;
        let end =
            |(place, (mu, load)): (usize, (&f64, &AtLoad))| mu / (load.nodes[node] * factor_at(law, &solved, place));
        Ok(found.iter().zip(loads).enumerate().map(end).collect())
    };
    let ends = [at_node(0)?, at_node(1)?, at_node(2)?];
    Ok((0..loads.len()).map(|place| [0, 1, 2].map(|node| ends[node][place])).collect())
}

/// Loads of `problem` with the nodes around the `dynamic_means` at each, and the load of each measurement.
fn loads(problem: &Problem, dynamic_means: &[f64]) -> (Vec<AtLoad>, Vec<usize>) {
    let pressure = |i: usize| problem.pressure_pa(&problem.measurements[i]);
    let mut loads: Vec<AtLoad> = Vec::new();
    let mut load_of = Vec::new();
    for i in 0..dynamic_means.len() {
        let known = loads.iter().position(|load| pressure(load.first) == pressure(i));
        load_of.push(known.unwrap_or_else(|| {
            let alike = (0..dynamic_means.len()).filter(|j| pressure(*j) == pressure(i)).map(|j| dynamic_means[j]);
            let [least, most] =
                alike.fold([f64::INFINITY, 0.0], |[least, most], mean| [mean.min(least), mean.max(most)]);
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
