use std::sync::atomic::AtomicBool;

use slipgrid_base::monitor::{Cancelled, Unwatched};
use slipgrid_base::statistics::cholesky::{
    cholesky, covariance_factor, dot, log_determinant, solve_lower, solve_upper,
};
use slipgrid_base::statistics::{BoxRule, Normals, normal_probability, normal_quantile};
use slipgrid_model::pattern::{Pattern, Planform};

use super::*;

mod chances;
mod come_true;
mod joint;
mod local_law;
mod made;
mod scatter;

/// Features of a groove of this width, spacing and depth, in um.
pub fn groove(width_um: f64, spacing_um: f64, depth_um: f64) -> Features {
    let [width_m, spacing_m, depth_m] = [width_um, spacing_um, depth_um].map(|length| length * 1e-6);
    Features::from(&Pattern::new(Planform::Groove, width_m, spacing_m, depth_m).unwrap())
}

fn load(pressure_mpa: f64, speed_mm_s: f64, humidity_pct: f64) -> Load {
    Load { pressure_pa: pressure_mpa * 1e6, speed_m_s: speed_mm_s * 1e-3, humidity: humidity_pct / 100.0 }
}

fn loads() -> Vec<Load> {
    [0.65, 1.3, 1.95, 2.6].map(|pressure_mpa| load(pressure_mpa, 2.0, 40.0)).to_vec()
}

/// Two loads at which dimensions and the local law have effects.
fn two_loads() -> [Load; 2] {
    [0.8, 2.2].map(|pressure_mpa| load(pressure_mpa, 2.0, 40.0))
}

/// Measurement of a modelled ratio of 0.9 with the discrepancy `log`, and with relative errors `std` of both samples.
pub fn measured(load: Load, log: f64, std: f64, sensitivity: Sensitivity) -> Measured {
    let (patterned_std, flat_std) = (std, std);
    Measured { load, measured: 0.9 * log.exp(), modelled: 0.9, patterned_std, flat_std, sensitivity }
}

/// Trial of a sample with exact dimensions, on a separate disc.
pub fn cut(name: &str, features: Features, measured: Vec<Measured>) -> Trial {
    Trial {
        name: name.to_owned(),
        features,
        sample_std: None,
        disc: None,
        measured,
        dimensions_std_m: [0.0; 3],
        dimension_shifts: Vec::new(),
    }
}

/// Trial with the true discrepancy `truth` at each of `loads`, measured with `noise` of each kind.
fn trial(name: &str, features: Features, loads: &[Load], noise: f64, truth: &mut dyn FnMut(usize) -> f64) -> Trial {
    let sensitivity = |place: usize| Sensitivity::of_modulus(0.1 + 0.02 * place as f64);
    let at = |(place, load): (usize, &Load)| measured(*load, truth(place), noise, sensitivity(place));
    cut(name, features, loads.iter().enumerate().map(at).collect())
}

/// Error of a dimension that changes the modelled ratio only.
fn physics_alone(features: Features, log_ratio: Vec<f64>) -> DimensionShift {
    DimensionShift { log_ratio, above: features, below: None }
}

/// Sensitivities of textures to Young's modulus only.
fn moduli<const N: usize>(slopes: [f64; N]) -> [Sensitivity; N] {
    slopes.map(Sensitivity::of_modulus)
}

fn discrepancy(trials: Vec<Trial>) -> Discrepancy {
    learned(Hyperparameters::default(), trials)
}

/// Discrepancy with a relative error of Young's modulus of 0.2.
fn learned(hyper: Hyperparameters, trials: Vec<Trial>) -> Discrepancy {
    Discrepancy::new(hyper, Conditions::default(), 0.2, trials).unwrap()
}

/// Discrepancy for an exact Young's modulus.
fn learned_exactly(hyper: Hyperparameters, trials: Vec<Trial>) -> Discrepancy {
    Discrepancy::new(hyper, Conditions::default(), 0.0, trials).unwrap()
}

/// Prior in which the texture has an effect for certain.
fn of_an_effect() -> Hyperparameters {
    let mut hyper = Hyperparameters::default();
    hyper.forms.retain(|(form, _)| *form != Form::None);
    let sum: f64 = hyper.forms.iter().map(|(_, weight)| weight).sum();
    hyper.forms.iter_mut().for_each(|(_, weight)| *weight /= sum);
    hyper
}

