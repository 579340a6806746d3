//! Traces of a calibration that is not complete yet.

use super::calibration_file::CalibrationFile;
use super::trace_table::TraceReader;
use super::traces::{ConditionTraces, OfTrial, TraceSetup};
use crate::formats::{Diagnostic, Document, Spanned};

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
        let mut reader = reader(document, &file)?;
        let mut lists = vec![file.traces.as_ref().map_or(Ok(Vec::new()), |table| reader.table(table, false))?];
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

/// Reads how the exports of the calibration in `document` are to be read, whatever else it lacks.
///
/// # Errors
/// [`Diagnostic`] if its table of traces cannot be read.
pub fn read_setup(document: &Document) -> Result<TraceSetup, Diagnostic> {
    Ok(reader(document, &document.parse()?)?.into_setup())
}

fn reader<'d>(document: &'d Document, file: &CalibrationFile) -> Result<TraceReader<'d>, Diagnostic> {
    let of_trials = file.trial.iter().filter_map(|trial| trial.get_ref().traces()).flatten();
    TraceReader::new(document, file.traces.as_ref().map(Spanned::get_ref), of_trials)
}
