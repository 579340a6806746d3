//! Section of a design's page with the coefficients of the material.

use slipgrid_base::units::PRESSURE_MPA;
use slipgrid_model::material::AreaLaw;
use slipgrid_model::springblock::Load;

use super::page::{Page, number, percent, plain, with_error};

/// Adds the local coefficients at `loads`, in order of pressure; a single row if all loads share them.
pub(super) fn coefficients(page: &mut Page, loads: &[Load]) {
    let row = |pressure: String, load: &Load| {
        vec![pressure, number(load.friction.static_mean(), 4), number(load.friction.dynamic_mean(), 4)]
    };
    let mut loads: Vec<&Load> = loads.iter().collect();
    loads.sort_by(|a, b| a.pressure_pa.total_cmp(&b.pressure_pa));
    let Some(first) = loads.first() else { return };
    let rows: Vec<Vec<String>> = if loads.iter().all(|load| load.friction == first.friction) {
        vec![row("all".to_owned(), first)]
    } else {
        loads.iter().map(|load| row(plain(PRESSURE_MPA.from_si(load.pressure_pa)), load)).collect()
    };
    page.table(
        &format!(
            "Means of the local friction coefficients, dimensionless; each block draws its own with a relative standard deviation of {} %.",
            percent(first.friction.relative_std(), 1)
        ),
        &["P in MPa", "static", "dynamic"],
        &rows,
    );
}

/// Adds the factors of the area law.
pub(super) fn area_law(page: &mut Page, law: &AreaLaw) {
    let rows: Vec<Vec<String>> = law
        .pressures_pa()
        .iter()
        .zip(law.factors())
        .enumerate()
        .map(|(row, (pressure_pa, factor))| {
            let std = law.factor_std().and_then(|all| all.get(row).copied());
            vec![plain(PRESSURE_MPA.from_si(*pressure_pa)), with_error(*factor, std, 4)]
        })
        .collect();
    page.table(
        "The area law: local friction is the local coefficient times f at the local pressure p, dimensionless. ± is one standard error. \
         f is 1 below the first pressure.",
        &["p in MPa", "f"],
        &rows,
    );
}
