//! How far a design's numbers are known, how they move with its dimensions, and what could be had for what.

use slipgrid_design::records::{
    BEFORE, BESIDE, Dimensions, DiscrepancyReport, FactorReport, PressureParts, Reading, RimSlopeReport,
    RobustnessReport, SensitivityReport, SpreadReport, TradeOffsReport,
};
use slipgrid_results::ErrorsReport;

use super::design::{lengths, three_lengths};
use super::page::{Page, ends, known, number, plain, sentence, with_error};
use crate::Outputs;

/// A slope in units of 0.0001 per micrometre with its error, where both are known.
fn slope(value: Option<f64>, error: Option<f64>) -> String {
    match known(value).zip(known(error)) {
        Some((value, error)) => format!("{} ± {}", number(1e4 * value, 2), number(1e4 * error, 2)),
        None => "-".to_owned(),
    }
}

/// Slopes at the design.
pub(super) fn sensitivities(page: &mut Page, found: &SensitivityReport) {
    if found.by_pressure.is_empty() {
        return;
    }
    let Dimensions { width, spacing, depth } = found.step_um;
    page.records(
        &format!(
            "Change of {} in units of 0.0001 where one dimension grows by 1 µm and the others stay, by the steady model: central \
             differences over {}, {} and {} µm each way. After ± their error {}.",
            found.quantity,
            plain(width),
            plain(spacing),
            plain(depth),
            found.errors_in_words(),
        ),
        &found.by_pressure,
        &[
            ("P in MPa", |row| plain(row.pressure_mpa)),
            ("width", |row| slope(row.per_um.width, row.error_per_um.width)),
            ("spacing", |row| slope(row.per_um.spacing, row.error_per_um.spacing)),
            ("depth", |row| slope(row.per_um.depth, row.error_per_um.depth)),
        ],
    );
    let own: Vec<RimSlopeReport> = found.rim_slopes().cloned().collect();
    if let Some(rim) = found.rim.as_ref().filter(|_| !own.is_empty()) {
        page.records(
            &format!(
                "The same where the mean height of the rims grows by 1 µm, by differences over {} µm in blocks of {} µm.",
                plain(rim.step_um),
                plain(rim.block_um),
            ),
            &own,
            &[
                ("P in MPa", |row| plain(row.pressure_mpa)),
                ("height of the rims", |row| slope(Some(row.per_um), row.error_per_um)),
            ],
        );
    }
    if let Some(rim) = &found.rim {
        page.paragraph(&sentence(&rim.words));
    }
}

/// The parts of the errors beside the confirmed values.
pub(super) fn errors(page: &mut Page, found: &ErrorsReport) {
    let rows: Vec<Vec<String>> = found
        .by_pressure
        .iter()
        .flat_map(|row| [("ratio", row.ratio.as_ref()), ("mu", Some(&row.mu))].map(|of| (row.pressure_mpa, of)))
        .map(|(pressure_mpa, (name, of))| {
            let part = |input: &String| {
                let own = of.and_then(|of| of.parts.iter().find(|part| part.input == *input));
                number(own.map(|part| part.std), 4)
            };
            let std = number(of.and_then(|of| of.std), 4);
            let interval = ends(of.and_then(|of| of.interval_95), 4);
            let first = [plain(pressure_mpa), name.to_owned(), std, interval];
            first.into_iter().chain(found.includes.iter().map(part)).collect()
        })
        .collect();
    let header: Vec<&str> =
        ["P in MPa", "quantity", "±", "95 %"].into_iter().chain(found.includes.iter().map(String::as_str)).collect();
    page.table(
        "What the error of a confirmed value is made of: one standard deviation, and that of each part alone.",
        &header,
        &rows,
    );
}

/// Values by the physics alone, where the search aimed with what trials say beside it.
pub(super) fn discrepancy(page: &mut Page, found: &DiscrepancyReport) {
    page.paragraph(&format!(
        "The search aimed with the discrepancy: what is compared with the target is the model's value times the factor. {}. By the \
         physics alone confirmed values lie {} tolerances from the target.",
        found.meaning(),
        number(found.physics_misfit, 2),
    ));
    let cell = |of: &Reading| with_error(of.physics, of.std, 4);
    let row = |row: &FactorReport| {
        vec![
            plain(row.pressure_mpa),
            with_error(row.factor, row.factor * row.relative_std, 3),
            ends(Some(row.interval_95), 3),
            cell(&row.predicted),
            cell(&row.confirmed),
            cell(&row.mu),
        ]
    };
    let rows: Vec<Vec<String>> = found.by_pressure.iter().map(row).collect();
    page.table(
        &format!("The same values by the physics alone: {}.", found.quantity),
        &["P in MPa", "factor", "95 % of samples", "predicted", "confirmed", "mu"],
        &rows,
    );
}

