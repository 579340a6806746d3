//! Scene files, the input of `simulate`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use slipgrid_model::material::{Condition, Material, MaterialError};
use slipgrid_model::springblock::{Layer, MAX_BLOCKS, MAX_ROWS, RunOptions, Scene, SceneError, Simulation};

use super::file_kind::FileKind;
use super::friction::check_condition;
use super::laser::read_specimen;
use super::material::{MaterialFile, read_referenced};
use super::pattern::{PatternFile, check_depth, read_pattern, require_section};
use super::relief::read_relief;
use super::run::{Overrides, read_run};
use super::stated_specimen::read_holder;
use super::unusual::{self, with_slip};
use super::values::{MAX_PRESSURES, Number, Numbers, PathOr, distinct_pressures, number_span};
use crate::formats::source::Source;
use crate::formats::{Diagnostic, Document, Spanned};
use slipgrid_base::units::{
    LENGTH_MM, LENGTH_STD_UM, LENGTH_UM, MODULUS_GPA, PRESSURE_MPA, Quantity, SPEED_MM_S, STEP_NS, significant_to, tidy,
};
use slipgrid_design::results::SimulationReport;
use slipgrid_design::{KnownMaterial, SpecimenError, TaskPart, check_pressures, correct, loads, of_scene};
use slipgrid_infer::calibrate::uncertainty::MaterialUncertainty;
use slipgrid_laser::export::{Outline, Specimen, SpecimenRecord};
use slipgrid_laser::specimen::Laid;

/// A scene in the form of its file.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SceneFile {
    /// Name for reports.
    pub name: Option<String>,
    /// Version of the file's schema; 1 when absent.
    pub schema: Option<Spanned<u32>>,
    /// Speed and humidity that select the friction coefficients of a material with coefficients per condition.
    pub condition: Option<Spanned<Condition>>,
    /// Material table, or path of a material file.
    pub material: Spanned<PathOr<MaterialFile>>,
    /// Pattern of cavities; without this table, the surface is flat.
    pub pattern: Option<Spanned<PatternFile>>,
    /// Specimen on which the pattern is laid out; without this table, the sample is one strip of length
    /// `sample.length_um`.
    pub specimen: Option<Spanned<SpecimenRecord>>,
    /// The modelled layer.
    #[serde(default)]
    pub sample: Spanned<SampleFile>,
    /// Loads and speed.
    pub load: Spanned<LoadFile>,
    /// Solver options.
    #[serde(default)]
    pub run: Spanned<RunOptions>,
}

/// The modelled layer in the form of a file.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SampleFile {
    /// Length of the modelled strip along the sliding direction, not given together with `[specimen]`; 9960 when
    /// absent.
    pub length_um: Option<Number>,
    /// Height of the layer that strips and runs in time represent by blocks; 200 or a smaller thickness when absent.
    /// If given without `thickness_mm`, only this layer is elastic.
    pub layer_um: Option<Number>,
    /// Thickness of the elastic specimen; 7 if neither `thickness_mm` nor `layer_um` is given.
    pub thickness_mm: Option<Number>,
    /// How the specimen is held: `rigid` if the holder keeps it from turning, so that friction tilts the pressure, or
    /// `self-aligning`; needs `thickness_mm`; anything between the two when absent.
    pub holder: Option<Spanned<String>>,
    /// Lattice spacing, the size of a block; 10 when absent.
    pub block_um: Option<Number>,
}

/// Thickness of the specimens of Balestra et al., J. Tribol. 144, 031704, in metres.
pub const DEFAULT_THICKNESS_M: f64 = 7e-3;

/// Layer of Balestra et al.: 996 x 20 blocks of 10 um, under a rigid bulk.
pub const DEFAULT_LAYER: Layer =
    Layer { length_m: 9960e-6, height_m: 200e-6, block_m: 10e-6, thickness_m: None, holder: None };

/// Layer of Balestra et al. as the lowest part of a specimen of the thickness `DEFAULT_THICKNESS_M`; the default for
/// files without `[sample]`.
pub const DEFAULT_SPECIMEN: Layer = Layer { thickness_m: Some(DEFAULT_THICKNESS_M), ..DEFAULT_LAYER };

/// Layer, and seed of the local coefficients, of the flat sample of a calibration that no design asks for.
pub const DEFAULT_SAMPLE: (Layer, u64) = (DEFAULT_SPECIMEN, 1);

