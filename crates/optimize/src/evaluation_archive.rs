//! Evaluates designs, judges them, and remembers each.

use crate::{Candidate, Constraints, FailedTrial, ForwardModel, ModelFailure, Response, SearchError, Target};
use slipgrid_monitor::Monitor;
use slipgrid_pattern::Pattern;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

/// A design by the bits of its lengths.
pub(crate) type Key = [u64; 3];

pub(crate) fn key(design: &Pattern) -> Key {
    [design.width_m().to_bits(), design.spacing_m().to_bits(), design.depth_m().to_bits()]
}

/// One evaluated design.
#[derive(Clone, Debug)]
pub(crate) enum Record {
    Computed(Candidate),
    Failed(FailedTrial),
}

impl Record {
    fn design(&self) -> &Pattern {
        match self {
            Self::Computed(candidate) => &candidate.design,
            Self::Failed(trial) => &trial.design,
        }
    }

    pub(crate) const fn candidate(&self) -> Option<&Candidate> {
        match self {
            Self::Computed(candidate) => Some(candidate),
            Self::Failed(_) => None,
        }
    }

    pub(crate) const fn failure(&self) -> Option<&FailedTrial> {
        match self {
            Self::Computed(_) => None,
            Self::Failed(trial) => Some(trial),
        }
    }
}

/// Why no further design is evaluated.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Interruption {
    Budget,
    Cancelled,
    Error(SearchError),
}

/// Calls the model, judges its answers and reports progress. Shared by all threads.
pub(crate) struct Evaluator<'a> {
    pub(crate) model: &'a dyn ForwardModel,
    pub(crate) target: &'a Target,
    pub(crate) constraints: &'a Constraints,
    pub(crate) max_evaluations: usize,
    monitor: &'a dyn Monitor,
    cancelled: AtomicBool,
    /// What any thread has computed. It saves calls and changes no outcome, the model being a function
    /// of the design; a design that another thread is just computing is not waited for but computed
    /// again, as a thread that waits inside rayon can end up waiting for itself.
    memory: Mutex<BTreeMap<Key, Record>>,
}

impl<'a> Evaluator<'a> {
    pub(crate) fn new(
        model: &'a dyn ForwardModel,
        target: &'a Target,
        constraints: &'a Constraints,
        max_evaluations: usize,
        monitor: &'a dyn Monitor,
    ) -> Self {
        let (cancelled, memory) = (AtomicBool::new(false), Mutex::new(BTreeMap::new()));
        Self { model, target, constraints, max_evaluations, monitor, cancelled, memory }
    }

    pub(crate) fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }

    /// The record of `design`, computed unless some thread already has.
    pub(crate) fn evaluate(&self, design: &Pattern) -> Result<Record, Interruption> {
        if self.is_cancelled() {
            return Err(Interruption::Cancelled);
        }
        // Records are whole when they enter: those of a panicking thread are as good as any.
        let memory = || self.memory.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = memory().get(&key(design)) {
            return Ok(known.clone());
        }
        let failed = |reason: &str| Record::Failed(FailedTrial { design: *design, reason: reason.to_owned() });
        let record = match self.model.respond(design) {
            Ok(response) => {
                let (expected, got) = (self.target.values(), response.value.len());
                if got != expected {
                    return Err(Interruption::Error(SearchError::WrongResponse { expected, got }));
                }
                let (expected, got) = (self.constraints.quantities.len(), response.limited.len());
                if got != expected {
                    return Err(Interruption::Error(SearchError::WrongLimited { expected, got }));
                }
                if response.value.iter().chain(&response.limited).all(|value| value.is_finite()) {
                    Record::Computed(self.judge(design, response))
                } else {
                    failed("the model returned a value that is not finite")
                }
            }
            Err(ModelFailure::Trial { reason }) => failed(&reason),
            Err(ModelFailure::Broken { reason }) => {
                return Err(Interruption::Error(SearchError::BrokenModel { reason }));
            }
            Err(ModelFailure::Cancelled) => {
                self.cancelled.store(true, Ordering::Relaxed);
                return Err(Interruption::Cancelled);
            }
        };
        // Two threads may have computed it at once: it counts once.
        if memory().insert(key(design), record.clone()).is_none() {
            self.monitor.advance(1.0 / self.max_evaluations as f64);
        }
        if self.monitor.cancelled() {
            self.cancelled.store(true, Ordering::Relaxed);
        }
        Ok(record)
    }

    fn judge(&self, design: &Pattern, response: Response) -> Candidate {
        Candidate::new(self.target, self.constraints, *design, response)
    }
}

/// All evaluated designs, in an order that does not depend on timing.
#[derive(Debug, Default)]
pub(crate) struct Archive {
    records: Vec<Record>,
    index: BTreeMap<Key, usize>,
}

impl Archive {
    pub(crate) fn records(&self) -> &[Record] {
        &self.records
    }

