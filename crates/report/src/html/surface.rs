//! Page of an altitude map: parameters, limits of the parameters, and warnings.

use super::page::{Page, micrometres, number, percent, sentence};
use crate::Outputs;
use crate::surface::{Parameter, SurfaceReport};
use slipgrid_base::units::LENGTH_UM;
use slipgrid_design::results::Table;
use slipgrid_surface::topography::{LIMITED_BY_PIXELS, SpectrumBin};

/// The size of the map limits the height parameters if the longest waves have more than this share of the squared
/// height.
const LIMITED_BY_SIDE: f64 = 0.4;
/// Share of missing points above which the page mentions them.
const MANY_MISSING: f64 = 0.01;

/// Symbols and meanings of the surface texture parameters.
const MEANINGS: [(&str, &str); 17] = [
    ("Sa", "mean distance of the heights from their mean"),
    ("Sq", "root mean square of the same"),
    ("Ssk", "skewness of the heights: below 0 where few valleys are deep"),
    ("Sku", "their kurtosis: 3 of normally distributed heights, more with single peaks or valleys"),
    ("Sp", "highest peak above the mean"),
    ("Sv", "deepest valley below it"),
    ("Sz", "both together"),
    ("Sdq", "root mean square slope from one point to its neighbours"),
    ("rms slope", "the same by the spectrum, of all waves that the map resolves: the area law takes this one"),
    ("Sdr", "surface area beyond that of the map's plane"),
    ("Sk", "height of the core, by the bearing curve"),
    ("Spk", "height of the peaks above the core"),
    ("Svk", "depth of the valleys below it"),
    ("Smr1", "share of the surface above the core"),
    ("Smr2", "share of the surface above the core's lower end"),
    ("Sal", "distance over which heights are forgotten: their autocorrelation has fallen to 0.2"),
    ("Str", "shortest over longest such distance: 1 alike in all directions, near 0 with a lay"),
];

/// Makes the page of a map from its `report` and the pictures in `outputs`.
pub fn surface(report: &SurfaceReport, outputs: &Outputs) -> String {
    let mut page = Page::default();
    let name = report.map.rsplit(['/', '\\']).next().unwrap_or_default();
    let title = format!("{name}: altitude map");
    page.title(&title);
    page.beside_picture(
        |page| {
            verdict(page, report);
            doubts(page, report);
        },
        |page| {
            page.picture_of(outputs, "map.svg", "Heights seen from above; the arrow at the right marks the section. The colours leave out the highest and lowest 0.05 %");
        },
    );
    page.part("What limits the parameters", |page| page.list(&limits(report)));
    page.part("Parameters", |page| parameters(page, report));
    if let Some(cavities) = &report.cavities {
        page.part("Cavities", |page| {
            page.table(
                "Cavities: mean, standard deviation from one to the next, and how many were measured.",
                &cavities.lengths(),
            );
            page.table("Edges and floors, with their standard errors.", &cavities.edges());
            page.list(&cavities.words().iter().map(|words| words.replace(" deg ", " ° ")).collect::<Vec<_>>());
            page.picture_of(
                outputs,
                "edge-profile.svg",
                "Land before the edges of cavities: mean height against the distance from the edge",
            );
        });
    }
    page.part("Heights and waves", |page| {
        page.picture_of(
            outputs,
            "histogram.svg",
            "How often heights occur, and the share of the surface at or above a height",
        );
        page.picture_of(
            outputs,
            "section.svg",
            "Height along the section that the map marks; heights are far from to scale",
        );
        page.picture_of(outputs, "spectrum.svg", "Power against wave number, both axes logarithmic");
    });
    page.part("What was done to the map", |page| page.sentences(&report.model));
    page.finish(&title, &report.made_by.version)
}

