//! `traces`: tribometer exports to measurements.

use crate::args::TracesArgs;
use crate::output::{Place, check_folder};
use crate::{CliError, Console, exit_code};
use slipgrid_calibrate::Measurement;
use slipgrid_calibrate::trace::DEFAULT_WINDOW_S;
use slipgrid_formats::Diagnostic;
use slipgrid_formats::calibration::Calibration;
use slipgrid_formats::file_kind::FileKind;
use slipgrid_formats::measurements;
use slipgrid_formats::traces::{ConditionTraces, SurfaceKind, TraceCondition, TraceSetup, analyse_condition, notes};
use slipgrid_report::Outputs;
use slipgrid_report::charts::{RepeatTrace, Series, TribometerChart, tribometer};
use slipgrid_results::fixed;
use slipgrid_results::{Table, VERSION};
use slipgrid_units::{FORCE_N, HUMIDITY_PCT, LENGTH_MM, Quantity, SPEED_MM_S, TIME_S, tidy};

use super::area_law::checked;

/// What is written.
pub const FILES: [&str; 5] = ["flat.csv", "patterned.csv", "traces.csv", "flat-*.svg", "patterned-*.svg"];

/// Reads exports and reports.
pub fn run(args: &TracesArgs, console: &mut Console<'_>) -> Result<u8, CliError> {
    if let Some(folder) = &args.output {
        check_folder(Place::output(folder), &FILES, &args.files)?;
    }
    let conditions = match &args.files[..] {
        [file] if file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml")) => {
            let calibration = Calibration::read(&crate::input::disk(), file)?;
            if calibration.traces.is_empty() {
                return Err(Diagnostic::file(file, "has no table [traces]").expected("one, or exports instead").into());
            }
            calibration.traces
        }
        [folder] if folder.is_dir() => {
            return Err(FileKind::Calibration.refuse_folder(&crate::input::disk(), folder).into());
        }
        _ => vec![analyse_condition(&crate::input::disk(), &setup(args)?, &condition(args)?)?],
    };
    if let Some(folder) = &args.output {
        let outputs = outputs(&conditions)?;
        crate::output::write(&outputs, folder)?;
        console.note(&format!("wrote {} to {}", outputs.names().join(", "), folder.display()));
    }
    console.answer(&summary(&conditions))?;
    Ok(exit_code::DONE)
}

fn setup(args: &TracesArgs) -> Result<TraceSetup, Diagnostic> {
    let window_s = match args.window_s.as_deref() {
        None => DEFAULT_WINDOW_S,
        Some(&[from, to]) if from < to => [checked("--window-s", from, TIME_S)?, checked("--window-s", to, TIME_S)?],
        Some(other) => {
            let given: Vec<String> = other.iter().map(f64::to_string).collect();
            return Err(
                Diagnostic::flag("--window-s", given.join(","), "is no window").expected("two increasing times, 10,40")
            );
        }
    };
    let radius = args.effective_radius_mm;
    Ok(TraceSetup {
        window_s,
        effective_radius_m: radius.map(|mm| checked("--effective-radius-mm", mm, LENGTH_MM)).transpose()?,
        specimens: args.specimens.unwrap_or(1).max(1),
        static_peak: !args.no_static_peak,
    })
}

fn condition(args: &TracesArgs) -> Result<TraceCondition, Diagnostic> {
    let needed = |flag: &'static str, value: Option<f64>, quantity: Quantity| match value {
        Some(value) => checked(flag, value, quantity),
        None => Err(Diagnostic { key: Some(flag.into()), reason: "is missing".into(), ..Diagnostic::default() }
            .expected("the condition of these exports; a calibration file with [traces] needs no flags")),
    };
    let mut known = std::collections::HashSet::new();
    for file in &args.files {
        if !known.insert(file.canonicalize().unwrap_or_else(|_| file.clone())) {
            return Err(Diagnostic::file(file, "is given twice: one export is one repeat").expected("each export once"));
        }
    }
    Ok(TraceCondition {
        surface: if args.patterned { SurfaceKind::Patterned } else { SurfaceKind::Flat },
        force_n: needed("--force-n", args.force_n, FORCE_N)?,
        speed_m_s: needed("--speed-mm-s", args.speed_mm_s, SPEED_MM_S)?,
        humidity: needed("--humidity-pct", args.humidity_pct, HUMIDITY_PCT)?,
        files: args.files.clone(),
    })
}

/// Tables and pictures of all conditions.
pub fn outputs(conditions: &[ConditionTraces]) -> Result<Outputs, CliError> {
    let mut outputs = Outputs::default();
    for kind in SurfaceKind::ALL {
        let of_kind = conditions.iter().filter(|traces| traces.condition.surface == kind);
        let rows: Vec<Measurement> = of_kind.map(ConditionTraces::measurement).collect();
        if !rows.is_empty() {
            let comment = format!(
                "By slipgrid traces {VERSION}: {} samples, mean and standard deviation of repeats",
                kind.name()
            );
            outputs.add(format!("{}.csv", kind.name()), measurements::table(&comment, &rows));
        }
    }
    outputs.add("traces.csv", table(conditions));
    for traces in conditions {
        outputs.add(format!("{}.svg", name(&traces.condition)), picture(traces)?);
    }
    Ok(outputs)
}

