//! The solver's passes over the map, each fused so that memory is read once. Sums run in fixed lanes:
//! the same result on every run, and room for vector instructions.

/// Sums that run side by side.
const LANES: usize = 4;
type Lanes = [f64; LANES];

/// Sums of `body` over the points, `body` taking one value of each input.
#[inline(always)]
fn sums<const I: usize, const S: usize>(inputs: [&[f64]; I], body: impl Fn([f64; I]) -> [f64; S]) -> [f64; S] {
    let chunked = inputs.map(|input| input.as_chunks::<LANES>());
    let mut sums = [[0.0; LANES]; S];
    for n in 0..chunked[0].0.len() {
        let lanes: [&Lanes; I] = std::array::from_fn(|i| &chunked[i].0[n]);
        for lane in 0..LANES {
            let terms = body(std::array::from_fn(|i| lanes[i][lane]));
            for s in 0..S {
                sums[s][lane] += terms[s];
            }
        }
    }
    for n in 0..chunked[0].1.len() {
        let terms = body(std::array::from_fn(|i| chunked[i].1[n]));
        for s in 0..S {
            sums[s][0] += terms[s];
        }
    }
    sums.map(total)
}

fn total(lanes: Lanes) -> f64 {
    (lanes[0] + lanes[2]) + (lanes[1] + lanes[3])
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
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    sums([a, b], |[a, b]| [a * b])[0]
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

pub(crate) fn measure(pressure: &[f64], displacement: &[f64], height: &[f64]) -> Gap {
    let [sum, count, work] = sums([pressure, displacement, height], |[p, u, h]| {
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
pub(crate) fn masked_gap(residual: &mut [f64], pressure: &[f64], displacement: &[f64], height: &[f64], shift: f64) {
    for (((r, &p), &u), &h) in residual.iter_mut().zip(pressure).zip(displacement).zip(height) {
        let gap = u - h - shift;
        *r = if free(p, gap) { gap } else { 0.0 };
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

pub(crate) fn fit(preconditioned: &[f64], residual: &[f64], previous: &[f64], pressure: &[f64]) -> Fit {
    let [count, z, r, zr, before, z_before] =
        sums([preconditioned, residual, previous, pressure], |[z, r, before, p]| {
            let mask = free(p, r);
            let (z, before) = (if mask { z } else { 0.0 }, if mask { before } else { 0.0 });
            [when(mask), z, r, z * r, before, z * before]
        });
    let mean = z / count;
    Fit { mean, now: zr - mean * r, before: z_before - mean * before }
}

/// d = -(z - mean) + beta d on free points, zero elsewhere; returns r . d.
pub(crate) fn turn(
    direction: &mut [f64],
    preconditioned: &[f64],
    residual: &[f64],
    pressure: &[f64],
    mean: f64,
    beta: f64,
) -> f64 {
    for (((d, &z), &r), &p) in direction.iter_mut().zip(preconditioned).zip(residual).zip(pressure) {
        let turned = mean - z + beta * *d;
        *d = if free(p, r) { turned } else { 0.0 };
    }
    dot(direction, residual)
}

/// What a step did to the pressures.
pub(crate) struct Moved {
    /// Their sum.
    pub(crate) sum: f64,
    /// Some were negative and set to zero.
    pub(crate) clipped: bool,
}

/// p += step d, negative pressures to zero; u += step Kd, which is K p where nothing was set to zero.
pub(crate) fn advance(
    pressure: &mut [f64],
    displacement: &mut [f64],
    direction: &[f64],
    image: &[f64],
    step: f64,
) -> Moved {
    let mut lowest = [0.0; LANES];
    let (chunks, rest) = pressure.as_chunks_mut::<LANES>();
    let (directions, direction_rest) = direction.as_chunks::<LANES>();
    let mut sum = [0.0; LANES];
    let mut one = |p: &mut f64, d: f64, lane: usize| {
        let moved = *p + step * d;
        lowest[lane] = if moved < lowest[lane] { moved } else { lowest[lane] };
        *p = if moved > 0.0 { moved } else { 0.0 };
        sum[lane] += *p;
    };
    for (p, d) in chunks.iter_mut().zip(directions) {
        for lane in 0..LANES {
            one(&mut p[lane], d[lane], lane);
        }
    }
    for (p, &d) in rest.iter_mut().zip(direction_rest) {
        one(p, d, 0);
    }
    let clipped = lowest.iter().any(|&low| low < 0.0);
    if !clipped {
        for (u, &image) in displacement.iter_mut().zip(image) {
            *u += step * image;
        }
    }
    Moved { sum: total(sum), clipped }
}

pub(crate) fn scale(values: &mut [f64], factor: f64) {
    values.iter_mut().for_each(|value| *value *= factor);
}
