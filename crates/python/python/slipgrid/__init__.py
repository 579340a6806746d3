"""Laser-textured surfaces for a target dry friction.

A design file, a search that is confirmed in time, the files of a laser::

    import slipgrid

    design = slipgrid.Design.read("designs/ldpe-lower-friction.toml")
    found = design.optimize(progress=lambda stage, share: print(f"{stage} {share:.0%}", end="\\r"))
    print(found.headline, found.design.width_um)
    found.export("out")

Units stand in names: ``width_um``, ``pressure_mpa``. Fields are those of the files and of result.json. Results are the command
line's to the last bit, with any number of threads. Ctrl-C ends what is computed; what is refused raises
:class:`slipgrid.errors.InputError` with file, line and key. What is doubtful is warned of
(:class:`slipgrid.errors.SlipgridWarning`) and stands in ``warnings`` of results. Paths count from where the process is when something is read, wherever it
goes afterwards.
"""

from __future__ import annotations

import html as _html
import json as _json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _slipgrid, campaign, errors
from ._records import Kept, Record, array, floats, frame, heights, pandas, table, toml, triples, warn, write
from ._slipgrid import SteadyCell, __version__, set_threads, threads

if TYPE_CHECKING:
    import pandas as _pandas

__all__ = [
    "AreaLaw",
    "Calibration",
    "Design",
    "DesignResult",
    "Map",
    "Material",
    "NextSamples",
    "Record",
    "Scene",
    "SimulationResult",
    "SteadyCell",
    "Surface",
    "Trials",
    "__version__",
    "campaign",
    "errors",
    "set_threads",
    "threads",
]

#: Told of the stage that runs and of the share of it that is done, 0 to 1, some times a second.
Progress = Callable[[str, float], object]
#: A path.
PathLike = Union[str, Path]


class Map:
    """An altitude map: heights in metres, missing points NaN or masked.

    Rows are the lines of a file, as ``numpy.loadtxt`` reads them: x runs along a row, from column to column, y from row to row. The
    face slides along x where a map is that of a sample.
    """

    def __init__(self, heights_m: ArrayLike, pixel_um: float, pixel_y_um: float | None = None) -> None:
        """A map of an array, shape (rows, columns), with pixels of ``pixel_um`` along a row and ``pixel_y_um`` from row to row, in
        micrometres. An array that is too large raises :class:`slipgrid.errors.TooLargeError` and is not copied."""
        self._map = _slipgrid.Map(heights(heights_m), pixel_um, pixel_y_um)

    @classmethod
    def read(
        cls,
        path: PathLike,
        *,
        pixel_um: float | None = None,
        height_unit: str | None = None,
        lateral_unit: str | None = None,
        decimal_comma: bool = False,
    ) -> Map:
        """The map of a file: a matrix, points, SUR, OPD, SDF, PLU, GWY, X3P and what else ``slipgrid surface`` reads."""
        made = cls.__new__(cls)
        made._map = _slipgrid.Map.read(
            Path(path), pixel_um=pixel_um, height_unit=height_unit, lateral_unit=lateral_unit, decimal_comma=decimal_comma
        )
        return made

    @property
    def heights_m(self) -> NDArray[np.float64]:
        """Heights in metres, shape (rows, columns), a row for each line along x: a view of the map's own numbers, read-only."""
        return self._map.heights_m

    @property
    def pixel_um(self) -> tuple[float, float]:
        """Sides of a pixel along x, from column to column, and along y, from row to row, in micrometres."""
        return self._map.pixel_um

    @property
    def is_synthetic(self) -> bool:
        """The file says of itself that the surface is synthetic, not measured."""
        return self._map.is_synthetic

    def measure(self, *, form: str = "plane", missing: str = "fill", despike: bool = False) -> Surface:
        """What the map says: ``parameters`` of ISO 25178, ``spectrum`` and ``warnings``, as ``slipgrid surface --json`` names them.

        ``form`` is what is subtracted first: "mean", "plane" or "second-order"; ``missing`` is "fill" or "refuse".
        """
        found = Surface(_json.loads(self._map.measure_json(form=form, missing=missing, despike=despike)))
        warn(found.warnings)
        return found

    def area_law(
        self,
        *,
        youngs_modulus_gpa: float,
        poisson_ratio: float = 1.0 / 3.0,
        pressures_mpa: ArrayLike | None = None,
        threshold_mpa: float | None = None,
        tolerance: float = 1e-8,
        form: str = "plane",
        missing: str = "fill",
        despike: bool = False,
        windows: int | None = None,
        progress: Progress | None = None,
    ) -> AreaLaw:
        """Real contact area against nominal pressure by rough contact of the map, and the area law f(P) that follows.

        ``tolerance`` is the error at which the contact computation ends; its default is that of ``slipgrid area-law``, whose numbers
        these are. Without ``threshold_mpa`` f is A/P over its limit at small loads; with it, over A/P there.
        ``windows`` along either side give standard errors: 1 for none, 2 by default where the map has room.
        """
        record = self._map.area_law_json(
            youngs_modulus_gpa=youngs_modulus_gpa,
            poisson_ratio=poisson_ratio,
            pressures_mpa=None if pressures_mpa is None else floats("pressures_mpa", pressures_mpa),
            threshold_mpa=threshold_mpa,
            tolerance=tolerance,
            form=form,
            missing=missing,
            despike=despike,
            windows=windows,
            progress=progress,
        )
        found = AreaLaw(_json.loads(record))
        warn(found["warnings"])
        return found

    def __repr__(self) -> str:
        return repr(self._map)


