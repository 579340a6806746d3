//! Why a design job ended without a design.

use slipgrid_material::MaterialError;
use slipgrid_monitor::Cancelled;

use crate::SpecimenError;

/// Why a design job ended without a design.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DesignError {
    /// A part of the task means nothing together with the rest.
    #[error(transparent)]
    Refused(#[from] Refusal),
    /// The numbers of a material lead to one without meaning.
    #[error(transparent)]
    Material(#[from] MaterialError),
    /// The answers kept beyond one run are not those of this task, or cannot be read.
    #[error("{0}")]
    Cache(String),
    /// The monitor cancelled the job.
    #[error("cancelled")]
    Cancelled,
    /// The time allowed was spent before there was anything to report.
    #[error("{0}")]
    OutOfTime(String),
    /// Anything else.
    #[error("{0}")]
    Failed(String),
}

/// A part of a task that was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{reason}")]
pub struct Refusal {
    /// Which.
    pub part: TaskPart,
    /// Why, in words that follow the part's value.
    pub reason: String,
    /// What would be accepted.
    pub expected: Option<String>,
}

/// The parts of a task that can be refused only when the whole of it is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TaskPart {
    /// No part alone.
    Whole,
    /// Number `.0` of the ranges of conditions.
    ConditionRange(usize),
    /// The condition designed for.
    Condition,
    /// The further conditions.
    FurtherConditions,
    /// Number `.0` of the target's pressures.
    Pressure(usize),
    /// The size of blocks.
    BlockSize,
}

impl Refusal {
    /// The refusal of `part`.
    #[must_use]
    pub fn new(part: TaskPart, reason: impl Into<String>) -> Self {
        Self { part, reason: reason.into(), expected: None }
    }

    /// The same, with what would be accepted.
    #[must_use]
    pub fn expected(mut self, expected: impl Into<String>) -> Self {
        self.expected = Some(expected.into());
        self
    }
}

impl DesignError {
    /// The model has no answer for any design within the bounds.
    #[must_use]
    pub fn nothing_computed() -> Self {
        Self::Failed("no design within the bounds can be computed".to_owned())
    }

    /// The task as a whole is refused, for a reason that only a solver or the search finds.
    #[must_use]
    pub fn refused(reason: impl Into<String>) -> Self {
        Refusal::new(TaskPart::Whole, reason).into()
    }
}

impl From<Cancelled> for DesignError {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

impl From<SpecimenError> for DesignError {
    fn from(error: SpecimenError) -> Self {
        Self::refused(error.to_string())
    }
}
