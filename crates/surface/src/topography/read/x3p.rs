//! XML 3-D surface (`.x3p`, ISO 25178-72): a zip archive with the index `main.xml`. The heights are in a binary file
//! named by the index (x fastest, little endian) or as text within it; an optional bit file marks the valid points
//! (lowest bit first). All lengths are in metres; a height is the stored number times the increment of the z axis plus
//! its offset. Missing points are NaN or not valid.

use std::collections::HashMap;
use std::io::{BufReader, Cursor, Read};

use zip::ZipArchive;
use zip::read::ZipFile;

use super::bytes::{at_end, numbers, unreadable};
use super::foreign;
use super::overridden::Lengths;
use super::window::Window;
use super::x3p_index::{FORMAT, Heights, Index, refused};
use super::{MapFormat, ReadMap, ReadOptions, bomb, check_expansion};
use crate::topography::ReadError;

pub(super) const MAGIC: &[u8] = b"PK\x03\x04";
/// Largest archive, in bytes. It is held in memory because its directory is at the end.
const MAX_ARCHIVE_BYTES: u64 = 1 << 29;
/// Largest index: a few hundred thousand heights fit as text; larger maps use a binary file.
const MAX_INDEX_BYTES: u64 = 1 << 24;
/// Ratio of unpacked to packed size above which an index is refused as a decompression bomb, if it is larger than
/// [`HARMLESS_INDEX_BYTES`]. Digits of heights pack to a third, the tags around them to a twentieth.
const MAX_INDEX_EXPANSION: u64 = 60;
/// Unpacked size up to which an index is not refused as a decompression bomb.
const HARMLESS_INDEX_BYTES: u64 = 1 << 20;

pub(super) fn read(mut source: impl Read, options: &ReadOptions) -> Result<ReadMap, ReadError> {
    let mut bytes = Vec::new();
    let read = (&mut source)
        .take(MAX_ARCHIVE_BYTES + 1)
        .read_to_end(&mut bytes)
        .map_err(|error| unreadable(FORMAT, &error))?;
    if read as u64 > MAX_ARCHIVE_BYTES {
        return Err(refused("archive", format!("over {MAX_ARCHIVE_BYTES} bytes"), "at most 512 MiB"));
    }
    let mut archive = ZipArchive::new(Cursor::new(bytes.as_slice())).map_err(|error| broken(&error))?;
    let places = Places::of(&archive);
    let index = {
        let names = || archive.file_names().filter_map(Result::ok);
        let place = places.index.ok_or_else(|| foreign::archive_of(names()))?;
        let file = archive.by_index(place).map_err(|error| broken(&error))?;
        if file.size() > MAX_INDEX_BYTES {
            return Err(refused("main.xml", format!("{} bytes", file.size()), "at most 16 MiB"));
        }
        if file.size() > HARMLESS_INDEX_BYTES && file.size() / MAX_INDEX_EXPANSION > file.compressed_size() {
            return Err(bomb(FORMAT, file.size(), file.compressed_size(), MAX_INDEX_EXPANSION));
        }
        Index::read(BufReader::new(file.take(MAX_INDEX_BYTES)))?
    };
    let mut window = Window::new(Some(index.rows), index.cols, options.crop, options.decimation)?;
    match &index.heights {
        Heights::File { path, valid } => {
            // Two entries are read in parallel, through two views of the same bytes.
            let (mut other, needed) = (archive.clone(), index.points().div_ceil(8));
            let mut bits = match valid {
                Some(valid) => Some(Bits::new(sized_entry(&mut other, places.find(valid)?, needed)?)),
                None => None,
            };
            let mut file = data_entry(&mut archive, places.find(path)?, &index)?;
            let height = |value: f64| {
                let is_valid = bits.as_mut().map_or(Ok(true), Bits::next)?;
                Ok(if is_valid && !value.is_infinite() { value } else { f64::NAN })
            };
            if numbers(&mut file, FORMAT, (index.number, false), index.points(), &mut window, height)? {
                at_end(&mut file, FORMAT)?;
                bits.map_or(Ok(()), |mut bits| at_end(&mut bits.source, FORMAT))?;
            }
        }
        Heights::List(values) => {
            if values.len() as u64 != index.points() {
                let (expected, found) = (index.points(), values.len() as u64);
                return Err(ReadError::Ended { format: FORMAT, what: "heights", expected, found });
            }
            window.push(values)?;
        }
    }
    let [x, y, z] = index.increment_m;
    let height = |value| value * z + index.offset_z_m;
    Lengths::metres([x, y]).map(window, height, options, MapFormat::X3p, index.comments)
}

