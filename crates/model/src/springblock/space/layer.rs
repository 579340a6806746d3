//! Exact displacements of a flat layer under forces on its lowest rows, by Fourier transforms.
//!
//! A flat layer under a rigid massless bulk is uniform along x and y: for the wave number q the equations of its rows
//! k, with the displacements u_k and the forces f_k, are block tridiagonal with 3 x 3 blocks
//!
//! ```text
//! C^T u_{k-1} + D_k u_k + C u_{k+1} = f_k
//! ```
//!
//! which are real for (u_x, u_y, -i u_z), because the lattice equals its own mirror image. Elimination from the bulk
//! down,
//!
//! ```text
//! S_k = D_k - C S_{k+1}^-1 C^T,
//! ```
//!
//! is done once per cell size; the rows above the cavities are represented by their S_k. In row 0 the vertical
//! displacement is prescribed (zero on the counterface) instead of the force. The bulk is another row that moves only
//! vertically and only as a whole (q = 0), and carries the load.
//!
//! The mirror image in y of a wave is a wave with opposite u_y: both use the same S.
//!
//! Rows of the cavities carry forces, and need displacements, only on the lines that cross a cavity. Only these lines
//! are transformed along x and stored. Along y all waves of one q_x are processed together, in a column that fits into
//! the cache: transform, elimination, inverse transform.

use std::ops::Range;
use std::sync::Arc;

use multiversion::multiversion;
use slipgrid_base::fft::{Complex, ComplexToReal, Fft, Precision, RealToComplex};

use super::springs::{LEVEL, springs};

/// The layer above a row counts as a half-space if the inverses S_k^-1 of the elimination change by less than this
/// fraction from row to row: a few rounding errors.
const HALF_SPACE_TOLERANCE: f64 = 1e-15;

/// Symmetric 3 x 3 matrix: xx, xy, xz, yy, yz, zz.
type Symmetric = [f64; 6];

/// Matrix C that couples neighbouring rows at one wave number: diagonal entries, and the entries xz and yz; zx and zy
/// have opposite signs.
#[derive(Clone, Copy, Debug)]
struct Coupling {
    xx: f64,
    yy: f64,
    zz: f64,
    xz: f64,
    yz: f64,
}

/// A flat layer condensed to its lowest rows.
#[derive(Clone)]
pub struct FlatLayer {
    columns: [usize; 2],
    /// Number of rows with explicit forces and displacements.
    explicit: usize,
    /// S_k^-1, the inverse of the matrix of row k after elimination of the rows above: for each wave number q_x, each
    /// row k in 1..explicit, and each q_y >= 0.
    inverses: Vec<Symmetric>,
    /// Row 0 for each wave number q_x and q_y >= 0: entries xx, xy, yy of the inverse of the xy block of S_0, then
    /// entries xz and yz of S_0.
    lowest: Vec<[f64; 5]>,
    couplings: Vec<Coupling>,
    forward_x: Arc<dyn RealToComplex<f64>>,
    inverse_x: Arc<dyn ComplexToReal<f64>>,
    forward_y: Arc<dyn Fft<f64>>,
    inverse_y: Arc<dyn Fft<f64>>,
}

impl std::fmt::Debug for FlatLayer {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "FlatLayer {{ columns: {:?}, explicit: {} }}", self.columns, self.explicit)
    }
}

/// Number of lines that are transformed along x before their spectra are stored, so that the values of one wave number
/// fill cache lines.
const BATCH: usize = 16;

/// Work space of [`FlatLayer::respond`].
pub struct Workspace {
    /// Range of needed lines, indices along y, of each field (three fields x, y, z per row).
    lines: Vec<Range<usize>>,
    /// Index of the first needed line of each field in the stored lines of one wave number q_x.
    starts: Vec<usize>,
    /// Fourier coefficients along x: for each wave number q_x the needed lines of all fields.
    spectra: Vec<Complex<f64>>,
    /// All fields at one wave number q_x, each over all lines along y.
    column: Vec<Complex<f64>>,
    transformed: Vec<Complex<f64>>,
    scratch: Vec<Complex<f64>>,
    real: Vec<f64>,
}

