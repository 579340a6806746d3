//! Which of the conditions that the target must hold at decide, and what is said of them.

use slipgrid_optimize::{Candidate, Target};
use slipgrid_springblock::Simulation;

use crate::multi_fidelity::MultiFidelityLoop;
use crate::operating_conditions::{Further, Setting};
use crate::task::DesignTask;
use slipgrid_units::{HUMIDITY_PCT, SPEED_MM_S, tidy};

/// The largest misfit of each condition's share of `values`.
pub fn misfits(target: &Target, values: &[f64]) -> Vec<f64> {
    values.chunks(target.points().len()).map(|own| target.at_conditions(1).misfit(own).max).collect()
}

/// The place of the greatest, the first of equals; 0 without any.
pub fn greatest(numbers: impl Iterator<Item = f64>) -> usize {
    let mut best = (0, f64::NEG_INFINITY);
    for (place, number) in numbers.enumerate() {
        if number > best.1 {
            best = (place, number);
        }
    }
    best.0
}

/// Places of the conditions that decide, of `values` at each pressure of each condition: those with the lowest and the highest
/// value at some pressure, and the one with the largest misfit. The first of equals, in order, each once.
fn decisive(target: &Target, values: &[f64]) -> Vec<usize> {
    let count = target.points().len();
    let at = |pressure: usize| values.iter().skip(pressure).step_by(count).copied();
    let mut places = vec![greatest(misfits(target, values).into_iter())];
    places.extend((0..count).flat_map(|p| [greatest(at(p).map(|value| -value)), greatest(at(p))]));
    places.sort_unstable();
    places.dedup();
    places
}

impl MultiFidelityLoop<'_> {
    /// The target's quantity at each load of each condition, the one designed for first: by the confirming runs, and where
    /// none was made by the steady model about that at the condition designed for. Absent where a run gave none.
    pub(super) fn confirmed_each(&self) -> Vec<Option<f64>> {
        let (Some(best), Some(confirmed)) = (&self.round.best, &self.round.confirmed) else { return Vec::new() };
        self.by_first(best, self.model.confirmed(&best.design, 0, confirmed), |at| at.confirmed.as_ref())
    }

    /// The same of `best` that is not run in time, of which `steady` is its specimen in steady sliding: with what time added to that of the
    /// last design that was, or is guessed to.
    pub(super) fn expected_each(&self, best: &Candidate, steady: &Simulation) -> Vec<Option<f64>> {
        let Some(added) = &self.added_by_time else { return Vec::new() };
        self.by_first(best, self.model.expected(&best.design, steady, added), |_| None)
    }

    /// Values `first` of `best` at the condition designed for, and those at the further ones: by the runs that `run` says, or about the first.
    fn by_first(
        &self,
        best: &Candidate,
        first: Vec<Option<f64>>,
        run: impl Fn(&Further) -> Option<&Simulation>,
    ) -> Vec<Option<f64>> {
        let of = |(place, at): (usize, &Further)| match run(at) {
            Some(run) => self.model.confirmed(&best.design, place + 1, run),
            None => self.model.about(&best.design, place + 1, &best.response.value, &first),
        };
        let further: Vec<Option<f64>> = self.further.iter().enumerate().flat_map(of).collect();
        first.into_iter().chain(further).collect()
    }

    /// The further conditions that decide and were not run in time, by their places among the further ones.
    pub(super) fn undecided(&self, design: &DesignTask) -> Vec<usize> {
        let Some(values) = self.confirmed_values() else { return Vec::new() };
        let places = decisive(&design.target, &values).into_iter().filter_map(|place| place.checked_sub(1));
        places.filter(|place| self.further[*place].confirmed.is_none()).collect()
    }

    /// The further condition with the largest misfit of all, where it was not run in time.
    pub(super) fn worst_undecided(&self, design: &DesignTask) -> Option<usize> {
        let values = self.confirmed_values()?;
        let place = greatest(misfits(&design.target, &values).into_iter()).checked_sub(1)?;
        self.further[place].confirmed.is_none().then_some(place)
    }

    /// What is said of the conditions beside what the confirming run says of itself.
    pub(super) fn condition_statements(&self, design: &DesignTask) -> Vec<String> {
        let mut statements = Vec::new();
        let alike = &design.directions.alike_deg;
        if !alike.is_empty() {
            let named: Vec<String> = alike.iter().map(|angle_deg| tidy(*angle_deg).to_string()).collect();
            let own_deg = design.space.texture().sliding_angle_deg();
            statements.push(format!(
                "sliding at {} deg is by symmetry what sliding at {} is: solved once",
                named.join(", "),
                if design.directions.different_deg.is_empty() {
                    format!("{} deg", tidy(own_deg))
                } else {
                    "another direction".to_owned()
                },
            ));
        }
        if self.further.is_empty() {
            return statements;
        }
        let first = Setting::first(design);
        let count = self.further.len() + 1;
        if let Some(range) = design.range() {
            let ends = |[lowest, highest]: [f64; 2]| {
                if lowest < highest {
                    format!("{} to {}", tidy(lowest), tidy(highest))
                } else {
                    tidy(lowest).to_string()
                }
            };
            statements.push(format!(
                "{} mm/s and {} % of humidity: friction is lowest and highest at its ends and at measured conditions inside, since \
                 coefficients are linear in between; designed for and reported at {}, of these the measured one with the most \
                 pressures nearest the middle",
                ends(range.speed_m_s().map(|speed| SPEED_MM_S.from_si(speed))),
                ends(range.humidity().map(|humidity| HUMIDITY_PCT.from_si(humidity))),
                Setting { sliding_angle_deg: None, ..first }.in_words(),
            ));
        }
        statements.push(format!(
            "searched for {count} conditions{} at once, each with its own coefficients; limits hold at all of them",
            if design.directions.different_deg.is_empty() { "" } else { " and sliding directions" },
        ));
        if design.target.quantity() == slipgrid_optimize::Quantity::DynamicFriction && !design.also_at.is_empty() {
            statements.push(format!(
                "flat friction at further conditions: that of the flat sample in time at {} times the ratio of the coefficients",
                first.in_words()
            ));
        }
        statements
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_optimize::{Quantity, TargetPoint};

    #[test]
    fn the_lowest_and_the_highest_at_each_pressure_and_the_worst_decide() {
        let points = [1e6, 2e6].map(|pressure_pa| TargetPoint { pressure_pa, value: 0.9 }).to_vec();
        let target = Target::new(Quantity::Ratio, points, 0.01).unwrap().at_conditions(4);
        // Lowest and highest at the first pressure: 1, 0; at the second 1, 3. The worst: 3.
        let values = [0.93, 0.90, 0.89, 0.89, 0.90, 0.90, 0.90, 0.95];
        assert_eq!(decisive(&target, &values), [0, 1, 3]);
        assert!(misfits(&target, &values).iter().zip([3.0, 1.0, 0.0, 5.0]).all(|(a, b)| (a - b).abs() < 1e-9));
        // Of equals the first.
        assert_eq!(decisive(&target, &[0.9; 8]), [0]);
    }
}
