//! Raster images embedded in an SVG drawing.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::ChartError;
use super::canvas::{PRECISION, failed};

/// Raster image encoded as PNG.
pub(super) struct Raster(Vec<u8>);

impl Raster {
    /// Encodes `wide` x `tall` pixels; `color(across, down)` counts from the top left.
    pub(super) fn new(wide: usize, tall: usize, color: impl Fn(usize, usize) -> [u8; 3]) -> Result<Self, ChartError> {
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
        Ok(Self(file))
    }

    /// Inserts the image into the drawing within `frame` (left, top, right, bottom).
    pub(super) fn onto(&self, svg: String, [left, top, right, bottom]: [f64; 4]) -> Result<String, ChartError> {
        let image = format!(
            "<image x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" preserveAspectRatio=\"none\" \
             style=\"image-rendering:pixelated\" href=\"data:image/png;base64,{}\"/>\n",
            left * PRECISION,
            top * PRECISION,
            (right - left) * PRECISION,
            (bottom - top) * PRECISION,
            STANDARD.encode(&self.0)
        );
        let Some(end) = svg.rfind("</svg>") else {
            return Err(ChartError::Drawing { reason: "the drawing has no end".to_owned() });
        };
        let mut whole = svg;
        whole.insert_str(end, &image);
        Ok(whole)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_come_back_from_the_file() {
        let raster = Raster::new(3, 2, |across, down| [across as u8, down as u8, 7]).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(&raster.0[..])).read_info().unwrap();
        let mut pixels = vec![0; 18];
        let info = reader.next_frame(&mut pixels).unwrap();
        assert_eq!((info.width, info.height), (3, 2));
        assert_eq!(pixels[..6], [0, 0, 7, 1, 0, 7]);
        assert_eq!(pixels[15..], [2, 1, 7]);
    }
}
