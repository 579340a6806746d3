//! Friction on the row of contact blocks.
//!
//! At rest friction balances the horizontal force up to max(mu_s, mu_d) f(p) F_n; in sliding it is mu_d f(p) F_n
//! against the velocity; a step that would reverse the velocity ends at rest. The law depends only on the local
//! pressure and the direction of slip.
//!
//! The leapfrog has forces at whole steps and velocities at half steps. A block released at one instant therefore gets
//! half a kick for the half step after it. A block whose velocity v reverses at an instant, with the deceleration a, is
//! placed where it turns, v^2 / (2 a) further on. The length of a slip then has an error of second order in the step. A
//! whole kick at the start and a stop at the instant would make the slip longer by the factor 1 / cos(theta / 2), with
//! the phase theta of a step, and shorter by up to (theta / 4)^2 of its length.

use crate::material::{AreaLaw, Piece};

use super::sweep::Kick;
use crate::springblock::Coefficients;

/// Local friction law: the resistance of a block with given coefficients at a given normal force.
#[derive(Clone, Copy, Debug)]
pub struct LocalLaw<'a> {
    area_law: Option<&'a AreaLaw>,
    /// Pressure on the face of one block under the unit of normal force, in pascals.
    unit_pressure_pa: f64,
}

impl<'a> LocalLaw<'a> {
    /// Creates the law for normal forces in units of `unit_pressure_pa` l^2, with the lattice spacing l.
    pub const fn new(area_law: Option<&'a AreaLaw>, unit_pressure_pa: f64) -> Self {
        Self { area_law, unit_pressure_pa }
    }

    /// Returns the polynomial that gives friction per unit friction coefficient around the normal force `normal`, with
    /// the interval of normal forces in which it holds. Forces are in units of `unit_pressure_pa` times the face area
    /// of a block.
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

    /// Computes f(p) F_n, the friction per unit friction coefficient, at the normal force F_n = `normal`, with the area
    /// factor f at the pressure p. `near` caches the index of the interval in the table of the area law.
    fn grip(&self, normal: f64, near: &mut usize) -> f64 {
        match self.area_law {
            Some(law) => normal * law.factor_near(normal * self.unit_pressure_pa, near),
            None => normal,
        }
    }
}

/// Friction per unit friction coefficient, f(p) F_n = constant + linear F_n + quadratic F_n^2, for normal forces F_n
/// from `from` up to `to`. f is the area factor at the pressure p; forces are in the units of [`LocalLaw`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GripPiece {
    pub from: f64,
    pub to: f64,
    pub constant: f64,
    pub linear: f64,
    pub quadratic: f64,
}

impl GripPiece {
    /// Computes the friction per unit friction coefficient at the normal force `normal`.
    pub fn grip(&self, normal: f64) -> f64 {
        self.constant + normal * (self.linear + normal * self.quadratic)
    }
}

/// State of motion of a contact block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// Held at rest by friction.
    Rest,
    /// Sliding, or free to move because it has no normal pressure.
    Slip,
    /// Off the counterface (unilateral contact only).
    Lifted,
}

/// One contact block with `H` horizontal degrees of freedom: 1 in the plane, 2 in space. Forces are in units of k l
/// (spring stiffness times lattice spacing).
#[derive(Clone, Copy, Debug)]
pub struct ContactBlock<const H: usize> {
    /// Local friction coefficients of the block.
    pub coefficients: Coefficients,
    /// State of motion.
    pub motion: Motion,
    /// Whether the block has slipped along the drive, or has had no friction at some step, since the drive began.
    pub has_slipped: bool,
    /// Column of the block, the index into arrays over the contact row.
    pub column: usize,
    /// Vertical displacement at which the block touches the counterface: the height of its face, in lattice spacings.
    pub face: f64,
    /// Normal force at the last force evaluation, positive in compression.
    pub normal: f64,
    /// Friction force along each axis at the last force evaluation, positive if it resists motion in positive
    /// direction.
    pub friction: [f64; H],
    /// Friction force mu_d f(p) F_n at the last force evaluation if the block slides: dynamic friction coefficient
    /// mu_d, area factor f at the pressure p, normal force F_n.
    pub sliding: f64,
}

