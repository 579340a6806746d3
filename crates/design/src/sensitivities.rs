//! Model of the search, with the sensitivity of its ratios to inputs that all textures share.

use std::fmt::Debug;

use crate::optimize::ModelFailure;
use rayon::prelude::*;
use slipgrid_base::units::PRESSURE_MPA;
use slipgrid_infer::calibrate::uncertainty::{ScaleShift, moved, with_local_law};
use slipgrid_infer::discrepancy::{Discrepancy, Load, Sensitivity};
use slipgrid_model::material::{Condition, MaterialError};
use slipgrid_model::pattern::Pattern;
use slipgrid_model::springblock::{Scene, block_refinement};

use crate::DesignError;
use crate::evaluation_cache::Answer;
use crate::prepared_task::PreparedTask;
use crate::steady_model::SteadyModel;

/// Maximum number of multiplications to solve a cell in smaller blocks: some hundredths of a second.
const MAX_REFINED: f64 = 2e8;
/// Like [`MAX_REFINED`], for cavities shallower than [`SHALLOW`]: half a second. Runs of specimens refine their ratios
/// by as small blocks, and in larger ones the ratios of such cavities differ by several per cent.
const MAX_REFINED_IF_SHALLOW: f64 = 2e9;
/// Depth, in blocks, from which cavities are two blocks deep in blocks of an eighth of the size.
const SHALLOW: f64 = 0.25;
/// Step of the logarithm of Young's modulus to each side for the derivative of ln R.
const LOG_MODULUS_STEP: f64 = 0.05;
/// The report of a design mentions the local law if it changes ln R, R the friction ratio, by more than this.
const NOTED_CHANGE: f64 = 0.002;
/// Relative humidity, from 0 to 1, if neither design nor trials name one.
const USUAL_HUMIDITY: f64 = 0.4;

/// Model values of a texture at the loads.
#[derive(Clone, Debug, PartialEq)]
pub struct Modelled {
    /// Logarithm ln R of the ratio at each load.
    pub log_ratio: Vec<f64>,
    /// Sensitivity of ln R to inputs that all textures share.
    pub sensitivity: Vec<Sensitivity>,
    /// Fraction of the face that is cavity, over that of a period ([`Features::face_share`]).
    ///
    /// [`Features::face_share`]: slipgrid_infer::discrepancy::Features::face_share
    pub face_share: f64,
}

/// Model of the search, with models for the changes of friction ratios with Young's modulus, and if friction follows
/// the local instead of the nominal pressure.
pub struct Models<'a> {
    pub own: &'a SteadyModel<'a>,
    /// Models with a stiffer and a softer body; `None` if the modulus has no effect.
    both: Option<[SteadyModel<'a>; 2]>,
    /// Models for friction by the local pressure; `None` if flat friction follows the area law at every condition.
    by_local_pressure: Option<ByLocalPressure<'a>>,
}

/// Models in which friction follows the local pressure, one per condition at which flat friction contradicts the area
/// law.
struct ByLocalPressure<'a> {
    /// Model by the area law, in blocks of the size that `laws` use.
    still: SteadyModel<'a>,
    laws: Vec<SteadyModel<'a>>,
    /// Index in `laws` of the model that applies at each load; `None` if flat friction follows the area law there.
    of_load: Vec<Option<usize>>,
}

