use super::canvas::{GREY, INK, LEFT, Mark, PALETTE, RIGHT, Swatch, WIDTH, picture};
use super::plot::{Axis, Plot};
use super::{ChartError, check, check_length};

/// Real contact area and the factor f against pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AreaLawChart<'a> {
    /// Title.
    pub title: &'a str,
    /// Pressures, in MPa, increasing.
    pub pressure_mpa: &'a [f64],
    /// Real contact area over nominal area, one per pressure.
    pub area_fraction: &'a [f64],
    /// The factor f, one per pressure.
    pub factor: &'a [f64],
    /// Standard errors of f, one per pressure; may be empty.
    pub factor_std: &'a [f64],
    /// Mean of f over windows of the map and its standard deviation among them, one pair per pressure; may be empty.
    pub windows: &'a [[f64; 2]],
    /// Threshold pressure P0 in MPa, below which friction is proportional to load, and the area fraction at P0.
    pub threshold: Option<[f64; 2]>,
    /// Other surfaces at identical pressures, drawn as thinner lines; may be empty.
    pub others: &'a [OtherSurface<'a>],
}

/// Surface for comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OtherSurface<'a> {
    /// Name in the legend.
    pub label: &'a str,
    /// Real contact area over nominal area, one per pressure.
    pub area_fraction: &'a [f64],
    /// The factor f, one per pressure.
    pub factor: &'a [f64],
}

/// Height of the picture.
const HEIGHT: f64 = 640.0;
/// Gap between the panels.
const GAP: f64 = 22.0;
/// Opacity of the band of standard errors.
const BAND: f64 = 0.25;

