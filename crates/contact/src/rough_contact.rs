use slipgrid_topography::fourier::{Fourier, Multiplier};
use slipgrid_topography::{HeightMap, MapError};

use crate::area::{ContactArea, contact_area};
use crate::error::within;
use crate::preconditioner::Preconditioner;
use crate::solver::{Failure, Outcome, Spare, minimize};
use crate::two_grids::{Near, TwoGrids};
use crate::{ContactError, Monitor, Unwatched, kernels};

/// How far the solver goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolveOptions {
    /// Residual at which a state counts as converged: |sum (g - min g) p| / (sum p Sq), the mean gap under
    /// pressure over the rms height, and the share of the load that is missing or too much. The area follows
    /// it: on the reference maps 1e-4 leaves 6e-5, 1e-5 5e-6, and from 1e-6 on no pixel changes.
    pub tolerance: f64,
    /// Iterations after which a solve fails.
    pub max_iterations: usize,
}

impl Default for SolveOptions {
    fn default() -> Self {
        Self { tolerance: 1e-8, max_iterations: 20_000 }
    }
}

/// What a solve took, and how well it ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Convergence {
    /// Iterations.
    pub iterations: usize,
    /// Applications of an operator in Fourier space: pairs of a transform and its inverse, all of the map's size.
    pub fourier_pairs: usize,
    /// The residual of [`SolveOptions::tolerance`].
    pub residual: f64,
}

impl Convergence {
    /// That of a state that is known without iterations.
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
    /// Estimate of the error that ending at the tolerance leaves in the area fractions: what they moved by while the
    /// residual fell through the last decade, at least one pixel.
    pub area_error: f64,
    /// What the solve took.
    pub convergence: Convergence,
}

/// Range of moduli and pressures in which nothing overflows, in pascals.
const MODULUS_RANGE_PA: std::ops::RangeInclusive<f64> = 1e-3..=1e15;
const PRESSURE_RANGE_PA: std::ops::RangeInclusive<f64> = 0.0..=1e15;

/// Newton's steps to the level of pressures that a solve begins with; a dozen do.
const MAX_LOWERINGS: usize = 50;
/// The level is found on one in so many points first.
const SAMPLED_OF: usize = 16;
/// Share of the load that is no longer lowered by: scaling brings it there.
const NEGLIGIBLE: f64 = 1e-3;

/// A rough elastic half-space against a rigid plane: fixed parameters, normalized.
///
/// Heights are in units of Sq and pressures in units of E* Sq q1/2, q1 the smallest wave number of the map.
/// So A(P; s h) = A(P/s; h) holds to the last digits: one curve of the normalized map serves every Sa and E*.
#[derive(Clone, Debug)]
pub struct RoughContact {
    pub(crate) cols: usize,
    pub(crate) fourier: Fourier,
    pub(crate) fourier_single: Fourier<f32>,
    /// u = K p: q1/q for each wave, 0 for the mean.
    pub(crate) compliance: Multiplier,
    pub(crate) compliance_single: Multiplier<f32>,
    /// About the same, for little.
    pub(crate) compliance_about: TwoGrids,
    /// About K's inverse on free points: of q/q1 for each wave, 1/2 for the mean.
    pub(crate) preconditioner: Preconditioner,
    /// Normalized heights, mean 0, rms 1; all 0 for a flat map.
    pub(crate) height: Vec<f64>,
    height_unit_m: f64,
    pressure_unit_pa: f64,
    /// Normalized p*.
    full_contact_pressure: f64,
    /// The deviation from the mean of the normalized pressure that flattens the surface.
    full_contact_fluctuation: Vec<f64>,
}

impl RoughContact {
    /// The surface `map`, taken as one period, on a half-space of contact modulus E* = E/(1 - nu^2).
    ///
    /// # Errors
    /// [`ContactError`] if points of the map are missing or the modulus lies outside 1e-3 to 1e15 Pa.
    pub fn new(map: &HeightMap, contact_modulus_pa: f64) -> Result<Self, ContactError> {
        Self::watched(map, contact_modulus_pa, &Unwatched)
    }

