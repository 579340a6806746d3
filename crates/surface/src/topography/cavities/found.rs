//! Detected cavities: regions, chords that end at each cavity's own half depth, floors.

use std::collections::BTreeMap;

use slipgrid_base::monitor::{Cancelled, Monitor};
use slipgrid_base::statistics::{mean_and_std, median};

use super::components::{Chord, Regions};
use super::edge::Edges;
use super::land::Land;
use super::{MARGIN, RimMetrology, SPECK};
use crate::topography::form::Form;
use crate::topography::{HeightMap, MapError};

/// Maximum distance of a length from the median that counts as near it, in pixels: lengths beside a whole number count.
const NEAR_MEDIAN: f64 = 1.5;
/// Number of chords between two checks for cancellation.
const CHORDS_TOGETHER: usize = 64;

/// Cavities of a map.
pub(super) struct Found {
    pub(super) land: Land,
    /// Heights above the land, in metres, with missing points filled.
    filled_m: Vec<f64>,
    pub(super) regions: Regions,
    /// Chords along x and y that end at each cavity's own half depth.
    pub(super) chords: [Vec<Chord>; 2],
    /// Statistics of each region's chords along x and y, by label.
    pub(super) along: [Vec<Along>; 2],
    pub(super) floors: Vec<Option<Floor>>,
    /// Whether each point lies in the middle third of a cavity.
    pub(super) middle: Vec<bool>,
    pub(super) pixel_m: [f64; 2],
    /// Fraction of a width that is excluded on either side of an edge, from the land and from the floor.
    pub(super) margin: f64,
}

impl Found {
    /// Finds the cavities of `map`, with `form` fitted to the land.
    pub(super) fn find(map: &HeightMap, form: Form, monitor: &dyn Monitor) -> Result<Self, MapError> {
        let land = Land::find(map, form, monitor)?;
        monitor.heed()?;
        let regions = Regions::find(&land.height_m, map.cols(), land.threshold_m, SPECK, monitor)?;
        if regions.count() == 0 {
            return Err(MapError::NoCavities { reason: "nothing lies below the land" });
        }
        monitor.heed()?;
        // A margin of a third of a typical width excludes rims from the land.
        let pixel_m = [map.dx_m(), map.dy_m()];
        let mut typical_m = f64::INFINITY;
        for (axis, pixel_m) in pixel_m.into_iter().enumerate() {
            let chords = regions.chords(&land.height_m, |_| land.threshold_m, axis, monitor)?;
            let mut lengths: Vec<f64> = chords.iter().filter_map(length).collect();
            typical_m = typical_m.min(median(&mut lengths).map_or(f64::INFINITY, |length| length * pixel_m));
        }
        let land = if typical_m.is_finite() {
            let margin = pixel_m.map(|pixel_m| (MARGIN * typical_m / pixel_m).ceil() as usize);
            land.refined(map, form, margin, monitor)?
        } else {
            land
        };
        monitor.heed()?;
        // Edges need a complete map, because instruments lose steep walls first.
        let mut filled = HeightMap::new(map.rows(), map.cols(), pixel_m[0], pixel_m[1], land.height_m.clone())?;
        filled.fill_missing(monitor);
        monitor.heed()?;
        let filled_m = filled.heights_m().to_vec();
        monitor.heed()?;
        let regions = Regions::find(&filled_m, map.cols(), land.threshold_m, SPECK, monitor)?;
        Self::complete(land, filled_m, regions, None, pixel_m, MARGIN, monitor)
    }

    /// Recomputes the floors below the land minus the fitted rim, which would otherwise make cavities appear deeper.
    pub(super) fn without_rim(
        self,
        edges: &Edges,
        rim: &RimMetrology,
        monitor: &dyn Monitor,
    ) -> Result<Self, MapError> {
        let bare = |(n, &height_m): (usize, &f64)| match edges.distance_m(n) {
            Some((_, distance_m)) if self.regions.label[n] == 0 => height_m - rim.fitted_m(distance_m),
            _ => height_m,
        };
        let mut bare_m = Vec::with_capacity(self.land.height_m.len());
        for (i, row) in self.land.height_m.chunks_exact(self.cols()).enumerate() {
            monitor.heed()?;
            bare_m.extend((i * self.cols()..).zip(row).map(bare));
        }
        Self::complete(self.land, self.filled_m, self.regions, Some(&bare_m), self.pixel_m, self.margin, monitor)
    }

