"""Scenes: friction of a given surface at given loads."""

from __future__ import annotations

import json
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _plots, _slipgrid
from ._records import Kept, Progress, Record, array, by_pressure, document, frame, table, write
from .types import SimulationRecord

if TYPE_CHECKING:
    import pandas as _pandas
    from matplotlib.axes import Axes
    from typing_extensions import Unpack

    from .types import SceneTables

Fidelity = Literal["steady", "dynamic", "reference"]
Extent = Literal["cell", "sample", "strip"]


class Scene:
    """A material, a pattern or none, and loads: friction of a given surface.

    Parameters
    ----------
    folder
        Folder from which paths in the tables start.
    fidelity, extent
        Overrule those of the table ``run``.
    **tables
        Tables of a scene file. An object may stand where the file has a path: a material, a map, a frame.

    Raises
    ------
    slipgrid.errors.InputError
        If a value is refused; the error has the key.

    Examples
    --------
    >>> import slipgrid
    >>> scene = slipgrid.Scene(
    ...     material={
    ...         "youngs_modulus_gpa": 0.38,
    ...         "density_g_cm3": 0.9,
    ...         "friction": {"static_mean": 0.30, "dynamic_mean": 0.27},
    ...         "area_law": {"pressure_mpa": [0.7, 2.6, 10.0], "factor": [1.0, 0.7, 0.3]},
    ...     },
    ...     pattern={"planform": "groove", "width_um": 130, "spacing_um": 370, "depth_um": 20},
    ...     load={"pressure_mpa": [0.65, 2.6], "speed_mm_s": 2},
    ...     fidelity="steady",
    ...     extent="cell",
    ... )
    >>> scene.simulate().ratio.round(3)
    array([0.958, 0.907])
    """

    def __init__(
        self,
        *,
        folder: str | PathLike[str] = ".",
        fidelity: Fidelity | None = None,
        extent: Extent | None = None,
        **tables: Unpack[SceneTables],
    ) -> None:
        text, objects = document(tables, folder)
        self._scene = _slipgrid.Scene(text, Path(folder) / "scene", fidelity=fidelity, extent=extent, objects=objects)

    @classmethod
    def from_toml(
        cls, text: str, folder: str | PathLike[str] = ".", *, fidelity: Fidelity | None = None, extent: Extent | None = None
    ) -> Scene:
        """A scene from the text of a scene file in ``folder``."""
        made = cls.__new__(cls)
        made._scene = _slipgrid.Scene(text, Path(folder) / "scene.toml", fidelity=fidelity, extent=extent)
        return made

    @classmethod
    def read(cls, path: str | PathLike[str], *, fidelity: Fidelity | None = None, extent: Extent | None = None) -> Scene:
        """The scene file at ``path``."""
        made = cls.__new__(cls)
        made._scene = _slipgrid.Scene(None, Path(path), fidelity=fidelity, extent=extent)
        return made

    @property
    def warnings(self) -> list[str]:
        """Warnings about the scene, one sentence each."""
        return self._scene.warnings

    def simulate(self, progress: Progress | None = None) -> SimulationResult:
        """Solves the scene: steady, dynamic or reference, as its ``run`` or ``fidelity`` says.

        Parameters
        ----------
        progress
            Called with the stage and the share that is done.

        Returns
        -------
        SimulationResult
            Arrays by load, and the record of result.json.
        """
        return SimulationResult(*self._scene.simulate(progress))

    def steady(self) -> SteadyCell:
        """The steady cell of the scene's texture, for any lengths and pressures."""
        return SteadyCell(self._scene.steady())

    def __repr__(self) -> str:
        return repr(self._scene)