fn broken(error: &zip::result::ZipError) -> ReadError {
    unreadable(FORMAT, error)
}

type Archive<'b> = ZipArchive<Cursor<&'b [u8]>>;

/// Positions of the files in an archive, by their names in lower case, without `./` and backslashes. Files added by
/// macOS are omitted.
struct Places {
    /// The index: `main.xml` in the outermost folder that has one.
    index: Option<usize>,
    /// Folder of the index, with its trailing slash.
    folder: String,
    names: HashMap<String, usize>,
}

impl Places {
    fn of(archive: &Archive<'_>) -> Self {
        let mut names = HashMap::new();
        for name in archive.file_names().filter_map(Result::ok) {
            let plain = plain(&name);
            let is_mac =
                plain.starts_with("__macosx/") || plain.rsplit('/').next().is_some_and(|file| file.starts_with("._"));
            if let Some(place) = archive.index_for_name(&name).filter(|_| !is_mac) {
                names.entry(plain).or_insert(place);
            }
        }
        let is_index = |name: &&String| name.rsplit('/').next() == Some("main.xml");
        let depth = |name: &&String| (name.matches('/').count(), name.len(), (*name).clone());
        let found = names.keys().filter(is_index).min_by_key(depth);
        let folder = found.map(|name| name.trim_end_matches("main.xml").to_owned()).unwrap_or_default();
        Self { index: found.and_then(|name| names.get(name)).copied(), folder, names }
    }

    /// Position in the archive of the file that the index calls `path`; refused if there is no such file.
    fn find(&self, path: &str) -> Result<usize, ReadError> {
        let plain = plain(path);
        let found = self.names.get(&format!("{}{plain}", self.folder)).or_else(|| self.names.get(&plain));
        let name = || format!("no {}", super::lines::excerpt(path));
        found.copied().ok_or_else(|| refused("archive", name(), "the files of an X3P surface"))
    }
}

/// Normalises the name of a file in an archive; writers differ in case and separators.
fn plain(name: &str) -> String {
    let name = name.replace('\\', "/").to_lowercase();
    name.split('/').filter(|part| !matches!(*part, "" | ".")).collect::<Vec<_>>().join("/")
}

/// The file of the archive, at position `place`, with the heights that `index` describes; refused if its size is wrong.
fn data_entry<'a, 'b>(
    archive: &'a mut Archive<'b>,
    place: usize,
    index: &Index,
) -> Result<ZipFile<'a, Cursor<&'b [u8]>>, ReadError> {
    let bytes_each = index.number.bytes() as u64;
    let file = sized_entry(archive, place, index.points().saturating_mul(bytes_each))?;
    check_expansion(FORMAT, index.points(), bytes_each, file.compressed_size())?;
    Ok(file)
}

/// The file at position `place` of the archive; refused unless it unpacks to `needed` bytes.
fn sized_entry<'a, 'b>(
    archive: &'a mut Archive<'b>,
    place: usize,
    needed: u64,
) -> Result<ZipFile<'a, Cursor<&'b [u8]>>, ReadError> {
    let file = archive.by_index(place).map_err(|error| broken(&error))?;
    if file.size() != needed {
        let (expected, found) = (needed, file.size());
        return Err(ReadError::Ended { format: FORMAT, what: "bytes of data", expected, found });
    }
    Ok(file)
}

/// Reads bits, lowest first.
struct Bits<R> {
    source: BufReader<R>,
    byte: u8,
    left: u32,
}

impl<R: Read> Bits<R> {
    fn new(source: R) -> Self {
        Self { source: BufReader::new(source), byte: 0, left: 0 }
    }

