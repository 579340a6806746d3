//! Division of a lattice into strips of columns, with the coefficients of its linear springs.
//!
//! Inside, coefficients are constant; rows at the counterface or at a cavity, and the two free sides, have individual
//! coefficients for every spring. The rows of a strip are close enough together for the translation buffer and the
//! caches. Strips are also the unit of work of threads. The division depends on the lattice only, and sums are computed
//! strip by strip, so that results do not depend on the number of threads. Units: k = 1, l = 1, m = 1.

use std::ops::Range;

use pulp::{Simd, WithSimd};

use super::real::Real;
use super::rows::{Field, INSIDE, RowCoefficients, Site};
use crate::springblock::Lattice;
use slipgrid_base::fft::vectorized;

/// Maximum number of columns of a strip, apart from rounding to whole cache lines: twenty rows of this length fill a
/// sixth of a second-level cache.
const STRIP_COLUMNS: usize = 256;

/// Vertical balance of the bulk: sum over the top blocks of [yy (H - u_y) + xy (X - u_x)] = -load, with the
/// displacements (X, H) of the bulk and (u_x, u_y) of a block. The fields are the sums of yy and of xy over the top
/// blocks, in units of the spring stiffness k.
#[derive(Clone, Copy, Debug)]
pub struct BulkBalance {
    yy: f64,
    xy: f64,
}

impl BulkBalance {
    /// Vertical displacement of the bulk at the horizontal displacement `bulk_x` under the load `load`; `top_row_force`
    /// is the sum of [`StripStencil::top_row_force`] over the strips. Units: k = 1, l = 1.
    pub fn height(&self, top_row_force: f64, bulk_x: f64, load: f64) -> f64 {
        (top_row_force - self.xy * bulk_x - load) / self.yy
    }
}

/// Spring stiffnesses and inverse masses of one strip, in units of spring stiffness k and block mass m.
#[derive(Clone, Debug)]
pub struct StripStencil<R> {
    /// Columns of the strip in the lattice.
    pub columns: Range<usize>,
    /// Rows with individual coefficients for every spring, from the counterface up.
    pub general: Vec<RowCoefficients<R>>,
    /// For each free side, the column index in the strip, and the blocks of this column above the general rows, bottom
    /// to top.
    pub sides: Vec<(usize, Vec<Site>)>,
    to_bulk_yy: Vec<f64>,
    /// Columns at free sides, whose springs to the bulk couple x and y, with the xy coefficient of these springs in
    /// units of k.
    to_bulk_xy: Vec<(usize, f64)>,
}

impl<R: Real> StripStencil<R> {
    /// Vertical force of the top row on the bulk at zero displacement of the bulk, in units of k l (spring stiffness
    /// times lattice spacing).
    pub fn top_row_force(&self, field: &Field<R>) -> f64 {
        let top = field.index(0, field.ny - 1);
        let row = |component: usize| &field.now[component].rows()[top..][..field.nx];
        let sideways: f64 = self.to_bulk_xy.iter().map(|(i, xy)| xy * row(0)[*i].to_f64()).sum();
        weighted_sum(&self.to_bulk_yy, row(1)) + sideways
    }
}

/// First column of each strip of a lattice with `nx` columns, followed by `nx`.
fn cuts<R: Real>(nx: usize) -> Vec<usize> {
    let strips = nx.div_ceil(STRIP_COLUMNS);
    // Strips have whole cache lines, except for the last one.
    let mut cuts: Vec<usize> = (0..strips).map(|s| nx * s / strips / R::LINE * R::LINE).collect();
    cuts.push(nx);
    cuts
}

