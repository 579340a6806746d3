//! One step of the leapfrog for the rows of a cell in space, from displacements now and one step before.
//!
//! Springs of stiffness k lead to the 6 nearest and the 12 face-diagonal neighbours. In each coordinate plane the
//! diagonals come in two pairs, rising and falling: what they pull is shared by the two components of that plane,
//!
//! ```text
//! rising = (a + b)_NE + (a + b)_SW,  falling = (a - b)_NW + (a - b)_SE
//! F_a = (rising + falling)/2 - 2 a,  F_b = (rising - falling)/2 - 2 b
//! ```
//!
//! and a block feels 6 k of its own in every component.

use std::ops::Range;

use pulp::{Simd, WithSimd};

use super::super::rows::{LINE, Plane};
use super::super::sweep::Kick;
use super::field::Field;
use super::stencil::{RowCoefficients, SPRINGS};

/// A component's values seen from its west, centre and east, in vectors.
#[derive(Clone, Copy)]
struct Views<'a, V> {
    west: &'a [V],
    centre: &'a [V],
    east: &'a [V],
}

impl<'a, V> Views<'a, V> {
    /// The first `count` vectors from the image before column 0 of row 0 on.
    #[inline(always)]
    fn new<S: Simd<f64s = V>>(_: S, plane: &'a Plane, count: usize) -> Self {
        let values = plane.rows();
        Self {
            west: &S::as_simd_f64s(&values[LINE - 1..]).0[..count],
            centre: &S::as_simd_f64s(&values[LINE..]).0[..count],
            east: &S::as_simd_f64s(&values[LINE + 1..]).0[..count],
        }
    }
}

/// Moves rows that are inside blocks alone: those of `layer`, which is not the lowest. Lanes beyond the last column
/// write into the images, which the caller restores.
pub struct InsideRows<'a> {
    pub field: &'a mut Field,
    pub layer: usize,
    pub rows: Range<usize>,
    pub kick: Kick,
}

/// What a row leaves for the row after the next: a sweep along y meets it as north, own and south.
struct Row<V> {
    /// x + y to the south west and x - y to the south east, seen from the row after it.
    south_west: V,
    south_east: V,
    /// x_E + x_W
    along: V,
    /// y - z above and y + z below, seen from the row after it.
    above: V,
    below: V,
    /// z above and z below.
    z_above: V,
    z_below: V,
    y: V,
}

impl WithSimd for InsideRows<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { field: Field { nx, nz, stride, layer: size, now, other, .. }, layer, rows, kick } = self;
        let Kick { kept, kick } = kick;
        let (vectors, row, up) = (nx.div_ceil(S::F64_LANES), *stride / S::F64_LANES, *size / S::F64_LANES);
        let count = (*nz + 1) * up;
        let [x, y, z] = [0, 1, 2].map(|component: usize| Views::new(simd, &now[component], count));
        let [other_x, other_y, other_z] = other;
        let new_x = &mut S::as_mut_simd_f64s(&mut other_x.rows_mut()[LINE..]).0[..count];
        let new_y = &mut S::as_mut_simd_f64s(&mut other_y.rows_mut()[LINE..]).0[..count];
        let new_z = &mut S::as_mut_simd_f64s(&mut other_z.rows_mut()[LINE..]).0[..count];

        // u + kept (u - u_before) + kick (-6 u + ...) = stay u - kept u_before + kick (...)
        let stay = simd.splat_f64s(1.0 + kept - 6.0 * kick);
        let (kept, kick, half) = (simd.splat_f64s(kept), simd.splat_f64s(kick), simd.splat_f64s(0.5));
        let (add, sub, mul) = (|a, b| simd.add_f64s(a, b), |a, b| simd.sub_f64s(a, b), |a, b| simd.mul_f64s(a, b));
        // A row seen from the row before it: what it pulls there, and what it leaves.
        let meet = |at: usize| {
            let (east, west) = (x.east[at], x.west[at]);
            let (y_east, y_west) = (y.east[at], y.west[at]);
            let (y_above, z_above) = (y.centre[at + up], z.centre[at + up]);
            let (y_below, z_below) = (y.centre[at - up], z.centre[at - up]);
            let pulls = [add(east, y_east), sub(west, y_west), add(y_above, z_above), sub(y_below, z_below)];
            let left = Row {
                south_west: add(west, y_west),
                south_east: sub(east, y_east),
                along: add(east, west),
                above: sub(y_above, z_above),
                below: add(y_below, z_below),
                z_above,
                z_below,
                y: y.centre[at],
            };
            (pulls, left)
        };
        let start = layer * up + (rows.start + 1) * row;
        for column in 0..vectors {
            let mut at = start + column;
            let (_, mut south) = meet(at - row);
            let (_, mut own) = meet(at);
            for _ in rows.clone() {
                let ([north_east, north_west, rising_above, falling_below], north) = meet(at + row);
                let (rising, falling) = (add(north_east, south.south_west), add(north_west, south.south_east));
                let (xy_x, xy_y) = (add(rising, falling), sub(rising, falling));
                let (rising, falling) = (add(rising_above, south.below), add(falling_below, south.above));
                let (yz_y, yz_z) = (add(rising, falling), sub(rising, falling));
                let (above, below) = (at + up, at - up);
                let rising = add(add(x.east[above], z.east[above]), add(x.west[below], z.west[below]));
                let falling = add(sub(x.west[above], z.west[above]), sub(x.east[below], z.east[below]));
                let (xz_x, xz_z) = (add(rising, falling), sub(rising, falling));

                let pull = simd.mul_add_e_f64s(half, add(xy_x, xz_x), own.along);
                let inert = sub(mul(stay, x.centre[at]), mul(kept, new_x[at]));
                new_x[at] = add(inert, mul(kick, pull));
                let pull = simd.mul_add_e_f64s(half, add(xy_y, yz_y), add(north.y, south.y));
                let inert = sub(mul(stay, own.y), mul(kept, new_y[at]));
                new_y[at] = add(inert, mul(kick, pull));
                let pull = simd.mul_add_e_f64s(half, add(yz_z, xz_z), add(own.z_above, own.z_below));
                let inert = sub(mul(stay, z.centre[at]), mul(kept, new_z[at]));
                new_z[at] = add(inert, mul(kick, pull));
                south = own;
                own = north;
                at += row;
            }
        }
    }
}

