//! Cuts synthetic cavities into a map, for tests and demonstrations.

use std::f64::consts::TAU;

use slipgrid_base::statistics::splitmix64;

use super::RimProfile;
use crate::topography::map::check_range;
use crate::topography::{HeightMap, MapError};

/// Shape of the cavities in plan view.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum CutShape {
    /// Grooves across the whole map along y.
    #[default]
    Groove,
    /// Squares, repeated along x and y.
    Square,
    /// Discs, repeated along x and y.
    Disc,
}

slipgrid_base::names!(CutShape { Groove = "groove", Square = "square", Disc = "disc" });

/// Rim on the land around every cavity, outward from the upper end of the wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutRim {
    /// Maximum height above the land, in metres.
    pub height_m: f64,
    /// Distance from the upper end of the wall to the end of the rim, in metres; at most half of the spacing.
    pub width_m: f64,
    /// Shape of the decrease of the height from the wall outward.
    pub profile: RimProfile,
    /// Standard deviation of the heights from cavity to cavity, in metres.
    pub height_std_m: f64,
}

/// Pattern of cavities. The map begins with half a spacing of land; the sides of the map clip cavities.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutPattern {
    /// Shape in plan view.
    pub shape: CutShape,
    /// Width at half depth, in metres.
    pub width_m: f64,
    /// Land between two cavities at half depth, in metres.
    pub spacing_m: f64,
    /// Depth, in metres.
    pub depth_m: f64,
    /// Horizontal extent of a wall from the surface to the floor, in metres; less than a pixel counts as a pixel. The
    /// wall of a cavity of depth d is inclined by atan(d/wall).
    pub wall_m: f64,
    /// Standard deviation of the widths, in metres.
    pub width_std_m: f64,
    /// Standard deviation of the distances between centres, in metres.
    pub pitch_std_m: f64,
    /// Standard deviation of the depths, in metres.
    pub depth_std_m: f64,
    /// Rims, if any; the cavities are the same with and without rims.
    pub rim: Option<CutRim>,
    /// Seed of the random deviations.
    pub seed: u64,
}

/// A synthetic cavity as cut into a map, with its random deviations from the pattern.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutCavity {
    /// Centre along x and y, in metres; y of a groove is the middle of the map.
    pub center_m: [f64; 2],
    /// Width at half depth, in metres.
    pub width_m: f64,
    /// Depth, in metres.
    pub depth_m: f64,
    /// Height of the rim, in metres; 0 without a rim.
    pub rim_height_m: f64,
}

impl CutPattern {
    fn validate(&self) -> Result<(), MapError> {
        const LENGTH: &str = "a length from 1e-9 to 1 m";
        check_range("cavity width", self.width_m, 1e-9..=1.0, LENGTH)?;
        check_range("cavity spacing", self.spacing_m, 1e-9..=1.0, LENGTH)?;
        check_range("cavity depth", self.depth_m, 1e-12..=1.0, "a length from 1e-12 to 1 m")?;
        check_range("wall width", self.wall_m, 0.0..=self.width_m, "a length of at most the cavity's width")?;
        const SPREAD: &str = "at most a fifth of the mean";
        check_range("deviation of the width", self.width_std_m, 0.0..=0.2 * self.width_m, SPREAD)?;
        check_range(
            "deviation of the pitch",
            self.pitch_std_m,
            0.0..=0.2 * self.spacing_m,
            "at most a fifth of the spacing",
        )?;
        check_range("deviation of the depth", self.depth_std_m, 0.0..=0.35 * self.depth_m, "at most 0.35 of the mean")?;
        let Some(rim) = self.rim else { return Ok(()) };
        check_range("rim height", rim.height_m, 1e-12..=1e-3, "a length from 1e-12 to 1e-3 m")?;
        check_range(
            "rim width",
            rim.width_m,
            1e-9..=0.5 * self.spacing_m,
            "a length from 1e-9 m to half of the spacing",
        )?;
        check_range(
            "deviation of the rim height",
            rim.height_std_m,
            0.0..=0.35 * rim.height_m,
            "at most 0.35 of the mean",
        )
    }
}

/// Gaussian random deviates, truncated at 2.7 standard deviations by redrawing.
struct Deviates {
    state: u64,
}

impl Deviates {
    fn uniform(&mut self) -> f64 {
        self.state = self.state.wrapping_add(1);
        // (0, 1], so that the logarithm is finite.
        ((splitmix64(splitmix64(self.state)) >> 11) as f64 + 1.0) / (1_u64 << 53) as f64
    }

