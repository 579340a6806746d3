use serde::{Deserialize, Serialize};

use crate::topography::fourier::{Fourier, FourierWork, Multiplier};
use crate::topography::{HeightMap, MapError};

use crate::contact::area::{ContactArea, contact_area};
use crate::contact::error::require_within;
use crate::contact::preconditioner::Preconditioner;
use crate::contact::solver::{BufferPool, Failure, Outcome, minimize};
use crate::contact::two_grids::{Near, TwoGrids};
use crate::contact::{ContactError, Monitor};

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
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Convergence {
    /// Number of iterations.
    pub iterations: usize,
    /// Number of operator applications in Fourier space, each a transform of the whole map and its inverse.
    pub fourier_pairs: usize,
    /// Final residual as defined at [`SolveOptions::tolerance`].
    pub residual: f64,
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
    /// Estimated error of the area fractions that results from stopping at the tolerance: the change of the fractions
    /// while the residual fell from ten times the tolerance to the tolerance, at least one pixel.
    pub area_error: f64,
    /// Iterations and residual of the solve.
    pub convergence: Convergence,
}

/// Contact moduli for which nothing overflows, in pascals.
const MODULUS_RANGE_PA: std::ops::RangeInclusive<f64> = 1e-3..=1e15;
/// Nominal pressures for which nothing overflows, in pascals.
const PRESSURE_RANGE_PA: std::ops::RangeInclusive<f64> = 0.0..=1e15;

/// Heights of a map in units of their rms, with mean 0. They are computed on each read, so that no second map is
/// stored.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Heights<'m> {
    heights_m: &'m [f64],
    mean_m: f64,
    /// Root mean square height Sq, in metres; infinite for a flat map, whose normalized heights are all 0.
    unit_m: f64,
}

impl<'m> Heights<'m> {
    fn of(map: &'m HeightMap) -> Self {
        let (heights_m, mean_m) = (map.heights_m(), map.mean_m());
        let deviation = heights_m.iter().map(|h| h - mean_m);
        // Dividing by the highest deviation first keeps the squares from underflowing.
        let highest_m = deviation.clone().fold(0.0, |highest, h| f64::max(highest, h.abs()));
        let square: f64 = deviation.map(|h| (h / highest_m).powi(2)).sum::<f64>() / heights_m.len() as f64;
        let unit_m = if highest_m > 0.0 { highest_m * square.sqrt() } else { f64::INFINITY };
        Self { heights_m, mean_m, unit_m }
    }

    pub(crate) const fn len(&self) -> usize {
        self.heights_m.len()
    }

    pub(crate) fn iter(self) -> impl Iterator<Item = f64> + 'm {
        self.heights_m.iter().map(move |&height_m| self.normalized(height_m))
    }

    /// Heights in metres, row by row.
    pub(crate) const fn in_metres(&self) -> &'m [f64] {
        self.heights_m
    }

    #[inline(always)]
    pub(crate) fn normalized(self, height_m: f64) -> f64 {
        (height_m - self.mean_m) / self.unit_m
    }
}

/// Contact problem of a rough elastic half-space against a rigid plane, normalized.
///
/// Heights are in units of Sq and pressures in units of E* Sq q1/2, where q1 is the smallest wave number of the map.
/// Therefore the area fraction A at the pressure P obeys A(P; s h) = A(P/s; h) to rounding if the heights h are scaled
/// by s: one curve of the normalized map serves every Sa and E*.
///
/// Beside the map this takes 2 bytes per pixel, and each running solve 29, or 41 if a side is not a power of two:
/// fields that a transform can recompute are mostly not stored.
#[derive(Clone, Debug)]
pub struct RoughContact<'m> {
    pub(crate) cols: usize,
    pub(crate) fourier: Fourier,
    pub(crate) fourier_single: Fourier<f32>,
    waves: Waves,
    /// Multiplier of u = K p: q1/q for each wave number q, 0 for the mean.
    pub(crate) compliance_single: Multiplier<f32>,
    /// Cheap approximation of the compliance K on two grids.
    pub(crate) compliance_two_grids: TwoGrids,
    /// Approximate inverse of the compliance K on free points, from q/q1 for each wave and 1/2 for the mean.
    pub(crate) preconditioner: Preconditioner,
    pub(crate) heights: Heights<'m>,
    height_unit_m: f64,
    pressure_unit_pa: f64,
    /// Normalized pressure p* of full contact.
    full_contact_pressure: f64,
}

