//! `validate`: measured ratios patterned/flat beside the model's.

mod figures;
mod laws;
mod measured_law;
mod model;
mod published;
mod ratios;
mod report;
mod summary;
mod text;

use slipgrid_pattern::{Pattern, Planform};

use figures::{Figures, area_tables};
use laws::{ScaledLaws, scaled_laws};
use model::{Body, Case, FlatPoint, predict, squares};
use ratios::{MeasuredReport, ModelledRatio, Pair, RatioReport, depth_um, pairs, same_condition};
use report::ValidationReport;
use summary::Summary;

use super::area_law::checked;
use crate::args::ValidateArgs;
use crate::interruption::heed;
use crate::output::{Place, check_folder};
use crate::progress::Progress;
use crate::{CliError, Console, exit_code};
use slipgrid_formats::Diagnostic;
use slipgrid_formats::calibration::Calibration;
use slipgrid_formats::scene::DEFAULT_LAYER;
use slipgrid_report::Outputs;
use slipgrid_results::{VERSION, json, json_and_timings};
use slipgrid_units::{HUMIDITY_PCT, LENGTH_UM, POSITIVE, PRESSURE_MPA, Quantity, SPEED_MM_S};

/// Lengths of the pattern: ten centimetres are more than any specimen.
const PATTERN_UM: Quantity = LENGTH_UM.at_most(1e5);
/// Travel of a run in time: sliding is steady after a few micrometres.
const TRAVEL_UM: Quantity = LENGTH_UM.at_most(100.0);
/// Slope factors: beyond these no surface is meant.
const SLOPE_FACTORS: std::ops::RangeInclusive<f64> = 0.01..=100.0;

/// What is written.
const FILES: [&str; 10] = [
    "report.html",
    "result.json",
    "timings.json",
    "ratios.*",
    "area-law.*",
    "friction.*",
    "interface.*",
    "interface-end.svg",
    "interface-squares.svg",
    "friction-*.svg",
];

/// Reads both tables, models every condition and reports.
pub fn run(args: &ValidateArgs, console: &mut Console<'_>) -> Result<u8, CliError> {
    if let Some(folder) = &args.output {
        check_folder(Place::output(folder), &FILES, std::slice::from_ref(&args.calibration))?;
    }
    let patterns = Patterns::read(args)?;
    let slope_factors = slope_factors(&args.slope_factors)?;
    let calibration = Calibration::read(&crate::input::disk(), &args.calibration)?;
    let pairs = measured(args, &calibration)?;
    let sliding_m = match args.sliding_um {
        0.0 => None,
        sliding_um => Some(checked("--sliding-um", sliding_um, TRAVEL_UM)?),
    };
    let whole = Progress::start("", true);
    let surface = scaled_laws(&args.calibration, &calibration, &slope_factors, console)?;
    let mut report = validate(args, &calibration, &pairs, &patterns, &surface, console)?;
    let mut outputs = Outputs::default();
    if args.output.is_some() {
        let figures = figures(args, &calibration, &pairs, &patterns, &surface, &report, sliding_m);
        if let Some(figures) = figures {
            report.in_time = figures.draw(&mut outputs, console)?;
        }
    }
    report.wall_s = whole.finish();
    if let Some(folder) = &args.output {
        let [result, timings] = json_and_timings(&report)?;
        outputs.add("result.json", result);
        outputs.add("timings.json", timings);
        outputs.add("ratios.csv", text::csv(&report));
        outputs.add("ratios.svg", text::picture(&report)?);
        slipgrid_report::pages::validation(&report, &mut outputs)?;
        crate::output::write(&outputs, folder)?;
        console.note(&format!("wrote {} to {}", outputs.names().join(", "), folder.display()));
    }
    if args.json {
        console.out.write_all(json(&report)?.as_bytes())?;
    } else {
        console.answer(&text::table(&report))?;
    }
    Ok(exit_code::DONE)
}

/// What the pictures show; `None` where nothing was compared.
fn figures<'a>(
    args: &'a ValidateArgs,
    calibration: &'a Calibration,
    pairs: &[Pair],
    patterns: &Patterns,
    surface: &'a ScaledLaws,
    report: &ValidationReport,
    sliding_m: Option<f64>,
) -> Option<Figures<'a>> {
    let first = pairs.first()?;
    let heaviest = pairs
        .iter()
        .filter(|pair| same_condition(&pair.flat, &first.flat))
        .max_by(|a, b| a.flat.force_n.total_cmp(&b.flat.force_n))?;
    let peaks = report.results.iter().flat_map(|row| &row.modelled).map(|modelled| modelled.peak_pressure_mpa);
    Some(Figures {
        path: &args.calibration,
        calibration,
        laws: &surface.laws,
        pattern: patterns.modelled,
        heaviest: flat_point(heaviest, calibration),
        peak_pa: PRESSURE_MPA.to_si(peaks.fold(0.0, f64::max)),
        sliding_m,
        synthetic: surface.synthetic,
    })
}

