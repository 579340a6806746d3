//! Chart of wall time against error.

use plotters::style::RGBColor;
use plotters::style::text_anchor::{HPos, VPos};

use super::{
    Axis, Canvas, Chart, ChartError, Frame, GREY, INK, Layer, Mark, PALETTE, Plot, SMALL_SIZE, Swatch, check,
    small_text_width,
};

/// Panel with the errors of all methods in one quantity.
#[derive(Clone, Debug, PartialEq)]
pub struct WorkPrecisionPanel<'a> {
    /// Title of the error axis.
    pub error_title: String,
    /// One point per method.
    pub points: Vec<WorkPoint<'a>>,
    /// Smallest distinguishable error, in per cent.
    pub resolution_pct: f64,
}

/// Wall time and error of a method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorkPoint<'a> {
    /// Short name of the method.
    pub label: &'a str,
    /// Index of the method's family in the list of families of `work_precision`.
    pub family: usize,
    /// Wall time in seconds.
    pub wall_s: f64,
    /// Magnitude of the error, in per cent of the reference's value.
    pub error_pct: f64,
    /// The error is not significant: `error_pct` is an upper bound.
    pub at_most: bool,
    /// No other method is both faster and at least as accurate.
    pub on_front: bool,
    /// The method is the program's default.
    pub is_default: bool,
}

/// Height of a panel with its axis, in picture units.
const PANEL_HEIGHT: f64 = 470.0;
/// Height of the title and the legend, in picture units.
const HEADING: f64 = 100.0;
/// Errors below this value, in per cent, are drawn at this value, because the axis is logarithmic.
const MIN_ERROR_PCT: f64 = 1e-3;
/// Times below this value, in seconds, are drawn at this value.
const MIN_TIME_S: f64 = 1e-6;
/// Space around a mark that labels do not cover, in picture units.
const MARK_ROOM: f64 = 7.0;
/// Space around the ring of a default method that labels do not cover, in picture units.
const RING_ROOM: f64 = 9.0;
/// Space beside a line that labels do not cover, in picture units.
const LINE_ROOM: f64 = 2.0;
/// Length of the arrow at an upper bound, in picture units.
const ARROW: f64 = 15.0;

