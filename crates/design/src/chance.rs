//! The chance that a cut sample is on target: what scatters when it is cut, what is not known of the material, how exactly the
//! model is solved and, where a design aims with it, the discrepancy.

mod accepted;
mod inputs;
mod numerical;
mod sampled;

use std::cell::RefCell;
use std::ops::Range;
use std::sync::Arc;

use slipgrid_calibrate::uncertainty::{Covariance, ScaleShift, moved, with_scale};
use slipgrid_discrepancy::Sampler;
use slipgrid_material::{Condition, MaterialError};
use slipgrid_optimize::{
    CommonDraws, Linearization, ModelFailure, Probability, Quantity, SearchError, Target, Tolerances, UncertainModel,
    Uncertainty, propagate, with_rim_off,
};
use slipgrid_pattern::Pattern;
use slipgrid_springblock::Scene;

pub use self::accepted::{Accepted, Gain};
pub(crate) use self::inputs::diagonal;
use self::inputs::{Parts, of_dimensions, percent, rms};
pub use self::numerical::{Numerical, block_std};
use crate::DesignError;
use crate::learned_discrepancy::LearnedDiscrepancy;
use crate::operating_conditions::Further;
use crate::steady_model::SteadyModel;
use crate::task::DesignTask;
use slipgrid_calibrate::uncertainty::MaterialUncertainty;
use slipgrid_units::{LENGTH_UM, tidy};

/// Width, spacing, depth: the inputs before the others.
const DIMENSIONS: usize = 3;
/// Widest difference along a dimension over the dimension itself.
const WIDEST_SHARE: f64 = 0.5;

/// What the mean height of a sample's rims is called.
pub const RIM_HEIGHT: &str = "rim height";

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
    /// Along flat friction, the area law's scale and its factors: models to both sides, and the way to each.
    friction: Option<Along<'a>>,
    law_scale: Option<Along<'a>>,
    /// That scale was fitted; otherwise it is Young's modulus.
    scale_is_fitted: bool,
    law: Option<Along<'a>>,
    /// What designs aim with beside the physics. It has what is not known of Young's modulus in it.
    learned: Option<Arc<LearnedDiscrepancy<'a>>>,
    inputs: Vec<Input>,
    /// First place of the discrepancy's deviates, one that picks its form and one a load, and of the numerical errors: one a load, and
    /// one that all loads have in common.
    first_discrepancy: usize,
    first_numerical: usize,
}

/// A design to first order along each input, and to second along the modulus (or the fitted scale) and the area law: a search for
/// the greatest chance finds where their slopes vanish. The discrepancy is drawn from its own distribution.
pub struct Expansion {
    slopes: Linearization,
    /// Half the second derivative of the values along an input, by its place.
    curvatures: Vec<(usize, Vec<f64>)>,
    discrepancy: Option<Drawn>,
}

impl Expansion {
    /// Adds to `values`, which are those to first order where the inputs are off by `deviations`, what the inputs that `of` names
    /// add to second order, and multiplies them by the discrepancy where it is one of these.
    fn complete(&self, values: &mut [f64], deviations: &[f64], of: &dyn Fn(usize) -> bool) {
        for (place, curvature) in self.curvatures.iter().filter(|(place, _)| of(*place)) {
            let square = deviations[*place].powi(2);
            values.iter_mut().zip(curvature).for_each(|(value, half)| *value += half * square);
        }
        if let Some(drawn) = self.discrepancy.as_ref().filter(|drawn| of(drawn.first)) {
            values.iter_mut().zip(drawn.factors(deviations)).for_each(|(value, factor)| *value *= factor);
        }
    }
}

/// The discrepancy of a design: values are times the exponential of a draw less the median.
struct Drawn {
    sampler: Sampler,
    medians: Vec<f64>,
    first: usize,
}

