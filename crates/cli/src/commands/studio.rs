//! `studio`: serves a page in the browser with the whole workflow, from measurements to laser files.

use std::path::Path;

use slipgrid_io::disk::{KeptResults, put};
use slipgrid_io::formats::Diagnostic;
use slipgrid_studio::{Program, Runner, example, serve};

use crate::args::StudioArgs;
use crate::interruption::{asked, hold_writing};
use crate::{CliError, Console, exit_code, run_with};

/// Default folder of `--example`.
const EXAMPLE: &str = "slipgrid-example";

/// Serves the page until Ctrl-C.
pub fn run(args: &StudioArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let usual = if args.example { EXAMPLE } else { "." };
    let folder = args.folder.as_deref().unwrap_or(Path::new(usual));
    if args.example && example::is_free(folder) {
        write_example(folder)?;
    }
    std::env::set_current_dir(folder).map_err(|error| {
        Diagnostic::file(folder, format!("cannot be opened: {error}")).expected("a folder with your measurements")
    })?;
    let (threads, no_cache) = (console.threads, console.no_cache);
    let kept = move || KeptResults::for_this_program().filter(|_| !no_cache);
    let run: Box<Runner> = Box::new(move |words, out, err, monitor| {
        let options = ["slipgrid".to_owned(), "--threads".to_owned(), threads.to_string()];
        run_with(options.iter().chain(words), out, err, kept(), Some(monitor))
    });
    let program = Program { run, kept: kept(), threads };
    let opens = !args.no_browser;
    let mut announced = Ok(());
    let ready = |address: &str| {
        announced = console.answer(&format!("slipgrid studio: {address}\nCtrl-C ends it\n"));
        let _ = console.out.flush();
        if opens && open::that_detached(address).is_err() {
            console.note("no browser was found: open the address above");
        }
    };
    serve(program, ready, asked)?;
    announced?;
    // Files of a result appear together: the process must not end between two of them.
    std::mem::forget(hold_writing());
    Ok(())
}

/// Writes the published calibration, a design and a synthesized altitude map into `folder`, which is new or empty.
fn write_example(folder: &Path) -> Result<(), CliError> {
    let failed = slipgrid_io::disk::WriteError::at(folder);
    for (name, text) in example::FILES {
        put(&folder.join(name), text.as_bytes()).map_err(&failed)?;
    }
    let map = folder.join(example::MAP).display().to_string();
    let (mut out, mut err) = (Vec::new(), Vec::new());
    let code = run_with(["slipgrid", "--quiet", "synthesize", "-o", &map], &mut out, &mut err, None, None);
    if code == exit_code::DONE { Ok(()) } else { Err(CliError::Other(String::from_utf8_lossy(&err).into_owned())) }
}
