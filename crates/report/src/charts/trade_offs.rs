use std::collections::BTreeSet;

use plotters::style::RGBColor;

use super::canvas::{INK, LEFT, Mark, PALETTE, PRECISION, RIGHT, Swatch, WIDTH, picture};
use super::plot::{Axis, Plot};
use super::{ChartError, check};

/// Designs by two or three goals, all minimized.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TradeOffsChart<'a> {
    /// Title.
    pub title: &'a str,
    /// Titles of the two or three goals with their units.
    pub titles: &'a [&'a str],
    /// Non-dominated designs.
    pub front: &'a [&'a [f64]],
    /// Other designs; may be empty.
    pub others: &'a [&'a [f64]],
    /// The chosen design.
    pub chosen: Option<&'a [f64]>,
    /// Limit of the first goal, with a label for the values left of it.
    pub limit: Option<(f64, &'a str)>,
}

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

/// Draws the first goal against each other goal, with the panels stacked.
///
/// # Errors
/// [`ChartError`] if there is no design, the numbers of goals differ or a value is not finite.
pub fn trade_offs(chart: &TradeOffsChart<'_>) -> Result<String, ChartError> {
    let all = || chart.front.iter().chain(chart.others).copied().chain(chart.chosen);
    check(chart.title, all().flatten())?;
    if let Some(odd) = all().find(|goals| goals.len() != chart.titles.len()) {
        let (left, right) = (chart.titles.len(), odd.len());
        return Err(ChartError::LengthMismatch { title: chart.title.to_owned(), left, right });
    }
    let Some((first, rest)) = chart.titles.split_first().filter(|(_, rest)| !rest.is_empty()) else {
        return Err(ChartError::Empty { title: chart.title.to_owned() });
    };
    let scales: Vec<Scale> = (0..chart.titles.len()).map(|goal| Scale::of(all().map(|goals| goals[goal]))).collect();
    let spans =
        all().map(|goals| goals[0]).fold(f64::INFINITY, f64::min)..=all().map(|goals| goals[0]).fold(0.0, f64::max);
    let [blue, vermilion, ..] = PALETTE;
    let mut legend = vec![(Swatch::Mark(Mark::Square, blue), "no other beats it in every goal")];
    if !chart.others.is_empty() {
        legend.push((Swatch::Mark(Mark::Circle, PALE), "other designs"));
    }
    if chart.chosen.is_some() {
        legend.push((Swatch::Mark(Mark::Diamond, vermilion), "chosen"));
    }
    let mut background = String::new();
    let svg = picture(HEADING + PANEL_HEIGHT * rest.len() as f64, |canvas| {
        let top = canvas.heading(chart.title, &legend)?;
        for (panel, title) in rest.iter().enumerate() {
            let goal = panel + 1;
            let top = top + PANEL_HEIGHT * panel as f64;
            let place = |goals: &[f64]| [scales[0].at(goals[0]), scales[goal].at(goals[goal])];
            let axis = |title: &str, goal: usize| scales[goal].axis(title, all().map(|goals| goals[goal]));
            let frame = [LEFT, top, WIDTH - RIGHT, top + PANEL_HEIGHT - 68.0];
            let plot = Plot::new(canvas, frame, axis(first, 0), axis(title, goal))?;
            if let Some((value, word)) = chart.limit.filter(|(value, _)| value.is_finite() && spans.contains(value)) {
                plot.vertical(scales[0].at(value), word)?;
            }
            let dot = |goals: &[f64], half: f64, color: RGBColor| {
                let [x, y] = plot.at(place(goals));
                canvas.rectangle([[x - half, y - half], [x + half, y + half]], color, 1.0)
            };
            let every = chart.others.len().div_ceil(MAX_OTHERS).max(1);
            // A dot on top of another one is not seen.
            let mut drawn = BTreeSet::new();
            let cell = |goals: &[f64]| plot.at(place(goals)).map(|length| (length / SMALL).round() as i64);
            for goals in chart.others.iter().step_by(every).filter(|goals| drawn.insert(cell(goals))) {
                let [x, y] = plot.at(place(goals)).map(|length| (length * PRECISION).round());
                background += &format!("M{x} {y}h0");
            }
            for goals in chart.front {
                dot(goals, LARGE, blue)?;
            }
            if let Some(goals) = chart.chosen {
                plot.mark(Mark::Diamond, place(goals), None, 0.0, vermilion)?;
                plot.mark(Mark::Ring, place(goals), None, 0.0, INK)?;
            }
        }
        Ok(())
    })?;
    Ok(behind(&svg, &background))
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
        let [low, high] = values.fold([f64::INFINITY, 0.0_f64], |[low, high], v| [low.min(v), high.max(v)]);
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
        let chart = TradeOffsChart {
            title: "Trade-offs",
            titles: &["misfit (tolerances)", "time (s)", "pressure (MPa)"],
            front: &front,
            others: &others,
            chosen: Some(&[1.0, 30.0, 6.0]),
            limit: Some((1.0, "right of it missed")),
        };
        let svg = trade_offs(&chart).unwrap();
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
        let uneven: Vec<&[f64]> = vec![&[0.1]];
        assert!(matches!(
            trade_offs(&TradeOffsChart { front: &uneven, ..chart }),
            Err(ChartError::LengthMismatch { .. })
        ));
        let none = TradeOffsChart { front: &[], others: &[], chosen: None, ..chart };
        assert!(matches!(trade_offs(&none), Err(ChartError::Empty { .. })));
    }
}
