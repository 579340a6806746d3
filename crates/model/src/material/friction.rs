use crate::material::MaterialError;
use crate::material::condition::{Condition, between};
use crate::material::error::{not_negative, positive};
use slipgrid_base::{statistics::extremes, units::tidy};

/// Means and scatter of the local friction coefficients. Each contact block draws mu_s = static_mean (1 + s g1) and
/// mu_d = dynamic_mean (1 + s g2), with the relative standard deviation s and standard normal g1 and g2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalFriction {
    static_mean: f64,
    dynamic_mean: f64,
    relative_std: f64,
}

impl LocalFriction {
    /// Creates local coefficients with the given means and relative standard deviation.
    ///
    /// # Errors
    /// [`MaterialError`] unless the means are positive and the scatter is not negative.
    pub fn new(static_mean: f64, dynamic_mean: f64, relative_std: f64) -> Result<Self, MaterialError> {
        Ok(Self {
            static_mean: positive("static friction coefficient", static_mean)?,
            dynamic_mean: positive("dynamic friction coefficient", dynamic_mean)?,
            relative_std: not_negative("relative standard deviation of friction", relative_std)?,
        })
    }

    /// Mean local static coefficient.
    pub const fn static_mean(&self) -> f64 {
        self.static_mean
    }

    /// Mean local dynamic coefficient.
    pub const fn dynamic_mean(&self) -> f64 {
        self.dynamic_mean
    }

    /// Standard deviation of both coefficients relative to their means.
    pub const fn relative_std(&self) -> f64 {
        self.relative_std
    }

    /// Interpolates linearly from `self` at `t` = 0 to `other` at `t` = 1.
    fn interpolate(&self, other: &Self, t: f64) -> Self {
        let mix = |a: f64, b: f64| a + t * (b - a);
        Self {
            static_mean: mix(self.static_mean, other.static_mean),
            dynamic_mean: mix(self.dynamic_mean, other.dynamic_mean),
            relative_std: mix(self.relative_std, other.relative_std),
        }
    }
}

/// Local coefficients fitted at one condition and one nominal pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConditionFriction {
    /// Nominal pressure of the measurement, in pascals.
    pub pressure_pa: f64,
    /// Speed and humidity; `None` if the coefficients hold for all conditions.
    pub condition: Option<Condition>,
    /// Means and scatter of the local friction coefficients.
    pub friction: LocalFriction,
}

/// Local friction of a material.
#[derive(Clone, Debug, PartialEq)]
pub enum Friction {
    /// One pair of coefficients for all loads, speeds and humidities.
    Single(LocalFriction),
    /// Coefficients per condition, interpolated linearly in nominal pressure, in the logarithm of speed and in
    /// humidity.
    PerCondition(Vec<ConditionFriction>),
}

/// Coefficients at one nominal pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrictionAt {
    /// Means and scatter of the local friction coefficients at the pressure.
    pub friction: LocalFriction,
    /// Whether the pressure is outside the measured range by more than [`END_MARGIN`]. Coefficients outside the range
    /// are those of the nearest measured pressure.
    pub outside_measured_range: bool,
}

impl Friction {
    /// Coefficients at `pressure_pa` under `condition` (ignored by [`Friction::Single`]).
    ///
    /// # Errors
    /// [`MaterialError`] if the coefficients depend on the condition and `condition` is missing or outside the measured
    /// range.
    pub fn at(&self, pressure_pa: f64, condition: Option<&Condition>) -> Result<FrictionAt, MaterialError> {
        let table = match self {
            Self::Single(friction) => return Ok(FrictionAt { friction: *friction, outside_measured_range: false }),
            Self::PerCondition(table) => table,
        };
        let measured = self.measured();
        // Rows without a condition hold for all conditions; a table has only such rows or none.
        if measured.is_empty() {
            let rows: Vec<&ConditionFriction> = table.iter().collect();
            return at_pressure(&rows, pressure_pa).ok_or_else(|| unknown_condition(table, condition));
        }
        let wanted = condition.ok_or_else(|| condition_missing(table))?;
        let shares = between(&measured, wanted).ok_or_else(|| unknown_condition(table, condition))?;
        let mut mixed: Option<FrictionAt> = None;
        let mut total = 0.0;
        for (own, share) in shares {
            let is_own = |row: &&ConditionFriction| row.condition.is_none_or(|condition| condition.matches(&own));
            let rows: Vec<&ConditionFriction> = table.iter().filter(is_own).collect();
            let at = at_pressure(&rows, pressure_pa).ok_or_else(|| unknown_condition(table, condition))?;
            total += share;
            // (1 - t) a + t b with t = s_n / (s_1 + ... + s_n), one after the other: sum of s_i x_i
            mixed = Some(mixed.map_or(at, |before| FrictionAt {
                friction: before.friction.interpolate(&at.friction, share / total),
                outside_measured_range: before.outside_measured_range || at.outside_measured_range,
            }));
        }
        mixed.ok_or_else(|| unknown_condition(table, condition))
    }

