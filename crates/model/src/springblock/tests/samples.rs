//! Test fixtures: the published polymer, patterns and scenes of it, and a measure of the smoothness of a sequence.

use crate::material::{AreaLaw, Elastic, LocalFriction};
use crate::pattern::{Pattern, Planform, Rim, RimProfile, Texture};

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

use crate::springblock::{Coefficients, Face, Fidelity, Layer, Load, RunOptions, Scene, Simulation, Strip, draws};

pub const E_PA: f64 = 0.38e9;

pub fn elastic() -> Elastic {
    Elastic::new(E_PA, 900.0).unwrap()
}

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

/// Pattern with flat lands but for rims `rim_um` wide; all lengths in micrometres.
pub fn rimmed(
    planform: Planform,
    [width_um, spacing_um, depth_um]: [f64; 3],
    height_um: f64,
    rim_um: f64,
    profile: RimProfile,
) -> Pattern {
    let rim = Rim::new(height_um * 1e-6, rim_um * 1e-6, profile).unwrap();
    pattern(Texture::new(planform).with_rim(rim), width_um, spacing_um, depth_um)
}

/// Options of a dynamic run that starts from sliding and travels `sliding_m`, in metres.
pub fn in_time(sliding_m: f64) -> RunOptions {
    RunOptions { fidelity: Fidelity::Dynamic, sliding_m, warm_start: true, ..RunOptions::default() }
}

/// Face of `strips` with their own cavity fraction.
pub fn face(strips: Vec<Strip>) -> Face {
    let area = |length_m: fn(&Strip) -> f64| strips.iter().map(|strip| strip.width_m * length_m(strip)).sum::<f64>();
    let share = area(Strip::cavity_length_m) / area(|strip| strip.length_m);
    Face::new(strips, share).unwrap()
}

/// Friction ratios of `simulation` by load.
pub fn ratios(simulation: &Simulation) -> Vec<f64> {
    simulation.loads.iter().map(|load| load.ratio().unwrap()).collect()
}

/// Whether a statement of `simulation` contains `words`.
pub fn says(simulation: &Simulation, words: &str) -> bool {
    let statements = &simulation.statements;
    statements.model.iter().chain(&statements.method).any(|statement| statement.contains(words))
}

/// A fixed sequence of numbers in [0, 1).
pub fn uniform(seed: u64) -> impl FnMut() -> f64 {
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    move || (generator.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
}

/// Slope of the straight line through `points` by least squares.
pub fn slope(points: &[[f64; 2]]) -> f64 {
    let mean = [0, 1].map(|axis| points.iter().map(|p| p[axis]).sum::<f64>() / points.len() as f64);
    let moment = |axis: usize| points.iter().map(|p| (p[0] - mean[0]) * (p[axis] - mean[axis])).sum::<f64>();
    moment(1) / moment(0)
}

/// Scene of `pattern` under [`persson_law`] in a layer of 9960 x 200 um with blocks of 10 um.
pub fn scene(pattern: Pattern, pressures_mpa: &[f64], run: RunOptions) -> Scene {
    let load = |pressure_mpa: &f64| Load { pressure_pa: pressure_mpa * 1e6, friction: friction() };
    Scene {
        elastic: elastic(),
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
