"""What the tests share: the project's folder, its program, small scenes and designs."""

from __future__ import annotations

import os
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

# Cache of the package, which is imported below, and of the program: one for all worker processes, which are started with it.
if "PYTEST_XDIST_WORKER" not in os.environ:
    CACHE = tempfile.TemporaryDirectory()
    os.environ["SLIPGRID_CACHE"] = CACHE.name

import pytest

ROOT = Path(__file__).resolve().parents[3]
PROGRAM = ROOT / "target" / "release" / "slipgrid"

MATERIAL = {
    "youngs_modulus_gpa": 0.38,
    "youngs_modulus_std_gpa": 0.08,
    "density_g_cm3": 0.9,
    "friction": {"static_mean": 0.30, "dynamic_mean": 0.27, "dynamic_std_error": 0.003},
    "area_law": {"pressure_mpa": [0.7, 1.3, 2.6, 10.0], "factor": [1.0, 0.9, 0.7, 0.3]},
}
SCENE: dict[str, Any] = {
    "material": MATERIAL,
    "pattern": {"planform": "groove", "width_um": 130.0, "spacing_um": 370.0, "depth_um": 20.0},
    "sample": {"length_um": 2000.0, "layer_um": 100.0, "block_um": 10.0},
    "load": {"pressure_mpa": [0.65, 2.6], "speed_mm_s": 2.0},
    "run": {"fidelity": "steady", "extent": "cell"},
}
DESIGN: dict[str, Any] = {
    "name": "small",
    "material": MATERIAL,
    "target": {"quantity": "ratio", "pressure_mpa": 2.6, "value": 0.88, "tolerance": 0.02},
    "bounds": {"width_um": [40.0, 100.0], "spacing_um": [40.0, 200.0], "depth_um": [2.0, 50.0]},
    "pattern": {"planform": "groove"},
    "tolerances": {"width_std_um": 2.0},
    "specimen": {"shape": "disc", "diameter_mm": 2.0},
    "sample": {"layer_um": 100.0, "block_um": 10.0},
}


@pytest.fixture
def program(tmp_path: Path) -> Callable[..., str]:
    """Runs the command line in a folder of its own; skips where it was not built."""
    if not PROGRAM.is_file():
        pytest.skip(f"{PROGRAM} is not built: cargo build --release")

    def run(*arguments: object) -> str:
        done = subprocess.run([PROGRAM, *map(str, arguments)], cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode in (0, 3), done.stderr
        return done.stdout

    return run
