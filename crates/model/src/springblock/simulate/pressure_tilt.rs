//! Change of the ratio by friction that tilts the pressure of a specimen.
//!
//! Friction at the face, of area A under the pressure P, and the pull of the holder at the back, at the distance of the
//! thickness H, form a couple mu P A H. If the holder prevents rotation, face and back each carry half of the couple.
//! On a rectangle the pressure is that under an elastic body of the same length and height ([`Body`]), on a foundation
//! with the compliance of the patterned face: linear if the specimen is much higher than long, otherwise with peaks at
//! the ends that are about as wide as the specimen is high. On strips of any length L, the longest being L_longest, on
//! a face with the second moment of area I about its middle across the sliding direction, the pressure is
//!
//! ```text
//! p(x) = P (p_0(2 x / L) + s f(2 x / L) L / L_longest),     s: so that int (p - P) x dA = mu P A H / 2
//! ```
//!
//! where p_0 is the pressure without friction of a rectangle of length sqrt(12 I / A), and f the deviation from p_0 due
//! to friction. Negative pressures are set to zero, because the face lifts there, and the rest is scaled to the load.
//! Friction coefficients that depend on pressure change the ratio:
//!
//! ```text
//! r = int p mu_cell(p) dA / int p mu_flat(p) dA,     change: r(p) - r(p_0)
//! ```
//!
//! The ratio includes a part of the change, with a standard error that is fully correlated between loads
//! ([`Included`]). With a rigid holder it is the whole change, known to [`RELATIVE_ERROR`]. A holder that lets the
//! specimen align itself removes the tilt. If the holder is unknown, any fraction of the change from none to all is
//! equally likely.

use crate::pattern::Pattern;

use super::load_sharing::body::{Body, Foundation, Patch};
use super::load_sharing::{CellFriction, LoadShare, SOLID_COMPLIANCE, excess_compliance_m, normalized};
use super::rim_difference::without_rim;
use super::widest;
use crate::springblock::{
    Dimension, Effect, Extent, Face, Holder, LoadOutcome, Monitor, Scene, Simulation, Statements, SteadyCell,
};

/// Relative standard error of the computed change of the ratio, for specimens some tens of periods long
/// (`it_changes_ratios_as_all_blocks_of_a_specimen_say`).
const RELATIVE_ERROR: f64 = 0.3;
/// Number of equal parts along a strip, each with one pressure.
const PARTS: usize = 16;
/// Change of pressure, relative to the nominal pressure, below which no statement is made.
const MIN_STATED_CHANGE: f64 = 0.01;

/// Part of the change by the tilt that a ratio includes.
#[derive(Clone, Copy, Debug, Default)]
struct Included {
    /// Mean of the included fraction of the change.
    mean: f64,
    /// Standard error of the ratio, as a fraction of the change.
    std: f64,
    /// Last clause of the statement on the tilt.
    words: &'static str,
}

impl Included {
    /// Returns the included part for a specimen in `holder`; `None` if the pressure does not tilt.
    const fn new(holder: Option<Holder>) -> Option<Self> {
        match holder {
            // The fraction is uniformly distributed from 0 to 1: sqrt((1 + RELATIVE_ERROR^2) / 3 - mean^2).
            None => Some(Self {
                mean: 0.5,
                std: 0.34,
                words: "the holder is not stated, so that half of the change is in the ratio and the rest in its error",
            }),
            Some(Holder::Rigid) => {
                Some(Self { mean: 1.0, std: RELATIVE_ERROR, words: "all of the change is in the ratio, known to 30 %" })
            }
            Some(Holder::SelfAligning) => None,
        }
    }
}

/// Rectangular part of the face: width across and length along the sliding direction, in metres. The pressure tilts
/// about the middle of the rectangle.
pub type Rectangle = [f64; 2];

