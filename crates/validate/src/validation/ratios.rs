//! Measured and modelled ratios.

use serde::Serialize;
use slipgrid_infer::calibrate::uncertainty::{Deviation, Deviations};
use slipgrid_model::pattern::Pattern;
use slipgrid_model::springblock::Status;

use super::laws::ScaledLaw;
use super::model::{ModelledRatios, squares};
use slipgrid_base::units::{HUMIDITY_PCT, PRESSURE_MPA, SPEED_MM_S, tidy};
use slipgrid_infer::calibrate::Measurement;
use slipgrid_io::formats::calibration::Calibration;

/// Measurements on the flat and on the patterned sample at one condition.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MeasuredReport {
    /// Normal force on one specimen.
    pub force_n: f64,
    /// Nominal pressure: normal force over the area of a specimen.
    pub pressure_mpa: f64,
    /// Sliding speed.
    pub speed_mm_s: f64,
    /// Relative humidity.
    pub humidity_pct: f64,
    /// Friction of the flat sample.
    pub mu_flat: f64,
    /// Standard deviation of `mu_flat`.
    pub mu_flat_std: f64,
    /// Friction of the patterned sample.
    pub mu_patterned: f64,
    /// Standard deviation of `mu_patterned`.
    pub mu_patterned_std: f64,
    /// Ratio of patterned to flat friction.
    pub ratio: f64,
    /// Standard deviation of the ratio.
    pub ratio_std: f64,
}

/// Measured ratio at one condition, with the modelled ratios.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RatioReport {
    /// Measured friction of both samples.
    #[serde(flatten)]
    pub measured: MeasuredReport,
    /// Modelled ratio with grooves, without an area law; null if the solution did not converge.
    pub ratio_amontons_coulomb: Option<f64>,
    /// Modelled ratios, one per slope factor.
    pub modelled: Vec<ModelledRatio>,
    /// Modelled ratios with measured flat friction as the local law, one per extrapolation; empty if flat friction was
    /// measured at one pressure only.
    pub measured_law: Vec<MeasuredLawRatio>,
    /// Modelled ratios at the measured depth, for the surface as given; null if the modelled depth is the measured
    /// depth.
    pub modelled_at_measured_depth: Option<ModelledRatio>,
}

/// Modelled ratios at one condition, if friction depends on local pressure as measured flat friction depends on nominal
/// pressure.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MeasuredLawRatio {
    /// Extrapolation of the law above the last measured pressure: `constant` or `logarithmic`.
    pub extrapolation: &'static str,
    /// Friction of the patterned over the flat surface, with grooves as cavities; null if the solution did not
    /// converge.
    pub ratio_groove: Option<f64>,
    /// Friction of the patterned over the flat surface, with square cavities of equal lengths, in three dimensions;
    /// null if the solution did not converge.
    pub ratio_square: Option<f64>,
}

/// Modelled ratios at one condition, for one factor on the slopes of the surface.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ModelledRatio {
    /// Factor on the slopes of the surface.
    pub slope_factor: f64,
    /// Rms slope; null without a surface.
    pub rms_slope: Option<f64>,
    /// Area factor f at the nominal pressure.
    pub area_law_factor: f64,
    /// Local dynamic coefficient: measured flat friction over the area factor f.
    pub dynamic_mean: f64,
    /// Friction of the patterned over the flat surface, with grooves as cavities; null if the solution did not
    /// converge.
    pub ratio_groove: Option<f64>,
    /// Standard deviation of `ratio_groove`; null if unknown.
    pub ratio_groove_std: Option<f64>,
    /// Standard deviation of the friction coefficient with grooves, which is the ratio times measured flat friction.
    pub mu_groove_std: Option<f64>,
    /// Friction of the patterned over the flat surface, with square cavities of equal lengths, in three dimensions;
    /// null if the solution did not converge.
    pub ratio_square: Option<f64>,
    /// Standard deviation of `ratio_square`; null if unknown.
    pub ratio_square_std: Option<f64>,
    /// Standard deviation of the friction coefficient with squares, which is the ratio times measured flat friction.
    pub mu_square_std: Option<f64>,
    /// Estimate of the ratio with squares from `ratio_groove`, with the strips between rows of cavities counted as
    /// flat; null without `ratio_groove`.
    pub ratio_square_estimate: Option<f64>,
    /// Change of `ratio_groove` if the source's whole specimen, 7 mm thick, is modelled instead of a layer; null if the
    /// whole specimen is modelled already.
    pub ratio_groove_thick_difference: Option<f64>,
    /// Change of `ratio_square` if the source's whole specimen, 7 mm thick, is modelled instead of a layer; null if the
    /// whole specimen is modelled already.
    pub ratio_square_thick_difference: Option<f64>,
    /// Maximum local pressure with grooves; it increases as blocks shrink.
    pub peak_pressure_mpa: f64,
    /// Maximum local pressure with squares; it increases as blocks shrink.
    pub peak_pressure_square_mpa: f64,
    /// Number of contact blocks under tension, grooves and squares together.
    pub tension_blocks: usize,
    /// Whether the ceiling of a cavity reaches the counterface, for grooves or squares.
    pub cavity_closed: bool,
    /// Whether a pressure exceeds the range of the area law, for grooves or squares.
    pub area_law_extrapolated: bool,
    /// Status of the solution for grooves.
    pub status: &'static str,
    /// Status of the solution for squares.
    pub status_square: &'static str,
}