    /// One row of coefficients per measured condition and pressure; empty for [`Friction::Single`].
    pub(crate) fn table(&self) -> &[ConditionFriction] {
        match self {
            Self::Single(_) => &[],
            Self::PerCondition(table) => table,
        }
    }

    /// Minimum and maximum pressure, in pascals, at which coefficients were measured under `condition`. If `condition`
    /// is interpolated, this is the range that all contributing conditions cover. `None` for [`Friction::Single`], for
    /// unknown conditions, and if the conditions have no pressure in common.
    pub fn measured_pressures_pa(&self, condition: Option<&Condition>) -> Option<[f64; 2]> {
        let measured = self.measured();
        let about: Vec<Option<Condition>> = if measured.is_empty() {
            vec![None]
        } else {
            between(&measured, condition?)?.into_iter().map(|(own, _)| Some(own)).collect()
        };
        let ends_pa = |own: &Option<Condition>| {
            let rows = self.table().iter().filter(|row| match (row.condition, own) {
                (Some(condition), Some(own)) => condition.matches(own),
                _ => true,
            });
            extremes(rows.map(|row| row.pressure_pa))
        };
        let common = about.iter().map(ends_pa).reduce(|[low, high], [from, to]| [low.max(from), high.min(to)])?;
        (common[0] <= common[1]).then_some(common)
    }

    /// Sentence on the measured conditions from which coefficients under `condition` are interpolated; `None` without
    /// interpolation.
    pub fn interpolation(&self, condition: Option<&Condition>) -> Option<String> {
        let shares = between(&self.measured(), condition?).filter(|shares| shares.len() > 1)?;
        let each = shares.iter().map(|(own, share)| format!("{} ({:.2})", own.in_words(), share));
        Some(format!(
            "coefficients at {} are interpolated, linear in the logarithm of speed and in humidity, between those measured at {}",
            condition?.in_words(),
            each.collect::<Vec<_>>().join(", ")
        ))
    }
}

/// A pressure outside the measured range still counts as measured if its distance from the range is at most this
/// fraction of the pressure. A coefficient that changes by 20 % over a factor of four in pressure, like that of the
/// published polymer, changes by 0.7 % over this distance, which is less than its standard error.
pub const END_MARGIN: f64 = 0.05;

/// Coefficients at a pressure, from the `rows` of one condition; `None` without rows.
fn at_pressure(rows: &[&ConditionFriction], pressure_pa: f64) -> Option<FrictionAt> {
    let mut rows = rows.to_vec();
    rows.sort_by(|a, b| a.pressure_pa.total_cmp(&b.pressure_pa));
    let (first, last) = (rows.first()?, rows.last()?);
    let margin_pa = END_MARGIN * pressure_pa.abs();
    if pressure_pa <= first.pressure_pa {
        let outside = pressure_pa < first.pressure_pa - margin_pa;
        return Some(FrictionAt { friction: first.friction, outside_measured_range: outside });
    }
    if pressure_pa >= last.pressure_pa {
        let outside = pressure_pa > last.pressure_pa + margin_pa;
        return Some(FrictionAt { friction: last.friction, outside_measured_range: outside });
    }
    let next = rows.partition_point(|row| row.pressure_pa <= pressure_pa);
    let (low, high) = (rows[next - 1], rows[next]);
    let t = (pressure_pa - low.pressure_pa) / (high.pressure_pa - low.pressure_pa);
    Some(FrictionAt { friction: low.friction.interpolate(&high.friction, t), outside_measured_range: false })
}

fn condition_missing(table: &[ConditionFriction]) -> MaterialError {
    let example = table.iter().find_map(|row| row.condition).map_or_else(String::new, |condition| {
        format!("speed_mm_s = {}, humidity_pct = {}", tidy(condition.speed_m_s * 1e3), tidy(condition.humidity * 1e2))
    });
    MaterialError(format!(
        "the material has coefficients per condition: name one, for instance condition = {{ {example} }}"
    ))
}

