"""Calibrations, materials and trials."""

from __future__ import annotations

import html
import json
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, TypedDict, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _plots, _slipgrid
from ._designs import Design, Prediction
from ._records import Kept, Progress, by_pressure, document, frame, real, rows, table, write
from ._scenes import Scene
from .types import FitRecord, TrialsRecord

if TYPE_CHECKING:
    import pandas as _pandas
    from matplotlib.axes import Axes
    from typing_extensions import Unpack

    from .types import (
        CalibrationTables,
        ConditionTable,
        DesignPatternTable,
        DesignTables,
        LaserTable,
        SampleTable,
        SpecimenTable,
        TolerancesTable,
    )


class CellOptions(TypedDict, total=False):
    """What a steady cell of a material may be told beside lengths and pressures; tables as in a scene file."""

    condition: ConditionTable
    pattern: DesignPatternTable
    sample: SampleTable


class PredictionOptions(CellOptions, total=False):
    """What a prediction of cut samples may be told beside lengths and pressures; tables as in a design file."""

    specimen: SpecimenTable
    tolerances: TolerancesTable
    laser: LaserTable


class Calibration:
    """Measurements on samples, and the surface that they were made on.

    Parameters
    ----------
    folder
        Folder from which paths in the tables start.
    **tables
        Tables of a calibration file. A :class:`Map` may stand where the file names a map, a pandas frame where it names a table
        or traces.

    Raises
    ------
    slipgrid.errors.InputError
        If a value is refused; the error has the key.
    """

    def __init__(self, *, folder: str | PathLike[str] = ".", **tables: Unpack[CalibrationTables]) -> None:
        text, objects = document(tables, folder)
        self._calibration = _slipgrid.Calibration(text, Path(folder) / "calibration", objects=objects)

    @classmethod
    def from_toml(cls, text: str, folder: str | PathLike[str] = ".") -> Calibration:
        """A calibration from the text of a calibration file in ``folder``."""
        made = cls.__new__(cls)
        made._calibration = _slipgrid.Calibration(text, Path(folder) / "calibration.toml")
        return made

    @classmethod
    def read(cls, path: str | PathLike[str]) -> Calibration:
        """The calibration file at ``path``."""
        made = cls.__new__(cls)
        made._calibration = _slipgrid.Calibration(None, Path(path))
        return made

    @property
    def warnings(self) -> list[str]:
        """Warnings about the calibration, one sentence each."""
        return self._calibration.warnings

    def fit(self, progress: Progress | None = None) -> FittedMaterial:
        """Fits local coefficients to the flat samples, and learns from trials.

        Parameters
        ----------
        progress
            Called with the stage and the share that is done.
        """
        return FittedMaterial(*self._calibration.fit(progress))

    def trials(self, progress: Progress | None = None) -> Trials:
        """Compares what was predicted of trial samples with what was measured."""
        record, text = self._calibration.trials(progress)
        return Trials(json.loads(record), text)

    def _as_files(self, number: int) -> tuple[str, dict[str, bytes]]:
        text, path, _, (_, files) = self._calibration.__reduce__()[1]
        folder = Path.cwd()
        contents = {fspath(folder / name): content for name, content in files.items()}
        name = str(folder / path)
        return name, {**contents, name: text.encode()}

    def __repr__(self) -> str:
        return repr(self._calibration)


