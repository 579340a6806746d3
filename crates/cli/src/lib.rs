//! The slipgrid command line
