//! Cavities of a map: record, tables and the picture of their edges.

use serde::{Serialize, Serializer};
use serde_json::json;
use slipgrid_base::units::{LENGTH_UM, significant, tidy};
use slipgrid_design::results::{Table, fixed};
use slipgrid_surface::topography::{CavityMetrology, Estimate, RimMetrology, RimUnknown, Spread};

use crate::ChartError;
use crate::charts;
use crate::html::page::sentence;

pub(super) fn um(length_m: f64) -> f64 {
    LENGTH_UM.from_si(length_m)
}

/// Number of line segments of the drawn rim.
const RIM_POINTS: u32 = 240;

/// Maximum coefficient of variation of the spacings in a regular pattern.
const MAX_SCATTER: f64 = 0.5;

/// Minimum ratio of cavity depth to width; a lower ratio casts doubt on the unit of heights. A laser pulse removes some
/// 0.1 um from spots of 20 um and more (1/200), and the shallowest textures have 1/1000. If heights in micrometres are
/// read as nanometres, cavities half as deep as wide appear as 1/2000.
const MIN_ASPECT: f64 = 1.0 / 2000.0;

/// Definition of widths and spacings of round cavities, for readers of the results.
const ROUND: &str = "the cavities are round: a width is the diameter of the disc with a cavity's area at half depth, a spacing what \
                     diameters leave of the distance of neighbours";

/// Conversion of a number from SI units to the units of the record.
type Scale = fn(f64) -> f64;

/// Cavities of a map; the record has lengths in micrometres.
#[derive(Clone, Debug)]
pub(crate) struct Cavities(pub(super) CavityMetrology);

impl Serialize for Cavities {
    /// The standard error of a value is null if only one value was measured. If no rim exceeds the roughness, the rim's
    /// width, profile and standard deviations are null.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let (found, rim) = (&self.0, &self.0.rim);
        let scaled = |of: Option<Estimate>, scale: Scale| {
            of.map(|of| json!({ "value": scale(of.value), "error": of.error.map(scale) }))
        };
        let spread = |of: Option<Spread>| {
            of.map(|of| json!({ "mean_um": um(of.mean_m), "std_um": um(of.std_m), "count": of.count }))
        };
        let record = json!({
            "width_x": spread(found.width[0]),
            "width_y": spread(found.width[1]),
            "spacing_x": spread(found.spacing[0]),
            "spacing_y": spread(found.spacing[1]),
            "staggered": found.staggered.map(|rows| rows.to_string()),
            // Angle by which the grid of cavities is rotated on the map.
            "turned_deg": scaled(found.turned_deg, tidy),
            // Widths are diameters of discs with the area of the cavities.
            "round": found.round,
            "depth": spread(found.depth),
            "area_fraction": tidy(found.area_fraction),
            "land_sq_um": um(found.land_sq_m),
            "count": found.cavities.len(),
            "rim": {
                "height_um": scaled(rim.height_m, um),
                "height_std_um": scaled(rim.height_std_m, um),
                "side_std_um": scaled(rim.side_std_m, um),
                "width_um": scaled(rim.width_m, um),
                "profile": rim.profile.map(|profile| profile.name()),
                "share_of_edge": scaled(rim.share_of_edge, tidy),
                // Distance from the edge at half depth to the upper end of the wall, where the rim begins.
                "start_um": um(rim.start_m),
            },
            "wall_angle_deg": scaled(found.wall_angle_deg, tidy),
            // Wall angle above which the pixels do not resolve a wall.
            "wall_resolved_deg": found.wall_resolved_deg.map(tidy),
            "floor_sq_um": scaled(found.floor_sq_m, um),
            "crossing": found.crossing.map(|crossing| crossing.to_string()),
        });
        record.serialize(serializer)
    }
}

