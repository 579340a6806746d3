//! Bursts, lines, passes and time for a layout and a laser.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use slipgrid_base::units::LENGTH_UM;
use slipgrid_model::pattern::{Pattern, Planform};

use crate::export::removal::{CavityHatch, LayoutHatch};
use crate::export::{Exposure, Laser, Layout, Marking, Removal, depth, micrometres, six_digits};

const SPOTS_FORMULA: &str = "ceil(cavity width / spot) * ceil(cavity length / spot): spots edge to edge, the spot taken as a square of that side; \
     overlap, which a round spot needs for an even floor, adds to it";
const SPOT_TIME_FORMULA: &str = "spots_on_specimen * bursts_per_cavity / repetition_hz";
const SPOT_TIME_ASSUMPTIONS: &str =
    "one burst per spot and repetition; movement between spots and cavities not counted";
const NO_SPOTS: &str = "none are counted: a mask exposes each cavity as a whole";
const MASK_TIME_FORMULA: &str = "cavities * bursts_per_cavity / repetition_hz";
const MASK_TIME_ASSUMPTIONS: &str =
    "one burst on a whole cavity per repetition, one cavity after the other; movement between cavities not counted";
const LINE_TIME_FORMULA: &str = "passes * marked_length_mm / speed_mm_s";
const LINE_TIME_ASSUMPTIONS: &str =
    "the spot moves at its speed along lines; jumps between lines and cavities, and acceleration, not counted";
const LINES_FORMULA: &str = "line_distance_um is nominal; within a cavity lines lie evenly between the outermost, which are spot_compensation_um \
     inside the edge, so that half of the depth in the middle falls on the edge; in discs, which have no side along the lines, the outermost \
     are half a distance inside a circle that is larger by spot^2 / (12 diameter) in radius, on which lines end; lines are as near as line_distance_um or nearer: from \
     least_line_distance_um to greatest_line_distance_um, as in hatch.csv";
const BURSTS_FORMULA: &str = "(pi / 4) spot^2 / (pulse distance * line distance): bursts that reach a point in one pass over an endless hatch, on \
     average; the line distance is the nominal one";
const STEP_FORMULA: &str = "depths of designs are whole multiples of this: what a pass over the lines in a cavity of this width removes in its middle, or the \
     depth per burst where bursts are planned on spots or a mask exposes whole cavities; a depth fixed by its bounds is kept as it is";
const ACROSS_FORMULA: &str = "each pair is [x, z]: z is the mean depth, after all passes, over the bin that ends at the distance x from the edge of a \
     cavity and begins where the bin before ends, the first at the edge; the eight bins are equally wide, and the last ends in \
     the middle of the cavity; it holds across the lines, in the middle of their length: at their ends, which lie on the edge, depth is half \
     of that and grows over half a spot";
const REMOVAL_FORMULA: &str = "z(x) = passes * (depth per burst / pulse distance) * length of lines within half a spot of x; removed volume = passes * \
     (depth per burst / pulse distance) * (pi / 4) spot^2 * marked length; the depth in the middle is the mean of z over the middle third of \
     the width, floor_um its least and greatest; the width made is that at half of this depth, of a disc the diameter of the disc with the \
     area at half depth; mean depth is the removed volume over the area of all cavities";

const EXPOSURES_FORMULA: &str = "lines within half a spot of a point, as a mean over the middle third of a cavity's width; depth_per_burst_um is that \
     of a cavity exposed so";

