//! Results of the simulated laboratories as numbers and text.

use super::{Job, Mechanism, Options, Policy, Start, TargetOf, Way};
use slipgrid_base::units::tidy;

/// Number of bins of the predicted chance.
const BINS: usize = 10;

/// Number of trials that each policy needs, and reliability of its predictions.
#[derive(Clone, Debug, PartialEq)]
pub struct LaboratoriesReport {
    /// Number of laboratories for each start.
    pub laboratories: usize,
    /// Maximum number of trials of a laboratory.
    pub most_trials: usize,
    /// Number of textures to choose from.
    pub textures: usize,
    /// Seed of the laboratories.
    pub seed: u64,
    /// Results by start.
    pub starts: Vec<StartReport>,
    /// Reliability of predicted chances, over all starts.
    pub chances: Vec<Reliability>,
    /// Results of the mixture by mechanism, over all starts: trials, and coverage of the intervals for the next trial's
    /// ratios.
    pub coverage: Vec<Coverage>,
}

/// Results of every policy for one start.
#[derive(Clone, Debug, PartialEq)]
pub struct StartReport {
    /// Name of the start.
    pub start: String,
    /// Results by policy.
    pub policies: Vec<PolicyReport>,
}

/// Number of trials of a policy until a sample was on target; one more than the maximum if none was.
#[derive(Clone, Debug, PartialEq)]
pub struct PolicyReport {
    /// Name of the policy.
    pub policy: String,
    /// Median number of trials.
    pub median: f64,
    /// Mean number of trials.
    pub mean: f64,
    /// Fraction of laboratories on target within three trials.
    pub within_3: f64,
    /// The same fraction for mechanisms inside the family of forms.
    pub within_3_inside: f64,
    /// The same fraction for mechanisms outside the family of forms.
    pub within_3_outside: f64,
    /// Fraction of laboratories that never were on target.
    pub never: f64,
}

/// Predicted chances compared with the observed frequency.
#[derive(Clone, Debug, PartialEq)]
pub struct Reliability {
    /// Policy and kind of targets, in words.
    pub of: String,
    /// All chances together.
    pub all: ChanceBin,
    /// Chances in bins of the predicted value, without empty bins.
    pub bins: Vec<ChanceBin>,
}

impl Reliability {
    fn new(of: &str, said: &[(f64, bool)]) -> Self {
        let bin = |own: &[(f64, bool)]| {
            let share = |sum: f64| if own.is_empty() { 0.0 } else { tidy(sum / own.len() as f64) };
            ChanceBin {
                cuts: own.len(),
                said: share(own.iter().map(|(said, _)| said).sum()),
                came_true: share(own.iter().filter(|(_, came_true)| *came_true).count() as f64),
            }
        };
        let at = |place: usize| {
            let is_inside = |said: f64| (said * BINS as f64).floor().clamp(0.0, BINS as f64 - 1.0) == place as f64;
            bin(&said.iter().copied().filter(|(said, _)| is_inside(*said)).collect::<Vec<_>>())
        };
        let bins = (0..BINS).map(at).filter(|bin| bin.cuts > 0).collect();
        Self { of: of.to_owned(), all: bin(said), bins }
    }

    /// Reliability of the mixture and of the known form for targets that some texture reaches, and of the mixture for
    /// arbitrary targets.
    fn all(jobs: &[Job], ways: &[Way]) -> Vec<Self> {
        let said = |is_own: &dyn Fn(&Job) -> bool| -> Vec<(f64, bool)> {
            let own = jobs.iter().zip(ways).filter(|(job, _)| is_own(job));
            own.flat_map(|(_, way)| way.chances.iter().copied()).collect()
        };
        let mixture = |job: &Job| job.policy == Policy::Mixture && job.target == TargetOf::Reached;
        let mut found = vec![
            Self::new("targets that some texture reaches, which nobody is told", &said(&mixture)),
            Self::new("the same with the form known", &said(&|job| job.policy == Policy::Form)),
            Self::new(
                "targets whether a texture reaches them or not, first three cuts",
                &said(&|job| job.policy == Policy::Mixture && job.target == TargetOf::Any),
            ),
        ];
        found.retain(|of| of.all.cuts > 0);
        found
    }
}

/// Bin of predicted chances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChanceBin {
    /// Number of cuts.
    pub cuts: usize,
    /// Mean predicted chance.
    pub said: f64,
    /// Observed fraction on target.
    pub came_true: f64,
}

/// Fraction of measured ratios within the predicted intervals.
#[derive(Clone, Debug, PartialEq)]
pub struct Coverage {
    /// Name of the mechanism; "all" for all mechanisms.
    pub mechanism: String,
    /// Number of measured ratios.
    pub ratios: usize,
    /// Fraction within the 68 % interval.
    pub of_68: f64,
    /// Fraction within the 95 % interval.
    pub of_95: f64,
    /// Mean number of trials.
    pub mean_trials: f64,
    /// Fraction of laboratories on target within three trials.
    pub within_3: f64,
}