/// Flat and patterned measurement at equal force, speed and humidity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// Nominal pressure, in pascals.
    pub pressure_pa: f64,
    /// Measurement on the flat sample.
    pub flat: Measurement,
    /// Measurement on the patterned sample.
    pub patterned: Measurement,
}

/// Pairs of measurements at conditions that both the flat and the patterned table contain, in the order of the flat
/// table.
pub fn pairs(calibration: &Calibration) -> Vec<Pair> {
    let pair = |flat: &Measurement| {
        let patterned = calibration.patterned.iter().find(|patterned| flat.is_at(patterned))?;
        Some(Pair { pressure_pa: calibration.pressure_pa(flat.force_n), flat: *flat, patterned: *patterned })
    };
    calibration.stated.flat.iter().filter_map(pair).collect()
}

impl MeasuredReport {
    /// Makes the record of the measurements of `pair`.
    pub fn new(pair: &Pair) -> Self {
        let Pair { pressure_pa, flat, patterned } = pair;
        let ratio = patterned.mu_dynamic / flat.mu_dynamic;
        // (s_r / r)^2 = (s_p / mu_p)^2 + (s_f / mu_f)^2
        let relative = (patterned.mu_dynamic_std / patterned.mu_dynamic).hypot(flat.mu_dynamic_std / flat.mu_dynamic);
        Self {
            force_n: flat.force_n,
            pressure_mpa: PRESSURE_MPA.from_si(*pressure_pa),
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

    /// Whether both records have equal speed and humidity.
    pub fn is_at_condition_of(&self, other: &Self) -> bool {
        self.speed_mm_s == other.speed_mm_s && self.humidity_pct == other.humidity_pct
    }
}

impl RatioReport {
    /// Modelled ratios at `slope_factor`; `None` if this factor was not modelled.
    pub fn at_slope(&self, slope_factor: f64) -> Option<&ModelledRatio> {
        self.modelled.iter().find(|modelled| modelled.slope_factor == slope_factor)
    }

    /// Modelled ratios for the surface as given, with slope factor 1.
    pub fn given(&self) -> Option<&ModelledRatio> {
        self.at_slope(1.0)
    }

    /// Modelled ratio with grooves for the surface as given; `None` if the solution did not converge.
    pub fn groove(&self) -> Option<f64> {
        self.given()?.ratio_groove
    }
}

impl ModelledRatio {
    /// Makes the record of `prediction` for `pattern` with the area law `law`.
    pub fn new(law: &ScaledLaw, pattern: &Pattern, prediction: &ModelledRatios) -> Self {
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
            ratio_square_estimate: prediction.outcome.ratio.map(|ratio| squares(pattern).strip_estimate(ratio)),
            ratio_groove_thick_difference: prediction.thick[0],
            ratio_square_thick_difference: prediction.thick[1],
            peak_pressure_mpa: PRESSURE_MPA.from_si(surface.peak_pressure_pa),
            peak_pressure_square_mpa: PRESSURE_MPA.from_si(square.peak_pressure_pa),
            tension_blocks: surface.tension_blocks + square.tension_blocks,
            cavity_closed: surface.cavity_closed || square.cavity_closed,
            area_law_extrapolated: surface.area_law_extrapolated || square.area_law_extrapolated,
            status: surface.status.name(),
            status_square: square.status.name(),
        }
    }

    /// Whether both solutions converged.
    pub fn has_converged(&self) -> bool {
        [self.status, self.status_square].into_iter().all(|status| status == Status::Converged.name())
    }
}
