//! Figures of the source, computed by this model: contact area, interface pressure and friction in time.

use std::path::Path;

use slipgrid_infer::calibrate::uncertainty::Slopes;
use slipgrid_model::material::{AreaLaw, LocalFriction};
use slipgrid_model::pattern::Pattern;
use slipgrid_model::springblock::{Extent, Fidelity, Layer, Load, RunOptions, Scene, Simulation, simulate};

use super::laws::ScaledLaw;
use super::model::{FlatPoint, knowledge, squares};
use super::report::{AreaTable, TimeReport};
use crate::StudyError;
use slipgrid_base::monitor::{Monitor, Stage, Unwatched};
use slipgrid_base::units::{LENGTH_UM, PRESSURE_MPA, SPEED_MM_S, tidy};
use slipgrid_design::Solved;
use slipgrid_design::results::PressureErrors;
use slipgrid_design::results::fixed;
use slipgrid_io::formats::Diagnostic;
use slipgrid_io::formats::calibration::Calibration;
use slipgrid_report::Outputs;
use slipgrid_report::charts::{AreaPoint, Series, Trace, area_law, friction_trace, interface_pressure};
use slipgrid_report::csv;
use slipgrid_report::pictures::{cavities_um, interface_map, pressures, trace};

/// Static over dynamic local coefficient if only dynamic friction was measured: the published pair, 0.30 and 0.27.
const STATIC_OVER_DYNAMIC: f64 = 0.30 / 0.27;

/// Input of the figures.
pub struct Figures<'a> {
    pub path: &'a Path,
    pub calibration: &'a Calibration,
    /// Modelled layer, and the specimen behind it.
    pub layer: Layer,
    /// Square cavities are shown.
    pub squares: bool,
    pub laws: &'a [ScaledLaw],
    pub pattern: Pattern,
    /// Highest compared load.
    pub heaviest: FlatPoint,
    /// Maximum local pressure of the modelled grooves, in pascals, up to which the area law is drawn.
    pub peak_pa: f64,
    /// Travel of the transient run, in metres; `None` for no run.
    pub sliding_m: Option<f64>,
    pub synthetic: bool,
}

