use super::super::draws::{between, chance_of, is_within};
use super::super::physics;
use super::super::truth::{Laboratory, TOLERANCE};
use super::*;

fn textures() -> Vec<Solved> {
    physics::textures(3).unwrap()
}

/// Measurements of two textures in one laboratory, their noise, and the limits of a target that both samples missed.
fn seen(textures: &[Solved], mechanism: Mechanism) -> (Vec<Seen>, f64, [[f64; LOADS]; 2]) {
    let mut laboratory = Laboratory::new(mechanism, 4, 7);
    let seen = [3, textures.len() - 1].map(|place| Seen::new(&laboratory.cut(&textures[place]).trial, place, true));
    (seen.to_vec(), laboratory.noise, between(&[0.97, 0.96, 0.95, 0.94], TOLERANCE))
}

/// Evidence and coefficients of a component agree with those from the dense covariance of all measurements, whose
/// columns are finite differences of the model.
#[test]
fn a_regression_is_what_the_dense_covariance_says() {
    const ALL: usize = 2 * LOADS;
    const { assert!(ALL == N, "the factor of so many rows") };
    let textures = textures();
    let (seen, noise, _) = seen(&textures, Mechanism::Edge);
    let generator = Generator::new(&textures, &[Mechanism::Edge, Mechanism::Rims]);
    let mut offset: Option<f64> = None;
    for of in generator.components(&seen, noise) {
        let at = |c: &Vector| -> Vector {
            let amplitude = amplitude(of.size.at + c[0], c[1], c[2]);
            let draw =
                Draw { kind: of.kind, log_modulus: of.modulus.at + c[3], amplitude, flat: [0.0; LOADS], weight: 0.0 };
            let log = |row: usize| generator.log_truth(&draw, seen[row / LOADS].place)[row % LOADS];
            std::array::from_fn(|row| log(row) - c[4 + row % LOADS])
        };
        let column = |k: usize| -> Vector {
            let [up, down] =
                [0.01, -0.01].map(|step| at(&std::array::from_fn(|own| if own == k { step } else { 0.0 })));
            std::array::from_fn(|row| (up[row] - down[row]) / 0.02)
        };
        let columns: [Vector; N] = std::array::from_fn(column);
        let none = at(&[0.0; N]);
        let mut rest: Vector = std::array::from_fn(|row| seen[row / LOADS].log[row % LOADS] - none[row]);
        // C = X S^2 X^T + s^2 1 and, within a sample, t^2 + (d L) (d L)^T
        let own = |row: usize, column: usize| {
            let log = |row: usize| DIMENSIONS_STD * seen[row / LOADS].log[row % LOADS];
            let same = if row == column { noise * noise } else { 0.0 };
            if row / LOADS == column / LOADS { SAMPLE_STD * SAMPLE_STD + log(row) * log(column) + same } else { 0.0 }
        };
        let dense: Matrix = std::array::from_fn(|row| {
            std::array::from_fn(|column| {
                let of_coefficients = |k: usize| of.std[k].powi(2) * columns[k][row] * columns[k][column];
                own(row, column) + (0..N).map(of_coefficients).sum::<f64>()
            })
        });
        let dense = cholesky(dense.as_flattened(), N).unwrap();
        solve_lower(&dense, N, &mut rest);
        let square: f64 = rest.iter().map(|x| x * x).sum();
        let evidence = -0.5 * square - (0..N).map(|row| dense[row * N + row].ln()).sum::<f64>();
        solve_upper(&dense, N, &mut rest);
        let kind = &generator.kinds[of.kind];
        let difference = of.weight - (kind.share * of.size.share * of.modulus.share).ln() - evidence;
        let offset = *offset.get_or_insert(difference);
        assert!((difference - offset).abs() < 1e-6, "{difference} {offset}");
        for (k, column) in columns.iter().enumerate() {
            // E c / S = S X^T C^-1 y
            let mean = of.std[k] * column.iter().zip(&rest).map(|(x, y)| x * y).sum::<f64>();
            assert!((mean - of.mean[k]).abs() < 1e-6, "{k}: {mean} {}", of.mean[k]);
        }
    }
}

/// Likelihood of the measurement of a sample off target, compared with the sum over its dimensions and its own scatter.
#[test]
fn a_sample_that_missed_is_as_likely_as_the_sum_over_its_scatter_says() {
    let (noise, wanted) = (0.01, between(&[0.9, 0.89, 0.88, 0.87], TOLERANCE));
    let measured = [-0.125, -0.14, -0.15, -0.138];
    let ratio = |log: [f64; LOADS]| {
        let rest: [f64; LOADS] = std::array::from_fn(|load| measured[load] - log[load]);
        let scatter = Scatter::new(&log, noise);
        let said = scatter.log_density(&rest).exp() * (1.0 - scatter.chance(&log, &rest, &wanted));
        let (mut sum, step) = (0.0, 0.02);
        let deviates = || (-250..=250).map(|place| step * f64::from(place));
        for z in deviates() {
            for t in deviates() {
                let truth = log.map(|log| (1.0 + DIMENSIONS_STD * z) * log + SAMPLE_STD * t);
                if !is_within(&truth, &wanted) {
                    let square: f64 = (0..LOADS).map(|load| ((measured[load] - truth[load]) / noise).powi(2)).sum();
                    sum += (-0.5 * (square + z * z + t * t)).exp();
                }
            }
        }
        said / sum
    };
    let ratios = [[-0.13, -0.14, -0.15, -0.16], [-0.12, -0.12, -0.13, -0.13], [-0.15; LOADS]].map(ratio);
    assert!(ratios.iter().all(|of| (of / ratios[0] - 1.0).abs() < 0.02), "{ratios:?}");
}

