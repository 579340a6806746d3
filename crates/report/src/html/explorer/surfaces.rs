//! Response surfaces as encoded in a page.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::Serialize;
use slipgrid_base::statistics::ResponseSurface;

use crate::charts::extremes;

/// Names of the axes of the surfaces, in order.
pub const LENGTHS: [&str; 3] = ["width", "spacing", "depth"];
/// Maximum 16-bit code of a coefficient.
const FULL_SCALE: f64 = 65_535.0;

/// Coefficients of outputs of a response surface. The coefficients of each output are encoded as 16-bit codes, little
/// endian, in base64; code 0 is the smallest coefficient of the output, and 65535 the largest.
#[derive(Serialize)]
pub struct Packed {
    /// One entry per output, in order.
    outputs: Vec<Output>,
}

#[derive(Serialize)]
struct Output {
    from: f64,
    to: f64,
    codes: String,
}

impl Packed {
    /// Encodes the outputs of `surface` with the indices `places`.
    pub fn new(surface: &ResponseSurface, places: impl IntoIterator<Item = usize>) -> Self {
        let output = |place: usize| {
            let all = || surface.coefficients().iter().skip(place).step_by(surface.outputs()).copied();
            let [from, to] = extremes(all());
            let span = if to > from { to - from } else { 1.0 };
            // The value lies between 0 and the full scale, so that the cast is exact.
            let code = |value: f64| (((value - from) / span * FULL_SCALE).round() as u16).to_le_bytes();
            let codes: Vec<u8> = all().flat_map(code).collect();
            Output { from, to: from + span, codes: STANDARD.encode(codes) }
        };
        Self { outputs: places.into_iter().map(output).collect() }
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
