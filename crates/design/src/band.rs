//! Requirements of a task on a cut sample: one [`Band`] per load.

use crate::optimize::{Goal, Quantity};
use slipgrid_base::statistics::extremes;
use slipgrid_infer::calibrate::uncertainty::Covariance;
use slipgrid_infer::discrepancy::{Conditions, Discrepancy, Distribution, Load, Measured, Trial, Wanted};
use slipgrid_model::material::END_MARGIN;

use crate::DesignError;
use crate::operating_conditions::Setting;
use crate::prepared_task::PreparedTask;
use crate::sensitivities::usual_humidity;

/// Relative difference up to which the speeds of trial and task are equal. Pressures are equal within [`END_MARGIN`].
const SAME_SPEED: f64 = 0.02;
/// Difference up to which the relative humidities of trial and task, from 0 to 1, are equal.
const SAME_HUMIDITY: f64 = 0.02;

/// Accepted values at one load of one condition.
#[derive(Clone, Debug, PartialEq)]
pub struct Band {
    /// Pressure, speed and humidity.
    pub load: Load,
    /// Sliding direction, in degrees; `None` if the target has only one.
    pub sliding_angle_deg: Option<f64>,
    /// Factor from a ratio to the quantity of the target: 1, or dynamic friction of the flat surface.
    pub flat: f64,
    /// Minimum and maximum accepted value of the quantity; `None` without such a limit.
    pub accepted: [Option<f64>; 2],
    /// Half the width of the accepted band; for a single limit, the distance inside it at which the search aims; `None`
    /// if nothing is demanded.
    pub tolerance: Option<f64>,
    /// Weight of this pressure in the mean that a goal optimizes.
    pub weight: f64,
}

/// Requirements of the task together with the trials.
pub struct Asked {
    /// One band per load of every condition.
    pub bands: Vec<Band>,
    /// Loads of the bands.
    pub loads: Vec<Load>,
    /// Accepted bands as bounds of the ratio.
    pub wanted: Wanted,
    /// Goal to optimize in addition to the bands; `None` without a goal.
    pub goal: Option<Goal>,
    /// Number of loads of one condition.
    pub count: usize,
    /// Discrepancy as learned from the trials of the material.
    pub learned: Discrepancy,
    /// Shares of the trials' flat sample errors in flat friction at each load; empty if ratios are asked for.
    pub flat_shares: Vec<Vec<f64>>,
    /// Covariance of the rest of the errors of flat friction at the loads of one sliding direction; `None` if trials
    /// share none of them.
    pub flat_rest: Option<Covariance>,
}

impl Asked {
    /// Builds the requirements of `prepared`.
    ///
    /// # Errors
    /// [`DesignError`] if the trials of the material are invalid.
    pub fn new(prepared: &PreparedTask) -> Result<Self, DesignError> {
        let PreparedTask { task, material, uncertainty, settings, .. } = prepared;
        let pressures_pa = task.pressures_pa();
        let [lowest_pressure_pa, _] = extremes(pressures_pa.iter().copied());
        let own = Conditions {
            reference_pressure_pa: pressures_pa.iter().sum::<f64>() / pressures_pa.len() as f64,
            lowest_pressure_pa,
            reference_speed_m_s: task.speed_m_s,
        };
        let learned = uncertainty.discrepancy(own).map_err(|error| DesignError::Failed(error.to_string()))?;
        let usual = usual_humidity(&learned);
        let (mut bands, mut at_conditions) = (Vec::new(), Vec::new());
        for Setting { condition, sliding_angle_deg, loads } in settings {
            let excess = uncertainty.excess(&pressures_pa, condition.as_ref());
            let speed_m_s = condition.map_or(task.speed_m_s, |condition| condition.speed_m_s);
            let humidity = condition.map_or(usual, |condition| condition.humidity);
            for (row, (demand, at)) in task.target.points().iter().zip(loads).enumerate() {
                // For friction itself, the factor is mu_d f(P) times dynamic over steady friction, from the flat sample.
                let flat = match task.target.quantity() {
                    Quantity::Ratio => 1.0,
                    Quantity::DynamicFriction => {
                        at.flat_mu(material.area_law.as_ref()) * excess.as_ref().map_or(1.0, |excess| excess[row])
                    }
                };
                let load = Load { pressure_pa: at.pressure_pa, speed_m_s, humidity };
                at_conditions.push((load, *condition));
                bands.push(Band {
                    load,
                    sliding_angle_deg: *sliding_angle_deg,
                    flat,
                    accepted: demand.wanted.band(),
                    tolerance: demand.wanted.tolerance(),
                    weight: demand.weight,
                });
            }
        }
        let loads: Vec<Load> = bands.iter().map(|band| band.load).collect();
        let count = prepared.loads().len();
        let end = |side: usize, open: f64| {
            bands.iter().map(|band| band.accepted[side].map_or(open, |end| end / band.flat)).collect()
        };
        let wanted = Wanted { lower: end(0, 0.0), upper: end(1, f64::INFINITY) };
        // All sliding directions have the friction of the same flat surface.
        at_conditions.truncate(loads.len() / (1 + task.directions.different_deg.len()));
        let is_friction = task.target.quantity() == Quantity::DynamicFriction;
        let shared = is_friction.then(|| uncertainty.flat_shares(&learned, &at_conditions)).flatten();
        let (shares, flat_rest) = shared.unzip();
        let flat_shares = shares.map_or_else(Vec::new, |own| own.iter().cycle().take(loads.len()).cloned().collect());
        Ok(Self { loads, wanted, goal: task.target.goal(), count, learned, bands, flat_shares, flat_rest })
    }

    /// Whether some load has a demand.
    pub fn has_demands(&self) -> bool {
        self.bands.iter().any(|band| band.accepted.iter().any(Option::is_some))
    }

