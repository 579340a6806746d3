//! Trials: samples that were cut and measured, and the discrepancy that they say.

use std::sync::Arc;

use slipgrid_contact::AreaPoint;
use slipgrid_discrepancy::{
    Conditions, DimensionShift, Discrepancy, Features, Hyperparameters, Load, Measured, Sensitivity, Trial,
};
use slipgrid_export::Specimen;
use slipgrid_material::AreaLaw;
use slipgrid_monitor::{Monitor, Stage};
use slipgrid_pattern::{Pattern, ReliefMap};
use slipgrid_springblock::Dimension;
use slipgrid_units::{HUMIDITY_PCT, PRESSURE_MPA, SPEED_MM_S, tidy};

use crate::patterned_samples::{Model, Pair, pairs};
use crate::surface_area_law_source::surface_findings;
use crate::{CalibrationError, CalibrationTask, Measurement, PendingSample, Surface};
use slipgrid_monitor::Part;

/// A sample that was cut, and measured unless it is pending.
#[derive(Clone, Debug, PartialEq)]
pub struct CutSample {
    /// Its name.
    pub name: String,
    /// When it was measured, as written; empty where that is not said.
    pub date: String,
    /// Whatever else is known of it.
    pub notes: String,
    /// Its pattern, as measured or as designed.
    pub pattern: Pattern,
    /// Measured heights of its face over one period, in place of rims.
    pub relief: Option<Arc<ReliefMap>>,
    /// Standard errors of width, spacing and depth, in metres; 0 where they are taken as exact.
    pub dimensions_std_m: [f64; 3],
    /// Scatter from one sample of the texture to the next, where it is known: of the ratio's logarithm.
    pub sample_std: Option<f64>,
    /// The disc that it shares with other samples of this name, as a sector of it; `None` where it has its own.
    pub disc: Option<String>,
    /// The specimen that it was cut into.
    pub specimen: CutSpecimen,
    /// Measurements on it; none while it is pending.
    pub measured: Vec<Measurement>,
}

/// The specimen that a sample was cut into.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CutSpecimen {
    /// Its face, and what became of cavities that pass its rim; `None` where the pattern is taken as endless, as on a sector of a disc.
    pub face: Option<Specimen>,
    /// Its thickness, in metres, where it is not that of the task's layer.
    pub thickness_m: Option<f64>,
}

/// What is wanted of trials: the samples, and what is believed before.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrialsTask {
    /// The samples, the earliest first.
    pub samples: Vec<CutSample>,
    /// What is believed before anything was measured.
    pub prior: Hyperparameters,
}

/// What the samples of a calibration say.
#[derive(Clone, Debug, PartialEq)]
pub struct Learned {
    /// The discrepancy.
    pub discrepancy: Discrepancy,
    /// What is not modelled of a sample as it is of designs, one sentence each.
    pub warnings: Vec<String>,
}

/// The discrepancy that the samples of `task` say, by an area law that follows from a contact area `curve`, or by `law` itself where
/// there is no curve. Before any sample it is the prior.
///
/// # Errors
/// [`CalibrationError`] if the numbers make no scene or no discrepancy, or the monitor asks to stop.
pub fn learn(
    task: &CalibrationTask,
    law: (Option<&AreaLaw>, &[AreaPoint]),
    monitor: &dyn Monitor,
) -> Result<Learned, CalibrationError> {
    let measured: Vec<&CutSample> = task.trials.samples.iter().filter(|sample| !sample.measured.is_empty()).collect();
    let monitor = Part::new(monitor, 1.0 / measured.len().max(1) as f64);
    let trials = measured.into_iter().map(|sample| trial(task, sample, law, &monitor));
    let (trials, warnings): (Vec<Trial>, Vec<Option<String>>) =
        trials.collect::<Result<Vec<_>, CalibrationError>>()?.into_iter().unzip();
    // As designs have it: ratios follow the modulus through the area law, where that moves with it.
    let (_, curve) = law;
    let modulus = if curve.is_empty() { 0.0 } else { tidy(task.modulus_relative_std().unwrap_or(0.0)) };
    let discrepancy = Discrepancy::new(task.trials.prior.clone(), conditions(task), modulus, trials);
    Ok(Learned {
        discrepancy: discrepancy.map_err(CalibrationError::Trials)?,
        warnings: warnings.into_iter().flatten().collect(),
    })
}

