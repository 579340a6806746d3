//! The largest local pressure by confirming runs, where designs limit it.
//!
//! The search's cell is endless. The outer lands of a specimen are pressed harder, and sliding in time adds to that. So the largest
//! pressure of the confirming runs is compared with the limit, too, and where it is beyond, by how many times it is that of the cell is
//! learned for the search that follows.

use slipgrid_optimize::{Limit, Violation};
use slipgrid_springblock::Simulation;

use crate::constraint_quantities::ConstraintQuantity;
use crate::multi_fidelity::MultiFidelityLoop;
use crate::task::DesignTask;

/// The largest local pressures of one design at one condition, in pascals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peaks {
    /// In the steady cell.
    cell_pa: f64,
    /// In the confirming run.
    confirmed_pa: f64,
}

impl Peaks {
    /// Those of `cell_pa`, by load, and of `run` at the same loads; `None` where it says nothing.
    fn new(cell_pa: &[f64], run: &Simulation) -> Option<Self> {
        let each = cell_pa.iter().zip(&run.loads).filter(|(_, load)| load.is_trusted());
        let (cell_pa, confirmed_pa) = each.fold((0.0_f64, 0.0_f64), |(cell, confirmed), (own, load)| {
            (cell.max(*own), confirmed.max(load.surface.peak_pressure_pa))
        });
        (cell_pa > 0.0 && confirmed_pa.is_finite()).then_some(Self { cell_pa, confirmed_pa })
    }
}

/// A constraint that the best design breaks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Broken {
    /// By the search's model.
    Model(Violation),
    /// By a confirming run.
    Confirmed(Limit, Peaks),
}

impl Broken {
    /// How far beyond the constraint, relative to it.
    pub(crate) fn excess(&self) -> f64 {
        match self {
            Self::Model(violation) => violation.excess(),
            Self::Confirmed(limit, peaks) => limit.excess(peaks.confirmed_pa),
        }
    }
}

impl std::fmt::Display for Broken {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Model(violation) => violation.fmt(f),
            Self::Confirmed(limit, Peaks { cell_pa, confirmed_pa }) => write!(
                f,
                "{} is {} in the confirming run and {} in the steady cell: allowed is at most {}",
                limit.name,
                limit.tell(*confirmed_pa),
                limit.tell(*cell_pa),
                limit.tell(limit.bound.limit()),
            ),
        }
    }
}

impl MultiFidelityLoop<'_> {
    /// The largest pressures of the best design at every condition that was run in time; none where they are not limited.
    fn peaks(&self) -> Vec<Peaks> {
        let further = self.further.iter().map(|at| at.confirmed.as_ref());
        let runs = std::iter::once(self.round.confirmed.as_ref()).chain(further);
        let cells = self.round.cell_peaks_pa.chunks(self.scene.loads.len());
        cells.zip(runs).filter_map(|(cell_pa, run)| Peaks::new(cell_pa, run?)).collect()
    }

    /// Learns by how many times confirming runs press the best design harder than its cell, once one of them was beyond the limit.
    pub(super) fn learn_peaks(&mut self, design: &DesignTask) {
        let Some(limit) = peak_limit(design) else { return };
        let peaks = self.peaks();
        let is_beyond = peaks.iter().any(|peaks| limit.excess(peaks.confirmed_pa) > 0.0);
        let factors = peaks.iter().map(|Peaks { cell_pa, confirmed_pa }| confirmed_pa / cell_pa);
        if let Some(factor) = factors.reduce(f64::max).filter(|_| is_beyond || self.model.peak_factor().is_some()) {
            self.model.learn_peak_factor(factor.max(1.0));
        }
    }

    /// Whether a confirming run of the best design is beyond the limit.
    pub(super) fn breaks_in_time(&self, design: &DesignTask) -> bool {
        self.broken(design).iter().any(|broken| matches!(broken, Broken::Confirmed(..)))
    }

    /// What the best design breaks: with its largest pressure in the cell and in every confirming run, where there is one. What was
    /// learned of another design need not hold for one that was run itself.
    pub(super) fn broken(&self, design: &DesignTask) -> Vec<Broken> {
        let Some(best) = &self.round.best else { return Vec::new() };
        let peaks = self.peaks();
        let highest =
            peaks.into_iter().reduce(|most, own| if own.confirmed_pa > most.confirmed_pa { own } else { most });
        let Some((limit, peaks)) = peak_limit(design).zip(highest) else {
            return best.violations.iter().copied().map(Broken::Model).collect();
        };
        let cell_pa = self.round.cell_peaks_pa.iter().copied().fold(0.0, f64::max);
        let is_other =
            |violation: &&Violation| !matches!(violation, Violation::Quantity { limit: of, .. } if *of == limit);
        let others = best.violations.iter().filter(is_other).copied().map(Broken::Model);
        let peak = if limit.excess(peaks.confirmed_pa) > 0.0 {
            Some(Broken::Confirmed(limit, peaks))
        } else if limit.excess(cell_pa) > 0.0 {
            Some(Broken::Model(Violation::Quantity { limit, value: cell_pa }))
        } else {
            None
        };
        others.chain(peak).collect()
    }
}

