//! Page of a design found by `optimize`.

use slipgrid_base::units::{counted, significant};
use slipgrid_design::records::{GoalReport, TradeOffsReport};
use slipgrid_design::results::{Table, believed_interval, duration_in_words, length_in_words};
use slipgrid_design::{DesignOutcome, DesignReport, Expected, LimitedBy, SampleReport, percent as chance_words};
use slipgrid_laser::export::{Exposure, Laser};
use slipgrid_model::material::AreaLaw;
use slipgrid_model::springblock::Load;

use super::background;
use super::first_screen::first_screen;
use super::page::{Page, micrometres, number, percent, plain, sentence, with_error};
use crate::Outputs;
use crate::charts::model_alone;
use crate::uncertainty_budget::{self, UncertaintyBudget};

/// Makes the page of a design from its `report`, the `area_law`, the local coefficients in `loads`, and the pictures
/// and files in `outputs`. Includes an explorer if `found`, the design of `report`, has an explorer.
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
    page.part("What is expected of a sample", |page| expected(page, report));
    page.part("Other textures", |page| others(page, report, outputs));
    page.part("The run that confirmed the design", |page| {
        confirmed(page, report);
        let interface = if report.sees_face() {
            "one period of the patterned surface seen from above; a flat one carries the nominal pressure everywhere"
        } else {
            "flat and patterned"
        };
        pictures(page, outputs, "Pressure along the interface", "interface-", interface);
        let in_time = "flat and patterned, with the averaging window. The curve of the patterned surface is the longest strip; its mean is that of the \
                       whole specimen";
        pictures(page, outputs, "Friction in time", "friction-", in_time);
    });
    page.model([&report.model, &report.method], report.sample.design.rim().is_some());
    page.fold("Material", |page| material(page, report, (area_law, loads)));
    page.part("Files", |page| {
        page.files(&outputs.names());
        page.fold("The pattern on the specimen", |page| {
            page.section(&report.sample.design, true);
            page.picture_of(outputs, "pattern.svg", "The specimen seen from above, with two periods enlarged");
        });
        page.fold("The laser, as the design gives it", |page| laser(page, &report.laser));
    });
    page.finish(&report.name, &report.made_by.version)
}

/// Adds expected values at every load, the inputs that limit them, uncertainty budgets, and the sensitivity to each
/// dimension.
fn expected(page: &mut Page, report: &DesignReport) {
    let all: Vec<(usize, &Expected)> = report.sample.expected.iter().enumerate().collect();
    let mut table = Table::of(&all);
    table.column("P in MPa", |(_, at)| plain(at.pressure_mpa));
    if all.iter().any(|(_, at)| !at.is_at_condition_of(all[0].1)) {
        table.column("speed, humidity, direction", |(_, at)| at.condition_in_words());
    }
    if report.target.has_demands() {
        table.column("accepted", |(_, at)| at.target_in_words());
    }
    table.column("expected", |(_, at)| number(at.median, 3));
    table.column("95 % of samples", |(_, at)| believed_interval([at.low_95, at.high_95]));
    table.column("model alone", |(row, _)| {
        let std = report.sample.modelled.get(*row).map(|modelled| modelled.std / modelled.ratio);
        let alone = model_alone(report, *row);
        with_error(alone, alone.zip(std).map(|(alone, std)| alone * std), 3)
    });
    let quantity = if report.is_ratio() { "ratio patterned over flat" } else { "dynamic friction coefficient" };
    page.table(
        &format!(
            "{}, dimensionless. Expected: median of cut samples. Model alone: without what trials say, ± one standard deviation of what is \
             not known of the material and of the computation.",
            sentence(quantity).trim_end_matches('.')
        ),
        &table.table(),
    );
    if let Some(found) = &report.goal {
        goal(page, found);
    }
    limited_by(page, report);
    page.fold("Uncertainty budget in the form of the GUM", |page| {
        let budgets = UncertaintyBudget::of_design(report);
        budgets.iter().for_each(|budget| page.table(&sentence(&budget.result_in_words()), &budget.table()));
        if !budgets.is_empty() {
            page.paragraph(uncertainty_budget::WORDS);
        }
    });
    slopes(page, report);
}

/// Adds a paragraph on the goal: expected and modelled value.
fn goal(page: &mut Page, goal: &GoalReport) {
    let interval = goal.interval_95.map_or_else(String::new, |ends| format!(" (95 %: {})", believed_interval(ends)));
    page.paragraph(&format!(
        "Goal: the {} {}. Expected {}{interval}, model alone {}.",
        if goal.goal == "even" { "least" } else { &goal.goal },
        goal.of,
        number(goal.expected, 4),
        number(goal.modelled, 4)
    ));
}

/// Minimum standard deviation of a listed input: half a unit of the last decimal shown.
const MIN_STD: f64 = 5e-5;