/// Loads in the form of a file.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LoadFile {
    /// Nominal pressures, one or several.
    pub pressure_mpa: Spanned<Numbers>,
    /// Sliding speed; that of `[condition]` when absent.
    pub speed_mm_s: Option<Number>,
}

/// A scene ready to be solved, with the data for its report.
#[derive(Clone, Debug)]
pub struct SceneInput {
    /// Scene to be solved.
    pub scene: Scene,
    /// The material, with its provenance.
    pub material: Material,
    /// Uncertainty of the material.
    pub uncertainty: MaterialUncertainty,
    /// Speed and humidity that select the coefficients; `None` if the coefficients hold at any condition.
    pub condition: Option<Condition>,
    /// Specimen with the layout of the pattern that is solved; `None` if one strip or one cell is solved.
    pub specimen: Option<Specimen>,
    /// For each load, whether its coefficients are those of the nearest measured pressure, because the load lies
    /// outside the measured pressures.
    pub friction_extrapolated: Vec<bool>,
    /// Diagnostics of unusual but accepted inputs in the file and its material.
    pub told: Vec<Diagnostic>,
    document: Document,
}

impl SceneInput {
    /// Reads the scene file at `path`.
    ///
    /// # Errors
    /// [`Diagnostic`] for any refused input in the file or in a file that it names.
    pub fn read(source: &Source, path: &std::path::Path, overrides: Overrides) -> Result<Self, Diagnostic> {
        Self::from_document(Document::read(source, path, FileKind::Scene)?, overrides)
    }

    /// Reads a scene from a document.
    ///
    /// # Errors
    /// Errors of [`SceneInput::read`].
    pub fn from_document(document: Document, overrides: Overrides) -> Result<Self, Diagnostic> {
        let file: SceneFile = document.parse()?;
        document.check_schema(file.schema.as_ref())?;
        let (KnownMaterial { mut material, uncertainty }, mut told) = read_referenced(&document, &file.material)?;
        let condition = file.condition.as_ref().map(|at| check_condition(&document, at)).transpose()?;
        material.provenance.notes.extend(material.friction.interpolation(condition.as_ref()));
        let specimen = file.specimen.as_ref().map(|table| read_specimen(&document, table)).transpose()?;
        let pattern = file.pattern.as_ref().map(|pattern| read_pattern(&document, pattern)).transpose()?;
        let stds = file.pattern.iter().flat_map(|table| table.get_ref().dimensions_std());
        if let Some(std) = stds.flatten().next() {
            document.number(std, LENGTH_STD_UM)?;
            return Err(document
                .refuse(std.span(), "has no meaning in a scene, which has one pattern")
                .expected("no such line; the standard errors of samples to be cut stand in [tolerances] of a design"));
        }
        let sliding = pattern.map_or([1.0, 0.0], |pattern| pattern.texture().sliding_direction_on_specimen());
        let layer = read_layer(&document, &file.sample, specimen.as_ref().map(|specimen| (specimen, sliding)))?;
        if let Some((table, specimen)) = file.specimen.as_ref().zip(specimen.as_ref()) {
            check_face(&document, table, specimen, &layer)?;
        }
        let mut relief = None;
        if let Some((table, pattern)) = file.pattern.as_ref().zip(pattern.as_ref()) {
            check_depth(&document, table.get_ref(), pattern.depth_m(), &layer)?;
            relief = read_relief(&document, table, pattern)?;
        }
        let run = read_run(&document, &file.run, overrides, specimen.is_some())?;
        let speed_m_s = read_speed(&document, &file.load, condition.as_ref())?;
        // A scene may have zero load and zero speed: both are meaningful, though without a friction coefficient.
        let load = PRESSURE_MPA.or_zero();
        let pressures_pa = read_pressures(&document, &file.load.get_ref().pressure_mpa, load, &material)?;
        let asked = file.condition.as_ref().map_or(file.material.span(), Spanned::span);
        let (loads, friction_extrapolated) = loads(&material.friction, &pressures_pa, condition.as_ref())
            .map_err(|error| document.refuse(asked, error.to_string()))?;
        // A flat specimen is modelled as one strip, and a single period of a pattern does not reach the rim of the
        // specimen.
        let specimen = specimen.filter(|_| pattern.is_some() && run.extent.has_ends());
        let scene = Scene {
            elastic: material.elastic,
            area_law: material.area_law.clone(),
            pattern,
            relief,
            layer,
            loads,
            speed_m_s,
            run: match &pattern {
                Some(pattern) if specimen.is_some() => run.on_specimen(pattern.texture()),
                _ => run,
            },
        };
        if let Some((pattern, file)) = scene.section().zip(file.pattern.as_ref()) {
            require_section(&document, (&file.get_ref().texture, file.span()), pattern.texture())?;
        }
        let modulus_gpa = MODULUS_GPA.from_si(scene.elastic.youngs_modulus_pa());
        told.extend(unusual::of_scene(&document, &file, modulus_gpa));
        told.extend(unusual::of_speed(&document, file.load.get_ref(), &scene));
        if scene.is_strip_aslant()
            && let Some(extent) = document.place("run", "extent")
        {
            return Err(document
                .refuse(extent, "asks for a strip of a pattern that slides aslant, and repeats at no distance across")
                .expected("\"cell\", or a sliding direction along or across the rows"));
        }
        let input = Self { scene, material, uncertainty, condition, specimen, friction_extrapolated, told, document };
        input.scene.validate().map_err(|error| input.refuse(&error))?;
        Ok(input)
    }

