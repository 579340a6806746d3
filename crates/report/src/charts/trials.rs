//! Trials: what was predicted of each ratio before it was measured, and all ratios against what the texture is.

use super::canvas::{GREY, LEFT, Mark, PALETTE, RIGHT, Swatch, WIDTH, picture};
use super::plot::{Axis, Plot};
use super::{ChartError, Estimate, check};

/// A measured ratio beside what was predicted of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prediction {
    /// Number of its trial, from 0.
    pub trial: usize,
    /// Measured ratio.
    pub measured: f64,
    /// What was predicted.
    pub predicted: Estimate,
    /// Ends of its interval of 95 %.
    pub interval: [f64; 2],
}

/// The ledger of trials.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrialsChart<'a> {
    /// Title.
    pub title: &'a str,
    /// Names of the trials.
    pub names: &'a [String],
    /// Every measured ratio, in order.
    pub predictions: &'a [Prediction],
    /// What ratios are drawn against, each with the points in the same order.
    pub panels: &'a [(&'a str, Vec<[f64; 2]>)],
}

/// Height of the first plot's lower end, and of the picture.
const FIRST: f64 = 380.0;
const HEIGHT: f64 = 680.0;
/// Room between panels, for the numbers of the axis.
const GAP: f64 = 60.0;
/// Room above and below all ratios over their range, at most.
const BEYOND: f64 = 0.75;
/// Trials that the legend names.
const NAMED: usize = 4;

/// Draws the ledger: predictions above, ratios against texture and load below.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw or a value is not finite.
pub fn trials(chart: &TrialsChart<'_>) -> Result<String, ChartError> {
    let ends: Vec<f64> =
        chart.predictions.iter().flat_map(|of| [of.interval[0], of.interval[1], of.measured]).collect();
    check(chart.title, &ends)?;
    let count = chart.predictions.len();
    // Before a first trial an interval may be far wider than all that is measured: bars end at the frame.
    let middles = || chart.predictions.iter().flat_map(|of| [of.predicted.value, of.measured]);
    let (least, most) =
        middles().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
    let room = (BEYOND * (most - least)).max(BEYOND * 0.02 * most);
    let [lowest, highest] = [least - room, most + room];
    let drawn = Axis::around("ratio patterned / flat", ends.iter().map(|end| end.clamp(lowest, highest)));
    let y_axis = if ends.iter().all(|end| (lowest..=highest).contains(end)) {
        drawn
    } else {
        Axis::over("ratio patterned / flat", [lowest, highest])
    };
    let colour = |trial: usize| PALETTE[trial % PALETTE.len()];
    picture(HEIGHT, |canvas| {
        let mut legend = vec![(Swatch::Mark(Mark::Circle, GREY), "predicted before, with 95 %")];
        for (trial, name) in chart.names.iter().enumerate().take(NAMED) {
            legend.push((Swatch::Mark(Mark::Square, colour(trial)), name));
        }
        let top = canvas.heading(chart.title, &legend)?;
        let numbers = (1..=count).map(|number| number.to_string()).collect();
        let x_axis = Axis::of_names("number of the measured ratio", numbers);
        let plot = Plot::new(canvas, [LEFT, top, WIDTH - RIGHT, FIRST], x_axis, y_axis.clone())?;
        for (place, of) in chart.predictions.iter().enumerate() {
            let [low, high] = of.interval.map(|end| end.clamp(lowest, highest));
            let (middle, half) = (f64::midpoint(low, high), 0.5 * (high - low));
            plot.error_bar([place as f64, middle], half, -3.0, GREY)?;
            plot.mark(Mark::Circle, [place as f64, of.predicted.value], None, -3.0, GREY)?;
            plot.mark(Mark::Square, [place as f64, of.measured], None, 3.0, colour(of.trial))?;
        }
        let width = (WIDTH - LEFT - RIGHT - GAP * (chart.panels.len() as f64 - 1.0)) / chart.panels.len().max(1) as f64;
        for (number, (name, points)) in chart.panels.iter().enumerate() {
            let left = LEFT + number as f64 * (width + GAP);
            let x_axis = Axis::from_zero(name, points.iter().map(|point| point[0]));
            let y_axis =
                Axis::around(if number == 0 { "measured ratio" } else { "" }, points.iter().map(|point| point[1]));
            let plot = Plot::new(canvas, [left, FIRST + GAP + 20.0, left + width, HEIGHT - 60.0], x_axis, y_axis)?;
            for (point, of) in points.iter().zip(chart.predictions) {
                plot.mark(Mark::Square, *point, None, 0.0, colour(of.trial))?;
            }
        }
        Ok(())
    })
}
