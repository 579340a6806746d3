//! Chart of designs by several goals.

use std::collections::BTreeSet;

use plotters::style::RGBColor;

use super::axis::{Axis, extremes};
use super::canvas::{INK, Mark, PALETTE, PRECISION, Swatch};
use super::chart::{Chart, Layer, Plot};
use super::{ChartError, check, check_length};

/// Height of a panel with its axis, and of title and legend.
const PANEL_HEIGHT: f64 = 400.0;
const HEADING: f64 = 76.0;
/// Half the size of the mark of a design off the front, and of a design on the front.
const SMALL: f64 = 1.4;
const LARGE: f64 = 2.6;
/// Maximum number of designs drawn besides the front; more would hide each other.
const MAX_OTHERS: usize = 4000;
/// Maximum over minimum from which an axis is logarithmic.
const WIDE: f64 = 20.0;

/// Draws designs, each by two or three goals that are minimized and have `titles` with units: the first goal against each other
/// goal, with the panels stacked. `front` are the non-dominated designs, `others` may be empty, and `limit` is a value of the
/// first goal with a label.
///
/// # Errors
/// [`ChartError`] if there is no design, the numbers of goals differ or a value is not finite.
pub fn trade_offs(
    title: &str,
    titles: &[&str],
    front: &[&[f64]],
    others: &[&[f64]],
    chosen: Option<&[f64]>,
    limit: Option<(f64, &str)>,
) -> Result<String, ChartError> {
    let all = || front.iter().chain(others).copied().chain(chosen);
    check(title, all().flatten().copied())?;
    all().try_for_each(|goals| check_length(title, titles.len(), goals.len()))?;
    let column = |goal: usize| all().map(move |goals| goals[goal]);
    let scales: Vec<Scale> = (0..titles.len()).map(|goal| Scale::of(column(goal))).collect();
    let [blue, vermilion, ..] = PALETTE;
    let mut legend = vec![(Swatch::Mark(Mark::Square, blue), "no other beats it in every goal")];
    if !others.is_empty() {
        legend.push((Swatch::Mark(Mark::Circle, PALE), "other designs"));
    }
    if chosen.is_some() {
        legend.push((Swatch::Mark(Mark::Diamond, vermilion), "chosen"));
    }
    let [least, most] = extremes(column(0));
    let limit = limit.filter(|(value, _)| value.is_finite() && (least..=most.max(0.0)).contains(value));
    let mut background = String::new();
    let mut chart = Chart::new(title, HEADING + PANEL_HEIGHT * titles.len().saturating_sub(1) as f64, legend);
    let [left, top, right, _] = chart.frame();
    for goal in 1..titles.len() {
        let top = top + PANEL_HEIGHT * (goal - 1) as f64;
        let place = |goals: &[f64]| [0, goal].map(|goal| scales[goal].at(goals[goal]));
        let [x, y] = [0, goal].map(|goal| scales[goal].axis(titles[goal], column(goal)));
        let mut plot = Plot::new([left, top, right, top + PANEL_HEIGHT - 68.0], x, y);
        let every = others.len().div_ceil(MAX_OTHERS).max(1);
        // A dot on top of another one is not seen.
        let mut drawn = BTreeSet::new();
        let cell = |goals: &[f64]| plot.at(place(goals)).map(|length| (length / SMALL).round() as i64);
        for goals in others.iter().step_by(every).filter(|goals| drawn.insert(cell(goals))) {
            let [x, y] = plot.at(place(goals)).map(|length| (length * PRECISION).round());
            background += &format!("M{x} {y}h0");
        }
        plot.layers.extend(limit.map(|(value, word)| Layer::Vertical(scales[0].at(value), word)));
        plot.layers.push(Layer::Dots(front.iter().map(|goals| place(goals)).collect(), blue, LARGE));
        plot.layers.push(Layer::marks(Mark::Diamond, chosen.map(place), vermilion));
        plot.layers.push(Layer::marks(Mark::Ring, chosen.map(place), INK));
        chart.plots.push(plot);
    }
    Ok(behind(&chart.svg()?, &background))
}

/// Adds the `dots`, zero-length lines of a path, behind all that is drawn: as a single element they take a tenth of the
/// bytes of thousands.
fn behind(svg: &str, dots: &str) -> String {
    let RGBColor(red, green, blue) = PALE;
    let width = 2.0 * SMALL * PRECISION;
    let path = format!(
        "<path d=\"{dots}\" fill=\"none\" stroke=\"#{red:02X}{green:02X}{blue:02X}\" stroke-width=\"{width}\" stroke-linecap=\"square\"/>"
    );
    // The first element is the ground of the picture.
    match svg.split_once("/>\n") {
        Some((ground, rest)) if !dots.is_empty() => format!("{ground}/>\n{path}\n{rest}"),
        _ => svg.to_owned(),
    }
}

/// Colour of background designs, lighter than the axes.
const PALE: RGBColor = RGBColor(200, 200, 200);

/// Scale of a goal's axis.
#[derive(Clone, Copy)]
enum Scale {
    Linear,
    Logarithmic,
}

impl Scale {
    /// Chooses a logarithmic scale if values are positive and span more than [`WIDE`].
    fn of(values: impl Iterator<Item = f64>) -> Self {
        let [low, high] = extremes(values);
        if low > 0.0 && high > WIDE * low { Self::Logarithmic } else { Self::Linear }
    }

    fn at(self, value: f64) -> f64 {
        match self {
            Self::Linear => value,
            Self::Logarithmic => value.log10(),
        }
    }

    fn axis(self, title: &str, values: impl Iterator<Item = f64>) -> Axis {
        match self {
            Self::Linear => Axis::around(title, values),
            Self::Logarithmic => Axis::logarithmic(title, values.map(f64::log10)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_design_of_the_front_and_the_chosen_one_are_drawn() {
        let front: Vec<&[f64]> = vec![&[0.1, 300.0, 5.0], &[1.0, 30.0, 6.0], &[10.0, 3.0, 4.0]];
        let others: Vec<&[f64]> = vec![&[5.0, 400.0, 9.0]];
        let drawn = |front: &[&[f64]], others: &[&[f64]], chosen: Option<&[f64]>| {
            let titles = ["misfit (tolerances)", "time (s)", "pressure (MPa)"];
            trade_offs("Trade-offs", &titles, front, others, chosen, Some((1.0, "right of it missed")))
        };
        let svg = drawn(&front, &others, Some(&[1.0, 30.0, 6.0])).unwrap();
        // Each of the two panels has three dots of the front, one dot behind them, and a diamond; the legend has a square, a circle and a diamond.
        assert_eq!(svg.matches("<rect").count(), 1 + 2 * 3);
        assert_eq!(svg.matches("h0").count(), 2);
        for text in [
            "no other beats it in every goal",
            "chosen",
            "misfit (tolerances)",
            "time (s)",
            "pressure (MPa)",
            "right of it missed",
        ] {
            assert!(svg.contains(&format!("\n{text}\n")), "{text}");
        }
        assert!(matches!(drawn(&[&[0.1]], &others, None), Err(ChartError::LengthMismatch { .. })));
        assert!(matches!(drawn(&[], &[], None), Err(ChartError::Empty { .. })));
    }
}
