//! Rims: what a laser melts out of a cavity and leaves standing along its edge.
//!
//! The rim of a cavity stands on the land over its width w. At the distance d from the edge the land is raised by
//!
//! ```text
//! r(d) = h phi(d / w),     phi(s) = 1 (flat), 1 - s (ramp), 1 - s^2 (round), sin(pi s) (half-sine),     0 <= s <= 1
//! ```
//!
//! Between two cavities nearer than two widths the rims end half-way, so that each point belongs to the nearest edge.

use std::f64::consts::PI;
use std::fmt;
use std::str::FromStr;

use crate::error::length;
use crate::{Pattern, PatternError, Planform};

/// Highest rim that is accepted, in metres.
const MOST_HEIGHT_M: f64 = 1e-3;
/// Nodes and weights on [0, 1] of Gauss and Legendre's rule of 8 points, the first half; the others mirror them.
const GAUSS: [[f64; 2]; 4] = [
    [0.019_855_071_751_231_9, 0.050_614_268_145_188_1],
    [0.101_666_761_293_186_6, 0.111_190_517_226_687_2],
    [0.237_233_795_041_835_5, 0.156_853_322_938_943_6],
    [0.408_282_678_752_175_1, 0.181_341_891_689_181],
];

/// How a rim falls from the edge of its cavity outward.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum RimProfile {
    /// As a parabola with its crest at the edge: 1 - s^2.
    #[default]
    Round,
    /// Not at all, up to its width.
    Flat,
    /// In a straight line: 1 - s.
    Ramp,
    /// As an arch with its crest at half its width: sin(pi s). Measured rims may be so.
    HalfSine,
}

impl RimProfile {
    /// Those that a pattern's files may name, in the order in which help texts list them.
    pub const ALL: [Self; 3] = [Self::Round, Self::Flat, Self::Ramp];
    /// Those that a measured rim is compared with, in the order in which help texts list them.
    pub const MEASURED: [Self; 4] = [Self::Round, Self::Flat, Self::Ramp, Self::HalfSine];

    /// The name used in files, options and results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Round => "round",
            Self::Flat => "flat",
            Self::Ramp => "ramp",
            Self::HalfSine => "half-sine",
        }
    }

    /// Height over the greatest, at the distance `s` from the edge over the rim's width; 0 outside 0 to 1.
    #[must_use]
    pub fn height(self, s: f64) -> f64 {
        match self {
            _ if !(0.0..=1.0).contains(&s) => 0.0,
            Self::Round => 1.0 - s * s,
            Self::Flat => 1.0,
            Self::Ramp => 1.0 - s,
            Self::HalfSine => libm::sin(PI * s),
        }
    }

    /// Integral of [`Self::height`] from the edge to `s`.
    #[must_use]
    pub fn integral(self, s: f64) -> f64 {
        let s = s.clamp(0.0, 1.0);
        match self {
            Self::Round => s * (1.0 - s * s / 3.0),
            Self::Flat => s,
            Self::Ramp => s * (1.0 - 0.5 * s),
            Self::HalfSine => (1.0 - libm::cos(PI * s)) / PI,
        }
    }

    /// Integral of the height over the greatest of a rim `width_m` wide between the distances `from_m` and `to_m` from the
    /// edge, in metres.
    #[must_use]
    pub fn integral_m(self, width_m: f64, from_m: f64, to_m: f64) -> f64 {
        let to = |distance_m: f64| self.integral(distance_m / width_m);
        width_m * (to(to_m) - to(from_m))
    }

    /// Mean of the same.
    #[must_use]
    pub fn mean(self, width_m: f64, from_m: f64, to_m: f64) -> f64 {
        self.integral_m(width_m, from_m, to_m) / (to_m - from_m)
    }

    /// How steeply it falls at `s`.
    fn fall(self, s: f64) -> f64 {
        match self {
            Self::Round => 2.0 * s,
            Self::Flat => 0.0,
            Self::Ramp => 1.0,
            Self::HalfSine => -PI * libm::cos(PI * s),
        }
    }
}

