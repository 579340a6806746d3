//! One leapfrog step for the blocks of a strip, from the current displacements and those one step earlier.
//!
//! Velocities are not stored. With the factors `kept` and `kick` of `Kick` and the displacement of the last step, w = u
//! - u_before,
//!
//! ```text
//! u_after = u + kept w + kick F/m + drag,  drag = -(1 - kept) v dt
//! ```
//!
//! The drag acts along x if displacements are relative to a frame that moves at the speed v, because damping is
//! relative to the frame at rest.
//!
//! Cost per inside block and step: 18 additions, two of them fused with an exact multiplication by 1/4, 6
//! multiplications, 8 loads and 2 stores. This assumes that the sums along a row are reused for the next row, which is
//! why inside rows are swept upwards in columns as wide as a vector. A core with eight additions and eight
//! multiplications per cycle needs 1.9 cycles per block for this arithmetic. Memory traffic is 48 bytes per block and
//! step (u read, u_before replaced): a cell of 50 x 20 blocks just exceeds the first-level cache, and a strip of 250
//! columns fits in the second-level cache. At 32 bytes per cycle the traffic takes 1.5 cycles in parallel with the
//! arithmetic. Measured on a Zen 4 core at 3.65 GHz: 2.35 cycles per block, 1.55e9 blocks per second in inside rows.
//! The contact row and the fixed cost of a step take a third of the total time on a cell.

use pulp::{Simd, WithSimd};

use super::real::Real;
use super::rows::{Field, Plane, RowCoefficients, Site};

/// Factors of a leapfrog step.
#[derive(Clone, Copy, Debug)]
pub struct Kick {
    /// Fraction of the velocity that remains after damping.
    pub kept: f64,
    /// Displacement in one step that a unit force causes on a unit mass at rest, in units of spring stiffness k,
    /// lattice spacing l and block mass m.
    pub kick: f64,
}

impl Kick {
    /// Creates the factors for the time step `time_step`, in units of sqrt(m/k), with implicit damping of the frequency
    /// `damping`, in units of sqrt(k/m); k is the spring stiffness, m the block mass.
    pub fn new(time_step: f64, damping: f64) -> Self {
        let half = 0.5 * damping * time_step;
        Self { kept: (1.0 - half) / (1.0 + half), kick: time_step * time_step / (1.0 + half) }
    }

    /// Rounds the factors to multiples of the epsilon of `R`, so that 1 + kept - n kick with a small integer n has no
    /// rounding error in this precision. A rigid translation of the layer then causes no force.
    #[must_use]
    pub fn rounded<R: Real>(self) -> Self {
        let unit = R::EPSILON;
        let round = |value: f64| (value / unit).round() * unit;
        Self { kept: round(self.kept), kick: round(self.kick) }
    }

    /// Drag in a frame that moves by `carried` per step: the displacement -(1 - kept) `carried` that damping adds in
    /// each step to displacements relative to this frame.
    pub fn drag(&self, carried: f64) -> f64 {
        -(1.0 - self.kept) * carried
    }
}

/// Takes one step of all blocks in the rows from `from` up. These blocks must have the springs and the mass of a block
/// inside the lattice, except for blocks at free sides, which [`move_side_block`] computes. Vector lanes beyond the
/// last column overwrite the padding of the rows, which the caller restores.
pub struct InsideRows<'a, R> {
    pub field: &'a mut Field<R>,
    pub from: usize,
    pub kick: Kick,
    /// Drag of the moving frame along x, from `Kick::drag`.
    pub drag: f64,
}

/// Sums and differences of the displacements x and y of the east (E) and west (W) neighbours of a block, shared by the
/// rows above and below: `along` = x_E + x_W, `x_plus` and `x_minus` = x_E + x_W +- (y_E - y_W), `y_plus` and `y_minus`
/// = y_E + y_W +- (x_E - x_W).
struct RowSums<V> {
    along: V,
    x_plus: V,
    x_minus: V,
    y_plus: V,
    y_minus: V,
}

/// Three views of a plane as vectors, shifted by one column each: at the index of a block, `west`, `centre` and `east`
/// have the values of the west neighbour, the block itself, and the east neighbour.
#[derive(Clone, Copy)]
pub struct Views<'a, V> {
    pub west: &'a [V],
    pub centre: &'a [V],
    pub east: &'a [V],
}

