//! Page of a design found by `optimize`.

use slipgrid_base::units::significant;
use slipgrid_design::records::{GoalReport, TradeOffsReport};
use slipgrid_design::results::{LoadReport, PatternReport, believed_interval, duration_in_words, length_in_words};
use slipgrid_design::{DesignOutcome, DesignReport, Expected, SampleReport, percent as chance_words};
use slipgrid_laser::export::{Exposure, Laser};
use slipgrid_model::material::AreaLaw;
use slipgrid_model::springblock::Load;

use super::background;
use super::first_screen::first_screen;
use super::page::{Column, Page, micrometres, number, percent, plain, sentence, with_error};
use crate::Outputs;
use crate::charts::model_alone;
use crate::uncertainty_budget::{self, UncertaintyBudget};

/// Makes the page of a design from its `report`, the coefficients in `loads` and `area_law`, and the pictures and files in
/// `outputs`; includes an explorer if `found`, the design of `report`, has one.
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
            page.section(&report.sample.design);
            page.picture_of(outputs, "pattern.svg", "The specimen seen from above, with two periods enlarged");
        });
        page.fold("The laser, as the design gives it", |page| laser(page, &report.laser));
    });
    page.finish(&report.name, &report.version)
}

/// Adds expected values at every load, their limits, and their sensitivity to the dimensions.
fn expected(page: &mut Page, report: &DesignReport) {
    let all = &report.sample.expected;
    let has_several = all.iter().any(|at| !at.is_at_condition_of(&all[0]));
    let has_tolerance = report.target.has_demands();
    let mut header = vec!["P in MPa"];
    header.extend(has_several.then_some("speed, humidity, direction"));
    header.extend(has_tolerance.then_some("accepted"));
    header.extend(["expected", "95 % of samples", "model alone"]);
    let quantity = if report.is_ratio() { "ratio patterned over flat" } else { "dynamic friction coefficient" };
    let row = |(row, at): (usize, &Expected)| {
        let mut cells = vec![plain(at.pressure_mpa)];
        cells.extend(has_several.then(|| at.condition_in_words()));
        cells.extend(has_tolerance.then(|| at.target_in_words()));
        let std = report.sample.modelled.get(row).map(|modelled| modelled.std / modelled.ratio);
        let alone = model_alone(report, row);
        cells.extend([
            number(at.median, 3),
            believed_interval([at.low_95, at.high_95]),
            with_error(alone, alone.zip(std).map(|(alone, std)| alone * std), 3),
        ]);
        cells
    };
    page.table(
        &format!(
            "{}, dimensionless. Expected: median of cut samples. Model alone: without what trials say, ± one standard deviation of what is \
             not known of the material and of the computation.",
            sentence(quantity).trim_end_matches('.')
        ),
        &header,
        &all.iter().enumerate().map(row).collect::<Vec<_>>(),
    );
    if let Some(found) = &report.goal {
        goal(page, found);
    }
    limited_by(page, report);
    budgets(page, report);
    slopes(page, report);
}

/// Adds the folded uncertainty budget of every load.
fn budgets(page: &mut Page, report: &DesignReport) {
    let budgets = UncertaintyBudget::of_design(report);
    page.fold("Uncertainty budget in the form of the GUM", |page| {
        for budget in &budgets {
            page.same_table(&sentence(&budget.result_in_words()), &budget.table());
        }
        if !budgets.is_empty() {
            page.paragraph(uncertainty_budget::WORDS);
        }
    });
}

/// Adds the achieved goal.
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

/// Standard deviation from which an input is listed: half a unit of the last decimal.
const MIN_STD: f64 = 5e-5;

/// Whether a cell has a number other than zero, or words.
fn says(cell: &str) -> bool {
    cell.chars().any(|c| !matches!(c, '-' | '0' | '.' | ' '))
}

