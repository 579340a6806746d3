//! What tolerances of manufacture and errors of the calibration make of a design's friction.

use slipgrid_calibrate::uncertainty::{Covariance, ScaleShift, moved, with_scale};
use slipgrid_material::{Condition, MaterialError};
use slipgrid_optimize::{
    Linearization, ModelFailure, Propagation, Quantity, SearchError, Spread, Target, UncertainModel, Uncertainty,
    propagate,
};
use slipgrid_pattern::Pattern;
use slipgrid_springblock::{Load, LoadOutcome, Scene, Simulation};

use crate::DesignError;
use crate::chance::{DEPTH_PER_BURST, RIM_HEIGHT, by_deeper_bursts, diagonal};
use crate::operating_conditions::{Further, Setting};
use crate::robust_search::RobustChoice;
use crate::robustness_report::{
    InputReport, MEANING, OptimumReport, PressureParts, PressureReport, RobustnessReport, ScatterReport, SpreadReport,
    distribution,
};
use crate::steady_model::SteadyModel;
use crate::task::{DesignTask, SCATTER_BASIS, SampleScatter};
use slipgrid_calibrate::uncertainty::MaterialUncertainty;
use slipgrid_monitor::{Monitor, Stage};
use slipgrid_results::PartsReport;
use slipgrid_results::PatternReport;
use slipgrid_specimen::Laid;
use slipgrid_units::{LENGTH_UM, PRESSURE_MPA, tidy};

/// Draws from the first-order model, which cost nothing.
const LINEAR_DRAWS: usize = 20_000;
/// Width, spacing, depth: the inputs before the model's parameters.
const DIMENSIONS: usize = 3;

/// A confirmed design.
pub struct About<'a> {
    /// The model of the search.
    pub model: &'a SteadyModel<'a>,
    /// The design.
    pub pattern: &'a Pattern,
    /// Its confirming run: friction is taken to lie about it.
    pub confirmed: &'a Simulation,
    /// The other conditions, with confirming runs of their own where they had one.
    pub further: &'a [Further],
    /// How it was chosen, where samples decided.
    pub choice: Option<&'a RobustChoice>,
    /// Says when to stop.
    pub bar: &'a Stage<'a>,
}

/// What is propagated through which design.
struct Request<'a> {
    about: &'a About<'a>,
    target: &'a Target,
    /// Target values are ratios to the flat surface.
    is_ratio: bool,
    /// How samples scatter.
    tolerances: &'a SampleScatter,
    /// How well the material is known.
    material: &'a MaterialUncertainty,
    /// Relative standard deviation of the depth that a burst removes, where that was fitted.
    burst_std: Option<f64>,
    /// Relative covariance of the loads' coefficients at every condition of one sliding direction, one condition after the other;
    /// `None` where it is not known.
    friction_covariance: Option<Vec<Vec<f64>>>,
    /// Sliding directions.
    directions: usize,
    /// The condition that spreads are told of, in words, where there are several.
    condition: Option<String>,
    /// Seed of the draws.
    seed: u64,
}

/// What tolerances and the errors of `material` make of the friction of `design`; `None` where the design file has no
/// tolerances, the confirming run has no friction at some pressure, or there is no time left.
///
/// # Errors
/// [`DesignError::Failed`] where no draw can be computed.
pub fn of_design(
    design: &DesignTask,
    material: &MaterialUncertainty,
    about: &About<'_>,
) -> Result<Option<RobustnessReport>, DesignError> {
    let Some(tolerances) = &design.tolerances else { return Ok(None) };
    match report(&Request::new(design, material, about, tolerances)) {
        Err(_) if about.bar.cancelled() => Ok(None),
        found => found,
    }
}

impl<'a> Request<'a> {
    /// The errors of `material` and `tolerances` through `design` as `about` has it.
    fn new(
        design: &'a DesignTask,
        material: &'a MaterialUncertainty,
        about: &'a About<'a>,
        tolerances: &'a SampleScatter,
    ) -> Self {
        // The same material in every direction: conditions of the first stand for those of the others.
        let directions = 1 + design.directions.different_deg.len();
        let conditions = (1 + about.further.len()) / directions;
        let further = about.further.iter().map(|further| further.at.condition);
        let each: Vec<Option<Condition>> = std::iter::once(design.condition).chain(further).take(conditions).collect();
        Self {
            about,
            target: &design.target,
            is_ratio: design.target.quantity() == Quantity::Ratio,
            tolerances,
            material,
            burst_std: design.laser.depth_per_burst_std(),
            friction_covariance: material.friction_covariance(&design.pressures_pa(), &each),
            directions,
            condition: (!about.further.is_empty()).then(|| Setting::first(design).in_words()),
            seed: design.seed,
        }
    }
}

