//! Arguments of commands for altitude maps.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use clap::Args;
use slipgrid_surface::topography::{CutShape, DecimationMethod, Form, Missing, RimProfile};

use super::{Choice, named};

/// Choices for the height of a pixel that replaces a block of pixels.
const JOINED: [Choice<DecimationMethod>; 2] = [
    (DecimationMethod::Mean, "The mean of the block's heights"),
    (DecimationMethod::Pick, "The first height of the block"),
];
/// Choices for the treatment of missing points.
const MISSING: [Choice<Missing>; 2] =
    [(Missing::Fill, "Replace them by the smoothest surface"), (Missing::Refuse, "Refuse the map")];
/// Choices for the form to subtract from a map.
const FORMS: [Choice<Form>; 3] = [
    (Form::Mean, "The mean height"),
    (Form::Plane, "The plane"),
    (Form::SecondOrder, "The second-order polynomial in x and y"),
];
/// Choices for the shape of synthetic cavities.
const SHAPES: [Choice<CutShape>; 3] = [
    (CutShape::Groove, "Across the sliding direction, through the whole map"),
    (CutShape::Square, "Squares, repeated in both directions"),
    (CutShape::Disc, "Discs, repeated in both directions"),
];
/// Choices for the profile of synthetic rims.
const PROFILES: [Choice<RimProfile>; 4] = [
    (RimProfile::Round, "Parabola, 1 - s^2 at the fraction s of the width"),
    (RimProfile::Flat, "Constant height"),
    (RimProfile::Ramp, "Straight line, 1 - s"),
    (RimProfile::HalfSine, "Arch, sin(pi s)"),
];

/// Options for reading an altitude map.
#[derive(Args, Debug)]
pub struct MapArgs {
    /// Pixel size along x, between the points of a line of the file; for files that do not give it
    #[arg(long, value_name = "UM")]
    pub pixel_um: Option<f64>,
    /// Pixel size along y, between the lines of the file, if it differs from that along x
    #[arg(long, requires = "pixel_um", value_name = "UM")]
    pub pixel_y_um: Option<f64>,
    /// Unit of the heights.
    #[arg(long, value_name = "UNIT", help = of_unit("heights"))]
    pub height_unit: Option<String>,
    /// Unit of the points' x and y.
    #[arg(long, value_name = "UNIT", help = of_unit("points' x and y"))]
    pub lateral_unit: Option<String>,
    /// Read commas as decimal signs: 1,234 is a little more than one. Unambiguous decimal commas, as in 0,5, are
    /// recognized without this flag
    #[arg(long)]
    pub decimal_comma: bool,
    /// Part of the map to keep: first row and first column, counted from 0, number of rows, number of columns
    #[arg(long, value_name = "ROW,COL,ROWS,COLS", value_parser = parse_crop)]
    pub crop: Option<[usize; 4]>,
    /// Join blocks of N x N pixels into one
    #[arg(long, value_name = "N")]
    pub decimate: Option<NonZeroUsize>,
    /// Height of the joined pixel
    #[arg(long, value_parser = named(JOINED, DecimationMethod::name), default_value = "mean", requires = "decimate", value_name = "HOW")]
    pub decimate_by: DecimationMethod,
    /// Treatment of missing points
    #[arg(long, value_parser = named(MISSING, Missing::name), default_value = "fill", value_name = "WHAT")]
    pub missing: Missing,
    /// Replace spikes, single points or clusters of up to twelve that stand far beyond all points around them, by the
    /// median of the points about them
    #[arg(long)]
    pub despike: bool,
    /// Least-squares form to subtract; from a map of exactly one period only the mean is subtracted
    #[arg(long, value_parser = named(FORMS, Form::name), default_value = "plane", value_name = "FORM")]
    pub form: Form,
}

/// Help text of a flag for the unit of `what`.
fn of_unit(what: &str) -> String {
    format!("Unit of the {what}, for a file that does not say it: {}", slipgrid_surface::topography::LengthUnit::NAMES)
}

