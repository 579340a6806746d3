//! Contact problems with closed solutions: judges of the solver, and estimates of their own.

mod hertz;
mod persson;
mod waves;

pub use hertz::Hertz;
pub use persson::persson_area_fraction;
pub use waves::{CrossedWaves, Wave};
