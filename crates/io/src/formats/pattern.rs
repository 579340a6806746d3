//! Pattern tables of scenes, and texture tables of designs.

use std::ops::Range;

use serde::{Deserialize, Serialize};
use slipgrid_model::pattern::{Arrangement, Pattern, PatternError, Planform, Rim, Texture};
use slipgrid_model::springblock::Layer;
use toml::Spanned;

use slipgrid_design::FurtherDirections;
use slipgrid_design::results::PatternReport;
use slipgrid_laser::export::Specimen;

use super::document::Document;
use super::rim::read_rim;
use super::values::{Number, NumberList, Numbers, list, number, number_list};
use crate::formats::diagnostic::Diagnostic;
use crate::formats::outline::read_outline;
use slipgrid_base::units::{CROSSING_ANGLE_DEG, GROOVE_ANGLE_DEG, LENGTH_UM, SLIDING_ANGLE_DEG};

/// A pattern in the form of a scene file.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct PatternFile {
    /// Width of a cavity along its row; the diameter of a disc.
    pub width_um: Number,
    /// Gap between two cavities of a row.
    pub spacing_um: Number,
    /// Depth of a cavity.
    pub depth_um: Number,
    /// Standard error of the measured mean width of a cut sample, at most a third of it; 0 when absent. No key of a scene.
    pub width_std_um: Option<Number>,
    /// Standard error of the measured mean spacing of a cut sample, at most a third of it; 0 when absent. No key of a scene.
    pub spacing_std_um: Option<Number>,
    /// Standard error of the measured mean depth of a cut sample, at most a third of it; 0 when absent. No key of a scene.
    pub depth_std_um: Option<Number>,
    /// As in [`TextureFile`].
    pub planform: Option<Spanned<String>>,
    /// As in [`TextureFile`].
    pub length_um: Option<Number>,
    /// As in [`TextureFile`].
    pub vertices_um: Option<Spanned<Vec<[f64; 2]>>>,
    /// As in [`TextureFile`].
    pub outline: Option<Spanned<String>>,
    /// As in [`TextureFile`].
    pub outline_layer: Option<Spanned<String>>,
    /// As in [`TextureFile`].
    pub spacing_across_um: Option<Number>,
    /// As in [`TextureFile`].
    pub arrangement: Option<Spanned<String>>,
    /// As in [`TextureFile`].
    pub angle_deg: Option<Number>,
    /// As in [`TextureFile`].
    pub crossing_angle_deg: Option<Number>,
    /// Angle of the sliding direction from the specimen's x axis; 0 when absent.
    pub sliding_angle_deg: Option<Number>,
    /// Map of one period of the measured face, in place of rims.
    pub relief: Option<Spanned<String>>,
    /// As in [`TextureFile`].
    pub rim_height_um: Option<Number>,
    /// As in [`TextureFile`].
    pub rim_heights_um: Option<Spanned<Vec<NumberList>>>,
    /// As in [`TextureFile`].
    pub rim_width_um: Option<Number>,
    /// As in [`TextureFile`].
    pub rim_profile: Option<Spanned<String>>,
    /// As in [`TextureFile`].
    pub rim_height_std_um: Option<Number>,
}