impl fmt::Display for RimProfile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for RimProfile {
    type Err = PatternError;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        let found = Self::ALL.into_iter().find(|profile| profile.name() == name);
        found.ok_or_else(|| PatternError::UnknownRimProfile { name: name.to_owned() })
    }
}

/// The rim of every cavity of a texture. Lengths in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rim {
    /// Depth of a cavity and height of its rim, ascending in depth; the first `known` count.
    heights_m: [[f64; 2]; Self::MOST_HEIGHTS],
    known: usize,
    width_m: f64,
    profile: RimProfile,
    height_std_m: f64,
}

impl Rim {
    /// Most depths for which heights may be given.
    pub const MOST_HEIGHTS: usize = 8;

    /// A rim `height_m` above the land at the edge of the cavity and `width_m` wide, whatever the cavity's depth.
    ///
    /// # Errors
    /// [`PatternError::RimHeight`] unless the height lies from 0 to 1 mm, [`PatternError::NotALength`] for the width.
    pub fn new(height_m: f64, width_m: f64, profile: RimProfile) -> Result<Self, PatternError> {
        Self::following_depth(&[[0.0, height_m]], width_m, profile)
    }

    /// A rim whose height follows the depth of its cavity: `heights_m` holds pairs of depth and height, ascending in depth,
    /// between which heights lie on straight lines; below the first depth and beyond the last they stay.
    ///
    /// # Errors
    /// As [`Self::new`]; [`PatternError::RimHeights`] without a pair, with more than 8, and for depths that do not ascend.
    pub fn following_depth(heights_m: &[[f64; 2]], width_m: f64, profile: RimProfile) -> Result<Self, PatternError> {
        let ascends = heights_m.windows(2).all(|pair| pair[0][0] < pair[1][0]);
        let is_depth = heights_m.iter().all(|[depth_m, _]| depth_m.is_finite() && *depth_m >= 0.0);
        if heights_m.is_empty() || heights_m.len() > Self::MOST_HEIGHTS || !ascends || !is_depth {
            return Err(PatternError::RimHeights { count: heights_m.len(), most: Self::MOST_HEIGHTS });
        }
        for [_, height_m] in heights_m {
            height("rim height", *height_m)?;
        }
        let mut known = [[0.0; 2]; Self::MOST_HEIGHTS];
        known[..heights_m.len()].copy_from_slice(heights_m);
        let width_m = length("rim width", width_m)?;
        Ok(Self { heights_m: known, known: heights_m.len(), width_m, profile, height_std_m: 0.0 })
    }

    /// The same with heights that scatter from rim to rim by the standard deviation `height_std_m`.
    ///
    /// # Errors
    /// [`PatternError::RimHeight`] unless it lies from 0 to 1 mm.
    pub fn with_height_std_m(mut self, height_std_m: f64) -> Result<Self, PatternError> {
        self.height_std_m = height("scatter of rim heights", height_std_m)?;
        Ok(self)
    }

    /// The same with every height moved by `by_m`, in metres, and none below zero.
    #[must_use]
    pub fn raised(mut self, by_m: f64) -> Self {
        for [_, height_m] in &mut self.heights_m[..self.known] {
            *height_m = (*height_m + by_m).clamp(0.0, MOST_HEIGHT_M);
        }
        self
    }

    /// The same with every height `factor` times as high, from 0 to 1 mm.
    #[must_use]
    pub fn times(mut self, factor: f64) -> Self {
        for [_, height_m] in &mut self.heights_m[..self.known] {
            *height_m = (*height_m * factor).clamp(0.0, MOST_HEIGHT_M);
        }
        self
    }

    /// Whether it rises above the land anywhere: a height or their scatter is not nil.
    #[must_use]
    pub fn stands(&self) -> bool {
        self.height_std_m > 0.0 || self.heights_m().iter().any(|[_, height_m]| *height_m > 0.0)
    }

    /// Height above the land at the edge of a cavity `depth_m` deep, in metres.
    #[must_use]
    pub fn height_m(&self, depth_m: f64) -> f64 {
        let known = self.heights_m();
        let after = known.partition_point(|[at_m, _]| *at_m <= depth_m);
        match (after.checked_sub(1).map(|before| known[before]), known.get(after)) {
            (Some([d0, h0]), Some([d1, h1])) => h0 + (h1 - h0) * (depth_m - d0) / (d1 - d0),
            (Some([_, height_m]), None) => height_m,
            (None, first) => first.map_or(0.0, |[_, height_m]| *height_m),
        }
    }

