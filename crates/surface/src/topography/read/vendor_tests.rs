//! Texts as written by the software of instruments, in several languages.

use super::{GIVEN, plainly};
use crate::topography::{LengthUnit, MapFormat, ReadOptions, read_map};

/// Rows of four heights that differ, so that their order shows.
const ROWS: [[f64; 4]; 3] = [[0.1, 0.25, 0.3, 0.4], [1.5, 2.0, 2.5, 3.0], [-1.0, -2.0, 0.0, 7.0]];

fn rows(mark: &str, quote: &str, scale: f64) -> String {
    let field = |height: &f64| format!("{quote}{}{quote}", height * scale);
    ROWS.iter().map(|row| row.iter().map(field).collect::<Vec<_>>().join(mark) + "\r\n").collect()
}

/// The map of `ROWS` in micrometres, read from `bytes` without any option, and its notes.
fn check(bytes: &[u8], [dx_m, dy_m]: [f64; 2]) -> Vec<String> {
    let text = String::from_utf8_lossy(bytes).into_owned();
    let read = read_map(bytes, &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}: {text}"));
    let map = &read.map;
    assert_eq!((read.format, map.rows(), map.cols()), (MapFormat::Matrix, 4, 3));
    assert!((map.dx_m() / dx_m - 1.0).abs() < 1e-9 && (map.dy_m() / dy_m - 1.0).abs() < 1e-9, "{map:?}");
    for (found, expected) in map.transposed().heights_m().iter().zip(ROWS.as_flattened()) {
        assert!((found * 1e6 - expected).abs() < 1e-9, "{found} {expected}");
    }
    read.notes
}

/// A Keyence export, with the words for pixel, width, height and unit given, and fields separated by `mark`.
fn keyence(mark: &str, [pixel, width, height, unit]: [&str; 4], micro: &str) -> String {
    let line = |fields: &[&str]| format!("\"{}\"\r\n", fields.join(&format!("\"{mark}\"")));
    [
        line(&["Date", "2024-03-11 10:12:30"]),
        line(&["Model", "VK-X1000 Series"]),
        // One version of the software writes a line break here.
        "\"Data type\n\"".to_owned() + mark + "\"ImageDataCsv\"\r\n",
        line(&["File version", "1000"]),
        line(&["Objective Lens Power", "10"]),
        line(&[pixel, if mark == ";" { "1389,000" } else { "1389.000" }, "nm"]),
        line(&["Output image data", height]),
        line(&[width, "4"]),
        line(&["Vertical", "3"]),
        line(&["Minimum value", "-2"]),
        line(&["Maximum value", "7"]),
        line(&[unit, micro]),
        line(&["Reference data name", ""]),
        "\r\n".to_owned(),
        line(&[height]),
        rows(mark, "\"", 1.0),
    ]
    .concat()
}

/// Encodes `text`, in which escapes stand for the bytes of non-ASCII characters.
fn bytes(text: &str, letters: &[(&str, &[u8])]) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
    for (letter, coded) in letters {
        while let Some(at) = bytes.windows(letter.len()).position(|part| part == letter.as_bytes()) {
            bytes.splice(at..at + letter.len(), coded.iter().copied());
        }
    }
    bytes
}

