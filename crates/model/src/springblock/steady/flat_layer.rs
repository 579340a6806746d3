//! Response of a flat periodic layer of equal columns, in closed form.
//!
//! At the wave number q the equations of its rows k, with the displacements u_k and the forces f_k, are block
//! tridiagonal with 2 x 2 blocks
//!
//! ```text
//! C^T u_{k-1} + D_k u_k + C u_{k+1} = f_k
//! ```
//!
//! which are real for (u_x, -i u_z), because the lattice equals its own mirror image. With the response G_kl of row k
//! to forces on row l, elimination from the bulk down,
//!
//! ```text
//! S_k = D_k - C S_{k+1}^-1 C^T,     u_k = S_k^-1 f_k + T_k u_{k-1},     T_k = -S_k^-1 C^T
//! G_kl = T_k ... T_{l+1} G_ll for k > l,     G_ll = S_l^-1 + T_l G_{l-1,l-1} T_l^T,
//! ```
//!
//! takes a few thousand operations per wave number. In row 0 the vertical displacement is prescribed and the force is
//! the result. The bulk is rigid, moves only vertically, and carries the load. Displacements are in units of P l^2 / k,
//! forces in units of P l^2, with the nominal pressure P, lattice spacing l and spring stiffness k.

use super::dense::subtract_products;
use crate::springblock::lattice::springs;

/// The layer above a row counts as a half-space if the inverses S_k^-1 of the elimination change by less than this
/// fraction from row to row: twice the rounding error.
const HALF_SPACE_TOLERANCE: f64 = 4e-16;

/// If more than this number of rows lie above the explicit rows, the uniform mode of these rows, which does not decay
/// with height, is computed in closed form instead of row by row.
const MIN_SERIES_ROWS: usize = 100;

/// Symmetric 2 x 2 matrix: xx, xz, zz.
type Symmetric = [f64; 3];
/// 2 x 2 matrix by rows.
type Square = [f64; 4];

/// Responses of the lowest rows of a flat layer to unit inputs on these rows.
///
/// Field 2 k is the x component of row k, field 2 k + 1 the vertical component. Inputs are forces and outputs are
/// displacements, except for field 1, the vertical component of row 0: its input is a displacement and its output the
/// required force.
pub struct FlatLayer {
    columns: usize,
    fields: usize,
    /// Responses by output field, then input field: the output in column 0 for a unit input in each of the columns
    /// 0..nx, stored twice, so that columns that pass the periodic side are consecutive.
    responses: Vec<f64>,
}

/// Elimination at one wave number.
struct Elimination {
    /// Inverse S_k^-1 of the matrix of each row k after elimination of the rows above, by row; entry 0 is not used.
    inverses: Vec<Symmetric>,
    /// T_k = -S_k^-1 C^T, which gives u_k from u_{k-1}, by row k; entry 0 is not used.
    transfer: Vec<Square>,
    /// S_0, the matrix of row 0 after elimination of all rows above.
    lowest: Symmetric,
}

