//! A campaign in a folder that several machines share.
//!
//! ```text
//! campaign.json           data common to all tasks
//! tasks.jsonl             one task per line: its id and the values of its keys
//! inputs/HASH             files that tasks read
//! results/00/ID.json      result of a task, in a folder named by the first two digits of its id
//! ```
//!
//! Files are never changed or appended to, except for damaged results: a file appears atomically by a rename, and two
//! workers that do one task write equal bytes. Therefore no locks are needed; on a network file system that shows files
//! late, some tasks may be done twice.

use std::collections::BTreeSet;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use serde::Serialize;

use crate::disk::WriteError;
use crate::formats::Diagnostic;
use crate::formats::source::{Files, Source, read_text};
use slipgrid_base::monitor::{Monitor, Stage};
use slipgrid_base::statistics::SplitMix64;
use slipgrid_base::units::counted;

use crate::Failure;
use crate::campaign::plan::Planned;
use crate::campaign::records::{Campaign, Task};
use crate::campaign::results::{Counts, Results};
use crate::campaign::worker::{Done, Worker};

/// File source that can also write files.
pub trait Store: Files {
    /// Writes `bytes` to the file at `path` atomically, and creates the parent folder if needed.
    ///
    /// # Errors
    /// Error of the operating system.
    fn put(&self, path: &Path, bytes: &[u8]) -> io::Result<()>;
}

/// Share of a worker: the tasks whose index, from 0, has the remainder `number` - 1 modulo `of`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Share {
    /// Index of the share, from 1 to `of`.
    pub number: usize,
    /// Number of shares.
    pub of: usize,
}

impl Share {
    /// The share that holds all tasks.
    pub const ALL: Self = Self { number: 1, of: 1 };
}

/// Summary of a worker's run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Worked {
    /// Number of tasks that this worker did, by outcome; `missing` counts the tasks of the share that still have no
    /// result.
    pub counts: Counts,
    /// Number of tasks of the share for which a valid result was found instead of computed.
    pub known: usize,
    /// Number of damaged results in the share, which were computed again.
    pub damaged: usize,
}

/// A campaign in a folder.
pub struct Folder {
    store: Arc<dyn Store>,
    path: PathBuf,
}

impl Folder {
    /// Opens the campaign in the folder `path` of `store`.
    pub fn new(store: Arc<dyn Store>, path: &Path) -> Self {
        Self { store, path: path.to_owned() }
    }

    fn put(&self, path: &Path, bytes: &[u8]) -> Result<(), Failure> {
        Ok(self.store.put(path, bytes).map_err(WriteError::at(path))?)
    }

    /// Writes a planned campaign to the folder. If the folder holds an equal campaign, that campaign and its results
    /// stay unchanged.
    ///
    /// # Errors
    /// [`Failure`] if another campaign is in the folder, or the folder is not writable.
    pub fn keep(&self, planned: &Planned) -> Result<(), Failure> {
        let (path, tasks) = (self.path.join("campaign.json"), self.path.join("tasks.jsonl"));
        let record = slipgrid_design::results::json(&planned.campaign)?;
        let lines = planned.tasks.iter().map(json_line).collect::<Result<String, _>>()?;
        let is_there = |path: &Path, text: &str| self.store.read(path).is_ok_and(|there| there == text.as_bytes());
        if self.store.entry(&path).is_ok() && !(is_there(&path, &record) && is_there(&tasks, &lines)) {
            let reason = "holds another campaign, or one whose tasks have changed since";
            return Err(Diagnostic::file(&self.path, reason)
                .expected("a new folder, or the same campaign again")
                .into());
        }
        for (hash, bytes) in &planned.contents {
            let path = self.path.join("inputs").join(hash);
            if self.store.entry(&path).is_err() {
                self.put(&path, bytes)?;
            }
        }
        self.put(&tasks, lines.as_bytes())?;
        // Written last, so that a visible campaign is complete.
        self.put(&path, record.as_bytes())
    }

    fn read(&self) -> Result<(Campaign, Vec<Task>), Failure> {
        let expected = "the folder of a campaign, as `slipgrid campaign plan -o DIR` makes it";
        let source: Source = Arc::clone(&self.store) as Source;
        let path = self.path.join("campaign.json");
        let text = read_text(&source, &path, expected).map_err(|refused| refused.expected(expected))?;
        let campaign = Campaign::read(&path, &text)?;
        let path = self.path.join("tasks.jsonl");
        let text = read_text(&source, &path, expected)?;
        let task = |(place, line): (usize, &str)| {
            serde_json::from_str(line).map_err(|error| {
                let reason = format!("is no task: {error}");
                Diagnostic { line: u32::try_from(place + 1).ok(), ..Diagnostic::file(&path, reason) }
            })
        };
        Ok((campaign, text.lines().enumerate().map(task).collect::<Result<_, Diagnostic>>()?))
    }

    fn result(&self, id: &str) -> PathBuf {
        self.path.join("results").join(id.get(..2).unwrap_or_default()).join(format!("{id}.json"))
    }

    /// Ids of the tasks that have results.
    fn known(&self) -> BTreeSet<String> {
        let results = self.path.join("results");
        let within = |name: String| self.store.names(&results.join(name));
        let names = self.store.names(&results).into_iter().flat_map(within);
        names.filter_map(|name| name.strip_suffix(".json").map(str::to_owned)).collect()
    }

    /// Reads the result of `task`; refuses a damaged result.
    fn done(&self, task: &Task) -> Result<Done, Diagnostic> {
        let path = self.result(&task.id);
        let refuse = |reason: String| Diagnostic::file(&path, reason);
        let bytes = self.store.read(&path).map_err(|error| refuse(format!("cannot be read: {error}")))?;
        let done = Done::read(&bytes).map_err(refuse)?;
        if done.id == task.id { Ok(done) } else { Err(refuse("is the result of another task".to_owned())) }
    }

