//! `[learned]` of a material file: the trials that determine the discrepancy.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use slipgrid_base::units::{HUMIDITY_PCT, LENGTH_UM, PRESSURE_MPA, SPEED_MM_S, tidy};
use slipgrid_infer::discrepancy::{
    Conditions, DimensionShift, Discrepancy, Features, Hyperparameters, Load, Measured, Sensitivity, Trial,
};

use crate::formats::{Diagnostic, Document, Spanned};

/// `[learned]` of a material file: the trials with model predictions that determine the discrepancy.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LearnedFile {
    /// Reference pressure P0 of the discrepancy: mean pressure of the measurements on flat samples.
    reference_pressure_mpa: f64,
    /// Pressure P1 of the discrepancy: lowest pressure of the measurements on flat samples.
    lowest_pressure_mpa: f64,
    /// Reference speed of the effect of speed: geometric mean over the measurements on flat samples.
    reference_speed_mm_s: f64,
    /// Relative standard deviation of Young's modulus.
    modulus_relative_std: f64,
    /// Prior standard deviations of the discrepancy, before any trial.
    prior: Hyperparameters,
    /// The trials from which the discrepancy was learned.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    trial: Vec<LearnedTrial>,
}

#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct LearnedTrial {
    /// Name of the sample.
    name: String,
    /// Fraction of a period that is cavity.
    areal_density: f64,
    /// Length of cavity edges per area of a period.
    edge_per_mm: f64,
    /// Width of a cavity.
    width_um: f64,
    /// Distance between two neighbouring cavities of a row, from centre to centre.
    pitch_um: f64,
    /// Depth of a cavity.
    depth_um: f64,
    /// Fraction of the face that is cavity, over `areal_density`; 1 when absent.
    face_share: Option<f64>,
    /// Standard deviation of ln(ratio) between samples of this texture.
    sample_std: Option<f64>,
    /// Standard error of the mean width, used to decide whether two trials have the same texture; 0 when absent.
    width_std_um: Option<f64>,
    /// Standard error of the spacing; 0 when absent.
    spacing_std_um: Option<f64>,
    /// Standard error of the depth; 0 when absent.
    depth_std_um: Option<f64>,
    /// Name of the disc of which the sample was a sector. Trials on one disc share the random deviation of this disc.
    disc: Option<String>,
    /// Nominal pressures, one per measurement.
    pressure_mpa: Vec<f64>,
    /// Sliding speeds, one per measurement.
    speed_mm_s: Vec<f64>,
    /// Relative humidities, one per measurement.
    humidity_pct: Vec<f64>,
    /// Measured ratios of patterned to flat friction, one per measurement.
    measured_ratio: Vec<f64>,
    /// Modelled ratios of patterned to flat friction, one per measurement.
    modelled_ratio: Vec<f64>,
    /// Relative standard errors of measured friction of the patterned sample, one per measurement.
    patterned_std: Vec<f64>,
    /// Relative standard errors of measured friction of the flat sample, one per measurement.
    flat_std: Vec<f64>,
    /// Derivatives d ln(modelled ratio) / d ln(Young's modulus), one per measurement.
    modulus_sensitivity: Vec<f64>,
    /// Changes of ln(modelled ratio) if local friction follows the local instead of the nominal pressure; zeros when
    /// absent.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    local_law_change: Vec<f64>,
    /// Changes of ln(modelled ratio) for one standard error of each dimension that has an error, and of the slope of
    /// the land if mapped; one list each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    of_dimensions: Vec<Vec<f64>>,
    /// Texture after the change of each list of `of_dimensions`: areal density, edge length per area in 1/mm, width,
    /// pitch and depth in um, and the share of the face, 1 when absent.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    texture_of_dimensions: Vec<Vec<f64>>,
}

/// Metres in a millimetre: converts edge length per area from 1/m to 1/mm.
const PER_MM: f64 = 1e-3;

