//! Material data for a friction model: elastic constants, local friction coefficients, the area law, and their
//! provenance.
//!
//! The friction traction of a sliding block with the local dynamic coefficient `mu_d` and the local pressure `p` is
//!
//! ```text
//! friction traction = mu_d f(p) p
//! ```
//!
//! `f` is the [`AreaLaw`]: real contact area relative to proportional growth (Balestra et al., J. Tribol. 144, 031704).
//! Without an area law `f = 1`: Amontons-Coulomb.
//!
//! | type | role |
//! |---|---|
//! | [`Elastic`] | Young's modulus and density |
//! | [`LocalFriction`] | means and scatter of the local coefficients |
//! | [`Friction`] | one pair of coefficients for all loads, or coefficients per condition |
//! | [`AreaLaw`] | factor f(p) |
//! | [`Provenance`] | origin of the values, and whether the surface is synthetic |
//!
//! This module does not depend on a lattice and opens no files.
//!
//! ```
//! use slipgrid_model::material::AreaLaw;
//! let law = AreaLaw::new(vec![0.7e6, 1.3e6], vec![1.0, 0.9])?;
//! assert_eq!(law.factor(0.2e6), 1.0);
//! assert!((law.factor(1.0e6) - 0.95).abs() < 1e-15);
//! assert!((law.factor(2.6e6) - 0.45).abs() < 1e-15); // the area stays: f goes as 1/p
//! # Ok::<(), slipgrid_model::material::MaterialError>(())
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
pub use friction::{ConditionFriction, END_MARGIN, Friction, FrictionAt, LocalFriction};
pub use measured_law::Extrapolation;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Origin of a material's values.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Provenance {
    /// Name of the material.
    pub name: String,
    /// Publication or laboratory that the values come from.
    pub source: String,
    /// True if the area law is computed from a synthetic surface.
    pub synthetic_surface: bool,
    // One sentence each.
    /// Notes on how values were obtained.
    pub notes: Vec<String>,
    // Each begins with its name.
    /// Warnings about the material, which make results doubtful.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
}

/// Material of the specimen.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Elastic constants and density.
    pub elastic: Elastic,
    /// Local friction coefficients.
    pub friction: Friction,
    /// Area law; `None` for Amontons-Coulomb friction.
    pub area_law: Option<AreaLaw>,
    /// Origin of the values.
    pub provenance: Provenance,
}
