//! Jobs: commands that run one after another, with progress and cancelling.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use axum::Json;
use axum::extract::{Path, State};
use axum::http::StatusCode;
use axum::response::sse::{self, KeepAlive, Sse};
use futures_util::stream::{self, Stream, StreamExt};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use slipgrid_base::monitor::{Memory, Monitor};
use slipgrid_io::disk::{KeptResults, quoted_word};
use tokio::sync::broadcast;

use crate::error::{Answer, Refused};
use crate::places::inside;
use crate::{Program, Shared, exploring};

/// Commands that a page may run.
const ALLOWED: [&str; 10] =
    ["new", "calibrate", "traces", "trials", "next", "optimize", "export", "surface", "simulate", "synthesize"];
/// Maximum number of words of a command.
const MAX_WORDS: usize = 60;
/// Maximum number of jobs that are remembered, and that wait.
const MAX_JOBS: usize = 100;
/// Shortest time between two messages about the progress of a job, in milliseconds.
const PROGRESS_INTERVAL_MS: u64 = 80;
/// Number of messages that a page may be behind before it must load everything again.
const MAX_BEHIND: usize = 256;

/// Name and JSON data of an event for the pages: a job began, progressed or ended, or files of the folder changed.
type Event = (&'static str, String);

/// Command of a job that computes the predictions for every texture of a design; it is not a command of the program.
const EXPLORE: &str = "explore";

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
enum JobState {
    #[default]
    Queued,
    Running,
    Done,
    Failed,
    Cancelled,
}

/// Progress and result of a job.
#[derive(Default)]
struct Progress {
    state: JobState,
    stage: String,
    exit_code: Option<u8>,
    out: String,
    err: String,
    started: Option<Instant>,
    seconds: f64,
}

/// A command line to run, with its progress.
pub struct Job {
    id: u64,
    words: Vec<String>,
    progress: Mutex<Progress>,
    /// Completed share of the stage, as the bits of an f64.
    share: AtomicU64,
    is_cancelled: AtomicBool,
    told_ms: AtomicU64,
    born: Instant,
    events: broadcast::Sender<Event>,
}

/// All jobs, newest last, and the queue of those that wait.
pub struct Jobs {
    all: Mutex<Vec<Arc<Job>>>,
    queue: Sender<Arc<Job>>,
    waiting: Mutex<Option<Receiver<Arc<Job>>>>,
    events: broadcast::Sender<Event>,
}

/// Locks a mutex even if it is poisoned.
pub fn locked<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    // Every change is complete when the lock is given back.
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Jobs {
    pub fn new() -> Self {
        let (queue, waiting) = channel();
        Self {
            all: Mutex::default(),
            queue,
            waiting: Mutex::new(Some(waiting)),
            events: broadcast::channel(MAX_BEHIND).0,
        }
    }

    /// Whether a page listens to events.
    pub fn is_watched(&self) -> bool {
        self.events.receiver_count() > 0
    }

    /// Sends `event` with `data` to every open page.
    pub fn tell(&self, event: &'static str, data: impl FnOnce() -> Value) {
        tell(&self.events, event, data);
    }

    fn add(&self, words: Vec<String>) -> Result<Arc<Job>, Refused> {
        let mut all = locked(&self.all);
        let id = all.last().map_or(1, |last| last.id + 1);
        let job = Arc::new(Job {
            id,
            words,
            progress: Mutex::default(),
            share: AtomicU64::default(),
            is_cancelled: AtomicBool::default(),
            told_ms: AtomicU64::default(),
            born: Instant::now(),
            events: self.events.clone(),
        });
        // A job that has not ended stays, so that it can be cancelled.
        while all.len() >= MAX_JOBS
            && let Some(oldest) = all.iter().position(|job| locked(&job.progress).exit_code.is_some())
        {
            all.remove(oldest);
        }
        if all.len() >= MAX_JOBS {
            let reason = format!("{MAX_JOBS} jobs wait already: cancel some of them first");
            return Err(Refused(StatusCode::TOO_MANY_REQUESTS, reason));
        }
        all.push(Arc::clone(&job));
        let ended = || Refused(StatusCode::SERVICE_UNAVAILABLE, "no jobs are run any more".to_owned());
        job.tell();
        self.queue.send(Arc::clone(&job)).map_err(|_| ended())?;
        Ok(job)
    }

    /// Runs jobs in their order until the process ends.
    pub fn work(&self, program: &Program, shared: &Shared, computing: &rayon::ThreadPool) {
        let Some(waiting) = locked(&self.waiting).take() else { return };
        for job in waiting {
            if job.cancelled() {
                continue;
            }
            job.begin();
            let (mut out, mut err) = (Vec::new(), Vec::new());
            let watched = Watched { job: &job, kept: program.kept.as_ref() };
            // A defect in one job must not take the page with it.
            let run = std::panic::AssertUnwindSafe(|| match &job.words[..] {
                [command, path] if command == EXPLORE => {
                    let explored = computing.install(|| exploring::explore(path, shared, &watched));
                    match explored {
                        Ok(()) => 0,
                        Err(reason) => {
                            err = format!("error: {reason}").into_bytes();
                            1
                        }
                    }
                }
                words => (program.run)(words, &mut out, &mut err, &watched),
            });
            let exit_code = std::panic::catch_unwind(run).unwrap_or(1);
            job.end(exit_code, out, err);
        }
    }
}

impl Job {
    fn cancelled(&self) -> bool {
        self.is_cancelled.load(Ordering::Relaxed)
    }

    fn begin(&self) {
        let mut progress = locked(&self.progress);
        (progress.state, progress.started) = (JobState::Running, Some(Instant::now()));
        drop(progress);
        self.tell();
    }

    fn end(&self, exit_code: u8, out: Vec<u8>, err: Vec<u8>) {
        let mut progress = locked(&self.progress);
        progress.state = match exit_code {
            _ if self.cancelled() && exit_code != 0 => JobState::Cancelled,
            // `optimize` ends with 3 where no texture meets the target and with 4 where time ran out: both are results.
            0 | 3 | 4 => JobState::Done,
            _ => JobState::Failed,
        };
        progress.exit_code = Some(exit_code);
        progress.seconds = progress.started.map_or(0.0, |started| started.elapsed().as_secs_f64());
        (progress.out, progress.err) = (to_text(out), to_text(err));
        drop(progress);
        self.tell();
    }

    fn tell(&self) {
        tell(&self.events, "job", || self.to_json());
    }

    /// Sends the progress to open pages, at most once per [`PROGRESS_INTERVAL_MS`].
    fn tell_progress(&self) {
        let now_ms = u64::try_from(self.born.elapsed().as_millis()).unwrap_or(u64::MAX);
        let before_ms = self.told_ms.load(Ordering::Relaxed);
        let is_due = now_ms >= before_ms + PROGRESS_INTERVAL_MS;
        if is_due && self.told_ms.compare_exchange(before_ms, now_ms, Ordering::Relaxed, Ordering::Relaxed).is_ok() {
            self.tell();
        }
    }

    fn to_json(&self) -> Value {
        let progress = locked(&self.progress);
        let is_running = progress.state == JobState::Running;
        let running_s = || progress.started.map_or(0.0, |started| started.elapsed().as_secs_f64());
        json!({
            "id": self.id,
            "command": self.words,
            "line": format!("slipgrid {}", self.words.iter().map(|word| quoted_word(word)).collect::<Vec<_>>().join(" ")),
            "state": progress.state,
            "is_cancelled": self.cancelled(),
            "stage": progress.stage,
            "share": f64::from_bits(self.share.load(Ordering::Relaxed)).clamp(0.0, 1.0),
            "exit_code": progress.exit_code,
            "out": progress.out,
            "err": progress.err,
            "seconds": if is_running { running_s() } else { progress.seconds },
        })
    }
}

/// Sends `event` with `data` to every open page; `data` is not called without one.
fn tell(events: &broadcast::Sender<Event>, event: &'static str, data: impl FnOnce() -> Value) {
    if events.receiver_count() > 0 {
        let _ = events.send((event, data().to_string()));
    }
}

fn to_text(bytes: Vec<u8>) -> String {
    String::from_utf8_lossy(&bytes).into_owned()
}

/// Monitor of a running job.
struct Watched<'a> {
    job: &'a Job,
    kept: Option<&'a KeptResults>,
}

