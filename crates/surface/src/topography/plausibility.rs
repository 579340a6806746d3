//! Plausibility of maps before anything is computed from them: the limits, each with its reason, and the warnings.

use std::fmt;

use slipgrid_base::monitor::{Cancelled, Monitor};
use slipgrid_base::statistics::upper_median;

use crate::topography::despike::ROBUST_DEVIATION;
use crate::topography::error::significant;
use crate::topography::{Form, HeightMap, Spikes};

pub mod limits;

/// A property of a map that makes numbers computed from it doubtful. The text begins with the warning's name.
#[derive(Clone, Debug, PartialEq)]
pub enum MapWarning {
    /// Spikes: single points far from all surrounding points.
    Spikes {
        /// The spikes.
        spikes: Spikes,
        /// Points of the map.
        points: usize,
        /// Finite-difference rms slope of the levelled map with the spikes.
        rms_slope: f64,
        /// Finite-difference rms slope without the spikes.
        rms_slope_without: f64,
        /// Height of the highest point above the median, in metres.
        highest_m: f64,
        /// Height of the highest point above the median without the spikes, in metres.
        highest_without_m: f64,
    },
    /// Patches far above the rest and wider than spikes: dust, debris, or a step of the instrument.
    Raised {
        /// Number of points that high.
        points: usize,
        /// Largest height above the median, in metres.
        highest_m: f64,
        /// Standard deviation estimated from the median absolute deviation, in metres.
        deviation_m: f64,
    },
    /// A part of the map far below the rest: a hole, a cavity, or the edge of the specimen.
    Lowered {
        /// Fraction of the points present that lie that low.
        share: f64,
        /// Distance of their mean below the median, in metres.
        depth_m: f64,
        /// First and last row, and first and last column, of these points.
        extent: [[usize; 2]; 2],
    },
    /// Most of the heights are explained by a second-order form: a curved specimen, measured as roughness.
    Curved {
        /// Sa of the map minus its plane, in metres.
        sa_m: f64,
        /// Sa of the map minus its second-order form, in metres.
        sa_without_m: f64,
    },
    /// Many points are missing.
    Missing {
        /// Number of missing points.
        missing: usize,
        /// Points of the map.
        points: usize,
    },
    /// Blocks of points that are exactly zero, which some instruments write for points not measured.
    Zeros {
        /// Number of such points.
        zeros: usize,
        /// Points of the map.
        points: usize,
    },
    /// Pixel sides that are implausible, or in two different units.
    Pixels {
        /// Sides along x and y, in metres.
        pixel_m: [f64; 2],
    },
    /// An rms slope outside the range of sliding surfaces.
    Slope {
        /// The rms slope.
        rms_slope: f64,
    },
    /// Heights that are probably in another unit.
    Heights {
        /// Root mean square height, in metres.
        sq_m: f64,
    },
}

impl MapWarning {
    /// Name of the warning, one word.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Spikes { .. } => "spikes",
            Self::Raised { .. } => "debris",
            Self::Lowered { .. } => "hole",
            Self::Curved { .. } => "curved",
            Self::Missing { .. } => "missing points",
            Self::Zeros { .. } => "zeros",
            Self::Pixels { .. } => "pixels",
            Self::Slope { .. } => "slope",
            Self::Heights { .. } => "unit of heights",
        }
    }
}

