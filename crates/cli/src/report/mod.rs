//! Results as files and people read them.

pub mod csv;
pub mod html;