    /// Diagnostic for an error of the solver, at the file position concerned and in the file's units.
    pub fn refuse(&self, error: &SceneError) -> Diagnostic {
        let um = |length_m: f64| LENGTH_UM.from_si(length_m);
        let at = |table, key, default: f64, reason| {
            self.document.refuse_or_default((table, key), Some(default.to_string()), reason)
        };
        let at_block = |reason| at("sample", "block_um", um(self.scene.layer.block_m), reason);
        match error {
            SceneError::TooManyBlocks { blocks, most } => {
                at_block(format!("divides the layer into {blocks:.1e} blocks"))
                    .expected(format!("a size that gives at most {most:.0e}"))
            }
            SceneError::TooLarge { bytes, most_bytes } => {
                let gib = |bytes: f64| bytes / (1_u64 << 30) as f64;
                at_block(format!("makes a lattice that takes {:.0} GiB", gib(*bytes)))
                    .expected(format!("larger blocks or a smaller layer, at most {:.0} GiB", gib(*most_bytes)))
            }
            SceneError::TooLong { core_s, most_s } => {
                let days = |seconds: f64| seconds / 86_400.0;
                let reason = format!("would take about {:.0} days of one core", days(*core_s));
                at("run", "sliding_um", um(self.scene.run.sliding_m), reason).expected(format!(
                    "less travel, larger blocks or a higher speed, at most {:.0} days",
                    days(*most_s)
                ))
            }
            SceneError::UnstableStep { step_s, limit_s, scheme } => {
                let limit_ns = significant_to(limit_s * 1e9, 4, f64::floor);
                match self.document.place("run", "step_ns") {
                    Some(step) => self
                        .document
                        .refuse(step, format!("is beyond the stability limit of the {scheme}, {limit_ns}"))
                        .expected(format!("at most {limit_ns}")),
                    // The time step is the default of the fidelity; the blocks are too small for this step.
                    None => {
                        let step_ns = STEP_NS.from_si(*step_s);
                        at_block(format!(
                            "um brings the stability limit of the {scheme} below its step of {step_ns} ns"
                        ))
                        .expected(format!("larger blocks, or run.step_ns of at most {limit_ns}"))
                    }
                }
            }
            SceneError::OutOfRange { quantity: "pitch_m", value, expected } => {
                let reason = format!("and the spacing make a pitch of {} um", um(*value));
                self.document.refuse_or_default(("pattern", "width_um"), None, reason).expected(*expected)
            }
            SceneError::Unsupported { what, instead } => {
                Diagnostic::file(self.document.path(), format!("{what} is not available")).expected(*instead)
            }
            // Numbers out of range, parts of blocks, empty lists and depths through the layer are refused by the reader.
            SceneError::OutOfRange { .. }
            | SceneError::NotWholeBlocks { .. }
            | SceneError::CavityThroughLayer { .. }
            | SceneError::NoLoads
            | SceneError::Relief(_) => Diagnostic::file(self.document.path(), error.to_string()),
        }
    }

    /// Diagnostic for an error of the solver, or of the pattern's layout on the specimen.
    pub fn refuse_on_specimen(&self, error: &SpecimenError) -> Diagnostic {
        match error {
            SpecimenError::Scene(error) => self.refuse(error),
            SpecimenError::Layout(error) => {
                self.document.refuse_or_default(("pattern", "width_um"), None, format!("um: {error}"))
            }
        }
    }

