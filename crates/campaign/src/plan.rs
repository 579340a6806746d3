//! From a campaign file to its tasks.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;

use rayon::prelude::*;
use serde::Deserialize;
use serde_json::Value as Json;
use slipgrid_calibrate::Selection;
use slipgrid_design::{DesignError, DesignTask, lattice};
use slipgrid_formats::calibrated::{Uncalibrated, complete};
use slipgrid_formats::calibration::Calibration;
use slipgrid_formats::confirmed_scene::steady_scene;
use slipgrid_formats::design::Design;
use slipgrid_formats::file_kind::FileKind;
use slipgrid_formats::run::Overrides;
use slipgrid_formats::scene::SceneInput;
use slipgrid_formats::source::{Source, read_text};
use slipgrid_formats::{Diagnostic, Document};
use slipgrid_monitor::{Monitor, Stage};
use slipgrid_pattern::Pattern;
use slipgrid_results::{SCHEMA, VERSION};
use slipgrid_studies::laboratories::{self, Job, Policy};
use slipgrid_units::LENGTH_UM;
use toml::{Spanned, Table, Value};

use crate::campaign::{Campaign, Kind, Task};
use crate::inputs::{Contents, Noted, ReadOnce};
use crate::{CampaignError, worker};

/// Most tasks of one campaign: each result is a file.
const MOST_TASKS: usize = 1_000_000;
/// Most trials of a simulated laboratory, and most widths that it chooses from.
const MOST_CHOICES: usize = 1000;
/// The base of a campaign of simulated laboratories, which is no file.
const LABORATORIES: &str = "laboratories";
/// What can be done with a design.
const WORK: [&str; 2] = ["search", "table"];

