//! CSV tables of simulations, of the designs of a lattice and of trade-offs.

use std::fmt::Write;

use slipgrid_base::units::{HUMIDITY_PCT, LENGTH_UM, PRESSURE_MPA, SPEED_MM_S, significant, tidy};
use slipgrid_design::results::PatternReport;
use slipgrid_design::{Compared, DesignTask, Lattice};
use slipgrid_model::pattern::Pattern;
use slipgrid_model::springblock::{Simulation, SurfaceOutcome};

/// Returns (nominal pressure in MPa, name of the surface in tables, outcome) of each surface at every load; at each
/// load the patterned surface comes first.
fn surfaces(simulation: &Simulation) -> impl Iterator<Item = (f64, &'static str, &SurfaceOutcome)> {
    simulation.loads.iter().flat_map(|load| {
        let own = if load.flat.is_some() { "patterned" } else { "flat" };
        let both = [Some((own, &load.surface)), load.flat.as_ref().map(|flat| ("flat", flat))];
        both.into_iter().flatten().map(|(name, surface)| (PRESSURE_MPA.from_si(load.pressure_pa), name, surface))
    })
}

/// Formats the friction coefficient mu against time as CSV, one row per time step recorded; `None` for steady runs.
pub fn friction_trace(simulation: &Simulation) -> Option<String> {
    let mut text = String::from("load_mpa,surface,time_us,mu\n");
    let header = text.len();
    for (load_mpa, name, surface) in surfaces(simulation) {
        for point in &surface.trace {
            let _ = writeln!(text, "{load_mpa},{name},{},{}", tidy(point.time_s * 1e6), point.mu);
        }
    }
    (text.len() > header).then_some(text)
}

/// Formats contact pressure and friction force per area, in MPa, along the interface as CSV, one row per contact block;
/// has a column for y if the model is three-dimensional.
pub fn interface(simulation: &Simulation) -> String {
    let in_space = surfaces(simulation).any(|(_, _, surface)| surface.interface.iter().any(|point| point.y_m != 0.0));
    let y_title = if in_space { "y_um," } else { "" };
    let mut text = format!("load_mpa,surface,x_um,{y_title}pressure_mpa,friction_mpa\n");
    for (load_mpa, name, surface) in surfaces(simulation) {
        for point in &surface.interface {
            let (x_um, pressure_mpa) = (LENGTH_UM.from_si(point.x_m), PRESSURE_MPA.from_si(point.pressure_pa));
            let friction_mpa = PRESSURE_MPA.from_si(point.friction_pa);
            let y_um = if in_space { format!("{},", LENGTH_UM.from_si(point.y_m)) } else { String::new() };
            let _ = writeln!(text, "{load_mpa},{name},{x_um},{y_um}{pressure_mpa},{friction_mpa}");
        }
    }
    text
}

/// Formats all designs of `lattice`, the grid of compared designs, with their predictions as CSV, one row per design;
/// fields without a prediction are empty.
pub fn lattice(design: &DesignTask, lattice: &Lattice) -> String {
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
        let (unit, _) = limit.quantity.unit();
        let unit = if unit.is_empty() { String::new() } else { format!("_{}", unit.to_lowercase()) };
        text += &format!(",{}{unit}", limit.quantity.name().replace(' ', "_"));
    }
    // Number of empty fields of a design without a prediction: all columns except the three lengths and `keeps_limits`.
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
                    text += &format!(",{}", tidy(value / limit.quantity.unit().1));
                }
                text += &format!(",{:.4},{}\n", found.chance, found.keeps_limits);
            }
            None => text += &format!("{},false\n", ",".repeat(columns + 1)),
        }
    }
    text
}

/// Formats the Pareto front of a comparison as CSV, one row per design. The chosen design is marked, and listed even if
/// it is not on the front.
pub fn trade_offs(compared: &Compared, chosen: &Pattern) -> String {
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

/// Formats `value` with six significant digits.
fn rounded(value: f64) -> String {
    significant(value, 6).to_string()
}