/// Arguments of `surface`
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    slipgrid surface flat.x3p\n  \
    slipgrid surface textured.sur --cavities -o out/textured\n  \
    slipgrid surface textured.sur --cavities --period-out period.asc\n  \
    slipgrid surface scan.csv --pixel-um 0.5 --height-unit um --decimate 4 --json\n\n\
    Reads matrix text and CSV, points x y z, .gsf, .npy, .sdf, .sur and .x3p, told by their content. \
    Writes the page report.html, map.svg, histogram.svg (with the bearing curve), section.svg, spectrum.svg, section.csv, \
    spectrum.csv and result.json, with --cavities also cavities.csv, edge-profile.csv and \
    edge-profile.svg. x runs along the file's lines, y from line to line; of points they are the file's own.\n\n\
    Cavities are connected regions below half depth. Widths (of round ones the diameter) and gaps are taken there, the depth from the land \
    beside a cavity to the middle third of its width, as in ISO 5436-1.\n\n\
    For rims, a round, flat, ramp or half-sine profile is fitted to the mean height of all points at equal distances \
    from an edge, above the land farther out; its greatest height and its width are given in um. A rim narrower than \
    four pixels has no height. Walls are given in degrees from the horizontal, between 20 % and 80 % of the depth.\n\n\
    With AVX, Fourier transforms add in another order than without: between such processors spectrum, rms slope, \
    Sal and Str differ by 1e-14 of themselves.")]
