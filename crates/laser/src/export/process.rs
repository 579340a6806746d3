//! Process sheet for the operator of the laser, as TOML.

use std::borrow::Cow;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use slipgrid_model::material::Provenance;
use slipgrid_model::pattern::{Pattern, Planform, Rim, TextureRecord};

use crate::export::removal::removed_volume_m3;
use crate::export::{
    ExportError, Laser, Layout, MICROMETRE_DECIMALS, SpecimenRecord, WorkSheet, all_positive, burst_warnings,
    groove_direction, lattice, micrometres, round_decimals, six_digits,
};

/// Effects that no model of slipgrid contains, for a pattern with or without rims; process sheets list them.
pub const fn not_modelled(has_rim: bool) -> [&'static str; 5] {
    let of_lasering = if has_rim {
        "roughening of the surface by lasering"
    } else {
        "recast rims: lasering raises a rim around each cavity and roughens the surface"
    };
    [of_lasering, "plasticity", "viscoelasticity", "heating", "wear"]
}

/// Origin of the rim dimensions, as stated on a process sheet.
const RIM_BASIS: &str = "what the design assumes: the laser's real rims have to be measured";

/// Standard deviations of the mean dimensions of a cut sample that the design assumes; absent ones are omitted.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Tolerances {
    /// Standard deviation of the width, in um.
    pub width_um: Option<f64>,
    /// Standard deviation of the spacing, in um.
    pub spacing_um: Option<f64>,
    /// Standard deviation of the depth, in um.
    pub depth_um: Option<f64>,
    /// Origin of the numbers.
    pub basis: String,
}

/// The material and the origin of its numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MaterialNote {
    /// Name of the material.
    pub name: String,
    /// Source of the measurements.
    pub source: String,
    /// Whether the height map of the area law is synthetic.
    pub synthetic_surface: bool,
}

impl From<&Provenance> for MaterialNote {
    fn from(of: &Provenance) -> Self {
        Self { name: of.name.clone(), source: of.source.clone(), synthetic_surface: of.synthetic_surface }
    }
}

/// Program that wrote a file, its version, and the version of the file's schema.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MadeBy {
    /// Program name, `slipgrid`.
    pub program: Cow<'static, str>,
    /// Version of the program.
    pub version: Cow<'static, str>,
    /// Schema version of the file.
    #[serde(default = "first_schema")]
    pub schema: u32,
}

/// Schema version of files that do not give one.
const fn first_schema() -> u32 {
    1
}

impl MadeBy {
    /// This program, for a file with the schema version `schema`.
    pub fn slipgrid(schema: u32) -> Self {
        Self { program: "slipgrid".into(), version: env!("CARGO_PKG_VERSION").into(), schema }
    }
}

/// Data for a process sheet in addition to the layout; a result has them under the same keys.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct ProcessInput {
    /// Name of the design.
    pub name: String,
    /// Program that made the design, with the schema version of the sheet.
    #[serde(flatten)]
    pub made_by: MadeBy,
    /// Seed of the design.
    pub seed: u64,
    /// Laser parameters.
    pub laser: Laser,
    /// Tolerances that the design assumes, if any.
    pub tolerances: Option<Tolerances>,
    /// The material.
    pub material: Provenance,
}

/// The process sheet. Dimensions of the pattern are rounded to one nanometre, derived numbers to six digits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ProcessSheet {
    /// Name of the design.
    pub name: String,
    /// Program that made the sheet.
    #[serde(flatten)]
    pub made_by: MadeBy,
    /// Seed of the design.
    pub seed: u64,
    /// Effects that the prediction leaves out.
    pub not_modelled: Vec<String>,
    /// The pattern.
    pub pattern: PatternSheet,
    /// Tolerances that the design assumes, if any.
    pub tolerances: Option<Tolerances>,
    /// The specimen and the cavities on it.
    pub specimen: SpecimenSheet,
    /// The laser, as given.
    pub laser: Laser,
    /// Bursts, lines, passes and time.
    pub work: WorkSheet,
    /// The material.
    pub material: MaterialNote,
}

/// Dimensions of the pattern.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PatternSheet {
    /// Width of a cavity along a row, in um; the diameter of a disc. Rows run along the sliding direction unless an
    /// angle is given.
    pub width_um: f64,
    /// Gap between the cavities of a row, in um.
    pub spacing_um: f64,
    /// Period of a row, width + spacing, in um.
    pub pitch_um: f64,
    /// Distance between rows, in um, if it differs from the pitch.
    pub pitch_across_um: Option<f64>,
    /// Depth, in um.
    pub depth_um: f64,
    /// Shape, arrangement, directions and rims; the height of rims is that at this depth.
    #[serde(flatten)]
    pub texture: TextureRecord,
    /// Origin of the rim dimensions; absent without rims.
    pub rim_basis: Option<String>,
    /// Fraction of the infinite pattern's area that is cavity.
    pub areal_density: f64,
}

/// The specimen and the cavities on it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SpecimenSheet {
    /// Shape and lengths.
    #[serde(flatten)]
    pub face: SpecimenRecord,
    /// Treatment of cavities that cross the border.
    pub at_the_rim: String,
    /// Arrangement of the cavities.
    pub arrangement: String,
    // In a schema a later key replaces a flattened one.
    /// Number of cavities.
    pub cavities: usize,
    /// Fraction of the specimen's face that is cavity.
    pub areal_density: f64,
    /// Area of all cavities, in mm^2.
    pub cavity_area_mm2: f64,
    /// Volume of all cavities, with walls as made by the laser, in mm^3.
    pub cavity_volume_mm3: f64,
}

