//! Charts of surfaces: heights seen from above, along a line, by frequency and near the edges of cavities, and the
//! power spectrum.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use plotters::style::text_anchor::{HPos, VPos};

use super::{
    Axis, Canvas, Chart, ChartError, GREY, INK, LEFT, Layer, Mark, PALETTE, PRECISION, Plot, Swatch, WIDTH, check,
    extremes, failed,
};

/// Draws the height along a line; each point is a position and a height in micrometres. Heights are exaggerated.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw or a value is not finite.
pub fn section(title: &str, points_um: &[[f64; 2]]) -> Result<String, ChartError> {
    let [_, last] = extremes(points_um.iter().map(|[x, _]| *x));
    // A single point still has an axis.
    let x = Axis::over("x (µm)", [0.0, if last > 0.0 { last } else { 1.0 }]);
    let heights = Axis::around("height (µm)", points_um.iter().map(|[_, height]| *height));
    let line = Layer::Line(points_um.to_vec(), PALETTE[0], 1.5);
    Chart::new(title, 320.0, Vec::new()).plot(x, heights, [line]).svg()
}

/// Draws power against wave number on logarithmic axes. Each of `log_points` has the decimal logarithms of the wave
/// number in rad/um and of the power spectral density in um^4.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw or a value is not finite.
pub fn spectrum(title: &str, log_points: &[[f64; 2]]) -> Result<String, ChartError> {
    let x = Axis::logarithmic("wave number (rad/um)", log_points.iter().map(|[q, _]| *q));
    let y = Axis::powers("power spectral density (um^4)", log_points.iter().map(|[_, power]| *power));
    let line = Layer::Line(log_points.to_vec(), PALETTE[0], 1.8);
    let marks = Layer::marks(Mark::Circle, log_points.iter().copied(), PALETTE[0]);
    Chart::new(title, 440.0, Vec::new()).plot(x, y, [line, marks]).svg()
}

const GAP: f64 = 28.0;

/// Draws a histogram of heights beside the bearing curve, on one height axis in micrometres. Each of `shares` is the
/// middle of a class, `class_um` wide, and its share of the surface in per cent; each of `bearing` is the share of the
/// surface at or above a height, in per cent, and that height; `core_um` are the lower and upper end of the core (Sk).
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

/// Opacity of the band of standard errors.
const BAND: f64 = 0.18;

/// Draws the mean height of the land against the distance from the edges of cavities; heights are exaggerated. Each of
/// `points_um` is a distance from the edge at half depth, a mean height above the land and its standard error. Each of
/// `rim_um`, which may be empty, is a distance and a height of the fitted rim, named `rim_label` in the legend. At the
/// distance `start_um` the wall ends and a rim begins.
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

/// Values over a surface seen from above: heights or pressures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceValues<'a> {
    /// Values; the value at position i along x and j along y has the index i * `columns` + j. NaN where a value is
    /// missing.
    pub values: &'a [f64],
    /// Number of values along y.
    pub columns: usize,
    /// Unit of the values.
    pub unit: &'a str,
    /// Values at the lower and the upper end of the colour scale.
    pub scale: [f64; 2],
    /// Side lengths of the map along x and y.
    pub side_um: [f64; 2],
}

/// Maximum height of the picture, in picture units.
const MAX_HEIGHT: f64 = 760.0;
/// Minimum side of the drawn map, in picture units.
const MIN_SIDE: f64 = 90.0;
/// Space right of the map for the colour scale, in picture units.
const SCALE_SPACE: f64 = 130.0;
const SCALE_WIDTH: f64 = 22.0;
const TOP: f64 = 62.0;
/// Height of the line with the sliding direction, in picture units.
const SLIDING_HEIGHT: f64 = 26.0;
const BOTTOM: f64 = 62.0;
/// Colour of a missing value.
const MISSING: [u8; 3] = [190, 190, 190];

/// Colour scale: Viridis (van der Walt and Smith) at ten equal steps, whose lightness rises uniformly, so that the map
/// is readable in grey and with any colour vision.
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

