//! The balance of work of the leapfrog in space closes for any sliding direction.

use crate::pattern::Planform;

use super::super::super::engine::{Engine, Setup};
use super::super::super::protocol::Protocol;
use super::super::bonds::SpaceBonds;
use super::super::leapfrog::SpaceLeapfrog;
use super::{protocol, setup};
use crate::springblock::SpaceLattice;
use crate::springblock::dynamics::tests::work_account::{Account, Instant};
use crate::springblock::tests::samples;

/// Error of the balance over the work of the drive.
fn relative_error(time_step: f64, direction: [f64; 2]) -> f64 {
    let lattice = SpaceLattice::cell(&samples::pattern(Planform::Square, 30.0, 50.0, 20.0), 10e-6, 5);
    let ([nx, ny], rows) = (lattice.columns(), lattice.rows());
    let blocks = nx * ny * rows;
    let coefficients = samples::coefficients(5, nx * ny);
    let protocol = Protocol { ramp: 0.0, start: 30.0, ..protocol(&lattice, 1e-4) };
    let setup = Setup { time_step, ..setup(&lattice, &coefficients, protocol, direction) };
    let damping = setup.damping;
    let mut engine = SpaceLeapfrog::new(&lattice, setup);
    let bonds = SpaceBonds::new(&lattice);
    let state = |engine: &SpaceLeapfrog<f64>| -> Vec<[f64; 3]> {
        (0..blocks).map(|n| engine.displacement([n % nx, n / nx % ny, n / (nx * ny)])).collect()
    };

    let mut account = Account::new(bonds.mass(), damping, time_step);
    let mut force = vec![[0.0; 3]; blocks + 1];
    for step in 0..(1000.0 / time_step) as usize {
        let mut u = state(&engine);
        let travel = protocol.bulk_x(step as f64 * time_step);
        u.push([direction[0] * travel, direction[1] * travel, 0.0]);
        bonds.balance(&mut u, protocol.load);
        bonds.forces(&u, &mut force);
        let potential = bonds.energy(&u) + protocol.load * u[blocks][2];
        // The bulk moves vertically by the load, so the drive has no vertical force.
        let (bulk, drive) = (u[blocks], [-force[blocks][0], -force[blocks][1], 0.0]);
        engine.step();
        let friction = lattice.contacts().zip(engine.contact().vectors());
        let friction = friction.map(|(column, (_, [x, y]))| (column, [x, y, 0.0])).collect();
        u.truncate(blocks);
        account.add(Instant { u, bulk, potential, drive, friction }, &state(&engine));
    }
    account.relative_error()
}

#[test]
fn the_account_closes_to_rounding() {
    for (time_step, direction) in [(0.15, [1.0, 0.0]), (0.3, [0.6, 0.8])] {
        let relative_error = relative_error(time_step, direction);
        assert!(relative_error.abs() < 1e-10, "{time_step}: {relative_error:e}");
    }
}