/// A texture in the form of a design file: all properties of a pattern that the design does not search.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TextureFile {
    /// Shape seen from above; `groove` when absent.
    pub planform: Option<Spanned<String>>,
    /// Extent of a rectangle across its row.
    pub length_um: Option<Number>,
    /// Outline of a polygon: corners as `[x, y]` in order, the last joined to the first. Only the shape matters: it is
    /// scaled so that the extent along x is the width.
    pub vertices_um: Option<Spanned<Vec<[f64; 2]>>>,
    /// A drawing, SVG or DXF, whose only closed outline is used in place of `vertices_um`.
    pub outline: Option<Spanned<String>>,
    /// The layer of the DXF drawing that holds the outline; any when absent.
    pub outline_layer: Option<Spanned<String>>,
    /// Gap between rows; as along the row when absent.
    pub spacing_across_um: Option<Number>,
    /// `square`, `staggered` or `hexagonal`; `square` when absent.
    pub arrangement: Option<Spanned<String>>,
    /// Angle of grooves (of the first family of crossing grooves) from the direction across the specimen's x axis; 0
    /// when absent.
    pub angle_deg: Option<Number>,
    /// Angle of the second family of crossing grooves from the first; 90 when absent.
    pub crossing_angle_deg: Option<Number>,
    /// Angle of the sliding direction from the specimen's x axis; 0 when absent. A design may name several.
    pub sliding_angle_deg: Option<Spanned<Numbers>>,
    /// Height of the rims at the edges of cavities, for any depth; no rims when neither this nor the next is given.
    pub rim_height_um: Option<Number>,
    /// Pairs of cavity depth and rim height, in ascending order.
    pub rim_heights_um: Option<Spanned<Vec<NumberList>>>,
    /// Distance from the edge at which a rim ends.
    pub rim_width_um: Option<Number>,
    /// Outward profile of rims: `round`, `flat` or `ramp`; `round` when absent.
    pub rim_profile: Option<Spanned<String>>,
    /// Standard deviation of the height between rims of one sample; 0 when absent.
    pub rim_height_std_um: Option<Number>,
}

impl PatternFile {
    /// Standard errors of width, spacing and depth.
    pub(crate) const fn dimensions_std(&self) -> [&Option<Number>; 3] {
        [&self.width_std_um, &self.spacing_std_um, &self.depth_std_um]
    }

    /// Texture properties of the pattern.
    #[must_use]
    pub fn texture(&self) -> TextureFile {
        TextureFile {
            planform: self.planform.clone(),
            length_um: self.length_um.clone(),
            vertices_um: self.vertices_um.clone(),
            outline: self.outline.clone(),
            outline_layer: self.outline_layer.clone(),
            spacing_across_um: self.spacing_across_um.clone(),
            arrangement: self.arrangement.clone(),
            angle_deg: self.angle_deg.clone(),
            crossing_angle_deg: self.crossing_angle_deg.clone(),
            sliding_angle_deg: self
                .sliding_angle_deg
                .as_ref()
                .map(|angle| Spanned::new(angle.span(), Numbers::One(*angle.get_ref()))),
            rim_height_um: self.rim_height_um.clone(),
            rim_heights_um: self.rim_heights_um.clone(),
            rim_width_um: self.rim_width_um.clone(),
            rim_profile: self.rim_profile.clone(),
            rim_height_std_um: self.rim_height_std_um.clone(),
        }
    }
}

impl From<&Pattern> for PatternFile {
    /// Converts the pattern to its file form; defaults are left out.
    fn from(pattern: &Pattern) -> Self {
        let written = PatternReport::from(pattern);
        let named = |name: String| Spanned::new(0..0, name);
        let rim = written.rim.as_ref();
        Self {
            width_um: number(written.width_um),
            spacing_um: number(written.spacing_um),
            depth_um: number(written.depth_um),
            width_std_um: None,
            spacing_std_um: None,
            depth_std_um: None,
            planform: Some(named(written.planform)),
            length_um: written.length_um.map(number),
            vertices_um: written.vertices_um.map(|vertices| Spanned::new(0..0, vertices)),
            outline: None,
            outline_layer: None,
            spacing_across_um: written.spacing_across_um.map(number),
            arrangement: written.arrangement.map(named),
            angle_deg: written.angle_deg.map(number),
            crossing_angle_deg: written.crossing_angle_deg.map(number),
            sliding_angle_deg: written.sliding_angle_deg.map(number),
            relief: None,
            rim_height_um: rim.and_then(|rim| rim.rim_height_um).map(number),
            rim_heights_um: rim
                .and_then(|rim| rim.rim_heights_um.as_ref())
                .map(|pairs| Spanned::new(0..0, pairs.iter().map(|pair| number_list(*pair)).collect())),
            rim_width_um: rim.map(|rim| number(rim.rim_width_um)),
            rim_profile: rim.map(|rim| named(rim.rim_profile.clone())),
            rim_height_std_um: rim.and_then(|rim| rim.rim_height_std_um).map(number),
        }
    }
}

