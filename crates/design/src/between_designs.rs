//! Interpolation of quantities known at some designs to other designs.

use slipgrid_base::statistics::{Kriging, distance};
use slipgrid_model::pattern::Pattern;

/// Correlation length in logarithms of the lengths. The difference between cells in blocks of 10 um and 2.5 um, the
/// main part of the difference between specimens and cells, varies over this distance for grooves 40 to 500 um wide.
const RANGE: f64 = 3.0;
/// Minimum distance between known designs, in logarithms of the lengths. At smaller distances quantities differ by the
/// positions of cavity ends within blocks and by errors of runs, and their slope does not extrapolate.
const MIN_APART: f64 = 0.3;
/// Factor of ln(depth) in distances between designs: depth counts more than width and spacing, because designs with
/// cavities one or two blocks deep differ most.
const OF_DEPTH: f64 = 2.0;

/// Quantities known for some designs and interpolated to others; at known designs the known values are returned.
#[derive(Clone, Debug, Default)]
pub struct BetweenDesigns {
    /// Designs with their quantities, the most recent last.
    known: Vec<(Pattern, Vec<f64>)>,
    kriging: Kriging<3>,
}

impl BetweenDesigns {
    /// Interpolates the quantities of `design`; `None` if no design is known.
    pub fn at(&self, design: &Pattern) -> Option<Vec<f64>> {
        (!self.known.is_empty()).then(|| self.kriging.at(&place(design)))
    }

    /// Adds the quantities of the designs `learnt`, equally many for each design. They replace the quantities of equal
    /// and similar designs.
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

/// Coordinates of `design`: ln(width), ln(spacing), and scaled ln(depth).
fn place(design: &Pattern) -> [f64; 3] {
    let [width, spacing, depth] = design.lengths_m().map(f64::ln);
    [width, spacing, OF_DEPTH * depth]
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_model::pattern::Planform;

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
        // A new value replaces the value of a similar design.
        let mut alike = BetweenDesigns::default();
        alike.learn([(groove(100.0, 10.0), vec![0.0])]);
        alike.learn([(groove(101.0, 10.0), vec![0.4])]);
        assert_eq!(alike.at(&groove(800.0, 40.0)), Some(vec![0.4]));
    }
}
