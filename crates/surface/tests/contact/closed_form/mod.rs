//! Contact problems with closed-form solutions, which the solver is compared with.

mod hertz;
mod waves;

pub use hertz::Hertz;
pub use waves::{CrossedWaves, Wave};
