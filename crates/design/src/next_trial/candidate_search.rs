//! The designs likeliest on target: all by the interpolated model, the best by the model itself, and what lies about them.

use rayon::prelude::*;
use slipgrid_discrepancy::{DimensionShift, Features, Predictor, Ranking};
use slipgrid_monitor::{Monitor, Part};
use slipgrid_optimize::ModelFailure;
use slipgrid_pattern::Pattern;

use super::interpolation::{Interpolation, Modelled, Models};
use super::local_search::{Climb, Known, Place, Steps, climb};
use super::{Asked, BeyondCells, Design, Judged};
use crate::chance::{About, Chances, Numerical};
use crate::task::DesignTask;

/// How much is looked at.
pub struct Scope {
    /// Most nodes of the interpolated model's lattice along width, spacing and depth.
    pub nodes: [usize; 3],
    /// The same of what smaller blocks change, some hundredths of a second each.
    pub blocks: [usize; 3],
    /// The same of what ends and tilt change.
    pub face: [usize; 3],
    /// Designs that are compared by it, about.
    pub designs: usize,
    /// Of these the best by it, which the model itself judges, beside the best of every region.
    pub judged: usize,
    /// Of these the best of different regions, from which is climbed.
    pub starts: usize,
    /// Designs that the model judges while climbing, at most.
    pub climbed: usize,
    /// Of the best by that, of which everything counts.
    pub completed: usize,
    /// Designs of which everything counts while climbing once more, at most.
    pub climbed_whole: usize,
}

impl Scope {
    /// In the plane, where a node takes some milliseconds.
    pub const PLANE: Self = Self {
        nodes: [13, 13, 9],
        blocks: [6, 6, 3],
        face: [5, 5, 2],
        designs: 6000,
        judged: 48,
        starts: 6,
        climbed: 900,
        completed: 16,
        climbed_whole: 80,
    };
    pub const SPACE: Self = Self { nodes: [6, 6, 4], climbed: 80, starts: 2, climbed_whole: 26, ..Self::PLANE };
    /// Beside a design that was searched.
    pub const BESIDE: Self = Self {
        nodes: [9, 9, 5],
        blocks: [5, 5, 3],
        face: [4, 4, 2],
        designs: 2000,
        judged: 24,
        completed: 8,
        ..Self::PLANE
    };
}

/// Regions along each length of which the best design is judged by the model itself: where the interpolated one is off by a tolerance it
/// may rank a whole region too low.
const REGIONS: usize = 3;
/// Share of a chance that a design's must have by the interpolated model for the model itself to judge it beside others of that chance.
const OF_CHANCE: f64 = 0.25;
/// The same by the model itself, for everything that counts to be found: that, and a climb over single blocks after it, change chances by
/// hundredths of themselves.
const OF_WHOLE_CHANCE: f64 = 0.5;
/// Lengths that differ by less are the same, relative.
const SAME_LENGTH: f64 = 1e-3;

/// Whether two textures are one: trials know their features alone.
pub fn is_same(a: &Features, b: &Features) -> bool {
    let same = |of: fn(&Features) -> f64| (of(a) - of(b)).abs() <= SAME_LENGTH * of(a).max(of(b));
    same(|of| of.width_m) && same(|of| of.pitch_m) && same(|of| of.depth_m) && same(|of| of.areal_density)
}

/// What is asked, and what answers.
pub struct Search<'a> {
    pub task: &'a DesignTask,
    pub asked: &'a Asked,
    predictor: Predictor,
    models: &'a Models<'a>,
    beyond: &'a BeyondCells<'a>,
    interpolation: &'a Interpolation,
    /// What is not known exactly beside what trials tell of.
    chances: &'a Chances<'a>,
    scope: &'a Scope,
    /// Whom it reports to, and who ends it.
    pub stage: &'a dyn Monitor,
}

impl<'a> Search<'a> {
    pub fn new(
        task: &'a DesignTask,
        asked: &'a Asked,
        (models, beyond): (&'a Models<'a>, &'a BeyondCells<'a>),
        chances: &'a Chances<'a>,
        (interpolation, scope): (&'a Interpolation, &'a Scope),
        stage: &'a dyn Monitor,
    ) -> Self {
        let predictor = asked.learned.at(&asked.loads);
        Self { task, asked, predictor, models, beyond, interpolation, chances, scope, stage }
    }

    /// Errors of the dimensions of samples of `pattern`, by the interpolated model.
    fn dimension_shifts(&self, pattern: &Pattern) -> Option<Vec<DimensionShift>> {
        let tolerances = self.task.tolerances.map(|scatter| scatter.tolerances).unwrap_or_default();
        self.interpolation.dimension_shifts(pattern, &tolerances)
    }

    /// `pattern` by the model itself in the layer's blocks and what smaller ones change of its like, with the scatter of its dimensions.
    fn drafted(&self, pattern: &Pattern) -> Result<Judged, ModelFailure> {
        let shifts = self.dimension_shifts(pattern).unwrap_or_default();
        let design = Design::new(*pattern, self.models.at(pattern)?, Vec::new(), shifts);
        let design = design.in_smaller_blocks(self.interpolation.shifts(pattern.lengths_m()));
        let design = design.moved(&self.interpolation.by_face(pattern.lengths_m()));
        Ok(design.judged(&self.predictor, &self.asked.wanted))
    }

