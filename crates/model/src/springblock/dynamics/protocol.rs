//! Load and motion of the bulk: the pressure ramps up from zero, rests, then the bulk moves.

use super::scales::Scales;
use crate::springblock::Scene;

/// Duration of the pressure ramp, in seconds (paper: 2 us).
pub const RAMP_S: f64 = 2e-6;
/// Duration of the rest at full pressure before the bulk moves, in seconds (paper: 10 us).
pub const REST_S: f64 = 10e-6;

/// Load and bulk position as functions of time. Units: lattice spacing l, spring stiffness k, block mass m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Protocol {
    /// Duration of the pressure ramp, in units of sqrt(m/k).
    pub ramp: f64,
    /// Time at which the bulk starts to move, in units of sqrt(m/k).
    pub start: f64,
    /// Full load on the bulk, in units of k l.
    pub load: f64,
    /// Speed of the bulk, in units of l sqrt(k/m).
    pub speed: f64,
}

impl Protocol {
    /// Creates the protocol of `scene` for the full load `load`, in units of k l (spring stiffness times lattice
    /// spacing). A warm start skips the ramp and the rest.
    pub fn new(scene: &Scene, scales: &Scales, load: f64) -> Self {
        let (ramp, start) =
            if scene.run.warm_start { (0.0, 0.0) } else { (RAMP_S / scales.time_s, (RAMP_S + REST_S) / scales.time_s) };
        Self { ramp, start, load, speed: scene.speed_m_s * scales.time_s / scales.length_m }
    }

    /// Load on the bulk at the time `time`; see [`Protocol`] for units.
    pub fn load(&self, time: f64) -> f64 {
        if time >= self.ramp { self.load } else { self.load * (time / self.ramp).max(0.0) }
    }

    /// Horizontal displacement of the bulk at the time `time`, in lattice spacings.
    pub fn bulk_x(&self, time: f64) -> f64 {
        self.speed * (time - self.start).max(0.0)
    }
}
