//! Planning: from a campaign file to its tasks.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;

use crate::formats::calibrated::complete;
use crate::formats::calibration::Calibration;
use crate::formats::confirmed_scene::steady_scene;
use crate::formats::design::Design;
use crate::formats::file_kind::FileKind;
use crate::formats::run::Overrides;
use crate::formats::scene::SceneInput;
use crate::formats::source::{Source, read_text};
use crate::formats::spanned::Spanned;
use crate::formats::{Diagnostic, Document};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::Value as Json;
use slipgrid_base::monitor::{Monitor, Stage};
use slipgrid_base::units::LENGTH_UM;
use slipgrid_design::lattice;
use slipgrid_design::results::{MadeBy, SCHEMA};
use slipgrid_infer::calibrate::Selection;
use slipgrid_model::pattern::Pattern;
use toml::{Table, Value};

use crate::Failure;
use crate::campaign::inputs::{Contents, ReadOnce, RecordedFiles};
use crate::campaign::records::{Campaign, Kind, Task};
use crate::campaign::varied::{GridFile, MAX_TASKS, Row, Varied, combinations};

/// Tables of a scene whose keys may vary even if the text of the scene does not have the table.
const SCENE_TABLES: [&str; 6] = ["material", "pattern", "sample", "load", "condition", "run"];
/// Values of the key `work` for a design, the default first: run the search, or solve every design of whole blocks and
/// bursts within bounds and limits as a steady scene.
const WORK: [&str; 2] = ["search", "table"];

