//! Errors of design jobs.

use slipgrid_base::monitor::Cancelled;
use slipgrid_model::springblock::SceneError;

use crate::SpecimenError;

/// Reason why a design job ended without a design.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DesignError {
    /// Part of the task that is invalid in combination with the rest.
    #[error(transparent)]
    Refused(#[from] Refusal),
    /// Stored results of the model that belong to another task or cannot be read.
    #[error("{0}")]
    Cache(String),
    /// The monitor cancelled the job.
    #[error("cancelled")]
    Cancelled,
    /// The time limit ended before there was a result.
    #[error("{0}")]
    OutOfTime(String),
    /// No set of textures that one specimen takes is worth cutting.
    #[error("{0}")]
    NothingToCut(String),
    /// Any other failure.
    #[error("{0}")]
    Failed(String),
}

/// Refused part of a task.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{reason}")]
pub struct Refusal {
    /// Part that is refused.
    pub part: TaskPart,
    /// Reason, in words that follow the value of the part.
    pub reason: String,
    /// Accepted values; `None` if not stated.
    pub expected: Option<String>,
}

/// Parts of a task that can be refused only when the whole task is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TaskPart {
    /// The task as a whole.
    Whole,
    /// Range of conditions with index `.0`.
    ConditionRange(usize),
    /// Condition of the design.
    Condition,
    /// Further conditions.
    FurtherConditions,
    /// Target pressure with index `.0`.
    Pressure(usize),
    /// Block size.
    BlockSize,
}

impl Refusal {
    /// Creates a refusal of `part`.
    pub fn new(part: TaskPart, reason: impl Into<String>) -> Self {
        Self { part, reason: reason.into(), expected: None }
    }

    /// Creates the refusal of a block size with which `what` takes too much memory or time, as `error` states.
    pub fn of_cost(what: &str, error: &SceneError) -> Self {
        let gib = |bytes: f64| bytes / (1_u64 << 30) as f64;
        let days = |seconds: f64| seconds / 86_400.0;
        let (takes, most) = match error {
            SceneError::TooLarge { bytes, most_bytes } => {
                (format!("{:.0} GiB of memory", gib(*bytes)), format!("{:.0} GiB", gib(*most_bytes)))
            }
            SceneError::TooLong { core_s, most_s } => {
                (format!("{:.0} days of one core", days(*core_s)), format!("{:.0} days", days(*most_s)))
            }
            other => return Self::new(TaskPart::Whole, other.to_string()),
        };
        Self::new(TaskPart::BlockSize, format!("um makes {what} that take about {takes}"))
            .expected(format!("larger blocks, a smaller layer or specimen, or a higher speed, for at most {most}"))
    }

    /// Adds the accepted values.
    #[must_use]
    pub fn expected(mut self, expected: impl Into<String>) -> Self {
        self.expected = Some(expected.into());
        self
    }
}

impl DesignError {
    /// Creates a refusal of the whole task, for a reason that only a solver or the search finds.
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
