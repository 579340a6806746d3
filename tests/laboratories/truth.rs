//! A laboratory: what its samples truly do, and what it measures of them.

use slipgrid_discrepancy::{DimensionShift, Features, Form, Hyperparameters, Measured, Trial};
use slipgrid_statistics::Normals;

use super::physics::{LOADS, PRESSURES_PA, Solved, loads};

/// Relative error of Young's modulus, as of the published polymer.
pub const MODULUS_STD: f64 = 0.21;
/// From one sample to the next of the same texture.
pub const SAMPLE_STD: f64 = 0.005;
/// Relative scatter of what a texture does, by its dimensions.
pub const DIMENSIONS_STD: f64 = 0.03;
/// Error of the flat sample's measurement over that of a patterned one.
pub const FLAT_SHARE: f64 = 0.5;
/// Young's modulus is off by no more than this: what the textures were solved for is not stretched further.
pub const MAX_LOG_MODULUS: f64 = 0.5;
/// Standard deviation of a mechanism's change with pressure over its size.
pub const SLOPE_SHARE: f64 = 0.3;
/// Half the band of ratios that a target accepts.
pub const TOLERANCE: f64 = 0.02;

/// What no model knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mechanism {
    /// Inside the family of forms.
    Density,
    /// Inside.
    Edge,
    /// Inside.
    Saturating,
    /// Inside.
    Depth,
    /// The square root of density times edge length: between two forms.
    Root,
    /// Rims, which the model leaves out.
    Rims,
    /// As the density, up to three times as much at pitches about 300 um.
    Bump,
    /// Friction rises with the density.
    Opposite,
    /// The physics is right.
    None,
}

impl Mechanism {
    /// All of them.
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

    /// Its name.
    #[must_use]
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

    /// Whether one of the mixture's forms is it.
    #[must_use]
    pub const fn is_inside(self) -> bool {
        matches!(self, Self::Density | Self::Edge | Self::Saturating | Self::Depth)
    }

    /// Its size is uniform from the first by as much as the second.
    pub const fn sizes(self) -> [f64; 2] {
        match self {
            Self::Opposite => [0.02, 0.08],
            Self::Bump => [-0.02, -0.08],
            _ => [-0.03, -0.2],
        }
    }

    /// The forms that it may be, alike likely, where it has a scale. Of others the first says nothing.
    pub fn scales(self) -> [Form; 4] {
        match self {
            Self::Depth => [2e-6, 5e-6, 10e-6, 20e-6].map(|scale_m| Form::DepthDensity { scale_m }),
            _ => [0.02, 0.04, 0.08, 0.16].map(|scale| Form::Saturating { scale }),
        }
    }

    /// How it grows with the texture, 1 at the reference; of rims nothing. `scale` is the form where it has a scale.
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

/// Size of a mechanism at each load: `size` at the middle pressures, and how it changes from there.
pub fn amplitude(size: f64, beta: f64, gamma: f64) -> [f64; LOADS] {
    PRESSURES_PA
        .map(|pressure_pa| size + beta * (pressure_pa - 1.5e6) / 1.5e6 + gamma * (PRESSURES_PA[0] / pressure_pa - 0.5))
}

/// A laboratory with its hidden truth.
#[derive(Clone, Debug)]
pub struct Laboratory {
    mechanism: Mechanism,
    /// The form of a mechanism that has a scale.
    scale: Form,
    log_modulus: f64,
    amplitude: [f64; LOADS],
    /// Standard error of one measurement over itself.
    pub noise: f64,
    /// The flat sample's error at each load, which all its ratios share: it was measured four times as often.
    flat: [f64; LOADS],
    normals: Normals,
}

/// What a cut sample truly does, and the trial that the laboratory makes of it.
#[derive(Clone, Debug)]
pub struct Cut {
    /// Its true ratio at each load.
    pub truth: [f64; LOADS],
    /// What was measured.
    pub trial: Trial,
}

impl Laboratory {
    /// Number `number` of those of a study with this `seed`.
    pub fn new(mechanism: Mechanism, number: usize, seed: u64) -> Self {
        // A stream of its own for every laboratory: a multiple of a large odd number.
        let mut normals = Normals::new(seed.wrapping_add((number as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15)));
        let uniform = |normals: &mut Normals| slipgrid_statistics::normal_probability(normals.draw());
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

    /// The form of its mechanism, where that is one of the family.
    pub fn form(&self) -> Option<Form> {
        match self.mechanism {
            Mechanism::Density => Some(Form::Density),
            Mechanism::Edge => Some(Form::Edge),
            Mechanism::Saturating | Mechanism::Depth => Some(self.scale),
            _ => None,
        }
    }

    /// Logarithm of the true ratio of a texture, as it was designed.
    fn log_truth(&self, of: &Solved) -> [f64; LOADS] {
        let value = self.mechanism.value(&of.features, self.scale);
        of.physics.log_truth(self.log_modulus, (value, &self.amplitude), self.mechanism == Mechanism::Rims)
    }

    /// True ratios of a texture, as it was designed.
    pub fn truth(&self, of: &Solved) -> [f64; LOADS] {
        self.log_truth(of).map(f64::exp)
    }

    /// Cuts a sample of `of` and measures it.
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

/// Error of the dimensions of a sample with the features `of`, whose ratio is about `ratio`.
pub fn dimension_shifts(of: Features, ratio: &[f64; LOADS]) -> Vec<DimensionShift> {
    let log_ratio = ratio.iter().map(|ratio| DIMENSIONS_STD * ratio.ln()).collect();
    vec![DimensionShift { log_ratio, above: of, below: None }]
}
