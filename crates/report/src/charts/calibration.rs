//! Charts of calibrations: flat friction, residuals, ratios and the area law.

use super::{Axis, Chart, ChartError, Estimate, GREY, INK, Layer, Mark, PALETTE, Swatch, extremes, width};

/// Friction of flat samples at one speed and humidity.
#[derive(Clone, Debug, PartialEq)]
pub struct FlatSeries {
    /// Name in the legend.
    pub label: String,
    /// Nominal pressure in MPa and measured friction with its standard deviation; pressures increase.
    pub measured: Vec<(f64, Estimate)>,
    /// Nominal pressure in MPa and modelled friction.
    pub modelled: Vec<(f64, Estimate)>,
}

/// Horizontal offset between the marks of neighbouring conditions at one pressure, relative to the width of the
/// picture.
const ASIDE: f64 = 0.01;

/// Draws measured friction as marks with error bars and modelled friction as rings; each condition has a colour and a
/// mark. An empty title gives a narrow picture for a phone.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw or a value is not finite.
pub fn flat_friction(title: &str, series: &[FlatSeries]) -> Result<String, ChartError> {
    let measured = || series.iter().flat_map(|of| &of.measured);
    let all = || measured().chain(series.iter().flat_map(|of| &of.modelled));
    let x_axis = Axis::around("nominal pressure (MPa)", measured().map(|(pressure, _)| *pressure));
    let y_axis = Axis::around("dynamic friction coefficient", all().flat_map(|(_, at)| at.ends()));
    let aside = ASIDE * width(title);
    let middle = 0.5 * (series.len() as f64 - 1.0);
    let mut legend: Vec<(Swatch, &str)> = Vec::new();
    let mut layers = Vec::new();
    for (place, of) in series.iter().enumerate() {
        let colour = PALETTE[place % PALETTE.len()];
        let mark = Mark::FILLED[place / PALETTE.len() % Mark::FILLED.len()];
        let aside = aside * (place as f64 - middle);
        legend.push((Swatch::Mark(mark, colour), &of.label));
        layers.push(Layer::Marks(mark, of.measured.clone(), colour, aside));
        layers.push(Layer::Marks(Mark::Ring, of.modelled.clone(), colour, aside));
    }
    legend.push((Swatch::Mark(Mark::Ring, PALETTE[0]), "fitted model"));
    Chart::new(title, 500.0, legend).plot(x_axis, y_axis, layers).svg()
}

/// Height of the picture without the list of measurement names below the plot, in picture units.
const HEIGHT: f64 = 460.0;
/// Height of a line of the list of measurement names below the plot, in picture units.
const KEY_LINE: f64 = 16.0;
/// Number of columns of the list of measurement names below the plot.
const KEY_COLUMNS: usize = 4;

/// Draws the residuals of measurements side by side, with the measured standard deviations as error bars. Measurements
/// are numbered; a key below the plot lists numbers and names.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw or a value is not finite.
pub fn residuals(title: &str, residuals: &[(String, Estimate)]) -> Result<String, ChartError> {
    let legend = vec![(Swatch::Mark(Mark::Circle, PALETTE[0]), "residual, with the measured standard deviation")];
    let x_axis = Axis::of_names("measurement", 1..=residuals.len());
    let y_axis = Axis::around("model - measured", residuals.iter().flat_map(|(_, of)| of.ends()).chain([0.0]));
    let lines = residuals.len().div_ceil(KEY_COLUMNS);
    let mut chart = Chart::new(title, HEIGHT + KEY_LINE * lines as f64, legend);
    let [left, top, right, _] = chart.frame();
    let marks = residuals.iter().enumerate().map(|(place, (_, of))| (place as f64, *of)).collect();
    let width = (right - left) / KEY_COLUMNS as f64;
    let note = |(place, (label, _)): (usize, &(String, Estimate))| {
        let (column, line) = (place / lines, place % lines);
        let at = [left + width * column as f64, HEIGHT - 10.0 + KEY_LINE * line as f64];
        Layer::Note(format!("{} {label}", place + 1), at)
    };
    let layers = [Layer::Horizontal(0.0), Layer::Marks(Mark::Circle, marks, PALETTE[0], 0.0)];
    let layers = layers.into_iter().chain(residuals.iter().enumerate().map(note));
    chart.plot_in([left, top, right, HEIGHT - 72.0], x_axis, y_axis, layers).svg()
}

/// Horizontal distance between neighbouring marks of one pressure, in picture units.
const BESIDE: f64 = 20.0;

