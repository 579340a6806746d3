//! Simulated laboratories: how many samples must be cut until one is on target.
//!
//! The true ratio of a sample is unknown to every model: it is the steady ratio at the true Young's modulus, times a
//! mechanism that may or may not be one of the discrepancy's forms, times the scatter of the sample. A laboratory cuts
//! the sample that a policy chooses, measures it with errors, and continues until a sample is truly on target.
//! The page that the book quotes is updated by
//! `SLIPGRID_UPDATE_GUIDE=1 cargo test --release -p slipgrid-tests --test laboratories -- --ignored the_kept_page`.

#![allow(clippy::unwrap_used, reason = "a test that unwraps in vain fails, as it should")]

mod physics;
mod policy;
mod report;
mod truth;

use rayon::prelude::*;
use slipgrid_base::statistics::{Normals, normal_probability};
use slipgrid_infer::discrepancy::{DimensionShift, Trial};

use physics::{LOADS, Solved};
use policy::{Known, all_dimension_shifts, candidate, learned, wanted};
use slipgrid_io::Failure;
use truth::{Laboratory, around, is_within};

pub use policy::Policy;
pub use report::{ChanceBin, Coverage, LaboratoriesReport, PolicyReport, Reliability, StartReport};
pub use truth::Mechanism;

/// Measurements available before the first cut for the target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// No measurements.
    Nothing,
    /// One randomly chosen groove.
    OneGroove,
    /// The published squares.
    PublishedSquares,
}

impl Start {
    /// All starts.
    pub const ALL: [Self; 3] = [Self::Nothing, Self::OneGroove, Self::PublishedSquares];

    /// Name of the start in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Nothing => "nothing measured",
            Self::OneGroove => "one groove measured",
            Self::PublishedSquares => "published squares measured",
        }
    }
}

/// Number of laboratories, and textures from which they choose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// Number of laboratories for each start; they take the mechanisms in turn.
    pub laboratories: usize,
    /// Maximum number of trials of a laboratory.
    pub most_trials: usize,
    /// Number of widths, and of spacings, of the grooves.
    pub steps: usize,
    /// Seed of the laboratories.
    pub seed: u64,
}

impl Default for Options {
    fn default() -> Self {
        Self { laboratories: 207, most_trials: 12, steps: 12, seed: 1 }
    }
}

/// Laboratory with its start, policy and kind of target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Job {
    /// Measurements before the first cut.
    pub start: Start,
    /// Policy that chooses the textures.
    pub policy: Policy,
    /// Number of the laboratory, which determines its truth and errors.
    pub number: usize,
    /// Kind of target.
    pub target: TargetOf,
}

impl Job {
    /// Jobs for every policy in every laboratory from every start, and for the mixture also with arbitrary targets.
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

/// Relation of a target to the truth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TargetOf {
    /// Some texture truly reaches the target, which no policy is told.
    Reached,
    /// An arbitrary target, which possibly no texture reaches.
    Any,
}

/// Course of one laboratory towards its target.
#[derive(Clone, Debug, PartialEq)]
pub struct Way {
    /// Number of trials until a sample was on target; `None` if none was.
    pub trials: Option<usize>,
    /// Predicted chance of every cut, and whether the sample was on target; for policies that predict chances.
    pub chances: Vec<(f64, bool)>,
    /// For every ratio measured in these cuts, the predicted probability of a lower value.
    pub below: Vec<f64>,
}

/// Textures from which laboratories choose, solved once for all of them.
pub struct Bench {
    options: Options,
    textures: Vec<Solved>,
    dimension_shifts: Vec<Vec<DimensionShift>>,
}

/// Laboratory before its first cut for the target.
struct Begun {
    laboratory: Laboratory,
    /// True ratios of each texture.
    truths: Vec<[f64; LOADS]>,
    target: [f64; LOADS],
    /// Textures that were cut and measured at the start.
    cut: Vec<usize>,
    trials: Vec<Trial>,
}

/// Runs every policy in every laboratory from every start.
pub fn run(options: &Options, policies: &[Policy]) -> Result<LaboratoriesReport, Failure> {
    let bench = Bench::new(options)?;
    let jobs = Job::all(options, policies);
    let ways: Vec<Way> = jobs.par_iter().map(|job| bench.way(*job)).collect::<Result<_, Failure>>()?;
    Ok(LaboratoriesReport::new(options, bench.textures.len(), &jobs, &ways))
}

/// Maximum number of trials of a laboratory with an arbitrary target.
const ANY_TRIALS: usize = 3;
/// Fraction of the tolerance within which some texture must truly reach a target.
const REACHED: f64 = 0.7;

/// Range of targets: minimum ratio at the middle pressures and width of its range, and maximum fall with pressure.
const MIDDLE: [f64; 2] = [0.65, 0.45];
const FALL: f64 = 0.08;
/// Minimum distance of a target from 1.
const NEAR_FLAT: f64 = 0.03;

/// Draws a target, a ratio at the middle pressures and a fall with pressure, independent of the truth; for
/// [`TargetOf::Reached`] until some texture reaches it.
fn target(truths: &[[f64; LOADS]], of: TargetOf, normals: &mut Normals) -> [f64; LOADS] {
    let mut uniform = || normal_probability(normals.draw());
    for _ in 0..10_000 {
        let (middle, fall) = (MIDDLE[0] + MIDDLE[1] * uniform(), FALL * uniform());
        if (middle - 1.0).abs() < NEAR_FLAT {
            continue;
        }
        let wanted: [f64; LOADS] = std::array::from_fn(|load| middle + fall * (0.5 - load as f64 / (LOADS - 1) as f64));
        let near = around(&wanted, REACHED * truth::TOLERANCE);
        if of == TargetOf::Any || truths.iter().any(|truth| is_within(truth, &near)) {
            return wanted;
        }
    }
    truths[0]
}

impl Job {
    /// Mechanism of the laboratory.
    pub const fn mechanism(&self) -> Mechanism {
        Mechanism::ALL[self.number % Mechanism::ALL.len()]
    }
}

impl Bench {
    /// Solves the textures.
    pub fn new(options: &Options) -> Result<Self, Failure> {
        let textures = physics::textures(options.steps)?;
        let dimension_shifts = all_dimension_shifts(&textures);
        Ok(Self { options: *options, textures, dimension_shifts })
    }

    /// Creates a laboratory with its target and the measurements of its start.
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

    /// Runs one laboratory until a sample is on target, or up to the maximum number of trials.
    ///
    /// # Errors
    /// [`Failure::Failed`] if nothing can be learned from the trials.
    pub fn way(&self, job: Job) -> Result<Way, Failure> {
        let (Self { options, textures, dimension_shifts, .. }, policy) = (self, job.policy);
        let Begun { mut laboratory, truths, target, mut cut, mut trials } = self.begin(job);
        let wanted = wanted(&target);
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
            };
            let place = policy.next(&known)?;
            let of = &textures[place];
            let made = laboratory.cut(of);
            let is_on_target = is_within(&made.truth, &around(&target, truth::TOLERANCE));
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
