//! Designs of which none is better than another in every respect.
//!
//! A design dominates another where it is at least as good by every goal and better by one (V. Pareto). The designs
//! that no other dominates are found on a lattice over the whole space, then about themselves at half its spacing,
//! at a quarter, and so on.

use crate::evaluation_archive::{Key, key};
use crate::low_discrepancy::MOST_DIMENSIONS;
use crate::space::Grid;
use crate::{Constraints, DesignSpace, ModelFailure, SearchError};
use rayon::prelude::*;
use slipgrid_pattern::Pattern;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

/// What designs are compared by. As with [`ForwardModel`](crate::ForwardModel), designs are evaluated from several
/// threads at once and equal designs give equal answers.
pub trait Goals: Sync {
    /// What `design` does by each goal, the less the better.
    ///
    /// # Errors
    /// [`ModelFailure::Trial`] for a design that is not to be compared, whether it cannot be computed or is not
    /// allowed; otherwise as [`ForwardModel::respond`](crate::ForwardModel::respond).
    fn of(&self, design: &Pattern) -> Result<Vec<f64>, ModelFailure>;
}

impl<F> Goals for F
where
    F: Fn(&Pattern) -> Result<Vec<f64>, ModelFailure> + Sync,
{
    fn of(&self, design: &Pattern) -> Result<Vec<f64>, ModelFailure> {
        self(design)
    }
}

/// How finely the space is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TradeOffOptions {
    /// Designs of the lattice, about.
    pub lattice: usize,
    /// Times that the surroundings of the front are looked at, each time half as wide.
    pub refinements: usize,
}

impl Default for TradeOffOptions {
    fn default() -> Self {
        Self { lattice: 2000, refinements: 4 }
    }
}

/// A design with what it does by each goal.
#[derive(Clone, Debug, PartialEq)]
pub struct TradeOff {
    /// The design.
    pub design: Pattern,
    /// By each goal, the less the better.
    pub goals: Vec<f64>,
}

/// What was found.
#[derive(Clone, Debug, PartialEq)]
pub struct TradeOffs {
    /// Designs that no other one tried dominates, by the first goal.
    pub front: Vec<TradeOff>,
    /// All others that were compared, in an order that does not depend on timing.
    pub dominated: Vec<TradeOff>,
    /// Designs that were not to be compared.
    pub left_out: usize,
}

/// The designs of `space` under `constraints` of which none is better than another by every goal; `also` are compared
/// beside those of the lattice. The peak pressure and what else a response has is for `goals` to leave out.
///
/// # Errors
/// [`SearchError`] where the space is empty, no design can be compared, or the model is broken.
pub fn trade_offs(
    space: &DesignSpace,
    constraints: &Constraints,
    also: &[Pattern],
    options: &TradeOffOptions,
    goals: &dyn Goals,
) -> Result<TradeOffs, SearchError> {
    let grid = Grid::new(space, constraints)?;
    let mut table = Table { goals, constraints, known: BTreeMap::new(), compared: Vec::new(), first_reason: None };
    let (points, spacings) = lattice(&grid, options.lattice.max(1));
    table.add(also.to_vec())?;
    table.add(points.iter().filter_map(|shares| grid.design(shares)).collect())?;
    let free = grid.free_axes();
    for refinement in 1..=options.refinements {
        let share = 0.5_f64.powi(i32::try_from(refinement).unwrap_or(i32::MAX));
        let mut neighbours = Vec::new();
        for index in table.front() {
            let here = grid.shares(&table.compared[index].design);
            for &axis in &free {
                for side in [-1.0, 1.0] {
                    let mut there = here;
                    there[axis] += side * share * spacings[axis];
                    neighbours.extend(grid.design(&there));
                }
            }
        }
        table.add(neighbours)?;
    }
    table.finish()
}

/// The trade-offs among `designs` alone.
///
/// # Errors
/// As [`trade_offs`].
pub fn compare(constraints: &Constraints, designs: &[Pattern], goals: &dyn Goals) -> Result<TradeOffs, SearchError> {
    let mut table = Table { goals, constraints, known: BTreeMap::new(), compared: Vec::new(), first_reason: None };
    table.add(designs.to_vec())?;
    table.finish()
}