/// Keeps the columns of `table` in which some cell has a number other than zero, or words.
fn known(table: &Table) -> Table {
    let says = |cell: &str| cell.chars().any(|c| !matches!(c, '-' | '0' | '.' | ' '));
    let is_known = |column: &usize| table.body().iter().any(|row| says(&row[*column]));
    let columns: Vec<usize> = (0..table.header().len()).filter(is_known).collect();
    let mut known = Table::new(columns.iter().map(|column| &*table.header()[*column]));
    table.body().iter().for_each(|row| known.row(columns.iter().map(|column| row[*column].clone())));
    known
}

fn limited_by(page: &mut Page, report: &DesignReport) {
    let last = report.target.pressure_mpa.len().saturating_sub(1);
    let limits = report.sample.limited_by.iter();
    let limits: Vec<&LimitedBy> = limits.filter(|limit| limit.std.iter().any(|std| *std >= MIN_STD)).collect();
    let mut table = Table::of(&limits);
    table.column("input", |limit| limit.input.clone());
    table.column("how well it is known", |limit| micrometres(&limit.known_to));
    table.column("standard deviation", |limit| number(limit.std.get(last).copied(), 4));
    if report.sample.chance.is_some() {
        table.column("chance without it", |limit| chance_words(limit.chance_if_known));
    }
    page.table(
        &format!(
            "What limits the prediction: the standard deviation of the ratio that each input alone gives at {} MPa, first the input without which the chance is greatest.",
            plain(report.target.pressure_mpa.get(last).copied())
        ),
        &table.table(),
    );
}

/// Adds a table of the change of expected values with each dimension of the texture.
fn slopes(page: &mut Page, report: &DesignReport) {
    let rows: Vec<(usize, &f64)> = report.target.pressure_mpa.iter().enumerate().collect();
    let mut table = Table::of(&rows);
    table.column("P in MPa", |(_, pressure_mpa)| plain(**pressure_mpa));
    for slope in &report.slopes {
        let cell = |(row, _): &(usize, &f64)| number(slope.per_um.get(*row).map(|per_um| 1e4 * per_um), 2);
        table.column(slope.dimension.trim_end_matches("_um"), cell);
    }
    if !report.slopes.is_empty() {
        page.table(
            "Change of what is expected, in units of 0.0001, where one dimension grows by 1 µm and the others stay.",
            &table.table(),
        );
    }
}

/// Adds other samples worth cutting, the trade-offs, and the accuracy of the table of model results.
fn others(page: &mut Page, report: &DesignReport, outputs: &Outputs) {
    let ends = |at: Option<&Expected>| {
        at.map_or_else(String::new, |at| {
            format!("{} ({})", number(at.median, 3), believed_interval([at.low_95, at.high_95]))
        })
    };
    let own = std::iter::once(&report.sample).filter(|_| !report.others.is_empty());
    let samples: Vec<&SampleReport> = own.chain(&report.others).collect();
    let mut table = Table::of(&samples);
    table.column("width / spacing / depth in µm", |of| of.design.lengths_in_words());
    table.column("planform", |of| of.design.planform().to_owned());
    table.column("chance", |of| of.chance.map_or_else(|| "-".to_owned(), chance_words));
    table.column("laser", |of| of.laser_s.map_or_else(|| "-".to_owned(), duration_in_words));
    table.column("learns", |of| of.learns().to_owned());
    table.column("share of endless pattern in %", |of| percent(of.design.areal_density, 1));
    table.column("expected at the first load (95 %)", |of| ends(of.expected.first()));
    table.column("at the last", |of| ends(of.expected.last()));
    page.table(
        "The design, and textures of other regions of the bounds that are worth cutting. The others' specimens were not run, which changes a chance by a point or two: `next` runs \
         those that it advises. Learns: how much measuring a sample would tell about how the model's error depends on the texture.",
        &known(&table.table()),
    );
    if let Some(found) = &report.trade_offs {
        trade_offs(page, found, outputs);
    }
    let table = &report.table;
    if table.nodes > 0 {
        page.paragraph(&format!(
            "A table of the model over the bounds (seed {}; {}, {} of them without an answer) compared {}. At {} its ratios, \
             those of the model alone on an endless face, are off by {} in the median and {} at most.",
            report.seed,
            counted(table.nodes, "node"),
            table.holes,
            counted(report.compared, "design"),
            counted(table.checked, "random design"),
            number(table.median_error, 4),
            number(table.worst_error, 4),
        ));
    }
}

