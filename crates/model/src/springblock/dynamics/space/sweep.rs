//! One leapfrog step for the rows of a cell in space, from the current displacements and those one step earlier.
//!
//! Springs of stiffness k connect a block with its 6 nearest and 12 face-diagonal neighbours. In each coordinate plane
//! the diagonals form two pairs, rising and falling, whose forces are shared by the two components of that plane:
//!
//! ```text
//! rising = (a + b)_NE + (a + b)_SW,  falling = (a - b)_NW + (a - b)_SE
//! F_a = (rising + falling)/2 - 2 a,  F_b = (rising - falling)/2 - 2 b
//! ```
//!
//! a and b are the displacement components in the plane, NE, SW, NW and SE the diagonal neighbours. The displacement u
//! of a block itself contributes -6 k u to its force.

use std::ops::Range;

use pulp::{Simd, WithSimd};

use super::super::real::Real;
use super::super::sweep::{Kick, Views};
use super::field::Field;
use super::stencil::{RowCoefficients, SPRINGS};

/// Takes one step of the rows `rows`, which have only inside blocks, in a `layer` other than the lowest. Vector lanes
/// beyond the last column overwrite ghost values, which the caller restores.
pub struct InsideRows<'a, R> {
    pub field: &'a mut Field<R>,
    pub layer: usize,
    pub rows: Range<usize>,
    pub kick: Kick,
    /// Drag of the moving frame along x and y, from [`Kick::drag`].
    pub drag: [f64; 2],
}

/// Contributions of a row to the forces on the row itself and on the next row along y. A sweep along y meets each row
/// first as north neighbour, then as centre, then as south neighbour.
#[derive(Clone, Copy)]
struct Row<V> {
    /// x + y of the west neighbours, which are the south-west neighbours for the next row.
    south_west: V,
    /// x - y of the east neighbours, which are the south-east neighbours for the next row.
    south_east: V,
    /// Sum of x of the east and west neighbours.
    along: V,
    /// y - z of the upper neighbours, used for the next row.
    above: V,
    /// y + z of the lower neighbours, used for the next row.
    below: V,
    /// z of the upper neighbours.
    z_above: V,
    /// z of the lower neighbours.
    z_below: V,
    y: V,
}

/// Contributions of a row: to the forces on the previous row along y, through the springs to the north east, the north
/// west, up north and down north; then to the forces on the row itself and on the next row.
type RowContributions<V> = ([V; 4], Row<V>);