/// Points of a lattice in shares of the bounds, about `wanted` of them, and their distance along each axis. An axis with
/// few values, such as bursts, has no more points than values.
fn lattice(grid: &Grid, wanted: usize) -> (Vec<[f64; MOST_DIMENSIONS]>, [f64; MOST_DIMENSIONS]) {
    lattice_of(grid, &grid.free_axes(), wanted)
}

/// The same over some of the free axes; shares of the others are 0.
pub(crate) fn lattice_of(
    grid: &Grid,
    axes: &[usize],
    wanted: usize,
) -> (Vec<[f64; MOST_DIMENSIONS]>, [f64; MOST_DIMENSIONS]) {
    let mut order = axes.to_vec();
    order.sort_by_key(|&axis| grid.values(axis));
    let mut counts = [1_u64; MOST_DIMENSIONS];
    let mut left = wanted as f64;
    for (place, &axis) in order.iter().enumerate() {
        // The same number along each axis that is left: n = left^(1/k). Far below 2^52: the cast is exact.
        let even = left.powf(1.0 / (order.len() - place) as f64).round().max(2.0) as u64;
        counts[axis] = even.min(grid.values(axis)).max(1);
        left = (left / counts[axis] as f64).max(1.0);
    }
    let spacings = counts.map(|count| if count > 1 { 1.0 / (count - 1) as f64 } else { 0.0 });
    let mut points = vec![[0.0; MOST_DIMENSIONS]];
    for &axis in axes {
        points = points
            .iter()
            .flat_map(|point| {
                (0..counts[axis]).map(move |step| {
                    let mut shares = *point;
                    shares[axis] = grid.spread(axis, step, counts[axis]);
                    shares
                })
            })
            .collect();
    }
    (points, spacings)
}

/// Designs that were looked at.
struct Table<'a> {
    goals: &'a dyn Goals,
    constraints: &'a Constraints,
    /// Whether each design could be compared.
    known: BTreeMap<Key, bool>,
    compared: Vec<TradeOff>,
    first_reason: Option<String>,
}

impl Table<'_> {
    /// Looks at those of `designs` that are not known.
    fn add(&mut self, designs: Vec<Pattern>) -> Result<(), SearchError> {
        let mut fresh: Vec<Pattern> = Vec::new();
        for design in designs {
            if let Entry::Vacant(entry) = self.known.entry(key(&design)) {
                entry.insert(false);
                if self.constraints.limits.violations(&design).is_empty() {
                    fresh.push(design);
                }
            }
        }
        let answers: Vec<_> = fresh.par_iter().map(|design| self.goals.of(design)).collect();
        for (design, answer) in fresh.into_iter().zip(answers) {
            match answer {
                Ok(goals) if goals.iter().all(|goal| goal.is_finite()) => {
                    self.known.insert(key(&design), true);
                    self.compared.push(TradeOff { design, goals });
                }
                Ok(_) => {}
                Err(ModelFailure::Trial { reason }) => {
                    self.first_reason.get_or_insert(reason);
                }
                Err(ModelFailure::Broken { reason }) => return Err(SearchError::BrokenModel { reason }),
                Err(ModelFailure::Cancelled) => return Err(SearchError::CancelledAtStart),
            }
        }
        Ok(())
    }

    fn front(&self) -> Vec<usize> {
        let goals: Vec<&[f64]> = self.compared.iter().map(|known| &known.goals[..]).collect();
        non_dominated(&goals)
    }

    fn finish(self) -> Result<TradeOffs, SearchError> {
        let left_out = self.known.values().filter(|compared| !**compared).count();
        if self.compared.is_empty() {
            let reason = self.first_reason.unwrap_or_else(|| "limits leave none".to_owned());
            return Err(SearchError::EveryTrialFailed { trials: left_out, reason });
        }
        let mut is_on_front = vec![false; self.compared.len()];
        for index in self.front() {
            is_on_front[index] = true;
        }
        let (mut front, mut dominated) = (Vec::new(), Vec::new());
        for (known, is_on_front) in self.compared.into_iter().zip(is_on_front) {
            if is_on_front { front.push(known) } else { dominated.push(known) }
        }
        // Stable: of equal goals the earlier first.
        front.sort_by(|a, b| in_order(&a.goals, &b.goals));
        Ok(TradeOffs { front, dominated, left_out })
    }
}

