//! Input uncertainties that trials do not reduce: dimensions and rim height of a sample, depth per burst, flat
//! friction, the area law, and the numerical error of ratios.
//!
//! Each input changes ln R, R the friction ratio, to first order; Young's modulus and the area law's scale change it to
//! second order as well. Errors that all samples share are a covariance of ln R; errors that are independent between
//! samples are a [`DimensionShift`], which also changes the discrepancy.

use std::ops::Range;

use crate::optimize::{ModelFailure, Quantity, SearchError, Tolerances, Uncertainty, with_rim_off};
use slipgrid_base::units::{LENGTH_UM, tidy};
use slipgrid_infer::calibrate::uncertainty::{Covariance, MaterialUncertainty, ScaleShift, Source, moved, with_scale};
use slipgrid_infer::discrepancy::{DimensionShift, Features};
use slipgrid_model::material::{Condition, MaterialError};
use slipgrid_model::pattern::Pattern;
use slipgrid_model::springblock::Scene;

use crate::DesignError;
use crate::evaluation_cache::Answer;
use crate::operating_conditions::Further;
use crate::sensitivities::conditions;
use crate::steady_model::SteadyModel;
use crate::task::DesignTask;

/// Number of dimensions: width, spacing and depth, the first inputs.
const DIMENSIONS: usize = 3;
/// Index of the depth among the dimensions.
const DEPTH: usize = 2;
/// Maximum step of a finite difference along a dimension, as a fraction of the dimension.
const WIDEST_SHARE: f64 = 0.5;
/// Standard deviation of the friction ratio between dynamic runs of one specimen that differ in speed or in the moment
/// of stick-slip: in the plane, from the test `ratios_that_are_predicted_are_those_of_the_specimen`; and in space,
/// where the search does not model sliding in time, and runs differ by 0.001 to 0.004.
const RUN_STD: [f64; 2] = [0.0015, 0.003];

/// Uncertain input.
#[derive(Clone, Debug, PartialEq)]
struct Input {
    name: &'static str,
    /// Accuracy of the input, in words that follow the name.
    known_to: String,
    /// Indices of the input's components among all inputs.
    places: Range<usize>,
}

/// Effect of one uncertain input on a texture.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Name of the input.
    pub name: &'static str,
    /// Accuracy of the input, in words that follow the name.
    pub known_to: String,
    /// Effect on ln R, R the friction ratio.
    pub effect: InputEffect,
}

/// Effect of an uncertain input on ln R, R the friction ratio.
#[derive(Clone, Debug, PartialEq)]
pub enum InputEffect {
    /// Covariance of ln R between loads from an error that all samples share: n by n matrix for n loads, row by row.
    Shared(Vec<f64>),
    /// Change of ln R by an error that is independent between samples.
    OfSample(DimensionShift),
}

/// Model with all uncertain inputs, at every condition.
pub struct Inputs<'a> {
    is_ratio: bool,
    loads: usize,
    /// Number of loads with separate inputs: the loads of one sliding direction, whose inputs all directions share.
    inputs_of_loads: usize,
    tolerances: Tolerances,
    uncertainty: Uncertainty,
    /// Model with all inputs at their means.
    still: SteadyModel<'a>,
    /// Model in blocks of half the size; `None` in space.
    fine: Option<SteadyModel<'a>>,
    /// Pairs of models with changed flat friction, scale of the area law (or Young's modulus), and factors of the area
    /// law.
    along: Vec<Along<'a>>,
    /// Index of the depth per burst among the inputs; `None` if the laser settings give no error of this depth.
    burst: Option<usize>,
    inputs: Vec<Input>,
}

/// Pair of models with one input, or flat friction at all loads, one standard deviation above and below the mean.
struct Along<'a> {
    above: SteadyModel<'a>,
    below: SteadyModel<'a>,
    /// Standard deviation of the input, one per load.
    step: Vec<f64>,
    /// Index of the first changed input.
    first: usize,
    is_friction: bool,
    /// Whether the input is Young's modulus. The discrepancy includes its first-order effect, because trials inform
    /// about it.
    is_modulus: bool,
}

