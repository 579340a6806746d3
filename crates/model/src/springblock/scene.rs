//! Parameters of a simulation, with their validation.

use std::sync::Arc;

use crate::material::{AreaLaw, Elastic, LocalFriction};
use crate::pattern::{Pattern, ReliefMap};

use crate::springblock::{Dimension, Extent, RunOptions, SceneError, run_speed_m_s, warm_travel_m};

/// How a specimen is held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Holder {
    /// The holder prevents rotation, so that friction tilts the pressure.
    Rigid,
    /// The specimen aligns itself with the counterface, so that friction does not tilt the pressure.
    SelfAligning,
}

slipgrid_base::names!(Holder { Rigid = "rigid", SelfAligning = "self-aligning" });

/// Modelled layer of the specimen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layer {
    /// Length of the specimen along the sliding direction, in metres.
    pub length_m: f64,
    /// Height of the layer of blocks, in metres, in dynamic runs and in scenes that model the specimen's ends; steady
    /// cells use `thickness_m` if it is given.
    pub height_m: f64,
    /// Distance between neighbouring blocks, the lattice spacing l, in metres.
    pub block_m: f64,
    /// Thickness of the specimen between the counterface and the rigid bulk, in metres. Steady cells are solved over
    /// the whole thickness; for scenes with ends and for dynamic runs, the effect of the thickness on the ratio of the
    /// steady cell is added. `None` puts the rigid bulk directly above the layer.
    pub thickness_m: Option<f64>,
    /// How the specimen is held; `None` if unknown. The holder has no effect without the thickness.
    pub holder: Option<Holder>,
}

/// Nominal pressure and the local friction coefficients at this pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Load {
    /// Load over the specimen's nominal area, in pascals.
    pub pressure_pa: f64,
    /// Local friction coefficients at this pressure.
    pub friction: LocalFriction,
}

impl Load {
    /// Friction coefficient of an infinite flat layer in steady sliding: mu_d f(P), with the pressure P and the area
    /// factor f; f = 1 without an area law.
    pub fn flat_mu(&self, area_law: Option<&AreaLaw>) -> f64 {
        self.friction.dynamic_mean() * area_law.map_or(1.0, |law| law.factor(self.pressure_pa))
    }
}

/// All parameters of a simulation.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Elastic constants of the layer.
    pub elastic: Elastic,
    /// Area law; `None` is Amontons-Coulomb friction.
    pub area_law: Option<AreaLaw>,
    /// Texture; `None` is a flat surface.
    pub pattern: Option<Pattern>,
    /// Measured heights of the textured face over one period, used instead of rims.
    pub relief: Option<Arc<ReliefMap>>,
    /// The modelled layer.
    pub layer: Layer,
    /// Loads, solved independently.
    pub loads: Vec<Load>,
    /// Sliding speed of the bulk, in m/s.
    pub speed_m_s: f64,
    /// Options that control how the scene is solved.
    pub run: RunOptions,
}

impl Layer {
    /// Number of rows of blocks in the layer.
    pub fn rows(&self) -> usize {
        whole(self.height_m / self.block_m)
    }

    /// Number of rows of blocks over the whole thickness, at least [`Self::rows`].
    pub fn thick_rows(&self) -> usize {
        self.thickness_m.map_or(0, |thickness_m| whole(thickness_m / self.block_m)).max(self.rows())
    }

    /// Whether the specimen is thicker than the layer.
    pub fn is_backed(&self) -> bool {
        self.thick_rows() > self.rows()
    }

    /// Returns the layer with the rigid bulk directly above it.
    #[must_use]
    pub const fn alone(self) -> Self {
        Self { thickness_m: None, holder: None, ..self }
    }

    /// Number of blocks of the layer in a section along the sliding direction, not rounded.
    pub fn blocks(&self) -> f64 {
        (self.length_m / self.block_m) * (self.height_m / self.block_m)
    }

    /// Number of columns of blocks along the whole specimen.
    pub fn columns(&self) -> usize {
        whole(self.length_m / self.block_m)
    }
}

