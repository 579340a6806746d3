//! Evaluations: all results of the search model, held in memory and, if a cache is given, stored as soon as they are
//! known, so that an interrupted job loses only results in progress.
//!
//! Results depend on the model alone, so that one cache serves any target, limits and confirming runs.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::optimize::ModelFailure;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use slipgrid_model::pattern::Pattern;

use crate::DesignError;
use slipgrid_laser::specimen::{Laid, on_face};

/// Results of the model for a design at the target's pressures. Numbers have the units of the file, so that numbers
/// read back are bitwise equal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Answer {
    /// Friction of the patterned over the flat surface, at each pressure.
    pub ratio: Vec<f64>,
    /// Maximum local pressure at any target pressure.
    pub peak_pressure_mpa: f64,
    /// Minimum ratio of local to nominal pressure at any target pressure; negative under tension.
    pub least_pressure: f64,
    /// Minimum height of a cavity's ceiling above the counterface at any target pressure; `None` where no ceiling could
    /// sag.
    pub clearance_um: Option<f64>,
}

/// Maximum magnitude of a number in an answer: far above results of the model, far below overflow of sums.
pub const LARGEST: f64 = 1e9;

impl Answer {
    /// Scales the ratios of a periodic cell to the face of the sample `made`, laid out as in `laid`, by the areal
    /// density of the sample over that of the infinite pattern.
    #[must_use]
    pub fn on(self, laid: &Laid, made: &Pattern) -> Self {
        let share = laid.share(made);
        Self { ratio: self.ratio.iter().map(|ratio| on_face(*ratio, share)).collect(), ..self }
    }

    /// Checks that the numbers can be results of the model at `loads` loads.
    ///
    /// # Errors
    /// [`Fault`] with the reason and the expected values.
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
        beyond.map_or(Ok(()), |(name, value)| {
            let reason = format!("answer.{name}: {value:e} is out of range");
            Err(Fault { reason, expected: format!("a number up to {LARGEST:e}") })
        })
    }

    /// Maximum local pressure, in pascals.
    pub fn peak_pressure_pa(&self) -> f64 {
        self.peak_pressure_mpa * 1e6
    }

    /// Minimum height of a cavity's ceiling above the counterface, in metres; `None` if no ceiling could sag.
    pub fn clearance_m(&self) -> Option<f64> {
        self.clearance_um.map(|clearance_um| clearance_um * 1e-6)
    }
}

/// Results of the model, or the reason why there are none.
pub type Answered = Result<Answer, String>;

/// Reason why a stored answer is not valid.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// Description of the fault.
    pub reason: String,
    /// Expected content.
    pub expected: String,
}

/// Results of the model together with the lengths of the design.
#[derive(Clone, Debug, PartialEq)]
pub struct Evaluation {
    /// Size of the model's blocks and width, spacing and depth of the design, in micrometres.
    pub lengths_um: [f64; 4],
    /// Results of the model, or the reason why there are none.
    pub answered: Answered,
}

/// Stores evaluations of the model for later runs of the program.
pub trait EvaluationCache: Sync {
    /// Loads the stored evaluations for `key`, with one ratio for each of `loads` loads; called once, before the first
    /// query.
    ///
    /// # Errors
    /// Reason why the cache cannot be used.
    fn open(&mut self, key: &Map<String, Value>, loads: usize) -> Result<Vec<Evaluation>, String>;

    /// Stores `evaluation`; called by any thread, once per design.
    ///
    /// # Errors
    /// Reason why the evaluation could not be stored.
    fn keep(&self, evaluation: &Evaluation) -> Result<(), String>;

    /// Describes the place of storage to users.
    fn place(&self) -> String;
}

/// Cache that stores nothing.
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

/// Bits of four numbers in micrometres: block size, and width, spacing and depth of a design.
type Key = [u64; 4];

/// Known evaluations of the model, and the cache that stores new ones.
#[derive(Default)]
pub struct Evaluations<'a> {
    known: Mutex<BTreeMap<Key, Answered>>,
    /// Number of ratios of each answer, one per load.
    loads: usize,
    cache: Option<&'a dyn EvaluationCache>,
}

impl<'a> Evaluations<'a> {
    /// Loads the evaluations that `cache` holds for `key`, with ratios at `loads` loads; also returns their number.
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

    /// Returns the results for `design` in blocks of size `block_m`, in metres: known results, or those of a call of
    /// `model`.
    ///
    /// # Errors
    /// [`ModelFailure`] of the model, and [`ModelFailure::Broken`] where the cache cannot store the results.
    pub fn answer(
        &self,
        block_m: f64,
        design: &Pattern,
        model: impl FnOnce() -> Result<Answer, ModelFailure>,
    ) -> Result<Answer, ModelFailure> {
        let lengths_m = [block_m, design.width_m(), design.spacing_m(), design.depth_m()];
        let lengths_um = lengths_m.map(|length_m| length_m * 1e6);
        let key: Key = lengths_um.map(f64::to_bits);
        if let Some(known) = self.known().get(&key) {
            return known.clone().map_err(ModelFailure::Trial);
        }
        let answered = match model() {
            Ok(answer) => Ok(answer),
            Err(ModelFailure::Trial(reason)) => Err(reason),
            Err(other) => return Err(other),
        };
        // Two threads may solve one design at once: the first readable answer is kept.
        let is_readable = answered.as_ref().map_or(true, |answer| answer.check(self.loads).is_ok());
        if self.known().insert(key, answered.clone()).is_none()
            && is_readable
            && let Some(cache) = self.cache
        {
            let evaluation = Evaluation { lengths_um, answered: answered.clone() };
            cache.keep(&evaluation).map_err(ModelFailure::Broken)?;
        }
        answered.map_err(ModelFailure::Trial)
    }

    /// Locks the known evaluations. Entries are inserted complete, so that entries of a panicked thread are valid.
    fn known(&self) -> MutexGuard<'_, BTreeMap<Key, Answered>> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