    /// `pattern` in blocks as small as the model can have, with everything that is not known exactly.
    pub fn exactly(&self, pattern: &Pattern) -> Result<Judged, ModelFailure> {
        self.completed(self.drafted(pattern)?)
    }

    /// The same of a draft.
    fn completed(&self, draft: Judged) -> Result<Judged, ModelFailure> {
        let Judged { design: Design { pattern, in_blocks: mut ratio, sensitivity, .. }, .. } = draft;
        let still = self.chances.still(&pattern)?;
        let open = match self.models.refined(&pattern) {
            Some((shifts, open)) => {
                ratio.iter_mut().zip(shifts).for_each(|(ratio, shift)| *ratio += shift);
                Numerical::in_common(open)
            }
            None => self.chances.numerical_of(&pattern, &still, &Numerical::in_common(vec![0.0; ratio.len()]))?,
        };
        let about = About { design: &pattern, still: &still, values: &ratio, numerical: &open };
        let expansion = self.chances.expand(&about)?;
        let shifts = self.chances.dimension_shifts(&expansion);
        let log_ratio = ratio.iter().map(|ratio| ratio.ln()).collect();
        let modelled = Modelled { log_ratio, sensitivity };
        let design = Design::new(pattern, modelled, self.chances.log_covariance(&expansion), shifts);
        let design = design.moved(&self.interpolation.by_face(pattern.lengths_m()));
        Ok(design.judged(&self.predictor, &self.asked.wanted))
    }

    /// The region of the bounds that `pattern` lies in, by the logarithms of its lengths.
    fn region(&self, pattern: &Pattern) -> usize {
        let bounds = self.task.space.lengths_m().into_iter();
        bounds.zip(pattern.lengths_m()).fold(0, |region, ([low, high], length_m)| {
            let share = if low < high { (length_m / low).ln() / (high / low).ln() } else { 0.0 };
            REGIONS * region + ((share * REGIONS as f64) as usize).min(REGIONS - 1)
        })
    }

    /// What looks best by the interpolated model, the best of every region among it, and how many were compared. Designs of less than
    /// `least_chance` are passed by, and of regions those of less than [`OF_CHANCE`] of the greatest. About so many `designs` are compared.
    fn looked_over(
        &self,
        is_open: &dyn Fn(&Pattern) -> bool,
        least_chance: f64,
        designs: usize,
    ) -> (Vec<Pattern>, usize) {
        let all = Steps::new(self.task).spread(designs);
        let patterns: Vec<Pattern> = all.into_iter().filter(is_open).collect();
        let between = |pattern: &Pattern| {
            if self.stage.cancelled() {
                return None;
            }
            let lengths_m = pattern.lengths_m();
            let shifts = self.dimension_shifts(pattern)?;
            let design = Design::new(*pattern, self.interpolation.at(lengths_m)?, Vec::new(), shifts);
            let design = design.in_smaller_blocks(self.interpolation.shifts(lengths_m));
            Some(design.moved(&self.interpolation.by_face(lengths_m)))
        };
        let drafts: Vec<Option<Design>> = patterns.par_iter().map(between).collect();
        let left: Vec<Design> = drafts.into_iter().flatten().collect();
        let candidate = |place: usize| (!self.stage.cancelled()).then(|| left[place].candidate());
        let mut ranking = Ranking::new(&self.predictor, &self.asked.wanted, least_chance, left.len(), &candidate);
        let found = ranking.best(self.scope.judged, least_chance, &|_| true);
        let enough = found.iter().fold(least_chance, |most, of| most.max(OF_CHANCE * of.score.chance));
        let mut best: Vec<usize> = found.into_iter().map(|of| of.place).collect();
        // The best of a region that is among the best is the region's best.
        let regions: Vec<usize> = left.iter().map(|design| self.region(&design.pattern)).collect();
        let mut seen: Vec<usize> = best.iter().map(|place| regions[*place]).collect();
        for region in 0..REGIONS.pow(3) {
            if !seen.contains(&region) {
                seen.push(region);
                best.extend(ranking.best(1, enough, &|place| regions[place] == region).into_iter().map(|of| of.place));
            }
        }
        (best.into_iter().map(|place| left[place].pattern).collect(), left.len())
    }

    /// What `judge` says of each of `all`, as a fifth of the stage; of none once that is cancelled.
    fn each<T: Send>(&self, all: Vec<T>, judge: &(dyn Fn(T) -> Result<Judged, ModelFailure> + Sync)) -> Vec<Judged> {
        let (part, share) = (Part::new(self.stage, 0.2), 1.0 / all.len().max(1) as f64);
        let judged = |of: T| {
            let found = if part.cancelled() { None } else { judge(of).ok() };
            part.advance(share);
            found
        };
        all.into_par_iter().map(judged).collect::<Vec<_>>().into_iter().flatten().collect()
    }

