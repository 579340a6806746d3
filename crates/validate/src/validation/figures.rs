//! Figures of the source paper, computed by this model: contact area, interface pressure and friction in time.

use slipgrid_infer::calibrate::uncertainty::Slopes;
use slipgrid_model::material::LocalFriction;
use slipgrid_model::pattern::Pattern;
use slipgrid_model::springblock::{Extent, Fidelity, RunOptions, Scene, Simulation, simulate};

use super::laws::ScaledLaw;
use super::laws::ScaledLaws;
use super::model::{knowledge, scene, squares};
use super::ratios::{ModelledRatio, Pair, RatioReport};
use super::report::{TimeReport, ValidationReport};
use super::tables::solutions;
use super::{ValidationTask, page, rims};
use crate::Failure;
use slipgrid_base::monitor::{Monitor, Stage, Unwatched};
use slipgrid_base::units::{LENGTH_UM, PRESSURE_MPA, SPEED_MM_S, tidy};
use slipgrid_design::Solved;
use slipgrid_design::results::{PressureErrors, Table, fixed};
use slipgrid_report::charts::{
    self, AreaPoint, ChartError, Estimate, Series, Trace, area_law, friction_trace, interface_pressure,
};
use slipgrid_report::pictures::{cavities_um, interface_map, pressures, trace};
use slipgrid_report::{Outputs, csv};

/// Ratio of static to dynamic local coefficient, which measured dynamic friction does not determine: from the published
/// pair 0.30 and 0.27.
const STATIC_OVER_DYNAMIC: f64 = 0.30 / 0.27;

/// Input of the figures of a validation.
pub struct Figures<'a> {
    pub task: &'a ValidationTask<'a>,
    pub surface: &'a ScaledLaws,
    pub report: &'a ValidationReport,
    /// Measurements at the highest compared load.
    pub heaviest: Pair,
}