pub(crate) fn unknown_condition(table: &[ConditionFriction], wanted: Option<&Condition>) -> MaterialError {
    let mut available: Vec<String> = Vec::new();
    for words in table.iter().filter_map(|row| row.condition).map(|condition| condition.in_words()) {
        if !available.contains(&words) {
            available.push(words);
        }
    }
    let [speed_mm_s, humidity_pct] =
        wanted.map_or([f64::NAN; 2], |wanted| [wanted.speed_m_s * 1e3, wanted.humidity * 1e2].map(tidy));
    let available = if available.is_empty() { "none".to_owned() } else { available.join(", ") };
    MaterialError(format!(
        "no coefficients for {speed_mm_s} mm/s at {humidity_pct} % humidity, which is not between measured ones: the material has {available}"
    ))
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
        assert!(at(2.2e6).outside_measured_range && at(2.2e6).friction.dynamic_mean() == 0.3);
        // No doubt within 5 % of an end.
        assert!(!at(2.08e6).outside_measured_range && at(2.08e6).friction.dynamic_mean() == 0.3);
        assert!(at(0.9e6).outside_measured_range && at(0.9e6).friction.dynamic_mean() == 0.2);
    }

    #[test]
    fn between_conditions_coefficients_are_linear_in_the_logarithm_of_speed() {
        let friction = Friction::PerCondition(vec![
            row(1e6, 1.0, 0.2),
            row(2e6, 1.0, 0.3),
            row(1e6, 4.0, 0.3),
            row(3e6, 4.0, 0.5),
        ]);
        let at = |speed_m_s, pressure_pa| friction.at(pressure_pa, Some(&Condition { speed_m_s, humidity: 0.15 }));
        let middle = at(2e-3, 1.5e6).unwrap();
        // Half of 0.25 and half of 0.35.
        assert!((middle.friction.dynamic_mean() - 0.3).abs() < 1e-12 && !middle.outside_measured_range);
        assert!((middle.friction.static_mean() - 0.33).abs() < 1e-12 && middle.friction.relative_std() == 0.05);
        // A pressure beyond those of one of the two conditions is outside.
        assert!(at(2e-3, 2.5e6).unwrap().outside_measured_range && !at(4e-3, 2.5e6).unwrap().outside_measured_range);
        // The range is that of the condition; between two conditions, the common range.
        let range = |speed_m_s| friction.measured_pressures_pa(Some(&Condition { speed_m_s, humidity: 0.15 }));
        assert_eq!((range(1e-3), range(4e-3)), (Some([1e6, 2e6]), Some([1e6, 3e6])));
        assert_eq!((range(2e-3), range(9e-3)), (Some([1e6, 2e6]), None));
        assert!(at(0.9e-3, 1.5e6).is_err() && at(4.1e-3, 1.5e6).is_err());
        let said = |speed_m_s| friction.interpolation(Some(&Condition { speed_m_s, humidity: 0.15 }));
        assert!(said(2e-3).unwrap().contains("1 mm/s at 15 % (0.50), 4 mm/s at 15 % (0.50)"));
        assert_eq!(said(4e-3), None);
    }

    #[test]
    fn a_missing_or_unknown_condition_says_what_there_is() {
        let friction = Friction::PerCondition(vec![row(1e6, 2.0, 0.2)]);
        let missing = friction.at(1e6, None).unwrap_err().to_string();
        assert!(missing.contains("speed_mm_s = 2, humidity_pct = 15"), "{missing}");
        let wanted = Condition { speed_m_s: 3e-3, humidity: 0.15 };
        let unknown = friction.at(1e6, Some(&wanted)).unwrap_err().to_string();
        assert!(unknown.contains("3 mm/s") && unknown.contains("2 mm/s at 15 %"), "{unknown}");
        // Distinct conditions, however many loads were measured.
        let loads = vec![row(1e6, 2.0, 0.2), row(1e6, 5.0, 0.2), row(2e6, 2.0, 0.2), row(2e6, 5.0, 0.2)];
        let unknown = Friction::PerCondition(loads).at(1e6, Some(&Condition { humidity: 0.9, ..wanted }));
        let unknown = unknown.unwrap_err().to_string();
        assert!(unknown.ends_with("the material has 2 mm/s at 15 %, 5 mm/s at 15 %"), "{unknown}");
    }
}
