//! Response surfaces as encoded in a page.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::Serialize;
use serde_json::{Value, json};
use slipgrid_base::statistics::{ResponseSurface, extremes};
use slipgrid_base::units::LENGTH_UM;
use slipgrid_design::DesignTask;
use slipgrid_laser::export::{Outline, depth_within_um, one_exposure};
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
            surface.coefficients().iter().skip(place).step_by(surface.outputs()).copied().collect::<Vec<f64>>()
        };
        Self::of(places.into_iter().map(output))
    }

    fn of(outputs: impl Iterator<Item = Vec<f64>>) -> Self {
        let output = |all: Vec<f64>| {
            let [least, most] = extremes(all.iter().copied());
            let step = (most - least).max(f64::MIN_POSITIVE) / f64::from(u16::MAX);
            let bytes = all.iter().flat_map(|value| (((value - least) / step).round() as u16).to_le_bytes());
            (least, step, STANDARD.encode(bytes.collect::<Vec<u8>>()))
        };
        Self(outputs.map(output).collect())
    }
}

/// Distance of the widths at which exposures are tabulated, in micrometres: the page rounds lengths to it.
const WIDTH_STEP_UM: f64 = 0.1;
/// Maximum number of these widths.
const MAX_WIDTHS: f64 = 4000.0;

/// One exposure by the width of cavities: it jumps where one more line or spot fits, so that it is not interpolated.
#[derive(Serialize)]
pub struct Exposures {
    /// `passes` or `bursts`.
    pub name: &'static str,
    /// Depth of one exposure in micrometres, and its time for a face that is all cavity in seconds, if known; at evenly
    /// spaced widths within the bounds.
    by_width: Packed,
    /// Largest difference of the depth of whole exposures from a fixed depth that counts as none, in micrometres; null
    /// where the depth is free.
    fixed_within_um: Option<f64>,
}

impl Exposures {
    /// Exposures of the cavities of `task`; `None` if the laser's depth is unknown.
    pub fn new(task: &DesignTask) -> Option<Self> {
        let [[from_m, to_m], [_, spacing_m], [least_m, depth_m]] = task.space.lengths_m();
        let last = (LENGTH_UM.from_si(to_m - from_m) / WIDTH_STEP_UM).ceil().min(MAX_WIDTHS);
        let at = |place: u32| {
            let width_m = from_m + (to_m - from_m) * f64::from(place) / last.max(1.0);
            one_exposure(&task.space.pattern([width_m, spacing_m, depth_m]).ok()?, &task.laser)
        };
        let all: Vec<(f64, Option<f64>)> = (0..=last as u32).map(at).collect::<Option<_>>()?;
        let area_m2 = task.specimen.outline.area_m2();
        let seconds: Option<Vec<f64>> = all.iter().map(|(_, time_s_m2)| Some(time_s_m2.as_ref()? * area_m2)).collect();
        let depths = all.iter().map(|(depth_um, _)| *depth_um).collect();
        let name = task.laser.exposures_name();
        let std_um = task.tolerances.map(|of| of.depth_std_um);
        let fixed_within_um = (least_m == depth_m)
            .then(|| depth_within_um(LENGTH_UM.from_si(depth_m), std_um.filter(|std_um| *std_um > 0.0)));
        Some(Self { name, by_width: Packed::of(std::iter::once(depths).chain(seconds)), fixed_within_um })
    }

    /// Whether the time is known.
    pub fn have_time(&self) -> bool {
        self.by_width.0.len() > 1
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
