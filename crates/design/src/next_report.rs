//! Samples to cut next, as JSON and as text.

use crate::results::{SCREEN_WIDTH, doubt_in_brief, material_doubts, wrapped};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use slipgrid_base::units::counted;
use slipgrid_base::units::{HUMIDITY_PCT, PRESSURE_MPA, SPEED_MM_S, tidy};
use slipgrid_infer::discrepancy::{Distribution, Load};

use slipgrid_laser::export::{Laser, MEASURE_EACH_ALONE, MadeBy, Outline, Sector, SpecimenRecord, Tolerances};
use slipgrid_model::material::Provenance;

use crate::design_report::samples_table;
use crate::learning_disc::LearningReport;
use crate::prediction::{SampleReport, percent};
use crate::search::ALIKE;

/// Samples to cut next.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct NextReport {
    /// Program that made the record.
    #[serde(flatten)]
    pub made_by: MadeBy,
    /// Name of the design.
    pub name: String,
    /// Number of measured trials.
    pub trials: usize,
    /// Number of samples that were cut and are not measured yet.
    pub pending: usize,
    /// Number of designs that were compared.
    pub compared: usize,
    /// Recommended action: `series` (cut a series), `trial` (cut a trial), `trial_meets_it` (a measured trial
    /// is on target), `cannot_be_met`, `measure_again` (two trials of one texture contradict each other) or
    /// `do_not_texture`; `learn` where a disc to learn from was requested.
    pub advice: String,
    /// Recommended action in one sentence.
    pub words: String,
    /// Samples to cut.
    pub samples: Vec<SampleReport>,
    /// Chance that at least one of `samples`, or of the pending samples, is on target; null with `learning` and where
    /// nothing is demanded.
    pub one_on_target: Option<f64>,
    /// Specimen on which the samples are sectors; absent where one disc was not requested.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub one_disc: Option<OneDiscReport>,
    /// Information of the sectors about the mechanism of the model error; absent where it was not requested.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub learning: Option<LearningReport>,
    /// Other samples, sorted by decreasing chance.
    pub others: Vec<SampleReport>,
    /// Samples that the user asked for.
    pub own: Vec<SampleReport>,
    /// Stages that the time limit ended early; absent if it ended none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cut_short: Vec<String>,
    /// Features that the laser cannot cut as designed, each with the number of the sample.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
    /// Target pressures outside the measured range, in words.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub beyond_measured: Option<String>,
    /// Material and its provenance.
    pub material: Provenance,
    /// Specimen on which the samples are laid out.
    pub specimen: SpecimenRecord,
    /// Laser settings.
    pub laser: Laser,
    /// Assumed manufacturing tolerances of samples; absent where the design file does not give them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tolerances: Option<Tolerances>,
    /// Seed of the random local coefficients.
    pub seed: u64,
}

/// Specimen on which the samples are sectors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct OneDiscReport {
    /// Name of the specimen, to be given as `disc` in trials on its sectors.
    pub name: String,
    /// Width of the untextured lands between the sectors.
    pub land_mm: f64,
    /// Area of the smallest sector without the untextured lands on its sides.
    pub area_mm2: f64,
    /// Diameter of the largest circle on the smallest sector: a pin or a counter-body has to be smaller.
    pub circle_mm: f64,
    /// Advice on measurements for which sectors are suitable.
    pub measuring: String,
    /// Sectors, in the order of the samples.
    pub sectors: Vec<SectorReport>,
}

/// Note on the sectors of a rectangle.
const OF_A_RECTANGLE: &str = "the specimen is a rectangle: its sectors meet in its middle at equal angles, differ in area, and their textures all \
                              lie as that of a whole specimen";

/// Sector of a specimen that is one of the samples.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SectorReport {
    /// Direction of the middle of the sector on the specimen, anticlockwise from the specimen's x axis.
    pub middle_deg: f64,
    /// Angle by which the texture is turned with the sector.
    pub turn_deg: f64,
    /// Share of the sector that is cavity, as cut.
    pub areal_density: f64,
}

impl OneDiscReport {
    /// Describes the specimen `name` with `sectors`; `None` without sectors.
    pub(super) fn of(name: String, sectors: &[Sector]) -> Option<Self> {
        let division = sectors.first()?.division();
        let areas_mm2 = sectors.iter().map(|sector| 1e6 * division.area_m2(sector.number()));
        let sector = |of: &Sector| SectorReport {
            middle_deg: tidy(division.middle_deg(of.number())),
            turn_deg: tidy(division.turn_deg(of.number())),
            areal_density: tidy(of.areal_density()),
        };
        Some(Self {
            name,
            land_mm: tidy(1e3 * division.land_m()),
            area_mm2: tidy(areas_mm2.fold(f64::INFINITY, f64::min)),
            circle_mm: tidy(1e3 * division.least_circle_m()),
            measuring: match division.specimen().outline {
                Outline::Rectangle { .. } => format!("{MEASURE_EACH_ALONE}; {OF_A_RECTANGLE}"),
                _ => MEASURE_EACH_ALONE.to_owned(),
            },
            sectors: sectors.iter().map(sector).collect(),
        })
    }

    fn text(&self) -> String {
        let densities: Vec<String> =
            self.sectors.iter().map(|of| format!("{:.2} %", 100.0 * of.areal_density)).collect();
        format!(
            "{}: {} sectors of {:.2} mm2 or more with lands of {:.2} mm between them, areal density as cut {}\n\
             {}; the pin or counter-body has to be smaller than {:.2} mm\n",
            self.name,
            self.sectors.len(),
            self.area_mm2,
            self.land_mm,
            densities.join(", "),
            self.measuring,
            self.circle_mm
        )
    }
}

