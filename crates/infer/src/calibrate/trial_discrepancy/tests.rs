use slipgrid_base::monitor::Unwatched;
use slipgrid_model::material::Elastic;
use slipgrid_model::pattern::Planform;
use slipgrid_model::springblock::{Holder, Layer};

use super::*;
use crate::calibrate::surface_area_law_source::surface_findings;
use crate::calibrate::uncertainty::{flat_friction, local_law, local_law_changes};
use crate::calibrate::{Coefficients, Selection};
use crate::calibrate::{CutSpecimen, Measurement, Surface, TrialsTask, learn_alone};
use crate::discrepancy::Form;

pub fn measured(force_n: f64, humidity: f64, mu_dynamic: f64) -> Measurement {
    Measurement { force_n, speed_m_s: 2e-3, humidity, mu_dynamic, mu_dynamic_std: 0.002, static_peak: None }
}

/// Calibration task of one sample, cut into the same specimen as the `flat` samples and measured at their conditions.
pub fn task(flat: Vec<Measurement>, planform: Planform) -> CalibrationTask {
    let sample = CutSample {
        name: "cut".to_owned(),
        date: String::new(),
        notes: String::new(),
        pattern: Pattern::new(planform, 130e-6, 170e-6, 12e-6).unwrap(),
        relief: None,
        map: None,
        land: None,
        dimensions_std_m: [5e-6, 0.0, 0.0],
        sample_std: None,
        disc: None,
        specimen: CutSpecimen::default(),
        measured: flat.iter().map(|flat| Measurement { mu_dynamic: 0.9 * flat.mu_dynamic, ..*flat }).collect(),
    };
    CalibrationTask {
        name: "test".to_owned(),
        source: "nowhere".to_owned(),
        elastic: Elastic::new(0.38e9, 900.0).unwrap(),
        youngs_modulus_std_pa: Some(0.08e9),
        poisson_ratio: 1.0 / 3.0,
        surface: Surface::RmsSlope(0.0137),
        threshold_pa: None,
        specimen_area_m2: 78.54e-6,
        flat,
        trials: TrialsTask { samples: vec![sample], ..TrialsTask::default() },
        coefficients: Coefficients::PerCondition,
        relative_std: 0.05,
        static_over_dynamic: 0.30 / 0.27,
        layer: Layer { length_m: 500e-6, height_m: 100e-6, block_m: 10e-6, thickness_m: None, holder: None },
        seed: 1,
        selection: Selection::default(),
        notes: Vec::new(),
        doubts: Vec::new(),
    }
}

/// Friction between that of two other measurements at one force, in two and in three dimensions.
#[test]
fn between_two_frictions_the_modelled_ratio_is_linear() {
    for planform in [Planform::Groove, Planform::Square] {
        let flat = vec![
            measured(100.0, 0.8, 0.32),
            measured(100.0, 0.4, 0.27),
            measured(100.0, 0.15, 0.24),
            measured(200.0, 0.4, 0.3),
        ];
        // The correction for time is known in two dimensions only, at the mean friction for a force, within the
        // error of a run.
        let of_time = if planform == Planform::Groove { 1.5e-3 } else { 0.0 };
        let task = |flat| {
            let own = task(flat, planform);
            let length_m = if planform == Planform::Groove { 5e-3 } else { own.layer.length_m };
            let layer = Layer { length_m, ..own.layer };
            CalibrationTask { layer, ..own }
        };
        let all = learn_alone(&task(flat.clone()), &Unwatched).unwrap().discrepancy;
        let all = &all.trials()[0];
        assert_eq!(all.dimension_shifts.len(), 1);
        for (row, flat) in flat.iter().enumerate() {
            let own = learn_alone(&task(vec![*flat]), &Unwatched).unwrap().discrepancy;
            let own = &own.trials()[0];
            let (found, exact) = (&all.measured[row], &own.measured[0]);
            let off = (found.modelled - exact.modelled).abs();
            assert!(off < 5e-5 + of_time, "{planform:?} {row}: {found:?} {exact:?}");
            assert!((found.sensitivity.modulus - exact.sensitivity.modulus).abs() < 2e-4, "{planform:?} {row}");
            // A wider cavity lowers the ratio.
            let change = all.dimension_shifts[0].log_ratio[row];
            assert!(
                change < -1e-4 && (change - own.dimension_shifts[0].log_ratio[0]).abs() < 5e-5,
                "{planform:?} {row}: {change}"
            );
        }
        let [most, _, least, heavy] = [0, 1, 2, 3].map(|row| all.measured[row].modelled);
        assert!((most - least).abs() > 1e-7 && heavy < most - 0.005, "{most} {least} {heavy}");
    }
}

