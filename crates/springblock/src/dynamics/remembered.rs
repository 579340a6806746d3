//! Runs in time that were made before.

use std::fmt::Debug;

use slipgrid_monitor::{Key, Monitor};

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
    let Some(memory) = monitor.memory() else { return run() };
    let key = Key::of("run", content);
    if let Some(known) = memory.recall(&key).and_then(|bytes| SurfaceOutcome::from_bytes(&bytes)) {
        monitor.advance(share);
        return known;
    }
    let outcome = run();
    if let Some(bytes) = outcome.to_bytes() {
        memory.keep(&key, &bytes);
    }
    outcome
}

/// What a run of `scene` follows from beside its load and its lattice.
pub fn settings(scene: &Scene) -> impl Debug + '_ {
    (&scene.elastic, &scene.area_law, &scene.layer, scene.speed_m_s, &scene.run, scene.dimensions())
}
