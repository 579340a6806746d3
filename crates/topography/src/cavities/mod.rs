//! Cavity metrology: width, spacing and depth of the cavities on a patterned surface, and their spread.
//!
//! The form is fitted to the land alone, found as the upper of two groups of heights. A cavity is a connected
//! region below half depth; its width along an axis is the median of the chords that lines cut out of it, its
//! spacing the median gap to the next on the same lines, with edges between pixels where the height crosses its own
//! half depth. Its depth is the height of the land beside it, from one third of its width to a whole one away from each
//! edge, above the middle third of its width (after ISO 5436-1, type A1: rims and walls count for neither, and
//! waves of the surface longer than a cavity do not count as depth). Where neighbours leave no such land, the
//! form fitted to all land takes its place.

mod components;
mod cut;
mod land;

use std::collections::BTreeMap;

use components::{Axis, Chord, Regions};
use land::Land;
use slipgrid_statistics::median;

pub use cut::{CutCavity, CutPattern, CutShape};

use crate::form::Form;
use crate::{HeightMap, MapError};

/// Share of the mean size below which a region is a speck.
const SPECK: f64 = 0.1;
/// Share of a width that is left out on either side of an edge, of the land and of the floor.
const MARGIN: f64 = 1.0 / 3.0;

/// Mean and scatter of one quantity over cavities.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Mean, in metres.
    pub mean_m: f64,
    /// Sample standard deviation, in metres; 0 for a single cavity.
    pub std_m: f64,
    /// Cavities, or pairs of neighbours.
    pub count: usize,
}

impl Spread {
    fn of(values: &[f64]) -> Option<Self> {
        let count = values.len();
        let mean_m = values.iter().sum::<f64>() / count as f64;
        let square: f64 = values.iter().map(|value| (value - mean_m).powi(2)).sum();
        let std_m = if count > 1 { (square / (count - 1) as f64).sqrt() } else { 0.0 };
        (count > 0).then_some(Self { mean_m, std_m, count })
    }
}

/// A cavity as it was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cavity {
    /// Centre of its area along x and y, in metres.
    pub center_m: [f64; 2],
    /// Width along x and y, in metres; `None` where the map's sides cut it off.
    pub width_m: [Option<f64>; 2],
    /// Depth, in metres; `None` where no floor was measured.
    pub depth_m: Option<f64>,
    /// Area at half depth within the map, in square metres.
    pub area_m2: f64,
}

/// What was measured.
#[derive(Clone, Debug, PartialEq)]
pub struct CavityMetrology {
    /// Widths along x and y; `None` where no cavity ends within the map along that axis, as grooves do not.
    pub width: [Option<Spread>; 2],
    /// Land between neighbours along x and y.
    pub spacing: [Option<Spread>; 2],
    /// Depths.
    pub depth: Option<Spread>,
    /// Share of the map below half depth.
    pub area_fraction: f64,
    /// Half depth, below the land, in metres.
    pub threshold_m: f64,
    /// Root mean square height of the land about its form, in metres.
    pub land_sq_m: f64,
    /// Every cavity.
    pub cavities: Vec<Cavity>,
}

impl HeightMap {
    /// Measures the cavities; `form` is fitted to the land. Missing points are bridged where edges are sought, and
    /// left out of depths.
    ///
    /// # Errors
    /// [`MapError::NoCavities`] if heights do not part into land and floors; [`MapError::FormUndetermined`] if
    /// the land does not determine the form.
    pub fn measure_cavities(&self, form: Form) -> Result<CavityMetrology, MapError> {
        let land = Land::find(self, form)?;
        let regions = Regions::find(&land.height_m, self.cols(), land.threshold_m, SPECK);
        if regions.count() == 0 {
            return Err(MapError::NoCavities { reason: "nothing lies below the land" });
        }
        // A third of a typical width keeps rims out of the land.
        let pixel_m = [self.dx_m(), self.dy_m()];
        let typical_m = [Axis::X, Axis::Y]
            .into_iter()
            .zip(pixel_m)
            .filter_map(|(axis, pixel_m)| {
                let chords = regions.chords(&land.height_m, |_| land.threshold_m, axis);
                let mut lengths: Vec<f64> = chords.iter().filter_map(length).collect();
                median(&mut lengths).map(|length| length * pixel_m)
            })
            .fold(f64::INFINITY, f64::min);
        let land = if typical_m.is_finite() {
            land.refined(self, form, pixel_m.map(|pixel_m| (MARGIN * typical_m / pixel_m).ceil() as usize))
        } else {
            land
        };
        // Edges are sought on a complete map: instruments lose the steep walls first.
        let mut filled = Self::new(self.rows(), self.cols(), pixel_m[0], pixel_m[1], land.height_m.clone())?;
        filled.fill_missing();
        Ok(measure(&filled, &land))
    }
}