class Material:
    """A material: elastic constants, local friction, area law, and what trials taught. Scenes and designs take it as ``material``.

    Examples
    --------
    >>> import numpy as np, slipgrid
    >>> material = slipgrid.Material.from_toml('''
    ...     youngs_modulus_gpa = 0.38
    ...     density_g_cm3 = 0.9
    ...     friction = { static_mean = 0.30, dynamic_mean = 0.27 }
    ...     area_law = { pressure_mpa = [0.7, 2.6, 10.0], factor = [1.0, 0.7, 0.3] }
    ... ''')
    >>> widths_um = np.array([60.0, 130.0])
    >>> material.ratio(widths_um, 370.0, 20.0, [0.65, 2.6]).round(3)
    array([[0.984, 0.958],
           [0.958, 0.907]])
    """

    def __init__(self, text: str, path: str | PathLike[str], warnings: list[str]) -> None:
        self._text, self._path, self._warnings = text, str(Path(path)), warnings

    @classmethod
    def read(cls, path: str | PathLike[str]) -> Material:
        """The material file at ``path``, as ``slipgrid calibrate`` or :meth:`save` writes it."""
        text, warnings = _slipgrid.read_material(Path(path))
        _slipgrid.give_warnings(warnings)
        return Material(text, path, warnings)

    @classmethod
    def from_toml(cls, text: str) -> Material:
        """A material from the text of a material file."""
        _, warnings = _slipgrid.read_material("material.toml", text)
        _slipgrid.give_warnings(warnings)
        return Material(text, "material.toml", warnings)

    @property
    def toml(self) -> str:
        """Text of the material file, without ``[made_from]`` for a fitted material: that belongs to a file at its place."""
        return self._text

    @property
    def warnings(self) -> list[str]:
        """Warnings about the material, one sentence each."""
        return list(self._warnings)

    def _as_files(self, number: int) -> tuple[str, dict[str, bytes]]:
        name = f"<material {number}>.toml"
        return name, {name: self.toml.encode()}

    def _steady(self, lengths: NDArray[np.float64], options: CellOptions) -> _slipgrid.SteadyCell:
        known = lengths[~np.isnan(lengths).any(axis=1)]
        first = known[0] if len(known) else np.array([100.0, 100.0, 10.0, 1.0])
        pattern = {"planform": "groove", **options.get("pattern", {})}
        pattern |= dict(zip(["width_um", "spacing_um", "depth_um"], first[:3].tolist()))
        tables = {**options, "pattern": pattern, "material": self}
        # The speed matters to runs in time alone.
        speed = {} if "condition" in options else {"speed_mm_s": 1e-3}
        tables["load"] = {"pressure_mpa": float(first[3]), **speed}
        text, objects = document(tables, ".")
        return _slipgrid.Scene(text, "material", fidelity="steady", extent="cell", objects=objects).steady()

    def _solve(self, value: int, arguments: dict[str, ArrayLike], options: CellOptions) -> NDArray[np.float64]:
        columns, shape = by_pressure(**arguments)
        found: NDArray[np.float64] = self._steady(columns, options).solve(columns)[:, value].reshape(shape)[()]
        return found

    def ratio(
        self,
        width_um: ArrayLike,
        spacing_um: ArrayLike,
        depth_um: ArrayLike,
        pressure_mpa: ArrayLike,
        **options: Unpack[CellOptions],
    ) -> NDArray[np.float64]:
        """Dynamic friction of textures over that of the flat surface, by the model alone.

        The lengths broadcast as those of NumPy ufuncs; pressures are the last axis, as in :meth:`predict`. Each distinct texture is
        solved once for all pressures, as one period in steady sliding, on all threads and without the interpreter lock.

        Parameters
        ----------
        width_um, spacing_um, depth_um
            Lengths of cavities in micrometres, of any shapes that broadcast.
        pressure_mpa
            Nominal pressures in MPa, shape (pressures,), or one number, which adds no axis.
        **options
            Tables of a scene file: ``condition`` for a material with coefficients per condition, ``pattern`` without its lengths
            (grooves by default), ``sample``.

        Returns
        -------
        ndarray
            Ratios in the common shape of the lengths, with a last axis (pressures,); NaN where an argument is NaN.

        Raises
        ------
        slipgrid.errors.InputError
            If a length or a pressure is refused.
        """
        return self._solve(0, _arguments(width_um, spacing_um, depth_um, pressure_mpa), options)

    def mu(
        self,
        width_um: ArrayLike,
        spacing_um: ArrayLike,
        depth_um: ArrayLike,
        pressure_mpa: ArrayLike,
        **options: Unpack[CellOptions],
    ) -> NDArray[np.float64]:
        """Dynamic friction coefficients of textures, by the model alone; arguments and shapes as for :meth:`ratio`."""
        return self._solve(1, _arguments(width_um, spacing_um, depth_um, pressure_mpa), options)

    def peak_pressure(
        self,
        width_um: ArrayLike,
        spacing_um: ArrayLike,
        depth_um: ArrayLike,
        pressure_mpa: ArrayLike,
        **options: Unpack[CellOptions],
    ) -> NDArray[np.float64]:
        """Largest pressures on a contact block in MPa; arguments and shapes as for :meth:`ratio`."""
        return self._solve(2, _arguments(width_um, spacing_um, depth_um, pressure_mpa), options)

    def predict(
        self,
        width_um: ArrayLike,
        spacing_um: ArrayLike,
        depth_um: ArrayLike,
        pressure_mpa: ArrayLike,
        *,
        band: tuple[float | None, float | None] = (None, None),
        progress: Progress | None = None,
        **options: Unpack[PredictionOptions],
    ) -> Prediction:
        """Predicts cut samples: the model corrected by trials, with the interval of samples and the chance of a band.

        The lengths broadcast as those of NumPy ufuncs. The predictions come from the table of their bounds, as those of
        :meth:`Design.predict`, which serves any number of calls with one table.

        Parameters
        ----------
        width_um, spacing_um, depth_um
            Lengths of cavities in micrometres, of any shapes that broadcast.
        pressure_mpa
            Nominal pressures in MPa, shape (pressures,); one number is taken as one of them.
        band
            Lowest and highest accepted ratio, the same at all pressures; ``None`` where there is no end.
        progress
            Called with the stage and the share that is done.
        **options
            Tables of a design file: ``condition``, ``pattern``, ``sample``, ``specimen`` (a disc of 10 mm by default),
            ``tolerances`` (none by default), ``laser``.

        Returns
        -------
        Prediction
            Arrays of the common shape, those by pressure with a last axis (pressures,).
        """
        pressures = np.atleast_1d(real("pressure_mpa", pressure_mpa))
        ends = {name: end for name, end in zip(("lowest", "highest"), band) if end is not None}
        columns, shape = rows(width_um=width_um, spacing_um=spacing_um, depth_um=depth_um)
        known = columns[~np.isnan(columns).any(axis=1)]
        if not len(known):
            raise ValueError("width_um, spacing_um and depth_um have no texture: expected at least one without NaN")
        bounds = [own[0] if own[0] == own[1] else own for own in zip(known.min(axis=0).tolist(), known.max(axis=0).tolist())]
        tables: dict[str, object] = {
            "specimen": {"shape": "disc", "diameter_mm": 10.0},
            **options,
            "material": self,
            "target": {"quantity": "ratio", "pressure_mpa": pressures, **(ends or {"goal": "lowest"})},
            "bounds": dict(zip(["width_um", "spacing_um", "depth_um"], bounds)),
        }
        return Design(**cast("DesignTables", tables)).predict(width_um, spacing_um, depth_um, progress=progress)

    def save(self, path: str | PathLike[str]) -> Path:
        """Writes the material file at ``path``. A file that slipgrid did not write is not replaced."""
        _slipgrid.write_file(self.toml.encode(), Path(path), [])
        return Path(path)

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self._path}>"

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(str(self)[:20_000])}</pre>"

    def __str__(self) -> str:
        return self.toml


