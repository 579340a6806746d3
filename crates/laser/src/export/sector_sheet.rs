//! Process sheet of several patterns on sectors of one specimen, as TOML.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::export::process::sheet_toml;
use crate::export::sectors::wrong_count;
use crate::export::{
    ANGLE_DECIMALS, Division, ExportError, Laser, MAX_SECTORS, MadeBy, MaterialNote, PatternSheet, ProcessInput,
    Removal, Sector, burst_warnings, laser_time_s, millimetres, not_modelled, round_decimals, sector_layer, six_digits,
};

/// Advice for measuring sectors.
pub const MEASURE_EACH_ALONE: &str = "measure each sector alone: with a counter-body or a pin that fits on one sector, or by friction resolved by the \
     angle of a turning disc; a tribometer that presses the whole face measures a mean of all sectors, which is a trial of none";

/// The process sheet of sectors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SectorsSheet {
    /// Name of the design.
    pub name: String,
    /// Program that made the sheet.
    #[serde(flatten)]
    pub made_by: MadeBy,
    /// Seed of the design.
    pub seed: u64,
    /// Advice for measuring sectors.
    pub measuring: String,
    /// Effects that the prediction leaves out.
    pub not_modelled: Vec<String>,
    /// The specimen.
    pub specimen: DividedSheet,
    /// The sectors, in order.
    pub sector: Vec<SectorSheet>,
    /// The laser, as given.
    pub laser: Laser,
    /// The material.
    pub material: MaterialNote,
}

/// A specimen divided into sectors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct DividedSheet {
    /// `disc`, `rectangle` or `ring`.
    pub shape: String,
    /// Extents along x and y, in mm.
    pub extents_mm: [f64; 2],
    /// Diameter of the hole of a ring, in mm.
    pub hole_mm: Option<f64>,
    /// Number of sectors.
    pub sectors: usize,
    /// Width of the untextured lands between sectors, in mm.
    pub land_mm: f64,
    /// Position of the mark.
    pub mark: String,
    /// Treatment of cavities at the border and at lands.
    pub at_the_rim: String,
}

/// One sector with its pattern and the laser work for it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SectorSheet {
    /// Number of the sector, from 1, anticlockwise.
    pub number: usize,
    /// Layer of the sector in the drawing.
    pub layer: String,
    /// Direction of the sector's middle from x, anticlockwise, in degrees.
    pub middle_deg: f64,
    /// Angle by which the pattern is turned with the sector, anticlockwise, in degrees.
    pub turn_deg: f64,
    /// Area of the sector without the untextured lands on its sides, in mm^2.
    pub area_mm2: f64,
    /// Diameter of the largest circle on the sector, in mm; a pin or a counter-body must be smaller.
    pub circle_mm: f64,
    /// Number of cavities; each part of a cut cavity counts.
    pub cavities: usize,
    /// Fraction of the sector that is cavity.
    pub areal_density: f64,
    /// Bursts per cavity (on each of its spots); absent if passes over lines give the depth.
    pub bursts_per_cavity: Option<u32>,
    /// Marking time, in s: that of the pattern on the whole specimen times the sector's fraction of the cavity area.
    pub estimated_time_s: Option<f64>,
    /// Areas of cavities that the spot does not reach, with remedies; empty if passes over lines give the depth.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
    /// Pattern of the sector.
    pub pattern: PatternSheet,
    /// Passes over the lines, and the depth that they remove; absent if bursts on spots or a mask give the depth.
    pub removal: Option<Removal>,
}

impl SectorsSheet {
    /// Creates the sheet for `sectors`.
    ///
    /// # Errors
    /// [`ExportError`] for an invalid laser, and without sectors.
    pub fn new(sectors: &[Sector], input: ProcessInput) -> Result<Self, ExportError> {
        let ProcessInput { name, made_by, seed, laser, material, .. } = input;
        laser.validate()?;
        let division = sectors.first().ok_or_else(|| wrong_count(0, MAX_SECTORS))?.division();
        let has_rim = sectors.iter().any(|of| of.pattern().texture().rim().is_some_and(|rim| rim.stands()));
        Ok(Self {
            name,
            made_by,
            seed,
            measuring: MEASURE_EACH_ALONE.to_owned(),
            not_modelled: not_modelled(has_rim).map(str::to_owned).to_vec(),
            specimen: DividedSheet::new(division),
            sector: sectors.iter().map(|sector| SectorSheet::new(sector, &laser)).collect(),
            laser,
            material: (&material).into(),
        })
    }

