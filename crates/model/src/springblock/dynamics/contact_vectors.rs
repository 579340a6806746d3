//! Vectorized friction on contact blocks.
//!
//! Nearly all blocks continue as before: at rest below their threshold, or sliding without a reversal, on the same
//! interval of the area law. One vectorized pass handles these; the few blocks whose law, state or direction changes go
//! through [`ContactBlock::kick`] one by one.

use pulp::{Simd, WithSimd};

use super::contact::{ContactBlock, ContactForce, ContactSums, LocalLaw, Motion, Slide, StepFactors};
use super::contact_columns::ContactColumns;
use super::stencil::fixed_sum;
use super::sweep::Kick;
use slipgrid_base::fft::vectorized;

/// The contact blocks of a strip in the plane, with `H` = 1 horizontal degree of freedom, or of a cell in space, with
/// `H` = 2, and their velocities. Arrays of a cell are stored row by row, each row padded to whole cache lines.
#[derive(Clone, Debug)]
pub struct ContactVectors<'a, const H: usize> {
    blocks: Vec<ContactBlock<H>>,
    law: LocalLaw<'a>,
    drive: [f64; H],
    /// Index into `blocks` by column; `usize::MAX` for a column without a contact block.
    number: Vec<usize>,
    columns: ContactColumns,
    /// Horizontal velocities times the time step along each axis, by column, in lattice spacings.
    velocity: [Vec<f64>; H],
    normal: Vec<f64>,
    friction: [Vec<f64>; H],
    /// Friction force mu_d f(p) F_n of each block if it slides, by column, in units of k l (spring stiffness times
    /// lattice spacing).
    sliding: Vec<f64>,
    /// By column, 1 for a block that the vectorized pass leaves to the scalar friction law, otherwise 0.
    unhandled: Vec<f64>,
    /// Number of blocks that have not slipped since the drive began.
    not_slipped: usize,
}

impl<'a, const H: usize> ContactVectors<'a, H> {
    /// Creates the contacts from `blocks` at rest, driven along the unit vector `drive`. `inverse_mass` has one value
    /// for each column, padded to whole cache lines.
    pub fn new(
        blocks: Vec<ContactBlock<H>>,
        law: LocalLaw<'a>,
        drive: [f64; H],
        inverse_mass: impl Iterator<Item = f64>,
        kick: Kick,
    ) -> Self {
        let mut columns = ContactColumns::without_blocks(inverse_mass.map(|inverse| kick.kick * inverse).collect());
        let count = columns.kick.len();
        let mut number = vec![usize::MAX; count];
        for (n, block) in blocks.iter().enumerate() {
            number[block.column] = n;
            columns.set_block(block.column, block.coefficients.starting_mu(), block.coefficients.dynamic_mu);
        }
        let not_slipped = blocks.iter().filter(|block| !block.has_slipped).count();
        let zero = || vec![0.0; count];
        let zeros = || std::array::from_fn(|_| zero());
        let (velocity, friction) = (zeros(), zeros());
        Self {
            blocks,
            law,
            drive,
            number,
            columns,
            velocity,
            normal: zero(),
            friction,
            sliding: zero(),
            unhandled: zero(),
            not_slipped,
        }
    }

    /// Marks every block as not slipped, at the start of the bulk's motion.
    pub fn begin_drive(&mut self) {
        for block in &mut self.blocks {
            block.has_slipped = false;
            // Sliding blocks are counted by the scalar law only.
            self.columns.from[block.column] = f64::INFINITY;
        }
        self.not_slipped = self.blocks.len();
    }

    /// Whether every block has slipped since the drive began.
    pub const fn all_have_slipped(&self) -> bool {
        self.not_slipped == 0
    }

