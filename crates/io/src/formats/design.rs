//! Design files, the input of `optimize`.

mod contradictions;
mod read;

use std::ops::Range;
use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::Deserialize;
use slipgrid_base::key_error::KeyError;
use slipgrid_base::units::{LENGTH_UM, MODULUS_GPA, PRESSURE_MPA, TIME_S};
use slipgrid_design::optimize::{Constraints, DesignSpace, Tolerances};
use slipgrid_design::{DesignTask, Refusal, SearchOptions, TaskPart};
use slipgrid_laser::export::SpecimenRecord;
use slipgrid_model::material::ConditionRange;
use slipgrid_model::pattern::{Pattern, Texture};
use slipgrid_model::springblock::Dimension;

use read::{read_date, read_limits, read_material_input, read_ranges, whole_bursts};

use super::file_kind::FileKind;
use super::laser::{LaserFile, check_fits, read_laser, read_specimen, unmeasured_fluence};
use super::limits::{LimitsFile, check_tolerances, read_limited};
use super::material::MaterialFile;
use super::pattern::{TextureFile, read_directions, read_texture, require_section};
use super::scene::{SampleFile, check_face, read_layer};
use super::target::{ConditionRangeFile, TargetFile, read_target};
use super::trade_offs::{TradeOffsFile, read_trade_offs};
use super::unusual;
use super::values::{Numbers, PathOr, number_span, range};
use crate::formats::source::Source;
use crate::formats::{Diagnostic, Document, Spanned};

/// Accepted values of a key of `[bounds]`.
const BOUNDS: &str = "[smallest, largest], or one number without brackets, which fixes it";

#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct DesignFile {
    /// Name for reports; the file's name when absent.
    name: Option<String>,
    /// Date of the design, shown beside its name on the page: a calendar date as YYYY-MM-DD.
    date: Option<Spanned<String>>,
    /// The material: a table, the path of a material file, or that of a calibration, which is then fitted first.
    material: Spanned<PathOr<MaterialFile>>,
    /// Speed and humidity that select coefficients of a material with coefficients per condition.
    condition: Option<Spanned<ConditionRangeFile>>,
    /// Further conditions, or ranges of conditions, at which the target must also hold.
    also_at: Option<Spanned<Vec<Spanned<ConditionRangeFile>>>>,
    /// Friction target.
    target: Spanned<TargetFile>,
    /// Ranges of the dimensions that are searched.
    bounds: Spanned<BoundsFile>,
    /// Fixed properties of the texture, which are not searched; grooves across the sliding direction when absent.
    #[serde(default)]
    pattern: Spanned<TextureFile>,
    /// Limits set by the laser and the surface.
    #[serde(default)]
    limits: LimitsFile,
    /// The laser, for the process sheet and the laser's input files.
    laser: Option<Spanned<LaserFile>>,
    /// Specimen on which the pattern is laid out.
    specimen: Spanned<SpecimenRecord>,
    /// The modelled layer.
    #[serde(default)]
    sample: Spanned<SampleFile>,
    /// Solver options and time limit.
    #[serde(default)]
    search: Spanned<SearchOptions>,
    /// Scatter of the mean dimensions from sample to sample; without this table the chance to be on target leaves this
    /// scatter out.
    tolerances: Option<Spanned<Tolerances>>,
    /// Comparison of designs by several goals; the Pareto-optimal designs are listed, those that no other design beats
    /// in every goal.
    trade_offs: Option<Spanned<TradeOffsFile>>,
}

#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct BoundsFile {
    /// Width of a cavity along its row: minimum and maximum, or one number, which fixes it.
    width_um: Spanned<Numbers>,
    /// Gap between two cavities of a row: minimum and maximum, or one number.
    spacing_um: Spanned<Numbers>,
    /// Depth of a cavity: minimum and maximum, or one number.
    depth_um: Spanned<Numbers>,
}

