//! Maps with the lengths that a file states, and notes on options that replace these or have no meaning for its format.

use super::scale::Scale;
use super::window::Window;
use super::{MapFormat, ReadMap, ReadOptions};
use crate::topography::{LengthUnit, ReadError};

/// Relative difference up to which a given pixel size counts as that of the file: programs count distances between
/// pixels, or round the sides.
const SAME_PIXEL: f64 = 0.01;

/// Values stated by a file.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct StatedValues {
    /// Pixel sides along x (between the points of a line) and along y (between lines), in metres.
    pub(super) pixel_m: [Option<f64>; 2],
    /// Unit of heights.
    pub(super) height_unit: Option<Scale>,
    /// Unit of x and y, if another unit would change the map.
    pub(super) lateral_unit: Option<Scale>,
}

/// Lengths stated by a file of lines of heights.
pub(super) struct Lengths {
    /// Pixel sides along x and along y, in `lateral_unit`.
    pub(super) steps: [f64; 2],
    pub(super) lateral_unit: Option<LengthUnit>,
    pub(super) height_unit: Option<LengthUnit>,
}

impl Lengths {
    /// Lengths in metres, with pixel sides `steps` along x and y.
    pub(super) fn metres(steps: [f64; 2]) -> Self {
        Self { steps, lateral_unit: Some(LengthUnit::Metre), height_unit: Some(LengthUnit::Metre) }
    }

    /// The map of the heights in `window`, which `height` converts to the unit of heights; `options` replace what the
    /// file states. Units that neither gives must have been refused if they are needed.
    pub(super) fn map(
        self,
        window: Window,
        height: impl Fn(f64) -> f64,
        options: &ReadOptions,
        format: MapFormat,
        comments: Vec<String>,
    ) -> Result<ReadMap, ReadError> {
        let Self { steps, lateral_unit, height_unit } = self;
        let stated = StatedValues {
            pixel_m: steps.map(|step| Some(lateral_unit?.to_metres(step))),
            height_unit: height_unit.map(Scale::from),
            lateral_unit: lateral_unit.map(Scale::from),
        };
        let lateral = options.lateral_unit.or(lateral_unit).unwrap_or(LengthUnit::Metre);
        let vertical = options.height_unit.or(height_unit).unwrap_or(LengthUnit::Metre);
        let [x, y] = steps.map(|step| lateral.to_metres(step));
        let to_metres = |value| vertical.to_metres(height(value));
        let (map, whole) = window.finish_lines(options.grid_m().unwrap_or([y, x]), to_metres)?;
        Ok(ReadMap { map, whole, format, comments, notes: stated.notes(options, format) })
    }
}

