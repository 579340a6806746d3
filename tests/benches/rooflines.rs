//! How near each kernel comes to what the machine allows: additions of numbers that lie in registers, and bytes that move
//! between a kernel and the cache or memory that holds its data, of one thread.
//!
//! `cargo bench -p slipgrid-tests --bench rooflines` (a minute) writes the tables of the book's page on rooflines.

#![allow(clippy::print_stdout)]

mod rates;

use std::hint::black_box;
use std::time::Instant;

use pulp::{Simd, WithSimd};
use slipgrid_base::fft::vectorized;
use slipgrid_model::pattern::{Pattern, Planform};
use slipgrid_model::springblock::{Extent, Fidelity, Scene, SteadyCell};
use slipgrid_surface::contact::{SolveOptions, area_curve};
use slipgrid_surface::topography::SelfAffine;
use slipgrid_surface::topography::fourier::Fourier;
use slipgrid_tests::{polymer_scene, published, published_groove};

use rates::{median, site_updates_per_second};

/// Additions of one measurement.
const ADDITIONS: usize = 1 << 30;
/// Bytes that one measurement moves.
const MOVED_BYTES: usize = 4 << 30;

macro_rules! peak {
    ($name:ident, $number:ty, $splat:ident, $add:ident) => {
        /// Independent sums, more than the latency of an addition needs.
        struct $name;

        impl WithSimd for $name {
            type Output = f64;

            /// Additions a second.
            #[inline(always)]
            fn with_simd<S: Simd>(self, simd: S) -> f64 {
                const SUMS: usize = 12;
                let step = simd.$splat(black_box(1.0));
                let mut sums = [simd.$splat(black_box(0.0)); SUMS];
                let lanes = size_of_val(&step) / size_of::<$number>();
                let rounds = ADDITIONS / (SUMS * lanes);
                let start = Instant::now();
                for _ in 0..rounds {
                    for sum in &mut sums {
                        *sum = simd.$add(*sum, step);
                    }
                }
                let seconds = start.elapsed().as_secs_f64();
                black_box(sums.map(|sum| simd.$add(sum, step)));
                (rounds * SUMS * lanes) as f64 / seconds
            }
        }
    };
}
peak!(SumsF64, f64, splat_f64s, add_f64s);
peak!(SumsF32, f32, splat_f32s, add_f32s);

/// a = b + c a: two numbers are read and one is written, as a kernel does that moves displacements.
struct Triad<'a>(&'a mut [f64], &'a [f64]);

impl WithSimd for Triad<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for (a, b) in self.0.iter_mut().zip(self.1) {
            *a = b + 0.5 * *a;
        }
    }
}

/// Bytes a second between the processor and what holds `bytes` bytes.
fn bandwidth(bytes: usize) -> f64 {
    let numbers = bytes / 16;
    let (mut a, b) = (vec![1.0; numbers], vec![0.5; numbers]);
    let rounds = (MOVED_BYTES / (24 * numbers)).max(1);
    median(|| {
        let start = Instant::now();
        for _ in 0..rounds {
            vectorized(Triad(black_box(&mut a), black_box(&b)));
        }
        (rounds * 24 * numbers) as f64 / start.elapsed().as_secs_f64()
    })
}

/// Limits of the machine, per second.
struct Machine {
    /// Additions in double and in single precision.
    additions: [f64; 2],
    /// Bytes from the second-level cache, the third, and memory.
    bytes: [f64; 3],
}

/// Where the data of a kernel lie.
#[derive(Clone, Copy)]
enum Held {
    SecondCache,
    ThirdCache,
    Memory,
}

/// A kernel with its cost per unit of work.
struct Kernel {
    name: &'static str,
    unit: &'static str,
    is_single: bool,
    additions: f64,
    bytes: f64,
    held: Held,
    /// Units a second.
    measured: f64,
}

impl Machine {
    fn measured() -> Self {
        Self {
            additions: [median(|| vectorized(SumsF64)), median(|| vectorized(SumsF32))],
            bytes: [256 << 10, 8 << 20, 1 << 30].map(bandwidth),
        }
    }

    fn print(&self) {
        println!("| machine, one thread | a second |\n|---|---|");
        println!("| additions in double; in single precision | {:.2e}; {:.2e} |", self.additions[0], self.additions[1]);
        let bytes = self.bytes.map(|bytes| format!("{:.0}", bytes * 1e-9)).join("; ");
        println!("| gigabytes of 256 kB; 8 MB; 1 GB | {bytes} |");
        println!("\n| kernel | unit | additions | bytes | limit | by | measured | share |");
        println!("|---|---|---|---|---|---|---|---|");
    }

    /// Prints a row: the smaller of both limits, and the share of it that was measured.
    fn judge(&self, kernel: &Kernel) {
        let Kernel { name, unit, is_single, additions, bytes, held, measured } = kernel;
        let by_additions = self.additions[usize::from(*is_single)] / additions;
        let (bandwidth, place) = match held {
            Held::SecondCache => (self.bytes[0], "second cache"),
            Held::ThirdCache => (self.bytes[1], "third cache"),
            Held::Memory => (self.bytes[2], "memory"),
        };
        let by_bytes = bandwidth / bytes;
        let (limit, by) = if by_additions < by_bytes { (by_additions, "additions") } else { (by_bytes, place) };
        println!(
            "| {name} | {unit} | {additions:.0} | {bytes:.0} | {limit:.2e} | {by} | {measured:.2e} | {:.0} % |",
            100.0 * measured / limit
        );
    }
}

fn scene(pattern: Option<Pattern>, extent: Extent, is_warm: bool) -> Scene {
    let mut scene = polymer_scene(pattern, &[2.6], Fidelity::Dynamic, extent).expect("a valid scene");
    scene.run.warm_start = is_warm;
    scene
}

