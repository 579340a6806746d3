//! Chart of cross-validation: measured ratios against the ratios that all other trials predict.

use super::axis::{Axis, extremes};
use super::canvas::{GREY, Mark, PALETTE, Swatch};
use super::chart::{Chart, Layer};
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
    check("measured against predicted", predictions.iter().flat_map(Prediction::values))?;
    let [low, high] = extremes(predictions.iter().flat_map(|of| [of.predicted, of.measured]));
    // An interval may be far wider than all ratios: bars end at the frame.
    let room = (0.5 * (high - low)).max(0.01 * high);
    let range = [low - room, high + room];
    let colour = |trial: usize| PALETTE[trial % PALETTE.len()];
    let mark = |trial: usize| Mark::FILLED[trial % Mark::FILLED.len()];
    let short: Vec<String> = names.iter().take(NAMED).map(|name| name.chars().take(MAX_LETTERS).collect()).collect();
    let mut legend = vec![(Swatch::Dashed(GREY), "as predicted")];
    let named = short.iter().enumerate();
    legend.extend(named.map(|(trial, name)| (Swatch::Mark(mark(trial), colour(trial)), name.as_str())));
    let mut layers = vec![Layer::Dashed([[range[0]; 2], [range[1]; 2]], GREY)];
    for of in predictions {
        let ends = of.interval.map(|end| [end.clamp(range[0], range[1]), of.measured]);
        layers.push(Layer::Line(ends.to_vec(), colour(of.trial), 1.6));
        layers.push(Layer::marks(mark(of.trial), [[of.predicted, of.measured]], colour(of.trial)));
    }
    let x_axis = Axis::over("predicted by all other trials, with 95 %", range);
    Chart::new("", HEIGHT, legend).plot(x_axis, Axis::over("measured ratio", range), layers).svg()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_ratio_is_a_mark_and_wide_intervals_end_at_the_frame() {
        let of = |trial, measured, predicted, interval| Prediction { trial, measured, predicted, interval };
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
