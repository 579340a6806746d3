//! Standard deviations to first order: slopes of the steady ratio, times what is known of each number. Along Young's
//! modulus, which is known to a fifth, the ratio bends: intervals rest on solves at one and at 1.96 standard deviations
//! of it each way, and reach farther to one side than to the other.

use slipgrid_material::{AreaLaw, LocalFriction, MaterialError};
use slipgrid_pattern::Pattern;
use slipgrid_springblock::{Extent, Fidelity, Load, RunOptions, Scene, SteadyCell};

use super::{InputUncertainty, Source};

/// Slopes of the steady ratio at one load; zero along what nothing is known of.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Slope {
    /// Along the relative error of flat friction.
    friction: f64,
    /// Along the logarithm of Young's modulus, or of the fitted scale.
    scale: f64,
    /// Along the area law's factors, all off by so many standard errors.
    law: f64,
}

/// How the ratio of a scene's pattern follows what is not known exactly: central differences over a standard deviation
/// each way, by the steady cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Slopes {
    /// One per load; `None` where a neighbour cannot be computed.
    by_load: Vec<Option<Slope>>,
    has_law_errors: bool,
    /// Changes of the ratio where Young's modulus is off by [`REACHES`], one list per load; empty where nothing is known of it
    /// or a neighbour cannot be computed.
    bends: Vec<[f64; 4]>,
}

/// Standard deviations of the modulus at which intervals are solved: those of 68 and of 95 % each way.
const REACHES: [f64; 4] = [-NORMAL_95, -1.0, 1.0, NORMAL_95];
/// The 97.5 % point of the normal distribution.
pub const NORMAL_95: f64 = 1.959_964;
/// The relative error of Young's modulus below which the logarithm goes on straight: a modulus stays positive.
const LOWEST_MODULUS_ERROR: f64 = -0.5;

/// A standard deviation with the parts that make it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Deviation {
    /// All parts together, with what they share.
    pub std: f64,
    /// What each source alone would make of it.
    pub parts: Vec<(Source, f64)>,
    /// How far the 68 % interval reaches below and above the value; 0 where nothing is known.
    pub reach_68: [f64; 2],
    /// The same of the 95 % interval.
    pub reach_95: [f64; 2],
}

impl Deviation {
    /// What is not known of the flat surface's friction `mu_flat` at load number `load`, whatever a pattern does.
    #[must_use]
    pub fn of_flat(load: usize, mu_flat: f64, knowledge: &InputUncertainty) -> Self {
        let friction = knowledge.flat_friction.as_ref().and_then(|all| all.get(load));
        friction.map_or_else(Self::default, |variance| {
            let std = mu_flat * variance.sqrt();
            let (reach_68, reach_95) = ([std; 2], [NORMAL_95 * std; 2]);
            Self { std, parts: vec![(Source::FlatFriction, std)], reach_68, reach_95 }
        })
    }
}

/// What the material leaves open at one load.
#[derive(Clone, Debug, PartialEq)]
pub struct Deviations {
    /// Of the ratio.
    pub ratio: Deviation,
    /// Of dynamic friction.
    pub mu: Deviation,
    /// Of the flat surface's dynamic friction.
    pub flat: Deviation,
}

