//! Time integration of the cell in space.
//!
//! | module | content |
//! |---|---|
//! | `bonds` | forces spring by spring, as a reference |
//! | `field` | displacements at two instants |
//! | `stencil` | rows of inside blocks, and rows with a coefficient per spring |
//! | `sweep` | one step for a row, in vectors |
//! | `slip` | friction as a vector on contact blocks |
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
pub use leapfrog::{SpaceLeapfrog, SpaceSetup};
pub use run::{SPACE_STEP, SpaceRun, SpaceScheme};

#[cfg(test)]
mod tests;
