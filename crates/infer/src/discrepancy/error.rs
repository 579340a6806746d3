//! Errors of trials and hyperparameters.

/// Reason why trials were refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DiscrepancyError {
    /// Invalid number of a trial.
    #[error("{quantity} of trial {trial} at its row {row} is {value}, and must be {expected}")]
    Measured {
        /// Name of the trial.
        trial: String,
        /// Index of the measurement in the trial, from 1.
        row: usize,
        /// Name of the number.
        quantity: &'static str,
        /// Value of the number.
        value: f64,
        /// Accepted values.
        expected: &'static str,
    },
    /// Invalid hyperparameter.
    #[error("{name} is {value}, and must be {expected}")]
    Hyperparameter {
        /// Name of the hyperparameter.
        name: &'static str,
        /// Value of the hyperparameter.
        value: f64,
        /// Accepted values.
        expected: &'static str,
    },
    /// Covariance of the measurements without an inverse.
    #[error("two measurements are the same without any error: their covariance has no inverse")]
    Singular,
}
