//! The periodic cell in space. A cubic mesh of blocks with springs to the 6 nearest and the 12 face-diagonal
//! neighbours, all of stiffness k = 2/5 E l, is isotropic with nu = 1/4. In plane strain it is equivalent to plane
//! stress at nu/(1 - nu) = 1/3: for a groove across the sliding direction it is the lattice of the vertical plane.
//!
//! | type | role |
//! |---|---|
//! | [`SpaceLattice`] | positions of blocks, springs between them, masses |
//! | [`SpaceSteadyModel`] | steady sliding of one cell under many loads |
//! | [`layer::FlatLayer`] | exact response of the flat layer, by Fourier transforms |
//! | [`interface::Interface`] | effect of the cavities: missing springs, blocks that do not touch |
//! | [`directions::Directions`] | search directions shared by successive loads |
//!
//! Processor time for condensing and for solving four pressures on one core, with cavities a quarter of the cell wide
//! and a tenth of the layer deep: 15 ms for 50 x 50 x 20 blocks, 0.13 s for 100 x 100 x 40, 0.85 s and 0.19 GB for 200
//! x 200 x 80.

mod directions;
mod interface;
mod lattice;
mod layer;
mod springs;
mod steady;

pub use lattice::{SpaceBond, SpaceLattice};
pub use springs::Spring as SpaceSpring;
pub(crate) use steady::{MAX_DIRECTIONS, MAX_STORED_DIRECTIONS, TOLERANCE};
pub use steady::{SpaceLoad, SpaceSteadyModel};

#[cfg(test)]
mod contact_tests;
#[cfg(test)]
mod planform_tests;
#[cfg(test)]
mod raised_tests;
#[cfg(test)]
mod tests;
