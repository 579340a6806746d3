//! Why trials were refused.

/// Why trials were refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DiscrepancyError {
    /// A number of a trial means nothing.
    #[error("{quantity} of trial {trial} at its row {row} is {value}, and must be {expected}")]
    Measured {
        /// Name of the trial.
        trial: String,
        /// Number of the row, from 1.
        row: usize,
        /// Which number.
        quantity: &'static str,
        /// What it is.
        value: f64,
        /// What would be accepted.
        expected: &'static str,
    },
    /// A hyperparameter means nothing.
    #[error("{name} is {value}, and must be {expected}")]
    Hyperparameter {
        /// Its name.
        name: &'static str,
        /// What it is.
        value: f64,
        /// What would be accepted.
        expected: &'static str,
    },
    /// The covariance of the measurements has no inverse.
    #[error("two measurements are the same without any error: their covariance has no inverse")]
    Singular,
}
