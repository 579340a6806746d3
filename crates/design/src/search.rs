//! The search: the texture within bounds and limits that a cut sample of is likeliest on target.
//!
//! ```text
//! all textures by the table -> the best of every region -> climbs over whole blocks and bursts by the table
//!   -> the model itself at their ends; the table learns what it is off by -> until the best is one that was solved
//!   -> ends, tilt and time of the best; the table learns -> until the best is one that has its own
//! ```

use std::sync::Arc;

use rayon::prelude::*;
use slipgrid_discrepancy::{DimensionShift, Features, Predictor};
use slipgrid_monitor::{Monitor, Part as Share};
use slipgrid_optimize::{ModelFailure, Tolerances, Violation};
use slipgrid_pattern::Pattern;
use slipgrid_specimen::simulate_on;
use slipgrid_springblock::Simulation;

use crate::as_cut::{BeyondCells, CutTexture, Known};
use crate::band::Asked;
use crate::between_designs::BetweenDesigns;
use crate::confirmation::confirming_scene;
use crate::constraint_quantities::{ConstraintQuantity, Limited};
use crate::evaluation_cache::Answer;
use crate::inputs::{Effect, Inputs, Part};
use crate::prediction::Prediction;
use crate::prepared_task::PreparedTask;
use crate::steps::{Place, Steps, climb};
use crate::table::{Models, Table};
use crate::task::DesignTask;

/// Textures that are compared by the table, about.
const COMPARED: usize = 3000;
/// Regions along each length, of each of which the best is looked at.
const REGIONS: usize = 3;
/// The best of different regions, from which is climbed.
const STARTS: usize = 6;
/// Textures that the table is asked of while climbing, at most.
const CLIMBED: usize = 1500;
/// The best by the table that are solved beside the ends of climbs: what several samples are chosen among.
const POOL: usize = 12;
/// Rounds of climbs by the corrected table at most, and textures solved as they are cut.
const MAX_ROUNDS: usize = 16;
const MAX_AS_CUT: usize = 4;
/// Share of the greatest chance that the best of a region must have by the table to be looked at: where that is off by a tolerance it may rank a
/// whole region too low.
const OF_CHANCE: f64 = 0.25;
/// Chances that differ by less are alike: the table is off by as much.
pub const ALIKE: f64 = 0.005;
/// Textures are alike where no length differs by more than this factor, its logarithm.
const UNLIKE: f64 = 0.15;
/// Lengths that differ by less are the same, relative.
const SAME_LENGTH: f64 = 1e-3;

/// Whether two textures are one: trials know their features alone.
pub fn is_same(a: &Features, b: &Features) -> bool {
    let same = |of: fn(&Features) -> f64| (of(a) - of(b)).abs() <= SAME_LENGTH * of(a).max(of(b));
    same(|of| of.width_m) && same(|of| of.pitch_m) && same(|of| of.depth_m) && same(|of| of.areal_density)
}

/// What is asked, and what answers.
pub struct Search<'a> {
    pub prepared: &'a PreparedTask,
    pub task: &'a DesignTask,
    pub asked: &'a Asked,
    pub predictor: Predictor,
    pub models: &'a Models<'a>,
    pub beyond: &'a BeyondCells<'a>,
    pub table: &'a Table,
    pub inputs: &'a Inputs<'a>,
    pub limited: &'a Limited,
    /// Whom it reports to, and who ends it.
    pub stage: &'a dyn Monitor,
}

/// What a search found.
pub struct Found {
    /// Textures that the model itself was asked of, the greatest value first.
    pub solved: Vec<Prediction>,
    /// Textures compared by the table.
    pub compared: usize,
    /// Some median of these lies within what is accepted at every load.
    pub is_within_reach: bool,
}