/// Divides a lattice of whole blocks of equal width into strips; returns their stencil coefficients, and the vertical
/// force balance of the bulk.
pub fn strips<R: Real>(lattice: &Lattice) -> (Vec<StripStencil<R>>, BulkBalance) {
    let (nx, ny) = (lattice.nx(), lattice.ny());
    let mut sites = vec![Site::default(); nx * ny];
    let (mut to_bulk_yy, mut to_bulk_xy) = (vec![0.0; nx], vec![0.0; nx]);
    lattice.for_each_bond(|bond| {
        let (i, j) = bond.a;
        let k = bond.stiffness;
        // Index of the spring among those of the first block; that of the second block has the next index.
        let spring = match bond.rest {
            [x, 0.0] if x > 0.0 => 0,
            [0.0, _] => 2,
            [x, _] if x > 0.0 => 4,
            _ => 6,
        };
        sites[j * nx + i].springs[spring] = k;
        match bond.b {
            Some((bi, bj)) => sites[bj * nx + bi].springs[spring + 1] = k,
            None => {
                let [_, kxy, kyy] = bond.linear();
                to_bulk_yy[i] += kyy;
                to_bulk_xy[i] += kxy;
            }
        }
    });
    for (number, site) in sites.iter_mut().enumerate() {
        let mass = lattice.mass(number % nx, number / nx);
        site.inverse_mass = if mass > 0.0 { 1.0 / mass } else { 0.0 };
    }
    let balance = BulkBalance { yy: to_bulk_yy.iter().sum(), xy: to_bulk_xy.iter().sum() };
    let inside = Site { springs: INSIDE, inverse_mass: 1.0 };
    let strips = cuts::<R>(nx)
        .windows(2)
        .map(|cut| {
            let columns = cut[0]..cut[1];
            let row = |j: usize| &sites[j * nx..][columns.clone()];
            let at_side = |i: usize| !lattice.is_periodic() && (i == 0 || i + 1 == nx);
            let is_inside = |j: usize| columns.clone().zip(row(j)).all(|(i, site)| at_side(i) || *site == inside);
            // The contact row is always general, because its forces are needed separately from its motion.
            let inside_from = (1..ny).rev().take_while(|&j| is_inside(j)).last().unwrap_or(ny);
            let general = (0..inside_from).map(|j| RowCoefficients::new(row(j))).collect();
            let sides = columns
                .clone()
                .filter(|&i| at_side(i))
                .map(|i| (i - columns.start, (inside_from..ny).map(|j| sites[j * nx + i]).collect()))
                .collect();
            let to_bulk_yy = to_bulk_yy[columns.clone()].to_vec();
            let own_xy = to_bulk_xy[columns.clone()].iter().copied().enumerate();
            let to_bulk_xy = own_xy.filter(|(_, xy)| *xy != 0.0).collect();
            StripStencil { columns, general, sides, to_bulk_yy, to_bulk_xy }
        })
        .collect();
    (strips, balance)
}

/// Number of partial sums of a long sum: fixed, so that the result does not depend on the vector width.
const PARTS: usize = 16;

struct WeightedSum<'a, R>(&'a [f64], &'a [R]);

impl<R: Real> WithSimd for WeightedSum<'_, R> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f64 {
        let (a, b) = (self.0.chunks_exact(PARTS), self.1.chunks_exact(PARTS));
        let rest: f64 = a.remainder().iter().zip(b.remainder()).map(|(a, b)| a * b.to_f64()).sum();
        let mut parts = [0.0; PARTS];
        for (a, b) in a.zip(b) {
            for ((part, a), b) in parts.iter_mut().zip(a).zip(b) {
                *part += a * b.to_f64();
            }
        }
        parts.iter().sum::<f64>() + rest
    }
}

/// Sum of a[i] b[i] in double precision; the order of additions does not depend on the vector width.
fn weighted_sum<R: Real>(a: &[f64], b: &[R]) -> f64 {
    vectorized(WeightedSum(a, b))
}

struct FixedSum<'a, R>(&'a [R]);

impl<R: Real> WithSimd for FixedSum<'_, R> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f64 {
        let chunks = self.0.chunks_exact(PARTS);
        let rest: f64 = chunks.remainder().iter().map(|value| value.to_f64()).sum();
        let mut parts = [0.0; PARTS];
        for chunk in chunks {
            for (part, value) in parts.iter_mut().zip(chunk) {
                *part += value.to_f64();
            }
        }
        parts.iter().sum::<f64>() + rest
    }
}

/// Sum of `values` in double precision; the order of additions does not depend on the vector width.
pub fn fixed_sum<R: Real>(values: &[R]) -> f64 {
    vectorized(FixedSum(values))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_cover_every_column_once_in_whole_lines() {
        for nx in [1, 50, 256, 257, 996, 100_000] {
            let cuts = cuts::<f32>(nx);
            assert!(cuts[0] == 0 && cuts[cuts.len() - 1] == nx);
            assert!(cuts.windows(2).all(|w| w[0] < w[1] && w[1] - w[0] <= STRIP_COLUMNS + f32::LINE));
            assert!(cuts[..cuts.len() - 1].iter().all(|cut| cut.is_multiple_of(f32::LINE)));
        }
    }

    #[test]
    fn sums_are_sums() {
        let values: Vec<f64> = (0..101).map(f64::from).collect();
        assert_eq!(fixed_sum(&values), 5050.0);
        assert_eq!(weighted_sum(&values, &values), 338_350.0);
    }
}