impl Figures<'_> {
    /// Adds the pictures, and tables of the drawn numbers, to `outputs`. Returns the results of the transient run;
    /// `None` if no run was requested.
    ///
    /// # Errors
    /// [`Failure`] if the numbers make no valid scene or a picture cannot be drawn.
    pub fn draw(&self, outputs: &mut Outputs, monitor: &dyn Monitor) -> Result<Option<TimeReport>, Failure> {
        if let Some(picture) = self.areas()? {
            outputs.add("area-law.svg", picture);
            outputs.add("area-law.csv", areas_csv(&self.report.area_laws));
        }
        let groove = self.task.patterns.modelled;
        let sample = self.scene(groove, Fidelity::Steady, Extent::Sample)?;
        let steady = self.solve(&sample, &Unwatched)?;
        monitor.heed()?;
        self.interface(&sample, &steady, outputs)?;
        if self.report.has_squares() {
            let cell = self.scene(squares(&groove), Fidelity::Steady, Extent::Cell)?;
            let solid = self.solve(&cell, &Unwatched)?;
            for load in &solid.loads {
                if let Some(map) = interface_map(&cell, load, self.load_mpa())? {
                    outputs.add("interface-squares.svg", map);
                }
            }
        }
        let Some(sliding_m) = self.task.sliding_m else { return Ok(None) };
        let mut scene = self.scene(groove, Fidelity::Dynamic, Extent::Sample)?;
        scene.run.sliding_m = sliding_m;
        let progress = Stage::new(monitor, "friction in time", None);
        let simulation = self.solve(&scene, &progress);
        let wall_s = progress.finish();
        monitor.heed()?;
        let simulation = simulation?;
        let knowledge = knowledge(self.task.body().modulus_relative_std, scene.area_law.as_ref(), &[self.heaviest]);
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

    /// Nominal pressure of the highest load in MPa, rounded to whole kilopascals, for titles.
    fn load_mpa(&self) -> f64 {
        (PRESSURE_MPA.from_si(self.heaviest.pressure_pa) * 1e3).round() / 1e3
    }

    /// Scene with `pattern` at the highest compared load. The local coefficients are such that the flat surface has the
    /// measured friction in steady sliding.
    fn scene(&self, pattern: Pattern, fidelity: Fidelity, extent: Extent) -> Result<Scene, Failure> {
        let body = self.task.body();
        let mut scene = scene(body, self.surface.given(), pattern, &[self.heaviest])?;
        scene.run = RunOptions { fidelity, extent, ..RunOptions::default() };
        for load in &mut scene.loads {
            let (mean, relative_std) = (load.friction.dynamic_mean(), self.task.calibration.stated.relative_std);
            load.friction = LocalFriction::new(STATIC_OVER_DYNAMIC * mean, mean, relative_std)
                .map_err(|error| body.refuse(&error))?;
        }
        Ok(scene)
    }

    fn solve(&self, scene: &Scene, progress: &dyn Monitor) -> Result<Simulation, Failure> {
        simulate(scene, progress).map_err(|error| self.task.body().refuse(&error))
    }

    fn areas(&self) -> Result<Option<String>, Failure> {
        let tables = &self.report.area_laws;
        let Some(given) = tables.iter().find(|table| table.slope_factor == 1.0) else { return Ok(None) };
        let modelled = self.report.results.iter().flat_map(|row| &row.modelled);
        let peak_mpa = modelled.map(|modelled| modelled.peak_pressure_mpa).fold(0.0, f64::max);
        // Pressures up to the first tabulated pressure that no contact block exceeds.
        let shown = given.pressure_mpa.iter().take_while(|&&pressure| pressure < peak_mpa).count() + 1;
        let shown = shown.clamp(2.min(given.pressure_mpa.len()), given.pressure_mpa.len());
        let stated_mpa =
            self.task.calibration.stated.threshold_pa.map(|threshold_pa| tidy(PRESSURE_MPA.from_si(threshold_pa)));
        let at_threshold = stated_mpa.and_then(|threshold_mpa| {
            let row = given.pressure_mpa.iter().position(|&pressure| tidy(pressure) == threshold_mpa)?;
            Some([threshold_mpa, given.area_fraction[row]])
        });
        let points = |table: &ScaledLaw| -> Vec<AreaPoint> {
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
        let title = format!("Real contact area and the factor f{}", self.report.synthetic_words());
        Ok(Some(area_law(&title, &points(given), at_threshold, &others)?))
    }

    /// Adds pictures of the pressure under the whole sample and under the first periods, and a table.
    fn interface(&self, scene: &Scene, simulation: &Simulation, outputs: &mut Outputs) -> Result<(), Failure> {
        let Some(load) = simulation.loads.first() else { return Ok(()) };
        let cavities = cavities_um(scene, &load.surface.interface);
        let flat = load.flat.as_ref().map_or_else(Vec::new, |flat| pressures("flat", &flat.interface).points);
        let own = pressures("patterned", &load.surface.interface).points;
        if flat.is_empty() || own.is_empty() {
            return Ok(());
        }
        let load_mpa = self.load_mpa();
        let first_um = 3.0 * LENGTH_UM.from_si(self.task.patterns.modelled.pitch_m());
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

    fn time(&self, simulation: &Simulation, at: &PressureErrors, outputs: &mut Outputs) -> Result<(), Failure> {
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
            SPEED_MM_S.from_si(self.heaviest.flat.speed_m_s)
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
            status_flat: flat.status.name(),
            status_patterned: load.surface.status.name(),
            wall_s,
        })
    }
}

/// Adds to `outputs` the record, the tables and pictures of ratios, and the page, which embeds the pictures in
/// `outputs`.
///
/// # Errors
/// [`Failure`] if a picture cannot be drawn or a number has no JSON form.
pub fn add_report(report: &ValidationReport, outputs: &mut Outputs) -> Result<(), Failure> {
    outputs.add_record(report).map_err(|error| Failure::Failed(error.to_string()))?;
    outputs.add("ratios.csv", ratios_csv(report));
    outputs.add("ratios.svg", ratios(report)?);
    if let Some(rims) = &report.rims {
        outputs.add("rims.csv", rims::csv(rims));
        outputs.add("rims.svg", rims::picture(rims)?);
    }
    outputs.add("report.html", page::validation(report, outputs));
    Ok(())
}

/// Columns of [`ratios_csv`]: keys of a result in the record, and the depth of the cavities.
const RATIOS: &str = "force_n,pressure_mpa,speed_mm_s,humidity_pct,mu_flat,mu_flat_std,mu_patterned,mu_patterned_std,ratio,ratio_std,\
                      ratio_amontons_coulomb,depth_um,slope_factor,rms_slope,area_law_factor,dynamic_mean,ratio_groove,ratio_groove_std,\
                      ratio_square,ratio_square_std,ratio_square_estimate";

