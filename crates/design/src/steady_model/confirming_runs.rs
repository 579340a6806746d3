//! What confirming runs say of the model.

use slipgrid_optimize::{Candidate, ForwardModel, ModelFailure};
use slipgrid_pattern::Pattern;
use slipgrid_springblock::{Load, LoadOutcome, Simulation};

use super::{SteadyModel, texture_effect};
use crate::task::DesignTask;

/// What time adds to the ratio over `mu_s / mu_d` - 1, roughly: 0.02 to 0.06 on six grooves 40 to 300 um wide at 0.65 to 2.6 MPa.
const ADDED_BY_STICKING: f64 = 0.035;

impl SteadyModel<'_> {
    /// Takes the difference between `confirmed` and what the model `predicted` of `design` as its error there, which says something of other
    /// designs, and returns the largest change of it at this one. Values, one per load of each condition, that either has not keep their
    /// correction.
    pub fn correct(&mut self, design: &Pattern, predicted: &[f64], confirmed: &[Option<f64>]) -> f64 {
        let mut largest = 0.0_f64;
        let (scales, each) = (self.scales(design), predicted.iter().zip(confirmed));
        let mut differences = self.correction_of(design);
        let cell =
            self.kept(&self.asked, &self.solver, design).and_then(|answer| Ok(answer.on(&self.lay(design)?, design)));
        let Ok(cell) = cell else { return largest };
        for (((difference, scale), ratio), (predicted, confirmed)) in
            differences.iter_mut().zip(scales).zip(&cell.ratio).zip(each)
        {
            if let Some(confirmed) = confirmed {
                largest = largest.max((confirmed - predicted).abs());
                *difference += (confirmed - predicted) / (scale * texture_effect(*ratio));
            }
        }
        self.correction.learn([(*design, differences)]);
        largest
    }

    /// Largest pressures are compared with their limit times `factor` from here on: confirming runs press that much harder than cells.
    pub fn learn_peak_factor(&mut self, factor: f64) {
        self.limited.learn_peak_factor(factor);
    }

    /// By how much confirming runs press harder than cells; absent before that is learned.
    #[must_use]
    pub const fn peak_factor(&self) -> Option<f64> {
        self.limited.peak_factor()
    }

    /// Largest local pressure of the cell of `design` at each load of each condition, in pascals; none where it is not limited.
    ///
    /// # Errors
    /// [`ModelFailure`] where the design cannot be computed.
    pub fn limited_peaks_pa(&self, design: &Pattern) -> Result<Vec<f64>, ModelFailure> {
        if self.limited.judges_peak() { self.peak_pressures_pa(design) } else { Ok(Vec::new()) }
    }

    /// The target's quantity by a confirming run of `design` at the condition of place `condition` as it is compared with the
    /// target, absent where it gave none that can be trusted.
    #[must_use]
    pub fn confirmed(&self, design: &Pattern, condition: usize, simulation: &Simulation) -> Vec<Option<f64>> {
        let factors = self.factors(design);
        let own = &factors[condition * self.scene.loads.len()..];
        simulation.loads.iter().zip(own).map(|(load, factor)| Some(self.physics(load)? * factor)).collect()
    }

    /// What a run in time, of which `confirmed` came, added to the specimen in steady sliding, to the target's quantity by the physics at each
    /// load of the condition designed for; `None` where it gave nothing that can be trusted, or is no specimen's.
    #[must_use]
    pub fn added_by_time(&self, confirmed: &Simulation) -> Option<Vec<f64>> {
        let steady = |load: &LoadOutcome| Some(load.ratio? - load.ratio_time_change?);
        let each = confirmed.loads.iter().enumerate();
        each.map(|(place, load)| Some(self.physics(load)? - steady(load)? * self.scale(place))).collect()
    }

    /// The same as it is guessed before any run, which only decides what is run: of grooves 0.002 to 0.007 of the ratio where blocks stick at a
    /// tenth more than they slide at. `None` in space, where nothing is known without time.
    #[must_use]
    pub fn guessed_by_time(&self) -> Option<Vec<f64>> {
        let of_load = |(place, load): (usize, &Load)| {
            let stick = load.friction.static_mean() / load.friction.dynamic_mean() - 1.0;
            ADDED_BY_STICKING * stick * self.scale(place)
        };
        self.dimension().takes_strips().then(|| self.scene.loads.iter().enumerate().map(of_load).collect())
    }

    /// The target's quantity of `design` at the condition designed for, by its specimen in steady sliding, `steady`, and what time adds,
    /// `added`, as it is compared with the target.
    #[must_use]
    pub fn expected(&self, design: &Pattern, steady: &Simulation, added: &[f64]) -> Vec<Option<f64>> {
        let each = steady.loads.iter().zip(added).zip(self.factors(design)).enumerate();
        each.map(|(place, ((load, added), factor))| {
            Some((load.ratio.filter(|_| load.is_trusted())? * self.scale(place) + added) * factor)
        })
        .collect()
    }

    /// The target's quantity by the physics of a confirming run; absent where it gave none that can be trusted.
    fn physics(&self, load: &LoadOutcome) -> Option<f64> {
        let value = if self.flat_mu.is_some() { load.surface.mu_dynamic } else { load.ratio };
        value.filter(|_| load.is_trusted())
    }

    /// What the steady model makes of the values `first` of `design` confirmed at the condition designed for at that of place
    /// `condition`, which the search took for `predicted`: its ratio is off by as much as there.
    #[must_use]
    pub fn about(
        &self,
        design: &Pattern,
        condition: usize,
        predicted: &[f64],
        first: &[Option<f64>],
    ) -> Vec<Option<f64>> {
        let (count, scales) = (self.scene.loads.len(), self.scales(design));
        let at = |(place, confirmed): (usize, &Option<f64>)| {
            let own = condition * count + place;
            // v + s dr, dr = (v_1 - predicted v_1) / s_1
            Some(predicted[own] + ((*confirmed)? - predicted[place]) * scales[own] / scales[place])
        };
        first.iter().enumerate().map(at).collect()
    }

    /// `candidate` by the model as it stands: it may have been corrected since.
    #[must_use]
    pub fn judged(&self, design: &DesignTask, candidate: &Candidate) -> Candidate {
        let Ok(response) = self.respond(&candidate.design) else { return candidate.clone() };
        Candidate {
            design: candidate.design,
            misfit: design.target.misfit(&response.value),
            violations: design.constraints.violations(&candidate.design, &response),
            response,
        }
    }
}
