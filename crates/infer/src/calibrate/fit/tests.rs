use super::dynamic_corrections::PeakLine;
use super::*;
use crate::calibrate::flat_sample;
use crate::calibrate::flat_sample::Pairs;
use crate::calibrate::{AreaLawScale, Measurement, StaticPeak};
use slipgrid_base::statistics::{Noise, extremes};
use slipgrid_model::material::LocalFriction;
use slipgrid_model::material::{AreaLaw, Elastic};
use slipgrid_model::springblock::{Layer, Unwatched};
use std::sync::LazyLock;

mod scale;

/// A short specimen, so that dynamic runs take milliseconds.
fn problem(coefficients: Coefficients) -> Problem {
    Problem {
        elastic: Elastic::new(0.38e9, 900.0).unwrap(),
        area_law: Some(AreaLaw::new(vec![0.7e6, 2.6e6, 10e6], vec![1.0, 0.8, 0.3]).unwrap()),
        area_law_scale: None,
        layer: Layer { length_m: 500e-6, height_m: 40e-6, block_m: 10e-6, thickness_m: None, holder: None },
        specimen_area_m2: 1.0,
        measurements: [0.637e6, 1.273e6, 2.546e6]
            .map(|pressure_pa| Measurement {
                force_n: pressure_pa, // on one square metre
                speed_m_s: 2e-3,
                humidity: 0.15,
                mu_dynamic: 0.2,
                mu_dynamic_std: 0.002,
                static_peak: None,
            })
            .to_vec(),
        coefficients,
        relative_std: 0.05,
        static_over_dynamic: 1.1,
        seed: 3,
    }
}

/// Speed of measurements with peaks: runs from rest take a third of the steps that they take at 2 mm/s.
const FAST_M_S: f64 = 6e-3;

/// Measurements computed from the model with known coefficients.
fn measured_by_the_model(problem: &mut Problem, dynamic_mean: f64, with_peaks: bool) {
    let pair = LocalFriction::new(1.1 * dynamic_mean, dynamic_mean, problem.relative_std).unwrap();
    if with_peaks {
        for measured in &mut problem.measurements {
            measured.static_peak = Some(StaticPeak { mu: 1.0, std: 0.005 });
        }
    }
    let pairs = vec![pair; problem.measurements.len()];
    let alone: Vec<usize> = (0..pairs.len()).collect();
    let found = flat_sample::dynamic(problem, &pairs, &alone, &Unwatched).unwrap();
    for (measured, found) in problem.measurements.iter_mut().zip(&found) {
        measured.mu_dynamic = found.mu_dynamic;
        measured.static_peak = measured.static_peak.map(|peak| StaticPeak { mu: found.mu_static.unwrap(), ..peak });
    }
}

/// Measurements of [`problem`] without and with static peaks, computed once from the model with a mean of 0.25.
static MEASURED: [LazyLock<Vec<Measurement>>; 2] =
    [LazyLock::new(|| measurements_of_the_model(false)), LazyLock::new(|| measurements_of_the_model(true))];

fn measurements_of_the_model(with_peaks: bool) -> Vec<Measurement> {
    let mut problem = problem(Coefficients::PerCondition);
    if with_peaks {
        problem.measurements.iter_mut().for_each(|measured| measured.speed_m_s = FAST_M_S);
    }
    measured_by_the_model(&mut problem, 0.25, with_peaks);
    problem.measurements
}

fn measured_problem(coefficients: Coefficients, with_peaks: bool) -> Problem {
    Problem { measurements: MEASURED[usize::from(with_peaks)].to_vec(), ..problem(coefficients) }
}