/// Spring forces on row `row` of `layer`, which has a coefficient per spring, by column.
pub struct RowForces<'a> {
    pub coefficients: &'a RowCoefficients,
    pub field: &'a Field,
    pub layer: usize,
    pub row: usize,
    pub force: [&'a mut [f64]; 3],
}

impl WithSimd for RowForces<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { coefficients, field: Field { nx, nz, stride, layer: size, now, .. }, layer, row, force } = self;
        let (vectors, stride, size) = (nx.div_ceil(S::F64_LANES), *stride / S::F64_LANES, *size / S::F64_LANES);
        let count = (*nz + 1) * size;
        let views = [0, 1, 2].map(|component: usize| Views::new(simd, &now[component], count));
        // The lowest layer has no springs downwards: whatever stands for what is below is multiplied by zero.
        let own = layer * size + (row + 1) * stride;
        let layers = [layer.saturating_sub(1), layer, layer + 1].map(|layer| layer * size + (row + 1) * stride);
        let [force_x, force_y, force_z] = force.map(|force| &mut S::as_mut_simd_f64s(force).0[..vectors]);
        let springs: [&[S::f64s]; SPRINGS] =
            std::array::from_fn(|spring| &S::as_simd_f64s(coefficients.spring(spring)).0[..vectors]);
        let [east, west, north, south, up, down, xy @ .., _, _, _, _, _, _, _, _] = springs;
        let [_, _, _, _, _, _, _, _, _, _, xz @ .., _, _, _, _] = springs;
        let [_, _, _, _, _, _, _, _, _, _, _, _, _, _, yz @ ..] = springs;
        let (add, sub, mul) = (|a, b| simd.add_f64s(a, b), |a, b| simd.sub_f64s(a, b), |a, b| simd.mul_f64s(a, b));
        for i in 0..vectors {
            let own = views.map(|view| view.centre[own + i]);
            // Difference of component `c` to the neighbour at a step along x, along y and upward, each plus one.
            let to = |c: usize, [sx, sy, sz]: [usize; 3]| {
                let at = layers[sz] + sy * stride - stride + i;
                let view = &views[c];
                let value = match sx {
                    0 => view.west[at],
                    1 => view.centre[at],
                    _ => view.east[at],
                };
                sub(value, own[c])
            };
            let straight = |c: usize, ahead: &[S::f64s], behind: &[S::f64s]| {
                let (mut plus, mut minus) = ([1; 3], [1; 3]);
                (plus[c], minus[c]) = (2, 0);
                add(mul(ahead[i], to(c, plus)), mul(behind[i], to(c, minus)))
            };
            // Half the stiffness times the elongation along each diagonal of the plane of a and b: its entries of
            // e e^T are 1/2.
            let diagonals = |a: usize, b: usize, k: [&[S::f64s]; 4]| {
                let pull = |k: &[S::f64s], ahead: bool, rising: bool| {
                    let mut step = [1; 3];
                    step[a] = if ahead == rising { 2 } else { 0 };
                    step[b] = if ahead { 2 } else { 0 };
                    let (along, across) = (to(a, step), to(b, step));
                    mul(k[i], if rising { add(along, across) } else { sub(along, across) })
                };
                let rising = add(pull(k[0], true, true), pull(k[1], false, true));
                let falling = add(pull(k[2], true, false), pull(k[3], false, false));
                [add(rising, falling), sub(rising, falling)]
            };
            let ([xy_x, xy_y], [xz_x, xz_z], [yz_y, yz_z]) =
                (diagonals(0, 1, xy), diagonals(0, 2, xz), diagonals(1, 2, yz));
            force_x[i] = add(straight(0, east, west), add(xy_x, xz_x));
            force_y[i] = add(straight(1, north, south), add(xy_y, yz_y));
            force_z[i] = add(straight(2, up, down), add(xz_z, yz_z));
        }
    }
}

