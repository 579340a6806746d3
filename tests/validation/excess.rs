//! How far dynamic friction of the flat surface lies above steady sliding, against what it depends on.

use slipgrid_material::LocalFriction;
use slipgrid_springblock::{Extent, Fidelity, Scene, Unwatched, simulate};
use slipgrid_tests::polymer_scene;

/// Dynamic over steady friction less one, and its standard error.
fn excess(change: impl Fn(&mut Scene)) -> (f64, f64) {
    let mut scene = polymer_scene(None, &[1.3], Fidelity::Steady, Extent::Sample).unwrap();
    change(&mut scene);
    let steady = simulate(&scene, &Unwatched).unwrap().loads[0].surface.mu_dynamic.unwrap();
    scene.run.fidelity = Fidelity::Dynamic;
    scene.run.warm_start = true;
    scene.run.sliding_m = 0.4e-6;
    let dynamic = &simulate(&scene, &Unwatched).unwrap().loads[0].surface;
    (dynamic.mu_dynamic.unwrap() / steady - 1.0, dynamic.mu_dynamic_stderr.unwrap() / steady)
}

#[test]
#[ignore = "two minutes: prints the table of the README"]
fn excess_of_dynamic_friction_against_step_damping_and_static_friction() {
    let row = |what: &str, (excess, error): (f64, f64)| {
        println!("| {what} | {:.2} +- {:.2} % |", 100.0 * excess, 100.0 * error);
        excess
    };
    let default = row("defaults: 4 ns, gamma = 0.01 sqrt(k/m), mu_s/mu_d = 1.11, 2 mm/s", excess(|_| {}));
    for step_ns in [1.0, 2.0, 8.0, 11.0] {
        let found = row(&format!("step {step_ns} ns"), excess(|scene| scene.run.step_s = Some(step_ns * 1e-9)));
        // Steps up to the default one change friction by less than 0.1 %.
        assert!(step_ns > 4.0 || (found - default).abs() < 1e-3);
    }
    let damping = [0.003, 0.03, 0.1]
        .map(|damping| row(&format!("gamma = {damping} sqrt(k/m)"), excess(|scene| scene.run.damping = damping)));
    assert!(damping[0] < damping[2], "more damping, more friction");
    let ratio = [1.0, 1.05, 1.2, 1.4].map(|ratio| {
        row(
            &format!("mu_s/mu_d = {ratio}"),
            excess(|scene| {
                scene.loads[0].friction = LocalFriction::new(0.27 * ratio, 0.27, 0.05).unwrap();
            }),
        )
    });
    assert!(ratio[0] < ratio[3], "more static friction, more stick-slip");
    for speed_mm_s in [0.4, 4.0] {
        row(&format!("{speed_mm_s} mm/s"), excess(|scene| scene.speed_m_s = speed_mm_s * 1e-3));
    }
}
