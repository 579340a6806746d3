"""Every script of the gallery runs as it stands, and draws its picture."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPTS = sorted((Path(__file__).resolve().parents[1] / "examples").glob("*.py"))


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