/// Memory, in bytes, that modelling the strips of the largest measured sample of `task` takes: samples follow one another.
///
/// # Errors
/// [`CalibrationError`] where one takes more than there is, or means nothing.
pub fn sample_bytes(task: &CalibrationTask) -> Result<f64, CalibrationError> {
    let law = (None, &[][..]);
    let mut most = 0.0_f64;
    for cut in task.trials.samples.iter().filter(|sample| !sample.measured.is_empty()) {
        let CutSpecimen { face, thickness_m } = cut.specimen;
        let Some(face) = &face else { continue };
        let model = Model { task, law, pattern: cut.pattern, relief: cut.relief.clone(), thickness_m };
        most = most.max(model.bytes_on(face, &pairs(task, &cut.measured))?);
    }
    Ok(most)
}

/// What a calibration's samples say, and what is modelled of those that were cut and not yet measured.
#[derive(Clone, Debug, PartialEq)]
pub struct LearnedSamples {
    /// The discrepancy.
    pub discrepancy: Discrepancy,
    /// What is modelled of the pending samples.
    pub pending: Vec<PendingSample>,
}

/// The same without fitting anything to flat samples, but where the area law is fitted to them. Stages of the monitor: those of the
/// area law, "calibration" where there is one, and "trials".
///
/// # Errors
/// As [`crate::run`].
pub fn learn_alone(task: &CalibrationTask, monitor: &dyn Monitor) -> Result<LearnedSamples, CalibrationError> {
    let (surface, learned) = if matches!(task.surface, Surface::FittedScale { .. }) {
        let found = crate::run(task, monitor)?;
        (found.surface, found.uncertainty.learned)
    } else {
        (surface_findings(task, monitor)?, None)
    };
    let law = surface.law_and_curve();
    let stage = Stage::new(monitor, "trials", None);
    let learned = learned.map_or_else(|| learn(task, law, &stage).map(|learned| learned.discrepancy), Ok);
    let pending = task.trials.samples.iter().filter(|sample| sample.measured.is_empty());
    let pending = pending.map(|sample| {
        // Each flat measurement beside itself: what is modelled there.
        let sample = CutSample { measured: task.flat.clone(), ..sample.clone() };
        trial(task, &sample, law, &Part::new(&stage, 0.0)).map(|(trial, _)| PendingSample::from(trial))
    });
    let pending = pending.collect::<Result<Vec<_>, CalibrationError>>();
    stage.finish();
    if monitor.cancelled() {
        return Err(CalibrationError::Cancelled);
    }
    Ok(LearnedSamples { discrepancy: learned?, pending: pending? })
}

/// What pressures and speeds count from: the measurements on flat samples.
fn conditions(task: &CalibrationTask) -> Conditions {
    let usual = Conditions::default();
    let count = task.flat.len();
    if count == 0 {
        return usual;
    }
    let pressures = || task.flat.iter().map(|measured| task.pressure_pa(measured));
    let speeds = task.flat.iter().map(|measured| measured.speed_m_s.ln());
    Conditions {
        reference_pressure_pa: tidy(pressures().sum::<f64>() / count as f64),
        lowest_pressure_pa: tidy(pressures().fold(f64::INFINITY, f64::min)),
        reference_speed_m_s: tidy((speeds.sum::<f64>() / count as f64).exp()),
    }
}

