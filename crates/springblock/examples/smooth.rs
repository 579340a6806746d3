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
        loads: vec![Load { pressure_pa: 2.6e6, friction }],
        speed_m_s: 2e-3,
        run: RunOptions::default(),
    }
}
fn p(w: f64, s: f64, d: f64) -> Pattern {
    Pattern::new(Planform::Groove, w * 1e-6, s * 1e-6, d * 1e-6).unwrap()
}
/// residual steps beyond a cubic in t
fn rough(v: &[f64]) -> f64 {
    let n = v.len();
    let k = 4;
    let t: Vec<f64> = (0..n).map(|i| 2.0 * i as f64 / (n - 1) as f64 - 1.0).collect();
    let mut a = vec![vec![0.0; k + 1]; k];
    for r in 0..k {
        for c in 0..k {
            a[r][c] = t.iter().map(|x| x.powi((r + c) as i32)).sum();
        }
        a[r][k] = t.iter().zip(v).map(|(x, y)| y * x.powi(r as i32)).sum();
    }
    for i in 0..k {
        for r in i + 1..k {
            let f = a[r][i] / a[i][i];
            for c in i..=k {
                a[r][c] -= f * a[i][c];
            }
        }
    }
    let mut co = vec![0.0; k];
    for i in (0..k).rev() {
        co[i] = (a[i][k] - (i + 1..k).map(|c| a[i][c] * co[c]).sum::<f64>()) / a[i][i];
    }
    let res: Vec<f64> =
        t.iter().zip(v).map(|(x, y)| y - (0..k).map(|i| co[i] * x.powi(i as i32)).sum::<f64>()).collect();
    res.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max)
}
fn main() {
    let count: usize = std::env::args().nth(1).unwrap().parse().unwrap();
    let model = SectionModel::new(&scene());
    let mut seed = 12345u64;
    let mut rnd = || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 11) as f64 / (1u64 << 53) as f64
    };
    let lg = |a: f64, b: f64, u: f64| (a.ln() + (b / a).ln() * u).exp();
    let at = |w: f64, s: f64, d: f64| model.ratios(&p(w, s, d))[0].unwrap();
    for (name, lo, hi, dl, dh) in
        [("all", 40.0, 400.0, 2.0, 50.0), ("shallow", 60.0, 400.0, 2.0, 9.0), ("usual", 100.0, 400.0, 10.0, 40.0)]
    {
        let mut out = vec![Vec::new(); 3];
        for _ in 0..count {
            let (w, s, d) = (lg(lo, hi, rnd()), lg(lo, 1000.0, rnd()), lg(dl, dh, rnd()));
            for axis in 0..3 {
                let v: Vec<f64> = (0..=20)
                    .map(|k| {
                        let k = f64::from(k);
                        match axis {
                            0 => at(w + k, s, d),
                            1 => at(w, s + k, d),
                            _ => at(w, s, d + k * 0.5),
                        }
                    })
                    .collect();
                out[axis].push(rough(&v));
                if name == "usual" && axis < 2 && rough(&v) > 3e-4 {
                    println!(
                        "{w:.1} {s:.1} {d:.1} axis {axis} {:.1e} steps {:.2?}",
                        rough(&v),
                        v.windows(2).map(|x| (x[1] - x[0]) * 1e3).collect::<Vec<_>>()
                    );
                }
            }
        }
        for (axis, out) in out.iter_mut().enumerate() {
            out.sort_by(f64::total_cmp);
            let n = out.len();
            print!(
                "{name} {}: med {:.1e} 90% {:.1e} max {:.1e}; ",
                ["w", "s", "d"][axis],
                out[n / 2],
                out[n * 9 / 10],
                out[n - 1]
            );
        }
        println!();
    }
}