    /// Formats the sheet as TOML.
    ///
    /// # Errors
    /// [`ExportError::Refused`] if TOML cannot hold a value.
    pub fn to_toml(&self) -> Result<String, ExportError> {
        let turned = self.sector.iter().any(|sector| sector.turn_deg != 0.0);
        let sliding = if turned {
            "x is the sliding direction of sector 1; turned back by the angle of a sector, the specimen slides along x on it"
        } else {
            "x is the sliding direction"
        };
        sheet_toml(&format!("One specimen in sectors. {sliding}"), self)
    }
}

impl DividedSheet {
    fn new(division: &Division) -> Self {
        let outline = &division.specimen().outline;
        let before_deg = (division.middle_deg(1) - division.angle_deg() / 2.0).rem_euclid(360.0);
        let rim = if division.specimen().is_clipped { "cut at the rim" } else { "whole within the rim" };
        Self {
            shape: outline.name().to_owned(),
            extents_mm: outline.extents_m().map(millimetres),
            hole_mm: Some(outline.hole_m()).filter(|hole_m| *hole_m > 0.0).map(millimetres),
            sectors: division.count(),
            land_mm: millimetres(division.land_m()),
            mark: format!(
                "a bar on the land at {} degrees from x, near the rim; from it anticlockwise, seen on the face, come sectors 1 to {}",
                round_decimals(before_deg, 3),
                division.count()
            ),
            at_the_rim: format!("{rim}; grooves end at the lands, other cavities that reach into one are left out"),
        }
    }
}

impl SectorSheet {
    fn new(sector: &Sector, laser: &Laser) -> Self {
        let (number, division, pattern) = (sector.number(), sector.division(), sector.pattern());
        let share = sector.cavity_area_m2() / sector.whole().cavity_area_m2();
        Self {
            number,
            layer: sector_layer(number),
            middle_deg: round_decimals(division.middle_deg(number), ANGLE_DECIMALS),
            turn_deg: round_decimals(division.turn_deg(number), ANGLE_DECIMALS),
            area_mm2: six_digits(division.area_m2(number) * 1e6),
            circle_mm: six_digits(division.circle_m(number) * 1e3),
            cavities: sector.cavities(),
            areal_density: six_digits(sector.areal_density()),
            bursts_per_cavity: laser.bursts(pattern.depth_m()),
            estimated_time_s: laser_time_s(sector.whole(), laser).map(|time_s| six_digits(share * time_s)),
            pattern: PatternSheet::from(pattern),
            warnings: burst_warnings(sector.whole(), laser),
            removal: Removal::new(sector.whole(), laser),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::{Outline, Specimen, process};
    use slipgrid_model::pattern::{Pattern, Planform};

    #[test]
    fn every_sector_has_its_depth_and_its_bursts() {
        let specimen = Specimen { outline: Outline::Disc { diameter_m: 10e-3 }, is_clipped: true };
        let patterns = [(100e-6, 300e-6, 10.4e-6), (150e-6, 250e-6, 5.2e-6)]
            .map(|(width_m, spacing_m, depth_m)| Pattern::new(Planform::Groove, width_m, spacing_m, depth_m).unwrap());
        let sectors = Division::new(specimen, 2).unwrap().lay(&patterns).unwrap();
        let laser =
            Laser { spot_um: Some(25.0), depth_per_burst_um: Some(2.6), repetition_hz: Some(1e4), ..Laser::default() };
        let input = ProcessInput { laser, ..process::tests::input(None) };
        let sheet = SectorsSheet::new(&sectors, input).unwrap();
        let text = sheet.to_toml().unwrap();
        let body = text.split_once('\n').unwrap().1;
        assert_eq!(toml::from_str::<SectorsSheet>(body).unwrap(), sheet);
        assert!(sheet.measuring.contains("a mean of all sectors"));
        let bursts: Vec<_> = sheet.sector.iter().map(|of| (of.bursts_per_cavity, of.layer.as_str())).collect();
        assert_eq!(bursts, [(Some(4), "CAVITIES_1"), (Some(2), "CAVITIES_2")]);
        // Half a disc without half a land of 0.5 mm, with grooves over a quarter and three eighths of it.
        let area_mm2 = (std::f64::consts::PI * 25.0 / 2.0) - 0.25 * 10.0;
        for (of, density) in sheet.sector.iter().zip([0.25, 0.375]) {
            assert!((of.area_mm2 / area_mm2 - 1.0).abs() < 1e-3, "{}", of.area_mm2);
            assert!((of.areal_density / density - 1.0).abs() < 0.03, "{}", of.areal_density);
            assert!(of.estimated_time_s.is_some_and(|time_s| time_s > 0.0) && (of.circle_mm - 4.75).abs() < 1e-9);
        }
    }
}
