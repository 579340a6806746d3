//! Page of a validation: tables and figures of the source and of the model.

use slipgrid_report::Outputs;
use slipgrid_report::html::page::{Column, Page, number, percent, plain, with_error, yes_or_no};

use super::ratios::{MeasuredReport, ModelledRatio, RatioReport};
use super::report::{AreaTable, PublishedReport, TimeReport, ValidationReport};

/// Makes the page of a validation from its `report` and the pictures in `outputs`.
#[must_use]
pub fn validation(report: &ValidationReport, outputs: &Outputs) -> String {
    let mut page = Page::default();
    let title = format!("{}: measured and modelled", report.name);
    page.title(&title);
    page.paragraph(&format!("Measurements: {}. Nothing was tuned to the patterned samples.", report.source));
    if let Some(trial) = &report.trial {
        page.paragraph(&format!("Compared is the trial \"{trial}\", as grooves of its lengths."));
    }
    if report.synthetic_surface {
        page.warning(
            "The altitude map behind the area law is synthetic, not measured: measured are the friction coefficients and the \
             pattern's dimensions alone. Read the spread between slopes of the surface as the model's uncertainty.",
        );
    }
    summary(&mut page, report);
    page.heading("Ratio patterned over flat");
    page.picture_of(
        outputs,
        "ratios.svg",
        &format!(
            "Measured with standard deviations; the modified law as grooves at the surface's slope and scaled{}; \
             Amontons-Coulomb friction (dashed) has no effect",
            if report.has_squares() { ", and as squares" } else { "" }
        ),
    );
    for planform in &PLANFORMS[..1 + usize::from(report.has_squares())] {
        ratios(&mut page, report, planform);
    }
    solves(&mut page, report);
    friction(&mut page, report);
    super::rims::section(&mut page, report, outputs);
    published(&mut page, &report.published);
    areas(&mut page, &report.area_laws, outputs);
    interface(&mut page, outputs);
    if let Some(run) = &report.in_time {
        in_time(&mut page, report, run, outputs);
    }
    measured(&mut page, &report.measured);
    page.heading("The modelled pattern");
    page.section(&report.pattern);
    page.paragraph(&format!("Depth of the measured cavities: {} µm.", plain(report.measured_depth_um)));
    page.model([&report.model, &[]], false);
    page.finish(&title, &report.version)
}

fn summary(page: &mut Page, report: &ValidationReport) {
    page.heading("What the comparison says");
    page.list(&report.statements);
    let summary = &report.summary;
    let measured = summary.reduction_measured;
    let explained =
        |reduction: Option<f64>| number(reduction.filter(|_| measured > 0.0).map(|of| 100.0 * of / measured), 0);
    let with_std = |share: Option<f64>, std: Option<f64>| match std {
        Some(std) => format!("{} ± {}", percent(share, 1), percent(std, 1)),
        None => percent(share, 1),
    };
    let all_measured = with_std(Some(measured), summary.reduction_measured_std);
    let mut rows = vec![
        vec!["measured".to_owned(), all_measured, "100".to_owned()],
        vec!["Amontons-Coulomb friction".to_owned(), percent(amontons(&report.results), 1), "0".to_owned()],
    ];
    for model in &summary.modelled {
        let factor = plain(model.slope_factor);
        let both = [("grooves", model.groove, model.groove_std), ("squares in space", model.square, model.square_std)];
        for (what, reduction, std) in both.into_iter().take(1 + usize::from(report.has_squares())) {
            let what = format!("{what}, slope x {factor}");
            rows.push(vec![what, with_std(reduction, std), explained(reduction)]);
        }
    }
    page.table(
        "Mean reduction of dynamic friction over the conditions; after ± of measured ones the standard deviation between \
         conditions, of modelled ones that of Young's modulus and measured flat friction.",
        &["what", "reduction in %", "share of the measured in %"],
        &rows,
    );
}

/// Mean reduction without an area law.
fn amontons(results: &[RatioReport]) -> Option<f64> {
    let found: Option<Vec<f64>> = results.iter().map(|row| Some(1.0 - row.ratio_amontons_coulomb?)).collect();
    found.filter(|found| !found.is_empty()).map(|found| found.iter().sum::<f64>() / found.len() as f64)
}

