//! First screen of a design's page: decision, sample to cut, expected values, limits and basis.

use maud::html;
use slipgrid_design::results::{believed_interval, duration_in_words, length_in_words};
use slipgrid_design::{DesignOutcome, DesignReport, Expected, LimitedBy, percent};
use slipgrid_laser::export::not_modelled;

use super::page::{Page, Text, known, length_um, number, percent as share, plain, sentence};
use crate::Outputs;
use crate::charts::{flat_of, target};

/// Maximum number of limiting inputs drawn as bars; the table below the first screen lists all inputs.
const MAX_BARS: usize = 5;
/// Minimum standard deviation of an input drawn as a bar, relative to the longest bar.
const MIN_BAR: f64 = 0.02;
/// The increase of the chance by exact knowledge of an input is reported if it exceeds this value.
const MIN_GAIN: f64 = 0.02;
/// Files needed at the laser.
const LASER_FILES: [&str; 4] = ["pattern.dxf", "pattern.svg", "pattern.csv", "process.toml"];

/// Terms on the page that readers from other fields may not know, with definitions.
const TERMS: [(&str, &str); 11] = [
    (
        "chance",
        "The probability that a sample that is cut and measured lies within what is accepted, at all pressures and conditions at once.",
    ),
    (
        "expected",
        "The median of cut samples: the model, corrected by what trials say, with everything that is not known exactly.",
    ),
    ("95 % of samples", "95 of 100 cut samples lie between these two values, 2 or 3 below and 2 or 3 above."),
    ("model alone", "The physical model without anything learned from trials."),
    (
        "ratio",
        "Dynamic friction of the patterned surface over that of the flat one, both at the same nominal pressure.",
    ),
    ("nominal pressure", "Normal force over the whole face of the specimen, cavities included."),
    ("confirmed", "By a run of the model alone, of the design on its specimen."),
    ("areal density", "Share of the face that is cavity."),
    ("burst", "What the laser gives a spot at once: it removes a fixed depth."),
    ("pass", "One run of the laser over every line of a hatch."),
    ("trial", "A sample that was cut and measured to learn how far the model is off."),
];

/// Adds the first screen of `report`, with details from the design `found` if available.
pub(super) fn first_screen(page: &mut Page, report: &DesignReport, outputs: &Outputs, found: Option<&DesignOutcome>) {
    let depth = report.wrong_depth();
    let doubts: Vec<String> = report.doubts().into_iter().filter(|doubt| Some(doubt) != depth.as_ref()).collect();
    // A sample is worth cutting, or a cut sample is on target.
    let is_good = matches!(&*report.advice, "series" | "trial" | "trial_meets_it");
    page.block(if is_good { "decision" } else { "decision missed" }, |page| {
        page.block("", |page| {
            page.marked("headline", &sentence(&report.words));
            if let Some(words) = expected_words(report) {
                page.paragraph(&words);
            }
            if let Some(words) = &depth {
                page.paragraph(&sentence(words));
            }
            page.badges(&doubts);
        });
        // Where a trial meets the target, the chance is that of another texture.
        if let Some(chance) = report.sample.chance.filter(|_| report.advice != "trial_meets_it") {
            page.dots(chance);
        }
    });
    page.block("first three", |page| {
        page.block("cut", |page| to_cut(page, report, outputs, found));
        page.block("plot", |page| {
            let several = report.sample.expected.len() > report.target.pressure_mpa.len();
            let conditions = if several { "; expected at several conditions, side by side at each pressure" } else { "" };
            let caption = format!("Friction of a cut sample against pressure{conditions}; earlier trials have textures and loads of their own");
            if let Ok(svg) = target("", report, found) {
                page.picture(&svg, &caption);
            }
        });
        page.block("limits", |page| limits(page, report, found));
    });
    basis(page, report);
    page.part("Doubts, the gravest first", |page| page.doubts(&doubts));
    page.terms(&TERMS);
}

/// Describes the expected value at the load that the first screen shows, and the strongest limit of the chance; `None`
/// without expected values.
fn expected_words(report: &DesignReport) -> Option<String> {
    let at = report.sample.expected.get(shown(report))?;
    let quantity = if report.is_ratio() { "a ratio to flat friction of" } else { "a friction coefficient of" };
    let limit = report.limit_in_words().map_or_else(String::new, |words| format!(" {}", sentence(&words)));
    let asked = match at.target_in_words().as_str() {
        "-" => String::new(),
        words => format!(" Accepted: {words}."),
    };
    // Where a trial meets the target, the page shows another texture.
    let sample =
        if report.advice == "trial_meets_it" { "a sample of the texture on this page" } else { "a cut sample" };
    let is_elsewhere = |other: &Expected| !other.is_at_condition_of(at);
    let has_several = report.sample.expected.iter().any(is_elsewhere);
    let condition = if has_several { format!(", {},", at.condition_in_words()) } else { String::new() };
    Some(format!(
        "At {} MPa{condition} {sample} is expected to have {quantity} {} (95 % of samples: {}).{asked}{limit}",
        plain(at.pressure_mpa),
        number(at.median, 3),
        believed_interval([at.low_95, at.high_95]),
    ))
}

