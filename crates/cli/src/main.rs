//! The `slipgrid` program: glue only.

use std::process::ExitCode;

fn main() -> ExitCode {
    // Without a handler Ctrl-C ends the process, as everywhere.
    let _ = slipgrid_cli::interruption::install();
    slipgrid_cli::run(std::env::args_os(), &mut std::io::stdout(), &mut std::io::stderr()).into()
}