/// Coefficients and forces of a leapfrog step of one contact block. Displacements are in lattice spacings l, forces in
/// units of k l with the spring stiffness k.
#[derive(Clone, Copy, Debug)]
pub struct StepFactors<const H: usize> {
    /// Fraction of the velocity that remains after damping.
    pub kept: f64,
    /// Displacement in one step from rest under a unit force, with the mass of the block.
    pub kick: f64,
    /// Horizontal spring force on the block along each axis.
    pub force: [f64; H],
    /// Vertical spring force on the block, positive upward; the normal force on the counterface is its negative.
    pub lift: f64,
    /// Unit vector of the drive.
    pub drive: [f64; H],
}

/// Friction on a contact block that moves along `H` horizontal axes.
pub trait Slide<const H: usize> {
    /// Whether friction up to `threshold` holds a block at rest against `force`.
    fn is_held(force: [f64; H], threshold: f64) -> bool;

    /// Returns the velocity times the time step after a full step that starts at rest and slides against the friction
    /// force `resistance`, which is smaller than the spring force.
    fn start(&mut self, factors: &StepFactors<H>, resistance: f64) -> [f64; H];

    /// Returns the velocity times the time step after a step of sliding against the friction force `resistance`. `v` is
    /// the same product before the step, `free` that after a step without friction.
    fn slide(&mut self, v: [f64; H], free: [f64; H], factors: &StepFactors<H>, resistance: f64) -> [f64; H];
}

/// State of a contact block that results from the current spring forces.
enum ContactState {
    /// No normal pressure, hence no friction.
    Free,
    /// At rest; friction balances the horizontal force.
    Held,
    /// Starts to slide against the friction force `resistance`, mu_d f(p) F_n.
    Starting { resistance: f64 },
    /// Slides against the friction force `resistance`, mu_d f(p) F_n.
    Sliding { resistance: f64 },
}

impl<const H: usize> ContactBlock<H> {
    /// Creates a block at rest.
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

    /// Sets the height of the face, and lifts the block if its vertical displacement `height` is larger; both are in
    /// lattice spacings.
    pub fn place(&mut self, face: f64, height: f64) {
        self.face = face;
        if height > face {
            self.motion = Motion::Lifted;
        }
    }

    fn release(&mut self) -> ContactState {
        (self.friction, self.sliding) = ([0.0; H], 0.0);
        self.has_slipped = true;
        if self.motion == Motion::Rest {
            self.motion = Motion::Slip;
        }
        ContactState::Free
    }

    /// Moves a block vertically under unilateral contact: lifts blocks under tension, moves lifted blocks, and stops
    /// blocks that reach the counterface.
    ///
    /// `height` is the vertical displacement before the step, `fall` the change of the vertical displacement in the
    /// last step, which is updated, and `force` the vertical spring force. Returns the vertical displacement after the
    /// step if the block was lifted during the step, otherwise `None`.
    pub fn move_detached(
        &mut self,
        height: f64,
        fall: &mut f64,
        kick: Kick,
        inverse_mass: f64,
        force: f64,
    ) -> Option<f64> {
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
        // Landing stops the vertical motion at the counterface.
        *fall = 0.0;
        self.motion = Motion::Slip;
        Some(self.face)
    }
}

