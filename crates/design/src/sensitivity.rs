//! How the target's quantity moves with the dimensions of the design: of a sample that has as many cavities as it.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};
use slipgrid_optimize::{ForwardModel, ModelFailure, Sensitivities, sensitivities};
use slipgrid_pattern::Pattern;

use crate::DesignError;
use crate::chance::block_std;
use crate::rim_sensitivity::{RimSensitivityReport, RimSlopeReport};
use slipgrid_results::Table;
use slipgrid_units::{LENGTH_UM, tidy};

/// Step of the differences, in blocks: within a block kinks of the lattice show, beyond one curvature does.
const STEP_BLOCKS: f64 = 0.5;

/// Slopes at the design, by pressure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SensitivityReport {
    /// What moves: `ratio` or `mu_dynamic`.
    pub quantity: Cow<'static, str>,
    /// Step of the central differences; null where designs beside it cannot be computed.
    pub step_um: Dimensions<Option<f64>>,
    /// One per target pressure.
    pub by_pressure: Vec<SlopesReport>,
    /// The errors of slopes have the size of blocks in them: in the vertical plane.
    #[serde(default)]
    pub errors_have_blocks: bool,
    /// Along the height of the rims; absent where nothing is known of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rim: Option<RimSensitivityReport>,
}

/// Slopes at one pressure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SlopesReport {
    /// Nominal pressure.
    pub pressure_mpa: f64,
    /// d(value)/d(length) per um.
    pub per_um: Dimensions<Option<f64>>,
    /// How far the slope at twice the step is from it and, in the vertical plane, half as far as that of vanishing blocks: both squared and added.
    pub error_per_um: Dimensions<Option<f64>>,
}

/// One thing for each dimension.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Dimensions<T> {
    /// Of the width.
    pub width: T,
    /// Of the spacing.
    pub spacing: T,
    /// Of the depth.
    pub depth: T,
}

impl<T: Copy> Dimensions<T> {
    /// From width, spacing, depth.
    pub const fn new([width, spacing, depth]: [T; 3]) -> Self {
        Self { width, spacing, depth }
    }

    /// Width, spacing, depth.
    pub const fn all(&self) -> [T; 3] {
        [self.width, self.spacing, self.depth]
    }
}

/// The slopes of `model` at `design`; `None` where it has no response there, or was asked to stop.
///
/// # Errors
/// [`DesignError::Failed`] for a model that is broken.
pub fn report(
    model: &dyn ForwardModel,
    design: &Pattern,
    block_m: f64,
    quantity: &'static str,
    pressures_mpa: &[f64],
) -> Result<Option<SensitivityReport>, DesignError> {
    let found = match sensitivities(model, design, STEP_BLOCKS * block_m) {
        Ok(found) => found,
        Err(ModelFailure::Trial { .. } | ModelFailure::Cancelled) => return Ok(None),
        Err(failure) => return Err(DesignError::Failed(failure.to_string())),
    };
    // A millionth of a metre: per metre times 1e-6.
    let per_um = |per_m: f64| tidy(per_m * 1e-6);
    let by_pressure = pressures_mpa
        .iter()
        .enumerate()
        .map(|(row, &pressure_mpa)| {
            let slopes = found.axes.each_ref().map(|axis| axis.as_ref().and_then(|axis| axis.slopes.get(row).copied()));
            SlopesReport {
                pressure_mpa,
                per_um: Dimensions::new(slopes.map(|slope| slope.map(|slope| per_um(slope.per_m)))),
                error_per_um: Dimensions::new(slopes.map(|slope| slope.map(|slope| per_um(slope.error_per_m)))),
            }
        })
        .collect();
    let step_um = found.axes.each_ref().map(|axis| axis.as_ref().map(|axis| LENGTH_UM.from_si(axis.step_m)));
    Ok(Some(SensitivityReport {
        quantity: quantity.into(),
        step_um: Dimensions::new(step_um),
        by_pressure,
        errors_have_blocks: false,
        rim: None,
    }))
}

impl SensitivityReport {
    /// Adds what the size of blocks leaves open to the errors of slopes ([`block_std`]): `own` has ratios in the blocks of these
    /// slopes, `fine` in blocks half as large; values are ratios times `scales`.
    ///
    /// # Errors
    /// [`ModelFailure`] where `own` or `fine` has no response at `design`.
    pub(crate) fn add_blocks(
        &mut self,
        [own, fine]: [&dyn ForwardModel; 2],
        design: &Pattern,
        block_m: f64,
        scales: &[f64],
    ) -> Result<(), ModelFailure> {
        let slopes = |model: &dyn ForwardModel| sensitivities(model, design, STEP_BLOCKS * block_m);
        let (own, fine) = (slopes(own)?, slopes(fine)?);
        let off = |axis: usize, row: usize| {
            let slope = |of: &Sensitivities| of.axes[axis].as_ref()?.slopes.get(row).map(|slope| slope.per_m);
            Some(block_std(slope(&own)? - slope(&fine)?) * scales[row] * 1e-6)
        };
        let with = |(row, slopes): (usize, &SlopesReport)| {
            let mut errors = slopes.error_per_um.all();
            for (axis, error) in errors.iter_mut().enumerate() {
                if let Some(error) = error {
                    *error = tidy(error.hypot(off(axis, row)?));
                }
            }
            Some(Dimensions::new(errors))
        };
        // Where smaller blocks lack a slope, errors stay those of the step.
        let all: Option<Vec<_>> = self.by_pressure.iter().enumerate().map(with).collect();
        if let Some(all) = all {
            self.by_pressure.iter_mut().zip(all).for_each(|(slopes, errors)| slopes.error_per_um = errors);
            self.errors_have_blocks = true;
        }
        Ok(())
    }

