//! Cache of dynamic runs.

use std::fmt::Debug;

use slipgrid_base::monitor::{Monitor, cached};

use crate::springblock::{Scene, SurfaceOutcome};

/// Returns the outcome of the dynamic run `run` from the monitor's cache, or executes the run.
///
/// `content` must determine the outcome; it is the cache key. `share` is the fraction of the whole job's work that the
/// run takes. Outcomes of unfinished runs are not cached.
pub fn cached_run(
    monitor: &dyn Monitor,
    content: &dyn Debug,
    share: f64,
    run: impl FnOnce() -> SurfaceOutcome,
) -> SurfaceOutcome {
    let run = || {
        let outcome = run();
        if outcome.status.is_final() { Ok(outcome) } else { Err(Box::new(outcome)) }
    };
    cached(monitor, ("run", content), share, run).unwrap_or_else(|unfinished| *unfinished)
}

/// Settings of `scene` on which a dynamic run depends besides load and lattice, as part of a cache key.
pub fn cache_key_settings(scene: &Scene) -> impl Debug + '_ {
    (&scene.elastic, &scene.area_law, &scene.layer, scene.speed_m_s, &scene.run, scene.dimension().number())
}
