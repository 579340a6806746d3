//! Time integration: friction at rest and in motion, from the first load to steady sliding.
//!
//! | module | what it holds |
//! |---|---|
//! | `scales` | units: l, k, m |
//! | `protocol` | ramp, rest, drive |
//! | `contact` | the friction law on a contact block, and the contact row of the plane |
//! | `bonds`, `bond_rows` | forces of linear or exact springs, row by row |
//! | `real` | single and double precision |
//! | `rows` | coefficients and state of a strip of columns |
//! | `stencil` | a lattice cut into strips, with the coefficients of its linear springs |
//! | `sweep` | one step for the rows of a strip, in vectors |
//! | `contact_columns` | what a pass over contact blocks reads |
//! | `contact_vectors` | friction on the contact blocks of a strip, or of a cell in space, in vectors |
//! | `strip` | one step of a strip |
//! | `strip_workers` | several threads on one lattice |
//! | `strip_leapfrog`, `leapfrog`, `runge_kutta` | integrators |
//! | `stability` | the largest eigenfrequency |
//! | `recorder` | history and averages |
//! | `stationary` | where a record becomes stationary |
//! | `drive` | an integrator from start to end |
//! | `remembered` | runs that were made before |
//! | `run` | one run in the plane |
//! | `space` | the cell in space |

mod bond_rows;
mod bonds;
mod contact;
mod contact_columns;
mod contact_vectors;
mod drive;
mod engine;
mod leapfrog;
mod protocol;
mod real;
mod recorder;
mod remembered;
mod rows;
mod run;
mod runge_kutta;
mod scales;
mod space;
mod stability;
mod stationary;
mod stencil;
mod strip;
mod strip_leapfrog;
mod strip_workers;
mod sweep;

pub use drive::{
    MAX_EXTENSION_FOR_STDERR, MAX_STEPS, Plan, WAVE_DEFICIT, even_speed_m_s, max_run_speed_m_s, run_speed_m_s,
    shear_modulus_pa, shear_period_s, warm_travel_m,
};
pub use remembered::{remembered, settings};
pub use run::{DynamicRun, Scheme, usual_step_s};
pub use space::{SpaceRun, SpaceScheme};

#[cfg(test)]
mod any_width;
#[cfg(test)]
mod front_speed;
#[cfg(test)]
mod precision_tests;
#[cfg(test)]
mod properties;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod work_account;
#[cfg(test)]
mod work_balance;
