"""Campaigns on engines that are really started: HyperQueue with two workers, and Slurm on this machine. The table is that of one
process. Skipped where the engine is not installed; Slurm needs the rights to start its services."""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from conftest import MATERIAL, PROGRAM, SCENE
from slipgrid._records import toml

WORKERS = 4
CAMPAIGN = """base = "scene.toml"
[[grid]]
key = "pattern.width_um"
values = [40.0, 60.0, 80.0, 100.0, 120.0]
[[grid]]
key = "pattern.spacing_um"
values = [100.0, 200.0, 300.0, 400.0]
"""


@pytest.fixture
def table(program, tmp_path: Path) -> str:
    """What one process finds; an empty campaign stands in "shared" for the engine, with its script."""
    (tmp_path / "scene.toml").write_text(toml({**SCENE, "material": MATERIAL}))
    (tmp_path / "campaign.toml").write_text(CAMPAIGN)
    program("campaign", "plan", "campaign.toml", "-o", "alone")
    program("campaign", "work", "alone", "--threads", "1")
    program("campaign", "merge", "alone")
    return (tmp_path / "alone" / "table.csv").read_text()


def merged(program, tmp_path: Path) -> str:
    assert "20 tasks: 20 done, 0 refused, 0 failed, 0 missing" in program("campaign", "merge", "shared")
    return (tmp_path / "shared" / "table.csv").read_text()


def test_hyperqueue_with_two_workers(program, tmp_path: Path, table: str) -> None:
    hyperqueue = pytest.importorskip("hyperqueue")
    from hyperqueue.cluster import WorkerConfig

    program("campaign", "plan", "campaign.toml", "-o", "shared", "--emit", "hyperqueue", "--workers", WORKERS)
    script = tmp_path / "shared" / "hyperqueue.sh"
    with hyperqueue.LocalCluster() as cluster:
        for _ in range(2):
            cluster.start_worker(WorkerConfig(cores=1))
        # What `hq submit` makes of the script's own lines; tasks count from 0 here and from 1 there.
        assert f"#HQ --array=1-{WORKERS}\n" in script.read_text()
        job = hyperqueue.Job(default_workdir=tmp_path)
        job.program(["true"])
        for _ in range(WORKERS):
            job.program(["bash", str(script)], env={"SLIPGRID": str(PROGRAM)})
        client = cluster.client()
        assert client.wait_for_jobs([client.submit(job)])
    assert merged(program, tmp_path) == table


@pytest.fixture
def slurm(tmp_path: Path) -> Iterator[dict[str, str]]:
    """A cluster of this machine, without a service manager: the environment that its commands need."""
    if os.name != "posix" or os.geteuid() != 0 or not all(map(shutil.which, ("slurmctld", "slurmd", "sbatch"))):
        pytest.skip("no Slurm that could be started: slurmctld, slurmd and sbatch, by root")
    folder, host = tmp_path / "slurm", socket.gethostname()
    for name in ("state", "spool"):
        (folder / name).mkdir(parents=True)
    ports = []
    for _ in range(2):
        with socket.socket() as free:
            free.bind(("", 0))
            ports.append(free.getsockname()[1])
    (folder / "slurm.conf").write_text(
        f"""ClusterName=test
SlurmctldHost={host}
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
AuthType=auth/none
CredType=cred/none
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SlurmUser=root
SlurmdUser=root
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ReturnToService=2
SwitchType=switch/none
MpiDefault=none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
NodeName={host} CPUs={os.cpu_count()} State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""
    )
    environment = {**os.environ, "SLURM_CONF": str(folder / "slurm.conf")}
    services = [subprocess.Popen([name, "-D", "-c"], env=environment) for name in ("slurmctld", "slurmd")]
    try:
        for _ in range(100):
            told = subprocess.run(["sinfo", "-h", "-o", "%t"], env=environment, capture_output=True, text=True, check=False)
            if told.stdout.strip() == "idle":
                break
            time.sleep(0.1)
        else:
            pytest.skip(f"Slurm did not come up: {told.stdout} {told.stderr}")
        yield environment
    finally:
        for service in reversed(services):
            service.terminate()
            service.wait()


def test_slurm_on_this_machine(program, slurm: dict[str, str], tmp_path: Path, table: str) -> None:
    flags = ["--emit", "slurm", "--workers", WORKERS, "--at-once", 2]
    program("campaign", "plan", "campaign.toml", "-o", "shared", *flags)
    environment = {**slurm, "SLIPGRID": str(PROGRAM)}
    script = tmp_path / "shared" / "slurm.sh"
    subprocess.run(["sbatch", "--wait", "-o", tmp_path / "%a.out", script], env=environment, check=True, timeout=120)
    for number in range(1, WORKERS + 1):
        assert "5 tasks: 5 done" in (tmp_path / f"{number}.out").read_text()
    assert merged(program, tmp_path) == table