impl Scene {
    /// Returns the scene at the sliding speed of the dynamic run that stands for this scene. This speed is limited by
    /// the lightest load and may be lower than the scene's ([`run_speed_m_s`]).
    #[must_use]
    pub fn slowed(mut self) -> Self {
        let lightest_pa = self.loads.iter().map(|load| load.pressure_pa).fold(f64::INFINITY, f64::min);
        self.speed_m_s = run_speed_m_s(&self.elastic, lightest_pa, self.speed_m_s);
        self
    }

    /// Returns the scene of the dynamic run that stands for this scene: at the speed of [`Self::slowed`] and, for a
    /// warm start, with the travel that a run from the sheared layer needs.
    #[must_use]
    pub fn in_time(self) -> Self {
        let mut scene = self.slowed();
        if scene.run.warm_start {
            let law = (&scene.elastic, scene.area_law.as_ref());
            scene.run.sliding_m = warm_travel_m(law, &scene.layer, &scene.loads, scene.speed_m_s);
        }
        scene
    }
}

/// Rounds a positive ratio to a whole number.
fn whole(ratio: f64) -> usize {
    // Validated to lie in [1, 1e7]: the cast is exact.
    ratio.round() as usize
}

/// Maximum number of blocks of a layer, which keeps the memory of a whole lattice below 24 GiB.
pub const MAX_BLOCKS: f64 = 4e7;
/// Maximum number of rows of blocks over the thickness of a specimen: rounding errors of the total shear grow with the
/// square of this number.
pub const MAX_ROWS: f64 = 1e5;
/// Maximum number of draws of local coefficients for one scene: the standard error falls only with the square root of
/// this number.
pub const MAX_DRAWS: u64 = 64;
/// Minimum pitch in lattice spacings l: springs between columns closer than l/sqrt(3) would have negative stiffness.
const MIN_PITCH: f64 = 1.2;
/// Relative tolerance within which a length over the block size counts as a whole number of blocks.
const WHOLE_BLOCKS_TOLERANCE: f64 = 1e-6;

impl Scene {
    /// Dimension in which the scene is solved: the requested dimension, otherwise the dimension that the pattern needs
    /// if a cell or a strip in space can solve the scene. Other scenes, and flat layers, are solved in the vertical
    /// plane.
    pub fn dimension(&self) -> Dimension {
        let is_open = self.run.dimensions.is_none() && !self.has_spatial_cell();
        let pattern = self.pattern.as_ref().filter(|_| !is_open);
        pattern.map_or(Dimension::Plane, |pattern| Dimension::of(self.run.dimensions, pattern.texture()))
    }

    /// Pattern of the scene if only one section of the pattern is solved; `None` otherwise.
    pub fn section(&self) -> Option<&Pattern> {
        self.dimension().section_of(self.pattern.as_ref()?)
    }

    /// Whether a cell or a strip in space can solve the scene.
    fn has_spatial_cell(&self) -> bool {
        self.run.extent != Extent::Sample && self.run.has_space()
    }

    /// Whether the scene requests a strip in space of a pattern that slides neither along its rows nor across them.
    pub fn is_strip_aslant(&self) -> bool {
        let is_strip = self.run.extent == Extent::Strip && self.dimension() == Dimension::Space;
        is_strip && self.pattern.is_some_and(|pattern| pattern.texture().slides_aslant())
    }

