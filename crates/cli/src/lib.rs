//! The `slipgrid` command line: reads files, calls the libraries, and writes their results.
//!
//! | module | role |
//! |---|---|
//! | [`args`] | flags and help |
//! | [`interruption`] | Ctrl-C |
//! | [`output`] | atomic writing of files |
//! | [`progress`] | progress bar on a terminal, clock of long runs |
//! | [`commands`] | one module per command |
//!
//! This crate contains no equations. Only this crate and `io::disk` access files and the environment; only this crate
//! accesses the clock and stdout.
//!
//! ```
//! let (mut out, mut err) = (Vec::new(), Vec::new());
//! let code = slipgrid_cli::run(["slipgrid", "simulate", "missing.toml"], &mut out, &mut err);
//! assert_eq!(code, 2);
//! assert!(String::from_utf8_lossy(&err).starts_with("error: missing.toml: cannot be read"));
//! ```

pub mod args;
pub mod commands;

mod error;
pub mod interruption;

pub mod output;
pub mod progress;
pub mod study_file;
pub use std::ffi::OsString;
use std::io::{ErrorKind, Write};
use std::path::Path;

use clap::{CommandFactory, FromArgMatches};

pub use error::CliError;
use slipgrid_base::monitor::Monitor;
use slipgrid_base::units::counted;
use slipgrid_io::disk::{KeptResults, ResultFolder};
use slipgrid_io::formats::diagnostic::printable_lines;
use slipgrid_report::Outputs;

/// Maximum number of written files that a note names; of more files it gives the number.
const MAX_NAMED: usize = 4;

/// Exit codes of the program.
pub mod exit_code {
    use slipgrid_design::Advice;

    /// Done; `optimize`, `next`: a sample or a series is worth cutting, or a trial meets the target.
    pub const DONE: u8 = 0;
    /// Any failure without a specific code.
    pub const FAILURE: u8 = 1;
    /// Input was refused; nothing was written.
    pub const BAD_INPUT: u8 = 2;
    /// `optimize`, `next`: no design within bounds and limits is expected to meet the target, or the flat surface meets
    /// it.
    pub const UNREACHABLE: u8 = 3;
    /// `optimize`, `next`: the time limit did not suffice for every stage.
    pub const BUDGET: u8 = 4;
    /// Ctrl-C was pressed: no result was written.
    pub const INTERRUPTED: u8 = 130;

    /// Exit code of a result with this `advice`, `None` of a disc to learn from; `is_cut_short`: the time limit ended a
    /// stage.
    pub const fn of_advice(advice: Option<&Advice>, is_cut_short: bool) -> u8 {
        match advice {
            _ if is_cut_short => BUDGET,
            None | Some(Advice::Series | Advice::Trial | Advice::TrialMeetsIt { .. }) => DONE,
            Some(Advice::CannotBeMet { .. } | Advice::MeasureAgain { .. } | Advice::DoNotTexture) => UNREACHABLE,
        }
    }
}

/// Output streams and options of a command.
pub struct Console<'a> {
    /// Stream for results: stdout of the program.
    pub out: &'a mut (dyn Write + Send),
    /// Stream for notes and warnings: stderr of the program.
    pub err: &'a mut (dyn Write + Send),
    /// Suppresses the progress bar and notes.
    pub quiet: bool,
    /// Number of computing threads.
    pub threads: usize,
    /// Cache of results of earlier runs; `None` without a cache.
    pub kept: Option<KeptResults>,
    /// `--no-cache` disabled the cache.
    pub no_cache: bool,
    /// Monitor of the caller, which follows progress and may cancel the command, as Ctrl-C does; `None` outside the
    /// studio.
    pub watcher: Option<&'a dyn Monitor>,
}

impl Console<'_> {
    /// Prints a line on stderr, unless notes are suppressed.
    pub fn note(&mut self, text: &str) {
        if !self.quiet {
            // Notes are optional: a closed stderr stops nothing.
            let _ = writeln!(self.err, "{}", printable_lines(text));
        }
    }

    /// Prints warnings about an input, one line each.
    pub fn warn(&mut self, told: &[impl std::fmt::Display]) {
        told.iter().for_each(|told| self.note(&format!("warning: {told}")));
    }

    /// Prints results as text on stdout; control characters from files cannot steer a terminal.
    ///
    /// # Errors
    /// The error of the system.
    pub fn answer(&mut self, text: &str) -> std::io::Result<()> {
        self.out.write_all(printable_lines(text).as_bytes())
    }

    /// Prints `record` on stdout: as JSON, or as `text`.
    ///
    /// # Errors
    /// [`CliError`] if the record has no JSON form, or if stdout cannot be written.
    pub fn report(
        &mut self,
        as_json: bool,
        record: &impl serde::Serialize,
        text: impl FnOnce() -> String,
    ) -> Result<(), CliError> {
        if as_json {
            self.out.write_all(slipgrid_design::results::json(record)?.as_bytes())?;
        } else {
            self.answer(&text())?;
        }
        Ok(())
    }

    /// Replaces an earlier result in `folder` by `outputs`, and prints a note.
    ///
    /// # Errors
    /// [`CliError`] if a file cannot be written; see [`ResultFolder::replace`].
    pub fn keep(&mut self, outputs: &Outputs, folder: &ResultFolder) -> Result<(), CliError> {
        output::replace(outputs, folder)?;
        self.kept(outputs, folder.path());
        Ok(())
    }

    /// Prints a note that `outputs` were written into `folder`.
    pub fn kept(&mut self, outputs: &Outputs, folder: &Path) {
        let names = outputs.names();
        let files = if names.len() > MAX_NAMED { counted(names.len(), "file") } else { names.join(", ") };
        self.note(&format!("wrote {files} to {}", folder.display()));
    }
}

