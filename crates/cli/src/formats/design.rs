//! Design files: what `optimize` takes.

mod read;

use std::path::{Path, PathBuf};

use serde::Deserialize;
use slipgrid_export::Laser;
use slipgrid_material::{Condition, ConditionRange, Friction, Material, MaterialError};
use slipgrid_optimize::{Constraints, DesignSpace, Target};
use slipgrid_pattern::Texture;
use slipgrid_springblock::{Layer, SceneError};
use toml::Spanned;

use read::{read_dimensions, read_limits, read_material_input, read_range, read_ranges, read_robust};

use super::condition_ranges::ConditionRangeFile;
use super::document::Document;
use super::file_kind::FileKind;
use super::laser::{LaserFile, SpecimenFile, check_fits, read_laser, read_specimen};
use super::limits::{LimitsFile, Measure, read_limited};
use super::material::MaterialFile;
use super::pattern::{FurtherDirections, TextureFile, read_directions, read_texture, require_section};
use super::scene::{SampleFile, default_sample, read_layer, read_pressures};
use super::target::{TargetFile, read_target};
use super::tolerances::{TolerancesFile, TolerancesInput, read_tolerances};
use super::trade_offs::{Given, TradeOffsFile, TradeOffsInput, read_trade_offs};
use super::values::{Number, Numbers, PathOr};
use crate::diagnostic::Diagnostic;
use slipgrid_calibrate::uncertainty::MaterialUncertainty;
use slipgrid_export::Specimen;
use slipgrid_units::{LENGTH_UM, PRESSURE_MPA, SPEED_MM_S, TIME_S};

/// Most model evaluations where a file names no limit.
const DEFAULT_MAX_EVALUATIONS: usize = 2000;
/// Sliding speed of the confirming run where neither condition nor target names one: the paper's.
const DEFAULT_SPEED_MM_S: f64 = 2.0;

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct DesignFile {
    name: Option<String>,
    material: Spanned<PathOr<MaterialFile>>,
    condition: Option<Spanned<ConditionRangeFile>>,
    also_at: Option<Spanned<Vec<Spanned<ConditionRangeFile>>>>,
    target: Spanned<TargetFile>,
    bounds: Spanned<BoundsFile>,
    #[serde(default = "plain_texture")]
    pattern: Spanned<TextureFile>,
    #[serde(default)]
    limits: LimitsFile,
    laser: Option<Spanned<LaserFile>>,
    specimen: Spanned<SpecimenFile>,
    #[serde(default = "default_sample")]
    sample: Spanned<SampleFile>,
    #[serde(default)]
    search: SearchFile,
    tolerances: Option<TolerancesFile>,
    trade_offs: Option<Spanned<TradeOffsFile>>,
}

/// Grooves across the sliding direction, where a design names nothing else.
fn plain_texture() -> Spanned<TextureFile> {
    Spanned::new(0..0, TextureFile::default())
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct BoundsFile {
    width_um: Spanned<Numbers>,
    spacing_um: Spanned<Numbers>,
    depth_um: Spanned<Numbers>,
}

#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct SearchFile {
    seed: Option<u64>,
    max_evaluations: Option<Spanned<u64>>,
    max_seconds: Option<Number>,
    table: Option<bool>,
    from_rest: Option<bool>,
    robust: Option<Spanned<bool>>,
    dimensions: Option<Spanned<u64>>,
}

/// Where the material comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum MaterialInput {
    /// Known already.
    Given(Box<Material>),
    /// To be calibrated from this file first.
    Calibration(PathBuf),
}

