//! Height map of the surface as 16-bit grey PNG, white at the face and black at the floor.
//!
//! Format: PNG, third edition (W3C). The chunk pHYs states the pixel size, and tEXt the meaning of black and white. The
//! first row has the largest y. Each pixel holds the depth at its middle.

use std::io::{self, Write};

use crate::export::{Cavity, ExportError, Heading, Laser, Layout, ascii, six_digits};

/// Maximum number of pixels along a side of the map.
pub const MAX_PIXELS: u32 = 32_768;
/// Maximum number of pixels along the longer side of the map, if no pixel size is given.
const DEFAULT_PIXELS: f64 = 4096.0;
/// Maximum number of pixels across the smallest extent of a cavity, if no pixel size is given.
const PIXELS_PER_CAVITY: f64 = 16.0;
/// Pixel value of the face, white.
const FACE: u16 = u16::MAX;
/// Pixel value of the floor of cavities, black.
const FLOOR: u16 = 0;

/// Raster of a height map: size of a pixel, number of pixels, and slope of walls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeightMap {
    pixel_m: f64,
    /// Number of columns and rows.
    pub(crate) size: [u32; 2],
    slope: f64,
}

impl HeightMap {
    /// Creates a raster over the specimen of `layout`. The default pixel is a sixteenth of the smallest extent of a
    /// cavity, and at least a 4096th of the extent of the specimen.
    ///
    /// # Errors
    /// [`ExportError::Refused`] for pixels larger than a cavity's smallest extent, which may miss cavities, and for more
    /// than [`MAX_PIXELS`] pixels along a side.
    pub fn new(layout: &Layout, laser: &Laser, pixel_um: Option<f64>) -> Result<Self, ExportError> {
        let extents_m = layout.outline().extents_m();
        let longer_m = extents_m[0].max(extents_m[1]);
        let least_extent_m = layout.pattern().least_extent_m();
        let usual_m = (longer_m / DEFAULT_PIXELS).max(least_extent_m / PIXELS_PER_CAVITY);
        let pixel_m = pixel_um.map_or(usual_m, |pixel_um| pixel_um * 1e-6);
        let pixels = (longer_m / pixel_m - 1e-6).ceil();
        let most_m = least_extent_m.min(longer_m);
        if pixel_m > most_m * (1.0 + 1e-9) || pixels > f64::from(MAX_PIXELS) {
            let [pixel_um, least_um, most_um] =
                [pixel_m, longer_m / f64::from(MAX_PIXELS), most_m].map(|length_m| six_digits(length_m * 1e6));
            return Err(ExportError::Refused(format!(
                "pixels of {pixel_um} um make a height map of {pixels:.0} pixels: expected pixels of {least_um} um, for {MAX_PIXELS} of \
                 them, to {most_um} um, as cavities"
            )));
        }
        // At most MAX_PIXELS, so that the casts are exact.
        let size = extents_m.map(|extent_m| (extent_m / pixel_m - 1e-6).ceil().max(1.0) as u32);
        Ok(Self { pixel_m, size, slope: laser.slope() })
    }

    /// Fills `heights` with the pixels of a row as written to the file. Row 0 has the largest y. Each cell of the
    /// lattice is looked up once, and walls are tested only where the row meets them.
    fn row(&self, layout: &Layout, row: u32, heights: &mut [u16]) {
        heights.fill(FACE);
        let y_m = self.y_m(row);
        let mut column = 0;
        while column < heights.len() {
            // At most MAX_PIXELS, so that the cast is exact.
            let cell = layout.cell([self.x_m(column as u32), y_m]);
            for cavity in &cell.cavities {
                self.cut(layout, cavity, y_m, heights);
            }
            column = self.after(cell.end_x_m).max(column + 1);
        }
    }

    /// Lowers the pixels of the row at `y_m` that lie in `cavity`.
    fn cut(&self, layout: &Layout, cavity: &Cavity, y_m: f64, heights: &mut [u16]) {
        let spans_m = cavity.spans_m([1.0, 0.0], y_m);
        let Some((&[from_m, _], &[_, to_m])) = spans_m.first().zip(spans_m.last()) else { return };
        // One more pixel on either side; the wall distance decides whether these lie inside.
        let (first, end) = (self.after(from_m).saturating_sub(1), (self.after(to_m) + 1).min(heights.len()));
        let wall_distance_m = |column: usize| cavity.wall_distance_m([self.x_m(column as u32), y_m]);
        let mut columns = first..end;
        if self.slope == 0.0 && cavity.is_plain() {
            // Vertical walls on all sides, with floor everywhere between the first and the last pixel inside.
            let inside = |&column: &usize| wall_distance_m(column) >= 0.0;
            if let Some((first, last)) = columns.clone().find(inside).zip(columns.rfind(inside)) {
                heights[first..=last].fill(FLOOR);
            }
            return;
        }
        for column in columns {
            let inside_m = wall_distance_m(column);
            if inside_m >= 0.0 {
                heights[column] = heights[column].min(height(self.depth_inside(layout, inside_m)));
            }
        }
    }

