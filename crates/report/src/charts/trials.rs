//! Charts of trials: measured ratios beside predicted and published ones, and against the texture.

use plotters::style::RGBColor;

use super::{Axis, Chart, ChartError, GREY, Layer, Mark, PALETTE, Swatch, check, extremes};
use crate::trials::{MeasuredReport, TrialReport};

/// Lower end of the first plot, in picture units from the top.
const FIRST: f64 = 380.0;
/// Height of the picture, in picture units.
const HEIGHT: f64 = 680.0;
/// Gap between panels, in picture units, for the texts of ticks.
const GAP: f64 = 60.0;
/// Maximum margin above and below all ratios, relative to the range of the ratios, which counts as at least 2 % of the
/// largest ratio.
const BEYOND: f64 = 0.75;
/// Maximum number of trials named in the legend.
const NAMED: usize = 4;

/// Function that returns the x value of a measured ratio in a panel.
type Quantity = fn(&TrialReport, &MeasuredReport) -> f64;

/// Draws all measured ratios side by side with their predictions from earlier trials; below, the ratios against areal
/// density, edge length and pressure.
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

/// Maximum number of letters of a name in the legend.
const MAX_LETTERS: usize = 20;

/// Draws the measured ratios of `trials` against predictions from all other trials with 95 % intervals; ratios without
/// other trials are left out. On the dashed line, prediction and measurement are equal.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw or a value is not finite.
pub fn left_out(trials: &[TrialReport]) -> Result<String, ChartError> {
    let styles = PALETTE.into_iter().cycle().zip(Mark::FILLED.into_iter().cycle());
    let styled = trials.iter().zip(styles.clone());
    let each = styled.flat_map(|(trial, style)| trial.measured.iter().map(move |at| (at, style)));
    let rows: Vec<_> = each.filter(|(at, _)| at.without_trial.known > 0).collect();
    let middles = || rows.iter().flat_map(|(at, _)| [at.without_trial.ratio, at.measured]);
    let ends = rows.iter().flat_map(|(at, _)| at.without_trial.interval_95);
    check("measured against predicted", middles().chain(ends))?;
    let [low, high] = extremes(middles());
    // An interval may be far wider than all ratios: bars end at the frame.
    let room = (0.5 * (high - low)).max(0.01 * high);
    let range = [low - room, high + room];
    let short = |of: &TrialReport| of.name.chars().take(MAX_LETTERS).collect::<String>();
    let names: Vec<String> = trials.iter().take(NAMED).map(short).collect();
    let mut legend = vec![(Swatch::Dashed(GREY), "as predicted")];
    legend.extend(styles.zip(&names).map(|((colour, mark), name)| (Swatch::Mark(mark, colour), name.as_str())));
    let mut layers = vec![Layer::Dashed([[range[0]; 2], [range[1]; 2]], GREY)];
    for (at, (colour, mark)) in rows {
        let ends = at.without_trial.interval_95.map(|end| [end.clamp(range[0], range[1]), at.measured]);
        layers.push(Layer::Line(ends.to_vec(), colour, 1.6));
        layers.push(Layer::marks(mark, [[at.without_trial.ratio, at.measured]], colour));
    }
    let x_axis = Axis::over("predicted by all other trials, with 95 %", range);
    // Below the legend the plot is about square.
    Chart::new("", 500.0, legend).plot(x_axis, Axis::over("measured ratio", range), layers).svg()
}

/// Draws ratios of textured over flat friction in columns: first the user's `own` ratios, then the ratios of each
/// `published` source, numbered from 1.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw or a value is not finite.
pub fn literature(title: &str, own: &[f64], published: &[&[f64]]) -> Result<String, ChartError> {
    let legend =
        vec![(Swatch::Mark(Mark::Square, PALETTE[0]), "your trials"), (Swatch::Mark(Mark::Circle, GREY), "published")];
    let names = ["yours".to_owned()].into_iter().chain((1..=published.len()).map(|number| number.to_string()));
    let x_axis = Axis::of_names("source, by the number in the table", names);
    let all = published.iter().copied().flatten().chain(own).copied();
    let y_axis = Axis::from_zero("ratio textured / flat", all);
    let column =
        |place: usize, ratios: &[f64]| -> Vec<[f64; 2]> { ratios.iter().map(|ratio| [place as f64, *ratio]).collect() };
    let mut layers = vec![Layer::Horizontal(1.0), Layer::marks(Mark::Square, column(0, own), PALETTE[0])];
    layers.extend((1..).zip(published).map(|(place, of)| Layer::marks(Mark::Circle, column(place, of), GREY)));
    let mut chart = Chart::new(title, 380.0, legend);
    let [left, top, right, bottom] = chart.frame();
    chart.plot_in([left, top, right, bottom + 2.0], x_axis, y_axis, layers).svg()
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::trials::PredictedReport;

    #[test]
    fn every_ratio_is_a_mark_and_wide_intervals_end_at_the_frame() {
        let trial = |measured, ratio, interval_95| {
            let without_trial = PredictedReport { ratio, interval_95, known: 1, ..PredictedReport::default() };
            let at = MeasuredReport { measured, without_trial, ..MeasuredReport::default() };
            TrialReport { measured: vec![at], ..TrialReport::default() }
        };
        let svg = left_out(&[trial(0.8, 0.85, [0.7, 1.0]), trial(0.9, 0.86, [-4.0, 9.0])]).unwrap();
        // The first trial has circles, the second squares; one of each stands in the legend.
        assert_eq!(svg.matches("<circle").count(), 2);
        assert_eq!(svg.matches("<polygon").count(), 2);
        assert!(!svg.contains("points=\"-") && svg.contains("predicted by all other trials"));
        assert!(matches!(left_out(&[]), Err(ChartError::Empty { .. })));
        let odd = [trial(f64::NAN, 0.8, [0.7, 0.9])];
        assert!(matches!(left_out(&odd), Err(ChartError::NotFinite { .. })));
    }
}
