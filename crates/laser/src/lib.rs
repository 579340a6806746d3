//! Layouts of a pattern on a specimen, files for the laser, and friction of the textured specimen.
//!
//! | module | content |
//! |---|---|
//! | [`export`] | layouts on a specimen and laser files |
//! | [`specimen`] | friction of a pattern on the specimen that it is cut into |

pub mod export;
pub mod specimen;
