//! The `slipgrid` program: glue only.

use std::process::ExitCode;

fn main() -> ExitCode {
    slipgrid_cli::run(std::env::args_os(), &mut std::io::stdout(), &mut std::io::stderr()).into()
}
