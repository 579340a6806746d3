//! Of the designs on target the one that a made sample of is likeliest on target, and of those alike the least effort.
//!
//! Designs on target fill a thin shell of the space. It is looked for along one dimension (the spacing, where it is free)
//! at every node of a lattice of the others, by the secant method on the mean residual; then about the best found, in
//! ever smaller steps.

mod count;

pub use self::count::SelectionCount;
use crate::evaluation_archive::{Key, key};
use crate::low_discrepancy::MOST_DIMENSIONS;
use crate::multi_fidelity::Corrected;
use crate::space::Grid;
use crate::trade_offs::lattice_of;
use crate::{
    Candidate, Constraints, DesignSpace, ForwardModel, LowFidelityCorrection, ModelFailure, Probability, SearchError,
    Target, summary,
};
use rayon::prelude::*;
use slipgrid_monitor::{Monitor, Part};
use slipgrid_pattern::Pattern;
use std::collections::BTreeMap;

/// What designs on target are chosen by. As with [`ForwardModel`], they are asked of from several threads at once and
/// equal designs give equal answers.
pub trait Merits: Sync {
    /// The chance that what is made of `candidate` is on target, and the share of it that counts in the choice: less than 1
    /// of a design that a dearer model may refuse. Only how the shares of designs compare matters.
    ///
    /// # Errors
    /// [`ModelFailure::Trial`] for a design that is not to be chosen; otherwise as [`ForwardModel::respond`].
    fn chance(&self, candidate: &Candidate) -> Result<(Probability, f64), ModelFailure>;

    /// Hears of the candidates whose rough chances will be asked for, before they are: what they have in common may be found once.
    fn expect(&self, _: &[Candidate]) {}

    /// The same as [`Merits::chance`], roughly, where that takes less: of the many that are compared. Those that come first are asked of
    /// exactly.
    fn rough_chance(&self, _: &Candidate) -> Option<Result<(Probability, f64), ModelFailure>> {
        None
    }

    /// What making `design` takes, the less the better.
    ///
    /// # Errors
    /// As [`Merits::chance`].
    fn effort(&self, design: &Pattern) -> Result<f64, ModelFailure>;
}

/// How finely the space is looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SelectionOptions {
    /// Nodes of the lattice at which the shell is looked for, about; a node takes some eight designs.
    pub nodes: usize,
    /// Times that the surroundings of the best are looked at, each time half as wide.
    pub refinements: usize,
    /// Chances that differ by less are alike; at least two standard errors are.
    pub alike: f64,
}

impl Default for SelectionOptions {
    fn default() -> Self {
        Self { nodes: 120, refinements: 3, alike: 0.01 }
    }
}

/// A design on target.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// The design, with what the model says of it.
    pub candidate: Candidate,
    /// The chance that what is made of it is on target.
    pub chance: Probability,
    /// The share of the chance that counts in the choice.
    pub counts: f64,
    /// Both are [rough](Merits::rough_chance).
    pub is_rough: bool,
    /// What making it takes.
    pub effort: f64,
}

/// What was chosen from.
#[derive(Clone, Debug, PartialEq)]
pub struct Selection {
    /// Designs on target, the chosen one first.
    pub pool: Vec<Choice>,
    /// The first of them that are unlike the chosen one and one another.
    pub alternatives: Vec<Candidate>,
    /// Designs that the model, or its guide, was asked of.
    pub designs: usize,
    /// Chances that differ from the greatest by less count as alike.
    pub alike: f64,
}

/// Shares of the line at which the shell is looked for first.
const LINE: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];
/// Secant steps towards the middle of the shell.
const SECANT_STEPS: usize = 3;
/// A secant step keeps so far from the ends of its bracket, as a share of it.
const BRACKET_END: f64 = 0.05;
/// Designs of one line whose chance, which is dearer, is asked for: those that miss least.
const MOST_OF_A_LINE: usize = 1;
/// Designs whose surroundings are looked at: so many by rank, and so many by chance.
const REFINED: usize = 3;
/// Designs whose chances are not left rough: so many by rank, and so many by chance.
const SETTLED: usize = 6;
/// First steps along the line about a design on target, as a share of the bounds: a shell is some hundredths thick.
const LINE_STEP: f64 = 0.02;
/// Rounds in which the dear model judges what its guide found, and designs of each.
const JUDGED_ROUNDS: usize = 2;
const JUDGED: usize = 8;