    /// What the errors of slopes have in them, in words.
    #[must_use]
    pub const fn errors_in_words(&self) -> &'static str {
        if self.errors_have_blocks {
            "by the step and the size of blocks"
        } else {
            "by the step alone, not the size of blocks"
        }
    }

    /// The slopes as a small table.
    #[must_use]
    pub fn text(&self) -> String {
        // A change of the ratio by a ten thousandth is the least that anybody cares for.
        let cell = |value: Option<f64>, error: Option<f64>| match (value, error) {
            (Some(value), Some(error)) => format!("{:.2} +- {:.2}", 1e4 * value, 1e4 * error),
            _ => "-".to_owned(),
        };
        let has_rim = self.rim_slopes().next().is_some();
        let mut table =
            Table::new(["P MPa", "width", "spacing", "depth"].into_iter().chain(has_rim.then_some("rim height")));
        for row in &self.by_pressure {
            let cells = row.per_um.all().into_iter().zip(row.error_per_um.all());
            let rim = self.rim_slopes().find(|slope| slope.pressure_mpa == row.pressure_mpa);
            let rim = rim.map(|slope| (Some(slope.per_um), slope.error_per_um));
            let cells = cells.chain(has_rim.then(|| rim.unwrap_or_default()));
            table.row(
                std::iter::once(row.pressure_mpa.to_string()).chain(cells.map(|(value, error)| cell(value, error))),
            );
        }
        let of_rims = self.rim.as_ref().map_or_else(String::new, |rim| format!("  {}\n", rim.words));
        format!(
            "  change of {} in 1e-4 where one dimension grows by 1 um (steady model; +- {})\n{table}{of_rims}",
            self.quantity,
            self.errors_in_words()
        )
    }

    /// Slopes along the height of the design's own rims.
    pub fn rim_slopes(&self) -> impl Iterator<Item = &RimSlopeReport> {
        self.rim.iter().filter(|rim| !rim.tried).flat_map(|rim| &rim.by_pressure)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_optimize::Response;
    use slipgrid_pattern::Planform;

    fn design() -> Pattern {
        Pattern::new(Planform::Groove, 130e-6, 370e-6, 20e-6).unwrap()
    }

    #[test]
    fn slopes_are_given_per_micrometre() {
        let model = |at: &Pattern| {
            let value = 0.9 - 1e2 * at.width_m() + 2e1 * at.spacing_m();
            Ok(Response { value: vec![value, 2.0 * value], limited: Vec::new() })
        };
        let found = report(&model, &design(), 10e-6, "ratio", &[0.65, 2.6]).unwrap().unwrap();
        assert_eq!(found.step_um, Dimensions { width: Some(5.0), spacing: Some(5.0), depth: Some(5.0) });
        let second = &found.by_pressure[1];
        let [width, spacing, depth] = second.per_um.all().map(Option::unwrap);
        assert!((width + 2e-4).abs() < 1e-12 && (spacing - 4e-5).abs() < 1e-12 && depth.abs() < 1e-12);
        let text = found.text();
        assert!(text.contains("-2.00 +- 0.00") && text.contains("0.40 +- 0.00"), "{text}");
        let none = |_: &Pattern| Err(ModelFailure::Trial { reason: "closes".to_owned() });
        assert_eq!(report(&none, &design(), 10e-6, "ratio", &[0.65]).unwrap(), None);
    }
    #[test]
    fn errors_of_slopes_cover_those_of_vanishing_blocks() {
        // A slope of blocks of l that is off by 30 sqrt(l): at half the blocks by 21.2.
        let of = |off: f64| {
            move |at: &Pattern| {
                let value = 0.9 - (1e2 + off) * at.width_m() + 2e1 * at.spacing_m();
                Ok(Response { value: vec![value], limited: Vec::new() })
            }
        };
        let (own, half) = (of(30.0), of(30.0 / 2.0_f64.sqrt()));
        let mut found = report(&own, &design(), 10e-6, "ratio", &[0.65]).unwrap().unwrap();
        assert!(found.text().contains("not the size of blocks"), "{}", found.text());
        found.add_blocks([&own, &half], &design(), 10e-6, &[2.0]).unwrap();
        let [width, spacing, depth] = found.by_pressure[0].error_per_um.all().map(Option::unwrap);
        assert!((width - 30e-6).abs() < 1e-9 && spacing < 1e-12 && depth < 1e-12, "{width} {spacing} {depth}");
        assert!(found.text().contains("by the step and the size of blocks"), "{}", found.text());
    }
}
