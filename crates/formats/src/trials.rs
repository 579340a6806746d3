//! Trials in files: `[[trial]]` and `[trial_prior]` of a calibration, and what a material file keeps of them.

use serde::{Deserialize, Serialize};
use slipgrid_calibrate::{CutSample, CutSpecimen, TrialsTask};
use slipgrid_discrepancy::{
    Conditions, DimensionShift, Discrepancy, Features, Hyperparameters, Load, Measured, Sensitivity, Trial,
};
use slipgrid_pattern::Pattern;
use slipgrid_results::PatternReport;
use toml::Spanned;

use super::calibration::read_fitting_pattern;
use super::calibration_file::FaceFile;
use super::cavity_lengths;
use super::document::Document;
use super::exchanged;
use super::material::existing;
use super::measured::{self, Placed, Remarks, Specimens};
use super::measurements;
use super::pattern::PatternFile;
use super::relief::read_relief;
use super::stated_specimen::{StatedSpecimen, area_m2};
use super::trace_table::{TraceConditionFile, TraceReader};
use super::traces::{ConditionTraces, OfTrial};
use super::values::Number;
use crate::diagnostic::Diagnostic;
use crate::dimension_error;
use slipgrid_units::{HUMIDITY_PCT, LENGTH_UM, PRESSURE_MPA, RELATIVE_STD, SPEED_MM_S, tidy};

/// `[[trial]]`: a sample that was cut; pending until it has measurements or traces.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrialFile {
    /// Name of the sample.
    name: Spanned<String>,
    /// When it was cut, in any form.
    #[serde(default)]
    date: String,
    /// Anything worth keeping.
    #[serde(default)]
    notes: String,
    /// Its pattern, as measured.
    pattern: Spanned<PatternFile>,
    /// CSV table of friction in the columns of flat samples.
    measurements: Option<Spanned<String>>,
    /// Raw exports of a tribometer in place of the table, one table a condition; `[traces]` says how they are read.
    traces: Option<Spanned<Vec<TraceConditionFile>>>,
    /// Face of this sample, on which `force_n` of its table counts; the calibration's specimen when absent.
    specimen: Option<Spanned<FaceFile>>,
    /// Standard error of its measured mean width, at most a third of it; 0 when absent.
    width_std_um: Option<Number>,
    /// Standard error of its measured mean spacing, at most a third of it; 0 when absent.
    spacing_std_um: Option<Number>,
    /// Standard error of its measured mean depth, at most a third of it; 0 when absent.
    depth_std_um: Option<Number>,
    /// Scatter of ln(ratio) from one such sample to the next, which no trial changes; 0.02 when absent.
    sample_std: Option<Number>,
    /// The disc of which the sample is a sector: trials with one disc name share what differs from disc to disc.
    disc: Option<Spanned<String>>,
}

impl TrialFile {
    /// The table of its measurements, where it has one.
    #[must_use]
    pub fn measurements(&self) -> Option<&str> {
        self.measurements.as_ref().map(|name| name.get_ref().as_str())
    }

    /// Conditions of its own traces, where it has some.
    #[must_use]
    pub fn traces(&self) -> Option<&[TraceConditionFile]> {
        self.traces.as_ref().map(|list| list.get_ref().as_slice())
    }
}

/// `[trial_prior]`: what is believed before anything was measured, where it differs from the defaults.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct PriorFile {
    /// Size of the discrepancy at the published squares; 0.2 when absent.
    amplitude_std: Option<f64>,
    /// Slope along (P - P0) / P0, with P0 the mean measured pressure; 0.06 when absent.
    pressure_std: Option<f64>,
    /// Slope along P1 / P, with P1 the lowest pressure, which adhesion would cause; 0.08 when absent.
    inverse_pressure_std: Option<f64>,
    /// Change for a speed e times as high; 0.05 when absent.
    speed_std: Option<f64>,
    /// Change from one humidity to another; 0.1 when absent.
    humidity_std: Option<f64>,
    /// Scatter from one sample of a texture to the next, until trials say otherwise; 0.02 when absent.
    sample_std: Option<f64>,
    /// Least relative standard error of a measurement; 0.005 when absent.
    least_measured_std: Option<f64>,
}

