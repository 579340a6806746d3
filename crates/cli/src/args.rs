//! Command line arguments and their help.

// Comments of arguments are help texts, in which tables of files stand in brackets.
#![allow(rustdoc::broken_intra_doc_links)]

mod campaign;
mod evidence;
mod export;
mod maps;
mod resuming;
mod trials;

use std::path::PathBuf;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser, Subcommand, ValueEnum};
use slipgrid_io::disk::MAX_THREADS;
use slipgrid_io::formats::stated_specimen::MAX_SPECIMENS;
use slipgrid_model::springblock::{Extent, Fidelity};

pub use campaign::{CampaignArgs, CampaignStep, MergeArgs, PlanArgs, WorkArgs};
pub use evidence::{AccuracyArgs, ValidateArgs};
pub use export::ExportArgs;
pub use maps::{MapArgs, SurfaceArgs, SynthesizeArgs};
pub use trials::{NextArgs, TrialsArgs};

/// Designs laser-textured surfaces for a target dry friction.
#[derive(Debug, Parser)]
#[command(
    name = "slipgrid",
    version,
    about = "Designs laser-textured surfaces for a target dry friction",
    arg_required_else_help = true,
    after_help = "Units stand in the keys of all files (width_um, pressure_mpa, speed_mm_s).\n\n\
        Exit codes: 0 done; 2 input refused, nothing written; 3 target cannot be met, or needs no texture, and \
        4 seconds spent (both only from optimize and next); 1 anything else.\n\n\
        Examples:\n  \
        slipgrid optimize designs/ldpe-lower-friction.toml\n  \
        slipgrid simulate scene.toml --fidelity dynamic --extent sample -o out/scene\n  \
        slipgrid calibrate calibration/ldpe-cast-iron/calibration.toml -o ldpe.toml"
)]
pub struct Arguments {
    /// Threads, 1 to 1024, of which no more than cores are started; all cores by default. Results do not depend on it
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=MAX_THREADS as u64))]
    pub threads: Option<u64>,
    /// Recompute everything. Without this flag, contact areas, fits and runs of earlier commands are reused from the
    /// folder that SLIPGRID_CACHE names, ~/.cache/slipgrid by default. Results do not depend on it
    #[arg(long, global = true)]
    pub no_cache: bool,
    /// Show no progress bar and no notes; results still go to stdout
    #[arg(long, short, global = true)]
    pub quiet: bool,
    /// Command to run.
    #[command(subcommand)]
    pub command: Command,
}

/// Commands of the program.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Compute the friction of a given surface at given loads
    Simulate(SimulateArgs),
    /// Search for a pattern that brings friction to a target, confirm it, and write the laser's files
    Optimize(OptimizeArgs),
    /// Write a page with sliders that shows the prediction for any design, before a search
    Explore(ExploreArgs),
    /// Fit local friction coefficients to measurements on flat samples
    Calibrate(CalibrateArgs),
    /// Choose the sample to cut next, and give its chance to be on target according to the trials
    Next(NextArgs),
    /// Compare measurements of trial samples with the predictions made before they were cut
    Trials(TrialsArgs),
    /// Read dynamic friction, static peak and stick-slip from tribometer exports
    Traces(TracesArgs),
    /// Compute the real contact area of an altitude map against pressure
    AreaLaw(AreaLawArgs),
    /// Measure parameters and cavities of an altitude map, and draw it
    Surface(SurfaceArgs),
    /// Make a synthetic self-affine altitude map, with cavities if wanted
    Synthesize(SynthesizeArgs),
    /// Write the design of a result in other formats
    Export(ExportArgs),
    /// Compare measured ratios, patterned over flat, with the model's
    Validate(ValidateArgs),
    /// Compare speed and error of every method, on one page
    Accuracy(AccuracyArgs),
    /// Compute thousands of scenes or designs on any number of machines
    Campaign(CampaignArgs),
    /// Write a commented file to start from
    New(NewArgs),
    /// Do all of this on a page in the browser, without a terminal
    Studio(StudioArgs),
    /// Print completions for a shell
    Completions(CompletionsArgs),
    /// Print the manual page
    Man(ManArgs),
}

/// Arguments of `simulate`
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    slipgrid simulate scene.toml\n  \
    slipgrid simulate scene.toml --json > result.json\n  \
    slipgrid simulate scene.toml --fidelity dynamic --extent sample -o out/scene\n\n\
    steady solves the equilibrium in which every contact block slides. It has neither time nor static \
    friction; searches use it. dynamic integrates in time by the fastest scheme whose error is measured, and \
    confirms designs. reference is exactly the published scheme (RK4, 1 ns); the others are judged by it.\n\n\
    The model leaves out plasticity, viscoelasticity, heating, wear, and recast rims unless [pattern] gives them.")]