/// Modelled planform, with functions for the ratio and its standard deviation.
struct Planform {
    name: &'static str,
    cell: &'static str,
    ratio: fn(&ModelledRatio) -> (Option<f64>, Option<f64>),
}

const PLANFORMS: [Planform; 2] = [
    Planform { name: "grooves", cell: "in the plane", ratio: |model| (model.ratio_groove, model.ratio_groove_std) },
    Planform { name: "squares", cell: "in space", ratio: |model| (model.ratio_square, model.ratio_square_std) },
];

/// Adds measured ratios and the ratios of one planform.
fn ratios(page: &mut Page, report: &ValidationReport, planform: &Planform) {
    let results = &report.results;
    let is_one_condition =
        results.windows(2).all(|pair| speed_and_humidity(&pair[0].measured) == speed_and_humidity(&pair[1].measured));
    let mut header = vec!["force in N", "P in MPa"];
    if !is_one_condition {
        header.extend(["speed in mm/s", "humidity in %"]);
    }
    header.extend(["measured", "Amontons-Coulomb"]);
    let mut header: Vec<String> = header.into_iter().map(str::to_owned).collect();
    header.extend(report.slope_factors.iter().map(|factor| format!("slope x {}", plain(*factor))));
    let has_depth = results.iter().any(|row| row.modelled_at_measured_depth.is_some());
    if has_depth {
        header.push(format!("{} µm deep", plain(report.measured_depth_um)));
    }
    let cell = |model: Option<&ModelledRatio>| {
        let (ratio, std) = model.map_or((None, None), planform.ratio);
        with_error(ratio, std, 3)
    };
    let rows: Vec<Vec<String>> = results
        .iter()
        .map(|row| {
            let mut cells = condition(&row.measured);
            if is_one_condition {
                cells.truncate(2);
            }
            cells.push(with_error(row.measured.ratio, row.measured.ratio_std, 3));
            cells.push(number(row.ratio_amontons_coulomb, 3));
            cells.extend((0..report.slope_factors.len()).map(|n| cell(row.modelled.get(n))));
            if has_depth {
                cells.push(cell(row.modelled_at_measured_depth.as_ref()));
            }
            cells
        })
        .collect();
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    page.table(
        &format!(
            "Ratios with {}, dimensionless. Measured: ± one standard deviation. Modelled: the steady cell {}, cavities {} µm \
             deep where nothing else is said, at the slopes of the surface times a factor. {}.",
            planform.name,
            planform.cell,
            plain(report.pattern.depth_um),
            report.errors.replace("+-", "±")
        ),
        &header,
        &rows,
    );
}

/// Force, pressure, speed and humidity of a row.
fn condition(row: &MeasuredReport) -> Vec<String> {
    vec![plain(row.force_n), number(row.pressure_mpa, 3), plain(row.speed_mm_s), plain(row.humidity_pct)]
}

/// Quantities that rows of one condition share.
const fn speed_and_humidity(row: &MeasuredReport) -> [f64; 2] {
    [row.speed_mm_s, row.humidity_pct]
}

/// Adds peak pressures and the status of the solutions.
fn solves<'a>(page: &mut Page, report: &'a ValidationReport) {
    let solved = |row: &'a RatioReport| {
        let models = row.modelled.iter().map(|model| (report.pattern.depth_um, model));
        let deep = row.modelled_at_measured_depth.iter().map(|model| (report.measured_depth_um, model));
        models.chain(deep).map(|(depth_um, model)| (&row.measured, depth_um, model))
    };
    let solved: Vec<_> = report.results.iter().flat_map(solved).collect();
    let mut columns: Vec<Column<(&'a MeasuredReport, f64, &'a ModelledRatio)>> = vec![
        ("P in MPa", |(own, ..)| number(own.pressure_mpa, 3)),
        ("depth in µm", |(_, depth_um, _)| plain(*depth_um)),
        ("slope factor", |(.., model)| plain(model.slope_factor)),
        ("strip estimate", |(.., model)| number(model.ratio_square_estimate, 3)),
        ("peak, grooves, in MPa", |(.., model)| number(model.peak_pressure_mpa, 2)),
        ("peak, squares, in MPa", |(.., model)| number(model.peak_pressure_square_mpa, 2)),
        ("cavity closes", |(.., model)| yes_or_no(model.cavity_closed)),
        ("status", |(.., model)| match (&model.status, &model.status_square) {
            (grooves, squares) if grooves == squares => grooves.to_string(),
            (grooves, squares) => format!("{grooves}, {squares}"),
        }),
    ];
    let mut caption = "Behind these ratios. ".to_owned();
    if report.has_squares() {
        caption += "Strip estimate: squares taken from grooves, for comparison. ";
    } else {
        columns.retain(|(name, _)| !["strip estimate", "peak, squares, in MPa"].contains(name));
    }
    caption += "Peak pressures are those of blocks of 10 µm and grow as blocks shrink.";
    page.records(&caption, &solved, &columns);
}

