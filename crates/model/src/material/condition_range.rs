//! Ranges of speed and humidity, and the conditions within them at which friction can be extreme.
//!
//! Coefficients are linear in ln(v) and in humidity between measured conditions ([`between`]). At any pressure their
//! minimum and maximum over a range are therefore at one of its corners, or at measured speeds and humidities inside
//! it.

use crate::material::condition::{Condition, between};
use crate::material::friction::unknown_condition;
use crate::material::{Friction, MaterialError};
use slipgrid_base::units::is_same;

/// Fraction by which a speed is shifted past the end of the measured speeds at one humidity: far more than the
/// tolerance of equal speeds, and too little to change friction.
const SPEED_SHIFT: f64 = 1e-4;
/// Tolerance for equal weights of measured conditions.
const WEIGHT_TOLERANCE: f64 = 1e-9;

/// A range of sliding speeds and a range of humidities.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConditionRange {
    speed_m_s: [f64; 2],
    humidity: [f64; 2],
}

impl ConditionRange {
    /// Creates a range of speeds, in m/s, and of humidities, from 0 to 1.
    ///
    /// # Errors
    /// [`MaterialError`] unless speeds are positive, humidities not negative, all are finite, and the
    /// minimum comes first.
    pub fn new(speed_m_s: [f64; 2], humidity: [f64; 2]) -> Result<Self, MaterialError> {
        crate::material::error::positive("sliding speed", speed_m_s[0])?;
        crate::material::error::not_negative("relative humidity", humidity[0])?;
        for (quantity, [lowest, highest]) in [("sliding speed", speed_m_s), ("relative humidity", humidity)] {
            if !(highest.is_finite() && highest >= lowest) {
                return Err(MaterialError::out_of_range(quantity, highest, "at least the lowest"));
            }
        }
        Ok(Self { speed_m_s, humidity })
    }

    /// Whether the range is more than a single condition.
    pub fn is_wide(&self) -> bool {
        !(is_same(self.speed_m_s[0], self.speed_m_s[1]) && is_same(self.humidity[0], self.humidity[1]))
    }

    /// Minimum and maximum speed, in m/s.
    pub const fn speed_m_s(&self) -> [f64; 2] {
        self.speed_m_s
    }

    /// Minimum and maximum humidity, from 0 to 1.
    pub const fn humidity(&self) -> [f64; 2] {
        self.humidity
    }

    /// Distinct corners of the range, ordered by increasing speed and then by increasing humidity.
    pub fn corners(&self) -> Vec<Condition> {
        let (speeds, humidities) = (places(self.speed_m_s, &[]), places(self.humidity, &[]));
        lattice(&speeds, &humidities).into_iter().flatten().collect()
    }

    /// Conditions that include the minimum and the maximum over the range of coefficients interpolated between
    /// `measured` conditions, at any pressure: the corners, and measured speeds and humidities inside the range. Where
    /// the measured speeds of one humidity end inside the range, coefficients at other humidities jump; both sides are
    /// included, with the open side shifted by the fraction `SPEED_SHIFT`. The conditions are distinct, and the speed
    /// varies slowest.
    ///
    /// # Errors
    /// A condition of the range, usually a corner, that is not between measured conditions.
    pub fn extremes(&self, measured: &[Condition]) -> Result<Vec<Condition>, Condition> {
        if let Some(outside) = self.corners().into_iter().find(|corner| between(measured, corner).is_none()) {
            return Err(outside);
        }
        let mut known: Vec<f64> = measured.iter().map(|condition| condition.speed_m_s).collect();
        for end in speed_ends(measured) {
            known.extend([end * (1.0 - SPEED_SHIFT), end * (1.0 + SPEED_SHIFT)]);
        }
        let speeds = places(self.speed_m_s, &known);
        let humidities =
            places(self.humidity, &measured.iter().map(|condition| condition.humidity).collect::<Vec<f64>>());
        let conditions = lattice(&speeds, &humidities);
        let mut shares: Vec<Vec<Vec<f64>>> = Vec::new();
        for at_speed in &conditions {
            let row: Result<Vec<Vec<f64>>, Condition> =
                at_speed.iter().map(|wanted| weights_in(measured, wanted).ok_or(*wanted)).collect();
            shares.push(row?);
        }
        // A condition whose weights are interpolated from its neighbours along one direction cannot be extreme at any
        // pressure.
        let logs: Vec<f64> = speeds.iter().map(|speed| speed.ln()).collect();
        let is_interpolated = |places: &[f64], n: usize, weights: &[&Vec<f64>]| {
            let around = [n.wrapping_sub(1), n, n + 1];
            n > 0 && n + 1 < places.len() && is_between(around.map(|n| weights[n]), around.map(|n| places[n]))
        };
        let mut extremes = Vec::new();
        for (i, at_speed) in conditions.iter().enumerate() {
            let across: Vec<&Vec<f64>> = shares[i].iter().collect();
            for (j, condition) in at_speed.iter().enumerate() {
                let along: Vec<&Vec<f64>> = shares.iter().map(|row| &row[j]).collect();
                if !is_interpolated(&logs, i, &along) && !is_interpolated(&humidities, j, &across) {
                    extremes.push(*condition);
                }
            }
        }
        Ok(extremes)
    }
}

