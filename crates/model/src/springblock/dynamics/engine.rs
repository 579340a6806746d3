//! Interface of the integrators, through which a run drives them.

use super::contact::{ContactForce, ContactRow, ContactSums};
use super::protocol::Protocol;

/// Parameters of an integrator besides the lattice, with `H` horizontal degrees of freedom. Units: spring stiffness k,
/// lattice spacing l, block mass m.
#[derive(Clone, Debug)]
pub struct Setup<'a, const H: usize> {
    pub contact: ContactRow<'a, H>,
    /// Unit vector of the sliding direction; in the plane always 1.
    pub direction: [f64; H],
    /// Load and motion of the bulk.
    pub protocol: Protocol,
    /// Time step in units of sqrt(m/k).
    pub time_step: f64,
    /// Damping frequency gamma in units of sqrt(k/m): the damping force on a block is -gamma m v.
    pub damping: f64,
    /// Whether contact is unilateral, so that blocks may lift.
    pub liftoff: bool,
}

/// An integrator with its state.
pub trait Engine {
    /// Starts the drive: blocks that slipped under the rising load no longer count as slipped.
    fn begin_drive(&mut self);

    /// Takes one step; returns the sums of forces over the contact row at the beginning of the step.
    fn step(&mut self) -> ContactSums;

    /// Takes one step, or two if that is faster; returns the sums of forces over the contact row for each step.
    ///
    /// The state between the two steps is not accessible. The second value is `None` if only one step was taken, as
    /// after sums that are not finite.
    fn one_or_two_steps(&mut self) -> (ContactSums, Option<ContactSums>) {
        (self.step(), None)
    }

    /// Whether every contact block has slipped since the drive began.
    fn all_have_slipped(&self) -> bool;

    /// Forces on the contact blocks at the last force evaluation, left to right; in space row by row along x.
    fn contact_forces(&mut self) -> Vec<ContactForce>;

    /// Stops worker threads; no step may follow.
    fn finish(&mut self) {}
}

/// An integrator of a plane lattice.
pub trait PlaneEngine: Engine {
    /// Sets the initial displacements x and y, in lattice spacings, which `displacement` returns for column i and row
    /// j, with every block at rest.
    fn start_sheared(&mut self, displacement: &dyn Fn(usize, usize) -> [f64; 2]);

    /// Vertical displacement of the block in column i of row j, in lattice spacings.
    fn rise(&self, i: usize, j: usize) -> f64;
}
