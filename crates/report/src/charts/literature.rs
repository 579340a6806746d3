//! Chart of published ratios beside measured ones.

use super::ChartError;
use super::axis::Axis;
use super::canvas::{GREY, Mark, PALETTE, Swatch};
use super::chart::{Chart, Layer};

/// Draws one column of marks for the user's `own` ratios of textured over flat friction, and one, by number from 1, for those
/// of each `published` source.
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
