//! CSV table of all designs of a lattice.

use slipgrid_base::units::{HUMIDITY_PCT, LENGTH_UM, PRESSURE_MPA, SPEED_MM_S, tidy};
use slipgrid_design::{DesignTask, Lattice};

/// Formats one row per design.
#[must_use]
pub fn csv(design: &DesignTask, lattice: &Lattice) -> String {
    let quantity = design.target.quantity().name();
    let mut text = "width_um,spacing_um,depth_um".to_owned();
    let elsewhere = design.also_at.iter().map(|condition| {
        let [speed, humidity] = [SPEED_MM_S.from_si(condition.speed_m_s), HUMIDITY_PCT.from_si(condition.humidity)];
        format!("_{}_mm_s_{}_pct", tidy(speed), tidy(humidity))
    });
    let conditions: Vec<String> = std::iter::once(String::new()).chain(elsewhere).collect();
    let turned = design.directions.different_deg.iter().map(|angle_deg| format!("_at_{angle_deg}_deg"));
    let directions = std::iter::once(String::new()).chain(turned);
    for condition in
        directions.flat_map(|turned| conditions.iter().map(move |condition| format!("{condition}{turned}")))
    {
        for point in design.target.points() {
            text += &format!(",{quantity}_at_{}_mpa{condition}", PRESSURE_MPA.from_si(point.pressure_pa));
        }
    }
    for limit in &design.constraints.quantities {
        let unit = if limit.unit.is_empty() { String::new() } else { format!("_{}", limit.unit.to_lowercase()) };
        text += &format!(",{}{unit}", limit.name.replace(' ', "_"));
    }
    // All columns of the header except the three lengths and the probability.
    let columns = text.matches(',').count() - 1;
    text += ",chance,keeps_limits\n";
    for (pattern, predicted) in lattice.patterns.iter().zip(&lattice.predicted) {
        let um = |length_m: f64| LENGTH_UM.from_si(length_m);
        text += &format!("{},{},{}", um(pattern.width_m()), um(pattern.spacing_m()), um(pattern.depth_m()));
        match predicted {
            Some(found) => {
                for median in &found.medians {
                    text += &format!(",{median:.6}");
                }
                for (limit, value) in design.constraints.quantities.iter().zip(&found.limited) {
                    text += &format!(",{}", tidy(value / limit.unit_si));
                }
                text += &format!(",{:.4},{}\n", found.chance, found.keeps_limits);
            }
            None => text += &format!("{},false\n", ",".repeat(columns + 1)),
        }
    }
    text
}
