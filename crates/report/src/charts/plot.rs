//! Axes, and values drawn within them.

use plotters::style::RGBColor;
use plotters::style::text_anchor::{HPos, VPos};
use slipgrid_base::units::tidy;

use super::ChartError;
use super::canvas::{Canvas, GREY, GRID, INK, Mark};

/// Axis: title with unit, range, and positions of numbers.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    title: String,
    range: [f64; 2],
    ticks: Vec<(f64, String)>,
}

impl Axis {
    /// Axis over all `values` with a margin on both sides.
    pub(super) fn around(title: &str, values: impl IntoIterator<Item = f64>) -> Self {
        const ROOM: f64 = 0.06;
        let [low, high] = extremes(values);
        // All values equal: any range around them.
        let room = if high > low { ROOM * (high - low) } else { 0.1 * high.abs().max(1e-3) };
        Self::over(title, [low - room, high + room])
    }

    /// Axis from zero to beyond all `values`.
    pub(super) fn from_zero(title: &str, values: impl IntoIterator<Item = f64>) -> Self {
        let high = extremes(values)[1];
        Self::over(title, [0.0, if high > 0.0 { 1.06 * high } else { 1.0 }])
    }

    /// Axis from zero if some `values` are less than half of the maximum; otherwise from about the minimum, so that changes are visible.
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

    /// Logarithmic axis over all `values`, which are decimal logarithms, with a margin on both sides; its numbers are
    /// not logarithms.
    pub(super) fn logarithmic(title: &str, values: impl IntoIterator<Item = f64>) -> Self {
        const ROOM: f64 = 0.15;
        let [low, high] = extremes(values);
        let range = [low - ROOM, high + ROOM];
        // At most two decades leave room for 2 and 5 between powers of ten.
        let factors: &[f64] = if range[1] - range[0] > 2.5 { &[1.0] } else { &[1.0, 2.0, 5.0] };
        let powers = (range[0].floor() as i32)..=(range[1].ceil() as i32);
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

    /// Logarithmic axis over all `values`, which are decimal logarithms and may span many decades; its numbers are every power
    /// of ten or every few, for example 1e-9.
    pub(super) fn powers(title: &str, values: impl IntoIterator<Item = f64>) -> Self {
        const ROOM: f64 = 0.3;
        const MAX_NUMBERS: i32 = 10;
        let [low, high] = extremes(values);
        let range = [low - ROOM, high + ROOM];
        let (first, last) = (range[0].ceil() as i32, range[1].floor() as i32);
        let step = ((last - first) / MAX_NUMBERS + 1).max(1);
        let ticks = (first..=last)
            .filter(|power| power.rem_euclid(step) == 0)
            .map(|power| (f64::from(power), format!("1e{power}")))
            .collect();
        Self { title: title.to_owned(), range, ticks }
    }

    /// Axis with numbers at `values` in place of round ones; a value too near the one before has none.
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

    /// Positions and texts of the numbers.
    pub(super) fn numbers(&self) -> impl Iterator<Item = (f64, &str)> {
        self.ticks.iter().map(|(value, text)| (*value, text.as_str()))
    }

    /// Axis with names at positions 0, 1, 2, ...
    pub(super) fn of_names(title: &str, names: Vec<String>) -> Self {
        let range = [-0.5, names.len() as f64 - 0.5];
        let ticks = names.into_iter().enumerate().map(|(index, name)| (index as f64, name)).collect();
        Self { title: title.to_owned(), range, ticks }
    }

    /// Removes numbers and title from the axis.
    pub(super) fn unlabelled(mut self) -> Self {
        self.title.clear();
        for (_, text) in &mut self.ticks {
            text.clear();
        }
        self
    }

    fn share(&self, value: f64) -> f64 {
        (value - self.range[0]) / (self.range[1] - self.range[0])
    }
}

/// Minimum and maximum of `values`.
fn extremes(values: impl IntoIterator<Item = f64>) -> [f64; 2] {
    values.into_iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)])
}

