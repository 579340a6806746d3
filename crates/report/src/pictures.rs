//! Pictures of simulations: converts results to charts.

use std::collections::BTreeMap;

use rayon::prelude::*;
use slipgrid_model::pattern::Texture;
use slipgrid_model::springblock::{
    Effect, Extent, InterfacePoint, LoadOutcome, Scene, Simulation, SteadyCell, SurfaceOutcome,
};

use crate::ChartError;
use crate::Outputs;
use crate::charts::{Estimate, Series, SurfaceValues, Trace, friction_trace, interface_pressure, surface_map};
use slipgrid_base::units::{LENGTH_UM, PRESSURE_MPA, tidy};
use slipgrid_design::results::PressureErrors;

/// Maximum distance between the centres of neighbouring contact blocks on one land, in block widths; a larger distance
/// spans a cavity.
const CONTIGUOUS_BLOCKS: f64 = 1.5;

/// Label of the flat surface.
const FLAT: &str = "flat";

/// Legend labels of the patterned surface's friction curve and of the mean coefficients. The ratio of a specimen
/// includes corrections for other strips, smaller blocks and the body behind the layer; the curve is from the run of a
/// single strip without these corrections.
fn run_words(scene: &Scene, load: &LoadOutcome) -> [&'static str; 2] {
    let is_whole = load.correction(Effect::Layout).is_some();
    match load.ratio() {
        Some(_) if is_whole && scene.dimension().takes_strips() => [
            "patterned: one strip of the specimen",
            "mean: flat over the window, patterned of the whole specimen, as in the tables",
        ],
        Some(_) => ["patterned", "mean: flat over the window, patterned as in the tables"],
        None => ["patterned", "mean over the window"],
    }
}

/// Surfaces of a load with their names, the flat surface first.
pub(crate) fn surfaces(load: &LoadOutcome) -> Vec<(&'static str, &SurfaceOutcome)> {
    match &load.flat {
        Some(flat) => vec![(FLAT, flat), ("patterned", &load.surface)],
        None => vec![(FLAT, &load.surface)],
    }
}

/// Adds pictures for every load: the friction coefficient against time for dynamic runs, and the pressure along the
/// interface. `errors` are the errors of the mean coefficients, one per load, if known.
///
/// # Errors
/// [`ChartError`] if a picture cannot be drawn.
pub fn simulation(
    scene: &Scene,
    simulation: &Simulation,
    errors: &[PressureErrors],
    outputs: &mut Outputs,
) -> Result<(), ChartError> {
    let each = simulation.loads.par_iter().enumerate();
    let pictures = each.map(|(row, load)| of_load(scene, load, errors.get(row))).collect::<Result<Vec<_>, _>>()?;
    for (name, picture) in pictures.into_iter().flatten() {
        outputs.add(name, picture);
    }
    Ok(())
}

/// Formats a non-negative number for a file name: `0.65`, or `1e-7` if the zeros of a decimal number would make the
/// name too long for some systems.
pub(crate) fn name_part(number: f64) -> String {
    if number == 0.0 || (1e-6..1e9).contains(&number) { number.to_string() } else { format!("{number:e}") }
}

/// Draws the pictures of one load; `at` are the errors of the mean coefficients, if known. Returns file names and SVG
/// texts.
fn of_load(
    scene: &Scene,
    load: &LoadOutcome,
    at: Option<&PressureErrors>,
) -> Result<Vec<(String, String)>, ChartError> {
    let mut pictures = Vec::new();
    let load_mpa = PRESSURE_MPA.from_si(load.pressure_pa);
    let surfaces = surfaces(load);
    let std = |label: &str| match (&at?.mu_flat, label) {
        (Some(flat), FLAT) => flat.std,
        _ => at?.mu.std,
    };
    let [patterned, means] = run_words(scene, load);
    let named = |label| if label == FLAT { FLAT } else { patterned };
    let of_surface = |&(label, surface): &(_, &SurfaceOutcome)| trace(named(label), surface, std(label));
    let traces: Vec<Trace<'_>> = surfaces.iter().map(of_surface).collect();
    if traces.iter().any(|trace| !trace.series.points.is_empty()) {
        let picture = friction_trace(&format!("Friction coefficient at {load_mpa} MPa"), &traces, means)?;
        pictures.push((format!("friction-{}mpa.svg", name_part(load_mpa)), picture));
    }
    let sees_face = scene.dimension().sees_face();
    let is_strip = sees_face && scene.run.extent == Extent::Strip;
    if sees_face && !is_strip {
        if let Some(map) = interface_map(scene, load, load_mpa)? {
            pictures.push((format!("interface-{}mpa.svg", name_part(load_mpa)), map));
        }
        return Ok(pictures);
    }
    let lines: Vec<Vec<InterfacePoint>> = if is_strip {
        lines_through_cavities(scene, &surfaces, &load.surface)
    } else {
        surfaces.iter().map(|(_, surface)| surface.interface.clone()).collect()
    };
    let series: Vec<Series<'_>> =
        surfaces.iter().zip(&lines).map(|((label, _), line)| pressures(label, line)).collect();
    if series.iter().any(|of| !of.points.is_empty()) {
        let where_from = if is_strip { "through cavities" } else { "along the interface" };
        let title = format!("Pressure {where_from} at {load_mpa} MPa");
        let cavities = lines.last().map_or_else(Vec::new, |line| cavities_um(scene, line));
        let picture = interface_pressure(&title, &series, &cavities, load_mpa)?;
        pictures.push((format!("interface-{}mpa.svg", name_part(load_mpa)), picture));
    }
    Ok(pictures)
}

