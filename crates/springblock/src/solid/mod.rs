//! The three-dimensional periodic cell.

mod lattice;
mod springs;