impl Cavities {
    /// Table of widths, spacings and depths of the cavities.
    pub(crate) fn lengths(&self) -> Table {
        let mut table = Table::new(["cavities", "mean um", "std um", "number"]);
        let found = &self.0;
        let all = [
            ("width along x", found.width[0]),
            ("width along y", found.width[1]),
            ("spacing along x", found.spacing[0]),
            ("spacing along y", found.spacing[1]),
            ("depth", found.depth),
        ];
        for (name, spread) in all.into_iter().filter_map(|(name, spread)| Some((name, spread?))) {
            let number = |length_m: f64| fixed(Some(um(length_m)), 2);
            table.row([name.to_owned(), number(spread.mean_m), number(spread.std_m), spread.count.to_string()]);
        }
        table
    }

    /// Table of rims, walls and floors.
    pub(crate) fn edges(&self) -> Table {
        let (found, rim) = (&self.0, &self.0.rim);
        let all: [(&str, Option<Estimate>, Scale, usize, &str); 7] = [
            ("rim height", rim.height_m, um, 3, "um"),
            ("rim height, cavity to cavity", rim.height_std_m, um, 3, "um"),
            ("rim height, side to side", rim.side_std_m, um, 3, "um"),
            ("rim width", rim.width_m, um, 2, "um"),
            ("share of edge with a rim", rim.share_of_edge, tidy, 3, ""),
            ("wall angle", found.wall_angle_deg, tidy, 1, "deg"),
            ("floor Sq", found.floor_sq_m, um, 3, "um"),
        ];
        let mut table = Table::new(["edges", "value", "+-", "unit"]);
        for (name, estimate, scale, decimals, unit) in all {
            let Some(Estimate { value, error }) = estimate else { continue };
            let [value, error] = [Some(value), error].map(|number| fixed(number.map(scale), decimals));
            table.row([name.to_owned(), value, error, unit.to_owned()]);
        }
        table
    }

    pub(super) fn table(&self) -> String {
        let (table, edges) = (self.lengths(), self.edges());
        let [rim, wall] = self.edge_words();
        let wall = if wall.is_empty() { wall } else { format!("; {wall}") };
        let crossing = self.0.crossing.as_ref().map_or_else(String::new, |crossing| format!("\n! {crossing}\n"));
        let round = if self.0.round { format!("  {ROUND}\n") } else { String::new() };
        let staggered = self.0.staggered.as_ref().map_or_else(String::new, |rows| format!("  {rows}\n"));
        let warnings = crate::marked("!", self.warnings());
        let (noun, verb) = if self.0.cavities.len() == 1 { ("cavity", "takes") } else { ("cavities", "take") };
        format!(
            "\n{table}{round}{staggered}{warnings}\n{} {noun} {verb} {:.1} % of the map{}; land Sq {} um\n{crossing}\n{edges}\n{rim}{wall}\n",
            self.0.cavities.len(),
            100.0 * self.0.area_fraction,
            self.cut_off(),
            fixed(Some(um(self.0.land_sq_m)), 3),
        )
    }

    /// Notes on the cavities that the tables do not contain, in sentences.
    pub(crate) fn words(&self) -> Vec<String> {
        let land = format!("The land between them has Sq {} um.", fixed(Some(um(self.0.land_sq_m)), 3));
        let edges = self.edge_words().into_iter().filter(|words| !words.is_empty());
        let crossing = self.0.crossing.iter().map(|crossing| sentence(&crossing.to_string()));
        let round = self.0.round.then(|| sentence(ROUND));
        let staggered = self.0.staggered.iter().map(|rows| sentence(&rows.to_string()));
        let warnings = self.warnings().map(|warning| sentence(&warning));
        let spacings = round.into_iter().chain(staggered).chain(warnings);
        std::iter::once(land).chain(spacings).chain(crossing).chain(edges.map(|words| sentence(&words))).collect()
    }

    /// Summarizes the number of cavities and their area.
    pub(crate) fn summary(&self) -> String {
        format!("{}, on {:.1} % of the map{}", self.0.cavities.len(), 100.0 * self.0.area_fraction, self.cut_off())
    }

    /// Counts the cavities that are not measured; empty if all are.
    fn cut_off(&self) -> String {
        match self.0.cavities.iter().filter(|cavity| cavity.width_m == [None; 2]).count() {
            cut if cut > 0 && self.0.crossing.is_none() => format!(", {cut} cut off by its sides and not measured"),
            _ => String::new(),
        }
    }