/// Draws the area fraction above the factor on a shared pressure axis, with the line through the origin
/// that proportional friction would follow.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw, lengths differ or a value is not finite.
pub fn area_law(chart: &AreaLawChart<'_>) -> Result<String, ChartError> {
    check_length(chart.title, chart.pressure_mpa.len(), chart.area_fraction.len())?;
    check_length(chart.title, chart.pressure_mpa.len(), chart.factor.len())?;
    if !chart.factor_std.is_empty() {
        check_length(chart.title, chart.pressure_mpa.len(), chart.factor_std.len())?;
    }
    if !chart.windows.is_empty() {
        check_length(chart.title, chart.pressure_mpa.len(), chart.windows.len())?;
    }
    for other in chart.others {
        check_length(chart.title, chart.pressure_mpa.len(), other.area_fraction.len())?;
        check_length(chart.title, chart.pressure_mpa.len(), other.factor.len())?;
    }
    let others = || chart.others.iter().flat_map(|other| other.area_fraction.iter().chain(other.factor));
    let own = || chart.pressure_mpa.iter().chain(chart.area_fraction).chain(chart.factor).chain(chart.factor_std);
    let own = || own().chain(chart.windows.as_flattened());
    let values = || own().chain(others());
    check(chart.title, chart.pressure_mpa)?;
    check(chart.title, values().chain(chart.threshold.iter().flatten()))?;

    let [blue, vermilion, coloured @ ..] = PALETTE;
    let compared = || chart.others.iter().zip(coloured.into_iter().cycle());
    let mut legend = vec![
        (Swatch::Mark(Mark::Circle, blue), "real contact area"),
        (Swatch::Mark(Mark::Square, vermilion), "factor f"),
    ];
    if !chart.factor_std.is_empty() {
        legend.push((Swatch::Band(vermilion, BAND), "f ± standard error"));
    }
    if !chart.windows.is_empty() {
        legend.push((Swatch::Mark(Mark::Ring, INK), "windows of the map, ± standard deviation"));
    }
    if chart.threshold.is_some() {
        legend.push((Swatch::Dashed(GREY), "proportional to load"));
    }
    legend.extend(compared().map(|(other, color)| (Swatch::Line(color), other.label)));
    let column = |column: &[f64]| -> Vec<[f64; 2]> {
        chart.pressure_mpa.iter().zip(column).map(|(&pressure, &value)| [pressure, value]).collect()
    };
    let x_axis = Axis::from_zero("nominal pressure (MPa)", chart.pressure_mpa.iter().copied());
    let areas = || chart.others.iter().flat_map(|other| other.area_fraction).chain(chart.area_fraction).copied();
    let factors = || chart.others.iter().flat_map(|other| other.factor).chain(chart.factor).copied();
    let area_axis = Axis::from_zero("area fraction", areas());
    let edge = |side: f64| {
        let rows = chart.pressure_mpa.iter().zip(chart.factor).zip(chart.factor_std);
        rows.map(move |((&pressure, factor), std)| [pressure, factor + side * std])
    };
    let band: Vec<[f64; 2]> = edge(-1.0).chain(edge(1.0).rev()).collect();
    let edges = band.iter().map(|point| point[1]);
    let of_windows = chart.windows.iter().flat_map(|[mean, std]| [mean - std, mean + std]);
    let factor_axis = Axis::around("factor f", factors().chain(edges).chain(of_windows).chain([1.0]));
    let area_high = chart.area_fraction.iter().fold(0.0_f64, |high, &area| high.max(area));
    let last = chart.pressure_mpa.iter().fold(0.0_f64, |high, &pressure| high.max(pressure));
    picture(HEIGHT, |canvas| {
        let top = canvas.heading(chart.title, &legend)?;
        let (right, bottom) = (WIDTH - RIGHT, HEIGHT - 62.0);
        let panel = (bottom - top - GAP) / 2.0;

        let upper = Plot::new(canvas, [LEFT, top, right, top + panel], x_axis.clone().unlabelled(), area_axis)?;
        if let Some([threshold_mpa, area]) = chart.threshold {
            upper.vertical(threshold_mpa, "P0")?;
            if area > 0.0 && threshold_mpa > 0.0 {
                // A = A(P0) P/P0, up to the border of the panel.
                let end_mpa = last.min(area_high / area * threshold_mpa);
                upper.dashed([[0.0, 0.0], [end_mpa, area * end_mpa / threshold_mpa]], GREY)?;
            }
        }
        for (other, color) in compared() {
            upper.line(&column(other.area_fraction), color, 1.2)?;
        }
        let points = column(chart.area_fraction);
        upper.line(&points, blue, 1.8)?;
        for &point in &points {
            upper.mark(Mark::Circle, point, None, 0.0, blue)?;
        }

        let lower = Plot::new(canvas, [LEFT, bottom - panel, right, bottom], x_axis, factor_axis)?;
        if let Some([threshold_mpa, _]) = chart.threshold {
            lower.vertical(threshold_mpa, "")?;
            lower.horizontal(1.0, GREY)?;
        }
        if !band.is_empty() {
            lower.polygon(&band, vermilion, BAND)?;
        }
        for (other, color) in compared() {
            lower.line(&column(other.factor), color, 1.2)?;
        }
        let points = column(chart.factor);
        lower.line(&points, vermilion, 1.8)?;
        for &point in &points {
            lower.mark(Mark::Square, point, None, 0.0, vermilion)?;
        }
        for (pressure, [mean, std]) in chart.pressure_mpa.iter().zip(chart.windows) {
            lower.mark(Mark::Ring, [*pressure, *mean], Some(*std), 0.0, INK)?;
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_panels_share_the_pressure_axis() {
        let chart = AreaLawChart {
            title: "Area law",
            pressure_mpa: &[0.35, 0.7, 1.4, 2.8],
            area_fraction: &[0.1, 0.2, 0.35, 0.5],
            factor: &[1.0, 1.0, 0.875, 0.625],
            factor_std: &[0.0, 0.0, 0.01, 0.02],
            windows: &[],
            threshold: Some([0.7, 0.2]),
            others: &[],
        };
        let svg = area_law(&chart).unwrap();
        for text in ["area fraction", "factor f", "P0", "proportional to load", "f ± standard error"] {
            assert!(svg.contains(&format!("\n{text}\n")), "{text}");
        }
        assert_eq!(svg.matches("\nnominal pressure (MPa)\n").count(), 1);
        // Four marks in each panel and one in the legend.
        assert_eq!(svg.matches("<circle").count(), 5);
        let other = OtherSurface { label: "rougher", area_fraction: &[0.05, 0.1, 0.2, 0.35], factor: &[1.0; 4] };
        let compared = area_law(&AreaLawChart { others: &[other], ..chart }).unwrap();
        // One more line in each panel and one in the legend.
        assert_eq!(compared.matches("#009E73").count(), 3);
        // A ring on each pressure, one in the legend.
        let windows = [[1.0, 0.0], [1.0, 0.0], [0.88, 0.03], [0.6, 0.05]];
        let spread = area_law(&AreaLawChart { windows: &windows, ..chart }).unwrap();
        assert_eq!(spread.matches("<circle").count(), 5 + 5);
        let short = OtherSurface { factor: &[1.0], ..other };
        assert!(area_law(&AreaLawChart { others: &[short], ..chart }).is_err());
    }

    #[test]
    fn columns_of_unequal_length_are_refused() {
        let chart = AreaLawChart {
            title: "t",
            pressure_mpa: &[1.0, 2.0],
            area_fraction: &[0.1],
            factor: &[1.0, 1.0],
            factor_std: &[],
            windows: &[],
            threshold: None,
            others: &[],
        };
        assert!(matches!(area_law(&chart), Err(ChartError::LengthMismatch { left: 2, right: 1, .. })));
    }
}