    /// Pairs of depth and height, in metres, ascending in depth; one pair where heights follow no depth.
    #[must_use]
    pub fn heights_m(&self) -> &[[f64; 2]] {
        &self.heights_m[..self.known]
    }

    /// Distance from the edge at which it ends, in metres.
    #[must_use]
    pub const fn width_m(&self) -> f64 {
        self.width_m
    }

    /// The largest length of which it is at least two wide and `block_m` a whole multiple, in metres: blocks that hold its shape.
    #[must_use]
    pub fn block_m(&self, block_m: f64) -> f64 {
        // A rim of two blocks but for rounding has two.
        block_m / (2.0 * block_m / self.width_m - 1e-9).ceil().max(1.0)
    }

    /// How it falls outward.
    #[must_use]
    pub const fn profile(&self) -> RimProfile {
        self.profile
    }

    /// Standard deviation of heights from rim to rim, in metres.
    #[must_use]
    pub const fn height_std_m(&self) -> f64 {
        self.height_std_m
    }

    /// Integral of the height over that at the edge between the distances `from_m` and `to_m` from it, in metres.
    #[must_use]
    pub fn integral_m(&self, from_m: f64, to_m: f64) -> f64 {
        self.profile.integral_m(self.width_m, from_m, to_m)
    }
}

impl Pattern {
    /// Height of the rims, in metres, where there are any.
    #[must_use]
    pub fn rim_height_m(&self) -> f64 {
        self.texture().rim().map_or(0.0, |rim| rim.height_m(self.depth_m()))
    }

    /// Mean height over that at an edge, from 0 to 1, of the rims on the land of the rectangle `[x0_m, x1_m] x [y0_m, y1_m]`,
    /// which lies as that of [`Self::coverage`] does; 0 where there is no land. Continuous in the rectangle and in every
    /// dimension.
    ///
    /// A rim is the region of all points within a distance of the cavity; that of a square or a rectangle keeps its corners.
    #[must_use]
    pub fn rim_share(&self, x0_m: f64, x1_m: f64, y0_m: f64, y1_m: f64) -> f64 {
        let Some(rim) = self.texture().rim() else { return 0.0 };
        let cavity = self.coverage(x0_m, x1_m, y0_m, y1_m);
        let land = 1.0 - cavity;
        // No wider than half of the narrowest land: there the next rim begins.
        let widest_m = rim.width_m().min(0.5 * self.least_land_m());
        let beyond = |distance_m: f64| self.coverage_within(distance_m, [x0_m, x1_m], [y0_m, y1_m]) - cavity;
        let whole = beyond(widest_m);
        if land <= 0.0 || whole <= 0.0 {
            return 0.0;
        }
        // integral of phi over the land = phi(end) A(end) + integral of -phi'(s) A(s) ds, A(s) what lies within s w
        let end = widest_m / rim.width_m();
        let mut mean = rim.profile().height(end * (1.0 - f64::EPSILON)) * whole;
        if rim.profile() != RimProfile::Flat {
            let mut ends_m = self.kinks_m([x0_m, x1_m], [y0_m, y1_m]);
            ends_m.retain(|distance_m| (0.0..widest_m).contains(distance_m));
            ends_m.extend([0.0, widest_m]);
            ends_m.sort_by(f64::total_cmp);
            for piece in ends_m.windows(2).filter(|piece| piece[1] > piece[0]) {
                let length_m = piece[1] - piece[0];
                for (node, weight) in GAUSS.iter().flat_map(|[node, weight]| [(*node, weight), (1.0 - node, weight)]) {
                    let distance_m = piece[0] + length_m * node;
                    let s = distance_m / rim.width_m();
                    mean += length_m / rim.width_m() * weight * rim.profile().fall(s) * beyond(distance_m);
                }
            }
        }
        (mean / land).clamp(0.0, 1.0)
    }
}