fn verdict(page: &mut Page, report: &SurfaceReport) {
    let value = |symbol: &str, digits| number(report.parameter(symbol), digits);
    page.marked("chance", &format!("Rms slope {}, Sq {} µm.", value("rms slope", 4), value("Sq", 3)));
    page.paragraph("The rms slope decides real contact area and with it the area law; heights alone decide neither.");
    let side = |count: usize, pixel_um: f64| number(count as f64 * pixel_um * 1e-3, 3);
    let [dx, dy] = report.pixel_um;
    let mut rows: Vec<(&str, String)> = vec![
        ("sides", format!("{} mm by {} mm", side(report.columns, dx), side(report.rows, dy))),
        ("pixels", format!("{} by {}, of {} µm by {} µm", report.columns, report.rows, number(dx, 3), number(dy, 3))),
        ("missing points", report.missing_points.to_string()),
        ("Sa", format!("{} µm", value("Sa", 3))),
        ("highest peak, deepest valley", format!("{} µm, {} µm", value("Sp", 2), value("Sv", 2))),
    ];
    rows.extend(
        report.parameter("Sal").map(|sal_um| ("heights are forgotten over (Sal)", format!("{} µm", number(sal_um, 1)))),
    );
    rows.extend(report.parameter("Str").map(|ratio| ("alike in all directions (Str)", number(ratio, 2))));
    rows.extend(report.cavities.as_ref().map(|cavities| ("cavities", cavities.summary())));
    rows.push(("file", format!("{} ({})", report.map, report.format)));
    page.facts("The map", &rows);
}

/// Adds warnings, the most serious first.
fn doubts(page: &mut Page, report: &SurfaceReport) {
    let mut all = Vec::new();
    if report.synthetic_surface {
        all.push("The map is synthetic: nothing here was measured.".to_owned());
    }
    all.extend(report.warnings.iter().map(|warning| format!("Doubtful: {warning}.")));
    let missing = report.missing_points as f64 / (report.rows * report.columns).max(1) as f64;
    if missing > MANY_MISSING {
        all.push(format!("{} % of the points are missing and were filled.", percent(missing, 1)));
    }
    page.doubts(&all);
}

/// Describes how pixel size and map size limit the parameters.
fn limits(report: &SurfaceReport) -> Vec<String> {
    let mut all = Vec::new();
    if let Some(short) = &report.short_waves {
        let words = if short.slope_share > LIMITED_BY_PIXELS {
            "finer pixels would find a higher one, and an area law from this map holds for these pixels"
        } else {
            "finer pixels would change it little unless the surface has more below them"
        };
        all.push(format!(
            "Rms slope and Sdq: {} % of the squared slope lies in waves shorter than {} µm, four pixels. Here {words}.",
            percent(short.slope_share, 0),
            number(LENGTH_UM.from_si(short.below_m), 2)
        ));
    }
    // The contribution of a ring to the squared height is proportional to the number of its waves times their density.
    let length_um = |ring: &SpectrumBin| LENGTH_UM.from_si(std::f64::consts::TAU / ring.q_per_m);
    let longest_um = report.spectrum.iter().map(length_um).fold(0.0, f64::max);
    let squares = |from_um: f64| -> f64 {
        let rings = report.spectrum.iter().filter(|ring| length_um(ring) > from_um);
        rings.map(|ring| ring.waves * ring.psd_m4).sum()
    };
    let whole = squares(0.0);
    if whole > 0.0 {
        let height = squares(0.5 * longest_um) / whole;
        let words = if height > LIMITED_BY_SIDE {
            "a larger map would find higher ones, and what form was subtracted decides them"
        } else {
            "the map is large enough for them"
        };
        all.push(format!(
            "Sa and Sq: {} % of the squared height lies in waves longer than {} µm, half the longest. Here {words}.",
            percent(height, 0),
            number(0.5 * longest_um, 0)
        ));
    }
    if report.parameter("Sal").is_none() {
        all.push("Sal and Str: heights are still correlated over half the map. The map is too small for them, or a form was left in it.".to_owned());
    }
    all.push(
        "Sp, Sv and Sz are single points: they grow with the map, and with every spike that is left in it.".to_owned(),
    );
    all
}

fn parameters(page: &mut Page, report: &SurfaceReport) {
    let meaning = |symbol: &str| MEANINGS.iter().find(|(own, _)| *own == symbol).map_or("", |(_, meaning)| *meaning);
    let mut table = Table::of(&report.parameters);
    table.column("parameter", |of| of.symbol.to_owned());
    table.column("value", Parameter::digits);
    table.column("unit", |of| of.unit.to_owned());
    table.column("what it is", |of| meaning(of.symbol).to_owned());
    page.table(
        &format!(
            "Parameters of ISO 25178-2, and the rms slope by the spectrum. {}",
            micrometres(&sentence(&report.filters.in_words()))
        ),
        &table.table(),
    );
}
