//! Laser and specimen tables of design files.

use std::ops::Range;

use schemars::JsonSchema;
use serde::Deserialize;
use slipgrid_laser::export::{Ablation, AblationPoint, ExportError, Exposure, Laser, Specimen, SpecimenRecord};
use slipgrid_model::pattern::{Pattern, Texture};

use super::values::{Number, NumberList, column};
use crate::formats::plausible::SPOT;
use crate::formats::{Diagnostic, Document, Spanned};
use slipgrid_base::statistics::extremes;
use slipgrid_base::units::{LENGTH_MM, LENGTH_UM, POSITIVE, WALL_TAPER_DEG, significant, significant_to, tidy};

/// The table `[laser]` of a design file.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LaserFile {
    /// Wavelength, for the process sheet.
    wavelength_nm: Option<Number>,
    /// Diameter of the spot, the lower limit of a cavity's width.
    pub(crate) spot_um: Option<Number>,
    /// Duration of a pulse, for the process sheet.
    pulse_ns: Option<Number>,
    /// Power density, for the process sheet.
    power_density_gw_cm2: Option<Number>,
    /// Repetition rate of pulses.
    repetition_hz: Option<Number>,
    /// Speed of the spot; with the repetition rate it determines pulses, overlap, passes and time on the process sheet.
    speed_mm_s: Option<Number>,
    /// Distance between marked lines; the spot diameter when absent.
    hatch_um: Option<Number>,
    /// Inclination of the cavity walls from the vertical; 0 when absent.
    pub(crate) wall_taper_deg: Option<Number>,
    /// `hatch` marks lines inside each contour, `mask` exposes whole contours, one with each burst; `hatch` when
    /// absent.
    #[schemars(with = "Option<String>")]
    exposure: Option<Exposure>,
    /// Fluence used for cutting, at which `[laser.ablation]` gives the depth per burst.
    fluence_j_cm2: Option<Number>,
    /// Depths per burst d measured at fluences F, to which d = delta ln(F / F_th) with the threshold F_th is fitted, in
    /// place of `limits.depth_per_burst_um`.
    ablation: Option<Spanned<AblationFile>>,
}

/// Depths per burst against fluence.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct AblationFile {
    /// Fluences of the measurements, three or more.
    fluence_j_cm2: NumberList,
    /// Measured depths per burst.
    depth_per_burst_um: NumberList,
    /// Standard errors of `depth_per_burst_um`.
    depth_std_um: Option<NumberList>,
}

/// Reads the laser; `limits` are the values of `depth_per_burst_um` and `min_land_um` in `[limits]`.
///
/// # Errors
/// [`Diagnostic`] if numbers are out of range, if lines or pulses lie farther apart than the spot is wide, if no
/// ablation law fits the measurements, or if a fluence stands without them or lies below their threshold.
pub fn read_laser(
    document: &Document,
    file: Option<&Spanned<LaserFile>>,
    limits: (&Option<Number>, &Option<Number>),
) -> Result<Laser, Diagnostic> {
    let copied = |value: Option<&Number>| document.optional(value, POSITIVE);
    // Lengths stay in the units of the file, because only solvers take metres.
    let length = |value: Option<&Number>| {
        document.optional(value, LENGTH_UM)?;
        copied(value)
    };
    let of_limits = Laser {
        depth_per_burst_um: length(limits.0.as_ref())?,
        min_land_um: length(limits.1.as_ref())?,
        ..Laser::default()
    };
    let Some(table) = file else { return Ok(of_limits) };
    let file = table.get_ref();
    let spot_um = length(file.spot_um.as_ref())?;
    if let Some(spot) = &file.spot_um
        && let Err(expected) = SPOT.judge(*spot.get_ref())
    {
        return Err(document.refuse(spot.span(), "is the spot of no laser").expected(expected));
    }
    let laser = Laser {
        wavelength_nm: copied(file.wavelength_nm.as_ref())?,
        spot_um,
        pulse_ns: copied(file.pulse_ns.as_ref())?,
        power_density_gw_cm2: copied(file.power_density_gw_cm2.as_ref())?,
        repetition_hz: copied(file.repetition_hz.as_ref())?,
        speed_mm_s: copied(file.speed_mm_s.as_ref())?,
        hatch_um: length(file.hatch_um.as_ref())?,
        wall_taper_deg: document.optional(file.wall_taper_deg.as_ref(), WALL_TAPER_DEG)?,
        exposure: file.exposure,
        ..of_limits
    };
    let laser = with_ablation(document, laser, table, limits.0.as_ref())?;
    laser.validate().map_err(|error| unlike_spot(document, table, &error))?;
    Ok(laser)
}

