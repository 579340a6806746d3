//! Balance of the work of the drive: friction, damping, springs, kinetic energy.
//!
//! Powers are integrated with the stages and weights of the method itself, so that the balance closes to the order of
//! the method. A block whose velocity would reverse within a step is stopped at the end of the step; its kinetic energy
//! there, of the order of (h a)^2, counts as friction.

use super::*;
use crate::material::AreaLaw;
use crate::springblock::dynamics::contact::LocalLaw;
use crate::springblock::dynamics::tests::{patterned, setup};
use crate::springblock::tests::samples;
use crate::springblock::{Coefficients, columns};

/// Work since the start, in k l^2.
#[derive(Clone, Copy, Debug, Default)]
pub struct Ledger {
    drive: f64,
    friction: f64,
    damping: f64,
    /// Part of `friction` that stopped blocks at the end of a step.
    stops: f64,
}

impl Ledger {
    pub fn stop(&mut self, inverse_mass: f64, velocity: f64) {
        let lost = 0.5 * velocity * velocity / inverse_mass;
        self.friction += lost;
        self.stops += lost;
    }
}

impl RungeKutta<'_> {
    /// Adds the powers at a stage at time `now`, in the step that began at `time`, over the duration `h`.
    pub fn account(&mut self, h: f64, now: f64, time: f64) {
        let protocol = self.protocol;
        let speed = if time >= protocol.start { protocol.speed } else { 0.0 };
        self.ledger.drive += h * speed * self.bonds.drive(&self.stage.u, protocol.bulk_x(now));
        for c in 0..2 {
            for (v, inverse) in self.stage.v[c].iter().zip(&self.inverse_mass).filter(|(_, inverse)| **inverse > 0.0) {
                self.ledger.damping += h * self.damping * v * v / inverse;
            }
        }
        for block in &self.contact.blocks {
            let i = block.column;
            let (v, mass) = (self.stage.v[0][i], 1.0 / self.inverse_mass[i]);
            // friction = F - m a - gamma m v
            let friction = self.bonds.forces()[0][i] - mass * (self.slope.v[0][i] + self.damping * v);
            self.ledger.friction += if block.motion == Motion::Slip { h * friction * v } else { 0.0 };
        }
    }

    /// Kinetic energy plus the potential energy of springs and load.
    fn energy(&mut self) -> f64 {
        let time = self.steps as f64 * self.time_step;
        let (bulk_x, load) = (self.protocol.bulk_x(time), self.protocol.load(time));
        self.bonds.evaluate(&self.state.u, bulk_x, load);
        let moving = self.state.v.iter().flat_map(|v| v.iter().zip(&self.inverse_mass));
        let kinetic: f64 =
            moving.filter(|(_, inverse)| **inverse > 0.0).map(|(v, inverse)| 0.5 * v * v / inverse).sum();
        kinetic + self.bonds.potential(&self.state.u, bulk_x, load)
    }
}

/// 1 ns in units of sqrt(m/k) for the published polymer at l = 10 um.
const NANOSECOND: f64 = 0.056273;

fn engine<'a>(springs: Springs, time_step: f64, speed: f64, damping: f64, law: Option<&'a AreaLaw>) -> RungeKutta<'a> {
    let lattice = patterned(true);
    let coefficients = samples::coefficients(5, lattice.nx());
    // 2.6 MPa over k / l = 0.75 x 0.38 GPa; times are whole numbers of steps.
    let setup = Setup {
        contact: ContactRow::new(lattice.contacts(), &coefficients, LocalLaw::new(law, 285e6)),
        direction: [1.0],
        protocol: Protocol {
            ramp: 200.0 * NANOSECOND,
            start: 1000.0 * NANOSECOND,
            load: 2.6 / 285.0 * lattice.length(),
            speed,
        },
        time_step,
        damping,
        liftoff: false,
    };
    RungeKutta::new(&lattice, springs, setup)
}