/// Prior with one form of one size, without residual.
fn one_form() -> Hyperparameters {
    let one = vec![(1.0, 1.0)];
    Hyperparameters {
        scales: one.clone(),
        residuals: vec![(0.0, 1.0)],
        scatters: one,
        forms: vec![(Form::Density, 1.0)],
        ..Hyperparameters::default()
    }
}

/// Prior with one form that has an amplitude only, for closed forms and one-dimensional integrals.
fn amplitude_alone() -> Hyperparameters {
    Hyperparameters { pressure_std: 0.0, inverse_pressure_std: 0.0, speed_std: 0.0, humidity_std: 0.0, ..one_form() }
}

fn prior() -> Discrepancy {
    discrepancy(Vec::new())
}

#[test]
fn without_cavities_there_is_no_discrepancy() {
    let trials = vec![trial("A", groove(100.0, 300.0, 10.0), &loads(), 0.01, &mut |_| -0.2)];
    for known in [Vec::new(), trials].map(|trials| learned(of_an_effect(), trials)) {
        let own = known.sample_std();
        let nothing = Features { areal_density: 0.0, edge_1_m: 0.0, ..groove(100.0, 300.0, 10.0) };
        let mut last = f64::INFINITY;
        // Ever fewer grooves, finally none; the scatter of a sample remains.
        for features in [1e2, 1e5, 1e8].map(|spacing_um| groove(100.0, spacing_um, 10.0)).into_iter().chain([nothing]) {
            let (mean, std) = known.at(&loads()).predict(&features, &moduli([0.0; 4])).moments(2);
            let off = mean.abs() + (std * std - own * own).abs();
            assert!(off < last || off == 0.0, "{off} after {last}");
            last = off;
        }
        assert!(last <= 1e-12, "{last}");
    }
}

#[test]
fn before_any_trial_the_prior_is_what_is_believed() {
    let hyper = Hyperparameters::default();
    let at = load(1.5, 2.0, 40.0);
    let found = prior().at(&[at]).predict(&hyper.reference, &moduli([0.3]));
    let (mean, std) = found.moments(0);
    // q = 0.65 / 1.5; every form is 1 at the reference, and the residual has the variance of alpha times its size.
    let q: f64 = 0.65 / 1.5;
    let mean_square = |all: &[(f64, f64)]| all.iter().map(|(size, weight)| weight * size * size).sum::<f64>();
    let of_form = 0.2_f64.powi(2) * (1.0 + mean_square(&hyper.residuals)) + (0.08 * q).powi(2) + 0.06_f64.powi(2);
    let scatter = (0.7 + 0.2 * 0.0625 + 0.07 * 9.0 + 0.03 * 100.0) * 0.02_f64.powi(2);
    // No effect has the weight 0.05.
    let variance = 0.95 * mean_square(&hyper.scales) * of_form + (0.2 * 0.3_f64).powi(2) + scatter;
    assert!(mean.abs() < 1e-15 && (std * std / variance - 1.0).abs() < 1e-12, "{mean} {std}");
    // A mixture of scales has more weight in the middle and in the tails than one normal distribution.
    assert!(found.quantile(0, 0.995) > 2.6 * std && found.quantile(0, 0.75) < 0.67 * std);
    assert!((prior().forms().iter().map(|of| of.weight).sum::<f64>() - 1.0).abs() < 1e-12);
    assert!((prior().sample_std() - scatter.sqrt()).abs() < 1e-15);
}

