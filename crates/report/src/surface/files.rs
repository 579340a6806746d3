//! Files of an altitude map.

use slipgrid_base::monitor::Monitor;
use slipgrid_design::results::json;

use super::pictures::Measured;
use super::{SurfaceReport, cavities_csv, edge_profile_csv, edge_profile_svg, pictures, section_csv, spectrum_csv};
use crate::{Outputs, ReportError, html};

/// Names of the files, with `*` as a wildcard.
pub const FILES: [&str; 8] = [
    "report.html",
    "result.json",
    "map.svg",
    "histogram.svg",
    "section.*",
    "spectrum.*",
    "cavities.*",
    "edge-profile.*",
];

/// Makes the files of a map described by `report`: record, tables, pictures and page.
///
/// # Errors
/// [`ReportError`] if a picture cannot be drawn, if the record has no JSON form, or if `monitor` cancels.
pub fn files(report: &SurfaceReport, of: Measured<'_>, monitor: &dyn Monitor) -> Result<Outputs, ReportError> {
    let Measured { surface, spectrum, cavities, column, .. } = of;
    let mut outputs = Outputs::default();
    outputs.add("result.json", json(report)?);
    outputs.add("section.csv", section_csv(&surface.map, column));
    outputs.add("spectrum.csv", spectrum_csv(spectrum));
    if let Some(cavities) = cavities {
        outputs.add("cavities.csv", cavities_csv(cavities));
        outputs.add("edge-profile.csv", edge_profile_csv(&cavities.rim));
        if let Some(svg) = edge_profile_svg(&cavities.rim, surface.synthetic)? {
            outputs.add("edge-profile.svg", svg);
        }
    }
    pictures::add(&mut outputs, of, monitor)?;
    monitor.heed()?;
    let page = html::surface(report, &outputs);
    outputs.add("report.html", page);
    Ok(outputs)
}