/// Laser work for a specimen: bursts, marking lines, passes and time. Values that need missing laser parameters are
/// absent.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct WorkSheet {
    /// `hatch` or `mask`.
    pub exposure: Exposure,
    /// Depth of the smallest exposure, in um: one pass over the lines of a cavity, otherwise one burst. Depths of designs
    /// are multiples of this step.
    pub depth_step_um: Option<f64>,
    /// Formula for the depth step.
    pub depth_step_formula: Option<String>,
    /// Bursts per cavity (on each of its spots, or on the whole cavity with a mask): depth over depth per burst,
    /// rounded to an integer; absent if passes over lines give the depth.
    pub bursts_per_cavity: Option<u32>,
    /// Depth of `bursts_per_cavity` bursts, in um.
    pub depth_of_bursts_um: Option<f64>,
    /// Standard error of `depth_of_bursts_um`, in um, if the depth per burst was fitted against fluence.
    pub depth_of_bursts_stderr_um: Option<f64>,
    /// Mean number of exposures of a point in the middle third of a cavity's width, if bursts lie edge to edge along
    /// the lines of `hatch.csv`. The depth per burst is that of a cavity exposed so, not of a single spot. Absent
    /// without bursts, if passes over lines give the depth, and for a mask.
    pub exposures_of_a_point: Option<f64>,
    /// Formula for the exposures of a point.
    pub exposures_of_a_point_formula: Option<String>,
    /// Width of a cavity at its floor, if walls slope, in um.
    pub floor_width_um: Option<f64>,
    /// Number of spots that tile a cavity, the largest one if cavities differ. Absent for a mask, which exposes whole
    /// cavities.
    pub spots_per_cavity: Option<u64>,
    /// Number of spots that tile all cavities; absent for a mask.
    pub spots_on_specimen: Option<u64>,
    /// Formula for the number of spots.
    pub spots_formula: String,
    /// Distance of the outermost lines from the edge of a cavity beside them, in um, so that half of the depth in the
    /// middle falls on the edge; the ends of lines lie on the edge, or half a spot inside the specimen's border. Absent
    /// for a mask.
    pub spot_compensation_um: Option<f64>,
    /// Direction of the lines; absent for a mask.
    pub marking_direction: Option<String>,
    /// Nominal distance between lines, that of an infinite hatch, in um: `laser.hatch_um`, or the spot if absent.
    /// Inside a cavity lines are spaced evenly, at this distance or closer.
    pub line_distance_um: Option<f64>,
    /// Smallest distance between neighbouring lines inside a cavity, in um, as in `hatch.csv`; absent if one line fills
    /// each cavity.
    pub least_line_distance_um: Option<f64>,
    /// Largest distance between neighbouring lines inside a cavity, in um, as in `hatch.csv`; equal to the smallest if
    /// all cavities are equally wide.
    pub greatest_line_distance_um: Option<f64>,
    /// Relation between the nominal, smallest and largest line distance.
    pub line_distance_formula: Option<String>,
    /// Overlap of neighbouring lines at their greatest distance inside a cavity, as a fraction of the spot; absent if one
    /// line fills each cavity.
    pub line_overlap: Option<f64>,
    /// Number of lines on the specimen; absent for a mask.
    pub lines_on_specimen: Option<u64>,
    /// Total length of the lines, in mm; absent for a mask.
    pub marked_length_mm: Option<f64>,
    /// Distance between bursts along a line: speed over repetition rate, in um.
    pub pulse_distance_um: Option<f64>,
    /// Overlap of bursts, as a fraction of the spot.
    pub pulse_overlap: Option<f64>,
    /// Mean number of bursts that reach a point in one pass over an infinite hatch.
    pub bursts_per_pass: Option<f64>,
    /// Formula for the bursts per pass.
    pub bursts_per_pass_formula: Option<String>,
    /// Volume removed by all passes over lines, in mm^3; absent if bursts on spots or a mask give the depth.
    pub removed_volume_mm3: Option<f64>,
    /// Depth profile of all passes between the edge of a cavity and its middle, in eight equally wide bins: pairs of
    /// the distance from the edge at which a bin ends, and the mean depth in the bin, both in um.
    pub depths_across_um: Option<Vec<[f64; 2]>>,
    /// Explanation of the pairs in `depths_across_um`.
    pub depths_across_formula: Option<String>,
    /// Formulas for depth and removed volume from the lines.
    pub removal_formula: Option<String>,
    /// Estimated marking time, in s.
    pub estimated_time_s: Option<f64>,
    /// Reason for a missing estimate of the marking time.
    pub no_estimate_because: Option<String>,
    /// Formula for the marking time.
    pub estimated_time_formula: String,
    /// Assumptions of the marking time.
    pub estimated_time_assumptions: String,
    /// Widths that differ from the design's, and areas of cavities that the spot does not reach, with remedies.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
    /// Passes over the lines, and the depth that they remove; absent if bursts on spots or a mask give the depth.
    pub removal: Option<Removal>,
}

