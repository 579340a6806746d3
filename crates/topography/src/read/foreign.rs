//! Files of instruments that are not read: told by what they begin with, so that a message can name them.

/// What files begin with, and what they are called.
const BEGINNINGS: [(&[u8], &str); 14] = [
    (b"AliconaImaging\0", "Alicona surface (.al3d)"),
    (b"\x01\0Directory", "Wyko surface (.opd)"),
    (b"\x88\x1b\x03\x6f", "Zygo MetroPro surface (.dat)"),
    (b"\x88\x1b\x03\x70", "Zygo MetroPro surface (.dat)"),
    (b"\x88\x1b\x03\x71", "Zygo MetroPro surface (.dat)"),
    (b"VK3_", "Keyence surface (.vk3)"),
    (b"VK4_", "Keyence surface (.vk4)"),
    (b"VK6", "Keyence surface (.vk6)"),
    (b"VK7", "Keyence surface (.vk7)"),
    (b"GWYP", "Gwyddion document (.gwy)"),
    (b"FRTM_", "FRT MicroProf surface (.frt)"),
    (b"\x89PNG", "PNG picture"),
    (b"II*\0", "TIFF picture"),
    (b"MM\0*", "TIFF picture"),
];

/// What a file that begins with `start` is, if it is one of an instrument that is not read.
pub(super) fn name_of(start: &[u8]) -> Option<&'static str> {
    let known = BEGINNINGS.iter().find(|(beginning, _)| start.starts_with(beginning)).map(|(_, name)| *name);
    known.or_else(|| is_plu(start).then_some(PLU))
}

const PLU: &str = "Sensofar surface (.plu)";
/// What a Sensofar archive holds beside its heights; the archive of an X3P surface has `main.xml` instead.
pub(super) const PLUX_INDEX: &str = "index.xml";
pub(super) const PLUX: &str = "Sensofar surface (.plux)";

/// A `.plu` file has no mark; it begins with a date and time, as `Thu May 10 10:17:24 2007`, and zeros to 128 bytes.
fn is_plu(start: &[u8]) -> bool {
    const LEAST_DATE: usize = 14;
    let length = start.iter().position(|&byte| byte == 0).unwrap_or(start.len());
    let (date, padding) = start.split_at(length);
    let count = |wanted: fn(&u8) -> bool| date.iter().filter(|byte| wanted(byte)).count();
    length >= LEAST_DATE
        && !padding.is_empty()
        && padding.iter().all(|&byte| byte == 0)
        && date.iter().all(|byte| byte.is_ascii_graphic() || byte.is_ascii_whitespace())
        && count(|byte| *byte == b':') >= 1
        && count(u8::is_ascii_digit) >= 6
}

#[cfg(test)]
mod tests {
    use crate::{ReadOptions, read_map};

    #[test]
    fn files_of_instruments_that_are_not_read_are_named_with_what_to_do() {
        let mut plu = b"Thu May 10 10:17:24 2007".to_vec();
        plu.resize(2000, 0);
        for (bytes, name) in [
            (&plu[..], "Sensofar surface (.plu)"),
            (b"AliconaImaging\0\r\n and more", "Alicona surface (.al3d)"),
            (b"\x01\0Directory\0\0\0\0 and more", "Wyko surface (.opd)"),
            (b"\x88\x1b\x03\x70 and more", "Zygo MetroPro surface (.dat)"),
            (b"VK4_\0\0", "Keyence surface (.vk4)"),
            (b"GWYPGwyContainer\0", "Gwyddion document (.gwy)"),
            (b"II*\0\x08\0\0\0", "TIFF picture"),
        ] {
            let message = read_map(bytes, &ReadOptions::default()).unwrap_err().to_string();
            assert!(message.contains(name), "{message}");
            assert!(message.contains("export") && message.contains(".sur, .x3p, .gsf or text"), "{message}");
        }
        // Numbers and dates of texts are no such file.
        for text in [&b"10:17:24 2007 1 2 3\n"[..], b"1 2 3 4\n5 6 7 8\n"] {
            let message = read_map(text, &ReadOptions::default()).unwrap_err().to_string();
            assert!(!message.contains("Sensofar"), "{message}");
        }
    }
}
