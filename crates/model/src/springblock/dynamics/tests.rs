pub mod any_width;
mod front_speed;
mod properties;
pub mod work_account;
mod work_balance;

use super::bonds::Bonds;
use super::contact::{ContactRow, LocalLaw};
use super::engine::{Engine, PlaneEngine, Setup};
use super::leapfrog::BondLeapfrog;
use super::protocol::Protocol;
use super::runge_kutta::RungeKutta;
use super::strip_leapfrog::StripLeapfrog;
use crate::springblock::tests::samples;
use crate::springblock::{Coefficients, Column, Lattice, Springs, columns};

/// Columns of a sample with cavities of 3 blocks and lands of 5 blocks.
fn sample(length: usize) -> Vec<Column> {
    columns::sample(&samples::groove(30.0, 50.0, 20.0), 10e-6, length)
}

/// A cell of 8 columns, or a sample of 37 with free ends.
pub fn patterned(periodic: bool) -> Lattice {
    let cell = || columns::cell(&samples::groove(30.0, 50.0, 20.0), 10e-6);
    Lattice::new(if periodic { cell() } else { sample(37) }, 6, periodic)
}

pub fn setup(lattice: &Lattice, time_step: f64, speed: f64) -> Setup<'static, 1> {
    let coefficients = samples::coefficients(5, lattice.nx());
    Setup {
        contact: ContactRow::new(lattice.contacts(), &coefficients, LocalLaw::new(None, 1.0)),
        direction: [1.0],
        protocol: Protocol { ramp: 20.0, start: 60.0, load: 0.005 * lattice.length(), speed },
        time_step,
        damping: 0.01,
        liftoff: false,
    }
}

#[test]
fn the_stencil_moves_as_the_bonds_do_and_strips_join_without_a_seam() {
    for periodic in [true, false] {
        // The long sample has more columns than two strips hold, not a whole number of cache lines. Stick-slip amplifies
        // rounding errors; they stay far below the forces of 0.1.
        let long = Lattice::new(sample(601), 6, periodic);
        for (lattice, steps, tolerance) in [(patterned(periodic), 4000, 1e-9), (long, 500, 1e-12)] {
            let mut fast = StripLeapfrog::new(&lattice, setup(&lattice, 0.2, 1e-5));
            let mut slow = BondLeapfrog::new(&lattice, Springs::Linear, setup(&lattice, 0.2, 1e-5));
            for step in 0..steps {
                let (a, b) = (fast.step(), slow.step());
                assert!((a.friction - b.friction).abs() < 1e-9, "{periodic} {step}: {} {}", a.friction, b.friction);
                assert!((a.normal - b.normal).abs() < 1e-9);
            }
            assert!(slow.all_have_slipped() == fast.all_have_slipped());
            for (i, j) in (0..lattice.nx()).flat_map(|i| (0..lattice.ny()).map(move |j| (i, j))) {
                assert!((fast.rise(i, j) - slow.rise(i, j)).abs() < tolerance, "{periodic} {i} {j}");
            }
        }
    }
}

#[test]
fn any_number_of_threads_takes_the_same_steps() {
    for periodic in [true, false] {
        let lattice = Lattice::new(sample(1101), 5, periodic);
        let run = |threads: usize| {
            std::thread::scope(|scope| {
                let setup = setup(&lattice, 0.2, 1e-4);
                let mut engine = StripLeapfrog::new(&lattice, setup).with_threads(scope, threads);
                let mut sums: Vec<_> = (0..300).map(|_| engine.step()).collect();
                engine.begin_drive();
                sums.extend((0..600).map(|_| engine.step()));
                let (forces, slipped) = (engine.contact_forces(), engine.all_have_slipped());
                engine.finish();
                let rises: Vec<f64> = (0..lattice.nx()).map(|i| engine.rise(i, 3)).collect();
                (sums, forces, slipped, rises)
            })
        };
        let alone = run(1);
        assert!(alone.0.iter().any(|sums| sums.friction > 0.0));
        for threads in [2, 3, 8] {
            assert!(run(threads) == alone, "{periodic} {threads}");
        }
    }
}

