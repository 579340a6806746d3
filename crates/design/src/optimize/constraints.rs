//! Constraints of a design besides its bounds.

use slipgrid_model::pattern::{LimitViolation, ManufacturingLimits, Pattern};
use std::fmt;

/// One-sided limit with its allowed side. An infinite limit does not bind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bound {
    /// Values up to the limit are allowed.
    AtMost(f64),
    /// Values from the limit on are allowed.
    AtLeast(f64),
}

impl Bound {
    /// Returns the limit.
    pub const fn limit(self) -> f64 {
        match self {
            Self::AtMost(limit) | Self::AtLeast(limit) => limit,
        }
    }
}

/// Quantity of a design that can be limited.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConstraintQuantity {
    /// Maximum local pressure over all target pressures, in the periodic cell and in dynamic runs of the specimen.
    PeakPressure,
    /// Fraction of the face that is land.
    BearingArea,
    /// Fraction of the face that is cavity.
    ArealDensity,
    /// Laser time for the specimen.
    LaserTime,
    /// Minimum height of a cavity's ceiling above the counterface over all target pressures.
    Clearance,
    /// Minimum ratio of local to nominal pressure over all target pressures; negative under tension.
    LeastPressure,
}

slipgrid_base::names!(ConstraintQuantity {
    PeakPressure = "peak pressure",
    BearingArea = "bearing area",
    ArealDensity = "share of the face that is cavity",
    LaserTime = "time under the laser",
    Clearance = "clearance under the ceiling",
    LeastPressure = "least local pressure over the nominal one",
});

impl ConstraintQuantity {
    /// Unit in messages, empty for a number without one, with its value in SI units.
    pub const fn unit(self) -> (&'static str, f64) {
        match self {
            Self::PeakPressure => ("MPa", 1e6),
            Self::LaserTime => ("s", 1.0),
            Self::Clearance => ("um", 1e-6),
            Self::BearingArea | Self::ArealDensity | Self::LeastPressure => ("", 1.0),
        }
    }

    /// Formats `value`, given in SI units, in the unit of the quantity.
    pub fn tell(self, value: f64) -> String {
        let (unit, unit_si) = self.unit();
        let told = significant(value / unit_si);
        if unit.is_empty() { told } else { format!("{told} {unit}") }
    }

    /// Limit of this quantity at `limit`, in SI units.
    pub const fn limited_to(self, limit: f64) -> Limit {
        let bound = match self {
            Self::PeakPressure | Self::ArealDensity | Self::LaserTime => Bound::AtMost(limit),
            Self::BearingArea | Self::Clearance | Self::LeastPressure => Bound::AtLeast(limit),
        };
        Limit { quantity: self, bound }
    }
}

/// Divisor that makes an excess over a limit of 0 dimensionless, in SI units; chosen for clearances, in metres.
const CLEARANCE_SCALE_M: f64 = 1e-6;

/// Quantity of a design computed by the model, with its limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// Limited quantity.
    pub quantity: ConstraintQuantity,
    /// Limit, in SI units.
    pub bound: Bound,
}

impl Limit {
    /// Distance of `value` beyond the limit, over the limit or a typical value: 0 at the limit, negative inside.
    pub fn excess(&self, value: f64) -> f64 {
        let limit = self.bound.limit();
        let scale = match self.quantity {
            ConstraintQuantity::LeastPressure => 1.0,
            _ if limit > 0.0 => limit,
            _ => CLEARANCE_SCALE_M,
        };
        match self.bound {
            Bound::AtMost(limit) => (value - limit) / scale,
            Bound::AtLeast(limit) => (limit - value) / scale,
        }
    }
}

/// Formats four significant digits.
fn significant(value: f64) -> String {
    format!("{value:.3e}").parse::<f64>().map_or_else(|_| value.to_string(), |rounded| rounded.to_string())
}

/// Constraints of a design besides its bounds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Constraints {
    /// Manufacturing limits of the laser.
    pub limits: ManufacturingLimits,
    /// Limited quantities that the model computes.
    pub quantities: Vec<Limit>,
}

impl Constraints {
    /// Lists the constraints that `design` violates; `limited` holds the values of the limited quantities of `design`,
    /// in the order of [`Self::quantities`], in SI units.
    pub fn violations(&self, design: &Pattern, limited: &[f64]) -> Vec<Violation> {
        let makeable = self.limits.violations(design).into_iter().map(Violation::Limit);
        let exceeded = |(limit, &value): (&Limit, &f64)| {
            (limit.excess(value) > 0.0).then_some(Violation::Quantity { limit: *limit, value })
        };
        makeable.chain(self.quantities.iter().zip(limited).filter_map(exceeded)).collect()
    }
}

/// Constraint that a design violates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Violation {
    /// Violated manufacturing limit of the laser.
    Limit(LimitViolation),
    /// Quantity beyond its limit.
    Quantity {
        /// Quantity with its limit.
        limit: Limit,
        /// Value of the design, in SI units.
        value: f64,
    },
}

impl Violation {
    /// Distance beyond the constraint, relative to the limit or a typical value: 0 at the constraint.
    pub fn excess(&self) -> f64 {
        match self {
            Self::Limit(limit) => limit.excess(),
            Self::Quantity { limit, value } => limit.excess(*value),
        }
    }
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Limit(limit) => limit.fmt(f),
            Self::Quantity { limit, value } => {
                let side = match limit.bound {
                    Bound::AtMost(_) => "at most",
                    Bound::AtLeast(_) => "at least",
                };
                let of = limit.quantity;
                let (value, allowed) = (of.tell(*value), of.tell(limit.bound.limit()));
                write!(f, "{} is {value}: allowed is {side} {allowed}", of.name())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_model::pattern::Planform;

    #[test]
    fn limits_hold_on_their_side_and_say_so_in_their_unit() {
        let peak = ConstraintQuantity::PeakPressure.limited_to(10e6);
        let land = ConstraintQuantity::BearingArea.limited_to(0.6);
        let design = Pattern::new(Planform::Groove, 1e-4, 3e-4, 1e-5).unwrap();
        let constraints = Constraints { quantities: vec![peak, land], ..Constraints::default() };
        let broken = |limited: Vec<f64>| constraints.violations(&design, &limited);
        assert!(broken(vec![10e6, 0.6]).is_empty());
        let both = broken(vec![12.345_67e6, 0.3]);
        assert_eq!(both[0].to_string(), "peak pressure is 12.35 MPa: allowed is at most 10 MPa");
        assert_eq!(both[1].to_string(), "bearing area is 0.3: allowed is at least 0.6");
        assert!((both[0].excess() - 0.234_567).abs() < 1e-9 && (both[1].excess() - 0.5).abs() < 1e-12);
    }
}
