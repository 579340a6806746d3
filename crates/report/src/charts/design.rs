//! Charts of designs: the target with the expected values of a cut sample, trade-offs, and predictions by mechanism.

use std::collections::BTreeSet;

use plotters::style::RGBColor;
use slipgrid_base::units::PRESSURE_MPA;
use slipgrid_design::{
    Compared, DesignOutcome, DesignReport, DesignTask, Expected, LearningReport, RatioPrediction, TradeOff,
    TradeOffGoal, percent,
};
use slipgrid_infer::discrepancy::Load;
use slipgrid_model::material::Condition;
use slipgrid_model::pattern::Pattern;

use super::{
    Axis, Chart, ChartError, GREY, INK, Layer, Mark, PALETTE, PRECISION, Plot, RIGHT, Swatch, WIDTH, check, extremes,
};

/// Trials are drawn from the lowest target pressure over this factor to the highest target pressure times this factor;
/// trials farther away would widen the plot.
const BEYOND: f64 = 1.1;
/// Opacity of the accepted band.
const BAND: f64 = 0.22;
/// Opacity of the 95 % intervals of samples.
const INTERVAL: f64 = 0.4;
/// Half the width of an interval bar, relative to the range of pressures.
const HALF_BAR: f64 = 0.012;
/// Horizontal distance between the marks of different conditions at one pressure, relative to the range of pressures.
const CONDITION_STEP: f64 = 0.04;

/// Whether a trial's `load` is at the design condition of `task`; true if the task has no condition.
pub(crate) fn is_at_condition(task: &DesignTask, load: &Load) -> bool {
    let own = Condition { speed_m_s: load.speed_m_s, humidity: load.humidity };
    task.condition.is_none_or(|wanted| wanted.matches(&own))
}

/// Nominal pressures in MPa and ratios measured in trials at the design condition, near the target's pressures. Empty
/// unless the target is a ratio, because flat friction at the loads of trials is not known here.
fn measured(report: &DesignReport, found: &DesignOutcome) -> Vec<[f64; 2]> {
    let (Some(learned), true) = (&found.material.uncertainty.learned, report.is_ratio()) else { return Vec::new() };
    let all = learned.trials().iter().flat_map(|trial| &trial.measured);
    let all = all.filter(|of| is_at_condition(&found.task, &of.load));
    let points = all.map(|of| [PRESSURE_MPA.from_si(of.load.pressure_pa), of.measured]);
    let [low, high] = extremes(report.target.pressure_mpa.iter().copied());
    points.filter(|[p, _]| (low / BEYOND..=high * BEYOND).contains(p)).collect()
}

/// Friction of the flat surface at the load with the index `row`, in the target's quantity; `None` if it is unknown.
pub(crate) fn flat_of(report: &DesignReport, row: usize) -> Option<f64> {
    Some(report.sample.modelled.get(row)?.flat)
}

/// Prediction of the model alone, without corrections from trials, at the load with the index `row`, in the target's
/// quantity; `None` if it is unknown.
pub(crate) fn model_alone(report: &DesignReport, row: usize) -> Option<f64> {
    report.sample.modelled.get(row).map(|modelled| modelled.ratio * modelled.flat)
}

/// Target at one pressure, with the friction of the flat surface; values are in the target's quantity.
#[derive(Clone, Copy)]
struct Wanted {
    pressure_mpa: f64,
    value: Option<f64>,
    lowest: Option<f64>,
    highest: Option<f64>,
    flat: Option<f64>,
}

/// Draws target and expected friction against pressure, with the trials behind the design `found`, if available;
/// `report` is the record of that design. An empty title gives a picture for a narrow column or a phone.
///
/// # Errors
/// [`ChartError`] if there is no target or a value is not finite.
pub(crate) fn target(title: &str, report: &DesignReport, found: Option<&DesignOutcome>) -> Result<String, ChartError> {
    target_beside(title, report, &found.map_or_else(Vec::new, |found| measured(report, found)))
}