impl Friction {
    /// Conditions that include the minimum and the maximum of the coefficients over `range` at any pressure
    /// ([`ConditionRange::extremes`]); the corners if coefficients do not depend on the condition.
    ///
    /// # Errors
    /// [`MaterialError`] with a condition of the range that is not between measured conditions.
    pub fn extremes(&self, range: &ConditionRange) -> Result<Vec<Condition>, MaterialError> {
        let measured = self.measured();
        if measured.is_empty() {
            return Ok(range.corners());
        }
        range.extremes(&measured).map_err(|outside| unknown_condition(self.table(), Some(&outside)))
    }

    /// Selects the condition among `conditions` that represents `range`: the one measured at the most pressures; among
    /// equals the nearest to the middle of the range in ln(v) and humidity, then the first. `None` if `conditions` is
    /// empty.
    pub fn primary(&self, range: &ConditionRange, conditions: &[Condition]) -> Option<Condition> {
        let measured = self.measured();
        let pressures = |condition: &Condition| measured.iter().filter(|own| own.matches(condition)).count();
        let off = |place: f64, [lowest, highest]: [f64; 2]| {
            if highest > lowest { ((place - f64::midpoint(lowest, highest)) / (highest - lowest)).powi(2) } else { 0.0 }
        };
        let from_middle = |condition: &Condition| {
            // Rounded, so that conditions at equal distances on both sides are equivalent.
            let square =
                off(condition.speed_m_s.ln(), range.speed_m_s.map(f64::ln)) + off(condition.humidity, range.humidity);
            (square * 1e6).round()
        };
        let rank = |a: &&Condition, b: &&Condition| {
            pressures(b).cmp(&pressures(a)).then(from_middle(a).total_cmp(&from_middle(b)))
        };
        conditions.iter().min_by(rank).copied()
    }

    /// Conditions at which coefficients were measured, repeated for each pressure.
    pub(super) fn measured(&self) -> Vec<Condition> {
        self.table().iter().filter_map(|row| row.condition).collect()
    }
}

/// Minimum and maximum measured speed, in m/s, at the humidity of each measured condition.
fn speed_ends(measured: &[Condition]) -> Vec<f64> {
    let at = |humidity: f64| {
        measured.iter().filter(move |other| is_same(other.humidity, humidity)).map(|other| other.speed_m_s)
    };
    measured
        .iter()
        .flat_map(|own| [at(own.humidity).fold(f64::INFINITY, f64::min), at(own.humidity).fold(0.0, f64::max)])
        .collect()
}

/// Both ends of a range and the `known` values strictly inside it, distinct and increasing.
fn places([lowest, highest]: [f64; 2], known: &[f64]) -> Vec<f64> {
    let is_inside =
        |place: &f64| *place > lowest && *place < highest && !is_same(*place, lowest) && !is_same(*place, highest);
    let mut places: Vec<f64> = known.iter().copied().filter(is_inside).collect();
    places.extend([lowest, highest]);
    places.sort_by(f64::total_cmp);
    places.dedup_by(|next, previous| is_same(*next, *previous));
    places
}

/// All combinations of `speeds`, in m/s, and `humidities`: one row per speed.
fn lattice(speeds: &[f64], humidities: &[f64]) -> Vec<Vec<Condition>> {
    let at = |speed_m_s: f64| humidities.iter().map(move |&humidity| Condition { speed_m_s, humidity }).collect();
    speeds.iter().map(|&speed_m_s| at(speed_m_s)).collect()
}

/// Weight of each condition of `measured` in the interpolation of `wanted`; `None` outside the measured range.
fn weights_in(measured: &[Condition], wanted: &Condition) -> Option<Vec<f64>> {
    let mut shares = vec![0.0; measured.len()];
    for (own, share) in between(measured, wanted)? {
        // A condition that was measured at several pressures counts once.
        if let Some(place) = measured.iter().position(|other| other.matches(&own)) {
            shares[place] += share;
        }
    }
    Some(shares)
}