/// Diagnostic for `error` of the laser. If lines or pulses lie farther apart than the spot is wide, the diagnostic
/// refers to the number that is most probably wrong.
fn unlike_spot(document: &Document, table: &Spanned<LaserFile>, error: &ExportError) -> Diagnostic {
    let file = table.get_ref();
    match (error, &file.hatch_um, &file.speed_mm_s) {
        (ExportError::BeyondLaser { relation: "below", limit_um, .. }, Some(hatch), _) => document
            .refuse(hatch.span(), "lays more than a thousand lines within a spot")
            .expected(format!("at least {} um", significant(*limit_um, 4))),
        (ExportError::BeyondLaser { limit_um, .. }, Some(hatch), _) => document
            .refuse(hatch.span(), format!("is more than the spot is wide, spot_um = {limit_um}: lines would not meet"))
            .expected(format!("at most {limit_um} um")),
        (&ExportError::PulsesApart { pulse_um, speed_mm_s, repetition_hz, spot_um }, _, Some(speed)) => {
            // Rounded to a value at which the limits still hold.
            let least_hz = significant_to(repetition_hz * pulse_um / spot_um * (1.0 - EXACT), 3, f64::ceil);
            let most_mm_s = significant_to(speed_mm_s * spot_um / pulse_um * (1.0 + EXACT), 3, f64::floor);
            let apart = format!("pulses {} um apart on a spot of {spot_um} um", significant(pulse_um, 4));
            document
                .refuse(speed.span(), format!("mm/s at repetition_hz = {repetition_hz} sets {apart}"))
                .expected(format!("repetition_hz of at least {least_hz}, or speed_mm_s of at most {most_mm_s}"))
        }
        _ => document.refuse(table.span(), error.to_string()),
    }
}

/// Relative tolerance for rounding errors of a limit that a message states.
const EXACT: f64 = 1e-9;

/// Fits the ablation law of `[laser.ablation]`, if given, and returns the laser with the depth per burst at the fluence
/// used.
fn with_ablation(
    document: &Document,
    laser: Laser,
    laser_table: &Spanned<LaserFile>,
    depth_per_burst: Option<&Number>,
) -> Result<Laser, Diagnostic> {
    let file = laser_table.get_ref();
    let fluence_j_cm2 = document.optional(file.fluence_j_cm2.as_ref(), POSITIVE)?;
    let Some(table) = &file.ablation else {
        let Some(fluence) = &file.fluence_j_cm2 else { return Ok(laser) };
        let refused = document.refuse(fluence.span(), "J/cm2 gives no depth without [laser.ablation]");
        return Err(refused.expected("measured depths in [laser.ablation], or depth_per_burst_um in [limits] alone"));
    };
    if let Some(depth) = depth_per_burst {
        return Err(document
            .refuse(depth.span(), "is given beside laser.ablation, which gives it too")
            .expected("either depth_per_burst_um or [laser.ablation]"));
    }
    let fluence_j_cm2 = fluence_j_cm2.ok_or_else(|| document.missing(laser_table.span(), "fluence_j_cm2"))?;
    let given = table.get_ref();
    let fluences = document.numbers(&given.fluence_j_cm2, POSITIVE)?;
    let column = |list: &NumberList| column(document, list, POSITIVE, fluences.len(), "fluence");
    let depths = column(&given.depth_per_burst_um)?;
    let deviations = given.depth_std_um.as_ref().map(column).transpose()?;
    let point = |place: usize| AblationPoint {
        fluence_j_cm2: fluences[place],
        depth_um: depths[place],
        depth_std_um: deviations.as_ref().map(|all| all[place]),
    };
    let points: Vec<AblationPoint> = (0..fluences.len()).map(point).collect();
    let law = Ablation::fit(&points, fluence_j_cm2).map_err(|error| {
        // If the law holds at the highest measured fluence, the fluence used lies below its threshold.
        let [_, highest] = extremes(fluences.iter().copied());
        match (Ablation::fit(&points, highest), &file.fluence_j_cm2) {
            (Ok(law), Some(used)) => document
                .refuse(used.span(), "J/cm2 removes nothing by [laser.ablation]")
                .expected(format!("more than the fitted threshold, {} J/cm2", law.threshold_j_cm2)),
            _ => document.refuse(given.fluence_j_cm2.span(), error.to_string()),
        }
    })?;
    Ok(Laser { depth_per_burst_um: Some(law.depth_per_burst_um), ablation: Some(law), ..laser })
}

