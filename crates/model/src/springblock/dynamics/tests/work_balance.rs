//! The balance of work of the leapfrog closes with the friction that it reports.

use super::super::bonds::Bonds;
use super::super::engine::Engine;
use super::super::strip_leapfrog::StripLeapfrog;
use super::work_account::{Account, Instant};
use super::{patterned, setup};
use crate::springblock::{Lattice, Springs};

fn state<'scope, 'a: 'scope>(engine: &StripLeapfrog<'scope, '_, 'a, f64>, lattice: &Lattice) -> [Vec<f64>; 2] {
    let (nx, ny) = (lattice.nx(), lattice.ny());
    [0, 1].map(|c: usize| (0..nx * ny).map(|number| engine.displacement(number % nx, number / nx)[c]).collect())
}

/// Groups displacements by block.
fn by_block([x, y]: &[Vec<f64>; 2]) -> Vec<[f64; 2]> {
    x.iter().zip(y).map(|(&x, &y)| [x, y]).collect()
}

/// Error of the balance over the work of the drive.
fn relative_error(time_step: f64, periodic: bool) -> f64 {
    let lattice = patterned(periodic);
    let (nx, blocks) = (lattice.nx(), lattice.nx() * lattice.ny());
    let mass: Vec<f64> = (0..blocks).map(|number| lattice.mass(number % nx, number / nx)).collect();
    let mut setup = setup(&lattice, time_step, 1e-4);
    (setup.protocol.ramp, setup.protocol.start) = (0.0, 30.0);
    let (protocol, damping) = (setup.protocol, setup.damping);
    let mut engine = StripLeapfrog::new(&lattice, setup);
    let mut bonds = Bonds::new(&lattice, Springs::Linear);

    let mut account = Account::new(&mass, damping, time_step);
    for step in 0..(2000.0 / time_step) as usize {
        let u = state(&engine, &lattice);
        let bulk_x = protocol.bulk_x(step as f64 * time_step);
        bonds.evaluate(&u, bulk_x, protocol.load);
        let (potential, drive_x) = (bonds.potential(&u, bulk_x, protocol.load), bonds.drive(&u, bulk_x));
        engine.step();
        let forces = lattice.contacts().zip(engine.contact_forces());
        let friction = forces.map(|(column, force)| (column, [force.friction, 0.0])).collect();
        let now = Instant { u: by_block(&u), bulk: [bulk_x, 0.0], potential, drive: [drive_x, 0.0], friction };
        account.add(now, &by_block(&state(&engine, &lattice)));
    }
    account.relative_error()
}

#[test]
fn the_account_closes_to_rounding() {
    for (periodic, time_step) in [(true, 0.2), (true, 0.4), (false, 0.2)] {
        let relative_error = relative_error(time_step, periodic);
        assert!(relative_error.abs() < 1e-10, "{periodic} {time_step}: {relative_error:e}");
    }
}