#[test]
fn what_is_modelled_has_what_time_adds() {
    let flat = vec![measured(50.0, 0.4, 0.26), measured(50.0, 0.8, 0.28), measured(200.0, 0.4, 0.3)];
    let scattered = CalibrationTask {
        layer: Layer { length_m: 5e-3, height_m: 200e-6, block_m: 10e-6, thickness_m: None, holder: None },
        surface: Surface::None,
        ..task(flat, Planform::Groove)
    };
    let alike = CalibrationTask { relative_std: 0.0, static_over_dynamic: 1.0, ..scattered.clone() };
    let modelled = |task: &CalibrationTask| -> Vec<f64> {
        let learned = learn_alone(task, &Unwatched).unwrap().discrepancy;
        learned.trials()[0].measured.iter().map(|at| at.modelled).collect()
    };
    // At the mean friction of each force.
    let load = |force_n: f64, mean: f64| slipgrid_model::springblock::Load {
        pressure_pa: force_n / 78.54e-6,
        friction: slipgrid_model::material::LocalFriction::new(0.30 / 0.27 * mean, mean, 0.05).unwrap(),
    };
    let scene = slipgrid_model::springblock::Scene {
        elastic: scattered.elastic,
        area_law: None,
        pattern: Some(scattered.trials.samples[0].pattern),
        relief: None,
        layer: scattered.layer,
        loads: vec![load(50.0, 0.27), load(200.0, 0.3)],
        speed_m_s: 2e-3,
        run: slipgrid_model::springblock::RunOptions { seed: 1, ..slipgrid_model::springblock::RunOptions::default() },
    };
    let added = slipgrid_laser::specimen::time_changes_on(&scene, None, &Unwatched).unwrap();
    let [light, heavy] = [0, 1].map(|place| added[place].unwrap());
    assert!(light > 4e-3 && heavy > 4e-3, "{light} {heavy}");
    let found = modelled(&scattered).into_iter().zip(modelled(&alike));
    for ((scattered, alike), added) in found.zip([light, light, heavy]) {
        // For equal blocks the correction is smaller.
        assert!((scattered - alike - added).abs() < 1e-3, "{scattered} {alike} {added}");
    }
}

/// A ratio of an unknown holder includes half of the tilt that a rigid one causes. Without a holder of its own a sample
/// is held as the task's layer.
#[test]
fn a_sample_is_modelled_in_its_own_holder() {
    let layer = Layer { length_m: 2e-3, height_m: 200e-6, block_m: 20e-6, thickness_m: Some(2e-3), holder: None };
    let flat = vec![measured(2.0, 0.4, 0.27)];
    let task = CalibrationTask { layer, specimen_area_m2: 2e-6, ..task(flat, Planform::Groove) };
    let outline = slipgrid_laser::export::Outline::Rectangle { length_m: 2e-3, width_m: 1e-3 };
    let face = Some(slipgrid_laser::export::Specimen { outline, is_clipped: false });
    let modelled = |holder: Option<Holder>, of_layer: Option<Holder>| {
        let mut task = task.clone();
        task.layer.holder = of_layer;
        task.trials.samples[0].specimen = CutSpecimen { face, holder, ..CutSpecimen::default() };
        learn_alone(&task, &Unwatched).unwrap().discrepancy.trials()[0].measured[0].modelled
    };
    let (rigid, aligned) = (Some(Holder::Rigid), Some(Holder::SelfAligning));
    let [all, none, half] = [rigid, aligned, None].map(|holder| modelled(holder, None));
    assert!((all - none).abs() > 1e-4 && (0.5 * (all + none) - half).abs() < 1e-6, "{all} {none} {half}");
    assert_eq!([modelled(None, rigid), modelled(aligned, rigid)], [all, none]);
}

