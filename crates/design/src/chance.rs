//! The chance that a cut sample is on target: what scatters when it is cut, what is not known of the material, how exactly the
//! model is solved and, where a design aims with it, the discrepancy.

mod accepted;
mod expansion;
mod inputs;
mod made;
mod numerical;
mod sampled;

use std::cell::RefCell;
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use rayon::prelude::*;
use slipgrid_calibrate::uncertainty::{Covariance, ScaleShift, moved, with_scale};
use slipgrid_material::{Condition, MaterialError};
use slipgrid_optimize::{
    CommonDraws, Linearization, ModelFailure, Probability, Quantity, SearchError, Target, Tolerances, UncertainModel,
    Uncertainty, propagate, with_rim_off,
};
use slipgrid_pattern::Pattern;
use slipgrid_springblock::Scene;

pub use self::accepted::{Accepted, Gain, Judged};
pub use self::expansion::Expansion;
use self::expansion::{Drawn, Sensitivity};
pub(crate) use self::inputs::diagonal;
use self::inputs::{Parts, of_dimensions, percent, rms};
pub use self::made::made;
pub use self::numerical::{Numerical, block_std};
use crate::DesignError;
use crate::between_designs::{BetweenDesigns, LEAST_APART};
use crate::evaluation_cache::Answer;
use crate::learned_discrepancy::LearnedDiscrepancy;
use crate::operating_conditions::Further;
use crate::steady_model::SteadyModel;
use crate::task::DesignTask;
use slipgrid_calibrate::uncertainty::MaterialUncertainty;
use slipgrid_units::{LENGTH_UM, tidy};

/// Width, spacing, depth: the inputs before the others.
const DIMENSIONS: usize = 3;
const DEPTH: usize = 2;
/// Widest difference along a dimension over the dimension itself.
const WIDEST_SHARE: f64 = 0.5;

/// What blocks leave open of a ratio at least, where it is found by that of others: less is the chance of two lattices that agree.
const LEAST_BLOCK_STD: f64 = 3e-4;

/// What the mean height of a sample's rims is called.
pub const RIM_HEIGHT: &str = "rim height";
/// What the depth that a burst removes is called.
pub const DEPTH_PER_BURST: &str = "depth per burst";

/// `design` made with as many bursts, each of which removes exp(`log`) times as much: a depth stays positive.
pub fn by_deeper_bursts(design: &Pattern, log: f64) -> Result<Pattern, ModelFailure> {
    let [width_m, spacing_m, depth_m] = design.lengths_m();
    Pattern::new(*design.texture(), width_m, spacing_m, depth_m * log.exp())
        .map_err(|error| ModelFailure::Trial { reason: error.to_string() })
}

/// Something that is not known exactly.
#[derive(Clone, Debug, PartialEq)]
pub struct Input {
    /// The input, in words.
    pub name: &'static str,
    /// How well it is known, in words after the name.
    pub known_to: String,
    /// Its places among the inputs.
    pub places: Range<usize>,
}

/// The model with everything that is not known exactly, at every condition.
pub struct Chances<'a> {
    target: Target,
    is_ratio: bool,
    /// What a ratio is multiplied by before it is compared with the target.
    scale: Vec<f64>,
    /// Loads with inputs of their own: those of one sliding direction, which all have in common.
    inputs_of_loads: usize,
    tolerances: Tolerances,
    uncertainty: Uncertainty,
    /// The model that dimensions are moved in.
    still: SteadyModel<'a>,
    /// The same in blocks half as large, in the vertical plane.
    fine: Option<SteadyModel<'a>>,
    /// Logarithm of what blocks leave open of a ratio, in the vertical plane, and how the steady model moves: where that was found out.
    between: Mutex<BetweenDesigns>,
    /// Along flat friction, the area law's scale and its factors: models to both sides, and the way to each.
    friction: Option<Along<'a>>,
    law_scale: Option<Along<'a>>,
    /// That scale was fitted; otherwise it is Young's modulus.
    scale_is_fitted: bool,
    law: Option<Along<'a>>,
    /// Place of the depth per burst, where that was fitted against fluence: the depths of all samples are off by this factor.
    burst: Option<usize>,
    /// What designs aim with beside the physics. It has what is not known of Young's modulus in it.
    learned: Option<Arc<LearnedDiscrepancy<'a>>>,
    inputs: Vec<Input>,
    /// First place of the discrepancy's deviates, one that picks its form and one a load, and of the numerical errors: one a load, and
    /// one that all loads have in common.
    first_discrepancy: usize,
    first_numerical: usize,
}

