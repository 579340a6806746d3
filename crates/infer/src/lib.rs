//! From measurements to a material with its errors, and from trials to the deviation from the model.
//!
//! | module | content |
//! |---|---|
//! | [`discrepancy`] | deviation of textured samples from the model, learned from trials |
//! | [`calibrate`] | from measurements on samples to a material with errors |

pub mod calibrate;
pub mod discrepancy;
