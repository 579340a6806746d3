//! Disc of two sectors that teaches most about the mechanism of the model error, `next --learn`.
//!
//! The pair of textures has the greatest mutual information between the mechanism, which is the family of the
//! discrepancy's form, and the two measured ratios. Both sectors share the scatter of the disc, so that the quotient of
//! the two ratios is known better than either. Grooves may lie across or along the sliding
//! direction; other planforms keep their directions.

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use slipgrid_base::monitor::Monitor;
use slipgrid_base::units::tidy;
use slipgrid_infer::discrepancy::Distribution;
use slipgrid_laser::export::Division;
use slipgrid_model::pattern::{Pattern, Planform, Texture};

use crate::DesignError;
use crate::as_cut::CutTexture;
use crate::band::Asked;
use crate::next_report::{NextReport, RatioPrediction};
use crate::next_trial::{NextOptions, NextTrials, coarse, new_report, unkept};
use crate::optimize::DesignSpace;
use crate::prediction::{MEASURED_STD, Prediction, percent};
use crate::prepared_task::PreparedTask;
use crate::results::{SCREEN_WIDTH, Table, believed, wrapped};
use crate::search::Search;
use crate::session::with_table;
use crate::steps::Steps;
use crate::task::{DesignTask, FurtherDirections, SearchOptions};
use crate::time_budget::TimeBudget;
use crate::timings::Timings;

/// Number of sectors of the disc.
pub const SECTORS: usize = 2;
/// Maximum number of designs in each direction from which pairs are formed: about three along each length, because
/// forms change little between neighbours. A round of replacements takes 4 times this many estimates of 40 ms.
const CANDIDATES: usize = 48;
/// A pair replaces another if its information is higher by this share, the error of the estimated information.
const CLEARLY_MORE: f64 = 0.05;
/// Maximum number of replacements; two or three are usual, and give 95 % of the information of the best of all pairs
/// (`the_pair_teaches_nearly_as_much_as_the_best_of_all`).
const MAX_ROUNDS: usize = 8;
/// Proposed content of a second disc, which separates the dose of the laser and the scatter of flat samples from the
/// texture.
const SECOND_DISC: &str =
    "leave one half flat, and give the other half the laser dose of sector 1 beside the track (a sham)";

/// Information of a disc of two sectors about the mechanism of the model error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LearningReport {
    /// Information about the mechanism from measuring both sectors at all loads to 1 %, in bits.
    pub bits: f64,
    /// Information that certainty about the mechanism would give, in bits.
    pub open_bits: f64,
    /// Reason for this pair of textures, in words.
    pub why: String,
    /// Proposed content of a second disc.
    pub second_disc: String,
    /// Texture of each sector, in words.
    pub textures: Vec<String>,
    /// Index of the load at which the quotient of the two ratios gives most information about the mechanism.
    pub load: usize,
    /// Mechanisms, sorted by decreasing weight.
    pub mechanisms: Vec<MechanismReport>,
}

/// Ratios of both sectors if one mechanism holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MechanismReport {
    /// Quantity that the model error grows with.
    pub mechanism: String,
    /// Probability of the mechanism, given the trials.
    pub weight: f64,
    /// Predictions, one per load.
    pub loads: Vec<SectorRatios>,
}

/// Ratios of both sectors at one load.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SectorRatios {
    /// Ratio of each sector to the flat surface.
    pub ratios: [RatioPrediction; SECTORS],
    /// Ratio of sector 2 over that of sector 1.
    pub quotient: RatioPrediction,
}

