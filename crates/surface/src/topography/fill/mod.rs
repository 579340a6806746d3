//! Fills missing points by the harmonic surface.
//!
//! Each filled height is the mean of its neighbours (weighted by 1/dx^2 and 1/dy^2), so that a hole becomes the
//! smoothest surface through its rim, without new summits or pits. The linear system is solved by conjugate gradients
//! with a multigrid preconditioner, to a residual of 1e-10 of the initial one, in a dozen or two iterations whatever
//! the size of the holes.

mod multigrid;

use multigrid::{Level, Multigrid, NONE};
use slipgrid_base::monitor::Monitor;
use slipgrid_base::statistics::cholesky::dot;

use crate::topography::HeightMap;

/// Statistics of filling missing points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Filling {
    /// Number of points that were missing and now have a height.
    pub points: usize,
    /// Number of iterations of the solver.
    pub iterations: usize,
    /// Norm of the residual relative to its initial value.
    pub residual: f64,
    /// Whether the residual is at most 1e-10; if not, the limit on iterations was reached and the heights are
    /// approximate.
    pub converged: bool,
}

/// Relative residual at which heights are as accurate as the digits of a measurement.
const TOLERANCE: f64 = 1e-10;
/// Limit on iterations: one or two dozen suffice at any map size, ragged holes need more.
const MAX_ITERATIONS: usize = 300;

/// The missing points, as unknowns of a linear system.
struct Holes {
    /// Multigrid levels of ever fewer unknowns; the first holds the missing points.
    multigrid: Multigrid,
    rows: usize,
    cols: usize,
    /// Weights of neighbours along x and along y: 1/dx^2 and 1/dy^2, divided by their sum.
    weight: [f64; 2],
}

impl Holes {
    /// Index of each unknown in the map.
    fn nodes(&self) -> &[u32] {
        &self.finest().cell
    }

    fn finest(&self) -> &Level {
        &self.multigrid.levels[0]
    }

    /// Sum of w (h - h_neighbour) over the neighbours of unknown `n`, with the heights h in `height`, the weights w,
    /// and known neighbours counted as zero.
    fn stiffness(&self, n: usize, height: &[f64]) -> f64 {
        let level = self.finest();
        let (node, [across, along]) = (level.cell[n] as usize, self.weight);
        let (i, j) = (node / self.cols, node % self.cols);
        let edges = |first: bool, last: bool| f64::from(2 - u8::from(first) - u8::from(last));
        let mut sum =
            (across * edges(i == 0, i + 1 == self.rows) + along * edges(j == 0, j + 1 == self.cols)) * height[n];
        if level.has_right(n) {
            sum -= along * height[n + 1];
        }
        if level.has_left(n) {
            sum -= along * height[n - 1];
        }
        for neighbour in [level.up[n], level.down[n]] {
            if neighbour != NONE {
                sum -= across * height[neighbour as usize];
            }
        }
        sum
    }

    /// Weighted sum of (height - `mean_m`) over the neighbours of unknown `n`; missing neighbours hold `mean_m` and add
    /// nothing.
    fn known_neighbour_sum(&self, n: usize, height: &[f64], mean_m: f64) -> f64 {
        let (node, [across, along], cols) = (self.nodes()[n] as usize, self.weight, self.cols);
        let (i, j) = (node / cols, node % cols);
        let mut sum = 0.0;
        let mut add = |there: bool, neighbour: usize, weight: f64| {
            if there {
                sum += weight * (height[neighbour] - mean_m);
            }
        };
        add(i > 0, node.wrapping_sub(cols), across);
        add(i + 1 < self.rows, node + cols, across);
        add(j > 0, node.wrapping_sub(1), along);
        add(j + 1 < cols, node + 1, along);
        sum
    }
}

impl HeightMap {
    /// Fills missing points with the harmonic surface through the surrounding points; all other heights stay as they
    /// are. At the map's sides the surface has zero normal slope. Ends once `monitor` cancels; the filled heights must
    /// then not be used.
    pub fn fill_missing(&mut self, monitor: &dyn Monitor) -> Filling {
        // The indices fit in a u32: a map has at most 2^28 points.
        let missing: Vec<u32> =
            self.heights_m().iter().enumerate().filter(|(_, h)| h.is_nan()).map(|(n, _)| n as u32).collect();
        if missing.is_empty() {
            return Filling { points: 0, iterations: 0, residual: 0.0, converged: true };
        }
        let stiffness = [self.dx_m().powi(-2), self.dy_m().powi(-2)];
        let (rows, cols) = (self.rows(), self.cols());
        let weight = stiffness.map(|value| value / (stiffness[0] + stiffness[1]));
        // The unknowns are deviations from the mean, and the initial values are zero.
        let mean_m = self.mean_m();
        for &node in &missing {
            self.heights_mut()[node as usize] = mean_m;
        }
        let mut holes = Holes { multigrid: Multigrid::new(missing, [rows, cols], weight, monitor), rows, cols, weight };
        let (deviation, filling) = solve(&mut holes, self.heights_m(), mean_m, monitor);
        for (&node, value) in holes.nodes().iter().zip(&deviation) {
            self.heights_mut()[node as usize] = mean_m + value;
        }
        filling
    }
}

