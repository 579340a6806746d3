//! How a laboratory may choose what it cuts next.

use slipgrid_discrepancy::{
    Candidate, Conditions, DimensionShift, Discrepancy, Form, Hyperparameters, Prediction as Distribution, Predictor,
    Score, Trial, Wanted,
};
use slipgrid_statistics::Normals;

use super::draws::{Draws, around, between};
use super::generator::{Generator, Seen, logs};
use super::physics::{LOADS, Solved, loads};
use super::truth::{MODULUS_STD, TOLERANCE, dimension_shifts};
use slipgrid_studies::StudyError;

/// Its standard deviation.
const PROCESS_STD: f64 = 0.2;
/// Textures of the greatest rough chance, for which the chance on more points decides.
const FINALISTS: usize = 8;
/// Draws behind the expected improvement.
const DRAWS: usize = 64;
/// Draws of laboratories behind the chances of [`Policy::Generator`], and more where those of equal weight are fewer than enough.
const INFORMED_DRAWS: [usize; 3] = [2048, 8192, 32768];
const ENOUGH_DRAWS: f64 = 600.0;

/// How the next texture is chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Policy {
    /// The mixture of forms, by the chance to be on target.
    Mixture,
    /// The model as it is: the next best of its designs.
    Physics,
    /// One factor over all that was measured.
    Constant,
    /// A factor linear in pressure.
    Linear,
    /// The last trial's factors.
    Last,
    /// A Gaussian process of the dimensions, without forms, by the chance.
    Process,
    /// The same process, by the expected improvement of the misfit.
    Improvement,
    /// The mixture of the mechanism's own form alone, where that is one of the family: what cannot be had without knowing it.
    Form,
    /// How laboratories are made is known, and that the target is reached, but not which laboratory this is: what no learner
    /// knows better.
    Generator,
    /// The truth is known but for each sample's own scatter: what no policy beats.
    Truth,
}

impl Policy {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::Mixture,
        Self::Physics,
        Self::Constant,
        Self::Linear,
        Self::Last,
        Self::Process,
        Self::Improvement,
        Self::Form,
        Self::Generator,
        Self::Truth,
    ];

    /// Its name.
    #[must_use]
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
            Self::Generator => "how laboratories are made known",
            Self::Truth => "the truth known",
        }
    }
}

/// What is wanted: these ratios, each within the tolerance.
pub fn wanted(target: &[f64; LOADS]) -> Wanted {
    let [lower, upper] = around(target, TOLERANCE).map(Vec::from);
    Wanted { lower, upper }
}

/// What is known after `trials`.
///
/// # Errors
/// [`StudyError`] for trials that mean nothing.
pub fn learned(hyper: &Hyperparameters, trials: &[Trial]) -> Result<Predictor, StudyError> {
    let failed = |error: slipgrid_discrepancy::DiscrepancyError| StudyError::Failed(format!("laboratories: {error}"));
    let found = Discrepancy::new(hyper.clone(), Conditions::default(), MODULUS_STD, trials.to_vec()).map_err(failed)?;
    Ok(found.at(&loads()))
}

/// Hyperparameters of a Gaussian process of the dimensions: no form.
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

/// Hyperparameters of one who knows the form to the letter.
fn of_form(form: Form) -> Hyperparameters {
    let one = vec![(1.0, 1.0)];
    Hyperparameters { forms: vec![(form, 1.0)], scales: one, residuals: vec![(0.0, 1.0)], ..Hyperparameters::default() }
}

/// The candidate that a texture is, with errors of its dimensions.
pub fn candidate<'a>(of: &'a Solved, dimension_shifts: &'a [DimensionShift]) -> Candidate<'a> {
    Candidate {
        features: of.features,
        modelled: &of.ratio,
        sensitivity: &of.sensitivity,
        covariance: &[],
        dimension_shifts,
    }
}

