//! The explorer: sliders that ask a response surface for what any design within the bounds does.

mod surfaces;

use maud::{Markup, PreEscaped, html};
use serde::Serialize;
use slipgrid_design::optimize::{Bound, Quantity};
use slipgrid_design::records::TargetReport;
use slipgrid_design::{ConstraintQuantity, DesignOutcome, DesignReport, DesignTask, Explored, Explorer, KnownMaterial};
use slipgrid_export::laser_time_s;
use slipgrid_pattern::Pattern;
use slipgrid_results::{PatternReport, VERSION};
use slipgrid_statistics::Axis;
use slipgrid_units::LENGTH_UM;

use self::surfaces::{AxisData, LENGTHS, Packed, RimData, axes_data};
use super::page::{Page, number, sentence};
use super::points::{Among, Point};
use crate::Outputs;

const SCRIPT: &str = include_str!("explorer.js");
/// What is said of a design whose cavities close, and of one near designs that the steady model cannot solve.
const CLOSED: &str = "the cavity closes under the load: no answer";
const UNANSWERED: &str = "the steady model finds no answer near this design";
/// A limit that the page can check.
#[derive(Serialize)]
struct LimitData {
    kind: &'static str,
    words: String,
    bound: f64,
    is_most: bool,
}

/// Widths at which the laser's time is computed, where the width is not fixed. Spots and lines are whole numbers: time has steps along the
/// width, which lie where they are to one part in forty over a range of ten.
const LASER_WIDTHS: usize = 96;

/// The laser's time: that of a width times the share of the face times the steps in depth.
#[derive(Serialize)]
struct LaserData {
    width_um: Vec<f64>,
    /// At each width, the time that a step in depth takes over the share of the face that is cavity, in seconds.
    step_s: Vec<f64>,
}

impl LaserData {
    /// The time of cavities at the spacing and the depth of `pattern` on the task's specimen, where the task's laser has one.
    fn new(task: &DesignTask, explorer: &Explorer, pattern: &Pattern) -> Option<Self> {
        let [width_m, spacing_m, depth_m] = pattern.lengths_m();
        let steps = match task.constraints.limits.depth_per_burst_m {
            Some(burst_m) => (depth_m / burst_m).round().max(1.0),
            None => LENGTH_UM.from_si(depth_m),
        };
        let Axis { from, to, nodes } = explorer.values.axes()[0];
        let along = Axis { from, to, nodes: if nodes == 1 { 1 } else { LASER_WIDTHS } };
        let mut widths: Vec<f64> = (0..along.nodes).map(|node| along.at(node)).collect();
        // The time of the pattern itself is met exactly.
        widths.push(LENGTH_UM.from_si(width_m));
        widths.sort_by(f64::total_cmp);
        widths.dedup();
        let of_width = |width_um: f64| {
            let made = Pattern::new(*pattern.texture(), LENGTH_UM.to_si(width_um), spacing_m, depth_m).ok()?;
            let laid = task.specimen.layout(made).ok()?;
            let step_s = laser_time_s(&laid, &task.laser)? / (laid.areal_density() * steps);
            step_s.is_finite().then_some((width_um, step_s))
        };
        let (width_um, step_s): (Vec<f64>, Vec<f64>) = widths.into_iter().filter_map(of_width).unzip();
        (!step_s.is_empty()).then_some(Self { width_um, step_s })
    }
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
    peak_and_sag: Packed,
    rim: Option<RimData>,
    areal_density: Packed,
    /// Share of the specimen's face that is cavity over that of a period, by the design of the page: limits are about the
    /// face.
    face_over_period: f64,
    offset: Vec<f64>,
    covariance: Vec<Vec<f64>>,
    /// Why there is neither a chance nor a band of errors, where there is none.
    no_chance: Option<String>,
    limits: Vec<LimitData>,
    burst_um: Option<f64>,
    /// Depths are whole passes over a hatch, and not bursts on a spot.
    has_passes: bool,
    laser: Option<LaserData>,
    closed: &'static str,
    /// Nodes of the lattice without an answer.
    unanswered: Vec<usize>,
    unanswered_words: &'static str,
    design: [f64; 3],
    points: Vec<Point>,
    toml: String,
}