impl FlatLayer {
    /// Condenses a layer of `rows` rows over `columns` columns, `spacing` lattice spacings apart, to the lowest
    /// `explicit` rows. `explicit` is from 1 to rows + 1; the row above the top row is the bulk.
    pub fn new(columns: [usize; 2], spacing: [f64; 2], rows: usize, explicit: usize) -> Self {
        let [nx, ny] = columns;
        let (half, pairs) = (nx / 2 + 1, ny / 2 + 1);
        let (real, complex) = (f64::real_plans(nx), f64::complex_plans(ny));
        let mut layer = Self {
            columns,
            explicit,
            inverses: vec![[0.0; 6]; (explicit - 1) * half * pairs],
            lowest: Vec::with_capacity(half * pairs),
            couplings: Vec::with_capacity(half * pairs),
            forward_x: real.forward,
            inverse_x: real.inverse,
            forward_y: complex.forward,
            inverse_y: complex.inverse,
        };
        for number in 0..half * pairs {
            let turn = std::f64::consts::TAU;
            let q = [turn * (number / pairs) as f64 / nx as f64, turn * (number % pairs) as f64 / ny as f64];
            layer.condense(number, q, spacing, rows);
        }
        layer
    }

    /// Eliminates the rows from the bulk down at the wave vector `q`, in radians per column along x and y, which has
    /// the index `number`.
    fn condense(&mut self, number: usize, q: [f64; 2], spacing: [f64; 2], rows: usize) {
        let kinds = springs(spacing);
        // Within a row: sum k e e^T 2 (1 - cos q.d); upward and downward: sum k e e^T each.
        let (mut level, mut upward) = ([0.0; 3], [0.0; 3]); // xx, xy, yy and xx, yy, zz
        let mut coupling = Coupling { xx: 0.0, yy: 0.0, zz: 0.0, xz: 0.0, yz: 0.0 };
        for (kind, spring) in kinds.iter().enumerate() {
            let [x, y, z] = spring.direction();
            let phase = q[0] * spring.step[0] as f64 + q[1] * spring.step[1] as f64;
            let (sin, cos) = (libm::sin(phase), libm::cos(phase));
            let k = spring.stiffness;
            if kind < LEVEL {
                let scale = 2.0 * k * (1.0 - cos);
                level[0] += scale * x * x;
                level[1] += scale * x * y;
                level[2] += scale * y * y;
            } else {
                upward[0] += k * x * x;
                upward[1] += k * y * y;
                upward[2] += k * z * z;
                // -k e e^T exp(i q.d), vertical components times i
                coupling.xx -= k * x * x * cos;
                coupling.yy -= k * y * y * cos;
                coupling.zz -= k * z * z * cos;
                coupling.xz += k * x * z * sin;
                coupling.yz += k * y * z * sin;
            }
        }
        self.couplings.push(coupling);
        let pairs = self.columns[1] / 2 + 1;
        let place = |k: usize| (number / pairs * (self.explicit - 1) + k - 1) * pairs + number % pairs;
        // The bulk: S = sum k e_z^2 for q = 0, rigid otherwise.
        let mut inverse = [0.0; 6];
        if q == [0.0; 2] {
            inverse[5] = 1.0 / upward[2];
        }
        let mut k = rows + 1;
        while k > 0 {
            k -= 1;
            let mut reduced = inverse;
            if k < rows {
                let sides = if k == 0 { 1.0 } else { 2.0 };
                reduced = coupling.condensed(&inverse).map(|entry| -entry);
                for (entry, value) in [
                    (0, level[0] + sides * upward[0]),
                    (1, level[1]),
                    (3, level[2] + sides * upward[1]),
                    (5, sides * upward[2]),
                ] {
                    reduced[entry] += value;
                }
                if k > 0 {
                    let above = std::mem::replace(&mut inverse, invert(&reduced));
                    // The wave does not reach farther up, so that all rows down to the explicit ones have the same
                    // inverse.
                    if k > self.explicit && is_half_space(&above, &inverse) {
                        k = self.explicit;
                    }
                }
            }
            if k == 0 {
                let [xx, xy, xz, yy, yz, _] = reduced;
                let determinant = xx * yy - xy * xy;
                self.lowest.push([yy / determinant, -xy / determinant, xx / determinant, xz, yz]);
            } else if k < self.explicit {
                self.inverses[place(k)] = inverse;
            }
        }
    }

