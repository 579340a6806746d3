//! The flat layer's displacements under forces on its lowest rows, exactly, by Fourier transforms.
//!
//! A flat layer under a rigid massless bulk is the same everywhere along x and y: for the wave number q
//! its equations are block tridiagonal over the rows, with 3 x 3 blocks
//!
//! ```text
//! C^T u_{k-1} + D_k u_k + C u_{k+1} = f_k
//! ```
//!
//! real for (u_x, u_y, -i u_z), because the lattice is its own mirror image. Eliminating from the bulk down,
//!
//! ```text
//! S_k = D_k - C S_{k+1}^-1 C^T,
//! ```
//!
//! needs to be done once for a cell size; the rows above the cavities leave nothing but their S. At
//! row 0 the vertical displacement is prescribed (zero on the counterface), not the force. The bulk is
//! a row like the others that moves only vertically and only as a whole (q = 0): its balance is the load's.

use std::sync::Arc;

use multiversion::multiversion;
use slipgrid_fft::{Complex, ComplexToReal, Fft, Precision, RealToComplex};

use super::springs::{LEVEL, springs};

/// Change of S_k^-1 from row to row, relative to itself, at which it is that of a half-space: a few roundings.
const SETTLED: f64 = 1e-15;

/// Symmetric 3 x 3 matrix: xx, xy, xz, yy, yz, zz.
type Symmetric = [f64; 6];

/// C over a wave number: diagonal, and the couplings of x and y with z.
#[derive(Clone, Copy, Debug)]
struct Coupling {
    xx: f64,
    yy: f64,
    zz: f64,
    xz: f64,
    yz: f64,
}

/// The condensed flat layer.
#[derive(Clone)]
pub struct FlatLayer {
    columns: [usize; 2],
    /// Rows whose forces and displacements are explicit: 0..explicit.
    explicit: usize,
    /// S_k^-1 for k = 1..explicit, wave numbers fastest.
    inverses: Vec<Symmetric>,
    /// Row 0: inverse of the xy part of S_0, then its xz and yz entries.
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

/// Work space of one application.
pub struct Workspace {
    spectra: Vec<Complex<f64>>,
    line: Vec<Complex<f64>>,
    scratch: Vec<Complex<f64>>,
    real: Vec<f64>,
}

impl FlatLayer {
    /// Condenses a layer of `rows` rows over `columns`, `spacing` apart, onto its `explicit` lowest rows,
    /// between 1 and rows + 1: the row above the top one is the bulk.
    pub fn new(columns: [usize; 2], spacing: [f64; 2], rows: usize, explicit: usize) -> Self {
        let [nx, ny] = columns;
        let half = nx / 2 + 1;
        let (real, complex) = (f64::real_plans(nx), f64::complex_plans(ny));
        let count = half * ny;
        let mut layer = Self {
            columns,
            explicit,
            inverses: vec![[0.0; 6]; (explicit - 1) * count],
            lowest: Vec::with_capacity(count),
            couplings: Vec::with_capacity(count),
            forward_x: real.forward,
            inverse_x: real.inverse,
            forward_y: complex.forward,
            inverse_y: complex.inverse,
        };
        for number in 0..count {
            let turn = std::f64::consts::TAU;
            let q = [turn * (number / ny) as f64 / nx as f64, turn * (number % ny) as f64 / ny as f64];
            layer.condense(number, count, q, spacing, rows);
        }
        layer
    }

    /// Block elimination at the wave number `q`.
    fn condense(&mut self, number: usize, count: usize, q: [f64; 2], spacing: [f64; 2], rows: usize) {
        let kinds = springs(spacing);
        // Within a row: sum k e e^T 2 (1 - cos q.d); up and down: sum k e e^T each.
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
                    // A wave does not reach farther up: what follows down to the explicit rows is the same.
                    if k > self.explicit && settled(&above, &inverse) {
                        k = self.explicit;
                    }
                }
            }
            if k == 0 {
                let [xx, xy, xz, yy, yz, _] = reduced;
                let determinant = xx * yy - xy * xy;
                self.lowest.push([yy / determinant, -xy / determinant, xx / determinant, xz, yz]);
            } else if k < self.explicit {
                self.inverses[(k - 1) * count + number] = inverse;
            }
        }
    }

    /// Work space for [`Self::respond`].
    pub fn workspace(&self) -> Workspace {
        let [nx, ny] = self.columns;
        let half = nx / 2 + 1;
        let scratch = [
            self.forward_x.get_scratch_len(),
            self.inverse_x.get_scratch_len(),
            self.forward_y.get_inplace_scratch_len(),
            self.inverse_y.get_inplace_scratch_len(),
        ];
        Workspace {
            spectra: vec![Complex::default(); 3 * self.explicit * half * ny],
            line: vec![Complex::default(); half],
            scratch: vec![Complex::default(); scratch.into_iter().max().unwrap_or(0)],
            real: vec![0.0; nx],
        }
    }

    /// Replaces forces by displacements in `fields`: three components of each explicit row, each nx x ny values, x
    /// fastest. The vertical component of row 0 is a displacement before and after. Where `wanted` is false for a
    /// line (component field times ny + j), the displacements there are not computed but left zero.
    pub fn respond(&self, fields: &mut [f64], wanted: &[bool], workspace: &mut Workspace) {
        let [nx, ny] = self.columns;
        let half = nx / 2 + 1;
        let Workspace { spectra, line, scratch, real } = workspace;
        let lines = |field: usize| (0..ny).map(move |j| (field * ny + j) * nx);
        for (field, spectrum) in spectra.chunks_exact_mut(half * ny).enumerate() {
            let mut empty = true;
            for (j, start) in lines(field).enumerate() {
                let values = &mut fields[start..start + nx];
                if values.iter().all(|value| *value == 0.0) {
                    (0..half).for_each(|q| spectrum[q * ny + j] = Complex::default());
                    continue;
                }
                empty = false;
                real.copy_from_slice(values);
                // Lengths are those planned for: cannot fail.
                let _ = self.forward_x.process_with_scratch(real, line, scratch);
                (0..half).for_each(|q| spectrum[q * ny + j] = line[q]);
            }
            if !empty {
                self.forward_y.process_with_scratch(spectrum, scratch);
            }
        }
        sweep(&self.inverses, &self.lowest, &self.couplings, self.explicit, spectra);
        let scale = 1.0 / (nx * ny) as f64;
        for (field, spectrum) in spectra.chunks_exact_mut(half * ny).enumerate() {
            // Row 0 is pinned where it is not prescribed: what came in stays.
            if field == 2 {
                continue;
            }
            if !wanted[field * ny..(field + 1) * ny].contains(&true) {
                fields[field * ny * nx..(field + 1) * ny * nx].fill(0.0);
                continue;
            }
            self.inverse_y.process_with_scratch(spectrum, scratch);
            for (j, start) in lines(field).enumerate() {
                let values = &mut fields[start..start + nx];
                if !wanted[field * ny + j] {
                    values.fill(0.0);
                    continue;
                }
                (0..half).for_each(|q| line[q] = spectrum[q * ny + j] * scale);
                line[0].im = 0.0;
                if nx.is_multiple_of(2) {
                    line[half - 1].im = 0.0;
                }
                let _ = self.inverse_x.process_with_scratch(line, values, scratch);
            }
        }
    }
}

