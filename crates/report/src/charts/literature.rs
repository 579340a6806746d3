//! Chart of published ratios beside measured ones.

use super::canvas::{GREY, LEFT, Mark, PALETTE, RIGHT, Swatch, WIDTH, picture};
use super::plot::{Axis, Plot};
use super::{ChartError, check};

/// Ratios of one source.
#[derive(Clone, Debug, PartialEq)]
pub struct LiteratureMark {
    /// Number of the source, or a name.
    pub number: String,
    /// Ratios of textured over flat friction.
    pub ratios: Vec<f64>,
    /// Whether the ratios are those of the user's trials.
    pub is_own: bool,
}

/// Published ratios beside measured ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LiteratureChart<'a> {
    /// Title.
    pub title: &'a str,
    /// One column of marks each.
    pub marks: &'a [LiteratureMark],
}

/// Height of the picture.
const HEIGHT: f64 = 380.0;

/// Draws one column of marks for every source.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw or a value is not finite.
pub fn literature(chart: &LiteratureChart<'_>) -> Result<String, ChartError> {
    let all: Vec<f64> = chart.marks.iter().flat_map(|of| of.ratios.iter().copied()).collect();
    check(chart.title, &all)?;
    picture(HEIGHT, |canvas| {
        let legend =
            [(Swatch::Mark(Mark::Square, PALETTE[0]), "your trials"), (Swatch::Mark(Mark::Circle, GREY), "published")];
        let top = canvas.heading(chart.title, &legend)?;
        let names = chart.marks.iter().map(|of| of.number.clone()).collect();
        let x_axis = Axis::of_names("source, by the number in the table", names);
        let y_axis = Axis::from_zero("ratio textured / flat", all.iter().copied());
        let plot = Plot::new(canvas, [LEFT, top, WIDTH - RIGHT, HEIGHT - 60.0], x_axis, y_axis)?;
        plot.horizontal(1.0, GREY)?;
        for (place, of) in chart.marks.iter().enumerate() {
            let (mark, colour) = if of.is_own { (Mark::Square, PALETTE[0]) } else { (Mark::Circle, GREY) };
            for ratio in &of.ratios {
                plot.mark(mark, [place as f64, *ratio], None, 0.0, colour)?;
            }
        }
        Ok(())
    })
}
