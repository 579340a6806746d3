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
//! h. As measured on a surface, the width is that at half depth, and the depth the mean over the middle third of it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use slipgrid_model::pattern::Contour;

use crate::export::marking::length_m;
use crate::export::{
    Cavity, Laser, Layout, Line, MICROMETRE_DECIMALS, Marking, decimal, micrometres, round_decimals, six_digits,
    unreached,
};

/// Range of a cavity's width that counts as its middle, as fractions.
const MIDDLE_RANGE: [f64; 2] = [1.0 / 3.0, 2.0 / 3.0];
/// Number of points at which a part of a cavity's width is sampled.
const SAMPLE_POINTS: u32 = 400;
/// Number of bins of the depth profile between the edge and the middle of a cavity on a process sheet.
const LISTED_BINS: u32 = 8;
/// Number of rounds for width and depth, of which each depends on the other; a round divides errors by ten or more.
const WIDTH_ROUNDS: u32 = 6;
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
    /// width at half depth, where depth is measured.
    pub passes: u32,
    /// Depth removed by one pass in the middle third.
    pub depth_per_pass_um: f64,
    /// Depth removed by all passes in the middle third.
    pub depth_um: f64,
    /// Removed volume over the area of the cavities.
    pub mean_depth_um: f64,
    /// Width that is made, across the lines at half depth.
    pub width_um: f64,
    /// Distance over which depth increases from zero to that in the middle: one spot, half of it on either side of a
    /// cavity's edge.
    pub edge_ramp_um: f64,
    /// Speed at which this number of passes makes the depth of the design; omitted if pulses would be farther apart
    /// than the spot is wide.
    pub speed_for_depth_mm_s: Option<f64>,
    /// Deviations by more than 5 % from width and depth of the design, and areas that the spot does not reach, with
    /// remedies.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
}

impl Removal {
    /// Computes the removal for all cavities of `layout`; `None` if bursts on spots or a mask give the depth, or if
    /// laser parameters are missing.
    pub fn new(layout: &Layout, laser: &Laser) -> Option<Self> {
        laser.depth_step_um().filter(|_| laser.bursts_per_pass().is_some())?;
        Hatched::new(layout, &Marking::new(laser).ok()?).removal(layout, laser)
    }

