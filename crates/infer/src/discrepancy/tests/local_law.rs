//! Tests of lambda, the effect of local pressure on friction, against closed forms and the dense covariance.

use super::*;

const MODULUS_STD: f64 = 0.2;
const NOISE: f64 = 0.01;

fn trial(features: Features, sensitivity: [Sensitivity; 2], log_excess: [f64; 2]) -> Trial {
    let at = |((load, sensitivity), log)| Measured { flat_std: 0.0, ..measured(load, log, NOISE, sensitivity) };
    cut("", features, two_loads().into_iter().zip(sensitivity).zip(log_excess).map(at).collect())
}

fn changes(modulus: [f64; 2], local_law: [f64; 2]) -> [Sensitivity; 2] {
    [0, 1].map(|load| Sensitivity { modulus: modulus[load], local_law: local_law[load] })
}

/// Compares with N(y; m, K), K in closed form: alpha h, eps g, lambda d, t and measurement errors.
#[test]
fn lambda_is_learned_as_the_dense_covariance_says() {
    let hyper = amplitude_alone();
    let textures = [groove(100.0, 300.0, 10.0), groove(60.0, 120.0, 10.0), groove(200.0, 500.0, 10.0)];
    let sensitivity = [
        changes([0.05, 0.07], [0.11, 0.06]),
        changes([0.09, 0.10], [-0.03, 0.20]),
        changes([0.02, 0.03], [0.15, -0.05]),
    ];
    let excess = [[-0.1, -0.12], [-0.2, 0.05]];
    let form = |of: &Features| of.areal_density / hyper.reference.areal_density;
    let (sample, load) = (|row: usize| row / 2, |row: usize| row % 2);
    let at = |row: usize| sensitivity[sample(row)][load(row)];
    let prior = |i: usize, j: usize| {
        let h = form(&textures[sample(i)]) * form(&textures[sample(j)]);
        let t = if sample(i) == sample(j) { hyper.sample_std.powi(2) } else { 0.0 };
        h * hyper.amplitude_std.powi(2)
            + MODULUS_STD.powi(2) * at(i).modulus * at(j).modulus
            + 0.25 * at(i).local_law * at(j).local_law
            + t
    };
    // Before any trial, half of the change is expected, and known to half of it.
    for n in [0, 4] {
        let trials = (0..n / 2).map(|place| trial(textures[place], sensitivity[place], excess[place])).collect();
        let learned = learned(hyper.clone(), trials);
        let inner: Vec<f64> =
            (0..n * n).map(|e| prior(e / n, e % n) + if e / n == e % n { NOISE * NOISE } else { 0.0 }).collect();
        let factor = cholesky(&inner, n).unwrap();
        let solve = |mut values: Vec<f64>| {
            solve_lower(&factor, n, &mut values);
            solve_upper(&factor, n, &mut values);
            values
        };
        let y = solve((0..n).map(|row| excess[sample(row)][load(row)] - 0.5 * at(row).local_law).collect());
        let conditional = |column: &dyn Fn(usize) -> f64, other: &dyn Fn(usize) -> f64| {
            let solved = solve((0..n).map(column).collect());
            let mean: f64 = (0..n).map(|row| column(row) * y[row]).sum();
            (mean, (0..n).map(|row| other(row) * solved[row]).sum::<f64>())
        };

        let (mean, covariance) = learned.at(&two_loads()).predict(&textures[2], &sensitivity[2]).mixed();
        for (l, m) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let (own, explained) = conditional(&|row| prior(row, 4 + l), &|row| prior(row, 4 + m));
            assert!((mean[l] - 0.5 * at(4 + l).local_law - own).abs() < 1e-12, "{l}: {} {own}", mean[l]);
            let expected = prior(4 + l, 4 + m) - explained;
            assert!((covariance[2 * l + m] - expected).abs() < 1e-12, "{l} {m}: {} {expected}", covariance[2 * l + m]);
        }
        // cov(lambda, y_i) = d_i / 4
        let of_lambda = |row: usize| 0.25 * at(row).local_law;
        let (own, explained) = conditional(&of_lambda, &of_lambda);
        let (mean, std) = learned.local_law();
        assert!((mean - 0.5 - own).abs() < 1e-12 && (std * std - 0.25 + explained).abs() < 1e-12, "{mean} {std}");
        assert!(n == 0 || std < 0.4, "{std}");
    }
}

/// Tests all forms, scales and scatters, at a texture with realistic measurement errors.
#[test]
fn a_trial_moves_lambda_to_the_law_that_it_was_measured_by() {
    let change = [0.12, 0.05];
    let moved = |log_excess: [f64; 2]| {
        let of = trial(groove(100.0, 200.0, 10.0), changes([0.03, 0.03], change), log_excess);
        discrepancy(vec![of]).local_law()
    };
    let (by_local, by_nominal, between) = (moved(change), moved([0.0; 2]), moved(change.map(|own| 0.5 * own)));
    assert!(by_local.0 > 0.55 && by_nominal.0 < 0.45, "{by_local:?} {by_nominal:?}");
    assert!((between.0 - 0.5).abs() < 1e-12 && between.1 < 0.5, "{between:?}");
    let (mean, std) = discrepancy(Vec::new()).local_law();
    assert!((mean - 0.5).abs() < 1e-12 && (std - 0.5).abs() < 1e-12, "{mean} {std}");
}

#[test]
fn truths_and_what_is_left_out_count_lambda() {
    let of = trial(groove(100.0, 300.0, 10.0), changes([0.05, 0.07], [0.10, 0.20]), [-0.05, 0.02]);
    let learned = discrepancy(vec![of]);
    let (features, sensitivity) = (groove(120.0, 240.0, 10.0), changes([0.05, 0.06], [0.25, 0.15]));
    let candidate = Candidate {
        features,
        modelled: &[0.9, 0.85],
        sensitivity: &sensitivity,
        covariance: &[],
        dimension_shifts: &[],
    };
    let wanted = Wanted { lower: vec![0.85, 0.8], upper: vec![1.0, 1.0] };
    let chance = wanted.score(&learned.at(&two_loads()).of(&candidate), candidate.modelled).chance;
    let on = Scenarios::new(&learned, 8000, 1).on_target(&candidate, &two_loads(), &wanted, 0);
    let share = on.iter().filter(|on| **on).count() as f64 / 8000.0;
    assert!((share - chance).abs() < 0.02 && chance > 0.2 && chance < 0.8, "{share} {chance}");
    // Without others, a trial is predicted by the prior, which includes half of the change.
    let found = leave_out(&learned, LeftOut::Trial, &Unwatched).unwrap();
    for (surprise, change) in found.iter().zip([0.10, 0.20]) {
        assert!((surprise.median - 0.5 * change).abs() < 1e-9, "{surprise:?}");
    }
}
