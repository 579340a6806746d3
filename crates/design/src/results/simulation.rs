//! Record of a simulation, and its table.

use std::borrow::Cow;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use slipgrid_model::material::Provenance;
use slipgrid_model::pattern::Pattern;
use slipgrid_model::springblock::{Correction, Effect, LoadOutcome, Scene, Simulation, Status};

use super::MadeBy;
use super::corrected::CorrectedReport;
use super::errors::ErrorsReport;
use super::notes::ABOUT_MATERIAL;
use super::pattern::PatternReport;
use slipgrid_base::units::{LENGTH_UM, PRESSURE_MPA, tidy};

/// Results of a simulated scene, as `simulate --json` prints them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SimulationReport {
    /// Program that made the result.
    #[serde(flatten)]
    pub made_by: MadeBy,
    /// Fidelity: `steady`, `dynamic` or `reference`.
    pub fidelity: Cow<'static, str>,
    /// Extent of the model: `cell`, `sample` or `strip`.
    pub extent: Cow<'static, str>,
    /// Dimensions of the model, 2 or 3.
    pub dimensions: u8,
    /// Modelling decisions with reasons.
    pub model: Vec<String>,
    /// Numerical method.
    #[serde(default)]
    pub method: Vec<String>,
    /// Material and its provenance.
    pub material: Provenance,
    /// Texture; null for a flat scene.
    pub pattern: Option<PatternReport>,
    /// True if the vertical plane is a section of a planform that needs three dimensions.
    pub section_model: bool,
    /// Areal density: share of a period of the infinite pattern that is cavity; null for a flat scene.
    pub areal_density: Option<f64>,
    /// Share of the modelled section that is cavity; null for a flat scene.
    pub section_density: Option<f64>,
    /// Block size.
    pub block_um: f64,
    /// Sliding speed.
    pub speed_mm_s: f64,
    /// Seed of the local coefficients.
    pub seed: u64,
    /// Number of surfaces, each with its own draw of local coefficients, over which results are averaged.
    pub draws: u64,
    /// Duration of the computation, in seconds; timings.json has it with the number of threads.
    #[serde(default)]
    pub wall_s: f64,
    /// Number of threads used.
    #[serde(default)]
    pub threads: usize,
    /// Results, one entry per pressure, in the order of the scene.
    pub results: Vec<LoadReport>,
    /// Errors of the results.
    pub errors: ErrorsReport,
    /// Ratio and friction corrected by the discrepancy of the material's patterned samples; null for a flat scene, and
    /// if no trials are known.
    pub discrepancy: Option<CorrectedReport>,
}

/// Reasons to doubt results computed with `material`, one sentence each.
pub fn material_doubts(material: &Provenance) -> impl Iterator<Item = String> {
    let synthetic = material.synthetic_surface.then(|| SYNTHETIC_SURFACE.to_owned());
    synthetic.into_iter().chain(material.warnings.iter().map(|words| format!("{ABOUT_MATERIAL}{words}")))
}

/// Formats the range of pressures at which friction was measured.
pub fn measured_range([low_mpa, high_mpa]: [f64; 2]) -> String {
    let range = if low_mpa == high_mpa { "at".to_owned() } else { format!("from {low_mpa} to") };
    format!("friction was measured {range} {high_mpa} MPa")
}

