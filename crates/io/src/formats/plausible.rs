//! Limits of plausibility: values that dry friction experiments on solids give, and values that cannot be measured.
//!
//! The ranges of [`slipgrid_base::units`] define the numbers that a file may hold; the ranges here define the plausible ones.
//! A calibration refuses impossible values and warns of unusual ones; a scene, which may be a thought experiment, only
//! gets warnings.

use crate::formats::diagnostic::Diagnostic;
use slipgrid_base::units::{MAX_DENSITY_G_CM3, MAX_MODULUS_GPA, Quantity, in_digits, significant, tidy};

/// Limits of plausibility of a quantity of an experiment, in the unit of the key in files.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plausible {
    /// Name of the quantity, in the plural.
    pub what: &'static str,
    /// Unit, as in the key.
    pub unit: &'static str,
    /// Range of values that can be measured.
    pub measurable: [f64; 2],
    /// Range outside which a mistake is more probable than a discovery.
    pub usual: [f64; 2],
    /// Examples at the ends of the ranges.
    pub why: &'static str,
    /// Units that are often mistaken for the unit of the key, with conversion factors.
    slips: &'static [(&'static str, f64)],
}

/// Units often mistaken for micrometres, with their factors to micrometres.
const OF_MICROMETRES: &[(&str, f64)] = &[("in mm, that", 1e3), ("in nm, that", 1e-3)];

/// Plausible friction coefficients.
pub const FRICTION: Plausible = Plausible {
    what: "friction coefficients",
    unit: "",
    measurable: [1e-3, 10.0],
    usual: [0.01, 3.0],
    why: "graphite slides at 0.01, rubber at 3, clean metals in vacuum at 10",
    slips: &[("in per cent, that", 1e-2)],
};
/// Plausible friction coefficients computed from a recorded friction force.
pub const FRICTION_OF_FORCE: Plausible = Plausible {
    slips: &[("with the friction force in mN, as `Fx [mN]`, that", 1e-3), ("in kN, as `Fx [kN]`, that", 1e3)],
    ..FRICTION
};
/// Plausible friction coefficients computed from a recorded torque.
pub const FRICTION_OF_TORQUE: Plausible = Plausible {
    slips: &[
        ("with the torque in N mm or mN m, as `torque [mN m]`, that", 1e-3),
        ("with the torque in N m, as `torque [N m]`, that", 1e3),
    ],
    ..FRICTION
};
/// Plausible Young's moduli of specimens, in GPa.
pub const MODULUS: Plausible = Plausible {
    what: "Young's moduli",
    unit: "GPa",
    measurable: [1e-6, MAX_MODULUS_GPA],
    usual: [5e-4, 250.0],
    why: "rubber has 0.001, polymers 0.1 to 5, steel 210, diamond 1220 GPa",
    slips: &[("in MPa, that", 1e-3), ("in Pa, that", 1e-9)],
};
/// Plausible densities of specimens, in g/cm^3.
pub const DENSITY: Plausible = Plausible {
    what: "densities",
    unit: "g/cm3",
    measurable: [1e-3, MAX_DENSITY_G_CM3],
    usual: [0.1, 20.0],
    why: "foams have 0.1, polymers 0.9 to 2.2, steel 7.9, osmium 22.6 g/cm3",
    slips: &[("in kg/m3, that", 1e-3)],
};
/// Plausible sliding speeds, in mm/s.
pub const SPEED: Plausible = Plausible {
    what: "sliding speeds",
    unit: "mm/s",
    measurable: [1e-7, 1e5],
    usual: [1e-4, 1e3],
    why: "tribometers slide at 0.1 um/s to 1 m/s, brakes at up to 100 m/s",
    slips: &[("in um/s, that", 1e-3), ("in m/s, that", 1e3)],
};
/// Plausible normal forces on one specimen, in newtons.
pub const FORCE: Plausible = Plausible {
    what: "normal forces",
    unit: "N",
    measurable: [1e-6, 1e6],
    usual: [1e-3, 1e4],
    why: "microtribometers load with 1 mN, large rigs with 10 kN",
    slips: &[("in mN, that", 1e-3), ("in kN, that", 1e3)],
};
/// Plausible nominal pressures, in MPa.
pub const PRESSURE: Plausible = Plausible {
    what: "nominal pressures",
    unit: "MPa",
    measurable: [1e-7, 1e4],
    usual: [1e-4, 100.0],
    why: "a specimen's own weight presses with 100 Pa, bearings with 100 MPa",
    slips: &[],
};
/// Plausible nominal pressures, in MPa, that a key states directly, not through a force.
pub const GIVEN_PRESSURE: Plausible = Plausible { slips: &[("in kPa, that", 1e-3), ("in Pa, that", 1e-6)], ..PRESSURE };
/// Plausible ratios of nominal pressure to Young's modulus.
pub const STRAIN: Plausible = Plausible {
    what: "nominal pressures over Young's modulus",
    unit: "",
    measurable: [0.0, slipgrid_design::MAX_STRAIN],
    usual: [0.0, 0.05],
    why: "polymers yield at 0.05 and below, and the model is linear",
    slips: &[],
};
/// Plausible ratios of the standard deviation of a friction coefficient to its mean.
pub const RELATIVE_DEVIATION: Plausible = Plausible {
    what: "standard deviations of friction over its mean",
    unit: "",
    measurable: [1e-6, 1.0],
    usual: [1e-4, 0.5],
    why: "repeats differ by 0.1 % at best; with a deviation of zero one row would count infinitely",
    slips: &[],
};
/// Plausible extents of specimens, in millimetres.
pub const SPECIMEN: Plausible = Plausible {
    what: "extents of specimens",
    unit: "mm",
    measurable: [1e-3, 1e4],
    usual: [0.1, 500.0],
    why: "pins have 0.1 mm, test plates 0.5 m",
    slips: &[("in um, that", 1e-3)],
};

