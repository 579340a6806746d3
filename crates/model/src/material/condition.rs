//! Conditions of a measurement other than its load, and interpolation between them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use slipgrid_base::units::{HumidityPct, InFiles, SpeedMmS, is_same, tidy};

/// Sliding speed and humidity: the conditions of a measurement other than pressure.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Condition {
    // In m/s.
    /// Sliding speed.
    #[serde(rename = "speed_mm_s", with = "SpeedMmS")]
    #[schemars(with = "f64")]
    pub speed_m_s: f64,
    // From 0 to 1.
    /// Relative humidity.
    #[serde(rename = "humidity_pct", with = "HumidityPct")]
    #[schemars(with = "f64")]
    pub humidity: f64,
}

impl Condition {
    /// Whether speed and humidity agree with those of `other`.
    pub fn matches(&self, other: &Self) -> bool {
        is_same(self.speed_m_s, other.speed_m_s) && is_same(self.humidity, other.humidity)
    }

    /// Whether the two conditions match, or both are unknown (`None`).
    pub fn is_same(one: Option<&Self>, other: Option<&Self>) -> bool {
        one.is_some() == other.is_some() && one.zip(other).is_none_or(|(one, other)| one.matches(other))
    }

    pub(crate) fn in_words(&self) -> String {
        format!("{} mm/s at {} %", tidy(self.speed_m_s * 1e3), tidy(self.humidity * 1e2))
    }
}

/// Measured conditions from which `wanted` is interpolated, with weights that sum to 1. If `wanted` itself was
/// measured, its weight is 1. Otherwise interpolation is linear in ln(speed) between the nearest speeds at one
/// humidity, and linear in humidity between the nearest humidities at which this is possible. `None` outside the
/// measured range: there is no extrapolation.
pub fn between(measured: &[Condition], wanted: &Condition) -> Option<Vec<(Condition, f64)>> {
    let mut humidities: Vec<f64> = measured.iter().map(|condition| condition.humidity).collect();
    humidities.sort_by(f64::total_cmp);
    humidities.dedup_by(|a, b| is_same(*a, *b));
    // Humidities with measured speeds around the wanted one.
    let levels: Vec<(f64, Vec<(Condition, f64)>)> = humidities
        .into_iter()
        .filter_map(|humidity| {
            let mut own: Vec<Condition> =
                measured.iter().filter(|condition| is_same(condition.humidity, humidity)).copied().collect();
            own.sort_by(|a, b| a.speed_m_s.total_cmp(&b.speed_m_s));
            let places: Vec<f64> = own.iter().map(|condition| condition.speed_m_s.ln()).collect();
            let shares = bracket(&places, wanted.speed_m_s.ln())?;
            Some((humidity, shares.into_iter().map(|(place, share)| (own[place], share)).collect()))
        })
        .collect();
    let places: Vec<f64> = levels.iter().map(|(humidity, _)| *humidity).collect();
    let shares = bracket(&places, wanted.humidity)?;
    let all = shares
        .into_iter()
        .flat_map(|(place, weight)| levels[place].1.iter().map(move |(own, share)| (*own, weight * share)));
    Some(all.collect())
}

/// Indices of the neighbours of `wanted` in the increasing `places`, with their weights in linear interpolation; `None`
/// outside `places`.
fn bracket(places: &[f64], wanted: f64) -> Option<Vec<(usize, f64)>> {
    if let Some(place) = places.iter().position(|place| is_same(*place, wanted)) {
        return Some(vec![(place, 1.0)]);
    }
    let next = places.partition_point(|place| *place < wanted);
    let (low, high) = (*places.get(next.checked_sub(1)?)?, *places.get(next)?);
    let t = (wanted - low) / (high - low);
    Some(vec![(next - 1, 1.0 - t), (next, t)])
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub fn at(speed_mm_s: f64, humidity_pct: f64) -> Condition {
        Condition { speed_m_s: speed_mm_s * 1e-3, humidity: humidity_pct * 1e-2 }
    }

    #[test]
    fn shares_reproduce_speed_and_humidity() {
        let measured = [at(0.4, 15.0), at(2.0, 15.0), at(4.0, 15.0), at(0.4, 80.0), at(4.0, 80.0), at(2.0, 15.0)];
        for (wanted, count) in
            [(at(2.0, 15.0), 1), (at(1.0, 15.0), 2), (at(3.0, 40.0), 4), (at(4.0, 40.0), 2), (at(0.4, 79.0), 2)]
        {
            let shares = between(&measured, &wanted).unwrap();
            assert_eq!(shares.len(), count, "{wanted:?}");
            let mean = |of: fn(&Condition) -> f64| shares.iter().map(|(own, share)| share * of(own)).sum::<f64>();
            assert!((mean(|_| 1.0) - 1.0).abs() < 1e-12);
            assert!((mean(|own| own.speed_m_s.ln()) - wanted.speed_m_s.ln()).abs() < 1e-12);
            assert!((mean(|own| own.humidity) - wanted.humidity).abs() < 1e-12);
        }
        for outside in [at(0.3, 15.0), at(5.0, 40.0), at(2.0, 14.0), at(2.0, 81.0)] {
            assert_eq!(between(&measured, &outside), None, "{outside:?}");
        }
        assert_eq!(between(&[], &at(1.0, 15.0)), None);
    }
}
