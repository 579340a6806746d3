//! Explorer of designs: sliders that interpolate the expected values of any design within the bounds.

mod surfaces;

use maud::{Markup, PreEscaped, html};
use serde::Serialize;
use serde_json::{Value, json};
use slipgrid_base::units::LENGTH_UM;
use slipgrid_design::optimize::{Bound, Quantity};
use slipgrid_design::records::TargetReport;
use slipgrid_design::results::{BELIEVED, PatternReport, Table, VERSION, believed, believed_interval};
use slipgrid_design::{
    ConstraintQuantity, DesignOutcome, DesignReport, DesignTask, Explored, Explorer, KnownMaterial,
    percent as chance_words,
};
use slipgrid_model::pattern::Pattern;
use slipgrid_model::springblock::Load;

use self::surfaces::{AxisData, Exposures, LENGTHS, Packed, axes_data, face_data};
use super::page::{Page, number};
use super::points::{Point, in_words};
use crate::Outputs;

const SCRIPT: &str = include_str!("explorer.js");

#[derive(Serialize)]
struct Data {
    is_ratio: bool,
    axes: Vec<AxisData>,
    pressure_mpa: Vec<f64>,
    /// Lowest accepted value at each pressure; null without a lower limit.
    lowest: Vec<Option<f64>>,
    highest: Vec<Option<f64>>,
    flat_mu: Vec<f64>,
    /// Cavity fractions of the face over that of a period between which all surfaces below but the last have as many
    /// outputs as nodes.
    shares: [f64; 2],
    /// Number of nodes of the medians and intervals between `shares`.
    share_nodes: usize,
    /// Specimen and lattice, to count cavities; null to interpolate the last two outputs of `beside`.
    face: Option<Value>,
    /// Median over samples at each load of each condition, the design condition first; at each node of `shares`.
    medians: Packed,
    /// Lower end of the 95 % interval of samples at each load of the design condition.
    lower: Packed,
    /// Upper end of the 95 % interval of samples at each load of the design condition.
    upper: Packed,
    /// Outputs as of [`Explorer::odds`].
    odds: Packed,
    /// Outputs as of [`Explorer::beside`]; the last two only without `face`.
    beside: Packed,
    /// Indices of the nodes of the surfaces at which the model gives no result.
    holes: Vec<usize>,
    limits: Vec<Value>,
    /// Depth and time of one exposure; null if unknown.
    exposures: Option<Exposures>,
    /// Range of values that are believed; ends of intervals outside are not printed as numbers.
    believed: [f64; 2],
    design: [f64; 3],
    points: Vec<Point>,
    toml: String,
}

impl Data {
    /// Whether the map shows points of `kind`: `found`, `trade-off` or `trial`.
    fn shows(&self, kind: &str) -> bool {
        self.points.iter().any(|point| point.on_map && point.kind == kind)
    }

    fn has_target(&self) -> bool {
        self.lowest.iter().chain(&self.highest).any(Option::is_some)
    }
}

/// Task whose designs a page explores, with the predictions.
pub(super) struct Subject<'a> {
    pub(super) task: &'a DesignTask,
    pub(super) material: &'a KnownMaterial,
    pattern: &'a Pattern,
    pub(super) explorer: &'a Explorer,
    /// Design found, if a search was run.
    pub(super) report: Option<&'a DesignReport>,
    /// Dynamic friction coefficient of the flat surface at each target pressure.
    pub(super) flat_mu: &'a [f64],
    /// Scene file with the initial pattern.
    toml: String,
}

