//! Chances of the mixture, by points, by draws and by truths.

use super::*;

/// Features of a groove with a width larger by a twentieth, at equal pitch.
fn wider(of: Features) -> Features {
    Features { areal_density: 1.05 * of.areal_density, width_m: 1.05 * of.width_m, ..of }
}

#[test]
fn scenarios_are_on_target_as_often_as_the_chance_says() {
    let at = loads();
    let trials = vec![trial("", groove(100.0, 300.0, 10.0), &at, 0.01, &mut |_| -0.1)];
    let known = discrepancy(trials);
    let scenarios = Scenarios::new(&known, 4000, 1);
    // Half of the variance from the dimensions of each sample, half shared by all.
    let all: Vec<f64> = (0..16).map(|e| if e % 5 == 0 { 1e-4 } else { 0.5e-4 }).collect();
    for texture in [groove(100.0, 300.0, 10.0), groove(60.0, 300.0, 20.0), groove(200.0, 100.0, 5.0)] {
        let candidate = Candidate {
            features: texture,
            modelled: &[0.98, 0.96, 0.95, 0.94],
            sensitivity: &moduli([0.02, 0.04, 0.06, 0.08]),
            covariance: &all,
            dimension_shifts: &[DimensionShift { log_ratio: vec![0.01; 4], above: wider(texture), below: None }],
        };
        let wanted = Wanted { lower: vec![0.82; 4], upper: vec![0.9; 4] };
        let chance = wanted.score(&known.at(&at).of(&candidate), candidate.modelled).chance;
        let share = scenarios.on_target(&candidate, &at, &wanted, 0).iter().filter(|on| **on).count() as f64 / 4000.0;
        // Standard error of at most 0.008, and the error of the integral.
        assert!((chance - share).abs() < 0.03, "{chance} {share}");
    }
}

/// Tests the chance that one of three equal samples is on target, with shared and individual errors, against the integral
/// over the shared errors.
#[test]
fn one_of_several_samples_is_on_target_as_often_as_they_differ() {
    let exact = Hyperparameters { sample_std: 1e-9, amplitude_std: 1e-9, ..amplitude_alone() };
    let known = learned_exactly(exact, Vec::new());
    let (scenarios, at) = (Scenarios::new(&known, 8000, 1), [load(1.3, 2.0, 40.0)]);
    let half = 0.0115_f64;
    let wanted = Wanted { lower: vec![0.9 * (-half).exp()], upper: vec![0.9 * half.exp()] };
    for [common, own] in [[0.005_f64, 0.02_f64], [0.01, 0.03], [0.02, 0.02]] {
        let (shared, features) = ([common.powi(2)], groove(100.0, 300.0, 10.0));
        let candidate = Candidate {
            features,
            modelled: &[0.9],
            sensitivity: &moduli([0.0]),
            covariance: &shared,
            dimension_shifts: &[physics_alone(features, vec![own])],
        };
        let each = [0, 1, 2].map(|number| scenarios.on_target(&candidate, &at, &wanted, number));
        let share = (0..8000).filter(|&draw| each.iter().any(|on| on[draw])).count() as f64 / 8000.0;
        let by_integral: f64 = (0..4000_u32)
            .map(|k| {
                let c = common * normal_quantile((f64::from(k) + 0.5) / 4000.0);
                let one = normal_probability((half - c) / own) - normal_probability((-half - c) / own);
                (1.0_f64 - (1.0 - one).powi(3)) / 4000.0
            })
            .sum();
        assert!((share - by_integral).abs() < 0.02, "{common} {own}: {share} {by_integral}");
    }
}

