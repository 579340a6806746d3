//! The explorer: sliders that ask a response surface for what any design within the bounds does.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use maud::{Markup, PreEscaped, html};
use serde::Serialize;
use slipgrid_design::optimize::Bound;
use slipgrid_design::{ConstraintQuantity, DesignOutcome, Explorer};
use slipgrid_export::laser_time_s;
use slipgrid_statistics::ResponseSurface;
use slipgrid_units::LENGTH_UM;

use super::page::{Page, number};
use crate::Outputs;

const SCRIPT: &str = include_str!("explorer.js");
/// Names of the axes.
const LENGTHS: [&str; 3] = ["width", "spacing", "depth"];
/// Largest of the codes that coefficients are written as.
const FULL_SCALE: f64 = 65_535.0;

/// Numbers as 16-bit codes between two of them, in base64.
#[derive(Serialize)]
struct Packed {
    from: f64,
    to: f64,
    codes: String,
}

impl Packed {
    fn new(surface: &ResponseSurface) -> Self {
        let all = surface.coefficients();
        let from = all.iter().copied().fold(f64::INFINITY, f64::min);
        let to = all.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let span = if to > from { to - from } else { 1.0 };
        // Between 0 and the full scale: the cast is exact.
        let code = |value: &f64| (((value - from) / span * FULL_SCALE).round() as u16).to_le_bytes();
        let codes: Vec<u8> = all.iter().flat_map(code).collect();
        Self { from, to: from + span, codes: STANDARD.encode(codes) }
    }
}

#[derive(Serialize)]
struct AxisData {
    name: &'static str,
    from: f64,
    to: f64,
    nodes: usize,
}

/// A limit that the page can check.
#[derive(Serialize)]
struct LimitData {
    kind: &'static str,
    words: String,
    bound: f64,
    is_most: bool,
}

#[derive(Serialize)]
struct LaserData {
    time_s: f64,
    areal_density: f64,
    depth_um: f64,
}

#[derive(Serialize)]
struct PointData {
    kind: &'static str,
    at: [f64; 3],
}

#[derive(Serialize)]
struct Data {
    is_ratio: bool,
    axes: Vec<AxisData>,
    pressure_mpa: Vec<f64>,
    lowest: Vec<Option<f64>>,
    highest: Vec<Option<f64>>,
    flat_mu: Option<Vec<f64>>,
    values: Packed,
    log_peak: Packed,
    areal_density: Packed,
    offset: Vec<f64>,
    covariance: Vec<Vec<f64>>,
    limits: Vec<LimitData>,
    burst_um: Option<f64>,
    laser: Option<LaserData>,
    design: [f64; 3],
    points: Vec<PointData>,
    toml: String,
}

/// What limits of `found` the page can check.
fn limits(found: &DesignOutcome) -> Vec<LimitData> {
    let task = &found.task;
    let mut all = Vec::new();
    let made = &task.constraints.limits;
    for (kind, name, bound_m) in
        [("land", "the smallest land", made.min_land_m), ("spot", "the laser's spot", made.spot_m)]
    {
        let Some(bound) = bound_m.map(|m| LENGTH_UM.from_si(m)) else { continue };
        all.push(LimitData { kind, words: format!("{name}, {} µm", number(bound, 1)), bound, is_most: false });
    }
    for (quantity, limit) in task.quantities.iter().zip(&task.constraints.quantities) {
        let (kind, unit_si) = match quantity {
            ConstraintQuantity::PeakPressure => ("peak", 1e6),
            ConstraintQuantity::ArealDensity => ("density", 1.0),
            ConstraintQuantity::BearingArea => ("bearing", 1.0),
            ConstraintQuantity::LaserTime => ("laser", 60.0),
            _ => continue,
        };
        let bound = limit.bound.limit();
        if bound.is_finite() {
            let is_most = matches!(limit.bound, Bound::AtMost(_));
            let words = format!("{}, {}", limit.name, limit.tell(bound));
            all.push(LimitData { kind, words, bound: bound / unit_si, is_most });
        }
    }
    all
}

fn data(found: &DesignOutcome, explorer: &Explorer, outputs: &Outputs) -> Data {
    let (report, task) = (&found.report, &found.task);
    let axes = explorer.values.axes().iter().zip(LENGTHS);
    let count = report.target.pressure_mpa.len();
    let edge = |edges: &[Option<f64>]| (0..count).map(|row| edges.get(row).copied().flatten()).collect();
    let flat_mu: Option<Vec<f64>> = report.confirmed.iter().map(|load| load.mu_flat).collect();
    let laid = task.specimen.layout(found.pattern).ok();
    let laser = laid.and_then(|laid| {
        Some(LaserData {
            time_s: laser_time_s(&laid, &task.laser)?,
            areal_density: found.pattern.areal_density(),
            depth_um: LENGTH_UM.from_si(found.pattern.depth_m()),
        })
    });
    let listed = report.trade_offs.iter().flat_map(|found| &found.listed).map(|listed| &listed.design);
    let point = |kind: &'static str| {
        move |of: &slipgrid_results::PatternReport| PointData { kind, at: [of.width_um, of.spacing_um, of.depth_um] }
    };
    Data {
        is_ratio: report.is_ratio(),
        axes: axes.map(|(axis, name)| AxisData { name, from: axis.from, to: axis.to, nodes: axis.nodes }).collect(),
        pressure_mpa: report.target.pressure_mpa.clone(),
        lowest: edge(&report.target.lowest),
        highest: edge(&report.target.highest),
        flat_mu: flat_mu.filter(|all| all.len() == count),
        values: Packed::new(&explorer.values),
        log_peak: Packed::new(&explorer.log_peak),
        areal_density: Packed::new(&explorer.areal_density),
        offset: explorer.offset.clone(),
        covariance: explorer.covariance.iter().take(count).map(|row| row[..count.min(row.len())].to_vec()).collect(),
        limits: limits(found),
        burst_um: task.constraints.limits.depth_per_burst_m.map(|m| LENGTH_UM.from_si(m)),
        laser,
        design: [report.design.width_um, report.design.spacing_um, report.design.depth_um],
        points: listed.map(point("trade-off")).collect(),
        toml: outputs.text("design.toml").unwrap_or_default(),
    }
}

