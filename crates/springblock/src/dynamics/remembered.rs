//! Runs in time, and other results, that were made before.

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
    let known = |bytes: &[u8]| {
        let outcome = SurfaceOutcome::from_bytes(bytes)?;
        monitor.advance(share);
        Some(outcome)
    };
    recalled(monitor, ("run", content), (known, SurfaceOutcome::to_bytes), run)
}

/// What `compute` gives, a result of `kind` that follows from `content` alone: recalled by `from_bytes` where the monitor's caller
/// remembers it, and otherwise remembered as `to_bytes` has it, which is nothing of what is not to be kept.
pub fn recalled<T>(
    monitor: &dyn Monitor,
    (kind, content): (&str, &dyn Debug),
    (from_bytes, to_bytes): (impl FnOnce(&[u8]) -> Option<T>, impl FnOnce(&T) -> Option<Vec<u8>>),
    compute: impl FnOnce() -> T,
) -> T {
    let Some(memory) = monitor.memory() else { return compute() };
    let key = Key::of(kind, content);
    if let Some(known) = memory.recall(&key).and_then(|bytes| from_bytes(&bytes)) {
        return known;
    }
    let result = compute();
    if let Some(bytes) = to_bytes(&result) {
        memory.keep(&key, &bytes);
    }
    result
}

/// What a run of `scene` follows from beside its load and its lattice.
pub fn settings(scene: &Scene) -> impl Debug + '_ {
    (&scene.elastic, &scene.area_law, &scene.layer, scene.speed_m_s, &scene.run, scene.dimensions())
}
