"""Results are the command line's, to the last bit."""

from __future__ import annotations

import copy as copies
import json
import math
import pickle
import sys
from pathlib import Path

import numpy as np
import pytest
import slipgrid
from conftest import DESIGN, ROOT, SCENE
from slipgrid._records import toml
from slipgrid.errors import ComputationError

SYNTHETIC = ROOT / "calibration" / "synthetic-polymer"


def copied(found, folder: Path) -> None:
    """A pickled copy, a copy of it, and a deep copy are what they are copies of, with the same files."""
    files = {path.name: path.read_bytes() for path in found.export(folder / "own")}
    pickled = pickle.loads(pickle.dumps(found))
    for place, copy in enumerate([pickled, pickle.loads(pickle.dumps(pickled)), copies.deepcopy(found)]):
        assert type(copy) is type(found) and str(copy) == str(found)
        assert {path.name: path.read_bytes() for path in copy.export(folder / f"copy-{place}")} == files
        if isinstance(found, slipgrid.Record):
            assert copy == found and copy.to_dict() == found.to_dict()


def test_records_are_copied() -> None:
    record = slipgrid.Record({"a": {"b": [1.5, None]}})
    assert pickle.loads(pickle.dumps(record)) == record == copies.deepcopy(record)


def test_frames_say_what_they_need(monkeypatch: pytest.MonkeyPatch) -> None:
    found = slipgrid.Scene(**SCENE).simulate()
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ImportError, match=r"frame\(\) needs pandas .*: pip install pandas$"):
        found.frame()


def test_a_scene_is_solved_as_by_the_command_line(program, tmp_path: Path) -> None:
    text = toml(SCENE)
    (tmp_path / "scene.toml").write_text(text)
    program("simulate", "scene.toml", "-o", "cli")
    expected = json.loads((tmp_path / "cli" / "result.json").read_text())
    for scene in (slipgrid.Scene(**SCENE), slipgrid.Scene.from_toml(text), slipgrid.Scene.read(tmp_path / "scene.toml")):
        found = scene.simulate()
        assert found.to_dict() == expected
    assert found.ratio.shape == (2,) and found.ratio[0] > found.ratio[1] > 0.5
    assert found.results[1].ratio == found["results"][1]["ratio"] == found.ratio[1]
    names = {path.name for path in found.export(tmp_path / "python")}
    # Beside the results stands the list of what was written.
    assert names == {path.name for path in (tmp_path / "cli").iterdir()} - {".slipgrid-written"}
    for name in names - {"timings.json"}:
        assert (tmp_path / "python" / name).read_bytes() == (tmp_path / "cli" / name).read_bytes(), name
    assert "<td>" in found._repr_html_() and "ratio" in str(found)
    copied(found, tmp_path)
    with pytest.raises(AttributeError, match="no field 'rato'"):
        found.rato


def test_a_design_is_found_as_by_the_command_line_with_any_number_of_threads(program, tmp_path: Path) -> None:
    # With a seed of its own: nothing of it is remembered from other tests.
    (tmp_path / "small.toml").write_text(toml({**DESIGN, "search": {"seed": 7}}))
    program("optimize", "small.toml", "-o", "cli")
    stages: list[tuple[str, float]] = []
    slipgrid.set_threads(1)
    found = slipgrid.Design.read(tmp_path / "small.toml").optimize(lambda stage, share: stages.append((stage, share)))
    slipgrid.set_threads(None)
    names = {path.name for path in found.export(tmp_path / "python")}
    # Beside the results stands the list of what was written.
    assert names == {path.name for path in (tmp_path / "cli").iterdir()} - {".slipgrid-written"}
    # The page tells seconds and threads.
    for name in names - {"timings.json", "report.html"}:
        assert (tmp_path / "python" / name).read_bytes() == (tmp_path / "cli" / name).read_bytes(), name
    assert any(stage.startswith("confirmation") for stage, _ in stages) and all(0.0 <= of <= 1.0 for _, of in stages)
    assert found.advice in ("trial", "cannot_be_met") and 0.0 <= found.chance <= 1.0
    assert found.expected[0].low_95 < found.expected[0].median < found.expected[0].high_95
    assert found.times.wall_s > 0.0 and list(found.frame().model_alone) == [at.ratio for at in found.modelled]
    assert found.drawing("dxf") == (tmp_path / "cli" / "pattern.dxf").read_bytes()
    with pytest.raises(ValueError, match="expected one of dxf, svg"):
        found.drawing("pdf")
    assert "width_um" not in found._repr_html_() and "small" in found._repr_html_() and "small" in str(found)
    copied(found, tmp_path)
    copy = pickle.loads(pickle.dumps(found))
    assert copy.headline == found.headline and copy.drawing("dxf") == found.drawing("dxf")
    assert copy.report_html() == found.report_html() and copy.times.wall_s == found.times.wall_s
    with pytest.raises(ComputationError, match="draw 'stl' with the result that was copied"):
        copy.drawing("stl")
    assert found.to_dict() == json.loads((tmp_path / "cli" / "result.json").read_text())


