//! Correction of friction for runs without the excess of dynamic over steady friction, or with an excess other than in
//! the calibration.
//!
//! A calibration fits the local coefficient mu_d to measured friction: mu_flat = delta mu_d f(P), where f(P) is the
//! area factor at the nominal pressure P, and delta, one to two per cent above 1, is friction of the flat sample in a
//! dynamic run over that of an infinite sample in steady sliding. A steady run gives mu_d f(P), reduced by the effect
//! of the specimen's ends for a whole sample. The excess of a dynamic run differs in space, and with another layer,
//! other blocks or another seed than in the calibration. In each case friction is multiplied by the factor that brings
//! the flat surface, solved together with the patterned one, to delta mu_d f(P). Ratios do not change.

use slipgrid_model::springblock::{Fidelity, LoadOutcome, Scene, Simulation, SurfaceOutcome};

/// Multiplies the friction of `simulation`, the result of `scene`, so that the flat surface has `excess` times its
/// steady friction at each load. `excess` is the ratio of dynamic to steady friction at each load; nothing is changed
/// if `excess` is `None` or has not one entry per load.
pub fn correct(simulation: &mut Simulation, scene: &Scene, excess: Option<&[f64]>) {
    let Some(excess) = excess.filter(|excess| excess.len() == simulation.loads.len()) else { return };
    let is_steady = scene.run.fidelity == Fidelity::Steady;
    let is_calibrated = !is_steady && scene.dimension().takes_strips();
    let (mut factors, mut of_time, mut of_ends) = (Vec::new(), Vec::new(), Vec::new());
    for ((outcome, load), excess) in simulation.loads.iter_mut().zip(&scene.loads).zip(excess) {
        let steady = load.flat_mu(scene.area_law.as_ref());
        let own = outcome.flat.as_ref().unwrap_or(&outcome.surface).mu_dynamic.filter(|mu| *mu > 0.0);
        if let Some(times) = own.map(|own| excess * steady / own) {
            scale(outcome, times);
            factors.push(times);
            of_time.push(*excess);
            of_ends.push(times / excess);
        }
    }
    if factors.is_empty() {
        return;
    }
    if is_calibrated && factors.iter().all(|times| (times - 1.0).abs() < OTHER_LAYER) {
        // The excess is that of the calibration, except for interpolation between the loads of the calibration.
        return;
    }
    let (factor, time, ends) = (range(&factors), range(&of_time), range(&of_ends));
    let in_time = "by which the calibration's flat sample has more friction in time than in steady sliding";
    simulation.statements.model(if is_calibrated {
        format!("dynamic friction: times {factor}, so that the flat sample has the calibrated friction; the calibration used another layer, other blocks or another seed")
    } else if !is_steady {
        format!("dynamic friction: times {factor}, so that the flat surface has the calibrated friction; in space friction in time exceeds steady sliding by another factor than in the plane")
    } else if of_ends.iter().all(|times| (times - 1.0).abs() < ROUNDING) {
        format!("dynamic friction: steady friction times {factor}, {in_time}; stresses are the steady ones")
    } else {
        format!("dynamic friction: steady friction times {factor}, which is {time}, {in_time}, times {ends}, steady friction of an endless flat layer, mu_d f(P), over that of this flat sample with its ends and the tilt of its pressure; stresses are the steady ones")
    });
}

/// Minimum difference of the correction factor from 1 that is reported for a dynamic run in the plane; the excess of
/// such a run is usually that of the calibration.
const OTHER_LAYER: f64 = 1e-3;
/// Factors that differ by less are equal when printed with four decimals.
const ROUNDING: f64 = 5e-5;

/// Formats the range of `factors` with four decimals, or one number if all are equal.
fn range(factors: &[f64]) -> String {
    let least = factors.iter().copied().fold(f64::INFINITY, f64::min);
    let most = factors.iter().copied().fold(0.0, f64::max);
    if (most - least).abs() < ROUNDING { format!("{most:.4}") } else { format!("{least:.4} to {most:.4}") }
}

