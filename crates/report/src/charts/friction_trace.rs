use super::canvas::{GREY, INK, LEFT, PALETTE, Swatch, TEXT_SIZE, WIDTH, picture};
use super::plot::{Axis, Plot};
use super::{ChartError, Estimate, Series, check};

/// Friction coefficient against time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrictionTraceChart<'a> {
    /// Title.
    pub title: &'a str,
    /// Traces, one per surface: flat, patterned.
    pub traces: &'a [Trace<'a>],
    /// Description of the marked means.
    pub means: &'a str,
}

/// Trace of one surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trace<'a> {
    /// Time in milliseconds and friction coefficient.
    pub series: Series<'a>,
    /// Start and end of the averaging window of the dynamic coefficient, in milliseconds.
    pub window_ms: Option<[f64; 2]>,
    /// Marked mean over that window, with its error.
    pub mu_dynamic: Option<Estimate>,
}

/// Height of the picture.
const HEIGHT: f64 = 500.0;
/// Widths at the right for the values of the means, and for their errors.
const VALUES: [f64; 2] = [84.0, 72.0];
const SHADE: f64 = 0.12;
/// Distance between two error bars, in picture units.
const BESIDE: f64 = 12.0;

/// Draws friction against time with shaded averaging windows and marked means.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw or a value is not finite.
pub fn friction_trace(chart: &FrictionTraceChart<'_>) -> Result<String, ChartError> {
    let points = || chart.traces.iter().flat_map(|trace| trace.series.points);
    check(chart.title, points().flatten())?;
    let means = || chart.traces.iter().filter_map(|trace| trace.mu_dynamic);
    let windows = chart.traces.iter().flat_map(|trace| trace.window_ms.into_iter().flatten());
    let marks = || windows.clone().chain(means().flat_map(|mean| [mean.value, mean.error.unwrap_or(0.0)]));
    if let Some(value) = marks().find(|value| !value.is_finite()) {
        return Err(ChartError::NotFinite { title: chart.title.to_owned(), value });
    }

    let coloured = || chart.traces.iter().zip(PALETTE.into_iter().cycle());
    let mut legend: Vec<(Swatch, &str)> =
        coloured().map(|(trace, color)| (Swatch::Line(color), trace.series.label)).collect();
    if chart.traces.iter().any(|trace| trace.window_ms.is_some()) {
        legend.push((Swatch::Band(GREY, SHADE), "averaging window"));
    }
    if chart.traces.iter().any(|trace| trace.mu_dynamic.is_some()) {
        legend.push((Swatch::Dashed(INK), chart.means));
    }

    let x_axis = || {
        let times = points().map(|point| point[0]);
        let [low, high] = times.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], t| [l.min(t), h.max(t)]);
        Axis::over("time (ms)", if high > low { [low.min(0.0), high] } else { [low - 0.5, high + 0.5] })
    };
    let reach = |mean: Estimate| [-1.0, 1.0].map(|side| mean.value + side * mean.error.unwrap_or(0.0));
    let mu = points().map(|point| point[1]).chain(means().flat_map(reach));
    let room = VALUES[0] + if means().any(|mean| mean.error.is_some()) { VALUES[1] } else { 0.0 };
    let y_axis = Axis::as_needed("friction coefficient", mu);
    picture(HEIGHT, |canvas| {
        let top = canvas.heading(chart.title, &legend)?;
        let frame = [LEFT, top, WIDTH - room, HEIGHT - 62.0];
        let plot = Plot::new(canvas, frame, x_axis(), y_axis)?;
        for span_ms in united(chart.traces.iter().filter_map(|trace| trace.window_ms).collect()) {
            plot.span(span_ms, GREY, SHADE)?;
        }
        for (trace, color) in coloured() {
            plot.line(trace.series.points, color, 1.6)?;
        }
        let mut means: Vec<(f64, Estimate)> = Vec::new();
        // Bars side by side at the end of the windows.
        for (place, (trace, color)) in coloured().enumerate() {
            let aside = -BESIDE * place as f64;
            let (Some(mean), [first, .., last]) = (trace.mu_dynamic, trace.series.points) else { continue };
            let [from, to] = trace.window_ms.unwrap_or([first[0], last[0]]);
            plot.dashed([[from, mean.value], [to, mean.value]], INK)?;
            if let Some(error) = mean.error {
                plot.error_bar([to, mean.value], error, aside, color)?;
            }
            means.push((plot.at([to, mean.value])[1], mean));
        }
        // Values from the top down, without overlap.
        means.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut free = f64::NEG_INFINITY;
        for (page_y, mean) in means {
            let page_y = page_y.max(free);
            let error = mean.error.map_or_else(String::new, |error| format!(" ± {error:.4}"));
            plot.margin_text(&format!("{:.4}{error}", mean.value), page_y)?;
            free = page_y + 1.2 * TEXT_SIZE;
        }
        Ok(())
    })
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
            series: Series { label, points: &points },
            window_ms: Some([0.6, 1.0]),
            mu_dynamic: Some(Estimate { value, error }),
        };
        let traces = [trace("flat", 0.2702, None), trace("patterned <130>", 0.2148, Some(0.0031))];
        let chart = FrictionTraceChart { title: "Friction at 2.6 MPa", traces: &traces, means: "means as told" };
        let svg = friction_trace(&chart).unwrap();
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
        assert_eq!(svg, friction_trace(&chart).unwrap());
    }

    #[test]
    fn overlapping_windows_are_shaded_once() {
        assert_eq!(united(vec![[0.64, 1.0], [0.6, 0.9], [2.0, 3.0]]), [[0.6, 1.0], [2.0, 3.0]]);
    }

    #[test]
    fn nothing_and_infinity_are_refused() {
        let empty = FrictionTraceChart { title: "t", traces: &[], means: "m" };
        assert!(matches!(friction_trace(&empty), Err(ChartError::Empty { .. })));
        let points = [[0.0, f64::NAN]];
        let traces = [Trace { series: Series { label: "a", points: &points }, window_ms: None, mu_dynamic: None }];
        // A mean whose trace is missing is left out while other traces are drawn.
        let there = [[0.0, 0.1], [1.0, 0.2]];
        let mean = Estimate { value: 0.1234, error: None };
        let trace = |points| Trace { series: Series { label: "a", points }, window_ms: None, mu_dynamic: Some(mean) };
        let half = friction_trace(&FrictionTraceChart { title: "t", traces: &[trace(&[]), trace(&there)], means: "m" })
            .unwrap();
        assert_eq!(half.matches("0.1234").count(), 1);
        let bad = FrictionTraceChart { title: "t", traces: &traces, means: "m" };
        assert!(matches!(friction_trace(&bad), Err(ChartError::NotFinite { .. })));
    }
}
