use crate::topography::fourier::{Fourier, Multiplier};
use crate::topography::{HeightMap, MapError};

use crate::contact::area::{ContactArea, contact_area};
use crate::contact::error::require_within;
use crate::contact::preconditioner::Preconditioner;
use crate::contact::solver::{BufferPool, Failure, Outcome, minimize};
use crate::contact::two_grids::{Near, TwoGrids};
use crate::contact::{ContactError, Monitor, Unwatched, kernels};

/// Tolerance and maximum number of iterations of the solver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolveOptions {
    /// Residual at which a state counts as converged.
    ///
    /// The residual is |sum (g - min g) p| / (sum p Sq), which is the mean gap under pressure over the rms height, plus
    /// the relative error of the load. The area error follows the tolerance: on the reference maps 1e-4 leaves 6e-5,
    /// 1e-5 leaves 5e-6, and from 1e-6 on no pixel changes.
    pub tolerance: f64,
    /// Maximum number of iterations before a solve fails.
    pub max_iterations: usize,
}

impl Default for SolveOptions {
    fn default() -> Self {
        Self { tolerance: 1e-8, max_iterations: 20_000 }
    }
}

/// Cost and final residual of a solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Convergence {
    /// Number of iterations.
    pub iterations: usize,
    /// Number of operator applications in Fourier space, each a transform of the whole map and its inverse.
    pub fourier_pairs: usize,
    /// Final residual as defined at [`SolveOptions::tolerance`].
    pub residual: f64,
}

impl Convergence {
    /// Convergence of a state that is known without iterations.
    pub(crate) const KNOWN: Self = Self { iterations: 0, fourier_pairs: 0, residual: 0.0 };
}

/// A state of contact: pressure and gap at every point of the map.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactState {
    /// Contact pressure, row by row, not negative, in pascals.
    pub pressure_pa: Vec<f64>,
    /// Distance to the rigid plane, row by row, not negative, in metres.
    pub gap_m: Vec<f64>,
    /// Real contact area.
    pub area: ContactArea,
    /// Estimated error of the area fractions that results from stopping at the tolerance: their change while the
    /// residual fell through the last decade, at least one pixel.
    pub area_error: f64,
    /// Iterations and residual of the solve.
    pub convergence: Convergence,
}

/// Moduli for which nothing overflows, in pascals.
const MODULUS_RANGE_PA: std::ops::RangeInclusive<f64> = 1e-3..=1e15;
const PRESSURE_RANGE_PA: std::ops::RangeInclusive<f64> = 0.0..=1e15;

/// Maximum of Newton steps for the level of the initial pressures; a dozen are needed.
const MAX_LEVEL_STEPS: usize = 50;
/// The level is found first on every 16th group of points, which is cheaper.
const SAMPLED_EVERY: usize = 16;
/// Relative load error at which the search for the level ends; scaling removes the rest.
const NEGLIGIBLE_LOAD_ERROR: f64 = 1e-3;

/// Contact problem of a rough elastic half-space against a rigid plane, normalized.
///
/// Heights are in units of Sq and pressures in units of E* Sq q1/2, where q1 is the smallest wave number of the map.
/// Therefore A(P; s h) = A(P/s; h) holds to rounding: one curve of the normalized map serves every Sa and E*.
#[derive(Clone, Debug)]
pub struct RoughContact {
    pub(crate) cols: usize,
    pub(crate) fourier: Fourier,
    pub(crate) fourier_single: Fourier<f32>,
    /// Multiplier of u = K p: q1/q for each wave, 0 for the mean.
    pub(crate) compliance: Multiplier,
    pub(crate) compliance_single: Multiplier<f32>,
    /// Cheap approximation of `compliance` on two grids.
    pub(crate) compliance_two_grids: TwoGrids,
    /// Approximate inverse of K on free points, from q/q1 for each wave and 1/2 for the mean.
    pub(crate) preconditioner: Preconditioner,
    /// Normalized heights, mean 0, rms 1; all 0 for a flat map.
    pub(crate) height: Vec<f64>,
    height_unit_m: f64,
    pressure_unit_pa: f64,
    /// Normalized pressure of full contact p*.
    full_contact_pressure: f64,
    /// Normalized pressure that flattens the surface, minus its mean.
    full_contact_fluctuation: Vec<f64>,
}

impl RoughContact {
    /// Prepares the contact problem of `map`, taken as one period, on a half-space of contact modulus E* = E/(1 -
    /// nu^2).
    ///
    /// # Errors
    /// [`ContactError`] if points of the map are missing or the modulus lies outside 1e-3 to 1e15 Pa.
    pub fn new(map: &HeightMap, contact_modulus_pa: f64) -> Result<Self, ContactError> {
        Self::with_monitor(map, contact_modulus_pa, &Unwatched)
    }

