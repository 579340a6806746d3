//! The `slipgrid` program, a thin wrapper around the library.

use std::process::ExitCode;

/// Number of the Ctrl-C signal.
const SIGINT: i32 = 2;

fn main() -> ExitCode {
    // A background run of a script ignores the keyboard, and must continue to. Without a handler, Ctrl-C ends the
    // process as usual.
    if !is_ignored(SIGINT) {
        let _ = slipgrid_cli::interruption::install();
    }
    let kept = slipgrid_io::disk::KeptResults::for_this_program();
    slipgrid_cli::run_with(std::env::args_os(), &mut std::io::stdout(), &mut std::io::stderr(), kept, None).into()
}

/// Whether the program was started with `signal` ignored, if the system reports it.
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0);
    mask >> (signal - 1) & 1 == 1
}
