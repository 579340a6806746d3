//! Friction on the contact blocks of a strip, in vectors.
//!
//! Nearly all blocks go on as they were: at rest below their threshold, or sliding without a reversal, on
//! the same interval of the area law. One pass does these; the few others, whose law, state or direction
//! changes, take [`ContactBlock::kick`] one by one.

use pulp::{Simd, WithSimd};

use super::contact::{ContactBlock, ContactForce, ContactSums, LocalLaw, Motion};
use super::contact_columns::ContactColumns;
use super::stencil::fixed_sum;
use super::sweep::{Kick, vectorized};

/// The contact blocks of a strip, with their velocities.
#[derive(Clone, Debug)]
pub struct ContactStrip<'a> {
    blocks: Vec<ContactBlock>,
    law: LocalLaw<'a>,
    /// Position in `blocks` by column; only contact columns are looked up.
    number: Vec<usize>,
    columns: ContactColumns,
    /// Horizontal velocity times the step, by column.
    velocity: Vec<f64>,
    normal: Vec<f64>,
    friction: Vec<f64>,
    /// 1 for a block that the pass has left to the scalar law, 0 for others.
    left: Vec<f64>,
    /// Blocks that have not slipped since the drive began.
    holding: usize,
}

impl<'a> ContactStrip<'a> {
    /// `blocks` have columns within the strip, of which `inverse_mass` holds whole cache lines.
    #[must_use]
    pub fn new(blocks: Vec<ContactBlock>, law: LocalLaw<'a>, inverse_mass: &[f64], kick: Kick) -> Self {
        let nx = inverse_mass.len();
        let zero = || vec![0.0; nx];
        let kick = inverse_mass.iter().map(|inverse| kick.kick * inverse).collect();
        let mut columns = ContactColumns::without_blocks(kick);
        let mut number = vec![usize::MAX; nx];
        for (n, block) in blocks.iter().enumerate() {
            number[block.column] = n;
            columns.set_block(block.column, block.coefficients.starting_mu(), block.coefficients.dynamic_mu);
        }
        let holding = blocks.iter().filter(|block| !block.has_slipped).count();
        Self { blocks, law, number, columns, velocity: zero(), normal: zero(), friction: zero(), left: zero(), holding }
    }

    /// Starts the account of which blocks have slipped: the bulk begins to move.
    pub fn begin_drive(&mut self) {
        for block in &mut self.blocks {
            block.has_slipped = false;
            // Whatever slides must pass the scalar law to be counted.
            self.columns.from[block.column] = f64::INFINITY;
        }
        self.holding = self.blocks.len();
    }

    /// Whether every block has slipped since the drive began.
    #[must_use]
    pub const fn all_have_slipped(&self) -> bool {
        self.holding == 0
    }

    /// Normal force, negative under tension, and friction of every block at the last force evaluation.
    pub fn forces(&self) -> impl Iterator<Item = ContactForce> + '_ {
        self.blocks.iter().map(|block| {
            let i = block.column;
            let [normal, friction] =
                if self.is_settled(i) { [self.normal[i], self.friction[i]] } else { [block.normal, block.friction] };
            self.law.force(normal, friction, block.coefficients.dynamic_mu)
        })
    }

    /// Whether the pass takes the block in column `i`.
    fn is_settled(&self, i: usize) -> bool {
        self.columns.from[i] != f64::INFINITY
    }

    /// Horizontal displacements of the last step, by column.
    pub fn velocity(&self) -> &[f64] {
        &self.velocity
    }

    /// One leapfrog kick by the spring forces `force_x`, `force_y`, by column; the sums over the strip.
    pub fn kick(&mut self, force_x: &[f64], force_y: &[f64], kept: f64) -> ContactSums {
        let left = vectorized(Pass {
            columns: &self.columns,
            velocity: &mut self.velocity,
            normal: &mut self.normal,
            friction: &mut self.friction,
            left: &mut self.left,
            force: [force_x, force_y],
            kept,
        });
        if left {
            for i in 0..self.left.len() {
                if self.left[i] != 0.0 {
                    self.kick_block(i, [force_x[i], force_y[i]], kept);
                }
            }
        }
        ContactSums { friction: fixed_sum(&self.friction), normal: fixed_sum(&self.normal), ..ContactSums::default() }
    }

    fn kick_block(&mut self, i: usize, force: [f64; 2], kept: f64) {
        let Self { blocks, law, columns, .. } = self;
        // What is no block has no friction, even where displacements are no longer finite.
        let Some(block) = blocks.get_mut(self.number[i]) else { return };
        let had_slipped = block.has_slipped;
        let mut piece = columns.piece(i);
        self.velocity[i] = block.kick(self.velocity[i], force, kept, columns.kick[i], |normal, _| {
            if !(piece.from <= normal && normal < piece.to) {
                piece = law.piece(normal);
            }
            piece.grip(normal)
        });
        self.holding -= usize::from(block.has_slipped && !had_slipped);
        // The sum of normal forces counts compressive blocks only.
        (self.normal[i], self.friction[i]) = (block.normal.max(0.0), block.friction);
        let goes_on = match block.motion {
            Motion::Rest => true,
            // Without velocity the pass would take it for a block at rest.
            Motion::Slip => self.velocity[i] != 0.0 && block.normal > 0.0,
            Motion::Lifted => false,
        };
        if goes_on {
            columns.set_piece(i, piece);
        } else {
            columns.from[i] = f64::INFINITY;
        }
    }

    /// Blocks that may be in the air or under tension: those that the pass leaves alone.
    pub fn unsettled(&mut self) -> impl Iterator<Item = &mut ContactBlock> {
        let from = &self.columns.from;
        self.blocks.iter_mut().filter(|block| from[block.column] == f64::INFINITY)
    }
}

