//! Python bindings of the slipgrid libraries.
//!
//! | module | binds |
//! |---|---|
//! | `maps` | altitude maps, their parameters and their area law |
//! | `scenes` | scenes and their solution, and steady cells for many patterns |
//! | `calibrations` | fit of a material to measurements, and trials |
//! | `designs` | search for a design, and the samples to cut next |
//! | `campaigns` | many scenes or designs as tasks for any number of processes |
//! | `copied` | files that scenes, designs and calibrations were read from, kept in their copies |
//! | `given` | conversion of numeric arguments |
//! | `watched` | work in the thread pool, progress, Ctrl-C |
//! | `threads` | the thread pool |
//! | `written` | safe writing of files |
//! | `refused` | errors as exceptions with file, line and key |
//! | `told` | warnings |
//!
//! Records are passed to Python as the JSON that the command line writes, byte for byte. Arrays are NumPy arrays.

#![cfg(feature = "module")]

mod calibrations;
mod campaigns;
mod copied;
mod designs;
mod given;
mod maps;
mod refused;
mod scenes;
mod threads;
mod told;
mod watched;
mod written;

use pyo3::prelude::*;

/// Compiled part of `slipgrid`; the Python part adds names and types.
#[pymodule(gil_used = true)]
mod _slipgrid {
    use super::*;

    #[pymodule_export]
    use crate::calibrations::{Calibration, Fitted};
    #[pymodule_export]
    use crate::campaigns::Campaign;
    #[pymodule_export]
    use crate::designs::{Design, Designed, NextSamples};
    #[pymodule_export]
    use crate::maps::{Map, map_of};
    #[pymodule_export]
    use crate::scenes::{Scene, Solved, SteadyCell};
    #[pymodule_export]
    use crate::threads::{set_threads, threads};
    #[pymodule_export]
    use crate::written::{check_file, write_file, write_folder};

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("MAX_MAP_POINTS", slipgrid::topography::MAX_POINTS)?;
        module.add("__version__", slipgrid::results::VERSION)
    }
}
