//! Effects of the specimen on a solved texture: ends, pressure tilt, and sliding in time.

use std::sync::Arc;

use slipgrid_base::monitor::Part as Share;
use slipgrid_base::units::PRESSURE_MPA;
use slipgrid_model::springblock::{Correction, Effect, LoadOutcome, Simulation, tilt_relative_error};

use super::Search;
use crate::as_cut::{CutTexture, Known};
use crate::confirmation::{confirming_scene, run_specimen};
use crate::inputs::{InputEffect, Part, known_to};
use crate::prediction::Prediction;

/// Effects whose errors a run of the specimen adds to those of its cell, which has that of the size of blocks. The error of
/// averaging over time is [`crate::inputs`]' own.
const OF_RUN: [Effect; 5] = [Effect::Layout, Effect::Rims, Effect::Time, Effect::Behind, Effect::Tilt];

impl Search<'_> {
    /// Replaces the effects of the specimen's ends and pressure tilt from the table by solved values, and adds a dynamic
    /// run in the plane, and in space a strip where the peak pressure is limited. Returns `found` as it is if the stage is
    /// cancelled.
    pub fn as_cut(&self, found: &Prediction) -> Prediction {
        if found.texture.known == Known::AsCut {
            return found.clone();
        }
        let ratios = found.texture.limited.iter().flat_map(|answer| &answer.ratio).copied().collect::<Vec<f64>>();
        let by_table = self.table.by_face(&found.texture.pattern, &ratios);
        let cell = found.texture.clone().moved(&by_table.iter().map(|by| -by).collect::<Vec<f64>>());
        let pattern = cell.pattern;
        let in_plane = self.models.own.dimension().takes_strips();
        // In space the peak pressure is that of the cell, unless a strip shows its outer lands.
        let has_ends = in_plane || self.task.search.strip && self.limits_peak();
        let run = self.beyond.face.as_ref().filter(|_| has_ends).and_then(|face| {
            let scene = confirming_scene(self.prepared, self.models.own, &pattern, false);
            run_specimen(&scene, face, &Share::new(self.stage, 0.0)).ok().map(Arc::new)
        });
        if let Some(run) = run.as_ref().filter(|_| in_plane)
            && let Some(by_run) = self.beyond.by_run(&cell.ratio, run)
        {
            let mut parts = cell.parts.clone();
            parts.extend(OF_RUN.iter().filter_map(|effect| self.of_effect(*effect, &log_stds(*effect, run))));
            return self.predicted(self.as_run(cell.moved(&by_run).with_parts(parts), run));
        }
        let (by_face, by_time) = rayon::join(
            || self.beyond.by_face(&pattern, &cell.ratio, false, self.stage),
            || self.beyond.by_time(&pattern, &cell.ratio, self.stage),
        );
        if self.stage.cancelled() {
            return found.clone();
        }
        let mut parts = cell.parts.clone();
        let texture = cell.moved(&by_face).moved(&by_time);
        if in_plane {
            return self.predicted(CutTexture { known: Known::AsCut, ..texture });
        }
        // In space the face adds the tilt alone, and the error of the layout.
        let relative = tilt_relative_error(self.task.layer.holder);
        parts.extend(self.of_effect(Effect::Tilt, &by_face.iter().map(|by| relative * by).collect::<Vec<f64>>()));
        parts
            .extend(self.of_effect(Effect::Layout, &self.beyond.layout_log_stds(&pattern, &texture.ratio, self.stage)));
        let mut texture = texture.with_parts(parts);
        let by_law = self.models.local_law_in_own_blocks(self.prepared, &pattern);
        let each = texture.sensitivity.iter_mut().zip(by_law);
        each.for_each(|(sensitivity, by_law)| sensitivity.local_law = by_law);
        self.predicted(match &run {
            Some(run) => self.as_run(texture, run),
            None => CutTexture { known: Known::AsCut, ..texture },
        })
    }

    /// Adds `run` of the specimen to `texture`, and compares the higher of its peak pressure and that of the cell with the
    /// limits: the outer lands of a specimen carry a higher pressure than an infinite pattern, and stick-slip adds to it.
    fn as_run(&self, texture: CutTexture, run: &Arc<Simulation>) -> CutTexture {
        let of_run_mpa = PRESSURE_MPA.from_si(run.peak_pressure_pa());
        let texture = self.with_peak(texture, &|of_cell_mpa| of_run_mpa.max(of_cell_mpa));
        CutTexture { known: Known::AsCut, run: Some(Arc::clone(run)), ..texture }
    }

    /// Uncertainty from `effect`, an error common to all loads and conditions: `log` has its standard deviation of ln R at
    /// each load, with the sign of the effect there. `None` without an error.
    fn of_effect(&self, effect: Effect, log: &[f64]) -> Option<Part> {
        let (n, count) = (self.asked.loads.len(), log.len());
        let most = log.iter().fold(0.0, |most: f64, own| most.max(own.abs()));
        let covariance = (0..n * n).map(|e| log[e / n % count] * log[e % n % count]).collect();
        let holder = self.task.layer.holder;
        (most > 0.0).then(|| Part {
            name: effect.name(),
            known_to: match effect {
                Effect::Tilt if holder.is_none() => "as nobody says how it is held".to_owned(),
                Effect::Tilt => known_to(tilt_relative_error(holder)),
                _ => format!("{} of the ratio", known_to(most)),
            },
            effect: InputEffect::Shared(covariance),
        })
    }
}

/// Standard deviations of ln R by `effect`, as `run` corrects it, with the sign of the correction: if the effect exceeds
/// its mean, a ratio changes in this direction.
fn log_stds(effect: Effect, run: &Simulation) -> Vec<f64> {
    let std = |own: &Correction| own.std.unwrap_or(0.0).copysign(own.change);
    let of = |load: &LoadOutcome| load.correction(effect).map_or(0.0, std) / load.ratio().unwrap_or(1.0);
    run.loads.iter().map(of).collect()
}
