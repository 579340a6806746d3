use crate::MaterialError;
use crate::error::{not_negative, positive};

/// Means and scatter of the local friction coefficients: each contact block draws
/// mu_s = static_mean (1 + s g1) and mu_d = dynamic_mean (1 + s g2), g1 and g2 standard normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalFriction {
    static_mean: f64,
    dynamic_mean: f64,
    relative_std: f64,
}

impl LocalFriction {
    /// Local coefficients with the given means and relative standard deviation.
    ///
    /// # Errors
    /// [`MaterialError::OutOfRange`] unless the means are positive and the scatter is not negative.
    pub fn new(static_mean: f64, dynamic_mean: f64, relative_std: f64) -> Result<Self, MaterialError> {
        Ok(Self {
            static_mean: positive("static friction coefficient", static_mean)?,
            dynamic_mean: positive("dynamic friction coefficient", dynamic_mean)?,
            relative_std: not_negative("relative standard deviation of friction", relative_std)?,
        })
    }

    /// Mean local static coefficient.
    #[must_use]
    pub const fn static_mean(&self) -> f64 {
        self.static_mean
    }

    /// Mean local dynamic coefficient.
    #[must_use]
    pub const fn dynamic_mean(&self) -> f64 {
        self.dynamic_mean
    }

    /// Standard deviation of both coefficients relative to their means.
    #[must_use]
    pub const fn relative_std(&self) -> f64 {
        self.relative_std
    }

    /// Linear interpolation between two sets of coefficients, `t` from 0 to 1.
    #[must_use]
    fn interpolate(&self, other: &Self, t: f64) -> Self {
        let mix = |a: f64, b: f64| a + t * (b - a);
        Self {
            static_mean: mix(self.static_mean, other.static_mean),
            dynamic_mean: mix(self.dynamic_mean, other.dynamic_mean),
            relative_std: mix(self.relative_std, other.relative_std),
        }
    }
}

/// Sliding speed and humidity: what else than pressure a measurement depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Condition {
    /// Sliding speed, in m/s.
    pub speed_m_s: f64,
    /// Relative humidity, from 0 to 1.
    pub humidity: f64,
}

impl Condition {
    /// Two conditions are the same when both numbers agree to one part in a million.
    #[must_use]
    pub fn matches(&self, other: &Self) -> bool {
        let close = |a: f64, b: f64| (a - b).abs() <= 1e-6 * a.abs().max(b.abs());
        close(self.speed_m_s, other.speed_m_s) && close(self.humidity, other.humidity)
    }

    fn in_words(&self) -> String {
        format!("{} mm/s at {} %", round(self.speed_m_s * 1e3), round(self.humidity * 1e2))
    }
}

/// Rounds away what unit conversion left behind, for messages.
fn round(value: f64) -> f64 {
    (value * 1e9).round() / 1e9
}

/// Local coefficients fitted at one condition and one nominal pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConditionFriction {
    /// Nominal pressure of the measurement, in pascals.
    pub pressure_pa: f64,
    /// Speed and humidity; `None` where the coefficients hold for any.
    pub condition: Option<Condition>,
    /// The coefficients.
    pub friction: LocalFriction,
}

/// Local friction of a material.
#[derive(Clone, Debug, PartialEq)]
pub enum Friction {
    /// One pair of coefficients for all loads, speeds and humidities.
    Single(LocalFriction),
    /// Coefficients per condition, linear in nominal pressure between measurements.
    PerCondition(Vec<ConditionFriction>),
}

/// Coefficients at one nominal pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrictionAt {
    /// The coefficients.
    pub friction: LocalFriction,
    /// The pressure lies outside the measured range: the nearest measurement was taken.
    pub outside_measured_range: bool,
}

