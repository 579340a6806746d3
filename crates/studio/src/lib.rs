//! A page on the user's own computer for the whole workflow: from raw traces and maps to a material, from a target to
//! laser files, and from a measured sample to the next one. [`serve`] starts its server.
//!
//! | module | content |
//! |---|---|
//! | `guard` | access control: token, `Host`, `Origin`; headers of answers |
//! | `places` | paths that stay inside the folder |
//! | `folder` | files of the folder, their kinds and changes |
//! | `texts` | reading, checking, writing and editing of text files |
//! | `jobs` | commands that run one after another, with progress and cancelling |
//! | `exploring` | predictions for any texture of a design; results whose inputs changed |
//! | `exports` | traces, as read and as averaged |
//! | `example` | a folder with the published material |
//!
//! The folder is the current folder of the process, so that a command on the page and on the command line have the same words and
//! write the same bytes. Like the command line, this crate may use threads, clocks and the network; it has no equations.

mod assets;
mod error;
pub mod example;
mod exploring;
mod exports;
mod folder;
mod guard;
mod jobs;
mod places;
mod texts;

use std::collections::HashMap;
use std::io::Write;
use std::net::{Ipv4Addr, TcpListener};
use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::{Duration, SystemTime};

use axum::Router;
use axum::extract::DefaultBodyLimit;
use axum::middleware::from_fn_with_state;
use axum::routing::{get, post, put};
use slipgrid_base::monitor::Monitor;
use slipgrid_io::Failure;
use slipgrid_io::disk::KeptResults;
use slipgrid_io::disk::lock::Lock;

use guard::Guard;
use jobs::Jobs;

/// Runs a command line, whose first word is the command; writes results and notes, and returns the exit code.
pub type Runner = dyn Fn(&[String], &mut (dyn Write + Send), &mut (dyn Write + Send), &dyn Monitor) -> u8 + Send + Sync;

/// Program behind the page.
pub struct Program {
    /// Runs the commands of the page.
    pub run: Box<Runner>,
    /// Cache of results of earlier runs; `None` without a cache.
    pub kept: Option<KeptResults>,
    /// Number of computing threads.
    pub threads: usize,
}

/// Reason why the page cannot be served.
#[derive(Debug, thiserror::Error)]
pub enum StudioError {
    /// Another run works in the folder, or the folder cannot be written.
    #[error(transparent)]
    Folder(#[from] Failure),
    /// The system refuses threads or the network.
    #[error("the page cannot be served: {0}")]
    System(#[from] std::io::Error),
    /// The system refuses computing threads.
    #[error("the page cannot be served: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
}

/// Name of the file that keeps a second server out of the folder.
const LOCK: &str = ".slipgrid-studio.lock";
/// Number of threads that answer requests; computations have separate threads.
const ANSWERING_THREADS: usize = 2;
/// Interval at which [`serve`] checks whether to stop.
const STOP_INTERVAL: Duration = Duration::from_millis(100);

/// State that all request handlers share.
struct Shared {
    jobs: Jobs,
    explored: exploring::Known,
    files_at: String,
    /// When files were noticed that came with an older time, as copies do, by path.
    came: Mutex<HashMap<String, SystemTime>>,
    kinds: Mutex<folder::Kinds>,
}

/// Serves the page for the current folder at a free port of this computer, until `stop` returns true. `ready` gets the
/// address, with its token, once the page can be opened.
///
/// # Errors
/// [`StudioError`] if another server works in the folder, or if the system refuses port or threads.
pub fn serve(program: Program, ready: impl FnOnce(&str), stop: impl Fn() -> bool) -> Result<(), StudioError> {
    let _lock = Lock::new(Path::new(LOCK))?;
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?;
    listener.set_nonblocking(true)?;
    let guard = Guard::new(listener.local_addr()?.port())?;
    let address = guard.address();
    let (explored, files_at) = (exploring::Known::default(), guard.files_at());
    let (came, kinds) = (Mutex::default(), Mutex::default());
    let shared = Arc::new(Shared { jobs: Jobs::new(), explored, files_at, came, kinds });
    let computing = rayon::ThreadPoolBuilder::new().num_threads(program.threads).build()?;
    let own = Arc::clone(&shared);
    // Computing ends with the process: a job notices its cancelling between two steps.
    let _worker =
        std::thread::Builder::new().name("jobs".to_owned()).spawn(move || own.jobs.work(&program, &own, &computing))?;
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(ANSWERING_THREADS).enable_all().build()?;
    let ended = runtime.block_on(async {
        let listener = tokio::net::TcpListener::from_std(listener)?;
        tokio::spawn(folder::watch(Arc::clone(&shared)));
        tokio::spawn(async move { axum::serve(listener, router(shared, guard)).await });
        ready(&address);
        while !stop() {
            tokio::time::sleep(STOP_INTERVAL).await;
        }
        Ok(())
    });
    // Open streams of events would keep the runtime waiting.
    runtime.shutdown_background();
    ended
}

/// Routes of the server, with access control.
fn router(shared: Arc<Shared>, guard: Guard) -> Router {
    let guard = Arc::new(guard);
    let api = Router::new()
        .route("/api/folder", get(folder::list))
        .route("/api/text", get(texts::read).put(texts::write))
        .route("/api/edit", post(texts::edit))
        .route("/api/check", post(texts::check))
        .route("/api/schema", get(texts::schema))
        .route("/api/upload", put(folder::upload).layer(DefaultBodyLimit::max(folder::MAX_UPLOAD)))
        .route("/api/zip", get(folder::zipped))
        .route("/api/trace", get(exports::one))
        .route("/api/traces", get(exports::averaged))
        .route("/api/jobs", get(jobs::list).post(jobs::start))
        .route("/api/jobs/{id}/cancel", post(jobs::cancel))
        .route("/api/events", get(jobs::events))
        .route("/api/explore", post(exploring::start))
        .route("/api/predict", get(exploring::predict))
        .route("/api/changed", get(exploring::changed))
        .route("/assets/{*name}", get(assets::asset))
        .route("/", get(assets::page))
        .layer(from_fn_with_state(Arc::clone(&guard), guard::admit));
    // Pages in a frame have no cookies: their addresses hold a key of their own, which only reads files.
    let files = Router::new()
        .route("/files/{key}/{*path}", get(folder::file))
        .layer(from_fn_with_state(guard, guard::admit_reading));
    api.merge(files).with_state(shared)
}