    /// The same until `monitor` cancels.
    pub(crate) fn watched(
        map: &HeightMap,
        contact_modulus_pa: f64,
        monitor: &dyn Monitor,
    ) -> Result<Self, ContactError> {
        let heed = || monitor.heed().map_err(MapError::from);
        map.require_complete()?;
        within("contact modulus", contact_modulus_pa, MODULUS_RANGE_PA, "a modulus from 1e-3 to 1e15 Pa")?;
        let mean_m = map.mean_m();
        let deviation = map.heights_m().iter().map(|h| h - mean_m);
        // Squares of the highest deviation's share do not vanish, however small the heights.
        let highest_m = deviation.clone().fold(0.0, |highest, h| f64::max(highest, h.abs()));
        let rms: f64 = deviation.clone().map(|h| (h / highest_m).powi(2)).sum::<f64>() / map.heights_m().len() as f64;
        heed()?;
        let height_unit_m = if highest_m > 0.0 { highest_m * rms.sqrt() } else { 0.0 };
        let height: Vec<f64> = deviation.map(|h| if highest_m > 0.0 { h / height_unit_m } else { 0.0 }).collect();

        heed()?;
        let fourier = Fourier::new(map.rows(), map.cols());
        let longest_m = (map.rows() as f64 * map.dx_m()).max(map.cols() as f64 * map.dy_m());
        let first = std::f64::consts::TAU / longest_m;
        let (dx_m, dy_m) = (map.dx_m(), map.dy_m());
        // u_q = 2/(E* q) p_q; in the units above q1/q.
        let compliance = |k, l| if k == 0 && l == 0 { 0.0 } else { first / fourier.wave_number(k, l, dx_m, dy_m) };
        // p_q = E* q/2 u_q; the mean, on which a half-space has no hold, takes half of the first wave's.
        let stiffness = |k, l| if k == 0 && l == 0 { 0.5 } else { fourier.wave_number(k, l, dx_m, dy_m) / first };
        let fourier_single: Fourier<f32> = Fourier::new(map.rows(), map.cols());
        // The deviation from the mean of the pressure that flattens the surface.
        let mut fluctuation = vec![0.0; height.len()];
        let flattening = fourier.wave_multiplier(stiffness);
        heed()?;
        fourier.filter(&height, &flattening, &mut fluctuation, &mut fourier.work_watched(monitor));
        heed()?;
        let lowest = fluctuation.iter().copied().fold(0.0, f64::min);
        let compliance_double = fourier.wave_multiplier(compliance);
        heed()?;
        let compliance_single = fourier_single.wave_multiplier(compliance);
        heed()?;
        let compliance_about = TwoGrids::new(map.rows(), map.cols(), Near::ShortWaves, compliance);
        heed()?;
        let preconditioner = Preconditioner::new(map.rows(), map.cols(), stiffness);
        heed()?;
        Ok(Self {
            cols: map.cols(),
            compliance: compliance_double,
            fourier,
            compliance_single,
            compliance_about,
            preconditioner,
            fourier_single,
            height,
            height_unit_m,
            pressure_unit_pa: 0.5 * contact_modulus_pa * height_unit_m * first,
            full_contact_pressure: -lowest,
            full_contact_fluctuation: fluctuation,
        })
    }

    /// Writes the pressures that flatten the surface, lowered until those above zero bear the normalized mean pressure `nominal` > 0:
    /// near the state of contact where most is in contact.
    pub(crate) fn press_flat(&self, nominal: f64, pressure: &mut [f64]) {
        let fluctuation = &self.full_contact_fluctuation;
        let mut level = nominal;
        // m(c) = mean max(c + f, 0) is convex: Newton's steps come down to m(c) = P from above, after one from below.
        for every in [SAMPLED_OF, 1] {
            for _ in 0..MAX_LOWERINGS {
                let pressed = kernels::pressed(fluctuation, level, every);
                // (m - P) / m'
                let lowering = (pressed.sum - nominal * pressed.points) / pressed.count;
                if !lowering.is_finite() || lowering.abs() <= NEGLIGIBLE * nominal {
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

    /// The state of contact at the nominal pressure `pressure_pa`. Without load nothing is in contact, from
    /// p* on everything is: both are known without iterations, and so is a flat map.
    ///
    /// # Errors
    /// [`ContactError::OutOfRange`] unless the pressure lies between 0 and 1e15 Pa, the tolerance between
    /// 1e-15 and 1; [`ContactError::NotConverged`] if the residual stays above the tolerance; [`MapError::Cancelled`] once
    /// `monitor` cancels.
    pub fn solve(
        &self,
        pressure_pa: f64,
        options: &SolveOptions,
        monitor: &dyn Monitor,
    ) -> Result<ContactState, ContactError> {
        check(pressure_pa, options)?;
        if let Some(area) = self.known_area(pressure_pa) {
            return Ok(self.known(pressure_pa, area));
        }
        let outcome = self.minimize(pressure_pa, options, monitor, &mut Spare::default())?;
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

    /// The area at `pressure_pa` where it is known without iterations.
    pub(crate) fn known_area(&self, pressure_pa: f64) -> Option<ContactArea> {
        if pressure_pa == 0.0 {
            return Some(ContactArea::NONE);
        }
        (pressure_pa >= self.full_contact_pressure_pa()).then_some(ContactArea::FULL)
    }

    /// The state at a pressure at which the area is known.
    fn known(&self, pressure_pa: f64, area: ContactArea) -> ContactState {
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

    /// The solution at a pressure between those at which the area is known.
    pub(crate) fn minimize(
        &self,
        pressure_pa: f64,
        options: &SolveOptions,
        monitor: &dyn Monitor,
        spare: &mut Spare,
    ) -> Result<Outcome, ContactError> {
        minimize(self, pressure_pa / self.pressure_unit_pa, options, monitor, spare).map_err(|failure| match failure {
            Failure::Cancelled => ContactError::Map(MapError::Cancelled),
            Failure::NotConverged { iterations, residual } => {
                ContactError::NotConverged { pressure_pa, residual, tolerance: options.tolerance, iterations }
            }
        })
    }

    /// The area of a solution and what ending at the tolerance leaves open of it.
    pub(crate) fn area(&self, outcome: &Outcome) -> (ContactArea, f64) {
        let area = contact_area(&outcome.pressure, self.cols);
        // Without a state a decade before, all of the area is open.
        let one_pixel = 1.0 / self.height.len() as f64;
        let error = outcome.area_before.map_or(area.fraction, |before| area.distance(&before)).max(one_pixel);
        (area, error)
    }
}

/// Checks what a solve is asked for.
pub(crate) fn check(pressure_pa: f64, options: &SolveOptions) -> Result<(), ContactError> {
    within("pressure", pressure_pa, PRESSURE_RANGE_PA, "a pressure from 0 to 1e15 Pa")?;
    within("tolerance", options.tolerance, 1e-15..=1.0, "a number from 1e-15 to 1")?;
    Ok(())
}
