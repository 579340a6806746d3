use super::canvas::{GREY, LEFT, Mark, NARROW, PALETTE, RIGHT, Swatch, WIDTH, picture_of_size};
use super::plot::{Axis, Plot};
use super::{ChartError, Estimate, check};

/// What was wanted, what the search predicts and what the confirming run found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TargetChart<'a> {
    /// Title.
    pub title: &'a str,
    /// Title of the vertical axis: what the target is about.
    pub quantity: &'a str,
    /// The target, pressures increasing.
    pub target: &'a [TargetPoint],
    /// Predicted: nominal pressure in MPa and value with its standard deviation.
    pub predicted: &'a [(f64, Estimate)],
    /// Confirmed: nominal pressure in MPa and value with its standard deviation.
    pub confirmed: &'a [(f64, Estimate)],
    /// The flat surface in the same quantity: nominal pressure in MPa and value with its standard deviation. May be empty.
    pub flat: &'a [(f64, Estimate)],
    /// Over all conditions: nominal pressure in MPa, lowest and highest value. Empty where there is one condition.
    pub spread: &'a [[f64; 3]],
}

/// One point of the target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TargetPoint {
    /// Nominal pressure, in MPa.
    pub pressure_mpa: f64,
    /// The value wanted; absent where a band is, or a goal alone.
    pub value: Option<f64>,
    /// Lowest accepted value, where there is one.
    pub lowest: Option<f64>,
    /// Highest accepted value, where there is one.
    pub highest: Option<f64>,
}

/// Height of the picture.
const HEIGHT: f64 = 500.0;
const BAND: f64 = 0.22;
/// From a mark to the error bar beside it where another's stands on it, in units of the page.
const BESIDE: f64 = 11.0;
/// Opacity of the spread over conditions, and the half width of its bars over that of the axis.
const SPREAD: f64 = 0.75;
const SPREAD_WIDTH: f64 = 0.007;
/// Draws target, prediction and confirmation against pressure.
///
/// # Errors
/// [`ChartError`] if there is no target or a value is not finite.
pub fn target(chart: &TargetChart<'_>) -> Result<String, ChartError> {
    target_of_width(chart, WIDTH)
}

/// The same for a phone.
///
/// # Errors
/// As [`target`].
pub fn target_narrow(chart: &TargetChart<'_>) -> Result<String, ChartError> {
    target_of_width(chart, NARROW)
}

/// Ends of the bar of a value with its error: friction and ratios are not negative.
fn ends_of(value: f64, error: f64) -> [f64; 2] {
    [(value - error).max(0.0), value + error]
}

