//! The designs that may be tried: bounds, limits, and the grid of what a laser can make.
//!
//! Every coordinate is a share t in [0, 1] of the logarithm of the length, because friction follows
//! width / spacing and lengths span a decade. A length is always one of the grid: whole bursts deep
//! (or [`DEPTH_STEP_M`] where no burst is given), width and spacing to [`POSITION_STEP_M`]. So every
//! number that a search reports belongs to a design that can be made, not to one rounded afterwards.

use crate::error::positive;
use crate::low_discrepancy::MOST_DIMENSIONS;
use crate::{Constraints, SearchError};
use slipgrid_pattern::{Arrangement, ManufacturingLimits, Pattern, PatternError, Planform, Texture};

/// Step of width and spacing, in metres: what a laser scanner positions. Coarser loses accuracy
/// (0.1 um moves the friction ratio by about 1e-4), finer gives digits without meaning.
pub const POSITION_STEP_M: f64 = 1e-7;
/// Step of the depth where no depth per burst is given, in metres: what a profilometer resolves.
pub const DEPTH_STEP_M: f64 = 1e-8;
/// Slack, in steps, in counting grid points, so that bounds written in decimal units keep theirs.
const GRID_SLACK: f64 = 1e-6;
/// Longest dimension accepted, in metres.
const LONGEST_M: f64 = 1.0;

/// Bounds of a design, in metres. Equal bounds fix a dimension.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DesignSpace {
    texture: Texture,
    width_m: [f64; 2],
    spacing_m: [f64; 2],
    depth_m: [f64; 2],
}

impl DesignSpace {
    /// Patterns of `texture` with width, spacing and depth in the closed intervals given, in metres.
    /// What else the texture leaves open follows: rows lie as far apart as cavities along them.
    ///
    /// # Errors
    /// [`SearchError::OutOfRange`] unless bounds are positive and at most a metre,
    /// [`SearchError::BoundsReversed`] where a lower bound exceeds the upper.
    pub fn new(
        texture: impl Into<Texture>,
        width_m: [f64; 2],
        spacing_m: [f64; 2],
        depth_m: [f64; 2],
    ) -> Result<Self, SearchError> {
        for (quantity, [lower_m, upper_m]) in [("width", width_m), ("spacing", spacing_m), ("depth", depth_m)] {
            for value in [lower_m, upper_m] {
                if !(value.is_finite() && value > 0.0 && value <= LONGEST_M) {
                    let expected = "a positive length of at most 1 m";
                    return Err(SearchError::OutOfRange { quantity, value, expected });
                }
            }
            if lower_m > upper_m {
                return Err(SearchError::BoundsReversed { quantity, lower_m, upper_m });
            }
        }
        Ok(Self { texture: texture.into(), width_m, spacing_m, depth_m })
    }

    /// The texture of every design.
    #[must_use]
    pub const fn texture(&self) -> &Texture {
        &self.texture
    }

    /// The planform of every design.
    #[must_use]
    pub const fn planform(&self) -> Planform {
        self.texture.planform()
    }

    /// Lower and upper bound of the width, in metres.
    #[must_use]
    pub const fn width_m(&self) -> [f64; 2] {
        self.width_m
    }

    /// Lower and upper bound of the spacing, in metres.
    #[must_use]
    pub const fn spacing_m(&self) -> [f64; 2] {
        self.spacing_m
    }

    /// Lower and upper bound of the depth, in metres.
    #[must_use]
    pub const fn depth_m(&self) -> [f64; 2] {
        self.depth_m
    }

    /// Lower and upper bounds of width, spacing and depth, in metres.
    #[must_use]
    pub const fn lengths_m(&self) -> [[f64; 2]; 3] {
        [self.width_m, self.spacing_m, self.depth_m]
    }

    /// The pattern of these width, spacing and depth, in metres.
    ///
    /// # Errors
    /// [`PatternError`] for lengths that make no pattern.
    pub fn pattern(&self, lengths_m: [f64; 3]) -> Result<Pattern, PatternError> {
        let [width_m, spacing_m, depth_m] = lengths_m;
        Pattern::new(self.texture, width_m, spacing_m, depth_m)
    }

    /// The pattern in the middle of the bounds, by the logarithms of its lengths.
    ///
    /// # Errors
    /// As [`DesignSpace::pattern`].
    pub fn middle(&self) -> Result<Pattern, PatternError> {
        self.pattern(self.lengths_m().map(|[lower_m, upper_m]| (lower_m * upper_m).sqrt()))
    }
}

