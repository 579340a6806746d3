//! Warnings about samples of one texture that contradict each other.

use crate::discrepancy::{Contradiction, Discrepancy};
use slipgrid_base::units::{HUMIDITY_PCT, PRESSURE_MPA, SPEED_MM_S, tidy};

/// Name with which the warnings begin.
const NAME: &str = "contradicting samples";
/// Maximum number of pairs that are listed.
const MAX_LISTED_PAIRS: usize = 3;

/// Warns of pairs of samples of one texture whose ratios differ by more than the stated scatter between samples, least
/// probable pair first.
pub fn contradicting_samples(learned: &Discrepancy) -> Vec<String> {
    let found = learned.contradictions();
    let mut all: Vec<String> = found.iter().take(MAX_LISTED_PAIRS).map(|pair| warning(learned, pair)).collect();
    match found.len().saturating_sub(MAX_LISTED_PAIRS) {
        0 => {}
        1 => all.push(format!("{NAME}: and one further pair")),
        more => all.push(format!("{NAME}: and {more} further pairs")),
    }
    all
}

fn warning(learned: &Discrepancy, pair: &Contradiction) -> String {
    let [first, second] = pair.trials.map(|trial| &learned.trials()[trial].name);
    let Contradiction { load, sample_std: [one, other], .. } = *pair;
    let stated = if one.to_bits() == other.to_bits() {
        percent(one)
    } else {
        format!("{} and {}", percent(one), percent(other))
    };
    let then = match pair.is_own {
        [true, true] => "sample_std is kept as it is stated of both".to_owned(),
        _ => format!("until then the scatter learned and used for other samples is {}", percent(learned.sample_std())),
    };
    format!(
        "{NAME}: \"{first}\" and \"{second}\" are of one texture within the errors of their dimensions, and their ratios over the modelled \
         ones differ by {} at {:.2} MPa, {} mm/s and {} %, where a scatter of {stated} is assumed (sample_std): {}; \
         measure both again, and their dimensions; {then}",
        percent(pair.difference.abs()),
        PRESSURE_MPA.from_si(load.pressure_pa),
        tidy(SPEED_MM_S.from_si(load.speed_m_s)),
        tidy(HUMIDITY_PCT.from_si(load.humidity)),
        if pair.probability < 1e-12 {
            "a probability below 1e-12".to_owned()
        } else {
            format!("a probability of {:.0e}", pair.probability)
        },
    )
}

/// Formats a difference of logarithms as a percentage with two digits.
fn percent(log: f64) -> String {
    let percent = 100.0 * log;
    if percent < 0.995 {
        format!("{percent:.2} %")
    } else if percent < 9.95 {
        format!("{percent:.1} %")
    } else {
        format!("{percent:.0} %")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discrepancy::tests::{cut, groove, measured};
    use crate::discrepancy::{Conditions, Hyperparameters, Load, Sensitivity, Trial};

    /// Samples of one texture with these logarithms of measured over modelled ratios.
    fn learned(excess: &[f64], sample_std: Option<f64>) -> Discrepancy {
        let load = Load { pressure_pa: 2e6, speed_m_s: 5e-3, humidity: 0.45 };
        let of = |(number, excess): (usize, &f64)| {
            let at = measured(load, *excess, 0.005, Sensitivity::of_modulus(0.05));
            Trial { sample_std, ..cut(&format!("cut-{}", number + 1), groove(150.0, 300.0, 12.0), vec![at]) }
        };
        let trials = excess.iter().enumerate().map(of).collect();
        Discrepancy::new(Hyperparameters::default(), Conditions::default(), 0.1, trials).unwrap()
    }

    #[test]
    fn pairs_are_named_with_what_is_said_of_their_scatter() {
        let [warning] = &contradicting_samples(&learned(&[0.0, -0.12], None))[..] else { panic!() };
        for words in [
            "contradicting samples: \"cut-1\" and \"cut-2\" are of one texture within the errors of their dimensions",
            "differ by 12 % at 2.00 MPa, 5 mm/s and 45 %, where a scatter of 2.0 % is assumed (sample_std)",
            "(sample_std): a probability of ",
            "until then the scatter learned and used for other samples is ",
        ] {
            assert!(warning.contains(words), "{words}: {warning}");
        }
        let own = contradicting_samples(&learned(&[0.0, -0.12], Some(0.01)));
        assert!(own.len() == 1 && own[0].contains("of 1.0 % is assumed (sample_std)"), "{own:?}");
        assert!(own[0].ends_with("sample_std is kept as it is stated of both"), "{own:?}");
        assert!(contradicting_samples(&learned(&[0.0, -0.12], Some(0.05))).is_empty());
        let many = contradicting_samples(&learned(&[0.0, 0.001, -0.12, -0.121], None));
        assert_eq!((many.len(), many[3].as_str()), (4, "contradicting samples: and one further pair"));
    }
}
