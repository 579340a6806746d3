"""Types of results, repr and HTML, and the examples of the docstrings."""

from __future__ import annotations

import doctest
import importlib
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import slipgrid
from conftest import DESIGN, MATERIAL, ROOT, SCENE
from slipgrid._records import toml

#: Most characters of what a notebook shows of a result.
MAX_HTML = 30_000


def test_types_are_generated_from_the_schemas(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(ROOT / "crates" / "python"))
    made = importlib.import_module("make_types")
    assert made.TARGET.read_text(encoding="utf-8") == made.generated(), "out of date: python make_types.py"


def test_a_misspelt_field_or_key_fails_the_type_check(tmp_path: Path) -> None:
    pytest.importorskip("mypy")
    lines = [
        ("found.design.width_um + 1.0", ""),
        ("found.desing", "has no attribute"),
        ("found.design.widht_um", "has no attribute"),
        ("found.expected[0].median.real", ""),
        ("found.expected[0].target_low + 1.0", "Unsupported operand"),
        ("slipgrid.Scene(material='m.toml', load={'pressure_mpa': 1.0}, pattern={'planform': 'grove'})", "Incompatible types"),
        ("slipgrid.Scene(material=material, load={'pressure_mpa': np.ones(2)})", ""),
        ("slipgrid.Design(material=material, bonds={})", "Unexpected keyword"),
        ("material.ratio(1.0, [1.0, 2.0], np.ones(3), 1.0, sample={'block_um': 5.0}).sum()", ""),
        ("material.ratio(1.0, 1.0, 1.0, 1.0, sampel={})", "Unexpected keyword"),
    ]
    head = "import numpy as np\nimport slipgrid\n\ndef use(found: slipgrid.DesignResult, material: slipgrid.Material) -> None:\n"
    (tmp_path / "used.py").write_text(head + "".join(f"    {line}\n" for line, _ in lines))
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "used.py"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    said = {int(line.split(":")[1]) - 5: line for line in done.stdout.splitlines() if line.startswith("used.py:") and "error" in line}
    for place, (line, expected) in enumerate(lines):
        assert expected in said.get(place, "") and bool(expected) == (place in said), f"{line}: {done.stdout}"


def test_records_have_types_and_values_left_out_are_none() -> None:
    found = slipgrid.Scene(**SCENE).simulate()
    assert isinstance(found.results[0], slipgrid.types.LoadResult) and isinstance(found.pattern, slipgrid.types.Pattern)
    assert found.results[0].mu_static is None and found.pattern.vertices_um == []
    assert "results" in dir(found) and "ratio" in dir(found.results[0])
    with pytest.raises(AttributeError, match="no field 'rato': expected one of .*ratio"):
        found.results[0].rato  # type: ignore[attr-defined]


@pytest.fixture(scope="module")
def shown() -> list[object]:
    """One object of every kind."""
    calibration = slipgrid.Calibration.read(ROOT / "calibration" / "synthetic-polymer" / "calibration.toml")
    design = slipgrid.Design(**DESIGN)
    surface = slipgrid.Map(1e-7 * np.random.default_rng(0).standard_normal((64, 64)), 1.0)
    scene = slipgrid.Scene(**SCENE)
    widths_um = np.linspace(40.0, 100.0, 1000)
    return [
        calibration,
        calibration.fit(),
        calibration.trials(),
        slipgrid.Material.from_toml(toml(MATERIAL)),
        design,
        design.predict(widths_um, 100.0, 10.0),
        design.optimize(),
        design.next(2),
        surface,
        surface.measure(),
        surface.area_law(youngs_modulus_gpa=0.38, windows=1),
        scene,
        scene.steady(),
        scene.simulate(),
    ]


@pytest.mark.filterwarnings("ignore::slipgrid.errors.SlipgridWarning")
def test_every_object_says_what_it_is_in_a_line_and_in_little_html(shown: list[object]) -> None:
    for own in shown:
        line = repr(own)
        assert line.startswith("<") and " " in line and "\n" not in line and len(line) < 300, line
        html: Callable[[], str] | None = getattr(own, "_repr_html_", None)
        if html is not None:
            assert 10 < len(html()) < MAX_HTML and "None" not in html(), type(own)


@pytest.mark.filterwarnings("ignore::slipgrid.errors.SlipgridWarning")
def test_results_draw_themselves_on_given_axes(shown: list[object]) -> None:
    pyplot = pytest.importorskip("matplotlib.pyplot")
    pyplot.switch_backend("agg")
    drawn = 0
    for own in shown:
        if isinstance(own, slipgrid.Prediction):
            with pytest.raises(ValueError, match=r"have the shape \(1000,\): choose one"):
                own.plot()
            own = own[3]
        plot = getattr(own, "plot", None)
        if plot is not None:
            figure, ax = pyplot.subplots()
            assert plot(ax) is ax and ax.get_xlabel() and ax.has_data(), type(own)
            assert plot().figure is not figure
            drawn += 1
            pyplot.close("all")
    assert drawn == 7


@pytest.mark.filterwarnings("ignore::slipgrid.errors.SlipgridWarning")
@pytest.mark.parametrize("name", ["_designs", "_maps", "_materials", "_scenes"])
def test_the_examples_of_docstrings_run(name: str) -> None:
    failed, run = doctest.testmod(importlib.import_module(f"slipgrid.{name}"))
    assert run > 0 and failed == 0


def test_public_functions_have_docstrings_and_types() -> None:
    import inspect

    for name in slipgrid.__all__:
        own = getattr(slipgrid, name)
        for member, value in inspect.getmembers(own) if inspect.isclass(own) else []:
            if not member.startswith("_") and inspect.isfunction(value) and value.__module__.startswith("slipgrid"):
                assert value.__doc__ and value.__annotations__, f"{name}.{member}"
