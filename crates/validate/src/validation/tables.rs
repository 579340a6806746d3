//! Tables of a validation, equal on the screen and on the page.

use slipgrid_design::results::{Records, Table, with_error};
use slipgrid_report::html::page::{number, percent, plain};

use super::laws::ScaledLaw;
use super::ratios::{MeasuredLawRatio, MeasuredReport, ModelledRatio, RatioReport};
use super::report::{PublishedReport, TimeReport, ValidationReport};

/// Table with its caption.
pub type Captioned = (String, Table);

/// Modelled planform: name, dimension in which the cell is solved, in words, and functions that return the numbers of
/// the planform.
pub struct Planform {
    name: &'static str,
    cell: &'static str,
    /// Ratio and its standard deviation.
    ratio: fn(&ModelledRatio) -> [Option<f64>; 2],
    mu_std: fn(&ModelledRatio) -> Option<f64>,
    by_measured_law: fn(&MeasuredLawRatio) -> Option<f64>,
}

const PLANFORMS: [Planform; 2] = [
    Planform {
        name: "grooves",
        cell: "in the plane",
        ratio: |model| [model.ratio_groove, model.ratio_groove_std],
        mu_std: |model| model.mu_groove_std,
        by_measured_law: |law| law.ratio_groove,
    },
    Planform {
        name: "squares",
        cell: "in space",
        ratio: |model| [model.ratio_square, model.ratio_square_std],
        mu_std: |model| model.mu_square_std,
        by_measured_law: |law| law.ratio_square,
    },
];

/// Planforms that are shown for `report`: grooves, and squares unless the samples were cut as grooves.
pub fn planforms(report: &ValidationReport) -> &'static [Planform] {
    &PLANFORMS[..1 + usize::from(report.has_squares())]
}

/// Adds the columns of force and pressure and, if `has_speeds`, of speed and humidity.
fn condition<T>(table: &mut Records<'_, T>, has_speeds: bool, of: impl Fn(&T) -> &MeasuredReport) {
    table.column("force in N", |row| plain(of(row).force_n));
    table.column("P in MPa", |row| number(of(row).pressure_mpa, 3));
    if has_speeds {
        table.column("speed in mm/s", |row| plain(of(row).speed_mm_s));
        table.column("humidity in %", |row| plain(of(row).humidity_pct));
    }
}

/// Table of the mean reductions, measured and modelled.
pub fn summary(report: &ValidationReport) -> Captioned {
    let summary = &report.summary;
    let measured = summary.reduction_measured;
    let mut table = Table::new(["reduction", "in %", "share of the measured in %"]);
    let mut row = |name: String, reduction: Option<f64>, std: Option<f64>| {
        let [in_percent, std] = [reduction, std].map(|share| share.map(|share| 100.0 * share));
        let explained = reduction.filter(|_| measured > 0.0).map(|reduction| reduction / measured);
        table.row([name, with_error(in_percent, std, 1), percent(explained, 0)]);
    };
    row("measured".to_owned(), Some(measured), summary.reduction_measured_std);
    row("Amontons-Coulomb friction".to_owned(), amontons(&report.results), None);
    for model in &summary.modelled {
        row(format!("grooves, slope x {}", model.slope_factor), model.groove, model.groove_std);
        if report.has_squares() {
            row(format!("squares in space, slope x {}", model.slope_factor), model.square, model.square_std);
        }
    }
    let caption = "Mean reduction of dynamic friction over the conditions; after +- of measured ones the standard deviation \
                   between conditions, of modelled ones that of Young's modulus and measured flat friction.";
    (caption.to_owned(), table)
}

/// Mean modelled reduction without an area law; `None` unless all solutions converged.
fn amontons(results: &[RatioReport]) -> Option<f64> {
    let found: Option<Vec<f64>> = results.iter().map(|row| Some(1.0 - row.ratio_amontons_coulomb?)).collect();
    found.filter(|found| !found.is_empty()).map(|found| found.iter().sum::<f64>() / found.len() as f64)
}

