//! The process sheet: what the person at the laser needs to know, as TOML.

use serde::{Deserialize, Serialize};
use slipgrid_pattern::{Arrangement, ManufacturingLimits, Pattern, Planform};

use crate::error::positive;
use crate::number::{DERIVED_DIGITS, MICROMETRE_DECIMALS, micrometres, millimetres, round_decimals, round_digits};
use crate::words::{ANGLE_DECIMALS, groove_direction, lattice};
use crate::{ExportError, Layout, Outline};

/// What no model of slipgrid contains; it stands on every process sheet.
pub const NOT_MODELLED: [&str; 5] = [
    "recast rims: lasering raises a rim around each cavity and roughens the surface",
    "plasticity",
    "viscoelasticity",
    "heating",
    "wear",
];

const SPOTS_FORMULA: &str = "ceil(cavity width / spot) * ceil(cavity length / spot): spots edge to edge, the spot taken as a square of that side; \
     overlap, which a round spot needs for an even floor, adds to it";
const TIME_FORMULA: &str = "spots_on_specimen * bursts_per_cavity / repetition_hz";
const TIME_ASSUMPTIONS: &str = "one burst per spot and repetition; movement between spots and cavities not counted";

/// Laser parameters as the design gives them; absent ones are left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
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
}

/// Permitted departures of the made cavities, plus or minus; absent ones are left out.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tolerances {
    /// Of the width, in um.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub width_um: Option<f64>,
    /// Of the spacing, in um.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spacing_um: Option<f64>,
    /// Of the depth, in um.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth_um: Option<f64>,
    /// Where the numbers come from, in words.
    pub basis: String,
}

/// The material and where its numbers come from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MaterialNote {
    /// Name.
    pub name: String,
    /// Source of the measurements.
    pub source: String,
    /// The altitude map behind the area law is synthetic, not measured.
    pub synthetic_surface: bool,
}

/// What goes onto a process sheet beside the layout.
#[derive(Clone, Debug, PartialEq)]
pub struct ProcessInput {
    /// Name of the design.
    pub name: String,
    /// Version of the program that made the design.
    pub version: String,
    /// Seed of the design.
    pub seed: u64,
    /// The laser.
    pub laser: Laser,
    /// Tolerances, where there are any.
    pub tolerances: Option<Tolerances>,
    /// The material.
    pub material: MaterialNote,
}

/// The process sheet. Lengths are rounded to one nanometre, derived numbers to six digits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProcessSheet {
    /// Name of the design.
    pub name: String,
    /// Program that made the sheet.
    pub program: String,
    /// Its version.
    pub version: String,
    /// Seed of the design.
    pub seed: u64,
    /// What the prediction leaves out.
    pub not_modelled: Vec<String>,
    /// The pattern.
    pub pattern: PatternSheet,
    /// Tolerances, where there are any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tolerances: Option<Tolerances>,
    /// The specimen and the cavities on it.
    pub specimen: SpecimenSheet,
    /// The laser, as given.
    pub laser: Laser,
    /// What follows for the work.
    pub work: WorkSheet,
    /// The material.
    pub material: MaterialNote,
}

/// Dimensions of the pattern.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PatternSheet {
    /// `groove`, `square`, `rectangle` or `disc`.
    pub planform: String,
    /// Width of a cavity along a row, in um; of a disc its diameter. Rows run along the sliding
    /// direction unless an angle says otherwise.
    pub width_um: f64,
    /// Gap between the cavities of a row, in um.
    pub spacing_um: f64,
    /// Period of a row, width + spacing, in um.
    pub pitch_um: f64,
    /// Length of a rectangle across the rows, in um.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub length_um: Option<f64>,
    /// Gap between rows, in um, where rows are not a pitch apart.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spacing_across_um: Option<f64>,
    /// Distance of rows, in um, where it is not the pitch.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pitch_across_um: Option<f64>,
    /// `staggered`, where rows are.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub arrangement: Option<String>,
    /// Grooves turned on the specimen from lying across x, anticlockwise, in degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angle_deg: Option<f64>,
    /// Sliding direction turned from x, anticlockwise, in degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sliding_angle_deg: Option<f64>,
    /// Depth, in um.
    pub depth_um: f64,
    /// Share of an unbounded surface that is cavity.
    pub areal_density: f64,
}

