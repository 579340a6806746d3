//! How modelled ratios follow what all textures have in common, and where a task asks for friction as trials know it.

use std::fmt::Debug;

use rayon::prelude::*;
use slipgrid_calibrate::uncertainty::{MaterialUncertainty, ScaleShift, moved, with_local_law};
use slipgrid_discrepancy::{Discrepancy, Load, Sensitivity};
use slipgrid_material::{Condition, MaterialError};
use slipgrid_optimize::ModelFailure;
use slipgrid_pattern::Pattern;
use slipgrid_springblock::Scene;
use slipgrid_units::PRESSURE_MPA;

use crate::operating_conditions::Further;
use crate::steady_model::SteadyModel;
use crate::task::DesignTask;
use crate::{DesignError, Refusal, TaskPart};

/// Logarithm of Young's modulus by which it is moved for the slope along it.
const LOG_MODULUS_STEP: f64 = 0.05;
/// Change of ln R by the local law from which on a design says so.
const NOTED_CHANGE: f64 = 0.002;
/// Relative humidity where neither design nor trials name one.
const USUAL_HUMIDITY: f64 = 0.4;

/// How modelled ratios follow Young's modulus, and the pressure that friction follows: models beside the one that is used.
pub struct Sensitivities<'a> {
    /// Of a stiffer and a softer body; `None` where the modulus moves nothing.
    both: Option<[SteadyModel<'a>; 2]>,
    /// `None` where flat friction follows the area law at every condition.
    by_local_pressure: Option<ByLocalPressure<'a>>,
    loads: usize,
}

/// Models by whose local law friction follows the local pressure, one a condition at which flat friction contradicts the area law.
struct ByLocalPressure<'a> {
    /// By the area law, in the blocks of the others.
    still: SteadyModel<'a>,
    laws: Vec<SteadyModel<'a>>,
    /// Which of them holds at each load.
    of_load: Vec<Option<usize>>,
}

impl<'a> ByLocalPressure<'a> {
    /// Of the material of `own` at the condition of each load.
    fn new(
        own: &SteadyModel<'a>,
        material: &MaterialUncertainty,
        conditions: &[Option<Condition>],
    ) -> Result<Option<Self>, MaterialError> {
        let mut known: Vec<Option<Condition>> = Vec::new();
        let (mut laws, mut places) = (Vec::new(), Vec::new());
        for condition in conditions {
            if known.iter().any(|other| is_same(other, condition)) {
                continue;
            }
            known.push(*condition);
            let law = material.local_law(own.area_law(), condition.as_ref());
            places.push(law.as_ref().map(|_| laws.len()));
            if let Some(law) = law {
                laws.push(own.beside(|scene: &Scene| with_local_law(scene, &law))?);
            }
        }
        if laws.is_empty() {
            return Ok(None);
        }
        let place = |condition: &Option<Condition>| {
            known.iter().position(|other| is_same(other, condition)).and_then(|known| places[known])
        };
        let still = own.beside(|scene: &Scene| Ok::<_, MaterialError>(scene.clone()))?;
        Ok(Some(Self { still, laws, of_load: conditions.iter().map(place).collect() }))
    }

    /// Change of ln R of `design` at every load where friction follows the local pressure.
    fn at(&self, design: &Pattern) -> Result<Vec<f64>, ModelFailure> {
        let models: Vec<&SteadyModel<'_>> = std::iter::once(&self.still).chain(&self.laws).collect();
        let ratios: Vec<Vec<f64>> =
            models.into_par_iter().map(|model| made(model, design)).collect::<Result<_, ModelFailure>>()?;
        let change = |(load, law): (usize, &Option<usize>)| {
            law.map_or(0.0, |law| (ratios[1 + law][load] / ratios[0][load]).ln())
        };
        Ok(self.of_load.iter().enumerate().map(change).collect())
    }
}

fn is_same(one: &Option<Condition>, other: &Option<Condition>) -> bool {
    match (one, other) {
        (Some(one), Some(other)) => one.matches(other),
        (one, other) => one.is_none() && other.is_none(),
    }
}

/// Ratios of `design` by `model`, also where cavities close, so that what follows from them is smooth up to there.
fn made(model: &SteadyModel<'_>, design: &Pattern) -> Result<Vec<f64>, ModelFailure> {
    Ok(model.answer_made(design, &model.lay(design)?)?.ratio)
}

