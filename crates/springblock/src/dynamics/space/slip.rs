//! Friction on one contact block that moves in the plane of contact.
//!
//! At rest friction balances the horizontal force vector until its magnitude exceeds max(mu_s, mu_d) f(p) F_n; sliding
//! its magnitude is mu_d f(p) F_n. Over one leapfrog step, with the velocities v before and v' after it (times the
//! step) and the spring force F,
//!
//! ```text
//! v' = free - kick R d,   free = kept v + kick F,   d = (v + v') / |v + v'| = (v + free) / |v + free|,
//! ```
//!
//! friction R d points against the mean of the two velocities, of second order in the step, and takes the work R |v +
//! v'|/2 of every step. A step whose v' would have no part along v ends at rest: friction could stop the block within
//! it. Along one axis these are the formulas of the vertical plane.

use super::super::contact::{GripPiece, Motion};
use crate::draws::Coefficients;

/// One contact block. Forces in units of k l.
#[derive(Clone, Copy, Debug)]
pub struct SlipBlock {
    /// Local coefficients.
    pub coefficients: Coefficients,
    /// State of motion.
    pub motion: Motion,
    /// Whether it has slipped along the drive, or was free to, since the drive began.
    pub has_slipped: bool,
    /// Its place in arrays over the contact layer.
    pub place: usize,
    /// Normal force, positive in compression, at the last force evaluation.
    pub normal: f64,
    /// Friction, as a resistance to motion along x and y, at the last force evaluation.
    pub friction: [f64; 2],
}

/// What a step does to one contact block.
#[derive(Clone, Copy, Debug)]
pub struct Push {
    /// Share of the velocity that damping leaves.
    pub kept: f64,
    /// Displacement per step that a unit force adds.
    pub kick: f64,
    /// Spring forces.
    pub force: [f64; 3],
    /// Direction of the drive.
    pub drive: [f64; 2],
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

impl SlipBlock {
    /// A block at rest.
    #[must_use]
    pub const fn new(place: usize, coefficients: Coefficients) -> Self {
        Self { coefficients, motion: Motion::Rest, has_slipped: false, place, normal: 0.0, friction: [0.0; 2] }
    }

    fn let_go(&mut self, free: [f64; 2]) -> [f64; 2] {
        self.friction = [0.0; 2];
        self.has_slipped = true;
        if self.motion == Motion::Rest {
            self.motion = Motion::Slip;
        }
        free
    }

    /// Velocity times the step after one leapfrog kick. `piece_at` gives the interval of the law around a normal force
    /// above zero.
    pub fn kick(&mut self, v: [f64; 2], push: Push, piece_at: impl FnOnce(f64) -> GripPiece) -> [f64; 2] {
        let Push { kept, kick, force: [fx, fy, fz], drive } = push;
        let force = [fx, fy];
        let free = [kept * v[0] + kick * fx, kept * v[1] + kick * fy];
        // F_n = -(force of the springs)_z
        self.normal = if self.motion == Motion::Lifted { 0.0 } else { -fz };
        if self.normal <= 0.0 {
            return self.let_go(free);
        }
        let grip = piece_at(self.normal).grip(self.normal);
        let threshold = self.coefficients.starting_mu() * grip;
        if threshold == 0.0 {
            // A law that reaches zero holds nothing, and a reversal is no end of motion.
            return self.let_go(free);
        }
        if self.motion == Motion::Rest {
            if dot(force, force) <= threshold * threshold {
                self.friction = force;
                return v;
            }
            self.motion = Motion::Slip;
        }
        let resistance = self.coefficients.dynamic_mu * grip;
        let along = [free[0] + v[0], free[1] + v[1]];
        self.has_slipped |= dot(along, drive) > 0.0;
        let per_length = resistance / dot(along, along).sqrt();
        let friction = [per_length * along[0], per_length * along[1]];
        let slowed = [free[0] - kick * friction[0], free[1] - kick * friction[1]];
        // A block that starts has no velocity yet: it moves along the force.
        let before = if v == [0.0; 2] { force } else { v };
        if dot(free, before) > 0.0 && dot(slowed, before) > 0.0 {
            self.friction = friction;
            slowed
        } else {
            // The step ends at rest: friction is what it took to stop the block.
            self.motion = Motion::Rest;
            self.friction = [free[0] / kick, free[1] / kick];
            [0.0; 2]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: GripPiece = GripPiece { from: 0.0, to: f64::INFINITY, constant: 0.0, linear: 1.0, quadratic: 0.0 };

    fn block(static_mu: f64, dynamic_mu: f64) -> SlipBlock {
        SlipBlock::new(0, Coefficients { static_mu, dynamic_mu })
    }

    fn kick(block: &mut SlipBlock, v: [f64; 2], force: [f64; 3]) -> [f64; 2] {
        block.kick(v, Push { kept: 1.0, kick: 0.1, force, drive: [1.0, 0.0] }, |_| UNIT)
    }

    /// Angles in a fixed sequence.
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
            // kick (F - mu_d N) along the force
            assert!((v[0] - 0.004 * cos).abs() < 1e-15 && (v[1] - 0.004 * sin).abs() < 1e-15, "{angle} {v:?}");
            assert!((own.friction[0].hypot(own.friction[1]) - 0.27).abs() < 1e-15);
            assert_eq!(own.has_slipped, cos > 0.0, "along the drive, which is x");
        }
    }

    #[test]
    fn a_lone_block_runs_straight_on_and_stops_at_the_closed_form_distance() {
        for angle in angles() {
            let (sin, cos) = angle.sin_cos();
            let mut own = block(0.3, 0.27);
            own.motion = Motion::Slip;
            // Deceleration a = mu_d N / m: kick = dt^2/m. From v the block goes v^2/(2 a), within a step.
            let (speed, kick, dt) = (0.8, 1e-4, 1e-2);
            let mut v = [speed * dt * cos, speed * dt * sin];
            let mut at = [0.0; 2];
            let mut steps = 0;
            while v != [0.0; 2] {
                // Velocities lie half a step before forces: the first step starts there.
                v = own.kick(v, Push { kept: 1.0, kick, force: [0.0, 0.0, -1.0], drive: [1.0, 0.0] }, |_| UNIT);
                at = [at[0] + v[0], at[1] + v[1]];
                assert!((at[0] * sin - at[1] * cos).abs() < 1e-12, "leaves its line");
                steps += 1;
                assert!(steps < 1000);
            }
            let expected = speed * speed / (2.0 * 0.27);
            let way = at[0].hypot(at[1]);
            assert!((way - expected).abs() < speed * dt, "{angle}: {way} {expected}");
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
                // The same along x alone, against the plane's law.
                let (v, f) = (v[0], pull * if number % 2 == 0 { 1.0 } else { -1.0 });
                let coefficients = [Coefficients { static_mu: 0.3, dynamic_mu: 0.27 }];
                let mut row = ContactRow::new([0].into_iter(), &coefficients, LocalLaw::new(None, 1.0));
                row.all_slip();
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