/// Results at one pressure.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LoadReport {
    /// Nominal pressure.
    pub pressure_mpa: f64,
    /// Dynamic friction coefficient; null if the run has none, for the reason in `status`.
    pub mu_dynamic: Option<f64>,
    /// Standard error of `mu_dynamic`; null for steady runs.
    pub mu_dynamic_stderr: Option<f64>,
    /// Friction force across the sliding direction over normal force; only for dynamic runs in three dimensions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mu_across: Option<f64>,
    /// Static friction coefficient; null for steady runs.
    pub mu_static: Option<f64>,
    /// Dynamic friction coefficient of the flat surface; null for a flat scene.
    pub mu_flat: Option<f64>,
    /// Standard error of `mu_flat`; null for steady runs and flat scenes.
    pub mu_flat_stderr: Option<f64>,
    /// Static friction coefficient of the flat surface; null for steady runs and flat scenes.
    pub mu_flat_static: Option<f64>,
    /// Dynamic friction of the patterned over the flat surface, in a section model that of the section; null if either
    /// value is missing.
    pub ratio: Option<f64>,
    /// Standard error of `ratio` from the run; null for steady runs.
    pub ratio_stderr: Option<f64>,
    /// Changes of the ratio by effects that the solved blocks leave out. `ratio` includes these changes.
    pub corrections: Vec<Correction>,
    /// Ratio of the surface in a section model, with the strips between rows of cavities counted as flat.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ratio_strip_estimate: Option<f64>,
    /// Maximum local pressure; it increases as blocks shrink.
    pub peak_pressure_mpa: f64,
    /// Number of contact blocks under tension.
    pub tension_blocks: usize,
    /// Status at the end of the run.
    pub status: Cow<'static, str>,
    /// Status at the end of the flat surface's run; null for a flat scene.
    pub status_flat: Option<Cow<'static, str>>,
    /// True if the ceiling of a cavity reaches the counterface.
    pub cavity_closed: bool,
    /// True if a local pressure exceeds the highest pressure of the area law.
    pub area_law_extrapolated: bool,
    /// True if the nominal pressure is outside the measured range of the friction coefficients.
    pub friction_extrapolated: bool,
    /// Bound on the convergence error of mu; null for dynamic runs.
    pub residual: Option<f64>,
    /// Number of iterations of a steady run.
    pub iterations: usize,
    /// Start of the time over which `mu_dynamic` is averaged, in seconds since the drive started; it ends with the run.
    /// Null for steady runs.
    pub averaged_from_s: Option<f64>,
    /// Start of the averaging time of the flat surface, in seconds since the drive started.
    pub averaged_from_s_flat: Option<f64>,
    /// Number of time steps of a dynamic run; null for steady runs.
    pub steps: Option<u64>,
    /// Time step of a dynamic run, in seconds; null for steady runs.
    pub dt_s: Option<f64>,
    /// Number of site updates of a dynamic run, blocks times force evaluations; null for steady runs.
    pub site_updates: Option<u64>,
    /// Site updates per second; null for steady runs.
    pub site_updates_per_s: Option<f64>,
}

impl LoadReport {
    /// Estimated bound on the difference of the ratio from its limit for vanishing blocks, two standard deviations;
    /// `None` if unknown.
    pub fn blocks_error(&self) -> Option<f64> {
        let blocks = self.corrections.iter().find(|correction| correction.effect == Effect::Blocks);
        blocks.and_then(|blocks| blocks.std).map(|std| 2.0 * std)
    }

    /// Creates the record of `load`. `pattern` is given if the vertical plane is a section of it.
    pub fn new(load: &LoadOutcome, pattern: Option<&Pattern>, friction_extrapolated: bool) -> Self {
        let (surface, flat) = (&load.surface, load.flat.as_ref());
        let strip = pattern.zip(load.ratio());
        let cost = surface.cost;
        Self {
            pressure_mpa: PRESSURE_MPA.from_si(load.pressure_pa),
            mu_dynamic: surface.mu_dynamic,
            mu_dynamic_stderr: surface.mu_dynamic_stderr,
            mu_across: surface.mu_across,
            mu_static: surface.mu_static,
            mu_flat: flat.and_then(|flat| flat.mu_dynamic),
            mu_flat_stderr: flat.and_then(|flat| flat.mu_dynamic_stderr),
            mu_flat_static: flat.and_then(|flat| flat.mu_static),
            ratio: load.ratio(),
            ratio_stderr: load.ratio_stderr,
            corrections: load.corrections().to_vec(),
            ratio_strip_estimate: strip.map(|(pattern, ratio)| pattern.strip_estimate(ratio)),
            peak_pressure_mpa: PRESSURE_MPA.from_si(surface.peak_pressure_pa),
            tension_blocks: surface.tension_blocks,
            status: surface.status.name().into(),
            status_flat: flat.map(|flat| flat.status.name().into()),
            cavity_closed: surface.cavity_closed,
            area_law_extrapolated: surface.area_law_extrapolated || flat.is_some_and(|flat| flat.area_law_extrapolated),
            friction_extrapolated,
            residual: surface.residual,
            iterations: surface.iterations,
            averaged_from_s: surface.averaged_from_s.map(tidy),
            averaged_from_s_flat: flat.and_then(|flat| flat.averaged_from_s).map(tidy),
            steps: cost.map(|cost| cost.steps),
            dt_s: cost.map(|cost| cost.dt_s),
            site_updates: cost.map(|cost| cost.site_updates),
            site_updates_per_s: cost
                .filter(|cost| cost.wall_s > 0.0)
                .map(|cost| cost.site_updates as f64 / cost.wall_s),
        }
    }
}