    /// Describes the depth that a pass and all passes remove, in the middle of a cavity and on average.
    pub fn words(&self) -> String {
        let um = |depth_um: f64| decimal((100.0 * depth_um).round() / 100.0, 2);
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
pub(crate) struct Hatched {
    pub(crate) lines: u64,
    pub(crate) length_m: f64,
    /// Smallest and largest distance between neighbouring lines in a cavity, in metres; `None` if no cavity has two
    /// lines.
    pub(crate) apart_m: Option<[f64; 2]>,
    /// Number and area, in square metres, of cavities without a line.
    bare: (u32, f64),
    /// First cavity with the greatest total length of lines, which represents all cavities, and its lines; `None` if
    /// all lines have zero length.
    one: Option<(Cavity, Vec<Line>)>,
    /// Radius of the spot, in metres.
    half_spot_m: f64,
    /// Section of the cavity `one` along which depth is sampled; `None` without such a cavity.
    section: Option<Section>,
    /// What is made along the section; `None` without depth.
    made: Option<Made>,
}

/// A cavity as it is measured along its section.
struct Made {
    /// Width at half depth, in metres.
    width_m: f64,
    /// Mean length of lines within half a spot of a point in the middle third of this width, in metres.
    reach_m: f64,
    /// The middle third, as fractions of the section.
    middle: [f64; 2],
}

/// Straight section across a cavity from edge to edge, through the middle of its longest line and at right angles to
/// it.
struct Section {
    from_m: [f64; 2],
    /// Unit vector along the section.
    across: [f64; 2],
    width_m: f64,
}

impl Hatched {
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
                (most_m, one) = (own_m, Some((cavity, own)));
            }
        }
        let across = |(cavity, own): &(Cavity, Vec<Line>)| Section::across(cavity, own, marking.direction(cavity));
        let section = one.as_ref().and_then(across);
        let half_spot_m = marking.half_spot_m;
        let mut of = Self { lines, length_m: length, apart_m, bare, one, half_spot_m, section, made: None };
        of.made = of.section.as_ref().and_then(|section| of.measured(section));
        of
    }

    /// Distance of the outermost line from the edge of a cavity, in metres; `None` without a section.
    pub(crate) fn outermost_m(&self) -> Option<f64> {
        let (section, (_, lines)) = self.section.as_ref().zip(self.one.as_ref())?;
        let at_m = |[from, _]: &Line| -> f64 {
            (0..2).map(|axis| (from[axis] - section.from_m[axis]) * section.across[axis]).sum()
        };
        lines.iter().map(at_m).filter(|at_m| *at_m >= 0.0).min_by(f64::total_cmp)
    }

    /// Measures width and depth along `section`; `None` if there is no depth in the middle.
    fn measured(&self, section: &Section) -> Option<Made> {
        let at_share = |share: f64| self.mean_of_lines(section, [share; 2], 1, |within_m| within_m);
        let reach = self.half_spot_m / section.width_m;
        let step = (1.0 + 2.0 * reach) / f64::from(SAMPLE_POINTS);
        let profile: Vec<f64> = (0..=SAMPLE_POINTS).map(|k| at_share(f64::from(k) * step - reach)).collect();
        let mut made = Made { width_m: section.width_m, reach_m: 0.0, middle: MIDDLE_RANGE };
        for _ in 0..WIDTH_ROUNDS {
            made.reach_m = self.mean_of_lines(section, made.middle, SAMPLE_POINTS, |within_m| within_m);
            let level_m = 0.5 * made.reach_m;
            // Both outermost points of half depth, interpolated; another arm of a polygon may reach the ends.
            let is_deep = |depth_m: &f64| *depth_m > level_m;
            let [first, last] = [profile.iter().position(is_deep)?, profile.iter().rposition(is_deep)?];
            let at = |deep: usize, shallow: usize| {
                let share = profile.get(shallow).map_or(0.0, |z| (profile[deep] - level_m) / (profile[deep] - z));
                (deep as f64 + share * (shallow as f64 - deep as f64)) * step - reach
            };
            let [from, to] = [at(first, first.wrapping_sub(1)), at(last, last + 1)];
            made.width_m = (to - from) * section.width_m;
            made.middle = MIDDLE_RANGE.map(|share| from + share * (to - from));
        }
        Some(made)
    }

    /// Warnings about areas that the spot does not reach.
    pub(crate) fn unreached_warnings(&self, layout: &Layout) -> Vec<String> {
        let Some((made, share)) = self.made.as_ref().zip(self.made_share()) else { return Vec::new() };
        let mut warnings = unreached::warnings(layout, self.half_spot_m, self.bare, share);
        let wanted_m = self.section.as_ref().map_or(made.width_m, |section| section.width_m);
        if let Some(off) = off(made.width_m, wanted_m) {
            warnings.push(format!(
                "lines make cavities {} um wide at half depth, {off} of the design's {} um, as the spot is {} um wide: a smaller spot \
                 or wider cavities come nearer",
                decimal(made.width_m * 1e6, 1),
                decimal(wanted_m * 1e6, 1),
                decimal(2e6 * self.half_spot_m, 1)
            ));
        }
        warnings
    }

    /// Fraction of a cavity that is at least half as deep as its middle; `None` without depth.
    pub(crate) fn made_share(&self) -> Option<f64> {
        let ((one, lines), made) = self.one.as_ref().zip(self.made.as_ref())?;
        let reach_m = |at_m: [f64; 2]| lines.iter().map(|line| within_m(line, at_m, self.half_spot_m)).sum::<f64>();
        Some(unreached::share(one, |at_m| reach_m(at_m) >= 0.5 * made.reach_m))
    }

    /// Mean over `points` of a part of `section`, from `from` to `to` as fractions of its width, of a sum over lines:
    /// each line adds `of(length)` for the length, in metres, of its part within half a spot of the point.
    fn mean_of_lines(&self, section: &Section, [from, to]: [f64; 2], points: u32, of: fn(f64) -> f64) -> f64 {
        let at_point = |k: u32| -> f64 {
            let at_m = section.width_m * (from + (to - from) * (f64::from(k) + 0.5) / f64::from(points));
            let at = [0, 1].map(|axis| section.from_m[axis] + at_m * section.across[axis]);
            let lines = self.one.iter().flat_map(|(_, lines)| lines);
            lines.map(|line| of(within_m(line, at, self.half_spot_m))).sum()
        };
        (0..points).map(at_point).sum::<f64>() / f64::from(points)
    }

    /// Mean number of lines within half a spot of a point, over the middle third of the width that is made;
    /// `None` without a section.
    pub(crate) fn exposures(&self) -> Option<f64> {
        let is_within = |within_m: f64| if within_m > 0.0 { 1.0 } else { 0.0 };
        Some(self.mean_of_lines(self.section.as_ref()?, self.made.as_ref()?.middle, SAMPLE_POINTS, is_within))
    }

    /// Depth profile of `passes` between an edge and the middle of a cavity, in um: for each bin, the distance from the
    /// edge at which it ends and its mean depth. `None` without a section or if laser parameters are missing.
    pub(crate) fn across_um(&self, laser: &Laser, passes: u32) -> Option<Vec<[f64; 2]>> {
        let section = self.section.as_ref()?;
        let scale = f64::from(passes) * laser.depth_per_burst_um? / laser.pulse_distance_um()?;
        let share = |k: u32| 0.5 * f64::from(k) / f64::from(LISTED_BINS);
        let up_to = |k: u32| {
            let depth_m = scale * self.mean_of_lines(section, [share(k - 1), share(k)], SAMPLE_POINTS, |m| m);
            [micrometres(section.width_m * share(k)), micrometres(depth_m)]
        };
        Some((1..=LISTED_BINS).map(up_to).collect())
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
        let Some(made) = &self.made else { return laser.depth_step_um() };
        // z / N = (d / p) <length of lines within s/2>
        Some(laser.depth_per_burst_um? / laser.pulse_distance_um()? * made.reach_m * 1e6)
    }

    /// Number of passes that comes nearest to the depth of the design; `None` if laser parameters are missing.
    pub(crate) fn passes(&self, layout: &Layout, laser: &Laser) -> Option<u32> {
        laser.depth_per_burst_um.and(laser.pulse_distance_um()).and(laser.speed_mm_s)?;
        let passes = layout.pattern().depth_m() * 1e6 / self.per_pass_um(laser)?;
        // At most a billion, so that the cast cannot overflow.
        Some(passes.round().clamp(1.0, MAX_PASSES) as u32)
    }

    pub(crate) fn removal(&self, layout: &Layout, laser: &Laser) -> Option<Removal> {
        let (passes, per_pass_um) = (self.passes(layout, laser)?, self.per_pass_um(laser)?);
        let (pulse_um, speed_mm_s) = (laser.pulse_distance_um()?, laser.speed_mm_s?);
        let design_um = layout.pattern().depth_m() * 1e6;
        let Some(made) = &self.made else {
            let warnings = vec![NO_LINES.to_owned()];
            return Some(Removal { passes, edge_ramp_um: laser.spot_um?, warnings, ..Removal::default() });
        };
        let made_um = f64::from(passes) * per_pass_um;
        let area_m2 = layout.cavity_area_m2();
        let mean_um = self.volume_m3(laser, passes)? / area_m2 * 1e6;
        // z is proportional to 1 / v
        let speed = speed_mm_s * made_um / design_um;
        let are_pulses_close = speed / speed_mm_s * pulse_um <= laser.spot_um? * (1.0 + LENGTH_TOLERANCE);
        let speed_for_depth_mm_s = are_pulses_close.then(|| six_digits(speed));
        let mut warnings = self.unreached_warnings(layout);
        let pass_words = if passes == 1 { "1 pass makes".to_owned() } else { format!("{passes} passes make") };
        if let Some(off) = off(made_um, design_um) {
            let how = speed_for_depth_mm_s.map_or_else(
                || "a lower fluence makes passes finer".to_owned(),
                |speed| format!("{} mm/s instead of {speed_mm_s} makes it right", decimal(speed, 1)),
            );
            warnings.push(format!(
                "{pass_words} {} um in the middle of a cavity, {off} of the design's {} um: {how}",
                decimal(made_um, 1),
                decimal(design_um, 1)
            ));
        }
        let wanted_um = removed_volume_m3(layout, laser) / area_m2 * 1e6;
        if let Some(off) = off(mean_um, wanted_um) {
            let what = if mean_um < wanted_um {
                let more = (wanted_um / mean_um * f64::from(passes)).round();
                let more = if more > f64::from(passes) {
                    format!(
                        "; {more} passes come nearest to it, with {} um in the middle",
                        decimal(more * per_pass_um, 1)
                    )
                } else {
                    String::new()
                };
                format!(
                    "depth grows over one spot, {} um, across the edge of a cavity; a smaller spot or wider cavities have steeper walls{more}",
                    decimal(2e6 * self.half_spot_m, 1)
                )
            } else {
                "lines lie nearer to each other than the hatch, to fit into a cavity".to_owned()
            };
            let (mean, wanted) = (decimal(mean_um, 1), decimal(wanted_um, 1));
            warnings
                .push(format!("the mean depth over cavities is {mean} um, {off} of the design's {wanted} um: {what}"));
        }
        Some(Removal {
            passes,
            depth_per_pass_um: round_decimals(per_pass_um, MICROMETRE_DECIMALS),
            depth_um: round_decimals(made_um, MICROMETRE_DECIMALS),
            mean_depth_um: round_decimals(mean_um, MICROMETRE_DECIMALS),
            width_um: micrometres(made.width_m),
            edge_ramp_um: laser.spot_um?,
            speed_for_depth_mm_s,
            warnings,
        })
    }
}