    /// Corrects the friction of `simulation`, the solution of this scene, to the calibrated friction of the flat
    /// surface (see [`correct`]), and returns it with its report. The report holds no computing time.
    ///
    /// # Errors
    /// [`MaterialError`] if the area law cannot be varied within its errors.
    pub fn report(&self, mut simulation: Simulation) -> Result<(Simulation, SimulationReport), MaterialError> {
        let (scene, condition) = (&self.scene, self.condition.as_ref());
        let pressures_pa: Vec<f64> = scene.loads.iter().map(|load| load.pressure_pa).collect();
        let excess = self.uncertainty.excess(&pressures_pa, condition);
        correct(&mut simulation, scene, excess.as_deref());
        let share = |pattern| Some(Laid::new(self.specimen.as_ref(), pattern, scene.dimension()).ok()?.share(pattern));
        let face_share = scene.pattern.as_ref().and_then(share).unwrap_or(1.0);
        let errors = of_scene(scene, &self.uncertainty, condition, (&simulation, face_share))?;
        let (provenance, outside) = (&self.material.provenance, &self.friction_extrapolated);
        let report = SimulationReport::new(scene, provenance, outside, &simulation, errors);
        Ok((simulation, report))
    }
}

/// Minimum width of the face of a specimen at its narrowest place, in blocks: a narrower face cannot be modelled as a
/// strip.
const MIN_FACE_BLOCKS: f64 = 2.0;

/// Refuses a specimen whose face is too narrow for the blocks of `layer`.
///
/// # Errors
/// [`Diagnostic`] at the table of the specimen.
pub fn check_face(
    document: &Document,
    table: &Spanned<SpecimenRecord>,
    specimen: &Specimen,
    layer: &Layer,
) -> Result<(), Diagnostic> {
    let (what, narrowest_m) = match specimen.outline {
        Outline::Disc { diameter_m } => ("diameter", diameter_m),
        Outline::Rectangle { length_m, width_m } => ("shorter side", length_m.min(width_m)),
        Outline::Ring { outer_diameter_m, inner_diameter_m } => {
            ("width from inner to outer edge", 0.5 * (outer_diameter_m - inner_diameter_m))
        }
    };
    if narrowest_m >= MIN_FACE_BLOCKS * layer.block_m {
        return Ok(());
    }
    let [narrowest_um, block_um] = [narrowest_m, layer.block_m].map(|length_m| LENGTH_UM.from_si(length_m));
    Err(document
        .refuse(table.span(), format!("has a {what} of {narrowest_um} um, of blocks of {block_um} um"))
        .expected(format!("a {what} of at least {MIN_FACE_BLOCKS} blocks, or a smaller sample.block_um")))
}