/// A design read from its file: the task, and the file positions of its parts.
#[derive(Clone, Debug)]
pub struct Design {
    /// Task; without a material if the material must be calibrated first.
    pub task: DesignTask,
    /// Calibration file from which the material must be calibrated; `None` if the material is known.
    pub calibration: Option<PathBuf>,
    /// Paths of the design file, of the material or calibration file, and of the drawing of the outline.
    pub inputs: Vec<PathBuf>,
    /// Diagnostics of unusual but accepted inputs in the design file and its material.
    pub told: Vec<Diagnostic>,
    /// Path of the material or calibration that was given in place of a design; `None` for a design file.
    pub(crate) stands_for: Option<PathBuf>,
    document: Document,
    places: Places,
}

/// File positions of the parts of a task.
#[derive(Clone, Debug)]
struct Places {
    /// Positions of the conditions as given; the condition designed for is first.
    ranges: Vec<Range<usize>>,
    condition: Range<usize>,
    also_at: Range<usize>,
    pressures: Spanned<Numbers>,
}

impl Design {
    /// Reads the design file at `path` and the material file it names.
    ///
    /// # Errors
    /// [`Diagnostic`] for any refused input.
    pub fn read(source: &Source, path: &Path) -> Result<Self, Diagnostic> {
        Self::from_document(Document::read(source, path, FileKind::Design)?)
    }