    /// Depth at the distance `inside_m` from the nearest wall, as a fraction of the depth of the cavities.
    fn depth_inside(&self, layout: &Layout, inside_m: f64) -> f64 {
        let slope_m = self.slope * layout.pattern().depth_m();
        // The wall falls by d over the distance d tan(taper).
        if slope_m > 0.0 { (inside_m / slope_m).min(1.0) } else { 1.0 }
    }

    /// x of the middle of the pixels in `column`, in metres from the specimen's centre.
    fn x_m(&self, column: u32) -> f64 {
        (f64::from(column) + 0.5 - f64::from(self.size[0]) / 2.0) * self.pixel_m
    }

    /// y of the middle of the pixels in `row`, in metres from the specimen's centre.
    fn y_m(&self, row: u32) -> f64 {
        (f64::from(self.size[1]) / 2.0 - f64::from(row) - 0.5) * self.pixel_m
    }

    /// First column whose middle lies beyond `x_m`, within rounding; at most one more than the number of columns.
    fn after(&self, x_m: f64) -> usize {
        let columns = f64::from(self.size[0]);
        // At most MAX_PIXELS, so that the cast is exact.
        (x_m / self.pixel_m + columns / 2.0 + 0.5).floor().clamp(0.0, columns + 1.0) as usize
    }
}

/// Pixel value of a relative depth from 0 to 1.
fn height(depth: f64) -> u16 {
    // 0 to 65535, so that the cast is exact.
    ((1.0 - depth) * f64::from(FACE)).round() as u16
}

/// Writes the height map of `layout`: white (65535) is the face, black (0) the depth of the cavities.
///
/// # Errors
/// Errors of the writer `to`.
pub fn height_map(layout: &Layout, map: &HeightMap, heading: &Heading, to: &mut dyn Write) -> io::Result<()> {
    let [columns, rows] = map.size;
    let mut encoder = png::Encoder::new(to, columns, rows);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Sixteen);
    // Pixels per metre, an integer in this format.
    let per_metre = (1.0 / map.pixel_m).round().clamp(1.0, f64::from(u32::MAX)) as u32;
    let dimensions = png::PixelDimensions { xppu: per_metre, yppu: per_metre, unit: png::Unit::Meter };
    encoder.set_pixel_dims(Some(dimensions));
    let depth_um = layout.pattern().depth_m() * 1e6;
    let meaning = format!(
        "pixel {} um; white 65535 = face, black 0 = {depth_um:.3} um deep, linear between; x to the right, y up, centre = centre of the specimen",
        map.pixel_m * 1e6
    );
    for (keyword, text) in [
        ("Software", format!("slipgrid {}", heading.version)),
        ("Title", ascii(heading.name)),
        ("Description", meaning),
    ] {
        encoder.add_text_chunk(keyword.to_owned(), text).map_err(io::Error::other)?;
    }
    let mut writer = encoder.write_header().map_err(io::Error::other)?;
    let mut stream = writer.stream_writer().map_err(io::Error::other)?;
    let mut heights = vec![FACE; columns as usize];
    let mut line = Vec::with_capacity(2 * heights.len());
    for row in 0..rows {
        map.row(layout, row, &mut heights);
        line.clear();
        line.extend(heights.iter().flat_map(|height| height.to_be_bytes()));
        stream.write_all(&line)?;
    }
    stream.finish().map_err(io::Error::other)
}

#[cfg(test)]
mod tests {
    use slipgrid_model::pattern::{Arrangement, Pattern, Planform, Polygon, Texture};

    use super::*;
    use crate::export::Outline;
    use crate::export::layout::every_kind;