impl Drawn {
    /// What values are multiplied by where the deviates, of all inputs, are `deviations`.
    fn factors(&self, deviations: &[f64]) -> impl Iterator<Item = f64> {
        let (which, z) = (deviations[self.first], &deviations[self.first + 1..=self.first + self.medians.len()]);
        let drawn = self.sampler.draw(which, z);
        drawn.into_iter().zip(&self.medians).map(|(drawn, median)| (drawn - median).exp())
    }
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
    /// Its ratios by the steady model, [`Chances::still`].
    pub still: &'a [f64],
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
            let each = conditions.iter().map(|at| material.friction_covariance(&design.pressures_pa(), at.as_ref()));
            if let Some(blocks) = each.collect::<Option<Vec<Covariance>>>() {
                let covariance = diagonal(&blocks);
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
                let scale = ScaleShift { log: scale * one, is_fitted };
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
            friction: along(friction_at, count, true, 0.0, 0.0)?,
            law_scale: along(scale_at, 1, false, 1.0, 0.0)?,
            scale_is_fitted: is_fitted,
            law: along(law_at, 1, false, 0.0, 1.0)?,
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

    /// Ratios of `design` by the steady model that is neither corrected nor kept.
    ///
    /// # Errors
    /// [`ModelFailure::Trial`] where it cannot be computed.
    pub fn still(&self, design: &Pattern) -> Result<Vec<f64>, ModelFailure> {
        Ok(self.still.steady(design)?.ratio)
    }

    /// How exactly the values of `design`, whose ratios are `still`, are computed: `others`, and in the vertical plane how far they are
    /// from those of vanishing blocks, if the order of convergence is one half, at the load where that is most.
    ///
    /// # Errors
    /// [`ModelFailure::Trial`] where the design cannot be computed in smaller blocks.
    pub fn numerical_of(&self, design: &Pattern, still: &[f64], others: &Numerical) -> Result<Numerical, ModelFailure> {
        let Some(fine) = &self.fine else { return Ok(others.clone()) };
        let fine = fine.steady(design)?.ratio;
        let most = still.iter().zip(&fine).map(|(own, fine)| (own - fine).abs()).fold(0.0, f64::max);
        let std = block_std(most);
        let common = self.scale.iter().zip(&others.common).map(|(scale, other)| (scale * std).hypot(*other)).collect();
        Ok(Numerical { common, ..others.clone() })
    }

    /// Seeded draws of everything.
    pub fn draws(&self, draws: usize, seed: u64) -> CommonDraws {
        CommonDraws::new(&self.uncertainty, draws, seed)
    }

    /// Share of `draws` in which the inputs that `of` names leave every value accepted.
    pub fn share(&self, draws: &CommonDraws, about: &Expansion, of: &dyn Fn(usize) -> bool) -> Probability {
        self.judge(draws, about, of, |_| ())
    }

    /// The draws in which the inputs that `of` names leave every value accepted.
    pub fn expanded(&self, draws: &CommonDraws, about: &Expansion, of: &dyn Fn(usize) -> bool) -> Accepted {
        let accepted = RefCell::new(Vec::new());
        let _ = self.judge(draws, about, of, |accepts| accepted.borrow_mut().push(accepts));
        Accepted(accepted.into_inner())
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
            let accepts = self.target.accepts(values);
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
        let run = Expansion { slopes: run, curvatures: Vec::new(), discrepancy: None };
        self.share(draws, &run, &|place| places.contains(&place))
    }

    /// The discrepancy of `design`, where designs aim with it.
    fn drawn(&self, design: &Pattern) -> Result<Option<Drawn>, ModelFailure> {
        let Some(learned) = &self.learned else { return Ok(None) };
        let prediction = learned.prediction(design, &learned.modulus_sensitivity(design)?);
        let (sampler, medians) = (prediction.sampler(), prediction.medians());
        Ok(Some(Drawn { sampler, medians, first: self.first_discrepancy }))
    }

    /// The values of a design about it: by central differences over a standard deviation each way.
    ///
    /// # Errors
    /// [`ModelFailure::Trial`] where neighbours of the design cannot be computed.
    pub fn expand(&self, about: &About<'_>) -> Result<Expansion, ModelFailure> {
        let (count, values) = (self.scale.len(), about.values.to_vec());
        let discrepancy = self.drawn(about.design)?;
        let medians = discrepancy.as_ref().map(|drawn| &drawn.medians);
        let factor = |load: usize| medians.map_or(1.0, |medians| medians[load].exp());
        let scale: Vec<f64> = self.scale.iter().enumerate().map(|(load, scale)| scale * factor(load)).collect();
        let mut slopes = vec![vec![0.0; count]; self.uncertainty.inputs()];
        let mut curvatures = Vec::new();
        for (axis, std_m) in self.tolerances.std_m.into_iter().enumerate().filter(|(_, std_m)| *std_m > 0.0) {
            let per_m = self.along_axis(about.design, axis, std_m)?;
            slopes[axis] = per_m.iter().zip(&scale).map(|(slope, scale)| slope * scale).collect();
        }
        if let Some(place) = self.uncertainty.rim() {
            let per_m = self.along_rim(about.design)?;
            slopes[place] = per_m.iter().zip(&scale).map(|(slope, scale)| slope * scale).collect();
        }
        // (r(x + s) - r(x - s)) / 2s and (r(x + s) - 2 r(x) + r(x - s)) / 2s^2
        let differences = |along: &Along| -> Result<(Vec<f64>, Vec<f64>), ModelFailure> {
            let (above, below) = rayon::join(|| along.above.steady(about.design), || along.below.steady(about.design));
            let (above, below) = (above?.ratio, below?.ratio);
            let at = |load: usize| {
                let (above, below, own, step) = (above[load], below[load], about.still[load], along.step[load]);
                let slope = scale[load] * (above - below) / (2.0 * step);
                (slope, scale[load] * (above - 2.0 * own + below) / (2.0 * step * step))
            };
            Ok((0..count).map(at).unzip())
        };
        if let Some(along) = &self.friction {
            for (load, slope) in differences(along)?.0.into_iter().enumerate() {
                // mu = r mu_flat (1 + x)
                slopes[along.first + load % self.inputs_of_loads][load] =
                    slope + if self.is_ratio { 0.0 } else { values[load] };
            }
        }
        for along in self.law_scale.iter().chain(&self.law) {
            let (slope, curvature) = differences(along)?;
            slopes[along.first] = slope;
            curvatures.push((along.first, curvature));
        }
        about.numerical.enter(&mut slopes[self.numerical()]);
        Ok(Expansion { slopes: Linearization::of_slopes(*about.design, values, slopes), curvatures, discrepancy })
    }

    /// dr/dh of each ratio along the height of the rims, per metre: over a standard deviation each way, and upwards alone
    /// where the rims are lower than that.
    fn along_rim(&self, design: &Pattern) -> Result<Vec<f64>, ModelFailure> {
        let step_m = self.tolerances.rim_height_std_m;
        let laid = self.still.lay(design)?;
        let at = |by_m: f64| self.still.ratios_made(&with_rim_off(design, by_m), &laid);
        let below_m = if design.rim_height_m() < step_m { 0.0 } else { -step_m };
        let (above, below) = (at(step_m)?, at(below_m)?);
        Ok(above.iter().zip(&below).map(|(above, below)| (above - below) / (step_m - below_m)).collect())
    }

    /// Standard deviation of each ratio of `design` by the height of its rims alone; `None` where that is exact, or where
    /// neighbours of the design cannot be computed.
    #[must_use]
    pub fn rim_std(&self, design: &Pattern) -> Option<Vec<f64>> {
        self.uncertainty.rim()?;
        let per_m = self.along_rim(design).ok()?;
        Some(per_m.iter().map(|slope| slope.abs() * self.tolerances.rim_height_std_m).collect())
    }

    /// Covariance of the logarithms of the values of a sample of a design, row by row, by everything but what trials say that the model lacks,
    /// which Young's modulus belongs to: to first order.
    ///
    /// # Errors
    /// [`ModelFailure`] where neighbours of the design cannot be computed.
    pub fn log_covariance(&self, about: &About<'_>) -> Result<Vec<f64>, ModelFailure> {
        Ok(self.log_covariance_of(&self.expand(about)?))
    }

    /// The same of a design's expansion.
    pub fn log_covariance_of(&self, expansion: &Expansion) -> Vec<f64> {
        let modulus = self.law_scale.as_ref().filter(|_| !self.scale_is_fitted).map(|along| along.first);
        let (slopes, values) = (&expansion.slopes, expansion.slopes.values());
        let rows = slopes.covariance_of(&self.uncertainty, &|place| Some(place) != modulus);
        // cov(ln v, ln w) = cov(v, w) / (v w)
        let row = |(row, own): (Vec<f64>, &f64)| {
            row.into_iter().zip(values).map(move |(entry, other)| entry / (own * other)).collect::<Vec<f64>>()
        };
        rows.into_iter().zip(values).flat_map(row).collect()
    }

    /// dr/dx of each ratio along one dimension, per metre.
    fn along_axis(&self, design: &Pattern, axis: usize, std_m: f64) -> Result<Vec<f64>, ModelFailure> {
        let lengths_m = design.lengths_m();
        let (step_m, laid) = (std_m.min(WIDEST_SHARE * lengths_m[axis]), self.still.lay(design)?);
        let at = |by_m: f64| {
            let mut made_m = lengths_m;
            made_m[axis] += by_m;
            let made = Pattern::new(*design.texture(), made_m[0], made_m[1], made_m[2]);
            let made = made.map_err(|error| ModelFailure::Trial { reason: error.to_string() })?;
            self.still.ratios_made(&made, &laid)
        };
        let slope = |above: Vec<f64>, below: Vec<f64>, width_m: f64| -> Vec<f64> {
            above.iter().zip(&below).map(|(above, below)| (above - below) / width_m).collect()
        };
        match rayon::join(|| at(step_m), || at(-step_m)) {
            (Ok(above), Ok(below)) => Ok(slope(above, below, 2.0 * step_m)),
            // One-sided beside designs that cannot be computed.
            (Ok(above), Err(ModelFailure::Trial { .. })) => Ok(slope(above, at(0.0)?, step_m)),
            (Err(ModelFailure::Trial { .. }), Ok(below)) => Ok(slope(at(0.0)?, below, step_m)),
            (Err(failure), _) | (_, Err(failure)) => Err(failure),
        }
    }
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
