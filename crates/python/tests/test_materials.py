"""Arrays of textures: they broadcast, agree with scenes and pages, and come from the table in less than a second."""

from __future__ import annotations

import pickle
import threading
import time
from pathlib import Path

import numpy as np
import pytest
import slipgrid
from conftest import DESIGN, MATERIAL, ROOT, SCENE
from slipgrid._records import toml
from slipgrid.errors import InputError, SlipgridWarning

SAMPLE = SCENE["sample"]


@pytest.fixture
def material() -> slipgrid.Material:
    return slipgrid.Material.from_toml(toml(MATERIAL))


def test_arrays_broadcast_and_agree_with_a_scene(material: slipgrid.Material) -> None:
    widths_um, pressures_mpa = np.array([100.0, 130.0, np.nan]), [0.65, 2.6]
    grid = material.ratio(widths_um, 370.0, 20, pressures_mpa, sample=SAMPLE)
    assert grid.shape == (3, 2) and np.isnan(grid[2]).all() and not np.isnan(grid[:2]).any()
    solved = slipgrid.Scene(**SCENE).simulate()
    assert np.allclose(grid[1], solved.ratio, rtol=1e-14, atol=0.0)
    assert np.allclose(material.mu(130.0, 370.0, 20.0, pressures_mpa, sample=SAMPLE), solved.mu_dynamic, rtol=1e-14, atol=0.0)
    peak = material.peak_pressure(130.0, 370.0, 20.0, pressures_mpa, sample=SAMPLE)
    assert np.allclose(peak, [row.peak_pressure_mpa for row in solved.results], rtol=1e-11, atol=0.0)
    one = material.ratio(130.0, 370.0, 20.0, 2.6, sample=SAMPLE)
    assert one.shape == () and one == grid[1, 1]
    # Pressures are the last axis, whatever the shape of the lengths.
    many = material.ratio([[130.0], [100.0]], [370.0, 200.0], 20.0, pressures_mpa, sample=SAMPLE)
    assert many.shape == (2, 2, 2) and np.array_equal(many[:, 0], grid[[1, 0]])
    assert material.ratio([], 370.0, 20.0, 1.0).shape == (0,)
    cell = slipgrid.Scene(**SCENE).steady()
    assert np.array_equal(cell.ratio([130.0, 100.0], 370.0, 20.0, pressures_mpa), cell.ratio([130.0, 100.0], 370.0, 20.0))
    with pytest.raises(ValueError, match=r"pressure_mpa has the shape \(1, 2\): expected one number or shape \(pressures,\)"):
        material.ratio(130.0, 370.0, 20.0, [pressures_mpa])
    squares = material.ratio(130.0, 370.0, 20.0, 2.6, sample={"layer_um": 40, "block_um": 20}, pattern={"planform": "square"})
    assert 0.9 < squares < 1.0


def test_what_a_material_does_not_bear_is_refused(material: slipgrid.Material) -> None:
    with pytest.raises(InputError, match="out of range") as refused:
        material.ratio(-130.0, 370.0, 20.0, 2.6)
    assert refused.value.key == "pattern.width_um"
    with pytest.raises(InputError, match="width_um, spacing_um, depth_um: 130, 370, -20"):
        material.ratio(130.0, 370.0, [20.0, -20.0], 2.6)
    with pytest.raises(InputError, match="planform"):
        material.ratio(130.0, 370.0, 20.0, 2.6, pattern={"planform": "round"})  # type: ignore[typeddict-item]
    with pytest.raises(InputError, match="material.toml:1: youngs_modulus_gpa"):
        slipgrid.Material.from_toml("youngs_modulus_gpa = -1.0\ndensity_g_cm3 = 1.0\nfriction = {static_mean = 0.3, dynamic_mean = 0.27}")


def test_pressures_beyond_those_measured_are_warned_of_where_the_caller_stands() -> None:
    rows = {"pressure_mpa": [0.6, 2.6], "static_mean": [0.30, 0.32], "dynamic_mean": [0.27, 0.29]}
    condition: slipgrid.types.ConditionTable = {"speed_mm_s": 2.0, "humidity_pct": 15.0}
    material = slipgrid.Material.from_toml(toml({**MATERIAL, "friction": {"conditions": [{**condition, **rows}]}}))
    with pytest.warns(SlipgridWarning, match="^at 0.1, 20 MPa outside the measured range") as warned:
        material.ratio(130.0, 370.0, 5.2, [0.1, 1.3, 20.0], condition=condition)
    assert [own.filename for own in warned if "outside" in str(own.message)] == [__file__]
    with pytest.raises(InputError, match="condition"):
        material.ratio(130.0, 370.0, 5.2, 1.3)