/// A pair's flat measurement, as the model needs it.
fn flat_point(pair: &Pair, calibration: &Calibration) -> FlatPoint {
    FlatPoint {
        pressure_pa: calibration.pressure_pa(pair.flat.force_n),
        speed_m_s: pair.flat.speed_m_s,
        mu_flat: pair.flat.mu_dynamic,
        mu_flat_std: pair.flat.mu_dynamic_std,
    }
}

/// The pattern at both depths, as grooves.
#[derive(Clone, Copy, Debug)]
struct Patterns {
    modelled: Pattern,
    measured: Pattern,
}

impl Patterns {
    fn read(args: &ValidateArgs) -> Result<Self, Diagnostic> {
        let layer_um = LENGTH_UM.from_si(DEFAULT_LAYER.height_m);
        let depth = |flag, depth_um: f64| {
            let depth_m = checked(flag, depth_um, PATTERN_UM)?;
            if depth_m < DEFAULT_LAYER.height_m {
                Ok(depth_m)
            } else {
                Err(Diagnostic::flag(
                    flag,
                    depth_um.to_string(),
                    format!("leaves nothing of the layer of {layer_um} um"),
                )
                .expected(format!("a depth below {layer_um}")))
            }
        };
        let width_m = checked("--width-um", args.width_um, PATTERN_UM)?;
        let spacing_m = checked("--spacing-um", args.spacing_um, PATTERN_UM)?;
        let grooves = |depth_m| {
            Pattern::new(Planform::Groove, width_m, spacing_m, depth_m)
                .map_err(|error| Diagnostic { reason: error.to_string(), ..Diagnostic::default() })
        };
        Ok(Self {
            modelled: grooves(depth("--depth-um", args.depth_um)?)?,
            measured: grooves(depth("--measured-depth-um", args.measured_depth_um)?)?,
        })
    }

    fn differ(&self) -> bool {
        self.modelled != self.measured
    }
}

/// The factors asked for and 1, increasing.
fn slope_factors(asked: &[f64]) -> Result<Vec<f64>, Diagnostic> {
    let mut factors = vec![1.0];
    for &factor in asked {
        if !SLOPE_FACTORS.contains(&factor) {
            let expected = format!("a factor from {} to {}", SLOPE_FACTORS.start(), SLOPE_FACTORS.end());
            return Err(Diagnostic::flag("--slope-factors", factor.to_string(), "is out of range").expected(expected));
        }
        factors.push(checked("--slope-factors", factor, POSITIVE)?);
    }
    factors.sort_by(f64::total_cmp);
    factors.dedup();
    Ok(factors)
}

/// The measured pairs that are reported.
fn measured(args: &ValidateArgs, calibration: &Calibration) -> Result<Vec<Pair>, Diagnostic> {
    let nothing = |reason: &str| Diagnostic {
        key: Some("measurements.patterned".into()),
        ..Diagnostic::file(&args.calibration, reason)
    };
    if calibration.patterned.is_empty() {
        return Err(nothing("is missing: there is nothing to compare with"));
    }
    let mut pairs = pairs(calibration);
    let Some(first) = pairs.first().copied() else {
        return Err(nothing("has no condition in common with measurements.flat")
            .expected("the same force, speed and humidity in both tables"));
    };
    if !args.all {
        pairs.retain(|pair| same_condition(&pair.flat, &first.flat));
    }
    Ok(pairs)
}