/// Tests that regression of the coefficients and conditioning of the measurements give one answer.
#[test]
fn coefficients_and_measurements_say_the_same() {
    let mut normals = Normals::new(3);
    let textures = [groove(100.0, 300.0, 10.0), groove(40.0, 90.0, 25.0), groove(210.0, 160.0, 4.0)];
    let places: Vec<Vec<Load>> = [[0.65, 15.0], [1.3, 40.0], [2.6, 60.0]]
        .map(|[pressure, humidity]| [2.0, 5.0].map(|speed| load(pressure, speed, humidity)).to_vec())
        .to_vec();
    let all: Vec<Trial> = textures
        .iter()
        .zip(&places)
        .enumerate()
        .map(|(place, (features, loads))| {
            let mut of = trial(&place.to_string(), *features, loads, 0.01, &mut |_| -0.1 + 0.05 * normals.draw());
            of.dimension_shifts = vec![physics_alone(*features, vec![0.01, 0.012])];
            for (at, change) in of.measured.iter_mut().zip([0.08, -0.03]) {
                at.sensitivity.local_law = change;
            }
            of
        })
        .collect();
    let left = leave_out(&discrepancy(all.clone()), LeftOut::TrialAndLater, &Unwatched).unwrap();
    for last in 0..3 {
        let known = discrepancy(all[..last].to_vec());
        let wanted = &all[last];
        // Measurement errors: of the sample, of the flat sample and of the dimensions.
        let mut errors = vec![0.0; 4];
        for l in 0..2 {
            for m in 0..2 {
                errors[2 * l + m] = wanted.dimension_shifts[0].log_ratio[l] * wanted.dimension_shifts[0].log_ratio[m];
            }
            errors[3 * l] += 2.0 * 0.01_f64.powi(2);
        }
        let sensitivity: Vec<Sensitivity> = wanted.measured.iter().map(|at| at.sensitivity).collect();
        let found = known.at(&places[last]).predict(&wanted.features, &sensitivity).with(&errors);
        for row in 0..2 {
            let other = left.iter().find(|of| (of.trial, of.row) == (last, row)).unwrap();
            for (p, expected) in [(0.5, other.median), (0.025, other.interval_95[0]), (0.84, other.interval_68[1])] {
                assert!((found.quantile(row, p) - expected).abs() < 1e-9, "{last} {row} {p}");
            }
        }
    }
}

/// Compares with N(y; 0, K) by the dense covariance of the measurements, for each form.
#[test]
fn weights_are_prior_times_evidence() {
    let of = |truth: f64| [-0.2, -0.21, -0.19, -0.2].map(move |off: f64| off * truth);
    let (first, second) = (of(1.0), of(0.5));
    let found = discrepancy(vec![
        trial("A", groove(100.0, 300.0, 10.0), &loads(), 0.01, &mut |place| first[place]),
        trial("B", groove(60.0, 420.0, 10.0), &loads(), 0.01, &mut |place| second[place]),
    ]);
    let rows: Vec<_> = found.rows().collect();
    let n = rows.len();
    let evidences: Vec<f64> = found
        .members()
        .iter()
        .map(|member| {
            let noise = found.noise(member.scatter, &|_, _| 0.0);
            let phi = found.basis_rows(member);
            let dense: Vec<f64> = (0..n * n).map(|e| noise[e] + dot(&phi[e / n], &phi[e % n])).collect();
            let factor = cholesky(&dense, n).unwrap();
            let mut y: Vec<f64> = rows.iter().map(|(_, at)| at.log_excess()).collect();
            solve_lower(&factor, n, &mut y);
            member.prior * (-0.5 * (dot(&y, &y) + log_determinant(&factor, n))).exp()
        })
        .collect();
    let sum: f64 = evidences.iter().sum();
    for (own, evidence) in found.members().iter().zip(evidences) {
        assert!((own.weight - evidence / sum).abs() < 1e-10, "{:?}", own.form);
    }
}

