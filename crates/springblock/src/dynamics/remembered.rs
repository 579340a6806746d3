//! Runs in time that were made before.

use std::fmt::Debug;

use slipgrid_monitor::{Monitor, cached};

use crate::outcome::SurfaceOutcome;
use crate::scene::Scene;

/// What `run` gives, which is `share` of all work and follows from `content` alone; recalled where the monitor's caller
/// remembers it.
pub fn remembered(
    monitor: &dyn Monitor,
    content: &dyn Debug,
    share: f64,
    run: impl FnOnce() -> SurfaceOutcome,
) -> SurfaceOutcome {
    let known = |bytes: &[u8]| {
        let outcome = SurfaceOutcome::from_bytes(bytes)?;
        monitor.advance(share);
        Some(outcome)
    };
    cached(monitor, ("run", content), (known, SurfaceOutcome::to_bytes), run)
}

/// What a run of `scene` follows from beside its load and its lattice.
pub fn settings(scene: &Scene) -> impl Debug + '_ {
    (&scene.elastic, &scene.area_law, &scene.layer, scene.speed_m_s, &scene.run, scene.dimension().number())
}