/// Chooses among the designs of `space` that meet `target` under `constraints`, those of `known` among them: the greatest
/// chance by `merits`, of those alike the least effort, then the smallest largest residual. With no design on target the
/// pool is empty. Cancelled by `monitor`, the choice is made from what is known.
///
/// # Errors
/// [`SearchError`] where the space is empty, or the model is broken.
#[allow(clippy::too_many_arguments, reason = "those of a search")]
pub fn select(
    target: &Target,
    space: &DesignSpace,
    constraints: &Constraints,
    known: &[Candidate],
    options: &SelectionOptions,
    model: &dyn ForwardModel,
    merits: &dyn Merits,
    monitor: &dyn Monitor,
) -> Result<Selection, SearchError> {
    let grid = Grid::new(space, constraints)?;
    let mut shell = Shell::new(target, constraints, &grid, *options, model, merits);
    shell.take(known.to_vec())?;
    shell.search(monitor)?;
    shell.settle(monitor)?;
    let designs = shell.designs;
    Ok(selection(&grid, shell.into_pool(), designs, options.alike))
}

/// As [`select`] where `model` is dear and `guide` differs from it as `low_fidelity_correction` knows: the guide, so corrected, looks for
/// designs, and the model judges the best of them. `known` are designs by the model, and all that are chosen from are.
///
/// # Errors
/// As [`select`].
#[allow(clippy::too_many_arguments, reason = "those of a guided search")]
pub fn select_multi_fidelity(
    target: &Target,
    space: &DesignSpace,
    constraints: &Constraints,
    known: &[Candidate],
    options: &SelectionOptions,
    model: &dyn ForwardModel,
    guide: &dyn ForwardModel,
    low_fidelity_correction: &mut LowFidelityCorrection,
    merits: &dyn Merits,
    monitor: &dyn Monitor,
) -> Result<Selection, SearchError> {
    let grid = Grid::new(space, constraints)?;
    let mut judged: Vec<Candidate> = known.to_vec();
    let mut found: Vec<Pattern> = known.iter().map(|candidate| candidate.design).collect();
    let mut designs = 0;
    let share = 1.0 / JUDGED_ROUNDS as f64;
    for round in 0..JUDGED_ROUNDS {
        let correction = low_fidelity_correction.correction(&grid, target.values(), constraints.quantities.len());
        let corrected = Corrected { guide, correction, grid: &grid, failures: &[] };
        let mut shell = Shell::new(target, constraints, &grid, *options, &corrected, merits);
        let again = found.par_iter().filter_map(|design| shell.ask(design).transpose()).collect::<Result<_, _>>()?;
        shell.take(again)?;
        if round == 0 {
            shell.search(&Part::new(monitor, share))?;
        } else {
            monitor.advance(share);
        }
        designs += shell.designs;
        let pool = ranked(shell.into_pool(), options.alike);
        found = pool.iter().map(|choice| choice.candidate.design).collect();
        let unknown = |design: &&Pattern| !judged.iter().any(|known| known.design == **design);
        let asked: Vec<Pattern> = found.iter().filter(unknown).take(JUDGED).copied().collect();
        let answers: Vec<_> = asked.par_iter().map(|design| (model.respond(design), guide.respond(design))).collect();
        for (design, answers) in asked.iter().zip(answers) {
            if let (Ok(response), Ok(guided)) = answers {
                low_fidelity_correction.learn(*design, &response, &guided);
                judged.push(Candidate::new(target, constraints, *design, response));
            }
        }
        if monitor.cancelled() {
            break;
        }
    }
    let mut shell = Shell::new(target, constraints, &grid, *options, model, merits);
    shell.take(judged)?;
    shell.settle(monitor)?;
    Ok(selection(&grid, shell.into_pool(), designs, options.alike))
}

