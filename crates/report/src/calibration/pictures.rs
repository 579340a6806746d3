//! Pictures of a calibration: flat friction and the area law.

use slipgrid_base::units::{HUMIDITY_PCT, PRESSURE_MPA, SPEED_MM_S, tidy};
use slipgrid_infer::calibrate::Measurement;

use super::Fitted;
use crate::ChartError;
use crate::area_law::picture_title;
use crate::charts::{self, AreaPoint, Estimate, FlatSeries};

/// Ratio of the highest drawn pressure of the area law to the highest measured nominal pressure.
const DRAWN: f64 = 6.0;

impl Fitted {
    /// Draws measured and fitted friction of flat samples, by speed and humidity; an empty title gives a narrow picture
    /// for a phone.
    ///
    /// # Errors
    /// [`ChartError`] if the picture cannot be drawn.
    pub(crate) fn flat_friction(&self, title: &str) -> Result<String, ChartError> {
        let label = |of: &Measurement| {
            let (speed, humidity) = (tidy(SPEED_MM_S.from_si(of.speed_m_s)), tidy(HUMIDITY_PCT.from_si(of.humidity)));
            format!("{speed} mm/s, {humidity} %")
        };
        let mut series: Vec<FlatSeries> = Vec::new();
        // Conditions in the order of measurement.
        for label in self.outcome.measurements.iter().map(label) {
            if !series.iter().any(|other| other.label == label) {
                series.push(FlatSeries { label, measured: Vec::new(), modelled: Vec::new() });
            }
        }
        let mut rows: Vec<_> = self.measured().map(|(of, modelled)| (self.pressure_mpa(of), of, modelled)).collect();
        // Stable sort: equal pressures keep their order.
        rows.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (pressure_mpa, of, modelled) in rows {
            let label = label(of);
            let Some(own) = series.iter_mut().find(|own| own.label == label) else { continue };
            own.measured.push((pressure_mpa, Estimate { value: of.mu_dynamic, error: Some(of.mu_dynamic_std) }));
            own.modelled.push((pressure_mpa, modelled.mu_dynamic.into()));
        }
        charts::flat_friction(title, &series)
    }

    /// Draws the area law and the contact area; `None` without an area law.
    pub(super) fn area_law(&self) -> Result<Option<String>, ChartError> {
        let surface = &self.outcome.surface;
        let Some(law) = surface.law.as_ref().filter(|_| !surface.curve.is_empty()) else { return Ok(None) };
        let highest_pa = self.outcome.measurements.iter().map(|of| self.task.pressure_pa(of)).fold(0.0, f64::max);
        let drawn = surface.curve.iter().filter(|point| point.pressure_pa < DRAWN * highest_pa).count() + 1;
        let curve = &surface.curve[..drawn.clamp(surface.curve.len().min(2), surface.curve.len())];
        // Standard error of the area factor f from the windows of the map, linear between the pressures of the law, zero
        // below.
        let std_at = |pressure_pa: f64| {
            let (all, own) = (law.factor_std()?, law.pressures_pa());
            let above = own.partition_point(|own| *own < pressure_pa * (1.0 - 1e-9)).min(own.len() - 1);
            let Some(below) = above.checked_sub(1) else {
                return Some(if (pressure_pa / own[0] - 1.0).abs() < 1e-9 { all[0] } else { 0.0 });
            };
            let share = ((pressure_pa - own[below]) / (own[above] - own[below])).clamp(0.0, 1.0);
            Some(all[below] + share * (all[above] - all[below]))
        };
        let points: Vec<AreaPoint> = curve
            .iter()
            .map(|point| AreaPoint {
                pressure_mpa: PRESSURE_MPA.from_si(point.pressure_pa),
                area_fraction: point.area_fraction_corrected,
                factor: law.factor(point.pressure_pa),
                factor_std: std_at(point.pressure_pa),
                windows: None,
            })
            .collect();
        let at_threshold =
            curve.iter().position(|point| (point.pressure_pa / law.pressures_pa()[0] - 1.0).abs() < 1e-9);
        let threshold = at_threshold.map(|row| [points[row].pressure_mpa, points[row].area_fraction]);
        charts::area_law(picture_title(surface.synthetic), &points, threshold, &[]).map(Some)
    }
}
