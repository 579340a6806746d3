//! Chart of trials: predicted against measured ratios, and all ratios against features of the texture.

use super::axis::{Axis, extremes};
use super::canvas::{GREY, Mark, PALETTE, Swatch};
use super::chart::{Chart, Layer};
use super::{ChartError, check};

/// Measured ratio with its prediction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prediction {
    /// Index of the trial, from 0.
    pub trial: usize,
    /// Measured ratio.
    pub measured: f64,
    /// Predicted ratio.
    pub predicted: f64,
    /// Ends of the prediction's 95 % interval.
    pub interval: [f64; 2],
}

impl Prediction {
    /// All ratios.
    pub(super) fn values(&self) -> [f64; 4] {
        [self.interval[0], self.interval[1], self.predicted, self.measured]
    }
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

/// Draws `predictions` of all measured ratios, in order, of trials named `names`; below, one panel of ratios against each
/// quantity, with its title and its points in the order of the ratios.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw or a value is not finite.
pub fn trials(
    title: &str,
    names: &[String],
    predictions: &[Prediction],
    panels: &[(&str, Vec<[f64; 2]>)],
) -> Result<String, ChartError> {
    check(title, predictions.iter().flat_map(Prediction::values))?;
    // Before a first trial, an interval may be far wider than the range of measured values: bars end at the frame.
    let [least, most] = extremes(predictions.iter().flat_map(|of| [of.predicted, of.measured]));
    let room = (BEYOND * (most - least)).max(BEYOND * 0.02 * most);
    let [lowest, highest] = [least - room, most + room];
    let ends = || predictions.iter().flat_map(|of| [of.interval[0], of.interval[1], of.measured]);
    let y_axis = if ends().all(|end| (lowest..=highest).contains(&end)) {
        Axis::around("ratio patterned / flat", ends())
    } else {
        Axis::over("ratio patterned / flat", [lowest, highest])
    };
    let colour = |trial: usize| PALETTE[trial % PALETTE.len()];
    let mut legend = vec![(Swatch::Mark(Mark::Circle, GREY), "predicted before, with 95 %")];
    let named = names.iter().enumerate().take(NAMED);
    legend.extend(named.map(|(trial, name)| (Swatch::Mark(Mark::Square, colour(trial)), name.as_str())));
    let layers = predictions.iter().enumerate().flat_map(|(place, of)| {
        let x = place as f64;
        [
            Layer::Bar(x, of.interval.map(|end| end.clamp(lowest, highest)), GREY, -3.0),
            Layer::Marks(Mark::Circle, vec![(x, of.predicted.into())], GREY, -3.0),
            Layer::Marks(Mark::Square, vec![(x, of.measured.into())], colour(of.trial), 3.0),
        ]
    });
    let mut chart = Chart::new(title, HEIGHT, legend);
    let [left, top, right, _] = chart.frame();
    let x_axis = Axis::of_names("number of the measured ratio", 1..=predictions.len());
    chart.plot_in([left, top, right, FIRST], x_axis, y_axis, layers);
    let width = (right - left - GAP * (panels.len() as f64 - 1.0)) / panels.len().max(1) as f64;
    for (number, (name, points)) in panels.iter().enumerate() {
        let left = left + number as f64 * (width + GAP);
        let x_axis = Axis::from_zero(name, points.iter().map(|point| point[0]));
        let title = if number == 0 { "measured ratio" } else { "" };
        let y_axis = Axis::around(title, points.iter().map(|point| point[1]));
        let marks = points.iter().zip(predictions);
        let marks = marks.map(|(point, of)| Layer::marks(Mark::Square, [*point], colour(of.trial)));
        chart.plot_in([left, FIRST + GAP + 20.0, left + width, HEIGHT - 60.0], x_axis, y_axis, marks);
    }
    chart.svg()
}
