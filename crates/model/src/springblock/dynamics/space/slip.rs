//! Friction on one contact block that moves in the plane of contact.
//!
//! At rest friction balances the horizontal force vector until its magnitude exceeds max(mu_s, mu_d) f(p) F_n; in
//! sliding its magnitude is mu_d f(p) F_n. Over one leapfrog step with the velocities v before and v' after it (times
//! the step) and the spring force F,
//!
//! ```text
//! v' = free - kick R d,   free = kept v + kick F,   d = (v + v') / |v + v'| = (v + free) / |v + free|,
//! ```
//!
//! The friction R d, with the resistance R = mu_d f(p) F_n, is opposite to the mean of the two velocities, of second
//! order in the step, and dissipates R |v + v'|/2 in every step. A step ends at rest if v' would have no component
//! along v, since friction could stop the block within the step. Starts and stops occur as in the plane; for motion
//! along one axis these formulas are those of the plane. The vectorized pass applies the same formulas to all blocks
//! whose motion continues as before.

use pulp::{Simd, WithSimd};

use super::super::contact::{ContactBlock, Motion, Slide, StepFactors, stopping_distance};
use super::super::contact_vectors::Pass;

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

impl Slide<2> for ContactBlock<2> {
    #[inline]
    fn is_held(force: [f64; 2], threshold: f64) -> bool {
        dot(force, force) <= threshold * threshold
    }

    #[inline]
    fn start(&mut self, factors: &StepFactors<2>, resistance: f64) -> [f64; 2] {
        self.has_slipped |= dot(factors.force, factors.drive) > 0.0;
        let share = 1.0 - resistance / dot(factors.force, factors.force).sqrt();
        factors.force.map(|force| factors.kick * share * force)
    }

    #[inline]
    fn slide(&mut self, v: [f64; 2], free: [f64; 2], factors: &StepFactors<2>, resistance: f64) -> [f64; 2] {
        let along = [free[0] + v[0], free[1] + v[1]];
        self.has_slipped |= dot(along, factors.drive) > 0.0;
        let per_length = resistance / dot(along, along).sqrt();
        let friction = [per_length * along[0], per_length * along[1]];
        let slowed = [free[0] - factors.kick * friction[0], free[1] - factors.kick * friction[1]];
        // A block that starts has no velocity yet and moves along the force.
        let before = if v == [0.0; 2] { factors.force } else { v };
        if dot(free, before) > 0.0 && dot(slowed, before) > 0.0 {
            self.friction = friction;
            slowed
        } else {
            // The step ends at rest; friction is the force that stopped the block.
            self.motion = Motion::Rest;
            let speed = dot(v, v).sqrt();
            let after = dot(free, v) / speed - factors.kick * resistance;
            let rest = if speed > 0.0 { v.map(|v| v * (stopping_distance(speed, after) / speed)) } else { [0.0; 2] };
            self.friction = [0, 1].map(|axis: usize| (free[axis] - rest[axis]) / factors.kick);
            rest
        }
    }
}

#[inline(always)]
fn dots<S: Simd>(simd: S, a: [S::f64s; 2], b: [S::f64s; 2]) -> S::f64s {
    simd.add_f64s(simd.mul_f64s(a[0], b[0]), simd.mul_f64s(a[1], b[1]))
}

