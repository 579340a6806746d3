"""Records of results, and conversion of arguments."""

from __future__ import annotations

import html
import importlib
import json
import math
import re
import typing
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import lru_cache
from os import PathLike
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, Protocol, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _slipgrid, errors

if TYPE_CHECKING:
    import pandas as _pandas

#: Called several times per second with the stage that runs and the share of it that is done, 0 to 1.
Progress = Callable[[str, float], object]
#: Maximum number of numbers of an argument: an array that claims more is not copied.
MAX_NUMBERS = 10_000_000
#: Kinds of arrays that hold real numbers: floating point, whole, without sign, and objects that may be any of them.
_REAL = "fiuO"


class Stored(Protocol):
    """An object that stands for a file: a map, a material, a calibration."""

    def _as_files(self, number: int) -> tuple[str, dict[str, bytes]]:
        """Name under which the object is read, unique by `number`, and contents of all files that it needs."""


class TableOfFile(Protocol):
    """A table that stands for a CSV file: a pandas frame."""

    @property
    def columns(self) -> Any: ...
    @property
    def to_csv(self) -> Callable[..., Any]: ...


#: What a key that names a file takes: a path, or an object in its place.
FileLike = Union[str, "PathLike[str]", Stored, TableOfFile]


@lru_cache(maxsize=None)
def _types(owner: type) -> dict[str, Any]:
    """Types of the fields of a record."""
    return typing.get_type_hints(owner)


def _typed(value: Any, kind: Any) -> Any:
    """`value` of a field as its type says: dictionaries as records, and an empty list where a list was left out."""
    inside = typing.get_args(kind)
    if value is None and typing.get_origin(kind) is list:
        return []
    if isinstance(value, list):
        return [_typed(item, inside[0] if inside else None) for item in value]
    if isinstance(value, dict):
        records = [own for own in (kind, *inside) if isinstance(own, type) and issubclass(own, Record)]
        return (records[0] if records else Record)(value)
    return value


class Record(Mapping[str, Any]):
    """A record whose fields are attributes as well as keys: ``found.design.width_um``, ``found["design"]["width_um"]``.

    Units stand in the names. An attribute that has no value is ``None``, a list without items is empty.
    """

    def __init__(self, fields: dict[str, Any]) -> None:
        self._fields = fields

    if not TYPE_CHECKING:
        # Type checkers know the fields from the annotations of subclasses alone.
        def __getattr__(self, name: str) -> Any:
            if name.startswith("_"):
                raise AttributeError(name)
            kinds = _types(type(self))
            if name not in self._fields and name not in kinds:
                known = sorted({*self._fields, *kinds})
                raise AttributeError(f"no field {name!r}: expected one of {', '.join(known)}")
            return _typed(self._fields.get(name), kinds.get(name))

    def __getitem__(self, name: str) -> Any:
        return self._fields[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._fields)

    def __len__(self) -> int:
        return len(self._fields)

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._fields]

    def __repr__(self) -> str:
        plain = [f"{name}={value!r}" for name, value in self._fields.items() if not isinstance(value, (dict, list))]
        return f"<{type(self).__name__} {', '.join(plain or self._fields)}>"

    def _repr_html_(self) -> str:
        return table([self._fields], [name for name, value in self._fields.items() if not isinstance(value, (dict, list))])

    def to_dict(self) -> dict[str, Any]:
        """A copy as plain dictionaries, lists, numbers and strings."""
        copy: dict[str, Any] = json.loads(json.dumps(self._fields))
        return copy


def array(rows: Sequence[Mapping[str, Any]], name: str) -> NDArray[np.float64]:
    """The field ``name`` of every row; NaN where there is no value."""
    return np.array([row.get(name) for row in rows], dtype=np.float64)


def pandas() -> ModuleType:
    """The package pandas, which only frames need."""
    try:
        return importlib.import_module("pandas")
    except ImportError as error:
        raise ImportError(f"frame() needs pandas ({error}): pip install pandas") from error


class Kept:
    """Text, warnings and inputs of a result, and its files. The compiled half of the result makes the files when they are asked for; a
    copy holds them, because in another process there is no compiled half."""

    def __init__(self, text: str, warnings: list[str], inputs: list[Path], compiled: Any = None) -> None:
        self.text, self.warnings, self.inputs, self.compiled = text, warnings, inputs, compiled
        self._files: list[tuple[str, bytes]] = []

    def files(self) -> list[tuple[str, bytes]]:
        """Names and contents of all files."""
        return self._files if self.compiled is None else list(self.compiled.files())

    def __getstate__(self) -> dict[str, Any]:
        return {**vars(self), "compiled": None, "_files": self.files()}


