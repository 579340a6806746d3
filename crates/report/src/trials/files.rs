//! Files of a ledger.

use super::TrialsReport;
use crate::{Outputs, ReportError, html};

impl TrialsReport {
    /// Makes the files of the ledger.
    ///
    /// # Errors
    /// [`ReportError`] if the picture cannot be drawn or the record has no JSON form.
    pub fn files(&self) -> Result<Outputs, ReportError> {
        let mut outputs = Outputs::default();
        outputs.add("trials.csv", self.csv());
        if !self.trials.is_empty() {
            outputs.add("trials.svg", self.picture()?);
        }
        outputs.add_record(self)?;
        let page = html::trials(self, &outputs);
        outputs.add("report.html", page);
        Ok(outputs)
    }
}
