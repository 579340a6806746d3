//! Damaged and hostile files of every format are read or refused without panic and without much memory.

#![allow(clippy::unwrap_used, reason = "a test that unwraps in vain fails, as it should")]

use std::path::Path;

use peak_alloc::PeakAlloc;
use slipgrid_surface::topography::{Crop, Decimation, DecimationMethod, LengthUnit, ReadError, ReadOptions, read_map};

/// Counts allocated memory. This file holds a single test because parallel test threads would share the count.
#[global_allocator]
static PEAK: PeakAlloc = PeakAlloc;

/// Largest memory for reading a file of a few kilobytes, whatever sizes it states: pieces of numbers, the state of a
/// decompressor, and the unpacked content of a few kilobytes.
const MAX_BYTES: usize = 8 << 20;
/// Number of damaged files per sample.
const ROUNDS: usize = 3000;

/// A small pseudorandom generator with a fixed seed.
struct Random(u64);

impl Random {
    fn below(&mut self, limit: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as usize) % limit
    }
}

/// Numbers that are invalid in headers.
const NUMBERS: [u64; 10] = [0, 1, 0x7f, 0xff, 0x7fff, 0xffff, 0x7fff_ffff, 0xffff_ffff, u64::MAX >> 1, u64::MAX];
const WORDS: [&[u8]; 14] = [
    b"99999999999",
    b"-1",
    b"0",
    b"1e308",
    b"nan",
    b"NaN",
    b"inf",
    b"1e-320",
    b"",
    b"*\n",
    b"\n",
    b"BAD",
    b"<a>",
    b"&x;",
];

/// The outcome of `work`, and the memory that it takes at most.
fn measured<T>(work: impl FnOnce() -> T) -> (T, usize) {
    let before = PEAK.current_usage();
    PEAK.reset_peak_usage();
    let outcome = work();
    (outcome, PEAK.peak_usage().saturating_sub(before))
}

fn damage(bytes: &mut Vec<u8>, random: &mut Random) {
    let at = random.below(bytes.len().max(1)).min(bytes.len().saturating_sub(1));
    // Damage to headers is most likely to have an effect.
    let at = if random.below(2) == 0 { at % 700 } else { at }.min(bytes.len().saturating_sub(1));
    match random.below(7) {
        0 => bytes.truncate(at),
        1 => bytes[at] ^= 1 << random.below(8),
        2 => bytes[at] = random.below(256) as u8,
        3 => {
            let number = NUMBERS[random.below(NUMBERS.len())].to_le_bytes();
            let width = 1 << random.below(4);
            for (target, source) in bytes[at..].iter_mut().zip(&number[..width]) {
                *target = *source;
            }
        }
        4 => {
            // Replaces a run of digits, as in a header with a wrong number.
            let Some(start) = bytes[at..].iter().position(u8::is_ascii_digit).map(|offset| at + offset) else { return };
            let end = bytes[start..].iter().position(|b| !b.is_ascii_digit()).map_or(bytes.len(), |n| start + n);
            bytes.splice(start..end, WORDS[random.below(WORDS.len())].iter().copied());
        }
        5 => {
            let length = random.below(64).min(bytes.len() - at);
            bytes.drain(at..at + length);
        }
        _ => {
            let length = random.below(200).min(bytes.len() - at);
            let copy = bytes[at..at + length].to_vec();
            let to = random.below(bytes.len());
            bytes.splice(to..to, copy);
        }
    }
}

fn samples() -> Vec<(String, Vec<u8>)> {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/topography/reference"));
    let mut samples: Vec<(String, Vec<u8>)> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap())
        .filter(|entry| {
            let name = entry.file_name().to_string_lossy().into_owned();
            name != "iso.npy"
                && [".sdf", ".sur", ".x3p", ".gsf", ".npy", ".asc", ".xyz"].iter().any(|ext| name.ends_with(ext))
        })
        .map(|entry| (entry.file_name().to_string_lossy().into_owned(), std::fs::read(entry.path()).unwrap()))
        .collect();
    samples.sort();
    let text = |name: &str, text: &str| (name.to_owned(), text.as_bytes().to_vec());
    samples.push(text(
        "matrix",
        "# Channel: Z\n# Width: 3 um\n# Height: 4 um\n# Value units: nm\n1\t2\tNaN\n4\tBAD\t---\n7\t8\t9\n",
    ));
    samples.push(text("points", "x_um;y_um;z_nm\n0;0;1\n0;1;2\n1;0;3\n1;1;BAD\n2;0;5\n2;1;6\n"));
    samples.push(text("table", "\"1\",\"2\",\"3\",\"4\"\n5,6,7,8\n1,,3,4\n"));
    samples
}

