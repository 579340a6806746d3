//! Traces: as an instrument exported them, and as a calibration averages them.

use std::path::Path;

use axum::extract::Query;
use serde::{Deserialize, Serialize};
use slipgrid_base::units::{HUMIDITY_PCT, LENGTH_MM, SPEED_MM_S, tidy};
use slipgrid_io::disk::disk;
use slipgrid_io::formats::Document;
use slipgrid_io::formats::file_kind::FileKind;
use slipgrid_io::formats::readable_traces::ReadableTraces;
use slipgrid_io::formats::source::read_letters;
use slipgrid_io::formats::traces::{ConditionTraces, Export, TraceSetup, parse_export};
use slipgrid_traces::columns::{Channel, Titles};
use slipgrid_traces::export::titles_in;
use slipgrid_traces::{Tangential, TraceChannels};

use crate::error::{Answer, aside};
use crate::places::inside;
use crate::texts::Message;

/// Maximum number of points of a curve that a page draws: two for each pixel of a wide screen.
const MAX_POINTS: usize = 4000;

/// An export and the calibration whose `[traces]` says how it is read.
#[derive(Deserialize)]
pub struct AtWith {
    path: String,
    calibration: Option<String>,
}

/// A column of an export.
#[derive(Serialize)]
struct ColumnFound {
    title: String,
    unit: Option<String>,
    role: Option<String>,
}

/// Curves of one repeat of an export.
#[derive(Serialize)]
struct RepeatFound {
    label: String,
    time_s: Vec<f64>,
    friction: Vec<f64>,
    friction_is: &'static str,
    force_n: Option<Vec<f64>>,
    position_mm: Option<Vec<f64>>,
    speed_mm_s: Option<f64>,
    humidity_pct: Option<f64>,
}

/// An export as it was understood.
#[derive(Default, Serialize)]
pub struct ExportFound {
    path: String,
    error: Option<String>,
    samples: usize,
    columns: Vec<ColumnFound>,
    notes: Vec<String>,
    repeats: Vec<RepeatFound>,
}

/// Indices of the samples that a curve needs: the lowest and the highest of every stretch.
fn thinned(values: &[f64]) -> Vec<usize> {
    if values.len() <= MAX_POINTS {
        return (0..values.len()).collect();
    }
    let stretch = values.len().div_ceil(MAX_POINTS / 2);
    let mut kept = Vec::with_capacity(MAX_POINTS);
    for (number, part) in values.chunks(stretch).enumerate() {
        let from = number * stretch;
        let index = |best: Option<(usize, &f64)>| best.map_or(from, |(index, _)| from + index);
        let low = index(part.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1)));
        let high = index(part.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)));
        kept.extend([low.min(high), low.max(high)]);
    }
    kept.dedup();
    kept
}

fn picked(values: &[f64], indices: &[usize]) -> Option<Vec<f64>> {
    // A page cannot read NaN: a missing number is drawn as 0 would mislead, so that the curve is left out.
    let picked: Vec<f64> = indices.iter().filter_map(|&index| values.get(index).copied()).collect();
    (!picked.is_empty() && picked.iter().all(|value| value.is_finite())).then_some(picked)
}

/// Options for exports by the `[traces]` of a calibration, even of one that is not complete yet.
fn setup(calibration: Option<&Path>) -> TraceSetup {
    let mut setup = TraceSetup::new(None, 1, true);
    let text = calibration.and_then(|path| std::fs::read_to_string(path).ok());
    let table: Option<toml::Table> = text.and_then(|text| toml::from_str(&text).ok());
    let Some(traces) = table.as_ref().and_then(|table| table.get("traces")) else { return setup };
    let radius_mm = traces.get("effective_radius_mm");
    let radius_mm =
        radius_mm.and_then(|value| value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64)));
    setup.effective_radius_m = radius_mm.map(|mm| LENGTH_MM.to_si(mm));
    for channel in Channel::ALL {
        let title = traces.get("columns").and_then(|columns| columns.get(channel.key())).and_then(toml::Value::as_str);
        if let Some(title) = title {
            // The check of the calibration names a title with an unknown unit.
            let _ = setup.titles.name(channel, title);
        }
    }
    setup
}

