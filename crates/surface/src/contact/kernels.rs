//! The solver's passes over the map, each fused so that memory is read once.
//!
//! Pressures are in double precision; gaps and search directions are in single precision. Sums run in double precision
//! over a fixed number of lanes, so that every run and every vector instruction set gives the same result.

use multiversion::multiversion;

use crate::contact::rough_contact::Heights;

/// Number of partial sums of each sum; fixed, so that every vector instruction set gives the same result.
const LANES: usize = 8;
type Lanes = [f64; LANES];

fn total(lanes: Lanes) -> f64 {
    let [a, b, c, d, e, f, g, h] = lanes;
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}

#[inline(always)]
fn indicator(condition: bool) -> f64 {
    if condition { 1.0 } else { 0.0 }
}

/// Scalar product a . b.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(crate) fn dot(a: &[f32], b: &[f32]) -> f64 {
    let mut sum = [0.0; LANES];
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    for (a, b) in a.iter().zip(b) {
        dot_lanes(a, b, &mut sum);
    }
    dot_lanes(a_rest, b_rest, &mut sum);
    total(sum)
}

#[inline(always)]
fn dot_lanes(a: &[f32], b: &[f32], sum: &mut Lanes) {
    for lane in 0..a.len() {
        sum[lane] += f64::from(a[lane]) * f64::from(b[lane]);
    }
}

/// Sums over the points with positive pressure, the pressure being a level plus a fluctuation f.
pub(crate) struct PositiveSums {
    pub(crate) sum: f64,
    /// Number of points with positive pressure.
    pub(crate) count: f64,
    /// Number of points inspected.
    pub(crate) points: f64,
}

/// Sums the pressures `level` + f where they are positive, with f in `fluctuation`, over every `every`-th group of
/// eight points.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(crate) fn sum_positive(fluctuation: &[f64], level: f64, every: usize) -> PositiveSums {
    let (mut sum, mut count, mut points) = ([0.0; LANES], [0.0; LANES], 0);
    for f in fluctuation.chunks(LANES).step_by(every) {
        for (lane, f) in f.iter().enumerate() {
            let pressure = level + f;
            sum[lane] += if pressure > 0.0 { pressure } else { 0.0 };
            count[lane] += indicator(pressure > 0.0);
        }
        points += f.len();
    }
    PositiveSums { sum: total(sum), count: total(count), points: points as f64 }
}

/// Statistics of a gap field.
pub(crate) struct GapStatistics {
    /// Mean gap over the points with pressure p > 0.
    pub(crate) shift: f64,
    pub(crate) lowest: f64,
    /// Scalar product of gap and pressure.
    pub(crate) work: f64,
}

/// Partial sums of [`GapStatistics`], one per lane.
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

    /// Adds up to [`LANES`] points. One loop per sum lets the compiler vectorize each loop.
    #[inline(always)]
    fn add(&mut self, pressure: &[f64], gap: &[f64]) {
        let Self { sum, count, work, lowest } = self;
        let points = gap.len();
        for lane in 0..points {
            sum[lane] += if pressure[lane] > 0.0 { gap[lane] } else { 0.0 };
        }
        for lane in 0..points {
            count[lane] += indicator(pressure[lane] > 0.0);
        }
        for lane in 0..points {
            work[lane] += gap[lane] * pressure[lane];
        }
        for lane in 0..points {
            lowest[lane] = if gap[lane] < lowest[lane] { gap[lane] } else { lowest[lane] };
        }
    }

    fn total(&self) -> GapStatistics {
        let lowest = self.lowest.into_iter().fold(f64::INFINITY, f64::min);
        GapStatistics { shift: total(self.sum) / total(self.count), lowest, work: total(self.work) }
    }
}

