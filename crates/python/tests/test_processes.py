"""Nothing hangs, whichever way processes and threads are started: every wait here ends after a while."""

from __future__ import annotations

import multiprocessing
import os
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import pytest
import slipgrid
from conftest import DESIGN, MATERIAL, SCENE
from slipgrid._records import toml

#: Seconds after which something hangs.
LONGEST_S = 120.0
#: What a trial has taught, as `slipgrid calibrate` writes it into a material file: reading it fits regressions.
LEARNED: dict[str, Any] = {
    "reference_pressure_mpa": 1.5,
    "lowest_pressure_mpa": 0.6,
    "reference_speed_mm_s": 2.0,
    "modulus_relative_std": 0.2,
    "prior": {
        "amplitude_std": 0.2,
        "pressure_std": 0.06,
        "inverse_pressure_std": 0.08,
        "speed_std": 0.05,
        "humidity_std": 0.1,
        "sample_std": 0.005,
        "least_measured_std": 0.005,
    },
    "trial": [
        {
            "name": "T1",
            "areal_density": 0.25,
            "edge_per_mm": 4.0,
            "width_um": 130.0,
            "pitch_um": 500.0,
            "depth_um": 5.2,
            "pressure_mpa": [0.6, 2.6],
            "speed_mm_s": [2.0, 2.0],
            "humidity_pct": [50.0, 50.0],
            "measured_ratio": [0.84, 0.8],
            "modelled_ratio": [0.99, 0.97],
            "patterned_std": [0.02, 0.01],
            "flat_std": [0.01, 0.01],
            "modulus_sensitivity": [0.005, 0.025],
        }
    ],
}


def scene(folder: Path) -> slipgrid.Scene:
    """A scene whose material is a file with trials, which is read anew."""
    return slipgrid.Scene(**{**SCENE, "material": "learned.toml"}, folder=folder)


def prepare(folder: Path) -> None:
    (folder / "learned.toml").write_text(toml({**MATERIAL, "learned": LEARNED}))


def compute(folder: Path) -> None:
    """Reads, solves, searches and writes."""
    scene(folder).simulate().export(folder / "solved")
    design = slipgrid.Design(**{**DESIGN, "material": "learned.toml"}, folder=folder)
    str(design.next(1))
    slipgrid.Map([[0.0, 1e-8], [1e-8, 0.0]] * 8, 1.0).measure()


def child(folder: Path) -> None:
    found = scene(folder).simulate()
    os._exit(0 if 0.5 < found.ratio[0] < 1.0 else 1)


def forks_while_another_thread_computes(folder: Path) -> None:
    """A child that is forked within a call, here one that tells of its progress, is told why it computes nothing."""
    seen: list[int] = []

    def fork(stage: str, share: float) -> None:
        if seen:
            return
        own = os.fork()
        if own == 0:
            try:
                scene(folder).simulate()
            except RuntimeError as error:
                os._exit(0 if "forked while slipgrid was computing" in str(error) else 2)
            os._exit(3)
        seen.append(own)

    slipgrid.Design(**DESIGN).optimize(fork)
    ended = time.monotonic() + LONGEST_S / 2
    while time.monotonic() < ended:
        pid, status = os.waitpid(seen[0], os.WNOHANG)
        if pid:
            sys.exit(os.waitstatus_to_exitcode(status))
        time.sleep(0.05)
    os.kill(seen[0], 9)
    sys.exit("the child hangs")


def uses_its_own_threads_alone(folder: Path) -> None:
    """All that computes does so on the threads that were asked for, at most one a core: no library has a pool for all."""
    cores = slipgrid.threads()
    slipgrid.set_threads(3)
    before = set(os.listdir("/proc/self/task"))
    prepare(folder)
    compute(folder)
    begun = set(os.listdir("/proc/self/task")) - before
    names = sorted(Path(f"/proc/self/task/{task}/comm").read_text().strip() for task in begun)
    assert names == [f"slipgrid-{number}" for number in range(min(3, cores))], names


def starts_children(method: str, folder: Path) -> None:
    prepare(folder)
    compute(folder)
    context = multiprocessing.get_context(method)
    children = [context.Process(target=child, args=(folder,)) for _ in range(2)]
    for own in children:
        own.start()
    for own in children:
        own.join(LONGEST_S / 2)
    codes = [own.exitcode for own in children]
    for own in children:
        own.kill()
    assert codes == [0, 0], f"{method}: {codes}"


def run(call: str, folder: Path) -> None:
    """Makes `call` of this file in a process that is ended where it hangs."""
    code = f"import sys; sys.path.insert(0, {str(Path(__file__).parent)!r}); from pathlib import Path; import test_processes as t; t.{call}"
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", code], cwd=folder, capture_output=True, text=True, timeout=LONGEST_S, check=False
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("method", multiprocessing.get_all_start_methods())
def test_children_of_a_process_that_has_computed_do_not_hang(method: str, tmp_path: Path) -> None:
    (tmp_path / "main.py").write_text(
        f"import sys; sys.path.insert(0, {str(Path(__file__).parent)!r})\n"
        "from pathlib import Path\nimport test_processes as t\n"
        f"if __name__ == '__main__':\n    t.starts_children({method!r}, Path('.').resolve())\n"
    )
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "main.py"], cwd=tmp_path, capture_output=True, text=True, timeout=LONGEST_S, check=False
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")
def test_a_child_forked_while_its_parent_computes_says_so(tmp_path: Path) -> None:
    prepare(tmp_path)
    run("forks_while_another_thread_computes(Path('.').resolve())", tmp_path)


@pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="no list of threads")
def test_no_library_uses_a_pool_for_all(tmp_path: Path) -> None:
    run("uses_its_own_threads_alone(Path('.').resolve())", tmp_path)


def test_threads_share_one_design_without_waiting_for_each_other(tmp_path: Path) -> None:
    design = slipgrid.Design(**DESIGN)
    found: list[slipgrid.DesignResult] = []
    threads = [threading.Thread(target=lambda: found.append(design.optimize()), daemon=True) for _ in range(3)]
    for own in threads:
        own.start()
    ended = time.monotonic() + LONGEST_S
    for own in threads:
        own.join(max(0.0, ended - time.monotonic()))
    assert len(found) == 3 and len({str(own.design) for own in found}) == 1
    assert found[0].design.to_dict() == found[2].design.to_dict()
