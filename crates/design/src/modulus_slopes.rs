//! How modelled ratios follow Young's modulus, and where a task asks for friction as trials know it.

use std::fmt::Debug;

use slipgrid_calibrate::uncertainty::{MaterialUncertainty, ScaleShift, moved};
use slipgrid_discrepancy::{Discrepancy, Load};
use slipgrid_optimize::ModelFailure;
use slipgrid_pattern::Pattern;
use slipgrid_springblock::Scene;

use crate::operating_conditions::Further;
use crate::steady_model::SteadyModel;
use crate::task::DesignTask;
use crate::{DesignError, Refusal, TaskPart};

/// Logarithm of Young's modulus by which it is moved for the slope along it.
const LOG_MODULUS_STEP: f64 = 0.05;
/// Relative humidity where neither design nor trials name one.
const USUAL_HUMIDITY: f64 = 0.4;

/// How modelled ratios follow Young's modulus: a stiffer and a softer body beside the one of a model.
pub struct ModulusSlopes<'a> {
    /// `None` where the modulus moves nothing.
    both: Option<[SteadyModel<'a>; 2]>,
    loads: usize,
}

impl<'a> ModulusSlopes<'a> {
    /// Those of `own`, whose material is known as `material` says.
    ///
    /// # Errors
    /// [`DesignError`] where the area law cannot be moved.
    pub fn new(own: &SteadyModel<'a>, material: &MaterialUncertainty) -> Result<Self, DesignError> {
        let loads = own.asked().loads.len();
        let still = vec![0.0; loads];
        let at = |log: f64| {
            own.beside(|scene: &Scene| moved(scene, &still, ScaleShift { log, is_fitted: false }, 0.0))
                .map_err(|error| Refusal::new(TaskPart::Whole, error.to_string()))
        };
        let moves = material.modulus_std(own.area_law()).is_some();
        let both = if moves { Some([at(LOG_MODULUS_STEP)?, at(-LOG_MODULUS_STEP)?]) } else { None };
        Ok(Self { both, loads })
    }

    /// Everything that slopes follow from but for the lengths of a design.
    pub(crate) fn content(&self) -> impl Debug + '_ {
        self.both.as_ref().map(|both| both.each_ref().map(SteadyModel::content))
    }

    /// g = d ln R / d ln E of `design` at every load.
    ///
    /// # Errors
    /// [`ModelFailure`] where it cannot be computed.
    pub fn at(&self, design: &Pattern) -> Result<Vec<f64>, ModelFailure> {
        let Some([stiffer, softer]) = &self.both else { return Ok(vec![0.0; self.loads]) };
        // Also where cavities close, so that slopes are smooth up to there.
        let at = |model: &SteadyModel<'_>| model.answer_made(design, &model.lay(design)?);
        let (stiffer, softer) = rayon::join(|| at(stiffer), || at(softer));
        let (stiffer, softer) = (stiffer?.ratio, softer?.ratio);
        let slope = |(above, below): (&f64, &f64)| (above / below).ln() / (2.0 * LOG_MODULUS_STEP);
        Ok(stiffer.iter().zip(&softer).map(slope).collect())
    }
}

/// The relative humidity where nothing names one: the mean of the trials', which is the usual one before any.
pub fn usual_humidity(learned: &Discrepancy) -> f64 {
    let measured = learned.trials().iter().flat_map(|trial| trial.measured.iter().map(|at| at.load.humidity));
    let humidities: Vec<f64> = measured.collect();
    if humidities.is_empty() { USUAL_HUMIDITY } else { humidities.iter().sum::<f64>() / humidities.len() as f64 }
}

/// Where `task` asks for friction, as trials know it: pressure, speed and humidity at every load of `model`.
pub fn loads_of(task: &DesignTask, learned: &Discrepancy, further: &[Further], model: &SteadyModel<'_>) -> Vec<Load> {
    let usual = usual_humidity(learned);
    let conditions: Vec<_> =
        std::iter::once(task.condition).chain(further.iter().map(|further| further.at.condition)).collect();
    let count = task.target.points().len().max(1);
    let at = |(place, load): (usize, &slipgrid_springblock::Load)| {
        let condition = conditions.get(place / count).copied().flatten();
        Load {
            pressure_pa: load.pressure_pa,
            speed_m_s: condition.map_or(task.speed_m_s, |condition| condition.speed_m_s),
            humidity: condition.map_or(usual, |condition| condition.humidity),
        }
    };
    model.asked().loads.iter().enumerate().map(at).collect()
}
