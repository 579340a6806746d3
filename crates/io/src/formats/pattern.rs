//! Pattern tables of scenes, and texture tables of designs.

use std::ops::Range;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use slipgrid_base::key_error::KeyError;
use slipgrid_base::units::{LENGTH_UM, SLIDING_ANGLE_DEG};
use slipgrid_design::FurtherDirections;
use slipgrid_laser::export::Specimen;
use slipgrid_model::pattern::{Arrangement, Pattern, Planform, Texture, TextureRecord};
use slipgrid_model::springblock::Layer;

use super::keys::{Keys, SEVERAL as SLIDING};
use super::values::{Number, Numbers, list};
use crate::formats::outline::read_outline;
use crate::formats::{Diagnostic, Document, Spanned};

/// A pattern in the form of a scene file.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(try_from = "Keys")]
#[schemars(!try_from)]
pub struct PatternFile {
    /// Width of a cavity along its row; for discs, the diameter.
    pub width_um: Number,
    /// Gap between two cavities of a row.
    pub spacing_um: Number,
    /// Depth of a cavity.
    pub depth_um: Number,
    /// Standard error of the measured mean width of a cut sample, at most a third of the width; 0 when absent. Refused
    /// in a scene.
    pub width_std_um: Option<Number>,
    /// Standard error of the measured mean spacing of a cut sample, at most a third of the spacing; 0 when absent.
    /// Refused in a scene.
    pub spacing_std_um: Option<Number>,
    /// Standard error of the measured mean depth of a cut sample, at most a third of the depth; 0 when absent. Refused
    /// in a scene.
    pub depth_std_um: Option<Number>,
    /// Altitude map of one period of the measured face, in place of keys for rims.
    pub relief: Option<Spanned<String>>,
    /// Shape, arrangement, directions and rims.
    #[serde(flatten)]
    pub texture: TextureFile,
    // In a schema, this key replaces the key of equal name in the flattened `texture`.
    /// Angle of the sliding direction from the specimen's x axis; 0 when absent.
    pub sliding_angle_deg: Option<Number>,
}

/// A texture in the form of a scene file or a design file: all properties of a pattern that a design does not search.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(try_from = "Keys")]
#[schemars(!try_from)]
pub struct TextureFile {
    /// A drawing, SVG or DXF, whose only closed outline is used in place of `vertices_um`.
    pub outline: Option<Spanned<String>>,
    /// The layer of the DXF drawing that holds the outline; any when absent.
    pub outline_layer: Option<Spanned<String>>,
    /// The other keys of a texture, without their positions in the file; [`Document::refuse_key`] finds the position of
    /// a refused key.
    #[serde(flatten)]
    pub record: TextureRecord,
    /// Angle of the sliding direction from the specimen's x axis; 0 when absent. A design may name several.
    pub sliding_angle_deg: Option<Spanned<Numbers>>,
}

impl TryFrom<Keys> for PatternFile {
    type Error = String;

    fn try_from(mut keys: Keys) -> Result<Self, String> {
        let own =
            ["width_um", "spacing_um", "depth_um", "width_std_um", "spacing_std_um", "depth_std_um", "relief", SLIDING];
        let mut numbers = [const { None }; 6];
        for (number, key) in numbers.iter_mut().zip(own) {
            *number = keys.take(key)?;
        }
        let [width_um, spacing_um, depth_um, width_std_um, spacing_std_um, depth_std_um] = numbers;
        let relief = keys.take("relief")?;
        let sliding_angle_deg = match keys.several.take() {
            None => None,
            Some(angles) => match *angles.get_ref() {
                Numbers::One(angle_deg) => Some(Spanned::new(angles.span(), angle_deg)),
                Numbers::Each(_) => return Err(format!("`{SLIDING}`: invalid type: sequence, expected f64")),
            },
        };
        let texture = TextureFile::read(keys, &own)?;
        let needed = |key: &str, number: Option<Number>| number.ok_or_else(|| format!("missing field `{key}`"));
        Ok(Self {
            width_um: needed("width_um", width_um)?,
            spacing_um: needed("spacing_um", spacing_um)?,
            depth_um: needed("depth_um", depth_um)?,
            width_std_um,
            spacing_std_um,
            depth_std_um,
            relief,
            sliding_angle_deg,
            texture,
        })
    }
}

