//! Trials of a calibration: `[[trial]]` and `[trial_prior]`.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use slipgrid_infer::calibrate::{CutSample, CutSpecimen, TrialsTask};
use slipgrid_infer::discrepancy::{Conditions, Discrepancy, DiscrepancyError, Hyperparameters};
use slipgrid_model::pattern::Pattern;

use super::calibration::read_fitting_pattern;
use super::calibration_file::FaceFile;
use super::material::existing;
use super::measured::{self, Placed, Remarks, Specimens};
use super::measurements;
use super::pattern::PatternFile;
use super::relief::read_relief;
use super::stated_specimen::{StatedSpecimen, area_m2};
use super::trace_table::{TraceConditionFile, TraceReader};
use super::traces::{ConditionTraces, OfTrial};
use super::unusual;
use super::values::Number;
use crate::formats::dimension_error;
use crate::formats::{Diagnostic, Document, Spanned};
use slipgrid_base::key_error::KeyError;
use slipgrid_base::units::RELATIVE_STD;

/// `[[trial]]`: a sample that was cut; pending until it has measurements or traces.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrialFile {
    /// Name of the sample.
    pub(crate) name: Spanned<String>,
    /// Date of cutting, in any form.
    #[serde(default)]
    date: String,
    /// Free notes.
    #[serde(default)]
    notes: String,
    /// Pattern of the sample, with measured dimensions.
    pattern: Spanned<PatternFile>,
    /// CSV table of measured friction, with the columns of the table of flat samples.
    pub(crate) measurements: Option<Spanned<String>>,
    /// Raw exports of a tribometer in place of the table, one table per condition; `[traces]` has the reading options.
    pub(crate) traces: Option<Spanned<Vec<TraceConditionFile>>>,
    /// Altitude map of the sample as cut, with its cavities: the slope of the land over that of the flat sample
    /// corrects the modelled ratio. Needs `map` in `[surface]`, and is read with the options of `[surface]` except
    /// `crop`.
    map: Option<Spanned<String>>,
    /// Face of this sample, to which `force_n` of its table refers; the calibration's specimen when absent.
    specimen: Option<Spanned<FaceFile>>,
    /// Standard error of the measured mean width, at most a third of the width; may stand in `[trial.pattern]` instead;
    /// 0 when absent.
    width_std_um: Option<Number>,
    /// Standard error of the measured mean spacing, at most a third of the spacing; may stand in `[trial.pattern]`
    /// instead; 0 when absent.
    spacing_std_um: Option<Number>,
    /// Standard error of the measured mean depth, at most a third of the depth; may stand in `[trial.pattern]` instead;
    /// 0 when absent.
    depth_std_um: Option<Number>,
    /// Standard deviation of ln(ratio) between samples of this texture, kept as given; without the key, that of
    /// `[trial_prior]`, which trials update.
    sample_std: Option<Number>,
    /// Name of the disc of which the sample is a sector. Trials on one disc share the random deviation of this disc.
    disc: Option<Spanned<String>>,
}

/// Flat samples of a calibration, with which the trials are compared.
pub(crate) struct FlatSamples<'a> {
    /// Specimen of the flat samples, as stated in the calibration.
    pub(crate) stated: StatedSpecimen,
    /// Specimen properties by which measurements are checked.
    pub(crate) specimens: &'a Specimens,
    /// Measurements on the flat samples.
    pub(crate) measured: &'a [Placed],
    /// Number of specimens that a force in a table presses at once.
    pub(crate) samples: u32,
    /// Whether a map of a flat sample is named.
    pub(crate) has_map: bool,
}