class Surface(Record):
    """What a map says; fields as in ``slipgrid surface --json``."""

    @property
    def warnings(self) -> list[str]:
        """What is unusual in the map; empty where nothing is."""
        return list(self.get("warnings", []))


class AreaLaw(Record):
    """Contact area and area law by pressure."""

    @property
    def pressure_mpa(self) -> NDArray[np.float64]:
        """Nominal pressures, in MPa, shape (pressures,)."""
        return np.array(self["pressure_mpa"], dtype=np.float64)

    @property
    def area_fraction(self) -> NDArray[np.float64]:
        """Real over nominal contact area, corrected for the boundary of the contact, shape (pressures,)."""
        return np.array(self["area_fraction_corrected"], dtype=np.float64)

    @property
    def factor(self) -> NDArray[np.float64]:
        """f(P): what the local coefficient is multiplied by, shape (pressures,); NaN where there is no law."""
        return np.array([np.nan if of is None else of for of in self["factor"]], dtype=np.float64)

    def frame(self) -> _pandas.DataFrame:
        """One row a pressure."""
        names = ["pressure_mpa", "area_fraction", "area_fraction_corrected", "area_error", "factor"]
        found: _pandas.DataFrame = pandas().DataFrame({name: self[name] for name in names})
        return found


class Scene:
    """A material, a pattern or none, and loads: friction of a given surface."""

    def __init__(self, *, folder: PathLike = ".", fidelity: str | None = None, extent: str | None = None, **tables: Any) -> None:
        """A scene by the tables of a scene file: ``Scene(material={...}, pattern={...}, load={...})``. What they name is
        looked for in ``folder``; ``fidelity`` and ``extent`` overrule ``run``."""
        self._scene = _slipgrid.Scene(toml(tables), Path(folder) / "scene", fidelity=fidelity, extent=extent)

    @classmethod
    def from_toml(
        cls, text: str, folder: PathLike = ".", *, fidelity: str | None = None, extent: str | None = None
    ) -> Scene:
        """A scene from the text of a scene file that would stand in ``folder``."""
        made = cls.__new__(cls)
        made._scene = _slipgrid.Scene(text, Path(folder) / "scene.toml", fidelity=fidelity, extent=extent)
        return made

    @classmethod
    def read(cls, path: PathLike, *, fidelity: str | None = None, extent: str | None = None) -> Scene:
        """The scene file at ``path``."""
        made = cls.__new__(cls)
        made._scene = _slipgrid.Scene.read(Path(path), fidelity=fidelity, extent=extent)
        return made

    @property
    def warnings(self) -> list[str]:
        """What is unusual in it."""
        return self._scene.warnings

    def simulate(self, progress: Progress | None = None) -> SimulationResult:
        """Solves it: "steady", "dynamic" or "reference", as its ``run`` or ``fidelity`` says."""
        return SimulationResult(self._scene.simulate(progress))

    def steady(self) -> SteadyCell:
        """The steady cell of the scene's texture: ratios of one pattern after the other, microseconds beside the solve."""
        return self._scene.steady()


