"""Campaigns: the same table from one process, several, threads, and a Dask cluster."""

from __future__ import annotations

from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path

import pytest
import slipgrid
from conftest import MATERIAL, SCENE
from slipgrid import campaign
from slipgrid._records import toml
from slipgrid.errors import InputError

CAMPAIGN = """base = "scene.toml"
[[grid]]
key = "pattern.width_um"
values = [40.0, 60.0, 80.0]
[[grid]]
key = "pattern.spacing_um"
values = [100.0, 200.0, 300.0]
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    (tmp_path / "material.toml").write_text(toml(MATERIAL))
    (tmp_path / "scene.toml").write_text(toml({**SCENE, "material": "material.toml"}))
    (tmp_path / "campaign.toml").write_text(CAMPAIGN)
    return tmp_path / "campaign.toml"


@pytest.fixture
def table(program, tmp_path: Path, file: Path) -> str:
    """What the command line finds."""
    program("campaign", "plan", file, "-o", "out")
    program("campaign", "work", "out")
    program("campaign", "merge", "out")
    return (tmp_path / "out" / "table.csv").read_text()


@pytest.mark.parametrize("pool", [ProcessPoolExecutor(2), ThreadPoolExecutor(2)], ids=["processes", "threads"])
def test_any_executor_finds_the_table_of_the_command_line(pool: Executor, file: Path, table: str) -> None:
    tasks = campaign.plan(file)
    assert len(tasks) == 9 and tasks.tasks[0]["values"] == {"pattern.width_um": 40.0, "pattern.spacing_um": 100.0}
    assert tasks.tasks[0].values["pattern.width_um"] == 40.0 and tasks.tasks[0].id == tasks.tasks[0]["id"]
    told: list[float] = []
    with pool:
        found = campaign.run(tasks, pool, progress=lambda stage, share: told.append(share))
    assert found.csv == table and found.counts == "9 tasks: 9 done, 0 refused, 0 failed, 0 missing"
    assert told[-1] == 1.0 and len(found) == 9
    alone = slipgrid.Scene(**{**SCENE, "pattern": {**SCENE["pattern"], "width_um": 40.0, "spacing_um": 100.0}})
    assert found[0].record.results == alone.simulate()["results"]


def test_dask_finds_it_too(file: Path, table: str) -> None:
    distributed = pytest.importorskip("dask.distributed")
    # Three processes, one thread each.
    with (
        distributed.LocalCluster(n_workers=3, threads_per_worker=1, processes=True, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        assert campaign.run(campaign.plan(file), client).csv == table


def test_frames_have_numbers_and_refusals_come_early(file: Path) -> None:
    pytest.importorskip("pandas")
    with ThreadPoolExecutor(1) as pool:
        frame = campaign.run(campaign.plan(file), pool).frame()
    assert len(frame) == 18 and (frame["ratio"] < 1.0).any() and frame["pattern.width_um"].unique().tolist() == [40.0, 60.0, 80.0]
    file.write_text(CAMPAIGN.replace("80.0", "-80.0"))
    with pytest.raises(InputError, match="pattern.width_um"):
        campaign.plan(file)
    file.write_text(CAMPAIGN)
    with pytest.raises(TypeError, match="expected a concurrent.futures.Executor"):
        campaign.run(campaign.plan(file), object())
