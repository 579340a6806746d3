//! Division of a period of the pattern into columns of blocks.
//!
//! Widths of whole blocks give the regular lattice. Other widths are resolved, not rounded. A cell is divided into the
//! nearest whole number of equal columns, stretched to fit. The left edge of the first cavity lies between two columns;
//! other edges lie where the pattern puts them, so that a column may be covered in part. A sample has a length of whole
//! blocks, and its columns are fitted to the edges: each land and each cavity is divided into the nearest whole number
//! n of columns, whose common width differs from the lattice spacing l by at most l/(2 n). The depth is kept in
//! fractions of a row, the relief (heights of rims or of a measured face) as the mean over the land part of a column's
//! face.

use crate::pattern::{Pattern, ReliefMap, Texture, snap_fraction};

use crate::springblock::rims::{PLANE_STRAIN, Rims};

/// One column of blocks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Column {
    /// Width, in lattice spacings.
    pub width: f64,
    /// Fraction of the column that is cavity: 0 on land, 1 in a cavity, in between at an edge.
    pub coverage: f64,
    /// Depth of the cavity in rows, measured from the counterface; 0 on land.
    pub cavity_rows: f64,
    /// Mean height of the land part of the face, positive towards the counterface, in lattice spacings, times
    /// [`PLANE_STRAIN`].
    pub relief: f64,
}

impl Column {
    /// Creates a column of land without relief, `width` lattice spacings wide.
    pub const fn land(width: f64) -> Self {
        Self { width, coverage: 0.0, cavity_rows: 0.0, relief: 0.0 }
    }

    /// Creates a column in a cavity `cavity_rows` rows deep, `width` lattice spacings wide.
    pub const fn cavity(width: f64, cavity_rows: f64) -> Self {
        Self { width, coverage: 1.0, cavity_rows, relief: 0.0 }
    }

    /// Whether the column's lowest block touches the counterface, at least in part.
    pub fn is_land(&self) -> bool {
        self.coverage < 1.0
    }
}

/// A length that differs from a whole number of blocks by less than this fraction is rounded, so that the regular
/// lattice is reproduced to the last bit.
const WHOLE_TOLERANCE: f64 = 1e-9;

/// Rounds `blocks` to a whole number if the difference is only a rounding error.
pub fn round_if_whole(blocks: f64) -> f64 {
    if (blocks - blocks.round()).abs() < WHOLE_TOLERANCE * blocks.max(1.0) { blocks.round() } else { blocks }
}

/// Number of columns into which a length of `blocks` lattice spacings is divided.
fn columns_in(blocks: f64) -> usize {
    // Lengths are validated to be positive and below 1e8 blocks.
    blocks.round().max(1.0) as usize
}

pub fn flat(count: usize) -> Vec<Column> {
    vec![Column::land(1.0); count]
}

/// Minimum number of columns of a cell whose length is not a whole number of blocks; shorter cells are repeated.
/// Stretching to fit changes the length by at most half a column, which then keeps the stiffness of every spring
/// positive.
const MIN_STRETCHED_COLUMNS: f64 = 8.0;
/// Minimum covered or uncovered fraction of a column; smaller fractions count as 0, because nothing would support so
/// small a part of a block.
const MIN_COVERAGE: f64 = 1e-6;

/// Returns the number of periods, the number of columns and the column width of a cell `blocks` lattice spacings long.
pub fn divide(blocks: f64) -> (usize, usize, f64) {
    let is_whole = (blocks - blocks.round()).abs() < WHOLE_TOLERANCE * blocks.max(1.0) && blocks > 0.5;
    if is_whole {
        return (1, blocks.round() as usize, 1.0);
    }
    let periods = (MIN_STRETCHED_COLUMNS / blocks).ceil().max(1.0);
    let columns = (periods * blocks).round();
    (periods as usize, columns as usize, periods * blocks / columns)
}

/// Rounds a fraction of a column to 0 or 1 if it is within [`MIN_COVERAGE`] of that value.
pub fn round_share(share: f64) -> f64 {
    snap_fraction(share, MIN_COVERAGE)
}