impl From<&Pattern> for PatternSheet {
    fn from(pattern: &Pattern) -> Self {
        let rim = pattern.texture().rim().filter(|rim| rim.stands());
        let apart_m = pattern.pitch_across_m().filter(|&pitch_m| pitch_m != pattern.pitch_m());
        let record = TextureRecord::from(pattern);
        let rounded = |um: f64| round_decimals(um, MICROMETRE_DECIMALS);
        let corners = |corners: Vec<[f64; 2]>| corners.into_iter().map(|corner| corner.map(rounded)).collect();
        Self {
            width_um: micrometres(pattern.width_m()),
            spacing_um: micrometres(pattern.spacing_m()),
            pitch_um: micrometres(pattern.pitch_m()),
            pitch_across_um: apart_m.map(micrometres),
            depth_um: micrometres(pattern.depth_m()),
            texture: TextureRecord {
                length_um: record.length_um.map(rounded),
                vertices_um: record.vertices_um.map(corners),
                spacing_across_um: apart_m.and(pattern.spacing_across_m()).map(micrometres),
                rim_height_um: rim.map(|_| micrometres(pattern.rim_height_m())),
                rim_heights_um: None,
                rim_width_um: record.rim_width_um.map(rounded),
                rim_height_std_um: record.rim_height_std_um.map(rounded),
                ..record
            },
            rim_basis: rim.map(|_| RIM_BASIS.to_owned()),
            areal_density: six_digits(pattern.areal_density()),
        }
    }
}

impl ProcessSheet {
    /// Creates the sheet for `layout`.
    ///
    /// # Errors
    /// [`ExportError::Refused`] if a given tolerance is not positive; errors of [`Laser::validate`].
    pub fn new(layout: &Layout, input: ProcessInput) -> Result<Self, ExportError> {
        let ProcessInput { name, made_by, seed, laser, tolerances, material } = input;
        laser.validate()?;
        if let Some(Tolerances { width_um, spacing_um, depth_um, .. }) = tolerances {
            let names = ["tolerance width_um", "tolerance spacing_um", "tolerance depth_um"];
            all_positive(names.into_iter().zip([width_um, spacing_um, depth_um]))?;
        }
        let mut work = WorkSheet { warnings: burst_warnings(layout, &laser), ..WorkSheet::new(layout, &laser) };
        let depth_std_um = tolerances.as_ref().and_then(|of| of.depth_um);
        work.removal = work.removal.map(|removal| removal.with_depth_tolerance(depth_std_um));
        let pattern = layout.pattern();
        Ok(Self {
            name,
            made_by,
            seed,
            not_modelled: not_modelled(pattern.texture().rim().is_some_and(Rim::stands)).map(str::to_owned).to_vec(),
            pattern: PatternSheet::from(pattern),
            tolerances,
            specimen: SpecimenSheet {
                face: SpecimenRecord { cavities: None, ..SpecimenRecord::from(layout.specimen()) },
                at_the_rim: if layout.specimen().is_clipped { "cavities are cut" } else { "whole cavities only" }
                    .to_owned(),
                arrangement: arrangement(layout),
                cavities: layout.cavities(),
                areal_density: six_digits(layout.areal_density()),
                cavity_area_mm2: six_digits(layout.cavity_area_m2() * 1e6),
                cavity_volume_mm3: six_digits(removed_volume_m3(layout, &laser) * 1e9),
            },
            laser,
            work,
            material: (&material).into(),
        })
    }

    /// Formats the sheet as TOML.
    ///
    /// # Errors
    /// [`ExportError::Refused`] if TOML cannot hold a value.
    pub fn to_toml(&self) -> Result<String, ExportError> {
        let sliding = match self.pattern.texture.sliding_angle_deg {
            None => "x is the sliding direction".to_owned(),
            Some(angle_deg) => format!("The sliding direction lies {angle_deg} degrees from x, anticlockwise"),
        };
        sheet_toml(&sliding, self)
    }
}

/// Formats `sheet` as TOML, with the remark `sliding` on the sliding direction in a comment above it.
pub(crate) fn sheet_toml(sliding: &str, sheet: &impl Serialize) -> Result<String, ExportError> {
    let unwritable = |error| ExportError::Refused(format!("the process sheet cannot be written as TOML: {error}"));
    let body = toml::to_string(sheet).map_err(unwritable)?;
    Ok(format!("# Process sheet. {sliding}; units stand in the keys.\n{body}"))
}

fn arrangement(layout: &Layout) -> String {
    let pattern = layout.pattern();
    let ends =
        if layout.specimen().is_clipped { "each cut at the rim" } else { "each as long as fits whole on the specimen" };
    match pattern.planform() {
        Planform::Groove => {
            format!("grooves {}, one through the centre, {ends}", groove_direction(pattern.texture()))
        }
        Planform::Crosshatch => format!(
            "{}, one of each family through the centre, {ends}; where they cross the first family is cut, the second ends at its walls",
            groove_direction(pattern.texture())
        ),
        _ if layout.specimen().is_clipped => format!("{}, one cavity on the centre, cut at the rim", lattice(pattern)),
        _ => format!("{}, one cavity on the centre, only whole cavities", lattice(pattern)),
    }
}

#[cfg(test)]
pub(crate) mod tests;