/// Draws the target and the expected values of cut samples of `report` with `measured`: nominal pressures in MPa and
/// measured values of trials, of any texture.
fn target_beside(title: &str, report: &DesignReport, measured: &[[f64; 2]]) -> Result<String, ChartError> {
    let target = &report.target;
    let point = |(row, &pressure_mpa): (usize, &f64)| Wanted {
        pressure_mpa,
        value: target.value.as_ref().map(|values| values[row]),
        lowest: target.lowest[row],
        highest: target.highest[row],
        flat: flat_of(report, row),
    };
    let mut points: Vec<Wanted> = target.pressure_mpa.iter().enumerate().map(point).collect();
    points.sort_by(|a, b| a.pressure_mpa.total_cmp(&b.pressure_mpa));
    let (Some(first), Some(last)) = (points.first(), points.last()) else {
        return Err(ChartError::Empty { title: title.to_owned() });
    };
    let model = |row: usize| model_alone(report, row);
    let samples = || report.sample.expected.iter().enumerate();
    let flat: Vec<[f64; 2]> = points.iter().filter_map(|point| Some([point.pressure_mpa, point.flat?])).collect();
    let limits = || points.iter().flat_map(|point| [point.value, point.lowest, point.highest]).flatten();
    let of_samples =
        || samples().flat_map(|(row, at)| [at.median, at.low_95, at.high_95].into_iter().chain(model(row)));
    let values = || limits().chain(of_samples()).chain(flat.iter().chain(measured).map(|[_, value]| *value));
    let pressures = || {
        let of_samples = samples().map(|(_, at)| at.pressure_mpa).chain(measured.iter().map(|[p, _]| *p));
        points.iter().map(|point| point.pressure_mpa).chain(of_samples)
    };

    let [blue, vermilion, green, purple, orange] = PALETTE;
    let condition = |row: usize| row / points.len();
    let conditions = report.sample.expected.len().div_ceil(points.len()).max(1);
    // Each condition has a mark, and another colour once all marks are taken.
    let style = |condition: usize| {
        let marks = [Mark::Circle, Mark::Diamond, Mark::Triangle, Mark::Square];
        (marks[condition % marks.len()], [vermilion, orange][condition / marks.len() % 2])
    };
    let named = samples().step_by(points.len()).map(|(row, at)| {
        let at = if conditions > 1 { format!(", {}", at.condition_in_words()) } else { String::new() };
        (style(condition(row)), format!("expected{at}"))
    });
    let named: Vec<_> = named.collect();
    // In an order that fills the rows of a narrow picture.
    let (has_samples, has_model) = (samples().next().is_some(), samples().any(|(row, _)| model(row).is_some()));
    let legend = [
        (limits().next().is_some(), Swatch::Band(green, BAND), "accepted"),
        (!flat.is_empty(), Swatch::Mark(Mark::Triangle, GREY), "flat"),
        (has_samples, Swatch::Band(vermilion, INTERVAL), "95 % of samples"),
        (has_model, Swatch::Mark(Mark::Ring, blue), "model alone"),
        (!measured.is_empty(), Swatch::Mark(Mark::Square, purple), "earlier trials"),
    ];
    let mut legend: Vec<_> =
        legend.into_iter().filter(|(is_drawn, ..)| *is_drawn).map(|(_, swatch, label)| (swatch, label)).collect();
    let place = usize::from(limits().next().is_some());
    legend.splice(place..place, named.iter().map(|((mark, colour), label)| (Swatch::Mark(*mark, *colour), &**label)));

    // The band extends slightly beyond the first and the last pressure, so that it surrounds the marks.
    let [low_mpa, high_mpa] = extremes(pressures());
    let range_mpa = if high_mpa > low_mpa { high_mpa - low_mpa } else { 0.3 * high_mpa.abs() };
    let shift_mpa =
        |condition: usize| CONDITION_STEP * range_mpa * (condition as f64 - 0.5 * (conditions as f64 - 1.0));
    let beyond_mpa = 0.03 * range_mpa + shift_mpa(conditions - 1);
    let ends = [(first, -beyond_mpa), (last, beyond_mpa)]
        .map(|(point, beyond_mpa)| Wanted { pressure_mpa: point.pressure_mpa + beyond_mpa, ..*point });
    let widened = || ends[..1].iter().chain(&points).chain(&ends[1..]);
    // A one-sided band extends slightly beyond all drawn values.
    let [low, high] = extremes(values());
    let beyond = 0.05 * (high - low).max(0.02 * high.abs());
    let [below, above] = [low - beyond, high + beyond];
    let is_open = points.iter().any(|point| point.lowest.is_some() != point.highest.is_some());
    let opened = [below, above].into_iter().filter(|_| is_open);
    let banded = || widened().filter(|point| point.lowest.is_some() || point.highest.is_some());
    let lower = banded().map(|point| [point.pressure_mpa, point.lowest.unwrap_or(below)]);
    let upper = banded().map(|point| [point.pressure_mpa, point.highest.unwrap_or(above)]);
    let band: Vec<[f64; 2]> = lower.chain(upper.rev()).collect();

    // Conditions of a single pressure stand near its middle.
    let around = if high_mpa > low_mpa { 0.0 } else { range_mpa };
    let reached = ends.iter().zip([-around, around]).map(|(end, beyond_mpa)| end.pressure_mpa + beyond_mpa);
    let own: Vec<f64> = points.iter().map(|point| point.pressure_mpa).collect();
    let x_axis = Axis::around("nominal pressure (MPa)", pressures().chain(reached)).numbered_at(&own);
    let quantity = if report.is_ratio() { "Dynamic friction over flat" } else { "Dynamic friction coefficient" };
    let y_axis = Axis::around(quantity, values().chain(opened));
    let wanted = widened().filter_map(|point| Some([point.pressure_mpa, point.value?])).collect();
    let of_sample = |(row, at): (usize, &Expected)| {
        let pressure_mpa = at.pressure_mpa + shift_mpa(condition(row));
        let (mark, colour) = style(condition(row));
        let [left, right] = [-1.0, 1.0].map(|side| pressure_mpa + side * HALF_BAR * range_mpa);
        let (low, high) = (at.low_95, at.high_95);
        [
            Layer::Area(vec![[left, low], [right, low], [right, high], [left, high]], vermilion, INTERVAL),
            Layer::marks(mark, [[pressure_mpa, at.median]], colour),
            Layer::marks(Mark::Ring, model(row).map(|model| [pressure_mpa, model]), blue),
        ]
    };
    let layers = [
        Layer::Area(band, green, BAND),
        Layer::Line(flat.clone(), GREY, 1.6),
        Layer::marks(Mark::Triangle, flat.iter().copied(), GREY),
        Layer::Line(wanted, green, 1.6),
    ];
    let measured = Layer::marks(Mark::Square, measured.iter().copied(), purple);
    let layers = layers.into_iter().chain(samples().flat_map(of_sample)).chain([measured]);
    Chart::new(title, 500.0, legend).plot(x_axis, y_axis, layers).svg()
}

