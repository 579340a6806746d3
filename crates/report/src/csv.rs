//! CSV tables of simulations, of the designs of a lattice and of trade-offs.

use std::fmt::Write;

use slipgrid_base::units::{HUMIDITY_PCT, LENGTH_UM, PRESSURE_MPA, SPEED_MM_S, significant, tidy};
use slipgrid_design::results::{PatternReport, Table};
use slipgrid_design::{Compared, DesignTask, Lattice};
use slipgrid_model::pattern::Pattern;
use slipgrid_model::springblock::{Simulation, SurfaceOutcome};

use crate::pictures;

/// Returns (nominal pressure in MPa, name of the surface in tables, outcome) of each surface at every load; at each
/// load the patterned surface comes first.
fn surfaces(simulation: &Simulation) -> impl Iterator<Item = (f64, &'static str, &SurfaceOutcome)> {
    simulation.loads.iter().flat_map(|load| {
        let load_mpa = PRESSURE_MPA.from_si(load.pressure_pa);
        pictures::surfaces(load).into_iter().rev().map(move |(name, surface)| (load_mpa, name, surface))
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
    let rows: Vec<_> = lattice.patterns.iter().zip(&lattice.predicted).collect();
    let mut table = Table::of(&rows);
    table.numbers("width_um", |(pattern, _)| LENGTH_UM.from_si(pattern.width_m()));
    table.numbers("spacing_um", |(pattern, _)| LENGTH_UM.from_si(pattern.spacing_m()));
    table.numbers("depth_um", |(pattern, _)| LENGTH_UM.from_si(pattern.depth_m()));
    let elsewhere = design.also_at.iter().map(|condition| {
        let [speed, humidity] = [SPEED_MM_S.from_si(condition.speed_m_s), HUMIDITY_PCT.from_si(condition.humidity)];
        format!("_{}_mm_s_{}_pct", tidy(speed), tidy(humidity))
    });
    let conditions: Vec<String> = std::iter::once(String::new()).chain(elsewhere).collect();
    let turned = design.directions.different_deg.iter().map(|angle_deg| format!("_at_{angle_deg}_deg"));
    let directions = std::iter::once(String::new()).chain(turned);
    let conditions =
        directions.flat_map(|turned| conditions.iter().map(move |condition| format!("{condition}{turned}")));
    let points = || design.target.points().iter().map(|point| PRESSURE_MPA.from_si(point.pressure_pa));
    let titles = conditions
        .flat_map(|condition| points().map(move |pressure_mpa| format!("{quantity}_at_{pressure_mpa}_mpa{condition}")));
    let fixed = |value: Option<f64>, digits: usize| value.map_or_else(String::new, |value| format!("{value:.digits$}"));
    for (place, title) in titles.enumerate() {
        table.column(title, |(_, found)| fixed(found.as_ref().map(|found| found.medians[place]), 6));
    }
    for (place, limit) in design.constraints.quantities.iter().enumerate() {
        let (unit, unit_si) = limit.quantity.unit();
        let unit = if unit.is_empty() { String::new() } else { format!("_{}", unit.to_lowercase()) };
        let title = format!("{}{unit}", limit.quantity.name().replace(' ', "_"));
        table.numbers(title, |(_, found)| found.as_ref().map(|found| tidy(found.limited[place] / unit_si)));
    }
    table.column("chance", |(_, found)| fixed(found.as_ref().map(|found| found.chance), 4));
    table.column("keeps_limits", |(_, found)| found.as_ref().is_some_and(|found| found.keeps_limits).to_string());
    table.table().csv()
}

/// Formats the Pareto front of a comparison as CSV, one row per design. The chosen design is marked, and listed even if
/// it is not on the front.
pub fn trade_offs(compared: &Compared, chosen: &Pattern) -> String {
    let goals = &compared.wanted.goals;
    let own = compared.dominated.iter().filter(|known| known.design == *chosen).map(|known| (known, false));
    let rows = compared.front.iter().map(|known| (known, true)).chain(own);
    let rows: Vec<_> = rows.map(|(known, on_front)| (known, PatternReport::from(&known.design), on_front)).collect();
    let mut table = Table::of(&rows);
    table.numbers("width_um", |(_, design, _)| design.width_um);
    table.numbers("spacing_um", |(_, design, _)| design.spacing_um);
    table.numbers("depth_um", |(_, design, _)| design.depth_um);
    table.numbers("areal_density", |(_, design, _)| significant(design.areal_density, 6));
    for (place, goal) in goals.iter().enumerate() {
        table.numbers(goal.name(), |(known, ..)| significant(known.goals[place], 6));
    }
    table.numbers("on_front", |(.., on_front)| f64::from(*on_front));
    table.numbers("chosen", |(known, ..)| f64::from(known.design == *chosen));
    table.table().csv()
}
