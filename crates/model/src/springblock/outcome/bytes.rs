//! Serialization of outcomes, for caches of dynamic runs.

use super::{DynamicCost, InterfacePoint, Status, SurfaceOutcome, TracePoint};

/// Statuses of runs that are worth caching.
const CACHED_STATUSES: [Status; 6] = [
    Status::Converged,
    Status::NoOnset,
    Status::NoFriction,
    Status::ShortWindow,
    Status::SlidingWaves,
    Status::StderrNotReached,
];

impl SurfaceOutcome {
    /// Serializes all numbers as eight bytes each, little-endian; `None` if the run did not reach its end.
    #[must_use]
    pub fn to_bytes(&self) -> Option<Vec<u8>> {
        let Self {
            status,
            mu_dynamic,
            mu_dynamic_stderr,
            stick_slip_excess,
            mu_across,
            averaged_from_s,
            mu_static,
            peak_pressure_pa,
            tension_blocks,
            cavity_closed,
            clearance_m,
            area_law_extrapolated,
            residual,
            iterations,
            cost,
            interface,
            trace,
        } = self;
        let place = CACHED_STATUSES.iter().position(|cached| cached == status)?;
        let DynamicCost { steps, dt_s, site_updates, wall_s } = (*cost)?;
        let counts = [
            place as u64,
            *tension_blocks as u64,
            u64::from(*cavity_closed),
            u64::from(*area_law_extrapolated),
            *iterations as u64,
            steps,
            site_updates,
            interface.len() as u64,
            trace.len() as u64,
        ];
        let optional = [
            *mu_dynamic,
            *mu_dynamic_stderr,
            *stick_slip_excess,
            *mu_across,
            *averaged_from_s,
            *mu_static,
            *clearance_m,
            *residual,
        ];
        let present = optional.iter().map(|value| u64::from(value.is_some()));
        let numbers = optional.iter().map(|value| value.unwrap_or(0.0)).chain([*peak_pressure_pa, dt_s, wall_s]);
        let points = interface.iter().flat_map(|point| [point.x_m, point.y_m, point.pressure_pa, point.friction_pa]);
        let history = trace.iter().flat_map(|point| [point.time_s, point.mu]);
        let words = counts.into_iter().chain(present).chain(numbers.chain(points).chain(history).map(f64::to_bits));
        Some(words.flat_map(u64::to_le_bytes).collect())
    }

    /// Inverse of [`SurfaceOutcome::to_bytes`]; `None` for any other bytes.
    #[must_use]
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let (words, rest) = bytes.as_chunks::<8>();
        if !rest.is_empty() {
            return None;
        }
        let mut words = words.iter().map(|word| u64::from_le_bytes(*word));
        let mut counts = [0; 9];
        for count in &mut counts {
            *count = words.next()?;
        }
        let mut present = [false; 8];
        for is_present in &mut present {
            *is_present = words.next()? == 1;
        }
        let mut numbers = words.map(f64::from_bits);
        let mut optional = [None; 8];
        for (value, is_present) in optional.iter_mut().zip(present) {
            *value = Some(numbers.next()?).filter(|_| is_present);
        }
        let [place, tension_blocks, closed, extrapolated, iterations, steps, site_updates, points, instants] = counts;
        let [
            mu_dynamic,
            mu_dynamic_stderr,
            stick_slip_excess,
            mu_across,
            averaged_from_s,
            mu_static,
            clearance_m,
            residual,
        ] = optional;
        let [peak_pressure_pa, dt_s, wall_s] = [numbers.next()?, numbers.next()?, numbers.next()?];
        let numbers: Vec<f64> = numbers.collect();
        // A run with a cached status has finite numbers only.
        let is_finite = |number: &f64| number.is_finite();
        let first = [peak_pressure_pa, dt_s, wall_s];
        if !optional.iter().flatten().chain(&first).chain(&numbers).all(is_finite) {
            return None;
        }
        let (points, instants) = (usize::try_from(points).ok()?, usize::try_from(instants).ok()?);
        let split = points.checked_mul(4)?;
        if numbers.len() != split.checked_add(instants.checked_mul(2)?)? {
            return None;
        }
        let (interface, trace) = numbers.split_at(split);
        let point =
            |&[x_m, y_m, pressure_pa, friction_pa]: &[f64; 4]| InterfacePoint { x_m, y_m, pressure_pa, friction_pa };
        Some(Self {
            status: *CACHED_STATUSES.get(usize::try_from(place).ok()?)?,
            mu_dynamic,
            mu_dynamic_stderr,
            stick_slip_excess,
            mu_across,
            averaged_from_s,
            mu_static,
            peak_pressure_pa,
            tension_blocks: usize::try_from(tension_blocks).ok()?,
            cavity_closed: closed == 1,
            clearance_m,
            area_law_extrapolated: extrapolated == 1,
            residual,
            iterations: usize::try_from(iterations).ok()?,
            cost: Some(DynamicCost { steps, dt_s, site_updates, wall_s }),
            interface: interface.as_chunks::<4>().0.iter().map(point).collect(),
            trace: trace.as_chunks::<2>().0.iter().map(|&[time_s, mu]| TracePoint { time_s, mu }).collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_outcome_is_what_its_bytes_say_and_other_bytes_are_none() {
        let outcome = SurfaceOutcome {
            mu_dynamic: Some(0.1 + 0.2),
            mu_across: Some(-0.0),
            cost: Some(DynamicCost { steps: 3, dt_s: 4e-9, site_updates: 60, wall_s: 0.5 }),
            tension_blocks: 2,
            cavity_closed: true,
            interface: vec![InterfacePoint { x_m: 1.0, y_m: 2.0, pressure_pa: 3.0, friction_pa: f64::MIN_POSITIVE }],
            trace: vec![TracePoint { time_s: 1e-6, mu: 0.25 }; 2],
            ..SurfaceOutcome::unsolved(Status::ShortWindow, std::iter::empty())
        };
        let bytes = outcome.to_bytes().unwrap();
        assert_eq!(SurfaceOutcome::from_bytes(&bytes), Some(outcome.clone()));
        for length in [0, 8, bytes.len() - 8, bytes.len() - 1] {
            assert_eq!(SurfaceOutcome::from_bytes(&bytes[..length]), None, "{length}");
        }
        assert_eq!(SurfaceOutcome::from_bytes(&[bytes, vec![0; 8]].concat()), None);
        assert_eq!(SurfaceOutcome::from_bytes(&[0xff; 800]), None);
        let cancelled = SurfaceOutcome { status: Status::Cancelled, ..outcome };
        assert_eq!(cancelled.to_bytes(), None);
    }
}
