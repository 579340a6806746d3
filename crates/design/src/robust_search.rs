//! `[search] robust = true`: of the designs that meet the target, the one whose samples miss it least.

use slipgrid_monitor::Monitor;
use slipgrid_optimize::{
    ForwardModel, RobustOutcome, SearchError, SearchOptions, SearchOutcome, Status, search_robust,
};
use slipgrid_pattern::Pattern;

use crate::steady_model::SteadyModel;
use crate::task::DesignTask;

/// What the last search for a robust design said.
#[derive(Clone, Debug)]
pub struct RobustChoice {
    /// The design that was best on paper.
    pub nominal: Pattern,
    /// What was found.
    pub found: RobustOutcome,
}

/// Replaces the best design of `outcome` by the robust one, where the design asks for that.
///
/// # Errors
/// As [`search_robust`].
pub fn choose(
    design: &DesignTask,
    model: &SteadyModel,
    options: &SearchOptions,
    outcome: SearchOutcome,
    monitor: &dyn Monitor,
) -> Result<(SearchOutcome, Option<RobustChoice>), SearchError> {
    // A search that ran out of time leaves none for another.
    let is_wanted = design.robust && outcome.status != Status::Cancelled;
    let Some(tolerances) = design.tolerances.filter(|_| is_wanted) else { return Ok((outcome, None)) };
    let guide = model.guide();
    let guide = guide.as_ref().map(|(guide, _)| guide as &dyn ForwardModel);
    let (target, space, constraints) = (&design.target, &design.space, &design.constraints);
    let found =
        search_robust(target, space, constraints, options, &tolerances.tolerances, model, guide, &outcome, monitor)?;
    let choice = RobustChoice { nominal: outcome.best.design, found: found.clone() };
    Ok((SearchOutcome { best: found.best, ..outcome }, Some(choice)))
}
