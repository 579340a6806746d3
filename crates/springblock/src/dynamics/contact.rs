//! Friction on the row of contact blocks.
//!
//! At rest friction balances the horizontal force up to max(mu_s, mu_d) f(p) F_n; sliding it is
//! mu_d f(p) F_n against the velocity; a step that would reverse the velocity ends at rest. The law
//! sees the local pressure and the direction of slip, nothing more.
//!
//! The leapfrog has forces at whole steps and velocities between them. A block that lets go at one instant is fast by half a kick
//! half a step later, and one whose velocity reverses about an instant stands where it turns, v^2 / 2 a further on: so a slip is as
//! long as in exact time but for the square of the step. A whole kick at the start and a stop at the instant would make it longer by
//! 1 / cos(theta / 2) with theta the phase of a step, and shorter by up to (theta / 4)^2.

use slipgrid_material::{AreaLaw, Piece};

use super::sweep::Kick;
use crate::draws::Coefficients;

/// Local friction law: what a block of given coefficients resists at a given normal force.
#[derive(Clone, Copy, Debug)]
pub struct LocalLaw<'a> {
    area_law: Option<&'a AreaLaw>,
    /// Pressure of a unit normal force on one block, in pascals.
    unit_pressure_pa: f64,
}

impl<'a> LocalLaw<'a> {
    /// A law for normal forces in units of `unit_pressure_pa` l^2.
    #[must_use]
    pub const fn new(area_law: Option<&'a AreaLaw>, unit_pressure_pa: f64) -> Self {
        Self { area_law, unit_pressure_pa }
    }

    /// Interval of normal forces around `normal` in which friction per unit coefficient is a polynomial.
    pub fn piece(&self, normal: f64) -> GripPiece {
        let unit_pa = self.unit_pressure_pa;
        let piece = self.area_law.map_or(Piece::PROPORTIONAL, |law| law.piece(normal * unit_pa));
        GripPiece {
            from: piece.from_pa / unit_pa,
            to: piece.to_pa / unit_pa,
            constant: piece.constant_pa / unit_pa,
            linear: piece.linear,
            quadratic: piece.quadratic_per_pa * unit_pa,
        }
    }

    /// f(p) F_n: friction per unit coefficient. `near` remembers the interval of the law's table.
    fn grip(&self, normal: f64, near: &mut usize) -> f64 {
        match self.area_law {
            Some(law) => normal * law.factor_near(normal * self.unit_pressure_pa, near),
            None => normal,
        }
    }
}

/// f(p) F_n = constant + linear F_n + quadratic F_n^2 for normal forces from `from` up to `to`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GripPiece {
    pub from: f64,
    pub to: f64,
    pub constant: f64,
    pub linear: f64,
    pub quadratic: f64,
}

impl GripPiece {
    /// f(p) F_n at the normal force `normal`.
    #[must_use]
    pub fn grip(&self, normal: f64) -> f64 {
        self.constant + normal * (self.linear + normal * self.quadratic)
    }
}

/// How a contact block moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// Held by friction.
    Rest,
    /// Sliding, or free to move because it carries no pressure.
    Slip,
    /// Off the counterface (unilateral contact only).
    Lifted,
}

/// One contact block, which moves along `H` horizontal axes: 1 in the plane, 2 in space. Forces in units of k l.
#[derive(Clone, Copy, Debug)]
pub struct ContactBlock<const H: usize> {
    /// Local coefficients.
    pub coefficients: Coefficients,
    /// State of motion.
    pub motion: Motion,
    /// Whether it has slipped along the drive, or was free to, since the drive began.
    pub has_slipped: bool,
    /// Its column: its place in arrays over the contact blocks.
    pub column: usize,
    /// Vertical displacement at which it touches the counterface: the height of its face, in lattice spacings.
    pub face: f64,
    /// Normal force, positive in compression, at the last force evaluation.
    pub normal: f64,
    /// Friction, as a resistance to motion along each axis, at the last force evaluation.
    pub friction: [f64; H],
    /// mu_d f(p) F_n at the last force evaluation: its friction if it slides.
    pub sliding: f64,
}