/// What is known beside the table while a search goes on.
#[derive(Default)]
struct Progress {
    /// Textures that the model itself was asked of.
    solved: Vec<Prediction>,
    /// The first of these with what cutting adds to others, as far as that was asked for.
    with_cutting: Vec<Prediction>,
    /// Textures that it has no answer for.
    refused: Vec<Pattern>,
    /// What the table is off by of ln R at every load, by those that were solved.
    off: BetweenDesigns,
    /// What ends, tilt and time of their own add to that of textures solved, by those solved as they are cut.
    by_cutting: BetweenDesigns,
}

impl Progress {
    fn is_known(&self, design: &Pattern) -> bool {
        let own = Features::from(design);
        self.refused.contains(design) || self.solved.iter().any(|of| is_same(&of.texture.features, &own))
    }

    /// The covariance of what samples of the texture nearest to `design` share.
    fn covariance(&self, design: &Pattern) -> Vec<f64> {
        let apart = |of: &Prediction| -> f64 {
            let lengths = design.lengths_m().into_iter().zip(of.texture.pattern.lengths_m());
            lengths.map(|(a, b)| (a / b).ln().powi(2)).sum()
        };
        let nearest = self.solved.iter().min_by(|a, b| apart(a).total_cmp(&apart(b)));
        nearest.map_or_else(Vec::new, |of| of.texture.covariance.clone())
    }
}

