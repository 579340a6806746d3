//! Design task: target friction, material, and allowed designs.

use crate::optimize::{Constraints, DesignSpace, Target, Tolerances};
use crate::results::beyond_measured_range;
use schemars::JsonSchema;
use serde::Deserialize;
use slipgrid_base::units::{LENGTH_UM, PRESSURE_MPA, in_digits, tidy};
use slipgrid_infer::calibrate::uncertainty::MaterialUncertainty;
use slipgrid_laser::export::{Laser, Specimen, Tolerances as SheetTolerances, laser_time_s};
use slipgrid_model::material::{Condition, ConditionRange, Friction, Material, MaterialError};
use slipgrid_model::pattern::Pattern;
use slipgrid_model::springblock::{Layer, Load, RunOptions, Scene, read_dimensions};

use crate::error::{Refusal, TaskPart};

/// Design task. [`DesignTask::new`] gives the defaults of optional fields.
#[derive(Clone, Debug)]
pub struct DesignTask {
    /// Name for reports.
    pub name: String,
    /// Date of the task for reports, as YYYY-MM-DD, if given; no code here reads a clock.
    pub date: Option<String>,
    /// Material, from which friction at the conditions of the task follows; jobs refuse a task without a material.
    pub material: Option<KnownMaterial>,
    /// Whether the material was computed from the calibration that the design file names, and not read from a material file.
    pub is_calibrated: bool,
    /// Conditions at which the target must hold, the design condition first; empty if the material has coefficients for
    /// one condition only.
    pub ranges: Vec<ConditionRange>,
    /// Design condition; if a range of conditions is given, [`DesignTask::resolve`] chooses it. `None` before, and for
    /// a material with coefficients for one condition only.
    pub condition: Option<Condition>,
    /// Further conditions at which the target must hold, known after [`DesignTask::resolve`].
    pub also_at: Vec<Condition>,
    /// Sliding directions besides the texture's own at which the target must hold.
    pub directions: FurtherDirections,
    /// Target friction.
    pub target: Target,
    /// Texture, and bounds of width, spacing and depth, of the patterns to search.
    pub space: DesignSpace,
    /// Constraints besides the bounds.
    pub constraints: Constraints,
    /// Laser settings, for laser times, depth steps and the process sheet.
    pub laser: Laser,
    /// Specimen that the design is cut into.
    pub specimen: Specimen,
    /// Modelled layer of the specimen, with its block size.
    pub layer: Layer,
    /// Sliding speed of the confirming run, in m/s.
    pub speed_m_s: f64,
    /// Solver options and time limit.
    pub search: SearchOptions,
    /// Whether to compute predictions for all designs within the bounds, for interactive pages.
    pub explorer: bool,
    /// Scatter of the mean dimensions of samples about the design; zero when absent.
    pub tolerances: Option<Tolerances>,
    /// Goals of the trade-offs; none when absent.
    pub trade_offs: Option<TradeOffsWanted>,
}

/// Solver options and time limit of a design.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SearchOptions {
    /// Seed of the local coefficients; 1 when absent.
    pub seed: u64,
    // In seconds.
    /// Time limit of the whole job; no limit when absent.
    pub max_seconds: Option<f64>,
    /// Also write the predictions for every design of whole blocks and bursts to `table.csv`; false when absent.
    pub table: bool,
    /// Start the confirming run from an unloaded layer at rest, with static friction; false when absent.
    pub from_rest: bool,
    /// Confirm designs in space on a strip of the specimen with its ends and margins, along the row of cavities through
    /// its middle, instead of on one cell; takes minutes instead of seconds; false when absent.
    pub strip: bool,
    /// 2 solves in the vertical plane, 3 in space; the planform decides when absent.
    #[schemars(with = "Option<u64>")]
    #[serde(deserialize_with = "read_dimensions")]
    pub dimensions: Option<u8>,
}

impl Default for SearchOptions {
    fn default() -> Self {
        Self { seed: 1, max_seconds: None, table: false, from_rest: false, strip: false, dimensions: None }
    }
}

impl SearchOptions {
    /// Shortens the time limit by the `spent_s` seconds before the job, for example of a calibration.
    pub fn take_seconds(&mut self, spent_s: f64) {
        self.max_seconds = self.max_seconds.map(|most_s| (most_s - spent_s).max(0.0));
    }
}

/// Material with its uncertainty.
#[derive(Clone, Debug, PartialEq)]
pub struct KnownMaterial {
    /// The material.
    pub material: Material,
    /// Uncertainty of the material data.
    pub uncertainty: MaterialUncertainty,
}