/// Lexicographic.
fn in_order(left: &[f64], right: &[f64]) -> std::cmp::Ordering {
    let differing = left.iter().zip(right).map(|(l, r)| l.total_cmp(r)).find(|order| order.is_ne());
    differing.unwrap_or(std::cmp::Ordering::Equal)
}

/// Places of those `goals` that no other dominates, in their order. Equal ones do not dominate each other.
fn non_dominated(goals: &[&[f64]]) -> Vec<usize> {
    // In lexicographic order whatever dominates comes first, and what a dominated one dominates something on the
    // front dominates too.
    let mut order: Vec<usize> = (0..goals.len()).collect();
    order.sort_by(|&a, &b| in_order(goals[a], goals[b]));
    let mut front: Vec<usize> = Vec::new();
    for index in order {
        if !front.iter().any(|&other| dominates(goals[other], goals[index])) {
            front.push(index);
        }
    }
    front.sort_unstable();
    front
}

/// At least as good by every goal, and better by one.
fn dominates(left: &[f64], right: &[f64]) -> bool {
    left.iter().zip(right).all(|(l, r)| l <= r) && left.iter().zip(right).any(|(l, r)| l < r)
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_pattern::{ManufacturingLimits, Planform};

    fn um(design: &Pattern) -> [f64; 3] {
        design.lengths_m().map(|length_m| length_m * 1e6)
    }

    fn space(width_um: [f64; 2], spacing_um: [f64; 2], depth_um: [f64; 2]) -> DesignSpace {
        let metres = |bounds: [f64; 2]| bounds.map(|bound| bound * 1e-6);
        DesignSpace::new(Planform::Groove, metres(width_um), metres(spacing_um), metres(depth_um)).unwrap()
    }

    fn bursts() -> Constraints {
        let limits = ManufacturingLimits { depth_per_burst_m: Some(2.6e-6), ..Default::default() };
        Constraints { limits, ..Default::default() }
    }

    /// Three goals that pull apart, uneven enough that neighbours dominate each other.
    fn pulling(design: &Pattern) -> Result<Vec<f64>, ModelFailure> {
        let [w, s, d] = um(design);
        let ripple = (31.0 * w).sin() + (17.0 * s).cos() + (5.0 * d).sin();
        if (w - 100.2).abs() < 1e-6 && d > 8.0 {
            return Err(ModelFailure::Trial { reason: "a hole in the space".to_owned() });
        }
        Ok(vec![(w - 100.1).powi(2) + 0.02 * ripple, d * w / s, 1.0 / d + 0.01 * (3.0 * s).sin()])
    }

    #[test]
    fn on_a_small_grid_the_front_is_the_set_that_brute_force_finds() {
        // 5 x 6 x 4 designs, all of them on the lattice.
        let space = space([100.0, 100.4], [200.0, 200.5], [2.0, 11.0]);
        let options = TradeOffOptions { lattice: 5 * 6 * 4, refinements: 2 };
        let found = trade_offs(&space, &bursts(), &[], &options, &pulling).unwrap();
        let mut all = Vec::new();
        for w in 0..5 {
            for s in 0..6 {
                for d in 1..=4 {
                    let lengths = [100.0 + 0.1 * f64::from(w), 200.0 + 0.1 * f64::from(s), 2.6 * f64::from(d)];
                    let [w, s, d] = lengths.map(|um| um * 1e-6);
                    let design = Pattern::new(Planform::Groove, w, s, d).unwrap();
                    all.extend(pulling(&design).ok().map(|goals| (design, goals)));
                }
            }
        }
        assert_eq!(found.front.len() + found.dominated.len(), all.len());
        assert_eq!(found.left_out, 120 - all.len());
        let close = |a: &Pattern, b: &Pattern| um(a).iter().zip(um(b)).all(|(a, b)| (a - b).abs() < 1e-6);
        let mut expected = 0;
        for (design, goals) in &all {
            let is_dominated = all.iter().any(|(_, other)| {
                other.iter().zip(goals).all(|(l, r)| *l <= r + 1e-13)
                    && other.iter().zip(goals).any(|(l, r)| *l < r - 1e-13)
            });
            expected += usize::from(!is_dominated);
            assert_eq!(found.front.iter().any(|known| close(&known.design, design)), !is_dominated, "{design:?}");
        }
        assert!(found.front.len() == expected && (5..100).contains(&expected), "{expected}");
    }

    #[test]
    fn non_dominated_agrees_with_the_definition_on_random_sets() {
        let mut normals = slipgrid_statistics::Normals::new(11);
        for count in [1, 2, 30, 200] {
            for dimensions in [2, 3] {
                // Rounded, so that equal goals occur.
                let points: Vec<Vec<f64>> =
                    (0..count).map(|_| (0..dimensions).map(|_| (3.0 * normals.draw()).round()).collect()).collect();
                let goals: Vec<&[f64]> = points.iter().map(|point| &point[..]).collect();
                let expected: Vec<usize> =
                    (0..count).filter(|&i| !goals.iter().any(|other| dominates(other, goals[i]))).collect();
                assert_eq!(non_dominated(&goals), expected);
            }
        }
    }

    #[test]
    fn refinement_brings_the_front_to_the_known_curve() {
        // f1 = (a - 1/3)^2 + e, f2 = (a - 2/3)^2 + e over shares a of the width and e = b^2 of the spacing: the front is
        // 1/3 <= a <= 2/3, b = 0, where sqrt(f1) + sqrt(f2) = 1/3.
        let space = space([40.0, 400.0], [40.0, 1000.0], [5.0, 5.0]);
        let goals = |design: &Pattern| {
            let [w, s, _] = um(design);
            let (a, b) = ((w / 40.0).ln() / 10.0_f64.ln(), (s / 40.0).ln() / 25.0_f64.ln());
            Ok(vec![(a - 1.0 / 3.0).powi(2) + b * b, (a - 2.0 / 3.0).powi(2) + b * b])
        };
        let at = |refinements| {
            let options = TradeOffOptions { lattice: 100, refinements };
            trade_offs(&space, &Constraints::default(), &[], &options, &goals).unwrap().front
        };
        let gaps = |front: &[TradeOff]| {
            let ends = front.windows(2).map(|pair| pair[1].goals[0].sqrt() - pair[0].goals[0].sqrt());
            ends.fold(0.0, f64::max)
        };
        let (coarse, fine) = (at(0), at(4));
        for known in &fine {
            assert!((known.goals[0].sqrt() + known.goals[1].sqrt() - 1.0 / 3.0).abs() < 2e-3);
        }
        assert!(fine.len() > 4 * coarse.len() && gaps(&fine) < 0.3 * gaps(&coarse), "{} {}", coarse.len(), fine.len());
        assert!(fine.windows(2).all(|pair| pair[0].goals[0] <= pair[1].goals[0]));
    }

    #[test]
    fn the_front_is_the_same_on_any_number_of_threads_and_takes_designs_beside_the_lattice() {
        let space = space([40.0, 400.0], [40.0, 1000.0], [2.0, 50.0]);
        let best = Pattern::new(Planform::Groove, 100.1e-6, 777.7e-6, 2.6e-6).unwrap();
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let options = TradeOffOptions { lattice: 300, refinements: 2 };
            pool.install(|| trade_offs(&space, &bursts(), &[best], &options, &pulling).unwrap())
        };
        let found = on(1);
        assert_eq!(found, on(3));
        assert!(found.front.iter().chain(&found.dominated).any(|known| known.design == best));
        let none = |_: &Pattern| Err(ModelFailure::Trial { reason: "never".to_owned() });
        let refused = trade_offs(&space, &bursts(), &[], &TradeOffOptions { lattice: 8, refinements: 1 }, &none);
        assert!(matches!(refused, Err(SearchError::EveryTrialFailed { .. })));
    }
}