/// Runs the program with `args`, which begin with the program's name, and returns its exit code. Progress bars
/// are shown on the process's stderr if it is a terminal.
pub fn run<I, T>(args: I, out: &mut (dyn Write + Send), err: &mut (dyn Write + Send)) -> u8
where
    I: IntoIterator<Item = T>,
    T: Into<OsString> + Clone,
{
    run_with(args, out, err, None, None)
}

/// Lets `command` and its subcommands accept negative numbers, and lists that begin with one, as values: a negative number is then
/// reported as out of range instead of as an unknown flag.
fn with_negative_numbers(command: clap::Command) -> clap::Command {
    let is_list = |argument: &clap::Arg| {
        argument.get_value_names().is_some_and(|names| names.iter().any(|name| name.contains(',')))
    };
    let with_numbers = |argument: clap::Arg| match argument.get_action().takes_values() {
        false => argument,
        true if is_list(&argument) => argument.allow_hyphen_values(true),
        true => argument.allow_negative_numbers(true),
    };
    command.mut_args(with_numbers).mut_subcommands(with_negative_numbers)
}

/// Same as [`run`], with `kept` as the cache of earlier results unless the flags disable it; `watcher` follows progress and
/// may cancel. One command runs at a time in a process.
pub fn run_with<I, T>(
    args: I,
    out: &mut (dyn Write + Send),
    err: &mut (dyn Write + Send),
    kept: Option<KeptResults>,
    watcher: Option<&dyn Monitor>,
) -> u8
where
    I: IntoIterator<Item = T>,
    T: Into<OsString> + Clone,
{
    interruption::begin();
    let mut command = with_negative_numbers(args::Arguments::command());
    let parsed = command.try_get_matches_from_mut(args);
    let parsed = parsed.and_then(|found| args::Arguments::from_arg_matches(&found));
    let arguments = match parsed.map_err(|refused| refused.format(&mut command)) {
        Ok(arguments) => arguments,
        Err(refused) => {
            // Help and version are answers, not errors.
            let text = printable_lines(&refused.render().to_string());
            let told = if refused.use_stderr() { write!(err, "{text}") } else { write!(out, "{text}") };
            let _ = told;
            return if refused.use_stderr() { exit_code::BAD_INPUT } else { exit_code::DONE };
        }
    };
    let threads = arguments.threads.map_or_else(slipgrid_io::disk::default_threads, |threads| Ok(threads as usize));
    let pool = threads.map_err(CliError::from).and_then(|threads| {
        // Threads beyond the cores would only wait for each other: 16 on two cores take a quarter longer than two.
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.min(slipgrid_io::disk::cores())).build();
        pool.map_err(|error| CliError::Other(format!("--threads: {error}")))
    });
    let pool = match pool {
        Ok(pool) => pool,
        Err(error) => {
            let _ = writeln!(err, "error: {error}");
            return error.exit_code();
        }
    };
    let (quiet, no_cache) = (arguments.quiet, arguments.no_cache);
    let kept = kept.filter(|_| !no_cache);
    let threads = pool.current_num_threads();
    let (ended, told) = pool.install(|| {
        let unusable = kept.as_ref().and_then(KeptResults::refused);
        let mut console = Console { out: &mut *out, err: &mut *err, quiet, threads, kept, no_cache, watcher };
        console.warn(unusable.map(|refused| format!("{refused}: SLIPGRID_CACHE keeps no result")).as_slice());
        let ended = commands::run(&arguments.command, &mut console);
        let told = console.out.flush();
        (ended, told)
    });
    match ended.and_then(|code| told.map(|()| code).map_err(CliError::from)) {
        Ok(code) => code,
        // The reader closed our stdout early, as `head` does.
        Err(CliError::Stdout(error)) if error.kind() == ErrorKind::BrokenPipe => exit_code::DONE,
        Err(error) => {
            // The error of an interrupted stage is not reported.
            let is_cancelled = interruption::asked() || watcher.is_some_and(Monitor::cancelled);
            let error = if is_cancelled { CliError::Interrupted } else { error };
            let _ = writeln!(err, "error: {}", printable_lines(&error.to_string()));
            error.exit_code()
        }
    }
}
