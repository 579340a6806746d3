//! Input of a fit: measurements on flat samples and known properties of the material.

use serde::Deserialize;
use slipgrid_base::units::{
    HUMIDITY_PCT, MODULUS_GPA, PRESSURE_MPA, SPEED_MM_S, is_same, significant, significant_to, tidy,
};
use slipgrid_model::material::{AreaLaw, Condition, Elastic, MaterialError};
use slipgrid_model::springblock::{Layer, SceneError};

/// A measured peak of friction at the onset of sliding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StaticPeak {
    /// Static friction coefficient.
    pub mu: f64,
    /// Standard deviation of `mu`.
    pub std: f64,
}

/// One measurement on a flat or a patterned sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement {
    /// Normal force on one specimen, in newtons.
    pub force_n: f64,
    /// Sliding speed, in m/s.
    pub speed_m_s: f64,
    /// Relative humidity, 0 to 1.
    pub humidity: f64,
    /// Dynamic friction coefficient.
    pub mu_dynamic: f64,
    /// Standard deviation of `mu_dynamic` as a prediction for another sample.
    pub mu_dynamic_std: f64,
    /// Static peak; `None` if not measured.
    pub static_peak: Option<StaticPeak>,
}

impl Measurement {
    /// Speed and humidity.
    pub const fn condition(&self) -> Condition {
        Condition { speed_m_s: self.speed_m_s, humidity: self.humidity }
    }

    /// Whether `other` was measured at equal speed and humidity.
    pub fn has_condition_of(&self, other: &Self) -> bool {
        self.condition().matches(&other.condition())
    }

    /// Whether `other` was measured at equal force, speed and humidity.
    pub fn is_at(&self, other: &Self) -> bool {
        is_same(self.force_n, other.force_n) && self.has_condition_of(other)
    }

    /// Describes force, speed and humidity.
    pub fn condition_in_words(&self) -> String {
        let [speed_mm_s, humidity_pct] = [SPEED_MM_S.from_si(self.speed_m_s), HUMIDITY_PCT.from_si(self.humidity)];
        format!("{} N, {speed_mm_s} mm/s, {humidity_pct} %", significant(self.force_n, 6))
    }
}

/// Splits the name of a parameter into quantity and measurement: `dynamic_mean 4` into `dynamic_mean` and the fourth of
/// `measurements`. `None` if the name has no index.
pub fn split_parameter_name<'a>(name: &'a str, measurements: &'a [Measurement]) -> Option<(&'a str, &'a Measurement)> {
    let (what, number) = name.rsplit_once(' ')?;
    Some((what, measurements.get(number.parse::<usize>().ok()?.checked_sub(1)?)?))
}

/// A contact area curve with an unknown pressure scale s: A(P) = a(P / s). For a surface of given shape, s is exactly
/// proportional to E* h'rms, contact modulus times rms slope: with heights h, A(P; c h) = A(P / c; h).
#[derive(Clone, Debug, PartialEq)]
pub struct AreaLawScale {
    /// Nominal pressures over the scale s, increasing.
    pub pressure_over_scale: Vec<f64>,
    /// Contact area fraction at these pressures.
    pub area_fraction: Vec<f64>,
    /// Lower and upper bound of the scale, in pascals.
    pub bounds_pa: [f64; 2],
}

impl AreaLawScale {
    /// Area law for the scale `scale_pa`; its factor is 1 at the first pressure of the curve.
    ///
    /// # Errors
    /// [`MaterialError`] if the curve is not a valid table.
    pub fn law(&self, scale_pa: f64) -> Result<AreaLaw, MaterialError> {
        let pressure_pa: Vec<f64> = self.pressure_over_scale.iter().map(|x| x * scale_pa).collect();
        AreaLaw::from_area_curve(&pressure_pa, &self.area_fraction, pressure_pa.first().copied().unwrap_or(0.0))
    }
}

/// Whether one pair of local coefficients is fitted to all measurements, or one pair per load, speed and humidity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Coefficients {
    /// One pair of local coefficients, static and dynamic, for all measurements.
    Single,
    /// One pair of local coefficients for each load, speed and humidity.
    PerCondition,
}