/// Moves a row by given forces.
pub struct MoveRow<'a> {
    pub inverse_mass: &'a [f64],
    pub field: &'a mut Field,
    pub layer: usize,
    pub row: usize,
    pub kick: Kick,
    pub force: [&'a [f64]; 3],
}

impl WithSimd for MoveRow<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { inverse_mass, field, layer, row, kick: Kick { kept, kick }, force } = self;
        let vectors = field.nx.div_ceil(S::F64_LANES);
        let start = field.at(0, row, layer);
        let (kept, kick) = (simd.splat_f64s(kept), simd.splat_f64s(kick));
        let inverse_mass = &S::as_simd_f64s(inverse_mass).0[..vectors];
        for ((now, other), force) in field.now.iter().zip(&mut field.other).zip(force) {
            let now = &S::as_simd_f64s(&now.rows()[start..]).0[..vectors];
            let other = &mut S::as_mut_simd_f64s(&mut other.rows_mut()[start..]).0[..vectors];
            let force = &S::as_simd_f64s(force).0[..vectors];
            for i in 0..vectors {
                // u_after = u + kept (u - u_before) + kick F/m
                let coasting = simd.add_f64s(now[i], simd.mul_f64s(kept, simd.sub_f64s(now[i], other[i])));
                other[i] = simd.add_f64s(coasting, simd.mul_f64s(simd.mul_f64s(kick, inverse_mass[i]), force[i]));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::stencil::Stencil;
    use super::*;
    use crate::solid::SolidLattice;
    use slipgrid_pattern::{Pattern, Planform};

    /// Everything that the sweeps write, on a cell of `nx` columns along both axes.
    fn swept<S: Simd>(simd: S, nx: usize) -> Vec<u64> {
        let um = |blocks: usize| blocks as f64 * 10e-6;
        let cavity = (nx / 3).max(1);
        let pattern = Pattern::new(Planform::Square, um(cavity), um(nx - cavity), um(1)).unwrap();
        let lattice = SolidLattice::cell(&pattern, 10e-6, 4);
        let stencil = Stencil::new(&lattice);
        let mut field = Field::at_rest([nx, nx], 4);
        let mut number = 1_u32;
        let size = LINE + 5 * field.layer + LINE;
        for plane in field.now.iter_mut().chain(&mut field.other) {
            // As many values on every machine and in every allocation.
            for value in plane.rows_mut().iter_mut().take(size) {
                number = number.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                *value = (f64::from(number) / f64::from(u32::MAX) - 0.5) * 1e-3;
            }
        }
        let kick = Kick::new(0.15, 0.02);
        let padded = stencil.contact[0].inverse_mass.len();
        let mut force = [vec![0.0; padded], vec![0.0; padded], vec![0.0; padded]];
        let mut bits = Vec::new();
        let contact = stencil.contact.iter().enumerate().map(|(row, coefficients)| (0, row, coefficients));
        let general = stencil.general.iter().map(|general| (general.layer, general.row, &general.coefficients));
        for (layer, row, coefficients) in contact.chain(general) {
            let forces = force.each_mut().map(Vec::as_mut_slice);
            simd.vectorize(RowForces { coefficients, field: &field, layer, row, force: forces });
            bits.extend(force.iter().flat_map(|force| force[..nx].to_vec()));
            let (inverse_mass, force) = (&coefficients.inverse_mass, force.each_ref().map(Vec::as_slice));
            simd.vectorize(MoveRow { inverse_mass, field: &mut field, layer, row, kick, force });
        }
        for (layer, ranges) in stencil.inside.iter().enumerate() {
            for rows in ranges {
                simd.vectorize(InsideRows { field: &mut field, layer, rows: rows.clone(), kick });
            }
        }
        for plane in &field.other {
            for (j, k) in (0..nx).flat_map(|j| (0..4).map(move |k| (j, k))) {
                bits.extend_from_slice(&plane.rows()[field.at(0, j, k)..][..nx]);
            }
        }
        bits.into_iter().map(f64::to_bits).collect()
    }

    #[test]
    fn vectors_of_any_width_give_the_same_bits() {
        for nx in [2, 3, 8, 14, 21] {
            let scalar = swept(pulp::Scalar::new(), nx);
            #[cfg(target_arch = "x86_64")]
            {
                if let Some(simd) = pulp::x86::V3::try_new() {
                    assert!(swept(simd, nx) == scalar, "four lanes, {nx} columns");
                }
                if let Some(simd) = pulp::x86::V4::try_new() {
                    assert!(swept(simd, nx) == scalar, "eight lanes, {nx} columns");
                }
            }
            assert!(scalar.iter().any(|bits| *bits != 0));
        }
    }
}
