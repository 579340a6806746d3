//! A folder with the published low-density polyethylene: calibration, tables, map and design.

use std::path::Path;

/// Files of the example by name. They are those of `calibration/ldpe-cast-iron` and `designs/ldpe-lower-friction.toml`.
pub const FILES: [(&str, &str); 4] = [
    ("ldpe-cast-iron/calibration.toml", include_str!("../example/calibration.toml")),
    ("ldpe-cast-iron/flat.csv", include_str!("../example/flat.csv")),
    ("ldpe-cast-iron/patterned.csv", include_str!("../example/patterned.csv")),
    ("lower-friction.toml", include_str!("../example/design.toml")),
];
/// Name of the example's altitude map, which is synthetic and is made when the example is written.
pub const MAP: &str = "ldpe-cast-iron/flat-map.asc";

/// Whether `folder` holds nothing that the example could replace.
pub fn is_free(folder: &Path) -> bool {
    std::fs::read_dir(folder).map_or(!folder.exists(), |mut entries| entries.next().is_none())
}
