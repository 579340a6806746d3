//! What a map should be before numbers are computed from it: the limits, each with its reason, and the warnings.

use std::fmt;

use slipgrid_statistics::upper_median;

use crate::{HeightMap, Spikes};

/// The limits of plausibility of maps, all of them.
pub mod limits {
    /// A spike differs from the median about it by more than this many standard deviations of all such differences
    /// (1.4826 times their median absolute value), and stands as far beyond every point around it. Of 33 million normal
    /// differences the largest is 5.6; heights of machined surfaces have heavier tails.
    pub const SPIKE_DEVIATIONS: f64 = 8.0;
    /// Points from the middle of the square about a point to its sides: 5 x 5 points, so that clusters of up to twelve
    /// bad points lose the vote of the median.
    pub const SPIKE_REACH: usize = 2;
    /// Most points of one spike: the largest minority of 5 x 5. What is larger is a feature of the surface, or debris.
    pub const MOST_SPIKE_POINTS: usize = 12;
    /// Fewest points present about a point, without itself, for a judgement on it: those about a corner of the map.
    pub const LEAST_SPIKE_NEIGHBOURS: usize = 8;
    /// Debris stands above the median height by more than this many standard deviations (1.4826 times the median
    /// absolute deviation): heights of a worn or machined surface go to 4 or 5, of a normal one of 33 million points to 5.6.
    pub const RAISED_DEVIATIONS: f64 = 12.0;
    /// Largest share of the map that is debris: more is what was measured (the land between wide cavities).
    pub const MOST_RAISED_SHARE: f64 = 0.05;
    /// Share of missing points from which the filled ones matter: they are smooth, and lower the slope by up to half
    /// their share. Instruments advise to measure again from 5 to 10 %.
    pub const WARNED_MISSING_SHARE: f64 = 0.1;
    /// Share of missing points above which the surface is an invention.
    pub const MOST_MISSING_SHARE: f64 = 0.9;
    /// Rms slopes of surfaces that slide: polished metal has 1e-3 to 1e-2, ground or lasered 0.1 to 0.5. Below the first
    /// a wafer, or heights in too large a unit; above the second elastic contact of gentle slopes no longer holds.
    pub const WARNED_SLOPE: [f64; 2] = [1e-4, 1.0];
    /// Slopes at which the area law means nothing: full contact at once, or walls of 84 degrees on average.
    pub const POSSIBLE_SLOPE: [f64; 2] = [1e-7, 10.0];
    /// Sq of surfaces that slide, in metres: from the size of an atom to what the eye sees as a relief.
    pub const WARNED_SQ_M: [f64; 2] = [1e-10, 1e-4];
}

/// Something about a map that makes the numbers computed from it doubtful. Its text begins with its name.
#[derive(Clone, Debug, PartialEq)]
pub enum MapWarning {
    /// Single points far from all about them.
    Spikes {
        /// Where they are.
        spikes: Spikes,
        /// Points of the map.
        points: usize,
        /// Finite-difference rms slope of the map as it is.
        rms_slope: f64,
        /// The same without them.
        rms_slope_without: f64,
    },
    /// Patches far above the rest, wider than spikes: dust, debris, a step of the instrument.
    Raised {
        /// Points that stand so high.
        points: usize,
        /// The largest height above the median, in metres.
        highest_m: f64,
        /// Standard deviation by the median absolute deviation, in metres.
        deviation_m: f64,
    },
    /// Many points are missing.
    Missing {
        /// Points missing.
        missing: usize,
        /// Points of the map.
        points: usize,
    },
    /// An rms slope that no surface that slides has.
    Slope {
        /// The rms slope.
        rms_slope: f64,
    },
    /// Heights that look as if they were in another unit.
    Heights {
        /// Root mean square height, in metres.
        sq_m: f64,
    },
}

impl MapWarning {
    /// One word for what it is.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Spikes { .. } => "spikes",
            Self::Raised { .. } => "debris",
            Self::Missing { .. } => "missing points",
            Self::Slope { .. } => "slope",
            Self::Heights { .. } => "unit of heights",
        }
    }
}

