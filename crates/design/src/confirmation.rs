//! Confirming runs: the best design in time, at the condition designed for and at those further ones that decide.

use slipgrid_optimize::Status;
use slipgrid_pattern::Pattern;
use slipgrid_springblock::{Extent, Scene, Simulation, Status as RunStatus, SteadySpecimen, can_refine};

use crate::DesignError;
use crate::dynamic_excess::correct;
use crate::multi_fidelity::{CONFIRMATION, MultiFidelityLoop, is_doubtful};
use crate::task::DesignTask;
use crate::timings::Timings;
use slipgrid_specimen::{SpecimenError, simulate_on, strips_on};

/// Contact blocks with coefficients of their own that a confirming run in space has at least, over all its draws: with what they drew taken out,
/// so few scatter the ratio by a twentieth of the usual tolerance.
pub(super) const LEAST_CONTACTS: f64 = 100.0;

/// Designs that are searched again at most by a guess of what time adds.
const MOST_GUESSED: usize = 3;
/// Share of the tolerance up to which the error of blocks is left as it is.
const OF_TOLERANCE: f64 = 0.2;

/// What is known of a design without a run in time.
pub struct WithoutTime {
    /// What the steady model says of it.
    predicted: Simulation,
    /// Its specimen in steady sliding, from which a run goes on.
    strips: SteadySpecimen,
}

/// What is expected of a design in time.
pub struct Expected {
    /// The target's quantity at each load of each condition, as it is compared with the target.
    values: Vec<f64>,
    /// What it misses by, as the search ranks.
    pub(super) merit: f64,
    /// Its largest distance from the target, in tolerances.
    pub(super) misfit: f64,
    /// Its largest distance from what the search took.
    missed: f64,
}

fn refuse(error: SpecimenError) -> DesignError {
    DesignError::refused(error.to_string())
}