/// Reads the `trials` of a calibration with these `flat` samples, and the `prior` of the discrepancy. The sample
/// `first`, from the patterned measurements of the calibration, becomes the first trial. `reader` reads the traces,
/// which are returned as well. Remarks are appended to `remarks`.
///
/// # Errors
/// [`Diagnostic`] for any refused input.
pub(crate) fn read_trials(
    document: &Document,
    trials: &[Spanned<TrialFile>],
    prior: Option<&Spanned<Hyperparameters>>,
    flat: &FlatSamples<'_>,
    first: Option<CutSample>,
    reader: &mut TraceReader<'_>,
    remarks: &mut Remarks,
) -> Result<(TrialsTask, Vec<ConditionTraces>), Diagnostic> {
    let FlatSamples { stated, specimens, measured: flat, samples: pressed, has_map: has_flat_map } = *flat;
    let mut read = Vec::new();
    let mut samples: Vec<CutSample> = first.into_iter().collect();
    let mut before = flat.to_vec();
    for (table, number) in trials.iter().zip(1..) {
        let file = table.get_ref();
        if samples.iter().any(|other| other.name == *file.name.get_ref()) {
            return Err(document
                .refuse(file.name.span(), "names two trials")
                .expected("a name of its own for every [[trial]]"));
        }
        let own =
            file.specimen.as_ref().map(|table| StatedSpecimen::read(document, table, Some(stated))).transpose()?;
        let own = own.unwrap_or(stated);
        let own_specimens = Specimens { area_m2: area_m2(&own.specimen.outline), ..*specimens };
        // A sector bears force on its own face, and the surrounding specimen continues around it.
        let is_laid = file.disc.is_none();
        let pattern = read_fitting_pattern(document, &file.pattern, &own.specimen, is_laid)?;
        remarks.told.extend(unusual::of_cavity(document, &file.pattern));
        let rows = match (&file.measurements, &file.traces) {
            (Some(_), Some(traces)) => {
                return Err(document
                    .refuse(traces.span(), "stands beside measurements")
                    .expected("either measurements or [[trial.traces]]"));
            }
            (Some(name), None) => measurements::read(document, name, pressed)?,
            (None, Some(list)) => {
                let conditions =
                    reader.conditions(list, Some(&OfTrial { number, name: file.name.get_ref().clone() }))?;
                let found = reader.analyse(&conditions)?;
                let rows = found.iter().zip(&conditions).map(|(traces, (span, _))| traces.placed(document, span));
                let rows = rows.collect();
                read.extend(found);
                rows
            }
            (None, None) => Vec::new(),
        };
        measured::refuse_repeated(&rows)?;
        remarks.repeated.extend(measured::identical(&before, &rows));
        before.extend(rows.iter().cloned());
        remarks.told.extend(measured::check(&rows, &own_specimens)?);
        let written = rows;
        let rows: Vec<Placed> = written.iter().map(|row| row.on(&own_specimens, specimens, flat)).collect();
        remarks.told.extend(measured::check_partners(&rows, &written, flat)?);
        remarks.doubts.extend(measured::doubtful_ratios(&rows, flat));
        let own_std = [&file.width_std_um, &file.spacing_std_um, &file.depth_std_um];
        let stds = [own_std, file.pattern.get_ref().dimensions_std()];
        samples.push(CutSample {
            name: file.name.get_ref().clone(),
            date: file.date.clone(),
            notes: file.notes.clone(),
            relief: read_relief(document, &file.pattern, &pattern)?,
            map: file.map.as_ref().map(|map| read_map(document, map, has_flat_map)).transpose()?,
            land: None,
            dimensions_std_m: dimension_error::read(document, &stds, &pattern)?,
            pattern,
            sample_std: document.optional(file.sample_std.as_ref(), RELATIVE_STD)?,
            specimen: if is_laid { own.cut() } else { CutSpecimen { face: None, ..own.cut() } },
            disc: read_disc(document, file.disc.as_ref())?,
            measured: rows.iter().map(|row| row.measurement).collect(),
        });
    }
    let hyper = prior.map_or_else(Hyperparameters::default, |table| table.get_ref().clone());
    Discrepancy::new(hyper.clone(), Conditions::default(), 0.0, Vec::new()).map_err(|error| {
        let span = prior.map_or(0..0, Spanned::span);
        match error {
            DiscrepancyError::Hyperparameter { name, expected, .. } => {
                document.refuse_key(&span, &KeyError::rule(name, "is out of range", expected))
            }
            other => document.refuse(span, other.to_string()),
        }
    })?;
    Ok((TrialsTask { samples, prior: hyper }, read))
}

