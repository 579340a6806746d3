//! Hill climbing from the best designs of a coarse scan to the best design in whole blocks and bursts.
//!
//! A step moves to the best neighbour of a design; neighbours lie `s` blocks or bursts away along one, two or three
//! lengths. If no neighbour improves the value, `s` is halved. Cost: at most 26 designs per step, less the designs
//! already known.

use std::collections::{BTreeMap, BTreeSet};

use rayon::prelude::*;
use slipgrid_base::monitor::Monitor;
use slipgrid_model::pattern::Pattern;

use crate::task::DesignTask;
use crate::whole_steps::axes;

/// Step sizes `s` of a climb, in blocks (width, spacing) or bursts (depth), in decreasing order.
const STEPS: [usize; 3] = [4, 2, 1];

/// Lattice index: indices of width, spacing and depth among the lengths of the lattice.
pub type Place = [usize; 3];

/// Lattice of all designs of whole blocks and bursts within the bounds.
pub struct Steps<'a> {
    task: &'a DesignTask,
    /// Widths, then spacings, in metres.
    axes: [Vec<f64>; 2],
    /// Depths at each width, in metres.
    depths_m: Vec<Vec<f64>>,
    /// Numbers of widths, of spacings, and of the depths at the width that has most.
    counts: [usize; 3],
}

impl<'a> Steps<'a> {
    /// Creates the lattice of `task`.
    pub fn new(task: &'a DesignTask) -> Self {
        let (axes, depths_m) = axes(task);
        let deepest = depths_m.iter().map(Vec::len).max().unwrap_or(0);
        let counts = [axes[0].len(), axes[1].len(), deepest];
        Self { task, axes, depths_m, counts }
    }

    /// Returns all designs, or at most `most` of them spread evenly over the bounds, without those that the laser
    /// cannot cut.
    pub fn spread(&self, most: usize) -> Vec<Pattern> {
        let [_, spacings, depths] = self.counts;
        let least = self.count().div_ceil(most).max(1);
        // A stride coprime to the axis lengths spreads the omitted designs evenly.
        let is_apart = |stride: &usize| common_divisor(*stride, spacings) == 1 && common_divisor(*stride, depths) == 1;
        self.every((least..).find(is_apart).unwrap_or(least)).collect()
    }

    /// Number of designs, with those that the laser cannot cut.
    fn count(&self) -> usize {
        self.counts.into_iter().fold(1, usize::saturating_mul)
    }

    /// Every `stride`-th of all designs, width varying slowest, without those that the laser cannot cut.
    pub fn every(&self, stride: usize) -> impl Iterator<Item = Pattern> + '_ {
        let [_, spacings, depths] = self.counts;
        let place = move |number: usize| [number / (spacings * depths), number / depths % spacings, number % depths];
        (0..self.count()).step_by(stride).filter_map(move |number| self.design(place(number)))
    }

    /// Index of `design`; `None` if it is not on the lattice.
    pub fn place(&self, design: &Pattern) -> Option<Place> {
        let lengths_m = design.lengths_m();
        let along = |axis: &[f64], length_m: f64| axis.binary_search_by(|node| node.total_cmp(&length_m)).ok();
        let [width, spacing] = [along(&self.axes[0], lengths_m[0])?, along(&self.axes[1], lengths_m[1])?];
        Some([width, spacing, along(&self.depths_m[width], lengths_m[2])?])
    }

    /// Design at `place`; `None` if the laser cannot cut it.
    fn design(&self, [width, spacing, depth]: Place) -> Option<Pattern> {
        let depth_m = *self.depths_m[width].get(depth)?;
        let design = self.task.space.pattern([self.axes[0][width], self.axes[1][spacing], depth_m]).ok()?;
        self.task.constraints.limits.violations(&design).is_empty().then_some(design)
    }

    /// Neighbours of `place` at a distance of `step` lattice steps along one or more lengths, within the bounds.
    fn about(&self, place: Place, step: usize) -> Vec<Place> {
        let moved = |axis: usize| {
            let above = Some(place[axis] + step).filter(|moved| *moved < self.counts[axis]);
            [place[axis].checked_sub(step), Some(place[axis]), above].into_iter().flatten()
        };
        let mut all = Vec::new();
        for depth in moved(2) {
            for spacing in moved(1) {
                all.extend(moved(0).map(|width| [width, spacing, depth]));
            }
        }
        all.retain(|other| *other != place);
        all
    }
}

