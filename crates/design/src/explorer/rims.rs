//! What rims of other heights than the modelled change.

use slipgrid_monitor::Stage;
use slipgrid_pattern::Rim;
use slipgrid_statistics::{Normals, ResponseSurface, normal_probability};

use super::{Nodes, ask, axes, filled, surfaces};
use crate::steady_model::{Endless, SteadyModel};
use crate::task::DesignTask;

/// Nodes in the vertical plane of what rims of other heights change, and these heights over the modelled ones.
const RIM_NODES: Nodes = Nodes { each: [6.0, 5.0, 2.5], most: [14, 14, 8] };
const RIM_FACTORS: [f64; 4] = [0.5, 0.75, 1.25, 1.5];

/// What rims of other heights than the modelled change, on a lattice of their own.
#[derive(Clone, Debug, PartialEq)]
pub struct RimChanges {
    /// Heights over the modelled ones, ascending; without 1, where nothing changes.
    pub factors: Vec<f64>,
    /// For each of them by width, spacing and depth: what is added to the values.
    pub values: Vec<ResponseSurface>,
    /// For each of them by the same: what is added to the logarithm of the largest local pressure, and to how far ceilings come down.
    pub peak_and_sag: Vec<ResponseSurface>,
}

impl RimChanges {
    /// Weights of the changes at a `factor`: those of the polynomial through all heights, the modelled one included (Lagrange).
    #[must_use]
    pub fn weights(&self, factor: f64) -> Vec<f64> {
        let all = || self.factors.iter().copied().chain([1.0]);
        let weight =
            |own: f64| all().filter(|other| *other != own).map(|other| (factor - other) / (own - other)).product();
        self.factors.iter().map(|own| weight(*own)).collect()
    }

    /// What is added to the values of a design whose rims are `factor` times as high as modelled.
    #[must_use]
    pub fn at(&self, lengths_um: &[f64; 3], factor: f64) -> Vec<f64> {
        let mut found = Vec::new();
        for (weight, surface) in self.weights(factor).iter().zip(&self.values) {
            let change = surface.at(lengths_um);
            found.resize(change.len(), 0.0);
            found.iter_mut().zip(change).for_each(|(sum, change)| *sum += weight * change);
        }
        found
    }
}

/// What rims of other heights than those of `rim` change; `None` where `bar` has cancelled, or no design can be computed.
pub(super) fn rim_changes(
    design: &DesignTask,
    model: &SteadyModel,
    rim: Rim,
    (bar, share): (&Stage<'_>, f64),
) -> Option<RimChanges> {
    let axes = axes(&design.space, &RIM_NODES);
    let nodes = ResponseSurface::nodes(&axes);
    let texture = *design.space.texture();
    let share = share / (1 + RIM_FACTORS.len()) as f64;
    let solved = |factor: f64| ask(model, &|_| texture.with_rim(rim.times(factor)), &nodes, false, (bar, share));
    let own = solved(1.0)?;
    let (mut values, mut peak_and_sag) = (Vec::new(), Vec::new());
    for factor in RIM_FACTORS {
        let change = |(other, own): (Option<Endless>, &Option<Endless>)| Some(other?.over(own.as_ref()?));
        let changes = filled(solved(factor)?.into_iter().zip(&own).map(change).collect(), &axes)?;
        let found = surfaces(axes, &changes);
        values.push(found.0);
        peak_and_sag.push(found.1);
    }
    Some(RimChanges { factors: RIM_FACTORS.to_vec(), values, peak_and_sag })
}

/// Heights of the rims of `count` designs over those modelled: anywhere between the ends of `rims`, or as modelled without it.
pub(super) fn factors(rims: Option<&RimChanges>, count: usize, seed: u64) -> Vec<f64> {
    let ends = rims.and_then(|rims| Some([*rims.factors.first()?, *rims.factors.last()?]));
    // Apart from the draws of the designs.
    let mut normals = Normals::new(seed.wrapping_add(1));
    let mut draw = |[from, to]: [f64; 2]| from + (to - from) * normal_probability(normals.draw());
    (0..count).map(|_| ends.map_or(1.0, &mut draw)).collect()
}

#[cfg(test)]
mod tests {
    use slipgrid_statistics::Axis;

    use super::*;

    #[test]
    fn changes_are_met_at_every_height_that_was_solved() {
        let axes = [Axis::new([10.0, 40.0], 4), Axis::new([20.0, 20.0], 1), Axis::new([5.0, 5.0], 1)];
        let surface = |change: f64| ResponseSurface::through(axes, 1, vec![change; 4]);
        // A polynomial of the height's factor that is nothing at 1.
        let change = |factor: f64| 0.3 * (factor - 1.0) - 0.2 * (factor - 1.0).powi(3);
        let rims = RimChanges {
            factors: RIM_FACTORS.to_vec(),
            values: RIM_FACTORS.map(|factor| surface(change(factor))).to_vec(),
            peak_and_sag: Vec::new(),
        };
        for factor in [0.5, 0.6, 0.75, 1.0, 1.3, 1.5] {
            let found = rims.at(&[20.0, 20.0, 5.0], factor);
            assert!((found[0] - change(factor)).abs() < 1e-12, "{factor}: {found:?}");
        }
        assert!(factors(Some(&rims), 50, 1).iter().all(|factor| (0.5..=1.5).contains(factor)));
        assert!(factors(None, 3, 1).iter().all(|factor| *factor == 1.0));
    }
}
