//! Page of a calibration: fitted coefficients, remaining uncertainty, and suggested measurements.

use slipgrid_base::statistics::median;
use slipgrid_base::units::{HUMIDITY_PCT, MODULUS_GPA, PRESSURE_MPA, SPEED_MM_S, counted};
use slipgrid_design::results::VERSION;
use slipgrid_infer::calibrate::{
    AreaLawOrigin, CalibrationOutcome, Coefficients, FittedPair, Measurement, Parameter, Surface,
};

use super::page::{Page, number, percent, plain, sentence, with_error};
use super::{background, trials};
use crate::Outputs;
use crate::calibration::{Fitted, parameter_value, static_table, static_words};
use crate::charts::extremes;
use crate::friction_sheet::FrictionSheet;
use crate::traces::LOOPS;

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

/// Makes the page of a fitted calibration, with the `sheet` of the friction measurements and the pictures in `outputs`.
pub fn calibration(fitted: &Fitted, sheet: &FrictionSheet, outputs: &Outputs) -> String {
    let Fitted { calibration, outcome, ledger, .. } = fitted;
    let mut page = Page::default();
    let title = format!("{}: calibration", calibration.stated.name);
    page.title(&title);
    page.beside_picture(
        |page| {
            verdict(page, outcome);
            found(page, fitted);
            caveat(page, outcome);
            page.terms(&TERMS);
        },
        |page| {
            page.picture_of_both(
                outputs,
                "flat-friction.svg",
                fitted.flat_friction("").ok(),
                "Friction of flat samples: measured with its standard deviation, and by the fitted model. Marks of one pressure stand \
                 side by side",
            );
            page.named_list("What to measure next", &next(fitted));
            page.named_list("What the data do not determine", &open(fitted));
        },
    );
    page.part("The fit", |page| fit(page, fitted, outputs));
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
        page.fold("Notes", |page| page.sentences(&outcome.material.provenance.notes));
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
    let relative_error = |pair: &FittedPair| Some(pair.dynamic_std_error? / pair.dynamic_mean);
    let mut errors: Vec<f64> = fit.pairs.iter().filter_map(relative_error).collect();
    let words = median(&mut errors).filter(|_| fit.pairs.len() > 1).map_or_else(String::new, |error| {
        let error = percent(error, 1);
        format!(" Each is known to {error} % in the median, errors of Young's modulus and of the area law included.")
    });
    let lead = format!("Local dynamic friction is {known}: {} on flat samples.{words}", counted(count, "measurement"));
    page.marked("chance", &lead);
    let off =
        outcome.measurements.iter().zip(&fit.predictions).map(|(of, at)| (at.residual / of.mu_dynamic_std).powi(2));
    let off = number((off.sum::<f64>() / count.max(1) as f64).sqrt(), 1);
    if fit.degrees_of_freedom == 0 {
        page.paragraph("As many numbers were fitted as were measured: the model follows every measurement, and none is left to check it by.");
    } else if fit.is_poor() {
        page.marked("verdict missed", &format!(
            "The model does not describe these measurements: it is off by {off} of their standard deviations (root mean square). Fit coefficients per condition."
        ));
    } else {
        let words =
            format!("The model is off the measurements by {off} of their standard deviations (root mean square).");
        page.marked("verdict", &words);
    }
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

fn found(page: &mut Page, fitted: &Fitted) {
    let Fitted { task, outcome, .. } = fitted;
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
    let [low, high] = extremes(outcome.measurements.iter().map(|of| fitted.pressure_mpa(of)));
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
fn open(fitted: &Fitted) -> Vec<String> {
    let Fitted { task, outcome, .. } = fitted;
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
    let value = |of: &Parameter, end: Option<f64>| {
        let unit = if of.name.ends_with("_pa") { " MPa" } else { "" };
        parameter_value(of, end) + unit
    };
    all.extend(fit.parameters.iter().filter_map(|parameter| {
        let ends = match parameter.interval {
            [Some(_), Some(_)] if parameter.std_error.is_finite() => return None,
            [low @ Some(_), None] => format!("above {}", value(parameter, low)),
            [None, high @ Some(_)] => format!("below {}", value(parameter, high)),
            _ => "anywhere within its bounds".to_owned(),
        };
        let bound =
            if parameter.at_bound { "; the fit ended at a bound, and the data ask for a value beyond it" } else { "" };
        Some(format!("{}: it lies {ends} (95 %){bound}.", fitted.in_words(&parameter.name)))
    }));
    if !fit.settled {
        all.push("The coefficients themselves: they still changed when the fit ended.".to_owned());
    }
    all
}

/// Suggests further measurements, the most important first.
fn next(fitted: &Fitted) -> Vec<String> {
    let Fitted { task, outcome, ledger, .. } = fitted;
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
    let rows = outcome.measurements.iter().zip(fitted.pairs());
    let rows = rows.filter_map(|(of, pair)| Some((of, measured_error(pair)?)));
    if let Some((of, error)) = rows.max_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, error)| *error > LOOSE_FRICTION) {
        all.push(format!(
            "Repeats on flat samples at {}: friction itself is known to {} % there.",
            condition(fitted, of),
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
fn condition(fitted: &Fitted, of: &Measurement) -> String {
    format!(
        "{} MPa, {} mm/s and {} % humidity",
        number(fitted.pressure_mpa(of), 2),
        plain(SPEED_MM_S.from_si(of.speed_m_s)),
        plain(HUMIDITY_PCT.from_si(of.humidity))
    )
}

/// Adds the content written by `add`, folded under `name` if `is_long`.
fn folded(page: &mut Page, is_long: bool, name: &str, add: impl FnOnce(&mut Page)) {
    if is_long { page.fold(name, add) } else { add(page) }
}

fn fit(page: &mut Page, fitted: &Fitted, outputs: &Outputs) {
    let is_long = fitted.task.coefficients == Coefficients::PerCondition;
    folded(page, is_long, "Every measurement with its coefficients", |page| {
        page.table(
            "Measured friction of flat samples +- one standard deviation, the local coefficients mu_d and mu_s +- one standard error, and the \
             difference of the fitted model; all dimensionless. A static coefficient without an error is assumed.",
            &fitted.flat_samples(),
        );
    });
    let peaks = fitted.static_rows();
    if let Some(words) = static_words(&peaks) {
        page.paragraph(&sentence(&words));
        page.table(
            "Static friction of flat samples, dimensionless: measured +- one standard deviation, and that of the model in the last run in time \
             of the fit; a dash is a peak that is not fitted.",
            &static_table(&peaks),
        );
    }
    folded(page, fitted.outcome.fit.parameters.len() > FEW, "Every fitted number with its interval", |page| {
        page.table(
            &format!(
                "Fitted numbers with their 95 % intervals by profile likelihood, {}. A dash: the data do not end the interval.",
                fitted.which_errors()
            ),
            &fitted.parameter_table(),
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
