//! The design whose samples, as they are made, miss the target least.
//!
//! Made dimensions are normal about the designed ones. The mean of a squared residual over them is taken by the cubature
//! of third degree (A. H. Stroud, Approximate Calculation of Multiple Integrals, 1971): the design itself and, along
//! each of the m directions that scatter, two more sqrt((2m + 1) / 2) standard deviations away, all with one weight.
//! Where the response is linear over that distance this is the mean itself,
//!
//! E[((v - t) / T)^2] = ((v(x) - t) / T)^2 + (standard deviation of v / T)^2,
//!
//! and a cliff within it is seen. So the target is asked of all these designs at once, and searched as any other.

use crate::search::search_along;
use crate::sensitivity::{AXES, with_lengths, with_rim_off};
use crate::{
    Bound, Candidate, Constraints, DesignSpace, ForwardModel, Limit, LowFidelityCorrection, Misfit, ModelFailure,
    Response, SearchError, SearchOptions, SearchOutcome, Target, Tolerances, Uncertainty, search_multi_fidelity,
};
use rayon::prelude::*;
use slipgrid_monitor::Monitor;
use slipgrid_pattern::Pattern;

/// A made dimension is at least this share of the designed one.
const LEAST_SHARE: f64 = 0.1;

/// What a robust search found.
#[derive(Clone, Debug, PartialEq)]
pub struct RobustOutcome {
    /// The chosen design, by itself.
    pub best: Candidate,
    /// Mean over samples of it; `rms` is the root of the mean squared residual.
    pub expected: Misfit,
    /// The same of the design that was best on paper; `None` where a sample of it cannot be computed.
    pub nominal_expected: Option<Misfit>,
    /// Designs that were asked of, each with its samples.
    pub evaluations: usize,
}

/// Searches for the design whose samples miss `target` least, starting from a search that asked of designs alone. Where
/// that met the target, only designs that meet it too are chosen, itself among them. With `guide`, as
/// [`search_multi_fidelity`].
///
/// # Errors
/// As [`search`](crate::search); [`SearchError::OutOfRange`] for tolerances that mean nothing.
#[allow(clippy::too_many_arguments, reason = "those of search, and what it begins with")]
pub fn search_robust(
    target: &Target,
    space: &DesignSpace,
    constraints: &Constraints,
    options: &SearchOptions,
    tolerances: &Tolerances,
    model: &dyn ForwardModel,
    guide: Option<&dyn ForwardModel>,
    nominal: &SearchOutcome,
    monitor: &dyn Monitor,
) -> Result<RobustOutcome, SearchError> {
    let samples = Samples::new(model, &constraints.quantities, tolerances)?;
    let of_samples = target.repeated(samples.count());
    let found = match guide {
        None => search_along(&[], &of_samples, space, constraints, options, &samples, monitor)?,
        Some(guide) => {
            let along = Samples { model: guide, displacements_m: samples.displacements_m.clone(), ..samples };
            let low_fidelity_correction = &mut LowFidelityCorrection::new();
            search_multi_fidelity(
                &of_samples,
                space,
                constraints,
                options,
                &samples,
                &along,
                low_fidelity_correction,
                monitor,
            )?
        }
    };
    let fatal = |failure: ModelFailure| SearchError::BrokenModel { reason: failure.to_string() };
    let expected = |design: &Pattern| match samples.respond(design) {
        Ok(response) => Ok(Some(of_samples.misfit(&response.value))),
        Err(ModelFailure::Trial { .. }) => Ok(None),
        Err(failure) => Err(fatal(failure)),
    };
    let nominal_expected = expected(&nominal.best.design)?;
    let most = f64::INFINITY;
    let never = Misfit { max: most, rms: most, cost: most, merit: most };
    let mut chosen = RobustOutcome {
        best: nominal.best.clone(),
        expected: nominal_expected.unwrap_or(never),
        nominal_expected,
        evaluations: found.evaluations.max(found.guide_evaluations),
    };
    for candidate in std::iter::once(&found.best).chain(&found.alternatives) {
        let response = model.respond(&candidate.design).map_err(fatal)?;
        let violations = constraints.violations(&candidate.design, &response);
        let misfit = target.misfit(&response.value);
        let own = Candidate { design: candidate.design, response, misfit, violations };
        let is_allowed = own.violations.len() <= nominal.best.violations.len()
            && (own.misfit.is_met() || !nominal.best.misfit.is_met());
        if is_allowed && candidate.misfit.cost < chosen.expected.cost {
            chosen = RobustOutcome { best: own, expected: candidate.misfit, ..chosen };
        }
    }
    Ok(chosen)
}

/// The responses of a design and of its samples, one after the other; what is limited is the worst of them.
struct Samples<'a> {
    model: &'a dyn ForwardModel,
    quantities: &'a [Limit],
    /// From the design to its samples, itself first: width, spacing, depth and the height of the rims.
    displacements_m: Vec<[f64; AXES + 1]>,
}

