//! Chart of model minus measurement.

use super::axis::Axis;
use super::canvas::{Mark, PALETTE, Swatch};
use super::chart::{Chart, Layer};
use super::{ChartError, Estimate};

/// Height of the picture without the key to the numbers.
const HEIGHT: f64 = 460.0;
/// Height of a line of the key, and number of its columns.
const KEY_LINE: f64 = 16.0;
const KEY_COLUMNS: usize = 4;

/// Draws the residual of each named measurement, with the measured standard deviation, side by side, numbered, with a key to the
/// numbers below.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw or a value is not finite.
pub fn residuals(title: &str, residuals: &[(String, Estimate)]) -> Result<String, ChartError> {
    let legend = vec![(Swatch::Mark(Mark::Circle, PALETTE[0]), "residual, with the measured standard deviation")];
    let x_axis = Axis::of_names("measurement", 1..=residuals.len());
    let y_axis = Axis::around("model - measured", residuals.iter().flat_map(|(_, of)| of.ends()).chain([0.0]));
    let lines = residuals.len().div_ceil(KEY_COLUMNS);
    let mut chart = Chart::new(title, HEIGHT + KEY_LINE * lines as f64, legend);
    let [left, top, right, _] = chart.frame();
    let marks = residuals.iter().enumerate().map(|(place, (_, of))| (place as f64, *of)).collect();
    let width = (right - left) / KEY_COLUMNS as f64;
    let note = |(place, (label, _)): (usize, &(String, Estimate))| {
        let (column, line) = (place / lines, place % lines);
        let at = [left + width * column as f64, HEIGHT - 10.0 + KEY_LINE * line as f64];
        Layer::Note(format!("{} {label}", place + 1), at)
    };
    let layers = [Layer::Horizontal(0.0), Layer::Marks(Mark::Circle, marks, PALETTE[0], 0.0)];
    let layers = layers.into_iter().chain(residuals.iter().enumerate().map(note));
    chart.plot_in([left, top, right, HEIGHT - 72.0], x_axis, y_axis, layers).svg()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_residual_has_its_mark_and_its_name() {
        let residual = |label: &str, value| (label.to_owned(), Estimate { value, error: Some(0.002) });
        let svg = residuals("t", &[residual("50 N", 0.001), residual("100 N", -0.002)]).unwrap();
        assert_eq!(svg.matches("<circle").count(), 3);
        assert!(svg.contains("\n1 50 N\n") && svg.contains("\n2 100 N\n"));
        assert!(matches!(residuals("t", &[]), Err(ChartError::Empty { .. })));
    }
}