/// How the values of one dimension are spaced.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Step {
    /// n / per_metre: the double nearest to the decimal number.
    PerMetre(f64),
    /// n times a length.
    Length(f64),
}

impl Step {
    fn at(self, index: u64) -> f64 {
        match self {
            Self::PerMetre(per_metre) => index as f64 / per_metre,
            Self::Length(length_m) => index as f64 * length_m,
        }
    }

    /// The fractional index of a length.
    fn index(self, value_m: f64) -> f64 {
        match self {
            Self::PerMetre(per_metre) => value_m * per_metre,
            Self::Length(length_m) => value_m / length_m,
        }
    }
}

/// One dimension of a design.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Axis {
    Fixed(f64),
    Free { lower_m: f64, upper_m: f64, step: Step, first: u64, last: u64 },
}

impl Axis {
    /// Values of `step` in the interval; `None` if there is none.
    fn on_grid([lower_m, upper_m]: [f64; 2], step: Step) -> Option<Self> {
        // Bounds are at most a metre and steps not below 1e-12 m: the casts are exact.
        let first = (step.index(lower_m) - GRID_SLACK).ceil().max(1.0) as u64;
        let last = (step.index(upper_m) + GRID_SLACK).floor() as u64;
        match first.cmp(&last) {
            std::cmp::Ordering::Greater => None,
            std::cmp::Ordering::Equal => Some(Self::Fixed(step.at(first).clamp(lower_m, upper_m))),
            std::cmp::Ordering::Less => Some(Self::Free { lower_m, upper_m, step, first, last }),
        }
    }

    /// Width, spacing, or a depth without bursts: equal bounds are taken as given, and an interval
    /// between two grid points is fixed at its middle.
    fn position(bounds: [f64; 2], step_m: f64) -> Self {
        if bounds[0] == bounds[1] {
            return Self::Fixed(bounds[0]);
        }
        Self::on_grid(bounds, Step::PerMetre((1.0 / step_m).round()))
            .unwrap_or(Self::Fixed(f64::midpoint(bounds[0], bounds[1])))
    }

    /// The grid value nearest to the share `t` of the logarithm.
    fn at(&self, t: f64) -> f64 {
        match *self {
            Self::Fixed(value_m) => value_m,
            // length = lower (upper / lower)^t
            Self::Free { lower_m, upper_m, .. } => {
                self.on_step(lower_m * (upper_m / lower_m).powf(t.clamp(0.0, 1.0)), f64::round)
            }
        }
    }

    /// The greatest grid value up to `most_m`, or the first.
    fn at_most(&self, most_m: f64) -> f64 {
        self.on_step(most_m, |index| (index + GRID_SLACK).floor())
    }

    /// The least grid value from `least_m` on, or the last.
    fn at_least(&self, least_m: f64) -> f64 {
        self.on_step(least_m, |index| (index - GRID_SLACK).ceil())
    }

    /// The grid value whose index is `whole` of that of `length_m`, or the nearest that there is.
    fn on_step(&self, length_m: f64, whole: fn(f64) -> f64) -> f64 {
        match *self {
            Self::Fixed(value_m) => value_m,
            Self::Free { lower_m, upper_m, step, first, last } => {
                let index = (whole(step.index(length_m)) as u64).clamp(first, last);
                step.at(index).clamp(lower_m, upper_m)
            }
        }
    }

    /// Number of grid values.
    fn values(&self) -> u64 {
        match *self {
            Self::Fixed(_) => 1,
            Self::Free { first, last, .. } => last - first + 1,
        }
    }

    /// The share of the one of `count` grid values that is the `step`-th: evenly spread in t, and each value once
    /// where `count` is all of them.
    fn spread(&self, step: u64, count: u64) -> f64 {
        match *self {
            Self::Free { first, step: grid_step, .. } if count == self.values() => {
                self.share(grid_step.at(first + step))
            }
            _ if count > 1 => step as f64 / (count - 1) as f64,
            _ => 0.5,
        }
    }

    /// The share t of a length; 0 where the axis is fixed.
    fn share(&self, value_m: f64) -> f64 {
        match *self {
            Self::Fixed(_) => 0.0,
            Self::Free { lower_m, upper_m, .. } => {
                ((value_m / lower_m).ln() / (upper_m / lower_m).ln()).clamp(0.0, 1.0)
            }
        }
    }
}

/// The designs that can be made within bounds and limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Grid {
    texture: Texture,
    axes: [Axis; MOST_DIMENSIONS],
    /// First and last whole number of bursts, where depths are counted in bursts.
    bursts: Option<[u64; 2]>,
    depth_per_burst_m: f64,
    limits: ManufacturingLimits,
}

