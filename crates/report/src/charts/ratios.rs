use super::canvas::{GREY, LEFT, Mark, PALETTE, RIGHT, Swatch, WIDTH, picture};
use super::plot::{Axis, Plot};
use super::{ChartError, Estimate, check, check_length};

/// Measured and modelled ratios.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RatiosChart<'a> {
    /// Title.
    pub title: &'a str,
    /// Nominal pressures, in MPa.
    pub pressure_mpa: &'a [f64],
    /// Series in their order from left to right, for example measured, modelled.
    pub series: &'a [RatioSeries<'a>],
}

/// Ratios from one source.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RatioSeries<'a> {
    /// Name in the legend.
    pub label: &'a str,
    /// One ratio per pressure; `None` where there is none.
    pub ratios: &'a [Option<Estimate>],
}

/// Height of the picture.
const HEIGHT: f64 = 480.0;
/// Horizontal distance between neighbouring marks of one pressure.
const ASIDE: f64 = 20.0;

/// Draws ratios of patterned to flat friction side by side at each pressure.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw, lengths differ or a value is not finite.
pub fn ratios(chart: &RatiosChart<'_>) -> Result<String, ChartError> {
    for series in chart.series {
        check_length(chart.title, chart.pressure_mpa.len(), series.ratios.len())?;
    }
    let bars: Vec<f64> = chart
        .series
        .iter()
        .flat_map(|series| series.ratios.iter().flatten())
        .flat_map(|&Estimate { value, error }| {
            let error = error.unwrap_or(0.0);
            [value - error, value + error]
        })
        .collect();
    check(chart.title, &bars)?;
    check(chart.title, chart.pressure_mpa)?;

    let styled = || chart.series.iter().zip(PALETTE.into_iter().cycle().zip(Mark::ALL.into_iter().cycle()));
    let mut legend: Vec<(Swatch, &str)> =
        styled().map(|(series, (color, mark))| (Swatch::Mark(mark, color), series.label)).collect();
    legend.push((Swatch::Dashed(GREY), "no effect (Amontons-Coulomb)"));
    let names = chart.pressure_mpa.iter().map(|pressure| format!("{pressure}")).collect();
    let x_axis = Axis::of_names("nominal pressure (MPa)", names);
    let y_axis = Axis::around("friction ratio, patterned / flat", bars.into_iter().chain([1.0]));
    picture(HEIGHT, |canvas| {
        let top = canvas.heading(chart.title, &legend)?;
        let plot = Plot::new(canvas, [LEFT, top, WIDTH - RIGHT, HEIGHT - 62.0], x_axis, y_axis)?;
        plot.horizontal(1.0, GREY)?;
        let middle = (chart.series.len() as f64 - 1.0) / 2.0;
        for (order, (series, (color, mark))) in styled().enumerate() {
            for (place, estimate) in series.ratios.iter().enumerate() {
                let Some(Estimate { value, error }) = *estimate else { continue };
                plot.mark(mark, [place as f64, value], error, ASIDE * (order as f64 - middle), color)?;
            }
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn absent_ratios_are_left_out() {
        let some = |value| Some(Estimate { value, error: Some(0.02) });
        let measured = [some(0.93), None, some(0.74)];
        let modelled = [some(0.97), some(0.92), some(0.83)];
        let series = [
            RatioSeries { label: "measured", ratios: &measured },
            RatioSeries { label: "modelled", ratios: &modelled },
        ];
        let chart = RatiosChart { title: "Ratios", pressure_mpa: &[0.65, 1.3, 2.6], series: &series };
        let svg = ratios(&chart).unwrap();
        // The first series has circles: two marks and one in the legend.
        assert_eq!(svg.matches("<circle").count(), 3);
        for text in ["measured", "modelled", "0.65", "1.3", "2.6"] {
            assert!(svg.contains(&format!("\n{text}\n")), "{text}");
        }
        let short = RatiosChart { pressure_mpa: &[0.65], ..chart };
        assert!(matches!(ratios(&short), Err(ChartError::LengthMismatch { .. })));
    }
}