impl fmt::Display for MapWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: ", self.name())?;
        match self {
            Self::Spikes { spikes, points, rms_slope, rms_slope_without } => write!(
                f,
                "{spikes} (of {points} points); the rms slope between neighbours is {rms_slope:.2e} with and \
                 {rms_slope_without:.2e} without them"
            ),
            Self::Raised { points, highest_m, deviation_m } => write!(
                f,
                "{points} points stand up to {:.3e} um above the median height, {:.0} robust standard deviations: dust or a \
                 fault of the measurement carries the load in their place",
                highest_m * 1e6,
                highest_m / deviation_m
            ),
            Self::Missing { missing, points } => write!(
                f,
                "{:.0} % of the map ({missing} of {points} points) was not measured; what fills it is smooth, so that slopes \
                 come out too small: crop the map to what was measured",
                100.0 * *missing as f64 / *points as f64
            ),
            Self::Slope { rms_slope } => write!(
                f,
                "the rms slope is {rms_slope:.2e}; surfaces that slide have {:e} to {:e}: see the units of heights and \
                 pixels, and the map for faults",
                limits::WARNED_SLOPE[0],
                limits::WARNED_SLOPE[1]
            ),
            Self::Heights { sq_m } => write!(
                f,
                "Sq is {:.3e} um; surfaces that slide have {:e} to {:e} um: the heights may be in another unit than taken",
                sq_m * 1e6,
                limits::WARNED_SQ_M[0] * 1e6,
                limits::WARNED_SQ_M[1] * 1e6
            ),
        }
    }
}

impl HeightMap {
    /// The warning on single points far from all about them, if there are any: on the map as measured, before
    /// missing points are filled.
    #[must_use]
    pub fn spike_warning(&self) -> Option<MapWarning> {
        if !self.has_spikes() {
            return None;
        }
        let mut without = self.clone();
        let spikes = without.despike();
        Some(MapWarning::Spikes {
            spikes,
            points: self.heights_m().len() - self.missing(),
            rms_slope: self.rms_slope_finite_difference(),
            rms_slope_without: without.rms_slope_finite_difference(),
        })
    }

    /// The warning on missing points, if they are many.
    #[must_use]
    pub fn missing_warning(&self) -> Option<MapWarning> {
        let (missing, points) = (self.missing(), self.heights_m().len());
        (missing as f64 > limits::WARNED_MISSING_SHARE * points as f64)
            .then_some(MapWarning::Missing { missing, points })
    }

    /// Warnings on heights and slope of a map whose form is removed, `rms_slope` its rms slope.
    #[must_use]
    pub fn height_warnings(&self, rms_slope: f64) -> Vec<MapWarning> {
        let outside = |value: f64, [least, most]: [f64; 2]| !(least..=most).contains(&value);
        let sq_m = self.sq_m();
        let unit = outside(sq_m, limits::WARNED_SQ_M).then_some(MapWarning::Heights { sq_m });
        let slope = outside(rms_slope, limits::WARNED_SLOPE).then_some(MapWarning::Slope { rms_slope });
        self.raised().into_iter().chain(unit).chain(slope).collect()
    }

    /// Patches that stand far above the rest, where they are few.
    fn raised(&self) -> Option<MapWarning> {
        let mut sample: Vec<f64> = self.sampled().map(|node| self.heights_m()[node]).filter(|h| !h.is_nan()).collect();
        let median_m = upper_median(&mut sample)?;
        sample.iter_mut().for_each(|height| *height = (*height - median_m).abs());
        let deviation_m = ROBUST_DEVIATION * upper_median(&mut sample)?;
        let least_m = limits::RAISED_DEVIATIONS * deviation_m;
        if deviation_m <= 0.0 {
            return None;
        }
        let above = self.heights_m().iter().map(|height| height - median_m).filter(|&above_m| above_m > least_m);
        let (points, highest_m) = above.fold((0, 0.0_f64), |(n, most), above_m| (n + 1, most.max(above_m)));
        let present = self.heights_m().len() - self.missing();
        let few = points > 0 && points as f64 <= limits::MOST_RAISED_SHARE * present as f64;
        few.then_some(MapWarning::Raised { points, highest_m, deviation_m })
    }
}