/// What a leapfrog step does to a contact block.
#[derive(Clone, Copy, Debug)]
pub struct Push<const H: usize> {
    /// Share of the velocity that damping leaves.
    pub kept: f64,
    /// Displacement per step that a unit force adds.
    pub kick: f64,
    /// Horizontal spring forces.
    pub force: [f64; H],
    /// Vertical spring force: minus the normal force on the counterface.
    pub lift: f64,
    /// Direction of the drive.
    pub drive: [f64; H],
}

/// The friction law along `H` axes.
pub trait Slide<const H: usize> {
    /// Whether friction up to `threshold` holds a block at rest against `force`.
    fn is_held(force: [f64; H], threshold: f64) -> bool;

    /// Velocity times the step that a whole step gives a block at rest against `resistance`, below the force on it.
    fn start(&mut self, push: &Push<H>, resistance: f64) -> [f64; H];

    /// Velocity times the step after a step in which the block slides against `resistance`: from `v`, and `free` where nothing
    /// resisted.
    fn slide(&mut self, v: [f64; H], free: [f64; H], push: &Push<H>, resistance: f64) -> [f64; H];
}

/// What the spring forces of an instant mean for a contact block.
enum Meeting {
    /// It carries no pressure: no friction.
    Free,
    /// It stays at rest; friction balances the horizontal force.
    Held,
    /// It starts to slide against mu_d f(p) F_n.
    Starting { resistance: f64 },
    /// It slides against the same.
    Sliding { resistance: f64 },
}

impl<const H: usize> ContactBlock<H> {
    /// A block at rest.
    #[must_use]
    pub const fn new(column: usize, coefficients: Coefficients) -> Self {
        Self {
            coefficients,
            motion: Motion::Rest,
            has_slipped: false,
            column,
            face: 0.0,
            normal: 0.0,
            friction: [0.0; H],
            sliding: 0.0,
        }
    }

    /// Its face raised by `face` and itself displaced vertically by `height`: off the counterface where that is higher.
    pub fn place(&mut self, face: f64, height: f64) {
        self.face = face;
        if height > face {
            self.motion = Motion::Lifted;
        }
    }

    fn let_go(&mut self) -> Meeting {
        (self.friction, self.sliding) = ([0.0; H], 0.0);
        self.has_slipped = true;
        if self.motion == Motion::Rest {
            self.motion = Motion::Slip;
        }
        Meeting::Free
    }

    /// Vertical motion under unilateral contact: lifts a block under tension, moves one in the air, lands one that reaches the
    /// counterface. `fall`: vertical displacement of the last step; `force`: vertical spring force. Returns the height after
    /// the step where it began at `height` in the air.
    pub fn fly(&mut self, height: f64, fall: &mut f64, kick: Kick, inverse_mass: f64, force: f64) -> Option<f64> {
        if self.motion != Motion::Lifted && self.normal < 0.0 {
            self.motion = Motion::Lifted;
        }
        if self.motion != Motion::Lifted {
            return None;
        }
        *fall = kick.kept * *fall + kick.kick * inverse_mass * force;
        let height = height + *fall;
        if height > self.face || height.is_nan() {
            return Some(height);
        }
        // Landing ends the vertical motion on the counterface.
        *fall = 0.0;
        self.motion = Motion::Slip;
        Some(self.face)
    }
}

impl<const H: usize> ContactBlock<H>
where
    Self: Slide<H>,
{
    /// Takes note of the spring forces: normal force, friction at rest, and whether the block starts.
    /// `grip_at` gives f(p) F_n for a normal force above zero.
    #[inline]
    fn meet(&mut self, force: [f64; H], lift: f64, grip_at: impl FnOnce(f64) -> f64) -> Meeting {
        // F_n = -(vertical force of the springs)
        self.normal = if self.motion == Motion::Lifted { 0.0 } else { -lift };
        if self.normal <= 0.0 {
            return self.let_go();
        }
        let grip = grip_at(self.normal);
        let threshold = self.coefficients.starting_mu() * grip;
        if threshold == 0.0 {
            // A law that reaches zero holds nothing, and a reversal is no end of motion.
            return self.let_go();
        }
        self.sliding = self.coefficients.dynamic_mu * grip;
        if self.motion == Motion::Rest {
            if Self::is_held(force, threshold) {
                self.friction = force;
                return Meeting::Held;
            }
            self.motion = Motion::Slip;
            return Meeting::Starting { resistance: self.sliding };
        }
        Meeting::Sliding { resistance: self.sliding }
    }

    /// Velocity times the step after one leapfrog kick from `v`; `grip_at` gives f(p) F_n for a normal force above zero.
    #[inline]
    pub fn kick(&mut self, v: [f64; H], push: Push<H>, grip_at: impl FnOnce(f64) -> f64) -> [f64; H] {
        let free = std::array::from_fn(|axis| push.kept * v[axis] + push.kick * push.force[axis]);
        let after = match self.meet(push.force, push.lift, grip_at) {
            Meeting::Free => return free,
            Meeting::Sliding { resistance } => return self.slide(v, free, &push, resistance),
            Meeting::Held if v == [0.0; H] => return v,
            Meeting::Held => [0.0; H],
            // At rest until now, and half a step later half a kick fast.
            Meeting::Starting { resistance } => self.start(&push, resistance).map(|v| 0.5 * v),
        };
        self.friction = std::array::from_fn(|axis| (free[axis] - after[axis]) / push.kick);
        after
    }
}

