//! Reference learner, which knows how laboratories are generated: the distributions of mechanisms, sizes, scales,
//! moduli and scatters in [`super::truth`], but not the values of the laboratory at hand. It is the exact Bayesian
//! learner of the benchmark, so that no learner without knowledge of the laboratory's truth can predict better.
//!
//! Narrow Gaussians cover the distributions of the mechanism's size and of the modulus. For each pair of Gaussians, a
//! linear regression gives the posterior of the coefficients and the evidence. Draws from this mixture are reweighted
//! by the exact model, which removes the errors of the Gaussians and of the linearization.

use slipgrid_base::statistics::Normals;
use slipgrid_base::statistics::cholesky::{cholesky, dot, solve_lower, solve_upper};
use slipgrid_infer::discrepancy::Trial;

use super::draws::{Draw, Draws};
use super::physics::{LOADS, Physics, Solved};
use super::truth::{
    DIMENSIONS_STD, FLAT_SHARE, MAX_LOG_MODULUS, MODULUS_STD, Mechanism, SAMPLE_STD, SLOPE_SHARE, amplitude,
};

/// Number of Gaussians for the size of a mechanism, and for the modulus.
const SIZES: usize = 24;
const MODULI: usize = 16;
/// Standard deviation of a Gaussian over the distance of two; their sum is then constant to 0.2 %.
const OVERLAP: f64 = 0.6;
/// Number of regression coefficients: size, its two changes with pressure, modulus, and the flat sample's errors.
const N: usize = 4 + LOADS;

type Vector = [f64; N];
type Matrix = [[f64; N]; N];

/// Gaussian of a mixture, with its weight.
#[derive(Clone, Copy, Debug)]
struct Node {
    at: f64,
    std: f64,
    share: f64,
}

impl Node {
    fn density(&self, x: f64) -> f64 {
        let z = (x - self.at) / self.std;
        self.share * (-0.5 * z * z).exp() / (self.std * std::f64::consts::TAU.sqrt())
    }
}

/// Mechanism with a given scale.
#[derive(Clone, Debug)]
pub struct Kind {
    /// Mechanism.
    pub mechanism: Mechanism,
    /// Prior probability of the mechanism with this scale.
    share: f64,
    /// Value of the mechanism at every texture, relative to the reference texture.
    values: Vec<f64>,
    sizes: Vec<Node>,
    /// Standard deviations of the two changes with pressure, for each Gaussian of the size.
    slopes: Vec<[f64; 2]>,
}

/// Generative model of laboratories.
#[derive(Clone, Debug)]
pub struct Generator {
    physics: Vec<Physics>,
    kinds: Vec<Kind>,
    moduli: Vec<Node>,
}

/// Measurement of a cut sample.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// Index of the texture.
    pub place: usize,
    /// Logarithms of the measured ratios.
    pub log: [f64; LOADS],
    /// Whether the sample is known to be off target, because the laboratory continued after it.
    pub is_missed: bool,
}

impl Seen {
    /// Takes the measurement of the texture at `place` from `trial`.
    pub fn new(trial: &Trial, place: usize, is_missed: bool) -> Self {
        Self { place, log: logs(trial), is_missed }
    }
}

/// Logarithms of the measured ratios.
pub fn logs(trial: &Trial) -> [f64; LOADS] {
    std::array::from_fn(|load| trial.measured[load].measured.ln())
}

/// Posterior of the regression coefficients for one kind, size and modulus.
struct Component {
    kind: usize,
    size: Node,
    modulus: Node,
    /// Logarithm of prior times evidence.
    weight: f64,
    /// Prior standard deviations of the coefficients.
    std: Vector,
    mean: Vector,
    /// Cholesky factor of the posterior precision, in units of the prior standard deviations.
    factor: Vec<f64>,
}

