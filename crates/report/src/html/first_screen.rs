//! What is seen first: the chance, what to cut, what to know, the target and the pattern.

use slipgrid_design::records::ChanceReport;
use slipgrid_design::{AdviceReport, DesignOutcome, DesignReport};
use slipgrid_export::laser_time_s;
use slipgrid_results::{duration_in_words, length_in_words};
use slipgrid_units::LENGTH_MM;

use super::page::{Page, known, length_um, percent, plain, sentence};
use crate::Outputs;
use crate::target::target_narrow;

/// Class of a verdict that is no success.
const MISSED: &str = "verdict missed";

/// The words of the page that a reader from another field may not know.
const TERMS: [(&str, &str); 10] = [
    (
        "chance",
        "How likely a sample that is cut and measured lies within the tolerance at every pressure and condition.",
    ),
    (
        "ratio",
        "Dynamic friction of the patterned surface over that of the flat one, both at the same nominal pressure.",
    ),
    ("mu", "Dynamic coefficient of friction: friction force over normal force while sliding."),
    ("nominal pressure", "Normal force over the whole face of the specimen, cavities included."),
    ("predicted", "By the steady model that the search asks: the equilibrium of sliding, without time."),
    ("confirmed", "By a run in time of the design on its specimen."),
    ("areal density", "Share of the face that is cavity."),
    ("burst", "What the laser gives a spot at once: it removes a fixed depth."),
    ("pass", "One run of the laser over every line of a hatch."),
    ("trial", "A sample that was cut and measured to learn how far the model is off."),
];

/// The screen, of `report` and, where it is known, of what was `found`.
pub(super) fn first_screen(page: &mut Page, report: &DesignReport, outputs: &Outputs, found: Option<&DesignOutcome>) {
    page.side_by_side(
        |page| {
            verdict(page, report);
            dimensions(page, report, found);
            caveat(page, report);
            page.terms(&TERMS);
        },
        |page| {
            page.picture_of_both(outputs, "target.svg", target_narrow(report).ok(), target_caption(report));
            let extents_mm = found.map(|found| found.task.specimen.outline.extents_m().map(|m| LENGTH_MM.from_si(m)));
            let [along, across] = extents_mm.unwrap_or([0.0; 2]);
            let words = format!("The specimen seen from above, {} mm by {} mm", plain(along), plain(across));
            page.face_of(outputs, "pattern.svg", [along, across], &words);
        },
    );
}

fn verdict(page: &mut Page, report: &DesignReport) {
    if let Some(found) = &report.chance {
        chance(page, found, report.advice.as_ref());
    }
    if let Some(advice) = &report.advice {
        page.paragraph(&sentence(&advice.words));
    }
    let verdict = report.verdict();
    let nearest = if verdict.shows_nearest { "; nearest design below" } else { "" };
    page.marked(if verdict.is_met { "verdict" } else { MISSED }, &sentence(&format!("{}{nearest}", verdict.words)));
}

/// The chance that a cut sample is on target, first of all.
fn chance(page: &mut Page, chance: &ChanceReport, advice: Option<&AdviceReport>) {
    page.marked("chance", &sentence(&chance.announced(advice)));
    if let Some(share) = known(chance.announced_value(advice)) {
        page.bar(share);
    }
    if let Some(both) = chance.with_and_without_trials(advice) {
        page.paragraph(&sentence(&both));
    }
}

/// What to cut.
fn dimensions(page: &mut Page, report: &DesignReport, found: Option<&DesignOutcome>) {
    let design = &report.design;
    let mut rows: Vec<(&str, String)> = vec![("planform", design.planform.clone())];
    rows.extend(design.arrangement.iter().map(|arrangement| ("arrangement", arrangement.clone())));
    let sizes =
        [("width", design.width_um), ("spacing (gap between cavities)", design.spacing_um), ("depth", design.depth_um)];
    rows.extend(sizes.into_iter().filter_map(|(name, um)| Some((name, format!("{} µm", length_in_words(known(um)?))))));
    let lengths = [
        ("length", "µm", design.length_um),
        ("spacing across", "µm", design.spacing_across_um),
        ("grooves turned by", "degrees", design.angle_deg.filter(|_| design.crossing_angle_deg.is_none())),
        ("sliding direction turned by", "degrees", design.sliding_angle_deg),
    ];
    if let Some(crossing_deg) = known(design.crossing_angle_deg) {
        let first_deg = design.angle_deg.unwrap_or(0.0);
        let [first, second] = [first_deg, first_deg + crossing_deg].map(length_um);
        rows.push(("grooves turned by", format!("{first} degrees, crossed by grooves turned by {second} degrees")));
    }
    rows.extend(
        lengths
            .into_iter()
            .filter_map(|(name, unit, value)| Some((name, format!("{} {unit}", length_um(known(value)?))))),
    );
    rows.extend(design.rim.iter().map(|rim| ("rims, as assumed", rim.words())));
    rows.push(("cavities' share of a period", format!("{} %", percent(design.areal_density, 2))));
    rows.push(("of the specimen's face", format!("{} %", percent(report.specimen_areal_density, 2))));
    rows.extend(report.passes.map(|passes| ("passes over every line", passes.to_string())));
    if let Some(removal) = &report.removal {
        let um = |depth_um: f64| format!("{} µm", length_in_words(depth_um));
        rows.push(("one pass removes, in the middle of a cavity", um(removal.depth_per_pass_um)));
        rows.push(("depth of all passes in the middle", um(removal.depth_um)));
        rows.push(("on average, with the edges", um(removal.mean_depth_um)));
    }
    let where_burst = if report.laser.is_mask() { "bursts per cavity" } else { "bursts per spot" };
    rows.extend(report.bursts.map(|bursts| (where_burst, bursts.to_string())));
    if let Some(laid) = found.and_then(|found| found.task.specimen.layout(found.pattern).ok()) {
        rows.push(("cavities on the specimen", laid.iter().count().to_string()));
        let time_s = laser_time_s(&laid, &report.laser);
        rows.extend(time_s.map(|seconds| ("time under the laser", duration_in_words(seconds))));
    }
    page.facts("What to cut", &rows);
}

/// What a reader should know of the numbers before anything is cut: what matters most, the rest folded.
fn caveat(page: &mut Page, report: &DesignReport) {
    let mut all: Vec<String> = Vec::new();
    if report.material.synthetic_surface {
        all.push("The area law behind these numbers rests on a synthetic surface, not on a measured one.".to_owned());
    }
    let doubts = |load: &slipgrid_results::LoadReport| {
        let at = plain(load.pressure_mpa);
        load.doubts().map(|doubt| format!("At {at} MPa {doubt}.")).collect::<Vec<_>>()
    };
    all.extend(report.confirmed.iter().flat_map(doubts));
    all.extend(report.material.doubts().map(|doubt| sentence(&doubt)));
    all.extend(report.violations.iter().cloned());
    all.extend(report.of_laser().map(|warning| format!("Laser: {warning}.")));
    all.extend(report.unresolved().map(|doubt| sentence(&doubt)));
    page.doubts(all);
}

const fn target_caption(report: &DesignReport) -> &'static str {
    if report.conditions.is_some() {
        "Target band, predicted, confirmed and flat values against pressure at the condition designed for; from the lowest to the \
         highest value over all conditions"
    } else {
        "Target band, predicted, confirmed and flat values against pressure"
    }
}
