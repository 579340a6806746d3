//! Textures that the simulated laboratories may cut, solved by the steady model.

use rayon::prelude::*;
use slipgrid_infer::calibrate::uncertainty::{ScaleShift, moved};
use slipgrid_infer::discrepancy::{Features, Load, Sensitivity};
use slipgrid_model::pattern::{Pattern, Planform, Rim, RimProfile, Texture};
use slipgrid_model::springblock::{Scene, SteadyCell};

use slipgrid_io::Failure;
use slipgrid_validate::accuracy::paper_scene;

/// Nominal pressures, in pascals.
pub const PRESSURES_PA: [f64; 4] = [0.65e6, 1.3e6, 1.95e6, 2.6e6];
/// Loads of every trial.
pub const LOADS: usize = PRESSURES_PA.len();
/// Logarithms of Young's modulus over its expected value at which textures are solved.
const LOG_MODULI: [f64; 3] = [-0.2, 0.0, 0.2];
/// Height of rims, in metres, for the mechanism of rims that the model leaves out.
const RIM_HEIGHT_M: f64 = 0.3e-6;
const RIM_WIDTH_M: f64 = 20e-6;
/// Block size for squares, in metres; coarse, which suffices for a comparison.
const SQUARE_BLOCK_M: f64 = 20e-6;

/// Texture with its modelled ratios.
#[derive(Clone, Debug)]
pub struct Solved {
    /// Width, spacing and depth.
    pub pattern: Pattern,
    /// Features on which the forms of the discrepancy depend.
    pub features: Features,
    /// Modelled ratio at each load.
    pub ratio: [f64; LOADS],
    /// Sensitivities of the ratio that the discrepancy takes into account, by load.
    pub sensitivity: [Sensitivity; LOADS],
    /// Logarithms of the ratios and their derivatives.
    pub physics: Physics,
}

/// Logarithm of the steady ratio of a texture at each load, with derivatives and the effect of rims.
#[derive(Clone, Copy, Debug)]
pub struct Physics {
    /// ln R.
    pub log: [f64; LOADS],
    /// g = d ln R / d ln E.
    pub slope: [f64; LOADS],
    /// d2 ln R / d (ln E)2.
    pub curvature: [f64; LOADS],
    /// Logarithm of the ratio with rims over that without.
    pub of_rims: [f64; LOADS],
}

impl Physics {
    /// ln R in a laboratory whose logarithm of the modulus is larger by `log_modulus`. The mechanism has this `value`
    /// at the texture and this `amplitude` at each load; rims are included if `has_rims`.
    pub fn log_truth(
        &self,
        log_modulus: f64,
        (value, amplitude): (f64, &[f64; LOADS]),
        has_rims: bool,
    ) -> [f64; LOADS] {
        let (m, rims) = (log_modulus, if has_rims { 1.0 } else { 0.0 });
        std::array::from_fn(|load| {
            self.log[load]
                + m * (self.slope[load] + 0.5 * m * self.curvature[load])
                + value * amplitude[load]
                + rims * self.of_rims[load]
        })
    }
}

/// The loads of every trial.
pub fn loads() -> [Load; LOADS] {
    PRESSURES_PA.map(|pressure_pa| Load { pressure_pa, speed_m_s: 2e-3, humidity: 0.4 })
}

/// Solves grooves with `steps` widths and `steps` spacings in geometric progression at four depths, a third as many
/// squares, and the published squares as the last texture.
///
/// # Errors
/// [`Failure`] if the built-in scene cannot be solved.
pub fn textures(steps: usize) -> Result<Vec<Solved>, Failure> {
    let failed = |error: &dyn std::fmt::Display| Failure::Failed(format!("the built-in scene: {error}"));
    let scene = paper_scene()?;
    let mut loads = Vec::new();
    for pressure_pa in PRESSURES_PA {
        loads.push(slipgrid_model::springblock::Load { pressure_pa, friction: scene.loads[0].friction });
    }
    let scene = Scene { loads, ..scene };
    let squares =
        Scene { layer: slipgrid_model::springblock::Layer { block_m: SQUARE_BLOCK_M, ..scene.layer }, ..scene.clone() };
    let at = |scene: &Scene| -> Result<Vec<Scene>, Failure> {
        LOG_MODULI
            .iter()
            .map(|&log| moved(scene, &[0.0; LOADS], ScaleShift { log, is_fitted: false }, 0.0))
            .collect::<Result<_, _>>()
            .map_err(|error| failed(&error))
    };
    let (grooves, squares) = (at(&scene)?, at(&squares)?);
    let solved = |pattern: &Pattern| solve(pattern, if pattern.is_uniform_along_y() { &grooves } else { &squares });
    Ok(patterns(steps).par_iter().filter_map(solved).collect())
}

