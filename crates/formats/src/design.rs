//! Design files: what `optimize` takes.

mod contradictions;
mod read;

use std::ops::Range;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use slipgrid_design::{DesignTask, Refusal, TaskPart};
use slipgrid_material::ConditionRange;
use slipgrid_optimize::{Constraints, DesignSpace};
use slipgrid_pattern::{Pattern, Texture};
use slipgrid_springblock::Dimension;
use slipgrid_units::{LENGTH_UM, MODULUS_GPA, PRESSURE_MPA, TIME_S};
use toml::Spanned;

use read::{read_date, read_dimensions, read_limits, read_material_input, read_range, read_ranges, whole_steps};

use super::condition_ranges::ConditionRangeFile;
use super::document::Document;
use super::explored::of_material;
use super::file_kind::FileKind;
use super::laser::{LaserFile, SpecimenFile, check_fits, read_laser, read_specimen, unmeasured_fluence};
use super::limits::{LimitsFile, read_limited};
use super::material::MaterialFile;
use super::pattern::{TextureFile, read_directions, read_texture, require_section};
use super::rim::read_rim;
use super::scene::{SampleFile, check_face, default_sample, read_layer};
use super::target::{TargetFile, read_target};
use super::tolerances::{TolerancesFile, read_tolerances};
use super::trade_offs::{Given, TradeOffsFile, read_trade_offs};
use super::unusual;
use super::values::{Number, Numbers, PathOr, number_span};
use crate::diagnostic::Diagnostic;
use crate::source::Source;

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct DesignFile {
    /// Name for reports; the file's name when absent.
    name: Option<String>,
    /// The day of the design, shown beside its name on the page: a date of the calendar as YYYY-MM-DD.
    date: Option<Spanned<String>>,
    /// The material: a table, the path of a material file, or that of a calibration, which is then fitted first.
    material: Spanned<PathOr<MaterialFile>>,
    /// Speed and humidity that select coefficients of a material that has them per condition.
    condition: Option<Spanned<ConditionRangeFile>>,
    /// Further conditions, or ranges of them, at which the target must hold, too.
    also_at: Option<Spanned<Vec<Spanned<ConditionRangeFile>>>>,
    /// What friction is wanted.
    target: Spanned<TargetFile>,
    /// The ranges of dimensions in which the search looks.
    bounds: Spanned<BoundsFile>,
    /// The part of the texture that is not searched; grooves across the sliding direction when absent.
    #[serde(default = "plain_texture")]
    pattern: Spanned<TextureFile>,
    /// What the laser and the surface demand.
    #[serde(default)]
    limits: LimitsFile,
    /// The laser, for the process sheet and the files that it takes.
    laser: Option<Spanned<LaserFile>>,
    /// The specimen that the pattern is laid on.
    specimen: Spanned<SpecimenFile>,
    /// The modelled layer.
    #[serde(default = "default_sample")]
    sample: Spanned<SampleFile>,
    /// How to solve, and for how long.
    #[serde(default)]
    search: SearchFile,
    /// How the mean dimensions of samples scatter; without this table the chance leaves them out.
    tolerances: Option<TolerancesFile>,
    /// A table of designs that no other beats in every goal.
    trade_offs: Option<Spanned<TradeOffsFile>>,
}

/// Grooves across the sliding direction, where a design names nothing else.
fn plain_texture() -> Spanned<TextureFile> {
    Spanned::new(0..0, TextureFile::default())
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct BoundsFile {
    /// Width of a cavity along its row: the least and the greatest, or one number, which fixes it.
    width_um: Spanned<Numbers>,
    /// Gap between two cavities of a row: the least and the greatest, or one number.
    spacing_um: Spanned<Numbers>,
    /// Depth of a cavity: the least and the greatest, or one number.
    depth_um: Spanned<Numbers>,
}

#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct SearchFile {
    /// Seed of the local coefficients; 1 when absent.
    seed: Option<u64>,
    /// Most seconds of the whole job; no limit when absent.
    max_seconds: Option<Number>,
    /// Also write what is expected of every design of whole blocks and bursts: `table.csv`; false when absent.
    table: Option<bool>,
    /// Confirm from an unloaded layer at rest, with static friction; false when absent.
    from_rest: Option<bool>,
    /// Confirm designs in space on a strip of the specimen with its own ends and margins, the row of cavities through its middle, in place of one
    /// cell: minutes in place of seconds; false when absent.
    strip: Option<Spanned<bool>>,
    /// 2 solves in the vertical plane, 3 in space; the planform decides when absent.
    dimensions: Option<Spanned<u64>>,
}

