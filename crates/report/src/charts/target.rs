use super::canvas::{GREY, LEFT, Mark, NARROW, PALETTE, RIGHT, Swatch, WIDTH, picture_of_size};
use super::plot::{Axis, Plot};
use super::{ChartError, check};

/// Target and expected friction of a cut sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TargetChart<'a> {
    /// Title.
    pub title: &'a str,
    /// Title of the vertical axis: the target's quantity.
    pub quantity: &'a str,
    /// The target, pressures increasing.
    pub target: &'a [TargetPoint],
    /// Expected values of cut samples.
    pub samples: &'a [SamplePoint],
    /// Flat surface in the target's quantity: nominal pressure in MPa and value. May be empty.
    pub flat: &'a [[f64; 2]],
    /// Values measured in trials, of any texture: nominal pressure in MPa and value. May be empty.
    pub measured: &'a [[f64; 2]],
}

/// Point of the target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TargetPoint {
    /// Nominal pressure, in MPa.
    pub pressure_mpa: f64,
    /// Target value; `None` for a band or a goal without a value.
    pub value: Option<f64>,
    /// Lowest accepted value, if there is one.
    pub lowest: Option<f64>,
    /// Highest accepted value, if there is one.
    pub highest: Option<f64>,
}

/// Expected value of cut samples at one load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SamplePoint {
    /// Nominal pressure, in MPa.
    pub pressure_mpa: f64,
    /// Index of the condition, from 0; conditions stand side by side.
    pub condition: usize,
    /// Median.
    pub median: f64,
    /// Interval that contains 95 % of samples.
    pub interval_95: [f64; 2],
    /// Prediction of the model alone, if known in the target's quantity.
    pub model: Option<f64>,
}

/// Height of the picture.
const HEIGHT: f64 = 500.0;
/// Opacity of the accepted band and of the sample intervals.
const BAND: f64 = 0.22;
const INTERVAL: f64 = 0.4;
/// Half the width of an interval bar, and the distance between conditions, relative to the range of pressures.
const HALF_BAR: f64 = 0.012;
const CONDITION_STEP: f64 = 0.04;

/// Draws the target and the expected value of a cut sample against pressure.
///
/// # Errors
/// [`ChartError`] if there is no target or a value is not finite.
pub fn target(chart: &TargetChart<'_>) -> Result<String, ChartError> {
    target_of_width(chart, WIDTH)
}

/// Draws [`target`] for a narrow column or a phone.
///
/// # Errors
/// Same as [`target`].
pub fn target_narrow(chart: &TargetChart<'_>) -> Result<String, ChartError> {
    target_of_width(chart, NARROW)
}

