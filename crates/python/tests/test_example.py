"""The example runs as it stands, and its search agrees with its cell."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

EXAMPLE = Path(__file__).resolve().parents[1] / "examples" / "from_map_to_laser.py"


def test_the_example_goes_from_a_map_to_the_laser(tmp_path: Path) -> None:
    done = subprocess.run([sys.executable, EXAMPLE, tmp_path], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "chance" in done.stdout
    found = json.loads((tmp_path / "result.json").read_text())
    assert found["advice"] == "trial" and (tmp_path / "pattern.dxf").is_file()
