//! What keeps a target out of reach: the greatest chance with each limit, or each bound that the best texture rests on, lifted.

use serde::{Deserialize, Serialize};
use slipgrid_optimize::DesignSpace;
use slipgrid_results::PatternReport;
use slipgrid_units::{LENGTH_UM, tidy};

use crate::constraint_quantities::Limited;
use crate::prediction::Prediction;
use crate::search::{ALIKE, Search};
use crate::table::Table;
use crate::task::DesignTask;

/// By what factor a bound is lifted.
const WIDER: f64 = 2.0;
/// A length rests on a bound where it is as near as this, relative.
const AT_BOUND: f64 = 0.05;

/// The greatest chance that is had without a limit or a bound.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LiftedReport {
    /// The limit or bound, in words.
    pub what: String,
    /// The greatest chance without it, by the table.
    pub chance: f64,
    /// The texture that has it.
    pub design: PatternReport,
    /// The median of some texture then lies within what is accepted.
    pub is_within_reach: bool,
}

/// What is had with each limit and each bound that `best` rests on lifted alone, those first that bring the target within
/// reach, then the greatest chance; those alone that gain something.
pub fn blocked_by(search: &Search<'_>, best: &Prediction) -> Vec<LiftedReport> {
    let task = search.task;
    let mut all = Vec::new();
    let mut add = |what: String, lifted: &DesignTask, table: &Table| {
        let limited = Limited::of(lifted);
        let relaxed = Search {
            prepared: search.prepared,
            task: lifted,
            predictor: search.predictor.clone(),
            asked: search.asked,
            models: search.models,
            beyond: search.beyond,
            table,
            inputs: search.inputs,
            limited: &limited,
            stage: search.stage,
        };
        let (found, is_within_reach) = relaxed.greatest();
        let Some(found) = found.filter(|found| found.value() > best.value() + ALIKE || is_within_reach) else { return };
        all.push(LiftedReport {
            what,
            chance: tidy(found.chance()),
            design: PatternReport::from(&found.texture.pattern),
            is_within_reach,
        });
    };
    for (place, limit) in task.constraints.quantities.iter().enumerate() {
        let mut lifted = task.clone();
        lifted.constraints.quantities[place] = limit.relaxed();
        add(format!("the limit of {}, {}", limit.name, limit.tell(limit.bound.limit())), &lifted, search.table);
    }
    if let Some(land_m) = task.constraints.limits.min_land_m {
        let mut lifted = task.clone();
        lifted.constraints.limits.min_land_m = None;
        add(format!("the smallest land, {} um", LENGTH_UM.from_si(land_m)), &lifted, search.table);
    }
    // In space further cells take as long as the first.
    if search.models.own.is_cheap_per_design() {
        let bounds_m = task.space.lengths_m();
        for (axis, name) in ["width", "spacing", "depth"].into_iter().enumerate() {
            let ([low, high], own) = (bounds_m[axis], best.texture.pattern.lengths_m()[axis]);
            let is_at = |end: f64| (own / end - 1.0).abs() <= AT_BOUND;
            let (side, wider) = if is_at(high) && high > low {
                ("greatest", [low, high * WIDER])
            } else if is_at(low) && high > low {
                ("least", [low / WIDER, high])
            } else {
                continue;
            };
            let mut wide_m = bounds_m;
            wide_m[axis] = wider;
            let Ok(space) = DesignSpace::new(*task.space.texture(), wide_m[0], wide_m[1], wide_m[2]) else { continue };
            let lifted = DesignTask { space, ..task.clone() };
            let Some(table) = search.table.widened(&lifted, search.models, search.stage) else { continue };
            let end_um = LENGTH_UM.from_si(if side == "least" { low } else { high });
            add(format!("the {side} {name}, {} um", tidy(end_um)), &lifted, &table);
        }
    }
    all.sort_by(|a, b| b.is_within_reach.cmp(&a.is_within_reach).then(b.chance.total_cmp(&a.chance)));
    all
}
