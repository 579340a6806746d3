//! Files of a ledger.

use super::TrialsReport;
use crate::friction_sheet::{self, FrictionSheet};
use crate::{Outputs, ReportError, html, linked_data};

impl TrialsReport {
    /// Makes the files of the ledger, with the `sheet` of its measurements.
    ///
    /// # Errors
    /// [`ReportError`] if the picture cannot be drawn or the record has no JSON form.
    pub fn files(&self, sheet: &FrictionSheet) -> Result<Outputs, ReportError> {
        let mut outputs = Outputs::default();
        outputs.add("trials.csv", self.csv());
        if !self.trials.is_empty() {
            outputs.add("trials.svg", self.picture()?);
        }
        outputs.add_record(self)?;
        outputs.add(friction_sheet::FILE, sheet.markdown());
        outputs.add(linked_data::FILE, linked_data::of_trials(self, &outputs)?);
        let page = html::trials(self, sheet, &outputs);
        outputs.add("report.html", page);
        Ok(outputs)
    }
}