/// Step of 1, 2 or 5 times a power of ten that divides `span` into four to nine.
fn tick_step(span: f64) -> f64 {
    let rough = span / 6.0;
    let power = 10_f64.powf(rough.log10().floor());
    let factor = [1.0, 2.0, 5.0].into_iter().find(|factor| factor * power >= 0.7 * rough).unwrap_or(10.0);
    factor * power
}

/// Rectangle of the page with axes.
pub(super) struct Plot<'c, 'a> {
    canvas: &'c Canvas<'a>,
    /// Left, top, right, bottom on the page.
    frame: [f64; 4],
    x: Axis,
    y: Axis,
}

impl<'c, 'a> Plot<'c, 'a> {
    /// Draws the axes of a plot within `frame` (left, top, right, bottom).
    pub(super) fn new(canvas: &'c Canvas<'a>, frame: [f64; 4], x: Axis, y: Axis) -> Result<Self, ChartError> {
        let plot = Self { canvas, frame, x, y };
        plot.axes()?;
        Ok(plot)
    }

    fn axes(&self) -> Result<(), ChartError> {
        let [left, top, right, bottom] = self.frame;
        for (value, text) in &self.x.ticks {
            let x = self.at([*value, self.y.range[0]])[0];
            self.canvas.line(&[[x, top], [x, bottom]], GRID, 1.0)?;
            self.canvas.text(text, [x, bottom + 7.0], (HPos::Center, VPos::Top), INK)?;
        }
        for (value, text) in &self.y.ticks {
            let y = self.at([self.x.range[0], *value])[1];
            self.canvas.line(&[[left, y], [right, y]], GRID, 1.0)?;
            self.canvas.text(text, [left - 9.0, y], (HPos::Right, VPos::Center), INK)?;
        }
        self.canvas.line(&[[left, top], [left, bottom], [right, bottom]], INK, 1.2)?;
        let middle = [(left + right) / 2.0, (top + bottom) / 2.0];
        self.canvas.text(&self.x.title, [middle[0], bottom + 32.0], (HPos::Center, VPos::Top), INK)?;
        self.canvas.upward_text(&self.y.title, [left - 74.0, middle[1]])
    }