impl Subject<'_> {
    /// Limits that the script of the page checks.
    fn limits(&self) -> Vec<Value> {
        let task = self.task;
        let mut all = Vec::new();
        let made = &task.constraints.limits;
        for (kind, name, bound_m) in
            [("land", "the smallest land", made.min_land_m), ("spot", "the laser's spot", made.spot_m)]
        {
            let Some(bound) = bound_m.map(|m| LENGTH_UM.from_si(m)) else { continue };
            let words = format!("{name}, {} µm", number(bound, 1));
            all.push(json!({"kind": kind, "words": words, "bound": bound, "is_most": false}));
        }
        for limit in &task.constraints.quantities {
            let kind = match limit.quantity {
                ConstraintQuantity::PeakPressure => "peak",
                ConstraintQuantity::ArealDensity => "density",
                ConstraintQuantity::BearingArea => "bearing",
                ConstraintQuantity::LaserTime => "laser",
                ConstraintQuantity::Clearance => "clearance",
                ConstraintQuantity::LeastPressure => "least",
            };
            let bound = limit.bound.limit();
            if bound.is_finite() {
                let is_most = matches!(limit.bound, Bound::AtMost(_));
                let words = format!("{}, {}", limit.quantity.name(), limit.quantity.tell(bound));
                let (_, unit_si) = limit.quantity.unit();
                all.push(json!({"kind": kind, "words": words, "bound": bound / unit_si, "is_most": is_most}));
            }
        }
        all
    }

    fn data(&self) -> Data {
        let (task, explorer) = (self.task, self.explorer);
        let target: TargetReport = (&task.target).into();
        let nodes = explorer.quantile_nodes();
        let (count, loads) = (target.pressure_mpa.len(), explorer.expected.outputs() / (3 * nodes));
        let own = PatternReport::from(self.pattern);
        let design = [own.width_um, own.spacing_um, own.depth_um];
        // The page interpolates between pressures, which a file may list in any order.
        let mut order: Vec<usize> = (0..count).collect();
        order.sort_by(|a, b| target.pressure_mpa[*a].total_cmp(&target.pressure_mpa[*b]));
        let of = |part: usize, conditions: usize| {
            let from = |node: usize| (3 * node + part) * loads;
            let starts = (0..nodes).flat_map(|node| (0..conditions).map(move |at| from(node) + at * count));
            Packed::new(&explorer.expected, starts.flat_map(|start| order.iter().map(move |load| start + load)))
        };
        let face = face_data(task, explorer.dimension);
        let ordered = |values: &[Option<f64>]| order.iter().map(|load| values[*load]).collect();
        Data {
            is_ratio: task.target.quantity() == Quantity::Ratio,
            axes: axes_data(&explorer.expected),
            lowest: ordered(&target.lowest),
            highest: ordered(&target.highest),
            pressure_mpa: order.iter().map(|load| target.pressure_mpa[*load]).collect(),
            flat_mu: order.iter().map(|load| self.flat_mu[*load]).collect(),
            medians: of(0, loads / count),
            lower: of(1, 1),
            upper: of(2, 1),
            odds: Packed::new(&explorer.odds, 0..explorer.odds.outputs()),
            beside: Packed::new(&explorer.beside, 0..explorer.beside.outputs() - if face.is_some() { 2 } else { 0 }),
            shares: explorer.shares,
            share_nodes: nodes,
            face,
            holes: explorer.holes.clone(),
            limits: self.limits(),
            exposures: Exposures::new(task),
            believed: BELIEVED,
            design,
            points: self.points(),
            toml: self.toml.clone(),
        }
    }

    /// Describes the interpolated quantities and states the interpolation error.
    fn words(&self) -> String {
        let explorer = self.explorer;
        let quantity = if self.task.target.quantity() == Quantity::Ratio { "ratio" } else { "friction" };
        let several = !self.task.also_at.is_empty() || !self.task.directions.different_deg.is_empty();
        let conditions = if several {
            let first = self.task.condition.map(|of| format!(", {}", in_words(of.speed_m_s, of.humidity)));
            format!(" The chance holds for all conditions; values are those of the first{}.", first.unwrap_or_default())
        } else {
            String::new()
        };
        let error = if explorer.checked == 0 {
            "No random design has an answer to compare the interpolation with.".to_owned()
        } else {
            format!(
                "The {quantity} expected of a sample is interpolated between computed designs: of {} random ones half are off by less than {}, all by at most {}.",
                explorer.checked,
                number(explorer.median_error, 4),
                number(explorer.worst_error, 4),
            )
        };
        let between = if self.task.target.points().len() > 1 {
            " Between the target's pressures values lie on straight lines."
        } else {
            ""
        };
        format!("What is expected of a cut sample of any design within the bounds. {error}{between}{conditions}")
    }

    /// Adds the sliders, the readings and the data for the script.
    fn add(&self, page: &mut Page) {
        let data = self.data();
        let Ok(json) = serde_json::to_string(&data) else { return };
        // The JSON text must not close the script element that contains it.
        let json = json.replace("</", "<\\/").replace("<!--", "<\\u0021--");
        page.add(&html! { div class="screen" { h2 { "Explore" } p { (self.words()) } (controls(&data)) } });
        page.add(&PreEscaped(format!(
            "<script type=\"application/json\" id=\"explorer-data\">{json}</script>\n<script>\n{SCRIPT}</script>"
        )));
    }
}

