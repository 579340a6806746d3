//! Plausibility of maps before anything is computed from them: the limits, each with its reason, and the warnings.

use std::fmt;

use slipgrid_base::monitor::{Cancelled, Monitor};
use slipgrid_base::statistics::upper_median;
use slipgrid_base::units::significant;

use crate::topography::despike::ROBUST_DEVIATION;
use crate::topography::{Form, HeightMap, Spikes};

pub mod limits;

/// A property of a map that makes numbers computed from it doubtful.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapDoubt {
    /// Single points far from all surrounding points.
    Spikes,
    /// Small patches far above the rest.
    Debris,
    /// A part far below the rest.
    Hole,
    /// The form of a curved specimen.
    Curved,
    /// Many points were not measured.
    MissingPoints,
    /// Blocks of exact zeros, as some instruments write for points that they did not measure.
    Zeros,
    /// Implausible sides of pixels.
    Pixels,
    /// An rms slope that no sliding surface has.
    Slope,
    /// Heights that are probably in another unit than assumed.
    UnitOfHeights,
}

impl MapDoubt {
    /// Name of the warning.
    pub const fn name(self) -> &'static str {
        NAMES[self as usize]
    }
}

/// Names of the warnings, in the order of [`MapDoubt`].
const NAMES: [&str; 9] =
    ["spikes", "debris", "hole", "curved", "missing points", "zeros", "pixels", "slope", "unit of heights"];

/// A warning about a map. It is displayed with its name in front of the text.
#[derive(Clone, Debug, PartialEq)]
pub struct MapWarning {
    /// Property of the map that is doubtful.
    pub doubt: MapDoubt,
    /// Amount of the doubtful property, and its meaning for numbers computed from the map.
    pub text: String,
}

impl fmt::Display for MapWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.doubt.name(), self.text)
    }
}

/// Spikes of a map, with the warning about them.
pub(crate) struct FoundSpikes {
    pub(crate) spikes: Spikes,
    pub(crate) warning: MapWarning,
    /// Whether the spikes change the slope or the highest point enough to matter.
    pub(crate) matter: bool,
}

/// Whether spikes change a map enough to matter; `with` and `without` hold the rms slope and the height of the highest
/// point above the median, in metres, with and without the spikes.
fn matter(with: [f64; 2], without: [f64; 2]) -> bool {
    (with[0] / without[0] - 1.0).abs() > limits::SPIKE_SLOPE || with[1] > (1.0 + limits::SPIKE_PEAK) * without[1]
}

/// Text of a warning about the slope `rms_slope`.
fn slope_text(rms_slope: f64) -> String {
    format!(
        "the rms slope is {}; surfaces that slide have {} to {}: see the units of heights and \
         pixels, and the map for faults{}",
        significant(rms_slope, 3),
        limits::WARNED_SLOPE[0],
        limits::WARNED_SLOPE[1],
        other_unit(rms_slope)
    )
}

/// Text on the power of a thousand by which heights must be multiplied to give a slope that is usual for surfaces;
/// empty if there is no such power.
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

impl HeightMap {
    /// Warning on spikes, if there are any. The map must be as measured, before missing points are filled.
    ///
    /// # Errors
    /// [`Cancelled`] once `monitor` cancels.
    pub(crate) fn spike_warning(&self, monitor: &dyn Monitor) -> Result<Option<FoundSpikes>, Cancelled> {
        if !self.has_spikes(monitor)? {
            return Ok(None);
        }
        let mut without = self.clone();
        let spikes = without.despike(monitor)?;
        let slope_and_highest_m = |mut map: Self| {
            // Points that do not determine a plane are not levelled.
            let _ = map.remove_form(Form::Plane, monitor);
            monitor.heed()?;
            let highest_m = map.heights_m().iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let above_m = highest_m - upper_median(&mut map.sampled_heights_m()).unwrap_or(f64::NAN);
            monitor.heed()?;
            Ok([map.rms_slope_finite_difference(), above_m])
        };
        let (with, without) = (slope_and_highest_m(self.clone())?, slope_and_highest_m(without)?);
        let text = format!(
            "{spikes} (of {} points); the rms slope between neighbours is {:.2e} with and \
             {:.2e} without them, the highest point {:.3} and {:.3} um above the median",
            self.heights_m().len() - self.missing(),
            with[0],
            without[0],
            with[1] * 1e6,
            without[1] * 1e6
        );
        let warning = MapWarning { doubt: MapDoubt::Spikes, text };
        Ok(Some(FoundSpikes { spikes, warning, matter: matter(with, without) }))
    }