/// Estimated marking time for all cavities of `layout`, in seconds, as on the process sheet; `None` if laser parameters
/// are missing.
pub fn laser_time_s(layout: &Layout, laser: &Laser) -> Option<f64> {
    time_s(layout, laser, lines(layout, laser).as_ref())
}

/// Time of one exposure of all cavities of `layout`, in seconds: one pass over their lines, or one burst on each of their
/// spots or of a mask. `None` if laser parameters are missing.
pub fn exposure_time_s(layout: &Layout, laser: &Laser) -> Option<f64> {
    exposure_s(layout, laser, lines(layout, laser).as_ref())
}

/// Depth of one exposure of cavities of `pattern`, in um, and its time over the area of cavities far from the border of a
/// specimen, in s/m^2, `None` if unknown. Both jump with the width, where one more line or spot fits; the time on a
/// specimen over this time is smooth in width and spacing. Cavities narrower than the spot have no line, and the
/// exposures of those that fit. `None` without a depth. The number of grooves that a mask exposes jumps on a specimen,
/// too.
pub fn one_exposure(pattern: &Pattern, laser: &Laser) -> Option<(f64, Option<f64>)> {
    let width_m = pattern.width_m().max(laser.spot_um.map_or(0.0, |spot_um| LENGTH_UM.to_si(spot_um)));
    let pattern = &Pattern::new(*pattern.texture(), width_m, pattern.spacing_m(), pattern.depth_m()).ok()?;
    if laser.has_passes() {
        let cavity = CavityHatch::of_pattern(pattern, laser)?;
        // t / A = L / (v A)
        let time_s_m2 = laser.speed_mm_s.map(|speed_mm_s| cavity.length_over_area() * 1e3 / speed_mm_s);
        return Some((cavity.per_pass_um(laser)?, time_s_m2));
    }
    let spots = |length_m: f64| {
        let along = |spot_um: f64| spots_along(length_m, spot_um) as f64;
        if laser.is_mask() { Some(1.0) } else { laser.spot_um.map(along) }
    };
    // A metre of a groove has so many spots that their number hardly jumps.
    let per_area =
        [pattern.width_m(), pattern.length_m().unwrap_or(1.0)].map(|length_m| Some(spots(length_m)? / length_m));
    let each_s = laser.repetition_hz.map(|repetition_hz| 1.0 / repetition_hz);
    let time_s_m2 = per_area.into_iter().chain([each_s]).product();
    Some((laser.depth_per_burst_um?, time_s_m2))
}

/// The hatch of all cavities of `layout` if passes over its lines give the depth.
fn lines(layout: &Layout, laser: &Laser) -> Option<LayoutHatch> {
    if laser.has_passes() { hatched(layout, laser) } else { None }
}

/// The hatch of all cavities of `layout`; `None` for a mask, which exposes whole cavities, and without a spot diameter.
fn hatched(layout: &Layout, laser: &Laser) -> Option<LayoutHatch> {
    let marking = Marking::new(laser).ok().filter(|_| !laser.is_mask())?;
    Some(LayoutHatch::new(layout, &marking))
}