impl<'a, V> Views<'a, V> {
    /// Views the first `count` vectors of `plane`.
    #[inline(always)]
    pub fn new<S: Simd, R: Real<Vector<S> = V>>(_: S, plane: &'a Plane<R>, count: usize) -> Self {
        let rows = plane.rows();
        Self {
            west: &R::vectors::<S>(&rows[R::LINE - 1..])[..count],
            centre: &R::vectors::<S>(&rows[R::LINE..])[..count],
            east: &R::vectors::<S>(&rows[R::LINE + 1..])[..count],
        }
    }
}

#[inline(always)]
fn row_sums<S: Simd, R: Real>(
    simd: S,
    x: Views<'_, R::Vector<S>>,
    y: Views<'_, R::Vector<S>>,
    at: usize,
) -> RowSums<R::Vector<S>> {
    let (x_sum, x_difference) = (R::add(simd, x.east[at], x.west[at]), R::sub(simd, x.east[at], x.west[at]));
    let (y_sum, y_difference) = (R::add(simd, y.east[at], y.west[at]), R::sub(simd, y.east[at], y.west[at]));
    RowSums {
        along: x_sum,
        x_plus: R::add(simd, x_sum, y_difference),
        x_minus: R::sub(simd, x_sum, y_difference),
        y_plus: R::add(simd, y_sum, x_difference),
        y_minus: R::sub(simd, y_sum, x_difference),
    }
}

impl<R: Real> WithSimd for InsideRows<'_, R> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { field: Field { nx, ny, stride, now, other }, from, kick: Kick { kept, kick }, drag } = self;
        let (vectors, row) = (nx.div_ceil(R::lanes::<S>()), *stride / R::lanes::<S>());
        let count = (*ny + 1) * row;
        let (x, y) = (Views::new(simd, &now[0], count), Views::new(simd, &now[1], count));
        let [other_x, other_y] = other;
        let new_x = &mut R::vectors_mut::<S>(&mut other_x.rows_mut()[R::LINE..])[..count];
        let new_y = &mut R::vectors_mut::<S>(&mut other_y.rows_mut()[R::LINE..])[..count];

        // u + kept (u - u_before) + kick (-3 u + ...) = stay u - kept u_before + kick (...)
        let stay = R::splat(simd, 1.0 + kept - 3.0 * kick);
        let (kept, kick, quarter) = (R::splat(simd, kept), R::splat(simd, kick), R::splat(simd, 0.25));
        let drag = R::splat(simd, drag);
        for column in 0..vectors {
            let mut at = from * row + column;
            let mut below = row_sums::<S, R>(simd, x, y, at - row);
            let mut here = row_sums::<S, R>(simd, x, y, at);
            let mut y_south = y.centre[at - row];
            for _ in from..*ny {
                let above = row_sums::<S, R>(simd, x, y, at + row);
                // F_x + 3 x = x_E + x_W + [(x_E + x_W + y_E - y_W)_N + (x_E + x_W - y_E + y_W)_S] / 4
                let diagonals = R::add(simd, above.x_plus, below.x_minus);
                let pull = R::scale_add(simd, quarter, diagonals, here.along);
                let inert = R::sub(simd, R::mul(simd, stay, x.centre[at]), R::mul(simd, kept, new_x[at]));
                new_x[at] = R::add(simd, R::add(simd, inert, drag), R::mul(simd, kick, pull));
                // F_y + 3 y = y_N + y_S + [(y_E + y_W + x_E - x_W)_N + (y_E + y_W - x_E + x_W)_S] / 4
                let diagonals = R::add(simd, above.y_plus, below.y_minus);
                let pull = R::scale_add(simd, quarter, diagonals, R::add(simd, y.centre[at + row], y_south));
                y_south = y.centre[at];
                let inert = R::sub(simd, R::mul(simd, stay, y_south), R::mul(simd, kept, new_y[at]));
                new_y[at] = R::add(simd, inert, R::mul(simd, kick, pull));
                below = here;
                here = above;
                at += row;
            }
        }
    }
}

/// Computes the spring forces on the blocks of row `row`, by column, with individual coefficients for every spring.
/// Forces are in units of k l (spring stiffness times lattice spacing).
pub struct RowForces<'a, R> {
    pub coefficients: &'a RowCoefficients<R>,
    pub field: &'a Field<R>,
    pub row: usize,
    pub force_x: &'a mut [R],
    pub force_y: &'a mut [R],
}