/// Tests trials generated by a form of the mixture: its family wins, and textures without trials are predicted.
#[test]
fn a_hidden_mechanism_is_found() {
    let textures = [
        groove(100.0, 300.0, 10.0),
        groove(30.0, 370.0, 10.0),
        groove(200.0, 300.0, 10.0),
        groove(20.0, 30.0, 10.0),
        groove(200.0, 200.0, 30.0),
        groove(60.0, 60.0, 3.0),
    ];
    let unseen = [groove(150.0, 350.0, 20.0), groove(40.0, 360.0, 5.0), groove(25.0, 75.0, 12.0)];
    for form in [Form::Density, Form::Edge, Form::Saturating { scale: 0.08 }, Form::DepthDensity { scale_m: 10e-6 }] {
        let truth = |of: &Features| -0.08 * form.value(of) / form.value(&Hyperparameters::default().reference);
        let mut normals = Normals::new(11);
        let all: Vec<Trial> = textures
            .iter()
            .map(|of| trial("", *of, &loads(), 0.005, &mut |_| truth(of) + 0.007 * normals.draw()))
            .collect();
        let found = discrepancy(all);
        let share: f64 = found.forms().iter().filter(|of| of.form.family() == form.family()).map(|of| of.weight).sum();
        assert!(share > 0.8, "{form:?}: {share}");
        for of in &unseen {
            let prediction = found.at(&loads()).predict(of, &moduli([0.1; 4]));
            let (mean, std) = prediction.moments(1);
            assert!((mean - truth(of)).abs() < 3.0 * std && std < 0.05, "{form:?} {mean} {std} {}", truth(of));
        }
    }
}

#[test]
fn the_order_of_trials_changes_nothing_but_rounding() {
    let mut all = Vec::new();
    for (place, texture) in [groove(100.0, 300.0, 10.0), groove(30.0, 100.0, 5.0)].into_iter().enumerate() {
        all.push(trial("", texture, &loads(), 0.01, &mut |row| -0.1 - 0.02 * (place + row) as f64));
    }
    let forward = discrepancy(all.clone()).at(&loads()).predict(&groove(50.0, 200.0, 8.0), &moduli([0.1; 4]));
    all.reverse();
    let backward = discrepancy(all).at(&loads()).predict(&groove(50.0, 200.0, 8.0), &moduli([0.1; 4]));
    for load in 0..4 {
        assert!((forward.quantile(load, 0.5) - backward.quantile(load, 0.5)).abs() < 1e-10);
    }
}

#[test]
fn a_flat_sample_measured_once_is_off_alike_in_all_trials() {
    // Two trials of one condition differ by measurement errors alone; at different conditions also by both flat samples.
    let shared = |second: Load| {
        let first = load(1.3, 2.0, 40.0);
        let textures = [groove(100.0, 300.0, 10.0), groove(100.0, 300.0, 10.0)];
        let all = textures.iter().zip([first, second]).map(|(of, at)| trial("", *of, &[at], 0.03, &mut |_| -0.2));
        let hyper = Hyperparameters { sample_std: 0.005, ..Hyperparameters::default() };
        let known = learned(hyper, all.collect());
        known.at(&[first]).predict(&textures[0], &moduli([0.1])).moments(0).1
    };
    let (same, other) = (shared(load(1.3, 2.0, 40.0)), shared(load(1.3, 2.000_1, 40.0)));
    assert!(same > 1.1 * other, "{same} {other}");
}

/// Tests one coefficient of variance A^2 and two trials of one texture, each with disc variance s^2 and individual
/// variance e^2.
#[test]
fn two_trials_of_one_disc_tell_less_of_the_mean_and_more_of_their_difference() {
    let (a2, s2, e2) = (0.2_f64.powi(2), 0.03_f64.powi(2), 0.01_f64.powi(2));
    let hyper = Hyperparameters { sample_std: s2.sqrt(), ..amplitude_alone() };
    let (at, texture) = ([load(1.3, 2.0, 40.0)], hyper.reference);
    let both_on = |disc: [Option<&str>; 2]| {
        let of = |(place, disc): (usize, Option<&str>)| {
            let mut cut = trial(&place.to_string(), texture, &at, e2.sqrt(), &mut |_| -0.1);
            cut.measured[0].flat_std = 0.0;
            Trial { disc: disc.map(str::to_owned), ..cut }
        };
        learned_exactly(hyper.clone(), disc.into_iter().enumerate().map(of).collect())
    };
    // A third sample, on a separate disc: 1 / (1 / A^2 + 1 / V) + s^2, V the variance of the mean of the two.
    let third = |known: &Discrepancy| known.at(&at).predict(&texture, &moduli([0.0])).moments(0).1.powi(2);
    let expected = |mean: f64| 1.0 / (1.0 / a2 + 1.0 / mean) + s2;
    // The second given the first: K - C^2 / K with K = A^2 + s^2 + e^2 and C their covariance.
    let second = |known: &Discrepancy| {
        let all = leave_out(known, LeftOut::TrialAndLater, &Unwatched).unwrap();
        let [low, high] = all.iter().find(|of| of.trial == 1).unwrap().interval_95;
        ((high - low) / (2.0 * normal_quantile(0.975))).powi(2)
    };
    let k = a2 + s2 + e2;
    let [apart, together] = ["B", "A"].map(|second| both_on([Some("A"), Some(second)]));
    for (known, mean, shared) in [(&together, s2 + e2 / 2.0, a2 + s2), (&apart, (s2 + e2) / 2.0, a2)] {
        assert!((third(known) / expected(mean) - 1.0).abs() < 1e-10, "{} {}", third(known), expected(mean));
        assert!((second(known) / (k - shared * shared / k) - 1.0).abs() < 1e-8, "{}", second(known));
    }
    assert!(third(&together) > 1.3 * third(&apart) && second(&together) < 0.2 * second(&apart));
    // Trials without a disc name have separate discs.
    for other in [[None, None], [Some("A"), None]] {
        assert_eq!(third(&both_on(other)).to_bits(), third(&apart).to_bits());
    }
}