/// Computes the statistics of the gap u - h from the displacement u and the height h, in units of the rms height Sq.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(crate) fn measure_gap(pressure: &[f64], displacement: &[f64], heights: Heights<'_>) -> GapStatistics {
    let mut sums = GapSums::new();
    let (pressures, p) = pressure.as_chunks::<LANES>();
    let (displacements, u) = displacement.as_chunks::<LANES>();
    let (lanes_of_heights, h) = heights.in_metres().as_chunks::<LANES>();
    for ((p, u), h) in pressures.iter().zip(displacements).zip(lanes_of_heights) {
        measure_gap_lanes(p, u, h, heights, &mut sums);
    }
    measure_gap_lanes(p, u, h, heights, &mut sums);
    sums.total()
}

#[inline(always)]
fn measure_gap_lanes(
    pressure: &[f64],
    displacement: &[f64],
    height_m: &[f64],
    heights: Heights<'_>,
    sums: &mut GapSums,
) {
    let mut gap = [0.0; LANES];
    for ((g, u), &h) in gap.iter_mut().zip(displacement).zip(height_m) {
        *g = u - heights.normalized(h);
    }
    sums.add(pressure, &gap[..pressure.len()]);
}

/// Computes the gap g = u - h - `shift` from the displacement u and the height h, all in units of the rms height Sq.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(crate) fn compute_gap(gap: &mut [f32], displacement: &[f64], heights: Heights<'_>, shift: f64) {
    for ((g, &u), &h) in gap.iter_mut().zip(displacement).zip(heights.in_metres()) {
        *g = (u - heights.normalized(h) - shift) as f32;
    }
}

/// Computes the residual r = g - shift on free points (p > 0 or g < 0) and 0 elsewhere.
///
/// The residual of a free point is never exactly zero, so that r != 0 marks the free points.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(crate) fn masked_gap(residual: &mut [f32], pressure: &[f64], gap: &[f32], shift: f64) {
    for ((r, &p), &g) in residual.iter_mut().zip(pressure).zip(gap) {
        let gap = (f64::from(g) - shift) as f32;
        let kept = if gap == 0.0 { f32::MIN_POSITIVE } else { gap };
        *r = if (p > 0.0) | (gap < 0.0) { kept } else { 0.0 };
    }
}

/// Scalar products of the preconditioned residual z, restricted to free points and shifted to zero mean.
pub(crate) struct ResidualProducts {
    /// Mean of z over free points.
    pub(crate) mean: f64,
    /// z . r, with the residual r.
    pub(crate) z_r: f64,
    /// z . r_previous, with the residual of the previous iteration.
    pub(crate) z_r_previous: f64,
}

/// Partial sums of [`ResidualProducts`], one per lane.
#[derive(Default)]
pub(crate) struct ResidualSums {
    count: Lanes,
    z: Lanes,
    r: Lanes,
    z_r: Lanes,
    before: Lanes,
    z_before: Lanes,
}

impl ResidualSums {
    /// Adds points; `preconditioned` need not be masked.
    pub(crate) fn add(&mut self, preconditioned: &[f32], residual: &[f32], previous: &[f32]) {
        add_products(self, preconditioned, residual, previous);
    }

    pub(crate) fn products(self) -> ResidualProducts {
        let [count, z, r] = [self.count, self.z, self.r].map(total);
        let mean = z / count;
        ResidualProducts {
            mean,
            z_r: total(self.z_r) - mean * r,
            z_r_previous: total(self.z_before) - mean * total(self.before),
        }
    }

    /// Adds up to [`LANES`] points. One loop per sum lets the compiler vectorize each loop.
    #[inline(always)]
    fn add_lanes(&mut self, preconditioned: &[f32], residual: &[f32], previous: &[f32]) {
        let points = residual.len();
        let [mut z, mut r, mut before, mut free] = [[0.0; LANES]; 4];
        for lane in 0..points {
            r[lane] = f64::from(residual[lane]);
        }
        for lane in 0..points {
            free[lane] = indicator(r[lane] != 0.0);
        }
        for lane in 0..points {
            z[lane] = free[lane] * f64::from(preconditioned[lane]);
        }
        for lane in 0..points {
            before[lane] = free[lane] * f64::from(previous[lane]);
        }
        let sums = [&mut self.count, &mut self.z, &mut self.r, &mut self.before];
        for (sum, terms) in sums.into_iter().zip([free, z, r, before]) {
            for lane in 0..points {
                sum[lane] += terms[lane];
            }
        }
        for (sum, terms) in [&mut self.z_r, &mut self.z_before].into_iter().zip([r, before]) {
            for lane in 0..points {
                sum[lane] += z[lane] * terms[lane];
            }
        }
    }
}

