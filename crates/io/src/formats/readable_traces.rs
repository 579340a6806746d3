//! Traces of a calibration that is not complete yet.

use crate::formats::spanned::Spanned;

use super::calibration_file::CalibrationFile;
use super::document::Document;
use super::trace_table::TraceReader;
use super::traces::{ConditionTraces, OfTrial};
use crate::formats::diagnostic::Diagnostic;

/// Traces of a calibration as far as they can be read.
#[derive(Debug, Default)]
pub struct ReadableTraces {
    /// Conditions whose traces could be averaged.
    pub found: Vec<ConditionTraces>,
    /// Reasons for the others.
    pub refused: Vec<Diagnostic>,
}

impl ReadableTraces {
    /// Reads the traces of the calibration in `document`, whatever else it lacks.
    ///
    /// # Errors
    /// [`Diagnostic`] if its tables of traces cannot be read.
    pub fn read(document: &Document) -> Result<Self, Diagnostic> {
        let file: CalibrationFile = document.parse()?;
        let of_trials = file.trial.iter().filter_map(|trial| trial.get_ref().traces()).flatten();
        let table = file.traces.as_ref();
        let mut reader = TraceReader::new(document, table.map(Spanned::get_ref), of_trials)?;
        let mut lists = vec![table.map_or(Ok(Vec::new()), |table| reader.table(table, false))?];
        for (number, trial) in (1..).zip(&file.trial) {
            if let Some((name, list)) = trial.get_ref().named_traces() {
                lists.push(reader.conditions(list, Some(&OfTrial { number, name: name.to_owned() }))?);
            }
        }
        let mut all = Self::default();
        for conditions in lists {
            let (found, refused) = reader.analyse_readable(&conditions);
            all.found.extend(found);
            all.refused.extend(refused);
        }
        Ok(all)
    }
}
