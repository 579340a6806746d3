//! Python bindings of slipgrid: the libraries, not the command line.
//!
//! | module | binds |
//! |---|---|
//! | `maps` | altitude maps, their parameters and their area law |
//! | `scenes` | scenes, solved, and steady cells asked for one pattern after the other |
//! | `calibrations` | measurements to a material, and what trials say |
//! | `designs` | the main job, and the samples to cut next |
//! | `campaigns` | many scenes or designs as tasks for any number of processes |
//! | `copied` | what scenes, designs and calibrations were read from, which travels with their copies |
//! | `given` | numbers that arguments give |
//! | `watched` | work in the pool, progress, Ctrl-C |
//! | `threads` | the pool that work is done in |
//! | `written` | files, where nothing is lost |
//! | `refused` | errors as exceptions with file, line and key |
//! | `told` | warnings |
//!
//! Records cross the border as the JSON that the command line writes: the same bytes. Arrays are NumPy's.

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

/// What `slipgrid` is made of; its Python part gives it names and types.
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
