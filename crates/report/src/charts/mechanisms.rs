//! Chart of several quantities side by side, one row per mechanism, with intervals.

use super::axis::Axis;
use super::canvas::{GREY, Mark, PALETTE, RIGHT, WIDTH};
use super::chart::{Chart, Layer};
use super::{ChartError, check};

/// Median and 95 % interval of each quantity by one mechanism.
#[derive(Clone, Debug, PartialEq)]
pub struct MechanismRow {
    /// Name, with the weight.
    pub name: String,
    /// Median and interval per quantity.
    pub values: Vec<(f64, [f64; 2])>,
}

/// Width of the names, gap between plots, height of a row, of the heading and of the numbers and titles below.
const NAMES: f64 = 300.0;
const GAP: f64 = 40.0;
const ROW: f64 = 34.0;
const HEADING: f64 = 60.0;
const BELOW: f64 = 62.0;
/// Range of ratios that is drawn: intervals of what nobody believes end at the frame.
const RANGE: [f64; 2] = [0.0, 2.0];

/// Draws `rows` from the top down in one plot for each of the quantities `titles`, with a dashed line at 1.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw or a value is not finite.
pub fn mechanisms(title: &str, titles: &[&str], rows: &[MechanismRow]) -> Result<String, ChartError> {
    let values = rows.iter().flat_map(|row| row.values.iter().flat_map(|(median, [low, high])| [*median, *low, *high]));
    check(title, values)?;
    let count = titles.len().max(1) as f64;
    let width = (WIDTH - NAMES - RIGHT - GAP * (count - 1.0)) / count;
    let height = ROW * rows.len() as f64;
    let mut chart = Chart::new(title, HEADING + height + BELOW, Vec::new());
    let [_, top, ..] = chart.frame();
    for (place, quantity) in titles.iter().enumerate() {
        let left = NAMES + place as f64 * (width + GAP);
        let of_names = Axis::of_names("", rows.iter().rev().map(|row| &row.name));
        let of_names = if place == 0 { of_names } else { of_names.unlabelled() };
        let colour = PALETTE[place % PALETTE.len()];
        let mut layers = vec![Layer::Dashed([[1.0, -0.5], [1.0, rows.len() as f64 - 0.5]], GREY)];
        for (row, of) in rows.iter().rev().enumerate() {
            let Some((median, ends)) = of.values.get(place) else { continue };
            let ends = ends.map(|end| [end.clamp(RANGE[0], RANGE[1]), row as f64]);
            layers.push(Layer::Line(ends.to_vec(), colour, 3.0));
            let shown = (RANGE[0]..=RANGE[1]).contains(median).then_some([*median, row as f64]);
            layers.push(Layer::marks(Mark::Circle, shown, colour));
        }
        chart.plot_in([left, top, left + width, top + height], Axis::over(quantity, RANGE), of_names, layers);
    }
    chart.svg()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_mechanism_is_a_row_and_wide_intervals_end_at_the_frame() {
        let row = |name: &str, median: f64| MechanismRow {
            name: name.to_owned(),
            values: vec![(median, [0.5, 7.0]), (1.0, [0.9, 1.1])],
        };
        let svg = mechanisms("t", &["sector 1", "sector 2"], &[row("areal density", 0.8), row("edges", 0.7)]).unwrap();
        // Two rows of two marks; names stand once.
        assert_eq!((svg.matches("<circle").count(), svg.matches("areal density").count()), (4, 1));
        let near = |text: &str| svg.find(text).unwrap();
        assert!(near("\nsector 1\n") < near("\nsector 2\n"));
        assert!(matches!(mechanisms("t", &["sector 1"], &[]), Err(ChartError::Empty { .. })));
        assert!(matches!(mechanisms("t", &["a"], &[row("b", f64::NAN)]), Err(ChartError::NotFinite { .. })));
    }
}