/// Friction of the texture of a trial, at its load, against flat friction known to f from the sample of the trial: with
/// the amplitude a, x the error of flat friction, y = a + x + t + e of the trial, and v = a + x + t' of another sample.
#[test]
fn friction_shares_the_flat_sample_with_the_trial() {
    let (a2, f2, s2, e2) = (0.2_f64.powi(2), 0.09_f64.powi(2), 0.03_f64.powi(2), 0.01_f64.powi(2));
    let hyper = Hyperparameters { sample_std: s2.sqrt(), ..amplitude_alone() };
    let (at, texture) = ([load(1.3, 2.0, 40.0)], hyper.reference);
    let mut cut = trial("", texture, &at, e2.sqrt(), &mut |_| -0.1);
    cut.measured[0].flat_std = f2.sqrt();
    let y = cut.measured[0].log_excess();
    let known = learned_exactly(hyper, vec![cut]);
    let (shares, rest) = known.flat_shares(&[vec![f2, f2], vec![f2, f2]], 1);
    assert!((shares[0][0] - f2.sqrt()).abs() < 1e-15 && rest[0][0].abs() < 1e-15, "{shares:?} {rest:?}");
    // A coefficient less certain than the flat sample has further errors of its own.
    let (less, more) = known.flat_shares(&[vec![4.0 * f2; 2], vec![4.0 * f2; 2]], 1);
    assert!((less[0][0] - f2.sqrt()).abs() < 1e-15 && (more[0][0] - 3.0 * f2).abs() < 1e-15, "{less:?} {more:?}");
    // Prior variance p of what a sample and the trial share, and s^2 + e^2 of what they do not.
    let given = |p: f64| p - p * p / (p + s2 + e2) + s2;
    let (none, predictor) = (moduli([0.0]), known.of_friction_at(&at, &shares));
    let candidate =
        Candidate { features: texture, modelled: &[0.9], sensitivity: &none, covariance: &[], dimension_shifts: &[] };
    let (mean, std) = predictor.of(&candidate).moments(0);
    let expected = (a2 + f2) / (a2 + f2 + s2 + e2) * y;
    assert!((mean - expected).abs() < 1e-12 && (std * std - given(a2 + f2)).abs() < 1e-12, "{mean} {std}");
    // The ratio shares the amplitude alone: p^2 is that of the amplitude, and the flat sample is noise.
    let of_ratio = known.at(&at).of(&candidate).moments(0).1;
    assert!((of_ratio * of_ratio - (a2 - a2 * a2 / (a2 + f2 + s2 + e2) + s2)).abs() < 1e-12, "{of_ratio}");
    let of_flat = predictor.of_known(&candidate, Unknown::Flat).moments(0).1;
    assert!((of_flat * of_flat - given(a2)).abs() < 1e-12, "{of_flat}");
    let of_form = predictor.of_known(&candidate, Unknown::Form).moments(0).1;
    assert!((of_form * of_form - given(f2)).abs() < 1e-12, "{of_form}");
    let drawn = Scenarios::new(&known, 8000, 1).of_friction(&shares).log_excesses(&candidate, &at, 0);
    let square = drawn.iter().map(|of| (of[0] - mean).powi(2)).sum::<f64>() / 8000.0;
    assert!((square / (std * std) - 1.0).abs() < 0.06, "{square} {std}");
}

