//! Value of looking ahead: cuts are chosen by the chance of being on target within all remaining cuts out of three,
//! instead of by the chance of the next cut alone. The result is in `tests/accuracy/laboratories.md`.

use super::super::draws::{Draw, Draws, between, chance_of};
use super::super::generator::{Scatter, Seen};
use super::super::truth::{DIMENSIONS_STD, SAMPLE_STD, TOLERANCE};
use super::*;

/// Number of candidates with the highest chance, and with the highest information.
const BY_CHANCE: usize = 24;
const BY_INFORMATION: usize = 10;
/// Rounds of the selection: number of rollouts per candidate, and number of candidates kept.
const ROUNDS: [(usize, usize); 3] = [(48, 8), (192, 3), (512, 1)];
/// Number of rollouts that evaluate the chosen and the greedy candidate; they do not affect the choice.
const LAST: usize = 512;
/// Number of cuts within which a sample should be on target.
const CUTS: usize = 3;
/// Numbers of draws, tried in turn until the effective number is sufficient.
const DRAWS: [usize; 3] = [8192, 65536, 262_144];
const ENOUGH_DRAWS: f64 = 1500.0;

/// Draws with nonzero weight: index and weight.
type Weights = Vec<(usize, f64)>;

struct Table<'a> {
    bench: &'a Bench,
    draws: Draws,
    wanted: [[f64; LOADS]; 2],
    noise: f64,
    /// Logarithms of the ratios by texture and draw, without the flat sample's errors and with them.
    logs: Vec<Vec<[f32; LOADS]>>,
    seen: Vec<Vec<[f32; LOADS]>>,
    /// Textures that may be on target in each draw, with the chance.
    near: Vec<Vec<(usize, f64)>>,
}

impl<'a> Table<'a> {
    fn new(bench: &'a Bench, draws: Draws, wanted: [[f64; LOADS]; 2], noise: f64) -> Self {
        let single = |log: [f64; LOADS]| log.map(|x| x as f32);
        let logs: Vec<Vec<[f32; LOADS]>> = (0..bench.textures())
            .map(|place| draws.all.iter().map(|draw| single(bench.generator.log_truth(draw, place))).collect())
            .collect();
        let with_flat =
            |(log, draw): (&[f32; LOADS], &Draw)| std::array::from_fn(|load| log[load] - draw.flat[load] as f32);
        let seen = logs.iter().map(|logs| logs.iter().zip(&draws.all).map(with_flat).collect()).collect();
        let near = (0..draws.all.len())
            .map(|draw| {
                logs.iter()
                    .map(|logs| chance_of(&logs[draw].map(f64::from), &wanted))
                    .enumerate()
                    .filter(|(_, chance)| *chance > 1e-4)
                    .collect()
            })
            .collect();
        Self { bench, draws, wanted, noise, logs, seen, near }
    }

    fn weights(&self) -> Weights {
        self.draws.all.iter().map(|draw| draw.weight).enumerate().collect()
    }

    fn log(&self, draw: usize, place: usize) -> [f64; LOADS] {
        self.logs[place][draw].map(f64::from)
    }

    fn chances(&self, weights: &[(usize, f64)]) -> Vec<f64> {
        let mut chances = vec![0.0; self.bench.textures()];
        for (draw, weight) in weights {
            self.near[*draw].iter().for_each(|(place, chance)| chances[*place] += weight * chance);
        }
        chances
    }

    fn best(&self, weights: &[(usize, f64)], cut: &[usize]) -> usize {
        let chances = self.chances(weights);
        (0..chances.len())
            .filter(|place| !cut.contains(place))
            .max_by(|a, b| chances[*a].total_cmp(&chances[*b]))
            .unwrap()
    }

    /// Information of a cut: sum over loads of ln(1 + spread^2 / noise^2), from the largest component alone.
    fn information(&self, place: usize, weights: &[(usize, f64)]) -> f64 {
        let mut moments = [[0.0; 2]; LOADS];
        for (draw, weight) in weights {
            let log = self.seen[place][*draw].map(f64::from);
            for load in 0..LOADS {
                let y = log[load];
                moments[load][0] += weight * y;
                moments[load][1] += weight * y * y;
            }
        }
        let of = |m: &[f64; 2]| ((m[1] - m[0] * m[0]) / (self.noise * self.noise + SAMPLE_STD * SAMPLE_STD)).ln_1p();
        moments.iter().map(of).sum()
    }