    fn next(&mut self) -> f64 {
        const MOST: f64 = 2.7;
        loop {
            // Box and Muller: sqrt(-2 ln u) cos(2 pi v)
            let deviate = libm::sqrt(-2.0 * libm::log(self.uniform())) * libm::cos(TAU * self.uniform());
            if deviate.abs() <= MOST {
                return deviate;
            }
        }
    }
}

impl HeightMap {
    /// Cuts the cavities of `pattern` out of the map; returns the cavities that reach into the map, ordered along x,
    /// then y.
    ///
    /// # Errors
    /// [`MapError`] if a parameter of the pattern is invalid; the map is unchanged then.
    pub fn cut_cavities(&mut self, pattern: &CutPattern) -> Result<Vec<CutCavity>, MapError> {
        pattern.validate()?;
        let sides = [self.rows() as f64 * self.dx_m(), self.cols() as f64 * self.dy_m()];
        let pitch_m = pattern.width_m + pattern.spacing_m;
        let count = |side: f64| (side / pitch_m).ceil() as usize;
        let [along_x, along_y] = match pattern.shape {
            CutShape::Groove => [count(sides[0]), 1],
            CutShape::Square | CutShape::Disc => [count(sides[0]), count(sides[1])],
        };
        let mut deviates = Deviates { state: splitmix64(pattern.seed) };
        // Rims use an independent random stream.
        let mut rim_deviates = Deviates { state: splitmix64(!pattern.seed) };
        let mut cavities = Vec::new();
        for i in 0..along_x {
            for j in 0..along_y {
                let middle = |index: usize| (index as f64 + 0.5) * pitch_m;
                // Each centre deviates by s/sqrt 2, so that the distance of two centres deviates by s.
                let mut stray = || pattern.pitch_std_m * deviates.next() / 2_f64.sqrt();
                let center_m = match pattern.shape {
                    CutShape::Groove => [middle(i) + stray(), 0.5 * sides[1]],
                    CutShape::Square | CutShape::Disc => [middle(i) + stray(), middle(j) + stray()],
                };
                let width_m = pattern.width_m + pattern.width_std_m * deviates.next();
                let depth_m = pattern.depth_m + pattern.depth_std_m * deviates.next();
                let rim_height_m = pattern.rim.map_or(0.0, |rim| rim.height_m + rim.height_std_m * rim_deviates.next());
                let begins_within = |axis: usize| center_m[axis] - 0.5 * width_m < sides[axis] * (1.0 - 1e-9);
                if begins_within(0) && (pattern.shape == CutShape::Groove || begins_within(1)) {
                    let cavity = CutCavity { center_m, width_m, depth_m, rim_height_m };
                    self.cut(pattern, &cavity);
                    cavities.push(cavity);
                }
            }
        }
        Ok(cavities)
    }