/// Height of a panel with its axis, in picture units.
const PANEL_HEIGHT: f64 = 400.0;
/// Height of title and legend, in picture units.
const HEADING: f64 = 76.0;
/// Half the size of the mark of a design that is not on the Pareto front, in picture units.
const SMALL: f64 = 1.4;
/// Half the size of the mark of a design on the Pareto front, in picture units.
const LARGE: f64 = 2.6;
/// Maximum number of designs drawn in addition to the Pareto front; more marks would hide each other.
const MAX_OTHERS: usize = 4000;
/// An axis is logarithmic if the ratio of its maximum to its minimum value exceeds this number.
const WIDE: f64 = 20.0;

/// Draws the `compared` designs with the first goal along x and each further goal along y, in stacked panels. Marks the
/// design `chosen`; `name` begins the title.
///
/// # Errors
/// [`ChartError`] if there is no design or a value is not finite.
pub(crate) fn trade_offs(name: &str, compared: &Compared, chosen: &Pattern) -> Result<String, ChartError> {
    let title = format!("{name}: trade-offs");
    let Compared { wanted, front, dominated: others } = compared;
    let all = || front.iter().chain(others);
    check(&title, all().flat_map(|known| known.goals.iter().copied()))?;
    let chosen = all().find(|known| known.design == *chosen);
    let titles: Vec<&str> = wanted.goals.iter().map(|goal| goal.words()[0]).collect();
    let column = |goal: usize| all().map(move |known| known.goals[goal]);
    let is_wide = |goal: usize| {
        let [low, high] = extremes(column(goal));
        low > 0.0 && high > WIDE * low
    };
    let is_logarithmic: Vec<bool> = (0..titles.len()).map(is_wide).collect();
    let at = |goal: usize, value: f64| if is_logarithmic[goal] { value.log10() } else { value };
    let axis = |goal: usize| {
        let (title, values) = (titles[goal], column(goal).map(|value| at(goal, value)));
        if is_logarithmic[goal] { Axis::logarithmic(title, values) } else { Axis::around(title, values) }
    };
    let [blue, vermilion, ..] = PALETTE;
    let mut legend = vec![(Swatch::Mark(Mark::Square, blue), "no other beats it in every goal")];
    if !others.is_empty() {
        legend.push((Swatch::Mark(Mark::Circle, PALE), "other designs"));
    }
    if chosen.is_some() {
        legend.push((Swatch::Mark(Mark::Diamond, vermilion), "chosen"));
    }
    let [least, most] = extremes(column(0));
    let has_limit = wanted.goals[0] == TradeOffGoal::Misfit && (least..=most.max(0.0)).contains(&1.0);
    let mut background = String::new();
    let mut chart = Chart::new(&title, HEADING + PANEL_HEIGHT * titles.len().saturating_sub(1) as f64, legend);
    let [left, top, right, _] = chart.frame();
    for goal in 1..titles.len() {
        let top = top + PANEL_HEIGHT * (goal - 1) as f64;
        let place = |known: &TradeOff| [0, goal].map(|goal| at(goal, known.goals[goal]));
        let [x, y] = [0, goal].map(axis);
        let mut plot = Plot::new([left, top, right, top + PANEL_HEIGHT - 68.0], x, y);
        let every = others.len().div_ceil(MAX_OTHERS).max(1);
        // A dot on top of another dot is not visible.
        let mut drawn = BTreeSet::new();
        let cell = |known: &TradeOff| plot.at(place(known)).map(|length| (length / SMALL).round() as i64);
        for known in others.iter().step_by(every).filter(|known| drawn.insert(cell(known))) {
            let [x, y] = plot.at(place(known)).map(|length| (length * PRECISION).round());
            background += &format!("M{x} {y}h0");
        }
        plot.layers.extend(has_limit.then(|| Layer::Vertical(at(0, 1.0), "missed beyond")));
        plot.layers.push(Layer::Dots(front.iter().map(place).collect(), blue, LARGE));
        plot.layers.push(Layer::marks(Mark::Diamond, chosen.map(place), vermilion));
        plot.layers.push(Layer::marks(Mark::Ring, chosen.map(place), INK));
        chart.plots.push(plot);
    }
    Ok(behind(&chart.svg()?, &background))
}

