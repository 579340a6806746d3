//! Charts of runs and of tribometer traces: friction in time or against position, and pressure along the interface.

use plotters::style::text_anchor::{HPos, VPos};

use super::{
    Axis, Chart, ChartError, Estimate, GREY, INK, Layer, Mark, PALETTE, RIGHT, Series, Swatch, TEXT_SIZE, extremes,
    lines,
};

/// Friction of one surface against time, with its mean.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace<'a> {
    /// Time in milliseconds and friction coefficient.
    pub series: Series<'a>,
    /// Start and end of the averaging window of the dynamic coefficient, in milliseconds; `None` draws no window.
    pub window_ms: Option<[f64; 2]>,
    /// Mean over the averaging window, with its error; `None` draws no mean.
    pub mu_dynamic: Option<Estimate>,
}

/// Widths right of the plot for the values of the means and for their errors, in picture units.
const VALUES: [f64; 2] = [84.0, 72.0];
/// Opacity of the shading of averaging windows.
const SHADE: f64 = 0.12;
/// Horizontal distance between neighbouring error bars, in picture units.
const BESIDE: f64 = 12.0;

/// Draws friction against time, one trace per surface, with shaded averaging windows and dashed means; `means` is the
/// text of the legend for the means.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw or a value is not finite.
pub fn friction_trace(title: &str, traces: &[Trace<'_>], means: &str) -> Result<String, ChartError> {
    let points = || traces.iter().flat_map(|trace| &trace.series.points);
    let marked = || traces.iter().filter_map(|trace| trace.mu_dynamic);
    let windows: Vec<[f64; 2]> = traces.iter().filter_map(|trace| trace.window_ms).collect();
    let (mut legend, lines) = lines(traces.iter().map(|trace| &trace.series), 1.6);
    if !windows.is_empty() {
        legend.push((Swatch::Band(GREY, SHADE), "averaging window"));
    }
    if marked().next().is_some() {
        legend.push((Swatch::Dashed(INK), means));
    }

    let [low, high] = extremes(points().map(|point| point[0]));
    let x_axis = Axis::over("time (ms)", if high > low { [low.min(0.0), high] } else { [low - 0.5, high + 0.5] });
    let mu = points().map(|point| point[1]).chain(marked().flat_map(|mean| mean.ends()));
    let y_axis = Axis::as_needed("friction coefficient", mu);
    let mut layers: Vec<Layer<'_>> = united(windows).into_iter().map(|span_ms| Layer::Span(span_ms, SHADE)).collect();
    layers.extend(lines);
    let mut drawn: Vec<Estimate> = Vec::new();
    // Bars side by side at the end of the windows.
    for (place, (trace, color)) in traces.iter().zip(PALETTE.into_iter().cycle()).enumerate() {
        let (Some(mean), [first, .., last]) = (trace.mu_dynamic, &trace.series.points[..]) else { continue };
        let [from, to] = trace.window_ms.unwrap_or([first[0], last[0]]);
        layers.push(Layer::Dashed([[from, mean.value], [to, mean.value]], INK));
        if mean.error.is_some() {
            layers.push(Layer::Bar(to, mean.ends(), color, -BESIDE * place as f64));
        }
        drawn.push(mean);
    }
    if !drawn.is_empty() {
        // Values from the top down, without overlap.
        drawn.sort_by(|a, b| b.value.total_cmp(&a.value));
        layers.push(Layer::Own(Box::new(move |canvas, plot| {
            let mut free = f64::NEG_INFINITY;
            for mean in &drawn {
                let page_y = plot.at([0.0, mean.value])[1].max(free);
                let error = mean.error.map_or_else(String::new, |error| format!(" ± {error:.4}"));
                let at = [plot.frame[2] + 8.0, page_y];
                canvas.text(&format!("{:.4}{error}", mean.value), at, (HPos::Left, VPos::Center), INK)?;
                free = page_y + 1.2 * TEXT_SIZE;
            }
            Ok(())
        })));
    }
    let room = VALUES[0] + if marked().any(|mean| mean.error.is_some()) { VALUES[1] } else { 0.0 };
    let mut chart = Chart::new(title, 500.0, legend);
    let [left, top, right, bottom] = chart.frame();
    chart.plot_in([left, top, right + RIGHT - room, bottom], x_axis, y_axis, layers).svg()
}

/// Merges overlapping spans, so that their shading does not add up.
fn united(mut spans: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    spans.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let mut united: Vec<[f64; 2]> = Vec::new();
    for span in spans {
        match united.last_mut() {
            Some(last) if span[0] <= last[1] => last[1] = last[1].max(span[1]),
            _ => united.push(span),
        }
    }
    united
}

/// Friction of one repeat of a test against time, with the values read from it.
#[derive(Clone, Debug, PartialEq)]
pub struct RepeatTrace<'a> {
    /// Time in seconds and friction coefficient.
    pub series: Series<'a>,
    /// Mean friction coefficient over the averaging window.
    pub mu_dynamic: f64,
    /// Time in seconds and friction coefficient of the static peak; `None` if no peak was found.
    pub static_peak: Option<[f64; 2]>,
}