/// Stiffness and compliance of waves with k periods along x and l along y, in normalized units.
#[derive(Clone, Copy, Debug)]
struct Waves {
    /// Smallest wave numbers along x and along y, in units of q1, the smaller of the two.
    first: [f64; 2],
}

impl Waves {
    fn wave_number(self, k: usize, l: usize) -> f64 {
        let [qx, qy] = [self.first[0] * k as f64, self.first[1] * l as f64];
        (qx * qx + qy * qy).sqrt()
    }

    /// Stiffness q/q1 of a wave, from p_q = (E* q/2) u_q. The mean displacement of a half-space is arbitrary; its
    /// stiffness is set to half that of the first wave.
    fn stiffness(self, k: usize, l: usize) -> f64 {
        if k == 0 && l == 0 { 0.5 } else { self.wave_number(k, l) }
    }

    /// Compliance q1/q of a wave, from u_q = 2/(E* q) p_q; 0 for the mean.
    fn compliance(self, k: usize, l: usize) -> f64 {
        if k == 0 && l == 0 { 0.0 } else { 1.0 / self.wave_number(k, l) }
    }
}

impl<'m> RoughContact<'m> {
    /// Prepares the contact problem of `map`, taken as one period, on a half-space of contact modulus E* = E/(1 -
    /// nu^2).
    ///
    /// # Errors
    /// [`ContactError`] if points of the map are missing, if the modulus lies outside 1e-3 to 1e15 Pa, or once `monitor`
    /// cancels.
    pub fn new(map: &'m HeightMap, contact_modulus_pa: f64, monitor: &dyn Monitor) -> Result<Self, ContactError> {
        let check_cancelled = || monitor.heed().map_err(MapError::from);
        map.require_complete()?;
        require_within("contact modulus", contact_modulus_pa, MODULUS_RANGE_PA, "a modulus from 1e-3 to 1e15 Pa")?;
        let heights = Heights::of(map);
        check_cancelled()?;
        let (rows, cols) = (map.rows(), map.cols());
        let sides_m = [rows as f64 * map.dx_m(), cols as f64 * map.dy_m()];
        let longest_m = sides_m[0].max(sides_m[1]);
        let waves = Waves { first: sides_m.map(|side_m| longest_m / side_m) };
        let fourier_single: Fourier<f32> = Fourier::new(rows, cols);
        let compliance_single = fourier_single.wave_multiplier(|k, l| waves.compliance(k, l));
        check_cancelled()?;
        let compliance_two_grids = TwoGrids::new(rows, cols, Near::ShortWaves, |k, l| waves.compliance(k, l));
        check_cancelled()?;
        let preconditioner = Preconditioner::new(rows, cols, |k, l| waves.stiffness(k, l));
        check_cancelled()?;
        let height_unit_m = if heights.unit_m.is_finite() { heights.unit_m } else { 0.0 };
        let first = std::f64::consts::TAU / longest_m;
        let mut contact = Self {
            cols,
            fourier: Fourier::new(rows, cols),
            fourier_single,
            waves,
            compliance_single,
            compliance_two_grids,
            preconditioner,
            heights,
            height_unit_m,
            pressure_unit_pa: 0.5 * contact_modulus_pa * height_unit_m * first,
            full_contact_pressure: 0.0,
        };
        let (mut height, mut flattening) = (vec![0.0; heights.len()], vec![0.0; heights.len()]);
        contact.flatten(&mut height, &mut flattening, &mut contact.fourier.work_watched(monitor));
        check_cancelled()?;
        contact.full_contact_pressure = -flattening.iter().copied().fold(0.0, f64::min);
        Ok(contact)
    }