/// The limit of the largest local pressure, where `design` has one.
fn peak_limit(design: &DesignTask) -> Option<Limit> {
    let mut limits = design.quantities.iter().zip(&design.constraints.quantities);
    limits.find(|(of, _)| **of == ConstraintQuantity::PeakPressure).map(|(_, limit)| *limit)
}

#[cfg(test)]
mod tests {
    use crate::constraint_quantities::ConstraintQuantity;
    use crate::next_trial::tests::task;
    use crate::{DesignReport, NoCache, Unwatched, run};
    use slipgrid_optimize::{Bound, Limit, Quantity, Target, TargetPoint};
    use slipgrid_pattern::Planform;
    use slipgrid_springblock::Layer;

    /// Grooves on a small disc, of which outer lands are pressed harder than those of an endless pattern.
    fn found(most_mpa: Option<f64>, most_evaluations: Option<usize>) -> DesignReport {
        let mut task = task(Planform::Groove);
        let point = TargetPoint { pressure_pa: 2.6e6, value: 0.93 };
        task.target = Target::new(Quantity::Ratio, vec![point], 0.02).unwrap();
        task.specimen.outline = slipgrid_export::Outline::Disc { diameter_m: 2e-3 };
        task.layer = Layer { length_m: 2e-3, height_m: 100e-6, block_m: 20e-6, thickness_m: None };
        if let Some(most_mpa) = most_mpa {
            let limit = most_mpa * 1e6;
            task.quantities.push(ConstraintQuantity::PeakPressure);
            task.constraints.quantities.push(Limit {
                name: "peak pressure",
                unit: "MPa",
                unit_si: 1e6,
                bound: Bound::AtMost(limit),
                scale: limit,
                loosest: f64::INFINITY,
            });
        }
        task.max_evaluations = most_evaluations.unwrap_or(task.max_evaluations);
        run(&task, &mut NoCache, &Unwatched).unwrap().report
    }

    fn peaks_mpa(report: &DesignReport) -> [f64; 2] {
        [&report.predicted, &report.confirmed].map(|loads| loads[0].peak_pressure_mpa)
    }

    #[test]
    fn the_largest_pressure_is_limited_in_the_confirming_run_too() {
        let free = found(None, None);
        let [cell, confirmed] = peaks_mpa(&free);
        assert!(free.status == "met" && confirmed > 1.05 * cell, "{cell} {confirmed}");
        let most = f64::midpoint(cell, confirmed);
        // Searched again with what the confirming run says.
        let kept = found(Some(most), None);
        let [_, kept_confirmed] = peaks_mpa(&kept);
        assert!(kept.rounds > 1 && kept.violations.is_empty(), "{} {:?}", kept.rounds, kept.violations);
        assert!(kept.status == "met" && kept_confirmed <= most, "{} {kept_confirmed} {most}", kept.status);
        // Without evaluations for a further search the limit is broken, and that is said.
        let broken = found(Some(most), Some(free.evaluations));
        assert_eq!((broken.rounds, broken.status.as_ref()), (1, "budget"));
        let [cell, confirmed] = peaks_mpa(&broken);
        assert!(cell <= most && confirmed > most, "{cell} {confirmed} {most}");
        let told = [confirmed, cell, most].map(|mpa| format!("{mpa:.3e}").parse::<f64>().unwrap());
        let says = format!(
            "peak pressure is {} MPa in the confirming run and {} MPa in the steady cell: allowed is at most {} MPa",
            told[0], told[1], told[2]
        );
        assert_eq!(broken.violations, [says]);
        assert!(!broken.verdict().is_met);
    }
}