impl PriorFile {
    /// Each key with what it stands for.
    fn values<'a>(&'a self, of: &'a mut Hyperparameters) -> [(Option<f64>, &'a mut f64); 7] {
        [
            (self.amplitude_std, &mut of.amplitude_std),
            (self.pressure_std, &mut of.pressure_std),
            (self.inverse_pressure_std, &mut of.inverse_pressure_std),
            (self.speed_std, &mut of.speed_std),
            (self.humidity_std, &mut of.humidity_std),
            (self.sample_std, &mut of.sample_std),
            (self.least_measured_std, &mut of.least_measured_std),
        ]
    }

    fn read(&self) -> Hyperparameters {
        let mut prior = Hyperparameters::default();
        for (given, value) in self.values(&mut prior) {
            if let Some(given) = given {
                *value = given;
            }
        }
        prior
    }

    fn new(prior: &Hyperparameters) -> Self {
        Self {
            amplitude_std: Some(prior.amplitude_std),
            pressure_std: Some(prior.pressure_std),
            inverse_pressure_std: Some(prior.inverse_pressure_std),
            speed_std: Some(prior.speed_std),
            humidity_std: Some(prior.humidity_std),
            sample_std: Some(prior.sample_std),
            least_measured_std: Some(prior.least_measured_std),
        }
    }
}

/// The flat samples of a calibration, beside which its trials stand.
pub(crate) struct FlatSamples<'a> {
    /// Their specimens.
    pub(crate) stated: StatedSpecimen,
    /// What measurements on them are judged by.
    pub(crate) specimens: &'a Specimens,
    /// The measurements.
    pub(crate) measured: &'a [Placed],
}

/// Reads the `trials` of a calibration with these `flat` samples, and what is believed before them, after the sample `first` that its own
/// tables name; their traces are read by `reader`, and returned. Adds to `remarks`.
///
/// # Errors
/// [`Diagnostic`] for anything refused in them.
pub(crate) fn read_trials(
    document: &Document,
    trials: &[Spanned<TrialFile>],
    prior: Option<&Spanned<PriorFile>>,
    flat: &FlatSamples<'_>,
    first: Option<CutSample>,
    reader: &mut TraceReader<'_>,
    remarks: &mut Remarks,
) -> Result<(TrialsTask, Vec<ConditionTraces>), Diagnostic> {
    let FlatSamples { stated, specimens, measured: flat } = *flat;
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
        // What presses on a sector has a face of its own, and the sector goes on around it.
        let is_laid = file.disc.is_none();
        let pattern = read_fitting_pattern(document, &file.pattern, &own.specimen, is_laid)?;
        remarks.told.extend(cavity_lengths::unusual(document, &file.pattern));
        remarks.told.extend(exchanged::check(document, &file.pattern, &pattern, &samples));
        remarks.told.extend(exchanged::check_depth(document, &file.pattern, &pattern, &samples));
        let rows = match (&file.measurements, &file.traces) {
            (Some(_), Some(traces)) => {
                return Err(document
                    .refuse(traces.span(), "stands beside measurements")
                    .expected("either measurements or [[trial.traces]]"));
            }
            (Some(name), None) => {
                let path = existing(document, name, name.get_ref())?;
                Placed::rows(&path, measurements::read(document.source(), &path)?)
            }
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
        let std = |written: &Option<Number>, name: &str, length_m: f64| {
            dimension_error::read(document, written.as_ref(), name, length_m)
        };
        samples.push(CutSample {
            name: file.name.get_ref().clone(),
            date: file.date.clone(),
            notes: file.notes.clone(),
            relief: read_relief(document, &file.pattern, &pattern)?,
            dimensions_std_m: [
                std(&file.width_std_um, "width", pattern.width_m())?,
                std(&file.spacing_std_um, "spacing", pattern.spacing_m())?,
                std(&file.depth_std_um, "depth", pattern.depth_m())?,
            ],
            pattern,
            sample_std: document.optional(file.sample_std.as_ref(), RELATIVE_STD)?,
            specimen: if is_laid { own.cut() } else { CutSpecimen { face: None, ..own.cut() } },
            disc: read_disc(document, file.disc.as_ref())?,
            measured: rows.iter().map(|row| row.measurement).collect(),
        });
    }
    let hyper = prior.map_or_else(Hyperparameters::default, |table| table.get_ref().read());
    // A prior that means nothing is refused where it stands.
    Discrepancy::new(hyper.clone(), Conditions::default(), 0.0, Vec::new()).map_err(|error| {
        let span = prior.map_or(0..0, Spanned::span);
        document.refuse(span, error.to_string())
    })?;
    Ok((TrialsTask { samples, prior: hyper }, read))
}

