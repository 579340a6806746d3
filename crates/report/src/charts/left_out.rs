//! Chart of cross-validation: measured ratios against the ratios that all other trials predict.

use super::axis::{Axis, extremes};
use super::canvas::{GREY, Mark, PALETTE, Swatch};
use super::chart::{Chart, Layer};
use super::{ChartError, check};
use crate::trials::TrialReport;

/// Height of the picture; with the legend above it the plot is about square.
const HEIGHT: f64 = 500.0;
/// Maximum number of letters of a name in the legend.
const MAX_LETTERS: usize = 20;
/// Maximum number of trials named in the legend.
const NAMED: usize = 4;

/// Draws the measured ratios of `trials` against those that all other trials predict, where there are any, with their 95 %
/// intervals. On the dashed line a prediction equals its measurement.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw or a value is not finite.
pub fn left_out(trials: &[TrialReport]) -> Result<String, ChartError> {
    let styles = PALETTE.into_iter().cycle().zip(Mark::FILLED.into_iter().cycle());
    let styled = trials.iter().zip(styles.clone());
    let each = styled.flat_map(|(trial, style)| trial.measured.iter().map(move |at| (at, style)));
    let rows: Vec<_> = each.filter(|(at, _)| at.without_trial.known > 0).collect();
    let middles = || rows.iter().flat_map(|(at, _)| [at.without_trial.ratio, at.measured]);
    let ends = rows.iter().flat_map(|(at, _)| at.without_trial.interval_95);
    check("measured against predicted", middles().chain(ends))?;
    let [low, high] = extremes(middles());
    // An interval may be far wider than all ratios: bars end at the frame.
    let room = (0.5 * (high - low)).max(0.01 * high);
    let range = [low - room, high + room];
    let short = |of: &TrialReport| of.name.chars().take(MAX_LETTERS).collect::<String>();
    let names: Vec<String> = trials.iter().take(NAMED).map(short).collect();
    let mut legend = vec![(Swatch::Dashed(GREY), "as predicted")];
    legend.extend(styles.zip(&names).map(|((colour, mark), name)| (Swatch::Mark(mark, colour), name.as_str())));
    let mut layers = vec![Layer::Dashed([[range[0]; 2], [range[1]; 2]], GREY)];
    for (at, (colour, mark)) in rows {
        let ends = at.without_trial.interval_95.map(|end| [end.clamp(range[0], range[1]), at.measured]);
        layers.push(Layer::Line(ends.to_vec(), colour, 1.6));
        layers.push(Layer::marks(mark, [[at.without_trial.ratio, at.measured]], colour));
    }
    let x_axis = Axis::over("predicted by all other trials, with 95 %", range);
    Chart::new("", HEIGHT, legend).plot(x_axis, Axis::over("measured ratio", range), layers).svg()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trials::{MeasuredReport, PredictedReport};

    #[test]
    fn every_ratio_is_a_mark_and_wide_intervals_end_at_the_frame() {
        let trial = |measured, ratio, interval_95| {
            let without_trial = PredictedReport { ratio, interval_95, known: 1, ..PredictedReport::default() };
            let at = MeasuredReport { measured, without_trial, ..MeasuredReport::default() };
            TrialReport { measured: vec![at], ..TrialReport::default() }
        };
        let svg = left_out(&[trial(0.8, 0.85, [0.7, 1.0]), trial(0.9, 0.86, [-4.0, 9.0])]).unwrap();
        // The first trial has circles, the second squares; one of each stands in the legend.
        assert_eq!(svg.matches("<circle").count(), 2);
        assert_eq!(svg.matches("<polygon").count(), 2);
        assert!(!svg.contains("points=\"-") && svg.contains("predicted by all other trials"));
        assert!(matches!(left_out(&[]), Err(ChartError::Empty { .. })));
        let odd = [trial(f64::NAN, 0.8, [0.7, 0.9])];
        assert!(matches!(left_out(&odd), Err(ChartError::NotFinite { .. })));
    }
}