impl Data {
    /// Whether the map shows a point of this kind.
    fn shows(&self, kind: &str) -> bool {
        self.points.iter().any(|point| point.on_map && point.kind == kind)
    }

    fn has_target(&self) -> bool {
        self.lowest.iter().chain(&self.highest).any(Option::is_some)
    }
}

/// What a page explores, with what is known of it.
struct Subject<'a> {
    task: &'a DesignTask,
    material: &'a KnownMaterial,
    pattern: &'a Pattern,
    explorer: &'a Explorer,
    /// The design found, where one was searched.
    report: Option<&'a DesignReport>,
    /// Friction of the flat surface at each of the target's pressures, where nothing was confirmed.
    flat_mu: Option<&'a [f64]>,
    /// A scene of the pattern.
    toml: String,
}

impl Subject<'_> {
    /// What limits the page can check.
    fn limits(&self) -> Vec<LimitData> {
        let task = self.task;
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

    /// Share of the specimen's face that is cavity over that of a period, of the pattern that the page is about.
    fn face_over_period(&self) -> f64 {
        let period = self.pattern.areal_density();
        let face = match self.report {
            Some(report) => Some(report.specimen_areal_density),
            None => self.task.specimen.layout(*self.pattern).ok().map(|laid| laid.areal_density()),
        };
        face.map(|face| face / period).filter(|factor| factor.is_finite() && *factor > 0.0).unwrap_or(1.0)
    }

    /// Why no chance is known of the designs, where none is.
    fn no_chance(&self) -> Option<String> {
        if !self.explorer.covariance.is_empty() {
            return None;
        }
        let Some(report) = self.report else {
            return Some("not known: errors are drawn about a design that was found, by slipgrid optimize".to_owned());
        };
        let unknown = report.chance.as_ref().filter(|chance| chance.value.is_none());
        let words = unknown.and_then(|chance| chance.words.strip_prefix("chance "));
        Some(words.unwrap_or("not known: errors about the design found could not be drawn").to_owned())
    }

    fn data(&self) -> Data {
        let (task, explorer, pattern) = (self.task, self.explorer, self.pattern);
        let target: TargetReport = (&task.target).into();
        let count = target.pressure_mpa.len();
        let edge = |edges: &[Option<f64>]| (0..count).map(|row| edges.get(row).copied().flatten()).collect();
        let confirmed = self.report.map_or(&[][..], |report| &report.confirmed);
        let flat_mu: Option<Vec<f64>> = confirmed.iter().map(|load| load.mu_flat).collect();
        let face_over_period = self.face_over_period();
        let flat_mu = self.flat_mu.map(<[f64]>::to_vec).or(flat_mu).filter(|all| all.len() == count);
        let among = Among {
            task,
            material: self.material,
            explorer,
            flat_mu: flat_mu.as_deref(),
            pressure_mpa: &target.pressure_mpa,
        };
        let points = among.points(self.report);
        let own = PatternReport::from(pattern);
        Data {
            is_ratio: task.target.quantity() == Quantity::Ratio,
            axes: axes_data(&explorer.values),
            lowest: edge(&target.lowest),
            highest: edge(&target.highest),
            pressure_mpa: target.pressure_mpa,
            flat_mu,
            values: Packed::new(&explorer.values),
            peak_and_sag: Packed::new(&explorer.peak_and_sag),
            rim: RimData::new(explorer, pattern),
            areal_density: Packed::new(&explorer.areal_density),
            face_over_period,
            offset: explorer.offset.clone(),
            covariance: explorer
                .covariance
                .iter()
                .take(count)
                .map(|row| row[..count.min(row.len())].to_vec())
                .collect(),
            no_chance: self.no_chance(),
            limits: self.limits(),
            burst_um: task.constraints.limits.depth_per_burst_m.map(|m| LENGTH_UM.from_si(m)),
            has_passes: task.laser.bursts_per_pass().is_some(),
            laser: LaserData::new(task, explorer, pattern),
            closed: CLOSED,
            unanswered: explorer.unanswered.clone(),
            unanswered_words: UNANSWERED,
            design: [own.width_um, own.spacing_um, own.depth_um],
            points,
            toml: self.toml.clone(),
        }
    }

    /// How far the surface is off, what it is compared with, and what is left out of that.
    fn errors(&self, data: &Data) -> String {
        let error = self.explorer.error;
        let quantity = if data.is_ratio { "ratio" } else { "dynamic friction" };
        let rims = data.rim.as_ref().map_or_else(String::new, |rim| {
            format!(", their rims from {} to {} times as high as modelled", rim.ends()[0], rim.ends()[1])
        });
        if error.points == 0 {
            return "No design drawn at random has an answer to compare it with.".to_owned();
        }
        let mut words = format!(
            "At the pressures of the table its {quantity} is off that of the steady solver in the same blocks by {} in the median and {} at worst over {} \
             designs drawn at random{rims}.",
            number(error.median, 4),
            number(error.worst, 4),
            error.points,
        );
        if let Some(between) = error.between {
            words += &format!(
                " Between these pressures it draws straight lines, from which the solver's ratio is off by up to {} more.",
                number(between, 4)
            );
        }
        let confirmed = self.report.map_or(&[][..], |report| &report.confirmed);
        let of_blocks =
            confirmed.iter().filter_map(|load| load.ratio_discretization_error).map(f64::abs).reduce(f64::max);
        let blocks = of_blocks.map_or_else(String::new, |blocks| {
            format!(" (of the design found, blocks that vanish change the ratio by up to {})", number(blocks, 4))
        });
        words
            + &format!(
                " The size of blocks{blocks} and how cavities are laid on the specimen are not in these numbers."
            )
    }

    /// Adds what asks the surface.
    fn add(&self, page: &mut Page) {
        let data = self.data();
        let Ok(json) = serde_json::to_string(&data) else { return };
        // Nothing in it may end the element that holds it.
        let json = json.replace("</", "<\\/").replace("<!--", "<\\u0021--");
        let corrected = match (self.report.is_some(), &data.no_chance) {
            (true, None) => {
                "The pattern is taken as endless, corrected so that the design found has what was predicted of it. Error band and chance \
                 take the errors of the design found: compare chances here with one another, not with the chance above."
                    .to_owned()
            }
            (true, Some(reason)) => format!(
                "The pattern is taken as endless, corrected so that the design found has what was predicted of it. There is neither a band \
                 of errors nor a chance, which is {reason}."
            ),
            (false, _) => {
                "The pattern is taken as endless; nothing was searched or confirmed in time, and no error of the material is drawn."
                    .to_owned()
            }
        };
        let which =
            if self.report.is_some() || data.has_target() { "within the bounds" } else { "that the sliders reach" };
        let errors = self.errors(&data);
        let times = if self.task.discrepancy { ", times the median factor that trials add" } else { "" };
        let words =
            format!("What any design {which} would do, by a table of steady solutions{times}. {errors} {corrected}");
        let words = if data.limits.iter().any(|limit| ["density", "bearing"].contains(&limit.kind)) {
            let of = if self.report.is_some() { "the design found" } else { "the design in the middle of the bounds" };
            let factor = number(data.face_over_period, 4);
            words
                + &format!(
                    " Limits on shares are about the face of the specimen: they are judged by the share of a period times {factor}, which {of} has."
                )
        } else {
            words
        };
        let is_all = self.task.also_at.is_empty() && self.task.directions.different_deg.is_empty();
        let words =
            if is_all { words } else { words + " Values and chance are those of the condition designed for alone." };
        page.add(&html! { div class="screen" { h2 { "Explore" } p { (words) } (controls(&data)) } });
        page.script(&format!(
            "<script type=\"application/json\" id=\"explorer-data\">{json}</script>\n<script>\n{SCRIPT}</script>"
        ));
    }
}