/// Adds modelled friction coefficients on the surface as given.
fn friction(page: &mut Page, report: &ValidationReport) {
    let given: Vec<(&MeasuredReport, &ModelledRatio)> =
        report.results.iter().filter_map(|row| Some((&row.measured, row.at_slope(1.0)?))).collect();
    let columns: [Column<(&MeasuredReport, &ModelledRatio)>; 10] = [
        ("force in N", |(own, _)| plain(own.force_n)),
        ("P in MPa", |(own, _)| number(own.pressure_mpa, 3)),
        ("speed in mm/s", |(own, _)| plain(own.speed_mm_s)),
        ("humidity in %", |(own, _)| plain(own.humidity_pct)),
        ("flat, measured", |(own, _)| with_error(own.mu_flat, own.mu_flat_std, 3)),
        ("f(P)", |(_, model)| number(model.area_law_factor, 3)),
        ("local coefficient", |(_, model)| number(model.dynamic_mean, 3)),
        ("patterned, measured", |(own, _)| with_error(own.mu_patterned, own.mu_patterned_std, 3)),
        ("grooves, modelled", |(own, model)| {
            with_error(model.ratio_groove.map(|ratio| ratio * own.mu_flat), model.mu_groove_std, 3)
        }),
        ("squares, modelled", |(own, model)| {
            with_error(model.ratio_square.map(|ratio| ratio * own.mu_flat), model.mu_square_std, 3)
        }),
    ];
    page.records(
        "Dynamic friction coefficients, dimensionless, ± as above. The local coefficient is the measured flat one over f: the model's flat \
         surface slides as the measured one does.",
        &given,
        &columns[..9 + usize::from(report.has_squares())],
    );
}

fn published(page: &mut Page, published: &[PublishedReport]) {
    if published.is_empty() {
        return;
    }
    page.heading("What the paper says, and what is found here");
    page.paragraph(
        "The paper gives its simulated values in figures alone, and its altitude map not at all: what its text and tables \
         say is compared.",
    );
    page.records(
        "",
        published,
        &[
            ("quantity", |row| row.quantity.clone()),
            ("paper", |row| row.source.clone()),
            ("here", |row| row.here.clone()),
        ],
    );
}

fn areas(page: &mut Page, tables: &[AreaTable], outputs: &Outputs) {
    let Some(first) = tables.first() else { return };
    page.heading("Real contact area and the factor f");
    page.picture_of(
        outputs,
        "area-law.svg",
        "Real contact area and the factor f against nominal pressure, up to what edges of cavities see; dashed: area in \
         proportion to load from P0 on",
    );
    let mut header = vec!["P in MPa".to_owned()];
    for table in tables {
        let factor = plain(table.slope_factor);
        header.extend([format!("area, slope x {factor}"), format!("f, slope x {factor}")]);
    }
    let rows: Vec<Vec<String>> = first
        .pressure_mpa
        .iter()
        .enumerate()
        .map(|(row, pressure_mpa)| {
            let both =
                |table: &AreaTable| [&table.area_fraction, &table.factor].map(|of| number(of.get(row).copied(), 4));
            std::iter::once(plain(*pressure_mpa)).chain(tables.iter().flat_map(both)).collect()
        })
        .collect();
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    page.table(
        "Area: share of the nominal area, corrected along its perimeter. f = [A(P)/A(P0)] / [P/P0] above P0, 1 below. Both are \
         dimensionless.",
        &header,
        &rows,
    );
}