impl WithSimd for Pass<'_, 2> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        let Self { columns: c, velocity: [vx, vy], normal, friction: [rx, ry], .. } = self;
        let Self { sliding, unhandled, force: [fx, fy], lift, kept, .. } = self;
        let vectors = normal.len() / S::F64_LANES;
        let column = |values| &S::as_simd_f64s(values).0[..vectors];
        let column_mut = |values| &mut S::as_mut_simd_f64s(values).0[..vectors];
        let (vx, vy, normal) = (column_mut(vx), column_mut(vy), column_mut(normal));
        let (rx, ry, sliding, unhandled) = (column_mut(rx), column_mut(ry), column_mut(sliding), column_mut(unhandled));
        let (fx, fy, lift, kick) = (column(fx), column(fy), column(lift), column(&c.kick));
        let (constant, linear, quadratic) = (column(&c.constant), column(&c.linear), column(&c.quadratic));
        let (from, to) = (column(&c.from), column(&c.to));
        let (starting_mu, dynamic_mu) = (column(&c.starting_mu), column(&c.dynamic_mu));
        let (zero, one) = (simd.splat_f64s(0.0), simd.splat_f64s(1.0));
        let kept = simd.splat_f64s(kept);
        let mut any = zero;
        for i in 0..vectors {
            let (v, force, pressing) = ([vx[i], vy[i]], [fx[i], fy[i]], simd.neg_f64s(lift[i]));
            let bent = simd.mul_f64s(pressing, quadratic[i]);
            let grip = simd.add_f64s(constant[i], simd.mul_f64s(pressing, simd.add_f64s(linear[i], bent)));
            let known =
                simd.and_m64s(simd.less_than_or_equal_f64s(from[i], pressing), simd.less_than_f64s(pressing, to[i]));
            let at_rest = simd.and_m64s(simd.equal_f64s(v[0], zero), simd.equal_f64s(v[1], zero));
            let threshold = simd.mul_f64s(starting_mu[i], grip);
            let is_held = simd.less_than_or_equal_f64s(dots(simd, force, force), simd.mul_f64s(threshold, threshold));
            let free_x = simd.add_f64s(simd.mul_f64s(kept, v[0]), simd.mul_f64s(kick[i], force[0]));
            let free_y = simd.add_f64s(simd.mul_f64s(kept, v[1]), simd.mul_f64s(kick[i], force[1]));
            // mu_d f(p) F_n against the mean of the velocities before and after the step
            let along = [simd.add_f64s(free_x, v[0]), simd.add_f64s(free_y, v[1])];
            let length = simd.sqrt_f64s(dots(simd, along, along));
            sliding[i] = simd.mul_f64s(dynamic_mu[i], grip);
            let per_length = simd.div_f64s(sliding[i], length);
            let resistance_x = simd.mul_f64s(per_length, along[0]);
            let resistance_y = simd.mul_f64s(per_length, along[1]);
            let slowed_x = simd.sub_f64s(free_x, simd.mul_f64s(kick[i], resistance_x));
            let slowed_y = simd.sub_f64s(free_y, simd.mul_f64s(kick[i], resistance_y));
            let keeps_sliding = simd.and_m64s(
                simd.less_than_f64s(zero, dots(simd, [free_x, free_y], v)),
                simd.less_than_f64s(zero, dots(simd, [slowed_x, slowed_y], v)),
            );
            // A block at rest has v = 0, so that `keeps_sliding` is false.
            let continues = simd.and_m64s(known, simd.or_m64s(simd.and_m64s(at_rest, is_held), keeps_sliding));
            let moves = simd.and_m64s(continues, keeps_sliding);
            vx[i] = simd.select_f64s(moves, slowed_x, v[0]);
            vy[i] = simd.select_f64s(moves, slowed_y, v[1]);
            rx[i] = simd.select_f64s(at_rest, force[0], resistance_x);
            ry[i] = simd.select_f64s(at_rest, force[1], resistance_y);
            normal[i] = pressing;
            unhandled[i] = simd.select_f64s(continues, zero, one);
            any = simd.add_f64s(any, unhandled[i]);
        }
        simd.reduce_sum_f64s(any) > 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::contact::GripPiece;
    use super::*;
    use crate::springblock::draws::Coefficients;

    const UNIT: GripPiece = GripPiece { from: 0.0, to: f64::INFINITY, constant: 0.0, linear: 1.0, quadratic: 0.0 };

    fn block(static_mu: f64, dynamic_mu: f64) -> ContactBlock<2> {
        ContactBlock::new(0, Coefficients { static_mu, dynamic_mu })
    }

    fn kick(block: &mut ContactBlock<2>, v: [f64; 2], [fx, fy, lift]: [f64; 3]) -> [f64; 2] {
        let factors = StepFactors { kept: 1.0, kick: 0.1, force: [fx, fy], lift, drive: [1.0, 0.0] };
        block.kick(v, factors, |normal| UNIT.grip(normal))
    }

    /// A fixed sequence of angles.
    fn angles() -> impl Iterator<Item = f64> {
        (0..48).map(|step| f64::from(step) * 0.1309 + 0.003)
    }

    #[test]
    fn a_block_at_rest_is_held_up_to_the_same_magnitude_in_every_direction() {
        for angle in angles() {
            let (sin, cos) = angle.sin_cos();
            let mut own = block(0.3, 0.27);
            assert_eq!(kick(&mut own, [0.0; 2], [0.2999 * cos, 0.2999 * sin, -1.0]), [0.0; 2]);
            assert_eq!((own.friction, own.motion), ([0.2999 * cos, 0.2999 * sin], Motion::Rest));
            let v = kick(&mut own, [0.0; 2], [0.31 * cos, 0.31 * sin, -1.0]);
            // kick (F - mu_d N) / 2 along the force: half a step at rest, half a step sliding.
            assert!((v[0] - 0.002 * cos).abs() < 1e-15 && (v[1] - 0.002 * sin).abs() < 1e-15, "{angle} {v:?}");
            assert!((own.friction[0].hypot(own.friction[1]) - 0.29).abs() < 1e-15);
            assert_eq!(own.has_slipped, cos > 0.0, "along the drive, which is x");
        }
    }

    #[test]
    fn a_lone_block_runs_straight_on_and_stops_at_the_closed_form_distance() {
        for angle in angles() {
            let (sin, cos) = angle.sin_cos();
            let mut own = block(0.3, 0.27);
            own.motion = Motion::Slip;
            // Deceleration a = mu_d N / m: kick = dt^2/m. From v the block slides v^2/(2 a), to within a step.
            let (speed, kick, dt) = (0.8, 1e-4, 1e-2);
            // Velocities are half a step before forces.
            let half = speed * dt + 0.5 * kick * 0.27;
            let mut v = [half * cos, half * sin];
            let mut at = [0.0; 2];
            let mut steps = 0;
            while v != [0.0; 2] {
                let factors = StepFactors { kept: 1.0, kick, force: [0.0; 2], lift: -1.0, drive: [1.0, 0.0] };
                v = own.kick(v, factors, |normal| UNIT.grip(normal));
                at = [at[0] + v[0], at[1] + v[1]];
                assert!((at[0] * sin - at[1] * cos).abs() < 1e-12, "leaves its line");
                steps += 1;
                assert!(steps < 1000);
            }
            let expected = speed * speed / (2.0 * 0.27);
            let way = at[0].hypot(at[1]);
            assert!((way - expected).abs() < 1e-12, "{angle}: {way} {expected}");
            assert_eq!(own.motion, Motion::Rest);
        }
    }

    #[test]
    fn friction_takes_work_whatever_the_force_and_along_an_axis_it_is_that_of_the_plane() {
        use super::super::super::contact::{ContactRow, LocalLaw};
        for (number, angle) in angles().enumerate() {
            let (sin, cos) = angle.sin_cos();
            for pull in [0.0, 0.1, 0.5, 3.0] {
                let v = [1e-2 * cos, -2e-2 * sin];
                let mut own = block(0.3, 0.27);
                own.motion = Motion::Slip;
                let after = kick(&mut own, v, [pull * sin, pull * cos, -1.0]);
                let work = dot(own.friction, [v[0] + after[0], v[1] + after[1]]);
                if own.motion == Motion::Slip {
                    assert!((own.friction[0].hypot(own.friction[1]) - 0.27).abs() < 1e-14);
                    assert!(work > 0.0, "{angle} {pull}");
                }
                // Motion along x only, compared with the law of the plane.
                let (v, f) = (v[0], pull * if number % 2 == 0 { 1.0 } else { -1.0 });
                let coefficients = [Coefficients { static_mu: 0.3, dynamic_mu: 0.27 }];
                let mut row = ContactRow::new([0].into_iter(), &coefficients, LocalLaw::new(None, 1.0));
                row.blocks[0].motion = Motion::Slip;
                let mut plane = [v];
                let sums = row.kick(&mut plane, &[f], &[-1.0], 1.0, &[0.1]);
                let mut own = block(0.3, 0.27);
                own.motion = Motion::Slip;
                let after = kick(&mut own, [v, 0.0], [f, 0.0, -1.0]);
                assert!((after[0] - plane[0]).abs() < 1e-16 && after[1] == 0.0, "{v} {f}: {after:?} {plane:?}");
                assert!((own.friction[0] - sums.friction).abs() < 1e-15);
                assert_eq!(own.motion, row.blocks[0].motion);
            }
        }
    }

    #[test]
    fn tension_carries_no_friction() {
        let mut own = block(0.3, 0.27);
        let v = kick(&mut own, [0.0; 2], [0.1, 0.2, 0.5]);
        assert!((v[0] - 0.01).abs() < 1e-15 && (v[1] - 0.02).abs() < 1e-15);
        assert_eq!((own.friction, own.normal, own.motion), ([0.0; 2], -0.5, Motion::Slip));
    }
}