impl Slopes {
    /// The slopes of `scene` along what `knowledge` has errors of. A flat scene has a ratio of 1 whatever happens.
    #[must_use]
    pub fn new(scene: &Scene, knowledge: &InputUncertainty) -> Self {
        let has_law_errors = scene.area_law.as_ref().is_some_and(|law| law.factor_std().is_some());
        let count = scene.loads.len();
        let Some(pattern) = &scene.pattern else {
            return Self { by_load: vec![Some(Slope::default()); count], has_law_errors, bends: Vec::new() };
        };
        let cell = steady_cell(scene, pattern);
        let still = vec![0.0; count];
        let friction_step: Vec<f64> = knowledge
            .flat_friction
            .as_ref()
            .map_or_else(|| still.clone(), |all| all.iter().map(|v| v.sqrt()).collect());
        let scale_step = knowledge.scale.as_ref().map_or(0.0, |scale| scale.variance.sqrt());
        let law_step = if has_law_errors { 1.0 } else { 0.0 };
        let is_fitted = knowledge.scale.as_ref().is_some_and(|scale| scale.is_fitted);
        let shift = |log: f64| ScaleShift { log, is_fitted };
        // (r(x + s) - r(x - s)) / 2s
        let along = |friction: &[f64], scale: f64, law: f64| -> Vec<Option<f64>> {
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
        let over = |difference: Option<f64>, step: f64| Some(if step == 0.0 { 0.0 } else { difference? / step });
        let (friction, (scale, law)) = rayon::join(
            || along(&friction_step, 0.0, 0.0),
            || rayon::join(|| along(&still, scale_step, 0.0), || along(&still, 0.0, law_step)),
        );
        let slope = |load: usize| {
            Some(Slope {
                friction: over(friction[load], friction_step[load])?,
                scale: over(scale[load], scale_step)?,
                law: over(law[load], law_step)?,
            })
        };
        let modulus = knowledge.scale.as_ref().filter(|scale| !scale.is_fitted && scale.variance > 0.0);
        let bends = modulus.and_then(|scale| bends(&cell, pattern, scale.variance.sqrt())).unwrap_or_default();
        Self { by_load: (0..count).map(slope).collect(), has_law_errors, bends }
    }

    /// g = d ln r / d ln E of modelled `ratios`, one a load: 0 where nothing is known of the modulus, or it moves nothing.
    #[must_use]
    pub fn modulus_sensitivity(&self, ratios: &[f64], knowledge: &InputUncertainty) -> Vec<f64> {
        let moves = knowledge.scale.as_ref().is_some_and(|scale| !scale.is_fitted);
        let slopes = self.by_load.iter().map(|slope| slope.filter(|_| moves).map_or(0.0, |slope| slope.scale));
        slopes.zip(ratios).map(|(slope, ratio)| slope / ratio).collect()
    }

    /// Standard deviations at load number `load`, where the model gives `ratio` to a flat surface that slides at
    /// `mu_flat`; `None` where the slopes are not known. With a discrepancy in `knowledge`, those of ratio and friction
    /// times its factor.
    #[must_use]
    pub fn deviations(
        &self,
        load: usize,
        ratio: f64,
        mu_flat: f64,
        knowledge: &InputUncertainty,
    ) -> Option<Deviations> {
        let slope = (*self.by_load.get(load)?)?;
        let known = |of: &Option<Vec<f64>>| of.as_ref().and_then(|all| all.get(load)).copied();
        let friction = known(&knowledge.flat_friction);
        let discrepancy = knowledge.discrepancy.as_ref().and_then(|all| all.get(load));
        let factor = discrepancy.map_or(1.0, |found| found.factor);
        // What is not known of the modulus is in the discrepancy.
        let scale = knowledge.scale.as_ref().filter(|scale| scale.is_fitted || discrepancy.is_none());
        // c = r F exp(d): F the factor, d its own error
        let ratio_slope = [
            factor * slope.friction,
            factor * slope.scale,
            factor * slope.law,
            if discrepancy.is_some() { factor * ratio } else { 0.0 },
        ];
        // mu = c mu_flat (1 + x), x the relative error of flat friction
        let [x, m, a, d] = ratio_slope;
        let mu_slope = [mu_flat * (x + factor * ratio), mu_flat * m, mu_flat * a, mu_flat * d];
        // Changes of c where the discrepancy lies at the ends of its intervals, or where the modulus is off by REACHES.
        let bent = match discrepancy {
            Some(found) => {
                let ([low, high], [lowest, highest]) = (found.log_reach_68, found.log_reach_95);
                Some([-lowest, -low, high, highest].map(|log| factor * ratio * log.exp_m1()))
            }
            None => self.bends.get(load).copied(),
        };
        let deviation = |[x, m, a, d]: [f64; 4], times: f64| {
            let mut variance = 0.0;
            let mut parts = Vec::new();
            let mut add = |source: Source, own: f64| {
                variance += own;
                parts.push((source, own.sqrt()));
            };
            if let Some(friction) = friction {
                add(Source::FlatFriction, x * x * friction);
            }
            if let Some(scale) = scale {
                add(if scale.is_fitted { Source::FittedScale } else { Source::Modulus }, m * m * scale.variance);
            }
            if self.has_law_errors {
                add(Source::AreaLaw, a * a);
            }
            if let Some(found) = discrepancy {
                add(Source::Discrepancy, (d * found.log_std).powi(2));
            }
            let shared = scale.filter(|_| friction.is_some());
            let shared = shared.and_then(|scale| scale.with_friction.get(load)).copied().unwrap_or(0.0);
            let variance = (variance + 2.0 * x * m * shared).max(0.0);
            let of_bent = match discrepancy {
                Some(found) => (d * found.log_std).powi(2),
                None => scale.map_or(0.0, |scale| m * m * scale.variance),
            };
            let reach = |bent: Option<[f64; 2]>, normal: f64| {
                let Some(bent) = bent else { return [normal * variance.sqrt(); 2] };
                let others = normal * normal * (variance - of_bent).max(0.0);
                let side = |sign: f64| bent.iter().map(|change| sign * times * change).fold(0.0, f64::max);
                [-1.0, 1.0].map(|sign| side(sign).powi(2)).map(|square| (square + others).sqrt())
            };
            Deviation {
                std: variance.sqrt(),
                parts,
                reach_68: reach(bent.map(|all| [all[1], all[2]]), 1.0),
                reach_95: reach(bent.map(|all| [all[0], all[3]]), NORMAL_95),
            }
        };
        let flat = Deviation::of_flat(load, mu_flat, knowledge);
        Some(Deviations { ratio: deviation(ratio_slope, 1.0), mu: deviation(mu_slope, mu_flat), flat })
    }
}

/// The steady cell of `scene`: in space in blocks twice as large where that can be had, which slopes do not see.
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
        // A cell knows no specimen: any whole number of blocks does.
        cell.layer.length_m = cell.layer.height_m;
    }
    cell
}