impl Grid {
    /// The grid of `space` under `constraints`.
    ///
    /// # Errors
    /// [`SearchError::LimitAboveBounds`] or [`SearchError::NoWholeBurst`] where nothing is left,
    /// [`SearchError::OutOfRange`] for a limit that is not positive.
    pub(crate) fn new(space: &DesignSpace, constraints: &Constraints) -> Result<Self, SearchError> {
        let limits = &constraints.limits;
        let above = |quantity, [lower_m, upper_m]: [f64; 2], limit: &'static str, limit_m: Option<f64>| {
            let Some(limit_m) = limit_m else { return Ok([lower_m, upper_m]) };
            positive(limit, limit_m)?;
            if limit_m > upper_m {
                return Err(SearchError::LimitAboveBounds { quantity, upper_m, limit, limit_m });
            }
            Ok([lower_m.max(limit_m), upper_m])
        };
        let width_m = above("width", space.width_m, "diameter of the laser spot", limits.spot_m)?;
        let spacing_m = above("spacing", space.spacing_m, "smallest land", limits.min_land_m)?;
        if let Some(length_m) = space.texture.length_m() {
            above("length", [length_m; 2], "diameter of the laser spot", limits.spot_m)?;
        }
        // Between staggered rows the land is wider than the spacing across them: each design tells.
        if let Some(spacing_m) = space.texture.spacing_across_m()
            && space.texture.arrangement() == Arrangement::Square
        {
            above("spacing across", [spacing_m; 2], "smallest land", limits.min_land_m)?;
        }
        constraints.validate()?;
        let (depth, bursts) = match limits.depth_per_burst_m {
            None => (Axis::position(space.depth_m, DEPTH_STEP_M), None),
            Some(depth_per_burst_m) => burst_axis(space.depth_m, depth_per_burst_m)?,
        };
        let axes = [Axis::position(width_m, POSITION_STEP_M), Axis::position(spacing_m, POSITION_STEP_M), depth];
        let depth_per_burst_m = limits.depth_per_burst_m.unwrap_or(DEPTH_STEP_M);
        Ok(Self { texture: space.texture, axes, bursts, depth_per_burst_m, limits: *limits })
    }

    /// Indices of the axes that are not fixed.
    pub(crate) fn free_axes(&self) -> Vec<usize> {
        (0..MOST_DIMENSIONS).filter(|&axis| matches!(self.axes[axis], Axis::Free { .. })).collect()
    }

    /// First and last whole number of bursts, where the depth is free and counted in bursts.
    pub(crate) const fn bursts(&self) -> Option<[u64; 2]> {
        self.bursts
    }

    /// Number of grid values of an axis.
    pub(crate) fn values(&self, axis: usize) -> u64 {
        self.axes[axis].values()
    }

    /// The share of the `step`-th of `count` values of an axis, evenly spread.
    pub(crate) fn spread(&self, axis: usize, step: u64, count: u64) -> f64 {
        self.axes[axis].spread(step, count)
    }

    /// Bursts that make `design`.
    pub(crate) fn bursts_of(&self, design: &Pattern) -> u64 {
        (design.depth_m() / self.depth_per_burst_m).round() as u64
    }

    /// The same grid with the depth fixed at `bursts` bursts.
    pub(crate) fn at_bursts(mut self, bursts: u64) -> Self {
        if let Axis::Free { lower_m, upper_m, step, .. } = self.axes[2] {
            self.axes[2] = Axis::Fixed(step.at(bursts).clamp(lower_m, upper_m));
        }
        self.bursts = None;
        self
    }

    /// The designs one grid step from `design` along each free axis.
    pub(crate) fn neighbours(&self, design: &Pattern) -> Vec<Pattern> {
        let lengths = design.lengths_m();
        let mut neighbours = Vec::new();
        for (axis, kind) in self.axes.iter().enumerate() {
            let Axis::Free { lower_m, upper_m, step, first, last } = *kind else { continue };
            let index = (step.index(lengths[axis]).round() as u64).clamp(first, last);
            for index in [index.saturating_sub(1), index + 1] {
                if (first..=last).contains(&index) {
                    let mut moved = lengths;
                    moved[axis] = step.at(index).clamp(lower_m, upper_m);
                    neighbours.extend(Pattern::new(self.texture, moved[0], moved[1], moved[2]));
                }
            }
        }
        neighbours.retain(|moved| !self.limits.walls_meet(moved));
        neighbours
    }

    /// The same grid with a free `axis` fixed at its lower or upper end.
    pub(crate) fn at_end(mut self, axis: usize, is_upper: bool) -> Self {
        self.axes[axis] = Axis::Fixed(self.axes[axis].at(if is_upper { 1.0 } else { 0.0 }));
        if axis == 2 {
            self.bursts = None;
        }
        self
    }

    /// The design nearest to the shares `t`, one per axis; shares of fixed axes are ignored. Where walls that lean would meet in it, it is as
    /// deep as they allow, or where its depth is fixed as wide as they need, if the grid has that.
    pub(crate) fn design(&self, t: &[f64; MOST_DIMENSIONS]) -> Option<Pattern> {
        let [width_m, spacing_m, depth_m] = std::array::from_fn(|axis| self.axes[axis].at(t[axis]));
        // Every length of the grid is positive and finite: always a pattern.
        let pattern = |width_m: f64, depth_m: f64| Pattern::new(self.texture, width_m, spacing_m, depth_m).ok();
        let found = pattern(width_m, depth_m)?;
        let Some(deepest_m) = self.limits.deepest_m(&found).filter(|_| self.limits.walls_meet(&found)) else {
            return Some(found);
        };
        let shallower = pattern(width_m, self.axes[2].at_most(deepest_m))?;
        if !self.limits.walls_meet(&shallower) {
            return Some(shallower);
        }
        let wider_m = width_m * shallower.depth_m() / deepest_m;
        pattern(self.axes[0].at_least(wider_m), shallower.depth_m())
    }

    /// The shares of `design`.
    pub(crate) fn shares(&self, design: &Pattern) -> [f64; MOST_DIMENSIONS] {
        let lengths = design.lengths_m();
        std::array::from_fn(|axis| self.axes[axis].share(lengths[axis]))
    }

    /// Largest difference of the shares of two designs, from 0 to 1.
    pub(crate) fn distance(&self, left: &Pattern, right: &Pattern) -> f64 {
        let (left, right) = (self.shares(left), self.shares(right));
        (0..MOST_DIMENSIONS).map(|axis| (left[axis] - right[axis]).abs()).fold(0.0, f64::max)
    }
}

