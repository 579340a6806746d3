//! Page of a calibration: fitted coefficients, remaining uncertainty, and suggested measurements.

use slipgrid_base::statistics::median;
use slipgrid_base::units::{HUMIDITY_PCT, MODULUS_GPA, PRESSURE_MPA, SPEED_MM_S};
use slipgrid_design::results::VERSION;
use slipgrid_infer::calibrate::{
    AreaLawOrigin, CalibrationOutcome, CalibrationTask, Coefficients, FittedPair, Measurement, Parameter, Surface,
};
use slipgrid_io::formats::calibration::Calibration;

use super::page::{Page, number, percent, plain, sentence, with_error};
use super::{background, trials};
use crate::Outputs;
use crate::calibration::{
    flat_friction, flat_samples, in_words, pair_of, parameter_table, static_rows, static_table, static_words,
    which_errors,
};
use crate::charts::extremes;
use crate::friction_sheet::FrictionSheet;
use crate::traces::LOOPS;
use crate::trials::TrialsReport;

/// Relative error of Young's modulus above which the page suggests a measurement.
const LOOSE_MODULUS: f64 = 0.1;
/// Relative error of a friction coefficient above which the page suggests a measurement.
const LOOSE_FRICTION: f64 = 0.02;
/// Maximum number of fitted parameters whose table is not folded.
const FEW: usize = 3;

const TERMS: [(&str, &str); 6] = [
    ("mu", "Dynamic coefficient of friction: friction force over normal force while sliding."),
    (
        "local coefficient",
        "Friction of one block of the face over its own normal force: what is fitted. The sample's friction follows from all blocks.",
    ),
    ("static, dynamic", "The local coefficient at rest and in sliding."),
    (
        "area law",
        "The factor f by which local friction falls where local pressure is high, as real contact area grows less than pressure.",
    ),
    ("nominal pressure", "Normal force over the whole face of the specimen, cavities included."),
    (
        "95 % by profile",
        "Values that fit the data nearly as well as the best: chi-square rises by less than 3.84, all other numbers fitted anew.",
    ),
];

/// Calibration with the task and the outcome of the fit, for a page.
#[derive(Clone, Copy, Debug)]
pub struct Fitted<'a> {
    /// The calibration as read.
    pub calibration: &'a Calibration,
    /// Task of the fit.
    pub task: &'a CalibrationTask,
    /// Outcome of the fit.
    pub outcome: &'a CalibrationOutcome,
    /// Ledger of trials, if a trial was measured.
    pub ledger: Option<&'a TrialsReport>,
    /// Sheet of the friction measurements.
    pub sheet: &'a FrictionSheet,
}

/// Makes the page of a calibration, with the pictures in `outputs`.
pub fn calibration(fitted: Fitted<'_>, outputs: &Outputs) -> String {
    let Fitted { calibration, task, outcome, ledger, sheet } = fitted;
    let mut page = Page::default();
    let title = format!("{}: calibration", calibration.stated.name);
    page.title(&title);
    page.beside_picture(
        |page| {
            verdict(page, outcome);
            found(page, task, outcome);
            caveat(page, outcome);
            page.terms(&TERMS);
        },
        |page| {
            page.picture_of_both(
                outputs,
                "flat-friction.svg",
                flat_friction("", task, outcome).ok(),
                "Friction of flat samples: measured with its standard deviation, and by the fitted model. Marks of one pressure stand \
                 side by side",
            );
            page.named_list("What to measure next", &next(&fitted));
            page.named_list("What the data do not determine", &open(task, outcome));
        },
    );
    page.part("The fit", |page| fit(page, task, outcome, outputs));
    page.part("Contact and the area law", |page| {
        page.picture_of(outputs, "area-law.svg", "Real contact area and the factor f against pressure. Edges of cavities see several times the highest nominal pressure");
        if let Some(law) = &outcome.surface.law {
            page.fold("The factors", |page| background::area_law(page, law));
        }
    });
    page.part("Trials", |page| match ledger {
        Some(ledger) => trials::part(page, ledger, outputs),
        None => page.paragraph("No patterned sample was measured: it is not known how far the model is off for one."),
    });
    page.part("What was measured", |page| traces(page, outputs));
    trials::statements(&mut page, sheet);
    page.part("How every value was obtained", |page| {
        page.paragraph(&format!("Source: {}.", calibration.stated.source));
        page.fold("Notes", |page| {
            page.sentences(&outcome.material.provenance.notes)
        });
    });
    page.finish(&title, VERSION)
}

