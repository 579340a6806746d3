//! Evaluations: every answer of the search's model, kept in memory and, where a cache is given, beyond the run as soon as it
//! is known, so that a killed run loses no more than what was being computed.
//!
//! Answers are those of the model alone, before anything that depends on target, limits or confirming runs: a cache serves
//! any of these.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use slipgrid_optimize::ModelFailure;
use slipgrid_pattern::Pattern;

use crate::DesignError;
use slipgrid_specimen::{Laid, on_face};

/// What the model says of a design at the target's pressures. Numbers are kept as the file holds them, so that those
/// read back are the same to the last bit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Answer {
    /// Friction, patterned over flat, at each pressure.
    pub ratio: Vec<f64>,
    /// Largest local pressure over all of them.
    pub peak_pressure_mpa: f64,
    /// Least local pressure over the nominal one: negative under tension.
    pub least_pressure: f64,
    /// Least height of a ceiling above the counterface; absent where nothing could sag.
    pub clearance_um: Option<f64>,
}

/// Largest size of a number in an answer: far above anything the model gives, far below where sums overflow.
pub const LARGEST: f64 = 1e9;

impl Answer {
    /// A cell's answer on the face of `made`, a sample of what was `laid`.
    #[must_use]
    pub fn on(self, laid: &Laid, made: &Pattern) -> Self {
        let share = laid.share(made);
        Self { ratio: self.ratio.iter().map(|ratio| on_face(*ratio, share)).collect(), ..self }
    }

    /// Whether these can be the model's numbers at `loads` loads.
    ///
    /// # Errors
    /// What is wrong, and what would be right.
    pub fn check(&self, loads: usize) -> Result<(), Fault> {
        let positive = |value: f64| value > 0.0 && value <= LARGEST;
        if self.ratio.len() != loads {
            let reason = format!("answer.ratio: has {} ratios", self.ratio.len());
            return Err(Fault { reason, expected: format!("{loads}, one for each load of each condition") });
        }
        if let Some(place) = self.ratio.iter().position(|&ratio| !positive(ratio)) {
            let reason = format!("answer.ratio: {:e} is no ratio of two frictions", self.ratio[place]);
            return Err(Fault { reason, expected: "positive numbers".to_owned() });
        }
        let sizes = [("least_pressure", self.least_pressure), ("clearance_um", self.clearance_um.unwrap_or(0.0))];
        let beyond = sizes.into_iter().find(|(_, value)| value.is_nan() || value.abs() > LARGEST);
        let beyond =
            beyond.or(Some(("peak_pressure_mpa", self.peak_pressure_mpa)).filter(|&(_, value)| !positive(value)));
        match beyond {
            Some((name, value)) => Err(Fault {
                reason: format!("answer.{name}: {value:e} is out of range"),
                expected: format!("a number up to {LARGEST:e}"),
            }),
            None => Ok(()),
        }
    }

    /// Largest local pressure, in pascals.
    #[must_use]
    pub fn peak_pressure_pa(&self) -> f64 {
        self.peak_pressure_mpa * 1e6
    }

    /// Least height of a ceiling, in metres.
    #[must_use]
    pub fn clearance_m(&self) -> Option<f64> {
        self.clearance_um.map(|clearance_um| clearance_um * 1e-6)
    }
}

/// An answer, or why there is none.
pub type Answered = Result<Answer, String>;

/// What is wrong with an answer that was kept.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// What is wrong.
    pub reason: String,
    /// What would be right.
    pub expected: String,
}

/// An answer with the design that it is of.
#[derive(Clone, Debug, PartialEq)]
pub struct Evaluation {
    /// Size of the model's blocks and width, spacing and depth of the design, in micrometres.
    pub lengths_um: [f64; 4],
    /// What the model says.
    pub answered: Answered,
}

