"""Errors, Ctrl-C, forks, threads, and the cost of the border."""

from __future__ import annotations

import errno
import os
import pickle
import signal
import statistics
import threading
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import slipgrid
from conftest import DESIGN, SCENE
from slipgrid._records import toml
from slipgrid.errors import InputError, MissingFileError


def test_what_is_refused_names_file_line_and_key() -> None:
    text = toml(DESIGN).replace("tolerance = 0.02", "tolerance = -0.02")
    with pytest.raises(InputError) as refused:
        slipgrid.Design.from_toml(text, "somewhere")
    error = refused.value
    assert error.file == os.path.join("somewhere", "design.toml") and error.key == "target.tolerance"
    assert text.splitlines()[error.line - 1] == "tolerance = -0.02" and error.value == "-0.02"
    assert error.expected and str(error).startswith("somewhere") and isinstance(error, ValueError)
    with pytest.raises(InputError, match="widht_um"):
        slipgrid.Design(**{**DESIGN, "bounds": {**DESIGN["bounds"], "widht_um": [1, 2]}})
    with pytest.raises(ValueError, match="expected one of steady, dynamic"):
        slipgrid.Scene(**SCENE, fidelity="quick")


@pytest.mark.parametrize(
    "read",
    [
        slipgrid.Scene.read,
        slipgrid.Design.read,
        slipgrid.Calibration.read,
        slipgrid.Map.read,
        slipgrid.campaign.plan,
    ],
)
def test_a_file_that_is_not_there_is_refused_and_not_found(read: Callable[[str], object], tmp_path: Path) -> None:
    for way in (InputError, FileNotFoundError):
        with pytest.raises(way, match="^nowhere.toml: cannot be read: ") as refused:
            read("nowhere.toml")
        error = refused.value
        assert isinstance(error, MissingFileError) and error.file == error.filename == "nowhere.toml" and error.errno == errno.ENOENT
        copy = pickle.loads(pickle.dumps(error))
        assert type(copy) is type(error) and str(copy) == str(error) and copy.file == error.file
    with pytest.raises(InputError, match="is a folder") as refused:
        read(str(tmp_path))
    assert not isinstance(refused.value, FileNotFoundError)


def slow() -> slipgrid.Scene:
    """A run in time of a minute."""
    return slipgrid.Scene(
        **{**SCENE, "sample": {"length_um": 9960.0, "layer_um": 200.0, "block_um": 5.0}}, fidelity="reference", extent="sample"
    )


@pytest.fixture
def ctrl_c():
    """Ctrl-C raises here even where it is ignored, as in what a script starts in the background."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("ctrl_c")
def test_ctrl_c_ends_a_run_long_before_its_end() -> None:
    shares = [0.0]
    timer = threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        slow().simulate(lambda stage, share: shares.append(share))
    assert shares[-1] < 0.5


@pytest.mark.alone
@pytest.mark.usefixtures("ctrl_c")
def test_ctrl_c_ends_the_ratios_of_many_patterns() -> None:
    cell = slipgrid.Scene(**SCENE).steady()
    widths_um = np.linspace(100.0, 200.0, 400_000)
    patterns = np.column_stack([widths_um, np.full_like(widths_um, 200.0), np.full_like(widths_um, 10.0)])
    # Time of the processors, which other programs do not lengthen: a twentieth of the patterns, and all until Ctrl-C.
    started = time.process_time()
    cell.ratio(*patterns[::20].T)
    twentieth_s = time.process_time() - started
    threading.Timer(0.1, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    started = time.process_time()
    with pytest.raises(KeyboardInterrupt):
        cell.ratio(*patterns.T)
    took_s = time.process_time() - started
    assert took_s < 10 * twentieth_s, f"{took_s} s, {twentieth_s} s for a twentieth"
    # The same cell goes on.
    assert np.array_equal(cell.ratio(*patterns[:5].T)[4], cell.ratio(*patterns[4]))


def test_what_a_callback_raises_ends_a_run_too() -> None:
    def tell(stage: str, share: float) -> None:
        raise LookupError(stage)

    with pytest.raises(LookupError):
        slow().simulate(tell)


def test_other_threads_of_python_go_on_meanwhile() -> None:
    ticks = 0
    done = threading.Event()

    def count() -> None:
        nonlocal ticks
        while not done.wait(0.01):
            ticks += 1

    counter = threading.Thread(target=count)
    counter.start()
    started = time.monotonic()
    slipgrid.Design(**DESIGN).optimize()
    took = time.monotonic() - started
    done.set()
    counter.join()
    assert ticks > 5 * took, f"{ticks} ticks in {took} s"


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_process_forked_after_use_computes_on_threads_of_its_own() -> None:
    cell = slipgrid.Scene(**SCENE).steady()
    patterns = np.array([[100.0, 200.0, 10.0], [130.0, 370.0, 20.0]])
    expected = cell.ratio(*patterns.T)
    child = os.fork()
    if child == 0:
        same = np.array_equal(cell.ratio(*patterns.T), expected) and slipgrid.threads() > 0
        os._exit(0 if same else 1)
    for _ in range(300):
        ended, status = os.waitpid(child, os.WNOHANG)
        if ended:
            break
        time.sleep(0.1)
    else:
        os.kill(child, signal.SIGKILL)
        pytest.fail("the child hangs")
    assert status == 0


def test_threads_are_those_asked_for() -> None:
    slipgrid.set_threads(1)
    assert slipgrid.threads() == 1
    slipgrid.set_threads(None)
    assert slipgrid.threads() == len(os.sched_getaffinity(0))
    with pytest.raises(ValueError, match="expected 1 to 1024"):
        slipgrid.set_threads(0)


@pytest.mark.alone
def test_the_border_costs_microseconds() -> None:
    """A call's time beside the solve: many single calls against one call for all of them, on one thread."""
    slipgrid.set_threads(1)
    cell = slipgrid.Scene(**SCENE).steady()
    patterns = np.array([[100.0 + step, 200.0, 10.0] for step in range(200)])
    beside = []
    for _ in range(5):
        started = time.perf_counter()
        for width_um, spacing_um, depth_um in patterns:
            cell.ratio(width_um, spacing_um, depth_um)
        single = time.perf_counter() - started
        started = time.perf_counter()
        cell.ratio(*patterns.T)
        beside.append((single - (time.perf_counter() - started)) / len(patterns))
    slipgrid.set_threads(None)
    print(f"{1e6 * statistics.median(beside):.1f} us a call beside the solve")
