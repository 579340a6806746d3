//! What `optimize` found.

use slipgrid_design::records::{ChanceReport, ExplanationReport, GoalReport, TableReport, TargetReport, Tolerance};
use slipgrid_design::{AdviceReport, DesignOutcome, DesignReport, PredictedRatio};
use slipgrid_export::{Exposure, Laser};
use slipgrid_material::AreaLaw;
use slipgrid_results::{PatternReport, believed_interval, duration_in_words, length_in_words};
use slipgrid_springblock::Load;

use super::first_screen::first_screen;
use super::page::{Page, estimate, known, number, percent, plain, sentence, with_error};
use super::{background, conditions, uncertainty};
use crate::Outputs;

/// The page of a design: from its `report`, the coefficients behind it, which are those of `loads` and of `area_law`, and the
/// pictures and files in `outputs`; with an explorer where `found`, of which `report` is, has one.
#[must_use]
pub fn design(
    report: &DesignReport,
    area_law: Option<&AreaLaw>,
    loads: &[Load],
    outputs: &Outputs,
    found: Option<&DesignOutcome>,
) -> String {
    let mut page = Page::default();
    page.title(&report.name);
    if let Some(date) = &report.date {
        page.marked("date", date);
    }
    first_screen(&mut page, report, outputs, found);
    if let Some(found) = found {
        super::explorer::explorer(&mut page, found, outputs);
    }
    page.part("Why this design", |page| chosen(page, report, outputs));
    page.part("What samples will do", |page| {
        if let Some(found) = &report.robustness {
            uncertainty::robustness(page, found);
        }
        if let Some(chance) = &report.chance {
            page.fold("What the chance includes, and what limits it", |page| {
                chance_parts(page, chance, report.advice.as_ref());
            });
        }
        if let Some(found) = &report.sensitivities {
            page.fold("What a micrometre changes", |page| uncertainty::sensitivities(page, found));
        }
    });
    page.part("Evidence", |page| {
        target(page, report);
        page.fold("The section", |page| page.section(&report.design));
        let interface = if report.sees_face() {
            "one period of the patterned surface seen from above; a flat one carries the nominal pressure everywhere"
        } else {
            "flat and patterned"
        };
        pictures(page, outputs, "Pressure along the interface", "interface-", interface);
        let in_time = "flat and patterned, with the averaging window; the curve of the patterned surface is the run of the longest strip, and its mean \
                       that of the whole specimen, as in the tables";
        pictures(page, outputs, "Friction in time", "friction-", in_time);
    });
    page.model([&report.model, &report.method], report.design.rim.is_some());
    page.fold("Material and calibration", |page| material(page, report, outputs, (area_law, loads)));
    page.part("Files", |page| {
        page.fold("pattern.svg: the pattern, with two periods enlarged", |page| {
            page.picture_of(outputs, "pattern.svg", "The specimen seen from above, with two periods enlarged");
        });
        laser(page, &report.laser, outputs);
    });
    page.finish(&report.name, &report.version)
}

/// What became of the search: what it chose, what it could not have, what else there is.
fn chosen(page: &mut Page, report: &DesignReport, outputs: &Outputs) {
    if let Some(selection) = &report.selection {
        page.paragraph(&format!("The design was {}.", selection.words));
    }
    if let Some(advice) = &report.advice {
        rather(page, advice);
    }
    if let Some(explanation) = &report.explanation {
        why(page, explanation);
    }
    if let Some(found) = &report.trade_offs {
        uncertainty::trade_offs(page, found, outputs);
    }
    page.fold("The search", |page| search(page, report));
}

/// Textures that are likelier on target.
fn rather(page: &mut Page, advice: &AdviceReport) {
    page.records(
        "Likelier on target, by what trials say of their own texture. Ratios are medians, with what 95 % of samples lie between.",
        &advice.rather,
        &[
            ("width in µm", |of| length_in_words(of.design.width_um)),
            ("spacing in µm", |of| length_in_words(of.design.spacing_um)),
            ("depth in µm", |of| length_in_words(of.design.depth_um)),
            ("chance in %", |of| percent(of.chance, 1)),
            ("laser", |of| of.laser_s.map_or_else(|| "-".to_owned(), duration_in_words)),
            ("ratio at the first load", |of| predicted(of.predicted.first())),
            ("at the last", |of| predicted(of.predicted.last())),
        ],
    );
}