/// Table of measured ratios and of the modelled ratios of one planform.
pub fn ratios(report: &ValidationReport, planform: &Planform) -> Captioned {
    let cell = |model: Option<&ModelledRatio>| {
        let [ratio, std] = model.map_or([None; 2], planform.ratio);
        with_error(ratio, std, 3)
    };
    let mut table = Table::of(&report.results);
    condition(&mut table, !report.has_one_condition(), |row| &row.measured);
    table.column("measured", |row| with_error(row.measured.ratio, row.measured.ratio_std, 3));
    table.column("Amontons-Coulomb", |row| number(row.ratio_amontons_coulomb, 3));
    for &factor in &report.slope_factors {
        table.column(format!("slope x {factor}"), |row| cell(row.at_slope(factor)));
    }
    if report.results.iter().any(|row| row.modelled_at_measured_depth.is_some()) {
        let name = format!("{} um deep", report.measured_depth_um);
        table.column(name, |row| cell(row.modelled_at_measured_depth.as_ref()));
    }
    let caption = if planform.name == PLANFORMS[0].name {
        format!(
            "Ratios patterned over flat with {}, dimensionless. Measured: +- one standard deviation. Modelled: the steady cell {}, \
             cavities {} um deep where nothing else is said, at the slopes of the surface times a factor. {}.",
            planform.name, planform.cell, report.pattern.depth_um, report.errors
        )
    } else {
        format!("The same with {}, modelled by the steady cell {}.", planform.name, planform.cell)
    };
    (caption, table.table())
}

/// Table of ratios with measured flat friction as the local law; no rows if no condition has such a ratio.
pub fn by_measured_law(report: &ValidationReport) -> Captioned {
    let rows: Vec<&RatioReport> = report.results.iter().filter(|row| !row.measured_law.is_empty()).collect();
    let mut table = Table::of(&rows);
    condition(&mut table, !report.has_one_condition(), |row| &row.measured);
    table.column("measured", |row| with_error(row.measured.ratio, row.measured.ratio_std, 3));
    let laws = rows.first().map_or(&[][..], |row| &row.measured_law);
    for (place, law) in laws.iter().enumerate() {
        for planform in planforms(report) {
            let ratio = |row: &&RatioReport| (planform.by_measured_law)(&row.measured_law[place]);
            table.column(format!("{}, {}", planform.name, law.extrapolation), |row| number(ratio(row), 3));
        }
    }
    let caption = "Modelled ratios where measured flat friction itself is the local law, mu(p) = mu_flat(P = p); constant or \
                   logarithmic above the last measured pressure.";
    (caption.to_owned(), table.table())
}

/// Solution at one condition: result with the measurement, depth of the cavities in um, and modelled ratios.
pub type Solution<'a> = (&'a RatioReport, f64, &'a ModelledRatio);

/// Solutions of `report` at every slope factor, and at the measured depth.
pub fn solutions(report: &ValidationReport) -> Vec<Solution<'_>> {
    let each = report.results.iter().flat_map(|row| {
        let RatioReport { modelled, modelled_at_measured_depth, .. } = row;
        let deep = modelled_at_measured_depth.iter().map(move |model| (row, report.measured_depth_um, model));
        modelled.iter().map(move |model| (row, report.pattern.depth_um, model)).chain(deep)
    });
    each.collect()
}

/// Table of the peak pressures and the status of the solutions.
pub fn solves(report: &ValidationReport) -> Captioned {
    let solutions = solutions(report);
    let mut table = Table::of(&solutions);
    table.column("P in MPa", |(row, ..)| number(row.measured.pressure_mpa, 3));
    table.column("depth in um", |(_, depth_um, _)| plain(*depth_um));
    table.column("slope factor", |(.., model)| plain(model.slope_factor));
    let mut caption = "Behind these ratios. ".to_owned();
    if report.has_squares() {
        caption += "Strip estimate: squares taken from grooves, for comparison. ";
        table.column("strip estimate", |(.., model)| number(model.ratio_square_estimate, 3));
    }
    table.column("peak, grooves, in MPa", |(.., model)| number(model.peak_pressure_mpa, 2));
    if report.has_squares() {
        table.column("peak, squares, in MPa", |(.., model)| number(model.peak_pressure_square_mpa, 2));
    }
    table.column("cavity closes", |(.., model)| if model.cavity_closed { "yes" } else { "no" }.to_owned());
    table.column("status", |(.., model)| match [model.status, model.status_square] {
        [grooves, squares] if grooves == squares => grooves.to_owned(),
        both => both.join(", "),
    });
    caption += "Peak pressures are those of blocks of 10 um and grow as blocks shrink.";
    (caption, table.table())
}

