//! Reads the parts of a design file.

use std::ops::Range;
use std::path::PathBuf;

use slipgrid_design::KnownMaterial;
use slipgrid_laser::export::Laser;
use slipgrid_model::material::ConditionRange;
use slipgrid_model::pattern::{Arrangement, ManufacturingLimits, Pattern, Texture};

use super::DesignFile;
use crate::formats::file_kind::FileKind;
use crate::formats::material::{MaterialFile, existing, read_referenced};
use crate::formats::plausible::SPOT;
use crate::formats::target::{ConditionRangeFile, read_conditions};
use crate::formats::values::PathOr;
use crate::formats::{Diagnostic, Document, Spanned};
use slipgrid_base::units::{LENGTH_UM, significant, significant_to};
use toml::value::Datetime;

/// Reads the conditions with their file positions: first `condition`, then those of `also_at`.
pub(super) fn read_ranges(
    document: &Document,
    file: &DesignFile,
) -> Result<Vec<(ConditionRange, Range<usize>)>, Diagnostic> {
    if let (None, Some(also_at)) = (&file.condition, &file.also_at) {
        return Err(document
            .refuse(also_at.span(), "stands without the condition that is designed for")
            .expected("condition = { speed_mm_s = ..., humidity_pct = ... } beside it"));
    }
    let further = file.also_at.iter().flat_map(Spanned::get_ref);
    let read = |range: &Spanned<ConditionRangeFile>| Ok((read_conditions(document, range.get_ref())?, range.span()));
    file.condition.iter().chain(further).map(read).collect()
}

/// Number of intervals of the widths within the bounds, at whose ends a whole number of passes is sought.
const WIDTHS: u32 = 100;

/// Width, spacing and depth bounds, in metres.
type Bounds = ([f64; 2], [f64; 2], [f64; 2]);

/// Depth of one burst, in metres, of which depths are multiples; `None` if unknown, and if passes give the depth.
fn burst_m(laser: &Laser) -> Option<f64> {
    laser.depth_per_burst_um.filter(|_| !laser.has_passes()).map(|depth_um| LENGTH_UM.to_si(depth_um))
}

/// Replaces a fixed depth, given by two equal bounds in metres, by the nearest depth of whole bursts if the two depths
/// differ by no more than the rounding of printed depths, 0.01 um. Other bounds are unchanged.
pub(super) fn whole_bursts(depth_m: [f64; 2], laser: &Laser) -> [f64; 2] {
    const PRINTED_M: f64 = 0.01e-6;
    let Some(step_m) = burst_m(laser) else { return depth_m };
    let whole_m = (depth_m[0] / step_m).round().max(1.0) * step_m;
    let is_printed = depth_m[0] == depth_m[1] && (whole_m - depth_m[0]).abs() <= PRINTED_M;
    if is_printed { [whole_m; 2] } else { depth_m }
}

