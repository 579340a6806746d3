//! Axes of plots: ranges and ticks.

pub(crate) use slipgrid_base::statistics::extremes;
use slipgrid_base::units::tidy;

/// Axis: title with unit, range, and ticks.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    pub(super) title: String,
    pub(super) range: [f64; 2],
    /// Position and text of each tick.
    pub(super) ticks: Vec<(f64, String)>,
}

impl Axis {
    /// Axis over all `values` with a margin on both sides.
    pub(super) fn around(title: &str, values: impl IntoIterator<Item = f64>) -> Self {
        const ROOM: f64 = 0.06;
        let [low, high] = extremes(values);
        // If all values are equal, any range around them will do.
        let room = if high > low { ROOM * (high - low) } else { 0.1 * high.abs().max(1e-3) };
        Self::over(title, [low - room, high + room])
    }

    /// Axis from zero to beyond all `values`.
    pub(super) fn from_zero(title: &str, values: impl IntoIterator<Item = f64>) -> Self {
        let high = extremes(values)[1];
        Self::over(title, [0.0, if high > 0.0 { 1.06 * high } else { 1.0 }])
    }

    /// Axis from zero if the smallest of `values` is at most half of the largest; otherwise from about the smallest, so
    /// that changes are visible.
    pub(super) fn as_needed(title: &str, values: impl IntoIterator<Item = f64> + Clone) -> Self {
        let [low, high] = extremes(values.clone());
        if low > 0.5 * high { Self::around(title, values) } else { Self::from_zero(title, values) }
    }

    /// Axis over exactly `range`.
    pub(super) fn over(title: &str, range: [f64; 2]) -> Self {
        let step = tick_step(range[1] - range[0]);
        // A step of 0.05 needs two decimals.
        let decimals = (-step.log10().floor()).max(0.0) as usize;
        let first = (range[0] / step - 1e-9).ceil();
        let count = (range[1] / step + 1e-9 - first).floor().max(0.0) as usize;
        let ticks = (0..=count)
            .map(|index| {
                let value = (first + index as f64) * step;
                // Adding zero turns a negative zero into a positive one.
                let text = format!("{:.decimals$}", if value.abs() < 1e-9 * step { 0.0 } else { value });
                (value, text)
            })
            .collect();
        Self { title: title.to_owned(), range, ticks }
    }

    /// Logarithmic axis over all `values`, which are decimal logarithms, with a margin on both sides; ticks show the
    /// numbers, not the logarithms.
    pub(super) fn logarithmic(title: &str, values: impl IntoIterator<Item = f64>) -> Self {
        const ROOM: f64 = 0.15;
        let [low, high] = extremes(values);
        let range = [low - ROOM, high + ROOM];
        // At most two decades leave room for 2 and 5 between powers of ten.
        let factors: &[f64] = if range[1] - range[0] > 2.5 { &[1.0] } else { &[1.0, 2.0, 5.0] };
        let powers = power(range[0].floor())..=power(range[1].ceil());
        let ticks = powers
            .flat_map(|power| factors.iter().map(move |factor| (f64::from(power) + factor.log10(), *factor, power)))
            .filter(|(log, ..)| (range[0]..=range[1]).contains(log))
            .map(|(log, factor, power)| {
                let decimals = (-power).max(0) as usize;
                (log, format!("{:.decimals$}", factor * 10_f64.powi(power)))
            })
            .collect();
        Self { title: title.to_owned(), range, ticks }
    }

    /// Logarithmic axis over all `values`, which are decimal logarithms and may span many decades; ticks are at most
    /// ten powers of ten, for example 1e-9.
    pub(super) fn powers(title: &str, values: impl IntoIterator<Item = f64>) -> Self {
        const ROOM: f64 = 0.3;
        const MAX_NUMBERS: i32 = 10;
        let [low, high] = extremes(values);
        let range = [low - ROOM, high + ROOM];
        let (first, last) = (power(range[0].ceil()), power(range[1].floor()));
        let step = ((last - first) / MAX_NUMBERS + 1).max(1);
        let ticks = (first..=last)
            .filter(|power| power.rem_euclid(step) == 0)
            .map(|power| (f64::from(power), format!("1e{power}")))
            .collect();
        Self { title: title.to_owned(), range, ticks }
    }