    /// Like [`Self::new`], but stops when `monitor` cancels.
    pub(crate) fn with_monitor(
        map: &HeightMap,
        contact_modulus_pa: f64,
        monitor: &dyn Monitor,
    ) -> Result<Self, ContactError> {
        let check_cancelled = || monitor.heed().map_err(MapError::from);
        map.require_complete()?;
        require_within("contact modulus", contact_modulus_pa, MODULUS_RANGE_PA, "a modulus from 1e-3 to 1e15 Pa")?;
        let mean_m = map.mean_m();
        let deviation = map.heights_m().iter().map(|h| h - mean_m);
        // Dividing by the highest deviation first keeps the squares from underflowing.
        let highest_m = deviation.clone().fold(0.0, |highest, h| f64::max(highest, h.abs()));
        let rms: f64 = deviation.clone().map(|h| (h / highest_m).powi(2)).sum::<f64>() / map.heights_m().len() as f64;
        check_cancelled()?;
        let height_unit_m = if highest_m > 0.0 { highest_m * rms.sqrt() } else { 0.0 };
        let height: Vec<f64> = deviation.map(|h| if highest_m > 0.0 { h / height_unit_m } else { 0.0 }).collect();

        check_cancelled()?;
        let fourier = Fourier::new(map.rows(), map.cols());
        let longest_m = (map.rows() as f64 * map.dx_m()).max(map.cols() as f64 * map.dy_m());
        let first = std::f64::consts::TAU / longest_m;
        let (dx_m, dy_m) = (map.dx_m(), map.dy_m());
        // u_q = 2/(E* q) p_q, which in normalized units is q1/q.
        let compliance = |k, l| if k == 0 && l == 0 { 0.0 } else { first / fourier.wave_number(k, l, dx_m, dy_m) };
        // p_q = E* q/2 u_q. The mean displacement of a half-space is arbitrary; its stiffness is set to half that of
        // the first wave.
        let stiffness = |k, l| if k == 0 && l == 0 { 0.5 } else { fourier.wave_number(k, l, dx_m, dy_m) / first };
        let fourier_single: Fourier<f32> = Fourier::new(map.rows(), map.cols());
        // Pressure that flattens the surface, minus its mean.
        let mut fluctuation = vec![0.0; height.len()];
        let flattening = fourier.wave_multiplier(stiffness);
        check_cancelled()?;
        fourier.filter(&height, &flattening, &mut fluctuation, &mut fourier.work_watched(monitor));
        check_cancelled()?;
        let lowest = fluctuation.iter().copied().fold(0.0, f64::min);
        let compliance_double = fourier.wave_multiplier(compliance);
        check_cancelled()?;
        let compliance_single = fourier_single.wave_multiplier(compliance);
        check_cancelled()?;
        let compliance_two_grids = TwoGrids::new(map.rows(), map.cols(), Near::ShortWaves, compliance);
        check_cancelled()?;
        let preconditioner = Preconditioner::new(map.rows(), map.cols(), stiffness);
        check_cancelled()?;
        Ok(Self {
            cols: map.cols(),
            compliance: compliance_double,
            fourier,
            compliance_single,
            compliance_two_grids,
            preconditioner,
            fourier_single,
            height,
            height_unit_m,
            pressure_unit_pa: 0.5 * contact_modulus_pa * height_unit_m * first,
            full_contact_pressure: -lowest,
            full_contact_fluctuation: fluctuation,
        })
    }

    /// Writes the initial pressures: those that flatten the surface, lowered by a constant until the positive ones have
    /// the normalized mean `nominal` > 0. They are close to the solution near full contact.
    pub(crate) fn press_flat(&self, nominal: f64, pressure: &mut [f64]) {
        let fluctuation = &self.full_contact_fluctuation;
        let mut level = nominal;
        // m(c) = mean max(c + f, 0) is convex: after at most one step from below, Newton's iterates descend to m(c) =
        // P.
        for every in [SAMPLED_EVERY, 1] {
            for _ in 0..MAX_LEVEL_STEPS {
                let sums = kernels::sum_positive(fluctuation, level, every);
                // (m - P) / m'
                let lowering = (sums.sum - nominal * sums.points) / sums.count;
                if !lowering.is_finite() || lowering.abs() <= NEGLIGIBLE_LOAD_ERROR * nominal {
                    break;
                }
                level -= lowering;
            }
        }
        pressure.iter_mut().zip(fluctuation).for_each(|(p, f)| *p = (level + f).max(0.0));
        let scale = nominal * pressure.len() as f64 / pressure.iter().sum::<f64>();
        if !scale.is_finite() {
            pressure.fill(nominal);
            return;
        }
        pressure.iter_mut().for_each(|pressure| *pressure *= scale);
    }

