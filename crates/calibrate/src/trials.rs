//! Trials: samples that were cut and measured, and the discrepancy that they say.

use std::sync::Arc;

use slipgrid_contact::AreaPoint;
use slipgrid_discrepancy::{Conditions, Discrepancy, Features, Hyperparameters, Load, Measured, Trial};
use slipgrid_material::AreaLaw;
use slipgrid_monitor::{Monitor, Stage};
use slipgrid_pattern::{Pattern, ReliefMap};
use slipgrid_units::tidy;

use crate::flat_sample::Portion;
use crate::patterned_samples::{Sample, ratio_points};
use crate::surface_findings::surface_findings;
use crate::{CalibrationError, CalibrationTask, Measurement, RatioPoint, Surface};

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
    /// Measurements on it; none while it is pending.
    pub measured: Vec<Measurement>,
}

/// What is wanted of trials: the samples, and what is believed before.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrialsTask {
    /// The samples, the earliest first.
    pub samples: Vec<CutSample>,
    /// What is believed before anything was measured.
    pub prior: Hyperparameters,
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
) -> Result<Discrepancy, CalibrationError> {
    let measured: Vec<&CutSample> = task.trials.samples.iter().filter(|sample| !sample.measured.is_empty()).collect();
    let monitor = Portion { whole: monitor, share: 1.0 / measured.len().max(1) as f64 };
    let trials = measured.into_iter().map(|sample| trial(task, sample, law, &monitor));
    let trials = trials.collect::<Result<Vec<Trial>, CalibrationError>>()?;
    let modulus = tidy(task.modulus_relative_std().unwrap_or(0.0));
    Discrepancy::new(task.trials.prior.clone(), conditions(task), modulus, trials).map_err(CalibrationError::Trials)
}

/// The same without fitting anything to flat samples, but where the area law is fitted to them. Stages of the monitor: those of the
/// area law, "calibration" where there is one, and "trials".
///
/// # Errors
/// As [`crate::run`].
pub fn learn_alone(task: &CalibrationTask, monitor: &dyn Monitor) -> Result<Discrepancy, CalibrationError> {
    if matches!(task.surface, Surface::FittedScale { .. }) {
        let learned = crate::run(task, monitor)?.uncertainty.learned;
        return learned.ok_or(CalibrationError::Cancelled);
    }
    let surface = surface_findings(task, monitor)?;
    let stage = Stage::new(monitor, "trials", None);
    let learned = learn(task, (surface.law.as_ref(), &surface.curve), &stage);
    stage.finish();
    if monitor.cancelled() { Err(CalibrationError::Cancelled) } else { learned }
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

/// A sample beside the model, its numbers to the digits that a material file holds.
fn trial(
    task: &CalibrationTask,
    cut: &CutSample,
    law: (Option<&AreaLaw>, &[AreaPoint]),
    monitor: &dyn Monitor,
) -> Result<Trial, CalibrationError> {
    let axes: Vec<usize> = (0..3).filter(|axis| cut.dimensions_std_m[*axis] > 0.0).collect();
    let monitor = Portion { whole: monitor, share: 1.0 / (1 + axes.len()) as f64 };
    let of = |pattern: Pattern| {
        let sample = Sample { pattern, relief: cut.relief.clone() };
        ratio_points(task, &cut.measured, law, &sample, &monitor)
    };
    let (pairs, points) = of(cut.pattern)?;
    let mut of_dimensions = Vec::new();
    for axis in axes {
        let lengths_m = [cut.pattern.width_m(), cut.pattern.spacing_m(), cut.pattern.depth_m()];
        // One standard error upwards: a cavity of a rough edge is rather too large than too small.
        let [width_m, spacing_m, depth_m] = std::array::from_fn(|other| {
            lengths_m[other] + if other == axis { cut.dimensions_std_m[axis] } else { 0.0 }
        });
        let moved = Pattern::new(*cut.pattern.texture(), width_m, spacing_m, depth_m);
        let Ok(moved) = moved else { continue };
        let (_, others) = of(moved)?;
        if others.len() == points.len() {
            let change = |(other, own): (&RatioPoint, &RatioPoint)| tidy((other.modelled / own.modelled).ln());
            of_dimensions.push(others.iter().zip(&points).map(change).collect());
        }
    }
    let measured = pairs.iter().zip(&points).map(|([flat, patterned], point)| Measured {
        load: Load {
            pressure_pa: tidy(point.pressure_pa),
            speed_m_s: tidy(flat.speed_m_s),
            humidity: tidy(flat.humidity),
        },
        measured: tidy(point.measured),
        modelled: tidy(point.modelled),
        patterned_std: tidy(patterned.mu_dynamic_std / patterned.mu_dynamic),
        flat_std: tidy(flat.mu_dynamic_std / flat.mu_dynamic),
        modulus_sensitivity: tidy(point.modulus_sensitivity),
    });
    let features = Features::from(&cut.pattern);
    let features = Features {
        areal_density: tidy(features.areal_density),
        edge_1_m: tidy(features.edge_1_m),
        width_m: tidy(features.width_m),
        pitch_m: tidy(features.pitch_m),
        depth_m: tidy(features.depth_m),
    };
    let name = cut.name.clone();
    Ok(Trial { name, features, sample_std: cut.sample_std, measured: measured.collect(), of_dimensions })
}