#[test]
fn damaged_files_are_read_or_refused_within_bounded_memory() {
    let given = ReadOptions {
        pixel_m: Some([1e-6, 2e-6]),
        height_unit: Some(LengthUnit::Micrometre),
        lateral_unit: Some(LengthUnit::Micrometre),
        ..ReadOptions::default()
    };
    let part = ReadOptions {
        crop: Some(Crop { first_row: 1, first_col: 0, rows: 4, cols: 3 }),
        decimation: Some(Decimation { factor: 2, method: DecimationMethod::Mean }),
        ..given
    };
    let mut random = Random(71);
    let (mut read, mut refused, mut most) = (0, 0, 0);
    for (name, whole) in samples() {
        assert!(read_map(&whole[..], &given).is_ok(), "{name} itself");
        for _ in 0..ROUNDS {
            let mut bytes = whole.clone();
            for _ in 0..=random.below(4) {
                if !bytes.is_empty() {
                    damage(&mut bytes, &mut random);
                }
            }
            for options in [ReadOptions::default(), given, part] {
                let (outcome, used) = measured(|| read_map(&bytes[..], &options));
                assert!(used < MAX_BYTES, "{name}: {used} bytes for {:?}", outcome.map(|read| read.map.rows()));
                most = most.max(used);
                match outcome {
                    Ok(found) => {
                        let map = found.map;
                        assert!(map.rows() >= 2 && map.cols() >= 2 && map.missing() < map.rows() * map.cols());
                        read += 1;
                    }
                    Err(error) => {
                        assert!(!error.to_string().is_empty() && error.to_string().len() < 500, "{error}");
                        refused += 1;
                    }
                }
            }
        }
    }
    // Some damaged files are refused and some are read; the memory used comes close to the bound.
    assert!(read > 5_000 && refused > 20_000, "{read} read, {refused} refused");
    assert!(most > MAX_BYTES / 100, "{most} bytes at most");
    no_height_at_all();
    claims_are_never_reserved();
    small_files_never_swell();
}

/// Largest memory per byte of a packed file: 8 heights of 8 bytes, three times while they grow.
const MAX_PER_BYTE: usize = 3 * 64;

/// Files that pack zeros, with correct or wrong lengths, take no more memory than measured heights of their size.
fn small_files_never_swell() {
    let refused = |name: &str, bytes: &[u8]| {
        let (read, used) = measured(|| read_map(bytes, &ReadOptions::default()));
        let error = read.unwrap_err();
        assert!(used < MAX_BYTES.max(MAX_PER_BYTE * bytes.len()), "{name}: {used} bytes of {}", bytes.len());
        assert!(error.to_string().contains("unpacks to"), "{name}: {error}");
    };
    // 9 million heights of 2 bytes in 17 kB, 25 million in 49 kB.
    for side in [3000_u32, 5000] {
        let packed = zeros_packed(2 * u64::from(side * side));
        for claimed in [packed.len() as u32, u32::MAX / 2] {
            let mut bytes = sur_header(side);
            for length in [1, 2 * side * side, claimed] {
                bytes.extend_from_slice(&length.to_le_bytes());
            }
            bytes.extend_from_slice(&packed);
            refused("sur", &bytes);
        }
    }
    // 4 and 33 million doubles; an index of 16 million spaces.
    for side in [2000_u64, 5792] {
        let index = x3p_index(side);
        refused("x3p", &x3p(&index, 8 * side * side));
    }
    refused("index", &x3p(&(x3p_index(2) + &" ".repeat(15 << 20)), 32));
}

/// `count` zeros in a zlib stream, packed piece by piece.
fn zeros_packed(count: u64) -> Vec<u8> {
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
    std::io::copy(&mut std::io::Read::take(std::io::repeat(0), count), &mut encoder).unwrap();
    encoder.finish().unwrap()
}

