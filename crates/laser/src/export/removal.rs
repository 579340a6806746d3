//! Depth removed by passes over the lines of a hatch.
//!
//! A pulse removes the depth d over the area of the spot, whose diameter is s. Pulses are p = v / f apart (speed v,
//! repetition rate f) along lines. The number of pulses that reach a point x is the length of the lines within half a
//! spot of x, divided by p. N passes remove the depth z and the volume V:
//!
//! ```text
//! z(x) = N (d / p) sum over lines of length(line within s/2 of x)
//! V = integral of z = N (d / p) (pi/4) s^2 L          L: length of all lines
//! ```
//!
//! For an infinite hatch with the line distance h, z is N d (pi/4) s^2 / (p h). Depth increases over the width of a
//! spot across the edge of a cavity, where it is half of that in the middle, and evenly spaced lines may be closer than
//! h. As measured on a surface, the width is that at half depth (of a round cavity, the diameter of the disc with the
//! area at half depth), and the depth the mean over the middle third of a width.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use slipgrid_base::statistics::extremes;
use slipgrid_model::pattern::{Contour, Pattern};

use crate::export::marking::length_m;
use crate::export::{
    Cavity, Laser, Layout, Line, Marking, Outline, decimal, depth, depth_words, micrometres, six_digits, unreached,
};

/// Range of a cavity's width that counts as its middle, as fractions.
const MIDDLE_RANGE: [f64; 2] = [1.0 / 3.0, 2.0 / 3.0];
/// Number of points at which a part of a cavity's width is sampled.
const SAMPLE_POINTS: u32 = 400;
/// Number of bins of the depth profile between the edge and the middle of a cavity on a process sheet.
const LISTED_BINS: u32 = 8;
/// Number of rows in which the area of a round cavity at half depth is sampled.
const ROWS: u32 = 60;
/// Relative deviation from width or depth of the design above which a warning is given.
const WARNED_DEVIATION: f64 = 0.05;
/// Relative tolerance for equal lengths of lines.
const LENGTH_TOLERANCE: f64 = 1e-9;
/// Maximum number of passes, so that it fits into a `u32`.
const MAX_PASSES: f64 = 1e9;

/// Depth removed by passes over the lines of a hatch, and the number of passes for a depth.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Removal {
    /// Passes over every line, chosen for the best match with the depth of the design in the middle third of a cavity's
    /// width, where depth is measured.
    pub passes: u32,
    /// Depth removed by one pass in the middle third.
    pub depth_per_pass_um: f64,
    /// Depth removed by all passes in the middle third.
    pub depth_um: f64,
    /// Least and greatest depth of all passes in the middle third, between lines and on them.
    #[serde(default)]
    pub floor_um: [f64; 2],
    /// Removed volume over the area of the cavities.
    pub mean_depth_um: f64,
    /// Width that is made, across the lines at half depth; of a disc, the diameter of the disc with the area at half
    /// depth.
    pub width_um: f64,
    /// Distance over which depth increases from zero to that in the middle if lines are much nearer than the spot is wide:
    /// one spot, half of it on either side of a cavity's edge. Lines farther apart make steps in it.
    pub edge_ramp_um: f64,
    /// Speed at which this number of passes makes the depth of the design; omitted if pulses would be farther apart
    /// than the spot is wide.
    pub speed_for_depth_mm_s: Option<f64>,
    /// Deviations by more than 5 % from width and depth of the design, floors uneven by more than the tolerance of the
    /// depth, and areas that the spot does not reach, with remedies.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
}

/// Largest difference of the depth that whole exposures make from `design_um` that counts as none: 5 % or `std_um`, the
/// standard deviation of the depth that the design assumes, whichever is less.
pub fn depth_within_um(design_um: f64, std_um: Option<f64>) -> f64 {
    (WARNED_DEVIATION * design_um).min(std_um.unwrap_or(f64::INFINITY))
}

impl Removal {
    /// Computes the removal for all cavities of `layout`; `None` if bursts on spots or a mask give the depth, or if
    /// laser parameters are missing.
    pub fn new(layout: &Layout, laser: &Laser) -> Option<Self> {
        laser.infinite_pass_um()?;
        LayoutHatch::new(layout, &Marking::new(laser).ok()?).removal(layout, laser)
    }