    /// Warning on a second-order form; `None` if the form explains at most [`limits::FORM_SHARE`] of the Sa left by the
    /// least-squares plane, or is not determined by the points.
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
        let text = || {
            format!(
                "Sa is {:.3} um, and {:.3} um without the least-squares surface of second order: the form of a curved specimen, which \
             counts as roughness (in a small map a long wave looks the same)",
                sa_m * 1e6,
                sa_without_m * 1e6
            )
        };
        Ok(is_curved.then(|| MapWarning { doubt: MapDoubt::Curved, text: text() }))
    }

    /// Warning on a part that lies far below the rest of a map whose form is removed; `None` unless the part's fraction
    /// of the map lies in [`limits::LOWERED_SHARE`].
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
        let [[col, last_col], [row, last_row]] = extent;
        (points > 0 && (least..=most).contains(&share)).then(|| MapWarning {
            doubt: MapDoubt::Hole,
            text: format!(
                "{:.1} % of the map lies {:.3} um below the rest on average (within rows {row} to {last_row}, columns {col} to \
                 {last_col}), as a hole, a cavity or the edge of a specimen does: crop the map to the surface itself",
                100.0 * share,
                sum_m / points as f64 * 1e6
            ),
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

    /// Warning on missing points; `None` if they are at most the fraction [`limits::WARNED_MISSING_SHARE`] of the map.
    pub fn missing_warning(&self) -> Option<MapWarning> {
        let (missing, points) = (self.missing(), self.heights_m().len());
        (missing as f64 > limits::WARNED_MISSING_SHARE * points as f64).then(|| MapWarning {
            doubt: MapDoubt::MissingPoints,
            text: format!(
                "{:.0} % of the map ({missing} of {points} points) was not measured; what fills it is smooth, so that slopes \
                 come out too small: crop the map to what was measured",
                100.0 * missing as f64 / points as f64
            ),
        })
    }

    /// Warnings on debris, Sq and rms slope of a map whose form is removed; `rms_slope` is its rms slope. Raised points
    /// count as debris only if they are more than `spike_points`, the number of points in spikes.
    pub(crate) fn height_warnings(&self, rms_slope: f64, spike_points: usize) -> Vec<MapWarning> {
        let outside = |value: f64, [least, most]: [f64; 2]| !(least..=most).contains(&value);
        let sq_m = self.sq_m();
        let unit = outside(sq_m, limits::WARNED_SQ_M).then(|| MapWarning {
            doubt: MapDoubt::UnitOfHeights,
            text: format!(
                "Sq is {:.3e} um; surfaces that slide have {:e} to {:e} um: the heights may be in another unit than taken",
                sq_m * 1e6,
                limits::WARNED_SQ_M[0] * 1e6,
                limits::WARNED_SQ_M[1] * 1e6
            ),
        });
        let slope = outside(rms_slope, limits::WARNED_SLOPE)
            .then(|| MapWarning { doubt: MapDoubt::Slope, text: slope_text(rms_slope) });
        self.raised(spike_points).into_iter().chain(unit).chain(slope).collect()
    }

    /// Warning on points that stand far above the median height; `None` if they are at most `spike_points`, or more
    /// than the fraction [`limits::MAX_RAISED_SHARE`] of the map.
    fn raised(&self, spike_points: usize) -> Option<MapWarning> {
        let (median_m, deviation_m) = self.robust()?;
        let least_m = limits::RAISED_DEVIATIONS * deviation_m;
        let above = self.heights_m().iter().map(|height| height - median_m).filter(|&above_m| above_m > least_m);
        let (points, highest_m) = above.fold((0, 0.0_f64), |(n, most), above_m| (n + 1, most.max(above_m)));
        let present = self.heights_m().len() - self.missing();
        let few = points > spike_points && points as f64 <= limits::MAX_RAISED_SHARE * present as f64;
        few.then(|| MapWarning {
            doubt: MapDoubt::Debris,
            text: format!(
                "{points} points stand up to {:.3e} um above the median height, {:.0} robust standard deviations: dust or a \
                 fault of the measurement carries the load in their place",
                highest_m * 1e6,
                highest_m / deviation_m
            ),
        })
    }
}

/// Largest number of points from which medians are taken; larger maps are sampled.
const MAX_SAMPLED: usize = 1 << 18;

impl HeightMap {
    /// Heights, in metres, from which medians over the map are taken.
    fn sampled_heights_m(&self) -> Vec<f64> {
        self.sampled(MAX_SAMPLED).map(|node| self.heights_m()[node]).filter(|height| !height.is_nan()).collect()
    }

    /// Nodes from which medians over the map are taken: at most about `most` of them, evenly over the map.
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

    #[test]
    fn a_plausible_surface_gives_no_warning() {
        for hurst in [0.2, 0.5, 0.8, 1.0] {
            let map = rough(hurst);
            assert!(map.spike_warning(&Unwatched).unwrap().is_none(), "{hurst}");
            assert_eq!(map.missing_warning(), None);
            assert_eq!(map.height_warnings(map.rms_slope_spectral(&Unwatched).unwrap(), 0), [], "{hurst}");
        }
    }

    #[test]
    fn dust_is_debris_and_land_between_cavities_is_not() {
        let map = rough(0.8);
        let square = |n: usize, side: usize| n / 128 % 64 < side && n % 128 % 64 < side;
        let dusty = map.changed(|n, h| if n / 128 < 8 && n % 128 < 8 { h + 40.0 * map.sq_m() } else { h });
        let warnings = dusty.height_warnings(0.01, 63);
        assert_eq!(warnings.len(), 1, "{warnings:?}");
        assert_eq!(dusty.height_warnings(0.01, 64), []);
        assert!(warnings[0].to_string().starts_with("debris: 64 points stand"), "{}", warnings[0]);
        for side in [20, 60] {
            let cut = map.changed(|n, h| if square(n, side) { h - 40.0 * map.sq_m() } else { h });
            assert_eq!(cut.height_warnings(0.01, 0), [], "{side}");
            assert!(cut.spike_warning(&Unwatched).unwrap().is_none(), "{side}");
        }
    }

    #[test]
    fn a_part_far_below_the_rest_is_a_hole() {
        let map = rough(0.8);
        let inside = |n: usize| (40..60).contains(&(n / 128)) && (10..50).contains(&(n % 128));
        let holed = map.changed(|n, h| if inside(n) { h - 40.0 * map.sq_m() } else { h });
        let warning = holed.hole_warning().unwrap();
        assert!(warning.text.contains("(within rows 10 to 49, columns 40 to 59)"), "{warning}");
        assert!(warning.to_string().starts_with("hole: 4.9 % of the map lies"), "{warning}");
        assert_eq!(map.hole_warning(), None);
        // A few pits are part of the surface.
        let pitted = map.changed(|n, h| if n % 400 == 0 { h - 40.0 * map.sq_m() } else { h });
        assert_eq!(pitted.hole_warning(), None);
    }

    #[test]
    fn spikes_matter_where_they_change_the_slope_or_the_highest_point() {
        let map = rough(0.8);
        let tilted = map.changed(|n, h| h + 20.0 * map.sq_m() * (n / 128) as f64);
        let spiked = |by: f64| {
            tilted
                .changed(|n, h| if n == 3000 { h + by * map.sq_m() } else { h })
                .spike_warning(&Unwatched)
                .unwrap()
                .unwrap()
        };
        for by in [30.0, -300.0] {
            assert!(spiked(by).matter, "{}", spiked(by).warning);
        }
        for (rms_slope, highest_m, matters) in [(0.102, 1.05e-6, false), (0.104, 1e-6, true), (0.1, 1.2e-6, true)] {
            assert_eq!(matter([rms_slope, highest_m], [0.1, 1e-6]), matters, "{rms_slope} {highest_m}");
        }
    }

    #[test]
    fn slopes_of_another_unit_are_named() {
        let said = slope_text;
        assert!(said(1.3e-5).contains("with heights 1000 times as large"), "{}", said(1.3e-5));
        assert!(said(51.0).contains("heights a thousandth as large"), "{}", said(51.0));
        assert!(!said(1.2).contains("as large"));
    }

    #[test]
    fn missing_points_slopes_and_units_have_limits() {
        let map = rough(0.8);
        let holed = |share: f64| map.changed(|n, h| if (n as f64) < share * 16384.0 { f64::NAN } else { h });
        assert_eq!(holed(0.09).missing_warning(), None);
        assert!(holed(0.2).missing_warning().unwrap().to_string().starts_with("missing points: 20 % of the map"));
        for (slope, warned) in [(2e-4, false), (0.9, false), (1.1, true), (5e-5, true), (f64::NAN, true)] {
            assert_eq!(map.height_warnings(slope, 0).len(), usize::from(warned), "{slope}");
        }
        for (factor, warned) in [(1.0, false), (1e3, true), (1e-4, true)] {
            let map = map.scaled(factor).unwrap();
            let names: Vec<_> = map.height_warnings(0.01, 0).iter().map(|warning| warning.doubt.name()).collect();
            assert_eq!(names == ["unit of heights"], warned, "{factor}: {names:?}");
        }
    }
}
