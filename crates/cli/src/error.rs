use slipgrid_base::monitor::Cancelled;
use slipgrid_model::material::MaterialError;

use slipgrid_io::Failure;
use slipgrid_io::disk::WriteError;
use slipgrid_io::formats::Diagnostic;

/// Error that ends a command without a result.
#[derive(Debug, thiserror::Error)]
pub enum CliError {
    /// Input was refused; nothing was written.
    #[error(transparent)]
    Input(#[from] Diagnostic),
    /// Several files were refused; nothing was written.
    #[error("{0}")]
    Inputs(String),
    /// Stdout could not be written.
    #[error("standard output: {0}")]
    Stdout(#[from] std::io::Error),
    /// Ctrl-C was pressed.
    #[error("{}", crate::interruption::message())]
    Interrupted,
    /// The time limit passed before any result was available.
    #[error("{0}")]
    OutOfTime(String),
    /// No texture is worth cutting.
    #[error("{0}")]
    NothingToCut(String),
    /// Anything else.
    #[error("{0}")]
    Other(String),
}

/// Converts errors of the listed types to [`CliError::Other`] with their message.
macro_rules! told {
    ($($error:ty),+ $(,)?) => {$(
        impl From<$error> for CliError {
            fn from(error: $error) -> Self {
                Self::Other(error.to_string())
            }
        }
    )+};
}

told!(MaterialError, WriteError, slipgrid_design::results::NoJsonForm, slipgrid_report::ChartError);

impl From<slipgrid_studio::StudioError> for CliError {
    fn from(error: slipgrid_studio::StudioError) -> Self {
        match error {
            slipgrid_studio::StudioError::Folder(error) => error.into(),
            other => Self::Other(other.to_string()),
        }
    }
}

impl From<Cancelled> for CliError {
    fn from(_: Cancelled) -> Self {
        Self::Interrupted
    }
}

impl From<Failure> for CliError {
    fn from(error: Failure) -> Self {
        match error {
            Failure::Refused(refused) => Self::Input(refused),
            Failure::SeveralRefused(reason) => Self::Inputs(reason),
            Failure::Cancelled => Self::Interrupted,
            other => Self::Other(other.to_string()),
        }
    }
}

impl CliError {
    /// Exit code of the error.
    pub const fn exit_code(&self) -> u8 {
        match self {
            Self::Input(_) | Self::Inputs(_) => crate::exit_code::BAD_INPUT,
            Self::Interrupted => crate::exit_code::INTERRUPTED,
            Self::OutOfTime(_) => crate::exit_code::BUDGET,
            Self::NothingToCut(_) => crate::exit_code::UNREACHABLE,
            Self::Stdout(_) | Self::Other(_) => crate::exit_code::FAILURE,
        }
    }
}
