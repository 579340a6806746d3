//! Fuzzing: eight thousand damaged files give a clear error or are accepted, and none crashes the program.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use crate::common::{CALIBRATION, DESIGN, FLAT, Place, SCENE, by_hand};
use slipgrid_base::statistics::SplitMix64;
use slipgrid_io::formats::calibration::Calibration;
use slipgrid_io::formats::design::Design;
use slipgrid_io::formats::measurements;
use slipgrid_io::formats::run::Overrides;
use slipgrid_io::formats::scene::SceneInput;
use slipgrid_io::formats::traces::{Export, TraceSetup, parse_export};
use slipgrid_io::formats::{Diagnostic, Document};
use slipgrid_traces::{TraceOptions, analyse};

/// Replacements of a value, separated by bars.
const VALUES: &str = "nan|-nan|inf|-inf|0|-0.0|-1|1e308|-1e308|1e-320|1e400|99999999999999999999|\
        9223372036854775807|0x7fffffffffffffff|\"\"|\"a\"|true|[]|[[]]|{}|[1.0, \"a\"]|\
        1979-05-27|1_000_000|1e7|1e-9|'''\n'''|[0.65, 0.65]|[2.6, 0.65]";

/// Text that is inserted at a random place, separated by bars.
const PIECES: &str = "\0|\u{feff}|\u{202e}|µ|\r\n|\n\n|[|]|{|}|=|\"|'''|#|,|.|[[run]]\n|a.b.c = 1\n";

/// A random one of the texts in `list`.
fn one_of(list: &'static str, dice: &mut SplitMix64) -> &'static str {
    list.split('|').nth(dice.below(list.matches('|').count() + 1)).unwrap()
}

/// Applies one to four random changes to `text`.
pub fn spoil(text: &str, dice: &mut SplitMix64) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
    for _ in 0..=dice.below(4) {
        let at = dice.below(bytes.len() + 1);
        match dice.below(9) {
            0 if at < bytes.len() => bytes[at] = dice.bits() as u8,
            1 => bytes.truncate(at),
            2 => {
                let end = (at + dice.below(12)).min(bytes.len());
                bytes.drain(at..end);
            }
            3 => {
                bytes.splice(at..at, one_of(PIECES, dice).bytes());
            }
            _ => bytes = spoil_line(&bytes, dice),
        }
    }
    bytes
}

/// Removes, doubles or moves a line, or replaces its value.
fn spoil_line(bytes: &[u8], dice: &mut SplitMix64) -> Vec<u8> {
    let mut lines: Vec<Vec<u8>> = bytes.split(|&byte| byte == b'\n').map(<[u8]>::to_vec).collect();
    let (line, other) = (dice.below(lines.len()), dice.below(lines.len()));
    match dice.below(8) {
        0 => {
            lines.remove(line);
        }
        1 => lines.insert(other, lines[line].clone()),
        2 => lines.swap(line, other),
        _ => {
            let value = one_of(VALUES, dice).as_bytes();
            let text = lines[line].clone();
            let equals = text.iter().position(|&byte| byte == b'=');
            lines[line] = match equals {
                Some(equals) => [&text[..=equals], b" ", value].concat(),
                // A table of measurements or heights: one field.
                None => {
                    let separator = if text.contains(&b',') { b',' } else { b' ' };
                    let mut fields: Vec<&[u8]> = text.split(|&byte| byte == separator).collect();
                    let field = dice.below(fields.len());
                    fields[field] = value;
                    fields.join(&separator)
                }
            };
        }
    }
    lines.join(&b'\n')
}

/// Whether the file was read. A refusal must name the file and give a reason.
fn judge<T>(read: Result<T, String>, spoiled: &[u8]) -> bool {
    match read {
        Ok(_) => true,
        Err(message) => {
            let reason = message.strip_prefix("x.").and_then(|rest| rest.split_once(": ")).map(|(_, reason)| reason);
            assert!(
                reason.is_some_and(|reason| reason.len() > 5),
                "{message:?} for {}",
                String::from_utf8_lossy(spoiled)
            );
            assert!(message.chars().count() < 600, "{message}");
            false
        }
    }
}

/// Damages `text` `times` times; returns how many results were accepted.
fn spoil_all<T>(text: &str, times: usize, seed: u64, read: impl Fn(&str, &[u8]) -> Result<T, String>) -> usize {
    let mut dice = SplitMix64(seed);
    let mut accepted = 0;
    for _ in 0..times {
        let spoiled = spoil(text, &mut dice);
        let outcome = catch_unwind(AssertUnwindSafe(|| read(&String::from_utf8_lossy(&spoiled), &spoiled)));
        let read = outcome.unwrap_or_else(|_| panic!("a panic from {}", String::from_utf8_lossy(&spoiled)));
        accepted += usize::from(judge(read, &spoiled));
    }
    accepted
}

/// Trace of 2.5 s at 20 samples a second.
fn trace() -> String {
    let rows = (0..=50).map(|i| format!("{:.2},{:.3},50,2\n", 0.05 * f64::from(i), 0.5 + 0.001 * f64::from(i % 3)));
    format!("# 20 samples a second\ntime_s,torque_nm,normal_force_n,speed_mm_s\n{}", rows.collect::<String>())
}

