//! Chart of measured and modelled friction of flat samples against pressure.

use super::canvas::{LEFT, Mark, NARROW, PALETTE, RIGHT, Swatch, WIDTH, picture_of_size};
use super::plot::{Axis, Plot};
use super::{ChartError, Estimate, check};

/// Friction of flat samples at one speed and humidity.
#[derive(Clone, Debug, PartialEq)]
pub struct FlatSeries {
    /// Name in the legend.
    pub label: String,
    /// Nominal pressure in MPa and measured friction with its standard deviation; pressures increase.
    pub measured: Vec<(f64, Estimate)>,
    /// Nominal pressure in MPa and modelled friction.
    pub modelled: Vec<[f64; 2]>,
}

/// Friction of flat samples at all conditions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlatFrictionChart<'a> {
    /// Title.
    pub title: &'a str,
    /// One series per condition.
    pub series: &'a [FlatSeries],
}

const HEIGHT: f64 = 500.0;
/// Horizontal offset between the marks of neighbouring conditions at one pressure, in picture units.
const ASIDE: f64 = 9.0;

/// Draws measured friction as marks with error bars and modelled friction as rings; each condition has a colour and a mark.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw or a value is not finite.
pub fn flat_friction(chart: &FlatFrictionChart<'_>) -> Result<String, ChartError> {
    of_width(chart, WIDTH)
}

/// Draws [`flat_friction`] for a phone.
///
/// # Errors
/// Same as [`flat_friction`].
pub fn flat_friction_narrow(chart: &FlatFrictionChart<'_>) -> Result<String, ChartError> {
    of_width(chart, NARROW)
}

fn of_width(chart: &FlatFrictionChart<'_>, width: f64) -> Result<String, ChartError> {
    let ends = |of: &FlatSeries| {
        let bars =
            of.measured.iter().flat_map(|(_, at)| [-1.0, 1.0].map(|sign| at.value + sign * at.error.unwrap_or(0.0)));
        bars.chain(of.modelled.iter().map(|point| point[1])).collect::<Vec<f64>>()
    };
    let values: Vec<f64> = chart.series.iter().flat_map(ends).collect();
    let pressures: Vec<f64> =
        chart.series.iter().flat_map(|of| of.measured.iter().map(|(pressure, _)| *pressure)).collect();
    check(chart.title, values.iter().chain(&pressures))?;
    let x_axis = Axis::around("nominal pressure (MPa)", pressures);
    let y_axis = Axis::around("dynamic friction coefficient", values);
    let style =
        |place: usize| (PALETTE[place % PALETTE.len()], Mark::FILLED[place / PALETTE.len() % Mark::FILLED.len()]);
    let aside = ASIDE * width / WIDTH;
    let middle = 0.5 * (chart.series.len() as f64 - 1.0);
    picture_of_size([width, HEIGHT], |canvas| {
        let mut legend: Vec<(Swatch, &str)> = Vec::new();
        for (place, of) in chart.series.iter().enumerate() {
            let (colour, mark) = style(place);
            legend.push((Swatch::Mark(mark, colour), &of.label));
        }
        legend.push((Swatch::Mark(Mark::Ring, PALETTE[0]), "fitted model"));
        let top = canvas.heading(chart.title, &legend)?;
        let plot = Plot::new(canvas, [LEFT, top, width - RIGHT, HEIGHT - 62.0], x_axis, y_axis)?;
        for (place, of) in chart.series.iter().enumerate() {
            let (colour, mark) = style(place);
            let aside = aside * (place as f64 - middle);
            for (pressure, at) in &of.measured {
                plot.mark(mark, [*pressure, at.value], at.error, aside, colour)?;
            }
            for point in &of.modelled {
                plot.mark(Mark::Ring, *point, None, aside, colour)?;
            }
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(label: &str, mu: f64) -> FlatSeries {
        let at = |pressure_mpa: f64, value: f64| (pressure_mpa, Estimate { value, error: Some(0.002) });
        let measured = vec![at(0.65, mu), at(2.6, mu + 0.02)];
        FlatSeries { label: label.to_owned(), measured, modelled: vec![[0.65, mu + 0.001], [2.6, mu + 0.019]] }
    }

    #[test]
    fn every_condition_has_its_marks_and_its_name() {
        let all = [series("2 mm/s, 15 %", 0.25), series("2 mm/s, 40 %", 0.3)];
        let svg = flat_friction(&FlatFrictionChart { title: "t", series: &all }).unwrap();
        // Two marks and two rings per condition, two marks and one ring in the legend; none is drawn at zero.
        assert_eq!(svg.matches("<circle").count(), 2 * (2 + 2) + 2 + 1);
        for text in ["2 mm/s, 15 %", "2 mm/s, 40 %", "fitted model", "0.26"] {
            assert!(svg.contains(&format!("\n{text}\n")), "{text}");
        }
        assert!(!svg.contains("\n0.00\n"));
        assert!(flat_friction(&FlatFrictionChart { title: "t", series: &[] }).is_err());
    }
}