/// Warning for cavities smaller than the spot.
const NO_LINES: &str = "no line is left in a cavity smaller than the spot: a smaller spot or wider cavities make it";

/// Deviation of a length from that of the design, in words, if it is large.
fn off(made: f64, wanted: f64) -> Option<String> {
    let share = made / wanted - 1.0;
    (share.abs() > WARNED_DEVIATION).then(|| format!("{:+.0} %", 100.0 * share))
}

impl Section {
    fn across(cavity: &Cavity, lines: &[Line], [dx, dy]: [f64; 2]) -> Option<Self> {
        let longest = lines.iter().fold(None, |longest: Option<&Line>, line| match longest {
            Some(other) if length_m(line) <= length_m(other) * (1.0 + LENGTH_TOLERANCE) => Some(other),
            _ => Some(line),
        })?;
        let middle = [0, 1].map(|axis| f64::midpoint(longest[0][axis], longest[1][axis]));
        let across = [-dy, dx];
        let place = |[x_m, y_m]: [f64; 2]| (x_m * dx + y_m * dy, y_m * dx - x_m * dy);
        let (along_m, at_m) = place(middle);
        let [from_m, to_m] = if let Some(face) = &cavity.face {
            // The left side of the direction across is backwards along the lines.
            let spans_m = face.spans_m(across, -along_m);
            spans_m.into_iter().find(|[from_m, to_m]| (*from_m..=*to_m).contains(&at_m))?
        } else {
            let (centre_along_m, centre_m) = place([cavity.centre_x_m, cavity.centre_y_m]);
            let half_m = match cavity.planform.contour() {
                Contour::Circle => {
                    let (radius_m, off_m) = (cavity.width_m / 2.0, along_m - centre_along_m);
                    ((radius_m - off_m) * (radius_m + off_m)).max(0.0).sqrt()
                }
                Contour::Rectangle => cavity.width_m.min(cavity.length_m) / 2.0,
            };
            [centre_m - half_m, centre_m + half_m]
        };
        let from = [along_m * dx - from_m * dy, along_m * dy + from_m * dx];
        Some(Self { from_m: from, across, width_m: to_m - from_m })
    }
}