/// Draws ratios of patterned to flat friction side by side at each nominal pressure. Each of `series`, from left to
/// right, has a name, for example measured or modelled, and one ratio per pressure, `None` if unknown.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw or a value is not finite.
pub fn ratios(
    title: &str,
    pressure_mpa: &[f64],
    series: &[(String, Vec<Option<Estimate>>)],
) -> Result<String, ChartError> {
    let all = series.iter().flat_map(|(_, ratios)| ratios.iter().flatten());
    let x_axis = Axis::of_names("nominal pressure (MPa)", pressure_mpa);
    let y_axis = Axis::around("friction ratio, patterned / flat", all.flat_map(|of| of.ends()).chain([1.0]));
    let middle = (series.len() as f64 - 1.0) / 2.0;
    let mut legend: Vec<(Swatch, &str)> = Vec::new();
    let mut layers = vec![Layer::Horizontal(1.0)];
    let styles = PALETTE.into_iter().cycle().zip(Mark::ALL.into_iter().cycle());
    for (order, ((label, ratios), (color, mark))) in series.iter().zip(styles).enumerate() {
        legend.push((Swatch::Mark(mark, color), label));
        let marks = ratios.iter().enumerate().filter_map(|(place, of)| Some((place as f64, (*of)?))).collect();
        layers.push(Layer::Marks(mark, marks, color, BESIDE * (order as f64 - middle)));
    }
    legend.push((Swatch::Dashed(GREY), "no effect (Amontons-Coulomb)"));
    Chart::new(title, 480.0, legend).plot(x_axis, y_axis, layers).svg()
}

/// Real contact area and area factor at one pressure.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AreaPoint {
    /// Nominal pressure, in MPa.
    pub pressure_mpa: f64,
    /// Real contact area over nominal area.
    pub area_fraction: f64,
    /// Area factor f: real contact area over pressure, relative to this quotient at the threshold pressure.
    pub factor: f64,
    /// Standard error of f; drawn only if all points have a standard error.
    pub factor_std: Option<f64>,
    /// Mean of f over windows of the map, with the standard deviation between windows; `None` without windows.
    pub windows: Option<Estimate>,
}

/// Gap between the panels, in picture units.
const GAP: f64 = 22.0;
/// Opacity of the band of standard errors.
const BAND: f64 = 0.25;