/// Creates the records of all loads of `simulation`. `pattern` is given if the vertical plane is a section of it;
/// `outside` holds, for each load, whether its friction was extrapolated.
pub fn load_reports(simulation: &Simulation, pattern: Option<&Pattern>, outside: &[bool]) -> Vec<LoadReport> {
    let flags = outside.iter().copied().chain(std::iter::repeat(false));
    simulation.loads.iter().zip(flags).map(|(load, outside)| LoadReport::new(load, pattern, outside)).collect()
}

/// Doubt about an area law from an altitude map that was not measured.
const SYNTHETIC_SURFACE: &str =
    "the altitude map is synthetic, not measured: map a flat sample, since every ratio rests on it";

/// Statement that the model is a vertical section of `pattern`, although this needs three dimensions.
pub fn section_note(pattern: &Pattern) -> String {
    format!(
        "section model: {} cavities are modelled by the vertical section through their centres, as grooves: {:.2} % \
         of the section, {:.2} % of the surface; `ratio` is the section's, `ratio_strip_estimate` counts the strips \
         between rows of cavities as flat",
        pattern.planform(),
        100.0 * pattern.section_density(),
        100.0 * pattern.areal_density(),
    )
}

impl SimulationReport {
    /// Creates the record of the solved `scene` with its errors and corrected results. `outside` holds, for each load,
    /// whether its friction was extrapolated.
    pub fn new(
        scene: &Scene,
        provenance: &Provenance,
        outside: &[bool],
        simulation: &Simulation,
        (errors, discrepancy): (ErrorsReport, Option<CorrectedReport>),
    ) -> Self {
        let pattern = scene.pattern.as_ref();
        let section = scene.section();
        Self {
            made_by: MadeBy::slipgrid(super::SCHEMA),
            fidelity: scene.run.fidelity.name().into(),
            extent: scene.run.extent.name().into(),
            dimensions: scene.dimension().number(),
            model: simulation.statements.model.iter().cloned().chain(section.map(section_note)).collect(),
            method: simulation.statements.method.clone(),
            material: provenance.clone(),
            pattern: pattern.map(PatternReport::from),
            section_model: section.is_some(),
            areal_density: pattern.map(|pattern| tidy(pattern.areal_density())),
            section_density: pattern.map(|pattern| tidy(pattern.section_density())),
            block_um: LENGTH_UM.from_si(scene.layer.block_m),
            speed_mm_s: slipgrid_base::units::SPEED_MM_S.from_si(scene.speed_m_s),
            seed: scene.run.seed,
            draws: scene.run.draws,
            wall_s: 0.0,
            threads: 1,
            results: load_reports(simulation, section, outside),
            errors,
            discrepancy,
        }
    }

    /// Reasons to doubt the material or the results, one sentence each.
    pub fn doubts(&self) -> Vec<String> {
        let blocks = unresolved(&self.results, self.block_um);
        material_doubts(&self.material).chain(warnings(&self.results)).chain(blocks).collect()
    }
}

/// Statuses of a run, each with the explanation that warnings give.
const EXPLAINED: [(Status, &str); 4] = [
    (
        Status::NoOnset,
        "not every contact block slid before the run ended: let it travel farther, or ask for warm_start",
    ),
    (
        Status::ShortWindow,
        "friction had not become stationary when the run ended, and its mean is not to be trusted: let it travel farther",
    ),
    (
        Status::SlidingWaves,
        "sliding is unstable to waves: blocks that stick while others slide take more than 1 % of friction away, by an amount \
         that depends on ends, damping and blocks; slide slower, or press harder",
    ),
    (Status::StderrNotReached, "the standard error asked for was not reached within the longest travel"),
];

