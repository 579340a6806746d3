//! Methods of search on problems of our own: the best design against the evaluations it took, over 20 seeds.
//!
//! All minimize the cost of a design by the steady cell in the vertical plane, with the same exact penalty of broken
//! limits, on the same grid of designs that can be made, in shares of the logarithmic bounds. What `slipgrid_optimize`
//! does is compared with the covariance matrix adaptation of Hansen and Ostermeier (Evol. Comput. 9, 159, 2001), restarted
//! with twice the population (Auger and Hansen, 2005), with a low-discrepancy sample polished by Nelder and Mead's method,
//! and with argmin's particle swarm. A method ends by itself or at the most evaluations.

#![allow(clippy::print_stdout, clippy::expect_used, reason = "a bench reports and may fail")]

use std::sync::Mutex;

use argmin::core::{CostFunction, Error, Executor};
use argmin::solver::neldermead::NelderMead;
use argmin::solver::particleswarm::ParticleSwarm;
use nalgebra::{Matrix3, SymmetricEigen, Vector3};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
use rayon::prelude::*;
use slipgrid_monitor::Unwatched;
use slipgrid_optimize::{
    Bound, Constraints, Demand, DesignSpace, Goal, Limit, Quantity, Response, SearchOptions, Target, Wanted, search,
};
use slipgrid_pattern::{ManufacturingLimits, Pattern, Planform};
use slipgrid_springblock::{Extent, Fidelity, SteadyCell};
use slipgrid_tests::polymer_scene;

const PRESSURES_MPA: [f64; 4] = [0.65, 1.3, 1.95, 2.6];
const SEEDS: u64 = 20;
const MOST_EVALUATIONS: usize = 800;
/// Evaluations after which the best so far is reported.
const MARKS: [usize; 4] = [50, 100, 200, 800];
/// Cost of a relative excess of 1, and of a design that cannot be computed.
const PENALTY: f64 = 300.0;
const FAILED: f64 = 1e3;
/// A cost within this of the least known counts as found: a tolerance's twentieth, or a twentieth of a per cent.
const FOUND: f64 = 0.05;

/// A problem, with the model that answers it.
struct Case {
    name: &'static str,
    target: Target,
    constraints: Constraints,
    space: DesignSpace,
    model: SteadyCell,
}

/// The best cost after every evaluation of one search.
struct Trace<'a> {
    case: &'a Case,
    best: Mutex<Vec<f64>>,
}

impl Case {
    fn new(name: &'static str, target: Target, peak_mpa: f64, least_land: f64, burst_um: Option<f64>) -> Self {
        let limit =
            |name, bound: Bound, scale| Limit { name, unit: "", unit_si: 1.0, bound, scale, loosest: bound.limit() };
        let quantities = vec![
            limit("peak pressure", Bound::AtMost(peak_mpa * 1e6), peak_mpa * 1e6),
            limit("bearing area", Bound::AtLeast(least_land), 1.0),
        ];
        let limits = ManufacturingLimits { depth_per_burst_m: burst_um.map(|um| um * 1e-6), ..Default::default() };
        let space = DesignSpace::new(Planform::Groove, [40e-6, 400e-6], [40e-6, 1e-3], [2e-6, 50e-6]);
        let scene = polymer_scene(None, &PRESSURES_MPA, Fidelity::Steady, Extent::Cell).expect("a valid scene");
        Self {
            name,
            target,
            constraints: Constraints { limits, quantities },
            space: space.expect("valid bounds"),
            model: SteadyCell::new(&scene),
        }
    }

    fn respond(&self, design: &Pattern) -> Option<Response> {
        let answers = self.model.solve(design);
        let value = answers.iter().map(|answer| answer.ratio).collect::<Option<Vec<f64>>>()?;
        let peak_pa = answers.iter().map(|answer| answer.surface.peak_pressure_pa).fold(0.0, f64::max);
        Some(Response { value, limited: vec![peak_pa, 1.0 - design.areal_density()] })
    }

    fn cost(&self, design: &Pattern) -> (f64, Option<Response>) {
        let Some(response) = self.respond(design) else { return (FAILED, None) };
        let excess: f64 = self.constraints.violations(design, &response).iter().map(|broken| broken.excess()).sum();
        (self.target.misfit(&response.value).cost + PENALTY * excess, Some(response))
    }