/// Reads a pattern.
///
/// # Errors
/// [`Diagnostic`] if numbers are out of range, or if the planform does not use a key.
pub fn read_pattern(document: &Document, file: &Spanned<PatternFile>) -> Result<Pattern, Diagnostic> {
    let pattern = file.get_ref();
    let texture = read_texture(document, &pattern.texture(), file.span())?;
    let width_m = document.number(&pattern.width_um, LENGTH_UM)?;
    let spacing_m = document.number(&pattern.spacing_um, LENGTH_UM)?;
    let depth_m = document.number(&pattern.depth_um, LENGTH_UM)?;
    Pattern::new(texture, width_m, spacing_m, depth_m).map_err(|error| document.refuse(file.span(), error.to_string()))
}

/// Refuses cavities as deep as `layer` or deeper.
///
/// # Errors
/// [`Diagnostic`] at the depth.
pub fn check_depth(document: &Document, file: &PatternFile, depth_m: f64, layer: &Layer) -> Result<(), Diagnostic> {
    if depth_m < layer.height_m {
        return Ok(());
    }
    let layer_um = LENGTH_UM.from_si(layer.height_m);
    Err(document
        .refuse(file.depth_um.span(), format!("um leaves nothing of the layer of {layer_um} um"))
        .expected(format!("a depth below {layer_um} um")))
}

/// Reads the texture in the table at `table`, with the first sliding direction that it names.
///
/// # Errors
/// [`Diagnostic`] if names are unknown, numbers are out of range, or the planform does not use a key.
pub fn read_texture(document: &Document, file: &TextureFile, table: Range<usize>) -> Result<Texture, Diagnostic> {
    let planform = file.planform.as_ref();
    let planform =
        planform.map_or(Ok(Planform::Groove), |name| document.choice(name, &Planform::ALL, Planform::name))?;
    if planform == Planform::Rectangle && file.length_um.is_none() {
        return Err(document.missing(table, "length_um"));
    }
    let drawn = [
        file.vertices_um.as_ref().map(Spanned::span),
        file.outline.as_ref().map(Spanned::span),
        file.outline_layer.as_ref().map(Spanned::span),
    ];
    if let (Some(key), true) = (drawn.into_iter().flatten().next(), planform != Planform::Polygon) {
        let refused = document.refuse(key, format!("has no meaning for planform \"{planform}\""));
        return Err(refused.expected("planform = \"polygon\", or no such key"));
    }
    // A property that the planform lacks is refused at the key that needs it.
    let refuse = |span: Range<usize>, error: &PatternError, expected: &'static str| match error {
        PatternError::NoSuchProperty { .. } => {
            document.refuse(span, format!("has no meaning for planform \"{planform}\"")).expected(expected)
        }
        _ => document.refuse(span, error.to_string()),
    };
    let mut texture = Texture::new(planform);
    if planform == Planform::Polygon {
        let (vertices, drawing, layer) =
            (file.vertices_um.as_ref(), file.outline.as_ref(), file.outline_layer.as_ref());
        let outline = read_outline(document, vertices, drawing, layer, table.clone())?;
        texture = texture.with_outline(outline).map_err(|error| document.refuse(table, error.to_string()))?;
    }
    if let Some(length) = &file.length_um {
        texture = texture
            .with_length_m(document.number(length, LENGTH_UM)?)
            .map_err(|error| refuse(length.span(), &error, "planform = \"rectangle\", or no such key"))?;
    }
    if let Some(spacing) = &file.spacing_across_um {
        texture = texture.with_spacing_across_m(document.number(spacing, LENGTH_UM)?).map_err(|error| {
            refuse(
                spacing.span(),
                &error,
                "planform = \"square\", \"rectangle\", \"disc\" or \"polygon\", or no such key",
            )
        })?;
    }
    if let Some(name) = &file.arrangement {
        let arrangement = document.choice(name, &Arrangement::ALL, Arrangement::name)?;
        texture = texture.with_arrangement(arrangement).map_err(|error| {
            refuse(name.span(), &error, "\"square\", or planform = \"square\", \"rectangle\", \"disc\" or \"polygon\"")
        })?;
    }
    if let Some(angle) = &file.angle_deg {
        texture = texture.with_groove_angle_deg(document.number(angle, GROOVE_ANGLE_DEG)?).map_err(|error| {
            refuse(angle.span(), &error, "planform = \"groove\" or \"crosshatch\", or sliding_angle_deg instead")
        })?;
    }
    if let Some(angle) = &file.crossing_angle_deg {
        texture = texture
            .with_crossing_angle_deg(document.number(angle, CROSSING_ANGLE_DEG)?)
            .map_err(|error| refuse(angle.span(), &error, "planform = \"crosshatch\", or no such key"))?;
    }
    if let Some(angle) = &file.sliding_angle_deg {
        texture = texture
            .with_sliding_angle_deg(list(document, angle, SLIDING_ANGLE_DEG)?[0])
            .map_err(|error| document.refuse(angle.span(), error.to_string()))?;
    }
    // A rim without height is left out.
    Ok(texture.with_rim(read_rim(document, file)?.filter(Rim::stands)))
}