/// Draws the traces of repeats with their static peaks and their means over the averaging window `window_s`, given by
/// start and end in seconds.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw or a value is not finite.
pub fn tribometer(title: &str, window_s: [f64; 2], repeats: &[RepeatTrace<'_>]) -> Result<String, ChartError> {
    let points = || repeats.iter().flat_map(|repeat| &repeat.series.points);
    let (mut legend, lines) = lines(repeats.iter().map(|repeat| &repeat.series), 1.2);
    legend.push((Swatch::Band(GREY, SHADE), "averaging window"));
    legend.push((Swatch::Dashed(INK), "mean over the window"));
    if repeats.iter().any(|repeat| repeat.static_peak.is_some()) {
        legend.push((Swatch::Mark(Mark::Ring, INK), "static peak"));
    }
    let end = points().map(|point| point[0]).fold(window_s[1], f64::max);
    let mu = points().map(|point| point[1]).chain(repeats.iter().map(|repeat| repeat.mu_dynamic));
    let y_axis = Axis::as_needed("friction coefficient", mu);
    let means = repeats.iter().zip(PALETTE.into_iter().cycle()).flat_map(|(repeat, color)| {
        let mean = window_s.map(|time_s| [time_s, repeat.mu_dynamic]);
        [Layer::Dashed(mean, INK), Layer::marks(Mark::Ring, repeat.static_peak, color)]
    });
    let layers = [Layer::Span(window_s, SHADE)].into_iter().chain(lines).chain(means);
    Chart::new(title, 500.0, legend).plot(Axis::over("time (s)", [0.0, end]), y_axis, layers).svg()
}

/// Draws friction against position in millimetres for reciprocating sliding; half the height of a loop is dynamic
/// friction.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw or a value is not finite.
pub fn friction_loops(title: &str, repeats: &[Series<'_>]) -> Result<String, ChartError> {
    let points = || repeats.iter().flat_map(|repeat| &repeat.points);
    let (legend, lines) = lines(repeats, 1.2);
    let x_axis = Axis::around("position (mm)", points().map(|point| point[0]));
    let y_axis = Axis::around("friction coefficient, with its sign", points().map(|point| point[1]));
    Chart::new(title, 500.0, legend).plot(x_axis, y_axis, lines).svg()
}

/// Opacity of the shading of cavities.
const CAVITY_SHADE: f64 = 0.18;

/// Draws the pressure on contact blocks in MPa along x in micrometres, one series per surface; lines are interrupted
/// over cavities. Each of `cavities_um` is the start and the end of a cavity; `nominal_mpa` is the nominal pressure.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw or a value is not finite.
pub fn interface_pressure(
    title: &str,
    surfaces: &[Series<'_>],
    cavities_um: &[[f64; 2]],
    nominal_mpa: f64,
) -> Result<String, ChartError> {
    let points = || surfaces.iter().flat_map(|surface| &surface.points);
    let coloured = || surfaces.iter().zip(PALETTE.into_iter().cycle());
    let mut legend: Vec<(Swatch, &str)> =
        coloured().map(|(surface, color)| (Swatch::Line(color), surface.label)).collect();
    if !cavities_um.is_empty() {
        legend.push((Swatch::Band(GREY, CAVITY_SHADE), "cavity"));
    }
    legend.push((Swatch::Dashed(GREY), "nominal pressure"));

    let [low, high] = extremes(points().map(|point| point[0]).chain(cavities_um.iter().flatten().copied()));
    let range_um = if high > low { [low, high] } else { [low - 1.0, high + 1.0] };
    let x_axis = Axis::over("position along the sliding direction x (µm)", range_um);
    let pressures = || points().map(|point| point[1]).chain([nominal_mpa]);
    // Tension stays visible if a model has it.
    let y_axis = if pressures().any(|p| p < 0.0) {
        Axis::around("contact pressure (MPa)", pressures().chain([0.0]))
    } else {
        Axis::from_zero("contact pressure (MPa)", pressures())
    };
    let mut layers: Vec<Layer<'_>> =
        cavities_um.iter().map(|cavity_um| Layer::Span(*cavity_um, CAVITY_SHADE)).collect();
    layers.push(Layer::Horizontal(nominal_mpa));
    for (surface, color) in coloured() {
        // The minimum distance between neighbours is one block; a longer distance is a cavity.
        let distance = |pair: &[[f64; 2]]| pair[1][0] - pair[0][0];
        let block_um = surface.points.windows(2).map(distance).fold(f64::INFINITY, f64::min);
        let lands = surface.points.chunk_by(|a, b| b[0] - a[0] < 1.5 * block_um);
        layers.extend(lands.map(|land| Layer::Line(land.to_vec(), color, 1.8)));
    }
    Chart::new(title, 460.0, legend).plot(x_axis, y_axis, layers).svg()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_text_and_the_bytes_are_the_same() {
        let trace = |label| Trace {
            series: Series { label, points: vec![[0.0, 0.0], [0.5, 0.3], [1.0, 0.27]] },
            window_ms: Some([0.6, 1.0]),
            mu_dynamic: None,
        };
        let drawn = || friction_trace("t", &[trace("flat"), trace("patterned <130>")], "m").unwrap();
        assert!(drawn().contains("\npatterned &lt;130&gt;\n"));
        assert_eq!(drawn(), drawn());
    }

    #[test]
    fn overlapping_windows_are_shaded_once() {
        assert_eq!(united(vec![[0.64, 1.0], [0.6, 0.9], [2.0, 3.0]]), [[0.6, 1.0], [2.0, 3.0]]);
    }

    #[test]
    fn nothing_and_infinity_are_refused() {
        assert!(matches!(friction_trace("t", &[], "m"), Err(ChartError::Empty { .. })));
        let series = Series { label: "a", points: vec![[0.0, f64::NAN]] };
        let traces = [Trace { series, window_ms: None, mu_dynamic: None }];
        // A mean whose trace is missing is left out while other traces are drawn.
        let there = vec![[0.0, 0.1], [1.0, 0.2]];
        let mean = Estimate { value: 0.1234, error: None };
        let trace = |points| Trace { series: Series { label: "a", points }, window_ms: None, mu_dynamic: Some(mean) };
        let half = friction_trace("t", &[trace(Vec::new()), trace(there)], "m").unwrap();
        assert_eq!(half.matches("0.1234").count(), 1);
        assert!(matches!(friction_trace("t", &traces, "m"), Err(ChartError::NotFinite { .. })));
    }

    #[test]
    fn loops_are_lines_against_position() {
        let turn = |i: u32| 0.1 * f64::from(i);
        let points: Vec<[f64; 2]> = (0..200).map(|i| [turn(i).cos(), turn(i).sin().signum() * 0.3]).collect();
        let svg = friction_loops("t", &[Series { label: "one", points }]).unwrap();
        // A line in the plot and one in the legend, drawn in the first colour.
        assert!(svg.matches("#0072B2").count() == 2 && svg.contains("\nposition (mm)\n"));
    }
}
