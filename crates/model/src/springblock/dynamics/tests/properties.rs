//! Invariants for random arrangements of cavities; the sequence of cases is fixed.

use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

use super::super::contact::{ContactRow, ContactSums, LocalLaw};
use super::super::engine::Engine;
use super::super::runge_kutta::RungeKutta;
use super::super::strip_leapfrog::StripLeapfrog;
use super::setup;
use crate::springblock::tests::samples::coefficients;
use crate::springblock::{Coefficients, Column, Lattice, Springs};

const ROWS: usize = 5;
/// Stick-slip amplifies rounding errors; over this many steps they stay far below the forces.
const STEPS: usize = 1500;

fn runner() -> TestRunner {
    let config = Config { cases: 24, failure_persistence: None, ..Config::default() };
    TestRunner::new_with_rng(config, TestRng::from_seed(RngAlgorithm::ChaCha, &[11; 32]))
}

/// Cavity depths in rows, one per column, with at least one land.
fn depths() -> impl Strategy<Value = Vec<usize>> {
    prop::collection::vec(prop_oneof![3 => Just(0), 2 => 1..ROWS], 3..16)
        .prop_filter("no land", |depths| depths.contains(&0))
}

/// Sums over the contact row for every step. `speed` is that of the bulk; `coefficients` are given by column.
fn slide(
    depths: &[usize],
    coefficients: &[Coefficients],
    periodic: bool,
    speed: f64,
    runge_kutta: bool,
) -> Vec<ContactSums> {
    let columns = depths
        .iter()
        .map(|&rows| if rows > 0 { Column::cavity(1.0, rows as f64) } else { Column::land(1.0) })
        .collect();
    let lattice = Lattice::new(columns, ROWS, periodic);
    let mut setup = setup(&lattice, 0.2, speed);
    setup.contact = ContactRow::new(lattice.contacts(), coefficients, LocalLaw::new(None, 1.0));
    setup.protocol.start = 40.0;
    let mut engine: Box<dyn Engine> = if runge_kutta {
        Box::new(RungeKutta::new(&lattice, Springs::Exact, setup))
    } else {
        Box::new(StripLeapfrog::new(&lattice, setup))
    };
    (0..STEPS).map(|_| engine.step()).collect()
}

/// Largest difference of the sums, with the friction of `b` times `sign`.
fn difference(a: &[ContactSums], b: &[ContactSums], sign: f64) -> f64 {
    let of =
        |(a, b): (&ContactSums, &ContactSums)| (a.friction - sign * b.friction).abs().max((a.normal - b.normal).abs());
    a.iter().zip(b).map(of).fold(0.0, f64::max)
}

#[test]
fn mirrored_cavities_slide_to_the_other_side_alike() {
    runner()
        .run(&(depths(), any::<u64>(), any::<bool>(), any::<bool>()), |(depths, seed, periodic, runge_kutta)| {
            let own = coefficients(seed, depths.len());
            let mirror_depths: Vec<usize> = depths.iter().rev().copied().collect();
            let mirror_own: Vec<Coefficients> = own.iter().rev().copied().collect();
            let right = slide(&depths, &own, periodic, 1e-4, runge_kutta);
            let left = slide(&mirror_depths, &mirror_own, periodic, -1e-4, runge_kutta);
            let worst = difference(&right, &left, -1.0);
            prop_assert!(worst < 1e-9, "{}", worst);
            Ok(())
        })
        .unwrap();
}

#[test]
fn a_cell_may_begin_at_any_of_its_columns() {
    runner()
        .run(&(depths(), any::<u64>(), 1..16_usize, any::<bool>()), |(depths, seed, by, runge_kutta)| {
            let mut own = coefficients(seed, depths.len());
            let here = slide(&depths, &own, true, 1e-4, runge_kutta);
            let by = by % depths.len();
            let mut moved = depths.clone();
            moved.rotate_left(by);
            own.rotate_left(by);
            let there = slide(&moved, &own, true, 1e-4, runge_kutta);
            let worst = difference(&here, &there, 1.0);
            prop_assert!(worst < 1e-9, "{}", worst);
            Ok(())
        })
        .unwrap();
}
