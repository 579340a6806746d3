"""Records: what a computation found, with the field names of result.json."""

from __future__ import annotations

import html
import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

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


def frame(rows: Sequence[Mapping[str, Any]]) -> _pandas.DataFrame:
    """A frame of the plain numbers and words of ``rows``."""
    import pandas

    plain = [{name: value for name, value in row.items() if not isinstance(value, (dict, list))} for row in rows]
    return pandas.DataFrame(plain)


def table(rows: Sequence[Mapping[str, Any]], names: Sequence[str]) -> str:
    """An HTML table of ``names`` of every row."""

    def cell(value: Any) -> str:
        if value is None:
            return "-"
        return html.escape(f"{value:.5g}" if isinstance(value, float) else str(value))

    head = "".join(f"<th>{html.escape(name)}</th>" for name in names)
    body = "".join("<tr>" + "".join(f"<td>{cell(row.get(name))}</td>" for name in names) + "</tr>" for row in rows)
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def write(files: Sequence[tuple[str, bytes]], folder: str | Path) -> list[Path]:
    """Writes ``files`` into ``folder``, which is made where there is none."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for name, content in files:
        path = folder / name
        path.write_bytes(content)
        paths.append(path)
    return paths


def toml(tables: Mapping[str, Any]) -> str:
    """Nested dictionaries as TOML."""

    def value(item: Any) -> str:
        if isinstance(item, Mapping):
            return "{ " + ", ".join(f"{json.dumps(str(key))} = {value(own)}" for key, own in item.items()) + " }"
        if isinstance(item, bool):
            return "true" if item else "false"
        if isinstance(item, str):
            return json.dumps(item, ensure_ascii=False)
        if isinstance(item, Path):
            return json.dumps(str(item), ensure_ascii=False)
        if isinstance(item, (int, np.integer)):
            return str(int(item))
        if isinstance(item, (float, np.floating)):
            return repr(float(item))
        if isinstance(item, (Sequence, np.ndarray)):
            return "[" + ", ".join(value(own) for own in item) + "]"
        raise TypeError(f"{item!r} has no TOML form: expected numbers, strings, booleans, lists and dictionaries")

    lines = []
    for name, item in tables.items():
        if not isinstance(item, Mapping):
            lines.append(f"{name} = {value(item)}")
    for name, item in tables.items():
        if isinstance(item, Mapping):
            lines.append(f"[{name}]")
            lines.extend(f"{key} = {value(own)}" for key, own in item.items())
    return "\n".join(lines) + "\n"