impl<const H: usize> ContactBlock<H>
where
    Self: Slide<H>,
{
    /// Updates normal force, friction at rest, and state of motion for the current spring forces. `grip_at` computes
    /// the friction per unit friction coefficient at a positive normal force.
    #[inline]
    fn update_state(&mut self, force: [f64; H], lift: f64, grip_at: impl FnOnce(f64) -> f64) -> ContactState {
        // F_n = -(vertical force of the springs)
        self.normal = if self.motion == Motion::Lifted { 0.0 } else { -lift };
        if self.normal <= 0.0 {
            return self.release();
        }
        let grip = grip_at(self.normal);
        let threshold = self.coefficients.starting_mu() * grip;
        if threshold == 0.0 {
            // Where the law reaches zero no friction acts, and a reversal of the velocity does not stop the block.
            return self.release();
        }
        self.sliding = self.coefficients.dynamic_mu * grip;
        if self.motion == Motion::Rest {
            if Self::is_held(force, threshold) {
                self.friction = force;
                return ContactState::Held;
            }
            self.motion = Motion::Slip;
            return ContactState::Starting { resistance: self.sliding };
        }
        ContactState::Sliding { resistance: self.sliding }
    }

    /// Applies one leapfrog kick: returns the velocity times the time step after the step, given its value `v` before.
    /// `grip_at` computes the friction per unit friction coefficient at a positive normal force.
    #[inline]
    pub fn kick(&mut self, v: [f64; H], factors: StepFactors<H>, grip_at: impl FnOnce(f64) -> f64) -> [f64; H] {
        let free = std::array::from_fn(|axis| factors.kept * v[axis] + factors.kick * factors.force[axis]);
        let after = match self.update_state(factors.force, factors.lift, grip_at) {
            ContactState::Free => return free,
            ContactState::Sliding { resistance } => return self.slide(v, free, &factors, resistance),
            ContactState::Held if v == [0.0; H] => return v,
            ContactState::Held => [0.0; H],
            // The block was at rest until now, so half a step later it has half a kick.
            ContactState::Starting { resistance } => self.start(&factors, resistance).map(|v| 0.5 * v),
        };
        self.friction = std::array::from_fn(|axis| (free[axis] - after[axis]) / factors.kick);
        after
    }
}

impl ContactBlock<1> {
    /// Marks the block as slipped if the sign `direction` of the slip is that of the drive. Slips against the drive,
    /// caused by the load or by waves, do not count.
    fn record_slip(&mut self, direction: f64) {
        self.has_slipped |= direction > 0.0;
    }
}

impl Slide<1> for ContactBlock<1> {
    #[inline]
    fn is_held([force]: [f64; 1], threshold: f64) -> bool {
        force.abs() <= threshold
    }

    #[inline]
    fn start(&mut self, factors: &StepFactors<1>, resistance: f64) -> [f64; 1] {
        let direction = slip_direction(0.0, factors.force[0]);
        self.record_slip(direction);
        [factors.kick * (factors.force[0] - direction * resistance)]
    }

    #[inline]
    fn slide(&mut self, [v]: [f64; 1], [free]: [f64; 1], factors: &StepFactors<1>, resistance: f64) -> [f64; 1] {
        let direction = slip_direction(v, factors.force[0]);
        self.record_slip(direction);
        let slowed = free - direction * factors.kick * resistance;
        if slowed * direction > 0.0 {
            self.friction = [direction * resistance];
            [slowed]
        } else {
            // The step ends at rest; friction is the force that stopped the block.
            self.motion = Motion::Rest;
            let rest = direction * stopping_distance(v * direction, slowed * direction);
            self.friction = [(free - rest) / factors.kick];
            [rest]
        }
    }
}

/// Sums of forces over contact blocks, in units of k l (spring stiffness times lattice spacing).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactSums {
    /// Friction force, positive against the drive.
    pub friction: f64,
    /// Friction force perpendicular to the drive; zero in the vertical plane.
    pub across: f64,
    /// Sum of positive normal forces.
    pub normal: f64,
    /// Friction force if every block slides: sum of mu_d f(p) F_n (dynamic coefficient, area factor, normal force).
    pub sliding: f64,
}

impl ContactSums {
    /// Whether friction and normal force are finite; they are not once a run has diverged.
    pub const fn is_finite(&self) -> bool {
        self.friction.is_finite() && self.normal.is_finite()
    }

    /// Friction coefficient, the friction force over the normal force; `None` without a normal force.
    pub fn mu(&self) -> Option<f64> {
        (self.normal > 0.0).then(|| self.friction / self.normal)
    }

    /// Adds the sums over other contact blocks, or at another instant.
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

/// Force on one contact block, instantaneous or averaged, in units of k l (spring stiffness times lattice spacing).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactForce {
    /// Normal force, positive in compression.
    pub normal: f64,
    /// Friction force, positive against the drive.
    pub friction: f64,
}

/// The contact blocks of a lattice, with `H` horizontal degrees of freedom.
#[derive(Clone, Debug)]
pub struct ContactRow<'a, const H: usize> {
    /// Contact blocks, left to right; in space row by row along x.
    pub blocks: Vec<ContactBlock<H>>,
    /// Cached index of an interval in the table of the area law, for each block.
    near: Vec<usize>,
    law: LocalLaw<'a>,
}

