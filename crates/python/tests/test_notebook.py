"""A notebook runs in a kernel of Jupyter and ends."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import MATERIAL
from slipgrid._records import toml

#: Seconds for the notebook with the start and end of its kernel.
TIMEOUT_S = 180
CELLS = [
    "import slipgrid\n%matplotlib inline",
    f"material = slipgrid.Material.from_toml({toml(MATERIAL)!r})\nmaterial",
    "stages = []\npredicted = material.predict(\n"
    "    [60.0, 100.0], 200.0, 10.0, [0.65, 2.6], band=(0.8, 0.95), progress=lambda stage, share: stages.append(stage)\n"
    ")\npredicted",
    "ax = predicted[1].plot()",
    "print(len(stages) > 0, material.ratio(60.0, 200.0, 10.0, 2.6) < 1.0)",
]
RUN = """
import sys
import nbformat
from nbclient import NotebookClient

notebook = nbformat.read(sys.argv[1], as_version=4)
NotebookClient(notebook, timeout=120, startup_timeout=60, kernel_name="python3").execute()
nbformat.write(notebook, sys.argv[1])
"""


def test_a_notebook_runs_in_a_kernel_and_ends(tmp_path: Path) -> None:
    for package in ("nbclient", "nbformat", "ipykernel", "matplotlib"):
        pytest.importorskip(package)
    cells = [
        {"cell_type": "code", "id": f"cell{place}", "metadata": {}, "source": own, "outputs": [], "execution_count": None}
        for place, own in enumerate(CELLS)
    ]
    path = tmp_path / "small.ipynb"
    path.write_text(json.dumps({"nbformat": 4, "nbformat_minor": 5, "metadata": {}, "cells": cells}))
    # A kernel ends by itself where the process that started it has ended.
    done = subprocess.run(
        [sys.executable, "-c", RUN, path], cwd=tmp_path, capture_output=True, text=True, timeout=TIMEOUT_S, check=False
    )
    assert done.returncode == 0, done.stderr
    outputs = [cell["outputs"] for cell in json.loads(path.read_text())["cells"]]
    shown = [{kind for output in own for kind in output.get("data", {})} for own in outputs]
    assert "text/html" in shown[1] and "text/html" in shown[2] and "image/png" in shown[3], shown
    assert "".join(outputs[4][0]["text"]) == "True True\n", outputs[4]
