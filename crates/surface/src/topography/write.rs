use std::fmt::Write as _;

use slipgrid_base::units::tidy;

use crate::topography::read::is_square;
use crate::topography::{HeightMap, LengthUnit};

/// Header content of a written map, and the format of its values.
#[derive(Clone, Debug, PartialEq)]
pub struct MatrixStyle {
    /// Name of the channel.
    pub channel: String,
    /// Comment lines without their comment mark; for a synthetic map those of
    /// [`SelfAffine::description`](crate::topography::SelfAffine::description).
    pub comments: Vec<String>,
    /// Unit of the heights.
    pub unit: LengthUnit,
    /// Digits after the decimal point, at most 17. Two digits of a nanometre keep 512 x 512 heights of about a tenth of
    /// a micrometre within 2 MB.
    pub decimals: u8,
}

impl HeightMap {
    /// Writes the map as matrix text with its size and unit in the header, which [`read_map`](crate::topography::read_map) can
    /// read: x runs along a line; missing points are written as NaN.
    pub fn to_matrix_text(&self, style: &MatrixStyle) -> String {
        let mut text = String::with_capacity(self.heights_m().len() * (usize::from(style.decimals) + 6));
        // A line break in a comment or name must not turn its rest into data.
        let line = |text: &str| text.replace(['\n', '\r'], " ");
        text.push_str(&format!("# Channel: {}\n", line(&style.channel)));
        for (key, extent_m) in
            [("Width", self.dx_m() * self.rows() as f64), ("Height", self.dy_m() * self.cols() as f64)]
        {
            text.push_str(&format!("# {key}: {}\n", length(extent_m)));
        }
        // If pixels are oblong, the sides alone do not show whether rows are missing.
        if !is_square(self.dx_m(), self.dy_m()) {
            text.push_str(&format!("# Rows: {}\n", self.cols()));
        }
        text.push_str(&format!("# Value units: {}\n", style.unit));
        for comment in &style.comments {
            text.push_str(&format!("# {}\n", line(comment)));
        }
        let decimals = usize::from(style.decimals.min(17));
        let lines = self.transposed();
        for line in lines.heights_m().chunks_exact(self.rows()) {
            for (i, height) in line.iter().enumerate() {
                if i > 0 {
                    text.push('\t');
                }
                let start = text.len();
                // Writing to a string cannot fail.
                let _ = write!(text, "{:.decimals$}", height * style.unit.per_metre());
                // A value that rounds to zero is written without a minus sign.
                if text[start..].starts_with('-') && !text[start..].contains(|c: char| ('1'..='9').contains(&c)) {
                    text.remove(start);
                }
            }
            text.push('\n');
        }
        text
    }
}

/// Formats a length in millimetres, or in metres if millimetres would lose a digit.
fn length(length_m: f64) -> String {
    let length_mm = tidy(length_m * 1e3);
    if LengthUnit::Millimetre.to_metres(length_mm) == length_m {
        format!("{length_mm} mm")
    } else {
        format!("{length_m:e} m")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topography::{MapFormat, ReadOptions, SelfAffine, read_map};
    use slipgrid_base::monitor::Unwatched;

    #[test]
    fn the_synthetic_map_reads_back_from_two_megabytes() {
        let parameters = SelfAffine::STAND_IN;
        let map = parameters.map().unwrap();
        let style = MatrixStyle {
            channel: "altitude".to_owned(),
            comments: parameters.description().to_vec(),
            unit: LengthUnit::Nanometre,
            decimals: 2,
        };
        let text = map.to_matrix_text(&style);
        assert!(text.len() < 2_100_000, "{} bytes", text.len());
        assert!(text.starts_with("# Channel: altitude\n# Width: 1 mm\n# Height: 1 mm\n# Value units: nm\n# synthetic"));
        assert!(text.contains("512 x 512 pixels, side 1 mm, Hurst exponent 0.8, waves per side 4 to 64, Sa 0.158 um"));
        let read = read_map(text.as_bytes(), &ReadOptions::default()).unwrap();
        assert_eq!(read.format, MapFormat::Matrix);
        assert!(read.is_synthetic());
        assert_eq!((read.map.rows(), read.map.cols()), (512, 512));
        assert_eq!((read.map.dx_m(), read.map.dy_m()), (map.dx_m(), map.dy_m()));
        for (a, b) in read.map.heights_m().iter().zip(map.heights_m()) {
            assert!((a - b).abs() <= 0.005_001e-9);
        }
        assert!((read.map.rms_slope_spectral(&Unwatched).unwrap() - 0.013728).abs() < 5e-7);
    }

    #[test]
    fn awkward_sizes_names_and_zeros() {
        let map = HeightMap::new(3, 2, 1e-6, 1e-6 / 3.0, vec![0.0, 1e-9, -1e-12, -2e-9, f64::NAN, 0.0]).unwrap();
        let style = MatrixStyle {
            channel: "two\nlines".to_owned(),
            comments: vec!["a\r\n1 2 3".to_owned()],
            unit: LengthUnit::Micrometre,
            decimals: 4,
        };
        let text = map.to_matrix_text(&style);
        assert!(
            text.contains("\n# Rows: 2\n") && text.ends_with("0.0000\t0.0000\tNaN\n0.0010\t-0.0020\t0.0000\n"),
            "{text}"
        );
        let read = read_map(text.as_bytes(), &ReadOptions::default()).unwrap().map;
        assert_eq!((read.missing(), read.dx_m(), read.dy_m()), (1, map.dx_m(), map.dy_m()));
    }
}
