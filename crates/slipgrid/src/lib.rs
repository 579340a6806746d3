//! Laser-textured surfaces for a target dry friction: every library of slipgrid under one name.
//!
//! | room | content |
//! |---|---|
//! | [`topography`] | altitude maps: reading, levelling, measurement |
//! | [`traces`] | tribometer traces: reading, averages, static peak and stick-slip |
//! | [`contact`] | real contact area of a rough surface against pressure |
//! | [`material`] | elastic constants, local friction, the area law |
//! | [`pattern`] | planforms and their lengths |
//! | [`springblock`] | friction of a pattern: steady cells, runs in time, in the plane and in space |
//! | [`specimen`] | friction of a pattern on the specimen that it is cut into |
//! | [`calibrate`] | from measurements on samples to a material with errors |
//! | [`discrepancy`] | deviation of textured samples from the model, learned from trials |
//! | [`optimize`] | targets, bounds, limits and tolerances |
//! | [`design`] | **the main job**: predict a cut sample, search, confirm in time |
//! | [`export`] | layouts on a specimen and the files of a laser |
//! | [`formats`] | scene, design, calibration and material files |
//! | [`results`], [`report`] | records of results; text, charts and pages drawn from them |
//! | [`validate`] | the program's own evidence |
//! | [`campaign`] | many scenes or designs as tasks that any machine can do |
//! | [`disk`], [`Failure`] | access to files, results and the cache on a disk; why work on files gave no result |
//! | [`monitor`], [`units`], [`statistics`] | progress and cancelling; units of files; deviates and quantiles |
//!
//! From Python, `slipgrid.Design.read("design.toml").optimize()` does the main job: see `crates/python`.
//!
//! Only [`disk`] opens a file or touches the environment, and nothing prints: bytes come through
//! [`formats::source::Files`], time and cancelling through [`monitor::Monitor`].
//!
//! The main job: a task from the text of a design file, a search that is confirmed, a drawing for the laser.
//!
//! ```
//! use slipgrid::design::{NoCache, run};
//! use slipgrid::formats::{Document, design::Design};
//! use slipgrid::{export, monitor::Unwatched};
//!
//! let text = r#"
//!     [material]
//!     youngs_modulus_gpa = 0.38
//!     density_g_cm3 = 0.9
//!     friction = { static_mean = 0.30, dynamic_mean = 0.27, relative_std = 0.05 }
//!     area_law = { pressure_mpa = [0.7, 2.6, 26.0], factor = [1.0, 0.8, 0.3] }
//!     [target]
//!     quantity = "ratio"
//!     pressure_mpa = 2.6
//!     value = 0.95
//!     tolerance = 0.02
//!     [bounds]
//!     width_um = [100, 200]
//!     spacing_um = [200, 400]
//!     depth_um = [5, 20]
//!     [specimen]
//!     shape = "disc"
//!     diameter_mm = 2
//!     [sample]
//!     layer_um = 60
//!     block_um = 10
//! "#;
//! let design = Design::from_document(Document::new("design.toml", text))?;
//! let found = run(&design.task, &mut NoCache, &Unwatched)?;
//! println!("{}", found.report.summary());
//!
//! let layout = design.task.specimen.layout(found.pattern)?;
//! let heading = export::Heading { name: &design.task.name, version: &found.report.made_by.version, notes: &[] };
//! let mut drawing = Vec::new();
//! export::dxf(&layout, &heading, &mut drawing)?;
//! assert!(drawing.starts_with(b"999\nslipgrid"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The design in this example stands alone: a document of [`Document::new`](formats::Document::new) has no other files,
//! and a key that names a material, a calibration or a drawing is refused.
//! [`Document::within`](formats::Document::within) gives a document the files of a source. The source for files on a
//! disk is [`disk::disk`]:
//!
//! ```
//! use slipgrid::formats::{Document, design::Design};
//!
//! let path = "../../designs/ldpe-squares.toml";
//! let text = std::fs::read_to_string(path)?;
//! let alone = Design::from_document(Document::new(path, &*text));
//! assert!(alone.is_err_and(|refused| refused.key.as_deref() == Some("material")));
//!
//! let design = Design::from_document(Document::within(&slipgrid::disk::disk(), path, text))?;
//! assert!(design.inputs.iter().any(|input| input.ends_with("ldpe-cast-iron/calibration.toml")));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub use slipgrid_base::monitor;
pub use slipgrid_base::statistics;
pub use slipgrid_base::units;
pub use slipgrid_design as design;
pub use slipgrid_design::optimize;
pub use slipgrid_design::results;
pub use slipgrid_infer::calibrate;
pub use slipgrid_infer::discrepancy;
pub use slipgrid_io::formats;
pub use slipgrid_io::{Failure, campaign, disk};
pub use slipgrid_laser::export;
pub use slipgrid_laser::specimen;
pub use slipgrid_model::material;
pub use slipgrid_model::pattern;
pub use slipgrid_model::springblock;
pub use slipgrid_report as report;
pub use slipgrid_surface::contact;
pub use slipgrid_surface::topography;
pub use slipgrid_traces as traces;
pub use slipgrid_validate as validate;