fn scene(text: &str) -> Result<SceneInput, String> {
    let input = SceneInput::from_document(Document::new("x.toml", text), Overrides::default());
    let input = input.map_err(|refused| refused.to_string())?;
    // What only the solver can judge is refused in its own words.
    input.scene.validate().map_err(|error| input.refuse(&error).to_string())?;
    Ok(input)
}

/// Number of accepted files among `times` damaged ones, for each kind of file.
fn spoil_everything(times: usize, seed: u64) -> [usize; 5] {
    let place = Place::with(&[("flat.csv", FLAT)]);
    let string = |refused: Diagnostic| refused.to_string();
    let near = |text: &str| Document::within(&slipgrid_io::disk::disk(), place.path("x.toml"), text);
    let folder = place.path("x.toml").display().to_string();
    let table = place.path("flat.csv").display().to_string();
    let local = |refused: Diagnostic| refused.to_string().replace(&folder, "x.toml");
    [
        spoil_all(SCENE, times, seed, |text, _| scene(text)),
        spoil_all(DESIGN, times, seed + 1, |text, _| {
            Design::from_document(Document::new("x.toml", text)).map_err(string)
        }),
        spoil_all(CALIBRATION, times, seed + 2, |text, _| {
            // The table that the calibration names may be missing, or be refused under its own name.
            let read = Calibration::from_document(&near(text)).map_err(local);
            read.map_err(|message| message.replace(&table, "x.csv").replace("flat.csv:", "x.csv:"))
        }),
        spoil_all(&trace(), times / 2, seed + 6, |text, _| {
            let file = parse_export(&Export::whole("x.csv".into()), text, &TraceSetup::new(Some(0.04), 1, true))
                .map_err(string)?;
            // What only the analysis can judge is refused in its own words.
            let options = TraceOptions {
                window_s: [1.0, 2.5],
                effective_radius_m: 0.04,
                nominal_force_n: None,
                speed_m_s: 2e-3,
                static_peak: true,
                stroke_share: None,
                zero_s: None,
            };
            analyse(&file.repeats[0].channels, &options).map_err(|error| format!("x.csv: {error}"))
        }),
        spoil_all(FLAT, times, seed + 3, |text, _| measurements::parse(Path::new("x.csv"), text).map_err(string)),
    ]
}

/// Some but not all damaged files are accepted.
fn some_are_read(rounds: u64) {
    let mut accepted = [0; 5];
    for seed in 0..rounds {
        for (sum, read) in accepted.iter_mut().zip(spoil_everything(2000, 100 * seed + 1)) {
            *sum += read;
        }
    }
    let times = 2000 * rounds as usize;
    assert!(accepted.iter().all(|&accepted| accepted > times / 100 && accepted < times), "{accepted:?} of {times}");
}

#[test]
fn thousands_of_spoiled_files_are_refused_or_read() {
    some_are_read(1);
}

#[test]
#[ignore = "half a minute"]
fn millions_of_spoiled_files_are_refused_or_read() {
    some_are_read(200);
}

/// Runs the program on a few hundred damaged files, from reading to the exit code.
#[test]
fn the_program_answers_spoiled_files_or_refuses_them() {
    // A key a line and commas in front: a line's value can be exchanged.
    let laser = r#""spot_um": 23.0, "hatch_um": 20.0, "wall_taper_deg": 5.0"#;
    let specimen = r#""shape": "ring", "outer_diameter_mm": 4.0, "inner_diameter_mm": 1.0"#;
    let result = by_hand(r#""planform": "square""#, laser, specimen);
    let words: Vec<&str> = result.split_whitespace().collect();
    let result = words.join(" ").replace(", \"", "\n, \"").replace('{', "{\n").replace('}', "\n}");
    let place = Place::with(&[]);
    let mut dice = SplitMix64(7);
    let mut codes = [0; 2];
    for _ in 0..400 {
        // JSON has colons where TOML has equals signs.
        let written = result.replace(": ", "= ");
        // JSON forgives little: half of the files have one line spoiled, mostly a value.
        let spoiled =
            if dice.below(2) == 0 { spoil(&written, &mut dice) } else { spoil_line(written.as_bytes(), &mut dice) };
        let spoiled: Vec<u8> = String::from_utf8_lossy(&spoiled).replace("= ", ": ").into_bytes();
        place.write("x.json", &spoiled);
        let path = place.path("x.json").display().to_string();
        let folder = place.path("out").display().to_string();
        let (mut out, mut err) = (Vec::new(), Vec::new());
        let args = ["slipgrid", "export", &path, "--format", "csv,svg,process", "--threads", "1", "-o", &folder];
        let code = catch_unwind(AssertUnwindSafe(|| slipgrid_cli::run(args, &mut out, &mut err)))
            .unwrap_or_else(|_| panic!("a panic from {}", String::from_utf8_lossy(&spoiled)));
        assert!(code == 0 || code == 2, "{code}: {}", String::from_utf8_lossy(&err));
        assert_eq!(code == 2, String::from_utf8_lossy(&err).starts_with("error: "));
        codes[usize::from(code == 2)] += 1;
    }
    assert!(codes.iter().all(|&count| count > 10), "{codes:?}");
}
