"""Designs: the search for a texture, predictions, and the samples to cut next."""

from __future__ import annotations

import json
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _plots, _slipgrid, errors
from ._records import Kept, Progress, Record, document, frame, rows, table, triples, write
from .types import DesignRecord, NextRecord

if TYPE_CHECKING:
    import pandas as _pandas
    from matplotlib.axes import Axes
    from typing_extensions import Unpack

    from .types import DesignTables

#: Formats of :meth:`DesignResult.drawing`.
Drawing = Literal["dxf", "svg", "csv", "process", "plt", "gcode", "corners", "hatch", "png", "stl"]


@dataclass(frozen=True, eq=False)
class Prediction:
    """Predictions of cut samples. Arrays have the shape of the textures; those by pressure a last axis (pressures,). NaN stands where
    a length is NaN, and where the model has no answer. Values are those of the first condition of a task, the chance that of all."""

    #: Nominal pressures in MPa, shape (pressures,).
    pressure_mpa: NDArray[np.float64]
    #: Lengths of the cavities in micrometres.
    width_um: NDArray[np.float64]
    spacing_um: NDArray[np.float64]
    depth_um: NDArray[np.float64]
    #: Median over samples, by pressure.
    median: NDArray[np.float64]
    #: Ends of the interval that holds 95 % of samples, by pressure.
    low_95: NDArray[np.float64]
    high_95: NDArray[np.float64]
    #: Chance that a sample is on target at all pressures; NaN where the target accepts everything.
    chance: NDArray[np.float64]
    #: Largest local pressure at any load, in MPa.
    peak_pressure_mpa: NDArray[np.float64]
    #: Smallest height of a cavity's ceiling under load, in micrometres.
    clearance_um: NDArray[np.float64]
    #: Share of the face that is cavity.
    areal_density: NDArray[np.float64]
    #: Seconds under the laser; NaN where its speed is not known.
    laser_s: NDArray[np.float64]
    #: Whether the values are of the "ratio" or of "mu_dynamic".
    quantity: str
    #: Error of the interpolated medians: median and maximum over random textures.
    median_error: float
    max_error: float
    #: Warnings about the task and its material, one sentence each.
    warnings: list[str]

    def __getitem__(self, place: Any) -> Prediction:
        """The predictions of some of the textures, by any index of their arrays."""
        shared = {"pressure_mpa", "quantity", "median_error", "max_error", "warnings"}
        own = {name: value if name in shared else value[place] for name, value in vars(self).items()}
        return Prediction(**own)

    def frame(self) -> _pandas.DataFrame:
        """One row a texture and pressure."""
        return frame(self._rows())

    def _rows(self, max_count: int | None = None) -> list[dict[str, float]]:
        by_pressure = ("median", "low_95", "high_95")
        of_texture = ("width_um", "spacing_um", "depth_um", "chance", "peak_pressure_mpa", "areal_density", "laser_s")
        places = list(np.ndindex(self.median.shape))[:max_count]
        return [
            {
                **{name: float(getattr(self, name)[place[:-1]]) for name in of_texture},
                "pressure_mpa": float(self.pressure_mpa[place[-1]]),
                **{name: float(getattr(self, name)[place]) for name in by_pressure},
            }
            for place in places
        ]

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draws what is expected of one texture against pressure on the axes ``ax`` of Matplotlib or new ones."""
        return _plots.prediction(self, ax)

    def __repr__(self) -> str:
        counts = [(self.chance.size, "texture"), (self.pressure_mpa.size, "pressure")]
        textures, pressures = (f"{count} {noun}{'' if count == 1 else 's'}" for count, noun in counts)
        return f"<Prediction of {self.quantity}: {textures} at {pressures}>"

    def _repr_html_(self) -> str:
        names = ["width_um", "spacing_um", "depth_um", "pressure_mpa", "median", "low_95", "high_95", "chance"]
        return table(self._rows(50), names, repr(self))


class Design:
    """A design task: which friction, of which material, and what may be cut.

    Parameters
    ----------
    folder
        Folder from which paths in the tables start.
    **tables
        Tables of a design file: ``material``, ``target``, ``bounds``, ``specimen`` and others. A :class:`Material` or a
        :class:`Calibration` may stand as ``material``.

    Raises
    ------
    slipgrid.errors.InputError
        If a value is refused; the error has the key.

    Examples
    --------
    >>> import slipgrid
    >>> design = slipgrid.Design(
    ...     material={
    ...         "youngs_modulus_gpa": 0.38,
    ...         "density_g_cm3": 0.9,
    ...         "friction": {"static_mean": 0.30, "dynamic_mean": 0.27},
    ...         "area_law": {"pressure_mpa": [0.7, 2.6, 10.0], "factor": [1.0, 0.7, 0.3]},
    ...     },
    ...     target={"quantity": "ratio", "pressure_mpa": 2.6, "value": 0.88, "tolerance": 0.02},
    ...     bounds={"width_um": [40, 100], "spacing_um": [40, 200], "depth_um": 10},
    ...     specimen={"shape": "disc", "diameter_mm": 2},
    ...     sample={"layer_um": 100, "block_um": 10},
    ... )
    >>> design.predict([50.0, 80.0], 120.0, 10.0).median.shape
    (2, 1)
    """

    def __init__(self, *, folder: str | PathLike[str] = ".", **tables: Unpack[DesignTables]) -> None:
        text, objects = document(tables, folder)
        self._design = _slipgrid.Design(text, Path(folder) / "design", objects=objects)

    @classmethod
    def from_toml(cls, text: str, folder: str | PathLike[str] = ".") -> Design:
        """A task from the text of a design file in ``folder``."""
        made = cls.__new__(cls)
        made._design = _slipgrid.Design(text, Path(folder) / "design.toml")
        return made

    @classmethod
    def read(cls, path: str | PathLike[str]) -> Design:
        """The design file at ``path``."""
        made = cls.__new__(cls)
        made._design = _slipgrid.Design(None, Path(path))
        return made

    @property
    def warnings(self) -> list[str]:
        """Warnings about the task, one sentence each."""
        return self._design.warnings

    def optimize(self, progress: Progress | None = None) -> DesignResult:
        """Searches the texture, confirms it and explains; a calibration that the task names is fitted once.

        Parameters
        ----------
        progress
            Called with the stage and the share that is done.

        Raises
        ------
        slipgrid.errors.ComputationError
            If no texture within the bounds can be computed.
        """
        return DesignResult(*self._design.optimize(progress))

    def predict(
        self, width_um: ArrayLike, spacing_um: ArrayLike, depth_um: ArrayLike, *, progress: Progress | None = None
    ) -> Prediction:
        """Predicts cut samples of any textures within the bounds, from the table of the bounds.

        The first call computes the table, as the page with sliders does (:meth:`explore`); further calls interpolate in it.

        Parameters
        ----------
        width_um, spacing_um, depth_um
            Lengths of cavities in micrometres, of any shapes that broadcast.
        progress
            Called with the stage and the share that is done.

        Returns
        -------
        Prediction
            Arrays of the common shape, those by pressure with a last axis (pressures,).

        Raises
        ------
        slipgrid.errors.InputError
            If a length lies beyond the bounds.
        """
        columns, shape = rows(width_um=width_um, spacing_um=spacing_um, depth_um=depth_um)
        values, pressure_mpa, quantity, (median_error, max_error), warnings = self._design.predict(columns, progress)
        count = pressure_mpa.size
        median, low_95, high_95 = (
            values[:, place * count : (place + 1) * count].reshape(*shape, count) for place in range(3)
        )
        names = ("chance", "peak_pressure_mpa", "clearance_um", "areal_density", "laser_s")
        others = {name: values[:, 3 * count + place].reshape(shape) for place, name in enumerate(names)}
        lengths = {name: columns[:, place].reshape(shape) for place, name in enumerate(("width_um", "spacing_um", "depth_um"))}
        return Prediction(
            pressure_mpa=pressure_mpa,
            **lengths,
            median=median,
            low_95=low_95,
            high_95=high_95,
            **others,
            quantity=quantity,
            median_error=median_error,
            max_error=max_error,
            warnings=warnings,
        )

    def explore(self, path: str | PathLike[str], progress: Progress | None = None) -> Path:
        """Writes the page with sliders of ``slipgrid explore``: what any design within the bounds does, before a search. A file that
        slipgrid did not write is not replaced."""
        path = Path(path)
        _slipgrid.check_file(path, self._design.inputs)
        page = self._design.explore_html(progress).encode()
        _slipgrid.write_file(page, path, self._design.inputs)
        return path

    def next(
        self,
        count: int = 1,
        candidates_um: ArrayLike = (),
        progress: Progress | None = None,
        *,
        one_disc: bool = False,
        learn: bool = False,
    ) -> NextSamples:
        """Chooses the samples to cut next by what trials say.

        Parameters
        ----------
        count
            Number of samples, 1 to 20; 2 to 12 on one disc.
        candidates_um
            Textures whose chance is asked for as well: rows of width, spacing and depth, shape (textures, 3).
        progress
            Called with the stage and the share that is done.
        one_disc
            Whether the samples are sectors of one disc, each of which is measured alone.
        learn
            Whether to choose the disc of two sectors that teaches most about which mechanism the model lacks, in place of ``count``
            samples that are likely on target. Drawings of either disc and its ``trials.toml`` are written by the command line,
            ``slipgrid next --one-disc`` or ``--learn``.

        Raises
        ------
        ValueError
            If ``count`` is not accepted, or if ``learn`` stands beside it, ``candidates_um`` or ``one_disc``.
        TimeoutError
            If ``max_seconds`` of the design was spent before a texture was found.
        slipgrid.errors.ComputationError
            If no textures that keep all limits fit on the sectors of one disc.
        """
        own = triples("candidates_um", candidates_um)
        return NextSamples(*self._design.next_samples(count, own, progress, one_disc, learn))

    def __repr__(self) -> str:
        return repr(self._design)


class Timings(Record):
    """Seconds of the stages of a search."""

    material: float
    table: float
    search: float
    confirm: float
    trade_offs: float
    explorer: float
    export: float


class DesignTimes(Record):
    """Seconds and threads, as in timings.json."""

    wall_s: float
    threads: int
    timings_s: Timings


class DesignResult(DesignRecord):
    """A design that was found; fields as in result.json of ``slipgrid optimize``."""

    def __init__(
        self, records: list[str], told: tuple[str, list[str], list[Path]], designed: _slipgrid.Designed
    ) -> None:
        super().__init__(json.loads(records[0]))
        self._times = DesignTimes(json.loads(records[1]))
        self._kept = Kept(*told, designed)

    @property
    def headline(self) -> str:
        """The first line that ``slipgrid optimize`` prints: what to do, and the chance that a cut sample is on target."""
        return self._kept.text.splitlines()[0]

    @property
    def warnings(self) -> list[str]:
        """Warnings about the task, its material and the design found, one sentence each."""
        return list(self._kept.warnings)

    @property
    def times(self) -> DesignTimes:
        """Seconds of every stage, as in timings.json."""
        return self._times

    def frame(self) -> _pandas.DataFrame:
        """One row a load: what is accepted, what is expected of a cut sample, and what the model alone says."""
        return frame(self._rows())

    def _rows(self) -> list[dict[str, object]]:
        return [
            {**expected, "model_alone": modelled["ratio"], "model_alone_std": modelled["std"]}
            for expected, modelled in zip(self["expected"], self["modelled"], strict=True)
        ]

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draws what is expected of a cut sample, and what is accepted, on the axes ``ax`` of Matplotlib or new ones."""
        return _plots.design(self, ax)

    def export(self, folder: str | PathLike[str]) -> list[Path]:
        """Writes what ``slipgrid optimize -o`` writes: the files of the laser, tables, pictures and report.html. Inputs, and files that
        slipgrid did not write, are not replaced: :class:`slipgrid.errors.InputError` names them."""
        return write(self._kept.files(), folder, self._kept.inputs)

    def drawing(self, format: Drawing) -> bytes:
        """The pattern as a file of the laser, in one of its formats."""
        if self._kept.compiled is not None:
            return bytes(self._kept.compiled.drawing(format)[1])
        names = {"dxf": "pattern.dxf", "svg": "pattern.svg", "csv": "pattern.csv", "process": "process.toml"}
        if format not in names:
            raise errors.ComputationError(f"a copy holds {', '.join(names)}: draw {format!r} with the result that was copied")
        return dict(self._kept.files())[names[format]]

    def report_html(self) -> str:
        """The page report.html, which needs no other file."""
        return dict(self._kept.files())["report.html"].decode()

    def __str__(self) -> str:
        return self._kept.text

    def __repr__(self) -> str:
        return f"<DesignResult {self.headline}>"

    def _repr_html_(self) -> str:
        names = ["pressure_mpa", "target_low", "target_high", "median", "low_95", "high_95", "model_alone"]
        lengths = "width {width_um:g} µm, spacing {spacing_um:g} µm, depth {depth_um:g} µm".format(**self["design"])
        return table(self._rows(), names, f"{self.headline}; {lengths}")


class NextSamples(NextRecord):
    """The samples to cut next; fields as in ``slipgrid next --json``."""

    def __init__(self, record: str, told: tuple[str, list[str], list[Path]]) -> None:
        super().__init__(json.loads(record))
        self._kept = Kept(*told)

    @property
    def warnings(self) -> list[str]:  # type: ignore[override]
        """Warnings about the task, its material and the samples, one sentence each."""
        return list(self._kept.warnings)

    def frame(self) -> _pandas.DataFrame:
        """One row a sample: those to cut, those asked for, and others."""
        return frame(self._rows())

    def _rows(self) -> list[dict[str, object]]:
        return [{"which": which, **own["design"], **own} for which in ("samples", "own", "others") for own in self[which]]

    def __str__(self) -> str:
        return self._kept.text

    def __repr__(self) -> str:
        chances = ", ".join("-" if own.chance is None else f"{own.chance:.0%}" for own in self.samples)
        return f"<NextSamples: {len(self.samples)} to cut, chances {chances}>"

    def _repr_html_(self) -> str:
        return table(self._rows(), ["which", "width_um", "spacing_um", "depth_um", "chance", "information_bits"])