/// A pattern with what no file is asked for.
#[derive(Serialize)]
struct TemplateFile<'a> {
    trial: [TemplateTrial<'a>; 1],
}

#[derive(Serialize)]
struct TemplateTrial<'a> {
    name: String,
    disc: &'a str,
    notes: String,
    pattern: toml::Table,
}

/// `[[trial]]` of `patterns` on one `disc`, in the order of its sectors, to be added to a calibration and filled in: pending until
/// they name their measurements. `densities` are the areal densities of the sectors as cut.
#[must_use]
pub fn sector_trials(disc: &str, patterns: &[Pattern], densities: &[f64]) -> String {
    let mut text = "# Trials of one disc, by slipgrid: add these to the calibration once it is cut. They are pending until each names its measurements.\n\
                    # Measure each sector alone: what presses the whole disc measures a mean of all sectors, which is a trial of none.\n\
                    # Write measured dimensions in place of the designed ones. force_n in a table counts on the calibration's specimen,\n\
                    # or on the face that [trial.specimen] gives, as that of a pin on a sector: radius_mm = 1.5.\n"
        .to_owned();
    for (place, (pattern, density)) in patterns.iter().zip(densities).enumerate() {
        let number = place + 1;
        // The keys of a pattern without what follows from them; a table of numbers and texts has a TOML form.
        let mut table = toml::Table::try_from(PatternReport::from(pattern)).unwrap_or_default();
        table.retain(|key, _| key != "areal_density" && key != "section_density");
        let trial = TemplateTrial {
            name: format!("{disc}, sector {number}"),
            disc,
            notes: format!("sector {number}, areal density as cut {:.2} %", 100.0 * density),
            pattern: table,
        };
        let body = toml::to_string(&TemplateFile { trial: [trial] }).unwrap_or_default();
        let measurements = format!("# measurements = \"sector-{number}.csv\"\n\n[trial.pattern]");
        text += &format!("\n{}", body.replacen("\n[trial.pattern]", &measurements, 1));
    }
    text
}

/// The name of the disc that a sample shares with others.
fn read_disc(document: &Document, disc: Option<&Spanned<String>>) -> Result<Option<String>, Diagnostic> {
    match disc {
        Some(name) if name.get_ref().trim().is_empty() => Err(document
            .refuse(name.span(), "names no disc")
            .expected("a name that all [[trial]] on one disc have, or no key where a sample is alone on its disc")),
        disc => Ok(disc.map(|name| name.get_ref().clone())),
    }
}

/// The sample that a calibration names by `[pattern]` and by `patterned` measurements: the first trial.
#[must_use]
pub fn of_tables(
    pattern: slipgrid_pattern::Pattern,
    relief: Option<std::sync::Arc<slipgrid_pattern::ReliefMap>>,
    specimen: CutSpecimen,
    measured: &[Placed],
) -> CutSample {
    CutSample {
        name: "patterned samples".to_owned(),
        date: String::new(),
        notes: "read from [pattern] and the patterned measurements".to_owned(),
        pattern,
        relief,
        dimensions_std_m: [0.0; 3],
        sample_std: None,
        disc: None,
        specimen,
        measured: measured.iter().map(|row| row.measurement).collect(),
    }
}

/// `[learned]` of a material file: the trials beside the model, from which the discrepancy follows.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct LearnedFile {
    /// P0, the mean measured pressure.
    reference_pressure_mpa: f64,
    /// P1, the lowest measured pressure.
    lowest_pressure_mpa: f64,
    /// Reference speed, from which the effect of speed is counted.
    reference_speed_mm_s: f64,
    /// Standard deviation of Young's modulus over the modulus.
    modulus_relative_std: f64,
    /// What is believed before any trial.
    prior: PriorFile,
    /// The trials, as they were learned from.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    trial: Vec<LearnedTrial>,
}