/// Draws error against wall time on logarithmic axes, one plot per panel from top to bottom, each with the Pareto front
/// of the methods. `families` are the names of the method families, at most as many as there are colours; `reference_s`
/// is the wall time of the reference method.
///
/// # Errors
/// [`ChartError`] if a panel is empty or a value is not finite.
pub fn work_precision(
    title: &str,
    families: &[&str],
    panels: &[WorkPrecisionPanel<'_>],
    reference_s: f64,
) -> Result<String, ChartError> {
    for panel in panels {
        check(title, panel.points.iter().flat_map(|point| [point.wall_s, point.error_pct]))?;
        check(title, [panel.resolution_pct, reference_s])?;
    }
    let marked = |(family, &name)| {
        let (mark, color) = style(family);
        (Swatch::Mark(mark, color), name)
    };
    let mut legend: Vec<(Swatch, &str)> = families.iter().enumerate().map(marked).collect();
    legend.extend([
        (Swatch::Mark(Mark::Ring, INK), "a default of the program"),
        (Swatch::Line(GREY), "front"),
        (Swatch::Dashed(GREY), "below it not told apart"),
        (Swatch::Arrow(GREY), "not significant: at most"),
    ]);
    let height = HEADING + PANEL_HEIGHT * panels.len() as f64;
    let mut chart = Chart::new(title, height, legend);
    let [left, heading, right, _] = chart.frame();
    let panel_height = (height - heading) / panels.len() as f64;
    for (order, panel) in panels.iter().enumerate() {
        let top = heading + panel_height * order as f64;
        let places: Vec<[f64; 2]> = panel.points.iter().map(logarithms).collect();
        let reference = reference_s.max(MIN_TIME_S).log10();
        let resolution = panel.resolution_pct.max(MIN_ERROR_PCT).log10();
        let times = places.iter().map(|at| at[0]).chain([reference]);
        let x_axis = Axis::logarithmic("wall time of one run on one thread (s)", times);
        let errors = places.iter().map(|at| at[1]).chain([resolution]);
        let y_axis = Axis::logarithmic(&panel.error_title, errors);
        let methods = Layer::Own(Box::new(move |canvas, plot| {
            draw(canvas, plot, &panel.points, &places, [reference, resolution])
        }));
        let frame = [left, top, right, top + panel_height - 70.0];
        chart.plot_in(frame, x_axis, y_axis, [Layer::Horizontal(resolution), methods]);
    }
    chart.svg()
}

fn style(family: usize) -> (Mark, RGBColor) {
    // Rings mark the defaults.
    (Mark::FILLED[family % Mark::FILLED.len()], PALETTE[family % PALETTE.len()])
}

fn logarithms(point: &WorkPoint<'_>) -> [f64; 2] {
    [point.wall_s.max(MIN_TIME_S).log10(), point.error_pct.max(MIN_ERROR_PCT).log10()]
}

/// Draws the line of the reference, the front, and the marks and labels of the methods at `places`. `places` are the
/// decimal logarithms of each method's wall time in seconds and error in per cent; `limits` are the logarithms of the
/// reference's wall time and of the smallest distinguishable error.
fn draw(
    canvas: &Canvas<'_>,
    plot: &Plot<'_>,
    points: &[WorkPoint<'_>],
    places: &[[f64; 2]],
    limits: [f64; 2],
) -> Result<(), ChartError> {
    let frame = plot.frame;
    let [foot, floor] = plot.at(limits);
    canvas.dashed([[foot, frame[3]], [foot, frame[1]]], INK, 1.2)?;
    canvas.text("reference", [foot - 6.0, frame[1] + 10.0], (HPos::Right, VPos::Center), INK)?;
    let mut taken = vec![[foot - 76.0, frame[1], foot + 2.0, frame[1] + 20.0]];

    // The front as stairs: between two methods, the faster method's error applies.
    let mut best: Vec<[f64; 2]> =
        points.iter().zip(places).filter(|(point, _)| point.on_front).map(|(_, at)| *at).collect();
    best.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let stairs: Vec<[f64; 2]> = best
        .iter()
        .zip(best.iter().skip(1).map(Some).chain([None]))
        .flat_map(|(&at, next)| [Some(at), next.map(|next| [next[0], at[1]])])
        .flatten()
        .map(|at| plot.at(at))
        .collect();
    canvas.line(&stairs, GREY, 1.8)?;
    // Labels do not cover the lines.
    taken.push([frame[0], floor - LINE_ROOM, frame[2], floor + LINE_ROOM]);
    taken.extend(stairs.windows(2).map(|ends| {
        let low = |axis: usize| ends[0][axis].min(ends[1][axis]) - LINE_ROOM;
        let high = |axis: usize| ends[0][axis].max(ends[1][axis]) + LINE_ROOM;
        [low(0), low(1), high(0), high(1)]
    }));

    for (point, &at) in points.iter().zip(places) {
        let (mark, color) = style(point.family);
        let page = plot.at(at);
        if point.at_most {
            canvas.arrow(page, [page[0], page[1] + ARROW], color)?;
        }
        canvas.mark(mark, page, color)?;
        if point.is_default {
            canvas.mark(Mark::Ring, page, INK)?;
        }
        let (room, below) =
            (if point.is_default { RING_ROOM } else { MARK_ROOM }, if point.at_most { ARROW } else { 0.0 });
        taken.push([page[0] - room, page[1] - room, page[0] + room, page[1] + room.max(below)]);
    }
    for (point, &at) in points.iter().zip(places) {
        let page = plot.at(at);
        let (label, leader) = free_place(page, small_text_width(point.label), frame, &taken);
        if let Some(far) = leader {
            canvas.line(&[page, far], style(point.family).1, 0.7)?;
        }
        canvas.small_text(point.label, [label[0], (label[1] + label[3]) / 2.0], INK)?;
        taken.push(label);
    }
    Ok(())
}

/// Finds the position nearest to `mark` within `frame` for a label of `width` that overlaps no rectangle in `taken`, or
/// the position with the least overlap. Also returns the end of the line from `mark` to a distant label. All lengths
/// are in picture units.
fn free_place(mark: [f64; 2], width: f64, frame: Frame, taken: &[Frame]) -> (Frame, Option<[f64; 2]>) {
    const DIRECTIONS: u32 = 24;
    const NEAR: f64 = 12.0;
    const STEP: f64 = 7.0;
    const STEPS: u32 = 16;
    let height = SMALL_SIZE + 2.0;
    let at = |distance: f64, direction: u32| {
        let angle = std::f64::consts::TAU * f64::from(direction) / f64::from(DIRECTIONS);
        let [x, y] = [mark[0] + distance * angle.cos(), mark[1] - distance * angle.sin()];
        // The side of the label that faces the mark touches (x, y).
        let left = x - width * (1.0 - angle.cos()) / 2.0;
        let top = y - height * (1.0 + angle.sin()) / 2.0;
        ([left, top, left + width, top + height], [x, y])
    };
    let overlap = |a: &Frame, b: &Frame| {
        let across = (a[2].min(b[2]) - a[0].max(b[0])).max(0.0);
        across * (a[3].min(b[3]) - a[1].max(b[1])).max(0.0)
    };
    let inside = |label: &Frame| {
        label[0] > frame[0] + 2.0 && label[2] < frame[2] && label[1] > frame[1] && label[3] < frame[3] - 2.0
    };
    let places = (0..STEPS)
        .flat_map(|step| (0..DIRECTIONS).map(move |direction| (NEAR + STEP * f64::from(step), direction)))
        .map(|(distance, direction)| (distance, at(distance, direction)))
        .filter(|(_, (label, _))| inside(label));
    let mut least: Option<(f64, f64, (Frame, [f64; 2]))> = None;
    for (distance, place) in places {
        let covered: f64 = taken.iter().map(|other| overlap(&place.0, other)).sum();
        if least.is_none_or(|(best, ..)| covered < best) {
            least = Some((covered, distance, place));
            if covered == 0.0 {
                break;
            }
        }
    }
    let (_, distance, (label, end)) = least.unwrap_or((0.0, NEAR, at(NEAR, 0)));
    (label, (distance > NEAR).then_some(end))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(label: &str, family: usize, wall_s: f64, error_pct: f64) -> WorkPoint<'_> {
        WorkPoint { label, family, wall_s, error_pct, at_most: false, on_front: false, is_default: false }
    }

    #[test]
    fn every_method_has_a_mark_and_a_label() {
        let points = vec![
            WorkPoint { on_front: true, is_default: true, ..point("fast", 0, 1e-3, 1.0) },
            WorkPoint { on_front: true, at_most: true, ..point("good", 1, 1.0, 0.01) },
            point("neither", 0, 2.0, 0.0),
        ];
        let drawn = |points| {
            let panel = WorkPrecisionPanel { error_title: "error (%)".to_owned(), points, resolution_pct: 0.02 };
            work_precision("Speed against error", &["circles", "squares"], &[panel], 30.0)
        };
        let svg = drawn(points).unwrap();
        // Two marks and a ring, and as many in the legend: one circle and a ring.
        assert_eq!(svg.matches("<circle").count(), 5);
        for text in ["fast", "good", "neither", "reference", "circles", "squares"] {
            assert!(svg.contains(&format!("\n{text}\n")), "{text}");
        }
        assert!(matches!(drawn(Vec::new()), Err(ChartError::Empty { .. })));
    }

    #[test]
    fn labels_of_neighbours_do_not_cover_each_other() {
        let frame = [0.0, 0.0, 400.0, 300.0];
        let mut taken = Vec::new();
        for mark in [[200.0, 150.0], [203.0, 150.0], [200.0, 153.0], [398.0, 2.0]] {
            let (label, _) = free_place(mark, 60.0, frame, &taken);
            for other in &taken {
                let apart =
                    label[2] <= other[0] || other[2] <= label[0] || label[3] <= other[1] || other[3] <= label[1];
                assert!(apart, "{label:?} {other:?}");
            }
            assert!(label[0] > 0.0 && label[2] < 400.0 && label[1] > 0.0 && label[3] < 300.0, "{label:?}");
            taken.push(label);
        }
    }
}
