//! Simulated laboratories: how many samples must be cut until one is on target.
//!
//! A laboratory has a truth that no model knows: the steady ratio at its polymer's own Young's modulus, times a mechanism that
//! is one of the discrepancy's forms or none of them, times each sample's own scatter. It cuts what a policy chooses, measures
//! it with errors, and goes on until a sample is truly on target. The page that the book quotes is kept by
//! `SLIPGRID_UPDATE_GUIDE=1 cargo test --release -p slipgrid-tests --test laboratories -- --ignored the_kept_page`.

#![allow(clippy::unwrap_used, reason = "a test that unwraps in vain fails, as it should")]

mod draws;
mod generator;
mod physics;
mod policy;
mod report;
mod truth;

use rayon::prelude::*;
use serde::Serialize;
use slipgrid_discrepancy::{DimensionShift, Trial};
use slipgrid_monitor::{Monitor, Stage};
use slipgrid_statistics::{Normals, normal_probability};

use draws::{around, is_within};
use generator::{Generator, Sizes};
use physics::{LOADS, Solved};
use policy::{Informed, Known, Told, all_dimension_shifts, candidate, learned, wanted};
use slipgrid_studies::StudyError;
use truth::Laboratory;

pub use policy::Policy;
pub use report::{ChanceBin, Coverage, LaboratoriesReport, PolicyReport, Reliability, StartReport};
pub use truth::Mechanism;

/// What a laboratory knows before its first cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// Nothing was measured.
    Nothing,
    /// One groove, taken at random, was.
    OneGroove,
    /// The published squares were.
    PublishedSquares,
}

impl Start {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Nothing, Self::OneGroove, Self::PublishedSquares];

    /// In words.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Nothing => "nothing measured",
            Self::OneGroove => "one groove measured",
            Self::PublishedSquares => "published squares measured",
        }
    }
}

/// How many laboratories, and what they may choose from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Options {
    /// Laboratories of each start, the mechanisms in turn.
    pub laboratories: usize,
    /// Most trials of a laboratory.
    pub most_trials: usize,
    /// Widths and spacings of the textures.
    pub steps: usize,
    /// Seed of the laboratories.
    pub seed: u64,
}

impl Default for Options {
    fn default() -> Self {
        Self { laboratories: 207, most_trials: 12, steps: 12, seed: 1 }
    }
}

/// A laboratory with what it knows at first, and how it chooses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Job {
    /// What it knows.
    pub start: Start,
    /// How it chooses.
    pub policy: Policy,
    /// Which laboratory: its truth and its errors.
    pub number: usize,
    /// What its target is.
    pub target: TargetOf,
}

impl Job {
    /// Every policy in every laboratory from every start, and the mixture once more whatever the target.
    #[must_use]
    pub fn all(options: &Options, policies: &[Policy]) -> Vec<Self> {
        let mut all = Self::of_reached_targets(options, policies);
        if policies.contains(&Policy::Mixture) {
            let mixture = Self::of_reached_targets(options, &[Policy::Mixture]);
            all.extend(mixture.into_iter().map(|job| Self { target: TargetOf::Any, ..job }));
        }
        all
    }

    fn of_reached_targets(options: &Options, policies: &[Policy]) -> Vec<Self> {
        let starts = Start::ALL.into_iter().flat_map(|start| policies.iter().map(move |policy| (start, *policy)));
        let of = |(start, policy)| {
            (0..options.laboratories).map(move |number| Self { start, policy, number, target: TargetOf::Reached })
        };
        starts.flat_map(of).collect()
    }
}

/// What a laboratory's target says of the truth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TargetOf {
    /// Some texture truly reaches it, which no policy is told.
    Reached,
    /// Nothing: no texture may reach it.
    Any,
}

impl TargetOf {
    /// Both kinds.
    pub const ALL: [Self; 2] = [Self::Reached, Self::Any];
}

