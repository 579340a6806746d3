//! Which of some draws are on target, and how two judgements of the same draws differ.

use slipgrid_optimize::Probability;

/// Whether each draw is on target, in the order drawn.
pub type Accepted = Vec<bool>;

/// Draws judged by an expansion of the steady model, and the first of them by the model itself. The share of the model is that of the
/// expansion at all draws, and what the model says otherwise of the first: two levels of Monte Carlo (Giles, Oper. Res. 56, 607, 2008), where
/// few of the dear draws suffice because they hardly differ from the cheap ones.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Judged {
    /// By the expansion.
    pub expanded: Accepted,
    /// The first of them by the model; none where it is too dear, and the expansion stands for it.
    pub sampled: Accepted,
}

/// By how much a share is greater than another of the same draws.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gain {
    /// Difference of the shares.
    pub share: f64,
    /// Its standard error.
    pub stderr: f64,
}

impl Gain {
    /// The mean of terms that are whole numbers; draws of which it is 0 tell nothing.
    fn of(terms: impl Iterator<Item = i32>) -> Self {
        let (mut count, mut sum, mut squares) = (0_u32, 0, 0);
        for term in terms {
            (count, sum, squares) = (count + 1, sum + term, squares + term * term);
        }
        let count = f64::from(count.max(1));
        // As in McNemar's test (Psychometrika 12, 153, 1947): variance of the sum that of its terms, one more so that it does not vanish
        // where all are 0.
        Self { share: f64::from(sum) / count, stderr: f64::from(squares + 1).sqrt() / count }
    }
}

impl Judged {
    /// What the model says otherwise of each draw that it was asked of: 1 of one that it alone accepts, -1 of one that it alone refuses.
    fn otherwise(&self) -> impl Iterator<Item = i32> {
        self.sampled.iter().zip(&self.expanded).map(|(&model, &expansion)| i32::from(model) - i32::from(expansion))
    }

    /// Share of all draws.
    pub fn probability(&self) -> Probability {
        let cheap = Probability::of(self.expanded.iter().filter(|&&accepted| accepted).count(), self.expanded.len());
        if self.sampled.is_empty() {
            return cheap;
        }
        // p = E_N[e] + E_n[s - e]
        let otherwise = Gain::of(self.otherwise());
        Probability {
            share: (cheap.share + otherwise.share).clamp(0.0, 1.0),
            stderr: cheap.stderr.hypot(otherwise.stderr),
        }
    }

    /// How much greater the share is than that of `other`, by the draws that both have.
    pub fn gain_over(&self, other: &Self) -> Gain {
        let both = self.expanded.iter().zip(&other.expanded);
        let cheap = Gain::of(both.map(|(&own, &other)| i32::from(own) - i32::from(other)));
        if self.sampled.is_empty() || other.sampled.is_empty() {
            return cheap;
        }
        let otherwise = Gain::of(self.otherwise().zip(other.otherwise()).map(|(own, other)| own - other));
        Gain { share: cheap.share + otherwise.share, stderr: cheap.stderr.hypot(otherwise.stderr) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_statistics::{Normals, normal_probability};

    fn of(accepted: &str) -> Accepted {
        accepted.chars().map(|draw| draw == '1').collect()
    }

    #[test]
    fn shares_of_the_same_draws_differ_by_those_that_are_judged_otherwise() {
        let judged = |expanded: &str| Judged { expanded: of(expanded), sampled: Vec::new() };
        let all = judged("1100110011");
        // Six draws: one gained, none lost. Of the others nothing is known.
        assert_eq!(judged("111011").gain_over(&all), Gain { share: 1.0 / 6.0, stderr: 2.0_f64.sqrt() / 6.0 });
        assert_eq!(judged("110011").gain_over(&all), Gain { share: 0.0, stderr: 1.0 / 6.0 });
        assert_eq!(judged("001111").gain_over(&all), Gain { share: 0.0, stderr: 5.0_f64.sqrt() / 6.0 });
        assert_eq!(all.probability().share, 0.6);
    }

    #[test]
    fn what_the_model_says_otherwise_is_added() {
        // Of four draws the model refuses one that the expansion accepts, and half of eight are accepted by that.
        let all = Judged { expanded: of("11001100"), sampled: of("1000") };
        assert_eq!(all.probability().share, 0.25);
        // Of another the model refuses none, and the expansion accepts one more.
        let other = Judged { expanded: of("11001110"), sampled: of("1100") };
        assert_eq!(other.gain_over(&all).share, 0.125 + 0.25);
        assert_eq!(Judged { sampled: Vec::new(), ..all }.probability(), Probability::of(4, 8));
    }

    /// Where the model is x^2 / 2 + x < 1 and its expansion x < 1, the share is the model's, and as exact as the error says.
    #[test]
    fn the_share_is_that_of_the_model_with_the_error_that_is_stated() {
        let root = 3.0_f64.sqrt();
        // x between -1 - sqrt(3) and -1 + sqrt(3)
        let exact = normal_probability(root - 1.0) - normal_probability(-root - 1.0);
        let mut normals = Normals::new(3);
        let mut off = Vec::new();
        for _ in 0..200 {
            let x: Vec<f64> = (0..4000).map(|_| normals.draw()).collect();
            let expanded = x.iter().map(|x| *x < 1.0).collect();
            let sampled = x[..300].iter().map(|x| 0.5 * x * x + x < 1.0).collect();
            let found = Judged { expanded, sampled }.probability();
            off.push((found.share - exact) / found.stderr);
        }
        let mean = off.iter().sum::<f64>() / 200.0;
        let square = off.iter().map(|off| off * off).sum::<f64>() / 200.0;
        assert!(mean.abs() < 0.25 && (square - 1.0).abs() < 0.35, "{mean} {square}");
    }
}