impl<'a> ByLocalPressure<'a> {
    /// Builds the models for the material of `prepared` at the condition of each load of `own`, in the guide's blocks if
    /// `is_coarse`.
    fn new(own: &SteadyModel<'a>, prepared: &PreparedTask, is_coarse: bool) -> Result<Option<Self>, MaterialError> {
        let changed = |change: &dyn Fn(&Scene) -> Result<Scene, MaterialError>| {
            if is_coarse { own.beside(change) } else { own.in_own_blocks(change) }
        };
        let (mut laws, mut of_load) = (Vec::new(), Vec::new());
        let mut known: Vec<(Option<Condition>, Option<usize>)> = Vec::new();
        for setting in &prepared.settings {
            let condition = setting.condition.as_ref();
            let same = known.iter().find(|(other, _)| Condition::is_same(other.as_ref(), condition));
            let place = match same {
                Some((_, place)) => *place,
                None => {
                    let law = prepared.uncertainty.local_law(own.area_law(), condition);
                    let place = law.as_ref().map(|_| laws.len());
                    if let Some(law) = law {
                        laws.push(changed(&|scene: &Scene| with_local_law(scene, &law))?);
                    }
                    known.push((setting.condition, place));
                    place
                }
            };
            of_load.extend(std::iter::repeat_n(place, setting.loads.len()));
        }
        if laws.is_empty() {
            return Ok(None);
        }
        let still = changed(&|scene: &Scene| Ok(scene.clone()))?;
        Ok(Some(Self { still, laws, of_load }))
    }

    /// Change of ln R, R the friction ratio, of `design` at every load if friction follows the local pressure; 0 at
    /// loads without such a model.
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

/// Ratios of `design` by `model`, including closed cavities, so that derived quantities stay smooth up to closure.
fn made(model: &SteadyModel<'_>, design: &Pattern) -> Result<Vec<f64>, ModelFailure> {
    Ok(model.answer_made(design, &model.lay(design)?)?.ratio)
}

impl<'a> Models<'a> {
    /// Builds the models for `own` and the material of `prepared`.
    ///
    /// # Errors
    /// [`DesignError`] if the area law, changed by its errors, is invalid.
    pub fn new(own: &'a SteadyModel<'a>, prepared: &PreparedTask) -> Result<Self, DesignError> {
        let still = vec![0.0; own.asked().loads.len()];
        let refused = |error: MaterialError| DesignError::refused(error.to_string());
        let at = |log: f64| {
            own.beside(|scene: &Scene| moved(scene, &still, ScaleShift { log, is_fitted: false }, 0.0)).map_err(refused)
        };
        let moves = prepared.uncertainty.modulus_std(own.area_law()).is_some();
        let both = if moves { Some([at(LOG_MODULUS_STEP)?, at(-LOG_MODULUS_STEP)?]) } else { None };
        Ok(Self { own, both, by_local_pressure: ByLocalPressure::new(own, prepared, true).map_err(refused)? })
    }

    /// All inputs of the sensitivities except width, spacing and depth of a design, for cache keys.
    pub(crate) fn content_of_sensitivities(&self) -> impl Debug + '_ {
        let both = self.both.as_ref().map(|both| both.each_ref().map(SteadyModel::content));
        let laws = self
            .by_local_pressure
            .as_ref()
            .map(|of| (of.laws.iter().map(SteadyModel::content).collect::<Vec<_>>(), &of.of_load));
        (both, laws)
    }

    /// Computes the model values of `design`, and the results that they come from.
    ///
    /// # Errors
    /// [`ModelFailure`] if the design cannot be computed, or its cavities close.
    pub fn at(&self, design: &Pattern) -> Result<(Modelled, Answer), ModelFailure> {
        let answer = self.own.steady(design)?;
        let log_ratio: Vec<f64> = answer.ratio.iter().map(|ratio| ratio.ln()).collect();
        let sensitivity = from_numbers(&self.numbers(design)?, log_ratio.len());
        Ok((Modelled { log_ratio, sensitivity, face_share: self.own.lay(design)?.share(design) }, answer))
    }

    /// Computes d ln R / d ln E, R the friction ratio and E Young's modulus, of `design` at every load, followed by the
    /// changes of ln R if friction follows the local pressure, where flat friction contradicts the area law.
    ///
    /// # Errors
    /// [`ModelFailure`] if the design cannot be computed.
    pub fn numbers(&self, design: &Pattern) -> Result<Vec<f64>, ModelFailure> {
        let (modulus, local) = rayon::join(
            || self.of_modulus(design),
            || self.by_local_pressure.as_ref().map_or_else(|| Ok(Vec::new()), |of| of.at(design)),
        );
        Ok([modulus?, local?].concat())
    }