#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
fn add_products(sums: &mut ResidualSums, preconditioned: &[f32], residual: &[f32], previous: &[f32]) {
    let (chunks, z) = preconditioned.as_chunks::<LANES>();
    let (residuals, r) = residual.as_chunks::<LANES>();
    let (befores, before) = previous.as_chunks::<LANES>();
    for ((z, r), before) in chunks.iter().zip(residuals).zip(befores) {
        sums.add_lanes(z, r, before);
    }
    sums.add_lanes(z, r, before);
}

/// Updates the direction, d = -(z - `mean`) + `beta` d on free points and 0 elsewhere; returns r . d, with the residual
/// r.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(crate) fn update_direction(
    direction: &mut [f32],
    preconditioned: &[f32],
    residual: &[f32],
    mean: f32,
    beta: f32,
) -> f64 {
    let mut slope = [0.0; LANES];
    let (directions, d) = direction.as_chunks_mut::<LANES>();
    let (chunks, z) = preconditioned.as_chunks::<LANES>();
    let (residuals, r) = residual.as_chunks::<LANES>();
    for ((d, z), r) in directions.iter_mut().zip(chunks).zip(residuals) {
        update_direction_lanes(d, z, r, mean, beta, &mut slope);
    }
    update_direction_lanes(d, z, r, mean, beta, &mut slope);
    total(slope)
}

#[inline(always)]
fn update_direction_lanes(direction: &mut [f32], z: &[f32], r: &[f32], mean: f32, beta: f32, slope: &mut Lanes) {
    let count = direction.len();
    let mut updated = [0.0; LANES];
    for lane in 0..count {
        let value = mean - z[lane] + beta * direction[lane];
        updated[lane] = if r[lane] != 0.0 { value } else { 0.0 };
    }
    for lane in 0..count {
        slope[lane] += f64::from(updated[lane]) * f64::from(r[lane]);
    }
    direction.copy_from_slice(&updated[..count]);
}

/// Statistics of the pressures after a step.
pub(crate) struct StepSums {
    pub(crate) sum: f64,
    /// Number of positive pressures.
    pub(crate) count: f64,
}

/// Updates the pressures, p = p + `step` d, minus `excess` on free points, and sets negative pressures to zero.
/// `change` receives the change of each pressure.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(crate) fn advance(pressure: &mut [f64], direction: &[f32], change: &mut [f32], step: f64, excess: f64) -> StepSums {
    let (mut sum, mut number) = ([0.0; LANES], [0.0; LANES]);
    let (pressures, p) = pressure.as_chunks_mut::<LANES>();
    let (directions, d) = direction.as_chunks::<LANES>();
    let (changes, m) = change.as_chunks_mut::<LANES>();
    for ((p, d), m) in pressures.iter_mut().zip(directions).zip(changes) {
        advance_lanes(p, d, m, (step, excess), (&mut sum, &mut number));
    }
    advance_lanes(p, d, m, (step, excess), (&mut sum, &mut number));
    StepSums { sum: total(sum), count: total(number) }
}

