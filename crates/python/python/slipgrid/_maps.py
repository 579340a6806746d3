"""Altitude maps, their parameters, and the area law of rough contact."""

from __future__ import annotations

import json
import struct
from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Literal, Optional

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _plots, _slipgrid
from ._records import Progress, Record, floats, frame, heights, table

if TYPE_CHECKING:
    import pandas as _pandas
    from matplotlib.axes import Axes

#: Form that is subtracted from a map first.
Form = Literal["mean", "plane", "second-order"]
#: What is done with missing points.
Missing = Literal["fill", "refuse"]


class SurfaceParameters(Record):
    """Parameters of ISO 25178 and the slope of the spectrum; ``None`` where a map does not determine one."""

    sa_um: float
    sq_um: float
    ssk: Optional[float]
    sku: Optional[float]
    sp_um: float
    sv_um: float
    sz_um: float
    sdq: float
    sdr_pct: float
    rms_slope: float
    sal_um: Optional[float]
    str: Optional[float]
    sk_um: Optional[float]
    spk_um: Optional[float]
    svk_um: Optional[float]
    smr1_pct: Optional[float]
    smr2_pct: Optional[float]


class SpectrumPoint(Record):
    """Mean power spectral density over the waves of one band of wavelengths."""

    wavelength_um: float
    q_per_um: float
    psd_um4: float
    waves: float


class SurfaceFilters(Record):
    """Operation and filters of ISO 25178-2 before the parameters, and the waves that the map holds."""

    #: Form that the F-operation removed: "mean", "plane" or "second-order".
    f_operation: str
    #: Nesting indices of the S-filter and the L-filter; ``None``, because neither is applied.
    s_filter_um: Optional[float]
    l_filter_um: Optional[float]
    #: Two pixels, and the longer side of the map.
    shortest_wave_um: float
    longest_wave_um: float


class Surface(Record):
    """What a map says; fields as in ``slipgrid surface --json``."""

    format: str
    synthetic_surface: bool
    rows: int
    columns: int
    pixel_um: list[float]
    missing_points: int
    model: list[str]
    parameters: SurfaceParameters
    filters: SurfaceFilters
    spectrum: list[SpectrumPoint]
    #: Warnings about the map, one sentence each.
    warnings: list[str]

    def _repr_html_(self) -> str:
        return table([self["parameters"]], list(self["parameters"]))


