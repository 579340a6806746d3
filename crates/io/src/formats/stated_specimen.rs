//! Specimens of a calibration and of its trials: face, rim, thickness, holder, and the number of specimens that share a
//! force.

use serde::Deserialize;
use slipgrid_infer::calibrate::CutSpecimen;
use slipgrid_laser::export::{Outline, Specimen, SpecimenRecord};
use slipgrid_model::springblock::{Holder, MAX_ROWS};

use super::calibration_file::{FaceFile, MeasurementsFile};
use super::scene::DEFAULT_LAYER;
use crate::formats::plausible::SPECIMEN;
use crate::formats::{Diagnostic, Document, Spanned};
use slipgrid_base::units::LENGTH_MM;

/// Minimum and maximum thickness of a specimen that a calibration may state, in metres: the height of the default
/// layer, and the height of the maximum number of rows of default blocks.
const THICKNESS_M: [f64; 2] = [DEFAULT_LAYER.height_m, MAX_ROWS * DEFAULT_LAYER.block_m];

/// A specimen as stated by a table of a calibration.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StatedSpecimen {
    /// Face, and treatment of cavities at the rim.
    pub(crate) specimen: Specimen,
    /// Thickness, in metres; `None` if not given.
    pub(crate) thickness_m: Option<f64>,
    /// How the specimen is held; `None` if not given.
    pub(crate) holder: Option<Holder>,
}

impl StatedSpecimen {
    /// Reads the specimen of `table`; treatment of cavities at the rim, thickness and holder default to those of
    /// `usual`.
    pub(crate) fn read(
        document: &Document,
        table: &Spanned<FaceFile>,
        usual: Option<Self>,
    ) -> Result<Self, Diagnostic> {
        let file = table.get_ref();
        let mut specimen = read_face(document, table)?;
        if file.cavities.is_none() {
            specimen.is_clipped = usual.is_some_and(|usual| usual.specimen.is_clipped);
        }
        let stated_m = document.optional(file.thickness_mm.as_ref(), LENGTH_MM)?;
        let [least_m, most_m] = THICKNESS_M;
        if let Some(given) = &file.thickness_mm
            && stated_m.is_some_and(|stated_m| !(least_m..=most_m).contains(&stated_m))
        {
            let [least_mm, most_mm] = THICKNESS_M.map(|end_m| LENGTH_MM.from_si(end_m));
            return Err(document
                .refuse(given.span(), "mm is no thickness that is modelled")
                .expected(format!("a thickness in millimetres, from {least_mm} to {most_mm}")));
        }
        let thickness_m = stated_m.or(usual.and_then(|usual| usual.thickness_m));
        let holder = read_holder(document, file.holder.as_ref(), thickness_m.is_some())?;
        Ok(Self { specimen, thickness_m, holder: holder.or(usual.and_then(|usual| usual.holder)) })
    }

    /// Converts to the specimen of a cut sample.
    pub(crate) fn cut(self) -> CutSpecimen {
        CutSpecimen { face: Some(self.specimen), thickness_m: self.thickness_m, holder: self.holder }
    }
}

/// Reads how a specimen is held; `None` if not given. A holder is refused without a stated thickness, because the tilt
/// of the pressure by friction depends on the thickness.
pub(crate) fn read_holder(
    document: &Document,
    given: Option<&Spanned<String>>,
    has_thickness: bool,
) -> Result<Option<Holder>, Diagnostic> {
    let Some(given) = given else { return Ok(None) };
    let holder = document.choice(given, &Holder::ALL, Holder::name)?;
    if !has_thickness {
        return Err(document
            .refuse(given.span(), "is given without the thickness of the specimen")
            .expected("thickness_mm beside it, or no such key"));
    }
    Ok(Some(holder))
}

/// Reads the face of a specimen: a disc by its radius, or one of the shapes of a design's specimen.
fn read_face(document: &Document, table: &Spanned<FaceFile>) -> Result<Specimen, Diagnostic> {
    let file = table.get_ref();
    let others = [
        ("disc", &file.diameter_mm),
        ("rectangle", &file.length_mm),
        ("rectangle", &file.width_mm),
        ("ring", &file.outer_diameter_mm),
        ("ring", &file.inner_diameter_mm),
    ];
    let mut written = others.map(|(_, length)| length.as_ref().map(|length| *length.get_ref()));
    let mut named = file.shape.as_ref().map(|shape| shape.get_ref().as_str());
    if let Some(radius) = &file.radius_mm {
        let stray = others.iter().find_map(|(_, length)| length.as_ref().map(Spanned::span));
        if let Some(stray) = stray.or(file.shape.as_ref().map(Spanned::span)) {
            return Err(document
                .refuse(stray, "stands beside radius_mm")
                .expected("either radius_mm alone, or a shape with its lengths"));
        }
        document.number(radius, LENGTH_MM)?;
        (named, written[0]) = (Some("disc"), Some(2.0 * radius.get_ref()));
    }
    // Without a shape key the lengths determine the shape.
    let shape = named.or_else(|| others.iter().find(|(_, length)| length.is_some()).map(|(shape, _)| *shape));
    let shape = shape.ok_or_else(|| {
        document.missing(table.span(), "radius_mm").expected(
            "radius_mm or diameter_mm of a disc, outer_diameter_mm and inner_diameter_mm of a ring, or length_mm and \
             width_mm of a rectangle",
        )
    })?;
    let [diameter_mm, length_mm, width_mm, outer_diameter_mm, inner_diameter_mm] = written;
    let (shape, cavities) = (shape.to_owned(), file.cavities.as_ref().map(|name| name.get_ref().clone()));
    let record =
        SpecimenRecord { shape, diameter_mm, length_mm, width_mm, outer_diameter_mm, inner_diameter_mm, cavities };
    // A disc given by its radius has no key for the diameter.
    record.specimen().map_err(|error| match file.radius_mm.as_ref().filter(|_| error.key == "diameter_mm") {
        Some(radius) => document.refuse(radius.span(), "is the radius of no specimen").expected("at most 5000 mm"),
        None => document.refuse_key(&table.span(), &error),
    })
}

