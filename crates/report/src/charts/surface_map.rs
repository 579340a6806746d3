//! Chart of a quantity over a surface, seen from above.

use plotters::style::text_anchor::{HPos, VPos};

use super::axis::Axis;
use super::canvas::{Canvas, INK, LEFT, Swatch, WIDTH};
use super::chart::{Chart, Layer, Plot};
use super::raster::Raster;
use super::{ChartError, check};

/// Values over a surface seen from above: heights or pressures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceValues<'a> {
    /// Values, row by row along y; NaN where a value is missing.
    pub values: &'a [f64],
    /// Number of values per row.
    pub columns: usize,
    /// Unit of the values.
    pub unit: &'a str,
    /// Values at the ends of the colour scale.
    pub scale: [f64; 2],
    /// Side lengths of the map along x and y.
    pub side_um: [f64; 2],
}

/// Maximum page height, and minimum side of the drawn map.
const MAX_HEIGHT: f64 = 760.0;
const MIN_SIDE: f64 = 90.0;
/// Space right of the map for the colour scale.
const SCALE_SPACE: f64 = 130.0;
const SCALE_WIDTH: f64 = 22.0;
const TOP: f64 = 62.0;
/// Height of the line with the sliding direction.
const SLIDING_HEIGHT: f64 = 26.0;
const BOTTOM: f64 = 62.0;
/// Colour of a missing value.
const MISSING: [u8; 3] = [190, 190, 190];

/// Viridis (van der Walt and Smith) at ten equal steps: uniform in lightness, so that it is readable in grey and with
/// any colour vision.
const SCALE: [[u8; 3]; 10] = [
    [68, 1, 84],
    [72, 40, 120],
    [62, 73, 137],
    [49, 104, 142],
    [38, 130, 142],
    [31, 158, 137],
    [53, 183, 121],
    [110, 206, 88],
    [181, 222, 43],
    [253, 231, 37],
];

/// Colour at `share` of the scale, 0 to 1.
fn color(share: f64) -> [u8; 3] {
    if share.is_nan() {
        return MISSING;
    }
    let place = share.clamp(0.0, 1.0) * (SCALE.len() - 1) as f64;
    let step = (place as usize).min(SCALE.len() - 2);
    let rest = place - step as f64;
    // The value lies between two bytes, so that the cast is exact after rounding.
    std::array::from_fn(|c| {
        (f64::from(SCALE[step][c]) * (1.0 - rest) + f64::from(SCALE[step + 1][c]) * rest).round() as u8
    })
}