/// Colour at `share` of the colour scale, from 0 to 1; NaN gives the colour of a missing value.
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

/// Draws the surface from above, x to the right and y upwards, to scale, with a colour scale. Marks the position
/// `section_y_um` of a section along x, and the direction of `sliding`: a unit vector in the axes of the map, and a
/// label.
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
    let map =
        png(rows, columns, |across, down| color((of.values[across * columns + (columns - 1 - down)] - low) / span))?;
    let scale = png(1, 256, |_, down| color(1.0 - down as f64 / 255.0))?;

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
    let images = image(&scale, scale_frame) + &image(&map, frame);
    Ok(svg.replace("</svg>", &(images + "</svg>")))
}

/// Encodes `wide` x `tall` pixels as PNG; `color(across, down)` counts from the top left.
fn png(wide: usize, tall: usize, color: impl Fn(usize, usize) -> [u8; 3]) -> Result<Vec<u8>, ChartError> {
    let pixels = (0..tall).flat_map(|down| (0..wide).map(move |across| (across, down)));
    let bytes: Vec<u8> = pixels.flat_map(|(across, down)| color(across, down)).collect();
    // Maps are at most some hundred pixels wide and tall, so that the casts are exact.
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, wide as u32, tall as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header().map_err(failed)?;
    writer.write_image_data(&bytes).map_err(failed)?;
    writer.finish().map_err(failed)?;
    Ok(file)
}

/// SVG element that shows a `png` within the frame (left, top, right, bottom), in picture units.
fn image(png: &[u8], [left, top, right, bottom]: [f64; 4]) -> String {
    format!(
        "<image x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" preserveAspectRatio=\"none\" \
         style=\"image-rendering:pixelated\" href=\"data:image/png;base64,{}\"/>\n",
        left * PRECISION,
        top * PRECISION,
        (right - left) * PRECISION,
        (bottom - top) * PRECISION,
        STANDARD.encode(png)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_profile_without_a_rim_has_no_name_of_one_and_one_without_points_is_refused() {
        let points = [[6.0, 0.9, 0.1], [8.0, 0.5, 0.1], [10.0, 0.0, 0.05]];
        let rim = [[5.0, 1.0], [10.0, 0.0]];
        assert!(!edge_profile("t", &points, &[], "ramp rim", 5.0).unwrap().contains("ramp rim"));
        assert!(edge_profile("t", &[], &rim, "ramp rim", 5.0).is_err());
        assert!(edge_profile("t", &points, &rim, "ramp rim", f64::NAN).is_err());
    }

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
        assert_eq!((color(0.0), color(1.0), color(f64::NAN)), (SCALE[0], SCALE[9], MISSING));
        assert_eq!((color(-5.0), color(7.0)), (SCALE[0], SCALE[9]));
        // Lightness (Rec. 709) never decreases.
        let lightness = |share: f64| {
            let [r, g, b] = color(share).map(f64::from);
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        assert!((0..100).all(|n| lightness(f64::from(n + 1) / 100.0) > lightness(f64::from(n) / 100.0)));
    }

    #[test]
    fn maps_without_points_are_refused() {
        assert!(map(&[], 3, [1.0, 1.0], None).is_err());
        assert!(map(&[0.0; 4], 3, [1.0, 1.0], None).is_err());
        assert!(map(&[0.0; 6], 3, [f64::NAN, 1.0], None).is_err());
    }

    #[test]
    fn pixels_come_back_from_the_file() {
        let file = png(3, 2, |across, down| [across as u8, down as u8, 7]).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(file)).read_info().unwrap();
        let mut pixels = vec![0; 18];
        let info = reader.next_frame(&mut pixels).unwrap();
        assert_eq!((info.width, info.height), (3, 2));
        assert_eq!(pixels[..6], [0, 0, 7, 1, 0, 7]);
        assert_eq!(pixels[15..], [2, 1, 7]);
    }
}
