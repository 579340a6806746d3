use slipgrid_material::MaterialError;

use crate::output::WriteError;
use slipgrid_formats::Diagnostic;

/// Why a command ended without a result.
#[derive(Debug, thiserror::Error)]
pub enum CliError {
    /// Input was refused; nothing was written.
    #[error(transparent)]
    Input(#[from] Diagnostic),
    /// A result could not be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// Stdout could not be written.
    #[error("standard output: {0}")]
    Stdout(#[from] std::io::Error),
    /// The numbers of a material lead to one without meaning.
    #[error(transparent)]
    Material(#[from] MaterialError),
    /// Ctrl-C was pressed.
    #[error("{}", crate::interruption::message())]
    Interrupted,
    /// The time allowed was spent before there was anything to report.
    #[error("{0}")]
    OutOfTime(String),
    /// Anything else.
    #[error("{0}")]
    Other(String),
}

impl From<slipgrid_results::NoJsonForm> for CliError {
    fn from(error: slipgrid_results::NoJsonForm) -> Self {
        Self::Other(error.to_string())
    }
}

impl From<slipgrid_report::ChartError> for CliError {
    fn from(error: slipgrid_report::ChartError) -> Self {
        Self::Other(error.to_string())
    }
}

impl From<slipgrid_report::ReportError> for CliError {
    fn from(error: slipgrid_report::ReportError) -> Self {
        Self::Other(error.to_string())
    }
}

impl From<slipgrid_formats::written_material::UnwritableMaterial> for CliError {
    fn from(error: slipgrid_formats::written_material::UnwritableMaterial) -> Self {
        Self::Other(error.to_string())
    }
}

impl From<slipgrid_formats::confirmed_scene::UnwritableScene> for CliError {
    fn from(error: slipgrid_formats::confirmed_scene::UnwritableScene) -> Self {
        Self::Other(error.to_string())
    }
}

impl From<slipgrid_studies::StudyError> for CliError {
    fn from(error: slipgrid_studies::StudyError) -> Self {
        match error {
            slipgrid_studies::StudyError::Input(refused) => Self::Input(refused),
            slipgrid_studies::StudyError::Cancelled => Self::Interrupted,
            other => Self::Other(other.to_string()),
        }
    }
}

impl CliError {
    /// The exit code.
    #[must_use]
    pub const fn exit_code(&self) -> u8 {
        match self {
            Self::Input(_) => crate::exit_code::BAD_INPUT,
            Self::Interrupted => crate::exit_code::INTERRUPTED,
            Self::OutOfTime(_) => crate::exit_code::BUDGET,
            Self::Write(_) | Self::Stdout(_) | Self::Material(_) | Self::Other(_) => crate::exit_code::FAILURE,
        }
    }
}
