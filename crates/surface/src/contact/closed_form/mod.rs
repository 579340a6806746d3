//! Contact problems with closed-form solutions, for tests of the solver and for quick estimates.

mod hertz;
mod persson;
mod waves;

pub use hertz::Hertz;
pub use persson::persson_area_fraction;
pub use waves::{CrossedWaves, Wave};
