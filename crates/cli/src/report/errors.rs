//! One error beside every friction coefficient and ratio: what the run, the calibration and, where values are corrected
//! by it, the discrepancy leave open, with its parts kept apart.

use serde::Serialize;
use slipgrid_calibrate::uncertainty::{
    Deviation, Deviations, InputUncertainty, SamplingScatter, Slopes, sampling_scatter,
};
use slipgrid_springblock::{Extent, Fidelity, LoadOutcome, Scene, Simulation, SurfaceOutcome};

use slipgrid_calibrate::uncertainty::MaterialUncertainty;
use slipgrid_units::{PRESSURE_MPA, tidy};

/// Part of a run: how long it lasted.
const TIME_AVERAGE: &str = "time average";
/// The same of a mean over several draws, whose scatter its error comes from.
const TIME_AND_DRAWS: &str = "time average and local coefficients drawn";
/// Part of a run: which local coefficients it drew.
const DRAWS: &str = "local coefficients drawn";
/// Part of a run: what stands for the specimen as it is laid out.
const LAYOUT: &str = "layout on the specimen";
/// Part of a ratio: how far it is from that of vanishing blocks.
const BLOCKS: &str = "size of blocks";
/// Part of a run: what is behind the layer that it holds, added by the steady cell.
const BEHIND: &str = "specimen behind the layer";
/// Part of a static peak, which follows them at most one to one.
const STATIC: &str = "static coefficient";
/// The 97.5 % point of the normal distribution.
const NORMAL_95: f64 = 1.959_964;
/// What is open where slopes could not be computed.
const NO_SLOPES: &str = "what the material's errors make of friction: its neighbours cannot be computed";

/// Errors of the numbers of one scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ErrorsReport {
    /// What the errors combine, in words.
    pub meaning: String,
    /// What is in them.
    pub includes: Vec<String>,
    /// What is not, because the material does not say it.
    pub unknown: Vec<String>,
    /// One per pressure.
    pub by_pressure: Vec<PressureErrors>,
}

/// Values at one pressure, each with its error.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PressureErrors {
    /// Nominal pressure.
    pub pressure_mpa: f64,
    /// What a search took for its target's quantity.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub predicted: Option<ErrorReport>,
    /// Patterned over flat; of a patterned surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ratio: Option<ErrorReport>,
    /// Dynamic friction.
    pub mu: ErrorReport,
    /// Dynamic friction of the flat surface beside a patterned one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mu_flat: Option<ErrorReport>,
    /// Static friction, where the run has it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mu_static: Option<ErrorReport>,
    /// The same of the flat surface beside a patterned one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mu_static_flat: Option<ErrorReport>,
}

/// A value with one standard deviation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ErrorReport {
    /// The value; null where the run gave none.
    pub value: Option<f64>,
    /// All parts together; null where none is known.
    pub std: Option<f64>,
    /// Ends of the 95 % interval, which reaches farther to one side where Young's modulus decides; null where none is known.
    pub interval_95: Option<[f64; 2]>,
    /// Each part alone.
    pub parts: Vec<PartsReport>,
}

/// What one input alone would do.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PartsReport {
    /// The input.
    pub input: String,
    /// Standard deviation of the value.
    pub std: f64,
}

/// A solved scene and what is known of its material.
#[derive(Clone, Copy)]
pub struct Solved<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// What came of it.
    pub simulation: &'a Simulation,
    /// How well its material is known at its loads; with a discrepancy, ratio and friction are corrected by it.
    pub knowledge: &'a InputUncertainty,
    /// How its ratios follow that.
    pub slopes: &'a Slopes,
}

impl ErrorReport {
    /// `own` parts are independent of one another and of what the material leaves open.
    #[must_use]
    pub fn new(value: Option<f64>, own: Vec<PartsReport>, material: Option<&Deviation>) -> Self {
        let known = material.filter(|known| !known.parts.is_empty());
        let square =
            own.iter().map(|part| part.std.powi(2)).sum::<f64>() + known.map_or(0.0, |known| known.std.powi(2));
        let is_known = value.is_some() && (known.is_some() || !own.is_empty());
        let of_run = own.iter().map(|part| part.std.powi(2)).sum::<f64>() * NORMAL_95 * NORMAL_95;
        let interval = value.filter(|_| is_known).map(|value| {
            let [below, above] =
                known.map_or([0.0; 2], |known| known.reach_95).map(|reach| (reach * reach + of_run).sqrt());
            [tidy(value - below), tidy(value + above)]
        });
        let of_material = known.into_iter().flat_map(|known| &known.parts);
        let of_material = of_material.map(|&(source, std)| PartsReport { input: source.name().to_owned(), std });
        let parts =
            own.into_iter().chain(of_material).map(|part| PartsReport { std: tidy(part.std), ..part }).collect();
        Self { value: value.map(tidy), std: is_known.then(|| tidy(square.sqrt())), interval_95: interval, parts }
    }

