//! Measured ratios of patterned samples beside the modelled ones, and the discrepancy between the two.

use std::sync::Arc;

use rayon::prelude::*;
use slipgrid_contact::AreaPoint;
use slipgrid_material::{AreaLaw, Elastic, LocalFriction, MaterialError};
use slipgrid_monitor::Monitor;
use slipgrid_pattern::{Pattern, ReliefMap};
use slipgrid_springblock::{Layer, Load, RunOptions, Scene, Status, simulate};

use crate::area_law::area_law;
use crate::flat_sample::Portion;
use crate::select_measurements::FEWEST_AT_HUMIDITY;
use crate::{
    CalibrationError, CalibrationTask, Discrepancy, DiscrepancyByHumidity, Measurement, RatioInterval, RatioPoint,
    estimate_discrepancy, leave_one_out,
};

/// Step of ln E behind the sensitivity: small against the modulus's own error, large against rounding.
const LOG_MODULUS_STEP: f64 = 0.02;

/// One condition measured on both kinds of sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RatioAtCondition {
    /// The measurement on the flat sample.
    pub flat: Measurement,
    /// Measured and modelled ratio.
    pub point: RatioPoint,
    /// The ratio predicted by the discrepancy of all other conditions; `None` where those are too few.
    pub left_out: Option<RatioInterval>,
    /// The same by the other conditions at its humidity.
    pub left_out_at_humidity: Option<RatioInterval>,
}

/// The discrepancy with what each condition says without itself.
#[derive(Clone, Debug, PartialEq)]
pub struct PatternedSamples {
    /// Conditions measured on both kinds of sample.
    pub rows: Vec<RatioAtCondition>,
    /// The pattern of the samples.
    pub pattern: Pattern,
    /// Standard deviation of Young's modulus over itself; 0 where it is not known.
    pub modulus_relative_std: f64,
    /// The discrepancy over all conditions and at humidities.
    pub discrepancies: DiscrepancyByHumidity,
}

impl PatternedSamples {
    /// What the discrepancy says, for the material's notes.
    #[must_use]
    pub fn note(&self) -> String {
        let all = &self.discrepancies.all;
        let factor = all.factor(all.reference_pressure_pa);
        let found = all.correct(all.reference_pressure_pa, factor, 0.0);
        format!(
            "discrepancy: on the patterned samples measured ratios are {factor:.3} times the modelled ones (95 % of conditions within {:.3} to {:.3}); it is kept apart from the physics, in [discrepancy], and holds for patterns like theirs alone",
            found.interval[0] / factor,
            found.interval[1] / factor
        )
    }
}

/// Compares the `patterned` measurements of `task` with the model, by an area law that follows from a contact area `curve`, or
/// by `law` itself where there is no curve; `None` without patterned samples, their pattern, or where no discrepancy is wanted.
///
/// # Errors
/// [`CalibrationError`] if the numbers make no scene or no discrepancy, or the monitor asks to stop.
pub fn compare(
    task: &CalibrationTask,
    patterned: &[Measurement],
    law: Option<&AreaLaw>,
    curve: &[AreaPoint],
    monitor: &dyn Monitor,
) -> Result<Option<PatternedSamples>, CalibrationError> {
    let (Some(form), Some(pattern)) = (task.discrepancy, task.pattern) else { return Ok(None) };
    let model = Model { task, law: (law, curve), pattern, relief: task.relief.clone() };
    let (flat, points) = ratio_points(&model, patterned, monitor)?;
    if points.is_empty() {
        return Ok(None);
    }
    let modulus_relative_std = task.modulus_relative_std().unwrap_or(0.0);
    let all = estimate_discrepancy(&points, form, modulus_relative_std).map_err(CalibrationError::Discrepancy)?;
    let left_out = leave_one_out(&points, form, modulus_relative_std);
    let mut rows: Vec<RatioAtCondition> = flat
        .into_iter()
        .zip(&points)
        .zip(left_out)
        .map(|((flat, &point), left_out)| RatioAtCondition { flat, point, left_out, left_out_at_humidity: None })
        .collect();
    let mut by_humidity: Vec<(f64, Discrepancy)> = Vec::new();
    for place in 0..rows.len() {
        let humidity = rows[place].flat.humidity;
        if by_humidity.iter().any(|(known, _)| *known == humidity) {
            continue;
        }
        let members: Vec<usize> = (0..rows.len()).filter(|&i| rows[i].flat.humidity == humidity).collect();
        let own: Vec<RatioPoint> = members.iter().map(|&i| points[i]).collect();
        if own.len() >= FEWEST_AT_HUMIDITY {
            let found =
                estimate_discrepancy(&own, form, modulus_relative_std).map_err(CalibrationError::Discrepancy)?;
            by_humidity.push((humidity, found));
            for (&i, found) in members.iter().zip(leave_one_out(&own, form, modulus_relative_std)) {
                rows[i].left_out_at_humidity = found;
            }
        }
    }
    let discrepancies = DiscrepancyByHumidity { all, by_humidity };
    Ok(Some(PatternedSamples { rows, pattern, modulus_relative_std, discrepancies }))
}

