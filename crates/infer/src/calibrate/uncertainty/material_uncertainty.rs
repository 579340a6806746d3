//! Uncertainty of a material's numbers: standard errors of its coefficients, of Young's modulus, of the area law's
//! scale, and the error of the model for patterned samples.

use slipgrid_base::statistics::cholesky::dot;
use slipgrid_base::statistics::extremes;
use slipgrid_model::material::{AreaLaw, Condition, END_MARGIN, MaterialError, between};
use slipgrid_model::springblock::Load;

use super::{Covariance, InputUncertainty, ScaleError, local_law, with_scale};
use crate::discrepancy::{Conditions, Discrepancy, DiscrepancyError, Hyperparameters, Load as At, is_same};

/// Errors of a material's numbers, as far as its file states them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MaterialUncertainty {
    /// Fitted dynamic coefficients with standard errors; empty if the file has none.
    pub friction: Vec<CoefficientEstimate>,
    /// Fitted static coefficients with standard errors; empty if the file has none.
    pub static_friction: Vec<CoefficientEstimate>,
    /// Dynamic over steady friction of the flat sample; empty if the file has none.
    pub dynamic_over_steady: Vec<CoefficientEstimate>,
    /// Whether the file has two standard errors for each dynamic coefficient: for the given area law, and including the
    /// errors of the area law.
    pub has_marginal_errors: bool,
    /// Relative standard deviation of Young's modulus; `None` if not known.
    pub modulus_relative_std: Option<f64>,
    /// Whether the area law's scale was fitted to friction, so that the law does not depend on the modulus.
    pub law_is_fitted: bool,
    /// Whether the law is measured flat friction, so that it does not depend on the modulus.
    pub law_is_measured: bool,
    /// Covariance matrix of the relative error of the local dynamic coefficient mu_d and of the logarithm of the area
    /// law's fitted scale, in this order; `None` if it is not known.
    pub scale_covariance: Option<[[f64; 2]; 2]>,
    /// Measured dynamic friction of flat samples, which may contradict an area law from contact area; empty if the file has none.
    pub flat_friction: Vec<CoefficientEstimate>,
    /// Discrepancy learned from trials, or the prior if there are none; `None` if the file says nothing about it.
    pub learned: Option<Discrepancy>,
}

/// A number of a material at one pressure and condition, with its standard error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoefficientEstimate {
    /// Nominal pressure, in pascals; `None` if the number holds for all pressures.
    pub pressure_pa: Option<f64>,
    /// Speed and humidity; `None` if the number holds for all conditions.
    pub condition: Option<Condition>,
    /// Estimated value.
    pub value: f64,
    /// Standard error of `value`; zero if it is not known.
    pub std_error: f64,
}

impl MaterialUncertainty {
    /// The learned discrepancy, or the default prior about the `asked` conditions if the file says nothing about it.
    ///
    /// # Errors
    /// [`DiscrepancyError`] if the error of Young's modulus is invalid.
    pub fn discrepancy(&self, asked: Conditions) -> Result<Discrepancy, DiscrepancyError> {
        let prior = || {
            let modulus_std = self.modulus_relative_std.unwrap_or(0.0);
            Discrepancy::new(Hyperparameters::default(), asked, modulus_std, Vec::new())
        };
        self.learned.clone().map_or_else(prior, Ok)
    }

    /// Covariance of the relative errors of the local dynamic coefficient at `pressures_pa` for each of `conditions`,
    /// one condition after the other. Fitted coefficients are independent. A value interpolated between two of them
    /// shares their errors and is no more accurate than they are. If one pair holds for all loads, or for all
    /// conditions, errors are fully correlated. `None` if the file has no standard errors for a condition.
    pub fn friction_covariance(&self, pressures_pa: &[f64], conditions: &[Option<Condition>]) -> Option<Covariance> {
        covariance(&self.friction, pressures_pa, conditions)
    }

