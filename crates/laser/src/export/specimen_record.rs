//! A specimen as keys of a file: one definition for files that are read and for records that are written.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use slipgrid_base::key_error::{KeyError, Refusal};
use slipgrid_base::units::LENGTH_MM;

use super::{AT_THE_RIM, Outline, Specimen};

/// Names of the shapes of a face in files.
const SHAPES: [&str; 3] = ["disc", "rectangle", "ring"];
/// Keys of the lengths of each shape, for messages.
const LENGTHS: &str = "diameter_mm for a disc, length_mm and width_mm for a rectangle, outer_diameter_mm and inner_diameter_mm for a ring";

/// Shape and size of a specimen, and treatment of cavities at its rim, as keys of a file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpecimenRecord {
    /// Shape of the face: `disc`, `rectangle` or `ring`.
    pub shape: String,
    /// Diameter of a disc.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub diameter_mm: Option<f64>,
    /// Length of a rectangle along x, the sliding direction unless `sliding_angle_deg` turns it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub length_mm: Option<f64>,
    /// Width of a rectangle along y, across the sliding direction unless `sliding_angle_deg` turns it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub width_mm: Option<f64>,
    /// Outer diameter of a ring.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub outer_diameter_mm: Option<f64>,
    /// Diameter of a ring's hole.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inner_diameter_mm: Option<f64>,
    /// Cavities that cross the rim of the specimen: `whole` leaves them out, `clipped` cuts them; `whole` when absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cavities: Option<String>,
}

impl From<&Specimen> for SpecimenRecord {
    fn from(specimen: &Specimen) -> Self {
        let millimetres = |length_m: f64| Some(LENGTH_MM.from_si(length_m));
        let named = Self {
            shape: specimen.outline.name().to_owned(),
            cavities: specimen.is_clipped.then(|| AT_THE_RIM[1].to_owned()),
            ..Self::default()
        };
        match specimen.outline {
            Outline::Disc { diameter_m } => Self { diameter_mm: millimetres(diameter_m), ..named },
            Outline::Rectangle { length_m, width_m } => {
                Self { length_mm: millimetres(length_m), width_mm: millimetres(width_m), ..named }
            }
            Outline::Ring { outer_diameter_m, inner_diameter_m } => Self {
                outer_diameter_mm: millimetres(outer_diameter_m),
                inner_diameter_mm: millimetres(inner_diameter_m),
                ..named
            },
        }
    }
}

impl SpecimenRecord {
    /// Converts the keys to a specimen in SI units.
    ///
    /// # Errors
    /// [`KeyError`] if a name is unknown, or if a length is missing, superfluous or impossible.
    pub fn specimen(&self) -> Result<Specimen, KeyError> {
        let shape = KeyError::choice("shape", &self.shape, &SHAPES, |name| name)?;
        let lengths = [
            ("diameter_mm", self.diameter_mm, "disc"),
            ("length_mm", self.length_mm, "rectangle"),
            ("width_mm", self.width_mm, "rectangle"),
            ("outer_diameter_mm", self.outer_diameter_mm, "ring"),
            ("inner_diameter_mm", self.inner_diameter_mm, "ring"),
        ];
        if let Some((key, ..)) = lengths.iter().find(|(_, length, of)| length.is_some() && *of != shape) {
            return Err(KeyError::rule(key, format!("has no meaning for a {shape}"), LENGTHS));
        }
        let needed = |place: usize| {
            let (key, length_mm, _) = lengths[place];
            let length_mm = length_mm.ok_or(KeyError { key, refusal: Refusal::Missing })?;
            KeyError::number(key, length_mm, LENGTH_MM)
        };
        let outline = match shape {
            "disc" => Outline::Disc { diameter_m: needed(0)? },
            "rectangle" => Outline::Rectangle { length_m: needed(1)?, width_m: needed(2)? },
            _ => {
                let (outer_diameter_m, inner_diameter_m) = (needed(3)?, needed(4)?);
                if inner_diameter_m >= outer_diameter_m {
                    let expected = "less than outer_diameter_mm";
                    return Err(KeyError::rule("inner_diameter_mm", "leaves nothing of the ring", expected));
                }
                Outline::Ring { outer_diameter_m, inner_diameter_m }
            }
        };
        let at_the_rim = self.cavities.as_ref();
        let at_the_rim =
            at_the_rim.map(|name| KeyError::choice("cavities", name, &AT_THE_RIM, |name| name)).transpose()?;
        Ok(Specimen { outline, is_clipped: at_the_rim == Some(AT_THE_RIM[1]) })
    }
}
