//! Raster images embedded in an SVG drawing.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::ChartError;

/// Raster image encoded as PNG.
pub(super) struct Raster {
    png: Result<Vec<u8>, String>,
}

impl Raster {
    /// Encodes `wide` x `tall` pixels; `color(across, down)` counts from the top left.
    pub(super) fn new(wide: usize, tall: usize, color: impl Fn(usize, usize) -> [u8; 3]) -> Self {
        let mut bytes = Vec::with_capacity(3 * wide * tall);
        for down in 0..tall {
            for across in 0..wide {
                bytes.extend_from_slice(&color(across, down));
            }
        }
        Self { png: encoded(wide, tall, &bytes) }
    }

    /// Inserts the image into the drawing within `frame` (left, top, right, bottom).
    pub(super) fn onto(&self, svg: String, [left, top, right, bottom]: [f64; 4]) -> Result<String, ChartError> {
        /// Scale of the drawing's view box relative to the page.
        const PRECISION: f64 = super::canvas::PRECISION;
        let png = self.png.as_ref().map_err(|reason| ChartError::Drawing { reason: reason.clone() })?;
        let image = format!(
            "<image x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" preserveAspectRatio=\"none\" \
             style=\"image-rendering:pixelated\" href=\"data:image/png;base64,{}\"/>\n",
            left * PRECISION,
            top * PRECISION,
            (right - left) * PRECISION,
            (bottom - top) * PRECISION,
            STANDARD.encode(png)
        );
        let Some(end) = svg.rfind("</svg>") else {
            return Err(ChartError::Drawing { reason: "the drawing has no end".to_owned() });
        };
        let mut whole = svg;
        whole.insert_str(end, &image);
        Ok(whole)
    }
}

fn encoded(wide: usize, tall: usize, bytes: &[u8]) -> Result<Vec<u8>, String> {
    let size = |pixels: usize| u32::try_from(pixels).map_err(|error| error.to_string());
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, size(wide)?, size(tall)?);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header().map_err(|error| error.to_string())?;
    writer.write_image_data(bytes).map_err(|error| error.to_string())?;
    writer.finish().map_err(|error| error.to_string())?;
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_come_back_from_the_file() {
        let raster = Raster::new(3, 2, |across, down| [across as u8, down as u8, 7]);
        let png = raster.png.unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(&png[..])).read_info().unwrap();
        let mut pixels = vec![0; 18];
        let info = reader.next_frame(&mut pixels).unwrap();
        assert_eq!((info.width, info.height), (3, 2));
        assert_eq!(pixels[..6], [0, 0, 7, 1, 0, 7]);
        assert_eq!(pixels[15..], [2, 1, 7]);
    }
}