/// A campaign with its tasks and all that they read.
#[derive(Clone, Debug, PartialEq)]
pub struct Planned {
    /// What all tasks share.
    pub campaign: Campaign,
    /// The tasks, no two alike.
    pub tasks: Vec<Task>,
    /// What they read, by its hash.
    pub contents: Contents,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CampaignFile {
    /// Name of the campaign; the file's name when absent.
    name: Option<String>,
    /// Path of a scene or a design, or `laboratories` for the simulated laboratories.
    base: Spanned<String>,
    /// What is done with a design: `search`, or `table` for every design of its table as a steady scene; `search` when absent.
    work: Option<Spanned<String>>,
    /// Options of simulated laboratories, with `base = "laboratories"`.
    laboratories: Option<Spanned<laboratories::Options>>,
    /// One table for each key that is varied by itself; every combination of all grids is a task.
    #[serde(default)]
    grid: Vec<Spanned<GridFile>>,
    /// Rows of keys that go together, each with every combination of the grids.
    #[serde(default)]
    list: Vec<Spanned<Table>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct GridFile {
    /// Dotted key of the base, present there or not.
    key: String,
    /// The values that it takes.
    values: Vec<Value>,
}

/// One combination: keys with their values.
type Row = BTreeMap<String, Json>;

/// The tasks of the campaign file at `path`. Every task is read as its command would, so that what is refused is refused now;
/// `monitor` is told of it.
///
/// # Errors
/// [`CampaignError`] for anything refused in the campaign or in one of its tasks.
pub fn plan(files: &Source, path: &Path, monitor: &dyn Monitor) -> Result<Planned, CampaignError> {
    let text = read_text(files, path, "a campaign file, with base = \"SCENE or DESIGN\"")?;
    let document = Document::within(files, path, text);
    let file: CampaignFile = document.parse()?;
    let (mut keys, rows) = combinations(&document, &file)?;
    let name = file.name.clone().unwrap_or_else(|| document.stem());
    let base_path = document.resolve(file.base.get_ref());
    let folder = base_path.parent().unwrap_or(Path::new(""));
    let base_name = base_path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let (kind, text, of_base) = base(files, &document, &file, &base_path, monitor)?;
    let rows = crossed(rows, &of_base);
    if rows.len() > MOST_TASKS {
        return Err(document.refuse(file.base.span(), "has more than a million tasks").expected("fewer values").into());
    }
    keys.extend(of_base.iter().flat_map(Row::keys).cloned().collect::<BTreeSet<_>>());
    let (program, inputs) = ("slipgrid".to_owned(), BTreeMap::new());
    let version = VERSION.to_owned();
    let mut campaign = Campaign { program, version, schema: SCHEMA, name, kind, base: base_name, text, keys, inputs };

    let stage = Stage::new(monitor, "tasks", None);
    let read_once = ReadOnce::new(Arc::clone(files));
    let share = 1.0 / rows.len().max(1) as f64;
    let planned: Vec<(Task, BTreeMap<String, String>)> = rows
        .into_par_iter()
        .map(|values| {
            stage.heed().map_err(|_| CampaignError::Cancelled)?;
            let noted = Noted::new(&read_once, folder);
            let source: Source = Arc::clone(&noted) as Source;
            let text = campaign.text_of(&values).map_err(|(key, reason)| {
                let at = Diagnostic::file(&base_path, reason);
                Diagnostic { key: Some(key.into()), ..at }
            })?;
            check(kind, &source, &base_path, &text, monitor).map_err(|refused| placed(refused, &values))?;
            let inputs = noted.seen();
            stage.advance(share);
            Ok((Task { id: campaign.id(&text, &inputs), values }, inputs))
        })
        .collect::<Result<_, CampaignError>>()?;
    stage.finish();

    let mut known = BTreeSet::new();
    let mut tasks = Vec::with_capacity(planned.len());
    for (task, inputs) in planned {
        campaign.inputs.extend(inputs);
        // Rows that say the same are one task.
        if known.insert(task.id.clone()) {
            tasks.push(task);
        }
    }
    let mut contents = read_once.contents();
    contents.retain(|hash, _| campaign.inputs.values().any(|input| input == hash));
    Ok(Planned { campaign, tasks, contents })
}

/// What tasks vary: its kind, what it says, and the rows that it has of itself.
fn base(
    files: &Source,
    document: &Document,
    file: &CampaignFile,
    path: &Path,
    monitor: &dyn Monitor,
) -> Result<(Kind, String, Vec<Row>), CampaignError> {
    let failed = |error: &dyn std::fmt::Display| CampaignError::Failed(error.to_string());
    if file.base.get_ref() == LABORATORIES {
        let options = file.laboratories.as_ref().map_or_else(laboratories::Options::default, |own| *own.get_ref());
        let own = file.laboratories.as_ref().map_or_else(|| file.base.span(), Spanned::span);
        for (key, number, most) in [
            ("laboratories", options.laboratories, MOST_TASKS),
            ("most_trials", options.most_trials, MOST_CHOICES),
            ("steps", options.steps, MOST_CHOICES),
        ] {
            if number > most {
                let refused = document.refuse(own, format!("has {number} as its `{key}`"));
                return Err(refused.expected(format!("a whole number from 0 to {most}")).into());
            }
        }
        let row = |job: Job| {
            let named = [("start", job.start.name()), ("policy", job.policy.name()), ("target", job.target.name())];
            let named = named.map(|(key, name)| (key.to_owned(), Json::from(name)));
            named.into_iter().chain([("number".to_owned(), Json::from(job.number))]).collect()
        };
        let rows = Job::all(&options, &Policy::ALL).into_iter().map(row).collect();
        return Ok((Kind::Laboratory, toml::to_string(&options).map_err(|error| failed(&error))?, rows));
    }
    if let Some(own) = &file.laboratories {
        return Err(document.refuse(own.span(), "is for base = \"laboratories\"").into());
    }
    let text = read_text(files, path, "a scene or a design").map_err(|refused| {
        document.refuse(file.base.span(), refused.reason).expected("a scene file, a design file, or \"laboratories\"")
    })?;
    let kind = FileKind::of(&text);
    let work = file.work.as_ref().map_or(WORK[0], |work| work.get_ref());
    match (kind, &file.work) {
        (_, Some(named)) if !WORK.contains(&work) => {
            Err(document.refuse(named.span(), "is no work").expected("\"search\" or \"table\"").into())
        }
        (Some(FileKind::Scene), Some(named)) => {
            Err(document.refuse(named.span(), "is for designs").expected("no such key: a scene is solved").into())
        }
        (Some(FileKind::Scene), None) => Ok((Kind::Scene, text, Vec::new())),
        (Some(FileKind::Design), _) if work == WORK[1] => {
            let mut design = Design::from_document(Document::within(files, path, text))?;
            complete(&mut design, files, monitor).map_err(|error| match error {
                Uncalibrated::Refused(refused) => refused.into(),
                Uncalibrated::Cancelled => CampaignError::Cancelled,
                Uncalibrated::Failed(reason) => CampaignError::Failed(reason),
            })?;
            let (patterns, _) = lattice(&design.task);
            let first = patterns.first().ok_or_else(|| {
                document
                    .refuse(file.base.span(), "has no design of whole blocks and bursts within its bounds and limits")
            })?;
            let scene = scene(&design.task, first).map_err(|error| match error {
                DesignError::Refused(refused) => design.refuse(&refused).into(),
                error => failed(&error),
            })?;
            Ok((Kind::Scene, scene, patterns.iter().map(dimensions).collect()))
        }
        (Some(FileKind::Design), _) => Ok((Kind::Design, text, Vec::new())),
        _ => {
            let refused = document.refuse(file.base.span(), "is no scene and no design");
            Err(refused.expected("a scene file, a design file, or \"laboratories\"").into())
        }
    }
}

/// The steady scene of a period of `pattern`, at the loads of `task`.
fn scene(task: &DesignTask, pattern: &Pattern) -> Result<String, DesignError> {
    let known = task.material.as_ref().ok_or_else(|| DesignError::Failed("the design has no material".to_owned()))?;
    let (loads, _) = task.loads(&known.material)?;
    steady_scene(task, known, &loads, pattern).map_err(|error| DesignError::Failed(error.to_string()))
}

/// The row of a pattern of a table.
fn dimensions(pattern: &Pattern) -> Row {
    let lengths = [("width", pattern.width_m()), ("spacing", pattern.spacing_m()), ("depth", pattern.depth_m())];
    lengths.map(|(name, m)| (format!("pattern.{name}_um"), Json::from(LENGTH_UM.from_si(m)))).into_iter().collect()
}

/// Every combination of the grids with every row of the list, grids slowest first.
fn combinations(document: &Document, file: &CampaignFile) -> Result<(Vec<String>, Vec<Row>), Diagnostic> {
    let mut keys: Vec<String> = Vec::new();
    let mut rows: Vec<Row> = vec![Row::new()];
    for grid in &file.grid {
        let GridFile { key, values } = grid.get_ref();
        if values.is_empty() || keys.contains(key) {
            let reason = if values.is_empty() { "has no values" } else { "varies a key for the second time" };
            return Err(document.refuse(grid.span(), reason).expected("a key of its own with one value or more"));
        }
        keys.push(key.clone());
        if rows.len().saturating_mul(values.len()) > MOST_TASKS {
            return Err(document.refuse(grid.span(), "makes more than a million tasks").expected("fewer values"));
        }
        rows = crossed(rows, &values.iter().map(|value| Row::from([(key.clone(), json(value))])).collect::<Vec<_>>());
    }
    let mut list = Vec::new();
    for row in &file.list {
        for key in row.get_ref().keys() {
            if file.grid.iter().any(|grid| grid.get_ref().key == *key) {
                return Err(document.refuse(row.span(), format!("varies {key}, and so does [[grid]]")));
            }
            if !keys.contains(key) {
                keys.push(key.clone());
            }
        }
        list.push(row.get_ref().iter().map(|(key, value)| (key.clone(), json(value))).collect());
    }
    Ok((keys, crossed(rows, &list)))
}

/// Every one of `rows` with every one of `more`; as they are where there are no more.
fn crossed(rows: Vec<Row>, more: &[Row]) -> Vec<Row> {
    if more.is_empty() {
        return rows;
    }
    let with =
        |row: Row| more.iter().map(move |own| row.iter().chain(own).map(|(k, v)| (k.clone(), v.clone())).collect());
    rows.into_iter().flat_map(with).collect()
}

/// Reads what the command of a task would read before it computes anything.
fn check(kind: Kind, source: &Source, path: &Path, text: &str, monitor: &dyn Monitor) -> Result<(), Diagnostic> {
    let document = Document::within(source, path, text);
    match kind {
        Kind::Scene => {
            SceneInput::from_file(document.clone(), &document.parse()?, Overrides::default())?;
        }
        Kind::Design => {
            let design = Design::from_document(document)?;
            if let Some(path) = &design.calibration {
                let task = &design.task;
                let calibration = Calibration::read(source, path)?;
                calibration.task(source, (task.layer, task.seed), Selection::default(), monitor)?;
            }
        }
        Kind::Laboratory => {
            worker::laboratory(text).map_err(|reason| Diagnostic::file(path, reason))?;
        }
    }
    Ok(())
}

/// Says where it was refused: the line is one of the task's text, which nobody has seen.
fn placed(mut refused: Diagnostic, values: &Row) -> Diagnostic {
    refused.line = None;
    let at: Vec<String> = values.iter().map(|(key, value)| format!("{key} = {value}")).collect();
    if !at.is_empty() {
        refused.reason += &format!(" (where {})", at.join(", "));
    }
    refused
}

fn json(value: &Value) -> Json {
    serde_json::to_value(value).unwrap_or_else(|_| Json::String(value.to_string()))
}