fn patterns(steps: usize) -> Vec<Pattern> {
    let span = |from: f64, to: f64, steps: usize| {
        (0..steps).map(move |step| from * (to / from).powf(step as f64 / (steps.max(2) - 1) as f64))
    };
    let mut all = Vec::new();
    for (planform, steps) in [(Planform::Groove, steps), (Planform::Square, steps.div_ceil(3))] {
        for width_um in span(40.0, 400.0, steps) {
            for spacing_um in span(60.0, 1000.0, steps) {
                for depth_um in [5.0, 10.0, 20.0, 40.0] {
                    all.extend(of(planform, width_um.round(), spacing_um.round(), depth_um));
                }
            }
        }
    }
    all.extend(of(Planform::Square, 130.0, 370.0, 5.2));
    all
}

fn of(planform: Planform, width_um: f64, spacing_um: f64, depth_um: f64) -> Option<Pattern> {
    Pattern::new(planform, width_um * 1e-6, spacing_um * 1e-6, depth_um * 1e-6).ok()
}

/// Solves a texture; `None` if a load does not converge or the cavity closes.
fn solve(pattern: &Pattern, scenes: &[Scene]) -> Option<Solved> {
    let ratios = |scene: &Scene, pattern: &Pattern| -> Option<[f64; LOADS]> {
        let outcomes = SteadyCell::new(&Scene { pattern: Some(*pattern), ..scene.clone() }).solve(pattern);
        let ratios: Vec<f64> = outcomes
            .iter()
            .filter(|outcome| outcome.surface.clearance_m.is_none_or(|clearance_m| clearance_m > 0.0))
            .filter_map(|outcome| outcome.ratio)
            .collect();
        ratios.try_into().ok()
    };
    let all: Vec<[f64; LOADS]> = scenes.iter().map(|scene| ratios(scene, pattern)).collect::<Option<_>>()?;
    let log = |place: usize, load: usize| all[place][load].ln();
    let step = LOG_MODULI[2];
    // Rims of squares, which take a finer cell in space, are taken for those of their section, as strips.
    let rim = Rim::new(RIM_HEIGHT_M, RIM_WIDTH_M, RimProfile::Round).ok()?;
    let groove = pattern.as_groove();
    let rimmed = Pattern::new(
        Texture::new(Planform::Groove).with_rim(rim),
        pattern.width_m(),
        pattern.spacing_m(),
        pattern.depth_m(),
    )
    .ok()?;
    let mut section = scenes[1].clone();
    section.layer.block_m = section.layer.block_m.min(0.5 * RIM_WIDTH_M);
    let (with, without) = (ratios(&section, &rimmed)?, ratios(&section, &groove)?);
    let strip = |ratio: f64| pattern.strip_estimate(ratio);
    let slope = std::array::from_fn(|load| (log(2, load) - log(0, load)) / (2.0 * step));
    Some(Solved {
        pattern: *pattern,
        features: Features::from(pattern),
        ratio: all[1],
        // Their flat friction follows the area law.
        sensitivity: slope.map(Sensitivity::of_modulus),
        physics: Physics {
            log: all[1].map(f64::ln),
            slope,
            curvature: std::array::from_fn(|load| (log(2, load) - 2.0 * log(1, load) + log(0, load)) / (step * step)),
            of_rims: std::array::from_fn(|load| (strip(with[load]) / strip(without[load])).ln()),
        },
    })
}
