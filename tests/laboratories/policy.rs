//! Policies by which a laboratory chooses the texture to cut next.

use slipgrid_base::statistics::Normals;
use slipgrid_infer::discrepancy::{
    Candidate, Conditions, DimensionShift, Discrepancy, Distribution, Form, Hyperparameters, Predictor, Score, Trial,
    Wanted,
};

use super::physics::{LOADS, Solved, loads};
use super::truth::{MODULUS_STD, TOLERANCE, around, dimension_shifts};
use slipgrid_io::Failure;

/// Standard deviation of the Gaussian process.
const PROCESS_STD: f64 = 0.2;
/// Number of textures with the highest rough chance, among which the chance on more points decides.
const FINALISTS: usize = 8;
/// Number of draws for the expected improvement.
const DRAWS: usize = 64;

/// Policy that chooses the next texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Policy {
    /// Maximum chance by the mixture of forms.
    Mixture,
    /// Minimum misfit by the model without correction.
    Physics,
    /// Minimum misfit by the model with one factor, the mean over all measurements.
    Constant,
    /// Minimum misfit by the model with a factor linear in pressure.
    Linear,
    /// Minimum misfit by the model with the factors of the last trial.
    Last,
    /// Maximum chance by a Gaussian process of the dimensions, without forms.
    Process,
    /// Maximum expected improvement of the misfit by the same Gaussian process.
    Improvement,
    /// Maximum chance by the mechanism's own form alone, if it belongs to the family; shows the value of knowing the
    /// form.
    Form,
    /// Minimum misfit by the true ratios, without the scatter of samples; an upper bound for every policy.
    Truth,
}

impl Policy {
    /// All policies.
    pub const ALL: [Self; 9] = [
        Self::Mixture,
        Self::Physics,
        Self::Constant,
        Self::Linear,
        Self::Last,
        Self::Process,
        Self::Improvement,
        Self::Form,
        Self::Truth,
    ];

    /// Name of the policy in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Mixture => "mixture of forms, greedy",
            Self::Physics => "physics alone",
            Self::Constant => "constant factor",
            Self::Linear => "factor linear in pressure",
            Self::Last => "last trial's factors",
            Self::Process => "Gaussian process",
            Self::Improvement => "expected improvement",
            Self::Form => "the form known, not its size",
            Self::Truth => "the truth known",
        }
    }
}

/// Limits of the ratios that are on target: `target` plus and minus the tolerance.
pub fn wanted(target: &[f64; LOADS]) -> Wanted {
    let [lower, upper] = around(target, TOLERANCE).map(Vec::from);
    Wanted { lower, upper }
}

/// Learns the discrepancy from `trials` and prepares predictions at the loads.
///
/// # Errors
/// [`Failure`] if the trials are invalid.
pub fn learned(hyper: &Hyperparameters, trials: &[Trial]) -> Result<Predictor, Failure> {
    let failed =
        |error: slipgrid_infer::discrepancy::DiscrepancyError| Failure::Failed(format!("laboratories: {error}"));
    let found = Discrepancy::new(hyper.clone(), Conditions::default(), MODULUS_STD, trials.to_vec()).map_err(failed)?;
    Ok(found.at(&loads()))
}

/// Hyperparameters of a Gaussian process of the dimensions, without forms.
pub fn process() -> Hyperparameters {
    Hyperparameters {
        amplitude_std: PROCESS_STD,
        pressure_std: 0.0,
        inverse_pressure_std: 0.0,
        speed_std: 0.0,
        humidity_std: 0.0,
        scales: vec![(1.0, 1.0)],
        residuals: vec![(1.0, 1.0)],
        forms: vec![(Form::Saturating { scale: 0.02 }, 1.0)],
        ..Hyperparameters::default()
    }
}

/// Hyperparameters that know the form exactly.
fn of_form(form: Form) -> Hyperparameters {
    let one = vec![(1.0, 1.0)];
    Hyperparameters { forms: vec![(form, 1.0)], scales: one, residuals: vec![(0.0, 1.0)], ..Hyperparameters::default() }
}

/// Candidate for a texture, with the errors of its dimensions.
pub fn candidate<'a>(of: &'a Solved, dimension_shifts: &'a [DimensionShift]) -> Candidate<'a> {
    Candidate {
        features: of.features,
        modelled: &of.ratio,
        sensitivity: &of.sensitivity,
        covariance: &[],
        dimension_shifts,
    }
}

/// Data available before the next cut.
pub struct Known<'a> {
    /// All textures, including those that were cut.
    pub textures: &'a [Solved],
    /// Errors of the dimensions of samples, for each texture.
    pub dimension_shifts: &'a [Vec<DimensionShift>],
    /// Indices of the textures that were cut.
    pub cut: &'a [usize],
    /// Measurements of the cut samples.
    pub trials: &'a [Trial],
    /// Target ratio at each load.
    pub target: &'a [f64; LOADS],
    /// Form of the mechanism, if it belongs to the family; only for [`Policy::Form`].
    pub form: Option<Form>,
    /// True ratios of each texture; only for [`Policy::Truth`].
    pub truths: &'a [[f64; LOADS]],
}

impl Policy {
    /// Prior of the policies that use the discrepancy: the mixture, or `form` alone if the policy knows it; `None` for
    /// other policies.
    pub fn hyperparameters(self, form: Option<Form>) -> Option<Hyperparameters> {
        match self {
            Self::Mixture => Some(Hyperparameters::default()),
            Self::Form => form.map(of_form),
            _ => None,
        }
    }

