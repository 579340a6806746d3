//! What is known at some designs, and what that says of those in between.

use slipgrid_pattern::Pattern;
use slipgrid_statistics::{Kriging, distance};

/// Distance over which quantities resemble each other. What cells in blocks of 10 um are off by those of 2.5 um, most of what specimens have
/// beyond cells, goes on differing the more, the further grooves 40 to 500 um wide are apart, up to there.
const RANGE: f64 = 3.0;
/// Nearer than this, quantities differ by where cavities end within blocks and by the errors of runs: their slope would say nothing of designs
/// further off.
const MIN_APART: f64 = 0.3;
/// Cavities as shallow as one or two blocks differ most: a factor in depth counts as much as this power of it in width or spacing.
const OF_DEPTH: f64 = 2.0;

/// Quantities that are known at some designs: exact there.
#[derive(Clone, Debug, Default)]
pub struct BetweenDesigns {
    /// The designs with their quantities, the one learnt last at the end.
    known: Vec<(Pattern, Vec<f64>)>,
    kriging: Kriging<3>,
}

impl BetweenDesigns {
    /// The quantities of `design`; `None` where nothing is known of any.
    pub fn at(&self, design: &Pattern) -> Option<Vec<f64>> {
        (!self.known.is_empty()).then(|| self.kriging.at(&place(design)))
    }

    /// Takes these quantities, as many for each, for those of the designs `learnt`, in the place of what was known of them and of designs alike.
    pub fn learn(&mut self, learnt: impl IntoIterator<Item = (Pattern, Vec<f64>)>) {
        for (design, quantities) in learnt {
            let own = place(&design);
            self.known.retain(|(known, _)| distance(&place(known), &own) >= MIN_APART);
            self.known.push((design, quantities));
        }
        let places = self.known.iter().map(|(known, _)| place(known)).collect();
        let count = self.known.first().map_or(0, |(_, quantities)| quantities.len());
        let of = |number: usize| self.known.iter().map(|(_, quantities)| quantities[number]).collect();
        self.kriging = Kriging::new(RANGE, places, (0..count).map(of).collect());
    }
}

/// Where `design` lies: ln(width), ln(spacing), and ln(depth), which counts more.
fn place(design: &Pattern) -> [f64; 3] {
    let [width, spacing, depth] = design.lengths_m().map(f64::ln);
    [width, spacing, OF_DEPTH * depth]
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_pattern::Planform;

    fn groove(width_um: f64, depth_um: f64) -> Pattern {
        Pattern::new(Planform::Groove, width_um * 1e-6, 300e-6, depth_um * 1e-6).unwrap()
    }

    #[test]
    fn what_was_learnt_last_of_a_design_counts_and_others_lie_between() {
        let mut found = BetweenDesigns::default();
        assert_eq!(found.at(&groove(100.0, 10.0)), None);
        found.learn([(groove(100.0, 10.0), vec![1.0, 5.0])]);
        assert_eq!(found.at(&groove(200.0, 20.0)), Some(vec![1.0, 5.0]));
        found.learn([(groove(200.0, 10.0), vec![3.0, 5.0]), (groove(100.0, 10.0), vec![2.0, 5.0])]);
        let at = |width_um: f64| found.at(&groove(width_um, 10.0)).unwrap();
        assert!((at(100.0)[0] - 2.0).abs() < 1e-9 && (at(200.0)[0] - 3.0).abs() < 1e-9);
        assert!(at(141.0)[0] > 2.2 && at(141.0)[0] < 2.8 && (at(141.0)[1] - 5.0).abs() < 1e-9);
    }

    #[test]
    fn designs_alike_stand_for_one_another() {
        let mut found = BetweenDesigns::default();
        found.learn([(groove(100.0, 10.0), vec![0.0])]);
        // What was known of one alike is forgotten.
        let nearly = groove(101.0, 10.0);
        found.learn([(nearly, vec![0.4])]);
        assert_eq!(found.at(&groove(800.0, 40.0)), Some(vec![0.4]));
        found.learn([(groove(100.0, 10.0), vec![0.0])]);
    }
}
