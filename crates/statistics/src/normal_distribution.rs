//! Univariate and multivariate normal distribution: probabilities and quantiles, identical on all platforms.

/// Range of |p - 1/2| of the central approximation of the quantile.
const CENTRAL_RANGE: f64 = 0.425;
/// Start of the approximation of the far tail.
const FAR_START: f64 = 5.0;

/// Probability that a standard normal deviate is below `x`.
#[must_use]
pub fn normal_probability(x: f64) -> f64 {
    // Phi(x) = erfc(-x / sqrt(2)) / 2
    0.5 * libm::erfc(-x * std::f64::consts::FRAC_1_SQRT_2)
}

/// Quantile of the standard normal distribution for the probability `p`, to 16 digits, by algorithm AS 241 (M. J.
/// Wichura, Appl. Stat. 37, 477). Infinite at 0 and 1, and NaN outside.
#[must_use]
pub fn normal_quantile(p: f64) -> f64 {
    if !(0.0..=1.0).contains(&p) {
        return f64::NAN;
    }
    let q = p - 0.5;
    if q.abs() <= CENTRAL_RANGE {
        // q P(r) / Q(r), r = 0.425^2 - q^2
        return q * rational(&CENTRAL_TOP, &CENTRAL_BOTTOM, 0.180_625 - q * q);
    }
    let tail = p.min(1.0 - p);
    if tail <= 0.0 {
        return if q < 0.0 { f64::NEG_INFINITY } else { f64::INFINITY };
    }
    let r = (-libm::log(tail)).sqrt();
    let size = if r <= FAR_START {
        rational(&MIDDLE_TOP, &MIDDLE_BOTTOM, r - 1.6)
    } else {
        rational(&FAR_TOP, &FAR_BOTTOM, r - FAR_START)
    };
    if q < 0.0 { -size } else { size }
}

/// Ratio of two polynomials with coefficients in ascending order.
fn rational(top: &[f64; 8], bottom: &[f64; 8], x: f64) -> f64 {
    let value = |coefficients: &[f64; 8]| coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c);
    value(top) / value(bottom)
}

const CENTRAL_TOP: [f64; 8] = [
    3.387_132_872_796_366_5,
    1.331_416_678_917_843_8e2,
    1.971_590_950_306_551_3e3,
    1.373_169_376_550_946e4,
    4.592_195_393_154_987e4,
    6.726_577_092_700_87e4,
    3.343_057_558_358_813e4,
    2.509_080_928_730_122_7e3,
];
const CENTRAL_BOTTOM: [f64; 8] = [
    1.0,
    4.231_333_070_160_091e1,
    6.871_870_074_920_579e2,
    5.394_196_021_424_751e3,
    2.121_379_430_158_659_7e4,
    3.930_789_580_009_271e4,
    2.872_908_573_572_194_3e4,
    5.226_495_278_852_545e3,
];
const MIDDLE_TOP: [f64; 8] = [
    1.423_437_110_749_683_5,
    4.630_337_846_156_546,
    5.769_497_221_460_691,
    3.647_848_324_763_204_5,
    1.270_458_252_452_368_4,
    2.417_807_251_774_506e-1,
    2.272_384_498_926_918_4e-2,
    7.745_450_142_783_414e-4,
];
const MIDDLE_BOTTOM: [f64; 8] = [
    1.0,
    2.053_191_626_637_759,
    1.676_384_830_183_803_8,
    6.897_673_349_851e-1,
    1.481_039_764_274_800_8e-1,
    1.519_866_656_361_645_7e-2,
    5.475_938_084_995_345e-4,
    1.050_750_071_644_416_9e-9,
];
const FAR_TOP: [f64; 8] = [
    6.657_904_643_501_103,
    5.463_784_911_164_114,
    1.784_826_539_917_291_3,
    2.965_605_718_285_048_7e-1,
    2.653_218_952_657_612_4e-2,
    1.242_660_947_388_078_4e-3,
    2.711_555_568_743_487_6e-5,
    2.010_334_399_292_288_1e-7,
];
const FAR_BOTTOM: [f64; 8] = [
    1.0,
    5.998_322_065_558_88e-1,
    1.369_298_809_227_358e-1,
    1.487_536_129_085_061_5e-2,
    7.868_691_311_456_133e-4,
    1.846_318_317_510_054_8e-5,
    1.421_511_758_316_446e-7,
    2.044_263_103_389_939_8e-15,
];