/// Largest number of spots in a cavity, and number on the specimen; `None` for a mask and without a spot diameter.
fn spots(layout: &Layout, laser: &Laser) -> Option<(u64, u64)> {
    let spot_um = laser.spot_um.filter(|_| !laser.is_mask())?;
    Some(layout.iter().fold((0, 0), |(longest, sum), cavity| {
        let spots = spots_along(cavity.width_m, spot_um) * spots_along(cavity.length_m, spot_um);
        (spots.max(longest), sum + spots)
    }))
}

/// Length of all lines, in millimetres.
fn marked_length_mm(hatch: &LayoutHatch) -> f64 {
    six_digits(hatch.length_m * 1e3)
}

/// Marking time, in seconds, by passes over the lines of `hatch`, or else by bursts; `None` if parameters are missing.
fn time_s(layout: &Layout, laser: &Laser, hatch: Option<&LayoutHatch>) -> Option<f64> {
    let passes = hatch.and_then(|hatch| hatch.passes(layout, laser));
    let exposures = passes.or_else(|| laser.bursts(layout.pattern().depth_m()))?;
    Some(six_digits(f64::from(exposures) * exposure_s(layout, laser, hatch)?))
}

/// Time of one pass over the lines of `hatch`, or else of one burst everywhere, in seconds; `None` if parameters are
/// missing.
fn exposure_s(layout: &Layout, laser: &Laser, hatch: Option<&LayoutHatch>) -> Option<f64> {
    if laser.has_passes() {
        // t = L / v
        return Some(marked_length_mm(hatch?) / laser.speed_mm_s?);
    }
    // Places that are exposed one by one: whole cavities for a mask, otherwise spots. t = N / f
    let exposed = if laser.is_mask() { layout.cavities() as u64 } else { spots(layout, laser)?.1 };
    Some(exposed as f64 / laser.repetition_hz?)
}

impl WorkSheet {
    pub(crate) fn new(layout: &Layout, laser: &Laser) -> Self {
        let depth_m = layout.pattern().depth_m();
        let (bursts, step_um) = (laser.bursts(depth_m), laser.depth_step_um(layout.pattern()));
        let inset_m = laser.floor_inset_m(depth_m);
        let of_bursts_um =
            |value: Option<f64>| bursts.zip(value).map(|(bursts, depth_um)| depth(f64::from(bursts) * depth_um));
        let mut sheet = Self {
            exposure: laser.exposure.unwrap_or_default(),
            depth_step_um: step_um.map(depth),
            depth_step_formula: step_um.map(|_| STEP_FORMULA.to_owned()),
            bursts_per_cavity: bursts,
            depth_of_bursts_um: of_bursts_um(laser.depth_per_burst_um),
            depth_of_bursts_stderr_um: of_bursts_um(laser.ablation.map(|law| law.depth_per_burst_stderr_um)),
            floor_width_um: (inset_m > 0.0).then(|| micrometres((layout.pattern().width_m() - 2.0 * inset_m).max(0.0))),
            spots_formula: match layout.pattern().planform() {
                _ if laser.is_mask() => NO_SPOTS.to_owned(),
                Planform::Disc => format!("{SPOTS_FORMULA}; a disc counts as the square around it"),
                Planform::Polygon => format!("{SPOTS_FORMULA}; a polygon counts as the rectangle around it"),
                Planform::Crosshatch => {
                    format!("{SPOTS_FORMULA}; crossings count in both grooves, though they are cut once")
                }
                Planform::Groove | Planform::Square | Planform::Rectangle => SPOTS_FORMULA.to_owned(),
            },
            ..Self::default()
        };
        (sheet.spots_per_cavity, sheet.spots_on_specimen) = spots(layout, laser).unzip();
        let hatch = hatched(layout, laser);
        if let Some(hatch) = &hatch {
            sheet.mark(layout, laser, hatch);
        }
        sheet.estimated_time_s = time_s(layout, laser, hatch.as_ref());
        sheet.estimate(laser);
        sheet
    }