impl LearningReport {
    /// Describes `pair` with the joint `distribution` of the ratios of both sectors and the reason `why`.
    fn new(pair: &[Prediction; SECTORS], distribution: &Distribution, asked: &Asked, why: String) -> Self {
        let n = asked.loads.len();
        let modelled = |sector: usize, load: usize| pair[sector].texture.ratio[load];
        let mut mechanisms: Vec<MechanismReport> = Vec::new();
        let mut open_bits = 0.0;
        for (family, weight) in distribution.families() {
            let own = distribution.if_family(family);
            let at = |load: usize| {
                let ratio =
                    |sector| RatioPrediction::new(&asked.loads[load], modelled(sector, load), &own, sector * n + load);
                let quotient = modelled(1, load) / modelled(0, load);
                let difference = own.difference(load, n + load);
                SectorRatios {
                    ratios: [ratio(0), ratio(1)],
                    quotient: RatioPrediction::new(&asked.loads[load], quotient, &difference, 0),
                }
            };
            // H = -sum p log2 p
            open_bits -= weight * weight.log2();
            let loads = (0..n).map(at).collect();
            mechanisms.push(MechanismReport { mechanism: family.to_owned(), weight: tidy(weight), loads });
        }
        mechanisms.sort_by(|a, b| b.weight.total_cmp(&a.weight));
        let by_load: Vec<f64> =
            (0..n).map(|load| distribution.difference(load, n + load).family_bits(MEASURED_STD)).collect();
        Self {
            bits: tidy(distribution.family_bits(MEASURED_STD)),
            open_bits: tidy(open_bits),
            why,
            second_disc: SECOND_DISC.to_owned(),
            textures: pair.iter().map(|of| in_words(&of.texture.pattern)).collect(),
            load: (0..n).max_by(|a, b| by_load[*a].total_cmp(&by_load[*b]).then(b.cmp(a))).unwrap_or(0),
            mechanisms,
        }
    }

    /// Formats the sectors and the predictions by mechanism at one load.
    pub(crate) fn text(&self) -> String {
        let mut text = String::new();
        for (place, sector) in self.textures.iter().enumerate() {
            text += &format!("  sector {}: {sector}\n", place + 1);
        }
        text += &wrapped(&format!("  {}", self.why), SCREEN_WIDTH, "    ", 3);
        let at = self.mechanisms.first().and_then(|first| first.loads.get(self.load));
        let pressure_mpa = at.map_or(f64::NAN, |at| at.quotient.pressure_mpa);
        text += &format!(
            "\n  ratio to the flat surface at {pressure_mpa} MPa (95 % of samples), if the model error grows with\n"
        );
        let mut table = Table::new(["", "weight", "sector 1", "sector 2", "sector 2 / 1"]);
        for of in &self.mechanisms {
            let Some(at) = of.loads.get(self.load) else { continue };
            let words = |of: &RatioPrediction| {
                let [median, low, high] = [of.ratio, of.interval_95[0], of.interval_95[1]].map(|own| believed(own, 2));
                format!("{median} ({low} to {high})")
            };
            let [first, second] = at.ratios.each_ref().map(words);
            table.row([of.mechanism.clone(), percent(of.weight), first, second, words(&at.quotient)]);
        }
        text += &table.to_string();
        text += &format!(
            "measuring both sectors would teach {:.2} of the {:.2} bits that tell the mechanisms apart\n",
            self.bits, self.open_bits
        );
        text + &wrapped(&format!("second disc, if you can cut one: {}", self.second_disc), SCREEN_WIDTH, "  ", 2) + "\n"
    }
}

/// Describes the texture of a sector in words.
fn in_words(pattern: &Pattern) -> String {
    let texture = pattern.texture();
    let direction = match texture.sliding_direction() {
        _ if texture.planform() != Planform::Groove => String::new(),
        [_, 0.0] => " across the sliding direction".to_owned(),
        [0.0, _] => " along the sliding direction".to_owned(),
        _ => " aslant to the sliding direction".to_owned(),
    };
    let [width, spacing, depth] = pattern.lengths_m().map(|length_m| tidy(1e6 * length_m));
    format!("{}s{direction}, {width} um wide, spacing {spacing} um, {depth} um deep", texture.planform().name())
}