/// The pass over blocks that go on as they were; whether it left any.
struct Pass<'a> {
    columns: &'a ContactColumns,
    velocity: &'a mut [f64],
    normal: &'a mut [f64],
    friction: &'a mut [f64],
    left: &'a mut [f64],
    force: [&'a [f64]; 2],
    kept: f64,
}

impl WithSimd for Pass<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        let Self { columns: c, velocity, normal, friction, left, force: [force_x, force_y], kept } = self;
        let vectors = velocity.len() / S::F64_LANES;
        let column = |values| &S::as_simd_f64s(values).0[..vectors];
        let column_mut = |values| &mut S::as_mut_simd_f64s(values).0[..vectors];
        let (velocity, normal) = (column_mut(velocity), column_mut(normal));
        let (friction, left) = (column_mut(friction), column_mut(left));
        let (force_x, force_y, kick) = (column(force_x), column(force_y), column(&c.kick));
        let (constant, linear, quadratic) = (column(&c.constant), column(&c.linear), column(&c.quadratic));
        let (from, to) = (column(&c.from), column(&c.to));
        let (starting_mu, dynamic_mu) = (column(&c.starting_mu), column(&c.dynamic_mu));
        let (add, mul) = (|a, b| simd.add_f64s(a, b), |a, b| simd.mul_f64s(a, b));
        let (zero, one) = (simd.splat_f64s(0.0), simd.splat_f64s(1.0));
        let (sign, kept) = (simd.splat_f64s(-0.0), simd.splat_f64s(kept));
        let mut any = zero;
        for i in 0..vectors {
            let (v, force, pressing) = (velocity[i], force_x[i], simd.neg_f64s(force_y[i]));
            let grip = add(constant[i], mul(pressing, add(linear[i], mul(pressing, quadratic[i]))));
            let known =
                simd.and_m64s(simd.less_than_or_equal_f64s(from[i], pressing), simd.less_than_f64s(pressing, to[i]));
            let at_rest = simd.equal_f64s(v, zero);
            // mu_d f(p) F_n with the sign of the velocity
            let resistance = simd.or_f64s(mul(dynamic_mu[i], grip), simd.and_f64s(v, sign));
            let free = add(mul(kept, v), mul(kick[i], force));
            let slowed = simd.sub_f64s(free, mul(kick[i], resistance));
            let held = simd.less_than_or_equal_f64s(simd.abs_f64s(force), mul(starting_mu[i], grip));
            let slides_on = simd.less_than_f64s(zero, mul(slowed, v));
            // At rest v is 0 and it cannot slide on.
            let goes_on = simd.and_m64s(known, simd.or_m64s(simd.and_m64s(at_rest, held), slides_on));
            velocity[i] = simd.select_f64s(simd.and_m64s(goes_on, slides_on), slowed, v);
            friction[i] = simd.select_f64s(at_rest, force, resistance);
            normal[i] = pressing;
            left[i] = simd.select_f64s(goes_on, zero, one);
            any = add(any, left[i]);
        }
        simd.reduce_sum_f64s(any) > 0.0
    }
}
