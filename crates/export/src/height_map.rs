//! The surface as a picture: 16-bit grey PNG, white at the face, black on the floor.
//!
//! PNG, third edition (W3C): the pixel's size stands in the chunk pHYs, what black and white mean in tEXt.
//! The first row is the one of the largest y. Each pixel is the depth at its middle.

use std::io::{self, Write};

use crate::{ExportError, Heading, Laser, Layout};

/// Most pixels along a side.
pub const MOST_PIXELS: u32 = 32_768;
/// Pixels along the longer side, and across a cavity, where no size is given.
const USUAL_PIXELS: f64 = 4096.0;
const PIXELS_PER_CAVITY: f64 = 16.0;

/// The raster of a height map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeightMap {
    pixel_m: f64,
    size: [u32; 2],
    slope: f64,
}

impl HeightMap {
    /// A raster over the specimen of `layout` with pixels of `pixel_um`: where absent a sixteenth of the
    /// smallest extent of a cavity, and at least a 4096th of the specimen's.
    ///
    /// # Errors
    /// [`ExportError::NoHeightMap`] for fewer pixels than one or more than [`MOST_PIXELS`] along a side.
    pub fn new(layout: &Layout, laser: &Laser, pixel_um: Option<f64>) -> Result<Self, ExportError> {
        let extents_m = layout.outline().extents_m();
        let longer_m = extents_m[0].max(extents_m[1]);
        let usual_m = (longer_m / USUAL_PIXELS).max(layout.pattern().least_extent_m() / PIXELS_PER_CAVITY);
        let pixel_m = pixel_um.map_or(usual_m, |pixel_um| pixel_um * 1e-6);
        let pixels = (longer_m / pixel_m - 1e-6).ceil();
        if !(1.0..=f64::from(MOST_PIXELS)).contains(&pixels) {
            return Err(ExportError::NoHeightMap { pixel_um: pixel_m * 1e6, pixels, most: MOST_PIXELS });
        }
        // At most MOST_PIXELS: the casts are exact.
        let size = extents_m.map(|extent_m| (extent_m / pixel_m - 1e-6).ceil().max(1.0) as u32);
        Ok(Self { pixel_m, size, slope: laser.slope() })
    }

    /// Columns and rows.
    #[must_use]
    pub const fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Side of a pixel, in metres.
    #[must_use]
    pub const fn pixel_m(&self) -> f64 {
        self.pixel_m
    }

    /// Depth at the middle of a pixel over the cavities' depth, 0 to 1; row 0 has the largest y.
    #[must_use]
    pub fn depth(&self, layout: &Layout, column: u32, row: u32) -> f64 {
        let [columns, rows] = self.size.map(f64::from);
        let x_m = (f64::from(column) + 0.5 - columns / 2.0) * self.pixel_m;
        let y_m = (rows / 2.0 - f64::from(row) - 0.5) * self.pixel_m;
        let Some(cavity) = layout.cavity_near([x_m, y_m]) else { return 0.0 };
        let inside_m = cavity.wall_distance_m([x_m, y_m]);
        let slope_m = self.slope * layout.pattern().depth_m();
        if inside_m < 0.0 {
            0.0
        } else if slope_m > 0.0 {
            // The wall falls by d over d tan(taper).
            (inside_m / slope_m).min(1.0)
        } else {
            1.0
        }
    }
}

/// Writes the height map of `layout`: white (65535) is the face, black (0) the cavities' depth.
///
/// # Errors
/// Those of `to`.
pub fn height_map(layout: &Layout, map: &HeightMap, heading: &Heading, to: &mut dyn Write) -> io::Result<()> {
    let [columns, rows] = map.size;
    let mut encoder = png::Encoder::new(to, columns, rows);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Sixteen);
    // Pixels per metre; a whole number by the format.
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
        ("Title", latin(heading.name)),
        ("Description", meaning),
    ] {
        encoder.add_text_chunk(keyword.to_owned(), text).map_err(io::Error::other)?;
    }
    let mut writer = encoder.write_header().map_err(io::Error::other)?;
    let mut stream = writer.stream_writer().map_err(io::Error::other)?;
    let mut line = Vec::with_capacity(2 * columns as usize);
    for row in 0..rows {
        line.clear();
        for column in 0..columns {
            // 0 to 65535: the cast is exact.
            let height = ((1.0 - map.depth(layout, column, row)) * 65_535.0).round() as u16;
            line.extend(height.to_be_bytes());
        }
        stream.write_all(&line)?;
    }
    stream.finish().map_err(io::Error::other)
}

/// What a text chunk may hold: others become question marks.
fn latin(text: &str) -> String {
    text.chars().map(|c| if c.is_ascii_graphic() || c == ' ' { c } else { '?' }).collect()
}
