//! The physical model: patterns, materials, and the spring-block lattice that slides.
//!
//! | module | content |
//! |---|---|
//! | [`material`] | elastic constants, local friction, the area law |
//! | [`pattern`] | planforms, arrangements, and their dimensions |
//! | [`springblock`] | friction of a pattern: steady cells and runs in time, in the plane and in space |

/// Implements for an enum the list of its variants and their names in files, which also display them.
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

pub mod material;
pub mod pattern;
pub mod springblock;
