use super::canvas::{GREY, INK, LEFT, Mark, PALETTE, RIGHT, Swatch, WIDTH, picture};
use super::plot::{Axis, Plot};
use super::{ChartError, Series, check};

/// Repeats of a tribometer test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TribometerChart<'a> {
    /// Title.
    pub title: &'a str,
    /// Averaging window, in seconds.
    pub window_s: [f64; 2],
    /// One trace per repeat.
    pub repeats: &'a [RepeatTrace<'a>],
}

/// Trace of one repeat.
#[derive(Clone, Copy, Debug, PartialEq)]
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

/// Draws the traces of repeats with their means and static peaks.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw or a value is not finite.
pub fn tribometer(chart: &TribometerChart<'_>) -> Result<String, ChartError> {
    let points = || chart.repeats.iter().flat_map(|repeat| repeat.series.points);
    check(chart.title, points().flatten())?;
    let marks = chart.repeats.iter().flat_map(|repeat| {
        [repeat.mu_dynamic].into_iter().chain(repeat.static_peak.into_iter().flatten()).chain(chart.window_s)
    });
    if let Some(value) = marks.clone().find(|value| !value.is_finite()) {
        return Err(ChartError::NotFinite { title: chart.title.to_owned(), value });
    }
    let coloured = || chart.repeats.iter().zip(PALETTE.into_iter().cycle());
    let mut legend: Vec<(Swatch, &str)> =
        coloured().map(|(repeat, color)| (Swatch::Line(color), repeat.series.label)).collect();
    legend.push((Swatch::Band(GREY, SHADE), "averaging window"));
    legend.push((Swatch::Dashed(INK), "mean over the window"));
    if chart.repeats.iter().any(|repeat| repeat.static_peak.is_some()) {
        legend.push((Swatch::Mark(Mark::Ring, INK), "static peak"));
    }
    let end = points().map(|point| point[0]).fold(chart.window_s[1], f64::max);
    let mu = points().map(|point| point[1]).chain(chart.repeats.iter().map(|repeat| repeat.mu_dynamic));
    let y_axis = Axis::as_needed("friction coefficient", mu);
    picture(HEIGHT, |canvas| {
        let top = canvas.heading(chart.title, &legend)?;
        let frame = [LEFT, top, WIDTH - RIGHT, HEIGHT - 62.0];
        let plot = Plot::new(canvas, frame, Axis::over("time (s)", [0.0, end]), y_axis)?;
        plot.span(chart.window_s, GREY, SHADE)?;
        for (repeat, color) in coloured() {
            plot.line(repeat.series.points, color, 1.2)?;
        }
        let [from, to] = chart.window_s;
        for (repeat, color) in coloured() {
            plot.dashed([[from, repeat.mu_dynamic], [to, repeat.mu_dynamic]], INK)?;
            if let Some(peak) = repeat.static_peak {
                plot.mark(Mark::Ring, peak, None, 0.0, color)?;
            }
        }
        Ok(())
    })
}

/// Draws friction against position, in mm, of reciprocating traces: half the height of a loop is dynamic friction.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw or a value is not finite.
pub fn friction_loops(title: &str, repeats: &[Series<'_>]) -> Result<String, ChartError> {
    let points = || repeats.iter().flat_map(|repeat| repeat.points);
    check(title, points().flatten())?;
    let coloured = || repeats.iter().zip(PALETTE.into_iter().cycle());
    let legend: Vec<(Swatch, &str)> = coloured().map(|(repeat, color)| (Swatch::Line(color), repeat.label)).collect();
    let x_axis = Axis::around("position (mm)", points().map(|point| point[0]));
    let y_axis = Axis::around("friction coefficient, with its sign", points().map(|point| point[1]));
    picture(HEIGHT, |canvas| {
        let top = canvas.heading(title, &legend)?;
        let plot = Plot::new(canvas, [LEFT, top, WIDTH - RIGHT, HEIGHT - 62.0], x_axis, y_axis)?;
        for (repeat, color) in coloured() {
            plot.line(repeat.points, color, 1.2)?;
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loops_are_lines_against_position() {
        let turn = |i: u32| 0.1 * f64::from(i);
        let points: Vec<[f64; 2]> = (0..200).map(|i| [turn(i).cos(), turn(i).sin().signum() * 0.3]).collect();
        let svg = friction_loops("t", &[Series { label: "one", points: &points }]).unwrap();
        // A line in the plot and one in the legend, drawn in the first colour.
        assert!(svg.matches("#0072B2").count() == 2 && svg.contains("\nposition (mm)\n"));
        assert!(matches!(friction_loops("t", &[]), Err(ChartError::Empty { .. })));
    }

    #[test]
    fn window_means_and_peaks_are_drawn() {
        let points: Vec<[f64; 2]> = (0..90).map(|i| [0.5 * f64::from(i), 0.25]).collect();
        let repeat = |static_peak| RepeatTrace {
            series: Series { label: "one <1>", points: &points },
            mu_dynamic: 0.25,
            static_peak,
        };
        let chart =
            |repeats: &[RepeatTrace<'_>]| tribometer(&TribometerChart { title: "t", window_s: [10.0, 40.0], repeats });
        let with = chart(&[repeat(Some([0.5, 0.31]))]).unwrap();
        assert_eq!(with.matches("<circle").count(), 2);
        assert!(with.contains("\none &lt;1&gt;\n") && with.contains("\naveraging window\n"));
        assert_eq!(chart(&[repeat(None)]).unwrap().matches("<circle").count(), 0);
        assert!(matches!(chart(&[]), Err(ChartError::Empty { .. })));
        assert!(matches!(chart(&[repeat(Some([f64::NAN, 0.3]))]), Err(ChartError::NotFinite { .. })));
    }
}