fn interface(page: &mut Page, outputs: &Outputs) {
    let captions = [
        (
            "interface.svg",
            "Flat and patterned sample in steady sliding, grooves; drawn local coefficients. The flat sample departs from the nominal pressure at its ends alone",
        ),
        ("interface-end.svg", "The same, the first periods enlarged"),
        ("interface-squares.svg", "Square cavities of the same lengths, one cell in space, seen from above"),
    ];
    if captions.iter().all(|(name, _)| outputs.text(name).is_none()) {
        return;
    }
    page.heading("Pressure along the interface");
    for (name, caption) in captions {
        page.picture_of(outputs, name, caption);
    }
}

fn in_time(page: &mut Page, report: &ValidationReport, run: &TimeReport, outputs: &Outputs) {
    page.heading("Friction in time");
    page.picture_of(
        outputs,
        "friction.svg",
        "Flat and patterned sample as grooves, from rest, with the averaging window",
    );
    // The transient run has the highest load at the condition of the first row.
    let rows = || report.results.iter().map(|row| &row.measured);
    let first = rows().next().map(speed_and_humidity);
    let alike = rows().filter(|row| Some(speed_and_humidity(row)) == first);
    let own = alike.max_by(|a, b| a.force_n.total_cmp(&b.force_n));
    let of = |value: fn(&MeasuredReport) -> (f64, f64)| {
        let (value, std) = own.map(value).unzip();
        with_error(value, std, 3)
    };
    let rows = [
        vec![
            "flat".to_owned(),
            of(|row| (row.mu_flat, row.mu_flat_std)),
            with_error(run.mu_flat, run.mu_flat_std, 4),
            with_error(run.mu_static_flat, run.mu_static_flat_std, 4),
            run.status_flat.to_string(),
        ],
        vec![
            "patterned".to_owned(),
            of(|row| (row.mu_patterned, row.mu_patterned_std)),
            with_error(run.mu_patterned, run.mu_patterned_std, 4),
            with_error(run.mu_static_patterned, run.mu_static_patterned_std, 4),
            run.status_patterned.to_string(),
        ],
        vec![
            "ratio".to_owned(),
            of(|row| (row.ratio, row.ratio_std)),
            with_error(run.ratio, run.ratio_std, 4),
            "-".to_owned(),
            "-".to_owned(),
        ],
    ];
    page.table(
        "Dynamic friction, dimensionless. Measured: ± one standard deviation of three repeats; modelled: ± one of \
         time average, local coefficients drawn, measured flat friction and Young's modulus.",
        &["surface", "measured", "modelled", "static peak, modelled", "status"],
        &rows,
    );
    page.paragraph(&format!(
        "{} MPa, {} mm/s, {} µm of travel; local coefficients {} dynamic and {} static (0.30/0.27 times it, the published \
         pair: no static friction was tabulated), scatter {} %. The flat sample lies a little above its measured friction \
         because sliding in time is micro-stick-slip, which calibrate corrects for and this comparison does not; the \
         ratio hardly notices.",
        number(run.pressure_mpa, 3),
        plain(run.speed_mm_s),
        plain(run.sliding_um),
        number(run.dynamic_mean, 4),
        number(run.static_mean, 4),
        percent(run.relative_std, 1),
    ));
}

fn measured(page: &mut Page, measured: &[MeasuredReport]) {
    if measured.is_empty() {
        return;
    }
    page.heading("All that was measured");
    page.records(
        "Dynamic friction coefficients, dimensionless, ± one standard deviation; of the ratio propagated.",
        measured,
        &[
            ("force in N", |row| plain(row.force_n)),
            ("P in MPa", |row| number(row.pressure_mpa, 3)),
            ("speed in mm/s", |row| plain(row.speed_mm_s)),
            ("humidity in %", |row| plain(row.humidity_pct)),
            ("flat", |row| with_error(row.mu_flat, row.mu_flat_std, 3)),
            ("patterned", |row| with_error(row.mu_patterned, row.mu_patterned_std, 3)),
            ("ratio", |row| with_error(row.ratio, row.ratio_std, 3)),
        ],
    );
}

