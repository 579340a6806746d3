/// Reason why a scene was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SceneError {
    /// A parameter is out of range; the value is in SI units.
    #[error("{quantity} is {value}: expected {expected}")]
    OutOfRange {
        /// Name of the parameter.
        quantity: &'static str,
        /// Value that was given.
        value: f64,
        /// Description of the accepted values.
        expected: &'static str,
    },
    /// A dimension of the layer is not a whole number of blocks.
    #[error("{quantity} is {length_m} m, which is not a whole number of blocks of {block_m} m")]
    NotWholeBlocks {
        /// Name of the dimension: `length_m` or `layer_m`, the height of the layer.
        quantity: &'static str,
        /// Value of the dimension, in metres.
        length_m: f64,
        /// The lattice spacing, in metres.
        block_m: f64,
    },
    /// The layer has too many blocks to fit in memory.
    #[error("the layer has {blocks:.3e} blocks: expected at most {most:.0e}")]
    TooManyBlocks {
        /// Requested number of blocks.
        blocks: f64,
        /// Maximum number of blocks.
        most: f64,
    },
    /// The equations do not fit in memory.
    #[error("the scene takes {bytes:.2e} bytes on this lattice: expected at most {most_bytes:.2e}")]
    TooLarge {
        /// Required memory, in bytes.
        bytes: f64,
        /// Maximum memory, in bytes.
        most_bytes: f64,
    },
    /// The scene would take too much computing time.
    #[error("it would take about {core_s:.1e} s of one core: expected at most {most_s:.1e}")]
    TooLong {
        /// Estimated time on one core, in seconds.
        core_s: f64,
        /// Maximum time, in seconds.
        most_s: f64,
    },
    /// The scene has no load.
    #[error("the scene has no load: expected at least one pressure")]
    NoLoads,
    /// The cavity is at least as deep as the layer.
    #[error("the cavity is {depth_m} m deep, the layer only {height_m} m high: expected a shallower cavity")]
    CavityThroughLayer {
        /// Depth of the cavity, in metres.
        depth_m: f64,
        /// Height of the layer, in metres.
        height_m: f64,
    },
    /// The time step exceeds the stability limit of the scheme.
    #[error(
        "step_s is {step_s:e} s: expected at most {limit_s:e} s, the stability limit of the {scheme} on this lattice"
    )]
    UnstableStep {
        /// Requested step, in seconds.
        step_s: f64,
        /// Stability limit, in seconds.
        limit_s: f64,
        /// Name of the integrator.
        scheme: &'static str,
    },
    /// The relief map does not fit the pattern.
    #[error("{0}")]
    Relief(#[source] crate::pattern::PatternError),
    /// The combination of options is not supported.
    #[error("{what} is not available: {instead}")]
    Unsupported {
        /// Requested combination.
        what: &'static str,
        /// Recommended alternative.
        instead: &'static str,
    },
}