impl Generator {
    /// Creates the generator for equally probable `mechanisms`.
    pub fn new(textures: &[Solved], mechanisms: &[Mechanism]) -> Self {
        let physics = textures.iter().map(|of| of.physics);
        let kinds = mechanisms.iter().flat_map(|&mechanism| {
            let has_scale = matches!(mechanism, Mechanism::Saturating | Mechanism::Depth);
            let scales = mechanism.scales().into_iter().take(if has_scale { 4 } else { 1 });
            let share = 1.0 / (mechanisms.len() * scales.len()) as f64;
            scales.map(move |scale| {
                let (sizes, slopes) = sizes(mechanism).into_iter().unzip();
                let values = textures.iter().map(|of| mechanism.value(&of.features, scale)).collect();
                Kind { mechanism, share, values, sizes, slopes }
            })
        });
        Self { physics: physics.collect(), kinds: kinds.collect(), moduli: moduli() }
    }

    /// Logarithms of the ratios of the texture at `place` as designed, in the laboratory `of`.
    pub fn log_truth(&self, of: &Draw, place: usize) -> [f64; LOADS] {
        let kind = &self.kinds[of.kind];
        let grown = (kind.values[place], &of.amplitude);
        self.physics[place].log_truth(of.log_modulus, grown, kind.mechanism == Mechanism::Rims)
    }

    /// Number of textures.
    pub fn textures(&self) -> usize {
        self.physics.len()
    }

    /// Draws `count` laboratories from the posterior after the measurements `seen` with the standard error `noise`.
    /// `wanted` holds the limits of the logarithms of a sample on target.
    pub fn draws(&self, seen: &[Seen], noise: f64, wanted: &[[f64; LOADS]; 2], count: usize) -> Draws {
        let components = self.components(seen, noise);
        let most = components.iter().map(|of| of.weight).fold(f64::NEG_INFINITY, f64::max);
        let shares: Vec<f64> = components.iter().map(|of| (of.weight - most).exp()).collect();
        let step = shares.iter().sum::<f64>() / count as f64;
        let mut normals = Normals::new(1 + seen.len() as u64);
        let (mut draws, mut reached, mut next) = (Vec::with_capacity(count), 0.0, 0.5 * step);
        for (of, share) in components.iter().zip(&shares) {
            reached += share;
            while next < reached {
                next += step;
                draws.extend(self.draw(of, seen, noise, wanted, &mut normals));
            }
        }
        Draws::new(draws)
    }

    fn draw(
        &self,
        of: &Component,
        seen: &[Seen],
        noise: f64,
        wanted: &[[f64; LOADS]; 2],
        normals: &mut Normals,
    ) -> Option<Draw> {
        let mut z: Vector = std::array::from_fn(|_| normals.draw());
        solve_upper(&of.factor, N, &mut z);
        let c: Vector = std::array::from_fn(|k| of.std[k] * (of.mean[k] + z[k]));
        let (size, log_modulus) = (of.size.at + c[0], of.modulus.at + c[3]);
        let amplitude = amplitude(size, c[1], c[2]);
        let flat = std::array::from_fn(|load| c[4 + load]);
        let mut draw = Draw { kind: of.kind, log_modulus, amplitude, flat, weight: 0.0 };
        let kind = &self.kinds[of.kind];
        // What the Gaussians say of the coefficients, against how they are drawn.
        let mut log = 0.0;
        if of.size.std > 0.0 {
            let [from, by] = kind.mechanism.sizes();
            let share = (size - from) / by;
            if !(0.0..=1.0).contains(&share) {
                return None;
            }
            log -= (by.abs() * kind.sizes.iter().map(|node| node.density(size)).sum::<f64>()).ln();
            // ln N(b; 0, s) - ln N(b; 0, s0)
            let (own, node) = (SLOPE_SHARE * size, of.std[1]);
            let square = c[1] * c[1] + c[2] * c[2];
            log += -0.5 * square * (own.powi(-2) - node.powi(-2)) - 2.0 * (own.abs() / node).ln();
        }
        if of.modulus.std > 0.0 {
            if log_modulus.abs() > MAX_LOG_MODULUS {
                return None;
            }
            let prior = Node { at: 0.0, std: MODULUS_STD, share: 1.0 };
            let inner = self.moduli.iter().filter(|node| node.std > 0.0);
            log += (prior.density(log_modulus) / inner.map(|node| node.density(log_modulus)).sum::<f64>()).ln();
        }
        // What was measured, against what the linear regression says of it.
        for at in seen {
            let physics = &self.physics[at.place];
            let own = self.log_truth(&draw, at.place);
            let square = 0.5 * (log_modulus - of.modulus.at).powi(2);
            let linear: [f64; LOADS] = std::array::from_fn(|load| own[load] - square * physics.curvature[load]);
            let rest = |truth: &[f64; LOADS]| std::array::from_fn(|load| at.log[load] - truth[load] + flat[load]);
            log -= Scatter::new(&at.log, noise).log_density(&rest(&linear));
            let (scatter, rest) = (Scatter::new(&own, noise), rest(&own));
            log += scatter.log_density(&rest);
            if at.is_missed {
                log += (1.0 - scatter.chance(&own, &rest, wanted)).ln();
            }
        }
        draw.weight = log;
        log.is_finite().then_some(draw)
    }

