//! Input uncertainties that trials do not reduce: dimensions and rim height of a sample, depth per burst, flat
//! friction, the area law, and the numerical error of ratios.
//!
//! Each input changes ln R, R the friction ratio, to first order; Young's modulus and the area law's scale change it to
//! second order as well. Errors that all samples share are a covariance of ln R; errors that are independent between
//! samples are a [`DimensionShift`], which also changes the discrepancy.

use crate::optimize::{ModelFailure, Quantity, SearchError, Tolerances, with_rim_off};
use slipgrid_base::units::{LENGTH_UM, tidy};
use slipgrid_infer::calibrate::uncertainty::{Covariance, ScaleShift, Source, moved, with_scale};
use slipgrid_infer::discrepancy::{DimensionShift, Features};
use slipgrid_laser::specimen::Laid;
use slipgrid_model::material::{Condition, MaterialError};
use slipgrid_model::pattern::Pattern;
use slipgrid_model::springblock::Scene;

use crate::DesignError;
use crate::prepared_task::PreparedTask;
use crate::steady_model::SteadyModel;

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
    tolerances: Tolerances,
    /// Relative standard deviation of the depth per burst; `None` if the laser settings give no error of this depth.
    burst_std: Option<f64>,
    /// Model with all inputs at their means.
    still: SteadyModel<'a>,
    /// Model in blocks of half the size; `None` in space, where smaller blocks are too expensive.
    fine: Option<SteadyModel<'a>>,
    inputs: Vec<Input<'a>>,
}

/// Uncertain number of the material, with models at one standard deviation above and below its mean.
struct Input<'a> {
    source: Source,
    /// Accuracy of the input, in words that follow the name.
    known_to: String,
    /// Covariance of the input: of flat friction between the loads of one sliding direction, whose inputs all directions
    /// share; of other inputs the variance alone.
    covariance: Covariance,
    /// The part of `covariance` that the errors of trials do not share.
    rest: Covariance,
    above: SteadyModel<'a>,
    below: SteadyModel<'a>,
}

/// Standard deviation at the load with the index `load`, from the `covariance` of an [`Input`].
fn std_at(covariance: &Covariance, load: usize) -> f64 {
    let place = load % covariance.len();
    covariance[place][place].sqrt()
}