impl Figures<'_> {
    /// Adds every picture with its numbers to `outputs`; returns the results of the transient run.
    ///
    /// # Errors
    /// [`StudyError`] if the numbers make no valid scene or a picture cannot be drawn.
    pub fn draw(&self, outputs: &mut Outputs, monitor: &dyn Monitor) -> Result<Option<TimeReport>, StudyError> {
        if let Some(picture) = self.areas()? {
            outputs.add("area-law.svg", picture);
            outputs.add("area-law.csv", areas_csv(&area_tables(self.laws)));
        }
        let sample = self.scene(self.pattern, Fidelity::Steady, Extent::Sample)?;
        let steady = self.solve(&sample, &Unwatched)?;
        monitor.heed()?;
        self.interface(&sample, &steady, outputs)?;
        if self.squares {
            let cell = self.scene(squares(&self.pattern), Fidelity::Steady, Extent::Cell)?;
            let solid = self.solve(&cell, &Unwatched)?;
            for load in &solid.loads {
                if let Some(map) = interface_map(&cell, load, self.load_mpa())? {
                    outputs.add("interface-squares.svg", map);
                }
            }
        }
        let Some(sliding_m) = self.sliding_m else { return Ok(None) };
        let mut scene = self.scene(self.pattern, Fidelity::Dynamic, Extent::Sample)?;
        scene.run.sliding_m = sliding_m;
        let progress = Stage::new(monitor, "friction in time", None);
        let simulation = self.solve(&scene, &progress);
        let wall_s = progress.finish();
        monitor.heed()?;
        let simulation = simulation?;
        let knowledge = knowledge(self.calibration.modulus_relative_std(), scene.area_law.as_ref(), &[self.heaviest]);
        let slopes = Slopes::new(&scene, &knowledge);
        let solved = Solved { scene: &scene, simulation: &simulation, knowledge: &knowledge, slopes: &slopes };
        let errors = solved.errors();
        let Some(at) = errors.first() else { return Ok(None) };
        self.time(&simulation, at, outputs)?;
        if let Some(trace) = csv::friction_trace(&simulation) {
            outputs.add("friction.csv", trace);
        }
        Ok(self.time_report(&scene, &simulation, at, wall_s))
    }

    /// Highest load in MPa, rounded to whole kilopascals, for titles.
    fn load_mpa(&self) -> f64 {
        (PRESSURE_MPA.from_si(self.heaviest.pressure_pa) * 1e3).round() / 1e3
    }

    fn law(&self) -> Option<&AreaLaw> {
        self.laws.iter().find(|law| law.slope_factor == 1.0).and_then(|law| law.law.as_ref())
    }

    /// Scene of the highest load on `pattern`, with the coefficients of the comparison: in steady sliding, the flat surface has the
    /// measured friction.
    fn scene(&self, pattern: Pattern, fidelity: Fidelity, extent: Extent) -> Result<Scene, StudyError> {
        let law = self.law();
        // mu_d = mu_flat / f(P)
        let dynamic_mean = self.heaviest.mu_flat / law.map_or(1.0, |law| law.factor(self.heaviest.pressure_pa));
        let refuse = |error: &dyn std::fmt::Display| Diagnostic::file(self.path, error.to_string());
        let friction =
            LocalFriction::new(STATIC_OVER_DYNAMIC * dynamic_mean, dynamic_mean, self.calibration.relative_std)
                .map_err(|error| refuse(&error))?;
        let scene = Scene {
            elastic: self.calibration.elastic,
            area_law: law.cloned(),
            pattern: Some(pattern),
            relief: None,
            layer: self.layer,
            loads: vec![Load { pressure_pa: self.heaviest.pressure_pa, friction }],
            speed_m_s: self.heaviest.speed_m_s,
            run: RunOptions { fidelity, extent, ..RunOptions::default() },
        };
        scene.validate().map_err(|error| refuse(&error))?;
        Ok(scene)
    }

    fn solve(&self, scene: &Scene, progress: &dyn Monitor) -> Result<Simulation, StudyError> {
        simulate(scene, progress).map_err(|error| Diagnostic::file(self.path, error.to_string()).into())
    }

    fn areas(&self) -> Result<Option<String>, StudyError> {
        let tables = area_tables(self.laws);
        let Some(given) = tables.iter().find(|table| table.slope_factor == 1.0) else { return Ok(None) };
        let peak_mpa = PRESSURE_MPA.from_si(self.peak_pa);
        // Up to the first tabulated pressure that no block exceeds.
        let shown = given.pressure_mpa.iter().take_while(|&&pressure| pressure < peak_mpa).count() + 1;
        let shown = shown.clamp(2.min(given.pressure_mpa.len()), given.pressure_mpa.len());
        let stated_mpa = self.calibration.threshold_pa.map(|threshold_pa| tidy(PRESSURE_MPA.from_si(threshold_pa)));
        let at_threshold = stated_mpa.and_then(|threshold_mpa| {
            let row = given.pressure_mpa.iter().position(|&pressure| tidy(pressure) == threshold_mpa)?;
            Some([threshold_mpa, given.area_fraction[row]])
        });
        let points = |table: &AreaTable| -> Vec<AreaPoint> {
            let point = |row: usize| AreaPoint {
                pressure_mpa: given.pressure_mpa[row],
                area_fraction: table.area_fraction[row],
                factor: table.factor[row],
                ..AreaPoint::default()
            };
            (0..shown).map(point).collect()
        };
        let others: Vec<(String, Vec<AreaPoint>)> = tables
            .iter()
            .filter(|table| table.slope_factor != 1.0)
            .map(|table| (format!("{} times the slope", table.slope_factor), points(table)))
            .collect();
        let synthetic = if self.synthetic { " (synthetic surface)" } else { "" };
        let title = format!("Real contact area and the factor f{synthetic}");
        Ok(Some(area_law(&title, &points(given), at_threshold, &others)?))
    }

    /// Adds the pressure under the whole sample, and a close-up under its first periods.
    fn interface(&self, scene: &Scene, simulation: &Simulation, outputs: &mut Outputs) -> Result<(), StudyError> {
        let Some(load) = simulation.loads.first() else { return Ok(()) };
        let cavities = cavities_um(scene, &load.surface.interface);
        let flat = load.flat.as_ref().map_or_else(Vec::new, |flat| pressures("flat", &flat.interface).points);
        let own = pressures("patterned", &load.surface.interface).points;
        if flat.is_empty() || own.is_empty() {
            return Ok(());
        }
        let load_mpa = self.load_mpa();
        let first_um = 3.0 * LENGTH_UM.from_si(self.pattern.pitch_m());
        let whole = format!("Interface pressure at {load_mpa} MPa: whole sample");
        let near = format!("Interface pressure at {load_mpa} MPa: left end and first cavities");
        for (name, title, end_um) in [("interface.svg", whole, f64::INFINITY), ("interface-end.svg", near, first_um)] {
            let upto = |points: &[[f64; 2]]| -> Vec<[f64; 2]> {
                points.iter().copied().filter(|[x_um, _]| *x_um <= end_um).collect()
            };
            let shown: Vec<[f64; 2]> = cavities.iter().copied().filter(|[_, to_um]| *to_um <= end_um).collect();
            let surfaces = [("flat", &flat), ("patterned", &own)];
            let surfaces = surfaces.map(|(label, points)| Series { label, points: upto(points) });
            outputs.add(name, interface_pressure(&title, &surfaces, &shown, load_mpa)?);
        }
        outputs.add("interface.csv", csv::interface(simulation));
        Ok(())
    }

    fn time(&self, simulation: &Simulation, at: &PressureErrors, outputs: &mut Outputs) -> Result<(), StudyError> {
        let Some(load) = simulation.loads.first() else { return Ok(()) };
        let flat = load.flat.as_ref().zip(at.mu_flat.as_ref()).map(|(flat, error)| trace("flat", flat, error.std));
        let own = trace("patterned", &load.surface, at.mu.std);
        let traces: Vec<Trace<'_>> = flat.into_iter().chain([own]).collect();
        if traces.iter().all(|trace| trace.series.points.is_empty()) {
            return Ok(());
        }
        let title = format!(
            "Friction in time, from rest: {} MPa, {} mm/s",
            self.load_mpa(),
            SPEED_MM_S.from_si(self.heaviest.speed_m_s)
        );
        outputs.add("friction.svg", friction_trace(&title, &traces, "mean over the window")?);
        Ok(())
    }

    fn time_report(
        &self,
        scene: &Scene,
        simulation: &Simulation,
        at: &PressureErrors,
        wall_s: f64,
    ) -> Option<TimeReport> {
        let load = simulation.loads.first()?;
        let flat = load.flat.as_ref()?;
        let friction = scene.loads.first()?.friction;
        Some(TimeReport {
            pressure_mpa: PRESSURE_MPA.from_si(load.pressure_pa),
            speed_mm_s: SPEED_MM_S.from_si(scene.speed_m_s),
            sliding_um: LENGTH_UM.from_si(scene.run.sliding_m),
            static_mean: tidy(friction.static_mean()),
            dynamic_mean: tidy(friction.dynamic_mean()),
            relative_std: friction.relative_std(),
            mu_flat: flat.mu_dynamic,
            mu_flat_stderr: flat.mu_dynamic_stderr,
            mu_flat_std: at.mu_flat.as_ref().and_then(|of| of.std),
            mu_static_flat: flat.mu_static,
            mu_static_flat_std: at.mu_static_flat.as_ref().and_then(|of| of.std),
            mu_patterned: load.surface.mu_dynamic,
            mu_patterned_stderr: load.surface.mu_dynamic_stderr,
            mu_patterned_std: at.mu.std,
            mu_static_patterned: load.surface.mu_static,
            mu_static_patterned_std: at.mu_static.as_ref().and_then(|of| of.std),
            ratio: load.ratio(),
            ratio_stderr: load.ratio_stderr,
            ratio_std: at.ratio.as_ref().and_then(|of| of.std),
            status_flat: flat.status.name().into(),
            status_patterned: load.surface.status.name().into(),
            wall_s,
        })
    }
}

