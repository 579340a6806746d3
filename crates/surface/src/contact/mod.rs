//! Normal contact of rough surfaces: the real contact area.
//!
//! An elastic half-space with the periodic surface h is pressed onto a rigid plane without adhesion or friction.
//! Pressure p and gap g obey
//!
//! ```text
//! g = u - h + const >= 0,   p >= 0,   p g = 0,   mean p = P,   u_q = 2/(E* |q|) p_q
//! ```
//!
//! with the displacement u, the nominal pressure P and E* = E/(1 - nu^2); the last equation holds for each wave vector
//! q in Fourier space. The real contact area is where p > 0.
//!
//! | item | role |
//! |---|---|
//! | [`area_curve`] | area fraction against pressure, pressures in parallel |
//! | [`RoughContact`] | normalized contact problem of one surface; solves one pressure or reports non-convergence |
//! | [`SolveOptions`] | tolerance and maximum number of iterations |
//! | [`ContactState`], [`AreaCurve`] | results, with their [`Convergence`] |
//! | [`ContactArea`] | area fraction: counted pixels, and corrected for the contact boundary |
//! | [`windows`], [`coarser`] | maps derived from a map, to study the effect of its size and resolution |
//! | [`Monitor`] | progress and cancellation |
//! | [`closed_form`] | area fraction by Persson's theory |
//!
//! This module does not depend on friction models and opens no files.
//!
//! ```
//! use slipgrid_surface::contact::{SolveOptions, Unwatched, area_curve};
//! use slipgrid_surface::topography::HeightMap;
//! // A wave of 1 um on 1 mm: full contact from p* = pi E* D / lambda, half contact at p*/2.
//! let heights = (0..64 * 4).map(|n| 1e-6 * (std::f64::consts::TAU * f64::from(n / 4) / 64.0).cos()).collect();
//! let map = HeightMap::new(64, 4, 1e-3 / 64.0, 1e-3 / 64.0, heights)?;
//! let full_pa = std::f64::consts::PI * 427.5e6 * 1e-6 / 1e-3;
//! let pressures_pa = [0.0, 0.5 * full_pa, 1.01 * full_pa];
//! let curve = area_curve(&map, 427.5e6, &pressures_pa, &SolveOptions::default(), &Unwatched)?;
//! assert!((curve.full_contact_pressure_pa / full_pa - 1.0).abs() < 1e-12);
//! assert_eq!(curve.points[0].area_fraction, 0.0);
//! assert!((curve.points[1].area_fraction - 0.5).abs() <= 1.0 / 64.0); // a column of pixels
//! assert_eq!(curve.points[2].area_fraction, 1.0);
//! # Ok::<(), slipgrid_surface::contact::ContactError>(())
//! ```

pub mod closed_form;

mod area;
mod blocks;
mod curve;
mod error;
mod kernels;
mod preconditioner;
mod projected_gradient;
mod rough_contact;
mod sampling;
mod solver;
mod two_grids;

pub use area::ContactArea;
pub use curve::{AreaCurve, AreaPoint, area_curve};
pub use error::ContactError;
pub use rough_contact::{ContactState, Convergence, RoughContact, SolveOptions};
pub use sampling::{coarser, window_pixels, windows};
pub use slipgrid_base::monitor::{Monitor, Unwatched};
