//! Depth of bursts where the lines of the spot overlap.
//!
//! Without a speed, n bursts of the depth d are planned per spot, which remove n d if each spot is exposed separately,
//! edge to edge. Lines inside a cavity are spaced evenly from edge to edge, closer than the spot is wide:
//!
//! ```text
//! E = <lines within s/2>        exposures of a point, s the spot: the mean over the middle third of a cavity
//! z = n d E                     depth there, bursts edge to edge along lines
//! ```

use crate::export::number::{MICROMETRE_DECIMALS, decimal, round_decimals};
use crate::export::removal::{Hatched, WARNED_DEVIATION};
use crate::export::{Laser, Layout, Marking, Removal};

/// Depth of bursts on overlapping lines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Overlap {
    /// Mean number of exposures of a point in the middle of a cavity.
    pub(crate) exposures: f64,
    /// Resulting depth of the planned bursts, in um.
    pub(crate) depth_um: f64,
    line_distance_um: f64,
    spot_um: f64,
    bursts: u32,
    burst_um: f64,
    design_um: f64,
}

impl Overlap {
    /// Computes the overlap of bursts on spots; `None` if passes over lines give the depth, if a mask exposes whole
    /// cavities, and if lines overlap by less than the difference in depth that causes a warning.
    pub(crate) fn from_hatch(layout: &Layout, laser: &Laser, hatched: &Hatched) -> Option<Self> {
        let design_m = layout.pattern().depth_m();
        let (bursts, burst_um) = laser.bursts(design_m).zip(laser.depth_per_burst_um)?;
        let (spot_um, apart_m) = laser.spot_um.filter(|_| !laser.is_mask()).zip(hatched.one_apart_m)?;
        let line_distance_um = apart_m * 1e6;
        let exposures = hatched.exposures()?;
        (exposures > 1.0 + WARNED_DEVIATION).then(|| Self {
            exposures,
            depth_um: round_decimals(f64::from(bursts) * burst_um * exposures, MICROMETRE_DECIMALS),
            line_distance_um,
            spot_um,
            bursts,
            burst_um,
            design_um: design_m * 1e6,
        })
    }

    /// Warning with the resulting depth and a remedy.
    pub(crate) fn warning(&self) -> String {
        let plural = |bursts: u32| if bursts == 1 { "1 burst".to_owned() } else { format!("{bursts} bursts") };
        let makes = |bursts: u32| if bursts == 1 { "makes" } else { "make" };
        let each_um = self.burst_um * self.exposures;
        // Fewer than the planned bursts, so that the cast cannot overflow.
        let nearest = (self.design_um / each_um).round().max(1.0) as u32;
        let fewer = if nearest < self.bursts {
            let come = if nearest == 1 { "comes" } else { "come" };
            let depth = decimal(f64::from(nearest) * each_um, 1);
            format!("{} on each {come} nearest to it, with {depth} um", plural(nearest))
        } else {
            "a lower fluence makes bursts finer".to_owned()
        };
        format!(
            "{} on each spot {} {} um, not the design's {} um: {fewer}; where the spot follows lines, bursts edge to edge, a point in the \
             middle is exposed {} times, as lines lie {} um apart in a cavity and the spot is {} um wide; speed_mm_s and repetition_hz in \
             [laser] let the sheet plan passes; depth_of_bursts_um holds where each spot is burnt by itself or a mask exposes whole cavities",
            plural(self.bursts),
            makes(self.bursts),
            decimal(self.depth_um, 1),
            decimal(self.design_um, 1),
            decimal(self.exposures, 2),
            decimal(self.line_distance_um, 1),
            decimal(self.spot_um, 1)
        )
    }
}

