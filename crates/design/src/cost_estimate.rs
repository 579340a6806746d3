//! What a design takes, said before it is begun.

use slipgrid_export::Specimen;
use slipgrid_pattern::{Pattern, Planform};
use slipgrid_springblock::{
    Expense, Fidelity, RunOptions, Scene, SceneError, Unwatched, bounded, cell_expense, expense, simulate,
};

use crate::DesignError;
use crate::lattice_table::lattice;
use crate::multi_fidelity::MultiFidelityLoop;
use crate::selection;
use crate::task::DesignTask;

/// Seconds, and bytes, up to which nothing is said.
const SHORT_S: f64 = 30.0;
const SMALL_BYTES: f64 = (1_u64 << 30) as f64;

/// Designs that a search, and what is said of its best one, ask of: of the model in the plane, and in space of its guide
/// and of the model itself.
const PLANE_DESIGNS: f64 = 200.0;
const GUIDE_DESIGNS: f64 = 400.0;
const SOLID_DESIGNS: f64 = 25.0;
/// Cells of larger blocks, as a guide's are, cost this share of the model's.
const GUIDE_SHARE: f64 = 0.02;
/// A search condenses its cells: they cost this share of all equations.
const CONDENSED_SHARE: f64 = 0.03;
/// Confirming runs go on until their standard error is small enough: they are usually this much longer.
const CONFIRMED_TIMES: f64 = 1.5;
/// Layouts of a design that its chance is asked for: for its effort, for its own cell, and for all cells beside it.
const LAYOUTS_OF_CHANCE: f64 = 3.0;
/// Cells, and layouts, that the modulus' slope takes where designs aim with the discrepancy.
const MODULUS_CELLS: f64 = 2.0;
/// Searches and choices solve cells to a looser balance than runs do, which costs this share.
const LOOSE_SHARE: f64 = 0.3;
/// Seconds that a layout takes for each crossing of grooves, and for each cavity where those at the rim are cut. Whole cavities
/// are counted in no time.
const CROSSING_S: f64 = 1.5e-6;
const CUT_CAVITY_S: f64 = 5e-7;

/// What a choice in space takes, about.
#[derive(Clone, Copy, Debug, PartialEq)]
struct ChoiceCost {
    /// Cells in the guide's blocks where there are such, and in those asked for.
    cells: f64,
    /// Cells that the model judges after its guide.
    judged: f64,
    /// Seconds of one core.
    core_s: f64,
}

/// Seconds that laying `pattern` on `specimen` takes.
fn layout_s(specimen: &Specimen, pattern: &Pattern) -> f64 {
    let pitch_m = pattern.pitch_m();
    let (across_m, each_s) = match pattern.planform() {
        Planform::Crosshatch => {
            let crossing_deg = pattern.texture().crossing_angle_deg().unwrap_or(90.0);
            (pitch_m / crossing_deg.to_radians().sin(), CROSSING_S)
        }
        _ if specimen.is_clipped => (pattern.pitch_across_m().unwrap_or(f64::INFINITY), CUT_CAVITY_S),
        _ => return 0.0,
    };
    specimen.outline.area_m2() / (pitch_m * across_m) * each_s
}