/// Turns the grooves of `texture` along the sliding direction if `is_along`, otherwise across.
fn laid(texture: &Texture, is_along: bool) -> Result<Texture, DesignError> {
    let angle_deg = texture.sliding_angle_deg() + if is_along { 90.0 } else { 0.0 };
    // Grooves are equal after half a turn.
    let folded_deg = angle_deg - 180.0 * (angle_deg / 180.0 - 0.5).ceil();
    texture.with_groove_angle_deg(folded_deg).map_err(|error| DesignError::refused(error.to_string()))
}

/// Tasks of the textures that a sector may carry: grooves across and grooves along the sliding direction, or for other
/// planforms `task` alone. Further sliding directions are dropped, because trials are measured in one direction.
fn tasks(task: &DesignTask) -> Result<Vec<PreparedTask>, DesignError> {
    let one = DesignTask { directions: FurtherDirections::default(), ..task.clone() };
    if task.space.texture().planform() != Planform::Groove {
        return Ok(vec![PreparedTask::new(&one)?]);
    }
    let of = |is_along: bool| {
        let texture = laid(task.space.texture(), is_along)?;
        let [width_m, spacing_m, depth_m] = task.space.lengths_m();
        let space = DesignSpace::new(texture, width_m, spacing_m, depth_m);
        let space = space.map_err(|error| DesignError::refused(error.to_string()))?;
        let dimensions = task.search.dimensions.filter(|_| texture == *task.space.texture());
        PreparedTask::new(&DesignTask {
            space,
            search: SearchOptions { dimensions, ..one.search.clone() },
            ..one.clone()
        })
    };
    [false, true].into_iter().map(of).collect()
}

/// Finds the two textures of `task` for the sectors of `division`.
///
/// # Errors
/// [`DesignError`] for a task that is refused, that the monitor cancels, or whose bounds leave a single texture.
pub fn choose(task: &DesignTask, options: &NextOptions, division: &Division, budget: TimeBudget<'_>) -> Chosen {
    let monitor = budget.monitor;
    let on_disc = |prepared: &PreparedTask, then: &dyn Fn(&Search<'_>) -> Chosen| {
        with_table(prepared, Some(division), None, budget, &mut Timings::default(), |search, _| then(search))
    };
    match &tasks(task)?[..] {
        [across, along] => {
            on_disc(across, &|across| on_disc(along, &|along| pair(&[across, along], options, division, monitor)))
        }
        all => on_disc(&all[0], &|search| pair(&[search], options, division, monitor)),
    }
}

/// Report and textures of the sectors.
type Chosen = Result<NextTrials, DesignError>;

/// Designs of `search` that fit on a sector and are not pending, spread over the bounds.
fn candidates(search: &Search<'_>, options: &NextOptions, division: &Division) -> Vec<CutTexture> {
    let spread = Steps::new(search.task).spread(CANDIDATES).into_iter();
    let open = spread.filter(|pattern| options.is_open(pattern, Some(division)));
    open.filter_map(|pattern| search.interpolated(&pattern)).collect()
}

/// Pair of indices of textures, with its information in bits.
type Pair = ([usize; SECTORS], f64);

/// Returns the best pair of `starts`, and the pair reached by replacing one of its textures by another of the `count`
/// textures as long as that gives clearly more information. `bits` computes the information of a pair; `None` without
/// starts.
fn greatest(
    starts: &[[usize; SECTORS]],
    count: usize,
    bits: &(dyn Fn([usize; SECTORS]) -> f64 + Sync),
) -> Option<[Pair; 2]> {
    let most = |pairs: &[[usize; SECTORS]]| -> Option<Pair> {
        let each: Vec<Pair> = pairs.par_iter().map(|pair| (*pair, bits(*pair))).collect();
        each.into_iter().reduce(|best, next| if next.1 > best.1 { next } else { best })
    };
    let start = most(starts)?;
    let mut best = start;
    for _ in 0..MAX_ROUNDS {
        let [a, b] = best.0;
        let others: Vec<[usize; SECTORS]> =
            (0..count).filter(|other| ![a, b].contains(other)).flat_map(|other| [[a, other], [other, b]]).collect();
        let next = most(&others).filter(|next| next.1 > (1.0 + CLEARLY_MORE) * best.1);
        let Some(next) = next else { break };
        best = next;
    }
    Some([start, best])
}