/// A travel of 25 periods of this layer at 2 mm/s is one of 2.5 periods at 20 mm/s.
#[test]
fn fast_measurements_are_averaged_as_long_as_slow_ones() {
    for with_peaks in [false, true] {
        let found = [2e-3, 20e-3].map(|speed_m_s| {
            let mut problem = problem(Coefficients::PerCondition);
            problem.layer.height_m = 200e-6;
            problem.measurements.truncate(2);
            problem.measurements.iter_mut().for_each(|measured| measured.speed_m_s = speed_m_s);
            measured_by_the_model(&mut problem, 0.25, with_peaks);
            problem.measurements.iter().map(|measured| measured.mu_dynamic).collect::<Vec<f64>>()
        });
        // Sliding is smoother at high speed: mu falls by up to the 2 % that stick-slip adds.
        for (slow, fast) in found[0].iter().zip(&found[1]) {
            assert!((fast / slow - 1.0).abs() < 0.02, "{slow} {fast}");
        }
    }
}

#[test]
fn coefficients_behind_the_models_own_data_are_recovered_with_standard_errors() {
    for coefficients in [Coefficients::Single, Coefficients::PerCondition] {
        let problem = measured_problem(coefficients, false);
        let fit = fit_coefficients(&problem, &Unwatched).unwrap();
        assert_eq!(fit.pairs.len(), if coefficients == Coefficients::Single { 1 } else { 3 });
        for pair in &fit.pairs {
            // A short specimen determines delta to about 1e-3.
            let noise = fit.predictions.iter().map(|p| p.relative_stderr).fold(0.0, f64::max);
            assert!((pair.dynamic_mean / 0.25 - 1.0).abs() < 4.0 * noise && noise < 2e-3, "{pair:?} {noise}");
            assert!(pair.static_std_error.is_none());
        }
        if coefficients == Coefficients::PerCondition {
            // mu is nearly proportional to mu_d, so that relative standard errors are equal.
            for (pair, measured) in fit.pairs.iter().zip(&problem.measurements) {
                let own = pair.dynamic_std_error.unwrap() / pair.dynamic_mean;
                let relative = own / (measured.mu_dynamic_std / measured.mu_dynamic);
                assert!((relative - 1.0).abs() < 0.05, "{relative}");
            }
            assert_eq!(fit.degrees_of_freedom, 0);
        }
        assert!(fit.settled && fit.notes.iter().any(|note| note.contains("static_mean: not determined")));
        // The excess over steady sliding and the value in the material file are two numbers, and the note distinguishes
        // them.
        let [least, most] = extremes(fit.predictions.iter().map(|predicted| predicted.over_local_law))
            .map(|over| format!("{:.2}", 100.0 * (over - 1.0)));
        let said = format!("Above mu_d f(P), the steady sliding of an endless sample, it lies {least} to {most} %");
        assert!(fit.notes[0].contains(&said), "{said}: {}", fit.notes[0]);
    }
}

#[test]
fn a_measured_static_peak_determines_the_static_coefficient() {
    let mut problem = measured_problem(Coefficients::Single, true);
    problem.static_over_dynamic = 2.0; // not used: every measurement has its peak
    let fit = fit_coefficients(&problem, &Unwatched).unwrap();
    let pair = fit.pairs[0];
    // The slope of the peak against mu_s is well below one, so that the error of mu_s exceeds that of the peak.
    let error = pair.static_std_error.unwrap();
    assert!(error > 0.005 / 3.0_f64.sqrt() && error < 0.03, "{pair:?}");
    assert!((pair.static_mean - 0.275).abs() < 2.0 * error, "{pair:?}");
    assert!((pair.dynamic_mean / 0.25 - 1.0).abs() < 0.01, "{pair:?}");
}

/// Dynamic friction of runs with the fitted coefficients minus the measured one, in standard deviations.
fn off_by(fit: &Fit, problem: &Problem) -> Vec<f64> {
    let pair = |of: &FittedPair| LocalFriction::new(of.static_mean, of.dynamic_mean, problem.relative_std).unwrap();
    let pairs: Pairs = fit.pairs.iter().map(pair).collect();
    let alone: Vec<usize> = (0..pairs.len()).collect();
    let found = flat_sample::dynamic(problem, &pairs, &alone, &Unwatched).unwrap();
    let off = |(found, measured): (&flat_sample::DynamicFlat, &Measurement)| {
        (found.mu_dynamic - measured.mu_dynamic) / measured.mu_dynamic_std
    };
    found.iter().zip(&problem.measurements).map(off).collect()
}

