//! Page of a validation: measurements and statements of the source, with tables and figures of the model.

use slipgrid_report::Outputs;
use slipgrid_report::html::page::{Page, number, percent, plain};

use super::report::{TimeReport, ValidationReport};
use super::rims;
use super::tables::{self, Captioned, planforms};

/// Makes the HTML page of a validation from its `report` and the pictures in `outputs`.
pub fn validation(report: &ValidationReport, outputs: &Outputs) -> String {
    let mut page = Page::default();
    let title = format!("{}: measured and modelled", report.name);
    page.title(&title);
    page.paragraph(&format!("Measurements: {}. Nothing was tuned to the patterned samples.", report.source));
    if let Some(trial) = &report.trial {
        page.paragraph(&format!("Compared is the trial \"{trial}\", as grooves of its lengths."));
    }
    if report.synthetic_surface {
        page.marked("warning", 
            "The altitude map behind the area law is synthetic, not measured: measured are the friction coefficients and the \
             pattern's dimensions alone. Read the spread between slopes of the surface as the model's uncertainty.",
        );
    }
    let add = |page: &mut Page, (caption, table): Captioned| page.table(&caption, &table);
    page.heading("What the comparison says");
    page.list(&report.statements);
    add(&mut page, tables::summary(report));
    page.heading("Ratio patterned over flat");
    let squares = if report.has_squares() { ", and as squares" } else { "" };
    page.picture_of(
        outputs,
        "ratios.svg",
        &format!(
            "Measured with standard deviations; the modified law as grooves at the surface's slope and scaled{squares}; \
             Amontons-Coulomb friction (dashed) has no effect"
        ),
    );
    for planform in planforms(report) {
        add(&mut page, tables::ratios(report, planform));
    }
    for table in [tables::solves(report), tables::friction(report), tables::by_measured_law(report)] {
        add(&mut page, table);
    }
    if let Some(rims) = &report.rims {
        page.heading("What rims of unknown height can and cannot explain");
        page.list(&rims.statements);
        page.picture_of(outputs, "rims.svg", "Measured ratios beside those of squares with rims of one height");
        add(&mut page, rims::table(rims));
    }
    page.part("What the paper says, and what is found here", |page| {
        let caption = "The paper gives its simulated values in figures alone, and its altitude map not at all: what its text and \
                       tables say is compared.";
        page.table(caption, &tables::published(&report.published));
    });
    page.part("Real contact area and the factor f", |page| {
        page.picture_of(
            outputs,
            "area-law.svg",
            "Real contact area and the factor f against nominal pressure, up to what edges of cavities see; dashed: area in \
             proportion to load from P0 on",
        );
        add(page, tables::areas(&report.area_laws));
    });
    page.part("Pressure along the interface", |page| {
        for (name, caption) in INTERFACES {
            page.picture_of(outputs, name, caption);
        }
    });
    if let Some(run) = &report.in_time {
        page.heading("Friction in time");
        page.picture_of(
            outputs,
            "friction.svg",
            "Flat and patterned sample as grooves, from rest, with the averaging window",
        );
        add(&mut page, tables::in_time(report, run));
        page.paragraph(&time_words(run));
    }
    page.part("All that was measured", |page| add(page, tables::measured(&report.measured)));
    page.heading("The modelled pattern");
    page.section(&report.pattern, true);
    page.paragraph(&format!("Depth of the measured cavities: {} µm.", plain(report.measured_depth_um)));
    page.model([&report.model, &[]], false);
    page.finish(&title, &report.made_by.version)
}

/// Pictures of the interface with their captions.
const INTERFACES: [(&str, &str); 3] = [
    (
        "interface.svg",
        "Flat and patterned sample in steady sliding, grooves; drawn local coefficients. The flat sample departs from the nominal pressure at its ends alone",
    ),
    ("interface-end.svg", "The same, the first periods enlarged"),
    ("interface-squares.svg", "Square cavities of the same lengths, one cell in space, seen from above"),
];

/// Describes the input of the transient run, and why its flat friction differs from the measurement.
fn time_words(run: &TimeReport) -> String {
    format!(
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
    )
}

#[cfg(test)]
mod tests {
    use super::super::report_for_tests::report;
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
