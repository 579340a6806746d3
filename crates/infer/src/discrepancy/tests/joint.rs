//! Samples of one disc, predicted jointly.

use super::*;

/// Prediction of two values by two forms of equal weight with these means of the second value, the first unknown.
fn two_forms(means: [f64; 2]) -> Distribution {
    let of = |(form, mean): (Form, f64)| {
        // The first value is unknown by 0.2, the second equals it up to 0.01.
        let covariance = vec![0.04, 0.04, 0.04, 0.0401];
        Component { form, weight: 0.5, mean: vec![0.0, mean], covariance }
    };
    Distribution { components: [Form::Density, Form::Edge].into_iter().zip(means).map(of).collect() }
}

#[test]
fn forms_that_predict_equal_ratios_teach_nothing_and_far_ones_a_bit() {
    assert!(two_forms([-0.1, -0.1]).family_bits(0.01) < 1e-12);
    assert!((two_forms([-0.5, 0.5]).family_bits(0.01) - 1.0).abs() < 1e-6);
    // The difference is known to 0.0173 with both errors of measuring, whatever the amplitude: two normal distributions
    // two standard deviations apart tell 0.486 bits (integral of the binary entropy).
    let apart = 2.0 * (1e-4_f64 + 2e-4).sqrt();
    let bits = two_forms([0.0, apart]).family_bits(0.01);
    assert!((bits - 0.486).abs() < 0.03, "{bits}");
    // Members of one family are one mechanism.
    let mut one = two_forms([-0.5, 0.5]);
    one.components.iter_mut().for_each(|of| of.form = Form::Edge);
    assert_eq!((one.family_bits(0.01), one.families()), (0.0, vec![("edge length", 1.0)]));
    let [one, both] = [two_forms([-0.5, 0.5]), two_forms([0.1, 0.3])].map(|of| of.difference(0, 1));
    assert!((one.if_family("edge length").moments(0).0 - 0.5).abs() < 1e-12);
    // sqrt(0.0001 + 0.1^2)
    assert!((both.moments(0).1 - (0.0001_f64 + 0.01).sqrt()).abs() < 1e-12);
}

/// Two samples with shared and own errors, after a trial: marginals are those of the predictor, and the covariance between
/// the samples that of drawn truths.
#[test]
fn samples_of_one_disc_agree_with_single_predictions_and_with_drawn_truths() {
    let known = discrepancy(vec![trial("", groove(100.0, 300.0, 10.0), &loads(), 0.01, &mut |_| -0.2)]);
    let loads = &loads()[..2];
    let features: [Features; 2] = [groove(120.0, 200.0, 8.0), groove(60.0, 300.0, 20.0)];
    let shifts = features.map(|own| {
        let above = Features { areal_density: 1.1 * own.areal_density, edge_1_m: 1.1 * own.edge_1_m, ..own };
        vec![DimensionShift { log_ratio: vec![-0.01, -0.02], above, below: None }]
    });
    let sensitivities =
        [[0.1, 0.2], [0.3, -0.1]].map(|of| of.map(|modulus| Sensitivity { modulus, local_law: 0.02 }).to_vec());
    let covariances = [vec![1e-4, 5e-5, 5e-5, 4e-4], vec![4e-4, 1e-4, 1e-4, 9e-4]];
    let samples: Vec<Candidate<'_>> = (0..2)
        .map(|sample| Candidate {
            features: features[sample],
            modelled: &[1.0, 1.0],
            sensitivity: &sensitivities[sample],
            covariance: &covariances[sample],
            dimension_shifts: &shifts[sample],
        })
        .collect();
    let predictor = known.at(loads);
    let joint = predictor.on_one_disc(&samples);
    for (sample, of) in samples.iter().enumerate() {
        let alone = predictor.of(of);
        assert_eq!(alone.components.len(), joint.components.len());
        for (alone, joint) in alone.components.iter().zip(&joint.components) {
            assert_eq!((alone.form, alone.weight), (joint.form, joint.weight));
            for l in 0..2 {
                assert!((alone.mean[l] - joint.mean[2 * sample + l]).abs() < 1e-9);
                for m in 0..2 {
                    let own = joint.covariance[(2 * sample + l) * 4 + 2 * sample + m];
                    assert!((alone.covariance[2 * l + m] - own).abs() < 1e-9, "{own} {:?}", alone.covariance);
                }
            }
        }
    }
    let count = 40_000;
    let truths = Scenarios::new(&known, count, 5).on_one_disc(6);
    let drawn: Vec<Vec<Vec<f64>>> =
        samples.iter().enumerate().map(|(number, of)| truths.log_excesses(of, loads, number)).collect();
    let (mean, covariance) = joint.mixed();
    for a in 0..4 {
        for b in 0..=a {
            let product = |draw: usize| (drawn[a / 2][draw][a % 2] - mean[a]) * (drawn[b / 2][draw][b % 2] - mean[b]);
            let found = (0..count).map(product).sum::<f64>() / count as f64;
            let scale = (covariance[a * 5] * covariance[b * 5]).sqrt();
            assert!((found - covariance[a * 4 + b]).abs() < 0.04 * scale, "{a} {b}: {found} {covariance:?}");
        }
    }
}