/// Two models to both sides of the one that is used.
struct Along<'a> {
    above: SteadyModel<'a>,
    below: SteadyModel<'a>,
    /// Distance of either, one per value.
    step: Vec<f64>,
    first: usize,
}

/// What a linearization is made about.
#[derive(Clone, Copy)]
pub struct About<'a> {
    /// The design.
    pub design: &'a Pattern,
    /// What the steady model says of it, [`Chances::still`].
    pub still: &'a Answer,
    /// Values as they are compared with the target, one per load of each condition.
    pub values: &'a [f64],
    /// How exactly the values were computed.
    pub numerical: &'a Numerical,
}

impl<'a> Chances<'a> {
    /// Of `design` with its `material`, by `model` at every condition, the one designed for first.
    ///
    /// # Errors
    /// [`DesignError`] for errors of a material that mean nothing.
    pub fn new(
        design: &DesignTask,
        material: &MaterialUncertainty,
        model: &SteadyModel<'a>,
        further: &[Further],
    ) -> Result<Self, DesignError> {
        let values = model.asked().loads.len();
        // The same material in every direction: the loads of the first stand for those of the others.
        let directions = 1 + design.directions.different_deg.len();
        let count = values / directions;
        let loads = &model.asked().loads[..count];
        let conditions: Vec<Option<Condition>> =
            std::iter::once(design.condition).chain(further.iter().map(|further| further.at.condition)).collect();
        let conditions = &conditions[..conditions.len() / directions];
        let of_material = |error: MaterialError| DesignError::Failed(format!("errors of the material: {error}"));
        let tolerances = design.tolerances.map(|input| input.tolerances).unwrap_or_default();
        let mut parts = Parts { inputs: of_dimensions(&tolerances), blocks: Vec::new(), count: DIMENSIONS };

        let law = model.area_law();
        let (mut friction_at, mut scale_at) = (None, None);
        if let (Some(known), Some(law)) = (&material.scale_covariance, law) {
            let joint = with_scale(known, law, loads).map_err(of_material)?;
            let first = parts.add(joint.clone());
            parts.name("flat friction", percent(rms(&joint[..count])), first..first + count);
            parts.name("scale of the area law", percent(joint[count][count].sqrt()), first + count..first + count + 1);
            (friction_at, scale_at) = (Some(first), Some(first + count));
        } else {
            if let Some(covariance) = material.friction_covariance(&design.pressures_pa(), conditions) {
                let known_to = percent(rms(&covariance));
                let first = parts.add(covariance);
                parts.name("flat friction", known_to, first..first + count);
                friction_at = Some(first);
            }
            if let Some(std) = material.modulus_std(law).filter(|_| !design.discrepancy) {
                let first = parts.add(vec![vec![std * std]]);
                parts.name("Young's modulus", percent(std), first..first + 1);
                scale_at = Some(first);
            }
        }
        let mut law_at = None;
        if law.is_some_and(|law| law.factor_std().is_some()) {
            let first = parts.add(vec![vec![1.0]]);
            parts.name("area law", "known to the scatter of its map's windows".to_owned(), first..first + 1);
            law_at = Some(first);
        }
        let burst = design.laser.depth_per_burst_std().map(|std| {
            let first = parts.add(vec![vec![std * std]]);
            parts.name(DEPTH_PER_BURST, percent(std), first..first + 1);
            first
        });
        let first_discrepancy = parts.count;
        let learned = model.learned().cloned();
        if let Some(learned) = &learned {
            let first = parts.add(diagonal(&vec![vec![vec![1.0]]; 1 + values]));
            let known_to = match learned.trials() {
                0 => "by what is believed before any trial".to_owned(),
                1 => "known by one trial".to_owned(),
                trials => format!("known by {trials} trials"),
            };
            parts.name("discrepancy", known_to, first..first + 1 + values);
        }
        let first_numerical = parts.add(diagonal(&vec![vec![vec![1.0]]; Numerical::deviates(values)]));
        let covariance = diagonal(&parts.blocks);
        let refused = |error: SearchError| DesignError::Failed(format!("errors of the material: {error}"));
        let uncertainty = Uncertainty::new(&tolerances, &covariance).map_err(refused)?;
        if let Some(place) = uncertainty.rim() {
            let known_to = format!("made to {} um", tidy(LENGTH_UM.from_si(tolerances.rim_height_std_m)));
            // Beside the dimensions.
            let after = parts.inputs.iter().take_while(|input| input.places.start < DIMENSIONS).count();
            parts.inputs.insert(after, Input { name: RIM_HEIGHT, known_to, places: place..place + 1 });
        }

        let is_fitted = material.scale_covariance.is_some();
        let along = |first: Option<usize>, inputs: usize, friction: bool, scale: f64, law: f64| {
            let Some(first) = first else { return Ok(None) };
            let step: Vec<f64> = (0..values).map(|place| uncertainty.std(first + place % inputs)).collect();
            let own = |side: f64| {
                let by: Vec<f64> = step.iter().map(|step| if friction { side * step } else { 0.0 }).collect();
                let one = side * step[0];
                let scale = ScaleShift::off_by(scale * one, is_fitted);
                model.beside(|scene: &Scene| moved(scene, &by, scale, law * one)).map_err(of_material)
            };
            Ok::<_, DesignError>(Some(Along { above: own(1.0)?, below: own(-1.0)?, step, first }))
        };
        Ok(Self {
            target: design.target.clone(),
            is_ratio: design.target.quantity() == Quantity::Ratio,
            scale: (0..values).map(|load| model.scale(load)).collect(),
            inputs_of_loads: count,
            tolerances,
            still: model.beside(|scene: &Scene| Ok::<_, DesignError>(scene.clone()))?,
            fine: fine(model)?,
            between: Mutex::default(),
            friction: along(friction_at, count, true, 0.0, 0.0)?,
            law_scale: along(scale_at, 1, false, 1.0, 0.0)?,
            scale_is_fitted: is_fitted,
            law: along(law_at, 1, false, 0.0, 1.0)?,
            burst,
            uncertainty,
            learned,
            inputs: parts.inputs,
            first_discrepancy,
            first_numerical,
        })
    }