/// A `[[trial]]` table with the designed pattern, to be completed by the user.
#[derive(Serialize)]
struct TemplateTrial<'a> {
    name: String,
    disc: &'a str,
    notes: String,
    pattern: PatternFile,
}

/// Template of `[[trial]]` tables for `patterns` on one `disc`, in the order of the sectors, to be added to a
/// calibration and filled in. A trial is pending until it names its measurements. `densities` are the areal densities
/// of the sectors as cut.
pub fn sector_trials(disc: &str, patterns: &[Pattern], densities: &[f64]) -> String {
    let mut text = "# Trials of one disc, by slipgrid: add these to the calibration once it is cut. They are pending until each names its measurements.\n\
                    # Measure each sector alone: what presses the whole disc measures a mean of all sectors, which is a trial of none.\n\
                    # Write measured dimensions in place of the designed ones. force_n in a table counts on the calibration's specimen,\n\
                    # or on the face that [trial.specimen] gives, as that of a pin on a sector: radius_mm = 1.5.\n"
        .to_owned();
    for (place, (pattern, density)) in patterns.iter().zip(densities).enumerate() {
        let number = place + 1;
        let trial = TemplateTrial {
            name: format!("{disc}, sector {number}"),
            disc,
            notes: format!("sector {number}, areal density as cut {:.2} %", 100.0 * density),
            pattern: PatternFile::from(pattern),
        };
        // Numbers and texts always have a TOML form.
        let body = toml::to_string(&trial).unwrap_or_default();
        let measurements = format!("# measurements = \"sector-{number}.csv\"\n\n[trial.pattern]");
        text += &format!("\n[[trial]]\n{}", body.replacen("\n[pattern]", &measurements, 1));
    }
    text
}

/// Path of the map of a cut sample; refused without a map of a flat sample.
fn read_map(document: &Document, map: &Spanned<String>, has_flat_map: bool) -> Result<PathBuf, Diagnostic> {
    if !has_flat_map {
        return Err(document
            .refuse(map.span(), "has no map of a flat sample to compare its land with")
            .expected("`map` in [surface], or no map of the trial"));
    }
    existing(document, map, map.get_ref())
}

/// Reads the name of the disc that a sample shares with other samples; `None` if not given.
fn read_disc(document: &Document, disc: Option<&Spanned<String>>) -> Result<Option<String>, Diagnostic> {
    match disc {
        Some(name) if name.get_ref().trim().is_empty() => Err(document
            .refuse(name.span(), "names no disc")
            .expected("a name that all [[trial]] on one disc have, or no key where a sample is alone on its disc")),
        disc => Ok(disc.map(|name| name.get_ref().clone())),
    }
}

/// First trial: the sample that a calibration describes by the pattern in `table` and by the measurements `measured` on
/// patterned samples.
///
/// # Errors
/// [`Diagnostic`] for any refused input.
pub(crate) fn of_tables(
    document: &Document,
    table: &Spanned<PatternFile>,
    stated: StatedSpecimen,
    measured: &[Placed],
) -> Result<CutSample, Diagnostic> {
    let pattern = read_fitting_pattern(document, table, &stated.specimen, true)?;
    Ok(CutSample {
        name: "patterned samples".to_owned(),
        date: String::new(),
        notes: "read from [pattern] and the patterned measurements".to_owned(),
        relief: read_relief(document, table, &pattern)?,
        map: None,
        land: None,
        dimensions_std_m: dimension_error::read(document, &[table.get_ref().dimensions_std()], &pattern)?,
        pattern,
        sample_std: None,
        disc: None,
        specimen: stated.cut(),
        measured: measured.iter().map(|row| row.measurement).collect(),
    })
}
