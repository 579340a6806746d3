//! The spring-block model of sliding friction, in the vertical plane along the sliding direction or in space.
//!
//! A square mesh of blocks with springs to their eight neighbours represents an elastic layer between a rigid
//! counterface and a rigid bulk (Balestra et al., J. Tribol. 144, 031704). For patterns other than grooves across the
//! sliding direction, a cubic mesh with springs to eighteen neighbours is used. A sliding block on the counterface has
//! the friction
//!
//! ```text
//! F_friction = mu_d f(p) F_n,     p = F_n / l^2
//! ```
//!
//! with the local dynamic coefficient mu_d, the area factor f, the normal force F_n and the lattice spacing l. The
//! friction coefficient of the surface is the sum of friction over the sum of normal force.
//!
//! | type | role |
//! |---|---|
//! | [`Scene`] | parameters of a simulation |
//! | [`simulate`] | solves a scene at every load, together with the flat surface |
//! | [`steady_ratios`] | ratios of a steady cell only |
//! | [`Face`], [`Strip`], [`simulate_specimen`] | whole specimens as they are cut, strip by strip |
//! | [`simulate_strip`] | a row of cavities in space with both ends of the specimen |
//! | [`Simulation`], [`LoadOutcome`], [`SurfaceOutcome`] | results, with a [`Status`] |
//! | [`Dimension`] | plane or space, and properties that depend on the choice |
//! | [`SteadyCell`], [`CellOutcome`] | steady ratio of many patterns, in the plane or in space, for searches |
//! | [`SpaceLattice`], [`SpaceSteadyModel`] | one cell in space: geometry, pressures and displacements |
//! | [`expense`], [`bounded`] | estimated cost of a scene, and its limits |
//! | [`Monitor`] | clock, progress, cancellation |
//!
//! This module is independent of optimization. It opens no files, reads no clock, and prints nothing.
//!
//! If the area law gives every block of the land the same friction at any pressure, f(p) = p0 / p, friction is
//! proportional to the land area. The ratio of the patterned to the flat surface is then the land fraction, 1 - width /
//! pitch, for any distribution of pressure:
//!
//! ```
//! use slipgrid_model::material::{AreaLaw, Elastic, LocalFriction};
//! use slipgrid_model::pattern::{Pattern, Planform};
//! use slipgrid_model::springblock::{Layer, Load, RunOptions, Scene, Unwatched, simulate};
//! let mut scene = Scene {
//!     elastic: Elastic::new(0.38e9, 900.0)?,
//!     // The real contact area is complete from 0.1 MPa on: above its last pressure f is proportional to 1/p.
//!     area_law: Some(AreaLaw::new(vec![0.05e6, 0.1e6], vec![1.0, 0.5])?),
//!     pattern: Some(Pattern::new(Planform::Groove, 130e-6, 370e-6, 20e-6)?),
//!     relief: None,
//!     layer: Layer { length_m: 9960e-6, height_m: 200e-6, block_m: 10e-6, thickness_m: None, holder: None },
//!     loads: vec![Load { pressure_pa: 2.6e6, friction: LocalFriction::new(0.30, 0.27, 0.05)? }],
//!     speed_m_s: 2e-3,
//!     run: RunOptions::default(),
//! };
//! let saturated = simulate(&scene, &Unwatched)?.loads[0].ratio().unwrap();
//! assert!((saturated - (1.0 - 130.0 / 500.0)).abs() < 1e-9);
//!
//! // Without an area law friction is proportional to load (Amontons and Coulomb), and no pattern changes it.
//! scene.area_law = None;
//! let proportional = simulate(&scene, &Unwatched)?.loads[0].ratio().unwrap();
//! assert!((proportional - 1.0).abs() < 1e-9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod cell;
mod columns;
mod dimension;
mod draws;
mod dynamics;
mod error;
mod face;
mod lattice;
mod outcome;
mod rims;
mod run_options;
mod scene;
mod simulate;
mod space;
mod steady;

pub use cell::{CellOutcome, SteadyCell};
pub(crate) use columns::Column;
pub use dimension::Dimension;
pub(crate) use draws::Coefficients;
pub use draws::phase_scatter;
pub use dynamics::{
    MAX_EXTENSION_FOR_STDERR, MAX_STEPS, WAVE_DEFICIT, even_speed_m_s, max_run_speed_m_s, run_speed_m_s,
    shear_modulus_pa, shear_period_s, warm_travel_m,
};
pub use error::SceneError;
pub use face::{Face, Strip};
pub(crate) use lattice::Lattice;
pub use outcome::{
    Correction, DynamicCost, Effect, InterfacePoint, LoadOutcome, Simulation, Statements, Status, SurfaceOutcome,
    TracePoint,
};
pub use run_options::{Extent, Fidelity, RunOptions, Springs, read_dimensions};
pub use scene::{Holder, Layer, Load, MAX_BLOCKS, MAX_DRAWS, MAX_ROWS, Scene};
pub use simulate::{
    BlockRefinement, Expense, add_tilt, block_refinement, bounded, can_refine, cell_expense, expense, planned_steps,
    simulate, simulate_specimen, simulate_strip, steady_face_bytes, steady_face_ratios, steady_ratios,
    tilt_relative_error, tilt_shifts, time_changes,
};
pub use slipgrid_base::monitor::{Cancelled, Monitor, Unwatched};
pub use space::{SpaceBond, SpaceLattice, SpaceLoad, SpaceSpring, SpaceSteadyModel};
pub(crate) use steady::{SteadyLoad, SteadyModel};

/// Fixtures of tests.
#[cfg(test)]
mod tests {
    pub mod samples;
}
