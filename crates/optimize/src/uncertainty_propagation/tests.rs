use super::*;
use crate::{CommonDraws, Tolerances};
use slipgrid_pattern::{Planform, Rim, RimProfile, Texture};

fn design() -> Pattern {
    Pattern::new(Planform::Groove, 130e-6, 370e-6, 50e-6).unwrap()
}

fn uncertainty(correlation: f64, parameters: &[Vec<f64>]) -> Uncertainty {
    let tolerances =
        Tolerances { std_m: [8e-6, 13e-6, 1.3e-6], width_spacing_correlation: correlation, ..Tolerances::default() };
    Uncertainty::new(&tolerances, parameters).unwrap()
}

/// v1 = 2e-3 w + 1e-3 s + p1, v2 = 5e-3 d - p1 + 2 p2; lengths in um.
fn linear(at: &Pattern, p: &[f64]) -> Result<Vec<f64>, ModelFailure> {
    let [w, s, d] = at.lengths_m().map(|length_m| length_m * 1e6);
    Ok(vec![2e-3 * w + 1e-3 * s + p[0], 5e-3 * d - p[0] + 2.0 * p[1]])
}

/// The standard normal distribution function.
fn normal_cdf(x: f64) -> f64 {
    0.5 * libm::erfc(-x / std::f64::consts::SQRT_2)
}

const PARAMETERS: [[f64; 2]; 2] = [[4e-4, -1.5e-4], [-1.5e-4, 1e-4]];

fn parameters() -> Vec<Vec<f64>> {
    PARAMETERS.map(|row| row.to_vec()).to_vec()
}

/// Standard deviations of v1 and v2 in closed form, with the correlation r of width and spacing.
fn exact_std(r: f64) -> [f64; 2] {
    let (w, s) = (2e-3 * 8.0, 1e-3 * 13.0);
    let first: f64 = w * w + s * s + 2.0 * r * w * s + 4e-4;
    // var(-p1 + 2 p2) = c11 - 4 c12 + 4 c22
    let second: f64 = (5e-3_f64 * 1.3).powi(2) + 4e-4 + 4.0 * 1.5e-4 + 4.0 * 1e-4;
    [first.sqrt(), second.sqrt()]
}

#[test]
fn a_linear_response_scatters_normally_with_the_covariance_of_its_inputs() {
    let centre = [2e-3 * 130.0 + 0.37, 0.25];
    for correlation in [0.0, -1.0, 0.6] {
        let uncertainty = uncertainty(correlation, &parameters());
        let exact = exact_std(correlation);
        let first_order = Linearization::new(&linear, &design(), &uncertainty).unwrap();
        for (value, (std, exact)) in first_order.std(&uncertainty).iter().zip(exact).enumerate() {
            assert!((std / exact - 1.0).abs() < 1e-9, "{value}: {std} {exact}");
            assert!((first_order.values()[value] - centre[value]).abs() < 1e-12);
        }
        let draws = 20_000;
        let found = propagate(&linear, &design(), &uncertainty, draws, 7).unwrap();
        assert_eq!((found.draws(), found.failed, found.redrawn), (draws, 0, 0));
        for (value, spread) in found.spreads().into_iter().enumerate() {
            let exact_std = exact[value];
            // Four standard errors: of the mean s / sqrt(n), of s itself s / sqrt(2 n), of a 2.5 % quantile 2.67 s / sqrt(n).
            let of_mean = exact_std / (draws as f64).sqrt();
            assert!((spread.mean - centre[value]).abs() < 4.0 * of_mean);
            assert!((spread.mean_stderr / of_mean - 1.0).abs() < 0.02);
            assert!((spread.std / exact_std - 1.0).abs() < 4.0 / (2.0 * draws as f64).sqrt());
            for (end, side) in spread.band.iter().zip([-1.959_964, 1.959_964]) {
                assert!((end - centre[value] - side * exact_std).abs() < 4.0 * 2.67 * of_mean);
            }
        }
        // P(|v1 - centre| <= T) = 2 Phi(T / s) - 1
        let tolerance = 0.03;
        let within = found.probability(|values| (values[0] - centre[0]).abs() <= tolerance);
        let expected = 2.0 * normal_cdf(tolerance / exact[0]) - 1.0;
        assert!((within.share - expected).abs() < 4.0 * within.stderr, "{within:?} {expected}");
        assert!((within.stderr - (expected * (1.0 - expected) / draws as f64).sqrt()).abs() < 1e-4);
    }
}