impl MultiFidelityLoop<'_> {
    /// What the steady model says of `pattern`, and how that is confirmed.
    fn predict(&mut self, design: &DesignTask, pattern: &Pattern) -> Result<Simulation, DesignError> {
        let predicted = self.model.simulate(pattern).map_err(refuse)?;
        self.round.confirming.draws = self.draws(pattern);
        // Once refined, always: what confirming runs correct must be the same from one to the next.
        self.round.confirming.refine |=
            can_refine(&self.confirming_scene(pattern), pattern) && self.is_coarse(design, pattern, &predicted);
        Ok(predicted)
    }

    /// Draws of the local coefficients that a confirming run of `pattern` takes.
    pub(super) fn draws(&self, pattern: &Pattern) -> u64 {
        match self.round.confirming.extent {
            // Dozens of cells have blocks enough.
            Extent::Strip => 1,
            Extent::Cell | Extent::Sample => self.model.draws(pattern, LEAST_CONTACTS),
        }
    }

    /// The best design without time; `None` where it is not solved strip by strip, or is not known what time adds to that.
    pub(super) fn without_time(
        &mut self,
        design: &DesignTask,
        timings: &mut Timings,
    ) -> Result<Option<WithoutTime>, DesignError> {
        let best = self.round.best.as_ref().map(|best| best.design);
        let Some(pattern) = best.filter(|_| self.added_by_time.is_some()) else { return Ok(None) };
        let bar = self.stage("confirmation");
        let predicted = self.predict(design, &pattern)?;
        let strips = strips_on(&self.confirming_scene(&pattern), &design.specimen, &bar).map_err(refuse)?;
        timings.confirm += bar.finish();
        self.monitor.heed()?;
        Ok(strips.map(|strips| WithoutTime { predicted, strips }))
    }

    /// What is expected in time of the best design, of which `solved` is known: with what time added to the last one, or is guessed to.
    pub(super) fn expected(&self, design: &DesignTask, solved: &WithoutTime) -> Option<Expected> {
        let best = self.round.best.as_ref()?;
        let each = self.expected_each(best, &solved.strips.steady());
        let values: Vec<f64> = each.into_iter().collect::<Option<_>>()?;
        let misfit = design.target.misfit(&values);
        let missed = best.response.value.iter().zip(&values).map(|(own, expected)| (expected - own).abs());
        Some(Expected { merit: misfit.merit, misfit: misfit.max, missed: missed.fold(0.0, f64::max), values })
    }

    /// Whether a search, of which `status` is said, is to be followed by another before its best design is run in time: where that is
    /// `expected` off target, or may bring one within reach. A run would say next to the same, at several times the cost. The model is corrected
    /// by what is expected then; of a design that it was corrected at, or that waits already, a run alone tells more.
    pub(super) fn is_searched_again(&mut self, design: &DesignTask, status: Status, expected: &Expected) -> bool {
        let is_guessed_too_often = self.runs == 0 && self.rounds > MOST_GUESSED;
        let may_go_on = self.goes_on(design) && !is_guessed_too_often;
        let Some(best) = self.round.best.as_ref().filter(|_| may_go_on) else { return false };
        let again = match status {
            _ if self.corrected_at == Some(best.design) || self.waits(&best.design) => false,
            Status::Met => expected.misfit > 1.0,
            Status::Unreachable => is_doubtful(design, best.misfit.max, expected.missed),
            Status::Budget | Status::Cancelled => false,
        };
        if again {
            let values: Vec<Option<f64>> = expected.values.iter().copied().map(Some).collect();
            self.corrected_at = Some(best.design);
            self.missed = self.model.correct(&best.design, &best.response.value, &values);
        }
        again
    }

    /// Runs `pattern` in time at the condition designed for, from what is `solved` of it without, where that is known.
    pub(super) fn confirm(
        &mut self,
        design: &DesignTask,
        pattern: &Pattern,
        solved: Option<WithoutTime>,
        timings: &mut Timings,
    ) -> Result<(), DesignError> {
        let bar = self.stage("confirmation");
        let (mut predicted, strips) = match solved {
            Some(WithoutTime { predicted, strips }) => (predicted, Some(strips)),
            None => (self.predict(design, pattern)?, None),
        };
        let scene = self.confirming_scene(pattern);
        let confirmed = match strips {
            Some(strips) => strips.in_time(&bar).map_err(SpecimenError::Scene),
            None => simulate_on(&scene, Some(&design.specimen), &bar),
        };
        let mut confirmed = confirmed.map_err(refuse)?;
        // Of a cell that has no answer nothing is compared.
        self.round.cell_peaks_pa = self.model.limited_peaks_pa(pattern).unwrap_or_default();
        timings.confirm += bar.finish();
        self.monitor.heed()?;
        self.note_cut(&confirmed, CONFIRMATION);
        let excess = self.excess.first().and_then(Option::as_deref);
        correct(&mut predicted, &self.model.scene(pattern), excess);
        correct(&mut confirmed, &scene, excess);
        self.added_by_time = self.model.added_by_time(&confirmed);
        self.runs += 1;
        self.round.predicted = Some(predicted);
        self.round.confirmed = Some(confirmed);
        for further in &mut self.further {
            further.confirmed = None;
        }
        Ok(())
    }

    /// The scene of the confirming run of `pattern` at the condition designed for.
    pub(super) fn confirming_scene(&self, pattern: &Pattern) -> Scene {
        Scene { pattern: Some(*pattern), run: self.round.confirming, ..self.scene.clone() }.in_time()
    }

    /// Whether the size of blocks leaves more open of `predicted` than a fifth of the tolerance.
    fn is_coarse(&self, design: &DesignTask, pattern: &Pattern, predicted: &Simulation) -> bool {
        let each = predicted.loads.iter().zip(self.model.scales(pattern));
        let most = each.filter_map(|(load, scale)| Some(load.ratio_discretization_error? * scale));
        most.fold(0.0, f64::max) > OF_TOLERANCE * design.target.tolerance()
    }

    /// Runs the best design in time at further conditions, each at its own speed: those of the lowest and the highest value at
    /// some pressure and of the largest misfit, by what is known so far, and then for as long as the largest misfit stands
    /// at one that was not run.
    pub(super) fn confirm_further(&mut self, design: &DesignTask, timings: &mut Timings) -> Result<(), DesignError> {
        let Some(pattern) = self.round.best.as_ref().map(|best| best.design) else { return Ok(()) };
        let mut wanted = self.undecided(design);
        while !wanted.is_empty() {
            for place in wanted {
                let at = &self.further[place];
                let what = format!("confirmation at {}", at.at.in_words());
                let bar = self.stage(&what);
                let speed_m_s = at.at.condition.map_or(self.scene.speed_m_s, |condition| condition.speed_m_s);
                let (loads, pattern) = (at.loads.clone(), at.at.turned(&pattern));
                let run = self.round.confirming;
                let scene = Scene { pattern: Some(pattern), loads, speed_m_s, run, ..self.scene.clone() }.in_time();
                let mut confirmed = simulate_on(&scene, Some(&design.specimen), &bar).map_err(refuse)?;
                timings.confirm_further += bar.finish();
                self.monitor.heed()?;
                correct(&mut confirmed, &scene, self.excess.get(1 + place).and_then(Option::as_deref));
                self.note_cut(&confirmed, "confirmation at further conditions");
                self.further[place].confirmed = Some(confirmed);
            }
            wanted = self.worst_undecided(design).into_iter().collect();
        }
        Ok(())
    }

    /// Notes that `run` was cut short, where it was: it confirms nothing.
    fn note_cut(&mut self, run: &Simulation, stage: &'static str) {
        let surfaces = run.loads.iter().flat_map(|load| std::iter::once(&load.surface).chain(&load.flat));
        if surfaces.into_iter().any(|surface| surface.status == RunStatus::Cancelled) {
            self.cut(stage);
            self.out_of_time = true;
        }
    }
}