fn channels_found(label: String, channels: &TraceChannels) -> RepeatFound {
    let (friction_is, friction) = match &channels.tangential {
        Tangential::TorqueNm(values) => ("torque_n_m", values),
        Tangential::ForceN(values) => ("force_n", values),
        Tangential::Coefficient(values) => ("coefficient", values),
    };
    let indices = thinned(friction);
    let time_s: Vec<f64> = channels.time_s.iter().map(|time_s| time_s - channels.start_s).collect();
    RepeatFound {
        label,
        time_s: picked(&time_s, &indices).unwrap_or_default(),
        friction: picked(friction, &indices).unwrap_or_default(),
        friction_is,
        force_n: picked(&channels.normal_force_n, &indices),
        position_mm: None,
        speed_mm_s: None,
        humidity_pct: None,
    }
}

/// Reads one export.
pub async fn one(Query(at): Query<AtWith>) -> Answer<ExportFound> {
    aside(move || {
        let path = inside(&at.path)?;
        let calibration = at.calibration.as_deref().map(inside).transpose()?;
        let setup = setup(calibration.as_deref());
        let mut found = ExportFound { path: at.path.clone(), ..ExportFound::default() };
        let text = match read_letters(&disk(), &path, "a table of traces") {
            Ok(text) => text,
            Err(error) => return Ok(ExportFound { error: Some(error.to_string()), ..found }),
        };
        found.columns = columns_found(&text, &setup.titles);
        let has_radius = setup.effective_radius_m.is_some();
        // Without the radius a torque can be drawn, although it gives no friction.
        let setup = if has_radius { setup } else { TraceSetup { effective_radius_m: Some(1.0), ..setup } };
        match parse_export(&Export { path: path.clone(), step: None }, &text, &setup) {
            Ok(file) => {
                let torque = file.used.contains(&Channel::Torque);
                if torque && !has_radius {
                    found
                        .notes
                        .push("a torque needs effective_radius_mm: the distance from the axis to the specimen".into());
                }
                let unused = file.unused.iter().map(|title| format!("the column `{title}` is not used"));
                found.notes.extend(unused);
                let is_one = file.repeats.len() == 1;
                for repeat in &file.repeats {
                    found.samples += repeat.channels.time_s.len();
                    let label = if is_one { at.path.clone() } else { format!("{} ({})", at.path, repeat.number) };
                    let mut own = channels_found(label, &repeat.channels);
                    let indices = thinned(match &repeat.channels.tangential {
                        Tangential::TorqueNm(values) | Tangential::ForceN(values) | Tangential::Coefficient(values) => {
                            values
                        }
                    });
                    let position_mm: Vec<f64> = repeat.position_m.iter().map(|&m| LENGTH_MM.from_si(m)).collect();
                    own.position_mm = picked(&position_mm, &indices);
                    own.speed_mm_s = repeat.speed_m_s.map(|speed| tidy(SPEED_MM_S.from_si(speed)));
                    own.humidity_pct = repeat.humidity.map(|humidity| tidy(HUMIDITY_PCT.from_si(humidity)));
                    found.repeats.push(own);
                }
            }
            Err(error) => found.error = Some(error.to_string()),
        }
        Ok(found)
    })
    .await
}

fn columns_found(text: &str, titles: &Titles) -> Vec<ColumnFound> {
    let found = titles_in(text, titles);
    let count = |title: &str, upto: usize| found[..upto].iter().filter(|(other, _)| other == title).count();
    let of_title = |(place, (title, channel)): (usize, &(String, Option<Channel>))| {
        let unit = title.find(['[', '(', '{']);
        let unit = unit.map(|at| title[at..].trim_matches(['[', '(', '{', ']', ')', '}']).to_owned());
        // Of equal titles a number says which is meant, as in `columns` of a calibration.
        let is_one = count(title, found.len()) == 1;
        let title = if is_one { title.clone() } else { format!("{title} #{}", count(title, place) + 1) };
        ColumnFound { title, unit, role: channel.map(Channel::key) }
    };
    found.iter().enumerate().map(of_title).collect()
}

/// Path of a calibration in the query of a request.
#[derive(Deserialize)]
pub struct OfCalibration {
    calibration: String,
}

/// One trace of a condition.
#[derive(Serialize)]
struct AveragedRepeat {
    label: String,
    mu: f64,
    static_mu: Option<f64>,
    flags: Vec<String>,
    time_s: Vec<f64>,
    mu_t: Vec<f64>,
}

