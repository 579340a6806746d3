//! Ctrl-C: a first one ends a run as soon as the stage under way has heard of it, a second one at once.
//!
//! The handler sets one flag. Long loops ask it through their monitor (`Progress`) and the models that
//! searches call; a stage that did not hear of it in time is ended from here. What was being written is finished or taken
//! back first, so that no file is half written either way.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use crate::{CliError, exit_code};

/// Time that the stage under way has to hear of a first Ctrl-C.
const GRACE: Duration = Duration::from_millis(700);

/// What is kept of a search.
pub const ANSWERS: &str = "answers of the search's model";
/// What is kept of many tasks.
pub const RESULTS: &str = "finished results";

static ASKED: AtomicBool = AtomicBool::new(false);
static ACCOUNT: Mutex<Account> =
    Mutex::new(Account { stage: String::new(), written: Vec::new(), kept: None, goes_on: None });

/// What is said of a run that was interrupted.
struct Account {
    stage: String,
    /// Files and folders with results.
    written: Vec<PathBuf>,
    /// The place of what is kept whatever happens, how much it is, and of what.
    kept: Option<(PathBuf, usize, &'static str)>,
    /// The command that goes on with them.
    goes_on: Option<String>,
}

/// What others left half done in these numbers is as good as any.
fn locked<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Ends the process's runs on Ctrl-C from here on, instead of the process.
///
/// # Errors
/// [`ctrlc::Error`] if the system takes no handler.
pub fn install() -> Result<(), ctrlc::Error> {
    ctrlc::set_handler(|| {
        if ASKED.swap(true, Ordering::SeqCst) {
            end();
        }
        std::thread::spawn(|| {
            std::thread::sleep(GRACE);
            // Files appear together: not between two of them.
            let _renaming = slipgrid_disk::hold_renaming();
            // Whoever closed stderr does not want to know.
            let _ = writeln!(std::io::stderr(), "\nerror: {}", message());
            end();
        });
    })
}

/// Ends the process, with the locks that it holds.
fn end() -> ! {
    slipgrid_disk::lock::remove_all();
    std::process::exit(exit_code::INTERRUPTED.into())
}

/// Whether Ctrl-C was pressed.
#[must_use]
pub fn asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}

/// Ends a command between two stages, and one whose stage ended early.
///
/// # Errors
/// [`CliError::Interrupted`] once Ctrl-C was pressed.
pub fn heed() -> Result<(), CliError> {
    if asked() { Err(CliError::Interrupted) } else { Ok(()) }
}

/// Names the stage under way.
pub fn enter(stage: &str) {
    stage.clone_into(&mut locked(&ACCOUNT).stage);
}

/// Says that `place` holds so many of `what`, whatever happens to the run.
pub fn kept(place: &Path, count: usize, what: &'static str) {
    let mut account = locked(&ACCOUNT);
    match &mut account.kept {
        Some((path, known, _)) if path == place => *known = count,
        other => *other = Some((place.to_owned(), count, what)),
    }
}

/// Says that a result stands at `path`, whole.
pub fn wrote(path: &Path) {
    locked(&ACCOUNT).written.push(path.to_owned());
}

/// Names the command that goes on with what was kept.
pub fn goes_on_with(command: String) {
    locked(&ACCOUNT).goes_on = Some(command);
}

/// What is said of a run that was interrupted now.
#[must_use]
pub fn message() -> String {
    let account = locked(&ACCOUNT);
    let during = if account.stage.is_empty() { String::new() } else { format!(" during {}", account.stage) };
    let written: Vec<String> = account.written.iter().map(|path| path.display().to_string()).collect();
    let kept = account.kept.as_ref().filter(|(_, count, _)| *count > 0);
    let mut text = format!("interrupted{during}: ");
    if !(written.is_empty() && kept.is_some_and(|(.., what)| *what == RESULTS)) {
        let written = if written.is_empty() { "no result".to_owned() } else { written.join(", ") };
        text += &format!("{written} was written{}", if kept.is_some() { "; " } else { "" });
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
