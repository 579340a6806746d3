//! Page of a ledger of trials: predictions before the samples were cut, measurements, and remaining unknowns.

use std::iter::once;

use slipgrid_design::results::{Table, believed, believed_interval};

use super::page::{Page, number, percent, sentence};
use crate::Outputs;
use crate::charts::left_out;
use crate::friction_sheet::{FRICTION_WORDS, FrictionSheet};
use crate::literature;
use crate::trials::{Coverage, DiscrepancyEffect, PredictedReport, TrialsReport};

/// Minimum ratio of posterior to prior standard deviation at which an effect counts as unknown.
const UNKNOWN: f64 = 0.9;
/// Minimum number of measured ratios for which the share within an interval is meaningful.
const ENOUGH: usize = 4;
/// Predictions count as too narrow if less than this share of measured ratios lies within their 95 % intervals.
const TOO_FEW: f64 = 0.8;
/// A measured ratio counts as surprising if it deviates from the prediction by at least this many standard deviations.
const SURPRISING: f64 = 2.0;

/// Definition of the modelled ratio of a ledger, and difference from the ratio in the report of a design.
const MODELLED: &str = "The modelled ratio is that of the texture as measured, in steady sliding, on its specimen or endless on a sector of a disc. The error of its \
    blocks is taken off where it is known. A design's report has the ratio of the confirming run of the whole specimen. The two may differ \
    by a hundredth.";

const TERMS: [(&str, &str); 7] = [
    ("trial", "A sample that was cut and measured to learn how far the model is off."),
    (
        "ratio",
        "Dynamic friction of the patterned surface over that of the flat one, both at the same nominal pressure.",
    ),
    ("modelled", "The ratio of the physical model alone, without anything learned from trials."),
    (
        "predicted before",
        "The modelled ratio with what the trials before this one say that the model lacks: median and interval.",
    ),
    (
        "surprise",
        "Number of standard deviations by which a normal value as improbable as the measured ratio lies off its prediction.",
    ),
    ("discrepancy", "Logarithm of the measured over the modelled ratio: what the model lacks."),
    ("form", "How the discrepancy grows with the texture: with its areal density, the length of its edges, its depth."),
];

/// Makes the page of the ledger `report`, with the `sheet` of the friction measurements and the pictures in `outputs`.
pub fn trials(report: &TrialsReport, sheet: &FrictionSheet, outputs: &Outputs) -> String {
    let mut page = Page::default();
    let title = format!("{}: trials", report.name);
    page.title(&title);
    page.beside_picture(
        |page| {
            page.doubts(&report.warnings.iter().map(|doubtful| format!("doubtful: {doubtful}")).collect::<Vec<_>>());
            verdict(page, report);
            page.named_list("What to measure next", &next(report));
            page.terms(&TERMS);
        },
        |page| picture(page, outputs),
    );
    details(&mut page, report);
    published(&mut page, report);
    statements(&mut page, sheet);
    page.finish(&title, &report.made_by.version)
}

/// Adds the ledger `report` as a part of another page.
pub(super) fn part(page: &mut Page, report: &TrialsReport, outputs: &Outputs) {
    verdict(page, report);
    picture(page, outputs);
    page.named_list("Which trial would tell most", &next(report));
    details(page, report);
}

/// Adds the `sheet` of the friction measurements, folded.
pub(super) fn statements(page: &mut Page, sheet: &FrictionSheet) {
    page.part("Statements for a publication", |page| {
        page.fold("Sheet of the friction measurements, with the items of ASTM G115", |page| {
            sheet.items.iter().for_each(|(title, items)| page.table(title, items));
            page.table("Textured samples", &sheet.textures);
            page.table(FRICTION_WORDS, &sheet.friction);
        });
    });
}

fn picture(page: &mut Page, outputs: &Outputs) {
    page.picture_of(
        outputs,
        "trials.svg",
        "Above: every measured ratio (squares, a colour a trial) beside the prediction by the trials before it, by its number in the ledger. Grey \
         bars: 95 %, cut off at the frame. Below: measured ratios against the texture and the pressure",
    );
}

