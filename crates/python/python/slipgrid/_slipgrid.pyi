"""The compiled part of slipgrid."""

from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import final

import numpy as np
from numpy.typing import NDArray

__version__: str
MAX_MAP_POINTS: int
__all__ = [
    "__version__",
    "MAX_MAP_POINTS",
    "Calibration",
    "Campaign",
    "Design",
    "Designed",
    "Fitted",
    "Map",
    "Scene",
    "Solved",
    "SteadyCell",
    "check_file",
    "restore_map",
    "read_material",
    "set_cache",
    "set_threads",
    "threads",
    "give_warnings",
    "write_file",
    "write_folder",
]

_Progress = Callable[[str, float], object]
_Path = str | PathLike[str]
_Told = tuple[str, list[str], list[Path]]
_Copied = tuple[bool, Mapping[str, bytes]]

def set_threads(count: int | None = None) -> None:
    """Sets the number of threads to `count`, of which no more than cores are started, or to the number of cores if `count`
    is None. Results do not depend on it. More than 1024 are refused."""

def set_cache(library: _Path, is_on: bool, folder: _Path | None) -> None:
    """Keeps results of the library in the file `library` from now on: in the process, and in `folder` or where the environment says;
    not at all unless `is_on`."""

def read_material(path: _Path, text: str | None = None) -> tuple[str, list[str]]:
    """Checks the material file at `path`, or `text` in its place; returns the text and its warnings."""

def threads() -> int:
    """Number of computing threads."""

def give_warnings(doubts: Sequence[str]) -> None:
    """Gives a warning for each of `doubts`, sentences about input or results."""

def write_folder(files: Sequence[tuple[str, bytes]], folder: _Path, inputs: Sequence[_Path]) -> None:
    """Writes `files`, by name, into `folder`; neither `inputs` nor files of other programs are replaced."""

def write_file(content: bytes, path: _Path, inputs: Sequence[_Path]) -> None:
    """Writes one file; refuses to replace one of `inputs`, the files that the content was made from."""

def check_file(path: _Path, inputs: Sequence[_Path]) -> None:
    """Checks before a long computation that the file can be written and is none of `inputs`; raises an error otherwise."""

def restore_map(
    heights_m: NDArray[np.float64],
    sides_m: Sequence[float],
    whole: bool,
    format: str,
    comments: Sequence[str],
    notes: Sequence[str],
    path: _Path,
) -> Map:
    """Restores a map that was read from `path` in `format`, with all its data; used by copies."""

@final
class Map:
    def __new__(cls, heights_m: NDArray[np.float64], pixel_um: float, pixel_y_um: float | None = None) -> Map: ...
    @staticmethod
    def read(
        path: _Path,
        *,
        pixel_um: float | None = None,
        pixel_y_um: float | None = None,
        height_unit: str | None = None,
        lateral_unit: str | None = None,
        decimal_comma: bool = False,
        crop: Sequence[int] | None = None,
        decimate: int | None = None,
        decimate_by: str = "mean",
    ) -> Map: ...
    def __reduce__(
        self,
    ) -> tuple[
        Callable[..., Map], tuple[NDArray[np.float64], Sequence[float], bool, str, list[str], list[str], str]
    ]: ...
    @property
    def heights_m(self) -> NDArray[np.float64]: ...
    @property
    def pixel_um(self) -> tuple[float, float]: ...
    @property
    def sides_m(self) -> tuple[float, float]: ...
    @property
    def is_synthetic(self) -> bool: ...
    def measure_json(self, *, form: str = "plane", missing: str = "fill", despike: bool = False) -> str: ...
    def area_law_json(
        self,
        *,
        youngs_modulus_gpa: float,
        poisson_ratio: float = ...,
        pressures_mpa: Sequence[float] | None = None,
        threshold_mpa: float | None = None,
        tolerance: float = 1e-8,
        form: str = "plane",
        missing: str = "fill",
        despike: bool = False,
        windows: int | None = None,
        progress: _Progress | None = None,
    ) -> str: ...

@final
class Scene:
    def __new__(
        cls,
        text: str | None,
        path: _Path,
        fidelity: str | None = None,
        extent: str | None = None,
        objects: Mapping[str, bytes] | None = None,
        copied: _Copied | None = None,
    ) -> Scene: ...
    def __reduce__(
        self,
    ) -> tuple[type[Scene], tuple[str, str, str | None, str | None, None, tuple[bool, dict[str, bytes]]]]: ...
    @property
    def warnings(self) -> list[str]: ...
    def simulate(self, progress: _Progress | None = None) -> tuple[list[str], _Told, Solved]: ...
    def steady(self) -> SteadyCell: ...

@final
class Solved:
    def files(self) -> list[tuple[str, bytes]]: ...

@final
class SteadyCell:
    """A steady cell: equilibrium of one period with every contact block sliding."""

    @property
    def pressure_mpa(self) -> NDArray[np.float64]: ...
    def solve(self, rows: NDArray[np.float64]) -> NDArray[np.float64]:
        """Ratio, dynamic friction and peak pressure in MPa, shape (rows, 3), for rows of width, spacing and depth in micrometres and
        pressure in MPa."""

@final
class Calibration:
    def __new__(
        cls, text: str | None, path: _Path, objects: Mapping[str, bytes] | None = None, copied: _Copied | None = None
    ) -> Calibration: ...
    def __reduce__(self) -> tuple[type[Calibration], tuple[str, str, None, tuple[bool, dict[str, bytes]]]]: ...
    @property
    def warnings(self) -> list[str]: ...
    def fit(self, progress: _Progress | None = None) -> tuple[list[str], _Told, Fitted]: ...
    def trials(self, progress: _Progress | None = None) -> list[str]: ...

@final
class Fitted:
    def material_toml(self, output: _Path) -> str: ...
    def files(self) -> list[tuple[str, bytes]]: ...

@final
class Campaign:
    @staticmethod
    def plan(path: _Path, progress: _Progress | None = None) -> Campaign: ...
    @staticmethod
    def of(shared: str, inputs: Mapping[str, bytes], tasks: Sequence[str]) -> Campaign: ...
    @property
    def name(self) -> str: ...
    def parts(self) -> tuple[str, dict[str, bytes]]: ...
    def tasks(self) -> list[str]: ...
    def work(self) -> list[str]: ...
    def table(self, results: Sequence[str | None]) -> tuple[str, str]: ...

@final
class Design:
    def __new__(
        cls, text: str | None, path: _Path, objects: Mapping[str, bytes] | None = None, copied: _Copied | None = None
    ) -> Design: ...
    def __reduce__(self) -> tuple[type[Design], tuple[str, str, None, tuple[bool, dict[str, bytes]]]]: ...
    @property
    def inputs(self) -> list[Path]: ...
    @property
    def warnings(self) -> list[str]: ...
    def optimize(self, progress: _Progress | None = None) -> tuple[list[str], _Told, Designed]: ...
    def predict(
        self, rows: NDArray[np.float64], progress: _Progress | None = None
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], str, list[float], list[str]]: ...
    def explore_html(self, progress: _Progress | None = None) -> str: ...
    def next_samples(
        self,
        count: int,
        candidates_um: Sequence[tuple[float, float, float]],
        progress: _Progress | None = None,
        one_disc: bool = False,
        learn: bool = False,
    ) -> tuple[str, _Told]: ...

@final
class Designed:
    def files(self) -> list[tuple[str, bytes]]: ...
    def drawing(self, format: str) -> tuple[str, bytes]: ...