    /// `found` with ends and tilt solved for itself in place of interpolated ones, and with its own run in time where that gives one.
    pub fn as_cut(&self, found: Judged) -> Judged {
        let interpolated = self.interpolation.by_face(found.design.pattern.lengths_m());
        let cell = found.design.moved(&interpolated.iter().map(|by| -by).collect::<Vec<f64>>());
        let Design { pattern, ratio, .. } = &cell;
        let (by_face, by_time) = rayon::join(
            || self.beyond.by_face(pattern, ratio, false, self.stage),
            || self.beyond.by_time(pattern, ratio, self.stage),
        );
        cell.moved(&by_face).moved(&by_time.unwrap_or_default()).judged(&self.predictor, &self.asked.wanted)
    }

    /// The first `count` of `pool`, each by [`Self::as_cut`], the greatest score first.
    pub fn all_as_cut(&self, mut pool: Vec<Judged>, count: usize) -> Vec<Judged> {
        pool.truncate(count);
        let mut pool: Vec<Judged> = pool.into_par_iter().map(|found| self.as_cut(found)).collect();
        // Stable: of equal scores the earlier first.
        pool.sort_by(|a, b| b.score.value().total_cmp(&a.score.value()));
        pool
    }

    /// The designs of the greatest scores among those that were not cut and are `open`, at least `count` where there are as many, the greatest
    /// first, and how many were compared; what is known so far where the stage is cancelled. Designs that are far from a chance of
    /// `enough` are passed by.
    ///
    /// All are ranked by the interpolated model, the best are judged by the model itself, and from the best of these of different
    /// regions is climbed over whole blocks and bursts: first by the model in the layer's blocks and what smaller ones change of their like, then with everything that counts.
    pub fn best(&self, open: &dyn Fn(&Pattern, &Features) -> bool, enough: f64, count: usize) -> (Vec<Judged>, usize) {
        let cut: Vec<Features> = self.asked.learned.trials().iter().map(|trial| trial.features).collect();
        let is_open = |pattern: &Pattern| {
            let own = Features::from(pattern);
            !cut.iter().any(|cut| is_same(cut, &own)) && open(pattern, &own)
        };
        let part = Part::new(self.stage, 0.2);
        let (best, compared) = self.looked_over(&is_open, OF_CHANCE * enough, self.scope.designs);
        // The model itself at what looks best by the interpolated one.
        self.stage.advance(0.2);
        let mut pool = self.each(best, &|pattern| self.drafted(&pattern));
        let value = |of: &Judged| of.score.value();
        // Stable: of equal scores the earlier first.
        let sort = |pool: &mut Vec<Judged>| pool.sort_by(|a, b| value(b).total_cmp(&value(a)));
        sort(&mut pool);

        let steps = Steps::new(self.task);
        let place = |of: &Judged| steps.place(&of.design.pattern);
        let mut known: Known<Judged> = pool.iter().filter_map(|of| Some((place(of)?, Some(of.clone())))).collect();
        let mut regions = Vec::new();
        let mut starts: Vec<Place> = Vec::new();
        for of in &pool {
            let region = self.region(&of.design.pattern);
            if starts.len() < self.scope.starts && !regions.contains(&region) {
                regions.push(region);
                starts.extend(place(of));
            }
        }
        let climbed = Climb { step: 4, most: self.scope.climbed };
        let draft = |pattern: &Pattern| self.drafted(pattern).ok();
        let ends = climb(&steps, &starts, climbed, &mut known, (&is_open, &draft, &value), &part);
        // What the climbs ended at, before what was known: neighbours of one design would crowd out all others.
        let is_known = |pool: &[Judged], of: &Judged| pool.iter().any(|own| own.design.pattern == of.design.pattern);
        let ended = ends.iter().filter_map(|end| known.get(end).cloned().flatten());
        let mut first: Vec<Judged> = ended.collect();
        pool.retain(|of| !is_known(&first, of));
        first.append(&mut pool);
        first.retain(|of| of.score.chance >= OF_WHOLE_CHANCE * enough);
        sort(&mut first);
        first.truncate(self.scope.completed.max(2 * count));
        let mut pool = self.each(first, &|draft| self.completed(draft));
        sort(&mut pool);

        let mut known: Known<Judged> = pool.iter().filter_map(|of| Some((place(of)?, Some(of.clone())))).collect();
        let start: Vec<Place> = pool.first().and_then(place).into_iter().collect();
        let climbed = Climb { step: 1, most: self.scope.climbed_whole };
        let whole = |pattern: &Pattern| self.exactly(pattern).ok();
        let ends = climb(&steps, &start, climbed, &mut known, (&is_open, &whole, &value), &part);
        let ended: Vec<Judged> = ends.iter().filter_map(|end| known.get(end).cloned().flatten()).collect();
        pool.extend(ended.into_iter().filter(|of| !is_known(&pool, of)).collect::<Vec<_>>());
        sort(&mut pool);
        (pool, compared)
    }
}