fn length(chord: &Chord) -> Option<f64> {
    chord.from.zip(chord.to).map(|(from, to)| to - from)
}

/// What is gathered about a region along one axis.
#[derive(Clone, Default)]
struct Along {
    lengths: Vec<f64>,
    /// Lines that meet the region; those on which the map cuts it off before, behind.
    lines: usize,
    cut: [usize; 2],
}

impl Along {
    /// Share of the lines on which a region must end within the map to have a width.
    const WITHIN: f64 = 0.9;

    /// Gathers the chords along both axes for regions 0 to `count`.
    fn gather(chords: &[Vec<Chord>; 2], count: usize) -> [Vec<Self>; 2] {
        let mut along = [vec![Self::default(); count + 1], vec![Self::default(); count + 1]];
        for (along, chords) in along.iter_mut().zip(chords) {
            for chord in chords {
                let along = &mut along[chord.region as usize];
                along.lines += 1;
                along.cut[0] += usize::from(chord.from.is_none());
                along.cut[1] += usize::from(chord.to.is_none());
                along.lengths.extend(length(chord));
            }
        }
        along
    }

    /// The map does not cut it off.
    fn is_within(&self) -> bool {
        self.lengths.len() as f64 >= Self::WITHIN * self.lines as f64
    }

    /// It runs through the whole map.
    fn runs_through(&self) -> bool {
        self.cut.iter().all(|&cut| cut as f64 >= Self::WITHIN * self.lines as f64)
    }
}

fn measure(filled: &HeightMap, land: &Land) -> CavityMetrology {
    let (cols, pixel_m) = (filled.cols(), [filled.dx_m(), filled.dy_m()]);
    let heights = filled.heights_m();
    let regions = Regions::find(heights, cols, land.threshold_m, SPECK);
    let chords = [Axis::X, Axis::Y].map(|axis| regions.chords(heights, |_| land.threshold_m, axis));
    // Each cavity has its own half depth.
    let floors = floors(&regions, &chords, &Along::gather(&chords, regions.count()), land, cols);
    let half_m =
        |region: u32| floors[region as usize].map_or(land.threshold_m, |floor| floor.land_m - 0.5 * floor.depth_m);
    let chords = [Axis::X, Axis::Y].map(|axis| regions.chords(heights, half_m, axis));

    let along = Along::gather(&chords, regions.count());
    // A region counts along an axis if it ends within the map there and is, across, either whole or a groove.
    let counts = |axis: usize, region: usize| {
        let across = &along[1 - axis][region];
        along[axis][region].is_within() && (across.is_within() || across.runs_through())
    };

    let spacing = [0, 1].map(|axis| {
        // Gaps of each pair of neighbours, line by line.
        let mut gaps: BTreeMap<(u32, u32), Vec<f64>> = BTreeMap::new();
        for pair in chords[axis].windows(2) {
            if let (Some(from), Some(to)) = (pair[0].to, pair[1].from)
                && pair[0].line == pair[1].line
            {
                gaps.entry((pair[0].region, pair[1].region)).or_default().push(to - from);
            }
        }
        let values: Vec<f64> = gaps
            .into_iter()
            .filter(|((one, other), gaps)| {
                // Neighbours face each other on most of their lines.
                let lines = along[axis][*one as usize].lines.min(along[axis][*other as usize].lines);
                2 * gaps.len() >= lines
            })
            .filter_map(|(_, mut gaps)| median(&mut gaps).map(|gap| gap * pixel_m[axis]))
            .collect();
        Spread::of(&values)
    });

    let mut center = vec![[0.0; 2]; regions.count() + 1];
    for (n, &region) in regions.label.iter().enumerate() {
        center[region as usize][0] += (n / cols) as f64 + 0.5;
        center[region as usize][1] += (n % cols) as f64 + 0.5;
    }
    let cavities: Vec<Cavity> = (1..=regions.count())
        .map(|region| {
            let points = regions.points[region] as f64;
            let width_m = [0, 1].map(|axis| {
                let mut lengths = along[axis][region].lengths.clone();
                median(&mut lengths).filter(|_| counts(axis, region)).map(|length| length * pixel_m[axis])
            });
            Cavity {
                center_m: [0, 1].map(|axis| center[region][axis] / points * pixel_m[axis]),
                width_m,
                depth_m: floors[region].filter(|_| counts(0, region) || counts(1, region)).map(|floor| floor.depth_m),
                area_m2: points * pixel_m[0] * pixel_m[1],
            }
        })
        .collect();
    let spread =
        |value: &dyn Fn(&Cavity) -> Option<f64>| Spread::of(&cavities.iter().filter_map(value).collect::<Vec<f64>>());
    CavityMetrology {
        width: [spread(&|cavity| cavity.width_m[0]), spread(&|cavity| cavity.width_m[1])],
        spacing,
        depth: spread(&|cavity| cavity.depth_m),
        area_fraction: regions.points.iter().sum::<usize>() as f64 / heights.len() as f64,
        threshold_m: -land.threshold_m,
        land_sq_m: land.sq_m(),
        cavities,
    }
}

