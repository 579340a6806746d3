//! Measured relief of a face: heights over one period of its pattern.

use crate::pattern::error::{length, um};
use crate::pattern::{Pattern, PatternError};

/// Depth, as a fraction of the cavity's depth, beyond which a point of the map belongs to a wall of the cavity. Such
/// points carry no load and are excluded from means. Points next to a wall, where instruments and averaging blend
/// heights, are raised to at least the mean height of the land around them.
const WALL_DEPTH: f64 = 0.1;
/// Maximum relative deviation of the sides of a map from those of the pattern's cell.
const MAX_MISFIT: f64 = 0.02;
/// Minimum fraction of the map's cavity that lies in the pattern's cavity, and vice versa.
const MIN_OVERLAP: f64 = 0.5;

/// Mismatch between the cavities of map and pattern, as a fraction of the map's area, above which a pattern with width
/// and spacing exchanged is tried.
const EXCHANGED_MISFIT: f64 = 0.1;

/// Overlap of the cavities of a map and of a pattern, as fractions of the map's area.
#[derive(Clone, Copy, Debug)]
struct Overlap {
    /// Fraction that is cavity in the map.
    map: f64,
    /// Fraction that is cavity in the pattern.
    pattern: f64,
    /// Fraction that is cavity in both.
    both: f64,
}

impl Overlap {
    /// Whether the cavity of the map and the cavity of the pattern each cover at least half of the other.
    fn is_one_cavity(self) -> bool {
        self.both >= MIN_OVERLAP * self.map && self.both >= MIN_OVERLAP * self.pattern
    }

    /// Fraction that is cavity in the map or in the pattern, but not in both.
    fn misfit(self) -> f64 {
        self.map + self.pattern - 2.0 * self.both
    }
}

/// Heights of a textured face over one period, with the centre of a cavity at the centre of the map. Heights inside
/// cavities are included, but excluded from the relief of lands.
#[derive(Clone, Debug, PartialEq)]
pub struct ReliefMap {
    sides_m: [f64; 2],
    pixels: [usize; 2],
    heights_m: Vec<f64>,
}

impl ReliefMap {
    /// Creates a map of heights over a period of `sides_m` along x and y, in metres and positive towards the
    /// counterface. With nx by ny `pixels`, the height of pixel i along x and j along y is `heights_m[j nx + i]`.
    ///
    /// # Errors
    /// [`PatternError::Refused`] for invalid sides, or unless there is a finite height for every pixel.
    pub fn new(sides_m: [f64; 2], pixels: [usize; 2], heights_m: Vec<f64>) -> Result<Self, PatternError> {
        for side_m in sides_m {
            length("side of the relief", side_m)?;
        }
        let finite = heights_m.iter().filter(|height| height.is_finite()).count();
        let expected = pixels[0].saturating_mul(pixels[1]);
        if expected == 0 || heights_m.len() != expected || finite != expected {
            let heights = format!("{finite} finite heights of a relief of {expected} pixels");
            return Err(PatternError::Refused(format!("{heights}: expected one for each")));
        }
        Ok(Self { sides_m, pixels, heights_m })
    }

    /// Sides of the mapped period along x and y, in metres.
    pub const fn sides_m(&self) -> [f64; 2] {
        self.sides_m
    }

    /// Transposes the map: x and y are exchanged.
    pub fn turned(&self) -> Self {
        let ([nx, ny], [x_m, y_m]) = (self.pixels, self.sides_m);
        let heights_m = (0..nx * ny).map(|n| self.heights_m[n / ny + n % ny * nx]).collect();
        Self { sides_m: [y_m, x_m], pixels: [ny, nx], heights_m }
    }

    /// Aligns the map with `pattern`: a map of grooves is transposed if its grooves run along x.
    ///
    /// # Errors
    /// [`PatternError::Refused`] if the map has a cavity that is not where the pattern has one, or that matches the
    /// pattern with width and spacing exchanged. A map without cavities, for example of rims only, is accepted.
    pub fn along(self, pattern: &Pattern) -> Result<Self, PatternError> {
        if pattern.is_uniform_along_y() {
            let own = if self.variation(1) > self.variation(0) { self.turned() } else { self };
            return if own.is_accepted(pattern)? { Ok(own) } else { Err(elsewhere("")) };
        }
        if self.is_accepted(pattern)? {
            return Ok(self);
        }
        let turned = ", as this map would have it if it were turned by a right angle";
        Err(elsewhere(if self.turned().has_cavity_of(pattern) { turned } else { "" }))
    }

