//! Foundations of the other crates: progress and cancellation, units, statistics, and Fourier transforms.
//!
//! | module | content |
//! |---|---|
//! | [`monitor`] | progress, cancellation, and the cache of a job |
//! | [`units`] | units of files and their conversion |
//! | [`statistics`] | random numbers, distributions, interpolation, and linear algebra |
//! | [`fft`] | Fourier transforms, and filters of maps |
//! | [`key_error`] | errors of refused keys of records |

/// Implements for an enum the list of its variants and their names in files, which also display them.
#[macro_export]
macro_rules! names {
    ($type:ident { $($variant:ident = $name:literal),+ $(,)? }) => {
        impl $type {
            /// All variants, in the order in which help texts list them.
            pub const ALL: [Self; [$($name),+].len()] = [$(Self::$variant),+];

            /// The name used in files, options and results.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name),+
                }
            }
        }

        impl std::fmt::Display for $type {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(self.name())
            }
        }
    };
}

pub mod fft;
pub mod key_error;
pub mod monitor;
pub mod statistics;
pub mod units;