/// A campaign with its tasks and input files.
#[derive(Clone, Debug, PartialEq)]
pub struct Planned {
    /// Data common to all tasks.
    pub campaign: Campaign,
    /// Tasks without duplicates, in the order of the varied values.
    pub tasks: Vec<Task>,
    /// Contents of the input files, by SHA-256 hash.
    pub contents: Contents,
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct CampaignFile {
    /// Name of the campaign; the file's name when absent.
    name: Option<String>,
    /// Path of the scene or the design whose keys the tasks vary.
    base: Spanned<String>,
    /// Work if `base` is a design: `search` optimizes in every task, `table` solves every design of whole blocks and
    /// bursts within bounds and limits as a steady scene; `search` when absent.
    work: Option<Spanned<String>>,
    /// One table `[[grid]]` for each key that varies independently; every combination of the values of all grids is a
    /// task.
    #[serde(default)]
    grid: Vec<Spanned<GridFile>>,
    /// Rows of keys that vary together, each combined with all grids.
    #[serde(default)]
    #[schemars(with = "Vec<BTreeMap<String, Json>>")]
    list: Vec<Spanned<BTreeMap<String, Spanned<Value>>>>,
}

/// Plans the campaign file at `path`. Every task is read as its command would read it, so that errors are found now.
/// `monitor` receives progress.
///
/// # Errors
/// [`Failure`] for any error in the campaign or in one of its tasks.
pub fn plan(files: &Source, path: &Path, monitor: &dyn Monitor) -> Result<Planned, Failure> {
    let text = read_text(files, path, FileKind::Campaign.expected())?;
    FileKind::Campaign.require(path, &text)?;
    let document = Document::within(files, path, text);
    let file: CampaignFile = document.parse()?;
    let varied = Varied::new(&document, &file.grid, &file.list)?;
    let name = file.name.clone().unwrap_or_else(|| document.stem());
    let base_path = document.resolve(file.base.get_ref());
    let folder = base_path.parent().unwrap_or(Path::new(""));
    let base_name = base_path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let (kind, text, base_rows) = base(files, &document, &file, &base_path, monitor)?;
    check_keys(&varied, &text, &base_rows)?;
    let rows = combinations(varied.rows.clone(), &base_rows);
    if rows.len() > MAX_TASKS {
        return Err(document.refuse(file.base.span(), "has more than a million tasks").expected("fewer values").into());
    }
    let mut keys = varied.keys.clone();
    keys.extend(base_rows.iter().flat_map(Row::keys).cloned().collect::<BTreeSet<_>>());
    let (made_by, inputs) = (MadeBy::slipgrid(SCHEMA), BTreeMap::new());
    let mut campaign = Campaign { made_by, name, kind, base: base_name, text, keys, inputs };

    let stage = Stage::new(monitor, "tasks", None);
    let read_once = ReadOnce::new(Arc::clone(files));
    let share = 1.0 / rows.len().max(1) as f64;
    let one = |values: &Row| {
        stage.heed()?;
        let noted = RecordedFiles::new(&read_once, folder);
        let source: Source = Arc::clone(&noted) as Source;
        let placed = |refused: Diagnostic| {
            // If the base file is refused without any values as well, the error refers to the base file.
            let alone = check(kind, &source, &base_path, &campaign.text, monitor).err();
            let is_base =
                |own: &Diagnostic| base_rows.is_empty() && own.key == refused.key && own.reason == refused.reason;
            let of_value = || varied.locate(&refused, values, &base_path);
            alone.filter(is_base).or_else(of_value).unwrap_or_else(|| without_line(refused.clone(), values))
        };
        let text = campaign.text_with(values).map_err(|(key, reason)| {
            let at = Diagnostic::file(&base_path, reason).expected("a key that stands in a table of the base");
            placed(Diagnostic { key: Some(key.into()), ..at })
        })?;
        check(kind, &source, &base_path, &text, monitor).map_err(placed)?;
        let inputs = noted.seen();
        stage.advance(share);
        Ok((Task { id: campaign.id(&text, &inputs), values: values.clone() }, inputs))
    };
    // The first refusal in the order of the tasks, whichever thread finds one.
    let planned: Vec<_> = rows.par_iter().map(one).collect();
    let planned = planned.into_iter().collect::<Result<Vec<_>, Failure>>()?;
    stage.finish();

    let mut known = BTreeSet::new();
    let mut tasks = Vec::with_capacity(planned.len());
    for (task, inputs) in planned {
        campaign.inputs.extend(inputs);
        // Rows that give equal tasks are merged.
        if known.insert(task.id.clone()) {
            tasks.push(task);
        }
    }
    let mut contents = read_once.contents();
    contents.retain(|hash, _| campaign.inputs.values().any(|input| input == hash));
    Ok(Planned { campaign, tasks, contents })
}

/// Reads the base file of the campaign. Returns the kind of the tasks, the TOML text that the tasks vary, and with
/// `work = "table"` one row of width, spacing and depth per design.
fn base(
    files: &Source,
    document: &Document,
    file: &CampaignFile,
    path: &Path,
    monitor: &dyn Monitor,
) -> Result<(Kind, String, Vec<Row>), Failure> {
    let text = read_text(files, path, "a scene or a design").map_err(|refused| {
        document.refuse(file.base.span(), refused.reason).expected("a scene file or a design file")
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
            complete(&mut design, files, monitor)?;
            let patterns = lattice(&design.task);
            let first = patterns.first().ok_or_else(|| {
                document
                    .refuse(file.base.span(), "has no design of whole blocks and bursts within its bounds and limits")
            })?;
            let task = &design.task;
            let known = task.material.as_ref();
            let known = known.ok_or_else(|| Failure::Failed("the design has no material".to_owned()))?;
            let (loads, _) = task.loads(&known.material).map_err(|refused| design.refuse(&refused))?;
            let scene = steady_scene(task, known, &loads, first)?;
            Ok((Kind::Scene, scene, patterns.iter().map(dimensions).collect()))
        }
        (Some(FileKind::Design), _) => Ok((Kind::Design, text, Vec::new())),
        _ => {
            let refused = document.refuse(file.base.span(), "is no scene and no design");
            Err(refused.expected("a scene file or a design file").into())
        }
    }
}

/// Width, spacing and depth of `pattern`, in micrometres, as varied keys of a scene.
fn dimensions(pattern: &Pattern) -> Row {
    let lengths = [("width", pattern.width_m()), ("spacing", pattern.spacing_m()), ("depth", pattern.depth_m())];
    lengths.map(|(name, m)| (format!("pattern.{name}_um"), Json::from(LENGTH_UM.from_si(m)))).into_iter().collect()
}

/// Reads all input that the command of a task would read before computing, so that refused input is found when
/// planning.
fn check(kind: Kind, source: &Source, path: &Path, text: &str, monitor: &dyn Monitor) -> Result<(), Diagnostic> {
    let document = Document::within(source, path, text);
    match kind {
        Kind::Scene => {
            SceneInput::from_document(document, Overrides::default())?;
        }
        Kind::Design => {
            let design = Design::from_document(document)?;
            if let Some(path) = &design.calibration {
                let task = &design.task;
                let calibration = Calibration::read(source, path)?;
                calibration.task(source, (task.layer, task.search.seed), Selection::default(), monitor)?;
            }
        }
    }
    Ok(())
}

/// Refuses varied keys that the scenes of `work = "table"`, varied by `base_rows`, do not have, or vary already. `text` is
/// that of one of these scenes.
fn check_keys(varied: &Varied<'_>, text: &str, base_rows: &[Row]) -> Result<(), Diagnostic> {
    let Some(row) = base_rows.first() else { return Ok(()) };
    for key in &varied.keys {
        if row.contains_key(key) {
            let expected = "another key, or bounds of the design that give these values";
            return Err(varied.refuse_key(key, "is what the rows of the design's table vary already", expected));
        }
        let table = key.split('.').next().unwrap_or(key);
        if !SCENE_TABLES.contains(&table) && !text.parse::<Table>().is_ok_and(|scene| scene.contains_key(table)) {
            let reason = "is no key of the scenes that work = \"table\" makes of the design";
            let expected = format!("a key of {}, or work = \"search\"", SCENE_TABLES.join(", "));
            return Err(varied.refuse_key(key, reason, &expected));
        }
    }
    Ok(())
}

/// Adapts an error that concerns none of the varied `values`: adds the values, and removes the line number, which
/// refers to the generated text of the task.
fn without_line(mut refused: Diagnostic, values: &Row) -> Diagnostic {
    refused.line = None;
    let at: Vec<String> = values.iter().map(|(key, value)| format!("{key} = {value}")).collect();
    if !at.is_empty() {
        refused.reason += &format!(" (where {})", at.join(", "));
    }
    refused
}