/// Index of the load at the design condition that the first screen describes: the last load, or, for a target that
/// cannot be met, the load at which the expected value is farthest from the target.
fn shown(report: &DesignReport) -> usize {
    let count = report.target.pressure_mpa.len();
    let miss = |at: &Expected| {
        let below = at.target_low.map_or(0.0, |low| low - at.median);
        below.max(at.target_high.map_or(0.0, |high| at.median - high))
    };
    let rows = report.sample.expected.iter().take(count).enumerate();
    let farthest = rows.max_by(|(_, a), (_, b)| miss(a).total_cmp(&miss(b))).map(|(row, _)| row);
    farthest.filter(|_| report.advice == "cannot_be_met").unwrap_or(count.saturating_sub(1))
}

/// Adds the texture to cut, the laser exposure and links to the files for the laser.
fn to_cut(page: &mut Page, report: &DesignReport, outputs: &Outputs, found: Option<&DesignOutcome>) {
    let design = &report.sample.design;
    let texture = &design.texture;
    let mut rows: Vec<(&str, String)> = vec![("planform", design.planform().to_owned())];
    rows.extend(texture.arrangement.iter().map(|arrangement| ("arrangement", arrangement.clone())));
    let sizes =
        [("width", design.width_um), ("spacing (gap between cavities)", design.spacing_um), ("depth", design.depth_um)];
    rows.extend(
        sizes.into_iter().filter_map(|(name, um)| Some((name, format!("{}\u{a0}µm", length_in_words(known(um)?))))),
    );
    let lengths = [
        ("length", "µm", texture.length_um),
        ("spacing across", "µm", texture.spacing_across_um),
        ("grooves turned by", "degrees", texture.angle_deg.filter(|_| texture.crossing_angle_deg.is_none())),
        ("sliding direction turned by", "degrees", texture.sliding_angle_deg),
    ];
    if let Some(crossing_deg) = known(texture.crossing_angle_deg) {
        let first_deg = texture.angle_deg.unwrap_or(0.0);
        let [first, second] = [first_deg, first_deg + crossing_deg].map(length_um);
        rows.push(("grooves turned by", format!("{first} degrees, crossed by grooves turned by {second} degrees")));
    }
    rows.extend(
        lengths
            .into_iter()
            .filter_map(|(name, unit, value)| Some((name, format!("{} {unit}", length_um(known(value)?))))),
    );
    rows.extend(design.rim_words().map(|rim| ("rims, as assumed", rim)));
    rows.push(("cavities' share of the face", format!("{} %", share(report.specimen_areal_density, 1))));
    let laid = found.and_then(|found| found.task.specimen.layout(found.pattern).ok());
    rows.extend(laid.map(|laid| ("cavities on the specimen", laid.iter().count().to_string())));
    rows.extend(report.passes.map(|passes| ("passes over every line", passes.to_string())));
    if let Some(removal) = &report.removal {
        rows.push(("depth of all passes, on average", format!("{} µm", length_in_words(removal.mean_depth_um))));
    }
    let where_burst = if report.laser.is_mask() { "bursts per cavity" } else { "bursts per spot" };
    rows.extend(report.bursts.map(|bursts| (where_burst, bursts.to_string())));
    rows.extend(report.sample.laser_s.map(|seconds| ("time under the laser", duration_in_words(seconds))));
    let is_to_be_cut = matches!(&*report.advice, "series" | "trial");
    page.subheading(if is_to_be_cut { "What to cut" } else { "The likeliest texture" });
    page.section(design, false);
    page.facts("", &rows);
    let files: Vec<&str> = outputs.names().into_iter().filter(|name| LASER_FILES.contains(name)).collect();
    if !files.is_empty() {
        page.add(&html! {
            p class="files" { @for (place, file) in files.iter().enumerate() { @if place > 0 { " · " } a href=(file) { (file) } } }
        });
    }
}