    /// Warns that heights may be in another unit than assumed; `None` unless cavities are implausibly shallow.
    fn unit_warning(&self) -> Option<String> {
        let width_um = self.0.width.iter().flatten().map(|width| um(width.mean_m));
        let (width_um, depth_um) = (width_um.fold(f64::INFINITY, f64::min), um(self.0.depth?.mean_m));
        (width_um.is_finite() && depth_um < MIN_ASPECT * width_um).then(|| {
            let [width, nm] = [width_um, 1e3 * depth_um].map(|length| significant(length, 3));
            format!(
                "unit of heights: cavities {width} um wide are {nm} nm deep, less than 1/{:.0} of their width, which is shallower than any \
                 laser cuts: the heights may be in another unit than was taken; 1000 times as large, the depth would be {nm} um",
                1.0 / MIN_ASPECT
            )
        })
    }

    /// Warnings that measured lengths may differ from the lengths of the pattern.
    fn warnings(&self) -> impl Iterator<Item = String> {
        self.unit_warning()
            .into_iter()
            .chain(self.cut_warning())
            .chain(self.depth_warning())
            .chain(self.spacing_warnings())
    }

    /// Warns that depths include rims; `None` if the rims are known or too small to matter.
    fn depth_warning(&self) -> Option<String> {
        let is_unknown = matches!(self.0.rim.unknown, Some(RimUnknown::NoLand | RimUnknown::Misfit));
        (is_unknown && self.0.depth.is_some()).then(|| {
            "depths count from what lies a third of a width to a width beside the cavities, which is not known to be land: rims \
             there, whose height is not known, make them too great"
                .to_owned()
        })
    }

    /// Width and spacing across grooves that are turned by `turn_deg`, in words; `None` for other cavities.
    fn across(&self, turn_deg: f64) -> Option<String> {
        let axis = (0..2).find(|axis| self.0.width[1 - axis].is_none())?;
        let across = |of: Spread| fixed(Some(um(of.mean_m) * turn_deg.to_radians().cos()), 2);
        let [width, spacing] = [self.0.width[axis]?, self.0.spacing[axis]?].map(across);
        Some(format!("across the grooves, where the width is {width} um and the spacing {spacing} um"))
    }

    /// Warns that no cavity ends within the map, as grooves at a large angle to its sides do not.
    fn cut_warning(&self) -> Option<String> {
        let is_measured = self.0.width.iter().any(Option::is_some) || self.0.crossing.is_some();
        (!is_measured).then(|| {
            "the map's sides cut every cavity, so that no width and no depth is known, and spacings are those along the sides: \
             measure with the grooves along a side, or a larger map"
                .to_owned()
        })
    }

    /// Warnings that measured spacings may differ from the spacings of the pattern.
    fn spacing_warnings(&self) -> impl Iterator<Item = String> {
        let turned = self.0.turned_deg.map(|turn| {
            let angle = fixed(Some(turn.value), 1);
            format!(
                "the cavities are turned by {angle} degrees on the map, from x towards y: widths and spacings are those along the map's \
                 sides, not {}",
                self.across(turn.value).unwrap_or_else(|| "along rows or across grooves".to_owned())
            )
        });
        let scattered = ["x", "y"].into_iter().zip(&self.0.spacing).filter_map(|(axis, spacing)| {
            let spacing = spacing.as_ref()?;
            (spacing.std_m > MAX_SCATTER * spacing.mean_m).then(|| {
                format!(
                    "the spacings along {axis} scatter by more than half of their mean: not every cavity faces the next of a row, \
                     and their mean is not the spacing of a pattern"
                )
            })
        });
        turned.into_iter().chain(scattered)
    }

