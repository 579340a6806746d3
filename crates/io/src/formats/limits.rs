//! Constraints of a design in addition to its bounds, `[limits]`, and the scatter of manufactured samples, `[tolerances]`.

use schemars::JsonSchema;
use serde::Deserialize;
use slipgrid_design::optimize::{ConstraintQuantity, Limit, Tolerances};
use slipgrid_laser::export::Laser;

use super::values::{Number, Numbers, list, number_span};
use crate::formats::{Diagnostic, Document, Spanned};
use slipgrid_base::key_error::KeyError;
use slipgrid_base::units::{
    CORRELATION, FRACTION, LENGTH_STD_UM, LENGTH_UM, PRESSURE_MPA, RIM_HEIGHT_UM, TIME_S, in_digits,
};

/// The table `[limits]` of a design file.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LimitsFile {
    /// Smallest gap between two cavities.
    pub min_land_um: Option<Number>,
    /// Depth that one burst removes, measured in a cavity with the hatch of the design: where lines overlap, a burst on
    /// each spot removes more than a single spot shows. Cavity depths are whole multiples of this depth. If `[laser]`
    /// has a spot, a speed and a repetition rate, the key is the depth of a single spot, and cavity depths are whole
    /// multiples of the depth that one pass over the lines of a cavity removes in its middle. A fixed depth is kept; the
    /// process sheet tells the speed that makes it.
    pub depth_per_burst_um: Option<Number>,
    /// Maximum pressure on a contact block at the block size of `[sample]`, at every target pressure: in the steady
    /// cell of every design, and in the confirming run of the specimen, whose outer lands may bear a higher pressure.
    /// If a design breaks the limit in that run, the search is repeated with the pressures of cells increased by the
    /// same factor.
    max_peak_pressure_mpa: Option<Number>,
    /// Minimum fraction of the face that is land, not cavity.
    min_bearing_area: Option<Number>,
    /// Maximum fraction of the face that is cavity.
    max_areal_density: Option<Number>,
    /// Maximum time under the laser, as the process sheet estimates it; needs repetition rate, depth per burst and,
    /// except with `exposure = "mask"`, the spot.
    max_laser_time_s: Option<Number>,
    /// Minimum gap left under the ceiling of a cavity at every target pressure.
    min_clearance_um: Option<Number>,
    /// `refuse` rejects designs in which a contact block is under tension in the steady model of the infinite pattern;
    /// `tension_blocks` of the result counts those of the confirming run.
    liftoff: Option<Liftoff>,
}

/// What happens to designs in which a contact block is under tension.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
enum Liftoff {
    Refuse,
    Allow,
}

impl LimitsFile {
    /// Refuses a nominal pressure of the target at which every design, the flat surface included, breaks
    /// `max_peak_pressure_mpa`.
    ///
    /// # Errors
    /// [`Diagnostic`] at the first pressure that is not below the limit.
    pub fn check_peak(&self, document: &Document, pressures: &Spanned<Numbers>) -> Result<(), Diagnostic> {
        let Some(limit) = &self.max_peak_pressure_mpa else { return Ok(()) };
        let (read, limit_mpa) = (list(document, pressures, PRESSURE_MPA)?, *limit.get_ref());
        document.number(limit, PRESSURE_MPA)?;
        let Some(place) = read.iter().position(|pressure_pa| PRESSURE_MPA.from_si(*pressure_pa) >= limit_mpa) else {
            return Ok(());
        };
        let limit_mpa = in_digits(limit_mpa);
        let line = document.refuse(limit.span(), "").line.map_or_else(String::new, |line| format!(" in line {line}"));
        let reason = format!(
            "MPa is not below limits.max_peak_pressure_mpa = {limit_mpa}{line}: the largest pressure on a block is never below the nominal \
             pressure, so that no design keeps the limit"
        );
        Err(document
            .refuse(number_span(pressures, place), reason)
            .expected(format!("pressures below {limit_mpa} MPa, or a higher max_peak_pressure_mpa")))
    }
}