/// Surface, force in N, speed in mm/s and humidity in per cent, in words.
fn words(condition: &TraceCondition) -> [String; 4] {
    [
        condition.surface.name().to_owned(),
        condition.force_n.to_string(),
        SPEED_MM_S.from_si(condition.speed_m_s).to_string(),
        HUMIDITY_PCT.from_si(condition.humidity).to_string(),
    ]
}

/// A file name for a condition: `flat-200N-2mm_s-15pct`.
fn name(condition: &TraceCondition) -> String {
    let [surface, force, speed, humidity] = words(condition);
    format!("{surface}-{force}N-{speed}mm_s-{humidity}pct")
}

fn title(condition: &TraceCondition) -> String {
    let [surface, force, speed, humidity] = words(condition);
    format!("{surface} sample, {force} N, {speed} mm/s, {humidity} % humidity")
}

fn picture(traces: &ConditionTraces) -> Result<String, CliError> {
    let points: Vec<Vec<[f64; 2]>> = traces
        .traces
        .iter()
        .map(|trace| trace.findings.time_s.iter().zip(&trace.findings.mu).map(|(&t, &mu)| [t, mu]).collect())
        .collect();
    let repeats: Vec<RepeatTrace<'_>> = traces
        .traces
        .iter()
        .zip(&points)
        .map(|(trace, points)| RepeatTrace {
            series: Series { label: &trace.label, points },
            mu_dynamic: trace.findings.window.mu,
            static_peak: trace.findings.static_peak.map(|peak| [peak.time_s, peak.mu]),
        })
        .collect();
    let window_s = traces.traces.first().map_or(DEFAULT_WINDOW_S, |trace| trace.findings.window_s);
    tribometer(&TribometerChart { title: &title(&traces.condition), window_s, repeats: &repeats })
        .map_err(|error| CliError::Other(error.to_string()))
}

/// One row a repeat.
fn table(conditions: &[ConditionTraces]) -> String {
    let mut text = String::from(
        "surface,force_n,speed_mm_s,humidity_pct,trace,mu_dynamic,mu_dynamic_stderr,drift,drift_stderr,mu_static,\
         mu_static_time_s,stick_slip_amplitude,stick_slip_period_s,stick_slips,normal_force_n,flags\n",
    );
    for traces in conditions {
        let condition = words(&traces.condition);
        for trace in &traces.traces {
            let found = &trace.findings;
            let optional = |value: Option<f64>| value.map_or_else(String::new, |value| tidy(value).to_string());
            let cells = [
                quoted(&trace.label),
                tidy(found.window.mu).to_string(),
                tidy(found.window.stderr).to_string(),
                tidy(found.window.drift).to_string(),
                tidy(found.window.drift_stderr).to_string(),
                optional(found.static_peak.map(|peak| peak.mu)),
                optional(found.static_peak.map(|peak| peak.time_s)),
                optional(found.stick_slip.map(|slip| slip.amplitude)),
                optional(found.stick_slip.map(|slip| slip.period_s)),
                found.stick_slip.map_or_else(String::new, |slip| slip.slips.to_string()),
                tidy(found.normal_force_n).to_string(),
                quoted(&trace.flags.join("; ")),
            ];
            text += &format!("{},{}\n", condition.join(","), cells.join(","));
        }
    }
    text
}

fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "'"))
}

fn summary(conditions: &[ConditionTraces]) -> String {
    let mut text = String::new();
    for traces in conditions {
        text += &format!("{}\n", title(&traces.condition));
        let mut table = Table::new(["trace", "mu", "+-", "drift %", "static peak", "at s", "slip", "period s"]);
        for trace in &traces.traces {
            let found = &trace.findings;
            table.row([
                trace.label.clone(),
                fixed(Some(found.window.mu), 4),
                fixed(Some(found.window.stderr), 4),
                fixed(Some(100.0 * found.window.drift / found.window.mu), 1),
                fixed(found.static_peak.map(|peak| peak.mu), 4),
                fixed(found.static_peak.map(|peak| peak.time_s), 2),
                fixed(found.stick_slip.map(|slip| slip.amplitude), 4),
                fixed(found.stick_slip.map(|slip| slip.period_s), 2),
            ]);
        }
        let mean = &traces.mean;
        table.row([
            format!("mean of {}", mean.count),
            fixed(Some(mean.mu_dynamic.mean), 4),
            fixed(Some(mean.mu_dynamic.std), 4),
            String::new(),
            fixed(mean.mu_static.map(|peak| peak.mean), 4),
            String::new(),
            String::new(),
            String::new(),
        ]);
        text += &format!("{table}\n");
    }
    for note in notes(conditions) {
        text += &format!("- {note}\n");
    }
    text
}