impl Pattern {
    /// Distances from a cavity at which the area within it in the rectangle `x_m` by `y_m` is not smooth: where outlines pass
    /// the rectangle's sides and corners.
    fn kinks_m(&self, x_m: [f64; 2], y_m: [f64; 2]) -> Vec<f64> {
        let (cell_m, half_m) = (self.cell_m(), [Some(self.width_m()), self.length_m()].map(|m| m.map(|m| 0.5 * m)));
        let mut kinks_m = Vec::new();
        for centre_m in self.centres_m() {
            // Distances of the sides from the nearest centres before and after.
            let seen = |ends_m: [f64; 2], axis: usize| {
                ends_m
                    .map(|at_m| (at_m - centre_m[axis]).rem_euclid(cell_m[axis]))
                    .map(|m| [m, cell_m[axis] - m])
                    .concat()
            };
            let [x, y] = [seen(x_m, 0), seen(y_m, 1)];
            for (distances_m, half_m) in [(&x, half_m[0]), (&y, half_m[1])] {
                if let Some(half_m) = half_m {
                    kinks_m.extend(distances_m.iter().map(|distance_m| distance_m - half_m));
                }
            }
            if self.planform() == Planform::Disc {
                let corners = x.iter().flat_map(|x| y.iter().map(|y| x.hypot(*y)));
                kinks_m.extend(corners.map(|distance_m| distance_m - 0.5 * self.width_m()));
            }
        }
        kinks_m
    }
}

