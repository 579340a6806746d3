//! The leapfrog's account of work: what the drive gives is what friction and damping take, what springs
//! and the load store, and kinetic energy.
//!
//! With displacements u_n, velocities v between them and forces at them, sums by the trapezoid rule and the
//! kinetic energy v_- . M v_+ / 2 close to rounding, with linear springs, for any step and through every
//! switch between rest and slip: the friction that is reported is the one that the step took.

use slipgrid_material::LocalFriction;
use slipgrid_pattern::{Pattern, Planform};

use super::bonds::Bonds;
use super::contact::{ContactRow, LocalLaw};
use super::engine::{Engine, Setup};
use super::protocol::Protocol;
use super::strip_leapfrog::StripLeapfrog;
use crate::columns;
use crate::draws;
use crate::lattice::Lattice;
use crate::scene::Springs;

/// What an instant adds to the account.
struct Instant {
    u: [Vec<f64>; 2],
    bulk_x: f64,
    potential: f64,
    drive: f64,
    /// By column.
    friction: Vec<f64>,
    /// Mean of the velocities before and after.
    velocity: [Vec<f64>; 2],
}

/// Displacements of all blocks, x and y.
fn state<'scope, 'a: 'scope>(engine: &StripLeapfrog<'scope, '_, 'a>, lattice: &Lattice) -> [Vec<f64>; 2] {
    let (nx, ny) = (lattice.nx(), lattice.ny());
    [0, 1].map(|c: usize| (0..nx * ny).map(|number| engine.displacement(number % nx, number / nx)[c]).collect())
}

/// What the account lacks, as a share of the drive's work.
fn lack(time_step: f64, periodic: bool) -> f64 {
    let pattern = Pattern::new(Planform::Groove, 30e-6, 50e-6, 20e-6).unwrap();
    let columns = if periodic { columns::cell(&pattern, 10e-6) } else { columns::sample(&pattern, 10e-6, 37) };
    let lattice = Lattice::new(columns, 6, periodic);
    let (nx, blocks) = (lattice.nx(), lattice.nx() * lattice.ny());
    let mass: Vec<f64> = (0..blocks).map(|number| lattice.mass(number % nx, number / nx)).collect();
    let coefficients = draws::draw(&LocalFriction::new(0.3, 0.27, 0.05).unwrap(), 5, nx);
    let protocol = Protocol { ramp: 0.0, start: 30.0, load: 0.005 * lattice.length(), speed: 1e-4 };
    let damping = 0.01;
    let contact = ContactRow::new(lattice.contacts(), &coefficients, LocalLaw::new(None, 1.0));
    let setup = Setup { contact, protocol, time_step, damping, liftoff: false };
    let mut engine = StripLeapfrog::new(&lattice, setup);
    let mut bonds = Bonds::new(&lattice, Springs::Linear);

    let (mut drive_work, mut lost, mut first, mut energy) = (0.0, 0.0, None, 0.0);
    let mut before: Option<(Instant, [Vec<f64>; 2])> = None;
    for step in 0..(2000.0 / time_step) as usize {
        let u: [Vec<f64>; 2] = state(&engine, &lattice);
        let bulk_x = protocol.bulk_x(step as f64 * time_step);
        bonds.evaluate(&u, bulk_x, protocol.load);
        let (potential, drive) = (bonds.potential(&u, bulk_x, protocol.load), bonds.drive(&u, bulk_x));
        engine.step();
        let mut friction = vec![0.0; nx];
        for (column, force) in lattice.contacts().zip(engine.contact_forces()) {
            friction[column] = force.friction;
        }
        let next: [Vec<f64>; 2] = state(&engine, &lattice);
        let velocity = [vec![0.0; blocks], vec![0.0; blocks]];
        let mut now = Instant { u, bulk_x, potential, drive, friction, velocity };
        let later = [0, 1].map(|c: usize| {
            next[c].iter().zip(&now.u[c]).map(|(next, now)| (next - now) / time_step).collect::<Vec<f64>>()
        });
        if let Some((earlier, velocity)) = before {
            drive_work += 0.5 * (earlier.drive + now.drive) * (now.bulk_x - earlier.bulk_x);
            for i in 0..nx {
                lost += 0.5 * (earlier.friction[i] + now.friction[i]) * (now.u[0][i] - earlier.u[0][i]);
            }
            energy = now.potential;
            for c in 0..2 {
                for number in 0..blocks {
                    let (v, w) = (velocity[c][number], later[c][number]);
                    energy += 0.5 * mass[number] * v * w;
                    // gamma m times the mean velocity at either end, over the way between.
                    let mean_velocity = 0.5 * (v + w);
                    let way = v * time_step;
                    lost += 0.5 * damping * mass[number] * (earlier.velocity[c][number] + mean_velocity) * way;
                    now.velocity[c][number] = mean_velocity;
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
    for (periodic, time_step) in [(true, 0.2), (true, 0.4), (false, 0.2)] {
        let lack = lack(time_step, periodic);
        assert!(lack.abs() < 1e-10, "{periodic} {time_step}: {lack:e}");
    }
}