fn selection(grid: &Grid, pool: Vec<Choice>, designs: usize, alike: f64) -> Selection {
    let alike = alike_by(&pool, alike);
    let pool = ranked(pool, alike);
    let alternatives = pool.first().map_or_else(Vec::new, |chosen| {
        summary::unlike(pool.iter().map(|choice| &choice.candidate), grid, &chosen.candidate)
    });
    Selection { pool, alternatives, designs, alike }
}

impl Selection {
    /// What each design of the pool is ranked by, in its order: its chance, less by what counts of it where more counts of
    /// another's.
    #[must_use]
    pub fn merits(&self) -> Vec<f64> {
        merits(&self.pool)
    }
}

fn merits(pool: &[Choice]) -> Vec<f64> {
    let most = pool.iter().map(|choice| choice.counts).fold(f64::MIN_POSITIVE, f64::max);
    pool.iter().map(|choice| choice.chance.share * choice.counts / most).collect()
}

/// The greatest chance of `pool`.
fn greatest(pool: &[Choice]) -> Option<Probability> {
    pool.iter().map(|choice| choice.chance).reduce(|best, next| if next.share > best.share { next } else { best })
}

/// By how much chances may differ from the greatest of `pool` and count as alike.
fn alike_by(pool: &[Choice], least: f64) -> f64 {
    greatest(pool).map_or(least, |best| least.max(2.0 * best.stderr))
}

/// `pool` with the chosen design first: those alike the best by effort, then the others by what they are ranked by.
fn ranked(pool: Vec<Choice>, alike: f64) -> Vec<Choice> {
    let alike = alike_by(&pool, alike);
    let merits = merits(&pool);
    let best = merits.iter().copied().fold(0.0, f64::max);
    let mut ranked: Vec<(f64, Choice)> =
        merits.into_iter().map(|merit| (best - alike - merit).max(0.0)).zip(pool).collect();
    ranked.sort_by(|(a_lost, a), (b_lost, b)| {
        a_lost
            .total_cmp(b_lost)
            .then(a.effort.total_cmp(&b.effort))
            .then(a.candidate.misfit.max.total_cmp(&b.candidate.misfit.max))
            .then(key(&a.candidate.design).cmp(&key(&b.candidate.design)))
    });
    ranked.into_iter().map(|(_, choice)| choice).collect()
}

type Shares = [f64; MOST_DIMENSIONS];

/// What is known of the designs on target.
struct Shell<'a> {
    target: &'a Target,
    constraints: &'a Constraints,
    grid: &'a Grid,
    options: SelectionOptions,
    model: &'a dyn ForwardModel,
    merits: &'a dyn Merits,
    /// Designs on target; `None` where one is not to be chosen.
    pool: BTreeMap<Key, Option<Choice>>,
    designs: usize,
}

impl<'a> Shell<'a> {
    fn new(
        target: &'a Target,
        constraints: &'a Constraints,
        grid: &'a Grid,
        options: SelectionOptions,
        model: &'a dyn ForwardModel,
        merits: &'a dyn Merits,
    ) -> Self {
        Self { target, constraints, grid, options, model, merits, pool: BTreeMap::new(), designs: 0 }
    }

    fn into_pool(self) -> Vec<Choice> {
        self.pool.into_values().flatten().collect()
    }

    /// Looks for the shell in the whole space, then about the best designs.
    fn search(&mut self, monitor: &dyn Monitor) -> Result<(), SearchError> {
        let stages = (1 + self.options.refinements) as f64;
        let free = self.grid.free_axes();
        let Some(line) = [1, 0, 2].into_iter().find(|axis| free.contains(axis)) else { return Ok(()) };
        let others: Vec<usize> = free.into_iter().filter(|axis| *axis != line).collect();
        let (nodes, spacings) = lattice_of(self.grid, &others, self.options.nodes);
        let at_nodes = nodes.into_iter().map(|shares| (shares, LINE.to_vec())).collect();
        self.along_lines(line, at_nodes)?;
        for refinement in 1..=self.options.refinements {
            monitor.advance(1.0 / stages);
            if monitor.cancelled() {
                break;
            }
            let share = 0.5_f64.powi(i32::try_from(refinement).unwrap_or(i32::MAX));
            let mut lines: Vec<(Shares, Vec<f64>)> = Vec::new();
            for Choice { candidate: Candidate { design, .. }, .. } in self.leaders(REFINED) {
                let here = self.grid.shares(&design);
                let step = LINE_STEP * 2.0 * share;
                lines.push((here, vec![here[line] - step, here[line] + step]));
                for &axis in &others {
                    for there in self.beside(&design, axis, share * spacings[axis]) {
                        let wide = 2.0 * step;
                        lines.push((there, vec![there[line] - wide, there[line], there[line] + wide]));
                    }
                }
            }
            self.along_lines(line, lines)?;
        }
        Ok(())
    }

