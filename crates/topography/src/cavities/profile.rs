//! Profiles of rims: how what a laser leaves standing falls from the edge of its cavity outward.

use std::f64::consts::PI;
use std::fmt;

/// How a rim of height h and width w stands on the land at the distance d from the upper end of the wall: r = h phi(d/w).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum RimProfile {
    /// A parabola with its crest at the edge: phi(s) = 1 - s^2.
    #[default]
    Round,
    /// As high up to its width: phi(s) = 1.
    Flat,
    /// A straight line: phi(s) = 1 - s.
    Ramp,
    /// An arch with its crest at half its width: phi(s) = sin(pi s).
    HalfSine,
}

impl RimProfile {
    /// All profiles, in the order in which help texts list them.
    pub const ALL: [Self; 4] = [Self::Round, Self::Flat, Self::Ramp, Self::HalfSine];

    /// The name used in options and results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Round => "round",
            Self::Flat => "flat",
            Self::Ramp => "ramp",
            Self::HalfSine => "half-sine",
        }
    }

    /// Height over the greatest, at the distance `s` from the edge over the rim's width; 0 outside 0 to 1.
    #[must_use]
    pub fn height(self, s: f64) -> f64 {
        match self {
            _ if !(0.0..=1.0).contains(&s) => 0.0,
            Self::Round => 1.0 - s * s,
            Self::Flat => 1.0,
            Self::Ramp => 1.0 - s,
            Self::HalfSine => libm::sin(PI * s),
        }
    }

    /// Integral of [`Self::height`] from the edge to `s`.
    #[must_use]
    pub fn integral(self, s: f64) -> f64 {
        let s = s.clamp(0.0, 1.0);
        match self {
            Self::Round => s * (1.0 - s * s / 3.0),
            Self::Flat => s,
            Self::Ramp => s * (1.0 - 0.5 * s),
            Self::HalfSine => (1.0 - libm::cos(PI * s)) / PI,
        }
    }

    /// Mean height over the greatest, of a rim of width `width_m`, between the distances `from_m` and `to_m`.
    pub(super) fn mean(self, width_m: f64, from_m: f64, to_m: f64) -> f64 {
        let to = |distance_m: f64| self.integral(distance_m / width_m);
        (to(to_m) - to(from_m)) * width_m / (to_m - from_m)
    }
}

impl fmt::Display for RimProfile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integrals_are_those_of_heights() {
        for profile in RimProfile::ALL {
            for s in [0.2, 0.5, 1.0, 1.7] {
                let parts = 20_000;
                let sum: f64 = (0..parts).map(|n| profile.height(s * (f64::from(n) + 0.5) / f64::from(parts))).sum();
                assert!((sum * s / f64::from(parts) - profile.integral(s)).abs() < 1e-4, "{profile} {s}");
            }
            let crest = (0..=1000).map(|n| profile.height(f64::from(n) / 1000.0)).fold(0.0, f64::max);
            assert!((crest - 1.0).abs() < 1e-12 && profile.height(1.001) == 0.0 && profile.height(-0.001) == 0.0);
        }
        // A flat rim of 4 um covers half of the pixel from 3 to 5 um, a quarter of that from -1.5 to 0.5 um.
        assert!((RimProfile::Flat.mean(4e-6, 3e-6, 5e-6) - 0.5).abs() < 1e-12);
        assert!((RimProfile::Flat.mean(4e-6, -1.5e-6, 0.5e-6) - 0.25).abs() < 1e-12);
    }
}
