//! Heights of the rims along a section of the face, in lattice spacings.
//!
//! A column is raised by the mean of the rim's height over its land, in closed form, so that the relief is continuous
//! in every length. If heights vary from rim to rim, with the mean h and the standard deviation s, edge number k of n
//! has the height
//!
//! ```text
//! h_k = max(0, h + s z_k),     z_k: the n mid-quantiles of the normal distribution, scaled to unit variance
//! ```
//!
//! in the order of the fractional parts of multiples of the golden section, which separates similar values.

use slipgrid_base::statistics::normal_quantile;

use crate::pattern::{Pattern, Rim};

/// Ratio of the plane-strain modulus E / (1 - nu^2) at nu = 1/4, the value of cells in space, to E.
///
/// The plane lattice with modulus E is in plane stress at nu = 1/3, which is equivalent to plane strain at nu = 1/4 up
/// to this factor. The lattice therefore takes face heights multiplied by the factor, which gives the same pressures
/// and displacements larger by the factor.
pub const PLANE_STRAIN: f64 = 16.0 / 15.0;

/// Number of periods in a cell whose rims have different heights.
const SCATTERED_PERIODS: usize = 4;
/// The golden section, (sqrt(5) - 1) / 2.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Rims of a row of cavities in the two-dimensional model.
pub struct Rims {
    rim: Rim,
    block_m: f64,
    /// Heights of the rims in lattice spacings times [`PLANE_STRAIN`]: entry 2 n is before cavity n, entry 2 n + 1
    /// after it.
    heights: Vec<f64>,
}

impl Rims {
    /// Number of periods that a plane cell of `pattern` needs for its rims.
    pub fn periods(pattern: &Pattern) -> usize {
        if scatters(pattern) { SCATTERED_PERIODS } else { 1 }
    }

    /// Creates the rims of `cavities` cavities of `pattern` in blocks of `block_m`; `None` if there are no rims.
    pub fn new(pattern: &Pattern, block_m: f64, cavities: usize) -> Option<Self> {
        let rim = *pattern.texture().rim()?;
        let mut heights = heights(pattern, block_m, 2 * cavities)?;
        heights.iter_mut().for_each(|height| *height *= PLANE_STRAIN);
        Some(Self { rim, block_m, heights })
    }

    /// Height of the rim before cavity number `cavity`, in lattice spacings times [`PLANE_STRAIN`], as in
    /// [`crate::springblock::columns::Column::relief`].
    pub fn before(&self, cavity: usize) -> f64 {
        self.heights[2 * cavity % self.heights.len()]
    }

    /// Height of the rim after cavity number `cavity`, in the unit of [`Self::before`].
    pub fn after(&self, cavity: usize) -> f64 {
        self.heights[(2 * cavity + 1) % self.heights.len()]
    }

    /// Integral of the relief over the intersection of `column` with the land `land`, each given by its two sides, in
    /// lattice spacings. `heights` are the heights of the rims at the left and right edge of the land, in the unit of
    /// [`Self::before`], `None` at an edge without a rim.
    pub fn integral(&self, column: [f64; 2], land: [f64; 2], heights: [Option<f64>; 2]) -> f64 {
        // Rims of opposite edges end half-way between them.
        let middle = match heights {
            [Some(_), Some(_)] => f64::midpoint(land[0], land[1]),
            [Some(_), None] => land[1],
            [None, _] => land[0],
        };
        let part = |low: f64, high: f64| {
            let (low, high) = (column[0].max(low), column[1].min(high));
            (high > low).then_some([low, high])
        };
        let of = |from: f64, to: f64| self.rim.integral_m(from * self.block_m, to * self.block_m) / self.block_m;
        let [after, before] = heights;
        let left =
            after.zip(part(land[0], middle)).map_or(0.0, |(h, [low, high])| h * of(low - land[0], high - land[0]));
        let right =
            before.zip(part(middle, land[1])).map_or(0.0, |(h, [low, high])| h * of(land[1] - high, land[1] - low));
        left + right
    }

    /// Mean relief, in the unit of [`Self::before`], of the land in `column`, given by its two sides, with cavities
    /// from m `pitch` to m `pitch` + `width` for all integers m. These lengths are in lattice spacings.
    pub fn mean(&self, column: [f64; 2], [width, pitch]: [f64; 2]) -> f64 {
        let (mut integral, mut land) = (0.0, 0.0);
        // Lands that overlap the column follow cavity number `first` and later ones.
        let first = ((column[0] - pitch) / pitch).floor();
        let mut m = first;
        while m * pitch + width < column[1] {
            let ends = [m * pitch + width, (m + 1.0) * pitch];
            // Cavities of the cell are numbered from the one at 0 and repeat; the cast is exact.
            let count = self.heights.len() as i64 / 2;
            let number = |m: f64| (m as i64).rem_euclid(count) as usize;
            let heights = [Some(self.after(number(m))), Some(self.before(number(m + 1.0)))];
            integral += self.integral(column, ends, heights);
            land += (column[1].min(ends[1]) - column[0].max(ends[0])).max(0.0);
            m += 1.0;
        }
        if land > 0.0 { integral / land } else { 0.0 }
    }
}

/// Whether the rims of `pattern` differ in height.
fn scatters(pattern: &Pattern) -> bool {
    pattern.texture().rim().is_some_and(|rim| rim.height_std_m() > 0.0)
}

/// Number of rectangular cells of `pattern` along x and y that a cell in space needs for its rims.
pub fn cells(pattern: &Pattern) -> [usize; 2] {
    match (scatters(pattern), pattern.is_uniform_along_y()) {
        (false, _) => [1, 1],
        (true, true) => [SCATTERED_PERIODS, 1],
        (true, false) => [2, 2],
    }
}