    /// Fills in lines, overlaps and passes of `hatch`.
    fn mark(&mut self, layout: &Layout, laser: &Laser, hatch: &LayoutHatch) {
        (self.lines_on_specimen, self.marked_length_mm) = (Some(hatch.lines), Some(marked_length_mm(hatch)));
        self.spot_compensation_um = hatch.cavity.as_ref().and_then(CavityHatch::spot_compensation_m).map(micrometres);
        self.marking_direction = Some(
            if layout.pattern().planform() == Planform::Crosshatch {
                "along the grooves, first one family and then the other, whose lines end at the walls of the first, so \
                 that crossings are marked once and no ridge stays at their mouths: depth there is even within a fifth for lines at most \
                 half a spot apart; every second line backwards"
            } else {
                "along the longer side of a cavity, along x where both are alike; every second line backwards, with its pieces where a hole or a groove cuts it"
            }
            .to_owned(),
        );
        let overlap =
            |distance_um: Option<f64>| distance_um.zip(laser.spot_um).map(|(d, spot)| six_digits(1.0 - d / spot));
        self.line_distance_um = laser.line_distance_um();
        let [least_um, greatest_um] = [0, 1].map(|end| hatch.apart_m.map(|apart_m| micrometres(apart_m[end])));
        (self.least_line_distance_um, self.greatest_line_distance_um) = (least_um, greatest_um);
        self.line_distance_formula = Some(LINES_FORMULA.to_owned());
        self.line_overlap = overlap(greatest_um);
        if self.bursts_per_cavity.is_some() {
            self.exposures_of_a_point = hatch.cavity.as_ref().map(|cavity| six_digits(cavity.exposures()));
            self.exposures_of_a_point_formula = self.exposures_of_a_point.map(|_| EXPOSURES_FORMULA.to_owned());
        }
        self.pulse_distance_um = laser.pulse_distance_um().map(six_digits);
        self.pulse_overlap = overlap(laser.pulse_distance_um());
        self.bursts_per_pass = laser.bursts_per_pass().map(six_digits);
        self.bursts_per_pass_formula = self.bursts_per_pass.map(|_| BURSTS_FORMULA.to_owned());
        self.removal = hatch.removal(layout, laser);
        if let Some(passes) = self.removal.as_ref().map(|removal| removal.passes) {
            self.removed_volume_mm3 = hatch.volume_m3(laser, passes).map(|volume_m3| six_digits(volume_m3 * 1e9));
            self.depths_across_um = hatch.cavity.as_ref().and_then(|cavity| cavity.across_um(laser, passes));
            self.depths_across_formula = self.depths_across_um.as_ref().map(|_| ACROSS_FORMULA.to_owned());
            self.removal_formula = Some(REMOVAL_FORMULA.to_owned());
        }
    }

    /// Says how the marking time is estimated, or why it is not.
    fn estimate(&mut self, laser: &Laser) {
        let missing = laser.missing_for_time();
        self.no_estimate_because = (!missing.is_empty()).then(|| format!("not given: {}", missing.join(", ")));
        let (formula, assumptions) = if self.removal.is_some() {
            (LINE_TIME_FORMULA, LINE_TIME_ASSUMPTIONS)
        } else if laser.is_mask() {
            (MASK_TIME_FORMULA, MASK_TIME_ASSUMPTIONS)
        } else {
            (SPOT_TIME_FORMULA, SPOT_TIME_ASSUMPTIONS)
        };
        self.estimated_time_formula = formula.to_owned();
        self.estimated_time_assumptions = assumptions.to_owned();
    }
}