impl From<Material> for KnownMaterial {
    /// Takes a material as exact.
    fn from(material: Material) -> Self {
        Self { material, uncertainty: MaterialUncertainty::default() }
    }
}

/// Sliding directions of a texture besides its own.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FurtherDirections {
    /// Directions that differ from the texture's own and from each other, in degrees.
    pub different_deg: Vec<f64>,
    /// Directions that are equivalent to another direction by symmetry, in degrees.
    pub alike_deg: Vec<f64>,
}

/// Goal of trade-offs: a quantity to minimize, except the chance, which is maximized.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TradeOffGoal {
    /// Chance that a cut sample is on target.
    Chance,
    /// Largest distance over all loads of the median of samples from the middle of the target, in tolerances. For a
    /// single limit the distance is 1 at the limit and 0 from one margin inside.
    Misfit,
    /// Laser time for the specimen, in seconds.
    LaserTime,
    /// Volume of the cavities on the specimen, in cubic millimetres.
    Volume,
    /// Largest local pressure at any target pressure, in megapascals.
    PeakPressure,
    /// Root mean square over all loads of the standard deviation of the target's quantity between samples, in
    /// tolerances.
    Spread,
}

// Names of the goals' columns in trade-offs.csv, with the unit.
slipgrid_base::names!(TradeOffGoal {
    Chance = "chance",
    Misfit = "misfit_tolerances",
    LaserTime = "laser_time_s",
    Volume = "volume_mm3",
    PeakPressure = "peak_pressure_mpa",
    Spread = "spread_tolerances",
});

impl TradeOffGoal {
    /// Description of the goal with the unit; a shorter one, and the unit.
    pub const fn words(self) -> [&'static str; 3] {
        match self {
            Self::Chance => ["chance that a cut sample is on target", "chance", ""],
            Self::Misfit => ["largest distance from the target (tolerances)", "distance from the target", "tolerances"],
            Self::LaserTime => ["time under the laser (s)", "laser time", "s"],
            Self::Volume => ["volume of cavities (mm3)", "volume", "mm3"],
            Self::PeakPressure => ["largest local pressure (MPa)", "peak pressure", "MPa"],
            Self::Spread => ["standard deviation over samples (tolerances)", "spread", "tolerances"],
        }
    }
}

/// Goals of the trade-offs, and the number of designs to compare.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TradeOffsWanted {
    /// Two or three goals.
    pub goals: Vec<TradeOffGoal>,
    /// Approximate number of designs to compare, spread over the bounds.
    pub designs: usize,
}

/// Sliding speed of the confirming run if neither condition nor target gives one, in m/s: the speed of Balestra et al.
pub const DEFAULT_SPEED_M_S: f64 = 2e-3;

/// Origin of the manufacturing tolerances, as the process sheet states it.
pub(crate) const SCATTER_BASIS: &str = "standard deviation of a sample's mean, as the design file gives it";

impl DesignTask {
    /// Laser time for `pattern` on the specimen, in seconds; `None` if the laser's speed is unknown or `pattern` does
    /// not fit.
    pub fn laser_time_s(&self, pattern: &Pattern) -> Option<f64> {
        laser_time_s(&self.specimen.layout(*pattern).ok()?, &self.laser)
    }

    /// Assumed manufacturing tolerances, as written to files for the laser; `None` if all are zero or absent.
    pub fn assumed_tolerances(&self) -> Option<SheetTolerances> {
        let Tolerances { width_std_um, spacing_std_um, depth_std_um, .. } = self.tolerances?;
        let given = |std_um: f64| Some(tidy(std_um)).filter(|std_um| *std_um > 0.0);
        let [width_um, spacing_um, depth_um] = [width_std_um, spacing_std_um, depth_std_um].map(given);
        let basis = SCATTER_BASIS.to_owned();
        [width_um, spacing_um, depth_um].iter().any(Option::is_some).then_some(SheetTolerances {
            width_um,
            spacing_um,
            depth_um,
            basis,
        })
    }

    /// Creates the task of a pattern of `space` that brings `material` to `target` on `specimen` with the modelled layer
    /// `layer`; other fields have the simplest values: one condition, no limits except the bounds, no tolerances.
    pub fn new(
        material: impl Into<KnownMaterial>,
        target: Target,
        space: DesignSpace,
        specimen: Specimen,
        layer: Layer,
    ) -> Self {
        Self { material: Some(material.into()), ..Self::without_material(target, space, specimen, layer) }
    }

