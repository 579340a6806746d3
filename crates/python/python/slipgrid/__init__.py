"""Laser-textured surfaces for a target dry friction.

A design file, a search that is confirmed, the files of a laser::

    import slipgrid

    design = slipgrid.Design.read("designs/ldpe-lower-friction.toml")
    found = design.optimize(progress=lambda stage, share: print(f"{stage} {share:.0%}", end="\\r"))
    print(found.headline, found.design.width_um)
    found.export("out")

Arrays of textures, by a material::

    material = slipgrid.Material.read("tpu.toml")
    ratio = material.ratio(width_um, spacing_um, depth_um, pressure_mpa)   # pressures are the last axis

Units stand in names: ``width_um``, ``pressure_mpa``. Fields are those of the files and of result.json. Results are equal to those of
the command line to the last bit, with any number of threads. Ctrl-C ends a computation. Input that is refused raises
:class:`slipgrid.errors.InputError` with file, line and key. Doubtful input and results give a
:class:`slipgrid.errors.SlipgridWarning` and are listed in ``warnings`` of results. Paths start from the current folder at the time of
reading.
"""

from __future__ import annotations

import tempfile
from os import PathLike
from pathlib import Path

from . import _slipgrid, campaign, errors, types
from ._designs import Design, DesignResult, NextSamples, Prediction
from ._maps import AreaLaw, Map, Surface
from ._materials import Calibration, FittedMaterial, Material, Trials
from ._records import Record
from ._scenes import Scene, SimulationResult, SteadyCell
from ._slipgrid import __version__, set_threads, threads

__all__ = [
    "AreaLaw",
    "Calibration",
    "Design",
    "DesignResult",
    "FittedMaterial",
    "Map",
    "Material",
    "NextSamples",
    "Prediction",
    "Record",
    "Scene",
    "SimulationResult",
    "SteadyCell",
    "Surface",
    "Trials",
    "__version__",
    "campaign",
    "errors",
    "set_cache",
    "set_threads",
    "threads",
    "types",
]


def set_cache(folder: str | PathLike[str] | None) -> None:
    """Sets where fits, runs and tables are kept, which are then not computed again; results do not depend on it.

    Parameters
    ----------
    folder
        Folder of the cache. ``None`` keeps nothing, as the flag ``--no-cache``. Until the first call it is the folder of the command
        line: that in the environment variable ``SLIPGRID_CACHE``, or ``slipgrid`` in the system's cache folder.

    Raises
    ------
    OSError
        If the folder cannot be made or written to.
    """
    folder = None if folder is None else Path(folder)
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
        # A computation never fails because of its cache, and would not say that nothing is kept.
        with tempfile.TemporaryFile(dir=folder):
            pass
    _slipgrid.set_cache(_slipgrid.__file__, folder is not None, folder)


_slipgrid.set_cache(_slipgrid.__file__, True, None)
