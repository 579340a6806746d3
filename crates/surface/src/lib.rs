//! Height maps, and the real contact area of a rough surface.
//!
//! | module | content |
//! |---|---|
//! | [`topography`] | height maps: read, levelled, measured |
//! | [`contact`] | real contact area against pressure |

pub mod contact;
pub mod topography;
