//! Response surfaces as the page carries them.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::Serialize;
use slipgrid_design::Explorer;
use slipgrid_pattern::Pattern;
use slipgrid_statistics::ResponseSurface;
use slipgrid_units::{LENGTH_UM, tidy};

/// Names of the axes.
pub const LENGTHS: [&str; 3] = ["width", "spacing", "depth"];
/// Largest of the codes that coefficients are written as.
const FULL_SCALE: f64 = 65_535.0;

/// Numbers as 16-bit codes between two of them, in base64.
#[derive(Serialize)]
pub struct Packed {
    from: f64,
    to: f64,
    codes: String,
}

impl Packed {
    pub fn new(surface: &ResponseSurface) -> Self {
        let all = surface.coefficients();
        let from = all.iter().copied().fold(f64::INFINITY, f64::min);
        let to = all.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let span = if to > from { to - from } else { 1.0 };
        // Between 0 and the full scale: the cast is exact.
        let code = |value: &f64| (((value - from) / span * FULL_SCALE).round() as u16).to_le_bytes();
        let codes: Vec<u8> = all.iter().flat_map(code).collect();
        Self { from, to: from + span, codes: STANDARD.encode(codes) }
    }
}

#[derive(Serialize)]
pub struct AxisData {
    pub name: &'static str,
    pub from: f64,
    pub to: f64,
    pub nodes: usize,
}

/// Rims of other heights than the modelled.
#[derive(Serialize)]
pub struct RimData {
    pub axes: Vec<AxisData>,
    /// Heights over those modelled.
    factors: Vec<f64>,
    /// Modelled heights by the depth of the cavity.
    heights_um: Vec<[f64; 2]>,
    values: Vec<Packed>,
    peak_and_sag: Vec<Packed>,
}

impl RimData {
    pub fn new(explorer: &Explorer, pattern: &Pattern) -> Option<Self> {
        let (changes, rim) = (explorer.rims.as_ref()?, pattern.texture().rim()?);
        Some(Self {
            axes: axes_data(changes.values.first()?),
            factors: changes.factors.clone(),
            heights_um: rim.heights_m().iter().map(|pair| pair.map(|m| tidy(LENGTH_UM.from_si(m)))).collect(),
            values: changes.values.iter().map(Packed::new).collect(),
            peak_and_sag: changes.peak_and_sag.iter().map(Packed::new).collect(),
        })
    }

    /// Least and greatest factor.
    pub fn ends(&self) -> [f64; 2] {
        [self.factors.first().copied().unwrap_or(1.0), self.factors.last().copied().unwrap_or(1.0)]
    }
}

pub fn axes_data(surface: &ResponseSurface) -> Vec<AxisData> {
    let named = surface.axes().iter().zip(LENGTHS);
    named.map(|(axis, name)| AxisData { name, from: axis.from, to: axis.to, nodes: axis.nodes }).collect()
}