/// Sliding directions of `file` on `specimen`, without the first, which `texture` has.
///
/// # Errors
/// [`Diagnostic`] for numbers out of range.
pub fn read_directions(
    document: &Document,
    file: &TextureFile,
    texture: &Texture,
    specimen: &Specimen,
) -> Result<FurtherDirections, Diagnostic> {
    let mut found = FurtherDirections::default();
    let Some(angles) = &file.sliding_angle_deg else { return Ok(found) };
    let mut known = vec![*texture];
    for angle_deg in list(document, angles, SLIDING_ANGLE_DEG)?.into_iter().skip(1) {
        if known.iter().any(|known| specimen.slides_alike(known, angle_deg)) {
            found.alike_deg.push(angle_deg);
            continue;
        }
        let turned = texture.with_sliding_angle_deg(angle_deg);
        known.push(turned.map_err(|error| document.refuse(angles.span(), error.to_string()))?);
        found.different_deg.push(angle_deg);
    }
    Ok(found)
}

/// Refuses a texture that has no meaningful section in the vertical plane. The plane models the sections of grooves
/// across the sliding direction, and of squares in rows along it.
///
/// # Errors
/// [`Diagnostic`] at the first key that needs a model in space.
pub fn require_section(document: &Document, file: &TextureFile, texture: &Texture) -> Result<(), Diagnostic> {
    const WHY: &str = "needs three dimensions, which scenes with extent = \"cell\" or \"strip\" have: the vertical \
                       section along the sliding direction says little of it";
    if texture.is_one_section() {
        return Ok(());
    }
    let refuse = |span: Range<usize>, expected: &str| Err(document.refuse(span, WHY).expected(expected));
    if let (false, Some(planform)) = (matches!(texture.planform(), Planform::Groove | Planform::Square), &file.planform)
    {
        return refuse(planform.span(), "\"groove\" or \"square\"");
    }
    if let Some(arrangement) = file.arrangement.as_ref().filter(|_| texture.arrangement() != Arrangement::Square) {
        return refuse(arrangement.span(), "\"square\"");
    }
    if texture.sliding_direction()[1] == 0.0 {
        return Ok(());
    }
    // Grooves or the sliding direction are turned, or both by different angles.
    match (&file.sliding_angle_deg, &file.angle_deg) {
        (Some(sliding), Some(groove)) => refuse(sliding.span(), &format!("that of the grooves, {}", groove.get_ref())),
        (Some(sliding), None) => refuse(sliding.span(), "0"),
        (None, Some(groove)) => refuse(groove.span(), "0"),
        (None, None) => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, Deserialize)]
    struct Written {
        pattern: Spanned<PatternFile>,
    }

    const LENGTHS: &str = "[pattern]\nwidth_um = 130.0\nspacing_um = 370.0\ndepth_um = 20.0\n";

    fn read(keys: &str) -> Result<(Pattern, Result<(), Diagnostic>), Diagnostic> {
        let document = Document::new("a.toml", format!("{LENGTHS}{keys}"));
        let written: Written = document.parse()?;
        let pattern = read_pattern(&document, &written.pattern)?;
        let section = require_section(&document, &written.pattern.get_ref().texture(), pattern.texture());
        Ok((pattern, section))
    }

    #[test]
    fn every_texture_reads_back_as_it_is_written() {
        for keys in [
            "",
            "planform = \"square\"\nspacing_across_um = 100.1",
            "planform = \"rectangle\"\nlength_um = 70.7\narrangement = \"staggered\"",
            "planform = \"disc\"\nsliding_angle_deg = -33.3\narrangement = \"square\"",
            "angle_deg = 45\nsliding_angle_deg = 180",
            "rim_height_um = 0.13\nrim_width_um = 11.7",
            "rim_heights_um = [[5.2, 0.1], [20, 0.57]]\nrim_width_um = 9.9\nrim_profile = \"ramp\"\nrim_height_std_um = 0.03",
            "planform = \"polygon\"\nvertices_um = [[0, 0], [10.1, 3], [7, 7.7], [0.3, 3]]\narrangement = \"staggered\"",
            "planform = \"crosshatch\"\nangle_deg = -20\ncrossing_angle_deg = 60.5\nsliding_angle_deg = 10",
        ] {
            let (pattern, _) = read(keys).unwrap();
            #[derive(Serialize)]
            struct Again {
                pattern: PatternFile,
            }
            let text = toml::to_string(&Again { pattern: PatternFile::from(&pattern) }).unwrap();
            let document = Document::new("b.toml", text);
            let again: Written = document.parse().unwrap();
            assert_eq!(read_pattern(&document, &again.pattern).unwrap(), pattern, "{keys}");
        }
        let (pattern, _) = read("planform = \"disc\"\nsliding_angle_deg = 90").unwrap();
        assert_eq!((pattern.planform(), pattern.sliding_direction()), (Planform::Disc, [0.0, 1.0]));
    }

    #[test]
    fn what_the_plane_sections_and_what_not() {
        for keys in [
            "",
            "angle_deg = 0",
            "sliding_angle_deg = 180.0",
            "angle_deg = 20.0\nsliding_angle_deg = 20.0",
            "planform = \"square\"",
            "planform = \"square\"\nspacing_across_um = 50.0\narrangement = \"square\"",
        ] {
            assert_eq!(read(keys).unwrap().1.map_err(|refused| refused.to_string()), Ok(()), "{keys}");
        }
        for (keys, key, expected) in [
            ("planform = \"disc\"", "5: pattern.planform: \"disc\" needs", "\"groove\" or \"square\""),
            ("planform = \"rectangle\"\nlength_um = 5.0", "5: pattern.planform: \"rectangle\" needs", "\"square\""),
            ("angle_deg = 90", "5: pattern.angle_deg: 90 needs three dimensions", "expected 0"),
            ("sliding_angle_deg = 1.5", "5: pattern.sliding_angle_deg: 1.5 needs", "expected 0"),
            ("angle_deg = 10\nsliding_angle_deg = 20", "6: pattern.sliding_angle_deg: 20 needs", "grooves, 10"),
            ("planform = \"square\"\nsliding_angle_deg = 45", "6: pattern.sliding_angle_deg: 45 needs", "expected 0"),
            (
                "planform = \"square\"\narrangement = \"staggered\"",
                "6: pattern.arrangement: \"staggered\"",
                "\"square\"",
            ),
        ] {
            let refused = read(keys).unwrap().1.unwrap_err().to_string();
            assert!(refused.starts_with(&format!("a.toml:{key}")) && refused.contains(expected), "{keys}: {refused}");
        }
    }
}