fn target_of_width(chart: &TargetChart<'_>, width: f64) -> Result<String, ChartError> {
    check(chart.title, chart.target.iter().map(|point| &point.pressure_mpa))?;
    let limits = || chart.target.iter().flat_map(|point| [point.value, point.lowest, point.highest]).flatten();
    let of_samples = || {
        chart
            .samples
            .iter()
            .flat_map(|at| [at.median, at.interval_95[0], at.interval_95[1]].into_iter().chain(at.model))
    };
    let values =
        || limits().chain(of_samples()).chain(chart.flat.iter().chain(chart.measured).map(|[_, value]| *value));
    let pressures = || {
        let of_samples = chart.samples.iter().map(|at| at.pressure_mpa);
        chart
            .target
            .iter()
            .map(|point| point.pressure_mpa)
            .chain(of_samples)
            .chain(chart.flat.iter().chain(chart.measured).map(|[p, _]| *p))
    };
    if let Some(value) = pressures().chain(values()).find(|value| !value.is_finite()) {
        return Err(ChartError::NotFinite { title: chart.title.to_owned(), value });
    }

    let [blue, vermilion, green, purple, ..] = PALETTE;
    // In an order that fills the rows of a narrow picture.
    let has_model = chart.samples.iter().any(|at| at.model.is_some());
    let legend: Vec<(Swatch, &str)> = [
        (limits().next().is_some(), Swatch::Band(green, BAND), "accepted"),
        (!chart.samples.is_empty(), Swatch::Mark(Mark::Circle, vermilion), "expected"),
        (!chart.flat.is_empty(), Swatch::Line(GREY), "flat"),
        (!chart.samples.is_empty(), Swatch::Band(vermilion, INTERVAL), "95 % of samples"),
        (has_model, Swatch::Mark(Mark::Ring, blue), "model alone"),
        (!chart.measured.is_empty(), Swatch::Mark(Mark::Square, purple), "earlier trials"),
    ]
    .into_iter()
    .filter_map(|(is_drawn, swatch, label)| is_drawn.then_some((swatch, label)))
    .collect();

    // The band extends slightly beyond the first and the last pressure, so that it surrounds the marks.
    let (Some(first), Some(last)) = (chart.target.first(), chart.target.last()) else {
        return Err(ChartError::Empty { title: chart.title.to_owned() });
    };
    let (low_mpa, high_mpa) =
        pressures().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
    let range_mpa = if high_mpa > low_mpa { high_mpa - low_mpa } else { 0.3 * high_mpa.abs() };
    let conditions = chart.samples.iter().map(|at| at.condition + 1).max().unwrap_or(1);
    let shift_mpa =
        |condition: usize| CONDITION_STEP * range_mpa * (condition as f64 - 0.5 * (conditions as f64 - 1.0));
    let beyond_mpa = 0.03 * range_mpa + shift_mpa(conditions - 1);
    let ends = [(first, -beyond_mpa), (last, beyond_mpa)]
        .map(|(point, beyond_mpa)| TargetPoint { pressure_mpa: point.pressure_mpa + beyond_mpa, ..*point });
    let widened = || ends[..1].iter().chain(chart.target).chain(&ends[1..]);
    // A one-sided band extends slightly beyond all drawn values.
    let (low, high) = values().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    let beyond = 0.05 * (high - low).max(0.02 * high.abs());
    let is_open = |point: &TargetPoint| point.lowest.is_some() != point.highest.is_some();
    let [below, above] = [low - beyond, high + beyond];
    let opened = chart.target.iter().filter(|point| is_open(point)).flat_map(|_| [below, above]);
    let is_banded = |point: &&TargetPoint| point.lowest.is_some() || point.highest.is_some();
    let lower = widened().filter(is_banded).map(|point| [point.pressure_mpa, point.lowest.unwrap_or(below)]);
    let upper = widened().filter(is_banded).map(|point| [point.pressure_mpa, point.highest.unwrap_or(above)]);
    let band: Vec<[f64; 2]> = lower.chain(upper.rev()).collect();

    // Conditions of a single pressure stand near its middle.
    let around = if high_mpa > low_mpa { 0.0 } else { range_mpa };
    let reached = ends.iter().zip([-around, around]).map(|(end, beyond_mpa)| end.pressure_mpa + beyond_mpa);
    let own: Vec<f64> = chart.target.iter().map(|point| point.pressure_mpa).collect();
    let x_axis = Axis::around("nominal pressure (MPa)", pressures().chain(reached)).numbered_at(&own);
    let y_axis = Axis::around(chart.quantity, values().chain(opened));
    picture_of_size([width, HEIGHT], |canvas| {
        let top = canvas.heading(chart.title, &legend)?;
        let plot = Plot::new(canvas, [LEFT, top, width - RIGHT, HEIGHT - 62.0], x_axis, y_axis)?;
        if !band.is_empty() {
            plot.polygon(&band, green, BAND)?;
        }
        plot.line(chart.flat, GREY, 1.6)?;
        for point in chart.flat {
            plot.mark(Mark::Triangle, *point, None, 0.0, GREY)?;
        }
        let wanted: Vec<[f64; 2]> = widened().filter_map(|point| Some([point.pressure_mpa, point.value?])).collect();
        plot.line(&wanted, green, 1.6)?;
        for at in chart.samples {
            let pressure_mpa = at.pressure_mpa + shift_mpa(at.condition);
            let [left, right] = [-1.0, 1.0].map(|side| pressure_mpa + side * HALF_BAR * range_mpa);
            let [low, high] = at.interval_95;
            plot.polygon(&[[left, low], [right, low], [right, high], [left, high]], vermilion, INTERVAL)?;
            plot.mark(Mark::Circle, [pressure_mpa, at.median], None, 0.0, vermilion)?;
            if let Some(model) = at.model {
                plot.mark(Mark::Ring, [pressure_mpa, model], None, 0.0, blue)?;
            }
        }
        for point in chart.measured {
            plot.mark(Mark::Square, *point, None, 0.0, purple)?;
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
    const SAMPLE: SamplePoint =
        SamplePoint { pressure_mpa: 0.65, condition: 0, median: 0.95, interval_95: [0.9, 0.99], model: None };

    fn chart<'a>(target: &'a [TargetPoint], samples: &'a [SamplePoint], flat: &'a [[f64; 2]]) -> TargetChart<'a> {
        TargetChart { title: "Target", quantity: "friction ratio", target, samples, flat, measured: &[] }
    }

    #[test]
    fn only_what_is_there_stands_in_the_legend() {
        let svg = target(&chart(&TARGET, &[], &[])).unwrap();
        assert!(svg.contains("\naccepted\n") && svg.contains("\nfriction ratio\n"));
        for absent in ["expected", "model alone", "flat", "earlier trials"] {
            assert!(!svg.contains(&format!("\n{absent}\n")), "{absent}");
        }
        let samples = [SamplePoint { model: Some(0.96), ..SAMPLE }];
        let full = TargetChart { measured: &[[1.3, 0.9]], ..chart(&TARGET, &samples, &[[0.65, 1.0]]) };
        let full = target(&full).unwrap();
        for present in ["expected", "95 % of samples", "model alone", "flat", "earlier trials"] {
            assert!(full.contains(&format!("\n{present}\n")), "{present}");
        }
        // Every series stands at its own pressure, and a ring leaves the mark inside it visible.
        let circles: Vec<&str> = full.split("<circle ").skip(1).filter_map(|rest| rest.split('"').nth(1)).collect();
        assert_eq!(circles.len(), 4, "two in the legend, two in the plot");
        assert_eq!(circles[2], circles[3]);
        // A target with a single point is drawn as well.
        assert!(target(&chart(&TARGET[..1], &samples, &[])).is_ok());
    }

    #[test]
    fn conditions_stand_side_by_side() {
        let bars = |samples: &[SamplePoint]| {
            let svg = target(&chart(&TARGET, samples, &[])).unwrap();
            svg.matches("<polygon").count()
        };
        let both = [SAMPLE, SamplePoint { condition: 1, ..SAMPLE }];
        assert_eq!(bars(&both), bars(&[SAMPLE]) + 1);
        let svg = target(&chart(&TARGET, &both, &[])).unwrap();
        let circles: Vec<&str> = svg.split("<circle ").skip(1).filter_map(|rest| rest.split(' ').next()).collect();
        assert!(circles.iter().collect::<std::collections::BTreeSet<_>>().len() >= 3, "{circles:?}");
    }

    #[test]
    fn bands_may_be_open_and_goals_have_none() {
        let open = TARGET.map(|point| TargetPoint { value: None, lowest: None, ..point });
        let svg = target(&chart(&open, &[SAMPLE], &[])).unwrap();
        assert!(svg.contains("\naccepted\n") && svg.contains("<polygon"));
        let free = open.map(|point| TargetPoint { highest: None, ..point });
        let svg = target(&chart(&free, &[SAMPLE], &[])).unwrap();
        assert!(!svg.contains("accepted") && svg.contains("\n95 % of samples\n"));
    }

    #[test]
    fn a_target_without_points_is_refused() {
        assert!(matches!(target(&chart(&[], &[], &[])), Err(ChartError::Empty { .. })));
        let odd = [SamplePoint { median: f64::NAN, ..SAMPLE }];
        assert!(matches!(target(&chart(&TARGET, &odd, &[])), Err(ChartError::NotFinite { .. })));
    }
}
