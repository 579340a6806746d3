//! Cavity metrology: width, spacing and depth of the cavities on a patterned surface, and their spread.
//!
//! The form is fitted to the land only, which is the upper of two groups of heights. A cavity is a connected region
//! below half depth. Its width along an axis is the median of the chords that lines cut out of it; the spacing is the
//! median gap to the next cavity on the same lines. Of grooves both are means near the median. Edges are interpolated
//! between pixels where the height crosses the cavity's own half depth. For round cavities the width is the diameter of
//! the disc (or ellipse) with the same area at half depth, and the spacing is the distance of neighbouring centres
//! minus the diameter. Cavities cut by the map's sides have no width, and their spacing counts only if no whole
//! cavities face each other. If every second row is shifted by half a pitch, the spacing across the rows is the land to
//! the next row ([`StaggeredRows`]).
//!
//! The depth is the height of the adjacent land above the middle third of the cavity's width. The land is taken from
//! one third of the width to the full width away from each edge (after ISO 5436-1, type A1), which excludes rims and
//! walls, and keeps surface waves longer than a cavity from counting as depth. If neighbours leave no such land, the
//! form fitted to all land replaces it. Walls wider than two thirds of a cavity reach into both thirds, which then begin
//! where the walls end; of walls wider than nine tenths, the depth is that of the middle tenth.
//!
//! Rims along the edges are measured from the mean of all heights at equal distances from an edge ([`RimMetrology`]). A
//! rim that reaches into the adjacent land would make its cavity appear deeper, so depths refer to the land minus the
//! fitted rim. Widths and spacings at half depth do not depend on rims if the walls were measured. If wall points are
//! missing, the smooth surface that fills them begins on the rim, and the width grows at most by the ratio of the rim's
//! height to the missing part of the wall.

mod components;
mod crossing;
mod cut;
mod edge;
mod found;
mod grid;
mod heights;
mod kriging;
mod land;
mod land_map;
mod period;
mod pitch;
mod rims;
mod round;
mod scene;
mod share;
mod walls;

use std::collections::BTreeMap;

use edge::Edges;
use found::{Floor, Found};
use grid::Grid;
use scene::Scene;
use slipgrid_base::monitor::{Cancelled, Monitor};
use slipgrid_base::statistics::mean_and_std;
use walls::Walls;

pub use crossing::Crossing;
pub use cut::{CutCavity, CutPattern, CutRim, CutShape};
pub use grid::StaggeredRows;
pub use period::{Arrangement, MeanPeriod};
pub use rims::{EdgeHeight, RimMetrology, RimUnknown};
pub use slipgrid_model::pattern::RimProfile;

use crate::topography::form::Form;
use crate::topography::{HeightMap, MapError};

/// A region smaller than this fraction of the mean size of regions is a speck, not a cavity.
const SPECK: f64 = 0.1;
/// Fraction of a width that is excluded on either side of an edge, from the land and from the floor.
const MARGIN: f64 = 1.0 / 3.0;
/// Greatest such fraction, for walls that reach farther.
const MAX_MARGIN: f64 = 0.45;
/// Maximum distance of the level below which cavities are found from half depth, relative to the depth. The first level
/// is half-way between the medians of land and cavities, whose walls may be most of their area.
const MAX_LEVEL_ERROR: f64 = 0.02;
/// Maximum number of rounds of finding cavities again where walls are wide; a round divides errors by some twenty.
const WALL_ROUNDS: usize = 2;

/// Mean and scatter of a quantity over cavities.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Mean, in metres.
    pub mean_m: f64,
    /// Sample standard deviation, in metres; 0 for a single cavity.
    pub std_m: f64,
    /// Number of cavities, or of pairs of neighbours.
    pub count: usize,
}

impl Spread {
    fn of(values: impl Iterator<Item = f64> + Clone) -> Option<Self> {
        let count = values.clone().count();
        let (mean_m, std_m) = mean_and_std(values)?;
        Some(Self { mean_m, std_m: std_m.unwrap_or(0.0), count })
    }
}

