//! What the search asks of a model.

use slipgrid_pattern::Pattern;

/// What one design does.
#[derive(Clone, Debug, PartialEq)]
pub struct Response {
    /// The target's quantity at the target's pressures, in the target's order, at each of its conditions in turn.
    pub value: Vec<f64>,
    /// What the constraints limit: one for each of [`Constraints::quantities`](crate::Constraints::quantities), in
    /// their order, SI units.
    pub limited: Vec<f64>,
}

/// Why a design has no response.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ModelFailure {
    /// This design cannot be computed; the next one may. The search counts it and goes on.
    #[error("{reason}")]
    Trial {
        /// What went wrong.
        reason: String,
    },
    /// No design can be computed: the search ends with an error.
    #[error("{reason}")]
    Broken {
        /// What went wrong.
        reason: String,
    },
    /// The model was asked to stop: the search ends with its best design so far.
    #[error("cancelled")]
    Cancelled,
}

impl ModelFailure {
    /// The failure of a model that gives `got` values of one design where it gave `expected` of another.
    pub(crate) fn of_another_length(expected: usize, got: usize) -> Self {
        Self::Broken { reason: format!("it gave {expected} values of one design and {got} of another") }
    }
}

/// `values` if there are `expected` of them.
///
/// # Errors
/// [`ModelFailure::Broken`] if there are more or fewer.
pub(crate) fn as_many(values: Vec<f64>, expected: usize) -> Result<Vec<f64>, ModelFailure> {
    if values.len() == expected { Ok(values) } else { Err(ModelFailure::of_another_length(expected, values.len())) }
}

/// The model that predicts a design's friction. Designs are evaluated from several threads at once;
/// the same design must give the same response, bit by bit.
pub trait ForwardModel: Sync {
    /// The response of `design`.
    ///
    /// # Errors
    /// [`ModelFailure`] says whether the design, the model or the user is the reason.
    fn respond(&self, design: &Pattern) -> Result<Response, ModelFailure>;
}

impl<F> ForwardModel for F
where
    F: Fn(&Pattern) -> Result<Response, ModelFailure> + Sync,
{
    fn respond(&self, design: &Pattern) -> Result<Response, ModelFailure> {
        self(design)
    }
}