def test_predictions_are_those_of_the_design_that_was_found() -> None:
    """The lattice of a page agrees with the prediction that `next` computes for the same textures."""
    design = slipgrid.Design(**DESIGN)
    found = design.predict([60.0, 80.0, np.nan], [100.0, 120.0, 100.0], 10.0)
    assert found.median.shape == (3, 1) and found.chance.shape == (3,) and found.pressure_mpa.tolist() == [2.6]
    assert np.isnan(found.median[2]).all() and np.isnan(found.chance[2])
    own = design.next(1, [(60, 100, 10), (80, 120, 10)]).own
    for place, sample in enumerate(own):
        # The ends of the disc of 2 mm and sliding in time are solved for these textures; the lattice takes those of its best.
        assert found.median[place, 0] == pytest.approx(sample.expected[0].median, abs=0.01)
        assert found.low_95[place, 0] == pytest.approx(sample.expected[0].low_95, abs=0.002)
        assert found.chance[place] == pytest.approx(sample.chance, abs=0.003)
    assert found.quantity == "ratio" and 0.0 < found.median_error < found.max_error < 0.05
    pytest.importorskip("pandas")
    assert len(found.frame()) == 3 and found[1].frame()["width_um"].tolist() == [80.0]


def test_a_material_predicts_as_its_design_does(material: slipgrid.Material) -> None:
    widths_um = np.linspace(40.0, 100.0, 4)
    found = material.predict(widths_um[:, None], [40.0, 200.0], 10.0, 2.6, band=(0.86, 0.90), sample=DESIGN["sample"], specimen=DESIGN["specimen"])
    bounds = {"width_um": [40.0, 100.0], "spacing_um": [40.0, 200.0], "depth_um": 10.0}
    target = {"quantity": "ratio", "pressure_mpa": 2.6, "lowest": 0.86, "highest": 0.90}
    tables = {**DESIGN, "material": material, "bounds": bounds, "target": target}
    del tables["tolerances"]
    expected = slipgrid.Design(**tables).predict(widths_um[:, None], [40.0, 200.0], 10.0)
    assert found.median.shape == (4, 2, 1) and np.array_equal(found.median, expected.median)
    assert np.array_equal(found.chance, expected.chance) and (found.chance > 0.0).all()
    assert np.isnan(material.predict(widths_um, 100.0, 10.0, 2.6, sample=DESIGN["sample"]).chance).all()


@pytest.mark.alone
def test_a_hundred_thousand_textures_come_from_the_table_in_a_second_beside_another_thread() -> None:
    design = slipgrid.Design(**DESIGN)
    design.predict(60.0, 100.0, 10.0)
    random = np.random.default_rng(0)
    lengths = [random.uniform(*ends, 100_000) for ends in DESIGN["bounds"].values()]
    ticks, done = [0], threading.Event()

    def count() -> None:
        while not done.wait(0.002):
            ticks[0] += 1

    counter = threading.Thread(target=count)
    counter.start()
    started = time.monotonic()
    found = design.predict(*lengths)
    took_s = time.monotonic() - started
    done.set()
    counter.join()
    print(f"{took_s:.2f} s for 100000 textures")
    assert took_s < 1.0 and found.chance.shape == (100_000,) and ticks[0] > 10


def test_objects_stand_where_files_are_named(material: slipgrid.Material, tmp_path: Path) -> None:
    path = material.save(tmp_path / "material.toml")
    assert slipgrid.Material.read(path).toml == material.toml
    named = slipgrid.Scene(**{**SCENE, "material": path})
    given = slipgrid.Scene(**{**SCENE, "material": material}, folder=tmp_path)
    assert given.simulate().to_dict() == named.simulate().to_dict()
    assert pickle.loads(pickle.dumps(given)).simulate().to_dict() == named.simulate().to_dict()
    assert pickle.loads(pickle.dumps(material)).toml == material.toml
    broken = slipgrid.Material("youngs_modulus_gpa = 1", "broken", [])
    with pytest.raises(InputError, match="^<material 1>.toml:1: density_g_cm3"):
        slipgrid.Scene(**{**SCENE, "material": broken})