#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct LearnedTrial {
    /// Name of the sample.
    name: String,
    /// Share of the face that is cavity.
    areal_density: f64,
    /// Length of edges over area.
    edge_per_mm: f64,
    /// Width of a cavity.
    width_um: f64,
    /// Distance of two cavities, from middle to middle.
    pitch_um: f64,
    /// Depth of a cavity.
    depth_um: f64,
    /// Scatter of ln(ratio) from one such sample to the next.
    sample_std: Option<f64>,
    /// Standard error of its width, which tells whether it is of one texture with another; 0 when absent.
    width_std_um: Option<f64>,
    /// Standard error of its spacing; 0 when absent.
    spacing_std_um: Option<f64>,
    /// Standard error of its depth; 0 when absent.
    depth_std_um: Option<f64>,
    /// The disc of which the sample was a sector: trials with one disc name share what differs from disc to disc.
    disc: Option<String>,
    /// Nominal pressures of the measurements.
    pressure_mpa: Vec<f64>,
    /// Their speeds.
    speed_mm_s: Vec<f64>,
    /// Their relative humidities.
    humidity_pct: Vec<f64>,
    /// Measured ratios, patterned over flat.
    measured_ratio: Vec<f64>,
    /// Modelled ratios.
    modelled_ratio: Vec<f64>,
    /// Relative standard errors of friction of the patterned sample.
    patterned_std: Vec<f64>,
    /// Relative standard errors of friction of the flat sample.
    flat_std: Vec<f64>,
    /// d ln(modelled ratio) / d ln(Young's modulus).
    modulus_sensitivity: Vec<f64>,
    /// Changes of ln(modelled ratio) where local friction follows the local pressure in place of the nominal one; zeros when absent.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    local_law_change: Vec<f64>,
    /// Changes of ln(modelled ratio) by the errors of width, spacing and depth, one list each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    of_dimensions: Vec<Vec<f64>>,
    /// Areal density, edges per mm, width, pitch and depth in um of the texture with each of these dimensions one standard error larger.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    texture_of_dimensions: Vec<Vec<f64>>,
}

/// Metres in a millimetre, for edges per area.
const PER_MM: f64 = 1e-3;

/// Areal density, edges per mm, width, pitch and depth in um.
fn to_columns(of: &Features) -> [f64; 5] {
    let [width_um, pitch_um, depth_um] =
        [of.width_m, of.pitch_m, of.depth_m].map(|length_m| LENGTH_UM.from_si(length_m));
    [of.areal_density, tidy(of.edge_1_m * PER_MM), width_um, pitch_um, depth_um]
}

/// The features that [`to_columns`] wrote.
fn from_columns([areal_density, edge_per_mm, lengths_um @ ..]: &[f64; 5]) -> Features {
    let [width_m, pitch_m, depth_m] = lengths_um.map(|length_um| tidy(LENGTH_UM.to_si(length_um)));
    Features { areal_density: *areal_density, edge_1_m: tidy(edge_per_mm / PER_MM), width_m, pitch_m, depth_m }
}

impl LearnedFile {
    /// What is kept of `learned`.
    #[must_use]
    pub fn new(learned: &Discrepancy) -> Self {
        let conditions = learned.conditions();
        let trial = |trial: &Trial| {
            let column = |of: fn(&Measured) -> f64| trial.measured.iter().map(|at| tidy(of(at))).collect();
            let of_length =
                |axis: usize| Some(LENGTH_UM.from_si(trial.dimensions_std_m[axis])).filter(|std| *std > 0.0);
            let [areal_density, edge_per_mm, width_um, pitch_um, depth_um] = to_columns(&trial.features);
            LearnedTrial {
                name: trial.name.clone(),
                areal_density,
                edge_per_mm,
                width_um,
                pitch_um,
                depth_um,
                sample_std: trial.sample_std,
                width_std_um: of_length(0),
                spacing_std_um: of_length(1),
                depth_std_um: of_length(2),
                disc: trial.disc.clone(),
                pressure_mpa: column(|at| PRESSURE_MPA.from_si(at.load.pressure_pa)),
                speed_mm_s: column(|at| SPEED_MM_S.from_si(at.load.speed_m_s)),
                humidity_pct: column(|at| HUMIDITY_PCT.from_si(at.load.humidity)),
                measured_ratio: column(|at| at.measured),
                modelled_ratio: column(|at| at.modelled),
                patterned_std: column(|at| at.patterned_std),
                flat_std: column(|at| at.flat_std),
                modulus_sensitivity: column(|at| at.sensitivity.modulus),
                local_law_change: if trial.measured.iter().any(|at| at.sensitivity.local_law != 0.0) {
                    column(|at| at.sensitivity.local_law)
                } else {
                    Vec::new()
                },
                of_dimensions: trial.dimension_shifts.iter().map(|shift| shift.log_ratio.clone()).collect(),
                texture_of_dimensions: trial
                    .dimension_shifts
                    .iter()
                    .map(|shift| to_columns(&shift.above).to_vec())
                    .collect(),
            }
        };
        Self {
            reference_pressure_mpa: PRESSURE_MPA.from_si(conditions.reference_pressure_pa),
            lowest_pressure_mpa: PRESSURE_MPA.from_si(conditions.lowest_pressure_pa),
            reference_speed_mm_s: SPEED_MM_S.from_si(conditions.reference_speed_m_s),
            modulus_relative_std: learned.modulus_relative_std(),
            prior: PriorFile::new(learned.hyperparameters()),
            trial: learned.trials().iter().map(trial).collect(),
        }
    }

