//! The solver's passes over the map, each fused so that memory is read once. Pressure, displacement and height are
//! in double precision, what makes up a direction in single. Sums run in double precision and fixed lanes: the same
//! result on every run and whatever vector instructions the machine has.

use multiversion::multiversion;

/// Sums that run side by side.
const LANES: usize = 8;
type Lanes = [f64; LANES];

/// Sums of `body` over the points, `body` taking one value of each input.
#[inline(always)]
fn sums<const D: usize, const I: usize, const S: usize>(
    doubles: [&[f64]; D],
    singles: [&[f32]; I],
    body: impl Fn([f64; D], [f64; I]) -> [f64; S],
) -> [f64; S] {
    let doubles = doubles.map(|input| input.as_chunks::<LANES>());
    let singles = singles.map(|input| input.as_chunks::<LANES>());
    let chunks = doubles.first().map_or_else(|| singles[0].0.len(), |input| input.0.len());
    let mut sums = [[0.0; LANES]; S];
    for n in 0..chunks {
        let double: [&Lanes; D] = std::array::from_fn(|i| &doubles[i].0[n]);
        let single: [&[f32; LANES]; I] = std::array::from_fn(|i| &singles[i].0[n]);
        for lane in 0..LANES {
            let terms =
                body(std::array::from_fn(|i| double[i][lane]), std::array::from_fn(|i| f64::from(single[i][lane])));
            for s in 0..S {
                sums[s][lane] += terms[s];
            }
        }
    }
    let rest = doubles.first().map_or_else(|| singles[0].1.len(), |input| input.1.len());
    for n in 0..rest {
        let terms = body(std::array::from_fn(|i| doubles[i].1[n]), std::array::from_fn(|i| f64::from(singles[i].1[n])));
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

/// Whether a point may change its pressure, r its gap where it may: p > 0 or g < 0.
#[inline(always)]
fn free(pressure: f64, residual: f64) -> bool {
    (pressure > 0.0) | (residual < 0.0)
}

/// a . b
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(crate) fn dot(a: &[f32], b: &[f32]) -> f64 {
    sums([], [a, b], |[], [a, b]| [a * b])[0]
}

/// The unshifted gap u - h.
pub(crate) struct Gap {
    /// Its mean over p > 0.
    pub(crate) shift: f64,
    /// Its lowest value.
    pub(crate) lowest: f64,
    /// Its product with the pressure.
    pub(crate) work: f64,
}

#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(crate) fn measure(pressure: &[f64], displacement: &[f64], height: &[f64]) -> Gap {
    let [sum, count, work] = sums([pressure, displacement, height], [], |[p, u, h], []| {
        let gap = u - h;
        [if p > 0.0 { gap } else { 0.0 }, when(p > 0.0), gap * p]
    });
    let mut lanes = [f64::INFINITY; LANES];
    let ((u, u_rest), (h, h_rest)) = (displacement.as_chunks::<LANES>(), height.as_chunks::<LANES>());
    for (u, h) in u.iter().zip(h) {
        for lane in 0..LANES {
            let gap = u[lane] - h[lane];
            lanes[lane] = if gap < lanes[lane] { gap } else { lanes[lane] };
        }
    }
    let rest = u_rest.iter().zip(h_rest).map(|(u, h)| u - h);
    let lowest = rest.chain(lanes).fold(f64::INFINITY, f64::min);
    Gap { shift: sum / count, lowest, work }
}

/// r = g = u - h - shift on free points, zero elsewhere.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(crate) fn masked_gap(residual: &mut [f32], pressure: &[f64], displacement: &[f64], height: &[f64], shift: f64) {
    for (((r, &p), &u), &h) in residual.iter_mut().zip(pressure).zip(displacement).zip(height) {
        let gap = u - h - shift;
        *r = if free(p, gap) { gap as f32 } else { 0.0 };
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
pub(crate) fn fit(preconditioned: &[f32], residual: &[f32], previous: &[f32], pressure: &[f64]) -> Fit {
    let [count, z, r, zr, before, z_before] =
        sums([pressure], [preconditioned, residual, previous], |[p], [z, r, before]| {
            let mask = free(p, r);
            let (z, before) = (if mask { z } else { 0.0 }, if mask { before } else { 0.0 });
            [when(mask), z, r, z * r, before, z * before]
        });
    let mean = z / count;
    Fit { mean, now: zr - mean * r, before: z_before - mean * before }
}

/// d = -(z - mean) + beta d on free points, zero elsewhere.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(crate) fn turn(
    direction: &mut [f32],
    preconditioned: &[f32],
    residual: &[f32],
    pressure: &[f64],
    mean: f32,
    beta: f32,
) {
    for (((d, &z), &r), &p) in direction.iter_mut().zip(preconditioned).zip(residual).zip(pressure) {
        let turned = mean - z + beta * *d;
        *d = if free(p, f64::from(r)) { turned } else { 0.0 };
    }
}

/// What a step did to the pressures.
pub(crate) struct Moved {
    /// Their sum.
    pub(crate) sum: f64,
    /// Some were negative and set to zero.
    pub(crate) clipped: bool,
}

/// p += step d, negative pressures to zero; `moved` becomes what each pressure changed by.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(crate) fn advance(pressure: &mut [f64], direction: &[f32], moved: &mut [f32], step: f64) -> Moved {
    let (mut lowest, mut sum) = ([0.0; LANES], [0.0; LANES]);
    let mut one = |p: &mut f64, d: f32, m: &mut f32, lane: usize| {
        let free = *p + step * f64::from(d);
        lowest[lane] = if free < lowest[lane] { free } else { lowest[lane] };
        let kept = if free > 0.0 { free } else { 0.0 };
        *m = (kept - *p) as f32;
        *p = kept;
        sum[lane] += kept;
    };
    let (chunks, rest) = pressure.as_chunks_mut::<LANES>();
    let (directions, direction_rest) = direction.as_chunks::<LANES>();
    let (changes, changes_rest) = moved.as_chunks_mut::<LANES>();
    for ((p, d), m) in chunks.iter_mut().zip(directions).zip(changes) {
        for lane in 0..LANES {
            one(&mut p[lane], d[lane], &mut m[lane], lane);
        }
    }
    for ((p, &d), m) in rest.iter_mut().zip(direction_rest).zip(changes_rest) {
        one(p, d, m, 0);
    }
    Moved { sum: total(sum), clipped: lowest.iter().any(|&low| low < 0.0) }
}

/// p = scale p, u = scale (u + step image).
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(crate) fn settle(pressure: &mut [f64], displacement: &mut [f64], image: &[f32], step: f64, scale: f64) {
    for ((p, u), &image) in pressure.iter_mut().zip(displacement).zip(image) {
        *p *= scale;
        *u = scale * (*u + step * f64::from(image));
    }
}
