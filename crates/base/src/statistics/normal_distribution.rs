//! Normal distribution of one and of several variables: probabilities and quantiles, identical on all platforms.

use std::ops::Range;
use std::sync::LazyLock;

/// The central approximation of the quantile is used for probabilities at most this far from one half.
const CENTRAL: f64 = 0.425;
/// The approximation of the far tail is used if sqrt(-ln p) exceeds this value; p is the probability in the tail.
const FAR: f64 = 5.0;

/// Probability that a standard normal deviate is below `x`.
pub fn normal_probability(x: f64) -> f64 {
    // Phi(x) = erfc(-x / sqrt(2)) / 2
    0.5 * libm::erfc(-x * std::f64::consts::FRAC_1_SQRT_2)
}

/// Like [`normal_probability`], in a sixth of the time with an error of at most 4e-9.
pub fn tabulated_normal_probability(x: f64) -> f64 {
    TABLES.probability(x)
}

/// Density of a standard normal deviate at `x`.
fn normal_density(x: f64) -> f64 {
    // exp(-x^2 / 2) / sqrt(2 pi)
    const AT_ZERO: f64 = 0.398_942_280_401_432_7;
    AT_ZERO * libm::exp(-0.5 * x * x)
}

/// Quantile of the standard normal distribution at the probability `p`, to 16 digits, by algorithm AS 241 (M. J.
/// Wichura, Appl. Stat. 37, 477). Infinite at 0 and 1, NaN outside.
pub fn normal_quantile(p: f64) -> f64 {
    if !(0.0..=1.0).contains(&p) {
        return f64::NAN;
    }
    let q = p - 0.5;
    if q.abs() <= CENTRAL {
        // q P(r) / Q(r), r = 0.425^2 - q^2
        return q * rational(&CENTRAL_TOP, &CENTRAL_BOTTOM, 0.180_625 - q * q);
    }
    let tail = p.min(1.0 - p);
    if tail <= 0.0 {
        return if q < 0.0 { f64::NEG_INFINITY } else { f64::INFINITY };
    }
    let r = (-libm::log(tail)).sqrt();
    let size = if r <= FAR {
        rational(&MIDDLE_TOP, &MIDDLE_BOTTOM, r - 1.6)
    } else {
        rational(&FAR_TOP, &FAR_BOTTOM, r - FAR)
    };
    if q < 0.0 { -size } else { size }
}

/// Coefficients of a polynomial by increasing power.
type Coefficients = [[f64; 4]; 2];

/// Ratio of two polynomials in `x`.
fn rational(top: &Coefficients, bottom: &Coefficients, x: f64) -> f64 {
    let value = |of: &Coefficients| of.as_flattened().iter().rev().fold(0.0, |sum, c| sum * x + c);
    value(top) / value(bottom)
}

const CENTRAL_TOP: Coefficients = [
    [3.387_132_872_796_366_5, 1.331_416_678_917_843_8e2, 1.971_590_950_306_551_3e3, 1.373_169_376_550_946e4],
    [4.592_195_393_154_987e4, 6.726_577_092_700_87e4, 3.343_057_558_358_813e4, 2.509_080_928_730_122_7e3],
];
const CENTRAL_BOTTOM: Coefficients = [
    [1.0, 4.231_333_070_160_091e1, 6.871_870_074_920_579e2, 5.394_196_021_424_751e3],
    [2.121_379_430_158_659_7e4, 3.930_789_580_009_271e4, 2.872_908_573_572_194_3e4, 5.226_495_278_852_545e3],
];
const MIDDLE_TOP: Coefficients = [
    [1.423_437_110_749_683_5, 4.630_337_846_156_546, 5.769_497_221_460_691, 3.647_848_324_763_204_5],
    [1.270_458_252_452_368_4, 2.417_807_251_774_506e-1, 2.272_384_498_926_918_4e-2, 7.745_450_142_783_414e-4],
];
const MIDDLE_BOTTOM: Coefficients = [
    [1.0, 2.053_191_626_637_759, 1.676_384_830_183_803_8, 6.897_673_349_851e-1],
    [1.481_039_764_274_800_8e-1, 1.519_866_656_361_645_7e-2, 5.475_938_084_995_345e-4, 1.050_750_071_644_416_9e-9],
];
const FAR_TOP: Coefficients = [
    [6.657_904_643_501_103, 5.463_784_911_164_114, 1.784_826_539_917_291_3, 2.965_605_718_285_048_7e-1],
    [2.653_218_952_657_612_4e-2, 1.242_660_947_388_078_4e-3, 2.711_555_568_743_487_6e-5, 2.010_334_399_292_288_1e-7],
];
const FAR_BOTTOM: Coefficients = [
    [1.0, 5.998_322_065_558_88e-1, 1.369_298_809_227_358e-1, 1.487_536_129_085_061_5e-2],
    [7.868_691_311_456_133e-4, 1.846_318_317_510_054_8e-5, 1.421_511_758_316_446e-7, 2.044_263_103_389_939_8e-15],
];