class SimulationResult(Record):
    """What a scene does; fields as in result.json of ``slipgrid simulate``."""

    def __init__(self, solved: _slipgrid.Solved | Kept) -> None:
        self._solved = solved
        record, times = solved.json()
        super().__init__(_json.loads(record))
        self._times: dict[str, Any] = _json.loads(times)

    def __reduce__(self) -> tuple[type[SimulationResult], tuple[Kept]]:
        return SimulationResult, (Kept.of(self._solved),)

    @property
    def pressure_mpa(self) -> NDArray[np.float64]:
        """Nominal pressures, in MPa, shape (loads,)."""
        return array(self["results"], "pressure_mpa")

    @property
    def mu_dynamic(self) -> NDArray[np.float64]:
        """Dynamic friction coefficients, shape (loads,); NaN where there is none."""
        return array(self["results"], "mu_dynamic")

    @property
    def ratio(self) -> NDArray[np.float64]:
        """Patterned over flat dynamic friction, shape (loads,); NaN where there is none."""
        return array(self["results"], "ratio")

    @property
    def warnings(self) -> list[str]:
        """What is doubtful in the scene and in its results, one sentence each."""
        return list(self._solved.warnings)

    @property
    def times(self) -> Record:
        """Seconds and speeds, as in timings.json."""
        return Record(self._times)

    def frame(self) -> _pandas.DataFrame:
        """One row a load."""
        return frame(self["results"])

    def export(self, folder: PathLike) -> list[Path]:
        """Writes what ``slipgrid simulate -o`` writes. Files that slipgrid did not write, and inputs, are not replaced."""
        return write(self._solved.files(), folder, self._solved.inputs)

    def __str__(self) -> str:
        return self._solved.text()

    def _repr_html_(self) -> str:
        return table(self["results"], ["pressure_mpa", "mu_dynamic", "mu_flat", "ratio", "peak_pressure_mpa", "status"])


class Calibration:
    """Measurements on samples, and the surface that they were made on."""

    def __init__(self, *, folder: PathLike = ".", **tables: Any) -> None:
        """A calibration by the tables of a calibration file; what they name is looked for in ``folder``."""
        self._calibration = _slipgrid.Calibration(toml(tables), Path(folder) / "calibration")

    @classmethod
    def from_toml(cls, text: str, folder: PathLike = ".") -> Calibration:
        """A calibration from the text of a file that would stand in ``folder``."""
        made = cls.__new__(cls)
        made._calibration = _slipgrid.Calibration(text, Path(folder) / "calibration.toml")
        return made

    @classmethod
    def read(cls, path: PathLike) -> Calibration:
        """The calibration file at ``path``."""
        made = cls.__new__(cls)
        made._calibration = _slipgrid.Calibration.read(Path(path))
        return made

    @property
    def warnings(self) -> list[str]:
        """What is unusual in it."""
        return self._calibration.warnings

    def fit(self, progress: Progress | None = None) -> Material:
        """Fits local coefficients to the flat samples, and learns from trials."""
        return Material(self._calibration.fit(progress))

    def trials(self, progress: Progress | None = None) -> Trials:
        """What was predicted of trial samples before they were cut, what was measured, and what that says of the next."""
        record, text = self._calibration.trials(progress)
        return Trials(_json.loads(record), text)


class Material:
    """A fitted material; scenes and designs name the file that :meth:`save` writes."""

    def __init__(self, fitted: _slipgrid.Fitted | Kept) -> None:
        self._fitted = fitted

    def __reduce__(self) -> tuple[type[Material], tuple[Kept]]:
        return Material, (Kept.of(self._fitted),)

    @property
    def toml(self) -> str:
        """The material file, but for ``[made_from]``, which is of a file at its place."""
        return self._fitted.material_toml()

    @property
    def warnings(self) -> list[str]:
        """What is doubtful in the measurements and in the material, one sentence each."""
        return list(self._fitted.warnings)

    @property
    def fit(self) -> Record:
        """Coefficients, covariance and residuals, as in fit.json of ``slipgrid calibrate --report``."""
        return Record(_json.loads(self._fitted.fit_json()))

    def save(self, path: PathLike) -> Path:
        """Writes the material file, which remembers the calibration file that it was made from. A file that slipgrid did not
        write is not replaced."""
        path = Path(path)
        _slipgrid.write_file(self._fitted.material_toml(path).encode(), path, self._fitted.inputs)
        return path

    def export(self, folder: PathLike) -> list[Path]:
        """Writes what ``slipgrid calibrate --report`` writes; nothing is replaced that slipgrid did not write."""
        return write(self._fitted.files(), folder, self._fitted.inputs)

    def __str__(self) -> str:
        return self._fitted.text()


class Trials(Record):
    """The ledger of trials; fields as in ``slipgrid trials --json``."""

    def __init__(self, fields: dict[str, Any], text: str) -> None:
        super().__init__(fields)
        self._words = text

    def frame(self) -> _pandas.DataFrame:
        """One row a measured ratio, with the trial's name."""
        rows = [{"trial": trial["name"], **at} for trial in self["trials"] for at in trial["measured"]]
        return frame(rows)

    def __str__(self) -> str:
        return self._words


