//! First-order propagation of standard deviations: slopes of the steady ratio times the errors of the inputs. The ratio
//! is nonlinear in Young's modulus, whose error may be a fifth of the value; therefore intervals are computed from
//! solves at 1 and 1.96 standard deviations on both sides, and are asymmetric.

use rayon::prelude::*;
use slipgrid_base::statistics::NORMAL_95;
use slipgrid_model::material::{AreaLaw, LocalFriction, MaterialError};
use slipgrid_model::pattern::Pattern;
use slipgrid_model::springblock::{Expense, Extent, Fidelity, Load, RunOptions, Scene, SteadyCell, cell_expense};

use super::{InputUncertainty, Source};

/// Sensitivity of the ratio of a pattern to uncertain inputs: central differences over one standard deviation, with the
/// steady cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Slopes {
    /// Slopes of the steady ratio at each load against the relative error of flat friction, the logarithm of Young's
    /// modulus or of the fitted scale, and the common shift of all factors of the area law in standard errors; zero for
    /// inputs without known errors. `None` if the ratio cannot be computed at one of the shifted inputs.
    by_load: Vec<Option<[f64; 3]>>,
    has_law_errors: bool,
    /// Changes of the ratio for deviations [`BENT_DEVIATIONS`] of Young's modulus, one list per load; empty if the
    /// error of the modulus is not known or a ratio cannot be computed.
    bends: Vec<[f64; 4]>,
}

/// Deviations of the modulus, in standard deviations, at which intervals are solved: the ends of the 68 % and 95 %
/// intervals.
const BENT_DEVIATIONS: [f64; 4] = [-NORMAL_95, -1.0, 1.0, NORMAL_95];
/// Below this relative error of Young's modulus its logarithm is extrapolated linearly, so that the modulus stays
/// positive.
const MIN_LOG_MODULUS_ERROR: f64 = -0.5;

/// A standard deviation with its contributions.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Deviation {
    /// Total standard deviation including correlations.
    pub std: f64,
    /// Standard deviation from each source alone.
    pub parts: Vec<(Source, f64)>,
    /// Distances from the value to the lower and upper end of the 68 % interval; 0 if nothing is known.
    pub reach_68: [f64; 2],
    /// Distances from the value to the lower and upper end of the 95 % interval; 0 if nothing is known.
    pub reach_95: [f64; 2],
}

impl Deviation {
    /// Deviation of the flat surface's friction `mu_flat` at the load with index `load`; zero if its error is not
    /// known.
    pub fn of_flat(load: usize, mu_flat: f64, knowledge: &InputUncertainty) -> Self {
        let friction = knowledge.flat_friction.as_ref().and_then(|all| all.get(load));
        friction.map_or_else(Self::default, |variance| {
            let std = mu_flat * variance.sqrt();
            let (reach_68, reach_95) = ([std; 2], [NORMAL_95 * std; 2]);
            Self { std, parts: vec![(Source::FlatFriction, std)], reach_68, reach_95 }
        })
    }
}

/// Standard deviations and intervals at one load that follow from the errors of the material.
#[derive(Clone, Debug, PartialEq)]
pub struct Deviations {
    /// Deviation of the ratio.
    pub ratio: Deviation,
    /// Deviation of the patterned surface's dynamic friction.
    pub mu: Deviation,
    /// Deviation of the flat surface's dynamic friction.
    pub flat: Deviation,
}

impl Slopes {
    /// Cost of [`Self::new`]: two steady cells for each uncertain input, and five for the second order of the modulus,
    /// two at a time.
    pub fn expense(scene: &Scene, knowledge: &InputUncertainty) -> Expense {
        let Some(pattern) = &scene.pattern else { return Expense::default() };
        let is_known = |variance: f64| variance > 0.0;
        let has_friction = knowledge.flat_friction.iter().flatten().copied().any(is_known);
        let scale = knowledge.scale.as_ref().filter(|scale| is_known(scale.variance));
        let has_law = scene.area_law.as_ref().is_some_and(|law| law.factor_std().is_some());
        let inputs = [has_friction, scale.is_some(), has_law].into_iter().filter(|is_known| *is_known).count();
        let bent = scale.map_or(0, |scale| if scale.is_fitted { 0 } else { 1 + BENT_DEVIATIONS.len() });
        let cells = (2 * inputs + bent) as f64;
        let cell = cell_expense(&steady_cell(scene, pattern));
        let at_once = cells.min(2.0).min(rayon::current_num_threads() as f64);
        Expense {
            core_s: cells * cell.core_s,
            wall_s: cells * cell.core_s / at_once.max(1.0),
            bytes: at_once * cell.bytes,
        }
    }

