//! The best of the designs on target: the one that a cut sample of is likeliest on target, and of those alike the one that
//! takes the laser least.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};
use slipgrid_export::laser_time_s;
use slipgrid_optimize::{
    Candidate, Choice, CommonDraws, Merits, ModelFailure, Probability, SearchError, SearchOutcome, Selection,
    SelectionOptions, Status, select, select_multi_fidelity,
};
use slipgrid_pattern::Pattern;

use crate::between_designs::unlike_those_before;
use crate::chance::{About, Chances, Expansion, Numerical};
use crate::multi_fidelity::MultiFidelityLoop;
use crate::task::DesignTask;
use crate::time_budget::SEARCH_SHARE;
use crate::timings::Timings;
use slipgrid_units::{significant, tidy};

/// Draws that designs are compared by.
const DRAWS: usize = 4000;
/// By how much a ratio of the steady model is taken to be off before it is confirmed in time: confirming runs differ by 0.001
/// to 0.004. Designs at the edge of what is accepted lose by it.
const NUMERICAL_STD: f64 = 0.002;
/// Distance from which designs that a search went through are unlike: a fifth of a width or a spacing, a tenth of a depth.
const UNLIKE: f64 = 0.2;
/// Misfit of the steady model from which a design may fail its confirming run: its chance counts that too.
const NEAR_THE_EDGE: f64 = 0.9;
/// Lattice in space, where a design of the guide takes some milliseconds.
const NODES_IN_SPACE: usize = 80;

/// What was chosen from, as result.json holds it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SelectionReport {
    /// What was chosen and why, in one line.
    pub words: String,
    /// Designs that the search's model, or its guide, evaluated.
    pub designs: usize,
    /// Number of designs on target that were compared.
    pub on_target: usize,
    /// The chance of the chosen design about the steady model, before it was confirmed.
    pub chance: f64,
    /// Of the design that comes first where effort does not count: chances count in proportion to how likely the run in time
    /// is to confirm the design.
    pub greatest_chance: f64,
    /// Chances that differ by less than this count as equal.
    pub alike: f64,
    /// What decides among those: `laser_time_s` or `cavity_volume_mm3`.
    pub effort: Cow<'static, str>,
    /// Of the chosen design.
    pub effort_value: f64,
    /// Of the design with the greatest chance.
    pub effort_of_greatest_chance: f64,
}

/// What making a design takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effort {
    /// Seconds under the laser.
    LaserTime,
    /// Cubic millimetres of cavities on the specimen: nobody says how fast the laser is.
    Volume,
}

impl Effort {
    const fn name(self) -> &'static str {
        match self {
            Self::LaserTime => "laser_time_s",
            Self::Volume => "cavity_volume_mm3",
        }
    }

    const fn words(self) -> [&'static str; 2] {
        match self {
            Self::LaserTime => ["time under the laser", "s"],
            Self::Volume => ["volume of cavities", "mm3"],
        }
    }

    /// What `pattern` takes on the specimen of `design`, in seconds or cubic millimetres.
    ///
    /// # Errors
    /// [`ModelFailure::Trial`] where the specimen cannot take it, or the laser's data give no time.
    pub fn of(self, design: &DesignTask, pattern: &Pattern) -> Result<f64, ModelFailure> {
        let trial = |reason: String| ModelFailure::Trial { reason };
        let layout = design.specimen.layout(*pattern).map_err(|error| trial(error.to_string()))?;
        match self {
            Self::LaserTime => {
                laser_time_s(&layout, &design.laser).ok_or_else(|| trial("the laser's time is not known".to_owned()))
            }
            Self::Volume => Ok(layout.cavity_volume_m3() * 1e9),
        }
    }
}

/// Whether designs of `design` on target are chosen among: the one asked for is not the one that a goal, or the greatest yield, names.
pub const fn is_wanted(design: &DesignTask) -> bool {
    design.target.goal().is_none() && !design.robust
}

/// How finely the space is looked at, with a guide or without.
pub fn options(is_guided: bool) -> SelectionOptions {
    let usual = SelectionOptions::default();
    if is_guided { SelectionOptions { nodes: NODES_IN_SPACE, ..usual } } else { usual }
}

/// What designs of one search are chosen by.
struct ByChance<'a> {
    design: &'a DesignTask,
    chances: &'a Chances<'a>,
    draws: CommonDraws,
    numerical: Numerical,
    /// Misfit up to which a confirming run is not expected to fail.
    safe_misfit: f64,
    effort: Effort,
}

impl ByChance<'_> {
    /// The chance of `candidate` by its expansion, and the share of it that counts.
    fn counted(&self, candidate: &Candidate, expansion: &Expansion) -> (Probability, f64) {
        let values = &candidate.response.value;
        let all = self.chances.share(&self.draws, expansion, &|_| true);
        if candidate.misfit.max <= self.safe_misfit {
            return (all, 1.0);
        }
        // How the ratio changes with the blocks, the confirming run has in common with the steady model.
        (all, self.chances.share_of_run(&self.draws, &candidate.design, values, &self.numerical).share)
    }
}