/// Input of a fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Problem {
    /// Elastic constants.
    pub elastic: Elastic,
    /// Area law; `None` if friction is proportional to load (Amontons-Coulomb).
    pub area_law: Option<AreaLaw>,
    /// Area law with an unknown scale that is fitted, instead of `area_law`; `None` if no scale is fitted. Requires one
    /// pair of coefficients for several loads, because one pair per load could absorb any law.
    pub area_law_scale: Option<AreaLawScale>,
    /// The modelled layer of the specimen.
    pub layer: Layer,
    /// Area of one specimen's face, in square metres.
    pub specimen_area_m2: f64,
    /// Measurements on flat samples.
    pub measurements: Vec<Measurement>,
    /// Whether one pair of local coefficients is fitted to all measurements, or one pair per load, speed and humidity.
    pub coefficients: Coefficients,
    /// Relative standard deviation of the local coefficients between contact blocks; mean friction does not determine
    /// it.
    pub relative_std: f64,
    /// Assumed ratio mu_s / mu_d of the local static to the local dynamic coefficient where no static peak was
    /// measured.
    pub static_over_dynamic: f64,
    /// Seed of the random draw of local coefficients.
    pub seed: u64,
}

/// Reason why a fit was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FitError {
    /// There is no measurement.
    #[error("there is no measurement: expected at least one")]
    NoMeasurement,
    /// A number of a measurement is invalid.
    #[error("measurement {number}: {quantity} is {value}: expected a positive number")]
    Measurement {
        /// Index of the measurement, from 1.
        number: usize,
        /// Key of the number in a table of measurements.
        quantity: &'static str,
        /// The number given.
        value: f64,
    },
    /// The spring-block model refused the layer or the material.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The fit led to invalid coefficients.
    #[error("the measurements lead to a friction coefficient without meaning: {0}")]
    Material(#[from] MaterialError),
    /// The flat sample did not slide in the model.
    #[error(
        "measurement {number}: the flat sample did not reach sliding in the model at {:.4} MPa: {status}",
        pressure_pa / 1e6
    )]
    NoSliding {
        /// Index of the measurement, from 1.
        number: usize,
        /// Nominal pressure, in pascals.
        pressure_pa: f64,
        /// Final status of the run.
        status: &'static str,
    },
    /// The modelled flat sample cannot show such a high static peak.
    #[error(
        "measurement {number}: the static peak is {ratio:.2} times dynamic friction: expected at most {most}, beyond \
         which the model's sample does not slide at once"
    )]
    PeakTooHigh {
        /// Index of the measurement, from 1.
        number: usize,
        /// Static peak over dynamic friction.
        ratio: f64,
        /// Maximum accepted ratio.
        most: f64,
    },
    /// The local coefficient would exceed the allowed maximum.
    #[error(
        "measurement {number}: friction over the area law's factor {factor:.2e} is {mean:.2e}: expected a local \
         coefficient of at most {most}"
    )]
    BeyondLaw {
        /// Index of the measurement, from 1.
        number: usize,
        /// Area factor f at the pressure of the measurement.
        factor: f64,
        /// Local coefficient that the measurement would require.
        mean: f64,
        /// Maximum accepted coefficient.
        most: f64,
    },
    /// Sliding is so fast that it proceeds in waves.
    #[error(
        "measurement {number}: {} mm/s is too fast at {} MPa with E = {} GPa: expected at most {} mm/s",
        tidy(SPEED_MM_S.from_si(*speed_m_s)),
        significant(PRESSURE_MPA.from_si(*pressure_pa), 3),
        tidy(MODULUS_GPA.from_si(*modulus_pa)),
        significant_to(SPEED_MM_S.from_si(*most_m_s), 2, f64::floor)
    )]
    TooFast {
        /// Index of the measurement, from 1.
        number: usize,
        /// Sliding speed, in m/s.
        speed_m_s: f64,
        /// Nominal pressure, in pascals.
        pressure_pa: f64,
        /// Young's modulus, in pascals.
        modulus_pa: f64,
        /// Maximum speed for this pressure and modulus, in m/s.
        most_m_s: f64,
        /// Maximum modulus for this pressure and speed, in pascals.
        most_modulus_pa: f64,
    },
    /// Modelled dynamic friction is not within 0.5 to 1.5 times steady friction.
    #[error(
        "measurement {number}: in the model the sample slides with {:.0} % of its steady friction at this load and \
         speed: expected 50 to 150 %, as where friction exceeds the inertia of the layer", 100.0 * delta
    )]
    NotQuasiStatic {
        /// Index of the measurement, from 1.
        number: usize,
        /// Dynamic over steady friction.
        delta: f64,
    },
    /// A run would take too long.
    #[error(
        "measurement {number}: its run in time takes {steps:.1e} time steps, as steps grow with 1/speed: {hours:.1} hours of one core, and up \
         to twenty times as long until its mean is known: expected at most {most:.0e} steps, a speed of {:.2e} m/s or more",
        least_m_s
    )]
    TooManySteps {
        /// Index of the measurement, from 1.
        number: usize,
        /// Time steps planned.
        steps: f64,
        /// Maximum number of time steps.
        most: f64,
        /// Approximate time on one core, in hours.
        hours: f64,
        /// Lowest speed, in m/s, with an accepted number of time steps.
        least_m_s: f64,
    },
    /// There are too many coefficients to compute their profiles.
    #[error("{count} coefficients are to be fitted: expected at most {most}")]
    TooManyCoefficients {
        /// Number of coefficients.
        count: usize,
        /// Maximum number of coefficients.
        most: usize,
    },
    /// All runs together would take too long.
    #[error("the runs of the flat sample take {steps:.1e} time steps together: expected at most {most:.0e}")]
    TooMuchWork {
        /// Time steps planned for one round.
        steps: f64,
        /// Maximum number of time steps.
        most: f64,
    },
    /// The data cannot separate the area law from the coefficients.
    #[error("the scale of the area law cannot be fitted: {reason}")]
    AreaLawNotIdentifiable {
        /// Reason, and the input that would be accepted.
        reason: &'static str,
    },
    /// The monitor asked to stop.
    #[error("stopped")]
    Cancelled,
}