/// What is known before the next cut.
pub struct Known<'a> {
    /// All textures, and those that were cut.
    pub textures: &'a [Solved],
    /// Errors of the samples' dimensions for each.
    pub dimension_shifts: &'a [Vec<DimensionShift>],
    /// Places of those that were cut.
    pub cut: &'a [usize],
    /// What was measured of these.
    pub trials: &'a [Trial],
    /// The target.
    pub target: &'a [f64; LOADS],
    /// The form of the mechanism, where it is one of the family, for [`Policy::Form`] alone.
    pub form: Option<Form>,
    /// What each texture truly does, for [`Policy::Truth`] alone.
    pub truths: &'a [[f64; LOADS]],
    /// Standard error of one measurement over itself.
    pub noise: f64,
    /// How many of the trials were there at first: the others were cut for the target, and missed it.
    pub judged_from: usize,
}

impl Policy {
    /// What the mixture believes before any trial, or one who knows the `form` where there is one.
    pub fn hyperparameters(self, form: Option<Form>) -> Option<Hyperparameters> {
        match self {
            Self::Mixture => Some(Hyperparameters::default()),
            Self::Form => form.map(of_form),
            _ => None,
        }
    }

    /// Place of the texture to cut next.
    ///
    /// # Errors
    /// [`StudyError`] for trials that mean nothing, or where nothing is left.
    pub fn next(self, known: &Known<'_>) -> Result<usize, StudyError> {
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
        let by_chance = |hyper: &Hyperparameters| -> Result<Option<usize>, StudyError> {
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
            Self::Generator => None,
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
        found.ok_or_else(|| StudyError::Failed("laboratories: every texture has been cut".to_owned()))
    }
}

/// What [`Policy::Generator`] is told beside how laboratories are made and what was measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Told {
    /// That some texture truly reaches the target, where one does.
    pub is_reached: bool,
    /// That no sample cut for the target was on it.
    pub is_missed: bool,
}

impl Told {
    /// Everything.
    pub const ALL: Self = Self { is_reached: true, is_missed: true };
}

/// What [`Policy::Generator`] knows before a cut.
pub struct Informed<'a> {
    generator: &'a Generator,
    draws: Draws,
    chances: Vec<f64>,
    noise: f64,
}

impl<'a> Informed<'a> {
    /// From what was measured, and from what is `told` of the target.
    ///
    /// # Errors
    /// [`StudyError::Failed`] where no laboratory that was drawn can be this one.
    pub fn new(generator: &'a Generator, told: Told, known: &Known<'_>) -> Result<Self, StudyError> {
        let seen = |(number, (trial, place)): (usize, (&Trial, &usize))| {
            Seen::new(trial, *place, told.is_missed && number >= known.judged_from)
        };
        let seen: Vec<Seen> = known.trials.iter().zip(known.cut).enumerate().map(seen).collect();
        let wanted = between(known.target, TOLERANCE);
        let mut draws = Draws::default();
        for count in INFORMED_DRAWS {
            let all = generator.draws(&seen, known.noise, &wanted, count);
            draws = if told.is_reached { all.of_reached(generator, known.target) } else { all };
            if draws.effective() >= ENOUGH_DRAWS {
                break;
            }
        }
        if draws.all.is_empty() {
            return Err(StudyError::Failed("laboratories: none that was drawn can be the one at hand".to_owned()));
        }
        let chances = draws.chances(generator, &wanted);
        Ok(Self { generator, draws, chances, noise: known.noise })
    }

    /// The texture of the greatest chance that was not cut yet.
    ///
    /// # Errors
    /// [`StudyError::Failed`] where every texture was cut.
    pub fn next(&self, known: &Known<'_>) -> Result<usize, StudyError> {
        let open = (0..self.chances.len()).filter(|place| !known.cut.contains(place));
        let best = open.max_by(|a, b| self.chances[*a].total_cmp(&self.chances[*b]));
        best.ok_or_else(|| StudyError::Failed("laboratories: every texture has been cut".to_owned()))
    }

    /// The chance that a sample is on target.
    pub fn chance(&self, place: usize) -> f64 {
        self.chances[place]
    }

    /// The share of what is predicted of a sample that lies below what was measured of it, at each load.
    pub fn below(&self, place: usize, trial: &Trial) -> [f64; LOADS] {
        self.draws.below(self.generator, place, self.noise, &logs(trial))
    }
}

/// The largest expected fall of the least misfit so far, the worst of all loads, by the Gaussian process.
fn improvement(known: &Known<'_>) -> Result<Option<usize>, StudyError> {
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