impl<'a> Samples<'a> {
    fn new(model: &'a dyn ForwardModel, quantities: &'a [Limit], tolerances: &Tolerances) -> Result<Self, SearchError> {
        let uncertainty = Uncertainty::new(tolerances, &[])?;
        let direction = |axis: usize| {
            let mut unit = vec![0.0; uncertainty.inputs()];
            unit[axis] = 1.0;
            let deviation = uncertainty.deviations(&unit);
            [deviation[0], deviation[1], deviation[2], uncertainty.rim().map_or(0.0, |place| deviation[place])]
        };
        let directions: Vec<[f64; AXES + 1]> = (0..uncertainty.inputs())
            .map(direction)
            .filter(|direction| direction.iter().any(|length_m| *length_m != 0.0))
            .collect();
        // a^2 = (2 m + 1) / 2: the mean of the squares of 2 m + 1 equal weights is the variance
        let reach = (directions.len() as f64 + 0.5).sqrt();
        let both =
            directions.iter().flat_map(|direction| [direction.map(|d| d * reach), direction.map(|d| -d * reach)]);
        Ok(Self { model, quantities, displacements_m: std::iter::once([0.0; AXES + 1]).chain(both).collect() })
    }

    fn count(&self) -> usize {
        self.displacements_m.len()
    }
}