pub struct SimulateArgs {
    /// Scene file
    pub scene: PathBuf,
    /// Solution method; the scene's choice by default
    #[arg(long, value_parser = named(FIDELITIES, Fidelity::name))]
    pub fidelity: Option<Fidelity>,
    /// Modelled part of the specimen; the scene's choice by default
    #[arg(long, value_parser = named(EXTENTS, Extent::name))]
    pub extent: Option<Extent>,
    /// Print everything: all doubts, intervals, assumptions and the numerical method
    #[arg(long, conflicts_with = "json")]
    pub details: bool,
    /// Print one JSON object instead of a table
    #[arg(long)]
    pub json: bool,
    /// Folder for result.json, timings.json, tables and pictures
    #[arg(long, short, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

/// Arguments of `optimize`
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    slipgrid optimize designs/ldpe-lower-friction.toml\n  \
    slipgrid optimize designs/ldpe-lower-friction.toml -o out/grooves --threads 8\n  \
    slipgrid optimize designs/ldpe-lower-friction.toml --table --resume\n\n\
    Writes result.json, timings.json, scene.toml (a scene for `simulate`), pattern.dxf, pattern.svg, pattern.csv, \
    process.toml, report.html and pictures. A file that slipgrid did not write is not replaced. Exit codes: \
    0 a sample or a series is worth cutting, or a trial meets the target; 3 no design within bounds and limits is expected \
    to meet it, or the flat surface does; 4 seconds spent. The report is written wherever \
    there is a design.\n\n\
    Every answer of the search's model is appended to out/NAME.study.jsonl at once. A run that was killed goes on \
    from there with --resume, and ends with the same results. A study of another material, layer, load or texture \
    is refused; other targets, limits and bounds share it. While a run works for a folder, out/NAME.lock keeps others out.\n\n\
    Grooves across the sliding direction are solved in the vertical plane. All other planforms, and grooves along or \
    oblique to the sliding direction, are solved in space. dimensions = 2 or 3 in [search] overrides this.\n\n\
    The model leaves out plasticity, viscoelasticity, heating, wear, and recast rims unless [pattern] gives them.")]
pub struct OptimizeArgs {
    /// Design file
    pub design: PathBuf,
    /// Folder for the results; out/NAME for designs/NAME.toml by default
    #[arg(long, short, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Also write table.csv with the prediction for every design of whole blocks and bursts within the bounds
    #[arg(long)]
    pub table: bool,
    /// Leave the explorer out of report.html, which saves some seconds and a hundred kilobytes
    #[arg(long)]
    pub no_explorer: bool,
    /// Reuse the results that an earlier run of this design left in out/NAME.study.jsonl
    #[arg(long)]
    pub resume: bool,
    /// Print everything in the report: all doubts, other textures, trade-offs and the numerical method
    #[arg(long, conflicts_with = "json")]
    pub details: bool,
    /// Print result.json, with times, instead of a summary
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `explore`
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    slipgrid explore designs/ldpe-lower-friction.toml\n  \
    slipgrid explore ldpe.toml --speed-mm-s 2 --humidity-pct 15 -o ldpe.html\n\n\
    The page interpolates steady solutions of a lattice of designs, and says how far this is from the table of the model. It needs \
    neither the network nor slipgrid. For a material it shows grooves at 0.65 to 2.6 MPa; for all else give a design.")]
pub struct ExploreArgs {
    /// Design, material or calibration file
    pub file: PathBuf,
    /// Sliding speed, for a material with coefficients per condition
    #[arg(long, value_name = "MM/S", requires = "humidity_pct")]
    pub speed_mm_s: Option<f64>,
    /// Relative humidity, for a material with coefficients per condition
    #[arg(long, value_name = "PCT", requires = "speed_mm_s")]
    pub humidity_pct: Option<f64>,
    /// Page to write, or a folder for explore.html
    #[arg(long, short, value_name = "PAGE.html", default_value = "explore.html")]
    pub output: PathBuf,
}

/// Arguments of `calibrate`
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    slipgrid calibrate calibration/ldpe-cast-iron/calibration.toml\n  \
    slipgrid calibrate calibration/ldpe-cast-iron/calibration.toml -o ldpe.toml\n\n\
    Scenes and designs name the written file: material = \"ldpe.toml\".")]