/// With peaks below or above those of the model, modelled dynamic friction must still equal the measured one.
#[test]
fn flat_friction_does_not_pay_for_a_static_peak_that_the_model_does_not_have() {
    for factor in [0.96, 1.2] {
        let mut problem = measured_problem(Coefficients::PerCondition, true);
        problem.measurements.truncate(2);
        for measured in &mut problem.measurements {
            measured.static_peak = measured.static_peak.map(|peak| StaticPeak { mu: factor * peak.mu, std: 0.0005 });
        }
        let fit = fit_coefficients(&problem, &Unwatched).unwrap();
        for off in off_by(&fit, &problem) {
            assert!(off.abs() < 3.0, "{factor}: {off} {:?}", fit.notes);
        }
    }
}

/// At the heavier of two loads the peak is far above dynamic friction, while the coefficients that explain dynamic
/// friction give a peak of 1.01 times dynamic friction. Fitting such a peak would raise modelled friction by three to
/// five standard deviations above the measured one, whether the fit settles or not. `above` is the ratio of the peak to
/// dynamic friction, and `length_m` the length of the layer.
fn is_named_and_left_out(above: f64, length_m: f64) {
    let mut problem = problem(Coefficients::PerCondition);
    problem.layer = Layer { length_m, height_m: 100e-6, ..problem.layer };
    problem.measurements.truncate(2);
    // Starts from rest, like the run in the fit.
    problem.measurements[1].static_peak = Some(StaticPeak { mu: 1.0, std: 0.0005 });
    let behind = LocalFriction::new(1.1 * 0.25, 0.25, problem.relative_std).unwrap();
    let found = flat_sample::dynamic(&problem, &vec![behind; 2], &[0, 1], &Unwatched).unwrap();
    for (measured, found) in problem.measurements.iter_mut().zip(&found) {
        measured.mu_dynamic = found.mu_dynamic;
    }
    assert!(found[1].mu_static.unwrap() < 1.05 * found[1].mu_dynamic, "{found:?}");
    let mu = above * problem.measurements[1].mu_dynamic;
    problem.measurements[1].static_peak = Some(StaticPeak { mu, std: 0.0005 });
    let fit = fit_coefficients(&problem, &Unwatched).unwrap();
    let named = "is not met by the model together with dynamic friction";
    let named = fit.warnings.iter().any(|text| text.starts_with("static_mean 2: ") && text.contains(named));
    assert!(named && fit.settled && fit.pairs[1].static_std_error.is_none(), "{above}: {fit:?}");
    assert!(fit.predictions[1].mu_static.is_none(), "{above}: {fit:?}");
    for off in off_by(&fit, &problem) {
        assert!(off.abs() < 1.0, "{above}: {off}");
    }
}

#[test]
fn a_peak_above_that_of_the_model_is_named_and_left_out() {
    is_named_and_left_out(1.6, 1e-3);
}

#[test]
#[ignore = "twenty seconds: another height of the peak of the test before"]
fn a_peak_far_above_that_of_the_model_is_named_and_left_out() {
    is_named_and_left_out(1.85, 2e-3);
}