/// Adds the explorer of the design `found`, if it has one.
pub(super) fn explorer(page: &mut Page, found: &DesignOutcome, outputs: &Outputs) {
    let Some(explorer) = &found.explorer else { return };
    let toml = outputs.text("scene.toml").unwrap_or_default();
    let (task, material, pattern) = (&found.task, &found.material, &found.pattern);
    let law = material.material.area_law.as_ref();
    // Friction from the dynamic run that confirms the design, or steady friction if this run has no value.
    let confirmed = |row: usize| found.report.confirmed.get(row).and_then(|load| load.mu_flat);
    let flat_mu = |(row, load): (usize, &Load)| confirmed(row).unwrap_or_else(|| load.flat_mu(law));
    let flat_mu: Vec<f64> = found.loads.iter().enumerate().map(flat_mu).collect();
    Subject { task, material, pattern, explorer, report: Some(&found.report), flat_mu: &flat_mu, toml }.add(page);
}

/// Makes the page on which the designs of a task can be explored before any search; `toml` is a scene file of the
/// initial design.
pub fn exploration(found: &Explored, toml: String) -> String {
    let Explored { task, material, pattern, explorer, flat_mu, trials, .. } = found;
    let mut page = Page::alone();
    page.title(&task.name);
    if let Some(date) = &task.date {
        page.marked("date", date);
    }
    page.doubts(&found.doubts());
    if *trials == 0 {
        page.paragraph(
            "No trial was measured: what is expected rests on the model and on what is believed of its error.",
        );
    }
    Subject { task, material, pattern, explorer, report: None, flat_mu, toml }.add(&mut page);
    printed(&mut page, found);
    page.finish(&task.name, VERSION)
}

/// Adds what is expected of the design at which the sliders start, in their place on paper.
fn printed(page: &mut Page, found: &Explored) {
    let own = PatternReport::from(&found.pattern);
    let lengths_um = [own.width_um, own.spacing_um, own.depth_um];
    let Some(read) = found.predict(lengths_um) else { return };
    let pressures_mpa = TargetReport::from(&found.task.target).pressure_mpa;
    let rows: Vec<(usize, &f64)> = pressures_mpa.iter().enumerate().collect();
    let mut table = Table::of(&rows);
    table.column("pressure in MPa", |(_, pressure_mpa)| number(**pressure_mpa, 3));
    let is_ratio = found.task.target.quantity() == Quantity::Ratio;
    let expected = if is_ratio { "expected ratio" } else { "expected mu" };
    table.column(expected, |(load, _)| believed(read.expected[*load], 3));
    table.column("95 % of samples", |(load, _)| believed_interval([read.lower_95[*load], read.upper_95[*load]]));
    let lengths = lengths_um.iter().zip(LENGTHS).map(|(um, name)| format!("{name} {}", number(*um, 1)));
    let lengths = lengths.collect::<Vec<_>>().join(", ");
    let chance = read.chance.map(|chance| format!("; chance on target, all pressures: {}", chance_words(chance)));
    let caption = format!("Where the sliders start, in µm: {lengths}{}", chance.unwrap_or_default());
    page.block("print", |page| page.table(&caption, &table.table()));
}

