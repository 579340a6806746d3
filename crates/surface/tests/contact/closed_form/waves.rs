use std::f64::consts::{PI, SQRT_2};

/// E* D / lambda, in pascals.
fn slope_pressure_pa(amplitude_m: f64, wavelength_m: f64, contact_modulus_pa: f64) -> f64 {
    contact_modulus_pa * amplitude_m / wavelength_m
}

/// A surface with one wave, h = D cos(2 pi x / lambda).
///
/// H. M. Westergaard, J. Appl. Mech. 6, A49 (1939); K. L. Johnson, Contact Mechanics, section 13.2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wave {
    wavelength_m: f64,
    full_contact_pressure_pa: f64,
}

impl Wave {
    /// Creates a wave of amplitude D and wavelength lambda on a half-space of contact modulus E*.
    pub fn new(amplitude_m: f64, wavelength_m: f64, contact_modulus_pa: f64) -> Self {
        // p* = pi E* D / lambda
        let full_contact_pressure_pa = PI * slope_pressure_pa(amplitude_m, wavelength_m, contact_modulus_pa);
        Self { wavelength_m, full_contact_pressure_pa }
    }

    /// p*, the mean pressure of full contact, in pascals.
    pub const fn full_contact_pressure_pa(&self) -> f64 {
        self.full_contact_pressure_pa
    }

    /// sin(psi) with psi = pi a / lambda, a the half width of the contact.
    fn sine(&self, nominal_pa: f64) -> f64 {
        // P = p* sin^2(psi)
        (nominal_pa / self.full_contact_pressure_pa).clamp(0.0, 1.0).sqrt()
    }

    /// Real contact area fraction under the mean pressure `nominal_pa`.
    pub fn area_fraction(&self, nominal_pa: f64) -> f64 {
        // 2 a / lambda = (2/pi) asin sqrt(P/p*)
        2.0 / PI * libm::asin(self.sine(nominal_pa))
    }

    /// Pressure at the distance `x_m` from a crest under the mean pressure `nominal_pa`, in pascals.
    pub fn pressure_pa(&self, nominal_pa: f64, x_m: f64) -> f64 {
        let angle = PI * (x_m / self.wavelength_m);
        if nominal_pa >= self.full_contact_pressure_pa {
            // p = P + p* cos(2 pi x / lambda)
            return nominal_pa + self.full_contact_pressure_pa * libm::cos(2.0 * angle);
        }
        // p = 2 P cos(pi x/lambda) / sin^2(psi) sqrt(sin^2(psi) - sin^2(pi x/lambda))
        let (sine, sine_x) = (self.sine(nominal_pa), libm::sin(angle));
        let inside = sine * sine - sine_x * sine_x;
        if inside <= 0.0 {
            return 0.0;
        }
        2.0 * self.full_contact_pressure_pa * libm::cos(angle).abs() * inside.sqrt()
    }
}

/// A surface with two crossed waves, h = D cos(2 pi x / lambda) cos(2 pi y / lambda).
///
/// K. L. Johnson, J. A. Greenwood and J. G. Higginson, Int. J. Mech. Sci. 27, 383 (1985).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CrossedWaves {
    full_contact_pressure_pa: f64,
}

impl CrossedWaves {
    /// Creates crossed waves of amplitude D and wavelength lambda on a half-space of contact modulus E*.
    pub fn new(amplitude_m: f64, wavelength_m: f64, contact_modulus_pa: f64) -> Self {
        // p* = sqrt 2 pi E* D / lambda
        let full_contact_pressure_pa = SQRT_2 * PI * slope_pressure_pa(amplitude_m, wavelength_m, contact_modulus_pa);
        Self { full_contact_pressure_pa }
    }

    /// p*, the mean pressure of full contact, in pascals.
    pub const fn full_contact_pressure_pa(&self) -> f64 {
        self.full_contact_pressure_pa
    }
}

#[test]
fn the_pressure_under_a_wave_carries_the_load() {
    let wave = Wave::new(1e-6, 1e-3, 427.5e6);
    let full = wave.full_contact_pressure_pa();
    for share in [0.1, 0.6, 0.999, 1.0, 1.5] {
        let steps = 100_000;
        let mean = (0..steps)
            .map(|n| wave.pressure_pa(share * full, (f64::from(n) + 0.5) * 1e-3 / f64::from(steps)))
            .sum::<f64>()
            / f64::from(steps);
        assert!((mean / (share * full) - 1.0).abs() < 1e-6, "{share}: {mean}");
    }
    assert!((wave.area_fraction(0.5 * full) - 0.5).abs() < 1e-15);
    assert_eq!((wave.area_fraction(0.0), wave.area_fraction(2.0 * full)), (0.0, 1.0));
    // The pressure is zero just outside the contact width and positive just inside.
    let half_m = 0.5e-3 * wave.area_fraction(0.3 * full);
    assert_eq!(wave.pressure_pa(0.3 * full, half_m * 1.000_001), 0.0);
    assert!(wave.pressure_pa(0.3 * full, half_m * 0.999_999) > 0.0);
}