    /// Finds the regions below `threshold_m`, a height above the form, again, and floors that begin at `margin`.
    pub(super) fn again(mut self, threshold_m: f64, margin: f64, monitor: &dyn Monitor) -> Result<Self, MapError> {
        self.land.threshold_m = threshold_m;
        let regions = Regions::find(&self.filled_m, self.cols(), threshold_m, SPECK, monitor)?;
        Self::complete(self.land, self.filled_m, regions, None, self.pixel_m, margin, monitor)
    }

    /// Computes floors and chords of `regions`; the land next to cavities is taken from `bare_m` if given.
    fn complete(
        land: Land,
        filled_m: Vec<f64>,
        regions: Regions,
        bare_m: Option<&[f64]>,
        pixel_m: [f64; 2],
        margin: f64,
        monitor: &dyn Monitor,
    ) -> Result<Self, MapError> {
        monitor.heed()?;
        let both = |threshold_m: &dyn Fn(u32) -> f64| {
            let [x, y] = [0, 1].map(|axis| regions.chords(&filled_m, threshold_m, axis, monitor));
            Ok::<_, Cancelled>([x?, y?])
        };
        let chords = both(&|_| land.threshold_m)?;
        // Each cavity has its own half depth.
        let along = Along::gather(&chords, regions.count());
        let (floors, middle) =
            floors(&regions, &chords, &along, bare_m.unwrap_or(&land.height_m), [land.threshold_m, margin], monitor)?;
        let chords = both(&|region| {
            floors[region as usize].map_or(land.threshold_m, |floor| floor.land_m - 0.5 * floor.depth_m)
        })?;
        let along = Along::gather(&chords, regions.count());
        Ok(Self { land, filled_m, regions, chords, along, floors, middle, pixel_m, margin })
    }

    /// Number of points along y.
    pub(super) fn cols(&self) -> usize {
        self.regions.cols
    }

    /// Whether a region counts along an axis: the region ends within the map along the axis, and across the axis it is
    /// whole or a groove.
    pub(super) fn counts(&self, axis: usize, region: usize) -> bool {
        let across = &self.along[1 - axis][region];
        self.along[axis][region].is_within() && (across.is_within() || across.reaches_across())
    }

    /// Whether the map's sides cut a region along no axis.
    pub(super) fn is_whole(&self, region: usize) -> bool {
        self.counts(0, region) && self.counts(1, region)
    }

    /// Whether a region shows both ends along an axis, or one complete end: it counts along the axis, or is a groove
    /// cut lengthwise by the map's side.
    fn shows_ends(&self, axis: usize, region: usize) -> bool {
        self.counts(axis, region) || self.along[1 - axis][region].reaches_across()
    }

    /// Pairs of regions that face each other along an axis on any line, and the width of the land between them on each
    /// such line, in pixels.
    pub(super) fn gaps(&self, axis: usize) -> BTreeMap<[u32; 2], Vec<f64>> {
        let mut gaps: BTreeMap<[u32; 2], Vec<f64>> = BTreeMap::new();
        for pair in self.chords[axis].windows(2) {
            if let (Some(from), Some(to)) = (pair[0].to, pair[1].from)
                && pair[0].line == pair[1].line
            {
                gaps.entry([pair[0].region, pair[1].region]).or_default().push(to - from);
            }
        }
        gaps
    }

