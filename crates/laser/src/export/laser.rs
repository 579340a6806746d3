//! Laser parameters of a design, and the limits of the laser.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use slipgrid_model::pattern::{ManufacturingLimits, Pattern};

use crate::export::removal::CavityHatch;
use crate::export::{Ablation, ExportError, all_positive, six_digits};

/// Method by which the laser exposes a cavity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Exposure {
    /// The spot fills the cavity line by line.
    #[default]
    Hatch,
    /// A mask has the shape of the cavity, so that the laser needs only its contour.
    Mask,
}

/// Laser parameters as given in the design; absent ones are omitted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Laser {
    /// Wavelength, in nm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wavelength_nm: Option<f64>,
    /// Diameter of the spot, in um.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spot_um: Option<f64>,
    /// Pulse duration, in ns.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pulse_ns: Option<f64>,
    /// Power density, in GW/cm^2.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub power_density_gw_cm2: Option<f64>,
    /// Depth that one burst removes, in um.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth_per_burst_um: Option<f64>,
    /// Bursts per second, in Hz.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub repetition_hz: Option<f64>,
    /// Speed of the spot along a line, in mm/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed_mm_s: Option<f64>,
    /// Distance between lines, in um; the diameter of the spot where absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hatch_um: Option<f64>,
    /// Angle of walls from vertical, in degrees; cavities narrow downwards.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wall_taper_deg: Option<f64>,
    /// Hatch or mask; hatch where absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exposure: Option<Exposure>,
    /// Minimum gap between two cavities, in um.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min_land_um: Option<f64>,
    /// Fitted depth per burst against fluence, if it was fitted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ablation: Option<Ablation>,
}

/// Maximum wall taper, in degrees: walls with a larger taper meet at a very small depth.
const MAX_TAPER_DEG: f64 = 80.0;

/// Maximum number of lines within a spot. More make no floor more even, and take hours to lay.
const MAX_LINES_PER_SPOT: f64 = 1000.0;

/// Tolerance of a depth against a multiple of the depth step, in um. Depths are printed to a hundredth of a micrometre.
const STEP_TOLERANCE_UM: f64 = 0.005 + 1e-9;

impl Laser {
    /// Checks each parameter, and that the distances of lines and of pulses do not exceed the spot.
    ///
    /// # Errors
    /// [`ExportError::BeyondLaser`] if lines are farther apart than the spot is wide or nearer than a thousandth of it;
    /// [`ExportError::PulsesApart`] if pulses are farther apart; [`ExportError::Refused`] for other numbers out of range.
    pub fn validate(&self) -> Result<(), ExportError> {
        all_positive([
            ("wavelength_nm", self.wavelength_nm),
            ("spot_um", self.spot_um),
            ("pulse_ns", self.pulse_ns),
            ("power_density_gw_cm2", self.power_density_gw_cm2),
            ("depth_per_burst_um", self.depth_per_burst_um),
            ("repetition_hz", self.repetition_hz),
            ("speed_mm_s", self.speed_mm_s),
            ("hatch_um", self.hatch_um),
            ("min_land_um", self.min_land_um),
        ])?;
        if let Some(taper_deg) = self.wall_taper_deg
            && !(0.0..=MAX_TAPER_DEG).contains(&taper_deg)
        {
            let expected = format!("0 to {MAX_TAPER_DEG} degrees from upright");
            return Err(ExportError::out_of_range("wall_taper_deg", taper_deg, &expected));
        }
        let Some(spot_um) = self.spot_um else { return Ok(()) };
        let least_um = spot_um / MAX_LINES_PER_SPOT;
        let beyond = |value_um, relation, limit, limit_um| {
            Err(ExportError::BeyondLaser { what: "hatch_um", value_um, relation, limit, limit_um })
        };
        // Rounding tolerance of one part in a million.
        match (self.hatch_um, self.pulse_distance_um()) {
            (Some(um), _) if um < least_um => beyond(um, "below", "a thousandth of spot_um", least_um),
            (Some(um), _) if um > spot_um * (1.0 + 1e-6) => beyond(um, "above", "spot_um", spot_um),
            (_, Some(pulse_um)) if pulse_um > spot_um * (1.0 + 1e-6) => Err(ExportError::PulsesApart {
                pulse_um,
                speed_mm_s: self.speed_mm_s.unwrap_or_default(),
                repetition_hz: self.repetition_hz.unwrap_or_default(),
                spot_um,
            }),
            _ => Ok(()),
        }
    }

    /// Checks that `pattern` is not too fine for the laser; the error names the limit.
    ///
    /// # Errors
    /// [`ExportError::BeyondLaser`] for a pattern that is too fine; errors of [`Laser::validate`].
    pub fn check(&self, pattern: &Pattern) -> Result<(), ExportError> {
        self.validate()?;
        let extent_um = pattern.least_extent_m() * 1e6;
        let below = |what, value_um: f64, limit, limit_um: f64| {
            // Rounding tolerance of one part in a million.
            if value_um < limit_um * (1.0 - 1e-6) {
                Err(ExportError::BeyondLaser { what, value_um, relation: "below", limit, limit_um })
            } else {
                Ok(())
            }
        };
        if let Some(spot_um) = self.spot_um {
            below("smallest extent of a cavity", extent_um, "spot_um", spot_um)?;
        }
        if let Some(land_um) = self.min_land_um {
            below("land between cavities", pattern.least_land_m() * 1e6, "min_land_um", land_um)?;
        }
        if self.floor_inset_m(pattern.depth_m()) > 0.0 {
            let walls_um = 2e6 * self.floor_inset_m(pattern.depth_m());
            below("smallest extent of a cavity", extent_um, "what two walls of wall_taper_deg take", walls_um)?;
        }
        Ok(())
    }

