//! Trade-offs between goals, as a table and as a picture.

use slipgrid_base::units::significant;
use slipgrid_design::results::PatternReport;
use slipgrid_design::{Compared, TradeOff, TradeOffGoal};
use slipgrid_model::pattern::Pattern;

use crate::charts::{self, ChartError};

/// Formats the front as CSV, including the chosen design, which is marked.
#[must_use]
pub fn csv(compared: &Compared, chosen: &Pattern) -> String {
    let goals = &compared.wanted.goals;
    let columns: Vec<&str> = goals.iter().map(|goal| goal.column()).collect();
    let mut text = format!("width_um,spacing_um,depth_um,areal_density,{},on_front,chosen\n", columns.join(","));
    let own = compared.dominated.iter().filter(|known| known.design == *chosen).map(|known| (known, false));
    for (known, is_on_front) in compared.front.iter().map(|known| (known, true)).chain(own) {
        let design = PatternReport::from(&known.design);
        let values: Vec<String> = known.goals.iter().map(|goal| rounded(*goal)).collect();
        text += &format!(
            "{},{},{},{},{},{},{}\n",
            design.width_um,
            design.spacing_um,
            design.depth_um,
            rounded(design.areal_density),
            values.join(","),
            u8::from(is_on_front),
            u8::from(known.design == *chosen),
        );
    }
    text
}

/// Formats six significant digits.
fn rounded(value: f64) -> String {
    significant(value, 6).to_string()
}

/// Draws the designs in the plane of two goals, or in several planes for three goals; marks the chosen design, which has
/// the name `name`.
///
/// # Errors
/// [`ChartError`] if the picture cannot be drawn.
pub fn picture(name: &str, compared: &Compared, chosen: &Pattern) -> Result<String, ChartError> {
    let goals = &compared.wanted.goals;
    let own = compared.front.iter().chain(&compared.dominated).find(|known| known.design == *chosen);
    let titles: Vec<&str> = goals.iter().map(|goal| goal.words()).collect();
    let (front, others) = (points(&compared.front), points(&compared.dominated));
    let limit = Some((1.0, "missed beyond")).filter(|_| goals[0] == TradeOffGoal::Misfit);
    let title = format!("{name}: trade-offs");
    charts::trade_offs(&title, &titles, &front, &others, own.map(|known| &known.goals[..]), limit)
}

fn points(designs: &[TradeOff]) -> Vec<&[f64]> {
    designs.iter().map(|known| &known.goals[..]).collect()
}
