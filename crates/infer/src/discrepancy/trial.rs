//! Trials: samples that were cut and measured.

use crate::discrepancy::{DiscrepancyError, Features, Form, Load};

/// Sample that was cut and measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// Name of the trial.
    pub name: String,
    /// Features of the texture, as measured or as designed.
    pub features: Features,
    /// Standard deviation of the log ratio over samples of one texture; `None` if not stated, so that the value of the
    /// hyperparameters holds.
    pub sample_std: Option<f64>,
    /// Name of the disc; trials of one disc share one deviation due to scatter. `None` for a separate disc.
    pub disc: Option<String>,
    /// Measurements of the sample.
    pub measured: Vec<Measured>,
    /// Standard errors of width, spacing and depth, in metres; 0 if exact.
    pub dimensions_std_m: [f64; 3],
    /// Independent errors of the dimensions, at the loads of `measured`; empty if the dimensions are exact.
    pub dimension_shifts: Vec<DimensionShift>,
}

/// Effect of one standard deviation of one independent error of a sample's dimensions.
#[derive(Clone, Debug, PartialEq)]
pub struct DimensionShift {
    /// Change of the logarithm of the modelled ratio at each load.
    pub log_ratio: Vec<f64>,
    /// Features of the texture with the dimensions one standard deviation above.
    pub above: Features,
    /// Features of the texture with the dimensions one standard deviation below; `None` if only one side is known.
    pub below: Option<Features>,
}

impl DimensionShift {
    /// Transfers the error from a sample with the features `from` to a similar sample with the features `to`.
    pub fn about(&self, from: &Features, to: &Features) -> Self {
        let moved = |own: &Features| Features {
            areal_density: own.areal_density + to.areal_density - from.areal_density,
            edge_1_m: own.edge_1_m + to.edge_1_m - from.edge_1_m,
            width_m: own.width_m + to.width_m - from.width_m,
            pitch_m: own.pitch_m + to.pitch_m - from.pitch_m,
            depth_m: own.depth_m + to.depth_m - from.depth_m,
            face_share: own.face_share * to.face_share / from.face_share,
        };
        Self { log_ratio: self.log_ratio.clone(), above: moved(&self.above), below: self.below.as_ref().map(moved) }
    }

    /// Change of the logarithm of `form` by one standard deviation, for a texture with the features `own`; 0 for a
    /// texture without cavities.
    pub fn log_form(&self, form: &Form, own: &Features) -> f64 {
        let log = |of: &Features| libm::log(form.on_face(of));
        let change = match &self.below {
            Some(below) => 0.5 * (log(&self.above) - log(below)),
            None => log(&self.above) - log(own),
        };
        if change.is_finite() { change } else { 0.0 }
    }

    /// Mean of `form` over the error, relative to its value for the features `own` as designed, to second order; 1 if
    /// only one side is known.
    pub fn mean_form(&self, form: &Form, own: &Features) -> f64 {
        let mean = |below: &Features| 0.5 * (form.on_face(&self.above) + form.on_face(below)) / form.on_face(own);
        self.below.as_ref().map(mean).filter(|mean| mean.is_finite()).unwrap_or(1.0)
    }
}

/// Measured ratio of patterned to flat friction, with the modelled ratio.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// Pressure, speed and humidity. Measurements of one condition share the flat sample's error.
    pub load: Load,
    /// Measured ratio of patterned to flat friction.
    pub measured: f64,
    /// Modelled ratio of patterned to flat friction.
    pub modelled: f64,
    /// Relative standard error of the patterned sample's friction.
    pub patterned_std: f64,
    /// Relative standard error of the flat sample's friction.
    pub flat_std: f64,
    /// Sensitivity of the logarithm of the modelled ratio to unknowns shared by all textures.
    pub sensitivity: Sensitivity,
}

/// Sensitivity of the logarithm of a texture's modelled ratio R to the unknowns shared by all textures.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sensitivity {
    /// Derivative d ln R / d ln E, with Young's modulus E.
    pub modulus: f64,
    /// ln R if local friction follows the local pressure, minus ln R as modelled; 0 if flat friction follows the area
    /// law.
    pub local_law: f64,
}

impl Sensitivity {
    /// Sensitivity to Young's modulus only.
    pub const fn of_modulus(modulus: f64) -> Self {
        Self { modulus, local_law: 0.0 }
    }
}

impl Measured {
    /// Logarithm of the measured over the modelled ratio.
    pub fn log_excess(&self) -> f64 {
        libm::log(self.measured / self.modelled)
    }
}

impl Trial {
    /// Checks that all numbers are valid.
    ///
    /// # Errors
    /// [`DiscrepancyError::Measured`] of the first invalid number.
    pub(crate) fn check(&self) -> Result<(), DiscrepancyError> {
        for (row, at) in self.measured.iter().enumerate() {
            let positive =
                |quantity, value: f64| (quantity, value, value > 0.0 && value.is_finite(), "positive and finite");
            let share = |quantity, value: f64| (quantity, value, (0.0..=1.0).contains(&value), "from 0 to 1");
            let finite = |quantity, value: f64, expected| (quantity, value, value.is_finite(), expected);
            let numbers = [
                positive("pressure in pascals", at.load.pressure_pa),
                positive("speed in m/s", at.load.speed_m_s),
                positive("measured ratio", at.measured),
                positive("modelled ratio", at.modelled),
                positive("share of the face", self.features.face_share),
                share("humidity", at.load.humidity),
                share("error of the patterned sample", at.patterned_std),
                share("error of the flat sample", at.flat_std),
                finite("sensitivity to the modulus", at.sensitivity.modulus, "finite"),
                finite("change by the local law", at.sensitivity.local_law, "finite"),
            ];
            let change = |shift: &DimensionShift| {
                let change = shift.log_ratio.get(row).copied().unwrap_or(f64::NAN);
                finite("change by an error of a dimension", change, "finite, one a measurement")
            };
            let mut all = numbers.into_iter().chain(self.dimension_shifts.iter().map(change));
            if let Some((quantity, value, _, expected)) = all.find(|(_, _, is_valid, _)| !is_valid) {
                let (trial, row) = (self.name.clone(), row + 1);
                return Err(DiscrepancyError::Measured { trial, row, quantity, value, expected });
            }
        }
        Ok(())
    }
}
