//! The periodic cell in space: a cubic mesh of blocks with springs to the 6 nearest and the 12 face-diagonal
//! neighbours, all of stiffness k = 2/5 E l, is isotropic with nu = 1/4. In plane strain that is plane stress at
//! nu/(1 - nu) = 1/3: a groove across is the vertical plane's own lattice.
//!
//! | type | role |
//! |---|---|
//! | [`SpaceLattice`] | where blocks are, which springs join them, what they weigh |
//! | [`SpaceSteadyModel`] | steady sliding of one cell under many loads |
//! | [`layer::FlatLayer`] | the flat layer's exact response, by Fourier transforms |
//! | [`interface::Interface`] | what cavities change of it: springs missing, blocks that do not touch |
//! | [`directions::Directions`] | search directions that serve one load after the other |
//!
//! Cost, four pressures on one core, cavities a quarter wide and a tenth deep (blocks: condensing and solving, processor
//! time): 50 x 50 x 20: 15 ms, 100 x 100 x 40: 0.13 s, 200 x 200 x 80: 0.85 s and 0.19 GB.

mod directions;
mod interface;
mod lattice;
mod layer;
mod springs;
mod steady;

pub use lattice::{SpaceBond, SpaceLattice};
pub use springs::Spring as SpaceSpring;
pub(crate) use steady::{MAX_DIRECTIONS, MAX_KEPT, TOLERANCE};
pub use steady::{SpaceLoad, SpaceSteadyModel};

#[cfg(test)]
mod contact_tests;
#[cfg(test)]
mod planform_tests;
#[cfg(test)]
mod raised_tests;
#[cfg(test)]
mod strip_tests;
#[cfg(test)]
mod tests;
