//! Requirements on a design: target, bounds, limits and manufacturing tolerances.
//!
//! | type | role |
//! |---|---|
//! | [`Target`], [`Demand`], [`Wanted`], [`Goal`] | values, bands and weights at pressures; goal to optimize |
//! | [`DesignSpace`] | bounds of width, spacing and depth |
//! | [`Constraints`], [`Limit`], [`Violation`] | manufacturing limits and limited quantities |
//! | [`Tolerances`], [`with_rim_off`] | scatter of samples about a design |
//! | [`ModelFailure`] | reason why a model gives no result |
//! | [`SearchError`] | reason why target, bounds or tolerances were refused |
//!
//! This module is independent of files, measurements and the implementation of models.
//!
//! ```
//! use slipgrid_design::optimize::{Quantity, Target, TargetPoint};
//! let point = TargetPoint { pressure_pa: 1e6, value: 0.75 };
//! let target = Target::new(Quantity::Ratio, vec![point], 0.01)?;
//! assert_eq!(target.points()[0].wanted.band(), [Some(0.74), Some(0.76)]);
//! # Ok::<(), slipgrid_design::optimize::SearchError>(())
//! ```

mod constraints;
mod error;
mod space;
mod target;
mod tolerances;

pub use constraints::{Bound, ConstraintQuantity, Constraints, Limit, Violation};
pub use error::{ModelFailure, SearchError};
pub use space::DesignSpace;
pub use target::{Demand, Goal, Quantity, Target, TargetPoint, Wanted};
pub use tolerances::{Tolerances, with_rim_off};