    /// The designs that come first: so many `by_each`, by what they are ranked by and by what they are chosen by.
    fn leaders(&self, by_each: usize) -> Vec<Choice> {
        let pool: Vec<Choice> = self.pool.values().flatten().cloned().collect();
        let mut by_merit: Vec<(f64, &Choice)> = merits(&pool).into_iter().zip(&pool).collect();
        // Stable: of equal ones in the order of the designs.
        by_merit.sort_by(|(a, _), (b, _)| b.total_cmp(a));
        let by_merit: Vec<Choice> = by_merit.into_iter().take(by_each).map(|(_, choice)| choice.clone()).collect();
        let mut leaders = ranked(pool, self.options.alike);
        leaders.truncate(by_each);
        for choice in by_merit {
            if !leaders.iter().any(|known| known.candidate.design == choice.candidate.design) {
                leaders.push(choice);
            }
        }
        leaders
    }

    /// Asks for the chances of those that come first, until none of them is rough or `monitor` cancels it.
    fn settle(&mut self, monitor: &dyn Monitor) -> Result<(), SearchError> {
        while !monitor.cancelled() {
            let rough: Vec<Choice> = self.leaders(SETTLED).into_iter().filter(|choice| choice.is_rough).collect();
            let merits = self.merits;
            let exact = rough.into_par_iter().map(|choice| (key(&choice.candidate.design), exact(merits, choice)));
            let exact: Vec<_> = exact.collect();
            let is_settled = exact.is_empty();
            // A rough chance is better than none.
            let is_cut = exact.iter().any(|(_, choice)| matches!(choice, Err(ModelFailure::Cancelled)));
            if is_settled || is_cut {
                break;
            }
            self.keep(exact)?;
        }
        Ok(())
    }

    /// Keeps what was found of designs in the pool.
    fn keep(&mut self, found: Vec<(Key, Result<Choice, ModelFailure>)>) -> Result<(), SearchError> {
        for (key, choice) in found {
            let choice = match choice {
                Ok(choice) => Some(choice),
                Err(ModelFailure::Trial { .. } | ModelFailure::Cancelled) => None,
                Err(ModelFailure::Broken { reason }) => return Err(SearchError::BrokenModel { reason }),
            };
            self.pool.insert(key, choice);
        }
        Ok(())
    }

    /// Shares to both sides of `design` along `axis`: at least one burst away where depths are counted in bursts.
    fn beside(&self, design: &Pattern, axis: usize, step: f64) -> Vec<Shares> {
        let here = self.grid.shares(design);
        let moved = [-1.0, 1.0].map(|side| {
            let mut there = here;
            there[axis] += side * step;
            there
        });
        let Some([first, last]) = self.grid.bursts().filter(|_| axis == 2) else { return moved.to_vec() };
        let own = self.grid.bursts_of(design);
        let bursts = [own.saturating_sub(1), own + 1].into_iter().filter(|bursts| (first..=last).contains(bursts));
        let design_of = |bursts: u64| self.grid.at_bursts(bursts).design(&here);
        let far = moved.iter().filter(|there| {
            self.grid.design(there).is_some_and(|design| self.grid.bursts_of(&design).abs_diff(own) > 1)
        });
        far.copied().chain(bursts.filter_map(design_of).map(|design| self.grid.shares(&design))).collect()
    }

    /// Looks along `line` at each of `starts`: shares of the other axes, and those of the line to begin with.
    fn along_lines(&mut self, line: usize, starts: Vec<(Shares, Vec<f64>)>) -> Result<(), SearchError> {
        let found: Vec<(usize, Vec<Candidate>)> = starts
            .par_iter()
            .map(|(shares, first)| self.along(line, shares, first))
            .collect::<Result<_, SearchError>>()?;
        self.designs += found.iter().map(|(asked, _)| asked).sum::<usize>();
        self.take(found.into_iter().flat_map(|(_, on_target)| on_target).collect())
    }

