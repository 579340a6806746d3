//! File formats: serialized types, converted once into the validated types of the library crates.
//!
//! A [`Document`] is a file with its text, so that every refusal, a [`Diagnostic`], names file, line, key and accepted
//! values. Bytes come through [`source::Files`]: this module opens no files, reads no clock, prints nothing, and does
//! not touch the environment.
//!
//! | module | reads |
//! |---|---|
//! | [`scene`], [`run`] | scenes to simulate |
//! | [`design`], [`target`], [`limits`], [`trade_offs`] | a design task |
//! | [`calibration`], [`measurements`], [`measured`], [`surface`], [`reporting`] | measurements |
//! | [`altitude_map`] | an altitude map, ready for computation |
//! | [`traces`] | tribometer exports |
//! | [`material`], [`friction`] | a material and its uncertainty |
//! | [`pattern`], [`outline`], [`relief`], [`laser`] | textures, outlines of cavities, rims, measured reliefs, specimens, lasers |
//! | [`stored_pattern`] | the design and the specimen of a result |
//! | [`plausible`], [`unusual`] | numbers that are probably mistakes |
//! | [`confirmed_scene`], [`written_material`] | output files: the scene of a design, the material of a calibration |
//!
//! Every number in a file belongs to a [`slipgrid_base::units::Quantity`]. A number outside the range of the quantity
//! is refused with a diagnostic that names the key:
//!
//! ```
//! use slipgrid_io::formats::{Document, material::{MaterialFile, read_known}};
//! let text = "youngs_modulus_gpa = 0.38\ndensity_g_cm3 = 900.0\nfriction = { static_mean = 0.30, dynamic_mean = 0.27 }\n";
//! let document = Document::new("polymer.toml", text);
//! let file: MaterialFile = document.parse()?;
//! let refused = read_known(&document, &file, &(0..text.len())).unwrap_err();
//! assert_eq!((refused.line, refused.key.as_deref()), (Some(2), Some("density_g_cm3")));
//! assert!(refused.expected.is_some_and(|expected| expected.starts_with("a number above 0 up to 23 g/cm3")));
//! # Ok::<(), slipgrid_io::formats::Diagnostic>(())
//! ```

pub mod altitude_map;
pub mod calibrated;
pub mod calibration;
pub(crate) mod calibration_file;
pub mod confirmed_scene;
pub mod design;
pub mod diagnostic;
mod dimension_error;
pub mod document;
pub mod explored;
pub mod file_kind;
pub mod friction;
mod keys;
pub mod laser;
pub mod learned;
pub mod limits;
pub mod made_from;
pub mod material;
pub mod measured;
pub mod measurements;
pub mod outline;
pub mod pattern;
pub mod plausible;
pub mod readable_traces;
pub mod relief;
pub mod reporting;
pub mod run;
pub mod scene;
pub mod source;
pub mod spanned;
pub mod stated_specimen;
pub mod stored_pattern;
pub mod surface;
pub mod target;
mod trace_departures;
mod trace_notes;
mod trace_table;
pub mod traces;
pub mod trade_offs;
pub mod trials;
pub mod unusual;
pub mod values;
pub mod written_material;

pub use diagnostic::Diagnostic;
pub use document::Document;
pub use plausible::checked;
pub use spanned::Spanned;