/// With v = a + g x, of which a trial says the sum: given the amplitude a, it says g x, and given x it says a.
#[test]
fn what_is_known_leaves_to_the_rest_what_the_trial_says() {
    let (a2, s2, e2) = (0.2_f64.powi(2), 0.03_f64.powi(2), 0.01_f64.powi(2));
    let hyper = Hyperparameters { sample_std: s2.sqrt(), ..amplitude_alone() };
    let (at, texture) = ([load(1.3, 2.0, 40.0)], hyper.reference);
    let law = Sensitivity { modulus: 0.0, local_law: 0.3 };
    let g2 = (0.3 * learned(hyper.clone(), Vec::new()).local_law().1).powi(2);
    for (sensitivity, x2, unknown) in
        [(Sensitivity::of_modulus(-0.5), 0.1_f64.powi(2), Unknown::Modulus), (law, g2, Unknown::LocalLaw)]
    {
        let patterned = Measured { flat_std: 0.0, ..measured(at[0], -0.1, e2.sqrt(), sensitivity) };
        let cut = cut("", texture, vec![patterned]);
        let known = learned(hyper.clone(), vec![cut]);
        let own = [sensitivity];
        let candidate = Candidate {
            features: texture,
            modelled: &[0.9],
            sensitivity: &own,
            covariance: &[],
            dimension_shifts: &[],
        };
        let given = |p: f64| p - p * p / (p + s2 + e2) + s2;
        let variance = |of: Distribution| of.moments(0).1.powi(2);
        let predictor = known.at(&at);
        for (found, expected) in [
            (predictor.of(&candidate), given(a2 + x2)),
            (predictor.of_known(&candidate, Unknown::Form), given(x2)),
            (predictor.of_known(&candidate, unknown), given(a2)),
        ] {
            let found = variance(found);
            assert!((found / expected - 1.0).abs() < 1e-9, "{unknown:?} {found} {expected}");
        }
    }
}

/// Without an effect of the texture, no trial moves a prediction: samples scatter.
#[test]
fn without_an_effect_samples_scatter_alone() {
    let hyper = Hyperparameters { forms: vec![(Form::None, 1.0)], ..Hyperparameters::default() };
    let far = groove(20.0, 10.0, 30.0);
    let wider = DimensionShift { log_ratio: vec![0.03; 4], above: groove(21.0, 9.0, 30.0), below: None };
    let trials = [-0.2, 0.1].map(|log| trial("", groove(100.0, 300.0, 10.0), &loads(), 0.01, &mut |_| log));
    for trials in [Vec::new(), trials.to_vec()] {
        let known = learned_exactly(hyper.clone(), trials);
        assert_eq!(known.members().len(), hyper.scatters.len());
        let own = known.sample_std().powi(2);
        let found = known.at(&loads()).predict_made(&far, &moduli([0.0; 4]), std::slice::from_ref(&wider));
        let (mean, std) = found.moments(1);
        assert!(mean == 0.0 && (std * std - own - 0.03_f64.powi(2)).abs() < 1e-15, "{mean} {std} {own}");
        let scenarios = Scenarios::new(&known, 2000, 1);
        let candidate = Candidate {
            features: far,
            modelled: &[0.9; 4],
            sensitivity: &moduli([0.0; 4]),
            covariance: &[],
            dimension_shifts: &[],
        };
        let square =
            scenarios.log_excesses(&candidate, &loads(), 0).iter().map(|of| of[2] * of[2]).sum::<f64>() / 2000.0;
        assert!((square / own - 1.0).abs() < 0.2, "{square} {own}");
    }
}