/// A layer without a thickness is modelled alone in designs, whatever thickness the calibration states: in trials, too.
#[test]
fn a_sample_of_a_layer_alone_is_modelled_without_the_body_behind_it() {
    let flat = vec![measured(50.0, 0.4, 0.27), measured(200.0, 0.4, 0.3)];
    let modelled = |of_layer: Option<f64>, thickness_m: Option<f64>| -> Vec<f64> {
        let mut task = task(flat.clone(), Planform::Groove);
        task.layer.thickness_m = of_layer;
        task.trials.samples[0].specimen = CutSpecimen { thickness_m, ..CutSpecimen::default() };
        let learned = learn_alone(&task, &Unwatched).unwrap().discrepancy;
        learned.trials()[0].measured.iter().map(|at| at.modelled).collect()
    };
    let alone = modelled(None, None);
    assert_eq!(modelled(None, Some(7e-3)), alone);
    let thick = modelled(Some(7e-3), None);
    assert_eq!(modelled(Some(2e-3), Some(7e-3)), thick);
    assert!((thick[1] - alone[1]).abs() > 2e-3, "{thick:?} {alone:?}");
}

/// The share of the face that is cavity is that of the cavities that fit.
#[test]
fn a_sample_has_the_cavities_that_its_specimen_takes() {
    let task = task(vec![measured(2.0, 0.4, 0.27)], Planform::Square);
    let mut task = CalibrationTask { specimen_area_m2: 0.95e-6, ..task };
    let sample = &mut task.trials.samples[0];
    let outline = slipgrid_laser::export::Outline::Disc { diameter_m: 1.1e-3 };
    let specimen = slipgrid_laser::export::Specimen { outline, is_clipped: false };
    sample.specimen.face = Some(specimen);
    sample.dimensions_std_m = [0.0, 5e-6, 0.0];
    let layout = specimen.layout(sample.pattern).unwrap();
    let expected = layout.areal_density() / sample.pattern.areal_density();
    let learned = learn_alone(&task, &Unwatched).unwrap().discrepancy;
    let features = learned.trials()[0].features;
    assert!(expected < 0.9 && (features.face_share - expected).abs() < 1e-11, "{features:?} {expected}");
    // At another spacing as many cavities take as much of the face: a discrepancy that follows it does not change.
    let shift = &learned.trials()[0].dimension_shifts[0];
    assert!(shift.above.areal_density < 0.98 * features.areal_density, "{shift:?}");
    assert!(shift.log_form(&Form::Density, &features).abs() < 1e-9, "{shift:?}");
}

/// Designs treat fitted and measured laws as independent of the modulus. A trial must do so as well, or part of its
/// effect would be lost.
#[test]
fn a_law_that_the_modulus_does_not_move_lays_nothing_to_it() {
    let flat = vec![measured(100.0, 0.4, 0.27), measured(200.0, 0.4, 0.25), measured(300.0, 0.4, 0.24)];
    let of = |surface: Surface| {
        let task =
            CalibrationTask { surface, coefficients: Coefficients::Single, ..task(flat.clone(), Planform::Groove) };
        learn_alone(&task, &Unwatched).unwrap().discrepancy
    };
    assert!((of(Surface::RmsSlope(0.0137)).modulus_relative_std() - 0.08 / 0.38).abs() < 1e-6);
    let fitted = of(Surface::FittedScale { bounds_pa: [0.5e6, 50e6] });
    assert_eq!((fitted.modulus_relative_std(), of(Surface::None).modulus_relative_std()), (0.0, 0.0));
    // A measured texture is predicted as measured, whatever modulus sensitivity is given.
    let trial = &fitted.trials()[0];
    let at: Vec<Load> = trial.measured.iter().map(|at| at.load).collect();
    let of_slope =
        |g: f64| fitted.at(&at).predict(&trial.features, &vec![Sensitivity::of_modulus(g); at.len()]).medians();
    assert_eq!(of_slope(0.0), of_slope(0.2));
}