#[test]
fn the_first_order_model_is_the_linear_one_and_its_parts_add_up() {
    let uncertainty = uncertainty(0.0, &parameters());
    let first_order = Linearization::new(&linear, &design(), &uncertainty).unwrap();
    let same = propagate(&first_order, &design(), &uncertainty, 50, 3).unwrap();
    let own = propagate(&linear, &design(), &uncertainty, 50, 3).unwrap();
    for (left, right) in same.spreads().iter().zip(own.spreads()) {
        assert!((left.mean - right.mean).abs() < 1e-12 && (left.std - right.std).abs() < 1e-12);
    }
    let of = |inputs: &[usize]| first_order.std_of(&uncertainty, &|input| inputs.contains(&input))[0];
    assert!((of(&[0]) - 0.016).abs() < 1e-12 && (of(&[3]) - 0.02).abs() < 1e-12 && of(&[2, 4]) < 1e-15);
    assert!((of(&[0, 1, 2, 3, 4]) - of(&[0]).hypot(of(&[1])).hypot(of(&[3]))).abs() < 1e-12);
}

#[test]
fn bands_and_probabilities_cover_what_they_say_over_many_seeds() {
    const SEEDS: u64 = 300;
    let uncertainty = uncertainty(0.0, &parameters());
    let (centre, std, tolerance) = (2e-3 * 130.0 + 0.37, exact_std(0.0)[0], 0.04);
    let exact = 2.0 * normal_cdf(tolerance / std) - 1.0;
    let (mut covered, mut means, mut content) = (0, 0, 0.0);
    for seed in 0..SEEDS {
        let found = propagate(&linear, &design(), &uncertainty, 400, seed).unwrap();
        let within = found.probability(|values| (values[0] - centre).abs() <= tolerance);
        covered += usize::from((within.share - exact).abs() <= 1.96 * within.stderr);
        let spread = found.spreads()[0];
        means += usize::from((spread.mean - centre).abs() <= 1.96 * spread.mean_stderr);
        let [low, high] = spread.band.map(|end| normal_cdf((end - centre) / std));
        content += (high - low) / SEEDS as f64;
    }
    // 95 % of 300 is 285 +- 3.8.
    assert!((272..=297).contains(&covered), "{covered}");
    assert!((272..=297).contains(&means), "{means}");
    // The band of 400 draws holds 95 % on average, less the few tenths that interpolated quantiles lose.
    assert!((content - 0.95).abs() < 0.006, "{content}");
}

#[test]
fn draws_that_have_no_answer_count_as_missed_and_impossible_dimensions_are_drawn_again() {
    let shallow = Pattern::new(Planform::Groove, 130e-6, 370e-6, 2.6e-6).unwrap();
    let model = |at: &Pattern, _: &[f64]| match at.depth_m() {
        // One standard deviation up.
        depth_m if depth_m > 3.9e-6 => Err(ModelFailure::Trial { reason: "closes".to_owned() }),
        depth_m => Ok(vec![depth_m]),
    };
    let uncertainty = uncertainty(0.0, &[]);
    let found = propagate(&model, &shallow, &uncertainty, 4000, 1).unwrap();
    // Phi(-2) = 0.0228 of the draws are redrawn, and of the rest 0.1587 / 0.9772 fail.
    assert!((found.redrawn as f64 / 4000.0 - 0.0233).abs() < 0.01, "{}", found.redrawn);
    assert!((found.failed as f64 / 4000.0 - 0.1624).abs() < 0.025, "{}", found.failed);
    let all = found.probability(|_| true);
    assert!((all.share + found.failed as f64 / 4000.0 - 1.0).abs() < 1e-12);
    assert!(found.spreads()[0].band[0] > 0.0);
    // All draws agree: the error does not vanish.
    let certain = propagate(&|_: &Pattern, _: &[f64]| Ok(vec![0.0]), &shallow, &uncertainty, 100, 1).unwrap();
    let within = certain.probability(|_| true);
    assert!(within.share == 1.0 && within.stderr > 0.005);

    let none = |_: &Pattern, _: &[f64]| Err(ModelFailure::Trial { reason: "never".to_owned() });
    assert_eq!(
        propagate(&none, &shallow, &uncertainty, 10, 1),
        Err(ModelFailure::Trial { reason: "never".to_owned() })
    );
    let broken = |_: &Pattern, _: &[f64]| Err(ModelFailure::Broken { reason: "broken".to_owned() });
    assert!(matches!(propagate(&broken, &shallow, &uncertainty, 10, 1), Err(ModelFailure::Broken { .. })));
}

