"""Nothing of the user's is lost, and what is refused is refused with the argument's name and what would be accepted."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import numpy as np
import pytest
import slipgrid
from conftest import DESIGN, PROGRAM, SCENE
from slipgrid._records import toml
from slipgrid.errors import InputError


def test_neither_inputs_nor_files_of_others_are_replaced(tmp_path: Path) -> None:
    file = tmp_path / "scene.toml"
    file.write_text(toml(DESIGN))
    before = file.read_bytes()
    design = slipgrid.Design.read(file)
    found = design.optimize()
    with pytest.raises(InputError, match="holds scene.toml, which is an input of this run") as refused:
        found.export(tmp_path)
    assert refused.value.key == "folder" and file.read_bytes() == before and list(tmp_path.iterdir()) == [file]

    folder = tmp_path / "out"
    folder.mkdir()
    (folder / "pattern.dxf").write_text("0\nSECTION\n")
    with pytest.raises(InputError, match="holds pattern.dxf, which was not written by slipgrid"):
        found.export(folder)
    assert [path.name for path in folder.iterdir()] == ["pattern.dxf"]
    (folder / "pattern.dxf").unlink()
    assert found.export(folder) and found.export(folder)

    page = tmp_path / "mine.html"
    page.write_text("<title>mine</title>")
    with pytest.raises(InputError, match="was not written by slipgrid"):
        design.explore(page)
    assert page.read_text() == "<title>mine</title>"
    assert design.explore(tmp_path / "own.html") == design.explore(tmp_path / "own.html")
    # A text stands in no file: a second export replaces the scene.toml of the first.
    alone = slipgrid.Design.from_toml(toml(DESIGN), tmp_path / "again").optimize()
    assert alone.export(tmp_path / "again") and alone.export(tmp_path / "again")


def test_a_calibration_is_not_replaced_by_its_material(tmp_path: Path) -> None:
    root = Path(__file__).resolve().parents[3] / "calibration" / "ldpe-cast-iron"
    for path in root.iterdir():
        if path.is_file():
            (tmp_path / path.name).write_bytes(path.read_bytes())
    file = tmp_path / "calibration.toml"
    before = file.read_bytes()
    material = slipgrid.Calibration.read(file).fit()
    with pytest.raises(InputError, match="is an input of this run"):
        material.save(file)
    assert file.read_bytes() == before
    assert material.save(tmp_path / "m.toml") == material.save(tmp_path / "m.toml")
    # Where nothing can be written it is the system that says so.
    with pytest.raises((InputError, OSError)):
        material.save(tmp_path / "m.toml" / "below.toml")


def test_cells_that_take_too_much_memory_are_refused() -> None:
    thick = {**SCENE, "sample": {"length_um": 2000.0, "thickness_mm": 5.0, "block_um": 10.0}}
    cell = slipgrid.Scene(**thick).steady()
    with pytest.raises(InputError, match=r"width_um, spacing_um, depth_um: 100000, 10, 10 makes a cell that takes .* bytes") as refused:
        cell.ratio([130.0, 1e5], 10.0, 10.0)
    assert "at most 4.3e9 bytes" in str(refused.value)


def test_lengths_come_as_any_array_of_numbers() -> None:
    cell = slipgrid.Scene(**SCENE).steady()
    widths_um = np.array([100.0, 120.0])
    expected = cell.ratio(widths_um, 370.0, 20.0)
    kinds = (np.float16, np.int8, np.uint64, object)
    for same in (*(widths_um.astype(kind) for kind in kinds), widths_um.tolist(), np.repeat(widths_um, 2)[::2]):
        assert np.array_equal(cell.ratio(same, 370.0, 20.0), expected)
    assert cell.ratio(np.ones(0), 370.0, 20.0).shape == (0, 2)
    with pytest.raises(ValueError, match=r"shapes do not broadcast: width_um \(2, 1\), spacing_um \(3, 1\)"):
        cell.ratio(widths_um, np.ones(3), 20.0)
    with pytest.raises(TypeError, match="width_um holds what is of the type <U3; expected real numbers"):
        cell.ratio("abc", 370.0, 20.0)
    with pytest.raises(InputError, match="width_um, spacing_um, depth_um: -1, 370, 20"):
        cell.ratio([100.0, -1.0], 370.0, 20.0)
    with pytest.raises(InputError, match="pressure_mpa: -1 is out of range"):
        cell.ratio(100.0, 370.0, 20.0, [0.65, -1.0])
    with pytest.raises(InputError, match="pressure_mpa: MPa is above 0.5 of Young's modulus"):
        cell.ratio(100.0, 370.0, 20.0, 300.0)


def test_threads_are_bounded() -> None:
    for count in (0, -1, 1025, 10**6, 2**70, -(2**70)):
        with pytest.raises(ValueError, match=f"count is {count}: expected 1 to 1024, or None"):
            slipgrid.set_threads(count)


def test_lengths_beyond_the_bounds_are_refused_with_the_bounds() -> None:
    design = slipgrid.Design(**{**DESIGN, "bounds": {**DESIGN["bounds"], "depth_um": 10.0}})
    for lengths, says in [
        ((-1.0, 100.0, 10.0), "width_um: -1 is beyond the bounds of the design; expected 40 to 100"),
        (([60.0, 80.0], [200.5, 100.0], 10.0), "spacing_um: 200.5 is .* expected 40 to 200"),
        ((60.0, 100.0, np.inf), "depth_um: inf is .* expected 10$"),
    ]:
        with pytest.raises(ValueError, match=says) as refused:
            design.predict(*lengths)
        assert isinstance(refused.value, InputError)
    assert design.predict([40.0, 100.0], 200.0, 10.0).chance.shape == (2,)


def test_samples_may_share_a_disc_and_teach() -> None:
    design = slipgrid.Design(**{**DESIGN, "specimen": {"shape": "disc", "diameter_mm": 4.0}})
    disc = design.next(2, one_disc=True)
    assert len(disc.samples) == 2 and disc.one_disc is not None and len(disc.one_disc.sectors) == 2
    learned = design.next(learn=True)
    assert learned.learning is not None and disc.learning is None
    with pytest.raises(ValueError, match="count is 1: expected 2 to 12 sectors of one_disc"):
        design.next(one_disc=True)
    for more in ({"count": 2}, {"candidates_um": [(60, 100, 10)]}, {"one_disc": True}):
        with pytest.raises(ValueError, match="learn chooses both sectors of one disc itself"):
            design.next(learn=True, **more)


def test_a_cache_that_cannot_be_written_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    for wrong in (tmp_path / "file", tmp_path / "file" / "below"):
        with pytest.raises(OSError):
            slipgrid.set_cache(wrong)


def test_messages_speak_of_python(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="seems to be a scene file, which `Scene` takes; expected a design file") as refused:
        slipgrid.Design.from_toml(toml(SCENE))
    assert "slipgrid" not in str(refused.value)
    (tmp_path / "table--1.csv").write_text("a,b\n1,2\n")
    with pytest.raises(InputError, match=r"table--1.csv: is a table of numbers: `Map` takes an altitude map"):
        slipgrid.Design.read(tmp_path / "table--1.csv")


def test_counts_of_any_size_are_refused_in_words() -> None:
    design = slipgrid.Design(**DESIGN)
    for count in (0, -1, 21, 2**70):
        with pytest.raises(ValueError, match=f"count is {count}: expected 1 to 20"):
            design.next(count)
    with pytest.raises(InputError, match=f"windows: {2**70} is no number of windows; expected 1 for none"):
        a_map().area_law(youngs_modulus_gpa=0.38, windows=2**70)
    for wrong in ("abc", 1.5):
        with pytest.raises(TypeError, match=f"count is {wrong}: expected a whole number"):
            design.next(wrong)  # type: ignore[arg-type]
        with pytest.raises(TypeError, match=f"count is {wrong}: expected a whole number"):
            slipgrid.set_threads(wrong)  # type: ignore[arg-type]


def test_masked_heights_and_lengths_are_missing() -> None:
    rng = np.random.default_rng(0)
    heights_m, bad = 1e-7 * rng.standard_normal((16, 16)), rng.random((16, 16)) < 0.1
    with_gaps = slipgrid.Map(np.where(bad, np.nan, heights_m), 1.0)
    masked = slipgrid.Map(np.ma.MaskedArray(heights_m, bad), 1.0)
    assert masked.heights_m.tobytes() == with_gaps.heights_m.tobytes() and masked.measure() == with_gaps.measure()
    whole = np.ma.MaskedArray(np.arange(4).reshape(2, 2), [[False, True], [False, False]])
    assert np.array_equal(slipgrid.Map(whole, 1.0).heights_m, [[0.0, np.nan], [2.0, 3.0]], equal_nan=True)
    assert not np.isnan(slipgrid.Map(np.ma.MaskedArray(heights_m), 1.0).heights_m).any()
    cell = slipgrid.Scene(**SCENE).steady()
    widths_um = np.ma.MaskedArray([100.0, 130.0], [False, True])
    found = cell.ratio(widths_um, 370.0, 20.0)
    assert np.array_equal(found[0], cell.ratio(100.0, 370.0, 20.0)) and np.isnan(found[1]).all()
    with pytest.raises(TypeError, match="load.pressure_mpa is masked: expected a number"):
        slipgrid.Scene(**{**SCENE, "load": {"pressure_mpa": np.ma.MaskedArray([0.65, 2.6], [False, True]), "speed_mm_s": 2.0}})


@pytest.mark.parametrize(
    "wrong",
    [
        np.ones((2, 3), dtype="datetime64[s]"),
        np.ones((2, 3), dtype="timedelta64[s]"),
        np.ones((2, 3), dtype=bool),
        np.full((2, 3), "1.0"),
        np.full((2, 3), b"1.0"),
        np.ones((2, 3), dtype=complex),
    ],
    ids=lambda wrong: str(wrong.dtype),
)
def test_only_real_numbers_are_numbers(wrong: np.ndarray) -> None:
    with pytest.raises(TypeError, match="heights_m holds what is of the type .*; expected real numbers"):
        slipgrid.Map(wrong, 1.0)
    with pytest.raises(TypeError, match="width_um holds what is of the type .*; expected real numbers"):
        slipgrid.Scene(**SCENE).steady().ratio(wrong, 200.0, 10.0)


def test_any_type_of_real_numbers_is_taken() -> None:
    for kind in (np.float16, np.float32, np.longdouble, np.int8, np.uint64, object):
        assert np.array_equal(slipgrid.Map(np.arange(6).reshape(2, 3).astype(kind), 1.0).heights_m, [[0, 1, 2], [3, 4, 5]])


def test_pixels_are_refused_in_their_unit(tmp_path: Path) -> None:
    accepted = "out of range; expected a number from 0.0000001 up to 10000000 um"
    for wrong in (-1.0, 0.0, 1e-8, 1e8, float("nan"), float("inf")):
        with pytest.raises(InputError, match=f"^pixel_um: .* is {accepted}$") as refused:
            slipgrid.Map(np.zeros((2, 2)), wrong)
        assert refused.value.key == "pixel_um"
        with pytest.raises(InputError, match=f"^pixel_y_um: .* is {accepted}$"):
            slipgrid.Map(np.zeros((2, 2)), 1.0, wrong)
        with pytest.raises(InputError, match=f"^pixel_um: .* is {accepted}$"):
            slipgrid.Map.read(tmp_path / "nowhere", pixel_um=wrong)
    for wrong_heights, says in [(np.zeros((1, 5)), "expected at least 2"), (np.full((2, 2), 2000.0), "height is 2000: expected")]:
        with pytest.raises(InputError, match=f"^heights_m: .*{says}"):
            slipgrid.Map(wrong_heights, 1.0)


def refused_by_the_program(folder: Path, command: str, name: str) -> str:
    """What the command line says of a file, without the word before it."""
    if not PROGRAM.is_file():
        pytest.skip(f"{PROGRAM} is not built: cargo build --release")
    done = subprocess.run([PROGRAM, command, name], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 2, done
    return done.stderr


def test_files_are_read_and_refused_as_by_the_command_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    texts = {"scene.toml": toml({"name": "Größe", **SCENE}), "design.toml": toml({**DESIGN, "name": "Größe"})}
    for name, text in texts.items():
        for encoding in ("utf-8", "utf-16", "latin-1"):
            Path(f"{encoding}-{name}").write_bytes(text.encode(encoding))
    Path("broken.toml").write_bytes(b"\x7fELF\0\0")
    for name, read, own in (("scene.toml", slipgrid.Scene.read, "simulate"), ("design.toml", slipgrid.Design.read, "optimize")):
        other = next(of for of in texts if of != name)
        for wrong, says in [
            (f"latin-1-{name}", "is no text in UTF-8"),
            ("broken.toml", "is no text"),
            (f"utf-8-{other}", "seems to be a "),
            (".", "is a folder"),
        ]:
            with pytest.raises(InputError, match=says) as refused:
                read(wrong)
            if says != "seems to be a ":
                assert str(refused.value) in refused_by_the_program(tmp_path, own, wrong)
        assert read(f"utf-16-{name}").warnings == read(f"utf-8-{name}").warnings
    with pytest.raises(InputError, match="^calibration.toml: seems to be a design file, which `Design` takes"):
        slipgrid.Calibration.from_toml(texts["design.toml"])
    assert slipgrid.Scene.read("utf-16-scene.toml").simulate() == slipgrid.Scene(**SCENE, name="Größe").simulate()


def a_map() -> slipgrid.Map:
    return slipgrid.Map(1e-7 * np.random.default_rng(0).standard_normal((64, 64)), 1.0)


def test_what_a_map_is_asked_for_is_checked() -> None:
    surface = a_map()
    assert surface.measure().warnings == [] or all(isinstance(of, str) for of in surface.measure().warnings)
    assert slipgrid.Surface({}).warnings == []
    for wrong, says in [
        ({"pressures_mpa": []}, r"pressures_mpa: \[\] has no pressure; expected positive numbers that increase"),
        ({"pressures_mpa": [2, 1]}, "pressures_mpa: 1 does not exceed the 2 before it"),
        ({"threshold_mpa": 0.0}, "threshold_mpa: 0 is out of range; expected"),
        ({"threshold_mpa": 1e9}, "threshold_mpa: 1000000000 is out of range; expected"),
        ({"tolerance": 0.0}, "tolerance: 0 is out of range; expected"),
        ({"windows": 0}, "windows: 0 is no number of windows; expected 1 for none, 2 or more"),
        ({"windows": -1}, "windows: -1 is no number of windows"),
        ({"windows": 1000}, "windows: 1000 "),
        ({"poisson_ratio": 0.6}, "poisson_ratio: 0.6 is out of range"),
    ]:
        with pytest.raises(InputError, match=says):
            surface.area_law(**{"youngs_modulus_gpa": 0.38, **wrong})
    with pytest.raises(InputError, match="youngs_modulus_gpa: 380000000 is out of range; .*in Pa, that would be 0.38 GPa"):
        surface.area_law(youngs_modulus_gpa=380e6)
    for wrong in (b"abc", "abc", 5.0):
        with pytest.raises(TypeError, match="pressures_mpa is .*: expected a list of numbers"):
            surface.area_law(youngs_modulus_gpa=0.38, pressures_mpa=wrong)  # type: ignore[arg-type]
    for heights in ("abc", np.zeros(5), np.zeros((2, 2)) + 1j, None):
        with pytest.raises((TypeError, ValueError), match="heights_m.*expected real numbers"):
            slipgrid.Map(heights, 1.0)  # type: ignore[arg-type]


def test_the_area_law_is_that_of_the_command_line(program, tmp_path: Path) -> None:
    path = Path(__file__).resolve().parents[3] / "calibration" / "ldpe-cast-iron" / "flat-map.asc"
    surface = slipgrid.Map.read(path)
    for pressures, more in [([0.1, 0.7, 2.6, 10.0], []), ([1.0, 3.0], ["--tolerance", "1e-6"])]:
        listed = ",".join(map(str, pressures))
        told = json.loads(
            program("area-law", path, "--youngs-modulus-gpa", "0.38", "--pressures-mpa", listed, "--json", "-q", *more)
        )
        law = surface.area_law(youngs_modulus_gpa=0.38, pressures_mpa=pressures, **({"tolerance": 1e-6} if more else {}))
        for name in ("pressure_mpa", "area_fraction", "area_fraction_corrected", "area_error", "factor", "factor_std"):
            assert law[name] == [row.get(name) for row in told["results"]], name


def test_dictionaries_become_toml() -> None:
    same = toml({"a b": np.bool_(True), "t": {"x.y": [1, 2], "z": {"ü\x7f\n": "\x7f"}}})
    assert same == '"a b" = true\n[t]\n"x.y" = [1, 2]\nz = { "ü\\u007f\\n" = "\\u007f" }\n'
    for wrong in (b"abc", np.array(0.65), None, 1j):
        with pytest.raises(TypeError, match="load.pressure_mpa is .*expected"):
            toml({"load": {"pressure_mpa": wrong}})
    scene = {**SCENE, "run": {**SCENE["run"], "liftoff": np.bool_(False)}}
    assert slipgrid.Scene(**scene).warnings == slipgrid.Scene(**SCENE).warnings
    with pytest.raises(TypeError, match=r"candidates_um\[0\] is 'abc'"):
        slipgrid.Design(**DESIGN).next(candidates_um=["abc"])  # type: ignore[list-item]
    with pytest.raises(ValueError, match=r"candidates_um\[0\] has 2 numbers"):
        slipgrid.Design(**DESIGN).next(candidates_um=[(1.0, 2.0)])


def test_the_headline_is_the_first_line_of_the_command_line() -> None:
    found = slipgrid.Design(**DESIGN).optimize()
    assert str(found).startswith(found.headline) and "\n" not in found.headline
    assert found.headline == f"{found.name}: {found.words}" and "chance" in found.words