/// Maximum number of Newton steps for the quantile of a mixture.
const MAX_STEPS: usize = 100;
/// The Newton iteration for the quantile of a mixture ends at this error of the probability: that of the tables.
const MAX_OFF: f64 = 5e-9;

/// Quantile of a mixture of normal distributions at the probability `p`. Each of `parts` has a weight, a mean and a
/// standard deviation; the weights sum to 1. The probability is met to 1e-8. NaN without parts.
pub fn mixture_quantile(parts: &[[f64; 3]], p: f64) -> f64 {
    let tables: &Tables = &TABLES;
    let z = normal_quantile(p);
    // The quantile lies between the smallest and the largest quantile of the parts, near their mean.
    let (mut low, mut high, mut value) = (f64::INFINITY, f64::NEG_INFINITY, 0.0);
    for [weight, mean, std] in parts {
        let own = mean + z * std;
        (low, high) = (low.min(own), high.max(own));
        value += weight * own;
    }
    for _ in 0..MAX_STEPS {
        let (mut off, mut density) = (-p, 0.0);
        for [weight, mean, std] in parts {
            if *std > 0.0 {
                let [below, slope] = tables.probability_and_density((value - mean) / std);
                off += weight * below;
                density += weight * slope / std;
            } else if *mean < value {
                off += weight;
            }
        }
        if off.abs() < MAX_OFF {
            break;
        }
        if off < 0.0 {
            low = value
        } else {
            high = value
        }
        // Newton's step; the middle of the interval if the step leads out of the interval.
        let next = value - off / density;
        let next = if low < next && next < high { next } else { f64::midpoint(low, high) };
        if next == value {
            break;
        }
        value = next;
    }
    if parts.is_empty() { f64::NAN } else { value }
}

/// Number of nodes of the table of probabilities per unit of x.
const PER_UNIT: f64 = 32.0;
/// End of the table of probabilities, which covers x from -END to END: the probability beyond is less than 1e-15.
const END: f64 = 8.0;
/// Number of intervals of the table of quantiles. More would cost memory for digits that no printed chance shows.
const QUANTILES: usize = 1024;
/// Minimum probability of the table of quantiles. A smaller minimum would cost memory as well.
const MIN_TABULATED: f64 = 0.02;

/// Tables that interpolate probabilities and quantiles for [`BoxRule`], which needs millions of values: a lookup takes
/// a sixth of the time of [`normal_probability`] or [`normal_quantile`].
struct Tables {
    /// Probability at each node, and the derivative times the node distance.
    probability: Vec<[f64; 2]>,
    /// Quantile at each node, and the derivative times the node distance.
    quantile: Vec<[f64; 2]>,
}

