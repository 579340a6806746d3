//! Execution of the tasks of a campaign.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::formats::calibrated::complete;
use crate::formats::design::Design;
use crate::formats::run::Overrides;
use crate::formats::scene::SceneInput;
use crate::formats::source::Source;
use crate::formats::{Diagnostic, Document};
use serde::{Deserialize, Serialize};
use serde_json::Value as Json;
use slipgrid_base::monitor::{Memory, Monitor};
use slipgrid_design::results::{SCHEMA, SimulationReport, json_and_timings};
use slipgrid_design::{DesignError, DesignReport, NoCache, simulate_on};

use crate::Failure;
use crate::campaign::inputs::{Contents, HashedFiles, InMemory, ReadOnce, RecordedFiles};
use crate::campaign::records::{Campaign, Kind, Task};

/// Outcome of a task.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Outcome {
    /// The computation succeeded, and the result has a record.
    Done,
    /// The input was refused, or has changed since the task was planned.
    Refused,
    /// The computation failed.
    Failed,
}

/// Result of a task, independent of who did it and when.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Done {
    /// Schema version of this record.
    pub schema: u32,
    /// Id of the task.
    pub id: String,
    /// Outcome of the task.
    pub outcome: Outcome,
    /// Reason why there is no record; `None` if the outcome is `done`.
    pub reason: Option<String>,
    /// Content of the result.json that the task's command would write; `None` unless the outcome is `done`.
    pub record: Option<Json>,
}

impl Done {
    /// Parses a result file.
    ///
    /// # Errors
    /// Text that says why `json` is no valid result.
    pub fn read(json: &[u8]) -> Result<Self, String> {
        let done: Self = serde_json::from_slice(json).map_err(|error| format!("is no result: {error}"))?;
        if done.outcome == Outcome::Done && !done.record.as_ref().is_some_and(Json::is_object) {
            return Err("is damaged: it says \"done\" and has no record".to_owned());
        }
        Ok(done)
    }
}

/// Does tasks of one campaign, in as many threads as call it.
pub struct Worker<'a> {
    campaign: &'a Campaign,
    files: Arc<ReadOnce>,
}

impl<'a> Worker<'a> {
    /// Creates a worker with the contents of files in memory.
    pub fn new(campaign: &'a Campaign, contents: Contents) -> Self {
        Self::with_store(campaign, Arc::new(InMemory(contents)), PathBuf::new())
    }

    /// Creates a worker that reads the contents of files from `folder` of `store`, where they are named by their hashes.
    pub(crate) fn with_store(campaign: &'a Campaign, store: Source, folder: PathBuf) -> Self {
        let given = HashedFiles::new(&campaign.inputs, store, folder);
        Self { campaign, files: ReadOnce::new(Arc::new(given)) }
    }

    /// Does `task`; `None` if `monitor` cancels.
    pub fn work(&self, task: &Task, monitor: &dyn Monitor) -> Option<Done> {
        let (outcome, reason, record) = match self.record(task, &Quiet(monitor)) {
            Ok(record) => (Outcome::Done, None, Some(record)),
            Err(Failure::Refused(refused)) => (Outcome::Refused, Some(refused.to_string()), None),
            Err(Failure::Cancelled) => return None,
            Err(failure) => (Outcome::Failed, Some(failure.to_string()), None),
        };
        Some(Done { schema: SCHEMA, id: task.id.clone(), outcome, reason, record })
    }

    fn record(&self, task: &Task, monitor: &dyn Monitor) -> Result<Json, Failure> {
        let text = self.campaign.text_with(&task.values).map_err(|(key, reason)| Diagnostic::key(&key, reason))?;
        let noted = RecordedFiles::new(&self.files, Path::new(""));
        let source: Source = Arc::clone(&noted) as Source;
        let document = || Document::within(&source, &self.campaign.base, text.clone());
        let whole = match self.campaign.kind {
            Kind::Scene => json_and_timings(&solved(document(), monitor)?),
            Kind::Design => json_and_timings(&designed(document(), &source, monitor)?),
        };
        if self.campaign.id(&text, &noted.seen()) != task.id {
            let reason = "the task is not what it was when the campaign was planned".to_owned();
            return Err(Diagnostic { reason, ..Diagnostic::default() }.into());
        }
        let [whole, _] = whole?;
        serde_json::from_str(&whole).map_err(Failure::failed)
    }
}

/// Monitor that forwards cancellation, time and cache only, because stages of many concurrent tasks are not shown.
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

fn solved(document: Document, monitor: &dyn Monitor) -> Result<SimulationReport, Failure> {
    let input = SceneInput::from_document(document, Overrides::default())?;
    let solved = simulate_on(&input.scene, input.specimen.as_ref(), monitor);
    if monitor.cancelled() {
        return Err(Failure::Cancelled);
    }
    let simulation = solved.map_err(|error| input.refuse_on_specimen(&error))?;
    let (_, report) = input.report(simulation).map_err(Failure::failed)?;
    Ok(report)
}

fn designed(document: Document, source: &Source, monitor: &dyn Monitor) -> Result<DesignReport, Failure> {
    let mut design = Design::from_document(document)?;
    complete(&mut design, source, monitor)?;
    let found = slipgrid_design::run(&design.task, &mut NoCache, monitor).map_err(|error| match error {
        DesignError::Refused(refused) => design.refuse(&refused).into(),
        DesignError::Cancelled => Failure::Cancelled,
        error => Failure::failed(error),
    })?;
    Ok(found.report)
}
