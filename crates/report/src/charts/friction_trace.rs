//! Chart of friction against time, with the means over windows.

use plotters::style::text_anchor::{HPos, VPos};

use super::axis::{Axis, extremes};
use super::canvas::{GREY, INK, PALETTE, RIGHT, Swatch, TEXT_SIZE};
use super::chart::{Chart, Layer, lines};
use super::{ChartError, Estimate, Series};

/// Trace of one surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace<'a> {
    /// Time in milliseconds and friction coefficient.
    pub series: Series<'a>,
    /// Start and end of the averaging window of the dynamic coefficient, in milliseconds.
    pub window_ms: Option<[f64; 2]>,
    /// Marked mean over that window, with its error.
    pub mu_dynamic: Option<Estimate>,
}

/// Widths at the right for the values of the means, and for their errors.
const VALUES: [f64; 2] = [84.0, 72.0];
const SHADE: f64 = 0.12;
/// Distance between two error bars, in picture units.
const BESIDE: f64 = 12.0;

/// Draws friction against time with shaded averaging windows and marked means, which the legend describes by `means`. One trace
/// per surface: flat, patterned.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_means_and_title_are_text_and_the_bytes_are_the_same() {
        let points = [[0.0, 0.0], [0.5, 0.3], [1.0, 0.27]];
        let trace = |label, value, error| Trace {
            series: Series { label, points: points.to_vec() },
            window_ms: Some([0.6, 1.0]),
            mu_dynamic: Some(Estimate { value, error }),
        };
        let traces = [trace("flat", 0.2702, None), trace("patterned <130>", 0.2148, Some(0.0031))];
        let drawn = || friction_trace("Friction at 2.6 MPa", &traces, "means as told").unwrap();
        let svg = drawn();
        for text in [
            "Friction at 2.6 MPa",
            "time (ms)",
            "flat",
            "patterned &lt;130&gt;",
            "0.2702",
            "0.2148 ± 0.0031",
            "means as told",
        ] {
            assert!(svg.contains(&format!("\n{text}\n")), "{text}");
        }
        assert!(svg.starts_with("<svg width=\"900\" height=\"500\" viewBox=\"0 0 7200 4000\""));
        assert_eq!(svg, drawn());
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
}