/// Height of a block after a fixed time of frictionless oscillation.
fn swing(make: impl Fn(&Lattice, Setup<'static, 1>) -> Box<dyn PlaneEngine>, time_step: f64) -> f64 {
    let lattice = patterned(true);
    let mut setup = setup(&lattice, time_step, 0.0);
    let coefficients = vec![Coefficients { static_mu: 0.0, dynamic_mu: 0.0 }; lattice.nx()];
    setup.contact = ContactRow::new(lattice.contacts(), &coefficients, LocalLaw::new(None, 1.0));
    setup.protocol = Protocol { ramp: 64.0, start: 1e9, load: 0.001 * lattice.length(), speed: 0.0 };
    let mut engine = make(&lattice, setup);
    for _ in 0..(48.0 / time_step).round() as usize {
        engine.step();
    }
    engine.rise(lattice.nx() / 2, 4)
}

#[test]
fn leapfrog_is_of_second_and_runge_kutta_of_fourth_order_without_friction() {
    let leapfrog = |lattice: &Lattice, setup: Setup<'static, 1>| -> Box<dyn PlaneEngine> {
        Box::new(StripLeapfrog::new(lattice, setup))
    };
    let runge_kutta = |lattice: &Lattice, setup: Setup<'static, 1>| -> Box<dyn PlaneEngine> {
        Box::new(RungeKutta::new(lattice, Springs::Linear, setup))
    };
    let exact = swing(runge_kutta, 0.0125);
    let order = |coarse: f64, fine: f64| ((coarse - exact) / (fine - exact)).abs().log2();
    let second = order(swing(leapfrog, 0.2), swing(leapfrog, 0.1));
    let fourth = order(swing(runge_kutta, 0.2), swing(runge_kutta, 0.1));
    assert!((second - 2.0).abs() < 0.2, "{second}");
    assert!((fourth - 4.0).abs() < 0.4, "{fourth}");
}

#[test]
fn plane_waves_obey_the_dispersion_relation() {
    // m w^2 = eig of Dxx = 2k(1 - cos qx) + k(1 - cos qx cos qy), Dyy likewise, Dxy = k sin qx sin qy.
    let (n, rows) = (12, 40);
    let lattice = Lattice::new(columns::flat(n), rows, true);
    let mut bonds = Bonds::new(&lattice, Springs::Linear);
    for (a, b) in [(1.0, 0.0), (1.0, 2.0), (3.0, 3.0), (6.0, 0.0), (4.0, 5.0)] {
        let (qx, qy) = (std::f64::consts::TAU * a / n as f64, std::f64::consts::TAU * b / 12.0);
        let phase = |number: usize| qx * (number % n) as f64 + qy * (number / n) as f64;
        let (dxx, dyy) = (
            2.0 * (1.0 - qx.cos()) + (1.0 - qx.cos() * qy.cos()),
            2.0 * (1.0 - qy.cos()) + (1.0 - qx.cos() * qy.cos()),
        );
        let dxy = qx.sin() * qy.sin();
        for polarization in [[1.0, 0.0], [0.0, 1.0]] {
            let u = polarization.map(|p| (0..n * rows).map(|number| p * phase(number).cos()).collect::<Vec<f64>>());
            bonds.evaluate(&u, 0.0, 0.0);
            let inside = n * (rows / 2) + 5;
            let expected = [
                -(dxx * polarization[0] + dxy * polarization[1]) * phase(inside).cos(),
                -(dxy * polarization[0] + dyy * polarization[1]) * phase(inside).cos(),
            ];
            for (force, expected) in bonds.forces().iter().zip(expected) {
                assert!((force[inside] - expected).abs() < 1e-12, "{a} {b} {polarization:?}");
            }
        }
    }
}

#[test]
fn a_lattice_under_load_without_drive_comes_to_rest_with_the_load_on_its_contacts() {
    for periodic in [true, false] {
        let lattice = patterned(periodic);
        let mut setup = setup(&lattice, 0.2, 0.0);
        setup.damping = 0.2;
        let mut engine = StripLeapfrog::new(&lattice, setup);
        let mut sums = engine.step();
        for _ in 0..20_000 {
            sums = engine.step();
        }
        let load = 0.005 * lattice.length();
        assert!((sums.normal / load - 1.0).abs() < 1e-9, "{periodic}: {} {load}", sums.normal);
        // The remaining friction balances locked-in stress, below the static threshold.
        assert!(sums.friction.abs() < 0.3 * load);
    }
}

#[test]
fn steps_beyond_the_limit_blow_up_and_steps_below_do_not() {
    let lattice = patterned(true);
    let limit = 2.0 / super::stability::largest_frequency(&lattice, false);
    let grows = |factor: f64| {
        let mut setup = setup(&lattice, factor * limit, 0.0);
        setup.damping = 0.0;
        let mut engine = StripLeapfrog::new(&lattice, setup);
        for _ in 0..4000 {
            engine.step();
        }
        let rise = engine.rise(0, 3).abs();
        rise.is_nan() || rise >= 1.0
    };
    assert!(!grows(0.99));
    assert!(grows(1.03));
}