    fn components(&self, seen: &[Seen], noise: f64) -> Vec<Component> {
        let mut found = Vec::new();
        for (place, kind) in self.kinds.iter().enumerate() {
            for modulus in &self.moduli {
                let sums = self.sums(kind, modulus, seen, noise);
                found.extend(kind.sizes.iter().zip(&kind.slopes).filter_map(|(size, [beta, gamma])| {
                    let mut std = [FLAT_SHARE * noise; N];
                    std[..4].copy_from_slice(&[size.std, *beta, *gamma, modulus.std]);
                    let prior = kind.share * size.share * modulus.share;
                    let (mean, factor, evidence) = sums.regression(&std, size.at)?;
                    Some(Component {
                        kind: place,
                        size: *size,
                        modulus: *modulus,
                        weight: prior.ln() + evidence,
                        std,
                        mean,
                        factor,
                    })
                }));
            }
        }
        found
    }

    fn sums(&self, kind: &Kind, modulus: &Node, seen: &[Seen], noise: f64) -> Sums {
        let mut sums = Sums::default();
        for at in seen {
            let (value, physics) = (kind.values[at.place], &self.physics[at.place]);
            let [of_beta, of_gamma] = [amplitude(0.0, 1.0, 0.0), amplitude(0.0, 0.0, 1.0)];
            let m = modulus.at;
            let none = physics.log_truth(m, (0.0, &[0.0; LOADS]), kind.mechanism == Mechanism::Rims);
            let rest: [f64; LOADS] = std::array::from_fn(|load| at.log[load] - none[load]);
            // Columns: what each coefficient does at each load.
            let mut columns = [[0.0; LOADS]; N];
            for load in 0..LOADS {
                columns[0][load] = value;
                columns[1][load] = value * of_beta[load];
                columns[2][load] = value * of_gamma[load];
                columns[3][load] = physics.slope[load] + m * physics.curvature[load];
                columns[4 + load][load] = -1.0;
            }
            sums.add(&columns, &rest, &Scatter::new(&at.log, noise));
        }
        sums
    }
}

/// Sums over all samples: X^T W X, X^T W y and y^T W y, with the columns X of the coefficients and the remainder y.
#[derive(Default)]
struct Sums {
    matrix: Matrix,
    right: Vector,
    square: f64,
}