    /// Pairs of regions that face each other along an axis on at least half of the lines of both, and the width of the
    /// land between them, in metres. Cavities cut by the map's sides are left out if any other pair remains.
    pub(super) fn neighbours(&self, axis: usize) -> Vec<([u32; 2], f64)> {
        let mut gaps = self.gaps(axis);
        gaps.retain(|pair, gaps| {
            let [one, other] = pair.map(|region| self.along[axis][region as usize].lines);
            2 * gaps.len() >= one.max(other)
        });
        let show_ends = |pair: &[u32; 2]| pair.iter().all(|&region| self.shows_ends(axis, region as usize));
        if gaps.keys().any(show_ends) {
            gaps.retain(|pair, _| show_ends(pair));
        }
        gaps.into_iter()
            .filter_map(|(pair, mut gaps)| {
                self.typical(pair[0] as usize, &mut gaps).map(|gap| (pair, gap * self.pixel_m[axis]))
            })
            .collect()
    }

    /// Median of `lengths` on lines across `region` or beside it, in pixels; of cavities that the map cuts, as it does
    /// grooves, the mean of those near the median; `None` without lengths. Of walls within a pixel lengths are whole numbers, and so is their median.
    pub(super) fn typical(&self, region: usize, lengths: &mut [f64]) -> Option<f64> {
        let middle = median(lengths)?;
        // Corners shorten the lines beside them.
        if self.is_whole(region) {
            return Some(middle);
        }
        let near = lengths.iter().copied().filter(|length| (length - middle).abs() < NEAR_MEDIAN);
        mean_and_std(near).map(|(mean, _)| mean)
    }

    /// Centre of every region along an axis, by label: the median of the middles of its chords, in metres; NaN if the
    /// map's sides cut all chords.
    pub(super) fn centers_m(&self, axis: usize) -> Vec<f64> {
        let mut middles = vec![Vec::new(); self.regions.count() + 1];
        for chord in &self.chords[axis] {
            middles[chord.region as usize].extend(chord.from.zip(chord.to).map(|(from, to)| 0.5 * (from + to)));
        }
        middles
            .iter_mut()
            .map(|middles| median(middles).map_or(f64::NAN, |middle| middle * self.pixel_m[axis]))
            .collect()
    }

    /// Edges of all regions; regions that count along no axis have edges along both.
    pub(super) fn edges(&self, monitor: &dyn Monitor) -> Result<Edges, Cancelled> {
        let counts = |axis: usize, region: u32| {
            let region = region as usize;
            self.counts(axis, region) || !self.counts(1 - axis, region)
        };
        let rows = self.regions.label.len() / self.cols();
        Edges::find(&self.chords, counts, [rows, self.cols()], self.pixel_m, monitor)
    }
}

pub(super) fn length(chord: &Chord) -> Option<f64> {
    chord.from.zip(chord.to).map(|(from, to)| to - from)
}

/// Chord statistics of a region along one axis.
#[derive(Clone, Default)]
pub(super) struct Along {
    /// Lengths of the chords that the map does not cut off, in pixels.
    pub(super) lengths: Vec<f64>,
    /// Number of lines that meet the region.
    pub(super) lines: usize,
    /// Numbers of lines on which the map cuts off the region at the start and at the end of the line.
    cut: [usize; 2],
}

impl Along {
    /// Minimum fraction of the lines on which a region must end within the map to have a width.
    const WITHIN: f64 = 0.9;

    /// Collects the chords along both axes for regions 0 to `count`.
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

    /// Whether the region ends within the map on at least [`Self::WITHIN`] of its lines.
    pub(super) fn is_within(&self) -> bool {
        self.lengths.len() as f64 >= Self::WITHIN * self.lines as f64
    }

    /// Whether the region reaches both sides of the map, as a groove does, though a turned one on no line both.
    pub(super) fn reaches_across(&self) -> bool {
        self.cut.iter().all(|&cut| cut > 0)
    }
}

/// Running mean.
#[derive(Clone, Copy, Default)]
pub(super) struct Mean {
    sum: f64,
    count: f64,
}

impl Mean {
    pub(super) fn add(&mut self, value: f64) {
        if !value.is_nan() {
            self.sum += value;
            self.count += 1.0;
        }
    }