/// A sample beside the model, its numbers to the digits that a material file holds, and what is not modelled of it as it is of designs.
///
/// A modelled ratio depends on local friction by a thousandth at most, and in space linearly but for 5e-5: there it is solved at each
/// force for the least and the greatest, as a load takes a tenth of a second. In the plane it is solved for every friction.
///
/// A run in time adds what designs, too, have in their confirmed ratios: without it, it would count among what the model lacks, and designs
/// that aim with that would have it twice.
fn trial(
    task: &CalibrationTask,
    cut: &CutSample,
    law: (Option<&AreaLaw>, &[AreaPoint]),
    monitor: &dyn Monitor,
) -> Result<(Trial, Option<String>), CalibrationError> {
    let axes: Vec<usize> = (0..3).filter(|axis| cut.dimensions_std_m[*axis] > 0.0).collect();
    let monitor = Part::new(monitor, 1.0 / (2 + axes.len()) as f64);
    let CutSpecimen { face, thickness_m } = cut.specimen;
    let model = |pattern: Pattern| Model { task, law, pattern, relief: cut.relief.clone(), thickness_m };
    let pairs = pairs(task, &cut.measured);
    let is_cheap = Dimension::of(None, cut.pattern.texture()).is_cheap_per_design();
    let ends = if is_cheap { Ends { solved: pairs.clone() } } else { Ends::new(&pairs) };
    let (steady, added) = rayon::join(
        || model(cut.pattern).sensitive_ratios(&ends.solved, face.as_ref(), &monitor),
        || model(cut.pattern).added_by_time(&pairs, face.as_ref(), &Part::new(&monitor, 0.0)),
    );
    let ((steady, on_face), added) = (steady?, added?);
    let face = (&ends.solved[..], on_face.as_ref());
    let by_local_law = model(cut.pattern).local_law_ratios(&pairs, face, &monitor)?;
    let known = pairs.iter().zip(&added.at).zip(by_local_law);
    let known = known.filter_map(|((pair, added), by_local_law)| {
        let [ratio, modulus] = ends.between(pair, |place| steady[place])?;
        let local_law = by_local_law.map_or(0.0, |by_local_law| (by_local_law / ratio).ln());
        Some((pair, ratio, Sensitivity { modulus, local_law }, *added))
    });
    let known: Vec<(&Pair, f64, Sensitivity, f64)> = known.collect();
    let mut dimension_shifts = Vec::new();
    for axis in axes {
        let lengths_m = cut.pattern.lengths_m();
        // One standard error upwards: a cavity of a rough edge is rather too large than too small.
        let [width_m, spacing_m, depth_m] = std::array::from_fn(|other| {
            lengths_m[other] + if other == axis { cut.dimensions_std_m[axis] } else { 0.0 }
        });
        let Ok(moved) = Pattern::new(*cut.pattern.texture(), width_m, spacing_m, depth_m) else { continue };
        let others = model(moved).ratios(&ends.solved, on_face.as_ref(), &monitor)?;
        let change = |(pair, own, _, added): &(&Pair, f64, Sensitivity, f64)| {
            let [other] = ends.between(pair, |place| Some([others[place]?]))?;
            Some(tidy(((other + added) / (own + added)).ln()))
        };
        let log_ratio = known.iter().map(change).collect::<Option<Vec<f64>>>();
        let above = tidy_features(&moved);
        dimension_shifts.extend(log_ratio.map(|log_ratio| DimensionShift { log_ratio, above, below: None }));
    }
    // d ln (r + a) = r / (r + a) d ln r
    let measured = known.iter().map(|([flat, patterned], steady, sensitivity, added)| Measured {
        load: Load {
            pressure_pa: tidy(task.pressure_pa(flat)),
            speed_m_s: tidy(flat.speed_m_s),
            humidity: tidy(flat.humidity),
        },
        measured: tidy(patterned.mu_dynamic / flat.mu_dynamic),
        modelled: tidy(steady + added),
        patterned_std: tidy(patterned.mu_dynamic_std / patterned.mu_dynamic),
        flat_std: tidy(flat.mu_dynamic_std / flat.mu_dynamic),
        sensitivity: Sensitivity {
            modulus: tidy(sensitivity.modulus * steady / (steady + added)),
            local_law: tidy(sensitivity.local_law * steady / (steady + added)),
        },
    });
    let warning = added.unknown.map(|unknown| format!("trial \"{}\": {unknown}", cut.name));
    let trial = Trial {
        name: cut.name.clone(),
        features: tidy_features(&cut.pattern),
        sample_std: cut.sample_std,
        disc: cut.disc.clone(),
        measured: measured.collect(),
        dimensions_std_m: cut.dimensions_std_m.map(tidy),
        dimension_shifts,
    };
    Ok((trial, warning))
}