static TABLES: LazyLock<Tables> = LazyLock::new(|| {
    // Some hundred nodes: the casts are exact.
    let probability = |place: usize| {
        let x = place as f64 / PER_UNIT - END;
        [normal_probability(x), normal_density(x) / PER_UNIT]
    };
    let quantile = |place: usize| {
        let x =
            normal_quantile((place as f64 / QUANTILES as f64).clamp(MIN_TABULATED / 2.0, 1.0 - MIN_TABULATED / 2.0));
        [x, 1.0 / (normal_density(x) * QUANTILES as f64)]
    };
    Tables {
        probability: (0..=(2.0 * END * PER_UNIT) as usize).map(probability).collect(),
        quantile: (0..=QUANTILES).map(quantile).collect(),
    }
});

/// Cubic Hermite polynomial between the two nodes around `along`, the distance from the first node in node distances:
/// coefficients by increasing power, and the position between these two nodes, from 0 to 1.
fn cubic(nodes: &[[f64; 2]], along: f64) -> ([f64; 4], f64) {
    // Within the nodes: the cast is exact.
    let place = (along as usize).min(nodes.len() - 2);
    let [[from, slope_from], [to, slope_to]] = [nodes[place], nodes[place + 1]];
    let rise = to - from;
    // p0 + t (m0 + t ((3 d - 2 m0 - m1) + t (m0 + m1 - 2 d)))
    let third = slope_from + slope_to - 2.0 * rise;
    ([from, slope_from, rise - slope_from - third, third], along - place as f64)
}

/// Interpolates `nodes`, values and derivatives, by cubic Hermite polynomials at `along`, the distance from the first
/// node in node distances.
fn interpolate(nodes: &[[f64; 2]], along: f64) -> f64 {
    let ([c0, c1, c2, c3], t) = cubic(nodes, along);
    c0 + t * (c1 + t * (c2 + t * c3))
}

impl Tables {
    /// Interpolates [`normal_probability`] with an error of at most 4e-9.
    fn probability(&self, x: f64) -> f64 {
        interpolate(&self.probability, (x.clamp(-END, END) + END) * PER_UNIT)
    }

    /// Interpolates [`normal_probability`] with an error of at most 4e-9, and the density with one of 2e-6.
    fn probability_and_density(&self, x: f64) -> [f64; 2] {
        if x.abs() >= END {
            return [if x < 0.0 { 0.0 } else { 1.0 }, 0.0];
        }
        let ([c0, c1, c2, c3], t) = cubic(&self.probability, (x + END) * PER_UNIT);
        [c0 + t * (c1 + t * (c2 + t * c3)), PER_UNIT * (c1 + t * (2.0 * c2 + 3.0 * t * c3))]
    }

    /// Interpolates [`normal_quantile`] with an error of at most 1e-7.
    fn quantile(&self, p: f64) -> f64 {
        if (MIN_TABULATED..=1.0 - MIN_TABULATED).contains(&p) {
            interpolate(&self.quantile, p * QUANTILES as f64)
        } else {
            normal_quantile(p.clamp(1e-300, 1.0 - 1e-16))
        }
    }
}

/// Quasi-Monte Carlo rule for the probability that a normal vector lies in a box: separation of variables (A. Genz, J. Comput. Graph. Stat. 1,
/// 141) on the points frac(k sqrt(p)) of a Richtmyer lattice.
#[derive(Clone, Debug)]
pub struct BoxRule {
    /// Square roots of different primes, one per component except the first; equal roots would correlate two
    /// components.
    roots: Vec<f64>,
}

/// Distance of `end` from the mean in standard deviations; infinite for an exact value, which has `std` 0.
fn standardized(end: f64, mean: f64, std: f64) -> f64 {
    if std > 0.0 {
        (end - mean) / std
    } else if end >= mean {
        f64::INFINITY
    } else {
        f64::NEG_INFINITY
    }
}

/// Number of points that [`BoxRule`] evaluates together, so that no point waits for the table lookups of another.
const LANES: usize = BoxRule::LANES;

impl BoxRule {
    /// Number of points that are evaluated together; a multiple of this number costs least per point.
    pub const LANES: usize = 4;