impl FlatLayer {
    /// Computes the responses of the `explicit` lowest rows of a layer of `rows` rows over `columns` columns, `w`
    /// lattice spacings apart.
    pub fn new(columns: usize, w: f64, rows: usize, explicit: usize) -> Self {
        let half = columns / 2 + 1;
        let fields = 2 * explicit;
        let turn = std::f64::consts::TAU / columns as f64;
        let angles: Vec<(f64, f64)> = (0..columns).map(|t| libm::sincos(turn * t as f64)).collect();
        // Pairs of rows (k, l) with k >= l, then components; wave numbers vary fastest.
        let pairs = explicit * (explicit + 1) / 2;
        let mut spectra = vec![0.0; 4 * pairs * half];
        let mut work =
            Elimination { inverses: vec![[0.0; 3]; explicit], transfer: vec![[0.0; 4]; explicit], lowest: [0.0; 3] };
        for number in 0..half {
            work.eliminate(angles[number], number == 0, w, rows, explicit);
            // The weight combines both signs of a wave number.
            let weight = if number == 0 || 2 * number == columns { 1.0 } else { 2.0 } / columns as f64;
            let mut put = |pair: usize, response: Square| {
                for (component, value) in response.into_iter().enumerate() {
                    spectra[(4 * pair + component) * half + number] = weight * value;
                }
            };
            work.respond(explicit, &mut put);
        }
        // Sums over wave numbers: cosines for equal components, sines for mixed ones.
        let mut waves = [vec![0.0; half * half], vec![0.0; half * half]];
        for (number, offset) in (0..half).flat_map(|number| (0..half).map(move |offset| (number, offset))) {
            let (sin, cos) = angles[number * offset % columns];
            // Negative, because products are subtracted.
            (waves[0][number * half + offset], waves[1][number * half + offset]) = (-cos, -sin);
        }
        let mut layer = Self { columns, fields, responses: vec![0.0; fields * fields * 2 * columns] };
        let mut sums = vec![0.0; half];
        let mut pair = 0;
        for l in 0..explicit {
            for k in l..explicit {
                for component in 0..4 {
                    let odd = component == 1 || component == 2;
                    sums.fill(0.0);
                    let spectrum = &spectra[(4 * pair + component) * half..][..half];
                    subtract_products(&mut sums, spectrum, &waves[usize::from(odd)], half, 0);
                    let (out, input) = (2 * k + component / 2, 2 * l + component % 2);
                    // u_x = -i u_xz f_z, u_z = i u_zx f_x: sin and -sin.
                    let sign = [1.0, 1.0, -1.0, 1.0][component];
                    layer.set(out, input, &sums, sign, odd);
                }
                pair += 1;
            }
        }
        layer
    }

    /// Stores the response `sums` for the column offsets 0..=nx/2, which is even or odd in the offset, and the
    /// reciprocal response of field `input` to field `out`.
    fn set(&mut self, out: usize, input: usize, sums: &[f64], sign: f64, odd: bool) {
        let nx = self.columns;
        let mirrored = if odd { -sign } else { sign };
        // Betti: u_a due to f_b equals u_b due to f_a at the opposite offset; a force due to a displacement has the
        // opposite sign.
        let reciprocal = if (out == 1) == (input == 1) { 1.0 } else { -1.0 };
        let at = |offset: usize| if 2 * offset <= nx { sign * sums[offset] } else { mirrored * sums[nx - offset] };
        // The output in column 0 due to the input in column e has the offset -e.
        let own = (out * self.fields + input) * 2 * nx;
        for e in 0..nx {
            let value = at((nx - e) % nx);
            self.responses[own + e] = value;
            self.responses[own + nx + e] = value;
        }
        if out != input {
            let other = (input * self.fields + out) * 2 * nx;
            for e in 0..nx {
                let value = reciprocal * at(e);
                self.responses[other + e] = value;
                self.responses[other + nx + e] = value;
            }
        }
    }

    /// Output of field `out` in column `column` for unit inputs of field `input` in `count` consecutive columns from
    /// `first` on.
    pub fn responses(&self, out: usize, column: usize, input: usize, first: usize, count: usize) -> &[f64] {
        let nx = self.columns;
        let start = (out * self.fields + input) * 2 * nx + (first + nx - column) % nx;
        &self.responses[start..start + count]
    }
}

