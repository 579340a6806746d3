//! An area law known up to its pressure scale.

use slipgrid_material::{AreaLaw, MaterialError};

/// A contact area curve of which only the scale s of pressure is unknown: A(P) = a(P / s). For a surface
/// of given shape s is proportional to E* h'rms, exactly: A(P; c h) = A(P / c; h).
#[derive(Clone, Debug, PartialEq)]
pub struct AreaLawScale {
    /// P / s, increasing.
    pub pressure_over_scale: Vec<f64>,
    /// Contact area fraction there.
    pub area_fraction: Vec<f64>,
    /// Least and greatest scale, in pascals.
    pub bounds_pa: [f64; 2],
}

impl AreaLawScale {
    /// The law at `scale_pa`, 1 at the first pressure of the curve.
    ///
    /// # Errors
    /// [`MaterialError`] if the curve is no table.
    pub fn law(&self, scale_pa: f64) -> Result<AreaLaw, MaterialError> {
        let pressure_pa: Vec<f64> = self.pressure_over_scale.iter().map(|x| x * scale_pa).collect();
        AreaLaw::from_area_curve(&pressure_pa, &self.area_fraction, pressure_pa.first().copied().unwrap_or(0.0))
    }
}