impl TryFrom<Keys> for TextureFile {
    type Error = String;

    fn try_from(keys: Keys) -> Result<Self, String> {
        Self::read(keys, &[SLIDING])
    }
}

impl TextureFile {
    /// Reads the keys of a texture. `beside` names further keys of the table, for messages about unknown keys.
    fn read(mut keys: Keys, beside: &[&str]) -> Result<Self, String> {
        let own = ["outline", "outline_layer"];
        let (outline, outline_layer) = (keys.take(own[0])?, keys.take(own[1])?);
        let sliding_angle_deg = keys.several.take();
        Ok(Self { outline, outline_layer, sliding_angle_deg, record: keys.record(&[beside, &own].concat())? })
    }
}

impl PatternFile {
    /// Standard errors of width, spacing and depth in micrometres, as written in the file.
    pub(crate) const fn dimensions_std(&self) -> [&Option<Number>; 3] {
        [&self.width_std_um, &self.spacing_std_um, &self.depth_std_um]
    }
}

impl From<&Pattern> for PatternFile {
    /// Converts the pattern to its file form; defaults are left out.
    fn from(pattern: &Pattern) -> Self {
        let [width_um, spacing_um, depth_um] =
            pattern.lengths_m().map(|length_m| Number::from(LENGTH_UM.from_si(length_m)));
        let mut record = TextureRecord::from(pattern);
        Self {
            width_um,
            spacing_um,
            depth_um,
            sliding_angle_deg: record.sliding_angle_deg.take().map(Number::from),
            texture: TextureFile { record, ..TextureFile::default() },
            ..Self::default()
        }
    }
}

/// Reads the pattern of a scene or a trial.
///
/// # Errors
/// [`Diagnostic`] if numbers are out of range, or if the planform does not use a key.
pub fn read_pattern(document: &Document, file: &Spanned<PatternFile>) -> Result<Pattern, Diagnostic> {
    let pattern = file.get_ref();
    let mut texture = read_texture(document, &pattern.texture, file.span())?;
    if let Some(angle) = &pattern.sliding_angle_deg {
        texture = slid(document, &texture, document.number(angle, SLIDING_ANGLE_DEG)?, angle.span())?;
    }
    let width_m = document.number(&pattern.width_um, LENGTH_UM)?;
    let spacing_m = document.number(&pattern.spacing_um, LENGTH_UM)?;
    let depth_m = document.number(&pattern.depth_um, LENGTH_UM)?;
    Pattern::new(texture, width_m, spacing_m, depth_m).map_err(|error| document.refuse(file.span(), error.to_string()))
}

/// Refuses a cavity depth `depth_m`, in metres, that reaches or exceeds the height of `layer`.
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
    let TextureFile { outline, outline_layer, sliding_angle_deg, record } = file;
    let refused = |error: KeyError| document.refuse_key(&table, &error);
    let planform = record.planform().map_err(refused)?;
    let drawing = [outline, outline_layer].into_iter().flatten().next();
    if let (Some(key), true) = (drawing, planform != Planform::Polygon) {
        let refused = document.refuse(key.span(), format!("has no meaning for planform \"{planform}\""));
        return Err(refused.expected("planform = \"polygon\", or no such key"));
    }
    let drawn = if planform == Planform::Polygon {
        let vertices = record.vertices_um.clone();
        let vertices = vertices.map(|vertices| Spanned::new(document.value_span(&table, "vertices_um"), vertices));
        Some(read_outline(document, vertices.as_ref(), outline.as_ref(), outline_layer.as_ref(), table.clone())?)
    } else {
        None
    };
    let texture = record.texture(drawn).map_err(refused)?;
    let Some(angles) = sliding_angle_deg else { return Ok(texture) };
    slid(document, &texture, list(document, angles, SLIDING_ANGLE_DEG)?[0], angles.span())
}

