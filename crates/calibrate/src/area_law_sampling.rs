//! How well a map determines its area law: windows of it, and coarser pixels.

use slipgrid_contact::{ContactError, coarser, windows};
use slipgrid_monitor::Monitor;
use slipgrid_statistics::mean_and_std;
use slipgrid_topography::HeightMap;

use crate::area_law::{AreaLawRequest, area_curve, area_law};
use slipgrid_monitor::Part;

/// Windows along either side where nobody asks for another number.
pub const DEFAULT_WINDOWS: usize = 2;
/// Error at which the contact computation of a window or a coarser map ends: areas to about 3e-5, far below what
/// windows differ by.
pub const STATISTICS_TOLERANCE: f64 = 1e-5;
/// Fewest points along a side of a window that is asked for by default.
const LEAST_DEFAULT_PIXELS: usize = 32;

/// Fewest points along a side of a map that is cut into windows where nobody asks for them.
pub const LEAST_DEFAULT_SIDE: usize = DEFAULT_WINDOWS * LEAST_DEFAULT_PIXELS;

/// How a window becomes the period that the contact computation takes.
pub const WINDOW_STATEMENT: &str =
    "each window is levelled and taken as its periodic component (Moisan), which continues itself across its sides";

/// The area law of windows of a map, each alone.
#[derive(Clone, Debug, PartialEq)]
pub struct WindowSpread {
    /// Windows along either side.
    pub per_side: usize,
    /// Points of a window along x and y.
    pub pixels: [usize; 2],
    /// Mean of f over the windows, one per pressure solved for.
    pub factor_mean: Vec<f64>,
    /// Standard deviation of f among the windows.
    pub factor_spread: Vec<f64>,
    /// Mean rms slope of the windows.
    pub rms_slope_mean: f64,
    /// Its standard deviation among them.
    pub rms_slope_spread: f64,
}

impl WindowSpread {
    /// Number of windows.
    #[must_use]
    pub const fn count(&self) -> usize {
        self.per_side * self.per_side
    }

    /// Standard errors of the factors of the whole map: the windows' standard deviation over the root of their
    /// number, as for independent pieces of one surface.
    #[must_use]
    pub fn factor_std(&self) -> Vec<f64> {
        self.factor_spread.iter().map(|spread| spread / (self.count() as f64).sqrt()).collect()
    }
}

/// Whether `map` is large enough to be cut into the default windows.
#[must_use]
pub fn takes_default_windows(map: &HeightMap) -> bool {
    map.rows().min(map.cols()) >= LEAST_DEFAULT_SIDE
}

/// The spread of f among `per_side` x `per_side` windows of `map`, `per_side` at least 2; `None` where a window gives
/// no law.
///
/// # Errors
/// [`ContactError`] if the map cannot be cut so, or a number means nothing to the contact solver.
pub fn window_spread(
    map: &HeightMap,
    per_side: usize,
    request: &AreaLawRequest<'_>,
    monitor: &dyn Monitor,
) -> Result<Option<WindowSpread>, ContactError> {
    let windows = windows(map, per_side, monitor)?;
    let pixels = [windows[0].rows(), windows[0].cols()];
    let mut factors = Vec::new();
    let mut slopes = Vec::new();
    let monitor = Part::new(monitor, 1.0 / windows.len() as f64);
    for window in &windows {
        let Some(factor) = factors_of(window, request, &monitor)? else { return Ok(None) };
        factors.push(factor);
        slopes.push(window.rms_slope_watched(&monitor)?);
    }
    let at = |n: usize| factors.iter().map(move |factor| factor[n]);
    let mean_and_spread = |values: &mut dyn Iterator<Item = f64>| {
        // Of at least four windows.
        let found = mean_and_std(values.collect::<Vec<f64>>());
        found.map_or([f64::NAN; 2], |(mean, std)| [mean, std.unwrap_or(f64::NAN)])
    };
    let statistics: Vec<[f64; 2]> = (0..request.pressures_pa.len()).map(|n| mean_and_spread(&mut at(n))).collect();
    let [rms_slope_mean, rms_slope_spread] = mean_and_spread(&mut slopes.iter().copied());
    Ok(Some(WindowSpread {
        per_side,
        pixels,
        factor_mean: statistics.iter().map(|pair| pair[0]).collect(),
        factor_spread: statistics.iter().map(|pair| pair[1]).collect(),
        rms_slope_mean,
        rms_slope_spread,
    }))
}

/// The area law at another lateral resolution.
#[derive(Clone, Debug, PartialEq)]
pub struct Resolution {
    /// Points of the map that one point of this one averages, along either side.
    pub coarser: usize,
    /// Pixel along the sliding direction, in metres.
    pub pixel_m: f64,
    /// Rms slope that is left.
    pub rms_slope: f64,
    /// f, one per pressure solved for; `None` where the curve gives no law.
    pub factor: Option<Vec<f64>>,
}

/// The area law of `map` seen by `factor` times coarser pixels.
///
/// # Errors
/// As [`window_spread`].
pub fn resolution(
    map: &HeightMap,
    factor: usize,
    request: &AreaLawRequest<'_>,
    monitor: &dyn Monitor,
) -> Result<Resolution, ContactError> {
    let blunt = coarser(map, factor)?;
    Ok(Resolution {
        coarser: factor,
        pixel_m: blunt.dx_m(),
        rms_slope: blunt.rms_slope_watched(monitor)?,
        factor: factors_of(&blunt, request, monitor)?,
    })
}

/// f of `map` at the pressures solved for.
fn factors_of(
    map: &HeightMap,
    request: &AreaLawRequest<'_>,
    monitor: &dyn Monitor,
) -> Result<Option<Vec<f64>>, ContactError> {
    let curve = area_curve(map, request.contact_modulus_pa, request.pressures_pa, STATISTICS_TOLERANCE, monitor)?;
    let law = area_law(&curve.points, request.threshold_pa).ok();
    Ok(law.map(|law| request.pressures_pa.iter().map(|&pressure_pa| law.factor(pressure_pa)).collect()))
}
