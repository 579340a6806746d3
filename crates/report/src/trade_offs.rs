//! Designs compared by goals, as a table and as a picture.

use slipgrid_design::{Compared, TradeOffGoal};
use slipgrid_optimize::TradeOff;
use slipgrid_pattern::Pattern;
use slipgrid_results::PatternReport;
use slipgrid_units::significant;

use crate::charts::{ChartError, TradeOffsChart, trade_offs as draw};

/// The front as a table, the chosen design with it and marked.
#[must_use]
pub fn csv(compared: &Compared, chosen: &Pattern) -> String {
    let (input, found) = (&compared.wanted, &compared.found);
    let columns: Vec<&str> = input.goals.iter().map(|goal| goal.column()).collect();
    let mut text = format!("width_um,spacing_um,depth_um,areal_density,{},on_front,chosen\n", columns.join(","));
    let own = found.dominated.iter().filter(|known| known.design == *chosen).map(|known| (known, false));
    for (known, is_on_front) in found.front.iter().map(|known| (known, true)).chain(own) {
        let design = PatternReport::from(&known.design);
        let goals: Vec<String> = known.goals.iter().map(|goal| rounded(*goal)).collect();
        text += &format!(
            "{},{},{},{},{},{},{}\n",
            design.width_um,
            design.spacing_um,
            design.depth_um,
            rounded(design.areal_density),
            goals.join(","),
            u8::from(is_on_front),
            u8::from(known.design == *chosen),
        );
    }
    text
}

/// Six significant digits.
fn rounded(value: f64) -> String {
    significant(value, 6).to_string()
}

/// The designs in the plane of their goals, or in several where there are three; the design called `name` and chosen among
/// them marked.
///
/// # Errors
/// [`ChartError`] if the picture cannot be drawn.
pub fn picture(name: &str, compared: &Compared, chosen: &Pattern) -> Result<String, ChartError> {
    let (input, found) = (&compared.wanted, &compared.found);
    let own = found.front.iter().chain(&found.dominated).find(|known| known.design == *chosen);
    let titles: Vec<&str> = input.goals.iter().map(|goal| goal.words()).collect();
    draw(&TradeOffsChart {
        title: &format!("{name}: trade-offs"),
        titles: &titles,
        front: &points(&found.front),
        others: &points(&found.dominated),
        chosen: own.map(|known| &known.goals[..]),
        limit: Some((1.0, "missed beyond")).filter(|_| input.goals[0] == TradeOffGoal::Misfit),
    })
}

fn points(designs: &[TradeOff]) -> Vec<&[f64]> {
    designs.iter().map(|known| &known.goals[..]).collect()
}
