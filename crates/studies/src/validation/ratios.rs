//! A measured ratio beside the modelled ones.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};
use slipgrid_calibrate::uncertainty::{Deviation, Deviations};
use slipgrid_pattern::Pattern;
use slipgrid_springblock::Status;

use super::laws::ScaledLaw;
use super::model::{Prediction, squares};
use slipgrid_calibrate::Measurement;
use slipgrid_formats::calibration::Calibration;
use slipgrid_units::{HUMIDITY_PCT, LENGTH_UM, PRESSURE_MPA, SPEED_MM_S, tidy};

/// A condition measured on both samples.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeasuredReport {
    /// Normal force on one specimen.
    pub force_n: f64,
    /// The same over its area.
    pub pressure_mpa: f64,
    /// Sliding speed.
    pub speed_mm_s: f64,
    /// Relative humidity.
    pub humidity_pct: f64,
    /// Flat sample.
    pub mu_flat: f64,
    /// Its standard deviation.
    pub mu_flat_std: f64,
    /// Patterned sample.
    pub mu_patterned: f64,
    /// Its standard deviation.
    pub mu_patterned_std: f64,
    /// Patterned over flat.
    pub ratio: f64,
    /// Its standard deviation.
    pub ratio_std: f64,
}

/// A measured ratio and the model's.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RatioReport {
    /// What was measured.
    #[serde(flatten)]
    pub measured: MeasuredReport,
    /// The model's ratio without an area law.
    pub ratio_amontons_coulomb: Option<f64>,
    /// The model's ratios, one per slope factor.
    pub modelled: Vec<ModelledRatio>,
    /// The model with measured flat friction as the local law, one per extrapolation; empty where flat friction was measured at
    /// one pressure only.
    pub measured_law: Vec<MeasuredLawRatio>,
    /// The model at the measured depth and the surface as given; null where both depths are one.
    pub modelled_at_measured_depth: Option<ModelledRatio>,
}

/// The model at one condition where a contact's friction depends on its local pressure as the flat sample's does on the nominal one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeasuredLawRatio {
    /// How the law goes on above the last measured pressure: `constant` or `logarithmic`.
    pub extrapolation: Cow<'static, str>,
    /// Ratio of the pattern as grooves; null where the solve did not converge.
    pub ratio_groove: Option<f64>,
    /// Ratio of square cavities of the same lengths, in space; null likewise.
    pub ratio_square: Option<f64>,
}

/// The model at one condition.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModelledRatio {
    /// What the slopes of the surface are multiplied by.
    pub slope_factor: f64,
    /// Rms slope; null without a surface.
    pub rms_slope: Option<f64>,
    /// f at the nominal pressure.
    pub area_law_factor: f64,
    /// Local dynamic coefficient, mu_flat / f.
    pub dynamic_mean: f64,
    /// Ratio of the pattern as grooves.
    pub ratio_groove: Option<f64>,
    /// Its standard deviation.
    pub ratio_groove_std: Option<f64>,
    /// Standard deviation of the same friction coefficient, ratio times flat friction.
    pub mu_groove_std: Option<f64>,
    /// Ratio of square cavities of the same lengths, in space.
    pub ratio_square: Option<f64>,
    /// Its standard deviation.
    pub ratio_square_std: Option<f64>,
    /// Standard deviation of the same friction coefficient.
    pub mu_square_std: Option<f64>,
    /// Strip estimate of the same from the groove's ratio.
    pub ratio_square_estimate: Option<f64>,
    /// What a specimen as thick as the source's, 7 mm, would change of the groove's ratio.
    pub ratio_groove_thick_difference: Option<f64>,
    /// The same of squares.
    pub ratio_square_thick_difference: Option<f64>,
    /// Largest local pressure, grooves; it grows as blocks shrink.
    pub peak_pressure_mpa: f64,
    /// Largest local pressure, squares.
    pub peak_pressure_square_mpa: f64,
    /// Contact blocks under tension.
    pub tension_blocks: usize,
    /// A cavity's ceiling reaches the counterface.
    pub cavity_closed: bool,
    /// A pressure lies past the last of the area law.
    pub area_law_extrapolated: bool,
    /// How the solve of grooves ended.
    pub status: Cow<'static, str>,
    /// How the solve of squares ended.
    pub status_square: Cow<'static, str>,
}

/// A flat measurement and the patterned one at the same condition.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// On the flat sample.
    pub flat: Measurement,
    /// On the patterned sample.
    pub patterned: Measurement,
}