class Design:
    """A design task: which friction, of which material, and what may be cut."""

    def __init__(self, *, folder: PathLike = ".", **tables: Any) -> None:
        """A task by the tables of a design file: ``Design(material={...}, target={...}, bounds={...}, specimen={...})``. What
        they name is looked for in ``folder``."""
        self._design = _slipgrid.Design(toml(tables), Path(folder) / "design")

    @classmethod
    def from_toml(cls, text: str, folder: PathLike = ".") -> Design:
        """A task from the text of a design file that would stand in ``folder``."""
        made = cls.__new__(cls)
        made._design = _slipgrid.Design(text, Path(folder) / "design.toml")
        return made

    @classmethod
    def read(cls, path: PathLike) -> Design:
        """The design file at ``path``."""
        made = cls.__new__(cls)
        made._design = _slipgrid.Design.read(Path(path))
        return made

    @property
    def warnings(self) -> list[str]:
        """What is unusual in it."""
        return self._design.warnings

    def optimize(self, progress: Progress | None = None) -> DesignResult:
        """Searches the pattern, confirms it in time and explains; a calibration that the task names is fitted once."""
        return DesignResult(self._design.optimize(progress))

    def explore(self, path: PathLike, progress: Progress | None = None) -> Path:
        """Writes a page with sliders, what any design within the bounds does, before a search; as ``slipgrid explore``. A file that
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
    ) -> NextSamples:
        """The ``count`` samples to cut next by what trials say. ``candidates_um`` are patterns of one's own, rows of width, spacing
        and depth, whose chance is asked for."""
        return NextSamples(self._design.next_samples(count, triples("candidates_um", candidates_um), progress))


class DesignResult(Record):
    """A design that was found; fields as in result.json of ``slipgrid optimize``: ``advice``, ``chance``, ``expected``, ``design``."""

    def __init__(self, designed: _slipgrid.Designed | Kept) -> None:
        self._designed = designed
        record, times = designed.json()
        super().__init__(_json.loads(record))
        self._times: dict[str, Any] = _json.loads(times)

    def __reduce__(self) -> tuple[type[DesignResult], tuple[Kept]]:
        return DesignResult, (Kept.of(self._designed),)

    @property
    def headline(self) -> str:
        """The first line of what ``slipgrid optimize`` prints: what to do, and the chance that a cut sample is on target."""
        return self._designed.text().splitlines()[0]

    @property
    def warnings(self) -> list[str]:
        """What is doubtful in the task, its material and the design found, one sentence each."""
        return list(self._designed.warnings)

    @property
    def times(self) -> Record:
        """Seconds of every stage, as in timings.json."""
        return Record(self._times)

    def frame(self) -> _pandas.DataFrame:
        """One row a load: what is accepted, what is expected of a cut sample, and what the model alone says."""
        rows = [
            {**expected, "model_alone": modelled["ratio"], "model_alone_std": modelled["std"]}
            for expected, modelled in zip(self["expected"], self["modelled"], strict=True)
        ]
        return frame(rows)

    def export(self, folder: PathLike) -> list[Path]:
        """Writes what ``slipgrid optimize -o`` writes: the files of the laser, tables, pictures and report.html.
        Files that slipgrid did not write, and inputs, are not replaced: :class:`slipgrid.errors.InputError` names them."""
        return write(self._designed.files(), folder, self._designed.inputs)

    def drawing(self, format: str) -> bytes:
        """The pattern as "dxf", "svg", "csv", "process", "plt", "gcode", "corners", "hatch", "png" or "stl"."""
        return self._designed.drawing(format)[1]

    def report_html(self) -> str:
        """The page that stands alone."""
        return dict(self._designed.files())["report.html"].decode()

    def __str__(self) -> str:
        return self._designed.text()

    def _repr_html_(self) -> str:
        page = _html.escape(self.report_html(), quote=True)
        return f'<iframe srcdoc="{page}" style="width: 100%; height: 40em; border: 0"></iframe>'


class NextSamples(Record):
    """The samples to cut next; fields as in ``slipgrid next --json``."""

    def __init__(self, samples: _slipgrid.NextSamples) -> None:
        super().__init__(_json.loads(samples.json()))
        self._words = samples.text()
        self._warnings = samples.warnings

    @property
    def warnings(self) -> list[str]:
        """What is doubtful in the task, its material and the samples, one sentence each."""
        return list(self._warnings)

    def frame(self) -> _pandas.DataFrame:
        """One row a sample: those to cut, those asked for, and others."""
        rows = [
            {"which": which, **of["design"], **of} for which in ("samples", "own", "others") for of in self[which]
        ]
        return frame(rows)

    def __str__(self) -> str:
        return self._words