#[test]
fn keyence_exports_are_read_in_every_language() {
    let pixel = [1.389e-6; 2];
    let english = ["XY Calibration", "Horizontal", "Height", "Unit"];
    let german = ["XY-Justierung", "Horizont.", "H\u{f6}he", "Einheit"];
    let japanese = ["XY\u{30ad}\u{30e3}", "\u{6a2a}", "\u{9ad8}\u{3055}", "\u{5358}\u{4f4d}"];
    for (words, micro) in [
        (english, "um"),
        (german, "\u{b5}m"),
        (japanese, "\u{3bc}m"),
        (["XY \u{6821}\u{51c6}", "\u{6c34}\u{5e73}", "\u{9ad8}\u{5ea6}", "\u{5355}\u{4f4d}"], "\u{3bc}m"),
    ] {
        assert_eq!(check(keyence(",", words, micro).as_bytes(), pixel), [""; 0], "{words:?}");
    }
    // Latin-1, Shift-JIS and GBK, whose bytes are invalid in the other encodings.
    check(&bytes(&keyence(",", german, "\u{b5}m"), &[("\u{f6}", b"\xf6"), ("\u{b5}", b"\xb5")]), pixel);
    let shift_jis: [(&str, &[u8]); 8] = [
        ("\u{30ad}", b"\x83\x4c"),
        ("\u{30e3}", b"\x83\x83"),
        ("\u{6a2a}", b"\x89\xa1"),
        ("\u{9ad8}", b"\x8d\x82"),
        ("\u{3055}", b"\x82\xb3"),
        ("\u{5358}", b"\x92\x50"),
        ("\u{4f4d}", b"\x88\xca"),
        ("\u{3bc}", b"\x83\xca"),
    ];
    let coded = bytes(&keyence(",", japanese, "\u{3bc}m"), &shift_jis);
    check(&[b"\"\x91\xaa\x92\xe8\x93\xfa\x8e\x9e\",\"2024\"\r\n", &coded[..]].concat(), pixel);
    check(
        &bytes(
            &keyence(",", ["XY \u{51c6}", "\u{6c34}", "\u{9ad8}", "\u{4f4d}"], "\u{3bc}m"),
            &[
                ("\u{51c6}", b"\xd7\xbc"),
                ("\u{6c34}", b"\xcb\xae"),
                ("\u{9ad8}", b"\xb8\xdf"),
                ("\u{4f4d}", b"\xce\xbb"),
                ("\u{3bc}", b"\xa6\xcc"),
            ],
        ),
        pixel,
    );
    // Semicolons, with decimal commas.
    let notes = check(
        keyence(";", german, "\u{b5}m").replace("0.1\";\"0.25", "0,1\";\"0,25").replace('.', ",").as_bytes(),
        pixel,
    );
    assert!(notes.len() == 1 && notes[0].contains("decimal commas"), "{notes:?}");
    // A missing point, and a truncated file.
    let holed = keyence(",", english, "um").replace("\"2.5\"", "\"\"");
    assert_eq!(plainly::read(holed).map.missing(), 1);
    let cut = keyence(",", english, "um").replace("\"-1\",\"-2\",\"0\",\"7\"\r\n", "");
    assert!(plainly::refused(cut).contains("rows end after 2 of 3"));
}

#[test]
fn gwyddion_and_mountains_map_write_their_headers_in_many_languages() {
    for [channel, width, height, unit] in [
        ["Channel:", "Width:", "Height:", "Value units:"],
        ["Kanal:", "Breite:", "H\u{f6}he:", "Einheiten:"],
        ["Kanal:", "Breite:", "H\u{f6}he:", "Einheit:"],
        ["Kan\u{e1}l:", "\u{160}\u{ed}\u{159}ka:", "V\u{fd}\u{161}ka:", "Jednotky hodnot:"],
        ["Canal\u{a0}:", "Largeur\u{a0}:", "Hauteur\u{a0}:", "Unit\u{e9}s\u{a0}:"],
        ["Canale:", "Larghezza:", "Altezza:", "unit\u{e0} valore:"],
        ["Canal:", "Anchura:", "Altura:", "Unidades de valor:"],
        [
            "\u{41a}\u{430}\u{43d}\u{430}\u{43b}:",
            "\u{428}\u{438}\u{440}\u{438}\u{43d}\u{430}:",
            "\u{412}\u{44b}\u{441}\u{43e}\u{442}\u{430}:",
            "\u{415}\u{434}\u{438}\u{43d}\u{438}\u{446}\u{44b} \u{438}\u{437}\u{43c}\u{435}\u{440}\u{435}\u{43d}\u{438}\u{44f}:",
        ],
        [
            "\u{30c1}\u{30e3}\u{30cd}\u{30eb}\u{ff1a}",
            "\u{5e45}:",
            "\u{9ad8}\u{3055}\u{ff1a}",
            "\u{5024}\u{306e}\u{5358}\u{4f4d}:",
        ],
    ] {
        for mark in ["# ", ""] {
            let header = [
                format!("{channel} Topo"),
                format!("{width} 8.000 \u{b5}m"),
                format!("{height} 6.000 \u{b5}m"),
                format!("{unit} m"),
            ];
            let header: String = header.iter().map(|line| format!("{mark}{line}\n")).collect();
            assert_eq!(check((header + &rows("\t", "", 1e-6)).as_bytes(), [2e-6; 2]), [""; 0], "{width}");
        }
    }
    // UTF-16 with decimal commas; groups of three digits alone could also be thousands.
    let text = "\u{feff}# Kanal: Topographie\r\n# Breite: 8,000 \u{b5}m\r\n# H\u{f6}he: 6,000 \u{b5}m\r\n# Einheit: \u{b5}m\r\n".to_owned()
        + &rows("\t", "", 1.0).replace('.', ",");
    let wide: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
    assert_eq!(check(&wide, [2e-6; 2]).len(), 1);
    let open = "# Width: 8,000 um\n# Height: 6 um\n# Value units: um\n1,234;5,678\n";
    assert!(plainly::refused(open).starts_with("line 1: Width is \"8,000 um\""));
    // If a file holds several maps, the first is read.
    let one = "# Channel: Z\n# Width: 8 um\n# Height: 6 um\n# Value units: um\n".to_owned() + &rows("\t", "", 1.0);
    let notes = check((one.clone() + "\n" + &one.replace("units: um", "units: V")).as_bytes(), [2e-6; 2]);
    assert_eq!(notes, ["the file holds several maps: the first is read"]);
}