impl Merits for ByChance<'_> {
    fn expect(&self, candidates: &[Candidate]) {
        self.chances.learn(candidates.iter().map(|candidate| candidate.design));
    }

    fn rough_chance(&self, candidate: &Candidate) -> Option<Result<(Probability, f64), ModelFailure>> {
        let (design, values) = (&candidate.design, &candidate.response.value);
        let expansion = self.chances.expand_roughly(design, values, &self.numerical);
        Some(expansion.map(|expansion| self.counted(candidate, &expansion)))
    }

    fn chance(&self, candidate: &Candidate) -> Result<(Probability, f64), ModelFailure> {
        let values = &candidate.response.value;
        let still = self.chances.still(&candidate.design)?;
        let numerical = self.chances.numerical_of(&candidate.design, &still, &self.numerical)?;
        let about = About { design: &candidate.design, still: &still, values, numerical: &numerical };
        Ok(self.counted(candidate, &self.chances.expand(&about)?))
    }

    fn effort(&self, design: &Pattern) -> Result<f64, ModelFailure> {
        self.effort.of(self.design, design)
    }
}

impl MultiFidelityLoop<'_> {
    /// `outcome` with the best of the designs on target, where it met a target without a goal and the design does not ask for
    /// the robust one.
    ///
    /// # Errors
    /// As [`select`].
    pub(super) fn choose(
        &mut self,
        design: &DesignTask,
        outcome: SearchOutcome,
        timings: &mut Timings,
    ) -> Result<SearchOutcome, SearchError> {
        self.round.selection = None;
        let is_wanted = is_wanted(design) && outcome.status == Status::Met;
        let Some(chances) = self.chances.as_ref().filter(|_| is_wanted && !self.out_of_time) else {
            return Ok(outcome);
        };
        let bar = self.budget.stage_of_share("choice", SEARCH_SHARE);
        let has_time = Effort::LaserTime.of(design, &outcome.best.design).is_ok();
        let merits = ByChance {
            design,
            chances,
            draws: chances.draws(DRAWS, design.seed),
            // Another design may differ by half of what the last one did.
            numerical: Numerical::scattered(
                chances.scale().iter().map(|scale| (scale * NUMERICAL_STD).max(0.5 * self.missed)).collect(),
            ),
            safe_misfit: if self.missed > 0.0 { 0.0 } else { NEAR_THE_EDGE },
            effort: if has_time { Effort::LaserTime } else { Effort::Volume },
        };
        let (target, space, constraints, known) =
            (&design.target, &design.space, &design.constraints, &outcome.meeting);
        let found = match self.model.guide() {
            None => {
                let (options, known) = (options(false), unlike(known));
                select(target, space, constraints, &known, &options, &self.model, &merits, &bar)
            }
            Some((guide, _)) => {
                let options = options(true);
                let (model, correction) = (&self.model, &mut self.correction);
                select_multi_fidelity(
                    target,
                    space,
                    constraints,
                    known,
                    &options,
                    model,
                    &guide,
                    correction,
                    &merits,
                    &bar,
                )
            }
        };
        timings.choice += bar.finish();
        let selection = found?;
        // What was found before the time was spent is as good as any; the search itself has ended.
        let Some(chosen) = selection.pool.first().map(|choice| choice.candidate.clone()) else { return Ok(outcome) };
        let alternatives = selection.alternatives.clone();
        self.round.selection = Some(Chosen { selection, effort: merits.effort });
        Ok(SearchOutcome { best: chosen, alternatives, ..outcome })
    }
}

/// Those of `known` that are unlike better ones: a search ends among many that are alike.
fn unlike(known: &[Candidate]) -> Vec<Candidate> {
    let mut known = known.to_vec();
    known.sort_by(|a, b| a.misfit.merit.total_cmp(&b.misfit.merit));
    let mut is_unlike = unlike_those_before(Vec::new(), UNLIKE);
    known.retain(|candidate| is_unlike(&candidate.design));
    known
}

/// What was chosen from, and by what effort.
#[derive(Clone, Debug)]
pub struct Chosen {
    /// The designs, the chosen one first.
    pub selection: Selection,
    /// What decides among those alike.
    pub effort: Effort,
}

impl Chosen {
    /// The choice as it is reported.
    #[must_use]
    pub fn report(&self) -> Option<SelectionReport> {
        let pool = &self.selection.pool;
        let chosen = pool.first()?;
        // As designs are ranked: a chance counts for less where the run in time is likely to refuse the design.
        let counted = |choice: &Choice| choice.chance.share * choice.counts;
        let greatest = pool.iter().reduce(|best, next| if counted(next) > counted(best) { next } else { best })?;
        let is_weighed = pool.iter().any(|choice| choice.counts < greatest.counts);
        let [effort, unit] = self.effort.words();
        let words = format!(
            "chosen of {} designs on target by the model: it has the least {effort}, {} {unit}, of those whose chance{} is within \
             {:.1} % of the greatest by the steady model; the likeliest of all takes {} {unit}",
            pool.len(),
            significant(chosen.effort, 3),
            if is_weighed { " to be confirmed in time and then on target" } else { "" },
            100.0 * self.selection.alike,
            significant(greatest.effort, 3),
        );
        Some(SelectionReport {
            words,
            designs: self.selection.designs,
            on_target: pool.len(),
            chance: tidy(chosen.chance.share),
            greatest_chance: tidy(greatest.chance.share),
            alike: tidy(self.selection.alike),
            effort: self.effort.name().into(),
            effort_value: tidy(chosen.effort),
            effort_of_greatest_chance: tidy(greatest.effort),
        })
    }
}