pub struct CalibrateArgs {
    /// Calibration file
    pub calibration: PathBuf,
    /// Material file to write; without it the fit is only printed
    #[arg(long, short, value_name = "MATERIAL.toml")]
    pub output: Option<PathBuf>,
    /// Folder for the page report.html, covariance, profiles, residuals, trials, and pictures of traces
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
    /// Print everything: all doubts, intervals, assumptions and the numerical method
    #[arg(long)]
    pub details: bool,
}

/// Arguments of `traces`
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    slipgrid traces my-material/calibration.toml -o out/traces\n  \
    slipgrid traces run1.csv run2.csv run3.csv --effective-radius-mm 38.1 --force-n 200 \\\n    \
    --speed-mm-s 2 --humidity-pct 15 -o out/200N\n\n\
    Takes a calibration file with a table [traces], which says what the flags say of exports, or the repeats of one condition. An export is a \
    table with a header that names time, torque (or friction force) and normal force, with units; comma, \
    semicolon or tab, decimal point or comma. mu = torque / (normal force x effective radius). \
    Writes flat.csv, patterned.csv and a table of each trial, which `calibrate` takes, traces.csv and pictures of each condition: friction against time, and loops against position where strokes go back and forth. \
    A trace that cannot be used (saturated, gap, no load, wrong sign, clock going back) is refused.")]
pub struct TracesArgs {
    /// Calibration file, or exports of one condition
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// Distance from the axis to the centre of a specimen; required for torques
    #[arg(long, value_name = "MM")]
    pub effective_radius_mm: Option<f64>,
    /// Nominal normal force on one specimen
    #[arg(long, value_name = "N")]
    pub force_n: Option<f64>,
    /// Sliding speed
    #[arg(long, value_name = "MM/S")]
    pub speed_mm_s: Option<f64>,
    /// Relative humidity; if it was not measured, the same number for all conditions, such as 50
    #[arg(long, value_name = "PCT")]
    pub humidity_pct: Option<f64>,
    /// Number of specimens that share the recorded normal force
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_SPECIMENS)))]
    pub specimens: Option<u32>,
    /// Averaging window, seconds since the first row; 10,40 by default
    #[arg(long, value_name = "FROM,TO", value_delimiter = ',', num_args = 1)]
    pub window_s: Option<Vec<f64>>,
    /// Span before touchdown whose mean forces are subtracted as the sensors' zero, seconds since the first row
    #[arg(long, value_name = "FROM,TO", value_delimiter = ',', num_args = 1)]
    pub zero_s: Option<Vec<f64>>,
    /// Step of the exports to read, by its number in the export, or counted from 1; the whole export by default
    #[arg(long, value_name = "N")]
    pub step: Option<u32>,
    /// The samples are patterned
    #[arg(long)]
    pub patterned: bool,
    /// Do not look for a peak at the onset of sliding
    #[arg(long)]
    pub no_static_peak: bool,
    /// The samples slide back and forth: friction is half the width of the loop, in the middle half of every stroke
    #[arg(long)]
    pub reciprocating: bool,
    /// Folder for tables and pictures
    #[arg(long, short, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

/// Arguments of `area-law`
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    slipgrid area-law flat-map.asc --youngs-modulus-gpa 0.38\n  \
    slipgrid area-law scan.txt --pixel-um 0.5 --height-unit nm --pressures-mpa 0.1,0.7,2.6 --json\n\n\
    The factor f is A/P, the contact area over pressure, divided by its limit at small loads. \
    It depends on the map's pixel size and rms slope.\n\n\
    Maps that look wrong are named in lines that begin with !, or are refused; crates/book has the limits. \
    Last digits (1e-14) differ between processors with AVX and without it.")]