/// Number of spots along a length, ceil(length / spot), with a rounding tolerance of one part in a million of a spot.
pub(crate) fn spots_along(length_m: f64, spot_um: f64) -> u64 {
    // Lengths are finite and positive; the cast saturates.
    (length_m * 1e6 / spot_um - 1e-6).ceil().max(1.0) as u64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::{Outline, laser_warnings};

    #[test]
    fn bursts_make_the_depth_of_the_design_and_exposures_of_a_point_are_told() {
        let laser = Laser { spot_um: Some(23.0), depth_per_burst_um: Some(2.6), ..Laser::default() };
        let sheet = |width_um: f64, laser: &Laser| {
            let pattern = Pattern::new(Planform::Groove, width_um * 1e-6, 98.7e-6, 15.6e-6).unwrap();
            let layout = Layout::new(pattern, Outline::Disc { diameter_m: 4e-3 }).unwrap();
            let sheet = WorkSheet::new(&layout, laser);
            assert!(laser_warnings(&layout, laser).is_empty() || sheet.removal.is_some());
            sheet
        };
        // Three lines 14.3 um apart in 46.2 um: the middle one exposes every point of 15.4 um, each other one a third.
        // Two lines 11.4 um apart expose every point.
        for (width_um, exposures) in [(46.2, 1.6375), (46.0, 1.645), (24.0, 2.0), (23.0, 2.0)] {
            let sheet = sheet(width_um, &laser);
            assert_eq!((sheet.bursts_per_cavity, sheet.depth_of_bursts_um), (Some(6), Some(15.6)));
            assert!((sheet.exposures_of_a_point.unwrap() - exposures).abs() < 5e-3, "{width_um}");
        }
        // Passes over lines, a mask, and no depth per burst.
        for other in [
            Laser { repetition_hz: Some(1000.0), speed_mm_s: Some(18.064), ..laser },
            Laser { exposure: Some(Exposure::Mask), ..laser },
            Laser { depth_per_burst_um: None, ..laser },
        ] {
            assert_eq!(sheet(46.2, &other).exposures_of_a_point, None, "{other:?}");
        }
    }

    #[test]
    fn exposures_far_from_the_border_jump_as_those_of_a_specimen_do() {
        let spots =
            Laser { spot_um: Some(23.0), repetition_hz: Some(1e3), depth_per_burst_um: Some(0.3), ..Laser::default() };
        let lines = Laser { speed_mm_s: Some(9.0), hatch_um: Some(15.0), ..spots };
        let mask = Laser { exposure: Some(Exposure::Mask), ..spots };
        let all = [Planform::Square, Planform::Disc, Planform::Groove, Planform::Crosshatch];
        for (laser, planforms, jumps) in [(spots, &all[..], true), (lines, &all, true), (mask, &all[..2], false)] {
            for &planform in planforms {
                let (mut before, mut most, mut most_of_time) = (None, 0.0_f64, 0.0_f64);
                for step in 0..300 {
                    let width_m = 40e-6 + 0.37e-6 * f64::from(step);
                    let pattern = Pattern::new(planform, width_m, 150e-6, 5e-6).unwrap();
                    let layout = Layout::new(pattern, Outline::Disc { diameter_m: 6e-3 }).unwrap();
                    let (depth_um, time_s_m2) = one_exposure(&pattern, &laser).unwrap();
                    assert_eq!(laser.depth_step_um(&pattern), Some(depth_um));
                    let each_s = exposure_time_s(&layout, &laser).unwrap();
                    let exposures = (5.0 / depth_um).round();
                    assert!((laser_time_s(&layout, &laser).unwrap() / (exposures * each_s) - 1.0).abs() < 1e-5);
                    let time = (each_s / layout.cavity_area_m2()).ln();
                    let smooth = time - time_s_m2.unwrap().ln();
                    if let Some((time_before, smooth_before)) = before.replace((time, smooth)) {
                        let (of_time, of_smooth): (f64, f64) = (time - time_before, smooth - smooth_before);
                        (most_of_time, most) = (most_of_time.max(of_time.abs()), most.max(of_smooth.abs()));
                    }
                }
                assert!(most < 0.01, "{planform:?} {laser:?}: {most}");
                assert_eq!(most_of_time > 0.06, jumps, "{planform:?} {laser:?}: {most_of_time}");
            }
        }
    }
}
