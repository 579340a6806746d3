//! Files for the laser, made from a design.

use std::io::{self, Write};
use std::sync::Arc;

use slipgrid_design::{DesignTask, NextTrials};
use slipgrid_io::formats::trials::sector_trials;
use slipgrid_laser::export::{
    ExportError, GcodePlan, Heading, HeightMap, Laser, Layout, Marking, MaterialNote, ProcessInput, ProcessSheet,
    Removal, Sector, SectorsSheet, Tolerances, check_stl, corners_csv, csv, dxf, dxf_of_sectors, gcode, hatch_csv,
    height_map, hpgl, stl, svg, svg_of_sectors,
};
use slipgrid_model::material::Provenance;
use slipgrid_model::pattern::Pattern;

use crate::Outputs;
use slipgrid_design::results::{SCHEMA, VERSION};
use slipgrid_laser::export::Specimen;

/// Format of a file for the laser; [`LaserFile::described`] names the file and describes the content.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LaserFile {
    /// DXF drawing (AutoCAD R12).
    Dxf,
    /// SVG picture to scale.
    Svg,
    /// Table of cavities.
    Csv,
    /// Process sheet for the laser operator.
    Process,
    /// HP-GL/2 plot.
    Plt,
    /// G-code program (RS-274).
    Gcode,
    /// Table of the corners of cavities.
    Corners,
    /// Table of marked lines.
    Hatch,
    /// Height map as a 16-bit grey image.
    Png,
    /// Removed material as closed solids.
    Stl,
}

impl LaserFile {
    /// All formats.
    pub const EACH: [Self; 10] = [
        Self::Dxf,
        Self::Svg,
        Self::Csv,
        Self::Process,
        Self::Plt,
        Self::Gcode,
        Self::Corners,
        Self::Hatch,
        Self::Png,
        Self::Stl,
    ];
    /// Formats that need only a pattern and a specimen; every search writes these formats.
    pub const ALWAYS: [Self; 4] = [Self::Dxf, Self::Svg, Self::Csv, Self::Process];

    /// Name of the format, and its file name with a description of the content.
    pub const fn described(self) -> [&'static str; 2] {
        match self {
            Self::Dxf => ["dxf", "pattern.dxf, drawing for the laser"],
            Self::Svg => ["svg", "pattern.svg, picture to scale"],
            Self::Csv => ["csv", "pattern.csv, one row per cavity"],
            Self::Process => ["process", "process.toml, process sheet"],
            Self::Plt => ["plt", "pattern.plt, HP-GL/2 plot with contours and lines"],
            Self::Gcode => ["gcode", "pattern.gcode, program for controllers with a laser mode"],
            Self::Corners => ["corners", "corners.csv, one row per corner"],
            Self::Hatch => ["hatch", "hatch.csv, one row per marked line"],
            Self::Png => ["png", "height-map.png, the surface as 16-bit grey"],
            Self::Stl => ["stl", "removed.stl, what is removed as closed solids"],
        }
    }
}

/// Design, laser and metadata from which the files are made.
pub struct DrawingInput<'a> {
    /// Name of the design.
    pub name: &'a str,
    /// Program version that made the design.
    pub version: &'a str,
    /// Random seed of the design.
    pub seed: u64,
    /// The pattern to cut.
    pub pattern: Pattern,
    /// The specimen, with the outline of its face.
    pub outline: Specimen,
    /// Parameters of the laser.
    pub laser: Laser,
    /// Assumed manufacturing tolerances; `None` if the design assumes none.
    pub tolerances: Option<Tolerances>,
    /// Name and source of the material.
    pub material: &'a Provenance,
}

/// Format that cannot be written, and the reason.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{}: {error}", format.described()[0])]
pub struct Unwritten {
    /// The format.
    pub format: LaserFile,
    /// The reason.
    pub error: ExportError,
}

