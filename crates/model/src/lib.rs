//! The physical model: patterns, materials, and the spring-block lattice that slides.
//!
//! | module | content |
//! |---|---|
//! | [`material`] | elastic constants, local friction, the area law |
//! | [`pattern`] | planforms, arrangements, and their dimensions |
//! | [`springblock`] | friction of a pattern: steady cells and runs in time, in the plane and in space |

pub mod material;
pub mod pattern;
pub mod springblock;