/// A design task, validated.
#[derive(Clone, Debug)]
pub struct Design {
    /// Name for reports.
    pub name: String,
    /// Where the material comes from.
    pub material: MaterialInput,
    /// Selects coefficients per condition: the one designed for. Of a range, and of a material that has to be calibrated
    /// first, known when [`Design::resolve`] has seen the measured ones.
    pub condition: Option<Condition>,
    /// Further conditions at which the target must hold: known at the same time.
    pub also_at: Vec<Condition>,
    /// Sliding directions beside the texture's own at which the target must hold, too.
    pub directions: FurtherDirections,
    /// The wanted friction.
    pub target: Target,
    /// Texture and bounds of the patterns that may be tried.
    pub space: DesignSpace,
    /// The search aims with the material's discrepancy.
    pub discrepancy: bool,
    /// What a pattern must respect beside its bounds.
    pub constraints: Constraints,
    /// What the constraints' quantities are, in their order.
    pub measures: Vec<Measure>,
    /// The laser, for the process sheet.
    pub laser: Laser,
    /// The specimen.
    pub outline: Specimen,
    /// The modelled layer.
    pub layer: Layer,
    /// Sliding speed of the confirming run, in m/s.
    pub speed_m_s: f64,
    /// Seed of search and local coefficients.
    pub seed: u64,
    /// Most evaluations of the model.
    pub max_evaluations: usize,
    /// Seconds that searches may take, confirming runs not counted; no limit when absent.
    pub max_seconds: Option<f64>,
    /// Every design of a lattice is computed, too.
    pub table: bool,
    /// Confirming runs start from an unloaded layer at rest and give static friction too.
    pub from_rest: bool,
    /// Of the designs that meet the target, the one whose samples miss it least is wanted; with tolerances only.
    pub robust: bool,
    /// Dimensions of the model, 2 or 3; what the texture needs when absent.
    pub dimensions: Option<u8>,
    /// How samples scatter about the design; nothing is said of it when absent.
    pub tolerances: Option<TolerancesInput>,
    /// By what designs are compared beside the search; nothing when absent.
    pub trade_offs: Option<TradeOffsInput>,
    /// Errors of a material that is given; a calibration finds its own.
    pub uncertainty: MaterialUncertainty,
    /// The design's file and that of its material.
    pub inputs: Vec<PathBuf>,
    document: Document,
    /// Conditions as given, with their places in the file: the one designed for first.
    ranges: Vec<(ConditionRange, std::ops::Range<usize>)>,
    condition_place: std::ops::Range<usize>,
    also_place: std::ops::Range<usize>,
    target_pressures: Spanned<Numbers>,
    discrepancy_place: std::ops::Range<usize>,
    /// Where the size of blocks stands; absent where the default holds.
    block_place: Option<std::ops::Range<usize>>,
}

impl Design {
    /// Reads the design file at `path` and the material file it names.
    ///
    /// # Errors
    /// [`Diagnostic`] for anything refused.
    pub fn read(path: &Path) -> Result<Self, Diagnostic> {
        Self::from_document(Document::read(path, FileKind::Design)?)
    }