    /// Says that whole passes at `speed_mm_s` depart from the depth of the design by more than 5 %, or by more than the
    /// standard deviation of the depth that the design assumes, and which speed makes it; `None` if they do not.
    pub fn wrong_depth(&self, [design_um, speed_mm_s]: [f64; 2], std_um: Option<f64>) -> Option<String> {
        let share = self.depth_um / design_um - 1.0;
        let is_far = (self.depth_um - design_um).abs() > depth_within_um(design_um, std_um);
        let how = self.speed_for_depth_mm_s.map_or_else(
            || "a lower fluence makes passes finer".to_owned(),
            |speed| format!("{} mm/s instead of {speed_mm_s} makes it right", decimal(speed, 1)),
        );
        let passes = if self.passes == 1 { "1 pass makes".to_owned() } else { format!("{} passes make", self.passes) };
        (is_far && self.depth_um > 0.0).then(|| {
            format!(
                "{passes} {} um in the middle of a cavity, {:+.0} % of the design's {} um: {how}",
                depth_words(self.depth_um, 1),
                100.0 * share,
                depth_words(design_um, 1)
            )
        })
    }

    /// Warns of a floor that departs from the depth in the middle by more than the standard deviation of the depth that
    /// the design assumes, beyond which the design's interval of samples does not hold. No warning without tolerances.
    #[must_use]
    pub fn with_depth_tolerance(mut self, std_um: Option<f64>) -> Self {
        let [least_um, greatest_um] = self.floor_um;
        let off_um = (self.depth_um - least_um).max(greatest_um - self.depth_um);
        if let Some(std_um) = std_um.filter(|std_um| off_um > *std_um) {
            self.warnings.push(format!(
                "the floor between lines and on them is {} to {} um deep, uneven by more than the depth's tolerance of {std_um} um: lines \
                 nearer to each other (hatch_um), at a proportionally lower depth per burst, even it out",
                depth_words(least_um, 1),
                depth_words(greatest_um, 1)
            ));
        }
        self
    }

    /// Describes the depth that a pass and all passes remove, in the middle of a cavity and on average.
    pub fn words(&self) -> String {
        let um = |depth_um: f64| depth_words(depth_um, 2);
        let passes = f64::from(self.passes.max(1));
        let [middle, mean] = [um(self.depth_per_pass_um), um(self.mean_depth_um / passes)];
        let each =
            format!("a pass removes {middle} um in the middle of a cavity and {mean} um on average with its edges");
        match self.passes {
            0 | 1 => each,
            _ => format!("{each}; all make {} um and {} um", um(self.depth_um), um(self.mean_depth_um)),
        }
    }
}

/// All lines on a specimen, with the data from which depths are computed.
pub(crate) struct LayoutHatch {
    pub(crate) lines: u64,
    pub(crate) length_m: f64,
    /// Smallest and largest distance between neighbouring lines in a cavity, in metres; `None` if no cavity has two
    /// lines.
    pub(crate) apart_m: Option<[f64; 2]>,
    /// Number and area, in square metres, of cavities without a line.
    bare: (u32, f64),
    half_spot_m: f64,
    /// First cavity with the greatest total length of lines, which represents all cavities; `None` without depth.
    pub(crate) cavity: Option<CavityHatch>,
}

/// A hatched cavity in the axes of its lines: u along them, v across, to their left, in metres.
pub(crate) struct CavityHatch {
    cavity: Cavity,
    along: [f64; 2],
    /// v and both ends of each line, ascending.
    lines: Vec<[f64; 3]>,
    /// Distance between neighbouring lines; 0 of a single one.
    apart_m: f64,
    half_spot_m: f64,
    /// u of the straight section across the cavity, through the middle of its longest line, along which depth is sampled.
    section_m: f64,
    /// v of both edges of the cavity on the section.
    edges_m: [f64; 2],
    /// Mean length of lines within half a spot of a point in the middle third of the section.
    middle_m: f64,
}

