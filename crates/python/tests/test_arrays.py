"""Arrays, lists and series stand for each other, and their types say so: `check` has this file checked by mypy."""

from __future__ import annotations

import numpy as np
import pytest
import slipgrid
from conftest import DESIGN, SCENE
from slipgrid import campaign


def test_pressures_are_a_list_an_array_or_a_series() -> None:
    surface = slipgrid.Map(1e-7 * np.random.default_rng(0).standard_normal((32, 32)), 1.0)
    pandas = pytest.importorskip("pandas")
    expected = surface.area_law(youngs_modulus_gpa=0.38, pressures_mpa=[0.7, 1.3], windows=1)
    array = np.array([0.7, 1.3])
    assert surface.area_law(youngs_modulus_gpa=0.38, pressures_mpa=array, windows=1) == expected
    assert surface.area_law(youngs_modulus_gpa=0.38, pressures_mpa=pandas.Series(array), windows=1) == expected


def test_candidates_are_rows_of_a_list_an_array_or_a_frame() -> None:
    design = slipgrid.Design(**DESIGN)
    pandas = pytest.importorskip("pandas")
    rows = [[80.0, 120.0, 10.0], [60.0, 100.0, 5.0]]
    array = np.array(rows)
    expected = design.next(1, rows)
    assert len(expected["own"]) == 2
    assert design.next(1, array) == design.next(1, tuple(map(tuple, rows))) == expected
    assert design.next(1, pandas.DataFrame(array, columns=["width_um", "spacing_um", "depth_um"])) == expected
    for wrong in ("abc", 1.0):
        with pytest.raises(TypeError, match="candidates_um is .*: expected rows of width, spacing and depth"):
            design.next(1, wrong)


def test_tables_take_arrays_and_series() -> None:
    pandas = pytest.importorskip("pandas")
    expected = slipgrid.Scene(**SCENE).simulate()
    for pressures in (np.array([0.65, 2.6]), pandas.Series([0.65, 2.6])):
        assert slipgrid.Scene(**{**SCENE, "load": {"pressure_mpa": pressures, "speed_mm_s": 2.0}}).simulate() == expected
    with pytest.raises(TypeError, match="load.pressure_mpa is .*which has no TOML form"):
        slipgrid.Scene(**{**SCENE, "load": {"pressure_mpa": pandas.Series(pandas.to_datetime(["2024-01-01"]))}})


def width_um(task: campaign.Task) -> float:
    """A value of a task, as an attribute of a known type."""
    return float(task.values["pattern.width_um"])
