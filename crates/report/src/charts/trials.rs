//! Chart of trials: predicted against measured ratios, and all ratios against features of the texture.

use super::canvas::{GREY, LEFT, Mark, PALETTE, RIGHT, Swatch, WIDTH, picture};
use super::plot::{Axis, Plot};
use super::{ChartError, Estimate, check};

/// Measured ratio with its prediction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prediction {
    /// Index of the trial, from 0.
    pub trial: usize,
    /// Measured ratio.
    pub measured: f64,
    /// Prediction.
    pub predicted: Estimate,
    /// Ends of the prediction's 95 % interval.
    pub interval: [f64; 2],
}

/// Ledger of trials.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrialsChart<'a> {
    /// Title.
    pub title: &'a str,
    /// Names of the trials.
    pub names: &'a [String],
    /// All measured ratios, in order.
    pub predictions: &'a [Prediction],
    /// Panels of ratios against a quantity: title and points, in the order of the ratios.
    pub panels: &'a [(&'a str, Vec<[f64; 2]>)],
}

/// Lower end of the first plot, and height of the picture.
const FIRST: f64 = 380.0;
const HEIGHT: f64 = 680.0;
/// Gap between panels, for the numbers of the axis.
const GAP: f64 = 60.0;
/// Maximum margin above and below all ratios, relative to their range.
const BEYOND: f64 = 0.75;
/// Maximum number of trials named in the legend.
const NAMED: usize = 4;

/// Draws the ledger: predictions at the top, ratios against texture and load below.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw or a value is not finite.
pub fn trials(chart: &TrialsChart<'_>) -> Result<String, ChartError> {
    let ends: Vec<f64> =
        chart.predictions.iter().flat_map(|of| [of.interval[0], of.interval[1], of.measured]).collect();
    check(chart.title, &ends)?;
    let count = chart.predictions.len();
    // Before a first trial, an interval may be far wider than the range of measured values: bars end at the frame.
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