/// Mean of what is added to it.
#[derive(Clone, Copy, Default)]
struct Mean {
    sum: f64,
    count: f64,
}

impl Mean {
    fn add(&mut self, value: f64) {
        if !value.is_nan() {
            self.sum += value;
            self.count += 1.0;
        }
    }

    fn value(self) -> Option<f64> {
        (self.count > 0.0).then(|| self.sum / self.count)
    }
}

/// The level of a region's floor.
#[derive(Clone, Copy)]
struct Floor {
    /// Height of the land beside it, in metres.
    land_m: f64,
    /// Distance from there down to the floor, in metres.
    depth_m: f64,
}

/// The land beside each region and the depth of its middle third, over points that were measured.
fn floors(
    regions: &Regions,
    chords: &[Vec<Chord>; 2],
    along: &[Vec<Along>; 2],
    land: &Land,
    cols: usize,
) -> Vec<Option<Floor>> {
    // A point is in the middle if it is so along every axis on which the region ends within the map. Along a groove
    // the lines in its walls meet it in short chords: what lies between those is wall, not land.
    let mut middle = vec![true; regions.label.len()];
    // The land before and behind along x, before and behind along y.
    let mut beside = vec![[Mean::default(); 4]; regions.count() + 1];
    for (axis, chords) in chords.iter().enumerate() {
        let length = if axis == 0 { regions.label.len() / cols } else { cols };
        for (number, chord) in chords.iter().enumerate() {
            let ends = chord.from.zip(chord.to).filter(|_| along[axis][chord.region as usize].is_within());
            let Some((from, to)) = ends else { continue };
            let at = |k: usize| if axis == 0 { k * cols + chord.line } else { chord.line * cols + k };
            let margin = MARGIN * (to - from);
            for k in from.ceil() as usize..=to.floor() as usize {
                if ((k as f64) < from + margin || k as f64 > to - margin) && regions.label[at(k)] == chord.region {
                    middle[at(k)] = false;
                }
            }
            // Land ends a margin before the next cavity on the line.
            let same_line = |other: &&Chord| other.line == chord.line;
            let previous = number.checked_sub(1).and_then(|before| chords.get(before)).filter(same_line);
            let next = chords.get(number + 1).filter(same_line);
            let first = previous.map_or(0.0, |previous| previous.to.unwrap_or(0.0) + margin).max(from - (to - from));
            let last = next
                .map_or(length as f64 - 1.0, |next| next.from.unwrap_or(length as f64) - margin)
                .min(to + (to - from));
            let sides = &mut beside[chord.region as usize];
            for (side, [first, last]) in [[first, from - margin], [to + margin, last]].into_iter().enumerate() {
                // The casts saturate at zero.
                for k in first.ceil() as usize..(last.floor() + 1.0).max(0.0) as usize {
                    sides[2 * axis + side].add(land.height_m[at(k.min(length - 1))]);
                }
            }
        }
    }
    let mut floor = vec![Mean::default(); regions.count() + 1];
    for ((&region, &middle), &height) in regions.label.iter().zip(&middle).zip(&land.height_m) {
        if middle {
            floor[region as usize].add(height);
        }
    }
    floor
        .into_iter()
        .zip(beside)
        .map(|(floor, beside)| {
            // Both sides weigh alike, whatever their number of points: a tilt drops out.
            let mut sides = Mean::default();
            for axis in beside.chunks_exact(2) {
                match (axis[0].value(), axis[1].value()) {
                    (Some(before), Some(behind)) => sides.add(0.5 * (before + behind)),
                    (one, other) => sides.add(one.or(other).unwrap_or(f64::NAN)),
                }
            }
            let land_m = sides.value().unwrap_or(0.0);
            floor.value().map(|floor| Floor { land_m, depth_m: land_m - floor })
        })
        .collect()
}

#[cfg(test)]
mod tests;