/// Inserts `dots`, zero-length lines of an SVG path, behind all other elements of the picture. A single path takes a
/// tenth of the bytes of thousands of elements.
fn behind(svg: &str, dots: &str) -> String {
    let RGBColor(red, green, blue) = PALE;
    let width = 2.0 * SMALL * PRECISION;
    let path = format!(
        "<path d=\"{dots}\" fill=\"none\" stroke=\"#{red:02X}{green:02X}{blue:02X}\" stroke-width=\"{width}\" stroke-linecap=\"square\"/>"
    );
    // The first element is the background of the picture.
    match svg.split_once("/>\n") {
        Some((ground, rest)) if !dots.is_empty() => format!("{ground}/>\n{path}\n{rest}"),
        _ => svg.to_owned(),
    }
}

/// Colour of background designs, lighter than the axes.
const PALE: RGBColor = RGBColor(200, 200, 200);

/// Name of the file with the picture of [`mechanisms`].
pub const MECHANISMS_FILE: &str = "mechanisms.svg";
/// Width of the column with the names of the mechanisms, in picture units.
const NAMES: f64 = 300.0;
/// Gap between plots, in picture units.
const GAP: f64 = 40.0;
/// Height of a row, in picture units.
const ROW: f64 = 34.0;
/// Height of the title, in picture units.
const TITLE: f64 = 60.0;
/// Height of ticks and axis titles below the plots, in picture units.
const BELOW: f64 = 62.0;
/// Drawn range of ratios; wider intervals, which are implausible, end at the frame.
const RANGE: [f64; 2] = [0.0, 2.0];

