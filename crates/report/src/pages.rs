//! Pages of results: report.html beside the files it shows.

use serde::Serialize;
use serde_json::Value;

use crate::Outputs;
use crate::html;

/// Name of the page.
const PAGE: &str = "report.html";

/// Adds the page of a design; all pictures stand in `outputs` already.
///
/// # Errors
/// [`ReportError`] if the report has no JSON form.
pub fn design(report: &impl Serialize, outputs: &mut Outputs) -> Result<(), serde_json::Error> {
    let page = html::design(&value(report)?, outputs);
    outputs.add(PAGE, page);
    Ok(())
}

fn value(report: &impl Serialize) -> Result<Value, serde_json::Error> {
    serde_json::to_value(report)
}
