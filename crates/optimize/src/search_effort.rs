//! How thoroughly a search is made.

/// Descents, simplexes and bursts of a search, and how far each goes.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Descents started together, about ten evaluations each. More give more alternatives and survive more false
    /// valleys.
    pub starts: usize,
    /// Simplexes started from the best of these where Gauss-Newton steps did not suffice.
    pub simplex_starts: usize,
    /// Whole numbers of bursts, nearest to the best one, at which width and spacing are sought anew where the target
    /// is not met.
    pub bursts: usize,
    /// Edge of the first simplex over the usual one.
    pub edge: f64,
    /// Scatter of costs, in tolerances, at which a simplex has collapsed, over the usual one.
    pub collapsed: f64,
    /// Nothing is asked but which design is nearest: neither how far friction can be brought, nor whether starts unlike
    /// those before lead elsewhere.
    pub nearest_alone: bool,
}

/// Nothing is known but the sample.
pub const WHOLE: Effort =
    Effort { starts: 5, simplex_starts: 2, bursts: 12, edge: 1.0, collapsed: 1.0, nearest_alone: false };
/// The same of a guide, which is not worth following to its last digit.
pub const ALONG: Effort = Effort { collapsed: 10.0, ..WHOLE };
/// The guide has changed a little since the last search, whose finds are known.
pub const AGAIN: Effort =
    Effort { starts: 2, simplex_starts: 1, bursts: NEXT_BURSTS, edge: 0.4, collapsed: 10.0, ..WHOLE };
/// The best design of much the same problem is known.
pub const NEAREST: Effort = Effort { starts: 3, nearest_alone: true, ..AGAIN };

/// The same as [`Effort::bursts`] where the target is met, but not comfortably.
pub const NEXT_BURSTS: usize = 3;