def frame(rows: Sequence[Mapping[str, Any]]) -> _pandas.DataFrame:
    """A frame of the plain numbers and words of ``rows``."""
    plain = [{name: value for name, value in row.items() if not isinstance(value, (dict, list))} for row in rows]
    found: _pandas.DataFrame = pandas().DataFrame(plain)
    return found


def table(rows: Sequence[Mapping[str, Any]], names: Sequence[str], caption: str = "") -> str:
    """An HTML table of ``names`` of every row, 50 at most."""

    def cell(value: Any) -> str:
        if value is None:
            return "-"
        return html.escape(f"{value:.4g}" if isinstance(value, float) else str(value)[:200])

    head = "".join(f"<th>{html.escape(name)}</th>" for name in names)
    body = "".join("<tr>" + "".join(f"<td>{cell(row.get(name))}</td>" for name in names) + "</tr>" for row in rows[:50])
    title = f"<caption>{html.escape(caption)}</caption>" if caption else ""
    return f"<table>{title}<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def check_count(name: str, count: int, max_count: int = MAX_NUMBERS, what: str = "numbers") -> None:
    """Refuses an array that is too large before it is copied."""
    if count > max_count:
        raise errors.TooLargeError(
            f"{name}: has {count} {what}; expected at most {max_count}",
            key=name,
            value=str(count),
            expected=f"at most {max_count}",
        )


def _size(given: Any) -> int:
    size = getattr(given, "size", 0)
    return int(size) if isinstance(size, (int, np.integer)) else 0


def real(name: str, given: ArrayLike, max_count: int = MAX_NUMBERS, what: str = "numbers") -> NDArray[np.float64]:
    """The argument ``name`` as an array of real numbers, NaN where they are masked."""
    typed: NDArray[Any] = np.asanyarray(given)
    check_count(name, typed.size, max_count, what)
    if type(typed) is np.ndarray and typed.dtype == np.float64:
        return typed
    if typed.dtype.kind not in _REAL:
        raise TypeError(f"{name} holds what is of the type {typed.dtype}; expected real numbers")
    try:
        return np.asarray(np.ma.filled(typed.astype(np.float64, copy=False), np.nan))
    except (TypeError, ValueError) as error:
        raise type(error)(f"{name}: {error}; expected real numbers") from None


def rows(**arguments: ArrayLike) -> tuple[NDArray[np.float64], tuple[int, ...]]:
    """The arguments broadcast against each other: an array with a column for each, and their common shape."""
    arrays = [real(name, given) for name, given in arguments.items()]
    try:
        shape = np.broadcast_shapes(*(own.shape for own in arrays))
    except ValueError:
        shapes = ", ".join(f"{name} {own.shape}" for name, own in zip(arguments, arrays))
        raise ValueError(f"shapes do not broadcast: {shapes}") from None
    check_count(", ".join(arguments), math.prod(shape), what="elements")
    columns = np.empty((*shape, len(arrays)))
    for place, own in enumerate(arrays):
        columns[..., place] = own
    return columns.reshape(-1, len(arrays)), shape


def by_pressure(pressure_mpa: ArrayLike, **lengths_um: ArrayLike) -> tuple[NDArray[np.float64], tuple[int, ...]]:
    """As :func:`rows`, with the pressures as the last axis, behind the common shape of the lengths; one pressure adds no axis."""
    pressures = real("pressure_mpa", pressure_mpa)
    if pressures.ndim > 1:
        raise ValueError(f"pressure_mpa has the shape {pressures.shape}: expected one number or shape (pressures,)")
    if pressures.ndim == 1:
        lengths_um = {name: np.expand_dims(np.asanyarray(own), -1) for name, own in lengths_um.items()}
    return rows(**lengths_um, pressure_mpa=pressures)


def heights(given: ArrayLike) -> NDArray[np.float64]:
    """``given`` as a matrix of heights, NaN where they are masked."""
    matrix = real("heights_m", given, _slipgrid.MAX_MAP_POINTS, "points")
    if matrix.ndim != 2:
        raise ValueError(f"heights_m has the shape {matrix.shape}; expected real numbers, shape (rows, columns)")
    return matrix