/// Whether linear interpolation between the weights `before` at the coordinate `from` and `after` at `to` gives the
/// weights `here` at the coordinate `at`.
fn is_between([before, here, after]: [&Vec<f64>; 3], [from, at, to]: [f64; 3]) -> bool {
    let t = (at - from) / (to - from);
    let is_on_line =
        |((before, here), after): ((&f64, &f64), &f64)| (before + t * (after - before) - here).abs() < WEIGHT_TOLERANCE;
    before.iter().zip(here).zip(after).all(is_on_line)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::condition::tests::at;
    use crate::material::{ConditionFriction, LocalFriction};

    fn range(speed_mm_s: [f64; 2], humidity_pct: [f64; 2]) -> ConditionRange {
        ConditionRange::new(speed_mm_s.map(|v| v * 1e-3), humidity_pct.map(|h| h * 1e-2)).unwrap()
    }

    /// Random coefficients: three pressures at some conditions, one at others.
    fn friction(measured: &[Condition], salt: u64) -> Friction {
        let mut state = salt;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            0.2 + 0.2 * (state >> 33) as f64 / (1_u64 << 31) as f64
        };
        let mut rows = Vec::new();
        for (place, condition) in measured.iter().enumerate() {
            let pressures: &[f64] = if place % 2 == 0 { &[0.5e6, 1.5e6, 2.5e6] } else { &[1e6] };
            for &pressure_pa in pressures {
                let friction = LocalFriction::new(0.5, next(), 0.05).unwrap();
                rows.push(ConditionFriction { pressure_pa, condition: Some(*condition), friction });
            }
        }
        Friction::PerCondition(rows)
    }

    /// Minimum and maximum coefficient over `conditions`.
    fn ends_of(friction: &Friction, conditions: &[Condition], pressure_pa: f64) -> [f64; 2] {
        let mu = |condition: &Condition| friction.at(pressure_pa, Some(condition)).unwrap().friction.dynamic_mean();
        conditions.iter().map(mu).fold([f64::INFINITY, 0.0], |[low, high], mu| [low.min(mu), high.max(mu)])
    }

    #[test]
    fn no_condition_of_the_box_has_lower_or_higher_friction_at_any_pressure() {
        let whole = vec![at(0.4, 15.0), at(2.0, 15.0), at(4.0, 15.0), at(0.4, 80.0), at(2.0, 80.0), at(4.0, 80.0)];
        // Speeds that differ between humidities, and end inside the range.
        let ragged = vec![
            at(0.4, 15.0),
            at(4.0, 15.0),
            at(0.9, 40.0),
            at(2.0, 40.0),
            at(0.4, 80.0),
            at(1.3, 80.0),
            at(4.0, 80.0),
            at(0.6, 55.0),
            at(3.0, 55.0),
        ];
        let boxes = [
            range([0.4, 4.0], [15.0, 80.0]),
            range([0.5, 3.7], [20.0, 70.0]),
            range([0.9, 2.0], [40.0, 40.0]),
            range([1.0, 1.0], [15.0, 80.0]),
            range([0.9, 3.0], [15.0, 50.0]),
        ];
        for measured in [&whole, &ragged] {
            for wide in &boxes {
                let extremes = wide.extremes(measured).unwrap();
                for salt in 0..6 {
                    let friction = friction(measured, salt);
                    let ([v0, v1], [h0, h1]) = (wide.speed_m_s, wide.humidity);
                    let step = |n: i32| f64::from(n) / 30.0;
                    let dense: Vec<Condition> = (0..=30)
                        .flat_map(|i| (0..=30).map(move |j| (step(i), step(j))))
                        .map(|(i, j)| Condition { speed_m_s: v0 * (v1 / v0).powf(i), humidity: h0 + j * (h1 - h0) })
                        .collect();
                    for pressure_pa in [0.4e6, 0.5e6, 1.0e6, 1.2e6, 1.5e6, 2.2e6, 3e6] {
                        let ours = ends_of(&friction, &extremes, pressure_pa);
                        let all = ends_of(&friction, &dense, pressure_pa);
                        // Error from the relative shift of 1e-4 at a jump.
                        assert!(all[0] > ours[0] - 1e-4 && all[1] < ours[1] + 1e-4, "{wide:?} {ours:?} {all:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_complete_grid_gives_its_corners_and_what_was_measured_inside() {
        let measured: Vec<Condition> =
            [0.4, 2.0, 4.0].iter().flat_map(|v| [15.0, 40.0, 80.0].map(|h| at(*v, h))).collect();
        let number = |wide: ConditionRange| wide.extremes(&measured).unwrap().len();
        assert_eq!(number(range([0.4, 4.0], [15.0, 80.0])), 9);
        assert_eq!(number(range([2.0, 2.0], [15.0, 80.0])), 3);
        assert_eq!(number(range([1.0, 3.0], [20.0, 30.0])), 6);
        assert_eq!(range([2.0, 2.0], [40.0, 40.0]).extremes(&measured).unwrap(), [at(2.0, 40.0)]);
        assert!(!range([2.0, 2.0], [40.0, 40.0]).is_wide() && range([2.0, 2.0], [40.0, 50.0]).is_wide());
        assert_eq!(range([0.4, 4.0], [15.0, 80.0]).corners().len(), 4);
    }

    #[test]
    fn the_condition_with_the_most_pressures_nearest_the_middle_stands_for_a_range() {
        let mut rows = Vec::new();
        for (speed_mm_s, humidity_pct, pressures) in
            [(0.4, 15.0, 1), (2.0, 15.0, 4), (4.0, 15.0, 1), (0.4, 80.0, 1), (2.0, 80.0, 4), (4.0, 80.0, 1)]
        {
            for pressure in 1..=pressures {
                let friction = LocalFriction::new(0.3, 0.27, 0.05).unwrap();
                let condition = Some(at(speed_mm_s, humidity_pct));
                rows.push(ConditionFriction { pressure_pa: f64::from(pressure) * 1e6, condition, friction });
            }
        }
        let friction = Friction::PerCondition(rows);
        let primary = |wide: ConditionRange| friction.primary(&wide, &friction.extremes(&wide).unwrap()).unwrap();
        assert_eq!(primary(range([0.4, 4.0], [15.0, 60.0])), at(2.0, 15.0));
        assert_eq!(primary(range([0.4, 4.0], [40.0, 80.0])), at(2.0, 80.0));
        // Nothing was measured inside: the first of four corners.
        assert_eq!(primary(range([0.5, 1.0], [20.0, 30.0])), at(0.5, 20.0));
        let outside = friction.extremes(&range([0.4, 5.0], [15.0, 80.0])).unwrap_err().to_string();
        assert!(outside.contains("5 mm/s at 15 %"), "{outside}");
        let any = Friction::Single(LocalFriction::new(0.3, 0.27, 0.05).unwrap());
        assert_eq!(any.extremes(&range([1.0, 2.0], [0.0, 0.0])).unwrap(), [at(1.0, 0.0), at(2.0, 0.0)]);
    }

    #[test]
    fn where_one_humidity_ends_both_sides_of_the_jump_are_asked() {
        // At 40 % nothing is known beyond 2 mm/s, so that friction at 30 % jumps there.
        let measured = [at(0.4, 15.0), at(4.0, 15.0), at(0.4, 40.0), at(2.0, 40.0), at(0.4, 80.0), at(4.0, 80.0)];
        let extremes = range([1.0, 4.0], [30.0, 30.0]).extremes(&measured).unwrap();
        let speeds: Vec<f64> = extremes.iter().map(|condition| condition.speed_m_s * 1e3).collect();
        assert_eq!(speeds.len(), 4);
        assert!((speeds[1] - 2.0).abs() < 1e-12 && speeds[2] > 2.0 && speeds[2] < 2.001, "{speeds:?}");
    }

    #[test]
    fn what_is_not_between_measured_conditions_is_named() {
        let measured = [at(0.4, 15.0), at(2.0, 15.0), at(0.4, 80.0), at(4.0, 80.0)];
        assert_eq!(range([0.4, 4.0], [15.0, 80.0]).extremes(&measured), Err(at(4.0, 15.0)));
        assert_eq!(range([0.4, 2.0], [10.0, 80.0]).extremes(&measured), Err(at(0.4, 10.0)));
        assert!(range([0.4, 2.0], [15.0, 80.0]).extremes(&measured).is_ok());
        // Both ends are known, the middle is not.
        let hole = [at(0.4, 15.0), at(1.0, 15.0), at(2.0, 15.1), at(4.0, 15.1), at(0.4, 80.0), at(4.0, 80.0)];
        assert!(range([0.4, 4.0], [15.1, 80.0]).extremes(&hole).is_err());
        assert!(ConditionRange::new([2e-3, 1e-3], [0.1, 0.2]).is_err());
        assert!(ConditionRange::new([1e-3, 2e-3], [0.2, f64::NAN]).is_err());
    }
}