/// Adds the trade-offs: a picture, and a table of designs on the Pareto front.
fn trade_offs(page: &mut Page, found: &TradeOffsReport, outputs: &Outputs) {
    page.subheading("Trade-offs");
    page.picture_of(
        outputs,
        "trade-offs.svg",
        "Designs by the goals that were compared; no other design beats one on the front in every goal",
    );
    page.paragraph(&format!(
        "Not beaten by another in every goal: {} of {}.",
        found.front,
        counted(found.designs, "design")
    ));
    let mut table = Table::of(&found.listed);
    table.column("width in µm", |listed| length_in_words(listed.design.width_um));
    table.column("spacing in µm", |listed| length_in_words(listed.design.spacing_um));
    table.column("depth in µm", |listed| length_in_words(listed.design.depth_um));
    for (goal, (words, name)) in found.words.iter().zip(&found.goals).enumerate() {
        table.column(words.clone(), |listed| match listed.goals.get(goal) {
            Some(chance) if name == "chance" => chance_words(*chance),
            value => plain(value.map(|value| significant(*value, 3))),
        });
    }
    let caption = if found.listed.len() < found.front {
        "Some of the front, from one end to the other; trade-offs.csv has all."
    } else {
        "The front, from one end to the other."
    };
    page.table(caption, &table.table());
}

/// Adds the results, at the target's pressures, of the run that confirms the design.
fn confirmed(page: &mut Page, report: &DesignReport) {
    let mut table = Table::of(&report.confirmed);
    table.column("P in MPa", |load| plain(load.pressure_mpa));
    table.column("ratio", |load| with_error(load.ratio, load.ratio_stderr, 4));
    table.column("change for vanishing blocks", |load| number(load.blocks_error(), 4));
    table.column("mu", |load| with_error(load.mu_dynamic, load.mu_dynamic_stderr, 4));
    table.column("mu flat", |load| with_error(load.mu_flat, load.mu_flat_stderr, 4));
    table.column("mu static", |load| number(load.mu_static, 4));
    table.column("mu static, flat", |load| number(load.mu_flat_static, 4));
    table.column("peak in MPa", |load| number(load.peak_pressure_mpa, 2));
    table.column("status", |load| load.status.to_string());
    page.table(
        &format!(
            "The model alone, {}: dimensionless, ± one standard error. The peak is the largest local pressure, which grows as blocks shrink.",
            report.confirmation()
        ),
        &known(&table.table()),
    );
}

/// Adds the pictures whose names begin with `prefix` for the first and the last load, folded. Pictures of the loads
/// between are accompanying files; they would double the size of the page.
fn pictures(page: &mut Page, outputs: &Outputs, heading: &str, prefix: &str, what: &str) {
    let names = outputs.names();
    let mut captioned = names.into_iter().filter_map(|name| {
        let load = name.strip_prefix(prefix)?.strip_suffix("mpa.svg")?;
        Some((name, format!("{heading} at {load} MPa: {what}")))
    });
    let shown = captioned.next().into_iter().chain(captioned.next_back());
    page.pictures(heading, outputs, shown);
}

fn material(page: &mut Page, report: &DesignReport, (area_law, loads): (Option<&AreaLaw>, &[Load])) {
    let (name, source) = (&report.material.name, &report.material.source);
    if !name.is_empty() {
        page.paragraph(&if source.is_empty() { name.clone() } else { format!("{name}. Source: {source}.") });
    }
    page.sentences(&report.material.notes);
    background::coefficients(page, loads);
    if let Some(law) = area_law {
        background::area_law(page, law);
    }
}

fn laser(page: &mut Page, laser: &Laser) {
    let exposure = laser.exposure.map(|exposure| match exposure {
        Exposure::Hatch => "hatch".to_owned(),
        Exposure::Mask => "mask".to_owned(),
    });
    let rows: Vec<(&str, String)> = [
        ("depth per burst", laser.depth_per_burst_um, "µm"),
        ("distance of hatch lines", laser.hatch_um, "µm"),
        ("smallest land", laser.min_land_um, "µm"),
        ("power density", laser.power_density_gw_cm2, "GW/cm²"),
        ("pulse length", laser.pulse_ns, "ns"),
        ("repetition rate", laser.repetition_hz, "Hz"),
        ("speed", laser.speed_mm_s, "mm/s"),
        ("spot", laser.spot_um, "µm"),
        ("taper of the walls", laser.wall_taper_deg, "°"),
        ("wavelength", laser.wavelength_nm, "nm"),
    ]
    .into_iter()
    .filter_map(|(name, value, unit)| Some((name, format!("{} {unit}", plain(value?)))))
    .chain(exposure.map(|exposure| ("exposure", exposure)))
    .collect();
    page.facts("", &rows);
    if let Some(law) = laser.ablation {
        page.paragraph(&format!(
            "Depth per burst d = delta ln(F / F_th): delta {} µm, F_th {} J/cm², at {} J/cm² {} µm ({} fluences).",
            with_error(law.delta_um, law.delta_stderr_um, 3),
            with_error(law.threshold_j_cm2, law.threshold_stderr_j_cm2, 3),
            plain(law.fluence_j_cm2),
            with_error(law.depth_per_burst_um, law.depth_per_burst_stderr_um, 3),
            law.points,
        ));
    }
}
