//! Operating conditions at which the target must hold: speeds and humidities, in every sliding direction.

use slipgrid_model::material::{Condition, Material};
use slipgrid_model::pattern::Pattern;
use slipgrid_model::springblock::Load;

use crate::Refusal;
use crate::prepared_task::PreparedTask;
use crate::task::DesignTask;
use slipgrid_base::units::{HUMIDITY_PCT, SPEED_MM_S, tidy};

/// Condition and sliding direction at which the target must hold, with its loads.
#[derive(Clone, Debug)]
pub struct Setting {
    /// Speed and humidity; `None` if coefficients are not given per condition.
    pub condition: Option<Condition>,
    /// Sliding direction, in degrees anticlockwise from the specimen's x axis; `None` if a design has a single
    /// direction.
    pub sliding_angle_deg: Option<f64>,
    /// Target pressures with the coefficients of this setting.
    pub loads: Vec<Load>,
}

impl Setting {
    /// Describes the setting.
    pub fn in_words(&self) -> String {
        let condition = self.condition.map(|condition| {
            let [speed, humidity] = [SPEED_MM_S.from_si(condition.speed_m_s), HUMIDITY_PCT.from_si(condition.humidity)];
            format!("{} mm/s, {} %", tidy(speed), tidy(humidity))
        });
        let sliding = self.sliding_angle_deg.map(|angle_deg| format!("sliding at {} deg", tidy(angle_deg)));
        [condition, sliding].into_iter().flatten().collect::<Vec<_>>().join(", ")
    }
}

/// Turns `pattern` to slide at `angle_deg` degrees from the specimen's x axis, if given; an invalid angle changes
/// nothing, because the design was refused before.
pub fn turned(pattern: &Pattern, angle_deg: Option<f64>) -> Pattern {
    angle_deg.and_then(|angle_deg| pattern.with_sliding_angle_deg(angle_deg).ok()).unwrap_or(*pattern)
}

/// Lists the settings of `design`: its conditions in the texture's own sliding direction, the design condition first,
/// then all conditions in every further direction.
///
/// # Errors
/// [`Refusal`] of a condition outside those measured.
pub fn settings(design: &DesignTask, material: &Material) -> Result<Vec<Setting>, Refusal> {
    let further_deg = &design.directions.different_deg;
    let own_deg = (!further_deg.is_empty()).then_some(design.space.texture().sliding_angle_deg());
    let mut all = Vec::new();
    for sliding_angle_deg in std::iter::once(own_deg).chain(further_deg.iter().copied().map(Some)) {
        let (loads, _) = design.loads(material)?;
        all.push(Setting { condition: design.condition, sliding_angle_deg, loads });
        for condition in &design.also_at {
            let loads = design.loads_at(material, condition)?;
            all.push(Setting { condition: Some(*condition), sliding_angle_deg, loads });
        }
    }
    Ok(all)
}

/// Statements on the conditions and sliding directions of `prepared`.
pub fn statements(prepared: &PreparedTask) -> Vec<String> {
    let (design, settings) = (&prepared.task, &prepared.settings);
    let mut statements = Vec::new();
    let alike: Vec<String> = design.directions.alike_deg.iter().map(|angle_deg| tidy(*angle_deg).to_string()).collect();
    if !alike.is_empty() {
        let other = if design.directions.different_deg.is_empty() {
            format!("{} deg", tidy(design.space.texture().sliding_angle_deg()))
        } else {
            "another direction".to_owned()
        };
        statements.push(format!(
            "sliding at {} deg is by symmetry what sliding at {other} is: solved once",
            alike.join(", ")
        ));
    }
    if let Some(range) = design.range() {
        let ends = |[lowest, highest]: [f64; 2]| {
            if lowest < highest { format!("{} to {}", tidy(lowest), tidy(highest)) } else { tidy(lowest).to_string() }
        };
        statements.push(format!(
            "{} mm/s and {} % of humidity: computed at its ends and at measured conditions inside, since coefficients are linear \
             in between, and at humidities at most 20 % apart, since the model's error is another one at each",
            ends(range.speed_m_s().map(|speed| SPEED_MM_S.from_si(speed))),
            ends(range.humidity().map(|humidity| HUMIDITY_PCT.from_si(humidity))),
        ));
    }
    if settings.len() > 1 {
        statements.push(format!(
            "the target holds at {} conditions or sliding directions at once, each with its own coefficients; ends, tilt and time are \
             those of the first, at {}",
            settings.len(),
            settings[0].in_words()
        ));
    }
    statements
}