    /// The design that can be made nearest to the shares `t`.
    fn design(&self, t: [f64; 3]) -> Pattern {
        let bounds = [self.space.width_m(), self.space.spacing_m(), self.space.depth_m()];
        let length = |axis: usize, step_m: f64| {
            let [lower_m, upper_m] = bounds[axis];
            let length_m = lower_m * (upper_m / lower_m).powf(t[axis].clamp(0.0, 1.0));
            let (first, last) = ((lower_m / step_m - 1e-6).ceil(), (upper_m / step_m + 1e-6).floor());
            (length_m / step_m).round().clamp(first, last) * step_m
        };
        let depth_step_m = self.constraints.limits.depth_per_burst_m.unwrap_or(1e-8);
        Pattern::new(Planform::Groove, length(0, 1e-7), length(1, 1e-7), length(2, depth_step_m)).expect("lengths")
    }
}

impl<'a> Trace<'a> {
    fn new(case: &'a Case) -> Self {
        Self { case, best: Mutex::new(Vec::new()) }
    }

    fn note(&self, cost: f64) {
        let mut best = self.best.lock().expect("no thread panics");
        let least = best.last().copied().unwrap_or(f64::INFINITY).min(cost);
        best.push(least);
    }

    fn len(&self) -> usize {
        self.best.lock().expect("no thread panics").len()
    }

    /// Cost at shares, counted; `None` once the evaluations are spent.
    fn at(&self, t: [f64; 3]) -> Option<f64> {
        if self.len() >= MOST_EVALUATIONS {
            return None;
        }
        let outside: f64 = t.iter().map(|t| (t - t.clamp(0.0, 1.0)).powi(2)).sum();
        let (cost, _) = self.case.cost(&self.case.design(t));
        self.note(cost);
        // Beyond the bounds as on them, and worse.
        Some(cost + 100.0 * outside)
    }

    fn close(self) -> Vec<f64> {
        self.best.into_inner().expect("no thread panics")
    }
}

/// Uniform in [0, 1).
fn uniform(generator: &mut ChaCha8Rng) -> f64 {
    (generator.next_u64() >> 11) as f64 * 2.0_f64.powi(-53)
}

