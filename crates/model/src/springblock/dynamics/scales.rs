//! Units of the time integration: lattice spacing l, spring stiffness k, block mass m, hence the time sqrt(m/k).

use crate::material::Elastic;

/// SI values of the units of the time integration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scales {
    /// Unit of length l, the lattice spacing, in metres.
    pub length_m: f64,
    /// Unit of time sqrt(m/k), with block mass m and spring stiffness k, in seconds.
    pub time_s: f64,
    /// Unit of pressure, in pascals: spring stiffness over lattice spacing, k/l, the pressure of the unit force k l on
    /// the face l^2 of one block.
    pub pressure_pa: f64,
}

impl Scales {
    /// Creates the units of a lattice in the vertical plane with blocks `block_m` metres apart.
    pub fn new(elastic: &Elastic, block_m: f64) -> Self {
        // k = 3/4 E l
        Self::from_pressure_unit(0.75 * elastic.youngs_modulus_pa(), elastic, block_m)
    }

    /// Creates the units of a lattice in space with blocks `block_m` metres apart.
    pub fn space(elastic: &Elastic, block_m: f64) -> Self {
        // k = 2/5 E l
        Self::from_pressure_unit(0.4 * elastic.youngs_modulus_pa(), elastic, block_m)
    }

    /// Creates the units from the unit of pressure `pressure_pa` = k/l, in pascals.
    fn from_pressure_unit(pressure_pa: f64, elastic: &Elastic, block_m: f64) -> Self {
        // m = rho l^3: m/k = rho l^2 / (k/l)
        Self { length_m: block_m, time_s: block_m * (elastic.density_kg_m3() / pressure_pa).sqrt(), pressure_pa }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frequency_of_the_published_polymer() {
        let scales = Scales::new(&Elastic::new(0.38e9, 900.0).unwrap(), 10e-6);
        assert!((1.0 / scales.time_s / 5.6273e7 - 1.0).abs() < 1e-4);
        // c_p = sqrt(C11/rho) = sqrt(3/2 k/l / rho) with nu = 1/3
        assert!((1.5_f64.sqrt() * scales.length_m / scales.time_s - 689.20).abs() < 0.01);
    }
}
