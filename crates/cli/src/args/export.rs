//! Arguments of `export`.

use std::path::PathBuf;

use clap::Args;
use clap::builder::TypedValueParser;
use slipgrid_report::LaserFile;

use super::named;

/// Arguments of `export`
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    slipgrid export out/ldpe-lower-friction/result.json --format dxf,svg -o laser\n  \
    slipgrid export out/ldpe-lower-friction/result.json --format plt,hatch,png,stl -o laser\n  \
    slipgrid export out/ldpe-lower-friction --sample 2 -o out/ldpe-lower-friction-sample-2\n  \
    slipgrid export out/next --sample 2 --format plt -o out/next/next-2\n\n\
    gcode and hatch need laser.spot_um in the design, gcode also laser.speed_mm_s; a mask has no lines and \
    neither file. What cannot be written is said at the end, after the other formats. A pattern finer than the \
    laser's limits is refused.")]
pub struct ExportArgs {
    /// result.json of `optimize` or `next`, or the folder that holds it
    pub result: PathBuf,
    /// Number of the sample in the table of the result; the first by default, which of `optimize` is the design
    #[arg(long, value_name = "N")]
    pub sample: Option<usize>,
    /// Formats, separated by commas
    #[arg(long, value_parser = laser_files(), value_delimiter = ',', default_values = LaserFile::ALWAYS.map(|file| file.described()[0]))]
    pub format: Vec<LaserFile>,
    /// Pixel size of the height map, at most the width of a cavity; by default 1/16 of a cavity, but at least 1/4096 of the specimen
    #[arg(long, value_name = "UM")]
    pub pixel_um: Option<f64>,
    /// Folder for the files; the folder of the result by default
    #[arg(long, short, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

/// Parser of the names of export formats.
fn laser_files() -> impl TypedValueParser<Value = LaserFile> {
    named(LaserFile::EACH.map(|(file, [_, words])| (file, words)), |file| file.described()[0])
}
