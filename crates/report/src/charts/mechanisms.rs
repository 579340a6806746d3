//! Chart of several quantities side by side, one row per mechanism, with intervals.

use super::canvas::{GREY, Mark, PALETTE, RIGHT, WIDTH, picture};
use super::plot::{Axis, Plot};
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
const BELOW: f64 = 62.0;
/// Range of ratios that is drawn: intervals of what nobody believes end at the frame.
const RANGE: [f64; 2] = [0.0, 2.0];

/// Draws `rows` from the top down in one plot for each of the quantities `titles`, with a dashed line at 1.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw or a value is not finite.
pub fn mechanisms(title: &str, titles: &[&str], rows: &[MechanismRow]) -> Result<String, ChartError> {
    let values = rows.iter().flat_map(|row| row.values.iter().flat_map(|(median, ends)| [median, &ends[0], &ends[1]]));
    check(title, values)?;
    let count = titles.len().max(1) as f64;
    let width = (WIDTH - NAMES - RIGHT - GAP * (count - 1.0)) / count;
    let names: Vec<String> = rows.iter().rev().map(|row| row.name.clone()).collect();
    let height_of_rows = ROW * rows.len() as f64;
    picture(60.0 + height_of_rows + BELOW, |canvas| {
        let top = canvas.heading(title, &[])?;
        for (place, quantity) in titles.iter().enumerate() {
            let left = NAMES + place as f64 * (width + GAP);
            let of_names = Axis::of_names("", names.clone());
            let of_names = if place == 0 { of_names } else { of_names.unlabelled() };
            let frame = [left, top, left + width, top + height_of_rows];
            let plot = Plot::new(canvas, frame, Axis::over(quantity, RANGE), of_names)?;
            plot.dashed([[1.0, -0.5], [1.0, rows.len() as f64 - 0.5]], GREY)?;
            for (row, of) in rows.iter().rev().enumerate() {
                let Some((median, ends)) = of.values.get(place) else { continue };
                let [low, high] = ends.map(|end| end.clamp(RANGE[0], RANGE[1]));
                plot.line(&[[low, row as f64], [high, row as f64]], PALETTE[place % PALETTE.len()], 3.0)?;
                if (RANGE[0]..=RANGE[1]).contains(median) {
                    plot.mark(Mark::Circle, [*median, row as f64], None, 0.0, PALETTE[place % PALETTE.len()])?;
                }
            }
        }
        Ok(())
    })
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
