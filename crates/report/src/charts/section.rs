//! Charts of a surface profile and of its power spectrum.

use super::ChartError;
use super::axis::{Axis, extremes};
use super::canvas::{Mark, PALETTE};
use super::chart::{Chart, Layer};

/// Draws height along a line, positions and heights in micrometres; heights are exaggerated.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw or a value is not finite.
pub fn section(title: &str, points_um: &[[f64; 2]]) -> Result<String, ChartError> {
    let [_, last] = extremes(points_um.iter().map(|[x, _]| *x));
    // A single point still has an axis.
    let x = Axis::over("x (µm)", [0.0, if last > 0.0 { last } else { 1.0 }]);
    let heights = Axis::around("height (µm)", points_um.iter().map(|[_, height]| *height));
    let line = Layer::Line(points_um.to_vec(), PALETTE[0], 1.5);
    Chart::new(title, 320.0, Vec::new()).plot(x, heights, [line]).svg()
}

/// Draws power against wave number on logarithmic axes: decimal logarithms of the wave number in rad/um and of the power spectral
/// density in um^4.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw or a value is not finite.
pub fn spectrum(title: &str, log_points: &[[f64; 2]]) -> Result<String, ChartError> {
    let x = Axis::logarithmic("wave number (rad/um)", log_points.iter().map(|[q, _]| *q));
    let y = Axis::powers("power spectral density (um^4)", log_points.iter().map(|[_, power]| *power));
    let line = Layer::Line(log_points.to_vec(), PALETTE[0], 1.8);
    let marks = Layer::marks(Mark::Circle, log_points.iter().copied(), PALETTE[0]);
    Chart::new(title, 440.0, Vec::new()).plot(x, y, [line, marks]).svg()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sections_and_spectra_have_units_on_their_axes() {
        let svg = section("t", &[[0.0, 1.0], [5.0, -1.0]]).unwrap();
        assert!(svg.contains("\nx (µm)\n") && svg.contains("\nheight (µm)\n"));
        let points = [[-2.0, 0.0], [0.0, -9.0]];
        let svg = spectrum("t", &points).unwrap();
        assert!(svg.contains("\nwave number (rad/um)\n") && svg.contains("\n1e-9\n"), "{svg}");
        assert_eq!(svg.matches("<circle").count(), 2);
        assert!(section("t", &[]).is_err());
        assert!(spectrum("t", &[[f64::NEG_INFINITY, 0.0]]).is_err());
    }
}