    /// Whether the map has no cavity, or a cavity that matches that of `pattern`; an error if it matches the pattern
    /// with width and spacing exchanged.
    fn is_accepted(&self, pattern: &Pattern) -> Result<bool, PatternError> {
        let Some(own) = self.overlap(pattern) else { return Ok(true) };
        let [width_m, spacing_m] = [pattern.width_m(), pattern.spacing_m()];
        if own.misfit() > EXCHANGED_MISFIT
            && let Ok(exchanged) = Pattern::new(*pattern.texture(), spacing_m, width_m, pattern.depth_m())
            && let Some(other) = self.overlap(&exchanged)
            && other.is_one_cavity()
            && other.misfit() < 0.5 * own.misfit()
        {
            return Err(PatternError::Refused(format!(
                "the cavity of the relief is not {} um wide beside gaps of {} um, but rather the other way round: expected the width of a cavity \
                 as width and the gap between two as spacing; they seem to be exchanged",
                um(width_m),
                um(spacing_m)
            )));
        }
        Ok(own.is_one_cavity())
    }

    /// Variance, in square metres, of the mean heights of the lines of pixels across `axis` (0 for x, 1 for y).
    fn variation(&self, axis: usize) -> f64 {
        let [nx, ny] = self.pixels;
        let count = self.pixels[axis];
        let mut means = vec![0.0; count];
        for (n, height_m) in self.heights_m.iter().enumerate() {
            means[if axis == 0 { n % nx } else { n / nx }] += height_m * count as f64 / (nx * ny) as f64;
        }
        let mean = means.iter().sum::<f64>() / count as f64;
        means.iter().map(|own| (own - mean).powi(2)).sum::<f64>() / count as f64
    }

    /// Whether the map has no cavity, or a cavity that matches that of `pattern`.
    fn has_cavity_of(&self, pattern: &Pattern) -> bool {
        self.overlap(pattern).is_none_or(Overlap::is_one_cavity)
    }

    /// Overlap of the cavities of the map and of `pattern`; `None` if the map has no cavity.
    fn overlap(&self, pattern: &Pattern) -> Option<Overlap> {
        let lowest_m = self.heights_m.iter().copied().fold(f64::INFINITY, f64::min);
        if lowest_m > -WALL_DEPTH * pattern.depth_m() {
            return None;
        }
        let nx = self.pixels[0];
        let mut cell_m = pattern.cell_m();
        if pattern.is_uniform_along_y() {
            cell_m[1] = self.sides_m[1];
        }
        let edge = |axis: usize, at: usize| (at as f64 / self.pixels[axis] as f64 - 0.5) * cell_m[axis];
        let mut sums = Overlap { map: 0.0, pattern: 0.0, both: 0.0 };
        let share = 1.0 / self.heights_m.len() as f64;
        for (n, height_m) in self.heights_m.iter().enumerate() {
            let (i, j) = (n % nx, n / nx);
            let covered = pattern.coverage(edge(0, i), edge(0, i + 1), edge(1, j), edge(1, j + 1));
            let taken = if *height_m < 0.5 * lowest_m { 1.0 } else { 0.0 };
            sums.map += share * taken;
            sums.pattern += share * covered;
            sums.both += share * taken * covered;
        }
        Some(sums)
    }