/// Drives `engine` for `nanoseconds` after the start of the drive; returns the balance error, the work of the drive,
/// and the ledger.
fn run(mut engine: RungeKutta, nanoseconds: f64) -> (f64, f64, Ledger) {
    let steps = |ns: f64| (ns * NANOSECOND / engine.time_step).round() as u64;
    let (before, after) = (steps(1000.0), steps(nanoseconds));
    for _ in 0..before {
        engine.step();
    }
    let (start, books) = (engine.energy(), engine.ledger);
    for _ in 0..after {
        engine.step();
    }
    let ledger = Ledger {
        drive: engine.ledger.drive - books.drive,
        friction: engine.ledger.friction - books.friction,
        damping: engine.ledger.damping - books.damping,
        stops: engine.ledger.stops - books.stops,
    };
    let stored = engine.energy() - start;
    (ledger.drive - ledger.friction - ledger.damping - stored, ledger.drive, ledger)
}

/// Speed of the bulk, 2 m/s over l sqrt(k/m) = 562.7 m/s: a thousand times the usual speed.
const SPEED: f64 = 2.0 / 562.73;

#[test]
fn the_work_of_the_drive_is_accounted_for() {
    // The last run has the published speed and starts from rest; most blocks are at rest at any instant.
    let runs = [
        (Springs::Linear, 1.0, 20_000.0),
        (Springs::Linear, 20.0, 20_000.0),
        (Springs::Exact, 20.0, 20_000.0),
        (Springs::Exact, 1000.0, 250_000.0),
    ];
    for (springs, slower, nanoseconds) in runs {
        let speed = SPEED / slower;
        let (error, drive, ledger) = run(engine(springs, NANOSECOND, speed, 0.01, None), nanoseconds);
        assert!(drive > 0.0 && ledger.friction > 0.0 && ledger.damping > 0.0 && ledger.stops > 0.0);
        assert!(error.abs() < 1e-6 * drive, "{springs:?} {speed}: {error} of {drive}");
    }
}

#[test]
fn the_balance_error_falls_at_least_with_the_fourth_power_of_the_step_while_no_block_stops() {
    // Steps are long enough for the error to exceed rounding.
    let error = |factor: f64| {
        let (error, drive, ledger) = run(engine(Springs::Exact, factor * NANOSECOND, SPEED, 0.3, None), 4_000.0);
        assert_eq!(ledger.stops, 0.0);
        (error / drive).abs()
    };
    let errors = [8.0, 4.0, 2.0].map(error);
    assert!(errors[0] < 1e-5, "{errors:?}");
    assert!(errors.windows(2).all(|pair| pair[1] < pair[0] / 2_f64.powf(3.8)), "{errors:?}");
}

#[test]
fn energy_is_never_created_without_drive() {
    let law = AreaLaw::new(vec![0.7e6, 2.6e6, 10e6], vec![1.0, 0.9, 0.6]).unwrap();
    for (springs, damping) in [(Springs::Exact, 0.0), (Springs::Linear, 0.01)] {
        let mut engine = engine(springs, NANOSECOND, 0.0, damping, Some(&law));
        for _ in 0..1000 {
            engine.step();
        }
        let mut last = engine.energy();
        let first = last;
        for _ in 0..10_000 {
            engine.step();
            let now = engine.energy();
            assert!(now <= last + 1e-9 * first.abs(), "{springs:?} {damping}: {last} {now}");
            last = now;
        }
        assert!(last < first);
    }
}

#[test]
fn a_flat_face_that_no_force_moves_rests_until_the_static_threshold() {
    let lattice = Lattice::new(columns::flat(4), 4, true);
    let coefficients = vec![Coefficients { static_mu: 0.4, dynamic_mu: 0.27 }; lattice.nx()];
    let contact = ContactRow::new(lattice.contacts(), &coefficients, LocalLaw::new(None, 1.0));
    let mut engine = RungeKutta::new(&lattice, Springs::Linear, Setup { contact, ..setup(&lattice, 0.05, 1e-5) });
    // The load acts from 0 on, and the bulk moves from 60 on.
    for _ in 0..1200 {
        engine.step();
    }
    engine.begin_drive();
    let mut most = 0.0_f64;
    while !engine.all_have_slipped() {
        most = most.max(engine.step().mu().unwrap());
    }
    assert!((0.399..=0.4).contains(&most), "slipped at {most}");
}