/// A design as its file has it: the task, and where its parts stand in the file.
#[derive(Clone, Debug)]
pub struct Design {
    /// The task; without its material where that has to be calibrated first.
    pub task: DesignTask,
    /// The file that the material has to be calibrated from.
    pub calibration: Option<PathBuf>,
    /// The design's file, that of its material, and the drawing of its outline.
    pub inputs: Vec<PathBuf>,
    /// What is unusual in the design's file.
    pub told: Vec<Diagnostic>,
    /// The material or calibration that was given in place of a design.
    pub(crate) stands_for: Option<PathBuf>,
    document: Document,
    places: Places,
}

/// Where parts of a task stand in the file.
#[derive(Clone, Debug)]
struct Places {
    /// Of the conditions as given: the one designed for first.
    ranges: Vec<Range<usize>>,
    condition: Range<usize>,
    also_at: Range<usize>,
    pressures: Spanned<Numbers>,
    /// Absent where the default holds.
    block: Option<Range<usize>>,
    /// Absent where the default holds.
    thickness: Option<Range<usize>>,
}

impl Design {
    /// Reads the design file at `path` and the material file it names.
    ///
    /// # Errors
    /// [`Diagnostic`] for anything refused.
    pub fn read(source: &Source, path: &Path) -> Result<Self, Diagnostic> {
        Self::from_document(Document::read(source, path, FileKind::Design)?)
    }

    /// A pattern of its texture, of the lengths that the flag `--candidate` gives.
    ///
    /// # Errors
    /// [`Diagnostic`] for what is no pattern.
    pub fn candidate(&self, text: &str) -> Result<Pattern, Diagnostic> {
        let lengths: Vec<f64> = text.split(',').filter_map(|length| length.trim().parse().ok()).collect();
        let refuse = |reason: &str| {
            Diagnostic::flag("--candidate", text.to_owned(), reason)
                .expected("width, spacing and depth in um: 100,300,10")
        };
        let [width_um, spacing_um, depth_um] = lengths[..] else { return Err(refuse("is no pattern")) };
        Pattern::new(*self.task.space.texture(), width_um * 1e-6, spacing_um * 1e-6, depth_um * 1e-6)
            .map_err(|error| refuse(&error.to_string()))
    }