    /// Shares of the flat sample's errors at the loads of trials in the error of flat friction at the loads `at`, each
    /// with the condition under which the material is asked, and the covariance of the rest, as
    /// [`Discrepancy::flat_shares`] gives them. `None` without a trial at a load to which a coefficient was fitted,
    /// without standard errors, and if friction was fitted together with the scale of the area law.
    pub fn flat_shares(
        &self,
        learned: &Discrepancy,
        at: &[(At, Option<Condition>)],
    ) -> Option<(Vec<Vec<f64>>, Covariance)> {
        if self.scale_covariance.is_some() {
            return None;
        }
        // A coefficient without a pressure, a speed or a humidity is that of the loads, if these have one.
        let common = |of: fn(&At) -> f64| {
            let [least, most] = extremes(at.iter().map(|(load, _)| of(load)));
            (least == most).then_some(least)
        };
        let common = [common(|load| load.pressure_pa), common(|load| load.speed_m_s), common(|load| load.humidity)];
        // A coefficient was fitted to the flat samples of its own load alone.
        let is_fitted = |load: &At| {
            self.friction.iter().any(|of| {
                let own = [
                    of.pressure_pa,
                    of.condition.map(|condition| condition.speed_m_s),
                    of.condition.map(|condition| condition.humidity),
                ];
                let value = |number: usize, any: f64| own[number].or(common[number]).unwrap_or(any);
                let (speed_m_s, humidity) = (value(1, load.speed_m_s), value(2, load.humidity));
                // Friction asked for a little beside a measured pressure is that of the measurement.
                let is_near = (value(0, load.pressure_pa) / load.pressure_pa - 1.0).abs() <= END_MARGIN;
                is_near && is_same(load, &At { speed_m_s, humidity, ..*load })
            })
        };
        if !learned.flat_loads().iter().any(is_fitted) {
            return None;
        }
        let errors_at =
            |load: &At, condition| errors(&self.friction, &[load.pressure_pa], &[condition]).map(|rows| rows.concat());
        let of_trial = |load: &At| {
            let condition = Condition { speed_m_s: load.speed_m_s, humidity: load.humidity };
            let own = is_fitted(load).then(|| errors_at(load, Some(condition))).flatten();
            own.unwrap_or_else(|| vec![0.0; self.friction.len()])
        };
        let asked = at.iter().map(|(load, condition)| errors_at(load, *condition));
        let mut rows = asked.collect::<Option<Vec<_>>>()?;
        rows.extend(learned.flat_loads().iter().map(of_trial));
        Some(learned.flat_shares(&of_errors(&rows), at.len()))
    }

    /// Dynamic friction of the flat sample over steady friction at `pressures_pa`, interpolated linearly between
    /// measurements. `None` if the file has no values for the condition.
    pub fn excess(&self, pressures_pa: &[f64], condition: Option<&Condition>) -> Option<Vec<f64>> {
        let known = &self.dynamic_over_steady;
        Some(shares(known, pressures_pa, condition)?.iter().map(|row| mean(row, known)).collect())
    }

    /// Uncertainty at `loads` under `condition`, for a material with this `area_law`.
    ///
    /// # Errors
    /// [`MaterialError`] if the law cannot be shifted by the error of its scale.
    pub fn at_loads(
        &self,
        area_law: Option<&AreaLaw>,
        loads: &[Load],
        condition: Option<&Condition>,
    ) -> Result<InputUncertainty, MaterialError> {
        let pressures_pa: Vec<f64> = loads.iter().map(|load| load.pressure_pa).collect();
        let variance =
            |known: Covariance| known.iter().enumerate().map(|(place, row)| row[place]).collect::<Vec<f64>>();
        let count = loads.len();
        let static_friction = covariance(&self.static_friction, &pressures_pa, &[condition.copied()]).map(variance);
        if let (Some(known), Some(law)) = (&self.scale_covariance, area_law) {
            // Flat friction and the scale were fitted together, so that their errors are correlated.
            let joint = with_scale(known, law, loads)?;
            let scale = ScaleError {
                is_fitted: true,
                variance: joint[count][count],
                with_friction: joint[..count].iter().map(|row| row[count]).collect(),
            };
            let flat_friction = Some((0..count).map(|load| joint[load][load]).collect());
            return Ok(InputUncertainty { flat_friction, static_friction, scale: Some(scale), discrepancy: None });
        }
        Ok(InputUncertainty {
            flat_friction: self.friction_covariance(&pressures_pa, &[condition.copied()]).map(variance),
            static_friction,
            scale: self.modulus_std(area_law).map(|std| ScaleError::of_modulus(std, count)),
            discrepancy: None,
        })
    }

    /// Relative standard deviation of Young's modulus (to first order that of its logarithm), if `area_law` depends on
    /// the modulus.
    pub fn modulus_std(&self, area_law: Option<&AreaLaw>) -> Option<f64> {
        self.modulus_relative_std
            .filter(|std| *std > 0.0 && !self.law_is_fitted && !self.law_is_measured && area_law.is_some())
    }

