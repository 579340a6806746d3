//! The `slipgrid` program: glue only.

fn main() {}