    /// Allocates work space for [`Self::respond`]. `lines` is, for each field (three fields x, y, z per row), the range
    /// of lines along y that may carry a force or be needed.
    pub fn workspace(&self, lines: Vec<Range<usize>>) -> Workspace {
        let [nx, ny] = self.columns;
        let half = nx / 2 + 1;
        let scratch = [
            self.forward_x.get_scratch_len(),
            self.inverse_x.get_scratch_len(),
            self.forward_y.get_inplace_scratch_len(),
            self.inverse_y.get_inplace_scratch_len(),
        ];
        let mut kept = 0;
        let mut starts = Vec::with_capacity(lines.len());
        for lines in &lines {
            starts.push(kept);
            kept += lines.len();
        }
        Workspace {
            lines,
            starts,
            spectra: vec![Complex::default(); half * kept],
            column: vec![Complex::default(); 3 * self.explicit * ny],
            transformed: vec![Complex::default(); BATCH * half],
            scratch: vec![Complex::default(); scratch.into_iter().max().unwrap_or(0)],
            real: vec![0.0; nx],
        }
    }

    /// Replaces forces by displacements in `fields`.
    ///
    /// Component c of the block in column i, line j and row k has the index ((3 k + c) ny + j) nx + i in `fields`. The
    /// vertical component of row 0 is a displacement on input and output. Line j of field f = 3 k + c is set to zero
    /// instead if `wanted[f ny + j]` is false.
    pub fn respond(&self, fields: &mut [f64], wanted: &[bool], workspace: &mut Workspace) {
        let [nx, ny] = self.columns;
        let (half, pairs) = (nx / 2 + 1, ny / 2 + 1);
        let loaded = self.transform_lines(fields, workspace);
        let Workspace { lines, starts, spectra, column, scratch, .. } = workspace;
        // The vertical displacements of row 0 are prescribed and remain as they are.
        let is_wanted = |field: usize| field != 2 && wanted[field * ny..(field + 1) * ny].contains(&true);
        let wanted_fields: Vec<bool> = (0..3 * self.explicit).map(is_wanted).collect();
        let kept = spectra.len() / half;
        for (q, spectra) in spectra.chunks_exact_mut(kept.max(1)).enumerate() {
            for (field, column) in column.chunks_exact_mut(ny).enumerate() {
                let lines = lines[field].clone();
                if !loaded[field] {
                    column.fill(Complex::default());
                    continue;
                }
                column[..lines.start].fill(Complex::default());
                column[lines.end..].fill(Complex::default());
                column[lines.clone()].copy_from_slice(&spectra[starts[field]..][..lines.len()]);
                self.forward_y.process_with_scratch(column, scratch);
            }
            let waves = Waves {
                inverses: &self.inverses[q * (self.explicit - 1) * pairs..][..(self.explicit - 1) * pairs],
                lowest: &self.lowest[q * pairs..][..pairs],
                couplings: &self.couplings[q * pairs..][..pairs],
                lines: ny,
            };
            sweep(&waves, column);
            for (field, column) in column.chunks_exact_mut(ny).enumerate().filter(|(field, _)| wanted_fields[*field]) {
                self.inverse_y.process_with_scratch(column, scratch);
                let lines = lines[field].clone();
                spectra[starts[field]..][..lines.len()].copy_from_slice(&column[lines]);
            }
        }
        self.transform_back(fields, wanted, workspace);
    }

    /// Transforms the needed lines of `fields` along x; returns for each field whether the field has forces.
    fn transform_lines(&self, fields: &[f64], workspace: &mut Workspace) -> Vec<bool> {
        let [nx, ny] = self.columns;
        let half = nx / 2 + 1;
        let Workspace { lines, starts, spectra, transformed, scratch, real, .. } = workspace;
        let kept = spectra.len() / half;
        let mut loaded = vec![false; lines.len()];
        for (field, lines) in lines.iter().enumerate() {
            let of_field = &fields[field * ny * nx..][..ny * nx];
            loaded[field] = of_field[lines.start * nx..lines.end * nx].iter().any(|value| *value != 0.0);
            if !loaded[field] {
                continue;
            }
            for first in lines.clone().step_by(BATCH) {
                let count = BATCH.min(lines.end - first);
                let together = of_field[first * nx..][..count * nx].chunks_exact(nx);
                for (values, line) in together.zip(transformed.chunks_exact_mut(half)) {
                    if values.iter().all(|value| *value == 0.0) {
                        line.fill(Complex::default());
                        continue;
                    }
                    real.copy_from_slice(values);
                    // The transform fails only for wrong lengths.
                    let _ = self.forward_x.process_with_scratch(real, line, scratch);
                }
                let start = starts[field] + first - lines.start;
                for q in 0..half {
                    let kept = &mut spectra[q * kept + start..][..count];
                    kept.iter_mut().enumerate().for_each(|(line, kept)| *kept = transformed[line * half + q]);
                }
            }
        }
        loaded
    }