impl Monitor for Watched<'_> {
    fn stage(&self, name: &str) {
        name.clone_into(&mut locked(&self.job.progress).stage);
        self.job.share.store(0.0_f64.to_bits(), Ordering::Relaxed);
        self.job.tell_progress();
    }

    fn detail(&self, text: &str) {
        text.clone_into(&mut locked(&self.job.progress).stage);
        self.job.tell_progress();
    }

    fn advance(&self, share: f64) {
        let add = |bits| Some((f64::from_bits(bits) + share).to_bits());
        let _ = self.job.share.fetch_update(Ordering::Relaxed, Ordering::Relaxed, add);
        self.job.tell_progress();
    }

    fn cancelled(&self) -> bool {
        self.job.cancelled()
    }

    fn seconds(&self) -> f64 {
        self.job.born.elapsed().as_secs_f64()
    }

    fn memory(&self) -> Option<&dyn Memory> {
        self.kept.map(|kept| kept as &dyn Memory)
    }
}

/// Words of a command line, without the program's name.
#[derive(Deserialize)]
pub struct Asked {
    command: Vec<String>,
}

/// Refuses commands that a page may not run, and words that name files outside the folder.
fn check(words: &[String]) -> Result<(), Refused> {
    let Some((command, rest)) = words.split_first() else { return Err(Refused::bad("a job without a command")) };
    if !ALLOWED.contains(&&command[..]) {
        return Err(Refused::bad(format!("{command:?} is no command of this page: expected {}", ALLOWED.join(", "))));
    }
    if words.len() > MAX_WORDS {
        return Err(Refused::bad(format!("a command of more than {MAX_WORDS} words")));
    }
    for word in rest {
        let is_flag = word.starts_with('-') && !word.chars().all(|letter| letter == '-' || letter == '.');
        let is_plain = word.chars().all(|letter| letter.is_ascii_alphanumeric() || "-.,".contains(letter));
        // A value joined to a flag could name a file.
        if is_flag && !is_plain {
            return Err(Refused::bad(format!("{word:?}: give a flag and its value as two words")));
        }
        if !is_flag {
            inside(word)?;
        }
    }
    Ok(())
}

