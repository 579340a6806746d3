//! Which of some draws are on target, and how two judgements of the same draws differ.

use slipgrid_optimize::Probability;

/// Whether each draw is on target, in the order drawn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Accepted(pub Vec<bool>);

/// By how much a share is greater than another of the same draws.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gain {
    /// Difference of the shares.
    pub share: f64,
    /// Its standard error.
    pub stderr: f64,
}

impl Accepted {
    /// Share of all draws.
    pub fn probability(&self) -> Probability {
        Probability::of(self.0.iter().filter(|&&accepted| accepted).count(), self.0.len())
    }

    /// How much greater the share is than that of `other`, by the draws that both have. These are the same draws, so that only those
    /// tell anything which one accepts and the other does not.
    pub fn gain_over(&self, other: &Self) -> Gain {
        let both = || self.0.iter().zip(&other.0);
        let gained = both().filter(|&(own, other)| *own && !other).count() as f64;
        let lost = both().filter(|&(own, other)| !own && *other).count() as f64;
        let draws = both().count() as f64;
        // As in McNemar's test (Psychometrika 12, 153, 1947): variance gained + lost, one more so that it does not vanish without either.
        Gain { share: (gained - lost) / draws, stderr: (gained + lost + 1.0).sqrt() / draws }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_of_the_same_draws_differ_by_those_that_are_judged_otherwise() {
        let of = |accepted: &str| Accepted(accepted.chars().map(|draw| draw == '1').collect());
        let all = of("1100110011");
        // Six draws: one gained, none lost. Of the others nothing is known.
        assert_eq!(of("111011").gain_over(&all), Gain { share: 1.0 / 6.0, stderr: 2.0_f64.sqrt() / 6.0 });
        assert_eq!(of("110011").gain_over(&all), Gain { share: 0.0, stderr: 1.0 / 6.0 });
        assert_eq!(of("001111").gain_over(&all), Gain { share: 0.0, stderr: 5.0_f64.sqrt() / 6.0 });
        assert_eq!(all.probability().share, 0.6);
    }
}