    /// Computes the relief of the lands between the cavities of `pattern`; the map is stretched to the pattern's cell.
    ///
    /// # Errors
    /// [`PatternError::Refused`] if the sides of map and cell differ by more than 2 %. Sides along y are not compared
    /// for grooves, which are uniform along y.
    pub fn lands(&self, pattern: &Pattern) -> Result<LandRelief, PatternError> {
        let mut cell_m = pattern.cell_m();
        if pattern.is_uniform_along_y() {
            cell_m[1] = self.sides_m[1];
        }
        if (0..2).any(|axis| (self.sides_m[axis] / cell_m[axis] - 1.0).abs() > MAX_MISFIT) {
            let ([x_um, y_um], [cell_x_um, cell_y_um]) = (self.sides_m.map(um), cell_m.map(um));
            return Err(PatternError::Refused(format!(
                "a relief of {x_um} x {y_um} um for cells of {cell_x_um} x {cell_y_um} um: expected one period of the pattern, its sides within 2 %"
            )));
        }
        let [nx, ny] = self.pixels;
        let pixel_m = [cell_m[0] / nx as f64, cell_m[1] / ny as f64];
        let from_m = cell_m.map(|side_m| -0.5 * side_m);
        let is_wall: Vec<bool> = self.heights_m.iter().map(|h| *h < -WALL_DEPTH * pattern.depth_m()).collect();
        let around = |i: usize, j: usize, reach: usize| {
            let near = move |at: usize, count: usize| {
                (0..=2 * reach).map(move |n| (at + count + n - reach.min(count)) % count)
            };
            near(j, ny).flat_map(move |row| near(i, nx).map(move |column| row * nx + column))
        };
        let is_beside_wall = |i: usize, j: usize| around(i, j, 1).any(|n| is_wall[n]);
        let beside_wall: Vec<bool> = (0..nx * ny).map(|n| is_beside_wall(n % nx, n / nx)).collect();
        // Height of a point next to a wall: at least the mean of the land within two points.
        let raised = |i: usize, j: usize| {
            let clear = around(i, j, 2).filter(|n| !beside_wall[*n]);
            let (sum_m, count) = clear.fold((0.0, 0), |(sum, count), n| (sum + self.heights_m[n], count + 1));
            let own_m = self.heights_m[j * nx + i];
            if count > 0 { own_m.max(sum_m / f64::from(count)) } else { own_m }
        };
        // Cumulative sums over the pixels below and to the left: area and height times area of the lands without walls,
        // then of the lands with walls.
        let mut sums = vec![[0.0; SUM_COUNT]; (nx + 1) * (ny + 1)];
        for j in 0..ny {
            let y_m = [0, 1].map(|end| from_m[1] + (j + end) as f64 * pixel_m[1]);
            let mut row = [0.0; SUM_COUNT];
            for i in 0..nx {
                let x_m = [0, 1].map(|end| from_m[0] + (i + end) as f64 * pixel_m[0]);
                let land = 1.0 - pattern.coverage(x_m[0], x_m[1], y_m[0], y_m[1]);
                let place = j * nx + i;
                let height_m = if land > 0.0 && beside_wall[place] && !is_wall[place] {
                    raised(i, j)
                } else {
                    self.heights_m[place]
                };
                let top = if is_wall[place] { 0.0 } else { land };
                let own = [top, top * height_m, land, land * height_m];
                let below = sums[j * (nx + 1) + i + 1];
                for n in 0..SUM_COUNT {
                    row[n] += own[n];
                    sums[(j + 1) * (nx + 1) + i + 1][n] = below[n] + row[n];
                }
            }
        }
        Ok(LandRelief { pixels: self.pixels, pixel_m, from_m, sums })
    }
}

/// Error for a map whose cavity is not where the pattern has a cavity; `remark` is appended.
fn elsewhere(remark: &str) -> PatternError {
    let expected = "expected one period with a cavity in its middle";
    PatternError::Refused(format!("the cavity of the relief is not where the pattern has its own: {expected}{remark}"))
}

/// Number of cumulative sums per pixel corner in [`LandRelief`]: area, and area times height, first without and then
/// with the walls of cavities.
const SUM_COUNT: usize = 4;

/// Heights of the lands of a pattern, as cumulative sums from which means over rectangles are computed.
#[derive(Clone, Debug)]
pub struct LandRelief {
    pixels: [usize; 2],
    pixel_m: [f64; 2],
    /// Corner of the map with the lowest x and y, in the pattern's axes, in metres.
    from_m: [f64; 2],
    sums: Vec<[f64; SUM_COUNT]>,
}

impl LandRelief {
    /// Mean height, in metres, of the land in the rectangle `x_m` by `y_m` in the pattern's axes, of any size, without
    /// the walls of cavities unless all land is wall; 0 without land.
    pub fn mean_m(&self, x_m: [f64; 2], y_m: [f64; 2]) -> f64 {
        let [x, y] = [(x_m, 0), (y_m, 1)]
            .map(|(ends_m, axis)| ends_m.map(|at_m| (at_m - self.from_m[axis]) / self.pixel_m[axis]));
        let corner = |x: f64, y: f64| self.sum_to(x, y);
        let [high, left, below, low] = [corner(x[1], y[1]), corner(x[0], y[1]), corner(x[1], y[0]), corner(x[0], y[0])];
        let sums: [f64; SUM_COUNT] = std::array::from_fn(|n| high[n] - left[n] - below[n] + low[n]);
        // Areas are in pixels, and a block holds several: smaller values are rounding. If all land is wall, the mean of
        // the wall is returned.
        let [top, top_height, land, height] = sums;
        match (top > 1e-9, land > 1e-9) {
            (true, _) => top_height / top,
            (false, true) => height / land,
            (false, false) => 0.0,
        }
    }

