//! The integrator of a cell compared with the sum over springs, closed forms, its symmetries, and the plane.

mod work_balance;

use crate::material::AreaLaw;
use crate::pattern::{Pattern, Planform, RimProfile, Texture};

use super::super::contact::{ContactRow, ContactSums, LocalLaw};
use super::super::engine::{Engine, PlaneEngine, Setup};
use super::super::protocol::Protocol;
use super::super::strip_leapfrog::StripLeapfrog;
use super::bonds::SpaceBonds;
use super::leapfrog::SpaceLeapfrog;
use crate::springblock::tests::samples::{coefficients, pattern, rimmed};
use crate::springblock::{Coefficients, Lattice, SpaceLattice, SpaceLoad, SpaceSteadyModel, columns};

/// A cell of `nx` columns along x and `ny` along y with one rectangular cavity; the cell has `rows` rows.
fn cell(width: usize, length: usize, [nx, ny]: [usize; 2], depth: usize, rows: usize) -> SpaceLattice {
    let um = |blocks: usize| blocks as f64 * 10e-6;
    let texture = Texture::new(Planform::Rectangle).with_length_m(um(length)).unwrap();
    let texture = texture.with_spacing_across_m(um(ny - length)).unwrap();
    let pattern = Pattern::new(texture, um(width), um(nx - width), um(depth)).unwrap();
    let lattice = SpaceLattice::cell(&pattern, 10e-6, rows);
    assert!(lattice.is_plain() && lattice.columns() == [nx, ny]);
    lattice
}

fn protocol(lattice: &SpaceLattice, speed: f64) -> Protocol {
    Protocol { ramp: 20.0, start: 40.0, load: 0.005 * lattice.face_columns() as f64, speed }
}

fn setup(
    lattice: &SpaceLattice,
    coefficients: &[Coefficients],
    protocol: Protocol,
    direction: [f64; 2],
) -> Setup<'static, 2> {
    Setup {
        contact: ContactRow::new(lattice.contacts(), coefficients, LocalLaw::new(None, 1.0)),
        protocol,
        direction,
        time_step: 0.15,
        damping: 0.01,
        liftoff: false,
    }
}