    /// Pattern with the texture of the design and the lengths in `text`, the value of the flag `--candidate`: width,
    /// spacing and depth in micrometres, separated by commas.
    ///
    /// # Errors
    /// [`Diagnostic`] if `text` gives no valid pattern.
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
    /// Errors of [`Design::read`].
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
            range(&document, &bounds.width_um, LENGTH_UM, BOUNDS)?,
            range(&document, &bounds.spacing_um, LENGTH_UM, BOUNDS)?,
            range(&document, &bounds.depth_um, LENGTH_UM, BOUNDS)?,
        );
        if depth_m[1] >= layer.height_m {
            let layer_um = LENGTH_UM.from_si(layer.height_m);
            return Err(document
                .refuse(bounds.depth_um.span(), format!("reaches through the layer of {layer_um} um"))
                .expected(format!("depths below {layer_um} um")));
        }
        let largest_m = [width_m[1], spacing_m[1], depth_m[1]];
        file.tolerances.iter().try_for_each(|table| check_tolerances(&document, table, largest_m))?;
        let texture = match &file.tolerances {
            Some(table) if table.get_ref().rim_height_std_um > 0.0 => {
                // A rim of zero mean height may still scatter in height.
                let rim = file.pattern.get_ref().record.rim();
                let rim = rim.map_err(|error| document.refuse_key(&file.pattern.span(), &error))?;
                texture.with_rim(rim.ok_or_else(|| {
                    document
                        .refuse(
                            document.value_span(&table.span(), "rim_height_std_um"),
                            "is of rims that [pattern] does not have",
                        )
                        .expected("rim_height_um and rim_width_um in [pattern], or no such key")
                })?)
            }
            _ => texture,
        };
        let directions = read_directions(&document, file.pattern.get_ref(), &texture, &specimen)?;
        let search = read_search(&document, &file.search)?;
        let turned = directions.different_deg.iter().filter_map(|deg| texture.with_sliding_angle_deg(*deg).ok());
        let each: Vec<Texture> = std::iter::once(texture).chain(turned).collect();
        if search.dimensions.is_some_and(|asked| !Dimension::numbered(asked).sees_face()) {
            let table = || (file.pattern.get_ref(), file.pattern.span());
            each.iter().try_for_each(|texture| require_section(&document, table(), texture))?;
        }
        // One model serves all sliding directions: if one direction needs a three-dimensional model, all directions use
        // it.
        let dimensions =
            search.dimensions.or_else(|| (each.len() > 1).then(|| Dimension::required_for(&each).number()));
        let limits = &file.limits;
        let laser = read_laser(&document, file.laser.as_ref(), (&limits.depth_per_burst_um, &limits.min_land_um))?;
        let depth_m = whole_bursts(depth_m, &laser);
        let space = DesignSpace::new(texture, width_m, spacing_m, depth_m)
            .map_err(|error| document.refuse(file.bounds.span(), error.to_string()))?;
        let limits = read_limits(&document, &file, &laser, &texture, (width_m, spacing_m, depth_m))?;
        let wide = file.bounds.get_ref().width_um.span();
        check_fits(&document, (&file.specimen, wide), &specimen, &texture, (width_m, spacing_m, depth_m))?;
        check_face(&document, &file.specimen, &specimen, &layer)?;
        file.limits.check_peak(&document, &file.target.get_ref().pressure_mpa)?;
        let quantities = read_limited(&document, &file.limits, &laser)?;
        let mut told =
            unusual::of_shares(&document, file.condition.iter().chain(file.also_at.iter().flat_map(Spanned::get_ref)));
        told.extend(unmeasured_fluence(&document, file.laser.as_ref(), &laser));
        let (known, calibration) = read_material_input(&document, &file.material, &mut told)?;
        let has_tolerances = file.tolerances.is_some();
        let compare = |table| read_trade_offs(&document, table, &laser, &target, space.texture(), has_tolerances);
        let trade_offs = file.trade_offs.as_ref().map(compare).transpose()?;
        let named = match file.material.get_ref() {
            PathOr::Path(path) => Some(document.resolve(path)),
            PathOr::Table(_) => None,
        };
        check_strip(&document, &file.search, &each, dimensions)?;
        let (ranges, places): (Vec<ConditionRange>, Vec<Range<usize>>) = ranges.into_iter().unzip();
        let task = DesignTask {
            name: file.name.clone().unwrap_or_else(|| document.stem()),
            date: file.date.as_ref().map(|date| read_date(&document, date)).transpose()?,
            material: known,
            ranges,
            directions,
            constraints: Constraints { limits, quantities },
            laser,
            search: SearchOptions { dimensions, ..search },
            tolerances: file.tolerances.map(Spanned::into_inner),
            trade_offs,
            ..DesignTask::without_material(target, space, specimen, layer)
        };
        let places = Places {
            ranges: places,
            condition: file.condition.as_ref().map_or(file.material.span(), Spanned::span),
            also_at: file.also_at.as_ref().map_or(0..0, Spanned::span),
            pressures: file.target.get_ref().pressure_mpa.clone(),
        };
        let drawing = file.pattern.get_ref().outline.as_ref().map(|outline| document.resolve(outline.get_ref()));
        let inputs = std::iter::once(document.path().to_owned()).chain(named).chain(drawing).collect();
        let sample = file.sample.get_ref();
        told.extend(unusual::of_rims(&document, task.space.texture().rim(), &file.pattern.span(), sample));
        let mut design = Self { task, calibration, inputs, told, stands_for: None, document, places };
        if let Some(known) = design.task.material.clone() {
            design.task.check(&known).map_err(|refused| design.refuse(&refused))?;
            design.told.extend(design.material_told());
        }
        Ok(design)
    }

    /// Diagnostic if a pressure of the target is unusual, or strains the material too much; `None` if not, or if the
    /// material is unknown.
    fn strained(&self) -> Option<Diagnostic> {
        let material = &self.task.material.as_ref()?.material;
        let modulus_gpa = MODULUS_GPA.from_si(material.elastic.youngs_modulus_pa());
        unusual::of_pressures(&self.document, &self.places.pressures, modulus_gpa).map(|told| self.named(told))
    }

    /// Makes the diagnostic `told` refer to the material file if the design is the default design for a material;
    /// otherwise returns `told` unchanged.
    fn named(&self, told: Diagnostic) -> Diagnostic {
        match &self.stands_for {
            Some(material) => told.of_material(self.document.path(), material),
            None => told,
        }
    }

    /// Refuses the design as a whole.
    pub fn refuse_whole(&self, reason: impl Into<String>) -> Diagnostic {
        self.refuse(&Refusal::new(TaskPart::Whole, reason))
    }

    /// Diagnostic at the file position of the part of the task that `refused` names.
    pub fn refuse(&self, refused: &Refusal) -> Diagnostic {
        let at = |place: &Range<usize>| self.document.refuse(place.clone(), refused.reason.clone());
        let whole = || Diagnostic::file(self.document.path(), refused.reason.clone());
        let pressure_pa = match refused.part {
            TaskPart::Pressure(place) => self.task.pressures_pa().get(place).copied(),
            _ => None,
        };
        let found = match refused.part {
            TaskPart::Whole => whole(),
            TaskPart::ConditionRange(place) => self.places.ranges.get(place).map_or_else(whole, at),
            TaskPart::Condition => at(&self.places.condition),
            TaskPart::FurtherConditions => at(&self.places.also_at),
            // The task has the pressures in ascending order, the file in any.
            TaskPart::Pressure(_) => {
                let written = self.places.pressures.get_ref().written();
                let place = written.iter().position(|mpa| Some(PRESSURE_MPA.to_si(*mpa)) == pressure_pa);
                at(&number_span(&self.places.pressures, place.unwrap_or_default()))
            }
            TaskPart::BlockSize => {
                let default = self.task.block_um().to_string();
                self.document.refuse_or_default(("sample", "block_um"), Some(default), refused.reason.clone())
            }
        };
        let expected = refused.expected.clone().map(|expected| match pressure_pa {
            Some(pressure_pa) => unusual::with_slip(&expected, PRESSURE_MPA.from_si(pressure_pa)),
            None => expected,
        });
        self.named(Diagnostic { expected: expected.map(Into::into), ..found })
    }
}