#[test]
fn loads_that_one_pair_cannot_describe_show_in_chi_square() {
    let mut problem = measured_problem(Coefficients::Single, false);
    for (measured, factor) in problem.measurements.iter_mut().zip([0.9, 1.0, 1.1]) {
        measured.mu_dynamic *= factor;
    }
    let fit = fit_coefficients(&problem, &Unwatched).unwrap();
    assert!(fit.chi_square > 50.0 && fit.degrees_of_freedom == 2);
    let warned = fit.warnings.iter().find(|warning| warning.contains("one pair of coefficients does not describe"));
    // Friction scatters by 0.1 about the fitted pair, far more than the errors of single measurements.
    let relative = fit.pairs[0].dynamic_std_error.unwrap() / fit.pairs[0].dynamic_mean;
    assert!((relative - 0.1).abs() < 0.02, "{relative}");
    assert!(warned.unwrap().contains(&format!("its standard error, {:.1} %", 100.0 * relative)), "{warned:?}");
    // Static coefficients fitted to peaks do not explain scatter of dynamic friction.
    problem.measurements = MEASURED[1].to_vec();
    problem.measurements.truncate(2);
    for (measured, factor) in problem.measurements.iter_mut().zip([0.9, 1.1]) {
        measured.mu_dynamic *= factor;
    }
    let pair = fit_coefficients(&problem, &Unwatched).unwrap().pairs[0];
    let relative = pair.dynamic_std_error.unwrap() / pair.dynamic_mean;
    assert!((relative - 0.02_f64.sqrt()).abs() < 0.03, "{relative}");
}

#[test]
fn measurements_without_meaning_are_refused() {
    let mut problem = problem(Coefficients::Single);
    problem.measurements[1].mu_dynamic_std = 0.0;
    let refused = fit_coefficients(&problem, &Unwatched).unwrap_err().to_string();
    assert!(refused.contains("measurement 2") && refused.contains("mu_dynamic_std"), "{refused}");
}

fn with_peak(mu: f64, std: f64) -> Problem {
    let mut problem = problem(Coefficients::PerCondition);
    problem.measurements.truncate(2);
    problem.measurements[1].static_peak = Some(StaticPeak { mu, std });
    problem
}

#[test]
fn a_peak_that_does_not_stand_out_is_left_out_by_name() {
    for (mu, std) in [(0.19, 0.001), (0.2008, 0.002)] {
        let fit = fit_coefficients(&with_peak(mu, std), &Unwatched).unwrap();
        assert!(fit.pairs.iter().all(|pair| pair.static_std_error.is_none()), "{:?}", fit.pairs);
        assert!(fit.warnings.iter().any(|note| note.starts_with("static_mean 2: not determined")));
    }
    // A distinct peak that hardly depends on mu_s: the standard error is finite or absent.
    let fit = fit_coefficients(&with_peak(0.2011, 1e-5), &Unwatched);
    let fit = fit.unwrap_or_else(|error| panic!("{error}"));
    assert!(fit.pairs.iter().all(|pair| pair.static_std_error.is_none_or(f64::is_finite)), "{:?}", fit.pairs);
}

#[test]
fn what_no_run_would_bring_nearer_is_refused_before_the_first() {
    struct Idle;
    impl slipgrid_model::springblock::Monitor for Idle {
        fn advance(&self, _: f64) {
            panic!("a run was begun");
        }
    }
    let refused = |spoil: &dyn Fn(&mut Problem)| {
        let mut problem = problem(Coefficients::PerCondition);
        spoil(&mut problem);
        fit_coefficients(&problem, &Idle).unwrap_err()
    };
    let peak = refused(&|p| p.measurements[2].static_peak = Some(StaticPeak { mu: 1.5, std: 0.01 }));
    assert!(matches!(peak, FitError::PeakTooHigh { number: 3, .. }), "{peak}");
    let slow = refused(&|p| p.measurements[1].speed_m_s = 5e-9);
    let FitError::TooManySteps { number: 2, least_m_s, hours, .. } = slow else { panic!("{slow}") };
    assert!(hours > 0.1 && (1e-7..1e-5).contains(&least_m_s), "{slow}");
    // Slightly faster, the run is accepted.
    let mut at_least = problem(Coefficients::PerCondition);
    at_least.measurements[1].speed_m_s = 1.01 * least_m_s;
    assert!(super::planned_steps(&at_least).is_ok());
    let law = refused(&|p| p.area_law = Some(AreaLaw::new(vec![0.7e6, 2.6e6], vec![1.0, 0.01]).unwrap()));
    assert!(matches!(law, FitError::BeyondLaw { number: 3, .. }), "{law}");
    let many = refused(&|p| {
        let at = |i: i32| Measurement { speed_m_s: least_m_s * (1.001 + 1e-6 * f64::from(i)), ..p.measurements[1] };
        p.measurements = (1..250).map(at).collect();
    });
    assert!(matches!(many, FitError::TooMuchWork { .. }), "{many}");
    let light = refused(&|p| p.measurements[1].force_n = 10.0);
    assert!(matches!(light, FitError::TooFast { number: 2, .. }), "{light}");
    let wide = refused(&|p| p.measurements = vec![p.measurements[0]; 251]);
    assert!(matches!(wide, FitError::TooManyCoefficients { count: 251, .. }), "{wide}");
}