impl LayoutHatch {
    pub(crate) fn new(layout: &Layout, marking: &Marking) -> Self {
        let (mut lines, mut length, mut most_m, mut one) = (0, 0.0, 0.0, None);
        let mut apart_m: Option<[f64; 2]> = None;
        let mut bare = (0, 0.0);
        let hatch = marking.on(layout);
        for cavity in layout.iter() {
            let (own, distance_m) = hatch.fill(&cavity);
            if let Some(at_m) = distance_m {
                let [least_m, most_m] = apart_m.unwrap_or([at_m; 2]);
                apart_m = Some([least_m.min(at_m), most_m.max(at_m)]);
            }
            let own_m: f64 = own.iter().map(length_m).sum();
            if own.is_empty() {
                bare = (bare.0 + 1, bare.1 + cavity.area_m2());
            }
            lines += own.len() as u64;
            length += own_m;
            if own_m > most_m * (1.0 + LENGTH_TOLERANCE) {
                (most_m, one) = (own_m, Some((cavity, own, distance_m)));
            }
        }
        let cavity = one.and_then(|(cavity, own, apart_m)| CavityHatch::new(cavity, &own, apart_m, marking));
        Self { lines, length_m: length, apart_m, bare, half_spot_m: marking.half_spot_m, cavity }
    }

    /// Warnings about the width that is made and areas that the spot does not reach.
    fn shape_warnings(&self, layout: &Layout) -> Vec<String> {
        let Some(cavity) = &self.cavity else { return Vec::new() };
        let mut warnings = unreached::warnings(layout, self.half_spot_m, self.bare, cavity.made_share());
        let [made_m, wanted_m] = [cavity.width_m(), cavity.section_width_m()];
        if let Some(off) = off(made_m, wanted_m) {
            warnings.push(format!(
                "across the lines, cavities are {} um wide at half depth, {off} of the design's {} um, as the spot is {} um wide: a smaller spot \
                 or wider cavities come nearer",
                decimal(made_m * 1e6, 1),
                decimal(wanted_m * 1e6, 1),
                decimal(2e6 * self.half_spot_m, 1)
            ));
        }
        warnings
    }

    /// Volume removed by `passes`, in cubic metres; `None` if laser parameters are missing.
    pub(crate) fn volume_m3(&self, laser: &Laser, passes: u32) -> Option<f64> {
        let spot_m2 = std::f64::consts::PI * self.half_spot_m * self.half_spot_m;
        // V = N (d / p) (pi/4) s^2 L
        let per_length = laser.depth_per_burst_um? / laser.pulse_distance_um()?;
        Some(f64::from(passes) * per_length * spot_m2 * self.length_m)
    }

    /// Depth of one pass in the middle of a cavity, in um: without a line that of an infinite hatch; `None` if laser
    /// parameters are missing.
    fn per_pass_um(&self, laser: &Laser) -> Option<f64> {
        self.cavity.as_ref().map_or_else(|| laser.infinite_pass_um(), |cavity| cavity.per_pass_um(laser))
    }

    /// Number of passes that comes nearest to the depth of the design; `None` if laser parameters are missing.
    pub(crate) fn passes(&self, layout: &Layout, laser: &Laser) -> Option<u32> {
        let passes = layout.pattern().depth_m() * 1e6 / self.per_pass_um(laser)?;
        // At most a billion, so that the cast cannot overflow.
        Some(passes.round().clamp(1.0, MAX_PASSES) as u32)
    }

    pub(crate) fn removal(&self, layout: &Layout, laser: &Laser) -> Option<Removal> {
        let (passes, per_pass_um) = (self.passes(layout, laser)?, self.per_pass_um(laser)?);
        let (pulse_um, speed_mm_s) = (laser.pulse_distance_um()?, laser.speed_mm_s?);
        let design_um = layout.pattern().depth_m() * 1e6;
        let Some(cavity) = &self.cavity else {
            let warnings = vec![NO_LINES.to_owned()];
            return Some(Removal { passes, edge_ramp_um: laser.spot_um?, warnings, ..Removal::default() });
        };
        let made_um = f64::from(passes) * per_pass_um;
        let floor_um = cavity.floor_m().map(|reach_m| made_um * reach_m / cavity.middle_m);
        // z is proportional to 1 / v
        let speed = speed_mm_s * made_um / design_um;
        let are_pulses_close = speed / speed_mm_s * pulse_um <= laser.spot_um? * (1.0 + LENGTH_TOLERANCE);
        let speed_for_depth_mm_s = are_pulses_close.then(|| six_digits(speed));
        let mut removal = Removal {
            passes,
            depth_per_pass_um: depth(per_pass_um),
            depth_um: depth(made_um),
            floor_um: floor_um.map(depth),
            mean_depth_um: depth(self.volume_m3(laser, passes)? / layout.cavity_area_m2() * 1e6),
            width_um: micrometres(cavity.width_m()),
            edge_ramp_um: laser.spot_um?,
            speed_for_depth_mm_s,
            warnings: self.shape_warnings(layout),
        };
        removal.warnings.extend(removal.wrong_depth([design_um, speed_mm_s], None));
        Some(removal)
    }
}