/// A measurement on a flat sample and that on a patterned one at the same condition.
pub(crate) type Pair = [Measurement; 2];

/// Conditions of `patterned` that were measured on a flat sample as well.
pub(crate) fn pairs(task: &CalibrationTask, patterned: &[Measurement]) -> Vec<Pair> {
    let same = |a: f64, b: f64| (a - b).abs() <= 1e-6 * a.abs().max(b.abs());
    let pair = |patterned: &Measurement| {
        let alike = |flat: &&Measurement| {
            same(flat.force_n, patterned.force_n)
                && same(flat.speed_m_s, patterned.speed_m_s)
                && same(flat.humidity, patterned.humidity)
        };
        Some([*task.flat.iter().find(alike)?, *patterned])
    };
    patterned.iter().filter_map(pair).collect()
}

/// What the model says of a sample.
pub(crate) struct Model<'a> {
    pub task: &'a CalibrationTask,
    /// The law, and the contact area that it follows from where it moves with the modulus.
    pub law: (Option<&'a AreaLaw>, &'a [AreaPoint]),
    pub pattern: Pattern,
    pub relief: Option<Arc<ReliefMap>>,
}

impl Model<'_> {
    /// Modelled ratio of each pair; `None` where a load did not converge.
    pub fn ratios(&self, pairs: &[Pair], monitor: &dyn Monitor) -> Result<Vec<Option<f64>>, CalibrationError> {
        self.ratios_at(0.0, pairs, monitor)
    }

    /// The same with d ln(modelled) / d ln(E).
    pub fn sensitive_ratios(
        &self,
        pairs: &[Pair],
        monitor: &dyn Monitor,
    ) -> Result<Vec<Option<[f64; 2]>>, CalibrationError> {
        let third = Portion { whole: monitor, share: 1.0 / 3.0 };
        let steps = [-LOG_MODULUS_STEP, 0.0, LOG_MODULUS_STEP];
        let all: Vec<Vec<Option<f64>>> =
            steps.par_iter().map(|&step| self.ratios_at(step, pairs, &third)).collect::<Result<_, _>>()?;
        let at = |i: usize| {
            let sensitivity = (all[2][i]?.ln() - all[0][i]?.ln()) / (2.0 * LOG_MODULUS_STEP);
            Some([all[1][i]?, sensitivity])
        };
        Ok((0..pairs.len()).map(at).collect())
    }

    fn ratios_at(
        &self,
        log_modulus: f64,
        pairs: &[Pair],
        monitor: &dyn Monitor,
    ) -> Result<Vec<Option<f64>>, CalibrationError> {
        let (law, curve) = self.law;
        let law = match law {
            None => None,
            // A measured law is moved by no modulus.
            Some(law) if curve.is_empty() => Some(law.clone()),
            Some(_) => Some(stiffer(curve, log_modulus, self.task.threshold_pa)?),
        };
        let elastic = self.task.elastic.at_modulus(log_modulus.exp())?;
        ratios(self, elastic, law, pairs, monitor)
    }
}