    /// Cumulative sums of the periodically repeated map from the map's corner to (`x`, `y`), in pixels.
    fn sum_to(&self, x: f64, y: f64) -> [f64; SUM_COUNT] {
        let [nx, ny] = self.pixels.map(|count| count as f64);
        let (a, b) = ((x / nx).floor(), (y / ny).floor());
        let (x, y) = (x - a * nx, y - b * ny);
        let whole = self.within(nx, ny);
        let (column, row) = (self.within(nx, y), self.within(x, ny));
        let part = self.within(x, y);
        std::array::from_fn(|n| a * b * whole[n] + a * column[n] + b * row[n] + part[n])
    }

    /// Cumulative sums from the map's corner to the point (`x`, `y`) within the map, in pixels; heights are constant in
    /// each pixel.
    fn within(&self, x: f64, y: f64) -> [f64; SUM_COUNT] {
        let [nx, ny] = self.pixels;
        // Both are within the map, so that the casts are exact.
        let (i, j) = ((x as usize).min(nx - 1), (y as usize).min(ny - 1));
        let (s, t) = (x - i as f64, y - j as f64);
        let at = |i: usize, j: usize| self.sums[j * (nx + 1) + i];
        let corners = [at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)];
        let weights = [(1.0 - s) * (1.0 - t), s * (1.0 - t), (1.0 - s) * t, s * t];
        std::array::from_fn(|n| corners.iter().zip(weights).map(|(corner, weight)| weight * corner[n]).sum())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pattern::{Planform, Rim, RimProfile, Texture};

    #[test]
    fn means_over_rectangles_are_those_of_the_pixels_they_hold() {
        let pattern = Pattern::new(Planform::Square, 40e-6, 60e-6, 10e-6).unwrap();
        let height = |i: usize, j: usize| ((i * 7 + j * 13) as f64).sin() * 1e-6;
        let map = ReliefMap::new([100e-6; 2], [50, 50], (0..2500).map(|n| height(n % 50, n / 50)).collect()).unwrap();
        let lands = map.lands(&pattern).unwrap();
        // Pixels of 2 um: the square covers 15 to 34.
        let is_land = |i: usize, j: usize| !((15..35).contains(&i) && (15..35).contains(&j));
        for (x, y) in
            [([-50, -30], [-50, -40]), ([-24, 24], [-30, 10]), ([30, 70], [-10, 130]), ([-250, 170], [-70, 90])]
        {
            let (mut sum, mut land) = (0.0, 0.0);
            for (i, j) in (x[0]..x[1]).step_by(2).flat_map(|i| (y[0]..y[1]).step_by(2).map(move |j| (i, j))) {
                let [i, j] = [i, j].map(|at: i32| (at + 50).div_euclid(2).rem_euclid(50) as usize);
                if is_land(i, j) {
                    sum += height(i, j);
                    land += 1.0;
                }
            }
            let um = |ends: [i32; 2]| ends.map(|end| f64::from(end) * 1e-6);
            let found = lands.mean_m(um(x), um(y));
            assert!((found - sum / land).abs() < 1e-15, "{x:?} {y:?}: {found} {}", sum / land);
        }
        assert_eq!(lands.mean_m([-10e-6, 10e-6], [-10e-6, 10e-6]), 0.0);
    }

    #[test]
    fn a_map_of_rims_is_as_the_rims() {
        for planform in [Planform::Groove, Planform::Square] {
            let rim = Rim::new(0.5e-6, 20e-6, RimProfile::Ramp).unwrap();
            let pattern = Pattern::new(Texture::new(planform).with_rim(rim), 60e-6, 140e-6, 20e-6).unwrap();
            let pixel = |n: usize| [n as f64 * 1e-6 - 100e-6, (n + 1) as f64 * 1e-6 - 100e-6];
            let heights = (0..40_000).map(|n| {
                let ([x0, x1], [y0, y1]) = (pixel(n % 200), pixel(n / 200));
                0.5e-6 * pattern.rim_share(x0, x1, y0, y1)
            });
            let map = ReliefMap::new([200e-6; 2], [200; 2], heights.collect()).unwrap();
            let lands = map.lands(&pattern).unwrap();
            for (x, y) in [(28.0, 5.0), (33.0, 31.0), (40.0, -35.0), (-80.0, 45.0), (95.0, 10.0)] {
                let [x, y] = [x, y].map(|from: f64| [from * 1e-6, (from + 10.0) * 1e-6]);
                let expected = 0.5e-6 * pattern.rim_share(x[0], x[1], y[0], y[1]);
                assert!((lands.mean_m(x, y) - expected).abs() < 2e-11, "{planform} {x:?}");
            }
        }
    }