impl ContactBlock<1> {
    /// Takes note of a slip in `direction`: what load or waves push against the drive does not slide with it.
    fn slips(&mut self, direction: f64) {
        self.has_slipped |= direction > 0.0;
    }
}

impl Slide<1> for ContactBlock<1> {
    #[inline]
    fn is_held([force]: [f64; 1], threshold: f64) -> bool {
        force.abs() <= threshold
    }

    #[inline]
    fn start(&mut self, push: &Push<1>, resistance: f64) -> [f64; 1] {
        let direction = slip_direction(0.0, push.force[0]);
        self.slips(direction);
        [push.kick * (push.force[0] - direction * resistance)]
    }

    #[inline]
    fn slide(&mut self, [v]: [f64; 1], [free]: [f64; 1], push: &Push<1>, resistance: f64) -> [f64; 1] {
        let direction = slip_direction(v, push.force[0]);
        self.slips(direction);
        let slowed = free - direction * push.kick * resistance;
        if slowed * direction > 0.0 {
            self.friction = [direction * resistance];
            [slowed]
        } else {
            // The step ends at rest: friction is what it took to stop the block.
            self.motion = Motion::Rest;
            let rest = direction * left_to_go(v * direction, slowed * direction);
            self.friction = [(free - rest) / push.kick];
            [rest]
        }
    }
}

/// Sums over the contact row at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactSums {
    /// Friction, positive against the drive.
    pub friction: f64,
    /// Friction across the drive; none in the vertical plane.
    pub across: f64,
    /// Normal forces of compressive blocks.
    pub normal: f64,
    /// mu_d f(p) F_n of all: the friction if every block slides.
    pub sliding: f64,
}

impl ContactSums {
    /// Whether friction and normal force are numbers: a run that blows up has others.
    #[must_use]
    pub const fn is_finite(&self) -> bool {
        self.friction.is_finite() && self.normal.is_finite()
    }

    /// Takes the sums of another part of the row.
    pub fn add(&mut self, other: Self) {
        self.friction += other.friction;
        self.across += other.across;
        self.normal += other.normal;
        self.sliding += other.sliding;
    }

    fn add_block(&mut self, block: &ContactBlock<1>) {
        self.friction += block.friction[0];
        self.normal += block.normal.max(0.0);
        self.sliding += block.sliding;
    }
}

/// Forces on one contact block, at an instant or in the mean.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactForce {
    /// Normal force, positive in compression.
    pub normal: f64,
    /// Friction, positive against the drive.
    pub friction: f64,
}

/// The contact row of the plane, block by block.
#[derive(Clone, Debug)]
pub struct ContactRow<'a> {
    /// Contact blocks, left to right.
    pub blocks: Vec<ContactBlock<1>>,
    /// Intervals of the law's table that they were on last.
    near: Vec<usize>,
    law: LocalLaw<'a>,
}

impl<'a> ContactRow<'a> {
    /// Blocks in `columns`, at rest, with the coefficients of their columns.
    #[must_use]
    pub fn new(columns: impl Iterator<Item = usize>, coefficients: &[Coefficients], law: LocalLaw<'a>) -> Self {
        let blocks: Vec<_> = columns.map(|column| ContactBlock::new(column, coefficients[column])).collect();
        Self { near: vec![0; blocks.len()], blocks, law }
    }

