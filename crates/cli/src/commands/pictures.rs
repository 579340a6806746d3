//! Pictures of results: from simulations and reports to what the charts draw.

use slipgrid_springblock::{LoadOutcome, Scene, Simulation, SurfaceOutcome};

use super::optimize::DesignReport;
use crate::CliError;
use crate::charts::{
    self, ChartError, Estimate, FrictionTraceChart, InterfacePressureChart, Series, TargetChart, TargetPoint, Trace,
    friction_trace, interface_pressure,
};
use crate::output::Outputs;
use crate::units::{LENGTH_UM, PRESSURE_MPA};

/// Shares of a cavity's pitch by which two contact blocks are one land: gaps wider than this many
/// block widths are cavities.
const CONTIGUOUS_BLOCKS: f64 = 1.5;

impl From<ChartError> for CliError {
    fn from(error: ChartError) -> Self {
        Self::Other(error.to_string())
    }
}

/// The surfaces of a load with their names, flat first.
fn surfaces(load: &LoadOutcome) -> Vec<(&'static str, &SurfaceOutcome)> {
    match &load.flat {
        Some(flat) => vec![("flat", flat), ("patterned", &load.surface)],
        None => vec![("flat", &load.surface)],
    }
}

/// Adds a picture of mu against time (dynamic runs) and one of the pressure along the interface
/// for every load.
///
/// # Errors
/// [`CliError::Other`] if a picture cannot be drawn.
pub fn simulation(scene: &Scene, simulation: &Simulation, outputs: &mut Outputs) -> Result<(), CliError> {
    for load in &simulation.loads {
        let load_mpa = PRESSURE_MPA.from_si(load.pressure_pa);
        let surfaces = surfaces(load);
        let finite = |points: Vec<[f64; 2]>| -> Vec<[f64; 2]> {
            points.into_iter().filter(|point| point.iter().all(|value| value.is_finite())).collect()
        };
        let traces: Vec<Vec<[f64; 2]>> = surfaces
            .iter()
            .map(|(_, surface)| finite(surface.trace.iter().map(|point| [point.time_s * 1e3, point.mu]).collect()))
            .collect();
        if traces.iter().any(|trace| !trace.is_empty()) {
            let traces: Vec<Trace<'_>> = surfaces
                .iter()
                .zip(&traces)
                .map(|(&(label, surface), points)| Trace {
                    series: Series { label, points },
                    // The mean reaches to the end of the trace.
                    window_ms: surface.averaged_from_s.zip(points.last()).map(|(from_s, end)| [from_s * 1e3, end[0]]),
                    mu_dynamic: surface.mu_dynamic,
                })
                .collect();
            let title = format!("Friction coefficient at {load_mpa} MPa");
            let chart = FrictionTraceChart { title: &title, traces: &traces };
            outputs.add(format!("friction-{load_mpa}mpa.svg"), friction_trace(&chart)?);
        }
        if scene.dimensions() == 3 {
            // A line along x says nothing of an interface that has two directions.
            continue;
        }
        let pressures: Vec<Vec<[f64; 2]>> = surfaces
            .iter()
            .map(|(_, surface)| {
                let point = |point: &slipgrid_springblock::InterfacePoint| {
                    [LENGTH_UM.from_si(point.x_m), PRESSURE_MPA.from_si(point.pressure_pa)]
                };
                finite(surface.interface.iter().map(point).collect())
            })
            .collect();
        if pressures.iter().any(|pressure| !pressure.is_empty()) {
            let series: Vec<Series<'_>> =
                surfaces.iter().zip(&pressures).map(|(&(label, _), points)| Series { label, points }).collect();
            let title = format!("Pressure along the interface at {load_mpa} MPa");
            let cavities = cavities_um(scene, &load.surface);
            let chart = InterfacePressureChart {
                title: &title,
                surfaces: &series,
                cavities_um: &cavities,
                nominal_mpa: Some(load_mpa),
            };
            outputs.add(format!("interface-{load_mpa}mpa.svg"), interface_pressure(&chart)?);
        }
    }
    Ok(())
}

/// Target, prediction and confirmation against pressure.
///
/// # Errors
/// [`CliError::Other`] if the picture cannot be drawn.
pub fn target(report: &DesignReport) -> Result<String, CliError> {
    let wanted = &report.target;
    let mut points: Vec<TargetPoint> = wanted
        .pressure_mpa
        .iter()
        .enumerate()
        .map(|(row, &pressure_mpa)| TargetPoint {
            pressure_mpa,
            value: wanted.value.as_ref().map(|values| values[row]),
            lowest: wanted.lowest[row],
            highest: wanted.highest[row],
        })
        .collect();
    points.sort_by(|a, b| a.pressure_mpa.total_cmp(&b.pressure_mpa));
    let mut predicted: Vec<[f64; 2]> =
        wanted.pressure_mpa.iter().zip(&report.predicted_value).map(|(&pressure, &value)| [pressure, value]).collect();
    predicted.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let mut confirmed: Vec<(f64, Estimate)> = report
        .confirmed
        .iter()
        .filter_map(|load| {
            Some((load.pressure_mpa, Estimate { value: report.value(load)?, error: report.stderr(load) }))
        })
        .collect();
    confirmed.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut flat: Vec<[f64; 2]> = report
        .confirmed
        .iter()
        .filter_map(|load| Some([load.pressure_mpa, if report.is_ratio() { 1.0 } else { load.mu_flat? }]))
        .collect();
    flat.sort_by(|a, b| a[0].total_cmp(&b[0]));
    Ok(charts::target(&TargetChart {
        title: &report.name,
        quantity: if report.is_ratio() {
            "Dynamic friction, patterned over flat"
        } else {
            "Dynamic friction coefficient"
        },
        target: &points,
        predicted: &predicted,
        confirmed: &confirmed,
        flat: &flat,
    })?)
}

/// The gaps between contact blocks of a patterned surface: its cavities, to within a block.
fn cavities_um(scene: &Scene, surface: &SurfaceOutcome) -> Vec<[f64; 2]> {
    if scene.pattern.is_none() {
        return Vec::new();
    }
    let block_m = scene.layer.block_m;
    surface
        .interface
        .windows(2)
        .filter(|pair| pair[1].x_m - pair[0].x_m > CONTIGUOUS_BLOCKS * block_m)
        .map(|pair| [pair[0].x_m + block_m / 2.0, pair[1].x_m - block_m / 2.0].map(|x_m| LENGTH_UM.from_si(x_m)))
        .collect()
}