    /// Reads a design from a document.
    ///
    /// # Errors
    /// As [`Design::read`].
    pub fn from_document(document: Document) -> Result<Self, Diagnostic> {
        let document = document.as_kind(FileKind::Design);
        let file: DesignFile = document.parse()?;
        let ranges = read_ranges(&document, &file)?;
        let target = read_target(&document, &file.target)?;
        let specimen = read_specimen(&document, &file.specimen)?;
        let texture = read_texture(&document, file.pattern.get_ref(), file.pattern.span())?;
        let sliding = texture.sliding_direction_on_specimen();
        let layer = read_layer(&document, &file.sample, Some((&specimen, sliding)))?;
        let bounds = file.bounds.get_ref();
        let (width_m, spacing_m, depth_m) = (
            read_range(&document, &bounds.width_um)?,
            read_range(&document, &bounds.spacing_um)?,
            read_range(&document, &bounds.depth_um)?,
        );
        if depth_m[1] >= layer.height_m {
            let layer_um = LENGTH_UM.from_si(layer.height_m);
            return Err(document
                .refuse(bounds.depth_um.span(), format!("reaches through the layer of {layer_um} um"))
                .expected(format!("depths below {layer_um} um")));
        }
        let largest_m = [width_m[1], spacing_m[1], depth_m[1]];
        let tolerances =
            file.tolerances.as_ref().map(|table| read_tolerances(&document, table, largest_m)).transpose()?;
        let texture = match file.tolerances.as_ref().and_then(|table| table.rim_height_std_um.as_ref()) {
            Some(std) if *std.get_ref() > 0.0 => {
                // Rims that are expected to be of no height may still have one.
                let rim = read_rim(&document, file.pattern.get_ref())?;
                texture.with_rim(rim.ok_or_else(|| {
                    document
                        .refuse(std.span(), "is of rims that [pattern] does not have")
                        .expected("rim_height_um and rim_width_um in [pattern], or no such key")
                })?)
            }
            _ => texture,
        };
        let directions = read_directions(&document, file.pattern.get_ref(), &texture, &specimen)?;
        let dimensions = read_dimensions(&document, file.search.dimensions.as_ref())?;
        let turned = directions.different_deg.iter().filter_map(|deg| texture.with_sliding_angle_deg(*deg).ok());
        let each: Vec<Texture> = std::iter::once(texture).chain(turned).collect();
        if dimensions.is_some_and(|asked| !Dimension::numbered(asked).sees_face()) {
            each.iter().try_for_each(|texture| require_section(&document, file.pattern.get_ref(), texture))?;
        }
        // One model serves all directions: where one of them needs space, all are solved there.
        let dimensions = dimensions.or_else(|| (each.len() > 1).then(|| Dimension::required_for(&each).number()));
        let limits = &file.limits;
        let laser = read_laser(&document, file.laser.as_ref(), (&limits.depth_per_burst_um, &limits.min_land_um))?;
        let depth_m = whole_steps(depth_m, &laser);
        let space = DesignSpace::new(texture, width_m, spacing_m, depth_m)
            .map_err(|error| document.refuse(file.bounds.span(), error.to_string()))?;
        let limits = read_limits(&document, &file, &laser, &texture, (width_m, spacing_m, depth_m))?;
        let wide = file.bounds.get_ref().width_um.span();
        check_fits(&document, (&file.specimen, wide), &specimen, &texture, (width_m, spacing_m, depth_m))?;
        check_face(&document, &file.specimen, &specimen, &layer)?;
        file.limits.check_peak(&document, &file.target.get_ref().pressure_mpa)?;
        let (measures, quantities) = read_limited(&document, &file.limits, &laser)?;
        let mut told =
            unusual::of_shares(&document, file.condition.iter().chain(file.also_at.iter().flat_map(Spanned::get_ref)));
        told.extend(unmeasured_fluence(&document, file.laser.as_ref(), &laser));
        let (known, calibration) = read_material_input(&document, &file.material, &mut told)?;
        let given = Given {
            laser: &laser,
            target: &target,
            texture: space.texture(),
            has_tolerances: file.tolerances.is_some(),
        };
        let trade_offs = file.trade_offs.as_ref().map(|table| read_trade_offs(&document, table, &given)).transpose()?;
        let named = match file.material.get_ref() {
            PathOr::Path(path) => Some(document.resolve(path)),
            PathOr::Table(_) => None,
        };
        let (ranges, places): (Vec<ConditionRange>, Vec<Range<usize>>) = ranges.into_iter().unzip();
        let task = DesignTask {
            name: file.name.clone().unwrap_or_else(|| document.stem()),
            date: file.date.as_ref().map(|date| read_date(&document, date)).transpose()?,
            material: known,
            ranges,
            directions,
            constraints: Constraints { limits, quantities },
            quantities: measures,
            laser,
            seed: file.search.seed.unwrap_or(1),
            max_seconds: document.optional(file.search.max_seconds.as_ref(), TIME_S)?,
            table: file.search.table.unwrap_or(false),
            from_rest: file.search.from_rest.unwrap_or(false),
            strip: read_strip(&document, &file, &each, dimensions)?,
            dimensions,
            tolerances,
            trade_offs,
            ..DesignTask::without_material(target, space, specimen, layer)
        };
        let places = Places {
            ranges: places,
            condition: file.condition.as_ref().map_or(file.material.span(), Spanned::span),
            also_at: file.also_at.as_ref().map_or(0..0, Spanned::span),
            pressures: file.target.get_ref().pressure_mpa.clone(),
            block: file.sample.get_ref().block_um.as_ref().map(Spanned::span),
            thickness: file.sample.get_ref().thickness_mm.as_ref().map(Spanned::span),
        };
        let drawing = file.pattern.get_ref().outline.as_ref().map(|outline| document.resolve(outline.get_ref()));
        let inputs = std::iter::once(document.path().to_owned()).chain(named).chain(drawing).collect();
        let (pattern, sample) = (file.pattern.get_ref(), file.sample.get_ref());
        told.extend(unusual::of_rims(&document, task.space.texture().rim(), pattern, sample));
        let mut design = Self { task, calibration, inputs, told, stands_for: None, document, places };
        if let Some(known) = design.task.material.clone() {
            design.task.check(&known).map_err(|refused| design.refuse(&refused))?;
            design.told.extend(design.material_told());
        }
        Ok(design)
    }