/// The explorer of `found`, where it was made.
pub(super) fn explorer(page: &mut Page, found: &DesignOutcome, outputs: &Outputs) {
    let Some(explorer) = &found.explorer else { return };
    let toml = outputs.text("scene.toml").unwrap_or_default();
    let (task, material, pattern) = (&found.task, &found.material, &found.pattern);
    Subject { task, material, pattern, explorer, report: Some(&found.report), flat_mu: None, toml }.add(page);
}

/// The page of what a task's designs do, before any is searched; `toml` is a scene of the design in the middle.
#[must_use]
pub fn exploration(found: &Explored, toml: String) -> String {
    let Explored { task, material, pattern, explorer, flat_mu, .. } = found;
    let mut page = Page::alone();
    page.title(&task.name);
    if let Some(date) = &task.date {
        page.marked("date", date);
    }
    if material.material.provenance.synthetic_surface {
        page.warning("The area law behind these numbers rests on a synthetic surface, not on a measured one.");
    }
    page.doubts(found.doubts().iter().map(|doubt| sentence(doubt)).collect());
    Subject { task, material, pattern, explorer, report: None, flat_mu: Some(flat_mu), toml }.add(&mut page);
    page.finish(&task.name, VERSION)
}

/// The points in words, each with a button that chooses it.
fn listed(data: &Data) -> Markup {
    let has_measured = data.points.iter().any(|point| !point.measured.is_empty());
    html! {
        details class="points" {
            summary { "Points of the map" }
            div class="scroll" {
                table {
                    caption {
                        "Lengths in µm." @if has_measured { " Measured: ratio patterned over flat; in brackets what this page draws there, or what was modelled of the sample." }
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
    let (first, second) = if data.is_ratio { ("ratio", "mu") } else { ("mu", "ratio") };
    let reading = |name: &str, place: &str, unit: &str| {
        html! { div { dt { (name) } dd { (PreEscaped(format!("<span data-{place}></span>"))) @if !unit.is_empty() { " " (unit) } } } }
    };
    let (curve, of_curve, of_map) = if data.has_target() {
        (
            "Values against pressure with the target's band",
            if data.no_chance.is_none() {
                "Values against pressure: this design with one standard deviation, and the target's band"
            } else {
                "Values against pressure: this design, and the target's band"
            },
            "Where designs are on target; the sliders choose the same",
        )
    } else {
        (
            "Values against pressure",
            "Values against pressure of this design",
            "How low values of designs are; the sliders choose the same",
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
                @if let Some(rim) = &data.rim {
                    div class="knob" {
                        label for="x-rim" { "rim height in µm" }
                        input id="x-rim" type="range" min=(rim.ends()[0]) max=(rim.ends()[1]) step="0.01" value="1" data-rim;
                        input type="number" inputmode="decimal" step="0.01" min="0" aria-label="rim height in µm, as a number" data-rim-height;
                        span data-rim-words {}
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
                    (reading(first, "first", "")) @if data.flat_mu.is_some() { (reading(second, "second", "")) }
                    @if data.has_target() { (reading("chance on target by the steady model", "chance", "")) }
                    (reading("peak pressure", "peak", "MPa")) (reading("cavities' share of the face", "density", "%"))
                    @if data.burst_um.is_some() { (reading(if data.has_passes { "depth, in whole passes" } else { "bursts (depth)" }, "bursts", "")) }
                    @if data.laser.is_some() { (reading("laser time", "laser-time", "")) }
                }
                p data-verdict aria-live="polite" {}
                p { button type="button" data-reset { "Back to the start" } " " button type="button" data-copy { "Copy as a scene file" } }
                textarea data-toml hidden readonly rows="8" aria-label="The design as a scene for slipgrid simulate" {}
            }
            div class="views" {
                div {
                    figure { div class="card" { svg data-curve viewBox="0 0 460 300" role="img" aria-label=(curve) font-family="sans-serif" font-size="15" fill="#333" {} }
                        figcaption { (of_curve) } }
                    figure { div class="card" { svg data-section viewBox="0 0 460 120" role="img" aria-label="Vertical section of two periods to scale" font-family="sans-serif" font-size="15" fill="#333" {} }
                        figcaption { "Vertical section of two periods of this design, both axes at one scale" } }
                }
                @if free.len() > 1 {
                    figure {
                        div class="card" { canvas data-map width="384" height="288" role="img" aria-label=(of_map) {} }
                        figcaption {
                            @if free.len() > 2 {
                                select data-pair aria-label="What the map shows" {
                                    @for (a, b) in pairs { option value=(format!("{a},{b}")) { (data.axes[a].name) " and " (data.axes[b].name) } }
                                }
                                " "
                            }
                            span data-across {} "; " span data-up {} @if data.has_target() { ". Green: on target" } @else { ". The darker, the lower" } @if !data.limits.is_empty() { ". Hatched: breaks a limit" span data-limits {} }
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