/// The depths that are whole numbers of bursts.
fn burst_axis([lower_m, upper_m]: [f64; 2], depth_per_burst_m: f64) -> Result<(Axis, Option<[u64; 2]>), SearchError> {
    const FINEST_BURST_M: f64 = 1e-12;
    positive("depth per burst", depth_per_burst_m)?;
    if depth_per_burst_m < FINEST_BURST_M {
        let expected = "at least 1e-12 m";
        return Err(SearchError::OutOfRange { quantity: "depth per burst", value: depth_per_burst_m, expected });
    }
    match Axis::on_grid([lower_m, upper_m], Step::Length(depth_per_burst_m)) {
        Some(axis @ Axis::Free { first, last, .. }) => Ok((axis, Some([first, last]))),
        Some(axis @ Axis::Fixed(_)) => Ok((axis, None)),
        None => {
            let below_m = (lower_m / depth_per_burst_m).floor() * depth_per_burst_m;
            let above_m = (upper_m / depth_per_burst_m).ceil() * depth_per_burst_m;
            let nearest_m = if below_m > 0.0 && lower_m - below_m <= above_m - upper_m { below_m } else { above_m };
            Err(SearchError::NoWholeBurst { lower_m, upper_m, depth_per_burst_m, nearest_m })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(width_um: [f64; 2], depth_um: [f64; 2], limits: ManufacturingLimits) -> Result<Grid, SearchError> {
        let metres = |bounds: [f64; 2]| bounds.map(|bound| bound * 1e-6);
        let space = DesignSpace::new(Planform::Groove, metres(width_um), metres([40.0, 1000.0]), metres(depth_um))?;
        Grid::new(&space, &Constraints { limits, ..Constraints::default() })
    }

    fn bursts_of(micrometres: f64) -> ManufacturingLimits {
        ManufacturingLimits { depth_per_burst_m: Some(micrometres * 1e-6), ..Default::default() }
    }

    #[test]
    fn every_design_lies_on_the_grid_and_within_bounds() {
        let grid = grid([40.03, 400.0], [2.0, 50.0], bursts_of(2.6)).unwrap();
        assert_eq!(grid.bursts(), Some([1, 19]));
        for n in 0..=1000 {
            let design = grid.design(&[f64::from(n) / 1000.0; 3]).unwrap();
            let tenths = design.width_m() * 1e7;
            assert!((tenths - tenths.round()).abs() < 1e-6);
            assert!((40.1e-6 - 1e-12..=400e-6).contains(&design.width_m()));
            let bursts = design.depth_m() / 2.6e-6;
            assert!((bursts - bursts.round()).abs() < 1e-9 && (2e-6..=50e-6).contains(&design.depth_m()));
            // Shares lead back to the same bits.
            assert_eq!(grid.design(&grid.shares(&design)).unwrap(), design);
        }
    }

    #[test]
    fn limits_cut_the_bounds_exactly() {
        // 0.1 + 0.2 style limits: no design may break one by rounding.
        let limits =
            ManufacturingLimits { min_land_m: Some(47.3 * 1e-6), spot_m: Some(80.7 * 1e-6), ..Default::default() };
        let lowest = grid([40.0, 400.0], [2.0, 50.0], limits).unwrap().design(&[0.0; 3]).unwrap();
        assert!(limits.violations(&lowest).is_empty());
        assert!((lowest.width_m() - 80.7e-6).abs() < 1e-12 && (lowest.spacing_m() - 47.3e-6).abs() < 1e-12);
        let narrow = ManufacturingLimits { spot_m: Some(500e-6), ..Default::default() };
        assert!(matches!(grid([40.0, 400.0], [2.0, 50.0], narrow), Err(SearchError::LimitAboveBounds { .. })));
    }

    #[test]
    fn fixed_dimensions_are_taken_as_given() {
        let grid = grid([123.456_789, 123.456_789], [5.2, 5.2], bursts_of(2.6)).unwrap();
        assert_eq!(grid.free_axes(), vec![1]);
        let design = grid.design(&[0.3; 3]).unwrap();
        assert_eq!(design.width_m(), 123.456_789 * 1e-6);
        assert_eq!(design.depth_m(), 5.2 * 1e-6);
    }

    #[test]
    fn depth_without_a_whole_burst_names_the_nearest() {
        for (depth_um, nearest_um) in [([5.5, 7.0], 5.2), ([6.9, 7.7], 7.8), ([1.0, 2.0], 2.6)] {
            match grid([40.0, 400.0], depth_um, bursts_of(2.6)) {
                Err(SearchError::NoWholeBurst { nearest_m, .. }) => {
                    assert!((nearest_m * 1e6 - nearest_um).abs() < 1e-9, "{nearest_m}");
                }
                other => panic!("{other:?}"),
            }
        }
    }

    #[test]
    fn bounds_that_mean_nothing_are_refused() {
        assert!(matches!(grid([-1.0, 400.0], [2.0, 50.0], bursts_of(2.6)), Err(SearchError::OutOfRange { .. })));
        assert!(matches!(grid([400.0, 40.0], [2.0, 50.0], bursts_of(2.6)), Err(SearchError::BoundsReversed { .. })));
        assert!(matches!(grid([40.0, 400.0], [2.0, 50.0], bursts_of(0.0)), Err(SearchError::OutOfRange { .. })));
    }

    #[test]
    fn designs_have_the_texture_of_their_space_and_its_lengths_obey_the_limits() {
        let staggered = Texture::new(Planform::Rectangle).with_arrangement(Arrangement::Staggered).unwrap();
        let texture = staggered.with_length_m(30e-6).unwrap().with_sliding_angle_deg(45.0).unwrap();
        let grid = |texture: Texture, limits| {
            let space = DesignSpace::new(texture, [40e-6, 400e-6], [40e-6, 1e-3], [2e-6, 50e-6]).unwrap();
            assert_eq!(*space.texture(), texture);
            Grid::new(&space, &Constraints { limits, ..Constraints::default() })
        };
        let limits =
            ManufacturingLimits { min_land_m: Some(20e-6), spot_m: Some(23e-6), ..ManufacturingLimits::default() };
        let design = grid(texture, limits).unwrap().design(&[0.4; 3]).unwrap();
        assert_eq!(*design.texture(), texture);
        // Rows follow the spacing searched.
        assert_eq!(design.spacing_across_m(), Some(design.spacing_m()));

        let refused = grid(texture.with_length_m(22e-6).unwrap(), limits);
        assert!(matches!(refused, Err(SearchError::LimitAboveBounds { quantity: "length", .. })));
        let near = texture.with_spacing_across_m(15e-6).unwrap();
        assert!(grid(near, limits).is_ok());
        let refused = grid(near.with_arrangement(Arrangement::Square).unwrap(), limits);
        assert!(matches!(refused, Err(SearchError::LimitAboveBounds { quantity: "spacing across", .. })));
    }
}
