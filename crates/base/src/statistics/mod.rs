//! Statistics for several crates: normal deviates and their distribution, chi-square, medians, standard deviations,
//! random integers, Student's t, response surfaces of three lengths, kriging, and small dense linear systems.
//!
//! ```
//! use slipgrid_base::statistics::{Confidence, mean_and_std, median, upper_median};
//! assert_eq!((median(&mut [4.0, 1.0, 3.0, 2.0]), upper_median(&mut [4.0, 1.0, 3.0, 2.0])), (Some(2.5), Some(3.0)));
//! assert_eq!(mean_and_std([1.0, 2.0, 3.0]), Some((2.0, Some(1.0))));
//! assert_eq!(Confidence::PERCENT_95.student_t(2), 4.302_653);
//! ```

mod chi_square;
pub mod cholesky;
mod kriging;
mod normal;
mod normal_distribution;
mod response_surface;
mod sample;
mod split_mix;
mod student;
mod synthetic_noise;

pub use chi_square::chi_square_beyond;
pub use kriging::{Kriging, distance};
pub use normal::Normals;
pub use normal_distribution::{
    BoxRule, mixture_quantile, normal_probability, normal_quantile, tabulated_normal_probability,
};
pub use response_surface::{Axis, ResponseSurface};
pub use sample::{extremes, mean_and_std, median, upper_median};
pub use split_mix::{SplitMix64, splitmix64};
pub use student::{Confidence, NORMAL_95};
pub use synthetic_noise::Noise;