impl Elimination {
    /// Eliminates from the bulk down, at the wave number with the given sine and cosine; `uniform` tells that this wave
    /// number is zero.
    fn eliminate(&mut self, (sin, cos): (f64, f64), uniform: bool, w: f64, rows: usize, explicit: usize) {
        let [horizontal, diagonal, vertical] = springs(w);
        // k e e^T of a diagonal: e = (w, 1) / sqrt(w^2 + 1)
        let share = diagonal / (w * w + 1.0);
        let level = 2.0 * horizontal * (1.0 - cos);
        let upward = [2.0 * share * w * w, vertical + 2.0 * share];
        let (cx, cz, cxz) = (-2.0 * share * w * w * cos, -vertical - 2.0 * share * cos, 2.0 * share * w * sin);
        // The bulk balances the load in the uniform mode and is rigid otherwise.
        let mut inverse = [0.0, 0.0, if uniform { 1.0 / upward[1] } else { 0.0 }];
        let mut k = rows;
        if uniform && rows > explicit + MIN_SERIES_ROWS {
            // n rows above in series: S^-1 = n / ((n + 1) s); the bulk follows the downward force.
            k = explicit;
            let above = (rows - k) as f64;
            inverse = [above / ((above + 1.0) * upward[0]), 0.0, 1.0 / upward[1]];
        }
        while k > 0 {
            k -= 1;
            let [a, b, d] = inverse;
            // C M C^T, C = [[cx, cxz], [-cxz, cz]]
            let (r0, r1) = ([cx * a + cxz * b, cx * b + cxz * d], [cz * b - cxz * a, cz * d - cxz * b]);
            let sides = if k == 0 { 1.0 } else { 2.0 };
            let xx = level + sides * upward[0] - (r0[0] * cx + r0[1] * cxz);
            let xz = -(r0[1] * cz - r0[0] * cxz);
            let zz = sides * upward[1] - (r1[1] * cz - r1[0] * cxz);
            if k == 0 {
                self.lowest = [xx, xz, zz];
                return;
            }
            let scale = 1.0 / (xx * zz - xz * xz);
            let above = std::mem::replace(&mut inverse, [zz * scale, -xz * scale, xx * scale]);
            // The wave does not reach farther up, so that all rows down to the explicit ones have the same inverse.
            if k > explicit && is_half_space(above, inverse) {
                k = explicit;
            }
            if k < explicit {
                let [a, b, d] = inverse;
                self.inverses[k] = inverse;
                // T = -S^-1 C^T, C^T = [[cx, -cxz], [cxz, cz]]
                self.transfer[k] = [-(a * cx + b * cxz), a * cxz - b * cz, -(b * cx + d * cxz), b * cxz - d * cz];
            }
        }
    }

    /// Calls `put` with the response of row k to inputs on row l for every pair k >= l, numbered consecutively; k
    /// varies fastest.
    fn respond(&self, explicit: usize, put: &mut impl FnMut(usize, Square)) {
        let [xx, xz, zz] = self.lowest;
        let inverse = 1.0 / xx;
        // Row 0 as a function of (f_x, w): u_x = (f_x - S_xz w) / S_xx, f_z = S_xz u_x + S_zz w
        put(0, [inverse, -xz * inverse, xz * inverse, zz - xz * xz * inverse]);
        let mut pair = 1;
        let mut up = [inverse, -xz * inverse, 0.0, 1.0];
        for k in 1..explicit {
            up = product(&self.transfer[k], &up);
            put(pair, up);
            pair += 1;
        }
        let mut own = [inverse, 0.0, 0.0, 0.0];
        for l in 1..explicit {
            let t = &self.transfer[l];
            let transfer = product(t, &own);
            let [a, b, d] = self.inverses[l];
            // T G T^T
            own = [
                a + transfer[0] * t[0] + transfer[1] * t[1],
                b + transfer[0] * t[2] + transfer[1] * t[3],
                b + transfer[2] * t[0] + transfer[3] * t[1],
                d + transfer[2] * t[2] + transfer[3] * t[3],
            ];
            put(pair, own);
            pair += 1;
            let mut up = own;
            for k in l + 1..explicit {
                up = product(&self.transfer[k], &up);
                put(pair, up);
                pair += 1;
            }
        }
    }
}

/// Whether the inverses of two rows are equal to rounding.
fn is_half_space(above: Symmetric, below: Symmetric) -> bool {
    let largest = below[0].abs().max(below[2].abs());
    above.iter().zip(&below).all(|(a, b)| (a - b).abs() <= HALF_SPACE_TOLERANCE * largest)
}

