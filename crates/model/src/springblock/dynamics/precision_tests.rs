//! Deviations from sliding in single precision compared with displacements in double precision.

use crate::material::AreaLaw;
use crate::pattern::{Pattern, Planform};

use super::contact::{ContactRow, ContactSums, LocalLaw};
use super::engine::{Engine, PlaneEngine, Setup};
use super::protocol::Protocol;
use super::scales::Scales;
use super::space::SpaceLeapfrog;
use super::strip_leapfrog::StripLeapfrog;
use crate::springblock::tests::samples::{E_PA, coefficients, elastic, friction, groove, pattern, persson_law};
use crate::springblock::{
    Coefficients, Lattice, SpaceLattice, SpaceLoad, SpaceSteadyModel, SteadyLoad, SteadyModel, columns, draws,
};

const BLOCK_M: f64 = 10e-6;
const PRESSURE_PA: f64 = 1.3e6;
/// Speed of the bulk in l per sqrt(m/k): 2 mm/s for the published polymer.
const SPEED: f64 = 3.6e-6;
const SEED: u64 = 3;

/// Grooves in the plane: a periodic cell, or a sample with two ends and more columns than two strips have.
fn grooves(periodic: bool) -> Lattice {
    let pattern = groove(40.0, 80.0, 20.0);
    let columns = if periodic { columns::cell(&pattern, BLOCK_M) } else { columns::sample(&pattern, BLOCK_M, 601) };
    Lattice::new(columns, 12, periodic)
}

/// Setup of the engine on `lattice`, and the sliding state from which a run starts.
fn sliding<'a>(lattice: &Lattice, law: &'a AreaLaw, liftoff: bool, seed: u64) -> (Setup<'a, 1>, Vec<[f64; 2]>) {
    let drawn = coefficients(seed, lattice.nx());
    let model = SteadyModel::new(lattice.clone(), BLOCK_M, E_PA, liftoff);
    let random_phase_friction = draws::random_phase_friction(&drawn, seed);
    let load = SteadyLoad { pressure_pa: PRESSURE_PA, dynamic_mu: &random_phase_friction, area_law: Some(law) };
    let unit_pa = Scales::new(&elastic(), BLOCK_M).pressure_pa;
    let setup = Setup {
        contact: ContactRow::new(lattice.contacts(), &drawn, LocalLaw::new(Some(law), unit_pa)),
        direction: [1.0],
        protocol: Protocol { ramp: 0.0, start: 0.0, load: PRESSURE_PA / unit_pa * lattice.length(), speed: SPEED },
        time_step: 0.3376,
        damping: 0.01,
        liftoff,
    };
    (setup, model.displacements(&load))
}

/// Largest difference of friction and normal force, relative to the largest value of each.
fn worst(single: &[ContactSums], double: &[ContactSums]) -> f64 {
    let of = |part: fn(&ContactSums) -> f64| {
        let largest = double.iter().map(|sums| part(sums).abs()).fold(0.0, f64::max);
        single.iter().zip(double).map(|(a, b)| (part(a) - part(b)).abs()).fold(0.0, f64::max) / largest
    };
    of(|sums| sums.friction).max(of(|sums| sums.normal))
}

/// Number of steps before rounding makes a block start or stop a step earlier or later.
const STEPS: usize = 1000;

#[test]
fn the_plane_moves_alike_in_single_and_double_precision() {
    let law = persson_law();
    for (periodic, liftoff) in [(true, false), (true, true), (false, false), (false, true)] {
        let lattice = grooves(periodic);
        let (setup, base) = sliding(&lattice, &law, liftoff, SEED);
        let mut double = StripLeapfrog::new(&lattice, setup.clone());
        double.start_sheared(&|i, j| base[j * lattice.nx() + i]);
        let mut single = StripLeapfrog::from_sliding(&lattice, setup, &base).unwrap();
        let (a, b): (Vec<ContactSums>, Vec<ContactSums>) = (0..STEPS).map(|_| (single.step(), double.step())).unzip();
        let apart = worst(&a, &b);
        let swing = a.iter().map(|sums| sums.friction).fold(0.0, f64::max) / a[0].friction - 1.0;
        assert!(apart < 1e-5 && swing > 1e-3, "{periodic} {liftoff}: {apart:e}, {swing:e}");
        for (i, j) in [(0, 0), (lattice.nx() - 1, 5), (lattice.nx() / 2, 11)] {
            let ([x, y], [ex, ey]) = (single.displacement(i, j), double.displacement(i, j));
            assert!((x - ex).abs() < 1e-7 && (y - ey).abs() < 1e-7, "{i} {j}: {x} {ex}, {y} {ey}");
        }
    }
}

/// Rows of 14 columns with their images fill cache lines of single precision, rows of 6 columns those of double
/// precision. In these cases vectors overwrite images of the next row.
#[test]
fn the_cell_in_space_moves_alike_in_single_and_double_precision() {
    for [width_um, spacing_um] in [[50.0, 90.0], [30.0, 30.0]] {
        assert_alike_in_space(&pattern(Planform::Square, width_um, spacing_um, 20.0));
    }
}

