//! Missing points are filled by the harmonic surface: each filled height is the mean of its neighbours
//! (weighted 1/dx^2 and 1/dy^2), so that a hole becomes the smoothest surface through its rim, without new
//! summits or pits. The linear system is solved by conjugate gradients with a diagonal preconditioner.

use crate::HeightMap;

/// What filling missing points took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Filling {
    /// Points that were missing and now have a height.
    pub points: usize,
    /// Iterations of the solver.
    pub iterations: usize,
    /// Norm of the residual over its initial value.
    pub residual: f64,
    /// The residual is below 1e-10; otherwise the limit of iterations was met and heights are approximate.
    pub converged: bool,
}

/// Residual, relative to the start, at which heights are as good as the measurement's digits.
const TOLERANCE: f64 = 1e-10;
/// Iterations allowed per row and column of the map: a hole needs about its diameter, more if it is ragged.
const ITERATIONS_PER_LINE: usize = 20;
/// Most visits of a missing point, a minute or two: it bounds the work on a map that is hardly there.
const MOST_VISITS: usize = 20_000_000_000;

/// The missing points as unknowns of a linear system, their neighbours' places worked out once.
struct Holes {
    /// Where each unknown stands in the map.
    node: Vec<usize>,
    rows: usize,
    cols: usize,
    /// 1/dx^2 and 1/dy^2, over their sum.
    weight: [f64; 2],
}

impl Holes {
    /// Calls `visit(neighbour, weight)` for the neighbours of `node` on the map.
    fn neighbours(&self, node: usize, mut visit: impl FnMut(usize, f64)) {
        let (i, j) = (node / self.cols, node % self.cols);
        if i > 0 {
            visit(node - self.cols, self.weight[0]);
        }
        if i + 1 < self.rows {
            visit(node + self.cols, self.weight[0]);
        }
        if j > 0 {
            visit(node - 1, self.weight[1]);
        }
        if j + 1 < self.cols {
            visit(node + 1, self.weight[1]);
        }
    }

    fn diagonal(&self, node: usize) -> f64 {
        let mut sum = 0.0;
        self.neighbours(node, |_, weight| sum += weight);
        sum
    }
}

impl HeightMap {
    /// Fills missing points with the harmonic surface through the points around them; the others stay as
    /// they are. At the map's sides the surface meets the side squarely.
    pub fn fill_missing(&mut self) -> Filling {
        let missing: Vec<usize> =
            self.heights_m().iter().enumerate().filter(|(_, h)| h.is_nan()).map(|(n, _)| n).collect();
        if missing.is_empty() {
            return Filling { points: 0, iterations: 0, residual: 0.0, converged: true };
        }
        let stiffness = [self.dx_m().powi(-2), self.dy_m().powi(-2)];
        let holes = Holes {
            node: missing,
            rows: self.rows(),
            cols: self.cols(),
            weight: stiffness.map(|value| value / (stiffness[0] + stiffness[1])),
        };
        // Unknowns are deviations from the mean, which is also the start.
        let mean_m = self.mean_m();
        for &node in &holes.node {
            self.heights_mut()[node] = mean_m;
        }
        let (deviation, filling) = solve(&holes, self.heights_m(), mean_m);
        for (&node, value) in holes.node.iter().zip(&deviation) {
            self.heights_mut()[node] = mean_m + value;
        }
        filling
    }
}