/// A quantity with its standard error, both in the unit given by the suffix of the field's name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Estimated value.
    pub value: f64,
    /// Standard error; `None` if a single sample shows no scatter.
    pub error: Option<f64>,
}

impl Estimate {
    /// Mean of independent samples, with the standard error from their scatter; `None` without samples.
    fn mean(values: impl Iterator<Item = f64> + Clone) -> Option<Self> {
        let count = values.clone().count() as f64;
        let (value, std) = mean_and_std(values)?;
        Some(Self { value, error: std.map(|std| std / count.sqrt()) })
    }
}

/// A detected cavity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cavity {
    /// Centroid of the cavity's area along x and y, in metres.
    pub center_m: [f64; 2],
    /// Width along x and y, the diameter for round cavities, in metres; `None` if the map's sides cut the cavity.
    pub width_m: [Option<f64>; 2],
    /// Depth, in metres; `None` if no floor was measured.
    pub depth_m: Option<f64>,
    /// Area at half depth within the map, in square metres.
    pub area_m2: f64,
    /// Mean height of the rim along the edge, in metres; `None` if no cavity has a rim, and at the map's sides.
    pub rim_height_m: Option<Estimate>,
    /// Slope of the wall between 20 % and 80 % of the depth, in degrees from the horizontal; `None` if it was not
    /// measured.
    pub wall_angle_deg: Option<f64>,
    /// Root mean square height of the floor's middle third about its plane, in metres; `None` if it was not measured.
    pub floor_sq_m: Option<f64>,
}

/// Results of the cavity metrology.
#[derive(Clone, Debug, PartialEq)]
pub struct CavityMetrology {
    /// Widths along x and y, in metres; `None` if no cavity ends within the map along that axis, as for grooves.
    pub width: [Option<Spread>; 2],
    /// Width of the land between neighbours along x and y, in metres, across staggered rows that of the land to the
    /// next row; `None` for an axis without neighbours.
    pub spacing: [Option<Spread>; 2],
    /// Staggered rows; `None` unless every second row of cavities is shifted by half a pitch.
    pub staggered: Option<StaggeredRows>,
    /// Rotation of a rectangular grid of cavities, or of grooves, on the map, in degrees from x towards y; `None` below
    /// 1 degree, or if it cannot be determined.
    pub turned_deg: Option<Estimate>,
    /// Whether the cavities are round, so that widths are diameters of discs with the same area at half depth, not
    /// median chords.
    pub round: bool,
    /// Depth of the cavities, in metres; `None` if no floor was measured.
    pub depth: Option<Spread>,
    /// Area fraction of the map below half depth.
    pub area_fraction: f64,
    /// Root mean square height of the land about its form, in metres.
    pub land_sq_m: f64,
    /// Rims along the edges.
    pub rim: RimMetrology,
    /// Mean slope of the walls between 20 % and 80 % of the depth, in degrees from the horizontal; `None` if no depth
    /// was measured, or no heights on the walls.
    pub wall_angle_deg: Option<Estimate>,
    /// Slope of a wall three pixels wide, in degrees; of steeper walls it is only a lower bound. `None` if no depth was
    /// measured.
    pub wall_resolved_deg: Option<f64>,
    /// Mean of the root mean square heights of the floors' middle thirds about their planes, in metres; `None` if no
    /// floor has the points that a plane needs.
    pub floor_sq_m: Option<Estimate>,
    /// All cavities.
    pub cavities: Vec<Cavity>,
    /// Crossing grooves, if the cavities form one region; otherwise `None`.
    pub crossing: Option<Crossing>,
}

impl HeightMap {
    /// Measures the cavities; `form` is fitted to the land. Missing points are filled for the detection of edges, and
    /// left out of depths.
    ///
    /// # Errors
    /// [`MapError::NoCavities`] if heights do not separate into land and floors; [`MapError::FormUndetermined`] if the
    /// land does not determine the form; [`MapError::Cancelled`] once `monitor` has cancelled.
    pub fn measure_cavities(&self, form: Form, monitor: &dyn Monitor) -> Result<CavityMetrology, MapError> {
        let (found, sought) = Sought::with_rims(Found::find(self, form, monitor)?, monitor)?;
        Ok(measure(&found, sought, monitor)?)
    }
}