impl<'a> Inputs<'a> {
    /// Collects the inputs of `prepared` for `model` at every condition. `flat_rest` is the part of the covariance of flat
    /// friction that the errors of trials do not share; `None` if they share nothing.
    ///
    /// # Errors
    /// [`DesignError`] if the stated errors of the material or the tolerances are invalid.
    pub fn new(
        prepared: &PreparedTask,
        model: &SteadyModel<'a>,
        flat_rest: Option<&Covariance>,
    ) -> Result<Self, DesignError> {
        let PreparedTask { task, uncertainty: material, settings, .. } = prepared;
        let values = model.asked().loads.len();
        // All directions share the material, so the loads of the first direction stand for the others.
        let directions = 1 + task.directions.different_deg.len();
        let count = values / directions;
        let loads = &model.asked().loads[..count];
        let conditions: Vec<Option<Condition>> =
            settings[..settings.len() / directions].iter().map(|setting| setting.condition).collect();
        let of_material = |error: MaterialError| DesignError::Failed(format!("errors of the material: {error}"));
        let tolerances = task.tolerances.unwrap_or_default();
        let refused = |error: SearchError| DesignError::Failed(format!("errors of the material: {error}"));
        tolerances.check().map_err(refused)?;

        let law = model.area_law();
        let mut stated: Vec<(Source, String, Covariance)> = Vec::new();
        if let (Some(known), Some(law)) = (&material.scale_covariance, law) {
            let joint = with_scale(known, law, loads).map_err(of_material)?;
            let friction: Covariance = joint[..count].iter().map(|row| row[..count].to_vec()).collect();
            let variance = joint[count][count];
            stated.push((Source::FlatFriction, known_to(rms(&friction)), friction));
            stated.push((Source::FittedScale, known_to(variance.sqrt()), vec![vec![variance]]));
        } else {
            if let Some(covariance) = material.friction_covariance(&task.pressures_pa(), &conditions) {
                stated.push((Source::FlatFriction, known_to(rms(&covariance)), covariance));
            }
            if let Some(std) = material.modulus_std(law) {
                stated.push((Source::Modulus, known_to(std), vec![vec![std * std]]));
            }
        }
        if law.is_some_and(|law| law.factor_std().is_some()) {
            let known_to = "known to the scatter of its map's windows".to_owned();
            stated.push((Source::AreaLaw, known_to, vec![vec![1.0]]));
        }

        let halved = |scene: &Scene| {
            let mut fine = scene.clone();
            fine.layer.block_m *= 0.5;
            Ok::<_, DesignError>(fine)
        };
        let is_fitted = material.scale_covariance.is_some();
        let input = |(source, known_to, covariance): (Source, String, Covariance)| {
            let own = |side: f64| {
                let if_of = |is_own: bool, load: usize| if is_own { side * std_at(&covariance, load) } else { 0.0 };
                let by: Vec<f64> = (0..values).map(|load| if_of(source == Source::FlatFriction, load)).collect();
                let scale = if_of(matches!(source, Source::Modulus | Source::FittedScale), 0);
                let scale = ScaleShift::off_by(scale, is_fitted);
                let law = if_of(source == Source::AreaLaw, 0);
                model.beside(|scene: &Scene| moved(scene, &by, scale, law)).map_err(of_material)
            };
            let (above, below) = (own(1.0)?, own(-1.0)?);
            let rest = flat_rest.filter(|_| source == Source::FlatFriction).unwrap_or(&covariance).clone();
            Ok::<_, DesignError>(Input { source, known_to, covariance, rest, above, below })
        };
        Ok(Self {
            is_ratio: task.target.quantity() == Quantity::Ratio,
            loads: values,
            tolerances,
            burst_std: task.laser.depth_per_burst_std(),
            still: model.beside(|scene: &Scene| Ok::<_, DesignError>(scene.clone()))?,
            fine: if model.is_cheap_per_design() { Some(model.beside(halved)?) } else { None },
            inputs: stated.into_iter().map(input).collect::<Result<_, _>>()?,
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
        for input in &self.inputs {
            // All evaluations use one layout, because the layout of crossing grooves takes as long as a solve.
            let at = |model: &SteadyModel| model.ratios_made(design, &laid);
            let (above, below) = rayon::join(|| at(&input.above), || at(&input.below));
            let (above, below) = (above?, below?);
            let is_friction = input.source == Source::FlatFriction;
            let mut slopes = vec![vec![0.0; self.loads]; input.covariance.len()];
            let mut bend = vec![0.0; self.loads];
            for load in 0..self.loads {
                let (above, below, own) = (above[load], below[load], still[load]);
                // (r(x + s) - r(x - s)) / 2s and (r(x + s) - 2 r(x) + r(x - s)) / 2; mu = r mu_flat (1 + x)
                let of_friction = if is_friction && !self.is_ratio { ratio[load] } else { 0.0 };
                slopes[load % input.covariance.len()][load] =
                    (above - below) / (2.0 * std_at(&input.covariance, load)) + of_friction;
                bend[load] = 0.5 * (above - 2.0 * own + below);
            }
            let first_order = propagated(&input.rest, &slopes);
            let covariance = log(&|l, m| {
                // The discrepancy includes the first order of the modulus, because trials inform about it.
                let first = if input.source == Source::Modulus { 0.0 } else { first_order[l][m] };
                // x^2 of a standard deviate x has the variance 2.
                let second = if is_friction { 0.0 } else { 2.0 * bend[l] * bend[m] };
                first + second
            });
            let (name, known_to) = (input.source.name(), input.known_to.clone());
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
        let (mut parts, laid) = (Vec::new(), self.still.lay(design)?);
        let part = |name: &'static str, known_to: String, by_m: [f64; DIMENSIONS], log_ratio: Vec<f64>| Part {
            name,
            known_to,
            effect: InputEffect::OfSample(shift(design, &laid, &by_m, log_ratio)),
        };
        let made_to = |std_m: f64| format!("made to {} um", tidy(LENGTH_UM.from_si(std_m)));
        for (name, by_m) in of_dimensions(&self.tolerances) {
            let own_m = by_m.iter().copied().find(|by_m| *by_m != 0.0).unwrap_or(0.0);
            parts.push(part(name, made_to(own_m), by_m, self.by_lengths(design, &by_m)?));
        }
        let std_m = self.tolerances.rim_height_std_m();
        if std_m > 0.0 {
            let laid = self.still.lay(design)?;
            let at = |by_m: f64| self.still.answer_made(&with_rim_off(design, by_m), &laid);
            // One-sided, upwards, if the rims are lower than one standard deviation.
            let below_m = if design.rim_height_m() < std_m { 0.0 } else { -std_m };
            let (above, below) = (at(std_m)?.ratio, at(below_m)?.ratio);
            let each = above.iter().zip(below).zip(still);
            let log = each.map(|((above, below), own)| std_m * (above - below) / ((std_m - below_m) * own)).collect();
            parts.push(part("rim height", made_to(std_m), [0.0; DIMENSIONS], log));
        }
        if let Some(std) = self.burst_std {
            let by_m = std::array::from_fn(|axis| if axis == DEPTH { std * design.depth_m() } else { 0.0 });
            parts.push(part("depth per burst", known_to(std), by_m, self.by_lengths(design, &by_m)?));
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
            let made = made.map_err(|error| ModelFailure::Trial(error.to_string()))?;
            Ok(self.still.answer_made(&made, &laid)?.ratio)
        };
        let log = |above: &[f64], below: &[f64], sides: f64| -> Vec<f64> {
            above.iter().zip(below).map(|(above, below)| (above / below).ln() / (sides * widest)).collect()
        };
        match rayon::join(|| at(1.0), || at(-1.0)) {
            (Ok(above), Ok(below)) => Ok(log(&above, &below, 2.0)),
            // One-sided next to designs that cannot be computed.
            (Ok(above), Err(ModelFailure::Trial(_))) => Ok(log(&above, &at(0.0)?, 1.0)),
            (Err(ModelFailure::Trial(_)), Ok(below)) => Ok(log(&at(0.0)?, &below, 1.0)),
            (Err(failure), _) | (_, Err(failure)) => Err(failure),
        }
    }
}

/// Name of the input Young's modulus.
pub const MODULUS: &str = Source::Modulus.name();
/// Name of the input flat friction, the only uncertain input of a flat surface.
pub const FLAT_FRICTION: &str = Source::FlatFriction.name();
/// Name of the input that decides whether friction follows the local or the nominal pressure.
pub const LOCAL_LAW: &str = "local law";
/// Name of the scatter of friction between samples of one texture.
pub const SCATTER: &str = "scatter between samples";

/// Independent errors of the dimensions of samples: name of the first dimension that changes, and changes of width,
/// spacing and depth by one standard deviation, in metres.
pub fn of_dimensions(tolerances: &Tolerances) -> Vec<(&'static str, [f64; DIMENSIONS])> {
    let name = |by_m: &[f64; DIMENSIONS]| {
        by_m.iter().position(|by_m| *by_m != 0.0).map_or("", |axis| ["width", "spacing", "depth"][axis])
    };
    tolerances.independent_m().into_iter().map(|by_m| (name(&by_m), by_m)).collect()
}

/// Builds the error of samples of `design` with as many cavities as `laid`: a change of the lengths by `by_m`, in metres,
/// changes ln R, R the friction ratio, by `log_ratio`, one per load.
pub fn shift(design: &Pattern, laid: &Laid, by_m: &[f64; DIMENSIONS], log_ratio: Vec<f64>) -> DimensionShift {
    let [above, below] = [1.0, -1.0].map(|side| {
        let made = made(design, by_m, side);
        Features::on_face(&made, laid.share(&made))
    });
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

/// Covariance of values from inputs with the `covariance` C, one row per value: G' C G, with the derivatives
/// G = `slopes`, one row per input and one column per value.
fn propagated(covariance: &Covariance, slopes: &[Vec<f64>]) -> Covariance {
    let count = slopes.first().map_or(0, Vec::len);
    let mut of_values = vec![vec![0.0; count]; count];
    for (row, left) in covariance.iter().zip(slopes) {
        for (entry, right) in row.iter().zip(slopes).filter(|(entry, _)| **entry != 0.0) {
            for (value, sums) in of_values.iter_mut().enumerate() {
                let left = left[value] * entry;
                sums.iter_mut().zip(right).for_each(|(sum, right)| *sum += left * right);
            }
        }
    }
    of_values
}

/// Root mean square of the standard deviations that the diagonal of `covariance` gives.
fn rms(covariance: &[Vec<f64>]) -> f64 {
    let sum: f64 = covariance.iter().enumerate().map(|(place, row)| row[place]).sum();
    (sum / covariance.len().max(1) as f64).sqrt()
}

/// Formats a relative standard deviation, at least 0.1 %.
pub fn known_to(std: f64) -> String {
    let percent = (100.0 * std).max(0.1);
    if percent < 9.95 { format!("known to {percent:.1} %") } else { format!("known to {percent:.0} %") }
}