    /// Depth at the middle of a pixel as a fraction of the depth of the cavities: 0 on the face, 1 on the floor.
    fn depth(map: &HeightMap, layout: &Layout, column: u32, row: u32) -> f64 {
        let at_m = [map.x_m(column), map.y_m(row)];
        // Where grooves cross, the larger depth counts.
        let cavities = layout.cell(at_m).cavities.into_iter();
        let inside_m = cavities.map(|cavity| cavity.wall_distance_m(at_m)).fold(f64::NEG_INFINITY, f64::max);
        if inside_m >= 0.0 { map.depth_inside(layout, inside_m) } else { 0.0 }
    }

    /// Compares every pixel of `layout` from its row with the separately computed one; returns how many are not face.
    fn compared(layout: &Layout, taper_deg: Option<f64>, pixel_um: f64) -> usize {
        let laser = Laser { wall_taper_deg: taper_deg, ..Laser::default() };
        let map = HeightMap::new(layout, &laser, Some(pixel_um)).unwrap();
        let [columns, rows] = map.size;
        let mut heights = vec![7; columns as usize];
        let mut cut = 0;
        for row in 0..rows {
            map.row(layout, row, &mut heights);
            for (column, &found) in heights.iter().enumerate() {
                let alone = height(depth(&map, layout, column as u32, row));
                assert_eq!(found, alone, "{layout:?}, {taper_deg:?}, {pixel_um} um: {column} {row}");
                cut += usize::from(found != FACE);
            }
        }
        cut
    }

    #[test]
    fn rows_hold_the_pixels_one_by_one_would() {
        let outlines = [
            Outline::Disc { diameter_m: 1.6e-3 },
            Outline::Rectangle { length_m: 1.6e-3, width_m: 1.1e-3 },
            Outline::Ring { outer_diameter_m: 1.6e-3, inner_diameter_m: 0.5e-3 },
        ];
        for (texture, outline) in every_kind().into_iter().flat_map(|kind| outlines.map(|outline| (kind, outline))) {
            // Edges at arbitrary places, and edges and centres on the middles of pixels.
            // The first pixels are smaller than cavity and pitch, the last are as wide as a cavity.
            for (width_m, spacing_m, pixels_um) in
                [(131.2347e-6, 369.9999e-6, [16.1, 77.7, 777.0]), (120e-6, 40e-6, [10.0, 77.7, 777.0])]
            {
                let pattern = Pattern::new(texture, width_m, spacing_m, 5.2e-6).unwrap();
                for layout in [Layout::new(pattern, outline).unwrap(), Layout::clipped(pattern, outline).unwrap()] {
                    for pixel_um in pixels_um.map(|pixel_um: f64| pixel_um.min(pattern.least_extent_m() * 1e6)) {
                        let cut = [None, Some(60.0)].map(|taper_deg| compared(&layout, taper_deg, pixel_um));
                        assert!(pixel_um > 50.0 || cut.iter().all(|&cut| cut > 100), "{layout:?}: {cut:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn polygons_whose_rows_reach_between_each_other_are_whole() {
        let corner = |k: u32| f64::from(60 * k + 30).to_radians();
        let hexagon: Vec<[f64; 2]> = (0..6).map(|k| [libm::cos(corner(k)), libm::sin(corner(k))]).collect();
        let texture = Texture::new(Planform::Polygon).with_outline(Polygon::new(&hexagon).unwrap()).unwrap();
        let texture = texture.with_arrangement(Arrangement::Hexagonal).unwrap();
        let pattern = Pattern::new(texture, 100e-6, 20e-6, 5e-6).unwrap();
        for outline in [Outline::Disc { diameter_m: 1e-3 }, Outline::Rectangle { length_m: 1e-3, width_m: 0.6e-3 }] {
            for layout in [Layout::new(pattern, outline).unwrap(), Layout::clipped(pattern, outline).unwrap()] {
                let cut_m2 = compared(&layout, None, 2.0) as f64 * 4e-12;
                assert!((cut_m2 / layout.cavity_area_m2() - 1.0).abs() < 2e-3, "{cut_m2}");
            }
        }
    }

    #[test]
    fn a_single_cavity_wider_than_the_raster_is_all_floor() {
        let pattern = Pattern::new(Planform::Groove, 1e-3, 1e-3, 5e-6).unwrap();
        let layout = Layout::clipped(pattern, Outline::Rectangle { length_m: 0.5e-3, width_m: 0.2e-3 }).unwrap();
        assert_eq!(compared(&layout, None, 10.0), 50 * 20);
    }
}
