//! Aiming with the discrepancy only where the physics alone says that the pattern does something: nothing is no pattern.

use slipgrid_optimize::{Bound, Limit};

use crate::constraint_quantities::ConstraintQuantity;
use crate::steady_model::SteadyModel;
use crate::task::DesignTask;

/// Keeps the search of a `design` that aims with the discrepancy to patterns whose friction differs from the flat surface's by more
/// than the tolerance by the physics alone.
pub fn demand_effect(design: &mut DesignTask) {
    if !design.discrepancy || !design.target.has_demands() {
        return;
    }
    design.quantities.push(ConstraintQuantity::Effect);
    design.constraints.quantities.push(Limit {
        name: "effect of the pattern by the physics alone in tolerances",
        unit: "",
        unit_si: 1.0,
        bound: Bound::AtLeast(1.0),
        scale: 1.0,
        // Nothing is learned of it by relaxing it: the loosest limit is the limit.
        loosest: 1.0,
    });
}

/// How much a pattern does by the physics alone.
#[derive(Clone, Debug, Default)]
pub struct Effect {
    /// What is accepted at each pressure; absent where nothing is demanded.
    tolerance: Vec<Option<f64>>,
    /// The flat surface's value at each load.
    flat: Vec<f64>,
}

impl Effect {
    /// Of the values that `model` gives designs of `design`.
    pub fn new(design: &DesignTask, model: &SteadyModel) -> Self {
        Self {
            tolerance: design.target.points().iter().map(|point| point.wanted.tolerance()).collect(),
            flat: (0..design.target.values()).map(|load| model.scale(load)).collect(),
        }
    }

    /// Largest distance of `physics`, values by the physics alone, from the flat surface's over the pressures, in tolerances; at
    /// the condition where that is least. Infinite where nothing is demanded.
    pub fn of(&self, physics: &[f64]) -> f64 {
        let count = self.tolerance.len().max(1);
        let at_condition = |(values, flat): (&[f64], &[f64])| {
            let each = values.iter().zip(flat).zip(&self.tolerance);
            each.filter_map(|((value, flat), tolerance)| Some((value - flat).abs() / (*tolerance)?))
                .reduce(f64::max)
                .unwrap_or(f64::INFINITY)
        };
        physics.chunks(count).zip(self.flat.chunks(count)).map(at_condition).fold(f64::INFINITY, f64::min)
    }
}