/// Adds the pattern's files in `formats` to `outputs`, one per format.
///
/// # Errors
/// [`ExportError`] if no cavity or far too many fit on the specimen, or if a format needs a value that the design
/// lacks.
pub fn draw(input: &DrawingInput<'_>, formats: &[LaserFile], outputs: &mut Outputs) -> Result<(), ExportError> {
    let unwritten = draw_with(input, formats, None, outputs)?;
    unwritten.into_iter().next().map_or(Ok(()), |first| Err(first.error))
}

/// Same as [`draw`], with pixels of `pixel_um` micrometres in a height map, or of the default size if `None`. Returns
/// the formats that cannot be written, and adds the files of all other formats.
///
/// # Errors
/// [`ExportError`] for errors that affect every format: an invalid laser or depth, no cavity on the specimen, or far
/// too many.
pub fn draw_with(
    input: &DrawingInput<'_>,
    formats: &[LaserFile],
    pixel_um: Option<f64>,
    outputs: &mut Outputs,
) -> Result<Vec<Unwritten>, ExportError> {
    let layout = input.outline.layout(input.pattern)?;
    input.laser.validate()?;
    input.laser.check_depth(input.pattern.depth_m())?;
    let drawing = Arc::new(Drawing::new(input, layout));
    let mut unwritten = Vec::new();
    for (place, &format) in formats.iter().enumerate() {
        if formats[..place].contains(&format) {
            continue;
        }
        if let Err(error) = add(format, input, &drawing, pixel_um, outputs) {
            unwritten.push(Unwritten { format, error });
        }
    }
    Ok(unwritten)
}

/// Adds the file of `format` to `outputs`; adds nothing on an error.
fn add(
    format: LaserFile,
    input: &DrawingInput<'_>,
    drawing: &Arc<Drawing>,
    pixel_um: Option<f64>,
    outputs: &mut Outputs,
) -> Result<(), ExportError> {
    let (layout, laser, drawing) = (drawing.layout, input.laser, Arc::clone(drawing));
    match format {
        LaserFile::Dxf => outputs.add_stream("pattern.dxf", move |to| drawing.write(to, dxf)),
        LaserFile::Svg => outputs.add_stream("pattern.svg", move |to| drawing.write(to, svg)),
        LaserFile::Csv => {
            let bursts = laser.bursts(input.pattern.depth_m());
            outputs.add_stream("pattern.csv", move |to| csv(&layout, bursts, to));
        }
        LaserFile::Corners => outputs.add_stream("corners.csv", move |to| corners_csv(&layout, to)),
        LaserFile::Hatch => {
            let marking = Marking::of_lines(&laser, "hatch.csv")?;
            outputs.add_stream("hatch.csv", move |to| hatch_csv(&layout, &marking, to));
        }
        LaserFile::Plt => {
            // Contours without a hatch make a valid plot too.
            let hatched = laser.spot_um.is_some() && !laser.is_mask();
            let marking = hatched.then(|| Marking::new(&laser)).transpose()?;
            outputs.add_stream("pattern.plt", move |to| {
                drawing.write(to, |layout, heading, to| hpgl(layout, marking.as_ref(), heading, to))
            });
        }
        LaserFile::Gcode => {
            let plan = GcodePlan::new(&laser, Removal::new(&layout, &laser).map_or(1, |removal| removal.passes))?;
            outputs.add_stream("pattern.gcode", move |to| {
                drawing.write(to, |layout, heading, to| gcode(layout, &plan, heading, to))
            });
        }
        LaserFile::Png => {
            let map = HeightMap::new(&layout, &laser, pixel_um)?;
            outputs.add_stream("height-map.png", move |to| {
                drawing.write(to, |layout, heading, to| height_map(layout, &map, heading, to))
            });
        }
        LaserFile::Stl => {
            check_stl(&layout, &laser)?;
            outputs.add_stream("removed.stl", move |to| {
                drawing.write(to, |layout, heading, to| stl(layout, &laser, heading, to))
            });
        }
        LaserFile::Process => {
            let sheet = ProcessSheet::new(&layout, process_input(input))?;
            outputs.add("process.toml", sheet.to_toml()?);
        }
    }
    Ok(())
}

