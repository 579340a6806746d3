//! Record of a specimen in result.json.

use serde::{Deserialize, Serialize};
use slipgrid_laser::export::{AT_THE_RIM, Outline, Specimen};

use slipgrid_base::units::LENGTH_MM;

/// Specimen with its shape and dimensions.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SpecimenReport {
    /// Shape: `disc`, `rectangle` or `ring`.
    pub shape: String,
    /// Diameter of a disc.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub diameter_mm: Option<f64>,
    /// Length of a rectangle along x.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length_mm: Option<f64>,
    /// Width of a rectangle along y.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub width_mm: Option<f64>,
    /// Outer diameter of a ring.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub outer_diameter_mm: Option<f64>,
    /// Diameter of the hole of a ring.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub inner_diameter_mm: Option<f64>,
    /// `clipped` if cavities are clipped at the border; left out if only whole cavities are laid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cavities: Option<String>,
}

impl From<&Specimen> for SpecimenReport {
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

impl SpecimenReport {
    /// Converts the record into a specimen in SI units.
    ///
    /// # Errors
    /// Message with the key that is missing or unknown.
    pub fn specimen(&self) -> Result<Specimen, String> {
        let needed = |value: Option<f64>, key: &str| {
            let value = value.ok_or_else(|| format!("specimen.{key} is missing"))?;
            if LENGTH_MM.accepts(value) {
                Ok(LENGTH_MM.to_si(value))
            } else {
                Err(format!("specimen.{key}: {value} is out of range; expected {LENGTH_MM}"))
            }
        };
        let outline = match self.shape.as_str() {
            "disc" => Outline::Disc { diameter_m: needed(self.diameter_mm, "diameter_mm")? },
            "rectangle" => Outline::Rectangle {
                length_m: needed(self.length_mm, "length_mm")?,
                width_m: needed(self.width_mm, "width_mm")?,
            },
            "ring" => Outline::Ring {
                outer_diameter_m: needed(self.outer_diameter_mm, "outer_diameter_mm")?,
                inner_diameter_m: needed(self.inner_diameter_mm, "inner_diameter_mm")?,
            },
            other => {
                return Err(format!(
                    "specimen.shape: {other:?} is not known; expected \"disc\", \"rectangle\" or \"ring\""
                ));
            }
        };
        let is_clipped = match self.cavities.as_deref() {
            None | Some("whole") => false,
            Some("clipped") => true,
            Some(other) => {
                return Err(format!("specimen.cavities: {other:?} is not known; expected \"whole\" or \"clipped\""));
            }
        };
        Ok(Specimen { outline, is_clipped })
    }
}
