//! `traces`: converts tribometer exports to measurements.

use std::path::Path;

use crate::args::TracesArgs;
use crate::output::{self, open};
use crate::{CliError, Console};
use slipgrid_base::units::{FORCE_N, HUMIDITY_PCT, LENGTH_MM, Quantity, SPEED_MM_S, TIME_S};
use slipgrid_io::formats::calibration::Calibration;
use slipgrid_io::formats::file_kind::FileKind;
use slipgrid_io::formats::traces::{
    ConditionTraces, Export, SurfaceKind, TraceCondition, TraceSetup, analyse_condition,
};
use slipgrid_io::formats::{Diagnostic, checked};
use slipgrid_report::traces;
use slipgrid_traces::{DEFAULT_STROKE_SHARE, DEFAULT_WINDOW_S};

/// Patterns of the names of files that this command may write.
pub const FILES: [&str; 7] = [
    "flat.csv",
    "patterned.csv",
    "trial-*-measured.csv",
    "traces.csv",
    "flat-*.svg",
    "patterned-*.svg",
    "trial-*pct.svg",
];

/// Reads exports and reports.
pub fn run(args: &TracesArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let folder = open(args.output.as_ref(), &FILES, &args.files)?;
    let conditions = match &args.files[..] {
        [file] if is_calibration(file) => of_calibration(file, args)?,
        [folder] if folder.is_dir() => {
            return Err(FileKind::Calibration.refuse_folder(&slipgrid_io::disk::disk(), folder).into());
        }
        _ => vec![analyse_condition(&slipgrid_io::disk::disk(), &setup(args)?, &condition(args)?)?],
    };
    if let Some(folder) = &folder {
        let outputs = traces::files(&conditions)?;
        // Flat and patterned samples, or several conditions, may be written to one folder in turn.
        output::add(&outputs, folder)?;
        console.kept(&outputs, folder.path());
    }
    Ok(console.answer(&traces::summary(&conditions))?)
}

fn is_calibration(file: &Path) -> bool {
    file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"))
}

/// Analysed traces of the calibration `file`, by condition; refuses flags that describe exports.
fn of_calibration(file: &Path, args: &TracesArgs) -> Result<Vec<ConditionTraces>, Diagnostic> {
    let flags = [
        ("--effective-radius-mm", args.effective_radius_mm.is_some(), "effective_radius_mm in [traces]"),
        ("--force-n", args.force_n.is_some(), "force_n in [[traces.condition]]"),
        ("--speed-mm-s", args.speed_mm_s.is_some(), "speed_mm_s in [[traces.condition]]"),
        ("--humidity-pct", args.humidity_pct.is_some(), "humidity_pct in [[traces.condition]]"),
        ("--specimens", args.specimens.is_some(), "specimens in [traces]"),
        ("--window-s", args.window_s.is_some(), "window_s in [traces]"),
        ("--zero-s", args.zero_s.is_some(), "zero_s in [traces]"),
        ("--step", args.step.is_some(), "step in [[traces.condition]]"),
        ("--patterned", args.patterned, "surface = \"patterned\" in [[traces.condition]]"),
        ("--no-static-peak", args.no_static_peak, "static_peak = false in [traces]"),
        ("--reciprocating", args.reciprocating, "reciprocating = true in [traces]"),
    ];
    if let Some((flag, _, key)) = flags.into_iter().find(|(_, is_given, _)| *is_given) {
        let reason = format!("is a flag for exports: of a calibration [traces] says this, in {}", file.display());
        return Err(Diagnostic::key(flag, reason).expected(format!("{key}, or exports in place of the calibration")));
    }
    let calibration = Calibration::read(&slipgrid_io::disk::disk(), file)?;
    if calibration.traces.is_empty() {
        return Err(Diagnostic::file(file, "has no table [traces]")
            .expected("one, [[trial.traces]] of a trial, or exports instead"));
    }
    Ok(calibration.traces)
}

fn setup(args: &TracesArgs) -> Result<TraceSetup, Diagnostic> {
    let radius_m = args.effective_radius_mm.map(|mm| checked("--effective-radius-mm", mm, LENGTH_MM)).transpose()?;
    Ok(TraceSetup::new(radius_m, args.specimens.unwrap_or(1), !args.no_static_peak))
}

/// Checks that `flag` was `given` two increasing times, in seconds; `None` if it was not given.
fn span_s(flag: &'static str, given: Option<&[f64]>, example: &str) -> Result<Option<[f64; 2]>, Diagnostic> {
    match given {
        None => Ok(None),
        Some(&[from, to]) if from < to => Ok(Some([checked(flag, from, TIME_S)?, checked(flag, to, TIME_S)?])),
        Some(other) => {
            let given: Vec<String> = other.iter().map(f64::to_string).collect();
            Err(Diagnostic::flag(flag, given.join(","), "is no span of time")
                .expected(format!("two increasing times, {example}")))
        }
    }
}

fn condition(args: &TracesArgs) -> Result<TraceCondition, Diagnostic> {
    let needed = |flag: &'static str, value: Option<f64>, quantity: Quantity| match value {
        Some(value) => checked(flag, value, quantity),
        None => Err(Diagnostic::key(flag, "is missing").expected(match flag {
            "--humidity-pct" => "the relative humidity in %; where it was not measured, one number everywhere, as 50",
            _ => "the condition of these exports; a calibration file with [traces] needs no flags",
        })),
    };
    let mut known = std::collections::HashSet::new();
    for file in &args.files {
        if is_calibration(file) {
            return Err(Diagnostic::file(file, "is a calibration file, and other files are given beside it").expected(
                "either a calibration file alone, whose [traces] names its exports, or exports of one condition",
            ));
        }
        if !known.insert(file.canonicalize().unwrap_or_else(|_| file.clone())) {
            return Err(Diagnostic::file(file, "is given twice: one export is one repeat").expected("each export once"));
        }
    }
    Ok(TraceCondition {
        surface: if args.patterned { SurfaceKind::Patterned } else { SurfaceKind::Flat },
        trial: None,
        window_s: span_s("--window-s", args.window_s.as_deref(), "10,40")?.unwrap_or(DEFAULT_WINDOW_S),
        stroke_share: args.reciprocating.then_some(DEFAULT_STROKE_SHARE),
        zero_s: span_s("--zero-s", args.zero_s.as_deref(), "0,2")?,
        force_n: needed("--force-n", args.force_n, FORCE_N)?,
        speed_m_s: needed("--speed-mm-s", args.speed_mm_s, SPEED_MM_S)?,
        humidity: needed("--humidity-pct", args.humidity_pct, HUMIDITY_PCT)?,
        order: None,
        files: args.files.iter().map(|path| Export { path: path.clone(), step: args.step }).collect(),
        excluded: Vec::new(),
    })
}
