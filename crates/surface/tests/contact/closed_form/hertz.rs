use std::f64::consts::PI;

/// Contact of a paraboloid of radius R with a plane under the force F.
///
/// H. Hertz, J. reine angew. Math. 92, 156 (1881); K. L. Johnson, Contact Mechanics, section 4.2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hertz {
    contact_radius_m: f64,
    peak_pressure_pa: f64,
}

impl Hertz {
    /// Solves the contact of a paraboloid of radius `radius_m` under the force `force_n` for the contact modulus E*.
    pub fn new(radius_m: f64, force_n: f64, contact_modulus_pa: f64) -> Self {
        // a = (3 F R / (4 E*))^(1/3),  p0 = 3 F / (2 pi a^2)
        let contact_radius_m = libm::cbrt(0.75 * force_n * radius_m / contact_modulus_pa);
        let peak_pressure_pa = 1.5 * force_n / (PI * contact_radius_m * contact_radius_m);
        Self { contact_radius_m, peak_pressure_pa }
    }

    /// Radius of the contact a, in metres.
    pub const fn contact_radius_m(&self) -> f64 {
        self.contact_radius_m
    }

    /// Pressure at the centre p0, in pascals.
    pub const fn peak_pressure_pa(&self) -> f64 {
        self.peak_pressure_pa
    }

    /// Pressure at the distance `r_m` from the centre, in pascals.
    pub fn pressure_pa(&self, r_m: f64) -> f64 {
        // p = p0 sqrt(1 - r^2/a^2)
        let share = r_m / self.contact_radius_m;
        self.peak_pressure_pa * (1.0 - share * share).max(0.0).sqrt()
    }
}

#[test]
fn numbers_of_a_worked_case_and_the_force() {
    // R = 10 mm, F = 0.057 N, E* = 427.5 MPa: a = 0.1 mm.
    let hertz = Hertz::new(0.01, 0.057, 427.5e6);
    assert!((hertz.contact_radius_m() - 1e-4).abs() < 1e-17);
    assert!((hertz.peak_pressure_pa() - 2.721_549e6).abs() < 1.0);
    // The integral of the pressure equals the force: 2 pi int p r dr.
    let steps = 200_000;
    let width = hertz.contact_radius_m() / f64::from(steps);
    let force: f64 =
        (0..steps).map(|n| (f64::from(n) + 0.5) * width).map(|r| 2.0 * PI * r * hertz.pressure_pa(r) * width).sum();
    assert!((force / 0.057 - 1.0).abs() < 1e-7, "{force}");
    assert_eq!(hertz.pressure_pa(1.1e-4), 0.0);
}