impl LaboratoriesReport {
    /// Creates the report from the courses `ways` of the `jobs`; `textures` is the number of textures.
    pub fn new(options: &Options, textures: usize, jobs: &[Job], ways: &[Way]) -> Self {
        let mut starts: Vec<StartReport> = Vec::new();
        for start in Start::ALL {
            let mut policies = Vec::new();
            for policy in Policy::ALL {
                let is_own = |(job, _): &(&Job, &Way)| {
                    job.start == start && job.policy == policy && job.target == TargetOf::Reached
                };
                let own: Vec<(&Job, &Way)> = jobs.iter().zip(ways).filter(is_own).collect();
                if !own.is_empty() {
                    policies.push(PolicyReport::new(policy, options, &own));
                }
            }
            starts.push(StartReport { start: start.name().to_owned(), policies });
        }
        let coverage = |name: &str, of: &dyn Fn(Mechanism) -> bool| {
            let is_own =
                |job: &Job| job.policy == Policy::Mixture && job.target == TargetOf::Reached && of(job.mechanism());
            let below: Vec<f64> = jobs
                .iter()
                .zip(ways)
                .filter(|(job, _)| is_own(job))
                .flat_map(|(_, way)| way.below.iter().copied())
                .collect();
            let share = |half: f64| {
                let inside = below.iter().filter(|below| (**below - 0.5).abs() <= half).count();
                tidy(inside as f64 / below.len().max(1) as f64)
            };
            let own = jobs.iter().zip(ways).filter(|(job, _)| is_own(job));
            let trials: Vec<usize> = own.map(|(_, way)| way.trials.unwrap_or(options.most_trials + 1)).collect();
            let count = trials.len().max(1) as f64;
            Coverage {
                mechanism: name.to_owned(),
                ratios: below.len(),
                of_68: share(0.34),
                of_95: share(0.475),
                mean_trials: tidy(trials.iter().sum::<usize>() as f64 / count),
                within_3: tidy(trials.iter().filter(|trials| **trials <= 3).count() as f64 / count),
            }
        };
        let mut coverages = vec![coverage("all", &|_| true)];
        let of = |own: &Mechanism| coverage(own.name(), &|mechanism| mechanism == *own);
        coverages.extend(Mechanism::ALL.iter().map(of));
        Self {
            laboratories: options.laboratories,
            most_trials: options.most_trials,
            textures,
            seed: options.seed,
            starts,
            chances: Reliability::all(jobs, ways),
            coverage: coverages,
        }
    }

    /// Formats the report as tables in Markdown.
    pub fn lines(&self) -> Vec<String> {
        let mut lines = vec![
            format!(
                "{} laboratories of each start, {} textures, at most {} trials, seed {}",
                self.laboratories, self.textures, self.most_trials, self.seed
            ),
            String::new(),
            "| start | policy | median | mean | within 3 | inside | outside | never |".to_owned(),
            "|---|---|---|---|---|---|---|---|".to_owned(),
        ];
        let percent = |share: f64| format!("{:.0} %", 100.0 * share);
        for start in &self.starts {
            for of in &start.policies {
                lines.push(format!(
                    "| {} | {} | {} | {:.2} | {} | {} | {} | {} |",
                    start.start,
                    of.policy,
                    of.median,
                    of.mean,
                    percent(of.within_3),
                    percent(of.within_3_inside),
                    percent(of.within_3_outside),
                    percent(of.never)
                ));
            }
        }
        for of in &self.chances {
            lines.extend([String::new(), format!("Chances: {}", of.of), String::new()]);
            lines.extend(["| chance said | came true | cuts |".to_owned(), "|---|---|---|".to_owned()]);
            let row = |name: &str, bin: &ChanceBin| {
                format!("| {name}{:.2} | {:.2} | {} |", bin.said, bin.came_true, bin.cuts)
            };
            lines.extend(of.bins.iter().map(|bin| row("", bin)));
            lines.push(row("all: ", &of.all));
        }
        lines.extend([
            String::new(),
            "| mechanism | mean trials | within 3 | ratios within 68 % | within 95 % | ratios |".to_owned(),
            "|---|---|---|---|---|---|".to_owned(),
        ]);
        lines.extend(self.coverage.iter().map(|of| {
            format!(
                "| {} | {:.2} | {} | {:.3} | {:.3} | {} |",
                of.mechanism,
                of.mean_trials,
                percent(of.within_3),
                of.of_68,
                of.of_95,
                of.ratios
            )
        }));
        lines
    }
}

impl PolicyReport {
    fn new(policy: Policy, options: &Options, ways: &[(&Job, &Way)]) -> Self {
        let never = options.most_trials + 1;
        let mut trials: Vec<f64> = ways.iter().map(|(_, way)| way.trials.unwrap_or(never) as f64).collect();
        let share = |of: &dyn Fn(&Way) -> bool, among: &dyn Fn(&Job) -> bool| {
            let among: Vec<&Way> = ways.iter().filter(|(job, _)| among(job)).map(|(_, way)| *way).collect();
            tidy(among.iter().filter(|way| of(way)).count() as f64 / among.len().max(1) as f64)
        };
        let soon = |way: &Way| way.trials.is_some_and(|trials| trials <= 3);
        Self {
            policy: policy.name().to_owned(),
            mean: tidy(trials.iter().sum::<f64>() / trials.len().max(1) as f64),
            median: slipgrid_base::statistics::median(&mut trials).unwrap_or(f64::NAN),
            within_3: share(&soon, &|_| true),
            within_3_inside: share(&soon, &|job| job.mechanism().is_inside()),
            within_3_outside: share(&soon, &|job| !job.mechanism().is_inside()),
            never: share(&|way| way.trials.is_none(), &|_| true),
        }
    }
}
