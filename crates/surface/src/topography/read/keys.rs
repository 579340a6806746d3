//! Words used in headers and their meanings, in the languages in which programs write them.

/// Quantity stated by a header line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Key {
    /// Side along x: length of a line.
    Width,
    /// Side along y: extent of all lines.
    Height,
    /// Both sides of a square scan.
    Side,
    /// Number of points on a line.
    Cols,
    /// Number of lines.
    Rows,
    /// Both sides of a pixel.
    Pixel,
    /// Side of a pixel along x.
    PixelX,
    /// Side of a pixel along y.
    PixelY,
    HeightUnit,
    /// Unit of heights, or of data converted to heights by a factor, such as radians.
    DataUnit,
    HeightFactor,
    LateralUnit,
}

/// Words for each key: those of Gwyddion in the languages of its interface, of MountainsMap, SPIP, Attocube, Nova and
/// Koala, and words that people write themselves, separated by commas. The first word stands for the key in messages.
const WORDS: [(Key, &str); 12] = [
    (
        Key::Width,
        "Width, x-length, Breite, Largeur, Larghezza, Anchura, Ancho, Largura, Šířka, Szerokość, Ширина, Bredd, \
         Bredde, Breedte, 幅, 폭, 宽度, 寬度",
    ),
    (
        Key::Height,
        "Height, y-length, Höhe, Hauteur, Altezza, Altura, Alto, Výška, Wysokość, Высота, Höjd, Høyde, Hoogte, \
         高さ, 높이, 高度",
    ),
    (Key::Side, "Scan size, Scan range, Scangröße, Scanbereich"),
    (Key::Cols, "x-pixels, NX, w"),
    (Key::Rows, "Rows, y-pixels, NY, h"),
    (
        Key::Pixel,
        "Pixel size, Pixel, Pixel pitch, Pixel spacing, Sample spacing, Point spacing, XY calibration, \
         Pixelgröße, Pixelabstand, Taille de pixel, Taille du pixel, Dimensione pixel, Tamaño de píxel, \
         Tamanho do pixel, ピクセルサイズ, 像素尺寸",
    ),
    (Key::PixelX, "Pixel size x, x pixel size, Pixel x, Scale x, x-step, x-spacing, x-increment, dx"),
    (Key::PixelY, "Pixel size y, y pixel size, Pixel y, Scale y, y-step, y-spacing, y-increment, dy"),
    (
        Key::HeightUnit,
        "Value units, Value unit, z-units, z-unit, Unit z, Height unit, Height units, Unit, Units, Einheit, \
         Einheiten, Werteinheiten, Höheneinheit, z-Einheit, Unité, Unités, unità, unità valore, Unidad, \
         Unidades, Unidades de valor, Unidade, Unidades dos valores, Jednotky, Jednotky hodnot, Jednostka, \
         Jednostki, Единицы, Единицы измерения, 単位, 値の単位, 단위, 값 단위, 单位, 單位",
    ),
    (Key::DataUnit, "Data unit, Unit data"),
    (
        Key::HeightFactor,
        "Height factor, Height conversion factor, Height scale, z-factor, z-scale, Scale z, Scale data, \
         Höhenfaktor, z-Faktor, Höhenskalierung",
    ),
    (Key::LateralUnit, "XY units, XY unit, Lateral units, Lateral unit, x-unit, Unit x, xy-Einheit, xy-Einheiten"),
];

impl Key {
    /// Finds the key for a header word, in any case, with `-`, `_` or blanks between its parts; `None` for other words.
    pub(super) fn of(word: &str) -> Option<Self> {
        let word = plain(word);
        WORDS.iter().find(|(_, words)| words.split(',').any(|known| plain(known) == word)).map(|(key, _)| *key)
    }

    /// The word used in messages.
    pub(super) fn name(self) -> &'static str {
        WORDS.iter().find(|(key, _)| *key == self).and_then(|(_, words)| words.split(',').next()).unwrap_or_default()
    }
}

/// Converts a word to lower case, with its parts separated by single blanks.
fn plain(word: &str) -> String {
    word.to_lowercase().split([' ', '\u{a0}', '-', '_']).filter(|part| !part.is_empty()).collect::<Vec<_>>().join(" ")
}

/// Parts of words, in lower case, that indicate a unit or a scale.
const SCALE_WORDS: &str =
    "unit,einheit,unidad,jednot,scale,skal,factor,faktor,facteur,fattore,pixel,calibrat,size,spacing,step,resolution";
/// Substrings, in lower case, of names of quantities that are neither heights nor pixel sizes.
const OTHER_WORDS: &str =
    "offset,origin,position,distance,speed,cutoff,cut-off,filter,wavelength,radius,range,min,max,image size";

/// Largest number of words in the name of a value; longer texts are remarks.
const MAX_NAME_WORDS: usize = 4;

/// Whether a line that was not understood seems to state a unit or a scale; `is_length` tells whether its value is a
/// length or a unit.
pub(super) fn states_scale(word: &str, value: &str, is_length: bool) -> bool {
    let word = word.to_lowercase();
    let has = |words: &str| words.split(',').any(|part| word.contains(part));
    let has_number = value.chars().any(|c| c.is_ascii_digit());
    // Longer sentences that end with a length are remarks.
    let names = is_length && word.split_whitespace().count() <= MAX_NAME_WORDS;
    !has(OTHER_WORDS) && (names || has("unit,einheit") || has(SCALE_WORDS) && has_number)
}