    /// Creates the task without a material.
    pub fn without_material(target: Target, space: DesignSpace, specimen: Specimen, layer: Layer) -> Self {
        Self {
            name: "design".to_owned(),
            date: None,
            material: None,
            is_calibrated: false,
            ranges: Vec::new(),
            condition: None,
            also_at: Vec::new(),
            directions: FurtherDirections::default(),
            target,
            space,
            constraints: Constraints::default(),
            laser: Laser::default(),
            specimen,
            layer,
            speed_m_s: DEFAULT_SPEED_M_S,
            search: SearchOptions::default(),
            explorer: false,
            tolerances: None,
            trade_offs: None,
        }
    }

    /// Finds conditions of all ranges that include the lowest and highest `friction`, each once, and humidities between
    /// them. Chooses the design condition among those of the first range, unless it is already set, and sets the others as
    /// further conditions. Does nothing without ranges.
    ///
    /// # Errors
    /// [`Refusal`] of a range that reaches outside the measured conditions.
    pub fn resolve(&mut self, friction: &Friction) -> Result<(), Refusal> {
        let Some(first) = self.ranges.first() else { return Ok(()) };
        let mut all: Vec<Condition> = Vec::new();
        for (place, range) in self.ranges.iter().enumerate() {
            let refuse = |error: MaterialError| Refusal::new(TaskPart::ConditionRange(place), error.to_string());
            let extremes = friction.extremes(range).map_err(refuse)?;
            if self.condition.is_none() {
                self.condition = friction.primary(first, &extremes);
            }
            for condition in with_humidities_between(&extremes) {
                if !all.iter().any(|known| known.matches(&condition)) {
                    all.push(condition);
                }
            }
        }
        let Some(condition) = self.condition else { return Ok(()) };
        all.retain(|other| !other.matches(&condition));
        self.also_at = all;
        self.speed_m_s = condition.speed_m_s;
        Ok(())
    }

    /// Range that the design condition was chosen from; `None` if a single condition was given.
    pub fn range(&self) -> Option<&ConditionRange> {
        self.ranges.first().filter(|range| range.is_wide())
    }

    /// Returns the loads at the target's pressures, and whether each lies outside the measured range of `material`.
    ///
    /// # Errors
    /// [`Refusal`] of a condition for which `material` has no coefficients, or of a pressure above [`MAX_STRAIN`] times
    /// the modulus.
    pub fn loads(&self, material: &Material) -> Result<(Vec<Load>, Vec<bool>), Refusal> {
        check_pressures(&self.pressures_pa(), material)?;
        for condition in &self.also_at {
            self.loads_at(material, condition)?;
        }
        loads(&material.friction, &self.pressures_pa(), self.condition.as_ref())
            .map_err(|error| Refusal::new(TaskPart::Condition, error.to_string()))
    }

    /// Range of pressures at which friction was measured at the design condition, in MPa; `None` if no entry of
    /// `outside` is true, or if the range is unknown.
    pub fn measured_mpa(&self, material: &Material, outside: &[bool]) -> Option<[f64; 2]> {
        let measured_pa = material.friction.measured_pressures_pa(self.condition.as_ref());
        let rounded = |pressure_pa: f64| (1e3 * PRESSURE_MPA.from_si(pressure_pa)).round() / 1e3;
        measured_pa.filter(|_| outside.contains(&true)).map(|ends_pa| ends_pa.map(rounded))
    }

    /// Target pressures that `outside` marks as outside the measured range, in words; `None` if there are none.
    pub fn beyond_measured(&self, material: &Material, outside: &[bool]) -> Option<String> {
        let pressures = self.pressures_pa().into_iter().zip(outside).filter(|(_, is_outside)| **is_outside);
        let beyond_mpa: Vec<f64> = pressures.map(|(pressure_pa, _)| tidy(PRESSURE_MPA.from_si(pressure_pa))).collect();
        beyond_measured_range(&beyond_mpa, self.measured_mpa(material, outside))
    }

    /// Returns the loads at a further `condition`.
    ///
    /// # Errors
    /// [`Refusal`] of the further conditions if `material` has no coefficients for `condition`.
    pub fn loads_at(&self, material: &Material, condition: &Condition) -> Result<Vec<Load>, Refusal> {
        loads(&material.friction, &self.pressures_pa(), Some(condition))
            .map(|(loads, _)| loads)
            .map_err(|error| Refusal::new(TaskPart::FurtherConditions, error.to_string()))
    }