impl MultiFidelityLoop<'_> {
    /// What the choice among designs on target takes in space, at `pattern` and `widest`; `None` where none is made. With G designs
    /// asked of, J judged and C chances ([`SelectionCount`](slipgrid_optimize::SelectionCount)), n cells a chance, g, f and h seconds of
    /// a cell in the guide's, the model's and the chance's blocks, l seconds and m of a layout, and e = 2 (h + l) where designs aim
    /// with the discrepancy and 0 otherwise:
    ///
    /// ```text
    /// choice = G (g + m l + e) + J (f + m l + e) + C (n h + 3 l + e)
    /// ```
    ///
    /// Choices among squares in blocks of 5 to 20 um and crossing grooves in blocks of 10 to 25 um took 0.6 to 1.0 of it in processor
    /// time.
    fn choice_cost(&self, design: &DesignTask, pattern: &Pattern, widest: Option<&Pattern>) -> Option<ChoiceCost> {
        let is_dear = !self.model.is_cheap_per_design();
        let chances = self.chances.as_ref().filter(|_| is_dear && selection::is_wanted(design))?;
        let space = &design.space;
        let is_free = |[least, most]: &[f64; 2]| least < most;
        let free =
            [space.width_m(), space.spacing_m(), space.depth_m()].iter().filter(|bounds| is_free(bounds)).count();
        let is_guided = self.model.guide().is_some();
        let count = selection::options(is_guided).count(free, is_guided);
        // Designs lie in the whole space.
        let spread_s = |cell: &dyn Fn(&Pattern) -> Scene| {
            let own_s = cell_expense(&cell(pattern)).core_s;
            LOOSE_SHARE * f64::midpoint(own_s, widest.map_or(own_s, |widest| cell_expense(&cell(widest)).core_s))
        };
        let guide_s = spread_s(&|design| self.model.cell(design, true));
        let model_s = spread_s(&|design| self.model.cell(design, false));
        let chance_s = spread_s(&|design| chances.cell(design));
        let laid_s = layout_s(&design.specimen, pattern);
        let layouts = 1 + design.quantities.iter().filter(|quantity| quantity.takes_a_layout()).count();
        let slopes = if self.model.learned().is_some() { MODULUS_CELLS } else { 0.0 };
        let slopes_s = slopes * (chance_s + laid_s);
        let (solves, beside_s) = (chances.solves() as f64, layouts as f64 * laid_s + slopes_s);
        Some(ChoiceCost {
            cells: count.designs * (1.0 + slopes) + count.judged * slopes + count.chances * (solves + slopes),
            judged: count.judged,
            core_s: count.designs * (guide_s + beside_s)
                + count.judged * (model_s + beside_s)
                + count.chances * (solves * chance_s + LAYOUTS_OF_CHANCE * laid_s + slopes_s),
        })
    }

    /// Says what the search, in space the choice among designs on target, and one confirming run take, where that is much, at the
    /// middle of the bounds; a table, samples and trade-offs in the plane with them.
    ///
    /// # Errors
    /// [`DesignError::Input`] where the confirming run takes more memory or time than anybody means to give it.
    pub(super) fn announce(&self, design: &DesignTask) -> Result<(), DesignError> {
        let space = &design.space;
        let Ok(pattern) = space.middle() else { return Ok(()) };
        let searched = self.model.scene(&pattern);
        let draws = self.draws(&pattern);
        let run = RunOptions { draws, ..self.round.confirming };
        let confirmed = Scene { run, ..searched.clone() }.in_time();
        // A middle that is no design says nothing of the others.
        if searched.validate().is_err() || confirmed.validate().is_err() {
            return Ok(());
        }
        bounded(&confirmed).map_err(|error| design.refuse_blocks(&error))?;
        let (cell, run) = (cell_expense(&searched), expense(&confirmed));
        // Searches look at the whole space, where the largest cells cost most.
        let widest = space.pattern([space.width_m()[1], space.spacing_m()[1], pattern.depth_m()]);
        let largest = widest.ok().map(|widest| (widest, self.model.scene(&widest)));
        let (widest, largest) = largest.filter(|(_, scene)| scene.validate().is_ok()).unzip();
        let spread_s = f64::midpoint(cell.core_s, largest.map_or(cell.core_s, |scene| cell_expense(&scene).core_s));
        let threads = rayon::current_num_threads() as f64;
        let search_s = if self.model.is_cheap_per_design() {
            let table = if design.table { lattice(design).0.len() } else { 0 };
            let draws = design.tolerances.map_or(0, |tolerances| tolerances.draws);
            let compared = design.trade_offs.as_ref().map_or(0, |input| input.designs);
            spread_s * CONDENSED_SHARE * (PLANE_DESIGNS + (table + draws + compared) as f64)
        } else {
            spread_s * GUIDE_DESIGNS * GUIDE_SHARE + cell.core_s * SOLID_DESIGNS
        };
        let choice = self.choice_cost(design, &pattern, widest.as_ref());
        let search_s = search_s + choice.map_or(0.0, |choice| choice.core_s);
        let run_s = CONFIRMED_TIMES * run.wall_s;
        let all = Expense {
            core_s: search_s + CONFIRMED_TIMES * run.core_s,
            wall_s: search_s / threads + run_s,
            bytes: run.bytes.max(cell.bytes * threads),
        };
        let what = if choice.is_some() { "a search, the choice of a design and" } else { "a search with" };
        let line = cost_line(&format!("{what} one confirming run"), all, false, rayon::current_num_threads());
        if let Some(line) = line {
            self.monitor.note(&line);
        }
        Ok(())
    }
}