/// Number of lattice points for [`box_probability`].
const LATTICE_POINTS: usize = 512;
/// Number of lattice points for ranking boxes of up to four components, and of more.
const ROUGH_LATTICE_POINTS: [usize; 2] = [64, 128];
/// Weight of a term below which fewer points are used: 64 points instead of 512 then change the sum by at most 1 %.
const SMALL_WEIGHT: f64 = 0.01;
/// Weight of a term for ranking below which fewer points are used, and the factor by which their number is reduced.
const ROUGH_SMALL_WEIGHT: f64 = 0.05;
const ROUGH_REDUCTION: usize = 4;

/// Probability that a normal vector with this `mean` lies between `lower` and `upper` in all components. `factor` is
/// the lower triangular factor L of its covariance L L^T, row by row, n x n; rows of zeros are exact components. Uses
/// separation of variables (A. Genz, J. Comput. Graph. Stat. 1, 141) on 512 points of a lattice: exact for one
/// component, and accurate to about 5e-4 root mean square for two to six components that are strongly correlated.
#[must_use]
pub fn box_probability(mean: &[f64], factor: &[f64], lower: &[f64], upper: &[f64]) -> f64 {
    integrate_box(mean, factor, lower, upper, LATTICE_POINTS)
}

/// [`box_probability`] for a term of a sum whose weight is at most `max_weight`: uses fewer points for small weights,
/// which leaves the accuracy of the sum unchanged.
#[must_use]
pub fn part_box_probability(mean: &[f64], factor: &[f64], lower: &[f64], upper: &[f64], max_weight: f64) -> f64 {
    let points = if max_weight < SMALL_WEIGHT { rough_points(mean) } else { LATTICE_POINTS };
    integrate_box(mean, factor, lower, upper, points)
}

/// [`box_probability`] for ranking: uses 64 points, with an error of 0.003 root mean square, and 128 points from five
/// components on, with an error of 0.01 root mean square for up to 24 components (`few_points_serve_to_rank_by`).
#[must_use]
pub fn rough_part_box_probability(mean: &[f64], factor: &[f64], lower: &[f64], upper: &[f64], max_weight: f64) -> f64 {
    let reduction = if max_weight < ROUGH_SMALL_WEIGHT { ROUGH_REDUCTION } else { 1 };
    integrate_box(mean, factor, lower, upper, rough_points(mean) / reduction)
}

fn rough_points(mean: &[f64]) -> usize {
    ROUGH_LATTICE_POINTS[usize::from(mean.len() > 4)]
}

/// Primes, whose square roots generate the lattice: a different one per component, because components with equal
/// generators would be correlated.
fn primes() -> impl Iterator<Item = u32> {
    (2..).filter(|number| (2..).take_while(|divisor| divisor * divisor <= *number).all(|divisor| number % divisor > 0))
}