/// Area and factor of every surface at the tabulated pressures.
pub fn area_tables(laws: &[ScaledLaw]) -> Vec<AreaTable> {
    // A measured law has no contact area.
    laws.iter()
        .filter(|scaled| !scaled.areas.is_empty())
        .filter_map(|scaled| {
            let law = scaled.law.as_ref()?;
            Some(AreaTable {
                slope_factor: scaled.slope_factor,
                rms_slope: scaled.rms_slope,
                pressure_mpa: scaled.areas.iter().map(|point| tidy(PRESSURE_MPA.from_si(point.pressure_pa))).collect(),
                area_fraction: scaled.areas.iter().map(|point| point.area_fraction_corrected).collect(),
                factor: scaled.areas.iter().map(|point| law.factor(point.pressure_pa)).collect(),
            })
        })
        .collect()
}

fn areas_csv(tables: &[AreaTable]) -> String {
    let mut text = String::from("slope_factor,rms_slope,pressure_mpa,area_fraction,factor\n");
    for table in tables {
        let slope = table.rms_slope.map_or_else(String::new, |slope| slope.to_string());
        for ((pressure, area), factor) in table.pressure_mpa.iter().zip(&table.area_fraction).zip(&table.factor) {
            text += &format!(
                "{},{slope},{pressure},{},{}\n",
                table.slope_factor,
                fixed(Some(*area), 6),
                fixed(Some(*factor), 6)
            );
        }
    }
    text
}
