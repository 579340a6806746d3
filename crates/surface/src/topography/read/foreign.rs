//! Unsupported files of instruments, recognised by their first bytes so that a message can name them.

use crate::topography::ReadError;

/// Formats that Gwyddion or the instrument's software can export in most cases.
const COMMON: &str = ".sur, .x3p, .gsf or text from the instrument's program or from Gwyddion";
const VK: &str = "the heights as CSV, or .sur, .x3p, .gsf or text from Gwyddion";
const MX: &str = "a Zygo XYZ text from Mx, or .sur, .x3p, .gsf or text from Gwyddion";
const VISION: &str = "ASCII (.asc) from Vision64, or .sur, .x3p, .gsf or text from Gwyddion";
const SENSOFAR: &str = "the points as .dat from SensoVIEW, or .sur, .x3p, .gsf or text from Gwyddion";
const PICTURE: &str = "the heights, which a picture does not hold, as .sur, .x3p, .gsf or text";
const PACKED: &str = "the file in it: unpack it first";
const SHEET: &str = "the sheet with the heights as CSV";

/// First bytes of unsupported files, the format that each begins, and formats to export instead.
const BEGINNINGS: [(&[&[u8]], &str, &str); 18] = [
    (&[b"AliconaImaging\0"], "Alicona surface (.al3d)", COMMON),
    (&[b"\x01\0Directory", b"VCA DATA\x01\0\0\x55"], "Wyko or Bruker surface (.opd, .opdx)", VISION),
    (&[b"\x88\x1b\x03\x6f", b"\x88\x1b\x03\x70", b"\x88\x1b\x03\x71"], "Zygo MetroPro surface (.dat)", COMMON),
    (&[b"\x89HDF\r\n\x1a\n"], "HDF5 file, such as a Zygo surface (.datx)", MX),
    (&[b"VK3_", b"VK4_", b"VK6", b"VK7", b"KPK0"], "Keyence surface (.vk3, .vk4, .vk6, .vk7 or .zon)", VK),
    (&[b"GWYP"], "Gwyddion document (.gwy)", ".gsf or text from Gwyddion"),
    (&[b"FRTM_"], "FRT MicroProf surface (.frt)", COMMON),
    (&[b"\\*File list"], "Bruker NanoScope image (.spm)", COMMON),
    (&[b"\x01\xb0\x93\xff"], "NT-MDT image (.mdt)", COMMON),
    (&[b"WSxM file copyright"], "WSxM image (.stp)", COMMON),
    (&[b"OLYMPUSRAWFORMAT"], "Olympus image (.oir)", COMMON),
    (&[b"MATLAB 5.0 MAT-file"], "MATLAB file (.mat)", "the heights as text, or as .npy"),
    (
        &[b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"],
        "MountainsMap document (.mnt) or an Excel workbook (.xls)",
        "the surface alone as .sur from MountainsMap",
    ),
    (&[b"solid ", b"ply\n", b"ply\r\n"], "mesh (.stl or .ply)", COMMON),
    (&[b"\x89PNG", b"II*\0", b"MM\0*", b"II+\0", b"\xff\xd8\xff", b"GIF8", b"BM"], "picture", PICTURE),
    (&[b"\x1f\x8b", b"BZh", b"\xfd7zXZ\0", b"7z\xbc\xaf\x27\x1c", b"Rar!\x1a\x07"], "archive", PACKED),
    (&[b"PK\x05\x06"], "zip archive without files", PACKED),
    (&[b"%PDF", b"<!DOCTYPE html", b"<html", b"<?xml", b"{\rtf"], "document (PDF, HTML, XML or RTF)", COMMON),
];

/// Unsupported zip archives (those without the index of an X3P surface), recognised by the name of a file in them.
const ARCHIVES: [(&str, &str, &str); 4] = [
    ("index.xml", "Sensofar surface (.plux)", SENSOFAR),
    ("xl/workbook.xml", "Excel workbook (.xlsx)", SHEET),
    ("content.xml", "spreadsheet (.ods)", SHEET),
    (".x3p", "zip archive of X3P surfaces", PACKED),
];

/// Refuses a file in `format` and names the formats to export instead.
fn refused(format: &str, export: &str) -> ReadError {
    ReadError::Refused(format!("this is a {format}, which is not read: export {export}"))
}

/// Error that names the unsupported format of a file that begins with `start`; `None` if the format is not recognised.
pub(super) fn of(start: &[u8]) -> Option<ReadError> {
    // Two or three letters may also begin a text; the formats identified by them also contain bytes that no text has.
    let is_binary = start.iter().any(|&byte| byte < 9);
    let is_known =
        |beginning: &[u8]| start.starts_with(beginning) && (beginning.len() > 3 || !beginning.is_ascii() || is_binary);
    let known = BEGINNINGS.iter().find(|(beginnings, ..)| beginnings.iter().any(|beginning| is_known(beginning)));
    let known = known.map(|&(_, format, export)| refused(format, export));
    known.or_else(|| is_plu(start).then(|| refused("Sensofar surface (.plu)", SENSOFAR)))
}

/// Error that names the unsupported format of a zip archive with files of these `names`.
pub(super) fn archive_of(names: impl Iterator<Item = impl AsRef<str>>) -> ReadError {
    let names: Vec<String> = names.map(|name| name.as_ref().to_lowercase()).collect();
    let holds = |part: &str| names.iter().any(|name| name == part || part.starts_with('.') && name.ends_with(part));
    let known = ARCHIVES.iter().find(|(part, ..)| holds(part)).map(|&(_, format, export)| (format, export));
    let (format, export) = known.unwrap_or(("zip archive without the main.xml of an X3P surface", PACKED));
    refused(format, export)
}

/// Whether a file that begins with `start` is a `.plu` file, which has no signature; it begins with a date and time,
/// such as `Thu May 10 10:17:24 2007`, padded with zeros to 128 bytes.
fn is_plu(start: &[u8]) -> bool {
    const MIN_DATE: usize = 14;
    let length = start.iter().position(|&byte| byte == 0).unwrap_or(start.len());
    let (date, padding) = start.split_at(length);
    let count = |wanted: fn(&u8) -> bool| date.iter().filter(|byte| wanted(byte)).count();
    length >= MIN_DATE
        && !padding.is_empty()
        && padding.iter().all(|&byte| byte == 0)
        && date.iter().all(|byte| byte.is_ascii_graphic() || byte.is_ascii_whitespace())
        && count(|byte| *byte == b':') >= 1
        && count(u8::is_ascii_digit) >= 6
}

#[cfg(test)]
mod tests {
    use super::super::plainly::refused;

    #[test]
    fn files_of_instruments_that_are_not_read_are_named_with_what_to_do() {
        let mut plu = b"Thu May 10 10:17:24 2007".to_vec();
        plu.resize(2000, 0);
        for (bytes, name) in [
            (&plu[..], "Sensofar surface (.plu)"),
            (b"AliconaImaging\0\r\n and more", "Alicona surface (.al3d)"),
            (b"\x01\0Directory\0\0\0\0 and more", "Wyko or Bruker surface (.opd"),
            (b"\x88\x1b\x03\x70 and more", "Zygo MetroPro surface (.dat)"),
            (b"VK4_\0\0", "Keyence surface (.vk3, .vk4,"),
            (b"GWYPGwyContainer\0", "Gwyddion document (.gwy)"),
            (b"II*\0\x08\0\0\0", "picture"),
            (b"\x89HDF\r\n\x1a\n\0\0\0\0", "Zygo surface (.datx)"),
            (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1\0\0", "MountainsMap document (.mnt)"),
            (b"\\*File list\r\n\\Version: 0x05120130\r\n", "NanoScope"),
            (b"BM\x36\0\0\0", "picture"),
            (b"\x1f\x8b\x08\0", "archive"),
            (b"solid ascii\nfacet normal 0 0 1\n", "mesh (.stl"),
        ] {
            let message = refused(bytes);
            assert!(message.contains(name) && message.contains("not read: export"), "{message}");
        }
        for (names, name) in [
            (&["index.xml", "LAYER_0.raw"][..], "(.plux)"),
            (&["[Content_Types].xml", "xl/workbook.xml"], "(.xlsx)"),
            (&["a/1.x3p", "a/2.x3p"], "archive of X3P"),
            (&["notes.txt"], "zip archive"),
        ] {
            let mut writer = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
            names.iter().for_each(|name| writer.start_file(*name, zip::write::SimpleFileOptions::default()).unwrap());
            let message = refused(writer.finish().unwrap().into_inner());
            assert!(message.contains(name), "{message}");
        }
        // Numbers and dates in texts are not recognised as such files.
        for text in [&b"10:17:24 2007 1 2 3\n"[..], b"1 2 3 4\n5 6 7 8\n", b"BM: 3\n1 2 3 4\n"] {
            let message = refused(text);
            assert!(!message.contains("export"), "{message}");
        }
    }
}