    /// Creates the rule for vectors of `n` components.
    pub fn new(n: usize) -> Self {
        let is_prime =
            |number: &u32| (2..).take_while(|d| d * d <= *number).all(|divisor| !number.is_multiple_of(divisor));
        let primes = (2..).filter(is_prime);
        Self { roots: primes.take(n.saturating_sub(1)).map(|prime| f64::from(prime).sqrt()).collect() }
    }

    /// Probability that a normal vector lies between `lower` and `upper`, as the mean over `points` of the lattice.
    /// `factor` is the lower triangular factor L of the covariance L L^T, n x n, row by row; rows of zeros are exact
    /// components. For a mixture, give consecutive `points` to the terms, so that their errors are independent.
    pub fn probability(&self, mean: &[f64], factor: &[f64], [lower, upper]: [&[f64]; 2], points: Range<usize>) -> f64 {
        let n = mean.len();
        if n == 0 {
            return 1.0;
        }
        let probability = if n == 1 { normal_probability } else { tabulated_normal_probability };
        let [first, last] = [lower[0], upper[0]].map(|end| probability(standardized(end, mean[0], factor[0])));
        // An exact component on its upper end counts as within.
        let share = last - first;
        if n == 1 || share <= 0.0 || points.is_empty() {
            return share.max(0.0);
        }
        let (count, tables): (_, &Tables) = (points.len() as f64, &TABLES);
        let (mut sum, mut drawn) = (0.0, vec![[0.0; LANES]; n]);
        for start in points.clone().step_by(LANES) {
            let (mut product, mut from, mut to) = ([share; LANES], [first; LANES], [last; LANES]);
            for row in 1..n {
                // The baker's transform of frac(k sqrt(p) + 1/2) makes the integrand periodic. At most some 1e9: the casts are exact.
                let root = self.roots[row - 1];
                let x = std::array::from_fn::<f64, LANES, _>(|lane| (start + lane + 1) as f64 * root + 0.5);
                let x = x.map(|x| (2.0 * (x - (x as i64) as f64) - 1.0).abs());
                drawn[row - 1] =
                    std::array::from_fn(|lane| tables.quantile(from[lane] + x[lane] * (to[lane] - from[lane])));
                let mut known = [0.0; LANES];
                for (y, l) in drawn[..row].iter().zip(&factor[row * n..]) {
                    (0..LANES).for_each(|lane| known[lane] += y[lane] * l);
                }
                let std = factor[row * n + row];
                let below = |end: f64| known.map(|known| tables.probability(standardized(end, mean[row] + known, std)));
                (from, to) = (below(lower[row]), below(upper[row]));
                (0..LANES).for_each(|lane| product[lane] *= (to[lane] - from[lane]).max(0.0));
                if product == [0.0; LANES] {
                    break;
                }
            }
            sum += product.iter().take(points.end - start).sum::<f64>();
        }
        sum / count
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::Normals;

    /// Probability by [`BoxRule`] with 512 points: exact for one component, with a root mean square error of about 5e-4
    /// for two to six components whose scatter is mostly common.
    fn box_probability(mean: &[f64], factor: &[f64], lower: &[f64], upper: &[f64]) -> f64 {
        BoxRule::new(mean.len()).probability(mean, factor, [lower, upper], 0..512)
    }

    /// Share of normal vectors, drawn by mean and factor, that lie between their lower and upper ends.
    fn drawn_share([mean, factor, lower, upper]: [&[f64]; 4], draws: u32, normals: &mut Normals) -> f64 {
        let n = mean.len();
        let is_inside = |z: Vec<f64>| {
            (0..n).all(|row| {
                let y = mean[row] + (0..=row).map(|c| factor[row * n + c] * z[c]).sum::<f64>();
                (lower[row]..=upper[row]).contains(&y)
            })
        };
        let inside = (0..draws).filter(|_| is_inside((0..n).map(|_| normals.draw()).collect())).count();
        inside as f64 / f64::from(draws)
    }

    #[test]
    fn quantiles_undo_probabilities() {
        for (p, x) in [(0.5, 0.0), (0.975, 1.959_963_984_540_054), (0.84, 0.994_457_883_209_753_2)] {
            assert!((normal_quantile(p) - x).abs() < 1e-14, "{p}");
        }
        for p in [1e-300, 1e-12, 1e-5, 0.02, 0.3, 0.7, 0.999, 1.0 - 1e-12] {
            let again = normal_probability(normal_quantile(p));
            assert!((again / p - 1.0).abs() < 1e-9, "{p} {again}");
        }
        assert!(normal_quantile(0.0) == f64::NEG_INFINITY && normal_quantile(1.0) == f64::INFINITY);
        assert!(normal_quantile(-0.1).is_nan());
    }

    #[test]
    fn tables_are_the_functions() {
        for place in -9_999..=9_999 {
            let x = f64::from(place) * 1e-3;
            let off = TABLES.probability(x) - normal_probability(x);
            assert!(off.abs() < 4e-9, "{x} {off}");
            let p = 0.5 + f64::from(place) * 5e-5;
            let off = TABLES.quantile(p) - normal_quantile(p);
            assert!(off.abs() < 1e-7, "{p} {off}");
        }
        for end in [f64::NEG_INFINITY, f64::INFINITY] {
            assert!((TABLES.probability(end) - normal_probability(end)).abs() < 1e-14);
        }
    }

    #[test]
    fn quantiles_of_mixtures_undo_their_probabilities() {
        let mut normals = Normals::new(17);
        for count in [1, 2, 5, 190] {
            let mut parts: Vec<[f64; 3]> =
                (0..count).map(|_| [normals.draw().abs(), normals.draw(), normals.draw().exp()]).collect();
            let sum: f64 = parts.iter().map(|part| part[0]).sum();
            parts.iter_mut().for_each(|part| part[0] /= sum);
            for p in [1e-4, 0.025, 0.3, 0.5, 0.975, 0.9999] {
                let value = mixture_quantile(&parts, p);
                let below: f64 = parts.iter().map(|[w, mean, std]| w * normal_probability((value - mean) / std)).sum();
                assert!((below - p).abs() < 1e-8, "{count} {p}: {below}");
            }
        }
        // Exact parts are steps: the quantile lies on the one that crosses p.
        let steps = [[0.3, 1.0, 0.0], [0.7, 2.0, 0.0]];
        assert!(
            (mixture_quantile(&steps, 0.2) - 1.0).abs() < 1e-9 && (mixture_quantile(&steps, 0.5) - 2.0).abs() < 1e-9
        );
        assert!(mixture_quantile(&[], 0.5).is_nan());
    }

    #[test]
    fn boxes_hold_the_share_of_draws_that_fall_into_them() {
        let mut normals = Normals::new(5);
        for case in 0..12 {
            let n = 1 + case % 4;
            let mut factor = vec![0.0; n * n];
            for row in 0..n {
                for column in 0..=row {
                    factor[row * n + column] = if case == 7 && column > 0 { 0.0 } else { normals.draw() };
                }
                factor[row * n + row] = factor[row * n + row].abs();
            }
            let mean: Vec<f64> = (0..n).map(|_| 0.5 * normals.draw()).collect();
            let (lower, upper): (Vec<f64>, Vec<f64>) =
                (0..n).map(|_| (-1.0 - normals.draw().abs(), 0.8 + normals.draw().abs())).unzip();
            let found = box_probability(&mean, &factor, &lower, &upper);
            let share = drawn_share([&mean, &factor, &lower, &upper], 200_000, &mut normals);
            // Draws: 0.0011 at most; the rule's own error.
            assert!((found - share).abs() < 0.004, "{case}: {found} {share}");
        }
    }

    /// Components with a common factor, as loads have by an uncertain modulus, in narrow boxes: draws of all components
    /// then are inside together.
    #[test]
    fn boxes_of_components_with_a_common_factor_are_those_of_an_integral_over_it() {
        let mut normals = Normals::new(3);
        let mut squares = 0.0;
        for case in 0..60 {
            let n = 2 + case % 5;
            let (common, own) = (1.0, 0.1 + 0.2 * normals.draw().abs());
            let ends: Vec<[f64; 2]> =
                (0..n).map(|_| [-0.4 - 0.4 * normals.draw().abs(), 0.4 + 0.4 * normals.draw().abs()]).collect();
            // P = integral of phi(z) prod (Phi((u_i - c z) / s) - Phi((l_i - c z) / s)) dz, by the trapezoidal rule.
            let at = |k: u32| {
                let z = f64::from(k) * 1e-3 - 8.0;
                let within = |[lower, upper]: &[f64; 2]| {
                    normal_probability((upper - common * z) / own) - normal_probability((lower - common * z) / own)
                };
                (-0.5 * z * z).exp() * ends.iter().map(within).product::<f64>()
            };
            let exact = (0..=16_000).map(at).sum::<f64>() * 1e-3 / std::f64::consts::TAU.sqrt();
            let covariance: Vec<f64> =
                (0..n * n).map(|e| common * common + if e / n == e % n { own * own } else { 0.0 }).collect();
            let factor = crate::statistics::cholesky::cholesky(&covariance, n).unwrap();
            let (lower, upper): (Vec<f64>, Vec<f64>) = ends.iter().map(|[lower, upper]| (*lower, *upper)).unzip();
            let off = box_probability(&vec![0.0; n], &factor, &lower, &upper) - exact;
            assert!(off.abs() < 3e-3, "{case} of {n}: {off} of {exact}");
            squares += off * off / 60.0;
        }
        assert!(squares.sqrt() < 1e-3, "{}", squares.sqrt());
    }

    /// Factor, mean and limits of a box for loads at several conditions, which share some inputs; from narrow to wide
    /// at random.
    fn of_conditions(n: usize, normals: &mut Normals) -> [Vec<f64>; 4] {
        let common = 1.0 + normals.draw().abs();
        let mut factor = vec![0.0; n * n];
        for row in 0..n {
            factor[row * n] = common * (1.0 + 0.2 * normals.draw());
            for column in 1..=row {
                factor[row * n + column] = 0.3 * normals.draw();
            }
            factor[row * n + row] = 0.1 + 0.3 * normals.draw().abs();
        }
        let mean: Vec<f64> = (0..n).map(|_| 0.5 * normals.draw()).collect();
        let half = 0.5 + 3.0 * normals.draw().abs();
        [factor, mean, vec![-half; n], vec![half; n]]
    }

    /// Boxes of vectors with many components, each of which needs a lattice direction of its own.
    #[test]
    fn boxes_of_many_conditions_hold_the_share_of_draws_too() {
        let mut normals = Normals::new(5);
        let (mut squares, mut between) = (0.0, 0);
        let cases = 24;
        for case in 0..cases {
            let n = 18 + 2 * (case % 4);
            let [factor, mean, lower, upper] = of_conditions(n, &mut normals);
            let found = box_probability(&mean, &factor, &lower, &upper);
            let share = drawn_share([&mean, &factor, &lower, &upper], 10_000, &mut normals);
            between += usize::from(share > 0.05 && share < 0.95);
            squares += (found - share).powi(2) / cases as f64;
        }
        // Draws: 0.005 at most. With twelve roots for all components it was 0.02.
        assert!(squares.sqrt() < 0.01 && between > cases / 2, "{} {between}", squares.sqrt());
    }

    #[test]
    fn one_component_and_exact_ones_are_exact() {
        let one = box_probability(&[0.3], &[2.0], &[-1.0], &[1.0]);
        assert!((one - (normal_probability(0.35) - normal_probability(-0.65))).abs() < 1e-15);
        // y_2 = y_1: the smaller box decides.
        let same = box_probability(&[0.0, 0.0], &[1.0, 0.0, 1.0, 0.0], &[-1.0, -1.0], &[1.0, 1.0]);
        assert!((same - 0.682_689_492_137_086).abs() < 1e-12);
        assert_eq!(box_probability(&[], &[], &[], &[]), 1.0);
    }
}