/// Adds the fitted coefficients and the quality of the fit.
fn verdict(page: &mut Page, outcome: &CalibrationOutcome) {
    let fit = &outcome.fit;
    let count = outcome.measurements.len();
    let means = || fit.pairs.iter().map(|pair| pair.dynamic_mean);
    let [low, high] = extremes(means());
    let known = match &fit.pairs[..] {
        [pair] => with_error(pair.dynamic_mean, pair.dynamic_std_error, 4),
        _ => format!("{} to {}", number(low, 3), number(high, 3)),
    };
    let mut errors: Vec<f64> = fit.pairs.iter().filter_map(relative_error).collect();
    let words = if fit.pairs.len() > 1 {
        median(&mut errors).map_or_else(String::new, |error| {
            format!(
                " Each is known to {} % in the median, errors of Young's modulus and of the area law included.",
                percent(error, 1)
            )
        })
    } else {
        String::new()
    };
    page.lead(&format!("Local dynamic friction is {known}: {count} measurements on flat samples.{words}"));
    let off =
        outcome.measurements.iter().zip(&fit.predictions).map(|(of, at)| (at.residual / of.mu_dynamic_std).powi(2));
    let off = (off.sum::<f64>() / count.max(1) as f64).sqrt();
    if fit.degrees_of_freedom == 0 {
        page.paragraph("As many numbers were fitted as were measured: the model follows every measurement, and none is left to check it by.");
    } else if fit.is_poor() {
        page.marked("verdict missed", &format!(
            "The model does not describe these measurements: it is off by {} of their standard deviations (root mean square). Fit coefficients per condition.",
            number(off, 1)
        ));
    } else {
        page.marked(
            "verdict",
            &format!(
                "The model is off the measurements by {} of their standard deviations (root mean square).",
                number(off, 1)
            ),
        );
    }
}

/// Relative standard error of the dynamic coefficient of a fitted pair of local coefficients; `None` if unknown.
fn relative_error(pair: &FittedPair) -> Option<f64> {
    Some(pair.dynamic_std_error? / pair.dynamic_mean)
}

/// Relative standard error of the dynamic coefficient of a pair due to measured flat friction alone, which repeated
/// measurements would reduce; `None` if unknown.
fn measured_error(pair: &FittedPair) -> Option<f64> {
    Some(pair.dynamic_std_error_given_law.or(pair.dynamic_std_error)? / pair.dynamic_mean)
}

/// Whether the static coefficient mu_s is assumed, not fitted, for some measurement.
fn assumes_static(outcome: &CalibrationOutcome) -> bool {
    outcome.fit.pairs.iter().any(|pair| pair.static_std_error.is_none())
}

