use super::canvas::{GREY, LEFT, PALETTE, RIGHT, Swatch, WIDTH, picture};
use super::plot::{Axis, Plot};
use super::{ChartError, Series, check};

/// Pressure along the interface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InterfacePressureChart<'a> {
    /// Title.
    pub title: &'a str,
    /// One series per surface: position in micrometres and pressure in MPa, contact blocks only.
    pub surfaces: &'a [Series<'a>],
    /// Start and end of each cavity, in micrometres.
    pub cavities_um: &'a [[f64; 2]],
    /// Nominal pressure, in MPa.
    pub nominal_mpa: Option<f64>,
}

/// Height of the picture.
const HEIGHT: f64 = 460.0;
const SHADE: f64 = 0.18;

/// Draws pressure along x; lines are interrupted over cavities.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw or a value is not finite.
pub fn interface_pressure(chart: &InterfacePressureChart<'_>) -> Result<String, ChartError> {
    let points = || chart.surfaces.iter().flat_map(|surface| surface.points);
    check(chart.title, points().flatten())?;
    check(chart.title, points().flatten().chain(chart.cavities_um.iter().flatten()).chain(chart.nominal_mpa.as_ref()))?;

    let coloured = || chart.surfaces.iter().zip(PALETTE.into_iter().cycle());
    let mut legend: Vec<(Swatch, &str)> =
        coloured().map(|(surface, color)| (Swatch::Line(color), surface.label)).collect();
    if !chart.cavities_um.is_empty() {
        legend.push((Swatch::Band(GREY, SHADE), "cavity"));
    }
    if chart.nominal_mpa.is_some() {
        legend.push((Swatch::Dashed(GREY), "nominal pressure"));
    }

    let places = points().map(|point| point[0]).chain(chart.cavities_um.iter().flatten().copied());
    let [low, high] = places.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], x| [l.min(x), h.max(x)]);
    let x_axis = Axis::over(
        "position along the sliding direction x (µm)",
        if high > low { [low, high] } else { [low - 1.0, high + 1.0] },
    );
    let pressures = || points().map(|point| point[1]).chain(chart.nominal_mpa);
    let title = "contact pressure (MPa)";
    // Tension stays visible if a model has it.
    let y_axis = if pressures().any(|p| p < 0.0) {
        Axis::around(title, pressures().chain([0.0]))
    } else {
        Axis::from_zero(title, pressures())
    };
    picture(HEIGHT, |canvas| {
        let top = canvas.heading(chart.title, &legend)?;
        let plot = Plot::new(canvas, [LEFT, top, WIDTH - RIGHT, HEIGHT - 62.0], x_axis, y_axis)?;
        for &cavity_um in chart.cavities_um {
            plot.span(cavity_um, GREY, SHADE)?;
        }
        if let Some(nominal_mpa) = chart.nominal_mpa {
            plot.horizontal(nominal_mpa, GREY)?;
        }
        for (surface, color) in coloured() {
            // The minimum distance between neighbours is one block; a longer distance is a cavity.
            let distance = |pair: &[[f64; 2]]| pair[1][0] - pair[0][0];
            let block_um = surface.points.windows(2).map(distance).fold(f64::INFINITY, f64::min);
            for land in surface.points.chunk_by(|a, b| b[0] - a[0] < 1.5 * block_um) {
                plot.line(land, color, 1.8)?;
            }
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_break_over_cavities() {
        let points = [[5.0, 1.0], [15.0, 2.0], [25.0, 3.0], [65.0, 3.0], [75.0, 2.0]];
        let surfaces = [Series { label: "patterned", points: &points }];
        let cavities_um = [[30.0, 60.0]];
        let chart = InterfacePressureChart {
            title: "Pressure",
            surfaces: &surfaces,
            cavities_um: &cavities_um,
            nominal_mpa: None,
        };
        let svg = interface_pressure(&chart).unwrap();
        // Two lands and the legend's line in the colour of the series.
        let lines = svg.lines().filter(|line| line.contains("<polyline") && line.contains("#0072B2")).count();
        assert_eq!(lines, 3);
        for text in ["contact pressure (MPa)", "cavity", "patterned"] {
            assert!(svg.contains(&format!("\n{text}\n")), "{text}");
        }
    }
}