fn product(a: &Square, b: &Square) -> Square {
    [a[0] * b[0] + a[1] * b[2], a[0] * b[1] + a[1] * b[3], a[2] * b[0] + a[3] * b[2], a[2] * b[1] + a[3] * b[3]]
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROWS: usize = 7;
    const EXPLICIT: usize = 4;

    /// Field `out` in column 0 for unit inputs of field `input` in all columns.
    fn by_all(layer: &FlatLayer, out: usize, input: usize) -> f64 {
        layer.responses(out, 0, input, 0, layer.columns).iter().sum()
    }

    #[test]
    fn uniform_forces_shear_and_compress_it_as_its_moduli_say() {
        for (columns, w, rows) in [(1, 1.0, ROWS), (2, 0.9, ROWS), (9, 1.0, ROWS), (10, 1.07, ROWS), (9, 0.9, 700)] {
            let layer = FlatLayer::new(columns, w, rows, EXPLICIT);
            let scale = ((rows / ROWS) as f64).powi(2);
            let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12 * scale, "{columns} {w}: {a} {b}");
            for (l, k) in (0..EXPLICIT).flat_map(|l| (0..EXPLICIT).map(move |k| (l, k))) {
                // C66 = k/2: a row shears by 2/w under a unit force per column, from the bulk down to the force.
                close(by_all(&layer, 2 * k, 2 * l), 2.0 * (rows - k.max(l)) as f64 / w);
                // C22 = 3k/2; the bulk moves, so that the counterface carries the downward force.
                if l > 0 && k > 0 {
                    close(by_all(&layer, 2 * k + 1, 2 * l + 1), 2.0 * k.min(l) as f64 / (3.0 * w));
                }
                if l > 0 {
                    close(by_all(&layer, 1, 2 * l + 1), -1.0);
                    close(by_all(&layer, 2 * l + 1, 1), 1.0);
                }
            }
            // A uniform rise of the face moves the layer without force.
            close(by_all(&layer, 1, 1), 0.0);
        }
    }

    #[test]
    fn forces_and_displacements_are_in_equilibrium_about_every_block() {
        // Off the counterface, for each input: springs balance the force on each block of rows 1 and 2.
        let (columns, w) = (9, 0.95);
        let layer = FlatLayer::new(columns, w, ROWS, EXPLICIT);
        let [horizontal, diagonal, vertical] = springs(w);
        for (input, at) in (0..2 * EXPLICIT).flat_map(|input| [0, 4].map(|at| (input, at))) {
            let displacement = |i: usize, row: usize| {
                let of = |field: usize| layer.responses(field, i % columns, input, at, 1)[0];
                let held = f64::from(u8::from(input == 1 && i % columns == at));
                [of(2 * row), if row == 0 { held } else { of(2 * row + 1) }]
            };
            for (row, i) in (1..EXPLICIT - 1).flat_map(|row| (0..columns).map(move |i| (row, i))) {
                let own = displacement(i, row);
                let mut force = [0.0; 2];
                for (step, rise, stiffness) in
                    [(1, 0, horizontal), (0, 1, vertical), (1, 1, diagonal), (1, -1, diagonal)]
                {
                    for sign in [1_isize, -1] {
                        let other = displacement(
                            (i + columns).wrapping_add_signed(sign * step),
                            row.wrapping_add_signed(sign * rise),
                        );
                        let (x, y) = ((sign * step) as f64 * w, (sign * rise) as f64);
                        let pull = stiffness * (x * (other[0] - own[0]) + y * (other[1] - own[1])) / (x * x + y * y);
                        force[0] += pull * x;
                        force[1] += pull * y;
                    }
                }
                for (component, force) in force.into_iter().enumerate() {
                    let applied = f64::from(u8::from(input == 2 * row + component && i == at));
                    assert!((force + applied).abs() < 1e-12, "{input} {at} {row} {i} {component}: {force}");
                }
            }
        }
    }
}