#[derive(Default)]
struct Blocks {
    inputs: Vec<Input>,
    blocks: Vec<Covariance>,
    count: usize,
}

impl Blocks {
    /// Adds the covariance of further inputs and returns the index of the first of them.
    fn add(&mut self, block: Covariance) -> usize {
        let first = self.count;
        self.count += block.len();
        self.blocks.push(block);
        first
    }

    fn name(&mut self, name: &'static str, known_to: String, places: Range<usize>) {
        self.inputs.push(Input { name, known_to, places });
    }
}

impl<'a> Inputs<'a> {
    /// Collects the inputs of `task` with its `material` for `model` at every condition, the design condition first.
    ///
    /// # Errors
    /// [`DesignError`] if the stated errors of the material are invalid.
    pub fn new(
        task: &DesignTask,
        material: &MaterialUncertainty,
        model: &SteadyModel<'a>,
        further: &[Further],
    ) -> Result<Self, DesignError> {
        let values = model.asked().loads.len();
        // All directions share the material, so the loads of the first direction stand for the others.
        let directions = 1 + task.directions.different_deg.len();
        let count = values / directions;
        let loads = &model.asked().loads[..count];
        let conditions: Vec<Option<Condition>> = conditions(task, further).collect();
        let conditions = &conditions[..conditions.len() / directions];
        let of_material = |error: MaterialError| DesignError::Failed(format!("errors of the material: {error}"));
        let tolerances = task.tolerances.unwrap_or_default();
        let mut parts = Blocks { count: DIMENSIONS, ..Blocks::default() };

        let law = model.area_law();
        let (mut friction_at, mut scale_at) = (None, None);
        if let (Some(known), Some(law)) = (&material.scale_covariance, law) {
            let joint = with_scale(known, law, loads).map_err(of_material)?;
            let first = parts.add(joint.clone());
            parts.name(FLAT_FRICTION, percent(rms(&joint[..count])), first..first + count);
            parts.name("scale of the area law", percent(joint[count][count].sqrt()), first + count..first + count + 1);
            (friction_at, scale_at) = (Some(first), Some(first + count));
        } else {
            if let Some(covariance) = material.friction_covariance(&task.pressures_pa(), conditions) {
                let known_to = percent(rms(&covariance));
                let first = parts.add(covariance);
                parts.name(FLAT_FRICTION, known_to, first..first + count);
                friction_at = Some(first);
            }
            if let Some(std) = material.modulus_std(law) {
                let first = parts.add(vec![vec![std * std]]);
                parts.name(MODULUS, percent(std), first..first + 1);
                scale_at = Some(first);
            }
        }
        let mut law_at = None;
        if law.is_some_and(|law| law.factor_std().is_some()) {
            let first = parts.add(vec![vec![1.0]]);
            parts.name("area law", "known to the scatter of its map's windows".to_owned(), first..first + 1);
            law_at = Some(first);
        }
        let burst = task.laser.depth_per_burst_std().map(|std| parts.add(vec![vec![std * std]]));
        let refused = |error: SearchError| DesignError::Failed(format!("errors of the material: {error}"));
        let uncertainty = Uncertainty::new(&tolerances, &diagonal(&parts.blocks)).map_err(refused)?;

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
            let is_modulus = scale > 0.0 && !is_fitted;
            Ok::<_, DesignError>(Some(Along {
                above: own(1.0)?,
                below: own(-1.0)?,
                step,
                first,
                is_friction: friction,
                is_modulus,
            }))
        };
        let all = [
            along(friction_at, count, true, 0.0, 0.0)?,
            along(scale_at, 1, false, 1.0, 0.0)?,
            along(law_at, 1, false, 0.0, 1.0)?,
        ];
        Ok(Self {
            is_ratio: task.target.quantity() == Quantity::Ratio,
            loads: values,
            inputs_of_loads: count,
            tolerances,
            still: model.beside(|scene: &Scene| Ok::<_, DesignError>(scene.clone()))?,
            fine: fine(model)?,
            along: all.into_iter().flatten().collect(),
            burst,
            uncertainty,
            inputs: parts.inputs,
        })
    }

    /// Computes the effect of every input on `design` with ratios `ratio`. `of_blocks` is the standard deviation of
    /// each ratio due to the block size; if `None`, it is estimated from blocks of half the size.
    ///
    /// # Errors
    /// [`ModelFailure`] if the design, or the design with a changed input, cannot be computed.
    pub fn parts(
        &self,
        design: &Pattern,
        ratio: &[f64],
        of_blocks: Option<Vec<f64>>,
    ) -> Result<Vec<Part>, ModelFailure> {
        let still = self.still.steady(design)?.ratio;
        let mut parts = self.of_samples(design, &still)?;
        let laid = self.still.lay(design)?;
        // cov(ln R_l, ln R_m) = cov(R_l, R_m) / (R_l R_m)
        let log = |covariance: &dyn Fn(usize, usize) -> f64| -> Vec<f64> {
            let n = self.loads;
            (0..n * n).map(|e| covariance(e / n, e % n) / (ratio[e / n] * ratio[e % n])).collect()
        };
        let mut slopes = vec![vec![0.0; self.loads]; self.uncertainty.inputs()];
        let mut bends: Vec<(usize, Vec<f64>)> = Vec::new();
        let mut known_elsewhere = Vec::new();
        for along in &self.along {
            // All evaluations use one layout, because the layout of crossing grooves takes as long as a solve.
            let at = |model: &SteadyModel| model.ratios_made(design, &laid);
            let (above, below) = rayon::join(|| at(&along.above), || at(&along.below));
            let (above, below) = (above?, below?);
            let mut bend = vec![0.0; self.loads];
            for (load, bend) in bend.iter_mut().enumerate() {
                let (above, below, own, step) = (above[load], below[load], still[load], along.step[load]);
                // (r(x + s) - r(x - s)) / 2s and (r(x + s) - 2 r(x) + r(x - s)) / 2
                let of_friction = if along.is_friction && !self.is_ratio { ratio[load] } else { 0.0 };
                let place = along.first + if along.is_friction { load % self.inputs_of_loads } else { 0 };
                // mu = r mu_flat (1 + x)
                slopes[place][load] = (above - below) / (2.0 * step) + of_friction;
                *bend = 0.5 * (above - 2.0 * own + below);
            }
            if !along.is_friction {
                bends.push((along.first, bend));
            }
            if along.is_modulus {
                known_elsewhere.push(along.first);
            }
        }
        for input in &self.inputs {
            let is_own = |place: usize| input.places.contains(&place) && !known_elsewhere.contains(&place);
            let of_input = self.uncertainty.covariance_of(&slopes, &is_own);
            // x^2 of a standard deviate x has the variance 2.
            let bent = |l: usize, m: usize| -> f64 {
                let own = bends.iter().filter(|(place, _)| input.places.contains(place));
                own.map(|(_, bend)| 2.0 * bend[l] * bend[m]).sum()
            };
            let covariance = log(&|l, m| of_input[l][m] + bent(l, m));
            let (name, known_to) = (input.name, input.known_to.clone());
            parts.push(Part { name, known_to, effect: InputEffect::Shared(covariance) });
        }
        let of_blocks = match of_blocks {
            Some(std) => std,
            None => vec![self.block_std(design, &still)?; self.loads],
        };
        let run_std = RUN_STD[usize::from(!self.still.is_cheap_per_design())];
        // The error by block size has the same sign at all loads, so it is fully correlated.
        let numerical = log(&|l, m| of_blocks[l] * of_blocks[m] + if l == m { run_std * run_std } else { 0.0 });
        let most = of_blocks.iter().map(|std| std.hypot(run_std)).fold(0.0, f64::max);
        let known_to = format!("up to {most:.4}");
        parts.push(Part { name: "numerical error", known_to, effect: InputEffect::Shared(numerical) });
        Ok(parts)
    }

    /// Standard deviation of the ratios of `design` due to the block size; `still` are the ratios in the requested
    /// blocks. 0 in space, where smaller blocks are too expensive.
    fn block_std(&self, design: &Pattern, still: &[f64]) -> Result<f64, ModelFailure> {
        let Some(fine) = &self.fine else { return Ok(0.0) };
        let fine = fine.steady(design)?.ratio;
        Ok(block_std(still.iter().zip(&fine).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)))
    }

    /// Effects of inputs that are independent between samples of `design`: dimensions, rim height, depth per burst.
    /// `still` are the ratios of the design without changes.
    fn of_samples(&self, design: &Pattern, still: &[f64]) -> Result<Vec<Part>, ModelFailure> {
        let mut parts = Vec::new();
        let part = |name: &'static str, known_to: String, by_m: [f64; DIMENSIONS], log_ratio: Vec<f64>| Part {
            name,
            known_to,
            effect: InputEffect::OfSample(shift(design, &by_m, log_ratio)),
        };
        let made_to = |std_m: f64| format!("made to {} um", tidy(LENGTH_UM.from_si(std_m)));
        for (name, by_m) in of_dimensions(&self.tolerances) {
            let own_m = by_m.iter().copied().find(|by_m| *by_m != 0.0).unwrap_or(0.0);
            parts.push(part(name, made_to(own_m), by_m, self.by_lengths(design, &by_m)?));
        }
        let per = |step: &Answers, std: f64| -> Vec<f64> {
            let each = step.above.ratio.iter().zip(&step.below.ratio).zip(still);
            each.map(|((above, below), own)| std * (above - below) / (step.step * own)).collect()
        };
        if self.uncertainty.rim().is_some() {
            let std_m = self.tolerances.rim_height_std_m();
            let laid = self.still.lay(design)?;
            let at = |by_m: f64| self.still.answer_made(&with_rim_off(design, by_m), &laid);
            // One-sided, upwards, if the rims are lower than one standard deviation.
            let below_m = if design.rim_height_m() < std_m { 0.0 } else { -std_m };
            let log = per(&Answers { above: at(std_m)?, below: at(below_m)?, step: std_m - below_m }, std_m);
            parts.push(part("rim height", made_to(std_m), [0.0; DIMENSIONS], log));
        }
        if let Some(place) = self.burst {
            let std = self.uncertainty.std(place);
            let by_m = std::array::from_fn(|axis| if axis == DEPTH { std * design.depth_m() } else { 0.0 });
            parts.push(part("depth per burst", percent(std), by_m, self.by_lengths(design, &by_m)?));
        }
        Ok(parts)
    }

    /// Change of ln R, R the friction ratio, of `design` at each load if its lengths change by `by_m`, in metres.
    fn by_lengths(&self, design: &Pattern, by_m: &[f64; DIMENSIONS]) -> Result<Vec<f64>, ModelFailure> {
        let laid = self.still.lay(design)?;
        let lengths_m = design.lengths_m();
        // Limits the step so that no length vanishes.
        let widest = lengths_m.iter().zip(by_m).map(|(own, by)| WIDEST_SHARE * own / by.abs()).fold(1.0, f64::min);
        let at = |side: f64| {
            let [width_m, spacing_m, depth_m] =
                std::array::from_fn(|axis| lengths_m[axis] + side * widest * by_m[axis]);
            let made = Pattern::new(*design.texture(), width_m, spacing_m, depth_m);
            let made = made.map_err(|error| ModelFailure::Trial { reason: error.to_string() })?;
            Ok(self.still.answer_made(&made, &laid)?.ratio)
        };
        let log = |above: &[f64], below: &[f64], sides: f64| -> Vec<f64> {
            above.iter().zip(below).map(|(above, below)| (above / below).ln() / (sides * widest)).collect()
        };
        match rayon::join(|| at(1.0), || at(-1.0)) {
            (Ok(above), Ok(below)) => Ok(log(&above, &below, 2.0)),
            // One-sided next to designs that cannot be computed.
            (Ok(above), Err(ModelFailure::Trial { .. })) => Ok(log(&above, &at(0.0)?, 1.0)),
            (Err(ModelFailure::Trial { .. }), Ok(below)) => Ok(log(&at(0.0)?, &below, 1.0)),
            (Err(failure), _) | (_, Err(failure)) => Err(failure),
        }
    }
}

