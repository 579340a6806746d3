//! Foundations of the other crates: progress and cancellation, units, statistics, and Fourier transforms.
//!
//! | module | content |
//! |---|---|
//! | [`monitor`] | progress, cancellation, and the cache of a job |
//! | [`units`] | units of files and their conversion |
//! | [`statistics`] | random numbers, distributions, interpolation, and linear algebra |
//! | [`fft`] | Fourier transforms, and filters of maps |
//! | [`key_error`] | errors of refused keys of records |

pub mod fft;
pub mod key_error;
pub mod monitor;
pub mod statistics;
pub mod units;