/// Chooses the pair of textures that gives most information, solves and reports it. `searches` are of grooves across
/// and along sliding, or one of another planform.
fn pair(searches: &[&Search<'_>], options: &NextOptions, division: &Division, monitor: &dyn Monitor) -> Chosen {
    let search = searches[0];
    let of_side = |(side, of): (usize, &&Search<'_>)| {
        candidates(of, options, division).into_iter().map(move |texture| (side, texture))
    };
    let (all, unkept_by): (Vec<(usize, CutTexture)>, _) =
        searches.iter().enumerate().flat_map(of_side).partition(|(_, texture)| texture.excess == 0.0);
    let joint = |pair: [&CutTexture; SECTORS]| search.predictor.on_one_disc(&pair.map(CutTexture::candidate));
    // The last search began last, so that its stage ends last.
    let last = searches[searches.len() - 1];
    let bits = |[a, b]: [usize; SECTORS]| {
        let is_in_time = !last.stage.cancelled();
        if is_in_time { joint([&all[a].1, &all[b].1]).family_bits(MEASURED_STD) } else { f64::NEG_INFINITY }
    };
    let is_equal = |a: usize, b: usize| all[a].1.pattern.lengths_m() == all[b].1.pattern.lengths_m();
    let pairs = |first: usize| (0..all.len()).map(move |second| [first, second]);
    // Grooves across and along with equal dimensions, or the first and the last texture with each other one.
    let has_directions = searches.len() == SECTORS;
    let starts: Vec<[usize; SECTORS]> = if has_directions {
        (0..all.len()).flat_map(pairs).filter(|[a, b]| all[*a].0 < all[*b].0 && is_equal(*a, *b)).collect()
    } else {
        [0, all.len().saturating_sub(1)].into_iter().flat_map(pairs).filter(|[a, b]| a != b).collect()
    };
    let Some([start, best]) = greatest(&starts, all.len(), &bits) else {
        return Err(DesignError::NothingToCut(match (all.len(), unkept_by.len()) {
            (0, 1..) => {
                let nearest = unkept_by.iter().min_by(|a, b| a.1.excess.total_cmp(&b.1.excess));
                unkept(&nearest.map_or_else(Vec::new, |(side, texture)| searches[*side].violated_by(texture)))
            }
            (1, _) => ONE_TEXTURE.to_owned(),
            _ => coarse(division),
        }));
    };
    monitor.heed()?;
    if best.1 == f64::NEG_INFINITY {
        return Err(last.nothing_found());
    }
    let [a, b] = if all[best.0[0]].0 > all[best.0[1]].0 { [best.0[1], best.0[0]] } else { best.0 };
    let failed = |failure| DesignError::Failed(format!("a sector cannot be computed: {failure}"));
    let solved = |place: usize| searches[all[place].0].solved(&all[place].1.pattern).map_err(failed);
    let chosen = [solved(a)?, solved(b)?];
    monitor.heed()?;
    let why = match (has_directions, is_equal(a, b)) {
        (true, true) => "equal dimensions: mechanisms that no direction changes predict equal model errors".to_owned(),
        (true, false) => {
            format!("teaches more than the best pair of equal dimensions across and along, {:.2} bits", start.1)
        }
        _ => format!(
            "{}s have no direction across or along: of the textures within the bounds these two teach most",
            all[a].1.pattern.texture().planform().name()
        ),
    };
    let distribution = joint([&chosen[0].texture, &chosen[1].texture]);
    let learning = LearningReport::new(&chosen, &distribution, search.asked, why);
    let report = NextReport {
        advice: "learn".to_owned(),
        words: "cut one disc of two sectors to learn which mechanism the model lacks".to_owned(),
        compared: all.len(),
        samples: chosen.iter().map(|of| of.report(search)).collect(),
        learning: Some(learning),
        cut_short: last.stage.cancelled().then(|| "search".to_owned()).into_iter().collect(),
        ..new_report(search, options)
    };
    let patterns = chosen.iter().map(|of| of.texture.pattern).collect();
    Ok(NextTrials { report, advice: None, patterns, sectors: Vec::new() })
}

/// Message if only one texture lies within the bounds.
const ONE_TEXTURE: &str =
    "the bounds leave a single texture without a direction: expected bounds of at least two textures, or grooves";

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_infer::discrepancy::{
        Candidate, Conditions, Discrepancy, Features, Hyperparameters, Load, Sensitivity,
    };

    /// Grooves of several widths, spacings and depths before any trial: the pair found against all pairs.
    #[test]
    fn the_pair_teaches_nearly_as_much_as_the_best_of_all() {
        let prior = Discrepancy::new(Hyperparameters::default(), Conditions::default(), 0.2, Vec::new()).unwrap();
        let loads = [0.65e6, 2.6e6].map(|pressure_pa| Load { pressure_pa, speed_m_s: 2e-3, humidity: 0.4 });
        let lengths = [60e-6, 300e-6].iter().flat_map(|width| [100e-6, 500e-6].map(|spacing| (*width, spacing)));
        let lengths = lengths.flat_map(|(width, spacing)| [5e-6, 30e-6].map(|depth| [width, spacing, depth]));
        let all: Vec<Features> = lengths
            .map(|[width, spacing, depth]| (&Pattern::new(Planform::Groove, width, spacing, depth).unwrap()).into())
            .collect();
        let sensitivity = [Sensitivity::of_modulus(0.1); 2];
        let candidate = |of: usize| Candidate {
            features: all[of],
            modelled: &[0.9, 0.8],
            sensitivity: &sensitivity,
            covariance: &[],
            dimension_shifts: &[],
        };
        let predictor = prior.at(&loads);
        let bits = |pair: [usize; 2]| predictor.on_one_disc(&pair.map(candidate)).family_bits(MEASURED_STD);
        let pairs = |first: usize| (0..all.len()).filter(move |other| *other != first).map(move |other| [first, other]);
        let starts: Vec<[usize; 2]> = [0, all.len() - 1].into_iter().flat_map(pairs).collect();
        let [start, found] = greatest(&starts, all.len(), &bits).unwrap();
        let best = (0..all.len()).flat_map(pairs).map(bits).fold(0.0, f64::max);
        assert!(found.1 >= start.1 && found.1 >= 0.95 * best && best > 0.1, "{start:?} {found:?} {best}");
        assert_eq!(bits(found.0), found.1);
        assert!(greatest(&[], 1, &bits).is_none());
    }

    #[test]
    fn grooves_lie_across_or_along_whatever_the_sliding_direction() {
        for sliding_deg in [-180.0, -90.0, -35.0, 0.0, 35.0, 90.0, 120.0, 180.0] {
            let texture = Texture::new(Planform::Groove).with_sliding_angle_deg(sliding_deg).unwrap();
            let [across, along] = [false, true].map(|is_along| laid(&texture, is_along).unwrap().sliding_direction());
            assert!(across[1].abs() < 1e-12 && along[0].abs() < 1e-12, "{sliding_deg}: {across:?} {along:?}");
        }
        let pattern = |is_along| {
            let texture = laid(&Texture::new(Planform::Groove), is_along).unwrap();
            in_words(&Pattern::new(texture, 120e-6, 3e-4, 1.04e-5).unwrap())
        };
        assert_eq!(pattern(false), "grooves across the sliding direction, 120 um wide, spacing 300 um, 10.4 um deep");
        assert!(pattern(true).starts_with("grooves along the sliding"));
    }
}
