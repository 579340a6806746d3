//! Specimens of a calibration and of its trials: face, rim and thickness.

use slipgrid_calibrate::CutSpecimen;
use slipgrid_export::{Outline, Specimen};
use slipgrid_springblock::MAX_ROWS;
use toml::Spanned;

use super::calibration_file::FaceFile;
use super::document::Document;
use super::laser;
use super::scene::DEFAULT_LAYER;
use super::values::Number;
use crate::diagnostic::Diagnostic;
use crate::plausible::SPECIMEN;
use slipgrid_units::LENGTH_MM;

/// Minimum and maximum thickness of a specimen that a calibration may state, in metres: the height of the layer, and
/// the maximum number of blocks of a solver.
const THICKNESS_M: [f64; 2] = [DEFAULT_LAYER.height_m, MAX_ROWS * DEFAULT_LAYER.block_m];

/// A specimen as stated by a table of a calibration.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StatedSpecimen {
    /// Face, and treatment of cavities at the rim.
    pub(crate) specimen: Specimen,
    /// Thickness, in metres, if given.
    pub(crate) thickness_m: Option<f64>,
}

impl StatedSpecimen {
    /// Reads the specimen of `table`; rim and thickness default to those of `usual`.
    pub(crate) fn read(
        document: &Document,
        table: &Spanned<FaceFile>,
        usual: Option<Self>,
    ) -> Result<Self, Diagnostic> {
        let file = table.get_ref();
        let is_clipped = match (&file.cavities, usual) {
            (None, Some(usual)) => usual.specimen.is_clipped,
            (name, _) => laser::read_is_clipped(document, name.as_ref())?,
        };
        let specimen = Specimen { outline: read_outline(document, table)?, is_clipped };
        let thickness_m = match &file.thickness_mm {
            Some(given) => Some(read_thickness_m(document, given)?),
            None => usual.and_then(|usual| usual.thickness_m),
        };
        Ok(Self { specimen, thickness_m })
    }

    /// Converts to the specimen of a sample that was cut into it.
    pub(crate) fn cut(self) -> CutSpecimen {
        CutSpecimen { face: Some(self.specimen), thickness_m: self.thickness_m }
    }
}

/// Reads a thickness in metres, within [`THICKNESS_M`].
fn read_thickness_m(document: &Document, given: &Number) -> Result<f64, Diagnostic> {
    let thickness_m = document.number(given, LENGTH_MM)?;
    let [least_m, most_m] = THICKNESS_M;
    if (least_m..=most_m).contains(&thickness_m) {
        return Ok(thickness_m);
    }
    let [least_mm, most_mm] = [least_m, most_m].map(|end_m| LENGTH_MM.from_si(end_m));
    Err(document
        .refuse(given.span(), "mm is no thickness that is modelled")
        .expected(format!("a thickness in millimetres, from {least_mm} to {most_mm}")))
}

/// Reads the face of a specimen: a disc by its radius, or one of the shapes of a design's specimen.
fn read_outline(document: &Document, table: &Spanned<FaceFile>) -> Result<Outline, Diagnostic> {
    let file = table.get_ref();
    let others = [
        ("disc", &file.diameter_mm),
        ("rectangle", &file.length_mm),
        ("rectangle", &file.width_mm),
        ("ring", &file.outer_diameter_mm),
        ("ring", &file.inner_diameter_mm),
    ];
    if let Some(radius) = &file.radius_mm {
        let stray = others.iter().find_map(|(_, length)| length.as_ref().map(Spanned::span));
        if let Some(stray) = stray.or(file.shape.as_ref().map(Spanned::span)) {
            return Err(document
                .refuse(stray, "stands beside radius_mm")
                .expected("either radius_mm alone, or a shape with its lengths"));
        }
        return Ok(Outline::Disc { diameter_m: 2.0 * document.number(radius, LENGTH_MM)? });
    }
    // Without a shape key the lengths determine the shape.
    let shape = others.iter().find(|(_, length)| length.is_some()).map(|(shape, _)| *shape);
    let named = shape.map(|shape| Spanned::new(table.span(), shape.to_owned()));
    let shape = file.shape.clone().or(named).ok_or_else(|| {
        document.missing(table.span(), "radius_mm").expected(
            "radius_mm or diameter_mm of a disc, outer_diameter_mm and inner_diameter_mm of a ring, or length_mm and \
             width_mm of a rectangle",
        )
    })?;
    let as_design = laser::SpecimenFile {
        shape,
        diameter_mm: file.diameter_mm.clone(),
        length_mm: file.length_mm.clone(),
        width_mm: file.width_mm.clone(),
        outer_diameter_mm: file.outer_diameter_mm.clone(),
        inner_diameter_mm: file.inner_diameter_mm.clone(),
        cavities: None,
    };
    Ok(laser::read_specimen(document, &Spanned::new(table.span(), as_design))?.outline)
}

/// Area of a face, in square metres.
pub(crate) fn area_m2(outline: &Outline) -> f64 {
    match outline {
        // pi r^2
        Outline::Disc { diameter_m } => std::f64::consts::PI * (diameter_m / 2.0) * (diameter_m / 2.0),
        other => other.area_m2(),
    }
}

/// Greatest extent of a face, in metres.
pub(crate) fn extent_m(outline: &Outline) -> f64 {
    match *outline {
        Outline::Disc { diameter_m } => diameter_m,
        Outline::Rectangle { length_m, width_m } => length_m.max(width_m),
        Outline::Ring { outer_diameter_m, .. } => outer_diameter_m,
    }
}

/// Diagnostics for an unusual size of the specimen.
pub(crate) fn outline_told(
    document: &Document,
    table: &Spanned<FaceFile>,
    outline: &Outline,
) -> Result<Option<Diagnostic>, Diagnostic> {
    let file = table.get_ref();
    let lengths = [&file.radius_mm, &file.diameter_mm, &file.length_mm, &file.outer_diameter_mm];
    let place = lengths.into_iter().flatten().next().map_or(table.span(), Spanned::span);
    SPECIMEN.check(LENGTH_MM.from_si(extent_m(outline)), || document.refuse(place, ""))
}