/// Points from which medians are taken; larger maps give one in several.
const MOST_SAMPLED: usize = 1 << 18;

impl HeightMap {
    /// Nodes from which medians over the map are taken, evenly over it.
    pub(crate) fn sampled(&self) -> impl Iterator<Item = usize> {
        let points = self.heights_m().len();
        let stride = (1..).find(|stride| points / (stride * stride) <= MOST_SAMPLED).unwrap_or(1);
        // Another column in each row, so that no pattern along the rows falls in with the sample.
        (0..self.rows())
            .step_by(stride)
            .flat_map(move |i| (i / stride * 7 % stride..self.cols()).step_by(stride).map(move |j| i * self.cols() + j))
    }
}

/// Standard deviation of a normal distribution over the median of its absolute values.
pub(crate) const ROBUST_DEVIATION: f64 = 1.4826;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SelfAffine;

    /// A synthetic surface on 128 x 128 pixels of 2 um.
    fn rough(hurst: f64) -> HeightMap {
        let size = SelfAffine { pixels: 128, side_m: 256e-6, min_wave: 2, max_wave: 40, ..SelfAffine::STAND_IN };
        SelfAffine { hurst, ..size }.map().unwrap()
    }

    fn changed(map: &HeightMap, change: impl Fn(usize, f64) -> f64) -> HeightMap {
        let heights = map.heights_m().iter().enumerate().map(|(n, &height)| change(n, height)).collect();
        HeightMap::new(map.rows(), map.cols(), map.dx_m(), map.dy_m(), heights).unwrap()
    }

    #[test]
    fn a_plausible_surface_gives_no_warning() {
        for hurst in [0.2, 0.5, 0.8, 1.0] {
            let map = rough(hurst);
            assert_eq!(map.spike_warning(), None, "{hurst}");
            assert_eq!(map.missing_warning(), None);
            assert_eq!(map.height_warnings(map.rms_slope_spectral().unwrap()), [], "{hurst}");
        }
    }

    #[test]
    fn dust_is_debris_and_land_between_cavities_is_not() {
        let map = rough(0.8);
        let square = |n: usize, side: usize| n / 128 % 64 < side && n % 128 % 64 < side;
        let dusty = changed(&map, |n, h| if n / 128 < 8 && n % 128 < 8 { h + 40.0 * map.sq_m() } else { h });
        let warnings = dusty.height_warnings(0.01);
        assert!(matches!(warnings[..], [MapWarning::Raised { points: 64, .. }]), "{warnings:?}");
        assert!(warnings[0].to_string().starts_with("debris: 64 points stand"), "{}", warnings[0]);
        for side in [20, 60] {
            let cut = changed(&map, |n, h| if square(n, side) { h - 40.0 * map.sq_m() } else { h });
            assert_eq!(cut.height_warnings(0.01), [], "{side}");
            assert_eq!(cut.spike_warning(), None, "{side}");
        }
    }

    #[test]
    fn missing_points_slopes_and_units_have_limits() {
        let map = rough(0.8);
        let holed = |share: f64| changed(&map, |n, h| if (n as f64) < share * 16384.0 { f64::NAN } else { h });
        assert_eq!(holed(0.09).missing_warning(), None);
        assert!(holed(0.2).missing_warning().unwrap().to_string().starts_with("missing points: 20 % of the map"));
        for (slope, warned) in [(2e-4, false), (0.9, false), (1.1, true), (5e-5, true), (f64::NAN, true)] {
            assert_eq!(map.height_warnings(slope).len(), usize::from(warned), "{slope}");
        }
        for (factor, warned) in [(1.0, false), (1e3, true), (1e-4, true)] {
            let map = map.scaled(factor).unwrap();
            let names: Vec<_> = map.height_warnings(0.01).iter().map(MapWarning::name).collect();
            assert_eq!(names == ["unit of heights"], warned, "{factor}: {names:?}");
        }
    }
}