    /// Probability of being on target within `left` cuts in the laboratory `draw`, if `place` is cut first and then the
    /// greedy choice.
    fn rollout(
        &self,
        draw: usize,
        place: usize,
        left: usize,
        weights: &[(usize, f64)],
        cut: &[usize],
        normals: &mut Normals,
    ) -> f64 {
        let own = self.log(draw, place);
        let chance = chance_of(&own, &self.wanted);
        if left == 1 || chance > 0.99 {
            return chance;
        }
        // A sample that misses, measured.
        let mut sample = own;
        for _ in 0..100 {
            let (t, more) = (SAMPLE_STD * normals.draw(), 1.0 + DIMENSIONS_STD * normals.draw());
            sample = own.map(|log| more * log + t);
            if !is_within(&sample, &self.wanted) {
                break;
            }
        }
        let flat = self.draws.all[draw].flat;
        let measured: [f64; LOADS] =
            std::array::from_fn(|load| sample[load] + self.noise * normals.draw() - flat[load]);
        let after = self.after(weights, place, &measured, Some(draw));
        let cut = [cut, &[place]].concat();
        let next = self.best(&after, &cut);
        chance + (1.0 - chance) * self.rollout(draw, next, left - 1, &after, &cut, normals)
    }

    /// Weights after a sample of `place` that missed the target; the draw `but` is excluded.
    fn after(&self, weights: &[(usize, f64)], place: usize, measured: &[f64; LOADS], but: Option<usize>) -> Weights {
        let (seen, single) = (&self.seen[place], measured.map(|x| x as f32));
        // Farther than seven standard deviations.
        let most = DIMENSIONS_STD * measured.iter().map(|x| x.abs()).fold(0.0, f64::max) * 1.3;
        let far = 7.0 * (self.noise * self.noise + SAMPLE_STD * SAMPLE_STD + most * most).sqrt() as f32;
        let mut found: Weights = Vec::new();
        for (draw, weight) in weights {
            if (0..LOADS).any(|load| (single[load] - seen[*draw][load]).abs() > far) || but == Some(*draw) {
                continue;
            }
            let rest: [f64; LOADS] = std::array::from_fn(|load| measured[load] - f64::from(seen[*draw][load]));
            let log = weight.ln() + Scatter::new(&self.log(*draw, place), self.noise).log_density(&rest);
            found.push((*draw, log));
        }
        let most = found.iter().map(|(_, log)| *log).fold(f64::NEG_INFINITY, f64::max);
        found.retain(|(_, log)| log - most > -9.0);
        for (draw, log) in &mut found {
            let own = self.log(*draw, place);
            let rest: [f64; LOADS] = std::array::from_fn(|load| measured[load] - f64::from(seen[*draw][load]));
            *log = (*log - most).exp() * (1.0 - Scatter::new(&own, self.noise).chance(&own, &rest, &self.wanted));
        }
        let sum: f64 = found.iter().map(|(_, weight)| weight).sum();
        if sum <= 0.0 {
            return weights.to_vec();
        }
        found.iter_mut().for_each(|(_, weight)| *weight /= sum);
        found
    }

    /// Mean probability over rollouts for each of `candidates`; all use the same laboratories and errors.
    fn values(&self, candidates: &[usize], left: usize, count: usize, cut: &[usize], seed: u64) -> Vec<f64> {
        let weights = self.weights();
        let mut cumulated = 0.0;
        let cumulated: Vec<f64> = weights
            .iter()
            .map(|(_, weight)| {
                cumulated += weight;
                cumulated
            })
            .collect();
        let mut sums = vec![0.0; candidates.len()];
        for number in 0..count {
            let mut normals = Normals::new(seed.wrapping_mul(1_000_003).wrapping_add(number as u64));
            let at = normal_probability(normals.draw());
            let draw = cumulated.partition_point(|sum| *sum < at).min(weights.len() - 1);
            for (sum, place) in sums.iter_mut().zip(candidates) {
                *sum += self.rollout(draw, *place, left, &weights, cut, &mut normals.clone());
            }
        }
        sums.into_iter().map(|sum| sum / count as f64).collect()
    }

