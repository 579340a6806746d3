//! What the tests of the book need: they hold its chapters to the program.
//!
//! | module | holds |
//! |---|---|
//! | [`console`] | fenced blocks of a chapter, and whether a command prints what the chapter shows |
//! | [`links`] | links and anchors of a chapter |
//! | [`keys`] | the keys of a file, read from the source text of the types that read it |
//! | [`schema`] | JSON schemas of these keys, and whether a file obeys one |
//!
//! This crate opens no files; its tests do. Two numbers of a printed line agree where they differ by two parts in a thousand at
//! most, or by one unit of the last digit that the book shows:
//!
//! ```
//! use slipgrid_book::console::agree;
//!
//! assert!(agree("ratio 0.9153 +- 0.0114", "ratio 0.9152 +- 0.0114"));
//! assert!(!agree("ratio 0.9153 +- 0.0114", "ratio 0.9353 +- 0.0114"));
//! ```

pub mod console;
pub mod keys;
pub mod links;
pub mod schema;