/// Keeps answers beyond one run.
pub trait EvaluationCache: Sync {
    /// The answers that are known already among those that depend on `key` and have ratios at `loads` loads; called once,
    /// before the first question.
    ///
    /// # Errors
    /// Why the cache cannot be used.
    fn open(&mut self, key: &Map<String, Value>, loads: usize) -> Result<Vec<Evaluation>, String>;

    /// Keeps `evaluation`; called by any thread, once for each design.
    ///
    /// # Errors
    /// Why it could not be kept.
    fn keep(&self, evaluation: &Evaluation) -> Result<(), String>;

    /// Where answers are kept, for people.
    fn place(&self) -> String;
}

/// A cache that keeps nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoCache;

impl EvaluationCache for NoCache {
    fn open(&mut self, _: &Map<String, Value>, _: usize) -> Result<Vec<Evaluation>, String> {
        Ok(Vec::new())
    }

    fn keep(&self, _: &Evaluation) -> Result<(), String> {
        Ok(())
    }

    fn place(&self) -> String {
        "nowhere".to_owned()
    }
}

/// Block size and lengths of a design in micrometres, by their bits.
type Key = [u64; 4];

/// What has been answered so far.
#[derive(Default)]
pub struct Evaluations<'a> {
    known: Mutex<BTreeMap<Key, Answered>>,
    /// Loads that an answer has ratios at.
    loads: usize,
    cache: Option<&'a dyn EvaluationCache>,
}

impl<'a> Evaluations<'a> {
    /// Evaluations that begin with what `cache` knows of the model with this `key`, whose answers have ratios at `loads`
    /// loads; and how many these are.
    ///
    /// # Errors
    /// [`DesignError::Cache`] where the cache cannot be used.
    pub fn cached(
        cache: &'a mut dyn EvaluationCache,
        key: &Map<String, Value>,
        loads: usize,
    ) -> Result<(Self, usize), DesignError> {
        let mut known = BTreeMap::new();
        for evaluation in cache.open(key, loads).map_err(DesignError::Cache)? {
            known.entry(evaluation.lengths_um.map(f64::to_bits)).or_insert(evaluation.answered);
        }
        let count = known.len();
        Ok((Self { known: Mutex::new(known), loads, cache: Some(cache) }, count))
    }

    /// The answer to `design` in blocks of `block_m`: known, or by `model`.
    ///
    /// # Errors
    /// [`ModelFailure`] of the model, and [`ModelFailure::Broken`] where the cache cannot keep the answer.
    pub fn answer(
        &self,
        block_m: f64,
        design: &Pattern,
        model: impl FnOnce() -> Result<Answer, ModelFailure>,
    ) -> Result<Answer, ModelFailure> {
        let lengths_m = [block_m, design.width_m(), design.spacing_m(), design.depth_m()];
        let lengths_um = lengths_m.map(|length_m| length_m * 1e6);
        let key: Key = lengths_um.map(f64::to_bits);
        let trial = |reason: String| ModelFailure::Trial { reason };
        if let Some(known) = self.known().get(&key) {
            return known.clone().map_err(trial);
        }
        let answered = match model() {
            Ok(answer) => Ok(answer),
            Err(ModelFailure::Trial { reason }) => Err(reason),
            Err(other) => return Err(other),
        };
        // Two threads may have come to one design: its first answer is kept, if it could be read again.
        let is_readable = answered.as_ref().map_or(true, |answer| answer.check(self.loads).is_ok());
        if self.known().insert(key, answered.clone()).is_none()
            && is_readable
            && let Some(cache) = self.cache
        {
            let evaluation = Evaluation { lengths_um, answered: answered.clone() };
            cache.keep(&evaluation).map_err(|reason| ModelFailure::Broken { reason })?;
        }
        answered.map_err(trial)
    }

    /// Entries are whole when they enter: those of a panicking thread are as good as any.
    fn known(&self) -> MutexGuard<'_, BTreeMap<Key, Answered>> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
