//! Response surfaces as encoded in a page.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::Serialize;
use slipgrid_base::statistics::ResponseSurface;

/// Names of the axes of the surfaces, in order.
pub const LENGTHS: [&str; 3] = ["width", "spacing", "depth"];

/// Coefficients of outputs of a response surface, one entry per output: single precision, little endian, in base64.
#[derive(Serialize)]
pub struct Packed(Vec<String>);

impl Packed {
    /// Encodes the outputs of `surface` with the indices `places`.
    pub fn new(surface: &ResponseSurface, places: impl IntoIterator<Item = usize>) -> Self {
        let output = |place: usize| {
            let all = surface.coefficients().iter().skip(place).step_by(surface.outputs());
            STANDARD.encode(all.flat_map(|value| (*value as f32).to_le_bytes()).collect::<Vec<u8>>())
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
