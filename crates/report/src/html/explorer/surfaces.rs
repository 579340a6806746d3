//! Response surfaces as encoded in a page.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::Serialize;
use serde_json::{Value, json};
use slipgrid_base::statistics::{ResponseSurface, extremes};
use slipgrid_base::units::LENGTH_UM;
use slipgrid_design::DesignTask;
use slipgrid_laser::export::Outline;
use slipgrid_model::pattern::{Contour, Pattern, Planform};
use slipgrid_model::springblock::Dimension;

/// Names of the axes of the surfaces, in order.
pub const LENGTHS: [&str; 3] = ["width", "spacing", "depth"];

/// Coefficients of outputs of a response surface, one entry per output: the smallest, the step, and the numbers of steps
/// above the smallest, as 16-bit integers, little endian, in base64.
#[derive(Serialize)]
pub struct Packed(Vec<(f64, f64, String)>);

impl Packed {
    /// Encodes the outputs of `surface` with the indices `places`.
    pub fn new(surface: &ResponseSurface, places: impl IntoIterator<Item = usize>) -> Self {
        let output = |place: usize| {
            let all = surface.coefficients().iter().skip(place).step_by(surface.outputs());
            let [least, most] = extremes(all.clone().copied());
            let step = (most - least).max(f64::MIN_POSITIVE) / f64::from(u16::MAX);
            let bytes = all.flat_map(|value| (((value - least) / step).round() as u16).to_le_bytes());
            (least, step, STANDARD.encode(bytes.collect::<Vec<u8>>()))
        };
        Self(places.into_iter().map(output).collect())
    }
}

#[derive(Serialize)]
pub struct AxisData {
    pub name: &'static str,
    pub from: f64,
    pub to: f64,
    pub nodes: usize,
}

pub fn axes_data(surface: &ResponseSurface) -> Vec<AxisData> {
    let named = surface.axes().iter().zip(LENGTHS);
    named.map(|(axis, name)| AxisData { name, from: axis.from, to: axis.to, nodes: axis.nodes }).collect()
}

/// Specimen and lattice of `task` by which the page counts complete cavities, in micrometres; `None` if it cannot count
/// them, and their number is interpolated: cut cavities, of which the area hardly jumps, crossing grooves, polygons, and
/// models of one section.
///
/// `radius` is that of a disc or a ring, null for a rectangle, and `hole` that of the hole; `half` are half the sides of
/// a rectangle along the pattern's x and y axes; `is_shifted` tells whether odd rows are shifted by half a pitch;
/// `length` of a cavity, and `across`, the pitch across, are a, b and c of a + b times width + c times spacing.
pub fn face_data(task: &DesignTask, dimension: Dimension) -> Option<Value> {
    let texture = task.space.texture();
    let lengths_m = task.space.lengths_m().map(|[least_m, _]| least_m);
    let first = task.space.pattern(lengths_m).ok()?;
    let orientation = texture.orientation();
    let is_even = orientation == [1.0, 0.0] || orientation == [0.0, 1.0];
    let is_counted = !matches!(texture.planform(), Planform::Crosshatch | Planform::Polygon)
        && !task.specimen.is_clipped
        && dimension.section_of(&first).is_none();
    if !is_counted {
        return None;
    }
    let [x, y] = task.specimen.outline.extents_m().map(|m| LENGTH_UM.from_si(m) / 2.0);
    let (radius, hole, half) = match task.specimen.outline {
        Outline::Disc { .. } => (Some(x), 0.0, [x, y]),
        Outline::Ring { inner_diameter_m, .. } => (Some(x), LENGTH_UM.from_si(inner_diameter_m) / 2.0, [x, y]),
        Outline::Rectangle { .. } if !is_even => return None,
        Outline::Rectangle { .. } => (None, 0.0, if orientation[0] == 1.0 { [x, y] } else { [y, x] }),
    };
    // All lengths of a lattice are linear in width and spacing.
    let linear = |of: fn(&Pattern) -> Option<f64>| {
        let [width_m, spacing_m, depth_m] = lengths_m;
        let at = |width_m, spacing_m| of(&task.space.pattern([width_m, spacing_m, depth_m]).ok()?);
        let Some(own) = at(width_m, spacing_m) else { return Some([0.0; 3]) };
        let by_width = (at(2.0 * width_m, spacing_m)? - own) / width_m;
        let by_spacing = (at(width_m, 2.0 * spacing_m)? - own) / spacing_m;
        Some([LENGTH_UM.from_si(own - by_width * width_m - by_spacing * spacing_m), by_width, by_spacing])
    };
    Some(json!({
        "radius": radius,
        "hole": hole,
        "half": half,
        "area": task.specimen.outline.area_m2() * LENGTH_UM.from_si(1.0).powi(2),
        "is_groove": texture.planform() == Planform::Groove,
        "is_round": texture.planform().contour() == Contour::Circle,
        "is_shifted": texture.arrangement().shifts_rows(),
        "length": linear(Pattern::length_m)?,
        "across": linear(Pattern::pitch_across_m)?,
    }))
}
