//! Words of headers: what each means, in the languages in which programs write them.

/// What a line of a header states.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Key {
    /// Side along x, of all points of a line.
    Width,
    /// Side along y, of all lines.
    Height,
    /// Both sides of a square scan.
    Side,
    /// Points of a line.
    Cols,
    /// Lines.
    Rows,
    /// Both sides of a pixel.
    Pixel,
    /// Side of a pixel along x.
    PixelX,
    /// Side of a pixel along y.
    PixelY,
    HeightUnit,
    /// Unit of heights, or of data that a factor makes heights, such as radians.
    DataUnit,
    HeightFactor,
    LateralUnit,
}

/// Words for each key: Gwyddion's in the languages of its interface, MountainsMap's, SPIP's, those of Attocube, Nova and
/// Koala, and what people write themselves. The first stands for the key in messages.
const WORDS: [(Key, &[&str]); 12] = [
    (
        Key::Width,
        &[
            "Width",
            "x-length",
            "Breite",
            "Largeur",
            "Larghezza",
            "Anchura",
            "Ancho",
            "Largura",
            "Šířka",
            "Szerokość",
            "Ширина",
            "Bredd",
            "Bredde",
            "Breedte",
            "幅",
            "폭",
            "宽度",
            "寬度",
        ],
    ),
    (
        Key::Height,
        &[
            "Height",
            "y-length",
            "Höhe",
            "Hauteur",
            "Altezza",
            "Altura",
            "Alto",
            "Výška",
            "Wysokość",
            "Высота",
            "Höjd",
            "Høyde",
            "Hoogte",
            "高さ",
            "높이",
            "高度",
        ],
    ),
    (Key::Side, &["Scan size", "Scan range", "Scangröße", "Scanbereich"]),
    (Key::Cols, &["x-pixels", "NX", "w"]),
    (Key::Rows, &["Rows", "y-pixels", "NY", "h"]),
    (
        Key::Pixel,
        &[
            "Pixel size",
            "Pixel",
            "Pixel pitch",
            "Pixel spacing",
            "Sample spacing",
            "Point spacing",
            "XY calibration",
            "Pixelgröße",
            "Pixelabstand",
            "Taille de pixel",
            "Taille du pixel",
            "Dimensione pixel",
            "Tamaño de píxel",
            "Tamanho do pixel",
            "ピクセルサイズ",
            "像素尺寸",
        ],
    ),
    (Key::PixelX, &["Pixel size x", "x pixel size", "Pixel x", "Scale x", "x-step", "x-spacing", "x-increment", "dx"]),
    (Key::PixelY, &["Pixel size y", "y pixel size", "Pixel y", "Scale y", "y-step", "y-spacing", "y-increment", "dy"]),
    (
        Key::HeightUnit,
        &[
            "Value units",
            "Value unit",
            "z-units",
            "z-unit",
            "Unit z",
            "Height unit",
            "Height units",
            "Unit",
            "Units",
            "Einheit",
            "Einheiten",
            "Werteinheiten",
            "Höheneinheit",
            "z-Einheit",
            "Unité",
            "Unités",
            "unità",
            "unità valore",
            "Unidad",
            "Unidades",
            "Unidades de valor",
            "Unidade",
            "Unidades dos valores",
            "Jednotky",
            "Jednotky hodnot",
            "Jednostka",
            "Jednostki",
            "Единицы",
            "Единицы измерения",
            "単位",
            "値の単位",
            "단위",
            "값 단위",
            "单位",
            "單位",
        ],
    ),
    (Key::DataUnit, &["Data unit", "Unit data"]),
    (
        Key::HeightFactor,
        &[
            "Height factor",
            "Height conversion factor",
            "Height scale",
            "z-factor",
            "z-scale",
            "Scale z",
            "Scale data",
            "Höhenfaktor",
            "z-Faktor",
            "Höhenskalierung",
        ],
    ),
    (
        Key::LateralUnit,
        &["XY units", "XY unit", "Lateral units", "Lateral unit", "x-unit", "Unit x", "xy-Einheit", "xy-Einheiten"],
    ),
];

impl Key {
    /// The key that a header calls `word`, in any case, with `-`, `_` or blanks between its parts.
    pub(super) fn of(word: &str) -> Option<Self> {
        let word = plain(word);
        WORDS.iter().find(|(_, words)| words.iter().any(|known| plain(known) == word)).map(|(key, _)| *key)
    }

    /// The word that messages use.
    pub(super) fn name(self) -> &'static str {
        WORDS.iter().find(|(key, _)| *key == self).map_or("", |(_, words)| words[0])
    }
}

/// A word in lower case, its parts separated by single blanks.
fn plain(word: &str) -> String {
    word.to_lowercase().split([' ', '\u{a0}', '-', '_']).filter(|part| !part.is_empty()).collect::<Vec<_>>().join(" ")
}

/// Parts of words, in lower case, that speak of a unit or a scale ...
const SCALE_WORDS: [&str; 16] = [
    "unit",
    "einheit",
    "unidad",
    "jednot",
    "scale",
    "skal",
    "factor",
    "faktor",
    "facteur",
    "fattore",
    "pixel",
    "calibrat",
    "size",
    "spacing",
    "step",
    "resolution",
];
/// ... and of lengths that say nothing of heights or pixels.
const OTHER_WORDS: [&str; 14] = [
    "offset",
    "origin",
    "position",
    "distance",
    "speed",
    "cutoff",
    "cut-off",
    "filter",
    "wavelength",
    "radius",
    "range",
    "min",
    "max",
    "image size",
];

/// Words of a name, at most.
const MAX_NAME_WORDS: usize = 4;

/// Whether a line that is not understood seems to state a unit or a scale; `is_length` if its value is a length or a unit.
pub(super) fn states_scale(word: &str, value: &str, is_length: bool) -> bool {
    let word = word.to_lowercase();
    let has = |words: &[&str]| words.iter().any(|part| word.contains(part));
    let has_number = value.chars().any(|c| c.is_ascii_digit());
    // Sentences with a length at their end are remarks.
    let names = is_length && word.split_whitespace().count() <= MAX_NAME_WORDS;
    !has(&OTHER_WORDS) && (names || has(&["unit", "einheit"]) || has(&SCALE_WORDS) && has_number)
}