/// What one laboratory's way to the target was.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Way {
    /// Trials until a sample was on target; `None` where none was.
    pub trials: Option<usize>,
    /// Of every cut by the mixture, by who knows the form or by who knows how laboratories are made: the chance that was said, and whether it came true.
    pub chances: Vec<(f64, bool)>,
    /// Of every ratio measured then, the share of what was predicted that lay below it.
    pub below: Vec<f64>,
}

/// What laboratories choose from, solved once for all of them.
pub struct Bench {
    options: Options,
    textures: Vec<Solved>,
    dimension_shifts: Vec<Vec<DimensionShift>>,
    /// What [`Policy::Generator`] knows.
    generator: Generator,
    told: Told,
}

/// A laboratory before its first cut for the target.
struct Begun {
    laboratory: Laboratory,
    /// What each texture truly does.
    truths: Vec<[f64; LOADS]>,
    target: [f64; LOADS],
    /// What was cut and measured before.
    cut: Vec<usize>,
    trials: Vec<Trial>,
}

/// Runs every policy in every laboratory from every start.
///
/// # Errors
/// [`StudyError::Cancelled`] once `monitor` has cancelled.
pub fn run(options: &Options, policies: &[Policy], monitor: &dyn Monitor) -> Result<LaboratoriesReport, StudyError> {
    let bench = Bench::new(options, monitor)?;
    let stage = Stage::new(monitor, "laboratories", None);
    let jobs = Job::all(options, policies);
    let share = 1.0 / jobs.len().max(1) as f64;
    let ways: Vec<Way> = jobs
        .par_iter()
        .map(|job| {
            stage.heed()?;
            let way = bench.way(*job);
            stage.advance(share);
            way
        })
        .collect::<Result<_, StudyError>>()?;
    stage.finish();
    Ok(LaboratoriesReport::new(options, bench.textures(), &jobs, &ways))
}

/// Most trials of a laboratory whose target may be reached by no texture.
const ANY_TRIALS: usize = 3;
/// Share of the tolerance within which some texture must truly reach a target.
const REACHED: f64 = 0.7;

/// Least ratio of a target at the middle pressures and by how much more it may be; how much it may fall with pressure.
const MIDDLE: [f64; 2] = [0.65, 0.45];
const FALL: f64 = 0.08;
/// No target is as near to 1.
const NEAR_FLAT: f64 = 0.03;

/// What a `fall` with pressure does at a load.
fn at_fall(fall: f64, load: usize) -> f64 {
    fall * (0.5 - load as f64 / (LOADS - 1) as f64)
}

/// A target that says nothing of the truth, but that a texture reaches it where it is to be so: a ratio at the middle pressures
/// and how much it falls with pressure, at random.
fn target(truths: &[[f64; LOADS]], of: TargetOf, normals: &mut Normals) -> [f64; LOADS] {
    let mut uniform = || normal_probability(normals.draw());
    for _ in 0..10_000 {
        let (middle, fall) = (MIDDLE[0] + MIDDLE[1] * uniform(), FALL * uniform());
        if (middle - 1.0).abs() < NEAR_FLAT {
            continue;
        }
        let wanted: [f64; LOADS] = std::array::from_fn(|load| middle + at_fall(fall, load));
        let near = around(&wanted, REACHED * truth::TOLERANCE);
        if of == TargetOf::Any || truths.iter().any(|truth| is_within(truth, &near)) {
            return wanted;
        }
    }
    truths[0]
}

impl Job {
    /// The truth of its laboratory.
    #[must_use]
    pub const fn mechanism(&self) -> Mechanism {
        Mechanism::ALL[self.number % Mechanism::ALL.len()]
    }
}

impl Bench {
    /// Solves the textures.
    ///
    /// # Errors
    /// [`StudyError::Cancelled`] once `monitor` has cancelled.
    pub fn new(options: &Options, monitor: &dyn Monitor) -> Result<Self, StudyError> {
        let stage = Stage::new(monitor, "textures", None);
        let textures = physics::textures(options.steps, &stage)?;
        stage.finish();
        let dimension_shifts = all_dimension_shifts(&textures);
        let generator = Generator::new(&textures, &Mechanism::ALL, Sizes::Own);
        Ok(Self { options: *options, textures, dimension_shifts, generator, told: Told::ALL })
    }