/// Plausible diameters of laser spots, in micrometres.
pub const SPOT: Plausible = Plausible {
    what: "laser spots",
    unit: "um",
    measurable: [0.2, 1e4],
    usual: [0.2, 1e4],
    why: "light is focused to half its wavelength at best, and masks let through 10 mm at most",
    slips: OF_MICROMETRES,
};

/// Plausible widths of cavities and gaps between cavities, in micrometres.
pub const CAVITY_WIDTH: Plausible = Plausible {
    what: "widths and gaps of cavities",
    unit: "um",
    measurable: [1e-3, 1e7],
    usual: [1.0, 1e4],
    why: "lasers cut from 1 um, and cutters up to 10 mm",
    slips: OF_MICROMETRES,
};
/// Plausible heights of rims, in micrometres.
pub const RIM_HEIGHT: Plausible = Plausible {
    what: "heights of rims",
    unit: "um",
    measurable: [0.0, 1000.0],
    usual: [0.0, 20.0],
    why: "lasers leave rims of 0.1 to 10 um around cavities",
    slips: &[("in nm, that", 1e-3)],
};
/// Plausible depths of cavities, in micrometres.
pub const CAVITY_DEPTH: Plausible = Plausible {
    what: "depths of cavities",
    unit: "um",
    measurable: [1e-4, 1e6],
    usual: [0.2, 1e3],
    why: "what is shallower drowns in roughness, and lasers cut up to 1 mm deep",
    slips: OF_MICROMETRES,
};

/// Density in g/cm3 below which a solid is a polymer, an elastomer or wood: fibres, metals and minerals are denser in
/// bulk.
const LIGHT_G_CM3: f64 = 1.4;
/// Highest known Young's modulus of light solids in GPa, along the grain of wood.
const LIGHT_MODULUS_GPA: f64 = 20.0;

