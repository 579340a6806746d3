//! Pages of results: report.html beside the files it shows.

use serde::Serialize;
use serde_json::Value;

use crate::CliError;
use crate::output::Outputs;
use crate::report::html;

/// Name of the page.
const PAGE: &str = "report.html";

/// Adds the page of a design; all pictures stand in `outputs` already.
///
/// # Errors
/// [`CliError::Other`] if the report has no JSON form.
pub fn design(report: &impl Serialize, outputs: &mut Outputs) -> Result<(), CliError> {
    let page = html::design(&value(report)?, outputs);
    outputs.add(PAGE, page);
    Ok(())
}

/// Adds the page of a validation; all pictures stand in `outputs` already.
///
/// # Errors
/// As [`design`].
pub fn validation(report: &impl Serialize, outputs: &mut Outputs) -> Result<(), CliError> {
    let page = html::validation(&value(report)?, outputs);
    outputs.add(PAGE, page);
    Ok(())
}

fn value(report: &impl Serialize) -> Result<Value, CliError> {
    serde_json::to_value(report).map_err(|error| CliError::Other(format!("the result has no JSON form: {error}")))
}
