//! Files: formats of scenes, designs and calibrations, folders of campaigns, and access to the disk.
//!
//! | module | content |
//! |---|---|
//! | [`formats`] | scene, design, calibration and material files |
//! | [`campaign`] | many scenes or designs as tasks for any number of machines |
//! | [`Outputs`] | files of one result, in memory |
//! | [`disk`] | access to files, results and the cache on a disk |
//! | [`Failure`] | why work on files gave no result |
//!
//! Only [`disk`] opens files, reads the clock or the environment; nothing prints. [`schemas()`] describes the files that are read as
//! JSON schemas.
//!
//! ```
//! use slipgrid_io::Outputs;
//! let mut outputs = Outputs::default();
//! outputs.add("ratio.csv", "pressure_mpa,ratio\n2.6,0.83\n");
//! assert_eq!(outputs.names(), ["ratio.csv"]);
//! assert!(outputs.text("ratio.csv").is_some_and(|text| text.ends_with("0.83\n")));
//! ```

pub mod campaign;
pub mod disk;
mod failure;
pub mod formats;
mod outputs;
mod schemas;

pub use failure::Failure;
pub use outputs::{Content, Outputs};
pub use schemas::{record_schema, schemas, sheet_schema};