    /// Reads a design from a document.
    ///
    /// # Errors
    /// As [`Design::read`].
    pub fn from_document(document: Document) -> Result<Self, Diagnostic> {
        let file: DesignFile = document.parse()?;
        let ranges = read_ranges(&document, &file)?;
        let target = read_target(&document, &file.target)?;
        let specimen = read_specimen(&document, &file.specimen)?;
        let layer = read_layer(&document, &file.sample, Some(&specimen))?;
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
        let texture = read_texture(&document, file.pattern.get_ref(), file.pattern.span())?;
        let directions = read_directions(&document, file.pattern.get_ref(), &texture)?;
        let dimensions = read_dimensions(&document, file.search.dimensions.as_ref())?;
        let turned = directions.different_deg.iter().filter_map(|deg| texture.with_sliding_angle_deg(*deg).ok());
        let each: Vec<Texture> = std::iter::once(texture).chain(turned).collect();
        if dimensions == Some(2) {
            each.iter().try_for_each(|texture| require_section(&document, file.pattern.get_ref(), texture))?;
        }
        // One model serves all directions: where one of them needs space, all are solved there.
        let needed = each.iter().map(Texture::dimensions).max().filter(|_| each.len() > 1);
        let dimensions = dimensions.or(needed);
        let space = DesignSpace::new(texture, width_m, spacing_m, depth_m)
            .map_err(|error| document.refuse(file.bounds.span(), error.to_string()))?;
        let limits = &file.limits;
        let laser = read_laser(&document, file.laser.as_ref(), (&limits.depth_per_burst_um, &limits.min_land_um))?;
        let limits = read_limits(&document, &file, &laser, (width_m, spacing_m, depth_m))?;
        check_fits(&document, &file.specimen, &specimen, &texture, (width_m, spacing_m, depth_m))?;
        let (measures, quantities) = read_limited(&document, &file.limits, &laser)?;
        let (material, uncertainty) = read_material_input(&document, &file.material)?;
        if let MaterialInput::Given(material) = &material {
            read_pressures(&document, &file.target.get_ref().pressure_mpa, PRESSURE_MPA, material)?;
        }
        let max_evaluations = match &file.search.max_evaluations {
            None => DEFAULT_MAX_EVALUATIONS,
            Some(most) => {
                usize::try_from(*most.get_ref()).ok().filter(|most| (1..=10_000_000).contains(most)).ok_or_else(
                    || document.refuse(most.span(), "is out of range").expected("a whole number from 1 to 10000000"),
                )?
            }
        };
        let given = Given {
            laser: &laser,
            target: &target,
            texture: space.texture(),
            has_tolerances: file.tolerances.is_some(),
        };
        let trade_offs = file.trade_offs.as_ref().map(|table| read_trade_offs(&document, table, &given)).transpose()?;
        let discrepancy = file.target.get_ref().discrepancy.as_ref();
        let named = match file.material.get_ref() {
            PathOr::Path(path) => Some(document.resolve(path)),
            PathOr::Table(_) => None,
        };
        let mut design = Self {
            inputs: std::iter::once(document.path().to_owned()).chain(named).collect(),
            name: file.name.clone().unwrap_or_else(|| document.stem()),
            material,
            condition: None,
            also_at: Vec::new(),
            directions,
            target,
            space,
            discrepancy: discrepancy.is_some_and(|wanted| *wanted.get_ref()),
            constraints: Constraints { limits, quantities },
            measures,
            laser,
            outline: specimen,
            layer,
            speed_m_s: SPEED_MM_S.to_si(DEFAULT_SPEED_MM_S),
            seed: file.search.seed.unwrap_or(1),
            max_evaluations,
            max_seconds: document.optional(file.search.max_seconds.as_ref(), TIME_S)?,
            table: file.search.table.unwrap_or(false),
            from_rest: file.search.from_rest.unwrap_or(false),
            robust: read_robust(&document, &file)?,
            dimensions,
            tolerances: file.tolerances.as_ref().map(|table| read_tolerances(&document, table)).transpose()?,
            trade_offs,
            uncertainty,
            ranges,
            condition_place: file.condition.as_ref().map_or(file.material.span(), Spanned::span),
            also_place: file.also_at.as_ref().map_or(0..0, Spanned::span),
            target_pressures: file.target.get_ref().pressure_mpa.clone(),
            discrepancy_place: discrepancy.map_or(0..0, Spanned::span),
            block_place: file.sample.get_ref().block_um.as_ref().map(Spanned::span),
            document,
        };
        if let MaterialInput::Given(material) = design.material.clone() {
            design.resolve(&material.friction)?;
            design.loads(&material)?;
            if design.discrepancy && design.uncertainty.discrepancy_at(design.humidity()).is_none() {
                return Err(
                    design.refuse_discrepancy("needs a material with a table [discrepancy], which this one lacks")
                );
            }
            if design.discrepancy && design.uncertainty.discrepancy_domain.is_none() {
                let reason = "needs to know near which patterns it holds: [[discrepancy.trials]] with planform, areal_density and \
                              depth_um of each, which this material lacks";
                return Err(design.refuse_discrepancy(reason));
            }
        }
        Ok(design)
    }

    /// Finds the conditions of all ranges at which `friction` is lowest and highest, each once, and the one designed for
    /// among those of the first.
    ///
    /// # Errors
    /// [`Diagnostic`] at a range that reaches outside the measured conditions.
    pub fn resolve(&mut self, friction: &Friction) -> Result<(), Diagnostic> {
        let Some((first, _)) = self.ranges.first() else { return Ok(()) };
        let mut all: Vec<Condition> = Vec::new();
        for (range, place) in &self.ranges {
            let refuse = |error: MaterialError| self.document.refuse(place.clone(), error.to_string());
            for condition in friction.extremes(range).map_err(refuse)? {
                if !all.iter().any(|known| known.matches(&condition)) {
                    all.push(condition);
                }
            }
            if self.condition.is_none() {
                self.condition = friction.primary(first, &all);
            }
        }
        let Some(condition) = self.condition else { return Ok(()) };
        all.retain(|other| !other.matches(&condition));
        self.also_at = all;
        self.speed_m_s = condition.speed_m_s;
        Ok(())
    }