/// By how much the pressures of an area law are larger.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ScaleShift {
    /// Its logarithm.
    pub log: f64,
    /// The scale was fitted; otherwise it is Young's modulus, which resists rims as well.
    pub is_fitted: bool,
}

impl ScaleShift {
    /// Where what is known is off by `deviation`, which has a normal distribution about 0: the logarithm of a scale that
    /// `is_fitted`, or Young's modulus over itself. What is measured of the modulus is the modulus, not its logarithm:
    /// E = E_0 (1 + x), and below half of E_0 the tangent of ln E there, so that no draw is negative.
    #[must_use]
    pub fn off_by(deviation: f64, is_fitted: bool) -> Self {
        let log = if is_fitted {
            deviation
        } else if deviation > LOWEST_MODULUS_ERROR {
            deviation.ln_1p()
        } else {
            // ln(1 + a) + (x - a)/(1 + a)
            LOWEST_MODULUS_ERROR.ln_1p() + (deviation - LOWEST_MODULUS_ERROR) / (1.0 + LOWEST_MODULUS_ERROR)
        };
        Self { log, is_fitted }
    }
}

/// `scene` where flat friction is larger by the shares `friction`, one per load, the law's pressures by `scale` and its factors
/// by `law` standard errors. Flat friction was measured: mu_d = mu_flat / f(P), whatever the law says.
///
/// # Errors
/// [`MaterialError`] where that leaves no area law or no coefficients.
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

/// Changes of the steady ratios of `pattern` where Young's modulus, known to `relative_std`, is off by [`REACHES`]; `None` where
/// one cannot be computed.
fn bends(cell: &Scene, pattern: &Pattern, relative_std: f64) -> Option<Vec<[f64; 4]>> {
    let still = vec![0.0; cell.loads.len()];
    let at = |reach: f64| -> Option<Vec<f64>> {
        let scale = ScaleShift::off_by(reach * relative_std, false);
        ratios(cell, pattern, &still, scale, 0.0).ok()?.into_iter().collect()
    };
    let [low, lower, higher, high] = REACHES;
    let ((own, (far_below, below)), (above, far_above)) =
        rayon::join(|| (at(0.0), (at(low), at(lower))), || (at(higher), at(high)));
    let (own, all) = (own?, [far_below?, below?, above?, far_above?]);
    Some((0..own.len()).map(|load| [0, 1, 2, 3].map(|place| all[place][load] - own[load])).collect())
}

/// Steady ratios of `pattern` in the cell that is moved so.
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