/// Warns if the fluence used lies outside the fluences at which depths were measured; `None` otherwise.
pub(crate) fn unmeasured_fluence(
    document: &Document,
    file: Option<&Spanned<LaserFile>>,
    laser: &Laser,
) -> Option<Diagnostic> {
    let (file, law) = (file?.get_ref(), laser.ablation?);
    let (used, table) = (file.fluence_j_cm2.as_ref()?, file.ablation.as_ref()?);
    // Values that are not numbers have been refused before.
    let fluences = document.numbers(&table.get_ref().fluence_j_cm2, POSITIVE).ok()?;
    let [least, most] = extremes(fluences);
    (law.fluence_j_cm2 < least || law.fluence_j_cm2 > most).then(|| {
        let reason = format!(
            "J/cm2 lies outside the fluences at which depths were measured, {} to {} J/cm2: the depth per burst, {} um, is extrapolated along the law",
            tidy(least),
            tidy(most),
            significant(law.depth_per_burst_um, 3)
        );
        document.refuse(used.span(), reason)
    })
}

/// Reads the specimen of a design or a scene.
///
/// # Errors
/// [`Diagnostic`] if the shape is unknown, or if a length is missing, superfluous or impossible.
pub fn read_specimen(document: &Document, file: &Spanned<SpecimenRecord>) -> Result<Specimen, Diagnostic> {
    file.get_ref().specimen().map_err(|error| document.refuse_key(&file.span(), &error))
}