/// Warning for cavities smaller than the spot.
const NO_LINES: &str = "no line is left in a cavity smaller than the spot: a smaller spot or wider cavities make it";

/// Deviation of a length from that of the design, in words, if it is large.
fn off(made: f64, wanted: f64) -> Option<String> {
    let share = made / wanted - 1.0;
    (share.abs() > WARNED_DEVIATION).then(|| format!("{:+.0} %", 100.0 * share))
}

impl CavityHatch {
    /// Hatch of a cavity of `pattern` far from the border of a specimen; `None` without depth, and if the laser has no
    /// spot.
    pub(crate) fn of_pattern(pattern: &Pattern, laser: &Laser) -> Option<Self> {
        let marking = Marking::new(laser).ok()?;
        // The middle of a groove so long does not depend on the grooves' ends.
        let groove_m = 2.0 * pattern.width_m() + 4.0 * marking.half_spot_m;
        let cavity = Cavity::new(pattern, [0.0; 2], pattern.length_m().unwrap_or(groove_m));
        let face = Outline::Disc { diameter_m: 4.0 * (cavity.width_m.hypot(cavity.length_m) + groove_m) };
        let (lines, apart_m) = marking.on_face(&face, cavity.width_m.min(cavity.length_m)).fill(&cavity);
        Self::new(cavity, &lines, apart_m, &marking)
    }

    fn new(cavity: Cavity, lines: &[Line], apart_m: Option<f64>, marking: &Marking) -> Option<Self> {
        let along @ [dx, dy] = marking.direction(&cavity);
        let turned = |line: &Line| {
            let [[u0, v], [u1, _]] = line.map(|[x, y]| [x * dx + y * dy, y * dx - x * dy]);
            [v, u0.min(u1), u0.max(u1)]
        };
        let mut lines: Vec<[f64; 3]> = lines.iter().map(turned).collect();
        lines.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let longer = |a: [f64; 3], b: [f64; 3]| {
            if b[2] - b[1] > (a[2] - a[1]) * (1.0 + LENGTH_TOLERANCE) { b } else { a }
        };
        let [longest_m, from_m, to_m] = lines.iter().copied().reduce(longer)?;
        let section_m = f64::midpoint(from_m, to_m);
        // The left side of the direction across is backwards along the lines.
        let spans_m = cavity.spans_m([-dy, dx], -section_m);
        let edges_m = spans_m.into_iter().find(|[low_m, high_m]| (*low_m..=*high_m).contains(&longest_m))?;
        let (apart_m, half_spot_m) = (apart_m.unwrap_or(0.0), marking.half_spot_m);
        let mut of = Self { cavity, along, lines, apart_m, half_spot_m, section_m, edges_m, middle_m: 0.0 };
        of.middle_m = of.mean(MIDDLE_RANGE, |within_m| within_m);
        (of.middle_m > 0.0).then_some(of)
    }

    /// Length of the lines over the area of the cavity, in 1/m.
    pub(crate) fn length_over_area(&self) -> f64 {
        self.lines.iter().map(|[_, from_m, to_m]| to_m - from_m).sum::<f64>() / self.cavity.area_m2()
    }

    fn section_width_m(&self) -> f64 {
        self.edges_m[1] - self.edges_m[0]
    }

    /// v of a point of the section, from its place as a fraction of the section.
    fn v_m(&self, share: f64) -> f64 {
        self.edges_m[0] + share * self.section_width_m()
    }