impl Sums {
    fn add(&mut self, columns: &[[f64; LOADS]; N], rest: &[f64; LOADS], scatter: &Scatter) {
        let weighted = columns.map(|column| scatter.solve(&column));
        for ((sums, right), column) in self.matrix.iter_mut().zip(&mut self.right).zip(columns) {
            *right += dot(column, &scatter.solve(rest));
            sums.iter_mut().zip(&weighted).for_each(|(sum, weighted)| *sum += dot(column, weighted));
        }
        self.square += dot(rest, &scatter.solve(rest));
    }

    /// Posterior mean and Cholesky factor of the precision, in units of the prior standard deviations `std`, and the
    /// logarithm of the evidence up to a constant shared by all components; `None` for numbers that are not finite.
    /// `size` is the prior mean of the size.
    fn regression(&self, std: &Vector, size: f64) -> Option<(Vector, Vec<f64>, f64)> {
        // A = 1 + S X^T W X S,  b = S X^T W (y - x0 size)
        let mut precision: Matrix =
            std::array::from_fn(|row| std::array::from_fn(|column| std[row] * self.matrix[row][column] * std[column]));
        (0..N).for_each(|row| precision[row][row] += 1.0);
        let mut mean: Vector = std::array::from_fn(|row| std[row] * (self.right[row] - size * self.matrix[row][0]));
        let square = self.square - 2.0 * size * self.right[0] + size * size * self.matrix[0][0];
        let factor = cholesky(precision.as_flattened(), N)?;
        solve_lower(&factor, N, &mut mean);
        // ln evidence = -(y^T W y - b^T A^-1 b) / 2 - ln det A / 2
        let known: f64 = mean.iter().map(|x| x * x).sum();
        let determinant: f64 = (0..N).map(|row| factor[row * N + row].ln()).sum();
        solve_upper(&factor, N, &mut mean);
        Some((mean, factor, -0.5 * (square - known) - determinant))
    }
}

/// Covariance of a sample's measured logarithms without the flat sample's errors: s^2 I + t^2 1 1^T + (d L) (d L)^T,
/// with the noise s, the scatter t between samples, the scatter d of dimensions, and the logarithm L of the ratio.
pub struct Scatter {
    variance: f64,
    /// t^2 / (s^2 + LOADS t^2)
    own: f64,
    /// d L
    dimensions: [f64; LOADS],
    /// V^-1 d L for V without the dimensions, and 1 + (d L)^T V^-1 d L.
    solved: [f64; LOADS],
    precision: f64,
}

impl Scatter {
    /// Creates the covariance for a sample with the logarithms `log`.
    pub fn new(log: &[f64; LOADS], noise: f64) -> Self {
        let (variance, own) = (noise * noise, SAMPLE_STD * SAMPLE_STD);
        let mut found = Self {
            variance,
            own: own / (variance + LOADS as f64 * own),
            dimensions: log.map(|log| DIMENSIONS_STD * log),
            solved: [0.0; LOADS],
            precision: 1.0,
        };
        found.solved = found.inner(&found.dimensions);
        found.precision += dot(&found.dimensions, &found.solved);
        found
    }

    /// Multiplies `x` by the inverse covariance without the dimensions: V^-1 x = (x - k sum x) / s^2.
    fn inner(&self, x: &[f64; LOADS]) -> [f64; LOADS] {
        let sum: f64 = x.iter().sum();
        x.map(|x| (x - self.own * sum) / self.variance)
    }

    fn solve(&self, x: &[f64; LOADS]) -> [f64; LOADS] {
        let (inner, along) = (self.inner(x), dot(&self.solved, x) / self.precision);
        std::array::from_fn(|load| inner[load] - along * self.solved[load])
    }

    /// Logarithm of the density of the residual `rest`, up to a constant shared by all textures.
    pub fn log_density(&self, rest: &[f64; LOADS]) -> f64 {
        -0.5 * (dot(rest, &self.solve(rest)) + self.precision.ln())
    }