/// Step of the reference integration where a scene names none, in seconds; that of dynamic runs is always stable.
const REFERENCE_STEP_S: f64 = 1e-9;

/// What solving `scene` takes, as [`cost_line`] says it of this run; nothing where it is refused.
#[must_use]
pub fn run_line(scene: &Scene) -> Option<String> {
    let may_go_on = scene.run.mu_stderr.is_some();
    let line = cost_line("this run", expense(scene), may_go_on, rayon::current_num_threads())?;
    (bounded(scene).is_ok() && is_stable(scene)).then_some(line)
}

/// Whether a run in time takes the step of `scene`.
fn is_stable(scene: &Scene) -> bool {
    let is_reference = scene.run.fidelity == Fidelity::Reference;
    let asked = scene.run.step_s.filter(|_| scene.run.fidelity != Fidelity::Steady);
    let Some(step_s) = asked.or(is_reference.then_some(REFERENCE_STEP_S)) else { return true };
    // The largest step is refused with the limit named, before anything is run.
    let mut probe = scene.clone();
    probe.run.step_s = Some(f64::MAX);
    match simulate(&probe, &Unwatched) {
        Err(SceneError::UnstableStep { limit_s, .. }) => step_s <= limit_s,
        Err(_) => false,
        Ok(_) => true,
    }
}

/// That `what` takes `expense` on `threads` threads, where that is more than half a minute or a gigabyte; `may_go_on`: until a
/// standard error is small enough.
#[must_use]
pub fn cost_line(what: &str, expense: Expense, may_go_on: bool, threads: usize) -> Option<String> {
    if expense.wall_s <= SHORT_S && expense.bytes <= SMALL_BYTES {
        return None;
    }
    let time = duration(expense.wall_s);
    let longer = if may_go_on { " or, until the standard error is small enough, longer" } else { "" };
    let memory = if expense.bytes > SMALL_BYTES {
        format!(" and {:.1} GiB of memory", expense.bytes / SMALL_BYTES)
    } else {
        String::new()
    };
    Some(format!("{what} takes about {time}{longer}{memory}, estimated for {threads} threads with cores of their own"))
}