    /// Describes the rim, and walls that are too steep for the pixels; the second text is empty if no wall is too
    /// steep.
    fn edge_words(&self) -> [String; 2] {
        let rim = &self.0.rim;
        let rim = match (rim.profile, rim.height_m) {
            (Some(profile), _) => format!("the rim's profile is {profile}"),
            (None, Some(_)) => "no rim stands out from the roughness".to_owned(),
            (None, None) => match rim.unknown {
                Some(RimUnknown::NoLand) => "the height of the rims is not known: no level land lies between the edges",
                Some(RimUnknown::Misfit) => "the height of the rims is not known: the mean profile is that of no rim",
                _ => "rims cannot be measured: too little land or edge, or too few pixels across",
            }
            .to_owned(),
        };
        let wall = match (self.0.wall_angle_deg, self.0.wall_resolved_deg) {
            (Some(angle), Some(resolved)) if angle.value >= resolved => {
                format!("walls are at least {resolved:.1} deg steep, which is all that the pixels resolve")
            }
            _ => String::new(),
        };
        [rim, wall]
    }
}

/// Formats the cavities as CSV, one row per cavity; fields are empty if the map's border cuts the cavity or a value was
/// not measured.
pub fn cavities_csv(metrology: &CavityMetrology) -> String {
    let mut table = Table::of(&metrology.cavities);
    table.numbers("x_um", |cavity| um(cavity.center_m[0]));
    table.numbers("y_um", |cavity| um(cavity.center_m[1]));
    table.numbers("width_x_um", |cavity| cavity.width_m[0].map(um));
    table.numbers("width_y_um", |cavity| cavity.width_m[1].map(um));
    table.numbers("depth_um", |cavity| cavity.depth_m.map(um));
    table.numbers("area_um2", |cavity| tidy(cavity.area_m2 * 1e12));
    table.numbers("rim_height_um", |cavity| cavity.rim_height_m.map(|height| um(height.value)));
    table.numbers("rim_height_error_um", |cavity| cavity.rim_height_m.and_then(|height| height.error).map(um));
    table.numbers("wall_angle_deg", |cavity| cavity.wall_angle_deg.map(tidy));
    table.numbers("floor_sq_um", |cavity| cavity.floor_sq_m.map(um));
    table.table().csv()
}

/// Formats the mean height of the land against the distance from the cavities' edges as CSV, one row per distance, with
/// the fitted rim.
pub fn edge_profile_csv(rim: &RimMetrology) -> String {
    let mut table = Table::of(&rim.edge_profile);
    table.numbers("distance_um", |point| um(point.distance_m));
    table.numbers("height_um", |point| um(point.height_m));
    table.numbers("height_error_um", |point| um(point.error_m));
    table.numbers("rim_um", |point| um(rim.fitted_m(point.distance_m)));
    table.table().csv()
}

/// Draws the mean height of the land against the distance from the cavities' edges, with the fitted rim; `None` without
/// land.
///
/// # Errors
/// [`ChartError`] if drawing fails.
pub fn edge_profile_svg(rim: &RimMetrology, synthetic: bool) -> Result<Option<String>, ChartError> {
    let Some(last) = rim.edge_profile.last() else { return Ok(None) };
    let points: Vec<[f64; 3]> =
        rim.edge_profile.iter().map(|point| [point.distance_m, point.height_m, point.error_m].map(um)).collect();
    let place = |step: u32| rim.start_m + (last.distance_m - rim.start_m) * f64::from(step) / f64::from(RIM_POINTS);
    let fitted: Vec<[f64; 2]> = match rim.profile {
        Some(_) => (0..=RIM_POINTS).map(place).map(|at_m| [um(at_m), um(rim.fitted_m(at_m))]).collect(),
        None => Vec::new(),
    };
    let title = if synthetic { "Land before the edges (synthetic surface)" } else { "Land before the edges" };
    let label = rim.profile.map_or_else(String::new, |profile| format!("{profile} rim"));
    charts::edge_profile(title, &points, &fitted, &label, um(rim.start_m)).map(Some)
}

#[cfg(test)]
mod tests {
    use slipgrid_surface::topography::{Form, HeightMap};

    use super::*;