impl<R: Real> WithSimd for RowForces<'_, R> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { coefficients: k, field: Field { nx, ny, stride, now, .. }, row, force_x, force_y } = self;
        let (vectors, stride) = (nx.div_ceil(R::lanes::<S>()), *stride / R::lanes::<S>());
        let count = (*ny + 1) * stride;
        let (x, y) = (Views::new(simd, &now[0], count), Views::new(simd, &now[1], count));
        // Row 0 has no springs downwards: the values read for them are multiplied by zero.
        let (below, here, above) = (row.saturating_sub(1) * stride, row * stride, (row + 1) * stride);
        let [east, west, north, south, half_ne, half_sw, half_nw, half_se] =
            k.springs.each_ref().map(|values| &R::vectors::<S>(values)[..vectors]);
        let force_x = &mut R::vectors_mut::<S>(force_x)[..vectors];
        let force_y = &mut R::vectors_mut::<S>(force_y)[..vectors];
        let (add, sub, mul) = (|a, b| R::add(simd, a, b), |a, b| R::sub(simd, a, b), |a, b| R::mul(simd, a, b));
        for i in 0..vectors {
            let (hx, hy) = (x.centre[here + i], y.centre[here + i]);
            // Half the stiffness times the elongation along each diagonal: the entries of e e^T are 1/2.
            let along = |x, y| add(sub(x, hx), sub(y, hy));
            let across = |x, y| sub(sub(x, hx), sub(y, hy));
            let ne = mul(half_ne[i], along(x.east[above + i], y.east[above + i]));
            let sw = mul(half_sw[i], along(x.west[below + i], y.west[below + i]));
            let nw = mul(half_nw[i], across(x.west[above + i], y.west[above + i]));
            let se = mul(half_se[i], across(x.east[below + i], y.east[below + i]));
            let (rising, falling) = (add(ne, sw), add(nw, se));
            let (to_east, to_west) = (sub(x.east[here + i], hx), sub(x.west[here + i], hx));
            let straight = add(mul(east[i], to_east), mul(west[i], to_west));
            force_x[i] = add(straight, add(rising, falling));
            let (to_north, to_south) = (sub(y.centre[above + i], hy), sub(y.centre[below + i], hy));
            let straight = add(mul(north[i], to_north), mul(south[i], to_south));
            force_y[i] = add(straight, sub(rising, falling));
        }
    }
}

/// Takes one step of a row of blocks under the forces `force`; each block has `D` displacement components.
pub struct MoveRow<'a, R, const D: usize> {
    pub inverse_mass: &'a [R],
    /// Current displacements.
    pub now: &'a [Plane<R>; D],
    /// Displacements one step earlier, replaced by the displacements one step later.
    pub other: &'a mut [Plane<R>; D],
    /// Number of columns of the row.
    pub columns: usize,
    /// Index of the first column of the row in [`Plane::rows`].
    pub start: usize,
    pub kick: Kick,
    /// Drag of the moving frame along each axis, from `Kick::drag`.
    pub drag: [f64; D],
    pub force: [&'a [R]; D],
}

impl<R: Real, const D: usize> WithSimd for MoveRow<'_, R, D> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { inverse_mass, now, other, columns, start, kick: Kick { kept, kick }, drag, force } = self;
        let vectors = columns.div_ceil(R::lanes::<S>());
        let (kept, kick) = (R::splat(simd, kept), R::splat(simd, kick));
        let inverse_mass = &R::vectors::<S>(inverse_mass)[..vectors];
        for (((now, other), force), drag) in now.iter().zip(other).zip(force).zip(drag) {
            let drag = R::splat(simd, drag);
            let now = &R::vectors::<S>(&now.rows()[start..])[..vectors];
            let other = &mut R::vectors_mut::<S>(&mut other.rows_mut()[start..])[..vectors];
            let force = &R::vectors::<S>(force)[..vectors];
            for i in 0..vectors {
                // u_after = u + kept (u - u_before) + drag + kick F/m
                let kept = R::mul(simd, kept, R::sub(simd, now[i], other[i]));
                let coasting = R::add(simd, now[i], R::add(simd, kept, drag));
                other[i] = R::add(simd, coasting, R::mul(simd, R::mul(simd, kick, inverse_mass[i]), force[i]));
            }
        }
    }
}