def test_a_calibration_and_its_trials_are_those_of_the_command_line(program, tmp_path: Path) -> None:
    calibration = slipgrid.Calibration.read(SYNTHETIC / "calibration.toml")
    expected = json.loads(program("trials", SYNTHETIC / "calibration.toml", "--json"))
    trials = calibration.trials()
    assert trials.to_dict() == expected and "patterned samples" in str(trials)
    program("calibrate", SYNTHETIC / "calibration.toml", "-o", "cli.toml", "--report", "report")
    material = calibration.fit()
    copied(material, tmp_path)
    assert copies.deepcopy(material).toml == material.toml and copies.deepcopy(material).fit == material.fit
    assert material.save(tmp_path / "python.toml").read_bytes() == (tmp_path / "cli.toml").read_bytes()
    assert material.fit.to_dict() == json.loads((tmp_path / "report" / "fit.json").read_text())
    # The material is one that scenes take.
    scene = slipgrid.Scene(**{**SCENE, "material": tmp_path / "python.toml"})
    assert scene.simulate().ratio[1] < 1.0


def test_the_samples_to_cut_next_are_those_of_the_command_line(program, tmp_path: Path) -> None:
    (tmp_path / "small.toml").write_text(toml(DESIGN))
    expected = json.loads(program("next", "small.toml", "--count", "2", "--candidate", "60,120,10", "--json"))
    found = slipgrid.Design.read(tmp_path / "small.toml").next(2, candidates_um=[(60, 120, 10)])
    assert found.to_dict() == expected and len(found.samples) == 2
    assert found.own[0].design.width_um == 60.0 and "next 2" in str(found)


def test_maps_are_measured_as_by_the_command_line(program, tmp_path: Path) -> None:
    program("synthesize", "--pixels", "64", "--waves", "2:16", "-o", "map.asc")
    path = tmp_path / "map.asc"
    made = slipgrid.Map.read(path)
    parameters = made.measure().to_dict()
    expected = json.loads(program("surface", path, "--json"))
    assert parameters == {**expected, "map": parameters["map"]}
    law = made.area_law(youngs_modulus_gpa=0.38, pressures_mpa=[0.7, 1.3, 2.6])
    expected = json.loads(
        program("area-law", path, "--youngs-modulus-gpa", "0.38", "--pressures-mpa", "0.7,1.3,2.6", "--json")
    )
    assert [row["area_fraction"] for row in expected["results"]] == law["area_fraction"]
    assert np.array_equal(law.factor, [row["factor"] for row in expected["results"]])
    assert made.is_synthetic and law.frame().shape == (3, 5)


def test_heights_cross_the_border_without_copies_and_unchanged() -> None:
    heights_m = 1e-6 * np.sin(np.arange(48.0)).reshape(6, 8)
    made = slipgrid.Map(heights_m, pixel_um=0.5, pixel_y_um=0.25)
    assert np.array_equal(made.heights_m, heights_m) and made.pixel_um == (0.5, 0.25)
    assert np.shares_memory(made.heights_m, made.heights_m)
    with pytest.raises(ValueError, match="read-only"):
        made.heights_m[0, 0] = 1.0
    # The view holds on to the map; a transposed array is read by its own order.
    view = slipgrid.Map(heights_m.T, pixel_um=0.5).heights_m
    assert np.array_equal(view, heights_m.T) and repr(made).startswith("<slipgrid.Map 6 x 8")
    heights_m[2, 3] = math.nan
    assert np.isnan(slipgrid.Map(heights_m, pixel_um=0.5).heights_m[2, 3])


def test_a_steady_cell_gives_what_simulate_gives() -> None:
    scene = slipgrid.Scene(**SCENE)
    cell = scene.steady()
    # To rounding: simulate multiplies friction and divides again.
    assert np.allclose(cell.ratio(130.0, 370.0, 20.0), scene.simulate().ratio, rtol=1e-14, atol=0.0)
    many = cell.ratio([130.0, 100.0], [370.0, 200.0], [20.0, 10.0])
    assert many.shape == (2, 2) and np.array_equal(many[0], cell.ratio(130.0, 370.0, 20.0))
    with pytest.raises(ValueError):
        cell.ratio(-1.0, 370.0, 20.0)


def test_frames_have_a_row_for_each_load() -> None:
    pandas = pytest.importorskip("pandas")
    frame = slipgrid.Scene(**SCENE).simulate().frame()
    assert isinstance(frame, pandas.DataFrame) and list(frame["pressure_mpa"]) == [0.65, 2.6]


def test_the_page_with_sliders_is_that_of_the_command_line(program, tmp_path: Path) -> None:
    (tmp_path / "small.toml").write_text(toml(DESIGN))
    program("explore", "small.toml", "-o", "own.html")
    page = slipgrid.Design.read(tmp_path / "small.toml").explore(tmp_path / "page.html")
    assert page.read_bytes() == (tmp_path / "own.html").read_bytes()