    /// Law of friction under `condition` if the local coefficient follows the local pressure, see [`local_law()`];
    /// `None` if flat friction is not known to contradict the `area_law`.
    pub fn local_law(&self, area_law: Option<&AreaLaw>, condition: Option<&Condition>) -> Option<AreaLaw> {
        let is_of_friction = self.law_is_fitted || self.law_is_measured;
        local_law(area_law.filter(|_| !is_of_friction)?, &self.flat_friction, condition)
    }

    /// Lists the errors that a material with this `area_law` does not state; `knowledge` holds the stated ones.
    pub fn unknown(&self, knowledge: &InputUncertainty, area_law: Option<&AreaLaw>) -> Vec<&'static str> {
        let mut unknown = Vec::new();
        if knowledge.flat_friction.is_none() {
            unknown.push("flat friction");
        }
        let Some(law) = area_law else { return unknown };
        let fitted_together = self.scale_covariance.is_some();
        if self.law_is_fitted && !fitted_together {
            unknown.push("scale of the area law");
        }
        if !self.law_is_fitted && !self.law_is_measured && !fitted_together && self.modulus_relative_std.is_none() {
            unknown.push("Young's modulus");
        }
        if !fitted_together && law.factor_std().is_none() {
            unknown.push("area law");
        }
        unknown
    }
}

/// Weights of the `known` coefficients in the coefficient at each of `pressures_pa` under `condition`, one row per
/// pressure. `None` if nothing is known, or `condition` is outside the known conditions.
pub(super) fn shares(
    known: &[CoefficientEstimate],
    pressures_pa: &[f64],
    condition: Option<&Condition>,
) -> Option<Vec<Vec<f64>>> {
    let measured: Vec<Condition> = known.iter().filter_map(|row| row.condition).collect();
    let conditions: Vec<(Option<Condition>, f64)> = if measured.is_empty() {
        vec![(None, 1.0)]
    } else {
        between(&measured, condition?)?.into_iter().map(|(own, share)| (Some(own), share)).collect()
    };
    let is_of =
        |row: &CoefficientEstimate, own: &Option<Condition>| Condition::is_same(row.condition.as_ref(), own.as_ref());
    let at = |&at_pa: &f64| {
        let mut row = vec![0.0; known.len()];
        for (own, share) in &conditions {
            let places: Vec<usize> = (0..known.len()).filter(|place| is_of(&known[*place], own)).collect();
            let estimates: Vec<&CoefficientEstimate> = places.iter().map(|place| &known[*place]).collect();
            places.iter().zip(weights(&estimates, at_pa)?).for_each(|(place, weight)| row[*place] += share * weight);
        }
        Some(row)
    };
    pressures_pa.iter().map(at).collect()
}

/// Mean of the `known` coefficients with the weights `row`.
pub(super) fn mean(row: &[f64], known: &[CoefficientEstimate]) -> f64 {
    row.iter().zip(known).map(|(share, known)| share * known.value).sum()
}

/// Covariance of the relative errors of the `known` coefficients at `pressures_pa` for each of `conditions`, one
/// condition after the other. `None` as for [`shares`].
fn covariance(
    known: &[CoefficientEstimate],
    pressures_pa: &[f64],
    conditions: &[Option<Condition>],
) -> Option<Covariance> {
    errors(known, pressures_pa, conditions).map(|rows| of_errors(&rows))
}

/// Covariance of values with the relative errors `rows`, in terms of independent errors of standard deviation 1.
fn of_errors(rows: &[Vec<f64>]) -> Covariance {
    rows.iter().map(|left| rows.iter().map(|right| dot(left, right)).collect()).collect()
}