fn integrate_box(mean: &[f64], factor: &[f64], lower: &[f64], upper: &[f64], points: usize) -> f64 {
    let n = mean.len();
    let ends = |row: usize, drawn: &[f64]| {
        let known: f64 = mean[row] + drawn.iter().zip(&factor[row * n..]).map(|(y, l)| y * l).sum::<f64>();
        let std = factor[row * n + row];
        [lower[row], upper[row]].map(|end| {
            if std > 0.0 {
                normal_probability((end - known) / std)
            } else if end >= known {
                1.0
            } else {
                0.0
            }
        })
    };
    if n == 0 {
        return 1.0;
    }
    let [first, last] = ends(0, &[]);
    // The lower end of an exact component counts as inside.
    let share = last - first;
    if n == 1 || share <= 0.0 {
        return share.max(0.0);
    }
    let roots: Vec<f64> = primes().take(n - 1).map(|prime| f64::from(prime).sqrt()).collect();
    let mut sum = 0.0;
    let mut drawn = vec![0.0; n];
    for point in 0..points {
        let mut product = share;
        let [mut from, mut to] = [first, last];
        for row in 1..n {
            // The baker's transform of frac(k sqrt(p) + 1/2) makes the integrand periodic.
            let x = ((point + 1) as f64 * roots[row - 1] + 0.5).fract();
            let x = (2.0 * x - 1.0).abs();
            drawn[row - 1] = normal_quantile((from + x * (to - from)).clamp(1e-300, 1.0 - 1e-16));
            [from, to] = ends(row, &drawn[..row]);
            product *= (to - from).max(0.0);
            if product == 0.0 {
                break;
            }
        }
        sum += product;
    }
    sum / points as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Normals;

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
            let draws = 200_000;
            let inside = (0..draws)
                .filter(|_| {
                    let z: Vec<f64> = (0..n).map(|_| normals.draw()).collect();
                    (0..n).all(|row| {
                        let y: f64 = mean[row] + (0..=row).map(|c| factor[row * n + c] * z[c]).sum::<f64>();
                        lower[row] <= y && y <= upper[row]
                    })
                })
                .count();
            let share = inside as f64 / f64::from(draws);
            // The error of the draws is at most 0.0011; the rest is the error of the rule.
            assert!((found - share).abs() < 0.004, "{case}: {found} {share}");
        }
    }

    /// Loads with a common factor, such as an uncertain modulus: narrow boxes, in which most draws of one component lie
    /// inside together.
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
            let factor = crate::cholesky::cholesky(&covariance, n).unwrap();
            let (lower, upper): (Vec<f64>, Vec<f64>) = ends.iter().map(|[lower, upper]| (*lower, *upper)).unzip();
            let off = box_probability(&vec![0.0; n], &factor, &lower, &upper) - exact;
            assert!(off.abs() < 3e-3, "{case} of {n}: {off} of {exact}");
            squares += off * off / 60.0;
        }
        assert!(squares.sqrt() < 1e-3, "{}", squares.sqrt());
    }

    /// Factor, mean and limits of a box of loads with common inputs, such as conditions: from narrow to wide.
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

    #[test]
    fn few_points_serve_to_rank_by() {
        let mut normals = Normals::new(11);
        let (mut squares, mut farthest) = (0.0, 0.0_f64);
        for case in 0..2000 {
            let [factor, mean, lower, upper] = of_conditions(5 + case % 20, &mut normals);
            let [rough, fine] =
                [rough_part_box_probability, part_box_probability].map(|of| of(&mean, &factor, &lower, &upper, 1.0));
            squares += (rough - fine).powi(2) / 2000.0;
            farthest = farthest.max((rough - fine).abs());
        }
        assert!(squares.sqrt() < 0.011 && farthest < 0.06, "{} {farthest}", squares.sqrt());
    }

    #[test]
    fn parts_of_little_weight_leave_no_more_of_a_sum_open() {
        let mut normals = Normals::new(13);
        let (mut exact, mut rough) = (0.0, 0.0);
        for case in 0..600 {
            let [factor, mean, lower, upper] = of_conditions(2 + case % 6, &mut normals);
            let by = |points: usize| integrate_box(&mean, &factor, &lower, &upper, points);
            let integral = by(1 << 13);
            let little = 0.99 * SMALL_WEIGHT;
            let of = |weight: f64, part: f64| (weight * (part - integral)).powi(2) / 600.0;
            exact += of(little, part_box_probability(&mean, &factor, &lower, &upper, little));
            let little = 0.99 * ROUGH_SMALL_WEIGHT;
            rough += of(little, rough_part_box_probability(&mean, &factor, &lower, &upper, little));
        }
        // Errors of a probability with 512 points, and with 64.
        assert!(exact.sqrt() < 5e-4 && rough.sqrt() < 3e-3, "{} {}", exact.sqrt(), rough.sqrt());
        assert!(exact.sqrt() > 1e-6 && rough.sqrt() > 1e-5, "{} {}", exact.sqrt(), rough.sqrt());
    }

    /// A case in which every component needs its own generator.
    #[test]
    fn boxes_of_many_conditions_hold_the_share_of_draws_too() {
        let mut normals = Normals::new(5);
        let (mut squares, mut between) = (0.0, 0);
        let cases = 24;
        for case in 0..cases {
            let n = 18 + 2 * (case % 4);
            let [factor, mean, lower, upper] = of_conditions(n, &mut normals);
            let found = box_probability(&mean, &factor, &lower, &upper);
            let draws = 10_000;
            let is_inside = |z: Vec<f64>| {
                (0..n).all(|row| {
                    let y = mean[row] + (0..=row).map(|c| factor[row * n + c] * z[c]).sum::<f64>();
                    (lower[row]..=upper[row]).contains(&y)
                })
            };
            let inside = (0..draws).filter(|_| is_inside((0..n).map(|_| normals.draw()).collect())).count();
            let share = inside as f64 / f64::from(draws);
            between += usize::from(share > 0.05 && share < 0.95);
            squares += (found - share).powi(2) / cases as f64;
        }
        // The error of the draws is at most 0.005. With twelve generators for all components the error was 0.02.
        assert!(squares.sqrt() < 0.01 && between > cases / 2, "{} {between}", squares.sqrt());
    }

    #[test]
    fn one_component_and_exact_ones_are_exact() {
        let one = box_probability(&[0.3], &[2.0], &[-1.0], &[1.0]);
        assert!((one - (normal_probability(0.35) - normal_probability(-0.65))).abs() < 1e-15);
        // y_2 = y_1: the smaller box determines the probability.
        let same = box_probability(&[0.0, 0.0], &[1.0, 0.0, 1.0, 0.0], &[-1.0, -1.0], &[1.0, 1.0]);
        assert!((same - 0.682_689_492_137_086).abs() < 1e-12);
        assert_eq!(box_probability(&[], &[], &[], &[]), 1.0);
    }
}
