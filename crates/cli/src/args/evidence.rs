//! Arguments of `validate` and `accuracy`.

use std::path::PathBuf;

use clap::Args;

/// Maximum number of draws of the local coefficients for a row of the comparison.
const MAX_SEEDS: u64 = 1000;

/// Arguments of `validate`
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    slipgrid validate\n  \
    slipgrid validate --all --slope-factors 0.5,1,2 -o out/validation\n  \
    slipgrid validate calibration/ldpe-cast-iron/calibration.toml --depth-um 5.2 --json\n  \
    slipgrid validate my-material/calibration.toml --trial cut-2\n\n\
    The model uses the flat measurements and the surface. It does not use the patterned measurements, which \
    are only compared with its results. The default pattern is the one that the source of the LDPE calibration \
    simulated, grooves 20 um deep; the cavities that it measured are squares, 5.2 um deep. With -o a page is written, \
    report.html, with the source's tables and figures beside those of the model: contact area, interface pressure, \
    friction in time and ratios at the heaviest load. The page also says what rims of unknown height can and \
    cannot explain.\n\n\
    Not modelled: plasticity, viscoelasticity, heating, wear.")]
pub struct ValidateArgs {
    /// Calibration file with measurements on patterned samples, or with measured trials
    #[arg(default_value = "calibration/ldpe-cast-iron/calibration.toml")]
    pub calibration: PathBuf,
    /// Trial to compare, with the lengths of its own pattern; without patterned samples, the first measured trial by default
    #[arg(long, value_name = "NAME")]
    pub trial: Option<String>,
    /// Width of a cavity along the sliding direction; from [pattern] by default, 130 for the published samples. A trial has its own lengths
    #[arg(long, value_name = "UM")]
    pub width_um: Option<f64>,
    /// Gap between two cavities; from [pattern] by default, 370 for the published samples
    #[arg(long, value_name = "UM")]
    pub spacing_um: Option<f64>,
    /// Depth of the modelled cavities; from [pattern] by default, 20 for the published samples
    #[arg(long, value_name = "UM")]
    pub depth_um: Option<f64>,
    /// Depth of the measured cavities; from [pattern] by default. The report gives the effect of its difference from the modelled depth
    #[arg(long, value_name = "UM")]
    pub measured_depth_um: Option<f64>,
    /// Factors on the slopes of the surface, separated by commas; 1 is always among them
    #[arg(long, value_delimiter = ',', default_values_t = [0.5, 1.0, 2.0], value_name = "S,S,...")]
    pub slope_factors: Vec<f64>,
    /// Compare every measured condition, not only the speed and humidity of the table's first row
    #[arg(long)]
    pub all: bool,
    /// Print one JSON object instead of a table
    #[arg(long)]
    pub json: bool,
    /// Travel of the run in time that computes mu(t) for the page; 0 omits the run
    #[arg(long, default_value_t = 2.0, value_name = "UM")]
    pub sliding_um: f64,
    /// Folder for the page report.html, result.json, tables and pictures
    #[arg(long, short, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

/// Arguments of `accuracy`
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    slipgrid accuracy\n  \
    slipgrid accuracy --full -o out/accuracy\n  \
    slipgrid accuracy scene.toml --seeds 5 --json\n\n\
    Methods (fidelity, integrator, springs, step, block size, extent, shortcuts) are compared with \
    `reference` on the same scene: wall time, site updates, error and its standard error. Writes accuracy.md, accuracy.csv, \
    accuracy.svg and result.json.\n\n\
    Reported times are those of runs on one thread with a core to itself. Not modelled: recast rims, plasticity, \
    viscoelasticity, heating, wear.")]
pub struct AccuracyArgs {
    /// Scene file; the source paper's specimen by default
    pub scene: Option<PathBuf>,
    /// Run a short specimen with a thin layer, about a minute; this is the default
    #[arg(long, conflicts_with = "full")]
    pub quick: bool,
    /// Run the scene as given, with all its rows of blocks, which takes hours
    #[arg(long)]
    pub full: bool,
    /// Number of draws of the local coefficients for each row
    #[arg(long, default_value = "3", value_name = "N", value_parser = clap::value_parser!(u64).range(1..=MAX_SEEDS))]
    pub seeds: u64,
    /// Print one JSON object instead of Markdown
    #[arg(long)]
    pub json: bool,
    /// Folder for the page, its numbers and the diagram, instead of stdout
    #[arg(long, short, value_name = "DIR")]
    pub output: Option<PathBuf>,
}