    /// The part of the run itself: how long it lasted and what it drew.
    #[must_use]
    pub fn std_of_run(&self) -> f64 {
        let own = self
            .parts
            .iter()
            .filter(|part| [TIME_AVERAGE, TIME_AND_DRAWS, DRAWS, LAYOUT, BEHIND].contains(&part.input.as_str()));
        own.map(|part| part.std.powi(2)).sum::<f64>().sqrt()
    }
}

impl Solved<'_> {
    /// Values at each load with their errors.
    #[must_use]
    pub fn errors(&self) -> Vec<PressureErrors> {
        (0..self.simulation.loads.len()).map(|place| self.at(place)).collect()
    }

    /// What the material leaves open at load number `place`; `None` where the run has no friction or slopes are open.
    #[must_use]
    pub fn deviations(&self, place: usize) -> Option<Deviations> {
        let load = &self.simulation.loads[place];
        let (ratio, mu_flat) = match &load.flat {
            Some(flat) => (load.ratio?, flat.mu_dynamic?),
            None => (1.0, load.surface.mu_dynamic?),
        };
        self.slopes.deviations(place, ratio, mu_flat, self.knowledge)
    }

    fn at(&self, place: usize) -> PressureErrors {
        let load = &self.simulation.loads[place];
        let material = self.deviations(place);
        let discrepancy = self.knowledge.discrepancy.as_ref().and_then(|all| all.get(place));
        let factor = discrepancy.map_or(1.0, |found| found.factor);
        let drawn = self.drawn(place, load);
        let surface = &load.surface;
        let mu = surface.mu_dynamic.map(|mu| mu * factor);
        let flat_mu = load.flat.as_ref().and_then(|flat| flat.mu_dynamic);
        // Of the ratio; of friction times that of the flat surface.
        let of_specimen = |times: Option<f64>| {
            // What errors of blocks hardly exceed, as two standard deviations.
            let blocks = load.ratio_discretization_error.map(|error| 0.5 * error);
            let each = [(LAYOUT, load.ratio_layout_error), (BEHIND, load.ratio_layer_error), (BLOCKS, blocks)];
            let part = move |(input, std): (&str, Option<f64>)| {
                Some(PartsReport { input: input.to_owned(), std: std? * factor * times? })
            };
            each.into_iter().filter_map(part)
        };
        let mut own_mu = self.of_run(mu, surface.mu_dynamic_stderr.map(|stderr| stderr * factor), drawn.mu);
        own_mu.extend(of_specimen(flat_mu));
        let material_mu = material.as_ref().map(|material| &material.mu);
        let flat = load.flat.as_ref();
        PressureErrors {
            pressure_mpa: PRESSURE_MPA.from_si(load.pressure_pa),
            predicted: None,
            ratio: flat.map(|_| {
                let ratio = load.ratio.map(|ratio| ratio * factor);
                let mut own = self.of_run(ratio, load.ratio_stderr.map(|stderr| stderr * factor), drawn.ratio);
                own.extend(of_specimen(Some(1.0)));
                ErrorReport::new(ratio, own, material.as_ref().map(|material| &material.ratio))
            }),
            mu: ErrorReport::new(mu, own_mu, material_mu),
            mu_flat: flat.map(|flat| {
                let own = self.of_run(flat.mu_dynamic, flat.mu_dynamic_stderr, drawn.flat);
                ErrorReport::new(flat.mu_dynamic, own, material.as_ref().map(|material| &material.flat))
            }),
            mu_static: self.of_static(place, surface, drawn.mu),
            mu_static_flat: flat.and_then(|flat| self.of_static(place, flat, drawn.flat)),
        }
    }

    /// What one draw of local coefficients leaves open; nothing of a cell at the mean coefficients.
    fn drawn(&self, place: usize, load: &LoadOutcome) -> SamplingScatter {
        let run = &self.scene.run;
        let is_drawn = run.fidelity != Fidelity::Steady || run.extent == Extent::Sample;
        if is_drawn {
            sampling_scatter(load, self.scene.loads[place].friction.relative_std())
        } else {
            SamplingScatter::default()
        }
    }

    /// Parts of a run: how long it lasted, and what it drew.
    fn of_run(&self, value: Option<f64>, stderr: Option<f64>, drawn: Option<f64>) -> Vec<PartsReport> {
        let has_several = self.scene.run.draws > 1;
        // The scatter of several draws is in their standard error.
        let drawn = value.zip(drawn).filter(|_| !has_several).map(|(value, share)| value * share);
        let parts = [(if has_several { TIME_AND_DRAWS } else { TIME_AVERAGE }, stderr), (DRAWS, drawn)];
        let part = |(input, std): (&str, Option<f64>)| Some(PartsReport { input: input.to_owned(), std: std? });
        parts.into_iter().filter_map(part).collect()
    }

    /// A static peak: one event per draw, with what the static coefficients leave open.
    fn of_static(&self, place: usize, surface: &SurfaceOutcome, drawn: Option<f64>) -> Option<ErrorReport> {
        let coefficient = self.knowledge.static_friction.as_ref().and_then(|all| all.get(place));
        let value = surface.mu_static?;
        let times = |share: Option<f64>| share.map(|share| value * share);
        let drawn = times(drawn.map(|share| share / (self.scene.run.draws as f64).sqrt()));
        let parts = [(DRAWS, drawn), (STATIC, times(coefficient.map(|variance| variance.sqrt())))];
        let part = |(input, std): (&str, Option<f64>)| Some(PartsReport { input: input.to_owned(), std: std? });
        Some(ErrorReport::new(Some(value), parts.into_iter().filter_map(part).collect(), None))
    }

    /// What is not in the errors of `rows`, as the material of `uncertainty` does not say it.
    #[must_use]
    pub fn unknown(&self, uncertainty: &MaterialUncertainty, rows: &[PressureErrors]) -> Vec<String> {
        let mut unknown = uncertainty.unknown(self.knowledge, self.scene.area_law.as_ref());
        if self.scene.pattern.is_none() {
            // The area law is in what was measured.
            unknown.retain(|name| *name == FLAT_FRICTION);
        }
        if rows.iter().any(|row| row.mu_static.is_some()) && self.knowledge.static_friction.is_none() {
            unknown.push(STATIC);
        }
        let has_friction = |place: usize| self.simulation.loads[place].surface.mu_dynamic.is_some();
        if (0..rows.len()).any(|place| has_friction(place) && self.deviations(place).is_none()) {
            unknown.push(NO_SLOPES);
        }
        unknown.into_iter().map(str::to_owned).collect()
    }
}

