"""What the command line warns of, Python warns of, where the caller's line stands; results keep it."""

from __future__ import annotations

import pickle
import re
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import slipgrid
from conftest import DESIGN, SCENE
from slipgrid._records import toml
from slipgrid.errors import CostWarning, InputError, SlipgridWarning, TooLargeError

#: A modulus that hardly any solid has: unusual, and read.
UNUSUAL = {**SCENE, "load": {"pressure_mpa": [0.65, 60.0], "speed_mm_s": 2.0}}


def told(made: Callable[[], object]) -> list[warnings.WarningMessage]:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        made()
    return caught


def test_a_scene_warns_where_it_is_read_and_where_it_is_solved(program: Callable[..., str], tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(toml(UNUSUAL))
    made: list[slipgrid.Scene] = []
    of_reading = told(lambda: made.append(slipgrid.Scene.read(tmp_path / "scene.toml")))
    assert [str(own.message) for own in of_reading] == made[0].warnings
    solved: list[slipgrid.SimulationResult] = []
    of_solving = told(lambda: solved.append(made[0].simulate()))
    found = solved[0]
    marked = re.findall("^! (.*)$", program("simulate", "scene.toml"), re.MULTILINE)
    assert marked and [str(own.message) for own in of_solving] == marked
    assert found.warnings == made[0].warnings + marked
    assert pickle.loads(pickle.dumps(found)).warnings == found.warnings
    for own in of_reading + of_solving:
        assert own.category is SlipgridWarning and own.filename == __file__
    # A copy is no second reading.
    assert not told(lambda: pickle.loads(pickle.dumps(made[0])))


def test_a_design_warns_of_what_its_text_marks() -> None:
    design = slipgrid.Design(**{**DESIGN, "sample": {"layer_um": 100.0, "block_um": 20.0}})
    found: list[slipgrid.DesignResult] = []
    caught = told(lambda: found.append(design.optimize()))
    marked = re.findall("^! (.*)$", str(found[0]), re.MULTILINE)
    assert found[0].warnings == design.warnings + marked
    assert [str(own.message) for own in caught if own.category is not CostWarning] == marked
    samples: list[slipgrid.NextSamples] = []
    caught = told(lambda: samples.append(design.next(1)))
    marked = re.findall("^! (.*)$", str(samples[0]), re.MULTILINE)
    assert samples[0].warnings == design.warnings + marked
    assert [str(own.message) for own in caught if own.category is not CostWarning] == marked


def test_a_map_warns_of_its_own() -> None:
    spiked = 1e-8 * np.random.default_rng(0).standard_normal((64, 64))
    spiked[5, 5] = 1e-5
    found: list[slipgrid.Surface] = []
    caught = told(lambda: found.append(slipgrid.Map(spiked, 1.0).measure()))
    assert found[0].warnings and [str(own.message) for own in caught] == found[0].warnings


def test_warnings_may_be_errors() -> None:
    scene = slipgrid.Scene(**SCENE)
    with warnings.catch_warnings():
        warnings.simplefilter("error", SlipgridWarning)
        with pytest.raises(SlipgridWarning):
            slipgrid.Scene(**UNUSUAL).simulate()
        scene.simulate()


def test_a_map_is_as_its_file_has_it(program: Callable[..., str], tmp_path: Path) -> None:
    """Waves along x, from column to column, in a file and in an array, whatever order the array has."""
    y, x = np.mgrid[0:12, 0:40]
    heights_m = 1e-7 * np.sin(2 * np.pi * x / 8) + 1e-9 * y
    np.savetxt(tmp_path / "map.txt", heights_m * 1e9, header="Value units: nm")
    read = slipgrid.Map.read(tmp_path / "map.txt", pixel_um=2.0)
    assert read.heights_m.shape == (12, 40) and np.allclose(read.heights_m, heights_m, rtol=1e-12, atol=0.0)
    for own in (heights_m, np.asfortranarray(heights_m), np.repeat(heights_m, 2, axis=0)[::2]):
        given = slipgrid.Map(own, 2.0)
        assert np.array_equal(given.heights_m, heights_m)
        assert np.allclose(given.measure()["parameters"]["sdq"], read.measure()["parameters"]["sdq"], rtol=1e-9)
    oblong = slipgrid.Map(heights_m, 0.5, 3.0)
    assert oblong.pixel_um == (0.5, 3.0)
    copy = pickle.loads(pickle.dumps(oblong))
    assert np.array_equal(copy.heights_m, heights_m) and copy.pixel_um == (0.5, 3.0)


@pytest.mark.parametrize("kind", [np.float64, np.int8])
@pytest.mark.parametrize("shape", [(10**5, 10**6), (2, 10**9), (2 * 10**4, 2 * 10**4)])
def test_what_is_too_large_is_refused_before_it_is_copied(kind: type, shape: tuple[int, int]) -> None:
    huge = np.broadcast_to(np.zeros((1, 1), dtype=kind), shape)
    with pytest.raises(TooLargeError, match="heights_m.*points.*expected at most") as refused:
        slipgrid.Map(huge, 1.0)
    assert isinstance(refused.value, MemoryError) and isinstance(refused.value, InputError)


def test_no_other_array_is_copied_out_either() -> None:
    cell = slipgrid.Scene(**SCENE).steady()
    with pytest.raises(MemoryError, match="width_um: has 10000000000 numbers"):
        cell.ratio(np.broadcast_to(np.ones(1), (10**10,)), 100.0, 10.0)
    with pytest.raises(MemoryError, match="width_um, spacing_um, depth_um, pressure_mpa: has .* elements"):
        cell.ratio(np.ones((10**4, 1)), np.ones((1, 10**4)), 10.0)
    many = np.broadcast_to(np.ones(1), (10**10,))
    with pytest.raises(MemoryError, match="load.pressure_mpa"):
        slipgrid.Scene(**{**SCENE, "load": {"pressure_mpa": many, "speed_mm_s": 2.0}})
    with pytest.raises(MemoryError, match="pressures_mpa"):
        slipgrid.Map(np.zeros((8, 8)), 1.0).area_law(youngs_modulus_gpa=1.0, pressures_mpa=many)
    with pytest.raises(MemoryError, match="candidates_um"):
        slipgrid.Design(**DESIGN).next(1, np.broadcast_to(np.ones((1, 3)), (10**10, 3)))
