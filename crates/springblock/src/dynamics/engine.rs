//! What every integrator offers to the run that drives it.

use super::contact::{ContactForce, ContactRow, ContactSums};
use super::protocol::Protocol;

/// What an integrator starts from, beside the lattice. Units: k = 1, l = 1, m = 1.
#[derive(Clone, Debug)]
pub struct Setup<'a> {
    /// The contact row, at rest.
    pub contact: ContactRow<'a>,
    /// Load and motion of the bulk.
    pub protocol: Protocol,
    /// Time step.
    pub time_step: f64,
    /// Damping frequency gamma.
    pub damping: f64,
    /// Contact is unilateral.
    pub liftoff: bool,
}

/// An integrator with its state.
pub trait Engine {
    /// The bulk begins to move: blocks that slipped under the rising load count as not yet slipped.
    fn begin_drive(&mut self);

    /// Advances by one step; the sums over the contact row at its beginning.
    fn step(&mut self) -> ContactSums;

    /// Advances by one step, or by two where that is faster; the sums of each. For who asks nothing in between: only sums that are
    /// not finite are seen in time, and no step follows them.
    fn one_or_two_steps(&mut self) -> (ContactSums, Option<ContactSums>) {
        (self.step(), None)
    }

    /// Whether every contact block has slipped since the drive began.
    fn all_have_slipped(&self) -> bool;

    /// Number of contact blocks.
    fn contacts(&self) -> usize;

    /// Forces on the contact blocks at the last force evaluation, left to right.
    fn contact_forces(&mut self) -> Vec<ContactForce>;

    /// Ends what runs beside the caller: no step follows.
    fn finish(&mut self) {}

    /// Time step over sqrt(m/k).
    fn time_step(&self) -> f64;

    /// Force evaluations per step.
    fn evaluations_per_step(&self) -> u64;
}

/// An integrator of the vertical plane.
pub trait PlaneEngine: Engine {
    /// Starts from given displacements over l, by (i, j), every block at rest.
    fn start_sheared(&mut self, displacement: &dyn Fn(usize, usize) -> [f64; 2]);

    /// Vertical displacement of block (i, j) over l.
    fn rise(&self, i: usize, j: usize) -> f64;
}