/// Converts features of a texture to areal density, edge length per area in 1/mm, width, pitch and depth in um, and the
/// share of the face.
fn to_columns(of: &Features) -> [f64; 6] {
    let [width_um, pitch_um, depth_um] =
        [of.width_m, of.pitch_m, of.depth_m].map(|length_m| LENGTH_UM.from_si(length_m));
    [of.areal_density, tidy(of.edge_1_m * PER_MM), width_um, pitch_um, depth_um, of.face_share]
}

/// Converts the columns of [`to_columns`] back to features of a texture.
fn from_columns([areal_density, edge_per_mm, width_um, pitch_um, depth_um, face_share]: [f64; 6]) -> Features {
    let [width_m, pitch_m, depth_m] = [width_um, pitch_um, depth_um].map(|length_um| tidy(LENGTH_UM.to_si(length_um)));
    let edge_1_m = tidy(edge_per_mm / PER_MM);
    Features { areal_density, edge_1_m, width_m, pitch_m, depth_m, face_share }
}

impl LearnedFile {
    /// Converts `learned` to the form of the file.
    pub fn new(learned: &Discrepancy) -> Self {
        let conditions = learned.conditions();
        let trial = |trial: &Trial| {
            let column = |of: fn(&Measured) -> f64| trial.measured.iter().map(|at| tidy(of(at))).collect();
            let of_length =
                |axis: usize| Some(LENGTH_UM.from_si(trial.dimensions_std_m[axis])).filter(|std| *std > 0.0);
            let [areal_density, edge_per_mm, width_um, pitch_um, depth_um, face_share] = to_columns(&trial.features);
            let shifts = &trial.dimension_shifts;
            LearnedTrial {
                name: trial.name.clone(),
                areal_density,
                edge_per_mm,
                width_um,
                pitch_um,
                depth_um,
                face_share: Some(face_share).filter(|share| *share != 1.0),
                sample_std: trial.sample_std,
                width_std_um: of_length(0),
                spacing_std_um: of_length(1),
                depth_std_um: of_length(2),
                disc: trial.disc.clone(),
                pressure_mpa: column(|at| PRESSURE_MPA.from_si(at.load.pressure_pa)),
                speed_mm_s: column(|at| SPEED_MM_S.from_si(at.load.speed_m_s)),
                humidity_pct: column(|at| HUMIDITY_PCT.from_si(at.load.humidity)),
                measured_ratio: column(|at| at.measured),
                modelled_ratio: column(|at| at.modelled),
                patterned_std: column(|at| at.patterned_std),
                flat_std: column(|at| at.flat_std),
                modulus_sensitivity: column(|at| at.sensitivity.modulus),
                local_law_change: Some(column(|at| at.sensitivity.local_law))
                    .filter(|changes: &Vec<f64>| changes.iter().any(|change| *change != 0.0))
                    .unwrap_or_default(),
                of_dimensions: shifts.iter().map(|shift| shift.log_ratio.clone()).collect(),
                texture_of_dimensions: shifts.iter().map(|shift| to_columns(&shift.above).to_vec()).collect(),
            }
        };
        Self {
            reference_pressure_mpa: PRESSURE_MPA.from_si(conditions.reference_pressure_pa),
            lowest_pressure_mpa: PRESSURE_MPA.from_si(conditions.lowest_pressure_pa),
            reference_speed_mm_s: SPEED_MM_S.from_si(conditions.reference_speed_m_s),
            modulus_relative_std: learned.modulus_relative_std(),
            prior: learned.hyperparameters().clone(),
            trial: learned.trials().iter().map(trial).collect(),
        }
    }

