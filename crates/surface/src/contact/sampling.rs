//! Maps derived from a map: windows and coarser pixels.

use crate::topography::{Form, HeightMap, periodic_component};

use crate::contact::error::require_within;
use crate::contact::{ContactError, Monitor};

/// Divides `map` into `per_side` x `per_side` windows of equal size, in row order.
///
/// Each window is levelled by its least-squares plane and made periodic ([`periodic_component`]). Rows and columns that
/// do not fill a window are dropped.
///
/// # Errors
/// [`ContactError`] if points are missing, a window would have fewer than 16 points per side, or `monitor` cancels.
pub fn windows(map: &HeightMap, per_side: usize, monitor: &dyn Monitor) -> Result<Vec<HeightMap>, ContactError> {
    window_pixels(map, per_side)?;
    map.in_windows(per_side)
        .map(|window| {
            let mut window = window?;
            window.remove_form(Form::Plane, monitor)?;
            Ok(periodic_component(&window, monitor)?)
        })
        .collect()
}

/// Returns the numbers of rows and columns that each window has if `map` is divided into `per_side` x `per_side`
/// windows.
///
/// # Errors
/// [`ContactError`] if points are missing, or a window would have fewer than 16 points per side.
pub fn window_pixels(map: &HeightMap, per_side: usize) -> Result<[usize; 2], ContactError> {
    divided("number of windows per side", map, per_side)
}

/// Minimum number of points along the side of a window or of a coarser map.
const MIN_PIXELS: usize = 16;

/// Numbers of rows and columns of a complete `map` over `factor`, which `quantity` names in errors.
fn divided(quantity: &'static str, map: &HeightMap, factor: usize) -> Result<[usize; 2], ContactError> {
    map.require_complete()?;
    let most = (map.rows().min(map.cols()) / MIN_PIXELS) as f64;
    require_within(quantity, factor as f64, 1.0..=most, "from 1 to a sixteenth of the pixels per side")?;
    Ok([map.rows() / factor, map.cols() / factor])
}

/// Averages `map` over `factor` x `factor` points, as an instrument with larger pixels would.
///
/// Rows and columns that do not fill a pixel are dropped, so that a periodic map stays periodic only if `factor`
/// divides both sides.
///
/// # Errors
/// [`ContactError`] if points are missing, or fewer than 16 points per side would remain.
pub fn coarser(map: &HeightMap, factor: usize) -> Result<HeightMap, ContactError> {
    let [rows, cols] = divided("factor of coarser pixels", map, factor)?;
    let mut height = vec![0.0; rows * cols];
    for (i, line) in map.heights_m().chunks_exact(map.cols()).take(rows * factor).enumerate() {
        let target = &mut height[i / factor * cols..][..cols];
        for (sum, points) in target.iter_mut().zip(line.chunks_exact(factor)) {
            *sum += points.iter().sum::<f64>() / (factor * factor) as f64;
        }
    }
    let (dx_m, dy_m) = (map.dx_m() * factor as f64, map.dy_m() * factor as f64);
    Ok(HeightMap::new(rows, cols, dx_m, dy_m, height)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::Unwatched;
    use crate::topography::SelfAffine;

    fn period() -> HeightMap {
        SelfAffine { pixels: 64, max_wave: 8, ..SelfAffine::STAND_IN }.map().unwrap()
    }

    #[test]
    fn windows_are_level_pieces_of_the_map() {
        let map = period();
        let pieces = windows(&map, 3, &Unwatched).unwrap();
        assert_eq!(pieces.len(), 9);
        assert!(pieces.iter().all(|piece| (piece.rows(), piece.cols(), piece.dx_m()) == (21, 21, map.dx_m())));
        assert!(pieces.iter().all(|piece| piece.mean_m().abs() < 1e-9 * map.sq_m()));
        assert_ne!(pieces[0], pieces[1]);
        assert!(windows(&map, 5, &Unwatched).unwrap_err().to_string().contains("sixteenth"));
        assert!(windows(&map, 0, &Unwatched).is_err());
    }

    #[test]
    fn coarser_pixels_average() {
        let height = (0..32 * 33).map(|n| (n / 33) as f64 + 10.0 * (n % 33) as f64).collect();
        let map = HeightMap::new(32, 33, 1e-6, 2e-6, height).unwrap();
        let coarse = coarser(&map, 2).unwrap();
        assert_eq!((coarse.rows(), coarse.cols(), coarse.dx_m(), coarse.dy_m()), (16, 16, 2e-6, 4e-6));
        assert_eq!(coarse.heights_m()[0], 5.5);
        assert_eq!(coarse.heights_m()[16 + 1], 27.5);
        assert_eq!(coarser(&map, 1).unwrap().rows(), 32);
        assert!(coarser(&map, 3).is_err() && coarser(&map, 0).is_err());
    }
}