    /// Transforms the lines of `fields` that `wanted` marks back along x; sets other needed lines to zero.
    fn transform_back(&self, fields: &mut [f64], wanted: &[bool], workspace: &mut Workspace) {
        let [nx, ny] = self.columns;
        let half = nx / 2 + 1;
        let Workspace { lines, starts, spectra, transformed, scratch, .. } = workspace;
        let kept = spectra.len() / half;
        let scale = 1.0 / (nx * ny) as f64;
        for (field, lines) in lines.iter().enumerate().filter(|(field, _)| *field != 2) {
            let of_field = &mut fields[field * ny * nx..][..ny * nx];
            let wanted = &wanted[field * ny..][..ny];
            for first in lines.clone().step_by(BATCH) {
                let count = BATCH.min(lines.end - first);
                let start = starts[field] + first - lines.start;
                if wanted[first..first + count].contains(&true) {
                    for q in 0..half {
                        let kept = &spectra[q * kept + start..][..count];
                        kept.iter().enumerate().for_each(|(line, kept)| transformed[line * half + q] = kept * scale);
                    }
                }
                let together = of_field[first * nx..][..count * nx].chunks_exact_mut(nx);
                for ((values, line), wanted) in together.zip(transformed.chunks_exact_mut(half)).zip(&wanted[first..]) {
                    if !wanted {
                        values.fill(0.0);
                        continue;
                    }
                    line[0].im = 0.0;
                    if nx.is_multiple_of(2) {
                        line[half - 1].im = 0.0;
                    }
                    let _ = self.inverse_x.process_with_scratch(line, values, scratch);
                }
            }
        }
    }
}

/// The condensed layer at all wave numbers q_y >= 0 of one q_x.
struct Waves<'a> {
    inverses: &'a [Symmetric],
    lowest: &'a [[f64; 5]],
    couplings: &'a [Coupling],
    /// Number of wave numbers q_y of either sign, which is the number of lines along y.
    lines: usize,
}

/// One displacement component of a wave and of its mirror image in y: real and imaginary part of the wave, then of the
/// image.
type Pair = [f64; 4];

/// Solves the block tridiagonal equations at every wave number of one q_x.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
fn sweep(waves: &Waves, column: &mut [Complex<f64>]) {
    let (count, pairs) = (waves.lines, waves.couplings.len());
    let explicit = column.len() / (3 * count);
    for number in 0..pairs {
        let mirror = if number == 0 { 0 } else { count - number };
        let c = &waves.couplings[number];
        let inverse = |k: usize| &waves.inverses[(k - 1) * pairs + number];
        // Downward: y_k = S_k^-1 f_k, f_{k-1} -= C y_k.
        let mut above = [[0.0; 4]; 3];
        for k in (0..explicit).rev() {
            let mut f = load(column, 3 * k * count, [count, number, mirror]);
            if k + 1 < explicit {
                let down = c.times(&above);
                f[0] = less(f[0], down[0]);
                f[1] = less(f[1], down[1]);
                if k > 0 {
                    f[2] = less(f[2], down[2]);
                }
            }
            if k > 0 {
                above = symmetric_times(inverse(k), &f);
                store(column, 3 * k * count, [count, number, mirror], &above);
            } else {
                above = f;
            }
        }
        // Row 0: w is given, S_xy u = f - S_xz w.
        let [xx, xy, yy, xz, yz] = waves.lowest[number];
        let w = above[2];
        let f = [less(above[0], times(w, xz)), less(above[1], times(w, yz))];
        let mut below = [plus(times(f[0], xx), times(f[1], xy)), plus(times(f[0], xy), times(f[1], yy)), w];
        store(column, 0, [count, number, mirror], &below);
        // Upward: u_k = y_k - S_k^-1 C^T u_{k-1}.
        for k in 1..explicit {
            let change = symmetric_times(inverse(k), &c.transposed_times(&below));
            let own = load(column, 3 * k * count, [count, number, mirror]);
            below = [less(own[0], change[0]), less(own[1], change[1]), less(own[2], change[2])];
            store(column, 3 * k * count, [count, number, mirror], &below);
        }
    }
}

/// Loads u_x, u_y, -i u_z of a wave and of its mirror image in y, with the sign of u_y of the image reversed, from the
/// row that begins at `start`. The other arguments are the number of lines and the indices of the wave and of the
/// mirror image.
#[inline(always)]
fn load(column: &[Complex<f64>], start: usize, [count, number, mirror]: [usize; 3]) -> [Pair; 3] {
    let at = |c: usize| [column[start + c * count + number], column[start + c * count + mirror]];
    let ([x, other_x], [y, other_y], [z, other_z]) = (at(0), at(1), at(2));
    [
        [x.re, x.im, other_x.re, other_x.im],
        [y.re, y.im, -other_y.re, -other_y.im],
        [z.im, -z.re, other_z.im, -other_z.re],
    ]
}