/// The specimen and the cavities on it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpecimenSheet {
    /// `disc` or `rectangle`.
    pub shape: String,
    /// Diameter of a disc, in mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub diameter_mm: Option<f64>,
    /// Length of a rectangle along x, in mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub length_mm: Option<f64>,
    /// Width of a rectangle along y, in mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub width_mm: Option<f64>,
    /// How cavities are arranged, in words.
    pub arrangement: String,
    /// Number of cavities.
    pub cavities: usize,
    /// Share of the specimen's face that is cavity.
    pub areal_density: f64,
    /// Area of all cavities, in mm^2.
    pub cavity_area_mm2: f64,
    /// Volume of all cavities, in mm^3.
    pub cavity_volume_mm3: f64,
}

/// Bursts, spots and time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WorkSheet {
    /// Bursts per cavity (on each of its spots): depth over depth per burst, to the nearest whole.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bursts_per_cavity: Option<u32>,
    /// Depth that those bursts give, in um.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth_of_bursts_um: Option<f64>,
    /// Spots that tile a cavity; of grooves on a disc the longest.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spots_per_cavity: Option<u64>,
    /// Spots that tile all cavities.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spots_on_specimen: Option<u64>,
    /// How spots are counted.
    pub spots_formula: String,
    /// Time under the laser, in s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub estimated_time_s: Option<f64>,
    /// Why there is no estimate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub no_estimate_because: Option<String>,
    /// How time is estimated.
    pub estimated_time_formula: String,
    /// What the estimate takes for granted.
    pub estimated_time_assumptions: String,
}

impl From<&Pattern> for PatternSheet {
    fn from(pattern: &Pattern) -> Self {
        let texture = pattern.texture();
        let given = |angle_deg: f64| Some(round_decimals(angle_deg, ANGLE_DECIMALS)).filter(|_| angle_deg != 0.0);
        let apart_m = pattern.pitch_across_m().filter(|&pitch_m| pitch_m != pattern.pitch_m());
        Self {
            planform: pattern.planform().name().to_owned(),
            width_um: micrometres(pattern.width_m()),
            spacing_um: micrometres(pattern.spacing_m()),
            pitch_um: micrometres(pattern.pitch_m()),
            length_um: texture.length_m().map(micrometres),
            spacing_across_um: apart_m.and(pattern.spacing_across_m()).map(micrometres),
            pitch_across_um: apart_m.map(micrometres),
            arrangement: (texture.arrangement() != Arrangement::Square)
                .then(|| texture.arrangement().name().to_owned()),
            angle_deg: given(texture.orientation_deg()),
            sliding_angle_deg: given(texture.sliding_angle_deg()),
            depth_um: micrometres(pattern.depth_m()),
            areal_density: round_digits(pattern.areal_density(), DERIVED_DIGITS),
        }
    }
}

impl ProcessSheet {
    /// The sheet of `layout`.
    ///
    /// # Errors
    /// [`ExportError::NotPositive`] if a laser parameter or tolerance that is given is not a
    /// positive number.
    pub fn new(layout: &Layout, input: ProcessInput) -> Result<Self, ExportError> {
        let ProcessInput { name, version, seed, laser, tolerances, material } = input;
        laser.validate()?;
        if let Some(tolerances) = &tolerances {
            tolerances.validate()?;
        }
        let pattern = layout.pattern();
        let (diameter_m, length_m, width_m) = match *layout.outline() {
            Outline::Disc { diameter_m } => (Some(diameter_m), None, None),
            Outline::Rectangle { length_m, width_m } => (None, Some(length_m), Some(width_m)),
        };
        Ok(Self {
            name,
            program: "slipgrid".to_owned(),
            version,
            seed,
            not_modelled: NOT_MODELLED.map(str::to_owned).to_vec(),
            pattern: PatternSheet::from(pattern),
            tolerances,
            specimen: SpecimenSheet {
                shape: layout.outline().name().to_owned(),
                diameter_mm: diameter_m.map(millimetres),
                length_mm: length_m.map(millimetres),
                width_mm: width_m.map(millimetres),
                arrangement: arrangement(pattern),
                cavities: layout.cavities(),
                areal_density: round_digits(layout.areal_density(), DERIVED_DIGITS),
                cavity_area_mm2: round_digits(layout.cavity_area_m2() * 1e6, DERIVED_DIGITS),
                cavity_volume_mm3: round_digits(layout.cavity_volume_m3() * 1e9, DERIVED_DIGITS),
            },
            laser,
            work: WorkSheet::new(layout, &laser),
            material,
        })
    }