/// A standard Gaussian deviate (Box and Muller).
fn gaussian(generator: &mut ChaCha8Rng) -> f64 {
    let (u, v) = (1.0 - uniform(generator), uniform(generator));
    (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

fn ours(case: &Case, seed: u64) -> Vec<f64> {
    let trace = Trace::new(case);
    let model = |design: &Pattern| {
        let (cost, response) = case.cost(design);
        trace.note(cost);
        response.ok_or(slipgrid_optimize::ModelFailure::Trial { reason: "not converged".to_owned() })
    };
    let options = SearchOptions { seed, max_evaluations: MOST_EVALUATIONS };
    // One thread: an evaluation is counted where it is made.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    pool.install(|| search(&case.target, &case.space, &case.constraints, &options, &model, &Unwatched))
        .expect("a search");
    trace.close()
}

/// Covariance matrix adaptation with the default constants of Hansen's tutorial (arXiv:1604.00772), restarted from a
/// uniform point with twice the population when it has converged.
fn covariance_adaptation(case: &Case, seed: u64) -> Vec<f64> {
    const N: f64 = 3.0;
    let trace = Trace::new(case);
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    // 4 + floor(3 ln 3)
    let mut offspring = 7;
    'restarts: loop {
        let parents = offspring / 2;
        let raw: Vec<f64> = (1..=parents).map(|i| (offspring as f64 / 2.0 + 0.5).ln() - (i as f64).ln()).collect();
        let total: f64 = raw.iter().sum();
        let weights: Vec<f64> = raw.iter().map(|weight| weight / total).collect();
        let mu_eff = 1.0 / weights.iter().map(|weight| weight * weight).sum::<f64>();
        let c_sigma = (mu_eff + 2.0) / (N + mu_eff + 5.0);
        let d_sigma = 1.0 + c_sigma + 2.0 * (((mu_eff - 1.0) / (N + 1.0)).sqrt() - 1.0).max(0.0);
        let c_c = (4.0 + mu_eff / N) / (N + 4.0 + 2.0 * mu_eff / N);
        let c_1 = 2.0 / ((N + 1.3).powi(2) + mu_eff);
        let c_mu = (1.0 - c_1).min(2.0 * (mu_eff - 2.0 + 1.0 / mu_eff) / ((N + 2.0).powi(2) + mu_eff));
        let chi = N.sqrt() * (1.0 - 1.0 / (4.0 * N) + 1.0 / (21.0 * N * N));

        let mut mean: Vector3<f64> = Vector3::from_fn(|_, _| uniform(&mut generator));
        let (mut sigma, mut covariance) = (0.3, Matrix3::<f64>::identity());
        let (mut path, mut path_sigma) = (Vector3::<f64>::zeros(), Vector3::<f64>::zeros());
        for generation in 1.. {
            let eigen = SymmetricEigen::new(covariance);
            let scale = eigen.eigenvalues.map(|value| value.max(1e-20).sqrt());
            let root = eigen.eigenvectors * Matrix3::from_diagonal(&scale);
            let inverse_root =
                eigen.eigenvectors * Matrix3::from_diagonal(&scale.map(f64::recip)) * eigen.eigenvectors.transpose();
            let mut population = Vec::new();
            for _ in 0..offspring {
                let step: Vector3<f64> = root * Vector3::from_fn(|_, _| gaussian(&mut generator));
                let point = mean + sigma * step;
                let Some(cost) = trace.at([point[0], point[1], point[2]]) else { break 'restarts };
                population.push((cost, step));
            }
            population.sort_by(|left, right| left.0.total_cmp(&right.0));
            let step = weights.iter().zip(&population).fold(Vector3::zeros(), |sum, (w, (_, y))| sum + *w * y);
            mean += sigma * step;
            path_sigma =
                (1.0 - c_sigma) * path_sigma + (c_sigma * (2.0 - c_sigma) * mu_eff).sqrt() * inverse_root * step;
            let fade = 1.0 - (1.0 - c_sigma).powi(2 * generation);
            let stalled = path_sigma.norm() / fade.sqrt() > (1.4 + 2.0 / (N + 1.0)) * chi;
            let h = if stalled { 0.0 } else { 1.0 };
            path = (1.0 - c_c) * path + h * (c_c * (2.0 - c_c) * mu_eff).sqrt() * step;
            let rank_one = path * path.transpose() + (1.0 - h) * c_c * (2.0 - c_c) * covariance;
            let rank_mu =
                weights.iter().zip(&population).fold(Matrix3::zeros(), |sum, (w, (_, y))| sum + *w * y * y.transpose());
            covariance = (1.0 - c_1 - c_mu) * covariance + c_1 * rank_one + c_mu * rank_mu;
            sigma *= ((c_sigma / d_sigma) * (path_sigma.norm() / chi - 1.0)).exp().min(2.0);
            let spread = population.last().map_or(0.0, |worst| worst.0 - population[0].0);
            if sigma * scale.max() < 1e-4 || spread < 1e-4 || sigma > 10.0 {
                break;
            }
        }
        offspring *= 2;
    }
    trace.close()
}

/// What argmin sees.
struct Counted<'a>(&'a Trace<'a>);

impl CostFunction for Counted<'_> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, t: &Self::Param) -> Result<f64, Error> {
        // An error while a solver begins would be a panic: what is spent costs as a failure instead.
        Ok(self.0.at([t[0], t[1], t[2]]).unwrap_or(FAILED))
    }
}

/// 32 points of the additive recurrence, and simplexes from the best of them until the evaluations are spent.
fn sample_and_simplex(case: &Case, seed: u64) -> Vec<f64> {
    let trace = Trace::new(case);
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    let shift: [f64; 3] = std::array::from_fn(|_| uniform(&mut generator));
    let golden = (0..64).fold(1.5_f64, |x, _| (1.0 + x).powf(0.25));
    let point = |n: i32| -> [f64; 3] {
        std::array::from_fn(|axis| (shift[axis] + f64::from(n) * golden.powi(-(axis as i32) - 1)).fract())
    };
    let mut sample: Vec<(f64, [f64; 3])> = (0..32).filter_map(|n| Some((trace.at(point(n))?, point(n)))).collect();
    sample.sort_by(|left, right| left.0.total_cmp(&right.0));
    for (_, start) in sample {
        let mut simplex = vec![start.to_vec()];
        for axis in 0..3 {
            let mut vertex = start.to_vec();
            vertex[axis] += if vertex[axis] < 0.5 { 0.12 } else { -0.12 };
            simplex.push(vertex);
        }
        let solver = NelderMead::new(simplex).with_sd_tolerance(2e-3).expect("a positive tolerance");
        let ended = Executor::new(Counted(&trace), solver).configure(|state| state.max_iters(200)).ctrlc(false).run();
        if ended.is_err() || trace.len() >= MOST_EVALUATIONS {
            break;
        }
    }
    trace.close()
}

