//! HTML page of a comparison of speed and error.

use slipgrid_report::Outputs;
use slipgrid_report::html::page::{Page, number, sentence};

use super::difference::Quantity;
use super::report::{AccuracyReport, FrontReport, RowReport};
use super::text::{QUANTITIES, change, error_text, machine, method_cells, significant_digits};

const TERMS: [(&str, &str); 5] = [
    ("reference", "The published scheme with the smallest step: what every method is compared with."),
    (
        "error",
        "The value of a method minus that of the reference, in per cent of the latter; ± the standard error of that difference.",
    ),
    ("n.s.", "Not significant: the difference is no more than chance may make."),
    ("front", "Methods than which no other is both faster and at least as accurate."),
    ("default", "What the program does where nobody chooses; its name ends with a star."),
];

/// Makes the page of a comparison from its `report` and the picture in `outputs`.
#[must_use]
pub fn page(report: &AccuracyReport, outputs: &Outputs) -> String {
    let mut page = Page::default();
    let title = format!("Speed against error ({})", report.size);
    page.title(&title);
    let defaults = || report.fronts.iter().flat_map(|front| &front.defaults);
    page.lead(&format!(
        "In {} of {} comparisons nothing is both faster than the program's default and as accurate.",
        defaults().filter(|of| of.on_front).count(),
        defaults().count()
    ));
    for front in &report.fronts {
        page.paragraph(&format!(
            "In {}: errors below {} % cannot be told apart here and count as equal.",
            front.quantity,
            number(front.resolution_pct, 2)
        ));
    }
    if report.size == "quick" {
        page.warning("A quick comparison resolves large errors only: --full tells apart what counts as equal here.");
    }
    page.terms(&TERMS);
    page.picture_of(outputs, "accuracy.svg", "Wall time against error, both axes logarithmic; the line is the front");
    page.part("Fastest at each error", |page| report.fronts.iter().for_each(|front| of_front(page, front)));
    page.part("Methods", |page| methods(page, report));
    page.part("What was compared", |page| {
        page.list(&report.model.iter().map(|statement| sentence(statement)).collect::<Vec<_>>());
        page.paragraph(machine(report).trim_end());
    });
    page.finish(&title, report.version)
}

fn of_front(page: &mut Page, front: &FrontReport) {
    page.paragraph(&format!("In {}, fastest first: {}.", front.quantity, front.methods.join("; ")));
    let standing = |of: &super::report::DefaultReport| match (&of.better, &of.among_static) {
        (None, _) => "on the front".to_owned(),
        (Some(better), None) => format!("{better} is faster and no less accurate"),
        (Some(better), Some(among)) => {
            let among = among.better.as_ref().map_or_else(
                || "this one is on the front".to_owned(),
                |better| format!("{better} is faster and no less accurate"),
            );
            format!("{better} is faster and no less accurate but gives no static mu; among the methods that do {among}")
        }
    };
    let rows: Vec<Vec<String>> =
        front.defaults.iter().map(|of| vec![of.name.clone(), of.default_of.to_owned(), standing(of)]).collect();
    page.table(
        &format!("The program's defaults by their error in {}.", front.quantity),
        &["default", "of", "stands"],
        &rows,
    );
}

fn methods(page: &mut Page, report: &AccuracyReport) {
    // Replaces signs of plain text by the page's signs.
    let cell = |text: String| text.replace("+-", "±");
    let starred = |row: &RowReport| {
        let mut cells = method_cells(row);
        cells[0] = if row.default_of.is_some() { format!("{} *", row.name) } else { row.name.clone() };
        cells.into_iter().map(cell).collect::<Vec<String>>()
    };
    let rows: Vec<Vec<String>> = std::iter::once(&report.reference).chain(&report.methods).map(starred).collect();
    page.table(
        "Errors against the reference in per cent. Seconds: one draw, both surfaces, on one thread with a core to itself.",
        &["method", "step in ns", "site updates", "dynamic mu", "static mu", "ratio", "status", "seconds", "updates/s"],
        &rows,
    );
    page.fold("The reference itself", |page| {
        let known = QUANTITIES.into_iter().filter_map(|quantity| Some((quantity, report.reference.value(quantity)?)));
        let rows = known.map(|(quantity, value)| {
            vec![quantity.name().to_owned(), number(value.value, 5), number(value.stderr, 5), number(value.std, 5)]
        });
        page.table("", &["quantity", "mean", "±", "from draw to draw"], &rows.collect::<Vec<_>>());
    });
    page.fold("Blocks: change from the finest, per cent", |page| {
        let row = |row: &RowReport| {
            let mut cells = vec![row.name.clone()];
            cells.extend([Quantity::MuDynamic, Quantity::Ratio].map(|quantity| change(row.value(quantity))));
            cells.extend([row.status.clone(), significant_digits(row.wall_s)]);
            cells
        };
        page.table(
            "",
            &["method", "dynamic mu", "ratio", "status", "seconds"],
            &report.discretization.iter().map(row).collect::<Vec<_>>(),
        );
    });
    page.fold("Choices of the model: change of the answer, per cent", |page| {
        let row = |row: &RowReport| {
            let mut cells = vec![row.name.clone()];
            cells.extend(QUANTITIES.map(|quantity| cell(error_text(row.value(quantity)))));
            cells.push(row.status.clone());
            cells
        };
        page.table(
            "No errors: each row is another scene.",
            &["choice", "dynamic mu", "static mu", "ratio", "status"],
            &report.choices.iter().map(row).collect::<Vec<_>>(),
        );
    });
    page.fold("Scatter from draw to draw", |page| {
        let known = QUANTITIES.into_iter().filter_map(|quantity| Some((quantity, report.scatter.value(quantity)?)));
        let rows = known.map(|(quantity, value)| {
            let percent = value.std.map(|std| 100.0 * std / value.value);
            vec![quantity.name().to_owned(), number(value.value, 5), number(value.std, 5), number(percent, 2)]
        });
        page.table(
            &format!("{} draws of the local coefficients.", report.scatter.seeds),
            &["quantity", "mean", "standard deviation", "in %"],
            &rows.collect::<Vec<_>>(),
        );
    });
}