/// Name of the one error of a flat surface.
const FLAT_FRICTION: &str = slipgrid_calibrate::uncertainty::Source::FlatFriction.name();

impl ErrorsReport {
    /// The report on `rows`, whose material leaves `unknown` open; `corrected` values have the discrepancy in them.
    #[must_use]
    pub fn new(by_pressure: Vec<PressureErrors>, unknown: Vec<String>, corrected: bool) -> Self {
        let mut includes: Vec<String> = Vec::new();
        let values = |row: &PressureErrors| {
            [row.ratio.clone(), Some(row.mu.clone()), row.mu_static.clone()].into_iter().flatten()
        };
        for part in by_pressure.iter().flat_map(values).flat_map(|value| value.parts) {
            if !includes.contains(&part.input) {
                includes.push(part.input);
            }
        }
        let mut words = if includes.is_empty() {
            "+-: nothing is known".to_owned()
        } else {
            format!("+-: one standard deviation of {}", includes.join(", "))
        };
        if !unknown.is_empty() {
            words += &format!("; not known of this material: {}", unknown.join(", "));
        }
        words += if corrected { "" } else { "; how far the model itself is off is not in it" };
        Self { meaning: words, includes, unknown, by_pressure }
    }

    /// The 95 % intervals of what `of` picks at each pressure, in one line; `None` where none is known.
    #[must_use]
    pub fn intervals(&self, name: &str, of: impl Fn(&PressureErrors) -> Option<ErrorReport>) -> Option<String> {
        let ends = |row: &PressureErrors| of(row)?.interval_95.map(|[from, to]| format!("{from:.4} to {to:.4}"));
        let all: Vec<String> = self.by_pressure.iter().map(|row| ends(row).unwrap_or_else(|| "-".to_owned())).collect();
        let is_known = all.iter().any(|ends| ends != "-");
        is_known.then(|| format!("95 % of {name}: {}", all.join(", ")))
    }

    /// The errors at one pressure.
    #[must_use]
    pub fn at(&self, row: usize) -> Option<&PressureErrors> {
        self.by_pressure.get(row)
    }
}
