//! Simulated laboratory: true ratios of its samples, and their measurement.

use slipgrid_base::statistics::Normals;
use slipgrid_infer::discrepancy::{DimensionShift, Features, Form, Hyperparameters, Measured, Trial};

use super::physics::{LOADS, PRESSURES_PA, Solved, loads};

/// Relative standard deviation of Young's modulus, that of the published polymer.
pub const MODULUS_STD: f64 = 0.21;
/// Standard deviation of the logarithm of the ratio between samples of the same texture.
pub const SAMPLE_STD: f64 = 0.005;
/// Standard deviation of the logarithm of the ratio by the dimensions of a sample, relative to this logarithm.
pub const DIMENSIONS_STD: f64 = 0.03;
/// Error of the flat sample's measurement relative to that of a patterned sample.
pub const FLAT_SHARE: f64 = 0.5;
/// Maximum deviation of the logarithm of Young's modulus, so that solved textures are not extrapolated too far.
pub const MAX_LOG_MODULUS: f64 = 0.5;
/// Standard deviation of a mechanism's changes with pressure, relative to its size.
pub const SLOPE_SHARE: f64 = 0.3;
/// Half the band of ratios that a target accepts.
pub const TOLERANCE: f64 = 0.02;

/// Mechanism of the true discrepancy, unknown to every model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mechanism {
    /// Proportional to the areal density; inside the family of forms.
    Density,
    /// Proportional to the edge length; inside the family of forms.
    Edge,
    /// Saturating with the density; inside the family of forms.
    Saturating,
    /// Dependent on depth and density; inside the family of forms.
    Depth,
    /// The square root of density times edge length: between two forms.
    Root,
    /// Rims that the model leaves out.
    Rims,
    /// Like the density, but up to three times as large at pitches near 300 um.
    Bump,
    /// Proportional to the density, with rising friction.
    Opposite,
    /// No discrepancy: the model is exact.
    None,
}

impl Mechanism {
    /// All mechanisms.
    pub const ALL: [Self; 9] = [
        Self::Density,
        Self::Edge,
        Self::Saturating,
        Self::Depth,
        Self::Root,
        Self::Rims,
        Self::Bump,
        Self::Opposite,
        Self::None,
    ];

    /// Name of the mechanism in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Density => "density",
            Self::Edge => "edge length",
            Self::Saturating => "saturating",
            Self::Depth => "depth",
            Self::Root => "sqrt(density x edge)",
            Self::Rims => "rims left out",
            Self::Bump => "bump in pitch",
            Self::Opposite => "opposite sign",
            Self::None => "none",
        }
    }

    /// Whether the mechanism is one of the mixture's forms.
    pub const fn is_inside(self) -> bool {
        matches!(self, Self::Density | Self::Edge | Self::Saturating | Self::Depth)
    }

    /// Range of the uniformly distributed size: start and signed width.
    pub const fn sizes(self) -> [f64; 2] {
        match self {
            Self::Opposite => [0.02, 0.08],
            Self::Bump => [-0.02, -0.08],
            _ => [-0.03, -0.2],
        }
    }

    /// Equally probable forms of a mechanism with a scale; for other mechanisms only the first is used, without
    /// meaning.
    pub fn scales(self) -> [Form; 4] {
        match self {
            Self::Depth => [2e-6, 5e-6, 10e-6, 20e-6].map(|scale_m| Form::DepthDensity { scale_m }),
            _ => [0.02, 0.04, 0.08, 0.16].map(|scale| Form::Saturating { scale }),
        }
    }

    /// Value of the mechanism at a texture, 1 at the reference texture; 0 for rims. `scale` is the form of a mechanism
    /// with a scale.
    pub fn value(self, of: &Features, scale: Form) -> f64 {
        let of_form = |form: Form| form.value(of) / form.value(&Hyperparameters::default().reference);
        match self {
            Self::Density | Self::Opposite => of_form(Form::Density),
            Self::Edge => of_form(Form::Edge),
            Self::Saturating | Self::Depth => of_form(scale),
            Self::Root => (of_form(Form::Density) * of_form(Form::Edge)).sqrt(),
            Self::Bump => {
                let away = (of.pitch_m / 300e-6).ln() / 0.3;
                of_form(Form::Density) * (1.0 + 2.0 * (-0.5 * away * away).exp())
            }
            Self::Rims | Self::None => 0.0,
        }
    }
}

/// Size of a mechanism at each load: `size` at the middle pressures, with the changes `beta` linear in pressure and
/// `gamma` linear in its inverse.
pub fn amplitude(size: f64, beta: f64, gamma: f64) -> [f64; LOADS] {
    PRESSURES_PA
        .map(|pressure_pa| size + beta * (pressure_pa - 1.5e6) / 1.5e6 + gamma * (PRESSURES_PA[0] / pressure_pa - 0.5))
}

