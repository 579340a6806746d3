//! Discrepancy between model and measurement on textured samples, learned from trials.
//!
//! A *trial* is a sample that was cut and measured. The *discrepancy* of a trial is the logarithm of the measured over the
//! modelled ratio of patterned to flat friction. For a texture x, pressure P, speed v and humidity H the discrepancy is
//!
//! ```text
//! ln r - ln R(x, P) = h(x) [alpha + beta u + kappa s + eta(H) + gamma(H) q + c(x, P)]
//!                   + eps g(x, P) + lambda d(x, P) + t + f + e
//! u = (P - P0) / P0,     q = P1 / P,     s = ln(v / v0)
//! ```
//!
//! h is the *form*: the growth of the discrepancy with the texture. It is 1 at the reference texture and 0 without
//! cavities. c, the *residual*, is a smooth function of the dimensions and of the pressure, for deviations from the form. eps is the
//! error of the logarithm of Young's modulus, g = d ln R / d ln E. lambda says which pressure local friction follows where flat friction contradicts
//! the area law: 0 for the nominal and 1 for the local one, and d is the difference of ln R between both ([`Sensitivity`]). t is the deviation
//! of one sample, which all samples on one disc share, f the flat sample's error, which all ratios of one condition share, and e
//! the error of the patterned measurement.
//!
//! A sample differs from its design. An error of its dimensions changes its modelled ratio and its form: in every trial and every
//! prediction, ln R and h refer to the texture as made ([`DimensionShift`]).
//!
//! The form, the size of the coefficients, the size of the residual and the scatter of samples are unknown. Each combination of
//! [`Hyperparameters::forms`], scales, residual sizes and scatters is an exact Gaussian regression, weighted by its prior times
//! its evidence: a finite mixture, exact and equal on every machine. Without trials the mixture is the prior.
//!
//! | item | role |
//! |---|---|
//! | [`Trial`], [`Measured`] | sample that was cut, and its measurements |
//! | [`Form`], [`Features`] | growth of the discrepancy with the texture, and the features that it depends on |
//! | [`Hyperparameters`] | prior standard deviations, with their reasons |
//! | [`Discrepancy`] | posterior mixture given the trials |
//! | [`Predictor`], [`Distribution`] | prediction for a texture at given loads: quantiles, covariance, chance to be on target |
//! | [`Contradiction`] | two samples of one texture that differ by more than the stated scatter |
//! | [`leave_out`] | cross-validation: every trial and every condition predicted from all others |
//! | [`Wanted`], [`Score`] | chance that a sample is on target, and ranking of textures |
//! | [`Predictor::on_one_disc`] | joint prediction of samples of one disc |
//! | [`Scenarios`] | truths drawn from the mixture, in which several samples are evaluated jointly |
//!
//! This module solves no contact and opens no files.
//!
//! ```
//! use slipgrid_infer::discrepancy::{Conditions, Discrepancy, Features, Hyperparameters, Load, Sensitivity};
//! use slipgrid_model::pattern::{Pattern, Planform};
//! // Before any trial: the prior's interval is wide.
//! let prior = Discrepancy::new(Hyperparameters::default(), Conditions::default(), 0.2, Vec::new())?;
//! let groove = Pattern::new(Planform::Groove, 100e-6, 300e-6, 10e-6).map_err(|error| error.to_string())?;
//! let load = Load { pressure_pa: 1e6, speed_m_s: 2e-3, humidity: 0.4 };
//! let found = prior.at(&[load]).predict(&Features::from(&groove), &[Sensitivity::of_modulus(0.1)]);
//! assert!(found.quantile(0, 0.025) < -0.3 && found.quantile(0, 0.975) > 0.3);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod error;
mod features;
mod flat_friction;
mod form;
mod hyperparameters;
mod identified;
mod joint;
mod leave_out;
mod mixture;
mod next_trial;
mod prediction;
mod residual;
mod rows;
mod scatter;
mod scenarios;
mod trial;

pub use error::DiscrepancyError;
pub use features::Features;
pub use form::Form;
pub use hyperparameters::{Conditions, Hyperparameters};
pub use leave_out::{LeftOut, Surprise, leave_out};
pub(crate) use mixture::is_same;
pub use mixture::{Discrepancy, FormWeight};
pub use next_trial::{Candidate, Score, Wanted, information};
pub use prediction::{Component, Distribution, Load, Predictor, Unknown};
pub use scatter::{Contradiction, ScatterWeight};
pub use scenarios::Scenarios;
pub use trial::{DimensionShift, Measured, Sensitivity, Trial};

#[cfg(test)]
pub(crate) mod tests;
