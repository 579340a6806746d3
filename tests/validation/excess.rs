//! How far dynamic friction of the flat surface lies above steady sliding, and the ratio of the published
//! pattern to it, against what they depend on.

use slipgrid_material::LocalFriction;
use slipgrid_springblock::{Extent, Fidelity, Layer, Scene, Unwatched, simulate};
use slipgrid_tests::{polymer_scene, published_groove};

/// A number and its standard error.
type Measured = (f64, f64);

/// Dynamic over steady friction of the flat sample less one, and the ratio patterned over flat.
fn excess_and_ratio(change: impl Fn(&mut Scene)) -> [Measured; 2] {
    let pattern = Some(published_groove().unwrap());
    let mut scene = polymer_scene(pattern, &[1.3], Fidelity::Steady, Extent::Sample).unwrap();
    scene.layer = Layer { length_m: 4980e-6, ..scene.layer };
    change(&mut scene);
    let steady = simulate(&scene, &Unwatched).unwrap().loads.remove(0).flat.unwrap().mu_dynamic.unwrap();
    scene.run.fidelity = Fidelity::Dynamic;
    scene.run.warm_start = true;
    scene.run.sliding_m = 1e-6;
    let dynamic = simulate(&scene, &Unwatched).unwrap().loads.remove(0);
    let flat = dynamic.flat.unwrap();
    [
        (flat.mu_dynamic.unwrap() / steady - 1.0, flat.mu_dynamic_stderr.unwrap() / steady),
        (dynamic.ratio.unwrap(), dynamic.ratio_stderr.unwrap()),
    ]
}

#[test]
#[ignore = "two minutes: prints the table of tests/README.md"]
fn excess_of_dynamic_friction_against_step_damping_and_static_friction() {
    println!(
        "| choice | flat sample: dynamic over steady friction, less one | ratio patterned over flat |\n|---|---|---|"
    );
    let mut ratios: Vec<Measured> = Vec::new();
    let mut row = |what: &str, [(excess, error), ratio]: [Measured; 2]| {
        let percent = [excess, error].map(|value| 100.0 * value);
        println!("| {what} | {:.2} +- {:.2} % | {:.4} +- {:.4} |", percent[0], percent[1], ratio.0, ratio.1);
        ratios.push(ratio);
        excess
    };
    let default = row("defaults: 4 ns, gamma = 0.01 sqrt(k/m), mu_s/mu_d = 1.11, 2 mm/s", excess_and_ratio(|_| {}));
    for step_ns in [1.0, 2.0, 6.0, 8.0, 10.0, 11.0] {
        let found =
            row(&format!("step {step_ns} ns"), excess_and_ratio(|scene| scene.run.step_s = Some(step_ns * 1e-9)));
        // Steps up to the default one change friction by less than 0.1 %.
        assert!(step_ns > 4.0 || (found - default).abs() < 1e-3);
    }
    let damping = [0.003, 0.03, 0.1].map(|damping| {
        row(&format!("gamma = {damping} sqrt(k/m)"), excess_and_ratio(|scene| scene.run.damping = damping))
    });
    assert!(damping[0] < damping[2], "more damping, more friction");
    let ratio = [1.0, 1.05, 1.2, 1.4].map(|ratio| {
        row(
            &format!("mu_s/mu_d = {ratio}"),
            excess_and_ratio(|scene| {
                scene.loads[0].friction = LocalFriction::new(0.27 * ratio, 0.27, 0.05).unwrap();
            }),
        )
    });
    assert!(ratio[0] < ratio[3], "more static friction, more stick-slip");
    for speed_mm_s in [0.4, 4.0] {
        row(&format!("{speed_mm_s} mm/s"), excess_and_ratio(|scene| scene.speed_m_s = speed_mm_s * 1e-3));
    }
    // The ratio hardly depends on any of them: 0.5 % and three standard errors.
    for (ratio, error) in &ratios {
        assert!((ratio - ratios[0].0).abs() < 5e-3 + 3.0 * error.hypot(ratios[0].1), "{ratio} {error}");
    }
}