/// Warns of a modulus that is usual in itself but too high for a solid of this density, and names the probable unit;
/// `None` if the two agree.
pub fn stiff_for_its_density(modulus_gpa: f64, density_g_cm3: f64) -> Option<String> {
    let is_doubtful = density_g_cm3 < LIGHT_G_CM3 && modulus_gpa > LIGHT_MODULUS_GPA;
    let usual = MODULUS.within([MODULUS.usual[0], LIGHT_MODULUS_GPA]);
    let slip = usual.slip(modulus_gpa).filter(|_| is_doubtful && MODULUS.judge(modulus_gpa) == Ok(None))?;
    Some(format!(
        "is unusual: solids lighter than {LIGHT_G_CM3} g/cm3 have at most {LIGHT_MODULUS_GPA} GPa, and density_g_cm3 is {density_g_cm3}; {slip}"
    ))
}

/// Warns of a relative humidity that is probably a fraction of 1; `None` for others. Air in a room has 20 to 80 %; zero
/// stands for dry air.
pub fn share_of_one(humidity_pct: f64) -> Option<String> {
    (humidity_pct > 0.0 && humidity_pct <= 1.0).then(|| {
        let meant = tidy(100.0 * humidity_pct);
        format!("at most 1 %, and only dried gas has so little; as a share of 1, that would be {meant} %")
    })
}

/// Plausible ratios of the friction of a patterned to that of a flat sample at equal load, speed and humidity. Other
/// ratios only give warnings.
pub const RATIO: Plausible = Plausible {
    what: "ratios of patterned to flat friction",
    unit: "",
    measurable: [0.0, 1e3],
    usual: [0.2, 1.3],
    why: "published textures change dry friction by some tens of per cent at most",
    slips: &[
        ("in per cent, that", 1e-2),
        ("with the decimal point one place to the left it", 0.1),
        ("with the decimal point one place to the right it", 10.0),
    ],
};

/// Few dry solids have a friction coefficient above this; rubber does.
const HIGH_FRICTION: f64 = 1.0;
/// Range of usual friction, in which the reciprocals of coefficients lie if friction force and normal force were
/// swapped.
const EXCHANGED: [f64; 2] = [0.05, 1.0];
/// A warning is given if at least this fraction of the coefficients look as if the two forces were swapped.
const NEARLY_ALL: f64 = 0.9;

/// Warns of friction coefficients that are nearly all above 1 and whose reciprocals are nearly all usual: friction
/// force and normal force are probably swapped. `None` for other coefficients.
pub fn exchanged_forces(friction: &[f64]) -> Option<String> {
    let is_likely = |mu: &&f64| **mu > HIGH_FRICTION && 1.0 / **mu >= EXCHANGED[0] && 1.0 / **mu < EXCHANGED[1];
    let likely: Vec<f64> = friction.iter().filter(is_likely).map(|mu| 1.0 / mu).collect();
    if likely.is_empty() || (likely.len() as f64) < NEARLY_ALL * friction.len() as f64 {
        return None;
    }
    let [least, most] = [f64::min as fn(f64, f64) -> f64, f64::max]
        .map(|of| tidy(significant(likely.iter().copied().reduce(of).unwrap_or(f64::NAN), 3)));
    let would = if least == most { format!("{least}") } else { format!("{least} to {most}") };
    let (count, all) = (likely.len(), friction.len());
    Some(format!(
        "is unusual: {count} of {all} friction coefficients are above {HIGH_FRICTION}, as of rubber; if friction force and normal force stand \
         in each other's place, friction would be {would}"
    ))
}

/// Names the probable intended unit of a `value` that the `quantity` of a key does not accept; `None` if no unit makes
/// it usual.
pub fn slip(quantity: Quantity, value: f64) -> Option<String> {
    let judged = [
        (slipgrid_base::units::FRICTION, FRICTION),
        (slipgrid_base::units::RATIO, RATIO),
        (slipgrid_base::units::PRESSURE_MPA, GIVEN_PRESSURE),
        (slipgrid_base::units::MODULUS_GPA, MODULUS),
        (slipgrid_base::units::DENSITY_G_CM3, DENSITY),
        (slipgrid_base::units::SPEED_MM_S, SPEED),
        (slipgrid_base::units::FORCE_N, FORCE),
    ];
    judged.into_iter().find(|(own, _)| *own == quantity).and_then(|(_, plausible)| plausible.slip(value))
}

