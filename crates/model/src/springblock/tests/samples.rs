//! Test fixtures: the published polymer, patterns and scenes of it, and a measure of the smoothness of a sequence.

use crate::material::{AreaLaw, Elastic, LocalFriction};
use crate::pattern::{Pattern, Planform, Texture};

use crate::springblock::{Coefficients, Layer, Load, RunOptions, Scene, draws};

pub const E_PA: f64 = 0.38e9;

/// Local coefficients 0.30 and 0.27 with a standard deviation of 5 %.
pub fn friction() -> LocalFriction {
    LocalFriction::new(0.30, 0.27, 0.05).unwrap()
}

/// Draws of [`friction`] for `count` columns.
pub fn coefficients(seed: u64, count: usize) -> Vec<Coefficients> {
    draws::draw(&friction(), seed, count)
}

/// Persson's law for E* h'rms = 4 MPa, A(P) = erf(sqrt(2) P / (E* h'rms)), in a fine table.
pub fn persson_law() -> AreaLaw {
    let pressure_pa: Vec<f64> = (1..=200).map(|step| 0.1e6 * f64::from(step)).collect();
    let area: Vec<f64> = pressure_pa.iter().map(|p| libm::erf(2.0_f64.sqrt() * p / 4e6)).collect();
    AreaLaw::from_area_curve(&pressure_pa, &area, 0.7e6).unwrap()
}

/// Pattern with lengths in micrometres.
pub fn pattern(texture: impl Into<Texture>, width_um: f64, spacing_um: f64, depth_um: f64) -> Pattern {
    Pattern::new(texture, width_um * 1e-6, spacing_um * 1e-6, depth_um * 1e-6).unwrap()
}

/// Pattern of grooves across the sliding direction, lengths in micrometres.
pub fn groove(width_um: f64, spacing_um: f64, depth_um: f64) -> Pattern {
    pattern(Planform::Groove, width_um, spacing_um, depth_um)
}

/// Scene of `pattern` under [`persson_law`] in a layer of 9960 x 200 um with blocks of 10 um.
pub fn scene(pattern: Pattern, pressures_mpa: &[f64], run: RunOptions) -> Scene {
    let load = |pressure_mpa: &f64| Load { pressure_pa: pressure_mpa * 1e6, friction: friction() };
    Scene {
        elastic: Elastic::new(E_PA, 900.0).unwrap(),
        area_law: Some(persson_law()),
        pattern: Some(pattern),
        relief: None,
        layer: Layer { length_m: 9960e-6, height_m: 200e-6, block_m: 10e-6, thickness_m: None, holder: None },
        loads: pressures_mpa.iter().map(load).collect(),
        speed_m_s: 2e-3,
        run,
    }
}

/// Values of f(x) at 0, 1, ..., n.
pub fn sweep(n: usize, f: impl Fn(f64) -> f64) -> Vec<f64> {
    (0..=n).map(|step| f(step as f64)).collect()
}

/// Largest deviation of a step from the mean step, and whether a step has the opposite sign.
pub fn roughness(values: &[f64]) -> (f64, bool) {
    let steps: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let mean = steps.iter().sum::<f64>() / steps.len() as f64;
    let worst = steps.iter().map(|step| (step - mean).abs()).fold(0.0, f64::max);
    (worst, steps.iter().any(|step| step * mean < 0.0))
}