    /// Nominal pressures of the target, in pascals.
    pub fn pressures_pa(&self) -> Vec<f64> {
        self.target.points().iter().map(|point| point.pressure_pa).collect()
    }

    /// Resolves the conditions of the task, and checks that conditions and pressures are compatible with the material
    /// `known`.
    ///
    /// # Errors
    /// [`Refusal`] of the first part that is incompatible.
    pub fn check(&mut self, known: &KnownMaterial) -> Result<(), Refusal> {
        check_pressures(&self.pressures_pa(), &known.material)?;
        self.resolve(&known.material.friction)?;
        self.loads(&known.material).map(|_| ())
    }

    /// Flat scene of this task, with `material` at `loads`.
    pub fn flat_scene(&self, material: &Material, loads: Vec<Load>, run: RunOptions) -> Scene {
        Scene {
            elastic: material.elastic,
            area_law: material.area_law.clone(),
            pattern: None,
            relief: None,
            layer: self.layer,
            loads,
            speed_m_s: self.speed_m_s,
            run,
        }
    }

    /// Block size, in micrometres.
    pub fn block_um(&self) -> f64 {
        LENGTH_UM.from_si(self.layer.block_m)
    }
}

/// Maximum difference of computed humidities in a range. The model's error is another one at each humidity
/// (`Hyperparameters::humidity_length`): the chance at humidities in such steps is at most 0.02 above that of the whole
/// range (`the_chance_over_a_range_of_humidities_does_not_depend_on_how_many_are_computed`).
const HUMIDITY_STEP: f64 = 0.2;

/// Adds humidities to `conditions`, sorted by speed and humidity, so that those at one speed differ by at most
/// [`HUMIDITY_STEP`].
fn with_humidities_between(conditions: &[Condition]) -> Vec<Condition> {
    let mut all: Vec<Condition> = Vec::new();
    for own in conditions {
        if let Some(last) = all.last().copied().filter(|last| last.speed_m_s == own.speed_m_s) {
            let apart = own.humidity - last.humidity;
            let steps = (apart / HUMIDITY_STEP - 1e-9).ceil().max(1.0);
            // At most five, so the cast is exact.
            let at = |step: u32| tidy(last.humidity + apart * f64::from(step) / steps);
            all.extend((1..steps as u32).map(|step| Condition { humidity: at(step), ..*own }));
        }
        all.push(*own);
    }
    all
}

/// Maximum ratio of nominal pressure to Young's modulus in measurements and designs: beyond it no solid is linear
/// elastic.
pub const MAX_STRAIN: f64 = 0.5;

/// Checks that a specimen of `material` bears every nominal pressure, in pascals.
///
/// # Errors
/// [`Refusal`] of the first pressure that is above [`MAX_STRAIN`] times Young's modulus.
pub fn check_pressures(pressures_pa: &[f64], material: &Material) -> Result<(), Refusal> {
    let modulus_pa = material.elastic.youngs_modulus_pa();
    let Some(place) = pressures_pa.iter().position(|&pressure_pa| pressure_pa > MAX_STRAIN * modulus_pa) else {
        return Ok(());
    };
    let in_mpa = |pa: f64| in_digits(tidy(PRESSURE_MPA.from_si(pa)));
    let [modulus_mpa, most_mpa] = [modulus_pa, MAX_STRAIN * modulus_pa].map(in_mpa);
    let reason = format!(
        "MPa is above {MAX_STRAIN} of Young's modulus, {modulus_mpa} MPa, where no solid is linear elastic and no friction is measured"
    );
    Err(Refusal::new(TaskPart::Pressure(place), reason).expected(format!("at most {most_mpa} MPa")))
}

/// Builds the loads of a scene: coefficients of `friction` at each pressure, and whether each was extrapolated from the
/// measured range.
///
/// # Errors
/// [`MaterialError`] if `friction` has coefficients per condition, and none for `condition`.
pub fn loads(
    friction: &Friction,
    pressures_pa: &[f64],
    condition: Option<&Condition>,
) -> Result<(Vec<Load>, Vec<bool>), MaterialError> {
    let mut loads = Vec::new();
    let mut outside = Vec::new();
    for &pressure_pa in pressures_pa {
        let at = friction.at(pressure_pa, condition)?;
        loads.push(Load { pressure_pa, friction: at.friction });
        outside.push(at.outside_measured_range);
    }
    Ok((loads, outside))
}
