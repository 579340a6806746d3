//! Traces: as an instrument exported them, and as a calibration averages them.

use std::path::Path;

use axum::extract::Query;
use serde::Deserialize;
use serde_json::{Value, json};
use slipgrid_base::units::{HUMIDITY_PCT, SPEED_MM_S, tidy};
use slipgrid_io::disk::disk;
use slipgrid_io::formats::Document;
use slipgrid_io::formats::file_kind::FileKind;
use slipgrid_io::formats::readable_traces::{ReadableTraces, read_setup};
use slipgrid_io::formats::source::read_letters;
use slipgrid_io::formats::traces::{ConditionTraces, Export, TraceSetup, parse_export};
use slipgrid_traces::columns::{Channel, Titles};
use slipgrid_traces::export::titles_in;
use slipgrid_traces::{Tangential, TraceChannels};

use crate::error::{Answer, aside};
use crate::folder::At;
use crate::places::inside;
use crate::texts::message;

/// Maximum number of points of a curve that a page draws: two for each pixel of a wide screen.
const MAX_POINTS: usize = 4000;

/// Paths of an export and of the calibration whose `[traces]` says how it is read, in the query of a request.
#[derive(Deserialize)]
pub struct AtWith {
    path: String,
    calibration: Option<String>,
}

/// Indices of the samples with which a curve is drawn: all, or the samples of lowest and highest value in every
/// stretch.
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

/// Options for exports by the `[traces]` of a calibration; default options without a calibration that can be read.
fn setup(calibration: Option<&Path>) -> TraceSetup {
    let document = calibration.map(|path| Document::read(&disk(), path, FileKind::Calibration));
    let read = document.and_then(|document| read_setup(&document.ok()?).ok());
    read.unwrap_or_else(|| TraceSetup::new(None, 1, true))
}

/// Curves of one repeat of an export, as JSON for the page.
fn curves(label: &str, channels: &TraceChannels) -> Value {
    let indices = thinned(channels.tangential.values());
    let time_s: Vec<f64> = channels.time_s.iter().map(|time_s| time_s - channels.start_s).collect();
    let friction_is = match channels.tangential {
        Tangential::TorqueNm(_) => "torque_n_m",
        Tangential::ForceN(_) => "force_n",
        Tangential::Coefficient(_) => "coefficient",
    };
    json!({
        "label": label,
        "time_s": picked(&time_s, &indices).unwrap_or_default(),
        "friction": picked(channels.tangential.values(), &indices).unwrap_or_default(),
        "friction_is": friction_is,
        "force_n": picked(&channels.normal_force_n, &indices),
    })
}

/// Answers with one export, as [`export_found`] describes it.
pub async fn one(Query(at): Query<AtWith>) -> Answer<Value> {
    aside(move || {
        let path = inside(&at.path)?;
        let calibration = at.calibration.as_deref().map(inside).transpose()?;
        Ok(export_found(&at.path, &path, setup(calibration.as_deref())))
    })
    .await
}

/// Describes an export as JSON: its columns, the curves of its repeats, notes, and the error if it cannot be read.
fn export_found(name: &str, path: &Path, mut setup: TraceSetup) -> Value {
    let mut columns = Vec::new();
    let file = read_letters(&disk(), path, "a table of traces").and_then(|text| {
        columns = columns_found(&text, &setup.titles);
        // Without the radius a torque can be drawn, although it gives no friction.
        let has_radius = setup.effective_radius_m.is_some();
        setup.effective_radius_m.get_or_insert(1.0);
        Ok((has_radius, parse_export(&Export { path: path.to_owned(), step: None }, &text, &setup)?))
    });
    let (mut samples, mut notes, mut repeats) = (0, Vec::new(), Vec::new());
    if let Ok((has_radius, file)) = &file {
        if !has_radius && file.used.contains(&Channel::Torque) {
            notes.push("a torque needs effective_radius_mm: the distance from the axis to the specimen".to_owned());
        }
        notes.extend(file.unused.iter().map(|title| format!("the column `{title}` is not used")));
        for repeat in &file.repeats {
            let label = if file.repeats.len() == 1 { name.to_owned() } else { format!("{name} ({})", repeat.number) };
            samples += repeat.channels.time_s.len();
            repeats.push(curves(&label, &repeat.channels));
        }
    }
    let error = file.err().map(|error| error.to_string());
    json!({ "path": name, "error": error, "samples": samples, "columns": columns, "notes": notes, "repeats": repeats })
}

/// Columns of an export as JSON: title, unit, and the quantity that was recognized.
fn columns_found(text: &str, titles: &Titles) -> Vec<Value> {
    let found = titles_in(text, titles);
    let count = |title: &str, upto: usize| found[..upto].iter().filter(|(other, _)| other == title).count();
    let of_title = |(place, (title, channel)): (usize, &(String, Option<Channel>))| {
        let unit = title.find(['[', '(', '{']);
        let unit = unit.map(|at| title[at..].trim_matches(['[', '(', '{', ']', ')', '}']).to_owned());
        // A number tells equal titles apart, as in `columns` of a calibration.
        let is_one = count(title, found.len()) == 1;
        let title = if is_one { title.clone() } else { format!("{title} #{}", count(title, place) + 1) };
        json!({ "title": title, "unit": unit, "role": channel.map(Channel::key) })
    };
    found.iter().enumerate().map(of_title).collect()
}

/// Mean over the repeats of a condition, and the curve of every repeat, as JSON.
fn averaged_condition(traces: &ConditionTraces) -> Value {
    let (condition, measured) = (&traces.condition, traces.measurement());
    let repeats = traces.traces.iter().map(|trace| {
        let indices = thinned(&trace.findings.mu);
        json!({
            "label": trace.label,
            "mu": trace.findings.window.mu,
            "static_mu": trace.findings.static_peak.as_ref().map(|peak| peak.mu),
            "flags": trace.flags,
            "time_s": picked(&trace.findings.time_s, &indices).unwrap_or_default(),
            "mu_t": picked(&trace.findings.mu, &indices).unwrap_or_default(),
        })
    });
    json!({
        "surface": condition.surface.name(),
        "trial": condition.trial.as_ref().map(|trial| &trial.name),
        "force_n": condition.force_n,
        "speed_mm_s": tidy(SPEED_MM_S.from_si(condition.speed_m_s)),
        "humidity_pct": tidy(HUMIDITY_PCT.from_si(condition.humidity)),
        "window_s": condition.window_s,
        "files": condition.files.iter().map(|export| export.path.display().to_string()).collect::<Vec<_>>(),
        "mu_dynamic": measured.mu_dynamic,
        "mu_dynamic_std": measured.mu_dynamic_std,
        "repeats": repeats.collect::<Vec<_>>(),
    })
}

/// Answers with the averaged traces of the calibration at a path, as far as they can be read, and with the first error.
pub async fn averaged(Query(at): Query<At>) -> Answer<Value> {
    aside(move || {
        let path = inside(&at.path)?;
        let document = Document::read(&disk(), &path, FileKind::Calibration);
        let read = document.and_then(|document| ReadableTraces::read(&document));
        let conditions: Vec<Value> = read.iter().flat_map(|read| &read.found).map(averaged_condition).collect();
        let error = match &read {
            Ok(read) => read.refused.first(),
            Err(error) => Some(error),
        };
        Ok(json!({ "conditions": conditions, "error": error.map(message) }))
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
            let text_of = |value: &Value| value.as_str().map(str::to_owned);
            let columns = columns_found(text, &Titles::default());
            columns.iter().map(|column| (text_of(&column["title"]).unwrap(), text_of(&column["role"]))).collect()
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