/// A measured ratio of a pair with its standard deviation.
fn measured_ratio([flat, patterned]: &Pair) -> [f64; 2] {
    let measured = patterned.mu_dynamic / flat.mu_dynamic;
    let relative = (patterned.mu_dynamic_std / patterned.mu_dynamic).hypot(flat.mu_dynamic_std / flat.mu_dynamic);
    [measured, measured * relative]
}

/// Conditions measured on both kinds of sample whose modelled ratio converged: the flat sample's measurement, and the ratios.
fn ratio_points(
    model: &Model<'_>,
    patterned: &[Measurement],
    monitor: &dyn Monitor,
) -> Result<(Vec<Measurement>, Vec<RatioPoint>), CalibrationError> {
    let pairs = pairs(model.task, patterned);
    let modelled = model.sensitive_ratios(&pairs, monitor)?;
    let point = |(pair, modelled): (&Pair, Option<[f64; 2]>)| {
        let ([measured, measured_std], [modelled, modulus_sensitivity]) = (measured_ratio(pair), modelled?);
        let pressure_pa = model.task.pressure_pa(&pair[0]);
        Some((pair[0], RatioPoint { pressure_pa, measured, measured_std, modelled, modulus_sensitivity }))
    };
    Ok(pairs.iter().zip(modelled).filter_map(point).unzip())
}

/// The law of a surface whose modulus is larger by the factor exp(log_modulus): A(P; c E) = A(P / c; E).
fn stiffer(curve: &[AreaPoint], log_modulus: f64, threshold_pa: f64) -> Result<AreaLaw, MaterialError> {
    let factor = log_modulus.exp();
    let moved: Vec<AreaPoint> =
        curve.iter().map(|point| AreaPoint { pressure_pa: point.pressure_pa * factor, ..*point }).collect();
    area_law(&moved, threshold_pa)
}

/// Modelled ratios of the patterned samples: steady cells, the flat surface at its measured friction. `None` where a load did
/// not converge.
fn ratios(
    Model { task, pattern, relief, .. }: &Model<'_>,
    elastic: Elastic,
    area_law: Option<AreaLaw>,
    pairs: &[Pair],
    monitor: &dyn Monitor,
) -> Result<Vec<Option<f64>>, CalibrationError> {
    let loads = pairs
        .iter()
        .map(|[flat, _]| {
            let pressure_pa = task.pressure_pa(flat);
            // A flat cell slides at mu_flat = mu_d f(P).
            let mean = flat.mu_dynamic / area_law.as_ref().map_or(1.0, |law| law.factor(pressure_pa));
            Ok(Load { pressure_pa, friction: LocalFriction::new(mean, mean, 0.0)? })
        })
        .collect::<Result<Vec<Load>, MaterialError>>()?;
    let Some(speed_m_s) = pairs.first().map(|[flat, _]| flat.speed_m_s) else { return Ok(Vec::new()) };
    let block_m = match (pattern.texture().rim(), relief) {
        (Some(rim), _) => rim.block_m(task.layer.block_m),
        // Measured rims are some ten micrometres wide.
        (None, Some(_)) => 0.5 * task.layer.block_m,
        (None, None) => task.layer.block_m,
    };
    let scene = Scene {
        elastic,
        area_law,
        pattern: Some(*pattern),
        relief: relief.clone(),
        layer: Layer { block_m, ..task.layer },
        loads,
        // Steady sliding does not depend on it.
        speed_m_s,
        run: RunOptions::default(),
    };
    let simulation = simulate(&scene, monitor)?;
    let converged = simulation.loads.iter().map(|load| load.ratio.filter(|_| load.surface.status == Status::Converged));
    Ok(converged.collect())
}