/// The explorer of `found`, where it was made.
pub(super) fn explorer(page: &mut Page, found: &DesignOutcome, outputs: &Outputs) {
    let Some(explorer) = &found.explorer else { return };
    let data = data(found, explorer, outputs);
    let Ok(json) = serde_json::to_string(&data) else { return };
    // Nothing in it may end the element that holds it.
    let json = json.replace("</", "<\\/").replace("<!--", "<\\u0021--");
    let quantity = if data.is_ratio { "ratio" } else { "dynamic friction" };
    let error = explorer.error;
    let words = format!(
        "What any design within the bounds would do, by a table of steady solutions: the {quantity} is off the solver's by {} in the \
         median and {} at worst over {} designs drawn at random. The pattern is taken as endless, corrected so that the design found has what \
         was predicted of it. Error band and chance take the errors of the design found.",
        number(error.median, 4),
        number(error.worst, 4),
        error.points,
    );
    page.add(&html! { div class="screen" { h2 { "Explore" } p { (words) } (controls(&data)) } });
    page.script(&format!(
        "<script type=\"application/json\" id=\"explorer-data\">{json}</script>\n<script>\n{SCRIPT}</script>"
    ));
}

fn controls(data: &Data) -> Markup {
    let free: Vec<usize> = (0..3).filter(|axis| data.axes[*axis].nodes > 1).collect();
    let pressures = &data.pressure_mpa;
    let (first, second) = if data.is_ratio { ("ratio", "mu") } else { ("mu", "ratio") };
    let reading = |name: &str, place: &str, unit: &str| {
        html! { div { dt { (name) } dd { (PreEscaped(format!("<span data-{place}></span>"))) @if !unit.is_empty() { " " (unit) } } } }
    };
    let pairs = [(0, 1), (0, 2), (1, 2)].into_iter().filter(|(a, b)| free.contains(a) && free.contains(b));
    html! {
        div id="explorer" class="explorer" hidden {
            div class="knobs" {
                @for axis in &free {
                    div class="knob" {
                        label for=(format!("x-{axis}")) { (data.axes[*axis].name) " in µm" }
                        input id=(format!("x-{axis}")) type="range" min="0" max="1000" step="1" data-slider=(axis);
                        input type="number" inputmode="decimal" step="0.1" min=(data.axes[*axis].from) max=(data.axes[*axis].to)
                            aria-label=(format!("{} in µm, as a number", data.axes[*axis].name)) data-number=(axis);
                    }
                }
                @if pressures.len() > 1 {
                    div class="knob" {
                        label for="x-p" { "pressure in MPa" }
                        input id="x-p" type="range" min=(pressures[0]) max=(pressures[pressures.len() - 1]) step="0.01" data-pressure;
                        span data-at {}
                    }
                }
                dl class="readings" {
                    (reading(first, "first", "")) (reading(second, "second", "")) (reading("chance on target", "chance", ""))
                    (reading("peak pressure", "peak", "MPa")) (reading("areal density", "density", "%"))
                    @if data.burst_um.is_some() { (reading("bursts (depth)", "bursts", "")) }
                    @if data.laser.is_some() { (reading("laser time", "minutes", "min")) }
                }
                p data-verdict aria-live="polite" {}
                p { button type="button" data-reset { "Back to the design found" } " " button type="button" data-copy { "Copy as a scene file" } }
                textarea data-toml hidden readonly rows="8" aria-label="The design as a scene for slipgrid simulate" {}
            }
            div class="views" {
                figure { div class="card" { svg data-curve viewBox="0 0 460 300" role="img" aria-label="Values against pressure with the target's band" font-family="sans-serif" font-size="13" fill="#333" {} }
                    figcaption { "Values against pressure: this design with one standard deviation, and the target's band" } }
                @if free.len() > 1 {
                    figure {
                        div class="card" { canvas data-map width="384" height="288" role="img" aria-label="Where designs are on target; the sliders choose the same" {} }
                        figcaption {
                            @if free.len() > 2 {
                                select data-pair aria-label="What the map shows" {
                                    @for (a, b) in pairs { option value=(format!("{a},{b}")) { (data.axes[a].name) " and " (data.axes[b].name) } }
                                }
                                " "
                            }
                            span data-across {} "; " span data-up {} ". Green: on target. Hatched: breaks a limit" span data-limits {} ". Diamond: the design found; grey: trade-offs; orange: chosen here. Click to choose."
                        }
                    }
                }
                figure { div class="card" { svg data-section viewBox="0 0 460 120" role="img" aria-label="Vertical section of two periods to scale" font-family="sans-serif" font-size="13" fill="#333" {} } }
            }
        }
    }
}
