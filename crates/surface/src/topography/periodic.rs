//! Checks whether a map is one period of a surface, and makes it one if it is not.

use std::f64::consts::TAU;

use slipgrid_base::monitor::Monitor;

use crate::topography::fourier::Fourier;
use crate::topography::{HeightMap, MapError};

/// Rms step across opposite sides of `map` over the rms step between neighbouring points: the larger of the ratios
/// along x and along y. About 1 for one period of a surface; large for a window of a smooth surface, whose opposite
/// sides are unrelated. 1 for a flat map.
///
/// # Errors
/// [`MapError`] if points are missing, and once `monitor` cancels.
pub fn side_step_ratio(map: &HeightMap, monitor: &dyn Monitor) -> Result<f64, MapError> {
    map.require_complete()?;
    let (rows, cols, height) = (map.rows(), map.cols(), map.heights_m());
    let ratio = |count: usize, points: usize, at: &dyn Fn(usize, usize) -> usize| -> Result<f64, MapError> {
        let steps = |from: usize, to: usize| -> Result<f64, MapError> {
            monitor.heed()?;
            Ok((0..points).map(|n| (height[at(to, n)] - height[at(from, n)]).powi(2)).sum())
        };
        let across = steps(count - 1, 0)?;
        let between = (1..count).map(|line| steps(line - 1, line)).sum::<Result<f64, _>>()? / (count.max(2) - 1) as f64;
        Ok(if across > 0.0 { (across / between).sqrt() } else { 0.0 })
    };
    let along_x = ratio(rows, cols, &|i, j| i * cols + j)?;
    let along_y = ratio(cols, rows, &|j, i| i * cols + j)?;
    let larger = along_x.max(along_y);
    Ok(if larger > 0.0 { larger } else { 1.0 })
}

/// Periodic component of `map`, which has no step across its sides and differs from the map by a field that is as
/// smooth as the steps allow.
///
/// L. Moisan, J. Math. Imaging Vis. 39, 161 (2011): the smooth field s solves Lap s = v with the periodic five-point
/// Laplacian and mean 0; v holds the steps across opposite sides, at the points along these sides. A map that is one
/// period of a smooth surface changes only by as much as the surface varies from one point to the next.
///
/// # Errors
/// [`MapError`] if points are missing, and once `monitor` cancels.
pub fn periodic_component(map: &HeightMap, monitor: &dyn Monitor) -> Result<HeightMap, MapError> {
    map.require_complete()?;
    let (rows, cols, height) = (map.rows(), map.cols(), map.heights_m());
    let mut steps = vec![0.0; height.len()];
    let along_x = (0..cols).map(|j| (j, (rows - 1) * cols + j));
    let along_y = (0..rows).map(|i| (i * cols, (i + 1) * cols - 1));
    for (first, last) in along_x.chain(along_y) {
        let step = height[last] - height[first];
        steps[first] += step;
        steps[last] -= step;
    }
    let fourier = Fourier::new(rows, cols);
    // s_kl = v_kl / (2 cos(2 pi k/rows) + 2 cos(2 pi l/cols) - 4)
    let cosines = |n: usize| (0..=n / 2).map(|k| (TAU * k as f64 / n as f64).cos()).collect::<Vec<f64>>();
    let (along_x, along_y) = (cosines(rows), cosines(cols));
    let inverse_laplacian =
        fourier.wave_multiplier(|k, l| if k == 0 && l == 0 { 0.0 } else { 0.5 / (along_x[k] + along_y[l] - 2.0) });
    let mut smooth = vec![0.0; height.len()];
    monitor.heed()?;
    fourier.filter(&steps, &inverse_laplacian, &mut smooth, &mut fourier.work_watched(monitor));
    monitor.heed()?;
    let periodic = height.iter().zip(&smooth).map(|(h, s)| h - s).collect();
    HeightMap::new(rows, cols, map.dx_m(), map.dy_m(), periodic)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topography::{Crop, SelfAffine};
    use slipgrid_base::monitor::Unwatched;

    fn period() -> HeightMap {
        SelfAffine { pixels: 64, max_wave: 8, ..SelfAffine::STAND_IN }.map().unwrap()
    }

    /// A window of the period: 40 x 48 of its points.
    fn window() -> HeightMap {
        period().windowed(Some(Crop { first_row: 0, first_col: 0, rows: 40, cols: 48 }), None).unwrap()
    }

    #[test]
    fn the_periodic_component_differs_by_a_smooth_field() {
        let map = window();
        let periodic = periodic_component(&map, &Unwatched).unwrap();
        let (rows, cols) = (map.rows(), map.cols());
        let smooth: Vec<f64> = map.heights_m().iter().zip(periodic.heights_m()).map(|(h, p)| h - p).collect();
        // Away from the sides the removed field is harmonic on the grid; its mean is zero.
        for i in 1..rows - 1 {
            for j in 1..cols - 1 {
                let at = |i: usize, j: usize| smooth[i * cols + j];
                let laplacian = at(i - 1, j) + at(i + 1, j) + at(i, j - 1) + at(i, j + 1) - 4.0 * at(i, j);
                assert!(laplacian.abs() < 1e-12 * map.sq_m(), "{laplacian}");
            }
        }
        assert!((map.mean_m() - periodic.mean_m()).abs() < 1e-12 * map.sq_m());
        // The steps across the sides fall from several times the steps between neighbours to the same size.
        assert!(side_step_ratio(&map, &Unwatched).unwrap() > 3.0);
        assert!(side_step_ratio(&periodic, &Unwatched).unwrap() < 1.5);
        assert!(side_step_ratio(&period(), &Unwatched).unwrap() < 1.5);
    }

    #[test]
    fn a_tilt_is_no_part_of_a_period() {
        let height = (0..32 * 24).map(|n| 1e-6 * (n / 24) as f64 - 3e-7 * (n % 24) as f64).collect();
        let tilted = HeightMap::new(32, 24, 1e-6, 1e-6, height).unwrap();
        assert!((side_step_ratio(&tilted, &Unwatched).unwrap() - 31.0).abs() < 1e-9);
        assert!(periodic_component(&tilted, &Unwatched).unwrap().sq_m() < 0.1 * tilted.sq_m());
        let flat = HeightMap::new(4, 4, 1e-6, 1e-6, vec![2e-6; 16]).unwrap();
        assert_eq!(side_step_ratio(&flat, &Unwatched).unwrap(), 1.0);
        assert_eq!(periodic_component(&flat, &Unwatched).unwrap(), flat);
    }
}
