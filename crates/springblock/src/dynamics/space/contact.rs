//! Friction on the contact layer, in vectors.
//!
//! As in the vertical plane nearly all blocks go on as they were: at rest below their threshold, or sliding on, on the
//! same interval of the area law. One pass does these; the few others take [`SlipBlock::kick`] one by one.

use pulp::{Simd, WithSimd};

use super::super::contact::{ContactForce, ContactSums, LocalLaw, Motion};
use super::super::contact_columns::ContactColumns;
use super::super::stencil::fixed_sum;
use super::super::sweep::{Kick, vectorized};
use super::slip::{Push, SlipBlock};

/// The contact blocks, with their velocities. Arrays hold row by row, each padded to whole cache lines.
#[derive(Clone, Debug)]
pub struct ContactLayer<'a> {
    blocks: Vec<SlipBlock>,
    law: LocalLaw<'a>,
    /// Sliding direction.
    direction: [f64; 2],
    /// Position in `blocks` by place; only contacts are looked up.
    number: Vec<usize>,
    columns: ContactColumns,
    /// Horizontal velocities times the step.
    velocity: [Vec<f64>; 2],
    normal: Vec<f64>,
    friction: [Vec<f64>; 2],
    /// 1 for a block that the pass has left to the scalar law, 0 for others.
    left: Vec<f64>,
    /// Blocks that have not slipped since the drive began.
    holding: usize,
}

impl<'a> ContactLayer<'a> {
    /// `blocks` at rest; `inverse_mass` over the whole layer.
    #[must_use]
    pub fn new(
        blocks: Vec<SlipBlock>,
        law: LocalLaw<'a>,
        direction: [f64; 2],
        inverse_mass: impl Iterator<Item = f64>,
        kick: Kick,
    ) -> Self {
        let kick: Vec<f64> = inverse_mass.map(|inverse| kick.kick * inverse).collect();
        let places = kick.len();
        let zero = || vec![0.0; places];
        let mut columns = ContactColumns::without_blocks(kick);
        let mut number = vec![usize::MAX; places];
        for (n, block) in blocks.iter().enumerate() {
            number[block.place] = n;
            columns.set_block(block.place, block.coefficients.starting_mu(), block.coefficients.dynamic_mu);
        }
        let holding = blocks.iter().filter(|block| !block.has_slipped).count();
        Self {
            blocks,
            law,
            direction,
            number,
            columns,
            velocity: [zero(), zero()],
            normal: zero(),
            friction: [zero(), zero()],
            left: zero(),
            holding,
        }
    }

    /// Number of contact blocks.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.blocks.len()
    }

    /// Starts the account of which blocks have slipped: the bulk begins to move.
    pub fn begin_drive(&mut self) {
        for block in &mut self.blocks {
            block.has_slipped = false;
            // Whatever slides must pass the scalar law to be counted.
            self.columns.from[block.place] = f64::INFINITY;
        }
        self.holding = self.blocks.len();
    }

    /// Whether every block has slipped since the drive began.
    #[must_use]
    pub const fn all_have_slipped(&self) -> bool {
        self.holding == 0
    }

    /// Normal force, negative under tension, and friction along x and y of every block at the last force evaluation.
    pub fn vectors(&self) -> impl Iterator<Item = (f64, [f64; 2])> + '_ {
        self.blocks.iter().map(|block| {
            let i = block.place;
            if self.columns.from[i] == f64::INFINITY {
                (block.normal, block.friction)
            } else {
                (self.normal[i], [self.friction[0][i], self.friction[1][i]])
            }
        })
    }

    /// Normal force and friction against the drive of every block.
    pub fn forces(&self) -> impl Iterator<Item = ContactForce> + '_ {
        let [x, y] = self.direction;
        self.vectors().zip(&self.blocks).map(move |((normal, [fx, fy]), block)| {
            self.law.force(normal, x * fx + y * fy, block.coefficients.dynamic_mu)
        })
    }

    /// Horizontal displacements of the last step, x and y.
    pub fn velocity(&self) -> [&[f64]; 2] {
        [&self.velocity[0], &self.velocity[1]]
    }

    /// One leapfrog kick by the spring forces; the sums over the layer.
    pub fn kick(&mut self, force: [&[f64]; 3], kept: f64) -> ContactSums {
        let left = vectorized(Pass {
            columns: &self.columns,
            velocity: &mut self.velocity,
            normal: &mut self.normal,
            friction: &mut self.friction,
            left: &mut self.left,
            force,
            kept,
        });
        if left {
            for place in 0..self.left.len() {
                if self.left[place] != 0.0 {
                    self.kick_block(place, force.map(|force| force[place]), kept);
                }
            }
        }
        let ([x, y], [sum_x, sum_y]) = (self.direction, [0, 1].map(|c: usize| fixed_sum(&self.friction[c])));
        ContactSums { friction: x * sum_x + y * sum_y, across: x * sum_y - y * sum_x, normal: fixed_sum(&self.normal) }
    }

    fn kick_block(&mut self, place: usize, force: [f64; 3], kept: f64) {
        let Self { blocks, law, columns, .. } = self;
        // What is no block has no friction, even where displacements are no longer finite.
        let Some(block) = blocks.get_mut(self.number[place]) else { return };
        let had_slipped = block.has_slipped;
        let mut piece = columns.piece(place);
        let push = Push { kept, kick: columns.kick[place], force, drive: self.direction };
        let v = block.kick([self.velocity[0][place], self.velocity[1][place]], push, |normal| {
            if !(piece.from <= normal && normal < piece.to) {
                piece = law.piece(normal);
            }
            piece
        });
        self.holding -= usize::from(block.has_slipped && !had_slipped);
        for (component, (v, friction)) in v.into_iter().zip(block.friction).enumerate() {
            self.velocity[component][place] = v;
            self.friction[component][place] = friction;
        }
        // The sum of normal forces counts compressive blocks only.
        self.normal[place] = block.normal.max(0.0);
        let goes_on = match block.motion {
            Motion::Rest => true,
            // Without velocity the pass would take it for a block at rest.
            Motion::Slip => v != [0.0; 2] && block.normal > 0.0,
            Motion::Lifted => false,
        };
        if goes_on {
            columns.set_piece(place, piece);
        } else {
            columns.from[place] = f64::INFINITY;
        }
    }

    /// Blocks that may be in the air or under tension: those that the pass leaves alone.
    pub fn unsettled(&mut self) -> impl Iterator<Item = &mut SlipBlock> {
        let from = &self.columns.from;
        self.blocks.iter_mut().filter(|block| from[block.place] == f64::INFINITY)
    }
}