/// Sets the sliding direction of `texture` to `angle_deg`, in degrees; an error refers to the file position `span`.
fn slid(document: &Document, texture: &Texture, angle_deg: f64, span: Range<usize>) -> Result<Texture, Diagnostic> {
    texture.with_sliding_angle_deg(angle_deg).map_err(|error| document.refuse(span, error.to_string()))
}

/// Reads the sliding directions of `file` except the first, which `texture` already has. Directions that the symmetry
/// of `texture` and `specimen` makes equivalent to another direction are returned separately.
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
        known.push(slid(document, texture, angle_deg, angles.span())?);
        found.different_deg.push(angle_deg);
    }
    Ok(found)
}

/// Refuses a texture that a two-dimensional model, a vertical section along the sliding direction, cannot represent.
/// Such a model represents grooves across the sliding direction, and squares in rows along the sliding direction.
///
/// # Errors
/// [`Diagnostic`] at the first key that needs a three-dimensional model.
pub fn require_section(
    document: &Document,
    (file, table): (&TextureFile, Range<usize>),
    texture: &Texture,
) -> Result<(), Diagnostic> {
    const WHY: &str = "needs three dimensions, which scenes with extent = \"cell\" or \"strip\" have: the vertical \
                       section along the sliding direction says little of it";
    if texture.is_one_section() {
        return Ok(());
    }
    let TextureRecord { planform, arrangement, angle_deg, .. } = &file.record;
    let refuse =
        |key: &str, expected: &str| Err(document.refuse(document.value_span(&table, key), WHY).expected(expected));
    if !matches!(texture.planform(), Planform::Groove | Planform::Square) && planform.is_some() {
        return refuse("planform", "\"groove\" or \"square\"");
    }
    if texture.arrangement() != Arrangement::Square && arrangement.is_some() {
        return refuse("arrangement", "\"square\"");
    }
    if texture.sliding_direction()[1] == 0.0 {
        return Ok(());
    }
    // Grooves or the sliding direction are turned, or both by different angles.
    match (texture.sliding_angle_deg() != 0.0, angle_deg) {
        (true, Some(groove_deg)) => refuse(SLIDING, &format!("that of the grooves, {groove_deg}")),
        (true, None) => refuse(SLIDING, "0"),
        (false, Some(_)) => refuse("angle_deg", "0"),
        (false, None) => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_model::pattern::{Rim, RimProfile};

    #[derive(Debug, Deserialize)]
    struct Written {
        pattern: Spanned<PatternFile>,
    }

    const LENGTHS: &str = "[pattern]\nwidth_um = 130.0\nspacing_um = 370.0\ndepth_um = 20.0\n";

    fn read(keys: &str) -> Result<(Pattern, Result<(), Diagnostic>), Diagnostic> {
        let document = Document::new("a.toml", format!("{LENGTHS}{keys}"));
        let written: Written = document.parse()?;
        let pattern = read_pattern(&document, &written.pattern)?;
        let section =
            require_section(&document, (&written.pattern.get_ref().texture, written.pattern.span()), pattern.texture());
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
    fn the_plane_sections_grooves_and_squares() {
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
    }

    #[test]
    fn rims_have_the_numbers_of_their_keys() {
        let um = |um: f64| LENGTH_UM.to_si(um);
        let rim = |keys: &str| *read(keys).unwrap().0.texture().rim().unwrap();
        let one = Rim::new(um(0.1), um(10.0), RimProfile::Round).unwrap();
        assert_eq!(rim("rim_height_um = 0.1\nrim_width_um = 10"), one);
        let pairs = [[um(5.2), um(0.1)], [um(20.0), um(0.5)]];
        let by_depth = Rim::following_depth(&pairs, um(12.5), RimProfile::Flat).unwrap();
        let keys = "rim_heights_um = [[5.2, 0.1], [20, 0.5]]\nrim_width_um = 12.5\nrim_profile = \"flat\"\n\
                    rim_height_std_um = 0.02";
        assert_eq!(rim(keys), by_depth.with_height_std_m(um(0.02)).unwrap());
        // A rim of no height is none.
        assert!(read("rim_height_um = 0\nrim_width_um = 10").unwrap().0.texture().rim().is_none());
    }
}