/// A fixed sequence of numbers in (-1/2, 1/2).
fn noise(number: usize, component: usize) -> f64 {
    let mut bits = (3 * number + component) as u64 + 1;
    for _ in 0..3 {
        bits = bits.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        bits ^= bits >> 29;
    }
    (bits >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
}

#[test]
fn the_sweeps_are_the_sum_over_springs() {
    let lattices = [
        cell(4, 3, [12, 10], 2, 6),
        cell(1, 1, [3, 2], 1, 3),
        cell(9, 4, [17, 9], 4, 5),
        SpaceLattice::flat([1, 1], 1),
        SpaceLattice::flat([8, 5], 4),
        cell(2, 2, [4, 4], 2, 4).repeated_along_y(2),
    ];
    for lattice in &lattices {
        let ([nx, ny], rows) = (lattice.columns(), lattice.rows());
        let blocks = nx * ny * rows;
        let drawn = coefficients(1, nx * ny);
        let start = Protocol { ramp: 0.0, start: 0.0, load: 0.3, speed: 0.0 };
        let mut setup = setup(lattice, &drawn, start, [1.0, 0.0]);
        setup.damping = 0.0;
        let dt = setup.time_step;
        let mut engine = SpaceLeapfrog::new(lattice, setup);
        let there = |n: usize| lattice.presence(n % nx, n / nx % ny, n / (nx * ny)) > 0.0;
        let touches = |n: usize| n < nx * ny && lattice.contact_share(n % nx, n / nx) > 0.0;
        let mut u: Vec<[f64; 3]> = (0..=blocks)
            .map(|n| {
                let all = [0, 1, 2].map(|c| noise(n, c));
                if n == blocks || !there(n) {
                    [0.0; 3]
                } else {
                    [all[0], all[1], if touches(n) { 0.0 } else { all[2] }]
                }
            })
            .collect();
        engine.start_sheared(&|[i, j, k]| u[(k * ny + j) * nx + i]);
        let bonds = SpaceBonds::new(lattice);
        bonds.balance(&mut u, 0.3);
        let mut force = vec![[0.0; 3]; blocks + 1];
        bonds.forces(&u, &mut force);
        assert!((force[blocks][2] - 0.3).abs() < 1e-12, "the bulk's springs carry the load");
        engine.step();
        let mut contacts = engine.contact().vectors();
        for n in 0..blocks {
            let moved = engine.displacement([n % nx, n / nx % ny, n / (nx * ny)]);
            if touches(n) {
                let (normal, _) = contacts.next().unwrap();
                assert!((normal.abs() - force[n][2].abs()).abs() < 1e-12, "{nx} {ny} {rows}: {normal} {:?}", force[n]);
                continue;
            }
            let mass = bonds.mass()[n];
            for c in 0..3 {
                // u_1 - u_0 = dt^2 F / m
                let expected = if mass > 0.0 { u[n][c] + dt * dt * force[n][c] / mass } else { 0.0 };
                assert!((moved[c] - expected).abs() < 1e-14, "{nx} {ny} {rows} block {n}: {moved:?} {expected}");
            }
        }
        assert!(contacts.next().is_none());
    }
}

#[test]
fn a_cell_under_load_without_drive_comes_to_rest_with_the_load_on_its_contacts() {
    for liftoff in [false, true] {
        let lattice = cell(3, 3, [8, 6], 2, 5);
        let drawn = coefficients(1, 48);
        let mut setup = setup(&lattice, &drawn, protocol(&lattice, 0.0), [0.6, 0.8]);
        setup.damping = 0.2;
        setup.liftoff = liftoff;
        let load = setup.protocol.load;
        let mut engine = SpaceLeapfrog::new(&lattice, setup);
        let mut sums = engine.step();
        for _ in 0..10_000 {
            sums = engine.step();
        }
        assert!((sums.normal / load - 1.0).abs() < 1e-9, "{} {load}", sums.normal);
        // The remaining friction balances locked-in stress, below the static threshold.
        assert!(sums.friction.hypot(sums.across) < 0.3 * load);
    }
}

#[test]
fn a_steady_equilibrium_stays_where_it_is() {
    let lattice = cell(4, 4, [12, 12], 2, 8);
    let model = SpaceSteadyModel::new(lattice.clone(), 10e-6, 0.38e9, false);
    let law = AreaLaw::new(vec![0.7e6, 1.3e6, 2.6e6, 10e6], vec![1.0, 0.96, 0.9, 0.6]).unwrap();
    let unit_pa = 0.4 * 0.38e9;
    for direction in [[1.0, 0.0], [0.0, -1.0], [0.6, 0.8]] {
        let load =
            SpaceLoad { pressure_pa: 2.6e6, dynamic_mu: 0.27, relative_mu: None, area_law: Some(&law), direction };
        let displacement = model.displacements(&load);
        // The threshold at rest equals the sliding friction.
        let equal = vec![Coefficients { static_mu: 0.27000001, dynamic_mu: 0.27 }; 144];
        let still = Protocol { ramp: 0.0, start: 0.0, load: 144.0 * 2.6e6 / unit_pa, speed: 0.0 };
        let mut setup = setup(&lattice, &equal, still, direction);
        setup.contact = ContactRow::new(lattice.contacts(), &equal, LocalLaw::new(Some(&law), unit_pa));
        let mut engine = SpaceLeapfrog::new(&lattice, setup);
        engine.start_sheared(&|[i, j, k]| displacement[(k * 12 + j) * 12 + i]);
        let sums = engine.step();
        let steady = model.solve(&load).mu_dynamic.unwrap();
        assert!((sums.friction / sums.normal - steady).abs() < 1e-8, "{} {steady}", sums.friction / sums.normal);
        for _ in 0..20 {
            engine.step();
        }
        for (number, expected) in displacement.iter().take(12 * 12 * 8).enumerate() {
            let block = [number % 12, number / 12 % 12, number / 144];
            if lattice.presence(block[0], block[1], block[2]) > 0.0 {
                let found = engine.displacement(block);
                for c in 0..3 {
                    assert!((found[c] - expected[c]).abs() < 1e-10, "{block:?} {found:?} {expected:?}");
                }
            }
        }
    }
}

#[test]
fn two_steps_at_once_are_two_steps_bit_for_bit() {
    let disc = pattern(Planform::Disc, 70.0, 60.0, 20.0);
    let lattices = [
        cell(4, 3, [12, 10], 2, 6),
        cell(9, 4, [17, 9], 4, 5),
        SpaceLattice::flat([1, 1], 1),
        SpaceLattice::flat([8, 5], 2),
        SpaceLattice::flat([5, 23], 4),
        SpaceLattice::cell(&disc, 10e-6, 9).nearest_whole(),
        SpaceLattice::cell(&rimmed(Planform::Square, [40.0, 80.0, 20.0], 0.3, 20.0, RimProfile::Flat), 10e-6, 8),
    ];
    for (lattice, liftoff) in lattices.iter().flat_map(|lattice| [(lattice, false), (lattice, true)]) {
        let ([nx, ny], rows) = (lattice.columns(), lattice.rows());
        let drawn = coefficients(6, nx * ny);
        let start = || {
            let mut setup = setup(lattice, &drawn, protocol(lattice, 1e-3), [0.6, 0.8]);
            setup.liftoff = liftoff || lattice.is_raised();
            setup.contact.place(|column| [lattice.relief(column % nx, column / nx), lattice.highest()]);
            let mut engine = SpaceLeapfrog::new(lattice, setup);
            engine.start_sheared(&|_| [0.0, 0.0, lattice.highest()]);
            engine
        };
        let (mut single, mut paired) = (start(), start());
        for pair in 0..300 {
            let (first, second) = (single.step(), single.step());
            assert_eq!(paired.one_or_two_steps(), (first, Some(second)), "{nx} {ny} {rows} {liftoff}: {pair}");
            // Single steps continue from pairs of steps.
            if pair % 50 == 49 {
                assert_eq!(paired.step(), single.step());
            }
        }
        let bits = |engine: &SpaceLeapfrog<f64>| -> Vec<u64> {
            let blocks = (0..nx * ny * rows).map(|n| [n % nx, n / nx % ny, n / (nx * ny)]);
            blocks.flat_map(|block| engine.displacement(block)).map(f64::to_bits).collect()
        };
        assert!(bits(&single) == bits(&paired) && bits(&single).iter().any(|bits| *bits != 0));
        assert!(single.contact().vectors().eq(paired.contact().vectors()));
        assert_eq!(single.all_have_slipped(), paired.all_have_slipped());
    }
}

#[test]
fn no_step_follows_sums_that_are_not_finite() {
    let lattice = cell(3, 3, [8, 8], 2, 9);
    let drawn = coefficients(1, 64);
    let start = || {
        let mut setup = setup(&lattice, &drawn, protocol(&lattice, 0.0), [1.0, 0.0]);
        setup.time_step = 1.0;
        SpaceLeapfrog::new(&lattice, setup)
    };
    let mut singles = start();
    let steps = (1_u64..).find(|_| !singles.step().is_finite()).unwrap();
    for alone in [steps % 2, (steps + 1) % 2] {
        let mut paired = start();
        for _ in 0..alone {
            paired.step();
        }
        let mut taken = alone;
        while let (_, Some(second)) = paired.one_or_two_steps() {
            taken += 2;
            if !second.is_finite() {
                break;
            }
        }
        let left_out = (steps - alone) % 2;
        assert_eq!(taken + left_out, steps);
        for block in [[0, 0, 0], [3, 4, 2], [7, 7, 8]] {
            assert_eq!(paired.displacement(block).map(f64::to_bits), singles.displacement(block).map(f64::to_bits));
        }
    }
}

const STEPS: usize = 1500;

/// Sums over the contact layer for every step.
fn slide(lattice: &SpaceLattice, drawn: &[Coefficients], direction: [f64; 2], liftoff: bool) -> Vec<ContactSums> {
    let mut setup = setup(lattice, drawn, protocol(lattice, 1e-4), direction);
    setup.liftoff = liftoff;
    let mut engine = SpaceLeapfrog::new(lattice, setup);
    (0..STEPS).map(|_| engine.step()).collect()
}

/// Largest difference of the sums, with the perpendicular part of `b` times `sign`.
fn difference(a: &[ContactSums], b: &[ContactSums], sign: f64) -> f64 {
    let of = |(a, b): (&ContactSums, &ContactSums)| {
        (a.friction - b.friction).abs().max((a.normal - b.normal).abs()).max((a.across - sign * b.across).abs())
    };
    assert!(a.iter().any(|sums| sums.across.abs() > 1e-5), "something happens across");
    a.iter().zip(b).map(of).fold(0.0, f64::max)
}

#[test]
fn sliding_along_y_is_sliding_along_x_on_the_transposed_cell() {
    let (here, there) = (cell(4, 3, [10, 7], 2, 5), cell(3, 4, [7, 10], 2, 5));
    let drawn = coefficients(3, 70);
    let transposed: Vec<Coefficients> = (0..70).map(|n| drawn[(n % 7) * 10 + n / 7]).collect();
    for liftoff in [false, true] {
        let along_x = slide(&here, &drawn, [1.0, 0.0], liftoff);
        let along_y = slide(&there, &transposed, [0.0, 1.0], liftoff);
        // The perpendicular axis is to the left for sliding along x and to the right for sliding along y.
        let worst = difference(&along_x, &along_y, -1.0);
        assert!(worst < 1e-9, "{worst}");
    }
}

#[test]
fn mirrored_cells_slide_alike() {
    let lattice = cell(4, 3, [10, 7], 2, 5);
    let drawn = coefficients(4, 70);
    // 10 and 7 columns with cavities of 4 and 3, so that the cell is its own mirror image.
    let across: Vec<Coefficients> = (0..70).map(|n| drawn[(6 - n / 10) * 10 + n % 10]).collect();
    let back: Vec<Coefficients> = (0..70).map(|n| drawn[n / 10 * 10 + 9 - n % 10]).collect();
    let own = slide(&lattice, &drawn, [1.0, 0.0], false);
    let oblique = slide(&lattice, &drawn, [0.6, 0.8], false);
    for (here, mirrored, direction) in
        [(&own, &across, [1.0, 0.0]), (&own, &back, [-1.0, 0.0]), (&oblique, &across, [0.6, -0.8])]
    {
        let worst = difference(here, &slide(&lattice, mirrored, direction, false), -1.0);
        assert!(worst < 1e-9, "{worst}");
    }
}

/// Plane strain at nu = 1/4 is plane stress at nu = 1/3: if nothing changes along y, the springs of a column are those
/// of the vertical plane with k doubled, bond by bond. The unit of time sqrt(m/k) is larger by sqrt(2).
#[test]
fn what_is_uniform_across_is_the_vertical_plane_to_rounding() {
    let pattern = pattern(Planform::Groove, 40.0, 80.0, 20.0);
    let cell = SpaceLattice::cell(&pattern, 10e-6, 6).repeated_along_y(3);
    as_in_the_plane(&cell, &Lattice::new(columns::cell(&pattern, 10e-6), 6, true), 0);
    // A strip with two free ends along y.
    let strip = cell.transposed().strip_along_y(31, 2, |line| Some(line % 12));
    as_in_the_plane(&strip, &Lattice::new(columns::sample(&pattern, 10e-6, 31), 6, false), 1);
}

/// Asserts that `lattice`, which has three columns across, slides along `axis` as `in_plane` does.
fn as_in_the_plane(lattice: &SpaceLattice, in_plane: &Lattice, axis: usize) {
    const ACROSS: usize = 3;
    let length = in_plane.nx();
    let [nx, ny] = lattice.columns();
    let along = |column: usize| [column % nx, column / nx][axis];
    let row = coefficients(5, length);
    let drawn: Vec<Coefficients> = (0..nx * ny).map(|column| row[along(column) % length]).collect();
    let law = AreaLaw::new(vec![0.7e6, 1.3e6, 2.6e6, 10e6], vec![1.0, 0.96, 0.9, 0.6]).unwrap();
    let (root, unit_pa) = (2.0_f64.sqrt(), 0.4 * 0.38e9);
    let own = protocol(lattice, 1e-4);
    let mut direction = [0.0; 2];
    direction[axis] = 1.0;
    let mut setup = setup(lattice, &drawn, own, direction);
    setup.contact = ContactRow::new(lattice.contacts(), &drawn, LocalLaw::new(Some(&law), unit_pa));
    let (dt, damping) = (setup.time_step, setup.damping);
    let mut engine = SpaceLeapfrog::new(lattice, setup);
    let plane = Protocol {
        ramp: own.ramp * root,
        start: own.start * root,
        load: own.load / ACROSS as f64 / 2.0,
        speed: own.speed / root,
    };
    let contact = ContactRow::new(in_plane.contacts(), &row, LocalLaw::new(Some(&law), 2.0 * unit_pa));
    let (time_step, damping) = (dt * root, damping / root);
    let setup = Setup { contact, direction: [1.0], protocol: plane, time_step, damping, liftoff: false };
    let mut flat = StripLeapfrog::new(in_plane, setup);
    let mut moved = false;
    for step in 0..2500 {
        let (space, plane) = (engine.step(), flat.step());
        let worst = (space.friction / 2.0 / ACROSS as f64 - plane.friction).abs();
        assert!(worst < 1e-11 && space.across.abs() < 1e-11, "{step}: {space:?} {plane:?}");
        assert!((space.normal / 2.0 / ACROSS as f64 - plane.normal).abs() < 1e-11, "{step}");
        moved |= engine.all_have_slipped();
    }
    assert!(moved, "every block has slipped");
    let block = |i: usize, j: usize, k: usize| if axis == 0 { [i, j, k] } else { [j, i, k] };
    for (i, k) in (0..length).flat_map(|i| (0..6).map(move |k| (i, k))) {
        let [first, others @ ..] = [0, 1, 2].map(|j| block(i, j, k));
        if lattice.presence(first[0], first[1], k) == 0.0 {
            continue;
        }
        let first = engine.displacement(first);
        for other in others {
            let other = engine.displacement(other);
            assert!((0..3).all(|c| (other[c] - first[c]).abs() < 1e-12), "{i} {k}");
        }
        let [x, z] = flat.displacement(i, k);
        assert!((first[axis] - x).abs() < 1e-11 && (first[2] - z).abs() < 1e-11 && first[1 - axis].abs() < 1e-12);
        assert_eq!(z, flat.rise(i, k));
    }
}

#[test]
fn friction_never_gives_work_and_never_exceeds_its_law() {
    let lattice = cell(4, 3, [10, 7], 2, 5);
    let drawn = coefficients(6, 70);
    let contacts: Vec<usize> = lattice.contacts().collect();
    let mut engine = SpaceLeapfrog::new(&lattice, setup(&lattice, &drawn, protocol(&lattice, 1e-4), [0.8, 0.6]));
    let place = |engine: &SpaceLeapfrog<f64>, n: usize| engine.displacement([n % 10, n / 10, 0]);
    let mut before: Vec<[f64; 3]> = contacts.iter().map(|n| place(&engine, *n)).collect();
    let mut earlier = before.clone();
    let mut slid = vec![false; contacts.len()];
    let (mut slides, mut stops) = (0, 0);
    for _ in 0..3000 {
        engine.step();
        let forces: Vec<(f64, [f64; 2])> = engine.contact().vectors().collect();
        for (number, n) in contacts.iter().enumerate() {
            let (normal, friction) = forces[number];
            let after = place(&engine, *n);
            let way: [f64; 2] = [0, 1].map(|c: usize| after[c] - earlier[number][c]);
            let magnitude = friction[0].hypot(friction[1]);
            // A block that slides before and after this instant has the friction of the law.
            let keeps_sliding =
                magnitude > 0.0 && (magnitude - drawn[*n].dynamic_mu * normal).abs() < 1e-12 * normal.max(1.0);
            if keeps_sliding && slid[number] {
                assert!(friction[0] * way[0] + friction[1] * way[1] > 0.0, "{friction:?} {way:?}");
                slides += 1;
            } else {
                // A block that rests, starts or stops within the step: stopping takes hardly more force than holding.
                let top_row_force = drawn[*n].starting_mu() * normal.max(0.0);
                assert!(magnitude <= 1.2 * top_row_force, "{magnitude} {top_row_force}");
                stops += usize::from(slid[number]);
            }
            slid[number] = keeps_sliding;
            (earlier[number], before[number]) = (before[number], after);
        }
    }
    assert!(slides > 1000 && stops > 100, "{slides} {stops}");
}