#[inline(always)]
fn dot<S: Simd>(simd: S, a: [S::f64s; 2], b: [S::f64s; 2]) -> S::f64s {
    simd.add_f64s(simd.mul_f64s(a[0], b[0]), simd.mul_f64s(a[1], b[1]))
}

/// The pass over blocks that go on as they were; whether it left any.
struct Pass<'a> {
    columns: &'a ContactColumns,
    velocity: &'a mut [Vec<f64>; 2],
    normal: &'a mut [f64],
    friction: &'a mut [Vec<f64>; 2],
    left: &'a mut [f64],
    force: [&'a [f64]; 3],
    kept: f64,
}

impl WithSimd for Pass<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        let Self { columns: c, velocity: [vx, vy], normal, friction: [rx, ry], left, force: [fx, fy, fz], kept } = self;
        let vectors = normal.len() / S::F64_LANES;
        let column = |values| &S::as_simd_f64s(values).0[..vectors];
        let column_mut = |values| &mut S::as_mut_simd_f64s(values).0[..vectors];
        let (vx, vy, normal) = (column_mut(vx), column_mut(vy), column_mut(normal));
        let (rx, ry, left) = (column_mut(rx), column_mut(ry), column_mut(left));
        let (fx, fy, fz, kick) = (column(fx), column(fy), column(fz), column(&c.kick));
        let (constant, linear, quadratic) = (column(&c.constant), column(&c.linear), column(&c.quadratic));
        let (from, to) = (column(&c.from), column(&c.to));
        let (starting_mu, dynamic_mu) = (column(&c.starting_mu), column(&c.dynamic_mu));
        let (zero, one) = (simd.splat_f64s(0.0), simd.splat_f64s(1.0));
        let kept = simd.splat_f64s(kept);
        let mut any = zero;
        for i in 0..vectors {
            let (v, force, pressing) = ([vx[i], vy[i]], [fx[i], fy[i]], simd.neg_f64s(fz[i]));
            let bent = simd.mul_f64s(pressing, quadratic[i]);
            let grip = simd.add_f64s(constant[i], simd.mul_f64s(pressing, simd.add_f64s(linear[i], bent)));
            let known =
                simd.and_m64s(simd.less_than_or_equal_f64s(from[i], pressing), simd.less_than_f64s(pressing, to[i]));
            let at_rest = simd.and_m64s(simd.equal_f64s(v[0], zero), simd.equal_f64s(v[1], zero));
            let threshold = simd.mul_f64s(starting_mu[i], grip);
            let held = simd.less_than_or_equal_f64s(dot(simd, force, force), simd.mul_f64s(threshold, threshold));
            let free_x = simd.add_f64s(simd.mul_f64s(kept, v[0]), simd.mul_f64s(kick[i], force[0]));
            let free_y = simd.add_f64s(simd.mul_f64s(kept, v[1]), simd.mul_f64s(kick[i], force[1]));
            // mu_d f(p) F_n against the mean of the velocities before and after the step
            let along = [simd.add_f64s(free_x, v[0]), simd.add_f64s(free_y, v[1])];
            let length = simd.sqrt_f64s(dot(simd, along, along));
            let per_length = simd.div_f64s(simd.mul_f64s(dynamic_mu[i], grip), length);
            let resistance_x = simd.mul_f64s(per_length, along[0]);
            let resistance_y = simd.mul_f64s(per_length, along[1]);
            let slowed_x = simd.sub_f64s(free_x, simd.mul_f64s(kick[i], resistance_x));
            let slowed_y = simd.sub_f64s(free_y, simd.mul_f64s(kick[i], resistance_y));
            let slides_on = simd.and_m64s(
                simd.less_than_f64s(zero, dot(simd, [free_x, free_y], v)),
                simd.less_than_f64s(zero, dot(simd, [slowed_x, slowed_y], v)),
            );
            // At rest v is 0 and it cannot slide on.
            let goes_on = simd.and_m64s(known, simd.or_m64s(simd.and_m64s(at_rest, held), slides_on));
            let moves = simd.and_m64s(goes_on, slides_on);
            vx[i] = simd.select_f64s(moves, slowed_x, v[0]);
            vy[i] = simd.select_f64s(moves, slowed_y, v[1]);
            rx[i] = simd.select_f64s(at_rest, force[0], resistance_x);
            ry[i] = simd.select_f64s(at_rest, force[1], resistance_y);
            normal[i] = pressing;
            left[i] = simd.select_f64s(goes_on, zero, one);
            any = simd.add_f64s(any, left[i]);
        }
        simd.reduce_sum_f64s(any) > 0.0
    }
}
