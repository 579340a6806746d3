//! The `slipgrid` program: glue only.

use std::process::ExitCode;

/// Number of the signal that Ctrl-C sends.
const SIGINT: i32 = 2;

fn main() -> ExitCode {
    // A run in the background of a script ignores the keyboard, and shall go on doing so. Without a handler Ctrl-C ends the
    // process, as everywhere.
    if !is_ignored(SIGINT) {
        let _ = slipgrid_cli::interruption::install();
    }
    let kept = slipgrid_disk::KeptResults::for_this_program();
    slipgrid_cli::run_with(std::env::args_os(), &mut std::io::stdout(), &mut std::io::stderr(), kept).into()
}

/// Whether the program was started to ignore `signal`, as far as the system says.
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0);
    mask >> (signal - 1) & 1 == 1
}
