//! Time integration: friction at rest and in motion, from the first load to steady sliding.
//!
//! | module | what it holds |
//! |---|---|
//! | `scales` | units: l, k, m |
//! | `protocol` | ramp, rest, drive |
//! | `contact` | the friction law on the contact row |
//! | `bonds` | forces bond by bond, linear or exact |
//! | `rows` | coefficients and state of the stencil |
//! | `stencil` | linear forces as a stencil |
//! | `sweep` | one pass of forces, kick and drift over the stencil |
//! | `leapfrog`, `runge_kutta` | integrators |
//! | `stability` | the largest eigenfrequency |
//! | `recorder` | history and averages |
//! | `run` | one run from start to end |

mod bonds;
mod contact;
mod engine;
mod leapfrog;
mod protocol;
mod recorder;
mod rows;
mod run;
mod runge_kutta;
mod scales;
mod stability;
mod stencil;
mod sweep;

pub use run::{DynamicRun, MOST_STEPS, Plan, Scheme};

#[cfg(test)]
mod properties;
#[cfg(test)]
mod tests;