/// Compares with N(y; 0, K) conditioned on the measurements:
/// K = A^2 + B^2 u u' + S^2 s s' + (N^2 + G^2 q q') exp(-(H - H')^2 / (2 0.25^2)).
#[test]
fn effects_of_low_loads_belong_to_a_humidity() {
    let hyper = one_form();
    let at = [load(0.65, 2.0, 15.0), load(2.6, 2.0, 15.0), load(0.65, 4.0, 80.0), load(1.3, 2.0, 80.0)];
    let (log, noise, t) = ([-0.1, -0.2, -0.27, -0.22], 0.01_f64, hyper.sample_std);
    let measured = trial("", hyper.reference, &at, noise, &mut |row| log[row]);
    let known = learned_exactly(hyper, vec![measured]);
    let covariance = |a: &Load, b: &Load| {
        let both = |of: fn(&Load) -> f64| of(a) * of(b);
        let humidity = (-0.5 * ((a.humidity - b.humidity) / 0.25).powi(2)).exp();
        0.2_f64.powi(2)
            + 0.06_f64.powi(2) * both(|at| (at.pressure_pa - 1.5e6) / 1.5e6)
            + 0.05_f64.powi(2) * both(|at| (at.speed_m_s / 2e-3).ln())
            + (0.06_f64.powi(2) + 0.08_f64.powi(2) * both(|at| 0.65e6 / at.pressure_pa)) * humidity
    };
    let n = at.len();
    let noise = |e: usize| if e.is_multiple_of(n + 1) { t * t + 2.0 * noise * noise } else { t * t };
    let all: Vec<f64> = (0..n * n).map(|e| covariance(&at[e / n], &at[e % n]) + noise(e)).collect();
    let factor = cholesky(&all, n).unwrap();
    let solved = |mut of: Vec<f64>| {
        solve_lower(&factor, n, &mut of);
        of
    };
    let y = solved(log.to_vec());
    for to in [at[0], load(0.65, 2.0, 40.0), load(5.0, 1.0, 100.0)] {
        let k = solved(at.iter().map(|own| covariance(own, &to)).collect());
        let (mean, std) = known.at(&[to]).predict(&known.hyperparameters().reference, &moduli([0.0])).moments(0);
        let expected = (covariance(&to, &to) - dot(&k, &k) + t * t).sqrt();
        assert!((mean - dot(&k, &y)).abs() < 1e-10 && (std - expected).abs() < 1e-10, "{mean} {std} {expected}");
    }
}

#[test]
fn a_trial_teaches_of_the_form_where_forms_differ() {
    // After one trial at a texture, all forms of an effect agree there, but differ at other textures.
    let here = groove(100.0, 300.0, 10.0);
    let trials = vec![trial("", here, &loads(), 0.005, &mut |_| -0.2)];
    let known = learned(of_an_effect(), trials);
    let predictor = known.at(&loads());
    let of = |texture: &Features| information(&predictor.predict(texture, &moduli([0.1; 4])), 0.01, |form| *form);
    let (again, far) = (of(&here), of(&groove(20.0, 30.0, 25.0)));
    assert!(far > 0.3 && again < 0.1 * far, "{again} {far}");
}

#[test]
fn numbers_without_meaning_are_named() {
    let mut of = trial("third cut", groove(100.0, 300.0, 10.0), &loads(), 0.01, &mut |_| -0.1);
    of.measured[2].measured = -0.4;
    let refused = Discrepancy::new(Hyperparameters::default(), Conditions::default(), 0.2, vec![of]).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "measured ratio of trial third cut at its row 3 is -0.4, and must be positive and finite"
    );
    let hyper = Hyperparameters { residual_length: 0.0, ..Hyperparameters::default() };
    let refused = Discrepancy::new(hyper, Conditions::default(), 0.2, Vec::new()).unwrap_err();
    assert_eq!(refused.to_string(), "residual_length is 0, and must be a positive finite number");
}

#[test]
fn leaving_out_ends_when_the_monitor_cancels() {
    let known = discrepancy(vec![trial("A", groove(100.0, 300.0, 10.0), &loads(), 0.01, &mut |_| -0.2)]);
    for by in [LeftOut::Trial, LeftOut::Condition, LeftOut::TrialAndLater] {
        assert_eq!(leave_out(&known, by, &AtomicBool::new(true)), Err(Cancelled));
    }
}