/// Formats the results as CSV: one row per condition and slope factor, and one row per condition for the measured depth
/// if it differs from the modelled depth.
fn ratios_csv(report: &ValidationReport) -> String {
    let mut text = format!("{RATIOS}\n");
    for (row, depth_um, modelled) in solutions(report) {
        let records = [serde_json::to_value(row), serde_json::to_value(modelled)].map(Result::unwrap_or_default);
        let cell = |key: &str| match key {
            "depth_um" => depth_um.to_string(),
            _ => {
                let number = records.iter().find_map(|record| record.get(key)?.as_f64());
                number.map_or_else(String::new, |number| number.to_string())
            }
        };
        text += &(RATIOS.split(',').map(cell).collect::<Vec<_>>().join(",") + "\n");
    }
    text
}

/// Draws measured and modelled ratios against pressure, at the speed and humidity of the first result.
fn ratios(report: &ValidationReport) -> Result<String, ChartError> {
    let rows = report.by_pressure();
    let Some(first) = rows.first() else { return Ok(String::new()) };
    let column = |factor: f64, of: fn(&ModelledRatio) -> (Option<f64>, Option<f64>)| -> Vec<Option<Estimate>> {
        let estimate = |row: &&RatioReport| {
            let (value, error) = of(row.at_slope(factor)?);
            Some(Estimate { value: value?, error })
        };
        rows.iter().map(estimate).collect()
    };
    let mut columns = Vec::new();
    // The surface as given and the two most different slope factors: more would be indistinguishable.
    let mut factors: Vec<f64> = [report.slope_factors.first(), Some(&1.0), report.slope_factors.last()]
        .into_iter()
        .flatten()
        .copied()
        .collect();
    factors.dedup();
    for factor in factors {
        let label = if factor == 1.0 { "grooves".to_owned() } else { format!("grooves, {factor} times the slope") };
        columns.push((label, column(factor, |at| (at.ratio_groove, at.ratio_groove_std))));
    }
    if report.has_squares() {
        columns.push(("squares, in space".to_owned(), column(1.0, |at| (at.ratio_square, at.ratio_square_std))));
    }
    let title = format!(
        "Patterned over flat, {} mm/s, {} % humidity{}",
        first.measured.speed_mm_s,
        first.measured.humidity_pct,
        report.synthetic_words()
    );
    beside_measured(
        &title,
        rows.iter().map(|row| [row.measured.pressure_mpa, row.measured.ratio, row.measured.ratio_std]),
        columns,
    )
}

/// Draws modelled ratios, one named series per model, beside measured ratios. Each of `measured` is a pressure in MPa,
/// a ratio and its standard deviation.
///
/// # Errors
/// [`ChartError`] if the picture cannot be drawn.
pub fn beside_measured(
    title: &str,
    measured: impl Iterator<Item = [f64; 3]>,
    modelled: Vec<(String, Vec<Option<Estimate>>)>,
) -> Result<String, ChartError> {
    let (pressure_mpa, measured): (Vec<f64>, Vec<_>) = measured
        .map(|[pressure, value, error]| ((pressure * 1e3).round() / 1e3, Some(Estimate { value, error: Some(error) })))
        .unzip();
    let measured = ("measured (bars: ± one standard deviation)".to_owned(), measured);
    let series: Vec<_> = std::iter::once(measured).chain(modelled).collect();
    charts::ratios(title, &pressure_mpa, &series)
}

fn areas_csv(tables: &[ScaledLaw]) -> String {
    let rows = tables.iter().flat_map(|law| (0..law.pressure_mpa.len()).map(move |row| (law, row)));
    let rows: Vec<(&ScaledLaw, usize)> = rows.collect();
    let mut table = Table::of(&rows);
    table.numbers("slope_factor", |(law, _)| law.slope_factor);
    table.numbers("rms_slope", |(law, _)| law.rms_slope);
    table.numbers("pressure_mpa", |(law, row)| law.pressure_mpa[*row]);
    table.column("area_fraction", |(law, row)| fixed(Some(law.area_fraction[*row]), 6));
    table.column("factor", |(law, row)| fixed(Some(law.factor[*row]), 6));
    table.table().csv()
}

#[cfg(test)]
mod tests {
    use super::super::report_for_tests::report;
    use super::*;

    #[test]
    fn the_columns_of_the_ratios_are_keys_of_the_record() {
        let text = ratios_csv(&report());
        let row = text.lines().nth(2).unwrap();
        let cells = RATIOS.split(',').zip(row.split(','));
        let empty: Vec<&str> = cells.filter(|(_, cell)| cell.is_empty()).map(|(name, _)| name).collect();
        assert_eq!(empty, ["rms_slope", "ratio_groove_std", "ratio_square_std"]);
    }
}