/// Effect of a tilt of the pressure.
#[derive(Clone, Debug, Default)]
pub struct PressureTilt {
    /// Largest change by friction of the pressure on a part of the face of a flat specimen, relative to the nominal
    /// pressure.
    max_change: f64,
    /// Whether the change exceeds the pressure without friction, so that a part of the face lifts.
    is_lifted: bool,
    /// Whole change of the ratio by the tilt, by load; `None` without an equilibrium.
    changes: Vec<Option<f64>>,
    included: Included,
}

impl PressureTilt {
    /// Computes the effect on the ratio for a specimen of `scene` whose face consists of `rectangles` with `pattern`.
    /// There is no effect if the scene does not give the thickness, if the specimen aligns itself, or once `monitor`
    /// has cancelled.
    pub fn new(scene: &Scene, pattern: &Pattern, rectangles: &[Rectangle], monitor: &dyn Monitor) -> Self {
        Self::try_new(scene, pattern, rectangles, monitor).unwrap_or_default()
    }

    fn try_new(scene: &Scene, pattern: &Pattern, rectangles: &[Rectangle], monitor: &dyn Monitor) -> Option<Self> {
        let height_m = scene.layer.thickness_m?;
        let included = Included::new(scene.layer.holder)?;
        let dimension = scene.dimension();
        let solid_m = SOLID_COMPLIANCE * height_m;
        let soft_m = excess_compliance_m(scene, pattern).unwrap_or(0.0).max(solid_m);
        let specimen = HeldSpecimen::new(rectangles, height_m, soft_m)?;
        let flat_specimen = HeldSpecimen::new(rectangles, height_m, solid_m)?;
        let cells = SteadyCell::with_dimension(scene, dimension).solve_heeding(pattern, monitor);
        monitor.heed().ok()?;
        // Without friction first, then at each load.
        let pressed = |specimen: &HeldSpecimen, mu: Vec<Option<f64>>| -> Vec<Option<TiltedPressure>> {
            std::iter::once(Some(0.0)).chain(mu).map(|mu| specimen.pressures_at(mu?)).collect()
        };
        let flat_mu = scene.loads.iter().map(|load| Some(load.flat_mu(scene.area_law.as_ref())));
        let flat = pressed(&flat_specimen, flat_mu.collect());
        let own = pressed(&specimen, cells.iter().map(|cell| cell.ratio.and(cell.surface.mu_dynamic)).collect());
        let friction =
            |cell: Option<(&Pattern, Dimension)>, each: &[Option<TiltedPressure>]| -> Vec<[Option<f64>; 2]> {
                let parts = each.iter().flatten().flat_map(|pressed| &pressed.parts);
                let friction = CellFriction::new(scene, cell, parts, monitor);
                let at = |number: usize, place: usize| friction.force(place, each[number].as_ref()?.parts.iter());
                (0..scene.loads.len()).map(|place| [at(1 + place, place), at(0, place)]).collect()
            };
        let (own, of_flat) = (friction(Some((pattern, dimension)), &own), friction(None, &flat));
        let change = |(own, flat): ([Option<f64>; 2], [Option<f64>; 2])| {
            let [tilted, frictionless] = [0, 1].map(|number| Some(own[number]? / flat[number]?));
            Some(tilted? - frictionless?)
        };
        Some(Self {
            max_change: flat.iter().flatten().map(|pressed| pressed.max_change).fold(0.0, f64::max),
            is_lifted: flat.iter().flatten().any(|pressed| pressed.is_lifted),
            changes: own.into_iter().zip(of_flat).map(change).collect(),
            included,
        })
    }

    /// Like [`Self::new`] for the sample of `scene`, one strip as long as its layer; no effect for a cell, which has no
    /// ends.
    pub fn for_sample(scene: &Scene, pattern: &Pattern, monitor: &dyn Monitor) -> Self {
        match scene.run.extent {
            Extent::Cell => Self::default(),
            Extent::Sample | Extent::Strip => Self::new(scene, pattern, &[[1.0, scene.layer.length_m]], monitor),
        }
    }

