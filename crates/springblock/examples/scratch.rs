use slipgrid_material::{AreaLaw, Elastic, LocalFriction};
use slipgrid_pattern::{Pattern, Planform};
use slipgrid_springblock::*;
fn scene(block: f64) -> Scene {
    let pressure_pa: Vec<f64> = (1..=200).map(|s| 0.1e6 * f64::from(s)).collect();
    let area: Vec<f64> = pressure_pa.iter().map(|p| libm::erf(2.0_f64.sqrt() * p / 4e6)).collect();
    let law = AreaLaw::from_area_curve(&pressure_pa, &area, 0.7e6).unwrap();
    let friction = LocalFriction::new(0.30, 0.27, 0.05).unwrap();
    Scene {
        elastic: Elastic::new(0.38e9, 900.0).unwrap(),
        area_law: Some(law),
        pattern: None,
        layer: Layer { length_m: 9960e-6, height_m: 200e-6, block_m: block },
        loads: vec![Load { pressure_pa: 2.6e6, friction }],
        speed_m_s: 2e-3,
        run: RunOptions::default(),
    }
}
fn p(w: f64, s: f64, d: f64) -> Pattern {
    Pattern::new(Planform::Groove, w * 1e-6, s * 1e-6, d * 1e-6).unwrap()
}
fn main() {
    let count: usize = std::env::args().nth(1).unwrap().parse().unwrap();
    let (plane, space) = (SectionModel::new(&scene(10e-6)), SolidModel::new(&scene(10e-6)));
    let mut seed = 12345u64;
    let mut rnd = || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 11) as f64 / (1u64 << 53) as f64
    };
    let lg = |a: f64, b: f64, u: f64| (a.ln() + (b / a).ln() * u).exp();
    let mut all: Vec<Vec<Vec<f64>>> = vec![vec![Vec::new(); 3]; 2];
    for _ in 0..count {
        let (w, s, d) = (lg(40.0, 400.0, rnd()), lg(40.0, 1000.0, rnd()), lg(2.0, 50.0, rnd()));
        for axis in 0..3 {
            for (which, out) in all.iter_mut().enumerate() {
                let at = |k: f64| {
                    let x = [(w, s, d), (w, s, d), (w, s, d)][0];
                    let q = match axis {
                        0 => p(x.0 + k, x.1, x.2),
                        1 => p(x.0, x.1 + k, x.2),
                        _ => p(x.0, x.1, x.2 + k),
                    };
                    if which == 0 { plane.ratios(&q)[0].unwrap() } else { space.ratios(&q)[0].unwrap() }
                };
                let v: Vec<f64> = (0..=10).map(|k| at(f64::from(k))).collect();
                let mean = (v[10] - v[0]) / 10.0;
                let worst = v.windows(2).map(|x| (x[1] - x[0] - mean).abs()).fold(0.0, f64::max);
                out[axis].push(worst);
            }
        }
    }
    for (name, out) in ["plane fitted", "stretched"].iter().zip(&mut all) {
        for axis in 0..3 {
            out[axis].sort_by(f64::total_cmp);
            let n = out[axis].len();
            println!(
                "{name} axis {axis}: median {:.1e} 90% {:.1e} max {:.1e}",
                out[axis][n / 2],
                out[axis][n * 9 / 10],
                out[axis][n - 1]
            );
        }
    }
    for (w, s, d) in
        [(50.0, 40.0, 10.0), (40.0, 40.0, 5.0), (130.0, 370.0, 20.0), (300.0, 60.0, 30.0), (115.0, 370.0, 20.0)]
    {
        for axis in 0..3 {
            let mut line = format!("{w}/{s}/{d} axis {axis}:");
            for which in 0..2 {
                let at = |k: f64| {
                    let q = match axis {
                        0 => p(w + k, s, d),
                        1 => p(w, s + k, d),
                        _ => p(w, s, d + k),
                    };
                    if which == 0 { plane.ratios(&q)[0].unwrap() } else { space.ratios(&q)[0].unwrap() }
                };
                let v: Vec<f64> = (0..=20).map(|k| at(f64::from(k))).collect();
                let mean = (v[20] - v[0]) / 20.0;
                let worst = v.windows(2).map(|x| (x[1] - x[0] - mean).abs()).fold(0.0, f64::max);
                let against = v.windows(2).any(|x| (x[1] - x[0]) * mean < 0.0);
                line += &format!(" {worst:.1e} {against} mean {mean:.1e}");
            }
            println!("{line}");
        }
    }
}