/// Posterior draws after a sample off target agree with prior draws weighted by the likelihood of the measurement.
#[test]
#[ignore = "five seconds: 400,000 draws of the prior, for the reference policy of laboratories alone"]
fn draws_say_what_weighted_draws_of_the_prior_say() {
    let textures = textures();
    let generator = Generator::new(&textures, &Mechanism::ALL);
    let (seen, _, wanted) = seen(&textures, Mechanism::Depth);
    let seen = &seen[1..];
    // So large that the prior's draws are not all alike unlikely.
    let noise = 0.06;
    let found = generator.draws(seen, noise, &wanted, 16_384);
    // Flat errors of a draw are those of this noise.
    let mut prior = generator.draws(&[], noise, &wanted, 400_000).all;
    for draw in &mut prior {
        draw.weight = draw.weight.ln();
        for at in seen {
            let log = generator.log_truth(draw, at.place);
            let rest = std::array::from_fn(|load| at.log[load] - log[load] + draw.flat[load]);
            let scatter = Scatter::new(&log, noise);
            let missed = if at.is_missed { 1.0 - scatter.chance(&log, &rest, &wanted) } else { 1.0 };
            draw.weight += scatter.log_density(&rest) + missed.ln();
        }
    }
    let weighted = Draws::new(prior);
    assert!(
        found.effective() > 4000.0 && weighted.effective() > 400.0,
        "{} {}",
        found.effective(),
        weighted.effective()
    );
    let error = (1.0 / found.effective() + 1.0 / weighted.effective()).sqrt();
    let moments = |of: &Draws, value: &dyn Fn(&Draw) -> f64| {
        let mean: f64 = of.all.iter().map(|draw| draw.weight * value(draw)).sum();
        let square: f64 = of.all.iter().map(|draw| draw.weight * value(draw).powi(2)).sum();
        (mean, (square - mean * mean).sqrt())
    };
    let same = |name: &str, value: &dyn Fn(&Draw) -> f64| {
        let ((a, std), (b, _)) = (moments(&weighted, value), moments(&found, value));
        assert!((a - b).abs() <= 4.0 * error * std, "{name}: {a} {b}, {}", error * std);
    };
    same("modulus", &|draw| draw.log_modulus);
    for load in 0..LOADS {
        same("size", &|draw| draw.amplitude[load]);
        same("flat", &|draw| draw.flat[load]);
    }
    for kind in 0..generator.kinds.len() {
        same("mechanism", &|draw| if draw.kind == kind { 1.0 } else { 0.0 });
    }
    for place in (0..textures.len()).step_by(7) {
        same("chance", &|draw| chance_of(&generator.log_truth(draw, place), &wanted));
    }
}

/// Mean and scatter of the true ratios of laboratories agree with those of prior draws.
#[test]
fn laboratories_are_made_as_the_draws_of_the_prior() {
    let textures = textures();
    let place = textures.len() / 2;
    for mechanism in Mechanism::ALL {
        let generator = Generator::new(&textures, &[mechanism]);
        let draws = generator.draws(&[], 0.01, &[[f64::NEG_INFINITY; LOADS], [f64::INFINITY; LOADS]], 20_000);
        let drawn: Vec<(f64, f64)> =
            draws.all.iter().map(|draw| (draw.weight, generator.log_truth(draw, place)[1])).collect();
        let count = 4000;
        let truths = (0..count).map(|number| Laboratory::new(mechanism, number, 5).truth(&textures[place])[1].ln());
        let made: Vec<(f64, f64)> = truths.map(|log| (1.0 / count as f64, log)).collect();
        let moments = |of: &[(f64, f64)]| {
            let mean: f64 = of.iter().map(|(weight, x)| weight * x).sum();
            (mean, of.iter().map(|(weight, x)| weight * (x - mean).powi(2)).sum::<f64>().sqrt())
        };
        let ((mean, std), (of_made, std_made)) = (moments(&drawn), moments(&made));
        let error = std * (1.0 / count as f64 + 1.0 / draws.effective()).sqrt();
        assert!((mean - of_made).abs() < 4.0 * error, "{mechanism:?}: {mean} {of_made} {error}");
        assert!((std_made / std - 1.0).abs() < 0.06, "{mechanism:?}: {std} {std_made}");
    }
}
