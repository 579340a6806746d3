//! The `slipgrid` program: glue only.

use std::process::ExitCode;

fn main() -> ExitCode {
    #[cfg(unix)]
    tidy_when_ended();
    slipgrid_cli::run(std::env::args_os(), &mut std::io::stdout(), &mut std::io::stderr()).into()
}

/// Removes the locks of this run when it is ended from the keyboard or by `kill`, and then ends as any program would.
#[cfg(unix)]
fn tidy_when_ended() {
    use signal_hook::consts::{SIGINT, SIGTERM};
    use signal_hook::low_level::emulate_default_handler;
    // A run in the background of a script ignores the keyboard, and shall go on doing so.
    let heeded: Vec<i32> = [SIGINT, SIGTERM].into_iter().filter(|&signal| !is_ignored(signal)).collect();
    let Ok(mut signals) = signal_hook::iterator::Signals::new(heeded) else { return };
    std::thread::spawn(move || {
        for signal in signals.forever() {
            slipgrid_cli::lock::remove_all();
            let _ = emulate_default_handler(signal);
        }
    });
}

/// Whether the program was started to ignore `signal`, as far as the system says.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0);
    mask >> (signal - 1) & 1 == 1
}
