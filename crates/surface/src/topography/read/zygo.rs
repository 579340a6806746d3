//! Text exports of Zygo software: `Zygo XYZ Data File`, whose point coordinates are pixel indices, and `Zygo ASCII Data
//! File`, whose heights are whole numbers, ten per line. Both begin with a header of numbers identified by their
//! positions, which ends with a line `#`.

use std::io::BufRead;

use super::entries::Entry;
use super::lines::{Lines, not_a_number, number};
use super::overridden::StatedValues;
use super::scale::Scale;
use super::window::{Window, window_of};
use super::xyz::XyzReader;
use super::{MapFormat, ReadMap, ReadOptions, keep_comment};
use crate::topography::{LengthUnit, MapOption, NotGiven, ReadError};

/// Beginnings of files in the two formats.
pub(super) const MAGIC: [&str; 2] = ["Zygo XYZ Data File", "Zygo ASCII Data File"];
const FORMAT: &str = "Zygo text";
/// Largest number of lines above the first `#`; usual writers have 13 or 14.
const MAX_HEADER_LINES: usize = 40;
/// Phase steps per fringe, for each phase resolution.
const PHASE_STEPS: [f64; 3] = [4096.0, 32768.0, 131_072.0];
/// Phases from this value on mark points without data.
const MIN_INVALID_PHASE: f64 = 2_147_483_640.0;

/// Lines above the data.
struct Header {
    lines: Vec<String>,
    /// Index of the line with the size of the phase data, the first line with four numbers only; the number of lines
    /// above it depends on the writer.
    size: usize,
    /// Index of the line with scale factor, wavelength and camera resolution: the next line with at least seven
    /// numbers.
    optics: usize,
}

impl Header {
    fn read(lines: &mut Lines<impl BufRead>) -> Result<Self, ReadError> {
        let mut header = Vec::new();
        while header.len() < MAX_HEADER_LINES {
            match lines.next()? {
                Some("#") => return Self::of(header),
                Some(text) => header.push(text.to_owned()),
                None => break,
            }
        }
        Err(Entry::new(FORMAT, "number of header lines", &header.len().to_string())
            .refused("at most 40, then a line with #"))
    }

    fn of(lines: Vec<String>) -> Result<Self, ReadError> {
        let is_numbers = |line: &str| line.split_whitespace().all(|word| number(word).is_some());
        let counts: Vec<usize> =
            lines.iter().map(|line| if is_numbers(line) { line.split_whitespace().count() } else { 0 }).collect();
        let size = counts.iter().position(|count| *count == 4);
        let optics = size.and_then(|size| (size + 1..counts.len()).find(|line| counts[*line] >= 7));
        let expected = "a line of four numbers and one of seven or more above the line with #";
        let (size, optics) = size.zip(optics).ok_or_else(|| Entry::new(FORMAT, "header", "").refused(expected))?;
        Ok(Self { lines, size, optics })
    }

    /// The number at `line` and `place` in the line, both counted from 0; refused unless `accepts` it.
    fn number(
        &self,
        field: &'static str,
        [line, place]: [usize; 2],
        accepts: fn(f64) -> bool,
    ) -> Result<f64, ReadError> {
        let word = self.lines.get(line).and_then(|line| line.split_whitespace().nth(place)).unwrap_or_default();
        Entry::new(FORMAT, field, word).number(accepts, "a number that the format allows, at its place")
    }

    fn count(&self, field: &'static str, place: [usize; 2]) -> Result<u64, ReadError> {
        let is_count = |number: f64| (0.0..1e9).contains(&number) && number.fract() == 0.0;
        self.number(field, place, is_count).map(|number| number as u64)
    }

    /// Number of points on a line, and of lines.
    fn size(&self) -> Result<[u64; 2], ReadError> {
        Ok([
            self.count("width of the phase data", [self.size, 2])?,
            self.count("height of the phase data", [self.size, 3])?,
        ])
    }

    /// Pixel side in metres; `None` if the instrument was not calibrated.
    fn pixel_m(&self) -> Result<Option<f64>, ReadError> {
        let pixel_m = self.number("camera resolution", [self.optics, 6], |length| length >= 0.0)?;
        Ok(Some(pixel_m).filter(|pixel_m| *pixel_m > 0.0))
    }

    /// Length in metres that a phase of 1 represents.
    fn phase_m(&self) -> Result<f64, ReadError> {
        let positive = |number| number > 0.0;
        let scale_factor = self.number("interferometric scale factor", [self.optics, 1], positive)?;
        let wavelength_m = self.number("wavelength", [self.optics, 2], positive)?;
        let obliquity = self.number("obliquity factor", [self.optics, 4], positive)?;
        let resolution =
            self.number("phase resolution", [self.optics + 3, 0], |number| [0.0, 1.0, 2.0].contains(&number))?;
        Ok(scale_factor * wavelength_m * obliquity / PHASE_STEPS[resolution as usize])
    }
}