/// Draws the surface from above, x to the right, y upwards, to scale, with the colour scale at its side; marks the position
/// `section_y_um` of a section along x, and the direction of `sliding`, a unit vector in the axes of the map, with a label.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw, rows are incomplete or a number is not finite.
pub fn surface_map(
    title: &str,
    of: &SurfaceValues<'_>,
    section_y_um: Option<f64>,
    sliding: Option<([f64; 2], &str)>,
) -> Result<String, ChartError> {
    let direction = sliding.map(|(direction, _)| direction);
    check(title, of.side_um.into_iter().chain(of.scale).chain(section_y_um).chain(direction.into_iter().flatten()))?;
    let columns = of.columns.max(1);
    let rows = of.values.len() / columns;
    if rows == 0 || rows * columns != of.values.len() {
        return Err(ChartError::Empty { title: title.to_owned() });
    }
    let [low, high] = of.scale;
    let span = if high > low { high - low } else { 1.0 };
    let map = Raster::new(rows, columns, |across, down| {
        color((of.values[across * columns + (columns - 1 - down)] - low) / span)
    })?;
    let scale = Raster::new(1, 256, |_, down| color(1.0 - down as f64 / 255.0))?;

    let top = TOP + if sliding.is_some() { SLIDING_HEIGHT } else { 0.0 };
    let tall = MAX_HEIGHT - top - BOTTOM;
    let per_um = ((WIDTH - LEFT - SCALE_SPACE) / of.side_um[0]).min(tall / of.side_um[1]);
    let [width, height] = of.side_um.map(|side| (side * per_um).max(MIN_SIDE));
    let frame = [LEFT, top, LEFT + width, top + height];
    let scale_frame = [frame[2] + 34.0, top, frame[2] + 34.0 + SCALE_WIDTH, top + height];
    let beside = |canvas: &Canvas<'_>, plot: &Plot<'_>| {
        if let Some(section_y_um) = section_y_um {
            // The mark stands outside, so that it does not hide the map.
            let [right, level] = plot.at([of.side_um[0], section_y_um]);
            let arrow = [[right + 3.0, level], [right + 12.0, level - 5.0], [right + 12.0, level + 5.0]];
            canvas.polygon(&arrow, INK, 1.0)?;
        }
        for (value, text) in Axis::over("", [low, low + span]).ticks {
            let at = [scale_frame[2] + 7.0, scale_frame[3] - (value - low) / span * height];
            canvas.line(&[[scale_frame[2], at[1]], [scale_frame[2] + 4.0, at[1]]], INK, 1.0)?;
            canvas.text(&text, at, (HPos::Left, VPos::Center), INK)?;
        }
        canvas.text(of.unit, [scale_frame[0], top - 12.0], (HPos::Left, VPos::Center), INK)
    };
    let legend = sliding.map(|(direction, label)| (Swatch::Toward(direction, INK), label)).into_iter().collect();
    let [x, y] = [("x (µm)", of.side_um[0]), ("y (µm)", of.side_um[1])].map(|(name, end)| Axis::over(name, [0.0, end]));
    let svg =
        Chart::new(title, height + top + BOTTOM, legend).plot_in(frame, x, y, [Layer::Own(Box::new(beside))]).svg()?;
    map.onto(scale.onto(svg, scale_frame)?, frame)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(
        values: &[f64],
        columns: usize,
        side_um: [f64; 2],
        sliding: Option<([f64; 2], &str)>,
    ) -> Result<String, ChartError> {
        let of = SurfaceValues { values, columns, unit: "um", scale: [-1.0, 1.0], side_um };
        surface_map("t", &of, Some(1.0), sliding)
    }

    #[test]
    fn a_map_and_its_scale_are_images_with_units() {
        let svg = map(&[0.0, 1.0, -1.0, f64::NAN, 0.5, 0.2], 3, [20.0, 30.0], None).unwrap();
        assert_eq!(svg.matches("<image ").count(), 2);
        assert_eq!(svg.matches("data:image/png;base64,iVBORw0KGgo").count(), 2);
        for text in ["x (µm)", "y (µm)", "um", "-1.0", "0.5"] {
            assert!(svg.contains(&format!("\n{text}\n")), "{text}");
        }
        assert!(svg.trim_end().ends_with("</svg>"));
    }

    #[test]
    fn an_arrow_says_which_way_a_surface_slides_where_that_is_known() {
        let square = |sliding| map(&[0.0; 400], 20, [1e3, 1e3], sliding);
        let drawn = |direction| square(Some((direction, "sliding direction"))).unwrap();
        // Polylines of an arrow: shaft and barbs.
        let lines = |svg: &str| svg.matches("<polyline").count();
        let (without, along) = (square(None).unwrap(), drawn([1.0, 0.0]));
        assert!(!without.contains("sliding") && along.contains("\nsliding direction\n"));
        assert_eq!(lines(&along), lines(&without) + 2);
        assert!(along != drawn([0.0, 1.0]) && drawn([0.0, 1.0]) != drawn([0.0, -1.0]));
        let height: f64 = along.split("height=\"").nth(1).unwrap().split('"').next().unwrap().parse().unwrap();
        assert!(height <= MAX_HEIGHT, "{height}");
        assert!(square(Some(([f64::NAN, 0.0], "l"))).is_err());
    }

    #[test]
    fn pages_stay_bounded_whatever_the_aspect() {
        let heights = vec![0.0; 400];
        for side_um in [[1e4, 1.0], [1.0, 1e4], [1e3, 1e3]] {
            let svg = map(&heights, 20, side_um, None).unwrap();
            let height: f64 = svg.split("height=\"").nth(1).unwrap().split('"').next().unwrap().parse().unwrap();
            assert!((200.0 - 1.0..=MAX_HEIGHT).contains(&height), "{height}");
        }
    }

    #[test]
    fn colours_run_from_dark_to_light_and_missing_is_grey() {
        let light = |share| color(share).iter().map(|&c| u32::from(c)).sum::<u32>();
        assert_eq!((color(0.0), color(1.0), color(f64::NAN)), (SCALE[0], SCALE[9], MISSING));
        assert_eq!((color(-5.0), color(7.0)), (SCALE[0], SCALE[9]));
        // Lightness (Rec. 709) never decreases.
        let lightness = |share: f64| {
            let [r, g, b] = color(share).map(f64::from);
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        assert!((0..100).all(|n| lightness(f64::from(n + 1) / 100.0) > lightness(f64::from(n) / 100.0)));
        assert!(light(1.0) > light(0.0));
    }

    #[test]
    fn maps_without_points_are_refused() {
        assert!(map(&[], 3, [1.0, 1.0], None).is_err());
        assert!(map(&[0.0; 4], 3, [1.0, 1.0], None).is_err());
        assert!(map(&[0.0; 6], 3, [f64::NAN, 1.0], None).is_err());
    }
}
