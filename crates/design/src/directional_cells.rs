//! Steady cells of one texture in every sliding direction.

use crate::optimize::ModelFailure;
use slipgrid_base::monitor::Monitor;
use slipgrid_model::pattern::{Pattern, Texture};
use slipgrid_model::springblock::{CellOutcome, Dimension, Load, Scene, Status, SteadyCell};

use crate::operating_conditions::turned;

/// Cells in space are solved in a search until the residual force over the load is this small; the design found is
/// solved again to 1e-10.
const SEARCH_BALANCE: f64 = 1e-7;

/// Solver of steady cells at the loads of each sliding direction.
pub struct Solver {
    /// Sliding direction in degrees, `None` for the designs' own, and solver of its cells.
    pub each: Vec<(Option<f64>, SteadyCell)>,
    /// Dimension of the cells, equal in every direction.
    pub dimension: Dimension,
}

impl Solver {
    /// Creates a solver for the loads of `scene`: first those of the designs' own direction, then equally many for each
    /// of `directions_deg`.
    pub fn new(scene: &Scene, texture: &Texture, directions_deg: &[f64]) -> Self {
        let each = std::iter::once(None).chain(directions_deg.iter().map(|&angle_deg| Some(angle_deg)));
        let own = scene.loads.len() / (1 + directions_deg.len());
        let cell = |(angle_deg, loads): (Option<f64>, &[Load])| {
            let cell = SteadyCell::of_texture(&Scene { loads: loads.to_vec(), ..scene.clone() }, texture);
            (angle_deg, cell.balanced_to(SEARCH_BALANCE))
        };
        let dimension = Dimension::of(scene.run.dimensions, texture);
        Self { each: each.zip(scene.loads.chunks(own)).map(cell).collect(), dimension }
    }

    /// Solves the cells of `design` in every direction: one outcome per load, or [`ModelFailure`] if a cell exceeds the
    /// memory limit or `monitor` cancels.
    pub fn solve(&self, design: &Pattern, monitor: &dyn Monitor) -> Result<Vec<CellOutcome>, ModelFailure> {
        let mut outcomes = Vec::new();
        for (angle_deg, cell) in &self.each {
            let turned = turned(design, *angle_deg);
            let (bytes, most_bytes) = (cell.bytes(&turned), cell.most_bytes());
            if bytes > most_bytes {
                let reason = format!("its cell takes {bytes:.1e} bytes, more than {most_bytes:.1e}");
                return Err(ModelFailure::Trial(reason));
            }
            let mut found = cell.solve_heeding(&turned, monitor);
            if found.iter().any(|outcome| outcome.surface.status == Status::Cancelled) {
                return Err(ModelFailure::Cancelled);
            }
            outcomes.append(&mut found);
        }
        Ok(outcomes)
    }
}