/// Reads the limited quantities with their limits.
///
/// # Errors
/// [`Diagnostic`] if a number is out of range, or if the time under the laser is limited but cannot be estimated.
pub fn read_limited(document: &Document, file: &LimitsFile, laser: &Laser) -> Result<Vec<Limit>, Diagnostic> {
    let read = |given: &Option<Number>, quantity| document.optional(given.as_ref(), quantity);
    let limits = [
        (ConstraintQuantity::PeakPressure, read(&file.max_peak_pressure_mpa, PRESSURE_MPA)?),
        (ConstraintQuantity::BearingArea, read(&file.min_bearing_area, FRACTION)?),
        (ConstraintQuantity::ArealDensity, read(&file.max_areal_density, FRACTION)?),
        (ConstraintQuantity::LaserTime, read(&file.max_laser_time_s, TIME_S)?),
        (ConstraintQuantity::Clearance, read(&file.min_clearance_um, LENGTH_UM.or_zero())?),
        (ConstraintQuantity::LeastPressure, file.liftoff.filter(|of| *of == Liftoff::Refuse).map(|_| 0.0)),
    ];
    let missing = missing_for_time(laser);
    if let Some(limit) = file.max_laser_time_s.as_ref().filter(|_| !missing.is_empty()) {
        let refused = document.refuse(limit.span(), "limits a time that cannot be estimated");
        return Err(refused.expected(format!("{} beside it", missing.join(", "))));
    }
    Ok(limits.into_iter().filter_map(|(quantity, limit)| Some(quantity.limited_to(limit?))).collect())
}

/// Names of the missing keys without which the time under the laser cannot be estimated.
pub(super) fn missing_for_time(laser: &Laser) -> Vec<&'static str> {
    let key = |name| match name {
        "spot_um" => "laser.spot_um",
        "repetition_hz" => "laser.repetition_hz",
        _ => "limits.depth_per_burst_um or laser.ablation",
    };
    laser.missing_for_time().into_iter().map(key).collect()
}

/// Checks the numbers of `[tolerances]`.
///
/// `largest_m` holds the largest width, spacing and depth within the bounds, in metres.
///
/// # Errors
/// [`Diagnostic`] if numbers are out of range, or if a dimension scatters by more than its largest value within the
/// bounds.
pub fn check_tolerances(
    document: &Document,
    table: &Spanned<Tolerances>,
    largest_m: [f64; 3],
) -> Result<(), Diagnostic> {
    let refuse = |error: KeyError| document.refuse_key(&table.span(), &error);
    let given = table.get_ref();
    // Random dimensions are drawn from a normal distribution, and a draw that is not positive is repeated: Phi(-1) = 16
    // % of draws if the standard deviation equals the dimension. With larger scatter more draws are repeated, and the
    // remaining cells are many times as large as any within the bounds.
    let stds = [
        ("width_std_um", given.width_std_um, "width"),
        ("spacing_std_um", given.spacing_std_um, "spacing"),
        ("depth_std_um", given.depth_std_um, "depth"),
    ];
    for ((key, std_um, name), largest_m) in stds.into_iter().zip(largest_m) {
        if KeyError::number(key, std_um, LENGTH_STD_UM).map_err(refuse)? > largest_m {
            let reason = format!(
                "is more than the largest {name} within the bounds: of any design, more than one sample in six would be drawn with no {name} \
                 at all"
            );
            return Err(refuse(KeyError::rule(key, reason, format!("at most {} um", LENGTH_UM.from_si(largest_m)))));
        }
    }
    KeyError::number("width_spacing_correlation", given.width_spacing_correlation, CORRELATION).map_err(refuse)?;
    KeyError::number("rim_height_std_um", given.rim_height_std_um, RIM_HEIGHT_UM).map_err(refuse)?;
    Ok(())
}
