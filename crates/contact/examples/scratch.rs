use slipgrid_contact::*;
use slipgrid_topography::{SelfAffine, fourier::Fourier};
use std::time::Instant;
fn main() {
    let e = 0.38e9 / (1.0 - 1.0 / 9.0);
    for n in [256usize, 512, 1024] {
        let f = Fourier::new(n, n);
        let m = f.multiplier(1.0, 1.0, 0.0, |q| 1.0 / q);
        let x = vec![1.0; n * n];
        let mut y = vec![0.0; n * n];
        let mut w = f.work();
        f.filter(&x, &m, &mut y, &mut w);
        let t = Instant::now();
        let reps = 40;
        for _ in 0..reps {
            f.filter(&x, &m, &mut y, &mut w);
        }
        println!("pair {n}: {:.3} ms", t.elapsed().as_secs_f64() * 1e3 / reps as f64);
    }
    let ps: Vec<f64> = [0.1, 0.2, 0.4, 0.7, 1.0, 1.3, 1.6, 2.0, 2.6, 3.3, 4.1, 5.0].iter().map(|p| p * 1e6).collect();
    for n in [256usize, 512] {
        let t = Instant::now();
        let map = SelfAffine { pixels: n, max_wave: n as u32 / 8, ..SelfAffine::STAND_IN }.map().unwrap();
        println!("map {:.3} s", t.elapsed().as_secs_f64());
        let t = Instant::now();
        let c = area_curve(&map, e, &ps, &SolveOptions::default(), &Unwatched).unwrap();
        let dt = t.elapsed().as_secs_f64();
        let (mut it, mut fp) = (0, 0);
        for p in &c.points {
            it += p.convergence.iterations;
            fp += p.convergence.fourier_pairs;
            println!("{} {:.6} {:.6} {:?}", p.pressure_pa, p.area_fraction, p.area_fraction_corrected, p.convergence);
        }
        println!("{n}: {dt:.2} s its {it} pairs {fp}");
    }
}