#[test]
fn samples_on_one_disc_are_off_together() {
    // The model error is almost known: the scatter of the disc remains.
    let hyper = Hyperparameters { sample_std: 0.02, amplitude_std: 1e-6, ..amplitude_alone() };
    let known = learned_exactly(hyper, Vec::new());
    let (at, textures) = ([load(1.3, 2.0, 40.0)], [groove(100.0, 300.0, 10.0), groove(60.0, 300.0, 20.0)]);
    let wanted = Wanted { lower: vec![0.9 * (-0.02_f64).exp()], upper: vec![0.9 * 0.02_f64.exp()] };
    let scenarios = Scenarios::new(&known, 4000, 1);
    let on = |of: &Scenarios, features: Features, number: usize| {
        let (modelled, sensitivity) = (&[0.9], &moduli([0.0]));
        let candidate = Candidate { features, modelled, sensitivity, covariance: &[], dimension_shifts: &[] };
        of.on_target(&candidate, &at, &wanted, number)
    };
    let share = |on: &[bool]| on.iter().filter(|on| **on).count() as f64 / 4000.0;
    let both =
        |one: &[bool], other: &[bool]| one.iter().zip(other).map(|(one, other)| *one && *other).collect::<Vec<_>>();
    // Each within one standard deviation, independently.
    let apart = [0, 1].map(|number| on(&scenarios, textures[number], number));
    let together = share(&both(&apart[0], &apart[1]));
    assert!((together - 0.683 * 0.683).abs() < 0.025, "{together}");
    let disc = scenarios.on_one_disc(2);
    let [one, other] = [0, 1].map(|number| on(&disc, textures[number], number));
    // Within one standard deviation, both or neither.
    let share = one.iter().filter(|on| **on).count() as f64 / 4000.0;
    assert!((share - 0.683).abs() < 0.025, "{share}");
    assert!(one.iter().zip(&other).filter(|(one, other)| one != other).count() < 10);
}

/// Tests six correlated loads, as two speeds at three pressures: the chance of all loads never exceeds the chance of
/// some, by the rule and by draws.
#[test]
fn more_loads_are_never_likelier_within_their_bounds_than_fewer() {
    let both: Vec<Load> =
        [2.0, 5.0].into_iter().flat_map(|speed| [2.0, 4.0, 8.0].map(|pressure| load(pressure, speed, 45.0))).collect();
    let trials = vec![trial("A", groove(113.0, 287.0, 14.0), &both, 0.01, &mut |_| -0.03)];
    let known = discrepancy(trials);
    for width_um in [150.0, 170.0, 190.0, 191.0, 192.0, 193.7, 195.0, 197.0] {
        let found = |loads: &[Load]| {
            let n = loads.len();
            let prediction =
                known.at(loads).predict(&groove(width_um, 278.3, 29.45), &vec![Sensitivity::of_modulus(0.1); n]);
            let wanted = Wanted { lower: vec![(-0.06_f64).exp(); n], upper: vec![0.02_f64.exp(); n] };
            let mut normals = Normals::new(1);
            let draws = 20_000;
            let within = (0..draws).filter(|_| {
                let which = normals.draw();
                let z: Vec<f64> = (0..n).map(|_| normals.draw()).collect();
                prediction.draw(which, &z).iter().all(|y| (-0.06..=0.02).contains(y))
            });
            let drawn = within.count() as f64 / f64::from(draws);
            let share = wanted.score(&prediction, &vec![1.0; n]).chance;
            // Error of the draws: 0.0035, and the error of the rule.
            assert!((share - drawn).abs() < 0.012, "{width_um} {n}: {share} {drawn}");
            share
        };
        let (all, slow, fast) = (found(&both), found(&both[..3]), found(&both[3..]));
        assert!(all <= slow.min(fast) + 0.01, "{width_um}: {all} {slow} {fast}");
    }
}

/// Compares chances of the mixture with the integral of each component on many points, from narrow to wide bands, before
/// trials and after one.
#[test]
fn points_shared_by_all_components_leave_little_of_a_chance_open() {
    let after = discrepancy(vec![trial("A", groove(100.0, 300.0, 10.0), &loads(), 0.01, &mut |_| -0.1)]);
    let both: Vec<Load> =
        [2.0, 5.0].into_iter().flat_map(|speed| [2.0, 4.0, 8.0].map(|pressure| load(pressure, speed, 45.0))).collect();
    for (known, loads) in [(discrepancy(vec![]), loads().to_vec()), (after.clone(), loads().to_vec()), (after, both)] {
        let (n, predictor) = (loads.len(), known.at(&loads));
        let (mut exact, mut rough, mut count) = (0.0, 0.0, 0.0);
        for width_um in [40.0, 110.0, 300.0] {
            for half in [0.02, 0.05, 0.1] {
                let prediction =
                    predictor.predict(&groove(width_um, 300.0, 10.0), &vec![Sensitivity::of_modulus(0.1); n]);
                let modelled: Vec<f64> = (0..n).map(|load| 0.95 - 0.02 * load as f64).collect();
                let wanted = Wanted { lower: vec![0.87 - half; n], upper: vec![0.87 + half; n] };
                let [lower, upper] = wanted.over(&modelled);
                let rule = BoxRule::new(n);
                let part = |of: &Component| {
                    let factor = covariance_factor(&of.covariance, n);
                    of.weight * rule.probability(&of.mean, &factor, [&lower, &upper], 0..1 << 11)
                };
                let integral: f64 = prediction.components.iter().map(part).sum();
                let off = |score: Score| score.chance - integral;
                exact += off(wanted.score(&prediction, &modelled)).powi(2);
                rough += off(wanted.rough_score(&prediction, &modelled)).powi(2);
                count += 1.0;
            }
        }
        let [exact, rough] = [exact / count, rough / count].map(f64::sqrt);
        // 0.0001 and 0.0011 before trials; 0.0008 and 0.0055, 0.0007 and 0.0081 after one, when few components remain.
        assert!(exact < 0.0015 && rough < 0.01, "{n}: {exact} {rough}");
    }
}