/// Features of `pattern` to the digits that a material file holds.
fn tidy_features(pattern: &Pattern) -> Features {
    let features = Features::from(pattern);
    Features {
        areal_density: tidy(features.areal_density),
        edge_1_m: tidy(features.edge_1_m),
        width_m: tidy(features.width_m),
        pitch_m: tidy(features.pitch_m),
        depth_m: tidy(features.depth_m),
    }
}

/// What trials say, for the material's notes; `None` without any that was measured.
pub(crate) fn note(learned: &Discrepancy) -> Option<String> {
    let trial = learned.trials().iter().rfind(|trial| !trial.measured.is_empty())?;
    let ratios: usize = learned.trials().iter().map(|trial| trial.measured.len()).sum();
    let at = trial.measured.first()?;
    let found = learned.at(&[at.load]).predict(&trial.features, &[at.sensitivity]);
    let Load { pressure_pa, speed_m_s, humidity } = at.load;
    Some(format!(
        "trials: {ratios} measured ratio{} of {} sample{}. At the texture of \"{}\", {:.3} MPa, {} mm/s and {} % a sample's true ratio is \
         {:.3} times the modelled one (95 % of samples: {:.3} to {:.3}); this is kept apart from the physics, in [learned]",
        if ratios == 1 { "" } else { "s" },
        learned.trials().len(),
        if learned.trials().len() == 1 { "" } else { "s" },
        trial.name,
        PRESSURE_MPA.from_si(pressure_pa),
        tidy(SPEED_MM_S.from_si(speed_m_s)),
        tidy(HUMIDITY_PCT.from_si(humidity)),
        found.quantile(0, 0.5).exp(),
        found.quantile(0, 0.025).exp(),
        found.quantile(0, 0.975).exp(),
    ))
}

/// The pairs that are solved, and what lies between them.
struct Ends {
    /// All, or at each force that of the least and that of the greatest flat friction, where they differ.
    solved: Vec<Pair>,
}

impl Ends {
    fn new(pairs: &[Pair]) -> Self {
        let mut solved: Vec<Pair> = Vec::new();
        for [flat, _] in pairs {
            if solved.iter().any(|[own, _]| own.force_n == flat.force_n) {
                continue;
            }
            let mut alike: Vec<&Pair> = pairs.iter().filter(|[other, _]| other.force_n == flat.force_n).collect();
            alike.sort_by(|a, b| a[0].mu_dynamic.total_cmp(&b[0].mu_dynamic));
            let (least, most) = (*alike[0], *alike[alike.len() - 1]);
            solved.push(least);
            solved.extend((most[0].mu_dynamic > least[0].mu_dynamic).then_some(most));
        }
        Self { solved }
    }

    /// What `at` says of the solved pairs, linear in flat friction between those at the force of `pair`.
    fn between<const N: usize>(&self, pair: &Pair, at: impl Fn(usize) -> Option<[f64; N]>) -> Option<[f64; N]> {
        if let Some(place) = self.solved.iter().position(|own| own == pair) {
            return at(place);
        }
        let [flat, _] = pair;
        let first = self.solved.iter().position(|[own, _]| own.force_n == flat.force_n)?;
        let least = at(first)?;
        let Some([most, _]) = self.solved.get(first + 1).filter(|[most, _]| most.force_n == flat.force_n) else {
            return Some(least);
        };
        let from = self.solved[first][0].mu_dynamic;
        let t = (flat.mu_dynamic - from) / (most.mu_dynamic - from);
        let greatest = at(first + 1)?;
        Some(std::array::from_fn(|value| least[value] + t * (greatest[value] - least[value])))
    }
}

#[cfg(test)]
mod tests {
    use slipgrid_material::Elastic;
    use slipgrid_monitor::Unwatched;
    use slipgrid_pattern::Planform;
    use slipgrid_springblock::Layer;

    use super::*;
    use crate::uncertainty::{flat_friction, local_law};
    use crate::{Coefficients, Selection};

    fn measured(force_n: f64, humidity: f64, mu_dynamic: f64) -> Measurement {
        Measurement { force_n, speed_m_s: 2e-3, humidity, mu_dynamic, mu_dynamic_std: 0.002, static_peak: None }
    }