    /// Whether a mask exposes each cavity as a whole.
    pub fn is_mask(&self) -> bool {
        self.exposure == Some(Exposure::Mask)
    }

    /// Names of the missing parameters without which the marking time cannot be estimated. A mask needs no spot.
    pub fn missing_for_time(&self) -> Vec<&'static str> {
        let spot_um = ("spot_um", self.spot_um.is_some() || self.is_mask());
        let depth_per_burst_um = ("depth_per_burst_um", self.depth_per_burst_um.is_some());
        let given = [spot_um, depth_per_burst_um, ("repetition_hz", self.repetition_hz.is_some())];
        given.into_iter().filter_map(|(name, is_given)| (!is_given).then_some(name)).collect()
    }

    /// Mean number of bursts that reach a point in one pass over an infinite hatch. `None` for a mask, and if spot,
    /// speed or repetition rate are missing: depth then comes from bursts on spots, not from passes.
    pub fn bursts_per_pass(&self) -> Option<f64> {
        let spot_um = self.spot_um.filter(|_| !self.is_mask())?;
        // n = (pi / 4) s^2 / (p h)
        Some(std::f64::consts::FRAC_PI_4 * spot_um * spot_um / (self.pulse_distance_um()? * self.line_distance_um()?))
    }

    /// Depth of one pass over an infinite hatch, in um; `None` if bursts give the depth, and without a depth per burst.
    pub(crate) fn infinite_pass_um(&self) -> Option<f64> {
        Some(self.depth_per_burst_um? * self.bursts_per_pass()?)
    }

    /// Depth of the smallest exposure of cavities of `pattern`, in um: what one pass over their lines removes in their
    /// middle if passes give the depth, otherwise one burst. Depths of designs are multiples of this step, which depends
    /// on width because lines are spread evenly over it. `None` without a depth per burst.
    pub fn depth_step_um(&self, pattern: &Pattern) -> Option<f64> {
        let Some(infinite_um) = self.infinite_pass_um() else { return self.depth_per_burst_um };
        CavityHatch::of_pattern(pattern, self).map_or(Some(infinite_um), |cavity| cavity.per_pass_um(self))
    }

    /// Whether passes over lines give the depth.
    pub fn has_passes(&self) -> bool {
        self.infinite_pass_um().is_some()
    }

    /// What a depth is counted in: passes over lines, or bursts on spots.
    pub fn exposures_name(&self) -> &'static str {
        if self.has_passes() { "passes" } else { "bursts" }
    }

    /// Relative standard error of the depth per burst; `None` unless the depth was fitted against fluence.
    pub fn depth_per_burst_std(&self) -> Option<f64> {
        let std = self.ablation.map(|law| law.depth_per_burst_stderr_um / law.depth_per_burst_um);
        std.filter(|std| *std > 0.0)
    }

    /// Checks that the depth of `pattern` is a multiple of the depth of a pass or burst, within 0.005 um.
    ///
    /// # Errors
    /// [`ExportError::Refused`] for any other depth.
    pub fn check_depth(&self, pattern: &Pattern) -> Result<(), ExportError> {
        let Some(step_um) = self.depth_step_um(pattern) else { return Ok(()) };
        let depth_um = pattern.depth_m() * 1e6;
        let steps = (depth_um / step_um).round().max(1.0);
        if (depth_um - steps * step_um).abs() <= STEP_TOLERANCE_UM {
            return Ok(());
        }
        let of = self.exposures_name();
        Err(ExportError::Refused(format!(
            "the depth of {} um is no whole number of {of} of {} um: expected for instance {} um",
            six_digits(depth_um),
            six_digits(step_um),
            six_digits(steps * step_um)
        )))
    }

    /// Number of bursts per spot for a depth of `depth_m`, at least one; `None` without a depth per burst, and if
    /// passes over lines give the depth.
    pub fn bursts(&self, depth_m: f64) -> Option<u32> {
        if self.bursts_per_pass().is_some() {
            return None;
        }
        let depth_per_burst_m = self.depth_per_burst_um.map(|depth_um| depth_um * 1e-6);
        ManufacturingLimits { depth_per_burst_m, ..Default::default() }.bursts(depth_m)
    }

    /// Distance between pulses along a line, in um; `None` without speed or repetition rate.
    pub fn pulse_distance_um(&self) -> Option<f64> {
        // p = v / f
        self.speed_mm_s.zip(self.repetition_hz).map(|(speed_mm_s, repetition_hz)| speed_mm_s * 1e3 / repetition_hz)
    }

    /// Nominal distance between lines, in um: the hatch, or the spot if no hatch is given; `None` without both.
    pub fn line_distance_um(&self) -> Option<f64> {
        self.hatch_um.or(self.spot_um)
    }

    /// Horizontal distance from the edge of a cavity of `depth_m` to the edge of its floor, in metres.
    pub fn floor_inset_m(&self, depth_m: f64) -> f64 {
        depth_m * self.slope()
    }

    /// Tangent of the wall taper: horizontal extent of a wall divided by its height; 0 for vertical walls.
    pub fn slope(&self) -> f64 {
        self.wall_taper_deg.map_or(0.0, |taper_deg| libm::tan(taper_deg.to_radians()))
    }
}