/// Converts the number of a flag to SI units.
///
/// # Errors
/// [`Diagnostic`] if `quantity` does not accept the number.
pub fn checked(flag: &str, value: f64, quantity: Quantity) -> Result<f64, Diagnostic> {
    if quantity.accepts(value) {
        return Ok(quantity.to_si(value));
    }
    // Limits the digits: a float may have three hundred.
    let given = in_digits(value);
    let slip = slip(quantity, value).map_or_else(String::new, |slip| format!("; {slip}"));
    Err(Diagnostic::flag(flag, given, "is out of range").expected(format!("{quantity}{slip}")))
}

/// Converts nominal pressures in MPa, given by a flag, to pascals.
///
/// # Errors
/// [`Diagnostic`] if there are none, one is out of range, or they do not increase.
pub fn checked_pressures(flag: &str, pressures_mpa: &[f64]) -> Result<Vec<f64>, Diagnostic> {
    let refuse =
        |value: String, reason: &str| Diagnostic::flag(flag, value, reason).expected("positive numbers that increase");
    if pressures_mpa.is_empty() {
        return Err(refuse("[]".to_owned(), "has no pressure"));
    }
    if let Some(pair) = pressures_mpa.windows(2).find(|pair| pair[1] <= pair[0]) {
        return Err(refuse(pair[1].to_string(), &format!("does not exceed the {} before it", pair[0])));
    }
    let pressures = pressures_mpa.iter();
    pressures.map(|&pressure_mpa| checked(flag, pressure_mpa, slipgrid_base::units::PRESSURE_MPA)).collect()
}

impl Plausible {
    /// Replaces the usual range by `usual`, a better known range.
    #[must_use]
    pub const fn within(self, usual: [f64; 2]) -> Self {
        Self { usual, ..self }
    }

    /// Checks `value`, in the unit of the key; returns a warning if it is unusual, and `None` if it is usual.
    ///
    /// # Errors
    /// Range of measured values with examples, if `value` cannot be measured.
    pub fn judge(&self, value: f64) -> Result<Option<String>, String> {
        let within = |[from, to]: [f64; 2]| value >= from && value <= to;
        let described = |[from, to]: [f64; 2]| {
            let slip = self.slip(value).map_or_else(String::new, |slip| format!("; {slip}"));
            format!("{from} to {to}{}, as {}{slip}", self.after_number(), self.why)
        };
        if within(self.usual) {
            Ok(None)
        } else if within(self.measurable) {
            Ok(Some(format!("is unusual: {} mostly lie from {}", self.what, described(self.usual))))
        } else {
            Err(described(self.measurable))
        }
    }

    /// The unit as it stands after a number.
    fn after_number(&self) -> String {
        if self.unit.is_empty() { String::new() } else { format!(" {}", self.unit) }
    }

    /// Names the probable intended unit, in which `value` is usual; `None` if there is none.
    pub fn slip(&self, value: f64) -> Option<String> {
        let is_usual = |value: f64| value >= self.usual[0] && value <= self.usual[1];
        let (what, factor) = self.slips.iter().find(|(_, factor)| is_usual(value * factor))?;
        Some(format!("{what} would be {}{}", tidy(value * factor), self.after_number()))
    }

    /// Names the probable intended unit of a `value` that is too small, in which it is greater and usual; `None` if
    /// there is none.
    pub fn greater(&self, value: f64) -> Option<String> {
        let slips = self.slips.iter().filter(|(_, factor)| *factor > 1.0);
        slips.map(|slip| Self { slips: std::slice::from_ref(slip), ..*self }).find_map(|one| one.slip(value))
    }