/// Preconditioned conjugate gradients for sum over neighbours of w (h - h_neighbour) = 0 at each hole.
/// Holes stand at the mean in `height`, so that what their neighbours contribute is what is known.
fn solve(holes: &Holes, height: &[f64], mean_m: f64) -> (Vec<f64>, Filling) {
    let count = holes.node.len();
    let diagonal: Vec<f64> = holes.node.iter().map(|&node| holes.diagonal(node)).collect();
    let mut residual: Vec<f64> = holes
        .node
        .iter()
        .map(|&node| {
            let mut sum = 0.0;
            holes.neighbours(node, |neighbour, weight| sum += weight * (height[neighbour] - mean_m));
            sum
        })
        .collect();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let mut solution = vec![0.0; count];
    // The direction lives on the whole map, zero where heights are known.
    let mut direction = vec![0.0; height.len()];
    let mut image = vec![0.0; count];
    let start = dot(&residual, &residual).sqrt();
    let most = (ITERATIONS_PER_LINE * (holes.rows + holes.cols)).min(MOST_VISITS / count.max(1));
    let mut previous = f64::INFINITY;
    let mut iterations = 0;
    let mut relative = if start > 0.0 { 1.0 } else { 0.0 };
    while relative > TOLERANCE && iterations < most {
        // z = r / diag;  d = z + (r.z / previous r.z) d
        let fit: f64 = residual.iter().zip(&diagonal).map(|(r, d)| r * r / d).sum();
        let beta = fit / previous;
        for ((&node, r), diag) in holes.node.iter().zip(&residual).zip(&diagonal) {
            direction[node] = r / diag + beta * direction[node];
        }
        previous = fit;
        let mut curvature = 0.0;
        for ((&node, diag), image) in holes.node.iter().zip(&diagonal).zip(&mut image) {
            let mut sum = 0.0;
            holes.neighbours(node, |neighbour, weight| sum += weight * direction[neighbour]);
            *image = diag * direction[node] - sum;
            curvature += direction[node] * *image;
        }
        let step = fit / curvature;
        for (n, &node) in holes.node.iter().enumerate() {
            solution[n] += step * direction[node];
            residual[n] -= step * image[n];
        }
        relative = dot(&residual, &residual).sqrt() / start;
        iterations += 1;
    }
    (solution, Filling { points: count, iterations, residual: relative, converged: relative <= TOLERANCE })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_harmonic_surface_is_restored_exactly() {
        // x y and the plane are harmonic on the grid, also with dx != dy.
        let height = |n: usize| {
            let (i, j) = ((n / 30) as f64, (n % 30) as f64);
            1e-6 + 2e-8 * i - 1e-8 * j + 3e-9 * i * j
        };
        let hole = |n: usize| (5..15).contains(&(n / 30)) && (10..28).contains(&(n % 30)) || n == 35;
        let heights = (0..600).map(|n| if hole(n) { f64::NAN } else { height(n) }).collect();
        let mut map = HeightMap::new(20, 30, 1e-6, 3e-6, heights).unwrap();
        let filling = map.fill_missing();
        assert!(filling.converged && filling.points == 181 && filling.iterations < 100, "{filling:?}");
        assert_eq!(map.missing(), 0);
        for (n, &h) in map.heights_m().iter().enumerate() {
            assert!((h - height(n)).abs() < 1e-15, "{n}: {h}");
        }
    }

    #[test]
    fn filled_heights_stay_between_those_present() {
        // Everything is missing but a few points, one of them in a corner.
        let mut heights = vec![f64::NAN; 40 * 50];
        heights[0] = -1e-6;
        heights[777] = 2e-6;
        heights[1999] = 0.5e-6;
        let mut map = HeightMap::new(40, 50, 1e-6, 1e-6, heights).unwrap();
        let filling = map.fill_missing();
        assert!(filling.converged, "{filling:?}");
        assert!(map.heights_m().iter().all(|h| (-1e-6 - 1e-14..=2e-6 + 1e-14).contains(h)));
        assert_eq!(map.heights_m()[777], 2e-6);
    }

    #[test]
    fn constant_heights_and_complete_maps_need_no_work() {
        let mut map = HeightMap::new(2, 2, 1e-6, 1e-6, vec![3e-6, f64::NAN, 3e-6, 3e-6]).unwrap();
        assert_eq!(map.fill_missing().iterations, 0);
        assert_eq!(map.heights_m(), [3e-6; 4]);
        assert_eq!(map.fill_missing(), Filling { points: 0, iterations: 0, residual: 0.0, converged: true });
    }
}