/// Draws the area fraction and, below, the area factor f of `points` on a shared pressure axis; pressures increase.
/// `threshold` is the threshold pressure P0 in MPa with its area fraction; a dashed line from the origin through this
/// point shows area proportional to load. `others` are named surfaces, drawn with thinner lines.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw or a value is not finite.
pub fn area_law(
    title: &str,
    points: &[AreaPoint],
    threshold: Option<[f64; 2]>,
    others: &[(String, Vec<AreaPoint>)],
) -> Result<String, ChartError> {
    let [blue, vermilion, coloured @ ..] = PALETTE;
    let compared = || others.iter().zip(coloured.into_iter().cycle());
    let area = |at: &AreaPoint| [at.pressure_mpa, at.area_fraction];
    let factor = |at: &AreaPoint| [at.pressure_mpa, at.factor];
    let windows: Vec<(f64, Estimate)> = points.iter().filter_map(|at| Some((at.pressure_mpa, at.windows?))).collect();
    let has_std = points.iter().all(|at| at.factor_std.is_some());
    let edge = |side: f64| {
        let known = points.iter().filter(move |_| has_std);
        known.filter_map(move |at| Some([at.pressure_mpa, at.factor + side * at.factor_std?]))
    };
    let band: Vec<[f64; 2]> = edge(-1.0).chain(edge(1.0).rev()).collect();

    let mut legend = vec![
        (Swatch::Mark(Mark::Circle, blue), "real contact area"),
        (Swatch::Mark(Mark::Square, vermilion), "factor f"),
    ];
    if has_std {
        legend.push((Swatch::Band(vermilion, BAND), "f ± standard error"));
    }
    if !windows.is_empty() {
        legend.push((Swatch::Mark(Mark::Ring, INK), "windows of the map, ± standard deviation"));
    }
    if threshold.is_some() {
        legend.push((Swatch::Dashed(GREY), "proportional to load"));
    }
    legend.extend(compared().map(|((label, _), color)| (Swatch::Line(color), label.as_str())));

    let pressures = || points.iter().map(|at| at.pressure_mpa);
    let all = || others.iter().flat_map(|(_, points)| points).chain(points);
    let (mut upper, mut lower) = (Vec::new(), Vec::new());
    if let Some([threshold_mpa, threshold_area]) = threshold {
        upper.push(Layer::Vertical(threshold_mpa, "P0"));
        if threshold_area > 0.0 && threshold_mpa > 0.0 {
            // Area proportional to load: A = A(P0) P/P0, up to the border of the panel.
            let [last, highest] = [extremes(pressures())[1], extremes(points.iter().map(|at| at.area_fraction))[1]];
            let end_mpa = last.min(highest / threshold_area * threshold_mpa);
            upper.push(Layer::Dashed([[0.0, 0.0], [end_mpa, threshold_area * end_mpa / threshold_mpa]], GREY));
        }
        lower.extend([Layer::Vertical(threshold_mpa, ""), Layer::Horizontal(1.0)]);
    }
    let x_axis = Axis::from_zero("nominal pressure (MPa)", pressures());
    let area_axis = Axis::from_zero("area fraction", all().map(|at| at.area_fraction));
    let reached = band.iter().map(|point| point[1]).chain(windows.iter().flat_map(|(_, of)| of.ends()));
    let factor_axis = Axis::around("factor f", all().map(|at| at.factor).chain(reached).chain([1.0]));
    lower.push(Layer::Area(band, vermilion, BAND));
    for ((_, points), color) in compared() {
        upper.push(Layer::Line(points.iter().map(area).collect(), color, 1.2));
        lower.push(Layer::Line(points.iter().map(factor).collect(), color, 1.2));
    }
    upper.push(Layer::Line(points.iter().map(area).collect(), blue, 1.8));
    upper.push(Layer::marks(Mark::Circle, points.iter().map(area), blue));
    lower.push(Layer::Line(points.iter().map(factor).collect(), vermilion, 1.8));
    lower.push(Layer::marks(Mark::Square, points.iter().map(factor), vermilion));
    lower.push(Layer::Marks(Mark::Ring, windows, INK, 0.0));

    let mut chart = Chart::new(title, 640.0, legend);
    let [left, top, right, bottom] = chart.frame();
    let panel = (bottom - top - GAP) / 2.0;
    chart.plot_in([left, top, right, top + panel], x_axis.clone().unlabelled(), area_axis, upper);
    chart.plot_in([left, bottom - panel, right, bottom], x_axis, factor_axis, lower).svg()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn absent_ratios_are_left_out() {
        let some = |value| Some(Estimate { value, error: Some(0.02) });
        let measured = [some(0.93), None, some(0.74)];
        let modelled = [some(0.97), some(0.92), some(0.83)];
        let series = [("measured".to_owned(), measured.to_vec()), ("modelled".to_owned(), modelled.to_vec())];
        let svg = ratios("Ratios", &[0.65, 1.3, 2.6], &series).unwrap();
        // The first series has circles: two marks and one in the legend.
        assert_eq!(svg.matches("<circle").count(), 3);
    }

    fn points(rows: [[f64; 3]; 4]) -> Vec<AreaPoint> {
        let point = |[pressure_mpa, area_fraction, factor]: [f64; 3]| AreaPoint {
            pressure_mpa,
            area_fraction,
            factor,
            ..AreaPoint::default()
        };
        rows.map(point).to_vec()
    }

    #[test]
    fn two_panels_share_the_pressure_axis() {
        let mut own = points([[0.35, 0.1, 1.0], [0.7, 0.2, 1.0], [1.4, 0.35, 0.875], [2.8, 0.5, 0.625]]);
        own.iter_mut().zip([0.0, 0.0, 0.01, 0.02]).for_each(|(at, std)| at.factor_std = Some(std));
        let drawn = |points: &[AreaPoint], others: &[(String, Vec<AreaPoint>)]| {
            area_law("Area law", points, Some([0.7, 0.2]), others)
        };
        let svg = drawn(&own, &[]).unwrap();
        assert_eq!(svg.matches("\nnominal pressure (MPa)\n").count(), 1);
        // Four marks in each panel and one in the legend.
        assert_eq!(svg.matches("<circle").count(), 5);
        let other = points([[0.35, 0.05, 1.0], [0.7, 0.1, 1.0], [1.4, 0.2, 1.0], [2.8, 0.35, 1.0]]);
        let compared = drawn(&own, &[("rougher".to_owned(), other)]).unwrap();
        // One more line in each panel and one in the legend.
        assert_eq!(compared.matches("#009E73").count(), 3);
        // A ring on each pressure, one in the legend.
        let windows = [[1.0, 0.0], [1.0, 0.0], [0.88, 0.03], [0.6, 0.05]];
        let windows = windows.map(|[value, std]| Some(Estimate { value, error: Some(std) }));
        own.iter_mut().zip(windows).for_each(|(at, of)| at.windows = of);
        let spread = drawn(&own, &[]).unwrap();
        assert_eq!(spread.matches("<circle").count(), 5 + 5);
        // A band needs an error at every pressure.
        own[0].factor_std = None;
        assert!(!drawn(&own, &[]).unwrap().contains("f ± standard error"));
    }
}