/// Computes the contributions of the row at the vector index `at`, with the rows `below` and `above` it.
#[inline(always)]
fn row_contributions<S: Simd, R: Real>(
    simd: S,
    [x, y, z]: &[Views<'_, R::Vector<S>>; 3],
    [below, at, above]: [usize; 3],
) -> RowContributions<R::Vector<S>> {
    let (east, west) = (x.east[at], x.west[at]);
    let (y_east, y_west) = (y.east[at], y.west[at]);
    let (y_above, z_above) = (y.centre[above], z.centre[above]);
    let (y_below, z_below) = (y.centre[below], z.centre[below]);
    let pulls = [
        R::add(simd, east, y_east),
        R::sub(simd, west, y_west),
        R::add(simd, y_above, z_above),
        R::sub(simd, y_below, z_below),
    ];
    let left = Row {
        south_west: R::add(simd, west, y_west),
        south_east: R::sub(simd, east, y_east),
        along: R::add(simd, east, west),
        above: R::sub(simd, y_above, z_above),
        below: R::add(simd, y_below, z_below),
        z_above,
        z_below,
        y: y.centre[at],
    };
    (pulls, left)
}

/// Sum and difference of the forces of two rising and of two falling diagonals.
#[inline(always)]
fn sum_and_difference<S: Simd, R: Real>(
    simd: S,
    rising: [R::Vector<S>; 2],
    falling: [R::Vector<S>; 2],
) -> [R::Vector<S>; 2] {
    let rising = R::add(simd, rising[0], rising[1]);
    let falling = R::add(simd, falling[0], falling[1]);
    [R::add(simd, rising, falling), R::sub(simd, rising, falling)]
}

/// Factors of a leapfrog step: `stay` multiplies the displacement, `kept` the previous displacement, `kick` the force;
/// `half` is 1/2.
#[derive(Clone, Copy)]
struct Step<V> {
    stay: V,
    kept: V,
    kick: V,
    half: V,
}

impl<V: Copy> Step<V> {
    /// Returns the displacement after the step: stay u - kept u_before + kick (straight + diagonals/2), plus `drag`
    /// along an axis that has one. u is the current and u_before the previous displacement.
    #[inline(always)]
    fn after<S: Simd, R: Real<Vector<S> = V>>(
        &self,
        simd: S,
        [u, before]: [V; 2],
        drag: Option<V>,
        straight: V,
        diagonals: [V; 2],
    ) -> V {
        let pull = R::scale_add(simd, self.half, R::add(simd, diagonals[0], diagonals[1]), straight);
        let inert = R::sub(simd, R::mul(simd, self.stay, u), R::mul(simd, self.kept, before));
        let inert = drag.map_or(inert, |drag| R::add(simd, inert, drag));
        R::add(simd, inert, R::mul(simd, self.kick, pull))
    }
}

impl<R: Real> WithSimd for InsideRows<'_, R> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { field: Field { nx, nz, stride, layer: size, now, other, .. }, layer, rows, kick, drag } = self;
        let Kick { kept, kick } = kick;
        let (vectors, row, up) = (nx.div_ceil(R::lanes::<S>()), *stride / R::lanes::<S>(), *size / R::lanes::<S>());
        let count = (*nz + 1) * up;
        let [now_x, now_y, now_z] = now;
        let views = [Views::new(simd, now_x, count), Views::new(simd, now_y, count), Views::new(simd, now_z, count)];
        let [x, _, z] = views;
        let [other_x, other_y, other_z] = other;
        let new_x = &mut R::vectors_mut::<S>(&mut other_x.rows_mut()[R::LINE..])[..count];
        let new_y = &mut R::vectors_mut::<S>(&mut other_y.rows_mut()[R::LINE..])[..count];
        let new_z = &mut R::vectors_mut::<S>(&mut other_z.rows_mut()[R::LINE..])[..count];
        let step = Step {
            // u + kept (u - u_before) + kick (-6 u + ...) = stay u - kept u_before + kick (...)
            stay: R::splat(simd, 1.0 + kept - 6.0 * kick),
            kept: R::splat(simd, kept),
            kick: R::splat(simd, kick),
            half: R::splat(simd, 0.5),
        };
        let [drag_x, drag_y] = drag.map(|drag| R::splat(simd, drag));
        let start = layer * up + (rows.start + 1) * row;
        for column in 0..vectors {
            let mut next = start + column;
            let (_, mut south) =
                row_contributions::<S, R>(simd, &views, [next - row - up, next - row, next - row + up]);
            let (_, mut own) = row_contributions::<S, R>(simd, &views, [next - up, next, next + up]);
            for _ in rows.clone() {
                // The black box makes the compiler see one index; otherwise it keeps a pointer in memory for each of
                // two dozen streams.
                let at = std::hint::black_box(next);
                let (below, above) = (at - up, at + up);
                let ([north_east, north_west, rising_above, falling_below], north) =
                    row_contributions::<S, R>(simd, &views, [below + row, at + row, above + row]);
                let [xy_x, xy_y] =
                    sum_and_difference::<S, R>(simd, [north_east, south.south_west], [north_west, south.south_east]);
                let [yz_y, yz_z] =
                    sum_and_difference::<S, R>(simd, [rising_above, south.below], [falling_below, south.above]);
                let [xz_x, xz_z] = sum_and_difference::<S, R>(
                    simd,
                    [R::add(simd, x.east[above], z.east[above]), R::add(simd, x.west[below], z.west[below])],
                    [R::sub(simd, x.west[above], z.west[above]), R::sub(simd, x.east[below], z.east[below])],
                );
                new_x[at] = step.after::<S, R>(simd, [x.centre[at], new_x[at]], Some(drag_x), own.along, [xy_x, xz_x]);
                new_y[at] = step.after::<S, R>(
                    simd,
                    [own.y, new_y[at]],
                    Some(drag_y),
                    R::add(simd, north.y, south.y),
                    [xy_y, yz_y],
                );
                let straight = R::add(simd, own.z_above, own.z_below);
                new_z[at] = step.after::<S, R>(simd, [z.centre[at], new_z[at]], None, straight, [yz_z, xz_z]);
                south = own;
                own = north;
                next += row;
            }
        }
    }
}