    /// Gives every block its face and its vertical displacement, by column.
    pub fn place(&mut self, face_and_height: impl Fn(usize) -> [f64; 2]) {
        for block in &mut self.blocks {
            let [face, height] = face_and_height(block.column);
            block.place(face, height);
        }
    }

    /// Its blocks and their law.
    #[must_use]
    pub fn into_parts(self) -> (Vec<ContactBlock<1>>, LocalLaw<'a>) {
        (self.blocks, self.law)
    }

    /// Sets every block in motion.
    #[cfg(test)]
    pub fn all_slip(&mut self) {
        for block in &mut self.blocks {
            block.motion = Motion::Slip;
            block.has_slipped = true;
        }
    }

    /// Starts the account of which blocks have slipped: the bulk begins to move.
    pub fn begin_drive(&mut self) {
        for block in &mut self.blocks {
            block.has_slipped = false;
        }
    }

    /// Whether every block has slipped since the drive began.
    #[must_use]
    pub fn all_have_slipped(&self) -> bool {
        self.blocks.iter().all(|block| block.has_slipped)
    }

    /// Forces on the blocks at the last force evaluation.
    #[must_use]
    pub fn forces(&self) -> Vec<ContactForce> {
        let force = |block: &ContactBlock<1>| ContactForce { normal: block.normal, friction: block.friction[0] };
        self.blocks.iter().map(force).collect()
    }

    /// One leapfrog kick of the contact row.
    ///
    /// `velocity`: horizontal velocities by column, times the step; `force_x`, `force_y`: spring forces
    /// by column; `kept`: share of the velocity that damping leaves; `kick`: displacement per step that
    /// a unit force adds, by column.
    pub fn kick(
        &mut self,
        velocity: &mut [f64],
        force_x: &[f64],
        force_y: &[f64],
        kept: f64,
        kick: &[f64],
    ) -> ContactSums {
        let mut sums = ContactSums::default();
        let law = self.law;
        for (block, near) in self.blocks.iter_mut().zip(&mut self.near) {
            let i = block.column;
            let push = Push { kept, kick: kick[i], force: [force_x[i]], lift: force_y[i], drive: [1.0] };
            [velocity[i]] = block.kick([velocity[i]], push, |normal| law.grip(normal, near));
            sums.add_block(block);
        }
        sums
    }

    /// Friction at the start of a Runge-Kutta step: blocks at rest that are pulled too hard start;
    /// returns the sums at this instant. Forces by column, `velocity` the horizontal one.
    pub fn begin_step(&mut self, velocity: &[f64], force_x: &[f64], force_y: &[f64]) -> ContactSums {
        let mut sums = ContactSums::default();
        let law = self.law;
        for (block, near) in self.blocks.iter_mut().zip(&mut self.near) {
            let i = block.column;
            let met = block.meet([force_x[i]], force_y[i], |normal| law.grip(normal, near));
            if let Meeting::Starting { resistance } | Meeting::Sliding { resistance } = met {
                let direction = slip_direction(velocity[i], force_x[i]);
                block.slips(direction);
                block.friction = [direction * resistance];
            }
            sums.add_block(block);
        }
        sums
    }

    /// Friction on block number `number` sliding in `direction` at the spring force `force_y`, signed
    /// as a resistance to positive motion.
    pub fn sliding_friction(&mut self, number: usize, direction: f64, force_y: f64) -> f64 {
        let law = self.law;
        let block = &mut self.blocks[number];
        let normal = -force_y;
        if normal <= 0.0 || block.motion == Motion::Lifted {
            return 0.0;
        }
        direction * block.coefficients.dynamic_mu * law.grip(normal, &mut self.near[number])
    }
}

/// How far a block goes on from an instant about which its velocity times the step falls from `before` to `after`, below zero, until
/// it stands: v^2 / 2 a with the velocity at the instant, v = (before + after) / 2, and a = before - after.
#[must_use]
pub fn left_to_go(before: f64, after: f64) -> f64 {
    if before > 0.0 && after <= 0.0 { (before + after).powi(2) / (8.0 * (before - after)) } else { 0.0 }
}

/// Direction of slip: that of the velocity or, for a block just starting, of the force; 0 without either.
#[must_use]
pub fn slip_direction(velocity: f64, force: f64) -> f64 {
    let of = if velocity != 0.0 { velocity } else { force };
    if of == 0.0 { 0.0 } else { of.signum() }
}

#[cfg(test)]
mod tests;
