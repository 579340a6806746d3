//! The solver's passes over the map, each fused so that memory is read once. Pressures are in double precision, gaps and
//! what makes up a direction in single. Sums run in double precision and fixed lanes: the same result on every run and
//! whatever vector instructions the machine has.

use multiversion::multiversion;

/// Sums that run side by side.
const LANES: usize = 8;
type Lanes = [f64; LANES];

/// Sums of `body` over the points, `body` taking one value of each input.
#[inline(always)]
fn sums<const I: usize, const S: usize>(inputs: [&[f32]; I], body: impl Fn([f64; I]) -> [f64; S]) -> [f64; S] {
    let inputs = inputs.map(|input| input.as_chunks::<LANES>());
    let mut sums = [[0.0; LANES]; S];
    for n in 0..inputs[0].0.len() {
        let values: [&[f32; LANES]; I] = std::array::from_fn(|i| &inputs[i].0[n]);
        for lane in 0..LANES {
            let terms = body(std::array::from_fn(|i| f64::from(values[i][lane])));
            for s in 0..S {
                sums[s][lane] += terms[s];
            }
        }
    }
    for n in 0..inputs[0].1.len() {
        let terms = body(std::array::from_fn(|i| f64::from(inputs[i].1[n])));
        for s in 0..S {
            sums[s][0] += terms[s];
        }
    }
    sums.map(total)
}

fn total(lanes: Lanes) -> f64 {
    let [a, b, c, d, e, f, g, h] = lanes;
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}

/// 1 or 0.
#[inline(always)]
fn when(condition: bool) -> f64 {
    if condition { 1.0 } else { 0.0 }
}

/// a . b
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(crate) fn dot(a: &[f32], b: &[f32]) -> f64 {
    sums([a, b], |[a, b]| [a * b])[0]
}

/// Pressures of a lowered state.
pub(crate) struct Pressed {
    /// Sum of those above zero.
    pub(crate) sum: f64,
    /// How many they are.
    pub(crate) count: f64,
    /// Of so many.
    pub(crate) points: f64,
}

/// The pressures `level` + f of one in `every` groups of eight points.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(crate) fn pressed(fluctuation: &[f64], level: f64, every: usize) -> Pressed {
    let (mut sum, mut count, mut points) = ([0.0; LANES], [0.0; LANES], 0);
    for f in fluctuation.chunks(LANES).step_by(every) {
        for (lane, f) in f.iter().enumerate() {
            let pressure = level + f;
            sum[lane] += if pressure > 0.0 { pressure } else { 0.0 };
            count[lane] += when(pressure > 0.0);
        }
        points += f.len();
    }
    Pressed { sum: total(sum), count: total(count), points: points as f64 }
}

/// What is known of a gap after a pass over the map.
pub(crate) struct Gap {
    /// Its mean over p > 0.
    pub(crate) shift: f64,
    /// Its lowest value.
    pub(crate) lowest: f64,
    /// Its product with the pressure.
    pub(crate) work: f64,
}

/// The sums of a [`Gap`], side by side.
struct GapSums {
    sum: Lanes,
    count: Lanes,
    work: Lanes,
    lowest: Lanes,
}

impl GapSums {
    fn new() -> Self {
        Self { sum: [0.0; LANES], count: [0.0; LANES], work: [0.0; LANES], lowest: [f64::INFINITY; LANES] }
    }

    /// Takes up to [`LANES`] points in, one sum after the other so that each becomes one vector's.
    #[inline(always)]
    fn add(&mut self, pressure: &[f64], gap: &[f64]) {
        let Self { sum, count, work, lowest } = self;
        let points = gap.len();
        for lane in 0..points {
            sum[lane] += if pressure[lane] > 0.0 { gap[lane] } else { 0.0 };
        }
        for lane in 0..points {
            count[lane] += when(pressure[lane] > 0.0);
        }
        for lane in 0..points {
            work[lane] += gap[lane] * pressure[lane];
        }
        for lane in 0..points {
            lowest[lane] = if gap[lane] < lowest[lane] { gap[lane] } else { lowest[lane] };
        }
    }

    /// With pressures `scale` times as high.
    fn total(&self, scale: f64) -> Gap {
        let lowest = self.lowest.into_iter().fold(f64::INFINITY, f64::min);
        Gap { shift: total(self.sum) / total(self.count), lowest, work: scale * total(self.work) }
    }
}