    /// Computes the slopes of `scene` along the inputs with errors in `knowledge`. The slopes of a flat scene are 0,
    /// because its ratio is always 1.
    pub fn new(scene: &Scene, knowledge: &InputUncertainty) -> Self {
        let has_law_errors = scene.area_law.as_ref().is_some_and(|law| law.factor_std().is_some());
        let count = scene.loads.len();
        let Some(pattern) = &scene.pattern else {
            return Self { by_load: vec![Some([0.0; 3]); count], has_law_errors, bends: Vec::new() };
        };
        let cell = steady_cell(scene, pattern);
        let zeros = vec![0.0; count];
        let friction_step: Vec<f64> = knowledge
            .flat_friction
            .as_ref()
            .map_or_else(|| zeros.clone(), |all| all.iter().map(|v| v.sqrt()).collect());
        let scale_step = knowledge.scale.as_ref().map_or(0.0, |scale| scale.variance.sqrt());
        let law_step = if has_law_errors { 1.0 } else { 0.0 };
        let is_fitted = knowledge.scale.as_ref().is_some_and(|scale| scale.is_fitted);
        let shift = |log: f64| ScaleShift { log, is_fitted };
        // (r(x + s) - r(x - s)) / 2s
        let along = |&(friction, scale, law): &(&[f64], f64, f64)| -> Vec<Option<f64>> {
            if friction.iter().chain([&scale, &law]).all(|step| *step == 0.0) {
                return vec![Some(0.0); count];
            }
            let less: Vec<f64> = friction.iter().map(|step| -step).collect();
            let (above, below) = rayon::join(
                || ratios(&cell, pattern, friction, shift(scale), law),
                || ratios(&cell, pattern, &less, shift(-scale), -law),
            );
            let difference = |load: usize| Some((above.as_ref().ok()?[load]? - below.as_ref().ok()?[load]?) / 2.0);
            (0..count).map(difference).collect()
        };
        let inputs = [(&friction_step[..], 0.0, 0.0), (&zeros, scale_step, 0.0), (&zeros, 0.0, law_step)];
        let differences: Vec<Vec<Option<f64>>> = inputs.par_iter().map(along).collect();
        let slope = |load: usize| {
            let over = |input: usize, step: f64| Some(if step == 0.0 { 0.0 } else { differences[input][load]? / step });
            Some([over(0, friction_step[load])?, over(1, scale_step)?, over(2, law_step)?])
        };
        let modulus = knowledge.scale.as_ref().filter(|scale| !scale.is_fitted && scale.variance > 0.0);
        let bends = modulus.and_then(|scale| bends(&cell, pattern, scale.variance.sqrt())).unwrap_or_default();
        Self { by_load: (0..count).map(slope).collect(), has_law_errors, bends }
    }

    /// Derivatives d ln(ratio) / d ln(E) for modelled `ratios`, one per load, with Young's modulus E; 0 if the error of
    /// the modulus is not known, or the law does not depend on it.
    pub fn modulus_sensitivity(&self, ratios: &[f64], knowledge: &InputUncertainty) -> Vec<f64> {
        let moves = knowledge.scale.as_ref().is_some_and(|scale| !scale.is_fitted);
        let slopes = self.by_load.iter().map(|slope| slope.filter(|_| moves).map_or(0.0, |[_, scale, _]| scale));
        slopes.zip(ratios).map(|(slope, ratio)| slope / ratio).collect()
    }

