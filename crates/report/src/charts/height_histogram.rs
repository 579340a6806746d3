//! Chart of the height distribution of a surface: histogram and bearing curve.

use super::ChartError;
use super::axis::Axis;
use super::canvas::{GREY, PALETTE, Swatch};
use super::chart::{Chart, Layer};

const GAP: f64 = 28.0;

/// Draws a histogram of heights beside the bearing curve, on one height axis in micrometres. Each of `shares` is the middle of a
/// class, `class_um` wide, and its share of the surface in percent; each of `bearing` is the share at or above a height in
/// percent, and the height; `core_um` are the ends of the core.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw or a value is not finite.
pub fn height_histogram(
    title: &str,
    class_um: f64,
    shares: &[[f64; 2]],
    bearing: &[[f64; 2]],
    core_um: [f64; 2],
) -> Result<String, ChartError> {
    let [blue, vermilion, ..] = PALETTE;
    let legend = vec![
        (Swatch::Band(blue, 0.75), "share of the surface"),
        (Swatch::Line(vermilion), "bearing curve"),
        (Swatch::Dashed(GREY), "ends of the core (Sk)"),
    ];
    let edges = |middle: f64| [middle - 0.5 * class_um, middle + 0.5 * class_um];
    let heights = Axis::around("height (µm)", shares.iter().flat_map(|[middle, _]| edges(*middle)).chain(core_um));
    let share = Axis::from_zero("share of the surface (%)", shares.iter().map(|[_, share]| *share));
    let ratio = Axis::over("material ratio (%)", [0.0, 100.0]);
    let bars = shares.iter().filter(|[_, share]| *share > 0.0).map(|[middle, share]| {
        let [low, high] = edges(*middle);
        Layer::Rectangle([[0.0, high], [*share, low]], blue, 0.75)
    });
    // The bearing curve falls to the right, and is drawn against x, which does not decrease.
    let curve = core_um.map(Layer::Horizontal).into_iter().chain([Layer::Line(bearing.to_vec(), vermilion, 2.2)]);
    let mut chart = Chart::new(title, 460.0, legend);
    let [left, top, right, bottom] = chart.frame();
    let middle = (left + right) / 2.0;
    chart.plot_in([left, top, middle - GAP, bottom], share, heights.clone(), bars);
    chart.plot_in([middle + GAP, top, right, bottom], ratio, heights.unlabelled(), curve).svg()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_bar_a_class_and_one_curve() {
        let shares = [[-0.25, 40.0], [0.25, 60.0], [0.75, 0.0]];
        let bearing = [[0.0, 0.9], [60.0, 0.0], [100.0, -0.5]];
        let svg = height_histogram("t", 0.5, &shares, &bearing, [-0.4, 0.6]).unwrap();
        for text in ["height (µm)", "share of the surface (%)", "material ratio (%)", "bearing curve"] {
            assert!(svg.contains(&format!("\n{text}\n")), "{text}");
        }
        // Background, two bars and one bar in the legend.
        assert_eq!(svg.matches("<rect").count(), 4);
        assert!(height_histogram("t", 0.5, &[], &bearing, [-0.4, 0.6]).is_err());
        assert!(height_histogram("t", 0.5, &shares, &bearing, [f64::NAN, 0.0]).is_err());
    }
}