/// The conditions that both tables have, in the order of the flat one.
pub fn pairs(calibration: &Calibration) -> Vec<Pair> {
    let pair = |flat: &Measurement| {
        let patterned = calibration
            .patterned
            .iter()
            .find(|patterned| same(flat.force_n, patterned.force_n) && same_condition(flat, patterned))?;
        Some(Pair { flat: *flat, patterned: *patterned })
    };
    calibration.flat.iter().filter_map(pair).collect()
}

/// Whether two measurements were made at the same speed and humidity.
pub fn same_condition(a: &Measurement, b: &Measurement) -> bool {
    same(a.speed_m_s, b.speed_m_s) && same(a.humidity, b.humidity)
}

fn same(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-6 * a.abs().max(b.abs())
}

impl MeasuredReport {
    /// What was measured at `pair`.
    pub fn new(pair: &Pair, calibration: &Calibration) -> Self {
        let Pair { flat, patterned } = pair;
        let ratio = patterned.mu_dynamic / flat.mu_dynamic;
        // (s_r / r)^2 = (s_p / mu_p)^2 + (s_f / mu_f)^2
        let relative = (patterned.mu_dynamic_std / patterned.mu_dynamic).hypot(flat.mu_dynamic_std / flat.mu_dynamic);
        Self {
            force_n: flat.force_n,
            pressure_mpa: PRESSURE_MPA.from_si(calibration.pressure_pa(flat.force_n)),
            speed_mm_s: SPEED_MM_S.from_si(flat.speed_m_s),
            humidity_pct: HUMIDITY_PCT.from_si(flat.humidity),
            mu_flat: flat.mu_dynamic,
            mu_flat_std: flat.mu_dynamic_std,
            mu_patterned: patterned.mu_dynamic,
            mu_patterned_std: patterned.mu_dynamic_std,
            ratio,
            ratio_std: ratio * relative,
        }
    }

    /// Whether both were measured at the same speed and humidity.
    pub fn is_at_condition_of(&self, other: &Self) -> bool {
        self.speed_mm_s == other.speed_mm_s && self.humidity_pct == other.humidity_pct
    }
}

impl RatioReport {
    /// The model at `slope_factor`.
    pub fn at_slope(&self, slope_factor: f64) -> Option<&ModelledRatio> {
        self.modelled.iter().find(|modelled| modelled.slope_factor == slope_factor)
    }
}

impl ModelledRatio {
    /// What `prediction` says of `pattern` on the surface of `law`.
    pub fn new(law: &ScaledLaw, pattern: &Pattern, prediction: &Prediction) -> Self {
        let (surface, square) = (&prediction.outcome.surface, &prediction.squares.surface);
        let std = |planform: usize, of: fn(&Deviations) -> &Deviation| {
            prediction.errors[planform].as_ref().map(|known| tidy(of(known).std))
        };
        Self {
            slope_factor: law.slope_factor,
            rms_slope: law.rms_slope,
            area_law_factor: tidy(prediction.area_law_factor),
            dynamic_mean: tidy(prediction.dynamic_mean),
            ratio_groove: prediction.outcome.ratio,
            ratio_groove_std: std(0, |of| &of.ratio),
            mu_groove_std: std(0, |of| &of.mu),
            ratio_square: prediction.squares.ratio,
            ratio_square_std: std(1, |of| &of.ratio),
            mu_square_std: std(1, |of| &of.mu),
            ratio_square_estimate: prediction.outcome.ratio.map(|ratio| as_squares(pattern, ratio)),
            ratio_groove_thick_difference: prediction.thick[0],
            ratio_square_thick_difference: prediction.thick[1],
            peak_pressure_mpa: PRESSURE_MPA.from_si(surface.peak_pressure_pa),
            peak_pressure_square_mpa: PRESSURE_MPA.from_si(square.peak_pressure_pa),
            tension_blocks: surface.tension_blocks + square.tension_blocks,
            cavity_closed: surface.cavity_closed || square.cavity_closed,
            area_law_extrapolated: surface.area_law_extrapolated || square.area_law_extrapolated,
            status: surface.status.name().into(),
            status_square: square.status.name().into(),
        }
    }

    /// Whether both solves converged.
    pub fn has_converged(&self) -> bool {
        [&self.status, &self.status_square].into_iter().all(|status| status == Status::Converged.name())
    }
}

/// The strip estimate of square cavities of `pattern`'s lengths whose section has `ratio_groove`.
fn as_squares(pattern: &Pattern, ratio_groove: f64) -> f64 {
    squares(pattern).strip_estimate(ratio_groove)
}

/// The pattern's depth in the file's unit.
pub fn depth_um(pattern: &Pattern) -> f64 {
    LENGTH_UM.from_si(pattern.depth_m())
}
