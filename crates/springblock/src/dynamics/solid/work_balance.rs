//! The account of work in space: what the drive gives is what friction and damping take, what springs and the load
//! store, and kinetic energy, as in the vertical plane.

use slipgrid_material::LocalFriction;
use slipgrid_pattern::{Pattern, Planform};

use super::super::contact::LocalLaw;
use super::super::engine::Engine;
use super::super::protocol::Protocol;
use super::bonds::SolidBonds;
use super::leapfrog::{SolidLeapfrog, SolidSetup};
use crate::draws;
use crate::solid::SolidLattice;

/// What an instant adds to the account.
struct Instant {
    /// Blocks, then the bulk.
    u: Vec<[f64; 3]>,
    potential: f64,
    /// Force of the drive on the bulk.
    drive: [f64; 2],
    friction: Vec<[f64; 2]>,
    /// Mean of the velocities before and after.
    velocity: Vec<[f64; 3]>,
}

/// What the account lacks, as a share of the drive's work.
fn lack(time_step: f64, direction: [f64; 2]) -> f64 {
    let pattern = Pattern::new(Planform::Square, 30e-6, 50e-6, 20e-6).unwrap();
    let lattice = SolidLattice::cell(&pattern, 10e-6, 5);
    let ([nx, ny], rows) = (lattice.columns(), lattice.rows());
    let blocks = nx * ny * rows;
    let coefficients = draws::draw(&LocalFriction::new(0.3, 0.27, 0.05).unwrap(), 5, nx * ny);
    let protocol = Protocol { ramp: 0.0, start: 30.0, load: 0.005 * (nx * ny) as f64, speed: 1e-4 };
    let damping = 0.01;
    let law = LocalLaw::new(None, 1.0);
    let setup =
        SolidSetup { coefficients: &coefficients, law, protocol, direction, time_step, damping, liftoff: false };
    let mut engine = SolidLeapfrog::new(&lattice, setup);
    let bonds = SolidBonds::new(&lattice);
    let contacts: Vec<usize> =
        (0..nx * ny).filter(|column| lattice.contact_share(column % nx, column / nx) > 0.0).collect();
    let state = |engine: &SolidLeapfrog| -> Vec<[f64; 3]> {
        (0..blocks).map(|n| engine.displacement([n % nx, n / nx % ny, n / (nx * ny)])).collect()
    };

    let (mut drive_work, mut lost, mut first, mut energy) = (0.0, 0.0, None, 0.0);
    let mut before: Option<(Instant, Vec<[f64; 3]>)> = None;
    let mut force = vec![[0.0; 3]; blocks + 1];
    for step in 0..(1000.0 / time_step) as usize {
        let mut u = state(&engine);
        let travel = protocol.bulk_x(step as f64 * time_step);
        u.push([direction[0] * travel, direction[1] * travel, 0.0]);
        bonds.balance(&mut u, protocol.load);
        bonds.forces(&u, &mut force);
        let potential = bonds.energy(&u) + protocol.load * u[blocks][2];
        let drive = [-force[blocks][0], -force[blocks][1]];
        engine.step();
        let friction = engine.contact().vectors().map(|(_, friction)| friction).collect();
        let next = state(&engine);
        let mut now = Instant { u, potential, drive, friction, velocity: vec![[0.0; 3]; blocks] };
        let later: Vec<[f64; 3]> =
            next.iter().zip(&now.u).map(|(b, a)| [0, 1, 2].map(|c: usize| (b[c] - a[c]) / time_step)).collect();
        if let Some((earlier, velocity)) = before {
            for c in 0..2 {
                drive_work += 0.5 * (earlier.drive[c] + now.drive[c]) * (now.u[blocks][c] - earlier.u[blocks][c]);
                for (number, n) in contacts.iter().enumerate() {
                    let mean = 0.5 * (earlier.friction[number][c] + now.friction[number][c]);
                    lost += mean * (now.u[*n][c] - earlier.u[*n][c]);
                }
            }
            energy = now.potential;
            for (n, mass) in bonds.mass().iter().enumerate() {
                for c in 0..3 {
                    let (v, w) = (velocity[n][c], later[n][c]);
                    energy += 0.5 * mass * v * w;
                    // gamma m times the mean velocity at either end, over the way between.
                    let mean_velocity = 0.5 * (v + w);
                    lost += 0.5 * damping * mass * (earlier.velocity[n][c] + mean_velocity) * v * time_step;
                    now.velocity[n][c] = mean_velocity;
                }
            }
            first.get_or_insert((energy, drive_work, lost));
        }
        before = Some((now, later));
    }
    let (first_energy, first_work, first_lost) = first.unwrap();
    let drive_work = drive_work - first_work;
    (drive_work - (lost - first_lost) - (energy - first_energy)) / drive_work
}

#[test]
fn the_account_closes_to_rounding() {
    for (time_step, direction) in [(0.15, [1.0, 0.0]), (0.3, [0.6, 0.8])] {
        let lack = lack(time_step, direction);
        assert!(lack.abs() < 1e-10, "{time_step}: {lack:e}");
    }
}