    #[test]
    fn a_map_is_laid_as_the_pattern_or_refused() {
        let of = |sides_um: [f64; 2], is_cavity: &dyn Fn(f64, f64) -> bool| {
            let pixels = sides_um.map(|side_um| (side_um / 2.0) as usize);
            let place = |at: usize, axis: usize| 2.0 * at as f64 + 1.0 - 0.5 * sides_um[axis];
            let height = |n: usize| {
                if is_cavity(place(n % pixels[0], 0), place(n / pixels[0], 1)) {
                    -10e-6
                } else {
                    (n as f64).sin() * 1e-7
                }
            };
            ReliefMap::new(sides_um.map(|side| side * 1e-6), pixels, (0..pixels[0] * pixels[1]).map(height).collect())
                .unwrap()
        };
        let groove = Pattern::new(Planform::Groove, 60e-6, 140e-6, 10e-6).unwrap();
        let along_y = of([200.0, 80.0], &|x, _| x.abs() < 30.0);
        assert_eq!(along_y.turned().turned(), along_y);
        assert_eq!(along_y.turned().along(&groove).unwrap(), along_y);
        assert_eq!(along_y.clone().along(&groove).unwrap(), along_y);
        let refused = |map: ReliefMap, pattern: &Pattern| map.along(pattern).unwrap_err().to_string();
        assert!(refused(of([200.0; 2], &|x, _| x.abs() > 70.0), &groove).contains("in its middle"));
        let rectangle = |length_m: f64, across_m: f64| {
            let long = Texture::new(Planform::Rectangle).with_length_m(length_m).unwrap();
            long.with_spacing_across_m(across_m).unwrap()
        };
        let texture = rectangle(120e-6, 80e-6);
        let long = Pattern::new(texture, 60e-6, 140e-6, 10e-6).unwrap();
        let map = of([200.0; 2], &|x, y| x.abs() < 30.0 && y.abs() < 60.0);
        assert_eq!(map.clone().along(&long).unwrap(), map);
        assert!(
            refused(map.turned(), &Pattern::new(Planform::Groove, 20e-6, 180e-6, 10e-6).unwrap()).contains("middle")
        );
        let wide = Pattern::new(rectangle(40e-6, 160e-6), 160e-6, 40e-6, 10e-6);
        assert!(refused(of([200.0; 2], &|x, y| x.abs() < 20.0 && y.abs() < 80.0), &wide.unwrap()).contains("turned"));
        // Width and spacing exchanged, for cavities that overlap by more than half and for others.
        for (width, spacing) in [(140.0, 60.0), (120.0, 80.0)] {
            let turned = Pattern::new(Planform::Groove, width * 1e-6, spacing * 1e-6, 10e-6).unwrap();
            let map = of([200.0, 80.0], &|x, _| x.abs() < 0.5 * spacing);
            assert!(refused(map.clone(), &turned).contains("exchanged"), "{width}");
            assert!(map.along(&Pattern::new(Planform::Groove, spacing * 1e-6, width * 1e-6, 10e-6).unwrap()).is_ok());
        }
        // A slightly different width is accepted.
        let near = Pattern::new(Planform::Groove, 104e-6, 96e-6, 10e-6).unwrap();
        assert!(of([200.0, 80.0], &|x, _| x.abs() < 48.0).along(&near).is_ok());
        // A map of rims only has no cavity.
        assert!(of([200.0; 2], &|_, _| false).along(&long).is_ok());
    }

    #[test]
    fn maps_that_are_none_or_of_another_period_are_refused() {
        let map = |side_m: f64, heights: Vec<f64>| ReliefMap::new([side_m; 2], [2, 2], heights);
        assert!(matches!(map(0.0, vec![0.0; 4]), Err(PatternError::Refused(_))));
        for bad in [vec![0.0; 3], vec![f64::NAN; 4], Vec::new()] {
            assert!(matches!(map(1e-4, bad), Err(PatternError::Refused(_))));
        }
        let pattern = Pattern::new(Planform::Square, 50e-6, 50e-6, 1e-5).unwrap();
        assert!(map(1.01e-4, vec![0.0; 4]).unwrap().lands(&pattern).is_ok());
        let refused = map(1.1e-4, vec![0.0; 4]).unwrap().lands(&pattern).unwrap_err().to_string();
        assert!(refused.contains("110 x 110") && refused.contains("100 x 100"), "{refused}");
    }
}