/// Solves the block tridiagonal equations at every wave number.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
fn sweep(
    inverses: &[Symmetric],
    lowest: &[[f64; 5]],
    couplings: &[Coupling],
    explicit: usize,
    spectra: &mut [Complex<f64>],
) {
    let count = couplings.len();
    let turned = |value: Complex<f64>| Complex::new(value.im, -value.re); // -i u
    for number in 0..count {
        let c = &couplings[number];
        let at = |row: usize, component: usize| (3 * row + component) * count + number;
        // Down: y_k = S_k^-1 f_k, f_{k-1} -= C y_k.
        let mut above = [Complex::default(); 3];
        for k in (0..explicit).rev() {
            let mut f = [spectra[at(k, 0)], spectra[at(k, 1)], turned(spectra[at(k, 2)])];
            if k + 1 < explicit {
                let down = c.times(above);
                f[0] -= down[0];
                f[1] -= down[1];
                if k > 0 {
                    f[2] -= down[2];
                }
            }
            if k > 0 {
                above = symmetric_times(&inverses[(k - 1) * count + number], f);
                for (component, value) in above.into_iter().enumerate() {
                    spectra[at(k, component)] = value;
                }
            } else {
                above = f;
            }
        }
        // Row 0: w is given, S_xy u = f - S_xz w.
        let [xx, xy, yy, xz, yz] = lowest[number];
        let w = above[2];
        let (fx, fy) = (above[0] - w * xz, above[1] - w * yz);
        let mut below = [fx * xx + fy * xy, fx * xy + fy * yy, w];
        spectra[at(0, 0)] = below[0];
        spectra[at(0, 1)] = below[1];
        // Up: u_k = y_k - S_k^-1 C^T u_{k-1}.
        for k in 1..explicit {
            let change = symmetric_times(&inverses[(k - 1) * count + number], c.transposed_times(below));
            for (component, change) in change.into_iter().enumerate() {
                below[component] = spectra[at(k, component)] - change;
            }
            spectra[at(k, 0)] = below[0];
            spectra[at(k, 1)] = below[1];
            spectra[at(k, 2)] = Complex::new(-below[2].im, below[2].re); // i w
        }
    }
}

impl Coupling {
    #[inline(always)]
    fn times(&self, u: [Complex<f64>; 3]) -> [Complex<f64>; 3] {
        [
            u[0] * self.xx + u[2] * self.xz,
            u[1] * self.yy + u[2] * self.yz,
            u[2] * self.zz - u[0] * self.xz - u[1] * self.yz,
        ]
    }

    #[inline(always)]
    fn transposed_times(&self, u: [Complex<f64>; 3]) -> [Complex<f64>; 3] {
        [
            u[0] * self.xx - u[2] * self.xz,
            u[1] * self.yy - u[2] * self.yz,
            u[2] * self.zz + u[0] * self.xz + u[1] * self.yz,
        ]
    }

    /// C M C^T.
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
fn symmetric_times(m: &Symmetric, u: [Complex<f64>; 3]) -> [Complex<f64>; 3] {
    [
        u[0] * m[0] + u[1] * m[1] + u[2] * m[2],
        u[0] * m[1] + u[1] * m[3] + u[2] * m[4],
        u[0] * m[2] + u[1] * m[4] + u[2] * m[5],
    ]
}

/// Whether the inverses of two rows are the same but for rounding.
fn settled(above: &Symmetric, below: &Symmetric) -> bool {
    let largest = below[0].abs().max(below[3].abs()).max(below[5].abs());
    above.iter().zip(below).all(|(a, b)| (a - b).abs() <= SETTLED * largest)
}

/// Inverse by cofactors.
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
