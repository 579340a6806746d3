//! Features of a texture that the discrepancy depends on.

use slipgrid_model::pattern::Pattern;

/// Features of a texture that the discrepancy depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Features {
    /// Fraction of a period that is cavity.
    pub areal_density: f64,
    /// Edge length of the cavities over the area of a period, in 1/m.
    pub edge_1_m: f64,
    /// Width of a cavity, in metres.
    pub width_m: f64,
    /// Period along a row, in metres.
    pub pitch_m: f64,
    /// Depth of a cavity, in metres.
    pub depth_m: f64,
    /// Fraction of the face that is cavity, over that of a period: the border of a small specimen leaves cavities out, or
    /// takes one more.
    pub face_share: f64,
}

impl From<&Pattern> for Features {
    fn from(pattern: &Pattern) -> Self {
        Self {
            areal_density: pattern.areal_density(),
            edge_1_m: pattern.edge_per_area_1_m(),
            width_m: pattern.width_m(),
            pitch_m: pattern.pitch_m(),
            depth_m: pattern.depth_m(),
            face_share: 1.0,
        }
    }
}

impl Features {
    /// Features of `pattern` on a face of which cavities take `face_share` times the share of a period.
    pub fn on_face(pattern: &Pattern, face_share: f64) -> Self {
        Self { face_share, ..Self::from(pattern) }
    }

    /// Natural logarithms of width, pitch and depth in metres.
    pub(crate) fn logarithms(&self) -> [f64; 3] {
        [self.width_m, self.pitch_m, self.depth_m].map(libm::log)
    }
}