pub(super) fn read(source: impl BufRead, options: &ReadOptions) -> Result<ReadMap, ReadError> {
    let mut lines = Lines::new(source);
    let header = Header::read(&mut lines)?;
    let mut comments = Vec::new();
    keep_comment(&mut comments, header.lines.first().map_or("", |line| line));
    let own_pixel_m = header.pixel_m()?;
    let Some(pixel_m) = options.pixel_m.or(own_pixel_m.map(|pixel_m| [pixel_m; 2])) else {
        let expected = "a camera resolution in the file, or a pixel size by option";
        let missing = vec![NotGiven { what: "pixel size", expected, option: MapOption::Pixel }];
        return Err(ReadError::NotGiven { missing });
    };
    let mut notes = Vec::new();
    let is_points = header.lines.first().is_some_and(|line| line.starts_with(MAGIC[0]));
    let (map, whole, height_unit) = if is_points {
        let unit = options.height_unit.unwrap_or(LengthUnit::Micrometre);
        if options.height_unit.is_none() {
            let said = "the file does not state the unit of its heights: um is taken, as Zygo's programs write; --height-unit or height_unit changes it";
            notes.push(said.to_owned());
        }
        let points = points(&mut lines, header.size()?)?;
        let lateral = pixel_m.map(|pixel_m| Scale::new(pixel_m, LengthUnit::Metre));
        let (map, whole) = window_of(points.grid(unit.into(), lateral)?, options.crop, options.decimation)?;
        (map, whole, None)
    } else {
        let own = Scale::new(header.phase_m()?, LengthUnit::Metre);
        let window = phases(&mut lines, &header, options)?;
        let scale = options.height_unit.map_or(own, Scale::from);
        let (map, whole) = window.finish_lines([pixel_m[1], pixel_m[0]], |phase| scale.to_metres(phase))?;
        (map, whole, Some(own))
    };
    let stated = StatedValues { pixel_m: [own_pixel_m; 2], height_unit, lateral_unit: None };
    notes.extend(stated.notes(options, MapFormat::Matrix));
    let format = if is_points { MapFormat::Xyz } else { MapFormat::Matrix };
    Ok(ReadMap { map, whole, format, comments, notes })
}

/// Reads the points up to the terminating `#`, or all that the header announces.
fn points(lines: &mut Lines<impl BufRead>, [width, height]: [u64; 2]) -> Result<XyzReader, ReadError> {
    let (mut points, mut found, expected) = (XyzReader::default(), 0, width * height);
    loop {
        let line = lines.line() + 1;
        match lines.next()? {
            Some("#") => return Ok(points),
            Some("") => {}
            Some(text) => {
                points.push(&text.replace("No Data", "NaN"), line)?;
                found += 1;
            }
            None if found >= expected => return Ok(points),
            None => return Err(ReadError::Ended { format: FORMAT, what: "points", expected, found }),
        }
    }
}

/// Reads the phases, which follow the intensities if there are any; each is a block of numbers terminated by `#`.
fn phases(lines: &mut Lines<impl BufRead>, header: &Header, options: &ReadOptions) -> Result<Window, ReadError> {
    let [width, height] = header.size()?;
    let window = Window::new(Some(height), width, options.crop, options.decimation)?;
    let above = header.size.saturating_sub(1);
    let intensities = [[above, 2], [above, 3]].map(|place| header.count("size of the intensity data", place));
    if let [Ok(1..), Ok(1..)] = intensities {
        let mut is_begun = false;
        while let Some(text) = lines.next()? {
            match text {
                "#" if is_begun => break,
                "#" | "" => {}
                _ => is_begun = true,
            }
        }
    }
    fill(lines, window, width * height)
}

/// Fills the window with the numbers of the next block, `expected` of them.
fn fill(lines: &mut Lines<impl BufRead>, mut window: Window, expected: u64) -> Result<Window, ReadError> {
    let (mut found, mut phases) = (0, Vec::new());
    while found < expected && !window.is_full() {
        let line = lines.line() + 1;
        let Some(text) = lines.next()?.filter(|text| *text != "#" || found == 0) else {
            return Err(ReadError::Ended { format: FORMAT, what: "phases", expected, found });
        };
        phases.clear();
        for (place, word) in text.split_whitespace().enumerate().filter(|(_, word)| *word != "#") {
            let phase = number(word).ok_or_else(|| not_a_number(line, place, word, "a phase"))?;
            phases.push(if phase < MIN_INVALID_PHASE { phase } else { f64::NAN });
        }
        phases.truncate(usize::try_from(expected - found).unwrap_or(usize::MAX));
        found += phases.len() as u64;
        window.push(&phases)?;
    }
    Ok(window)
}