/// Divides one period of `pattern` into columns.
///
/// Several periods are taken if the period is not a whole number of blocks and has fewer than 8 columns, or if the rims
/// have different heights. If the cell has m columns and a cavity is c columns wide, floor((m - c)/2) columns precede
/// the first cavity.
pub fn cell(pattern: &Pattern, block_m: f64) -> Vec<Column> {
    cell_with_map(pattern, block_m, None)
}

/// Like [`cell`], with the measured relief `map` of the lands.
pub fn cell_with_map(pattern: &Pattern, block_m: f64, map: Option<&ReliefMap>) -> Vec<Column> {
    let [cavity, spacing, depth] = pattern.lengths_m().map(|length_m| round_if_whole(length_m / block_m));
    let pitch = cavity + spacing;
    let repeated = Rims::periods(pattern);
    let (periods, columns, width) = divide(repeated as f64 * pitch);
    let rims = Rims::new(pattern, block_m, periods * repeated);
    let covered = columns_in(cavity / width);
    let before = columns.saturating_sub(covered) / 2;
    let edge = before as f64 * width;
    let columns = (0..columns)
        .map(|i| {
            let (left, right) = (i as f64 * width - edge, (i + 1) as f64 * width - edge);
            // Cavities m pitches from the first one, also beyond the ends of the cell.
            let overlap = |m: f64| (right.min(m * pitch + cavity) - left.max(m * pitch)).max(0.0);
            let first = (left / pitch).floor();
            let coverage = round_share((overlap(first) + overlap(first + 1.0)) / width);
            let cavity_rows = if coverage > 0.0 { depth } else { 0.0 };
            let relief = rims.as_ref().map_or(0.0, |rims| rims.mean([left, right], [cavity, pitch]));
            Column { width, coverage, cavity_rows, relief }
        })
        .collect();
    with_measured_relief(columns, pattern, block_m, map, edge)
}

/// Sets the relief of `columns` from `map`, a map of a face with `pattern`; without a map, `columns` remain as they
/// are. The left edge of a cavity lies `edge` lattice spacings from the left end.
fn with_measured_relief(
    mut columns: Vec<Column>,
    pattern: &Pattern,
    block_m: f64,
    map: Option<&ReliefMap>,
    edge: f64,
) -> Vec<Column> {
    // The scene already refuses a map that does not fit its pattern.
    let Some(lands) = map.and_then(|map| map.lands(pattern).ok()) else { return columns };
    let across_m = map.map_or(0.0, |map| map.sides_m()[1]);
    let mut left = -edge - 0.5 * pattern.width_m() / block_m;
    for column in &mut columns {
        let right = left + column.width;
        if column.is_land() {
            let x_m = [left, right].map(|at| at * block_m);
            column.relief = PLANE_STRAIN * lands.mean_m(x_m, [-0.5 * across_m, 0.5 * across_m]) / block_m;
        }
        left = right;
    }
    columns
}

/// Divides the whole specimen, `length` lattice spacings long, into columns like those of a [`strip`].
///
/// The specimen begins with half the columns of a land, like a cell, and its end cuts the last period.
pub fn sample(pattern: &Pattern, block_m: f64, length: usize) -> Vec<Column> {
    sample_with_map(pattern, block_m, length, None)
}

/// Like [`sample`], with the measured relief `map` of the lands.
pub fn sample_with_map(pattern: &Pattern, block_m: f64, length: usize, map: Option<&ReliefMap>) -> Vec<Column> {
    let [width, spacing, depth] = pattern.lengths_m().map(|length_m| round_if_whole(length_m / block_m));
    let (length, land) = (length as f64, columns_in(spacing));
    let first = (land / 2) as f64 * spacing / land as f64;
    let starts = (0..).map(|number| first + f64::from(number) * (width + spacing));
    let starts = starts.take_while(|start| start + MIN_PIECE_WIDTH <= length);
    let cavities: Vec<[f64; 2]> = starts.map(|start| [start, (start + width).min(length)]).collect();
    with_relief(strip(length, &cavities, depth), pattern, block_m, map)
}