    /// How many textures there are.
    #[must_use]
    pub const fn textures(&self) -> usize {
        self.textures.len()
    }

    /// A laboratory with its target, and what was measured at first.
    fn begin(&self, job: Job) -> Begun {
        let (Self { options, textures, .. }, Job { start, number, .. }) = (self, job);
        let mut laboratory = Laboratory::new(job.mechanism(), number, options.seed);
        let mut normals = Normals::new(options.seed.wrapping_mul(31).wrapping_add(number as u64));
        let truths: Vec<[f64; LOADS]> = textures.iter().map(|of| laboratory.truth(of)).collect();
        let target = target(&truths, job.target, &mut normals);
        let first = match start {
            Start::Nothing => None,
            Start::OneGroove => {
                let grooves = textures.iter().filter(|of| of.pattern.is_uniform_along_y()).count();
                let place = normal_probability(normals.draw()) * grooves as f64;
                Some((place as usize).min(grooves - 1))
            }
            Start::PublishedSquares => Some(textures.len() - 1),
        };
        let trials = first.map(|place| laboratory.cut(&textures[place]).trial);
        Begun { laboratory, truths, target, cut: first.into_iter().collect(), trials: trials.into_iter().collect() }
    }

    /// The way of one laboratory to its target.
    ///
    /// # Errors
    /// [`StudyError::Failed`] where nothing can be learned from its trials.
    pub fn way(&self, job: Job) -> Result<Way, StudyError> {
        let (Self { options, textures, dimension_shifts, .. }, policy) = (self, job.policy);
        let Begun { mut laboratory, truths, target, mut cut, mut trials } = self.begin(job);
        let (wanted, judged_from) = (wanted(&target), trials.len());
        let mut found = Way { trials: None, chances: Vec::new(), below: Vec::new() };
        let most = match job.target {
            TargetOf::Reached => options.most_trials,
            TargetOf::Any => options.most_trials.min(ANY_TRIALS),
        };
        for count in 1..=most {
            let known = Known {
                textures,
                dimension_shifts,
                cut: &cut,
                trials: &trials,
                target: &target,
                form: laboratory.form(),
                truths: &truths,
                noise: laboratory.noise,
                judged_from,
            };
            let told = Told { is_reached: self.told.is_reached && job.target == TargetOf::Reached, ..self.told };
            let informed =
                (policy == Policy::Generator).then(|| Informed::new(&self.generator, told, &known)).transpose()?;
            let place = match &informed {
                Some(informed) => informed.next(&known)?,
                None => policy.next(&known)?,
            };
            let of = &textures[place];
            let made = laboratory.cut(of);
            let is_on_target = is_within(&made.truth, &around(&target, truth::TOLERANCE));
            if let Some(informed) = &informed {
                found.chances.push((informed.chance(place), is_on_target));
                found.below.extend(informed.below(place, &made.trial));
            }
            if let Some(hyper) = policy.hyperparameters(laboratory.form()) {
                let prediction = learned(&hyper, &trials)?.of(&candidate(of, &dimension_shifts[place]));
                found.chances.push((wanted.score(&prediction, &of.ratio).chance, is_on_target));
                // Errors of the measurement: its own and the flat sample's.
                let errors: Vec<f64> = (0..LOADS * LOADS)
                    .map(|entry| {
                        if entry % (LOADS + 1) == 0 {
                            (1.0 + truth::FLAT_SHARE.powi(2)) * laboratory.noise.powi(2)
                        } else {
                            0.0
                        }
                    })
                    .collect();
                let prediction = prediction.with(&errors);
                found.below.extend(
                    made.trial
                        .measured
                        .iter()
                        .enumerate()
                        .map(|(load, at)| prediction.probability_below(load, at.log_excess())),
                );
            }
            if is_on_target {
                found.trials = Some(count);
                break;
            }
            cut.push(place);
            trials.push(made.trial);
        }
        Ok(found)
    }
}

#[cfg(test)]
mod tests;
