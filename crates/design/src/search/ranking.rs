//! Ranking of textures spread over the bounds, by the table.

use rayon::prelude::*;
use slipgrid_model::pattern::Pattern;

use super::{STARTS, Search};
use crate::as_cut::CutTexture;
use crate::prediction::Prediction;
use crate::steps::Steps;

/// Approximate number of textures compared by the table.
const COMPARED: usize = 3000;
/// Number of compared textures that the whole mixture predicts: the best by the likeliest members of the mixture.
const PREDICTED: usize = 400;
/// Number of the best textures of every region, and of those with accepted medians, that the whole mixture predicts,
/// too.
const PREDICTED_OF_EACH: usize = 8;
/// Number of regions along each length; the best texture of each region is examined.
const REGIONS: usize = 3;
/// Minimum chance of a region's best texture by the table, as a share of the maximum chance, for the region to be
/// examined: an error of the table of one tolerance may rank a whole region too low.
const OF_CHANCE: f64 = 0.25;

impl Search<'_> {
    /// Index of the region of the bounds that contains `pattern`; regions are equal in the logarithms of the lengths.
    fn region(&self, pattern: &Pattern) -> usize {
        let bounds = self.task.space.lengths_m().into_iter();
        bounds.zip(pattern.lengths_m()).fold(0, |region, ([low, high], length_m)| {
            let share = if low < high { (length_m / low).ln() / (high / low).ln() } else { 0.0 };
            REGIONS * region + ((share * REGIONS as f64) as usize).min(REGIONS - 1)
        })
    }

    /// Returns the best `most` textures by the table and the best of every region, sorted by decreasing value, with the
    /// number of compared textures and whether one of them has accepted medians at every load. If every texture
    /// violates a limit, those with the smallest violation are returned.
    pub(super) fn ranked(
        &self,
        steps: &Steps<'_>,
        most: usize,
        open: &(dyn Fn(&Pattern) -> bool + Sync),
    ) -> (Vec<Prediction>, usize, bool) {
        let patterns = steps.spread(COMPARED);
        let draft = |pattern: &Pattern| {
            if self.stage.cancelled() || !open(pattern) { None } else { self.interpolated(pattern) }
        };
        let drafts: Vec<CutTexture> = patterns.par_iter().filter_map(draft).collect();
        let compared = drafts.len();
        let least = drafts.iter().map(|texture| texture.excess).fold(f64::INFINITY, f64::min);
        let left: Vec<CutTexture> = drafts.into_iter().filter(|texture| texture.excess <= least).collect();
        let (left, others) = self.likeliest(left);
        // Distributions of thousands of textures would fill the memory, so those of the best are recomputed.
        let one = |(place, texture): (usize, &CutTexture)| {
            let found = (!self.stage.cancelled()).then(|| self.predicted(texture.clone()))?;
            Some((place, found.value(), found.chance(), found.is_within(self.asked)))
        };
        let mut scored: Vec<(usize, f64, f64, bool)> = left.par_iter().enumerate().filter_map(one).collect();
        // The likeliest members may misjudge a median: before a target counts as out of reach, the whole mixture checks
        // the other textures, too.
        let has_median_within = |texture: &CutTexture| {
            let distribution = self.predictor.of(&texture.candidate());
            !self.stage.cancelled() && self.asked.has_medians_within(&texture.ratio, &distribution)
        };
        let is_within_reach =
            scored.iter().any(|(.., is_within)| *is_within) || others.par_iter().any(has_median_within);
        scored.sort_by(|a, b| b.1.total_cmp(&a.1).then(b.2.total_cmp(&a.2)));
        let greatest = scored.first().map_or(0.0, |(_, _, chance, _)| *chance);
        let has_chances = self.asked.goal.is_none() && least <= 0.0;
        let enough = if has_chances { OF_CHANCE * greatest } else { f64::NEG_INFINITY };
        let (mut seen, mut rank) = ([false; REGIONS.pow(3)], 0);
        scored.retain(|(place, _, chance, _)| {
            rank += 1;
            let is_first = !std::mem::replace(&mut seen[self.region(&left[*place].pattern)], true);
            rank <= most || is_first && *chance >= enough
        });
        let best = scored.par_iter().map(|(place, ..)| self.predicted(left[*place].clone())).collect();
        (best, compared, is_within_reach && least == 0.0)
    }

    /// Divides `all` into the best by the likeliest members of the mixture (of all, of every region, and of those whose
    /// medians are accepted) and the others.
    fn likeliest(&self, all: Vec<CutTexture>) -> (Vec<CutTexture>, Vec<CutTexture>) {
        if all.len() <= PREDICTED {
            return (all, Vec::new());
        }
        let one = |(place, texture): (usize, &CutTexture)| {
            let found = Prediction::new(texture.clone(), &self.of_ranking, self.asked);
            (!self.stage.cancelled()).then(|| (place, found.value(), found.is_within(self.asked)))
        };
        let mut scored: Vec<(usize, f64, bool)> = all.par_iter().enumerate().filter_map(one).collect();
        scored.sort_by(|a, b| b.1.total_cmp(&a.1));
        let (mut rank, mut within, mut of_region) = (0, 0, [0; REGIONS.pow(3)]);
        scored.retain(|(place, _, is_within)| {
            let own_region = &mut of_region[self.region(&all[*place].pattern)];
            (rank, within, *own_region) = (rank + 1, within + usize::from(*is_within), *own_region + 1);
            rank <= PREDICTED || *own_region <= PREDICTED_OF_EACH || *is_within && within <= PREDICTED_OF_EACH
        });
        let mut is_kept = vec![false; all.len()];
        scored.iter().for_each(|(place, ..)| is_kept[*place] = true);
        let (kept, others): (Vec<_>, Vec<_>) = all.into_iter().zip(is_kept).partition(|(_, is_kept)| *is_kept);
        let textures = |of: Vec<(CutTexture, bool)>| of.into_iter().map(|(texture, _)| texture).collect();
        (textures(kept), textures(others))
    }

    /// First texture of `ranked` in each region.
    pub(super) fn first_of_regions(&self, ranked: &[Prediction]) -> Vec<Pattern> {
        let mut seen = Vec::new();
        let is_new = |of: &&Prediction| {
            let region = self.region(&of.texture.pattern);
            let is_new = !seen.contains(&region);
            seen.push(region);
            is_new
        };
        ranked.iter().filter(is_new).take(STARTS).map(|of| of.texture.pattern).collect()
    }
}
