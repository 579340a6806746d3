//! Contact states of a face with height variations: touching, lifted or yielding.

use super::*;

/// Maximum number of rounds of switching contacts on a face with height variations.
const MAX_RAISED_ROUNDS: usize = 200;
/// Tolerance while the contact states still change, unless the tolerance of the model is larger.
const ROUGH_TOLERANCE: f64 = 1e-4;

impl Solver<'_> {
    pub(super) fn yielding(&self) -> Vec<bool> {
        self.interface.yielding(&self.state.unknowns, self.face).map(|height| height.is_some()).collect()
    }

    pub(super) fn lifted(&self) -> Vec<bool> {
        self.interface.lifted(&self.state.unknowns).map(|height| height.is_some()).collect()
    }

    /// Solves for equilibrium under `load` on a face with height variations, starting from the contact states of the
    /// previous load. The contact states are found with nearly balanced forces; the last iterations balance the forces
    /// to the tolerance of the model.
    pub(super) fn equilibrate_raised(&mut self, load: &SpaceLoad) -> End {
        let area = self.interface.column_area();
        self.face = Face {
            raise: 1.0 / self.model.displacement_unit(load.pressure_pa),
            limit: self.model.yield_pressure_pa.map_or(f64::INFINITY, |yield_pa| yield_pa / load.pressure_pa * area),
        };
        if self.yielding().contains(&true) {
            // Yielded contacts keep the height to which they were pressed and are elastic again.
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
                // An unconverged state must not change the face.
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

    /// Next state of each contact, by contact index: whether the contact is lifted, and whether it yields.
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

    /// Switches to the contact states `lifted` and `yields`, given by contact, and keeps the values of unknowns that
    /// exist in both states.
    pub(super) fn switch(&mut self, lifted: &[bool], yields: &[bool]) {
        let mut interface = self.model.interface.with_contacts(lifted, yields);
        interface.copy_heights(&self.interface);
        let unknowns = interface.convert_unknowns(&self.interface, &self.state.unknowns, self.face.raise);
        let elastic = interface.elastic_unknowns();
        self.response = interface.response();
        self.state = State { unknowns, elastic: vec![0.0; elastic], normal: vec![0.0; interface.contacts()] };
        self.interface = Cow::Owned(interface);
        self.slope.clear();
        self.directions.clear();
        self.observe();
    }
}