    /// Deviations at the load with index `load`, for a modelled `ratio` on a flat surface that slides at `mu_flat`;
    /// `None` if the slopes are not known. With a discrepancy in `knowledge`, ratio and friction are multiplied by its
    /// factor.
    pub fn deviations(
        &self,
        load: usize,
        ratio: f64,
        mu_flat: f64,
        knowledge: &InputUncertainty,
    ) -> Option<Deviations> {
        let slope = (*self.by_load.get(load)?)?;
        let known = |values: &Option<Vec<f64>>| values.as_ref().and_then(|all| all.get(load)).copied();
        let friction = known(&knowledge.flat_friction);
        let discrepancy = knowledge.discrepancy.as_ref().and_then(|all| all.get(load));
        let factor = discrepancy.map_or(1.0, |found| found.factor);
        // The discrepancy includes the error of the modulus.
        let scale = knowledge.scale.as_ref().filter(|scale| scale.is_fitted || discrepancy.is_none());
        // c = r F exp(d): F the factor of the discrepancy, d its error
        let [x, m, a] = slope.map(|slope| factor * slope);
        let d = if discrepancy.is_some() { factor * ratio } else { 0.0 };
        // mu = c mu_flat (1 + x), x the relative error of flat friction
        let mu_slope = [mu_flat * (x + factor * ratio), mu_flat * m, mu_flat * a, mu_flat * d];
        // Changes of c at the interval ends of the discrepancy, or at the deviations BENT_DEVIATIONS of the modulus.
        let bent = match discrepancy {
            Some(found) => {
                let ([low, high], [lowest, highest]) = (found.log_reach_68, found.log_reach_95);
                Some([-lowest, -low, high, highest].map(|log| factor * ratio * log.exp_m1()))
            }
            None => self.bends.get(load).copied(),
        };
        let deviation = |[x, m, a, d]: [f64; 4], times: f64| {
            let variances = [
                friction.map(|friction| (Source::FlatFriction, x * x * friction)),
                scale.map(|scale| {
                    let source = if scale.is_fitted { Source::FittedScale } else { Source::Modulus };
                    (source, m * m * scale.variance)
                }),
                self.has_law_errors.then_some((Source::AreaLaw, a * a)),
                discrepancy.map(|found| (Source::Discrepancy, (d * found.log_std).powi(2))),
            ];
            let bent_variance = variances[3].or(variances[1]).map_or(0.0, |(_, own)| own);
            let shared = scale.filter(|_| friction.is_some());
            let shared = shared.and_then(|scale| scale.with_friction.get(load)).copied().unwrap_or(0.0);
            let sum: f64 = variances.iter().flatten().map(|(_, own)| own).sum();
            let variance = (sum + 2.0 * x * m * shared).max(0.0);
            let reach = |bent: Option<[f64; 2]>, normal: f64| {
                let Some(bent) = bent else { return [normal * variance.sqrt(); 2] };
                let others = normal * normal * (variance - bent_variance).max(0.0);
                let side = |sign: f64| bent.iter().map(|change| sign * times * change).fold(0.0, f64::max);
                [-1.0, 1.0].map(|sign| side(sign).powi(2)).map(|square| (square + others).sqrt())
            };
            Deviation {
                std: variance.sqrt(),
                parts: variances.into_iter().flatten().map(|(source, own)| (source, own.sqrt())).collect(),
                reach_68: reach(bent.map(|all| [all[1], all[2]]), 1.0),
                reach_95: reach(bent.map(|all| [all[0], all[3]]), NORMAL_95),
            }
        };
        let flat = Deviation::of_flat(load, mu_flat, knowledge);
        Some(Deviations { ratio: deviation([x, m, a, d], 1.0), mu: deviation(mu_slope, mu_flat), flat })
    }
}

/// Scene of the steady cell of `scene`; in three dimensions with blocks twice as large if possible, which hardly
/// changes slopes.
pub(super) fn steady_cell(scene: &Scene, pattern: &Pattern) -> Scene {
    const COARSER: usize = 2;
    const MIN_BLOCKS: f64 = 4.0;
    let run = RunOptions {
        fidelity: Fidelity::Steady,
        extent: Extent::Cell,
        dimensions: Some(scene.dimension().number()),
        liftoff: scene.run.liftoff,
        ..RunOptions::default()
    };
    let mut cell = Scene { run, ..scene.clone() };
    let block_m = COARSER as f64 * scene.layer.block_m;
    let is_wide = pattern.cell_m().iter().chain([&pattern.width_m()]).all(|side_m| *side_m >= MIN_BLOCKS * block_m);
    if !cell.dimension().is_cheap_per_design() && scene.layer.rows().is_multiple_of(COARSER) && is_wide {
        cell.layer.block_m = block_m;
        // A cell does not depend on the specimen, so that any whole number of blocks is valid.
        cell.layer.length_m = cell.layer.height_m;
    }
    cell
}

