//! Stated chances against what comes true, for truths drawn from the prior.

use super::*;

/// Relative standard errors of a measured ratio: patterned and flat sample.
const PATTERNED_STD: f64 = 0.005;
const FLAT_STD: f64 = 0.003;
/// Samples that each laboratory cuts.
const CUTS: usize = 3;
const BINS: usize = 5;

/// Grooves that a laboratory may cut, with modelled ratios that fall with density and load.
fn textures() -> Vec<(Features, Vec<f64>)> {
    let mut found = Vec::new();
    for width_um in [40.0, 80.0, 160.0, 320.0] {
        for spacing_um in [80.0, 160.0, 320.0, 640.0] {
            let features = groove(width_um, spacing_um, if spacing_um > 200.0 { 20.0 } else { 5.0 });
            let ratio = |place: usize| 1.0 - (0.02 + 0.04 * place as f64) * features.areal_density;
            found.push((features, (0..loads().len()).map(ratio).collect()));
        }
    }
    found
}

/// Chances stated by laboratories before each cut, with whether the sample was on target: each laboratory is a truth of
/// the prior, cuts the likeliest texture that it has not cut, measures it, and learns.
fn said_and_came_true(laboratories: usize) -> Vec<(f64, bool)> {
    let (textures, at) = (textures(), loads());
    let sensitivity = moduli([0.02, 0.06, 0.10, 0.14]);
    let candidate = |place: usize| {
        let (features, modelled): &(Features, Vec<f64>) = &textures[place];
        Candidate { features: *features, modelled, sensitivity: &sensitivity, covariance: &[], dimension_shifts: &[] }
    };
    let truths = Scenarios::new(&prior(), laboratories, 5);
    // Each cut is of another sample, also where two are of one texture.
    let samples: Vec<Vec<Vec<Vec<f64>>>> = (0..CUTS)
        .map(|own| (0..textures.len()).map(|place| truths.log_excesses(&candidate(place), &at, own)).collect())
        .collect();
    let mut normals = Normals::new(7);
    let mut found = Vec::new();
    for truth in 0..laboratories {
        let middle = 0.95 - 0.25 * normal_probability(normals.draw());
        let half = 0.04 + 0.2 * normal_probability(normals.draw());
        let wanted = Wanted { lower: vec![middle - half; at.len()], upper: vec![middle + half; at.len()] };
        let flat: Vec<f64> = at.iter().map(|_| FLAT_STD * normals.draw()).collect();
        let mut trials: Vec<Trial> = Vec::new();
        let mut open: Vec<usize> = (0..textures.len()).collect();
        for sample in &samples {
            let predictor = discrepancy(trials.clone()).at(&at);
            let rough = |place: &usize| {
                let candidate = candidate(*place);
                wanted.rough_score(&predictor.of(&candidate), candidate.modelled).value()
            };
            let values: Vec<f64> = open.iter().map(rough).collect();
            let best = (0..open.len()).max_by(|a, b| values[*a].total_cmp(&values[*b])).unwrap();
            let place = open.swap_remove(best);
            let candidate = candidate(place);
            let said = wanted.score(&predictor.of(&candidate), candidate.modelled).chance;
            let truly: Vec<f64> = sample[place][truth].clone();
            let [lower, upper] = wanted.over(candidate.modelled);
            let is_on = (0..at.len()).all(|load| (lower[load]..=upper[load]).contains(&truly[load]));
            found.push((said, is_on));
            let measured = |(load, on): (usize, &Load)| {
                let log = truly[load] + flat[load] + PATTERNED_STD * normals.draw();
                Measured {
                    load: *on,
                    measured: candidate.modelled[load] * log.exp(),
                    modelled: candidate.modelled[load],
                    patterned_std: PATTERNED_STD,
                    flat_std: FLAT_STD,
                    sensitivity: sensitivity[load],
                }
            };
            let name = format!("cut {}", trials.len() + 1);
            trials.push(cut(&name, candidate.features, at.iter().enumerate().map(measured).collect()));
        }
    }
    found
}

/// Checks every bin of a fifth: the share that came true is the mean chance that was said, within three standard errors.
#[expect(clippy::print_stdout, reason = "a table for people")]
fn check(cuts: &[(f64, bool)]) {
    for bin in 0..BINS {
        let own = cuts.iter().filter(|(said, _)| ((said * BINS as f64) as usize).min(BINS - 1) == bin);
        let own: Vec<&(f64, bool)> = own.collect();
        let count = own.len() as f64;
        let said = own.iter().map(|(said, _)| said).sum::<f64>() / count;
        let came = own.iter().filter(|(_, came)| *came).count() as f64 / count;
        println!("{count} cuts: {said:.3} said, {came:.3} came true");
        let noise = 3.0 * (said * (1.0 - said) / count).sqrt();
        assert!(count >= 10.0 && (came - said).abs() < noise, "{count} cuts: {said} said, {came} came true");
    }
}

#[test]
fn stated_chances_come_true() {
    check(&said_and_came_true(80));
}

/// The table of the book, evidence/verification.md.
#[test]
#[ignore = "half a minute: 1500 laboratories"]
fn stated_chances_of_many_laboratories_come_true() {
    check(&said_and_came_true(1500));
}
