//! Time integration: friction at rest and in motion, from the first load to steady sliding.
//!
//! | module | content |
//! |---|---|
//! | `scales` | units: l, k, m |
//! | `protocol` | pressure ramp, rest under load, motion of the bulk |
//! | `contact` | friction law of a contact block, contact row of the plane |
//! | `bonds`, `bond_rows` | forces of linear or exact springs, row by row |
//! | `real` | single and double precision |
//! | `rows` | coefficients and state of a strip of columns |
//! | `stencil` | division of a lattice into strips, coefficients of its linear springs |
//! | `sweep` | one step for the rows of a strip, in vectors |
//! | `contact_columns` | per-column data of contact blocks |
//! | `contact_vectors` | vectorized friction on contact blocks, in the plane and in space |
//! | `strip` | one step of a strip |
//! | `strip_workers` | several threads on one lattice |
//! | `strip_leapfrog`, `leapfrog`, `runge_kutta` | integrators |
//! | `stability` | largest eigenfrequency |
//! | `recorder` | history of the friction coefficient, mean and standard error |
//! | `stationary` | start of the stationary part of a record |
//! | `engine` | interface of the integrators |
//! | `drive` | one run of an integrator |
//! | `run_cache` | cache of dynamic runs |
//! | `run` | one run in the plane |
//! | `space` | cells in space |

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
mod rows;
mod run;
mod run_cache;
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
pub use run::{DynamicRun, Scheme, default_step_s};
pub use run_cache::{cache_key_settings, cached_run};
pub use space::{SpaceRun, SpaceScheme};

#[cfg(test)]
mod precision_tests;
#[cfg(test)]
mod tests;
