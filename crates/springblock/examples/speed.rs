use slipgrid_material::{AreaLaw, Elastic, LocalFriction};
use slipgrid_pattern::{Pattern, Planform};
use slipgrid_springblock::*;
fn scene() -> Scene {
    let pressure_pa: Vec<f64> = (1..=200).map(|s| 0.1e6 * f64::from(s)).collect();
    let area: Vec<f64> = pressure_pa.iter().map(|p| libm::erf(2.0_f64.sqrt() * p / 4e6)).collect();
    let law = AreaLaw::from_area_curve(&pressure_pa, &area, 0.7e6).unwrap();
    let friction = LocalFriction::new(0.30, 0.27, 0.05).unwrap();
    Scene {
        elastic: Elastic::new(0.38e9, 900.0).unwrap(),
        area_law: Some(law),
        pattern: None,
        layer: Layer { length_m: 9960e-6, height_m: 200e-6, block_m: 10e-6 },
        loads: [0.65e6, 1.3e6, 1.95e6, 2.6e6].map(|pressure_pa| Load { pressure_pa, friction }).to_vec(),
        speed_m_s: 2e-3,
        run: RunOptions::default(),
    }
}
fn p(w: f64, s: f64, d: f64) -> Pattern {
    Pattern::new(Planform::Groove, w * 1e-6, s * 1e-6, d * 1e-6).unwrap()
}
fn main() {
    let count: usize = std::env::args().nth(1).unwrap().parse().unwrap();
    let which = std::env::args().nth(2).unwrap();
    let mut seed = 12345u64;
    let mut rnd = || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 11) as f64 / (1u64 << 53) as f64
    };
    let model = SectionModel::new(&scene());
    let patterns: Vec<Pattern> = (0..count)
        .map(|_| {
            let w = 60.0 + 250.0 * rnd();
            let pitch = 496.0 + 8.0 * rnd();
            let d = 2.0 + 28.0 * rnd();
            if which.contains("wide") {
                let u = rnd();
                p(40.0 + 360.0 * u, 40.0 + 960.0 * rnd(), 2.0 + 48.0 * rnd())
            } else {
                p(w, pitch - w, d)
            }
        })
        .collect();
    let mut best = f64::INFINITY;
    let mut worst = 0.0f64;
    for batch in patterns.chunks(20) {
        let start = std::time::Instant::now();
        for q in batch {
            if which.contains("plain") {
                std::hint::black_box(model.solve_all_blocks(q));
            } else {
                std::hint::black_box(model.solve(q));
            }
        }
        best = best.min(start.elapsed().as_secs_f64() / batch.len() as f64);
    }
    if which.contains("check") {
        for q in &patterns {
            let (a, b) = (model.solve(q), model.solve_all_blocks(q));
            for (a, b) in a.iter().zip(&b) {
                worst = worst.max((a.ratio.unwrap() - b.ratio.unwrap()).abs());
            }
        }
    }
    println!("best batch {:.1} us a design; worst difference {worst:e}", best * 1e6);
}