/// Prediction of a sample's ratio at one load by the model and the trials.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RatioPrediction {
    /// Nominal pressure.
    pub pressure_mpa: f64,
    /// Sliding speed.
    pub speed_mm_s: f64,
    /// Relative humidity.
    pub humidity_pct: f64,
    /// Ratio by the model alone.
    pub modelled: f64,
    /// Median ratio of samples, with the correction by trials.
    pub ratio: f64,
    /// Ends of the 95 % interval of samples.
    pub interval_95: [f64; 2],
}

impl RatioPrediction {
    /// Creates the record for the load `at`, which has the index `row` in `prediction`, and a sample whose ratio by the
    /// model alone is `modelled`.
    pub fn new(at: &Load, modelled: f64, prediction: &Distribution, row: usize) -> Self {
        let quantile = |p: f64| tidy(modelled * prediction.quantile(row, p).exp());
        Self {
            pressure_mpa: tidy(PRESSURE_MPA.from_si(at.pressure_pa)),
            speed_mm_s: tidy(SPEED_MM_S.from_si(at.speed_m_s)),
            humidity_pct: tidy(HUMIDITY_PCT.from_si(at.humidity)),
            modelled: tidy(modelled),
            ratio: quantile(0.5),
            interval_95: [quantile(0.025), quantile(0.975)],
        }
    }
}

impl NextReport {
    /// All listed samples with their names, in order: the samples to cut, the user's samples, and the others.
    pub fn rows(&self) -> Vec<(String, &SampleReport)> {
        let numbered =
            |place: usize| if self.samples.len() == 1 { "next".to_owned() } else { format!("next {}", place + 1) };
        let next = self.samples.iter().enumerate().map(|(place, of)| (numbered(place), of));
        let yours =
            |place: usize| if self.own.len() == 1 { "yours".to_owned() } else { format!("yours {}", place + 1) };
        let own = self.own.iter().enumerate().map(|(place, of)| (yours(place), of));
        let others = self.others.iter().map(|of| ("also".to_owned(), of));
        next.chain(own).chain(others).collect()
    }

    /// User's sample with the highest chance that keeps all limits; `None` unless this chance is clearly higher than that of all samples
    /// found.
    pub fn likelier_own(&self) -> Option<&SampleReport> {
        let found = self.samples.iter().chain(&self.others).filter_map(|of| of.chance).fold(0.0, f64::max);
        let keeping = self.own.iter().filter(|own| own.violations.is_empty());
        let own = keeping.reduce(|best, next| if next.chance > best.chance { next } else { best })?;
        (own.chance? > found + ALIKE).then_some(own)
    }

    /// Reasons to doubt the samples, one sentence each; the text marks them with `!`.
    pub fn doubts(&self) -> Vec<String> {
        self.first_doubts().chain(self.laser_doubts()).collect()
    }

    /// Doubts that stand above the samples: about the search, limits and the material.
    fn first_doubts(&self) -> impl Iterator<Item = String> {
        let cut_short =
            (!self.cut_short.is_empty()).then(|| format!("cut short by max_seconds: {}", self.cut_short.join(", ")));
        cut_short.into_iter().chain(self.violated_limits()).chain(self.material_doubts())
    }

    fn violated_limits(&self) -> impl Iterator<Item = String> {
        let of = |(name, sample): (String, &SampleReport)| {
            sample.violations.iter().map(move |limit| format!("{name}: {limit}")).collect::<Vec<_>>()
        };
        self.rows().into_iter().flat_map(of)
    }

    fn material_doubts(&self) -> impl Iterator<Item = String> {
        self.beyond_measured.clone().into_iter().chain(material_doubts(&self.material))
    }

    fn laser_doubts(&self) -> impl Iterator<Item = String> {
        self.warnings.iter().map(|warning| format!("laser: {warning}"))
    }

    /// Formats the samples as text.
    pub fn text(&self) -> String {
        let mut text = wrapped(&format!("{}: {}", self.name, self.words), SCREEN_WIDTH, "  ", 3);
        let (trials, designs) = (counted(self.trials, "trial"), counted(self.compared, "design"));
        text += &format!("\n  {trials} measured, {} pending; {designs} compared\n", self.pending);
        self.first_doubts().for_each(|doubt| text += &doubt_in_brief(&doubt));
        if let Some(learning) = &self.learning {
            return text + &learning.text() + &self.ending();
        }
        if let Some(own) = self.likelier_own() {
            let chance = percent(own.chance.unwrap_or(0.0));
            text += &format!("yours, {} um, is likelier: {chance}\n", own.design.lengths_in_words());
        }
        if let Some(chance) = self.one_on_target.filter(|_| self.samples.len() > 1 || self.pending > 0) {
            text += &format!("{} chance that one of those cut is on target\n", percent(chance));
        }
        text += &samples_table(self.rows().into_iter()).to_string();
        text += "learns: how much a measured sample would teach of how the model's error depends on the texture\n";
        text + &self.ending()
    }

    /// Formats the doubts about the laser, and the description of the specimen with sectors if there is one.
    fn ending(&self) -> String {
        let doubts: String = self.laser_doubts().map(|doubt| doubt_in_brief(&doubt)).collect();
        doubts + &self.one_disc.as_ref().map_or_else(String::new, OneDiscReport::text)
    }
}
