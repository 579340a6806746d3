//! Fits of the pressure scale of an area law.

use super::*;

/// A saturating contact area curve: a(x) = 1 - exp(-x), close to Persson's.
fn unknown_law() -> AreaLawScale {
    let pressure_over_scale: Vec<f64> = (0..160).map(|i| 1e-3 * 1.07_f64.powi(i)).collect();
    AreaLawScale {
        area_fraction: pressure_over_scale.iter().map(|x| -(-x).exp_m1()).collect(),
        pressure_over_scale,
        bounds_pa: [0.5e6, 50e6],
    }
}

/// Six loads on a short specimen with an unknown law and static peaks.
fn scaled_problem() -> Problem {
    let mut problem = problem(Coefficients::Single);
    problem.area_law = None;
    problem.area_law_scale = Some(unknown_law());
    let static_peak = Some(StaticPeak { mu: 0.2, std: 0.004 });
    problem.measurements = [0.637e6, 1.0e6, 1.5e6, 2.5e6, 4.0e6, 6.0e6]
        .map(|force_n| Measurement { force_n, static_peak, ..problem.measurements[0] })
        .to_vec();
    problem
}

#[test]
fn intervals_cover_the_truth_as_often_as_they_say() {
    const REPLICATES: usize = 200;
    let (truth, scale_pa): (f64, f64) = (0.25, 6e6);
    let mut problem = scaled_problem();
    let layout = Layout::new(&problem);
    let count = problem.measurements.len();
    // Dynamic runs are replaced by constant corrections; peaks have a slope of one half against mu_s.
    let line = |i: usize| PeakLine { at_current: 0.22 - 0.01 * i as f64, slope: 0.5, current: 0.275 };
    let corrections = Corrections {
        delta: vec![1.015; count],
        relative_stderr: vec![0.0; count],
        peaks: (0..count).map(|i| Some(line(i))).collect(),
    };
    let means = vec![truth; count];
    let clean: Vec<f64> = {
        let exact = Problem { area_law: problem.law_at(scale_pa).unwrap(), ..problem.clone() };
        let pairs = vec![LocalFriction::new(0.275, truth, 0.05).unwrap(); count];
        flat_sample::steady(&exact, &pairs, &(0..count).collect::<Vec<_>>())
            .unwrap()
            .iter()
            .map(|mu| 1.015 * mu)
            .collect()
    };
    let settings = problem.clone();
    let emulator = Emulator::new(&settings, &means, &Unwatched).unwrap();
    let mut noise = Noise::new(20);
    let mut covered = [[0; 2]; 3];
    let mut chi_square = 0.0;
    for _ in 0..REPLICATES {
        for (i, measured) in problem.measurements.iter_mut().enumerate() {
            measured.mu_dynamic = clean[i] + measured.mu_dynamic_std * noise.normal();
            measured.static_peak = Some(StaticPeak { mu: line(i).at_current + 0.004 * noise.normal(), std: 0.004 });
        }
        let model = Model { problem: &problem, layout: &layout, corrections: &corrections, emulator: &emulator };
        let solution = model.fit(&[0.2, 0.2, (2e6_f64).ln()], true).unwrap();
        let parameters = profile_likelihood::parameters(&model, &solution).unwrap();
        chi_square += solution.chi_square();
        for ((covered, parameter), truth) in covered.iter_mut().zip(&parameters).zip([truth, 0.275, scale_pa]) {
            let [from, to] = parameter.interval;
            let within = from.is_none_or(|from| from <= truth) && to.is_none_or(|to| truth <= to);
            covered[0] += usize::from(within);
            let curvature = (parameter.value - truth).abs() < 1.959_964 * parameter.std_error;
            covered[1] += usize::from(curvature);
        }
    }
    // 95 % of 200 is 190 +- 3.1.
    for parameter in covered {
        assert!((181..=199).contains(&parameter[0]), "{covered:?}");
    }
    assert!((178..=199).contains(&covered[0][1]) && (181..=199).contains(&covered[1][1]), "{covered:?}");
    // Twelve values minus three parameters: chi-square is 9 +- 4.2 / sqrt(200).
    assert!((chi_square / REPLICATES as f64 - 9.0).abs() < 1.2, "{}", chi_square / REPLICATES as f64);
}

#[test]
fn the_emulator_is_the_steady_sample() {
    let problem = scaled_problem();
    let emulator = Emulator::new(&problem, &[0.25; 6], &Unwatched).unwrap();
    for (mean, scale_pa) in [(0.25, 6e6), (0.22, 1.3e6), (0.3, 20e6)] {
        let law = problem.law_at(scale_pa).unwrap();
        let exact = Problem { area_law: law.clone(), ..problem.clone() };
        let pairs = vec![LocalFriction::new(0.3, mean, 0.05).unwrap(); 6];
        let solved = flat_sample::steady(&exact, &pairs, &[0, 1, 2, 3, 4, 5]).unwrap();
        for (i, mu) in solved.iter().enumerate() {
            let emulated = emulator.steady(i, mean, law.as_ref(), scale_pa.ln());
            // A tenth of the smallest measured standard deviation, on a specimen whose ends make up a tenth.
            assert!((emulated / mu - 1.0).abs() < 5e-4, "{mean} {scale_pa} {i}: {emulated} {mu}");
        }
    }
}

#[test]
fn a_law_that_the_loads_do_not_show_is_left_open_and_said() {
    // At two light loads, f is 1 within one per cent.
    let mut problem = scaled_problem();
    problem.measurements.truncate(2);
    for measured in &mut problem.measurements {
        measured.static_peak = None;
    }
    let fit = fit_coefficients(&problem, &Unwatched).unwrap();
    let scale = fit.parameters.last().unwrap();
    assert_eq!(scale.name, "area_law_scale_pa");
    assert!(scale.interval.contains(&None), "{scale:?}");
    assert!(fit.notes.iter().any(|note| note.contains("area law: not determined by the data")), "{:?}", fit.notes);
    // One pair per load, or a single load, cannot determine a law.
    let each = Problem { coefficients: Coefficients::PerCondition, ..problem.clone() };
    assert!(matches!(fit_coefficients(&each, &Unwatched), Err(FitError::AreaLawNotIdentifiable { .. })));
    let mut reversed = problem.clone();
    reversed.area_law_scale.as_mut().unwrap().bounds_pa.reverse();
    assert!(matches!(fit_coefficients(&reversed, &Unwatched), Err(FitError::AreaLawNotIdentifiable { .. })));
    problem.measurements.truncate(1);
    assert!(matches!(fit_coefficients(&problem, &Unwatched), Err(FitError::AreaLawNotIdentifiable { .. })));
    problem.measurements.clear();
    assert_eq!(fit_coefficients(&problem, &Unwatched).unwrap_err(), FitError::NoMeasurement);
}