fn found(page: &mut Page, task: &CalibrationTask, outcome: &CalibrationOutcome) {
    let (fit, surface) = (&outcome.fit, &outcome.surface);
    let mut rows: Vec<(&str, String)> = Vec::new();
    let ends = |of: fn(&FittedPair) -> f64| {
        let [low, high] = extremes(fit.pairs.iter().map(of));
        format!("{} to {} ({} pairs)", number(low, 3), number(high, 3), fit.pairs.len())
    };
    match &fit.pairs[..] {
        [pair] => {
            rows.push(("dynamic coefficient", with_error(pair.dynamic_mean, pair.dynamic_std_error, 4)));
            rows.push(("static coefficient", with_error(pair.static_mean, pair.static_std_error, 4)));
        }
        _ => {
            rows.push(("dynamic coefficients", ends(|pair| pair.dynamic_mean)));
            rows.push(("static coefficients", ends(|pair| pair.static_mean)));
        }
    }
    if assumes_static(outcome) {
        rows.push((
            "static over dynamic",
            format!("{}, assumed where no static peak was measured", number(task.static_over_dynamic, 3)),
        ));
    }
    let modulus = MODULUS_GPA.from_si(task.elastic.youngs_modulus_pa());
    let std = task.youngs_modulus_std_pa.map(|pa| MODULUS_GPA.from_si(pa));
    rows.push((
        "Young's modulus, as given",
        format!("{} GPa", std.map_or_else(|| plain(modulus), |std| format!("{} ± {}", plain(modulus), plain(std)))),
    ));
    let law = match surface.origin {
        None => "none: friction is proportional to load".to_owned(),
        Some(AreaLawOrigin::Map) if surface.synthetic => "from a synthetic altitude map".to_owned(),
        Some(AreaLawOrigin::Map) => "from the measured altitude map".to_owned(),
        Some(AreaLawOrigin::Persson) => "by theory, from a given rms slope".to_owned(),
        Some(AreaLawOrigin::Fit) => "its pressure scale is fitted to flat friction".to_owned(),
        Some(AreaLawOrigin::Measured) => "measured flat friction itself".to_owned(),
    };
    rows.push(("area law", law));
    rows.extend(surface.rms_slope.map(|slope| ("rms slope of the surface", number(slope, 4))));
    let [low, high] = extremes(outcome.measurements.iter().map(|of| PRESSURE_MPA.from_si(task.pressure_pa(of))));
    rows.push(("nominal pressures measured", format!("{} to {} MPa", number(low, 2), number(high, 2))));
    if let (Some(law), true) = (&surface.law, high.is_finite()) {
        rows.push(("f at the highest of them", number(law.factor(PRESSURE_MPA.to_si(high)), 3)));
    }
    page.facts("What was fitted, and what it rests on", &rows);
}

/// Adds all warnings, the most important first.
fn caveat(page: &mut Page, outcome: &CalibrationOutcome) {
    let mut all: Vec<String> = Vec::new();
    if outcome.surface.synthetic {
        all.push("The area law rests on a synthetic surface, not on a measured one.".to_owned());
    }
    all.extend(outcome.material.provenance.warnings.iter().map(|doubtful| format!("Doubtful: {doubtful}.")));
    page.doubts(&all);
}

/// Lists quantities that the measurements do not determine.
fn open(task: &CalibrationTask, outcome: &CalibrationOutcome) -> Vec<String> {
    let fit = &outcome.fit;
    let mut all = Vec::new();
    if assumes_static(outcome) {
        all.push(format!(
            "The static coefficient: the mean of sliding friction says nothing of it. {} times the dynamic one is assumed.",
            number(task.static_over_dynamic, 3)
        ));
    }
    all.push(format!(
        "The scatter of local coefficients from block to block: {} % is assumed, as no mean of friction shows it.",
        percent(task.relative_std, 1)
    ));
    match (&task.surface, outcome.surface.origin) {
        (Surface::None, _) => all.push("How friction falls with local pressure: no surface is given, and friction is taken as proportional to load.".to_owned()),
        (_, Some(AreaLawOrigin::Persson)) => all.push("The area law: it follows by theory from one rms slope, which is taken as given.".to_owned()),
        _ => {}
    }
    if task.youngs_modulus_std_pa.is_none() {
        all.push("How well Young's modulus is known: no error is given, and none is in any prediction.".to_owned());
    }
    all.extend(fit.parameters.iter().filter_map(|parameter| {
        let ends = match parameter.interval {
            [Some(_), Some(_)] if parameter.std_error.is_finite() => return None,
            [Some(low), None] => format!("above {}", value(parameter, low)),
            [None, Some(high)] => format!("below {}", value(parameter, high)),
            _ => "anywhere within its bounds".to_owned(),
        };
        let bound =
            if parameter.at_bound { "; the fit ended at a bound, and the data ask for a value beyond it" } else { "" };
        Some(format!("{}: it lies {ends} (95 %){bound}.", in_words(outcome, &parameter.name)))
    }));
    if !fit.settled {
        all.push("The coefficients themselves: they still changed when the fit ended.".to_owned());
    }
    all
}

/// Formats a parameter's value in its displayed unit.
fn value(parameter: &Parameter, value: f64) -> String {
    if parameter.name.ends_with("_pa") {
        format!("{} MPa", number(PRESSURE_MPA.from_si(value), 3))
    } else {
        number(value, 4)
    }
}