pub struct SurfaceArgs {
    /// Altitude map
    pub map: PathBuf,
    /// Options for reading the map.
    #[command(flatten)]
    pub reading: MapArgs,
    /// Measure the cavities of a patterned sample: width, spacing, depth and rims in um, walls in degrees
    #[arg(long)]
    pub cavities: bool,
    /// Write the mean period of the pattern as matrix text in um: cavities averaged about their centres, heights above
    /// the land, cavity in the middle; grooves as a square with their pitch as its side
    #[arg(long, requires = "cavities", value_name = "FILE")]
    pub period_out: Option<PathBuf>,
    /// Distance of the section along x from the side y = 0; the middle by default
    #[arg(long, value_name = "UM")]
    pub section_um: Option<f64>,
    /// Print one JSON object instead of a table
    #[arg(long)]
    pub json: bool,
    /// Folder for result.json, tables and pictures
    #[arg(long, short, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

/// Arguments of `synthesize`
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    slipgrid synthesize -o flat-map.asc\n  \
    slipgrid synthesize --side-mm 2.56 --cavities 130,370,5.2 --wall-um 10 -o textured.asc\n  \
    slipgrid synthesize --pixels 256 --hurst 0.7 --waves 4:32 --sa-um 0.3 --seed 7 -o rough.asc\n\n\
    The defaults make the map that stands in for the unpublished one of the LDPE calibration. \
    Waves n:m are the longest and the shortest wave, in waves per side.")]
pub struct SynthesizeArgs {
    /// Number of pixels per side
    #[arg(long, default_value_t = 512, value_name = "N")]
    pub pixels: usize,
    /// Side of the square
    #[arg(long, default_value_t = 1.0, value_name = "MM")]
    pub side_mm: f64,
    /// Hurst exponent
    #[arg(long, default_value_t = 0.8, value_name = "H")]
    pub hurst: f64,
    /// Minimum and maximum number of waves per side
    #[arg(long, default_value = "4:64", value_name = "MIN:MAX", value_parser = parse_waves)]
    pub waves: (u32, u32),
    /// Arithmetic mean height Sa
    #[arg(long, default_value_t = 0.158, value_name = "UM")]
    pub sa_um: f64,
    /// Root mean square slope, instead of Sa
    #[arg(long, value_name = "SLOPE", conflicts_with = "sa_um")]
    pub rms_slope: Option<f64>,
    /// Seed of the phases and of the cavities' scatter
    #[arg(long, default_value_t = 20_240_607, value_name = "SEED")]
    pub seed: u32,
    /// Cut cavities: width, spacing and depth
    #[arg(long, value_name = "UM,UM,UM", value_parser = parse_three)]
    pub cavities: Option<[f64; 3]>,
    /// Shape of the cavities seen from above
    #[arg(long, value_parser = named(SHAPES, CutShape::name), default_value = "groove", requires = "cavities", value_name = "SHAPE")]
    pub cavity_shape: CutShape,
    /// Horizontal extent of the cavities' walls, which are inclined by atan(depth/extent); less than a pixel counts as
    /// a pixel
    #[arg(long, default_value_t = 0.0, requires = "cavities", value_name = "UM")]
    pub wall_um: f64,
    /// Rims along the cavities' edges: maximum height above the land, and width from the upper end of the wall
    #[arg(long, requires = "cavities", value_name = "UM,UM", value_parser = parse_two)]
    pub rims: Option<[f64; 2]>,
    /// Profile of rims from the edge outward
    #[arg(long, value_parser = named(PROFILES, RimProfile::name), default_value = "round", requires = "rims", value_name = "PROFILE")]
    pub rim_profile: RimProfile,
    /// Standard deviation of the rims' heights from cavity to cavity
    #[arg(long, default_value_t = 0.0, requires = "rims", value_name = "UM")]
    pub rim_std_um: f64,
    /// Standard deviations of the cavities' width, pitch and depth
    #[arg(long, requires = "cavities", value_name = "UM,UM,UM", value_parser = parse_three)]
    pub cavity_std: Option<[f64; 3]>,
    /// Map to write, as matrix text: a name that ends in .asc or .txt
    #[arg(long, short, value_name = "FILE")]
    pub output: PathBuf,
}

fn parse_waves(text: &str) -> Result<(u32, u32), String> {
    let expected = || "expected two whole numbers, for instance 4:64".to_owned();
    let (least, most) = text.split_once(':').ok_or_else(expected)?;
    match (least.trim().parse(), most.trim().parse()) {
        (Ok(least), Ok(most)) if 0 < least && least <= most => Ok((least, most)),
        (Ok(_), Ok(_)) => Err("expected the smaller number first, from 1 up".to_owned()),
        _ => Err(expected()),
    }
}

fn parse_two(text: &str) -> Result<[f64; 2], String> {
    parse_list(text).ok_or_else(|| "expected two numbers, for instance 0.5,15".to_owned())
}

fn parse_three(text: &str) -> Result<[f64; 3], String> {
    parse_list(text).ok_or_else(|| "expected three numbers, for instance 130,370,5.2".to_owned())
}

fn parse_list<T: std::str::FromStr, const COUNT: usize>(text: &str) -> Option<[T; COUNT]> {
    let numbers: Option<Vec<T>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    numbers.and_then(|numbers| numbers.try_into().ok())
}

fn parse_crop(text: &str) -> Result<[usize; 4], String> {
    parse_list(text)
        .filter(|[_, _, rows, cols]| *rows > 1 && *cols > 1)
        .ok_or_else(|| "expected four whole numbers, the last two from 2 up, for instance 0,0,512,512".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crops_and_cavities_are_lists_of_numbers() {
        assert_eq!(parse_crop("0, 10,512,256"), Ok([0, 10, 512, 256]));
        assert_eq!(parse_three("130,370,5.2"), Ok([130.0, 370.0, 5.2]));
        assert_eq!(parse_two("0.5, 15"), Ok([0.5, 15.0]));
        assert!(parse_two("0.5").is_err() && parse_two("0.5,15,1").is_err());
        for bad in ["1,2,3", "0,0,1,5", "-1,0,5,5", "a,b,c,d", ""] {
            assert!(parse_crop(bad).is_err() && parse_three(&format!("{bad},x")).is_err(), "{bad}");
        }
    }

    #[test]
    fn waves_are_a_range() {
        assert_eq!(parse_waves("4:64"), Ok((4, 64)));
        for bad in ["4", "64:4", "0:4", "a:b", "4:"] {
            assert!(parse_waves(bad).is_err(), "{bad}");
        }
    }
}
