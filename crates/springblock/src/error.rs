/// Why a scene was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SceneError {
    /// A number outside its meaning; SI units.
    #[error("{quantity} is {value}: expected {expected}")]
    OutOfRange {
        /// Which number.
        quantity: &'static str,
        /// The number given.
        value: f64,
        /// What would be accepted.
        expected: &'static str,
    },
    /// A dimension of the layer that is no whole number of blocks.
    #[error("{quantity} is {length_m} m, which is not a whole number of blocks of {block_m} m")]
    NotWholeBlocks {
        /// `length_m` or `layer_m`.
        quantity: &'static str,
        /// The dimension, in metres.
        length_m: f64,
        /// The lattice spacing, in metres.
        block_m: f64,
    },
    /// More blocks than fit in memory.
    #[error("the layer has {blocks:.3e} blocks: expected at most {most:.0e}")]
    TooManyBlocks {
        /// Blocks asked for.
        blocks: f64,
        /// The limit.
        most: f64,
    },
    /// It does not fit in memory.
    #[error("the scene takes {bytes:.2e} bytes on this lattice: expected at most {most_bytes:.2e}")]
    TooLarge {
        /// Memory they would take.
        bytes: f64,
        /// The limit.
        most_bytes: f64,
    },
    /// A run would take longer than anybody waits.
    #[error("it would take about {core_s:.1e} s of one core: expected at most {most_s:.1e}")]
    TooLong {
        /// Seconds of one core.
        core_s: f64,
        /// The limit.
        most_s: f64,
    },
    /// No pressure was given.
    #[error("the scene has no load: expected at least one pressure")]
    NoLoads,
    /// The cavity is as deep as the layer or deeper.
    #[error("the cavity is {depth_m} m deep, the layer only {height_m} m high: expected a shallower cavity")]
    CavityThroughLayer {
        /// The cavity's depth, in metres.
        depth_m: f64,
        /// The layer's height, in metres.
        height_m: f64,
    },
    /// The time step is beyond the stability limit of the scheme.
    #[error(
        "step_s is {step_s:e} s: expected at most {limit_s:e} s, the stability limit of the {scheme} on this lattice"
    )]
    UnstableStep {
        /// The step asked for, in seconds.
        step_s: f64,
        /// The limit, in seconds.
        limit_s: f64,
        /// Name of the integrator.
        scheme: &'static str,
    },
    /// A relief that is not that of the pattern.
    #[error("{0}")]
    Relief(#[source] slipgrid_pattern::PatternError),
    /// A combination that no solver offers.
    #[error("{what} is not available: {instead}")]
    Unsupported {
        /// What was asked for.
        what: &'static str,
        /// What to ask for instead.
        instead: &'static str,
    },
}
