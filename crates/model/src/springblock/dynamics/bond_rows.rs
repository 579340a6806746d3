//! Spring forces row by row, linear or geometrically exact, in vectors.
//!
//! Cost per block and evaluation with exact springs, four of them for each block: 4 square roots, 4 divisions, 64
//! additions and multiplications. A Zen 4 core takes 18 and 16 cycles for a square root and a division of eight
//! numbers, which makes 17 cycles per block; the other operations overlap with these.

use pulp::{Simd, WithSimd};

use crate::springblock::Springs;
use slipgrid_base::fft::vectorized;

/// Number of columns of a row that are evaluated together, so that their forces stay in the first-level cache for all
/// four kinds of springs.
const CHUNK: usize = 128;

/// Vectors along the four kinds of springs that belong to a block, at rest, in lattice spacings: right, up, up right,
/// and up left.
pub const KINDS: [[f64; 2]; 4] = [[1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [-1.0, 1.0]];

/// Springs between every block and its right and upper neighbours on a uniform mesh, with or without periodic sides.
///
/// In rows of up to [`CHUNK`] columns, the order in which the forces on a block are summed does not depend on the
/// position of the block.
#[derive(Clone, Debug)]
pub struct BondRows {
    columns: usize,
    law: Springs,
    /// Stiffness of every spring, in units of the spring stiffness k; the first index is the kind ([`KINDS`]), the
    /// second the block number j * nx + i for column i of row j. 0 where there is no spring. Upward springs of the last
    /// row end at the bulk.
    stiffness: [Vec<f64>; 4],
    /// Displacements x and y of the bulk, in lattice spacings, repeated for every column.
    bulk: [Vec<f64>; 2],
    /// Scratch space, by column, for the forces x and y of springs to the bulk.
    on_bulk: [Vec<f64>; 2],
}

impl BondRows {
    /// Creates a mesh of `columns` by `rows` blocks without springs.
    pub fn new(columns: usize, rows: usize, law: Springs) -> Self {
        let row = || [vec![0.0; columns], vec![0.0; columns]];
        let stiffness = KINDS.map(|_| vec![0.0; columns * rows]);
        Self { columns, law, stiffness, bulk: row(), on_bulk: row() }
    }

    /// Adds a spring of the kind `KINDS[kind]` to block number `block`; `stiffness` is in units of the spring stiffness
    /// k.
    pub fn add(&mut self, kind: usize, block: usize, stiffness: f64) {
        self.stiffness[kind][block] += stiffness;
    }

    /// Returns the sum of the vertical forces that the springs to the bulk exert on the layer, in units of k l (spring
    /// stiffness times lattice spacing). `u` and `bulk` are the displacements x and y of the blocks and of the bulk, in
    /// lattice spacings.
    pub fn pull(&mut self, u: &[Vec<f64>; 2], bulk: [f64; 2]) -> f64 {
        self.place_bulk(bulk);
        match self.law {
            Springs::Linear => vectorized(Pull::<false> { rows: self, u }),
            Springs::Exact => vectorized(Pull::<true> { rows: self, u }),
        }
    }

    /// Adds the forces of all springs on the blocks to `forces`, in units of k l (spring stiffness times lattice
    /// spacing). `u` and `bulk` are the displacements x and y of the blocks and of the bulk, in lattice spacings.
    pub fn evaluate(&mut self, u: &[Vec<f64>; 2], bulk: [f64; 2], forces: &mut [Vec<f64>; 2]) {
        self.place_bulk(bulk);
        match self.law {
            Springs::Linear => vectorized(Evaluate::<false> { rows: self, u, forces }),
            Springs::Exact => vectorized(Evaluate::<true> { rows: self, u, forces }),
        }
    }

    fn place_bulk(&mut self, bulk: [f64; 2]) {
        for (row, at) in self.bulk.iter_mut().zip(bulk) {
            row.fill(at);
        }
    }
}

/// Overwrites `x_forces` and `y_forces` with the forces of springs of the kind `KINDS[kind]` on their first ends; `a`
/// and `b` are the displacements of the first and of the second ends.
#[inline(always)]
fn forces_of<const EXACT: bool>(
    kind: usize,
    stiffness: &[f64],
    a: [&[f64]; 2],
    b: [&[f64]; 2],
    [x_forces, y_forces]: [&mut [f64]; 2],
) {
    let [x, y] = KINDS[kind];
    let square = x * x + y * y;
    let length = square.sqrt();
    let count = stiffness.len();
    let (a_x, a_y, b_x, b_y) = (&a[0][..count], &a[1][..count], &b[0][..count], &b[1][..count]);
    let (x_forces, y_forces) = (&mut x_forces[..count], &mut y_forces[..count]);
    for n in 0..count {
        let (dx, dy) = (b_x[n] - a_x[n], b_y[n] - a_y[n]);
        let along = x * dx + y * dy;
        if EXACT {
            // F = k (r - L) (r_b - r_a) / r, with r - L = (2 rest . d + d . d) / (r + L) free of cancellation
            let (to_x, to_y) = (x + dx, y + dy);
            let r = (to_x * to_x + to_y * to_y).sqrt();
            let scale = stiffness[n] * (2.0 * along + (dx * dx + dy * dy)) / ((r + length) * r);
            x_forces[n] = scale * to_x;
            y_forces[n] = scale * to_y;
        } else {
            // F = k e (e . d)
            let scale = stiffness[n] * along / square;
            x_forces[n] = scale * x;
            y_forces[n] = scale * y;
        }
    }
}

#[inline(always)]
fn add(to: &mut [f64], values: &[f64]) {
    for (to, value) in to.iter_mut().zip(values) {
        *to += value;
    }
}

#[inline(always)]
fn subtract(to: &mut [f64], values: &[f64]) {
    for (to, value) in to.iter_mut().zip(values) {
        *to -= value;
    }
}

struct Evaluate<'a, const EXACT: bool> {
    rows: &'a mut BondRows,
    u: &'a [Vec<f64>; 2],
    forces: &'a mut [Vec<f64>; 2],
}