/// Adds a job to the queue, and answers with its id.
pub async fn start(State(shared): State<Arc<Shared>>, Json(asked): Json<Asked>) -> Answer<Value> {
    check(&asked.command)?;
    Ok(Json(json!({ "id": shared.jobs.add(asked.command)?.id })))
}

/// Adds a job that computes predictions for the design at `path`, cancels earlier ones for this design, and answers
/// with the id.
pub fn start_exploring(shared: &Shared, path: &str) -> Result<Json<Value>, Refused> {
    inside(path)?;
    let words = vec![EXPLORE.to_owned(), path.to_owned()];
    // Earlier computations of the same predictions are out of date.
    for job in locked(&shared.jobs.all).iter() {
        if job.words == words && locked(&job.progress).exit_code.is_none() {
            cancel_job(job);
        }
    }
    Ok(Json(json!({ "id": shared.jobs.add(words)?.id })))
}

/// Lists jobs, newest first.
pub async fn list(State(shared): State<Arc<Shared>>) -> Json<Value> {
    let jobs: Vec<Value> = locked(&shared.jobs.all).iter().rev().map(|job| job.to_json()).collect();
    Json(json!({ "jobs": jobs }))
}

fn cancel_job(job: &Job) {
    job.is_cancelled.store(true, Ordering::Relaxed);
    let mut progress = locked(&job.progress);
    if progress.state == JobState::Queued {
        (progress.state, progress.exit_code) = (JobState::Cancelled, Some(1));
    }
    drop(progress);
    job.tell();
}

/// Cancels a job.
pub async fn cancel(State(shared): State<Arc<Shared>>, Path(id): Path<u64>) -> Answer<Value> {
    let found = locked(&shared.jobs.all).iter().find(|job| job.id == id).cloned();
    let job = found.ok_or_else(|| Refused(StatusCode::NOT_FOUND, format!("there is no job {id}")))?;
    cancel_job(&job);
    Ok(Json(json!({})))
}

/// Answers with the stream of events for a page.
pub async fn events(
    State(shared): State<Arc<Shared>>,
) -> Sse<impl Stream<Item = Result<sse::Event, std::convert::Infallible>>> {
    let receiver = shared.jobs.events.subscribe();
    let event = |(name, data): (&str, String)| Ok(sse::Event::default().event(name).data(data));
    let hello = || ("hello", "{}".to_owned());
    let told = stream::unfold(receiver, move |mut receiver| async move {
        let next = match receiver.recv().await {
            Ok(told) => told,
            // The page was too slow: it loads everything again.
            Err(broadcast::error::RecvError::Lagged(_)) => hello(),
            Err(broadcast::error::RecvError::Closed) => return None,
        };
        Some((event(next), receiver))
    });
    let hello = stream::once(async move { event(hello()) });
    Sse::new(hello.chain(told)).keep_alive(KeepAlive::default())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_a_full_list_the_oldest_job_that_has_ended_goes() {
        let jobs = Jobs::new();
        let add = || jobs.add(vec!["traces".to_owned()]).unwrap_or_else(|refused| panic!("{}", refused.1));
        let queued = add();
        for _ in 1..MAX_JOBS {
            add().end(0, Vec::new(), Vec::new());
        }
        let last = add();
        let ids: Vec<u64> = locked(&jobs.all).iter().map(|job| job.id).collect();
        assert_eq!((ids.len(), ids[0], ids[1], ids[MAX_JOBS - 1]), (MAX_JOBS, queued.id, 3, last.id));
        let wait = (0..).find_map(|_| jobs.add(vec!["traces".to_owned()]).err()).map(|refused| refused.0);
        assert_eq!((wait, locked(&jobs.all).len()), (Some(StatusCode::TOO_MANY_REQUESTS), MAX_JOBS));
    }

    #[test]
    fn commands_stay_in_the_folder() {
        let words = |line: &str| line.split(' ').map(str::to_owned).collect::<Vec<_>>();
        for line in
            ["optimize a.toml", "next a.toml --count 3 -o out/a-next --json", "surface m.asc --crop 0,0,9,9 -o out/m"]
        {
            assert!(check(&words(line)).is_ok(), "{line}");
        }
        for line in [
            "studio .",
            "campaign work x",
            "optimize ../a.toml",
            "optimize /etc/passwd",
            "optimize a.toml -o ..",
            "optimize a.toml -o/tmp/x",
            "optimize a.toml --output=/tmp/x",
            "optimize a.toml --output=../x",
            "optimize a.toml -o .hidden",
        ] {
            assert!(check(&words(line)).is_err(), "{line}");
        }
        assert!(check(&[]).is_err());
    }
}
