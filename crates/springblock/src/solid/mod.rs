//! The three-dimensional periodic cell.

mod directions;
mod interface;
mod lattice;
mod layer;
mod outcome;
mod springs;
mod steady;

pub use lattice::{SolidBond, SolidLattice};
pub use outcome::{SolidOutcome, SolidPoint};
pub use steady::{SolidLoad, SolidSteadyModel};

#[cfg(test)]
mod tests;