/// Divides a strip of the specimen's face, `length` lattice spacings long, into columns.
///
/// `cavities` are disjoint intervals in ascending order, in lattice spacings, `depth` rows deep. Each land and each
/// cavity is divided into the nearest whole number of columns. A land narrower than [`MIN_PIECE_WIDTH`] is merged with
/// the adjacent cavities, a narrower cavity with the land.
pub fn strip(length: f64, cavities: &[[f64; 2]], depth: f64) -> Vec<Column> {
    let cavity = Column::cavity(1.0, round_if_whole(depth));
    let mut columns: Vec<Column> = Vec::new();
    let mut filled = 0.0;
    let mut fill = |to: f64, piece: Column| {
        let blocks = round_if_whole(to - filled);
        if blocks >= MIN_PIECE_WIDTH {
            let count = columns_in(blocks);
            columns.extend(std::iter::repeat_n(Column { width: blocks / count as f64, ..piece }, count));
            filled = to;
        }
    };
    for (number, &[start, end]) in cavities.iter().enumerate() {
        fill(start, Column::land(1.0));
        // The cavity ends at the strip's end or at the next cavity if the land between would be too narrow.
        let next = cavities.get(number + 1).map_or(length, |next| next[0]);
        fill(if next - end < MIN_PIECE_WIDTH { next } else { end }, cavity);
    }
    fill(length, Column::land(1.0));
    columns
}

/// Like [`strip`], on whole blocks for time integration: every edge lies on the nearest block boundary. A cavity is at
/// least one block wide and one row deep, and at least one of the `rows` rows remains above it.
pub fn whole_strip(length: f64, cavities: &[[f64; 2]], depth: f64, rows: usize) -> Vec<Column> {
    let columns = columns_in(round_if_whole(length));
    let deepest = (rows.max(2) - 1) as f64;
    let cavity = Column::cavity(1.0, round_if_whole(depth).round().clamp(1.0, deepest));
    let mut whole = flat(columns);
    for &[start, end] in cavities {
        // Both are bounded by the strip's length: the casts are exact.
        let from = (round_if_whole(start).round() as usize).min(columns);
        let to = (round_if_whole(end).round() as usize).max(from + 1).min(columns);
        whole[from..to].fill(cavity);
    }
    whole
}

/// Sets the relief of `columns`, each entirely land or entirely cavity, from `map`, a map of a face with `pattern`, or
/// from the rims of the pattern if there is no map.
pub fn with_relief(mut columns: Vec<Column>, pattern: &Pattern, block_m: f64, map: Option<&ReliefMap>) -> Vec<Column> {
    if map.is_some() {
        let edge = columns.iter().take_while(|column| column.is_land()).map(|column| column.width).sum();
        return with_measured_relief(columns, pattern, block_m, map, edge);
    }
    let cavities = columns.chunk_by(|a, b| a.is_land() == b.is_land()).filter(|run| !run[0].is_land()).count();
    let Some(rims) = Rims::new(pattern, block_m, cavities) else { return columns };
    let (mut left, mut cavity) = (0.0, 0);
    for run in columns.chunk_by_mut(|a, b| a.is_land() == b.is_land()) {
        let right = left + run.iter().map(|column| column.width).sum::<f64>();
        if run[0].is_land() {
            // The free ends of a face have no rim.
            let heights =
                [(cavity > 0).then(|| rims.after(cavity - 1)), (cavity < cavities).then(|| rims.before(cavity))];
            let mut start = left;
            for column in run {
                let end = start + column.width;
                column.relief = rims.integral([start, end], [left, right], heights) / column.width;
                start = end;
            }
        } else {
            cavity += 1;
        }
        left = right;
    }
    columns
}

/// Minimum width of a land or a cavity with columns of its own, in lattice spacings. Springs along the axes have
/// positive stiffness for widths between 1/sqrt(3) and sqrt(3) lattice spacings.
const MIN_PIECE_WIDTH: f64 = 0.6;