    /// Probability that the measured sample is on target, that is, that its logarithms are within `wanted`. `log` are
    /// the logarithms as designed, `rest` the residual of the measurement.
    pub fn chance(&self, log: &[f64; LOADS], rest: &[f64; LOADS], wanted: &[[f64; LOADS]; 2]) -> f64 {
        // Of the dimensions, in standard deviations.
        let (mean, std) = (dot(&self.solved, rest) / self.precision, self.precision.powf(-0.5));
        // Of the sample's own, where the dimensions are known.
        let of_own = |z: f64| {
            let left: f64 = (0..LOADS).map(|load| rest[load] - z * self.dimensions[load]).sum();
            (self.own * left, (self.own * self.variance).sqrt())
        };
        within(log, wanted, (mean, std), &of_own)
    }
}

/// Integration grid for the deviate of the dimensions: step in standard deviations, and number of steps on either side.
const STEP: f64 = 0.5;
const STEPS: i32 = 7;

/// Probability that (1 + d z) `log` + t is within `wanted` at every load. The deviate z is normal with this mean and
/// standard deviation; `of_own` returns those of t for a given z.
pub fn within(
    log: &[f64; LOADS],
    wanted: &[[f64; LOADS]; 2],
    (mean, std): (f64, f64),
    of_own: &dyn Fn(f64) -> (f64, f64),
) -> f64 {
    let [lower, upper] = wanted;
    let mut sum = 0.0;
    for step in -STEPS..=STEPS {
        let deviate = STEP * f64::from(step);
        let z = mean + std * deviate;
        let more = 1.0 + DIMENSIONS_STD * z;
        let (mut least, mut most) = (f64::NEG_INFINITY, f64::INFINITY);
        for load in 0..LOADS {
            least = least.max(lower[load] - more * log[load]);
            most = most.min(upper[load] - more * log[load]);
        }
        if least < most {
            let (own, own_std) = of_own(z);
            let below = |x: f64| slipgrid_base::statistics::normal_probability((x - own) / own_std);
            sum += (-0.5 * deviate * deviate).exp() * (below(most) - below(least));
        }
    }
    (sum * STEP / std::f64::consts::TAU.sqrt()).clamp(0.0, 1.0)
}

/// Equidistant Gaussians from `from` to `to`, weighted by `share`.
fn cover(from: f64, to: f64, count: usize, share: &dyn Fn(f64) -> f64) -> Vec<Node> {
    let step = (to - from) / count as f64;
    (0..count)
        .map(|place| {
            let at = from + (place as f64 + 0.5) * step;
            Node { at, std: OVERLAP * step.abs(), share: share(at) }
        })
        .collect()
}

/// Gaussians for the size of `mechanism`, with the standard deviations of its two changes with pressure.
fn sizes(mechanism: Mechanism) -> Vec<(Node, [f64; 2])> {
    if matches!(mechanism, Mechanism::Rims | Mechanism::None) {
        return vec![(Node { at: 0.0, std: 0.0, share: 1.0 }, [0.0; 2])];
    }
    let [from, by] = mechanism.sizes();
    let nodes = cover(from, from + by, SIZES, &|_| 1.0 / SIZES as f64);
    nodes.into_iter().map(|node| (node, [SLOPE_SHARE * node.at.abs(); 2])).collect()
}

/// Gaussians for the modulus between its limits, and one point at each limit with the probability beyond it.
fn moduli() -> Vec<Node> {
    let beyond = slipgrid_base::statistics::normal_probability(-MAX_LOG_MODULUS / MODULUS_STD);
    let step = 2.0 * MAX_LOG_MODULUS / MODULI as f64;
    let prior = Node { at: 0.0, std: MODULUS_STD, share: 1.0 };
    let mut nodes = cover(-MAX_LOG_MODULUS, MAX_LOG_MODULUS, MODULI, &|at| step * prior.density(at));
    nodes.extend([-MAX_LOG_MODULUS, MAX_LOG_MODULUS].map(|at| Node { at, std: 0.0, share: beyond }));
    nodes
}

#[cfg(test)]
mod tests;
