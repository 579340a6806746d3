//! Files for the laser, made from a design.

use std::io::{self, Write};
use std::sync::Arc;

use slipgrid_design::{DesignTask, NextTrials};
use slipgrid_io::formats::trials::sector_trials;
use slipgrid_laser::export::{
    ExportError, GcodePlan, Heading, HeightMap, Laser, Layout, Marking, ProcessInput, ProcessSheet, Removal, Sector,
    SectorsSheet, check_stl, corners_csv, csv, dxf, dxf_of_sectors, gcode, hatch_csv, height_map, hpgl, stl, svg,
    svg_of_sectors,
};
use slipgrid_model::material::Provenance;
use slipgrid_model::pattern::Pattern;

use crate::Outputs;
use slipgrid_design::results::{MadeBy, SCHEMA};
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
    /// All formats, in the order of the variants, with what [`Self::described`] returns.
    pub const EACH: [(Self, [&'static str; 2]); 10] = [
        (Self::Dxf, ["dxf", "pattern.dxf, drawing for the laser"]),
        (Self::Svg, ["svg", "pattern.svg, picture to scale"]),
        (Self::Csv, ["csv", "pattern.csv, one row per cavity"]),
        (Self::Process, ["process", "process.toml, process sheet"]),
        (Self::Plt, ["plt", "pattern.plt, HP-GL/2 plot with contours and lines"]),
        (Self::Gcode, ["gcode", "pattern.gcode, program for controllers with a laser mode"]),
        (Self::Corners, ["corners", "corners.csv, one row per corner"]),
        (Self::Hatch, ["hatch", "hatch.csv, one row per marked line"]),
        (Self::Png, ["png", "height-map.png, the surface as 16-bit grey"]),
        (Self::Stl, ["stl", "removed.stl, what is removed as closed solids"]),
    ];
    /// Formats that need only a pattern and a specimen; every search writes these formats.
    pub const ALWAYS: [Self; 4] = [Self::Dxf, Self::Svg, Self::Csv, Self::Process];

    /// Name of the format, and its file name with a description of the content.
    pub const fn described(self) -> [&'static str; 2] {
        Self::EACH[self as usize].1
    }
}

/// Pattern, specimen, laser and metadata from which the files are made.
pub struct DrawingInput {
    /// The pattern to cut.
    pub pattern: Pattern,
    /// The specimen, with the outline of its face.
    pub outline: Specimen,
    /// Laser and metadata.
    pub about: ProcessInput,
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
pub fn draw(input: &DrawingInput, formats: &[LaserFile], outputs: &mut Outputs) -> Result<(), ExportError> {
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
    input: &DrawingInput,
    formats: &[LaserFile],
    pixel_um: Option<f64>,
    outputs: &mut Outputs,
) -> Result<Vec<Unwritten>, ExportError> {
    let layout = input.outline.layout(input.pattern)?;
    input.about.laser.validate()?;
    check_bursts(&input.about.laser, &input.pattern)?;
    let drawing = Arc::new(Drawing { drawn: layout, about: input.about.clone() });
    let mut unwritten = Vec::new();
    for (place, &format) in formats.iter().enumerate() {
        if formats[..place].contains(&format) {
            continue;
        }
        if let Err(error) = add(format, &drawing, pixel_um, outputs) {
            unwritten.push(Unwritten { format, error });
        }
    }
    Ok(unwritten)
}

/// Adds the file of `format` to `outputs`; adds nothing on an error.
fn add(
    format: LaserFile,
    drawing: &Arc<Drawing<Layout>>,
    pixel_um: Option<f64>,
    outputs: &mut Outputs,
) -> Result<(), ExportError> {
    let (layout, laser, drawing) = (drawing.drawn, drawing.about.laser, Arc::clone(drawing));
    match format {
        LaserFile::Dxf => outputs.add_stream("pattern.dxf", move |to| drawing.write(to, dxf)),
        LaserFile::Svg => outputs.add_stream("pattern.svg", move |to| drawing.write(to, svg)),
        LaserFile::Csv => {
            let bursts = laser.bursts(layout.pattern().depth_m());
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
            let sheet = ProcessSheet::new(&layout, drawing.about.clone())?;
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
    let about = |name: &str| about(task, name, &found.report.material);
    if let Some(disc) = &found.report.one_disc {
        return Ok(vec![draw_sectors(&found.sectors, about(&disc.name))?]);
    }
    let of_pattern = |pattern: &Pattern| {
        let input = DrawingInput { pattern: *pattern, outline: task.specimen, about: about(&found.report.name) };
        let mut outputs = Outputs::default();
        draw(&input, &LaserFile::ALWAYS, &mut outputs).map(|()| outputs)
    };
    found.patterns.iter().map(of_pattern).collect()
}

/// Laser and metadata that the drawings of `task` state, under `name` and cut in `material`.
pub(crate) fn about(task: &DesignTask, name: &str, material: &Provenance) -> ProcessInput {
    ProcessInput {
        name: name.to_owned(),
        made_by: MadeBy::slipgrid(SCHEMA),
        seed: task.search.seed,
        laser: task.laser,
        tolerances: task.assumed_tolerances(),
        material: material.clone(),
    }
}

/// Checks that the depth of `pattern` is whole bursts. Of passes the sheet tells the speed that makes any depth.
fn check_bursts(laser: &Laser, pattern: &Pattern) -> Result<(), ExportError> {
    if laser.has_passes() { Ok(()) } else { laser.check_depth(pattern) }
}

/// Files of `sectors`, each with the metadata `about` the specimen.
fn draw_sectors(sectors: &[Sector], about: ProcessInput) -> Result<Outputs, ExportError> {
    let mut outputs = Outputs::default();
    let laser = about.laser;
    laser.validate()?;
    sectors.iter().try_for_each(|sector| check_bursts(&laser, sector.pattern()))?;
    let sheet = SectorsSheet::new(sectors, about.clone())?;
    let patterns: Vec<Pattern> = sectors.iter().map(|sector| *sector.pattern()).collect();
    let densities: Vec<f64> = sectors.iter().map(Sector::areal_density).collect();
    let trials = sector_trials(&about.name, &patterns, &densities);
    let of_dxf = Arc::new(Drawing { drawn: sectors.to_vec(), about });
    let of_svg = Arc::clone(&of_dxf);
    outputs.add_stream("pattern.dxf", move |to| {
        of_dxf.write(to, |sectors, heading, to| dxf_of_sectors(sectors, &laser, heading, to))
    });
    outputs.add_stream("pattern.svg", move |to| {
        of_svg.write(to, |sectors, heading, to| svg_of_sectors(sectors, &laser, heading, to))
    });
    outputs.add("process.toml", sheet.to_toml()?);
    outputs.add("trials.toml", trials);
    Ok(outputs)
}

/// Layout of a pattern, or sectors, to draw, with the laser and the metadata that drawings state.
struct Drawing<T> {
    drawn: T,
    about: ProcessInput,
}

impl<T> Drawing<T> {
    fn write(
        &self,
        to: &mut dyn Write,
        format: impl FnOnce(&T, &Heading<'_>, &mut dyn Write) -> io::Result<()>,
    ) -> io::Result<()> {
        let ProcessInput { name, made_by, material, .. } = &self.about;
        let note = material.synthetic_surface.then_some("the area law behind this design rests on a synthetic surface");
        format(&self.drawn, &Heading { name, version: &made_by.version, notes: note.as_slice() }, to)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_format_is_described_by_its_own_row() {
        for (file, described) in LaserFile::EACH {
            assert_eq!(file.described(), described);
        }
    }
}