/// Stores u_x, u_y, -i u_z of a wave and of its mirror image: the inverse of [`load`].
#[inline(always)]
fn store(column: &mut [Complex<f64>], start: usize, [count, number, mirror]: [usize; 3], [x, y, z]: &[Pair; 3]) {
    let place = |c: usize, number: usize| start + c * count + number;
    column[place(0, mirror)] = Complex::new(x[2], x[3]);
    column[place(1, mirror)] = Complex::new(-y[2], -y[3]);
    column[place(2, mirror)] = Complex::new(-z[3], z[2]);
    column[place(0, number)] = Complex::new(x[0], x[1]);
    column[place(1, number)] = Complex::new(y[0], y[1]);
    column[place(2, number)] = Complex::new(-z[1], z[0]);
}

#[inline(always)]
fn plus(a: Pair, b: Pair) -> Pair {
    std::array::from_fn(|lane| a[lane] + b[lane])
}

#[inline(always)]
fn less(a: Pair, b: Pair) -> Pair {
    std::array::from_fn(|lane| a[lane] - b[lane])
}

#[inline(always)]
fn times(a: Pair, factor: f64) -> Pair {
    a.map(|value| value * factor)
}

impl Coupling {
    /// Returns C u, with C = `self`.
    #[inline(always)]
    fn times(&self, u: &[Pair; 3]) -> [Pair; 3] {
        [
            plus(times(u[0], self.xx), times(u[2], self.xz)),
            plus(times(u[1], self.yy), times(u[2], self.yz)),
            less(less(times(u[2], self.zz), times(u[0], self.xz)), times(u[1], self.yz)),
        ]
    }

    /// Returns C^T u, with C = `self`.
    #[inline(always)]
    fn transposed_times(&self, u: &[Pair; 3]) -> [Pair; 3] {
        [
            less(times(u[0], self.xx), times(u[2], self.xz)),
            less(times(u[1], self.yy), times(u[2], self.yz)),
            plus(plus(times(u[2], self.zz), times(u[0], self.xz)), times(u[1], self.yz)),
        ]
    }

    /// Returns C M C^T, with C = `self` and M = `m`.
    fn condensed(&self, m: &Symmetric) -> Symmetric {
        let rows = [[self.xx, 0.0, self.xz], [0.0, self.yy, self.yz], [-self.xz, -self.yz, self.zz]];
        let full = [[m[0], m[1], m[2]], [m[1], m[3], m[4]], [m[2], m[4], m[5]]];
        let product = |a: [f64; 3], b: [f64; 3]| -> f64 {
            (0..3).map(|r| a[r] * (0..3).map(|c| full[r][c] * b[c]).sum::<f64>()).sum()
        };
        [
            product(rows[0], rows[0]),
            product(rows[0], rows[1]),
            product(rows[0], rows[2]),
            product(rows[1], rows[1]),
            product(rows[1], rows[2]),
            product(rows[2], rows[2]),
        ]
    }
}

#[inline(always)]
fn symmetric_times(m: &Symmetric, u: &[Pair; 3]) -> [Pair; 3] {
    let row = |x: f64, y: f64, z: f64| plus(plus(times(u[0], x), times(u[1], y)), times(u[2], z));
    [row(m[0], m[1], m[2]), row(m[1], m[3], m[4]), row(m[2], m[4], m[5])]
}

/// Whether the inverses of two rows are equal to rounding.
fn is_half_space(above: &Symmetric, below: &Symmetric) -> bool {
    let largest = below[0].abs().max(below[3].abs()).max(below[5].abs());
    above.iter().zip(below).all(|(a, b)| (a - b).abs() <= HALF_SPACE_TOLERANCE * largest)
}

fn invert(m: &Symmetric) -> Symmetric {
    let [xx, xy, xz, yy, yz, zz] = *m;
    let cofactors = [
        yy * zz - yz * yz,
        xz * yz - xy * zz,
        xy * yz - xz * yy,
        xx * zz - xz * xz,
        xy * xz - xx * yz,
        xx * yy - xy * xy,
    ];
    let determinant = xx * cofactors[0] + xy * cofactors[1] + xz * cofactors[2];
    cofactors.map(|cofactor| cofactor / determinant)
}