    /// Report on squares of 40 um at `places_um`, on 300 x 300 pixels of 2 um.
    fn squares(places_um: &[[f64; 2]], turn_deg: f64) -> Cavities {
        let (sin, cos) = turn_deg.to_radians().sin_cos();
        let height = |n: usize| {
            let (x, y) = (2.0 * f64::from(n as u32 / 300), 2.0 * f64::from(n as u32 % 300));
            let off = |[px, py]: &[f64; 2]| {
                let (x, y) = (x - px, y - py);
                (cos * x + sin * y).abs().max((cos * y - sin * x).abs())
            };
            let nearest_um = places_um.iter().map(off).fold(f64::INFINITY, f64::min);
            -5e-6 * (0.5 + (20.0 - nearest_um) / 4.0).clamp(0.0, 1.0)
        };
        let map = HeightMap::new(300, 300, 2e-6, 2e-6, (0..90_000).map(height).collect()).unwrap();
        Cavities(map.measure_cavities(Form::Plane, &slipgrid_base::monitor::Unwatched).unwrap())
    }

    #[test]
    fn spacings_that_are_not_those_of_a_pattern_are_warned_of() {
        let grid = |turn_deg: f64| {
            let (sin, cos) = turn_deg.to_radians().sin_cos();
            let place = |n: i32| [100.0 * f64::from(n % 12 - 6), 100.0 * f64::from(n / 12 - 6)];
            (0..144).map(place).map(|[x, y]| [cos * x - sin * y + 310.0, sin * x + cos * y + 310.0]).collect::<Vec<_>>()
        };
        let straight = squares(&grid(0.0), 0.0);
        assert_eq!((straight.spacing_warnings().count(), straight.0.staggered.is_none()), (0, true));
        let turned = squares(&grid(8.0), 8.0);
        assert!(turned.table().contains("\n! the cavities are turned by 8.0 degrees on the map"), "{}", turned.table());
        assert!(turned.words().iter().any(|words| words.starts_with("The cavities are turned by 8.0")));
        // Grooves 59.8 um wide every 149.4 um, the walls 4 um wide.
        let grooves = |turn_deg: f64| {
            let (sin, cos) = turn_deg.to_radians().sin_cos();
            let across = |n: u32| 2.0 * (cos * f64::from(n / 300) + sin * f64::from(n % 300));
            let inside_um = |n: u32| 29.9 - (across(n).rem_euclid(149.4) - 74.7).abs();
            let height = |n: u32| -5e-6 * (0.5 + inside_um(n) / 4.0).clamp(0.0, 1.0);
            let map = HeightMap::new(300, 300, 2e-6, 2e-6, (0..90_000).map(height).collect()).unwrap();
            Cavities(map.measure_cavities(Form::Plane, &slipgrid_base::monitor::Unwatched).unwrap()).table()
        };
        for (turn_deg, words) in [(5.0, "5.0"), (-12.0, "-12.0")] {
            let said = grooves(turn_deg);
            assert!(
                said.contains(&format!("\n! the cavities are turned by {words} degrees on the map, from x ")),
                "{said}"
            );
            let (_, across) = said.split_once("not across the grooves, where the width is ").unwrap();
            let numbers: Vec<f64> = across.split(' ').filter_map(|word| word.parse().ok()).take(2).collect();
            assert!((numbers[0] - 59.8).abs() < 0.1 && (numbers[1] - 89.6).abs() < 0.1, "{said}");
        }
        let said = grooves(45.0);
        assert!(said.contains("\n! the map's sides cut every cavity, so that no width"), "{said}");
        // Columns of squares at distances of 60, 60 and 300 um.
        let uneven: Vec<[f64; 2]> =
            (0..12).map(|n| [[60.0, 120.0, 180.0, 480.0][n % 4], 100.0 + 150.0 * (n / 4) as f64]).collect();
        let said = squares(&uneven, 0.0).table();
        assert!(
            said.contains("! the spacings along x scatter by more than half") && !said.contains("along y scatter"),
            "{said}"
        );
    }

    #[test]
    fn staggered_rows_are_named_with_the_word_of_the_key() {
        let places: Vec<[f64; 2]> = (0..36)
            .map(|n| [50.0 + 100.0 * f64::from(n % 6) + 50.0 * f64::from(n / 6 % 2), 50.0 + 90.0 * f64::from(n / 6)])
            .collect();
        let said = squares(&places, 0.0).table();
        assert!(said.contains("the rows are staggered") && said.contains("arrangement = \"staggered\""), "{said}");
    }
}