    /// Position of a value on the page.
    pub(super) fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [left, top, right, bottom] = self.frame;
        [left + self.x.share(x) * (right - left), bottom - self.y.share(y) * (bottom - top)]
    }

    fn all_at(&self, points: &[[f64; 2]]) -> Vec<[f64; 2]> {
        points.iter().map(|&point| self.at(point)).collect()
    }

    /// Draws a line through points; dense points are reduced to their extremes.
    pub(super) fn line(&self, points: &[[f64; 2]], color: RGBColor, width: f64) -> Result<(), ChartError> {
        self.canvas.line(&thinned(&self.all_at(points)), color, width)
    }

    /// Draws a straight dashed line.
    pub(super) fn dashed(&self, ends: [[f64; 2]; 2], color: RGBColor) -> Result<(), ChartError> {
        self.canvas.dashed(ends.map(|end| self.at(end)), color, 2.0)
    }

    /// Draws a vertical dashed line over the height of the plot, with a label at its top.
    pub(super) fn vertical(&self, x: f64, text: &str) -> Result<(), ChartError> {
        let [top, bottom] = [self.at([x, self.y.range[1]]), self.at([x, self.y.range[0]])];
        self.canvas.dashed([bottom, top], GREY, 1.2)?;
        self.canvas.text(text, [top[0] + 6.0, top[1] + 10.0], (HPos::Left, VPos::Center), GREY)
    }

    /// Draws a horizontal dashed line over the width of the plot.
    pub(super) fn horizontal(&self, y: f64, color: RGBColor) -> Result<(), ChartError> {
        self.dashed([[self.x.range[0], y], [self.x.range[1], y]], color)
    }

    /// Shades a span of x over the height of the plot.
    pub(super) fn span(&self, [from, to]: [f64; 2], color: RGBColor, opacity: f64) -> Result<(), ChartError> {
        let [from, to] = [from, to].map(|x| x.clamp(self.x.range[0], self.x.range[1]));
        let corners = [self.at([from, self.y.range[1]]), self.at([to, self.y.range[0]])];
        self.canvas.rectangle(corners, color, opacity)
    }

    /// Draws a filled polygon.
    pub(super) fn polygon(&self, points: &[[f64; 2]], color: RGBColor, opacity: f64) -> Result<(), ChartError> {
        self.canvas.polygon(&self.all_at(points), color, opacity)
    }

    /// Draws a mark, offset horizontally by `aside` picture units, with its error bar.
    pub(super) fn mark(
        &self,
        mark: Mark,
        [x, y]: [f64; 2],
        error: Option<f64>,
        aside: f64,
        color: RGBColor,
    ) -> Result<(), ChartError> {
        if let Some(error) = error {
            self.error_bar([x, y], error, aside, color)?;
        }
        let [page_x, page_y] = self.at([x, y]);
        self.canvas.mark(mark, [page_x + aside, page_y], color)
    }

    /// Draws a bar of `error` on both sides of y, offset horizontally by `aside` picture units.
    pub(super) fn error_bar(
        &self,
        [x, y]: [f64; 2],
        error: f64,
        aside: f64,
        color: RGBColor,
    ) -> Result<(), ChartError> {
        self.bar(x, [y - error, y + error], aside, color)
    }

    /// Draws a bar between two values, offset horizontally by `aside` picture units.
    pub(super) fn bar(&self, x: f64, ends: [f64; 2], aside: f64, color: RGBColor) -> Result<(), ChartError> {
        const CAP: f64 = 4.0;
        let [low, high] = ends.map(|y| {
            let [page_x, page_y] = self.at([x, y]);
            [page_x + aside, page_y]
        });
        self.canvas.line(&[low, high], color, 1.6)?;
        for end in [low, high] {
            self.canvas.line(&[[end[0] - CAP, end[1]], [end[0] + CAP, end[1]]], color, 1.6)?;
        }
        Ok(())
    }

    /// Writes text at the right edge of the plot, at page height `page_y`.
    pub(super) fn margin_text(&self, text: &str, page_y: f64) -> Result<(), ChartError> {
        self.canvas.text(text, [self.frame[2] + 8.0, page_y], (HPos::Left, VPos::Center), INK)
    }
}

/// Keeps only the first, the extreme and the last points within each unit of x, in order, which leaves the visible line
/// unchanged: a unit is at most a pixel where pages show a picture.
fn thinned(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    const BIN: f64 = 1.0;
    let bin = |point: &[f64; 2]| (point[0] / BIN).floor();
    let mut kept = Vec::new();
    for group in points.chunk_by(|a, b| bin(a) == bin(b)) {
        let extreme = |better: fn(f64, f64) -> bool| {
            (1..group.len()).fold(0, |best, i| if better(group[i][1], group[best][1]) { i } else { best })
        };
        let mut indices = [0, extreme(|a, b| a < b), extreme(|a, b| a > b), group.len() - 1];
        indices.sort_unstable();
        for (position, &index) in indices.iter().enumerate() {
            if position == 0 || indices[position - 1] != index {
                kept.push(group[index]);
            }
        }
    }
    kept
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
        assert_eq!(axis.numbers().collect::<Vec<_>>(), [(0.65, "0.65"), (1.3, "1.3"), (2.6, "2.6")]);
    }

    #[test]
    fn thinning_keeps_extremes_and_short_lines_whole() {
        let points: Vec<[f64; 2]> = (0..100_000).map(|i| [f64::from(i) * 1e-3, f64::from(i * 7919 % 1000)]).collect();
        let kept = thinned(&points);
        assert!(kept.len() <= 404);
        let high = |points: &[[f64; 2]]| points.iter().map(|p| p[1]).fold(0.0, f64::max);
        assert_eq!(high(&kept), high(&points));
        assert_eq!((kept[0], kept[kept.len() - 1]), (points[0], points[99_999]));
        assert!(kept.windows(2).all(|pair| pair[0][0] <= pair[1][0]));
        let few = [[0.0, 1.0], [5.0, 2.0], [9.0, 0.0]];
        assert_eq!(thinned(&few), few);
    }
}
