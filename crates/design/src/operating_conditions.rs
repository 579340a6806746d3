//! Where the target must hold beside what is designed for: further speeds and humidities, and further sliding directions.

use slipgrid_material::{Condition, Material};
use slipgrid_pattern::Pattern;
use slipgrid_springblock::{Load, Simulation};

use crate::DesignError;
use crate::task::DesignTask;
use slipgrid_units::{HUMIDITY_PCT, SPEED_MM_S, tidy};

/// Where friction is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setting {
    /// Speed and humidity, where coefficients are known per condition.
    pub condition: Option<Condition>,
    /// Sliding direction, anticlockwise from the specimen's x axis; where a design names one alone, not worth a word.
    pub sliding_angle_deg: Option<f64>,
}

/// A setting beside the one designed for.
#[derive(Clone, Debug)]
pub struct Further {
    /// Speed, humidity and direction.
    pub at: Setting,
    /// The target's pressures with the coefficients that hold here.
    pub loads: Vec<Load>,
    /// Whether each pressure lies outside the measured range.
    pub outside: Vec<bool>,
    /// The confirming run of the best design here, where it was run in time.
    pub confirmed: Option<Simulation>,
}

impl Setting {
    /// What `design` is made for first.
    #[must_use]
    pub fn first(design: &DesignTask) -> Self {
        let has_several = !design.directions.different_deg.is_empty();
        let own_deg = design.space.texture().sliding_angle_deg();
        Self { condition: design.condition, sliding_angle_deg: has_several.then_some(own_deg) }
    }

    /// `pattern` as it slides here.
    #[must_use]
    pub fn turned(&self, pattern: &Pattern) -> Pattern {
        turned(pattern, self.sliding_angle_deg)
    }

    /// In words.
    #[must_use]
    pub fn in_words(&self) -> String {
        let condition = self.condition.map(|condition| {
            let [speed, humidity] = [SPEED_MM_S.from_si(condition.speed_m_s), HUMIDITY_PCT.from_si(condition.humidity)];
            format!("{} mm/s, {} %", tidy(speed), tidy(humidity))
        });
        let sliding = self.sliding_angle_deg.map(|angle_deg| format!("sliding at {} deg", tidy(angle_deg)));
        [condition, sliding].into_iter().flatten().collect::<Vec<_>>().join(", ")
    }
}

/// `pattern` sliding at `angle_deg`, where that is one; an angle that no texture takes changes nothing, and was refused
/// with its design.
#[must_use]
pub fn turned(pattern: &Pattern, angle_deg: Option<f64>) -> Pattern {
    angle_deg.and_then(|angle_deg| pattern.with_sliding_angle_deg(angle_deg).ok()).unwrap_or(*pattern)
}

/// The settings of `design` beside the one designed for: its further conditions, then in every further direction all
/// conditions, the one designed for first.
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
            all.push(Further { at, loads, outside, confirmed: None });
        }
        for condition in &design.also_at {
            let (loads, outside) = design.loads_at(material, condition)?;
            let at = Setting { condition: Some(*condition), ..at };
            all.push(Further { at, loads, outside, confirmed: None });
        }
    }
    Ok(all)
}
