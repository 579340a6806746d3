//! Traces of a calibration that is not complete yet.

use super::calibration_file::CalibrationFile;
use super::trace_table::TraceReader;
use super::traces::{ConditionTraces, OfTrial, TraceSetup};
use crate::formats::{Diagnostic, Document};

/// Traces of a calibration, as far as they can be read and analysed.
#[derive(Debug, Default)]
pub struct ReadableTraces {
    /// Conditions whose traces could be averaged.
    pub found: Vec<ConditionTraces>,
    /// Reasons why the traces of the other conditions could not be averaged.
    pub refused: Vec<Diagnostic>,
}

impl ReadableTraces {
    /// Reads the traces of the calibration in `document`, even if other values or files of the calibration would be
    /// refused.
    ///
    /// # Errors
    /// [`Diagnostic`] if the document cannot be parsed, or its tables of traces are refused.
    pub fn read(document: &Document) -> Result<Self, Diagnostic> {
        let file: CalibrationFile = document.parse()?;
        let mut reader = TraceReader::new(document, &file)?;
        let mut lists = vec![file.traces.as_ref().map_or(Ok(Vec::new()), |table| reader.table(table, false))?];
        for (number, trial) in (1..).zip(&file.trial) {
            let trial = trial.get_ref();
            if let Some(list) = &trial.traces {
                let of = OfTrial { number, name: trial.name.get_ref().clone() };
                lists.push(reader.conditions(list, Some(&of))?);
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

/// Reads the options for reading the exports of the calibration in `document`, even if other values of the calibration
/// would be refused.
///
/// # Errors
/// [`Diagnostic`] if the document cannot be parsed, or its table of traces is refused.
pub fn read_setup(document: &Document) -> Result<TraceSetup, Diagnostic> {
    Ok(TraceReader::new(document, &document.parse()?)?.setup)
}