/// Adds bars for the inputs that limit the chance, the constraints that keep the target out of reach, and the next
/// steps.
fn limits(page: &mut Page, report: &DesignReport, found: Option<&DesignOutcome>) {
    let row = shown(report);
    let std = |limit: &LimitedBy| limit.std.get(row).copied().filter(|std| std.is_finite()).unwrap_or(0.0);
    let tolerance = report.sample.expected.get(row).and_then(|at| {
        let half = 0.5 * (at.target_high? - at.target_low?);
        Some(half / flat_of(report, row)?)
    });
    let largest = report.sample.limited_by.iter().map(std).fold(tolerance.unwrap_or(0.0), f64::max);
    // The widest, in the order of the record: by the chance without the input, as `limited mostly by` names the first.
    let all = &report.sample.limited_by;
    let wider = |limit: &LimitedBy| all.iter().filter(|other| std(other) > std(limit)).count();
    let shown = all.iter().filter(|limit| std(limit) >= MIN_BAR * largest && wider(limit) < MAX_BARS);
    let shown: Vec<&LimitedBy> = shown.collect();
    if largest > 0.0 && !shown.is_empty() {
        let at = plain(report.target.pressure_mpa.get(row).copied());
        let accepted = if tolerance.is_some() { ", beside what is accepted" } else { "" };
        let bar = |value: f64| format!("width:{:.1}%", 100.0 * value / largest);
        let raises = |limit: &LimitedBy| report.sample.chance.is_some_and(|own| limit.chance_if_known > own + MIN_GAIN);
        page.subheading("What limits it");
        page.add(&html! {
            div class="bars" {
                p { "How far each unknown moves the ratio at " (at) " MPa (one standard deviation)" (accepted) "; first the one without which the chance is greatest." }
                @for limit in shown {
                    div class="input" {
                        span {
                            (Text(&limit.input)) small { " " (Text(&limit.known_to))
                                @if raises(limit) { "; without it: " (percent(limit.chance_if_known)) " chance" }
                            }
                        }
                        div { div style=(bar(std(limit))) {} } b { (number(std(limit), 3)) }
                    }
                }
                @if let Some(tolerance) = tolerance {
                    div class="input accepted" { span { "accepted: half the width of the target" } div { div style=(bar(tolerance)) {} } b { (number(tolerance, 3)) } }
                }
            }
        });
    }
    let lifted = report.blocked_by.iter().map(|lifted| {
        let reach = if lifted.is_within_reach { "" } else { ", still out of reach" };
        let (chance, lengths) = (percent(lifted.chance), lifted.design.lengths_in_words());
        format!("Without {}: {chance} chance, {lengths} µm{reach}.", lifted.what)
    });
    page.named_list("What keeps the target out of reach", &lifted.collect::<Vec<_>>());
    page.steps("What to do next", &next_steps(report, found.is_some_and(|found| found.task.is_calibrated)));
}

/// Steps to a better design. If `is_calibrated`, the design file names a calibration, and the next search reads its new
/// trials; a material file must be made anew.
fn next_steps(report: &DesignReport, is_calibrated: bool) -> Vec<String> {
    let mut steps = match &*report.advice {
        "trial" => vec!["Cut one sample and measure it at the pressures of the plot."],
        "series" => vec!["Cut the series. Measure its first samples and add them as [[trial]]."],
        "trial_meets_it" => vec![
            "Make the trial's texture: it meets the target.",
            "To come closer, cut the texture on this page as another trial.",
        ],
        "cannot_be_met" => vec![
            "Cut nothing for this target yet.",
            "Accept more, or widen a bound or a limit.",
            "Or cut the texture on this page as a trial: it shows how far the model is off there.",
        ],
        "measure_again" => vec![
            "Measure both trials again, and their dimensions.",
            "Mend the numbers of the wrong one, or take it out, and design again: slipgrid optimize.",
        ],
        _ => Vec::new(),
    };
    let bounds = report.at_bounds.join(" and ");
    let wider = format!("Or widen the bounds, if you can: the texture rests on {bounds}.");
    if report.advice == "trial" {
        steps.extend(if is_calibrated {
            &["Add it as [[trial]] to the calibration."][..]
        } else if report.material.name.is_empty() {
            &["Write a calibration of this material with it as [[trial]], and name the calibration as material."][..]
        } else {
            &[
                "Add it as [[trial]] to the calibration of this material.",
                "Make the material file anew: slipgrid calibrate CALIBRATION.toml -o MATERIAL.toml.",
            ]
        });
        steps.push("Design again: slipgrid optimize.");
        let synthetic = "Map a flat sample: the surface map used here is synthetic.";
        steps.extend(report.material.synthetic_surface.then_some(synthetic));
        steps.extend((!bounds.is_empty()).then_some(&*wider));
    }
    steps.into_iter().map(str::to_owned).collect()
}

/// Adds what the numbers rest on: trials, material, accuracy of inputs, the run that confirms the design, and effects
/// that are not modelled.
fn basis(page: &mut Page, report: &DesignReport) {
    let mut known = vec![match report.trials {
        0 => "no trial yet".to_owned(),
        1 => "1 trial".to_owned(),
        trials => format!("{trials} trials"),
    }];
    if !report.material.name.is_empty() {
        known.push(format!("material: {}", report.material.name));
    }
    let inputs = report.sample.limited_by.iter().filter(|limit| limit.known_to.ends_with('%'));
    known.extend(inputs.map(|limit| format!("{} {}", limit.input, limit.known_to)));
    if !report.confirmed.is_empty() {
        known.push(format!("confirmed by a run of the model alone: {}", report.confirmation()));
    }
    let has_rim = report.sample.design.rim().is_some();
    let lacking = not_modelled(has_rim).map(|what| what.split(':').next().unwrap_or_default());
    known.push(format!("not modelled: {}", lacking.join(", ")));
    page.block("basis", |page| page.named_list("What this rests on", &known));
}