/// Name of the input Young's modulus.
pub const MODULUS: &str = "Young's modulus";
/// Name of the input flat friction, the only uncertain input of a flat surface.
pub const FLAT_FRICTION: &str = Source::FlatFriction.name();
/// Name of the input that decides whether friction follows the local or the nominal pressure.
pub const LOCAL_LAW: &str = "local law";
/// Name of the scatter of friction between samples of one texture.
pub const SCATTER: &str = "scatter between samples";

struct Answers {
    above: Answer,
    below: Answer,
    step: f64,
}

/// Independent errors of the dimensions of samples: name of the first dimension that changes, and changes of width,
/// spacing and depth by one standard deviation, in metres.
pub fn of_dimensions(tolerances: &Tolerances) -> Vec<(&'static str, [f64; DIMENSIONS])> {
    let name = |by_m: &[f64; DIMENSIONS]| {
        by_m.iter().position(|by_m| *by_m != 0.0).map_or("", |axis| ["width", "spacing", "depth"][axis])
    };
    tolerances.independent_m().into_iter().map(|by_m| (name(&by_m), by_m)).collect()
}

/// Builds the error of samples of `design`: a change of the lengths by `by_m`, in metres, changes ln R, R the friction
/// ratio, by `log_ratio`, one per load.
pub fn shift(design: &Pattern, by_m: &[f64; DIMENSIONS], log_ratio: Vec<f64>) -> DimensionShift {
    let [above, below] = [1.0, -1.0].map(|side| Features::from(&made(design, by_m, side)));
    DimensionShift { log_ratio, above, below: Some(below) }
}

