//! Trials: samples that were cut and measured, and the discrepancy learned from them.

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

use crate::patterned_samples::{Model, Pair, pair_measurements};
use crate::surface_area_law_source::surface_findings;
use crate::{CalibrationError, CalibrationTask, Measurement, PendingSample, Surface};
use slipgrid_monitor::Part;

/// A sample that was cut; it is pending if it has no measurements.
#[derive(Clone, Debug, PartialEq)]
pub struct CutSample {
    /// Name of the sample.
    pub name: String,
    /// Date of the measurement as written in the file, or empty.
    pub date: String,
    /// Free text from the file.
    pub notes: String,
    /// Pattern, as measured or as designed.
    pub pattern: Pattern,
    /// Measured heights of the face over one period, instead of rims.
    pub relief: Option<Arc<ReliefMap>>,
    /// Standard errors of width, spacing and depth, in metres; 0 for exact dimensions.
    pub dimensions_std_m: [f64; 3],
    /// Standard deviation of the logarithm of the ratio between samples of one texture, if known.
    pub sample_std: Option<f64>,
    /// Name of the disc if the sample is one of several sectors of it; `None` if it has its own disc.
    pub disc: Option<String>,
    /// Specimen into which the sample was cut.
    pub specimen: CutSpecimen,
    /// Measurements; empty while the sample is pending.
    pub measured: Vec<Measurement>,
}

/// Specimen into which a sample was cut.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CutSpecimen {
    /// Face, and treatment of cavities that cross its border; `None` for an infinite pattern, as on a sector of a disc.
    pub face: Option<Specimen>,
    /// Thickness, in metres, if it differs from that of the task's layer.
    pub thickness_m: Option<f64>,
}

/// Input for learning from trials.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrialsTask {
    /// Samples, earliest first.
    pub samples: Vec<CutSample>,
    /// Prior of the discrepancy.
    pub prior: Hyperparameters,
}

/// Result of learning from trials.
#[derive(Clone, Debug, PartialEq)]
pub struct Learned {
    /// Posterior of the discrepancy.
    pub discrepancy: Discrepancy,
    /// Warnings about samples that are not modelled like designs, one sentence each.
    pub warnings: Vec<String>,
}

/// Learns the discrepancy from the samples of `task`, with the area law from the contact area `curve`, or `law` itself
/// if `curve` is empty. Without samples the result is the prior.
///
/// # Errors
/// [`CalibrationError`] if a scene or the discrepancy is invalid, or the monitor cancels.
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
    // As for designs: ratios depend on the modulus through the area law only.
    let (_, curve) = law;
    let modulus = if curve.is_empty() { 0.0 } else { tidy(task.modulus_relative_std().unwrap_or(0.0)) };
    let discrepancy = Discrepancy::new(task.trials.prior.clone(), conditions(task), modulus, trials);
    Ok(Learned {
        discrepancy: discrepancy.map_err(CalibrationError::Trials)?,
        warnings: warnings.into_iter().flatten().collect(),
    })
}

/// Memory, in bytes, for the strips of the largest measured sample of `task`; samples are modelled one after the other.
///
/// # Errors
/// [`CalibrationError`] if a sample is invalid or needs more memory than available.
pub fn sample_bytes(task: &CalibrationTask) -> Result<f64, CalibrationError> {
    let law = (None, &[][..]);
    let mut most = 0.0_f64;
    for cut in task.trials.samples.iter().filter(|sample| !sample.measured.is_empty()) {
        let CutSpecimen { face, thickness_m } = cut.specimen;
        let Some(face) = &face else { continue };
        let model = Model { task, law, pattern: cut.pattern, relief: cut.relief.clone(), thickness_m };
        most = most.max(model.face_bytes(face, &pair_measurements(task, &cut.measured))?);
    }
    Ok(most)
}

