//! The solver's passes over the map, each fused so that memory is read once. Pressures are in double precision, gaps and
//! what makes up a direction in single. Sums run in double precision and fixed lanes: the same result on every run and
//! whatever vector instructions the machine has.

use multiversion::multiversion;

/// Sums that run side by side.
const LANES: usize = 8;
type Lanes = [f64; LANES];

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

    fn total(&self) -> Gap {
        let lowest = self.lowest.into_iter().fold(f64::INFINITY, f64::min);
        Gap { shift: total(self.sum) / total(self.count), lowest, work: total(self.work) }
    }
}

/// The gap u - h.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(crate) fn measure(pressure: &[f64], displacement: &[f64], height: &[f64]) -> Gap {
    let mut sums = GapSums::new();
    let (pressures, p) = pressure.as_chunks::<LANES>();
    let (displacements, u) = displacement.as_chunks::<LANES>();
    let (heights, h) = height.as_chunks::<LANES>();
    for ((p, u), h) in pressures.iter().zip(displacements).zip(heights) {
        measure_lanes(p, u, h, &mut sums);
    }
    measure_lanes(p, u, h, &mut sums);
    sums.total()
}

#[inline(always)]
fn measure_lanes(pressure: &[f64], displacement: &[f64], height: &[f64], sums: &mut GapSums) {
    let mut gap = [0.0; LANES];
    for ((g, u), h) in gap.iter_mut().zip(displacement).zip(height) {
        *g = u - h;
    }
    sums.add(pressure, &gap[..pressure.len()]);
}

/// g = u - h - shift
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(crate) fn gap(gap: &mut [f32], displacement: &[f64], height: &[f64], shift: f64) {
    for ((g, &u), &h) in gap.iter_mut().zip(displacement).zip(height) {
        *g = (u - h - shift) as f32;
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

/// The sums of a [`Fit`], side by side.
#[derive(Default)]
pub(crate) struct FitSums {
    count: Lanes,
    z: Lanes,
    r: Lanes,
    z_r: Lanes,
    before: Lanes,
    z_before: Lanes,
}

impl FitSums {
    /// Takes points in, of whose values `preconditioned` is not masked.
    pub(crate) fn add(&mut self, preconditioned: &[f32], residual: &[f32], previous: &[f32]) {
        add_fit(self, preconditioned, residual, previous);
    }

    pub(crate) fn fit(self) -> Fit {
        let [count, z, r] = [self.count, self.z, self.r].map(total);
        let mean = z / count;
        Fit { mean, now: total(self.z_r) - mean * r, before: total(self.z_before) - mean * total(self.before) }
    }

    /// Up to [`LANES`] points, one sum after the other so that each becomes one vector's.
    #[inline(always)]
    fn add_lanes(&mut self, preconditioned: &[f32], residual: &[f32], previous: &[f32]) {
        let points = residual.len();
        let [mut z, mut r, mut before, mut free] = [[0.0; LANES]; 4];
        for lane in 0..points {
            r[lane] = f64::from(residual[lane]);
        }
        for lane in 0..points {
            free[lane] = when(r[lane] != 0.0);
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
fn add_fit(sums: &mut FitSums, preconditioned: &[f32], residual: &[f32], previous: &[f32]) {
    let (chunks, z) = preconditioned.as_chunks::<LANES>();
    let (residuals, r) = residual.as_chunks::<LANES>();
    let (befores, before) = previous.as_chunks::<LANES>();
    for ((z, r), before) in chunks.iter().zip(residuals).zip(befores) {
        sums.add_lanes(z, r, before);
    }
    sums.add_lanes(z, r, before);
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
}

/// p = p + step d, less `excess` on free points, negative pressures to zero; `moved` becomes what each pressure changed by.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(crate) fn advance(pressure: &mut [f64], direction: &[f32], moved: &mut [f32], step: f64, excess: f64) -> Moved {
    let (mut sum, mut number) = ([0.0; LANES], [0.0; LANES]);
    let (pressures, p) = pressure.as_chunks_mut::<LANES>();
    let (directions, d) = direction.as_chunks::<LANES>();
    let (changes, m) = moved.as_chunks_mut::<LANES>();
    for ((p, d), m) in pressures.iter_mut().zip(directions).zip(changes) {
        advance_lanes(p, d, m, (step, excess), (&mut sum, &mut number));
    }
    advance_lanes(p, d, m, (step, excess), (&mut sum, &mut number));
    Moved { sum: total(sum), count: total(number) }
}

#[inline(always)]
fn advance_lanes(
    pressure: &mut [f64],
    direction: &[f32],
    moved: &mut [f32],
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

/// p = `share` p, `moved` follows.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(crate) fn scale(pressure: &mut [f64], moved: &mut [f32], share: f64) {
    for (p, moved) in pressure.iter_mut().zip(moved) {
        *moved += ((share - 1.0) * *p) as f32;
        *p *= share;
    }
}

/// p = p - `share` c without negative pressures, c what they changed by; returns their sum.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(crate) fn step_back(pressure: &mut [f64], moved: &[f32], share: f64) -> f64 {
    let mut sum = 0.0;
    for (p, &moved) in pressure.iter_mut().zip(moved) {
        *p = (*p - share * f64::from(moved)).max(0.0);
        sum += *p;
    }
    sum
}

/// g = g - shift + `share` K c
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(crate) fn settle(gap: &mut [f32], image: &[f32], pressure: &[f64], shift: f64, share: f64) -> Gap {
    let mut sums = GapSums::new();
    let (gaps, g) = gap.as_chunks_mut::<LANES>();
    let (images, i) = image.as_chunks::<LANES>();
    let (pressures, p) = pressure.as_chunks::<LANES>();
    for ((g, i), p) in gaps.iter_mut().zip(images).zip(pressures) {
        settle_lanes(g, i, p, (shift, share), &mut sums);
    }
    settle_lanes(g, i, p, (shift, share), &mut sums);
    sums.total()
}

#[inline(always)]
fn settle_lanes(gap: &mut [f32], image: &[f32], pressure: &[f64], (shift, share): (f64, f64), sums: &mut GapSums) {
    let count = gap.len();
    let mut settled = [0.0; LANES];
    for lane in 0..count {
        settled[lane] = f64::from(gap[lane]) - shift + share * f64::from(image[lane]);
    }
    sums.add(pressure, &settled[..count]);
    for lane in 0..count {
        gap[lane] = settled[lane] as f32;
    }
}
