//! Chart of the height distribution of a surface: histogram and bearing curve.

use super::canvas::{GREY, LEFT, PALETTE, RIGHT, Swatch, WIDTH, picture};
use super::plot::{Axis, Plot};
use super::{ChartError, check};

/// Histogram of heights beside the bearing curve.
#[derive(Clone, Copy, Debug)]
pub struct HeightHistogramChart<'a> {
    /// Title above the picture.
    pub title: &'a str,
    /// Width of a class.
    pub class_um: f64,
    /// Middle of each class, and the class's share of the surface in percent.
    pub shares: &'a [[f64; 2]],
    /// Bearing curve: share of the surface at or above a height, in percent, and the height.
    pub bearing: &'a [[f64; 2]],
    /// Lower and upper height of the core.
    pub core_um: [f64; 2],
}

const HEIGHT: f64 = 460.0;
const GAP: f64 = 28.0;

/// Draws both panels on one height axis.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw or a value is not finite.
pub fn height_histogram(chart: &HeightHistogramChart<'_>) -> Result<String, ChartError> {
    check(chart.title, chart.shares.iter().flatten())?;
    check(chart.title, chart.bearing.iter().flatten().chain(&chart.core_um))?;
    let [blue, vermilion, ..] = PALETTE;
    let legend = [
        (Swatch::Band(blue, 0.75), "share of the surface"),
        (Swatch::Line(vermilion), "bearing curve"),
        (Swatch::Dashed(GREY), "ends of the core (Sk)"),
    ];
    let ends =
        chart.shares.iter().flat_map(|[middle, _]| [middle - 0.5 * chart.class_um, middle + 0.5 * chart.class_um]);
    let heights = Axis::around("height (µm)", ends.chain(chart.core_um));
    picture(HEIGHT, |canvas| {
        let top = canvas.heading(chart.title, &legend)?;
        let bottom = HEIGHT - 62.0;
        let middle = (LEFT + WIDTH - RIGHT) / 2.0;
        let share = Axis::from_zero("share of the surface (%)", chart.shares.iter().map(|[_, share]| *share));
        let left = Plot::new(canvas, [LEFT, top, middle - GAP, bottom], share, heights.clone())?;
        for [height, share] in chart.shares.iter().filter(|[_, share]| *share > 0.0) {
            let [low, high] = [height - 0.5 * chart.class_um, height + 0.5 * chart.class_um];
            canvas.rectangle([left.at([0.0, high]), left.at([*share, low])], blue, 0.75)?;
        }
        let ratio = Axis::over("material ratio (%)", [0.0, 100.0]);
        let right = Plot::new(canvas, [middle + GAP, top, WIDTH - RIGHT, bottom], ratio, heights.unlabelled())?;
        for height in chart.core_um {
            right.horizontal(height, GREY)?;
        }
        // The bearing curve falls to the right, and is drawn against x, which does not decrease.
        right.line(chart.bearing, vermilion, 2.2)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_bar_a_class_and_one_curve() {
        let chart = HeightHistogramChart {
            title: "t",
            class_um: 0.5,
            shares: &[[-0.25, 40.0], [0.25, 60.0], [0.75, 0.0]],
            bearing: &[[0.0, 0.9], [60.0, 0.0], [100.0, -0.5]],
            core_um: [-0.4, 0.6],
        };
        let svg = height_histogram(&chart).unwrap();
        for text in ["height (µm)", "share of the surface (%)", "material ratio (%)", "bearing curve"] {
            assert!(svg.contains(&format!("\n{text}\n")), "{text}");
        }
        // Background, two bars and one bar in the legend.
        assert_eq!(svg.matches("<rect").count(), 4);
        assert!(height_histogram(&HeightHistogramChart { shares: &[], ..chart }).is_err());
        assert!(height_histogram(&HeightHistogramChart { core_um: [f64::NAN, 0.0], ..chart }).is_err());
    }
}
