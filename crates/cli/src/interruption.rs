//! Ctrl-C handling: the first one ends a run as soon as the current stage notices it, the second one at once.
//!
//! The handler sets a flag, which long loops poll through their monitor (`progress::Job`) and through the models that
//! searches call. A stage that does not notice the flag in time is ended by the handler. Writing in progress is
//! finished or undone first, so that no file is half written. Only the second Ctrl-C may leave an unfinished file,
//! which a later run removes.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use crate::{CliError, exit_code};

/// Time for the current stage to notice a first Ctrl-C.
const GRACE: Duration = Duration::from_millis(700);
/// Interval at which the handler looks whether a stage still writes: longer than a stage takes to end once it has written.
const WRITING: Duration = Duration::from_millis(50);

/// Words for the results that an interrupted search keeps.
pub const ANSWERS: &str = "answers of the search's model";
/// Words for the results that an interrupted campaign keeps.
pub const RESULTS: &str = "finished results";

static ASKED: AtomicBool = AtomicBool::new(false);
static ACCOUNT: Mutex<Account> = Mutex::new(Account::NONE);

/// Data for the message of an interrupted run.
struct Account {
    stage: String,
    /// Files and folders with results.
    written: Vec<PathBuf>,
    /// Path, number and description of results that are kept even if the run is interrupted.
    kept: Option<(PathBuf, usize, &'static str)>,
    /// Command that resumes from the kept results, if one can.
    goes_on: Option<String>,
}

impl Account {
    const NONE: Self = Self { stage: String::new(), written: Vec::new(), kept: None, goes_on: None };
}

/// Locks a mutex even if it is poisoned: the data of the message are valid after a panic.
fn locked<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Makes Ctrl-C interrupt the current run instead of killing the process.
///
/// # Errors
/// [`ctrlc::Error`] if the system refuses the handler.
pub fn install() -> Result<(), ctrlc::Error> {
    ctrlc::set_handler(|| {
        if ASKED.swap(true, Ordering::SeqCst) {
            end();
        }
        std::thread::spawn(|| {
            // Files of a result appear together, and unfinished ones are removed by the stage that writes them.
            std::thread::sleep(GRACE);
            let _nothing_is_written = hold_writing();
            // A closed stderr is no reason to fail.
            let _ = writeln!(std::io::stderr(), "\nerror: {}", message());
            end();
        });
    })
}

/// Waits until nothing is being written, and blocks further writing, before the program ends.
pub fn hold_writing() -> MutexGuard<'static, usize> {
    loop {
        if let Some(held) = slipgrid_io::disk::hold_writing() {
            return held;
        }
        std::thread::sleep(WRITING);
    }
}

/// Removes the lock files of the process and ends it.
fn end() -> ! {
    slipgrid_io::disk::lock::remove_all();
    std::process::exit(exit_code::INTERRUPTED.into())
}

/// Forgets the stages and files of an earlier command of this process.
pub fn begin() {
    *locked(&ACCOUNT) = Account::NONE;
}

/// Whether Ctrl-C was pressed.
pub fn asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}

/// Returns an error after Ctrl-C; called between stages, and after a stage that ended early.
///
/// # Errors
/// [`CliError::Interrupted`] after Ctrl-C.
pub fn heed() -> Result<(), CliError> {
    if asked() { Err(CliError::Interrupted) } else { Ok(()) }
}

/// Sets the name of the current stage.
pub fn enter(stage: &str) {
    stage.clone_into(&mut locked(&ACCOUNT).stage);
}

/// Records that `place` holds `count` results, which are kept even if the run is interrupted; `what` describes them.
pub fn kept(place: &Path, count: usize, what: &'static str) {
    let mut account = locked(&ACCOUNT);
    match &mut account.kept {
        Some((path, known, _)) if path == place => *known = count,
        other => *other = Some((place.to_owned(), count, what)),
    }
}

/// Records that the result at `path` is complete.
pub fn wrote(path: &Path) {
    locked(&ACCOUNT).written.push(path.to_owned());
}

/// Sets the command that resumes from the kept results.
pub fn goes_on_with(command: String) {
    locked(&ACCOUNT).goes_on = Some(command);
}

/// Message for a run that is interrupted now.
pub fn message() -> String {
    let account = locked(&ACCOUNT);
    let during = if account.stage.is_empty() { String::new() } else { format!(" during {}", account.stage) };
    let written: Vec<String> = account.written.iter().map(|path| path.display().to_string()).collect();
    let kept = account.kept.as_ref().filter(|(_, count, _)| *count > 0);
    let mut text = format!("interrupted{during}: ");
    if !(written.is_empty() && kept.is_some_and(|(.., what)| *what == RESULTS)) {
        let written = if written.is_empty() { "no result".to_owned() } else { written.join(", ") };
        text += &format!("{written} was written{}", if kept.is_some() { "\n" } else { "" });
    }
    if let Some((path, count, what)) = kept {
        text += &format!("{count} {what} are kept in {}", path.display());
        if let Some(command) = &account.goes_on {
            text += &format!(", and\n  {command}\ngoes on with them");
            if account.stage == "explorer" {
                text += "; with --no-explorer it leaves this stage, the page's sliders, out";
            }
        }
    }
    text
}