impl FitError {
    /// Index of the measurement that caused the error, from 1; `None` if no single one did.
    pub const fn measurement(&self) -> Option<usize> {
        match self {
            Self::Measurement { number, .. }
            | Self::NoSliding { number, .. }
            | Self::PeakTooHigh { number, .. }
            | Self::BeyondLaw { number, .. }
            | Self::TooFast { number, .. }
            | Self::NotQuasiStatic { number, .. }
            | Self::TooManySteps { number, .. } => Some(*number),
            _ => None,
        }
    }
}

impl Problem {
    /// Nominal pressure of a measurement, in pascals.
    pub fn pressure_pa(&self, measured: &Measurement) -> f64 {
        // P = F / A
        measured.force_n / self.specimen_area_m2
    }

    /// Whether a static peak was measured. Peaks require a second round of dynamic runs, and one more run per peak with
    /// a larger local static coefficient.
    pub fn has_peaks(&self) -> bool {
        self.measurements.iter().any(|measured| measured.static_peak.is_some())
    }

    /// Checks the numbers of the measurements, and that they determine what is to be fitted. The model refuses other
    /// numbers that are invalid.
    ///
    /// # Errors
    /// [`FitError`] if there are no measurements, one is invalid, or they do not determine the scale of the area law.
    pub fn validate(&self) -> Result<(), FitError> {
        let Some(first) = self.measurements.first() else { return Err(FitError::NoMeasurement) };
        for (measured, number) in self.measurements.iter().zip(1..) {
            let peak = measured.static_peak.unwrap_or(StaticPeak { mu: 1.0, std: 1.0 });
            for (quantity, value) in [
                ("force_n", measured.force_n),
                ("speed_m_s", measured.speed_m_s),
                ("mu_dynamic", measured.mu_dynamic),
                ("mu_dynamic_std", measured.mu_dynamic_std),
                ("mu_static", peak.mu),
                ("mu_static_std", peak.std),
            ] {
                if !(value.is_finite() && value > 0.0) {
                    return Err(FitError::Measurement { number, quantity, value });
                }
            }
        }
        let Some(unknown) = &self.area_law_scale else { return Ok(()) };
        for bound_pa in unknown.bounds_pa {
            unknown.law(bound_pa)?;
        }
        let reason = if unknown.bounds_pa[0] >= unknown.bounds_pa[1] {
            "its bounds are no range: expected two increasing pressures"
        } else if self.coefficients == Coefficients::PerCondition {
            "a pair of coefficients for each load absorbs any area law: expected coefficients = \"single\", or a map"
        } else if self.measurements.iter().all(|measured| (measured.force_n / first.force_n - 1.0).abs() < 1e-6) {
            "all measurements are at one load: expected two loads or more, or a map"
        } else {
            return Ok(());
        };
        Err(FitError::AreaLawNotIdentifiable { reason })
    }

    /// Area law for `scale_pa` if the scale is fitted, otherwise the given law; `None` if friction is proportional to
    /// load.
    pub(crate) fn law_at(&self, scale_pa: f64) -> Result<Option<AreaLaw>, FitError> {
        match &self.area_law_scale {
            Some(unknown) => Ok(Some(unknown.law(scale_pa)?)),
            None => Ok(self.area_law.clone()),
        }
    }
}