/// Test whether the results of a load are doubtful, with an explanation.
type Doubt = (fn(&LoadReport) -> bool, &'static str);

/// Reasons to doubt the results of a load besides [`EXPLAINED`] statuses.
const DOUBTS: [Doubt; 5] = [
    (
        |load| load.status != "converged" && !EXPLAINED.iter().any(|(status, _)| load.has_status(*status)),
        "the run has no result that can be trusted: see its status",
    ),
    (
        |load| load.cavity_closed,
        "cavities close: their ceiling reaches the counterface, and the model lets it pass through",
    ),
    (
        |load| load.area_law_extrapolated,
        "local pressures exceed the area law's last: the area is taken as constant there",
    ),
    (|load| load.friction_extrapolated, BEYOND_MEASURED),
    (|load| load.tension_blocks > 0, "some contact blocks are under tension and carry no friction"),
];

/// Statement about loads at which friction was not measured.
const BEYOND_MEASURED: &str = "outside the measured range: the nearest measurement's coefficients were taken";

impl LoadReport {
    /// Whether the surface, or the flat surface of comparison, ended with `status`.
    fn has_status(&self, status: Status) -> bool {
        self.status == status.name() || self.status_flat.as_deref() == Some(status.name())
    }
}

/// Lists `pressures_mpa`, all outside the measured range of friction; `None` if there are none.
pub fn beyond_measured(pressures_mpa: &[f64]) -> Option<String> {
    let named: Vec<String> = pressures_mpa.iter().map(f64::to_string).collect();
    (!named.is_empty()).then(|| format!("at {} MPa {BEYOND_MEASURED}", named.join(", ")))
}

/// Like [`beyond_measured`], followed by the measured range in MPa, if given.
pub fn beyond_measured_range(pressures_mpa: &[f64], measured_mpa: Option<[f64; 2]>) -> Option<String> {
    let range = measured_mpa.map_or_else(String::new, |range| format!(" ({})", measured_range(range)));
    beyond_measured(pressures_mpa).map(|words| words + &range)
}

/// Blocks do not resolve a pattern if the error of the ratio due to the block size exceeds this.
const UNRESOLVED: f64 = 0.1;

/// Describes at which loads blocks of `block_um` do not resolve the pattern, and a remedy; `None` if the blocks resolve
/// it at all loads.
pub fn unresolved(results: &[LoadReport], block_um: f64) -> Option<String> {
    let error = |load: &LoadReport| load.blocks_error().filter(|error| *error > UNRESOLVED);
    let named: Vec<String> =
        results.iter().filter(|load| error(load).is_some()).map(|load| load.pressure_mpa.to_string()).collect();
    let largest = results.iter().filter_map(error).reduce(f64::max)?;
    Some(format!(
        "at {} MPa the ratio would change by up to {largest:.2} with vanishing blocks, more than {UNRESOLVED}: blocks of {block_um} um do not \
         resolve the pattern; a smaller block_um in [sample], such as {}, helps, and so do wider cavities and lands, or, where there are rims, wider and lower ones",
        named.join(", "),
        block_um / 2.0
    ))
}

/// Warnings to be read before the results are used, one sentence each.
pub fn warnings(results: &[LoadReport]) -> Vec<String> {
    let at = |test: &dyn Fn(&LoadReport) -> bool, text: &str| {
        let named: Vec<String> =
            results.iter().filter(|load| test(load)).map(|load| load.pressure_mpa.to_string()).collect();
        (!named.is_empty()).then(|| format!("at {} MPa {text}", named.join(", ")))
    };
    let explained = EXPLAINED.into_iter().filter_map(|(status, text)| at(&|load| load.has_status(status), text));
    explained.chain(DOUBTS.into_iter().filter_map(|(test, text)| at(&test, text))).collect()
}
