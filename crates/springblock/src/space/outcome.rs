//! What steady sliding of the cell in space found.

use crate::outcome::{InterfacePoint, Status, SurfaceOutcome};

/// One contact block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpacePoint {
    /// Centre along x, from the cell's corner, in metres.
    pub x_m: f64,
    /// Centre along y, in metres.
    pub y_m: f64,
    /// Share of the block's area that touches the counterface.
    pub area_share: f64,
    /// Normal pressure on that area, positive in compression, in pascals.
    pub pressure_pa: f64,
    /// Friction traction on it, positive against the drive, in pascals.
    pub friction_pa: f64,
}

/// Steady sliding under one load.
#[derive(Clone, Debug, PartialEq)]
pub struct SpaceOutcome {
    /// How the solve ended.
    pub status: Status,
    /// Friction along the drive over normal force, compressive blocks only; absent where there is no load.
    pub mu_dynamic: Option<f64>,
    /// Largest pressure on a contact block, in pascals. It grows as blocks shrink.
    pub peak_pressure_pa: f64,
    /// Contact blocks under tension.
    pub tension_blocks: usize,
    /// The ceiling of a cavity sags to the counterface.
    pub cavity_closed: bool,
    /// Least height of a cavity's ceiling above the counterface under load, in metres, negative beyond it; absent of flat
    /// surfaces.
    pub clearance_m: Option<f64>,
    /// A contact pressure lies past the last pressure of the area law.
    pub area_law_extrapolated: bool,
    /// Sum of the forces out of balance over the load.
    pub residual: f64,
    /// Responses of the flat layer that were computed.
    pub iterations: usize,
    /// The contact blocks, x fastest.
    pub interface: Vec<SpacePoint>,
}

impl SpaceOutcome {
    /// What is said without a load or without contact.
    pub(super) fn unloaded(interface: Vec<SpacePoint>) -> Self {
        Self {
            status: Status::NoLoad,
            mu_dynamic: None,
            peak_pressure_pa: 0.0,
            tension_blocks: 0,
            cavity_closed: false,
            clearance_m: None,
            area_law_extrapolated: false,
            residual: 0.0,
            iterations: 0,
            interface,
        }
    }
}

impl From<SpaceOutcome> for SurfaceOutcome {
    fn from(outcome: SpaceOutcome) -> Self {
        Self {
            mu_dynamic: outcome.mu_dynamic,
            peak_pressure_pa: outcome.peak_pressure_pa,
            tension_blocks: outcome.tension_blocks,
            cavity_closed: outcome.cavity_closed,
            clearance_m: outcome.clearance_m,
            area_law_extrapolated: outcome.area_law_extrapolated,
            residual: Some(outcome.residual).filter(|_| outcome.status != Status::NoLoad),
            iterations: outcome.iterations,
            interface: outcome
                .interface
                .iter()
                .map(|point| InterfacePoint {
                    x_m: point.x_m,
                    y_m: point.y_m,
                    pressure_pa: point.pressure_pa,
                    friction_pa: point.friction_pa,
                })
                .collect(),
            ..Self::unsolved(outcome.status, std::iter::empty())
        }
    }
}
