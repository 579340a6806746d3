use super::canvas::{GREY, LEFT, Mark, PALETTE, RIGHT, Swatch, WIDTH, picture};
use super::plot::{Axis, Plot};
use super::{ChartError, Estimate, check, check_length};

/// Model minus measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResidualsChart<'a> {
    /// Title.
    pub title: &'a str,
    /// Names of the measurements.
    pub labels: &'a [String],
    /// Residuals with the measured standard deviations, one per name.
    pub residuals: &'a [Estimate],
}

/// Height of the picture without the key to the numbers.
const HEIGHT: f64 = 460.0;
/// Height of a line of the key, and number of its columns.
const KEY_LINE: f64 = 16.0;
const KEY_COLUMNS: usize = 4;

/// Draws residuals side by side, numbered, with a key to the numbers below.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw, lengths differ or a value is not finite.
pub fn residuals(chart: &ResidualsChart<'_>) -> Result<String, ChartError> {
    check_length(chart.title, chart.labels.len(), chart.residuals.len())?;
    let ends: Vec<f64> = chart
        .residuals
        .iter()
        .flat_map(|residual| {
            let error = residual.error.unwrap_or(0.0);
            [residual.value - error, residual.value + error]
        })
        .collect();
    check(chart.title, &ends)?;
    let numbers = (1..=chart.labels.len()).map(|number| number.to_string()).collect();
    let x_axis = Axis::of_names("measurement", numbers);
    let y_axis = Axis::around("model - measured", ends.into_iter().chain([0.0]));
    let lines = chart.labels.len().div_ceil(KEY_COLUMNS);
    picture(HEIGHT + KEY_LINE * lines as f64, |canvas| {
        let legend = [(Swatch::Mark(Mark::Circle, PALETTE[0]), "residual, with the measured standard deviation")];
        let top = canvas.heading(chart.title, &legend)?;
        let plot = Plot::new(canvas, [LEFT, top, WIDTH - RIGHT, HEIGHT - 72.0], x_axis, y_axis)?;
        plot.horizontal(0.0, GREY)?;
        for (place, residual) in chart.residuals.iter().enumerate() {
            plot.mark(Mark::Circle, [place as f64, residual.value], residual.error, 0.0, PALETTE[0])?;
        }
        let width = (WIDTH - LEFT - RIGHT) / KEY_COLUMNS as f64;
        for (place, label) in chart.labels.iter().enumerate() {
            let (column, line) = (place / lines.max(1), place % lines.max(1));
            let at = [LEFT + width * column as f64, HEIGHT - 10.0 + KEY_LINE * line as f64];
            canvas.small_text(&format!("{} {label}", place + 1), at, GREY)?;
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_residual_has_its_mark_and_its_name() {
        let labels = ["50 N".to_owned(), "100 N".to_owned()];
        let all = [0.001, -0.002].map(|value| Estimate { value, error: Some(0.002) });
        let svg = residuals(&ResidualsChart { title: "t", labels: &labels, residuals: &all }).unwrap();
        assert_eq!(svg.matches("<circle").count(), 3);
        assert!(svg.contains("\n1 50 N\n") && svg.contains("\n2 100 N\n"));
        let short = ResidualsChart { title: "t", labels: &labels, residuals: &all[..1] };
        assert!(matches!(residuals(&short), Err(ChartError::LengthMismatch { .. })));
    }
}