    /// What is told of the target's pressures, by Young's modulus of the material where that is known.
    fn strained(&self) -> Option<Diagnostic> {
        let material = &self.task.material.as_ref()?.material;
        let modulus_gpa = MODULUS_GPA.from_si(material.elastic.youngs_modulus_pa());
        unusual::of_pressures(&self.document, &self.places.pressures, modulus_gpa).map(|told| self.named(told))
    }

    /// What is told of the design, which may stand for a material.
    fn named(&self, told: Diagnostic) -> Diagnostic {
        match &self.stands_for {
            Some(material) => of_material(told, self.document.path(), material),
            None => told,
        }
    }

    /// Refuses the design as a whole.
    #[must_use]
    pub fn refuse_whole(&self, reason: impl Into<String>) -> Diagnostic {
        self.refuse(&Refusal::new(TaskPart::Whole, reason))
    }

    /// Where `refused` stands in the file.
    #[must_use]
    pub fn refuse(&self, refused: &Refusal) -> Diagnostic {
        let at = |place: &Range<usize>| self.document.refuse(place.clone(), refused.reason.clone());
        let whole = || Diagnostic::file(self.document.path(), refused.reason.clone());
        let found = match refused.part {
            TaskPart::Whole => whole(),
            TaskPart::ConditionRange(place) => self.places.ranges.get(place).map_or_else(whole, at),
            TaskPart::Condition => at(&self.places.condition),
            TaskPart::FurtherConditions => at(&self.places.also_at),
            TaskPart::Pressure(place) => at(&number_span(&self.places.pressures, place)),
            TaskPart::BlockSize => match &self.places.block {
                Some(place) => at(place),
                None => Diagnostic {
                    key: Some("sample.block_um".into()),
                    value: Some(format!("{} (the default)", self.task.block_um()).into()),
                    ..whole()
                },
            },
        };
        let pressure_pa = match refused.part {
            TaskPart::Pressure(place) => self.task.pressures_pa().get(place).copied(),
            _ => None,
        };
        let expected = refused.expected.as_ref().map(|expected| {
            let pressure_mpa = pressure_pa.map(|pressure_pa| PRESSURE_MPA.from_si(pressure_pa));
            pressure_mpa.map_or_else(|| expected.clone(), |at_mpa| unusual::with_slip(expected, at_mpa))
        });
        self.named(Diagnostic { expected: expected.map(Into::into), ..found })
    }
}

/// Whether a strip confirms the design: of what is solved in space, where it slides along rows or across them.
fn read_strip(
    document: &Document,
    file: &DesignFile,
    textures: &[Texture],
    dimensions: Option<u8>,
) -> Result<bool, Diagnostic> {
    let Some(strip) = file.search.strip.as_ref().filter(|strip| *strip.get_ref()) else { return Ok(false) };
    let is_in_space = dimensions.map_or_else(|| Dimension::required_for(textures), Dimension::numbered).sees_face();
    if !is_in_space {
        return Err(document
            .refuse(strip.span(), "is of designs in space: in the plane all strips of the specimen are solved")
            .expected("false"));
    }
    if textures.iter().any(Texture::slides_aslant) {
        return Err(document
            .refuse(
                strip.span(),
                "is of patterns that slide along their rows or across them: others repeat at no distance across",
            )
            .expected("false"));
    }
    Ok(true)
}