class SteadyCell:
    """One period of a texture in steady sliding, for arrays of lengths and pressures.

    Lengths broadcast as those of NumPy ufuncs; pressures are the last axis of what is returned, as in :meth:`Design.predict`. Each
    distinct texture is solved once for all pressures, on all threads and without the interpreter lock. NaN where an argument is NaN
    or friction is not defined.
    """

    def __init__(self, cell: _slipgrid.SteadyCell) -> None:
        self._cell = cell

    def _solve(self, value: int, lengths_um: dict[str, ArrayLike], pressure_mpa: ArrayLike | None) -> NDArray[np.float64]:
        if pressure_mpa is None:
            pressure_mpa = self._cell.pressure_mpa
        columns, shape = by_pressure(pressure_mpa, **lengths_um)
        found: NDArray[np.float64] = self._cell.solve(columns)[:, value].reshape(shape)[()]
        return found

    def ratio(
        self, width_um: ArrayLike, spacing_um: ArrayLike, depth_um: ArrayLike, pressure_mpa: ArrayLike | None = None
    ) -> NDArray[np.float64]:
        """Dynamic friction of the texture over that of the flat surface, by the model alone.

        Parameters
        ----------
        width_um, spacing_um, depth_um
            Lengths of cavities in micrometres, of any shapes that broadcast.
        pressure_mpa
            Nominal pressures in MPa, shape (pressures,), or one number, which adds no axis; the loads of the scene when absent.

        Returns
        -------
        ndarray
            Ratios in the common shape of the lengths, with a last axis (pressures,).
        """
        return self._solve(0, {"width_um": width_um, "spacing_um": spacing_um, "depth_um": depth_um}, pressure_mpa)

    def mu(
        self, width_um: ArrayLike, spacing_um: ArrayLike, depth_um: ArrayLike, pressure_mpa: ArrayLike | None = None
    ) -> NDArray[np.float64]:
        """Dynamic friction coefficients; arguments and shapes as for :meth:`ratio`."""
        return self._solve(1, {"width_um": width_um, "spacing_um": spacing_um, "depth_um": depth_um}, pressure_mpa)

    def peak_pressure(
        self, width_um: ArrayLike, spacing_um: ArrayLike, depth_um: ArrayLike, pressure_mpa: ArrayLike | None = None
    ) -> NDArray[np.float64]:
        """Largest pressure on a contact block in MPa; arguments and shapes as for :meth:`ratio`."""
        return self._solve(2, {"width_um": width_um, "spacing_um": spacing_um, "depth_um": depth_um}, pressure_mpa)

    def __repr__(self) -> str:
        return f"<SteadyCell at {', '.join(f'{own:g}' for own in self._cell.pressure_mpa)} MPa>"


class SimulationTimes(Record):
    """Seconds and threads, as in timings.json."""

    wall_s: float
    threads: int


class SimulationResult(SimulationRecord):
    """What a scene does; fields as in result.json of ``slipgrid simulate``. Arrays have the shape (loads,)."""

    def __init__(
        self, records: list[str], told: tuple[str, list[str], list[Path]], solved: _slipgrid.Solved
    ) -> None:
        super().__init__(json.loads(records[0]))
        self._times = SimulationTimes(json.loads(records[1]))
        self._kept = Kept(*told, solved)

    @property
    def pressure_mpa(self) -> NDArray[np.float64]:
        """Nominal pressures in MPa, shape (loads,)."""
        return array(self["results"], "pressure_mpa")

    @property
    def mu_dynamic(self) -> NDArray[np.float64]:
        """Dynamic friction coefficients, shape (loads,); NaN where there is none."""
        return array(self["results"], "mu_dynamic")

    @property
    def ratio(self) -> NDArray[np.float64]:
        """Dynamic friction over that of the flat surface, shape (loads,); NaN where there is none."""
        return array(self["results"], "ratio")

    @property
    def warnings(self) -> list[str]:
        """Warnings about the scene and its results, one sentence each."""
        return list(self._kept.warnings)

    @property
    def times(self) -> SimulationTimes:
        """Seconds and threads, as in timings.json."""
        return self._times

    def frame(self) -> _pandas.DataFrame:
        """One row a load."""
        return frame(self["results"])

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draws the ratio against pressure, or dynamic friction of a flat surface, on the axes ``ax`` of Matplotlib or new ones."""
        return _plots.simulation(self, ax)

    def export(self, folder: str | PathLike[str]) -> list[Path]:
        """Writes what ``slipgrid simulate -o`` writes. Inputs, and files that slipgrid did not write, are not replaced."""
        return write(self._kept.files(), folder, self._kept.inputs)

    def __str__(self) -> str:
        return self._kept.text

    def __repr__(self) -> str:
        values = ", ".join(f"{own:.4g}" for own in (self.mu_dynamic if np.isnan(self.ratio).all() else self.ratio))
        return f"<SimulationResult, {self.fidelity}: {'friction' if np.isnan(self.ratio).all() else 'ratio'} {values}>"

    def _repr_html_(self) -> str:
        return table(self["results"], ["pressure_mpa", "mu_dynamic", "mu_flat", "ratio", "peak_pressure_mpa", "status"])