    /// Changes of ln R of `design` by the local law in the requested blocks; empty without such a law, and if the guide's
    /// blocks are the requested ones.
    pub fn local_law_in_own_blocks(&self, prepared: &PreparedTask, design: &Pattern) -> Vec<f64> {
        if !self.own.has_guide() || self.by_local_pressure.is_none() {
            return Vec::new();
        }
        let law = ByLocalPressure::new(self.own, prepared, false).ok().flatten();
        law.and_then(|law| law.at(design).ok()).unwrap_or_default()
    }

    fn of_modulus(&self, design: &Pattern) -> Result<Vec<f64>, ModelFailure> {
        let Some([stiffer, softer]) = &self.both else { return Ok(vec![0.0; self.own.asked().loads.len()]) };
        let (stiffer, softer) = rayon::join(|| made(stiffer, design), || made(softer, design));
        let slope = |(above, below): (&f64, &f64)| (above / below).ln() / (2.0 * LOG_MODULUS_STEP);
        Ok(stiffer?.iter().zip(&softer?).map(slope).collect())
    }

    /// Change of each of `ratios`, those of `design`, by smaller blocks, and standard deviation due to the remaining
    /// block size; `None` for rims in space, and if smaller blocks are too expensive. `is_rough` ends at
    /// larger blocks in the plane, for comparisons of many textures.
    pub fn refined(&self, design: &Pattern, ratios: &[f64], is_rough: bool) -> Option<(Vec<f64>, Vec<f64>)> {
        let share = self.own.lay(design).ok()?.share(design);
        // Ratio of the cell, with the areal densities D of specimen and period: 1 - r = (1 - r_cell) D / D_period
        let own: Vec<Option<f64>> = ratios.iter().map(|ratio| Some(1.0 - (1.0 - ratio) / share)).collect();
        let cells = self.own.cells(design);
        let is_shallow = design.depth_m() < SHALLOW * self.own.asked().layer.block_m;
        let most = if is_shallow { MAX_REFINED_IF_SHALLOW } else { MAX_REFINED };
        let (mut shifts, mut open) = (Vec::new(), Vec::new());
        for (cell, own) in cells.iter().zip(own.chunks(own.len() / cells.len())) {
            let refined = block_refinement(cell, own, most, is_rough)?;
            shifts.extend(refined.shifts.iter().map(|shift| share * shift));
            // The error is an upper bound, taken as two standard deviations.
            open.extend(refined.errors.iter().map(|error| 0.5 * share * error));
        }
        Some((shifts, open))
    }
}

/// Decodes the sensitivities at `loads` loads from the numbers of [`Models::numbers`]; zeros if there are no
/// numbers.
pub fn from_numbers(numbers: &[f64], loads: usize) -> Vec<Sensitivity> {
    let number = |place: usize| numbers.get(place).copied().unwrap_or(0.0);
    (0..loads).map(|load| Sensitivity { modulus: number(load), local_law: number(loads + load) }).collect()
}

/// Note on the change by the local law at the load where it changes the ratio most; `mean` is the expected share of the
/// change. `None` if the ratio changes by at most 0.2 %.
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

/// Default relative humidity: the mean of the trials, or 0.4 without trials.
pub fn usual_humidity(learned: &Discrepancy) -> f64 {
    let measured = learned.trials().iter().flat_map(|trial| trial.measured.iter().map(|at| at.load.humidity));
    let humidities: Vec<f64> = measured.collect();
    if humidities.is_empty() { USUAL_HUMIDITY } else { humidities.iter().sum::<f64>() / humidities.len() as f64 }
}
