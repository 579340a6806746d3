//! Search for the pattern that brings friction to a target.
//!
//! Friction v_i at the pressures P_i, i = 1..n, should be t_i within the tolerances T_i, or within bands. Over
//! the designs x = (width, spacing, depth) that a laser can make, the search minimizes
//!
//! rms(x) = sqrt( sum_i w_i ((v_i(x) - t_i) / T_i)^2 / sum_i w_i )   subject to   q_k(x) <= or >= the limit of q_k,
//!
//! with weights w_i and limited quantities q_k (peak pressure, share of land and the like); or, where the target
//! has a goal, its lowest or highest mean or its least spread over the pressures, within the bands if any.
//!
//! | type | role |
//! |---|---|
//! | [`Target`], [`Demand`], [`Goal`] | values, bands and weights at pressures; what is to be as good as possible |
//! | [`DesignSpace`], [`Constraints`], [`Limit`] | bounds; manufacturing limits and limited quantities |
//! | [`ForwardModel`], [`Response`], [`ModelFailure`] | the model: what it is asked, answers, or why not |
//! | [`search`], [`SearchOptions`] | the search, and how it is made |
//! | [`least_evaluations`] | what a search takes before it is cut in its first step |
//! | [`search_near`] | the same about a design known to be near |
//! | [`search_multi_fidelity`], [`LowFidelityCorrection`] | the search with a dear model along a cheap one, and what that taught |
//! | [`SearchOutcome`], [`Candidate`], [`Status`] | what it found |
//! | [`explain_infeasibility`], [`Explanation`], [`Relief`] | why a target is out of reach, and what would bring it within |
//! | [`sensitivities`], [`Slope`], [`with_rim_off`] | how a response moves with the dimensions, and how well that is known |
//! | [`Tolerances`], [`Uncertainty`], [`propagate`], [`Linearization`] | what uncertain dimensions and parameters make of it |
//! | [`search_robust`] | the design whose samples, as they are made, miss the target least |
//! | [`select`], [`Merits`], [`CommonDraws`] | of the designs on target the one whose samples are likeliest there, and cheap |
//! | [`trade_offs`], [`Goals`] | the designs of which none is better than another by every goal |
//! | [`SearchError`] | why there was nothing to search |
//!
//! The search goes from the whole to the detail. It evaluates the corners of the bounds and a
//! low-discrepancy sample, descends from the best distinct designs by damped Gauss-Newton steps (to a lowest or
//! highest mean by projected linear ones) and, where these do not suffice, by Nelder and Mead's method,
//! seeks width and spacing anew at neighbouring numbers of bursts, and, before it calls a target
//! unreachable, looks for the lowest and highest value there is. It moves only on the grid of
//! designs that can be made (whole bursts deep; width and spacing to [`POSITION_STEP_M`]), so no
//! result is rounded afterwards. It stops early only where a design misses by at most
//! [`COMFORTABLE_RMS`] tolerances. A limited quantity is a linearized constraint of the former and an exact
//! penalty of the latter.
//!
//! A design is evaluated once; only where two threads come to the same design at the same time do
//! both call the model. Equal inputs and seeds give equal outcomes at any number of threads.
//!
//! A search reports to, and is cancelled by, a [`Monitor`](slipgrid_monitor::Monitor).
//!
//! This crate knows no files, no measurements, and nothing of how a model works.
//!
//! ```
//! use slipgrid_optimize::{
//!     Constraints, DesignSpace, Quantity, Response, SearchOptions, Status, Target, TargetPoint, search,
//! };
//! use slipgrid_monitor::Unwatched;
//! use slipgrid_pattern::{Pattern, Planform};
//!
//! // A surface whose friction is proportional to its land: ratio = 1 - width / pitch. With grooves
//! // 100 um wide the ratio 0.75 takes a spacing of 300 um.
//! let model = |design: &Pattern| {
//!     Ok(Response { value: vec![1.0 - design.section_density()], limited: Vec::new() })
//! };
//! let point = TargetPoint { pressure_pa: 1e6, value: 0.75 };
//! let target = Target::new(Quantity::Ratio, vec![point], 0.01)?;
//! let space = DesignSpace::new(Planform::Groove, [100e-6, 100e-6], [40e-6, 1000e-6], [5e-6, 5e-6])?;
//! let outcome =
//!     search(&target, &space, &Constraints::default(), &SearchOptions::default(), &model, &Unwatched)?;
//! assert_eq!(outcome.status, Status::Met);
//! assert!((outcome.best.design.spacing_m() - 300e-6).abs() < 1e-6);
//! # Ok::<(), slipgrid_optimize::SearchError>(())
//! ```

mod chance;
mod constraints;
mod error;
mod evaluation_archive;
mod gauss_newton;
mod infeasibility;
mod local_search;
mod low_discrepancy;
mod low_fidelity_correction;
mod model;
mod multi_fidelity;
mod nelder_mead;
mod outcome;
mod robust_search;
mod search;
mod search_effort;
mod selection;
mod sensitivity;
mod sequential_linear_programming;
mod space;
mod summary;
mod target;
mod trade_offs;
mod uncertainty;
mod uncertainty_propagation;

pub use chance::CommonDraws;
pub use constraints::{Bound, Constraints, Limit, Violation};
pub use error::SearchError;
pub use infeasibility::{Dimension, Explanation, Relief, Restriction, explain_infeasibility};
pub use low_fidelity_correction::LowFidelityCorrection;
pub use model::{ForwardModel, ModelFailure, Response};
pub use multi_fidelity::search_multi_fidelity;
pub use outcome::{Candidate, FailedTrial, HistoryPoint, ReachableRange, SearchOutcome, Status};
pub use robust_search::{RobustOutcome, search_robust};
pub use search::{SearchOptions, least_evaluations, search, search_near};
pub use selection::{Choice, Merits, Selection, SelectionCount, SelectionOptions, select, select_multi_fidelity};
pub use sensitivity::{AxisSensitivity, Sensitivities, Slope, sensitivities, with_rim_off};
pub use space::{DEPTH_STEP_M, DesignSpace, POSITION_STEP_M};
pub use target::{Demand, Goal, Misfit, Quantity, Target, TargetPoint, Wanted};
pub use trade_offs::{Goals, TradeOff, TradeOffOptions, TradeOffs, compare, trade_offs};
pub use uncertainty::{Tolerances, Uncertainty};
pub use uncertainty_propagation::{Linearization, Probability, Propagation, Spread, UncertainModel, propagate};

/// Root-mean-square misfit, in tolerances, at which a design counts as comfortably on target and
/// descending further would only spend evaluations: 0.0002 of a ratio at a tolerance of 0.01.
pub const COMFORTABLE_RMS: f64 = 0.02;