/// Twenty particles by argmin.
fn particle_swarm(case: &Case, seed: u64) -> Vec<f64> {
    let trace = Trace::new(case);
    let solver =
        ParticleSwarm::new((vec![0.0; 3], vec![1.0; 3]), 20).with_rng_generator(ChaCha8Rng::seed_from_u64(seed));
    let most = MOST_EVALUATIONS as u64 / 20 - 1;
    let ended = Executor::new(Counted(&trace), solver).configure(|state| state.max_iters(most)).ctrlc(false).run();
    let ended = ended.expect("costs are numbers");
    assert!(ended.state.get_best_cost().is_finite());
    trace.close()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn target(wanted: [Wanted; 4], goal: Option<Goal>) -> Target {
    let demand = |(pressure_mpa, wanted)| Demand { pressure_pa: pressure_mpa * 1e6, wanted, weight: 1.0 };
    let demands = PRESSURES_MPA.into_iter().zip(wanted).map(demand).collect();
    Target::of(Quantity::Ratio, demands, goal).expect("a valid target")
}

fn main() {
    let near = |values: [f64; 4]| values.map(|value| Wanted::Near { value, tolerance: 0.01 });
    let lower = [0.97, 0.92, 0.87, 0.83];
    let band = Wanted::Between { lowest: 0.7, highest: 0.97 };
    let cases = [
        Case::new("values, all free", target(near(lower), None), 1e3, 0.0, None),
        Case::new("values, bursts, peak 8 MPa", target(near(lower), None), 8.0, 0.0, Some(2.6)),
        Case::new("level 0.7, out of reach", target(near([0.7; 4]), None), 10.0, 0.5, Some(2.6)),
        Case::new(
            "lowest, land 60 %, peak 8 MPa",
            target([Wanted::Anything; 4], Some(Goal::Lowest)),
            8.0,
            0.6,
            Some(2.6),
        ),
        Case::new("even in a band, peak 8 MPa", target([band; 4], Some(Goal::Even)), 8.0, 0.0, Some(2.6)),
    ];
    type Method = fn(&Case, u64) -> Vec<f64>;
    let methods: [(&str, Method); 4] = [
        ("slipgrid", ours),
        ("CMA-ES", covariance_adaptation),
        ("sample + simplexes", sample_and_simplex),
        ("particle swarm", particle_swarm),
    ];
    println!(
        "Median cost above the least known after so many evaluations, {SEEDS} seeds; then evaluations (median, most) to come"
    );
    println!("within {FOUND} of it, seeds that did, and evaluations used (median).\n");
    for case in &cases {
        let traces: Vec<Vec<Vec<f64>>> = methods
            .iter()
            .map(|(_, method)| (0..SEEDS).into_par_iter().map(|seed| method(case, seed)).collect())
            .collect();
        let ends = traces.iter().flatten().filter_map(|trace| trace.last().copied());
        let least = ends.fold(f64::INFINITY, f64::min);
        println!("{}: least known {least:.3}", case.name);
        println!(
            "  {:<20} {:>8} {:>8} {:>8} {:>8}   {:>6} {:>6} {:>6} {:>6}",
            "", "50", "100", "200", "800", "median", "most", "seeds", "used"
        );
        for ((name, _), traces) in methods.iter().zip(&traces) {
            let at =
                |mark: usize| median(traces.iter().map(|trace| trace[mark.min(trace.len()) - 1] - least).collect());
            let marks: Vec<String> = MARKS.iter().map(|&mark| format!("{:>8.3}", at(mark))).collect();
            let first = |trace: &Vec<f64>| trace.iter().position(|cost| *cost <= least + FOUND).map(|place| place + 1);
            let found: Vec<f64> = traces.iter().filter_map(first).map(|count| count as f64).collect();
            let reached = if found.is_empty() {
                format!("{:>6} {:>6} {:>6}", "-", "-", 0)
            } else {
                let most = found.iter().copied().fold(0.0, f64::max);
                format!("{:>6} {most:>6} {:>6}", median(found.clone()), found.len())
            };
            let used = median(traces.iter().map(|trace| trace.len() as f64).collect());
            println!("  {name:<20} {}   {reached} {used:>6}", marks.join(" "));
        }
        println!();
    }
}