    /// Adds the values of another mean.
    pub(super) fn join(&mut self, other: Self) {
        self.sum += other.sum;
        self.count += other.count;
    }

    pub(super) fn value(self) -> Option<f64> {
        (self.count > 0.0).then(|| self.sum / self.count)
    }
}

/// Depth of a region's floor, and height of the land next to the region.
#[derive(Clone, Copy)]
pub(super) struct Floor {
    /// Height of the adjacent land, in metres.
    pub(super) land_m: f64,
    /// Distance from the adjacent land down to the floor, in metres.
    pub(super) depth_m: f64,
}

/// Computes the adjacent land, of points above `threshold_m`, and the depth of the middle of each region, at least
/// `margin` widths from its edges, from measured points; also returns which points are in middles.
fn floors(
    regions: &Regions,
    chords: &[Vec<Chord>; 2],
    along: &[Vec<Along>; 2],
    height_m: &[f64],
    [threshold_m, margin]: [f64; 2],
    monitor: &dyn Monitor,
) -> Result<(Vec<Option<Floor>>, Vec<bool>), Cancelled> {
    let cols = regions.cols;
    // A point is in the middle if it is so along every axis on which the region ends within the map. Lines within a
    // groove's walls meet it in short chords, between which there is wall, not land.
    let mut middle = vec![true; regions.label.len()];
    // Land at the start and the end along x, and at the start and the end along y.
    let mut beside = vec![[Mean::default(); 4]; regions.count() + 1];
    for (axis, chords) in chords.iter().enumerate() {
        let length = if axis == 0 { regions.label.len() / cols } else { cols };
        let widths: Vec<f64> =
            along[axis].iter().map(|along| median(&mut along.lengths.clone()).unwrap_or_default()).collect();
        for (number, chord) in chords.iter().enumerate() {
            if number % CHORDS_TOGETHER == 0 {
                monitor.heed()?;
            }
            let ends = chord.from.zip(chord.to).filter(|_| along[axis][chord.region as usize].is_within());
            let Some((from, to)) = ends else { continue };
            let at = |k: usize| if axis == 0 { k * cols + chord.line } else { chord.line * cols + k };
            // Of the region, not of the chord: beside the short chords of corners there is wall.
            let width = widths[chord.region as usize];
            let margin = margin * width;
            for k in from.ceil() as usize..=to.floor() as usize {
                if ((k as f64) < from + margin || k as f64 > to - margin) && regions.label[at(k)] == chord.region {
                    middle[at(k)] = false;
                }
            }
            // Land ends one margin before the next cavity on the line.
            let same_line = |other: &&Chord| other.line == chord.line;
            let previous = number.checked_sub(1).and_then(|before| chords.get(before)).filter(same_line);
            let next = chords.get(number + 1).filter(same_line);
            let first = previous.map_or(0.0, |previous| previous.to.unwrap_or(0.0) + margin).max(from - width);
            let last =
                next.map_or(length as f64 - 1.0, |next| next.from.unwrap_or(length as f64) - margin).min(to + width);
            let sides = &mut beside[chord.region as usize];
            for (side, [first, last]) in [[first, from - margin], [to + margin, last]].into_iter().enumerate() {
                // The casts saturate at zero.
                for k in first.ceil() as usize..(last.floor() + 1.0).max(0.0) as usize {
                    let height_m = height_m[at(k.min(length - 1))];
                    // Lower points are specks and the smallest slivers of cavities at the map's sides.
                    if height_m > threshold_m {
                        sides[2 * axis + side].add(height_m);
                    }
                }
            }
        }
    }
    monitor.heed()?;
    let mut floor = vec![Mean::default(); regions.count() + 1];
    for ((&region, &middle), &height) in regions.label.iter().zip(&middle).zip(height_m) {
        if middle {
            floor[region as usize].add(height);
        }
    }
    let floors = floor
        .into_iter()
        .zip(beside)
        .map(|(floor, beside)| {
            // Both sides have equal weight, whatever their number of points, so that a tilt cancels.
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
        .collect();
    Ok((floors, middle))
}
