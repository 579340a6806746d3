//! Every design of a lattice, so that nobody need believe the search: whole blocks wide and apart, whole bursts deep.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use slipgrid_optimize::{Candidate, ForwardModel, ModelFailure};
use slipgrid_pattern::Pattern;
use slipgrid_springblock::Dimension;

use crate::DesignError;
use crate::job::Lattice;
use crate::multi_fidelity::MultiFidelityLoop;
use crate::steady_model::SteadyModel;
use crate::task::DesignTask;
use crate::timings::Timings;
use slipgrid_monitor::{Monitor, Stage};
use slipgrid_results::PatternReport;

/// Step of the depth where no burst gives one, in metres.
const DEPTH_STEP_M: f64 = 2e-6;
/// Most designs of a table.
const MOST_NODES: usize = 1_000_000;
/// Bounds that are whole steps but for rounding belong to the table.
const WHOLE: f64 = 1e-6;
/// A design of the table counts as better where its cost is lower by more: what a search takes for comfortable.
const BETTER: f64 = slipgrid_optimize::COMFORTABLE_RMS;

/// A table, and what it says of the design found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TableReport {
    /// Designs of the table.
    pub designs: usize,
    /// Designs that could not be computed.
    pub failed: usize,
    /// Designs that respect every limit.
    pub feasible: usize,
    /// Designs of these that also meet the target; with a goal, that do what is demanded.
    pub meeting: usize,
    /// The best of the table.
    pub best: NodeReport,
    /// The best of those within a step of the design found, in each direction; null where there is none.
    pub neighbour: Option<NodeReport>,
    /// Cost of the design found: its largest misfit in tolerances, or the goal in per cent.
    pub found_cost: f64,
    /// No design of the table is better than the one found.
    pub confirms_search: bool,
    /// The design found is on target and was chosen by its chance: less misfit alone does not make a design better.
    pub by_chance: bool,
}

/// A design of the table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NodeReport {
    /// The design.
    pub design: PatternReport,
    /// Cost of the design: its largest misfit in tolerances, or the goal in per cent.
    pub cost: f64,
    /// Largest distance from the target, in tolerances.
    pub misfit: f64,
    /// It respects every limit.
    pub feasible: bool,
}

impl From<&Candidate> for NodeReport {
    fn from(candidate: &Candidate) -> Self {
        Self {
            design: (&candidate.design).into(),
            cost: candidate.misfit.merit,
            misfit: candidate.misfit.max,
            feasible: candidate.violations.is_empty(),
        }
    }
}

/// The widths, spacings and depths of whole blocks and bursts within the bounds of `design`, and their steps, in metres.
#[must_use]
pub fn axes(design: &DesignTask) -> ([Vec<f64>; 3], [f64; 3]) {
    let (space, limits) = (&design.space, &design.constraints.limits);
    let block_m = design.layer.block_m;
    let steps_m = [block_m, block_m, limits.depth_per_burst_m.unwrap_or(DEPTH_STEP_M)];
    let axis = |[lower_m, upper_m]: [f64; 2], step_m: f64| -> Vec<f64> {
        if lower_m == upper_m {
            return vec![lower_m];
        }
        // Bounds are at most a metre: the casts are exact.
        let (first, last) = ((lower_m / step_m - WHOLE).ceil().max(1.0), (upper_m / step_m + WHOLE).floor());
        (first as u64..=last as u64).map(|step| (step as f64 * step_m).clamp(lower_m, upper_m)).collect()
    };
    let axes =
        [axis(space.width_m(), steps_m[0]), axis(space.spacing_m(), steps_m[1]), axis(space.depth_m(), steps_m[2])];
    (axes, steps_m)
}

/// The designs of a lattice, widths slowest, with the steps of width, spacing and depth in metres; one more than a million at most.
#[must_use]
pub fn lattice(design: &DesignTask) -> (Vec<Pattern>, [f64; 3]) {
    let (space, limits) = (&design.space, &design.constraints.limits);
    let ([widths, spacings, depths], steps_m) = axes(design);
    let makeable = |pattern: &Pattern| limits.violations(pattern).is_empty();
    let patterns = widths
        .iter()
        .flat_map(|width_m| spacings.iter().map(move |spacing_m| (*width_m, *spacing_m)))
        .flat_map(|(width_m, spacing_m)| depths.iter().map(move |depth_m| (width_m, spacing_m, *depth_m)))
        .filter_map(|(width_m, spacing_m, depth_m)| space.pattern([width_m, spacing_m, depth_m]).ok())
        .filter(makeable)
        .take(MOST_NODES + 1)
        .collect();
    (patterns, steps_m)
}

/// Refuses a table that cannot be made, before anything is computed.
///
/// # Errors
/// [`DesignError`] for models in space, and tables of too many designs or none.
pub fn check(design: &DesignTask) -> Result<(), DesignError> {
    if !Dimension::of(design.dimensions, design.space.texture()).is_cheap_per_design() {
        return Err(DesignError::refused(
            "a table takes the vertical plane: in space it would take hours, which a campaign with work = \"table\" spreads over machines",
        ));
    }
    match lattice(design).0.len() {
        0 => Err(DesignError::refused("no whole blocks and bursts lie within bounds and limits: the table is empty")),
        nodes if nodes > MOST_NODES => {
            Err(DesignError::refused(format!("the table has more than {MOST_NODES} designs: narrow the bounds")))
        }
        _ => Ok(()),
    }
}