/// Draws the files of the next samples to cut, `found` for `task`. Returns one set of files per sample; if the samples
/// are sectors of one specimen, returns a single set, with a file of trials to fill in.
///
/// # Errors
/// Same as [`draw`].
pub fn draw_next(found: &NextTrials, task: &DesignTask) -> Result<Vec<Outputs>, ExportError> {
    let input = |name, pattern: &Pattern| DrawingInput {
        name,
        version: VERSION,
        seed: task.search.seed,
        pattern: *pattern,
        outline: task.specimen,
        laser: task.laser,
        tolerances: task.assumed_tolerances(),
        material: &found.report.material,
    };
    let drawn = |drawing: &dyn Fn(&mut Outputs) -> Result<(), ExportError>| {
        let mut outputs = Outputs::default();
        drawing(&mut outputs).map(|()| outputs)
    };
    match (&found.report.one_disc, found.patterns.first()) {
        (Some(disc), Some(first)) => {
            let input = input(&disc.name, first);
            Ok(vec![drawn(&|outputs| draw_sectors(&found.sectors, &input, outputs))?])
        }
        _ => {
            let each =
                |pattern| drawn(&|outputs| draw(&input(&found.report.name, pattern), &LaserFile::ALWAYS, outputs));
            found.patterns.iter().map(each).collect()
        }
    }
}

/// Adds the files of `sectors` to `outputs`, each with the metadata of `input`.
fn draw_sectors(sectors: &[Sector], input: &DrawingInput<'_>, outputs: &mut Outputs) -> Result<(), ExportError> {
    let laser = input.laser;
    laser.validate()?;
    sectors.iter().try_for_each(|sector| laser.check_depth(sector.pattern().depth_m()))?;
    let sheet = SectorsSheet::new(sectors, process_input(input))?;
    let patterns: Vec<Pattern> = sectors.iter().map(|sector| *sector.pattern()).collect();
    let densities: Vec<f64> = sectors.iter().map(Sector::areal_density).collect();
    let drawing = Arc::new((sectors.to_vec(), notes(input.material), input.name.to_owned(), input.version.to_owned()));
    for (name, is_dxf) in [("pattern.dxf", true), ("pattern.svg", false)] {
        let drawing = Arc::clone(&drawing);
        outputs.add_stream(name, move |to| {
            let (sectors, notes, name, version) = &*drawing;
            let heading = Heading { name, version, notes };
            if is_dxf {
                dxf_of_sectors(sectors, &laser, &heading, to)
            } else {
                svg_of_sectors(sectors, &laser, &heading, to)
            }
        });
    }
    outputs.add("process.toml", sheet.to_toml()?);
    outputs.add("trials.toml", sector_trials(input.name, &patterns, &densities));
    Ok(())
}

/// Converts `input` to the input of the process sheet.
fn process_input(input: &DrawingInput<'_>) -> ProcessInput {
    ProcessInput {
        name: input.name.to_owned(),
        version: input.version.to_owned(),
        schema: SCHEMA,
        seed: input.seed,
        laser: input.laser,
        tolerances: input.tolerances.clone(),
        material: MaterialNote {
            name: input.material.name.clone(),
            source: input.material.source.clone(),
            synthetic_surface: input.material.synthetic_surface,
        },
    }
}

fn notes(material: &Provenance) -> Vec<&'static str> {
    let note = "the area law behind this design rests on a synthetic surface";
    if material.synthetic_surface { vec![note] } else { Vec::new() }
}

/// Layout of the pattern on the specimen, with the metadata that drawings state.
struct Drawing {
    layout: Layout,
    name: String,
    version: String,
    notes: Vec<&'static str>,
}

impl Drawing {
    fn new(input: &DrawingInput<'_>, layout: Layout) -> Self {
        let notes = notes(input.material);
        Self { layout, name: input.name.to_owned(), version: input.version.to_owned(), notes }
    }

    fn write(
        &self,
        to: &mut dyn Write,
        format: impl FnOnce(&Layout, &Heading<'_>, &mut dyn Write) -> io::Result<()>,
    ) -> io::Result<()> {
        format(&self.layout, &Heading { name: &self.name, version: &self.version, notes: &self.notes }, to)
    }
}
