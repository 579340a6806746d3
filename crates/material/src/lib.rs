//! What a material brings to a friction model: elastic constants, local friction coefficients, the
//! area law, and where each came from.
//!
//! A block that carries the local pressure `p` and slides resists with
//!
//! ```text
//! friction traction = mu_d f(p) p
//! ```
//!
//! `f` is the [`AreaLaw`]: the real contact area relative to what proportional growth would give
//! (Balestra et al., J. Tribol. 144, 031704). Without one, `f = 1`: Amontons-Coulomb.
//!
//! | type | role |
//! |---|---|
//! | [`Elastic`] | Young's modulus and density |
//! | [`LocalFriction`] | means and scatter of the local coefficients |
//! | [`Friction`] | one pair for all loads, or coefficients per condition |
//! | [`AreaLaw`] | the factor f(p) |
//! | [`Provenance`] | where values came from, and whether the surface is synthetic |
//!
//! This crate knows no lattice and opens no files.
//!
//! ```
//! use slipgrid_material::AreaLaw;
//! let law = AreaLaw::new(vec![0.7e6, 1.3e6], vec![1.0, 0.9])?;
//! assert_eq!(law.factor(0.2e6), 1.0);
//! assert!((law.factor(1.0e6) - 0.95).abs() < 1e-15);
//! assert!((law.factor(2.6e6) - 0.45).abs() < 1e-15); // the area stays: f goes as 1/p
//! # Ok::<(), slipgrid_material::MaterialError>(())
//! ```

mod area_law;
mod condition;
mod condition_range;
mod elastic;
mod error;
mod friction;
mod measured_law;
mod modulus;

pub use area_law::{AreaLaw, MAX_FACTOR, Piece, THRESHOLD_PRESSURE_PA};
pub use condition::{Condition, between};
pub use condition_range::ConditionRange;
pub use elastic::Elastic;
pub use error::MaterialError;
pub use friction::{ConditionFriction, Friction, FrictionAt, LocalFriction};
pub use measured_law::Extrapolation;

/// Where a material's values came from.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Provenance {
    /// The material's name.
    pub name: String,
    /// Publication or laboratory.
    pub source: String,
    /// The altitude map behind the area law is synthetic, not measured.
    pub synthetic_surface: bool,
    /// One line per value: how it was obtained, what was assumed.
    pub notes: Vec<String>,
    /// What makes results that rest on it doubtful; each begins with its name.
    pub warnings: Vec<String>,
}

/// A material as the models take it.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Elastic constants and density.
    pub elastic: Elastic,
    /// Local friction coefficients.
    pub friction: Friction,
    /// Area law; absent for Amontons-Coulomb friction.
    pub area_law: Option<AreaLaw>,
    /// Where the values came from.
    pub provenance: Provenance,
}