/// Checks the numbers of the options of a search.
fn read_search(document: &Document, table: &Spanned<SearchOptions>) -> Result<SearchOptions, Diagnostic> {
    let search = table.get_ref();
    let time = search.max_seconds.map_or(Ok(0.0), |time_s| KeyError::number("max_seconds", time_s, TIME_S));
    let dimensions = match search.dimensions {
        None | Some(2 | 3) => Ok(()),
        Some(_) => Err(KeyError::rule("dimensions", "dimensions do not exist here", "2 or 3")),
    };
    time.and(dimensions).map_err(|error| document.refuse_key(&table.span(), &error))?;
    Ok(search.clone())
}

/// Refuses `strip = true` in `[search]` unless the model is three-dimensional and all `textures` slide along or across
/// their rows.
fn check_strip(
    document: &Document,
    search: &Spanned<SearchOptions>,
    textures: &[Texture],
    dimensions: Option<u8>,
) -> Result<(), Diagnostic> {
    if !search.get_ref().strip {
        return Ok(());
    }
    let is_in_space = dimensions.map_or_else(|| Dimension::required_for(textures), Dimension::numbered).sees_face();
    let reason = if !is_in_space {
        "is of designs in space: in the plane all strips of the specimen are solved"
    } else if textures.iter().any(Texture::slides_aslant) {
        "is of patterns that slide along their rows or across them: others repeat at no distance across"
    } else {
        return Ok(());
    };
    Err(document.refuse(document.value_span(&search.span(), "strip"), reason).expected("false"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refused_pressure_is_named_in_any_order() {
        let refused = |pressures: &str| {
            let text = format!(
                "[material]\nyoungs_modulus_gpa = 0.38\ndensity_g_cm3 = 0.9\nfriction = {{ static_mean = 0.3, dynamic_mean = 0.27 }}\n\
                 [target]\nquantity = \"ratio\"\ngoal = \"lowest\"\npressure_mpa = {pressures}\n\
                 [bounds]\nwidth_um = [40, 80]\nspacing_um = [40, 80]\ndepth_um = [2, 10]\n\
                 [specimen]\nshape = \"disc\"\ndiameter_mm = 10\n"
            );
            Design::from_document(Document::new("d.toml", text)).unwrap_err().to_string()
        };
        for pressures in ["[0.65, 300.0]", "[300.0, 0.65]", "[2.0, 300.0, 0.65]"] {
            let said = refused(pressures);
            assert!(said.starts_with("d.toml:8: target.pressure_mpa: 300.0 MPa is above 0.5 of Young's"), "{said}");
        }
    }
}