fn scale(outcome: &mut LoadOutcome, times: f64) {
    let of = |surface: &mut SurfaceOutcome| {
        for value in [&mut surface.mu_dynamic, &mut surface.mu_dynamic_stderr, &mut surface.mu_across] {
            *value = value.map(|value| value * times);
        }
    };
    of(&mut outcome.surface);
    outcome.flat.iter_mut().for_each(of);
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_model::material::{AreaLaw, Elastic, LocalFriction};
    use slipgrid_model::pattern::{Pattern, Planform};
    use slipgrid_model::springblock::{Extent, Layer, Load, RunOptions, Unwatched, simulate};

    #[test]
    fn the_flat_surface_has_the_calibrated_friction_in_the_plane_and_in_space() {
        let friction = LocalFriction::new(0.30, 0.27, 0.05).unwrap();
        let scene = |planform: Planform, fidelity: Fidelity| Scene {
            elastic: Elastic::new(0.38e9, 900.0).unwrap(),
            area_law: Some(AreaLaw::new(vec![0.7e6, 2.6e6, 10e6], vec![1.0, 0.8, 0.3]).unwrap()),
            pattern: Some(Pattern::new(planform, 60e-6, 60e-6, 20e-6).unwrap()),
            relief: None,
            layer: Layer { length_m: 120e-6, height_m: 40e-6, block_m: 10e-6, thickness_m: None, holder: None },
            loads: vec![Load { pressure_pa: 2e6, friction }],
            speed_m_s: 2e-3,
            run: RunOptions {
                fidelity,
                extent: Extent::Cell,
                sliding_m: 0.2e-6,
                warm_start: true,
                ..RunOptions::default()
            },
        };
        let calibrated = 1.015 * 0.27 * scene(Planform::Groove, Fidelity::Steady).area_law.unwrap().factor(2e6);
        for (planform, fidelity) in [
            (Planform::Groove, Fidelity::Steady),
            (Planform::Square, Fidelity::Steady),
            (Planform::Square, Fidelity::Dynamic),
        ] {
            let scene = scene(planform, fidelity);
            let plain = simulate(&scene, &Unwatched).unwrap();
            let mut found = plain.clone();
            correct(&mut found, &scene, Some(&[1.015]));
            let (before, after) = (&plain.loads[0], &found.loads[0]);
            let flat = after.flat.as_ref().unwrap().mu_dynamic.unwrap();
            assert!((flat / calibrated - 1.0).abs() < 1e-9, "{planform} {flat} {calibrated}");
            let times = after.surface.mu_dynamic.unwrap() / before.surface.mu_dynamic.unwrap();
            let of_flat = flat / before.flat.as_ref().unwrap().mu_dynamic.unwrap();
            assert!((times / of_flat - 1.0).abs() < 1e-12 && after.ratio() == before.ratio());
            assert_eq!(found.statements.model.len(), plain.statements.model.len() + 1);
            let of_time = "times 1.0150, by which the calibration's flat sample has more friction in time than in steady sliding; ";
            assert_eq!(
                found.statements.model.last().unwrap().contains(of_time),
                fidelity == Fidelity::Steady,
                "{:?}",
                found.statements
            );
            let mut unknown = plain.clone();
            correct(&mut unknown, &scene, None);
            assert_eq!(unknown, plain);
        }
        // The ends of a whole sample also reduce friction, which is not an effect of time.
        let sample = scene(Planform::Groove, Fidelity::Steady);
        let sample = Scene { run: RunOptions { extent: Extent::Sample, ..sample.run }, ..sample };
        let mut found = simulate(&sample, &Unwatched).unwrap();
        let steady_mu = 0.27 * sample.area_law.as_ref().unwrap().factor(2e6);
        let ends = steady_mu / found.loads[0].flat.as_ref().unwrap().mu_dynamic.unwrap();
        correct(&mut found, &sample, Some(&[1.015]));
        let says = format!(
            "steady friction times {:.4}, which is 1.0150, by which the calibration's flat sample has more friction in time than in steady \
             sliding, times {ends:.4}, steady friction of an endless flat layer",
            1.015 * ends
        );
        assert!(
            (ends - 1.0).abs() > 1e-3 && found.statements.model.last().unwrap().contains(&says),
            "{ends} {:?}",
            found.statements
        );
        // In the plane, runs in time have the calibrated excess if only the pattern differs.
        let scene = scene(Planform::Groove, Fidelity::Dynamic);
        let plain = simulate(&scene, &Unwatched).unwrap();
        let own = plain.loads[0].flat.as_ref().unwrap().mu_dynamic.unwrap();
        let steady = scene.loads[0].flat_mu(scene.area_law.as_ref());
        for (times, is_told) in [(1.0002, false), (1.01, true)] {
            let mut found = plain.clone();
            correct(&mut found, &scene, Some(&[times * own / steady]));
            let (before, after) = (&plain.loads[0], &found.loads[0]);
            assert!((after.surface.mu_dynamic.unwrap() / before.surface.mu_dynamic.unwrap() - times).abs() < 1e-12);
            assert_eq!(after.ratio(), before.ratio());
            let said = found.statements.model.last().unwrap();
            assert_eq!(said.contains("so that the flat sample has the calibrated friction"), is_told, "{said}");
        }
    }
}