fn limited_by(page: &mut Page, report: &DesignReport) {
    let last = report.target.pressure_mpa.len().saturating_sub(1);
    let has_chance = report.sample.chance.is_some();
    let mut header = vec!["input", "how well it is known", "standard deviation"];
    header.extend(has_chance.then_some("chance if it were known exactly"));
    let rows: Vec<Vec<String>> = report
        .sample
        .limited_by
        .iter()
        .filter(|limit| limit.std.iter().any(|std| *std >= MIN_STD))
        .map(|limit| {
            let mut cells =
                vec![limit.input.clone(), micrometres(&limit.known_to), number(limit.std.get(last).copied(), 4)];
            cells.extend(has_chance.then(|| chance_words(limit.chance_if_known)));
            cells
        })
        .collect();
    page.table(
        &format!(
            "What limits the prediction: the standard deviation of the ratio that each input alone gives at {} MPa.",
            plain(report.target.pressure_mpa.get(last).copied())
        ),
        &header,
        &rows,
    );
}

/// Adds the sensitivity of expected values to each dimension.
fn slopes(page: &mut Page, report: &DesignReport) {
    let mut header = vec!["P in MPa"];
    header.extend(report.slopes.iter().map(|slope| slope.dimension.trim_end_matches("_um")));
    let row = |(row, pressure_mpa): (usize, &f64)| {
        let slopes = report.slopes.iter().map(|slope| number(slope.per_um.get(row).map(|per_um| 1e4 * per_um), 2));
        std::iter::once(plain(*pressure_mpa)).chain(slopes).collect()
    };
    if !report.slopes.is_empty() {
        page.table(
            "Change of what is expected, in units of 0.0001, where one dimension grows by 1 µm and the others stay.",
            &header,
            &report.target.pressure_mpa.iter().enumerate().map(row).collect::<Vec<Vec<String>>>(),
        );
    }
}

/// Adds other samples worth cutting, and the trade-offs.
fn others(page: &mut Page, report: &DesignReport, outputs: &Outputs) {
    let ends = |at: Option<&Expected>| {
        at.map_or_else(String::new, |at| {
            format!("{} ({})", number(at.median, 3), believed_interval([at.low_95, at.high_95]))
        })
    };
    let columns: [Column<SampleReport>; 6] = [
        ("width / spacing / depth in µm", |of| of.design.lengths_in_words()),
        ("planform", |of| of.design.planform().to_owned()),
        ("chance", |of| of.chance.map_or_else(|| "-".to_owned(), chance_words)),
        ("laser", |of| of.laser_s.map_or_else(|| "-".to_owned(), duration_in_words)),
        ("learns", |of| of.learns().to_owned()),
        ("share in %", |of| percent(of.design.areal_density, 1)),
    ];
    let is_known = |column: &&Column<SampleReport>| report.others.iter().any(|other| says(&column.1(other)));
    let columns: Vec<Column<SampleReport>> = columns.iter().filter(is_known).copied().collect();
    let mut header: Vec<&str> = columns.iter().map(|(name, _)| *name).collect();
    header.extend(["expected at the first load (95 %)", "at the last"]);
    let own = std::iter::once(&report.sample).filter(|_| !report.others.is_empty());
    let row = |of: &SampleReport| {
        let cells = columns.iter().map(|(_, cell)| cell(of));
        cells.chain([ends(of.expected.first()), ends(of.expected.last())]).collect()
    };
    page.table(
        "The design, and textures of other regions of the bounds that are worth cutting. Learns: how much measuring a sample would tell \
         about how the model's error depends on the texture.",
        &header,
        &own.chain(&report.others).map(row).collect::<Vec<Vec<String>>>(),
    );
    if let Some(found) = &report.trade_offs {
        trade_offs(page, found, outputs);
    }
    let table = &report.table;
    if table.nodes > 0 {
        page.paragraph(&format!(
            "{} designs were compared by a table of the model over the bounds, seed {}. It has {} nodes, {} of them without an answer. At {} random \
             designs its ratios are off by {} in the median and {} at most.",
            report.compared,
            report.seed,
            table.nodes,
            table.holes,
            table.checked,
            number(table.median_error, 4),
            number(table.worst_error, 4),
        ));
    }
}