/// Returns the pattern whose width, spacing and depth are the nearest whole numbers of blocks, for time integration.
/// Each is at least one block, and the depth leaves at least one of the `rows` rows.
///
/// # Errors
/// The errors of [`Pattern::new`]; none occur for a positive block size.
pub fn nearest_whole(pattern: &Pattern, block_m: f64, rows: usize) -> Result<Pattern, crate::pattern::PatternError> {
    let whole = |length_m: f64| columns_in(round_if_whole(length_m / block_m)) as f64 * block_m;
    let deepest_m = (rows.max(2) - 1) as f64 * block_m;
    Pattern::new(
        Texture::new(pattern.planform()).with_rim(pattern.texture().rim().copied()),
        whole(pattern.width_m()),
        whole(pattern.spacing_m()),
        whole(pattern.depth_m()).min(deepest_m),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::springblock::tests::samples::groove;

    #[test]
    fn whole_blocks_give_the_plain_lattice() {
        let columns = cell(&groove(130.0, 370.0, 20.0), 10e-6);
        assert_eq!(columns.len(), 50);
        assert!(columns.iter().all(|c| c.width == 1.0));
        assert!(columns.iter().all(|c| c.is_land() || c.cavity_rows == 2.0));
        let first = columns.iter().position(|c| !c.is_land());
        assert_eq!(first, Some(18)); // floor(37 / 2)
        assert_eq!(columns.iter().filter(|c| !c.is_land()).count(), 13);
    }

    #[test]
    fn a_sample_starts_with_half_a_land_and_clips_the_last_period() {
        let columns = sample(&groove(130.0, 370.0, 20.0), 10e-6, 996);
        assert_eq!(columns.len(), 996);
        assert!(columns.iter().all(|c| c.width == 1.0));
        // A period has 50 columns and begins at column 18: cavities at 18..31, 68..81, ..., 968..981.
        for (i, column) in columns.iter().enumerate() {
            let in_cavity = i >= 18 && (i - 18) % 50 < 13;
            assert_eq!(column.is_land(), !in_cavity, "column {i}");
        }
    }

    #[test]
    fn stretched_columns_keep_every_area_and_the_first_edge() {
        for (width_um, spacing_um, periods) in [(133.7, 361.2, 1.0), (17.0, 18.0, 3.0), (7.0, 6.0, 7.0)] {
            let columns = cell(&groove(width_um, spacing_um, 14.0), 10e-6);
            let width = columns[0].width;
            assert!(columns.iter().all(|c| c.width == width) && width > 0.93 && width < 1.07, "{width}");
            assert!((width * columns.len() as f64 - 0.1 * periods * (width_um + spacing_um)).abs() < 1e-12);
            let covered: f64 = columns.iter().map(|c| c.coverage * c.width).sum();
            assert!((covered - 0.1 * periods * width_um).abs() < 1e-5, "{covered}");
        }
        let columns = cell(&groove(133.0, 367.0, 14.0), 10e-6);
        // 13.3 columns are covered: 13 columns, and 0.3 of the next one.
        assert_eq!((columns[17].coverage, columns[18].coverage, columns[30].coverage), (0.0, 1.0, 1.0));
        assert!((columns[31].coverage - 0.3).abs() < 1e-9 && columns[32].is_land());
    }

    #[test]
    fn fitted_columns_keep_the_total_length() {
        for length in [990, 991, 996, 1000] {
            let total: f64 = sample(&groove(133.7, 361.2, 14.0), 10e-6, length).iter().map(|c| c.width).sum();
            assert!((total - length as f64).abs() < 1e-9, "{length}: {total}");
        }
    }

    #[test]
    fn no_column_is_too_thin_or_too_wide_for_positive_springs() {
        // Springs along the axes have positive stiffness for widths between l/sqrt(3) and l sqrt(3).
        for width_um in [10.0, 14.9, 15.1, 44.4, 101.3] {
            for spacing_um in [10.0, 14.9, 15.1, 47.0, 512.9] {
                for column in sample(&groove(width_um, spacing_um, 20.0), 10e-6, 997) {
                    assert!(column.width > 0.6 && column.width < 1.7, "{width_um} {spacing_um} {}", column.width);
                }
            }
        }
    }

    #[test]
    fn nearest_whole_blocks_are_at_least_one_and_leave_a_row() {
        let nearest = nearest_whole(&groove(4.0, 26.0, 199.0), 10e-6, 20).unwrap();
        let close = |a: f64, b: f64| (a - b).abs() < 1e-12;
        assert!(close(nearest.width_m(), 10e-6) && close(nearest.spacing_m(), 30e-6));
        assert!(close(nearest.depth_m(), 190e-6));
    }
}