/// The gap scale u - h.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(crate) fn measure(pressure: &[f64], displacement: &[f64], height: &[f64], scale: f64) -> Gap {
    let mut sums = GapSums::new();
    let (pressures, p) = pressure.as_chunks::<LANES>();
    let (displacements, u) = displacement.as_chunks::<LANES>();
    let (heights, h) = height.as_chunks::<LANES>();
    for ((p, u), h) in pressures.iter().zip(displacements).zip(heights) {
        measure_lanes(p, u, h, scale, &mut sums);
    }
    measure_lanes(p, u, h, scale, &mut sums);
    sums.total(scale)
}

#[inline(always)]
fn measure_lanes(pressure: &[f64], displacement: &[f64], height: &[f64], scale: f64, sums: &mut GapSums) {
    let mut gap = [0.0; LANES];
    for ((g, u), h) in gap.iter_mut().zip(displacement).zip(height) {
        *g = scale * u - h;
    }
    sums.add(pressure, &gap[..pressure.len()]);
}

/// g = scale u - h - shift
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(crate) fn gap(gap: &mut [f32], displacement: &[f64], height: &[f64], scale: f64, shift: f64) {
    for ((g, &u), &h) in gap.iter_mut().zip(displacement).zip(height) {
        *g = (scale * u - h - shift) as f32;
    }
}

/// g = g - shift where the pressure may change, p > 0 or g < 0, zero elsewhere; never zero where it may.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(crate) fn masked_gap(residual: &mut [f32], pressure: &[f64], gap: &[f32], shift: f64) {
    for ((r, &p), &g) in residual.iter_mut().zip(pressure).zip(gap) {
        let gap = (f64::from(g) - shift) as f32;
        let kept = if gap == 0.0 { f32::MIN_POSITIVE } else { gap };
        *r = if (p > 0.0) | (gap < 0.0) { kept } else { 0.0 };
    }
}

/// Products of the preconditioned gap z, masked and less its mean over free points.
pub(crate) struct Fit {
    /// The mean of z over free points.
    pub(crate) mean: f64,
    /// z . r
    pub(crate) now: f64,
    /// z . r of the previous iteration
    pub(crate) before: f64,
}

#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(crate) fn fit(preconditioned: &[f32], residual: &[f32], previous: &[f32]) -> Fit {
    let [count, z, r, zr, before, z_before] = sums([preconditioned, residual, previous], |[z, r, before]| {
        let mask = r != 0.0;
        let (z, before) = (if mask { z } else { 0.0 }, if mask { before } else { 0.0 });
        [when(mask), z, r, z * r, before, z * before]
    });
    let mean = z / count;
    Fit { mean, now: zr - mean * r, before: z_before - mean * before }
}

/// d = -(z - mean) + beta d on free points, zero elsewhere; returns r . d.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(crate) fn turn(direction: &mut [f32], preconditioned: &[f32], residual: &[f32], mean: f32, beta: f32) -> f64 {
    let mut slope = [0.0; LANES];
    let (directions, d) = direction.as_chunks_mut::<LANES>();
    let (chunks, z) = preconditioned.as_chunks::<LANES>();
    let (residuals, r) = residual.as_chunks::<LANES>();
    for ((d, z), r) in directions.iter_mut().zip(chunks).zip(residuals) {
        turn_lanes(d, z, r, mean, beta, &mut slope);
    }
    turn_lanes(d, z, r, mean, beta, &mut slope);
    total(slope)
}

#[inline(always)]
fn turn_lanes(direction: &mut [f32], z: &[f32], r: &[f32], mean: f32, beta: f32, slope: &mut Lanes) {
    let count = direction.len();
    let mut turned = [0.0; LANES];
    for lane in 0..count {
        let value = mean - z[lane] + beta * direction[lane];
        turned[lane] = if r[lane] != 0.0 { value } else { 0.0 };
    }
    for lane in 0..count {
        slope[lane] += f64::from(turned[lane]) * f64::from(r[lane]);
    }
    direction.copy_from_slice(&turned[..count]);
}

/// What a step did to the pressures.
pub(crate) struct Moved {
    /// Their sum.
    pub(crate) sum: f64,
    /// How many are positive.
    pub(crate) count: f64,
    /// Some were negative and set to zero.
    pub(crate) clipped: bool,
}