/// Adds a summary of the trials in a few sentences.
fn verdict(page: &mut Page, report: &TrialsReport) {
    let Some(before) = report.coverage.first().filter(|_| !report.trials.is_empty()) else {
        page.marked("chance", "No trial was measured: what the model lacks is as wide as what is believed before any.");
        return;
    };
    page.marked("chance", &headline(before));
    if let Some(effect) = report.effects.first() {
        // The interval is symmetric in the logarithm of the ratio.
        let times = |deviations: f64| number((effect.value + deviations * effect.std).exp(), 3);
        let [low, middle, high] = [-2.0, 0.0, 2.0].map(times);
        page.paragraph(&format!(
            "Samples have {middle} times the modelled ratio ({low} to {high} with two standard deviations). This holds {}.",
            effect.of.trim_start_matches("discrepancy ")
        ));
    }
    page.paragraph(&sentence(&report.form_in_words()));
    let predicted = report.rows().into_iter().filter(|(_, at)| at.before.known > 0);
    let largest = predicted.max_by(|a, b| a.1.before.surprise.abs().total_cmp(&b.1.before.surprise.abs()));
    if let Some((trial, at)) = largest.filter(|(_, at)| at.before.surprise.abs() >= SURPRISING) {
        page.marked(
            "warning",
            &format!(
                "The largest surprise: {} at {} MPa, {} measured where {} was predicted ({} standard deviations).",
                trial.name,
                number(at.pressure_mpa, 2),
                number(at.measured, 3),
                number(at.before.ratio, 3),
                number(at.before.surprise, 1)
            ),
        );
    }
}

/// States how many measured ratios lay within their 95 % intervals, of the ratios that were predicted from earlier
/// trials.
fn headline(before: &Coverage) -> String {
    let first = match before.without_any {
        0 => String::new(),
        1 => " The first sample's one ratio is not counted, because no trial before it says anything of it.".to_owned(),
        many => format!(
            " The first sample's {many} ratios are not counted, because no trial before it says anything of them."
        ),
    };
    match before.ratios {
        0 => format!("One sample was measured: nothing was predicted by a trial yet.{first}"),
        ratios => format!(
            "{} of {ratios} measured ratios lay within what the trials before predicted of 95 % of samples.{first}",
            before.within_95
        ),
    }
}

/// Suggests the next measurements: pending samples, then measurements for each quantity that the trials leave unknown.
fn next(report: &TrialsReport) -> Vec<String> {
    let mut all = Vec::new();
    if !report.pending.is_empty() {
        all.push(format!("What was cut and is not measured yet: {}.", report.pending.join(", ")));
    }
    if report.trials.is_empty() {
        all.push(
            "A first trial: any texture of the kind that is wanted. slipgrid next says which is likeliest on target."
                .to_owned(),
        );
        return all;
    }
    if report.identified.is_none() {
        all.push("A texture of another areal density, edge length and depth than those below: it would tell the forms apart.".to_owned());
    }
    let is_narrow =
        |before: &&Coverage| before.ratios >= ENOUGH && (before.within_95 as f64) < TOO_FEW * before.ratios as f64;
    if report.coverage.first().filter(is_narrow).is_some() {
        all.push(
            "A repeat of a texture: predictions were too narrow, and only a repeat tells the scatter of samples from a wrong form."
                .to_owned(),
        );
    }
    let unknown = |effect: &&DiscrepancyEffect| effect.std >= UNKNOWN * effect.prior_std;
    let names: Vec<&str> = report.effects.iter().skip(1).filter(unknown).map(|effect| effect.of.as_str()).collect();
    if !names.is_empty() {
        all.push(format!(
            "A sample at other conditions: nothing is known of the effect of {} but what is believed before any trial.",
            names.join(" and of ")
        ));
    }
    if all.is_empty() {
        all.push(
            "The texture that slipgrid next names for your target: its chance there says how much is still open."
                .to_owned(),
        );
    }
    all
}

/// Adds a picture and a table of published ratios, for comparison with the measured ratios.
fn published(page: &mut Page, report: &TrialsReport) {
    let Ok(svg) = literature::picture(report) else { return };
    page.part("What others measured", |page| {
        page.picture(&svg, "Measured ratios of the trials beside published ones, a column a source");
        let sources: Vec<_> = literature::sources().into_iter().zip(1_usize..).collect();
        let mut table = Table::of(&sources);
        table.column("number", |(_, at)| at.to_string());
        table.column("source", |((source, ..), _)| source.clone());
        table.column("reference", |((_, reference, _), _)| reference.clone());
        table.column("ratios", |((.., ratios), _)| {
            ratios.iter().map(|ratio| number(*ratio, 2)).collect::<Vec<_>>().join(", ")
        });
        page.table(
            "Dry polymers and rubbers with numbers. Only the first has a flat face with known dimensions of the texture; the others slid on balls or do not give them.",
            &table.table(),
        );
    });
}