    /// Normal force, negative under tension, and friction force along each axis of every block at the last force
    /// evaluation, in units of k l (spring stiffness times lattice spacing).
    pub fn vectors(&self) -> impl Iterator<Item = (f64, [f64; H])> + '_ {
        self.blocks.iter().map(|block| {
            let i = block.column;
            if self.columns.from[i] == f64::INFINITY {
                (block.normal, block.friction)
            } else {
                (self.normal[i], self.friction.each_ref().map(|friction| friction[i]))
            }
        })
    }

    /// Normal force and friction force against the drive of every block at the last force evaluation.
    pub fn forces(&self) -> impl Iterator<Item = ContactForce> + '_ {
        self.vectors().map(|(normal, friction)| ContactForce { normal, friction: along(self.drive, friction) })
    }

    /// Horizontal displacements in the last step along each axis, by column, in lattice spacings.
    pub fn velocity(&self) -> [&[f64]; H] {
        self.velocity.each_ref().map(Vec::as_slice)
    }

    /// Moves blocks vertically under unilateral contact ([`ContactBlock::move_detached`]). By column, `rises` are the
    /// vertical displacements from the base state, which has the height that `base_height` returns, `fall` their changes
    /// in the last step, and `lift` the vertical spring forces; `inverse_mass` returns the inverse mass.
    pub fn move_vertically(
        &mut self,
        kick: Kick,
        lift: &[f64],
        (rises, fall): (&mut [f64], &mut [f64]),
        base_height: impl Fn(usize) -> f64,
        inverse_mass: impl Fn(usize) -> f64,
    ) {
        // Blocks that are lifted or under tension are excluded from the vectorized pass.
        let from = &self.columns.from;
        for block in self.blocks.iter_mut().filter(|block| from[block.column] == f64::INFINITY) {
            let (i, base) = (block.column, base_height(block.column));
            if let Some(height) = block.move_detached(base + rises[i], &mut fall[i], kick, inverse_mass(i), lift[i]) {
                rises[i] = height - base;
            }
        }
    }
}

/// Component of `vector` along `drive`.
#[inline]
fn along<const H: usize>(drive: [f64; H], vector: [f64; H]) -> f64 {
    drive.into_iter().zip(vector).map(|(drive, part)| drive * part).reduce(|sum, part| sum + part).unwrap_or(0.0)
}

impl<const H: usize> ContactVectors<'_, H>
where
    ContactBlock<H>: Slide<H>,
    for<'p> Pass<'p, H>: WithSimd<Output = bool>,
{
    /// Updates friction and velocities for one leapfrog step. `force` and `lift` are the horizontal and the vertical
    /// spring forces, by column; `kept` is the fraction of the velocity that remains after damping. Returns the sums of
    /// forces over all blocks.
    #[inline(never)]
    pub fn kick(&mut self, force: [&[f64]; H], lift: &[f64], kept: f64) -> ContactSums {
        let unhandled = vectorized(Pass {
            columns: &self.columns,
            velocity: &mut self.velocity,
            normal: &mut self.normal,
            friction: &mut self.friction,
            sliding: &mut self.sliding,
            unhandled: &mut self.unhandled,
            force,
            lift,
            kept,
        });
        if unhandled {
            for i in 0..self.unhandled.len() {
                if self.unhandled[i] != 0.0 {
                    self.kick_block(i, force.map(|force| force[i]), lift[i], kept);
                }
            }
        }
        let sums = self.friction.each_ref().map(|friction| fixed_sum(friction));
        let across = match (&self.drive[..], &sums[..]) {
            ([x, y], [sum_x, sum_y]) => x * sum_y - y * sum_x,
            _ => 0.0,
        };
        ContactSums {
            friction: along(self.drive, sums),
            across,
            normal: fixed_sum(&self.normal),
            sliding: fixed_sum(&self.sliding),
        }
    }

    /// Applies the scalar friction law to the block in column `i`, which the vectorized pass did not handle. Not
    /// inlined, because such blocks are rare.
    #[inline(never)]
    fn kick_block(&mut self, i: usize, force: [f64; H], lift: f64, kept: f64) {
        let Self { blocks, law, columns, .. } = self;
        // Columns without a block have no friction, even if displacements are no longer finite.
        let Some(block) = blocks.get_mut(self.number[i]) else { return };
        let had_slipped = block.has_slipped;
        let mut piece = columns.piece(i);
        let factors = StepFactors { kept, kick: columns.kick[i], force, lift, drive: self.drive };
        let v = block.kick(self.velocity.each_ref().map(|velocity| velocity[i]), factors, |normal| {
            if !(piece.from <= normal && normal < piece.to) {
                piece = law.piece(normal);
            }
            piece.grip(normal)
        });
        self.not_slipped -= usize::from(block.has_slipped && !had_slipped);
        for (axis, (v, friction)) in v.into_iter().zip(block.friction).enumerate() {
            self.velocity[axis][i] = v;
            self.friction[axis][i] = friction;
        }
        self.normal[i] = block.normal.max(0.0);
        self.sliding[i] = block.sliding;
        let continues = match block.motion {
            // A block at rest that still has a stopping distance in `v` is not sliding.
            Motion::Rest => v == [0.0; H],
            // The pass would treat a sliding block without velocity as at rest.
            Motion::Slip => v != [0.0; H] && block.normal > 0.0,
            Motion::Lifted => false,
        };
        if continues {
            columns.set_piece(i, piece);
        } else {
            columns.from[i] = f64::INFINITY;
        }
    }
}