pub(super) fn read_limits(
    document: &Document,
    file: &DesignFile,
    laser: &Laser,
    asked: &Texture,
    (width_m, spacing_m, depth_m): Bounds,
) -> Result<ManufacturingLimits, Diagnostic> {
    let limits = ManufacturingLimits {
        min_land_m: document.optional(file.limits.min_land_um.as_ref(), LENGTH_UM)?,
        spot_m: laser.spot_um.map(|spot_um| LENGTH_UM.to_si(spot_um)),
        // Given or fitted against fluence.
        depth_per_burst_m: burst_m(laser),
        wall_slope: laser.wall_taper_deg.map(|_| laser.slope()),
    };
    let bounds = file.bounds.get_ref();
    let none_left = |place: Range<usize>, below: &str, least: &str, least_m: f64| {
        let refused = document.refuse(place, format!("{below}: no pattern is left"));
        refused.expected(format!("{least} {} um", significant(LENGTH_UM.from_si(least_m), 6)))
    };
    let of_pattern = |key: &str| document.value_span(&file.pattern.span(), key);
    if let Some(least_m) = limits.min_land_m.filter(|least_m| spacing_m[1] < *least_m) {
        let spacing = bounds.spacing_um.span();
        return Err(none_left(spacing, "ends below limits.min_land_um", "a largest spacing of at least", least_m));
    }
    if let Some(spot_m) = limits.spot_m.filter(|spot_m| width_m[1] < *spot_m) {
        let [spot_um, most_um] = [spot_m, width_m[1]].map(|length_m| significant(LENGTH_UM.from_si(length_m), 6));
        if let Some(spot) = file.laser.as_ref().and_then(|laser| laser.get_ref().spot_um.as_ref())
            && let Some(slip) = SPOT.within([1.0, most_um]).slip(spot_um)
        {
            let reason = format!("is wider than the widest cavity within the bounds, {most_um} um");
            return Err(document.refuse(spot.span(), reason).expected(format!("at most {most_um} um; {slip}")));
        }
        let width = bounds.width_um.span();
        return Err(none_left(width, "ends below the laser's spot", "a largest width of at least", spot_m));
    }
    if let Some((spot_m, _)) = limits.spot_m.zip(asked.length_m()).filter(|(spot_m, length_m)| length_m < spot_m) {
        return Err(none_left(of_pattern("length_um"), "is below the laser's spot", "at least", spot_m));
    }
    let across_m = asked.spacing_across_m().filter(|_| asked.arrangement() == Arrangement::Square);
    if let Some((least_m, _)) = limits.min_land_m.zip(across_m).filter(|(least_m, across_m)| across_m < least_m) {
        let across = of_pattern("spacing_across_um");
        return Err(none_left(across, "is below limits.min_land_um", "at least", least_m));
    }
    // Smallest whole number of bursts, or of passes over the lines in some width, at or above the minimum depth, with a
    // tolerance for decimals.
    let whole_m = |step_m: f64| (depth_m[0] / step_m - 1e-6).ceil().max(1.0) * step_m;
    let pass_m = |share: u32| {
        let width_m = width_m[0] + f64::from(share) / f64::from(WIDTHS) * (width_m[1] - width_m[0]);
        let pattern = Pattern::new(*asked, width_m, spacing_m[1], depth_m[0]).ok()?;
        laser.depth_step_um(&pattern).map(|step_um| LENGTH_UM.to_si(step_um))
    };
    let (of, least_m) = if laser.has_passes() && depth_m[0] < depth_m[1] {
        ("passes", (0..=WIDTHS).filter_map(pass_m).map(whole_m).reduce(f64::min))
    } else {
        ("bursts", limits.depth_per_burst_m.map(whole_m))
    };
    if let Some(least_m) = least_m.filter(|least_m| *least_m > depth_m[1] * (1.0 + 1e-6)) {
        let refused = document.refuse(bounds.depth_um.span(), format!("holds no whole number of {of}"));
        let least_um = significant(LENGTH_UM.from_si(least_m), 6);
        return Err(refused.expected(format!("a largest depth of at least {least_um} um")));
    }
    // The widest cavities at minimum depth.
    let widest = Pattern::new(*asked, width_m[1], spacing_m[1], depth_m[0]).ok();
    let taper = file.laser.as_ref().and_then(|laser| laser.get_ref().wall_taper_deg.as_ref());
    if let (Some(pattern), Some(taper)) = (widest, taper)
        && limits.walls_meet(&pattern)
    {
        let extent_m = pattern.least_extent_m();
        // tan(taper) = w / 2d
        let most_deg = significant_to((extent_m / (2.0 * depth_m[0])).atan().to_degrees(), 3, f64::floor);
        let (extent_um, depth_um) = (LENGTH_UM.from_si(extent_m), LENGTH_UM.from_si(depth_m[0]));
        let reason = format!(
            "lets walls meet above the floor of every cavity within the bounds: the widest is {} um wide, the shallowest {} um deep",
            significant(extent_um, 4),
            significant(depth_um, 4)
        );
        return Err(document
            .refuse(taper.span(), reason)
            .expected(format!("at most {most_deg} degrees, or wider or shallower cavities")));
    }
    Ok(limits)
}

/// Reads the material of a design. Returns the material, or, if `material` names a calibration, `None` and the path of
/// the calibration. Appends warnings of unusual values to `told`.
pub(super) fn read_material_input(
    document: &Document,
    material: &Spanned<PathOr<MaterialFile>>,
    told: &mut Vec<Diagnostic>,
) -> Result<(Option<KnownMaterial>, Option<PathBuf>), Diagnostic> {
    if let PathOr::Path(path) = material.get_ref() {
        let path = existing(document, material, path)?;
        let named = Document::read_any(document.source(), &path, FileKind::Material)?;
        if named.kind() == Some(FileKind::Calibration) {
            return Ok((None, Some(path)));
        }
    }
    let (known, of_material) = read_referenced(document, material)?;
    told.extend(of_material);
    Ok((Some(known), None))
}

/// Reads a calendar date: four digits, two and two, with hyphens between.
pub(super) fn read_date(document: &Document, date: &Spanned<String>) -> Result<String, Diagnostic> {
    let text = date.get_ref();
    match text.parse() {
        Ok(Datetime { date: Some(_), time: None, offset: None }) => Ok(text.clone()),
        _ => Err(document.refuse(date.span(), "is no day").expected("a day as \"YYYY-MM-DD\", such as \"2026-11-22\"")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_depth_as_it_is_printed_is_a_whole_number_of_bursts() {
        let laser = Laser { depth_per_burst_um: Some(5.890_486_225_48), ..Laser::default() };
        let of = |from_um: f64, to_um: f64| whole_bursts([from_um * 1e-6, to_um * 1e-6], &laser);
        assert_eq!(of(11.78, 11.78), [2.0 * LENGTH_UM.to_si(5.890_486_225_48); 2]);
        // Neither a range nor a value that rounding to printed digits explains.
        for [from_um, to_um] in [[11.6, 11.6], [11.78, 12.0]] {
            assert_eq!(of(from_um, to_um), [from_um * 1e-6, to_um * 1e-6]);
        }
        assert_eq!(whole_bursts([11.6e-6; 2], &Laser::default()), [11.6e-6; 2]);
    }

    #[test]
    fn a_day_is_one_of_the_calendar() {
        let is_day = |day: &str| read_date(&Document::new("a.toml", ""), &day.to_owned().into()).is_ok();
        for day in ["2026-11-22", "2024-02-29", "2000-02-29", "2026-12-31"] {
            assert!(is_day(day), "{day}");
        }
        for none in [
            "2026-02-29",
            "1900-02-29",
            "2026-13-01",
            "2026-00-10",
            "2026-04-31",
            "2026-1-1",
            "22.11.2026",
            "+026-01-01",
            "",
        ] {
            assert!(!is_day(none), "{none}");
        }
    }
}