    /// Like [`Self::new`] for `face`, whose cavity fraction is `share` times that of a period.
    pub fn for_face(scene: &Scene, pattern: &Pattern, face: &Face, share: f64, monitor: &dyn Monitor) -> Self {
        let rectangles: Vec<Rectangle> = face.strips().iter().map(|strip| [strip.width_m, strip.length_m]).collect();
        let mut found = Self::new(scene, pattern, &rectangles, monitor);
        found.changes.iter_mut().flatten().for_each(|change| *change *= share);
        found
    }

    /// Like [`Self::for_face`] for a face that is solved strip by strip, with flat lands.
    pub fn for_strips(scene: &Scene, pattern: &Pattern, face: &Face, share: f64, monitor: &dyn Monitor) -> Self {
        let flat = Scene { relief: None, ..scene.clone() };
        Self::for_face(&flat, &without_rim(pattern), face, share, monitor)
    }

    /// Adds the included part of the change, with its standard error, to the ratio of each load, and a statement to
    /// `statements`.
    pub fn add(&self, loads: &mut [LoadOutcome], statements: &mut Statements) {
        for (load, change) in loads.iter_mut().zip(&self.changes) {
            let Some(change) = change else { continue };
            load.correct(Effect::Tilt, self.included.mean * change, self.included.std * change.abs());
        }
        statements.model.extend(self.statement());
    }

    /// Statement on the tilt; `None` if the tilt is small.
    fn statement(&self) -> Option<String> {
        let what = if self.is_lifted {
            "lifts one end off the counterface".to_owned()
        } else {
            format!("changes the pressure at the ends by up to {:.0} %", 100.0 * self.max_change)
        };
        let change = widest(self.changes.iter().copied().flatten());
        (self.max_change >= MIN_STATED_CHANGE).then(|| {
            format!("on a specimen that cannot turn in its holder friction {what}; this moves the ratio by {change:+.4} at most; {}", self.included.words)
        })
    }
}

/// Relative standard error of the change of ratios by the tilt of the pressure, for a specimen in `holder`.
pub const fn tilt_relative_error(holder: Option<Holder>) -> f64 {
    match Included::new(holder) {
        Some(included) => included.std / included.mean,
        None => 0.0,
    }
}

/// Adds the effect of a tilt of the pressure to the ratios of `simulation`, which are those of cells of `scene` with
/// `pattern`. `face` is the face of the specimen; its cavity fraction is `share` times that of a period.
pub fn add_tilt(
    simulation: &mut Simulation,
    scene: &Scene,
    pattern: &Pattern,
    face: &Face,
    share: f64,
    monitor: &dyn Monitor,
) {
    let tilt = PressureTilt::for_face(scene, pattern, face, share, monitor);
    tilt.add(&mut simulation.loads, &mut simulation.statements);
}

/// Mean changes of the ratios of cells of `scene` with `pattern` by a tilt of the pressure, by load.
///
/// `face` is the face of the specimen; its cavity fraction is `share` times that of a period. A load is `None` if a
/// cell has no equilibrium, if the scene does not give the thickness, if the specimen aligns itself, or once `monitor`
/// has cancelled.
pub fn tilt_shifts(
    scene: &Scene,
    pattern: &Pattern,
    face: &Face,
    share: f64,
    monitor: &dyn Monitor,
) -> Vec<Option<f64>> {
    let tilt = match scene.dimension().takes_strips() {
        false => PressureTilt::for_face(scene, pattern, face, share, monitor),
        // No tilt is added to strips of a layer alone.
        true if !scene.layer.is_backed() => PressureTilt::default(),
        true => PressureTilt::for_strips(scene, pattern, face, share, monitor),
    };
    let mut shifts: Vec<_> =
        tilt.changes.iter().map(|change| change.map(|change| tilt.included.mean * change)).collect();
    shifts.resize(scene.loads.len(), None);
    shifts
}