#[test]
fn headers_state_units_factors_and_pixels_in_many_words() {
    let pixel = [2e-6; 2];
    for (header, scale) in [
        ("# Z unit: Angstrom\n# pixel: 2 um\n", 1e4),
        ("Unit: nm\nPixel: 2 um\n", 1e3),
        ("Unit\tnm\nPixel size\t2\tum\n", 1e3),
        ("Z unit: 10 nm\nPixel size: 2e-6 m\n", 100.0),
        ("Height factor: 0.05 um per count\ndx = 2 um\ndy = 2 um\n", 20.0),
        ("h=3 w=4\npixel size=2.00000e-006 m\ndata unit=rad\nheight conversion factor (-> m)=5e-008\n", 20.0),
        ("h=3 w=4\npixel size=2.00000e-006 m\ndata unit=m\nheight conversion factor (-> m)=1\n", 1e-6),
        (
            "# Daisy frame view snapshot\n# x-pixels: 4\n# y-pixels: 3\n# x-length: 8\n# y-length: 6\n# x-unit: um\n# z-unit: nm\n",
            1e3,
        ),
        (
            "File Format = ASCII\nCreated by: Nova\nNX = 4\nNY = 3\nScale X = 2\nScale Y = 2\nUnit X = um\nUnit Data = nm\nScale Data = 1\n",
            1e3,
        ),
        ("Width [um]: 8\nHeight [um]: 6\nValue units: um\n", 1.0),
        ("Pixelgr\u{f6}\u{df}e: 0,002 mm\nEinheit: \u{b5}m\n", 1.0),
    ] {
        let notes = check((header.to_owned() + &rows(" ", "", scale)).as_bytes(), pixel);
        assert_eq!(notes, [""; 0], "{header}");
    }
    // A single side length is that of both sides if there are as many points as lines.
    let square = "Scan size: 640 um\nZ unit: 10 nm\n1 2\n3 4\n";
    let map = plainly::read(square).map;
    assert!(
        (map.dx_m() / 320e-6 - 1.0).abs() < 1e-12
            && map.dx_m() == map.dy_m()
            && (map.heights_m()[0] - 1e-8).abs() < 1e-22
    );
    let oblong = "Scan size: 640 um\nZ unit: nm\n".to_owned() + &rows(" ", "", 1.0);
    assert!(plainly::refused(oblong).contains("pixel size is not known"));
}

#[test]
fn lines_of_a_header_that_state_a_scale_and_are_not_used_are_named() {
    let options = ReadOptions { lateral_unit: None, ..GIVEN };
    let notes = |header: &str| read_map((header.to_owned() + &rows(" ", "", 1.0)).as_bytes(), &options).unwrap().notes;
    for header in [
        "Z resolution: 0.1 nm\n",
        "# Height factor: 0.063\n",
        "Value units: counts\n",
        "Scale bar: 50 um\n",
        "# Pixel: 4\n",
    ] {
        let named = notes(header);
        let text = header.trim_start_matches("# ").trim();
        assert_eq!(named, [format!("line 1 of the header is not used: \"{text}\"")], "{header}");
    }
    let many: String = (0..7).map(|n| format!("Scale {n}: {n} um\n")).collect();
    assert!(notes(&many).len() == 5 && notes(&many)[4].starts_with("3 more lines"), "{:?}", notes(&many));
    for header in [
        "Operator: Anna\n",
        "# Gain = 20\n",
        "Speed: 10 um/s\n",
        "# x offset: 3 mm\n",
        "# side 1 mm, Sa 0.1 um\n",
        "# roughness left in the mean, on land: 0.01 um\n",
        "Objective: 10x\n",
    ] {
        assert_eq!(notes(header), [""; 0], "{header}");
    }
    // Options have precedence over the header, and a note says so.
    let said = notes("# Z unit: 10 nm\n# Pixel: 3 um\n");
    assert!(
        said[0].contains("not those of the file, 3 x 3 um") && said[1].contains("and not 10 nm, as the file says"),
        "{said:?}"
    );
    let um = Some(LengthUnit::Micrometre);
    let named = read_map(
        &b"x(\xb5m)\ty(\xb5m)\tz(\xb5m)\n0\t0\t1\n1\t0\t***\n0\t1\t3\n1\t1\t4\n"[..],
        &ReadOptions { lateral_unit: um, ..ReadOptions::default() },
    );
    assert_eq!(named.map(|read| (read.map.missing(), read.notes.len())), Ok((1, 0)));
}