/// p = scale p_before + step d, negative pressures to zero; `moved` becomes what each pressure changed by.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(crate) fn advance(
    pressure: &mut [f64],
    before: &[f64],
    direction: &[f32],
    moved: &mut [f32],
    scale: f64,
    step: f64,
) -> Moved {
    let (mut lowest, mut sum, mut number) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
    let (pressures, p) = pressure.as_chunks_mut::<LANES>();
    let (befores, b) = before.as_chunks::<LANES>();
    let (directions, d) = direction.as_chunks::<LANES>();
    let (changes, m) = moved.as_chunks_mut::<LANES>();
    for (((p, b), d), m) in pressures.iter_mut().zip(befores).zip(directions).zip(changes) {
        advance_lanes(p, b, d, m, (scale, step), (&mut lowest, &mut sum, &mut number));
    }
    advance_lanes(p, b, d, m, (scale, step), (&mut lowest, &mut sum, &mut number));
    Moved { sum: total(sum), count: total(number), clipped: lowest.iter().any(|&low| low < 0.0) }
}

#[inline(always)]
fn advance_lanes(
    pressure: &mut [f64],
    before: &[f64],
    direction: &[f32],
    moved: &mut [f32],
    (scale, step): (f64, f64),
    (lowest, sum, number): (&mut Lanes, &mut Lanes, &mut Lanes),
) {
    let count = pressure.len();
    let (mut kept, mut changes) = ([0.0; LANES], [0.0; LANES]);
    for lane in 0..count {
        let before = scale * before[lane];
        let free = before + step * f64::from(direction[lane]);
        lowest[lane] = if free < lowest[lane] { free } else { lowest[lane] };
        kept[lane] = if free > 0.0 { free } else { 0.0 };
        changes[lane] = (kept[lane] - before) as f32;
        sum[lane] += kept[lane];
        number[lane] += when(free > 0.0);
    }
    pressure.copy_from_slice(&kept[..count]);
    moved.copy_from_slice(&changes[..count]);
}

/// p = p - `excess` where p is positive, to zero where that is negative; `moved` follows. Returns the sum of p.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(crate) fn lower(pressure: &mut [f64], moved: &mut [f32], excess: f64) -> f64 {
    let mut sum = [0.0; LANES];
    let (pressures, p) = pressure.as_chunks_mut::<LANES>();
    let (changes, m) = moved.as_chunks_mut::<LANES>();
    for (p, m) in pressures.iter_mut().zip(changes) {
        lower_lanes(p, m, excess, &mut sum);
    }
    lower_lanes(p, m, excess, &mut sum);
    total(sum)
}

#[inline(always)]
fn lower_lanes(pressure: &mut [f64], moved: &mut [f32], excess: f64, sum: &mut Lanes) {
    let count = pressure.len();
    let (mut kept, mut changes) = ([0.0; LANES], [0.0; LANES]);
    for lane in 0..count {
        let lowered = pressure[lane] - excess;
        kept[lane] = if lowered > 0.0 { lowered } else { 0.0 };
        changes[lane] = moved[lane] + (kept[lane] - pressure[lane]) as f32;
        sum[lane] += kept[lane];
    }
    pressure.copy_from_slice(&kept[..count]);
    moved.copy_from_slice(&changes[..count]);
}

/// What a step does to a gap. With u = scale (u + step K d) the gap u - h is, up to a constant,
/// g = scale (g - shift + step K d) + (scale - 1) h.
#[derive(Clone, Copy)]
pub(crate) struct Settling {
    pub(crate) shift: f64,
    pub(crate) step: f64,
    pub(crate) scale: f64,
}

#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(crate) fn settle(gap: &mut [f32], image: &[f32], height: &[f32], pressure: &[f64], change: Settling) -> Gap {
    let mut sums = GapSums::new();
    let (gaps, g) = gap.as_chunks_mut::<LANES>();
    let (images, i) = image.as_chunks::<LANES>();
    let (heights, h) = height.as_chunks::<LANES>();
    let (pressures, p) = pressure.as_chunks::<LANES>();
    for (((g, i), h), p) in gaps.iter_mut().zip(images).zip(heights).zip(pressures) {
        settle_lanes(g, i, h, p, change, &mut sums);
    }
    settle_lanes(g, i, h, p, change, &mut sums);
    sums.total(change.scale)
}

#[inline(always)]
fn settle_lanes(
    gap: &mut [f32],
    image: &[f32],
    height: &[f32],
    pressure: &[f64],
    change: Settling,
    sums: &mut GapSums,
) {
    let Settling { shift, step, scale } = change;
    let count = gap.len();
    let mut settled = [0.0; LANES];
    for lane in 0..count {
        let moved = f64::from(gap[lane]) - shift + step * f64::from(image[lane]);
        settled[lane] = scale * moved + (scale - 1.0) * f64::from(height[lane]);
    }
    sums.add(pressure, &settled[..count]);
    for lane in 0..count {
        gap[lane] = settled[lane] as f32;
    }
}