    /// Checks `value` for a calibration and returns a warning if it is unusual, and `None` if it is usual; `place`
    /// gives file, line, key and value of the diagnostic.
    ///
    /// # Errors
    /// `place` with the accepted values, if the value cannot be measured.
    pub fn check(&self, value: f64, place: impl FnOnce() -> Diagnostic) -> Result<Option<Diagnostic>, Diagnostic> {
        match self.judge(value) {
            Ok(told) => Ok(told.map(|reason| Diagnostic { reason, ..place() })),
            Err(expected) => {
                let reason = format!("lies outside all measured {}", self.what);
                Err(Diagnostic { reason, ..place() }.expected(expected))
            }
        }
    }

    /// Like `check`, but for scenes, which refuse no value: a value that cannot be measured gives a warning, too;
    /// `None` for a usual value.
    pub fn tell(&self, value: f64, place: impl FnOnce() -> Diagnostic) -> Option<Diagnostic> {
        self.check(value, place).unwrap_or_else(Some)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All quantities that are checked.
    const ALL: [Plausible; 14] = [
        RIM_HEIGHT,
        FRICTION,
        RATIO,
        MODULUS,
        DENSITY,
        SPEED,
        FORCE,
        PRESSURE,
        STRAIN,
        RELATIVE_DEVIATION,
        SPECIMEN,
        SPOT,
        CAVITY_WIDTH,
        CAVITY_DEPTH,
    ];

    #[test]
    fn a_flag_in_another_unit_is_told_which() {
        let refused = checked("youngs_modulus_gpa", 380e6, slipgrid_base::units::MODULUS_GPA).unwrap_err().to_string();
        let expected = "expected a number above 0 up to 1250 GPa; in Pa, that would be 0.38 GPa";
        assert_eq!(refused, format!("youngs_modulus_gpa: 380000000 is out of range; {expected}"));
    }

    #[test]
    fn every_range_is_a_range_within_a_range() {
        for quantity in ALL {
            let ([least, most], [from, to]) = (quantity.measurable, quantity.usual);
            assert!(least <= from && from < to && to <= most, "{quantity:?}");
            assert!(quantity.judge(from).unwrap().is_none() && quantity.judge(to).unwrap().is_none());
            assert!(quantity.judge(most).is_ok() && quantity.judge(1.01 * most).is_err(), "{quantity:?}");
            assert!(quantity.judge(f64::NAN).is_err());
        }
    }

    #[test]
    fn forces_in_each_others_place_are_asked_about() {
        let said = exchanged_forces(&[4.0, 3.2, 2.5]).unwrap();
        assert!(said.contains("3 of 3") && said.contains("friction would be 0.25 to 0.4"), "{said}");
        assert!(exchanged_forces(&[1.6]).unwrap().contains("would be 0.625"));
        // One value of ten may differ, for example at the smallest load.
        let mut ten = [2.0; 10];
        ten[0] = 0.9;
        assert!(exchanged_forces(&ten).unwrap().contains("9 of 10"));
        ten[1] = 0.9;
        for usual in [&ten[..], &[0.25, 0.3], &[0.99, 1.01], &[1.0], &[40.0, 60.0], &[], &[f64::NAN]] {
            assert_eq!(exchanged_forces(usual), None, "{usual:?}");
        }
    }

    #[test]
    fn a_slope_is_no_friction_coefficient() {
        for (quantity, value, hint) in [
            (slipgrid_base::units::SLOPE, 13.7, None),
            (slipgrid_base::units::SLOPE, 250.0, None),
            (slipgrid_base::units::RATIO, 85.0, Some("in per cent, that would be 0.85")),
            (slipgrid_base::units::FRICTION, 25.0, Some("in per cent, that would be 0.25")),
        ] {
            let said = slip(quantity, value);
            assert_eq!(said.is_some(), hint.is_some(), "{quantity}: {said:?}");
        }
        assert!(!slipgrid_base::units::SLOPE.accepts(1e-9));
    }

    #[test]
    fn what_was_measured_is_what_files_may_hold() {
        for (measured, held) in
            [(MODULUS, slipgrid_base::units::MODULUS_GPA), (DENSITY, slipgrid_base::units::DENSITY_G_CM3)]
        {
            let most = measured.measurable[1];
            assert!(held.accepts(most) && !held.accepts(most.next_up()), "{}: {held}", measured.what);
        }
    }

    #[test]
    fn mistaken_units_are_named() {
        for (quantity, value, says) in [
            (FRICTION_OF_TORQUE, 143.0, "with the torque in N mm or mN m, as `torque [mN m]`, that would be 0.143"),
            (MODULUS, 380.0, "in MPa, that would be 0.38 GPa"),
            (MODULUS, 3.8e8, "in Pa, that would be 0.38 GPa"),
            (RATIO, 8.199, "one place to the left it would be 0.8199"),
            (RATIO, 0.08, "one place to the right it would be 0.8"),
            (DENSITY, 900.0, "in kg/m3, that would be 0.9 g/cm3"),
            (RATIO, 85.0, "in per cent, that would be 0.85"),
            (SPOT, 0.02, "in mm, that would be 20 um"),
            (SPOT, 2e4, "in nm, that would be 20 um"),
            (GIVEN_PRESSURE, 4e5, "in Pa, that would be 0.4 MPa"),
            (GIVEN_PRESSURE, 400.0, "in kPa, that would be 0.4 MPa"),
        ] {
            let said = match quantity.judge(value) {
                Ok(told) => told.unwrap(),
                Err(expected) => expected,
            };
            assert!(said.contains(says), "{said}");
        }
    }

    #[test]
    fn a_value_that_cannot_be_is_told_in_a_sentence() {
        let place = || Diagnostic {
            key: Some("youngs_modulus_gpa".into()),
            value: Some("5000".into()),
            ..Diagnostic::default()
        };
        let said = MODULUS.check(5000.0, place).unwrap_err().to_string();
        assert!(
            said.starts_with("youngs_modulus_gpa: 5000 lies outside all measured Young's moduli; expected"),
            "{said}"
        );
        assert!(
            said.contains("0.000001 to 1250 GPa, as rubber has") && said.contains("in MPa, that would be 5 GPa"),
            "{said}"
        );
    }

    #[test]
    fn a_modulus_too_high_for_so_light_a_solid_is_asked_about() {
        for (modulus_gpa, density_g_cm3, meant) in [(48.0, 1.21, "0.048"), (100.0, 0.95, "0.1"), (25.0, 1.15, "0.025")]
        {
            let said = stiff_for_its_density(modulus_gpa, density_g_cm3).unwrap();
            assert!(said.ends_with(&format!("in MPa, that would be {meant} GPa")), "{said}");
        }
        // Polymers, wood, a fibre composite, magnesium; a value that is unusual for any solid gets one warning only.
        for (modulus_gpa, density_g_cm3) in [(3.6, 1.3), (15.0, 0.6), (140.0, 1.55), (45.0, 1.74), (380.0, 0.9)] {
            assert_eq!(stiff_for_its_density(modulus_gpa, density_g_cm3), None);
        }
    }

    #[test]
    fn usual_materials_and_tests_are_not_told() {
        for (quantity, values) in [
            (FRICTION, &[0.02, 0.25, 1.2, 2.5][..]),
            (MODULUS, &[0.001, 0.38, 2.5, 70.0, 210.0]),
            (DENSITY, &[0.9, 1.3, 2.2, 7.9, 19.3]),
            (SPEED, &[0.001, 2.0, 500.0]),
            (FORCE, &[0.01, 50.0, 2000.0]),
            (PRESSURE, &[0.01, 0.65, 2.6, 20.0]),
            (RATIO, &[0.4, 0.8, 1.0, 1.1]),
        ] {
            assert!(values.iter().all(|value| quantity.judge(*value) == Ok(None)), "{quantity:?}");
        }
    }
}
