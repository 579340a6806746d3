use slipgrid_contact::*;
use slipgrid_topography::*;
fn main() {
    let mut s: u64 = 7;
    let mut rnd = || {
        s = s.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (s >> 11) as f64 / (1u64 << 53) as f64
    };
    let (mut worst, mut total, mut bad) = (0, 0, 0);
    for case in 0..60 {
        let rows = 16 + (rnd() * 150.0) as usize;
        let cols = 16 + (rnd() * 150.0) as usize;
        let kind = case % 4;
        let base = SelfAffine {
            pixels: 256,
            max_wave: 100,
            hurst: 0.1 + 0.9 * rnd(),
            min_wave: 1,
            seed: case,
            ..SelfAffine::STAND_IN
        }
        .map()
        .unwrap();
        let h: Vec<f64> = (0..rows * cols)
            .map(|n| match kind {
                0 => base.heights_m()[n / cols * 256 + n % cols],
                1 => rnd() * 1e-7,
                2 => {
                    if rnd() < 0.02 {
                        1e-6 * rnd()
                    } else {
                        0.0
                    }
                }
                _ => (base.heights_m()[n / cols * 256 + n % cols] * 1e8).floor() * 1e-8,
            })
            .collect();
        let map = HeightMap::new(rows, cols, 4e-6, 4e-6 * (0.2 + 4.0 * rnd()), h).unwrap();
        let c = RoughContact::new(&map, 427.5e6).unwrap();
        let full = c.full_contact_pressure_pa();
        for f in [1e-6, 1e-4, 1e-3, 1e-2, 0.05, 0.2, 0.5, 0.8, 0.95, 0.999] {
            let r = c.solve(f * full, &SolveOptions::default(), &Unwatched).unwrap();
            let k = r.convergence;
            total += k.iterations;
            if k.iterations > worst {
                worst = k.iterations;
                println!("kind {kind} {rows}x{cols} f {f} {k:?} A {}", r.area.fraction);
            }
            if k.status != Status::Converged {
                bad += 1;
                println!("BAD kind {kind} {rows}x{cols} f {f} {k:?}");
            }
        }
    }
    println!("total {total} bad {bad} of 600 worst {worst}");
}