    /// Index of the texture to cut next.
    ///
    /// # Errors
    /// [`Failure`] if the trials are invalid, or if every texture has been cut.
    pub fn next(self, known: &Known<'_>) -> Result<usize, Failure> {
        let is_open = |place: &usize| !known.cut.contains(place);
        let nearest = |ratio: &dyn Fn(usize, usize) -> f64| {
            let misfit = |place: usize| {
                (0..LOADS).map(|load| (ratio(place, load) - known.target[load]).abs()).fold(0.0, f64::max)
            };
            (0..known.textures.len()).filter(is_open).min_by(|a, b| misfit(*a).total_cmp(&misfit(*b)))
        };
        let by_factor =
            |factor: &dyn Fn(usize) -> f64| nearest(&|place, load| known.textures[place].ratio[load] * factor(load));
        let excess =
            |load: usize| -> Vec<f64> { known.trials.iter().map(|trial| trial.measured[load].log_excess()).collect() };
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
        let at_load: Vec<f64> = (0..LOADS).map(|load| mean(&excess(load))).collect();
        let by_chance = |hyper: &Hyperparameters| -> Result<Option<usize>, Failure> {
            let predictor = learned(hyper, known.trials)?;
            let (wanted, textures, shifts) = (wanted(known.target), known.textures, known.dimension_shifts);
            let value = |place: usize, score: fn(&Wanted, &Distribution, &[f64]) -> Score| {
                let candidate = candidate(&textures[place], &shifts[place]);
                (place, score(&wanted, &predictor.of(&candidate), candidate.modelled).value())
            };
            // The first of equal ones wins, as the sort is stable.
            let mut all: Vec<(usize, f64)> =
                (0..textures.len()).filter(is_open).map(|place| value(place, Wanted::rough_score)).collect();
            all.sort_by(|a, b| b.1.total_cmp(&a.1));
            let finalists = all.iter().take(FINALISTS).map(|(place, _)| value(*place, Wanted::score));
            Ok(finalists.reduce(|best, next| if next.1 > best.1 { next } else { best }).map(|best| best.0))
        };
        let found = match self {
            Self::Mixture | Self::Form => by_chance(&self.hyperparameters(known.form).unwrap_or_default())?,
            Self::Process => by_chance(&process())?,
            Self::Improvement => improvement(known)?,
            Self::Truth => nearest(&|place, load| known.truths[place][load]),
            Self::Physics => by_factor(&|_| 1.0),
            Self::Constant => by_factor(&|_| mean(&at_load).exp()),
            Self::Linear => {
                // Equal distances of the pressures: u = -3, -1, 1, 3
                let u = |load: usize| 2.0 * load as f64 - (LOADS as f64 - 1.0);
                let slope = (0..LOADS).map(|load| u(load) * at_load[load]).sum::<f64>()
                    / (0..LOADS).map(|load| u(load) * u(load)).sum::<f64>();
                by_factor(&|load| (mean(&at_load) + slope * u(load)).exp())
            }
            Self::Last => by_factor(&|load| excess(load).last().copied().unwrap_or(0.0).exp()),
        };
        found.ok_or_else(|| Failure::Failed("laboratories: every texture has been cut".to_owned()))
    }
}

/// Texture with the largest expected improvement by the Gaussian process: decrease of the minimum misfit, which is the
/// largest over all loads.
fn improvement(known: &Known<'_>) -> Result<Option<usize>, Failure> {
    let predictor = learned(&process(), known.trials)?;
    let misfit = |ratios: &dyn Fn(usize) -> f64| {
        (0..LOADS).map(|load| (ratios(load) - known.target[load]).abs() / TOLERANCE).fold(0.0, f64::max)
    };
    let measured = known.trials.iter().map(|trial| misfit(&|load| trial.measured[load].measured));
    let least = measured.fold(10.0, f64::min);
    let mut normals = Normals::new(1);
    let draws: Vec<[f64; LOADS]> = (0..DRAWS).map(|_| [0; LOADS].map(|_| normals.draw())).collect();
    let expected = |place: usize| {
        let of = &known.textures[place];
        let prediction = predictor.of(&candidate(of, &known.dimension_shifts[place]));
        let component = &prediction.components[0];
        // Loads move together but for their own scatter: a common deviate and a small one each.
        let std = |load: usize| component.covariance[load * LOADS + load].sqrt();
        let common = component.covariance[1].max(0.0) / (std(0) * std(1));
        let at = |z: &[f64; LOADS]| {
            let value = |load: usize| {
                let deviate = common.sqrt() * z[0] + (1.0 - common).max(0.0).sqrt() * z[load];
                of.ratio[load] * (component.mean[load] + std(load) * deviate).exp()
            };
            (least - misfit(&value)).max(0.0)
        };
        draws.iter().map(at).sum::<f64>()
    };
    let open = (0..known.textures.len()).filter(|place| !known.cut.contains(place));
    Ok(open.map(|place| (place, expected(place))).max_by(|a, b| a.1.total_cmp(&b.1)).map(|(place, _)| place))
}

/// [`dimension_shifts`] for every texture.
pub fn all_dimension_shifts(textures: &[Solved]) -> Vec<Vec<DimensionShift>> {
    textures.iter().map(|of| dimension_shifts(of.features, &of.ratio)).collect()
}
