//! Charts of tribometer traces.

use super::axis::Axis;
use super::canvas::{GREY, INK, Mark, PALETTE, Swatch};
use super::chart::{Chart, Layer, lines};
use super::{ChartError, Series};

/// Trace of one repeat.
#[derive(Clone, Debug, PartialEq)]
pub struct RepeatTrace<'a> {
    /// Time in seconds and friction coefficient.
    pub series: Series<'a>,
    /// Mean friction coefficient over the window.
    pub mu_dynamic: f64,
    /// Time in seconds and friction coefficient of the static peak.
    pub static_peak: Option<[f64; 2]>,
}

/// Height of the picture.
const HEIGHT: f64 = 500.0;
const SHADE: f64 = 0.12;

/// Draws the traces of repeats with their means over the averaging window `window_s` and their static peaks.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw or a value is not finite.
pub fn tribometer(title: &str, window_s: [f64; 2], repeats: &[RepeatTrace<'_>]) -> Result<String, ChartError> {
    let points = || repeats.iter().flat_map(|repeat| &repeat.series.points);
    let (mut legend, lines) = lines(repeats.iter().map(|repeat| &repeat.series), 1.2);
    legend.push((Swatch::Band(GREY, SHADE), "averaging window"));
    legend.push((Swatch::Dashed(INK), "mean over the window"));
    if repeats.iter().any(|repeat| repeat.static_peak.is_some()) {
        legend.push((Swatch::Mark(Mark::Ring, INK), "static peak"));
    }
    let end = points().map(|point| point[0]).fold(window_s[1], f64::max);
    let mu = points().map(|point| point[1]).chain(repeats.iter().map(|repeat| repeat.mu_dynamic));
    let y_axis = Axis::as_needed("friction coefficient", mu);
    let means = repeats.iter().zip(PALETTE.into_iter().cycle()).flat_map(|(repeat, color)| {
        let mean = window_s.map(|time_s| [time_s, repeat.mu_dynamic]);
        [Layer::Dashed(mean, INK), Layer::marks(Mark::Ring, repeat.static_peak, color)]
    });
    let layers = [Layer::Span(window_s, SHADE)].into_iter().chain(lines).chain(means);
    Chart::new(title, HEIGHT, legend).plot(Axis::over("time (s)", [0.0, end]), y_axis, layers).svg()
}

/// Draws friction against position, in mm, of reciprocating traces: half the height of a loop is dynamic friction.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw or a value is not finite.
pub fn friction_loops(title: &str, repeats: &[Series<'_>]) -> Result<String, ChartError> {
    let points = || repeats.iter().flat_map(|repeat| &repeat.points);
    let (legend, lines) = lines(repeats, 1.2);
    let x_axis = Axis::around("position (mm)", points().map(|point| point[0]));
    let y_axis = Axis::around("friction coefficient, with its sign", points().map(|point| point[1]));
    Chart::new(title, HEIGHT, legend).plot(x_axis, y_axis, lines).svg()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loops_are_lines_against_position() {
        let turn = |i: u32| 0.1 * f64::from(i);
        let points: Vec<[f64; 2]> = (0..200).map(|i| [turn(i).cos(), turn(i).sin().signum() * 0.3]).collect();
        let svg = friction_loops("t", &[Series { label: "one", points }]).unwrap();
        // A line in the plot and one in the legend, drawn in the first colour.
        assert!(svg.matches("#0072B2").count() == 2 && svg.contains("\nposition (mm)\n"));
        assert!(matches!(friction_loops("t", &[]), Err(ChartError::Empty { .. })));
    }

    #[test]
    fn window_means_and_peaks_are_drawn() {
        let points: Vec<[f64; 2]> = (0..90).map(|i| [0.5 * f64::from(i), 0.25]).collect();
        let repeat = |static_peak| RepeatTrace {
            series: Series { label: "one <1>", points: points.clone() },
            mu_dynamic: 0.25,
            static_peak,
        };
        let chart = |repeats: &[RepeatTrace<'_>]| tribometer("t", [10.0, 40.0], repeats);
        let with = chart(&[repeat(Some([0.5, 0.31]))]).unwrap();
        assert_eq!(with.matches("<circle").count(), 2);
        assert!(with.contains("\none &lt;1&gt;\n") && with.contains("\naveraging window\n"));
        assert_eq!(chart(&[repeat(None)]).unwrap().matches("<circle").count(), 0);
        assert!(matches!(chart(&[]), Err(ChartError::Empty { .. })));
        assert!(matches!(chart(&[repeat(Some([f64::NAN, 0.3]))]), Err(ChartError::NotFinite { .. })));
    }
}