    /// Designs with a response, in order.
    pub(crate) fn candidates(&self) -> impl Iterator<Item = &Candidate> {
        self.records.iter().filter_map(Record::candidate)
    }

    /// Designs with a response that respect the constraints, in order.
    pub(crate) fn feasible(&self) -> impl Iterator<Item = &Candidate> {
        self.candidates().filter(|candidate| candidate.violations.is_empty())
    }

    /// The best design; the earliest of equals.
    pub(crate) fn best(&self) -> Option<&Candidate> {
        self.candidates().fold(None, |best: Option<&Candidate>, candidate| match best {
            Some(best) if !candidate.is_better_than(best) => Some(best),
            _ => Some(candidate),
        })
    }

    /// Takes over what one descent found, but for the designs that are known already.
    pub(crate) fn absorb(&mut self, records: Vec<Record>) {
        for record in records {
            if let Entry::Vacant(entry) = self.index.entry(key(record.design())) {
                entry.insert(self.records.len());
                self.records.push(record);
            }
        }
    }

    /// Whether `design` has been evaluated.
    pub(crate) fn knows(&self, design: &Pattern) -> bool {
        self.index.contains_key(&key(design))
    }

    fn find(&self, design: &Key) -> Option<&Record> {
        self.index.get(design).map(|&position| &self.records[position])
    }
}

/// What one descent adds to a archive that stays as it is meanwhile. Its budget counts every design
/// that the archive lacks, whether or not another descent computes it too, so that the outcome does
/// not depend on who came first.
pub(crate) struct LocalArchive<'a> {
    evaluator: &'a Evaluator<'a>,
    archive: &'a Archive,
    own: Archive,
    budget: usize,
    pub(crate) interruption: Option<Interruption>,
}

impl<'a> LocalArchive<'a> {
    /// A local archive for at most `budget` new evaluations.
    pub(crate) fn new(evaluator: &'a Evaluator<'a>, archive: &'a Archive, budget: usize) -> Self {
        Self { evaluator, archive, own: Archive::default(), budget, interruption: None }
    }

    /// The record of `design`, evaluated only where neither the archive nor this local archive has it.
    /// `None` once interrupted.
    pub(crate) fn look(&mut self, design: &Pattern) -> Option<&Record> {
        let key = key(design);
        if let Some(known) = self.archive.find(&key) {
            return Some(known);
        }
        if self.own.find(&key).is_none() {
            if self.interruption.is_some() {
                return None;
            }
            if self.own.records.len() >= self.budget {
                self.interruption = Some(Interruption::Budget);
                return None;
            }
            match self.evaluator.evaluate(design) {
                Ok(record) => self.own.absorb(vec![record]),
                Err(interruption) => {
                    self.interruption = Some(interruption);
                    return None;
                }
            }
        }
        self.own.find(&key)
    }

    pub(crate) const fn target(&self) -> &'a Target {
        self.evaluator.target
    }

    pub(crate) const fn constraints(&self) -> &'a Constraints {
        self.evaluator.constraints
    }

    /// New records and what interrupted them.
    pub(crate) fn close(self) -> (Vec<Record>, Option<Interruption>) {
        (self.own.records, self.interruption)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Quantity, TargetPoint};
    use slipgrid_monitor::Unwatched;
    use slipgrid_pattern::Planform;
    use std::sync::atomic::AtomicUsize;

    fn design(width_um: f64) -> Pattern {
        Pattern::new(Planform::Groove, width_um * 1e-6, 300e-6, 10e-6).unwrap()
    }

    #[test]
    fn a_design_is_evaluated_once_and_within_the_budget() {
        let calls = AtomicUsize::new(0);
        let model = |design: &Pattern| {
            calls.fetch_add(1, Ordering::Relaxed);
            Ok(Response { value: vec![design.section_density()], limited: Vec::new() })
        };
        let point = TargetPoint { pressure_pa: 1e6, value: 0.3 };
        let target = Target::new(Quantity::Ratio, vec![point], 0.01).unwrap();
        let constraints = Constraints::default();
        let evaluator = Evaluator::new(&model, &target, &constraints, 10, &Unwatched);
        let mut archive = Archive::default();
        archive.absorb(vec![evaluator.evaluate(&design(100.0)).unwrap()]);
        let mut local = LocalArchive::new(&evaluator, &archive, 2);
        for width_um in [100.0, 110.0, 110.0, 120.0, 100.0] {
            assert!(local.look(&design(width_um)).is_some());
        }
        assert!(local.look(&design(130.0)).is_none());
        assert!(local.look(&design(120.0)).is_some(), "what is known costs nothing");
        let (records, interruption) = local.close();
        assert_eq!((records.len(), interruption), (2, Some(Interruption::Budget)));
        assert_eq!(calls.load(Ordering::Relaxed), 3);
    }
}