/// Lists the points of the map, each with a button that selects the point.
fn listed(data: &Data) -> Markup {
    let has_measured = data.points.iter().any(|point| !point.measured.is_empty());
    html! {
        details class="points" {
            summary { "Points of the map" }
            div class="scroll" {
                table {
                    caption {
                        "Lengths in µm." @if has_measured { " Measured: ratio patterned over flat; in brackets what is expected here, or what was modelled of the sample." }
                    }
                    thead {
                        tr { th scope="col" { "point" } @for name in LENGTHS { th scope="col" { (name) } } th scope="col" { "choose" } @if has_measured { th scope="col" class="words" { "measured" } } }
                    }
                    tbody {
                        @for point in &data.points {
                            tr {
                                td { (point.name) }
                                @for length in point.at { td { (number(length, 1)) } }
                                td { @if point.on_map { button type="button" data-go=(format!("{},{},{}", point.at[0], point.at[1], point.at[2])) aria-label=(format!("Choose {}", point.name)) { "show" } } @else { "-" } }
                                @if has_measured { td class="words" { (point.measured) } }
                            }
                        }
                    }
                }
            }
        }
    }
}

fn controls(data: &Data) -> Markup {
    let free: Vec<usize> = (0..3).filter(|axis| data.axes[*axis].nodes > 1).collect();
    let pressures = &data.pressure_mpa;
    let (first, second) =
        if data.is_ratio { ("expected ratio", "expected mu") } else { ("expected mu", "expected ratio") };
    let reading = |name: &str, place: &str, unit: &str| {
        html! { div { dt { (name) } dd { (PreEscaped(format!("<span data-{place}></span>"))) @if !unit.is_empty() { " " (unit) } } } }
    };
    let (curve, of_map) = if data.has_target() {
        (
            "Expected of a cut sample of this design against pressure, with 95 % of samples, and what is accepted",
            "Chance that a sample is on target",
        )
    } else {
        (
            "Expected of a cut sample of this design against pressure, with 95 % of samples",
            "How low the expected values of designs are",
        )
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
                    @if data.has_target() { (reading("chance on target, all pressures", "chance", "")) }
                    (reading(first, "first", "")) (reading("95 % of samples", "interval", "")) (reading(second, "second", ""))
                    (reading("largest pressure, all loads", "peak", "MPa")) (reading("cavities' share of the face", "density", "%"))
                    @if let Some(exposures) = &data.exposures {
                        (reading(&format!("{} (depth)", exposures.name), "exposures", ""))
                        @if exposures.have_time() { (reading("laser time", "laser-time", "")) }
                    }
                }
                p data-verdict aria-live="polite" {}
                p { button type="button" data-reset { "Back to the start" } " " button type="button" data-copy { "Copy as a scene file" } }
                textarea data-toml hidden readonly rows="8" aria-label="The design as a scene for slipgrid simulate" {}
            }
            div class="views" {
                div {
                    figure { div class="card" { svg data-curve viewBox="0 0 460 300" role="img" aria-label=(curve) font-family="sans-serif" font-size="15" fill="#333" {} }
                        figcaption { (curve) } }
                    figure { div class="card" { svg data-section viewBox="0 0 460 120" role="img" aria-label="Vertical section of two periods to scale" font-family="sans-serif" font-size="15" fill="#333" {} }
                        figcaption { "Vertical section of two periods of this design, both axes at one scale" } }
                }
                @if free.len() > 1 {
                    figure {
                        div class="card map" {
                            p class="up" data-up {}
                            div class="ticks" data-ticks="up" aria-hidden="true" {}
                            canvas data-map width="384" height="288" role="img" aria-label=(of_map) {}
                            div class="ticks" data-ticks="across" aria-hidden="true" {}
                            p class="across" data-across {}
                        }
                        figcaption {
                            @if free.len() > 2 {
                                select data-pair aria-label="What the map shows" {
                                    @for (a, b) in pairs { option value=(format!("{a},{b}")) { (data.axes[a].name) " and " (data.axes[b].name) } }
                                }
                                " "
                            }
                            @if data.has_target() { "The darker, the greater the chance: " span data-scale {} ". Green: expected on target" } @else { "The darker, the lower" }
                            @if !data.limits.is_empty() { ". Hatched: breaks a limit" span data-limits {} }
                            span data-closed-words {}
                            ". Diamond: where it started; orange: chosen here" @if data.shows("trade-off") { "; grey: trade-offs" } @if data.shows("trial") { "; purple squares: trials, cut and measured" } ". Click to choose."
                        }
                    }
                }
            }
            @if !data.points.is_empty() { (listed(data)) }
        }
    }
}