/// The model about a confirmed design, with the parameters that are not known exactly.
#[derive(Clone)]
struct AboutDesign<'a> {
    model: &'a SteadyModel<'a>,
    designed: Pattern,
    laid: Laid,
    bar: &'a Stage<'a>,
    /// The design's at every condition, the one designed for first, with the material as calibrated.
    scene: Scene,
    /// Loads of the condition designed for, which spreads are told of.
    shown: usize,
    /// Loads with inputs of their own: those of one sliding direction, which all have in common.
    inputs_of_loads: usize,
    is_ratio: bool,
    /// Confirmed less steady ratio.
    offset: Vec<f64>,
    /// Friction of the flat sample in the confirming run.
    flat_mu: Vec<f64>,
    parameters: Parameters,
    scale_is_fitted: bool,
    /// What ratios are multiplied by: the discrepancy's median where designs aim with it.
    factor: Vec<f64>,
}

/// Places of the parameters among the deviations; absent where one is not uncertain.
#[derive(Clone, Debug, Default)]
struct Parameters {
    /// First of the relative errors of flat friction, one per load of one sliding direction.
    friction: Option<usize>,
    /// Young's modulus over itself, or the logarithm of the area law's fitted scale, which moves the law alike.
    modulus: Option<usize>,
    /// The logarithm of the depth that a burst removes: all cavities of all samples are deeper by it.
    burst: Option<usize>,
    /// The area law's factors, in standard errors.
    law: Option<usize>,
    /// First of the logarithmic errors of the discrepancy, one per load; Young's modulus is in them.
    discrepancy: Option<usize>,
    count: usize,
}

/// Propagates the uncertainties of `request`; `None` where the confirming run has no friction at some pressure.
fn report(request: &Request<'_>) -> Result<Option<RobustnessReport>, DesignError> {
    let failed = |failure: ModelFailure| DesignError::Failed(format!("tolerances: {failure}"));
    let Some((about, covariance)) = AboutDesign::new(request).map_err(failed)? else { return Ok(None) };
    let tolerances = &request.tolerances.tolerances;
    let refused = |error: SearchError| DesignError::Failed(format!("tolerances: {error}"));
    let uncertainty = Uncertainty::new(tolerances, &covariance).map_err(refused)?;
    let made = Uncertainty::new(tolerances, &vec![vec![0.0; covariance.len()]; covariance.len()]).map_err(refused)?;
    let first_order = Linearization::new(&about, request.about.pattern, &uncertainty).map_err(failed)?;
    let is_linear = !request.about.model.is_cheap_per_design();
    let (sampled, draws): (&dyn UncertainModel, usize) =
        if is_linear { (&first_order, LINEAR_DRAWS) } else { (&about, request.tolerances.draws) };
    let drawn = |of: &Uncertainty| propagate(sampled, request.about.pattern, of, draws, request.seed).map_err(failed);
    let is_known = about.parameters.count > 0;
    let samples = drawn(&made)?;
    let all = if is_known { Some(drawn(&uncertainty)?) } else { None };
    Ok(Some(RobustnessReport {
        meaning: MEANING.into(),
        condition: request.condition.clone(),
        method: if is_linear { "linearized" } else { "sampled" }.into(),
        inputs: inputs(request, &about, &uncertainty),
        samples: scatter(request, &about, &samples),
        with_material: all.as_ref().map(|all| scatter(request, &about, all)),
        parts: parts(&about, &uncertainty, &first_order),
        optimum: request.about.choice.map(|choice| {
            // In space a draw costs a tenth of a second.
            let nominal = (!is_linear)
                .then(|| {
                    // Its samples have its own cavities.
                    let laid = request.about.model.lay(&choice.nominal).ok()?;
                    let about = AboutDesign { laid, ..about.clone() };
                    propagate(&about, &choice.nominal, &made, request.tolerances.draws, request.seed).ok()
                })
                .flatten();
            OptimumReport {
                nominal: PatternReport::from(&choice.nominal),
                nominal_expected_rms: choice.found.nominal_expected.map(|misfit| tidy(misfit.rms)),
                expected_rms: tidy(choice.found.expected.rms),
                nominal_probability: nominal
                    .map(|drawn| tidy(drawn.probability(|values| is_met(request, values)).share)),
                evaluations: choice.found.evaluations,
            }
        }),
    }))
}