/// At 60 mm/s the layer would slide in waves, so that all runs use the speed limit of even sliding.
#[test]
fn measurements_faster_than_even_sliding_are_run_more_slowly() {
    let fitted = |speed_m_s: f64| {
        let mut problem = problem(Coefficients::PerCondition);
        problem.measurements.iter_mut().for_each(|measured| measured.speed_m_s = speed_m_s);
        fit_coefficients(&problem, &Unwatched).unwrap()
    };
    let (fast, faster) = (fitted(60e-3), fitted(80e-3));
    assert_eq!(fast.pairs, faster.pairs);
    let told = fast.notes.iter().find(|note| note.starts_with("speed: ")).unwrap();
    assert!(told.contains("3 of 3 measurements") && told.contains("known to about 1 %"), "{told}");
    let problem = problem(Coefficients::PerCondition);
    // v = 0.01 P / sqrt(E rho)
    let measured = &problem.measurements[0];
    let (elastic, pressure_pa) = (&problem.elastic, problem.pressure_pa(measured));
    let even = 0.01 * pressure_pa / (elastic.youngs_modulus_pa() * elastic.density_kg_m3()).sqrt();
    let run = |speed_m_s: f64| flat_sample::speed_m_s(&problem, &Measurement { speed_m_s, ..*measured });
    assert!(even > measured.speed_m_s && run(measured.speed_m_s) == measured.speed_m_s);
    assert!((run(9.9 * even) / even - 1.0).abs() < 1e-12);
    // Far above the limit no slower run can replace it.
    assert_eq!(run(10.1 * even), 10.1 * even);
}

#[test]
fn friction_at_which_the_model_does_not_slide_steadily_is_refused_by_name() {
    let mut problem = problem(Coefficients::Single);
    problem.area_law = None;
    problem.measurements.iter_mut().for_each(|measured| measured.mu_dynamic = 4.0);
    let refused = fit_coefficients(&problem, &Unwatched).unwrap_err();
    assert!(matches!(refused, FitError::NoSliding { number: 1, .. }), "{refused}");
    let refused = feasibility::check_deltas(&[1.01, 0.46]).unwrap_err();
    assert!(matches!(refused, FitError::NotQuasiStatic { number: 2, .. }), "{refused}");
    assert!(feasibility::check_deltas(&[0.98, 1.015]).is_ok() && feasibility::check_deltas(&[f64::NAN]).is_err());
}

#[test]
fn a_heavy_load_is_given_the_travel_that_its_onset_takes() {
    let mut problem = problem(Coefficients::Single);
    problem.layer.height_m = 100e-6;
    problem.area_law = None;
    problem.measurements.truncate(1);
    // The onset is at 2.03 um, beyond the least travel of a run from rest.
    problem.measurements[0].force_n = 9.6e6;
    problem.measurements[0].mu_dynamic = 0.25;
    problem.measurements[0].static_peak = Some(StaticPeak { mu: 0.26, std: 0.002 });
    let pairs = vec![LocalFriction::new(0.3, 0.25, 0.05).unwrap()];
    let found = flat_sample::dynamic(&problem, &pairs, &[0], &Unwatched).unwrap();
    assert!(found[0].mu_static.unwrap() > found[0].mu_dynamic, "{found:?}");
}

