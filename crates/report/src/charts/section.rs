//! Charts of a surface profile and of its power spectrum.

use super::canvas::{LEFT, Mark, PALETTE, RIGHT, WIDTH, picture};
use super::plot::{Axis, Plot};
use super::{ChartError, check};

/// Height along a line.
#[derive(Clone, Copy, Debug)]
pub struct SectionChart<'a> {
    /// Title above the picture.
    pub title: &'a str,
    /// Position and height.
    pub points_um: &'a [[f64; 2]],
}

/// Power against wave number.
#[derive(Clone, Copy, Debug)]
pub struct SpectrumChart<'a> {
    /// Title above the picture.
    pub title: &'a str,
    /// Decimal logarithms of the wave number in rad/um and of the power spectral density in um^4.
    pub log_points: &'a [[f64; 2]],
}

const SECTION_HEIGHT: f64 = 320.0;
const SPECTRUM_HEIGHT: f64 = 440.0;

/// Draws the section; heights are exaggerated.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw or a value is not finite.
pub fn section(chart: &SectionChart<'_>) -> Result<String, ChartError> {
    check(chart.title, chart.points_um.iter().flatten())?;
    let last = chart.points_um.iter().map(|[x, _]| *x).fold(0.0, f64::max);
    // A single point still has an axis.
    let x = Axis::over("x (µm)", [0.0, if last > 0.0 { last } else { 1.0 }]);
    let heights = Axis::around("height (µm)", chart.points_um.iter().map(|[_, height]| *height));
    picture(SECTION_HEIGHT, |canvas| {
        let top = canvas.heading(chart.title, &[])?;
        let frame = [LEFT, top, WIDTH - RIGHT, SECTION_HEIGHT - 62.0];
        Plot::new(canvas, frame, x, heights)?.line(chart.points_um, PALETTE[0], 1.5)
    })
}

/// Draws the spectrum on logarithmic axes.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw or a value is not finite.
pub fn spectrum(chart: &SpectrumChart<'_>) -> Result<String, ChartError> {
    check(chart.title, chart.log_points.iter().flatten())?;
    let x = Axis::logarithmic("wave number (rad/um)", chart.log_points.iter().map(|[q, _]| *q));
    let y = Axis::powers("power spectral density (um^4)", chart.log_points.iter().map(|[_, power]| *power));
    picture(SPECTRUM_HEIGHT, |canvas| {
        let top = canvas.heading(chart.title, &[])?;
        let plot = Plot::new(canvas, [LEFT, top, WIDTH - RIGHT, SPECTRUM_HEIGHT - 62.0], x, y)?;
        plot.line(chart.log_points, PALETTE[0], 1.8)?;
        chart.log_points.iter().try_for_each(|&point| plot.mark(Mark::Circle, point, None, 0.0, PALETTE[0]))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sections_and_spectra_have_units_on_their_axes() {
        let svg = section(&SectionChart { title: "t", points_um: &[[0.0, 1.0], [5.0, -1.0]] }).unwrap();
        assert!(svg.contains("\nx (µm)\n") && svg.contains("\nheight (µm)\n"));
        let points = [[-2.0, 0.0], [0.0, -9.0]];
        let svg = spectrum(&SpectrumChart { title: "t", log_points: &points }).unwrap();
        assert!(svg.contains("\nwave number (rad/um)\n") && svg.contains("\n1e-9\n"), "{svg}");
        assert_eq!(svg.matches("<circle").count(), 2);
        assert!(section(&SectionChart { title: "t", points_um: &[] }).is_err());
        assert!(spectrum(&SpectrumChart { title: "t", log_points: &[[f64::NEG_INFINITY, 0.0]] }).is_err());
    }
}