/// Returns the displacements x and y after the step, in lattice spacings, of the block in column i of row j at a free
/// side. `field` must still contain the displacements of this block one step earlier.
pub fn move_side_block<R: Real>(site: &Site, field: &Field<R>, [i, j]: [usize; 2], kick: Kick, drag: f64) -> [f64; 2] {
    let Kick { kept, kick } = kick;
    let [east, west, north, south, north_east, south_west, north_west, south_east] = site.springs;
    let block = |east: usize, north: usize| {
        // Indices are one more than the offset, so that the lower left neighbour is (0, 0).
        let at = field.index(i + east, j + north - 1) - 1;
        [0, 1].map(|component: usize| field.now[component].rows()[at].to_f64())
    };
    let ([x, y], [xe, _], [xw, _], [_, yn], [_, ys]) =
        (block(1, 1), block(2, 1), block(0, 1), block(1, 2), block(1, 0));
    let along = |[bx, by]: [f64; 2]| (bx - x) + (by - y);
    let across = |[bx, by]: [f64; 2]| (bx - x) - (by - y);
    let rising = 0.5 * north_east * along(block(2, 2)) + 0.5 * south_west * along(block(0, 0));
    let falling = 0.5 * north_west * across(block(0, 2)) + 0.5 * south_east * across(block(2, 0));
    let force_x = east * (xe - x) + west * (xw - x) + (rising + falling);
    let force_y = north * (yn - y) + south * (ys - y) + (rising - falling);
    let (at, scale) = (field.index(i, j), kick * site.inverse_mass);
    let before = [0, 1].map(|component: usize| field.other[component].rows()[at].to_f64());
    [x + (kept * (x - before[0]) + drag) + scale * force_x, y + kept * (y - before[1]) + scale * force_y]
}

#[cfg(test)]
mod tests {
    use std::marker::PhantomData;

    use super::super::rows::INSIDE;
    use super::super::tests::any_width::{assert_same_bits, fill};
    use super::*;

    /// A field of `nx` columns with values of various magnitudes, and coefficients of a row.
    fn field<R: Real>(nx: usize) -> (Field<R>, RowCoefficients<R>) {
        let mut field = Field::at_rest(nx, 5);
        let size = R::LINE + 6 * field.stride;
        fill(field.now.iter_mut().chain(&mut field.other), size);
        let sites: Vec<Site> = (0..nx)
            .map(|i| {
                let mut springs = INSIDE;
                springs[0] = 1.0 / (1.0 + i as f64);
                Site { springs, inverse_mass: 1.3 }
            })
            .collect();
        (field, RowCoefficients::new(&sites))
    }

    /// All results of the sweeps, by column and row.
    struct Swept<R> {
        nx: usize,
        precision: PhantomData<R>,
    }

    impl<R: Real> WithSimd for Swept<R> {
        type Output = Vec<f64>;

        fn with_simd<S: Simd>(self, simd: S) -> Vec<f64> {
            let nx = self.nx;
            let (mut field, coefficients) = field::<R>(nx);
            let kick = Kick::new(0.3, 0.02);
            let padded = coefficients.inverse_mass.len();
            let (mut force_x, mut force_y) = (vec![R::default(); padded], vec![R::default(); padded]);
            let mut written = Vec::new();
            let mut write = |values: &[R]| written.extend(values[..nx].iter().map(|value| value.to_f64()));
            for row in 0..2 {
                let forces =
                    |force_x, force_y| RowForces { coefficients: &coefficients, field: &field, row, force_x, force_y };
                simd.vectorize(forces(&mut force_x, &mut force_y));
                [&force_x, &force_y].into_iter().for_each(|force| write(force));
            }
            let (inverse_mass, start, force) =
                (&coefficients.inverse_mass, field.index(0, 1), [&force_x[..], &force_y]);
            let (now, other) = (&field.now, &mut field.other);
            let drag = [-1e-5, 0.0];
            simd.vectorize(MoveRow { inverse_mass, now, other, columns: nx, start, kick, drag, force });
            simd.vectorize(InsideRows { field: &mut field, from: 2, kick, drag: -1e-5 });
            for plane in &field.other {
                for j in 1..field.ny {
                    write(&plane.rows()[field.index(0, j)..]);
                }
            }
            written
        }
    }

    #[test]
    fn vectors_of_any_width_give_the_same_bits() {
        for nx in [1, 3, 8, 50, 101] {
            assert_same_bits(&format!("{nx} columns"), || Swept { nx, precision: PhantomData::<f64> });
            assert_same_bits(&format!("{nx} columns, single"), || Swept { nx, precision: PhantomData::<f32> });
        }
    }
}