/// Quantities measured along the edges of cavities.
struct Sought {
    /// Whether each region, by label, ends within the map along at least one axis.
    counts: Vec<bool>,
    /// Width of each region along x and y, by label; `None` if the region does not end within the map along the axis.
    width_m: Vec<[Option<f64>; 2]>,
    spacing: [Option<Spread>; 2],
    /// Mean width of the cavities, the smaller of those along x and y, in metres; 0 without any.
    mean_width_m: f64,
    edges: Edges,
    walls: Walls,
    rim: RimMetrology,
    /// Rim height of each region, by label, in metres.
    rim_heights: BTreeMap<u32, Estimate>,
}

impl Sought {
    /// Measures edges, walls and rims of `found`; if walls are wide, or if there are rims, land and floors are measured
    /// again beyond them.
    fn with_rims(mut found: Found, monitor: &dyn Monitor) -> Result<(Found, Self), MapError> {
        let mut sought = Self::along_edges(&found, monitor)?;
        for _ in 0..WALL_ROUNDS {
            let pixel_m = found.pixel_m[0].max(found.pixel_m[1]);
            let most = MAX_MARGIN.min(0.5 - pixel_m / sought.mean_width_m);
            let margin = ((sought.walls.top_m + pixel_m) / sought.mean_width_m).min(most).max(found.margin);
            let floors = found.floors.iter().zip(&sought.counts).filter(|(_, counts)| **counts);
            let floors: Vec<Floor> = floors.filter_map(|(floor, _)| *floor).collect();
            let mean_m = |of_m: fn(&Floor) -> f64| mean_and_std(floors.iter().map(of_m)).map(|(mean_m, _)| mean_m);
            let Some((land_m, depth_m)) = mean_m(|floor| floor.land_m).zip(mean_m(|floor| floor.depth_m)) else {
                break;
            };
            let half_m = land_m - 0.5 * depth_m;
            if margin <= found.margin && (half_m - found.land.threshold_m).abs() <= MAX_LEVEL_ERROR * depth_m {
                break;
            }
            found = found.again(half_m, margin, monitor)?;
            sought = Self::along_edges(&found, monitor)?;
        }
        if sought.rim.width_m.is_none() {
            return Ok((found, sought));
        }
        let found = found.without_rim(&sought.edges, &sought.rim, monitor)?;
        let sought = Self::along_edges(&found, monitor)?;
        Ok((found, sought))
    }

    fn along_edges(found: &Found, monitor: &dyn Monitor) -> Result<Self, MapError> {
        let regions = 0..=found.regions.count();
        let counts: Vec<bool> =
            regions.clone().map(|region| region > 0 && (found.counts(0, region) || found.counts(1, region))).collect();
        let width_m: Vec<[Option<f64>; 2]> = regions
            .map(|region| {
                [0, 1].map(|axis| {
                    let mut lengths = found.along[axis][region].lengths.clone();
                    let width =
                        found.typical(region, &mut lengths).filter(|_| region > 0 && found.counts(axis, region));
                    width.map(|length| length * found.pixel_m[axis])
                })
            })
            .collect();
        let spacing = [0, 1].map(|axis| Spread::of(found.neighbours(axis).iter().map(|(_, gap_m)| *gap_m)));
        let widths = [0, 1].map(|axis| Spread::of(width_m.iter().filter_map(|width| width[axis])));
        let least_m =
            |spreads: [Option<Spread>; 2]| spreads.into_iter().flatten().map(|spread| spread.mean_m).reduce(f64::min);
        let edges = found.edges(monitor)?;
        let mean_width_m = least_m(widths).unwrap_or(0.0);
        let walls = walls::measure(found, &edges, &counts, mean_width_m, monitor)?;
        let least_pixel_m = found.pixel_m[0].min(found.pixel_m[1]);
        let scene = Scene {
            edges: &edges,
            height_m: &found.land.height_m,
            label: &found.regions.label,
            threshold_m: found.land.threshold_m,
            counts: &counts,
            pixel_m: found.pixel_m,
            bin_m: edges.points.iter().map(|edge| found.pixel_m[edge.axis]).fold(least_pixel_m, f64::max),
            start_m: walls.top_m,
            width_m: mean_width_m,
            spacing_m: least_m(spacing),
        };
        let (rim, rim_heights) = rims::measure(&scene, monitor)?;
        Ok(Self { counts, width_m, spacing, mean_width_m, edges, walls, rim, rim_heights })
    }
}

