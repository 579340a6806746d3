//! Points of the explorer's map: the design found, trade-offs and trials.

use serde::Serialize;
use slipgrid_base::units::{HUMIDITY_PCT, LENGTH_UM, PRESSURE_MPA, SPEED_MM_S, tidy};
use slipgrid_design::optimize::Quantity;
use slipgrid_design::results::PatternReport;
use slipgrid_infer::discrepancy::{Features, Trial};
use slipgrid_model::pattern::{Pattern, Texture};

use super::explorer::Subject;
use super::page::{number, plain};
use crate::charts::is_at_condition;

/// Maximum relative difference of features at which a trial counts as having the design's texture; allows for rounding
/// only.
const ALIKE: f64 = 1e-6;
/// Relative tolerance of the test whether a point lies within the bounds of the map.
const ROOM: f64 = 1e-6;

/// Describes the condition with sliding speed `speed_m_s` and relative humidity `humidity`, from 0 to 1.
pub(super) fn in_words(speed_m_s: f64, humidity: f64) -> String {
    let [speed_mm_s, humidity_pct] = [SPEED_MM_S.from_si(speed_m_s), HUMIDITY_PCT.from_si(humidity)];
    format!("{} mm/s, {} %", plain(tidy(speed_mm_s)), plain(tidy(humidity_pct)))
}

/// Point on the explorer's map.
#[derive(Serialize)]
pub(super) struct Point {
    /// Kind of the point: `found`, `trade-off` or `trial`.
    pub kind: &'static str,
    /// Width, spacing and depth of the texture, in micrometres.
    pub at: [f64; 3],
    /// Whether the map shows the point: its lengths lie within the bounds, and its texture is that of the task.
    pub on_map: bool,
    #[serde(skip)]
    pub name: String,
    #[serde(skip)]
    pub measured: String,
}

impl Subject<'_> {
    /// Points of the design and the trade-offs found, and of the trials of the material.
    pub(super) fn points(&self) -> Vec<Point> {
        let lengths = |of: &PatternReport| [of.width_um, of.spacing_um, of.depth_um];
        let point = |kind, at, name: String| Point { kind, at, on_map: self.holds(&at), name, measured: String::new() };
        let found =
            self.report.map(|report| point("found", lengths(&report.sample.design), "the design found".to_owned()));
        let listed = self.report.and_then(|report| report.trade_offs.as_ref()).map_or(&[][..], |found| &found.listed);
        let traded = listed
            .iter()
            .enumerate()
            .map(|(place, of)| point("trade-off", lengths(&of.design), format!("trade-off {}", place + 1)));
        let trials = self.material.uncertainty.learned.as_ref().map_or(&[][..], |learned| learned.trials());
        found.into_iter().chain(traded).chain(trials.iter().map(|trial| self.trial(trial))).collect()
    }

    /// Whether a design with width, spacing and depth `at`, in micrometres, lies within the bounds.
    fn holds(&self, at: &[f64; 3]) -> bool {
        let mut axes = self.explorer.expected.axes().iter().zip(at);
        axes.all(|(axis, length)| (axis.from * (1.0 - ROOM)..=axis.to * (1.0 + ROOM)).contains(length))
    }

    fn trial(&self, trial: &Trial) -> Point {
        let Features { width_m, pitch_m, depth_m, .. } = trial.features;
        let at = [width_m, pitch_m - width_m, depth_m].map(|m| tidy(LENGTH_UM.from_si(m)));
        let has_texture = is_of(self.task.space.texture(), &trial.features);
        let on_map = has_texture && self.holds(&at);
        // If the trial has loads at the design condition, only these are listed.
        let is_wanted = |load: &slipgrid_infer::discrepancy::Load| is_at_condition(self.task, load);
        let is_any = trial.measured.iter().any(|of| is_wanted(&of.load));
        let words = |of: &slipgrid_infer::discrepancy::Measured| {
            let mut condition = format!("{} MPa", number(PRESSURE_MPA.from_si(of.load.pressure_pa), 2));
            if !is_any {
                condition += &format!(", {}", in_words(of.load.speed_m_s, of.load.humidity));
            }
            let here = on_map.then(|| self.ratio(&at, of.load.pressure_pa)).flatten();
            let beside = here.map_or_else(
                || format!("modelled {}", number(of.modelled, 3)),
                |ratio| format!("expected {}", number(ratio, 3)),
            );
            format!("{} at {condition} ({beside})", number(of.measured, 3))
        };
        let measured: Vec<String> =
            trial.measured.iter().filter(|of| !is_any || is_wanted(&of.load)).map(words).collect();
        let outside = match (has_texture, on_map) {
            (false, _) => " (another texture)",
            (true, false) => " (beyond the sliders)",
            _ => "",
        };
        Point {
            kind: "trial",
            at,
            on_map,
            name: format!("trial {}{outside}", trial.name),
            measured: measured.join("; "),
        }
    }

    /// Expected ratio of patterned to flat friction at `pressure_pa` of the design with width, spacing and depth `at`,
    /// in micrometres. Linear between target pressures, like the curve on the page; `None` outside the range of target
    /// pressures.
    fn ratio(&self, at: &[f64; 3], pressure_pa: f64) -> Option<f64> {
        let pattern = self.task.space.pattern(at.map(|um| LENGTH_UM.to_si(um))).ok()?;
        let values = self.explorer.sample(&self.task.specimen.layout(pattern).ok()?).0;
        let pressure_mpa = PRESSURE_MPA.from_si(pressure_pa);
        let points = self.task.target.points().iter();
        let pressures: Vec<f64> = points.map(|point| PRESSURE_MPA.from_si(point.pressure_pa)).collect();
        let ratio = |load: usize| match self.task.target.quantity() {
            Quantity::Ratio => values.get(load).copied(),
            Quantity::DynamicFriction => Some(values.get(load)? / self.flat_mu.get(load)?),
        };
        let same = |load: &usize| (pressures[*load] / pressure_mpa - 1.0).abs() < 1e-3;
        if let Some(load) = (0..pressures.len()).find(same) {
            return ratio(load);
        }
        let by_pressure = |a: &usize, b: &usize| pressures[*a].total_cmp(&pressures[*b]);
        let lower = (0..pressures.len()).filter(|load| pressures[*load] < pressure_mpa).max_by(by_pressure)?;
        let upper = (0..pressures.len()).filter(|load| pressures[*load] > pressure_mpa).min_by(by_pressure)?;
        let t = (pressure_mpa - pressures[lower]) / (pressures[upper] - pressures[lower]);
        Some((1.0 - t) * ratio(lower)? + t * ratio(upper)?)
    }
}

/// Whether `features` are those of a pattern with `texture` and with the width, pitch and depth in `features`.
fn is_of(texture: &Texture, features: &Features) -> bool {
    let Ok(pattern) = Pattern::new(*texture, features.width_m, features.pitch_m - features.width_m, features.depth_m)
    else {
        return false;
    };
    let own = Features::from(&pattern);
    let alike = |a: f64, b: f64| (a / b - 1.0).abs() < ALIKE;
    alike(own.areal_density, features.areal_density) && alike(own.edge_1_m, features.edge_1_m)
}
