//! Local friction coefficients from measurements on flat samples.
//!
//! The model of the flat sample is the spring-block one, with its area law f(P) and its free ends. For
//! every measurement i at nominal pressure P_i and speed v_i it predicts
//!
//! ```text
//! mu_i = delta_i steady(mu_d, P_i),     chi^2 = sum [(mu_i - measured_i) / std_i]^2
//! ```
//!
//! `steady` is the flat sample in steady sliding, `delta_i` the ratio of a dynamic run to it: at a few
//! mm/s sliding is micro-stick-slip and friction one to two per cent above steady sliding. delta is
//! found at the fitted coefficients, so that the dynamic mu that the program predicts for the flat
//! sample is the measured one.
//!
//! | type | role |
//! |---|---|
//! | [`Problem`] | measurements and what is known of the material |
//! | [`calibrate`] | the fit |
//! | [`Fit`], [`FittedPair`], [`Parameter`] | coefficients, covariance, profile likelihood, residuals, what stays undetermined |
//! | [`trace`] | tribometer traces: dynamic mean, static peak, stick-slip |
//! | [`estimate`], [`Discrepancy`] | the model's error on patterned samples, apart from its physics |
//! | [`TrialDomain`] | the patterns that it is used for |
//! | [`uncertainty`] | what all that leaves open of the friction of a scene, to first order |
//!
//! The mean dynamic friction of a flat sample says nothing of mu_s: without a measured static peak
//! its ratio to mu_d is an assumption ([`Problem::static_over_dynamic`]) and the fit says so.
//!
//! Where no map is given, the pressure scale of the area law can be fitted as well ([`AreaLawScale`]).
//!
//! This crate fits nothing to patterned samples and opens no files.
//!
//! ```no_run
//! use slipgrid_calibrate::{Coefficients, Measurement, Problem, calibrate};
//! use slipgrid_material::Elastic;
//! use slipgrid_springblock::{Layer, Unwatched};
//! let problem = Problem {
//!     elastic: Elastic::new(0.38e9, 900.0)?,
//!     area_law: None,
//!     area_law_scale: None,
//!     layer: Layer { length_m: 9960e-6, height_m: 200e-6, block_m: 10e-6, thickness_m: None },
//!     specimen_area_m2: 78.54e-6,
//!     measurements: vec![Measurement {
//!         force_n: 200.0,
//!         speed_m_s: 2e-3,
//!         humidity: 0.15,
//!         mu_dynamic: 0.278,
//!         mu_dynamic_std: 0.001,
//!         static_peak: None,
//!     }],
//!     coefficients: Coefficients::Single,
//!     relative_std: 0.05,
//!     static_over_dynamic: 0.30 / 0.27,
//!     seed: 1,
//! };
//! let fit = calibrate(&problem, &Unwatched)?;
//! println!("mu_d = {}", fit.pairs[0].dynamic_mean);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod area_law;
mod area_law_scale;
mod discrepancies;
mod discrepancy;
mod emulator;
mod fit;
mod fitted_material;
mod flat;
mod flat_friction_law;
mod least_squares;
mod marginal;
mod noise;
mod patterned_samples;
mod problem;
mod select_measurements;
mod surface;
mod task;
pub mod trace;
mod trials;
pub mod uncertainty;
pub mod windows;

pub use area_law_scale::AreaLawScale;
pub use discrepancies::Discrepancies;
pub use discrepancy::{Discrepancy, DiscrepancyForm, RatioInterval, RatioPoint, estimate, leave_one_out, uncorrected};
pub use fit::{Fit, FittedPair, Parameter, Prediction, calibrate, planned_steps};
pub use flat_friction_law::flat_friction_law;
pub use marginal::{FlatLoad, marginal_relative_std};
pub use noise::Noise;
pub use patterned_samples::{PatternedSamples, RatioAtCondition};
pub use problem::{Coefficients, FitError, Measurement, Problem, StaticPeak};
pub use select_measurements::{Selection, measured_friction};
pub use surface::{AreaLawOrigin, SurfaceFindings};
pub use task::{CalibrationError, CalibrationOutcome, CalibrationTask, FittedRow, MapSurface, Surface, run};
pub use trials::{DENSITY_FACTOR, DEPTH_FACTOR, Far, Trial, TrialDomain};