/// Adds the designs on the Pareto front.
fn trade_offs(page: &mut Page, found: &TradeOffsReport, outputs: &Outputs) {
    page.subheading("Trade-offs");
    page.picture_of(
        outputs,
        "trade-offs.svg",
        "Designs by the goals that were compared; no other design beats one on the front in every goal",
    );
    page.paragraph(&format!("Of {} designs {} are not beaten by another in every goal.", found.designs, found.front));
    let header: Vec<&str> = ["width in µm", "spacing in µm", "depth in µm"]
        .into_iter()
        .chain(found.words.iter().map(AsRef::as_ref))
        .collect();
    let row = |design: &PatternReport, goals: &[f64]| {
        let lengths = [design.width_um, design.spacing_um, design.depth_um].map(length_in_words);
        lengths.into_iter().chain(goals.iter().map(|goal| plain(significant(*goal, 3)))).collect()
    };
    let rows: Vec<Vec<String>> = found.listed.iter().map(|listed| row(&listed.design, &listed.goals)).collect();
    page.table("Some of the front, from one end to the other; trade-offs.csv has all.", &header, &rows);
}

/// Adds the results of the confirming run at the target's pressures.
fn confirmed(page: &mut Page, report: &DesignReport) {
    let columns: [Column<LoadReport>; 9] = [
        ("P in MPa", |load| plain(load.pressure_mpa)),
        ("ratio", |load| with_error(load.ratio, load.ratio_stderr, 4)),
        ("change for vanishing blocks", |load| number(load.blocks_error(), 4)),
        ("mu", |load| with_error(load.mu_dynamic, load.mu_dynamic_stderr, 4)),
        ("mu flat", |load| with_error(load.mu_flat, load.mu_flat_stderr, 4)),
        ("mu static", |load| number(load.mu_static, 4)),
        ("mu static, flat", |load| number(load.mu_flat_static, 4)),
        ("peak in MPa", |load| number(load.peak_pressure_mpa, 2)),
        ("status", |load| load.status.to_string()),
    ];
    let is_known = |column: &&Column<LoadReport>| report.confirmed.iter().any(|load| says(&column.1(load)));
    let columns: Vec<Column<LoadReport>> = columns.iter().filter(is_known).copied().collect();
    page.records(
        &format!(
            "The model alone, {}: dimensionless, ± one standard error. The peak is the largest local pressure, which grows as blocks shrink.",
            report.confirmation()
        ),
        &report.confirmed,
        &columns,
    );
}

/// Adds the pictures whose names begin with `prefix`, of the first and the last load: the others, which lie between them,
/// are files beside the page and would double its size.
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
    let mut named = named.into_iter();
    let shown: Vec<_> = named.next().into_iter().chain(named.next_back()).collect();
    if !shown.is_empty() {
        page.fold(heading, |page| page.pictures(shown.iter().map(|(svg, caption)| (svg.as_str(), caption.as_str()))));
    }
}

fn material(page: &mut Page, report: &DesignReport, (area_law, loads): (Option<&AreaLaw>, &[Load])) {
    let (name, source) = (&report.material.name, &report.material.source);
    if !name.is_empty() {
        page.paragraph(&if source.is_empty() { name.clone() } else { format!("{name}. Source: {source}.") });
    }
    page.list(&report.material.notes.iter().map(|note| sentence(note)).collect::<Vec<_>>());
    background::coefficients(page, loads);
    if let Some(law) = area_law {
        background::area_law(page, law);
    }
}

fn laser(page: &mut Page, laser: &Laser) {
    // Alphabetical by name.
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
        ("depth per burst", depth_per_burst_um, "µm"),
        ("distance of hatch lines", hatch_um, "µm"),
        ("smallest land", min_land_um, "µm"),
        ("power density", power_density_gw_cm2, "GW/cm²"),
        ("pulse length", pulse_ns, "ns"),
        ("repetition rate", repetition_hz, "Hz"),
        ("speed", speed_mm_s, "mm/s"),
        ("spot", spot_um, "µm"),
        ("taper of the walls", wall_taper_deg, "°"),
        ("wavelength", wavelength_nm, "nm"),
    ]
    .into_iter()
    .filter_map(|(name, value, unit)| Some((name, format!("{} {unit}", plain(value?)))))
    .chain(exposure.map(|exposure| ("exposure", exposure)))
    .collect();
    page.facts("", &rows);
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
}