/// A specimen whose holder prevents rotation.
struct HeldSpecimen<'a> {
    rectangles: &'a [Rectangle],
    height_m: f64,
    area_m2: f64,
    /// Body in the plane, as long as a rectangle with the area and the second moment of the face.
    body: Body,
    /// Pressures without friction on the parts of a strip, relative to the nominal pressure.
    frictionless: [f64; PARTS],
}

impl<'a> HeldSpecimen<'a> {
    /// Creates a specimen `height_m` thick on a foundation with the compliance `compliance_m`; `None` without a face or
    /// a height.
    fn new(rectangles: &'a [Rectangle], height_m: f64, compliance_m: f64) -> Option<Self> {
        let sum =
            |of: &dyn Fn(f64) -> f64| rectangles.iter().map(|[width_m, length_m]| width_m * of(*length_m)).sum::<f64>();
        // A, and I = sum w L^3 / 12
        let (area_m2, moment_m4) = (sum(&|length_m| length_m), sum(&|length_m| length_m.powi(3) / 12.0));
        let foundation = Foundation { length_m: (12.0 * moment_m4 / area_m2).sqrt(), compliance_m };
        let body = Body::new(&[foundation], height_m)?;
        let frictionless = average_on_parts(&body.pressure(0.0)?.patches);
        Some(Self { rectangles, height_m, area_m2, body, frictionless })
    }

    /// Pressures at the friction coefficient `mu`; `None` if there is no equilibrium.
    fn pressures_at(&self, mu: f64) -> Option<TiltedPressure> {
        let (frictionless, dragged) = (&self.frictionless, average_on_parts(&self.body.pressure(mu)?.patches));
        let longest_m = self.rectangles.iter().map(|[_, length_m]| *length_m).fold(0.0, f64::max);
        // Area, position, pressure without friction, and f.
        let on = |[width_m, length_m]: &Rectangle| -> Vec<[f64; 4]> {
            let part = |number: usize| {
                let x_m = length_m * ((number as f64 + 0.5) / PARTS as f64 - 0.5);
                let departure = (dragged[number] - frictionless[number]) * length_m / longest_m;
                [width_m * length_m / PARTS as f64, x_m, frictionless[number], departure]
            };
            (0..PARTS).map(part).collect()
        };
        let parts: Vec<[f64; 4]> = self.rectangles.iter().flat_map(on).collect();
        // s = (mu A H / 2) / int f x dA
        let couple_m3: f64 = parts.iter().map(|[area_m2, x_m, _, departure]| area_m2 * x_m * departure).sum();
        let scale = if mu > 0.0 { 0.5 * mu * self.area_m2 * self.height_m / couple_m3.abs() } else { 0.0 };
        let max_change = parts.iter().map(|[.., departure]| (scale * departure).abs()).fold(0.0, f64::max);
        let area_and_pressure =
            |[area_m2, _, frictionless, departure]: &[f64; 4]| [*area_m2, frictionless + scale * departure];
        let is_lifted = parts.iter().any(|part| area_and_pressure(part)[1] < 0.0);
        let solid = |part| {
            let [area_m2, pressure] = area_and_pressure(part);
            LoadShare::solid(area_m2, pressure.max(0.0))
        };
        Some(TiltedPressure { parts: normalized(parts.iter().map(solid).collect()), max_change, is_lifted })
    }
}

/// Pressures on a specimen relative to the nominal pressure.
struct TiltedPressure {
    parts: Vec<LoadShare>,
    /// Largest change of pressure by friction on any part of the face, before negative pressures are set to zero.
    max_change: f64,
    is_lifted: bool,
}

