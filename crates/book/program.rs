//! Builds `slipgrid` next to the tests of the book, for the commands of its chapters.

use std::ffi::OsString;
use std::process::ExitCode;

fn main() -> ExitCode {
    let args = std::iter::once(OsString::from("slipgrid")).chain(std::env::args_os().skip(1));
    let kept = slipgrid_io::disk::KeptResults::for_this_program();
    slipgrid_cli::run_with(args, &mut std::io::stdout(), &mut std::io::stderr(), kept, None).into()
}