    /// Relative humidity of the condition designed for.
    #[must_use]
    pub fn humidity(&self) -> Option<f64> {
        self.condition.map(|condition| condition.humidity)
    }

    /// The range that the design is made for, where it is one.
    #[must_use]
    pub fn range(&self) -> Option<&ConditionRange> {
        self.ranges.first().map(|(range, _)| range).filter(|range| range.is_wide())
    }

    /// The loads at the target's pressures, and whether each lies outside the measured range.
    ///
    /// # Errors
    /// [`Diagnostic`] at the condition if `material` has no coefficients for it, or at the
    /// pressures if one exceeds its modulus.
    pub fn loads(&self, material: &Material) -> Result<(Vec<slipgrid_springblock::Load>, Vec<bool>), Diagnostic> {
        read_pressures(&self.document, &self.target_pressures, PRESSURE_MPA, material)?;
        for condition in &self.also_at {
            self.loads_at(material, condition)?;
        }
        super::scene::loads(&material.friction, &self.pressures_pa(), self.condition.as_ref())
            .map_err(|error| self.document.refuse(self.condition_place.clone(), error.to_string()))
    }

    /// The same at a further condition.
    ///
    /// # Errors
    /// [`Diagnostic`] at the further conditions if `material` has no coefficients for this one.
    pub fn loads_at(
        &self,
        material: &Material,
        condition: &Condition,
    ) -> Result<(Vec<slipgrid_springblock::Load>, Vec<bool>), Diagnostic> {
        super::scene::loads(&material.friction, &self.pressures_pa(), Some(condition))
            .map_err(|error| self.document.refuse(self.also_place.clone(), error.to_string()))
    }

    /// Nominal pressures of the target, in pascals.
    #[must_use]
    pub fn pressures_pa(&self) -> Vec<f64> {
        self.target.points().iter().map(|point| point.pressure_pa).collect()
    }

    /// Refuses to aim with the discrepancy.
    #[must_use]
    pub fn refuse_discrepancy(&self, reason: &str) -> Diagnostic {
        self.document.refuse(self.discrepancy_place.clone(), reason).expected(
            "a calibration whose [measurements] or [traces] have patterned samples with a [pattern], or the material file \
             that `slipgrid calibrate` writes of it",
        )
    }

    /// Refuses the blocks, for what they make of confirming runs.
    #[must_use]
    pub fn refuse_blocks(&self, error: &SceneError) -> Diagnostic {
        let gib = |bytes: f64| bytes / (1_u64 << 30) as f64;
        let days = |seconds: f64| seconds / 86_400.0;
        let (takes, most) = match error {
            SceneError::TooLarge { bytes, most_bytes } => {
                (format!("{:.0} GiB of memory", gib(*bytes)), format!("{:.0} GiB", gib(*most_bytes)))
            }
            SceneError::TooLong { core_s, most_s } => {
                (format!("{:.0} days of one core", days(*core_s)), format!("{:.0} days", days(*most_s)))
            }
            other => return self.refuse(other.to_string()),
        };
        let reason = format!("um makes confirming runs that take about {takes}");
        let expected = format!("larger blocks, a smaller layer or a higher speed, for at most {most}");
        match &self.block_place {
            Some(place) => self.document.refuse(place.clone(), reason),
            None => Diagnostic {
                key: Some("sample.block_um".into()),
                value: Some(format!("{} (the default)", LENGTH_UM.from_si(self.layer.block_m)).into()),
                ..self.refuse(reason)
            },
        }
        .expected(expected)
    }

    /// Refuses the design as a whole, for reasons that only a solver or the search finds.
    #[must_use]
    pub fn refuse(&self, reason: impl Into<String>) -> Diagnostic {
        Diagnostic::file(self.document.path(), reason)
    }
}