impl<const EXACT: bool> WithSimd for Evaluate<'_, EXACT> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { rows: BondRows { columns, stiffness, bulk, on_bulk, .. }, u, forces } = self;
        let nx = *columns;
        let rows = u[0].len() / nx;
        let (mut kind_x, mut kind_y) = ([0.0; CHUNK], [0.0; CHUNK]);
        let [forces_x, forces_y] = forces;
        for j in 0..rows {
            let own = j * nx..(j + 1) * nx;
            let [u_x, u_y] = [&u[0][own.clone()], &u[1][own.clone()]];
            let (f_x, upper_x) = forces_x[own.start..].split_at_mut(nx);
            let (f_y, upper_y) = forces_y[own.start..].split_at_mut(nx);
            // The bulk is rigid: all springs to it end at the same displacement.
            let inside = j + 1 < rows;
            let (upper, [g_x, g_y]) = if inside {
                let above = own.end..own.end + nx;
                let upper = [&u[0][above.clone()], &u[1][above]];
                (upper, [&mut upper_x[..nx], &mut upper_y[..nx]])
            } else {
                let [on_x, on_y] = &mut *on_bulk;
                ([&bulk[0][..], &bulk[1][..]], [&mut on_x[..], &mut on_y[..]])
            };
            for from in (0..nx).step_by(CHUNK) {
                let to = (from + CHUNK).min(nx);
                let (t_x, t_y) = (&mut kind_x[..to - from], &mut kind_y[..to - from]);
                for (kind, stiffness) in stiffness.iter().enumerate() {
                    // Range of columns whose springs end within the row, the offset of the other end, and the column
                    // pair across the periodic side.
                    let (first, last, shift, seam) = match (kind, inside) {
                        (0, _) => (from, to.min(nx - 1), 1, Some([nx - 1, 0])),
                        (2, true) => (from, to.min(nx - 1), 1, Some([nx - 1, 0])),
                        (3, true) => (from.max(1), to, -1, Some([0, nx - 1])),
                        _ => (from, to, 0, None),
                    };
                    let k = &stiffness[own.clone()];
                    let ends = if kind == 0 { [u_x, u_y] } else { upper };
                    let seam = seam.filter(|[column, _]| (from..to).contains(column));
                    let spans = [
                        (first < last).then(|| (first..last, first.wrapping_add_signed(shift))),
                        seam.map(|[column, end]| (column..column + 1, end)),
                    ];
                    for (span, end) in spans.iter().flatten() {
                        let a = [&u_x[span.clone()], &u_y[span.clone()]];
                        let b = [&ends[0][*end..], &ends[1][*end..]];
                        let place = span.start - from..span.end - from;
                        let t = [&mut t_x[place.clone()], &mut t_y[place]];
                        let k = &k[span.clone()];
                        match kind {
                            0 => forces_of::<EXACT>(0, k, a, b, t),
                            1 => forces_of::<EXACT>(1, k, a, b, t),
                            2 => forces_of::<EXACT>(2, k, a, b, t),
                            _ => forces_of::<EXACT>(3, k, a, b, t),
                        }
                    }
                    let [on_x, on_y] = if kind == 0 { [&mut *f_x, &mut *f_y] } else { [&mut *g_x, &mut *g_y] };
                    for (span, end) in spans.into_iter().flatten() {
                        let place = span.start - from..span.end - from;
                        subtract(&mut on_x[end..], &t_x[place.clone()]);
                        subtract(&mut on_y[end..], &t_y[place]);
                    }
                    add(&mut f_x[from..to], t_x);
                    add(&mut f_y[from..to], t_y);
                }
            }
        }
    }
}

struct Pull<'a, const EXACT: bool> {
    rows: &'a mut BondRows,
    u: &'a [Vec<f64>; 2],
}

impl<const EXACT: bool> WithSimd for Pull<'_, EXACT> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f64 {
        const LANES: usize = 8;
        let Self { rows: BondRows { columns, stiffness, bulk, on_bulk: [t_x, t_y], .. }, u } = self;
        let top = u[0].len() - *columns;
        let a = [&u[0][top..], &u[1][top..]];
        let b = [&bulk[0][..], &bulk[1][..]];
        let mut sums = [0.0; LANES];
        for (kind, stiffness) in stiffness.iter().enumerate().skip(1) {
            let k = &stiffness[top..];
            match kind {
                1 => forces_of::<EXACT>(1, k, a, b, [&mut *t_x, &mut *t_y]),
                2 => forces_of::<EXACT>(2, k, a, b, [&mut *t_x, &mut *t_y]),
                _ => forces_of::<EXACT>(3, k, a, b, [&mut *t_x, &mut *t_y]),
            }
            // Partial sums in an order that does not depend on the vector width.
            for values in t_y.chunks(LANES) {
                for (sum, value) in sums.iter_mut().zip(values) {
                    *sum += value;
                }
            }
        }
        sums.iter().sum()
    }
}