    /// Best candidate for `left` cuts, and the values of this and of the greedy candidate by separate rollouts.
    fn look(&self, left: usize, cut: &[usize]) -> (usize, [f64; 2]) {
        let weights = self.weights();
        let greedy = self.best(&weights, cut);
        let chances = self.chances(&weights);
        let mut open: Vec<usize> = (0..chances.len()).filter(|place| !cut.contains(place)).collect();
        open.sort_by(|a, b| chances[*b].total_cmp(&chances[*a]));
        let mut left_over = open.split_off(BY_CHANCE);
        let told: Vec<f64> = (0..chances.len()).map(|place| self.information(place, &weights)).collect();
        left_over.sort_by(|a, b| told[*b].total_cmp(&told[*a]));
        open.extend(left_over.into_iter().take(BY_INFORMATION));
        for (round, (count, keep)) in ROUNDS.into_iter().enumerate() {
            let values = self.values(&open, left, count, cut, round as u64);
            let mut order: Vec<usize> = (0..open.len()).collect();
            order.sort_by(|a, b| values[*b].total_cmp(&values[*a]));
            open = order.into_iter().take(keep).map(|at| open[at]).collect();
        }
        let values = self.values(&[open[0], greedy], left, LAST, cut, 99);
        (open[0], [values[0], values[1]])
    }
}

/// Prints the gain of looking ahead, by rollouts and in the laboratories, for the start START (0 nothing, 1 one groove,
/// 2 the squares).
#[test]
#[ignore = "half a minute for each of LABORATORIES, 1 when absent"]
#[expect(clippy::print_stdout, reason = "prints a table of tests/accuracy/laboratories.md")]
fn what_looking_ahead_gains() {
    let options =
        Options { laboratories: asked("LABORATORIES", 1), seed: asked("SEED", 1) as u64, ..Options::default() };
    let bench = Bench::new(&options, &Unwatched).unwrap();
    let start = Start::ALL[asked("START", 0).min(2)];
    let go = |number: usize| {
        let job = Job { start, policy: Policy::Generator, number, target: TargetOf::Reached };
        let Begun { mut laboratory, target, mut cut, trials, .. } = bench.begin(job);
        let wanted = between(&target, TOLERANCE);
        let mut seen: Vec<Seen> =
            trials.iter().zip(&cut).map(|(trial, place)| Seen::new(trial, *place, false)).collect();
        let (mut values, mut on_target) = (Vec::new(), None);
        for left in (1..=CUTS).rev() {
            let mut draws = Draws::default();
            for count in DRAWS {
                let all = bench.generator.draws(&seen, laboratory.noise, &wanted, count);
                draws = all.of_reached(&bench.generator, &target);
                if draws.effective() >= ENOUGH_DRAWS {
                    break;
                }
            }
            let table = Table::new(&bench, draws, wanted, laboratory.noise);
            let place = if left > 1 {
                let (place, found) = table.look(left, &cut);
                values.push((left, found));
                place
            } else {
                table.best(&table.weights(), &cut)
            };
            let made = laboratory.cut(&bench.textures[place]);
            if is_within(&made.truth, &around(&target, TOLERANCE)) {
                on_target = Some(CUTS + 1 - left);
                break;
            }
            seen.push(Seen::new(&made.trial, place, true));
            cut.push(place);
        }
        println!("{number}, {}: on target with {on_target:?}, [ahead, greedy] {values:?}", job.mechanism().name());
        (job.mechanism().is_inside(), on_target, values)
    };
    let found: Vec<_> = (0..options.laboratories).into_par_iter().map(go).collect();
    for is_inside in [true, false] {
        let own: Vec<_> = found.iter().filter(|(inside, ..)| *inside == is_inside).collect();
        let on_target = own.iter().filter(|(_, cuts, _)| cuts.is_some()).count();
        println!("{}, inside {is_inside}: {on_target} of {} on target", start.name(), own.len());
        for left in (2..=CUTS).rev() {
            let of: Vec<[f64; 2]> = own
                .iter()
                .flat_map(|(.., values)| values.iter().filter(|(own, _)| *own == left).map(|(_, values)| *values))
                .collect();
            let mean = |k: usize| of.iter().map(|values| values[k]).sum::<f64>() / of.len().max(1) as f64;
            println!("  {left} cuts left, {}: ahead {:.4}, greedy {:.4}", of.len(), mean(0), mean(1));
        }
    }
}
