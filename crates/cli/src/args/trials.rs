//! Arguments of `next` and `trials`.

use std::path::PathBuf;

use clap::Args;

/// Arguments of `next`
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    slipgrid next designs/ldpe-lower-friction.toml\n  \
    slipgrid next designs/ldpe-lower-friction.toml --count 3 -o out/next\n  \
    slipgrid next designs/ldpe-lower-friction.toml --count 3 --one-disc -o out/disc\n  \
    slipgrid next designs/ldpe-lower-friction.toml --candidate 100,300,10\n  \
    slipgrid next designs/ldpe-lower-friction.toml --learn -o out/learn\n  \
    slipgrid export out/next --sample 2 --format plt -o out/next/next-2\n\n\
    Compares about 3,000 designs within the bounds by the chance that a cut sample is on target, by the table of the model and what \
    the trials of the calibration say that it lacks, and goes on from the best of them by the model itself, for grooves in \
    time. Several samples are chosen to complement each other \
    and those that are pending. A [[trial]] without measurements is pending. Exit codes as of optimize: 3 no sample is worth \
    cutting, 4 seconds spent.\n\n\
    --one-disc serves where each sector is measured alone: with a pin or a counter-body that fits on it, or by friction \
    resolved by the angle of a turning disc. A tribometer that presses the whole disc measures a mean of all sectors, which \
    is of no use here.\n\n\
    --learn proposes a first disc for a new material. A sector of grooves may lie across or along the sliding direction; other \
    planforms keep their directions. It shows the ratio of both sectors if the model error grows with areal density, edge \
    length, ..., and chooses the pair whose measured ratios tell these mechanisms apart best. The chance to be on target \
    plays no part.")]
pub struct NextArgs {
    /// Design file
    pub design: PathBuf,
    /// Number of samples to cut at once
    #[arg(long, default_value_t = 1, value_name = "N")]
    pub count: usize,
    /// Cut the samples as sectors of one disc: write their files, and trials.toml, whose lines go into the calibration
    #[arg(long)]
    pub one_disc: bool,
    /// Cut the one disc of two sectors that teaches most about which mechanism the model lacks
    #[arg(long, conflicts_with_all = ["count", "one_disc", "candidate"])]
    pub learn: bool,
    /// Candidate of your own, as width, spacing and depth in um; may be given several times
    #[arg(long, value_name = "W,S,D")]
    pub candidate: Vec<String>,
    /// Print one JSON object instead of a table
    #[arg(long)]
    pub json: bool,
    /// Folder for result.json, and for next-1, next-2, ... with the files for the laser. Without it nothing is written,
    /// but for --one-disc out/NAME-disc and for --learn out/NAME-learn
    #[arg(long, short, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

/// Arguments of `trials`
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    slipgrid trials calibration/ldpe-cast-iron/calibration.toml\n  \
    slipgrid trials calibration.toml -o out/trials\n\n\
    Every [[trial]] of the calibration is compared with what the model and the trials before it predicted. The \
    table of forms says how the discrepancy, ln(measured / modelled), grows with the texture as far as trials \
    tell. Nothing is fitted to flat samples, unless the area law itself is fitted.")]
pub struct TrialsArgs {
    /// Calibration file
    pub calibration: PathBuf,
    /// Print everything: all doubts, forms and sizes of the discrepancy, scatter and pending samples
    #[arg(long, conflicts_with = "json")]
    pub details: bool,
    /// Print one JSON object instead of tables
    #[arg(long)]
    pub json: bool,
    /// Folder for the page report.html, trials.csv, trials.svg and result.json
    #[arg(long, short, value_name = "DIR")]
    pub output: Option<PathBuf>,
}
