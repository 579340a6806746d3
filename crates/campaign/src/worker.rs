//! Doing a task.

use std::path::Path;
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use serde_json::Value as Json;
use slipgrid_design::{DesignError, DesignReport, NoCache, simulate_on};
use slipgrid_formats::calibrated::{Uncalibrated, complete};
use slipgrid_formats::design::Design;
use slipgrid_formats::run::Overrides;
use slipgrid_formats::scene::SceneInput;
use slipgrid_formats::source::Source;
use slipgrid_formats::{Diagnostic, Document};
use slipgrid_monitor::{Memory, Monitor};
use slipgrid_results::{SCHEMA, SimulationReport, json_and_timings};

use crate::campaign::{Campaign, Kind, Task};
use crate::inputs::{Contents, Given, InMemory, Noted, ReadOnce};

/// How a task ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Outcome {
    /// There is a record.
    Done,
    /// Its input was refused, or is not what it was when the task was planned.
    Refused,
    /// It was computed in vain.
    Failed,
}

/// What came of a task: the same whoever did it, and when.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Done {
    /// Version of these fields.
    pub schema: u32,
    /// The task's.
    pub id: String,
    /// How it ended.
    pub outcome: Outcome,
    /// Why there is no record.
    pub reason: Option<String>,
    /// What result.json of its command holds.
    pub record: Option<Json>,
}

impl Done {
    /// A result from its JSON.
    ///
    /// # Errors
    /// What is wrong with it, to be said of it.
    pub fn read(json: &[u8]) -> Result<Self, String> {
        let done: Self = serde_json::from_slice(json).map_err(|error| format!("is no result: {error}"))?;
        if done.outcome == Outcome::Done && !done.record.as_ref().is_some_and(Json::is_object) {
            return Err("is damaged: it says \"done\" and has no record".to_owned());
        }
        Ok(done)
    }
}

/// Why a task has no record.
enum Undone {
    Refused(String),
    Failed(String),
    Cancelled,
}

impl From<Diagnostic> for Undone {
    fn from(refused: Diagnostic) -> Self {
        Self::Refused(refused.to_string())
    }
}

/// Does tasks of one campaign, as many at a time as threads call it.
pub struct Worker<'a> {
    campaign: &'a Campaign,
    files: Arc<ReadOnce>,
}

impl<'a> Worker<'a> {
    /// A worker that has the contents of files in memory.
    #[must_use]
    pub fn new(campaign: &'a Campaign, contents: Contents) -> Self {
        Self::with(campaign, Arc::new(InMemory(contents)))
    }

    /// A worker to which `store` gives the contents of files by their hashes.
    #[must_use]
    pub fn with(campaign: &'a Campaign, store: Source) -> Self {
        let given = Given::new(&campaign.inputs, store);
        Self { campaign, files: ReadOnce::new(Arc::new(given)) }
    }

    /// Does `task`; `None` where `monitor` cancels.
    pub fn work(&self, task: &Task, monitor: &dyn Monitor) -> Option<Done> {
        let (outcome, reason, record) = match self.record(task, &Quiet(monitor)) {
            Ok(record) => (Outcome::Done, None, Some(record)),
            Err(Undone::Refused(reason)) => (Outcome::Refused, Some(reason), None),
            Err(Undone::Failed(reason)) => (Outcome::Failed, Some(reason), None),
            Err(Undone::Cancelled) => return None,
        };
        Some(Done { schema: SCHEMA, id: task.id.clone(), outcome, reason, record })
    }

    fn record(&self, task: &Task, monitor: &dyn Monitor) -> Result<Json, Undone> {
        let said = |(key, reason): (String, String)| Undone::Refused(format!("{key}: {reason}"));
        let text = self.campaign.text_of(&task.values).map_err(said)?;
        let noted = Noted::new(&self.files, Path::new(""));
        let source: Source = Arc::clone(&noted) as Source;
        let document = || Document::within(&source, &self.campaign.base, text.clone());
        let whole = match self.campaign.kind {
            Kind::Scene => json_and_timings(&solved(document(), monitor)?),
            Kind::Design => json_and_timings(&designed(document(), &source, monitor)?),
        };
        if self.campaign.id(&text, &noted.seen()) != task.id {
            return Err(Undone::Refused("the task is not what it was when the campaign was planned".to_owned()));
        }
        let [whole, _] = whole.map_err(|error| Undone::Failed(error.to_string()))?;
        serde_json::from_str(&whole).map_err(|error| Undone::Failed(error.to_string()))
    }
}

/// A task under way says nothing of its stages: there are many.
struct Quiet<'a>(&'a dyn Monitor);

impl Monitor for Quiet<'_> {
    fn cancelled(&self) -> bool {
        self.0.cancelled()
    }

    fn seconds(&self) -> f64 {
        self.0.seconds()
    }

    fn memory(&self) -> Option<&dyn Memory> {
        self.0.memory()
    }
}

fn solved(document: Document, monitor: &dyn Monitor) -> Result<SimulationReport, Undone> {
    let file = document.parse()?;
    let input = SceneInput::from_file(document, &file, Overrides::default())?;
    let solved = simulate_on(&input.scene, input.specimen.as_ref(), monitor);
    if monitor.cancelled() {
        return Err(Undone::Cancelled);
    }
    let simulation = solved.map_err(|error| input.refuse_on_specimen(&error))?;
    let (_, report) = input.report(simulation, 0.0, 1).map_err(|error| Undone::Failed(error.to_string()))?;
    Ok(report)
}

fn designed(document: Document, source: &Source, monitor: &dyn Monitor) -> Result<DesignReport, Undone> {
    let mut design = Design::from_document(document)?;
    complete(&mut design, source, monitor).map_err(|error| match error {
        Uncalibrated::Refused(refused) => refused.into(),
        Uncalibrated::Cancelled => Undone::Cancelled,
        Uncalibrated::Failed(reason) => Undone::Failed(reason),
    })?;
    let found = slipgrid_design::run(&design.task, &mut NoCache, monitor).map_err(|error| match error {
        DesignError::Refused(refused) => design.refuse(&refused).into(),
        DesignError::Cancelled => Undone::Cancelled,
        error => Undone::Failed(error.to_string()),
    })?;
    Ok(found.report)
}