@pytest.mark.filterwarnings("ignore::slipgrid.errors.SlipgridWarning")
def test_a_map_a_table_and_a_calibration_stand_where_files_are_named(tmp_path: Path) -> None:
    pandas = pytest.importorskip("pandas")
    random = np.random.default_rng(1)
    heights_m = 1e-7 * np.fft.irfft2(np.fft.rfft2(random.standard_normal((32, 32)))[:, :6], s=(32, 32))
    surface, rows = slipgrid.Map(heights_m, 0.7, 0.9), {"force_n": [50.0, 200.0], "speed_mm_s": [2.0] * 2, "humidity_pct": [50.0] * 2, "mu_dynamic": [0.25, 0.24], "mu_dynamic_std": [0.01, 0.01]}
    np.save(tmp_path / "map.npy", heights_m)
    flat = pandas.DataFrame(rows)
    flat.to_csv(tmp_path / "flat.csv", index=False)
    shared = {"name": "own", "source": "here", "material": {"youngs_modulus_gpa": 0.38, "density_g_cm3": 0.9}, "specimen": {"radius_mm": 5.0}}
    read = slipgrid.Map.read(tmp_path / "map.npy", pixel_um=0.7, pixel_y_um=0.9, height_unit="m")
    assert np.array_equal(read.heights_m, heights_m) and read.pixel_um == surface.pixel_um
    of_files = {"map": "map.npy", "pixel_um": 0.7, "pixel_y_um": 0.9, "height_unit": "m", "windows": 1}
    named = slipgrid.Calibration(**shared, surface=of_files, measurements={"flat": "flat.csv"}, folder=tmp_path)
    given = slipgrid.Calibration(**shared, surface={"map": surface, "windows": 1}, measurements={"flat": flat})
    assert given.fit().fit == named.fit().fit
    assert pickle.loads(pickle.dumps(given)).fit().fit == named.fit().fit
    condition = {"speed_mm_s": 2.0, "humidity_pct": 50.0}
    tables = {**DESIGN, "condition": condition, "material": given}
    assert slipgrid.Design(**tables).predict(60.0, 100.0, 10.0).median > 0.5
    assert slipgrid.Design(**{**tables, "material": given.fit()}).predict(60.0, 100.0, 10.0).median > 0.5


def test_an_area_law_stands_in_a_material(tmp_path: Path) -> None:
    surface = slipgrid.Map.read(ROOT / "calibration" / "ldpe-cast-iron" / "flat-map.asc")
    law = surface.area_law(youngs_modulus_gpa=0.38, pressures_mpa=[0.7, 1.3, 2.6, 8.0])
    found = slipgrid.Scene(**{**SCENE, "material": {**MATERIAL, "area_law": law}}).simulate()
    plain = {"pressure_mpa": law.pressure_mpa, "factor": law.factor}
    expected = slipgrid.Scene(**{**SCENE, "material": {**MATERIAL, "area_law": plain}}).simulate()
    assert np.array_equal(found.ratio, expected.ratio) and (found.ratio < 1.0).all()


def test_maps_are_cropped_and_decimated_as_by_the_command_line(program, tmp_path: Path) -> None:
    import json

    path = ROOT / "calibration" / "ldpe-cast-iron" / "flat-map.asc"
    flags = ["--crop", "16,32,256,128", "--decimate", "2", "--decimate-by", "pick"]
    expected = json.loads(program("surface", path, "--json", *flags))
    read = slipgrid.Map.read(path, crop=[16, 32, 256, 128], decimate=2, decimate_by="pick")
    assert read.heights_m.shape == (128, 64)
    assert read.measure().parameters.to_dict() == expected["parameters"]
    whole = slipgrid.Map.read(path).heights_m
    assert np.array_equal(read.heights_m, whole[16:272:2, 32:160:2])
    with pytest.raises(ValueError, match="decimate_by is .* expected one of mean, pick"):
        slipgrid.Map.read(path, decimate=2, decimate_by="first")  # type: ignore[arg-type]


def test_results_are_kept_in_a_folder_or_not_at_all(tmp_path: Path) -> None:
    design = {**DESIGN, "search": {"seed": 11}, "material": {**MATERIAL, "youngs_modulus_gpa": 0.381}}
    try:
        slipgrid.set_cache(None)
        expected = slipgrid.Design(**design).predict(60.0, 100.0, 10.0).median
        assert not any(tmp_path.rglob("*.kept"))
        slipgrid.set_cache(tmp_path / "cache")
        assert np.array_equal(slipgrid.Design(**design).predict(60.0, 100.0, 10.0).median, expected)
        assert any((tmp_path / "cache").glob("*.kept"))
        assert np.array_equal(slipgrid.Design(**design).predict(60.0, 100.0, 10.0).median, expected)
    finally:
        slipgrid._slipgrid.set_cache(slipgrid._slipgrid.__file__, True, None)
