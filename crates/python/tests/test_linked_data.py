"""result.jsonld expands without a network, to terms of schema.org and of tribAIn."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import slipgrid
from conftest import DESIGN, ROOT

SCHEMA = "https://schema.org/"
#: Address of the folder of the document, for the names of its files.
BASE = "https://example.org/folder/"
TRIBAIN = "http://ktmfk.de/ontology/tribAIn/"


def expanded(path: Path) -> dict[str, Any]:
    """The document at ``path``, expanded; fails where it asks for the network."""
    jsonld = pytest.importorskip("pyld.jsonld")

    def refuse(url: str, options: object = None) -> None:
        raise AssertionError(f"asked for {url}")

    (found,) = jsonld.expand(json.loads(path.read_text(encoding="utf-8")), {"documentLoader": refuse, "base": BASE})
    return found


def keys(value: Any) -> Iterator[str]:
    if isinstance(value, dict):
        for key, inner in value.items():
            yield key
            yield from keys(inner)
    elif isinstance(value, list):
        for inner in value:
            yield from keys(inner)


def first(node: dict[str, Any], term: str) -> Any:
    """First value of a property of a node."""
    value = node[SCHEMA + term][0]
    return value.get("@value", value.get("@id", value))


def test_a_design_is_a_data_set_with_its_values(tmp_path: Path) -> None:
    found = slipgrid.Design(**DESIGN).optimize()
    found.export(tmp_path)
    node = expanded(tmp_path / "result.jsonld")
    assert node["@type"] == [SCHEMA + "Dataset"] and first(node, "name") == "small"
    assert all(key.startswith((SCHEMA, "@")) for key in keys(node)), set(keys(node))
    values = {first(own, "name"): own for own in node[SCHEMA + "variableMeasured"]}
    assert first(values["width of a cavity"], "value") == found.design.width_um
    assert first(values["width of a cavity"], "unitCode") == "4H"
    expected = values["expected ratio of dynamic friction, textured over flat"]
    assert first(expected, "value") == pytest.approx(found.expected[0].median)
    reference = {first(own, "propertyID"): own for own in expected[SCHEMA + "valueReference"]}
    assert set(reference) == {TRIBAIN + term for term in ("ContactPressure", "Speed", "RelativeHumidity")}
    assert first(reference[TRIBAIN + "ContactPressure"], "value") == 2.6
    files = {first(own, "contentUrl").removeprefix(BASE) for own in node[SCHEMA + "distribution"]}
    assert {"result.json", "pattern.dxf", "uncertainty.csv"} <= files and all((tmp_path / name).is_file() for name in files)


def test_a_ledger_is_a_data_set_with_its_measured_ratios(program: Any, tmp_path: Path) -> None:
    calibration = ROOT / "calibration" / "synthetic-polymer" / "calibration.toml"
    program("trials", calibration, "-o", "ledger")
    node = expanded(tmp_path / "ledger" / "result.jsonld")
    ledger = json.loads((tmp_path / "ledger" / "result.json").read_text())
    measured = [row["measured"] for trial in ledger["trials"] for row in trial["measured"]]
    assert node["@type"] == [SCHEMA + "Dataset"] and len(measured) > 0
    assert [first(own, "value") for own in node[SCHEMA + "variableMeasured"]] == pytest.approx(measured)
    sheet = (tmp_path / "ledger" / "friction-sheet.md").read_text(encoding="utf-8")
    assert "| repeats of a condition |" in sheet and "- Counterface: material (counterface_material in [reporting])" in sheet
