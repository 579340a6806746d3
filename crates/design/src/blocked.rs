//! Limits and bounds that keep a target out of reach: the maximum chance with each limit removed, or each bound that
//! the best texture rests on widened.

use std::fmt;

use crate::optimize::{DesignSpace, Limit, Violation};
use crate::results::PatternReport;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use slipgrid_base::units::{LENGTH_UM, tidy};
use slipgrid_model::pattern::Pattern;

use crate::prediction::Prediction;
use crate::search::{ALIKE, Search};
use crate::table::Table;
use crate::task::DesignTask;

/// Factor by which a bound is widened.
const WIDER: f64 = 2.0;
/// A length rests on a bound if the relative difference of the two is at most this.
const AT_BOUND: f64 = 0.05;

/// Maximum chance without one limit, or with one bound widened.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LiftedReport {
    /// Name of the limit or bound, in words.
    pub what: String,
    /// Maximum chance, from 0 to 1, without the limit or with the bound widened by a factor of 2, by the table of
    /// designs.
    pub chance: f64,
    /// Texture that has this chance.
    pub design: PatternReport,
    /// True if some texture then has accepted medians of samples at every load.
    pub is_within_reach: bool,
}

/// Bound of a dimension that a texture rests on.
pub struct ReachedBound {
    axis: usize,
    is_upper: bool,
    end_um: f64,
}

impl fmt::Display for ReachedBound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let side = if self.is_upper { "greatest" } else { "least" };
        write!(f, "the {side} {} of {} um", ["width", "spacing", "depth"][self.axis], self.end_um)
    }
}

/// Bounds of `task` that `pattern` rests on; none for fixed dimensions.
pub fn bounds_reached(task: &DesignTask, pattern: &Pattern) -> Vec<ReachedBound> {
    let one = |(axis, ([low, high], own)): (usize, ([f64; 2], f64))| {
        let is_at = |end: f64| (own / end - 1.0).abs() <= AT_BOUND;
        let is_upper = is_at(high);
        let end_um = tidy(LENGTH_UM.from_si(if is_upper { high } else { low }));
        (high > low && (is_upper || is_at(low))).then_some(ReachedBound { axis, is_upper, end_um })
    };
    task.space.lengths_m().into_iter().zip(pattern.lengths_m()).enumerate().filter_map(one).collect()
}

/// Computes the maximum chance by the table with, separately, each limit removed and each bound that `best` rests on
/// widened. Returns only limits and bounds that bring the target within reach, or admit a better texture: those that
/// bring it within reach first, then by decreasing chance. If the target `is_within_reach` by the table, textures break
/// limits only as they are cut, and only the limits that `best` breaks are examined.
pub fn blocked_by(search: &Search<'_>, best: &Prediction, is_within_reach: bool) -> Vec<LiftedReport> {
    let task = search.task;
    let broken = search.violated_by(&best.texture);
    let is_examined = |own: &Limit| {
        let is_own = |of: &Violation| matches!(of, Violation::Quantity { limit, .. } if limit == own);
        !is_within_reach || broken.iter().any(is_own)
    };
    let mut all = Vec::new();
    let mut add = |what: String, lifted: &DesignTask, table: &Table| {
        let relaxed = Search { task: lifted, table, ..search.clone() };
        let (found, is_within_reach) = relaxed.greatest(&|_| true);
        let is_better =
            |found: &Prediction| found.value() > best.value() + ALIKE && !search.is_admitted(&found.texture.pattern);
        let Some(found) = found.filter(|found| is_within_reach || is_better(found)) else { return };
        all.push(LiftedReport {
            what,
            chance: tidy(found.chance()),
            design: PatternReport::from(&found.texture.pattern),
            is_within_reach,
        });
    };
    let limits = task.constraints.quantities.iter().enumerate();
    for (place, limit) in limits.filter(|(_, limit)| is_examined(limit)) {
        let mut lifted = task.clone();
        lifted.constraints.quantities.remove(place);
        let (name, told) = (limit.quantity.name(), limit.quantity.tell(limit.bound.limit()));
        add(format!("the limit of {name}, {told}"), &lifted, search.table);
    }
    if let Some(land_m) = task.constraints.limits.min_land_m.filter(|_| !is_within_reach) {
        let mut lifted = task.clone();
        lifted.constraints.limits.min_land_m = None;
        add(format!("the smallest land, {} um", LENGTH_UM.from_si(land_m)), &lifted, search.table);
    }
    // In space, a wider table would take as long as the first one.
    if search.models.own.is_cheap_per_design() && !is_within_reach {
        let bounds_m = task.space.lengths_m();
        for bound in bounds_reached(task, &best.texture.pattern) {
            let mut wide_m = bounds_m;
            let [low, high] = bounds_m[bound.axis];
            wide_m[bound.axis] = if bound.is_upper { [low, high * WIDER] } else { [low / WIDER, high] };
            let Ok(space) = DesignSpace::new(*task.space.texture(), wide_m[0], wide_m[1], wide_m[2]) else { continue };
            let lifted = DesignTask { space, ..task.clone() };
            let Some(table) = search.table.widened(&lifted, search.models, search.stage) else { continue };
            add(bound.to_string(), &lifted, &table);
        }
    }
    all.sort_by(|a, b| b.is_within_reach.cmp(&a.is_within_reach).then(b.chance.total_cmp(&a.chance)));
    all
}
