//! Chart of pressure along the interface.

use super::axis::{Axis, extremes};
use super::canvas::{GREY, PALETTE, Swatch};
use super::chart::{Chart, Layer};
use super::{ChartError, Series};

const SHADE: f64 = 0.18;

/// Draws pressure in MPa along x in micrometres, one series per surface, contact blocks only; lines are interrupted over cavities,
/// which have a start and an end. `nominal_mpa` is the nominal pressure.
///
/// # Errors
/// [`ChartError`] if there is nothing to draw or a value is not finite.
pub fn interface_pressure(
    title: &str,
    surfaces: &[Series<'_>],
    cavities_um: &[[f64; 2]],
    nominal_mpa: f64,
) -> Result<String, ChartError> {
    let points = || surfaces.iter().flat_map(|surface| &surface.points);
    let coloured = || surfaces.iter().zip(PALETTE.into_iter().cycle());
    let mut legend: Vec<(Swatch, &str)> =
        coloured().map(|(surface, color)| (Swatch::Line(color), surface.label)).collect();
    if !cavities_um.is_empty() {
        legend.push((Swatch::Band(GREY, SHADE), "cavity"));
    }
    legend.push((Swatch::Dashed(GREY), "nominal pressure"));

    let [low, high] = extremes(points().map(|point| point[0]).chain(cavities_um.iter().flatten().copied()));
    let range_um = if high > low { [low, high] } else { [low - 1.0, high + 1.0] };
    let x_axis = Axis::over("position along the sliding direction x (µm)", range_um);
    let pressures = || points().map(|point| point[1]).chain([nominal_mpa]);
    // Tension stays visible if a model has it.
    let y_axis = if pressures().any(|p| p < 0.0) {
        Axis::around("contact pressure (MPa)", pressures().chain([0.0]))
    } else {
        Axis::from_zero("contact pressure (MPa)", pressures())
    };
    let mut layers: Vec<Layer<'_>> = cavities_um.iter().map(|cavity_um| Layer::Span(*cavity_um, SHADE)).collect();
    layers.push(Layer::Horizontal(nominal_mpa));
    for (surface, color) in coloured() {
        // The minimum distance between neighbours is one block; a longer distance is a cavity.
        let distance = |pair: &[[f64; 2]]| pair[1][0] - pair[0][0];
        let block_um = surface.points.windows(2).map(distance).fold(f64::INFINITY, f64::min);
        let lands = surface.points.chunk_by(|a, b| b[0] - a[0] < 1.5 * block_um);
        layers.extend(lands.map(|land| Layer::Line(land.to_vec(), color, 1.8)));
    }
    Chart::new(title, 460.0, legend).plot(x_axis, y_axis, layers).svg()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_break_over_cavities() {
        let points = [[5.0, 1.0], [15.0, 2.0], [25.0, 3.0], [65.0, 3.0], [75.0, 2.0]];
        let surfaces = [Series { label: "patterned", points: points.to_vec() }];
        let svg = interface_pressure("Pressure", &surfaces, &[[30.0, 60.0]], 2.0).unwrap();
        // Two lands and the legend's line in the colour of the series.
        let lines = svg.lines().filter(|line| line.contains("<polyline") && line.contains("#0072B2")).count();
        assert_eq!(lines, 3);
        for text in ["contact pressure (MPa)", "cavity", "patterned"] {
            assert!(svg.contains(&format!("\n{text}\n")), "{text}");
        }
    }
}
