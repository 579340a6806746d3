//! Time integration of a cell in space.
//!
//! | module | content |
//! |---|---|
//! | `bonds` | forces spring by spring, as a reference |
//! | `field` | displacements at two instants |
//! | `stencil` | rows of inside blocks, and rows with individual coefficients per spring |
//! | `sweep` | one step for a row, in vectors |
//! | `slip` | friction on contact blocks that move along x and y |
//! | `leapfrog` | the integrator |
//! | `run` | one run of one cell |

mod bonds;
mod field;
mod leapfrog;
mod run;
mod slip;
mod stencil;
mod sweep;

#[cfg(test)]
pub use leapfrog::SpaceLeapfrog;
pub use run::{SPACE_STEP, SpaceRun, SpaceScheme};

#[cfg(test)]
mod tests;
