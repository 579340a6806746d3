//! Chart of trials: predicted against measured ratios, and all ratios against features of the texture.

use plotters::style::RGBColor;

use super::axis::{Axis, extremes};
use super::canvas::{GREY, Mark, PALETTE, Swatch};
use super::chart::{Chart, Layer};
use super::{ChartError, check};
use crate::trials::{MeasuredReport, TrialReport};

/// Lower end of the first plot, and height of the picture.
const FIRST: f64 = 380.0;
const HEIGHT: f64 = 680.0;
/// Gap between panels, for the numbers of the axis.
const GAP: f64 = 60.0;
/// Maximum margin above and below all ratios, relative to their range.
const BEYOND: f64 = 0.75;
/// Maximum number of trials named in the legend.
const NAMED: usize = 4;

/// Quantity of a measured ratio.
type Quantity = fn(&TrialReport, &MeasuredReport) -> f64;

/// Draws all measured ratios, in order, with their predictions from earlier trials; below, the ratios against areal density,
/// edge length and pressure.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw or a value is not finite.
pub fn trials(title: &str, trials: &[TrialReport]) -> Result<String, ChartError> {
    let coloured = trials.iter().zip(PALETTE.into_iter().cycle());
    let each = coloured.clone().flat_map(|(trial, colour)| trial.measured.iter().map(move |at| (trial, at, colour)));
    let rows: Vec<(&TrialReport, &MeasuredReport, RGBColor)> = each.collect();
    let ends = || rows.iter().flat_map(|(_, at, _)| at.before.interval_95.into_iter().chain([at.measured]));
    check(title, ends())?;
    // Before a first trial, an interval may be far wider than the range of measured values: bars end at the frame.
    let [least, most] = extremes(rows.iter().flat_map(|(_, at, _)| [at.before.ratio, at.measured]));
    let room = (BEYOND * (most - least)).max(BEYOND * 0.02 * most);
    let [lowest, highest] = [least - room, most + room];
    let y_axis = if ends().all(|end| (lowest..=highest).contains(&end)) {
        Axis::around("ratio patterned / flat", ends())
    } else {
        Axis::over("ratio patterned / flat", [lowest, highest])
    };
    let mut legend = vec![(Swatch::Mark(Mark::Circle, GREY), "predicted before, with 95 %")];
    legend.extend(coloured.take(NAMED).map(|(of, colour)| (Swatch::Mark(Mark::Square, colour), of.name.as_str())));
    let layers = rows.iter().enumerate().flat_map(|(place, (_, at, colour))| {
        let x = place as f64;
        [
            Layer::Bar(x, at.before.interval_95.map(|end| end.clamp(lowest, highest)), GREY, -3.0),
            Layer::Marks(Mark::Circle, vec![(x, at.before.ratio.into())], GREY, -3.0),
            Layer::Marks(Mark::Square, vec![(x, at.measured.into())], *colour, 3.0),
        ]
    });
    let mut chart = Chart::new(title, HEIGHT, legend);
    let [left, top, right, _] = chart.frame();
    let x_axis = Axis::of_names("number of the measured ratio", 1..=rows.len());
    chart.plot_in([left, top, right, FIRST], x_axis, y_axis, layers);
    let panels: [(&str, &str, Quantity); 3] = [
        ("measured ratio", "areal density (%)", |trial, _| 100.0 * trial.areal_density),
        ("", "edges per area (1/mm)", |trial, _| trial.edge_per_mm),
        ("", "pressure (MPa)", |_, at| at.pressure_mpa),
    ];
    let width = (right - left - 2.0 * GAP) / 3.0;
    for (number, (y_title, x_title, value)) in panels.into_iter().enumerate() {
        let left = left + number as f64 * (width + GAP);
        let x_axis = Axis::from_zero(x_title, rows.iter().map(|(trial, at, _)| value(trial, at)));
        let y_axis = Axis::around(y_title, rows.iter().map(|(_, at, _)| at.measured));
        let marks = rows
            .iter()
            .map(|(trial, at, colour)| Layer::marks(Mark::Square, [[value(trial, at), at.measured]], *colour));
        let frame = [left, FIRST + GAP + 20.0, left + width, HEIGHT - 60.0];
        chart.plot_in(frame, x_axis, y_axis, marks);
    }
    chart.svg()
}
