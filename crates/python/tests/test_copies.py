"""Copies of maps, scenes, designs and calibrations do what they are copies of do, to the last bit, where no file is left."""

from __future__ import annotations

import copy as copies
import multiprocessing
import os
import pickle
import shutil
from pathlib import Path

import numpy as np
import pytest
import slipgrid
from conftest import DESIGN, MATERIAL, ROOT, SCENE
from slipgrid import _slipgrid
from slipgrid._records import toml
from slipgrid.errors import InputError

SYNTHETIC = ROOT / "calibration" / "synthetic-polymer"
LDPE = ROOT / "calibration" / "ldpe-cast-iron"


def every_copy(of, folder: Path, monkeypatch: pytest.MonkeyPatch) -> list:
    """Copies, pickled copies with every protocol, and a copy of a copy, once the files in `folder` and the folder itself are gone."""
    pickled = [pickle.dumps(of, protocol) for protocol in range(pickle.HIGHEST_PROTOCOL + 1)]
    found = [copies.copy(of), copies.deepcopy(of)]
    elsewhere = folder.with_name("elsewhere")
    elsewhere.mkdir()
    monkeypatch.chdir(elsewhere)
    shutil.rmtree(folder)
    found.extend(pickle.loads(each) for each in pickled)
    found.append(pickle.loads(pickle.dumps(found[-1])))
    assert all(type(copy) is type(of) for copy in found)
    return found


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of its own, which is where the process is."""
    made = tmp_path / "inputs"
    made.mkdir()
    monkeypatch.chdir(made)
    return made


def surface() -> np.ndarray:
    """Waves of every direction."""
    x, y = np.meshgrid(np.arange(32.0), np.arange(32.0))
    waves = np.random.default_rng(1).uniform(-1.0, 1.0, (40, 3))
    return 1e-9 * sum(np.sin(along * x + across * y + 4.0 * phase) for along, across, phase in waves)


def test_a_scene_takes_along_what_it_read(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (folder / "materials").mkdir()
    (folder / "materials" / "own.toml").write_text(toml(MATERIAL))
    text = toml({**SCENE, "material": "../inputs/./materials/own.toml", "run": {"extent": "cell"}})
    (folder / "scene.toml").write_text(text)
    scenes = [
        slipgrid.Scene.read("scene.toml", fidelity="steady"),
        slipgrid.Scene.from_toml(text, fidelity="steady"),
        slipgrid.Scene(**SCENE),
    ]
    expected = [scene.simulate().to_dict() for scene in scenes]
    first = every_copy(scenes[0], folder, monkeypatch)
    # What was read once needs its files no more.
    others = [[pickle.loads(pickle.dumps(scene))] for scene in scenes[1:]]
    for scene, all_copies, record in zip(scenes, [first, *others], expected):
        for copy in all_copies:
            assert copy.warnings == scene.warnings
            assert copy.simulate().to_dict() == record
            assert np.array_equal(copy.steady().ratio(130.0, 370.0, 20.0), scene.steady().ratio(130.0, 370.0, 20.0))


def test_a_scene_does_not_notice_what_changes_after_it_was_read(folder: Path) -> None:
    (folder / "own.toml").write_text(toml(MATERIAL))
    scene = slipgrid.Scene(**{**SCENE, "material": "own.toml"})
    (folder / "own.toml").write_text(toml({**MATERIAL, "youngs_modulus_gpa": 2.0}))
    assert pickle.loads(pickle.dumps(scene)).simulate().to_dict() == scene.simulate().to_dict()
    assert slipgrid.Scene(**{**SCENE, "material": "own.toml"}).simulate().to_dict() != scene.simulate().to_dict()


def test_a_calibration_takes_along_its_traces(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copytree(SYNTHETIC / "traces", folder / "traces")
    text = (SYNTHETIC / "calibration.toml").read_text()
    listed = 'files = ["traces/flat-30N-*.csv"]'
    assert listed in text
    text = text.replace(listed, f'{listed}\nexclude = ["flat-30N-2.csv"]')
    # Stars also stand in names without a folder.
    for path in (folder / "traces").glob("flat-80N-*"):
        path.rename(folder / path.name)
    text = text.replace("traces/flat-80N-*.csv", "flat-80N-*.csv")
    (folder / "calibration.toml").write_text(text)
    calibration = slipgrid.Calibration.read("calibration.toml")
    material, trials = calibration.fit(), calibration.trials()
    for copy in every_copy(calibration, folder, monkeypatch):
        assert copy.warnings == calibration.warnings
    fitted, copied_trials = copy.fit(), copy.trials()
    assert copied_trials.to_dict() == trials.to_dict() and str(copied_trials) == str(trials)
    assert fitted.toml == material.toml and fitted.fit == material.fit and str(fitted) == str(material)


def mapped(folder: Path) -> None:
    """The calibration of LDPE with a small map, of the conditions on both sides of 2 mm/s and 50 %."""
    for name in ("flat.csv", "patterned.csv"):
        lines = (LDPE / name).read_text().splitlines(keepends=True)
        kept = [line for line in lines if not line[0].isdigit() or ",2,40," in line or ",2,80," in line]
        (folder / name).write_text("".join(kept))
    np.savetxt(folder / "map.txt", surface())
    text = (LDPE / "calibration.toml").read_text()
    map_of_text = 'map = "map.txt"\npixel_um = 0.7\nheight_unit = "m"\nwindows = 1'
    (folder / "calibration.toml").write_text(text.replace('map = "flat-map.asc"', map_of_text))


def test_a_design_takes_along_its_calibration_with_its_map(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    mapped(folder)
    tables = {**DESIGN, "material": "calibration.toml", "condition": {"speed_mm_s": 2.0, "humidity_pct": 50.0}}
    tables["target"] = {**DESIGN["target"], "pressure_mpa": 2.546}
    design, calibration = slipgrid.Design(**tables), slipgrid.Calibration.read("calibration.toml")
    taken = pickle.dumps(calibration)
    all_copies = every_copy(design, folder, monkeypatch)
    # The map is read when it is needed: the original has it from when it was copied.
    material = calibration.fit().toml
    assert pickle.loads(taken).fit().toml == material
    expected = design.optimize()
    next_samples = design.next(1).to_dict()
    for copy in all_copies:
        assert copy.warnings == design.warnings
    found = copy.optimize()
    assert found.to_dict() == expected.to_dict() and found.drawing("dxf") == expected.drawing("dxf")
    assert copy.next(1).to_dict() == next_samples


def test_a_calibration_and_a_design_are_those_of_the_folder_in_which_they_were_read(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    mapped(folder)
    tables = {**DESIGN, "material": "calibration.toml", "condition": {"speed_mm_s": 2.0, "humidity_pct": 50.0}}
    tables["target"] = {**DESIGN["target"], "pressure_mpa": 2.546}
    (folder / "scene.toml").write_text(toml(tables))
    expected = slipgrid.Calibration.read("calibration.toml").fit()
    saved = expected.save("expected.toml").read_text()
    (folder / "expected.toml").unlink()
    design, calibration = slipgrid.Design.read("scene.toml"), slipgrid.Calibration.read("calibration.toml")
    later, taken = slipgrid.Calibration.read("calibration.toml"), slipgrid.Design.read("scene.toml")
    elsewhere = folder.with_name("elsewhere")
    elsewhere.mkdir()
    monkeypatch.chdir(elsewhere)
    material = calibration.fit()
    assert material.toml == expected.toml and str(material) == str(expected)
    # What it was made from is found from where it stands.
    assert material.save(folder / "material.toml").read_text() == saved
    found = design.optimize()
    assert pickle.loads(pickle.dumps(taken)).optimize().to_dict() == found.to_dict()
    assert design.next(1).to_dict()["samples"]
    # Inputs are guarded where they stand, and nothing of the same name elsewhere.
    with pytest.raises(InputError, match="is an input of this run"):
        material.save(folder / "calibration.toml")
    with pytest.raises(InputError, match="holds scene.toml, which is an input of this run"):
        found.export(folder)
    assert found.export(".") and found.export(".")
    (folder / "map.txt").unlink()
    with pytest.raises(InputError, match="^map.txt: cannot be read: "):
        later.fit()


def test_a_file_that_is_gone_before_it_was_read_is_named(folder: Path) -> None:
    mapped(folder)
    calibration = slipgrid.Calibration.read("calibration.toml")
    (folder / "map.txt").unlink()
    with pytest.raises(InputError, match="map.txt: cannot be read: ") as refused:
        pickle.dumps(calibration)
    assert refused.value.file == "map.txt"


def test_a_map_is_copied_with_what_its_file_says(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    heights_m = surface()
    heights_m[3, 4] = np.nan
    np.savetxt("map.txt", heights_m, header="A synthetic surface")
    read = slipgrid.Map.read("map.txt", pixel_um=0.7, height_unit="m")
    given = slipgrid.Map(heights_m.T, pixel_um=0.1, pixel_y_um=0.3)
    assert read.is_synthetic and not given.is_synthetic
    copies_of_given = [pickle.loads(pickle.dumps(given)), copies.deepcopy(given)]
    for own, all_copies in ((read, every_copy(read, folder, monkeypatch)), (given, copies_of_given)):
        law = own.area_law(youngs_modulus_gpa=0.38, pressures_mpa=[0.7, 1.3], windows=1)
        for copy in all_copies:
            assert copy.heights_m.tobytes() == own.heights_m.tobytes() and copy.heights_m.shape == own.heights_m.shape
            assert not copy.heights_m.flags.writeable
            assert repr(copy) == repr(own) and copy.pixel_um == own.pixel_um and copy.is_synthetic == own.is_synthetic
            assert copy.measure().to_dict() == own.measure().to_dict()
        assert copy.area_law(youngs_modulus_gpa=0.38, pressures_mpa=[0.7, 1.3], windows=1) == law


def test_a_damaged_copy_of_a_map_is_refused() -> None:
    sides_m = [1e-6, 1e-6]
    with pytest.raises(ValueError, match='format is "none": expected one of matrix, '):
        _slipgrid.restore_map(surface(), sides_m, True, "none", [], [], "array")
    with pytest.raises(ValueError, match="pixel size along x"):
        _slipgrid.restore_map(surface(), [-1.0, 1e-6], True, "matrix", [], [], "array")


def test_processes_are_sent_scenes_designs_calibrations_and_maps(folder: Path) -> None:
    scene, design, made = slipgrid.Scene(**SCENE), slipgrid.Design(**DESIGN), slipgrid.Map(surface(), pixel_um=0.7)
    mapped(folder)
    calibration = slipgrid.Calibration.read("calibration.toml")
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        # Which of them has the files does not matter.
        assert pool.apply(os.getpid) != os.getpid()
        assert pool.apply(scene.simulate) == scene.simulate()
        assert pool.apply(design.optimize).to_dict() == design.optimize().to_dict()
        assert pool.apply(calibration.fit).toml == calibration.fit().toml
        assert pool.apply(made.measure) == made.measure()
