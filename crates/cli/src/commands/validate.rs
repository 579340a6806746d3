//! `validate`: measured ratios patterned/flat beside the model's.

use serde::Serialize;

use crate::args::ValidateArgs;
use crate::diagnostic::Diagnostic;
use crate::formats::calibration::Calibration;
use crate::formats::measurements::Measurement;
use crate::report::table::fixed;
use crate::report::{Table, VERSION, json};
use crate::units::{HUMIDITY_PCT, PRESSURE_MPA, SPEED_MM_S};
use crate::{CliError, Console, exit_code};

/// What `validate --json` prints.
#[derive(Clone, Debug, Serialize)]
struct ValidationReport {
    program: &'static str,
    version: &'static str,
    name: String,
    source: String,
    results: Vec<MeasuredRatio>,
}

/// A measured ratio.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
struct MeasuredRatio {
    force_n: f64,
    pressure_mpa: f64,
    speed_mm_s: f64,
    humidity_pct: f64,
    mu_flat: f64,
    mu_patterned: f64,
    ratio: f64,
    ratio_std: f64,
}

/// Reads both tables and reports their ratios.
pub fn run(args: &ValidateArgs, console: &mut Console<'_>) -> Result<u8, CliError> {
    let calibration = Calibration::read(&args.calibration)?;
    if calibration.patterned.is_empty() {
        return Err(Diagnostic {
            key: Some("measurements.patterned".into()),
            ..Diagnostic::file(&args.calibration, "is missing: there is nothing to compare with")
        }
        .into());
    }
    let report = ValidationReport {
        program: "slipgrid",
        version: VERSION,
        name: calibration.name.clone(),
        source: calibration.source.clone(),
        results: measured_ratios(&calibration),
    };
    let text = if args.json { json(&report)? } else { table(&report) };
    console.out.write_all(text.as_bytes())?;
    Ok(exit_code::DONE)
}

/// The ratio at every condition that both tables have, in the order of the flat one.
fn measured_ratios(calibration: &Calibration) -> Vec<MeasuredRatio> {
    let ratio = |flat: &Measurement| {
        let patterned = calibration.patterned.iter().find(|patterned| same_condition(flat, patterned))?;
        let ratio = patterned.mu_dynamic / flat.mu_dynamic;
        // (s_r / r)^2 = (s_p / mu_p)^2 + (s_f / mu_f)^2
        let relative = (patterned.mu_dynamic_std / patterned.mu_dynamic).hypot(flat.mu_dynamic_std / flat.mu_dynamic);
        Some(MeasuredRatio {
            force_n: flat.force_n,
            pressure_mpa: PRESSURE_MPA.from_si(calibration.pressure_pa(flat.force_n)),
            speed_mm_s: SPEED_MM_S.from_si(flat.speed_m_s),
            humidity_pct: HUMIDITY_PCT.from_si(flat.humidity),
            mu_flat: flat.mu_dynamic,
            mu_patterned: patterned.mu_dynamic,
            ratio,
            ratio_std: ratio * relative,
        })
    };
    calibration.flat.iter().filter_map(ratio).collect()
}

fn same_condition(a: &Measurement, b: &Measurement) -> bool {
    let close = |a: f64, b: f64| (a - b).abs() <= 1e-6 * a.abs().max(b.abs());
    close(a.force_n, b.force_n) && close(a.speed_m_s, b.speed_m_s) && close(a.humidity, b.humidity)
}

fn table(report: &ValidationReport) -> String {
    let mut table = Table::new(["F N", "P MPa", "v mm/s", "RH %", "mu flat", "mu patterned", "ratio", "+-"]);
    for row in &report.results {
        table.row([
            row.force_n.to_string(),
            fixed(Some(row.pressure_mpa), 3),
            row.speed_mm_s.to_string(),
            row.humidity_pct.to_string(),
            fixed(Some(row.mu_flat), 3),
            fixed(Some(row.mu_patterned), 3),
            fixed(Some(row.ratio), 3),
            fixed(Some(row.ratio_std), 3),
        ]);
    }
    format!("{} ({})\n\n{table}", report.name, report.source)
}