/// What samples made after the design do.
pub(super) fn robustness(page: &mut Page, found: &RobustnessReport) {
    let how = match found.method.as_ref() {
        "sampled" => "draws of the steady model about the confirming run",
        _ => "draws of the steady model to first order about the confirming run",
    };
    let samples = &found.samples;
    let drawn = format!(
        "{} {how} ({} could not be computed and count as outside, {} without a positive dimension were drawn again).",
        samples.draws, samples.failed, samples.redrawn,
    );
    if samples.probability.is_none() {
        // A goal alone has no tolerance to be within.
        page.paragraph(&format!("What samples made so do, by {drawn}"));
    } else {
        page.paragraph(&format!(
            "Share of samples within the tolerance at {}, from tolerances alone, with the material as calibrated: {}, by {drawn} \
             After ± the binomial standard error.",
            found.everywhere(),
            samples.share("±"),
        ));
    }
    if let Some(material) = found.with_material.as_ref().filter(|material| material.probability.is_some()) {
        page.paragraph(&format!(
            "The same from tolerances and what is not known of the material, which all samples share: {}.",
            material.share("±")
        ));
    }
    if samples.probability.is_some() {
        page.paragraph(&sentence(BESIDE));
    }
    let shown = found.with_material.as_ref().unwrap_or(samples);
    let ratio = |spread: Option<&SpreadReport>| ends(spread.map(|spread| spread.ratio.band_95), 4);
    let rows: Vec<Vec<String>> = samples
        .by_pressure
        .iter()
        .enumerate()
        .map(|(row, at)| {
            let all = shown.by_pressure.get(row).map(|at| &at.spread);
            vec![
                plain(at.pressure_mpa),
                ratio(Some(&at.spread)),
                ratio(all),
                number(all.map(|spread| spread.mu.mean), 4),
                ends(all.map(|spread| spread.mu.band_95), 4),
            ]
        })
        .collect();
    let at = found.condition.as_ref();
    let at = at.map_or_else(String::new, |words| format!(" Values are those at the condition designed for, {words}."));
    page.table(
        &format!("Bands hold 95 % of samples.{at}"),
        &["P in MPa", "ratio: samples", "with material", "mu", "mu: with material"],
        &rows,
    );
    parts(page, &found.parts);
    page.records(
        "What scatters: standard deviations.",
        &found.inputs,
        &[
            ("input", |input| input.name.clone()),
            ("std", |input| input.std.iter().map(|std| number(*std, 2)).collect::<Vec<_>>().join(", ")),
            ("unit", |input| if input.unit == "um" { "µm" } else { &input.unit }.to_owned()),
            ("basis", |input| input.basis.clone()),
        ],
    );
    page.paragraph(&format!("{}.", found.meaning));
    if let Some(optimum) = &found.optimum {
        page.paragraph(&format!(
            "Chosen for made samples: expected misfit {} tolerances (root mean square). The nearest design on paper, {} µm \
             (width, spacing, depth), has {}.",
            number(optimum.expected_rms, 2),
            lengths(&optimum.nominal),
            number(optimum.nominal_expected_rms, 2),
        ));
    }
}

/// What each input alone would do.
fn parts(page: &mut Page, all: &[PressureParts]) {
    let Some(first) = all.first() else { return };
    let header: Vec<&str> =
        ["P in MPa", "all"].into_iter().chain(first.of.iter().map(|part| part.input.as_str())).collect();
    let rows: Vec<Vec<String>> = all
        .iter()
        .map(|row| {
            let own = [plain(row.pressure_mpa), number(row.std, 4)];
            own.into_iter().chain(row.of.iter().map(|part| number(part.std, 4))).collect()
        })
        .collect();
    page.table("Standard deviations of the target's quantity that each input alone would cause.", &header, &rows);
}

/// Designs that no other beats in every goal.
pub(super) fn trade_offs(page: &mut Page, found: &TradeOffsReport, outputs: &Outputs) {
    page.subheading("Trade-offs");
    if let Some(reason) = &found.none_because {
        page.paragraph(&format!("Nothing could be compared: {reason}."));
        return;
    }
    page.picture_of(
        outputs,
        "trade-offs.svg",
        "Designs by the goals that were compared; no other design beats one on the front in every goal",
    );
    let chosen = if found.chosen_is_on_front {
        "The chosen design is one of them."
    } else {
        "The chosen design is not one of them: it was not chosen by these goals."
    };
    page.paragraph(&format!(
        "Of {} designs {} are not beaten by another in every goal ({} more could not be computed or break a limit). {chosen} By {}.",
        found.designs, found.front, found.left_out, found.model,
    ));
    if found.goals.iter().any(|name| name == "chance") {
        page.paragraph(&sentence(BEFORE));
    }
    let header: Vec<&str> = ["width in µm", "spacing in µm", "depth in µm"]
        .into_iter()
        .chain(found.words.iter().map(AsRef::as_ref))
        .collect();
    let rows: Vec<Vec<String>> = found
        .listed
        .iter()
        .map(|listed| {
            three_lengths(&listed.design).into_iter().chain(listed.goals.iter().map(|goal| number(*goal, 2))).collect()
        })
        .collect();
    let caption = if found.on_target {
        "Designs of the front that meet the target, or some of them, from one end to the other; trade-offs.csv has the whole front."
    } else {
        "Some of the front, from one end to the other; trade-offs.csv has all."
    };
    page.table(caption, &header, &rows);
}
