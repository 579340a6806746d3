"""Records: what a computation found, with the field names of result.json."""

from __future__ import annotations

import html
import importlib
import json
import re
import warnings
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _slipgrid, errors

if TYPE_CHECKING:
    import pandas as _pandas


def _wrapped(value: Any) -> Any:
    if isinstance(value, dict):
        return Record(value)
    if isinstance(value, list):
        return [_wrapped(item) for item in value]
    return value


class Record(Mapping[str, Any]):
    """A record whose fields are attributes as well as keys: ``found.design.width_um``, ``found["design"]["width_um"]``.

    Units stand in the names. A field that has no value is ``None``.
    """

    def __init__(self, fields: dict[str, Any]) -> None:
        self._fields = fields

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        try:
            return _wrapped(self._fields[name])
        except KeyError:
            raise AttributeError(f"no field {name!r}: expected one of {', '.join(self._fields)}") from None

    def __getitem__(self, name: str) -> Any:
        return self._fields[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._fields)

    def __len__(self) -> int:
        return len(self._fields)

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._fields]

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {', '.join(self._fields)}>"

    def to_dict(self) -> dict[str, Any]:
        """A copy as plain dictionaries, lists, numbers and strings."""
        copy: dict[str, Any] = json.loads(json.dumps(self._fields))
        return copy


def array(rows: Sequence[Mapping[str, Any]], name: str) -> NDArray[np.float64]:
    """The field ``name`` of every row; NaN where there is no value."""
    return np.array([np.nan if row.get(name) is None else row[name] for row in rows], dtype=np.float64)


def pandas() -> ModuleType:
    """The package pandas, which frames alone need."""
    try:
        return importlib.import_module("pandas")
    except ImportError as error:
        raise ImportError(f"frame() needs pandas ({error}): pip install pandas") from error


class Kept:
    """What the compiled half of a result gave, in a copy of the result: in another process it is not there."""

    def __init__(self, given: dict[str, Any]) -> None:
        self._given = given

    @classmethod
    def of(cls, found: Any) -> Kept:
        """All that ``found`` gives."""
        if isinstance(found, cls):
            return found
        names = [name for name in ("json", "text", "files", "material_toml", "fit_json") if hasattr(found, name)]
        given = {"inputs": list(found.inputs), "warnings": list(found.warnings)}
        return cls({**given, **{name: getattr(found, name)() for name in names}})

    def json(self) -> tuple[str, str]:
        record, times = self._given["json"]
        return record, times

    def text(self) -> str:
        return str(self._given["text"])

    def files(self) -> list[tuple[str, bytes]]:
        return list(self._given["files"])

    def fit_json(self) -> str:
        return str(self._given["fit_json"])

    def material_toml(self, path: Path | None = None) -> str:
        return str(self._given["material_toml"])

    def drawing(self, format: str) -> tuple[str, bytes]:
        names = {"dxf": "pattern.dxf", "svg": "pattern.svg", "csv": "pattern.csv", "process": "process.toml"}
        if format not in names:
            raise errors.ComputationError(f"a copy holds {', '.join(names)}: draw {format!r} with the result that was copied")
        return names[format], dict(self.files())[names[format]]

    @property
    def inputs(self) -> list[Path]:
        return list(self._given["inputs"])

    @property
    def warnings(self) -> list[str]:
        return list(self._given["warnings"])


def frame(rows: Sequence[Mapping[str, Any]]) -> _pandas.DataFrame:
    """A frame of the plain numbers and words of ``rows``."""
    plain = [{name: value for name, value in row.items() if not isinstance(value, (dict, list))} for row in rows]
    found: _pandas.DataFrame = pandas().DataFrame(plain)
    return found


def table(rows: Sequence[Mapping[str, Any]], names: Sequence[str]) -> str:
    """An HTML table of ``names`` of every row."""

    def cell(value: Any) -> str:
        if value is None:
            return "-"
        return html.escape(f"{value:.5g}" if isinstance(value, float) else str(value))

    head = "".join(f"<th>{html.escape(name)}</th>" for name in names)
    body = "".join("<tr>" + "".join(f"<td>{cell(row.get(name))}</td>" for name in names) + "</tr>" for row in rows)
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


#: Kinds of arrays that hold real numbers: of floating point, whole, without sign, and objects that may be any of them.
_REAL = "fiuO"


#: Most numbers of a list in a file, a list of pressures or of candidates: an array that claims more is not copied out.
_MAX_NUMBERS = 10_000_000


def _check_count(name: str, given: Any) -> None:
    """Refuses, before it is copied, an array with more than ``_MAX_NUMBERS`` numbers."""
    size = getattr(given, "size", 0)
    if isinstance(size, (int, np.integer)) and size > _MAX_NUMBERS:
        raise errors.TooLargeError(
            f"{name}: has {size} numbers; expected at most {_MAX_NUMBERS}",
            key=name,
            value=str(size),
            expected=f"at most {_MAX_NUMBERS}",
        )


