//! Whole commands on the files that ship.

mod designs;