/// Factor on the pressures of an area law.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ScaleShift {
    /// Logarithm of the factor.
    pub log: f64,
    /// Whether the factor is that of a fitted scale; otherwise it is that of Young's modulus, which also affects rims.
    pub is_fitted: bool,
}

impl ScaleShift {
    /// Shift for a normally distributed `deviation` with mean 0: the logarithm of the scale if it `is_fitted`,
    /// otherwise the relative error of Young's modulus. The modulus itself is normally distributed, E = E_0 (1 + x);
    /// below half of E_0 its logarithm is replaced by the tangent, so that the modulus stays positive.
    pub fn off_by(deviation: f64, is_fitted: bool) -> Self {
        let log = if is_fitted {
            deviation
        } else if deviation > MIN_LOG_MODULUS_ERROR {
            deviation.ln_1p()
        } else {
            // ln(1 + a) + (x - a)/(1 + a)
            MIN_LOG_MODULUS_ERROR.ln_1p() + (deviation - MIN_LOG_MODULUS_ERROR) / (1.0 + MIN_LOG_MODULUS_ERROR)
        };
        Self { log, is_fitted }
    }
}

/// Shifts the inputs of `scene`: flat friction by the relative amounts `friction`, one per load, the pressures of the
/// law by `scale`, and its factors by `law` standard errors. The measured flat friction is kept: mu_d = mu_flat / f(P).
///
/// # Errors
/// [`MaterialError`] if the shifted area law or coefficients are invalid.
pub fn moved(scene: &Scene, friction: &[f64], scale: ScaleShift, law: f64) -> Result<Scene, MaterialError> {
    let area_law =
        scene.area_law.as_ref().map(|own| own.with_factors_off_by(law).at_modulus(scale.log.exp())).transpose()?;
    let elastic = if scale.is_fitted { scene.elastic } else { scene.elastic.at_modulus(scale.log.exp())? };
    with_law(Scene { elastic, ..scene.clone() }, area_law, friction)
}

/// `scene` with the area law `law` in place of its own, and flat friction larger by the shares `friction`, one per load.
pub(super) fn with_law(scene: Scene, law: Option<AreaLaw>, friction: &[f64]) -> Result<Scene, MaterialError> {
    let factor = |law: &Option<AreaLaw>, load: &Load| law.as_ref().map_or(1.0, |law| law.factor(load.pressure_pa));
    let each = scene.loads.iter().zip(friction).map(|(load, by)| {
        let times = (1.0 + by) * factor(&scene.area_law, load) / factor(&law, load);
        let own = &load.friction;
        let friction = LocalFriction::new(own.static_mean() * times, own.dynamic_mean() * times, own.relative_std())?;
        Ok(Load { friction, ..*load })
    });
    let loads = each.collect::<Result<Vec<Load>, MaterialError>>()?;
    Ok(Scene { area_law: law, loads, ..scene })
}

/// Changes of the steady ratios of `pattern`, one list per load, for deviations [`BENT_DEVIATIONS`] of Young's modulus
/// with the relative error `relative_std`; `None` if a ratio cannot be computed.
fn bends(cell: &Scene, pattern: &Pattern, relative_std: f64) -> Option<Vec<[f64; 4]>> {
    let zeros = vec![0.0; cell.loads.len()];
    let at = |reach: f64| -> Option<Vec<f64>> {
        let scale = ScaleShift::off_by(reach * relative_std, false);
        ratios(cell, pattern, &zeros, scale, 0.0).ok()?.into_iter().collect()
    };
    let [low, lower, higher, high] = BENT_DEVIATIONS;
    let ((own, (far_below, below)), (above, far_above)) =
        rayon::join(|| (at(0.0), (at(low), at(lower))), || (at(higher), at(high)));
    let (own, all) = (own?, [far_below?, below?, above?, far_above?]);
    Some((0..own.len()).map(|load| [0, 1, 2, 3].map(|place| all[place][load] - own[load])).collect())
}

/// Steady ratios of `pattern` in `cell` with inputs shifted as by [`moved`], one per load; `None` for a load without a
/// solution.
fn ratios(
    cell: &Scene,
    pattern: &Pattern,
    friction: &[f64],
    scale: ScaleShift,
    law: f64,
) -> Result<Vec<Option<f64>>, MaterialError> {
    Ok(SteadyCell::new(&moved(cell, friction, scale, law)?).ratios(pattern))
}

#[cfg(test)]
mod tests;