/// Warnings about cavities of `layout` that are made by bursts on spots: where lines overlap, and where the spot does
/// not fit. Empty if passes over lines give the depth, for which [`Removal`] has warnings.
#[must_use]
pub fn burst_warnings(layout: &Layout, laser: &Laser) -> Vec<String> {
    if laser.is_mask() || laser.bursts(layout.pattern().depth_m()).is_none() {
        return Vec::new();
    }
    let Ok(marking) = Marking::new(laser) else { return Vec::new() };
    let hatched = Hatched::new(layout, &marking);
    let overlap = Overlap::from_hatch(layout, laser, &hatched);
    hatched.unreached_warnings(layout).into_iter().chain(overlap.iter().map(Overlap::warning)).collect()
}

/// Warnings about cavities of `layout` that deviate from the design, for passes over lines or for bursts on overlapping
/// lines.
#[must_use]
pub fn laser_warnings(layout: &Layout, laser: &Laser) -> Vec<String> {
    Removal::new(layout, laser).map_or_else(|| burst_warnings(layout, laser), |removal| removal.warnings)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::{Exposure, Outline, WorkSheet};
    use slipgrid_model::pattern::{Pattern, Planform};

    const LASER: Laser = Laser { spot_um: Some(23.0), depth_per_burst_um: Some(2.6), ..Laser::UNKNOWN };

    fn grooves(width_um: f64) -> Layout {
        let pattern = Pattern::new(Planform::Groove, width_um * 1e-6, 98.7e-6, 15.6e-6).unwrap();
        Layout::new(pattern, Outline::Disc { diameter_m: 4e-3 }).unwrap()
    }

    #[test]
    fn bursts_on_the_spots_of_overlapping_lines_are_warned_of_with_the_depth_that_they_make() {
        // Three lines 11.6 um apart in 46.2 um: two of them expose every point.
        let sheet = WorkSheet::new(&grooves(46.2), &LASER);
        assert_eq!((sheet.bursts_per_cavity, sheet.depth_of_bursts_um), (Some(6), Some(15.6)));
        let exposures = sheet.exposures_of_a_point.unwrap();
        assert!((exposures - 1.98).abs() < 0.02, "{exposures}");
        assert!((sheet.depth_where_lines_overlap_um.unwrap() - 15.6 * exposures).abs() < 0.01);
        let [warning] = &sheet.warnings[..] else { panic!("{:?}", sheet.warnings) };
        for said in
            ["11.6 um apart", "middle is exposed", "6 bursts on each spot make 3", "3 bursts on each come nearest"]
        {
            assert!(warning.contains(said), "{warning}");
        }
        assert_eq!(laser_warnings(&grooves(46.2), &LASER), sheet.warnings);
        // Two lines 1 um apart: no point is exposed by more than both.
        let narrow = WorkSheet::new(&grooves(24.0), &LASER);
        assert_eq!(narrow.exposures_of_a_point, Some(2.0));
        assert!(narrow.warnings[0].contains("3 bursts on each come nearest"), "{:?}", narrow.warnings);
        // With a speed of one burst per pass over an infinite hatch, passes give nearly the same depth.
        let moving = Laser { repetition_hz: Some(1000.0), speed_mm_s: Some(18.064), ..LASER };
        let sheet = WorkSheet::new(&grooves(46.2), &moving);
        assert_eq!((sheet.exposures_of_a_point, sheet.removal.map(|removal| removal.passes)), (None, Some(3)));
    }

    #[test]
    fn bursts_are_not_warned_of_where_lines_do_not_overlap_or_nothing_is_hatched() {
        // Two lines side by side, one line, a mask, and no depth per burst.
        for (width_um, laser) in [
            (46.0, LASER),
            (23.0, LASER),
            (46.2, Laser { exposure: Some(Exposure::Mask), ..LASER }),
            (46.2, Laser { depth_per_burst_um: None, ..LASER }),
        ] {
            let sheet = WorkSheet::new(&grooves(width_um), &laser);
            assert_eq!((sheet.exposures_of_a_point, sheet.warnings.len()), (None, 0), "{width_um} {laser:?}");
            assert_eq!(laser_warnings(&grooves(width_um), &laser), sheet.warnings);
        }
    }
}