    /// Sum over the lines within half a spot of the point (u, v): each adds `of(length)` for the length, in metres, of its
    /// part there.
    fn sum_at(&self, [u, v]: [f64; 2], of: impl Fn(f64) -> f64) -> f64 {
        let first = self.lines.partition_point(|[line_m, ..]| *line_m <= v - self.half_spot_m);
        let near = self.lines[first..].iter().take_while(|[line_m, ..]| *line_m < v + self.half_spot_m);
        near.map(|[line_m, from_m, to_m]| {
            let off_m = v - line_m;
            let half_m = ((self.half_spot_m - off_m) * (self.half_spot_m + off_m)).max(0.0).sqrt();
            of((to_m.min(u + half_m) - from_m.max(u - half_m)).max(0.0))
        })
        .sum()
    }

    /// Length of lines within half a spot of the point (u, v), in metres.
    fn reach_m(&self, at_m: [f64; 2]) -> f64 {
        self.sum_at(at_m, |within_m| within_m)
    }

    /// Mean of a sum over lines, as in `sum_at`, over a part of the section, from `from` to `to` as fractions.
    fn mean(&self, [from, to]: [f64; 2], of: fn(f64) -> f64) -> f64 {
        let share = |k: u32| from + (to - from) * (f64::from(k) + 0.5) / f64::from(SAMPLE_POINTS);
        let sum: f64 = (0..SAMPLE_POINTS).map(|k| self.sum_at([self.section_m, self.v_m(share(k))], of)).sum();
        sum / f64::from(SAMPLE_POINTS)
    }

    /// Width at half depth, in metres: on the section between the outermost points of half depth, or the diameter of the
    /// disc with the area at half depth.
    fn width_m(&self) -> f64 {
        let (level_m, reach) = (0.5 * self.middle_m, self.half_spot_m / self.section_width_m());
        let step = (1.0 + 2.0 * reach) / f64::from(SAMPLE_POINTS);
        let profile = |u: f64| -> Vec<f64> {
            (0..=SAMPLE_POINTS).map(|k| self.reach_m([u, self.v_m(f64::from(k) * step - reach)])).collect()
        };
        let is_deep = |reach_m: &f64| *reach_m > level_m;
        if self.cavity.planform.contour() == Contour::Circle {
            let half_m = self.cavity.width_m / 2.0 + self.half_spot_m;
            let row_m = 2.0 * half_m / f64::from(ROWS);
            let u = |row: u32| self.section_m - half_m + (f64::from(row) + 0.5) * row_m;
            let deep: usize = (0..ROWS).map(|row| profile(u(row)).iter().filter(|at| is_deep(at)).count()).sum();
            let area_m2 = deep as f64 * step * self.section_width_m() * row_m;
            return (4.0 * area_m2 / std::f64::consts::PI).sqrt();
        }
        let profile = profile(self.section_m);
        // Interpolated; another arm of a polygon may reach the ends.
        let at = |deep: usize, shallow: Option<usize>| {
            let Some((shallow, z)) = shallow.and_then(|at| Some((at, profile.get(at)?))) else { return deep as f64 };
            deep as f64 + (profile[deep] - level_m) / (profile[deep] - z) * (shallow as f64 - deep as f64)
        };
        let ends = profile.iter().position(is_deep).zip(profile.iter().rposition(is_deep));
        let steps = ends.map_or(0.0, |(first, last)| at(last, Some(last + 1)) - at(first, first.checked_sub(1)));
        steps * step * self.section_width_m()
    }

    /// Least and greatest length of lines within half a spot of a point in the middle third, in metres.
    fn floor_m(&self) -> [f64; 2] {
        let [low_m, high_m] = MIDDLE_RANGE.map(|share| self.v_m(share));
        // Between points at which a line comes into the spot's reach, the sum is concave: the least is at such a point.
        let enters = self.lines.iter().flat_map(|[line_m, ..]| [line_m - self.half_spot_m, line_m + self.half_spot_m]);
        let samples = (0..=SAMPLE_POINTS).map(|k| low_m + (high_m - low_m) * f64::from(k) / f64::from(SAMPLE_POINTS));
        let places = enters.filter(|v| (low_m..=high_m).contains(v)).chain(samples);
        extremes(places.map(|v| self.reach_m([self.section_m, v])))
    }