/// Heights of `count` rims of `pattern`, in lattice spacings of `block_m` metres; `None` if there are no rims.
pub fn heights(pattern: &Pattern, block_m: f64, count: usize) -> Option<Vec<f64>> {
    let rim = pattern.texture().rim().filter(|_| count > 0)?;
    let (height_m, std_m) = (rim.height_m(pattern.depth_m()), rim.height_std_m());
    if std_m > 0.0 {
        return Some(scattered(count).map(|z| (height_m + std_m * z).max(0.0) / block_m).collect());
    }
    (height_m > 0.0).then(|| vec![height_m / block_m; count])
}

/// Mid-quantiles of the normal distribution for `count` values, scaled to mean 0 and variance 1, in an order that
/// separates similar values.
fn scattered(count: usize) -> impl Iterator<Item = f64> {
    let fraction = |number: usize| (GOLDEN * number as f64).fract();
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|a, b| fraction(*a).total_cmp(&fraction(*b)));
    let mut values = vec![0.0; count];
    for (rank, place) in order.into_iter().enumerate() {
        values[place] = normal_quantile((rank as f64 + 0.5) / count as f64);
    }
    let scale = (values.iter().map(|z| z * z).sum::<f64>() / count as f64).sqrt();
    values.into_iter().map(move |z| z / scale)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pattern::{Planform, RimProfile, Texture};
    use crate::springblock::columns::{cell, sample, with_relief};

    fn pattern(width_um: f64, spacing_um: f64, rim_um: f64, std_um: f64) -> Pattern {
        let rim = Rim::new(0.5e-6, rim_um * 1e-6, RimProfile::Ramp).unwrap().with_height_std_m(std_um * 1e-6).unwrap();
        let texture = Texture::new(Planform::Groove).with_rim(rim);
        Pattern::new(texture, width_um * 1e-6, spacing_um * 1e-6, 2e-5).unwrap()
    }

    #[test]
    fn columns_hold_the_area_of_the_rims_at_any_width() {
        for (width, spacing, rim) in [(130.0, 370.0, 10.0), (133.3, 61.7, 17.0), (100.0, 20.0, 30.0), (17.0, 18.0, 3.0)]
        {
            let pattern = pattern(width, spacing, rim, 0.0);
            let columns = cell(&pattern, 10e-6);
            let area: f64 = columns.iter().map(|c| c.relief / PLANE_STRAIN * c.width * (1.0 - c.coverage)).sum();
            let length: f64 = columns.iter().map(|c| c.width).sum();
            // The area of a ramp is h (d - d^2 / 2 w) up to the end d, in blocks of 10 um.
            let end = rim.min(spacing / 2.0);
            let expected = 2.0 * 0.05 * (end - 0.5 * end * end / rim) / 10.0 * length * 10.0 / (width + spacing);
            assert!((area / expected - 1.0).abs() < 1e-9, "{width} {spacing} {rim}: {area} {expected}");
            // The mean over columns equals the rim share computed by the pattern.
            for (i, column) in columns.iter().enumerate().filter(|(_, c)| c.is_land() && c.coverage == 0.0) {
                let from_m = columns[..i].iter().map(|c| c.width).sum::<f64>() * 10e-6;
                let first_m = columns.iter().take_while(|c| c.is_land()).map(|c| c.width).sum::<f64>() * 10e-6;
                let x_m = from_m - first_m - pattern.width_m() / 2.0;
                if columns[0].width == 1.0 {
                    let share = pattern.rim_share(x_m, x_m + 10e-6, 0.0, 1e-6);
                    assert!((column.relief / PLANE_STRAIN - 0.05 * share).abs() < 1e-9, "{i}");
                }
            }
        }
    }

    #[test]
    fn the_rims_of_a_free_face_are_those_of_its_cavities_alone() {
        let pattern = pattern(130.0, 370.0, 10.0, 0.0);
        let columns = sample(&pattern, 10e-6, 996);
        assert_eq!(columns, with_relief(columns.clone(), &pattern, 10e-6, None));
        let raised: Vec<usize> = (0..996).filter(|&i| columns[i].relief > 0.0).collect();
        let expected: Vec<usize> = (0..20).flat_map(|m| [17 + 50 * m, 31 + 50 * m]).filter(|i| *i < 996).collect();
        assert_eq!(raised, expected);
        assert!(raised.iter().all(|&i| (columns[i].relief / PLANE_STRAIN - 0.025).abs() < 1e-12));
    }

    #[test]
    fn scattered_heights_have_their_mean_and_their_scatter() {
        for count in [2, 8, 40] {
            let z: Vec<f64> = scattered(count).collect();
            let (sum, square) = z.iter().fold((0.0, 0.0), |(s, q), z| (s + z, q + z * z));
            assert!(sum.abs() < 1e-9 && (square / count as f64 - 1.0).abs() < 1e-12, "{count}");
        }
        let columns = cell(&pattern(130.0, 370.0, 10.0, 0.1), 10e-6);
        assert_eq!(columns.len(), 200);
        let mut heights: Vec<f64> = columns.iter().map(|c| c.relief).filter(|r| *r > 0.0).collect();
        heights.sort_by(f64::total_cmp);
        assert_eq!(heights.len(), 8);
        assert!(heights.windows(2).all(|pair| pair[1] > pair[0]));
        let mean = heights.iter().sum::<f64>() / 8.0 / PLANE_STRAIN;
        assert!((mean - 0.025).abs() < 1e-12, "{mean}");
    }
}