    /// Reads the discrepancy of the model from `table`.
    ///
    /// # Errors
    /// [`Diagnostic`] at the table if the numbers are invalid.
    pub fn read(document: &Document, table: &Spanned<Self>) -> Result<Discrepancy, Diagnostic> {
        let file = table.get_ref();
        let refuse = |reason: String| document.refuse(table.span(), reason);
        let trial = |trial: &LearnedTrial| {
            let n = trial.pressure_mpa.len();
            let columns = [
                &trial.speed_mm_s,
                &trial.humidity_pct,
                &trial.measured_ratio,
                &trial.modelled_ratio,
                &trial.patterned_std,
                &trial.flat_std,
                &trial.modulus_sensitivity,
            ];
            // Zeros for a file written before the key existed.
            let by_law = Some(&trial.local_law_change).filter(|column| !column.is_empty());
            if columns.into_iter().chain(&trial.of_dimensions).chain(by_law).any(|column| column.len() != n) {
                let reason = format!("has columns of different lengths in trial \"{}\"", trial.name);
                return Err(refuse(reason).expected("one number a pressure in each of them"));
            }
            if trial.texture_of_dimensions.iter().any(|columns| !matches!(columns.len(), 5 | 6)) {
                let reason = format!("has a texture of other than six numbers in trial \"{}\"", trial.name);
                return Err(refuse(reason).expected("areal density, edges per mm, width, pitch, depth and share"));
            }
            let measured = |row: usize| Measured {
                load: Load {
                    pressure_pa: tidy(PRESSURE_MPA.to_si(trial.pressure_mpa[row])),
                    speed_m_s: tidy(SPEED_MM_S.to_si(trial.speed_mm_s[row])),
                    humidity: tidy(HUMIDITY_PCT.to_si(trial.humidity_pct[row])),
                },
                measured: trial.measured_ratio[row],
                modelled: trial.modelled_ratio[row],
                patterned_std: trial.patterned_std[row],
                flat_std: trial.flat_std[row],
                sensitivity: Sensitivity {
                    modulus: trial.modulus_sensitivity[row],
                    local_law: trial.local_law_change.get(row).copied().unwrap_or(0.0),
                },
            };
            let LearnedTrial { areal_density, edge_per_mm, width_um, pitch_um, depth_um, .. } = *trial;
            let face_share = trial.face_share.unwrap_or(1.0);
            let features = from_columns([areal_density, edge_per_mm, width_um, pitch_um, depth_um, face_share]);
            let shift = |(place, log_ratio): (usize, &Vec<f64>)| {
                let columns = trial.texture_of_dimensions.get(place);
                // For a file written before the key existed: the changes of the model alone.
                let above = columns.map_or(features, |columns| {
                    from_columns(std::array::from_fn(|column| columns.get(column).copied().unwrap_or(1.0)))
                });
                DimensionShift { log_ratio: log_ratio.clone(), above, below: None }
            };
            let dimension_shifts = trial.of_dimensions.iter().enumerate().map(shift).collect();
            Ok(Trial {
                name: trial.name.clone(),
                features,
                sample_std: trial.sample_std,
                disc: trial.disc.clone(),
                measured: (0..n).map(measured).collect(),
                dimensions_std_m: [trial.width_std_um, trial.spacing_std_um, trial.depth_std_um]
                    .map(|std_um| std_um.map_or(0.0, |std_um| tidy(LENGTH_UM.to_si(std_um)))),
                dimension_shifts,
            })
        };
        let trials = file.trial.iter().map(trial).collect::<Result<Vec<Trial>, Diagnostic>>()?;
        let conditions = Conditions {
            reference_pressure_pa: tidy(PRESSURE_MPA.to_si(file.reference_pressure_mpa)),
            lowest_pressure_pa: tidy(PRESSURE_MPA.to_si(file.lowest_pressure_mpa)),
            reference_speed_m_s: tidy(SPEED_MM_S.to_si(file.reference_speed_mm_s)),
        };
        Discrepancy::new(file.prior.clone(), conditions, file.modulus_relative_std, trials)
            .map_err(|error| refuse(error.to_string()))
    }
}