    /// The discrepancy that it says.
    ///
    /// # Errors
    /// [`Diagnostic`] at the table for numbers that mean nothing.
    pub fn read(document: &Document, table: &Spanned<Self>) -> Result<Discrepancy, Diagnostic> {
        let file = table.get_ref();
        let refuse = |reason: String| document.refuse(table.span(), reason);
        let trial = |trial: &LearnedTrial| {
            let n = trial.pressure_mpa.len();
            let columns = [
                &trial.speed_mm_s,
                &trial.humidity_pct,
                &trial.measured_ratio,
                &trial.modelled_ratio,
                &trial.patterned_std,
                &trial.flat_std,
                &trial.modulus_sensitivity,
            ];
            // A file of before that key holds zeros.
            let by_law = Some(&trial.local_law_change).filter(|column| !column.is_empty());
            if columns.into_iter().chain(&trial.of_dimensions).chain(by_law).any(|column| column.len() != n) {
                let reason = format!("has columns of different lengths in trial \"{}\"", trial.name);
                return Err(refuse(reason).expected("one number a pressure in each of them"));
            }
            if trial.texture_of_dimensions.iter().any(|columns| columns.len() != 5) {
                let reason = format!("has a texture of other than five numbers in trial \"{}\"", trial.name);
                return Err(refuse(reason).expected("areal density, edges per mm, width, pitch and depth"));
            }
            let measured = |row: usize| Measured {
                load: Load {
                    pressure_pa: tidy(PRESSURE_MPA.to_si(trial.pressure_mpa[row])),
                    speed_m_s: tidy(SPEED_MM_S.to_si(trial.speed_mm_s[row])),
                    humidity: tidy(HUMIDITY_PCT.to_si(trial.humidity_pct[row])),
                },
                measured: trial.measured_ratio[row],
                modelled: trial.modelled_ratio[row],
                patterned_std: trial.patterned_std[row],
                flat_std: trial.flat_std[row],
                sensitivity: Sensitivity {
                    modulus: trial.modulus_sensitivity[row],
                    local_law: trial.local_law_change.get(row).copied().unwrap_or(0.0),
                },
            };
            let LearnedTrial { areal_density, edge_per_mm, width_um, pitch_um, depth_um, .. } = *trial;
            let features = from_columns(&[areal_density, edge_per_mm, width_um, pitch_um, depth_um]);
            // A file of before that key holds what moves the model alone.
            let above = |place: usize| {
                let columns = trial.texture_of_dimensions.get(place).and_then(|columns| columns.first_chunk::<5>());
                columns.map_or(features, from_columns)
            };
            let shift = |(place, log_ratio): (usize, &Vec<f64>)| DimensionShift {
                log_ratio: log_ratio.clone(),
                above: above(place),
                below: None,
            };
            let dimension_shifts = trial.of_dimensions.iter().enumerate().map(shift).collect();
            Ok(Trial {
                name: trial.name.clone(),
                features,
                sample_std: trial.sample_std,
                disc: trial.disc.clone(),
                measured: (0..n).map(measured).collect(),
                dimensions_std_m: [trial.width_std_um, trial.spacing_std_um, trial.depth_std_um]
                    .map(|std_um| std_um.map_or(0.0, |std_um| tidy(LENGTH_UM.to_si(std_um)))),
                dimension_shifts,
            })
        };
        let trials = file.trial.iter().map(trial).collect::<Result<Vec<Trial>, Diagnostic>>()?;
        let conditions = Conditions {
            reference_pressure_pa: tidy(PRESSURE_MPA.to_si(file.reference_pressure_mpa)),
            lowest_pressure_pa: tidy(PRESSURE_MPA.to_si(file.lowest_pressure_mpa)),
            reference_speed_m_s: tidy(SPEED_MM_S.to_si(file.reference_speed_mm_s)),
        };
        Discrepancy::new(file.prior.read(), conditions, file.modulus_relative_std, trials)
            .map_err(|error| refuse(error.to_string()))
    }
}