/// Refuses a specimen on which the smallest cavity within the bounds does not fit, or on which even the largest
/// cavities at the largest spacing are too many. The bounds of width, spacing and depth are in metres.
///
/// # Errors
/// [`Diagnostic`] at the width, whose file position is `width_um`, or at the specimen.
pub fn check_fits(
    document: &Document,
    (table, width_um): (&Spanned<SpecimenRecord>, Range<usize>),
    outline: &Specimen,
    texture: &Texture,
    (width_m, spacing_m, depth_m): ([f64; 2], [f64; 2], [f64; 2]),
) -> Result<(), Diagnostic> {
    let error_at = |end: usize| {
        // Lengths that the texture does not allow are refused with the bounds.
        let pattern = Pattern::new(*texture, width_m[end], spacing_m[end], depth_m[0]).ok()?;
        outline.check(pattern).err()
    };
    if let Some(ExportError::NoCavityFits { needed_m, extent_m, .. }) = error_at(0) {
        let smallest = if width_m[0] < width_m[1] { "the smallest of these widths" } else { "this width" };
        let extent_mm = significant(LENGTH_MM.from_si(extent_m), 4);
        let needed_mm = significant_to(LENGTH_MM.from_si(needed_m) * (1.0 - EXACT), 3, f64::ceil);
        let reason = format!("cavities of {smallest} do not fit whole on the specimen, whose extent is {extent_mm} mm");
        return Err(document
            .refuse(width_um, reason)
            .expected(format!("narrower cavities, or a specimen with an extent of at least {needed_mm} mm")));
    }
    if let Some(error @ ExportError::NoPeriodFits { .. }) = error_at(0) {
        let refused = document.refuse(table.span(), format!("is too small for any of the bounds: {error}"));
        return Err(refused.expected("a larger specimen, or smaller bounds"));
    }
    match error_at(1) {
        Some(error @ ExportError::TooManyCavities { .. }) => {
            Err(document.refuse(table.span(), error.to_string()).expected("a smaller specimen, or larger bounds"))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_laser::export::Outline;

    #[derive(Debug, Deserialize)]
    struct Written {
        laser: Option<Spanned<LaserFile>>,
        specimen: Spanned<SpecimenRecord>,
    }

    fn read(laser: &str, specimen: &str) -> Result<(Laser, Specimen), String> {
        let document = Document::new("a.toml", format!("[laser]\n{laser}\n[specimen]\n{specimen}\n"));
        let written: Written = document.parse().map_err(|refused| refused.to_string())?;
        let laser =
            read_laser(&document, written.laser.as_ref(), (&None, &None)).map_err(|refused| refused.to_string())?;
        Ok((laser, read_specimen(&document, &written.specimen).map_err(|refused| refused.to_string())?))
    }

    #[test]
    fn a_fluence_outside_those_measured_is_told_of() {
        let told = |fluence_j_cm2: &str| {
            let table = ABLATION.replace("fluence_j_cm2 = 4.0", &format!("fluence_j_cm2 = {fluence_j_cm2}"));
            let document = Document::new("a.toml", format!("[laser]\n{table}\n[specimen]\n{DISC}\n"));
            let written: Written = document.parse().unwrap();
            let laser = read_laser(&document, written.laser.as_ref(), (&None, &None)).unwrap();
            unmeasured_fluence(&document, written.laser.as_ref(), &laser).map(|told| told.to_string())
        };
        assert_eq!([told("4.0"), told("8.0")], [None, None]);
        let said = told("9.0").unwrap();
        assert!(
            said.starts_with("a.toml:2: laser.fluence_j_cm2: 9.0 J/cm2 lies outside") && said.contains("1 to 8 J/cm2"),
            "{said}"
        );
        assert!(told("0.7").unwrap().contains("extrapolated"));
    }

    const DISC: &str = "shape = \"disc\"\ndiameter_mm = 10.0";
    const ABLATION: &str = "fluence_j_cm2 = 4.0\nablation = { fluence_j_cm2 = [1.0, 2.0, 4.0, 8.0], depth_per_burst_um = [0.55, 1.11, 1.66, 2.22] }";

    #[test]
    fn depth_per_burst_follows_from_fluence() {
        let (laser, _) = read(ABLATION, DISC).unwrap();
        let law = laser.ablation.unwrap();
        // 0.8 ln(F / 0.5) to two decimals.
        assert!((law.delta_um - 0.8).abs() < 0.005 && (law.threshold_j_cm2 - 0.5).abs() < 0.01);
        assert_eq!(laser.depth_per_burst_um, Some(law.depth_per_burst_um));
    }

    #[test]
    fn specimens_of_every_shape() {
        let ring = "shape = \"ring\"\nouter_diameter_mm = 10.0\ninner_diameter_mm = 4.0";
        let outline = Outline::Ring { outer_diameter_m: 10e-3, inner_diameter_m: 4e-3 };
        assert_eq!(read("", ring).unwrap().1, Specimen { outline, is_clipped: false });
        assert!(read("", &format!("{ring}\ncavities = \"clipped\"")).unwrap().1.is_clipped);
    }
}