fn measure(found: &Found, sought: Sought, monitor: &dyn Monitor) -> Result<CavityMetrology, Cancelled> {
    let diameters_m = round::diameters(found);
    let mut spacing = diameters_m
        .as_ref()
        .map_or(sought.spacing, |diameters_m| [0, 1].map(|axis| round::spacing(found, axis, diameters_m)));
    let width_m = |region: usize| {
        let diameter_m = diameters_m.as_ref().and_then(|diameters_m| diameters_m[region]);
        diameter_m.map_or(sought.width_m[region], |diameter_m| diameter_m.map(Some))
    };
    let grid = Grid::of(found, width_m);
    let staggered = grid.staggered().map(|(rows, to_next)| {
        spacing[usize::from(!rows.along_y)] = Some(to_next);
        rows
    });
    let (regions, cols, pixel_m) = (&found.regions, found.cols(), found.pixel_m);
    let mut center = vec![[0.0; 2]; regions.count() + 1];
    for (i, row) in regions.label.chunks_exact(cols).enumerate() {
        monitor.heed()?;
        for (j, &region) in row.iter().enumerate() {
            center[region as usize][0] += i as f64 + 0.5;
            center[region as usize][1] += j as f64 + 0.5;
        }
    }
    let cavities: Vec<Cavity> = (1..=regions.count())
        .map(|region| {
            let points = regions.points[region] as f64;
            let measured = |value: Option<f64>| value.filter(|_| sought.counts[region]);
            Cavity {
                center_m: [0, 1].map(|axis| center[region][axis] / points * pixel_m[axis]),
                width_m: width_m(region),
                depth_m: measured(found.floors[region].map(|floor| floor.depth_m)),
                area_m2: points * pixel_m[0] * pixel_m[1],
                // At most 2^28 regions: the cast is exact.
                rim_height_m: sought.rim_heights.get(&(region as u32)).copied(),
                wall_angle_deg: measured(sought.walls.angle_deg[region]),
                floor_sq_m: measured(sought.walls.floor_sq_m[region]),
            }
        })
        .collect();
    let spread = |value: &dyn Fn(&Cavity) -> Option<f64>| Spread::of(cavities.iter().filter_map(value));
    let depth = spread(&|cavity| cavity.depth_m);
    Ok(CavityMetrology {
        width: [spread(&|cavity| cavity.width_m[0]), spread(&|cavity| cavity.width_m[1])],
        spacing,
        staggered,
        turned_deg: grid.turned_deg().or_else(|| grid::grooves_turned_deg(found)),
        round: diameters_m.is_some(),
        depth,
        area_fraction: regions.points.iter().sum::<usize>() as f64 / regions.label.len() as f64,
        land_sq_m: found.land.sq_m(),
        rim: sought.rim,
        wall_angle_deg: Estimate::mean(cavities.iter().filter_map(|cavity| cavity.wall_angle_deg)),
        wall_resolved_deg: depth.map(|depth| walls::resolved_deg(depth.mean_m, pixel_m)),
        floor_sq_m: Estimate::mean(cavities.iter().filter_map(|cavity| cavity.floor_sq_m)),
        cavities,
        crossing: Crossing::of(found, monitor)?,
    })
}

#[cfg(test)]
mod rim_tests;
#[cfg(test)]
mod tests;
