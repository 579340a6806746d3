//! Contact problems with closed-form solutions, which the solver is compared with.

use std::f64::consts::{PI, SQRT_2};

/// Contact of a paraboloid of radius R with a plane under the force F.
///
/// H. Hertz, J. reine angew. Math. 92, 156 (1881); K. L. Johnson, Contact Mechanics, section 4.2.
pub struct Hertz {
    /// Radius of the contact a, in metres.
    pub contact_radius_m: f64,
    /// Pressure at the centre p0, in pascals.
    pub peak_pressure_pa: f64,
}

impl Hertz {
    pub fn new(radius_m: f64, force_n: f64, contact_modulus_pa: f64) -> Self {
        // a = (3 F R / (4 E*))^(1/3),  p0 = 3 F / (2 pi a^2)
        let contact_radius_m = libm::cbrt(0.75 * force_n * radius_m / contact_modulus_pa);
        let peak_pressure_pa = 1.5 * force_n / (PI * contact_radius_m * contact_radius_m);
        Self { contact_radius_m, peak_pressure_pa }
    }

    /// Pressure at the distance `r_m` from the centre, in pascals.
    pub fn pressure_pa(&self, r_m: f64) -> f64 {
        // p = p0 sqrt(1 - r^2/a^2)
        let share = r_m / self.contact_radius_m;
        self.peak_pressure_pa * (1.0 - share * share).max(0.0).sqrt()
    }
}

/// A surface with one wave, h = D cos(2 pi x / lambda).
///
/// H. M. Westergaard, J. Appl. Mech. 6, A49 (1939); K. L. Johnson, Contact Mechanics, section 13.2.
pub struct Wave {
    wavelength_m: f64,
    /// p*, the mean pressure of full contact, in pascals.
    pub full_contact_pressure_pa: f64,
}

impl Wave {
    pub fn new(amplitude_m: f64, wavelength_m: f64, contact_modulus_pa: f64) -> Self {
        // p* = pi E* D / lambda
        Self { wavelength_m, full_contact_pressure_pa: PI * contact_modulus_pa * amplitude_m / wavelength_m }
    }

    /// sin(psi) with psi = pi a / lambda, a the half width of the contact.
    fn sine(&self, nominal_pa: f64) -> f64 {
        // P = p* sin^2(psi)
        (nominal_pa / self.full_contact_pressure_pa).clamp(0.0, 1.0).sqrt()
    }

    /// Pressure at the distance `x_m` from a crest under the mean pressure `nominal_pa`, below p*, in pascals.
    pub fn pressure_pa(&self, nominal_pa: f64, x_m: f64) -> f64 {
        // p = 2 P cos(pi x/lambda) / sin^2(psi) sqrt(sin^2(psi) - sin^2(pi x/lambda))
        let angle = PI * (x_m / self.wavelength_m);
        let (sine, sine_x) = (self.sine(nominal_pa), libm::sin(angle));
        let inside = (sine * sine - sine_x * sine_x).max(0.0);
        2.0 * self.full_contact_pressure_pa * libm::cos(angle).abs() * inside.sqrt()
    }
}

/// p* of two crossed waves, h = D cos(2 pi x / lambda) cos(2 pi y / lambda), in pascals.
///
/// K. L. Johnson, J. A. Greenwood and J. G. Higginson, Int. J. Mech. Sci. 27, 383 (1985).
pub fn crossed_waves_full_contact_pa(amplitude_m: f64, wavelength_m: f64, contact_modulus_pa: f64) -> f64 {
    SQRT_2 * PI * contact_modulus_pa * amplitude_m / wavelength_m
}