/// Suggests further measurements, the most important first.
fn next(fitted: &Fitted<'_>) -> Vec<String> {
    let Fitted { task, outcome, ledger, .. } = *fitted;
    let mut all = Vec::new();
    let is_measured = outcome.surface.origin == Some(AreaLawOrigin::Map) && !outcome.surface.synthetic;
    if !is_measured && outcome.surface.origin != Some(AreaLawOrigin::Measured) {
        all.push("An altitude map of a flat sample: the area law decides what a pattern does, and it rests on no measured surface.".to_owned());
    }
    match task.modulus_relative_std() {
        None => all.push("Young's modulus with its standard deviation: every prediction depends on it.".to_owned()),
        Some(std) if std > LOOSE_MODULUS => {
            all.push(format!("Young's modulus: it is known to no better than {} %.", percent(std, 0)));
        }
        Some(_) => {}
    }
    if ledger.is_none() {
        all.push("A trial: one sample that is cut and measured says how far the model is off.".to_owned());
    }
    let rows = outcome
        .measurements
        .iter()
        .enumerate()
        .filter_map(|(row, of)| Some((of, measured_error(pair_of(outcome, row)?)?)));
    if let Some((of, error)) = rows.max_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, error)| *error > LOOSE_FRICTION) {
        all.push(format!(
            "Repeats on flat samples at {}: friction itself is known to {} % there.",
            condition(task, of),
            percent(error, 1)
        ));
    }
    if assumes_static(outcome) {
        all.push("The peak of friction at the onset of sliding, if static friction is wanted.".to_owned());
    }
    let [low, high] = extremes(outcome.measurements.iter().map(|of| of.force_n));
    if low == high {
        all.push("Flat samples at other pressures: one alone does not say how friction goes with load.".to_owned());
    }
    all
}

/// States the nominal pressure, speed and humidity of a measurement.
fn condition(task: &CalibrationTask, of: &Measurement) -> String {
    format!(
        "{} MPa, {} mm/s and {} % humidity",
        number(PRESSURE_MPA.from_si(task.pressure_pa(of)), 2),
        plain(SPEED_MM_S.from_si(of.speed_m_s)),
        plain(HUMIDITY_PCT.from_si(of.humidity))
    )
}

/// Adds the content written by `add`, folded under `name` if `is_long`.
fn folded(page: &mut Page, is_long: bool, name: &str, add: impl FnOnce(&mut Page)) {
    if is_long { page.fold(name, add) } else { add(page) }
}

fn fit(page: &mut Page, task: &CalibrationTask, outcome: &CalibrationOutcome, outputs: &Outputs) {
    let is_long = task.coefficients == Coefficients::PerCondition;
    folded(page, is_long, "Every measurement with its coefficients", |page| {
        page.table(
            "Measured friction of flat samples +- one standard deviation, the local coefficients mu_d and mu_s +- one standard error, and the \
             difference of the fitted model; all dimensionless. A static coefficient without an error is assumed.",
            &flat_samples(task, outcome),
        );
    });
    let peaks = static_rows(task, outcome);
    if let Some(words) = static_words(&peaks) {
        page.paragraph(&sentence(&words));
        page.table(
            "Static friction of flat samples, dimensionless: measured +- one standard deviation, and that of the model in the last run in time \
             of the fit; a dash is a peak that is not fitted.",
            &static_table(&peaks),
        );
    }
    folded(page, outcome.fit.parameters.len() > FEW, "Every fitted number with its interval", |page| {
        page.table(
            &format!(
                "Fitted numbers with their 95 % intervals by profile likelihood, {}. A dash: the data do not end the interval.",
                which_errors(outcome)
            ),
            &parameter_table(outcome),
        );
    });
    page.fold("What the model leaves of each measurement", |page| {
        page.picture_of(
            outputs,
            "residuals.svg",
            "Model minus measured dynamic friction of flat samples, with the measured standard deviation",
        );
    });
}

/// Adds the pictures of tribometer traces, in a collapsed section.
fn traces(page: &mut Page, outputs: &Outputs) {
    let names = outputs.names().into_iter().filter(|name| name.ends_with("pct.svg"));
    let captioned = names.map(|name| {
        let shown = if name.contains(LOOPS) {
            "The last loops of friction against position, as recorded"
        } else {
            "Repeats against time, with what was read from them"
        };
        (name, format!("{shown} ({})", name.trim_end_matches(".svg")))
    });
    page.pictures("Traces of the tribometer", outputs, captioned);
}
