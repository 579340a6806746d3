//! Chart of measured and modelled friction of flat samples against pressure.

use super::axis::Axis;
use super::canvas::{Mark, PALETTE, Swatch};
use super::chart::{Chart, Layer, width};
use super::{ChartError, Estimate};

/// Friction of flat samples at one speed and humidity.
#[derive(Clone, Debug, PartialEq)]
pub struct FlatSeries {
    /// Name in the legend.
    pub label: String,
    /// Nominal pressure in MPa and measured friction with its standard deviation; pressures increase.
    pub measured: Vec<(f64, Estimate)>,
    /// Nominal pressure in MPa and modelled friction.
    pub modelled: Vec<(f64, Estimate)>,
}

/// Horizontal offset between the marks of neighbouring conditions at one pressure, relative to the width.
const ASIDE: f64 = 0.01;

/// Draws measured friction as marks with error bars and modelled friction as rings; each condition has a colour and a mark.
/// Without a title, the picture is for a phone.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw or a value is not finite.
pub fn flat_friction(title: &str, series: &[FlatSeries]) -> Result<String, ChartError> {
    let measured = || series.iter().flat_map(|of| &of.measured);
    let all = || measured().chain(series.iter().flat_map(|of| &of.modelled));
    let x_axis = Axis::around("nominal pressure (MPa)", measured().map(|(pressure, _)| *pressure));
    let y_axis = Axis::around("dynamic friction coefficient", all().flat_map(|(_, at)| at.ends()));
    let aside = ASIDE * width(title);
    let middle = 0.5 * (series.len() as f64 - 1.0);
    let mut legend: Vec<(Swatch, &str)> = Vec::new();
    let mut layers = Vec::new();
    for (place, of) in series.iter().enumerate() {
        let colour = PALETTE[place % PALETTE.len()];
        let mark = Mark::FILLED[place / PALETTE.len() % Mark::FILLED.len()];
        let aside = aside * (place as f64 - middle);
        legend.push((Swatch::Mark(mark, colour), &of.label));
        layers.push(Layer::Marks(mark, of.measured.clone(), colour, aside));
        layers.push(Layer::Marks(Mark::Ring, of.modelled.clone(), colour, aside));
    }
    legend.push((Swatch::Mark(Mark::Ring, PALETTE[0]), "fitted model"));
    Chart::new(title, 500.0, legend).plot(x_axis, y_axis, layers).svg()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(label: &str, mu: f64) -> FlatSeries {
        let at = |pressure_mpa: f64, value: f64| (pressure_mpa, Estimate { value, error: Some(0.002) });
        let measured = vec![at(0.65, mu), at(2.6, mu + 0.02)];
        FlatSeries {
            label: label.to_owned(),
            measured,
            modelled: vec![(0.65, (mu + 0.001).into()), (2.6, (mu + 0.019).into())],
        }
    }

    #[test]
    fn every_condition_has_its_marks_and_its_name() {
        let all = [series("2 mm/s, 15 %", 0.25), series("2 mm/s, 40 %", 0.3)];
        let svg = flat_friction("t", &all).unwrap();
        // Two marks and two rings per condition, two marks and one ring in the legend; none is drawn at zero.
        assert_eq!(svg.matches("<circle").count(), 2 * (2 + 2) + 2 + 1);
        for text in ["2 mm/s, 15 %", "2 mm/s, 40 %", "fitted model", "0.26"] {
            assert!(svg.contains(&format!("\n{text}\n")), "{text}");
        }
        assert!(!svg.contains("\n0.00\n"));
        assert!(flat_friction("t", &[]).is_err());
    }
}