impl<'a> AboutDesign<'a> {
    /// The model about the design, and the covariance of its parameters.
    fn new(request: &Request<'a>) -> Result<Option<(Self, Covariance)>, ModelFailure> {
        let run: Option<Vec<(f64, f64)>> = request.about.confirmed.loads.iter().map(values_of).collect();
        let Some(run) = run else { return Ok(None) };
        let model = request.about.model;
        let scene = Scene { pattern: Some(*request.about.pattern), ..model.asked().clone() };
        let laid = model.lay(request.about.pattern)?;
        let steady = model.ratios_of(&scene, request.about.pattern, &laid)?;
        let confirmed = confirmed_everywhere(request, &scene.loads, &run, &steady);
        let (count, shown) = (scene.loads.len(), run.len());
        // All of one direction's, where friction is known of them.
        let inputs_of_loads = count / request.directions;
        let loads = &scene.loads[..inputs_of_loads];
        let mut parameters = Parameters::default();
        let mut blocks: Vec<Vec<Vec<f64>>> = Vec::new();
        let mut add = |block: Vec<Vec<f64>>| {
            let place = parameters.count;
            parameters.count += block.len();
            blocks.push(block);
            Some(place)
        };
        let material = request.material;
        let (friction, modulus);
        if let (Some(known), Some(law)) = (&material.scale_covariance, model.area_law()) {
            // Fitted together: flat friction and the law's scale are off together.
            friction = add(with_scale(known, law, loads).map_err(trial)?);
            modulus = friction.map(|first| first + inputs_of_loads);
        } else {
            friction = request.friction_covariance.clone().and_then(&mut add);
            let own = material.modulus_std(model.area_law()).filter(|_| model.learned().is_none());
            modulus = own.and_then(|std| add(vec![vec![std * std]]));
        }
        let has_errors = model.area_law().and_then(|law| law.factor_std()).is_some();
        let law = has_errors.then(|| add(vec![vec![1.0]])).flatten();
        let burst = request.burst_std.and_then(|std| add(vec![vec![std * std]]));
        let prediction = match model.learned() {
            Some(learned) => {
                let slopes = learned.modulus_sensitivity(request.about.pattern)?;
                Some(learned.prediction(request.about.pattern, &slopes))
            }
            None => None,
        };
        // A normal distribution of the mixture's covariance about its median.
        let errors = prediction.as_ref().and_then(|prediction| {
            let (_, all) = prediction.mixed();
            let row = |row: usize| all[row * prediction.loads()..][..count].to_vec();
            add((0..count).map(row).collect())
        });
        let factor =
            prediction.map_or_else(|| vec![1.0; count], |found| found.medians().iter().map(|d| d.exp()).collect());
        let covariance = diagonal(&blocks);
        parameters = Parameters { friction, modulus, burst, law, discrepancy: errors, ..parameters };
        let about = Self {
            model,
            bar: request.about.bar,
            designed: *request.about.pattern,
            laid,
            is_ratio: request.is_ratio,
            offset: confirmed.iter().zip(&steady).map(|((ratio, _), steady)| ratio - steady).collect(),
            flat_mu: confirmed.iter().map(|(_, flat_mu)| *flat_mu).collect(),
            scene,
            shown,
            inputs_of_loads,
            parameters,
            scale_is_fitted: material.scale_covariance.is_some(),
            factor,
        };
        Ok(Some((about, covariance)))
    }

    /// What moves the area law along the pressure.
    fn scale_name(&self) -> &'static str {
        if self.scale_is_fitted { "scale of the area law" } else { "Young's modulus" }
    }

    /// Ratio and friction at each load, one after the other or the other way round as the target has it.
    fn ordered(&self, ratio: &[f64], relative_friction: &[f64]) -> Vec<f64> {
        let mu = ratio.iter().zip(&self.flat_mu).zip(relative_friction).map(|((r, flat), by)| r * flat * (1.0 + by));
        if self.is_ratio {
            ratio.iter().copied().chain(mu).collect()
        } else {
            mu.chain(ratio.iter().copied()).collect()
        }
    }
}