    /// Designs asked of along one line, and the best of those on target.
    fn along(&self, line: usize, shares: &Shares, first: &[f64]) -> Result<(usize, Vec<Candidate>), SearchError> {
        // Share, mean residual; sorted by the share.
        let mut known: Vec<(f64, f64)> = Vec::new();
        let mut on_target: Vec<Candidate> = Vec::new();
        let mut asked = 0;
        let mut look = |t: f64, known: &mut Vec<(f64, f64)>| -> Result<(), SearchError> {
            let mut there = *shares;
            there[line] = t.clamp(0.0, 1.0);
            let Some(design) = self.grid.design(&there) else { return Ok(()) };
            let t = self.grid.shares(&design)[line];
            if known.iter().any(|(share, _)| *share == t) || !self.constraints.limits.violations(&design).is_empty() {
                return Ok(());
            }
            asked += 1;
            let Some(candidate) = self.ask(&design)? else { return Ok(()) };
            known.push((t, self.target.mean_residual(&candidate.response.value)));
            known.sort_by(|a, b| a.0.total_cmp(&b.0));
            if candidate.meets_target() {
                on_target.push(candidate);
            }
            Ok(())
        };
        for &t in first {
            look(t, &mut known)?;
        }
        for _ in 0..SECANT_STEPS {
            let across = known.windows(2).filter(|pair| pair[0].1 * pair[1].1 < 0.0);
            let bracket = across.min_by(|a, b| (a[0].1 - a[1].1).abs().total_cmp(&(b[0].1 - b[1].1).abs()));
            let Some(&[(from, below), (to, above)]) = bracket else { break };
            // Where the line through both ends is zero.
            let share = (below / (below - above)).clamp(BRACKET_END, 1.0 - BRACKET_END);
            look(from + share * (to - from), &mut known)?;
        }
        on_target.sort_by(|a, b| a.misfit.max.total_cmp(&b.misfit.max));
        on_target.truncate(MOST_OF_A_LINE);
        Ok((asked, on_target))
    }

    /// `design` by the model; `None` where it cannot be computed.
    fn ask(&self, design: &Pattern) -> Result<Option<Candidate>, SearchError> {
        match self.model.respond(design) {
            Ok(response) if response.value.iter().chain(&response.limited).all(|value| value.is_finite()) => {
                Ok(Some(Candidate::new(self.target, self.constraints, *design, response)))
            }
            Ok(_) | Err(ModelFailure::Trial { .. } | ModelFailure::Cancelled) => Ok(None),
            Err(ModelFailure::Broken { reason }) => Err(SearchError::BrokenModel { reason }),
        }
    }

    /// Asks for chance and effort of those of `candidates` that are on target and not known.
    fn take(&mut self, candidates: Vec<Candidate>) -> Result<(), SearchError> {
        let mut fresh: Vec<Candidate> = Vec::new();
        for candidate in candidates {
            if candidate.meets_target() && self.pool.insert(key(&candidate.design), None).is_none() {
                fresh.push(candidate);
            }
        }
        let merits = self.merits;
        merits.expect(&fresh);
        let choice = |candidate: Candidate| {
            let effort = merits.effort(&candidate.design)?;
            let rough = merits.rough_chance(&candidate);
            let is_rough = rough.is_some();
            let (chance, counts) = rough.unwrap_or_else(|| merits.chance(&candidate))?;
            Ok(Choice { chance, counts, is_rough, effort, candidate })
        };
        let found = fresh.into_par_iter().map(|candidate| (key(&candidate.design), choice(candidate)));
        self.keep(found.collect())
    }
}

/// `choice` with the chance that is not rough.
fn exact(merits: &dyn Merits, choice: Choice) -> Result<Choice, ModelFailure> {
    let (chance, counts) = merits.chance(&choice.candidate)?;
    Ok(Choice { chance, counts, is_rough: false, ..choice })
}

#[cfg(test)]
mod tests;