pub struct AreaLawArgs {
    /// Altitude map
    #[arg(required_unless_present = "persson_rms_slope")]
    pub map: Option<PathBuf>,
    /// Rms slope for the law of Persson's theory, instead of a map
    #[arg(long, value_name = "SLOPE", conflicts_with_all = ["map", "windows", "resolutions", "pixel_um", "pixel_y_um", "height_unit",
        "lateral_unit", "decimal_comma", "crop", "decimate", "decimate_by", "missing", "despike", "form", "no_level"])]
    pub persson_rms_slope: Option<f64>,
    /// Young's modulus; by default that of the published polyethylene, 0.38 GPa, which is stated in the result
    #[arg(long, value_name = "GPA")]
    pub youngs_modulus_gpa: Option<f64>,
    /// Poisson's ratio; the default is 1/3
    #[arg(long, default_value_t = 1.0 / 3.0, value_name = "NU", hide_default_value = true)]
    pub poisson_ratio: f64,
    /// Nominal pressures, separated by commas; 0.1 to 100 MPa by default
    #[arg(long, value_delimiter = ',', value_name = "P,P,...")]
    pub pressures_mpa: Option<Vec<f64>>,
    /// Error at which the contact computation ends
    #[arg(long, default_value_t = 1e-8, value_name = "ERROR")]
    pub tolerance: f64,
    /// Pressure up to which friction is taken as proportional to load; without it f is A/P over its limit at small loads
    #[arg(long, value_name = "MPA")]
    pub threshold_mpa: Option<f64>,
    /// Number of windows along each side of the map, whose scatter of f gives its standard error; 0 or 1 for none, 2 by
    /// default if the map is large enough
    #[arg(long, value_name = "N")]
    pub windows: Option<usize>,
    /// Also report f at coarser pixels: means over 2 x 2 and 4 x 4, or over the numbers given
    #[arg(long, value_delimiter = ',', value_name = "N,N,...", num_args = 0.., default_missing_value = "2,4", require_equals = true)]
    pub resolutions: Option<Vec<usize>>,
    /// Options for reading the map.
    #[command(flatten)]
    pub reading: MapArgs,
    /// Do not subtract the least-squares plane
    #[arg(long, conflicts_with = "form")]
    pub no_level: bool,
    /// Print one JSON object instead of a table
    #[arg(long)]
    pub json: bool,
    /// Folder for result.json, the table and a picture
    #[arg(long, short, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

/// Arguments of `studio`
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    slipgrid studio my-material\n  \
    slipgrid studio --example\n\n\
    Serves the page on this computer alone, at an address with a token, and opens it in the browser. Forms are views of the files in \
    the folder; the page runs the commands of this program, and writes the same bytes. Ctrl-C ends it.")]
pub struct StudioArgs {
    /// Folder with calibrations and designs, which may be empty; the current one by default
    pub folder: Option<PathBuf>,
    /// Begin with the published polyethylene, in a new folder: slipgrid-example by default
    #[arg(long)]
    pub example: bool,
    /// Print the address, and open no browser
    #[arg(long)]
    pub no_browser: bool,
}

/// Arguments of `new`
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    slipgrid new design my-design.toml\n  \
    slipgrid new calibration my-material\n\n\
    The file runs as it is. Nothing that exists is replaced.")]
pub struct NewArgs {
    /// Kind of file to write
    #[arg(value_enum)]
    pub template: TemplateName,
    /// File, or folder of a calibration; scene.toml, design.toml or calibration by default
    pub path: Option<PathBuf>,
}

/// Names of the templates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum TemplateName {
    /// A folder with a calibration and its table of measurements
    Calibration,
    /// A design task for `optimize`
    Design,
    /// A scene for `simulate`
    Scene,
}

/// Arguments of `completions`
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    slipgrid completions bash > ~/.local/share/bash-completion/completions/slipgrid\n  \
    slipgrid completions fish > ~/.config/fish/completions/slipgrid.fish")]
pub struct CompletionsArgs {
    /// Shell
    #[arg(value_enum)]
    pub shell: clap_complete::Shell,
}

/// Arguments of `man`
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    slipgrid man | man -l -\n  \
    slipgrid man -o ~/.local/share/man/man1")]
pub struct ManArgs {
    /// Folder for one page per command, instead of stdout
    #[arg(long, short, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

/// Value of a flag, with its help.
type Choice<T> = (T, &'static str);

/// Choices for `--fidelity`.
const FIDELITIES: [Choice<Fidelity>; 3] = [
    (Fidelity::Steady, "Equilibrium with every contact block sliding"),
    (Fidelity::Dynamic, "Time integration by the fastest scheme whose error is measured"),
    (Fidelity::Reference, "Exactly the published scheme"),
];
/// Choices for `--extent`.
const EXTENTS: [Choice<Extent>; 3] = [
    (Extent::Cell, "One period with periodic sides"),
    (Extent::Sample, "The whole specimen with free sides"),
    (Extent::Strip, "A strip of the specimen in space, one period wide, with two ends"),
];

/// Parser of the values in `choices` by their `name`.
fn named<T: Copy + Send + Sync + 'static, const COUNT: usize>(
    choices: [Choice<T>; COUNT],
    name: fn(T) -> &'static str,
) -> impl TypedValueParser<Value = T> {
    let known = choices.map(|(value, help)| PossibleValue::new(name(value)).help(help));
    let value = move |given: String| choices.into_iter().map(|(value, _)| value).find(|value| name(*value) == given);
    PossibleValuesParser::new(known).try_map(move |given| value(given).ok_or("an unknown name"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        crate::with_negative_numbers(Arguments::command()).debug_assert();
    }
}