/// Relative errors of the coefficient at `pressures_pa` for each of `conditions`, one condition after the other: one row
/// per value, with its share in the independent error of each of the `known` coefficients. `None` as for [`shares`].
fn errors(
    known: &[CoefficientEstimate],
    pressures_pa: &[f64],
    conditions: &[Option<Condition>],
) -> Option<Vec<Vec<f64>>> {
    let each = conditions.iter().map(|condition| shares(known, pressures_pa, condition.as_ref()));
    let rows = each.collect::<Option<Vec<Vec<Vec<f64>>>>>()?.concat();
    // The standard error for another sample between two measurements is no smaller than at them, because errors do not
    // average out:
    // s_i = sum_k w_ik s_k,   cov(mu_i, mu_j) = rho_ij s_i s_j / (mu_i mu_j),   rho_ij that of independent errors w_ik
    // s_k
    let each = |row: &[f64]| -> Vec<f64> { row.iter().zip(known).map(|(w, known)| w * known.std_error).collect() };
    let size = |errors: &[f64]| errors.iter().map(|error| error * error).sum::<f64>().sqrt();
    let scaled = |row: &Vec<f64>| {
        let errors = each(row);
        let (correlated, independent) = (errors.iter().sum::<f64>(), size(&errors));
        let scale = if independent > 0.0 { correlated / (independent * mean(row, known)) } else { 0.0 };
        errors.into_iter().map(|error| scale * error).collect::<Vec<f64>>()
    };
    Some(rows.iter().map(scaled).collect())
}

/// Weights of the `known` coefficients at a pressure: linear between measurements, the nearest measurement outside
/// their range; `None` if `known` is empty.
fn weights(known: &[&CoefficientEstimate], at_pa: f64) -> Option<Vec<f64>> {
    let mut weights = vec![0.0; known.len()];
    let pressure = |place: usize| known[place].pressure_pa;
    let mut order: Vec<usize> = (0..known.len()).collect();
    order.sort_by(|&a, &b| pressure(a).unwrap_or(0.0).total_cmp(&pressure(b).unwrap_or(0.0)));
    let (&first, &last) = (order.first()?, order.last()?);
    let (Some(first_pa), Some(last_pa)) = (pressure(first), pressure(last)) else {
        weights[first] = 1.0;
        return Some(weights);
    };
    if at_pa <= first_pa || at_pa >= last_pa {
        weights[if at_pa <= first_pa { first } else { last }] = 1.0;
        return Some(weights);
    }
    let next = order.partition_point(|&place| pressure(place).is_some_and(|own_pa| own_pa <= at_pa));
    let (low, high) = (order[next - 1], order[next]);
    let (low_pa, high_pa) = (pressure(low)?, pressure(high)?);
    let t = (at_pa - low_pa) / (high_pa - low_pa);
    (weights[low], weights[high]) = (1.0 - t, t);
    Some(weights)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discrepancy::tests::{cut, groove, measured};
    use crate::discrepancy::{Hyperparameters, Sensitivity};

    /// A trial at three loads; the coefficient of the second one, as a calibration and as the scene of a design state it.
    #[test]
    fn friction_shares_the_flat_sample_of_its_own_load_alone() {
        let load = |pressure_pa: f64, humidity: f64| At { pressure_pa, speed_m_s: 2e-3, humidity };
        let loads = [load(0.65e6, 0.4), load(0.65e6, 0.8), load(1.3e6, 0.8)];
        let at = |load: At| measured(load, -0.1, 0.01, Sensitivity::default());
        let trial = cut("", groove(100.0, 300.0, 10.0), loads.map(at).to_vec());
        let learned = Discrepancy::new(Hyperparameters::default(), Conditions::default(), 0.0, vec![trial]).unwrap();
        let condition = Condition { speed_m_s: 2e-3, humidity: 0.8 };
        let shares = |pressure_pa, of: Option<Condition>, asked: &[At]| {
            let own = CoefficientEstimate { pressure_pa, condition: of, value: 0.25, std_error: 0.0025 };
            let known = MaterialUncertainty { friction: vec![own], ..MaterialUncertainty::default() };
            let asked: Vec<_> = asked.iter().map(|load| (*load, Some(condition))).collect();
            known.flat_shares(&learned, &asked)
        };
        for (pressure_pa, of) in [(Some(0.65e6), Some(condition)), (Some(0.65e6), None), (None, None)] {
            let (shares, rest) = shares(pressure_pa, of, &[load(0.651e6, 0.8)]).unwrap();
            let is_own = shares[0].iter().zip([0.0, 0.01, 0.0]).all(|(share, own)| (share - own).abs() < 1e-12);
            assert!(is_own && rest[0][0].abs() < 1e-12, "{shares:?} {rest:?}");
        }
        // No trial at the load, and one coefficient for all pressures of the condition.
        assert!(shares(Some(2.6e6), Some(condition), &[load(2.6e6, 0.8)]).is_none());
        let (shares, _) = shares(None, Some(condition), &loads[1..]).unwrap();
        assert!(shares.iter().all(|own| own[0] == 0.0 && own[1] == own[2] && own[1] > 0.0), "{shares:?}");
    }
}