/// What is predicted of a sample at a load.
fn predicted(at: Option<&PredictedRatio>) -> String {
    at.map_or_else(String::new, |at| format!("{} ({})", number(at.of.ratio, 3), believed_interval(at.of.interval_95)))
}

/// What the chance rests on.
fn chance_parts(page: &mut Page, chance: &ChanceReport, advice: Option<&AdviceReport>) {
    page.paragraph("The chance is one of all pressures and conditions at once.");
    for line in chance.lines(advice) {
        page.paragraph(&sentence(&line));
    }
    page.records(
        "What limits the chance: the chance in % if one of these were known, or made, exactly.",
        &chance.parts,
        &[
            ("what", |part| part.input.clone()),
            ("how well it is known", |part| part.known_to.clone()),
            ("chance in %", |part| percent(part.chance_without, 1)),
        ],
    );
}

fn target(page: &mut Page, report: &DesignReport) {
    let wanted = &report.target;
    let rows: Vec<Vec<String>> = wanted
        .pressure_mpa
        .iter()
        .enumerate()
        .map(|(row, pressure_mpa)| {
            let (predicted, at) = (report.predicted.get(row), report.errors.at(row));
            vec![
                plain(*pressure_mpa),
                accepted(wanted, row),
                estimate(at.and_then(|at| at.predicted.as_ref()), 4),
                number(predicted.and_then(|load| load.ratio_discretization_error), 4),
                estimate(report.confirmed_at(row), 4),
                number(report.confirmed.get(row).and_then(|load| load.ratio_discretization_error), 4),
                estimate(at.map(|at| &at.mu), 4),
                estimate(at.and_then(|at| at.mu_flat.as_ref()), 4),
                estimate(at.and_then(|at| at.mu_static.as_ref()), 4),
                number(predicted.map(|load| load.peak_pressure_mpa), 2),
                report.confirmed.get(row).map_or("-", |load| &load.status).to_owned(),
            ]
        })
        .collect();
    let header = "P in MPa,target,predicted,change of predicted for vanishing blocks,confirmed,change of confirmed for vanishing \
                  blocks,mu,mu flat,mu static,peak in MPa,status";
    let (header, rows, status) = told(&header.split(',').collect::<Vec<_>>(), &rows);
    let quantity = if report.is_ratio() { "ratio patterned over flat" } else { "dynamic friction coefficient" };
    page.table(
        &format!(
            "Target (or the band accepted), predicted and confirmed: {quantity}, dimensionless{}. After ±: of the target its \
             tolerance; else {}. Changes for vanishing blocks: estimated, of the ratio. The peak is the \
             largest local pressure of the steady cell, which grows as blocks shrink.{status}",
            if report.discrepancy.is_some() { ", times what trials say that the model lacks" } else { "" },
            report.errors.meaning.trim_start_matches("+-: "),
        ),
        &header,
        &rows,
    );
    page.fold("What the errors are made of", |page| uncertainty::errors(page, &report.errors));
    if let Some(found) = &report.discrepancy {
        uncertainty::discrepancy(page, found);
    }
    if let Some(found) = &report.conditions {
        conditions::conditions(page, found);
    }
    if let Some(found) = &report.goal {
        goal(page, found);
    }
    // A goal alone has no distance.
    if wanted.has_demands() {
        page.paragraph(&format!(
            "Largest distance from the target in tolerances: {} predicted, {} confirmed; up to 1 is met.",
            number(report.misfit.predicted, 2),
            number(report.misfit.confirmed, 2)
        ));
    }
}

/// What became of the goal.
fn goal(page: &mut Page, goal: &GoalReport) {
    page.paragraph(&format!(
        "Goal: the {} {}. Predicted {}, confirmed {}; highest less lowest value {} and {}.",
        if goal.goal == "even" { "least" } else { &goal.goal },
        goal.of,
        with_error(goal.predicted, goal.predicted_std, 5),
        with_error(goal.confirmed, goal.confirmed_std, 5),
        number(goal.range_predicted, 4),
        number(goal.range_confirmed, 4)
    ));
}

/// Header and rows without the columns that say nothing at any pressure; the last, the status, in words where it
/// is one.
fn told<'a>(header: &[&'a str], rows: &[Vec<String>]) -> (Vec<&'a str>, Vec<Vec<String>>, String) {
    let status = rows.first().and_then(|row| row.last()).filter(|&status| status != "-");
    let status = status.filter(|&status| rows.iter().all(|row| row.last() == Some(status)));
    let words = status.map_or_else(String::new, |status| format!(" Status at every pressure: {status}."));
    let says = |&column: &usize| rows.iter().any(|row| row.get(column).is_some_and(|cell| cell != "-"));
    let columns: Vec<usize> = (0..header.len() - usize::from(status.is_some())).filter(says).collect();
    let rows = rows.iter().map(|row| columns.iter().filter_map(|&column| row.get(column).cloned()).collect());
    (columns.iter().map(|&column| header[column]).collect(), rows.collect(), words)
}