    /// What is not known exactly, but for the numerical errors.
    pub fn inputs(&self) -> &[Input] {
        &self.inputs
    }

    /// Whether anything but the numerical errors is known to be off.
    pub fn is_known(&self) -> bool {
        !self.inputs.is_empty()
    }

    /// What ratios are multiplied by before they are compared with the target, but for the discrepancy.
    pub fn scale(&self) -> &[f64] {
        &self.scale
    }

    /// The model in blocks half as large, in the vertical plane.
    pub const fn fine(&self) -> Option<&SteadyModel<'a>> {
        self.fine.as_ref()
    }

    /// Places of the numerical errors.
    pub fn numerical(&self) -> Range<usize> {
        self.first_numerical..self.first_numerical + Numerical::deviates(self.scale.len())
    }

    /// What the steady model that is neither corrected nor kept says of `design`.
    ///
    /// # Errors
    /// [`ModelFailure::Trial`] where it cannot be computed.
    pub fn still(&self, design: &Pattern) -> Result<Answer, ModelFailure> {
        self.still.steady(design)
    }

    /// How exactly the values of `design`, of which the model says `still`, are computed: `others`, and in the vertical plane how far they are
    /// from those of vanishing blocks, if the order of convergence is one half, at the load where that is most.
    ///
    /// # Errors
    /// [`ModelFailure::Trial`] where the design cannot be computed in smaller blocks.
    pub fn numerical_of(
        &self,
        design: &Pattern,
        still: &Answer,
        others: &Numerical,
    ) -> Result<Numerical, ModelFailure> {
        let of_blocks = self.block_std(design, still)?;
        Ok(of_blocks.map_or_else(|| others.clone(), |std| self.with_blocks(std, others)))
    }

    /// What blocks leave open of the ratios of `design`, of which the model says `still`; `None` in space, where smaller ones are dear.
    fn block_std(&self, design: &Pattern, still: &Answer) -> Result<Option<f64>, ModelFailure> {
        let Some(fine) = &self.fine else { return Ok(None) };
        Ok(Some(block_std(most_apart(&still.ratio, &fine.steady(design)?.ratio))))
    }

    /// Finds out what [`Self::expand_roughly`] needs, of those of `designs` that are unlike others: a third of a choice's. It goes smoothly with the
    /// lengths but for where cavities end within blocks. Those that cannot be computed are left out.
    pub fn learn(&self, designs: impl IntoIterator<Item = Pattern>) {
        let known = || self.between.lock().unwrap_or_else(PoisonError::into_inner);
        let fresh = known().unlike(designs, LEAST_APART);
        // Not locked while designs are solved: a thread that waits for another's may take up any task.
        let solved = |design: &Pattern| {
            let still = self.still(design)?;
            let blocks = self.block_std(design, &still)?.unwrap_or_default().max(LEAST_BLOCK_STD).ln();
            let numbers = [vec![blocks], self.sensitivity(design, &still)?.numbers()].concat();
            Ok::<_, ModelFailure>((*design, numbers))
        };
        let learnt: Vec<_> = fresh.par_iter().filter_map(|design| solved(design).ok()).collect();
        known().learn(learnt);
    }

    /// As [`Self::expand`] with [`Self::numerical_of`], by what [`Self::learn`] found of designs like it where it found any: where many are
    /// compared. `values` are those compared with the target.
    ///
    /// # Errors
    /// As there.
    pub fn expand_roughly(
        &self,
        design: &Pattern,
        values: &[f64],
        others: &Numerical,
    ) -> Result<Expansion, ModelFailure> {
        let still = &self.still(design)?;
        let Some(numbers) = self.between.lock().unwrap_or_else(PoisonError::into_inner).at(design) else {
            let numerical = &self.numerical_of(design, still, others)?;
            return self.expand(&About { design, still, values, numerical });
        };
        let (blocks, rest) = (numbers[0], &numbers[1..]);
        let of_blocks = self.fine.as_ref().map(|_| self.with_blocks(blocks.exp(), others));
        let numerical = of_blocks.as_ref().unwrap_or(others);
        let about = About { design, still, values, numerical };
        self.expand_by(&about, &Sensitivity::of(rest, self.scale.len()))
    }

    /// `others` with what the size of blocks leaves open of ratios.
    fn with_blocks(&self, std: f64, others: &Numerical) -> Numerical {
        let common = self.scale.iter().zip(&others.common).map(|(scale, other)| (scale * std).hypot(*other)).collect();
        Numerical { common, ..others.clone() }
    }

    /// Cells that a chance takes: of the design, of one in smaller blocks where there are such, and to both sides along each
    /// dimension that scatters, the rims' height, the depth per burst, flat friction, and scale and factors of the area law.
    pub fn solves(&self) -> usize {
        let scattering = self.tolerances.std_m.iter().filter(|std_m| **std_m > 0.0).count();
        let beside = self.beside().count();
        let others = usize::from(self.uncertainty.rim().is_some()) + usize::from(self.burst.is_some());
        1 + usize::from(self.fine.is_some()) + 2 * (scattering + others + beside)
    }

    /// What scatters beside dimensions and is solved to both sides.
    fn beside(&self) -> impl Iterator<Item = &Along<'a>> {
        [&self.friction, &self.law_scale, &self.law].into_iter().flatten()
    }

    /// One of these cells.
    pub fn cell(&self, design: &Pattern) -> Scene {
        self.still.scene(design)
    }

    /// Cells that were solved so far.
    #[cfg(test)]
    pub fn solved(&self) -> usize {
        let beside = self.beside().flat_map(|along| [&along.above, &along.below]);
        std::iter::once(&self.still).chain(&self.fine).chain(beside).map(|model| model.solved()[0]).sum()
    }

    /// Seeded draws of everything.
    pub fn draws(&self, draws: usize, seed: u64) -> CommonDraws {
        CommonDraws::new(&self.uncertainty, draws, seed)
    }

    /// The draws that [`Self::sampled`] begins with.
    ///
    /// # Errors
    /// [`ModelFailure::Trial`] where hardly any leaves the dimensions of `design` positive.
    pub fn draws_about(&self, design: &Pattern, draws: usize, seed: u64) -> Result<CommonDraws, ModelFailure> {
        CommonDraws::about(design, &self.uncertainty, draws, seed)
    }

    /// Share of `draws` in which the inputs that `of` names leave every value accepted.
    pub fn share(&self, draws: &CommonDraws, about: &Expansion, of: &dyn Fn(usize) -> bool) -> Probability {
        self.judge(draws, about, of, |_| ())
    }

    /// The draws in which the inputs that `of` names leave every value accepted.
    pub fn expanded(&self, draws: &CommonDraws, about: &Expansion, of: &dyn Fn(usize) -> bool) -> Accepted {
        let accepted = RefCell::new(Vec::new());
        let _ = self.judge(draws, about, of, |accepts| accepted.borrow_mut().push(accepts));
        accepted.into_inner()
    }

    /// The share, where `told` hears of every draw whether it is accepted.
    fn judge(
        &self,
        draws: &CommonDraws,
        about: &Expansion,
        of: &dyn Fn(usize) -> bool,
        told: impl Fn(bool),
    ) -> Probability {
        draws.probability_by(&about.slopes, of, |values, deviations| {
            about.complete(values, deviations, of);
            let accepts = about.is_open(deviations, of) && self.target.accepts(values);
            told(accepts);
            accepts
        })
    }

    /// Covariance of the values of a design over `draws`, one row a value.
    pub fn covariance(&self, draws: &CommonDraws, about: &Expansion) -> Vec<Vec<f64>> {
        let count = self.scale.len();
        let sums = RefCell::new((0_u32, vec![0.0; count], vec![vec![0.0; count]; count]));
        let _ = draws.probability_by(&about.slopes, &|_| true, |values, deviations| {
            about.complete(values, deviations, &|_| true);
            let off: Vec<f64> = values.iter().zip(about.slopes.values()).map(|(value, own)| value - own).collect();
            let (drawn, sum, squares) = &mut *sums.borrow_mut();
            *drawn += 1;
            for (row, own) in off.iter().enumerate() {
                sum[row] += own;
                squares[row].iter_mut().zip(&off).for_each(|(square, other)| *square += own * other);
            }
            true
        });
        let (drawn, sum, squares) = sums.into_inner();
        let count = f64::from(drawn.max(2));
        let entry = |row: usize, place: usize| (squares[row][place] - sum[row] * sum[place] / count) / (count - 1.0);
        (0..sum.len()).map(|row| (0..sum.len()).map(|place| entry(row, place)).collect()).collect()
    }

    /// Share of `draws` in which `values`, off by the errors `numerical` alone, are accepted.
    pub fn share_of_run(
        &self,
        draws: &CommonDraws,
        design: &Pattern,
        values: &[f64],
        numerical: &Numerical,
    ) -> Probability {
        let places = self.numerical();
        let mut slopes = vec![vec![0.0; values.len()]; places.end];
        numerical.enter(&mut slopes[places.clone()]);
        let run = Linearization::of_slopes(*design, values.to_vec(), slopes);
        let run = Expansion::of_slopes(run);
        self.share(draws, &run, &|place| places.contains(&place))
    }

    /// Covariance of the logarithms of the values of a design, row by row, by everything that all samples share beside the discrepancy, which
    /// Young's modulus belongs to: to first order.
    pub fn log_covariance(&self, expansion: &Expansion) -> Vec<f64> {
        let modulus = self.law_scale.as_ref().filter(|_| !self.scale_is_fitted).map(|along| along.first);
        let rim = self.uncertainty.rim();
        let others = [modulus, rim, self.burst];
        self.log_covariance_of(expansion, &|place| place >= DIMENSIONS && !others.contains(&Some(place)))
    }

    fn log_covariance_of(&self, expansion: &Expansion, of: &dyn Fn(usize) -> bool) -> Vec<f64> {
        let (slopes, values) = (&expansion.slopes, expansion.slopes.values());
        let rows = slopes.covariance_of(&self.uncertainty, of);
        // cov(ln v, ln w) = cov(v, w) / (v w)
        let row = |(row, own): (Vec<f64>, &f64)| {
            row.into_iter().zip(values).map(move |(entry, other)| entry / (own * other)).collect::<Vec<f64>>()
        };
        rows.into_iter().zip(values).flat_map(row).collect()
    }
}

/// The largest distance of two numbers at one place.
fn most_apart(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// `model` in blocks half as large; `None` in space, where they are dear.
fn fine<'a>(model: &SteadyModel<'a>) -> Result<Option<SteadyModel<'a>>, DesignError> {
    let change = |scene: &Scene| {
        let mut fine = scene.clone();
        fine.layer.block_m *= 0.5;
        Ok::<_, DesignError>(fine)
    };
    if model.is_cheap_per_design() { model.beside(change).map(Some) } else { Ok(None) }
}

#[cfg(test)]
mod tests;
