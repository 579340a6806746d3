//! Measured relief of a pattern: a map of one period, named by a scene or a calibration.

use std::sync::Arc;

use slipgrid_base::monitor::Unwatched;
use slipgrid_model::pattern::{Pattern, ReliefMap};
use slipgrid_surface::topography::{HeightMap, ReadOptions};

use super::altitude_map::open;
use super::material::existing;
use super::pattern::PatternFile;
use crate::formats::{Diagnostic, Document, Spanned};

/// Reads the relief that `file` names for `pattern`, if any: one period with a cavity at its centre, as `surface
/// --cavities --period-out` writes it. A relief of grooves may be turned by a right angle.
///
/// # Errors
/// [`Diagnostic`] if the file cannot be read or is no map, if its period differs or its cavity is off centre, or if
/// rims are given as well.
pub fn read_relief(
    document: &Document,
    file: &Spanned<PatternFile>,
    pattern: &Pattern,
) -> Result<Option<Arc<ReliefMap>>, Diagnostic> {
    let Some(key) = &file.get_ref().relief else { return Ok(None) };
    if pattern.texture().rim().is_some() {
        return Err(document
            .refuse(key.span(), "stands beside rims, which a measured relief holds already")
            .expected("either relief or the keys of rims"));
    }
    let path = existing(document, key, key.get_ref())?;
    let mut map = open(document.source(), &path, &ReadOptions::default(), &Unwatched)?.map;
    map.fill_missing(&Unwatched);
    let relief = relief_of(&map).and_then(|relief| relief.along(pattern));
    let relief = relief.and_then(|relief| relief.lands(pattern).map(|_| relief));
    let relief = relief.map_err(|error| document.refuse(key.span(), error.to_string()))?;
    Ok(Some(Arc::new(relief)))
}

/// Converts `map`, whose rows follow one another along x, to a relief.
fn relief_of(map: &HeightMap) -> Result<ReliefMap, slipgrid_model::pattern::PatternError> {
    let [nx, ny] = [map.rows(), map.cols()];
    let heights_m = (0..nx * ny).map(|n| map.heights_m()[n % nx * ny + n / nx]).collect();
    ReliefMap::new([nx as f64 * map.dx_m(), ny as f64 * map.dy_m()], [nx, ny], heights_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_a_map_follow_each_other_along_x() {
        let map = HeightMap::new(2, 3, 2e-6, 1e-6, vec![0.0, 1e-6, 2e-6, 3e-6, 4e-6, 5e-6]).unwrap();
        let expected = ReliefMap::new([4e-6, 3e-6], [2, 3], vec![0.0, 3e-6, 1e-6, 4e-6, 2e-6, 5e-6]).unwrap();
        assert_eq!(relief_of(&map).unwrap(), expected);
    }
}
