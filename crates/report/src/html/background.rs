//! Coefficients and area law of a material on a page.

use slipgrid_base::units::{PRESSURE_MPA, significant};
use slipgrid_design::results::Table;
use slipgrid_model::material::AreaLaw;
use slipgrid_model::springblock::Load;

use super::page::{Page, number, percent, plain, with_error};

/// Maximum number of rows of the area law's table.
const MAX_FACTORS: usize = 24;

/// Adds a table of the mean local coefficients at `loads`, sorted by pressure; a single row if all loads have equal
/// coefficients.
pub(super) fn coefficients(page: &mut Page, loads: &[Load]) {
    let mut loads: Vec<&Load> = loads.iter().collect();
    loads.sort_by(|a, b| a.pressure_pa.total_cmp(&b.pressure_pa));
    let Some(first) = loads.first().copied() else { return };
    let is_one = loads.iter().all(|load| load.friction == first.friction);
    let pressure = |load: &Load| if is_one { "all".to_owned() } else { plain(PRESSURE_MPA.from_si(load.pressure_pa)) };
    let mut table = Table::of(if is_one { &loads[..1] } else { &loads });
    table.column("P in MPa", |load| pressure(load));
    table.column("static", |load| number(load.friction.static_mean(), 4));
    table.column("dynamic", |load| number(load.friction.dynamic_mean(), 4));
    page.table(
        &format!(
            "Means of the local friction coefficients, dimensionless; each block draws its own with a relative standard deviation of {} %.",
            percent(first.friction.relative_std(), 1)
        ),
        &table.table(),
    );
}

/// Adds a table of the factors f of the area law; leaves out pressures if there are too many.
pub(super) fn area_law(page: &mut Page, law: &AreaLaw) {
    let mut table = Table::new(["p in MPa", "f"]);
    let all = law.pressures_pa();
    let step = all.len().div_ceil(MAX_FACTORS).max(1);
    for (row, (pressure_pa, factor)) in all.iter().zip(law.factors()).enumerate() {
        if row % step != 0 && row + 1 != all.len() {
            continue;
        }
        let std = law.factor_std().and_then(|all| all.get(row).copied());
        table.row([plain(significant(PRESSURE_MPA.from_si(*pressure_pa), 4)), with_error(*factor, std, 4)]);
    }
    let shown = if step == 1 { "" } else { " Some pressures are left out." };
    page.table(
        &format!(
            "The area law: local friction is the local coefficient times f at the local pressure p, dimensionless. ± is one standard \
             error. f is 1 below the first pressure.{shown}"
        ),
        &table,
    );
}