    fn next(&mut self) -> Result<bool, ReadError> {
        if self.left == 0 {
            [self.byte] = super::bytes::exact(&mut self.source, FORMAT, "validity")?;
            self.left = 8;
        }
        let bit = self.byte & 1 == 1;
        self.byte >>= 1;
        self.left -= 1;
        Ok(bit)
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;

    use zip::CompressionMethod;
    use zip::write::SimpleFileOptions;

    use super::super::plainly::{self, refused};
    use super::{Cursor, MAX_INDEX_BYTES, MapFormat};

    const INDEX: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<p:ISO5436_2 xmlns:p="http://www.opengps.eu/2008/ISO5436_2">
 <Record1><Revision>ISO5436 - 2000</Revision><FeatureType>SUR</FeatureType><Axes>
  <CX><AxisType>I</AxisType><DataType>D</DataType><Increment>1e-6</Increment><Offset>0</Offset></CX>
  <CY><AxisType>I</AxisType><DataType>D</DataType><Increment>2e-6</Increment><Offset>0</Offset></CY>
  <CZ><AxisType>A</AxisType><DataType>TYPE</DataType><Increment>1e-9</Increment><Offset>5e-9</Offset></CZ>
 </Axes></Record1>
 <Record2><Comment>a &lt;comment&gt;</Comment></Record2>
 <Record3><MatrixDimension><SizeX>3</SizeX><SizeY>2</SizeY><SizeZ>1</SizeZ></MatrixDimension>DATA</Record3>
</p:ISO5436_2>"#;

    const LINK: &str = "<DataLink><PointDataLink>bindata/data.bin</PointDataLink></DataLink>";
    const LINKS: &str = "<DataLink><PointDataLink>bindata/data.bin</PointDataLink>\
                         <ValidPointsLink>bindata/valid.bin</ValidPointsLink></DataLink>";

    fn zipped(files: &[(&str, &[u8])], method: CompressionMethod) -> Vec<u8> {
        let mut writer = zip::ZipWriter::new(Cursor::new(Vec::new()));
        for (name, bytes) in files {
            writer.start_file(*name, SimpleFileOptions::default().compression_method(method)).unwrap();
            writer.write_all(bytes).unwrap();
        }
        writer.finish().unwrap().into_inner()
    }

    fn archive(index: &str, files: &[(&str, &[u8])]) -> Vec<u8> {
        zipped(&[&[("main.xml", index.as_bytes())], files].concat(), CompressionMethod::Deflated)
    }

    /// Six heights, the fourth of them missing.
    fn floats() -> Vec<u8> {
        [1.0_f32, 2.0, 3.0, f32::NAN, -5.0, 6.0].into_iter().flat_map(f32::to_le_bytes).collect()
    }

    fn index(kind: &str, data: &str) -> String {
        INDEX.replace("TYPE", kind).replace("DATA", data)
    }

    fn check(bytes: &[u8]) {
        let heights_m = [6.0, f64::NAN, 7.0, 0.0, 8.0, 11.0].map(|height_nm| 1e-9 * height_nm);
        let read = plainly::check(bytes, MapFormat::X3p, [1e-6, 2e-6], heights_m, 1e-18);
        assert!(read.comments.contains(&"Comment: a <comment>".to_owned()), "{:?}", read.comments);
    }

    #[test]
    fn every_way_to_store_heights_gives_the_same_map() {
        check(&archive(&index("F", LINK), &[("bindata/data.bin", &floats())]));
        let shorts: Vec<u8> = [1_i16, 2, 3, 99, -5, 6].into_iter().flat_map(i16::to_le_bytes).collect();
        let valid = [0b11_0111_u8];
        check(&archive(&index("I", LINKS), &[("bindata/data.bin", &shorts), ("bindata/valid.bin", &valid)]));
        let listed = "<DataList><Datum>1</Datum><Datum>2</Datum><Datum>3.0</Datum><Datum></Datum>\
                      <Datum>-5</Datum><Datum> 6 </Datum></DataList>";
        check(&archive(&index("D", listed), &[]));
        check(&archive(&index("D", &listed.replace("<Datum></Datum>", "<Datum/>")), &[]));
    }

    #[test]
    fn files_are_found_in_folders_in_any_case_and_with_any_slashes() {
        let packed = |prefix: &str, main: &str, link: &str| {
            let linked = LINKS
                .replace("bindata/data.bin", link)
                .replace("bindata/valid.bin", &link.replace("data.bin", "valid.bin"));
            let index = index("F", &linked);
            let files = [
                (&format!("__MACOSX/{prefix}._main.xml")[..], &b"\x00\x05\x16\x07"[..]),
                (&format!("__MACOSX/{prefix}main.xml"), b"no index"),
                (&format!("{prefix}{main}"), index.as_bytes()),
                (&format!("{prefix}bindata/data.bin"), &floats()),
                (&format!("{prefix}bindata/valid.bin"), &[0xFF]),
            ];
            zipped(&files, CompressionMethod::Deflated)
        };
        for (prefix, main, link) in [
            ("", "main.xml", "bindata/data.bin"),
            ("sample-7/", "main.xml", "bindata/data.bin"),
            ("a/b/", "Main.XML", "Bindata/data.bin"),
            ("./", "main.xml", "./bindata/data.bin"),
            ("sample 7\\", "main.xml", "bindata\\data.bin"),
            ("", "MAIN.XML", "/bindata/data.bin"),
            ("sample-7/", "main.xml", "sample-7/bindata/data.bin"),
        ] {
            check(&packed(prefix, main, link));
        }
    }

    #[test]
    fn an_optional_entry_that_is_empty_is_absent() {
        let floats: Vec<u8> =
            [6.0e-9_f64, 7e-9, 8e-9, f64::NAN, 0.0, 11e-9].into_iter().flat_map(f64::to_le_bytes).collect();
        let plain = index("D", LINK).replace("<Increment>1e-9</Increment><Offset>5e-9</Offset>", "");
        for (from, to) in [
            ("</AxisType><DataType>D</DataType></CZ>", "</AxisType><DataType>D</DataType><Increment/><Offset/></CZ>"),
            ("<Offset>0</Offset>", "<Offset></Offset>"),
            ("</PointDataLink>", "</PointDataLink><ValidPointsLink/><MD5ChecksumPointData/>"),
        ] {
            assert!(plain.contains(from));
            check(&archive(&plain.replace(from, to), &[("bindata/data.bin", &floats)]));
        }
    }

    #[test]
    fn archives_that_lie_are_refused_by_name() {
        let data = [0; 48];
        let whole = |xml: &str| refused(archive(xml, &[("bindata/data.bin", &data)]));
        assert!(refused(archive(&index("D", LINK), &[])).contains("no bindata/data.bin"));
        assert!(refused(archive(&index("D", LINK), &[("bindata/data.bin", &data[1..])])).contains("47"));
        assert!(whole(&index("X", LINK)).contains("DataType"));
        assert!(whole(&index("D", LINK).replace(">SUR<", ">PCL<")).contains("FeatureType"));
        assert!(whole(&index("D", LINK).replace("<SizeX>3", "<SizeX>4000000000")).contains("expected at most"));
        assert!(whole(&index("D", LINK).replace("<SizeX>3", "<SizeX>-3")).contains("SizeX"));
        assert!(whole(&index("D", LINK).replace("<SizeZ>1", "<SizeZ>2")).contains("SizeZ"));
        assert!(whole(&index("D", LINK).replace("1e-6", "fine")).contains("Increment"));
        assert!(whole(&index("D", "")).contains("PointDataLink"));
        assert!(whole("<p><Record1>").contains("main.xml"));
        assert!(refused(b"PK\x03\x04 and then nothing").contains("surface (.x3p)"));
    }

    #[test]
    fn damaged_heights_fail_their_check_sum() {
        let data: Vec<u8> = [1.0_f64, 2.0, 3.0, 4.0, 5.0, 6.0].into_iter().flat_map(f64::to_le_bytes).collect();
        let files = [("main.xml", index("D", LINK).into_bytes()), ("bindata/data.bin", data)];
        let mut bytes = zipped(&files.each_ref().map(|(name, bytes)| (*name, &bytes[..])), CompressionMethod::Stored);
        plainly::read(&bytes);
        let at = bytes.windows(8).position(|part| part == 5.0_f64.to_le_bytes()).unwrap();
        bytes[at + 6] ^= 1;
        let message = refused(bytes);
        assert!(message.contains("checksum"), "{message}");
    }

    #[test]
    fn zip_bombs_are_refused_before_they_unpack() {
        // 3 million equal heights pack to a thousandth of their size.
        let size = index("D", LINK).replace("<SizeX>3", "<SizeX>2000").replace("<SizeY>2", "<SizeY>1500");
        let zeros = vec![0; 8 * 3_000_000];
        let bomb = archive(&size, &[("bindata/data.bin", &zeros)]);
        drop(zeros);
        let message = refused(bomb);
        assert!(message.contains("unpacks to 24000000 bytes"), "{message}");
        let xml = index("D", LINK) + &" ".repeat(MAX_INDEX_BYTES as usize);
        let message = refused(archive(&xml, &[]));
        assert!(message.contains("main.xml"), "{message}");
    }
}
