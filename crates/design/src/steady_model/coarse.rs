//! What may be asked in larger blocks, where space makes it worth while.

use slipgrid_springblock::SteadyCell;
use slipgrid_units::LENGTH_UM;

use super::*;

/// The model in larger blocks: the low-fidelity model of a search in space.
pub struct LowFidelity<'a> {
    pub(super) model: &'a SteadyModel<'a>,
    pub(super) scene: &'a Scene,
    pub(super) solver: &'a Solver,
}

impl ForwardModel for LowFidelity<'_> {
    fn respond(&self, design: &Pattern) -> Result<Response, ModelFailure> {
        self.model.ask(self.scene, self.solver, (design, design))
    }
}

/// What the model says of an endless pattern.
#[derive(Clone, Debug, PartialEq)]
pub struct Endless {
    /// Values at the loads of the condition designed for, as they are compared with the target but not corrected.
    pub values: Vec<f64>,
    /// The largest local pressure at any of them, in MPa.
    pub peak_mpa: f64,
    /// How far the ceilings come down at any load of any condition, in micrometres: where it is the depth, cavities close.
    pub sag_um: f64,
}

impl Endless {
    /// Whether a cavity of this depth closes under the load: then its values are no answer, as the model lets ceilings pass through the
    /// counterface.
    #[must_use]
    pub fn is_closed(&self, depth_um: f64) -> bool {
        self.sag_um >= depth_um
    }

    /// What it has more than `own`: differences, of the largest pressure the ratio.
    #[must_use]
    pub fn over(&self, own: &Self) -> Self {
        Self {
            values: self.values.iter().zip(&own.values).map(|(other, own)| other - own).collect(),
            peak_mpa: self.peak_mpa / own.peak_mpa,
            sag_um: self.sag_um - own.sag_um,
        }
    }
}

impl SteadyModel<'_> {
    /// What it says of an endless pattern, whether or not its cavities close; by the guide where `coarse` and there is one.
    ///
    /// # Errors
    /// [`ModelFailure`] where the design cannot be computed.
    pub fn endless(&self, design: &Pattern, coarse: bool) -> Result<Endless, ModelFailure> {
        let (scene, solver) = match self.guide.as_ref().filter(|_| coarse) {
            Some((scene, solver)) => (scene, solver),
            None => (&self.asked, &self.solver),
        };
        let mut answer = self.answer(scene, solver, design)?;
        if let Some(learned) = &self.learned {
            answer.modulus_sensitivity = learned.modulus_sensitivity(design)?;
        }
        let depth_um = LENGTH_UM.from_si(design.depth_m());
        let sag_um = answer.clearance_um.map_or(0.0, |clearance_um| depth_um - clearance_um);
        let factors = self.factors_of(design, &answer);
        let own = answer.ratio.iter().zip(&factors).take(self.scene.loads.len()).enumerate();
        let values = own.map(|(load, (ratio, factor))| ratio * self.scale(load) * factor).collect();
        Ok(Endless { values, peak_mpa: answer.peak_pressure_mpa, sag_um })
    }

    /// How far straight lines between the loads of the condition designed for are from the ratios of an endless pattern, at most: at
    /// `parts` - 1 pressures evenly between each two of them; in the guide's blocks where there are such and they serve. `None` with one
    /// load alone, and where there is no answer.
    #[must_use]
    pub fn off_between(&self, design: &Pattern, parts: usize) -> Option<f64> {
        let mut scene = self.scene(design);
        if let Some(guide) = self.serving_guide() {
            scene.layer = guide.layer;
        }
        let pressure_pa = |from: &Load, to: &Load, part: usize| {
            from.pressure_pa + (to.pressure_pa - from.pressure_pa) * part as f64 / parts as f64
        };
        // A ratio depends on local friction by a thousandth of itself at most.
        let inside = |pair: &[Load]| -> Vec<Load> {
            (0..parts).map(|part| Load { pressure_pa: pressure_pa(&pair[0], &pair[1], part), ..pair[0] }).collect()
        };
        let mut loads: Vec<Load> = scene.loads.windows(2).flat_map(inside).collect();
        loads.extend(
            scene
                .loads
                .last()
                .map(|last| Load { friction: loads.last().map_or(last.friction, |own| own.friction), ..*last }),
        );
        scene.loads = loads;
        scene.validate().ok()?;
        let ratios = SteadyCell::new(&scene)
            .solve_heeding(design, self.monitor)
            .into_iter()
            .map(|outcome| outcome.ratio.filter(|_| !outcome.surface.cavity_closed))
            .collect::<Option<Vec<f64>>>()?;
        let off = |(place, ratio): (usize, &f64)| {
            let (first, part) = (place / parts * parts, (place % parts) as f64 / parts as f64);
            let to = ratios.get(first + parts).unwrap_or(ratio);
            (ratio - ratios[first] - part * (to - ratios[first])).abs()
        };
        let worst = ratios.iter().enumerate().map(off).fold(0.0, f64::max);
        (self.scene.loads.len() > 1).then_some(worst)
    }
}