/// Runs in time. Additions and bytes of a block are counted in `dynamics/sweep.rs` and `dynamics/space/sweep.rs`.
fn runs(machine: &Machine) {
    // In the plane: 18 additions; two components are read, two read and written.
    let plane = |name, is_single: bool, travel_m| {
        let measured = site_updates_per_second(&scene(None, Extent::Sample, is_single), travel_m);
        let bytes = if is_single { 24.0 } else { 48.0 };
        let held = Held::SecondCache;
        machine.judge(&Kernel { name, unit: "block", is_single, additions: 18.0, bytes, held, measured });
    };
    plane("run in the plane, 996 x 20 blocks, double precision", false, 0.02e-6);
    plane("the same, single precision", true, 0.05e-6);
    // In space: 9 additions for the sums that rows share, 16 for three pairs of diagonals, 2 for straight springs and 14 for
    // three components of the step.
    let squares = published(Planform::Square).expect("valid lengths");
    for (name, is_single, travel_m) in [
        ("run in space, 50 x 50 x 20 blocks, double precision", false, 0.004e-6),
        ("the same in space, single precision", true, 0.02e-6),
    ] {
        let measured = site_updates_per_second(&scene(Some(squares), Extent::Cell, is_single), travel_m);
        let bytes = if is_single { 36.0 } else { 72.0 };
        let held = Held::ThirdCache;
        machine.judge(&Kernel { name, unit: "block", is_single, additions: 41.0, bytes, held, measured });
    }
}

/// Filters of maps: half of a complex transform of radix 4 there and back, 22 additions for four numbers and two levels; each of
/// three passes reads and writes all numbers, and one reads factors.
fn filters(machine: &Machine) {
    for (name, side, is_single, held) in [
        ("filter of 512 x 512 pixels, single precision", 512, true, Held::ThirdCache),
        ("filter of 512 x 512 pixels, double precision", 512, false, Held::ThirdCache),
        ("filter of 4096 x 4096 pixels, single precision", 4096, true, Held::Memory),
    ] {
        let pixels = side * side;
        let measured = if is_single { filtered::<f32>(side) } else { filtered::<f64>(side) };
        let size = if is_single { 4.0 } else { 8.0 };
        let additions = 2.75 * (pixels as f64).log2();
        machine.judge(&Kernel { name, unit: "pixel", is_single, additions, bytes: 6.5 * size, held, measured });
    }
}

/// Pixels filtered a second.
fn filtered<T: slipgrid_base::fft::Precision>(side: usize) -> f64 {
    let fourier: Fourier<T> = Fourier::new(side, side);
    let factor = fourier.multiplier(1.0, 1.0, 1.0, |q| 1.0 / (1.0 + q));
    let input: Vec<T> = (0..side * side).map(|n| T::from_usize(n % 1009).expect("small")).collect();
    let (mut output, mut work) = (input.clone(), fourier.work());
    median(|| {
        let start = Instant::now();
        fourier.filter(black_box(&input), &factor, &mut output, &mut work);
        (side * side) as f64 / start.elapsed().as_secs_f64()
    })
}

/// Whole solves of the contact area. An iteration filters once in single precision and moves 124 bytes a pixel beside: 64 for the
/// preconditioner, 16 for the direction, 24 for the step and 20 for the gap.
fn contact(machine: &Machine) {
    for (name, pixels, held) in [
        ("iteration of the contact solver, 512 x 512 pixels", 512, Held::ThirdCache),
        ("iteration of the contact solver, 2048 x 2048 pixels", 2048, Held::Memory),
    ] {
        let map = SelfAffine { pixels, ..SelfAffine::STAND_IN }.map().expect("a map");
        let points = (pixels * pixels) as f64;
        let measured = median(|| {
            let start = Instant::now();
            let found =
                area_curve(&map, 0.43e9, &[1.3e6], &SolveOptions::default(), &slipgrid_surface::contact::Unwatched);
            let iterations = found.expect("a curve").points[0].convergence.iterations;
            iterations as f64 * points / start.elapsed().as_secs_f64()
        });
        // 80 additions a pixel are three stencils of nine, their sums over blocks, and the vector sums.
        let additions = 2.75 * points.log2() + 80.0;
        machine.judge(&Kernel { name, unit: "pixel", is_single: true, additions, bytes: 150.0, held, measured });
    }
}

/// The condensed cell: additions of its elimination, n^3/3 + n^2 m + n m^2.
fn cells(machine: &Machine) {
    let scene = polymer_scene(None, &[0.65, 1.3, 1.95, 2.6], Fidelity::Steady, Extent::Cell).expect("a valid scene");
    let model = SteadyCell::new(&scene);
    let groove = published_groove().expect("valid lengths");
    // 13 of 50 columns are cavity, two rows deep: five unknowns per covered column and two more, four per row.
    let (n, m) = (5.0 * 15.0 + 4.0 * 2.0, 37.0);
    let additions = n * n * n / 3.0 + n * n * m + n * m * m;
    let designs = vec![groove; 200];
    let measured = median(|| {
        let start = Instant::now();
        black_box(model.ratios_of(&designs));
        designs.len() as f64 / start.elapsed().as_secs_f64()
    });
    let bytes = 8.0 * (n + m) * (n + m);
    let (name, held) = ("steady cell of 50 columns, four loads", Held::SecondCache);
    machine.judge(&Kernel { name, unit: "design", is_single: false, additions, bytes, held, measured });
}

fn main() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    pool.install(|| {
        let machine = Machine::measured();
        machine.print();
        runs(&machine);
        filters(&machine);
        contact(&machine);
        cells(&machine);
    });
}
