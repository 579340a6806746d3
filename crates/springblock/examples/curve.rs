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
    let model = SectionModel::new(&scene(10e-6));
    let at = |w: f64, s: f64, d: f64| model.ratios(&p(w, s, d))[0].unwrap();
    // departure from linear in a over [c, c+1], relative to the step, at pitch fixed
    for (w, pitch) in [(130.0, 500.0), (300.0, 500.0), (60.0, 200.0), (100.0, 150.0)] {
        for d in [9.0, 10.0, 10.2, 10.5, 11.0, 12.0, 14.0, 15.0, 16.0, 18.0, 19.0, 20.0] {
            let (a, b) = (at(w, pitch - w, d), at(w + 10.0, pitch - w - 10.0, d));
            let v: Vec<String> = (0..=10)
                .map(|k| {
                    let k = f64::from(k);
                    format!("{:.3}", (at(w + k, pitch - w - k, d) - a) / (b - a) - k / 10.0)
                })
                .collect();
            println!("{w}/{pitch}/{d} step {:.1e}: {}", b - a, v.join(" "));
        }
    }
}