    /// Fraction of the cavity that is at least half as deep as its middle, or between two places so deep on both sides,
    /// half a line distance away: a ridge between coarse lines is not a corner.
    pub(crate) fn made_share(&self) -> f64 {
        let [dx, dy] = self.along;
        let is_made = |[x, y]: [f64; 2]| {
            let is_deep = |off_m| self.reach_m([x * dx + y * dy, y * dx - x * dy + off_m]) >= 0.5 * self.middle_m;
            is_deep(0.0) || is_deep(-0.5 * self.apart_m) && is_deep(0.5 * self.apart_m)
        };
        unreached::share(&self.cavity, is_made)
    }

    /// Distance of the outermost line from the edge of the cavity, in metres.
    pub(crate) fn spot_compensation_m(&self) -> Option<f64> {
        self.lines.iter().map(|[line_m, ..]| line_m - self.edges_m[0]).find(|inset_m| *inset_m >= 0.0)
    }

    /// Mean number of lines within half a spot of a point in the middle third.
    pub(crate) fn exposures(&self) -> f64 {
        self.mean(MIDDLE_RANGE, |within_m| if within_m > 0.0 { 1.0 } else { 0.0 })
    }

    /// Depth of one pass in the middle third, in um; `None` if laser parameters are missing.
    pub(crate) fn per_pass_um(&self, laser: &Laser) -> Option<f64> {
        // z / N = (d / p) <length of lines within s/2>
        Some(laser.depth_per_burst_um? / laser.pulse_distance_um()? * self.middle_m * 1e6)
    }

    /// Depth profile of `passes` between an edge and the middle of the cavity, in um: for each bin, the distance from the
    /// edge at which it ends and its mean depth. `None` if laser parameters are missing.
    pub(crate) fn across_um(&self, laser: &Laser, passes: u32) -> Option<Vec<[f64; 2]>> {
        let scale = f64::from(passes) * self.per_pass_um(laser)? / self.middle_m;
        let share = |k: u32| 0.5 * f64::from(k) / f64::from(LISTED_BINS);
        let up_to = |k: u32| {
            let depth_um = scale * self.mean([share(k - 1), share(k)], |within_m| within_m);
            [micrometres(self.section_width_m() * share(k)), depth(depth_um)]
        };
        Some((1..=LISTED_BINS).map(up_to).collect())
    }
}

/// Warnings about deviations of the cut cavities of `layout` from the design, for passes over lines or for bursts on
/// spots.
pub fn laser_warnings(layout: &Layout, laser: &Laser) -> Vec<String> {
    Removal::new(layout, laser).map_or_else(|| burst_warnings(layout, laser), |removal| removal.warnings)
}

/// Warnings about widths of cavities of `layout`, and areas that the spot does not reach, if bursts on spots give the
/// depth; otherwise empty. For passes over lines, [`Removal`] has the warnings.
pub fn burst_warnings(layout: &Layout, laser: &Laser) -> Vec<String> {
    if laser.is_mask() || laser.bursts(layout.pattern().depth_m()).is_none() {
        return Vec::new();
    }
    Marking::new(laser).map_or_else(|_| Vec::new(), |marking| LayoutHatch::new(layout, &marking).shape_warnings(layout))
}

/// Volume of all cavities of `layout` with the wall taper of `laser`, in cubic metres.
pub(crate) fn removed_volume_m3(layout: &Layout, laser: &Laser) -> f64 {
    let depth_m = layout.pattern().depth_m();
    let inset_m = laser.floor_inset_m(depth_m);
    if inset_m == 0.0 {
        return layout.cavity_volume_m3();
    }
    // Area is quadratic in depth for walls of constant slope, so that d/6 (A_0 + 4 A_1/2 + A_1) is exact.
    let area_m2 = |cavity: &Cavity, share: f64| cavity.inset(share * inset_m).map_or(0.0, |at| at.area_m2());
    let six_m2 = |cavity: Cavity| cavity.area_m2() + 4.0 * area_m2(&cavity, 0.5) + area_m2(&cavity, 1.0);
    // All complete polygons are equal, and the area inside their walls takes time to integrate.
    let mut whole_m2 = None;
    let each_m2 = |cavity: Cavity| {
        if cavity.face.is_some() && cavity.cut_by.is_none() {
            *whole_m2.get_or_insert_with(|| six_m2(cavity))
        } else {
            six_m2(cavity)
        }
    };
    layout.iter().map(each_m2).sum::<f64>() * depth_m / 6.0
}

#[cfg(test)]
mod tests;