/// Draws the ratios of both sectors of a disc and their quotient, one row per mechanism of the model error, at the load
/// with the index `learning.load`, which discriminates best between mechanisms. `name` is the name of the design.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw or a value is not finite.
pub fn mechanisms(name: &str, learning: &LearningReport) -> Result<String, ChartError> {
    let rows: Vec<(String, [&RatioPrediction; 3])> = learning
        .mechanisms
        .iter()
        .filter_map(|of| Some((of, of.loads.get(learning.load)?)))
        .map(|(of, at)| {
            let [first, second] = &at.ratios;
            (format!("{}, {}", of.mechanism, percent(of.weight)), [first, second, &at.quotient])
        })
        .collect();
    let pressure_mpa = rows.first().map_or(0.0, |(_, [.., quotient])| quotient.pressure_mpa);
    let title = format!("{name}: ratio to the flat surface at {pressure_mpa} MPa, median and 95 % of samples");
    let values = rows.iter().flat_map(|(_, of)| of.iter().flat_map(|at| [[at.ratio; 2], at.interval_95]).flatten());
    check(&title, values)?;
    let titles = ["sector 1", "sector 2", "sector 2 / sector 1"];
    let count = titles.len() as f64;
    let width = (WIDTH - NAMES - RIGHT - GAP * (count - 1.0)) / count;
    let height = ROW * rows.len() as f64;
    let mut chart = Chart::new(&title, TITLE + height + BELOW, Vec::new());
    let [_, top, ..] = chart.frame();
    for (place, quantity) in titles.iter().enumerate() {
        let left = NAMES + place as f64 * (width + GAP);
        let of_names = Axis::of_names("", rows.iter().rev().map(|(name, _)| name));
        let of_names = if place == 0 { of_names } else { of_names.unlabelled() };
        let colour = PALETTE[place];
        let mut layers = vec![Layer::Dashed([[1.0, -0.5], [1.0, rows.len() as f64 - 0.5]], GREY)];
        for (row, (_, of)) in rows.iter().rev().enumerate() {
            let ends = of[place].interval_95.map(|end| [end.clamp(RANGE[0], RANGE[1]), row as f64]);
            layers.push(Layer::Line(ends.to_vec(), colour, 3.0));
            let median = of[place].ratio;
            let shown = (RANGE[0]..=RANGE[1]).contains(&median).then_some([median, row as f64]);
            layers.push(Layer::marks(Mark::Circle, shown, colour));
        }
        chart.plot_in([left, top, left + width, top + height], Axis::over(quantity, RANGE), of_names, layers);
    }
    chart.svg()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::html::tests::fixture::report;
    use slipgrid_design::{MechanismReport, SectorRatios, TradeOffsWanted};
    use slipgrid_model::pattern::Planform;

    fn drawn(report: &DesignReport) -> Result<String, ChartError> {
        target_beside("Target", report, &[])
    }

    #[test]
    fn only_what_is_there_stands_in_the_legend() {
        let mut bare = report();
        bare.target.quantity = "mu_dynamic".into();
        (bare.sample.expected, bare.sample.modelled) = (Vec::new(), Vec::new());
        let svg = drawn(&bare).unwrap();
        assert!(svg.contains("\naccepted\n") && svg.contains("\nDynamic friction coefficient\n"));
        for absent in ["expected", "model alone", "flat", "earlier trials"] {
            assert!(!svg.contains(&format!("\n{absent}\n")), "{absent}");
        }
        let mut single = report();
        single.sample.expected.truncate(1);
        let full = target_beside("Target", &single, &[[1.3, 0.9]]).unwrap();
        for present in ["expected", "95 % of samples", "model alone", "flat", "earlier trials"] {
            assert!(full.contains(&format!("\n{present}\n")), "{present}");
        }
        // Every series stands at its own pressure, and a ring leaves the mark inside it visible.
        let circles: Vec<&str> = full.split("<circle ").skip(1).filter_map(|rest| rest.split('"').nth(1)).collect();
        assert_eq!(circles.len(), 4, "two in the legend, two in the plot");
        assert_eq!(circles[2], circles[3]);
        // A target with a single point is drawn as well.
        single.target.pressure_mpa.truncate(1);
        assert!(drawn(&single).is_ok());
    }

    #[test]
    fn conditions_stand_side_by_side_with_a_mark_and_a_name_each() {
        let mut both = report();
        let count = |svg: &str| ["<polygon", "<circle"].map(|shape| svg.matches(shape).count());
        let [polygons, circles] = count(&drawn(&both).unwrap());
        let further = both.sample.expected.clone().into_iter().map(|at| Expected { speed_mm_s: 7.0, ..at });
        both.sample.expected.extend(further);
        let svg = drawn(&both).unwrap();
        // Two bars and two diamonds, and a diamond in the legend.
        assert_eq!(count(&svg), [polygons + 5, circles]);
        let names = ["\nexpected, 2 mm/s, 40 %\n", "\nexpected, 7 mm/s, 40 %\n"].map(|name| svg.find(name));
        assert!(names.is_sorted() && !names.contains(&None) && !svg.contains("\nexpected\n"), "{names:?}");
    }

    #[test]
    fn bands_may_be_open_and_goals_have_none() {
        let mut open = report();
        (open.target.value, open.target.lowest) = (None, vec![None; 2]);
        let svg = drawn(&open).unwrap();
        assert!(svg.contains("\naccepted\n") && svg.contains("<polygon"));
        open.target.highest = vec![None; 2];
        let svg = drawn(&open).unwrap();
        assert!(!svg.contains("accepted") && svg.contains("\n95 % of samples\n"));
    }

    #[test]
    fn a_target_without_points_is_refused() {
        assert!(matches!(drawn(&DesignReport::default()), Err(ChartError::Empty { .. })));
        let mut odd = report();
        odd.sample.expected[0].median = f64::NAN;
        assert!(matches!(drawn(&odd), Err(ChartError::NotFinite { .. })));
    }

    #[test]
    fn every_design_of_the_front_and_the_chosen_one_are_drawn() {
        let design = |width_um: f64| Pattern::new(Planform::Groove, width_um * 1e-6, 1e-4, 1e-5).unwrap();
        let known = |width_um: f64, goals: [f64; 3]| TradeOff { design: design(width_um), goals: goals.to_vec() };
        let front = vec![known(40.0, [0.1, 300.0, 5.0]), known(50.0, [1.0, 30.0, 6.0]), known(60.0, [10.0, 3.0, 4.0])];
        let goals = vec![TradeOffGoal::Misfit, TradeOffGoal::LaserTime, TradeOffGoal::PeakPressure];
        let wanted = TradeOffsWanted { goals: goals.clone(), designs: 4 };
        let mut compared = Compared { wanted, front, dominated: vec![known(70.0, [5.0, 400.0, 9.0])] };
        let svg = trade_offs("a", &compared, &design(50.0)).unwrap();
        // Each of the two panels has three dots of the front, one dot behind them, and a diamond; the legend has a square, a circle and a diamond.
        assert_eq!(svg.matches("<rect").count(), 1 + 2 * 3);
        assert_eq!(svg.matches("h0").count(), 2);
        let titles: Vec<&str> = goals.iter().map(|goal| goal.words()[0]).collect();
        for text in
            ["a: trade-offs", "no other beats it in every goal", "chosen", "missed beyond"].iter().chain(&titles)
        {
            assert!(svg.contains(&format!("\n{text}\n")), "{text}");
        }
        (compared.front, compared.dominated) = (Vec::new(), Vec::new());
        assert!(matches!(trade_offs("a", &compared, &design(50.0)), Err(ChartError::Empty { .. })));
    }

    #[test]
    fn every_mechanism_is_a_row_and_wide_intervals_end_at_the_frame() {
        let at = |ratio: f64, interval_95| RatioPrediction {
            pressure_mpa: 2.6,
            speed_mm_s: 2.0,
            humidity_pct: 40.0,
            modelled: 1.0,
            ratio,
            interval_95,
        };
        let row = |name: &str, median: f64| MechanismReport {
            mechanism: name.to_owned(),
            weight: 0.5,
            loads: vec![SectorRatios {
                ratios: [at(median, [0.5, 7.0]), at(1.0, [0.9, 1.1])],
                quotient: at(1.0, [0.9, 1.1]),
            }],
        };
        let learning = |mechanisms| LearningReport {
            bits: 0.0,
            open_bits: 0.0,
            why: String::new(),
            second_disc: String::new(),
            textures: Vec::new(),
            load: 0,
            mechanisms,
        };
        let svg = mechanisms("t", &learning(vec![row("areal density", 0.8), row("edges", 0.7)])).unwrap();
        // Two rows of three marks; names stand once.
        assert_eq!((svg.matches("<circle").count(), svg.matches("areal density").count()), (6, 1));
        let near = |text: &str| svg.find(text).unwrap();
        assert!(near("\nsector 1\n") < near("\nsector 2\n"));
        assert!(matches!(mechanisms("t", &learning(Vec::new())), Err(ChartError::Empty { .. })));
        assert!(matches!(mechanisms("t", &learning(vec![row("b", f64::NAN)])), Err(ChartError::NotFinite { .. })));
    }
}