#[test]
fn planned_steps_are_those_that_a_run_takes() {
    use slipgrid_model::springblock::{Extent, Fidelity, Load, RunOptions, Scene, simulate};
    let problem = problem(Coefficients::Single);
    let pair = LocalFriction::new(0.22, 0.2, 0.05).unwrap();
    let planned = flat_sample::planned_steps(&problem, &vec![pair; 3]);
    for (measured, planned) in problem.measurements.iter().zip(&planned) {
        let loads = vec![Load { pressure_pa: problem.pressure_pa(measured), friction: pair }];
        let (law, speed_m_s) = ((&problem.elastic, problem.area_law.as_ref()), measured.speed_m_s);
        let scene = Scene {
            elastic: problem.elastic,
            area_law: None,
            pattern: None,
            relief: None,
            layer: problem.layer,
            speed_m_s,
            run: RunOptions {
                fidelity: Fidelity::Dynamic,
                extent: Extent::Sample,
                warm_start: true,
                sliding_m: slipgrid_model::springblock::warm_travel_m(law, &problem.layer, &loads, speed_m_s),
                ..RunOptions::default()
            },
            loads,
        };
        assert_eq!(*planned, simulate(&scene, &Unwatched).unwrap().loads[0].surface.cost.unwrap().steps);
    }
    // Heavier loads slip further.
    assert!(planned[0] < planned[1] && planned[1] < planned[2]);
}

#[test]
fn one_run_stands_for_all_at_its_load_and_speed() {
    let mut problem = problem(Coefficients::PerCondition);
    problem.layer = Layer { length_m: 2e-3, height_m: 100e-6, ..problem.layer };
    // The requested standard error has a lower limit.
    problem.measurements.iter_mut().for_each(|measured| measured.mu_dynamic_std = 1e-4);
    let of = |factor: f64| vec![LocalFriction::new(0.3 * factor, 0.27 * factor, 0.05).unwrap(); 3];
    let deltas = |pairs: &Pairs| -> Vec<[f64; 2]> {
        let runs = flat_sample::dynamic(&problem, pairs, &[0, 1, 2], &Unwatched).unwrap();
        let steady = flat_sample::steady(&problem, pairs, &[0, 1, 2]).unwrap();
        runs.iter().zip(&steady).map(|(run, steady)| [run.mu_dynamic / steady, run.stderr / steady]).collect()
    };
    let own = deltas(&of(1.0));
    for factor in [0.88_f64, 1.13] {
        for ([at, stderr], [own, own_stderr]) in deltas(&of(factor)).iter().zip(&own) {
            let allowed = dynamic_corrections::EXCESS_SENSITIVITY_STD * (own - 1.0) * factor.ln().abs()
                + stderr.hypot(*own_stderr);
            assert!((own - 1.0) > 5e-3 && (at - own).abs() < 3.0 * allowed, "{at} {own} {allowed:e}");
            assert!(allowed < 1e-3, "{allowed:e}");
        }
    }
    // Of three humidities the middle one is run; a measurement with a peak has its own run.
    problem.measurements = vec![problem.measurements[0]; 3];
    let pairs: Pairs = [1.0, 1.2, 1.1].iter().flat_map(|&factor| of(factor).pop()).collect();
    assert_eq!(flat_sample::representatives(&problem, &pairs), [2, 2, 2]);
    assert_eq!(flat_sample::planned_steps(&problem, &pairs)[..2], [0, 0]);
    problem.measurements[1].static_peak = Some(StaticPeak { mu: 0.3, std: 0.01 });
    assert_eq!(flat_sample::representatives(&problem, &pairs), [0, 1, 0]);
}