/// Averages the pressures of `patches` over [`PARTS`] equal parts of the face.
fn average_on_parts(patches: &[Patch]) -> [f64; PARTS] {
    let length_m: f64 = patches.iter().map(|patch| patch.length_m).sum();
    let part_m = length_m / PARTS as f64;
    let mut parts = [0.0; PARTS];
    let mut from_m = 0.0;
    for patch in patches {
        let to_m = from_m + patch.length_m;
        for (number, part) in parts.iter_mut().enumerate() {
            let [start_m, end_m] = [number, number + 1].map(|edge| part_m * edge as f64);
            let shared_m = (to_m.min(end_m) - f64::max(from_m, start_m)).max(0.0);
            *part += patch.pressure * shared_m / part_m;
        }
        from_m = to_m;
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::springblock::face::Strip;
    use crate::springblock::tests::samples;
    use crate::springblock::{Layer, Load, RunOptions};
    use crate::springblock::{Unwatched, steady_face_ratios};

    /// Strips across a disc of radius 1.
    fn disc() -> Vec<Rectangle> {
        let middle = |band: i32| (f64::from(band) + 0.5) / 32.0 - 1.0;
        (0..64).map(|band| [1.0 / 32.0, 2.0 * (1.0 - middle(band).powi(2)).sqrt()]).collect()
    }

    #[test]
    fn pressures_bear_the_load_and_half_of_the_couple() {
        for rectangles in [vec![[3.0, 10.0], [1.0, 10.0]], vec![[1.0, 10.0], [1.0, 5.0]], disc()] {
            let TiltedPressure { parts, .. } =
                HeldSpecimen::new(&rectangles, 1.0, 1e-4).unwrap().pressures_at(0.1).unwrap();
            let area_m2: f64 = parts.iter().map(LoadShare::area_m2).sum();
            let mean = parts.iter().map(LoadShare::force).sum::<f64>() / area_m2;
            assert!((mean - 1.0).abs() < 1e-12);
            let of_strip = |(parts, [_, length_m]): (&[LoadShare], &Rectangle)| -> f64 {
                let x_m = |part: usize| length_m * ((part as f64 + 0.5) / PARTS as f64 - 0.5);
                parts.iter().enumerate().map(|(part, area_and_pressure)| area_and_pressure.force() * x_m(part)).sum()
            };
            let couple = parts.chunks(PARTS).zip(&rectangles).map(of_strip).sum::<f64>().abs();
            assert!((couple / (0.5 * 0.1 * area_m2) - 1.0).abs() < 1e-9, "{couple}");
        }
    }

    /// Reference: cylinders of radius 5 mm with a fixed back under uniform friction tau on their face, which does not
    /// rotate. Mode 1 of the Fourier series around the axis in bilinear finite elements (64 x 56, graded towards the
    /// rim, Poisson's ratio 1/3).
    #[test]
    fn discs_bear_what_finite_elements_say() {
        // Height over radius; root mean square and mean magnitude of the deviation over tau.
        for (height, rms, magnitude) in
            [(2.4, 2.466, 1.897), (1.4, 1.545, 1.060), (0.6, 0.892, 0.429), (0.3, 0.618, 0.220)]
        {
            let rectangles = disc();
            let specimen = HeldSpecimen::new(&rectangles, height, 1e-4).unwrap();
            let [frictionless, dragged] = [0.0, 1e-3].map(|mu| specimen.pressures_at(mu).unwrap().parts);
            let mean = |of: fn(f64) -> f64| {
                let off = |(frictionless, dragged): (&LoadShare, &LoadShare)| {
                    of((dragged.force() - frictionless.force()) / frictionless.area_m2() / 1e-3)
                };
                let sum: f64 = frictionless.iter().zip(&dragged).map(|pair| off(pair) * pair.0.area_m2()).sum();
                sum / frictionless.iter().map(LoadShare::area_m2).sum::<f64>()
            };
            let (own_rms, own_magnitude) = (mean(|off| off * off).sqrt(), mean(f64::abs));
            // The rim of a thin disc carries more than parts of a sixteenth can resolve.
            let max_change = if height > 1.0 { 0.03 } else { 0.25 };
            assert!((own_rms / rms - 1.0).abs() < max_change, "{height}: {own_rms} {rms}");
            assert!(
                (own_magnitude / magnitude - 1.0).abs() < 0.7 * max_change.max(0.05),
                "{height}: {own_magnitude} {magnitude}"
            );
        }
    }

    /// Compares all blocks of a whole specimen, whose back does not rotate, with strips of its layer plus corrections:
    /// the change of the difference by friction is the tilt. Cells represent periods, which does not hold exactly at
    /// the ends.
    #[test]
    fn it_changes_ratios_as_all_blocks_of_a_specimen_say() {
        const LENGTH_M: f64 = 4e-3;
        const HEIGHT_M: f64 = 2e-3;
        let off_by = |period_um: f64| {
            let groove = samples::groove(0.5 * period_um, 0.5 * period_um, 40.0);
            let run = RunOptions { extent: Extent::Sample, ..RunOptions::default() };
            let base = samples::scene(groove, &[0.65, 1.3, 2.6], run);
            let period_m = period_um * 1e-6;
            let start_m = |number: u32| (0.25 + f64::from(number)) * period_m;
            let count = (LENGTH_M / period_m).round() as u32;
            let cavities_m = (0..count).map(|number| [start_m(number), start_m(number) + 0.5 * period_m]).collect();
            let strip = Strip { band: 0, width_m: 1e-3, length_m: LENGTH_M, cavities_m };
            let face = Face::new(vec![strip], 0.5).unwrap();
            let layer = Layer { length_m: LENGTH_M, block_m: 20e-6, ..base.layer };
            let of = |height_m: f64, thickness_m: Option<f64>, mu: f64| {
                let friction = crate::material::LocalFriction::new(mu * 1.01, mu, 0.0).unwrap();
                let loads = base.loads.iter().map(|load| Load { friction, ..*load }).collect();
                let layer = Layer { height_m, thickness_m, ..layer };
                Scene { layer, loads, ..base.clone() }
            };
            let ratios = |scene: &Scene| -> Vec<f64> {
                let found = steady_face_ratios(scene, &groove, &face, &Unwatched).unwrap();
                found.into_iter().map(Option::unwrap).collect()
            };
            let off = |mu: f64| -> Vec<f64> {
                let (all, added) = (ratios(&of(HEIGHT_M, None, mu)), ratios(&of(200e-6, Some(HEIGHT_M), mu)));
                all.iter().zip(added).map(|(all, added)| all - added).collect()
            };
            let by_blocks: Vec<f64> = off(0.27).iter().zip(off(0.01)).map(|(all, little)| all - little).collect();
            let found = PressureTilt::for_face(&of(200e-6, Some(HEIGHT_M), 0.27), &groove, &face, 1.0, &Unwatched);
            let changes: Vec<f64> = found.changes.iter().copied().map(Option::unwrap).collect();
            // The tilt lowers the ratio at low pressures and raises it at high pressures.
            assert!(changes[0] < -0.005 && changes[2] > 0.007 && by_blocks[0] < -0.002 && by_blocks[2] > 0.007);
            let squares: f64 = changes.iter().zip(&by_blocks).map(|(found, all)| (found - all).powi(2)).sum();
            (squares / 3.0).sqrt() / widest(changes.into_iter()).abs()
        };
        let [long, short, shorter] = [400.0, 200.0, 100.0].map(off_by);
        assert!(
            long < 0.6 && short < 0.8 * long && shorter < 0.8 * short && shorter < RELATIVE_ERROR,
            "{long} {short} {shorter}"
        );
    }

    #[test]
    fn loads_between_others_have_the_change_of_their_own() {
        let run = RunOptions { extent: Extent::Sample, ..RunOptions::default() };
        for (pattern, coefficients) in [
            (samples::groove(100.0, 300.0, 20.0), [0.2, 0.26, 0.3]),
            (samples::groove(200.0, 200.0, 40.0), [0.2, 0.25, 0.3]),
            (samples::groove(200.0, 100.0, 40.0), [0.4, 0.5, 0.6]),
        ] {
            let scene = samples::scene(pattern, &[1.3], run);
            let layer = Layer { thickness_m: Some(7e-3), ..scene.layer };
            let changes = |coefficients: &[f64]| -> Vec<f64> {
                let load = |mu: &f64| {
                    let friction = crate::material::LocalFriction::new(*mu, *mu, 0.0).unwrap();
                    Load { friction, ..scene.loads[0] }
                };
                let loads = coefficients.iter().map(load).collect();
                let scene = Scene { loads, layer, ..scene.clone() };
                let found = PressureTilt::for_sample(&scene, &pattern, &Unwatched).changes;
                found.into_iter().map(Option::unwrap).collect()
            };
            let (shared, own) = (changes(&coefficients)[1], changes(&coefficients[1..2])[0]);
            assert!(shared != own && (shared / own - 1.0).abs() < 0.01, "{shared} {own}");
        }
    }

    #[test]
    fn half_of_it_is_added_and_the_error_is_that_of_a_share_that_nobody_knows() {
        // Fractions from 0 to 1 of a change with the relative error RELATIVE_ERROR.
        let Included { mean, std, .. } = Included::new(None).unwrap();
        let variance = (1.0 + RELATIVE_ERROR * RELATIVE_ERROR) / 3.0 - mean * mean;
        assert!((std - variance.sqrt()).abs() < 5e-3, "{}", variance.sqrt());
        let run = RunOptions { extent: Extent::Sample, ..RunOptions::default() };
        let scene = samples::scene(samples::groove(100.0, 300.0, 20.0), &[0.65, 2.6], run);
        let scene = Scene { layer: Layer { thickness_m: Some(7e-3), ..scene.layer }, ..scene };
        let pattern = scene.pattern.unwrap();
        let plain = crate::springblock::simulate(&scene, &Unwatched).unwrap();
        let tilt = PressureTilt::for_sample(&scene, &pattern, &Unwatched);
        let correction = |load: &LoadOutcome| load.correction(Effect::Tilt).map(|tilt| (tilt.change, tilt.std));
        for (load, change) in plain.loads.iter().zip(&tilt.changes) {
            let change = change.unwrap();
            assert_eq!(correction(load), Some((mean * change, Some(std * change.abs()))));
        }
        assert!(samples::says(&plain, "half of the change is in the ratio"));
        let held = |holder: Holder| {
            let layer = Layer { holder: Some(holder), ..scene.layer };
            crate::springblock::simulate(&Scene { layer, ..scene.clone() }, &Unwatched).unwrap()
        };
        let [rigid, aligned] = Holder::ALL.map(held);
        for ((plain, rigid), aligned) in plain.loads.iter().zip(&rigid.loads).zip(&aligned.loads) {
            let change = 2.0 * correction(plain).unwrap().0;
            let [half, all, none] = [plain, rigid, aligned].map(|load| load.ratio().unwrap());
            assert!((half - none - 0.5 * change).abs() < 1e-12 && (all - none - change).abs() < 1e-12 && change != 0.0);
            assert_eq!((correction(rigid), correction(aligned)), (Some((change, Some(0.3 * change.abs()))), None));
        }
        assert!(samples::says(&rigid, "all of the change is in the ratio, known to 30 %"));
        assert!(!samples::says(&aligned, "cannot turn in its holder"));
        // Friction coefficients independent of pressure are not affected.
        let amontons = Scene { area_law: None, ..scene };
        let tilt = PressureTilt::for_sample(&amontons, &pattern, &Unwatched);
        assert!(
            tilt.changes.iter().all(|change| change.unwrap().abs() < 1e-9) && tilt.max_change > 0.5,
            "{:?}",
            tilt.changes
        );
    }
}
