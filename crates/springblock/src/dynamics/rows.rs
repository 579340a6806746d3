//! What a sweep reads and writes: coefficients of rows, displacements and velocities of blocks.

/// Stiffness of the springs of one block over k: east, west, north, south, then the diagonals.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Springs8 {
    pub east: f64,
    pub west: f64,
    pub north: f64,
    pub south: f64,
    pub north_east: f64,
    pub north_west: f64,
    pub south_east: f64,
    pub south_west: f64,
}

/// Springs of a block inside the lattice.
pub const INSIDE: Springs8 = Springs8 {
    east: 1.0,
    west: 1.0,
    north: 1.0,
    south: 1.0,
    north_east: 0.5,
    north_west: 0.5,
    south_east: 0.5,
    south_west: 0.5,
};

/// One block's springs and inverse mass.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Site {
    pub springs: Springs8,
    pub inverse_mass: f64,
}

/// Coefficients of a row, one array per spring, one entry per column.
#[derive(Clone, Debug, Default)]
pub struct RowCoefficients {
    pub east: Vec<f64>,
    pub west: Vec<f64>,
    pub north: Vec<f64>,
    pub south: Vec<f64>,
    pub north_east: Vec<f64>,
    pub north_west: Vec<f64>,
    pub south_east: Vec<f64>,
    pub south_west: Vec<f64>,
    pub inverse_mass: Vec<f64>,
}

impl RowCoefficients {
    /// Transposes the blocks of a row.
    pub fn new(sites: &[Site]) -> Self {
        let column = |f: fn(&Site) -> f64| sites.iter().map(f).collect::<Vec<f64>>();
        Self {
            east: column(|s| s.springs.east),
            west: column(|s| s.springs.west),
            north: column(|s| s.springs.north),
            south: column(|s| s.springs.south),
            north_east: column(|s| s.springs.north_east),
            north_west: column(|s| s.springs.north_west),
            south_east: column(|s| s.springs.south_east),
            south_west: column(|s| s.springs.south_west),
            inverse_mass: column(|s| s.inverse_mass),
        }
    }
}

/// How the forces on a row are found.
#[derive(Clone, Debug)]
pub enum Row {
    /// Every block is an inside one, but for the two at free sides.
    Plain { sides: Option<[Site; 2]> },
    /// Springs or masses differ from block to block.
    General(RowCoefficients),
}

/// Displacements of all blocks, and velocities times the step. Row r, column i is at
/// r * stride + 1 + i; a column of padding on each side holds the periodic images; row ny is the bulk.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    pub nx: usize,
    pub ny: usize,
    pub stride: usize,
    pub ux: Vec<f64>,
    pub uy: Vec<f64>,
    pub wx: Vec<f64>,
    pub wy: Vec<f64>,
}

impl Field {
    /// A lattice at rest.
    #[must_use]
    pub fn at_rest(nx: usize, ny: usize) -> Self {
        // Rows begin at multiples of a cache line.
        let stride = (nx + 2).next_multiple_of(8);
        let size = stride * (ny + 1);
        Self { nx, ny, stride, ux: vec![0.0; size], uy: vec![0.0; size], wx: vec![0.0; size], wy: vec![0.0; size] }
    }

    /// Index of block (i, j).
    #[must_use]
    pub const fn at(&self, i: usize, j: usize) -> usize {
        j * self.stride + 1 + i
    }
}
