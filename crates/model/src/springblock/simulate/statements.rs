//! Statements on a simulation: what was modelled and why.

use crate::pattern::Pattern;

use crate::springblock::dynamics::{Plan, Scheme};
use crate::springblock::{Column, Extent, MAX_STEPS, Scene, Statements, columns};

/// Typical change of the ratio from steady to dynamic sliding, at speeds of mm/s, divided by the cavity fraction: 0.7
/// to 2.2 % on eight grooves at three loads, largest at light loads and in shallow cavities (`what_time_adds_to_ratios`
/// of the validation tests).
const TIME_CHANGE: f64 = 0.015;

/// Statement on the extent of a periodic cell.
pub const PERIODIC_CELL: &str = "cell: one period with periodic sides, as nothing asked for depends on the ends";
/// Statement on steady runs at zero speed.
pub const SPEED_ZERO: &str = "speed 0: the limit of vanishing speed, in which every contact block still slides";
/// Statement on cells whose dimensions are not whole numbers of blocks.
pub const STRETCHED_CELL: &str = "dimensions that are no whole blocks: the cell in whole columns stretched to fit, edges and depth blended between blocks";

pub fn describe_steady(scene: &Scene) -> String {
    let ratio = scene.pattern.as_ref().map_or_else(String::new, |pattern| {
        let percent = 100.0 * TIME_CHANGE * pattern.areal_density();
        format!(" and a ratio higher by about {percent:.1} %, which a run in time decides")
    });
    format!(
        "steady: equilibrium with every contact block sliding, linear elasticity; no time, no static friction; dynamic runs at mm/s have 1 to 2 % more friction{ratio}"
    )
}

/// Clause on the reason why `pattern` is solved in space.
pub fn space_reason(scene: &Scene, pattern: &Pattern) -> String {
    if scene.run.dimensions == Some(3) {
        return "as asked for".to_owned();
    }
    let aslant = if pattern.is_uniform_along_y() { " along or oblique to the sliding direction" } else { "" };
    format!("as {} cavities{aslant} need", pattern.planform())
}

pub fn describe_scheme(scene: &Scene, scheme: &Scheme) -> String {
    format!(
        "{}: {} springs, {} at {:.3} ns (limit {:.2} ns), damping {} sqrt(k/m)",
        scene.run.fidelity.name(),
        scheme.springs.name(),
        if scheme.runge_kutta { "classical Runge-Kutta of order 4" } else { "leapfrog with implicit damping" },
        scheme.step_s * 1e9,
        scheme.limit_s * 1e9,
        scene.run.damping,
    )
}

/// Adds statements on runs refused for too many steps of `step_s` and on a bulk at rest.
pub fn describe_protocol(scene: &Scene, step_s: f64, statements: &mut Statements) {
    let steps = Plan::new(scene, step_s).total();
    if steps > MAX_STEPS {
        statements.model(format!(
            "not run: {:.3e} m of travel at {:.3e} m/s would take {steps:.1e} steps, more than {MAX_STEPS:.0e}; travel less, slide faster, or ask for steady",
            scene.run.sliding_m, scene.speed_m_s,
        ));
    }
    if scene.speed_m_s == 0.0 {
        statements.model("speed 0: the bulk stays where it is; 20 us of rest are simulated");
    }
}

/// Adds a statement on the start of a run if it is a warm start; `body` names the sheared body.
pub fn describe_start(scene: &Scene, body: &str, statements: &mut Statements) {
    if scene.run.warm_start {
        statements.method(format!(
            "warm start: the {body} sheared as in sliding, every block at rest at a random moment of its stick-slip; no ramp, no static friction"
        ));
    }
}

pub fn describe_draws(scene: &Scene, statements: &mut Statements) {
    if scene.run.draws > 1 {
        statements.method(format!(
            "mean of {} draws of the local coefficients, seeds from {}; standard errors from their scatter, or from \
             within the runs where that gives more",
            scene.run.draws, scene.run.seed
        ));
    }
}