    /// p*, the pressure from which all of the map is in contact, in pascals.
    #[must_use]
    pub fn full_contact_pressure_pa(&self) -> f64 {
        self.full_contact_pressure * self.pressure_unit_pa
    }

    /// Solves for the state of contact at the nominal pressure `pressure_pa`.
    ///
    /// Zero load, pressures from p* on, and flat maps need no iterations.
    ///
    /// # Errors
    /// [`ContactError::OutOfRange`] unless the pressure lies between 0 and 1e15 Pa and the tolerance between 1e-15 and
    /// 1; [`ContactError::NotConverged`] if the residual stays above the tolerance; [`MapError::Cancelled`] once
    /// `monitor` cancels.
    pub fn solve(
        &self,
        pressure_pa: f64,
        options: &SolveOptions,
        monitor: &dyn Monitor,
    ) -> Result<ContactState, ContactError> {
        check(pressure_pa, options)?;
        if let Some(area) = self.known_area(pressure_pa) {
            return Ok(self.known_state(pressure_pa, area));
        }
        let outcome = self.minimize(pressure_pa, options, monitor, &mut BufferPool::default())?;
        let (area, area_error) = self.area(&outcome);
        let Outcome { pressure: mut pressure_pa, displacement: mut gap_m, convergence, .. } = outcome;
        let mut lowest = f64::INFINITY;
        for (g, h) in gap_m.iter_mut().zip(&self.height) {
            *g -= h;
            lowest = lowest.min(*g);
        }
        gap_m.iter_mut().for_each(|g| *g = (*g - lowest) * self.height_unit_m);
        pressure_pa.iter_mut().for_each(|p| *p *= self.pressure_unit_pa);
        Ok(ContactState { pressure_pa, gap_m, area, area_error, convergence })
    }

    /// Returns the area at `pressure_pa` if it is known without iterations: no load, or full contact.
    pub(crate) fn known_area(&self, pressure_pa: f64) -> Option<ContactArea> {
        if pressure_pa == 0.0 {
            return Some(ContactArea::NONE);
        }
        (pressure_pa >= self.full_contact_pressure_pa()).then_some(ContactArea::FULL)
    }

    /// Returns the state at a pressure for which [`Self::known_area`] returned `area`.
    fn known_state(&self, pressure_pa: f64, area: ContactArea) -> ContactState {
        let points = self.height.len();
        let (pressure_pa, gap_m) = if area == ContactArea::NONE {
            let highest = self.height.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            (vec![0.0; points], self.height.iter().map(|h| (highest - h) * self.height_unit_m).collect())
        } else {
            let fluctuation = self.full_contact_fluctuation.iter();
            (fluctuation.map(|p| (pressure_pa + p * self.pressure_unit_pa).max(0.0)).collect(), vec![0.0; points])
        };
        ContactState { pressure_pa, gap_m, area, area_error: 0.0, convergence: Convergence::KNOWN }
    }

    /// Solves at a pressure between zero and full contact.
    pub(crate) fn minimize(
        &self,
        pressure_pa: f64,
        options: &SolveOptions,
        monitor: &dyn Monitor,
        pool: &mut BufferPool,
    ) -> Result<Outcome, ContactError> {
        minimize(self, pressure_pa / self.pressure_unit_pa, options, monitor, pool).map_err(|failure| match failure {
            Failure::Cancelled => ContactError::Map(MapError::Cancelled),
            Failure::NotConverged { iterations, residual } => {
                ContactError::NotConverged { pressure_pa, residual, tolerance: options.tolerance, iterations }
            }
        })
    }

    /// Returns the area of a solution and its estimated error.
    pub(crate) fn area(&self, outcome: &Outcome) -> (ContactArea, f64) {
        let area = contact_area(&outcome.pressure, self.cols);
        // Without an earlier state the whole area counts as uncertain.
        let one_pixel = 1.0 / self.height.len() as f64;
        let error = outcome.area_before.map_or(area.fraction, |before| area.distance(&before)).max(one_pixel);
        (area, error)
    }
}

/// Checks the pressure and the tolerance of a solve.
pub(crate) fn check(pressure_pa: f64, options: &SolveOptions) -> Result<(), ContactError> {
    require_within("pressure", pressure_pa, PRESSURE_RANGE_PA, "a pressure from 0 to 1e15 Pa")?;
    require_within("tolerance", options.tolerance, 1e-15..=1.0, "a number from 1e-15 to 1")?;
    Ok(())
}