/// Mean over the repeats of a condition.
#[derive(Serialize)]
struct AveragedCondition {
    surface: &'static str,
    trial: Option<String>,
    force_n: f64,
    speed_mm_s: f64,
    humidity_pct: f64,
    window_s: [f64; 2],
    files: Vec<String>,
    mu_dynamic: f64,
    mu_dynamic_std: f64,
    repeats: Vec<AveragedRepeat>,
}

/// Conditions of a calibration's traces.
#[derive(Default, Serialize)]
pub struct Averaged {
    conditions: Vec<AveragedCondition>,
    error: Option<Message>,
}

impl From<&ConditionTraces> for AveragedCondition {
    fn from(traces: &ConditionTraces) -> Self {
        let (condition, measured) = (&traces.condition, traces.measurement());
        let repeats = traces.traces.iter().map(|trace| {
            let indices = thinned(&trace.findings.mu);
            AveragedRepeat {
                label: trace.label.clone(),
                mu: trace.findings.window.mu,
                static_mu: trace.findings.static_peak.as_ref().map(|peak| peak.mu),
                flags: trace.flags.clone(),
                time_s: picked(&trace.findings.time_s, &indices).unwrap_or_default(),
                mu_t: picked(&trace.findings.mu, &indices).unwrap_or_default(),
            }
        });
        Self {
            surface: condition.surface.name(),
            trial: condition.trial.as_ref().map(|trial| trial.name.clone()),
            force_n: condition.force_n,
            speed_mm_s: tidy(SPEED_MM_S.from_si(condition.speed_m_s)),
            humidity_pct: tidy(HUMIDITY_PCT.from_si(condition.humidity)),
            window_s: condition.window_s,
            files: condition.files.iter().map(|export| export.path.display().to_string()).collect(),
            mu_dynamic: measured.mu_dynamic,
            mu_dynamic_std: measured.mu_dynamic_std,
            repeats: repeats.collect(),
        }
    }
}

/// Reads the traces of a calibration and averages them, as far as they can be read.
pub async fn averaged(Query(of): Query<OfCalibration>) -> Answer<Averaged> {
    aside(move || {
        let path = inside(&of.calibration)?;
        let document = Document::read(&disk(), &path, FileKind::Calibration);
        Ok(match document.and_then(|document| ReadableTraces::read(&document)) {
            Ok(read) => Averaged {
                conditions: read.found.iter().map(AveragedCondition::from).collect(),
                error: read.refused.first().map(Message::from),
            },
            Err(error) => Averaged { conditions: Vec::new(), error: Some(Message::from(&error)) },
        })
    })
    .await
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinned_curves_keep_their_extremes() {
        let mut values: Vec<f64> = (0..100_000).map(|i| f64::from(i % 7)).collect();
        (values[31_415], values[92_653]) = (1e3, -1e3);
        let kept = thinned(&values);
        assert!(kept.len() <= MAX_POINTS && kept.windows(2).all(|pair| pair[0] < pair[1]));
        assert!(kept.contains(&31_415) && kept.contains(&92_653));
        assert_eq!(thinned(&values[..9]), (0..9).collect::<Vec<_>>());
    }

    #[test]
    fn columns_are_named_with_what_they_hold() {
        let roles = |text: &str| -> Vec<(String, Option<String>)> {
            columns_found(text, &Titles::default()).into_iter().map(|column| (column.title, column.role)).collect()
        };
        let role = |title: &str, role: Option<&str>| (title.to_owned(), role.map(str::to_owned));
        assert_eq!(
            roles("# by hand\nTime [s];Fx [N];Fz [N];Pressure\n0;1;2;3\n"),
            [
                role("Time [s]", Some("time")),
                role("Fx [N]", Some("friction_force")),
                role("Fz [N]", Some("normal_force")),
                role("Pressure", None)
            ]
        );
        assert_eq!(
            roles("clock,F_tan,F_norm\n0,1,2\n"),
            [role("clock", None), role("F_tan", None), role("F_norm", None)]
        );
        let twice: Vec<String> = roles("Time;Fx;Fx;Fz\n0;1;1;2\n").into_iter().map(|(title, _)| title).collect();
        assert_eq!(twice, ["Time", "Fx #1", "Fx #2", "Fz"]);
        assert_eq!(roles("no table\n"), []);
    }
}
