//! CSV tables of simulation histories.

use std::fmt::Write;

use slipgrid_model::springblock::{Simulation, SurfaceOutcome};

use slipgrid_base::units::{LENGTH_UM, PRESSURE_MPA, tidy};

/// Both surfaces of every load, with their names in tables.
fn surfaces(simulation: &Simulation) -> impl Iterator<Item = (f64, &'static str, &SurfaceOutcome)> {
    simulation.loads.iter().flat_map(|load| {
        let own = if load.flat.is_some() { "patterned" } else { "flat" };
        let both = [Some((own, &load.surface)), load.flat.as_ref().map(|flat| ("flat", flat))];
        both.into_iter().flatten().map(|(name, surface)| (PRESSURE_MPA.from_si(load.pressure_pa), name, surface))
    })
}

/// mu against time, one row per sample; `None` for steady runs.
#[must_use]
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

/// Pressure and friction along the interface, one row per contact block; includes y if the model has it.
#[must_use]
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
