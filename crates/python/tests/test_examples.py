"""Every script of the gallery runs as it stands, and draws the picture that the book shows."""

from __future__ import annotations

import importlib
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import ROOT

SCRIPTS = sorted((ROOT / "crates" / "python" / "examples").glob("*.py"))
#: Largest relative difference of a drawn number, as other processors round differently.
TOLERANCE = 2e-3
#: Largest size of a picture of the book in bytes.
MAX_BYTES = 60_000


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.stem)
def test_an_example_runs_and_draws(script: Path, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    if "dask" in script.stem:
        pytest.importorskip("dask.distributed")
    done = subprocess.run([sys.executable, script, tmp_path], capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 0, done.stderr
    picture = (tmp_path / f"{script.stem.replace('_', '-')}.png").read_bytes()
    assert picture.startswith(b"\x89PNG") and len(picture) > 5_000
    if script.stem == "target_to_laser":
        found = json.loads((tmp_path / "result.json").read_text())
        assert found["advice"] == "trial" and (tmp_path / "pattern.dxf").is_file() and found["name"] in done.stdout
    if script.stem == "sweep_on_dask":
        assert "12 tasks: 12 done" in done.stdout


def compare(kept: Any, now: Any, place: str) -> None:
    """Fails where labels differ, or numbers by more than the tolerance of their largest."""
    if isinstance(kept, dict):
        assert kept.keys() == now.keys(), place
        for key in kept:
            compare(kept[key], now[key], f"{place}: {key}")
    elif isinstance(kept, list) and not all(isinstance(item, (int, float)) for item in kept):
        assert len(kept) == len(now), place
        for number, pair in enumerate(zip(kept, now)):
            compare(*pair, f"{place} {number}")
    elif isinstance(kept, list):
        assert np.shape(kept) == np.shape(now), place
        scale = np.abs(np.asarray(kept, dtype=float)).max(initial=0.0)
        assert np.allclose(kept, now, rtol=TOLERANCE, atol=TOLERANCE * scale), f"{place}: {kept} in the book, now {now}"
    else:
        assert kept == now, place


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.stem)
def test_the_book_shows_what_an_example_draws(script: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("matplotlib")
    if "dask" in script.stem:
        pytest.importorskip("dask.distributed")
    monkeypatch.syspath_prepend(str(ROOT / "crates" / "python"))
    gallery = importlib.import_module("make_gallery")
    command = [sys.executable, gallery.__file__, "--folder", tmp_path, script.stem]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 0, done.stderr
    kept = gallery.picture(gallery.PICTURES, script.stem)
    assert kept.stat().st_size < MAX_BYTES and b"<dc:date>" not in kept.read_bytes()
    compare(gallery.described(kept), gallery.described(gallery.picture(tmp_path, script.stem)), f"{script.stem}: python make_gallery.py")
    chapter = (ROOT / "crates" / "book" / "src" / "tutorials" / "python.md").read_text(encoding="utf-8")
    assert f'src="../pictures/{kept.name}"' in chapter