/// Computes the spring forces on row `row` of `layer`, by column, with individual coefficients for every spring. Forces
/// are in units of k l (spring stiffness times lattice spacing).
pub struct RowForces<'a, R> {
    pub coefficients: &'a RowCoefficients<R>,
    pub field: &'a Field<R>,
    pub layer: usize,
    pub row: usize,
    pub force: [&'a mut [R]; 3],
}

impl<R: Real> WithSimd for RowForces<'_, R> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { coefficients, field: Field { nx, nz, stride, layer: size, now, .. }, layer, row, force } = self;
        let (vectors, row_step, up) =
            (nx.div_ceil(R::lanes::<S>()), *stride / R::lanes::<S>(), *size / R::lanes::<S>());
        let count = (*nz + 1) * up;
        let [now_x, now_y, now_z] = now;
        let (x, y, z) =
            (Views::new(simd, now_x, count), Views::new(simd, now_y, count), Views::new(simd, now_z, count));
        let own = layer * up + (row + 1) * row_step;
        // The lowest layer has no springs downwards: the values read for them are multiplied by zero.
        let down = if layer == 0 { 0 } else { up };
        let [force_x, force_y, force_z] = force;
        let force_x = &mut R::vectors_mut::<S>(force_x)[..vectors];
        let force_y = &mut R::vectors_mut::<S>(force_y)[..vectors];
        let force_z = &mut R::vectors_mut::<S>(force_z)[..vectors];
        // Springs in the order of STEPS, vectors fastest.
        let springs = R::vectors::<S>(&coefficients.springs);
        let padded = springs.len() / SPRINGS;
        let (add, sub, mul) = (|a, b| R::add(simd, a, b), |a, b| R::sub(simd, a, b), |a, b| R::mul(simd, a, b));
        for i in 0..vectors {
            let at = own + i;
            let (above, below, north, south) = (at + up, at - down, at + row_step, at - row_step);
            let k = |spring: usize| springs[spring * padded + i];
            let (u, v, w) = (x.centre[at], y.centre[at], z.centre[at]);
            // Half the stiffness times the elongation along each diagonal: the entries of e e^T are 1/2.
            let rise = |k, a, b, [own_a, own_b]: [R::Vector<S>; 2]| mul(k, add(sub(a, own_a), sub(b, own_b)));
            let fall = |k, a, b, [own_a, own_b]: [R::Vector<S>; 2]| mul(k, sub(sub(a, own_a), sub(b, own_b)));
            let xy = [u, v];
            let rising =
                add(rise(k(6), x.east[north], y.east[north], xy), rise(k(7), x.west[south], y.west[south], xy));
            let falling =
                add(fall(k(8), x.west[north], y.west[north], xy), fall(k(9), x.east[south], y.east[south], xy));
            let (xy_x, xy_y) = (add(rising, falling), sub(rising, falling));
            let xz = [u, w];
            let rising =
                add(rise(k(10), x.east[above], z.east[above], xz), rise(k(11), x.west[below], z.west[below], xz));
            let falling =
                add(fall(k(12), x.west[above], z.west[above], xz), fall(k(13), x.east[below], z.east[below], xz));
            let (xz_x, xz_z) = (add(rising, falling), sub(rising, falling));
            let yz = [v, w];
            let [north_above, south_below] = [above + row_step, below - row_step];
            let [south_above, north_below] = [above - row_step, below + row_step];
            let rising = add(
                rise(k(14), y.centre[north_above], z.centre[north_above], yz),
                rise(k(15), y.centre[south_below], z.centre[south_below], yz),
            );
            let falling = add(
                fall(k(16), y.centre[south_above], z.centre[south_above], yz),
                fall(k(17), y.centre[north_below], z.centre[north_below], yz),
            );
            let (yz_y, yz_z) = (add(rising, falling), sub(rising, falling));
            let straight = add(mul(k(0), sub(x.east[at], u)), mul(k(1), sub(x.west[at], u)));
            force_x[i] = add(straight, add(xy_x, xz_x));
            let straight = add(mul(k(2), sub(y.centre[north], v)), mul(k(3), sub(y.centre[south], v)));
            force_y[i] = add(straight, add(xy_y, yz_y));
            let straight = add(mul(k(4), sub(z.centre[above], w)), mul(k(5), sub(z.centre[below], w)));
            force_z[i] = add(straight, add(xz_z, yz_z));
        }
    }
}