class AreaLaw(Record):
    """Real contact area and area law by pressure. It may stand where a material has its ``area_law``."""

    rms_slope: float
    full_contact_pressure_mpa: float
    #: Warnings about the law, one sentence each.
    warnings: list[str]

    @property
    def pressure_mpa(self) -> NDArray[np.float64]:
        """Nominal pressures in MPa, shape (pressures,)."""
        return np.array(self["pressure_mpa"], dtype=np.float64)

    @property
    def area_fraction(self) -> NDArray[np.float64]:
        """Real over nominal contact area, corrected for the boundary of the contact, shape (pressures,)."""
        return np.array(self["area_fraction_corrected"], dtype=np.float64)

    @property
    def factor(self) -> NDArray[np.float64]:
        """f(P), by which the local coefficient is multiplied, shape (pressures,); NaN where there is no law."""
        return np.array(self["factor"], dtype=np.float64)

    @property
    def factor_std(self) -> NDArray[np.float64]:
        """Standard errors of f(P) from windows of the map, shape (pressures,); NaN without windows."""
        return np.array(self["factor_std"], dtype=np.float64)

    def _as_table(self) -> dict[str, object]:
        known = np.isfinite(self.factor)
        law: dict[str, object] = {"origin": "map", "rms_slope": self.rms_slope}
        law |= {"pressure_mpa": self.pressure_mpa[known], "factor": self.factor[known]}
        std = self.factor_std[known]
        return {**law, "factor_std": std} if np.isfinite(std).all() else law

    def frame(self) -> _pandas.DataFrame:
        """One row a pressure."""
        return frame(self._rows())

    def _rows(self) -> list[dict[str, float]]:
        names = ["pressure_mpa", "area_fraction", "area_fraction_corrected", "area_error", "factor"]
        return [dict(zip(names, row)) for row in zip(*(self[name] for name in names))]

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draws f(P) with its standard errors.

        Parameters
        ----------
        ax
            Axes of Matplotlib, by default new ones.

        Returns
        -------
        Axes
            The axes.
        """
        return _plots.area_law(self, ax)

    def __repr__(self) -> str:
        ends = f"{self.pressure_mpa[0]:g} to {self.pressure_mpa[-1]:g} MPa" if len(self.pressure_mpa) else "no pressure"
        return f"<AreaLaw at {len(self.pressure_mpa)} pressures, {ends}>"

    def _repr_html_(self) -> str:
        return table(self._rows(), ["pressure_mpa", "area_fraction_corrected", "factor"])


class Map:
    """An altitude map: heights in metres, missing points NaN or masked.

    Rows of the array are lines of a file, as ``numpy.loadtxt`` reads them: x runs along a row (axis 1), y from row to row (axis 0).
    A sample slides along x, which is axis 1 of the array.

    Parameters
    ----------
    heights_m
        Heights in metres, shape (rows, columns).
    pixel_um
        Side of a pixel along x, in micrometres.
    pixel_y_um
        Side of a pixel along y, in micrometres; as along x by default.

    Raises
    ------
    slipgrid.errors.TooLargeError
        If the array exceeds the limit of points; it is not copied.

    Examples
    --------
    >>> import numpy as np, slipgrid
    >>> waves = 1e-7 * np.sin(2 * np.pi * np.arange(64) / 16)
    >>> surface = slipgrid.Map(np.tile(waves, (64, 1)), pixel_um=0.5)
    >>> surface
    <slipgrid.Map 64 x 64 pixels of 0.5 x 0.5 um>
    >>> round(surface.measure().parameters.sq_um, 4)
    0.0694
    """

    def __init__(self, heights_m: ArrayLike, pixel_um: float, pixel_y_um: float | None = None) -> None:
        self._map = _slipgrid.Map(heights(heights_m), pixel_um, pixel_y_um)

    @classmethod
    def read(
        cls,
        path: str | PathLike[str],
        *,
        pixel_um: float | None = None,
        pixel_y_um: float | None = None,
        height_unit: str | None = None,
        lateral_unit: str | None = None,
        decimal_comma: bool = False,
        crop: Sequence[int] | None = None,
        decimate: int | None = None,
        decimate_by: Literal["mean", "pick"] = "mean",
    ) -> Map:
        """Reads a map in any format that ``slipgrid surface`` reads.

        Parameters
        ----------
        path
            A matrix, points, SUR, OPD, SDF, PLU, GWY, X3P, NPY and others.
        pixel_um, pixel_y_um
            Sides of a pixel along x and y in micrometres, for files that do not state them.
        height_unit, lateral_unit
            Units of heights, and of x and y in lists of points, for files that do not state them.
        decimal_comma
            Whether commas are decimal signs.
        crop
            First row, first column, number of rows, number of columns.
        decimate
            Number N of points along each side that are joined into one.
        decimate_by
            Whether a joined point is the mean of its points or the first.

        Raises
        ------
        slipgrid.errors.InputError
            If the file is refused; the error has the file and the line.
        """
        made = cls.__new__(cls)
        made._map = _slipgrid.Map.read(
            Path(path),
            pixel_um=pixel_um,
            pixel_y_um=pixel_y_um,
            height_unit=height_unit,
            lateral_unit=lateral_unit,
            decimal_comma=decimal_comma,
            crop=crop,
            decimate=decimate,
            decimate_by=decimate_by,
        )
        return made

    @property
    def heights_m(self) -> NDArray[np.float64]:
        """Heights in metres, shape (rows, columns), x along axis 1: a read-only view of the map's own numbers."""
        return self._map.heights_m

    @property
    def pixel_um(self) -> tuple[float, float]:
        """Sides of a pixel in micrometres along x (axis 1) and along y (axis 0)."""
        return self._map.pixel_um

    @property
    def is_synthetic(self) -> bool:
        """Whether the file states that the surface is synthetic, not measured."""
        return self._map.is_synthetic

    def _as_files(self, number: int) -> tuple[str, dict[str, bytes]]:
        """The map as a binary surface data file (SDF), which keeps every bit of its heights."""
        lines = self.heights_m
        dx_m, dy_m = self._map.sides_m
        maker = b"synthetic" if self.is_synthetic else b"slipgrid"
        counts = (lines.shape[1], lines.shape[0])
        head = struct.pack("<8s10s12s12sIIddddbbb", b"bISO-2.0", maker, b"", b"", *counts, dx_m, dy_m, 1.0, 0.0, 0, 7, 0)
        name = f"<map {number}>.sdf"
        return name, {name: head + lines.astype("<f8").tobytes()}

    def measure(self, *, form: Form = "plane", missing: Missing = "fill", despike: bool = False) -> Surface:
        """Measures the map.

        Parameters
        ----------
        form
            Form that is subtracted first.
        missing
            Whether missing points are filled or refused.
        despike
            Whether spikes are replaced by the median of the points about them.

        Returns
        -------
        Surface
            ``parameters`` of ISO 25178, ``spectrum`` and ``warnings``, as ``slipgrid surface --json`` names them.
        """
        found = Surface(json.loads(self._map.measure_json(form=form, missing=missing, despike=despike)))
        _slipgrid.give_warnings(found.warnings)
        return found

    def area_law(
        self,
        *,
        youngs_modulus_gpa: float,
        poisson_ratio: float = 1.0 / 3.0,
        pressures_mpa: ArrayLike | None = None,
        threshold_mpa: float | None = None,
        tolerance: float = 1e-8,
        form: Form = "plane",
        missing: Missing = "fill",
        despike: bool = False,
        windows: int | None = None,
        progress: Progress | None = None,
    ) -> AreaLaw:
        """Computes real contact area against nominal pressure by rough contact of the map, and the area law f(P).

        Parameters
        ----------
        youngs_modulus_gpa, poisson_ratio
            Elastic constants of the softer body.
        pressures_mpa
            Nominal pressures in MPa, shape (pressures,), increasing; those of ``slipgrid area-law`` by default.
        threshold_mpa
            Pressure up to which friction is proportional to load: f is A/P over A/P there. By default over its limit at small
            loads.
        tolerance
            Error at which the contact computation ends.
        form, missing, despike
            As for :meth:`measure`.
        windows
            Windows along either side, whose scatter gives standard errors: 1 for none; 2 by default where the map has room.
        progress
            Called with the stage and the share that is done.

        Returns
        -------
        AreaLaw
            Arrays by pressure.
        """
        record = json.loads(self._map.area_law_json(
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
        ))
        names = ("pressure_mpa", "area_fraction", "area_fraction_corrected", "area_error", "factor", "factor_std")
        found = AreaLaw({
            **{name: record[name] for name in ("rms_slope", "full_contact_pressure_mpa")},
            **{name: [row[name] for row in record["results"]] for name in names},
            "warnings": record.get("warnings", []),
        })
        _slipgrid.give_warnings(found.warnings)
        return found

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draws the heights in micrometres, x to the right.

        Parameters
        ----------
        ax
            Axes of Matplotlib, by default new ones.

        Returns
        -------
        Axes
            The axes.
        """
        return _plots.heights(self, ax)

    def __repr__(self) -> str:
        return repr(self._map)
