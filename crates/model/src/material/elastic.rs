use crate::material::MaterialError;
use crate::material::error::positive;

/// Elastic constants and density of an isotropic solid. Poisson's ratio is not included: the lattice fixes it, and
/// functions for the half-space take it as an argument.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elastic {
    youngs_modulus_pa: f64,
    density_kg_m3: f64,
    yield_pressure_pa: Option<f64>,
}

impl Elastic {
    /// Creates a solid with Young's modulus `youngs_modulus_pa` and density `density_kg_m3`.
    ///
    /// # Errors
    /// [`MaterialError`] unless both are positive and finite.
    pub fn new(youngs_modulus_pa: f64, density_kg_m3: f64) -> Result<Self, MaterialError> {
        Ok(Self {
            youngs_modulus_pa: positive("Young's modulus", youngs_modulus_pa)?,
            density_kg_m3: positive("density", density_kg_m3)?,
            yield_pressure_pa: None,
        })
    }

    /// Young's modulus E, in pascals.
    pub const fn youngs_modulus_pa(&self) -> f64 {
        self.youngs_modulus_pa
    }

    /// Mass density rho, in kg/m^3.
    pub const fn density_kg_m3(&self) -> f64 {
        self.density_kg_m3
    }

    /// Returns the solid with Young's modulus multiplied by `factor`.
    ///
    /// # Errors
    /// See [`Self::new`].
    pub fn at_modulus(&self, factor: f64) -> Result<Self, MaterialError> {
        Ok(Self {
            yield_pressure_pa: self.yield_pressure_pa,
            ..Self::new(self.youngs_modulus_pa * factor, self.density_kg_m3)?
        })
    }

    /// Sets the contact pressure, in pascals, at which heights of the face (rims or a measured relief) are flattened
    /// permanently; `None` for an elastic solid.
    ///
    /// # Errors
    /// [`MaterialError`] unless the pressure is positive and finite.
    pub fn with_yield_pressure_pa(self, yield_pressure_pa: Option<f64>) -> Result<Self, MaterialError> {
        let checked = yield_pressure_pa.map(|value_pa| positive("yield pressure", value_pa)).transpose()?;
        Ok(Self { yield_pressure_pa: checked, ..self })
    }

    /// Contact pressure at which heights of the face are flattened permanently, in pascals: about three times the yield
    /// stress. `None` for an elastic solid.
    pub const fn yield_pressure_pa(&self) -> Option<f64> {
        self.yield_pressure_pa
    }

    /// Contact modulus E* = E / (1 - nu^2) against a rigid body, in pascals.
    pub fn contact_modulus_pa(&self, poisson_ratio: f64) -> f64 {
        self.youngs_modulus_pa / (1.0 - poisson_ratio * poisson_ratio)
    }
}