    /// The sheet as TOML text.
    ///
    /// # Errors
    /// [`ExportError::Unwritable`] if TOML cannot hold a value.
    pub fn to_toml(&self) -> Result<String, ExportError> {
        let body = toml::to_string(self).map_err(|error| ExportError::Unwritable { reason: error.to_string() })?;
        let sliding = match self.pattern.sliding_angle_deg {
            None => "x is the sliding direction".to_owned(),
            Some(angle_deg) => format!("The sliding direction lies {angle_deg} degrees from x, anticlockwise"),
        };
        Ok(format!("# Process sheet. {sliding}; units stand in the keys.\n{body}"))
    }
}

impl Laser {
    fn validate(&self) -> Result<(), ExportError> {
        given([
            ("wavelength_nm", self.wavelength_nm),
            ("spot_um", self.spot_um),
            ("pulse_ns", self.pulse_ns),
            ("power_density_gw_cm2", self.power_density_gw_cm2),
            ("depth_per_burst_um", self.depth_per_burst_um),
            ("repetition_hz", self.repetition_hz),
        ])
    }

    /// Bursts for a depth of `depth_m`, at least one; `None` without a depth per burst.
    #[must_use]
    pub fn bursts(&self, depth_m: f64) -> Option<u32> {
        let depth_per_burst_m = self.depth_per_burst_um.map(|depth_um| depth_um * 1e-6);
        ManufacturingLimits { depth_per_burst_m, ..Default::default() }.bursts(depth_m)
    }
}

impl Tolerances {
    fn validate(&self) -> Result<(), ExportError> {
        given([
            ("tolerance width_um", self.width_um),
            ("tolerance spacing_um", self.spacing_um),
            ("tolerance depth_um", self.depth_um),
        ])
    }
}

/// Checks that the numbers which are given are positive.
fn given<const N: usize>(numbers: [(&'static str, Option<f64>); N]) -> Result<(), ExportError> {
    for (quantity, value) in numbers {
        if let Some(value) = value {
            positive(quantity, value)?;
        }
    }
    Ok(())
}

fn arrangement(pattern: &Pattern) -> String {
    match pattern.planform() {
        Planform::Groove => format!(
            "grooves {}, one through the centre, each as long as fits whole on the specimen",
            groove_direction(pattern.texture())
        ),
        _ => format!("{}, one cavity on the centre, only whole cavities", lattice(pattern)),
    }
}

impl WorkSheet {
    fn new(layout: &Layout, laser: &Laser) -> Self {
        let bursts = laser.bursts(layout.pattern().depth_m());
        let spots = laser.spot_um.map(|spot_um| {
            layout.iter().fold((0, 0), |(longest, sum), cavity| {
                let spots = spots_along(cavity.width_m, spot_um) * spots_along(cavity.length_m, spot_um);
                (spots.max(longest), sum + spots)
            })
        });
        let missing: Vec<&str> = [
            ("spot_um", laser.spot_um),
            ("depth_per_burst_um", laser.depth_per_burst_um),
            ("repetition_hz", laser.repetition_hz),
        ]
        .into_iter()
        .filter_map(|(name, value)| value.is_none().then_some(name))
        .collect();
        let estimated_time_s = match (spots, bursts, laser.repetition_hz) {
            // t = N_spots n_bursts / f
            (Some((_, spots)), Some(bursts), Some(repetition_hz)) => {
                Some(round_digits(spots as f64 * f64::from(bursts) / repetition_hz, DERIVED_DIGITS))
            }
            _ => None,
        };
        Self {
            bursts_per_cavity: bursts,
            depth_of_bursts_um: bursts
                .zip(laser.depth_per_burst_um)
                .map(|(bursts, depth_um)| round_decimals(f64::from(bursts) * depth_um, MICROMETRE_DECIMALS)),
            spots_per_cavity: spots.map(|(longest, _)| longest),
            spots_on_specimen: spots.map(|(_, sum)| sum),
            spots_formula: match layout.pattern().planform() {
                Planform::Disc => format!("{SPOTS_FORMULA}; a disc counts as the square around it"),
                _ => SPOTS_FORMULA.to_owned(),
            },
            estimated_time_s,
            no_estimate_because: (!missing.is_empty()).then(|| format!("not given: {}", missing.join(", "))),
            estimated_time_formula: TIME_FORMULA.to_owned(),
            estimated_time_assumptions: TIME_ASSUMPTIONS.to_owned(),
        }
    }
}

/// ceil(length / spot), one part in a million of a spot forgiven as rounding.
fn spots_along(length_m: f64, spot_um: f64) -> u64 {
    // Lengths are finite and positive; the cast saturates.
    (length_m * 1e6 / spot_um - 1e-6).ceil().max(1.0) as u64
}

#[cfg(test)]
mod tests;