impl fmt::Display for MapWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: ", self.name())?;
        match self {
            Self::Spikes { spikes, points, rms_slope, rms_slope_without, highest_m, highest_without_m } => write!(
                f,
                "{spikes} (of {points} points); the rms slope between neighbours is {rms_slope:.2e} with and \
                 {rms_slope_without:.2e} without them, the highest point {:.3} and {:.3} um above the median",
                highest_m * 1e6,
                highest_without_m * 1e6
            ),
            Self::Raised { points, highest_m, deviation_m } => write!(
                f,
                "{points} points stand up to {:.3e} um above the median height, {:.0} robust standard deviations: dust or a \
                 fault of the measurement carries the load in their place",
                highest_m * 1e6,
                highest_m / deviation_m
            ),
            // Files list rows along x, this module columns: the indices are exchanged to match the file.
            Self::Lowered { share, depth_m, extent: [[col, last_col], [row, last_row]] } => write!(
                f,
                "{:.1} % of the map lies {:.3} um below the rest on average (within rows {row} to {last_row}, columns {col} to \
                 {last_col}), as a hole, a cavity or the edge of a specimen does: crop the map to the surface itself",
                100.0 * share,
                depth_m * 1e6
            ),
            Self::Curved { sa_m, sa_without_m } => write!(
                f,
                "Sa is {:.3} um, and {:.3} um without the least-squares surface of second order: the form of a curved specimen, which \
                 counts as roughness (in a small map a long wave looks the same)",
                sa_m * 1e6,
                sa_without_m * 1e6
            ),
            Self::Missing { missing, points } => write!(
                f,
                "{:.0} % of the map ({missing} of {points} points) was not measured; what fills it is smooth, so that slopes \
                 come out too small: crop the map to what was measured",
                100.0 * *missing as f64 / *points as f64
            ),
            Self::Zeros { zeros, points } => write!(
                f,
                "{zeros} of {points} points are exactly 0 in blocks, as some instruments write points that they did not measure: \
                 if they are, export them as NaN or BAD"
            ),
            Self::Pixels { pixel_m: [x_m, y_m] } => write!(
                f,
                "pixels of {} x {} um are implausible: a side of the map may be missing in the file, or in another unit",
                significant(x_m * 1e6, 5),
                significant(y_m * 1e6, 5)
            ),
            Self::Slope { rms_slope } => write!(
                f,
                "the rms slope is {rms_slope:.2e}; surfaces that slide have {:e} to {:e}: see the units of heights and \
                 pixels, and the map for faults{}",
                limits::WARNED_SLOPE[0],
                limits::WARNED_SLOPE[1],
                other_unit(*rms_slope)
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

/// Unit that heights or pixels were probably in, judged by the usual slope of surfaces.
fn other_unit(rms_slope: f64) -> String {
    const USUAL: [f64; 2] = [3e-3, 0.6];
    let factors = [(1e3, "1000 times"), (1e6, "a million times"), (1e-3, "a thousandth"), (1e-6, "a millionth")];
    let fits = |(factor, _): &(f64, &str)| (USUAL[0]..=USUAL[1]).contains(&(factor * rms_slope));
    factors.into_iter().find(fits).map_or_else(String::new, |(factor, words)| {
        format!(
            " (with heights {words} as large, in another unit than was taken, it would be {:.2e})",
            factor * rms_slope
        )
    })
}

impl MapWarning {
    /// Whether the warning affects results: spikes do only if they change the slope or the highest point enough, all
    /// other warnings always.
    #[must_use]
    pub fn matters(&self) -> bool {
        let Self::Spikes { rms_slope, rms_slope_without, highest_m, highest_without_m, .. } = self else { return true };
        (rms_slope / rms_slope_without - 1.0).abs() > limits::SPIKE_SLOPE
            || *highest_m > (1.0 + limits::SPIKE_PEAK) * highest_without_m
    }
}

impl HeightMap {
    /// Warning on spikes, if there are any. The map must be as measured, before missing points are filled.
    ///
    /// # Errors
    /// [`Cancelled`] once `monitor` cancels.
    pub fn spike_warning(&self, monitor: &dyn Monitor) -> Result<Option<MapWarning>, Cancelled> {
        if !self.has_spikes(monitor)? {
            return Ok(None);
        }
        let mut without = self.clone();
        let spikes = without.despike(monitor)?;
        let slope_and_highest_m = |mut map: Self| {
            // Points that do not determine a plane are not levelled.
            let _ = map.subtract_plane(monitor);
            monitor.heed()?;
            let highest_m = map.heights_m().iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let above_m = highest_m - map.median_m();
            monitor.heed()?;
            Ok([map.rms_slope_finite_difference(), above_m])
        };
        let [rms_slope, highest_m] = slope_and_highest_m(self.clone())?;
        let [rms_slope_without, highest_without_m] = slope_and_highest_m(without)?;
        Ok(Some(MapWarning::Spikes {
            spikes,
            points: self.heights_m().len() - self.missing(),
            rms_slope,
            rms_slope_without,
            highest_m,
            highest_without_m,
        }))
    }

    /// Warning on a second-order form, if it explains most of the heights left by the least-squares plane.
    ///
    /// # Errors
    /// [`Cancelled`] once `monitor` cancels.
    pub fn form_warning(&self, monitor: &dyn Monitor) -> Result<Option<MapWarning>, Cancelled> {
        let sa_m_without = |form: Form| {
            let mut map = self.clone();
            // If the points do not determine a form, there is no warning.
            let is_removed = map.remove_form(form, monitor).is_ok();
            monitor.heed()?;
            Ok(is_removed.then(|| map.sa_m()))
        };
        let Some(sa_without_m) = sa_m_without(Form::SecondOrder)? else { return Ok(None) };
        let Some(sa_m) = sa_m_without(Form::Plane)? else { return Ok(None) };
        let is_curved = sa_without_m < (1.0 - limits::FORM_SHARE) * sa_m && sa_m >= limits::WARNED_SQ_M[0];
        Ok(is_curved.then_some(MapWarning::Curved { sa_m, sa_without_m }))
    }

    /// Median of the heights present, in metres.
    fn median_m(&self) -> f64 {
        let mut sample = self.sampled_heights_m();
        upper_median(&mut sample).unwrap_or(f64::NAN)
    }

    /// Warning on a part of sufficient size that lies far below the rest of a map whose form is removed.
    #[must_use]
    pub fn hole_warning(&self) -> Option<MapWarning> {
        let (median_m, deviation_m) = self.robust()?;
        let most_m = median_m - limits::LOWERED_DEVIATIONS * deviation_m;
        let (mut points, mut sum_m, mut extent) = (0_usize, 0.0, [[usize::MAX, 0]; 2]);
        for (n, &height_m) in self.heights_m().iter().enumerate().filter(|(_, height_m)| **height_m < most_m) {
            points += 1;
            sum_m += median_m - height_m;
            for (extent, at) in extent.iter_mut().zip([n / self.cols(), n % self.cols()]) {
                *extent = [extent[0].min(at), extent[1].max(at)];
            }
        }
        let share = points as f64 / (self.heights_m().len() - self.missing()) as f64;
        let [least, most] = limits::LOWERED_SHARE;
        (points > 0 && (least..=most).contains(&share)).then(|| {
            let depth_m = sum_m / points as f64;
            MapWarning::Lowered { share, depth_m, extent }
        })
    }

    /// Median height, and standard deviation estimated from the median absolute deviation, in metres; `None` if half of
    /// all heights are equal.
    fn robust(&self) -> Option<(f64, f64)> {
        let mut sample = self.sampled_heights_m();
        let median_m = upper_median(&mut sample)?;
        sample.iter_mut().for_each(|height| *height = (*height - median_m).abs());
        let deviation_m = ROBUST_DEVIATION * upper_median(&mut sample)?;
        (deviation_m > 0.0).then_some((median_m, deviation_m))
    }

    /// Warning on missing points, if there are many.
    #[must_use]
    pub fn missing_warning(&self) -> Option<MapWarning> {
        let (missing, points) = (self.missing(), self.heights_m().len());
        (missing as f64 > limits::WARNED_MISSING_SHARE * points as f64)
            .then_some(MapWarning::Missing { missing, points })
    }

    /// Warnings on heights and slope of a map whose form is removed; `rms_slope` is its rms slope.
    #[must_use]
    pub fn height_warnings(&self, rms_slope: f64) -> Vec<MapWarning> {
        let outside = |value: f64, [least, most]: [f64; 2]| !(least..=most).contains(&value);
        let sq_m = self.sq_m();
        let unit = outside(sq_m, limits::WARNED_SQ_M).then_some(MapWarning::Heights { sq_m });
        let slope = outside(rms_slope, limits::WARNED_SLOPE).then_some(MapWarning::Slope { rms_slope });
        self.raised().into_iter().chain(unit).chain(slope).collect()
    }

    /// Warning on patches that stand far above the rest, if they are few.
    fn raised(&self) -> Option<MapWarning> {
        let (median_m, deviation_m) = self.robust()?;
        let least_m = limits::RAISED_DEVIATIONS * deviation_m;
        let above = self.heights_m().iter().map(|height| height - median_m).filter(|&above_m| above_m > least_m);
        let (points, highest_m) = above.fold((0, 0.0_f64), |(n, most), above_m| (n + 1, most.max(above_m)));
        let present = self.heights_m().len() - self.missing();
        let few = points > 0 && points as f64 <= limits::MAX_RAISED_SHARE * present as f64;
        few.then_some(MapWarning::Raised { points, highest_m, deviation_m })
    }
}

/// Number of points from which medians are taken; larger maps are sampled.
const MAX_SAMPLED: usize = 1 << 18;

impl HeightMap {
    /// Heights from which medians over the map are taken.
    fn sampled_heights_m(&self) -> Vec<f64> {
        self.sampled(MAX_SAMPLED).map(|node| self.heights_m()[node]).filter(|height| !height.is_nan()).collect()
    }

    /// Nodes from which medians over the map are taken: `most` of them, evenly over the map.
    pub(crate) fn sampled(&self, most: usize) -> impl Iterator<Item = usize> {
        let points = self.heights_m().len();
        let stride = (1..).find(|stride| points / (stride * stride) <= most).unwrap_or(1);
        // Each row is sampled at other columns, so that patterns along the rows do not coincide with the sample.
        (0..self.rows())
            .step_by(stride)
            .flat_map(move |i| (i / stride * 7 % stride..self.cols()).step_by(stride).map(move |j| i * self.cols() + j))
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::topography::SelfAffine;
    use slipgrid_base::monitor::Unwatched;

    /// A synthetic surface on 128 x 128 pixels of 2 um.
    pub(crate) fn rough(hurst: f64) -> HeightMap {
        let size = SelfAffine { pixels: 128, side_m: 256e-6, min_wave: 2, max_wave: 40, ..SelfAffine::STAND_IN };
        SelfAffine { hurst, ..size }.map().unwrap()
    }

    pub(crate) fn changed(map: &HeightMap, change: impl Fn(usize, f64) -> f64) -> HeightMap {
        let heights = map.heights_m().iter().enumerate().map(|(n, &height)| change(n, height)).collect();
        HeightMap::new(map.rows(), map.cols(), map.dx_m(), map.dy_m(), heights).unwrap()
    }

    #[test]
    fn a_plausible_surface_gives_no_warning() {
        for hurst in [0.2, 0.5, 0.8, 1.0] {
            let map = rough(hurst);
            assert_eq!(map.spike_warning(&Unwatched).unwrap(), None, "{hurst}");
            assert_eq!(map.missing_warning(), None);
            assert_eq!(map.height_warnings(map.rms_slope_spectral(&Unwatched).unwrap()), [], "{hurst}");
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
            assert_eq!(cut.spike_warning(&Unwatched).unwrap(), None, "{side}");
        }
    }

    #[test]
    fn a_part_far_below_the_rest_is_a_hole() {
        let map = rough(0.8);
        let inside = |n: usize| (40..60).contains(&(n / 128)) && (10..50).contains(&(n % 128));
        let holed = changed(&map, |n, h| if inside(n) { h - 40.0 * map.sq_m() } else { h });
        let warning = holed.hole_warning().unwrap();
        let MapWarning::Lowered { share, extent, .. } = warning else { panic!("{warning}") };
        assert!((share - 800.0 / 16384.0).abs() < 1e-12 && extent == [[40, 59], [10, 49]]);
        assert!(warning.to_string().starts_with("hole: 4.9 % of the map lies"), "{warning}");
        assert_eq!(map.hole_warning(), None);
        // A few pits are part of the surface.
        let pitted = changed(&map, |n, h| if n % 400 == 0 { h - 40.0 * map.sq_m() } else { h });
        assert_eq!(pitted.hole_warning(), None);
    }

    #[test]
    fn spikes_matter_where_they_change_the_slope_or_the_highest_point() {
        let map = rough(0.8);
        let tilted = changed(&map, |n, h| h + 20.0 * map.sq_m() * (n / 128) as f64);
        let spiked = |by: f64| {
            changed(&tilted, |n, h| if n == 3000 { h + by * map.sq_m() } else { h })
                .spike_warning(&Unwatched)
                .unwrap()
                .unwrap()
        };
        for by in [30.0, -300.0] {
            assert!(spiked(by).matters(), "{}", spiked(by));
        }
        let warning = |rms_slope, highest_m| MapWarning::Spikes {
            spikes: Spikes::default(),
            points: 16384,
            rms_slope,
            rms_slope_without: 0.1,
            highest_m,
            highest_without_m: 1e-6,
        };
        for (rms_slope, highest_m, matters) in [(0.102, 1.05e-6, false), (0.104, 1e-6, true), (0.1, 1.2e-6, true)] {
            assert_eq!(warning(rms_slope, highest_m).matters(), matters, "{rms_slope} {highest_m}");
        }
    }

    #[test]
    fn slopes_of_another_unit_are_named() {
        let said = |rms_slope| MapWarning::Slope { rms_slope }.to_string();
        assert!(said(1.3e-5).contains("with heights 1000 times as large"), "{}", said(1.3e-5));
        assert!(said(51.0).contains("heights a thousandth as large"), "{}", said(51.0));
        assert!(!said(1.2).contains("as large"));
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
