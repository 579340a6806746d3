//! Campaigns: tasks that are sent to other processes, and their results.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use slipgrid::campaign::{Campaign as Shared, Done, Planned, Results, Task, Worker, plan};

use crate::errors::{Failure, failed};
use crate::progress::watched;
use slipgrid::disk::disk;

/// Tasks with all files that they read.
#[pyclass(frozen, module = "slipgrid")]
pub struct Campaign {
    planned: Planned,
}

fn unusable(error: &dyn std::fmt::Display) -> PyErr {
    PyValueError::new_err(format!("what a campaign was made of is damaged: {error}"))
}

#[pymethods]
impl Campaign {
    /// Plans the campaign of the file at `path`.
    #[staticmethod]
    #[pyo3(signature = (path, progress=None))]
    fn plan(py: Python<'_>, path: PathBuf, progress: Option<&Bound<'_, PyAny>>) -> Result<Self, Failure> {
        Ok(Self { planned: watched(py, progress, |watch| plan(&disk(), &path, watch))?? })
    }

    /// Makes a campaign from `parts` of another campaign, with these of its tasks.
    #[staticmethod]
    fn of(shared: &str, inputs: BTreeMap<String, Vec<u8>>, tasks: Vec<String>) -> PyResult<Self> {
        let campaign: Shared = serde_json::from_str(shared).map_err(|error| unusable(&error))?;
        let task = |text: &String| -> PyResult<Task> { serde_json::from_str(text).map_err(|error| unusable(&error)) };
        let tasks = tasks.iter().map(task).collect::<PyResult<_>>()?;
        let contents = inputs.into_iter().map(|(hash, bytes)| (hash, Arc::new(bytes))).collect();
        Ok(Self { planned: Planned { campaign, tasks, contents } })
    }

    /// Data that all tasks share as JSON, and the files that they read, by hash.
    fn parts<'py>(&self, py: Python<'py>) -> Result<(String, BTreeMap<&str, Bound<'py, PyBytes>>), Failure> {
        let shared = serde_json::to_string(&self.planned.campaign).map_err(failed)?;
        let inputs = self.planned.contents.iter().map(|(hash, bytes)| (hash.as_str(), PyBytes::new(py, bytes)));
        Ok((shared, inputs.collect()))
    }

    /// Every task as JSON.
    fn tasks(&self) -> Result<Vec<String>, Failure> {
        self.planned.tasks.iter().map(|task| serde_json::to_string(task).map_err(failed)).collect()
    }

    /// The name of the campaign.
    #[getter]
    fn name(&self) -> &str {
        &self.planned.campaign.name
    }

    /// Works on all tasks in order; returns the result of each as JSON.
    fn work(&self, py: Python<'_>) -> Result<Vec<String>, Failure> {
        let Planned { campaign, tasks, contents } = &self.planned;
        let done: Option<Vec<_>> = watched(py, None, |watch| {
            let worker = Worker::new(campaign, contents.clone());
            tasks.iter().map(|task| worker.work(task, watch)).collect()
        })?;
        done.unwrap_or_default().iter().map(|done| serde_json::to_string(done).map_err(failed)).collect()
    }

    /// Table of the results in the order of the tasks, with None for a missing result, and a text that counts the results by status.
    fn table(&self, results: Vec<Option<String>>) -> PyResult<(String, String)> {
        let mut all = Results::new(&self.planned.campaign);
        for (task, text) in self.planned.tasks.iter().zip(&results) {
            let done = text.as_deref().map(|text| Done::read(text.as_bytes())).transpose();
            let done = done.map_err(|reason| unusable(&format!("a result {reason}")))?;
            all.add(task, done.as_ref());
        }
        Ok((all.csv().to_owned(), all.counts().words()))
    }
}
