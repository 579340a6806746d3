//! One error beside every friction coefficient and ratio: what the run, the calibration and, where it is aimed with, the
//! discrepancy leave open, with its parts kept apart.

use serde::Serialize;
use slipgrid_optimize::{Linearization, ModelFailure, Quantity, Tolerances, Uncertainty};
use slipgrid_springblock::LoadOutcome;

use super::model::SteadyCell;
use super::robustness::{About, AboutDesign, Request};
use super::robustness_report::PartsReport;
use crate::CliError;
use crate::formats::design::Design;
use crate::formats::material_uncertainty::MaterialUncertainty;
use crate::formats::tolerances::TolerancesInput;
use crate::units::{PRESSURE_MPA, tidy};

/// Width, spacing, depth: the inputs before the model's parameters. The design itself is taken as exact.
const DIMENSIONS: usize = 3;
/// Part of a confirming run: how long it lasted.
const TIME_AVERAGE: &str = "time average";
/// The same of a mean over several draws, whose scatter its error comes from.
const TIME_AND_DRAWS: &str = "time average and local coefficients drawn";
/// Part of a confirming run: which local coefficients it drew.
const DRAWS: &str = "local coefficients drawn";

/// Errors of a design's numbers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ErrorsReport {
    /// What the errors combine, in words.
    pub meaning: String,
    /// What is in them.
    pub includes: Vec<String>,
    /// What is not, because the material does not say it.
    pub unknown: Vec<String>,
    /// One per target pressure.
    pub by_pressure: Vec<PressureErrors>,
}

/// Values at one pressure as they are compared with the target, each with its error.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PressureErrors {
    /// Nominal pressure.
    pub pressure_mpa: f64,
    /// The target's quantity by the search's model.
    pub predicted: ErrorReport,
    /// The ratio by the confirming run.
    pub ratio: ErrorReport,
    /// Dynamic friction by the confirming run.
    pub mu: ErrorReport,
}

/// A value with one standard deviation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ErrorReport {
    /// The value; null where the run gave none.
    pub value: Option<f64>,
    /// All parts together; null where none is known.
    pub std: Option<f64>,
    /// Each part alone.
    pub parts: Vec<PartsReport>,
}

impl ErrorReport {
    /// Parts that are independent of one another, `combined` being one that holds those `of` it already.
    fn new(value: Option<f64>, own: Vec<PartsReport>, combined: Option<f64>, of: Vec<PartsReport>) -> Self {
        let square: f64 = own.iter().map(|part| part.std.powi(2)).sum::<f64>() + combined.unwrap_or(0.0).powi(2);
        let is_known = value.is_some() && (combined.is_some() || !own.is_empty());
        let parts = own.into_iter().chain(of).map(|part| PartsReport { std: tidy(part.std), ..part }).collect();
        Self { value: value.map(tidy), std: is_known.then(|| tidy(square.sqrt())), parts }
    }
}

/// What the material leaves open at each load: of ratio and friction all together, and each part.
struct Material {
    /// Names of the parts.
    names: Vec<&'static str>,
    /// Of the ratio, then of dynamic friction: all parts, then each, by load.
    of: [Vec<Vec<f64>>; 2],
}

/// Errors of the values of `about`: `predicted` is the target's quantity as the search took it, `draws` how many the
/// confirming run is the mean of.
///
/// # Errors
/// [`CliError::Other`] for a broken model.
pub fn of_design(
    design: &Design,
    material: &MaterialUncertainty,
    about: &About<'_>,
    predicted: &[f64],
    draws: u64,
) -> Result<ErrorsReport, CliError> {
    let exact = TolerancesInput { tolerances: Tolerances::default(), draws: 0 };
    let request = Request::new(design, material, about, &exact);
    let known = match of_material(&request, design, &exact) {
        Ok(known) => known,
        Err(ModelFailure::Trial { .. }) => None,
        Err(failure) => return Err(CliError::Other(failure.to_string())),
    };
    let is_ratio = design.target.quantity() == Quantity::Ratio;
    let scene = about.model.scene(about.pattern);
    let factors = super::aim::factors(design, material, &scene.loads);
    let own = |std: Option<f64>, input: &str| std.map(|std| PartsReport { input: input.to_owned(), std });
    let by_pressure: Vec<PressureErrors> = about
        .confirmed
        .loads
        .iter()
        .enumerate()
        .map(|(place, load)| {
            let factor = factors[place];
            let of = |quantity: usize| {
                let known = known.as_ref()?;
                let parts = known.names.iter().zip(&known.of[quantity][1..]);
                let parts = parts.filter_map(|(name, std)| own(Some(std[place]), name)).collect();
                Some((known.of[quantity][0][place], parts))
            };
            let with = |value: Option<f64>, parts: Vec<PartsReport>, quantity: usize| match of(quantity) {
                Some((combined, of)) => ErrorReport::new(value, parts, Some(combined), of),
                None => ErrorReport::new(value, parts, None, Vec::new()),
            };
            let [ratio, mu] = [load.ratio, load.surface.mu_dynamic].map(|value| value.map(|value| value * factor));
            let drawn = drawn(load, scene.loads[place].friction.relative_std());
            let [drawn_ratio, drawn_mu] = if draws > 1 { [None, None] } else { drawn };
            let run = |stderr: Option<f64>, value: Option<f64>, drawn: Option<f64>| {
                let parts = [
                    own(stderr.map(|stderr| stderr * factor), if draws > 1 { TIME_AND_DRAWS } else { TIME_AVERAGE }),
                    own(value.zip(drawn).map(|(v, by)| v * by), DRAWS),
                ];
                parts.into_iter().flatten().collect::<Vec<_>>()
            };
            PressureErrors {
                pressure_mpa: PRESSURE_MPA.from_si(load.pressure_pa),
                predicted: with(predicted.get(place).copied(), Vec::new(), usize::from(!is_ratio)),
                ratio: with(ratio, run(load.ratio_stderr, ratio, drawn_ratio), 0),
                mu: with(mu, run(load.surface.mu_dynamic_stderr, mu, drawn_mu), 1),
            }
        })
        .collect();
    let mut includes: Vec<String> = Vec::new();
    for part in by_pressure.iter().flat_map(|row| row.ratio.parts.iter().chain(&row.mu.parts)) {
        if !includes.contains(&part.input) {
            includes.push(part.input.clone());
        }
    }
    let unknown = unknown(about.model, material, &request, known.as_ref());
    Ok(ErrorsReport { meaning: meaning(design, &includes, &unknown), includes, unknown, by_pressure })
}