/// The header of a compressed `.sur` file of 16-bit heights on `side` x `side` points.
fn sur_header(side: u32) -> Vec<u8> {
    let mut bytes = vec![0; 512];
    let mut put = |at: usize, value: &[u8]| bytes[at..at + value.len()].copy_from_slice(value);
    put(0, b"DSCOMPRESSED");
    put(16, &1_u16.to_le_bytes());
    put(18, &2_u16.to_le_bytes());
    put(98, &16_u16.to_le_bytes());
    for (at, value) in [(108, side), (112, side), (116, side * side)] {
        put(at, &value.to_le_bytes());
    }
    for at in [120, 124, 128] {
        put(at, &1_f32.to_le_bytes());
    }
    for at in [180, 196, 212] {
        put(at, b"um");
    }
    bytes
}

fn x3p_index(side: u64) -> String {
    format!(
        "<p><Record1><FeatureType>SUR</FeatureType><Axes><CX><AxisType>I</AxisType><Increment>1e-6</Increment></CX><CY>\
         <AxisType>I</AxisType><Increment>1e-6</Increment></CY><CZ><DataType>D</DataType></CZ></Axes></Record1><Record3>\
         <MatrixDimension><SizeX>{side}</SizeX><SizeY>{side}</SizeY><SizeZ>1</SizeZ></MatrixDimension><DataLink>\
         <PointDataLink>data.bin</PointDataLink></DataLink></Record3></p>"
    )
}

fn x3p(index: &str, zeros: u64) -> Vec<u8> {
    let mut writer = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    let options = zip::write::SimpleFileOptions::default().compression_method(zip::CompressionMethod::Deflated);
    writer.start_file("main.xml", options).unwrap();
    std::io::Write::write_all(&mut writer, index.as_bytes()).unwrap();
    writer.start_file("data.bin", options).unwrap();
    std::io::copy(&mut std::io::Read::take(std::io::repeat(0), zeros), &mut writer).unwrap();
    writer.finish().unwrap().into_inner()
}

/// NaN everywhere.
fn no_height_at_all() {
    let mut bytes = b"Gwyddion Simple Field 1.0\nXRes = 40\nYRes = 50\nZUnits = m\nXYUnits = m\n".to_vec();
    bytes.resize(bytes.len() + 4 - bytes.len() % 4, 0);
    bytes.extend((0..2000).flat_map(|_| f32::NAN.to_le_bytes()));
    let error = read_map(&bytes[..], &ReadOptions::default()).unwrap_err();
    assert!(error.to_string().contains("all 2000 points are missing"), "{error}");
}

/// A header may state as many points as a map can have; memory is allocated only for data that arrive.
fn claims_are_never_reserved() {
    let header = "{'descr': '<f8', 'fortran_order': False, 'shape': (5000, 5000)}";
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend_from_slice(&(header.len() as u16).to_le_bytes());
    bytes.extend_from_slice(header.as_bytes());
    bytes.extend_from_slice(&[0; 800]);
    let given =
        ReadOptions { pixel_m: Some([1e-6; 2]), height_unit: Some(LengthUnit::Micrometre), ..ReadOptions::default() };
    let (read, used) = measured(|| read_map(&bytes[..], &given));
    let error = read.unwrap_err();
    assert!(matches!(error, ReadError::Ended { expected: 25_000_000, found: 100, .. }), "{error}");
    assert!(used < 1 << 20);
    // Twenty-five million points decimated by 10 take the memory of a quarter of a million.
    let header_bytes = bytes.len() - 800;
    let endless = std::io::BufReader::new(std::io::Read::chain(
        &bytes[..header_bytes],
        std::io::Read::take(std::io::repeat(0), 200_000_000),
    ));
    let decimation = Some(Decimation { factor: 10, method: DecimationMethod::Mean });
    let (read, used) = measured(|| read_map(endless, &ReadOptions { decimation, ..given }));
    let map = read.unwrap().map;
    assert_eq!((map.rows(), map.cols()), (500, 500));
    assert!((map.dx_m() - 1e-5).abs() < 1e-15);
    assert!(used < 8 << 20, "{used} bytes");
}