impl Search<'_> {
    fn tolerances(&self) -> Tolerances {
        self.task.tolerances.unwrap_or_default()
    }

    /// How far `pattern`, of which the model says `answer`, is beyond the limits, relative to them.
    fn excess(&self, pattern: &Pattern, answer: &Answer) -> Option<f64> {
        Some(self.violations(pattern, answer).ok()?.iter().map(Violation::excess).sum())
    }

    /// The limits that `pattern` breaks, of which the model says `answer`.
    ///
    /// # Errors
    /// [`ModelFailure`] where the specimen does not take it.
    pub fn violations(&self, pattern: &Pattern, answer: &Answer) -> Result<Vec<Violation>, ModelFailure> {
        self.limited.check(pattern)?;
        Ok(self.task.constraints.violations(pattern, &self.limited.values(pattern, answer)?))
    }

    /// `pattern` by the table; `None` beside a hole.
    pub fn interpolated(&self, pattern: &Pattern) -> Option<CutTexture> {
        let (modelled, answer) = self.table.at(pattern)?;
        let shifts: Vec<DimensionShift> = self.table.dimension_shifts(pattern, &self.tolerances())?;
        let texture = CutTexture::interpolated(*pattern, modelled, shifts);
        let texture = texture.moved(&self.table.by_blocks(pattern)).moved(&self.table.by_face(pattern));
        Some(CutTexture { excess: self.excess(pattern, &answer)?, ..texture })
    }

    /// The same with what is known of textures about it.
    fn corrected(&self, pattern: &Pattern, known: &Progress) -> Option<CutTexture> {
        let texture = self.interpolated(pattern)?.moved(&known.off.at(pattern).unwrap_or_default());
        let texture = texture.moved(&known.by_cutting.at(pattern).unwrap_or_default());
        Some(CutTexture { covariance: known.covariance(pattern), ..texture })
    }

    /// The textures that were solved, the greatest value first; those that were not solved as they are cut with what cutting adds to others.
    fn ordered(&self, known: &mut Progress) -> Vec<Prediction> {
        let one = |of: &Prediction| match known.by_cutting.at(&of.texture.pattern) {
            Some(by) if of.texture.known < Known::AsCut => self.predicted(of.texture.clone().moved(&by)),
            _ => of.clone(),
        };
        let fresh: Vec<Prediction> = known.solved[known.with_cutting.len()..].par_iter().map(one).collect();
        known.with_cutting.extend(fresh);
        sorted(known.with_cutting.clone())
    }

    fn predicted(&self, texture: CutTexture) -> Prediction {
        Prediction::new(texture, &self.predictor, self.asked)
    }

    /// `pattern` by the table alone.
    pub fn roughly(&self, pattern: &Pattern) -> Option<Prediction> {
        self.interpolated(pattern).map(|texture| self.predicted(texture))
    }

    /// The same with what the table is `off` by of ln R, and with the errors `covariance` that samples share.
    pub fn roughly_with(&self, pattern: &Pattern, off: &[f64], covariance: &[f64]) -> Option<Prediction> {
        let texture = CutTexture { covariance: covariance.to_vec(), ..self.interpolated(pattern)?.moved(off) };
        Some(self.predicted(texture))
    }

    /// What the table is off by of ln R at the texture of `found`.
    pub fn off_at(&self, found: &Prediction) -> Vec<f64> {
        let table = self.interpolated(&found.texture.pattern);
        let ratios = table.iter().flat_map(|table| found.texture.ratio.iter().zip(&table.ratio));
        ratios.map(|(exact, table)| (exact / table).ln()).collect()
    }

    /// A sample of the texture of `found` that was made as `made`: its ratio differs as the model says, and the discrepancy is that of its own
    /// texture.
    pub fn made(&self, found: &Prediction, made: &Pattern) -> Option<Prediction> {
        let model = self.models.own;
        let laid = model.lay(&found.texture.pattern).ok()?;
        let [made_ratio, designed] =
            [made, &found.texture.pattern].map(|pattern| model.ratios_made(pattern, &laid).ok());
        let by: Vec<f64> = made_ratio?.iter().zip(designed?).map(|(made, designed)| (made / designed).ln()).collect();
        let (designed, features) = (&found.texture.features, Features::from(made));
        let shifts = found.texture.dimension_shifts.iter().map(|shift| shift.about(designed, &features));
        let texture = CutTexture { features, dimension_shifts: shifts.collect(), ..found.texture.clone() };
        Some(self.predicted(texture.moved(&by)))
    }

    /// `pattern` by the model itself in blocks as small as it can have, with everything that is not known exactly; ends and tilt by the table.
    ///
    /// # Errors
    /// [`ModelFailure`] where it cannot be computed.
    pub fn solved(&self, pattern: &Pattern) -> Result<Prediction, ModelFailure> {
        let modelled = self.models.at(pattern)?;
        let mut ratio: Vec<f64> = modelled.log_ratio.iter().map(|log| log.exp()).collect();
        let refined = self.models.refined(pattern);
        if let Some((shifts, _)) = &refined {
            ratio.iter_mut().zip(shifts).for_each(|(ratio, shift)| *ratio += shift);
        }
        let parts = self.inputs.parts(pattern, &ratio, refined.map(|(_, open)| open))?;
        let answer = self.models.own.steady(pattern)?;
        let excess = self.violations(pattern, &answer)?.iter().map(Violation::excess).sum();
        let texture = CutTexture::interpolated(*pattern, modelled, Vec::new()).with_parts(parts);
        let texture = CutTexture { ratio, known: Known::Solved, excess, ..texture };
        Ok(self.predicted(texture.moved(&self.table.by_face(pattern))))
    }

    /// A texture that was solved with ends and tilt of its own in place of the table's, and in the plane with its own run in time.
    pub fn as_cut(&self, found: &Prediction) -> Prediction {
        if found.texture.known == Known::AsCut {
            return found.clone();
        }
        let by_table: Vec<f64> = self.table.by_face(&found.texture.pattern).iter().map(|by| -by).collect();
        let cell = found.texture.clone().moved(&by_table);
        let pattern = cell.pattern;
        if let (Some(face), true) = (&self.beyond.face, self.models.own.dimension().takes_strips()) {
            let scene = confirming_scene(self.prepared, self.models.own, &pattern, false);
            let run = simulate_on(&scene, Some(face), &Share::new(self.stage, 0.0)).ok();
            if let Some((by_run, run)) = run.and_then(|run| Some((self.beyond.by_run(&cell.ratio, &run)?, run))) {
                let excess = cell.excess.max(self.excess_of(&run));
                let mut parts = cell.parts.clone();
                parts.extend(self.of_tilt(&run));
                let texture = cell.moved(&by_run).with_parts(parts);
                return self.predicted(CutTexture { known: Known::AsCut, excess, run: Some(Arc::new(run)), ..texture });
            }
        }
        let (by_face, by_time) = rayon::join(
            || self.beyond.by_face(&pattern, &cell.ratio, false, self.stage),
            || self.beyond.by_time(&pattern, &cell.ratio, self.stage),
        );
        self.predicted(CutTexture { known: Known::AsCut, ..cell.moved(&by_face).moved(&by_time) })
    }

    /// What is not known of how far friction tilts the pressure of the specimen of `run`: nobody says how it is held. The same share of it at all
    /// loads and conditions.
    fn of_tilt(&self, run: &Simulation) -> Option<Part> {
        let log: Vec<f64> =
            run.loads.iter().map(|load| load.tilt_error().unwrap_or(0.0) / load.ratio.unwrap_or(1.0)).collect();
        let (n, count) = (self.asked.loads.len(), log.len());
        let most = log.iter().fold(0.0, |most: f64, own| most.max(own.abs()));
        let covariance = (0..n * n).map(|e| log[e / n % count] * log[e % n % count]).collect();
        (most > 0.0).then(|| Part {
            name: "tilt of the specimen",
            known_to: "as nobody says how it is held".to_owned(),
            effect: Effect::Shared(covariance),
        })
    }

    /// How far the largest pressure of `run` is beyond its limit: the outer lands of a specimen are pressed harder than those of an endless
    /// pattern, and sliding in time adds to that.
    fn excess_of(&self, run: &Simulation) -> f64 {
        let mut limits = self.task.quantities.iter().zip(&self.task.constraints.quantities);
        let limit = limits.find(|(of, _)| **of == ConstraintQuantity::PeakPressure).map(|(_, limit)| limit);
        let most_pa = run.loads.iter().map(|load| load.surface.peak_pressure_pa).fold(0.0, f64::max);
        limit.map_or(0.0, |limit| limit.excess(most_pa).max(0.0))
    }

    /// The region of the bounds that `pattern` lies in, by the logarithms of its lengths.
    fn region(&self, pattern: &Pattern) -> usize {
        let bounds = self.task.space.lengths_m().into_iter();
        bounds.zip(pattern.lengths_m()).fold(0, |region, ([low, high], length_m)| {
            let share = if low < high { (length_m / low).ln() / (high / low).ln() } else { 0.0 };
            REGIONS * region + ((share * REGIONS as f64) as usize).min(REGIONS - 1)
        })
    }

    /// The best `most` by the table, and the best of every region, the greatest value first, how many were compared, and whether the median of one lies within what
    /// is accepted. Where every texture is beyond a limit it is those that are least so.
    fn ranked(
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
        // Distributions of thousands of textures would fill the memory: those of the best are computed again.
        let one = |(place, texture): (usize, &CutTexture)| {
            let found = (!self.stage.cancelled()).then(|| self.predicted(texture.clone()))?;
            Some((place, found.value(), found.chance()))
        };
        let mut scored: Vec<(usize, f64, f64)> = left.par_iter().enumerate().filter_map(one).collect();
        scored.sort_by(|a, b| b.1.total_cmp(&a.1));
        let greatest = scored.first().map_or(0.0, |(.., chance)| *chance);
        let has_chances = self.asked.goal.is_none() && least <= 0.0;
        let enough = if has_chances { OF_CHANCE * greatest } else { f64::NEG_INFINITY };
        let (mut seen, mut rank) = ([false; REGIONS.pow(3)], 0);
        scored.retain(|(place, _, chance)| {
            rank += 1;
            let is_first = !std::mem::replace(&mut seen[self.region(&left[*place].pattern)], true);
            rank <= most || is_first && *chance >= enough
        });
        let is_within = |texture: &CutTexture| {
            self.asked.has_medians_within(&texture.ratio, &self.predictor.of(&texture.candidate()))
        };
        // Of one that is likelier on target than not there is no need to look.
        let is_within_reach =
            greatest > 0.5 || left.par_iter().any(|texture| !self.stage.cancelled() && is_within(texture));
        let best = scored.par_iter().map(|(place, ..)| self.predicted(left[*place].clone())).collect();
        (best, compared, is_within_reach && least == 0.0)
    }

    /// The first of `ranked` of different regions.
    fn first_of_regions(&self, ranked: &[Prediction]) -> Vec<Pattern> {
        let mut seen = Vec::new();
        let is_new = |of: &&Prediction| {
            let region = self.region(&of.texture.pattern);
            let is_new = !seen.contains(&region);
            seen.push(region);
            is_new
        };
        ranked.iter().filter(is_new).take(STARTS).map(|of| of.texture.pattern).collect()
    }

    /// The textures of the greatest value among those that are `open`, the greatest first, which is solved as it is cut. What is known so far
    /// where the stage is cancelled; at least `count` of them where there are as many.
    pub fn best(&self, open: &(dyn Fn(&Pattern) -> bool + Sync), count: usize) -> Found {
        let steps = Steps::new(self.task);
        let (ranked, compared, is_within_reach) = self.ranked(&steps, POOL.max(count), open);
        self.stage.advance(0.3);
        let mut known = Progress::default();
        // What trials were cut of, too: one that was on target is likely to be again.
        let cut = self.cut().into_iter().filter(|pattern| open(pattern));
        let ends = self.climbed(&steps, self.first_of_regions(&ranked), (&known, &[]), open);
        let pool = ranked.iter().take(POOL.max(count)).map(|of| of.texture.pattern);
        self.solve(ends.into_iter().chain(cut).chain(pool).collect(), &mut known);
        self.stage.advance(0.3);
        let mut solved = self.ordered(&mut known);
        for _ in 0..MAX_AS_CUT {
            // Until the best by the corrected table is one that was solved.
            for _ in 0..MAX_ROUNDS {
                let from = solved.iter().take(STARTS / 2).map(|of| of.texture.pattern).collect();
                let mut ends = self.climbed(&steps, from, (&known, &solved), open);
                ends.retain(|end| !known.is_known(end));
                if ends.is_empty() || self.stage.cancelled() {
                    break;
                }
                self.solve(ends, &mut known);
                solved = self.ordered(&mut known);
            }
            let first = solved.first().filter(|first| first.texture.known < Known::AsCut && !self.stage.cancelled());
            let Some(pattern) = first.map(|first| first.texture.pattern) else { break };
            let Some(own) = known.solved.iter_mut().find(|of| of.texture.pattern == pattern) else { break };
            let found = self.as_cut(own);
            let by = found.texture.ratio.iter().zip(&own.texture.ratio).map(|(cut, solved)| (cut / solved).ln());
            known.by_cutting.learn([(pattern, by.collect())]);
            *own = found;
            known.with_cutting.clear();
            solved = self.ordered(&mut known);
            self.stage.advance(0.05);
        }
        // The best of those solved as they are cut, should others still promise more.
        if let Some(first) = solved.iter().position(|of| of.texture.known == Known::AsCut) {
            solved[..=first].rotate_right(1);
        }
        self.stage.advance(0.2);
        Found { solved, compared, is_within_reach }
    }

    /// The greatest value by the table, after a climb, and whether some median lies within what is accepted.
    pub fn greatest(&self) -> (Option<Prediction>, bool) {
        let steps = Steps::new(self.task);
        let (ranked, _, is_within_reach) = self.ranked(&steps, STARTS, &|_| true);
        let ends = self.climbed(&steps, self.first_of_regions(&ranked), (&Progress::default(), &[]), &|_| true);
        let all = ends.iter().filter_map(|end| self.roughly(end)).collect();
        (sorted(all).into_iter().next(), is_within_reach)
    }

    /// The textures of trials, as designs of the task: those of which the features are those of a design of its texture.
    fn cut(&self) -> Vec<Pattern> {
        let of = |features: &Features| {
            let lengths_m = [features.width_m, features.pitch_m - features.width_m, features.depth_m];
            let pattern = self.task.space.pattern(lengths_m).ok()?;
            let bounds = self.task.space.lengths_m().into_iter().zip(lengths_m);
            let is_within =
                bounds.into_iter().all(|([low, high], own)| low * (1.0 - 1e-9) <= own && own <= high * (1.0 + 1e-9));
            // Depths as they were measured need not be whole bursts.
            let is_makeable = self.task.constraints.limits.violations(&pattern).is_empty()
                && self.task.laser.check_depth(pattern.depth_m()).is_ok();
            (is_within && is_makeable && is_same(features, &Features::from(&pattern))).then_some(pattern)
        };
        self.asked.learned.trials().iter().filter_map(|trial| of(&trial.features)).collect()
    }

    /// Where climbs from `starts` end, by the table with what is `known`, and by what was `solved` itself.
    fn climbed(
        &self,
        steps: &Steps<'_>,
        starts: Vec<Pattern>,
        (known, solved): (&Progress, &[Prediction]),
        open: &(dyn Fn(&Pattern) -> bool + Sync),
    ) -> Vec<Pattern> {
        let values = solved.iter().map(|of| (&of.texture.pattern, Some(of.value())));
        let values = values.chain(known.refused.iter().map(|pattern| (pattern, None)));
        let values = values.filter_map(|(pattern, value)| Some((steps.place(pattern)?, value))).collect();
        let value = |pattern: &Pattern| Some(self.predicted(self.corrected(pattern, known)?).value());
        let starts: Vec<Place> = starts.iter().filter_map(|pattern| steps.place(pattern)).collect();
        let part = Share::new(self.stage, 0.0);
        climb(steps, &starts, CLIMBED, values, (open, &value), &part)
    }

    /// Solves those of `designs` that are not known by the model itself.
    fn solve(&self, designs: Vec<Pattern>, known: &mut Progress) {
        let mut fresh: Vec<Pattern> = Vec::new();
        for design in designs {
            let own = Features::from(&design);
            let is_fresh = !fresh.iter().any(|other| is_same(&Features::from(other), &own));
            if is_fresh && !known.is_known(&design) {
                fresh.push(design);
            }
        }
        let one = |design: &Pattern| if self.stage.cancelled() { None } else { self.solved(design).ok() };
        let answers: Vec<Option<Prediction>> = fresh.par_iter().map(one).collect();
        let mut off = Vec::new();
        for (design, found) in fresh.into_iter().zip(answers) {
            let Some(found) = found else {
                known.refused.push(design);
                continue;
            };
            off.push((design, self.off_at(&found)));
            known.solved.push(found);
        }
        known.off.learn(off.into_iter().filter(|(_, off)| !off.is_empty()));
    }

    /// The first `most` of `solved`, but of those that are alike the best alone; where these are not `least`, others after them.
    pub fn unlike(&self, solved: &[Prediction], least: usize, most: usize) -> Vec<Prediction> {
        let mut chosen: Vec<&Prediction> = Vec::new();
        for of in solved {
            let is_allowed = of.texture.excess == 0.0 || chosen.is_empty();
            let is_alike = |other: &&Prediction| {
                let lengths = of.texture.pattern.lengths_m().into_iter().zip(other.texture.pattern.lengths_m());
                lengths.into_iter().all(|(own, other)| (own / other).ln().abs() < UNLIKE)
            };
            if is_allowed && !chosen.iter().any(is_alike) {
                chosen.push(of);
            }
        }
        let is_left = |of: &&Prediction| !chosen.iter().any(|other| other.texture.pattern == of.texture.pattern);
        let lacking = least.saturating_sub(chosen.len());
        let rest: Vec<&Prediction> = solved.iter().filter(is_left).take(lacking).collect();
        chosen.into_iter().chain(rest).take(most).cloned().collect()
    }
}

/// The greatest value first; of equal ones the earlier.
fn sorted(mut all: Vec<Prediction>) -> Vec<Prediction> {
    all.sort_by(|a, b| b.value().total_cmp(&a.value()));
    all
}