def heights(given: ArrayLike) -> NDArray[np.float64]:
    """``given`` as a matrix of heights, NaN where they are masked."""
    expected = "expected real numbers, shape (rows, columns)"
    try:
        typed: NDArray[Any] = np.asanyarray(given)
        if typed.size > _slipgrid.MAX_MAP_POINTS:
            raise errors.TooLargeError(
                f"heights_m: has {typed.size} points; expected at most {_slipgrid.MAX_MAP_POINTS}",
                key="heights_m",
                value=str(typed.size),
                expected=f"at most {_slipgrid.MAX_MAP_POINTS}",
            )
        if typed.dtype.kind not in _REAL:
            raise TypeError(f"holds what is of the type {typed.dtype}")
        array: NDArray[np.float64] = np.asarray(np.ma.filled(typed.astype(np.float64, copy=False), np.nan))
    except errors.InputError:
        raise
    except (TypeError, ValueError) as error:
        raise type(error)(f"heights_m: {error}; {expected}") from None
    if array.ndim != 2:
        raise ValueError(f"heights_m has the shape {array.shape}; {expected}")
    return array


def floats(name: str, given: Any) -> list[float]:
    """The argument ``name`` as a list of numbers."""
    expected = f"{name} is {given!r:.80}: expected a list of numbers"
    if isinstance(given, (str, bytes, bytearray, memoryview, Mapping)):
        raise TypeError(expected)
    _check_count(name, given)
    try:
        return [float(number) for number in given]
    except (TypeError, ValueError):
        raise TypeError(expected) from None


def triples(name: str, given: Any) -> list[tuple[float, float, float]]:
    """The argument ``name`` as rows of width, spacing and depth."""
    if isinstance(given, (str, bytes, bytearray, memoryview, Mapping)) or not hasattr(given, "__iter__"):
        raise TypeError(f"{name} is {given!r:.80}: expected rows of width, spacing and depth")
    _check_count(name, given)
    rows = []
    # A frame of pandas gives the names of its columns where rows are asked for.
    for place, row in enumerate(np.asanyarray(given) if hasattr(given, "__array__") else given):
        lengths = floats(f"{name}[{place}]", row)
        if len(lengths) != 3:
            raise ValueError(f"{name}[{place}] has {len(lengths)} numbers: expected width, spacing and depth")
        rows.append((lengths[0], lengths[1], lengths[2]))
    return rows


def warn(doubts: Sequence[str]) -> None:
    """Warns who called the caller of each of ``doubts``."""
    for doubt in doubts:
        warnings.warn(doubt, errors.SlipgridWarning, stacklevel=3)


def write(files: Sequence[tuple[str, bytes]], folder: str | Path, inputs: Sequence[Path]) -> list[Path]:
    """Writes ``files`` into ``folder``, which is made where there is none; neither ``inputs`` nor files of others are replaced."""
    folder = Path(folder)
    _slipgrid.write_folder(files, folder, inputs)
    return [folder / name for name, _ in files]


def toml(tables: Mapping[str, Any]) -> str:
    """Nested dictionaries as TOML; their lists may be arrays, or what is like one."""

    def quoted(text: str) -> str:
        return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")

    def bare(name: Any) -> str:
        return str(name) if re.fullmatch("[A-Za-z0-9_-]+", str(name)) else quoted(str(name))

    def value(at: str, item: Any) -> str:
        if isinstance(item, Mapping):
            return "{ " + ", ".join(f"{bare(key)} = {value(f'{at}.{key}', own)}" for key, own in item.items()) + " }"
        if isinstance(item, (bool, np.bool_)):
            return "true" if item else "false"
        if isinstance(item, str):
            return quoted(item)
        if isinstance(item, Path):
            return quoted(str(item))
        if isinstance(item, (int, np.integer)):
            return str(int(item))
        if isinstance(item, (float, np.floating)):
            return repr(float(item))
        if item is np.ma.masked:
            raise TypeError(f"{at} is masked: expected a number")
        if not isinstance(item, (np.ndarray, np.generic)) and hasattr(item, "__array__"):
            # A series of pandas, or what else is like an array.
            item = np.asarray(item)
        if isinstance(item, np.ndarray) and item.ndim == 0:
            raise TypeError(f"{at} is an array without dimensions: expected a number, as its item() gives it, or a list")
        _check_count(at, item)
        if isinstance(item, (Sequence, np.ndarray)) and not isinstance(item, (bytes, bytearray, memoryview)):
            return "[" + ", ".join(value(at, own) for own in item) + "]"
        raise TypeError(f"{at} is {item!r:.80}, which has no TOML form: expected numbers, strings, booleans, lists and dictionaries")

    lines = []
    for name, item in tables.items():
        if not isinstance(item, Mapping):
            lines.append(f"{bare(name)} = {value(name, item)}")
    for name, item in tables.items():
        if isinstance(item, Mapping):
            lines.append(f"[{bare(name)}]")
            lines.extend(f"{bare(key)} = {value(f'{name}.{key}', own)}" for key, own in item.items())
    return "\n".join(lines) + "\n"