#[cfg(test)]
mod tests {
    use super::super::fixture::report;
    use super::*;

    const SVG: &str = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"9\" height=\"9\"></svg>";

    fn assert_balanced(page: &str) {
        for tag in ["html", "head", "body", "main", "h1", "h2", "p", "ul", "li", "div", "figure", "figcaption", "svg"]
            .into_iter()
            .chain(["table", "caption", "thead", "tbody", "tr", "th", "td", "button", "style", "script", "title"])
        {
            let opened = page.matches(&format!("<{tag}>")).count() + page.matches(&format!("<{tag} ")).count();
            assert_eq!(opened, page.matches(&format!("</{tag}>")).count(), "{tag}");
        }
    }

    #[test]
    fn a_page_holds_measured_and_modelled_numbers_with_their_errors() {
        let mut outputs = Outputs::default();
        for name in ["ratios.svg", "area-law.svg", "interface.svg", "interface-squares.svg", "friction.svg"] {
            outputs.add(name, SVG);
        }
        let page = validation(&report(), &outputs);
        assert_balanced(&page);
        for said in [
            "<h1>a &lt;b&gt; &amp; &quot;c&quot;: measured and modelled</h1>",
            ">squares in space, slope x 1</td>",
            ">slope x 0.5</button>",
            ">10 µm deep</button>",
            "<td>0.875 ± 0.000</td>",
            "<td>0.2550 ± 0.0030</td>",
            "<td>0.250 ± 0.002</td>",
            "<td>no_onset</td>",
            "<td>0.0300</td>",
            "± of modelled values: nothing.",
            "scatter 5.0 %",
            "Pressure along the interface",
            "Depth of the measured cavities: 10 µm.",
        ] {
            assert!(page.contains(said), "{said}");
        }
        // All conditions have one speed and one humidity: the table of ratios does not repeat them.
        assert!(page.contains(">P in MPa</button></th><th scope=\"col\"><button type=\"button\">measured</button>"));
        let bare = page.replace("http://www.w3.org/2000/svg", "");
        assert!(!bare.contains("http") && !bare.contains("src="));
        assert_eq!(page, validation(&report(), &outputs));
    }

    #[test]
    fn a_run_in_time_stands_beside_what_was_measured_at_its_own_condition() {
        let mut report = report();
        let mut humid = report.results[1].clone();
        (humid.measured.humidity_pct, humid.measured.mu_flat) = (80.0, 0.303);
        report.results.push(humid);
        let page = validation(&report, &Outputs::default());
        assert!(page.contains("<td>flat</td><td>0.250 ± 0.002</td><td>0.2550 ± 0.0030</td>"), "{page}");
        assert!(page.contains(">humidity in %</button>"));
    }

    #[test]
    fn a_report_is_read_back_as_it_was_written() {
        let stored = slipgrid_design::results::json(&report()).unwrap();
        assert_eq!(serde_json::from_str::<ValidationReport>(&stored).unwrap(), report());
    }

    #[test]
    fn a_record_without_its_optional_parts_still_makes_a_page() {
        let mut without = report();
        without.synthetic_surface = false;
        without.in_time = None;
        without.summary.modelled.clear();
        (without.statements, without.published, without.area_laws) = (Vec::new(), Vec::new(), Vec::new());
        (without.measured, without.model) = (Vec::new(), Vec::new());
        for row in &mut without.results {
            row.modelled.clear();
            (row.ratio_amontons_coulomb, row.modelled_at_measured_depth) = (None, None);
        }
        let mut empty = without.clone();
        empty.results.clear();
        empty.slope_factors.clear();
        for report in [without, empty] {
            let page = validation(&report, &Outputs::default());
            assert_balanced(&page);
            for absent in
                ["Friction in time", "Real contact area", "What the paper says", "All that", "µm deep</b", "<li>"]
            {
                assert!(!page.contains(absent), "{absent}");
            }
        }
    }
}