pub fn describe_extent(scene: &Scene, statements: &mut Statements) {
    let what = match scene.run.extent {
        Extent::Cell => PERIODIC_CELL,
        Extent::Sample | Extent::Strip => "sample: the whole specimen with free sides",
    };
    statements.method(what);
    statements.model.extend(describe_periods(scene));
    let asked = match &scene.pattern {
        Some(pattern) if !pattern.texture().is_one_section() && scene.run.dimensions == Some(2) => ", as asked for",
        _ => "",
    };
    statements.method(format!(
        "two dimensions: the vertical plane along the sliding direction, plane stress, nu = 1/3{asked}{}",
        modulus_of_heights(scene)
    ));
}

/// Clause on the elastic modulus that applies to face heights in the plane; empty for a flat face.
pub fn modulus_of_heights(scene: &Scene) -> &'static str {
    if scene.is_raised() { "; rims and heights press as in plane strain, E / (1 - nu^2) at nu = 1/4" } else { "" }
}

/// Minimum difference between the cavity fractions of specimen and pattern for a statement: the ratio changes by about
/// as much.
const MIN_STATED_DIFFERENCE: f64 = 0.01;

/// Statement on a specimen of few periods whose cavity fraction differs from that of the pattern; `None` if it does
/// not.
fn describe_periods(scene: &Scene) -> Option<String> {
    let pattern = scene.pattern.as_ref().filter(|_| scene.run.extent.has_ends())?;
    let columns = columns::sample(pattern, scene.layer.block_m, scene.layer.columns());
    let sum = |of: fn(&Column) -> f64| columns.iter().map(of).sum::<f64>();
    let share = sum(|column| column.width * column.coverage) / sum(|column| column.width);
    few_periods(scene.layer.length_m / pattern.pitch_m(), share, pattern.section_density())
}

/// Statement on a specimen of `periods` periods with the cavity fraction `share`; `None` if `own`, the cavity fraction
/// of a period, hardly differs.
pub fn few_periods(periods: f64, share: f64, own: f64) -> Option<String> {
    ((share - own).abs() > MIN_STATED_DIFFERENCE).then(|| {
        format!(
            "the specimen holds {periods:.1} periods, no whole number of them: cavities take {:.1} % of its length, {:.1} % of a period; its \
             ratio is its own, not that of many periods",
            100.0 * share,
            100.0 * own,
        )
    })
}

pub fn describe_law(scene: &Scene, statements: &mut Statements) {
    match &scene.area_law {
        Some(_) => statements.method("area law: f = 1 up to its first pressure, the line through the origin above it"),
        None => statements.model("no area law: Amontons-Coulomb friction"),
    }
    if scene.run.liftoff {
        statements.method("unilateral contact: blocks under tension leave the counterface");
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::springblock::simulate::simulate;
    use crate::springblock::{Layer, RunOptions, Unwatched, tests::samples};

    #[test]
    fn a_specimen_of_few_periods_says_that_it_is_not_the_pattern() {
        let statements = |length_m: f64, extent: Extent| {
            let run = RunOptions { extent, ..RunOptions::default() };
            let scene = samples::scene(samples::groove(100.0, 300.0, 20.0), &[1.0], run);
            let layer = Layer { length_m, height_m: 50e-6, ..scene.layer };
            let scene = Scene { area_law: None, layer, ..scene };
            let model = simulate(&scene, &Unwatched).unwrap().statements.model;
            model.into_iter().find(|statement| statement.contains("periods"))
        };
        // 150 um of land, 100 of cavity, 300 of land, 90 of cavity: 190 of 640.
        let told = statements(640e-6, Extent::Sample).unwrap();
        assert!(told.contains("1.6 periods") && told.contains("29.7 % of its length, 25.0 % of a period"), "{told}");
        assert_eq!(statements(800e-6, Extent::Sample), None);
        assert_eq!(statements(640e-6, Extent::Cell), None);
    }
}