#[cfg(test)]
mod tests {
    use super::super::plainly::{check, read, refused};
    use crate::topography::{Crop, MapFormat, ReadOptions, read_map};

    /// A header for 3 x 2 points on pixels of 2 um.
    fn header(magic: &str, intensities: &str) -> String {
        format!(
            "{magic} - Format 1\n1 8 3 5 \"Mon Mar 11 10:12:30 2024\"\n0 0 {intensities} 255\n10 20 3 2\n\"comment\"\n\"\"\n\"\"\n\
             0 0.5 6.328e-007 0 1 0 2.0e-006 1710000000\n3 2 0 0 0 0 \"\"\n0 0 0 0 0 0 0 0 0 0\n1 1 20 2 0 0 0 0 0\n0 \"\"\n1 0\n\"\"\n#\n"
        )
    }

    const POINTS: &str = "10 20 1\n11 20 2\n12 20 No Data\n10 21 4\n11 21 5\n12 21 6\n";

    #[test]
    fn points_count_pixels_and_heights_are_micrometres() {
        let text = header("Zygo XYZ Data File", "0 0 0") + POINTS + "#\n";
        let heights_m = [1e-6, 4e-6, 2e-6, 5e-6, f64::NAN, 6e-6];
        let found = check(text.as_bytes(), MapFormat::Xyz, [2e-6; 2], heights_m, f64::MIN_POSITIVE);
        assert!(found.notes.len() == 1 && found.notes[0].contains("um is taken"), "{:?}", found.notes);
        let given = ReadOptions {
            pixel_m: Some([3e-6, 4e-6]),
            height_unit: Some(crate::topography::LengthUnit::Nanometre),
            ..ReadOptions::default()
        };
        let given = read_map(text.as_bytes(), &given).unwrap();
        assert_eq!((given.map.dx_m(), given.map.dy_m(), given.map.heights_m()[0]), (3e-6, 4e-6, 1e-9));
        assert!(given.notes[0].starts_with("pixels of 3 x 4 um are taken"), "{:?}", given.notes);
        // All points without the terminating mark are accepted, fewer are not.
        read(header("Zygo XYZ Data File", "0 0 0") + POINTS);
        let cut = header("Zygo XYZ Data File", "0 0 0") + &POINTS[..POINTS.len() - 8];
        assert!(refused(&cut).contains("the points end after 5 of 6"), "{}", refused(&cut));
    }

    #[test]
    fn phases_are_lengths_by_wavelength_and_resolution_behind_intensities_or_without() {
        let phases = "32768 -32768 2147483640 0\n16384 65536\n#\n";
        for (intensities, text) in [
            ("0 0 0", phases.to_owned()),
            ("0 0 0", format!("#\n{phases}")),
            ("2 2 1", format!("7 8\n9 10\n#\n{phases}")),
        ] {
            let text = header("Zygo ASCII Data File", intensities) + &text;
            let heights_m = [0.5, 0.0, -0.5, 0.25, f64::NAN, 1.0].map(|waves| waves * 632.8e-9);
            check(text.as_bytes(), MapFormat::Matrix, [2e-6; 2], heights_m, 1e-18);
            let crop = Some(Crop { first_row: 0, first_col: 1, rows: 2, cols: 2 });
            let part = read_map(text.as_bytes(), &ReadOptions { crop, ..ReadOptions::default() }).unwrap().map;
            assert_eq!((part.rows(), part.cols(), part.heights_m()[3]), (2, 2, 632.8e-9));
        }
        let text = header("Zygo ASCII Data File", "0 0 0");
        assert!(refused(text.clone() + "1 2 3 4\n#\n").contains("the phases end after 4 of 6"));
        assert!(refused(text.clone() + "1 2 x\n").contains("column 3: \"x\""));
        assert!(refused(text.replace("\n1 1 20", "\n7 1 20")).contains("phase resolution is \"7\""));
        assert!(refused(text.replace("2.0e-006", "0")).contains("pixel size"));
        assert!(refused("Zygo ASCII Data File - Format 2\n1 2\n#\n").contains("a line of four numbers"));
        assert!(refused("Zygo ASCII Data File - Format 2\n1 2\n").contains("number of header lines is \"2\""));
    }
}
