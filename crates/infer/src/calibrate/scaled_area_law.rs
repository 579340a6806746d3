//! Area law with an unknown pressure scale.

use slipgrid_model::material::{AreaLaw, MaterialError};

/// A contact area curve with an unknown pressure scale s: A(P) = a(P / s). For a surface of given shape s is exactly
/// proportional to E* h'rms: A(P; c h) = A(P / c; h).
#[derive(Clone, Debug, PartialEq)]
pub struct AreaLawScale {
    /// P / s, increasing.
    pub pressure_over_scale: Vec<f64>,
    /// Contact area fraction at these pressures.
    pub area_fraction: Vec<f64>,
    /// Lower and upper bound of the scale, in pascals.
    pub bounds_pa: [f64; 2],
}

impl AreaLawScale {
    /// Area law at `scale_pa`; 1 at the first pressure of the curve.
    ///
    /// # Errors
    /// [`MaterialError`] if the curve is not a valid table.
    pub fn law(&self, scale_pa: f64) -> Result<AreaLaw, MaterialError> {
        let pressure_pa: Vec<f64> = self.pressure_over_scale.iter().map(|x| x * scale_pa).collect();
        AreaLaw::from_area_curve(&pressure_pa, &self.area_fraction, pressure_pa.first().copied().unwrap_or(0.0))
    }
}