/// Converts the friction of `surface` in time to a trace named `label`; `std` is the standard deviation of the mean
/// coefficient.
pub fn trace<'a>(label: &'a str, surface: &SurfaceOutcome, std: Option<f64>) -> Trace<'a> {
    let points = finite(surface.trace.iter().map(|point| [point.time_s * 1e3, point.mu]));
    Trace {
        // The averaging window extends to the end of the trace.
        window_ms: surface.averaged_from_s.zip(points.last()).map(|(from_s, end)| [from_s * 1e3, end[0]]),
        mu_dynamic: surface.mu_dynamic.map(|value| Estimate { value, error: std }),
        series: Series { label, points },
    }
}

/// Converts the pressure in MPa on contact blocks against x in micrometres to a series named `label`.
pub fn pressures<'a>(label: &'a str, interface: &[InterfacePoint]) -> Series<'a> {
    let point = |point: &InterfacePoint| [LENGTH_UM.from_si(point.x_m), PRESSURE_MPA.from_si(point.pressure_pa)];
    Series { label, points: finite(interface.iter().map(point)) }
}

/// Keeps the points whose numbers are finite.
fn finite(points: impl Iterator<Item = [f64; 2]>) -> Vec<[f64; 2]> {
    points.filter(|point| point.iter().all(|value| value.is_finite())).collect()
}

/// Draws the pressure over the interface of a three-dimensional cell, seen from above; `load_mpa` is the nominal
/// pressure in the title. `None` if no block has a finite pressure.
///
/// # Errors
/// [`ChartError`] if the picture cannot be drawn.
pub fn interface_map(scene: &Scene, load: &LoadOutcome, load_mpa: f64) -> Result<Option<String>, ChartError> {
    let points = &load.surface.interface;
    let [x, y] = columns(scene, points);
    let mut values = vec![f64::NAN; x.count * y.count];
    for point in points {
        if let Some(value) = values.get_mut(x.number(point.x_m) * y.count + y.number(point.y_m)) {
            *value = PRESSURE_MPA.from_si(point.pressure_pa);
        }
    }
    if values.iter().all(|value| !value.is_finite()) {
        return Ok(None);
    }
    let extreme = |of: fn(f64, f64) -> f64| values.iter().copied().filter(|value| value.is_finite()).fold(0.0, of);
    let scale = [extreme(f64::min), extreme(f64::max)];
    let texture = scene.pattern.as_ref().map(|pattern| *pattern.texture());
    let label = sliding_words(texture.as_ref());
    let grey = if texture.is_some() { "; cavities grey" } else { "" };
    let title = format!("Contact pressure at {load_mpa} MPa{grey}");
    let side_um = [x, y].map(|columns| LENGTH_UM.from_si(columns.count as f64 * columns.spacing_m));
    let pressures = SurfaceValues { values: &values, columns: y.count, unit: "MPa", scale, side_um };
    let direction = texture.map_or([1.0, 0.0], |texture| texture.sliding_direction());
    surface_map(&title, &pressures, None, Some((direction, &label))).map(Some)
}

/// Describes the sliding direction of a face seen from above, in the axes of the drawing, which are the texture's axes.
fn sliding_words(texture: Option<&Texture>) -> String {
    let (sliding_deg, own_deg) =
        texture.map_or((0.0, 0.0), |texture| (texture.sliding_angle_deg(), texture.orientation_deg()));
    let own = match own_deg {
        0.0 => String::new(),
        own_deg => format!(", the texture's own axis, {}° from the specimen's x", tidy(own_deg)),
    };
    match tidy(sliding_deg - own_deg) {
        0.0 => format!("sliding direction x{own}"),
        angle_deg => format!("sliding direction, {angle_deg}° from x{own}"),
    }
}