    /// Does the tasks of `share` whose results are missing or damaged, `threads` at a time; after `max_s` seconds, if
    /// given, no further task is started. `seed` sets the order of the tasks, so that workers with equal shares and
    /// different seeds rarely do the same task.
    ///
    /// # Errors
    /// [`Failure`] for a folder without a campaign, a result that cannot be written, and once `monitor` cancels;
    /// results written before the error are kept.
    pub fn work(
        &self,
        share: Share,
        threads: usize,
        max_s: Option<f64>,
        seed: u64,
        monitor: &dyn Monitor,
    ) -> Result<Worked, Failure> {
        let (campaign, tasks) = self.read()?;
        let known = self.known();
        let own = || tasks.iter().enumerate().filter(|(place, _)| place % share.of.max(1) + 1 == share.number);
        let (mut missing, mut damaged) = (Vec::new(), BTreeSet::new());
        for (_, task) in own() {
            match known.contains(&task.id).then(|| self.done(task)) {
                Some(Ok(_)) => continue,
                Some(Err(refused)) => {
                    monitor.note(&format!("warning: {refused}; its task is done again"));
                    damaged.insert(task.id.as_str());
                }
                None => {}
            }
            missing.push(task);
        }
        let mut worked =
            Worked { known: own().count() - missing.len(), damaged: damaged.len(), counts: Counts::default() };
        if missing.is_empty() {
            return Ok(worked);
        }
        shuffle(&mut missing, seed);
        let results = self.path.join("results");
        monitor.kept(&results, worked.known);
        let worker = Worker::with_store(&campaign, Arc::clone(&self.store) as Source, self.path.join("inputs"));
        let stage = Stage::new(monitor, "tasks", max_s.map(|seconds| monitor.seconds() + seconds));
        let (next, ended) = (AtomicUsize::new(0), Mutex::new((worked, None::<Failure>)));
        let lane = || {
            loop {
                let place = next.fetch_add(1, Ordering::Relaxed);
                let Some(task) = missing.get(place).filter(|_| !stage.cancelled()) else { break };
                let path = self.result(&task.id);
                // Another worker may have done this task meanwhile.
                let is_there = !damaged.contains(task.id.as_str()) && self.store.entry(&path).is_ok();
                let found = if is_there { Ok(None) } else { self.do_task(&worker, task, monitor).map(Some) };
                let mut ended = ended.lock().unwrap_or_else(PoisonError::into_inner);
                match found {
                    Ok(Some(done)) => ended.0.counts.add(done.outcome),
                    Ok(None) => ended.0.known += 1,
                    Err(error) => {
                        ended.1.get_or_insert(error);
                        break;
                    }
                }
                monitor.kept(&results, ended.0.known + ended.0.counts.ended());
                stage.advance(1.0 / missing.len() as f64);
            }
        };
        // Parallel tasks share nothing; with fewer tasks than threads, each task uses several threads.
        let lanes = threads.clamp(1, missing.len());
        let each = (threads / lanes).max(1);
        std::thread::scope(|scope| -> Result<(), Failure> {
            for _ in 0..lanes {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(each).build();
                let pool = pool.map_err(Failure::failed)?;
                scope.spawn(move || pool.install(lane));
            }
            Ok(())
        })?;
        stage.finish();
        let error;
        (worked, error) = ended.into_inner().unwrap_or_else(PoisonError::into_inner);
        if let Some(error) = error {
            return Err(error);
        }
        monitor.heed()?;
        worked.counts.missing = own().count() - worked.known - worked.counts.ended();
        Ok(worked)
    }

    /// Does one task and writes its result.
    fn do_task(&self, worker: &Worker<'_>, task: &Task, monitor: &dyn Monitor) -> Result<Done, Failure> {
        let done = worker.work(task, monitor).ok_or(Failure::Cancelled)?;
        self.put(&self.result(&task.id), json_line(&done)?.as_bytes())?;
        Ok(done)
    }

    /// Collects all results and passes them to `then`.
    ///
    /// # Errors
    /// [`Failure`] for a folder without a campaign, and for damaged results, listing all of them.
    pub fn merge<T>(&self, then: impl FnOnce(&Results<'_>) -> T) -> Result<T, Failure> {
        let (campaign, tasks) = self.read()?;
        let known = self.known();
        let mut results = Results::new(&campaign);
        let mut damaged = Vec::new();
        for task in &tasks {
            match known.contains(&task.id).then(|| self.done(task)).transpose() {
                Ok(done) => results.add(task, done.as_ref()),
                Err(refused) => damaged.push(refused),
            }
        }
        if !damaged.is_empty() {
            let listed: String = damaged.iter().map(|one| format!("\n  {one}")).collect();
            return Err(Failure::SeveralRefused(format!(
                "{}; `slipgrid campaign work` on the same folder does their tasks again:{listed}",
                counted(damaged.len(), "damaged result")
            )));
        }
        Ok(then(&results))
    }
}

/// Formats `record` as JSON on a line of its own.
fn json_line(record: &impl Serialize) -> Result<String, Failure> {
    Ok(serde_json::to_string(record).map_err(Failure::failed)? + "\n")
}

/// Shuffles `items` in an order that depends on `seed` only (Fisher and Yates).
fn shuffle<T>(items: &mut [T], seed: u64) {
    let mut random = SplitMix64(seed);
    for last in (1..items.len()).rev() {
        items.swap(last, random.below(last + 1));
    }
}