fn target_of_width(chart: &TargetChart<'_>, width: f64) -> Result<String, ChartError> {
    check(chart.title, chart.target.iter().map(|point| &point.pressure_mpa))?;
    let estimates = || chart.predicted.iter().chain(chart.flat).chain(chart.confirmed);
    let bars = || {
        estimates().flat_map(|&(_, Estimate { value, error })| {
            let error = error.unwrap_or(0.0);
            ends_of(value, error)
        })
    };
    let limits = || chart.target.iter().flat_map(|point| [point.value, point.lowest, point.highest]).flatten();
    let pressures =
        || chart.target.iter().map(|point| point.pressure_mpa).chain(estimates().map(|(pressure, _)| *pressure));
    let ends = || chart.spread.iter().flat_map(|[_, low, high]| [*low, *high]);
    let values = || limits().chain(bars()).chain(ends());
    if let Some(value) = pressures().chain(values()).find(|value| !value.is_finite()) {
        return Err(ChartError::NotFinite { title: chart.title.to_owned(), value });
    }

    let [blue, vermilion, green, purple, ..] = PALETTE;
    let has_values = chart.target.iter().any(|point| point.value.is_some());
    let mut legend = Vec::new();
    if limits().next().is_some() {
        legend.push((Swatch::Band(green, BAND), if has_values { "target ± tolerance" } else { "accepted" }));
    }
    if has_values {
        legend.push((Swatch::Mark(Mark::Diamond, green), "target"));
    }
    if !chart.predicted.is_empty() {
        let bars = chart.predicted.iter().any(|(_, estimate)| estimate.error.is_some());
        let label = if bars { "predicted ± one standard deviation" } else { "predicted" };
        legend.push((Swatch::Mark(Mark::Ring, blue), label));
    }
    if !chart.confirmed.is_empty() {
        let bars = chart.confirmed.iter().any(|(_, estimate)| estimate.error.is_some());
        let label = if bars { "confirmed ± one standard deviation" } else { "confirmed" };
        legend.push((Swatch::Mark(Mark::Square, vermilion), label));
    }
    if !chart.spread.is_empty() {
        legend.push((Swatch::Band(purple, SPREAD), "all conditions"));
    }
    if !chart.flat.is_empty() {
        legend.push((Swatch::Line(GREY), "flat surface"));
    }

    // The band reaches a little beyond the first and the last pressure, so that marks lie on it.
    let (Some(first), Some(last)) = (chart.target.first(), chart.target.last()) else {
        return Err(ChartError::Empty { title: chart.title.to_owned() });
    };
    let (low_mpa, high_mpa) =
        pressures().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
    let beyond_mpa = if high_mpa > low_mpa { 0.03 * (high_mpa - low_mpa) } else { 0.01 * high_mpa.abs() };
    let ends = [(first, -beyond_mpa), (last, beyond_mpa)]
        .map(|(point, beyond_mpa)| TargetPoint { pressure_mpa: point.pressure_mpa + beyond_mpa, ..*point });
    let widened = || ends[..1].iter().chain(chart.target).chain(&ends[1..]);
    // A band that is open to one side reaches a little beyond everything drawn.
    let (low, high) = values().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    let beyond = 0.05 * (high - low).max(0.02 * high.abs());
    let is_open = |point: &TargetPoint| point.lowest.is_some() != point.highest.is_some();
    let [below, above] = [low - beyond, high + beyond];
    let opened = chart.target.iter().filter(|point| is_open(point)).flat_map(|_| [below, above]);
    let is_banded = |point: &&TargetPoint| point.lowest.is_some() || point.highest.is_some();
    let lower = widened().filter(is_banded).map(|point| [point.pressure_mpa, point.lowest.unwrap_or(below)]);
    let upper = widened().filter(is_banded).map(|point| [point.pressure_mpa, point.highest.unwrap_or(above)]);
    let band: Vec<[f64; 2]> = lower.chain(upper.rev()).collect();

    let x_axis = Axis::around("nominal pressure (MPa)", pressures());
    let y_axis = Axis::around(chart.quantity, values().chain(opened));
    picture_of_size([width, HEIGHT], |canvas| {
        let top = canvas.heading(chart.title, &legend)?;
        let plot = Plot::new(canvas, [LEFT, top, width - RIGHT, HEIGHT - 62.0], x_axis, y_axis)?;
        if !band.is_empty() {
            plot.polygon(&band, green, BAND)?;
        }
        let flat: Vec<[f64; 2]> = chart.flat.iter().map(|(pressure, estimate)| [*pressure, estimate.value]).collect();
        plot.line(&flat, GREY, 1.6)?;
        for &(pressure, estimate) in chart.flat {
            if let Some(error) = estimate.error {
                plot.bar(pressure, ends_of(estimate.value, error), 0.0, GREY)?;
            }
            plot.mark(Mark::Triangle, [pressure, estimate.value], None, 0.0, GREY)?;
        }
        let at = |point: &TargetPoint| Some([point.pressure_mpa, point.value?]);
        let wanted: Vec<[f64; 2]> = widened().filter_map(at).collect();
        plot.line(&wanted, green, 1.6)?;
        for point in chart.target.iter().filter_map(at) {
            plot.mark(Mark::Diamond, point, None, 0.0, green)?;
        }
        // Behind the marks: beside their error bars, and wider.
        let half_mpa = SPREAD_WIDTH * if high_mpa > low_mpa { high_mpa - low_mpa } else { 0.1 * high_mpa.abs() };
        for &[pressure, low, high] in chart.spread {
            let [left, right] = [pressure - half_mpa, pressure + half_mpa];
            plot.polygon(&[[left, low], [right, low], [right, high], [left, high]], purple, SPREAD)?;
        }
        for &(pressure, estimate) in chart.confirmed {
            if let Some(error) = estimate.error {
                plot.bar(pressure, ends_of(estimate.value, error), 0.0, vermilion)?;
            }
            plot.mark(Mark::Square, [pressure, estimate.value], None, 0.0, vermilion)?;
        }
        for &(pressure, estimate) in chart.predicted {
            plot.mark(Mark::Ring, [pressure, estimate.value], None, 0.0, blue)?;
            if let Some(error) = estimate.error {
                plot.bar(pressure, ends_of(estimate.value, error), -BESIDE, blue)?;
            }
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const TARGET: [TargetPoint; 2] = [
        TargetPoint { pressure_mpa: 0.65, value: Some(0.97), lowest: Some(0.96), highest: Some(0.98) },
        TargetPoint { pressure_mpa: 2.6, value: Some(0.83), lowest: Some(0.82), highest: Some(0.84) },
    ];

    #[test]
    fn only_what_is_there_stands_in_the_legend() {
        let bare = TargetChart {
            title: "Target",
            quantity: "friction ratio",
            target: &TARGET,
            predicted: &[],
            confirmed: &[],
            flat: &[],
            spread: &[],
        };
        let svg = target(&bare).unwrap();
        assert!(svg.contains("\ntarget ± tolerance\n") && svg.contains("\nfriction ratio\n"));
        assert!(!svg.contains("\npredicted\n") && !svg.contains("\nflat surface\n"));
        let confirmed = [(0.65, Estimate { value: 0.971, error: Some(0.002) })];
        let alone = |value| [(0.65, Estimate { value, error: None })];
        let full = TargetChart { predicted: &alone(0.972), confirmed: &confirmed, flat: &alone(1.0), ..bare };
        let svg = target(&full).unwrap();
        assert!(svg.contains("\npredicted\n") && svg.contains("\nconfirmed ± one standard deviation\n"));
        assert!(svg.contains("\nflat surface\n"));
        assert!(!svg.contains("\nall conditions\n"));
        let wide = target(&TargetChart { spread: &[[0.65, 0.955, 0.985], [2.6, 0.8, 0.81]], ..full }).unwrap();
        assert!(wide.contains("\nall conditions\n"));
        assert_eq!(wide.matches("<polygon").count(), svg.matches("<polygon").count() + 2);
        // One point of the target is drawn as well.
        assert!(target(&TargetChart { target: &TARGET[..1], ..full }).is_ok());
    }

    #[test]
    fn bands_may_be_open_and_goals_have_none() {
        let predicted =
            [(0.65, 0.9), (2.6, 0.7)].map(|(pressure, value)| (pressure, Estimate { value, error: Some(0.02) }));
        let chart = |target: &[TargetPoint]| {
            let chart = TargetChart {
                title: "t",
                quantity: "q",
                target,
                predicted: &predicted,
                confirmed: &[],
                flat: &[],
                spread: &[],
            };
            super::target(&chart).unwrap()
        };
        let open = TARGET.map(|point| TargetPoint { value: None, lowest: None, ..point });
        let svg = chart(&open);
        assert!(svg.contains("\naccepted\n") && svg.contains("<polygon") && !svg.contains("\ntarget\n"));
        let free = open.map(|point| TargetPoint { highest: None, ..point });
        let svg = chart(&free);
        assert!(!svg.contains("accepted") && svg.contains("\npredicted ± one standard deviation\n"));
    }

    #[test]
    fn bars_end_at_nil() {
        assert_eq!(ends_of(0.3, 0.4), [0.0, 0.7]);
        assert_eq!(ends_of(0.5, 0.25), [0.25, 0.75]);
    }

    #[test]
    fn a_target_without_points_is_refused() {
        let chart = TargetChart {
            title: "t",
            quantity: "q",
            target: &[],
            predicted: &[],
            confirmed: &[],
            flat: &[],
            spread: &[],
        };
        assert!(matches!(target(&chart), Err(ChartError::Empty { .. })));
    }
}
