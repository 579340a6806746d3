//! Cavities that form one region: crossing grooves, which have no width, spacing and depth as a whole.

use std::fmt;

use slipgrid_base::monitor::{Cancelled, Monitor};

use super::SPECK;
use super::components::Regions;
use super::found::Found;

/// Minimum number of land patches for crossing grooves, for a region that reaches all sides of the map: one crossing
/// leaves four.
const MIN_PATCHES: usize = 4;
/// A line of pixels lies within a groove along it if at least this fraction of the line lies in cavities.
const IN_GROOVE: f64 = 0.9;
/// Fraction of a land strip between grooves that is left out on each side, to exclude walls.
const WALL: f64 = 0.1;
/// Minimum number of lines of a strip for the strip to be recommended.
const MIN_LINES: usize = 8;

/// Crossing grooves on a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crossing {
    /// Number of land patches between the grooves.
    pub patches: usize,
    /// First and last row of the widest strip between two grooves along the rows, and first and last column of the
    /// widest strip between two grooves along the columns; `None` if there is no such strip.
    pub strips: [Option<[usize; 2]>; 2],
}

impl fmt::Display for Crossing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "grooves that cross are one connected region, here around {} patches of land, and have no width, spacing and depth as a \
             whole: crop the map to a strip between two neighbours of one family",
            self.patches
        )?;
        // Uses the terms of a file, whose rows run along x.
        let named: Vec<String> = ["columns", "rows"]
            .into_iter()
            .zip(self.strips)
            .filter_map(|(name, strip)| strip.map(|[first, last]| format!("{name} {first} to {last}")))
            .collect();
        if !named.is_empty() {
            write!(f, " ({} of this map)", named.join(", or "))?;
        }
        f.write_str(", on which the other family is measured alone")
    }
}

impl Crossing {
    /// Returns the crossing grooves among the regions of `found`, if there are any.
    pub(super) fn of(found: &Found, monitor: &dyn Monitor) -> Result<Option<Self>, Cancelled> {
        let crosses = |region: &usize| [0, 1].iter().all(|&axis| found.along[axis][*region].reaches_across());
        let crossing = (1..=found.regions.count()).filter(crosses).max_by_key(|&region| found.regions.points[region]);
        let Some(region) = crossing else { return Ok(None) };
        monitor.heed()?;
        let (label, cols) = (&found.regions.label, found.cols());
        let rows = label.len() / cols;
        let inside = |n: usize| label[n] as usize == region;
        let land: Vec<f64> = (0..label.len()).map(|n| f64::from(u8::from(inside(n)))).collect();
        let patches = Regions::find(&land, cols, 0.5, SPECK, monitor)?.count();
        let share = |points: &mut dyn Iterator<Item = usize>, count: usize| {
            monitor.heed()?;
            Ok::<_, Cancelled>(points.filter(|&n| inside(n)).count() as f64 / count as f64)
        };
        let of_rows: Result<Vec<f64>, _> = (0..rows).map(|i| share(&mut (i * cols..(i + 1) * cols), cols)).collect();
        let of_cols: Result<Vec<f64>, _> =
            (0..cols).map(|j| share(&mut (j..label.len()).step_by(cols), rows)).collect();
        let strips = [strip(&of_rows?), strip(&of_cols?)];
        Ok((patches >= MIN_PATCHES).then_some(Self { patches, strips }))
    }
}

/// First and last line of the widest strip between two grooves along the lines; `share` is the fraction of each line
/// that lies in cavities. `None` if there are no two grooves, or the strip is too narrow.
fn strip(share: &[f64]) -> Option<[usize; 2]> {
    let in_groove: Vec<usize> = (0..share.len()).filter(|&line| share[line] >= IN_GROOVE).collect();
    // The strip has grooves on both sides.
    let [before, behind] =
        in_groove.windows(2).map(|pair| [pair[0], pair[1]]).max_by_key(|[before, behind]| behind - before)?;
    let margin = (WALL * (behind - before) as f64).ceil() as usize;
    let (first, last) = (before + margin, behind - margin);
    (last >= first + MIN_LINES).then_some([first, last])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_widest_strip_lies_between_two_grooves() {
        let mut share = vec![0.3; 100];
        for line in [10, 11, 12, 40, 41, 90] {
            share[line] = 1.0;
        }
        assert_eq!(strip(&share), Some([46, 85]));
        assert_eq!(strip(&share[..40]), None);
        assert_eq!(strip(&[0.3; 50]), None);
    }
}