impl MultiFidelityLoop<'_> {
    /// Compares the design found with every design of a lattice.
    pub(super) fn compare(
        &mut self,
        design: &DesignTask,
        timings: &mut Timings,
    ) -> Result<Option<(TableReport, Lattice)>, DesignError> {
        let Some(best) = &self.round.best else { return Ok(None) };
        let best = self.model.judged(design, best);
        let bar = self.stage("table");
        let compared = table(design, &self.model, &best, &bar);
        timings.table = bar.finish();
        self.monitor.heed()?;
        let compared = compared?;
        if compared.is_none() {
            self.cut("table");
        }
        Ok(compared)
    }
}

/// Asks `model` of every design of the lattice, and compares with `found`; `None` where `progress` ends
/// before that.
///
/// # Errors
/// [`DesignError::Failed`] where the model is broken, or can compute no design of the table.
pub fn table(
    design: &DesignTask,
    model: &SteadyModel,
    found: &Candidate,
    progress: &Stage<'_>,
) -> Result<Option<(TableReport, Lattice)>, DesignError> {
    let (patterns, steps_m) = lattice(design);
    let share = 1.0 / patterns.len() as f64;
    let answers: Vec<Result<Candidate, ModelFailure>> = patterns
        .par_iter()
        .map(|pattern| {
            let response = if progress.cancelled() { Err(ModelFailure::Cancelled) } else { model.respond(pattern) };
            progress.advance(share);
            response.map(|response| Candidate {
                design: *pattern,
                misfit: design.target.misfit(&response.value),
                violations: design.constraints.violations(pattern, &response),
                response,
            })
        })
        .collect();
    if answers.contains(&Err(ModelFailure::Cancelled)) {
        return Ok(None);
    }
    if let Some(Err(ModelFailure::Broken { reason })) =
        answers.iter().find(|answer| matches!(answer, Err(ModelFailure::Broken { .. })))
    {
        return Err(DesignError::Failed(reason.clone()));
    }
    let nodes: Vec<&Candidate> = answers.iter().filter_map(|answer| answer.as_ref().ok()).collect();
    let best = |nodes: &mut dyn Iterator<Item = &Candidate>| {
        nodes.fold(None, |best: Option<Candidate>, node| match best {
            Some(best) if !node.is_better_than(&best) => Some(best),
            _ => Some(node.clone()),
        })
    };
    let Some(leader) = best(&mut nodes.iter().copied()) else {
        return Err(DesignError::Failed("no design of the table can be computed".to_owned()));
    };
    let is_near = |node: &&&Candidate| {
        let (left, right) = (node.design.lengths_m(), found.design.lengths_m());
        (0..3).all(|axis| (left[axis] - right[axis]).abs() <= steps_m[axis] * (1.0 + WHOLE))
    };
    let neighbour = best(&mut nodes.iter().filter(is_near).copied());
    let feasible = nodes.iter().filter(|node| node.violations.is_empty()).count();
    // Of designs on target the chance decides, which a table does not say.
    let is_chosen = design.target.goal().is_none() && found.meets_target();
    let is_less = leader.misfit.merit < found.misfit.merit - BETTER;
    let beats = !is_chosen && leader.is_better_than(found) && is_less;
    let report = TableReport {
        designs: patterns.len(),
        failed: patterns.len() - nodes.len(),
        feasible,
        meeting: nodes.iter().filter(|node| node.meets_target()).count(),
        best: (&leader).into(),
        neighbour: neighbour.as_ref().map(NodeReport::from),
        found_cost: found.misfit.merit,
        confirms_search: !beats,
        by_chance: is_chosen,
    };
    Ok(Some((report, Lattice { patterns, answers })))
}

impl TableReport {
    /// What the table says, one line each.
    #[must_use]
    pub fn lines(&self, seconds: f64) -> Vec<String> {
        let at = |node: &NodeReport| format!("{} um", node.design.lengths_in_words());
        let mut lines = vec![format!(
            "table of {} designs in {seconds:.1} s: {} respect every limit, {} of them do what is demanded, {} could not be computed",
            self.designs, self.feasible, self.meeting, self.failed
        )];
        let gain = self.found_cost - self.best.cost;
        lines.push(if self.by_chance {
            format!(
                "the design found is on target ({:.3}), as are {} of the table, and was chosen by its chance; the least misfit has {} ({:.3})",
                self.found_cost,
                self.meeting,
                at(&self.best),
                self.best.cost
            )
        } else if self.confirms_search {
            format!(
                "none is better than the design found ({:.3}) by more than {BETTER}: the best is {} ({:.3})",
                self.found_cost,
                at(&self.best),
                self.best.cost
            )
        } else {
            format!(
                "{} is better than the design found by {gain:.3} ({:.3}, not {:.3})",
                at(&self.best),
                self.best.cost,
                self.found_cost
            )
        });
        if let Some(neighbour) = &self.neighbour {
            lines.push(format!(
                "of those within a step of it the best is {} ({:.3}{})",
                at(neighbour),
                neighbour.cost,
                if neighbour.feasible { "" } else { ", beyond a limit" }
            ));
        }
        lines
    }
}
