//! `[trade_offs]` of a design: goals for the comparison of designs in addition to the search.

use schemars::JsonSchema;
use serde::Deserialize;
use slipgrid_design::optimize::Target;
use slipgrid_design::{TradeOffGoal, TradeOffsWanted};
use slipgrid_laser::export::Laser;
use slipgrid_model::pattern::{Arrangement, Texture};

use super::limits::missing_for_time;
use crate::formats::{Diagnostic, Document, Spanned};

/// Default approximate number of designs to compare, spread over the bounds.
const DEFAULT_DESIGNS: usize = 1000;
/// Default approximate number of designs to compare with the goal `spread`, which also needs neighbours of each design.
const DEFAULT_DESIGNS_WITH_SPREAD: usize = 400;

/// The table `[trade_offs]` of a design file.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TradeOffsFile {
    /// Two or three of `chance`, `misfit`, `laser_time`, `volume`, `peak_pressure` and `spread` (with `[tolerances]`).
    #[schemars(with = "Vec<String>")]
    goals: Spanned<Vec<Spanned<TradeOffGoal>>>,
    /// Approximate number of designs to compare at first, spread over the bounds; 1000 when absent, 400 with `spread`.
    designs: Option<Spanned<usize>>,
}

/// Reads the table `[trade_offs]` of a design with this laser, target and texture; `has_tolerances` tells whether the
/// design states the scatter of samples.
///
/// # Errors
/// [`Diagnostic`] if goals are unknown, repeated, too few or too many, or if they need inputs that are not given.
pub fn read_trade_offs(
    document: &Document,
    table: &Spanned<TradeOffsFile>,
    laser: &Laser,
    target: &Target,
    texture: &Texture,
    has_tolerances: bool,
) -> Result<TradeOffsWanted, Diagnostic> {
    let file = table.get_ref();
    let mut goals: Vec<TradeOffGoal> = Vec::new();
    for name in file.goals.get_ref() {
        if goals.contains(name.get_ref()) {
            return Err(document.refuse(name.span(), "stands there twice").expected("each goal once"));
        }
        needs(document, name, laser, target, has_tolerances)?;
        goals.push(*name.get_ref());
    }
    if !(2..=3).contains(&goals.len()) {
        let reason = format!("has {} goals", goals.len());
        return Err(document.refuse(file.goals.span(), reason).expected("two or three, to weigh against each other"));
    }
    if texture.sliding_direction()[1] != 0.0 || texture.arrangement() != Arrangement::Square {
        return Err(document
            .refuse(table.span(), "compares some thousand designs by the friction of one vertical section along the sliding direction: rows that are staggered, \
                 hexagonal or turned have no section that stands for the whole texture, and to solve so many cells in space would take hours")
            .expected("rows along the sliding direction in a square arrangement, or no [trade_offs]: the search itself solves such patterns in space"));
    }
    let designs = match &file.designs {
        None if goals.contains(&TradeOffGoal::Spread) => DEFAULT_DESIGNS_WITH_SPREAD,
        None => DEFAULT_DESIGNS,
        Some(designs) if (8..=1_000_000).contains(designs.get_ref()) => *designs.get_ref(),
        Some(designs) => {
            return Err(document
                .refuse(designs.span(), "is out of range")
                .expected("a whole number from 8 to 1000000"));
        }
    };
    Ok(TradeOffsWanted { goals, designs })
}

/// Refuses a goal that needs inputs that the design does not give.
fn needs(
    document: &Document,
    name: &Spanned<TradeOffGoal>,
    laser: &Laser,
    target: &Target,
    has_tolerances: bool,
) -> Result<(), Diagnostic> {
    let missing = missing_for_time(laser);
    let beside = format!("{} beside it", missing.join(", "));
    let (reason, expected) = match name.get_ref() {
        TradeOffGoal::LaserTime if !missing.is_empty() => ("is a time that cannot be estimated", &beside[..]),
        TradeOffGoal::Misfit if !target.has_demands() => ("has nothing to miss", "a value or a band in [target]"),
        TradeOffGoal::Spread if !has_tolerances => ("needs to know how samples scatter", "a table [tolerances]"),
        TradeOffGoal::Chance if !target.has_demands() || target.goal().is_some() => {
            ("is that of designs on a target", "a value or a band in [target], and no goal")
        }
        TradeOffGoal::LaserTime
        | TradeOffGoal::Misfit
        | TradeOffGoal::Spread
        | TradeOffGoal::Chance
        | TradeOffGoal::Volume
        | TradeOffGoal::PeakPressure => return Ok(()),
    };
    Err(document.refuse(name.span(), reason).expected(expected))
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_design::optimize::{Quantity, TargetPoint};
    use slipgrid_model::pattern::Planform;

    #[derive(Debug, Deserialize)]
    struct File {
        trade_offs: Spanned<TradeOffsFile>,
    }

    fn read(text: &str, laser: &Laser, has_tolerances: bool) -> Result<TradeOffsWanted, String> {
        let point = TargetPoint { pressure_pa: 1e6, value: 0.9 };
        let target = Target::new(Quantity::Ratio, vec![point], 0.01).unwrap();
        let texture = Texture::new(Planform::Square);
        let document = Document::new("d.toml", format!("[trade_offs]\n{text}\n"));
        let file: File = document.parse().map_err(|error: Diagnostic| error.to_string())?;
        read_trade_offs(&document, &file.trade_offs, laser, &target, &texture, has_tolerances)
            .map_err(|error| error.to_string())
    }

    #[test]
    fn goals_are_two_or_three_and_rest_on_what_is_given() {
        let bare = Laser::default();
        let known =
            Laser { spot_um: Some(23.0), repetition_hz: Some(1e3), depth_per_burst_um: Some(2.6), ..Laser::default() };
        let two = read("goals = [\"misfit\", \"peak_pressure\"]", &bare, false).unwrap();
        assert_eq!(two.goals, [TradeOffGoal::Misfit, TradeOffGoal::PeakPressure]);
        let three = read("goals = [\"misfit\", \"laser_time\", \"spread\"]\ndesigns = 64", &known, true).unwrap();
        assert_eq!((three.goals.len(), three.designs), (3, 64));
        let by_chance = read("goals = [\"chance\", \"volume\"]", &bare, false).unwrap();
        assert_eq!(by_chance.goals, [TradeOffGoal::Chance, TradeOffGoal::Volume]);
    }
}