/// Length of the part of a line that is within `radius_m` of a point, in metres.
fn within_m([from, to]: &Line, [x_m, y_m]: [f64; 2], radius_m: f64) -> f64 {
    let length = length_m(&[*from, *to]);
    if length == 0.0 {
        return 0.0;
    }
    let [ex, ey] = [(to[0] - from[0]) / length, (to[1] - from[1]) / length];
    let (dx_m, dy_m) = (x_m - from[0], y_m - from[1]);
    let (along_m, off_m) = (dx_m * ex + dy_m * ey, dy_m * ex - dx_m * ey);
    let half_m = ((radius_m - off_m) * (radius_m + off_m)).max(0.0).sqrt();
    ((along_m + half_m).min(length) - (along_m - half_m).max(0.0)).max(0.0)
}

/// Warnings about deviations of the cut cavities of `layout` from the design, for passes over lines or for bursts on
/// spots.
pub fn laser_warnings(layout: &Layout, laser: &Laser) -> Vec<String> {
    Removal::new(layout, laser).map_or_else(|| burst_warnings(layout, laser), |removal| removal.warnings)
}

/// Warnings about areas of cavities of `layout` that the spot does not reach, if bursts on spots give the depth;
/// otherwise empty. For passes over lines, [`Removal`] has the warnings.
pub fn burst_warnings(layout: &Layout, laser: &Laser) -> Vec<String> {
    if laser.is_mask() || laser.bursts(layout.pattern().depth_m()).is_none() {
        return Vec::new();
    }
    Marking::new(laser).map_or_else(|_| Vec::new(), |marking| Hatched::new(layout, &marking).unreached_warnings(layout))
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
