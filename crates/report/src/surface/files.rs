//! Files of an altitude map: record, tables, pictures and page.

use slipgrid_base::monitor::{Cancelled, Monitor};
use slipgrid_design::results::json;
use slipgrid_surface::topography::{
    CavityMetrology, CorrelationLengths, Decimation, DecimationMethod, HeightMap, MapError, MaterialRatioCurve,
    PreparedMap, SpectrumBin,
};

use super::cavities::{cavities_csv, edge_profile_csv, edge_profile_svg};
use super::{SurfaceReport, section_csv, spectrum_csv};
use crate::charts::{self, SurfaceValues};
use crate::{Failure, Outputs, html};

/// Names of the files of an altitude map, with `*` as a wildcard.
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

/// Maximum number of pixels of the drawn map along a side.
const MAX_PIXELS: usize = 700;
/// Number of classes of the histogram.
const CLASSES: usize = 80;
/// Number of line segments of the drawn bearing curve.
const CURVE_POINTS: u32 = 400;
/// Share of the points at each end of the height distribution that the colour scale excludes as spikes.
const SPIKES: f64 = 5e-4;

/// Measured map with its results.
pub struct Measured {
    /// The map.
    pub surface: PreparedMap,
    /// Cavities of the map, if they were detected.
    pub(super) cavities: Option<CavityMetrology>,
    /// Bearing curve of the map.
    pub(super) curve: MaterialRatioCurve,
    /// Correlation lengths of the map.
    pub(super) lengths: CorrelationLengths,
    /// Power spectrum of the map.
    pub(super) spectrum: Vec<SpectrumBin>,
}

impl Measured {
    /// Measures a map, whose `cavities` are known if they were detected.
    ///
    /// # Errors
    /// [`MapError`] for a map without spectrum, and if `monitor` cancels.
    pub fn new(
        surface: PreparedMap,
        cavities: Option<CavityMetrology>,
        monitor: &dyn Monitor,
    ) -> Result<Self, MapError> {
        let curve = MaterialRatioCurve::new(&surface.map, monitor)?;
        let lengths = surface.map.correlation_lengths(surface.sides(), monitor)?;
        let spectrum = surface.map.radial_spectrum(surface.sides(), monitor)?;
        Ok(Self { surface, cavities, curve, lengths, spectrum })
    }
}

/// Makes the files of a map described by `report`: record, tables, pictures and page. `column` is the index along y of
/// the pixels of the section, which runs along x.
///
/// # Errors
/// [`Failure`] if a picture cannot be drawn, if the record has no JSON form, or if `monitor` cancels.
pub fn files(report: &SurfaceReport, of: &Measured, column: usize, monitor: &dyn Monitor) -> Result<Outputs, Failure> {
    let Measured { surface, spectrum, cavities, .. } = of;
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
    add_pictures(&mut outputs, of, column, monitor)?;
    monitor.heed()?;
    let page = html::surface(report, &outputs);
    outputs.add("report.html", page);
    Ok(outputs)
}

/// Adds the pictures of the map, its heights, its section and its spectrum to `outputs`.
fn add_pictures(outputs: &mut Outputs, of: &Measured, column: usize, monitor: &dyn Monitor) -> Result<(), Failure> {
    let Measured { surface, curve, spectrum, .. } = of;
    let map = &surface.map;
    let titled = |title: &str| {
        if surface.synthetic { format!("{title} (synthetic surface)") } else { title.to_owned() }
    };
    let um = |length_m: f64| length_m * 1e6;

    let drawn = drawn(surface, monitor)?;
    let heights = SurfaceValues {
        values: &drawn.heights_m().iter().map(|&height| um(height)).collect::<Vec<f64>>(),
        columns: drawn.cols(),
        unit: "µm",
        scale: [um(curve.height_m(1.0 - SPIKES)), um(curve.height_m(SPIKES))],
        side_um: [um(map.dx_m() * map.rows() as f64), um(map.dy_m() * map.cols() as f64)],
    };
    let section_y_um = um((column as f64 + 0.5) * map.dy_m());
    // A map does not contain the sliding direction of its sample.
    outputs.add("map.svg", charts::surface_map(&titled("Altitude"), &heights, Some(section_y_um), None)?);

    monitor.heed()?;
    let core = curve.core();
    monitor.heed()?;
    let (lowest, highest) = (curve.height_m(1.0), curve.height_m(0.0));
    let edge = |class: usize| lowest + (highest - lowest) * class as f64 / CLASSES as f64;
    // The share between two heights is the difference of the shares above each.
    let shares: Vec<[f64; 2]> = (0..CLASSES)
        .map(|class| {
            // The lowest height belongs to the lowest class.
            let above_lower = if class == 0 { 1.0 } else { curve.ratio(edge(class)) };
            [um(0.5 * (edge(class) + edge(class + 1))), 100.0 * (above_lower - curve.ratio(edge(class + 1)))]
        })
        .collect();
    let bearing: Vec<[f64; 2]> = (0..=CURVE_POINTS)
        .map(|n| f64::from(n) / f64::from(CURVE_POINTS))
        .map(|ratio| [100.0 * ratio, um(curve.height_m(ratio))])
        .collect();
    let (title, class_um) = (titled("Heights and bearing curve"), um(highest - lowest) / CLASSES as f64);
    let core_um = [um(core.lower_m), um(core.upper_m)];
    outputs.add("histogram.svg", charts::height_histogram(&title, class_um, &shares, &bearing, core_um)?);

    let section: Vec<[f64; 2]> =
        (0..map.rows()).map(|i| [um(i as f64 * map.dx_m()), um(map.heights_m()[i * map.cols() + column])]).collect();
    let title = titled(&format!("Section at y = {section_y_um:.0} um"));
    outputs.add("section.svg", charts::section(&title, &section)?);

    let points: Vec<[f64; 2]> = spectrum
        .iter()
        .filter(|bin| bin.psd_m4 > 0.0)
        .map(|bin| [(bin.q_per_m * 1e-6).log10(), (bin.psd_m4 * 1e24).log10()])
        .collect();
    // A flat map has no spectrum.
    if !points.is_empty() {
        outputs.add("spectrum.svg", charts::spectrum(&titled("Power spectrum"), &points)?);
    }
    Ok(())
}

/// Coarsens the map for drawing; missing points stay missing.
fn drawn(surface: &PreparedMap, monitor: &dyn Monitor) -> Result<HeightMap, Cancelled> {
    let map = &surface.map;
    let factor = map.rows().max(map.cols()).div_ceil(MAX_PIXELS);
    // A long, narrow map keeps two pixels across.
    let factor = factor.min(map.rows().min(map.cols()) / 2).max(1);
    let mut heights = map.heights_m().to_vec();
    monitor.heed()?;
    for (height, _) in heights.iter_mut().zip(&surface.filled).filter(|(_, missing)| **missing) {
        *height = f64::NAN;
    }
    monitor.heed()?;
    let holed = HeightMap::new(map.rows(), map.cols(), map.dx_m(), map.dy_m(), heights);
    monitor.heed()?;
    let coarse =
        |holed: HeightMap| holed.windowed(None, Some(Decimation { factor, method: DecimationMethod::Mean })).ok();
    Ok(holed.ok().and_then(coarse).unwrap_or_else(|| map.clone()))
}
