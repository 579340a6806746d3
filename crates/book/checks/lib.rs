//! Tools of the book: those of its tests, which check the chapters against the program, and the conversion of equations.
//!
//! | module | content |
//! |---|---|
//! | [`console`] | fenced blocks of a chapter, and comparison of a command's output with the chapter |
//! | [`equations`] | equations of a chapter, converted for its page |
//! | [`links`] | links and anchors of a chapter |
//! | [`keys`] | keys of a file, from the JSON schema of its table |
//! | [`schema`] | JSON schemas of files, completed, and validation of files by them |
//!
//! This crate opens no files; its tests do. Two numbers of a line agree if they differ by at most two parts in a
//! thousand plus 1.5 units of the last digit that the book shows:
//!
//! ```
//! use slipgrid_book::console::agree;
//!
//! assert!(agree("ratio 0.9153 +- 0.0114", "ratio 0.9152 +- 0.0114"));
//! assert!(!agree("ratio 0.9153 +- 0.0114", "ratio 0.9353 +- 0.0114"));
//! ```

pub mod console;
pub mod equations;
pub mod keys;
pub mod links;
pub mod schema;