/// Seconds in the unit that fits them.
fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 100.0 => format!("{:.0} s", s.ceil()),
        s if s < 5400.0 => format!("{:.0} min", s / 60.0),
        s if s < 172_800.0 => format!("{:.0} h", s / 3600.0),
        s => format!("{:.0} days", s / 86_400.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chances;
    use crate::evaluation_cache::NoCache;
    use crate::next_trial::tests::task;
    use crate::steady_model::SteadyModel;
    use crate::time_budget::TimeBudget;
    use crate::timings::Timings;
    use slipgrid_calibrate::uncertainty::MaterialUncertainty;
    use slipgrid_monitor::Unwatched;
    use slipgrid_optimize::{Demand, Goal, Quantity, Status, Target, TargetPoint, Wanted};
    use slipgrid_springblock::Layer;

    #[test]
    fn the_choice_in_space_is_counted_as_it_is_made() {
        let mut design = task(Planform::Square);
        design.layer = Layer { length_m: 10e-3, height_m: 160e-6, block_m: 20e-6, thickness_m: None };
        let material = design.material.clone().unwrap().material;
        let loads = design.loads(&material).unwrap().0;
        let pattern = design.space.middle().unwrap();
        // What the middle of the bounds does, so that the search meets it.
        let scene = design.flat_scene(&material, loads.clone(), RunOptions::default());
        let ratio = SteadyModel::new(&scene, &[], &[], &design.space, None).steady(&pattern).unwrap().ratio;
        let points = [0.65e6, 2.6e6].into_iter().zip(ratio);
        let points = points.map(|(pressure_pa, value)| TargetPoint { pressure_pa, value }).collect();
        design.target = Target::new(Quantity::Ratio, points, 0.02).unwrap();
        design.max_evaluations = 1000;
        let known = MaterialUncertainty { modulus_relative_std: Some(0.2), ..MaterialUncertainty::default() };
        let searched = |chooses: bool| {
            let (budget, mut cache) = (TimeBudget::new(&Unwatched, None), NoCache);
            let timings = &mut Timings::default();
            let new =
                MultiFidelityLoop::new(&design, &material, loads.clone(), Vec::new(), budget, &Unwatched, timings);
            let mut found = new.unwrap();
            let chances = Chances::new(&design, &known, &found.model, &[]).unwrap();
            found.chances = chooses.then_some(chances);
            found.keep_answers(&design, &mut cache).unwrap();
            let cost = found.choice_cost(&design, &pattern, None);
            let outcome = found.search(&design, timings).unwrap();
            assert_eq!((outcome.status, found.round.selection.is_some()), (Status::Met, chooses));
            let [model, guide] = found.model.solved();
            (cost, [model, guide + found.chances.as_ref().map_or(0, Chances::solved)])
        };
        let ((none, search), (cost, all)) = (searched(false), searched(true));
        let cost = cost.unwrap();
        assert_eq!(none, None);
        let near = |counted: usize, expected: f64| {
            let over = counted as f64 / expected;
            assert!((0.5..2.0).contains(&over), "{counted}, where {expected} were expected");
        };
        near(all[1] - search[1], cost.cells);
        near(all[0] - search[0], cost.judged);
        assert!(cost.core_s > 0.0);
    }

    #[test]
    fn a_choice_costs_what_its_chances_and_layouts_do_and_nothing_where_none_is_made() {
        let known = MaterialUncertainty { modulus_relative_std: Some(0.2), ..MaterialUncertainty::default() };
        let cost = |planform: Planform, known: &MaterialUncertainty, change: &dyn Fn(&mut DesignTask)| {
            let mut design = task(planform);
            design.layer.height_m = 160e-6;
            change(&mut design);
            let material = design.material.clone().unwrap().material;
            let (loads, budget) = (design.loads(&material).unwrap().0, TimeBudget::new(&Unwatched, None));
            let timings = &mut Timings::default();
            let new = MultiFidelityLoop::new(&design, &material, loads, Vec::new(), budget, &Unwatched, timings);
            let mut found = new.unwrap();
            found.chances = Some(Chances::new(&design, known, &found.model, &[]).unwrap());
            found.choice_cost(&design, &design.space.middle().unwrap(), None)
        };
        let squares = cost(Planform::Square, &known, &|_| ()).unwrap();
        let exact = cost(Planform::Square, &MaterialUncertainty::default(), &|_| ()).unwrap();
        assert!(squares.cells > 1.2 * exact.cells && squares.core_s > exact.core_s, "{squares:?} {exact:?}");
        let cut = cost(Planform::Square, &known, &|design| design.specimen.is_clipped = true).unwrap();
        assert!(cut.cells == squares.cells && cut.core_s > squares.core_s, "{cut:?} {squares:?}");
        // Without a guide, the model itself is asked of more designs.
        let alone = cost(Planform::Square, &known, &|design| design.layer.height_m = 60e-6).unwrap();
        assert!(alone.judged == 0.0 && alone.cells > 500.0, "{alone:?}");
        assert_eq!(cost(Planform::Square, &known, &|design| design.robust = true), None);
        let demand = Demand { pressure_pa: 0.65e6, wanted: Wanted::Anything, weight: 1.0 };
        let least = |design: &mut DesignTask| {
            design.target = Target::of(Quantity::Ratio, vec![demand], Some(Goal::Lowest)).unwrap();
        };
        assert_eq!(cost(Planform::Square, &known, &least), None);
        assert_eq!(cost(Planform::Groove, &known, &|_| ()), None);
    }

    #[test]
    fn only_what_is_long_or_large_is_said() {
        let expense = |wall_s: f64, gib: f64| Expense { core_s: wall_s, wall_s, bytes: gib * SMALL_BYTES };
        assert_eq!(cost_line("this run", expense(29.0, 0.9), true, 2), None);
        let told = cost_line("this run", expense(31.0, 0.1), false, 2).unwrap();
        assert_eq!(told, "this run takes about 31 s, estimated for 2 threads with cores of their own");
        let told = cost_line("this run", expense(7300.0, 2.0), true, 2).unwrap();
        assert!(told.contains("2 h or, until") && told.contains("2.0 GiB of memory"), "{told}");
        assert!(cost_line("a", expense(1.0, 1.5), false, 1).unwrap().contains("about 1 s and 1.5 GiB"));
        assert_eq!((duration(600.0), duration(1e6)), ("10 min".to_owned(), "12 days".to_owned()));
    }
}