impl<'a> Sensitivities<'a> {
    /// Those of `own`, whose material is known as `material` says, at the condition of each load.
    ///
    /// # Errors
    /// [`DesignError`] where the area law cannot be moved.
    pub fn new(
        own: &SteadyModel<'a>,
        material: &MaterialUncertainty,
        conditions: &[Option<Condition>],
    ) -> Result<Self, DesignError> {
        let loads = own.asked().loads.len();
        let still = vec![0.0; loads];
        let refused = |error: MaterialError| Refusal::new(TaskPart::Whole, error.to_string());
        let at = |log: f64| {
            own.beside(|scene: &Scene| moved(scene, &still, ScaleShift { log, is_fitted: false }, 0.0)).map_err(refused)
        };
        let moves = material.modulus_std(own.area_law()).is_some();
        let both = if moves { Some([at(LOG_MODULUS_STEP)?, at(-LOG_MODULUS_STEP)?]) } else { None };
        Ok(Self { both, by_local_pressure: ByLocalPressure::new(own, material, conditions).map_err(refused)?, loads })
    }

    /// Everything that they follow from but for the lengths of a design.
    pub(crate) fn content(&self) -> impl Debug + '_ {
        let both = self.both.as_ref().map(|both| both.each_ref().map(SteadyModel::content));
        let laws = self
            .by_local_pressure
            .as_ref()
            .map(|of| (of.laws.iter().map(SteadyModel::content).collect::<Vec<_>>(), &of.of_load));
        (both, laws)
    }

    /// Those of `design` at every load.
    ///
    /// # Errors
    /// [`ModelFailure`] where they cannot be computed.
    pub fn at(&self, design: &Pattern) -> Result<Vec<Sensitivity>, ModelFailure> {
        Ok(from_numbers(&self.numbers(design)?, self.loads))
    }

    /// g = d ln R / d ln E of `design` at every load, and the changes by the local pressure where there are any.
    ///
    /// # Errors
    /// [`ModelFailure`] where they cannot be computed.
    pub fn numbers(&self, design: &Pattern) -> Result<Vec<f64>, ModelFailure> {
        let (modulus, local) = rayon::join(
            || self.of_modulus(design),
            || self.by_local_pressure.as_ref().map_or_else(|| Ok(Vec::new()), |of| of.at(design)),
        );
        Ok([modulus?, local?].concat())
    }

    fn of_modulus(&self, design: &Pattern) -> Result<Vec<f64>, ModelFailure> {
        let Some([stiffer, softer]) = &self.both else { return Ok(vec![0.0; self.loads]) };
        let (stiffer, softer) = rayon::join(|| made(stiffer, design), || made(softer, design));
        let slope = |(above, below): (&f64, &f64)| (above / below).ln() / (2.0 * LOG_MODULUS_STEP);
        Ok(stiffer?.iter().zip(&softer?).map(slope).collect())
    }
}

/// The sensitivities at so many `loads` that [`Sensitivities::numbers`] wrote; zeros where there are no numbers.
pub fn from_numbers(numbers: &[f64], loads: usize) -> Vec<Sensitivity> {
    let number = |place: usize| numbers.get(place).copied().unwrap_or(0.0);
    (0..loads).map(|load| Sensitivity { modulus: number(load), local_law: number(loads + load) }).collect()
}

/// What is said of the local law where it moves ratios, at the load where it moves them most; `mean` is the share of the change that is expected.
pub fn local_law_note(sensitivity: &[Sensitivity], loads: &[Load], mean: f64) -> Option<String> {
    let size = |place: &usize| sensitivity[*place].local_law.abs();
    let most = (0..sensitivity.len()).max_by(|a, b| size(a).total_cmp(&size(b)))?;
    (size(&most) > NOTED_CHANGE).then(|| {
        format!(
            "local law: flat friction contradicts the area law. If friction follows the local in place of the nominal pressure, the ratio at {:.2} MPa \
             changes by {:+.1} %; {:.0} % of the change is expected",
            PRESSURE_MPA.from_si(loads[most].pressure_pa),
            100.0 * sensitivity[most].local_law.exp_m1(),
            100.0 * mean.clamp(0.0, 1.0)
        )
    })
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
    let at = |(load, condition): (&slipgrid_springblock::Load, Option<Condition>)| Load {
        pressure_pa: load.pressure_pa,
        speed_m_s: condition.map_or(task.speed_m_s, |condition| condition.speed_m_s),
        humidity: condition.map_or(usual, |condition| condition.humidity),
    };
    model.asked().loads.iter().zip(conditions_of(task, further)).map(at).collect()
}

/// Speed and humidity at every load of `task`, condition by condition.
pub fn conditions_of(task: &DesignTask, further: &[Further]) -> Vec<Option<Condition>> {
    let count = task.target.points().len().max(1);
    let conditions = std::iter::once(task.condition).chain(further.iter().map(|further| further.at.condition));
    conditions.flat_map(|condition| std::iter::repeat_n(condition, count)).collect()
}