/// Vectorized pass over the blocks whose motion continues as before. Returns whether any block remains for the scalar
/// friction law.
pub struct Pass<'a, const H: usize> {
    pub columns: &'a ContactColumns,
    pub velocity: &'a mut [Vec<f64>; H],
    pub normal: &'a mut [f64],
    pub friction: &'a mut [Vec<f64>; H],
    pub sliding: &'a mut [f64],
    pub unhandled: &'a mut [f64],
    pub force: [&'a [f64]; H],
    pub lift: &'a [f64],
    pub kept: f64,
}

impl WithSimd for Pass<'_, 1> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        let Self { columns: c, velocity: [velocity], normal, friction: [friction], .. } = self;
        let Self { sliding, unhandled, force: [force_x], lift, kept, .. } = self;
        let vectors = normal.len() / S::F64_LANES;
        let column = |values| &S::as_simd_f64s(values).0[..vectors];
        let column_mut = |values| &mut S::as_mut_simd_f64s(values).0[..vectors];
        let (velocity, normal) = (column_mut(velocity), column_mut(normal));
        let (friction, sliding, unhandled) = (column_mut(friction), column_mut(sliding), column_mut(unhandled));
        let (force_x, lift, kick) = (column(force_x), column(lift), column(&c.kick));
        let (constant, linear, quadratic) = (column(&c.constant), column(&c.linear), column(&c.quadratic));
        let (from, to) = (column(&c.from), column(&c.to));
        let (starting_mu, dynamic_mu) = (column(&c.starting_mu), column(&c.dynamic_mu));
        let (add, mul) = (|a, b| simd.add_f64s(a, b), |a, b| simd.mul_f64s(a, b));
        let (zero, one) = (simd.splat_f64s(0.0), simd.splat_f64s(1.0));
        let (sign, kept) = (simd.splat_f64s(-0.0), simd.splat_f64s(kept));
        let mut any = zero;
        for i in 0..vectors {
            let (v, force, pressing) = (velocity[i], force_x[i], simd.neg_f64s(lift[i]));
            let grip = add(constant[i], mul(pressing, add(linear[i], mul(pressing, quadratic[i]))));
            let known =
                simd.and_m64s(simd.less_than_or_equal_f64s(from[i], pressing), simd.less_than_f64s(pressing, to[i]));
            let at_rest = simd.equal_f64s(v, zero);
            // mu_d f(p) F_n with the sign of the velocity
            sliding[i] = mul(dynamic_mu[i], grip);
            let resistance = simd.or_f64s(sliding[i], simd.and_f64s(v, sign));
            let free = add(mul(kept, v), mul(kick[i], force));
            let slowed = simd.sub_f64s(free, mul(kick[i], resistance));
            let is_held = simd.less_than_or_equal_f64s(simd.abs_f64s(force), mul(starting_mu[i], grip));
            let keeps_sliding = simd.less_than_f64s(zero, mul(slowed, v));
            // A block at rest has v = 0, so that `keeps_sliding` is false.
            let continues = simd.and_m64s(known, simd.or_m64s(simd.and_m64s(at_rest, is_held), keeps_sliding));
            velocity[i] = simd.select_f64s(simd.and_m64s(continues, keeps_sliding), slowed, v);
            friction[i] = simd.select_f64s(at_rest, force, resistance);
            normal[i] = pressing;
            unhandled[i] = simd.select_f64s(continues, zero, one);
            any = add(any, unhandled[i]);
        }
        simd.reduce_sum_f64s(any) > 0.0
    }
}