impl UncertainModel for AboutDesign<'_> {
    fn respond_at(&self, design: &Pattern, deviations: &[f64]) -> Result<Vec<f64>, ModelFailure> {
        if self.bar.cancelled() {
            return Err(ModelFailure::Cancelled);
        }
        let count = self.scene.loads.len();
        let at = |first: Option<usize>, load: usize| first.map_or(0.0, |first| deviations[first + load]);
        let flat: Vec<f64> = (0..count).map(|load| at(self.parameters.friction, load % self.inputs_of_loads)).collect();
        let scale = ScaleShift::off_by(at(self.parameters.modulus, 0), self.scale_is_fitted);
        let moved = moved(&self.scene, &flat, scale, at(self.parameters.law, 0)).map_err(trial)?;
        let made = by_deeper_bursts(design, at(self.parameters.burst, 0))?;
        let steady = self.model.ratios_of(&moved, &made, &self.laid)?;
        // r F exp(d): F the discrepancy's median, d its own error
        let off = |load: usize| self.factor[load] * at(self.parameters.discrepancy, load).exp();
        let ratio = steady.iter().zip(&self.offset).enumerate();
        let ratio: Vec<f64> = ratio.map(|(load, (steady, offset))| (steady + offset) * off(load)).collect();
        Ok(self.ordered(&ratio, &flat))
    }
}

fn trial(error: MaterialError) -> ModelFailure {
    ModelFailure::Trial { reason: error.to_string() }
}

/// At every condition.
fn is_met(request: &Request<'_>, values: &[f64]) -> bool {
    request.target.misfit(&values[..request.target.values()]).is_met()
}

/// Ratio and friction of the flat sample in a confirming run.
fn values_of(load: &LoadOutcome) -> Option<(f64, f64)> {
    Some((load.ratio?, load.flat.as_ref()?.mu_dynamic?))
}

/// Ratio and flat friction at each of `loads`, those of `run` first: of further conditions by runs of their own, and where there is
/// none by the `steady` ratios, which are off by as much as at the condition designed for, and the coefficients.
fn confirmed_everywhere(request: &Request<'_>, loads: &[Load], run: &[(f64, f64)], steady: &[f64]) -> Vec<(f64, f64)> {
    let count = run.len();
    let at = |own: usize| {
        let (first, (ratio, flat_mu)) = (own % count, run[own % count]);
        let further = (own / count).checked_sub(1).and_then(|place| request.about.further.get(place));
        let own_run = further.and_then(|at| values_of(at.confirmed.as_ref()?.loads.get(first)?));
        let dynamic = |load: usize| loads[load].friction.dynamic_mean();
        own_run.unwrap_or((steady[own] + ratio - steady[first], flat_mu * dynamic(own) / dynamic(first)))
    };
    run.iter().copied().chain((count..loads.len()).map(at)).collect()
}

/// Whether anything is demanded that a sample could miss.
fn is_asked(request: &Request<'_>) -> bool {
    request.target.has_demands()
}

fn scatter(request: &Request<'_>, about: &AboutDesign<'_>, found: &Propagation) -> ScatterReport {
    let count = about.scene.loads.len();
    let spreads = found.spreads();
    let within = found.probability(|values| is_met(request, values));
    ScatterReport {
        draws: found.draws(),
        failed: found.failed,
        redrawn: found.redrawn,
        probability: is_asked(request).then(|| tidy(within.share)),
        probability_stderr: is_asked(request).then(|| tidy(within.stderr)),
        by_pressure: (0..about.shown)
            .map(|load| PressureReport {
                pressure_mpa: PRESSURE_MPA.from_si(about.scene.loads[load].pressure_pa),
                spread: pair(&spreads, request.is_ratio, load, count),
            })
            .collect(),
    }
}

/// Ratio and friction at one load.
fn pair(spreads: &[Spread], is_ratio: bool, load: usize, count: usize) -> SpreadReport {
    let (first, second) = (distribution(&spreads[load]), distribution(&spreads[count + load]));
    let (ratio, mu) = if is_ratio { (first, second) } else { (second, first) };
    SpreadReport { ratio, mu }
}