def floats(name: str, given: Any) -> list[float]:
    """The argument ``name`` as a list of numbers."""
    expected = f"{name} is {given!r:.80}: expected a list of numbers"
    if isinstance(given, (str, bytes, bytearray, memoryview, Mapping)):
        raise TypeError(expected)
    check_count(name, _size(given))
    try:
        return [float(number) for number in given]
    except (TypeError, ValueError):
        raise TypeError(expected) from None


def triples(name: str, given: Any) -> list[tuple[float, float, float]]:
    """The argument ``name`` as rows of width, spacing and depth."""
    if isinstance(given, (str, bytes, bytearray, memoryview, Mapping)) or not hasattr(given, "__iter__"):
        raise TypeError(f"{name} is {given!r:.80}: expected rows of width, spacing and depth")
    check_count(name, _size(given))
    found = []
    # A frame of pandas gives the names of its columns where rows are asked for.
    for place, row in enumerate(np.asanyarray(given) if hasattr(given, "__array__") else given):
        lengths = floats(f"{name}[{place}]", row)
        if len(lengths) != 3:
            raise ValueError(f"{name}[{place}] has {len(lengths)} numbers: expected width, spacing and depth")
        found.append((lengths[0], lengths[1], lengths[2]))
    return found


def write(files: Sequence[tuple[str, bytes]], folder: str | PathLike[str], inputs: Sequence[Path]) -> list[Path]:
    """Writes ``files`` into ``folder``, which is made where there is none; neither ``inputs`` nor files of others are replaced."""
    folder = Path(folder)
    _slipgrid.write_folder(files, folder, inputs)
    return [folder / name for name, _ in files]


def document(tables: Mapping[str, Any], folder: str | PathLike[str]) -> tuple[str, dict[str, bytes]]:
    """Text of ``tables`` as a file in ``folder``, and contents of the objects in them, by the paths at which the text looks for
    them."""
    objects: dict[str, bytes] = {}
    text = toml(tables, objects)
    return text, {str(Path(folder) / name): content for name, content in objects.items()}


def toml(tables: Mapping[str, Any], objects: dict[str, bytes] | None = None) -> str:
    """Nested dictionaries as TOML; their lists may be arrays, or what is like one. Objects that stand for files are put into
    ``objects``, by the name that the text has for them."""

    def quoted(text: str) -> str:
        return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")

    def bare(name: Any) -> str:
        return str(name) if re.fullmatch("[A-Za-z0-9_-]+", str(name)) else quoted(str(name))

    def named(item: Any, into: dict[str, bytes]) -> str:
        number = len(into) + 1
        if hasattr(item, "_as_files"):
            name, contents = item._as_files(number)
        else:
            name, contents = f"<table {number}>.csv", {}
            contents[name] = item.to_csv(index=False).encode()
        into.update(contents)
        return quoted(name)

    def value(at: str, item: Any) -> str:
        if hasattr(item, "_as_table"):
            item = item._as_table()
        if objects is not None and (hasattr(item, "_as_files") or (hasattr(item, "to_csv") and hasattr(item, "columns"))):
            return named(item, objects)
        if isinstance(item, Mapping):
            return "{ " + ", ".join(f"{bare(key)} = {value(f'{at}.{key}', own)}" for key, own in item.items()) + " }"
        if isinstance(item, (bool, np.bool_)):
            return "true" if item else "false"
        if isinstance(item, str):
            return quoted(item)
        if isinstance(item, PathLike):
            return quoted(str(Path(item)))
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
        check_count(at, _size(item))
        if isinstance(item, (Sequence, np.ndarray)) and not isinstance(item, (bytes, bytearray, memoryview)):
            return "[" + ", ".join(value(at, own) for own in item) + "]"
        raise TypeError(f"{at} is {item!r:.80}, which has no TOML form: expected numbers, strings, booleans, lists and dictionaries")

    is_table = {name: isinstance(item, Mapping) and not hasattr(item, "_as_table") for name, item in tables.items()}
    lines = [f"{bare(name)} = {value(name, item)}" for name, item in tables.items() if not is_table[name]]
    for name, item in tables.items():
        if is_table[name]:
            lines.append(f"[{bare(name)}]")
            lines.extend(f"{bare(key)} = {value(f'{name}.{key}', own)}" for key, own in item.items())
    return "\n".join(lines) + "\n"