/// What is accepted at a pressure.
fn accepted(wanted: &TargetReport, row: usize) -> String {
    if let Some(value) = &wanted.value {
        let tolerance = match &wanted.tolerance {
            Some(Tolerance::One(one)) => Some(*one),
            Some(Tolerance::Each(each)) => each.get(row).copied(),
            None => None,
        };
        return format!("{} ± {}", plain(value.get(row).copied()), plain(tolerance));
    }
    let edge = |edges: &[Option<f64>]| known(edges.get(row).copied().flatten());
    match (edge(&wanted.lowest), edge(&wanted.highest)) {
        (Some(lowest), Some(highest)) => format!("{} to {}", number(lowest, 4), number(highest, 4)),
        (Some(lowest), None) => format!("at least {}", number(lowest, 4)),
        (None, Some(highest)) => format!("at most {}", number(highest, 4)),
        (None, None) => "-".to_owned(),
    }
}

/// The pictures whose names begin with `prefix`, by load.
fn pictures(page: &mut Page, outputs: &Outputs, heading: &str, prefix: &str, what: &str) {
    let named: Vec<(String, String)> = outputs
        .names()
        .into_iter()
        .filter(|name| name.starts_with(prefix) && name.ends_with(".svg"))
        .filter_map(|name| {
            let load = name.strip_prefix(prefix)?.strip_suffix("mpa.svg")?;
            Some((outputs.text(name)?, format!("{heading} at {load} MPa: {what}")))
        })
        .collect();
    if named.is_empty() {
        return;
    }
    page.fold(heading, |page| page.pictures(named.iter().map(|(svg, caption)| (svg.as_str(), caption.as_str()))));
}

fn search(page: &mut Page, report: &DesignReport) {
    page.paragraph(&format!(
        "{} designs evaluated in {}, {} that could not be computed, seed {}.",
        report.evaluations,
        match report.rounds {
            1 => "one search".to_owned(),
            rounds => format!("{rounds} searches, each corrected by what was solved of the design before it"),
        },
        report.failed_trials,
        report.seed
    ));
    let tried = report
        .reachable_among
        .map_or_else(|| "designs tried".to_owned(), |count| format!("{count} designs solved in space"));
    page.records(
        &format!("Lowest and highest value among the {tried} that respect every constraint."),
        &report.reachable,
        &[
            ("P in MPa", |range| plain(range.pressure_mpa)),
            ("lowest", |range| with_error(range.lowest, range.lowest_std, 4)),
            ("highest", |range| with_error(range.highest, range.highest_std, 4)),
        ],
    );
    page.records(
        "Other designs that meet the target by the search's model.",
        &report.alternatives,
        &[
            ("width in µm", |other| length_in_words(other.width_um)),
            ("spacing in µm", |other| length_in_words(other.spacing_um)),
            ("depth in µm", |other| length_in_words(other.depth_um)),
            ("share in %", |other| percent(other.areal_density, 2)),
        ],
    );
    if let Some(found) = &report.table {
        table(page, found, report.laser.bursts_per_pass().is_some());
    }
    background::history(page, &report.history);
}

/// Which limits and bounds keep designs from the target, where it is out of reach.
fn why(page: &mut Page, explanation: &ExplanationReport) {
    page.subheading("Why the target is out of reach");
    page.records(
        "Limits and bounds that bind, by the search's model: each relaxed alone, and what the target is then.",
        &explanation.binding,
        &[
            ("limit or bound", |relief| relief.what.clone()),
            ("now", |relief| plain(relief.limit)),
            ("relaxed to", |relief| if relief.suffices { plain(relief.relaxed) } else { number(relief.relaxed, 3) }),
            ("unit", |relief| relief.unit.to_string()),
            ("target", |relief| {
                if relief.suffices {
                    return "met".to_owned();
                }
                format!("missed by {} tolerances", number(relief.nearest.misfit, 2))
            }),
            ("design (width / spacing / depth in µm)", |relief| lengths(&relief.nearest.design)),
        ],
    );
    if explanation.binding.is_empty() {
        page.paragraph("No single limit or bound is the reason: relaxing each alone brings no design nearer.");
    }
    if let Some(together) = &explanation.together {
        page.paragraph(&format!(
            "With all of them relaxed together the nearest design, {} µm, misses by {} tolerances.",
            lengths(&together.design),
            number(together.misfit, 2)
        ));
    }
}