/// Reads the modelled layer and checks that it consists of whole blocks. `specimen` is a specimen with its sliding
/// direction, a unit vector; if given, the layer is as long as the specimen in this direction.
///
/// # Errors
/// [`Diagnostic`] for numbers out of range.
pub fn read_layer(
    document: &Document,
    file: &Spanned<SampleFile>,
    specimen: Option<(&Specimen, [f64; 2])>,
) -> Result<Layer, Diagnostic> {
    let sample = file.get_ref();
    let or = |value: Option<&Number>, default_m: f64| {
        document.optional(value, LENGTH_UM).map(|read| read.unwrap_or(default_m))
    };
    let block_m = or(sample.block_um.as_ref(), DEFAULT_LAYER.block_m)?;
    let length_m = match (&sample.length_um, specimen) {
        (Some(length), Some((specimen, sliding))) => {
            let length_m = specimen.outline.length_along_m(sliding);
            return Err(document
                .refuse(length.span(), "is given beside [specimen], which says how long the specimen is")
                .expected(format!(
                    "no such key: the {} is {} mm long in the sliding direction",
                    specimen.outline.name(),
                    tidy(LENGTH_MM.from_si(length_m))
                )));
        }
        // Rounded to whole blocks; strips of the layout keep their lengths.
        (None, Some((specimen, sliding))) => specimen.whole_length_m(sliding, block_m),
        (length, None) => or(length.as_ref(), DEFAULT_LAYER.length_m)?,
    };
    let thickness_m = document.optional(sample.thickness_mm.as_ref(), LENGTH_MM)?;
    let thickness_m = match &sample.layer_um {
        // A layer given alone has no elastic body above it.
        Some(_) => thickness_m,
        None => thickness_m.or(DEFAULT_SPECIMEN.thickness_m),
    };
    let lowest_m = thickness_m.map_or(DEFAULT_LAYER.height_m, |thickness_m| thickness_m.min(DEFAULT_LAYER.height_m));
    let height_m = or(sample.layer_um.as_ref(), lowest_m)?;
    let holder = read_holder(document, sample.holder.as_ref(), sample.thickness_mm.is_some())?;
    let layer = Layer { length_m, height_m, block_m, thickness_m, holder };
    let blocks = layer.blocks();
    if let (Some(given), true) = (&sample.block_um, blocks > MAX_BLOCKS) {
        return Err(document
            .refuse(given.span(), format!("divides the layer into {blocks:.1e} blocks"))
            .expected(format!("a size that gives at most {MAX_BLOCKS:.0e}")));
    }
    if let (Some(thickness), Some(thickness_m)) = (&sample.thickness_mm, thickness_m)
        && thickness_m < layer.height_m
    {
        let layer_um = LENGTH_UM.from_si(layer.height_m);
        return Err(document
            .refuse(thickness.span(), format!("mm is thinner than the layer of {layer_um} um, which is part of it"))
            .expected(format!("at least {}, or a lower layer_um", LENGTH_MM.from_si(layer.height_m))));
    }
    if let Some(thickness_m) = thickness_m.filter(|thickness_m| *thickness_m > MAX_ROWS * block_m) {
        let given = sample.thickness_mm.as_ref().or(sample.block_um.as_ref()).map_or(file.span(), Spanned::span);
        let thick_mm = LENGTH_MM.from_si(thickness_m);
        return Err(document
            .refuse(given, format!("makes more than {MAX_ROWS:.0e} rows of blocks of a specimen {thick_mm} mm thick"))
            .expected("larger blocks, a thinner specimen, or a layer_um alone"));
    }
    let block_um = LENGTH_UM.from_si(layer.block_m);
    for (name, value, length_m) in
        [("length_um", &sample.length_um, layer.length_m), ("layer_um", &sample.layer_um, layer.height_m)]
    {
        let blocks = length_m / layer.block_m;
        if blocks < 0.5 || (blocks - blocks.round()).abs() > 1e-6 * blocks {
            let named = value.as_ref().or(sample.block_um.as_ref()).map_or(file.span(), Spanned::span);
            let whole_um = LENGTH_UM.from_si(blocks.round().max(1.0) * layer.block_m);
            let length_um = LENGTH_UM.from_si(length_m);
            let reason = match value {
                Some(_) => format!("is no whole number of blocks of {block_um} um"),
                None => format!("does not divide {name}, which is {length_um} by default"),
            };
            return Err(document
                .refuse(named, reason)
                .expected(format!("a multiple of block_um, for instance {name} = {whole_um}")));
        }
    }
    Ok(layer)
}

/// Reads nominal pressures in the range of `quantity`, in pascals, and checks them against the elastic modulus.
///
/// # Errors
/// [`Diagnostic`] if numbers are out of range, or if a pressure is repeated.
fn read_pressures(
    document: &Document,
    pressures: &Spanned<Numbers>,
    quantity: Quantity,
    material: &Material,
) -> Result<Vec<f64>, Diagnostic> {
    let read = distinct_pressures(document, pressures, quantity, MAX_PRESSURES)?;
    check_pressures(&read, material).map_err(|refused| {
        let place = if let TaskPart::Pressure(place) = refused.part { place } else { 0 };
        let expected = refused.expected.map(|expected| with_slip(&expected, PRESSURE_MPA.from_si(read[place])));
        Diagnostic {
            expected: expected.map(Into::into),
            ..document.refuse(number_span(pressures, place), refused.reason)
        }
    })?;
    Ok(read)
}

fn read_speed(document: &Document, load: &Spanned<LoadFile>, condition: Option<&Condition>) -> Result<f64, Diagnostic> {
    match (&load.get_ref().speed_mm_s, condition) {
        (None, None) => Err(document.missing(load.span(), "speed_mm_s")),
        (None, Some(condition)) => Ok(condition.speed_m_s),
        (Some(speed), condition) => {
            let speed_m_s = document.number(speed, SPEED_MM_S.or_zero())?;
            // A run in time may be slower, as that of a design in which the modelled layer would slide in waves.
            let other = condition.filter(|condition| speed_m_s > (1.0 + 1e-6) * condition.speed_m_s);
            other.map_or(Ok(speed_m_s), |condition| {
                Err(document
                    .refuse(speed.span(), "mm/s is more than the speed of the condition that selects the coefficients")
                    .expected(format!("at most {}, or no such key", SPEED_MM_S.from_si(condition.speed_m_s))))
            })
        }
    }
}