/// What each input alone makes of the target's quantity at each load, to first order.
fn parts(about: &AboutDesign<'_>, uncertainty: &Uncertainty, first_order: &Linearization) -> Vec<PressureParts> {
    let count = about.scene.loads.len();
    let parameter = |place: Option<usize>, of: usize| place.map(|place| DIMENSIONS + place..DIMENSIONS + place + of);
    let of_friction = about.inputs_of_loads;
    let groups = [
        ("width", Some(0..1)),
        ("spacing", Some(1..2)),
        ("depth", Some(2..3)),
        (RIM_HEIGHT, uncertainty.rim().map(|place| place..place + 1)),
        ("flat friction", parameter(about.parameters.friction, of_friction)),
        (about.scale_name(), parameter(about.parameters.modulus, 1)),
        (DEPTH_PER_BURST, parameter(about.parameters.burst, 1)),
        ("area law", parameter(about.parameters.law, 1)),
        ("discrepancy", parameter(about.parameters.discrepancy, count)),
    ];
    let known: Vec<(&str, Vec<f64>)> = groups
        .into_iter()
        .filter_map(|(name, range)| {
            let range = range.filter(|range| range.clone().any(|input| uncertainty.std(input) > 0.0))?;
            Some((name, first_order.std_of(uncertainty, &|input| range.contains(&input))))
        })
        .collect();
    let all = first_order.std(uncertainty);
    (0..about.shown)
        .map(|load| PressureParts {
            pressure_mpa: PRESSURE_MPA.from_si(about.scene.loads[load].pressure_pa),
            std: tidy(all[load]),
            of: known
                .iter()
                .map(|(name, std)| PartsReport { input: (*name).to_owned(), std: tidy(std[load]) })
                .collect(),
        })
        .collect()
}

/// What scatters, in words and numbers.
fn inputs(request: &Request<'_>, about: &AboutDesign<'_>, uncertainty: &Uncertainty) -> Vec<InputReport> {
    let mut inputs: Vec<InputReport> = Vec::new();
    for (axis, name) in ["width", "spacing", "depth"].into_iter().enumerate() {
        let std_um = LENGTH_UM.from_si(uncertainty.std(axis));
        if std_um > 0.0 {
            inputs.push(InputReport {
                name: name.to_owned(),
                std: vec![std_um],
                unit: "um".into(),
                basis: SCATTER_BASIS.to_owned(),
            });
        }
    }
    if let Some(place) = uncertainty.rim() {
        let is_half = about.designed.rim_height_m() == 0.0;
        inputs.push(InputReport {
            name: RIM_HEIGHT.to_owned(),
            std: vec![LENGTH_UM.from_si(uncertainty.std(place))],
            unit: "um".into(),
            basis: if is_half {
                format!("{SCATTER_BASIS}; half-normal, rims being expected to have none")
            } else {
                SCATTER_BASIS.to_owned()
            },
        });
    }
    let percent = |std: f64| tidy(100.0 * std);
    if let Some(first) = about.parameters.friction {
        inputs.push(InputReport {
            name: "flat friction at each load".to_owned(),
            std: (0..about.shown).map(|load| percent(uncertainty.std(DIMENSIONS + first + load))).collect(),
            unit: "%".into(),
            basis: "standard errors of the fitted coefficients".to_owned(),
        });
    }
    if let Some(place) = about.parameters.modulus {
        let is_fitted = request.material.scale_covariance.is_some();
        inputs.push(InputReport {
            name: about.scale_name().to_owned(),
            std: vec![percent(uncertainty.std(DIMENSIONS + place))],
            unit: "%".into(),
            basis: if is_fitted {
                "fitted together with flat friction"
            } else {
                "shifts the area law along pressure, while flat friction stays as measured"
            }
            .to_owned(),
        });
    }
    if let Some(place) = about.parameters.burst {
        inputs.push(InputReport {
            name: DEPTH_PER_BURST.to_owned(),
            std: vec![percent(uncertainty.std(DIMENSIONS + place))],
            unit: "%".into(),
            basis: "fitted to measured depths; all cavities are deeper or shallower by it".to_owned(),
        });
    }
    if about.parameters.law.is_some() {
        inputs.push(InputReport {
            name: "factors of the area law".to_owned(),
            std: vec![1.0],
            unit: "standard errors".into(),
            basis: "scatter among windows of the altitude map; all factors are taken to be off in the same direction"
                .to_owned(),
        });
    }
    if let Some(first) = about.parameters.discrepancy {
        inputs.push(InputReport {
            name: "discrepancy, at each load".to_owned(),
            std: (0..about.shown).map(|load| percent(uncertainty.std(DIMENSIONS + first + load))).collect(),
            unit: "%".into(),
            basis: "what the model lacks, as far as trials leave it open, with Young's modulus".to_owned(),
        });
    }
    inputs
}
