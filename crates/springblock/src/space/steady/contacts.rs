//! Which contacts of a face with heights are on, off, or yield.

use super::*;

/// Rounds of switching contacts on a face with heights after which it gives up.
const MAX_RAISED_ROUNDS: usize = 200;
/// Forces out of balance, as in [`TOLERANCE`], with which contacts are told on and off there.
const ROUGH_TOLERANCE: f64 = 1e-4;

impl Solver<'_> {
    /// Whether each contact yields.
    pub(super) fn yielding(&self) -> Vec<bool> {
        self.interface.yielding(&self.state.unknowns, self.face).map(|height| height.is_some()).collect()
    }

    /// Whether each contact is off the counterface.
    pub(super) fn lifted(&self) -> Vec<bool> {
        self.interface.lifted(&self.state.unknowns).map(|height| height.is_some()).collect()
    }

    /// The equilibrium under `load` on a face with heights, from the contacts on and off of the load before. Which contacts
    /// these are is found with forces that are nearly balanced; the last iterations balance them wholly.
    pub(super) fn equilibrate_raised(&mut self, load: &SpaceLoad) -> End {
        let area = self.interface.column_area();
        self.face = Face {
            raise: 1.0 / self.model.displacement_unit(load.pressure_pa),
            limit: self.model.yield_pressure_pa.map_or(f64::INFINITY, |yield_pa| yield_pa / load.pressure_pa * area),
        };
        if self.yielding().contains(&true) {
            // What has yielded is as high as it was pressed, and elastic from there on.
            let lifted = self.lifted();
            self.switch(&lifted, &vec![false; lifted.len()]);
        } else {
            self.observe();
        }
        let mut directions = 0;
        self.tolerance = self.model.tolerance.max(ROUGH_TOLERANCE);
        for _ in 0..MAX_RAISED_ROUNDS {
            let mut end = self.iterate(load);
            directions += end.directions;
            end.directions = directions;
            if end.status == Status::Cancelled {
                return end;
            }
            let (lifted, yields) = self.next_contacts();
            let is_settled = lifted == self.lifted() && yields == self.yielding();
            if is_settled && self.tolerance == self.model.tolerance {
                // What is no solution leaves the face as it was.
                if end.status == Status::Converged {
                    self.interface.to_mut().flatten(&self.state.unknowns, self.face);
                }
                return end;
            }
            if is_settled {
                self.tolerance = self.model.tolerance;
                continue;
            }
            if end.status != Status::Converged || lifted.iter().all(|lifted| *lifted) {
                return End { status: Status::NotConverged, ..end };
            }
            self.switch(&lifted, &yields);
        }
        let (_, residual) = self.residual(load);
        End { status: Status::NotConverged, residual, directions }
    }

    /// The contacts that are off the counterface next, and those that yield.
    pub(super) fn next_contacts(&self) -> (Vec<bool>, Vec<bool>) {
        let contacts = self.interface.surface().iter().filter(|surface| surface.contact.is_some());
        let unknowns = &self.state.unknowns;
        let heights = self.interface.lifted(unknowns).zip(self.interface.yielding(unknowns, self.face));
        contacts
            .zip(heights.zip(&self.state.normal))
            .map(|(surface, ((off, yielding), normal))| {
                let face = self.face.raise * surface.relief;
                let limit = self.face.limit * surface.contact_share;
                match (off, yielding) {
                    (Some(height), _) => (height >= face, false),
                    (None, Some(height)) => (false, height <= face),
                    (None, None) => (*normal < 0.0, *normal > limit),
                }
            })
            .unzip()
    }

    /// Goes on with the contacts off the counterface of which `lifted` says so, and those that `yields` names flattened.
    pub(super) fn switch(&mut self, lifted: &[bool], yields: &[bool]) {
        let mut interface = self.model.interface.with_contacts(lifted, yields);
        interface.take_heights(&self.interface);
        let unknowns = interface.continued(&self.interface, &self.state.unknowns, self.face.raise);
        let elastic = interface.elastic_unknowns();
        self.response = interface.response();
        self.state = State { unknowns, elastic: vec![0.0; elastic], normal: vec![0.0; interface.contacts()] };
        self.interface = Cow::Owned(interface);
        self.slope.clear();
        self.directions.clear();
        self.observe();
    }
}