/// What is propagated to first order; `None` where nothing is known of the material, or the run has no friction.
fn of_material(
    request: &Request<'_>,
    design: &Design,
    exact: &TolerancesInput,
) -> Result<Option<Material>, ModelFailure> {
    let Some((about, covariance)) = AboutDesign::new(request)? else { return Ok(None) };
    let trial = |reason: String| ModelFailure::Trial { reason };
    let uncertainty = Uncertainty::new(&exact.tolerances, &covariance).map_err(|error| trial(error.to_string()))?;
    let count = design.target.points().len();
    let place = |first: Option<usize>, of: usize| first.map(|first| DIMENSIONS + first..DIMENSIONS + first + of);
    let groups = [
        ("flat friction", place(about.parameters.friction, count)),
        (about.scale_name(), place(about.parameters.modulus, 1)),
        ("area law", place(about.parameters.law, 1)),
        ("discrepancy", place(about.parameters.discrepancy.filter(|_| design.discrepancy), count)),
    ];
    let groups: Vec<_> = groups.into_iter().filter_map(|(name, range)| Some((name, range?))).collect();
    if groups.is_empty() {
        return Ok(None);
    }
    let first_order = Linearization::new(&about, request.pattern(), &uncertainty)?;
    let all = first_order.std(&uncertainty);
    let each = groups.iter().map(|(_, range)| first_order.std_of(&uncertainty, &|input| range.contains(&input)));
    let values: Vec<Vec<f64>> = std::iter::once(all).chain(each).collect();
    // The target's quantity comes first.
    let half = |second: bool| -> Vec<Vec<f64>> {
        let from = if second { count } else { 0 };
        values.iter().map(|std| std[from..from + count].to_vec()).collect()
    };
    let is_ratio = design.target.quantity() == Quantity::Ratio;
    let names = groups.iter().map(|(name, _)| *name).collect();
    Ok(Some(Material { names, of: [half(!is_ratio), half(is_ratio)] }))
}

/// Standard deviations of ratio and friction over themselves among runs with other draws of the local coefficients.
///
/// ```text
/// d ln(mu) = sum_i w_i s g_i,  w_i = F_i / sum F:  std = s sqrt(sum w_i^2)
/// d ln(ratio) = sum_i (w_i - 1/n) s g_i:           std = s sqrt(sum w_i^2 - 1/n)
/// ```
///
/// F friction of a block, g its deviate, n the blocks of the flat surface, which has the same deviates.
fn drawn(load: &LoadOutcome, scatter: f64) -> [Option<f64>; 2] {
    let total: f64 = load.surface.interface.iter().map(|point| point.friction_pa).sum();
    let square: f64 = load.surface.interface.iter().map(|point| (point.friction_pa / total).powi(2)).sum();
    let blocks = load.flat.as_ref().map_or(0, |flat| flat.interface.len());
    if !square.is_finite() || blocks == 0 {
        return [None, None];
    }
    [square - 1.0 / blocks as f64, square].map(|sum| Some(scatter * sum.max(0.0).sqrt()))
}

/// What the material does not say of its own errors.
fn unknown(
    model: &SteadyCell,
    material: &MaterialUncertainty,
    request: &Request<'_>,
    known: Option<&Material>,
) -> Vec<String> {
    let has_law = model.area_law().is_some();
    let fitted_together = material.scale_covariance.is_some() && has_law;
    let mut unknown: Vec<&str> = Vec::new();
    if !fitted_together && !request.knows_friction() {
        unknown.push("flat friction");
    }
    if has_law && !fitted_together && (material.law_is_fitted || material.modulus_relative_std.is_none()) {
        unknown.push(if material.law_is_fitted { "scale of the area law" } else { "Young's modulus" });
    }
    if has_law && material.scale_covariance.is_none() && model.area_law().and_then(|law| law.factor_std()).is_none() {
        unknown.push("area law");
    }
    if known.is_none() && unknown.is_empty() {
        unknown.push("what the material's errors make of friction: designs beside this one cannot be computed");
    }
    unknown.into_iter().map(str::to_owned).collect()
}

fn meaning(design: &Design, includes: &[String], unknown: &[String]) -> String {
    let mut words = format!("+-: one standard deviation of {}", includes.join(", "));
    if !unknown.is_empty() {
        words += &format!("; not known of this material: {}", unknown.join(", "));
    }
    words + if design.discrepancy { "" } else { "; how far the model itself is off is not in it" }
}

impl ErrorsReport {
    /// The errors at one pressure.
    #[must_use]
    pub fn at(&self, row: usize) -> Option<&PressureErrors> {
        self.by_pressure.get(row)
    }
}