    fn task(flat: Vec<Measurement>, planform: Planform) -> CalibrationTask {
        let sample = CutSample {
            name: "cut".to_owned(),
            date: String::new(),
            notes: String::new(),
            pattern: Pattern::new(planform, 130e-6, 170e-6, 12e-6).unwrap(),
            relief: None,
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
            layer: Layer { length_m: 500e-6, height_m: 100e-6, block_m: 10e-6, thickness_m: None },
            seed: 1,
            selection: Selection::default(),
            notes: Vec::new(),
            doubts: Vec::new(),
        }
    }

    /// Friction between that of two other measurements at its force, in the plane and in space.
    #[test]
    fn between_two_frictions_the_modelled_ratio_is_linear() {
        for planform in [Planform::Groove, Planform::Square] {
            let flat = vec![
                measured(100.0, 0.8, 0.32),
                measured(100.0, 0.4, 0.27),
                measured(100.0, 0.15, 0.24),
                measured(200.0, 0.4, 0.3),
            ];
            // What time adds is known in the plane alone, at the mean friction of a force, within the error of a run.
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
            layer: Layer { length_m: 5e-3, height_m: 200e-6, block_m: 10e-6, thickness_m: None },
            surface: Surface::None,
            ..task(flat, Planform::Groove)
        };
        let alike = CalibrationTask { relative_std: 0.0, static_over_dynamic: 1.0, ..scattered.clone() };
        let modelled = |task: &CalibrationTask| -> Vec<f64> {
            let learned = learn_alone(task, &Unwatched).unwrap().discrepancy;
            learned.trials()[0].measured.iter().map(|at| at.modelled).collect()
        };
        // At the mean friction of each force.
        let load = |force_n: f64, mean: f64| slipgrid_springblock::Load {
            pressure_pa: force_n / 78.54e-6,
            friction: slipgrid_material::LocalFriction::new(0.30 / 0.27 * mean, mean, 0.05).unwrap(),
        };
        let scene = slipgrid_springblock::Scene {
            elastic: scattered.elastic,
            area_law: None,
            pattern: Some(scattered.trials.samples[0].pattern),
            relief: None,
            layer: scattered.layer,
            loads: vec![load(50.0, 0.27), load(200.0, 0.3)],
            speed_m_s: 2e-3,
            run: slipgrid_springblock::RunOptions { seed: 1, ..slipgrid_springblock::RunOptions::default() },
        };
        let added = slipgrid_specimen::time_changes_on(&scene, None, &Unwatched).unwrap();
        let [light, heavy] = [0, 1].map(|place| added[place].unwrap());
        assert!(light > 4e-3 && heavy > 4e-3, "{light} {heavy}");
        let found = modelled(&scattered).into_iter().zip(modelled(&alike));
        for ((scattered, alike), added) in found.zip([light, light, heavy]) {
            // To blocks that are all alike it adds less.
            assert!((scattered - alike - added).abs() < 1e-3, "{scattered} {alike} {added}");
        }
    }

    /// Designs take a fitted law and a measured one as they are, whatever the modulus: what a trial laid to the modulus would be lost to them.
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
        // What is measured of a texture is predicted of it, whatever slope along the modulus is asked with.
        let trial = &fitted.trials()[0];
        let at: Vec<Load> = trial.measured.iter().map(|at| at.load).collect();
        let of_slope =
            |g: f64| fitted.at(&at).predict(&trial.features, &vec![Sensitivity::of_modulus(g); at.len()]).medians();
        assert_eq!(of_slope(0.0), of_slope(0.2));
    }

    /// In the plane and in space, in which friction between two others is interpolated.
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
            for row in 0..2 {
                let [own, other] = [&modelled, &by_law].map(|of| of.trials()[0].measured[row]);
                let (change, expected) = (own.sensitivity.local_law, (other.modelled / own.modelled).ln());
                assert!(
                    expected > 0.005 && (change - expected).abs() < 1e-3,
                    "{planform:?} {row}: {change} {expected}"
                );
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
        assert_eq!(found.pending[0], PendingSample::from(known.discrepancy.trials()[0].clone()));
    }
}