/// Area of a face, in square metres.
pub(crate) fn area_m2(outline: &Outline) -> f64 {
    match outline {
        // pi r^2
        Outline::Disc { diameter_m } => std::f64::consts::PI * (diameter_m / 2.0) * (diameter_m / 2.0),
        other => other.area_m2(),
    }
}

/// Diagnostic for an unusual size of the specimen, `None` for a usual one; refuses an impossible size.
pub(crate) fn outline_told(
    document: &Document,
    table: &Spanned<FaceFile>,
    outline: &Outline,
) -> Result<Option<Diagnostic>, Diagnostic> {
    let file = table.get_ref();
    let lengths = [&file.radius_mm, &file.diameter_mm, &file.length_mm, &file.outer_diameter_mm];
    let place = lengths.into_iter().flatten().next().map_or(table.span(), Spanned::span);
    let [x_m, y_m] = outline.extents_m();
    SPECIMEN.check(LENGTH_MM.from_si(x_m.max(y_m)), || document.refuse(place, ""))
}

/// Maximum number of specimens in a holder.
pub const MAX_SPECIMENS: u32 = 100;

/// Meaning of a force in a table if a holder has several specimens: on one specimen, or on all of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum ForceIs {
    PerSample,
    Total,
}

/// Reads the number of specimens in a holder.
///
/// # Errors
/// [`Diagnostic`] if the number is 0 or above `MAX_SPECIMENS`.
pub(crate) fn read_count(document: &Document, given: &Spanned<u64>) -> Result<u32, Diagnostic> {
    let count = u32::try_from(*given.get_ref()).ok().filter(|count| (1..=MAX_SPECIMENS).contains(count));
    let expected = format!("a whole number from 1 to {MAX_SPECIMENS}");
    count.ok_or_else(|| document.refuse(given.span(), "specimens are not held").expected(expected))
}

/// Number of specimens that a force in the tables presses: `samples` if forces are totals, otherwise 1.
///
/// # Errors
/// [`Diagnostic`] if `samples` is out of range, or if one of `samples` and `force_is` is needed and missing.
pub(crate) fn sharing_force(document: &Document, table: Option<&Spanned<MeasurementsFile>>) -> Result<u32, Diagnostic> {
    let Some(table) = table else { return Ok(1) };
    let MeasurementsFile { samples, force_is, .. } = table.get_ref();
    let count = samples.as_ref().map(|given| read_count(document, given)).transpose()?;
    match (samples, count, force_is) {
        (None, _, Some(ForceIs::Total)) => {
            Err(document.missing(table.span(), "samples").expected("the specimens in the holder"))
        }
        (Some(given), Some(2..), None) => Err(document
            .refuse(given.span(), "specimens share a force, or each bears it")
            .expected("force_is = \"per_sample\" or \"total\" beside samples")),
        (_, Some(count), Some(ForceIs::Total)) => Ok(count),
        _ => Ok(1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reads the specimen of a trial from its `own` keys and the `usual` ones of the calibration.
    fn cut(usual: &str, own: &str) -> Result<CutSpecimen, String> {
        let read = |keys: &str, usual: Option<StatedSpecimen>| {
            let document = Document::new("c.toml", format!("radius_mm = 5.0\n{keys}\n"));
            let table = Spanned::new(0..0, document.parse().map_err(|refused: Diagnostic| refused.to_string())?);
            StatedSpecimen::read(&document, &table, usual).map_err(|refused| refused.to_string())
        };
        Ok(read(own, Some(read(usual, None)?))?.cut())
    }

    #[test]
    fn a_trial_is_held_as_the_calibration_says_or_as_it_says_itself() {
        let held = |usual: &str, own: &str| cut(usual, own).map(|cut| cut.holder);
        let rigid = "thickness_mm = 4.0\nholder = \"rigid\"";
        assert_eq!(held("", ""), Ok(None));
        assert_eq!(held(rigid, ""), Ok(Some(Holder::Rigid)));
        assert_eq!(held(rigid, "holder = \"self-aligning\""), Ok(Some(Holder::SelfAligning)));
        assert_eq!(held("thickness_mm = 4.0", "holder = \"rigid\""), Ok(Some(Holder::Rigid)));
    }

    use crate::formats::calibration_file::CalibrationFile;

    #[test]
    fn a_total_force_presses_all_specimens() {
        let pressed = |keys: &str| {
            let text = format!(
                "name = \"a\"\nsource = \"b\"\n[material]\nyoungs_modulus_gpa = 0.38\ndensity_g_cm3 = 0.9\n[specimen]\nradius_mm = 5.0\n\
                 [measurements]\n{keys}\n"
            );
            let document = Document::new("c.toml", text);
            let file: CalibrationFile = document.parse().map_err(|refused: Diagnostic| refused.to_string())?;
            sharing_force(&document, file.measurements.as_ref()).map_err(|refused| refused.to_string())
        };
        assert_eq!(pressed(""), Ok(1));
        assert_eq!(pressed("samples = 3\nforce_is = \"total\""), Ok(3));
        assert_eq!(pressed("samples = 3\nforce_is = \"per_sample\""), Ok(1));
        assert_eq!(pressed("samples = 1"), Ok(1));
    }
}