    fn cut(&mut self, pattern: &CutPattern, cavity: &CutCavity) {
        let (cols, pixel_m) = (self.cols(), [self.dx_m(), self.dy_m()]);
        let place = |axis: usize, index: usize| (index as f64 + 0.5) * pixel_m[axis] - cavity.center_m[axis];
        // Distance from the edge at half depth along one axis, positive outside.
        let beyond = |axis: usize, index: usize| place(axis, index).abs() - 0.5 * cavity.width_m;
        // Fraction of the depth at the distance d outside the edge: 1/2 - d/wall, clamped to [0, 1].
        let wall_m = [0, 1].map(|axis| pattern.wall_m.max(pixel_m[axis]));
        let share = |d: f64, wall_m: f64| (0.5 - d / wall_m).clamp(0.0, 1.0);
        // Mean of the rim over a pixel at the distance d outside the upper end of the wall.
        let rim_m = |d: f64, pixel_m: f64| {
            let mean = |rim: CutRim| rim.profile.mean(rim.width_m, d - 0.5 * pixel_m, d + 0.5 * pixel_m);
            pattern.rim.map_or(0.0, |rim| cavity.rim_height_m * mean(rim))
        };
        let mean_m = |of_m: [f64; 2]| 0.5 * (of_m[0] + of_m[1]);
        let reach_m = 0.5 * wall_m[0] + pattern.rim.map_or(0.0, |rim| rim.width_m) + pixel_m[0];
        for (i, row) in self.heights_mut().chunks_exact_mut(cols).enumerate() {
            let along_x = beyond(0, i);
            if along_x > reach_m {
                continue;
            }
            for (j, height) in row.iter_mut().enumerate() {
                let (taken, raised_m) = match pattern.shape {
                    CutShape::Groove => (share(along_x, wall_m[0]), rim_m(along_x - 0.5 * wall_m[0], pixel_m[0])),
                    CutShape::Square => {
                        let along_y = beyond(1, j);
                        // Walls meet in mitred corners; rims are rounded at corners.
                        let taken = share(along_x, wall_m[0]).min(share(along_y, wall_m[1]));
                        let out = [along_x - 0.5 * wall_m[0], along_y - 0.5 * wall_m[1]];
                        let raised_m = match out {
                            [x, y] if x > 0.0 && y > 0.0 => rim_m(x.hypot(y), mean_m(pixel_m)),
                            [x, y] if x >= y => rim_m(x, pixel_m[0]),
                            [_, y] => rim_m(y, pixel_m[1]),
                        };
                        (taken, raised_m)
                    }
                    CutShape::Disc => {
                        let radial = place(0, i).hypot(place(1, j)) - 0.5 * cavity.width_m;
                        (share(radial, mean_m(wall_m)), rim_m(radial - 0.5 * mean_m(wall_m), mean_m(pixel_m)))
                    }
                };
                *height += raised_m - cavity.depth_m * taken;
            }
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::Spread;
    use super::*;

    pub(crate) const GROOVES: CutPattern = CutPattern {
        shape: CutShape::Groove,
        width_m: 30e-6,
        spacing_m: 70e-6,
        depth_m: 5e-6,
        wall_m: 0.0,
        width_std_m: 0.0,
        pitch_std_m: 0.0,
        depth_std_m: 0.0,
        rim: None,
        seed: 1,
    };

    fn flat() -> HeightMap {
        HeightMap::new(250, 110, 1e-6, 2e-6, vec![0.0; 250 * 110]).unwrap()
    }

    #[test]
    fn grooves_take_away_their_volume() {
        for wall_m in [0.0, 12e-6] {
            let mut map = flat();
            let cut = map.cut_cavities(&CutPattern { wall_m, ..GROOVES }).unwrap();
            assert_eq!(cut.len(), 3);
            // Two whole grooves, and the third from 235 to 265, clipped at 250.
            let volume: f64 = -map.heights_m().iter().sum::<f64>() * 2e-12;
            let exact = 5e-6 * 220e-6 * (30e-6 + 30e-6 + 15e-6);
            assert!((volume / exact - 1.0).abs() < 1e-12, "{wall_m}: {volume} and {exact}");
            assert_eq!(map.heights_m()[50 * 110], -5e-6);
            assert_eq!(map.heights_m()[110 * 110], 0.0);
        }
    }

    #[test]
    fn squares_stand_in_both_directions_and_deviations_have_their_size() {
        let mut map = HeightMap::new(1000, 1000, 2e-6, 2e-6, vec![0.0; 1_000_000]).unwrap();
        let pattern = CutPattern {
            shape: CutShape::Square,
            width_std_m: 2e-6,
            pitch_std_m: 3e-6,
            depth_std_m: 0.5e-6,
            ..GROOVES
        };
        let cut = map.cut_cavities(&pattern).unwrap();
        assert_eq!(cut.len(), 400);
        // Deviates truncated at 2.7 have 0.98 of their standard deviation, which 400 of them determine to 4 %.
        let Spread { mean_m, std_m, .. } = Spread::of(cut.iter().map(|cavity| cavity.width_m)).unwrap();
        assert!((mean_m - 30e-6).abs() < 0.3e-6 && (std_m / 2e-6 - 0.98).abs() < 0.1, "{mean_m} {std_m}");
        let Spread { mean_m, std_m, .. } = Spread::of(cut.iter().map(|cavity| cavity.depth_m)).unwrap();
        assert!((mean_m - 5e-6).abs() < 0.08e-6 && (std_m / 0.5e-6 - 0.98).abs() < 0.1, "{mean_m} {std_m}");
        assert_eq!(map, {
            let mut again = HeightMap::new(1000, 1000, 2e-6, 2e-6, vec![0.0; 1_000_000]).unwrap();
            again.cut_cavities(&pattern).unwrap();
            again
        });
    }

    #[test]
    fn patterns_that_mean_nothing_are_refused() {
        let refused = |change: fn(&mut CutPattern)| {
            let mut pattern = GROOVES;
            change(&mut pattern);
            let mut map = flat();
            let error = map.cut_cavities(&pattern).unwrap_err().to_string();
            assert_eq!(map, flat());
            error
        };
        assert!(refused(|p| p.width_m = 0.0).contains("cavity width"));
        assert!(refused(|p| p.spacing_m = f64::NAN).contains("cavity spacing"));
        assert!(refused(|p| p.depth_m = -1e-6).contains("cavity depth"));
        assert!(refused(|p| p.wall_m = 31e-6).contains("wall"));
        assert!(refused(|p| p.depth_std_m = 2e-6).contains("deviation of the depth"));
    }
}