impl ForwardModel for Samples<'_> {
    fn respond(&self, design: &Pattern) -> Result<Response, ModelFailure> {
        let responses = self
            .displacements_m
            .par_iter()
            .map(|by_m| {
                let designed_m = design.lengths_m();
                let made_m =
                    std::array::from_fn(|axis| (designed_m[axis] + by_m[axis]).max(LEAST_SHARE * designed_m[axis]));
                let made = with_lengths(design, made_m)?;
                // A design without rims, or whose rims are exact, is itself.
                self.model.respond(&if by_m[AXES] == 0.0 { made } else { with_rim_off(&made, by_m[AXES]) })
            })
            .collect::<Result<Vec<Response>, ModelFailure>>()?;
        let worst = |(place, limit): (usize, &Limit)| {
            let values = responses.iter().filter_map(|response| response.limited.get(place).copied());
            match limit.bound {
                Bound::AtMost(_) => values.reduce(f64::max),
                Bound::AtLeast(_) => values.reduce(f64::min),
            }
        };
        let limited = self.quantities.iter().enumerate().filter_map(worst).collect();
        Ok(Response { value: responses.into_iter().flat_map(|response| response.value).collect(), limited })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Quantity, Status, TargetPoint, propagate, search};
    use slipgrid_monitor::Unwatched;
    use slipgrid_pattern::{Planform, Rim, RimProfile, Texture};

    fn space() -> DesignSpace {
        DesignSpace::new(Planform::Groove, [40e-6, 400e-6], [40e-6, 400e-6], [5e-6, 5e-6]).unwrap()
    }

    fn target(value: f64) -> Target {
        Target::new(Quantity::Ratio, vec![TargetPoint { pressure_pa: 1e6, value }], 0.01).unwrap()
    }

    fn tolerances(std_um: [f64; 3]) -> Tolerances {
        Tolerances { std_m: std_um.map(|um| um * 1e-6), ..Tolerances::default() }
    }

    fn both(
        target: &Target,
        tolerances: &Tolerances,
        value: impl Fn(f64, f64) -> f64 + Sync,
    ) -> (SearchOutcome, RobustOutcome) {
        let model = |design: &Pattern| {
            let value = value(design.width_m() * 1e6, design.spacing_m() * 1e6);
            Ok(Response { value: vec![value], limited: Vec::new() })
        };
        let (constraints, options) = (Constraints::default(), SearchOptions::default());
        let nominal = search(target, &space(), &constraints, &options, &model, &Unwatched).unwrap();
        let robust =
            search_robust(target, &space(), &constraints, &options, tolerances, &model, None, &nominal, &Unwatched);
        (nominal, robust.unwrap())
    }

    #[test]
    fn the_mean_squared_residual_of_a_linear_response_is_exact() {
        let model = |design: &Pattern| {
            let [w, s, _] = design.lengths_m().map(|length_m| length_m * 1e6);
            Ok(Response { value: vec![0.9 + 1e-3 * w - 2e-3 * s], limited: vec![w, w] })
        };
        let known = Tolerances { std_m: [4e-6, 3e-6, 0.0], width_spacing_correlation: -0.5, ..Tolerances::default() };
        let limit = |bound| Limit { name: "width", unit: "", unit_si: 1.0, bound, scale: 1.0, loosest: 0.0 };
        let quantities = [limit(Bound::AtMost(1e3)), limit(Bound::AtLeast(1.0))];
        let samples = Samples::new(&model, &quantities, &known).unwrap();
        assert_eq!(samples.count(), 5);
        let design = Pattern::new(Planform::Groove, 100e-6, 50e-6, 5e-6).unwrap();
        let response = samples.respond(&design).unwrap();
        let found = target(0.88).repeated(samples.count()).misfit(&response.value).rms;
        // (0.02 / T)^2 + (a^2 + b^2 - 2 r a b) / T^2, a = 4e-3, b = 6e-3, r = -0.5 and slopes of opposite sign
        let variance = 4e-3_f64.powi(2) + 6e-3_f64.powi(2) + 2.0 * 0.5 * 4e-3 * 6e-3;
        let expected = (0.02_f64.powi(2) + variance).sqrt() / 0.01;
        assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
        assert!(response.limited[0] > 104.0 && response.limited[1] < 96.0, "the worst of the samples");
    }

    #[test]
    fn samples_have_rims_of_other_heights_and_none_below_the_land() {
        let model = |design: &Pattern| Ok(Response { value: vec![design.rim_height_m() * 1e6], limited: Vec::new() });
        let known = Tolerances { rim_height_std_m: 0.05e-6, ..Tolerances::default() };
        let samples = Samples::new(&model, &[], &known).unwrap();
        for (height_um, mean_square) in [(0.3, 0.3_f64.powi(2) + 0.05_f64.powi(2)), (0.0, 0.05_f64.powi(2))] {
            let rim = Rim::new(height_um * 1e-6, 10e-6, RimProfile::Round).unwrap();
            let texture = Texture::new(Planform::Groove).with_rim(rim);
            let heights = samples.respond(&Pattern::new(texture, 1e-4, 1e-4, 1e-5).unwrap()).unwrap().value;
            let found = heights.iter().map(|height| height * height).sum::<f64>() / heights.len() as f64;
            assert!(heights.len() == 3 && heights.iter().all(|height| *height >= 0.0), "{heights:?}");
            assert!((found / mean_square - 1.0).abs() < 1e-9, "{heights:?}");
        }
    }

    #[test]
    fn of_all_designs_on_target_the_least_sensitive_is_chosen() {
        // v = w s / 3e4: on the curve w s = 2.7e4 the variance is (s^2 sw^2 + w^2 ss^2), least where s sw = w ss.
        let (nominal, robust) = both(&target(0.9), &tolerances([8.0, 4.0, 0.0]), |w, s| w * s / 3e4);
        assert_eq!(nominal.status, Status::Met);
        let [w, s] = [robust.best.design.width_m(), robust.best.design.spacing_m()].map(|length_m| length_m * 1e6);
        assert!((w / s - 2.0).abs() < 0.2 && robust.best.misfit.is_met(), "{w} {s}");
        // The least there is: sqrt(2 s sw w ss) = sqrt(2 * 2.7e4 * 32) / 3e4.
        let least = (2.0 * 2.7e4 * 32.0_f64).sqrt() / 3e4 / 0.01;
        assert!(robust.expected.rms < 1.01 * least && robust.expected.rms > 0.99 * least, "{}", robust.expected.rms);
        assert!(robust.expected.rms <= robust.nominal_expected.unwrap().rms);
    }

    #[test]
    fn beside_a_cliff_the_robust_design_stands_back() {
        // Best on paper at a width of 198 um; from 200 um on a cavity closes and friction jumps.
        let value = |w: f64, _: f64| 0.9 + 5e-5 * (w - 198.0) + if w > 200.0 { 0.1 } else { 0.0 };
        let known = tolerances([8.0, 0.0, 0.0]);
        let (nominal, robust) = both(&target(0.9), &known, value);
        assert!(nominal.best.design.width_m() > 190e-6, "{:?}", nominal.best.design);
        let width_um = robust.best.design.width_m() * 1e6;
        assert!((160.0..190.5).contains(&width_um), "{width_um}");
        assert!(robust.best.misfit.is_met() && robust.expected.rms < 0.2 * robust.nominal_expected.unwrap().rms);
        let share = |design: &Pattern| {
            let model = |at: &Pattern, _: &[f64]| Ok(vec![value(at.width_m() * 1e6, 0.0)]);
            let drawn = propagate(&model, design, &Uncertainty::new(&known, &[]).unwrap(), 2000, 1).unwrap();
            drawn.probability(|values| target(0.9).misfit(values).is_met()).share
        };
        let (on_paper, made) = (share(&nominal.best.design), share(&robust.best.design));
        assert!(on_paper < 0.8 && made > 0.85, "{on_paper} {made}");
    }

    #[test]
    fn without_tolerances_nothing_changes() {
        let (nominal, robust) = both(&target(0.9), &tolerances([0.0; 3]), |w, s| w * s / 3e4);
        assert!(robust.expected.rms <= nominal.best.misfit.rms && robust.best.misfit.is_met());
    }
}