    /// Checks all parameters.
    ///
    /// # Errors
    /// [`SceneError`] with the first invalid quantity.
    pub fn validate(&self) -> Result<(), SceneError> {
        let refuse = |quantity, value, expected| Err(SceneError::OutOfRange { quantity, value, expected });
        let positive = |quantity, value: f64| {
            if value.is_finite() && value > 0.0 { Ok(()) } else { refuse(quantity, value, "a positive number") }
        };
        let not_negative = |quantity, value: f64| {
            if value.is_finite() && value >= 0.0 { Ok(()) } else { refuse(quantity, value, "a number not below zero") }
        };
        positive("length_m", self.layer.length_m)?;
        positive("layer_m", self.layer.height_m)?;
        positive("block_m", self.layer.block_m)?;
        for (quantity, length_m) in [("length_m", self.layer.length_m), ("layer_m", self.layer.height_m)] {
            let blocks = length_m / self.layer.block_m;
            if blocks < 1.0 - WHOLE_BLOCKS_TOLERANCE
                || (blocks - blocks.round()).abs() > WHOLE_BLOCKS_TOLERANCE * blocks.max(1.0)
            {
                return Err(SceneError::NotWholeBlocks { quantity, length_m, block_m: self.layer.block_m });
            }
        }
        if let Some(thickness_m) = self.layer.thickness_m {
            positive("thickness_m", thickness_m)?;
            if thickness_m < self.layer.height_m || thickness_m > MAX_ROWS * self.layer.block_m {
                let expected = "at least the height of the layer and at most 1e5 blocks";
                return refuse("thickness_m", thickness_m, expected);
            }
        }
        let blocks = self.layer.blocks();
        if blocks > MAX_BLOCKS {
            return Err(SceneError::TooManyBlocks { blocks, most: MAX_BLOCKS });
        }
        if self.loads.is_empty() {
            return Err(SceneError::NoLoads);
        }
        for load in &self.loads {
            not_negative("pressure_pa", load.pressure_pa)?;
        }
        not_negative("speed_m_s", self.speed_m_s)?;
        positive("sliding_m", self.run.sliding_m)?;
        not_negative("damping", self.run.damping)?;
        if let Some(step_s) = self.run.step_s {
            positive("step_s", step_s)?;
        }
        if let Some(mu_stderr) = self.run.mu_stderr {
            positive("mu_stderr", mu_stderr)?;
        }
        if !(1..=MAX_DRAWS).contains(&self.run.draws) {
            return refuse("draws", self.run.draws as f64, "a whole number from 1 to 64");
        }
        if let Some(dimensions) = self.run.dimensions.filter(|dimensions| !(2..=3).contains(dimensions)) {
            return refuse("dimensions", f64::from(dimensions), "2 or 3");
        }
        if self.run.dimensions == Some(3) && !self.has_spatial_cell() {
            return Err(SceneError::Unsupported {
                what: "three dimensions in whole samples, with exact springs and by the reference integration",
                instead: "ask for a cell or a strip, steady or dynamic, with linear springs, or for dimensions = 2",
            });
        }
        if self.is_strip_aslant() {
            return Err(SceneError::Unsupported {
                what: "a strip in space of a pattern that slides aslant to its rows, and so repeats at no distance across",
                instead: "ask for extent = \"cell\", or slide along the rows or across them",
            });
        }
        self.validate_relief()?;
        if let Some(pattern) = &self.pattern {
            if pattern.depth_m() >= self.layer.height_m {
                return Err(SceneError::CavityThroughLayer {
                    depth_m: pattern.depth_m(),
                    height_m: self.layer.height_m,
                });
            }
            if pattern.pitch_m() < MIN_PITCH * self.layer.block_m {
                let expected = "a pitch of at least 1.2 blocks: smaller blocks resolve it";
                return refuse("pitch_m", pattern.pitch_m(), expected);
            }
            let most_m = MAX_BLOCKS / (self.layer.height_m / self.layer.block_m) * self.layer.block_m;
            if pattern.pitch_m() > most_m {
                return refuse("pitch_m", pattern.pitch_m(), "a pitch of at most 4e7 blocks");
            }
        }
        Ok(())
    }

    /// Checks that the measured relief fits the pattern and that the pattern has no rims.
    fn validate_relief(&self) -> Result<(), SceneError> {
        let Some(relief) = &self.relief else { return Ok(()) };
        let Some(pattern) = &self.pattern else {
            return Err(SceneError::Unsupported {
                what: "a relief without a pattern, whose period it holds",
                instead: "give the pattern, or no relief",
            });
        };
        if pattern.texture().rim().is_some() {
            return Err(SceneError::Unsupported {
                what: "a measured relief beside rims, which it holds already",
                instead: "give one of the two",
            });
        }
        relief.lands(pattern).map(|_| ()).map_err(SceneError::Relief)
    }

    /// Whether the face has height variations: rims or a measured relief.
    pub fn is_raised(&self) -> bool {
        self.relief.is_some() || self.pattern.as_ref().is_some_and(|pattern| pattern.texture().rim().is_some())
    }
}