/// Compares chances by members of 99.5 % of the weight with chances by all, from narrow to wide bands, before trials and
/// after one.
#[test]
fn likeliest_members_give_the_chances_of_all() {
    let after = discrepancy(vec![trial("A", groove(100.0, 300.0, 10.0), &loads(), 0.01, &mut |_| -0.1)]);
    for known in [discrepancy(vec![]), after] {
        let (n, all) = (loads().len(), known.at(&loads()));
        let (some, one) = (all.likeliest(0.995), all.likeliest(1e-9));
        let sensitivity = vec![Sensitivity::of_modulus(0.1); n];
        let components = |of: &Predictor| of.predict(&groove(100.0, 300.0, 10.0), &sensitivity).components;
        let weight: f64 = components(&some).iter().map(|of| of.weight).sum();
        assert!((weight - 1.0).abs() < 1e-12 && components(&some).len() < components(&all).len());
        // The first is the likeliest.
        let most = components(&all).into_iter().max_by(|a, b| a.weight.total_cmp(&b.weight)).unwrap();
        assert!(matches!(&components(&one)[..], [only] if only.mean == most.mean && only.weight == 1.0));
        for width_um in [40.0, 110.0, 300.0] {
            for half in [0.02, 0.05, 0.1] {
                let chance = |of: &Predictor| {
                    let prediction = of.predict(&groove(width_um, 300.0, 10.0), &sensitivity);
                    let wanted = Wanted { lower: vec![0.87 - half; n], upper: vec![0.87 + half; n] };
                    wanted.score(&prediction, &vec![0.95; n]).chance
                };
                let off = (chance(&some) - chance(&all)).abs();
                assert!(off < 0.004, "{width_um} {half}: {off}");
            }
        }
    }
}

/// A sample that is on target at any humidity from 15 to 80 % is so at every humidity between, not only at the computed
/// ones: steps of a fifth must find the chance that steps of a twentieth find, before trials and after one at both ends,
/// where the humidities between are the least known. With the correlation exp(-|dH| / 0.3) the four chances before trials
/// are 0.072, 0.061, 0.055 and 0.051, and have no limit but 0.
#[test]
fn the_chance_over_a_range_of_humidities_does_not_depend_on_how_many_are_computed() {
    let ends = [load(0.65, 2.0, 15.0), load(0.65, 2.0, 80.0)];
    let texture = groove(100.0, 300.0, 10.0);
    let after = discrepancy(vec![trial("A", texture, &ends, 0.01, &mut |_| -0.1)]);
    for known in [discrepancy(Vec::new()), after] {
        let chances = [4_u32, 8, 13, 26].map(|steps| {
            let at: Vec<Load> =
                (0..=steps).map(|step| load(0.65, 2.0, 15.0 + 65.0 * f64::from(step) / f64::from(steps))).collect();
            let n = at.len();
            let prediction = known.at(&at).predict(&texture, &vec![Sensitivity::of_modulus(0.1); n]);
            let wanted = Wanted { lower: vec![(-0.2_f64).exp(); n], upper: vec![1.0; n] };
            wanted.score(&prediction, &vec![1.0; n]).chance
        });
        let [coarse, _, fine, finest] = chances;
        assert!(coarse - finest < 0.02 && (fine - finest).abs() < 0.005, "{chances:?}");
    }
}
