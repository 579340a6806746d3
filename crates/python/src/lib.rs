//! Python bindings of the slipgrid libraries.
//!
//! | module | binds |
//! |---|---|
//! | `maps` | altitude maps, their parameters and their area law |
//! | `scenes` | scenes and their solution, and steady cells for many patterns |
//! | `calibrations` | fit of a material to measurements, and trials |
//! | `designs` | search for a design, and the samples to cut next |
//! | `campaigns` | many scenes or designs as tasks for any number of processes |
//! | `origin` | files that scenes, designs and calibrations were read from, kept in their copies |
//! | `counts` | conversion of counts |
//! | `progress` | work in the thread pool, progress, Ctrl-C |
//! | `threads` | the thread pool |
//! | `output` | safe writing of files |
//! | `errors` | errors as exceptions with file, line and key |
//! | `warnings` | warnings |
//!
//! Records are passed to Python as the JSON that the command line writes, byte for byte. Arrays are NumPy arrays.

#![cfg(feature = "module")]

mod calibrations;
mod campaigns;
mod counts;
mod designs;
mod errors;
mod maps;
mod origin;
mod output;
mod progress;
mod scenes;
mod threads;
mod warnings;

use pyo3::prelude::*;

/// Compiled part of `slipgrid`; the Python part adds names and types.
#[pymodule(gil_used = true)]
mod _slipgrid {
    use super::*;

    #[pymodule_export]
    use crate::calibrations::{Calibration, Fitted, read_material};
    #[pymodule_export]
    use crate::campaigns::Campaign;
    #[pymodule_export]
    use crate::designs::{Design, Designed};
    #[pymodule_export]
    use crate::maps::{Map, restore_map};
    #[pymodule_export]
    use crate::output::{check_file, write_file, write_folder};
    #[pymodule_export]
    use crate::progress::set_cache;
    #[pymodule_export]
    use crate::scenes::{Scene, Solved, SteadyCell};
    #[pymodule_export]
    use crate::threads::{set_threads, threads};
    #[pymodule_export]
    use crate::warnings::give_warnings;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("MAX_MAP_POINTS", slipgrid::topography::MAX_POINTS)?;
        module.add("__version__", slipgrid::results::VERSION)
    }
}
