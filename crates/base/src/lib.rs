//! Ground of the other crates: progress and cancelling, units, statistics, and Fourier transforms.
//!
//! | module | content |
//! |---|---|
//! | [`monitor`] | progress, cancellation, and the cache of a job |
//! | [`units`] | units of files and their conversion |
//! | [`statistics`] | draws, quantiles, and linear algebra |
//! | [`fft`] | real Fourier transforms |
//! | [`key_error`] | refused keys of records |

pub mod fft;
pub mod key_error;
pub mod monitor;
pub mod statistics;
pub mod units;