impl Friction {
    /// The coefficients at `pressure_pa` under `condition` (ignored by [`Friction::Single`]).
    ///
    /// # Errors
    /// [`MaterialError::ConditionMissing`] or [`MaterialError::UnknownCondition`] where the
    /// coefficients depend on the condition and it is absent or was not measured.
    pub fn at(&self, pressure_pa: f64, condition: Option<&Condition>) -> Result<FrictionAt, MaterialError> {
        let table = match self {
            Self::Single(friction) => return Ok(FrictionAt { friction: *friction, outside_measured_range: false }),
            Self::PerCondition(table) => table,
        };
        let mut rows: Vec<&ConditionFriction> = Vec::new();
        for row in table {
            match (&row.condition, condition) {
                (None, _) => rows.push(row),
                (Some(_), None) => return Err(condition_missing(table)),
                (Some(measured), Some(wanted)) if measured.matches(wanted) => rows.push(row),
                (Some(_), Some(_)) => {}
            }
        }
        rows.sort_by(|a, b| a.pressure_pa.total_cmp(&b.pressure_pa));
        let (Some(first), Some(last)) = (rows.first(), rows.last()) else {
            return Err(unknown_condition(table, condition));
        };
        // A pressure within a part in a million of an end counts as that end.
        let margin_pa = 1e-6 * pressure_pa.abs();
        if pressure_pa <= first.pressure_pa {
            let outside = pressure_pa < first.pressure_pa - margin_pa;
            return Ok(FrictionAt { friction: first.friction, outside_measured_range: outside });
        }
        if pressure_pa >= last.pressure_pa {
            let outside = pressure_pa > last.pressure_pa + margin_pa;
            return Ok(FrictionAt { friction: last.friction, outside_measured_range: outside });
        }
        let next = rows.partition_point(|row| row.pressure_pa <= pressure_pa);
        let (low, high) = (rows[next - 1], rows[next]);
        let t = (pressure_pa - low.pressure_pa) / (high.pressure_pa - low.pressure_pa);
        Ok(FrictionAt { friction: low.friction.interpolate(&high.friction, t), outside_measured_range: false })
    }
}

fn condition_missing(table: &[ConditionFriction]) -> MaterialError {
    let example = table.iter().find_map(|row| row.condition).map_or_else(String::new, |condition| {
        format!("speed_mm_s = {}, humidity_pct = {}", round(condition.speed_m_s * 1e3), round(condition.humidity * 1e2))
    });
    MaterialError::ConditionMissing { example }
}

fn unknown_condition(table: &[ConditionFriction], wanted: Option<&Condition>) -> MaterialError {
    let mut available: Vec<String> = table.iter().filter_map(|row| row.condition).map(|c| c.in_words()).collect();
    available.dedup();
    MaterialError::UnknownCondition {
        speed_mm_s: wanted.map_or(f64::NAN, |c| round(c.speed_m_s * 1e3)),
        humidity_pct: wanted.map_or(f64::NAN, |c| round(c.humidity * 1e2)),
        available: if available.is_empty() { "none".to_owned() } else { available.join(", ") },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(pressure_pa: f64, speed_mm_s: f64, mu: f64) -> ConditionFriction {
        ConditionFriction {
            pressure_pa,
            condition: Some(Condition { speed_m_s: speed_mm_s * 1e-3, humidity: 0.15 }),
            friction: LocalFriction::new(mu * 1.1, mu, 0.05).unwrap(),
        }
    }

    #[test]
    fn coefficients_are_linear_in_pressure_and_flagged_outside() {
        let friction = Friction::PerCondition(vec![row(2e6, 2.0, 0.3), row(1e6, 2.0, 0.2), row(1e6, 4.0, 0.9)]);
        let condition = Condition { speed_m_s: 2e-3, humidity: 0.15 };
        let at = |p| friction.at(p, Some(&condition)).unwrap();
        assert!((at(1.5e6).friction.dynamic_mean() - 0.25).abs() < 1e-12);
        assert!(!at(1.5e6).outside_measured_range && !at(2e6).outside_measured_range);
        assert!(at(2.1e6).outside_measured_range && at(2.1e6).friction.dynamic_mean() == 0.3);
        assert!(at(0.9e6).outside_measured_range && at(0.9e6).friction.dynamic_mean() == 0.2);
    }

    #[test]
    fn a_missing_or_unknown_condition_says_what_there_is() {
        let friction = Friction::PerCondition(vec![row(1e6, 2.0, 0.2)]);
        let missing = friction.at(1e6, None).unwrap_err().to_string();
        assert!(missing.contains("speed_mm_s = 2, humidity_pct = 15"), "{missing}");
        let wanted = Condition { speed_m_s: 3e-3, humidity: 0.15 };
        let unknown = friction.at(1e6, Some(&wanted)).unwrap_err().to_string();
        assert!(unknown.contains("3 mm/s") && unknown.contains("2 mm/s at 15 %"), "{unknown}");
    }
}