fn details(page: &mut Page, report: &TrialsReport) {
    let rows = report.rows();
    page.part("The ledger", |page| {
        let ledger = report.ledger(false);
        let mut numbered = Table::new(once("number").chain(ledger.header().iter().map(String::as_str)));
        let numbers = (1..).map(|number: usize| number.to_string());
        numbers.zip(ledger.body()).for_each(|(number, row)| numbered.row(once(number).chain(row.iter().cloned())));
        page.table(
            "Ratios patterned over flat, dimensionless. Before: predicted by the trials before, those of the first trial by what is believed \
             before any, with the interval of 95 %, the measurement's own errors included. Surprise: number of standard deviations by which a normal value as improbable as the measured ratio lies off that prediction.",
            &numbered,
        );
        page.paragraph(MODELLED);
        page.table(
            "Pending: cut and not yet measured. Predicted: by all trials, with the interval of 95 % of such samples.",
            &report.pending_table(),
        );
        let mut table = Table::of(&report.trials);
        table.column("trial", |trial| trial.name.clone());
        if report.trials.iter().any(|trial| !trial.date.is_empty()) {
            table.column("date", |trial| trial.date.clone());
        }
        table.column("width in µm", |trial| number(trial.width_um, 1));
        table.column("spacing in µm", |trial| number(trial.spacing_um, 1));
        table.column("depth in µm", |trial| number(trial.depth_um, 1));
        table.column("areal density in %", |trial| percent(trial.areal_density, 1));
        table.column("edges in 1/mm", |trial| number(trial.edge_per_mm, 2));
        if report.trials.iter().any(|trial| !trial.notes.is_empty()) {
            table.column("notes", |trial| trial.notes.clone());
        }
        page.table("The samples.", &table.table());
    });
    page.part("How good the predictions were", |page| {
        let mut table = Table::of(&report.coverage);
        table.column("predicted by", |of| of.by.clone());
        table.column("ratios", |of| of.ratios.to_string());
        table.column("not counted", |of| of.without_any.to_string());
        table.column("within 68 %", |of| share(of, of.within_68));
        table.column("within 95 %", |of| share(of, of.within_95));
        page.table(
            "How many measured ratios lie within the intervals that were predicted. If the intervals are right, about 68 and 95 % of them do. Ratios \
             of which no other measurement says anything are not counted: before any trial an interval is so wide that any number lies in it.",
            &table.table(),
        );
        if let Ok(svg) = left_out(&report.trials) {
            page.picture(
                &svg,
                "Measured ratios against those predicted by all other trials. Bars: 95 % of samples, cut off at the frame",
            );
        }
        page.fold("Every ratio predicted by the other trials, and by the other conditions", |page| {
            let mut table = Table::of(&rows);
            table.column("trial", |(trial, _)| trial.name.clone());
            table.column("P in MPa", |(_, at)| number(at.pressure_mpa, 3));
            table.column("measured", |(_, at)| number(at.measured, 3));
            table.column("by other trials", |(_, at)| predicted_by(&at.without_trial));
            table.column("surprise", |(_, at)| number(at.without_trial.surprise, 1));
            table.column("by other conditions", |(_, at)| predicted_by(&at.without_condition));
            table.column("surprise", |(_, at)| number(at.without_condition.surprise, 1));
            page.table("By all other trials; by all other conditions, of the same trial as well.", &table.table());
        });
    });
    page.part("What the model lacks", |page| {
        page.fold("How it depends on the condition", |page| {
            page.table(
                "Of the logarithm of the measured over the modelled ratio: 0.01 is one per cent. An error as large as the one before any trial is \
                 what is believed, not what was measured.",
                &report.effects_table(),
            );
        });
        page.fold("How it grows with the texture", |page| {
            page.table("How much each form is believed, now and before any trial.", &report.forms_table());
        });
    });
}

fn share(of: &Coverage, within: usize) -> String {
    format!("{within} ({} %)", percent((of.ratios > 0).then(|| within as f64 / of.ratios as f64), 0))
}

fn predicted_by(of: &PredictedReport) -> String {
    format!("{} ({})", believed(of.ratio, 3), believed_interval(of.interval_95))
}