fn height(quantity: &'static str, value_m: f64) -> Result<f64, PatternError> {
    if (0.0..=MOST_HEIGHT_M).contains(&value_m) {
        // A negative zero would print as one.
        Ok(value_m + 0.0)
    } else {
        Err(PatternError::RimHeight { quantity, value_m })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Planform, Polygon, Texture};

    fn rimmed(planform: Planform, profile: RimProfile) -> Pattern {
        let rim = Rim::new(0.5e-6, 20e-6, profile).unwrap();
        Pattern::new(Texture::new(planform).with_rim(rim), 130e-6, 70e-6, 20e-6).unwrap()
    }

    #[test]
    fn names_read_back_and_others_are_refused_with_all_that_are_accepted() {
        for profile in RimProfile::ALL {
            assert_eq!(profile.name().parse::<RimProfile>().unwrap(), profile);
        }
        let refused = "square".parse::<RimProfile>().unwrap_err().to_string();
        assert!(RimProfile::ALL.iter().all(|profile| refused.contains(profile.name())), "{refused}");
    }

    #[test]
    fn integrals_are_those_of_heights() {
        for profile in RimProfile::MEASURED {
            for s in [0.2, 0.5, 1.0, 1.7] {
                let parts = 20_000;
                let sum: f64 = (0..parts).map(|n| profile.height(s * (f64::from(n) + 0.5) / f64::from(parts))).sum();
                assert!((sum * s / f64::from(parts) - profile.integral(s)).abs() < 1e-4, "{profile} {s}");
            }
            let crest = (0..=1000).map(|n| profile.height(f64::from(n) / 1000.0)).fold(0.0, f64::max);
            assert!((crest - 1.0).abs() < 1e-12 && profile.height(1.001) == 0.0 && profile.height(-0.001) == 0.0);
        }
        // A flat rim of 4 um covers half of the pixel from 3 to 5 um, a quarter of that from -1.5 to 0.5 um.
        assert!((RimProfile::Flat.mean(4e-6, 3e-6, 5e-6) - 0.5).abs() < 1e-12);
        assert!((RimProfile::Flat.mean(4e-6, -1.5e-6, 0.5e-6) - 0.25).abs() < 1e-12);
    }

    #[test]
    fn heights_follow_the_depth_between_what_was_measured_and_stay_beyond() {
        let rim = Rim::following_depth(&[[5e-6, 0.1e-6], [15e-6, 0.5e-6]], 1e-5, RimProfile::Flat).unwrap();
        for (depth_m, height_m) in [(1e-6, 0.1e-6), (5e-6, 0.1e-6), (10e-6, 0.3e-6), (15e-6, 0.5e-6), (1e-3, 0.5e-6)] {
            assert!((rim.height_m(depth_m) - height_m).abs() < 1e-18, "{depth_m}");
        }
        assert!((rim.raised(-0.2e-6).height_m(20e-6) - 0.3e-6).abs() < 1e-18);
        assert_eq!(rim.raised(-0.2e-6).height_m(0.0), 0.0);
        for bad in [&[][..], &[[5e-6, 0.0], [5e-6, 1e-7]], &[[-1e-6, 1e-7]], &[[f64::NAN, 1e-7]], &[[0.0, 0.0]; 9]] {
            assert!(matches!(Rim::following_depth(bad, 1e-5, RimProfile::Flat), Err(PatternError::RimHeights { .. })));
        }
        for bad in [-1e-7, f64::NAN, 2e-3] {
            assert!(matches!(Rim::new(bad, 1e-5, RimProfile::Round), Err(PatternError::RimHeight { .. })));
        }
    }

    #[test]
    fn blocks_are_at_most_half_a_rim_and_a_whole_number_of_times_smaller() {
        for (rim_um, block_um) in [(10.0, 5.0), (20.0, 10.0), (50.0, 10.0), (12.0, 5.0), (6.0, 2.5), (3.0, 10.0 / 7.0)]
        {
            let found_m = Rim::new(1e-7, rim_um * 1e-6, RimProfile::Round).unwrap().block_m(10e-6);
            assert!((found_m * 1e6 - block_um).abs() < 1e-9, "{rim_um}: {found_m}");
        }
    }

    #[test]
    fn blocks_that_fill_a_cell_hold_the_volume_of_the_rims() {
        // Areas of what lies within d of the cavity: 2 d per length, a square ring, an annulus.
        let ring = |d: f64| 4.0 * d * (130e-6 + d);
        let annulus = |d: f64| std::f64::consts::PI * d * (130e-6 + d);
        let w = 20e-6;
        for profile in RimProfile::ALL {
            // integral of phi dA by many thin rings
            let volume = |area: &dyn Fn(f64) -> f64| -> f64 {
                let thin =
                    |n: i32| (f64::from(n) / 20_000.0, (f64::from(n) + 0.5) / 20_000.0, f64::from(n + 1) / 20_000.0);
                (0..20_000).map(thin).map(|(a, m, b)| profile.height(m) * (area(b * w) - area(a * w))).sum()
            };
            let groove = |d: f64| 2.0 * d * 200e-6;
            for (planform, expected) in [
                (Planform::Groove, volume(&groove)),
                (Planform::Square, volume(&ring)),
                (Planform::Disc, volume(&annulus)),
            ] {
                let pattern = rimmed(planform, profile);
                for blocks in [20, 27] {
                    let side = 200e-6 / f64::from(blocks);
                    let edges = |n: i32| (f64::from(n) * side - 31e-6, f64::from(n + 1) * side - 31e-6);
                    let cells = (0..blocks * blocks).map(|n| (edges(n % blocks), edges(n / blocks)));
                    let found: f64 = cells
                        .map(|((x0, x1), (y0, y1))| {
                            let land = 1.0 - pattern.coverage(x0, x1, y0, y1);
                            pattern.rim_share(x0, x1, y0, y1) * land * side * side
                        })
                        .sum();
                    assert!((found / expected - 1.0).abs() < 1e-5, "{planform} {profile} {blocks}: {found} {expected}");
                }
            }
        }
    }

    #[test]
    fn shares_of_small_blocks_are_those_of_points() {
        for (planform, exact) in [(Planform::Groove, 1e-9), (Planform::Square, 1e-9), (Planform::Disc, 1e-4)] {
            for profile in RimProfile::ALL {
                let pattern = rimmed(planform, profile);
                for (x, y) in [(63.0, 3.0), (71.5, -12.0), (64.0, 62.0), (80.0, 50.0), (40.0, 45.0), (47.0, 47.0)] {
                    let [x, y] = [x, y].map(|from: f64| [from * 1e-6, (from + 4.0) * 1e-6]);
                    let whole = pattern.rim_share(x[0], x[1], y[0], y[1]);
                    // The same from 16 x 16 parts, by their lands.
                    let part = |ends: [f64; 2], n: i32| {
                        [0, 1].map(|k| ends[0] + (ends[1] - ends[0]) * f64::from(n + k) / 16.0)
                    };
                    let (mut sum, mut land) = (0.0, 0.0);
                    for (i, j) in (0..16).flat_map(|i| (0..16).map(move |j| (i, j))) {
                        let ([x0, x1], [y0, y1]) = (part(x, i), part(y, j));
                        let own = 1.0 - pattern.coverage(x0, x1, y0, y1);
                        sum += own * pattern.rim_share(x0, x1, y0, y1);
                        land += own;
                    }
                    let parts = if land > 0.0 { sum / land } else { 0.0 };
                    assert!((whole - parts).abs() < exact, "{planform} {profile} {x:?}: {whole} {parts}");
                }
            }
        }
    }

    #[test]
    fn the_rims_of_outlines_and_of_crossing_grooves_are_those_of_the_plain_shapes() {
        let rim = Rim::new(0.5e-6, 20e-6, RimProfile::Ramp).unwrap();
        let of = |texture: Texture| Pattern::new(texture.with_rim(rim), 130e-6, 70e-6, 20e-6).unwrap();
        // A disc against a polygon of 360 corners, whose rim is the same but for flattened arcs.
        let corners: Vec<[f64; 2]> = (0..360).map(|n| f64::from(n).to_radians()).map(|a| [a.cos(), a.sin()]).collect();
        let outline = Polygon::new(&corners).unwrap();
        let polygon = of(Texture::new(Planform::Polygon).with_outline(outline).unwrap());
        let disc = of(Texture::new(Planform::Disc));
        let crossing = of(Texture::new(Planform::Crosshatch));
        let groove = of(Texture::new(Planform::Groove));
        for (x, y) in [(63.0, 3.0), (71.5, -12.0), (48.0, 48.0), (10.0, 72.0)] {
            let [x, y] = [x, y].map(|from: f64| [from * 1e-6, (from + 8.0) * 1e-6]);
            let share = |pattern: &Pattern| pattern.rim_share(x[0], x[1], y[0], y[1]);
            assert!((share(&polygon) - share(&disc)).abs() < 2e-3, "{x:?}: {} {}", share(&polygon), share(&disc));
        }
        // Far from the other family a land beside one groove is that of grooves: its middle lies half a pitch away.
        let share = |pattern: &Pattern| pattern.rim_share(66e-6, 73e-6, 97e-6, 103e-6);
        assert!((share(&crossing) - share(&groove)).abs() < 1e-12);
    }

    #[test]
    fn rims_that_meet_end_half_way() {
        let rim = Rim::new(0.5e-6, 20e-6, RimProfile::Ramp).unwrap();
        let pattern = Pattern::new(Texture::new(Planform::Groove).with_rim(rim), 100e-6, 20e-6, 20e-6).unwrap();
        // 1 - s from the edge to half a width: 3/4 in the mean.
        assert!((pattern.rim_share(50e-6, 70e-6, 0.0, 1e-6) - 0.75).abs() < 1e-12);
        assert_eq!(pattern.rim_share(-10e-6, 10e-6, 0.0, 1e-6), 0.0);
    }

    #[test]
    fn shares_are_continuous_in_the_rim_and_in_the_cavity() {
        for (planform, profile) in [(Planform::Groove, RimProfile::Flat), (Planform::Square, RimProfile::Round)] {
            let share = |width_um: f64, rim_um: f64| {
                let rim = Rim::new(1e-6, rim_um * 1e-6, profile).unwrap();
                let texture = Texture::new(planform).with_rim(rim);
                let pattern = Pattern::new(texture, width_um * 1e-6, 1e-4, 2e-5).unwrap();
                pattern.rim_share(60e-6, 70e-6, 0.0, 10e-6)
            };
            let steps = |values: Vec<f64>| values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
            let along_rim = steps((1..400).map(|n| share(110.0, 0.1 * f64::from(n))).collect());
            let along_width = steps((0..380).map(|n| share(100.0 + 0.1 * f64::from(n), 12.0)).collect());
            assert!(along_rim < 0.02 && along_width < 0.03, "{planform}: {along_rim} {along_width}");
        }
    }
}