fn validate(
    args: &ValidateArgs,
    calibration: &Calibration,
    pairs: &[Pair],
    patterns: &Patterns,
    surface: &ScaledLaws,
    console: &Console<'_>,
) -> Result<ValidationReport, CliError> {
    let points: Vec<FlatPoint> = pairs.iter().map(|pair| flat_point(pair, calibration)).collect();
    // Every slope, then Amontons-Coulomb, then the surface as given at the measured depth.
    let given = surface.laws.iter().find(|law| law.slope_factor == 1.0);
    let mut cases: Vec<Case<'_>> =
        surface.laws.iter().map(|law| Case { pattern: patterns.modelled, law: law.law.as_ref() }).collect();
    cases.push(Case { pattern: patterns.modelled, law: None });
    let deep = given.filter(|_| patterns.differ());
    cases.extend(deep.map(|law| Case { pattern: patterns.measured, law: law.law.as_ref() }));

    let progress = Progress::start("patterns", console.quiet);
    let body = Body {
        elastic: calibration.elastic,
        modulus_relative_std: calibration.modulus_relative_std(),
        layer: DEFAULT_LAYER,
    };
    let predicted = predict(&args.calibration, body, &cases, &points, &progress);
    progress.finish();
    heed()?;
    let predicted = predicted?;

    let by_measured_law =
        measured_law::ratios(&args.calibration, calibration, body, patterns.modelled, pairs, console)?;
    let slopes = surface.laws.len();
    let results: Vec<RatioReport> = pairs
        .iter()
        .enumerate()
        .map(|(row, pair)| RatioReport {
            measured: MeasuredReport::new(pair, calibration),
            ratio_amontons_coulomb: predicted[slopes][row].outcome.ratio,
            modelled: surface
                .laws
                .iter()
                .zip(&predicted)
                .map(|(law, predicted)| ModelledRatio::new(law, &patterns.modelled, &predicted[row]))
                .collect(),
            measured_law: by_measured_law[row].clone(),
            modelled_at_measured_depth: deep
                .zip(predicted.get(slopes + 1))
                .map(|(law, predicted)| ModelledRatio::new(law, &patterns.measured, &predicted[row])),
        })
        .collect();
    let slope_factors: Vec<f64> = surface.laws.iter().map(|law| law.slope_factor).collect();
    let mut report = ValidationReport {
        program: "slipgrid",
        version: VERSION,
        name: calibration.name.clone(),
        source: calibration.source.clone(),
        synthetic_surface: surface.synthetic,
        model: model_notes(args, pairs, patterns, &surface.notes),
        errors: errors_note(calibration),
        pattern: (&patterns.modelled).into(),
        areal_density_square: slipgrid_units::tidy(squares(&patterns.modelled).areal_density()),
        measured_depth_um: depth_um(&patterns.measured),
        summary: Summary::new(&results, &slope_factors),
        slope_factors,
        statements: Vec::new(),
        published: Vec::new(),
        measured: self::pairs(calibration).iter().map(|pair| MeasuredReport::new(pair, calibration)).collect(),
        area_laws: area_tables(&surface.laws),
        in_time: None,
        wall_s: 0.0,
        threads: console.threads,
        results,
    };
    report.statements = text::statements(&report);
    report.published = published::published(&report);
    Ok(report)
}

/// What stands after +- of modelled values, and what does not.
fn errors_note(calibration: &Calibration) -> String {
    let modulus = match calibration.modulus_relative_std() {
        Some(std) => format!("Young's modulus, known to {:.0} %, and ", 100.0 * std),
        None => "(Young's modulus is taken as exact: the calibration names no error) ".to_owned(),
    };
    format!(
        "+- of modelled values: one standard deviation of {modulus}measured flat friction, to first order. Not in it: the slope of \
         the surface, of which others stand beside it, and how far the model itself is off"
    )
}

/// What was modelled and how.
fn model_notes(args: &ValidateArgs, pairs: &[Pair], patterns: &Patterns, surface: &[String]) -> Vec<String> {
    let um = |length_m: f64| LENGTH_UM.from_si(length_m);
    let pattern = &patterns.modelled;
    let mut notes = Vec::new();
    if let Some(first) = pairs.first().filter(|_| !args.all) {
        notes.push(format!(
            "measured at {} mm/s and {} % humidity, the condition of the table's first row; --all compares every one",
            SPEED_MM_S.from_si(first.flat.speed_m_s),
            HUMIDITY_PCT.from_si(first.flat.humidity),
        ));
    }
    notes.push(format!(
        "grooves {} um wide, {} um apart and {} um deep; the measured cavities are {} um deep",
        um(pattern.width_m()),
        um(pattern.spacing_m()),
        depth_um(pattern),
        depth_um(&patterns.measured),
    ));
    notes.push(format!(
        "steady sliding of one period in the vertical plane, a layer of {} um in blocks of {} um",
        um(DEFAULT_LAYER.height_m),
        um(DEFAULT_LAYER.block_m),
    ));
    notes.push(
        "at each measurement mu_d = mu_flat / f(P): a flat cell slides at mu_d f(P), so that the model's flat surface has \
         the measured friction; the patterned measurements enter nowhere"
            .to_owned(),
    );
    notes.push(
        "squares of the same lengths by the same in space, nu = 1/4; their strip estimate, 1 - (width/pitch)(1 - ratio of \
         the groove), counts strips between rows of cavities as flat"
            .to_owned(),
    );
    notes.extend(surface.iter().cloned());
    notes.push("not modelled: recast rims, plasticity, viscoelasticity, heating, wear, menisci".to_owned());
    notes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_surface_as_given_is_always_among_the_factors() {
        assert_eq!(slope_factors(&[2.0, 0.5, 2.0]).unwrap(), [0.5, 1.0, 2.0]);
        assert_eq!(slope_factors(&[]).unwrap(), [1.0]);
        for bad in [0.0, -1.0, f64::NAN, 1e3] {
            assert!(slope_factors(&[1.0, bad]).is_err(), "{bad}");
        }
    }
}