/// Width, spacing and depth of a design, in micrometres.
pub(super) fn three_lengths(design: &PatternReport) -> [String; 3] {
    [design.width_um, design.spacing_um, design.depth_um].map(length_in_words)
}

/// The same in one cell.
pub(super) fn lengths(design: &PatternReport) -> String {
    three_lengths(design).join(" / ")
}

/// What a table of designs says of the one found.
fn table(page: &mut Page, table: &TableReport, has_passes: bool) {
    let verdict = match (table.by_chance, table.confirms_search) {
        (true, _) => "The design found was not chosen by its misfit alone",
        (false, true) => "None is better than the design found",
        (false, false) => "One is better than the design found",
    };
    page.paragraph(&format!(
        "Table of {} designs (table.csv; whole blocks and {}): {} respect every limit, {} of them do what is demanded. {verdict}. \
         The design found has a cost of {}; the best of the table, {} µm, has {}. Cost is the largest misfit in \
         tolerances, or the goal in per cent.",
        table.designs,
        if has_passes { "passes" } else { "bursts" },
        table.feasible,
        table.meeting,
        number(table.found_cost, 3),
        lengths(&table.best.design),
        number(table.best.cost, 3),
    ));
}

fn material(page: &mut Page, report: &DesignReport, outputs: &Outputs, (area_law, loads): (Option<&AreaLaw>, &[Load])) {
    let (name, source) = (&report.material.name, &report.material.source);
    if !name.is_empty() {
        page.paragraph(&if source.is_empty() { name.clone() } else { format!("{name}. Source: {source}.") });
    }
    page.list(&report.material.notes);
    background::coefficients(page, loads);
    if let Some(law) = area_law {
        background::area_law(page, law);
    }
    if let Some(scene) = outputs.text("scene.toml") {
        page.folded("scene.toml: coefficients, area law, sample and run, as confirmed", &scene);
    }
}

fn laser(page: &mut Page, laser: &Laser, outputs: &Outputs) {
    // By name, in the order of the alphabet.
    let Laser {
        depth_per_burst_um,
        exposure,
        hatch_um,
        min_land_um,
        power_density_gw_cm2,
        pulse_ns,
        repetition_hz,
        speed_mm_s,
        spot_um,
        wall_taper_deg,
        wavelength_nm,
        ablation,
    } = *laser;
    let exposure = exposure.map(|exposure| match exposure {
        Exposure::Hatch => "hatch".to_owned(),
        Exposure::Mask => "mask".to_owned(),
    });
    let rows: Vec<(&str, String)> = [
        ("depth_per_burst_um", depth_per_burst_um.map(plain)),
        ("exposure", exposure),
        ("hatch_um", hatch_um.map(plain)),
        ("min_land_um", min_land_um.map(plain)),
        ("power_density_gw_cm2", power_density_gw_cm2.map(plain)),
        ("pulse_ns", pulse_ns.map(plain)),
        ("repetition_hz", repetition_hz.map(plain)),
        ("speed_mm_s", speed_mm_s.map(plain)),
        ("spot_um", spot_um.map(plain)),
        ("wall_taper_deg", wall_taper_deg.map(plain)),
        ("wavelength_nm", wavelength_nm.map(plain)),
    ]
    .into_iter()
    .filter_map(|(name, value)| Some((name, value?)))
    .collect();
    page.facts("The laser, as the design gives it; units stand in the names", &rows);
    if let Some(law) = ablation {
        page.paragraph(&format!(
            "Depth per burst d = delta ln(F / F_th): delta {} µm, F_th {} J/cm², at {} J/cm² {} µm ({} fluences).",
            with_error(law.delta_um, law.delta_stderr_um, 3),
            with_error(law.threshold_j_cm2, law.threshold_stderr_j_cm2, 3),
            plain(law.fluence_j_cm2),
            with_error(law.depth_per_burst_um, law.depth_per_burst_stderr_um, 3),
            law.points,
        ));
    }
    if let Some(sheet) = outputs.text("process.toml") {
        page.folded("process.toml: the process sheet", &sheet);
    }
}