/// Laboratory with its hidden truth.
#[derive(Clone, Debug)]
pub struct Laboratory {
    mechanism: Mechanism,
    /// Form of a mechanism with a scale.
    scale: Form,
    log_modulus: f64,
    amplitude: [f64; LOADS],
    /// Relative standard error of one measurement.
    pub noise: f64,
    /// Errors of the flat sample's logarithms at each load, shared by all ratios; it was measured four times as often.
    flat: [f64; LOADS],
    normals: Normals,
}

/// Cut sample with its true ratios and its trial.
#[derive(Clone, Debug)]
pub struct Cut {
    /// True ratio at each load.
    pub truth: [f64; LOADS],
    /// Trial with the measurements.
    pub trial: Trial,
}

impl Laboratory {
    /// Creates laboratory `number` of the study with this `seed`.
    pub fn new(mechanism: Mechanism, number: usize, seed: u64) -> Self {
        // A stream of its own for every laboratory: a multiple of a large odd number.
        let mut normals = Normals::new(seed.wrapping_add((number as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15)));
        let uniform = |normals: &mut Normals| slipgrid_base::statistics::normal_probability(normals.draw());
        let [from, by] = mechanism.sizes();
        let size = from + by * uniform(&mut normals);
        let (beta, gamma) = (SLOPE_SHARE * size * normals.draw(), SLOPE_SHARE * size * normals.draw());
        let amplitude = amplitude(size, beta, gamma);
        let noise = 0.005 * 4_f64.powf(uniform(&mut normals));
        let log_modulus = (MODULUS_STD * normals.draw()).clamp(-MAX_LOG_MODULUS, MAX_LOG_MODULUS);
        let flat = [0; LOADS].map(|_| FLAT_SHARE * noise * normals.draw());
        // One of the family's four scales.
        let place = ((4.0 * uniform(&mut normals)) as usize).min(3);
        let scale = mechanism.scales()[place];
        Self { mechanism, scale, log_modulus, amplitude, noise, flat, normals }
    }

    /// Form of the mechanism, if it belongs to the family.
    pub fn form(&self) -> Option<Form> {
        match self.mechanism {
            Mechanism::Density => Some(Form::Density),
            Mechanism::Edge => Some(Form::Edge),
            Mechanism::Saturating | Mechanism::Depth => Some(self.scale),
            _ => None,
        }
    }

    /// Logarithm of the true ratio of a texture as designed.
    fn log_truth(&self, of: &Solved) -> [f64; LOADS] {
        let value = self.mechanism.value(&of.features, self.scale);
        of.physics.log_truth(self.log_modulus, (value, &self.amplitude), self.mechanism == Mechanism::Rims)
    }

    /// True ratios of a texture as designed.
    pub fn truth(&self, of: &Solved) -> [f64; LOADS] {
        self.log_truth(of).map(f64::exp)
    }

    /// Cuts a sample of the texture `of` and measures it.
    pub fn cut(&mut self, of: &Solved) -> Cut {
        let own = SAMPLE_STD * self.normals.draw();
        let more = 1.0 + DIMENSIONS_STD * self.normals.draw();
        let truth = self.log_truth(of).map(|log| (more * log + own).exp());
        let mut measured = Vec::new();
        for (load, at) in loads().into_iter().enumerate() {
            let error = self.noise * self.normals.draw() - self.flat[load];
            measured.push(Measured {
                load: at,
                measured: truth[load] * error.exp(),
                modelled: of.ratio[load],
                patterned_std: self.noise,
                flat_std: FLAT_SHARE * self.noise,
                sensitivity: of.sensitivity[load],
            });
        }
        // In proportion to the whole effect, measured and not modelled: the discrepancy moves with it.
        let log_ratio = measured.iter().map(|at| DIMENSIONS_STD * at.measured.ln()).collect();
        let dimension_shifts = vec![DimensionShift { log_ratio, above: of.features, below: None }];
        let trial = Trial {
            name: String::new(),
            features: of.features,
            sample_std: None,
            disc: None,
            measured,
            dimensions_std_m: [0.0; 3],
            dimension_shifts,
        };
        Cut { truth, trial }
    }
}

/// Lower and upper limits of ratios within `distance` of `target`.
pub fn around(target: &[f64; LOADS], distance: f64) -> [[f64; LOADS]; 2] {
    [-distance, distance].map(|distance| target.map(|ratio| ratio + distance))
}

/// Whether every value is within its limits.
pub fn is_within(values: &[f64; LOADS], [lower, upper]: &[[f64; LOADS]; 2]) -> bool {
    (0..LOADS).all(|load| (lower[load]..=upper[load]).contains(&values[load]))
}

/// Errors of the dimensions of a sample with the features `of` and ratios near `ratio`.
pub fn dimension_shifts(of: Features, ratio: &[f64; LOADS]) -> Vec<DimensionShift> {
    let log_ratio = ratio.iter().map(|ratio| DIMENSIONS_STD * ratio.ln()).collect();
    vec![DimensionShift { log_ratio, above: of, below: None }]
}
