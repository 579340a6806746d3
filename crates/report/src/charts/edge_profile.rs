//! Chart of height against distance from the edges of cavities.

use super::canvas::{LEFT, Mark, PALETTE, RIGHT, Swatch, WIDTH, picture};
use super::plot::{Axis, Plot};
use super::{ChartError, check};

/// Mean profile of the land before an edge, with its rim.
#[derive(Clone, Copy, Debug)]
pub struct EdgeProfileChart<'a> {
    /// Title above the picture.
    pub title: &'a str,
    /// Distance from the edge at half depth, mean height above the land, and standard error of the height.
    pub points_um: &'a [[f64; 3]],
    /// Fitted rim as distance and height; may be empty.
    pub rim_um: &'a [[f64; 2]],
    /// Name of the fitted rim in the legend.
    pub rim_label: &'a str,
    /// Distance at which the wall ends and a rim begins.
    pub start_um: f64,
}

const HEIGHT: f64 = 400.0;
/// Opacity of the band of standard errors.
const BAND: f64 = 0.18;

/// Draws the profile; heights are exaggerated.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw or a value is not finite.
pub fn edge_profile(chart: &EdgeProfileChart<'_>) -> Result<String, ChartError> {
    check(chart.title, chart.points_um.iter().flatten().chain([&chart.start_um]))?;
    if !chart.rim_um.is_empty() {
        check(chart.title, chart.rim_um.iter().flatten())?;
    }
    if chart.points_um.is_empty() {
        return Err(ChartError::Empty { title: chart.title.to_owned() });
    }
    let [blue, vermilion, ..] = PALETTE;
    let side = |sign: f64| chart.points_um.iter().map(move |[x, height, error]| [*x, height + sign * error]);
    let band: Vec<[f64; 2]> = side(-1.0).chain(side(1.0).rev()).collect();
    let means: Vec<[f64; 2]> = side(0.0).collect();
    let mut legend =
        vec![(Swatch::Mark(Mark::Circle, blue), "mean height"), (Swatch::Band(blue, BAND), "± standard error")];
    if !chart.rim_um.is_empty() {
        legend.push((Swatch::Line(vermilion), chart.rim_label));
    }
    let x = Axis::from_zero("distance from the edge at half depth (µm)", means.iter().map(|point| point[0]));
    let heights = band.iter().chain(chart.rim_um).map(|point| point[1]).chain([0.0]);
    let y = Axis::around("height above the land (µm)", heights);
    picture(HEIGHT, |canvas| {
        let top = canvas.heading(chart.title, &legend)?;
        let plot = Plot::new(canvas, [LEFT, top, WIDTH - RIGHT, HEIGHT - 62.0], x, y)?;
        plot.vertical(chart.start_um, "end of the wall")?;
        plot.polygon(&band, blue, BAND)?;
        plot.line(&means, blue, 1.2)?;
        plot.line(chart.rim_um, vermilion, 1.8)?;
        means.iter().try_for_each(|&point| plot.mark(Mark::Circle, point, None, 0.0, blue))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn profile_rim_and_wall_are_drawn_and_named() {
        let points = [[6.0, 0.9, 0.1], [8.0, 0.5, 0.1], [10.0, 0.0, 0.05]];
        let rim = [[5.0, 1.0], [10.0, 0.0]];
        let chart =
            EdgeProfileChart { title: "t", points_um: &points, rim_um: &rim, rim_label: "ramp rim", start_um: 5.0 };
        let svg = edge_profile(&chart).unwrap();
        for text in ["mean height", "± standard error", "ramp rim", "end of the wall", "height above the land (µm)"] {
            assert!(svg.contains(&format!("\n{text}\n")), "{text}");
        }
        // Three marks and one in the legend.
        assert_eq!(svg.matches("<circle").count(), 4);
        let bare = edge_profile(&EdgeProfileChart { rim_um: &[], ..chart }).unwrap();
        assert!(!bare.contains("ramp rim"));
        assert!(edge_profile(&EdgeProfileChart { points_um: &[], ..chart }).is_err());
        assert!(edge_profile(&EdgeProfileChart { start_um: f64::NAN, ..chart }).is_err());
    }
}