    /// Whether `ratios`, one per load, are all within the accepted bands.
    pub fn accepts(&self, ratios: &[f64]) -> bool {
        let Wanted { lower, upper } = &self.wanted;
        ratios.iter().zip(lower.iter().zip(upper)).all(|(ratio, (lower, upper))| (lower..=upper).contains(&ratio))
    }

    /// Whether the median of samples is accepted at every load, for the modelled `ratios` and the `distribution` of
    /// ln(true / modelled ratio).
    pub fn has_medians_within(&self, ratios: &[f64], distribution: &Distribution) -> bool {
        let [lower, upper] = self.wanted.over(ratios);
        distribution.has_medians_within(&lower, &upper)
    }

    /// Largest distance over all loads of `ratios` from the middle of the accepted band, divided by the tolerance. For
    /// a single limit the distance is 1 at the limit, 0 from one tolerance inside, and grows outside.
    pub fn misfit(&self, ratios: &[f64]) -> f64 {
        let off = |(band, ratio): (&Band, &f64)| {
            let (Some(tolerance), value) = (band.tolerance, ratio * band.flat) else { return 0.0 };
            match band.accepted {
                [Some(low), Some(high)] => (value - f64::midpoint(low, high)).abs() / tolerance,
                [Some(low), None] => 1.0 + (low - value).max(-tolerance) / tolerance,
                [None, Some(high)] => 1.0 + (value - high).max(-tolerance) / tolerance,
                [None, None] => 0.0,
            }
        };
        self.bands.iter().zip(ratios).map(off).fold(0.0, f64::max)
    }

    /// Value of the goal for `ratios` at the worst condition: the mean over the pressures, or for an even goal the
    /// standard deviation over the mean. `None` without a goal.
    pub fn goal_value(&self, ratios: &[f64]) -> Option<f64> {
        let goal = self.goal?;
        let mean = |of: &dyn Fn(usize) -> f64, places: std::ops::Range<usize>| {
            let weight: f64 = places.clone().map(|place| self.bands[place].weight).sum();
            places.map(|place| self.bands[place].weight * of(place)).sum::<f64>() / weight
        };
        let value = |place: usize| ratios[place] * self.bands[place].flat;
        let of = |first: usize| {
            let places = first..first + self.count;
            let own = mean(&value, places.clone());
            match goal {
                Goal::Lowest | Goal::Highest => own,
                // s / m = sqrt( sum w_i (v_i - m)^2 / sum w_i ) / m
                Goal::Even => mean(&|place| (value(place) - own).powi(2), places).sqrt() / own,
            }
        };
        let worst = if goal == Goal::Highest { f64::min } else { f64::max };
        (0..ratios.len()).step_by(self.count).map(of).reduce(worst)
    }

    /// Score of `ratios` by the goal, higher for better ratios and of the order of 1; 0 without a goal.
    pub fn goal_gain(&self, ratios: &[f64]) -> f64 {
        let flat = self.bands.first().map_or(1.0, |band| band.flat);
        match (self.goal, self.goal_value(ratios)) {
            (Some(Goal::Lowest), Some(value)) => -value / flat,
            (Some(Goal::Highest), Some(value)) => value / flat,
            (Some(Goal::Even), Some(value)) => -value,
            _ => 0.0,
        }
    }

    /// Trials measured on target at every load: interpolated linearly between two measured pressures, or measured up to
    /// [`END_MARGIN`] away. None for a target with a goal, without demands, or in several directions.
    pub fn met_by(&self) -> impl Iterator<Item = &Trial> {
        // Trials are measured in one direction, so they cannot meet a target in several directions.
        let is_of_one = self.bands.iter().all(|band| band.sliding_angle_deg == self.bands[0].sliding_angle_deg);
        let can_be_met = is_of_one && self.has_demands() && self.goal.is_none();
        let is_met = move |trial: &&Trial| {
            can_be_met && self.at_loads(trial, |at| at.measured).is_some_and(|ratios| self.accepts(&ratios))
        };
        self.learned.trials().iter().filter(is_met)
    }

    /// `value` of a trial's measurements at each load: interpolated between measured pressures, or that of the nearest
    /// pressure within [`END_MARGIN`]; `None` if a load was not measured.
    pub fn at_loads(&self, trial: &Trial, value: impl Fn(&Measured) -> f64) -> Option<Vec<f64>> {
        self.loads.iter().map(|load| measured_at(trial, load, &value)).collect()
    }
}

/// `value` of `trial` at `load`, see [`Asked::at_loads`].
fn measured_at(trial: &Trial, load: &Load, value: impl Fn(&Measured) -> f64) -> Option<f64> {
    let here = trial.measured.iter().filter(|at| {
        (at.load.speed_m_s / load.speed_m_s - 1.0).abs() <= SAME_SPEED
            && (at.load.humidity - load.humidity).abs() <= SAME_HUMIDITY
    });
    let mut known: Vec<(f64, f64)> = here.map(|at| (at.load.pressure_pa, value(at))).collect();
    known.sort_by(|a, b| a.0.total_cmp(&b.0));
    let p = load.pressure_pa;
    let between = known.windows(2).find_map(|pair| {
        let [from, to] = [pair[0], pair[1]];
        let is_between = from.0 < to.0 && (from.0..=to.0).contains(&p);
        is_between.then(|| from.1 + (to.1 - from.1) * (p - from.0) / (to.0 - from.0))
    });
    let nearest =
        known.iter().map(|(known_pa, ratio)| ((known_pa - p).abs(), *ratio)).min_by(|a, b| a.0.total_cmp(&b.0));
    between.or_else(|| nearest.filter(|(off_pa, _)| *off_pa <= END_MARGIN * p).map(|(_, ratio)| ratio))
}
