//! Chart of cross-validation: measured ratios against the ratios that all other trials predict.

use super::canvas::{GREY, LEFT, Mark, NARROW, PALETTE, RIGHT, Swatch, picture_of_size};
use super::plot::{Axis, Plot};
use super::{ChartError, Prediction, check};

/// Height of the picture; with the legend above it the plot is about square.
const HEIGHT: f64 = 500.0;
/// Maximum number of letters of a name in the legend.
const MAX_LETTERS: usize = 20;
/// Maximum number of trials named in the legend.
const NAMED: usize = 4;

/// Draws `predictions` of trials named `names`, each made by all other trials, with their 95 % intervals. On the dashed
/// line a prediction equals its measurement.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw or a value is not finite.
pub fn left_out(names: &[String], predictions: &[Prediction]) -> Result<String, ChartError> {
    let each = |of: &Prediction| [of.interval[0], of.interval[1], of.predicted.value, of.measured];
    let values: Vec<f64> = predictions.iter().flat_map(each).collect();
    check("measured against predicted", &values)?;
    let middles = || predictions.iter().flat_map(|of| [of.predicted.value, of.measured]);
    let [low, high] = middles().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)]);
    // An interval may be far wider than all ratios: bars end at the frame.
    let room = (0.5 * (high - low)).max(0.01 * high);
    let range = [low - room, high + room];
    let colour = |trial: usize| PALETTE[trial % PALETTE.len()];
    let mark = |trial: usize| Mark::FILLED[trial % Mark::FILLED.len()];
    picture_of_size([NARROW, HEIGHT], |canvas| {
        let mut legend = vec![(Swatch::Dashed(GREY), "as predicted")];
        let short: Vec<String> =
            names.iter().take(NAMED).map(|name| name.chars().take(MAX_LETTERS).collect()).collect();
        for (trial, name) in short.iter().enumerate() {
            legend.push((Swatch::Mark(mark(trial), colour(trial)), name));
        }
        let top = canvas.heading("", &legend)?;
        let axes = ["predicted by all other trials, with 95 %", "measured ratio"].map(|title| Axis::over(title, range));
        let [x_axis, y_axis] = axes;
        let plot = Plot::new(canvas, [LEFT, top, NARROW - RIGHT, HEIGHT - 62.0], x_axis, y_axis)?;
        plot.dashed([[range[0]; 2], [range[1]; 2]], GREY)?;
        for of in predictions {
            let [from, to] = of.interval.map(|end| end.clamp(range[0], range[1]));
            plot.line(&[[from, of.measured], [to, of.measured]], colour(of.trial), 1.6)?;
            plot.mark(mark(of.trial), [of.predicted.value, of.measured], None, 0.0, colour(of.trial))?;
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::charts::Estimate;

    #[test]
    fn every_ratio_is_a_mark_and_wide_intervals_end_at_the_frame() {
        let of = |trial, measured, value, interval| Prediction {
            trial,
            measured,
            predicted: Estimate { value, error: None },
            interval,
        };
        let all = [of(0, 0.8, 0.85, [0.7, 1.0]), of(1, 0.9, 0.86, [-4.0, 9.0])];
        let svg = left_out(&["a".to_owned(), "b".to_owned()], &all).unwrap();
        // The first trial has circles, the second squares; one of each stands in the legend.
        assert_eq!(svg.matches("<circle").count(), 2);
        assert_eq!(svg.matches("<polygon").count(), 2);
        assert!(!svg.contains("points=\"-") && svg.contains("predicted by all other trials"));
        assert!(matches!(left_out(&[], &[]), Err(ChartError::Empty { .. })));
        let odd = [of(0, f64::NAN, 0.8, [0.7, 0.9])];
        assert!(matches!(left_out(&[], &odd), Err(ChartError::NotFinite { .. })));
    }
}