/// Returns `design` with its lengths changed by `side` times `by_m`, in metres; no length loses more than nine tenths.
pub fn made(design: &Pattern, by_m: &[f64; DIMENSIONS], side: f64) -> Pattern {
    let lengths_m = design.lengths_m();
    let [width_m, spacing_m, depth_m] =
        std::array::from_fn(|axis| (lengths_m[axis] + side * by_m[axis]).max(0.1 * lengths_m[axis]));
    Pattern::new(*design.texture(), width_m, spacing_m, depth_m).unwrap_or(*design)
}

/// Standard deviation due to the block size of a value that changes by `difference` in blocks of half the size: half of
/// the extrapolated distance of the value from the limit of vanishing blocks, for an order of convergence of 1/2.
fn block_std(difference: f64) -> f64 {
    // |r_l - r_(l/2)| (1 + 1 / (2^(1/2) - 1)), as two standard deviations
    0.5 * difference.abs() * (1.0 + 1.0 / (std::f64::consts::SQRT_2 - 1.0))
}

/// Joins the covariances of independent groups of inputs to a block-diagonal matrix.
fn diagonal(blocks: &[Covariance]) -> Covariance {
    let count = blocks.iter().map(Vec::len).sum();
    let mut all = vec![vec![0.0; count]; count];
    let mut first = 0;
    for block in blocks {
        for (row, entries) in block.iter().enumerate() {
            all[first + row][first..first + block.len()].copy_from_slice(entries);
        }
        first += block.len();
    }
    all
}

/// Root mean square of the standard deviations that the diagonal of `covariance` gives.
fn rms(covariance: &[Vec<f64>]) -> f64 {
    let sum: f64 = covariance.iter().enumerate().map(|(place, row)| row[place]).sum();
    (sum / covariance.len().max(1) as f64).sqrt()
}

/// Formats a relative standard deviation.
pub fn percent(std: f64) -> String {
    let percent = 100.0 * std;
    if percent < 9.95 { format!("known to {percent:.1} %") } else { format!("known to {percent:.0} %") }
}

/// Returns `model` in blocks of half the size; `None` in space, where smaller blocks are too expensive.
fn fine<'a>(model: &SteadyModel<'a>) -> Result<Option<SteadyModel<'a>>, DesignError> {
    let change = |scene: &Scene| {
        let mut fine = scene.clone();
        fine.layer.block_m *= 0.5;
        Ok::<_, DesignError>(fine)
    };
    if model.is_cheap_per_design() { model.beside(change).map(Some) } else { Ok(None) }
}