#[cfg(test)]
mod tests {
    use std::marker::PhantomData;

    use super::super::super::sweep::MoveRow;
    use super::super::super::tests::any_width::{assert_same_bits, fill};
    use super::super::stencil::{GeneralRow, Stencil};
    use super::*;
    use crate::pattern::{Pattern, Planform};
    use crate::springblock::space::SpaceLattice;

    /// All results of the sweeps on a cell with `nx` columns along both axes.
    struct Swept<R> {
        nx: usize,
        precision: PhantomData<R>,
    }

    impl<R: Real> WithSimd for Swept<R> {
        type Output = Vec<f64>;

        fn with_simd<S: Simd>(self, simd: S) -> Vec<f64> {
            let nx = self.nx;
            let um = |blocks: usize| blocks as f64 * 10e-6;
            let cavity = (nx / 3).max(1);
            let pattern = Pattern::new(Planform::Square, um(cavity), um(nx - cavity), um(1)).unwrap();
            let lattice = SpaceLattice::cell(&pattern, 10e-6, 4);
            let stencil = Stencil::<R>::new(&lattice);
            let mut field = Field::at_rest([nx, nx], 4);
            let size = R::LINE + 5 * field.layer + R::LINE;
            fill(field.now.iter_mut().chain(&mut field.other), size);
            let kick = Kick::new(0.15, 0.02);
            let padded = stencil.general[0][0].coefficients.inverse_mass.len();
            let mut force = [vec![R::default(); padded], vec![R::default(); padded], vec![R::default(); padded]];
            let mut written = Vec::new();
            let mut write = |values: &[R]| written.extend(values[..nx].iter().map(|value| value.to_f64()));
            let general = stencil.general.iter().enumerate();
            for (layer, GeneralRow { row, coefficients }) in
                general.flat_map(|(layer, rows)| rows.iter().map(move |row| (layer, row)))
            {
                let row = *row;
                let forces = force.each_mut().map(Vec::as_mut_slice);
                simd.vectorize(RowForces { coefficients, field: &field, layer, row, force: forces });
                force.iter().for_each(|force| write(force));
                let (inverse_mass, force) = (&coefficients.inverse_mass, force.each_ref().map(Vec::as_slice));
                let (columns, start) = (nx, field.index(0, row, layer));
                let (now, other) = (&field.now, &mut field.other);
                let drag = [-1e-5, 2e-5, 0.0];
                simd.vectorize(MoveRow { inverse_mass, now, other, columns, start, kick, drag, force });
            }
            for (layer, ranges) in stencil.inside.iter().enumerate() {
                for rows in ranges {
                    let (rows, drag) = (rows.clone(), [-1e-5, 2e-5]);
                    simd.vectorize(InsideRows { field: &mut field, layer, rows, kick, drag });
                }
            }
            for plane in &field.other {
                for (j, k) in (0..nx).flat_map(|j| (0..4).map(move |k| (j, k))) {
                    write(&plane.rows()[field.index(0, j, k)..]);
                }
            }
            written
        }
    }

    #[test]
    fn vectors_of_any_width_give_the_same_bits() {
        for nx in [2, 3, 8, 14, 21] {
            assert_same_bits(&format!("{nx} columns"), || Swept { nx, precision: PhantomData::<f64> });
            assert_same_bits(&format!("{nx} columns, single"), || Swept { nx, precision: PhantomData::<f32> });
        }
    }
}
