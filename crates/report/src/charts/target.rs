//! Chart of a target, and of the expected friction of a cut sample.

use super::ChartError;
use super::axis::{Axis, extremes};
use super::canvas::{GREY, Mark, PALETTE, Swatch};
use super::chart::{Chart, Layer};

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
    /// Value of the flat surface, if known.
    pub flat: Option<f64>,
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

/// Opacity of the accepted band and of the sample intervals.
const BAND: f64 = 0.22;
const INTERVAL: f64 = 0.4;
/// Half the width of an interval bar, and the distance between conditions, relative to the range of pressures.
const HALF_BAR: f64 = 0.012;
const CONDITION_STEP: f64 = 0.04;

/// Draws the points of a target, whose pressures increase, and the expected values of cut `samples` against pressure; `quantity`
/// is the title of the vertical axis. `measured` are nominal pressures in MPa and values of trials, of any texture. Without a
/// title, the picture is for a narrow column or a phone.
///
/// # Errors
/// [`ChartError`] if there is no target or a value is not finite.
pub fn target(
    title: &str,
    quantity: &str,
    points: &[TargetPoint],
    samples: &[SamplePoint],
    measured: &[[f64; 2]],
) -> Result<String, ChartError> {
    let (Some(first), Some(last)) = (points.first(), points.last()) else {
        return Err(ChartError::Empty { title: title.to_owned() });
    };
    let flat: Vec<[f64; 2]> = points.iter().filter_map(|point| Some([point.pressure_mpa, point.flat?])).collect();
    let limits = || points.iter().flat_map(|point| [point.value, point.lowest, point.highest]).flatten();
    let of_samples = || samples.iter().flat_map(|at| [at.median].into_iter().chain(at.interval_95).chain(at.model));
    let values = || limits().chain(of_samples()).chain(flat.iter().chain(measured).map(|[_, value]| *value));
    let pressures = || {
        let of_samples = samples.iter().map(|at| at.pressure_mpa).chain(measured.iter().map(|[p, _]| *p));
        points.iter().map(|point| point.pressure_mpa).chain(of_samples)
    };

    let [blue, vermilion, green, purple, ..] = PALETTE;
    // In an order that fills the rows of a narrow picture.
    let has_model = samples.iter().any(|at| at.model.is_some());
    let legend = [
        (limits().next().is_some(), Swatch::Band(green, BAND), "accepted"),
        (!samples.is_empty(), Swatch::Mark(Mark::Circle, vermilion), "expected"),
        (!flat.is_empty(), Swatch::Line(GREY), "flat"),
        (!samples.is_empty(), Swatch::Band(vermilion, INTERVAL), "95 % of samples"),
        (has_model, Swatch::Mark(Mark::Ring, blue), "model alone"),
        (!measured.is_empty(), Swatch::Mark(Mark::Square, purple), "earlier trials"),
    ];
    let legend =
        legend.into_iter().filter(|(is_drawn, ..)| *is_drawn).map(|(_, swatch, label)| (swatch, label)).collect();

    // The band extends slightly beyond the first and the last pressure, so that it surrounds the marks.
    let [low_mpa, high_mpa] = extremes(pressures());
    let range_mpa = if high_mpa > low_mpa { high_mpa - low_mpa } else { 0.3 * high_mpa.abs() };
    let conditions = samples.iter().map(|at| at.condition + 1).max().unwrap_or(1);
    let shift_mpa =
        |condition: usize| CONDITION_STEP * range_mpa * (condition as f64 - 0.5 * (conditions as f64 - 1.0));
    let beyond_mpa = 0.03 * range_mpa + shift_mpa(conditions - 1);
    let ends = [(first, -beyond_mpa), (last, beyond_mpa)]
        .map(|(point, beyond_mpa)| TargetPoint { pressure_mpa: point.pressure_mpa + beyond_mpa, ..*point });
    let widened = || ends[..1].iter().chain(points).chain(&ends[1..]);
    // A one-sided band extends slightly beyond all drawn values.
    let [low, high] = extremes(values());
    let beyond = 0.05 * (high - low).max(0.02 * high.abs());
    let [below, above] = [low - beyond, high + beyond];
    let is_open = points.iter().any(|point| point.lowest.is_some() != point.highest.is_some());
    let opened = [below, above].into_iter().filter(|_| is_open);
    let banded = || widened().filter(|point| point.lowest.is_some() || point.highest.is_some());
    let lower = banded().map(|point| [point.pressure_mpa, point.lowest.unwrap_or(below)]);
    let upper = banded().map(|point| [point.pressure_mpa, point.highest.unwrap_or(above)]);
    let band: Vec<[f64; 2]> = lower.chain(upper.rev()).collect();

    // Conditions of a single pressure stand near its middle.
    let around = if high_mpa > low_mpa { 0.0 } else { range_mpa };
    let reached = ends.iter().zip([-around, around]).map(|(end, beyond_mpa)| end.pressure_mpa + beyond_mpa);
    let own: Vec<f64> = points.iter().map(|point| point.pressure_mpa).collect();
    let x_axis = Axis::around("nominal pressure (MPa)", pressures().chain(reached)).numbered_at(&own);
    let y_axis = Axis::around(quantity, values().chain(opened));
    let wanted = widened().filter_map(|point| Some([point.pressure_mpa, point.value?])).collect();
    let of_sample = |at: &SamplePoint| {
        let pressure_mpa = at.pressure_mpa + shift_mpa(at.condition);
        let [left, right] = [-1.0, 1.0].map(|side| pressure_mpa + side * HALF_BAR * range_mpa);
        let [low, high] = at.interval_95;
        [
            Layer::Area(vec![[left, low], [right, low], [right, high], [left, high]], vermilion, INTERVAL),
            Layer::marks(Mark::Circle, [[pressure_mpa, at.median]], vermilion),
            Layer::marks(Mark::Ring, at.model.map(|model| [pressure_mpa, model]), blue),
        ]
    };
    let layers = [
        Layer::Area(band, green, BAND),
        Layer::Line(flat.clone(), GREY, 1.6),
        Layer::marks(Mark::Triangle, flat.iter().copied(), GREY),
        Layer::Line(wanted, green, 1.6),
    ];
    let measured = Layer::marks(Mark::Square, measured.iter().copied(), purple);
    let layers = layers.into_iter().chain(samples.iter().flat_map(of_sample)).chain([measured]);
    Chart::new(title, 500.0, legend).plot(x_axis, y_axis, layers).svg()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TARGET: [TargetPoint; 2] = [
        TargetPoint { pressure_mpa: 0.65, value: Some(0.97), lowest: Some(0.96), highest: Some(0.98), flat: None },
        TargetPoint { pressure_mpa: 2.6, value: Some(0.83), lowest: Some(0.82), highest: Some(0.84), flat: None },
    ];
    const SAMPLE: SamplePoint =
        SamplePoint { pressure_mpa: 0.65, condition: 0, median: 0.95, interval_95: [0.9, 0.99], model: None };

    fn drawn(points: &[TargetPoint], samples: &[SamplePoint]) -> Result<String, ChartError> {
        target("Target", "friction ratio", points, samples, &[])
    }

    #[test]
    fn only_what_is_there_stands_in_the_legend() {
        let svg = drawn(&TARGET, &[]).unwrap();
        assert!(svg.contains("\naccepted\n") && svg.contains("\nfriction ratio\n"));
        for absent in ["expected", "model alone", "flat", "earlier trials"] {
            assert!(!svg.contains(&format!("\n{absent}\n")), "{absent}");
        }
        let samples = [SamplePoint { model: Some(0.96), ..SAMPLE }];
        let beside_flat = [TargetPoint { flat: Some(1.0), ..TARGET[0] }, TARGET[1]];
        let full = target("Target", "friction ratio", &beside_flat, &samples, &[[1.3, 0.9]]).unwrap();
        for present in ["expected", "95 % of samples", "model alone", "flat", "earlier trials"] {
            assert!(full.contains(&format!("\n{present}\n")), "{present}");
        }
        // Every series stands at its own pressure, and a ring leaves the mark inside it visible.
        let circles: Vec<&str> = full.split("<circle ").skip(1).filter_map(|rest| rest.split('"').nth(1)).collect();
        assert_eq!(circles.len(), 4, "two in the legend, two in the plot");
        assert_eq!(circles[2], circles[3]);
        // A target with a single point is drawn as well.
        assert!(drawn(&TARGET[..1], &samples).is_ok());
    }

    #[test]
    fn conditions_stand_side_by_side() {
        let bars = |samples: &[SamplePoint]| {
            let svg = drawn(&TARGET, samples).unwrap();
            svg.matches("<polygon").count()
        };
        let both = [SAMPLE, SamplePoint { condition: 1, ..SAMPLE }];
        assert_eq!(bars(&both), bars(&[SAMPLE]) + 1);
        let svg = drawn(&TARGET, &both).unwrap();
        let circles: Vec<&str> = svg.split("<circle ").skip(1).filter_map(|rest| rest.split(' ').next()).collect();
        assert!(circles.iter().collect::<std::collections::BTreeSet<_>>().len() >= 3, "{circles:?}");
    }

    #[test]
    fn bands_may_be_open_and_goals_have_none() {
        let open = TARGET.map(|point| TargetPoint { value: None, lowest: None, ..point });
        let svg = drawn(&open, &[SAMPLE]).unwrap();
        assert!(svg.contains("\naccepted\n") && svg.contains("<polygon"));
        let free = open.map(|point| TargetPoint { highest: None, ..point });
        let svg = drawn(&free, &[SAMPLE]).unwrap();
        assert!(!svg.contains("accepted") && svg.contains("\n95 % of samples\n"));
    }

    #[test]
    fn a_target_without_points_is_refused() {
        assert!(matches!(drawn(&[], &[]), Err(ChartError::Empty { .. })));
        let odd = [SamplePoint { median: f64::NAN, ..SAMPLE }];
        assert!(matches!(drawn(&TARGET, &odd), Err(ChartError::NotFinite { .. })));
    }
}