#[test]
fn the_same_seed_gives_the_same_draws_on_any_number_of_threads() {
    let uncertainty = uncertainty(0.3, &parameters());
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| propagate(&linear, &design(), &uncertainty, 200, 5).unwrap())
    };
    assert_eq!(on(1), on(3));
    assert_ne!(on(1), propagate(&linear, &design(), &uncertainty, 200, 6).unwrap());
}

#[test]
fn a_model_that_changes_its_number_of_values_is_broken() {
    let model = |at: &Pattern, _: &[f64]| Ok(vec![1.0; if at.width_m() > 131e-6 { 1 } else { 2 }]);
    let known = uncertainty(0.0, &[]);
    let about = Linearization::new(&model, &design(), &known);
    assert!(matches!(about, Err(ModelFailure::Broken { .. })), "{about:?}");
    let drawn = propagate(&model, &design(), &known, 40, 1);
    assert!(matches!(drawn, Err(ModelFailure::Broken { .. })), "{drawn:?}");
}

/// Grooves whose rims are expected to be `height_um` high.
fn rimmed(height_um: f64) -> Pattern {
    let rim = Rim::new(height_um * 1e-6, 10e-6, RimProfile::Flat).unwrap();
    Pattern::new(Texture::new(Planform::Groove).with_rim(rim), 130e-6, 370e-6, 50e-6).unwrap()
}

/// v = 1e-3 w + 2 h + p; lengths in um.
fn by_height(at: &Pattern, p: &[f64]) -> Result<Vec<f64>, ModelFailure> {
    Ok(vec![1e-3 * at.width_m() * 1e6 + 2.0 * at.rim_height_m() * 1e6 + p[0]])
}

#[test]
fn the_height_of_rims_scatters_normally_and_half_normally_where_none_is_expected() {
    let tolerances = Tolerances { std_m: [8e-6, 0.0, 0.0], rim_height_std_m: 0.05e-6, ..Tolerances::default() };
    let known = Uncertainty::new(&tolerances, &[vec![1e-4]]).unwrap();
    let draws = 20_000;
    // (8e-3)^2 + (2 * 0.05)^2 + 1e-4
    let std = (6.4e-5_f64 + 1e-2 + 1e-4).sqrt();
    let high = Linearization::new(&by_height, &rimmed(0.5), &known).unwrap();
    assert!((high.std(&known)[0] / std - 1.0).abs() < 1e-9, "{:?}", high.std(&known));
    let found = propagate(&by_height, &rimmed(0.5), &known, draws, 7).unwrap().spreads()[0];
    assert!((found.mean - 1.13).abs() < 4.0 * found.mean_stderr && (found.std / std - 1.0).abs() < 0.02, "{found:?}");
    // Heights of |z| 0.05 um: 2 E|z| 0.05 = 0.1 sqrt(2 / pi) in the mean, and 0.1 in the root mean square.
    let none = Linearization::new(&by_height, &rimmed(0.0), &known).unwrap();
    assert!((none.std(&known)[0] / std - 1.0).abs() < 1e-9, "{:?}", none.std(&known));
    let exact = propagate(&by_height, &rimmed(0.0), &known, draws, 7).unwrap();
    let linear = propagate(&none, &rimmed(0.0), &known, draws, 7).unwrap();
    let mean = 0.13 + 0.1 * (2.0 / std::f64::consts::PI).sqrt();
    for found in [exact.spreads()[0], linear.spreads()[0]] {
        assert!((found.mean - mean).abs() < 4.0 * found.mean_stderr, "{found:?} {mean}");
    }
    // By the rims alone: |z| below 1.
    let share = CommonDraws::new(&known, draws, 7).probability_of(&none, &|input| input == 4, |v| v[0] < 0.13 + 0.1);
    assert!((share.share - 0.6827).abs() < 4.0 * share.stderr, "{share:?}");
}
