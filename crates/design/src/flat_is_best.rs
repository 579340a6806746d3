//! Targets that no pattern is needed for, or that none can meet, because the model only lowers friction.

use serde::{Deserialize, Serialize};
use slipgrid_optimize::{Demand, Goal, Quantity, Status, Wanted};

use crate::multi_fidelity::MultiFidelityLoop;
use crate::task::DesignTask;
use slipgrid_results::fixed;
use slipgrid_units::PRESSURE_MPA;

/// What is to be said where the flat surface is better than any pattern.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FlatReport {
    /// In words, with the numbers.
    pub words: String,
    /// The flat surface does what is asked; otherwise nothing does.
    pub suffices: bool,
}

/// The status of a design whose flat surface is the best.
pub const FLAT_IS_BEST: &str = "flat_is_best";

impl MultiFidelityLoop<'_> {
    /// What the flat surface does about the target of `design`, where it is better than any pattern.
    pub(super) fn flat_is_best(&self, design: &DesignTask) -> Option<FlatReport> {
        let target = &design.target;
        let flat: Vec<f64> = (0..target.values()).map(|load| self.model.scale(load)).collect();
        let quantity = match target.quantity() {
            Quantity::Ratio => "ratio",
            Quantity::DynamicFriction => "dynamic friction",
        };
        let points = target.points();
        let asked = |of: &[f64]| -> Vec<(Demand, f64)> {
            of.iter().enumerate().map(|(place, value)| (points[place % points.len()], *value)).collect()
        };
        // The demand that lies highest above what no pattern exceeds by the physics.
        let above = asked(&flat)
            .into_iter()
            .filter_map(|(point, flat)| Some((point, flat, point.wanted.band()[0]? - flat)))
            .filter(|(_, _, by)| *by > 0.0)
            .max_by(|a, b| a.2.total_cmp(&b.2));
        // What the model lacks may raise friction.
        if let Some((point, flat, by)) = above.filter(|_| self.status == Status::Unreachable && !design.discrepancy) {
            return Some(FlatReport {
                words: format!(
                    "this model only lowers friction: at {} MPa a {quantity} of at least {} is wanted, and the flat surface, which no \
                     pattern exceeds, has {}",
                    PRESSURE_MPA.from_si(point.pressure_pa),
                    fixed(Some(flat + by), 4),
                    fixed(Some(flat), 4),
                ),
                suffices: false,
            });
        }
        if !target.misfit(&flat).is_met() {
            return None;
        }
        let found = &self.round.best.as_ref()?.response.value;
        let list = |values: &[f64]| values.iter().map(|value| fixed(Some(*value), 4)).collect::<Vec<_>>().join(", ");
        let goes_up = |wanted: &Wanted, flat: f64| matches!(wanted, Wanted::Near { value, .. } if *value > flat);
        if let Some(goal) = target.goal() {
            return self.flat_is_better(design, goal, quantity, [&flat, found], &list);
        }
        let is_best = asked(&flat).iter().all(|(point, flat)| goes_up(&point.wanted, *flat));
        is_best.then(|| FlatReport { words: almost_flat(quantity, &list(&flat), &list(found)), suffices: true })
    }

    /// What is to be said where the goal of `design` has a better value by the `flat` surface's values, which are accepted, than by
    /// those `found`.
    fn flat_is_better(
        &self,
        design: &DesignTask,
        goal: Goal,
        quantity: &str,
        [flat, found]: [&[f64]; 2],
        list: &dyn Fn(&[f64]) -> String,
    ) -> Option<FlatReport> {
        let [of_flat, of_found] = [design.target.goal_value(flat)?, design.target.goal_value(found)?];
        let gain = if goal == Goal::Highest { of_flat - of_found } else { of_found - of_flat };
        if gain <= 0.0 {
            return None;
        }
        let words = if goal == Goal::Highest && gain <= design.target.tolerance() {
            almost_flat(quantity, &list(flat), &list(found))
        } else {
            let of = match goal {
                Goal::Highest | Goal::Lowest => format!("mean {quantity}"),
                Goal::Even => format!("standard deviation of {quantity} over its mean"),
            };
            format!(
                "the flat surface is better than the best pattern found: its {of} is {}, that of the pattern {} ({quantity} of {}, and of {})",
                fixed(Some(of_flat), 4),
                fixed(Some(of_found), 4),
                list(flat),
                list(found),
            )
        };
        Some(FlatReport { words, suffices: true })
    }
}

/// What is said where the values `found` are hardly those of the `flat` surface.
fn almost_flat(quantity: &str, flat: &str, found: &str) -> String {
    format!(
        "the flat surface is the best: this model only lowers friction, the flat surface has a {quantity} of {flat}, and the search ended \
         at almost no pattern ({found})"
    )
}
