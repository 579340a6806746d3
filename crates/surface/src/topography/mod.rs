//! Altitude maps of measured or synthetic surfaces: readers, form removal, ISO 25178 parameters, cavities.
//!
//! A map is a surface h(x, y) on a grid of pixels dx by dy. Its parameters are
//!
//! ```text
//! Sa = mean |h - mean h|,   Sq^2 = mean (h - mean h)^2,   h'rms^2 = sum over waves of |q|^2 |h_q|^2
//! ```
//!
//! | item | role |
//! |---|---|
//! | [`HeightMap`] | a valid map in metres: parameters, form removal, filling of missing points, writing |
//! | [`read_map`], [`ReadOptions`] | a map from what instruments write ([`MapFormat`]), whole, cropped or decimated |
//! | [`PreparedMap`], [`Preparation`] | a map made ready for computation: filled, without spikes and form, as one period |
//! | [`periodic_component`], [`side_step_ratio`] | a map's periodic component, and the step across its sides |
//! | [`Form`], [`Filling`] | shapes that form removal subtracts; statistics of filling missing points |
//! | [`MapWarning`], [`limits`], [`Spikes`] | warnings about doubtful maps, their limits, and single wrong points |
//! | [`HeightParameters`], [`CorrelationLengths`] | Sa to Sz; Sal and Str; Sdr is [`HeightMap::sdr`] |
//! | [`MaterialRatioCurve`], [`CoreParameters`] | bearing curve; Sk, Spk, Svk, Smr1, Smr2 |
//! | [`SpectrumBin`] | the radial power spectrum in m^4 |
//! | [`CavityMetrology`], [`RimMetrology`] | width, spacing and depth of cavities with their spread; rims, walls, floors |
//! | [`MeanPeriod`] | the mean period of a pattern of cavities, as a map |
//! | [`SelfAffine`], [`CutPattern`] | synthetic self-affine maps and cavities, the same on every platform |
//! | [`Fourier`](fourier::Fourier) | the periodic transform behind spectral parameters and contact solvers |
//!
//! This module does not depend on contact computations and opens no files.
//!
//! ```
//! use slipgrid_surface::topography::{ReadOptions, read_map};
//! let text = "# Width: 4 um\n# Height: 2 um\n# Value units: um\n1 -1 1 -1\n1 -1 1 NaN\n";
//! let mut map = read_map(text.as_bytes(), &ReadOptions::default())?.map;
//! assert_eq!((map.rows(), map.cols(), map.dx_m(), map.missing()), (4, 2, 1e-6, 1));
//! map.fill_missing(&slipgrid_base::monitor::Unwatched);
//! assert!(map.heights_m()[7].abs() < 1e-18); // halfway between its neighbours, 1 and -1 um
//! // Mean 1/8 um: four heights 7/8, three 9/8 and one 1/8 um from it.
//! assert!((map.sa_m() - 0.875e-6).abs() < 1e-18);
//! # Ok::<(), slipgrid_surface::topography::ReadError>(())
//! ```

pub mod fourier;

mod cavities;
mod despike;
mod error;
mod file_faults;
mod fill;
mod form;
mod level;
mod map;
mod order;
mod parameters;
mod periodic;
mod plausibility;
mod prepare;
mod read;
mod synthetic;
mod unit;
mod write;

pub use cavities::{
    Arrangement, Cavity, CavityMetrology, Crossing, CutCavity, CutPattern, CutRim, CutShape, EdgeHeight, Estimate,
    MeanPeriod, RimMetrology, RimProfile, RimUnknown, Spread, StaggeredRows,
};
pub use despike::{Spike, Spikes};
pub use error::{MapError, MapOption, NotGiven, ReadError};
pub use fill::Filling;
pub use form::Form;
pub use map::{HeightMap, MAX_POINTS};
pub use parameters::{
    CoreParameters, CorrelationLengths, HeightParameters, LIMITED_BY_PIXELS, MaterialRatioCurve, ShortWaves, Sides,
    SpectrumBin,
};
pub use periodic::{periodic_component, side_step_ratio};
pub use plausibility::{MapDoubt, MapWarning, limits};
pub use prepare::{Missing, Preparation, PreparationError, PreparedMap};
pub use read::{Crop, Decimation, DecimationMethod, MapFormat, ReadMap, ReadOptions, read_map};
pub use synthetic::SelfAffine;
pub use unit::{LengthUnit, UnknownUnit};
pub use write::MatrixStyle;