    /// Computes the displacement u = K p, in normalized units.
    pub(crate) fn displace(&self, pressure: &[f64], displacement: &mut [f64], work: &mut FourierWork<'_>) {
        self.fourier.filter_unstored(pressure, |k, l| self.waves.compliance(k, l), displacement, work);
    }

    /// Writes to `flattening` the deviation from the mean of the pressure that flattens the surface, in units of
    /// `pressure_unit_pa`; `height` is work space.
    pub(crate) fn flatten(&self, height: &mut [f64], flattening: &mut [f64], work: &mut FourierWork<'_>) {
        height.iter_mut().zip(self.heights.iter()).for_each(|(height, h)| *height = h);
        self.fourier.filter_unstored(height, |k, l| self.waves.stiffness(k, l), flattening, work);
    }

    /// Lowest nominal pressure p* at which all of the map is in contact, in pascals.
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
            return self.known_state(pressure_pa, area, monitor);
        }
        let outcome = self.minimize(pressure_pa, options, monitor, &mut BufferPool::default())?;
        let (area, area_error) = self.area(&outcome);
        let Outcome { pressure: mut pressure_pa, displacement: mut gap_m, convergence, .. } = outcome;
        let mut lowest = f64::INFINITY;
        for (g, h) in gap_m.iter_mut().zip(self.heights.iter()) {
            *g -= h;
            lowest = lowest.min(*g);
        }
        gap_m.iter_mut().for_each(|g| *g = (*g - lowest) * self.height_unit_m);
        pressure_pa.iter_mut().for_each(|p| *p *= self.pressure_unit_pa);
        Ok(ContactState { pressure_pa, gap_m, area, area_error, convergence })
    }

    /// Returns the area at `pressure_pa` if it is known without iterations, at zero load or full contact; otherwise
    /// `None`.
    pub(crate) fn known_area(&self, pressure_pa: f64) -> Option<ContactArea> {
        if pressure_pa == 0.0 {
            return Some(ContactArea::NONE);
        }
        (pressure_pa >= self.full_contact_pressure_pa()).then_some(ContactArea::FULL)
    }

    /// Returns the state at a pressure for which [`Self::known_area`] returned `area`.
    fn known_state(
        &self,
        pressure_pa: f64,
        area: ContactArea,
        monitor: &dyn Monitor,
    ) -> Result<ContactState, ContactError> {
        let points = self.heights.len();
        let (mut gap_m, mut pressures_pa) = (vec![0.0; points], vec![0.0; points]);
        if area == ContactArea::NONE {
            let highest = self.heights.iter().fold(f64::NEG_INFINITY, f64::max);
            gap_m.iter_mut().zip(self.heights.iter()).for_each(|(g, h)| *g = (highest - h) * self.height_unit_m);
        } else {
            self.flatten(&mut gap_m, &mut pressures_pa, &mut self.fourier.work_watched(monitor));
            monitor.heed().map_err(MapError::from)?;
            gap_m.fill(0.0);
            pressures_pa.iter_mut().for_each(|p| *p = (pressure_pa + *p * self.pressure_unit_pa).max(0.0));
        }
        Ok(ContactState {
            pressure_pa: pressures_pa,
            gap_m,
            area,
            area_error: 0.0,
            convergence: Convergence::default(),
        })
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

    /// Returns the contact area of the solution `outcome`, and the estimated error of the area fractions.
    pub(crate) fn area(&self, outcome: &Outcome) -> (ContactArea, f64) {
        let area = contact_area(&outcome.pressure, self.cols);
        // Without an earlier state the whole area counts as uncertain.
        let one_pixel = 1.0 / self.heights.len() as f64;
        let error = outcome.area_before.map_or(area.fraction, |before| area.distance(&before)).max(one_pixel);
        (area, error)
    }
}

/// Checks that the pressure and the tolerance of a solve lie in their ranges.
pub(crate) fn check(pressure_pa: f64, options: &SolveOptions) -> Result<(), ContactError> {
    require_within("pressure", pressure_pa, PRESSURE_RANGE_PA, "a pressure from 0 to 1e15 Pa")?;
    require_within("tolerance", options.tolerance, 1e-15..=1.0, "a number from 1e-15 to 1")?;
    Ok(())
}