/// Columns of blocks along one axis, side by side from position 0.
#[derive(Clone, Copy)]
struct Columns {
    spacing_m: f64,
    count: usize,
}

impl Columns {
    /// Index of the column that contains the position `place_m`.
    fn number(&self, place_m: f64) -> usize {
        // Centres of blocks are positive; indices are limited to the last column.
        ((place_m / self.spacing_m) as usize).min(self.count - 1)
    }
}

/// Columns along x and y of the cell that contains `points`.
fn columns(scene: &Scene, points: &[InterfacePoint]) -> [Columns; 2] {
    let reach = |place: fn(&InterfacePoint) -> f64| points.iter().map(place).fold(0.0, f64::max);
    let block_m = scene.layer.block_m;
    let filled = |reach_m: f64, spacing_m: f64| Columns { spacing_m, count: (reach_m / spacing_m) as usize + 1 };
    let reach = [reach(|point| point.x_m), reach(|point| point.y_m)];
    let Some(pattern) = scene.pattern else { return reach.map(|reach_m| filled(reach_m, block_m)) };
    let (cell_m, cells) = (pattern.cell_m(), SteadyCell::new(scene).columns(&pattern));
    // Whole numbers, at least 1.
    let divided = |axis: usize| Columns { spacing_m: cell_m[axis] / cells[axis], count: cells[axis].max(1.0) as usize };
    // Along a groove, columns fill the length for which the run was made.
    [divided(0), if pattern.is_uniform_along_y() { filled(reach[1], block_m) } else { divided(1) }]
}

/// Contact blocks of each of `surfaces`, solved as strips, on one line along the sliding direction; x runs along the
/// line. The chosen line has the fewest blocks of the `patterned` surface, so that it runs through the middle of
/// cavities.
fn lines_through_cavities(
    scene: &Scene,
    surfaces: &[(&'static str, &SurfaceOutcome)],
    patterned: &SurfaceOutcome,
) -> Vec<Vec<InterfacePoint>> {
    let is_turned = scene.pattern.is_some_and(|pattern| !pattern.texture().slides_along_rows());
    let turned = |point: &InterfacePoint| match is_turned {
        true => InterfacePoint { x_m: point.y_m, y_m: point.x_m, ..*point },
        false => *point,
    };
    let mut lines: BTreeMap<u64, usize> = BTreeMap::new();
    // Centres of blocks are positive, so that their bit patterns sort like their values.
    patterned.interface.iter().for_each(|point| *lines.entry(turned(point).y_m.to_bits()).or_default() += 1);
    let fewest = lines.values().copied().min().unwrap_or(0);
    let alike: Vec<u64> = lines.iter().filter(|(_, count)| **count == fewest).map(|(line, _)| *line).collect();
    let chosen = alike.get(alike.len() / 2).copied().unwrap_or(0);
    let on_line = |surface: &SurfaceOutcome| -> Vec<InterfacePoint> {
        surface.interface.iter().map(turned).filter(|point| point.y_m.to_bits() == chosen).collect()
    };
    surfaces.iter().map(|(_, surface)| on_line(surface)).collect()
}

/// Start and end along x, in micrometres, of each cavity: gaps between the contact blocks `interface`, accurate to one
/// block. Empty for a flat surface.
pub fn cavities_um(scene: &Scene, interface: &[InterfacePoint]) -> Vec<[f64; 2]> {
    if scene.pattern.is_none() {
        return Vec::new();
    }
    let block_m = scene.layer.block_m;
    interface
        .windows(2)
        .filter(|pair| pair[1].x_m - pair[0].x_m > CONTIGUOUS_BLOCKS * block_m)
        .map(|pair| [pair[0].x_m + block_m / 2.0, pair[1].x_m - block_m / 2.0].map(|x_m| LENGTH_UM.from_si(x_m)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_model::pattern::Planform;

    #[test]
    fn the_sliding_direction_is_told_in_the_axes_of_the_drawn_face() {
        let grooves = Texture::new(Planform::Groove);
        assert_eq!(sliding_words(None), "sliding direction x");
        assert_eq!(sliding_words(Some(&grooves)), "sliding direction x");
        let slid = grooves.with_sliding_angle_deg(30.0).unwrap();
        assert_eq!(sliding_words(Some(&slid)), "sliding direction, 30° from x");
        // Drawn across the grooves, for any orientation on the specimen.
        let turned = grooves.with_groove_angle_deg(30.0).unwrap();
        let own = ", the texture's own axis, 30° from the specimen's x";
        assert_eq!(sliding_words(Some(&turned)), format!("sliding direction, -30° from x{own}"));
        assert_eq!(
            sliding_words(Some(&turned.with_sliding_angle_deg(30.0).unwrap())),
            format!("sliding direction x{own}")
        );
    }
}