/// Discrepancy learned from a calibration's samples, and modelled ratios of pending samples.
#[derive(Clone, Debug, PartialEq)]
pub struct LearnedSamples {
    /// Posterior of the discrepancy.
    pub discrepancy: Discrepancy,
    /// Modelled ratios of the pending samples.
    pub pending: Vec<PendingSample>,
}

/// Learns from trials without a fit to flat samples, unless the area law is fitted to them. Stages of the monitor:
/// those of the area law, "calibration" if a fit is made, and "trials".
///
/// # Errors
/// See [`crate::run`].
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
        // Flat measurements stand in for patterned ones; only the modelled values are used.
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

/// Reference pressure and speed of the discrepancy, from the measurements on flat samples.
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

/// Models a measured sample. Returns its measured and modelled ratios, rounded as in a material file, and a warning if
/// it is not modelled like designs.
///
/// A modelled ratio depends on local friction by a thousandth at most. In three dimensions, where one load takes a
/// tenth of a second, it is solved for the lowest and highest friction at each force and interpolated, with an error of
/// 5e-5. In the plane it is solved for every friction.
///
/// The correction for sliding in time is included, as in the confirmed ratios of designs. Otherwise it would become
/// part of the discrepancy and would be counted twice in designs.
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
    let pairs = pair_measurements(task, &cut.measured);
    let is_cheap = Dimension::of(None, cut.pattern.texture()).is_cheap_per_design();
    let solved_pairs = if is_cheap { SolvedPairs { solved: pairs.clone() } } else { SolvedPairs::new(&pairs) };
    let (steady, added) = rayon::join(
        || model(cut.pattern).sensitive_ratios(&solved_pairs.solved, face.as_ref(), &monitor),
        || model(cut.pattern).time_changes(&pairs, face.as_ref(), &Part::new(&monitor, 0.0)),
    );
    let ((steady, on_face), added) = (steady?, added?);
    let face = (&solved_pairs.solved[..], on_face.as_ref());
    let by_local_law = model(cut.pattern).local_law_ratios(&pairs, face, &monitor)?;
    let known = pairs.iter().zip(&added.at).zip(by_local_law);
    let known = known.filter_map(|((pair, added), by_local_law)| {
        let [ratio, modulus] = solved_pairs.between(pair, |place| steady[place])?;
        let local_law = by_local_law.map_or(0.0, |by_local_law| (by_local_law / ratio).ln());
        Some((pair, ratio, Sensitivity { modulus, local_law }, *added))
    });
    let known: Vec<(&Pair, f64, Sensitivity, f64)> = known.collect();
    let mut dimension_shifts = Vec::new();
    for axis in axes {
        let lengths_m = cut.pattern.lengths_m();
        // One standard error upwards: a cavity with a rough edge is more likely too large than too small.
        let [width_m, spacing_m, depth_m] = std::array::from_fn(|other| {
            lengths_m[other] + if other == axis { cut.dimensions_std_m[axis] } else { 0.0 }
        });
        let Ok(moved) = Pattern::new(*cut.pattern.texture(), width_m, spacing_m, depth_m) else { continue };
        let others = model(moved).ratios(&solved_pairs.solved, on_face.as_ref(), &monitor)?;
        let change = |(pair, own, _, added): &(&Pair, f64, Sensitivity, f64)| {
            let [other] = solved_pairs.between(pair, |place| Some([others[place]?]))?;
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

/// Features of `pattern`, rounded as in a material file.
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

/// Note on the trials for the material; `None` without measured trials.
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

/// Pairs that are solved; others are interpolated.
struct SolvedPairs {
    /// All pairs, or those with the lowest and highest flat friction at each force.
    solved: Vec<Pair>,
}

impl SolvedPairs {
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

    /// Value of `at` for `pair`, interpolated linearly in flat friction between the solved pairs at its force.
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
            // For equal blocks the correction is smaller.
            assert!((scattered - alike - added).abs() < 1e-3, "{scattered} {alike} {added}");
        }
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
