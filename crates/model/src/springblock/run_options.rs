//! Options of a run: method, extent, time, and the spring law.

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};
use slipgrid_base::units::{InFiles, LengthUm, StepNs};

use crate::pattern::Texture;
use crate::springblock::Dimension;

/// Physical model and time integration scheme.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Fidelity {
    /// Equilibrium with every contact block sliding, without time.
    Steady,
    /// Time integration by the fastest scheme with a measured error.
    Dynamic,
    /// Scheme of Balestra et al., J. Tribol. 144, 031704: classical Runge-Kutta of order 4, steps of 1 ns, exact spring
    /// law.
    Reference,
}

slipgrid_base::names!(Fidelity { Steady = "steady", Dynamic = "dynamic", Reference = "reference" });

/// Part of the specimen that is modelled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Extent {
    /// One period of the pattern with periodic sides.
    Cell,
    /// The whole specimen with free sides, in the vertical plane.
    Sample,
    /// A strip of the specimen in space with two ends, one period wide with periodic sides; in the plane the same as a
    /// sample.
    Strip,
}

slipgrid_base::names!(Extent { Cell = "cell", Sample = "sample", Strip = "strip" });

impl Extent {
    /// Whether the model has ends.
    pub const fn has_ends(self) -> bool {
        !matches!(self, Self::Cell)
    }
}

/// Force law of a spring.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Springs {
    /// For small displacements u: F = k e (e . (u_j - u_i)), with the unit vector e along the spring at rest.
    Linear,
    /// Geometrically exact: F = k (r - l) (r_j - r_i) / r, with the length r of the spring and its length l at rest.
    Exact,
}

slipgrid_base::names!(Springs { Linear = "linear", Exact = "exact" });

/// Options that control how a scene is solved.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RunOptions {
    /// Method of solution: `steady`, `dynamic` or `reference`; `steady` when absent.
    pub fidelity: Fidelity,
    /// `cell`, one period; `sample`, the whole specimen; or `strip`, a strip of it in space, one period wide with periodic sides and with two
    /// ends; `cell` when absent. On a `[specimen]` that is solved in space, a sample is one cell, and a strip the row of cavities through
    /// its middle.
    pub extent: Extent,
    /// Seed of the local coefficients; 1 when absent.
    pub seed: u64,
    // In metres. A run whose mu is not stationary after this travel continues up to four times as far, or twenty times
    // if `mu_stderr` is set.
    /// Planned travel of the bulk in dynamic runs; 2 when absent.
    #[serde(rename = "sliding_um", with = "LengthUm")]
    #[schemars(with = "f64")]
    pub sliding_m: f64,
    /// A block under tension leaves the counterface instead of being pinned; false when absent.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub liftoff: bool,
    /// Relative standard error of mu at which a dynamic run may end; without it no such error is sought.
    pub mu_stderr: Option<f64>,
    // In seconds.
    /// Time step; without it 0.34 sqrt(m/k) for `dynamic`, which is 6 ns for the published polymer in blocks of 10 um, and 1 ns for
    /// `reference`.
    #[serde(rename = "step_ns", with = "StepNs")]
    #[schemars(with = "Option<f64>")]
    pub step_s: Option<f64>,
    /// Damping frequency over sqrt(k/m); 0.01 when absent.
    #[serde(skip_serializing_if = "is_usual_damping")]
    pub damping: f64,
    // Blocks start at rest, each at a random phase of its stick-slip cycle; if they started in steady sliding,
    // stick-slip would set in only after micrometres.
    /// Start dynamic runs from the sheared steady equilibrium; false when absent.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub warm_start: bool,
    /// `linear` springs, for small displacements, or `exact` springs; without it the fidelity decides.
    pub springs: Option<Springs>,
    /// 2 solves in the vertical plane, 3 in space; the planform decides when absent, and a strip is solved in space.
    #[schemars(with = "Option<u64>")]
    #[serde(deserialize_with = "read_dimensions")]
    pub dimensions: Option<u8>,
    // With the seeds `seed`, `seed` + 1 and so on. Their mean is reported, with a standard error from their scatter.
    /// Surfaces with independent coefficients in dynamic runs, 1 to 64; 1 when absent.
    #[serde(skip_serializing_if = "is_one")]
    pub draws: u64,
    // If the correction is impossible, the statements of the simulation give the reason.
    /// Extrapolate ratios to vanishing block size from steady cells in smaller blocks; false when absent. Applies where
    /// the changes converge: in the vertical plane, and in space without rims, through smaller cells and the changes
    /// found in similar grooves, if such cells are affordable and cavities are at least two of their blocks deep.
    /// Otherwise ratios remain those of the blocks of `[sample]`, and the result's model states the reason.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub refine: bool,
}

/// Reads a number of dimensions. Numbers above 255 become 255; validation of the scene refuses all but 2 and 3.
///
/// # Errors
/// Errors of `deserializer`.
pub fn read_dimensions<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<u8>, D::Error> {
    u64::deserialize(deserializer).map(|number| Some(u8::try_from(number).unwrap_or(u8::MAX)))
}

/// Default damping frequency over sqrt(k/m), with the spring stiffness k and the block mass m.
const USUAL_DAMPING: f64 = 0.01;

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks by reference")]
fn is_usual_damping(damping: &f64) -> bool {
    *damping == USUAL_DAMPING
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks by reference")]
const fn is_one(count: &u64) -> bool {
    *count == 1
}

/// Relative standard error of dynamic friction at which a run of [`RunOptions::from_sliding`] ends.
const MEAN_STDERR: f64 = 0.001;

impl RunOptions {
    /// Options of a dynamic run for mean friction only, which starts near sliding and ends when the relative standard
    /// error of the mean is 0.001.
    #[must_use]
    pub const fn from_sliding(self) -> Self {
        Self { fidelity: Fidelity::Dynamic, warm_start: true, mu_stderr: Some(MEAN_STDERR), ..self }
    }

    /// Options for a specimen with patterns of `texture`. In the plane the dimension is fixed, so that the specimen is
    /// solved strip by strip for other sliding directions of the texture as well. In space a whole sample becomes one
    /// cell; a requested strip remains.
    #[must_use]
    pub fn on_specimen(self, texture: &Texture) -> Self {
        match Dimension::of(self.dimensions, texture) {
            Dimension::Plane => Self { dimensions: Some(Dimension::Plane.number()), ..self },
            Dimension::Space if self.has_space() && self.extent == Extent::Sample => {
                Self { extent: Extent::Cell, ..self }
            }
            Dimension::Space => self,
        }
    }

    /// Whether cells and strips in space support these options.
    pub(crate) fn has_space(&self) -> bool {
        match self.fidelity {
            Fidelity::Steady => true,
            Fidelity::Dynamic => self.springs != Some(Springs::Exact),
            Fidelity::Reference => false,
        }
    }
}

impl Default for RunOptions {
    fn default() -> Self {
        Self {
            fidelity: Fidelity::Steady,
            extent: Extent::Cell,
            seed: 1,
            sliding_m: 2e-6,
            liftoff: false,
            mu_stderr: None,
            step_s: None,
            damping: USUAL_DAMPING,
            warm_start: false,
            springs: None,
            dimensions: None,
            draws: 1,
            refine: false,
        }
    }
}