impl<'a, const H: usize> ContactRow<'a, H> {
    /// Creates blocks at rest in the columns `columns`; `coefficients` has the local friction coefficients of every
    /// column.
    pub fn new(columns: impl Iterator<Item = usize>, coefficients: &[Coefficients], law: LocalLaw<'a>) -> Self {
        let blocks: Vec<_> = columns.map(|column| ContactBlock::new(column, coefficients[column])).collect();
        Self { near: vec![0; blocks.len()], blocks, law }
    }

    /// Sets the face height of every block and lifts the blocks above it. `face_and_height` returns the face height and
    /// the vertical displacement in a column, in lattice spacings.
    pub fn place(&mut self, face_and_height: impl Fn(usize) -> [f64; 2]) {
        for block in &mut self.blocks {
            let [face, height] = face_and_height(block.column);
            block.place(face, height);
        }
    }

    /// Returns the blocks and their law.
    pub fn into_parts(self) -> (Vec<ContactBlock<H>>, LocalLaw<'a>) {
        (self.blocks, self.law)
    }
}

impl ContactRow<'_, 1> {
    /// Marks every block as not slipped, at the start of the bulk's motion.
    pub fn begin_drive(&mut self) {
        for block in &mut self.blocks {
            block.has_slipped = false;
        }
    }

    /// Whether every block has slipped since the drive began.
    pub fn all_have_slipped(&self) -> bool {
        self.blocks.iter().all(|block| block.has_slipped)
    }

    /// Forces on the blocks at the last force evaluation, left to right.
    pub fn forces(&self) -> Vec<ContactForce> {
        let force = |block: &ContactBlock<1>| ContactForce { normal: block.normal, friction: block.friction[0] };
        self.blocks.iter().map(force).collect()
    }

    /// Applies one leapfrog kick to the contact row.
    ///
    /// Slices are indexed by column: `velocity` is the horizontal velocity times the time step, `force_x` and `force_y`
    /// are spring forces, and `kick` is the displacement per step caused by a unit force. `kept` is the fraction of the
    /// velocity that remains after damping. Returns the sums of forces over the row.
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
            let factors = StepFactors { kept, kick: kick[i], force: [force_x[i]], lift: force_y[i], drive: [1.0] };
            [velocity[i]] = block.kick([velocity[i]], factors, |normal| law.grip(normal, near));
            sums.add_block(block);
        }
        sums
    }

    /// Updates friction at the start of a Runge-Kutta step, which releases overloaded blocks at rest, and returns the
    /// sums of forces at this instant. Arguments are indexed by column; `velocity` is horizontal.
    pub fn begin_step(&mut self, velocity: &[f64], force_x: &[f64], force_y: &[f64]) -> ContactSums {
        let mut sums = ContactSums::default();
        let law = self.law;
        for (block, near) in self.blocks.iter_mut().zip(&mut self.near) {
            let i = block.column;
            let state = block.update_state([force_x[i]], force_y[i], |normal| law.grip(normal, near));
            if let ContactState::Starting { resistance } | ContactState::Sliding { resistance } = state {
                let direction = slip_direction(velocity[i], force_x[i]);
                block.record_slip(direction);
                block.friction = [direction * resistance];
            }
            sums.add_block(block);
        }
        sums
    }

    /// Friction force on block `number` if it slides in `direction` (1 or -1) at the vertical spring force `force_y`;
    /// positive if friction resists motion in the positive direction.
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

/// Distance v^2 / (2 a) that a block with the velocity v and the deceleration a still moves until it stops.
///
/// The velocity times the time step falls from `before` to `after` in this step, so that v = (before + after) / 2 and a
/// = before - after in units of the time step. The distance is 0 unless `before` is positive and `after` is not.
pub fn stopping_distance(before: f64, after: f64) -> f64 {
    if before > 0.0 && after <= 0.0 { (before + after).powi(2) / (8.0 * (before - after)) } else { 0.0 }
}

/// Direction of slip: the sign of the velocity or, for a block that just starts, of the force; 0 if both are zero.
pub fn slip_direction(velocity: f64, force: f64) -> f64 {
    let of = if velocity != 0.0 { velocity } else { force };
    if of == 0.0 { 0.0 } else { of.signum() }
}

#[cfg(test)]
mod tests;