/// Greatest common divisor.
const fn common_divisor(mut a: usize, mut b: usize) -> usize {
    while b > 0 {
        (a, b) = (b, a % b);
    }
    a
}

/// Values of designs by lattice index; `None` if a design is excluded or has no value.
pub type Values = BTreeMap<Place, Option<f64>>;

/// Filter of the allowed designs, and function that computes the value of a design, or `None` if it has no value.
pub type Asking<'a> = (&'a (dyn Fn(&Pattern) -> bool + Sync), &'a (dyn Fn(&Pattern) -> Option<f64> + Sync));

/// Climbs from `starts` over designs that the filter `open` allows, until no neighbour improves the value, `most`
/// designs were evaluated, or `monitor` cancels. `known` holds previous values. Returns the designs at which climbs
/// end, each once.
pub fn climb(
    steps: &Steps<'_>,
    starts: &[Place],
    most: usize,
    mut known: Values,
    (open, value): Asking<'_>,
    monitor: &dyn Monitor,
) -> Vec<Pattern> {
    let ask = |known: &mut Values, asked: &[Place]| {
        let one = |place: &Place| {
            let design = steps.design(*place).filter(|design| !monitor.cancelled() && open(design));
            design.and_then(|design| value(&design))
        };
        let found: Vec<Option<f64>> = asked.par_iter().map(one).collect();
        known.extend(asked.iter().copied().zip(found));
    };
    let mut at: BTreeSet<Place> = starts.iter().copied().collect();
    let unknown: Vec<Place> = at.iter().filter(|place| !known.contains_key(*place)).copied().collect();
    ask(&mut known, &unknown);
    let mut left = most;
    for step in STEPS {
        let mut moving = at.clone();
        while !moving.is_empty() && left > 0 && !monitor.cancelled() {
            let about: BTreeSet<Place> = moving.iter().flat_map(|place| steps.about(*place, step)).collect();
            let asked: Vec<Place> = about.into_iter().filter(|place| !known.contains_key(place)).take(left).collect();
            left -= asked.len();
            ask(&mut known, &asked);
            let of = |place: &Place| known.get(place).copied().flatten().unwrap_or(f64::NEG_INFINITY);
            // The first of equal values wins.
            let best = |place: &Place| {
                steps
                    .about(*place, step)
                    .into_iter()
                    .fold(*place, |best, other| if of(&other) > of(&best) { other } else { best })
            };
            let moved: Vec<[Place; 2]> =
                moving.iter().map(|place| [*place, best(place)]).filter(|[from, to]| from != to).collect();
            moved.iter().for_each(|[from, _]| _ = at.remove(from));
            moving = moved.into_iter().map(|[_, to]| to).collect();
            at.extend(&moving);
        }
    }
    at.into_iter().filter_map(|place| steps.design(place)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::task;
    use slipgrid_base::monitor::Unwatched;
    use slipgrid_laser::export::Removal;
    use slipgrid_model::pattern::Planform;

    #[test]
    fn a_climb_ends_where_nothing_about_it_is_better() {
        let task = task(Planform::Groove);
        let steps = Steps::new(&task);
        // Ridge across the axes.
        let value = |design: &Pattern| {
            let [width, spacing, depth] = design.lengths_m().map(|m| 1e6 * m);
            -((width - 140.0) / 20.0).powi(2)
                - ((spacing - 2.0 * width) / 10.0).powi(2)
                - ((depth - 16.0) / 2.0).powi(2)
        };
        let ended = |most: usize| {
            // Start at the widest and deepest grooves with the narrowest gaps.
            let start = [steps.counts[0] - 1, 1, steps.counts[2] - 1];
            assert_eq!(steps.place(&steps.design(start).unwrap()), Some(start));
            let asked = std::sync::atomic::AtomicUsize::default();
            let value = |design: &Pattern| {
                asked.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
                Some(value(design))
            };
            let found = climb(&steps, &[start], most, Values::new(), (&|_| true, &value), &Unwatched);
            assert_eq!(found.len(), 1);
            (found[0], asked.into_inner())
        };
        let (design, asked) = ended(1000);
        assert!((design.width_m() - 140e-6).abs() < 1e-9 && (design.spacing_m() - 280e-6).abs() < 1e-9, "{design:?}");
        assert!((design.depth_m() - 16e-6).abs() < 1e-9 && asked < 400, "{asked}");
        assert_eq!(ended(26).1, 27);
    }

    /// Lines are nearer in some widths than in others, and a pass over them is deeper.
    #[test]
    fn depths_are_whole_passes_over_the_lines_of_each_width() {
        let mut task = task(Planform::Groove);
        task.laser = slipgrid_laser::export::Laser {
            spot_um: Some(25.0),
            depth_per_burst_um: Some(1.0),
            repetition_hz: Some(20e3),
            speed_mm_s: Some(200.0),
            ..task.laser
        };
        let steps = Steps::new(&task);
        let mut passes_um = Vec::new();
        for design in steps.every(1) {
            let removal = Removal::new(&task.specimen.layout(design).unwrap(), &task.laser).unwrap();
            let depth_um = 1e6 * design.depth_m();
            assert!((removal.depth_um / depth_um - 1.0).abs() < 1e-3 && removal.warnings.is_empty(), "{removal:?}");
            assert_eq!(steps.design(steps.place(&design).unwrap()), Some(design));
            passes_um.push(removal.depth_per_pass_um);
        }
        let [least_um, most_um] = slipgrid_base::statistics::extremes(passes_um);
        assert!(least_um > 1.9 && most_um > 1.2 * least_um, "{least_um} {most_um}");
        let [width_m, spacing_m, _] = task.space.lengths_m();
        let within = |task: &mut DesignTask, depth_m: [f64; 2]| {
            task.space = crate::optimize::DesignSpace::new(Planform::Groove, width_m, spacing_m, depth_m).unwrap();
        };
        // A part of the designs has nearly as many as are asked for, also where the bounds begin with many passes.
        within(&mut task, [40e-6, 50e-6]);
        let found = Steps::new(&task).spread(500).len();
        assert!((250..=500).contains(&found), "{found}");
        // A bound in printed digits loses no pass: the deepest design is on it.
        let deepest_m = Steps::new(&task).every(1).map(|design| design.depth_m()).fold(0.0, f64::max);
        within(&mut task, [40e-6, deepest_m * (1.0 - 1e-9)]);
        assert!(Steps::new(&task).every(1).any(|design| design.depth_m() == deepest_m * (1.0 - 1e-9)));
        // The speed makes a fixed depth.
        within(&mut task, [7.77e-6; 2]);
        assert!(Steps::new(&task).every(1).all(|design| design.depth_m() == 7.77e-6));
        // Of very fine passes several are taken at a time.
        task.laser.depth_per_burst_um = Some(1e-7);
        within(&mut task, [2e-6, 50e-6]);
        assert!(Steps::new(&task).counts[2] <= 1001);
    }

    #[test]
    fn a_part_of_very_many_designs_reaches_all_bounds() {
        let mut task = task(Planform::Groove);
        let um = |bounds: [f64; 2]| bounds.map(|um| um * 1e-6);
        let [width, spacing] = [um([60.0, 1060.0]), um([100.0, 1100.0])];
        task.space = crate::optimize::DesignSpace::new(Planform::Groove, width, spacing, um([5.0, 30.0])).unwrap();
        task.layer.block_m = 1e-6;
        let found = Steps::new(&task).spread(5000);
        assert!((2500..=5000).contains(&found.len()), "{}", found.len());
        for axis in 0..3 {
            let [low, high] = task.space.lengths_m()[axis];
            let least = found.iter().map(|of| of.lengths_m()[axis]).fold(f64::INFINITY, f64::min);
            let most = found.iter().map(|of| of.lengths_m()[axis]).fold(0.0, f64::max);
            assert!(least < low + 0.05 * (high - low) && most > high - 0.05 * (high - low), "{axis}: {least} {most}");
        }
    }
}