impl StatedValues {
    /// Notes on `options` that differ from the values that the file states, one sentence each.
    pub(super) fn notes(&self, options: &ReadOptions, format: MapFormat) -> Vec<String> {
        // Rounded to a picometre, which hides the rounding of the file's sides divided by the number of pixels.
        let um = |side_m: f64| (1e12 * side_m).round() / 1e6;
        let pixel = options.pixel_m.and_then(|given_m| {
            if format == MapFormat::Xyz {
                let told =
                    "--pixel-um or pixel_um is not used: the points x y z of the file say how far apart they are";
                return Some(told.to_owned());
            }
            let [own_x_m, own_y_m] = self.pixel_m;
            let differs =
                |own_m: Option<f64>, given_m: f64| own_m.is_some_and(|own| (given_m / own - 1.0).abs() > SAME_PIXEL);
            if !differs(own_x_m, given_m[0]) && !differs(own_y_m, given_m[1]) {
                return None;
            }
            let own = match (own_x_m, own_y_m) {
                (Some(x_m), Some(y_m)) => format!("{} x {} um", um(x_m), um(y_m)),
                (own_x_m, own_y_m) => format!("{} um", own_x_m.or(own_y_m).map_or(f64::NAN, um)),
            };
            let [x, y] = given_m.map(um);
            Some(format!("pixels of {x} x {y} um are taken, as given by option, and not those of the file, {own}"))
        });
        let unit = |what: &str, given: Option<LengthUnit>, own: Option<Scale>| {
            let (given, own) = given.zip(own).filter(|(given, own)| Scale::from(*given) != *own)?;
            Some(format!("the unit of {what} is {given}, as given by option, and not {own}, as the file says"))
        };
        let unused = match format {
            MapFormat::Matrix | MapFormat::Npy => Some("a matrix has no numbers x and y"),
            MapFormat::Xyz => None,
            _ => options.pixel_m.map(|_| "the sides of the pixels are given by option"),
        };
        let lateral = match (options.lateral_unit, unused) {
            (Some(_), Some(why)) => Some(format!("--lateral-unit or lateral_unit is not used: {why}")),
            (given, _) => unit("x and y", given, self.lateral_unit),
        };
        let height = unit("heights", options.height_unit, self.height_unit);
        pixel.into_iter().chain(lateral).chain(height).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topography::read_map;

    const MATRIX: &str = "# Width: 8 um\n# Height: 4 um\n# Value units: nm\n1 2 3 4\n5 6 7 8\n";
    const POINTS: &str = "x_um,y_um,z_nm\n0,0,1\n0,1,2\n1,0,3\n1,1,4\n";

    fn notes(text: &str, options: &ReadOptions) -> Vec<String> {
        read_map(text.as_bytes(), options).unwrap().notes
    }

    #[test]
    fn what_goes_before_the_file_is_told() {
        let pixel =
            |pixel_um: [f64; 2]| ReadOptions { pixel_m: Some(pixel_um.map(|um| um * 1e-6)), ..ReadOptions::default() };
        let said = notes(MATRIX, &pixel([5.0, 5.0]));
        assert_eq!(said, ["pixels of 5 x 5 um are taken, as given by option, and not those of the file, 2 x 2 um"]);
        assert_eq!(notes(MATRIX, &pixel([2.0, 2.0])), [""; 0]);
        assert_eq!(notes(MATRIX, &pixel([2.0, 3.0])).len(), 1);
        // For a part of the map the lines of the file are not counted.
        let crop = Some(crate::topography::Crop { first_row: 0, first_col: 0, rows: 2, cols: 2 });
        let text = format!("{MATRIX}9 9 9 9\n");
        let said = notes(&text, &ReadOptions { crop, ..pixel([5.0, 5.0]) });
        assert_eq!(said, ["pixels of 5 x 5 um are taken, as given by option, and not those of the file, 2 um"]);
        let unit = |height_unit| ReadOptions { height_unit: Some(height_unit), ..ReadOptions::default() };
        let said = notes(MATRIX, &unit(LengthUnit::Micrometre));
        assert_eq!(said, ["the unit of heights is um, as given by option, and not nm, as the file says"]);
        assert_eq!(notes(MATRIX, &unit(LengthUnit::Nanometre)), [""; 0]);
    }

    #[test]
    fn options_that_mean_nothing_for_a_format_are_told() {
        let pixel = ReadOptions { pixel_m: Some([5e-6; 2]), ..ReadOptions::default() };
        let lateral = ReadOptions { lateral_unit: Some(LengthUnit::Millimetre), ..ReadOptions::default() };
        assert!(notes(POINTS, &pixel)[0].starts_with("--pixel-um or pixel_um is not used"));
        assert!(notes(MATRIX, &lateral)[0].starts_with("--lateral-unit or lateral_unit is not used"));
        assert_eq!(
            notes(POINTS, &lateral),
            ["the unit of x and y is mm, as given by option, and not um, as the file says"]
        );
        assert_eq!(
            [notes(POINTS, &ReadOptions::default()), notes(MATRIX, &ReadOptions::default())],
            [[""; 0], [""; 0]]
        );
    }
}