#[inline(always)]
fn advance_lanes(
    pressure: &mut [f64],
    direction: &[f32],
    change: &mut [f32],
    (step, excess): (f64, f64),
    (sum, number): (&mut Lanes, &mut Lanes),
) {
    let count = pressure.len();
    let (mut kept, mut changes) = ([0.0; LANES], [0.0; LANES]);
    for lane in 0..count {
        let direction = f64::from(direction[lane]);
        let free = pressure[lane] + step * direction - if direction != 0.0 { excess } else { 0.0 };
        kept[lane] = if free > 0.0 { free } else { 0.0 };
        changes[lane] = (kept[lane] - pressure[lane]) as f32;
        sum[lane] += kept[lane];
        number[lane] += indicator(free > 0.0);
    }
    pressure.copy_from_slice(&kept[..count]);
    change.copy_from_slice(&changes[..count]);
}

/// Subtracts `excess` from positive pressures and sets negative results to zero. Adds the change of each pressure to
/// `change`; returns the sum of the pressures.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(crate) fn lower(pressure: &mut [f64], change: &mut [f32], excess: f64) -> f64 {
    let mut sum = [0.0; LANES];
    let (pressures, p) = pressure.as_chunks_mut::<LANES>();
    let (changes, m) = change.as_chunks_mut::<LANES>();
    for (p, m) in pressures.iter_mut().zip(changes) {
        lower_lanes(p, m, excess, &mut sum);
    }
    lower_lanes(p, m, excess, &mut sum);
    total(sum)
}

#[inline(always)]
fn lower_lanes(pressure: &mut [f64], change: &mut [f32], excess: f64, sum: &mut Lanes) {
    let count = pressure.len();
    let (mut kept, mut changes) = ([0.0; LANES], [0.0; LANES]);
    for lane in 0..count {
        let lowered = pressure[lane] - excess;
        kept[lane] = if lowered > 0.0 { lowered } else { 0.0 };
        changes[lane] = change[lane] + (kept[lane] - pressure[lane]) as f32;
        sum[lane] += kept[lane];
    }
    pressure.copy_from_slice(&kept[..count]);
    change.copy_from_slice(&changes[..count]);
}

/// Multiplies the pressures by `share` and adds the change to `change`.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(crate) fn scale(pressure: &mut [f64], change: &mut [f32], share: f64) {
    for (p, change) in pressure.iter_mut().zip(change) {
        *change += ((share - 1.0) * *p) as f32;
        *p *= share;
    }
}

/// Undoes the fraction `share` of the last change c of the pressures p, given in `change`: p = max(p - share c, 0).
/// Returns the sum of the pressures.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(crate) fn step_back(pressure: &mut [f64], change: &[f32], share: f64) -> f64 {
    let mut sum = 0.0;
    for (p, &change) in pressure.iter_mut().zip(change) {
        *p = (*p - share * f64::from(change)).max(0.0);
        sum += *p;
    }
    sum
}

/// Updates the gap, g = g - `shift` + `share` K c, where `image` is K c; returns the statistics of the new gap.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(crate) fn update_gap(gap: &mut [f32], image: &[f32], pressure: &[f64], shift: f64, share: f64) -> GapStatistics {
    let mut sums = GapSums::new();
    let (gaps, g) = gap.as_chunks_mut::<LANES>();
    let (images, i) = image.as_chunks::<LANES>();
    let (pressures, p) = pressure.as_chunks::<LANES>();
    for ((g, i), p) in gaps.iter_mut().zip(images).zip(pressures) {
        update_gap_lanes(g, i, p, (shift, share), &mut sums);
    }
    update_gap_lanes(g, i, p, (shift, share), &mut sums);
    sums.total()
}

#[inline(always)]
fn update_gap_lanes(gap: &mut [f32], image: &[f32], pressure: &[f64], (shift, share): (f64, f64), sums: &mut GapSums) {
    let count = gap.len();
    let mut updated = [0.0; LANES];
    for lane in 0..count {
        updated[lane] = f64::from(gap[lane]) - shift + share * f64::from(image[lane]);
    }
    sums.add(pressure, &updated[..count]);
    for lane in 0..count {
        gap[lane] = updated[lane] as f32;
    }
}
