//! Local friction coefficients from measurements on flat samples.
//!
//! The flat sample is modelled by the spring-block model with its area law f(P) and free ends. For measurement i at
//! nominal pressure P_i and speed v_i the model predicts
//!
//! ```text
//! mu_i = delta_i steady(mu_d, P_i),     chi^2 = sum [(mu_i - measured_i) / std_i]^2
//! ```
//!
//! `steady` is friction of the flat sample in steady sliding, and `delta_i` the ratio of dynamic to steady friction. At
//! a few mm/s sliding is micro-stick-slip, and friction is one to two per cent above steady sliding. delta is computed
//! at the fitted coefficients, so that modelled dynamic friction of the flat sample equals the measured one.
//!
//! | item | role |
//! |---|---|
//! | [`run`], [`CalibrationTask`] | the whole job: from measurements and a surface to a material with its uncertainty |
//! | [`CalibrationOutcome`] | the material, its [`uncertainty::MaterialUncertainty`], the fit and the contact area |
//! | [`Selection`] | measurements required for given conditions and pressures |
//! | [`area_law`], [`area_law_sampling`] | contact area and area law of a map, and their spread over windows |
//! | [`fit_coefficients`], [`Problem`] | the fit alone |
//! | [`Fit`], [`FittedPair`], [`Parameter`] | coefficients, covariance, profiles, residuals, undetermined parameters |
//! | [`learn`], [`CutSample`] | discrepancy of the model, learned from samples that were cut and measured |
//! | [`uncertainty`] | first-order uncertainty of the friction of a scene |
//!
//! Mean dynamic friction of a flat sample does not determine mu_s. Without a measured static peak the ratio to mu_d is
//! an assumption ([`Problem::static_over_dynamic`]), which the notes of the fit state.
//!
//! Without a map, the pressure scale of the area law can be fitted as well ([`AreaLawScale`]).
//!
//! This module does not fit coefficients to patterned samples, opens no files, prints nothing and reads no clock.
//!
//! A calibration from two measurements on flat samples, for a surface with a known rms slope only:
//!
//! ```no_run
//! use slipgrid_infer::calibrate::{CalibrationTask, Coefficients, Measurement, Selection, Surface, TrialsTask, run};
//! use slipgrid_model::material::Elastic;
//! use slipgrid_model::springblock::{Layer, Unwatched};
//! let measured = |force_n: f64, mu_dynamic: f64| Measurement {
//!     force_n,
//!     speed_m_s: 2e-3,
//!     humidity: 0.15,
//!     mu_dynamic,
//!     mu_dynamic_std: 0.001,
//!     static_peak: None,
//! };
//! let task = CalibrationTask {
//!     name: "LDPE on cast iron".to_owned(),
//!     source: "our laboratory".to_owned(),
//!     elastic: Elastic::new(0.38e9, 900.0)?,
//!     youngs_modulus_std_pa: Some(0.08e9),
//!     poisson_ratio: 1.0 / 3.0,
//!     surface: Surface::RmsSlope(0.0137),
//!     threshold_pa: None,
//!     specimen_area_m2: 78.54e-6,
//!     flat: vec![measured(100.0, 0.271), measured(200.0, 0.278)],
//!     trials: TrialsTask::default(),
//!     coefficients: Coefficients::PerCondition,
//!     relative_std: 0.05,
//!     static_over_dynamic: 0.30 / 0.27,
//!     layer: Layer { length_m: 9960e-6, height_m: 200e-6, block_m: 10e-6, thickness_m: None, holder: None },
//!     seed: 1,
//!     selection: Selection::default(),
//!     notes: Vec::new(),
//!     doubts: Vec::new(),
//! };
//! let found = run(&task, &Unwatched)?;
//! println!("mu_d = {}", found.fit.pairs[0].dynamic_mean);
//! println!("{:?}", found.material.area_law);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod area_law;
pub mod area_law_sampling;
mod calibration;
mod calibration_task;
mod contradicting_samples;
mod cut_sample;
mod fit;
mod fit_problem;
mod fitted_material;
mod flat_friction_law;
mod flat_sample;
mod flat_sample_emulator;
mod land_slope;
mod law_pressures;
mod least_squares;
mod load_dependence;
mod marginal_uncertainty;
mod patterned_samples;
mod select_measurements;
mod surface_area_law_source;
mod trial_discrepancy;
pub mod uncertainty;

pub use calibration::{learn_alone, run};
pub use calibration_task::{CalibrationError, CalibrationTask, MapSurface, Selection, Surface};
pub use contradicting_samples::contradicting_samples;
pub use cut_sample::{CutSample, CutSpecimen, TrialsTask};
pub use fit::{
    Fit, FittedPair, FittedRow, ModelledRow, Parameter, STATIC_OVER_DYNAMIC, fit_coefficients, planned_steps,
};
pub use fit_problem::{AreaLawScale, Coefficients, FitError, Measurement, Problem, StaticPeak, split_parameter_name};
pub use fitted_material::CalibrationOutcome;
pub use flat_friction_law::flat_friction_law;
pub use land_slope::{LandEffect, LandSlope};
pub use law_pressures::{LawPressures, light_pressure_pa};
pub use marginal_uncertainty::marginal_relative_std;
pub use select_measurements::measured_friction;
pub use surface_area_law_source::{AreaLawOrigin, SurfaceFindings};
pub use trial_discrepancy::{Learned, learn, sample_bytes};
