//! Chart of measured and modelled ratios.

use super::axis::Axis;
use super::canvas::{GREY, Mark, PALETTE, Swatch};
use super::chart::{Chart, Layer};
use super::{ChartError, Estimate, check_length};

/// Horizontal distance between neighbouring marks of one pressure.
const ASIDE: f64 = 20.0;

/// Draws ratios of patterned to flat friction side by side at each nominal pressure. Each of `series`, from left to right, has a
/// name, for example measured or modelled, and one ratio per pressure, `None` where there is none.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw, lengths differ or a value is not finite.
pub fn ratios(
    title: &str,
    pressure_mpa: &[f64],
    series: &[(String, Vec<Option<Estimate>>)],
) -> Result<String, ChartError> {
    for (_, ratios) in series {
        check_length(title, pressure_mpa.len(), ratios.len())?;
    }
    let all = series.iter().flat_map(|(_, ratios)| ratios.iter().flatten());
    let x_axis = Axis::of_names("nominal pressure (MPa)", pressure_mpa);
    let y_axis = Axis::around("friction ratio, patterned / flat", all.flat_map(|of| of.ends()).chain([1.0]));
    let middle = (series.len() as f64 - 1.0) / 2.0;
    let mut legend: Vec<(Swatch, &str)> = Vec::new();
    let mut layers = vec![Layer::Horizontal(1.0)];
    let styles = PALETTE.into_iter().cycle().zip(Mark::ALL.into_iter().cycle());
    for (order, ((label, ratios), (color, mark))) in series.iter().zip(styles).enumerate() {
        legend.push((Swatch::Mark(mark, color), label));
        let marks = ratios.iter().enumerate().filter_map(|(place, of)| Some((place as f64, (*of)?))).collect();
        layers.push(Layer::Marks(mark, marks, color, ASIDE * (order as f64 - middle)));
    }
    legend.push((Swatch::Dashed(GREY), "no effect (Amontons-Coulomb)"));
    Chart::new(title, 480.0, legend).plot(x_axis, y_axis, layers).svg()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn absent_ratios_are_left_out() {
        let some = |value| Some(Estimate { value, error: Some(0.02) });
        let measured = [some(0.93), None, some(0.74)];
        let modelled = [some(0.97), some(0.92), some(0.83)];
        let series = [("measured".to_owned(), measured.to_vec()), ("modelled".to_owned(), modelled.to_vec())];
        let svg = ratios("Ratios", &[0.65, 1.3, 2.6], &series).unwrap();
        // The first series has circles: two marks and one in the legend.
        assert_eq!(svg.matches("<circle").count(), 3);
        for text in ["measured", "modelled", "0.65", "1.3", "2.6"] {
            assert!(svg.contains(&format!("\n{text}\n")), "{text}");
        }
        assert!(matches!(ratios("Ratios", &[0.65], &series), Err(ChartError::LengthMismatch { .. })));
    }
}