/// Table of friction coefficients, measured and modelled for the surface as given.
pub fn friction(report: &ValidationReport) -> Captioned {
    let mut table = Table::of(&report.results);
    condition(&mut table, true, |row| &row.measured);
    table.column("flat, measured", |row| with_error(row.measured.mu_flat, row.measured.mu_flat_std, 3));
    table.column("f(P)", |row| number(row.given().map(|model| model.area_law_factor), 3));
    table.column("local coefficient", |row| number(row.given().map(|model| model.dynamic_mean), 3));
    table.column("patterned, measured", |row| with_error(row.measured.mu_patterned, row.measured.mu_patterned_std, 3));
    for planform in planforms(report) {
        table.column(format!("{}, modelled", planform.name), |row| {
            let ratio = row.given().and_then(|model| (planform.ratio)(model)[0]);
            with_error(ratio.map(|ratio| ratio * row.measured.mu_flat), row.given().and_then(planform.mu_std), 3)
        });
    }
    let caption = "Dynamic friction coefficients, dimensionless, +- as above. The local coefficient is the measured flat one over f: the \
                   model's flat surface slides as the measured one does.";
    (caption.to_owned(), table.table())
}

/// Table of the statements of the source, with the corresponding results.
pub fn published(published: &[PublishedReport]) -> Table {
    let mut table = Table::of(published);
    table.column("quantity", |row| row.quantity.clone());
    table.column("paper", |row| row.source.clone());
    table.column("here", |row| row.here.clone());
    table.table()
}

/// Table of contact area and area factor f at every slope factor, at the pressures of the first of `tables`.
pub fn areas(tables: &[ScaledLaw]) -> Captioned {
    let pressures_mpa = tables.first().map_or(&[][..], |table| &table.pressure_mpa);
    let rows: Vec<(usize, &f64)> = pressures_mpa.iter().enumerate().collect();
    let mut table = Table::of(&rows);
    table.column("P in MPa", |(_, pressure_mpa)| plain(**pressure_mpa));
    for ScaledLaw { slope_factor, area_fraction, factor, .. } in tables {
        for (name, values) in [("area", area_fraction), ("f", factor)] {
            table.column(format!("{name}, slope x {slope_factor}"), |(row, _)| number(values.get(*row).copied(), 4));
        }
    }
    let caption = "Area: share of the nominal area, corrected along its perimeter. f = [A(P)/A(P0)] / [P/P0] above P0, 1 below. Both \
                   are dimensionless.";
    (caption.to_owned(), table.table())
}

/// Table of the friction of the transient run, and of the friction measured at the load of the run.
pub fn in_time(report: &ValidationReport, run: &TimeReport) -> Captioned {
    // The transient run has the highest load at the condition of the first row.
    let rows = report.by_pressure();
    let own = |value: fn(&MeasuredReport) -> [f64; 2]| {
        rows.last().map_or_else(
            || "-".to_owned(),
            |row| {
                let [value, std] = value(&row.measured);
                with_error(value, std, 3)
            },
        )
    };
    let mut table = Table::new(["surface", "measured", "modelled", "static peak, modelled", "status"]);
    let four = |value: Option<f64>, std: Option<f64>| with_error(value, std, 4);
    table.row([
        "flat".to_owned(),
        own(|row| [row.mu_flat, row.mu_flat_std]),
        four(run.mu_flat, run.mu_flat_std),
        four(run.mu_static_flat, run.mu_static_flat_std),
        run.status_flat.to_string(),
    ]);
    table.row([
        "patterned".to_owned(),
        own(|row| [row.mu_patterned, row.mu_patterned_std]),
        four(run.mu_patterned, run.mu_patterned_std),
        four(run.mu_static_patterned, run.mu_static_patterned_std),
        run.status_patterned.to_string(),
    ]);
    let ratio = own(|row| [row.ratio, row.ratio_std]);
    table.row(["ratio".to_owned(), ratio, four(run.ratio, run.ratio_std), "-".to_owned(), "-".to_owned()]);
    let caption = "Dynamic friction, dimensionless. Measured: +- one standard deviation of three repeats; modelled: +- one of time \
                   average, local coefficients drawn, measured flat friction and Young's modulus.";
    (caption.to_owned(), table)
}

/// Table of all conditions that were measured on both samples.
pub fn measured(rows: &[MeasuredReport]) -> Captioned {
    let mut table = Table::of(rows);
    condition(&mut table, true, |row| row);
    table.column("flat", |row| with_error(row.mu_flat, row.mu_flat_std, 3));
    table.column("patterned", |row| with_error(row.mu_patterned, row.mu_patterned_std, 3));
    table.column("ratio", |row| with_error(row.ratio, row.ratio_std, 3));
    let caption = "Dynamic friction coefficients, dimensionless, +- one standard deviation; of the ratio propagated.";
    (caption.to_owned(), table.table())
}
