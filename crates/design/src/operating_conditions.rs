//! Operating conditions of the target besides the design condition: further speeds and humidities, and further sliding
//! directions.

use slipgrid_model::material::{Condition, Material};
use slipgrid_model::pattern::Pattern;
use slipgrid_model::springblock::Load;

use crate::DesignError;
use crate::task::DesignTask;
use slipgrid_base::units::{HUMIDITY_PCT, SPEED_MM_S, tidy};

/// Condition and sliding direction at which friction is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setting {
    /// Speed and humidity; `None` if coefficients are not given per condition.
    pub condition: Option<Condition>,
    /// Sliding direction, in degrees anticlockwise from the specimen's x axis; `None` if a design has a single
    /// direction.
    pub sliding_angle_deg: Option<f64>,
}

/// Setting of the target in addition to the design setting, with its loads.
#[derive(Clone, Debug)]
pub struct Further {
    /// Speed, humidity and direction.
    pub at: Setting,
    /// Target pressures with the coefficients of this setting.
    pub loads: Vec<Load>,
    /// Whether each pressure lies outside the measured range.
    pub outside: Vec<bool>,
}

impl Setting {
    /// Returns the design setting of `design`: the design condition in the texture's own sliding direction.
    pub fn first(design: &DesignTask) -> Self {
        let has_several = !design.directions.different_deg.is_empty();
        let own_deg = design.space.texture().sliding_angle_deg();
        Self { condition: design.condition, sliding_angle_deg: has_several.then_some(own_deg) }
    }

    /// Turns `pattern` to the sliding direction of this setting.
    pub fn turned(&self, pattern: &Pattern) -> Pattern {
        turned(pattern, self.sliding_angle_deg)
    }

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

/// Lists the settings of `design` besides the design setting: its further conditions, then all conditions in every
/// further direction, the design condition first.
///
/// # Errors
/// [`DesignError`] for a condition outside those measured.
pub fn further(design: &DesignTask, material: &Material) -> Result<Vec<Further>, DesignError> {
    let mut all = Vec::new();
    let first = Setting::first(design);
    let turned = design.directions.different_deg.iter().map(|&angle_deg| Some(angle_deg));
    for sliding_angle_deg in std::iter::once(None).chain(turned) {
        let at = Setting { sliding_angle_deg: sliding_angle_deg.or(first.sliding_angle_deg), ..first };
        if sliding_angle_deg.is_some() {
            let (loads, outside) = design.loads(material)?;
            all.push(Further { at, loads, outside });
        }
        for condition in &design.also_at {
            let (loads, outside) = design.loads_at(material, condition)?;
            let at = Setting { condition: Some(*condition), ..at };
            all.push(Further { at, loads, outside });
        }
    }
    Ok(all)
}

/// Statements on the conditions and sliding directions of `design`, with `further` settings besides the first.
pub fn statements(design: &DesignTask, further: usize) -> Vec<String> {
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
            "{} mm/s and {} % of humidity: friction is lowest and highest at its ends and at measured conditions inside, since \
             coefficients are linear in between",
            ends(range.speed_m_s().map(|speed| SPEED_MM_S.from_si(speed))),
            ends(range.humidity().map(|humidity| HUMIDITY_PCT.from_si(humidity))),
        ));
    }
    if further > 0 {
        statements.push(format!(
            "the target holds at {} conditions or sliding directions at once, each with its own coefficients; ends, tilt and time are \
             those of the first, at {}",
            1 + further,
            Setting::first(design).in_words()
        ));
    }
    statements
}
