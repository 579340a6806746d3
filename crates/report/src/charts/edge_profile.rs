//! Chart of height against distance from the edges of cavities.

use super::axis::Axis;
use super::canvas::{Mark, PALETTE, Swatch};
use super::chart::{Chart, Layer};
use super::{ChartError, check};

/// Opacity of the band of standard errors.
const BAND: f64 = 0.18;

/// Draws the mean profile of the land before an edge; heights are exaggerated. Each of `points_um` is a distance from the edge at
/// half depth, a mean height above the land and its standard error; `rim_um` is the fitted rim, distances and heights, may be
/// empty and has the name `rim_label`. At the distance `start_um` the wall ends and a rim begins.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw or a value is not finite.
pub fn edge_profile(
    title: &str,
    points_um: &[[f64; 3]],
    rim_um: &[[f64; 2]],
    rim_label: &str,
    start_um: f64,
) -> Result<String, ChartError> {
    check(title, points_um.as_flattened().iter().copied())?;
    let [blue, vermilion, ..] = PALETTE;
    let side = |sign: f64| points_um.iter().map(move |[x, height, error]| [*x, height + sign * error]);
    let band: Vec<[f64; 2]> = side(-1.0).chain(side(1.0).rev()).collect();
    let mut legend =
        vec![(Swatch::Mark(Mark::Circle, blue), "mean height"), (Swatch::Band(blue, BAND), "± standard error")];
    if !rim_um.is_empty() {
        legend.push((Swatch::Line(vermilion), rim_label));
    }
    let x = Axis::from_zero("distance from the edge at half depth (µm)", points_um.iter().map(|point| point[0]));
    let heights = band.iter().chain(rim_um).map(|point| point[1]).chain([0.0]);
    let y = Axis::around("height above the land (µm)", heights);
    let layers = [
        Layer::Vertical(start_um, "end of the wall"),
        Layer::Area(band, blue, BAND),
        Layer::Line(side(0.0).collect(), blue, 1.2),
        Layer::Line(rim_um.to_vec(), vermilion, 1.8),
        Layer::marks(Mark::Circle, side(0.0), blue),
    ];
    Chart::new(title, 400.0, legend).plot(x, y, layers).svg()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn profile_rim_and_wall_are_drawn_and_named() {
        let points = [[6.0, 0.9, 0.1], [8.0, 0.5, 0.1], [10.0, 0.0, 0.05]];
        let rim = [[5.0, 1.0], [10.0, 0.0]];
        let svg = edge_profile("t", &points, &rim, "ramp rim", 5.0).unwrap();
        for text in ["mean height", "± standard error", "ramp rim", "end of the wall", "height above the land (µm)"] {
            assert!(svg.contains(&format!("\n{text}\n")), "{text}");
        }
        // Three marks and one in the legend.
        assert_eq!(svg.matches("<circle").count(), 4);
        assert!(!edge_profile("t", &points, &[], "ramp rim", 5.0).unwrap().contains("ramp rim"));
        assert!(edge_profile("t", &[], &rim, "ramp rim", 5.0).is_err());
        assert!(edge_profile("t", &points, &rim, "ramp rim", f64::NAN).is_err());
    }
}