    /// Axis with ticks at `values` instead of round numbers; a value too close to the previous tick gets no tick.
    pub(super) fn numbered_at(self, values: &[f64]) -> Self {
        const GAP: f64 = 0.09;
        let mut ticks: Vec<(f64, String)> = Vec::new();
        let mut values = values.to_vec();
        values.sort_by(f64::total_cmp);
        for value in values {
            if ticks.last().is_none_or(|(before, _)| value - before > GAP * (self.range[1] - self.range[0])) {
                ticks.push((value, tidy(value).to_string()));
            }
        }
        Self { ticks, ..self }
    }

    /// Axis with ticks named by `names` at the positions 0, 1, 2, ...
    pub(super) fn of_names(title: &str, names: impl IntoIterator<Item: ToString>) -> Self {
        let names = names.into_iter().enumerate();
        let ticks: Vec<(f64, String)> = names.map(|(index, name)| (index as f64, name.to_string())).collect();
        Self { title: title.to_owned(), range: [-0.5, ticks.len() as f64 - 0.5], ticks }
    }

    /// Removes the title and the texts of the ticks.
    pub(super) fn unlabelled(mut self) -> Self {
        self.title.clear();
        for (_, text) in &mut self.ticks {
            text.clear();
        }
        self
    }

    /// Position of `value` relative to the range: 0 at the start and 1 at the end.
    pub(super) fn share(&self, value: f64) -> f64 {
        (value - self.range[0]) / (self.range[1] - self.range[0])
    }
}

/// Converts a whole decimal logarithm to an integer, limited to powers of finite numbers, so that an infinite end of a
/// range gives a limited number of ticks.
fn power(log: f64) -> i32 {
    log.clamp(-330.0, 330.0) as i32
}

/// Tick step of 1, 2 or 5 times a power of ten that divides `span` into three to nine intervals.
fn tick_step(span: f64) -> f64 {
    let rough = span / 6.0;
    let power = 10_f64.powf(rough.log10().floor());
    let factor = [1.0, 2.0, 5.0].into_iter().find(|factor| factor * power >= 0.7 * rough).unwrap_or(10.0);
    factor * power
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_numbers_within_the_range() {
        let texts = |range| Axis::over("", range).ticks.into_iter().map(|(_, text)| text).collect::<Vec<_>>();
        assert_eq!(texts([0.0, 3.0]), ["0.0", "0.5", "1.0", "1.5", "2.0", "2.5", "3.0"]);
        assert_eq!(texts([0.81, 1.02]), ["0.85", "0.90", "0.95", "1.00"]);
        assert_eq!(texts([-20.0, 40.0]), ["-20", "-10", "0", "10", "20", "30", "40"]);
    }

    #[test]
    fn logarithmic_ticks_are_powers_of_ten() {
        let texts = |range| Axis::logarithmic("", range).ticks.into_iter().map(|(_, text)| text).collect::<Vec<_>>();
        assert_eq!(texts([-2.0, 2.0]), ["0.01", "0.1", "1", "10", "100"]);
        assert_eq!(texts([-1.0, 0.1]), ["0.1", "0.2", "0.5", "1"]);
    }

    #[test]
    fn equal_values_still_span_an_axis() {
        for value in [0.0, 0.27, -3.0] {
            let axis = Axis::around("", [value, value]);
            assert!(axis.range[0] < value && value < axis.range[1]);
            assert!(!axis.ticks.is_empty());
        }
    }

    #[test]
    fn an_axis_has_numbers_at_given_values_that_are_not_crowded() {
        let axis = Axis::over("", [0.0, 3.0]).numbered_at(&[0.65, 1.3, 1.4, 2.6]);
        assert_eq!(axis.ticks, [0.65, 1.3, 2.6].map(|value| (value, value.to_string())));
    }
}