fn assert_alike_in_space(pattern: &Pattern) {
    let law = persson_law();
    let lattice = SpaceLattice::cell(pattern, BLOCK_M, 12);
    let [nx, ny] = lattice.columns();
    let drawn: Vec<Coefficients> = coefficients(SEED, nx * ny);
    let unit_pa = Scales::space(&elastic(), BLOCK_M).pressure_pa;
    for (direction, liftoff) in [([1.0, 0.0], false), ([0.6, 0.8], true)] {
        let phases = draws::random_phase_mean_friction(&friction(), SEED, nx * ny);
        let model = SpaceSteadyModel::new(lattice.clone(), BLOCK_M, E_PA, liftoff);
        let base = model.displacements(&SpaceLoad {
            pressure_pa: PRESSURE_PA,
            dynamic_mu: friction().dynamic_mean(),
            relative_mu: Some(&phases),
            area_law: Some(&law),
            direction,
        });
        let setup = Setup {
            contact: ContactRow::new(lattice.contacts(), &drawn, LocalLaw::new(Some(&law), unit_pa)),
            protocol: Protocol { ramp: 0.0, start: 0.0, load: PRESSURE_PA / unit_pa * (nx * ny) as f64, speed: SPEED },
            direction,
            time_step: 0.1644,
            damping: 0.01,
            liftoff,
        };
        let mut double = SpaceLeapfrog::new(&lattice, setup.clone());
        double.start_sheared(&|[i, j, k]| base[(k * ny + j) * nx + i]);
        let mut single = SpaceLeapfrog::from_sliding(&lattice, setup, &base).unwrap();
        let mut pairs = single.clone();
        let (a, b): (Vec<ContactSums>, Vec<ContactSums>) = (0..STEPS).map(|_| (single.step(), double.step())).unzip();
        let apart = worst(&a, &b);
        let swing = a.iter().map(|sums| sums.friction).fold(0.0, f64::max) / a[0].friction - 1.0;
        assert!(apart < 1e-5 && swing > 1e-3, "{direction:?} {liftoff}: {apart:e}, {swing:e}");
        let mut together = Vec::new();
        while together.len() < STEPS {
            let (first, second) = pairs.one_or_two_steps();
            together.extend(std::iter::once(first).chain(second));
        }
        assert!(together[..STEPS] == a[..], "two steps at once are two steps");
        for block in [[0, 0, 0], [nx - 1, ny / 2, 5], [nx / 2, 1, 11]] {
            let (found, expected) = (single.displacement(block), double.displacement(block));
            assert!((0..3).all(|c| (found[c] - expected[c]).abs() < 1e-7), "{block:?}: {found:?} {expected:?}");
        }
    }
}

#[test]
fn any_number_of_threads_takes_the_same_steps_from_sliding() {
    let (law, lattice) = (persson_law(), grooves(false));
    let run = |threads: usize| {
        std::thread::scope(|scope| {
            let (setup, base) = sliding(&lattice, &law, false, SEED);
            let mut engine = StripLeapfrog::from_sliding(&lattice, setup, &base).unwrap().with_threads(scope, threads);
            let sums: Vec<_> = (0..600).map(|_| engine.step()).collect();
            engine.finish();
            let rises: Vec<f64> = (0..lattice.nx()).map(|i| engine.rise(i, 5)).collect();
            (sums, rises)
        })
    };
    let alone = run(1);
    for threads in [2, 3] {
        assert!(run(threads) == alone, "{threads}");
    }
}

#[test]
fn friction_in_the_mean_is_that_of_double_precision() {
    let (law, lattice) = (persson_law(), grooves(true));
    let mean = |engine: &mut dyn FnMut() -> ContactSums| {
        let sums: Vec<ContactSums> = (0..40_000).map(|_| engine()).skip(4000).collect();
        let of = |part: fn(&ContactSums) -> f64| sums.iter().map(part).sum::<f64>();
        of(|sums| sums.friction) / of(|sums| sums.normal)
    };
    for seed in 0..12 {
        let (setup, base) = sliding(&lattice, &law, false, seed);
        let mut double = StripLeapfrog::new(&lattice, setup.clone());
        double.start_sheared(&|i, j| base[j * lattice.nx() + i]);
        let mut single = StripLeapfrog::from_sliding(&lattice, setup, &base).unwrap();
        let apart = mean(&mut || single.step()) / mean(&mut || double.step()) - 1.0;
        assert!(apart.abs() < 1e-6, "{seed}: {apart:e}");
    }
}

#[test]
fn nothing_deviates_from_a_state_that_is_not_in_equilibrium() {
    let (law, lattice) = (persson_law(), grooves(true));
    let (setup, mut base) = sliding(&lattice, &law, false, SEED);
    assert!(StripLeapfrog::from_sliding(&lattice, setup.clone(), &base).is_some());
    base[5 * lattice.nx()][0] += 1e-6;
    assert!(StripLeapfrog::from_sliding(&lattice, setup, &base).is_none());
}