/// In the plane and in space: the change is that of cells in the blocks of the layer, as in `simulate`, and not that of
/// the smaller blocks which trials are else modelled in.
#[test]
fn a_trial_knows_what_the_local_law_changes() {
    for planform in [Planform::Groove, Planform::Square] {
        let flat = vec![measured(50.0, 0.4, 0.25), measured(200.0, 0.4, 0.30), measured(50.0, 0.8, 0.27)];
        // Without what time adds both ratios are those of cells.
        let task = CalibrationTask { relative_std: 0.0, static_over_dynamic: 1.0, ..task(flat, planform) };
        let surface = surface_findings(&task, &Unwatched).unwrap();
        let area_law = surface.law.clone().unwrap();
        let of = |task: &CalibrationTask, law| learn(task, law, &Unwatched).unwrap().discrepancy;
        let modelled = of(&task, surface.law_and_curve());
        let condition = task.flat[0].condition();
        let law = local_law(&area_law, &flat_friction(&task), Some(&condition)).unwrap();
        let by_law = of(&task, (Some(&law), &[]));
        let load = |flat: &Measurement| {
            let pressure_pa = task.pressure_pa(flat);
            let mean = flat.mu_dynamic / area_law.factor(pressure_pa);
            let friction = slipgrid_model::material::LocalFriction::new(mean, mean, 0.0).unwrap();
            slipgrid_model::springblock::Load { pressure_pa, friction }
        };
        let pattern = task.trials.samples[0].pattern;
        let scene = slipgrid_model::springblock::Scene {
            elastic: task.elastic,
            area_law: Some(area_law.clone()),
            pattern: Some(pattern),
            relief: None,
            layer: task.layer,
            loads: task.flat[..2].iter().map(load).collect(),
            speed_m_s: 2e-3,
            run: slipgrid_model::springblock::RunOptions::default(),
        };
        let endless = (&[1.0; 2][..], 1.0);
        for (row, expected) in local_law_changes(&scene, &pattern, &law, endless).into_iter().enumerate() {
            let [own, other] = [&modelled, &by_law].map(|of| of.trials()[0].measured[row]);
            let (change, refined) = (own.sensitivity.local_law, (other.modelled / own.modelled).ln());
            // What time adds to equal blocks is below a thousandth.
            assert!((change / expected - 1.0).abs() < 1e-3, "{planform:?} {row}: {change} {expected}");
            let apart = (change / refined - 1.0).abs();
            assert!((0.01..0.1).contains(&apart) && refined > 0.005, "{planform:?} {row}: {change} {refined}");
        }
        // At the other humidity one load was measured.
        assert_eq!(modelled.trials()[0].measured[2].sensitivity.local_law, 0.0);
        // Nor where a law is that of friction, or one pair of coefficients holds at all loads.
        let single = CalibrationTask { coefficients: Coefficients::Single, ..task.clone() };
        for of in [by_law, of(&single, surface.law_and_curve())] {
            assert!(of.trials()[0].measured.iter().all(|at| at.sensitivity.local_law == 0.0));
        }
    }
}

#[test]
fn a_pending_sample_is_modelled_as_it_will_be_measured() {
    let flat = vec![measured(100.0, 0.4, 0.27), measured(200.0, 0.4, 0.3)];
    let mut task = task(flat, Planform::Groove);
    let known = learn_alone(&task, &Unwatched).unwrap();
    assert!(known.pending.is_empty());
    task.trials.samples[0].measured.clear();
    let found = learn_alone(&task, &Unwatched).unwrap();
    assert!(found.discrepancy.trials().is_empty());
    let (pending, measured) = (&found.pending[0], &known.discrepancy.trials()[0]);
    assert_eq!((&pending.name, &pending.dimension_shifts), (&measured.name, &measured.dimension_shifts));
    assert_eq!((pending.features, pending.measured.len()), (measured.features, measured.measured.len()));
    for (pending, measured) in pending.measured.iter().zip(&measured.measured) {
        assert_eq!((pending.load, pending.modelled), (measured.load, measured.modelled));
        assert_eq!(pending.sensitivity, measured.sensitivity);
    }
}