/// Solves sum over neighbours of w (h - h_neighbour) = 0 at each missing point by preconditioned conjugate gradients;
/// returns the heights relative to `mean_m`. The missing points hold `mean_m` in `height`, so that the sum over all
/// neighbours is that over the known ones.
fn solve(holes: &mut Holes, height: &[f64], mean_m: f64, monitor: &dyn Monitor) -> (Vec<f64>, Filling) {
    let count = holes.nodes().len();
    let mut residual: Vec<f64> = (0..count).map(|n| holes.known_neighbour_sum(n, height, mean_m)).collect();
    let mut solution = vec![0.0; count];
    let mut direction = vec![0.0; count];
    let mut image = vec![0.0; count];
    let start = dot(&residual, &residual).sqrt();
    let mut previous = f64::INFINITY;
    let mut iterations = 0;
    let mut relative = if start > 0.0 { 1.0 } else { 0.0 };
    while relative > TOLERANCE && iterations < MAX_ITERATIONS && !monitor.cancelled() {
        // z = B r with B one multigrid cycle, on numbers scaled to about 1;  d = z + (r.z / previous r.z) d
        let scale = start * relative;
        let finest = &mut holes.multigrid.levels[0];
        for (right_side, r) in finest.right_side.iter_mut().zip(&residual) {
            *right_side = (r / scale) as f32;
        }
        holes.multigrid.precondition(monitor);
        let preconditioned = &holes.finest().solution;
        let fit: f64 = residual.iter().zip(preconditioned).map(|(r, z)| r * f64::from(*z)).sum::<f64>() * scale;
        let beta = fit / previous;
        for (direction, z) in direction.iter_mut().zip(preconditioned) {
            *direction = scale * f64::from(*z) + beta * *direction;
        }
        previous = fit;
        let mut curvature = 0.0;
        for n in 0..count {
            image[n] = holes.stiffness(n, &direction);
            curvature += direction[n] * image[n];
        }
        let step = fit / curvature;
        for (n, (solution, residual)) in solution.iter_mut().zip(&mut residual).enumerate() {
            *solution += step * direction[n];
            *residual -= step * image[n];
        }
        relative = dot(&residual, &residual).sqrt() / start;
        iterations += 1;
    }
    (solution, Filling { points: count, iterations, residual: relative, converged: relative <= TOLERANCE })
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_base::monitor::Unwatched;

    #[test]
    fn a_harmonic_surface_is_restored_exactly() {
        // x y and the plane are harmonic on the grid, also for dx != dy.
        let height = |n: usize| {
            let (i, j) = ((n / 30) as f64, (n % 30) as f64);
            1e-6 + 2e-8 * i - 1e-8 * j + 3e-9 * i * j
        };
        let hole = |n: usize| (5..15).contains(&(n / 30)) && (10..28).contains(&(n % 30)) || n == 35;
        let heights = (0..600).map(|n| if hole(n) { f64::NAN } else { height(n) }).collect();
        let mut map = HeightMap::new(20, 30, 1e-6, 3e-6, heights).unwrap();
        let filling = map.fill_missing(&Unwatched);
        assert!(filling.converged && filling.points == 181 && filling.iterations < 100, "{filling:?}");
        assert_eq!(map.missing(), 0);
        for (n, &h) in map.heights_m().iter().enumerate() {
            assert!((h - height(n)).abs() < 1e-15, "{n}: {h}");
        }
    }

    #[test]
    fn filled_heights_stay_between_those_present() {
        // All points are missing but a few, one of them in a corner.
        let mut heights = vec![f64::NAN; 40 * 50];
        heights[0] = -1e-6;
        heights[777] = 2e-6;
        heights[1999] = 0.5e-6;
        let mut map = HeightMap::new(40, 50, 1e-6, 1e-6, heights).unwrap();
        let filling = map.fill_missing(&Unwatched);
        assert!(filling.converged, "{filling:?}");
        assert!(map.heights_m().iter().all(|h| (-1e-6 - 1e-14..=2e-6 + 1e-14).contains(h)));
        assert_eq!(map.heights_m()[777], 2e-6);
    }

    #[test]
    fn constant_heights_and_complete_maps_need_no_work() {
        let mut map = HeightMap::new(2, 2, 1e-6, 1e-6, vec![3e-6, f64::NAN, 3e-6, 3e-6]).unwrap();
        assert_eq!(map.fill_missing(&Unwatched).iterations, 0);
        assert_eq!(map.heights_m(), [3e-6; 4]);
        assert_eq!(map.fill_missing(&Unwatched), Filling { points: 0, iterations: 0, residual: 0.0, converged: true });
    }

    /// Gauss-Seidel sweeps until the heights no longer change: slow, but independent of the solver tested.
    fn gauss_seidel_reference(map: &HeightMap) -> Vec<f64> {
        let (rows, cols) = (map.rows(), map.cols());
        let weight = [map.dx_m().powi(-2), map.dy_m().powi(-2)];
        let missing: Vec<usize> = (0..rows * cols).filter(|&n| map.heights_m()[n].is_nan()).collect();
        let mut heights: Vec<f64> =
            map.heights_m().iter().map(|height| if height.is_nan() { map.mean_m() } else { *height }).collect();
        for _ in 0..20_000 {
            let mut moved: f64 = 0.0;
            for &n in &missing {
                let (i, j) = (n / cols, n % cols);
                let (mut sum, mut weights) = (0.0, 0.0);
                for (there, other, weight) in [
                    (i > 0, n.wrapping_sub(cols), weight[0]),
                    (i + 1 < rows, n + cols, weight[0]),
                    (j > 0, n.wrapping_sub(1), weight[1]),
                    (j + 1 < cols, n + 1, weight[1]),
                ] {
                    if there {
                        sum += weight * heights[other];
                        weights += weight;
                    }
                }
                moved = moved.max((sum / weights - heights[n]).abs());
                heights[n] = sum / weights;
            }
            if moved < 1e-19 {
                break;
            }
        }
        heights
    }

    /// A rough surface on `side` x `side` pixels of 1 um x `dy`, with the points `missing` missing.
    fn holed(side: usize, dy_m: f64, missing: impl Fn(f64, f64, f64) -> bool) -> HeightMap {
        let heights = (0..side * side).map(|n| {
            let (u, v) = ((n / side) as f64 / side as f64 - 0.5, (n % side) as f64 / side as f64 - 0.5);
            let noise = (12.9898 * n as f64).sin() * 43_758.545_3;
            let noise = noise - noise.floor();
            if missing(u, v, noise) { f64::NAN } else { 1e-6 * ((20.0 * u).sin() * (31.0 * v).cos() + noise) }
        });
        HeightMap::new(side, side, 1e-6, dy_m, heights.collect()).unwrap()
    }

    #[test]
    fn holes_of_any_shape_are_filled_as_slow_sweeps_fill_them() {
        type Missing = fn(f64, f64, f64) -> bool;
        // Missing points: those outside a round field, every second point, a square and a few points beside it, and
        // nineteen of twenty.
        let shapes: [Missing; 4] = [
            |u, v, _| u.hypot(v) > 0.5,
            |_, _, noise| noise < 0.5,
            |u, v, noise| u.abs().max(v.abs()) < 0.3 || noise < 0.1,
            |_, _, noise| noise > 0.05,
        ];
        for (shape, dy_m) in shapes.into_iter().zip([1e-6, 0.5e-6, 2.5e-6, 1e-6]) {
            let mut map = holed(61, dy_m, shape);
            let expected = gauss_seidel_reference(&map);
            let filling = map.fill_missing(&Unwatched);
            assert!(filling.converged && filling.residual <= TOLERANCE, "{filling:?}");
            for (found, expected) in map.heights_m().iter().zip(expected) {
                assert!((found - expected).abs() < 1e-14, "{found} {expected}");
            }
        }
    }

    #[test]
    fn a_ring_between_two_heights_is_the_logarithm() {
        // h = ln(r / 20) / ln(160 / 20) between circles of 20 and 160 pixels. The circles are staircases of pixels, so
        // the inner radius is known to one pixel of 20.
        let (side, inner, outer) = (340_usize, 20.0_f64, 160.0_f64);
        let exact = |n: usize| {
            let r = ((n / side) as f64 - 169.5).hypot((n % side) as f64 - 169.5);
            (r, (r / inner).ln() / (outer / inner).ln())
        };
        let heights = (0..side * side).map(|n| {
            let (r, h) = exact(n);
            if inner < r && r < outer { f64::NAN } else { 1e-6 * h.max(-1.0) }
        });
        let mut map = HeightMap::new(side, side, 1e-6, 1e-6, heights.collect()).unwrap();
        let filling = map.fill_missing(&Unwatched);
        assert!(filling.converged, "{filling:?}");
        for (n, height) in map.heights_m().iter().enumerate() {
            assert!((height * 1e6 - exact(n).1.max(-1.0)).abs() < 1e-3, "{:?}: {height}", exact(n));
        }
    }

    #[test]
    fn the_work_does_not_grow_with_the_holes() {
        for (side, dy_m) in [(64, 1e-6), (256, 1e-6), (768, 1e-6), (256, 3e-6)] {
            let filling = holed(side, dy_m, |u, v, _| u.hypot(v) > 0.5).fill_missing(&Unwatched);
            // Conjugate gradients without multigrid take 150, 600 and 1800 iterations.
            assert!(filling.converged && filling.iterations <= 30, "{side}: {filling:?}");
        }
        let filling = holed(512, 1e-6, |_, _, noise| noise > 0.06).fill_missing(&Unwatched);
        assert!(filling.converged && filling.iterations <= 30, "{filling:?}");
    }
}