def _arguments(width_um: ArrayLike, spacing_um: ArrayLike, depth_um: ArrayLike, pressure_mpa: ArrayLike) -> dict[str, ArrayLike]:
    return {"width_um": width_um, "spacing_um": spacing_um, "depth_um": depth_um, "pressure_mpa": pressure_mpa}


class FittedMaterial(Material):
    """A material that was fitted to measurements."""

    def __init__(
        self, records: list[str], told: tuple[str, list[str], list[Path]], fitted: _slipgrid.Fitted
    ) -> None:
        self._fit, toml = records
        self._kept = Kept(*told, fitted)
        super().__init__(toml, "fitted", self._kept.warnings)

    @property
    def fit(self) -> FitRecord:
        """Coefficients, covariance and residuals."""
        return FitRecord(json.loads(self._fit))

    def save(self, path: str | PathLike[str]) -> Path:
        """Writes the material file at ``path``, with the name of the calibration file that it was made from. A file that slipgrid
        did not write is not replaced."""
        path = Path(path)
        compiled = self._kept.compiled
        text = self.toml if compiled is None else compiled.material_toml(path)
        _slipgrid.write_file(text.encode(), path, self._kept.inputs)
        return path

    def export(self, folder: str | PathLike[str]) -> list[Path]:
        """Writes what ``slipgrid calibrate --report`` writes; nothing is replaced that slipgrid did not write."""
        return write(self._kept.files(), folder, self._kept.inputs)

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draws the fitted parameters with their 95 % intervals on the axes ``ax`` of Matplotlib or new ones."""
        return _plots.fit(self, ax)

    def __str__(self) -> str:
        return self._kept.text


class Trials(TrialsRecord):
    """The ledger of trials; fields as in ``slipgrid trials --json``."""

    def __init__(self, fields: dict[str, object], text: str) -> None:
        super().__init__(fields)
        self._words = text

    def frame(self) -> _pandas.DataFrame:
        """One row a measured ratio, with the trial's name."""
        return frame(self._rows())

    def _rows(self) -> list[dict[str, object]]:
        return [{"trial": trial["name"], **own} for trial in self["trials"] for own in trial["measured"]]

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draws predicted against measured ratios on the axes ``ax`` of Matplotlib or new ones."""
        return _plots.trials(self, ax)

    def __str__(self) -> str:
        return self._words

    def __repr__(self) -> str:
        return f"<Trials of {self.name!r}: {len(self.trials)} measured>"

    def _repr_html_(self) -> str:
        return table(self._rows(), ["trial", "pressure_mpa", "speed_mm_s", "humidity_pct", "measured", "modelled"], self.name)
