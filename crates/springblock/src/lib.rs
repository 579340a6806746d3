//! The spring-block model of sliding friction.

mod columns;
mod draws;
mod error;
mod lattice;
mod monitor;
mod outcome;
mod scene;
pub mod steady;

pub use error::SceneError;
pub use monitor::{Monitor, Unwatched};
pub use outcome::{
    DynamicCost, InterfacePoint, LoadOutcome, Simulation, Status, SurfaceOutcome, TracePoint,
};
pub use scene::{Extent, Fidelity, Layer, Load, RunOptions, Scene, Springs};

/// Solves `scene` at every load, beside the flat surface where it has a pattern.
///
/// Loads and surfaces run in parallel on rayon's current pool; the result does not depend on the
/// number of threads.
///
/// # Errors
/// [`SceneError`] if the scene means nothing; everything else is a [`Status`].
pub fn simulate(scene: &Scene, _monitor: &dyn Monitor) -> Result<Simulation, SceneError> {
    scene.validate()?;
    Err(SceneError::Unsupported { what: "simulate", instead: "the solver is under construction" })
}
